//! Number fields, and sliders with a number beside them: what may be typed into them, and the reply to any other text.
//!
//! In: a value, its kind and range, typed text. Out: a new value once the text is complete, by Enter, Tab or a click elsewhere; or a reply that says why
//! there is none, which the interface takes by [`take_reply`]. Always: a text that cannot be read, or whose number is outside the range, changes nothing,
//! nor does Escape, which also takes back the steps of the arrow keys; a text stays while it is edited, although the value may change, as the seconds of a
//! running clock do; a step starts from the typed number. egui by itself would read the text after each key, so that the beginning of `33.9 X` counted, would
//! clamp the number to the range, would replace the text by a new value, and would step from the value before the text.

use crate::units::SECONDS_PER_DAY;
use crate::view::app::place_text::{typed_latitude_deg, typed_longitude_deg};
use crate::view::app::view_state::wrapped_longitude_deg;
use crate::view::language::numbers::{field_text, typed_degrees, typed_number, typed_seconds, typed_whole_number};
use crate::view::language::{FluentArgument, text, text_with_arguments};
use crate::wording::echo_within;
use egui::accesskit::Action;
use egui::emath::Numeric;
use egui::{Context, DragValue, Event, Id, Key, Modifiers, Response, Slider, TextEdit, Ui, Widget};
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::rc::Rc;

/// Maximum number of characters of a typed text that a reply quotes.
const MAX_ECHO_CHARS: usize = 30;
/// Maximum number of decimals of a range in a reply.
const MAX_RANGE_DECIMALS: usize = 6;
/// The keys that step the value of a field whose text has the focus.
const STEP_KEYS: [Key; 2] = [Key::ArrowUp, Key::ArrowDown];
/// Names under which egui stores the reply to the last text, the pass in which Escape was last pressed, and what each field remembers.
const REPLY: &str = "reply to a typed number";
const ESCAPE_PASS: &str = "pass of the last Escape";
const EDITED_VALUE: &str = "edited value";

/// What the number of a field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberKind {
    Plain,
    Whole,
    /// A whole number that is shown without separators.
    Year,
    /// A whole number of hours, minutes or seconds that is shown with two digits.
    Clock,
    Degrees,
    /// Degrees north; a compass direction may be typed.
    Latitude,
    /// Degrees east; a compass direction may be typed, and any angle, which is wrapped.
    Longitude,
    /// A length of time in seconds; another unit may be typed.
    Seconds,
}

impl NumberKind {
    /// The number that a text gives; `None` if it gives none of this kind.
    fn read(self, text: &str) -> Option<f64> {
        let number = match self {
            Self::Plain => typed_number(text),
            Self::Whole | Self::Year | Self::Clock => typed_whole_number(text),
            Self::Degrees => typed_degrees(text),
            Self::Latitude => typed_latitude_deg(text),
            Self::Longitude => typed_longitude_deg(text).map(wrapped_longitude_deg),
            Self::Seconds => typed_seconds(text),
        };
        // Adding 0 turns -0 into 0, which is shown without a sign.
        number.map(|number| number + 0.0)
    }

    /// The text of a number, without its unit.
    fn write(self, number: f64, decimals: RangeInclusive<usize>) -> String {
        match self {
            Self::Year => format!("{number:.0}"),
            Self::Clock => format!("{number:02.0}"),
            _ => field_text(number, decimals),
        }
    }

    /// The text of a bound of the range. That of a length of time is in days, because nobody reads so many seconds.
    fn write_bound(self, bound: f64) -> String {
        match self {
            Self::Seconds => format!("{} d", field_text(bound / SECONDS_PER_DAY, 0..=MAX_RANGE_DECIMALS)),
            _ => format!("{}{}", self.write(bound, 0..=MAX_RANGE_DECIMALS), self.unit()),
        }
    }

    fn is_whole(self) -> bool {
        matches!(self, Self::Whole | Self::Year | Self::Clock)
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Plain | Self::Whole | Self::Year | Self::Clock => "",
            Self::Degrees | Self::Latitude | Self::Longitude => "°",
            Self::Seconds => " s",
        }
    }

    /// The id of the message for a text that cannot be read.
    fn refusal(self) -> &'static str {
        match self {
            Self::Plain | Self::Degrees => "number-unreadable",
            Self::Whole | Self::Year | Self::Clock => "number-not-whole",
            Self::Latitude => "number-no-latitude",
            Self::Longitude => "number-no-longitude",
            Self::Seconds => "number-no-seconds",
        }
    }

    /// The reply to a text, empty if the text counts; and the number of a text that counts.
    fn answer(self, text: &str, range: &RangeInclusive<f64>) -> (String, Option<f64>) {
        let typed = echo_within(text.trim(), MAX_ECHO_CHARS);
        let Some(number) = self.read(text) else {
            return (text_with_arguments(self.refusal(), &[("typed", typed.value())]), None);
        };
        // A bound that was an f32 differs by its rounding from the decimals that are typed for it.
        let is_within = |bound: f64, excess: f64| excess <= f64::from(f32::EPSILON) * bound.abs();
        if is_within(*range.start(), range.start() - number) && is_within(*range.end(), number - range.end()) {
            return (String::new(), Some(number));
        }
        let [smallest, largest] = [range.start(), range.end()].map(|bound| self.write_bound(*bound));
        (text!("number-outside", typed = typed, smallest = smallest, largest = largest), None)
    }
}

/// What a field remembers from pass to pass while its text has the focus.
#[derive(Clone)]
struct EditedValue {
    /// The value at the moment when the text got the focus, to which Escape returns.
    entered: f64,
    /// The value that the text belongs to: `entered`, or that which the arrow keys have set since.
    value: f64,
    /// Whether the arrow keys have set the value.
    is_stepped: bool,
    /// Whether the user has typed since the last step. Otherwise the text counts as unchanged.
    is_typed: bool,
    /// The text, if the user has changed it since the last step.
    typed: Option<String>,
    /// The pass in which the text had the focus.
    pass: u64,
}

impl EditedValue {
    /// What a field remembers whose text has the focus for the first time, or has none.
    fn new(value: f64, pass: u64) -> Self {
        Self { entered: value, value, is_stepped: false, is_typed: false, typed: None, pass }
    }

    /// What the field under this id remembers from the pass before. A field that was hidden since then remembers nothing.
    fn load(ui: &Ui, id: Id) -> Option<Self> {
        let last_pass = ui.ctx().cumulative_pass_nr().saturating_sub(1);
        ui.ctx().data(|data| data.get_temp::<Self>(id)).filter(|edited| edited.pass >= last_pass)
    }
}

/// Whether the input of this pass changes a text that has the focus.
fn is_typing(ui: &Ui) -> bool {
    let changes_text = |event: &Event| match event {
        Event::Text(_) | Event::Paste(_) | Event::Cut | Event::Ime(_) => true,
        Event::Key { key, pressed, .. } => *pressed && matches!(key, Key::Backspace | Key::Delete),
        _ => false,
    };
    ui.input(|input| input.raw.events.iter().any(changes_text))
}

/// Whether the input of this pass may change a text that has the focus, also by undoing what was typed.
pub(super) fn may_change_text(ui: &Ui) -> bool {
    let is_undo = |event: &Event| match event {
        Event::Key { key, pressed, modifiers, .. } => *pressed && modifiers.command && matches!(key, Key::Z | Key::Y),
        _ => false,
    };
    is_typing(ui) || ui.input(|input| input.raw.events.iter().any(is_undo))
}

/// Whether an arrow key of this pass steps the value of a field whose text has the focus.
fn is_stepping(ui: &Ui) -> bool {
    let is_step = |event: &Event| match event {
        Event::Key { key, pressed, modifiers, .. } => *pressed && STEP_KEYS.contains(key) && modifiers.matches_logically(Modifiers::NONE),
        _ => false,
    };
    ui.input(|input| input.events.iter().any(is_step))
}

/// Whether assistive technology steps the value of some control in this pass.
fn is_stepped_by_assistive_technology(ui: &Ui) -> bool {
    let is_step = |event: &Event| match event {
        Event::AccessKitActionRequest(request) => matches!(request.action, Action::Increment | Action::Decrement),
        _ => false,
    };
    ui.input(|input| input.events.iter().any(is_step))
}

/// Shows a widget with the value that its text belongs to: while the text has the focus, the value does not change under it. `add`: adds the widget, given its
/// value and its text.
fn with_edited_value<N: Numeric>(
    ui: &mut Ui,
    value: &mut N,
    kind: NumberKind,
    range: &RangeInclusive<N>,
    add: impl FnOnce(&mut Ui, &mut N, &Rc<FieldText>) -> Response,
) -> Response {
    let id = ui.next_auto_id().with(EDITED_VALUE);
    let pass = ui.ctx().cumulative_pass_nr();
    let mut edited = match EditedValue::load(ui, id) {
        Some(edited) => EditedValue { is_typed: edited.is_typed || is_typing(ui), pass, ..edited },
        None => EditedValue::new(value.to_f64(), pass),
    };
    let text = FieldText::new(ui, kind, range, edited.is_typed);
    let is_restored = text.is_cancelled && edited.is_stepped;
    if is_restored {
        edited.value = edited.entered;
    } else if is_stepping(ui) {
        text.step_from_typed(ui, &mut edited);
    }
    let before = N::from_f64(edited.value);
    let mut shown = before;
    let mut response = add(ui, &mut shown, &text);
    let text_counts = text.store_reply(ui);
    // A typed text counts also if its number is the one that the field shows: meanwhile `value` may be another.
    if text_counts || is_restored || shown != before {
        *value = shown;
    }
    // egui compares with the number that the text belongs to, not with the value.
    if is_restored || text_counts {
        response.mark_changed();
    }
    forget_earlier_edits(&response);
    // The focus may also be on the rail of a slider, which has no text.
    if is_edited(&response) && ui.ctx().text_edit_focused() {
        edited.is_stepped |= text_counts || shown != before;
        edited.value = shown.to_f64();
        edited.typed = text.changed.take().or(edited.typed);
        ui.ctx().data_mut(|data| data.insert_temp(id, edited));
    }
    response
}

/// Whether the field has the focus among the controls of the window, also while another window has the keyboard: `Response::has_focus()` is false then, but the
/// text is still being edited.
pub(super) fn is_edited(field: &Response) -> bool {
    field.ctx.memory(|memory| memory.has_focus(field.id))
}

/// When a field gets the focus, lets its text forget what was typed and shown earlier: undo takes back only what the user does from now on.
pub(super) fn forget_earlier_edits(field: &Response) {
    if field.gained_focus()
        && let Some(mut state) = TextEdit::load_state(&field.ctx, field.id)
    {
        state.clear_undoer();
        TextEdit::store_state(&field.ctx, field.id, state);
    }
}

/// The text of one field in one pass.
struct FieldText {
    kind: NumberKind,
    range: RangeInclusive<f64>,
    /// Whether the user has typed.
    is_typed: bool,
    /// Whether the user left the field by Escape.
    is_cancelled: bool,
    /// Whether the text may change in this pass, so that it does not yet count.
    may_change: bool,
    /// The text after its last change in this pass.
    changed: RefCell<Option<String>>,
    /// The text of the value. A field that the user leaves with this text, without typing, keeps its value, which may have more decimals or be outside the
    /// range.
    shown: RefCell<String>,
    /// The reply to a typed text.
    reply: RefCell<Option<String>>,
}

impl FieldText {
    fn new<N: Numeric>(ui: &Ui, kind: NumberKind, range: &RangeInclusive<N>, is_typed: bool) -> Rc<Self> {
        let range = range.start().to_f64()..=range.end().to_f64();
        Rc::new(Self {
            kind,
            range,
            is_typed,
            is_cancelled: is_cancelled(ui),
            may_change: may_change_text(ui),
            changed: RefCell::default(),
            shown: RefCell::default(),
            reply: RefCell::default(),
        })
    }

    /// Lets the arrow keys of this pass step from the number of a changed text. If it gives none, they leave it as it is, and the reply says why.
    fn step_from_typed(&self, ui: &Ui, edited: &mut EditedValue) {
        let Some(typed) = &edited.typed else { return };
        let (reply, number) = self.kind.answer(typed, &self.range);
        *self.reply.borrow_mut() = Some(reply);
        match number {
            Some(number) => (edited.value, edited.is_typed, edited.typed) = (number, false, None),
            None => ui.input_mut(|input| {
                for key in STEP_KEYS {
                    input.consume_key(Modifiers::NONE, key);
                }
            }),
        }
    }

    /// The text of the value, which egui asks for before it reads a typed text.
    fn write(&self, number: f64, decimals: RangeInclusive<usize>) -> String {
        let text = self.kind.write(number, decimals);
        self.shown.borrow_mut().clone_from(&text);
        text
    }

    fn read(&self, text: &str) -> Option<f64> {
        if self.may_change {
            *self.changed.borrow_mut() = Some(text.to_owned());
            return None;
        }
        if self.is_cancelled || !self.is_typed && text == self.shown.borrow().as_str() {
            return None;
        }
        let (reply, number) = self.kind.answer(text, &self.range);
        *self.reply.borrow_mut() = Some(reply);
        number
    }

    /// Leaves the reply to a text, if one was typed, for [`take_reply`]. Returns whether the text counts.
    fn store_reply(&self, ui: &Ui) -> bool {
        let Some(reply) = self.reply.take() else { return false };
        let counts = reply.is_empty();
        ui.ctx().data_mut(|data| data.insert_temp(Id::unique(REPLY), reply));
        counts
    }
}

/// Whether Escape was pressed in this pass.
pub(super) fn is_escape_pressed(ui: &Ui) -> bool {
    // A shortcut may have consumed the key, but not the raw event.
    let is_escape = |event: &Event| matches!(event, Event::Key { key: Key::Escape, pressed: true, .. });
    ui.input(|input| input.raw.events.iter().any(is_escape))
}

/// Whether Escape was pressed in this pass or in the one before. egui takes the focus from a field at once, and lets it read its text in both.
pub(super) fn is_cancelled(ui: &Ui) -> bool {
    let pass = ui.ctx().cumulative_pass_nr();
    if is_escape_pressed(ui) {
        ui.ctx().data_mut(|data| data.insert_temp(Id::unique(ESCAPE_PASS), pass));
    }
    ui.ctx().data(|data| data.get_temp::<u64>(Id::unique(ESCAPE_PASS))).is_some_and(|escape_pass| pass <= escape_pass + 1)
}

/// The reply to the text that was typed into a field in this pass, if any. It is empty if the text counts, and so removes the reply to an earlier attempt.
pub(crate) fn take_reply(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(Id::unique(REPLY)))
}

/// Shows a number field. Without its accessible name a screen reader would read only the unit. `range`: of the value; drags end there. `adapt` sets what is
/// particular to the field, such as its speed.
pub(crate) fn show<N: Numeric>(
    ui: &mut Ui,
    value: &mut N,
    kind: NumberKind,
    range: RangeInclusive<N>,
    name: &str,
    adapt: impl FnOnce(DragValue<'_>) -> DragValue<'_>,
) -> Response {
    let response = with_edited_value(ui, value, kind, &range.clone(), |ui, value, text| {
        let (writer, reader) = (Rc::clone(text), Rc::clone(text));
        let field = adapt(DragValue::new(value));
        let field = if kind.unit().is_empty() { field } else { field.suffix(kind.unit()) };
        // The speed is also the step by arrow keys and assistive technology: egui's own for whole numbers, 0.25, would be rounded away.
        let field = if kind.is_whole() && (is_stepping(ui) || is_stepped_by_assistive_technology(ui)) { field.speed(1.0) } else { field };
        let field = field
            .range(range)
            .update_while_editing(text.may_change)
            .custom_formatter(move |number, decimals| writer.write(number, decimals))
            .custom_parser(move |typed| reader.read(typed));
        ui.add(field)
    });
    response.on_hover_text(name).accessible_name(name)
}

/// A slider with a number beside it, as a widget. `adapt` sets what is particular to the slider, such as its label.
pub(crate) fn slider<N: Numeric>(
    value: &mut N,
    kind: NumberKind,
    range: RangeInclusive<N>,
    adapt: impl FnOnce(Slider<'_>) -> Slider<'_>,
) -> impl Widget {
    move |ui: &mut Ui| {
        with_edited_value(ui, value, kind, &range.clone(), |ui, value, text| {
            let (writer, reader) = (Rc::clone(text), Rc::clone(text));
            let slider = adapt(Slider::new(value, range));
            let slider = if kind.unit().is_empty() { slider } else { slider.suffix(kind.unit()) };
            let slider = slider
                .update_while_editing(text.may_change)
                .custom_formatter(move |number, decimals| writer.write(number, decimals))
                .custom_parser(move |typed| reader.read(typed));
            ui.add(slider)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::language::{Language, set};

    #[test]
    fn each_kind_reads_its_texts_and_says_why_it_reads_no_other() {
        let latitudes = -90.0..=90.0;
        let hundred_days = -100.0 * SECONDS_PER_DAY..=100.0 * SECONDS_PER_DAY;
        for (language, kind, range, text, number, reply) in [
            (Language::English, NumberKind::Latitude, latitudes.clone(), "33.9 S", Some(-33.9), ""),
            (Language::English, NumberKind::Latitude, latitudes.clone(), "33.9° n", Some(33.9), ""),
            (Language::German, NumberKind::Latitude, latitudes.clone(), "33,9 S", Some(-33.9), ""),
            (Language::English, NumberKind::Latitude, latitudes.clone(), "95", None, "“95” is not between -90° and 90°"),
            (Language::German, NumberKind::Latitude, latitudes.clone(), "95", None, "„95“ liegt nicht zwischen -90° und 90°"),
            (Language::English, NumberKind::Latitude, latitudes, "33.9 W", None, "“33.9 W” is not a latitude: write 33.9 S or -33.9"),
            (Language::English, NumberKind::Longitude, -360.0..=360.0, "20 W", Some(-20.0), ""),
            (Language::German, NumberKind::Longitude, -360.0..=360.0, "20 O", Some(20.0), ""),
            (Language::English, NumberKind::Longitude, -360.0..=360.0, "400", Some(40.0), ""),
            (Language::English, NumberKind::Longitude, -360.0..=360.0, "200 W", Some(160.0), ""),
            (Language::English, NumberKind::Degrees, 1.0..=360.0, "60°", Some(60.0), ""),
            (Language::English, NumberKind::Degrees, 1.0..=360.0, "60 x", None, "“60 x” is not a number"),
            (Language::German, NumberKind::Degrees, 1.0..=360.0, "60 x", None, "„60 x“ ist keine Zahl"),
            (Language::English, NumberKind::Seconds, hundred_days.clone(), "1 d", Some(86_400.0), ""),
            (Language::English, NumberKind::Seconds, hundred_days.clone(), "-2h", Some(-7200.0), ""),
            (Language::English, NumberKind::Seconds, hundred_days.clone(), "2 min", Some(120.0), ""),
            (Language::German, NumberKind::Seconds, hundred_days.clone(), "2 Min", Some(120.0), ""),
            (Language::English, NumberKind::Seconds, hundred_days.clone(), "90 S", Some(90.0), ""),
            (Language::English, NumberKind::Seconds, hundred_days, "1e12", None, "“1e12” is not between -100 d and 100 d"),
            (Language::English, NumberKind::Whole, 1.0..=100.0, "12", Some(12.0), ""),
            (Language::English, NumberKind::Whole, 1.0..=100.0, "12.5", None, "“12.5” is not a whole number"),
            (Language::English, NumberKind::Whole, 1.0..=9999.0, "1 000", Some(1000.0), ""),
            (Language::English, NumberKind::Whole, 1.0..=9999.0, "1,000", None, "“1,000” is not a whole number"),
            (Language::German, NumberKind::Whole, 1.0..=9999.0, "1.000", Some(1000.0), ""),
            (Language::German, NumberKind::Whole, 1.0..=9999.0, "1.5", None, "„1.5“ ist keine ganze Zahl"),
            (Language::English, NumberKind::Clock, 0.0..=23.0, "24", None, "“24” is not between 00 and 23"),
            (Language::English, NumberKind::Plain, f64::from(0.6_f32)..=3.0, "0.6", Some(0.6), ""),
            (Language::English, NumberKind::Plain, f64::from(0.6_f32)..=3.0, "0.59", None, "“0.59” is not between 0.6 and 3"),
            (Language::English, NumberKind::Plain, 0.0..=20.0, "-0.001", None, "“-0.001” is not between 0 and 20"),
        ] {
            set(language);
            let answer = kind.answer(text, &range);
            assert_eq!((answer.0.as_str(), answer.1), (reply, number), "{text}");
        }
        set(Language::English);
        for text in ["0 S", "-0"] {
            let (_, number) = NumberKind::Latitude.answer(text, &(-90.0..=90.0));
            assert!(number.is_some_and(|number| number == 0.0 && number.is_sign_positive()), "{text}: {number:?}");
        }
    }
}
