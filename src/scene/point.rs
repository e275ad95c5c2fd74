//! Bodies of a few pixels: where a point takes over from the disc, and how its light is spread.

use crate::catalog::NaifId;
use crate::scene::camera::{self, Camera};
use crate::scene::draw::Point;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};

/// Reach of a point's sprite: three standard deviations of its point-spread function, so that a star is 1.6 pixels wide at half height.
pub(crate) const POINT_RADIUS_PX: f64 = 2.0;
/// Diameters between which a disc takes over from a point. Below, a pixel's one place on the disc stands for too much of it: over places
/// in the pixel a full disc of 4 pixels is 6 % too bright, a half-lit one within 10 %; at 2 pixels 18 % and 25 % (worked outside).
pub const BLEND_FROM_PX: f64 = 2.0;
pub const BLEND_TO_PX: f64 = 4.0;

/// Part of the light that the disc draw carries at a diameter; the point carries the rest.
pub fn disc_share(diameter_px: f64) -> f64 {
    let x = ((diameter_px - BLEND_FROM_PX) / (BLEND_TO_PX - BLEND_FROM_PX)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Part of a point's flux that its brightest pixel gets.
pub(crate) fn point_peak() -> f64 {
    1.0 / (2.0 * std::f64::consts::PI * (POINT_RADIUS_PX / 3.0).powi(2))
}

/// Sum of the body's radiance over the pixels, linear RGB.
pub(crate) fn flux(camera: &Camera, p: &PlacedBody<'_>) -> DVec3 {
    let direction = p.placement.centre_km / p.distance_km;
    let cos_off_axis = direction.dot(camera.forward);
    // Solid angle of the pixel at that place of the image plane.
    let pixel_sr = camera.pixel_tangent().powi(2) * cos_off_axis.max(1e-3).powi(3);
    p.body.colour.as_dvec3() * (p.irradiance * std::f64::consts::PI / pixel_sr)
}

/// Drawn over all bodies: what nearer ones hide of it is taken from its flux (`crate::scene::visibility::hidden`).
pub(crate) fn sprite(body: NaifId, clip: DVec2, flux: DVec3) -> Point {
    Point { body, centre: camera::narrow(clip.extend(1.0)), radius_px: camera::narrow_scalar(POINT_RADIUS_PX), flux: camera::narrow(flux) }
}
