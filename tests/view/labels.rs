//! Names of bodies in the view overlap neither each other nor the overlays, which the window shows over the view: hints, messages, *What to see now*.

use crate::support::sweep;
use crate::view::input::Window;
use crate::view::interface::{harness, interface};
use egui::epaint::{ClippedShape, Shape};
use egui::{Rect, Vec2};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::scene::labels::{LabelMetrics, LabelSide, label_rect};
use orrery::view::app::settings::HintsFollowed;
use orrery::view::app::view_state::CameraPose;

const JUPITER: NaifId = NaifId(599);
const SATURN: NaifId = NaifId(699);
/// Targets and distances in radii: Jupiter with its moons, Saturn with its moons, the planets around the Sun.
const TARGETS: [(NaifId, f64); 3] = [(JUPITER, 60.0), (SATURN, 90.0), (NaifId::SUN, 4000.0)];
/// Sizes of the window in points: small, usual, and large enough for *What to see now*.
const SIZES: [[f32; 2]; 3] = [[640.0, 400.0], [900.0, 560.0], [1280.0, 800.0]];
const YAW_STEP_DEG: f64 = 7.0;
const PITCH_STEP_DEG: f64 = 5.6;
/// Size of names in the view, points.
const NAME_POINTS: f64 = 13.0;

/// The names of bodies painted over the view, with their rectangles. Each is painted twice: first as its own shadow.
fn painted_names(shapes: &[ClippedShape], view: Rect, bodies: &[String]) -> Vec<(String, Rect)> {
    fn walk(shape: &Shape, found: &mut Vec<(String, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|s| walk(s, found)),
            Shape::Text(text) => found.push((text.galley.job.text.to_string(), text.visual_bounding_rect())),
            _ => {}
        }
    }
    let mut found = Vec::new();
    shapes.iter().filter(|s| s.clip_rect == view).for_each(|s| walk(&s.shape, &mut found));
    found.retain(|(text, _)| bodies.contains(text));
    // Of each pair the first is the shadow, which is offset.
    found.chunks_exact(2).map(|pair| pair[1].clone()).collect()
}

/// A window that shows a system of bodies, with all hints.
fn window(target: NaifId, distance_radii: f64, size: [f32; 2]) -> Window {
    let mut interface = interface(target, "2024-12-07T20:00:00Z");
    interface.settings.hints_followed = HintsFollowed::default();
    interface.settings.panels.now_shown = true;
    interface.body_browser_shown = size[0] > 700.0;
    if let CameraPose::Orbit { distance_radii: distance, .. } = &mut interface.viewer.view.camera_pose {
        *distance = distance_radii;
    }
    let mut window = harness(interface);
    window.set_size(Vec2::from(size));
    window
}

/// The camera turns so that bodies come below each overlay. As a negative control the test counts the names that an overlay would cover at their usual
/// places, and how many of these are names of the selected body.
#[test]
fn names_keep_clear_of_hints_messages_and_each_other() {
    let (mut frames, mut without_overlays) = (0, Vec::new());
    let (mut shown, mut selected_shown, mut usually_covered, mut selected_usually_covered) = (0, 0, 0, 0);
    for (target, distance_radii) in TARGETS {
        for size in SIZES {
            let mut window = window(target, distance_radii, size);
            for (k, (yaw_steps, pitch_steps)) in (-2..=2)
                .flat_map(|yaw_steps| (-3..=3).map(move |pitch_steps| (yaw_steps, pitch_steps)))
                .enumerate()
                .filter(|(k, _)| sweep::runs(*k, 3))
            {
                let state = window.state_mut();
                if let CameraPose::Orbit { yaw_deg, pitch_deg, .. } = &mut state.viewer.view.camera_pose {
                    (*yaw_deg, *pitch_deg) = (f64::from(yaw_steps) * YAW_STEP_DEG, f64::from(pitch_steps) * PITCH_STEP_DEG);
                }
                state.viewer.view.tracks = true;
                // A message takes the place of the hints, so half of the frames have one.
                let long_message = "The view was saved as a bookmark, and this message is as long as such messages are.";
                state.show_reply(if k % 2 == 0 { long_message } else { "" });
                window.run_steps(4);
                let view = window.get_by_label_contains("The sky:").rect();
                let state = window.state();
                let overlays = state.overlays().to_vec();
                frames += 1;
                if overlays.is_empty() {
                    without_overlays.push((size, yaw_steps, pitch_steps, view, state.message_line().to_owned(), state.shown().is_some()));
                    continue;
                }
                let rendered = state.shown().expect("an image");
                let bodies: Vec<String> = rendered.scene.bodies.iter().map(|b| b.name.clone()).collect();
                let found = painted_names(&window.output().shapes, view, &bodies);
                for (i, (name, rect)) in found.iter().enumerate() {
                    let case = format!("{name} at {rect:?}, {size:?}, yaw {yaw_steps} steps, pitch {pitch_steps} steps");
                    let covered = overlays.iter().find(|o| o.intersects(rect.shrink(0.5)));
                    assert!(covered.is_none(), "{case} is covered by {covered:?}");
                    let other = found[..i].iter().find(|(_, other)| other.shrink(1.0).intersects(rect.shrink(1.0)));
                    assert!(other.is_none(), "{case} overlaps {other:?}");
                    shown += 1;
                    selected_shown += u32::from(rendered.scene.body(state.viewer.selected).is_some_and(|b| b.name == *name));
                }
                // Where the names would be without overlays.
                let metrics = LabelMetrics::of_size(NAME_POINTS);
                let points_per_px = f64::from(view.height()) / f64::from(rendered.height);
                for body in &rendered.scene.bodies {
                    let Some(at) = rendered.scene.geometry.pixel_of(&rendered.scene.camera, body.placement.centre_km) else { continue };
                    let usual = label_rect(at * points_per_px, 0.0, &body.name, &metrics, LabelSide::DEFAULT);
                    let in_window = |corner: glam::DVec2| view.min + Vec2::new(corner.x as f32, corner.y as f32);
                    let usual = Rect::from_min_max(in_window(usual.min), in_window(usual.max));
                    let is_covered = view.contains_rect(usual) && overlays.iter().any(|o| o.intersects(usual));
                    usually_covered += u32::from(is_covered);
                    selected_usually_covered += u32::from(is_covered && body.id == state.viewer.selected);
                }
            }
        }
    }
    println!("{} of {frames} frames without hints and messages: {:?}", without_overlays.len(), without_overlays.first());
    println!("{shown} names, {selected_shown} of selected bodies; covered at usual places: {usually_covered}, {selected_usually_covered}");
    assert!(10 * without_overlays.len() < frames, "{} of {frames} frames without hints and messages", without_overlays.len());
    // A partial run has a third of the frames. The factor is 5, not 3, because the frames differ in their number of names.
    let scale_to_full_run = if sweep::in_full() { 1 } else { 5 };
    assert!(
        scale_to_full_run * shown > 500 && scale_to_full_run * selected_shown > 50,
        "{shown} names, {selected_shown} of selected bodies"
    );
    assert!(
        scale_to_full_run * usually_covered > 50 && (scale_to_full_run > 1 || selected_usually_covered > 3),
        "covered at usual places: {usually_covered}, {selected_usually_covered} of selected bodies"
    );
}
