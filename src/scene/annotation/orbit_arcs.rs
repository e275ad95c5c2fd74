//! The conic on which a body moves about its parent, cut into arcs for the vertex stage of shaders/entry/orbit.wesl.
//!
//! In: the body's position and velocity relative to the parent, and its position from the camera. Out: [`OrbitArc`]s: a point of the conic in camera axes
//! with its first and second derivative with respect to the universal anomaly, computed in f64 and narrowed. The third derivative is -alpha times the first,
//! with alpha = GM / semi-major axis, so Stumpff's functions give every point of the arc, on ellipse, parabola and hyperbola alike (`ephemeris::conic`).
//! Always: if the body is in the frame, its position is a vertex, so that the line passes through the body's disc at any distance. An arc outside the frame
//! is left out. Any other arc is halved until its `CHORDS_PER_ARC` chords deviate on the screen by less than `MAX_CHORD_ERROR_PX` and it is not much larger
//! than the frame; its f32 values are then precise to hundredths of a pixel.

use crate::ephemeris::State;
use crate::ephemeris::conic::stumpff;
use crate::scene::annotation::strokes::MARGIN_PX;
use crate::scene::camera::{Camera, NEAR_DEPTH_KM, narrow, narrow_scalar};
use crate::scene::numeric::smooth_rise;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Largest deviation of a chord from its arc, pixels.
pub(crate) const MAX_CHORD_ERROR_PX: f64 = 0.05;
/// Chords per arc. They are few, so that the ends of an orbit seen edge-on, where it curves on the screen, do not force short arcs on its straight parts.
pub(crate) const CHORDS_PER_ARC: u32 = 4;
/// [`size_on_screen_px`] at which an orbit starts to appear, and at which it is opaque.
pub(super) const FADE_PX: (f64, f64) = (3.0, 12.0);
/// Maximum number of halvings of an orbit: an arc of an orbit with a semi-major axis of 100 au is then some tens of metres long. An arc that is still too long
/// or too curved is left out.
const MAX_HALVINGS: u32 = 40;
/// Largest argument of Stumpff's functions on an arc: alpha times the square of the universal anomaly between its ends. The shader's series are accurate up to
/// 0.7.
const MAX_STUMPFF_ARGUMENT: f64 = 0.65;
/// Largest half length of an arc across the line of sight, in half diagonals of the frame at the distance of the arc's nearest point.
const MAX_HALF_LENGTH_ACROSS: f64 = 2.0;
/// Opacity one revolution behind the body, relative to the opacity at the body: the line fades backwards along the path.
const MIN_OPACITY: f64 = 0.25;
/// An open path is drawn up to the larger of two distances from the parent: this multiple of the periapsis distance, and
/// [`OPEN_PATH_PER_BODY_DISTANCE`] times the body's distance.
const OPEN_PATH_PER_PERIAPSIS: f64 = 40.0;
/// See [`OPEN_PATH_PER_PERIAPSIS`].
const OPEN_PATH_PER_BODY_DISTANCE: f64 = 3.0;
/// Ratio of an ellipse's semi-major axis to the body's distance from the parent up to which the whole ellipse is drawn; a longer one is drawn like an open
/// path.
const MAX_WHOLE_SIZE_RATIO: f64 = 400.0;

/// An arc of a conic. Its parameter u is the universal anomaly, counted from a point of the arc, divided by that of the whole arc: it increases by 1 along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitArc {
    /// Position at u = 0 in camera axes (right, up, forward), km; x and y are divided by the tangents of half the field of view.
    pub point: Vec3,
    /// First and second derivative of the position with respect to u, at u = 0, in the axes of `point`.
    pub first_derivative: Vec3,
    pub second_derivative: Vec3,
    /// Argument of Stumpff's functions at u = 1: the conic's alpha times the square of the universal anomaly between the arc's ends.
    pub alpha: f32,
    /// First and last u: -1 and 0 or 0 and 1 if the arc ends or begins at the body, which is then at u = 0; otherwise -0.5 and 0.5.
    pub range: [f32; 2],
    /// Opacity at the first and last u.
    pub opacity: [f32; 2],
    /// Linear RGB.
    pub colour: Vec3,
}

impl OrbitArc {
    /// x and y from -1 to 1 across the frame (y up) and reversed depth, at a fraction of the arc, 0 to 1; computed from the narrowed values.
    pub fn clip(&self, fraction: f64) -> DVec3 {
        let [first, last] = self.range.map(f64::from);
        let u = first + (last - first) * fraction;
        let [_, c1, c2, _] = stumpff(f64::from(self.alpha) * u * u);
        let p = self.point.as_dvec3() + self.first_derivative.as_dvec3() * (u * c1) + self.second_derivative.as_dvec3() * (u * u * c2);
        DVec3::new(p.x / p.z, p.y / p.z, NEAR_DEPTH_KM / p.z)
    }
}

/// A conic about the parent, parameterised by the universal anomaly s, which is 0 at the body: ds = dt / r, in seconds per kilometre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Conic {
    /// First and second derivative of the position with respect to s, at the body, in the axes of `body_from_parent_km`.
    first_derivative: DVec3,
    second_derivative: DVec3,
    /// GM over the semi-major axis, km^2/s^2: negative on a hyperbola.
    alpha: f64,
    gm_km3_s2: f64,
    /// The body's position relative to the parent, km.
    body_from_parent_km: DVec3,
}

impl Conic {
    /// The orbit of a state relative to a parent. `gm_km3_s2`: GM of both bodies together. `None` without gravity, for a radial path, or if a number is not
    /// finite.
    pub(crate) fn of(state: &State, gm_km3_s2: f64) -> Option<Self> {
        let (r, v) = (state.pos_km, state.vel_km_s);
        let distance = r.length();
        let alpha = 2.0 * gm_km3_s2 / distance - v.length_squared();
        let conic = Self {
            // d/ds = r d/dt, with the acceleration -GM r / |r|^3.
            first_derivative: v * distance,
            second_derivative: v * r.dot(v) - r * (gm_km3_s2 / distance),
            alpha,
            gm_km3_s2,
            body_from_parent_km: r,
        };
        let is_valid = gm_km3_s2 > 0.0 && r.cross(v).length() > 0.0 && alpha.is_finite() && conic.second_derivative.is_finite();
        is_valid.then_some(conic)
    }

    /// The semi-major axis of an ellipse that is drawn as a whole; for any other path the body's distance from the parent.
    pub(crate) fn size_km(&self) -> f64 {
        if self.is_drawn_whole() { self.gm_km3_s2 / self.alpha } else { self.body_from_parent_km.length() }
    }

    /// Whether the conic is drawn as a whole.
    fn is_drawn_whole(&self) -> bool {
        self.alpha > 0.0 && self.gm_km3_s2 / self.alpha < MAX_WHOLE_SIZE_RATIO * self.body_from_parent_km.length()
    }

    /// Vector from the body to the point at s, in the axes of the body's state, without loss of precision close to the body.
    pub(crate) fn offset_from_body_km(&self, s: f64) -> DVec3 {
        let [_, c1, c2, _] = stumpff(self.alpha * s * s);
        self.first_derivative * (s * c1) + self.second_derivative * (s * s * c2)
    }

    /// First and second derivative at s.
    fn derivatives(&self, s: f64) -> [DVec3; 2] {
        let [c0, c1, ..] = stumpff(self.alpha * s * s);
        [
            self.first_derivative * c0 + self.second_derivative * (s * c1),
            self.second_derivative * c0 - self.first_derivative * (self.alpha * s * c1),
        ]
    }

    /// Range of s that is drawn: half a revolution back and ahead, or the ends of an open path.
    pub(crate) fn drawn_range(&self) -> [f64; 2] {
        if self.is_drawn_whole() {
            let half = PI / self.alpha.sqrt();
            return [-half, half];
        }
        // The periapsis distance q follows from q (1 + e) = h^2 / GM, with the eccentricity e and the specific angular momentum h.
        let distance = self.body_from_parent_km.length();
        let momentum_sq = self.body_from_parent_km.cross(self.first_derivative / distance).length_squared();
        let eccentricity = (1.0 - self.alpha * momentum_sq / (self.gm_km3_s2 * self.gm_km3_s2)).max(0.0).sqrt();
        let end_distance =
            (OPEN_PATH_PER_PERIAPSIS * momentum_sq / (self.gm_km3_s2 * (1.0 + eccentricity))).max(OPEN_PATH_PER_BODY_DISTANCE * distance);
        let end = |sign: f64| {
            // To first order the point is then as far from the body as the parent is. The steps may overshoot the end by up to a quarter of s.
            let mut s = sign * distance / self.first_derivative.length();
            // The limit of s ends the loop if rounding keeps the point from reaching the distance.
            while (self.body_from_parent_km + self.offset_from_body_km(s)).length() < end_distance && s.abs() < 1e30 {
                s *= 1.25;
            }
            s
        };
        [end(-1.0), end(1.0)]
    }
}

/// [`Conic::size_km`] in pixels, seen at the distance of the ellipse's centre, or at that of the body if the path is not drawn as a whole. The distance
/// counts as at least the size. `body_from_camera_km`: ICRF.
pub(crate) fn size_on_screen_px(camera: &Camera, conic: &Conic, body_from_camera_km: DVec3) -> f64 {
    let size_km = conic.size_km();
    // The body and the point half a revolution ahead are opposite to each other about the ellipse's centre.
    let centre_from_body_km = if conic.is_drawn_whole() { 0.5 * conic.offset_from_body_km(conic.drawn_range()[1]) } else { DVec3::ZERO };
    size_km / (body_from_camera_km + centre_from_body_km).length().max(size_km) / camera.pixel_tangent()
}

/// Divides one orbit into arcs.
struct ArcSubdivision<'a> {
    camera: &'a Camera,
    conic: &'a Conic,
    /// The body's apparent position from the camera, ICRF.
    body_from_camera_km: DVec3,
    /// Linear RGB.
    colour: DVec3,
    /// Opacity at the body.
    opacity: f64,
    /// [`Conic::drawn_range`].
    drawn_range: [f64; 2],
    arcs: Vec<OrbitArc>,
}

impl ArcSubdivision<'_> {
    /// Opacity at s. It decreases from the body backwards along the whole orbit, so that it is lowest just ahead of the body. `is_ahead`: whether the arc is
    /// ahead of the body; it decides the opacity at s = 0, where the arcs ahead of the body and behind it meet.
    fn opacity_at(&self, s: f64, is_ahead: bool) -> f32 {
        let [back_end, ahead_end] = self.drawn_range;
        // 1 at the body, 0 at the point farthest back along the path, and ahead of the body on an open path. On an orbit drawn as a whole the point farthest
        // back is the body again: going backwards, the half behind the body is followed by the half ahead of it.
        let brightness = if !self.conic.is_drawn_whole() {
            if is_ahead { 0.0 } else { 1.0 - s / back_end }
        } else if is_ahead {
            0.5 * s / ahead_end
        } else {
            1.0 - 0.5 * s / back_end
        };
        narrow_scalar(self.opacity * (MIN_OPACITY + (1.0 - MIN_OPACITY) * brightness))
    }

    /// Largest distance on the screen, in pixels, between a chord and the middle of the part of the arc that it replaces.
    fn chord_error_px(&self, from: f64, to: f64) -> f64 {
        // The point of the arc after `k` halves of chords.
        let on_screen_px = |k: u32| {
            let s = from + (to - from) * f64::from(k) / f64::from(2 * CHORDS_PER_ARC);
            let point = self.camera.in_axes(self.body_from_camera_km + self.conic.offset_from_body_km(s));
            point.truncate() / (point.z * self.camera.pixel_tangent())
        };
        let mut start = on_screen_px(0);
        let mut largest = 0.0_f64;
        for chord in 0..CHORDS_PER_ARC {
            let [middle, end] = [2 * chord + 1, 2 * chord + 2].map(on_screen_px);
            let (along, to_middle) = (end - start, middle - start);
            let length = along.length();
            // Usually the distance to the line through the chord. But where the arc folds back on the screen, the foot of its middle point is not near the
            // chord's middle: then the distance to the chord's nearer end counts.
            let error = if length > 0.0 && (0.25..=0.75).contains(&(to_middle.dot(along) / (length * length))) {
                along.perp_dot(to_middle).abs() / length
            } else {
                to_middle.length().min((middle - end).length())
            };
            largest = largest.max(error);
            start = end;
        }
        largest
    }

    /// Adds the arc between two values of s, or its halves if it is too long or too curved; adds nothing outside the frame. `halvings`: how often the orbit has
    /// been halved to get this arc.
    fn add_arc(&mut self, from: f64, to: f64, halvings: u32) {
        let (middle_s, half) = (0.5 * (from + to), 0.5 * (to - from));
        let [first_derivative, second_derivative] = self.conic.derivatives(middle_s);
        let middle = self.camera.in_axes(self.body_from_camera_km + self.conic.offset_from_body_km(middle_s));
        // On an ellipse the second derivative is -alpha times the vector from the centre, so its length is at most alpha times the semi-major axis, that is GM.
        // On an open path its length is largest at one of the arc's ends.
        let max_second_derivative = if self.conic.alpha > 0.0 {
            self.conic.gm_km3_s2
        } else {
            [from, to].map(|s| self.conic.derivatives(s)[1].length()).into_iter().fold(0.0, f64::max)
        };
        // No point of the arc is farther from its middle than this.
        let radius_km = first_derivative.length() * half + 0.5 * max_second_derivative * half * half;
        if !self.camera.sphere_may_be_in_frame(middle, radius_km, MARGIN_PX) {
            return;
        }
        // An arc along the line of sight may be long, because it appears short in the image.
        let half_length_across_km =
            self.camera.in_axes(first_derivative).reject_from(middle).length() * half + 0.5 * max_second_derivative * half * half;
        let nearest_km = (middle.length() - radius_km).max(NEAR_DEPTH_KM);
        let is_small = self.conic.alpha.abs() * (2.0 * half).powi(2) < MAX_STUMPFF_ARGUMENT
            && half_length_across_km < MAX_HALF_LENGTH_ACROSS * self.camera.tan_half_fov.length() * nearest_km
            // The camera is outside the arc's bounding sphere, with a margin of a tenth: the farthest point is at most 19 times as far as the nearest.
            && radius_km < 0.9 * middle.length();
        let is_in_front_of_camera = middle.z - radius_km > NEAR_DEPTH_KM;
        if is_small && is_in_front_of_camera && self.chord_error_px(from, to) < MAX_CHORD_ERROR_PX {
            // u = (s - origin) / s_per_u. An arc that ends at the body has its origin there, so that it is exact at the body.
            let (origin, range) = if from == 0.0 {
                (from, [0.0, 1.0])
            } else if to == 0.0 {
                (to, [-1.0, 0.0])
            } else {
                (middle_s, [-0.5, 0.5])
            };
            let s_per_u = to - from;
            let [first_derivative, second_derivative] =
                if origin == middle_s { [first_derivative, second_derivative] } else { self.conic.derivatives(origin) };
            let point = self.camera.in_axes(self.body_from_camera_km + self.conic.offset_from_body_km(origin));
            let divided_by_tangents = |v: DVec3| narrow((v.truncate() / self.camera.tan_half_fov).extend(v.z));
            let is_ahead = to > 0.0;
            self.arcs.push(OrbitArc {
                point: divided_by_tangents(point),
                first_derivative: divided_by_tangents(self.camera.in_axes(first_derivative) * s_per_u),
                second_derivative: divided_by_tangents(self.camera.in_axes(second_derivative) * (s_per_u * s_per_u)),
                alpha: narrow_scalar(self.conic.alpha * s_per_u * s_per_u),
                range,
                opacity: [self.opacity_at(from, is_ahead), self.opacity_at(to, is_ahead)],
                colour: narrow(self.colour),
            });
        } else if halvings < MAX_HALVINGS {
            self.add_arc(from, middle_s, halvings + 1);
            self.add_arc(middle_s, to, halvings + 1);
        }
    }
}

/// The arcs of one orbit. `body_from_camera_km`: the body's apparent position from the camera, ICRF. `opacity`: at the body, if the orbit is not
/// faded for its size on the screen ([`FADE_PX`]). `colour`: linear RGB.
pub(crate) fn arcs(camera: &Camera, conic: &Conic, body_from_camera_km: DVec3, opacity: f64, colour: DVec3) -> Vec<OrbitArc> {
    let opacity = opacity * smooth_rise(FADE_PX, size_on_screen_px(camera, conic, body_from_camera_km));
    if opacity <= 0.0 || !body_from_camera_km.is_finite() {
        return Vec::new();
    }
    let drawn_range = conic.drawn_range();
    let mut subdivision = ArcSubdivision { camera, conic, body_from_camera_km, colour, opacity, drawn_range, arcs: Vec::new() };
    // Split at the body, so that the line is exact there. Quarters of the orbit: two halvings.
    for [from, to] in [
        [drawn_range[0], 0.5 * drawn_range[0]],
        [0.5 * drawn_range[0], 0.0],
        [0.0, 0.5 * drawn_range[1]],
        [0.5 * drawn_range[1], drawn_range[1]],
    ] {
        subdivision.add_arc(from, to, 2);
    }
    subdivision.arcs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::conic::ConicState;
    use crate::ephemeris::two_body;
    use glam::DVec2;

    /// The Sun's GM, km^3/s^2.
    const GM: f64 = 1.327e11;

    /// Ellipses, near-parabolas and hyperbolas with the Sun's GM: a state on each, km and km/s.
    fn states() -> Vec<(&'static str, State)> {
        // q: periapsis distance, km; e: eccentricity; w: tangent of half the true anomaly.
        let at = |q: f64, e: f64, w: f64| {
            // The true anomaly from the tangent of its half, then the equation of the conic.
            let nu = 2.0 * w.atan();
            let (p, r) = (q * (1.0 + e), q * (1.0 + e) / (1.0 + e * nu.cos()));
            let speed = (GM / p).sqrt();
            let turn = glam::DMat3::from_rotation_z(0.7) * glam::DMat3::from_rotation_x(0.4);
            let pos_km = turn * DVec3::new(r * nu.cos(), r * nu.sin(), 0.0);
            State { pos_km, vel_km_s: turn * DVec3::new(-speed * nu.sin(), speed * (e + nu.cos()), 0.0) }
        };
        vec![
            // Semi-major axis in km; eccentricity; inclination, node, argument of periapsis and mean anomaly in radians; mean motion in radians per second.
            ("planet", two_body::state_in_frame(1.5e9, 0.2, 0.4, 1.0, 2.0, 0.7, 6.8e-9)),
            ("comet", at(8.8e7, 0.967, 0.8)),
            ("nearly parabolic ellipse", at(5e7, 0.999_99, -1.5)),
            ("parabola", at(5e7, 1.0, 1.2)),
            ("nearly parabolic hyperbola", at(5e7, 1.000_01, 0.4)),
            ("hyperbola", at(3e8, 3.4, -0.3)),
        ]
    }

    #[test]
    fn the_conic_is_the_path_of_the_body() {
        for (name, state) in states() {
            let conic = Conic::of(&state, GM).expect("a conic");
            let from = ConicState { position: state.pos_km, velocity: state.vel_km_s };
            for days in [-300.0, -1.0, 1e-9, 40.0, 900.0] {
                let expected = from.propagated(GM, days * 86_400.0).position;
                // Finds the nearest point of the line: 401 samples over the drawn range, then over ever shorter ranges around the best sample.
                let [back_end, ahead_end] = conic.drawn_range();
                let (mut middle, mut half_width) = (0.0, 0.0);
                for round in 0..40 {
                    let around = |k: i32| {
                        if round == 0 {
                            back_end + (ahead_end - back_end) * f64::from(k + 200) / 400.0
                        } else {
                            middle + half_width * f64::from(k) / 200.0
                        }
                    };
                    let error_km = |s: f64| (state.pos_km + conic.offset_from_body_km(s)).distance(expected);
                    let best = (-200..=200).map(around).min_by(|a, b| error_km(*a).total_cmp(&error_km(*b))).expect("some");
                    (middle, half_width) = (best, if round == 0 { (ahead_end - back_end) / 200.0 } else { half_width * 0.2 });
                }
                let error_km = (state.pos_km + conic.offset_from_body_km(middle)).distance(expected);
                assert!(error_km < 1e-7 * expected.length(), "{name} {days}: {error_km} km");
            }
        }
        let state = states()[0].1;
        assert_eq!(Conic::of(&state, 0.0), None, "no gravity");
        assert_eq!(Conic::of(&State { vel_km_s: state.pos_km * 1e-8, ..state }, GM), None, "a radial path");
    }

    /// Distance in pixels from a point on the screen to the nearest chord of the f32 arcs.
    fn distance_to_line_px(camera: &Camera, all: &[OrbitArc], clip: DVec2) -> f64 {
        let pixel = clip * camera.half_size_px();
        let distance_px = |arc: &OrbitArc, k: u32| {
            let end = |k: u32| arc.clip(f64::from(k) / f64::from(CHORDS_PER_ARC)).truncate() * camera.half_size_px();
            let (a, b) = (end(k), end(k + 1));
            let t = ((pixel - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            (pixel - a.lerp(b, t)).length()
        };
        all.iter().flat_map(|arc| (0..CHORDS_PER_ARC).map(move |k| distance_px(arc, k))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_line_lies_on_its_conic_wherever_the_camera_is() {
        for (name, state) in states() {
            let conic = Conic::of(&state, GM).expect("a conic");
            let [back_end, ahead_end] = conic.drawn_range();
            let body_km = state.pos_km;
            // A camera beside the line. `fraction`: of the drawn range ahead of the body, or behind it if negative; `along`: the camera looks ahead along the
            // line (1), back (-1), or down on it (0).
            let beside = |fraction: f64, height_km: f64, along: f64, fov_deg: f64| {
                let s = fraction * if fraction < 0.0 { -back_end } else { ahead_end };
                let offset = conic.offset_from_body_km(s);
                let ahead = conic.offset_from_body_km(s + 1e-4 * (ahead_end - back_end)) - offset;
                let forward = if along == 0.0 { DVec3::NEG_Z } else { ahead * along };
                Camera::looking(body_km + offset + DVec3::Z * height_km, forward, DVec3::Z, fov_deg, 800, 600)
            };
            // Distances from a metre to a hundred au.
            let cameras = [
                Camera::looking(DVec3::new(0.0, 0.0, 1.5e10), DVec3::NEG_Z, DVec3::Y, 30.0, 800, 600),
                beside(0.3, 1e-3, 1.0, 60.0),
                beside(0.03, 1e3, -1.0, 60.0),
                beside(1e-5, 1e6, 0.0, 60.0),
                beside(0.9, 1e9, 0.0, 60.0),
                beside(0.0, 10.0, 0.0, 60.0),
                beside(0.2, 1e7, 0.0, 0.02),
                beside(-0.4, 1e5, 0.0, 1.0),
            ];
            for (n, camera) in cameras.iter().enumerate() {
                let all = arcs(camera, &conic, body_km - camera.position_km, 1.0, DVec3::ONE);
                assert!(!all.is_empty() && all.len() < 1000, "{name}, camera {n}: {} arcs", all.len());
                assert!(
                    all.iter().all(|a| a.point.is_finite() && a.first_derivative.is_finite() && a.second_derivative.is_finite()),
                    "{name}, camera {n}"
                );
                let mut seen = 0;
                for step in -4000..4000 {
                    // The samples are dense close to the body, where the camera may be close to the line.
                    let t = f64::from(step) / 4000.0;
                    let s = (t * t * t) * if t < 0.0 { -back_end } else { ahead_end };
                    let p = body_km + conic.offset_from_body_km(s) - camera.position_km;
                    // Behind the camera, or less than a metre in front of it.
                    if p.dot(camera.forward) < 1e-3 {
                        continue;
                    }
                    let Some(clip) = camera.clip(p).filter(|c| c.abs().max_element() < 1.0) else { continue };
                    seen += 1;
                    let error_px = distance_to_line_px(camera, &all, clip);
                    // The bound of a chord's middle, doubled for its other points and for f32.
                    assert!(error_px < 2.0 * MAX_CHORD_ERROR_PX, "{name}, camera {n}: the conic leaves the line by {error_px} px at {t}");
                }
                // Only the first camera is certain to see samples: it looks down from afar.
                assert!(seen > 3 || n > 0, "{name}, camera {n} sees {seen} points");
            }
        }
    }

    /// A vertex is within 0.05 px of the body, from 6000 km away to beyond the planets, on and off the optical axis; a shifted line is detected.
    #[test]
    fn the_line_passes_through_its_body_at_every_zoom() {
        for (name, state) in states() {
            let conic = Conic::of(&state, GM).expect("a conic");
            let mut worst = 0.0_f64;
            // `side`: the body's angle from the optical axis, as a part of half the field of view.
            for (k, side) in (0..60).flat_map(|k| [0.0, 0.6, -0.9].map(|side| (k, side))) {
                let distance_km = 6000.0 * 1.3_f64.powi(k);
                let from = DVec3::new(0.3, -0.5, 0.8).normalize() * distance_km;
                let fov_deg = if k % 3 == 0 { 0.05 } else { 50.0 };
                let aim = -from + DVec3::new(0.9, 0.2, -0.3).normalize() * (side * distance_km * f64::tan(f64::to_radians(fov_deg / 2.0)));
                let camera = Camera::looking(state.pos_km + from, aim, DVec3::Z, fov_deg, 1024, 1024);
                let all = arcs(&camera, &conic, -from, 1.0, DVec3::ONE);
                let Some(clip) = camera.clip(-from).filter(|c| c.abs().max_element() < 1.0) else { continue };
                if all.is_empty() {
                    continue;
                }
                let vertices = all.iter().flat_map(|a| [a.clip(0.0), a.clip(1.0)]);
                let error_px = vertices.map(|v| ((v.truncate() - clip) * camera.half_size_px()).length()).fold(f64::INFINITY, f64::min);
                worst = worst.max(error_px);
            }
            assert!(worst < 0.05, "{name}: {worst} px");
        }
        // At a distance of 1e5 km, a line shifted by 100 km is 1 px from its body.
        let conic = Conic::of(&states()[0].1, GM).expect("a conic");
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 50.0, 1024, 1024);
        let body_km = DVec3::new(1e5, 0.0, 0.0);
        let moved = arcs(&camera, &conic, body_km + conic.first_derivative.normalize().any_orthonormal_vector() * 100.0, 1.0, DVec3::ONE);
        assert!(distance_to_line_px(&camera, &moved, DVec2::ZERO) > 0.05);
    }

    #[test]
    fn the_line_fades_backwards_along_the_path() {
        let state = states()[0].1;
        let conic = Conic::of(&state, GM).expect("a conic");
        let camera = Camera::looking(DVec3::new(0.0, 0.0, 1.5e10), DVec3::NEG_Z, DVec3::Y, 30.0, 800, 600);
        let all = arcs(&camera, &conic, state.pos_km - camera.position_km, 0.8, DVec3::ONE);
        let body = camera.clip(state.pos_km - camera.position_km).expect("in front");
        let is_body = |clip: DVec3| (clip.truncate() - body).length() < 1e-6;
        let opacity_of_arcs_to_body: Vec<f32> = all.iter().filter(|a| is_body(a.clip(1.0))).map(|a| a.opacity[1]).collect();
        let opacity_of_arcs_from_body: Vec<f32> = all.iter().filter(|a| is_body(a.clip(0.0))).map(|a| a.opacity[0]).collect();
        assert_eq!((opacity_of_arcs_to_body, opacity_of_arcs_from_body), (vec![0.8], vec![0.8 * MIN_OPACITY as f32]));
        let far = Camera { position_km: camera.position_km * 1e4, ..camera };
        let arcs_from_afar = arcs(&far, &conic, state.pos_km - far.position_km, 0.8, DVec3::ONE);
        assert!(arcs_from_afar.is_empty(), "an orbit smaller than a pixel has no line");
    }
}
