//! The Sample panel: values of the displayed image, sorted by a click on a heading; a click on a moon makes it the target.

use crate::view::input::{SATURN, TIME, Window};
use crate::view::interface::{harness, interface, session, settle};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::panels::Tab;

const MERCURY: NaifId = NaifId(199);
const TITAN: NaifId = NaifId(606);

/// A window with the panel, once its image has arrived.
fn window_at(target: NaifId) -> Window {
    let mut window = harness(interface(target, TIME));
    // The list of bodies has buttons of the same names.
    window.state_mut().body_browser_shown = false;
    window.state_mut().tab = Some(Tab::Sample);
    settle(&mut window);
    window
}

/// Saturn's moons in the table, from top to bottom.
fn moons(window: &Window) -> Vec<String> {
    let is_moon = |name: &String| session().catalog().moons_of(SATURN).any(|moon| moon.name == *name);
    let buttons = window.query_all_by_role(Role::Button).filter_map(|n| Some((n.rect().top(), n.accesskit_node().label()?)));
    let mut rows: Vec<(f32, String)> = buttons.filter(|(_, name)| is_moon(name)).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, name)| name).collect()
}

/// Saturn's moons by their magnitudes in the displayed image, then those without one.
fn moons_by_magnitude(window: &Window) -> Vec<String> {
    let scene = &window.state().shown().expect("an image").scene;
    let bodies = session().catalog().moons_of(SATURN).map(|moon| scene.body(moon.id).expect("a moon"));
    let mut sorted: Vec<(f64, String)> = bodies.map(|b| (b.magnitude.unwrap_or(f64::INFINITY), b.name.clone())).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    sorted.into_iter().map(|(_, name)| name).collect()
}

#[test]
fn the_moons_are_sorted_by_their_values_in_the_image() {
    let mut window = window_at(SATURN);
    assert_eq!(moons(&window), moons_by_magnitude(&window));
    let titan = window.state().shown().expect("an image").scene.body(TITAN).expect("Titan").magnitude.expect("sunlight on Titan");
    // Negative control: as seen from the Earth, Titan has a magnitude of about 8.
    assert!(titan < 5.0, "{titan}");
    let shown = format!("{titan:+.2}");
    // Cells are padded with blanks.
    let has_magnitude = window.query_all_by(|node| node.value().is_some_and(|value| value.trim() == shown)).next().is_some();
    assert!(has_magnitude, "{shown} is not shown");
    window.get_by_role_and_label(Role::Button, "moon").click();
    window.run_steps(3);
    let by_name = moons(&window);
    assert!(by_name.is_sorted() && by_name != moons_by_magnitude(&window), "{by_name:?}");
}

#[test]
fn a_click_on_a_moon_makes_it_the_target_and_keeps_the_list() {
    let mut window = window_at(SATURN);
    let count = moons(&window).len();
    // The row may be scrolled out of view.
    window.get_by_role_and_label(Role::Button, "Titan").click_accesskit();
    settle(&mut window);
    let viewer = &window.state().viewer;
    assert_eq!((viewer.view.target, viewer.selected), (TITAN, TITAN));
    assert_eq!(moons(&window).len(), count, "the moons of Titan's planet");
    window.get_by_label("Back").click();
    settle(&mut window);
    assert_eq!(window.state().viewer.view.target, SATURN);
}

#[test]
fn a_planet_without_moons_has_no_table() {
    let window = window_at(MERCURY);
    assert_eq!(window.query_all_by_label("No moons in the catalog").count(), 1);
    assert_eq!(window.query_all_by_role_and_label(Role::Button, "magnitude").count(), 0);
}
