//! How actions turn, zoom and re-orient the camera: about its body, on the spot, in another frame.
//!
//! In: motions of the mouse and positions of bodies. Out: the camera pose of the view. Always: the first motion starts in the direction that the
//! last image had.

use super::Viewer;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::request::Projection;
use crate::scene::request::composition::FISHEYE_RANGE_DEG;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::view_state::{
    CameraPose, MAX_FOV_DEG, MIN_FOV_DEG, body_fixed_orbit_pose, horizontal_angles_deg, inertial_orbit_pose,
};
use glam::DVec3;

/// Change of the logarithm of the field of view per wheel notch.
const LOG_FOV_PER_NOTCH: f64 = 0.15;

impl Viewer {
    pub(super) fn turn(&mut self, dx: f64, dy: f64, height_px: f64, places: &dyn BodyPositions) {
        self.end_flight();
        let fov_rad = self.view.fov_deg.to_radians();
        match &mut self.view.eye {
            CameraPose::Orbit { azimuth_deg, elevation_deg, distance_radii, .. } => {
                let mut orbit = OrbitCamera::from_degrees(*azimuth_deg, *elevation_deg, *distance_radii);
                orbit.drag(dx, dy, height_px, fov_rad);
                (*azimuth_deg, *elevation_deg) = (orbit.azimuth_rad.to_degrees(), orbit.elevation_rad.to_degrees());
            }
            _ => self.look_around(-dx, -dy, height_px, places),
        }
    }

    /// Turns the camera by a motion in pixels, right and down. A drag passes the negative motion, so that the image follows the mouse.
    pub(super) fn look_around(&mut self, dx: f64, dy: f64, height_px: f64, places: &dyn BodyPositions) {
        self.end_flight();
        self.keep_tracked_direction(places);
        let deg_per_px = self.view.image_fov_deg() / height_px.max(1.0);
        match &mut self.view.eye {
            CameraPose::Orbit { yaw_deg, pitch_deg, .. } => {
                *yaw_deg = (*yaw_deg + dx * deg_per_px + 180.0).rem_euclid(360.0) - 180.0;
                *pitch_deg = (*pitch_deg - dy * deg_per_px).clamp(-89.0, 89.0);
            }
            CameraPose::Ground { azimuth_deg, altitude_deg, body, .. } => {
                *azimuth_deg = (*azimuth_deg + dx * deg_per_px).rem_euclid(360.0);
                *altitude_deg = (*altitude_deg - dy * deg_per_px).clamp(-89.9, 89.9);
                // Looking around stops the tracking of another target. It remains the target, so that the exposure does not jump.
                self.view.tracks &= self.view.target == *body;
            }
            CameraPose::Centre { .. } | CameraPose::Free { .. } => {}
        }
    }

    pub(super) fn zoom(&mut self, notches: f64) {
        self.end_flight();
        match &mut self.view.eye {
            CameraPose::Orbit { distance_radii, azimuth_deg, elevation_deg, .. } => {
                let mut orbit = OrbitCamera::from_degrees(*azimuth_deg, *elevation_deg, *distance_radii);
                orbit.zoom(notches);
                *distance_radii = orbit.distance_radii;
            }
            _ => self.change_fov(notches),
        }
    }

    pub(super) fn change_fov(&mut self, notches: f64) {
        let (angle_deg, range_deg) = match self.view.composition.projection {
            Projection::Perspective => (&mut self.view.fov_deg, MIN_FOV_DEG..=MAX_FOV_DEG),
            Projection::Fisheye => (&mut self.view.composition.fisheye_deg, FISHEYE_RANGE_DEG),
            // An equirectangular image always shows the entire sphere.
            Projection::Equirectangular => return,
        };
        *angle_deg = (*angle_deg * (-notches * LOG_FOV_PER_NOTCH).exp()).clamp(*range_deg.start(), *range_deg.end());
    }

    pub(super) fn track(&mut self, on: bool, places: &dyn BodyPositions) {
        if !on {
            self.keep_tracked_direction(places);
        }
        self.view.tracks = on;
    }

    /// If a camera on the ground tracks another body, stores the direction to that body as its azimuth and altitude. Otherwise the camera would jump
    /// to the stored angles when the tracking ends, although no image has shown that direction. The stored direction is geometric, without the planetary
    /// aberration that an image includes: some 20 arcsec for the Sun, at most a minute of arc for a planet.
    fn keep_tracked_direction(&mut self, places: &dyn BodyPositions) {
        let CameraPose::Ground { body, latitude_deg, longitude_deg, height_km, .. } = self.view.eye else { return };
        if !self.view.tracks || self.view.target == body {
            return;
        }
        let Some(body_from_icrf) = places.body_from_icrf(body, self.view.time()) else { return };
        let Some(pose) = self.pose_from(body, places) else { return };
        let radii_km = self.subject(body).map_or(DVec3::ONE, |s| s.radii_km);
        let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
        let tracked_deg = horizontal_angles_deg(normal, body_from_icrf * pose.forward);
        if let CameraPose::Ground { azimuth_deg, altitude_deg, .. } = &mut self.view.eye {
            (*azimuth_deg, *altitude_deg) = tracked_deg;
        }
        // While the camera tracks a body, its up direction is the zenith, without the roll.
        self.view.roll_deg = 0.0;
    }

    pub(super) fn rotate_with_body(&mut self, make_fixed: bool, places: &dyn BodyPositions) {
        self.end_flight();
        let CameraPose::Orbit { body, fixed, yaw_deg: old_yaw_deg, pitch_deg: old_pitch_deg, .. } = self.view.eye else { return };
        let Some(pose) = self.pose_from(body, places).filter(|_| fixed != make_fixed) else { return };
        let Some(body_from_icrf) = places.body_from_icrf(body, self.view.time()) else { return };
        let radius_km = self.radius_km(body);
        self.view.eye = if make_fixed {
            body_fixed_orbit_pose(body, OrbitCamera::from_offset(body_from_icrf * pose.offset_km, radius_km, DVec3::Z))
        } else {
            inertial_orbit_pose(body, OrbitCamera::from_offset(pose.offset_km, radius_km, body_from_icrf.row(2)))
        };
        // Both poses measure these two angles from the direction to the body and its pole.
        if let CameraPose::Orbit { yaw_deg, pitch_deg, .. } = &mut self.view.eye {
            (*yaw_deg, *pitch_deg) = (old_yaw_deg, old_pitch_deg);
        }
    }

    pub(super) fn face_selected(&mut self) {
        self.end_flight();
        self.view.roll_deg = 0.0;
        self.view.tracks = true;
        if let CameraPose::Orbit { body, yaw_deg, pitch_deg, .. } = &mut self.view.eye {
            (*yaw_deg, *pitch_deg) = (0.0, 0.0);
            self.view.target = *body;
        }
    }
}
