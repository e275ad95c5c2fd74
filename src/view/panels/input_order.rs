//! The order of keyboard input in slow frames.
//!
//! In: the input events of a frame. Out: as many of these events as one pass of the interface can handle; the rest follows in later passes.
//! Always: no event is lost, and the order of events is kept; a press that is not moved is a click, however slow the frames until the release are.
//!
//! egui moves the keyboard focus once per pass, and on Escape removes it before any field has read its text. If a frame takes a second, the
//! keys `/`, the letters of a word, Enter and Escape can arrive in the same frame. If one pass handled them all, the letters would act as
//! shortcuts. A press of the pointer elsewhere ends a text field (`theme::apply` tells egui so), which then reads its text. The release that follows is a
//! click, by which a button may hide the field, so that the release needs a later pass than the press. What acts elsewhere without a press, such as a
//! shortcut, needs a later pass too.
//!
//! egui takes a press for a drag once 0.8 seconds have passed in its time, that of the frames. On a busy machine one frame may take so long, and the click
//! would be lost. Only a touch keeps this limit: a touch that is held opens the context menu.

use egui::accesskit::Action;
use egui::{Context, Event, Id, InputOptions, Key, Plugin, RawInput, Ui};

/// Delays events whose effect depends on where an earlier event moves the keyboard focus.
#[derive(Default)]
pub(crate) struct InputOrder {
    /// The events that later passes will handle, in order.
    waiting: Vec<Event>,
}

/// Whether an event goes to the control with the keyboard focus: text, a pressed key, or a clipboard event. Key releases have no effect.
fn is_typed(event: &Event) -> bool {
    matches!(event, Event::Text(_) | Event::Key { pressed: true, .. } | Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_))
}

/// Whether an event can take the focus from a text field. egui then moves the focus before the field reads the text typed in the same pass.
fn can_end_field(event: &Event) -> bool {
    match event {
        Event::Key { key, pressed, .. } => *pressed && matches!(key, Key::Escape | Key::Tab | Key::Enter),
        Event::PointerButton { .. } | Event::Touch { .. } | Event::AccessKitActionRequest(_) => true,
        _ => false,
    }
}

/// Whether an event can move the focus for the next pass; `/` moves it to the search field.
fn can_move_focus(event: &Event) -> bool {
    can_end_field(event) || matches!(event, Event::Text(text) if text == "/")
}

/// Whether an event acts elsewhere than in a text field with the focus, but takes the focus from no field: a screen reader's click, or Ctrl+S, which saves an
/// image of the size in the fields.
fn acts_elsewhere(event: &Event, field: Id) -> bool {
    match event {
        Event::AccessKitActionRequest(request) => request.action == Action::Click && request.target_node != field.accesskit_id(),
        Event::Key { key: Key::S, pressed, modifiers, .. } => *pressed && modifiers.command,
        _ => false,
    }
}

/// Whether an event is a press of a key that steps the number in a field. egui steps before the field reads what was typed in the same pass.
fn is_step(event: &Event) -> bool {
    matches!(event, Event::Key { key: Key::ArrowUp | Key::ArrowDown, pressed: true, .. })
}

/// Number of events that one pass can handle. The pass ends before a typed event that follows a possible move of the focus. It also ends before an event
/// that can end a text field, if an event of this pass was typed. `edited_field`: the text field with the focus, if any; then the pass also ends after a press
/// of a pointer's button, before an event that acts elsewhere, and between steps of a number and other typed events.
fn events_in_pass(events: &[Event], edited_field: Option<Id>) -> usize {
    let (mut has_typed, mut may_have_moved_focus, mut has_stepped) = (false, false, false);
    for (index, event) in events.iter().enumerate() {
        if (may_have_moved_focus && is_typed(event)) || (has_typed && can_end_field(event)) {
            return index;
        }
        if edited_field.is_some_and(|field| acts_elsewhere(event, field)) {
            return index;
        }
        if edited_field.is_some() && matches!(event, Event::PointerButton { pressed: true, .. }) {
            return index + 1;
        }
        if edited_field.is_some() && is_typed(event) && has_typed && is_step(event) != has_stepped {
            return index;
        }
        has_stepped |= is_step(event);
        has_typed |= is_typed(event);
        may_have_moved_focus |= can_move_focus(event);
    }
    events.len()
}

impl Plugin for InputOrder {
    fn debug_name(&self) -> &'static str {
        "order of input"
    }

    /// Passes on as many of the waiting and the new events as one pass can handle; none if a text field must read its text before the first of them.
    fn input_hook(&mut self, ctx: &Context, input: &mut RawInput) {
        self.waiting.append(&mut input.events);
        let is_touched = ctx.input(|input| input.any_touches()) || self.waiting.iter().any(|event| matches!(event, Event::Touch { .. }));
        let max_click_duration = if is_touched { InputOptions::default().max_click_duration } else { f64::INFINITY };
        ctx.options_mut(|options| options.input_options.max_click_duration = max_click_duration);
        let edited_field = ctx.memory(|memory| memory.focused()).filter(|_| ctx.text_edit_focused());
        let count = events_in_pass(&self.waiting, edited_field);
        if let Some(field) = edited_field
            && count == 0
            && !self.waiting.is_empty()
        {
            // In this pass the field reads its text.
            ctx.memory_mut(|memory| memory.surrender_focus(field));
        }
        let later_events = self.waiting.split_off(count);
        input.events = std::mem::replace(&mut self.waiting, later_events);
    }

    /// Requests another pass if events are waiting.
    fn on_end_pass(&mut self, ui: &mut Ui) {
        if !self.waiting.is_empty() {
            ui.ctx().request_repaint();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Modifiers;

    fn key(key: Key) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }
    }

    /// The events that each pass handles, if all events arrive in the first frame.
    fn passes(events: &[Event]) -> Vec<Vec<Event>> {
        let mut order = InputOrder::default();
        let mut input = RawInput { events: events.to_vec(), ..RawInput::default() };
        let mut passes = Vec::new();
        loop {
            order.input_hook(&Context::default(), &mut input);
            if input.events.is_empty() {
                return passes;
            }
            passes.push(input.take().events);
        }
    }

    #[test]
    fn a_search_that_arrives_in_one_frame_is_handled_in_order() {
        let text = |t: &str| Event::Text(t.into());
        let events = [key(Key::Slash), text("/"), text("s"), key(Key::E), text("e"), key(Key::Enter), key(Key::Escape), text("5")];
        let taken = passes(&events);
        assert_eq!(taken.concat(), events, "an event is lost or overtakes another");
        // All letters of a word share one pass: a pass for each letter would be slow where passes are slow.
        assert_eq!(taken.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3, 1, 1, 1], "{taken:?}");
    }

    #[test]
    fn a_drag_and_a_zoom_share_one_pass() {
        let position = egui::pos2(1.0, 2.0);
        let button =
            |pressed| Event::PointerButton { pos: position, button: egui::PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
        let events = [Event::PointerMoved(position), button(true), Event::PointerMoved(position), button(false), Event::Zoom(1.0)];
        assert_eq!(passes(&events), [events.to_vec()]);
        // While a text is edited, it is read between the press and the release.
        assert_eq!([None, Some(Id::unique("field"))].map(|field| events_in_pass(&events, field)), [5, 2]);
    }

    /// A touch that is held opens the context menu; the press of a button that is held stays a click.
    #[test]
    fn only_a_touch_can_be_too_long_for_a_click() {
        let pos = egui::pos2(1.0, 2.0);
        let (device_id, id, phase, force) = (egui::TouchDeviceId(0), egui::TouchId(0), egui::TouchPhase::Start, None);
        let press = Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed: true, modifiers: Modifiers::NONE };
        for (event, is_limited) in [(Event::Touch { device_id, id, phase, pos, force }, true), (press, false)] {
            let ctx = Context::default();
            InputOrder::default().input_hook(&ctx, &mut RawInput { events: vec![event], ..RawInput::default() });
            assert_eq!(ctx.options(|options| options.input_options.max_click_duration.is_finite()), is_limited);
        }
    }

    /// An arrow key steps from the number that was typed before it.
    #[test]
    fn a_step_of_a_number_and_typed_text_are_in_separate_passes() {
        let text = Event::Text("4".into());
        let events = [text.clone(), text.clone(), key(Key::ArrowUp), key(Key::ArrowDown), text];
        let edited = Some(Id::unique("field"));
        assert_eq!([edited, None].map(|field| events_in_pass(&events, field)), [2, events.len()]);
        assert_eq!(events_in_pass(&events[2..], edited), 2);
    }

    /// The image that Ctrl+S saves has the size that was typed. Only Ctrl+S needs a pass of its own, and only while a text is edited; letters and Ctrl+A do
    /// not.
    #[test]
    fn an_edited_text_is_read_before_a_shortcut_acts_elsewhere() {
        let key_with = |key, modifiers| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        let edited_field = Some(Id::unique("field"));
        let text = Event::Text("4".into());
        for (key, modifiers, count) in [(Key::S, Modifiers::COMMAND, 1), (Key::S, Modifiers::NONE, 2), (Key::A, Modifiers::COMMAND, 2)] {
            let events = [text.clone(), key_with(key, modifiers)];
            assert_eq!([edited_field, None].map(|field| events_in_pass(&events, field)), [count, 2], "{key:?}");
            assert_eq!(events_in_pass(&events[1..], edited_field), count - 1, "{key:?}");
        }
    }
}
