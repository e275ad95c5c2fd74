//! The first view of a window: a body seen from its lit side; if it is the Earth, with the Moon beside it where possible.
//!
//! In: a body, a time, positions. Out: a [`ViewState`], with the layer of brightened stars. The Moon is left out if it is less than about 57 degrees
//! from the Sun: the camera could show it only beside a thin crescent of the Earth. Within 10 degrees of full moon it may be left out, too, if none of
//! the camera directions that are tried shows it beside the Earth.

use crate::catalog::{Catalog, NaifId};
use crate::time::Instant;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::view_state::{ViewState, ViewStateError};
use glam::{DQuat, DVec3};

/// Distance of the first view, equatorial radii.
const START_DISTANCE_RADII: f64 = 3.5;
/// Angle at the body's centre between the Sun and the camera (the phase angle), before the camera is moved by [`POLE_OFFSET`]. At this angle the
/// terminator is visible.
const SUN_ANGLE_DEG: f64 = 62.0;
/// Range of the Sun angles that are tried for a view with the Moon.
const SUN_ANGLE_RANGE_DEG: [f64; 2] = [30.0, 94.0];
/// Step from one tried Sun angle to the next.
const SUN_ANGLE_STEP_DEG: f64 = 4.0;
/// Offset of the camera towards the pole, as a fraction of its distance from the body's centre.
const POLE_OFFSET: f64 = 0.25;
/// The offsets towards the pole that are tried for a view with the Moon.
const POLE_OFFSETS: [f64; 5] = [POLE_OFFSET, 0.1, 0.0, -0.1, -POLE_OFFSET];
/// Greatest horizontal distance of the Moon from the image's centre. This distance and the next two are tangents of angles at the camera.
const MOON_MAX_HORIZONTAL_TAN: f64 = 0.5;
/// Lowest and highest position of the Moon in the image: above the row *What to see now*, and below the upper edge.
const MOON_HEIGHTS_TAN: [f64; 2] = [-0.1, 0.33];
/// Least distance of the Moon from the image's centre: just outside the Earth's disc.
const MOON_MIN_DISTANCE_TAN: f64 = 0.33;

/// The first view of a body at a time.
///
/// # Errors
/// If the catalog does not contain the body.
pub fn initial_view(catalog: &Catalog, positions: &dyn BodyPositions, target: NaifId, time: Instant) -> Result<ViewState, ViewStateError> {
    let body = catalog.body(target).ok_or(ViewStateError::NoSuchBody(target))?;
    let sunward = positions.geometric_vector_km(target, NaifId::SUN, time).and_then(DVec3::try_normalize);
    let pole = positions.body_from_icrf(target, time).map_or(DVec3::Z, |m| m.row(2));
    let radius_km = body.radii_km.x;
    // The Moon's position relative to the Earth's centre, in Earth radii.
    let earth_to_moon_radii =
        if target == NaifId::EARTH { positions.geometric_vector_km(target, NaifId::MOON, time).map(|km| km / radius_km) } else { None };
    let direction_with_moon = sunward.zip(earth_to_moon_radii).and_then(|(sun, moon)| camera_direction_with_moon(sun, moon, pole));
    // Without the Moon, the camera's direction is turned from the Sun's about the celestial pole.
    let direction = direction_with_moon.unwrap_or_else(|| camera_direction(sunward, DVec3::Z, SUN_ANGLE_DEG, POLE_OFFSET, pole));
    let mut view = ViewState::around(target, direction * (START_DISTANCE_RADII * radius_km), radius_km, pole, time);
    // At the exposure of a sunlit planet no star would be visible without this layer.
    view.layers.bright_stars = true;
    Ok(view)
}

/// Unit vector from the body to the camera: the direction to the Sun, turned about `axis` by `sun_angle_deg`, then moved towards the pole. `sunward`: `None`
/// for the Sun itself, and if the ephemeris does not cover the time; an arbitrary direction is then moved towards the pole.
fn camera_direction(sunward: Option<DVec3>, axis: DVec3, sun_angle_deg: f64, pole_offset: f64, pole: DVec3) -> DVec3 {
    let beside_sun = sunward.map_or(DVec3::X, |sun| DQuat::from_axis_angle(axis, sun_angle_deg.to_radians()) * sun);
    (beside_sun + pole_offset * pole).try_normalize().unwrap_or(beside_sun)
}

/// The direction from the Earth to a camera that sees the Moon beside the Earth: the one whose angle from the Sun is closest to [`SUN_ANGLE_DEG`]; `None` if no
/// tried direction does.
/// `earth_to_moon_radii`: the Moon's position relative to the Earth's centre, in Earth radii.
fn camera_direction_with_moon(sunward: DVec3, earth_to_moon_radii: DVec3, pole: DVec3) -> Option<DVec3> {
    // About this axis, a positive angle turns the Sun's direction away from the Moon's: for a camera in the turned direction, the Moon is beyond the Earth.
    let axis = earth_to_moon_radii.cross(sunward).try_normalize()?;
    let [min_deg, max_deg] = SUN_ANGLE_RANGE_DEG;
    let steps = ((max_deg - min_deg) / SUN_ANGLE_STEP_DEG) as u32;
    let mut angles_deg: Vec<f64> = (0..=steps).map(|k| min_deg + f64::from(k) * SUN_ANGLE_STEP_DEG).collect();
    angles_deg.sort_by(|a, b| (a - SUN_ANGLE_DEG).abs().total_cmp(&(b - SUN_ANGLE_DEG).abs()));
    let at_angle = |&angle_deg: &f64| POLE_OFFSETS.map(|offset| camera_direction(Some(sunward), axis, angle_deg, offset, pole));
    let directions = angles_deg.iter().flat_map(at_angle);
    directions.into_iter().find(|&direction| shows_moon(direction, earth_to_moon_radii, pole))
}

/// Whether a camera in this direction from the Earth, with the pole up, shows the Moon beside the Earth's disc.
fn shows_moon(direction: DVec3, earth_to_moon_radii: DVec3, pole: DVec3) -> bool {
    let moon_from_camera = earth_to_moon_radii - direction * START_DISTANCE_RADII;
    // Distance of the Moon along the line of sight, which is opposite to `direction`.
    let depth_radii = -moon_from_camera.dot(direction);
    let Some(right) = pole.cross(direction).try_normalize().filter(|_| depth_radii > 0.0) else { return false };
    // The Moon's position in the image, right and up from the centre: tangents of angles at the camera.
    let [x, y] = [right, direction.cross(right)].map(|axis| moon_from_camera.dot(axis) / depth_radii);
    let [lowest, highest] = MOON_HEIGHTS_TAN;
    x.abs() <= MOON_MAX_HORIZONTAL_TAN && (lowest..=highest).contains(&y) && x.hypot(y) >= MOON_MIN_DISTANCE_TAN
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angle_rad(a: DVec3, b: DVec3) -> f64 {
        a.cross(b).length().atan2(a.dot(b))
    }

    /// The camera's direction for a Moon in the ecliptic at an angle of 0 to 360 degrees east of the Sun. The Sun is along x; the Earth's pole is 23 degrees
    /// from the ecliptic's.
    fn direction_for_elongation(elongation_deg: f64) -> Option<DVec3> {
        let pole = DVec3::new(0.0, -0.39, 0.92).normalize();
        // The Moon's mean distance is 60.3 Earth radii.
        let moon = DQuat::from_axis_angle(DVec3::Z, elongation_deg.to_radians()) * DVec3::X * 60.3;
        let direction = camera_direction_with_moon(DVec3::X, moon, pole);
        if let Some(direction) = direction {
            assert!(shows_moon(direction, moon, pole));
            // At least two fifths of the disc are lit, and the terminator is visible.
            let sun_angle_deg = angle_rad(direction, DVec3::X).to_degrees();
            assert!((25.0..100.0).contains(&sun_angle_deg), "{elongation_deg}: {sun_angle_deg}");
            // The Moon is beside the disc, whose angular radius is asin(1 / 3.5).
            let moon_from_camera = moon - START_DISTANCE_RADII * direction;
            assert!(angle_rad(moon_from_camera, -direction) > (1.0 / START_DISTANCE_RADII).asin() + 0.01, "{elongation_deg}");
        }
        direction
    }

    #[test]
    fn the_moon_is_shown_beside_the_earth_unless_it_is_near_the_sun() {
        for elongation_deg in (0..360).step_by(5) {
            let from_sun_deg = f64::from(180 - (elongation_deg - 180_i32).abs());
            let found = direction_for_elongation(f64::from(elongation_deg));
            // The limit of about 57 degrees (see the module comment) is between these two.
            assert!(found.is_some() || from_sun_deg < 75.0, "{elongation_deg}");
            assert!(found.is_none() || from_sun_deg > 50.0, "{elongation_deg}");
        }
    }
}
