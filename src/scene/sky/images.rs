//! The user's images of the sky, drawn behind all bodies. Each is in a tangent plane of the celestial sphere (gnomonic projection, FITS `TAN`).
//!
//! In: the catalog's layers with an image of the sky, the camera, the viewer's velocity. Out: [`SkyImageDraw`], the uniforms of
//! shaders/entry/sky_image.wesl, and the decisions. Always: an image is display-referred: its white is white at any exposure. Its tangent point and axes
//! follow stellar aberration; the variation of aberration over the image (0.35 arcsec per degree at the Earth's velocity) is
//! left out. All values are f64; only the uniforms are narrowed.

use crate::catalog::{DataLayer, ImageWcs};
use crate::ephemeris::apparent::aberrated;
use crate::message::{Argument, reason};
use crate::scene::camera::{Camera, narrow, narrow_scalar, narrow2};
use crate::scene::decision::Decision;
use glam::{DMat2, DMat3, DVec2, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// Length of an image's longer side in the frame, pixels, up to which the image is not drawn.
const MIN_SIZE_PX: f64 = 0.5;
/// Step in the tangent plane, radians, of the finite differences that give the plane's axes under aberration: small against the angles over which aberration
/// varies, large against rounding.
const STEP_RAD: f64 = 1e-4;

/// Uniforms of an image on the sky.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyImageDraw {
    /// The name under which the texture is looked up.
    pub image: String,
    /// The homogeneous image coordinates (u = x / z, v = y / z) of the frame's middle, and their change to the frame's right and to its upper edge.
    pub middle: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    /// Width and height of the image in pixels of the frame.
    pub span_px: Vec2,
    /// Mip level.
    pub map_level: f32,
    pub opacity: f32,
}

/// The matrix from a direction (ICRF) to homogeneous image coordinates h, (u, v) = h.xy / h.z: u to the right, v down, 0 to 1. `size`: of the image in texels.
/// `velocity_km_s`: that of the viewer, for the aberration. `None` for an image that is not of the sky.
fn image_from_icrf(wcs: &ImageWcs, size: DVec2, velocity_km_s: DVec3) -> Option<DMat3> {
    let ImageWcs::Tangent { centre_deg, centre_px, deg_per_px } = wcs else { return None };
    let [(sin_ra, cos_ra), (sin_dec, cos_dec)] = centre_deg.map(|v| v.to_radians().sin_cos());
    let to_centre = DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec);
    let east = DVec3::new(-sin_ra, cos_ra, 0.0);
    let north = to_centre.cross(east);
    // The plane's axes under aberration, as finite differences of apparent directions.
    let apparent_centre = aberrated(to_centre, velocity_km_s);
    let apparent_axis = |axis: DVec3| {
        let step = aberrated((to_centre + STEP_RAD * axis).normalize(), velocity_km_s);
        (step / step.dot(apparent_centre) - apparent_centre) / STEP_RAD
    };
    let icrf_from_plane = DMat3::from_cols(apparent_axis(east), apparent_axis(north), apparent_centre);
    let [[east_by_x, east_by_y], [north_by_x, north_by_y]] = *deg_per_px;
    let deg_from_px = DMat2::from_cols(DVec2::new(east_by_x, north_by_x), DVec2::new(east_by_y, north_by_y));
    let px_per_radian = deg_from_px.inverse() * 1_f64.to_degrees();
    // In FITS the centre of the first pixel has the coordinate 1, and rows run upwards; in the image rows run downwards.
    let in_image_coordinates = |px: DVec2| DVec2::new(px.x / size.x, -px.y / size.y);
    let (x, y) = (in_image_coordinates(px_per_radian.x_axis), in_image_coordinates(px_per_radian.y_axis));
    let tangent_point = DVec2::new((centre_px[0] - 0.5) / size.x, 1.0 - (centre_px[1] - 0.5) / size.y);
    let image_from_plane = DMat3::from_cols(x.extend(0.0), y.extend(0.0), tangent_point.extend(1.0));
    Some(image_from_plane * icrf_from_plane.inverse())
}

/// The images in the frame with the decisions about them; images of earlier layers are behind those of later layers.
pub(crate) fn images(layers: &[Arc<DataLayer>], camera: &Camera, velocity_km_s: DVec3) -> (Vec<SkyImageDraw>, Vec<Decision>) {
    let (mut draws, mut decisions) = (Vec::new(), Vec::new());
    for (layer, image) in layers.iter().filter_map(|l| Some((l, l.image.as_ref()?))) {
        let size = DVec2::new(f64::from(image.width), f64::from(image.height));
        let Some(from_icrf) = image_from_icrf(&image.wcs, size, velocity_km_s) else { continue };
        // The direction of the centre of the sky image, and its size in pixels of the frame, from the size of a texel at the centre.
        let image_centre = from_icrf.inverse() * DVec3::new(0.5, 0.5, 1.0);
        let distance_px = |step: DVec2| {
            let direction = from_icrf.inverse() * (DVec2::splat(0.5) + step).extend(1.0);
            direction.normalize().distance(image_centre.normalize()) / camera.pixel_tangent()
        };
        let texel = DVec2::ONE / size;
        let span_px = DVec2::new(distance_px(DVec2::X * texel) * size.x, distance_px(DVec2::Y * texel) * size.y);
        // The image is tested as a sphere whose centre is 1 km away. One of 2 km radius contains the camera, so it is in the frame whatever its direction.
        let (radius_km, margin_px) = ((0.5 * span_px.length() * camera.pixel_tangent()).min(2.0), 1.0);
        let is_in_frame = camera.sphere_may_be_in_frame(camera.in_axes(image_centre.normalize()), radius_km, margin_px);
        let on = is_in_frame && span_px.max_element() > MIN_SIZE_PX;
        let [width, height] = [span_px.x, span_px.y].map(|px| Argument::Number(format!("{px:.1}")));
        let name = &layer.name;
        let reason = if is_in_frame {
            reason!("image-size", image = name, width = width, height = height)
        } else {
            reason!("image-outside", image = name, width = width, height = height)
        };
        decisions.push(Decision { effect: "data", on, reason, stated_error: None });
        if on {
            draws.push(SkyImageDraw {
                image: layer.image_name(),
                middle: narrow(from_icrf * camera.forward),
                right: narrow(from_icrf * (camera.right * camera.tan_half_fov.x)),
                up: narrow(from_icrf * (camera.up * camera.tan_half_fov.y)),
                span_px: narrow2(span_px),
                map_level: narrow_scalar((size / span_px).max_element().log2().max(0.0)),
                opacity: narrow_scalar(layer.style.opacity),
            });
        }
    }
    (draws, decisions)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the textbook formula of the gnomonic projection (Calabretta & Greisen 2002, section 5.1.3), with a matrix that rotates and stretches. The
    /// FITS coordinates (1, 1) are half a pixel from the left and the lower edge.
    #[test]
    fn positions_in_the_image_follow_the_standard() {
        let (ra0, dec0) = (83.633_f64, 22.0145_f64);
        let cd = [[-2e-4, 5e-5], [3e-5, 2.5e-4]];
        let wcs = ImageWcs::Tangent { centre_deg: [ra0, dec0], centre_px: [310.5, 120.25], deg_per_px: cd };
        let size = DVec2::new(640.0, 480.0);
        let from_icrf = image_from_icrf(&wcs, size, DVec3::ZERO).expect("of the sky");
        for (ra, dec) in [(83.633, 22.0145), (83.6, 22.05), (83.75, 21.96)] {
            let (da, d, d0) = ((ra - ra0).to_radians(), f64::to_radians(dec), dec0.to_radians());
            let cos_c = d0.sin() * d.sin() + d0.cos() * d.cos() * da.cos();
            let x = (d.cos() * da.sin() / cos_c).to_degrees();
            let y = ((d0.cos() * d.sin() - d0.sin() * d.cos() * da.cos()) / cos_c).to_degrees();
            let det = cd[0][0] * cd[1][1] - cd[0][1] * cd[1][0];
            let px = [310.5 + (cd[1][1] * x - cd[0][1] * y) / det, 120.25 + (cd[0][0] * y - cd[1][0] * x) / det];
            let (sin_a, cos_a) = f64::to_radians(ra).sin_cos();
            let h = from_icrf * DVec3::new(d.cos() * cos_a, d.cos() * sin_a, d.sin());
            let found = DVec2::new(h.x, h.y) / h.z * size;
            assert!(
                h.z > 0.0 && (found.x - (px[0] - 0.5)).abs() < 1e-6 && (found.y - (480.0 - px[1] + 0.5)).abs() < 1e-6,
                "{ra}: {found} {px:?}"
            );
        }
        // For a moving viewer the tangent point (310.0 pixels from the left edge) appears where a star in its direction appears. A pixel is 0.7 arcsec wide.
        let velocity = DVec3::new(10.0, -25.0, 7.0);
        let moved = image_from_icrf(&wcs, size, velocity).expect("of the sky");
        let (sin_a, cos_a) = ra0.to_radians().sin_cos();
        let star = DVec3::new(dec0.to_radians().cos() * cos_a, dec0.to_radians().cos() * sin_a, dec0.to_radians().sin());
        let h = moved * aberrated(star, velocity);
        assert!((h.x / h.z * 640.0 - 310.0).abs() < 1e-6, "{}", h.x / h.z * 640.0);
        let unmoved = moved * star;
        assert!((unmoved.x / unmoved.z * 640.0 - 310.0).abs() > 5.0, "20 arcsec are more than five pixels");
    }
}
