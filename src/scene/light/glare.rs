//! The Sun's glare (effect and shader `glow`): light that the optics of the eye or a camera scatter around the Sun's disc while the Sun is in the frame.
//!
//! In: the Sun's apparent position, the bodies in front of it, the threshold. Out: [`Glare`], the uniforms of shaders/entry/glow.wesl, and the reason; for
//! light meter and corona, `VeilingGlare`: the glare's radiance before the air dims it.
//!
//! The law of Stiles and Holladay is L = 10 E / theta^2, with the luminance L in cd/m2, the illuminance E in lux and the angle theta from the Sun in
//! degrees. CIE 146:2002 gives it for 1 to 30 degrees; closer to the Sun it is extrapolated. About a tenth of the light is scattered. The law represents the
//! glare of eye and lens together; a clean lens scatters less, by a factor that depends on the lens. Within the Sun's limb (or within a pixel, if that is
//! wider) the glare is constant. The glare of a partly hidden Sun is centred on the middle of the visible part, and its constant core shrinks with the visible
//! light. The glare is therefore bright around the last bead, and faint at the opposite limb of the Moon. The glare is drawn as far as it can change a display
//! level: farther out it adds less than [`VISIBLE_LIGHT`] of white. The disc keeps its full radiance, a hundred times the glare's. A Sun outside the frame has
//! no glare, as if the lens had a hood, and light meter and corona do not count any, either. Left out: streaks and ghosts, which are specific to a lens. Not
//! here: the glare of points (`scene::point`) and of small discs (`light::disc_glare`).

use crate::catalog::NaifId;
use crate::message::{Reason, reason};
use crate::scene::camera::{Camera, ClipRect, narrow, narrow_scalar, narrow2};
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::{Purpose, Threshold};
use crate::scene::request::effects::Effect;
use crate::scene::request::{Quality, ViewRequest};
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::units::luminance;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::f64::consts::{FRAC_PI_2, PI};

/// L theta^2 / E of the law above, with theta in radians, in units where a white plane under irradiance E has the radiance E (no factor pi):
/// pi * 10 * (pi / 180)^2.
pub const VEILING_GLARE_COEFFICIENT: f64 = PI * 10.0 * (PI / 180.0) * (PI / 180.0);

/// Exponent with which the glare grows while the Sun enters the frame: chosen, not derived.
const ENTRY_EXPONENT: i32 = 6;

/// Uniforms of the glare, and where it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Left, top, right, bottom of the rectangle that contains all radiance above [`VISIBLE_LIGHT`] of white.
    pub rect_in_clip: Vec4,
    /// Unit vector towards the middle of the visible part of the Sun, camera axes: right, up, forward.
    pub sun_direction: Vec3,
    /// Square of the angle within which the glare is constant, radians squared: smaller for a partly hidden Sun.
    pub core_angle_sq: f32,
    /// Radiance times theta², as in `VeilingGlare`, dimmed by the air between camera and Sun.
    pub strength: Vec3,
    pub tan_half_fov: Vec2,
    /// Radiance that is subtracted everywhere, so that the light falls to zero at the rectangle's edge; 0 for linear light.
    pub cutoff: f32,
    /// Whether a renderer may interpolate the light between shaded points. False for linear light, which is measured, and at reference quality.
    pub is_interpolated: bool,
}

/// The fraction of the Sun's light that no body hides from the camera.
pub(crate) fn visible_fraction(placed: &[PlacedBody<'_>], sun: &PlacedBody<'_>) -> f64 {
    let visible = crate::scene::visibility::hidden::visible_fraction(placed, sun);
    // An uncovered Sun must give exactly 1, which the rounded sum of the luminance weights does not.
    if visible == DVec3::ONE { 1.0 } else { luminance(visible.to_array()) }
}

/// The position of the middle of the Sun's visible part relative to the Sun's centre, in solar radii; and the factor on the square of the core's angle. The
/// factor is the square root of the visible fraction of light. The glare's radiance in the core is then also proportional to this square root, so that the
/// core fades out with the light.
fn middle_and_core_factor(placed: &[PlacedBody<'_>], sun: &PlacedBody<'_>) -> (DVec3, f64) {
    let light = visible_fraction(placed, sun);
    if light <= 0.0 || light >= 1.0 {
        return (DVec3::ZERO, light.clamp(0.0, 1.0));
    }
    (crate::scene::visibility::hidden::visible_middle(placed, sun), light.sqrt())
}

/// How far a disc has entered the frame: 0 while it is outside, 1 once it has entered by its radius or by half the frame. It is 1 in each face of a
/// cube, because the edges of a face are not those of the image. In between, the fraction along each axis is raised to a power, so that the glare, which is
/// far brighter than the dark sky, appears gradually. The outline's bounding rectangle cannot be used instead: it is too wide for a body at a right angle
/// to the line of sight. `towards`: unit vector to the disc's centre, ICRF; `sin_radius`: sine of the disc's angular radius.
fn entered_fraction_of_disc(camera: &Camera, towards: DVec3, sin_radius: f64) -> f64 {
    if camera.is_cube_face {
        return 1.0;
    }
    let cos_off_axis = towards.dot(camera.forward);
    if cos_off_axis <= 0.0 {
        return 0.0;
    }
    let entered_along = |across: f64, tan_half: f64| {
        // Perspective enlarges the disc at the frame's edge by 1 / cosine squared.
        let projected_radius = sin_radius * (1.0 + tan_half * tan_half);
        ((tan_half + projected_radius - (across / cos_off_axis).abs()) / projected_radius.min(tan_half))
            .clamp(0.0, 1.0)
            .powi(ENTRY_EXPONENT)
    };
    entered_along(towards.dot(camera.right), camera.tan_half_fov.x) * entered_along(towards.dot(camera.up), camera.tan_half_fov.y)
}

/// How far the Sun has entered the frame: the factor on its glare. Not for a camera at the Sun's centre.
pub(crate) fn entered_fraction(camera: &Camera, sun: &PlacedBody<'_>) -> f64 {
    entered_fraction_of_disc(camera, sun.placement.centre_km / sun.distance_km, (sun.body.radii_km.x / sun.distance_km).min(1.0))
}

/// The glare around the Sun's visible part. Its radiance at an angle theta from the middle of that part is `strength` / theta². In the core, where theta²
/// is below `core_angle_sq` (radians squared), it is constant. The air between camera and Sun is left out.
pub(crate) struct VeilingGlare {
    /// Unit vector towards the middle of the Sun's visible part, ICRF.
    pub towards: DVec3,
    pub strength: f64,
    pub core_angle_sq: f64,
    /// Square of the angle between `towards` and the farthest point of the Sun's limb, radians squared; at least `core_angle_sq`.
    far_limb_angle_sq: f64,
    /// Fraction of the Sun's light that causes glare: what no body hides, times [`entered_fraction`].
    pub light_fraction: f64,
}

impl VeilingGlare {
    /// The glare of a Sun that is at least partly in the frame.
    pub(crate) fn of(camera: &Camera, placed: &[PlacedBody<'_>]) -> Option<Self> {
        // At the Sun's centre there is no glare.
        let sun = placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > 0.0)?;
        let sin_radius = (sun.body.radii_km.x / sun.distance_km).min(1.0);
        let entered = entered_fraction(camera, sun);
        if entered <= 0.0 {
            return None;
        }
        let light_fraction = entered * visible_fraction(placed, sun);
        let irradiance = (crate::units::KM_PER_AU / sun.distance_km).powi(2);
        let (middle, core_factor) = middle_and_core_factor(placed, sun);
        let pixel_sq = camera.pixel_tangent().powi(2);
        let core_angle_sq = (core_factor * (sin_radius * sin_radius).max(pixel_sq)).max(pixel_sq);
        Some(Self {
            towards: (sun.placement.centre_km / sun.distance_km + middle * sin_radius).normalize(),
            strength: VEILING_GLARE_COEFFICIENT * irradiance * light_fraction,
            core_angle_sq,
            far_limb_angle_sq: (sin_radius * (1.0 + middle.length())).powi(2).max(core_angle_sq),
            light_fraction,
        })
    }

    /// As [`Self::of`]; `None` also if the user has switched the glare off.
    pub(crate) fn unless_switched_off(request: &ViewRequest, camera: &Camera, placed: &[PlacedBody<'_>]) -> Option<Self> {
        let sun = placed.iter().find(|p| p.body.id == NaifId::SUN)?;
        Self::of(camera, placed).filter(|_| request.effects.override_of_body(sun.body, Effect::Glare) != Some(false))
    }

    /// Radiance at the point of the Sun's limb that is farthest from the visible part: the lowest along the limb.
    pub(crate) fn limb_radiance(&self) -> f64 {
        self.strength / self.far_limb_angle_sq
    }

    /// Radiance in a direction (a unit vector).
    pub(crate) fn radiance(&self, direction: DVec3) -> f64 {
        self.strength / (direction - self.towards).length_squared().max(self.core_angle_sq)
    }
}

/// The rectangle in the image that bounds all directions (unit vectors) whose distance from `towards` (a unit vector in camera axes: right, up, forward) is
/// less than `chord`.
pub(crate) fn rect_around(camera: &Camera, towards: DVec3, chord: f64) -> ClipRect {
    let angle = 2.0 * (0.5 * chord).min(1.0).asin();
    // Tangents of the smallest and the largest angle from the view axis, after projection along the image's other axis.
    let span = |across: f64| {
        let projected_length = across.hypot(towards.z);
        // PI, all angles: the directions surround the other axis, along which they are projected.
        let half_width = if angle < FRAC_PI_2 && angle.sin() < projected_length { (angle.sin() / projected_length).asin() } else { PI };
        let middle = across.atan2(towards.z);
        let tangent = |a: f64| if a.abs() < FRAC_PI_2 { a.tan() } else { f64::INFINITY.copysign(a) };
        (tangent(middle - half_width), tangent(middle + half_width))
    };
    let clip = |(from, to): (f64, f64), tan_half: f64| ((from / tan_half).clamp(-1.0, 1.0), (to / tan_half).clamp(-1.0, 1.0));
    let (left, right) = clip(span(towards.x), camera.tan_half_fov.x);
    let (bottom, top) = clip(span(towards.y), camera.tan_half_fov.y);
    ClipRect { left, top, right, bottom }
}

/// The glare of a frame, whether it is visible, and the reason; `None` without a Sun in the frame. `transmittance`: of the air in a direction (ICRF), per
/// channel.
pub(crate) fn glare(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    threshold: Threshold,
    transmittance: impl Fn(DVec3) -> DVec3,
) -> Option<(Glare, bool, Reason)> {
    let sun = placed.iter().find(|p| p.body.id == NaifId::SUN)?;
    let VeilingGlare { towards, strength, core_angle_sq, light_fraction, .. } = VeilingGlare::of(camera, placed)?;
    let strength = transmittance(sun.placement.centre_km / sun.distance_km) * strength;
    let core_radiance = strength.max_element() / core_angle_sq;
    let on = threshold.is_exceeded_by_radiance(core_radiance);
    let reason = if light_fraction > 0.0 {
        reason!("glare-at-limb", light = threshold.radiance_description(core_radiance))
    } else {
        reason!("glare-hidden")
    };
    let in_camera = camera.in_axes(towards);
    let cutoff = threshold.cutoff_radiance(VISIBLE_LIGHT);
    let rect = rect_around(camera, in_camera, (strength.max_element() / cutoff.max(f64::MIN_POSITIVE)).sqrt());
    let glare = Glare {
        rect_in_clip: rect.of_whole_pixels(camera.half_size_px()).narrowed(),
        sun_direction: narrow(in_camera),
        core_angle_sq: narrow_scalar(core_angle_sq),
        strength: narrow(strength),
        tan_half_fov: narrow2(camera.tan_half_fov),
        cutoff: narrow_scalar(cutoff),
        is_interpolated: request.purpose == Purpose::Display && request.quality != Quality::Reference,
    };
    Some((glare, on, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_the_light_is_scattered() {
        // The radiance divided by pi (the unit contains no factor pi), integrated over the solid angle from the limb to 30 degrees.
        let (from, to) = (0.266_f64.to_radians(), 30f64.to_radians());
        let fraction = VEILING_GLARE_COEFFICIENT / PI * 2.0 * PI * (to / from).ln();
        assert!((0.05..0.15).contains(&fraction), "{fraction}");
    }

    #[test]
    fn a_sun_outside_the_view_is_not_in_the_frame() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 2.0, 100, 100);
        let at = |deg: f64| DVec3::new(deg.to_radians().cos(), deg.to_radians().sin(), 0.0);
        // The frame ends at 1 degree, and the disc's angular radius is 0.27 degrees.
        for (deg, shows) in [(0.0, true), (1.2, true), (1.3, false), (89.9999, false), (90.0001, false), (180.0, false)] {
            assert_eq!(entered_fraction_of_disc(&camera, at(deg), 0.0047) > 0.0, shows, "{deg} degrees");
        }
    }

    #[test]
    fn the_rectangle_tightly_bounds_all_directions_within_the_chord() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 100, 80);
        for (direction, chord) in [([0.0, 0.0, 1.0], 0.2), ([0.3, -0.2, 0.9], 0.1), ([0.5, 0.5, 0.8], 0.7), ([0.1, 0.0, 1.0], 1.9)] {
            let towards = DVec3::from(direction).normalize();
            let rect = rect_around(&camera, towards, chord);
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
            // Only the largest chord, 1.9, reaches beyond the frame on all sides.
            assert_eq!(outside > 0, chord < 0.7 || direction == [0.5, 0.5, 0.8], "{direction:?}, {chord}");
        }
    }
}
