//! The angle between two points of the image that the user clicks while holding Ctrl.
//!
//! In: the direction of each clicked point, and the body at this point, if any. Out: the angle as a message, for two bodies with the distance between their
//! apparent positions; and the arc between the points. Always: the arc stays fixed to the sky while the view rotates, because the points are directions from
//! the camera; a third point starts a new measurement. Not here: how a click finds a star or a body (`viewport`).

use super::information::scaled_angle_text;
use crate::ephemeris::angle_rad;
use crate::view::language::numbers::grouped;
use crate::view::language::{body_name, text};
use crate::view::panels::theme::BODY_TEXT_POINTS;
use egui::{Align2, Color32, FontId, Pos2, Shape, Stroke, vec2};
use glam::DVec3;

/// Colour of the points, the arc and the angle.
const COLOUR: Color32 = Color32::from_rgb(255, 200, 90);
/// Number of line segments of the arc. Where the edge of the image cuts the arc, a segment is missing, at most a degree long.
const SEGMENTS: u32 = 180;

/// The measured angle, with the clicked points: two at most.
#[derive(Debug, Default)]
pub(super) struct MeasuredAngle {
    points: Vec<MeasuredPoint>,
}

/// A clicked point.
#[derive(Debug)]
struct MeasuredPoint {
    /// Direction of the point from the camera, an ICRF unit vector.
    direction: DVec3,
    /// The body at the point, if any.
    body: Option<SeenBody>,
}

/// A body under a click.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeenBody {
    /// The body's name in the catalog.
    pub name: String,
    /// The body's apparent centre relative to the camera, ICRF.
    pub centre_km: DVec3,
}

impl MeasuredAngle {
    /// Adds the point in an ICRF direction (a unit vector) from the camera; returns the message for the user.
    pub(super) fn add(&mut self, direction: DVec3, body: Option<SeenBody>) -> String {
        if self.points.len() >= 2 {
            self.points.clear();
        }
        self.points.push(MeasuredPoint { direction, body });
        let Some(angle) = self.angle_text() else { return text!("angle-second").into() };
        self.distance_text()
            .map_or_else(|| text!("angle", angle = angle), |distance| text!("angle-and-distance", angle = angle, distance = distance))
    }

    /// Moves the clicked bodies to where a newer image shows them: camera or time may have changed since the click, and a distance needs the positions of
    /// both bodies at one time, relative to one camera. A body that the newer image lacks is dropped, but its point stays. `centre_km`: returns the apparent
    /// centre of the body with a given name, relative to the camera (ICRF), if the newer image has that body.
    pub(super) fn move_bodies(&mut self, centre_km: impl Fn(&str) -> Option<DVec3>) {
        for point in &mut self.points {
            let body = point.body.take();
            point.body = body.and_then(|body| Some(SeenBody { centre_km: centre_km(&body.name)?, ..body }));
        }
    }

    /// Removes the points; returns whether there were any.
    pub(super) fn clear(&mut self) -> bool {
        !std::mem::take(&mut self.points).is_empty()
    }

    /// The angle between the two points; `None` before the second click.
    fn angle_text(&self) -> Option<String> {
        let [a, b] = &self.points[..] else { return None };
        Some(scaled_angle_text(angle_rad(a.direction, b.direction).to_degrees()))
    }

    /// The distance between the apparent centres of the two bodies, if the points are on two different bodies.
    fn distance_text(&self) -> Option<String> {
        let [MeasuredPoint { body: Some(a), .. }, MeasuredPoint { body: Some(b), .. }] = &self.points[..] else { return None };
        // Both are as in the image of the second click (see `move_bodies`), so a body that was clicked twice has one name and one centre.
        (a != b).then(|| {
            text!(
                "angle-distance",
                first = body_name(&a.name),
                second = body_name(&b.name),
                distance = grouped(a.centre_km.distance(b.centre_km), 0)
            )
        })
    }

    /// Draws the points, the great-circle arc between them, and the angle. `project`: the position of an ICRF direction in the window, if it is in the
    /// image. `is_cut`: whether the short arc between two directions leaves the image at one edge and continues at the opposite edge.
    pub(super) fn paint(&self, painter: &egui::Painter, project: impl Fn(DVec3) -> Option<Pos2>, is_cut: impl Fn(DVec3, DVec3) -> bool) {
        for position in self.points.iter().filter_map(|point| project(point.direction)) {
            painter.circle_stroke(position, 4.0, Stroke::new(1.5, COLOUR));
        }
        let ([MeasuredPoint { direction: a, .. }, MeasuredPoint { direction: b, .. }], Some(text)) = (&self.points[..], self.angle_text())
        else {
            return;
        };
        let angle_between_rad = angle_rad(*a, *b);
        // The direction of the arc at `a`.
        let Some(tangent) = (b - a * a.dot(*b)).try_normalize() else { return };
        let direction_at = |fraction: f64| *a * (angle_between_rad * fraction).cos() + tangent * (angle_between_rad * fraction).sin();
        let arc: Vec<DVec3> = (0..=SEGMENTS).map(|k| direction_at(f64::from(k) / f64::from(SEGMENTS))).collect();
        for part in arc.chunk_by(|from, to| !is_cut(*from, *to)) {
            let positions: Vec<Option<Pos2>> = part.iter().map(|direction| project(*direction)).collect();
            // Parts of the arc outside the image interrupt the line.
            for visible in positions.split(Option::is_none).filter(|positions| positions.len() > 1) {
                painter.add(Shape::line(visible.iter().flatten().copied().collect(), Stroke::new(1.5, COLOUR)));
            }
        }
        let bounds = painter.clip_rect();
        if let Some(middle) = project(direction_at(0.5)).filter(|middle| bounds.contains(*middle)) {
            let font = FontId::proportional(BODY_TEXT_POINTS);
            let size = painter.layout_no_wrap(text.clone(), font.clone(), COLOUR).size();
            // Above the middle of the arc, but within the viewport.
            let position = middle.max(bounds.min + vec2(0.5 * size.x, size.y)).min(bounds.max - vec2(0.5 * size.x, 0.0));
            painter.text(position + vec2(1.0, 1.0), Align2::CENTER_BOTTOM, &text, font.clone(), Color32::BLACK);
            painter.text(position, Align2::CENTER_BOTTOM, &text, font, COLOUR);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use glam::DVec2;

    fn camera(tan_half_fov: f64) -> Camera {
        Camera {
            position_km: DVec3::ZERO,
            right: DVec3::NEG_Y,
            up: DVec3::Z,
            forward: DVec3::X,
            tan_half_fov: DVec2::splat(tan_half_fov),
            width: 1000,
            height: 1000,
            is_cube_face: false,
            composed_cone: None,
            limits_sprite_size: false,
        }
    }

    fn direction(camera: &Camera, x: f64, y: f64) -> DVec3 {
        camera.ray(camera.clip_from_pixel(DVec2::new(x, y))).normalize()
    }

    /// The angle from the middle to the edge is half the field of view, at any field of view; a third click starts a new measurement.
    #[test]
    fn the_angle_from_middle_to_edge_is_half_the_field_of_view() {
        const NO_BODY: Option<SeenBody> = None;
        for half_deg in [1.0 / 120.0, 0.5, 20.0, 45.0, 80.0] {
            let camera = camera(f64::to_radians(half_deg).tan());
            let mut angle = MeasuredAngle::default();
            assert!(angle.add(direction(&camera, 500.0, 500.0), NO_BODY).contains("second place"));
            let message = angle.add(direction(&camera, 1000.0, 500.0), NO_BODY);
            assert_eq!(message, format!("Angle: {}", scaled_angle_text(half_deg)));
            assert!(angle.add(direction(&camera, 0.0, 0.0), NO_BODY).contains("second place"));
            assert!(angle.clear() && !angle.clear());
        }
    }

    #[test]
    fn two_bodies_have_a_distance_and_one_has_none() {
        let body = |name: &str, centre_km| Some(SeenBody { name: name.into(), centre_km });
        let (a, b) = (body("Io", DVec3::new(300.0, 0.0, 0.0)), body("Europa", DVec3::new(0.0, 400_000.0, 0.0)));
        let message = |first: Option<SeenBody>, second: Option<SeenBody>| {
            let mut angle = MeasuredAngle::default();
            angle.add(direction(&camera(1.0), 500.0, 500.0), first);
            angle.add(direction(&camera(1.0), 600.0, 500.0), second)
        };
        assert!(message(a.clone(), b.clone()).ends_with("; from Io to Europa 400 000 km"));
        assert!(!message(a.clone(), a.clone()).contains("km") && !message(a, None).contains("km"));
    }

    #[test]
    fn a_distance_is_that_in_the_image_of_the_second_click() {
        let body = |name: &str, centre_km| Some(SeenBody { name: name.into(), centre_km });
        let message = |moved_io_km: Option<DVec3>, second: Option<SeenBody>| {
            let mut angle = MeasuredAngle::default();
            angle.add(direction(&camera(1.0), 500.0, 500.0), body("Io", DVec3::new(300.0, 0.0, 0.0)));
            angle.move_bodies(|name| moved_io_km.filter(|_| name == "Io"));
            angle.add(direction(&camera(1.0), 600.0, 500.0), second)
        };
        let moved_km = DVec3::new(300.0, 0.0, 250_000.0);
        let europa = || body("Europa", DVec3::new(300.0, 0.0, 0.0));
        assert!(message(Some(moved_km), europa()).ends_with("; from Io to Europa 250 000 km"));
        assert!(!message(Some(moved_km), body("Io", moved_km)).contains("km"), "a body has no distance from itself");
        assert!(!message(None, europa()).contains("km"), "the image does not have the first body");
    }
}
