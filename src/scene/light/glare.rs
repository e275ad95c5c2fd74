//! The Sun's glare (effect and shader `glow`): light that the optics of the eye or a camera scatter around the Sun's disc while the Sun is in the image or
//! just beside it.
//!
//! In: the Sun's apparent position, the bodies in front of it, the threshold. Out: [`Glare`], the uniforms of shaders/entry/glow.wesl, and the reason; for
//! light meter and corona, `VeilingGlare`: the glare's radiance before the air dims it.
//!
//! The law of Stiles and Holladay is L = 10 E / theta^2, with the luminance L in cd/m2, the illuminance E in lux and the angle theta from the Sun in
//! degrees. CIE 146:2002 gives it for 1 to 30 degrees; closer to the Sun it is extrapolated. From 30 to 90 degrees it fades to nothing, which is chosen: a
//! hood keeps the light of a Sun far beside the line of sight from the lens. About a tenth of the light is scattered by up to 30 degrees.
//! The law represents the glare of eye and lens together; a clean lens scatters less, by a factor that depends on the lens. Within the Sun's limb (or
//! within a pixel, if that is wider) the glare is constant. The glare of a partly hidden Sun is centred on the middle of the visible part, and its
//! constant core shrinks with the visible light. The glare is therefore bright around the last bead, and faint at the opposite limb of the Moon. The
//! glare is drawn as far as it can change a display level: farther out it adds less than [`VISIBLE_LIGHT`] of white. The disc keeps its full radiance, a
//! hundred times that of the glare's core. While the Sun leaves the image, a factor on all of its glare falls to 0 over some degrees (`faded`): a lens has a
//! hood that fits its field of view. The image is that of the whole composition, so that the glare depends only on the direction: it is the same in each face
//! of a dome image or a whole-sphere image, and in the latter the factor is always 1. Left out: streaks and ghosts, which are specific to a lens. Not here:
//! the glare of points (`scene::point`) and of small discs (`light::disc_glare`).

use crate::catalog::NaifId;
use crate::ephemeris::angle_rad;
use crate::message::{Reason, reason};
use crate::scene::camera::{Camera, ClipRect, narrow, narrow_scalar, narrow2};
use crate::scene::numeric::smooth_rise;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::{Purpose, Threshold};
use crate::scene::request::effects::Effect;
use crate::scene::request::{Quality, ViewRequest};
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::units::luminance;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

/// L theta^2 / E of the law above, with theta in radians, in units where a white plane under irradiance E has the radiance E (no factor pi):
/// pi * 10 * (pi / 180)^2.
pub const VEILING_GLARE_COEFFICIENT: f64 = PI * 10.0 * (PI / 180.0) * (PI / 180.0);

/// Squares of the chords (between unit vectors) of 30 and 90 degrees, between which the law fades to nothing.
const LAW_FADES_SQ: (f64, f64) = (0.267_949_192_431, 2.0);

/// Exponent with which the glare falls while the Sun leaves the image: chosen, not derived. The glare is far brighter than the dark sky, and the eye sees
/// ratios of light.
const FADING_EXPONENT: i32 = 6;
/// Over this part of half the field of view, but at most this angle, the glare of a Sun beside the image fades to nothing (chosen); over the angular radius of
/// the Sun if that is wider.
const FADING_PART_OF_HALF_FIELD: f64 = 0.3;
const MAX_FADING_RAD: f64 = 10.0 * PI / 180.0;

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
    /// Tangents of half the horizontal and half the vertical field of view.
    pub tan_half_fov: Vec2,
    /// Radiance that is subtracted everywhere, so that the light falls to zero at the rectangle's edge; 0 for linear light.
    pub cutoff: f32,
    /// Squared chords from the Sun between which the law fades to nothing.
    pub law_fades_sq: Vec2,
    /// Whether a renderer may interpolate the light between shaded points. False for linear light, which is measured, and at reference quality.
    pub is_interpolated: bool,
}

/// The fraction of the luminance of the Sun's light that no body hides from the camera.
pub(crate) fn visible_fraction(placed: &[PlacedBody<'_>], sun: &PlacedBody<'_>) -> f64 {
    let visible = crate::scene::visibility::hidden::visible_fraction(placed, sun);
    // An uncovered Sun must give exactly 1, which the rounded sum of the luminance weights does not.
    if visible == DVec3::ONE { 1.0 } else { luminance(visible.to_array()) }
}

/// The position of the middle of the Sun's visible part relative to the Sun's centre, in solar radii; and the factor on the square of the core's angle. The
/// factor is the square root of the visible fraction of light. The radiance in the core, strength / square of the core's angle, is then proportional to this
/// square root, too, so that the core fades out with the light.
fn middle_and_core_factor(placed: &[PlacedBody<'_>], sun: &PlacedBody<'_>) -> (DVec3, f64) {
    let light = visible_fraction(placed, sun);
    if light <= 0.0 || light >= 1.0 {
        return (DVec3::ZERO, light.clamp(0.0, 1.0));
    }
    (crate::scene::visibility::hidden::visible_middle(placed, sun), light.sqrt())
}

/// The factor on the glare of a disc whose centre is by the angle `outside` beyond an edge of the image (negative inside): 1 once the centre is inside, or once
/// the disc has entered by half the field; 0 from some degrees outside on. `half_field`: half the field of view across this edge; `widest`: upper limit of the
/// angle over which the glare fades. All angles in radians.
fn faded(outside: f64, half_field: f64, radius: f64, widest: f64) -> f64 {
    let radius = radius.min(widest);
    let width = radius.max((FADING_PART_OF_HALF_FIELD * half_field).min(MAX_FADING_RAD)).min(widest);
    // A disc wider than the field has its full glare once its limb has passed the middle of the image.
    let full_from = (radius - half_field).max(0.0);
    ((width - outside) / (width - full_from)).clamp(0.0, 1.0).powi(FADING_EXPONENT)
}

/// How far a disc is in the image or near it: 1 while it is inside, falling to 0 while it leaves. `towards`: unit vector to the disc's centre, ICRF;
/// `sin_radius`: sine of the disc's angular radius.
fn entered_fraction_of_disc(camera: &Camera, towards: DVec3, sin_radius: f64) -> f64 {
    let radius = sin_radius.asin();
    if let Some(cone) = camera.composed_cone {
        return faded(angle_rad(towards, cone.axis) - cone.half_angle_rad, cone.half_angle_rad, radius, PI);
    }
    let in_camera = camera.in_axes(towards);
    if in_camera.z <= 0.0 {
        return 0.0;
    }
    // With the half fields h and v, each direction at a right angle to the line of sight is at least by the angle `widest` beyond an edge. So the glare is gone
    // before the Sun is behind the camera.
    let [h, v] = [camera.tan_half_fov.x.atan(), camera.tan_half_fov.y.atan()];
    let widest = (h.cos().powi(-2) + v.cos().powi(-2)).sqrt().recip().asin();
    let along = |across: f64, half_field: f64| {
        // The distance from the plane through the camera and the edge of the image.
        let outside = across.abs() * half_field.cos() - in_camera.z * half_field.sin();
        faded(outside.clamp(-1.0, 1.0).asin(), half_field, radius, widest)
    };
    along(in_camera.x, h) * along(in_camera.y, v)
}

/// How far the Sun is in the image or near it: the factor on its glare. Not for a camera at the Sun's centre.
pub(crate) fn entered_fraction(camera: &Camera, sun: &PlacedBody<'_>) -> f64 {
    entered_fraction_of_disc(camera, sun.placement.centre_km / sun.distance_km, (sun.body.radii_km.x / sun.distance_km).min(1.0))
}

/// Fraction of the law that remains at a squared chord from the Sun.
fn law_fraction(chord_sq: f64) -> f64 {
    1.0 - smooth_rise(LAW_FADES_SQ, chord_sq)
}

/// The glare around the Sun's visible part. Its radiance at an angle theta from the middle of that part is `strength` / theta², with the chord between unit
/// vectors as theta, times a fraction that falls from 1 to 0 between 30 and 90 degrees (`law_fraction`). In the core, where theta² is below `core_angle_sq`
/// (radians squared), it is constant. The air between camera and Sun is left out.
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
    /// The glare of the Sun; `None` if the Sun is not in `placed`, or so far outside the image that it has none, or if the camera is at its centre.
    pub(crate) fn of(camera: &Camera, placed: &[PlacedBody<'_>]) -> Option<Self> {
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
        // The core's angle is at least that of a pixel, before and after the factor.
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
        let chord_sq = (direction - self.towards).length_squared();
        self.strength * law_fraction(chord_sq) / chord_sq.max(self.core_angle_sq)
    }
}

/// The rectangle in the image that bounds all directions (unit vectors) whose distance from `towards` (a unit vector in camera axes: right, up, forward) is
/// less than `chord`.
pub(crate) fn rect_around(camera: &Camera, towards: DVec3, chord: f64) -> ClipRect {
    let angle = 2.0 * (0.5 * chord).min(1.0).asin();
    // Along one axis of the image: tangents of the smallest and the largest angle from the view axis, after projection along the other axis.
    let span = |across: f64| {
        let projected_length = across.hypot(towards.z);
        // If the cone of the directions contains an end of the other axis, it contains directions at all angles.
        if angle >= FRAC_PI_2 || angle.sin() >= projected_length {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let half_width = (angle.sin() / projected_length).asin();
        let middle = across.atan2(towards.z);
        let tangent = |a: f64| if a.abs() < FRAC_PI_2 { a.tan() } else { f64::INFINITY.copysign(a) };
        (tangent(middle - half_width), tangent(middle + half_width))
    };
    let clip = |(from, to): (f64, f64), tan_half: f64| ((from / tan_half).clamp(-1.0, 1.0), (to / tan_half).clamp(-1.0, 1.0));
    let (left, right) = clip(span(towards.x), camera.tan_half_fov.x);
    let (bottom, top) = clip(span(towards.y), camera.tan_half_fov.y);
    ClipRect { left, top, right, bottom }
}

/// The glare of a frame, whether it is visible, and the reason; `None` without a Sun in the image or just beside it. `transmittance`: of the air in a direction
/// (ICRF), per channel.
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
    let in_camera = camera.in_axes(towards);
    // The squared chord to the nearest point of the image; 0 for the Sun in the frame. In a composed image all frames decide alike, as for a Sun inside.
    let nearest_sq = if camera.composed_cone.is_none() && in_camera.z > 0.0 {
        let nearest = (in_camera.truncate() / in_camera.z).clamp(-camera.tan_half_fov, camera.tan_half_fov).extend(1.0).normalize();
        (nearest - in_camera).length_squared()
    } else {
        0.0
    };
    let brightest = strength.max_element() * law_fraction(nearest_sq) / nearest_sq.max(core_angle_sq);
    let on = threshold.is_exceeded_by_radiance(brightest);
    let reason = if light_fraction <= 0.0 {
        reason!("glare-hidden")
    } else if nearest_sq > core_angle_sq {
        reason!("glare-from-beside", light = threshold.radiance_description(brightest))
    } else {
        reason!("glare-at-limb", light = threshold.radiance_description(brightest))
    };
    let cutoff = threshold.cutoff_radiance(VISIBLE_LIGHT);
    let reach = (strength.max_element() / cutoff.max(f64::MIN_POSITIVE)).sqrt().min(SQRT_2);
    let rect = rect_around(camera, in_camera, reach);
    let glare = Glare {
        rect_in_clip: rect.of_whole_pixels(camera.half_size_px()).narrowed(),
        sun_direction: narrow(in_camera),
        core_angle_sq: narrow_scalar(core_angle_sq),
        strength: narrow(strength),
        tan_half_fov: narrow2(camera.tan_half_fov),
        cutoff: narrow_scalar(cutoff),
        law_fades_sq: narrow2(LAW_FADES_SQ.into()),
        is_interpolated: request.purpose == Purpose::Display && request.quality != Quality::Reference,
    };
    Some((glare, on, reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::ComposedCone;

    #[test]
    fn a_tenth_of_the_light_is_scattered() {
        // The radiance divided by pi (the unit contains no factor pi), integrated over the solid angle from the Sun's limb at 0.266 degrees to 30 degrees.
        let (from, to) = (0.266_f64.to_radians(), 30f64.to_radians());
        let fraction = VEILING_GLARE_COEFFICIENT / PI * 2.0 * PI * (to / from).ln();
        assert!((0.05..0.15).contains(&fraction), "{fraction}");
    }

    /// The sine of the Sun's angular radius seen from the Earth: 0.27 degrees.
    const SIN_RADIUS: f64 = 0.0047;

    fn at(deg: f64) -> DVec3 {
        DVec3::new(deg.to_radians().cos(), deg.to_radians().sin(), 0.0)
    }

    #[test]
    fn a_sun_far_outside_the_view_has_no_glare() {
        let camera = |fov_deg: f64| Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, fov_deg, 100, 100);
        // The frame ends at half the field of view. In the narrowest field the glare fades over the Sun's radius, otherwise over 0.3 of half the field, in the
        // widest over 10 degrees.
        for (fov_deg, full, shows, gone) in
            [(1.0, 0.49, 0.76, 0.78), (2.0, 0.99, 1.25, 1.35), (60.0, 29.9, 38.0, 39.1), (120.0, 59.9, 69.0, 70.1)]
        {
            let entered = |deg: f64| entered_fraction_of_disc(&camera(fov_deg), at(deg), SIN_RADIUS);
            assert_eq!(entered(full), 1.0, "{fov_deg}");
            assert!(entered(shows) > 0.0 && entered(shows) < 0.01, "{fov_deg}: {}", entered(shows));
            for deg in [gone, 89.9999, 90.0001, 150.0, 180.0] {
                assert_eq!(entered(deg), 0.0, "{fov_deg}: {deg} degrees");
            }
        }
        // In the widest field it is gone, before the Sun is at a right angle to the line of sight, at every position angle.
        let camera = camera(170.0);
        for k in 0..360 {
            let (sin, cos) = f64::from(k).to_radians().sin_cos();
            let towards = |depth: f64| DVec3::new(depth, cos, sin).normalize();
            assert!(entered_fraction_of_disc(&camera, towards(1e-6), SIN_RADIUS) < 1e-9, "{k}");
            assert_eq!(entered_fraction_of_disc(&camera, towards(-1e-6), SIN_RADIUS), 0.0, "{k}");
        }
    }

    /// From 10 to 70 degrees beside a Sun's direction, in steps of 0.1 degrees, the light in the image's middle never jumps by more than a sixth. Negative
    /// control: over the Sun's radius alone it would lose most of its light in one step, and all in three.
    #[test]
    fn the_glare_of_a_sun_that_leaves_the_image_fades_steadily() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 100, 100);
        let light = |k: u32| entered_fraction_of_disc(&camera, at(0.1 * f64::from(k)), SIN_RADIUS);
        // Down to 1e-4 of the light, beyond which a step cannot be seen.
        for k in (100..700).take_while(|k| light(*k) > 1e-4) {
            assert!(light(k + 1) > light(k) * 5.0 / 6.0 - 1e-4, "{k}: {} to {}", light(k), light(k + 1));
        }
        let narrow = |outside_deg: f64| faded(outside_deg.to_radians(), 2.0 * SIN_RADIUS, SIN_RADIUS, PI);
        assert!(narrow(0.1) < 0.2 && narrow(0.3) == 0.0);
    }

    /// In a composed image only the image's own edge counts, whichever frame shows the direction; a whole-sphere image has none.
    #[test]
    fn every_face_of_a_dome_has_the_same_glare() {
        for (forward, up) in [(DVec3::X, DVec3::Z), (DVec3::Y, DVec3::Z), (DVec3::NEG_Y, DVec3::Z), (DVec3::Z, DVec3::X)] {
            let entered = |half_angle_deg: f64, deg: f64| {
                let cone = ComposedCone { axis: DVec3::X, half_angle_rad: half_angle_deg.to_radians() };
                let face = Camera { composed_cone: Some(cone), ..Camera::looking(DVec3::ZERO, forward, up, 90.0, 100, 100) };
                entered_fraction_of_disc(&face, at(deg), SIN_RADIUS)
            };
            for deg in [0.0, 50.0, 89.0, 130.0, 180.0] {
                assert_eq!(entered(180.0, deg), 1.0, "{deg}");
            }
            assert_eq!([0.0, 60.0, 89.9, 100.1, 180.0].map(|deg| entered(90.0, deg)), [1.0, 1.0, 1.0, 0.0, 0.0]);
            assert!((entered(90.0, 95.0) - 0.5_f64.powi(FADING_EXPONENT)).abs() < 1e-9);
        }
    }

    /// The law of Stiles and Holladay up to 30 degrees; beyond, the light falls faster, to nothing at 90 degrees.
    #[test]
    fn the_law_ends_at_a_right_angle() {
        let glare = VeilingGlare { towards: DVec3::X, strength: 1.0, core_angle_sq: 1e-6, far_limb_angle_sq: 1e-6, light_fraction: 1.0 };
        let times_chord_sq = |deg: f64| glare.radiance(at(deg)) * (at(deg) - DVec3::X).length_squared();
        for deg in [1.0, 10.0, 29.9] {
            assert!((times_chord_sq(deg) - 1.0).abs() < 1e-6, "{deg}");
        }
        assert!((0.5..0.7).contains(&times_chord_sq(60.0)) && times_chord_sq(90.1) == 0.0 && times_chord_sq(180.0) == 0.0);
    }

    #[test]
    fn the_rectangle_tightly_bounds_all_directions_within_the_chord() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 100, 80);
        for (direction, chord) in [
            ([0.0, 0.0, 1.0], 0.2),
            ([0.3, -0.2, 0.9], 0.1),
            ([0.5, 0.5, 0.8], 0.7),
            ([0.1, 0.0, 1.0], 1.9),
            // Nearly all directions: all but those around the point opposite, which is in the frame.
            ([0.1, 0.05, -1.0], 1.99),
        ] {
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
            // Only the rectangles of the largest chords, 1.9 and 1.99, fill the frame; the others leave a part of it outside.
            assert_eq!(outside > 0, chord < 0.7 || direction == [0.5, 0.5, 0.8], "{direction:?}, {chord}");
        }
    }
}
