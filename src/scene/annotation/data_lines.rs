//! Lines of the user's data on the ground of one body, on the side that faces the camera.
//!
//! In: the layers, the time, and the placed body. Out: line segments and a decision. Always: a line is straight in longitude and planetographic latitude from
//! vertex to vertex (RFC 7946, section 3.1.1) and ends at the limb. Between vertices more than half a turn apart in longitude the line takes the shorter way
//! around; only a line of two vertices at the same latitude, a whole turn apart, is a whole parallel. A line appears at its time and fades like a data point.
//! Vertices closer than `MERGE_PX` are merged. Ignores relief and shape models. A million vertices take about 0.2 s per frame.

use crate::catalog::DataLayer;
use crate::ephemeris::topocentric::ground_point_km;
use crate::message::{Reason, reason};
use crate::scene::annotation::body_lines::GroundLineBuilder;
use crate::scene::annotation::data::opacity_at;
use crate::scene::annotation::strokes::{Curve, reversed_depth, segments};
use crate::scene::camera::NEAR_DEPTH_KM;
use crate::time::Instant;
use crate::units::srgb_to_linear;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Distance below which vertices are merged, pixels.
const MERGE_PX: f64 = 0.3;
/// Largest step between points at which a line is tested against the limb. The length of a step is the sum of its changes of latitude and longitude.
const STEP_RAD: f64 = 0.05;

/// A vertex of the data, or a point inserted between two vertices.
struct Vertex {
    /// Planetographic latitude (x) and east longitude (y), radians.
    lat_lon: DVec2,
    /// Parameter of the curve: length of the path up to here, radians; the length of a step is as for [`STEP_RAD`].
    parameter: f64,
    /// Position on the unit sphere.
    point: DVec3,
}

/// A line subdivided into steps.
struct Path {
    vertices: Vec<Vertex>,
    radii_km: DVec3,
}

/// The point of the unit sphere at a planetographic latitude (x) and an east longitude (y), radians.
fn on_unit_sphere(radii_km: DVec3, lat_lon: DVec2) -> DVec3 {
    let height_km = 0.0;
    let (ground_km, _normal) = ground_point_km(radii_km, lat_lon.x.to_degrees(), lat_lon.y.to_degrees(), height_km);
    ground_km / radii_km
}

impl Path {
    /// `vertices`: planetographic latitude and east longitude, degrees. `merge_distance`: distance on the unit sphere below which vertices are merged.
    fn of(vertices: &[[f64; 2]], radii_km: DVec3, merge_distance: f64) -> Self {
        let mut path = Self { vertices: Vec::with_capacity(vertices.len()), radii_km };
        for (k, vertex) in vertices.iter().enumerate() {
            let mut to = DVec2::new(vertex[0], vertex[1]).map(f64::to_radians);
            let Some(last) = path.vertices.last() else {
                path.vertices.push(Vertex { lat_lon: to, parameter: 0.0, point: on_unit_sphere(radii_km, to) });
                continue;
            };
            let (from, mut parameter) = (last.lat_lon, last.parameter);
            // A line of only two vertices, at the same latitude and a whole turn apart, is a whole parallel, such as the equator. In a line of more vertices
            // such a step crosses the antimeridian.
            let is_whole_parallel = vertices.len() == 2 && to.x == from.x && (to.y - from.y).abs() > TAU - 1e-9;
            if (to.y - from.y).abs() > PI && !is_whole_parallel {
                to.y -= TAU * ((to.y - from.y) / TAU).round();
            }
            let is_last = k + 1 == vertices.len();
            if !is_last && last.point.distance_squared(on_unit_sphere(radii_km, to)) < merge_distance * merge_distance {
                continue;
            }
            let length = (to - from).abs().element_sum();
            if length < 1e-12 {
                continue;
            }
            let steps = (length / STEP_RAD).ceil().max(1.0);
            for n in 1..=steps as usize {
                let lat_lon = from.lerp(to, n as f64 / steps);
                parameter += length / steps;
                path.vertices.push(Vertex { lat_lon, parameter, point: on_unit_sphere(radii_km, lat_lon) });
            }
        }
        path
    }

    /// The point on the unit sphere at a parameter.
    fn at(&self, parameter: f64) -> DVec3 {
        let next = self.vertices.partition_point(|v| v.parameter < parameter).clamp(1, self.vertices.len() - 1);
        let [a, b] = [&self.vertices[next - 1], &self.vertices[next]];
        on_unit_sphere(self.radii_km, a.lat_lon.lerp(b.lat_lon, (parameter - a.parameter) / (b.parameter - a.parameter)))
    }

    /// The parts visible from a camera outside the unit sphere, each as the parameters of its points.
    fn visible_parts(&self, camera: DVec3) -> Vec<Vec<f64>> {
        // Height of the camera above the plane that touches the unit sphere at the point: positive where the camera sees the point.
        let camera_height = |point: DVec3| camera.dot(point) - 1.0;
        let limb_between = |mut visible: f64, mut hidden: f64| {
            for _ in 0..40 {
                let middle = 0.5 * (visible + hidden);
                if camera_height(self.at(middle)) > 0.0 { visible = middle } else { hidden = middle }
            }
            visible
        };
        let mut parts: Vec<Vec<f64>> = Vec::new();
        for (k, vertex) in self.vertices.iter().enumerate() {
            let previous = k.checked_sub(1).map(|k| &self.vertices[k]);
            let previous_if_visible = previous.filter(|p| camera_height(p.point) > 0.0);
            match (previous_if_visible, camera_height(vertex.point) > 0.0, parts.last_mut()) {
                (Some(_), true, Some(part)) => part.push(vertex.parameter),
                (Some(p), false, Some(part)) => part.push(limb_between(p.parameter, vertex.parameter)),
                (_, true, _) => {
                    let limb = previous.map(|p| limb_between(vertex.parameter, p.parameter));
                    parts.push(limb.into_iter().chain([vertex.parameter]).collect());
                }
                (_, false, _) => {}
            }
        }
        parts.retain(|p| p.len() > 1);
        parts
    }
}

/// Draws the lines of all layers of the body.
pub(super) fn on_ground(builder: &mut GroundLineBuilder<'_, '_>, layers: &[Arc<DataLayer>], now: Instant) {
    let placement = builder.placed.placement;
    let radii_km = placement.radii_km;
    let nearest_km = (builder.placed.distance_km - radii_km.max_element()).max(NEAR_DEPTH_KM);
    let merge_distance = MERGE_PX * builder.camera.pixel_tangent() * nearest_km / radii_km.max_element();
    // The lengths of the first and second derivatives of `point` with respect to its parameter are at most a^4 / (b c^2), where a is the longest semi-axis, b
    // the shorter one of the equator and c the shortest; sampled for shapes down to b = a / 2 and c = 0.4 b. The radius of curvature of a meridian is up to
    // a^2 / c.
    let [longest, shortest, shorter_equatorial] = [radii_km.max_element(), radii_km.min_element(), radii_km.truncate().min_element()];
    let derivative_bound = longest.powi(4) / (shorter_equatorial * shortest * shortest);
    let icrf_from_body = placement.body_from_icrf.transpose();
    let (mut segment_count, mut descriptions) = (0, Vec::new());
    for layer in layers.iter().filter(|l| l.body == Some(builder.placed.body.id) && !l.lines.is_empty()) {
        let colour = DVec3::from_array(layer.colour.map(|c| srgb_to_linear(f64::from(c) / 255.0)));
        let count_before = builder.output.segments.len();
        for line in layer.lines.iter() {
            let Some(opacity) = opacity_at(layer, line.time, now) else { continue };
            let path = Path::of(&line.vertices, radii_km, merge_distance);
            if path.vertices.len() < 2 {
                continue;
            }
            let point = |parameter: f64| placement.centre_km + icrf_from_body * (path.at(parameter) * radii_km);
            let curve = Curve { camera: builder.camera, point: &point, derivative_bound, tolerance_factor: 1.0 };
            for part in path.visible_parts(placement.camera_in_unit_sphere()) {
                for run in curve.runs(&part) {
                    builder.output.segments.extend(segments(builder.camera, &run, reversed_depth, |_| opacity, colour));
                }
            }
        }
        segment_count += builder.output.segments.len() - count_before;
        descriptions.push(reason!("lines-of", count = layer.lines.len(), layer = &layer.name));
    }
    let layers: Reason = descriptions.into_iter().collect();
    let reason = if segment_count > 0 { layers } else { reason!("lines-none-now", layers = layers) };
    builder.record_decision("data", segment_count > 0, reason);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Merge distances, in units of the unit sphere's radius.
    const NO_MERGING: f64 = 0.0;
    const MERGE_DISTANCE: f64 = 1e-3;
    const EARTH_RADII_KM: DVec3 = DVec3::new(6378.137, 6378.137, 6356.752);

    /// Between vertices a line is straight in longitude and latitude, also across the antimeridian.
    #[test]
    fn a_line_is_straight_in_longitude_and_latitude() {
        for (vertices, middle) in [([[49.0, -123.0], [49.0, -95.0]], [49.0, -109.0]), ([[10.0, 179.0], [20.0, -179.0]], [15.0, 180.0])] {
            let path = Path::of(&vertices, EARTH_RADII_KM, NO_MERGING);
            let last = path.vertices.last().expect("a vertex").parameter;
            let found = path.at(0.5 * last);
            let expected = on_unit_sphere(EARTH_RADII_KM, DVec2::from_array(middle).map(f64::to_radians));
            assert!(found.distance(expected) < 1e-9, "{vertices:?}: {found} {expected}");
        }
        // A great circle differs: the middle of the first line would be 2.2 degrees farther north.
        let chord = [-123.0, -95.0].map(|lon| on_unit_sphere(EARTH_RADII_KM, DVec2::new(49.0, lon).map(f64::to_radians)));
        let great_circle_middle = (chord[0] + chord[1]).normalize();
        assert!(great_circle_middle.distance(on_unit_sphere(EARTH_RADII_KM, DVec2::new(49.0, -109.0).map(f64::to_radians))) > 0.01);
    }

    /// The Arctic Circle from one side of the antimeridian to the other is a whole turn; in a line of more vertices such a step crosses the antimeridian.
    #[test]
    fn a_line_of_a_whole_turn_is_a_parallel() {
        let length_deg = |vertices: &[[f64; 2]]| {
            let path = Path::of(vertices, EARTH_RADII_KM, MERGE_DISTANCE);
            path.vertices.last().expect("a vertex").parameter.to_degrees()
        };
        assert!((length_deg(&[[66.56, -180.0], [66.56, 180.0]]) - 360.0).abs() < 1e-6);
        assert!((length_deg(&[[10.0, 179.0], [10.0, 180.0], [10.0, -180.0], [10.0, -179.0]]) - 2.0).abs() < 1e-6);
    }

    /// The visible parts agree with a visibility test of each sampled point.
    #[test]
    fn lines_end_at_the_limb() {
        let vertices = [[60.0, -170.0], [-40.0, -20.0], [0.0, 40.0], [80.0, 170.0]];
        let path = Path::of(&vertices, EARTH_RADII_KM, NO_MERGING);
        let last = path.vertices.last().expect("a vertex").parameter;
        for camera in [DVec3::new(3.0, 0.4, 0.2), DVec3::new(-0.3, 1.02, 0.1), DVec3::new(0.1, 0.2, 40.0)] {
            let parts = path.visible_parts(camera);
            // The second camera is so low that it may see no part of the line.
            assert!(!parts.is_empty() || camera.z < 0.15);
            for n in 0..=5000 {
                let parameter = last * f64::from(n) / 5000.0;
                let camera_height = camera.dot(path.at(parameter)) - 1.0;
                let is_in = parts.iter().any(|p| (p[0]..=p[p.len() - 1]).contains(&parameter));
                // Visibility is tested at the ends of steps only: within a step the height may pass 0 unnoticed, here by less than 2e-4.
                assert!(is_in == (camera_height > 0.0) || camera_height.abs() < 2e-4, "{camera}, {parameter}: {camera_height}");
            }
        }
    }

    /// Vertices closer than the merge distance become one, and the last vertex is kept.
    #[test]
    fn close_vertices_are_merged() {
        let vertices: Vec<[f64; 2]> = (0..=10_000).map(|k| [0.0, f64::from(k) * 1e-4]).collect();
        let path = Path::of(&vertices, EARTH_RADII_KM, MERGE_DISTANCE);
        // The line is one degree long: 17.5 merge distances.
        assert!((10..25).contains(&path.vertices.len()), "{}", path.vertices.len());
        assert!(path.vertices.last().expect("a vertex").lat_lon.distance(DVec2::new(0.0, 1_f64.to_radians())) < 1e-12);
    }
}
