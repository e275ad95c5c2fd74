//! Comets, minor planets, constellations and stars in the window: found by search, named, clicked, with their facts.

use crate::view::information::texts;
use crate::view::input::{Window, click, pausable_window, window_without_images};
use crate::view::interface::{interface, session, settle};
use crate::view::search::search;
use egui::{Pos2, Shape, vec2};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::catalog::constellations::Constellations;
use orrery::scene::labels::{SkyObject, small_body_px};
use orrery::scene::request::Look;
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::search::{SearchTarget, suggestions};
use orrery::view::panels::Tab;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const HALE_BOPP: &str = "C/1995 O1 (Hale-Bopp)";

/// The value in the row of the Information panel with this label.
fn value_of(window: &Window, label: &str) -> String {
    texts(window).into_iter().skip_while(|text| text != label).nth(1).unwrap_or_default()
}

/// How often the window paints a text.
fn painted(window: &Window, text: &str) -> usize {
    fn count(shape: &Shape, text: &str) -> usize {
        match shape {
            Shape::Vec(shapes) => shapes.iter().map(|shape| count(shape, text)).sum(),
            Shape::Text(shown) => usize::from(shown.galley.job.text == text),
            _ => 0,
        }
    }
    window.output().shapes.iter().map(|clipped| count(&clipped.shape, text)).sum()
}

/// Craters and nothing at all were found in their place.
#[test]
fn comets_minor_planets_and_constellations_are_found_by_name() {
    let window = window_without_images(NaifId::MOON);
    let first = |text: &str| suggestions(text, &window.state().viewer, session().catalog(), ShownTimeZone::Utc, 8).into_iter().next();
    for (text, name) in [
        ("hale-bopp", HALE_BOPP),
        ("halley", "1P/Halley"),
        ("pallas", "2 Pallas"),
        ("433 eros", "433 Eros"),
        ("scorpius", "Scorpius"),
        ("bootes", "Boötes"),
        ("cma", "Canis Major"),
    ] {
        let found = first(text).unwrap_or_else(|| panic!("nothing for {text}"));
        assert_eq!(found.name, name, "{text}");
    }
    // Bodies, stars and cities of the same name come first.
    assert!(matches!(first("europa").map(|s| s.target), Some(SearchTarget::Body(_))));
    for city in ["paris", "vienna", "phoenix"] {
        assert!(matches!(first(city).map(|s| s.target), Some(SearchTarget::City(_))), "{city}");
    }
    assert!(matches!(first("spica").map(|s| s.target), Some(SearchTarget::Star(_))));
}

#[test]
fn a_constellation_is_in_the_middle_of_its_image() {
    let mut window = window_without_images(NaifId::MOON);
    search(&mut window, "scorpius");
    let view = &window.state().viewer.view;
    assert!(view.layers.constellations && view.target == NaifId::EARTH);
    let request = view.request(session().catalog(), session().ephemeris(), 200, 100).expect("a view");
    let Look::Along { direction, .. } = request.look else { panic!("{:?}", request.look) };
    let all = &Constellations::embedded().all;
    let scorpius = all.iter().find(|c| c.abbreviation == "Sco").expect("one of 88");
    assert!(orrery::ephemeris::angle_rad(direction, scorpius.label_direction).to_degrees() < 0.01, "{direction}");
    // The whole figure fits.
    let extent = scorpius.figure.iter().flatten().map(|v| orrery::ephemeris::angle_rad(v.direction, direction)).fold(0.0, f64::max);
    assert!(view.fov_deg > 2.0 * extent.to_degrees() && view.fov_deg < 100.0, "{}", view.fov_deg);
}

/// A comet that was found is in the middle of the image, with its name and its facts; a click on it selects it again.
#[test]
fn a_comet_is_found_named_and_clicked() {
    let mut interface = interface(NaifId::EARTH, "1997-04-10T20:00:00Z");
    interface.tab = Some(Tab::Information);
    let mut window = pausable_window(interface, &Arc::new(AtomicBool::new(true)), 900.0);
    window.run_steps(20);
    search(&mut window, "hale-bopp");
    assert!(window.state().reply_text().starts_with(&format!("{HALE_BOPP}, magnitude ")), "{}", window.state().reply_text());
    settle(&mut window);
    assert!(window.state().viewer.view.layers.comets);
    assert!(painted(&window, HALE_BOPP) >= 2, "the name and its shadow");
    // In April 1997 it was in Perseus, in the evening.
    assert_eq!(value_of(&window, "constellation"), "Perseus");
    assert!(value_of(&window, "elongation").ends_with("east of the Sun (evening)"), "{}", value_of(&window, "elongation"));
    for label in ["distance from the Sun", "magnitude", "rise", "set", "altitude"] {
        assert_ne!(value_of(&window, label), "", "{label}");
    }
    let sky = window.get_by_label_contains("The sky: ").rect();
    let small_bodies = session().catalog().small_bodies();
    let index = small_bodies.comets.iter().position(|c| c.full_name() == HALE_BOPP).expect("in the catalog");
    let comet = SkyObject::Comet(index).small_body(&small_bodies).expect("in the catalog");
    let position = |window: &Window| -> Pos2 {
        let rendered = window.state().shown().expect("an image");
        let px = small_body_px(&rendered.scene, session().ephemeris(), comet).expect("in the image");
        let points_per_px = f64::from(sky.width()) / f64::from(rendered.width);
        sky.min + vec2((px.x * points_per_px) as f32, (px.y * points_per_px) as f32)
    };
    let comet_pos = position(&window);
    assert!(comet_pos.distance(sky.center()) < 2.0, "{comet_pos:?} in {sky:?}");
    // Another star takes its place, or none; the comet's facts are gone.
    click(&mut window, comet_pos + vec2(150.0, 120.0));
    window.run_steps(3);
    assert!(!texts(&window).iter().any(|text| text == "distance from the Sun"));
    click(&mut window, comet_pos);
    window.run_steps(3);
    assert!(window.state().reply_text().starts_with(&format!("{HALE_BOPP}, magnitude ")), "{}", window.state().reply_text());
    assert_ne!(value_of(&window, "distance from the Sun"), "");
    // Without the layer there is neither name nor click.
    window.state_mut().viewer.view.layers.comets = false;
    settle(&mut window);
    click(&mut window, comet_pos + vec2(150.0, 120.0));
    settle(&mut window);
    assert_eq!(painted(&window, HALE_BOPP), 0);
}

/// A minor planet too faint for the exposure has a marker; the chosen one has a name.
#[test]
fn a_minor_planet_is_found_and_named() {
    let mut window = pausable_window(interface(NaifId::EARTH, "2027-01-01T00:00:00Z"), &Arc::new(AtomicBool::new(true)), 700.0);
    window.run_steps(20);
    search(&mut window, "pallas");
    settle(&mut window);
    assert!(window.state().viewer.view.layers.minor_planets);
    assert!(painted(&window, "2 Pallas") >= 2);
    assert_eq!(painted(&window, "3 Juno"), 0, "the others have none");
}

/// The constellation, and rise and set at the observer's place, which the facts about stars lacked.
#[test]
fn a_star_has_its_constellation_and_rises_at_the_place() {
    let mut interface = interface(NaifId::EARTH, "2024-01-15T00:00:00Z");
    interface.tab = Some(Tab::Information);
    let mut window = pausable_window(interface, &Arc::default(), 900.0);
    window.run_steps(3);
    search(&mut window, "sirius");
    window.run_steps(5);
    assert_eq!(value_of(&window, "constellation"), "Canis Major");
    // In Greenwich Sirius, at a declination of -16.75 degrees, culminates at an altitude of 90 - 51.48 - 16.75 degrees.
    let transit = value_of(&window, "transit");
    assert!(transit.contains("altitude 21.8°"), "{transit}");
    for label in ["rise", "set"] {
        assert!(value_of(&window, label).starts_with("2024-01-15 "), "{label}: {}", value_of(&window, label));
    }
}
