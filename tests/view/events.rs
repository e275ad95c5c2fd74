//! The Events panel: the views it opens; contacts at a place; rows that do not move while a search goes on or is stopped, and do not overlap the details.

use crate::view::input::{Window, advance, window_without_images};
use crate::view::interface::{CpuTestRenderer, interface, session};
use egui::accesskit::Role;
use egui::{Event, Rect, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::{Observer, ObserverSky};
use orrery::events::{MoonEventType, solar_eclipses};
use orrery::session::Session;
use orrery::time::Instant;
use orrery::view::app::body_positions::{BodyPositions, SessionPositions};
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::event_search::{EventKind, SkyEvent, events_between};
use orrery::view::app::settings::Home;
use orrery::view::app::view_state::CameraPose;
use orrery::view::language::Language;
use orrery::view::panels::Tab;
use orrery::view::window::cpu_painter::Painter;
use orrery::view::worker::render_worker::{FailedJob, RenderJob, RenderWorker, RenderedView, Task};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

pub(super) fn parse_time(text: &str) -> Instant {
    Instant::parse(text).expect(text)
}

pub(super) fn between(kinds: &[EventKind], from: &str, to: &str) -> Vec<SkyEvent> {
    events_between(session().catalog(), session().ephemeris(), kinds, parse_time(from), parse_time(to)).expect("within the theories")
}

pub(super) fn greatest_tdb_s(event: &SkyEvent) -> f64 {
    event.greatest().tdb_seconds_past_j2000()
}

/// Over twenty years, each solar eclipse is viewed from a place where the discs overlap above the horizon, lunar eclipses and transits from the Earth's
/// centre.
#[test]
fn each_view_shows_its_event() {
    let (catalog, ephemeris, places) = (session().catalog(), session().ephemeris(), SessionPositions(session()));
    let base_view = interface(NaifId::EARTH, "2000-01-01T12:00:00Z").viewer.view;
    let mut with_low_sun = 0;
    for event in between(&[EventKind::Solar, EventKind::Lunar, EventKind::Transit], "2004-01-01", "2024-01-01") {
        let view = event.view(catalog, &places, &base_view);
        let name = format!("{} {}", event.title(catalog), event.summary(ShownTimeZone::Utc));
        assert!(view.request(catalog, ephemeris, 300, 200).is_ok() && view.paused == Some(true), "{name}");
        assert_eq!(view.tdb_s, greatest_tdb_s(&event), "{name}");
        match (&event, view.camera_pose) {
            (SkyEvent::Solar(_), CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km, .. }) => {
                let place = Observer { body: NaifId::EARTH, lat_graphic_deg: latitude_deg, lon_east_deg: longitude_deg, height_km };
                let sky = ObserverSky { catalog, ephemeris, place };
                let [sun, moon] = [NaifId::SUN, NaifId::MOON].map(|id| sky.topocentric(id, view.time()).expect("a place"));
                let separation_deg = orrery::ephemeris::angle_rad(sun.direction, moon.direction).to_degrees();
                assert!(separation_deg < sun.semidiameter_deg + moon.semidiameter_deg, "{name}: {separation_deg} degrees apart");
                // Dip of the horizon for a height h over a sphere of radius R: sqrt(2 h / R).
                let dip_deg = (2.0 * height_km / 6371.0).sqrt().to_degrees();
                assert!(sun.altitude_deg + dip_deg > sun.semidiameter_deg, "{name}: the Sun at {} degrees", sun.altitude_deg);
                // Where the Sun is near the horizon, the camera is 3 km above the ground instead of 10 m.
                with_low_sun += usize::from(height_km > 1.0);
            }
            (SkyEvent::Lunar(_), CameraPose::Centre { body: NaifId::EARTH }) => {
                let from_earth_km = |id| places.geometric_vector_km(NaifId::EARTH, id, view.time()).expect("a place");
                let separation_deg =
                    180.0 - orrery::ephemeris::angle_rad(from_earth_km(NaifId::SUN), from_earth_km(NaifId::MOON)).to_degrees();
                // The radius of the penumbra is up to 1.3 degrees, that of the Moon up to 0.28 degrees.
                assert!(view.target == NaifId::MOON && separation_deg < 1.7, "{name}: {separation_deg} degrees off the shadow");
            }
            (SkyEvent::Transit(_), CameraPose::Centre { body: NaifId::EARTH }) => assert_eq!(view.target, NaifId::SUN),
            other => panic!("{name}: {:?}", other.1),
        }
    }
    assert!(with_low_sun > 3, "eclipses seen from above the ground: {with_low_sun}");
}

/// Three months after opposition, Jupiter's shadow is beside Jupiter. The view of a moon's eclipse contains the moon even if it is above or below Jupiter,
/// because half the vertical field of view exceeds the moon's distance from Jupiter.
#[test]
fn the_view_of_a_moons_eclipse_contains_the_moon() {
    let (catalog, places) = (session().catalog(), SessionPositions(session()));
    let base_view = interface(NaifId::EARTH, "2015-05-01T00:00:00Z").viewer.view;
    let mut far_from_planet = 0;
    for event in between(&[EventKind::Moons], "2015-04-26", "2015-04-27") {
        let SkyEvent::Moons(moons_event) = &event else { panic!("{event:?}") };
        let view = event.view(catalog, &places, &base_view);
        if moons_event.class != MoonEventType::Eclipse {
            continue;
        }
        let from_earth_km = |id| places.geometric_vector_km(NaifId::EARTH, id, view.time()).expect("a place");
        let (planet_km, moon_km) = (from_earth_km(moons_event.planet), from_earth_km(moons_event.moon));
        let apart_deg = orrery::ephemeris::angle_rad(planet_km, moon_km).to_degrees();
        assert!(apart_deg < 0.5 * view.fov_deg, "{}: {apart_deg} degrees of {}", event.title(catalog), view.fov_deg);
        let radius_deg = (catalog.body(moons_event.planet).expect("a planet").radii_km.x / planet_km.length()).to_degrees();
        far_from_planet += usize::from(apart_deg > 3.0 * radius_deg);
    }
    assert!(far_from_planet > 0, "no eclipse far from the planet");
}

/// The Moon set in Greenwich while in the umbra on 2022-05-16 (timeanddate.com: moonset 05:07 BST, totality from 04:29 to 05:53 BST).
#[test]
fn contacts_below_the_horizon_are_marked() {
    let event = between(&[EventKind::Lunar], "2022-05-01", "2022-06-01").remove(0);
    let seen = event.seen_from(session().catalog(), session().ephemeris(), Home::default()).expect("a place");
    assert!(seen.is_visible);
    for (name, is_up) in [("P1", true), ("U1", true), ("U2", true), ("U3", false), ("U4", false), ("P4", false)] {
        assert_eq!(seen.contacts.iter().find(|l| l.name == name).map(|l| l.is_up), Some(is_up), "{name}");
    }
    // In Greenwich Jupiter was above the horizon in the night of the triple shadow, and below it at noon.
    let events = between(&[EventKind::Moons], "2015-01-24", "2015-01-25");
    let is_up_around = |hour: f64| {
        let lines =
            events.iter().flat_map(|e| e.seen_from(session().catalog(), session().ephemeris(), Home::default()).expect("a place").contacts);
        let near =
            |t: Instant| (t.tdb_seconds_past_j2000() - parse_time("2015-01-24").tdb_seconds_past_j2000() - hour * 3600.0).abs() < 5400.0;
        lines.filter(|l| near(l.time)).map(|l| l.is_up).collect::<Vec<_>>()
    };
    let [by_night, at_noon] = [6.5, 12.5].map(is_up_around);
    assert!(by_night.len() > 3 && by_night.iter().all(|is_up| *is_up), "{by_night:?}");
    assert!(!at_noon.is_empty() && at_noon.iter().all(|is_up| !is_up), "{at_noon:?}");
}

/// The window's search leaves out the numbers in the Saros series, because up to seven other eclipses are computed for each number. It finds the same
/// eclipses as the search with the numbers.
#[test]
fn the_search_computes_no_numbers_in_saros_series() {
    let [from, to] = ["2024-01-01", "2026-01-01"];
    let (catalog, ephemeris) = (session().catalog(), session().ephemeris());
    let with_saros = solar_eclipses(catalog, ephemeris, parse_time(from), parse_time(to)).expect("within the theories");
    let mut searched = 0;
    for (event, eclipse) in between(&[EventKind::Solar], from, to).iter().zip(&with_saros) {
        let SkyEvent::Solar(e) = event else { panic!("{event:?}") };
        assert_eq!((e.greatest, e.saros_member), (eclipse.greatest, None));
        assert!(eclipse.saros_member.is_some());
        searched += 1;
    }
    assert_eq!((searched, with_saros.len()), (4, 4), "solar eclipses of 2024 and 2025");
    let lunar = between(&[EventKind::Lunar], from, to);
    assert!(lunar.len() >= 3 && lunar.iter().all(|e| matches!(e, SkyEvent::Lunar(e) if e.saros_member.is_none())), "{lunar:?}");
}

pub(super) fn open_events(window: &mut Window, utc: &str) {
    window.state_mut().viewer.view.tdb_s = parse_time(utc).tdb_seconds_past_j2000();
    window.state_mut().tab = Some(Tab::Events);
    window.run_steps(40);
}

/// Contact times are shown in seconds, and in 585 BC the Earth's rotation is known to minutes only.
#[test]
fn an_error_of_delta_t_above_the_shown_digits_is_stated() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "-0584-05-08T00:00:00Z");
    window.get_by_label_contains("Total solar eclipse, -0584-05-22").click();
    window.run_steps(3);
    // Before 1200 the standard error is 0.8 s times the square of the centuries from 1820 (Morrison and Stephenson 2004).
    window.get_by_label_contains("Delta T is uncertain by 462 s");
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2024-01-01T00:00:00Z");
    window.get_by_label_contains("Total solar eclipse, 2024-04-08 18:17 UTC").click();
    window.run_steps(3);
    assert!(window.query_by_label_contains("Delta T is uncertain").is_none());
}

/// In Greenwich the Moon set before the greatest eclipse of 2024-03-25. So the maximum at this place was at moonset, with the Moon's centre below the horizon
/// and its upper limb at it.
#[test]
fn a_maximum_at_moonset_is_at_the_horizon() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2024-01-01T00:00:00Z");
    window.get_by_label_contains("Penumbral lunar eclipse, 2024-03-25").click();
    window.run_steps(3);
    assert_eq!(window.query_all_by_label("at the horizon").count(), 1);
    // The last contact.
    assert_eq!(window.query_all_by_label("below the horizon").count(), 1);
}

#[test]
fn an_eclipse_is_one_click_away_and_time_runs_through_it() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2024-01-01T00:00:00Z");
    window.get_by_label_contains("events after 2024-01-01 00:00 UTC");
    window.get_by_label_contains("Total solar eclipse, 2024-04-08 18:17 UTC").click();
    window.run_steps(3);
    let state = window.state();
    assert!(state.viewer.view.target == NaifId::SUN && state.viewer.time_rate.is_paused());
    let CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, .. } = state.viewer.view.camera_pose else {
        panic!("{:?}", state.viewer.view.camera_pose)
    };
    // Greatest eclipse at 25.3 N, 104.1 W (Espenak, NASA eclipse bulletin).
    assert!((latitude_deg - 25.3).abs() < 0.1 && (longitude_deg + 104.1).abs() < 0.1, "{latitude_deg}, {longitude_deg}");
    // It was not visible in Greenwich.
    window.get_by_label("Not visible from this place.");
    // C1, maximum and C4 at the place, all below the horizon, and not the contacts for the entire Earth.
    assert_eq!(window.query_all_by_label("below the horizon").count(), 3);
    assert!(["C1", "C4"].iter().all(|contact| window.query_by_label(contact).is_some()) && window.query_by_label("P1").is_none());
    assert!(window.get_by_label("From this place").accesskit_node().is_disabled());
    window.get_by_label("Watch it").click();
    window.run_steps(2);
    let start_s = window.state().viewer.view.tdb_s;
    let greatest_s = parse_time("2024-04-08T18:17:16Z").tdb_seconds_past_j2000();
    let rate = window.state().viewer.time_rate.rate();
    assert!(rate > 100.0 && start_s < greatest_s - 4000.0, "{rate}, {} s before", greatest_s - start_s);
    let mut real_s = 0.0;
    while !window.state().viewer.time_rate.is_paused() {
        advance(&mut window, 0.5);
        real_s += 0.5;
        assert!(real_s < 60.0, "the watch never ends");
    }
    assert!((20.0..40.0).contains(&real_s), "{real_s} s");
    // Half the time that the penumbra takes to pass over a place is 1 to 2 hours.
    let after_s = window.state().viewer.view.tdb_s - greatest_s;
    assert!((3600.0..8000.0).contains(&after_s), "{after_s} s after the greatest eclipse");
    window.get_by_label("Greatest").click();
    window.run_steps(2);
    assert!((window.state().viewer.view.tdb_s - greatest_s).abs() < 10.0);
}

/// From a place from which the event is visible, *Watch it* stays there; otherwise it goes to the best view and says so.
#[test]
fn watching_an_event_keeps_the_place_from_which_it_is_visible() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2019-01-10T00:00:00Z");
    let place = |window: &Window| match window.state().viewer.view.camera_pose {
        CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, .. } => Some((latitude_deg, longitude_deg)),
        _ => None,
    };
    let greenwich = Some((Home::default().latitude_deg, Home::default().longitude_deg));
    // Visible in Greenwich from the first contact to the last (Espenak, NASA).
    window.get_by_label_contains("Total lunar eclipse, 2019-01-21").click();
    window.run_steps(3);
    window.get_by_label("Watch it").click();
    window.run_steps(3);
    assert_eq!(place(&window), None, "the best view is that of the Earth's centre");
    window.get_by_label("From this place").click();
    window.run_steps(3);
    let greatest_s = window.state().viewer.view.tdb_s;
    assert_eq!(place(&window), greenwich);
    window.get_by_label("Watch it").click();
    window.run_steps(3);
    assert_eq!((place(&window), window.state().viewer.view.target), (greenwich, NaifId::MOON));
    let state = window.state();
    // The Moon is in the penumbra from 2.6 hours before the greatest eclipse.
    let before_s = greatest_s - state.viewer.view.tdb_s;
    assert!((9000.0..11_000.0).contains(&before_s) && !state.viewer.time_rate.is_paused(), "{before_s} s before");
    assert_eq!(state.message_line(), "");
    let camera_pose = state.viewer.view.camera_pose;
    window.get_by_label_contains("Total solar eclipse, 2019-07-02").click();
    window.run_steps(3);
    window.state_mut().viewer.view.camera_pose = camera_pose;
    window.run_steps(3);
    window.get_by_label("Watch it").click();
    window.run_steps(3);
    assert!(place(&window).is_some_and(|(latitude_deg, _)| latitude_deg < 0.0), "{:?}", place(&window));
    assert!(window.state().message_line().starts_with("Not visible from this place:"), "{}", window.state().message_line());
}

/// The details never show an event outside the span of the list.
#[test]
fn the_chosen_event_belongs_to_the_listed_span() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2024-01-01T00:00:00Z");
    let has_details = |window: &Window| window.query_by_label("Watch it").is_some();
    let search_from = |window: &mut Window, utc: &str| {
        window.state_mut().viewer.view.tdb_s = parse_time(utc).tdb_seconds_past_j2000();
        window.run_steps(2);
        window.get_by_role_and_label(Role::Button, "Search").click();
        window.run_steps(40);
    };
    window.get_by_label_contains("Total solar eclipse, 2024-04-08 18:17 UTC").click();
    window.run_steps(3);
    // The search from the displayed event finds it again.
    window.get_by_role_and_label(Role::Button, "Search").click();
    window.run_steps(40);
    window.get_by_label_contains("Total solar eclipse, 2024-04-08 18:17 UTC");
    assert!(has_details(&window));
    search_from(&mut window, "2050-01-01T00:00:00Z");
    assert!(!has_details(&window), "details of 2024 beside the events of 2050");
    // The key e goes to the next solar eclipse, that of 2009-07-22 (Espenak, NASA), which is outside the listed span: a new search lists it.
    window.state_mut().viewer.view.tdb_s = parse_time("2009-07-01T00:00:00Z").tdb_seconds_past_j2000();
    window.run_steps(2);
    window.event(Event::Text("e".into()));
    window.run_steps(40);
    assert!(has_details(&window));
    window.get_by_label_contains("Total solar eclipse, 2009-07-22 02:35 UTC");
}

/// The texts that a window paints, with the visible part of the rectangle of each of their rows. The rectangle of an entire text would not do: in a wrapping
/// row of controls, that of a label begins at the left margin, below the controls before the label.
pub(super) fn painted_texts(window: &Window) -> Vec<(String, Rect)> {
    fn walk(shape: &Shape, clip_rect: Rect, out: &mut Vec<(String, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, clip_rect, out)),
            Shape::Text(text) => out.extend(text.galley.rows.iter().map(|row| {
                let rect = row.rect_without_leading_space().translate(text.pos.to_vec2());
                (text.galley.job.text.clone(), rect.intersect(clip_rect))
            })),
            _ => {}
        }
    }
    let mut out = Vec::new();
    window.output().shapes.iter().for_each(|clipped| walk(&clipped.shape, clipped.clip_rect, &mut out));
    out
}

/// Pairs of texts that overlap by more than three points in both directions.
fn overlaps(texts: &[(String, Rect)]) -> Vec<[&str; 2]> {
    let overlap = |a: Rect, b: Rect| {
        let common = a.intersect(b);
        common.width() > 3.0 && common.height() > 3.0
    };
    let pairs = texts.iter().enumerate().flat_map(|(k, a)| texts[..k].iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| overlap(a.1, b.1)).map(|(a, b)| [a.0.as_str(), b.0.as_str()]).collect()
}

/// In a low window, rows of the list were once painted over the title and the date of the chosen event.
#[test]
fn the_list_and_the_details_share_a_low_window() {
    for height in [600.0, 480.0] {
        let mut window = window_without_images(NaifId::EARTH);
        window.set_size(egui::vec2(900.0, height));
        open_events(&mut window, "2027-08-01T15:00:00Z");
        window.get_by_label_contains("Total solar eclipse, 2027-08-02 10:0").click_accesskit();
        window.run_steps(10);
        let panel_left = window.get_by_label_contains("The sky:").rect().right();
        let texts: Vec<(String, Rect)> = painted_texts(&window).into_iter().filter(|(_, rect)| rect.left() >= panel_left).collect();
        // Of the list, the first row at least; of the details, the title.
        assert!(texts.iter().filter(|(text, rect)| text == "Total solar eclipse" && rect.height() > 10.0).count() == 2, "{texts:?}");
        assert!(overlaps(&texts).is_empty(), "at a height of {height}: {:?}", overlaps(&texts));
        // The last contact can be reached.
        window.get_by_label("C4").scroll_to_me();
        window.run_steps(90);
        let last_contact = window.get_by_label("C4").rect();
        assert!(painted_texts(&window).iter().any(|(text, rect)| text == "C4" && rect.height() > 10.0), "C4 is at {last_contact}");
    }
    // Negative control.
    let rect = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(50.0, 15.0));
    let texts =
        [("a", 0.0, 0.0), ("b", 40.0, 5.0), ("c", 0.0, -13.0)].map(|(text, x, y)| (text.to_owned(), rect.translate(egui::vec2(x, y))));
    assert_eq!(overlaps(&texts), [["b", "a"]]);
}

#[test]
fn kinds_and_direction_choose_what_is_listed() {
    let mut window = window_without_images(NaifId(499));
    open_events(&mut window, "2015-01-24T00:00:00Z");
    // Solar and lunar eclipses are on at first; then only events of moons are.
    for kind in [EventKind::Solar, EventKind::Lunar, EventKind::Moons] {
        window.get_by_role_and_label(Role::CheckBox, kind.name()).click();
        window.run_steps(2);
    }
    window.get_by_role_and_label(Role::ComboBox, "Range of the search").click();
    window.run_steps(2);
    window.get_by_label("month").click();
    window.run_steps(60);
    for moon in ["Io", "Europa", "Callisto"] {
        let name = format!("{moon}'s shadow on Jupiter, 2015-01-24 0");
        assert!(window.query_all_by_label_contains(&name).count() >= 1, "{name}");
    }
    // An empty selection is reported.
    window.get_by_role_and_label(Role::CheckBox, EventKind::Moons.name()).click();
    window.run_steps(2);
    window.get_by_label("Choose at least one kind of event.");
    window.get_by_role_and_label(Role::CheckBox, EventKind::Transit.name()).click();
    window.run_steps(3);
    window.get_by_label_contains("No event after");
    window.get_by_label("Before").click();
    window.get_by_role_and_label(Role::ComboBox, "Range of the search").click();
    window.run_steps(2);
    window.get_by_label("10 years").click();
    window.run_steps(20);
    // Nearest first: Venus in 2012, then Mercury in 2006.
    let row_tops =
        ["Transit of Venus, 2012-06-06 01:3", "Transit of Mercury, 2006-11-08"].map(|name| window.get_by_label_contains(name).rect().top());
    assert!(row_tops[0] < row_tops[1]);
}

/// Tasks that wait until a test runs them.
#[derive(Default)]
struct TaskQueue {
    tasks: Mutex<VecDeque<Task>>,
}

impl TaskQueue {
    fn run_next(&self) -> bool {
        let task = self.tasks.lock().expect("unpoisoned").pop_front();
        task.map(|task| task(session())).is_some()
    }
}

/// Draws nothing, and queues its tasks.
struct QueuingWorker(Arc<TaskQueue>);

impl RenderWorker for QueuingWorker {
    fn session(&self) -> &Session {
        session()
    }
    fn submit(&self, _: RenderJob) {}
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        None
    }
    fn run(&self, task: Task) {
        self.0.tasks.lock().expect("unpoisoned").push_back(task);
    }
}

/// A window with tasks that wait in a queue.
fn queuing_window(queue: &Arc<TaskQueue>) -> Window {
    let worker = QueuingWorker(Arc::clone(queue));
    let mut window: Window = Harness::builder()
        .with_size([1100.0, 900.0])
        .with_step_dt(1.0 / 60.0)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(
            move |ui, state| orrery::view::panels::Interface::ui(state, ui, &worker),
            interface(NaifId::EARTH, "2000-01-01T00:00:00Z"),
        );
    window.state_mut().tab = Some(Tab::Events);
    window.run_steps(3);
    window
}

/// *From this place* is disabled until the contacts of the chosen event have arrived; those of the event chosen before do not count.
#[test]
fn an_event_is_seen_from_a_place_only_once_its_own_contacts_are_known() {
    let queue: Arc<TaskQueue> = Arc::default();
    let mut window = queuing_window(&queue);
    // Both total eclipses of the Moon in 2000; that of January was visible in Greenwich (Espenak, NASA catalog of lunar eclipses).
    let [january, july] = ["Total lunar eclipse, 2000-01-21", "Total lunar eclipse, 2000-07-16"];
    let answer_all = |window: &mut Window| {
        while queue.run_next() {
            window.run_steps(2);
        }
    };
    let is_disabled = |window: &Window| window.get_by_label("From this place").accesskit_node().is_disabled();
    answer_all(&mut window);
    window.get_by_label_contains(january).click_accesskit();
    window.run_steps(4);
    answer_all(&mut window);
    assert!(!is_disabled(&window), "the contacts in January have arrived");
    let shown_s = window.state().viewer.view.tdb_s;
    window.get_by_label_contains(july).click_accesskit();
    let mut frames = 0;
    for _ in 0..6 {
        // The frame after the choice is the first that shows the other event.
        let is_chosen = window.state().viewer.view.tdb_s != shown_s;
        window.run_steps(1);
        assert!(!is_chosen || is_disabled(&window), "enabled by the contacts in January, {frames} frames after the choice");
        frames += u32::from(is_chosen);
    }
    assert!(frames > 2, "July was not chosen");
}

/// The step was searched before the language changed, and is shown after it.
#[test]
fn rows_are_in_the_language_in_which_they_are_shown() {
    let queue: Arc<TaskQueue> = Arc::default();
    let mut window = queuing_window(&queue);
    assert!(queue.run_next(), "no step was requested");
    window.state_mut().language = Language::German;
    window.run_steps(3);
    assert!(window.query_all_by_label_contains("Totale Mondfinsternis, ").count() > 0, "no row in German");
    assert_eq!(window.query_all_by_label_contains("eclipse, ").count(), 0, "a row in English");
}

#[test]
fn rows_do_not_move_while_a_search_goes_on_or_after_it_is_stopped() {
    let queue: Arc<TaskQueue> = Arc::default();
    let mut window = queuing_window(&queue);
    let rows = |window: &Window| -> Vec<(String, Rect)> {
        let named = window.query_all_by_role(Role::Button).filter_map(|n| Some((n.accesskit_node().label()?, n.rect())));
        named.filter(|(name, _)| name.contains("eclipse, ")).collect()
    };
    assert!(rows(&window).is_empty());
    let mut before = Vec::new();
    for step in 0..3 {
        assert!(queue.run_next(), "step {step} was not requested");
        window.run_steps(3);
        let now = rows(&window);
        // The third step may add nothing here, because the list shows only rows that fit into the panel.
        assert!(now.len() > before.len() || step == 2, "step {step} added nothing to {}", before.len());
        assert_eq!(now[..before.len()], before, "rows moved");
        before = now;
    }
    window.get_by_role_and_label(Role::ProgressIndicator, "Progress of the search");
    window.get_by_label("Stop").click();
    window.run_steps(3);
    while queue.run_next() {}
    window.run_steps(3);
    assert_eq!(rows(&window), before, "a stopped search goes on");
    assert!(window.query_by_label("Stop").is_none());
}
