//! Where a finished picture shows directions: a plane, a fisheye or whole sphere, or two eyes.
//!
//! In: ICRF directions, pixels of the finished picture. Out: each from the other. Always: `ImageGeometry::direction` and [`ImageGeometry::place_px`] are inverse to
//! each other within the picture; of a stereo pair both are those of a camera between the eyes, so that a body in front of the target or behind it is off by half its
//! parallax. Not here: a warp mesh, which moves the finished picture.

use super::Camera;
use super::sphere::{PicturePlaces, SpherePicture};
use glam::{DVec2, DVec3};

/// How a finished picture shows directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ImageGeometry {
    /// As the scene's camera.
    #[default]
    Perspective,
    /// A fisheye or an equirectangular picture.
    Sphere(SpherePicture),
    /// A stereo pair.
    Stereo {
        /// The camera between the eyes; as wide as one eye's picture.
        between: Box<Camera>,
        /// Each eye has half of the picture.
        side_by_side: bool,
    },
}

impl ImageGeometry {
    /// As labels and marks ask for it.
    pub(crate) fn places<'a>(&'a self, camera: &'a Camera) -> &'a dyn PicturePlaces {
        match self {
            Self::Perspective => camera,
            Self::Sphere(picture) => picture,
            Self::Stereo { between, .. } => &**between,
        }
    }

    /// The pixel that shows an ICRF direction; of a side-by-side pair the one in the left picture.
    pub fn place_px(&self, camera: &Camera, direction: DVec3) -> Option<DVec2> {
        self.places(camera).place_px(direction)
    }

    /// The ICRF direction that a pixel shows, a unit vector; `None` outside a fisheye's circle.
    pub(crate) fn direction(&self, camera: &Camera, pixel: DVec2) -> Option<DVec3> {
        let of_camera = |camera: &Camera, pixel: DVec2| Some(camera.ray(camera.clip_from_pixel(pixel)).normalize());
        match self {
            Self::Perspective => of_camera(camera, pixel),
            Self::Sphere(picture) => picture.direction(pixel).map(|v| picture.right * v.x + picture.up * v.y + picture.forward * v.z),
            Self::Stereo { between, .. } => of_camera(between, self.one_eye_px(pixel)),
        }
    }

    /// A pixel of the right picture of a side-by-side pair, where the left one has it; any other pixel itself.
    pub(crate) fn one_eye_px(&self, pixel: DVec2) -> DVec2 {
        match self {
            Self::Stereo { between, side_by_side: true } if pixel.x >= f64::from(between.width) => {
                pixel - DVec2::new(f64::from(between.width), 0.0)
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
    fn a_pixel_and_its_direction_are_each_others() {
        let whole = camera(90, 60);
        let sphere = |projection| {
            let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
            ImageGeometry::Sphere(SpherePicture { right, up, forward, projection, half_fov_rad: 1.5, width: 90, height: 60 })
        };
        let pair = |side_by_side| ImageGeometry::Stereo { between: Box::new(camera(45, 60)), side_by_side };
        for geometry in
            [ImageGeometry::Perspective, sphere(Projection::Fisheye), sphere(Projection::Equirectangular), pair(true), pair(false)]
        {
            let mut seen = 0;
            for (x, y) in (0..90).flat_map(|x| (0..60).map(move |y| (x, y))) {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(direction) = geometry.direction(&whole, pixel) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-12);
                let back = geometry.place_px(&whole, direction).expect("in the picture");
                assert!(back.distance(geometry.one_eye_px(pixel)) < 1e-7, "{geometry:?} {pixel}: {back}");
                seen += 1;
            }
            assert!(seen > 2500, "{geometry:?}: {seen}");
        }
    }

    #[test]
    fn both_halves_of_a_pair_show_the_same_place_and_a_circle_has_an_outside() {
        let pair = ImageGeometry::Stereo { between: Box::new(camera(45, 60)), side_by_side: true };
        let left = DVec2::new(10.0, 20.0);
        let right = left + DVec2::new(45.0, 0.0);
        assert_eq!((pair.one_eye_px(right), pair.one_eye_px(left)), (left, left));
        assert_eq!(pair.direction(&camera(90, 60), right), pair.direction(&camera(90, 60), left));
        let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
        let dome = SpherePicture { right, up, forward, projection: Projection::Fisheye, half_fov_rad: 1.5, width: 90, height: 60 };
        assert_eq!(ImageGeometry::Sphere(dome).direction(&camera(90, 60), DVec2::ONE), None);
    }
}
