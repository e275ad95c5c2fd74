//! Points of light: stars, and bodies of a few pixels. This module defines how disc and point blend, and how a point's light is spread over pixels.
//!
//! The spread preserves the flux. It is a Gaussian core of fixed width minus its value at the sprite's rim, so that it falls to zero there and no pixel
//! jumps as the sprite grows. Points brighter than white also have a glare, which widens with brightness and contains at most 30 % of the light.
//! shaders/entry/point.wesl draws the spread with the constants of this module. The law of the glare is chosen to look like stars on photographs; it is not
//! measured.

use crate::catalog::NaifId;
use crate::scene::camera::{self, Camera};
use crate::scene::draw::Point;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Smallest radius of a point's sprite: three standard deviations of its core, so that a star is 1.6 pixels wide at half maximum.
pub const POINT_RADIUS_PX: f64 = 2.0;
/// Standard deviation of the core.
pub const CORE_SIGMA_PX: f64 = POINT_RADIUS_PX / 3.0;
/// Radius within which the glare is nearly constant; beyond, it falls with the third power of the distance.
pub const GLARE_WIDTH_PX: f64 = 2.0;
/// Fraction of the light that goes into the glare of the brightest points.
pub const GLARE_FRACTION: f64 = 0.3;
/// Exponent with which the sprite's radius grows with brightness relative to white: a star of first magnitude reaches 1.5 times as far as a star of second
/// magnitude.
pub const GLARE_RADIUS_EXPONENT: f64 = 0.45;
/// Largest radius of a point's sprite.
pub const MAX_RADIUS_PX: f64 = 64.0;
/// Range of diameters over which a disc gradually replaces a point. In a smaller disc one sample per pixel represents too much of the disc: averaged over
/// positions in the pixel, a full disc of 4 pixels is 6 % too bright, a half-lit disc within 10 %; at 2 pixels 18 % and 25 % (computed outside this program).
pub(crate) const BLEND_FROM_PX: f64 = 2.0;
pub(crate) const BLEND_TO_PX: f64 = 4.0;

/// Fraction of a body's light that is drawn as a disc, by its diameter; the point has the rest.
pub fn disc_share(diameter_px: f64) -> f64 {
    let x = ((diameter_px - BLEND_FROM_PX) / (BLEND_TO_PX - BLEND_FROM_PX)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// For a Gaussian of height 1 minus its value at the sprite's rim: returns the value at the rim, and the integral over the sprite's circle.
fn truncated_core(radius_px: f64) -> (f64, f64) {
    let x = 0.5 * (radius_px / CORE_SIGMA_PX).powi(2);
    let rim = (-x).exp();
    (rim, 2.0 * PI * CORE_SIGMA_PX.powi(2) * (1.0 - rim * (1.0 + x)))
}

/// Fraction of a point's flux in its central pixel, for points no brighter than white.
pub fn point_peak() -> f64 {
    let (rim, integral) = truncated_core(POINT_RADIUS_PX);
    (1.0 - rim) / integral
}

/// Radius of a point's sprite, at which its glare falls smoothly to zero. `peak`: brightness of its central pixel relative to white, without glare.
pub(crate) fn point_radius_px(peak: f64) -> f64 {
    (POINT_RADIUS_PX * peak.max(1.0).powf(GLARE_RADIUS_EXPONENT)).min(MAX_RADIUS_PX)
}

/// Amplitudes of core and glare for a point of flux 1 with a sprite of this radius. The core is the Gaussian minus its value at the rim.
pub fn point_spread(radius_px: f64) -> [f64; 2] {
    let glare = GLARE_FRACTION * (1.0 - (POINT_RADIUS_PX / radius_px).powi(2)).max(0.0);
    // The glare is (1 - r^2 / R^2)^2 (1 + r^2 / a^2)^-1.5; with v = 1 + r^2 / a^2 its integral over the circle has a closed form.
    let v = 1.0 + (radius_px / GLARE_WIDTH_PX).powi(2);
    let k = 1.0 / (v - 1.0);
    let c = 1.0 + k;
    let integral = 2.0 * c * c * (1.0 - v.powf(-0.5)) - 4.0 * c * k * (v.sqrt() - 1.0) + 2.0 / 3.0 * k * k * (v.powf(1.5) - 1.0);
    [(1.0 - glare) / truncated_core(radius_px).1, glare / (PI * GLARE_WIDTH_PX.powi(2) * integral)]
}

/// The body's radiance summed over pixels, linear RGB.
pub(crate) fn flux(camera: &Camera, p: &PlacedBody<'_>) -> DVec3 {
    let direction = p.placement.centre_km / p.distance_km;
    let cos_off_axis = direction.dot(camera.forward);
    // Solid angle of the pixel at the body's position in the image plane.
    let pixel_sr = camera.pixel_tangent().powi(2) * cos_off_axis.max(1e-3).powi(3);
    p.body.colour.as_dvec3() * (p.irradiance * PI / pixel_sr)
}

/// Widens the sprite of a point that is brighter than white, so that it contains the glare.
pub(crate) fn spread_glare(point: &mut Point, white: f64) {
    point.radius_px = camera::narrow_scalar(point_radius_px(f64::from(point.flux.max_element()) * point_peak() / white));
}

/// A point's sprite. It is drawn over all bodies; [`crate::scene::visibility::hidden`] removes the flux that nearer bodies hide.
pub(crate) fn sprite(body: NaifId, clip: DVec2, flux: DVec3) -> Point {
    Point { body, centre: camera::narrow(clip.extend(1.0)), radius_px: camera::narrow_scalar(POINT_RADIUS_PX), flux: camera::narrow(flux) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For every radius, the light summed over small steps of the sprite's square equals the flux. The glare starts at zero and the radius grows without a
    /// jump.
    #[test]
    fn a_points_light_is_its_flux() {
        let mut last = 0.0;
        for k in 0..=50 {
            let peak = 10_f64.powf(f64::from(k) / 10.0 - 0.5);
            let radius = point_radius_px(peak);
            let [core, glare] = point_spread(radius);
            let side = 800;
            let step = 2.0 * radius / f64::from(side);
            let at = |n: i32| (f64::from(n) + 0.5) * step - radius;
            let light = |x: f64, y: f64| {
                let r_sq = x * x + y * y;
                let edge = (1.0 - r_sq / (radius * radius)).max(0.0);
                let gauss = |r_sq: f64| (-0.5 * r_sq / CORE_SIGMA_PX.powi(2)).exp();
                core * (gauss(r_sq) - gauss(radius * radius)).max(0.0)
                    + glare * edge * edge * (1.0 + r_sq / GLARE_WIDTH_PX.powi(2)).powf(-1.5)
            };
            let sum: f64 = (0..side).map(|y| (0..side).map(|x| light(at(x), at(y))).sum::<f64>()).sum::<f64>() * step * step;
            assert!((sum - 1.0).abs() < 1e-4, "{radius}: {sum}");
            assert!(radius - last < 0.13 * radius && radius >= last || k == 0, "{last} {radius}");
            last = radius;
        }
        assert_eq!(point_spread(point_radius_px(1.0))[1], 0.0);
    }
}
