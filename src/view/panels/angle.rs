//! The angle between two places of the picture: Ctrl and a click on each.
//!
//! The places are directions from the eye, so that the line stays on the sky while the view turns. A click near a star or a small body means its middle. After two places a third
//! begins anew; Escape takes the line away.

use super::information::degrees;
use crate::ephemeris::angle_rad;
use crate::scene::camera::Camera;
use egui::{Align2, Color32, FontId, Pos2, Shape, Stroke};
use glam::{DVec2, DVec3};

const COLOUR: Color32 = Color32::from_rgb(255, 200, 90);
/// Straight pieces of the line.
const PIECES: u32 = 48;

/// Directions of the places that were clicked, ICRF unit vectors: two at most.
#[derive(Debug, Default)]
pub(super) struct MeasuredAngle {
    places: Vec<DVec3>,
}

impl MeasuredAngle {
    /// Adds a place of the picture; what to say about it.
    pub(super) fn add(&mut self, camera: &Camera, at_px: DVec2) -> String {
        if self.places.len() >= 2 {
            self.places.clear();
        }
        self.places.push(camera.ray(camera.clip_from_pixel(at_px)).normalize());
        self.text().map_or_else(|| "Ctrl+click a second place to measure the angle".into(), |angle| format!("Angle: {angle}"))
    }

    /// Whether there was anything to take away.
    pub(super) fn clear(&mut self) -> bool {
        !std::mem::take(&mut self.places).is_empty()
    }

    fn text(&self) -> Option<String> {
        let [a, b] = self.places[..] else { return None };
        Some(degrees(angle_rad(a, b).to_degrees()))
    }

    /// Draws the places, the great circle between them and its length. `at`: where the window has a pixel of the picture.
    pub(super) fn paint(&self, painter: &egui::Painter, camera: &Camera, at: impl Fn(DVec2) -> Pos2) {
        let seen = |direction: DVec3| camera.clip(direction).map(|clip| at(camera.pixel_from_clip(clip)));
        for place in self.places.iter().filter_map(|place| seen(*place)) {
            painter.circle_stroke(place, 4.0, Stroke::new(1.5, COLOUR));
        }
        let ([a, b], Some(text)) = (&self.places[..], self.text()) else { return };
        let angle = angle_rad(*a, *b);
        let Some(across) = (b - a * a.dot(*b)).try_normalize() else { return };
        let on_arc = |part: f64| seen(*a * (angle * part).cos() + across * (angle * part).sin());
        let points: Vec<Option<Pos2>> = (0..=PIECES).map(|k| on_arc(f64::from(k) / f64::from(PIECES))).collect();
        for run in points.split(Option::is_none).filter(|run| run.len() > 1) {
            painter.add(Shape::line(run.iter().flatten().copied().collect(), Stroke::new(1.5, COLOUR)));
        }
        if let Some(middle) = on_arc(0.5) {
            let font = FontId::proportional(14.0);
            painter.text(middle + egui::vec2(1.0, 1.0), Align2::CENTER_BOTTOM, &text, font.clone(), Color32::BLACK);
            painter.text(middle, Align2::CENTER_BOTTOM, &text, font, COLOUR);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(tan_half_fov: f64) -> Camera {
        Camera {
            position_km: DVec3::ZERO,
            right: DVec3::NEG_Y,
            up: DVec3::Z,
            forward: DVec3::X,
            tan_half_fov: DVec2::splat(tan_half_fov),
            width: 1000,
            height: 1000,
            one_of_several: false,
        }
    }

    /// From the middle to the edge it is half the field of view, at any field; a third click begins anew.
    #[test]
    fn an_angle_is_that_of_the_field_of_view() {
        for half_deg in [1.0 / 120.0, 0.5, 20.0, 45.0, 80.0] {
            let camera = camera(f64::to_radians(half_deg).tan());
            let mut angle = MeasuredAngle::default();
            assert!(angle.add(&camera, DVec2::new(500.0, 500.0)).contains("second place"));
            let said = angle.add(&camera, DVec2::new(1000.0, 500.0));
            assert_eq!(said, format!("Angle: {}", degrees(half_deg)));
            assert!(angle.add(&camera, DVec2::new(0.0, 0.0)).contains("second place"));
            assert!(angle.clear() && !angle.clear());
        }
    }
}
