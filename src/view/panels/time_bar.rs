//! The bar below the viewport. First row: date field and calendar, rate of time, time steps. Second row: buttons that find the previous and the next
//! event of a kind, and the timeline.
//!
//! In: the displayed time, typed dates, clicks. Out: actions that set the time or its rate, or show an event.

use super::icons::{self, Icon};
use super::number_field::{self, NumberKind};
use super::top_bar::caption;
use super::{Interface, MAX_ECHO_CHARS, accessible, events, theme, timeline};
use crate::ephemeris::EphemerisError;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::date_text::parse_date;
use crate::view::app::event_search::{EventKind, EventSearch, SkyEvent};
use crate::view::app::time_rate::{MAX_SPEED, MIN_SPEED, rate_text};
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::dates::{date_in_digits, instant_text, long_date, month_name};
use crate::view::language::{text, text_by_id};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use crate::wording::echo_within;
use chrono::{Datelike, Days, Months, NaiveDate, NaiveDateTime, NaiveTime, Timelike};
use egui::accesskit::Action as ReaderAction;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, ComboBox, Event, Grid, Key, PopupCloseBehavior, Sense, Slider, TextEdit, Vec2};
use std::sync::Arc;

/// The first event that a search finds, pending. An error is formatted later, because the language may change before it arrives.
type PendingEvent = Pending<Result<Option<SkyEvent>, EphemerisError>>;

/// The text of the date field while it has the focus. A running clock leaves it as it is.
struct EditedDate {
    text: String,
    /// The text that the field showed when it got the focus.
    shown_before: String,
    /// Whether the user has changed the text, and perhaps changed it back.
    is_typed: bool,
}

/// State of the bar.
pub(crate) struct TimeBar {
    /// The text of the date field; `None` while the field has no focus, and shows the view's time.
    edited: Option<EditedDate>,
    /// First day of the month that the calendar displays; `None`: the month of the view's time.
    month: Option<NaiveDate>,
    /// First day of the month whose days are laid out. While a press may become a click, `month` may be ahead of it.
    laid_out_month: Option<NaiveDate>,
    /// The kind of event that the buttons search for.
    kind: EventKind,
    /// The kind of event that the running search looks for, and the pending result. The user may choose another kind for the buttons meanwhile.
    pending: Option<(EventKind, PendingEvent)>,
    /// Whether a key requested the previous event.
    pub wants_previous_event: bool,
    /// Whether a key requested the next event.
    pub wants_next_event: bool,
}

impl Default for TimeBar {
    fn default() -> Self {
        Self {
            edited: None,
            month: None,
            laid_out_month: None,
            kind: EventKind::Solar,
            pending: None,
            wants_previous_event: false,
            wants_next_event: false,
        }
    }
}

impl TimeBar {
    /// Drops a running search: the user has chosen another view meanwhile, which the event would replace.
    pub(super) fn forget_search(&mut self) {
        self.pending = None;
    }

    /// The direction of the search that a key requested: whether it runs backward.
    fn take_request_by_key(&mut self) -> Option<bool> {
        let wants_previous = std::mem::take(&mut self.wants_previous_event);
        if std::mem::take(&mut self.wants_next_event) { Some(false) } else { wants_previous.then_some(true) }
    }

    /// The event that the search has found, or why there is none; `None` while the search runs, or if none was started.
    fn take_found(&mut self) -> Option<Result<SkyEvent, String>> {
        let (kind, pending) = self.pending.as_ref()?;
        let (kind, found) = (*kind, pending.take()?);
        self.pending = None;
        let found = found.map_err(|e| error_text(&e));
        Some(found.and_then(|event| event.ok_or_else(|| text!("event-none-near", kind = kind.name(), years = EVENT_SEARCH_YEARS))))
    }
}

/// Time steps of the buttons: length in seconds, and the message id of the step's name. Each has a button for a step forward and one for a step back.
const STEPS: [(f64, &str); 4] =
    [(60.0, "step-minute"), (3600.0, "step-hour"), (SECONDS_PER_DAY, "step-day"), (DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY, "step-year")];
/// Length of time that is searched for the next or previous event, Julian years. The longest gap between events of one kind is 13 years, between the transits
/// of Mercury of 2019 and 2032. Ten times this gap is a choice: it also exceeds the 121.5 years between the transits of Venus of 1882 and 2004.
const EVENT_SEARCH_YEARS: u32 = 130;
/// Time between the displayed time and the start of the search for another event, seconds, so that the search does not find the displayed event.
const EVENT_GAP_S: f64 = 60.0;

/// Last year with days that history books give in the Julian calendar.
const LAST_YEAR_OF_JULIAN_DATES: i32 = 1582;
/// Width that the date field needs in addition to its text, points: its margins and the cursor.
const DATE_FIELD_MARGIN: f32 = 16.0;
/// A digit that is at least as wide as any other in the font of the interface.
const WIDEST_DIGIT: &str = "0";

/// The rates with the longest texts: -59.9 minutes and -11.9 months per second, in seconds of displayed time per real second.
const RATES_WITH_LONGEST_TEXTS: [f64; 2] = [-59.9 * 60.0, -11.9 * DAYS_PER_JULIAN_YEAR / 12.0 * SECONDS_PER_DAY];

pub(crate) fn bar(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        date_field(interface, ui, actions);
        calendar_button(interface, ui, actions);
        let now = icons::button(ui, Icon::Now, text!("time-now"));
        if ui.add(now).on_hover_text(text!("time-now-hint")).clicked() {
            actions.push(Action::Now);
        }
        ui.separator();
        rate_controls(interface, ui, actions);
        ui.separator();
        caption(ui, text!("time-step"));
        let back = STEPS.iter().rev().map(|(seconds, name)| (-seconds, format!("-{}", text_by_id(name))));
        let forward = STEPS.iter().map(|(seconds, name)| (*seconds, format!("+{}", text_by_id(name))));
        for (seconds, name) in back.chain(forward) {
            if ui.small_button(&name).on_hover_text(text!("time-step-hint", name = name)).clicked() {
                actions.push(Action::Step(seconds));
            }
        }
        let is_shown = &mut interface.settings.panels.timeline_shown;
        ui.toggle_value(is_shown, text!("timeline")).on_hover_text(text!("timeline-hint"));
    });
    ui.horizontal(|ui| {
        event_buttons(interface, ui, worker, actions);
        if interface.settings.panels.timeline_shown {
            timeline::show(interface, ui, worker, actions);
        }
    });
}

/// Shows the date field, and the button that switches between UTC and local time.
fn date_field(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let time = interface.viewer.view.time();
    let time_zone = interface.settings.time_zone;
    let displayed_text = time_zone.civil_time(time).map_or_else(|| instant_text(time), civil_text);
    let mut text = interface.time_bar.edited.as_ref().map_or_else(|| displayed_text.clone(), |edited| edited.text.clone());
    let width = date_field_width(ui, &displayed_text);
    let response = ui.add(TextEdit::singleline(&mut text).desired_width(width));
    let response = response.on_hover_text(text!("time-field-hint")).accessible_name(text!("time-field"));
    number_field::forget_earlier_edits(&response);
    if number_field::is_edited(&response) {
        let entered = || EditedDate { text: displayed_text.clone(), shown_before: displayed_text, is_typed: false };
        let edited = interface.time_bar.edited.get_or_insert_with(entered);
        edited.is_typed |= edited.text != text;
        edited.text = text;
    } else if let Some(edited) = interface.time_bar.edited.take()
        && response.lost_focus()
    {
        let is_confirmed = ui.input(|input| input.key_pressed(Key::Enter));
        // A text that the user has changed back counts only by Enter: otherwise a running clock would be set back by the length of the edit.
        let counts = edited.is_typed && !number_field::is_cancelled(ui) && (is_confirmed || edited.text != edited.shown_before);
        if counts {
            match parse_date(&edited.text, time_zone, interface.viewer.now()) {
                Some(time) => actions.push(Action::SetTime(time)),
                None => interface.refuse_view(text!("time-no-date", typed = echo_within(edited.text.trim(), MAX_ECHO_CHARS))),
            }
        }
    }
    let other_zone = if time_zone == ShownTimeZone::Utc { ShownTimeZone::Local } else { ShownTimeZone::Utc };
    let label = time_zone.label(time);
    let hover = text!("time-zone-hint");
    // Without the minutes of whole hours the row fits into a window 1264 points wide, a usual one on a screen of 1280.
    let short_label = label.strip_suffix(":00").unwrap_or(&label);
    if ui.button(short_label).on_hover_text(hover).accessible_name(text!("time-zone", name = label)).clicked() {
        interface.settings.time_zone = other_zone;
    }
}

/// Width of the date field for a displayed date, points. The field has room for the same date with the widest digits, so that its width stays constant
/// while time runs.
fn date_field_width(ui: &egui::Ui, displayed_text: &str) -> f32 {
    theme::text_width(ui, displayed_text.replace(|c: char| c.is_ascii_digit(), WIDEST_DIGIT)).ceil() + DATE_FIELD_MARGIN
}

/// Date and time of day in digits, in the form that the date field shows.
fn civil_text(civil: NaiveDateTime) -> String {
    let date = date_in_digits(&civil.format("%Y-%m-%d").to_string());
    text!("date-field", date = date, clock = civil.format("%H:%M:%S").to_string())
}

/// Shows the button that opens the calendar, and applies the time chosen in it.
fn calendar_button(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let time_zone = interface.settings.time_zone;
    let displayed = interface.viewer.view.time();
    let Some(civil) = time_zone.civil_time(displayed) else { return };
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside).style(theme::menu_style);
    let button = icons::button(ui, Icon::Calendar, text!("calendar"));
    let (button, content) = MenuButton::from_button(button).config(config).ui(ui, |ui| calendar(&mut interface.time_bar, ui, civil));
    button.on_hover_text(text!("calendar-hint"));
    let Some(content) = content else {
        (interface.time_bar.month, interface.time_bar.laid_out_month) = (None, None);
        return;
    };
    if let Some(time) = content.inner.and_then(|civil| time_zone.instant_near(civil, displayed)) {
        actions.push(Action::SetTime(time));
    }
}

/// Shows the days of a month and the time of day; returns a newly chosen time. `civil`: the displayed time in the displayed time zone.
fn calendar(bar: &mut TimeBar, ui: &mut egui::Ui, civil: NaiveDateTime) -> Option<NaiveDateTime> {
    let month_of_view = civil.date().with_day(1)?;
    let month = bar.month.unwrap_or(month_of_view);
    let mut chosen = None;
    ui.horizontal(|ui| {
        let month_button = |ui: &mut egui::Ui, icon: Icon, name: &str, month: Option<NaiveDate>| {
            if icons::icon_button(ui, icon, name).on_hover_text(name).clicked() { month } else { None }
        };
        let earlier = month_button(ui, Icon::Previous, text!("calendar-previous"), month.checked_sub_months(Months::new(1)));
        ui.strong(month_name(month));
        let mut year = month.year();
        number_field::show(ui, &mut year, NumberKind::Year, -9999..=9999, text!("calendar-year"), |field| field.speed(0.2));
        let later = month_button(ui, Icon::Next, text!("calendar-next"), month.checked_add_months(Months::new(1)));
        bar.month = earlier.or(later).or(month.with_year(year)).or(bar.month);
    });
    if month.year() <= LAST_YEAR_OF_JULIAN_DATES {
        ui.weak(text!("calendar-gregorian"));
    }
    // A press that ends the text of the year changes the month before the release, which may be a click on a day. Until then the days stay in place. So they
    // do for a click of a screen reader, before which the text is read.
    let is_readers_click = |event: &Event| matches!(event, Event::AccessKitActionRequest(request) if request.action == ReaderAction::Click);
    let may_click = ui.input(|input| input.pointer.could_any_button_be_click() || input.raw.events.iter().any(is_readers_click));
    let laid_out = bar.laid_out_month.filter(|_| may_click).unwrap_or(month);
    bar.laid_out_month = Some(laid_out);
    let first_monday = laid_out.checked_sub_days(Days::new(laid_out.weekday().num_days_from_monday().into()))?;
    Grid::new("days of the month").num_columns(7).spacing([2.0, 2.0]).show(ui, |ui| {
        for name in [
            text!("weekday-1"),
            text!("weekday-2"),
            text!("weekday-3"),
            text!("weekday-4"),
            text!("weekday-5"),
            text!("weekday-6"),
            text!("weekday-7"),
        ] {
            ui.weak(name);
        }
        ui.end_row();
        // The days of a month fall in at most six weeks.
        for day in first_monday.iter_days().take(42) {
            let is_displayed = day == civil.date();
            let text = egui::RichText::new(format!("{:>2}", day.day()));
            let text = if day.month() == laid_out.month() { text } else { text.weak() };
            if ui
                .add(Button::selectable(is_displayed, text))
                .on_hover_text(text!("calendar-day-hint"))
                .accessible_name(long_date(day))
                .clicked()
            {
                // The typed year counts for the day, too. It may have no 29 February: then no day is chosen.
                let years = if month.month() == laid_out.month() { month.year() - laid_out.year() } else { 0 };
                let day_of_year = day.with_year(day.year() + years);
                chosen = day_of_year.map(|day| day.and_time(civil.time()));
            }
            if day.weekday() == chrono::Weekday::Sun {
                ui.end_row();
            }
        }
    });
    ui.separator();
    ui.horizontal(|ui| {
        ui.label(text!("calendar-time"));
        let (mut hour, mut minute, mut second) = (civil.hour(), civil.minute(), civil.second());
        for (mark, value, max, name) in [
            (None, &mut hour, 23, text!("calendar-hour")),
            (Some(":"), &mut minute, 59, text!("calendar-minute")),
            (Some(":"), &mut second, 59, text!("calendar-second")),
        ] {
            if let Some(mark) = mark {
                ui.label(mark);
            }
            number_field::show(ui, value, NumberKind::Clock, 0..=max, name, |field| field);
        }
        let time =
            NaiveTime::from_hms_opt(hour, minute, second).filter(|time| *time != civil.time().with_nanosecond(0).unwrap_or_default());
        chosen = chosen.or(time.map(|time| civil.date().and_time(time)));
    });
    chosen
}

/// Shows the controls for direction and rate of time.
fn rate_controls(interface: &Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let time_rate = &interface.viewer.time_rate;
    let is_paused = time_rate.is_paused();
    let is_backward = time_rate.rate() < 0.0;
    for (icon, name, hover, is_on, action) in [
        (Icon::Reverse, text!("time-reverse"), text!("time-reverse-hint"), is_backward, Action::TimeBackward),
        (Icon::Pause, text!("time-pause"), text!("time-pause-hint"), is_paused, Action::TogglePause),
        (Icon::Play, text!("time-play"), text!("time-play-hint"), !is_paused && !is_backward, Action::TimeForward),
    ] {
        // A button that is on stays on: a click on Pause does not resume paused time.
        if icons::selectable(ui, icon, is_on, name).on_hover_text(hover).clicked() && !is_on {
            actions.push(action);
        }
    }
    caption(ui, text!("time-rate-caption"));
    let mut speed = time_rate.speed();
    let slider = Slider::new(&mut speed, MIN_SPEED..=MAX_SPEED).logarithmic(true).show_value(false);
    // With a size known in advance, the slider moves to the next row if this one has no room. By itself, a slider of egui would extend beyond the window.
    let slider_size = [ui.spacing().slider_width, ui.spacing().interact_size.y];
    let slider = ui.add_sized(slider_size, slider).on_hover_text(text!("time-rate-hint")).accessible_name(text!("time-rate"));
    if slider.changed() {
        actions.push(Action::SetSpeed(speed));
    }
    let paused_text = |rate| text!("time-paused-at", speed = rate_text(rate));
    // The label is as wide as the longest text, so that the controls next to it do not move.
    let width = RATES_WITH_LONGEST_TEXTS.into_iter().map(|rate| theme::text_width(ui, paused_text(rate))).fold(0.0, f32::max);
    let text = if is_paused { paused_text(time_rate.resumed_rate()) } else { time_rate.label() };
    // One point is added, because positions are rounded to pixels.
    let size = [width.ceil() + 1.0, ui.spacing().interact_size.y];
    ui.add_sized(size, egui::Label::new(text).truncate());
}

/// Shows the buttons for the previous and the next event of a kind, and starts their searches.
fn event_buttons(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    show_found_event(interface, worker, actions);
    let kind = interface.time_bar.kind;
    let mut requested_backward = interface.time_bar.take_request_by_key();
    let event_button = |ui: &mut egui::Ui, icon: Icon, name: &str, key: &str| {
        icons::icon_button(ui, icon, name).on_hover_text(text!("event-look-hint", name = name, kind = kind.name(), key = key)).clicked()
    };
    if event_button(ui, Icon::Previous, text!("event-previous"), "p") {
        requested_backward = Some(true);
    }
    let list = ComboBox::from_id_salt("kind of event").selected_text(kind.name()).width(100.0).show_ui(ui, |ui| {
        for kind in EventKind::ALL {
            ui.selectable_value(&mut interface.time_bar.kind, kind, kind.name());
        }
    });
    list.response.on_hover_text(text!("event-kind-hint")).accessible_name(text!("event-kind"));
    if event_button(ui, Icon::Next, text!("event-next"), "e") {
        requested_backward = Some(false);
    }
    if let Some(is_backward) = requested_backward {
        search_event(interface, worker, kind, is_backward);
    }
    if interface.time_bar.pending.is_some() {
        accessible::spinner(ui, text!("event-looking"));
    } else {
        // The spinner has a place of its own: otherwise the timeline would move under the pointer, and lose the focus.
        ui.allocate_exact_size(Vec2::splat(ui.spacing().interact_size.y), Sense::hover());
    }
}

/// The part of the bar that works while the bar is hidden: searches for events by key.
pub(crate) fn update_hidden(interface: &mut Interface, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    show_found_event(interface, worker, actions);
    if let Some(is_backward) = interface.time_bar.take_request_by_key() {
        let kind = interface.time_bar.kind;
        search_event(interface, worker, kind, is_backward);
    }
}

/// Searches for the next event of a kind, or for the previous one.
fn search_event(interface: &mut Interface, worker: &dyn RenderWorker, kind: EventKind, is_backward: bool) {
    let gap_s = if is_backward { -EVENT_GAP_S } else { EVENT_GAP_S };
    let start = interface.viewer.view_after_flight().time().plus_seconds(gap_s);
    let span_s = f64::from(EVENT_SEARCH_YEARS) * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
    let search = EventSearch::new(vec![kind], start, span_s, is_backward);
    let pending = ask(worker, move |session| search.find_first(session.catalog(), session.ephemeris()));
    interface.time_bar.pending = Some((kind, pending));
}

/// Shows the event that a search has found, or says why there is none.
fn show_found_event(interface: &mut Interface, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    // The event may arrive in the very frame in which a key or a typed date chooses another view.
    if actions.iter().any(super::chooses_view) {
        interface.time_bar.forget_search();
    }
    match interface.time_bar.take_found() {
        Some(Ok(event)) => events::show(interface, worker, Arc::new(event), actions),
        Some(Err(why)) => interface.refuse_view(why),
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Instant;
    use crate::view::language::{Language, set};

    /// The date field shows a time as a text that it reads as the same time.
    #[test]
    fn the_displayed_text_is_read_back_as_the_same_time() {
        let now = Instant::parse("2026-11-22T23:00:00Z").expect("a time");
        for (language, text) in [(Language::English, "2024-04-08 18:17:00"), (Language::German, "08.04.2024, 18:17:00")] {
            set(language);
            for zone in [ShownTimeZone::Utc, ShownTimeZone::Local] {
                let time = parse_date(text, zone, now).expect(text);
                assert_eq!(zone.civil_time(time).map(civil_text).as_deref(), Some(text));
            }
        }
        set(Language::English);
    }

    /// Another kind may be chosen while a search runs.
    #[test]
    fn a_search_without_result_names_the_kind_that_was_searched() {
        let (pending, answer) = Pending::with_sender();
        let mut bar = TimeBar { pending: Some((EventKind::Moons, pending)), kind: EventKind::Lunar, ..TimeBar::default() };
        assert!(bar.take_found().is_none() && bar.pending.is_some());
        answer(Ok(None));
        let why = bar.take_found().and_then(Result::err).expect("a reason");
        assert!(why.contains(EventKind::Moons.name()) && !why.contains(EventKind::Lunar.name()), "{why}");
        assert!(bar.pending.is_none());
    }
}
