//! Where a finished picture shows directions: a plane, a fisheye or whole sphere, or two eyes.
//!
//! In: ICRF directions, pixels of the finished picture. Out: the pixel of a direction, and the direction of a pixel. Always: `ImageGeometry::direction` and [`ImageGeometry::pixel_of`] are inverse to
//! each other within the picture; of a stereo pair both are those of the left eye's picture. Not here: a warp mesh, which moves the finished picture.

use super::Camera;
use super::sphere::{ImageProjection, SpherePicture};
use glam::{DVec2, DVec3};

/// How a finished picture shows directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ImageGeometry {
    /// As the scene's camera.
    #[default]
    Perspective,
    /// A fisheye or an equirectangular picture.
    Sphere(SpherePicture),
    /// A stereo pair, whose scene is the left eye's.
    Stereo(StereoGeometry),
}

/// The columns of the left eye's rendered frame that the finished picture keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoGeometry {
    /// The first of them.
    pub left_column: u32,
    /// Width of one eye's part of the finished picture, pixels.
    pub width: u32,
    /// Whether the eyes' pictures stand side by side; else they are overlaid.
    pub side_by_side: bool,
}

/// The picture that is cut out of the left eye's frame.
struct LeftPicture<'a> {
    camera: &'a Camera,
    geometry: StereoGeometry,
}

impl LeftPicture<'_> {
    fn column(&self) -> DVec2 {
        DVec2::new(f64::from(self.geometry.left_column), 0.0)
    }
}

impl ImageProjection for LeftPicture<'_> {
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        self.camera.pixel_of(direction).map(|px| px - self.column())
    }
    fn size_px(&self) -> DVec2 {
        DVec2::new(f64::from(self.geometry.width), f64::from(self.camera.height))
    }
    fn disc_radius_px(&self, angular_radius: f64) -> f64 {
        self.camera.disc_radius_px(angular_radius)
    }
    fn field_of_view(&self) -> String {
        self.camera.field_of_view()
    }
}

impl ImageGeometry {
    /// The projection by which labels and marks are placed.
    pub(crate) fn projection<'a>(&'a self, camera: &'a Camera) -> Box<dyn ImageProjection + 'a> {
        match self {
            Self::Perspective => Box::new(camera.clone()),
            Self::Sphere(picture) => Box::new(picture.clone()),
            Self::Stereo(geometry) => Box::new(LeftPicture { camera, geometry: *geometry }),
        }
    }

    /// The pixel that shows an ICRF direction; of a side-by-side pair the one in the left half.
    pub fn pixel_of(&self, camera: &Camera, direction: DVec3) -> Option<DVec2> {
        self.projection(camera).pixel_of(direction)
    }

    /// The ICRF direction that a pixel shows, a unit vector; `None` outside a fisheye's circle.
    pub(crate) fn direction(&self, camera: &Camera, pixel: DVec2) -> Option<DVec3> {
        let of_camera = |pixel: DVec2| Some(camera.ray(camera.clip_from_pixel(pixel)).normalize());
        match self {
            Self::Perspective => of_camera(pixel),
            Self::Sphere(picture) => picture.direction(pixel).map(|v| picture.right * v.x + picture.up * v.y + picture.forward * v.z),
            Self::Stereo(geometry) => of_camera(self.left_eye_px(pixel) + LeftPicture { camera, geometry: *geometry }.column()),
        }
    }

    /// Where a sprite at this place of the scene's frame (clip coordinates) is in the finished picture.
    pub(crate) fn sprite_px(&self, camera: &Camera, clip: DVec2) -> DVec2 {
        let px = camera.pixel_from_clip(clip);
        match self {
            // The sprites of a dome or a whole sphere are placed in the finished picture.
            Self::Perspective | Self::Sphere(_) => px,
            Self::Stereo(geometry) => px - LeftPicture { camera, geometry: *geometry }.column(),
        }
    }

    /// A pixel in the right half of a side-by-side pair moves to the same place of the left half; any other pixel stays.
    pub(crate) fn left_eye_px(&self, pixel: DVec2) -> DVec2 {
        match self {
            Self::Stereo(StereoGeometry { width, side_by_side: true, .. }) if pixel.x >= f64::from(*width) => {
                pixel - DVec2::new(f64::from(*width), 0.0)
            }
            _ => pixel,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::request::composition::Projection;

    fn camera(width: u32, height: u32) -> Camera {
        Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, width, height)
    }

    #[test]
    fn direction_and_pixel_are_inverse() {
        let whole = camera(90, 60);
        let sphere = |projection| {
            let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
            ImageGeometry::Sphere(SpherePicture { right, up, forward, projection, half_fov_rad: 1.5, width: 90, height: 60 })
        };
        // A frame of 90 pixels, whose right half is the left eye's picture.
        let pair = |side_by_side| ImageGeometry::Stereo(StereoGeometry { left_column: 45, width: 45, side_by_side });
        for geometry in
            [ImageGeometry::Perspective, sphere(Projection::Fisheye), sphere(Projection::Equirectangular), pair(true), pair(false)]
        {
            let mut seen = 0;
            for (x, y) in (0..90).flat_map(|x| (0..60).map(move |y| (x, y))) {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(direction) = geometry.direction(&whole, pixel) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-12);
                let back = geometry.pixel_of(&whole, direction).expect("in the picture");
                assert!(back.distance(geometry.left_eye_px(pixel)) < 1e-7, "{geometry:?} {pixel}: {back}");
                seen += 1;
            }
            assert!(seen > 2500, "{geometry:?}: {seen}");
        }
    }

    #[test]
    fn both_halves_of_a_pair_show_one_direction_and_pixels_outside_a_fisheye_show_none() {
        let pair = ImageGeometry::Stereo(StereoGeometry { left_column: 45, width: 45, side_by_side: true });
        let left = DVec2::new(10.0, 20.0);
        let right = left + DVec2::new(45.0, 0.0);
        assert_eq!((pair.left_eye_px(right), pair.left_eye_px(left)), (left, left));
        assert_eq!(pair.direction(&camera(90, 60), right), pair.direction(&camera(90, 60), left));
        let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
        let dome = SpherePicture { right, up, forward, projection: Projection::Fisheye, half_fov_rad: 1.5, width: 90, height: 60 };
        assert_eq!(ImageGeometry::Sphere(dome).direction(&camera(90, 60), DVec2::ONE), None);
    }
}
