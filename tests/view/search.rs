//! The search field: each kind of answer leads to its place, and similar names are offered.

use crate::support::session::session_over;
use crate::view::input::{Window, type_text, window_without_images};
use crate::view::interface::{interface, session};
use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::catalog::stars::STAR_NAMES;
use orrery::scene::request::{Axes, Look};
use orrery::session::Session;
use orrery::time::Instant;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::event_search::EventKind;
use orrery::view::app::search::{SearchTarget, similar_texts, suggestions};
use orrery::view::app::sky_target::star_view;
use orrery::view::app::view_state::CameraPose;
use orrery::view::language::Language;
use orrery::view::panels::{Interface, Tab};
use orrery::view::worker::render_worker::InlineWorker;

pub(super) const MARS: NaifId = NaifId(499);

pub(super) fn search(window: &mut Window, text: &str) {
    type_text(window, "/");
    type_text(window, text);
    window.key_press(Key::Enter);
    window.run_steps(3);
}

pub(super) fn window_after_search(text: &str) -> Window {
    let mut window = window_without_images(MARS);
    search(&mut window, text);
    window
}

#[test]
fn dates_in_many_forms_set_the_time() {
    for text in ["8 April 2024", "april 8 2024", "2024-04-08", "8.4.2024", "Apr 8, 2024 00:00 UTC"] {
        let window = window_after_search(text);
        assert_eq!(window.state().viewer.view.time().to_utc_iso(), "2024-04-08T00:00:00Z", "{text}");
        assert_eq!(window.state().viewer.view.target, MARS, "{text}");
    }
    // The clock of the test is at J2000.
    assert_eq!(window_after_search("now").state().viewer.view.tdb_s, 0.0);
}

/// An effect has the name that the Effects panel shows, in German too.
#[test]
fn effects_are_found_by_their_names_in_the_language_of_the_window() {
    let mut window = window_without_images(MARS);
    window.state_mut().language = Language::German;
    window.run_steps(2);
    search(&mut window, "Ringschatten");
    assert_eq!(window.state().tab, Some(Tab::Effects));
}

#[test]
fn each_kind_of_answer_leads_to_its_target() {
    let events = window_after_search("eclipse 2027");
    assert_eq!(events.state().tab, Some(Tab::Events));
    // Total in Spain and Egypt on 2027-08-02 (Espenak and Meeus, canon of solar eclipses).
    events.get_by_label_contains("Total solar eclipse, 2027-08-02 10:0");
    events.get_by_label_contains("events after 2027-01-01 00:00 UTC");
    let venus = window_after_search("transit of venus 2012");
    venus.get_by_label_contains("Transit of Venus, 2012-06-06");
    // German words for events are understood in either language.
    for phrase in ["venustransit 2012", "transit von venus 2012"] {
        window_after_search(phrase).get_by_label_contains("Transit of Venus, 2012-06-06");
    }
    assert_eq!(window_after_search("ring-shadow").state().tab, Some(Tab::Effects));
    let switched = window_after_search("-ring-shadow");
    assert_eq!(switched.state().viewer.view.effects.to_text(), "-ring-shadow");
    // Mars has no rings, so only the reply shows that something happened.
    assert!(switched.state().reply_text().contains(": -ring-shadow"), "{}", switched.state().reply_text());
    assert_eq!(window_after_search("lambert.albedo.sun1.ellipsoid").state().tab, Some(Tab::Shader));
    let moment = window_after_search("great conj");
    assert!(moment.state().viewer.view.time().to_utc_iso().starts_with("2020-12-21T18:2"));
    let on_ground = window_after_search("51.5, -0.1");
    let pose = on_ground.state().viewer.view.camera_pose;
    assert!(
        matches!(pose, CameraPose::Ground { body: MARS, latitude_deg: 51.5, longitude_deg, .. } if (longitude_deg + 0.1).abs() < 1e-9),
        "{pose:?}"
    );
    assert_eq!(window_after_search("titan").state().viewer.view_after_flight().target, NaifId(606));
    // A city is on the Earth, whatever is selected, and becomes the observer's place for events.
    let city = window_after_search("mazat");
    let state = city.state();
    let CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, .. } = state.viewer.view.camera_pose else {
        panic!("not on the Earth")
    };
    // The port's lighthouse on Cerro del Creston: 23.177 N, 106.427 W.
    assert!((latitude_deg - 23.2).abs() < 0.1 && (longitude_deg + 106.4).abs() < 0.1, "{latitude_deg} {longitude_deg}");
    city.get_by_label_contains("events, rise and set now refer to this place");
    // A crater is viewed from above: Tycho, 43.3 S 11.2 W (gazetteer of the IAU).
    let tycho = window_after_search("tycho");
    let view = &tycho.state().viewer.view;
    let CameraPose::Orbit { body: NaifId::MOON, is_body_fixed: true, azimuth_deg, elevation_deg, .. } = view.camera_pose else {
        panic!("{view:?}")
    };
    assert!(
        (elevation_deg + 43.3).abs() < 0.1 && ((azimuth_deg + 11.2 + 180.0).rem_euclid(360.0) - 180.0).abs() < 0.1,
        "{azimuth_deg} {elevation_deg}"
    );
    // A star is no target for the camera: the view is from near the Earth.
    let vega = window_after_search("vega");
    assert_eq!((vega.state().viewer.view.target, vega.state().viewer.view.fov_deg), (NaifId::EARTH, 20.0));
}

/// A window over a session of its own, whose catalog has a moment beyond the ephemeris and one inside its range.
fn window_with_moments() -> Window {
    let folder = tempfile::tempdir().expect("a folder");
    let moment = |name: &str, time: &str| {
        format!(
            "[[moment]]\nname = \"{name}\"\nkind = \"photograph\"\ntime = \"{time}\"\ntarget = \"Moon\"\nside = \"Sun\"\nradii = 5.0\n\
             about = \"Nothing.\"\nsource = \"invented\"\n"
        )
    };
    let moments = moment("Qwerty beyond", "9000-05-05T00:00:00Z") + &moment("Qwerty inside", "2010-05-05T00:00:00Z");
    std::fs::write(folder.path().join("own.toml"), moments).expect("written");
    let session: &'static Session = Box::leak(Box::new(session_over(folder.path()).0));
    let worker = InlineWorker::new(session);
    Harness::builder()
        .with_size([1100.0, 600.0])
        .with_max_steps(40)
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface(MARS, "2017-05-17T00:00:00Z"))
}

/// The reason why a view is not shown ends with the next view, about which it would seem to be; other replies stay.
#[test]
fn a_chosen_view_ends_the_refusal_of_another_one() {
    let mut window = window_with_moments();
    window.run_steps(3);
    for next in ["qwerty inside", "titan", "2020-01-01", "51.5, -0.1"] {
        search(&mut window, "qwerty beyond");
        assert_eq!(window.state().reply_text(), "Qwerty beyond: outside the range of the ephemeris");
        search(&mut window, next);
        assert_eq!(window.state().reply_text(), "", "{next}");
    }
    // Negative control.
    search(&mut window, "-ring-shadow");
    search(&mut window, "titan");
    assert!(window.state().reply_text().contains(": -ring-shadow"), "{}", window.state().reply_text());
}

#[test]
fn misspelled_words_of_searches_are_corrected() {
    let window = window_without_images(MARS);
    let similar = |text: &str| similar_texts(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc);
    assert_eq!(similar("eclpse 2027"), ["eclipses 2027"]);
    assert_eq!(similar("lunr eclipse"), ["lunar eclipses"]);
    assert_eq!(similar("moon phasses"), ["moon phases"]);
    assert_eq!(similar("solar sistem"), ["solar system"]);
    assert_eq!(similar("indianapolus"), ["Indianapolis"]);
    assert_eq!(similar("satrun").first().map(String::as_str), Some("Saturn"));
    // A body's name is also a word of searches; both spellings of it were once offered.
    for (text, name) in [("jupterr", "Jupiter"), ("/sun", "Sun"), ("merkury", "Mercury")] {
        let found = similar(text);
        let count = found.iter().filter(|found| found.eq_ignore_ascii_case(name)).count();
        assert!(found.contains(&name.to_owned()) && count == 1, "{text}: {found:?}");
    }
    assert!(similar("zz 9").is_empty() && similar("").is_empty());
}

/// The view of every named star looks in the star's direction at the time of the view, with proper motion: in 1950 and in 2050.
#[test]
fn a_star_is_in_the_middle_of_its_image() {
    const MAX_DEG: f64 = 0.01;
    let (catalog, stars, places) = (session().catalog(), session().catalog().stars(), SessionPositions(session()));
    let mut view = window_without_images(MARS).state().viewer.view.clone();
    let mut moved = 0;
    for (year, utc) in [(1950.0, "1950-01-01"), (2050.0, "2050-01-01")] {
        view.tdb_s = Instant::parse(utc).expect(utc).tdb_seconds_past_j2000();
        for (name, hip) in STAR_NAMES {
            let star = stars.star_of_hip(hip).expect(name);
            let years = stars.years_since_epoch(view.time().jd_tt());
            assert!((years - (year - 1991.25)).abs() < 0.1);
            let request =
                star_view(star, years, &places, &view).expect(name).request(catalog, session().ephemeris(), 200, 100).expect(name);
            let Look::Along { direction, axes: Axes::Icrf } = request.look else { panic!("{name}: {:?}", request.look) };
            let direction_at_date = (star.direction + star.motion_per_year * years).normalize();
            let error_deg = |direction| orrery::ephemeris::angle_rad(direction, direction_at_date).to_degrees();
            assert!(error_deg(direction) < MAX_DEG, "{name}");
            moved += usize::from(error_deg(star.direction) > MAX_DEG);
        }
    }
    // Negative control: Arcturus moves by 2.3 arcsec per year, so without its proper motion it is off by 90 arcsec or more.
    assert!(moved > 0, "no star moves by {MAX_DEG} degrees");
}

#[test]
fn the_likeliest_meaning_is_suggested_first() {
    let window = window_without_images(MARS);
    let first = |text: &str| {
        suggestions(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8).into_iter().next().map(|s| s.target)
    };
    assert_eq!(first("mars"), Some(SearchTarget::Body(MARS)));
    assert_eq!(first("moon"), Some(SearchTarget::Body(NaifId::MOON)));
    assert_eq!(first("sirius"), Some(SearchTarget::Star(32_349)));
    assert_eq!(first("HIP 32349"), Some(SearchTarget::Star(32_349)));
    assert!(matches!(first("lunar eclipse"), Some(SearchTarget::Events { start: None, kinds }) if kinds.len() == 1));
    assert!(matches!(first("next solar eclipse"), Some(SearchTarget::Events { .. })));
    for of_moons in ["moons of jupiter", "eclipses of the moons of jupiter", "jupiter transit", "shadow transit"] {
        assert!(matches!(first(of_moons), Some(SearchTarget::Events { kinds, .. }) if kinds == [EventKind::Moons]), "{of_moons}");
    }
    assert!(matches!(first("2024-04-08T18:17:16Z"), Some(SearchTarget::Time(_))));
    for nothing in ["", "  ", "nowhere", "zz 9", "91, 0", "hip 999999", "."] {
        assert_eq!(first(nothing), None, "{nothing}");
    }
    assert!(suggestions("a", &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8).len() <= 8);
}

/// Only a year was understood; a date, which is what one has in hand, was called unknown, and a place, too.
#[test]
fn events_are_found_by_their_date_and_a_place_is_explained() {
    let window = window_without_images(MARS);
    let found = |text: &str| suggestions(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8);
    let start_of = |text: &str| match found(text).first().map(|s| s.target.clone()) {
        Some(SearchTarget::Events { kinds, start: Some(start) }) => (start.to_utc_iso(), kinds.len()),
        other => panic!("{text}: {other:?}"),
    };
    for (text, start, kind_count) in [
        ("eclipse 2026-08-12", "2026-08-12T00:00:00Z", 2),
        ("2026-08-12 eclipse", "2026-08-12T00:00:00Z", 2),
        ("solar eclipse 12 August 2026", "2026-08-12T00:00:00Z", 1),
        ("eclipse on August 12, 2026 17:45", "2026-08-12T00:00:00Z", 2),
        ("Sonnenfinsternis am 12. August 2026", "2026-08-12T00:00:00Z", 1),
        ("eclipse august 2026", "2026-08-01T00:00:00Z", 2),
        ("eclipse 2026-08", "2026-08-01T00:00:00Z", 2),
        ("eclipse 2026", "2026-01-01T00:00:00Z", 2),
        ("transit nov 2032", "2032-11-01T00:00:00Z", 1),
    ] {
        assert_eq!(start_of(text), (start.to_owned(), kind_count), "{text}");
    }
    assert!(found("eclipse nonsense 2026").is_empty() && found("august nonsense").is_empty());
    // A day alone means the day, and offers its events.
    let of_day = found("2026-08-12");
    assert!(matches!(of_day[0].target, SearchTarget::Time(_)), "{of_day:?}");
    assert!(matches!(&of_day[1].target, SearchTarget::Events { start: Some(_), kinds } if kinds.len() == 3), "{of_day:?}");
    assert!(!found("2027").iter().any(|s| matches!(s.target, SearchTarget::Events { .. })));
    let day = window_after_search("eclipse 12 August 2026");
    day.get_by_label_contains("Total solar eclipse, 2026-08-12 17:4");
    // The built-in moment of that eclipse is found by any of its words.
    assert!(matches!(&found("eclipse spain")[..], [moment] if matches!(moment.target, SearchTarget::Moment(_))));
    window_after_search("eclipse france").get_by_label_contains("events are found by kind and date");
}

/// A date of history books was read in the Gregorian calendar, without a word, and missed its eclipse by six days.
#[test]
fn a_date_before_the_gregorian_calendar_finds_its_eclipse() {
    let window = window_without_images(MARS);
    let found = suggestions("28 May 585 BC", &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8);
    let [date, events, ..] = &found[..] else { panic!("{found:?}") };
    assert_eq!(date.name, "28 May 585 BC (Julian) = -0584-05-22 00:00 UTC (Gregorian)");
    assert!(
        matches!(&events.target, SearchTarget::Events { start: Some(_), .. }) && events.name.contains("from -0584-05-22"),
        "{events:?}"
    );
    // ISO 8601 and the date field are Gregorian.
    for iso in ["-0584-05-22", "22.05.585 BC"] {
        let found = suggestions(iso, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8);
        assert_eq!(found.first().map(|s| s.name.as_str()), Some("-0584-05-22 00:00 UTC"), "{iso}");
    }
    window_after_search("solar eclipse 28 May 585 BC").get_by_label_contains("Total solar eclipse, -0584-05-22 ");
}

/// The field stayed empty, beside the latitude of the city.
#[test]
fn a_city_of_the_search_is_named_in_the_city_field() {
    let mut window = window_after_search("eclipse 2026");
    window.get_by_label_contains("Total solar eclipse, 2026-08-12 17:4").click();
    window.run_steps(3);
    let city = |window: &Window| window.get_by_role_and_label(egui::accesskit::Role::TextInput, "City").accesskit_node().value();
    assert_eq!(city(&window).unwrap_or_default(), "");
    search(&mut window, "munich");
    window.run_steps(5);
    assert_eq!(city(&window).as_deref(), Some("Munich"));
}

/// A typed time is suggested with its seconds, not rounded to a minute of the next year.
#[test]
fn a_suggested_time_has_the_typed_seconds() {
    let window = window_without_images(MARS);
    for (text, name) in [
        ("2999-12-31 23:59:50", "2999-12-31 23:59:50 UTC"),
        ("8 April 2024 18:17", "2024-04-08 18:17 UTC"),
        ("2027", "2027-01-01 00:00 UTC"),
    ] {
        let found = suggestions(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8);
        assert_eq!(found.first().map(|s| s.name.as_str()), Some(name), "{text}");
    }
}

#[test]
fn a_similar_name_is_offered_and_not_chosen() {
    let mut window = window_without_images(MARS);
    type_text(&mut window, "/");
    type_text(&mut window, "betelguese");
    window.get_by_label("Did you mean Betelgeuse?");
    window.key_press(Key::Enter);
    window.run_steps(2);
    window.get_by_label("Nothing is called “betelguese”");
    assert_eq!(window.state().viewer.view.target, MARS);
    window.get_by_label("Did you mean Betelgeuse?").click();
    window.run_steps(3);
    assert_eq!(window.state().viewer.view.target, NaifId::EARTH);
}

/// A pasted link is opened; an invalid one is reported with its errors.
#[test]
fn a_link_in_the_search_field_opens_its_view() {
    let window = window_after_search(" orrery://view?target=599&time=2015-01-24T06:45:00Z");
    let view = &window.state().viewer.view;
    assert_eq!((view.target, view.time().to_utc_iso().as_str()), (NaifId(599), "2015-01-24T06:45:00Z"));
    let window = window_after_search("orrery://view?target=nowhere&fov_deg=900");
    window.get_by_label_contains("fov_deg 900");
    assert_eq!(window.state().viewer.view.target, MARS);
}

/// The error says what is wrong with an impossible date or place.
#[test]
fn impossible_dates_and_places_are_named_as_such() {
    for (text, error) in [
        ("32 February 2024", "“32 February 2024” is not a date"),
        ("2023-02-29", "“2023-02-29” is not a date"),
        ("98.3, 500", "“98.3, 500” is not a place: latitudes are -90 to 90 degrees"),
        ("nowhere 5", "Nothing is called “nowhere 5”"),
    ] {
        let window = window_after_search(text);
        window.get_by_label_contains(error);
        assert_eq!(window.state().viewer.view.target, MARS, "{text}");
    }
}

/// The error about an unknown effect lists all effects; it stays inside the window.
#[test]
fn a_long_error_wraps_inside_the_window() {
    let mut window = window_after_search("+nonsense");
    for width in [1100.0, 500.0] {
        window.set_size(egui::vec2(width, 800.0));
        window.run_steps(4);
        let error = window.get_by_label_contains("nonsense` is not known").rect();
        let field = window.get_by_role_and_label(egui::accesskit::Role::TextInput, "Search").rect();
        assert!(error.left() >= field.left() - 1.0 && error.right() <= width && error.height() > 20.0, "{width}: {error:?}");
    }
}
