//! Points of light: stars, and bodies of a few pixels. This module defines over which diameters a drawn disc replaces a point, how a point's light is spread
//! over pixels (the point-spread function), and the glare of a small disc.
//!
//! In: a flux, the white level, the camera, the diameter of a disc. Out: the sprite's radius, the amplitudes of its core and glare, and the parts of a body's
//! light that disc, point and glare have. Not here: which stars and bodies are visible.
//!
//! The spread preserves the flux. Its core is a Gaussian of fixed width, lowered so that it is zero at the sprite's rim; so a pixel that a growing sprite
//! reaches starts at zero. Points whose central pixel is brighter than white also have a glare: here the wide part of a point's spread, not the glare around
//! the Sun (`light::glare`). The glare widens with brightness and contains at most 30 % of the light. shaders/entry/point.wesl draws the spread with the
//! constants of this module. The glare's profile is chosen to look like stars on photographs; it is not measured.
//!
//! Glare belongs to eye and lens, not to points: a disc brighter than white has glare, too, while the disc is small enough to be seen as a light rather than
//! as a surface. This glare shrinks while the disc grows, and is gone at [`NO_GLARE_FROM_PX`]. Which discs have glare: `light::disc_glare`.

use crate::catalog::NaifId;
use crate::scene::camera::{self, Camera};
use crate::scene::draw::Point;
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Smallest radius of a point's sprite: three standard deviations of its core, so that a star is 1.6 pixels wide at half maximum.
pub const MIN_POINT_RADIUS_PX: f64 = 2.0;
/// Standard deviation of the core.
pub const CORE_SIGMA_PX: f64 = MIN_POINT_RADIUS_PX / 3.0;
/// Scale radius of the glare, whose profile is (1 + r^2 / a^2)^-1.5 (Moffat's with exponent 1.5): 35 % of its peak at this radius, r^-3 far beyond it.
pub const GLARE_SCALE_RADIUS_PX: f64 = 2.0;
/// Upper limit of the fraction of the light that is in the glare; the brightest points approach it.
pub const MAX_GLARE_FRACTION: f64 = 0.3;
/// Exponent with which the sprite's radius grows with brightness relative to white: a star of first magnitude reaches 1.5 times as far as a star of second
/// magnitude.
pub const GLARE_RADIUS_EXPONENT: f64 = 0.45;
/// Largest radius of a point's sprite, a limit on its cost: the glare of the brightest points ends at this radius.
pub const MAX_RADIUS_PX: f64 = 64.0;
/// Diameter from which a disc gradually replaces a point; at [`DISC_ONLY_FROM_PX`] only the disc is left. Small discs are drawn too bright, because each pixel
/// is shaded at one place, where the light is above its mean over the covered part of the pixel. The mean error over all positions of the disc's centre in its
/// pixel (computed outside this program): a disc 4 pixels wide is 6 % too bright at full phase and within 10 % if half lit. A disc 2 pixels wide is 18 % too
/// bright at full phase and within 25 % if half lit.
pub(crate) const POINT_ONLY_BELOW_PX: f64 = 2.0;
/// See [`POINT_ONLY_BELOW_PX`].
pub(crate) const DISC_ONLY_FROM_PX: f64 = 4.0;
/// Diameter from which no disc has glare. From [`DISC_ONLY_FROM_PX`] on the glare shrinks to none.
pub(crate) const NO_GLARE_FROM_PX: f64 = 16.0;

/// Fraction of a body's light that is drawn as a disc, by the disc's diameter; the point has the rest.
pub fn disc_fraction(diameter_px: f64) -> f64 {
    smooth_rise((POINT_ONLY_BELOW_PX, DISC_ONLY_FROM_PX), diameter_px)
}

/// How far a disc is from a small one to one that is seen as a surface: 0 up to a diameter of [`DISC_ONLY_FROM_PX`], 1 from [`NO_GLARE_FROM_PX`]. It depends on
/// the logarithm of the diameter, so that the glare narrows about evenly in a steady zoom.
pub(crate) fn beyond_small_disc(diameter_px: f64) -> f64 {
    smoothstep((diameter_px / DISC_ONLY_FROM_PX).ln() / (NO_GLARE_FROM_PX / DISC_ONLY_FROM_PX).ln())
}

/// As [`disc_fraction`], but 1 if the user has switched points off, and for ground below the camera, however few pixels the image has. `points`: the user's
/// choice for the effect `points`; `None`: no choice.
pub(crate) fn drawn_disc_fraction(points: Option<bool>, placed: &PlacedBody<'_>, diameter_px: f64) -> f64 {
    if points == Some(false) || placed.is_ground_below_camera() { 1.0 } else { disc_fraction(diameter_px) }
}

/// For a core of amplitude 1: the Gaussian's value at the sprite's rim, and the integral over the sprite's circle of the Gaussian less this value.
struct LoweredCore {
    at_rim: f64,
    integral: f64,
}

fn lowered_core(radius_px: f64) -> LoweredCore {
    let exponent = 0.5 * (radius_px / CORE_SIGMA_PX).powi(2);
    let at_rim = (-exponent).exp();
    // The Gaussian's integral is 2 pi sigma^2 (1 - at_rim). The circle's area times `at_rim` is subtracted; the area is 2 pi sigma^2 times the exponent.
    LoweredCore { at_rim, integral: 2.0 * PI * CORE_SIGMA_PX.powi(2) * (1.0 - at_rim * (1.0 + exponent)) }
}

/// Peak of the point-spread function without glare, per square pixel: a point of flux F at a pixel's centre gives this pixel F times this value as radiance.
pub fn point_peak() -> f64 {
    let LoweredCore { at_rim, integral } = lowered_core(MIN_POINT_RADIUS_PX);
    (1.0 - at_rim) / integral
}

/// Radius of a point's sprite, at which its glare falls smoothly to zero. `brightness`: that of its central pixel relative to white, without glare.
pub(crate) fn point_radius_px(brightness: f64) -> f64 {
    (MIN_POINT_RADIUS_PX * brightness.max(1.0).powf(GLARE_RADIUS_EXPONENT)).min(MAX_RADIUS_PX)
}

/// Fraction of a point's light that is in the glare of a sprite of this radius: 0 for the smallest sprite, and a chosen law from there on.
fn glare_fraction(radius_px: f64) -> f64 {
    MAX_GLARE_FRACTION * (1.0 - (MIN_POINT_RADIUS_PX / radius_px).powi(2)).max(0.0)
}

/// Integral of the glare's profile over the circle of a sprite: its light for an amplitude of 1.
fn glare_integral(radius_px: f64, scale_radius_px: f64) -> f64 {
    // The glare is (1 - r^2 / R^2)^2 (1 + r^2 / a^2)^-1.5, R the sprite's radius and a the scale radius. Substituting u = 1 + r^2 / a^2 gives its
    // integral over the circle, divided by pi a^2, in closed form. `v` is u at the rim, `k` is a^2 / R^2, and the first factor is (c - k u)^2.
    let v = 1.0 + (radius_px / scale_radius_px).powi(2);
    let k = 1.0 / (v - 1.0);
    let c = 1.0 + k;
    let integral = 2.0 * c * c * (1.0 - v.powf(-0.5)) - 4.0 * c * k * (v.sqrt() - 1.0) + 2.0 / 3.0 * k * k * (v.powf(1.5) - 1.0);
    PI * scale_radius_px.powi(2) * integral
}

/// Amplitudes of core and glare for a point of flux 1 with a sprite of this radius: the factors on the lowered Gaussian and on the glare's profile.
pub fn point_spread(radius_px: f64) -> [f64; 2] {
    let glare_fraction = glare_fraction(radius_px);
    [(1.0 - glare_fraction) / lowered_core(radius_px).integral, glare_fraction / glare_integral(radius_px, GLARE_SCALE_RADIUS_PX)]
}

/// Brightness relative to white that decides the glare of a disc of this flux: pi times [`point_peak`], 1.18, times the disc's mean radiance. At a diameter of
/// [`POINT_ONLY_BELOW_PX`], it equals the brightness of a point's central pixel.
pub(crate) fn disc_brightness(flux: f64, white: f64, diameter_px: f64) -> f64 {
    flux * point_peak() * (POINT_ONLY_BELOW_PX / diameter_px).powi(2) / white
}

/// Fraction of a disc's light that is in its glare, and the radius of the glare's sprite. `brightness`: see [`disc_brightness`].
pub(crate) fn disc_glare(brightness: f64, diameter_px: f64) -> (f64, f64) {
    let faded = beyond_small_disc(diameter_px);
    // Radius of the sprite of a point with this glare. Around a disc the glare begins at the limb.
    let point_sprite_px = MIN_POINT_RADIUS_PX + (1.0 - faded) * (point_radius_px(brightness) - MIN_POINT_RADIUS_PX);
    (glare_fraction(point_sprite_px), (point_sprite_px + 0.5 * diameter_px).min(MAX_RADIUS_PX))
}

/// Scale radius of the glare of a disc in pixels, and its amplitude for a glare of flux 1. `radius_px`: of the glare's sprite.
pub fn disc_glare_spread(radius_px: f64, disc_radius_px: f64) -> [f64; 2] {
    // Each point of the disc has the glare of a point, so the disc's glare is the convolution of the disc with a point's profile (1 + r^2 / a^2)^-1.5. The
    // convolution of two such profiles (Cauchy distributions in two dimensions) is such a profile, whose scale radius is the sum of theirs. Therefore the disc
    // is replaced by the profile with the same radius of half of the light: sqrt(1/2) of a disc's radius, sqrt(3) of a profile's scale radius.
    let scale_radius_px = GLARE_SCALE_RADIUS_PX + disc_radius_px / 6_f64.sqrt();
    [scale_radius_px, 1.0 / glare_integral(radius_px, scale_radius_px)]
}

/// The flux of a body's point by its [`PlacedBody::shown_irradiance`], linear RGB.
pub(crate) fn flux(camera: &Camera, placed: &PlacedBody<'_>) -> DVec3 {
    flux_of_irradiance(camera, placed, placed.shown_irradiance)
}

/// The flux of a body that causes an irradiance at the viewer, both linear RGB: the radiance that it would have if it filled one pixel.
pub(crate) fn flux_of_irradiance(camera: &Camera, placed: &PlacedBody<'_>, irradiance: DVec3) -> DVec3 {
    let direction = placed.placement.centre_km / placed.distance_km;
    // In the units used, radiance 1 is that of a white Lambert plane under irradiance 1, which is 1 / pi per steradian: hence the factor.
    irradiance * (PI / pixel_sr(camera, direction))
}

/// Solid angle of a pixel in a direction (unit vector): perspective shrinks it by the third power of the cosine of the angle to the axis. The lower limit of
/// the cosine keeps it above 0 in directions beside the frame.
pub(crate) fn pixel_sr(camera: &Camera, direction: DVec3) -> f64 {
    camera.pixel_tangent().powi(2) * direction.dot(camera.forward).max(1e-3).powi(3)
}

/// Radius of the sprite of a point of this flux: wide enough for the glare of a point that is brighter than white, else the smallest.
/// `white`: the radiance shown as white.
pub(crate) fn sprite_radius_px(flux: f64, white: f64) -> f64 {
    point_radius_px(flux * point_peak() / white)
}

/// Sets the radius of a point's sprite (see [`sprite_radius_px`]).
pub(crate) fn set_sprite_radius(point: &mut Point, white: f64) {
    point.radius_px = camera::narrow_scalar(sprite_radius_px(point.flux.max_element().into(), white));
}

/// The glare's profile at a distance from the centre of a sprite of this radius, relative to its amplitude in [`point_spread`]; as in
/// shaders/lib/point_light.wesl.
pub(crate) fn glare_profile(distance_px: f64, radius_px: f64) -> f64 {
    let fade = (1.0 - (distance_px / radius_px).powi(2)).max(0.0);
    fade * fade * (1.0 + (distance_px / GLARE_SCALE_RADIUS_PX).powi(2)).powf(-1.5)
}

/// Whether a sprite of this radius around a clip position (normalised device coordinates) may reach into the frame. The margin beyond the frame, the radius
/// plus 2 pixels, is at least 4 pixels. So a body that is drawn as point and disc keeps its point wherever its disc is drawn: up to 3.5 pixels beyond the frame
/// (a radius of 2, and the padding of its outline, 1.5).
pub(crate) fn reaches_frame(camera: &Camera, clip: DVec2, radius_px: f64) -> bool {
    clip.abs().cmple(DVec2::ONE + (radius_px + 2.0) / camera.half_size_px()).all()
}

/// A point's sprite. Its reversed depth is 1, that of the near plane, so that it is drawn over all bodies; [`crate::scene::visibility::hidden`]
/// removes the part of it that nearer bodies hide. `covered_px`: see [`Point::covered_px`].
pub(crate) fn sprite(body: NaifId, clip: DVec2, flux: DVec3, covered_px: f64) -> Point {
    let radius_px = camera::narrow_scalar(MIN_POINT_RADIUS_PX);
    let [centre, flux] = [clip.extend(1.0), flux].map(camera::narrow);
    Point { body, centre, radius_px, stretch: 1.0, flux, covered_px: camera::narrow_scalar(covered_px), disc_radius_px: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For every radius, the spread integrated numerically over the sprite's bounding square is 1, the flux. The glare starts at zero, and the radius
    /// grows with brightness without a jump.
    #[test]
    fn a_points_light_is_its_flux() {
        let mut last = 0.0;
        for k in 0..=50 {
            let brightness = 10_f64.powf(f64::from(k) / 10.0 - 0.5);
            let radius = point_radius_px(brightness);
            let [core, glare] = point_spread(radius);
            let side = 800;
            let step = 2.0 * radius / f64::from(side);
            let at = |n: i32| (f64::from(n) + 0.5) * step - radius;
            let light = |x: f64, y: f64| {
                let r_sq = x * x + y * y;
                let fade = (1.0 - r_sq / (radius * radius)).max(0.0);
                let gauss = |r_sq: f64| (-0.5 * r_sq / CORE_SIGMA_PX.powi(2)).exp();
                core * (gauss(r_sq) - gauss(radius * radius)).max(0.0)
                    + glare * fade * fade * (1.0 + r_sq / GLARE_SCALE_RADIUS_PX.powi(2)).powf(-1.5)
            };
            let sum: f64 = (0..side).map(|y| (0..side).map(|x| light(at(x), at(y))).sum::<f64>()).sum::<f64>() * step * step;
            assert!((sum - 1.0).abs() < 1e-4, "{radius}: {sum}");
            // A step multiplies the brightness by 10^0.1, which widens the radius by a tenth of itself (10^0.045 = 1.11).
            assert!(radius - last < 0.13 * radius && radius >= last || k == 0, "{last} {radius}");
            last = radius;
        }
        assert_eq!(point_spread(point_radius_px(1.0))[1], 0.0);
    }

    /// The glare of a disc has the light that `disc_glare` says: its spread, integrated numerically, is 1. With the scale radius of a point it would not be.
    #[test]
    fn the_glare_of_a_disc_has_its_light() {
        for (brightness, diameter_px) in [(1.5, 2.1), (1.5, 12.0), (30.0, 4.0), (30.0, 8.0), (3e4, 3.0), (3e4, 15.9)] {
            let (fraction, radius_px) = disc_glare(brightness, diameter_px);
            let disc_radius_px = 0.5 * diameter_px;
            assert!(fraction > 0.0 && fraction <= MAX_GLARE_FRACTION && radius_px > disc_radius_px && radius_px <= MAX_RADIUS_PX);
            let [scale_px, amplitude] = disc_glare_spread(radius_px, disc_radius_px);
            let step = radius_px / 4000.0;
            let light = |scale_px: f64| {
                let ring = |r: f64| {
                    (1.0 - (r / radius_px).powi(2)).powi(2) * (1.0 + (r / scale_px).powi(2)).powf(-1.5) * 2.0 * PI * r * step * amplitude
                };
                (0..4000).map(|n| ring((f64::from(n) + 0.5) * step)).sum::<f64>()
            };
            assert!((light(scale_px) - 1.0).abs() < 1e-5, "{brightness} {diameter_px}: {}", light(scale_px));
            assert!(light(GLARE_SCALE_RADIUS_PX) < 0.9, "{brightness} {diameter_px}: {}", light(GLARE_SCALE_RADIUS_PX));
        }
    }

    /// From disc to point, brightness and glare change steadily. A disc of [`NO_GLARE_FROM_PX`] has none, nor has one that is not brighter than white.
    #[test]
    fn the_glare_of_a_disc_shrinks_to_nothing() {
        assert!((disc_brightness(5.0, 0.5, POINT_ONLY_BELOW_PX) - 5.0 * point_peak() / 0.5).abs() < 1e-12);
        for brightness in [0.5, 1.0, 2.0, 3e4] {
            let (fraction_of_large, _) = disc_glare(brightness, NO_GLARE_FROM_PX);
            let (fraction_of_small, _) = disc_glare(brightness, DISC_ONLY_FROM_PX);
            assert!(fraction_of_large <= 0.0 && (brightness > 1.0) == (fraction_of_small > 0.0));
        }
        // A zoom from 2 to 16 pixels in steps of 1 %. For each step: the fraction of the light in the glare, and the radius of its sprite.
        let glare: Vec<_> = (0..=209).map(|k| disc_glare(3e4, 2.0 * 1.01_f64.powi(k))).collect();
        for [before, after] in glare.array_windows::<2>() {
            let ((fraction_before, radius_before_px), (fraction, radius_px)) = (before, after);
            assert!(fraction <= fraction_before && fraction_before - fraction < 0.03, "{before:?} {after:?}");
            assert!((radius_px - radius_before_px).abs() < 0.8, "{before:?} {after:?}");
        }
    }
}
