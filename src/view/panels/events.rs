//! The Events panel: eclipses, transits and events of moons before or after the displayed date, searched in the background.
//!
//! In: kinds of events, a range of dates, clicks. Out: actions that show an event, play it, or show it from a place. Always: rows are only
//! appended, nearest event first, so that no row moves under the pointer; a search continues while the panel is closed, and stops on request;
//! the searched span contains the chosen event. Not here: the chosen event's buttons and contacts (`details`), a running playback (`playback`).

mod details;
mod playback;

use self::playback::RunningPlayback;
use super::Interface;
use super::icons::{self, Icon};
use super::theme::MIN_LIST_HEIGHT;
use crate::catalog::Catalog;
use crate::ephemeris::EphemerisError;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use crate::view::app::body_positions::SessionPositions;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::event_search::{EventFromPlace, EventKind, EventSearch, SkyEvent};
use crate::view::app::event_view::EventPlayback;
use crate::view::app::settings::Home;
use crate::view::app::view_state::{CameraPose, ViewState};
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::dates::short_minute_text;
use crate::view::language::{text, text_by_id};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use chrono::{Months, NaiveDateTime};
use egui::text::{LayoutJob, TextWrapping};
use egui::{Button, Color32, ComboBox, Label, Panel, Pos2, ProgressBar, Response, RichText, ScrollArea, TextStyle, vec2};
use std::sync::Arc;

/// Lengths of the searched span of time, calendar months, and the message ids of their names.
const RANGES_MONTHS: [(u32, &str); 4] = [(1, "range-month"), (12, "range-year"), (120, "range-10-years"), (1200, "range-100-years")];
/// Index of the year in [`RANGES_MONTHS`].
const YEAR_RANGE_INDEX: usize = 1;
/// Separator between the parts of a summary.
const PART_SEPARATOR: &str = " · ";
/// Height of the line above the list, points.
const STATUS_HEIGHT: f32 = 24.0;
/// Number of rows of the list for which the details of an event leave room. The details may take half of the height, though, even if fewer rows remain.
const MIN_VISIBLE_ROWS: f32 = 2.0;
/// Largest number of rows of the list of events.
const MAX_ROWS: usize = 1000;
/// Time between the start of a search and the chosen event, which the search must find again, seconds.
const SEARCH_MARGIN_S: f64 = 60.0;

/// A row of the list.
struct Row {
    event: Arc<SkyEvent>,
    title: String,
}

impl Row {
    /// The row of an event, in the current language.
    fn of(event: SkyEvent, catalog: &Catalog) -> Self {
        Self { title: event.title(catalog), event: Arc::new(event) }
    }
}

/// The result of one search step: the search after the step, and the events that it found. Texts about them are formatted later, because the language may
/// change before the result is taken.
type StepAnswer = (EventSearch, Vec<SkyEvent>);

/// An event as seen from a place, or the text of an error.
type SeenFromPlace = Result<EventFromPlace, String>;

/// The chosen event as seen from a place.
struct EventAtPlace {
    event: Arc<SkyEvent>,
    observer_place: Home,
    pending: Pending<SeenFromPlace>,
    /// `None` until the answer has arrived.
    seen: Option<SeenFromPlace>,
}

/// The instant at which a search starts, and whether it runs backward from there.
#[derive(Clone, Copy)]
struct SearchStart {
    start: Instant,
    is_backward: bool,
}

/// State of the Events panel.
pub(crate) struct EventsPanel {
    /// Whether each kind of [`EventKind::ALL`] is searched.
    kinds: [bool; EventKind::ALL.len()],
    /// Index into [`RANGES_MONTHS`].
    range_index: usize,
    /// Whether the search runs from the displayed date into the past.
    is_backward: bool,
    /// The running search step, if any, and the fraction of the search (0 to 1) that was done before this step.
    running: Option<(Pending<StepAnswer>, f32)>,
    rows: Vec<Row>,
    /// The search that found the rows; `None` before the first search.
    searched: Option<SearchStart>,
    /// Why the search has ended before the end of its range.
    failure: Option<EphemerisError>,
    /// The event whose details are shown.
    chosen: Option<Arc<SkyEvent>>,
    /// The chosen event as seen from the observer's place, once it was asked for; may still belong to an earlier event or place.
    at_place: Option<EventAtPlace>,
    /// The running playback of an event.
    playback: Option<RunningPlayback>,
}

impl EventsPanel {
    /// The span and rate at which the chosen event is played, or would be played with this camera; `None` if no event is chosen.
    pub(crate) fn playback_of_chosen(&self, camera_pose: &CameraPose, observer_place: Home) -> Option<EventPlayback> {
        let chosen = self.chosen.as_ref()?;
        let seen = self.seen_from(chosen, observer_place).and_then(|seen| seen.as_ref().ok());
        let seen_from_camera = seen.filter(|seen| seen.is_visible && details::stands_at(camera_pose, observer_place));
        let at_camera = seen_from_camera.map(|seen| chosen.playback_at(seen));
        let running = self.playback.as_ref().map(|running| running.playback);
        Some(running.or(at_camera).unwrap_or_else(|| chosen.playback()))
    }

    /// An event as seen from a place, if the answer of the query worker has arrived. `self.at_place` may still belong to another event or place.
    fn seen_from(&self, event: &Arc<SkyEvent>, observer_place: Home) -> Option<&SeenFromPlace> {
        self.at_place.as_ref().filter(|asked| Arc::ptr_eq(&asked.event, event) && asked.observer_place == observer_place)?.seen.as_ref()
    }

    /// Whether the search includes the kind of an event.
    fn includes_kind_of(&self, event: &SkyEvent) -> bool {
        EventKind::ALL.into_iter().zip(self.kinds).any(|(kind, is_searched)| is_searched && kind == event.kind())
    }

    /// Whether the time of an event is within the span of the last search.
    fn covers(&self, event: &SkyEvent) -> bool {
        let Some(SearchStart { start, is_backward }) = self.searched else { return false };
        let after_start_s = event.greatest().tdb_seconds_past_j2000() - start.tdb_seconds_past_j2000();
        let distance_s = if is_backward { -after_start_s } else { after_start_s };
        (0.0..=self.range_s(start)).contains(&distance_s)
    }

    /// Length of the chosen range from `start` on, seconds: up to the same day of a month and the same time of day in UTC, so that the year after a
    /// 1 January is a calendar year, whether it has 365 or 366 days.
    fn range_s(&self, start: Instant) -> f64 {
        let (months, _) = RANGES_MONTHS[self.range_index];
        let utc = ShownTimeZone::Utc;
        let add_months = if self.is_backward { NaiveDateTime::checked_sub_months } else { NaiveDateTime::checked_add_months };
        let end = utc.civil_time(start).and_then(|civil| utc.instant(add_months(civil, Months::new(months))?));
        let tdb_s = Instant::tdb_seconds_past_j2000;
        // Outside the calendar's range of years, months have their mean length.
        let mean_range_s = f64::from(months) / 12.0 * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
        end.map_or(mean_range_s, |end| (tdb_s(end) - tdb_s(start)).abs())
    }

    /// The start of a search that finds this event first: just outside the event's span.
    fn start_beside(&self, event: &SkyEvent) -> Instant {
        let (first, last) = event.span();
        if self.is_backward { last.plus_seconds(SEARCH_MARGIN_S) } else { first.plus_seconds(-SEARCH_MARGIN_S) }
    }

    /// Formats the titles of the rows again, in the current language, and drops the contacts, which may hold an error in the previous language.
    pub(crate) fn rewrite_texts(&mut self, catalog: &Catalog) {
        self.at_place = None;
        for row in &mut self.rows {
            row.title = row.event.title(catalog);
        }
    }
}

impl Default for EventsPanel {
    fn default() -> Self {
        Self {
            // Eclipses of the Sun and the Moon, in ten years.
            kinds: [true, true, false, false],
            range_index: 2,
            is_backward: false,
            running: None,
            rows: Vec::new(),
            searched: None,
            failure: None,
            chosen: None,
            at_place: None,
            playback: None,
        }
    }
}

/// Shows the panel. When it is first shown, a search starts.
pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    if search_options(interface, ui) || interface.events.searched.is_none() {
        begin(interface, worker);
    }
    progress(&mut interface.events, ui, interface.settings.time_zone);
    // The details need as much room as the list.
    let min_height = if interface.events.chosen.is_some() { 2.0 * MIN_LIST_HEIGHT } else { MIN_LIST_HEIGHT };
    ui.scope(|ui| {
        ui.set_max_height(ui.available_height().max(min_height));
        if let Some(event) = interface.events.chosen.clone() {
            // The details scroll if they are taller than this.
            let available = ui.available_height();
            let max_height = (available - MIN_VISIBLE_ROWS * (row_height(ui) + ui.spacing().item_spacing.y)).max(0.5 * available);
            Panel::bottom("event").resizable(false).show(ui, |ui| {
                ScrollArea::vertical()
                    .auto_shrink([false, true])
                    .max_height(max_height)
                    .min_scrolled_height(max_height)
                    .show(ui, |ui| details::show(interface, ui, worker, &event, actions));
            });
        }
        failure(&interface.events, ui);
        list(interface, ui, worker, actions);
    });
}

/// Shows below the list why the search ended before the end of its range. The text wraps there without moving a row of the list.
fn failure(panel: &EventsPanel, ui: &mut egui::Ui) {
    let Some(why) = &panel.failure else { return };
    Panel::bottom("end of events").resizable(false).show(ui, |ui| {
        ui.add(Label::new(RichText::new(error_text(why)).color(ui.visuals().warn_fg_color)).wrap());
    });
}

/// Shows the controls for kinds, direction and range; returns whether to search again.
fn search_options(interface: &mut Interface, ui: &mut egui::Ui) -> bool {
    let panel = &mut interface.events;
    let mut changed = false;
    ui.horizontal_wrapped(|ui| {
        for (kind, is_searched) in EventKind::ALL.into_iter().zip(&mut panel.kinds) {
            changed |= ui.checkbox(is_searched, kind.name()).on_hover_text(text!("events-kind-hint", kind = kind.name())).changed();
        }
    });
    ui.horizontal(|ui| {
        for (is_backward, name, tooltip) in
            [(false, text!("events-after"), text!("events-after-hint")), (true, text!("events-before"), text!("events-before-hint"))]
        {
            changed |= ui.selectable_value(&mut panel.is_backward, is_backward, name).on_hover_text(tooltip).changed();
        }
        let (_, range_name) = RANGES_MONTHS[panel.range_index];
        let list = ComboBox::from_id_salt("range of events").selected_text(text_by_id(range_name)).width(80.0).show_ui(ui, |ui| {
            for (i, (_, name)) in RANGES_MONTHS.iter().enumerate() {
                changed |= ui.selectable_value(&mut panel.range_index, i, text_by_id(name)).changed();
            }
        });
        list.response.on_hover_text(text!("events-range-hint")).accessible_name(text!("events-range"));
        let search = icons::button(ui, Icon::Search, text!("events-search"));
        changed |= ui.add(search).on_hover_text(text!("events-search-hint")).clicked();
    });
    changed
}

/// Starts a search from the displayed date; a running search is dropped. If the chosen event is displayed, the search starts beside it, so that it
/// finds the event.
fn begin(interface: &mut Interface, worker: &dyn RenderWorker) {
    let time = interface.viewer.view_after_flight().time();
    let panel = &interface.events;
    let is_displayed = |event: &&Arc<SkyEvent>| panel.includes_kind_of(event) && event.playback().is_near(time.tdb_seconds_past_j2000());
    let displayed = panel.chosen.as_ref().filter(is_displayed);
    let start = displayed.map_or(time, |event| panel.start_beside(event));
    begin_at(interface, worker, start);
}

/// Starts a search from an instant; a running search is dropped. A chosen event outside the searched span, or of a kind
/// that is not searched, is dropped, too, because its details would not belong to the list.
fn begin_at(interface: &mut Interface, worker: &dyn RenderWorker, start: Instant) {
    let panel = &mut interface.events;
    let kinds = EventKind::ALL.into_iter().zip(panel.kinds).filter_map(|(kind, is_searched)| is_searched.then_some(kind)).collect();
    panel.rows.clear();
    panel.failure = None;
    panel.searched = Some(SearchStart { start, is_backward: panel.is_backward });
    if panel.chosen.as_ref().is_some_and(|event| !panel.covers(event) || !panel.includes_kind_of(event)) {
        (panel.chosen, panel.at_place) = (None, None);
    }
    let search = EventSearch::new(kinds, start, panel.range_s(start), panel.is_backward);
    panel.running = next_step(search, worker);
}

/// Searches for some kinds of events: in the calendar year after `start`, or without `start` in the chosen range after the displayed date.
pub(crate) fn search_for(interface: &mut Interface, worker: &dyn RenderWorker, kinds: &[EventKind], start: Option<Instant>) {
    let panel = &mut interface.events;
    panel.kinds = EventKind::ALL.map(|kind| kinds.contains(&kind));
    panel.is_backward = false;
    match start {
        Some(start) => {
            panel.range_index = YEAR_RANGE_INDEX;
            begin_at(interface, worker, start);
        }
        None => begin(interface, worker),
    }
}

/// Starts the next step, unless the search is over. Returns the pending step, and the fraction of the search that was done before it.
fn next_step(mut search: EventSearch, worker: &dyn RenderWorker) -> Option<(Pending<StepAnswer>, f32)> {
    if search.is_over() {
        return None;
    }
    let fraction_done = search.progress();
    let step = move |session: &crate::session::Session| {
        let found = search.step(session.catalog(), session.ephemeris());
        (search, found)
    };
    Some((ask(worker, step), fraction_done))
}

/// Takes the results of a step and starts the next; advances a playback. Runs in every frame, also while the panel is closed.
pub(crate) fn update(interface: &mut Interface, worker: &dyn RenderWorker) {
    let panel = &mut interface.events;
    if let Some((search, found)) = panel.running.as_ref().and_then(|(step, _)| step.take()) {
        let catalog = worker.session().catalog();
        panel.rows.extend(found.into_iter().map(|event| Row::of(event, catalog)));
        panel.failure = search.failure().cloned();
        panel.running = if panel.rows.len() < MAX_ROWS { next_step(search, worker) } else { None };
        panel.rows.truncate(MAX_ROWS);
    }
    if let Some(at_place) = &mut panel.at_place
        && let Some(seen) = at_place.pending.take()
    {
        at_place.seen = Some(seen);
    }
    playback::update(interface);
}

/// Shows the progress or the result of a search, at constant height, so that the list below stays in place.
fn progress(panel: &mut EventsPanel, ui: &mut egui::Ui, zone: ShownTimeZone) {
    let stopped = ui.horizontal(|ui| {
        ui.set_min_height(STATUS_HEIGHT);
        if let Some((_, fraction_done)) = panel.running {
            ui.add(ProgressBar::new(fraction_done).desired_width(180.0).show_percentage()).accessible_name(text!("events-progress"));
            return ui.button(text!("events-stop")).on_hover_text(text!("events-stop-hint")).clicked();
        }
        let (status, hint) = status_text(panel, zone);
        // The tooltip has the whole text, so egui's own for a text that is cut is switched off.
        let label = Label::new(RichText::new(&status).weak()).truncate().show_tooltip_when_elided(false);
        ui.add(label).on_hover_text(format!("{status}\n{hint}"));
        false
    });
    if stopped.inner {
        panel.running = None;
    }
}

/// A text about the result of the last search, and its tooltip.
fn status_text(panel: &EventsPanel, zone: ShownTimeZone) -> (String, &'static str) {
    let searched_text = panel.searched.map_or(String::new(), |SearchStart { start, is_backward }| {
        let side = if is_backward { text!("events-before-date") } else { text!("events-after-date") };
        format!("{side} {}", short_minute_text(start, zone))
    });
    match panel.rows.len() {
        0 if panel.kinds.contains(&true) => (text!("events-none", searched = searched_text), text!("events-none-hint")),
        0 => (text!("events-choose-kind").into(), text!("events-choose-kind-hint")),
        1 => (text!("events-one", searched = searched_text), text!("events-one-hint")),
        MAX_ROWS => (text!("events-most", count = MAX_ROWS, searched = searched_text), text!("events-some-hint")),
        n => (text!("events-some", n = n, searched = searched_text), text!("events-some-hint")),
    }
}

/// Shows a row of two lines: the event's title, and below it its time, size and place. The row omits the label of the time's zone, which its
/// tooltip, its accessible name and the line above the list contain. `height`: of the row, points.
fn row(ui: &mut egui::Ui, row: &Row, zone: ShownTimeZone, height: f32, is_chosen: bool) -> Response {
    let response = ui.add_sized([ui.available_width(), height], Button::selectable(is_chosen, ""));
    let visuals = ui.visuals();
    let (title_colour, summary_colour) = match is_chosen {
        true => (visuals.selection.stroke.color, visuals.selection.stroke.color),
        false => (visuals.strong_text_color(), visuals.text_color()),
    };
    let painter = ui.painter().with_clip_rect(response.rect.intersect(ui.clip_rect()));
    let corner = response.rect.left_top() + ui.spacing().button_padding;
    let second_line_corner = corner + vec2(0.0, ui.text_style_height(&TextStyle::Body));
    let width = response.rect.width() - 2.0 * ui.spacing().button_padding.x;
    // If a line is too long, its last parts are left out. If even its first part is too long, that part ends in an ellipsis. The tooltip has all parts.
    let line = |left_top: Pos2, text: String, style: TextStyle, colour: Color32| {
        let font = style.resolve(ui.style());
        let fits = |text: &str| painter.layout_no_wrap(text.to_owned(), font.clone(), colour).size().x <= width;
        let mut shown = text.as_str();
        while let Some((parts, _)) = shown.rsplit_once(PART_SEPARATOR).filter(|_| !fits(shown)) {
            shown = parts;
        }
        let wrap = TextWrapping::truncate_at_width(width);
        let job = LayoutJob { wrap, ..LayoutJob::simple_singleline(shown.to_owned(), font.clone(), colour) };
        painter.galley(left_top, painter.layout_job(job), colour);
    };
    line(corner, row.title.clone(), TextStyle::Body, title_colour);
    line(second_line_corner, row.event.summary_without_zone(zone), TextStyle::Small, summary_colour);
    let summary = row.event.summary(zone);
    response.on_hover_text(text!("events-row-hint", summary = summary)).accessible_name(format!("{}, {summary}", row.title))
}

/// Height of a row of the list, points.
fn row_height(ui: &egui::Ui) -> f32 {
    let lines_height = ui.text_style_height(&TextStyle::Body) + ui.text_style_height(&TextStyle::Small);
    lines_height + 2.0 * ui.spacing().button_padding.y + 2.0
}

/// Shows the list of events. A click on a row chooses its event and shows the best view of it.
fn list(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let row_height = row_height(ui);
    let mut clicked = None;
    let panel = &interface.events;
    // Without the minimum of 0, egui would let a list that has little room overlap the details.
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(0.0).show_rows(ui, row_height, panel.rows.len(), |ui, visible| {
        for event_row in &panel.rows[visible] {
            let is_chosen = panel.chosen.as_ref().is_some_and(|chosen| chosen.is_same(&event_row.event));
            if row(ui, event_row, interface.settings.time_zone, row_height, is_chosen).clicked() {
                clicked = Some(Arc::clone(&event_row.event));
            }
        }
    });
    if let Some(event) = clicked {
        actions.push(Action::Show(Box::new(best_view(interface, worker, &event))));
        interface.events.playback = None;
        interface.events.chosen = Some(event);
    }
}

/// The best view of an event.
fn best_view(interface: &Interface, worker: &dyn RenderWorker, event: &SkyEvent) -> ViewState {
    let session = worker.session();
    event.view(session.catalog(), &SessionPositions(session), &interface.viewer.base_view())
}

/// Chooses an event that was found outside this panel, and shows the best view of it. If the current list cannot contain the event, because the
/// search had another span or other kinds, a new search starts.
pub(crate) fn show(interface: &mut Interface, worker: &dyn RenderWorker, event: Arc<SkyEvent>, actions: &mut Vec<Action>) {
    actions.push(Action::Show(Box::new(best_view(interface, worker, &event))));
    let panel = &mut interface.events;
    let start = panel.start_beside(&event);
    let needs_search = panel.searched.is_some() && !(panel.covers(&event) && panel.includes_kind_of(&event));
    for (kind, is_searched) in EventKind::ALL.into_iter().zip(&mut panel.kinds) {
        *is_searched |= kind == event.kind();
    }
    panel.playback = None;
    panel.chosen = Some(event);
    if needs_search {
        begin_at(interface, worker, start);
    }
}
