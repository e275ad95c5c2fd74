//! Orbit lines: the ellipse on which a body would go on if only its parent pulled, as short straight pieces on the screen.
//!
//! In: a state relative to the parent and where the body is seen. Out: [`LineSegment`]s in clip space, clipped to the frame, whose ends meet exactly.
//! The ellipse is counted from the body's own place, so that the line passes through the disc at any distance, and pieces are halved until a chord
//! leaves its arc by less than [`MAX_BEND_PX`], or lies outside the frame: from a metre to a hundred au the work is some hundred pieces. All in f64;
//! only clip coordinates are narrowed. Open orbits have no line.

use crate::ephemeris::{Ephemeris, State};
pub use crate::scene::annotation::strokes::LineSegment;
use crate::scene::annotation::strokes::{Curve, Run, segments};
use crate::scene::camera::{Camera, NEAR_DEPTH_KM};
use crate::scene::decision::Decision;
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Half the width of a line, pixels.
pub const HALF_WIDTH_PX: f32 = 0.6;
/// Radiance of a white line, of the radiance that is shown as white.
pub const LEVEL: f32 = 0.3;
/// An ellipse whose half length is less than this many pixels is not drawn, and is drawn in full from the second on.
const FADE_PX: (f64, f64) = (3.0, 12.0);
/// Strength a whole turn away from the body, of the strength beside it: the line fades the way the body has come.
const FAINTEST: f64 = 0.25;

/// An ellipse about the parent, counted from the body's place on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Half axes as vectors, kilometres, ICRF.
    pub major_km: DVec3,
    pub minor_km: DVec3,
    /// The body's eccentric anomaly, radians.
    pub anomaly: f64,
}

impl Ellipse {
    /// The orbit of a state relative to a parent; `gm`: of both together, km^3/s^2. `None`: it is open, or falls straight.
    pub fn of(state: &State, gm_km3_s2: f64) -> Option<Self> {
        let (r, v) = (state.pos_km, state.vel_km_s);
        let distance = r.length();
        let axis_km = 1.0 / (2.0 / distance - v.length_squared() / gm_km3_s2);
        let normal = r.cross(v);
        if !(axis_km > 0.0 && axis_km.is_finite() && normal.length() > 0.0) {
            return None;
        }
        let eccentricity = v.cross(normal) / gm_km3_s2 - r / distance;
        let e = eccentricity.length();
        if e >= 1.0 {
            return None;
        }
        // A circle has no periapsis: any direction will do.
        let along = if e > 1e-12 { eccentricity / e } else { r / distance };
        let across = normal.normalize().cross(along);
        let minor = (1.0 - e * e).sqrt();
        let anomaly = (r.dot(across) / minor).atan2(r.dot(along) + axis_km * e);
        Some(Self { major_km: along * axis_km, minor_km: across * (axis_km * minor), anomaly })
    }

    /// From the body to the point `ahead` radians of eccentric anomaly before it; exact where that is little.
    pub fn from_body_km(&self, ahead: f64) -> DVec3 {
        // cos(E + d) - cos E and sin(E + d) - sin E without the difference.
        let (half, (sin, cos)) = ((0.5 * ahead).sin(), (self.anomaly + 0.5 * ahead).sin_cos());
        2.0 * half * (self.minor_km * cos - self.major_km * sin)
    }
}

/// A line of sight's strength by the size of the whole ellipse on the screen.
fn by_size(half_length_px: f64) -> f64 {
    smoothstep((half_length_px - FADE_PX.0) / (FADE_PX.1 - FADE_PX.0))
}

/// Half the ellipse's length on the screen as seen from outside it, pixels; what is around the camera is as large as the frame.
pub fn half_length_px(camera: &Camera, ellipse: &Ellipse, body_from_camera_km: DVec3) -> f64 {
    let axis_km = ellipse.major_km.length();
    let centre = body_from_camera_km + 0.5 * ellipse.from_body_km(PI);
    axis_km / centre.length().max(axis_km) / camera.pixel_tangent()
}

/// The pieces of one orbit. `body_km`: the body's apparent place from the camera, ICRF; `strength`: opacity beside the body.
pub fn pieces(camera: &Camera, ellipse: &Ellipse, body_km: DVec3, strength: f64, colour: DVec3) -> Vec<LineSegment> {
    let strength = strength * by_size(half_length_px(camera, ellipse, body_km));
    if strength <= 0.0 || !ellipse.major_km.is_finite() || !body_km.is_finite() {
        return Vec::new();
    }
    let point = |ahead: f64| body_km + ellipse.from_body_km(ahead);
    // No arc of an ellipse is longer, or bends more, than that of its outer circle.
    let curve = Curve { camera, point: &point, size: ellipse.major_km.length(), finer: 1.0 };
    // Counted from the body, so that the line is exact there.
    let runs = curve.runs(&[-PI, -0.5 * PI, 0.0, 0.5 * PI, PI], 2);
    let of_run = |run: &Run| {
        // Where the body goes counts on from where it came: at its place the line jumps from the strongest to the faintest.
        let ahead = run[0].1 + run[run.len() - 1].1 > 0.0;
        let fading = |at: f64| {
            let turn = if ahead { at / TAU } else { 1.0 + at / TAU };
            strength * (FAINTEST + (1.0 - FAINTEST) * turn)
        };
        segments(camera, run, |p| (NEAR_DEPTH_KM / p.z).min(1.0), fading, colour)
    };
    runs.iter().flat_map(of_run).collect()
}

/// Opacity of a line beside its body.
const STRENGTH: f64 = 0.9;

/// The line of one body and why it is there or not. `None`: it has no parent.
pub(crate) fn line(camera: &Camera, ephemeris: &Ephemeris, p: &PlacedBody<'_>) -> Option<(Vec<LineSegment>, Decision)> {
    let parent = p.catalog.body(p.body.parent?)?;
    let feature = "orbit";
    let without = |reason: String| Some((Vec::new(), Decision { feature, on: false, reason, tier: None }));
    let state = match ephemeris.state(p.body.id, parent.id, p.seen_at, None) {
        Ok(answer) => answer.state,
        Err(e) => return without(e.to_string()),
    };
    let gm = parent.gm_km3_s2.unwrap_or(0.0) + p.body.gm_km3_s2.unwrap_or(0.0);
    let Some(ellipse) = Ellipse::of(&state, gm) else { return without(format!("its path about {} is no ellipse", parent.name)) };
    // Its own colour, half way to white.
    let colour = p.body.colour.as_dvec3() / f64::from(p.body.colour.max_element()) * 0.5 + 0.5;
    let all = pieces(camera, &ellipse, p.placement.centre_km, STRENGTH, colour);
    let size_px = half_length_px(camera, &ellipse, p.placement.centre_km);
    let reason = match all.len() {
        0 if size_px < FADE_PX.0 => format!("half its length is {size_px:.1} px, of {} that a line is drawn from", FADE_PX.0),
        0 => "outside the frame".into(),
        n => format!("about {}: half its length is {size_px:.0} px, {n} pieces", parent.name),
    };
    let on = !all.is_empty();
    Some((all, Decision { feature, on, reason, tier: None }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::two_body;
    use crate::scene::annotation::strokes::MAX_BEND_PX;
    use glam::{DVec2, Vec3};

    /// A camera 100 au over the plane of a planet's orbit, and that orbit.
    fn system() -> (Camera, Ellipse, DVec3) {
        let state = two_body::state_in_frame(1.5e9, 0.2, 0.4, 1.0, 2.0, 0.7, 6.8e-9);
        let ellipse = Ellipse::of(&state, 1.327e11).expect("closed");
        (Camera::looking(DVec3::new(0.0, 0.0, 1.5e10), DVec3::NEG_Z, DVec3::Y, 30.0, 800, 600), ellipse, state.pos_km)
    }

    #[test]
    fn the_ellipse_is_keplers() {
        let (a, e, n) = (4.2e5, 0.3, 4.1e-5_f64);
        let gm = n * n * a * a * a;
        let at = |mean: f64| two_body::state_in_frame(a, e, 0.3, 1.1, 2.2, mean, n);
        for (from, to) in [(0.4, 2.9), (3.3, 3.3 + 1e-9), (6.0, 0.1), (0.0, 1.0)] {
            let ellipse = Ellipse::of(&at(from), gm).expect("closed");
            let anomaly = |mean: f64| two_body::eccentric_anomaly(mean, e);
            let moved = ellipse.from_body_km(anomaly(to) - anomaly(from));
            let expected = at(to).pos_km - at(from).pos_km;
            assert!((moved - expected).length() < 1e-12 * a, "from {from} to {to}: {moved} for {expected}");
        }
        let fast = State { vel_km_s: at(0.4).vel_km_s * 3.0, ..at(0.4) };
        assert_eq!(Ellipse::of(&fast, gm), None, "an open path");
        assert_eq!(Ellipse::of(&at(0.4), 0.0), None, "nothing pulls");
    }

    /// Distance in pixels from a place on the screen to the nearest piece.
    fn to_nearest(camera: &Camera, all: &[LineSegment], clip: DVec2) -> f64 {
        let px = |v: Vec3| v.truncate().as_dvec2() * camera.half_size();
        let at = clip * camera.half_size();
        let of = |p: &LineSegment| {
            let (a, b) = (px(p.ends[0]), px(p.ends[1]));
            let t = ((at - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            (at - a.lerp(b, t)).length()
        };
        all.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_line_lies_on_the_ellipse_wherever_the_camera_is() {
        let (far, ellipse, planet) = system();
        // Beside the line, looking along it (1), back (-1), or down on it (0).
        let beside = |ahead: f64, off_km: f64, along: f64| {
            let here = ellipse.from_body_km(ahead);
            let forward = (ellipse.from_body_km(ahead + 1e-3) - here) * along;
            let forward = if along == 0.0 { DVec3::NEG_Z } else { forward };
            Camera::looking(planet + here + DVec3::Z * off_km, forward, DVec3::Z, 60.0, 800, 600)
        };
        // From a metre to a hundred au.
        let cameras = [
            far.clone(),
            beside(1.0, 1e-3, 1.0),
            beside(0.1, 1e3, -1.0),
            beside(1e-4, 1e6, 0.0),
            beside(3.0, 1e9, 0.0),
            beside(0.0, 10.0, 0.0),
        ];
        for (k, camera) in cameras.iter().enumerate() {
            let all = pieces(camera, &ellipse, planet - camera.position_km, 1.0, DVec3::ONE);
            assert!(!all.is_empty() && all.len() < 2000, "camera {k}: {} pieces", all.len());
            for p in &all {
                let finite = p.ends.iter().all(|e| e.is_finite() && e.truncate().abs().max_element() < 1.1 && (0.0..=1.0).contains(&e.z));
                assert!(finite && p.across.iter().all(|a| (a.length() - 1.0).abs() < 1e-5), "camera {k}: {p:?}");
            }
            let joined = all.windows(2).filter(|w| w[0].ends[1] == w[1].ends[0]).count();
            assert!(joined + 10 > all.len(), "camera {k}: {joined} of {} pieces meet the next", all.len());
            let mut seen = 0;
            for step in -20_000..20_000 {
                // Close together beside the planet, where the camera may be near.
                let t = f64::from(step) / 20_000.0;
                let p = planet + ellipse.from_body_km(PI * t * t * t) - camera.position_km;
                if p.dot(camera.forward) < 1e-3 {
                    continue;
                }
                let Some(clip) = camera.clip(p).filter(|c| c.abs().max_element() < 1.0) else { continue };
                seen += 1;
                let off = to_nearest(camera, &all, clip);
                assert!(off < 2.0 * MAX_BEND_PX, "camera {k}: the ellipse leaves the line by {off} px");
            }
            assert!(seen > 10, "camera {k} sees the line");
        }
    }

    #[test]
    fn the_line_fades_the_way_the_body_came() {
        let (camera, ellipse, planet) = system();
        let all = pieces(&camera, &ellipse, planet - camera.position_km, 0.8, DVec3::ONE);
        let body = camera.clip(planet - camera.position_km).expect("in front").as_vec2();
        let at_body =
            |k: usize| all.iter().filter(|p| (p.ends[k].truncate() - body).length() < 1e-6).map(|p| p.strength[k]).collect::<Vec<_>>();
        assert_eq!((at_body(1), at_body(0)), (vec![0.8], vec![0.8 * FAINTEST as f32]), "it ends and begins at the body");
        let tiny = Camera { position_km: camera.position_km * 1e4, ..camera };
        assert!(pieces(&tiny, &ellipse, planet - tiny.position_km, 0.8, DVec3::ONE).is_empty(), "a dot has no line");
    }
}
