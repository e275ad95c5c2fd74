//! Ready-made views (presets): how they are found, by search and in the Moments panel; what they show; what of them later views keep.

use crate::view::input::{Window, advance, window_without_images};
use crate::view::interface::session;
use crate::view::search::{MARS, search, window_after_search};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::{Observer, ObserverSky};
use orrery::time::Instant;
use orrery::view::app::body_positions::{BodyPositions, SessionPositions};
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::presets::Preset;
use orrery::view::app::search::{SearchTarget, suggestions};
use orrery::view::app::settings::Home;
use orrery::view::app::view_state::{CameraPose, ViewState};
use orrery::view::app::what_to_see_now::NowItem;
use orrery::view::panels::Tab;

fn base_view() -> ViewState {
    window_without_images(MARS).state().viewer.view.clone()
}

fn targets(text: &str) -> Vec<SearchTarget> {
    let window = window_without_images(MARS);
    suggestions(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8).into_iter().map(|s| s.target).collect()
}

#[test]
fn search_finds_views_by_everyday_words() {
    for (text, target) in [
        ("whole system", SearchTarget::Preset(Preset::WholeSystem)),
        ("solar system", SearchTarget::Preset(Preset::WholeSystem)),
        ("Sonnensystem", SearchTarget::Preset(Preset::WholeSystem)),
        ("inner planets", SearchTarget::Preset(Preset::InnerSystem)),
        ("moon phases", SearchTarget::Preset(Preset::MoonPhases)),
        ("night sky", SearchTarget::Preset(Preset::SkyTonight)),
        ("the sky", SearchTarget::Preset(Preset::SkyTonight)),
        ("moon tonight", SearchTarget::WhatToSeeNow(NowItem::Moon)),
        ("saturn now", SearchTarget::WhatToSeeNow(NowItem::Saturn)),
    ] {
        assert_eq!(targets(text).first(), Some(&target), "{text}");
    }
    assert_eq!(targets("moon").first(), Some(&SearchTarget::Body(NaifId::MOON)), "a body comes first");
    assert!(targets("whole nonsense").is_empty());
}

/// On the Earth, *Stand on surface* uses the observer's place, as do events, rise and set; other bodies have a place of their own.
#[test]
fn stand_on_surface_uses_the_observers_place_on_earth_only() {
    let stand = |window: &mut Window, body: NaifId| {
        window.state_mut().viewer.selected = body;
        window.run_steps(3);
        window.get_by_label("Stand on surface").click_accesskit();
        window.run_steps(3);
        let CameraPose::Ground { latitude_deg, .. } = window.state().viewer.view.camera_pose else { panic!("not on the ground") };
        latitude_deg
    };
    // A search for a city, here Mazatlán, sets the observer's place.
    let mut window = window_after_search("mazat");
    assert!((stand(&mut window, NaifId::EARTH) - 23.2).abs() < 0.1);
    assert_eq!(stand(&mut window, MARS), 0.0);
}

/// Most planets have longitudes from 0 to 360 degrees: 200 degrees east is not 180 degrees, but 160 degrees west.
#[test]
fn a_typed_longitude_beyond_half_a_turn_is_the_same_meridian() {
    for (body, typed_deg, longitude_deg) in
        [(MARS, 200.0, -160.0), (MARS, -350.0, 10.0), (MARS, 33.0, 33.0), (NaifId::EARTH, 200.0, -160.0)]
    {
        let mut window = window_without_images(body);
        window.get_by_label("Longitude (E), degrees").set_value_accesskit(typed_deg);
        window.run_steps(3);
        window.get_by_label("Stand on surface").click_accesskit();
        window.run_steps(3);
        let CameraPose::Ground { longitude_deg: stood_deg, .. } = window.state().viewer.view.camera_pose else {
            panic!("not on the ground")
        };
        assert!((stood_deg - longitude_deg).abs() < 1e-9, "{body:?}, {typed_deg}: {stood_deg}");
        if body == NaifId::EARTH {
            assert_eq!(window.state().settings.home.longitude_deg, longitude_deg);
        }
    }
}

#[test]
fn the_system_is_seen_from_above_with_its_orbits() {
    let window = window_after_search("whole system");
    let view = &window.state().viewer.view;
    let CameraPose::Orbit { body: NaifId::SUN, elevation_deg, .. } = view.camera_pose else { panic!("{:?}", view.camera_pose) };
    assert!((elevation_deg - 40.0).abs() < 1e-9 && view.orbits && view.target == NaifId::SUN);
    // The button in the Moments panel leads to the same view.
    let mut window = window_without_images(MARS);
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(3);
    window.get_by_label("Whole solar system").click_accesskit();
    window.run_steps(3);
    assert_eq!(window.state().viewer.view.camera_pose, view.camera_pose);
}

#[test]
fn moon_phases_run_at_a_day_per_second() {
    let window = window_after_search("moon phases");
    let viewer = &window.state().viewer;
    assert_eq!((viewer.view.target, viewer.view.camera_pose), (NaifId::MOON, CameraPose::Centre { body: NaifId::EARTH }));
    assert_eq!(viewer.time_rate.rate(), 86_400.0);
}

/// The next view does not inherit the orbits, layers, exposure and rate of time that a preset has set, unless the user has changed them. Only a search for a
/// body, which flies there, keeps the orbits.
#[test]
fn the_next_view_does_not_inherit_what_a_preset_has_set() {
    let mut window = window_after_search("whole system");
    assert!(window.state().viewer.view.exposure_stops.is_some());
    search(&mut window, "saturn");
    let goal = window.state().viewer.view_after_flight();
    assert_eq!((goal.orbits, goal.exposure_stops), (true, None));
    for (first, next) in [("whole system", "sky tonight"), ("sky tonight", "moon phases"), ("moon phases", "moon tonight")] {
        let mut window = window_after_search(first);
        search(&mut window, next);
        let view = &window.state().viewer.view;
        let is_sky = next == "sky tonight";
        assert_eq!((view.orbits, view.exposure_stops), (false, None), "{first}, {next}");
        assert_eq!((view.layers.constellations, view.stars_boost > 0.0), (is_sky, is_sky), "{first}, {next}");
        assert_eq!(window.state().viewer.time_rate.rate(), if next == "moon phases" { 86_400.0 } else { 1.0 }, "{first}, {next}");
    }
    // An exposure that the user has changed is kept.
    let mut window = window_after_search("whole system");
    window.state_mut().viewer.view.exposure_stops = Some(5.0);
    search(&mut window, "saturn");
    assert_eq!(window.state().viewer.view_after_flight().exposure_stops, Some(5.0));
}

/// *Back* returns to a preset's view as it was, with the exposure and the stars that the preset has set. The list of recent views stores the same view.
#[test]
fn back_returns_to_a_presets_view_as_it_was() {
    for (preset, exposure_stops, stars_boost) in [("whole system", Some(2.0), 0.0), ("sky tonight", None, 2.0)] {
        let mut window = window_after_search(preset);
        for body in ["saturn", "jupiter"] {
            search(&mut window, body);
            let goal = window.state().viewer.view_after_flight();
            assert_eq!((goal.exposure_stops, goal.stars_boost), (None, 0.0), "{preset}, {body}");
            let recent = &window.state().settings.recent[0].view;
            assert_eq!((recent.exposure_stops, recent.stars_boost), (exposure_stops, stars_boost), "{preset}, {body}");
            window.get_by_label("Back").click_accesskit();
            window.run_steps(3);
            let view = &window.state().viewer.view;
            assert_eq!((view.exposure_stops, view.stars_boost), (exposure_stops, stars_boost), "{preset}, {body}");
        }
    }
}

/// A preset's changes are undone once: an exposure that the user sets afterwards is kept.
#[test]
fn a_presets_changes_are_undone_only_once() {
    let mut window = window_without_images(MARS);
    window.state_mut().viewer.view.exposure_stops = Some(12.0);
    search(&mut window, "moon phases");
    assert_eq!(window.state().viewer.view.exposure_stops, None);
    search(&mut window, "saturn");
    assert_eq!(window.state().viewer.view_after_flight().exposure_stops, Some(12.0), "the user's exposure returns");
    advance(&mut window, 3.0);
    assert!(!window.state().viewer.is_flying());
    window.state_mut().viewer.view.exposure_stops = None;
    search(&mut window, "jupiter");
    assert_eq!(window.state().viewer.view_after_flight().exposure_stops, None);
}

/// The sky of tonight is shown when the Sun is at least 15 degrees below the horizon, if it gets so low. The view is at most a day later than now, and looks
/// above the horizon towards the equator's side.
#[test]
fn the_sky_tonight_is_dark() {
    let positions = SessionPositions(session());
    let base_view = base_view();
    for latitude_deg in [51.4769_f64, -33.9, 0.0, 78.2] {
        for (day, sun_declination_deg) in
            [("2026-03-20T12:00:00Z", 0.0_f64), ("2026-06-21T03:00:00Z", 23.4), ("2026-12-21T22:00:00Z", -23.4)]
        {
            let home = Home { latitude_deg, longitude_deg: 18.4 };
            let now = Instant::parse(day).expect("a time");
            let view = Preset::SkyTonight.view(&positions, now, home, &base_view).expect("a view");
            let waited_s = view.tdb_s - now.tdb_seconds_past_j2000();
            assert!((0.0..=86_400.0).contains(&waited_s), "{latitude_deg} {day}");
            let place = Observer { body: NaifId::EARTH, lat_graphic_deg: latitude_deg, lon_east_deg: 18.4, height_km: 0.0 };
            let sky = ObserverSky { catalog: session().catalog(), ephemeris: session().ephemeris(), place };
            let sun = sky.topocentric(NaifId::SUN, view.time()).expect("the Sun");
            // The Sun's altitude at its lower culmination. At 51 degrees north in June this is so close to -15 degrees that the search in steps may miss it.
            let lowest_deg = (latitude_deg + sun_declination_deg).abs() - 90.0;
            let gets_dark = lowest_deg < -16.0;
            assert!(!gets_dark || sun.altitude_deg < -14.9, "{latitude_deg} {day}: {}", sun.altitude_deg);
            let CameraPose::Ground { azimuth_deg, altitude_deg, .. } = view.camera_pose else { panic!("not on the ground") };
            assert_eq!(azimuth_deg, if latitude_deg < 0.0 { 0.0 } else { 180.0 });
            assert!(altitude_deg - 0.5 * view.fov_deg > 0.0, "the image reaches below the horizon");
            assert!(view.layers.constellations);
        }
    }
    // A date outside the ephemeris has no view.
    let too_late = Instant::from_tdb_seconds_past_j2000(1e13);
    assert!(positions.geometric_vector_km(NaifId::EARTH, NaifId::SUN, too_late).is_none());
    for preset in [Preset::WholeSystem, Preset::InnerSystem, Preset::SkyTonight] {
        assert!(preset.view(&positions, too_late, Home::default(), &base_view).is_none(), "{preset:?}");
    }
}
