//! The first view of a window: a body seen from its lit side.
//!
//! In: a body, a time, positions. Out: a [`ViewState`].

use crate::catalog::{Catalog, NaifId};
use crate::time::Instant;
use crate::view::app::places::BodyPositions;
use crate::view::app::view_state::{ViewState, ViewStateError};
use glam::{DQuat, DVec3};

/// Distance of the first view, equatorial radii.
const START_DISTANCE_RADII: f64 = 3.5;
/// Angle between the directions to the camera and to the Sun, chosen so that the terminator is visible.
const SUN_ANGLE_DEG: f64 = 62.0;
/// Offset of the camera towards the pole, as a fraction of the distance.
const POLE_OFFSET: f64 = 0.25;

/// # Errors
/// If the catalog does not contain the body.
pub fn initial_view(catalog: &Catalog, places: &dyn BodyPositions, target: NaifId, time: Instant) -> Result<ViewState, ViewStateError> {
    let body = catalog.body(target).ok_or(ViewStateError::NoSuchBody(target))?;
    let sunward = places.between_km(target, NaifId::SUN, time).and_then(DVec3::try_normalize);
    let aside = sunward.map_or(DVec3::X, |sun| DQuat::from_axis_angle(DVec3::Z, SUN_ANGLE_DEG.to_radians()) * sun);
    let pole = places.body_from_icrf(target, time).map_or(DVec3::Z, |m| m.row(2));
    let side = (aside + POLE_OFFSET * pole).try_normalize().unwrap_or(aside);
    let radius_km = body.radii_km.x;
    Ok(ViewState::around(target, side * (START_DISTANCE_RADII * radius_km), radius_km, pole, time))
}
