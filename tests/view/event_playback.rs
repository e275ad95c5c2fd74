//! *Watch it* and animations of a whole event: time for totality; a rate that the user chooses; the end.

use crate::view::input::{Window, advance};
use crate::view::interface::session;
use crate::view::search::window_after_search;
use egui_kittest::kittest::Queryable;
use orrery::time::Instant;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::viewer::Action;

/// Greatest eclipse of 2026-08-12 (Espenak, NASA), with 2 min 18 s of totality there.
const GREATEST: &str = "2026-08-12T17:45:53Z";
/// Half the length of that totality, without the seconds by which the greatest phase may differ.
const HALF_TOTALITY_S: f64 = 65.0;

/// A window that plays the eclipse of 2026-08-12, from the place where it is greatest.
fn playing_window() -> Window {
    let mut window = window_after_search("eclipse 2026");
    window.get_by_label_contains("Total solar eclipse, 2026-08-12 17:4").click();
    window.run_steps(3);
    window.get_by_label("Watch it").click();
    window.run_steps(2);
    window
}

/// Seconds from the greatest phase to the displayed time.
fn after_greatest_s(window: &Window) -> f64 {
    let greatest = Instant::parse(GREATEST).expect("a time");
    window.state().viewer.view.tdb_s - greatest.tdb_seconds_past_j2000()
}

/// Totality passed in half a second, so that slow frames showed none of it. A click on *Pause* after the end started time again.
#[test]
fn totality_is_watched_for_ten_seconds_also_with_slow_frames() {
    let mut window = playing_window();
    // Frames of a second. At the rate of the partial phases, one of them takes longer than totality.
    assert!(window.state().viewer.time_rate.rate() > 4.0 * HALF_TOTALITY_S, "{}", window.state().viewer.time_rate.rate());
    let (mut frames, mut frames_in_totality) = (0, 0);
    while !window.state().viewer.time_rate.is_paused() {
        advance(&mut window, 1.0);
        frames += 1;
        frames_in_totality += usize::from(after_greatest_s(&window).abs() < HALF_TOTALITY_S);
        assert!(frames < 60, "the playback never ends");
    }
    assert!((8..13).contains(&frames_in_totality) && (26..36).contains(&frames), "{frames_in_totality} of {frames} frames");
    window.get_by_label("Pause").click();
    window.run_steps(3);
    assert!(window.state().viewer.time_rate.is_paused(), "a click on Pause started time");
    window.get_by_label("Play").click();
    window.run_steps(3);
    assert!(!window.state().viewer.time_rate.is_paused());
}

/// `eclipse find --at=43.37,-8.4` has 1m20s.
#[test]
fn the_details_state_how_long_totality_lasts_at_the_place() {
    let mut window = window_after_search("eclipse 2026");
    window.get_by_label_contains("Total solar eclipse, 2026-08-12 17:4").click();
    window.run_steps(3);
    // In Greenwich it is partial.
    assert!(window.query_by_label_contains("Totality lasts").is_none());
    for (field, degrees) in [("Latitude of the place, degrees north", 43.37), ("Longitude of the place, degrees east", -8.4)] {
        window.get_by_label(field).set_value_accesskit(degrees);
        window.run_steps(3);
    }
    window.get_by_label("Totality lasts 1 min 20 s.");
}

/// A user who slows time down during the partial phases keeps that rate in totality.
#[test]
fn a_rate_chosen_during_the_playback_stays() {
    let mut window = playing_window();
    window.state_mut().viewer.apply(Action::RunAt(60.0), 600.0, &SessionPositions(session()));
    let start_s = window.state().viewer.view.tdb_s - after_greatest_s(&window) - 2.0 * HALF_TOTALITY_S;
    window.state_mut().viewer.view.tdb_s = start_s;
    let mut has_been_in_totality = false;
    for _ in 0..6 {
        advance(&mut window, 0.5);
        assert_eq!(window.state().viewer.time_rate.rate(), 60.0);
        has_been_in_totality |= after_greatest_s(&window).abs() < HALF_TOTALITY_S;
    }
    assert!(has_been_in_totality, "{} s", after_greatest_s(&window));
}
