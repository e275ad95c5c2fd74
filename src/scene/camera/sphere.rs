//! Fisheye and equirectangular images: the mapping between directions and pixels.
//!
//! In: directions in the image's axes (x right, y up, z forward) or ICRF. Out: pixels, and the solid angle of a pixel. Always: `SphereImage::direction`
//! and [`SphereImage::pixel`] are inverse to each other. The formulas are those of shaders/entry/fisheye.wesl and equirectangular.wesl.

use super::Camera;
use crate::message::{Argument, Message, message};
use crate::scene::request::composition::Projection;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The mapping of an image from directions to pixel coordinates, which are (0, 0) at the top left corner.
pub(crate) trait ImageProjection {
    /// The pixel of a direction (ICRF, of any length); `None` if the image cannot show it.
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2>;
    /// The direction (ICRF, a unit vector) that a pixel shows; `None` if it shows none.
    fn direction_of(&self, pixel: DVec2) -> Option<DVec3>;
    /// Width and height, pixels.
    fn size_px(&self) -> DVec2;
    /// Radius in pixels that a disc of this angular radius has in the image's middle.
    fn disc_radius_px(&self, angular_radius_rad: f64) -> f64;
    /// Pixels per radian in the image's middle.
    fn px_per_radian_in_middle(&self) -> f64 {
        const SMALL_RAD: f64 = 1e-6;
        self.disc_radius_px(SMALL_RAD) / SMALL_RAD
    }
    /// For a vector from the camera to a point (ICRF, km): the distance at which a length across the line of sight to the image's middle has as many pixels as
    /// at the point. In a perspective image this is the point's view depth; a fisheye or an equirectangular image shows equal angles by equal lengths.
    fn scale_distance_km(&self, to_point_km: DVec3) -> f64 {
        to_point_km.length()
    }
    /// The text for the field of view in an image's caption.
    fn field_of_view_text(&self) -> Message;
}

impl ImageProjection for Camera {
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        self.clip(direction).map(|clip| self.pixel_from_clip(clip))
    }
    fn direction_of(&self, pixel: DVec2) -> Option<DVec3> {
        Some(self.ray(self.clip_from_pixel(pixel)).normalize())
    }
    fn size_px(&self) -> DVec2 {
        self.half_size_px() * 2.0
    }
    fn disc_radius_px(&self, angular_radius_rad: f64) -> f64 {
        angular_radius_rad.tan() / self.pixel_tangent()
    }
    fn scale_distance_km(&self, to_point_km: DVec3) -> f64 {
        to_point_km.dot(self.forward)
    }
    fn field_of_view_text(&self) -> Message {
        let deg = 2.0 * self.tan_half_fov.y.atan().to_degrees();
        let arcsec = 3600.0 * deg;
        // An angle that would round to 60 minutes or seconds is given in the next larger unit. An angle of less than an arcsecond has two significant digits.
        let angle = match deg {
            _ if deg >= 59.95 / 60.0 => format!("{deg:.1}°"),
            _ if arcsec >= 59.995 => format!("{:.1}'", 60.0 * deg),
            _ => format!("{arcsec:.places$}\"", places = (1.0 - arcsec.log10().floor()).clamp(2.0, 9.0) as usize),
        };
        message!("image-field-of-view", angle = Argument::Number(angle))
    }
}

/// A fisheye or equirectangular image.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereImage {
    /// Unit axes of the image, ICRF.
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    pub projection: Projection,
    /// For a fisheye: half the angle across its circle, radians. Not used by an equirectangular image.
    pub half_fov_rad: f64,
    /// Size of the image, pixels.
    pub width: u32,
    pub height: u32,
}

impl SphereImage {
    fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height))
    }

    fn is_fisheye(&self) -> bool {
        self.projection == Projection::Fisheye
    }

    /// Radians per pixel: along a fisheye's radius (both components), or along an equirectangular image's rows (x, at the equator) and columns (y).
    pub(crate) fn radians_per_pixel(&self) -> DVec2 {
        if self.is_fisheye() {
            DVec2::splat(2.0 * self.half_fov_rad / self.size().min_element())
        } else {
            DVec2::new(TAU, PI) / self.size()
        }
    }

    /// The direction in the image's axes that a pixel shows; `None` outside a fisheye's circle.
    pub(crate) fn direction(&self, pixel: DVec2) -> Option<DVec3> {
        let scale = self.radians_per_pixel();
        let from_middle = (pixel - 0.5 * self.size()) * scale * DVec2::new(1.0, -1.0);
        if self.is_fisheye() {
            let angle = from_middle.length();
            let radial = if angle > 0.0 { from_middle / angle } else { DVec2::ZERO };
            return (angle <= self.half_fov_rad).then(|| (radial * angle.sin()).extend(angle.cos()));
        }
        let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (from_middle.x.sin_cos(), from_middle.y.sin_cos());
        Some(DVec3::new(sin_lon * cos_lat, sin_lat, cos_lon * cos_lat))
    }

    /// The pixel of a direction in the image's axes; `None` outside a fisheye's circle.
    pub fn pixel(&self, direction: DVec3) -> Option<DVec2> {
        let off_axis = direction.truncate().length();
        let from_middle = if self.is_fisheye() {
            let angle = off_axis.atan2(direction.z);
            // The direction opposite to the axis is the entire edge of a fisheye of 360 degrees; one of its pixels is as good as any.
            let radial = if off_axis > 0.0 { direction.truncate() / off_axis } else { DVec2::Y };
            (angle <= self.half_fov_rad).then_some(radial * angle)?
        } else {
            DVec2::new(direction.x.atan2(direction.z), direction.y.atan2(direction.x.hypot(direction.z)))
        };
        Some(0.5 * self.size() + from_middle / self.radians_per_pixel() * DVec2::new(1.0, -1.0))
    }

    /// Distance in pixels of a position within a fisheye's circle from the circle; infinite in an equirectangular image, which has none.
    pub(crate) fn distance_from_circle_px(&self, pixel: DVec2) -> f64 {
        if !self.is_fisheye() {
            return f64::INFINITY;
        }
        0.5 * self.size().min_element() - (pixel - 0.5 * self.size()).length()
    }

    /// An ICRF vector in the image's axes.
    pub fn in_axes(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.forward))
    }

    /// For a direction in the image's axes: the solid angle of its pixel, and the image's horizontal stretch. The stretch is 1 in a fisheye; an equirectangular
    /// image stretches its rows near the poles. A lower bound keeps the solid angle positive at the poles and opposite to a fisheye's axis.
    pub fn pixel_sr_and_stretch(&self, direction: DVec3) -> (f64, f64) {
        let scale = self.radians_per_pixel();
        let off_axis = direction.truncate().length();
        if self.is_fisheye() {
            let angle = off_axis.atan2(direction.z);
            let sinc = if angle > 1e-6 { angle.sin() / angle } else { 1.0 };
            return (scale.element_product() * sinc.max(1e-3), 1.0);
        }
        let cos_lat = (direction.x.hypot(direction.z) / direction.length()).max(0.5 * scale.y);
        (scale.element_product() * cos_lat, scale.y / (scale.x * cos_lat))
    }

    /// Largest number of pixels per radian: for an equirectangular image at its equator, for a fisheye within 90 degrees of its axis. The true density is
    /// unbounded near the poles of an equirectangular image and near 180 degrees from the axis of a fisheye; both regions are ignored.
    pub(crate) fn densest_pixels_per_radian(&self) -> f64 {
        let density = 1.0 / self.radians_per_pixel().min_element();
        if !self.is_fisheye() {
            return density;
        }
        // At an angle from the axis, a fisheye has more pixels per radian along the circle around the axis than along the radius, by the factor
        // angle / sin(angle).
        let angle = self.half_fov_rad.min(FRAC_PI_2);
        density * angle / angle.sin()
    }
}

impl ImageProjection for SphereImage {
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        self.pixel(self.in_axes(direction))
    }
    fn direction_of(&self, pixel: DVec2) -> Option<DVec3> {
        // `v` is in the image's axes: right, up, forward.
        self.direction(pixel).map(|v| self.right * v.x + self.up * v.y + self.forward * v.z)
    }
    fn size_px(&self) -> DVec2 {
        self.size()
    }
    fn disc_radius_px(&self, angular_radius_rad: f64) -> f64 {
        angular_radius_rad / self.radians_per_pixel().y
    }
    fn field_of_view_text(&self) -> Message {
        let deg = 2.0 * self.half_fov_rad.to_degrees();
        if self.is_fisheye() { message!("image-fisheye", angle = format_args!("{deg:.0}°")) } else { message!("image-whole-sphere") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `fov_deg`: angle across a fisheye's circle; an equirectangular image does not use it.
    fn image(projection: Projection, fov_deg: f64, width: u32, height: u32) -> SphereImage {
        let half_fov_rad = fov_deg.to_radians() / 2.0;
        SphereImage { right: DVec3::X, up: DVec3::Y, forward: -DVec3::Z, projection, half_fov_rad, width, height }
    }

    /// For several images and fields of view: pixel to direction to pixel is the identity, and the pixels' solid angles sum to that of the cap or the
    /// sphere.
    #[test]
    fn pixels_and_directions_are_inverse_and_pixels_fill_the_sphere() {
        for (projection, fov_deg, width, height) in [
            (Projection::Fisheye, 180.0, 300, 300),
            (Projection::Fisheye, 360.0, 301, 400),
            (Projection::Fisheye, 30.0, 64, 50),
            (Projection::Equirectangular, 0.0, 400, 200),
            (Projection::Equirectangular, 0.0, 100, 301),
        ] {
            let image = image(projection, fov_deg, width, height);
            let mut solid_angle = 0.0;
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(direction) = image.direction(pixel) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-12);
                let back = image.pixel(direction * 3.0).expect("it is in the image");
                assert!((back - pixel).length() < 1e-7, "{projection:?} {pixel}: {back}");
                solid_angle += image.pixel_sr_and_stretch(direction).0;
            }
            let expected_sr = if projection == Projection::Fisheye { TAU * (1.0 - (fov_deg.to_radians() / 2.0).cos()) } else { 2.0 * TAU };
            // A pixel counts fully if its centre is in the circle: in an image 50 pixels high this is wrong by 0.6 % of the area, in larger images by
            // less.
            let bound = if width.min(height) < 100 { 1e-2 } else { 5e-3 };
            assert!((solid_angle / expected_sr - 1.0).abs() < bound, "{projection:?} {fov_deg}: {solid_angle} of {expected_sr}");
        }
    }

    /// The text for a field of view never rounds to 60 minutes, 60 seconds or zero.
    #[test]
    fn a_field_of_view_has_a_readable_text() {
        let texts = [
            (20.0, "20.0°"),
            (0.9995, "1.0°"),
            (0.5, "30.0'"),
            (59.999 / 3600.0, "1.0'"),
            (7.2 / 3600.0, "7.20\""),
            (0.25 / 3600.0, "0.25\""),
            (1e-6, "0.0036\""),
        ];
        for (fov_deg, expected) in texts {
            let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, fov_deg, 400, 300);
            let text = camera.field_of_view_text().text_in(crate::message::TextLanguage::English);
            assert!(text.contains(&format!(" {expected}")) || text.starts_with(expected), "{fov_deg}: {text}");
        }
    }

    /// The up axis is at the top of the image and the right axis on its right, as seen from inside the sphere.
    #[test]
    fn the_axes_are_those_of_the_camera() {
        let dome = image(Projection::Fisheye, 180.0, 200, 200);
        assert_eq!(dome.pixel(DVec3::Z), Some(DVec2::splat(100.0)));
        assert!((dome.pixel(DVec3::Y).expect("in") - DVec2::new(100.0, 0.0)).length() < 1e-9);
        assert!((dome.pixel(DVec3::X).expect("in") - DVec2::new(200.0, 100.0)).length() < 1e-9);
        assert_eq!(dome.pixel(DVec3::new(1.0, 0.0, -0.01)), None);
        let whole = image(Projection::Fisheye, 360.0, 200, 200);
        assert_eq!(whole.pixel(DVec3::Z), Some(DVec2::splat(100.0)));
        assert!((whole.pixel(-DVec3::Z).expect("in") - DVec2::new(100.0, 0.0)).length() < 1e-9, "opposite to the middle");
        let sphere = image(Projection::Equirectangular, 0.0, 400, 200);
        assert!((sphere.pixel(DVec3::X).expect("in") - DVec2::new(300.0, 100.0)).length() < 1e-9);
        assert!((sphere.pixel(DVec3::new(0.0, 1.0, 1.0)).expect("in") - DVec2::new(200.0, 50.0)).length() < 1e-9);
        assert_eq!(sphere.pixel_of(-DVec3::Z).expect("forward"), DVec2::new(200.0, 100.0));
    }
}
