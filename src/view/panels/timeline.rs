//! The timeline below the viewport: dates around the displayed time, and marks of events.
//!
//! In: drags, clicks, the wheel, keys. Out: actions that set the time or show an event; the span, which the settings store. Always: the
//! displayed time is in the middle, and a drag moves the dates with the pointer; a click means what was under the pointer at the press, although
//! a running clock, or a typed date that counts from the press on, moves the dates before the release; events are searched in the background and
//! appear when found, and the parts that are still to be searched are grey; events of moons, of which there are dozens a week, appear only on short
//! spans. Not here: the axis (`app::timeline`).

use super::icons::{self, Icon};
use super::viewport::POINTS_PER_NOTCH;
use super::{Interface, events, theme};
use crate::catalog::Catalog;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use crate::view::app::event_search::{EventKind, EventSearch, SkyEvent};
use crate::view::app::known_events::{KnownEvent, KnownEvents};
use crate::view::app::timeline::{SPANS_WITH_LONGEST_TEXTS_S, TimeAxis, span_text, usable_span_s, zoomed_span_s};
use crate::view::app::viewer::Action;
use crate::view::language::dates::minute_text;
use crate::view::language::text;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use egui::{Align2, Color32, EventFilter, Key, Rect, Response, Sense, Stroke, TextStyle, Ui, pos2, vec2};
use std::sync::Arc;

/// Height of the timeline, points.
const HEIGHT: f32 = 34.0;
/// Height of the lower part with the dates, points.
const DATES_HEIGHT: f32 = 15.0;
/// Largest horizontal distance from an event's mark at which a click selects it, points.
const CLICK_DISTANCE: f64 = 5.0;
/// Radius of the mark of a notable event, and of any other event, points.
const MARK_RADII: [f32; 2] = [4.0, 2.5];
/// Longest span on which events that are not notable are shown, seconds.
const MAX_SPAN_ALL_EVENTS_S: f64 = 40.0 * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
/// Longest span on which events of moons are shown, seconds.
const MAX_SPAN_MOONS_S: f64 = 10.0 * SECONDS_PER_DAY;
/// Fraction of the span by which an arrow key changes the time.
const KEY_STEP_FRACTION: f64 = 0.02;
/// Number of wheel notches to which a pinch by a factor of e is equivalent: so many notches change the span by about a factor of e.
const NOTCHES_PER_E_FOLD: f64 = 4.0;

/// Opacity of the grey fill over the parts of the timeline that are still to be searched.
const UNSEARCHED_OPACITY: f32 = 0.6;

/// Change of the span by one press of its buttons, in wheel notches.
const BUTTON_NOTCHES: f64 = 2.0;

/// Kinds of events that are searched for on any span.
const RARE_KINDS: &[EventKind] = &[EventKind::Solar, EventKind::Lunar, EventKind::Transit];
/// Kinds of events that are searched for only on short spans.
const FREQUENT_KINDS: &[EventKind] = &[EventKind::Moons];

/// A search after a step, and the events found in it.
type SearchedStep = (EventSearch, Vec<KnownEvent>);

/// The known events of some kinds, and the running search for more of them.
struct EventTrack {
    known: KnownEvents,
    /// The search whose step is running, as it was before the step, and the pending result.
    running: Option<(EventSearch, Pending<SearchedStep>)>,
}

/// State of the timeline.
pub(crate) struct Timeline {
    /// The events of [`RARE_KINDS`].
    rare: EventTrack,
    /// The events of [`FREQUENT_KINDS`].
    frequent: EventTrack,
    /// The axis at the time of the press, while the pointer's button is down on the timeline.
    pressed_axis: Option<TimeAxis>,
}

impl Default for Timeline {
    fn default() -> Self {
        let track = |kinds, step_days| EventTrack { known: KnownEvents::new(kinds, step_days), running: None };
        // A step of a search covers 500 or 3 days, in which it finds about ten events.
        Self { rare: track(RARE_KINDS, 500.0), frequent: track(FREQUENT_KINDS, 3.0), pressed_axis: None }
    }
}

impl Timeline {
    /// Formats the titles of the known events again, in the current language. Running searches, whose titles are in the previous language, start again.
    pub(crate) fn rewrite_texts(&mut self, catalog: &Catalog) {
        for track in [&mut self.rare, &mut self.frequent] {
            track.running = None;
            track.known.rewrite_titles(|event| event.title(catalog));
        }
    }

    /// Whether a time (TDB seconds past J2000) is in a part of the axis whose eclipses and transits are still to be searched.
    fn is_unsearched(&self, axis: &TimeAxis, tdb_s: f64) -> bool {
        let parts = self.rare.known.unsearched(axis.start_tdb_s(), axis.end_tdb_s());
        parts.into_iter().flatten().any(|(from_tdb_s, to_tdb_s)| (from_tdb_s..to_tdb_s).contains(&tdb_s))
    }
}

impl EventTrack {
    /// Takes the result of the running step, if it has arrived, and starts the next one.
    fn update(&mut self, axis: &TimeAxis, worker: &dyn RenderWorker) {
        if let Some((search, pending)) = self.running.take() {
            match pending.take() {
                Some((advanced, found)) => self.known.add_result(&search, advanced, found),
                None => {
                    self.running = Some((search, pending));
                    return;
                }
            }
        }
        let Some(next) = self.known.next_search(axis.start_tdb_s(), axis.end_tdb_s()) else { return };
        let mut search = next.clone();
        let query = move |session: &crate::session::Session| {
            let catalog = session.catalog();
            let known_event = |event: SkyEvent| KnownEvent {
                tdb_s: event.greatest().tdb_seconds_past_j2000(),
                title: event.title(catalog),
                event: Arc::new(event),
            };
            let found = search.step(catalog, session.ephemeris());
            (search, found.into_iter().map(known_event).collect())
        };
        self.running = Some((next, ask(worker, query)));
    }
}

/// Shows the timeline, with the buttons that shorten and lengthen its span.
pub(crate) fn show(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let span_s = usable_span_s(interface.settings.panels.timeline_span_s);
    // The zoom in wheel notches; positive notches shorten the span.
    let mut notches = 0.0;
    if icons::icon_button(ui, Icon::Minus, text!("timeline-longer")).on_hover_text(text!("timeline-longer-hint")).clicked() {
        notches = -BUTTON_NOTCHES;
    }
    if icons::icon_button(ui, Icon::Plus, text!("timeline-shorter")).on_hover_text(text!("timeline-shorter-hint")).clicked() {
        notches = BUTTON_NOTCHES;
    }
    // The label is as wide as the longest text, so that the timeline stays in place. One point is added, because positions are rounded to pixels.
    let label_width = SPANS_WITH_LONGEST_TEXTS_S.into_iter().map(|span_s| theme::text_width(ui, span_text(span_s))).fold(0.0, f32::max);
    let size = [label_width.ceil() + 1.0, ui.spacing().interact_size.y];
    ui.add_sized(size, egui::Label::new(span_text(span_s)).truncate());
    let width = ui.available_width().max(60.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::click_and_drag());
    let axis = TimeAxis { middle_tdb_s: interface.viewer.view.tdb_s, span_s, width_points: f64::from(rect.width()) };
    // Events are searched for only after the first image of the viewport. During a press that may become a click they stay, although a typed date, which counts at
    // the press, may have moved the axis: the click is for the event that was shown there.
    let may_become_click = interface.timeline.pressed_axis.is_some() && !response.dragged();
    if interface.shown().is_some() && !may_become_click {
        interface.timeline.rare.update(&axis, worker);
        if span_s <= MAX_SPAN_MOONS_S {
            interface.timeline.frequent.update(&axis, worker);
        }
    }
    notches += wheel_notches(ui, &response) + handle_keys(ui, &response, &axis, actions);
    paint(interface, ui, rect, &axis, response.has_focus());
    announce(interface, &response);
    let response = with_tooltip(interface, response, rect, &axis);
    drag(ui, &response, &axis, actions);
    let pressed_axis = interface.timeline.pressed_axis.take().unwrap_or(axis);
    interface.timeline.pressed_axis = response.is_pointer_button_down_on().then_some(pressed_axis);
    click(interface, &response, rect, &pressed_axis, worker, actions);
    interface.settings.panels.timeline_span_s = zoomed_span_s(span_s, notches);
}

/// The displayed events, with their positions on the timeline in points.
fn marks<'t>(interface: &'t Interface, axis: &TimeAxis) -> impl Iterator<Item = (f64, &'t KnownEvent)> {
    let Timeline { rare, frequent, pressed_axis: _ } = &interface.timeline;
    let (from_tdb_s, to_tdb_s, span_s) = (axis.start_tdb_s(), axis.end_tdb_s(), axis.span_s);
    let axis = *axis;
    let frequent = if span_s <= MAX_SPAN_MOONS_S { frequent.known.between(from_tdb_s, to_tdb_s) } else { &[] };
    let rare = rare.known.between(from_tdb_s, to_tdb_s).iter().filter(move |e| span_s <= MAX_SPAN_ALL_EVENTS_S || e.event.is_notable());
    frequent.iter().chain(rare).map(move |e| (axis.position_points(e.tdb_s), e))
}

/// The event whose mark is nearest to a position on the timeline, if it is within [`CLICK_DISTANCE`].
fn event_at<'t>(interface: &'t Interface, axis: &TimeAxis, x_points: f64) -> Option<&'t KnownEvent> {
    let distance = |position: f64| (position - x_points).abs();
    let close = marks(interface, axis).filter(|(position, _)| distance(*position) <= CLICK_DISTANCE);
    close.min_by(|(a, _), (b, _)| distance(*a).total_cmp(&distance(*b))).map(|(_, known)| known)
}

/// The colour of the marks of a kind of event.
fn mark_colour(ui: &Ui, kind: EventKind) -> Color32 {
    let is_dark = ui.visuals().dark_mode;
    let [r, g, b] = match (kind, is_dark) {
        (EventKind::Solar, true) => [255, 190, 60],
        (EventKind::Solar, false) => [170, 95, 0],
        (EventKind::Lunar, true) => [240, 120, 100],
        (EventKind::Lunar, false) => [175, 40, 25],
        (EventKind::Transit, true) => [120, 190, 255],
        (EventKind::Transit, false) => [0, 95, 175],
        (EventKind::Moons, true) => [120, 215, 140],
        (EventKind::Moons, false) => [10, 115, 45],
    };
    Color32::from_rgb(r, g, b)
}

/// Paints the ticks with their dates, the parts still to be searched, the marks of events, and the line at the displayed time.
fn paint(interface: &Interface, ui: &Ui, rect: Rect, axis: &TimeAxis, is_focused: bool) {
    if !ui.is_rect_visible(rect) {
        return;
    }
    let visuals = ui.visuals();
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let outline = if is_focused { visuals.selection.stroke } else { visuals.widgets.noninteractive.bg_stroke };
    painter.rect(rect, 3.0, visuals.extreme_bg_color, outline, egui::StrokeKind::Inside);
    let screen_x = |x_points: f64| rect.left() + x_points as f32;
    let dates_top = rect.bottom() - DATES_HEIGHT;
    let font = TextStyle::Small.resolve(ui.style());
    for tick in axis.ticks(interface.settings.time_zone) {
        let tick_x = screen_x(axis.position_points(tick.tdb_s));
        painter.vline(tick_x, rect.y_range(), Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color));
        painter.text(pos2(tick_x + 3.0, rect.bottom() - 2.0), Align2::LEFT_BOTTOM, tick.label, font.clone(), visuals.text_color());
    }
    // The parts that are still to be searched are grey, because marks are missing there.
    for (from_tdb_s, to_tdb_s) in interface.timeline.rare.known.unsearched(axis.start_tdb_s(), axis.end_tdb_s()).into_iter().flatten() {
        let part = egui::Rangef::new(screen_x(axis.position_points(from_tdb_s)), screen_x(axis.position_points(to_tdb_s)));
        let fill = visuals.widgets.noninteractive.bg_stroke.color.gamma_multiply(UNSEARCHED_OPACITY);
        painter.rect_filled(Rect::from_x_y_ranges(part, rect.top()..=dates_top), 0.0, fill);
    }
    let middle_y = 0.5 * (rect.top() + dates_top);
    for (position, known) in marks(interface, axis) {
        let radius = MARK_RADII[usize::from(!known.event.is_notable())];
        painter.circle_filled(pos2(screen_x(position), middle_y), radius, mark_colour(ui, known.event.kind()));
    }
    // The line at the displayed time.
    let stroke = Stroke::new(1.5, visuals.strong_text_color());
    painter.vline(rect.center().x, rect.top()..=dates_top, stroke);
}

/// Describes the timeline to screen readers as a slider of time.
fn announce(interface: &Interface, response: &Response) {
    // The value is rounded to minutes, because a screen reader announces each change.
    let time = interface.viewer.view.time();
    let minutes = (time.tdb_seconds_past_j2000() / 60.0).round();
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(minute_text(time, interface.settings.time_zone)),
        ..egui::WidgetInfo::slider(true, minutes * 60.0 / SECONDS_PER_DAY, text!("timeline"))
    });
}

/// Shows a tooltip with the event or date under the pointer; returns the response.
fn with_tooltip(interface: &Interface, response: Response, rect: Rect, axis: &TimeAxis) -> Response {
    let Some(pointer) = response.hover_pos() else {
        return response.on_hover_text(text!("timeline-drag-hint"));
    };
    let (x_points, zone) = (f64::from(pointer.x - rect.left()), interface.settings.time_zone);
    let tooltip = match event_at(interface, axis, x_points) {
        Some(known) => format!("{}\n{}", known.title, known.event.summary(zone)),
        None => {
            let tdb_s = axis.tdb_s_at(x_points);
            let date = minute_text(Instant::from_tdb_seconds_past_j2000(tdb_s), zone);
            if interface.timeline.is_unsearched(axis, tdb_s) { format!("{date}\n{}", text!("timeline-searching")) } else { date }
        }
    };
    response.on_hover_text_at_pointer(tooltip)
}

/// Handles drags, which move the displayed time.
fn drag(ui: &Ui, response: &Response, axis: &TimeAxis, actions: &mut Vec<Action>) {
    let dragged_points = f64::from(response.drag_delta().x);
    if response.dragged() && dragged_points != 0.0 {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
        actions.push(Action::Step(-axis.duration_s(dragged_points)));
    }
}

/// Handles clicks, which show an event or set the time. `axis`: the one that was shown at the press.
fn click(
    interface: &mut Interface,
    response: &Response,
    rect: Rect,
    axis: &TimeAxis,
    worker: &dyn RenderWorker,
    actions: &mut Vec<Action>,
) {
    let Some(pointer) = response.interact_pointer_pos().filter(|_| response.clicked()) else { return };
    let x_points = f64::from(pointer.x - rect.left());
    match event_at(interface, axis, x_points).map(|known| Arc::clone(&known.event)) {
        Some(event) => events::show(interface, worker, event, actions),
        None => actions.push(Action::SetTime(Instant::from_tdb_seconds_past_j2000(axis.tdb_s_at(x_points)))),
    }
}

/// The zoom by the wheel or a pinch over the timeline, in wheel notches; 0 if the pointer is elsewhere.
fn wheel_notches(ui: &Ui, response: &Response) -> f64 {
    if !response.hovered() {
        return 0.0;
    }
    let (wheel, pinch) = ui.input(|i| {
        let (scroll, zoom) = (f64::from(i.smooth_scroll_delta().y), f64::from(i.zoom_delta()));
        (scroll / POINTS_PER_NOTCH, zoom.ln() * NOTCHES_PER_E_FOLD)
    });
    if pinch == 0.0 { wheel } else { pinch }
}

/// Handles arrow keys, and increments and decrements from assistive technology, while the timeline has the focus. Left, right, increments and decrements step
/// the time. Returns the zoom by up and down, in wheel notches.
fn handle_keys(ui: &Ui, response: &Response, axis: &TimeAxis, actions: &mut Vec<Action>) -> f64 {
    if !response.has_focus() {
        return 0.0;
    }
    let arrows = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|m| m.set_focus_lock_filter(response.id, arrows));
    let pressed = |key| ui.input(|i| i.num_presses(key)) as f64;
    let requested = |action| ui.input(|i| i.num_accesskit_action_requests(response.id, action)) as f64;
    let steps = pressed(Key::ArrowRight) - pressed(Key::ArrowLeft) + requested(egui::accesskit::Action::Increment)
        - requested(egui::accesskit::Action::Decrement);
    if steps != 0.0 {
        actions.push(Action::Step(steps * KEY_STEP_FRACTION * axis.span_s));
    }
    pressed(Key::ArrowUp) - pressed(Key::ArrowDown)
}
