//! The Information panel: rows that depend on the body; the day of rise, transit, set and a solar eclipse.

use crate::view::input::{SATURN, TIME, Window, click, type_text};
use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::app::settings::{Home, LengthUnit, Settings};
use orrery::view::app::view_state::CameraPose;
use orrery::view::panels::{Interface, Tab};

/// A window with the panel about a body, once its image has arrived. The camera is beside `target`.
pub(super) fn window_about(selected: NaifId, target: NaifId, utc: &str, home: Home) -> Window {
    let Interface { mut viewer, settings, .. } = interface(target, utc);
    viewer.selected = selected;
    let mut interface = Interface::new(viewer, Settings { home, ..settings });
    interface.tab = Some(Tab::Information);
    let mut window = harness(interface);
    settle(&mut window);
    window
}

/// All texts that are not controls, from top to bottom. In a row of the panel the value follows the label.
pub(super) fn texts(window: &Window) -> Vec<String> {
    window.query_all_by_role(Role::Label).filter_map(|label| label.accesskit_node().value()).collect()
}

/// The value in the row with this label; `None` if the panel has no such row.
fn value_of(window: &Window, label: &str) -> Option<String> {
    texts(window).into_iter().skip_while(|text| text != label).nth(1)
}

#[test]
fn the_suns_altitude_is_that_of_the_image_and_the_sun_has_none() {
    for body in [SATURN, NaifId(606)] {
        let window = window_about(body, SATURN, TIME, Home::default());
        let scene = &window.state().shown().expect("an image").scene;
        let altitude_deg = scene.body(body).and_then(|body| body.sun_altitude_deg).expect("lit by the Sun");
        let expected = format!("{altitude_deg:+.2}° (no refraction)");
        assert_eq!(value_of(&window, "solar altitude there"), Some(expected));
    }
    let sun = window_about(NaifId::SUN, SATURN, TIME, Home::default());
    assert_eq!(value_of(&sun, "solar altitude there"), None);
    // Negative control: the panel has the rows of the Sun.
    assert!(value_of(&sun, "equatorial radius").is_some());
}

/// The Sun reflects no light that counts; it had an albedo of 0.000.
#[test]
fn only_bodies_lit_by_the_sun_have_an_albedo() {
    let saturn = window_about(SATURN, SATURN, TIME, Home::default());
    assert_eq!(value_of(&saturn, "geometric albedo").as_deref(), Some("0.499"));
    let sun = window_about(NaifId::SUN, SATURN, TIME, Home::default());
    assert_eq!(value_of(&sun, "geometric albedo"), None);
}

/// Below a radius the panel gives the height above the ground, in metres or kilometres (feet or miles), as well as the distance of the centre; from farther
/// away only the distance. On the ground it gave no more than the radius.
#[test]
fn the_height_is_given_near_the_ground() {
    for (height_km, unit, expected) in [
        (0.15, LengthUnit::Kilometres, Some("150 m")),
        (0.15, LengthUnit::Miles, Some("492 ft")),
        (500.0, LengthUnit::BodyRadii, Some("500 km")),
        (500.0, LengthUnit::Miles, Some("311 miles")),
        (2000.0, LengthUnit::Kilometres, None),
    ] {
        let Interface { mut viewer, settings, .. } = interface(NaifId::MOON, TIME);
        viewer.view.camera_pose = CameraPose::Ground {
            body: NaifId::MOON,
            latitude_deg: 20.0,
            longitude_deg: 30.0,
            height_km,
            azimuth_deg: 90.0,
            altitude_deg: -5.0,
        };
        let mut interface = Interface::new(viewer, Settings { unit, ..settings });
        interface.tab = Some(Tab::Information);
        let mut window = harness(interface);
        settle(&mut window);
        assert_eq!(value_of(&window, "height above the surface").as_deref(), expected, "{height_km}");
        assert!(value_of(&window, "distance").is_some(), "{height_km}");
    }
}

/// The texts of the panel about the Sun that contain a date of this month: rise, transit, set and the contacts of an eclipse.
fn dated_texts(utc: &str, home: Home, month: &str) -> Vec<String> {
    let window = window_about(NaifId::SUN, NaifId::EARTH, utc, home);
    texts(&window).into_iter().filter(|text| text.contains(month)).collect()
}

/// The day is that of UTC, which the date field shows. It was that of TDB, which began 69 s earlier in 2026 and five hours earlier in 585 BC.
#[test]
fn the_day_of_rise_and_set_is_the_displayed_one() {
    let late = ["2026-11-29T23:58:30Z", "2026-11-29T23:59:30Z"].map(|utc| dated_texts(utc, Home::default(), "2026-11-"));
    // Sunrise in Greenwich (timeanddate.com: 07:40 in London).
    assert!(late[0].iter().any(|text| text.starts_with("2026-11-29 07:4")), "{late:?}");
    assert_eq!(late[0], late[1]);
    // The eclipse that Thales is said to have predicted, in Istanbul.
    let istanbul = Home { latitude_deg: 41.01, longitude_deg: 28.95 };
    let of_thales = ["-0584-05-22T10:00:00Z", "-0584-05-22T19:30:00Z"].map(|utc| dated_texts(utc, istanbul, "-0584-05-2"));
    assert!(of_thales[0].len() >= 6 && of_thales[0].iter().all(|text| text.contains("-0584-05-22 ")), "{of_thales:?}");
    assert_eq!(of_thales[0], of_thales[1]);
    // Negative control: on the next day there is no eclipse.
    assert_eq!(dated_texts("-0584-05-23T10:00:00Z", istanbul, "-0584-05-2").len(), 3);
}

/// A field names no city whose place is no longer the observer's. A name that is being typed stays.
#[test]
fn the_field_for_a_city_empties_when_another_place_is_typed() {
    let mut window = window_about(SATURN, SATURN, TIME, Home::default());
    let city = |window: &Window| window.get_by_role_and_label(Role::TextInput, "City").accesskit_node().value().unwrap_or_default();
    for (field, number) in [("Latitude of the place, degrees north", "43.3"), ("Longitude of the place, degrees east", "-2.9")] {
        for (role, name, text, expected) in [
            (Role::TextInput, "City", "Mosc", "Moscow"),
            (Role::SpinButton, field, number, ""),
            (Role::TextInput, "City", "Lisb", "Lisbon"),
        ] {
            window.get_by_role_and_label(role, name).focus();
            window.run_steps(2);
            window.key_press_modifiers(Modifiers::COMMAND, Key::A);
            window.run_steps(2);
            type_text(&mut window, text);
            let before = city(&window);
            assert_eq!(before, if role == Role::SpinButton { "Moscow" } else { text }, "{field}: {text}");
            window.key_press(Key::Enter);
            window.run_steps(4);
            assert_eq!(city(&window), expected, "{field}: {text}");
        }
    }
    // The name of a city that was chosen is typed again, without Enter, before another latitude.
    for (role, name, text) in [(Role::TextInput, "City", "Lisbon"), (Role::SpinButton, "Latitude of the place, degrees north", "10")] {
        window.get_by_role_and_label(role, name).focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        type_text(&mut window, text);
        assert_eq!(city(&window), "Lisbon");
    }
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert_eq!(city(&window), "");
}

/// The field once stayed as Escape had left it: empty, or with the beginning of another name.
#[test]
fn escape_shows_the_chosen_city_again() {
    let mut window = window_about(SATURN, SATURN, TIME, Home::default());
    let moscow = Home { latitude_deg: 55.756, longitude_deg: 37.618 };
    for (typed, key, expected) in [
        ("Lisb", Key::Escape, ""),
        ("Mosc", Key::Enter, "Moscow"),
        ("", Key::Escape, "Moscow"),
        ("Lisb", Key::Escape, "Moscow"),
        // A name that is left unfinished stays, so that its city can be clicked.
        ("Lisb", Key::Tab, "Lisb"),
        ("Par", Key::Escape, "Moscow"),
    ] {
        window.get_by_role_and_label(Role::TextInput, "City").focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        if typed.is_empty() {
            window.key_press(Key::Backspace);
        } else {
            type_text(&mut window, typed);
        }
        window.run_steps(2);
        let city = |window: &Window| window.get_by_role_and_label(Role::TextInput, "City").accesskit_node().value().unwrap_or_default();
        assert_eq!(city(&window), typed);
        window.key_press(key);
        window.run_steps(4);
        assert_eq!(city(&window), expected, "{typed:?}, {key:?}");
        let home = window.state().settings.home;
        let is_moscow = (home.latitude_deg - moscow.latitude_deg).abs().max((home.longitude_deg - moscow.longitude_deg).abs()) < 0.2;
        assert_eq!(is_moscow, !expected.is_empty(), "{typed:?}, {key:?}: {home:?}");
    }
}

/// A name that no city has was kept without a word, above the place and the contacts of another city.
#[test]
fn an_unknown_city_is_reported_and_not_kept() {
    let mut window = window_about(SATURN, SATURN, TIME, Home::default());
    let city = |window: &Window| window.get_by_role_and_label(Role::TextInput, "City").accesskit_node().value().unwrap_or_default();
    let enter = |window: &mut Window, typed: &str, key: Key| {
        window.get_by_role_and_label(Role::TextInput, "City").focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        type_text(window, typed);
        window.key_press(key);
        window.run_steps(4);
    };
    enter(&mut window, "Sydn", Key::Enter);
    let sydney = window.state().settings.home;
    assert_eq!(city(&window), "Sydney");
    for (key, shown) in [(Key::Enter, "atlantis"), (Key::Tab, "Sydney")] {
        enter(&mut window, "atlantis", key);
        assert!(window.query_by_label("Nothing is called “atlantis”").is_some(), "{key:?}");
        assert_eq!((city(&window).as_str(), window.state().settings.home), (shown, sydney), "{key:?}");
        if key == Key::Enter {
            // The field has kept the focus.
            window.key_press(Key::Escape);
            window.run_steps(4);
            assert!(window.query_by_label_contains("Nothing is called").is_none());
            assert_eq!(city(&window), "Sydney");
        }
    }
    // A similar name is one click away. The press takes the focus from the field.
    enter(&mut window, "Moskow", Key::Enter);
    window.get_by_label("Did you mean Moscow?").scroll_to_me();
    window.run_steps(4);
    let place = window.get_by_label("Did you mean Moscow?").rect().center();
    click(&mut window, place);
    window.run_steps(3);
    assert_eq!(city(&window), "Moscow");
    assert!(window.query_by_label_contains("Nothing is called").is_none() && window.state().settings.home != sydney);
}

/// The rows were missing without a word: the Moon is in the ephemeris at this time, but not for the rest of the day.
#[test]
fn a_day_that_is_partly_outside_the_ephemeris_is_reported_in_place_of_the_rise() {
    let window = window_about(NaifId::MOON, NaifId::EARTH, "3001-01-08T06:00:00Z", Home::default());
    assert!(value_of(&window, "altitude").is_some_and(|altitude| altitude.contains('°')), "{:?}", texts(&window));
    let why = value_of(&window, "rise").expect("a row");
    assert!(why.contains("to 3001-01-08T17:58"), "{why}");
}
