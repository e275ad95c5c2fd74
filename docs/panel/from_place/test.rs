//! The Sample panel: its table, sorted by a click on a heading.

use crate::view::input::{SATURN, Window, window_without_images};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::view::panels::Tab;

/// The bodies of the table from top to bottom. In the list of bodies their names are buttons, not labels.
fn bodies(window: &Window) -> Vec<String> {
    let is_body = |name: &str| window.state().viewer.selectable_bodies().iter().any(|body| body.name == name);
    let texts = window.query_all_by_role(Role::Label).filter_map(|n| Some((n.rect().top(), n.accesskit_node().value()?)));
    let mut rows: Vec<(f32, String)> = texts.filter(|(_, text)| is_body(text)).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().map(|(_, name)| name).collect()
}

#[test]
fn a_click_on_a_heading_sorts_the_bodies() {
    let mut window = window_without_images(SATURN);
    window.state_mut().tab = Some(Tab::Sample);
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "magnitude").click();
    window.run_steps(3);
    assert_eq!(bodies(&window)[..2], ["Sun", "Moon"], "the brightest come first");
    // At 1 au the Sun's magnitude is -26.76; the Earth is 1.011 au away from it. Cells are padded with blanks.
    let has_magnitude_of_sun =
        window.query_all_by(|node| node.value().is_some_and(|value| value.trim().starts_with("-26.7"))).next().is_some();
    assert!(has_magnitude_of_sun, "the Sun's magnitude is not shown");
    window.get_by_role_and_label(Role::Button, "magnitude").click();
    window.run_steps(3);
    let sorted = bodies(&window);
    let row = |name: &str| sorted.iter().position(|body| body == name).expect(name);
    assert!(row("Moon") < row("Sun") && row("Sun") < row("Earth"), "the faintest come first, those without a magnitude last: {sorted:?}");
}
