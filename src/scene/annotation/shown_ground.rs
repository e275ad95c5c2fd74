//! The point of a body's ground to which an image's scale bar applies.
//!
//! In: the image and the body's placement. Out: the vector from the camera to the point. Always: the point is on the reference ellipsoid, also if a shape model
//! is drawn, and in the image. Bodies in front of it are not considered.

use crate::scene::camera::Placement;
use crate::scene::camera::sphere::ImageProjection;
use glam::{DVec2, DVec3};

/// Distance between the places of the image's middle column at which the ground is sought, pixels. It is less than half the smallest disc with a scale bar of
/// lengths.
const ROW_STEP_PX: f64 = 4.0;

/// The point of a body's ground in the image's middle. If the middle shows none: the nearest to the camera that the middle column shows; if this shows none,
/// either: the one towards the body's centre, if that is in the image. ICRF, km from the camera; `None` if the image shows none of these, or if the camera is
/// inside the body.
pub(super) fn shown_ground_km(image: &impl ImageProjection, placement: &Placement) -> Option<DVec3> {
    let size = image.size_px();
    let middle = 0.5 * size;
    let ground_at = |pixel: DVec2| placement.ground_along(image.direction_of(pixel)?);
    let nearest_in_column = || {
        let steps = (size.y / ROW_STEP_PX).ceil().max(1.0);
        let points = (0..=steps as u32).filter_map(|k| ground_at(DVec2::new(middle.x, size.y * f64::from(k) / steps)));
        points.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    };
    let towards_centre = || {
        let pixel = image.pixel_of(placement.centre_km)?;
        let is_in_image = pixel.cmpge(DVec2::ZERO).all() && pixel.cmple(size).all();
        placement.ground_along(placement.centre_km).filter(|_| is_in_image)
    };
    ground_at(middle).or_else(nearest_in_column).or_else(towards_centre)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use glam::DMat3;

    /// A sphere of radius 100 km in this direction from the camera, at this distance of its centre.
    fn sphere(direction: DVec3, distance_km: f64) -> Placement {
        Placement { centre_km: direction.normalize() * distance_km, body_from_icrf: DMat3::IDENTITY, radii_km: DVec3::splat(100.0) }
    }

    /// A camera that looks along x, with z up: 40 degrees of height, 60 degrees of width.
    fn camera() -> Camera {
        Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 40.0, 317, 200)
    }

    #[test]
    fn the_middle_comes_first_then_the_middle_column_then_the_centre() {
        // In the middle: on the line of sight, also if a lower row shows nearer ground.
        let below_middle = sphere(DVec3::new(1.0, 0.0, -0.05), 130.0);
        let ground = shown_ground_km(&camera(), &below_middle).expect("ground");
        assert!(ground.truncate().y.abs() < 1e-9 && ground.z.abs() < 1e-9, "{ground}");
        // Standing 2 m above the ground, with the horizon below the middle: the lowest row shows the nearest ground, 20 degrees below the horizontal plane.
        let underfoot = sphere(-DVec3::Z, 100.002);
        let looking_up = Camera::looking(DVec3::ZERO, DVec3::new(1.0, 0.0, 0.1), DVec3::Z, 40.0, 317, 200);
        let ground = shown_ground_km(&looking_up, &underfoot).expect("ground");
        let depression = 20.0_f64.to_radians() - 0.1_f64.atan();
        assert!((ground.length() * depression.sin() / 0.002 - 1.0).abs() < 0.01, "{ground}");
        // Beside the middle column.
        let beside = sphere(DVec3::new(1.0, 0.3, 0.1), 1000.0);
        let ground = shown_ground_km(&camera(), &beside).expect("ground");
        assert!((ground.length() - 900.0).abs() < 1e-6 && ground.normalize().dot(beside.centre_km.normalize()) > 1.0 - 1e-9, "{ground}");
        // Outside the image, behind the camera, and around it.
        for unseen in [sphere(DVec3::new(1.0, 1.0, 0.0), 1000.0), sphere(-DVec3::X, 1000.0), sphere(DVec3::X, 50.0)] {
            assert_eq!(shown_ground_km(&camera(), &unseen), None, "{unseen:?}");
        }
    }
}
