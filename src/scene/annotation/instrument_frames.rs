//! Outlines of the fields of view of instruments over the image, each with the instrument's name. In this module such an outline is called a *frame*.
//!
//! In: the catalog's instruments or the user's telescope, the camera, and the target's direction. Out: line segments, labels and a decision. Always: the
//! frame of an instrument is centred on the target, or on the middle of the image if the target is outside it (not so in faces of a cube, see `frames`); that
//! of the telescope on the middle; sides of a rectangle are great circles; a field that covers the entire image, or is smaller than a few pixels, has no frame.

use crate::catalog::{FieldOfView, Instrument};
use crate::message::{TextLanguage, reason};
use crate::scene::annotation::line_texts::UnplacedText;
use crate::scene::annotation::sky_lines::AnnotationLines;
use crate::scene::annotation::strokes::{Curve, segments, split_into_quarter_turns, tolerance_factor_at_corners};
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::request::Telescope;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Linear RGB of frames and their names.
const COLOUR: DVec3 = DVec3::new(1.0, 0.3, 0.25);
const OPACITY: f64 = 0.9;
/// Smallest size of a frame, pixels.
const MIN_SIZE_PX: f64 = 8.0;
/// Distance between the middle of a frame's upper side and the middle of its name, in glyph sizes.
const NAME_OFFSET: f64 = 0.8;

/// Orthonormal axes of a field of view: towards its centre, and its directions up and left as seen from inside the celestial sphere.
struct FieldAxes {
    centre: DVec3,
    up: DVec3,
    left: DVec3,
}

impl FieldAxes {
    /// The axes at a centre (unit vector, ICRF). `position_angle_deg`: angle of `up` from north through east. East is to the left of north, because the sky is
    /// seen from inside.
    fn of(centre: DVec3, position_angle_deg: f64) -> Self {
        let east = DVec3::Z.cross(centre).try_normalize().unwrap_or(DVec3::Y);
        let north = centre.cross(east);
        let (sin, cos) = position_angle_deg.to_radians().sin_cos();
        Self { centre, up: north * cos + east * sin, left: east * cos - north * sin }
    }

    /// The point of a circle about the centre at the angle `t` from up through left.
    fn on_circle(&self, radius_rad: f64, t: f64) -> DVec3 {
        self.centre * radius_rad.cos() + (self.up * t.cos() + self.left * t.sin()) * radius_rad.sin()
    }

    /// The direction with these coordinates, left and up, in the gnomonic projection about the centre: tangents of angles from the centre.
    fn at_tangents(&self, left: f64, up: f64) -> DVec3 {
        (self.centre + self.left * left + self.up * up).normalize()
    }
}

/// Draws the part of a curve on the unit sphere that is in the image. `range_rad`: first and last parameter of `point`. `derivative_bound`: see [`Curve`].
fn draw_arc(camera: &Camera, output: &mut AnnotationLines, point: &dyn Fn(f64) -> DVec3, range_rad: [f64; 2], derivative_bound: f64) {
    // All points are infinitely far away, so the tolerance is that at the corners of the image, where a wide view is magnified.
    let curve = Curve { camera, point, derivative_bound, tolerance_factor: tolerance_factor_at_corners(camera) };
    // The image shows the curve as pieces (runs); the range is searched for them in spans of at most a quarter turn.
    for run in curve.runs(&split_into_quarter_turns(range_rad)) {
        // Reversed depth 1 is in front of all bodies.
        output.segments.extend(segments(camera, &run, |_| 1.0, |_| OPACITY, COLOUR));
    }
}

/// Draws the shorter arc of a great circle between two unit vectors.
fn draw_great_circle(camera: &Camera, output: &mut AnnotationLines, a: DVec3, b: DVec3) {
    let angle = a.cross(b).length().atan2(a.dot(b));
    if angle > 0.0 {
        let point = |t: f64| (a * (angle - t).sin() + b * t.sin()) / angle.sin();
        let derivative_bound = 1.0;
        draw_arc(camera, output, &point, [0.0, angle], derivative_bound);
    }
}

/// Draws the outline of a field of view with its name. Returns whether it is in the image, neither too small nor wider than the image.
fn draw_frame(name: &str, field: FieldOfView, axes: &FieldAxes, camera: &Camera, glyph_px: f64, output: &mut AnnotationLines) -> bool {
    let half_size_rad = match field {
        FieldOfView::Circle { diameter_deg } => DVec2::splat((0.5 * diameter_deg).to_radians()),
        FieldOfView::Rectangle { width_deg, height_deg } => 0.5 * DVec2::new(width_deg, height_deg).map(f64::to_radians),
    };
    let half_size_tan = half_size_rad.map(f64::tan);
    let is_too_small = 2.0 * half_size_tan.max_element() / camera.pixel_tangent() < MIN_SIZE_PX;
    if is_too_small || half_size_tan.min_element() > camera.tan_half_fov.max_element() {
        return false;
    }
    let count_before = output.segments.len();
    match field {
        FieldOfView::Circle { .. } => draw_arc(camera, output, &|t| axes.on_circle(half_size_rad.x, t), [0.0, TAU], half_size_rad.x.sin()),
        FieldOfView::Rectangle { .. } => {
            let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
                .map(|[l, u]| axes.at_tangents(l * half_size_tan.x, u * half_size_tan.y));
            (0..4).for_each(|k| draw_great_circle(camera, output, corners[k], corners[(k + 1) % 4]));
        }
    }
    if output.segments.len() == count_before {
        return false;
    }
    if let Some(clip) = camera.clip(axes.at_tangents(0.0, half_size_tan.y)) {
        let centre_px = camera.pixel_from_clip(clip) - DVec2::new(0.0, NAME_OFFSET * glyph_px);
        output.texts.push(UnplacedText { text: name.to_owned(), centre_px, colour: COLOUR, is_grid_coordinate: false });
    }
    true
}

/// The frame of a telescope: in the middle of a perspective image, and upright in it; none in a face of a cube. `glyph_px`: size of glyphs.
pub(crate) fn telescope_frame(telescope: Telescope, camera: &Camera, language: TextLanguage, glyph_px: f64) -> AnnotationLines {
    let mut output = AnnotationLines::default();
    if !camera.is_cube_face {
        let axes = FieldAxes { centre: camera.forward, up: camera.up, left: -camera.right };
        draw_frame(&telescope.label(language), telescope.field_of_view(), &axes, camera, glyph_px, &mut output);
    }
    output
}

/// The frames of all instruments. `target`: vector from the camera to the target, ICRF, of any length. `glyph_px`: size of glyphs.
pub(crate) fn frames(instruments: &[Instrument], camera: &Camera, target: Option<DVec3>, glyph_px: f64) -> AnnotationLines {
    let mut output = AnnotationLines::default();
    let in_image = |v: &DVec3| camera.clip(*v).is_some_and(|clip| clip.abs().max_element() < 1.0);
    let target = target.and_then(DVec3::try_normalize);
    // In a face of a cube, the centre is the target even if it is outside the face, because a part of a frame may be inside. The middle of a face is not the
    // middle of the image and does not replace the target.
    let Some(centre) = target.filter(|v| camera.is_cube_face || in_image(v)).or((!camera.is_cube_face).then_some(camera.forward)) else {
        return output;
    };
    let (mut drawn, mut left_out) = (Vec::new(), 0);
    for instrument in instruments {
        let axes = FieldAxes::of(centre, instrument.position_angle_deg);
        if draw_frame(&instrument.name, instrument.field_of_view, &axes, camera, glyph_px, &mut output) {
            drawn.push(instrument.name.clone());
        } else {
            left_out += 1;
        }
    }
    let on = !drawn.is_empty();
    let mut reason = if on { reason!("lines-instruments", names = drawn) } else { reason!("lines-none") };
    if left_out > 0 {
        reason = reason.and(reason!("lines-instruments-left", count = left_out));
    }
    output.decisions.push(Decision { effect: "instruments", on, reason, stated_error: None });
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLYPH_PX: f64 = 13.0;
    const NORTH_UP_DEG: f64 = 0.0;

    fn instrument(field: FieldOfView, position_angle_deg: f64) -> Instrument {
        Instrument { name: "own".into(), field_of_view: field, position_angle_deg }
    }

    /// Both ends of every segment of a circular frame are at half the field's diameter from the centre. A rectangular frame has the width and height of the
    /// field and is turned by its position angle.
    #[test]
    fn frames_have_the_size_of_their_fields() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 30.0, 800, 600);
        let ray = |end: glam::Vec3| camera.ray(DVec2::new(f64::from(end.x), f64::from(end.y))).normalize();
        let target = DVec3::new(1.0, 0.05, 0.03).normalize();
        for diameter_deg in [1.0, 6.5, 20.0] {
            let found = frames(&[instrument(FieldOfView::Circle { diameter_deg }, NORTH_UP_DEG)], &camera, Some(target), GLYPH_PX);
            assert!(found.decisions[0].on && found.texts.len() == 1, "{:?}", found.decisions);
            for segment in &found.segments {
                let errors_deg = segment.ends.map(|end| ray(end).cross(target).length().asin().to_degrees() - 0.5 * diameter_deg);
                assert!(errors_deg.iter().all(|error| error.abs() < 1e-4), "{diameter_deg}: {errors_deg:?}");
            }
        }
        // A quarter turn exchanges width and height. North is up here, east is left.
        let field = FieldOfView::Rectangle { width_deg: 12.0, height_deg: 4.0 };
        for (angle_deg, half_width_deg, half_height_deg) in [(0.0, 6.0, 2.0), (90.0, 2.0, 6.0)] {
            let found = frames(&[instrument(field, angle_deg)], &camera, Some(DVec3::X), GLYPH_PX);
            let rays: Vec<DVec3> = found.segments.iter().flat_map(|p| p.ends).map(ray).collect();
            let max_angle_deg =
                |component: &dyn Fn(&DVec3) -> f64| rays.iter().map(|r| (component(r) / r.x).atan().to_degrees()).fold(0.0, f64::max);
            let errors_deg = [max_angle_deg(&|r| r.y) - half_width_deg, max_angle_deg(&|r| r.z) - half_height_deg];
            assert!(errors_deg.iter().all(|error| error.abs() < 1e-3), "{angle_deg}: {errors_deg:?}");
        }
        // At 30 degrees the upper side leans to the east, which is left of north.
        let tilted = frames(&[instrument(field, 30.0)], &camera, Some(DVec3::X), GLYPH_PX);
        let text = tilted.texts[0].centre_px;
        assert!(text.x < 400.0 && text.y < 300.0, "{text}");
    }

    /// The frame of a telescope is upright in the middle of the image, whatever the camera's up direction, also in a mirrored image; an eyepiece's is a circle.
    #[test]
    fn the_frame_of_a_telescope_is_upright_in_the_middle() {
        for mirrored in [false, true] {
            let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::new(0.0, 0.6, 0.8), 30.0, 800, 600);
            let camera = if mirrored { camera.mirrored() } else { camera };
            for (text, [half_width_deg, half_height_deg]) in [("100/36x24", [10.204, 6.843]), ("1000/100/80", [4.0, 4.0])] {
                let telescope = Telescope::parse(text).expect(text);
                let found = telescope_frame(telescope, &camera, TextLanguage::English, GLYPH_PX);
                let ends = || found.segments.iter().flat_map(|p| p.ends);
                let [right, up] = [0, 1].map(|axis| ends().map(|end| f64::from(end[axis])).fold(0.0, f64::max));
                let found_deg = [right * camera.tan_half_fov.x, up * camera.tan_half_fov.y].map(|tan| tan.atan().to_degrees());
                assert!(
                    (found_deg[0] - half_width_deg).abs() < 1e-3 && (found_deg[1] - half_height_deg).abs() < 1e-3,
                    "{text}: {found_deg:?}"
                );
                assert!((found.texts[0].centre_px.x - 400.0).abs() < 1e-3 && found.texts[0].centre_px.y < 300.0, "{:?}", found.texts);
            }
        }
        let face = Camera { is_cube_face: true, ..Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 90.0, 600, 600) };
        let telescope = Telescope::parse("1000/100/80").expect("a telescope");
        assert!(telescope_frame(telescope, &face, TextLanguage::English, GLYPH_PX).segments.is_empty());
    }

    #[test]
    fn fields_too_small_or_larger_than_the_image_have_no_frame() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 30.0, 800, 600);
        for diameter_deg in [0.01, 100.0] {
            let no_target = None;
            let found = frames(&[instrument(FieldOfView::Circle { diameter_deg }, NORTH_UP_DEG)], &camera, no_target, GLYPH_PX);
            assert!(found.segments.is_empty() && !found.decisions[0].on, "{diameter_deg}");
            assert!(found.decisions[0].reason.to_string().contains("1 too small or wider than the image"));
        }
    }
}
