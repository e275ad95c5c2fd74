//! Lines of the user's data on the ground of one body, on the side that faces the camera.
//!
//! In: the layers, the time, and the body as it is seen. Out: pieces of lines and a decision. Always: a line is straight in longitude and planetographic latitude from corner to corner (RFC
//! 7946, section 3.1.1), goes the shorter way around where corners lie more than half a turn apart, and ends at the limb; it shows from its time on and fades as points do. Corners nearer to
//! each other than a third of a pixel are drawn as one. Left out: relief and shape models. A million corners are some 0.2 s a frame.

use crate::catalog::DataLayer;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::annotation::body_lines::Sheet;
use crate::scene::annotation::data::shown;
use crate::scene::annotation::strokes::{Curve, segments};
use crate::scene::camera::NEAR_DEPTH_KM;
use crate::time::Instant;
use crate::units::srgb_to_linear;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Corners nearer to each other than this are one, pixels.
const NEAR_PX: f64 = 0.3;
/// A line is looked at for the limb in steps of so many radians of latitude and longitude together.
const STEP: f64 = 0.05;

/// A corner, or a place between two: latitude and longitude in radians, the sum of steps to it, and its place on the unit sphere.
struct Corner {
    at: DVec2,
    way: f64,
    point: DVec3,
}

/// A line in steps.
struct Path {
    corners: Vec<Corner>,
    radii_km: DVec3,
}

fn on_unit_sphere(radii_km: DVec3, at: DVec2) -> DVec3 {
    ground_point_km(radii_km, at.x.to_degrees(), at.y.to_degrees(), 0.0).0 / radii_km
}

impl Path {
    /// `near`: distance on the unit sphere below which corners are one.
    fn of(corners: &[[f64; 2]], radii_km: DVec3, near: f64) -> Self {
        // Places on a curve that begins anew have the parameter 0: see `Curve::runs`.
        let mut path = Self { corners: Vec::with_capacity(corners.len()), radii_km };
        for (k, corner) in corners.iter().enumerate() {
            let mut to = DVec2::new(corner[0], corner[1]).map(f64::to_radians);
            let Some(last) = path.corners.last() else {
                path.corners.push(Corner { at: to, way: 1.0, point: on_unit_sphere(radii_km, to) });
                continue;
            };
            let (from, mut way) = (last.at, last.way);
            if (to.y - from.y).abs() > PI {
                to.y -= TAU * ((to.y - from.y) / TAU).round();
            }
            let is_last = k + 1 == corners.len();
            if !is_last && last.point.distance_squared(on_unit_sphere(radii_km, to)) < near * near {
                continue;
            }
            let length = (to - from).abs().element_sum();
            if length < 1e-12 {
                continue;
            }
            let steps = (length / STEP).ceil().max(1.0);
            for n in 1..=steps as usize {
                let at = from.lerp(to, n as f64 / steps);
                way += length / steps;
                path.corners.push(Corner { at, way, point: on_unit_sphere(radii_km, at) });
            }
        }
        path
    }

    /// On the unit sphere, by the sum of steps.
    fn at(&self, way: f64) -> DVec3 {
        let next = self.corners.partition_point(|c| c.way < way).clamp(1, self.corners.len() - 1);
        let [a, b] = [&self.corners[next - 1], &self.corners[next]];
        on_unit_sphere(self.radii_km, a.at.lerp(b.at, (way - a.way) / (b.way - a.way)))
    }

    /// The parts from which a camera outside the unit sphere is seen, each as the ways of its corners.
    fn facing(&self, camera: DVec3) -> Vec<Vec<f64>> {
        let over = |point: DVec3| camera.dot(point) - 1.0;
        let limb = |mut inside: f64, mut outside: f64| {
            for _ in 0..40 {
                let middle = 0.5 * (inside + outside);
                if over(self.at(middle)) > 0.0 { inside = middle } else { outside = middle }
            }
            inside
        };
        let mut parts: Vec<Vec<f64>> = Vec::new();
        for (k, corner) in self.corners.iter().enumerate() {
            let before = k.checked_sub(1).map(|k| &self.corners[k]);
            let was_over = before.filter(|b| over(b.point) > 0.0);
            match (was_over, over(corner.point) > 0.0, parts.last_mut()) {
                (Some(_), true, Some(part)) => part.push(corner.way),
                (Some(b), false, Some(part)) => part.push(limb(b.way, corner.way)),
                (_, true, _) => parts.push(before.map(|b| limb(corner.way, b.way)).into_iter().chain([corner.way]).collect()),
                (_, false, _) => {}
            }
        }
        parts.retain(|p| p.len() > 1);
        parts
    }
}

/// Draws the lines of all layers of the body.
pub(super) fn on_ground(sheet: &mut Sheet<'_, '_>, layers: &[Arc<DataLayer>], now: Instant) {
    let placement = sheet.p.placement;
    let radii_km = placement.radii_km;
    let nearest_km = (sheet.p.distance_km - radii_km.max_element()).max(NEAR_DEPTH_KM);
    let near = NEAR_PX * sheet.camera.pixel_tangent() * nearest_km / radii_km.max_element();
    // Of both derivatives by the sum of steps: a meridian is curved by up to a^2 / c.
    let size = radii_km.max_element().powi(2) / radii_km.min_element();
    let icrf_from_body = placement.body_from_icrf.transpose();
    let (mut count, mut said) = (0, Vec::new());
    for layer in layers.iter().filter(|l| l.body == Some(sheet.p.body.id) && !l.lines.is_empty()) {
        let colour = DVec3::from_array(layer.colour.map(|c| srgb_to_linear(f64::from(c) / 255.0)));
        let before = sheet.all.pieces.len();
        for line in layer.lines.iter() {
            let Some(opacity) = shown(layer, line.time, now) else { continue };
            let path = Path::of(&line.corners, radii_km, near);
            if path.corners.len() < 2 {
                continue;
            }
            let point = |way: f64| placement.centre_km + icrf_from_body * (path.at(way) * radii_km);
            let curve = Curve { camera: sheet.camera, point: &point, size, finer: 1.0 };
            for part in path.facing(placement.camera_in_unit_sphere()) {
                for run in curve.runs(&part, 0) {
                    let depth = |p: DVec3| (NEAR_DEPTH_KM / p.z).min(1.0);
                    sheet.all.pieces.extend(segments(sheet.camera, &run, depth, |_| opacity, colour));
                }
            }
        }
        count += sheet.all.pieces.len() - before;
        said.push(format!("{} lines of {}", layer.lines.len(), layer.name));
    }
    let reason = if count > 0 { said.join("; ") } else { format!("{}: none in the frame now", said.join("; ")) };
    sheet.decide("data", count > 0, reason);
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: DVec3 = DVec3::new(6378.137, 6378.137, 6356.752);

    /// Between corners a line is straight in longitude and latitude, over the date line too.
    #[test]
    fn a_line_is_straight_in_longitude_and_latitude() {
        for (corners, middle) in [([[49.0, -123.0], [49.0, -95.0]], [49.0, -109.0]), ([[10.0, 179.0], [20.0, -179.0]], [15.0, 180.0])] {
            let path = Path::of(&corners, EARTH, 0.0);
            let last = path.corners.last().expect("corners").way;
            let found = path.at(0.5 * (1.0 + last));
            let expected = on_unit_sphere(EARTH, DVec2::from_array(middle).map(f64::to_radians));
            assert!(found.distance(expected) < 1e-9, "{corners:?}: {found} {expected}");
        }
        // A great circle is elsewhere: 2.2 degrees farther north in the middle of the first line.
        let chord = [-123.0, -95.0].map(|lon| on_unit_sphere(EARTH, DVec2::new(49.0, lon).map(f64::to_radians)));
        let great = (chord[0] + chord[1]).normalize();
        assert!(great.distance(on_unit_sphere(EARTH, DVec2::new(49.0, -109.0).map(f64::to_radians))) > 0.01);
    }

    /// What faces the camera is what is over its horizon: against each place by itself.
    #[test]
    fn lines_end_at_the_limb() {
        let corners = [[60.0, -170.0], [-40.0, -20.0], [0.0, 40.0], [80.0, 170.0]];
        let path = Path::of(&corners, EARTH, 0.0);
        let last = path.corners.last().expect("corners").way;
        for camera in [DVec3::new(3.0, 0.4, 0.2), DVec3::new(-0.3, 1.02, 0.1), DVec3::new(0.1, 0.2, 40.0)] {
            let parts = path.facing(camera);
            assert!(!parts.is_empty() || camera.z < 0.15);
            for n in 0..=5000 {
                let way = 1.0 + (last - 1.0) * f64::from(n) / 5000.0;
                let over = camera.dot(path.at(way)) - 1.0;
                let is_in = parts.iter().any(|p| (p[0]..=p[p.len() - 1]).contains(&way));
                assert!(is_in == (over > 0.0) || over.abs() < 2e-4, "{camera}, {way}: {over}");
            }
        }
    }

    /// What a pixel cannot part is drawn as one line, and its end is kept.
    #[test]
    fn near_corners_are_one() {
        let corners: Vec<[f64; 2]> = (0..=10_000).map(|k| [0.0, f64::from(k) * 1e-4]).collect();
        let path = Path::of(&corners, EARTH, 1e-3);
        assert!((10..25).contains(&path.corners.len()), "{}", path.corners.len());
        assert!(path.corners.last().expect("corners").at.distance(DVec2::new(0.0, 1_f64.to_radians())) < 1e-12);
    }
}
