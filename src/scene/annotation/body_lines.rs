//! Lines on the ground of one body, on the side that faces the camera: its grid of planetographic latitude and planetocentric longitude, and its terminator.
//! `GroundLineBuilder` also draws smooth lines through given points for `eclipse_lines`, and collects the lines of `data_lines`.
//!
//! In: the placed body. Out: line segments, labels and decisions. Always: a line ends at the limb. The end is computed from the ellipsoid, not by the
//! depth test, so that lines do not flicker. Nearer bodies are drawn later, over the lines. Not modelled: relief and shape models.

use crate::message::{Reason, TextLanguage, reason};
use crate::scene::annotation::grids::{Cap, GridLineKind, MIN_LABELLED_OPACITY, angle_text, grid_lines, signed_angle_text};
use crate::scene::annotation::line_texts::UnplacedText;
use crate::scene::annotation::sky_lines::AnnotationLines;
use crate::scene::annotation::strokes::{Curve, reversed_depth, segments, split_into_quarter_turns};
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::eclipse::shadow_cone::GroundLine;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

const GRID_COLOUR: DVec3 = DVec3::new(0.9, 0.95, 1.0);
const GRID_OPACITY: f64 = 0.45;
const TERMINATOR_COLOUR: DVec3 = DVec3::new(1.0, 0.55, 0.15);
const TERMINATOR_OPACITY: f64 = 0.9;

/// A circle on the unit sphere: centre + a cos t + b sin t.
struct Circle {
    centre: DVec3,
    a: DVec3,
    b: DVec3,
}

/// The cap of the unit sphere that a camera outside this sphere sees, with a margin: it contains the planetographic latitude and the planetocentric longitude
/// of each visible point. `camera_position`: unit-sphere frame.
fn visible_cap(camera_position: DVec3, radii_km: DVec3) -> Cap {
    let distance = camera_position.length();
    let latitude_deg = (camera_position.z / distance).clamp(-1.0, 1.0).asin().to_degrees();
    // A hundredth of a degree allows for rounding.
    let radius_deg = (1.0 / distance).clamp(-1.0, 1.0).acos().to_degrees() + 0.01;
    // The tangents of latitude and longitude are those on the unit sphere times a ratio of two semi-axes, or times a number between two such ratios. For the
    // ratio of the semi-axes p > q, the largest difference of the angles has the sine (p - q) / (p + q): 3 degrees on Saturn. The margin is at least 6 degrees.
    let (longest, shortest) = (radii_km.max_element(), radii_km.min_element());
    let margin_deg = ((longest - shortest) / (longest + shortest)).asin().to_degrees().max(6.0);
    Cap {
        longitude_deg: camera_position.y.atan2(camera_position.x).to_degrees(),
        latitude_deg,
        radius_deg: (radius_deg + margin_deg).min(180.0),
    }
}

/// Number of points of a parallel that is no circle: the curve through them turns by less than a tenth of a radian from point to point.
const PARALLEL_POINTS: u32 = 128;

/// A parallel on a body with three different axes. `latitude_deg`: planetographic, between -90 and 90, both excluded. `first_angle_rad`: angle on the
/// unit sphere at which the parallel begins.
fn triaxial_parallel(latitude_deg: f64, radii_km: DVec3, first_angle_rad: f64) -> GroundLine {
    let point = |k: u32| {
        let equatorial = DVec2::from_angle(first_angle_rad + TAU * f64::from(k) / f64::from(PARALLEL_POINTS));
        // The normal is the point divided by the semi-axes. The tangent of its angle to the equator is that of the latitude.
        let z = radii_km.z * latitude_deg.to_radians().tan() * (equatorial / radii_km.truncate()).length();
        equatorial.extend(z).normalize()
    };
    GroundLine { points: (0..PARALLEL_POINTS).map(point).collect(), is_closed: true }
}

impl Circle {
    /// The parallel of the unit sphere with the given sine of latitude.
    fn of_latitude(sine: f64) -> Self {
        let radius = (1.0 - sine * sine).max(0.0).sqrt();
        Self { centre: DVec3::Z * sine, a: DVec3::X * radius, b: DVec3::Y * radius }
    }

    /// The circle through the poles that contains the meridian of a planetocentric longitude; its parameter is the latitude on the unit sphere, radians.
    fn of_longitude(longitude_deg: f64, radii_km: DVec3) -> Self {
        let on_equator = DVec2::from_angle(longitude_deg.to_radians()) / radii_km.truncate();
        Self { centre: DVec3::ZERO, a: on_equator.normalize().extend(0.0), b: DVec3::Z }
    }

    /// The point at a parameter.
    fn at(&self, t: f64) -> DVec3 {
        self.centre + self.a * t.cos() + self.b * t.sin()
    }

    /// The parts of a range of the parameter that are visible from a camera outside the unit sphere. The range must be within -pi to 2 pi,
    /// because the visible interval is tried only as it is, one turn earlier and one turn later.
    fn visible_intervals(&self, camera_position: DVec3, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
        // A point p is visible if p · camera > 1, that is, if offset + a cos t + b sin t = offset + amplitude cos(t - middle) is positive.
        let (offset, a, b) = (camera_position.dot(self.centre) - 1.0, camera_position.dot(self.a), camera_position.dot(self.b));
        let amplitude = a.hypot(b);
        if offset >= amplitude {
            return vec![[from, to]];
        }
        if offset <= -amplitude {
            return Vec::new();
        }
        let (middle, half) = (b.atan2(a), (-offset / amplitude).acos());
        let shifted_interval = |turn: f64| [(middle - half + turn).max(from), (middle + half + turn).min(to)];
        [-TAU, 0.0, TAU].map(shifted_interval).into_iter().filter(|[from, to]| from < to).collect()
    }
}

/// Collects the lines of one body.
pub(super) struct GroundLineBuilder<'a, 'b> {
    pub(super) camera: &'a Camera,
    pub(super) placed: &'a PlacedBody<'b>,
    pub(super) output: AnnotationLines,
}

/// Step of the curve parameter from one point of a [`GroundLine`] to the next. It is shorter than the longest span that [`Curve`] may replace by a chord, so
/// that only the deviation in pixels decides whether a span is halved.
const POINT_STEP: f64 = 0.15;

/// A Catmull-Rom curve (Catmull and Rom 1974) on the unit sphere. At an integer parameter k it passes through point k of the line.
fn curve_point(line: &GroundLine, t: f64) -> DVec3 {
    let count = line.points.len() as isize;
    let point = |k: isize| {
        if line.is_closed {
            return line.points[k.rem_euclid(count) as usize];
        }
        // Beyond an end the line continues as the parabola of its last three points.
        let extrapolate = |a: DVec3, b: DVec3, c: DVec3| 3.0 * (a - b) + c;
        match k {
            k if k < 0 => extrapolate(line.points[0], line.points[1], line.points[2]),
            k if k >= count => {
                let last = line.points.len() - 1;
                extrapolate(line.points[last], line.points[last - 1], line.points[last - 2])
            }
            k => line.points[k as usize],
        }
    };
    let first = if line.is_closed { t.floor() } else { t.floor().clamp(0.0, (count - 2).max(0) as f64) };
    let (k, u) = (first as isize, t - first);
    let [a, b, c, d] = [point(k - 1), point(k), point(k + 1), point(k + 2)];
    let cubic = b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)));
    cubic.normalize()
}

impl GroundLineBuilder<'_, '_> {
    /// Draws the visible part of a circle in a range of its parameter. `opacity`: opacity at a parameter. Returns the position of the label: the middle of the
    /// first part inside the frame, in camera axes.
    fn draw_circle(&mut self, circle: &Circle, range: [f64; 2], opacity: &dyn Fn(f64) -> f64, colour: DVec3) -> Option<DVec3> {
        let placement = &self.placed.placement;
        let point = |t: f64| placement.centre_km + placement.body_from_icrf.transpose() * (circle.at(t) * placement.radii_km);
        let curve = Curve { camera: self.camera, point: &point, derivative_bound: placement.radii_km.max_element(), tolerance_factor: 1.0 };
        let mut label_point = None;
        for [from, to] in circle.visible_intervals(placement.camera_in_unit_sphere(), range) {
            for run in curve.runs(&split_into_quarter_turns([from, to])) {
                label_point = label_point.or(run.get(run.len() / 2).map(|point| point.position));
                self.output.segments.extend(segments(self.camera, &run, reversed_depth, opacity, colour));
            }
        }
        label_point
    }

    /// Draws the visible part of a smooth line through points; nothing for fewer than three points. Returns the position of the label: the middle of the part
    /// inside the frame, in camera axes.
    pub(super) fn draw_line(&mut self, line: &GroundLine, opacity: f64, colour: DVec3) -> Option<DVec3> {
        let placement = &self.placed.placement;
        let camera_position = placement.camera_in_unit_sphere();
        let count = line.points.len();
        if count < 3 {
            return None;
        }
        let spans = if line.is_closed { count } else { count - 1 };
        // Height of the camera above the plane that touches the unit sphere at the point: positive where the camera sees the point.
        let camera_height = |t: f64| camera_position.dot(curve_point(line, t)) - 1.0;
        let limb_between = |mut visible: f64, mut hidden: f64| {
            for _ in 0..40 {
                let middle = 0.5 * (visible + hidden);
                if camera_height(middle) > 0.0 { visible = middle } else { hidden = middle }
            }
            visible
        };
        let point =
            |t: f64| placement.centre_km + placement.body_from_icrf.transpose() * (curve_point(line, t / POINT_STEP) * placement.radii_km);
        let longest_step = (0..spans).map(|k| line.points[k].distance(line.points[(k + 1) % count])).fold(0.0, f64::max);
        // The derivative bound, with its factor of 1.5, is valid for a curve that turns by less than a tenth of a radian from point to point.
        let curve = Curve {
            camera: self.camera,
            point: &point,
            derivative_bound: 1.5 / POINT_STEP * longest_step * placement.radii_km.max_element(),
            tolerance_factor: 1.0,
        };
        let mut middles = Vec::new();
        for k in 0..spans {
            let (from, to) = (k as f64, (k + 1) as f64);
            let range = match (camera_height(from) > 0.0, camera_height(to) > 0.0) {
                (true, true) => [from, to],
                (true, false) => [from, limb_between(from, to)],
                (false, true) => [limb_between(to, from), to],
                (false, false) => continue,
            };
            for run in curve.runs(&range.map(|t| t * POINT_STEP)) {
                middles.extend(run.get(run.len() / 2).map(|point| point.position));
                self.output.segments.extend(segments(self.camera, &run, reversed_depth, |_| opacity, colour));
            }
        }
        middles.get(middles.len() / 2).copied()
    }

    /// Records a decision about one layer.
    pub(super) fn record_decision(&mut self, effect: &'static str, on: bool, reason: Reason) {
        self.output.decisions.push(Decision { effect, on, reason, stated_error: None });
    }

    /// Draws the grid of latitude and longitude, with its coordinates.
    pub(super) fn grid(&mut self, language: TextLanguage) {
        let radii_km = self.placed.placement.radii_km;
        let camera_position = self.placed.placement.camera_in_unit_sphere();
        // Degrees of latitude per pixel at the sub-observer point.
        let height_km = (camera_position.length() - 1.0).max(1e-9) * radii_km.x;
        let pixel_deg = (height_km * self.camera.pixel_tangent() / radii_km.x).to_degrees();
        let mut count = 0;
        for line in grid_lines(visible_cap(camera_position, radii_km), pixel_deg) {
            let opacity = |t: f64| {
                let latitude_deg = if line.kind == GridLineKind::Meridian { t.to_degrees() } else { line.coordinate_deg };
                GRID_OPACITY * line.opacity(latitude_deg, pixel_deg)
            };
            let label_point = match line.kind {
                GridLineKind::Parallel if radii_km.x == radii_km.y => {
                    // The latitude on the unit sphere that corresponds to the planetographic latitude.
                    let latitude_on_sphere = (radii_km.z / radii_km.x * line.coordinate_deg.to_radians().tan()).atan();
                    self.draw_circle(&Circle::of_latitude(latitude_on_sphere.sin()), [0.0, TAU], &opacity, GRID_COLOUR)
                }
                GridLineKind::Parallel => {
                    // It begins on the far side, so that the visible part is in one piece. The opacity is the same at every parameter.
                    let far_side_rad = (-camera_position.y).atan2(-camera_position.x);
                    self.draw_line(&triaxial_parallel(line.coordinate_deg, radii_km, far_side_rad), opacity(0.0), GRID_COLOUR)
                }
                GridLineKind::Meridian => {
                    let range = line.latitude_range_deg(pixel_deg).map(f64::to_radians);
                    self.draw_circle(&Circle::of_longitude(line.coordinate_deg, radii_km), range, &opacity, GRID_COLOUR)
                }
            };
            let Some(label_point) = label_point else { continue };
            count += 1;
            let text = match line.kind {
                GridLineKind::Parallel => signed_angle_text(line.coordinate_deg),
                GridLineKind::Meridian => format!("{}{}", angle_text(line.coordinate_deg), language.name("compass", "E")),
            };
            let clip = DVec2::new(label_point.x, label_point.y) / (label_point.z * self.camera.tan_half_fov);
            // A meridian is labelled if its opacity at the equator is high enough.
            if clip.abs().max_element() < 1.0 && line.opacity(0.0, pixel_deg) > MIN_LABELLED_OPACITY {
                self.output.texts.push(UnplacedText {
                    text,
                    centre_px: self.camera.pixel_from_clip(clip),
                    colour: GRID_COLOUR,
                    is_grid_coordinate: true,
                });
            }
        }
        let reason = reason!("lines-body", count = count, body = &self.placed.body.name);
        self.record_decision("grid-body", count > 0, reason);
    }

    /// Draws the terminator.
    pub(super) fn terminator(&mut self) {
        // On the terminator the Sun's centre is on the horizon: its direction is perpendicular to the ellipsoid's normal. On the unit sphere these points
        // form a great circle.
        let sun = self.placed.body_from_icrf * self.placed.body_to_sun_km / self.placed.placement.radii_km;
        let Some(pole) = sun.try_normalize() else { return self.record_decision("terminator", false, reason!("lines-no-sun")) };
        let a = pole.any_orthonormal_vector();
        let circle = Circle { centre: DVec3::ZERO, a, b: pole.cross(a) };
        let drawn = self.draw_circle(&circle, [-PI, PI], &|_| TERMINATOR_OPACITY, TERMINATOR_COLOUR).is_some();
        let reason = if drawn { reason!("lines-terminator", body = &self.placed.body.name) } else { reason!("lines-not-in-frame") };
        self.record_decision("terminator", drawn, reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::topocentric::place_of_normal_deg;
    use crate::random::Random;

    /// Semi-axes of Amalthea, a very elongated body with three different axes.
    const AMALTHEA_KM: DVec3 = DVec3::new(125.0, 73.0, 64.0);

    /// Planetographic latitude and planetocentric longitude of a point of the unit sphere.
    fn place_deg(point: DVec3, radii_km: DVec3) -> [f64; 2] {
        place_of_normal_deg(radii_km, point / radii_km)
    }

    /// On a body with three different axes: parallels have their planetographic latitude, also between the points that define them, and meridians their
    /// planetocentric longitude. Circles and angles of the unit sphere, which the program drew formerly, are degrees away from them.
    #[test]
    fn the_grid_of_a_triaxial_body_has_its_latitudes_and_longitudes() {
        let (mut from_circle_deg, mut from_sphere_deg) = (0.0_f64, 0.0_f64);
        for coordinate_deg in [-80.0, -45.0, -10.0, 0.0, 30.0, 60.0] {
            let first_angle_rad = 0.4;
            let parallel = triaxial_parallel(coordinate_deg, AMALTHEA_KM, first_angle_rad);
            for k in 0..4 * PARALLEL_POINTS {
                let [latitude_deg, _] = place_deg(curve_point(&parallel, 0.25 * f64::from(k)), AMALTHEA_KM);
                // The curve between the points is cubic.
                assert!((latitude_deg - coordinate_deg).abs() < 1e-3, "{coordinate_deg}: {latitude_deg}");
            }
            let circle = Circle::of_latitude((AMALTHEA_KM.z / AMALTHEA_KM.x * coordinate_deg.to_radians().tan()).atan().sin());
            let meridian = Circle::of_longitude(coordinate_deg, AMALTHEA_KM);
            for t in [-1.4, -0.3, 0.0, 0.8, 1.5] {
                let [_, longitude_deg] = place_deg(meridian.at(t), AMALTHEA_KM);
                assert!((longitude_deg - coordinate_deg).abs() < 1e-9, "{coordinate_deg}: {longitude_deg}");
                from_circle_deg = from_circle_deg.max((place_deg(circle.at(t), AMALTHEA_KM)[0] - coordinate_deg).abs());
                let on_sphere_deg = meridian.a.y.atan2(meridian.a.x).to_degrees();
                from_sphere_deg = from_sphere_deg.max((on_sphere_deg - coordinate_deg).abs());
            }
        }
        assert!(from_circle_deg > 5.0 && from_sphere_deg > 10.0, "{from_circle_deg} {from_sphere_deg}");
    }

    /// The visible intervals agree with a visibility test of each sampled point.
    #[test]
    fn lines_end_at_the_limb() {
        for (k, camera) in [DVec3::new(3.0, 0.4, 0.2), DVec3::new(-0.3, 1.02, 0.1), DVec3::new(0.1, 0.2, 40.0)].into_iter().enumerate() {
            let meridians = [77.0, 310.0].map(|longitude_deg| Circle::of_longitude(longitude_deg, AMALTHEA_KM));
            for circle in [0.3, -0.99].map(Circle::of_latitude).into_iter().chain(meridians) {
                let range = [-1.5, 4.0];
                let found = circle.visible_intervals(camera, range);
                for n in 0..=5000 {
                    let t = range[0] + (range[1] - range[0]) * f64::from(n) / 5000.0;
                    let camera_height = camera.dot(circle.at(t)) - 1.0;
                    let is_in = found.iter().any(|[from, to]| (*from..=*to).contains(&t));
                    assert!(is_in == (camera_height > 0.0) || camera_height.abs() < 1e-9, "camera {k}, {t}: {camera_height}");
                }
            }
        }
    }

    /// Latitude and longitude of every visible point are in the cap, on bodies as flat as the Earth, Saturn, Phobos and Prometheus, and on Amalthea. With the
    /// margin of 6 degrees, which suffices for Saturn, the last three would lack parallels.
    #[test]
    fn the_visible_cap_contains_all_visible_latitudes_and_longitudes() {
        let mut random = Random::new(3);
        let spheroids = [(0.99665, false), (0.902, false), (0.7, true), (0.413, true)];
        let bodies = spheroids.map(|(axis_ratio, exceeds_6_deg)| (DVec3::new(1.0, 1.0, axis_ratio), exceeds_6_deg));
        for (radii_km, exceeds_6_deg) in bodies.into_iter().chain([(AMALTHEA_KM, true)]) {
            let (mut visible, mut beyond_6_deg) = (0, 0);
            for _ in 0..100_000 {
                let camera = random.direction() * random.between(1.01, 1.5);
                let point = random.direction();
                if point.dot(camera) <= 1.0 {
                    continue;
                }
                visible += 1;
                let [latitude_deg, longitude_deg] = place_deg(point, radii_km);
                let cap = visible_cap(camera, radii_km);
                let from_middle_deg = (latitude_deg - cap.latitude_deg).abs();
                assert!(from_middle_deg <= cap.radius_deg, "{radii_km}: {latitude_deg} seen from {camera}");
                // On a sphere the margin is 6 degrees.
                beyond_6_deg += u32::from(from_middle_deg > visible_cap(camera, DVec3::ONE).radius_deg);
                // A cap around a pole has all longitudes.
                let sine = cap.radius_deg.to_radians().sin() / cap.latitude_deg.to_radians().cos();
                if cap.radius_deg < 90.0 && sine < 1.0 {
                    let aside_deg = ((longitude_deg - cap.longitude_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
                    assert!(aside_deg <= sine.asin().to_degrees(), "{radii_km}: {longitude_deg} seen from {camera}");
                }
            }
            assert!(visible > 1000, "{radii_km}: {visible}");
            assert_eq!(beyond_6_deg > 0, exceeds_6_deg, "{radii_km}: {beyond_6_deg} of {visible}");
        }
    }
}
