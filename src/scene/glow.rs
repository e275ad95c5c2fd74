//! The Sun's glow: the veil of light that the eye's or a camera's optics spread around its disc while it is in the frame.
//!
//! In: where the Sun stands, what hides it, what is white. Out: [`Glow`], the amounts of shaders/entry/glow.wgsl, and the reason. The law is that of
//! Stiles and Holladay, L = 10 E / theta^2 (cd/m2 and lux, degrees; CIE 146:2002, where it holds from 1 to 30 degrees): about a tenth of
//! the light goes astray. It stands for the glare of the whole optics; a clean lens spreads less, by a factor that depends on the lens. Nearer than
//! the Sun's limb (or a pixel, where that is wider) the veil is flat. It is drawn as far as it can change a display level: beyond that it adds less than
//! [`LEAST_SHOWN`] of white. Its light is not taken from the disc, which shines a hundred times as
//! bright. Left out: streaks and ghosts, which belong to one lens, and veils of bodies other than the Sun.

use super::Placed;
use super::camera::{Camera, ClipRect, Placement, narrow, narrow_scalar};
use super::purpose::Bound;
use crate::catalog::NaifId;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::f64::consts::{FRAC_PI_2, PI};

/// L theta^2 / E with theta in radians, where a white plane facing E has the radiance E (no factor pi): pi * 10 * (pi / 180)^2.
pub const VEIL: f64 = PI * 10.0 * (PI / 180.0) * (PI / 180.0);

/// The power with which the veil grows while the Sun comes into the frame.
const ENTERS: i32 = 6;

/// Light, as a part of white, of half a level of 255 on black, where the sRGB curve is steepest (12.92): what is less rounds away.
pub const LEAST_SHOWN: f64 = 0.5 / 255.0 / 12.92;

/// Uniforms of the glow, and where it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glow {
    /// Left, top, right, bottom: what holds all light over [`LEAST_SHOWN`] of white.
    pub rect_in_clip: Vec4,
    pub sun_direction: Vec3,
    pub least_sq: f32,
    pub strength: Vec3,
    pub tan_half_fov: Vec2,
}

/// What is left of the Sun's disc behind a body: an even disc cut by a circle, by a straight edge where the body looks larger. Within 0.03 of the
/// exact overlap while the body is larger than twice the Sun or smaller than half of it; between these within 0.15.
fn left_by(separation: f64, body: f64, sun: f64) -> f64 {
    if body < sun {
        let covered = ((body + sun - separation) / (2.0 * body)).clamp(0.0, 1.0);
        return 1.0 - covered * (body / sun).powi(2);
    }
    let edge = ((separation - body) / sun).clamp(-1.0, 1.0);
    1.0 - (edge.acos() - edge * (1.0 - edge * edge).sqrt()) / PI
}

/// Angle from the middle of a body to its limb on the side of a unit vector, and the cosine by which the limb slants there. Outside the body.
fn limb_towards(body: &Placement, towards: DVec3) -> (f64, f64) {
    let distance_km = body.centre_km.length();
    let middle = body.centre_km / distance_km;
    let aside = (towards - middle * towards.dot(middle)).try_normalize().unwrap_or_else(|| middle.any_orthonormal_vector());
    // In the unit-sphere frame the ray a + u b, u the angle's tangent, grazes where its squared distance from the centre is 1.
    let (a, b) = (body.direction_in_unit_sphere(middle), body.direction_in_unit_sphere(aside));
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let radii = distance_km / body.radii_km.x;
    let q = radii * radii * a.cross(b).length_squared() - bb;
    let angle = (ab + (ab * ab + q * aa).max(0.0).sqrt()).atan2(q);
    // Across the limb the squared distance grows fastest.
    let (sin, cos) = angle.sin_cos();
    let (c, d) = (body.camera_in_unit_sphere(), body.direction_in_unit_sphere(middle * cos + aside * sin));
    let outwards = body.body_from_icrf.transpose() * ((d * (c.length_squared() - 1.0) - c * c.dot(d)) * (body.radii_km.x / body.radii_km));
    (angle, outwards.normalize_or_zero().dot(aside * cos - middle * sin).clamp(0.0, 1.0))
}

/// What a body leaves of a disc of an angular radius (radians) around a unit vector that lies behind it.
pub(super) fn left_behind(body: &Placement, towards: DVec3, radius: f64) -> f64 {
    let separation = crate::ephemeris::angle_rad(body.centre_km, towards);
    let (limb, slant) = limb_towards(body, towards);
    left_by(limb + (separation - limb) * slant, limb, radius)
}

/// The part of the Sun's disc that no body hides from the camera.
fn part_seen(placed: &[Placed<'_>], sun: &Placed<'_>) -> f64 {
    let radius = (sun.body.radii_km.x / sun.distance_km).min(1.0).asin();
    let towards = sun.placement.centre_km / sun.distance_km;
    let nearer = placed.iter().filter(|p| p.body.id != sun.body.id && p.distance_km > 0.0 && p.distance_km < sun.distance_km);
    nearer.map(|p| left_behind(&p.placement, towards, radius)).product()
}

/// How far a disc has come into the frame, from 0 where it touches to 1 where it is in by its radius or by half of the frame; by a power of it, so that the
/// glare of the Sun, nineteen stops over the dark sky, does not come at once. The outline's rectangle will not do: it is wide for a body at a right angle to
/// the view.
fn part_in_frame(camera: &Camera, towards: DVec3, radius: f64) -> f64 {
    let ahead = towards.dot(camera.forward);
    if ahead <= 0.0 {
        return 0.0;
    }
    let within = |across: f64, half: f64| {
        let reach = radius * (1.0 + half * half);
        ((half + reach - (across / ahead).abs()) / reach.min(half)).clamp(0.0, 1.0).powi(ENTERS)
    };
    within(towards.dot(camera.right), camera.tan_half_fov.x) * within(towards.dot(camera.up), camera.tan_half_fov.y)
}

/// The veil around the Sun: its radiance at an angle theta is `strength` / theta squared, flat within `least_sq`.
pub(super) struct Veil {
    /// Unit vector, ICRF.
    pub towards: DVec3,
    pub strength: f64,
    pub least_sq: f64,
    /// Part of the Sun's disc that no body hides, less while it comes into the frame.
    pub seen: f64,
}

impl Veil {
    /// Of a Sun that is in the frame, if partly: as much of its light goes astray as enters there.
    pub fn of(camera: &Camera, placed: &[Placed<'_>]) -> Option<Self> {
        let sun = placed.iter().find(|p| p.body.id == NaifId::SUN)?;
        let towards = sun.placement.centre_km / sun.distance_km;
        let radius = (sun.body.radii_km.x / sun.distance_km).min(1.0);
        let entering = part_in_frame(camera, towards, radius);
        if entering <= 0.0 {
            return None;
        }
        let seen = entering * part_seen(placed, sun);
        let irradiance = (crate::units::KM_PER_AU / sun.distance_km).powi(2);
        let least = radius.max(camera.pixel_tangent());
        Some(Self { towards, strength: VEIL * irradiance * seen, least_sq: least * least, seen })
    }

    /// Radiance in a direction (a unit vector).
    pub fn radiance(&self, direction: DVec3) -> f64 {
        self.strength / (direction - self.towards).length_squared().max(self.least_sq)
    }
}

/// The rectangle around all directions whose chord to `towards` (a unit vector in camera axes: right, up, forward) is less than `chord`.
fn reach(camera: &Camera, towards: DVec3, chord: f64) -> ClipRect {
    let angle = 2.0 * (0.5 * chord).min(1.0).asin();
    // Tangents of the least and the greatest angle from the view axis, seen along the picture's other axis.
    let span = |across: f64| {
        let flat = across.hypot(towards.z);
        let half = if angle < FRAC_PI_2 && angle.sin() < flat { (angle.sin() / flat).asin() } else { PI };
        let middle = across.atan2(towards.z);
        let tangent = |a: f64| if a.abs() < FRAC_PI_2 { a.tan() } else { f64::INFINITY.copysign(a) };
        (tangent(middle - half), tangent(middle + half))
    };
    let clip = |(from, to): (f64, f64), tan_half: f64| ((from / tan_half).clamp(-1.0, 1.0), (to / tan_half).clamp(-1.0, 1.0));
    let (left, right) = clip(span(towards.x), camera.tan_half_fov.x);
    let (bottom, top) = clip(span(towards.y), camera.tan_half_fov.y);
    ClipRect { left, top, right, bottom }
}

/// The glow of a frame with its reason, where the catalog has a Sun in front of the camera. `tint`: what the air leaves of its light.
pub(super) fn glow(camera: &Camera, placed: &[Placed<'_>], bound: Bound, tint: impl Fn(DVec3) -> DVec3) -> Option<(Glow, bool, String)> {
    let Veil { towards, strength, least_sq, seen } = Veil::of(camera, placed)?;
    let strength = tint(towards) * strength;
    let beside = strength.max_element() / least_sq;
    let on = bound.counts(beside);
    let reason = if seen > 0.0 { format!("beside its limb the veil is {}", bound.said(beside)) } else { "other bodies hide it".into() };
    let in_camera = DVec3::new(towards.dot(camera.right), towards.dot(camera.up), towards.dot(camera.forward));
    let rect = reach(camera, in_camera, (strength.max_element() / bound.least_shown(LEAST_SHOWN).max(f64::MIN_POSITIVE)).sqrt());
    let glow = Glow {
        rect_in_clip: Vec4::from_array([rect.left, rect.top, rect.right, rect.bottom].map(narrow_scalar)),
        sun_direction: narrow(in_camera),
        least_sq: narrow_scalar(least_sq),
        strength: narrow(strength),
        tan_half_fov: camera.tan_half_fov.as_vec2(),
    };
    Some((glow, on, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_the_light_goes_astray() {
        // Radiance over pi (no factor pi in the unit) over the solid angle from the limb to 30 degrees.
        let (from, to) = (0.266_f64.to_radians(), 30f64.to_radians());
        let part = VEIL / PI * 2.0 * PI * (to / from).ln();
        assert!((0.05..0.15).contains(&part), "{part}");
    }

    #[test]
    fn a_sun_beside_the_view_is_not_in_the_frame() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 2.0, 100, 100);
        let at = |deg: f64| DVec3::new(deg.to_radians().cos(), deg.to_radians().sin(), 0.0);
        for (deg, shows) in [(0.0, true), (1.2, true), (1.3, false), (89.9999, false), (90.0001, false), (180.0, false)] {
            assert_eq!(part_in_frame(&camera, at(deg), 0.0047) > 0.0, shows, "{deg} degrees");
        }
    }

    #[test]
    fn all_light_over_the_bound_is_in_the_rectangle() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 100, 80);
        for (direction, chord) in [([0.0, 0.0, 1.0], 0.2), ([0.3, -0.2, 0.9], 0.1), ([0.5, 0.5, 0.8], 0.7), ([0.1, 0.0, 1.0], 1.9)] {
            let towards = DVec3::from(direction).normalize();
            let rect = reach(&camera, towards, chord);
            let (mut nearest, mut inside, mut outside) = (f64::INFINITY, 0, 0);
            for k in 0..400 * 400 {
                let clip = glam::DVec2::new(f64::from(k % 400), f64::from(k / 400)) / 200.0 - 1.0;
                let ray = (clip * camera.tan_half_fov).extend(1.0).normalize();
                let within = (ray - towards).length() < chord;
                let drawn = (rect.left..=rect.right).contains(&clip.x) && (rect.bottom..=rect.top).contains(&clip.y);
                assert!(drawn || !within, "{direction:?}, {chord}: {clip} is left out");
                (inside, outside) = (inside + u32::from(within), outside + u32::from(!drawn));
                if within {
                    nearest = nearest.min(clip.x - rect.left).min(rect.right - clip.x).min(clip.y - rect.bottom).min(rect.top - clip.y);
                }
            }
            assert!(inside > 100 && nearest < 0.03, "{direction:?}, {chord}: the rectangle is wider than it must be by {nearest}");
            assert_eq!(outside > 0, chord < 0.7 || direction == [0.5, 0.5, 0.8], "{direction:?}, {chord}");
        }
    }

    /// A long body from near, as Phobos: rays just inside of the limb meet it, rays just outside do not; a sphere's limb is known.
    #[test]
    fn the_limb_is_where_rays_begin_to_miss() {
        let radii_km = DVec3::new(13.0, 11.4, 9.1);
        for (k, distance_km) in [(0, 14.0), (1, 20.0), (2, 99.0), (3, 1e6)] {
            let turned = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3 + f64::from(k), 1.1, 0.7 * f64::from(k));
            let body = Placement { centre_km: DVec3::X * distance_km, body_from_icrf: turned, radii_km };
            let meets = |towards: DVec3| {
                let (c, d) = (body.camera_in_unit_sphere(), body.direction_in_unit_sphere(towards).normalize());
                c.dot(d) < 0.0 && c.cross(d).length() < 1.0
            };
            let mut angles = Vec::new();
            for n in 0..12 {
                let aside = DVec3::new(0.0, f64::from(n).cos(), f64::from(n).sin());
                let (limb, slant) = limb_towards(&body, (DVec3::X + 0.3 * aside).normalize());
                assert!((0.5..=1.0).contains(&slant), "{slant}");
                let at = |angle: f64| DVec3::X * angle.cos() + aside * angle.sin();
                assert!(meets(at(limb * 0.9999)) && !meets(at(limb * 1.0001)), "{distance_km} km, {n}: {limb}");
                angles.push(limb);
            }
            let (least, most) = (angles.iter().copied().fold(f64::MAX, f64::min), angles.iter().copied().fold(0.0, f64::max));
            assert!(most > 1.05 * least, "its outline is long: {least} to {most}");
            let round = Placement { radii_km: DVec3::splat(9.1), ..body };
            let (limb, slant) = limb_towards(&round, DVec3::new(0.8, 0.6, 0.0));
            assert!((limb / (9.1 / distance_km).asin() - 1.0).abs() < 1e-9 && (slant - 1.0).abs() < 1e-6, "{limb} {slant}");
        }
    }

    #[test]
    fn a_body_before_the_sun_hides_what_it_covers() {
        assert_eq!(left_by(3.0, 1.5, 1.0), 1.0);
        assert!(left_by(0.2, 1.5, 1.0) < 1e-12 && left_by(50.0, 51.0, 1.0) < 1e-12);
        assert!((left_by(50.0, 50.0, 1.0) - 0.5).abs() < 1e-12, "a straight horizon through the middle");
        assert!((left_by(0.0, 0.1, 1.0) - 0.99).abs() < 1e-12);
    }
}
