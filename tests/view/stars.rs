//! Stars in the window: facts about a clicked star, and angles between two points.

use crate::view::input::{TIME, Window, click, pausable_window};
use crate::view::interface::{interface, session, settle};
use egui::{Event, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::view::app::view_state::CameraPose;
use orrery::view::panels::Tab;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn ctrl_click(window: &mut Window, pos: Pos2) {
    window.event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.run_steps(1);
    window.hover_at(pos);
    window.run_steps(1);
    for pressed in [true, false] {
        window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::COMMAND });
        window.run_steps(1);
    }
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(1);
}

/// A click on a star shows its name at once and its facts in the Information panel; two clicks with Ctrl measure an angle.
#[test]
fn a_click_selects_a_star_and_two_clicks_measure_an_angle() {
    let mut interface = interface(NaifId::EARTH, TIME);
    let catalog = session().catalog();
    let places = orrery::view::app::body_positions::SessionPositions(session());
    let rigel = catalog.stars().star_of_hip(24_436).copied().expect("in the catalog");
    let years = catalog.stars().years_since_epoch(interface.viewer.view.time().jd_tt());
    let view = orrery::view::app::search::star_view(&rigel, years, &places, &interface.viewer.view).expect("a view");
    let height_px = 900.0;
    interface.viewer.apply(orrery::view::app::viewer::Action::Show(Box::new(view)), height_px, &places);
    interface.tab = Some(Tab::Information);
    let mut window = pausable_window(interface, &Arc::new(AtomicBool::new(true)), 900.0);
    window.run_steps(20);
    settle(&mut window);
    // The sky is the area that the panels leave.
    let sky = window.get_by_label_contains("The sky: ").rect();
    let star = catalog.stars().index_of_hip(24_436).expect("in the catalog");
    let screen_position = |window: &Window, px: glam::DVec2| {
        let rendered = window.state().shown().expect("an image");
        let points_per_px = f64::from(sky.width()) / f64::from(rendered.width);
        sky.min + egui::vec2((px.x * points_per_px) as f32, (px.y * points_per_px) as f32)
    };
    let star_at = |window: &Window| {
        let px = orrery::scene::labels::star_px(&window.state().shown().expect("an image").scene, star).expect("Rigel is drawn");
        screen_position(window, px)
    };
    let star_pos = star_at(&window);
    click(&mut window, star_pos);
    window.run_steps(3);
    assert!(window.state().reply_text().starts_with("Rigel (HIP 24436), magnitude 0."), "{}", window.state().reply_text());
    assert!(window.query_all_by_label_contains("Rigel (HIP 24436)").count() >= 1);
    // With Ctrl: the angle from the star to another point of the sky.
    ctrl_click(&mut window, star_pos);
    assert!(window.state().reply_text().contains("second place"), "{}", window.state().reply_text());
    ctrl_click(&mut window, star_pos + egui::vec2(200.0, 150.0));
    let message = window.state().reply_text();
    let angle_deg: f64 =
        message.strip_prefix("Angle: ").and_then(|rest| rest.strip_suffix('°')?.parse().ok()).unwrap_or_else(|| panic!("{message}"));
    // The view is 20 degrees high, with the star in its middle. The tolerance is for a click near another star, which means that star.
    let tangent = 200_f64.hypot(150.0) / (0.5 * f64::from(sky.height())) * 10_f64.to_radians().tan();
    assert!((angle_deg - tangent.atan().to_degrees()).abs() < 0.5, "{message}, and not {} degrees", tangent.atan().to_degrees());
}

/// The distance of two bodies is that in one image: from itself a body has none, also if the camera has moved between the clicks.
#[test]
fn a_body_has_no_distance_from_itself_after_a_motion_of_the_camera() {
    let mut window = pausable_window(interface(NaifId::EARTH, TIME), &Arc::new(AtomicBool::new(true)), 900.0);
    window.run_steps(20);
    settle(&mut window);
    let centre = window.get_by_label_contains("The sky: ").rect().center();
    ctrl_click(&mut window, centre);
    assert!(window.state().reply_text().contains("second place"), "{}", window.state().reply_text());
    let CameraPose::Orbit { distance_radii, .. } = &mut window.state_mut().viewer.view.camera_pose else {
        panic!("the camera must be in orbit")
    };
    *distance_radii *= 2.0;
    settle(&mut window);
    ctrl_click(&mut window, centre);
    let message = window.state().reply_text();
    assert!(message.starts_with("Angle: ") && !message.contains("km"), "{message}");
}
