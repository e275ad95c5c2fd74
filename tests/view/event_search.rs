//! The search for events: in steps, up to the ends of the ephemeris, and in a calendar year.

use crate::view::events::{between, greatest_tdb_s, open_events, parse_time};
use crate::view::input::window_without_images;
use crate::view::interface::session;
use crate::view::search::window_after_search;
use egui::Event;
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::view::app::event_search::{EventKind, EventSearch, events_between};

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
        assert!(why.contains("from -3001-11-23 to 3001-01-08"), "{why}");
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
    // The line above the list says why the list ends there.
    window.get_by_label_contains("from -3001-11-23 to 3001-01-08");
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
