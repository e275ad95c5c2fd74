//! Views of stars, constellations, minor planets and comets, from near the Earth.
//!
//! In: a star, a constellation or a small body, the time of a base view. Out: a view with it in the middle of the image and the Earth behind the camera; `None`
//! if the ephemeris does not cover the time. Always: settings other than camera, time and the layer that draws the target are those of the base view.

use crate::catalog::NaifId;
use crate::catalog::constellations::Constellation;
use crate::catalog::small_bodies::SmallBody;
use crate::catalog::stars::Star;
use crate::ephemeris::star_place::star_from_viewer;
use crate::ephemeris::{BEST_SOURCE, Ephemeris, angle_rad};
use crate::scene::labels::SmallBodySight;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::view_state::{CameraPose, ViewState};
use glam::DVec3;

/// Vertical field of view around a star, a minor planet or a comet.
const FOV_DEG: f64 = 20.0;
/// Distance of the camera from the Earth's centre, in Earth radii. The camera is between the Earth and the target.
const CAMERA_RADII: f64 = 3.0;
/// Vertical field of view around a constellation: range, and the value for one without a figure.
const CONSTELLATION_FOV_RANGE_DEG: [f64; 2] = [20.0, 100.0];
const DEFAULT_CONSTELLATION_FOV_DEG: f64 = 40.0;
/// The height of the image relative to the constellation's largest extent from the place of its name, in both directions.
const CONSTELLATION_MARGIN: f64 = 1.2;

/// The view in a direction (ICRF, of any length), with the Earth behind the camera.
fn view_along(direction: DVec3, fov_deg: f64, positions: &dyn BodyPositions, base_view: &ViewState) -> Option<ViewState> {
    let pole = positions.body_from_icrf(NaifId::EARTH, base_view.time())?.row(2);
    let orbit = OrbitCamera::from_offset_radii(direction.try_normalize()? * CAMERA_RADII, pole);
    let camera_pose = CameraPose::Orbit {
        body: NaifId::EARTH,
        // In ICRF, so that the camera does not rotate with the Earth.
        is_body_fixed: false,
        azimuth_deg: orbit.azimuth_rad.to_degrees(),
        elevation_deg: orbit.elevation_rad.to_degrees(),
        distance_radii: orbit.distance_radii,
        // Away from the Earth.
        yaw_deg: 180.0,
        pitch_deg: 0.0,
    };
    Some(base_view.tracking_view(NaifId::EARTH, camera_pose, fov_deg))
}

/// The view of a star. `years_since_epoch`: Julian years since the epoch of the star catalog.
pub fn star_view(star: &Star, years_since_epoch: f64, positions: &dyn BodyPositions, base_view: &ViewState) -> Option<ViewState> {
    // As seen from the solar system's barycentre: the annual parallax is too small to see in this field of view.
    view_along(star_from_viewer(star, years_since_epoch, DVec3::ZERO), FOV_DEG, positions, base_view)
}

/// The view of a constellation, with the figures switched on. The image is high enough for the whole figure.
pub fn constellation_view(constellation: &Constellation, positions: &dyn BodyPositions, base_view: &ViewState) -> Option<ViewState> {
    let middle = constellation.label_direction;
    let extents_rad = constellation.figure.iter().flatten().map(|vertex| angle_rad(vertex.direction, middle));
    let [least_deg, most_deg] = CONSTELLATION_FOV_RANGE_DEG;
    let fov_deg = extents_rad.reduce(f64::max).map_or(DEFAULT_CONSTELLATION_FOV_DEG, |extent_rad| {
        (2.0 * CONSTELLATION_MARGIN * extent_rad.to_degrees()).clamp(least_deg, most_deg)
    });
    let mut view = view_along(middle, fov_deg, positions, base_view)?;
    view.layers.constellations = true;
    Some(view)
}

/// Where a small body is seen from the Earth's centre, and so by a camera between the two.
pub fn sight_from_earth<'a>(ephemeris: &'a Ephemeris, base_view: &ViewState) -> Option<SmallBodySight<'a>> {
    let time = base_view.time();
    let earth = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, time, BEST_SOURCE).ok()?.state;
    // A camera in orbit is at rest: it sees no aberration of bodies.
    Some(SmallBodySight { ephemeris, position_km: earth.pos_km, velocity_km_s: DVec3::ZERO, time })
}

/// The view of a minor planet or comet, with the layer switched on that draws it.
pub fn small_body_view(body: &SmallBody, ephemeris: &Ephemeris, positions: &dyn BodyPositions, base_view: &ViewState) -> Option<ViewState> {
    let seen = sight_from_earth(ephemeris, base_view)?.see(body)?;
    let mut view = view_along(seen.apparent_km, FOV_DEG, positions, base_view)?;
    if body.is_comet() {
        view.layers.comets = true;
    } else {
        view.layers.minor_planets = true;
    }
    Some(view)
}
