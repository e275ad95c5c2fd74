//! Stars in the window: facts about a clicked star, and angles between two points.

use crate::view::input::{TIME, Window, click, pausable_window};
use crate::view::interface::{interface, session, settle};
use egui::epaint::ColorMode;
use egui::{Color32, Event, Modifiers, PointerButton, Pos2, Rect, Shape, vec2};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::scene::request::Projection;
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
    let view = orrery::view::app::sky_target::star_view(&rigel, years, &places, &interface.viewer.view).expect("a view");
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
        sky.min + vec2((px.x * points_per_px) as f32, (px.y * points_per_px) as f32)
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
    ctrl_click(&mut window, star_pos + vec2(200.0, 150.0));
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

/// The lines of a measured arc in the window, and the rectangles of a text.
fn arc_and_text(window: &Window, text: &str) -> (Vec<Vec<Pos2>>, Vec<Rect>) {
    const ARC_COLOUR: Color32 = Color32::from_rgb(255, 200, 90);
    fn walk(shape: &Shape, text: &str, lines: &mut Vec<Vec<Pos2>>, rects: &mut Vec<Rect>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, text, lines, rects)),
            Shape::Path(path) if path.stroke.color == ColorMode::Solid(ARC_COLOUR) => lines.push(path.points.clone()),
            Shape::Text(shown) if shown.galley.job.text == text => rects.push(Rect::from_min_size(shown.pos, shown.galley.size())),
            _ => {}
        }
    }
    let (mut lines, mut rects) = (Vec::new(), Vec::new());
    window.output().shapes.iter().for_each(|clipped| walk(&clipped.shape, text, &mut lines, &mut rects));
    (lines, rects)
}

/// In a whole-sphere image the arc between two places at its left and right edges is short and in two parts. A line joined the parts across the entire image,
/// and the angle was cut off.
#[test]
fn a_measured_arc_is_interrupted_at_the_edge_of_a_whole_sphere_image() {
    let mut interface = interface(NaifId(699), TIME);
    interface.viewer.view.composition.projection = Projection::Equirectangular;
    let mut window = pausable_window(interface, &Arc::new(AtomicBool::new(true)), 700.0);
    window.run_steps(20);
    settle(&mut window);
    let sky = window.get_by_label_contains("The sky: ").rect();
    let (left, right) = (sky.left_center(), sky.right_center());
    for (ends, is_cut) in
        [([left + vec2(60.0, 40.0), right - vec2(60.0, 40.0)], true), ([120.0, 240.0].map(|x| left + vec2(x, 40.0)), false)]
    {
        ends.into_iter().for_each(|end| ctrl_click(&mut window, end));
        window.run_steps(1);
        let message = window.state().reply_text().to_owned();
        let angle = message.strip_prefix("Angle: ").and_then(|rest| rest.split(';').next()).unwrap_or_else(|| panic!("{message}"));
        let (lines, rects) = arc_and_text(&window, angle);
        assert_eq!(lines.len(), if is_cut { 2 } else { 1 }, "{message}: {lines:?}");
        for line in &lines {
            // Neighbouring points are less than a degree apart; away from the poles that is much less than a tenth of the image.
            assert!(line.windows(2).all(|pair| pair[0].distance(pair[1]) < 0.1 * sky.width()), "{message}: {line:?}");
        }
        // The arc reaches an edge where it is cut, to within the missing segment, and only there.
        for edge in [left.x, right.x] {
            let nearest = lines.iter().flatten().map(|point| (point.x - edge).abs()).fold(f32::INFINITY, f32::min);
            assert_eq!(nearest < 5.0, is_cut, "{message}: {nearest} points from the edge at {edge}");
        }
        // The angle, and its shadow.
        assert!(rects.len() == 2 && rects.iter().all(|rect| sky.expand(1.5).contains_rect(*rect)), "{message}: {rects:?} in {sky}");
    }
}
