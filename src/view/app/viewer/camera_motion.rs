//! How actions move the camera: they turn it about its body or on the spot, zoom, or change the frame in which it orbits.
//!
//! In: motions of the mouse and positions of bodies. Out: the camera pose of the view. Always: a motion starts in the direction of the
//! last image, also after a tour, or if the camera tracked a body until then.

use super::Viewer;
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::{ground_point_km, place_of_normal_deg};
use crate::scene::request::Projection;
use crate::scene::request::composition::FISHEYE_RANGE_DEG;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::view_state::{
    CameraPose, MAX_FOV_DEG, MIN_FOV_DEG, body_fixed_orbit_pose, horizontal_angles_deg, inertial_orbit_pose, rotated_view,
    view_at_azimuth_altitude,
};
use glam::{DMat3, DQuat, DVec3};

/// Change of the natural logarithm of the field of view per wheel notch: about 15 %, close to the change of an orbit's height.
const LOG_FOV_PER_NOTCH: f64 = 0.15;
/// Largest pitch, up or down, to which a motion turns a camera in an orbit.
const MAX_PITCH_DEG: f64 = 89.0;
/// Largest altitude, above or below the horizon, to which a motion turns a camera on the ground.
const MAX_ALTITUDE_DEG: f64 = 89.9;
/// Number of steps of the iteration in [`GroundPlace::of`].
const GROUND_PLACE_STEPS: u32 = 30;

impl Viewer {
    /// Turns the camera about its body by a drag of `dx_px` to the right and `dy_px` down. A camera that does not orbit looks around instead.
    pub(super) fn turn(&mut self, dx_px: f64, dy_px: f64, image_height_px: f64, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        let fov_rad = self.view.image_fov_deg().to_radians();
        let [right_px, down_px] = self.in_level_image(dx_px, dy_px);
        match &mut self.view.camera_pose {
            CameraPose::Orbit { azimuth_deg, elevation_deg, distance_radii, .. } => {
                let mut orbit = OrbitCamera::from_degrees(*azimuth_deg, *elevation_deg, *distance_radii);
                orbit.drag(right_px, down_px, image_height_px, fov_rad);
                (*azimuth_deg, *elevation_deg) = (orbit.azimuth_rad.to_degrees(), orbit.elevation_rad.to_degrees());
            }
            _ => self.look_around(-dx_px, -dy_px, image_height_px, positions),
        }
    }

    /// Turns the camera on the spot by a motion of `dx_px` to the right and `dy_px` down. A drag passes the negative motion, so that the image follows the
    /// mouse.
    pub(super) fn look_around(&mut self, dx_px: f64, dy_px: f64, image_height_px: f64, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        if !self.can_turn() || matches!(self.view.camera_pose, CameraPose::Free { .. }) {
            return;
        }
        self.keep_tracked_direction(positions);
        let deg_per_px = self.view.image_fov_deg() / image_height_px.max(1.0);
        // Looking around stops the tracking of another target. It remains the target, so that the exposure does not jump.
        self.view.tracks &= self.view.target == self.view.camera_pose.body();
        let [right_px, down_px] = self.in_level_image(dx_px, dy_px);
        match &mut self.view.camera_pose {
            CameraPose::Orbit { yaw_deg, pitch_deg, .. } => {
                *yaw_deg = (*yaw_deg + right_px * deg_per_px + 180.0).rem_euclid(360.0) - 180.0;
                *pitch_deg = (*pitch_deg - down_px * deg_per_px).clamp(-MAX_PITCH_DEG, MAX_PITCH_DEG);
            }
            CameraPose::Ground { azimuth_deg, altitude_deg, .. } => {
                *azimuth_deg = (*azimuth_deg + right_px * deg_per_px).rem_euclid(360.0);
                *altitude_deg = (*altitude_deg - down_px * deg_per_px).clamp(-MAX_ALTITUDE_DEG, MAX_ALTITUDE_DEG);
            }
            CameraPose::Centre { .. } | CameraPose::Free { .. } => {}
        }
    }

    /// A motion of the pointer, to the right and down, in the image without mirroring and roll: a drag moves the image with the pointer however the image is
    /// turned. While the camera follows another body, only the mirroring counts, because the roll is then not measured from the axis of the orbit.
    fn in_level_image(&self, dx_px: f64, dy_px: f64) -> [f64; 2] {
        let dx_px = if self.view.is_mirrored { -dx_px } else { dx_px };
        let composition = &self.view.composition;
        let is_level = composition.projection == Projection::Fisheye && composition.is_zenith_centred;
        let tracks_other_body = self.view.tracks && self.view.target != self.view.camera_pose.body();
        if is_level || tracks_other_body {
            return [dx_px, dy_px];
        }
        // A positive roll turns the image clockwise.
        let (sin, cos) = self.view.roll_deg.to_radians().sin_cos();
        [dx_px * cos + dy_px * sin, dy_px * cos - dx_px * sin]
    }

    /// Whether a drag turns the camera: at the centre of a body it always faces the target.
    pub(crate) fn can_turn(&self) -> bool {
        !matches!(self.view.camera_pose, CameraPose::Centre { .. })
    }

    /// Rolls the camera; positive turns the shown image clockwise.
    pub(super) fn roll(&mut self, deg: f64, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        // The roll is that of the image before it is mirrored.
        let deg = if self.view.is_mirrored { -deg } else { deg };
        self.view.roll_deg = (self.view.roll_deg + deg).rem_euclid(360.0);
    }

    /// Zooms by wheel notches, positive inwards: changes the height of an orbit, or the field of view of any other camera.
    pub(super) fn zoom(&mut self, notches: f64, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        match &mut self.view.camera_pose {
            CameraPose::Orbit { distance_radii, azimuth_deg, elevation_deg, .. } => {
                let mut orbit = OrbitCamera::from_degrees(*azimuth_deg, *elevation_deg, *distance_radii);
                orbit.zoom(notches);
                *distance_radii = orbit.distance_radii;
            }
            _ => self.change_fov(notches),
        }
    }

    /// Changes the angle that the image spans by wheel notches; positive narrows it.
    pub(super) fn change_fov(&mut self, notches: f64) {
        let (angle_deg, range_deg) = match self.view.composition.projection {
            Projection::Perspective => (&mut self.view.fov_deg, MIN_FOV_DEG..=MAX_FOV_DEG),
            Projection::Fisheye => (&mut self.view.composition.fisheye_deg, FISHEYE_RANGE_DEG),
            // An equirectangular image always shows the entire sphere.
            Projection::Equirectangular => return,
        };
        *angle_deg = (*angle_deg * (-notches * LOG_FOV_PER_NOTCH).exp()).clamp(*range_deg.start(), *range_deg.end());
    }

    /// Starts or stops tracking the target. When tracking stops, the camera keeps its direction.
    pub(super) fn track(&mut self, tracks: bool, positions: &dyn BodyPositions) {
        self.leave_free_pose(positions);
        if tracks {
            self.keep_up_direction(positions);
        } else {
            self.keep_tracked_direction(positions);
        }
        self.view.tracks = tracks;
    }

    /// Makes the camera face and track a body from the camera's current position. Does nothing if the camera is at the centre of this body.
    ///
    /// In an orbit, the roll is measured from the pole of the orbited body while the camera faces this body, and from celestial north while it tracks another
    /// one. If the camera is rolled and this changes, or if it had turned away, the up direction of the image turns with the line of sight, by the shortest way.
    /// A level camera stays level.
    pub(super) fn look_at(&mut self, id: NaifId, positions: &dyn BodyPositions) {
        if self.view.camera_pose == (CameraPose::Centre { body: id }) {
            return;
        }
        self.push_history();
        self.leave_free_pose(positions);
        let camera_body = self.view.camera_pose.body();
        let is_orbit = matches!(self.view.camera_pose, CameraPose::Orbit { .. });
        let changes_reference = (self.view.tracks && self.view.target != camera_body) != (id != camera_body);
        let keeps_up = is_orbit && (self.has_turned_away() || (self.view.roll_deg != 0.0 && changes_reference));
        let pose_before = if keeps_up { self.pose_relative_to(camera_body, positions) } else { None };
        (self.view.target, self.view.tracks) = (id, true);
        if let CameraPose::Orbit { body, yaw_deg, pitch_deg, .. } = &mut self.view.camera_pose
            && *body == id
        {
            (*yaw_deg, *pitch_deg) = (0.0, 0.0);
        }
        let Some(before) = pose_before else { return };
        let rolled_deg = std::mem::take(&mut self.view.roll_deg);
        self.view.roll_deg = self.pose_relative_to(camera_body, positions).map_or(rolled_deg, |level| {
            let up = DQuat::from_rotation_arc(before.forward, level.forward) * before.up;
            roll_deg(level.forward, level.up, up)
        });
    }

    /// Whether the camera is in an orbit and faces neither the orbited body nor a target: its direction is given by yaw and pitch.
    fn has_turned_away(&self) -> bool {
        matches!(self.view.camera_pose, CameraPose::Orbit { .. }) && self.view.target != self.view.camera_pose.body() && !self.view.tracks
    }

    /// Before a camera in an orbit that has turned away from the body faces a target again: keeps the up direction of the image. Until then the roll is
    /// measured from the body's pole, and [`Self::keep_tracked_direction`] may have put the angle between pole and celestial north into it.
    fn keep_up_direction(&mut self, positions: &dyn BodyPositions) {
        let body = self.view.camera_pose.body();
        if !self.has_turned_away() {
            return;
        }
        let Some(pose) = self.pose_relative_to(body, positions) else { return };
        let (_, level_up) = rotated_view(pose.forward, DVec3::Z, 0.0, 0.0);
        self.view.roll_deg = roll_deg(pose.forward, level_up, pose.up);
    }

    /// If the camera tracks a body other than the one that it stands on or orbits, stores the direction to that body in the angles of its pose. Without
    /// this, when the tracking ends, the camera would jump to the angles stored before, which no image has shown. The stored direction is geometric: it lacks
    /// the planetary aberration that an image includes, which from the Earth is some 20 arcsec for the Sun and at most an arcminute for a planet.
    fn keep_tracked_direction(&mut self, positions: &dyn BodyPositions) {
        let body = self.view.camera_pose.body();
        if !self.view.tracks || self.view.target == body {
            return;
        }
        let Some(body_from_icrf) = positions.body_from_icrf(body, self.view.time()) else { return };
        let Some(pose) = self.pose_relative_to(body, positions) else { return };
        let radii_km = self.selectable_body(body).map_or(DVec3::ONE, |s| s.radii_km);
        match &mut self.view.camera_pose {
            CameraPose::Ground { latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg, .. } => {
                let (_, normal) = ground_point_km(radii_km, *latitude_deg, *longitude_deg, *height_km);
                // The roll stays: with and without tracking it is measured from the zenith.
                (*azimuth_deg, *altitude_deg) = horizontal_angles_deg(normal, body_from_icrf * pose.forward);
            }
            CameraPose::Orbit { is_body_fixed, azimuth_deg, elevation_deg, distance_radii, yaw_deg, pitch_deg, .. } => {
                let orbit = OrbitCamera::from_degrees(*azimuth_deg, *elevation_deg, *distance_radii);
                let (axes_from_icrf, pole) =
                    if *is_body_fixed { (body_from_icrf, DVec3::Z) } else { (DMat3::IDENTITY, body_from_icrf.row(2)) };
                // Only the direction of the offset is used, which does not depend on the radius.
                let inward = -orbit.offset_km(1.0, pole).normalize();
                let (forward, up) = (axes_from_icrf * pose.forward, axes_from_icrf * pose.up);
                [*yaw_deg, *pitch_deg, self.view.roll_deg] = orbit_angles_deg(inward, pole, forward, up);
            }
            CameraPose::Centre { .. } | CameraPose::Free { .. } => {}
        }
    }

    /// Replaces a free pose, in which a tour was paused, by one that drags can change and that gives the same image. The new pose is an orbit, or a place
    /// above the ground if the camera is closer to the centre than the equatorial radius: near the ground of a flattened body there is no orbit. During a
    /// flight the pose stays free.
    pub(super) fn leave_free_pose(&mut self, positions: &dyn BodyPositions) {
        let CameraPose::Free { body, offset_km, forward, up } = self.view.camera_pose else { return };
        let Some(body_from_icrf) = positions.body_from_icrf(body, self.view.time()).filter(|_| !self.is_flying()) else { return };
        let (Some(inward), Some(forward)) = ((-offset_km).try_normalize(), forward.try_normalize()) else { return };
        let radii_km = self.selectable_body(body).map_or(DVec3::ONE, |s| s.radii_km);
        // A free camera tracks nothing.
        self.view.tracks = self.view.target == body;
        if offset_km.length() < radii_km.x
            && let Some(place) = GroundPlace::of(radii_km, body_from_icrf * offset_km)
        {
            (self.view.camera_pose, self.view.roll_deg) = place.pose(body, body_from_icrf * forward, body_from_icrf * up);
            return;
        }
        let pole = body_from_icrf.row(2);
        self.view.camera_pose = inertial_orbit_pose(body, OrbitCamera::from_offset(offset_km, self.radius_km(body), pole));
        if let CameraPose::Orbit { yaw_deg, pitch_deg, .. } = &mut self.view.camera_pose {
            [*yaw_deg, *pitch_deg, self.view.roll_deg] = orbit_angles_deg(inward, pole, forward, up);
        }
    }

    /// Changes the axes of an orbit to body-fixed ones (`make_body_fixed`) or to ICRF, and keeps the camera in place.
    pub(super) fn rotate_with_body(&mut self, make_body_fixed: bool, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        let CameraPose::Orbit { body, is_body_fixed, yaw_deg: old_yaw_deg, pitch_deg: old_pitch_deg, .. } = self.view.camera_pose else {
            return;
        };
        let Some(pose) = self.pose_relative_to(body, positions).filter(|_| is_body_fixed != make_body_fixed) else { return };
        let Some(body_from_icrf) = positions.body_from_icrf(body, self.view.time()) else { return };
        let radius_km = self.radius_km(body);
        self.view.camera_pose = if make_body_fixed {
            body_fixed_orbit_pose(body, OrbitCamera::from_offset(body_from_icrf * pose.offset_km, radius_km, DVec3::Z))
        } else {
            inertial_orbit_pose(body, OrbitCamera::from_offset(pose.offset_km, radius_km, body_from_icrf.row(2)))
        };
        // Both poses measure yaw and pitch from the direction to the body and its pole.
        if let CameraPose::Orbit { yaw_deg, pitch_deg, .. } = &mut self.view.camera_pose {
            (*yaw_deg, *pitch_deg) = (old_yaw_deg, old_pitch_deg);
        }
    }

    /// Resets the roll and tracks the target; in an orbit, the orbited body becomes the target.
    pub(super) fn face_body(&mut self, positions: &dyn BodyPositions) {
        self.end_flight();
        self.leave_free_pose(positions);
        self.view.roll_deg = 0.0;
        self.view.tracks = true;
        if let CameraPose::Orbit { body, yaw_deg, pitch_deg, .. } = &mut self.view.camera_pose {
            (*yaw_deg, *pitch_deg) = (0.0, 0.0);
            self.view.target = *body;
        }
    }
}

/// A place above the reference ellipsoid, as in [`ground_point_km`].
struct GroundPlace {
    latitude_deg: f64,
    longitude_deg: f64,
    height_km: f64,
    /// The direction of the zenith, body-fixed.
    normal: DVec3,
}

impl GroundPlace {
    /// The place of a body-fixed point: the inverse of [`ground_point_km`]. `None` for a point on or below the ellipsoid.
    fn of(radii_km: DVec3, point_km: DVec3) -> Option<Self> {
        let squared_radii = radii_km * radii_km;
        let mut normal = (point_km / squared_radii).try_normalize()?;
        let mut height_km = 0.0;
        // Each step multiplies the error of the normal by about the height in radii. The camera is closer to the centre than the equatorial radius, so this
        // factor is below the flattening, which is at most 0.1 for a planet. Up to a factor of 0.3, as for a very flat moon, this number of steps reaches
        // the precision of f64.
        for _ in 0..GROUND_PLACE_STEPS {
            let surface_km = squared_radii * normal / (squared_radii * normal).dot(normal).sqrt();
            height_km = (point_km - surface_km).dot(normal);
            normal = ((point_km - normal * height_km) / squared_radii).try_normalize()?;
        }
        let [latitude_deg, longitude_deg] = place_of_normal_deg(radii_km, normal);
        // At a pole, east and north depend on the longitude, so the normal is computed from latitude and longitude, as for an image of the pose.
        let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
        (height_km > 0.0).then_some(Self { latitude_deg, longitude_deg, height_km, normal })
    }

    /// The camera pose at this place with these forward and up vectors, body-fixed, and its roll, degrees.
    fn pose(&self, body: NaifId, forward: DVec3, up: DVec3) -> (CameraPose, f64) {
        let Self { latitude_deg, longitude_deg, height_km, normal } = *self;
        let (azimuth_deg, altitude_deg) = horizontal_angles_deg(normal, forward);
        let (_, unrolled_up) = view_at_azimuth_altitude(normal, azimuth_deg, altitude_deg);
        let camera_pose = CameraPose::Ground { body, latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg };
        (camera_pose, roll_deg(forward, unrolled_up, up))
    }
}

/// The roll, degrees, that turns `unrolled_up` about `forward` to `up`. A positive roll turns the up vector by a negative angle.
fn roll_deg(forward: DVec3, unrolled_up: DVec3, up: DVec3) -> f64 {
    (-up.dot(forward.cross(unrolled_up)).atan2(up.dot(unrolled_up)).to_degrees()).rem_euclid(360.0)
}

/// Yaw, pitch and roll, degrees, of a camera with these forward and up vectors. Yaw and pitch are measured from `inward`, the direction from the camera to the
/// body that it orbits. All vectors are in the same axes; `forward` and `inward` are unit vectors.
fn orbit_angles_deg(inward: DVec3, pole: DVec3, forward: DVec3, up: DVec3) -> [f64; 3] {
    // Yaw and pitch are 0 here: the camera faces the body.
    let (inward, level_up) = rotated_view(inward, pole, 0.0, 0.0);
    let right = inward.cross(level_up);
    let yaw_deg = forward.dot(right).atan2(forward.dot(inward)).to_degrees();
    let pitch_deg = forward.dot(level_up).clamp(-1.0, 1.0).asin().to_degrees();
    let (_, unrolled_up) = rotated_view(inward, pole, yaw_deg, pitch_deg);
    [yaw_deg, pitch_deg, roll_deg(forward, unrolled_up, up)]
}
