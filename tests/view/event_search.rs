//! The search for events: in steps, up to the ends of the ephemeris, and in a calendar year. Moons' events as seen from a place.

use crate::view::events::{between, greatest_tdb_s, open_events, painted_texts, parse_time};
use crate::view::input::window_without_images;
use crate::view::interface::session;
use crate::view::search::{search, window_after_search};
use egui::Event;
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::{Observer, ObserverSky};
use orrery::time::Instant;
use orrery::view::app::event_search::{EventFromPlace, EventKind, EventSearch, SkyEvent, events_between};
use orrery::view::app::settings::Home;

const JUPITER: NaifId = NaifId(599);

/// Whether two lists have the same events. An event near the end of a step is refined from another starting value, so its time may differ by less than a
/// second.
fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1.0)
}

/// A search in steps finds the same events as a single search over the whole span, in either direction.
#[test]
fn a_search_in_steps_finds_each_event_once_and_nearest_first() {
    for (kinds, from, to) in [
        (vec![EventKind::Solar, EventKind::Lunar], "2000-01-01", "2030-01-01"),
        (vec![EventKind::Transit], "1990-01-01", "2020-01-01"),
        (vec![EventKind::Moons], "2015-01-20", "2015-02-03"),
        (EventKind::ALL.to_vec(), "2015-03-15", "2015-03-25"),
    ] {
        let expected: Vec<f64> = between(&kinds, from, to).iter().map(greatest_tdb_s).collect();
        // Ten days hold few events, even of all kinds.
        assert!(expected.len() > 3 || kinds.len() > 2 && !expected.is_empty(), "{kinds:?}: {}", expected.len());
        let reach_s = parse_time(to).tdb_seconds_past_j2000() - parse_time(from).tdb_seconds_past_j2000();
        for backward in [false, true] {
            let mut search = EventSearch::new(kinds.clone(), parse_time(if backward { to } else { from }), reach_s, backward);
            let (mut found, mut progress) = (Vec::new(), -1.0);
            while !search.is_over() {
                found.extend(search.step(session().catalog(), session().ephemeris()).iter().map(greatest_tdb_s));
                assert!(search.progress() > progress, "{kinds:?}: no progress at {progress}");
                progress = search.progress();
            }
            assert_eq!((progress, search.failure()), (1.0, None));
            if backward {
                found.reverse();
            }
            assert!(are_same(&found, &expected), "{kinds:?}, backward {backward}: {found:?} instead of {expected:?}");
        }
    }
    assert!(EventSearch::new(Vec::new(), parse_time("2000-01-01"), 1e9, false).is_over(), "an empty search never ends");
}

/// A step that reached beyond the ephemeris once failed as a whole, so that the last years before its end seemed to be without events.
#[test]
fn the_events_before_the_ends_of_the_ephemeris_are_found() {
    const CENTURY_S: f64 = 36_525.0 * 86_400.0;
    let (catalog, ephemeris) = (session().catalog(), session().ephemeris());
    let kinds = [EventKind::Solar, EventKind::Lunar];
    // The series have the Earth from -3001-11-23 to 3001-01-08. Eclipses are in spring and autumn in these years.
    for (start, end, is_backward) in [("2999-12-30", "3001-01-01", false), ("-2998-06-01", "-3001-12-05", true)] {
        let (from, to) = if is_backward { (end, start) } else { (start, end) };
        let mut expected: Vec<f64> = between(&kinds, from, to).iter().map(greatest_tdb_s).collect();
        if is_backward {
            expected.reverse();
        }
        assert!(expected.len() > 4, "{start}: {} events", expected.len());
        let mut search = EventSearch::new(kinds.to_vec(), parse_time(start), CENTURY_S, is_backward);
        let (mut found, mut steps) = (Vec::new(), 0);
        while !search.is_over() {
            found.extend(search.step(catalog, ephemeris).iter().map(greatest_tdb_s));
            steps += 1;
            assert!(steps < 30, "{start}: no end");
        }
        assert!(are_same(&found, &expected), "{start}: {found:?} instead of {expected:?}");
        let why = search.failure().expect("the ephemeris ends first").to_string();
        // An end on the day of the failed step has its time of day.
        assert!(why.contains("from -3001-11-23") && why.contains(" to 3001-01-08"), "{why}");
        // Negative control: a search of the whole span fails.
        let century_end = parse_time(start).plus_seconds(if is_backward { -CENTURY_S } else { CENTURY_S });
        let (from, to) = if is_backward { (century_end, parse_time(start)) } else { (parse_time(start), century_end) };
        assert!(events_between(catalog, ephemeris, &kinds, from, to).is_err());
    }
}

/// In the window: by the key, which then says why there is no further event, and in the list of the Events panel.
#[test]
fn the_window_finds_the_last_eclipses_of_the_ephemeris() {
    let mut window = window_without_images(NaifId::EARTH);
    window.state_mut().viewer.view.tdb_s = parse_time("3000-08-01T00:00:00Z").tdb_seconds_past_j2000();
    for has_event in [true, false] {
        window.run_steps(2);
        window.event(Event::Text("e".into()));
        window.run_steps(5);
        let after_eclipse_s = window.state().viewer.view.tdb_s - parse_time("3000-10-19T16:08:58Z").tdb_seconds_past_j2000();
        assert!(after_eclipse_s.abs() < 10.0, "{after_eclipse_s} s after the hybrid eclipse");
        let message = window.state().message_line();
        assert_eq!(message.contains("from -3001-11-23 to 3001-01-08"), !has_event, "{message}");
    }
    let mut window = window_without_images(NaifId::EARTH);
    open_events(&mut window, "2999-12-30T00:00:00Z");
    for event in ["Total solar eclipse, 3000-04-26 14:1", "Hybrid solar eclipse, 3000-10-19 16:0"] {
        assert!(window.query_by_label_contains(event).is_some(), "{event} is not listed");
    }
    // The line below the list says why the list ends there. It was cut after one row.
    window.get_by_label_contains("from -3001-11-23 to 3001-01-08");
    let rows = painted_texts(&window).into_iter().filter(|(text, _)| text.contains("from -3001-11-23 to 3001-01-08"));
    assert!(rows.count() > 1, "the reason does not wrap");
    window.get_by_label_contains(" events after 2999-12-30 00:00 UTC");
}

/// A year once had 365.25 days, so that the last 18 hours of a leap year were left out.
#[test]
fn a_leap_year_is_searched_to_its_end() {
    let window = window_after_search("lunar eclipse 2028");
    window.get_by_label_contains("3 events after 2028-01-01 00:00 UTC");
    // Espenak and Meeus, canon of lunar eclipses: total on 2028-12-31, greatest at 16:52.
    window.get_by_label_contains("Total lunar eclipse, 2028-12-31 16:5");
    // Negative control: the eclipse is later than 365.25 days after the start of the year.
    let (start, length_s) = (parse_time("2028-01-01"), 365.25 * 86_400.0);
    let found = events_between(session().catalog(), session().ephemeris(), &[EventKind::Lunar], start, start.plus_seconds(length_s));
    assert_eq!(found.expect("within the theories").len(), 2);
}

/// The first event of a day with this title.
fn moons_event(title: &str, day: &str, next_day: &str) -> SkyEvent {
    let mut events = between(&[EventKind::Moons], day, next_day).into_iter();
    events.find(|event| event.title(session().catalog()) == title).expect(title)
}

/// Altitude of Jupiter's centre at a place, degrees, without refraction.
fn jupiter_altitude_deg(home: Home, time: Instant) -> f64 {
    let place = Observer { body: NaifId::EARTH, lat_graphic_deg: home.latitude_deg, lon_east_deg: home.longitude_deg, height_km: 0.0 };
    let sky = ObserverSky { catalog: session().catalog(), ephemeris: session().ephemeris(), place };
    sky.topocentric(JUPITER, time).expect("a place").altitude_deg
}

fn seen_from(event: &SkyEvent, home: Home) -> EventFromPlace {
    event.seen_from(session().catalog(), session().ephemeris(), home).expect("a place")
}

/// In Greenwich Jupiter rose 50 minutes after the middle of this transit of Callisto. *From this place* showed the ground at the middle of the event, and
/// *Watch it* began three hours before Jupiter rose.
#[test]
fn a_moons_event_is_shown_while_its_planet_is_up() {
    let transit = moons_event("Callisto in front of Jupiter", "2026-12-11", "2026-12-12");
    let seen = seen_from(&transit, Home::default());
    let maximum = seen.contacts.iter().find(|contact| contact.name == "maximum").expect("a maximum");
    // Jupiter rises when its centre is at -34 arcmin.
    let rise_deg = -34.0 / 60.0;
    assert!(seen.is_visible && maximum.is_up && (maximum.altitude_deg - rise_deg).abs() < 0.01, "{maximum:?}");
    // Negative control: the middle is below the horizon, as is the first contact.
    assert!(jupiter_altitude_deg(Home::default(), transit.greatest()) < -5.0 && !seen.contacts[0].is_up, "{seen:?}");
    let mut window = window_without_images(JUPITER);
    window.state_mut().viewer.view.tdb_s = parse_time("2026-12-11T18:00:00Z").tdb_seconds_past_j2000();
    search(&mut window, "jupiter moons");
    window.run_steps(10);
    window.get_by_label_contains("Callisto in front of Jupiter, 2026-12-11").click_accesskit();
    window.run_steps(3);
    window.get_by_label("From this place").click_accesskit();
    window.run_steps(3);
    let shown_deg = jupiter_altitude_deg(Home::default(), window.state().viewer.view.time());
    assert!((shown_deg - rise_deg).abs() < 0.01, "Jupiter at {shown_deg} degrees");
    window.get_by_label("Watch it").click_accesskit();
    window.run_steps(3);
    // The playback begins before the rise by a twentieth of the 95 minutes until the last contact. Jupiter rises by less than 0.25 degrees a minute.
    let start_deg = jupiter_altitude_deg(Home::default(), window.state().viewer.view.time());
    assert!(start_deg > rise_deg - 0.25 * 95.0 / 20.0, "Jupiter at {start_deg} degrees");
}

/// At the polar circle Jupiter was above the horizon for two hours between two contacts of this event, which was called invisible.
#[test]
fn a_moons_event_is_visible_between_contacts_below_the_horizon() {
    let shadow = moons_event("Ganymede's shadow on Jupiter", "2031-09-09", "2031-09-10");
    let home = Home { latitude_deg: 67.0, longitude_deg: -95.7 };
    let seen = seen_from(&shadow, home);
    let (maxima, contacts): (Vec<_>, Vec<_>) = seen.contacts.iter().partition(|contact| contact.name == "maximum");
    assert!(seen.is_visible && maxima.len() == 1 && maxima[0].is_up && maxima[0].time == shadow.greatest(), "{seen:?}");
    // Negative control: by the contacts alone, it is invisible.
    assert!(contacts.len() == 4 && contacts.iter().all(|contact| !contact.is_up), "{contacts:?}");
    let (rise, set) = (seen.rise.expect("a rise"), seen.set.expect("a set"));
    for (time, is_up) in [(rise.plus_seconds(-300.0), false), (rise.plus_seconds(300.0), true), (set.plus_seconds(300.0), false)] {
        assert_eq!(jupiter_altitude_deg(home, time) > -34.0 / 60.0, is_up, "{time:?}");
    }
    // On the other side of the Earth, Jupiter is below the horizon.
    let opposite = seen_from(&shadow, Home { longitude_deg: 84.3, ..home });
    assert_eq!(opposite.contacts.len(), seen.contacts.len());
    assert!(!opposite.is_visible && opposite.contacts.iter().all(|contact| !contact.is_up), "{opposite:?}");
}
