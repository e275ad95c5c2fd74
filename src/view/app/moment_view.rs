//! The view of a well-known moment of the catalog.
//!
//! In: a [`Moment`], positions of bodies. Out: a [`ViewState`], or `None` if the ephemeris does not cover the moment or the catalog lacks its
//! body.

use crate::catalog::Catalog;
use crate::catalog::moments::{Moment, Vantage};
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::view_state::{CameraPose, DEFAULT_FOV_DEG, ViewState, inertial_orbit_pose};

/// The view of a moment; quality, effects and layers come from `base_view`.
pub(crate) fn view_of_moment(
    moment: &Moment,
    catalog: &Catalog,
    positions: &dyn BodyPositions,
    base_view: &ViewState,
) -> Option<ViewState> {
    let target = catalog.body(moment.target)?;
    let (camera_pose, fov_deg) = match moment.vantage {
        Vantage::Centre { body, fov_deg } => (CameraPose::Centre { body }, fov_deg),
        Vantage::Side { reference_body, is_far_side, distance_radii } => {
            let towards_reference_body = positions.geometric_vector_km(target.id, reference_body, moment.time)?.try_normalize()?;
            // Unit vector from the target to the camera.
            let side = if is_far_side { -towards_reference_body } else { towards_reference_body };
            let pole = positions.body_from_icrf(target.id, moment.time)?.row(2);
            let radius_km = target.radii_km.x;
            (inertial_orbit_pose(target.id, OrbitCamera::from_offset(side * distance_radii * radius_km, radius_km, pole)), DEFAULT_FOV_DEG)
        }
        // Above the target itself the camera looks straight down; from any other body it tracks the target, and these angles are not used.
        Vantage::Place { body, latitude_deg, longitude_deg, height_km, fov_deg } => {
            let (azimuth_deg, altitude_deg) = if body == target.id { (0.0, -90.0) } else { (0.0, 0.0) };
            (CameraPose::Ground { body, latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg }, fov_deg)
        }
    };
    Some(base_view.paused_view(moment.time, target.id, camera_pose, fov_deg))
}
