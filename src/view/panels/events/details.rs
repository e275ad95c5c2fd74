//! The chosen event in the Events panel: its buttons, and its contacts at the observer's place.
//!
//! In: the chosen event, the observer's place. Out: actions that show the event or play it. Always: if the camera stands at the observer's place and the
//! event is visible from this place, *Watch it* leaves the camera where it is. Not here: the list of events.

use super::{EventAtPlace, RunningPlayback, best_view};
use crate::catalog::NaifId;
use crate::events::{GeodeticPosition, LunarType, SolarType};
use crate::time::{Instant, MIN_SHOWN_DELTA_T_ERROR_S};
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::event_search::{ContactAtPlace, EventFromPlace, SkyEvent};
use crate::view::app::event_view::central_phase;
use crate::view::app::settings::Home;
use crate::view::app::view_state::{CameraPose, ViewState, wrapped_longitude_deg};
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::dates::{month_day_second_text, second_text};
use crate::view::language::{decimal, text, translated_name};
use crate::view::panels::icons::{self, Icon};
use crate::view::panels::{Interface, accessible, information};
use crate::view::worker::render_worker::{RenderWorker, ask};
use egui::{Grid, vec2};
use std::sync::Arc;

/// Height of a row of the table of an event's contacts, and of the line above the table, points.
const CONTACT_ROW_HEIGHT: f32 = 24.5;
/// Smallest number of rows for which the table of contacts has room: at a place, a total solar eclipse has four contacts and a maximum.
const MIN_CONTACT_ROWS: usize = 5;
/// Two places count as the same if latitude and longitude differ by less than this: about a kilometre on the Earth.
const SAME_PLACE_DEG: f64 = 0.01;

/// Shows the chosen event: buttons for its actions, and its contacts.
pub(super) fn show(
    interface: &mut Interface,
    ui: &mut egui::Ui,
    worker: &dyn RenderWorker,
    event: &Arc<SkyEvent>,
    actions: &mut Vec<Action>,
) {
    ui.add_space(4.0);
    ui.strong(event.title(worker.session().catalog()));
    ui.label(event.summary(interface.settings.time_zone));
    if matches!(**event, SkyEvent::Lunar(_)) {
        ui.weak(text!("events-shadow")).on_hover_text(text!("events-shadow-hint"));
    }
    let (_, delta_t_error_s) = event.greatest().delta_t_and_error_s();
    if delta_t_error_s >= MIN_SHOWN_DELTA_T_ERROR_S {
        let seconds = decimal(delta_t_error_s, if delta_t_error_s < 10.0 { 1 } else { 0 });
        ui.weak(text!("events-delta-t", seconds = seconds)).on_hover_text(text!("events-delta-t-hint"));
    }
    let observer_place = interface.information.observer_place;
    let seen_from_place = interface.events.seen_from(event, observer_place).and_then(|seen| seen.as_ref().ok()).cloned();
    let is_visible_at_place = seen_from_place.as_ref().is_some_and(|seen| seen.is_visible);
    let camera_is_at_place = stands_at(&interface.viewer.view_after_flight().camera_pose, observer_place);
    ui.horizontal_wrapped(|ui| {
        let watch = icons::button(ui, Icon::Watch, text!("events-watch"));
        // A camera at the place stays there only if the event is visible there, which is known once the contacts have arrived.
        let is_ready = !camera_is_at_place || interface.events.seen_from(event, observer_place).is_some();
        if ui.add_enabled(is_ready, watch).on_hover_text(text!("events-watch-hint")).clicked() {
            watch_event(interface, worker, event, seen_from_place.as_ref().filter(|_| camera_is_at_place), actions);
            if camera_is_at_place && !is_visible_at_place {
                interface.refuse_view(text!("events-watch-elsewhere"));
            }
        }
        if ui.button(text!("events-greatest")).on_hover_text(text!("events-greatest-hint")).clicked() {
            actions.push(Action::Show(Box::new(best_view(interface, worker, event))));
        }
        let from_place = icons::button(ui, Icon::Stand, text!("events-from-place"));
        if ui.add_enabled(is_visible_at_place, from_place).on_hover_text(text!("events-from-place-hint")).clicked() {
            let contacts = seen_from_place.as_ref().map(|seen| seen.contacts.as_slice()).unwrap_or_default();
            let view = view_from_place(interface, event, contacts);
            actions.push(Action::Show(Box::new(view)));
        }
    });
    information::place_fields(ui, &mut interface.information);
    // The height is reserved before the contacts at the place arrive, so that no button moves when they do. Their number is not known yet. But an event with
    // more contacts than the minimum of rows, such as a lunar eclipse, has the same contacts everywhere, plus a maximum.
    let rows = (event.contacts().len() + 1).max(MIN_CONTACT_ROWS);
    let height = (rows + 1) as f32 * CONTACT_ROW_HEIGHT;
    ui.allocate_ui(vec2(ui.available_width(), height), |ui| {
        ui.set_min_height(height);
        contact_table(interface, ui, worker, event);
    });
    ui.add_space(4.0);
}

/// Whether a camera stands on the Earth's ground at the observer's place.
pub(super) fn stands_at(camera_pose: &CameraPose, observer_place: Home) -> bool {
    let CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, .. } = *camera_pose else { return false };
    let differences_deg = [latitude_deg - observer_place.latitude_deg, wrapped_longitude_deg(longitude_deg - observer_place.longitude_deg)];
    differences_deg.into_iter().all(|degrees| degrees.abs() < SAME_PLACE_DEG)
}

/// The view of an event from the observer's place, at the time of the event's maximum at this place. `contacts`: the event's contacts at the place.
fn view_from_place(interface: &Interface, event: &SkyEvent, contacts: &[ContactAtPlace]) -> ViewState {
    let Home { latitude_deg, longitude_deg } = interface.information.observer_place;
    let maximum = contacts.iter().find(|contact| contact.name == "maximum");
    // An event without a maximum does not occur at the place, and nothing asks for its view.
    let altitude_deg = maximum.map_or(45.0, |maximum| maximum.altitude_deg);
    let place = GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 };
    let mut view = event.view_from(place, altitude_deg, &interface.viewer.base_view());
    view.tdb_s = maximum.map_or(view.tdb_s, |maximum| maximum.time.tdb_seconds_past_j2000());
    view
}

/// Runs time through an event. The view is from the observer's place if the camera stands at this place and the event is visible from it; otherwise it is
/// the best view. `seen`: the event as seen from the observer's place; `None` if the camera stands elsewhere or this is not known.
fn watch_event(
    interface: &mut Interface,
    worker: &dyn RenderWorker,
    event: &SkyEvent,
    seen: Option<&EventFromPlace>,
    actions: &mut Vec<Action>,
) {
    let (view, playback) = match seen {
        Some(seen) if seen.is_visible => (view_from_place(interface, event, &seen.contacts), event.playback_at(seen)),
        _ => (best_view(interface, worker, event), event.playback()),
    };
    actions.push(Action::Show(Box::new(ViewState { tdb_s: playback.start_tdb_s, paused: Some(false), ..view })));
    actions.push(Action::RunAt(playback.rate_at(playback.start_tdb_s)));
    interface.events.playback = Some(RunningPlayback::from_start(playback));
}

/// Shows the name of a contact, with a tooltip that explains it.
fn contact_name(ui: &mut egui::Ui, name: &str) {
    let label = ui.label(translated_name("contact", name));
    let about = translated_name("contact-about", name);
    if about != name {
        label.on_hover_text(about);
    }
}

/// Shows the time of a contact in the displayed zone, with a tooltip that names the year and the zone.
fn contact_time(ui: &mut egui::Ui, time: Instant, zone: ShownTimeZone) {
    ui.monospace(month_day_second_text(time, zone)).on_hover_text(second_text(time, zone));
}

/// Shows the contacts at the observer's place, which the query worker computes; if the event does not occur at that place, those for the entire Earth.
fn contact_table(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, event: &Arc<SkyEvent>) {
    let (observer_place, zone) = (interface.information.observer_place, interface.settings.time_zone);
    let panel = &mut interface.events;
    if !panel.at_place.as_ref().is_some_and(|asked| Arc::ptr_eq(&asked.event, event) && asked.observer_place == observer_place) {
        let asked_event = Arc::clone(event);
        let question = move |session: &crate::session::Session| {
            asked_event.seen_from(session.catalog(), session.ephemeris(), observer_place).map_err(|e| error_text(&e))
        };
        panel.at_place = Some(EventAtPlace { event: Arc::clone(event), observer_place, pending: ask(worker, question), seen: None });
    }
    let seen = match panel.seen_from(event, observer_place) {
        None => {
            accessible::spinner(ui, text!("events-contacts-coming"));
            return;
        }
        Some(Err(why)) => {
            ui.weak(why);
            return;
        }
        Some(Ok(seen)) => seen,
    };
    if !seen.is_visible {
        ui.colored_label(ui.visuals().warn_fg_color, text!("events-not-visible"));
    }
    Grid::new("contacts").num_columns(3).striped(true).show(ui, |ui| {
        if seen.contacts.is_empty() {
            for (name, time) in event.contacts() {
                contact_name(ui, name);
                contact_time(ui, *time, zone);
                ui.end_row();
            }
        }
        for contact in &seen.contacts {
            contact_name(ui, contact.name);
            contact_time(ui, contact.time, zone);
            // Refraction raises the upper limb above the horizon while the centre's altitude is negative. Beside a visible contact, a negative
            // altitude would look wrong.
            if contact.is_up && contact.altitude_deg < 0.0 {
                ui.label(text!("events-at-horizon"));
            } else if contact.is_up {
                ui.label(text!("events-altitude", degrees = decimal(contact.altitude_deg, 0)));
            } else {
                ui.weak(text!("events-below-horizon"));
            }
            ui.end_row();
        }
    });
    if seen.is_visible
        && let Some(line) = central_phase_text(event, &seen.contacts)
    {
        ui.label(line);
    }
}

/// How long the total or annular phase of an eclipse lasts at a place; `None` if there is none, or the event is no eclipse of the Sun or the Moon.
fn central_phase_text(event: &SkyEvent, contacts: &[ContactAtPlace]) -> Option<String> {
    let contacts: Vec<(&str, Instant)> = contacts.iter().map(|contact| (contact.name, contact.time)).collect();
    let (start, end) = central_phase(&contacts)?;
    let duration = minutes_and_seconds(end.tdb_seconds_past_j2000() - start.tdb_seconds_past_j2000());
    match event {
        SkyEvent::Solar(e) if e.class == SolarType::Annular => Some(text!("events-annularity", duration = duration)),
        // Which of the two a hybrid eclipse is at a place, the contacts do not say.
        SkyEvent::Solar(e) if e.class == SolarType::Hybrid => Some(text!("events-central-phase", duration = duration)),
        SkyEvent::Solar(_) => Some(text!("events-totality", duration = duration)),
        SkyEvent::Lunar(e) if e.class == LunarType::Total => Some(text!("events-totality", duration = duration)),
        SkyEvent::Lunar(_) | SkyEvent::Transit(_) | SkyEvent::Moons(_) => None,
    }
}

/// A duration in minutes and whole seconds, below a minute only in seconds.
fn minutes_and_seconds(duration_s: f64) -> String {
    let whole_s = duration_s.round();
    let (minutes, seconds) = ((whole_s / 60.0).floor(), whole_s % 60.0);
    let seconds = format!("{} {}", decimal(seconds, 0), text!("unit-second"));
    if minutes == 0.0 { seconds } else { format!("{} {} {seconds}", decimal(minutes, 0), text!("unit-minute")) }
}
