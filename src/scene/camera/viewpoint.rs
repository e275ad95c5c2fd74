//! Places the camera of a request: its position and direction at the request's instant, and aberration for a moving viewer.
//!
//! In: the request, the catalog and the ephemeris. Out: a [`Viewer`]: the camera, its velocity if it moves with a body, and the body on which it stands or at
//! whose centre it is. A camera above its target is at rest relative to the barycentre of the solar system, and is placed relative to the apparent target, so
//! that light time does not shift the target in the frame. Diurnal aberration (at most 0.32 arcsec on the Earth) is left out.

use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::topocentric::ground_point_km;
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError, State};
use crate::scene::camera::Camera;
use crate::scene::error::SceneError;
use crate::scene::request::camera_file::normalisable_direction;
use crate::scene::request::view_request::{
    Axes, FITTED_DISC_FRACTION, FOV_AT_FITTED_DISTANCE_DEG, FOV_AT_GIVEN_POSITION_DEG, Look, Position, Up, ViewRequest,
};
use crate::scene::sky::frames::ecliptic_pole;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use glam::{DMat3, DVec3};

/// A camera and its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewer {
    pub camera: Camera,
    /// Barycentric velocity, ICRF, of the body at whose centre or on whose ground the camera is; zero for a camera above its target or at an offset from a
    /// body. It gives the aberration of bodies.
    pub velocity_km_s: DVec3,
    /// Barycentric velocity, ICRF, of the body relative to which the camera is placed, in every position. It gives the aberration of the sky (stars, grids, sky
    /// images), so that stars do not jump as the camera leaves the ground. If `velocity_km_s` is zero, stars are displaced relative to bodies by up to this
    /// speed divided by that of light, radians (docs/accuracy.md).
    pub sky_aberration_velocity_km_s: DVec3,
    /// The requested up direction (ICRF, of any length), not necessarily orthogonal to the line of sight.
    pub up_hint: DVec3,
    /// The body or barycentre at whose centre the camera is; `None` for a camera elsewhere. A body around the camera is not drawn. In a stereo pair the cameras
    /// are beside this centre.
    pub at_centre_of: Option<CarryingBody>,
    /// The body on whose ground the camera stands; `None` for a camera elsewhere.
    pub stands_on: Option<CarryingBody>,
}

/// The body on whose ground a camera stands, or at whose centre it is. Viewer and body move together, so light time and aberration between them cancel (to
/// second order in v/c, 1e-8), and the body's geometric position is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarryingBody {
    pub id: NaifId,
    /// Barycentric position of the body's centre.
    pub centre_km: DVec3,
}

/// Distance from a sphere's centre, in its radii, at which its disc has the diameter [`FITTED_DISC_FRACTION`]. A disc of angular radius a fills the fraction
/// tan a / tan(fov / 2) of the frame's height.
fn fitted_distance_radii(fov_deg: f64) -> f64 {
    1.0 / (FITTED_DISC_FRACTION * (fov_deg.to_radians() / 2.0).tan()).atan().sin()
}

/// The field of view in which a disc of this angular radius has the diameter [`FITTED_DISC_FRACTION`].
fn fitted_fov_deg(angular_radius_rad: f64) -> f64 {
    2.0 * (angular_radius_rad.tan() / FITTED_DISC_FRACTION).atan().to_degrees()
}

/// Range of the field of view that is fitted to a target as seen from a body's centre, degrees. The lower limit is far smaller than the disc of any body.
const FITTED_FOV_RANGE_DEG: (f64, f64) = (1e-6, 60.0);
/// Distance from the camera to what it looks at below which there is no line of sight: a millimetre.
const MIN_DISTANCE_KM: f64 = 1e-6;

/// Looks up bodies and their states at the request's time.
struct StateLookup<'a> {
    catalog: &'a Catalog,
    ephemeris: &'a Ephemeris,
    time: Instant,
}

impl StateLookup<'_> {
    fn body(&self, id: NaifId) -> Result<&Body, SceneError> {
        self.catalog.body(id).ok_or_else(|| SceneError::NotABody(format!("{}", id.0)))
    }

    /// Barycentric state, ICRF.
    fn state(&self, id: NaifId) -> Result<State, SceneError> {
        Ok(self.ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, self.time, BEST_SOURCE)?.state)
    }

    /// Barycentric position, ICRF, of a body at the time when it emitted the light that now arrives at this distance from it.
    fn position_at_emission_km(&self, id: NaifId, distance_km: f64) -> Result<DVec3, SceneError> {
        // If the ephemeris does not contain the requested time, the error must name that time, not the time less the light time.
        self.state(id)?;
        let emission_time = self.time.plus_seconds(-distance_km / SPEED_OF_LIGHT_KM_S);
        let emitted = self.ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, emission_time, BEST_SOURCE);
        Ok(emitted.map_err(EphemerisError::when_light_left)?.state.pos_km)
    }

    /// The rotation to ICRF from the axes of a body, or the identity for ICRF axes.
    fn icrf_from(&self, axes: Axes, body: NaifId) -> Result<DMat3, SceneError> {
        match axes {
            Axes::Icrf => Ok(DMat3::IDENTITY),
            Axes::BodyFixed => Ok(self.ephemeris.body_from_icrf(body, self.time)?.transpose()),
        }
    }
}

/// Maximum distance of a camera from the body relative to which it is placed: 1000 light years. From farther away the time of emission would be outside
/// every ephemeris.
pub(crate) const FARTHEST_KM: f64 = 1000.0 * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY * SPEED_OF_LIGHT_KM_S;

/// An error if a distance is more than [`FARTHEST_KM`]. `what`: the value of the request that gives the distance.
fn check_distance(distance_km: f64, what: impl FnOnce() -> String) -> Result<(), SceneError> {
    if distance_km <= FARTHEST_KM {
        return Ok(());
    }
    Err(SceneError::Request(format!("{}: that is {distance_km:.3e} km away; at most {FARTHEST_KM:.3e} km, 1000 light years", what())))
}

/// Places the camera of a request.
///
/// # Errors
/// An invalid request, a body that cannot be placed at the request's time, a camera that is too far away, or one that has no line of sight to its target.
pub fn viewer(catalog: &Catalog, ephemeris: &Ephemeris, request: &ViewRequest) -> Result<Viewer, SceneError> {
    request.check()?;
    let states = StateLookup { catalog, ephemeris, time: request.time };
    let required_target = || request.target.ok_or_else(|| SceneError::Request("name a target, or give the direction to look in".into()));
    let mut fov_deg = request.fov_deg;
    let mut velocity_km_s = DVec3::ZERO;
    let mut at_centre_of = None;
    let mut stands_on = None;
    // The direction of `Up::Zenith`: away from the centre or the ground of the body below the camera; `None` at the centre of a body.
    let mut zenith = None;
    // The body relative to which the camera is placed.
    let reference_body;
    // The centre, however it was given.
    let position = match request.position {
        Position::Offset { body, offset_km, axes } => Position::at_offset(body, offset_km, axes),
        other => other,
    };
    let position_km = match position {
        Position::AboveTarget { towards, distance_radii } => {
            let target = states.body(required_target()?)?;
            reference_body = target.id;
            // Fixes the field of view if the request does not.
            let fov = *fov_deg.get_or_insert(if distance_radii.is_some() { FOV_AT_GIVEN_POSITION_DEG } else { FOV_AT_FITTED_DISTANCE_DEG });
            let distance_km = distance_radii.unwrap_or_else(|| fitted_distance_radii(fov)) * target.radii_km.max_element();
            let distance_text = || distance_radii.map_or_else(|| format!("field of view {fov}"), |d| format!("distance {d:?} radii"));
            check_distance(distance_km, distance_text)?;
            let centre = states.position_at_emission_km(target.id, distance_km)?;
            // The camera is above the side of the target that faces this body: by default the Earth, or the Sun if the target is the Earth.
            let faced_body = towards.unwrap_or(if target.id == NaifId::EARTH { NaifId::SUN } else { NaifId::EARTH });
            if faced_body == target.id {
                return Err(SceneError::Request(format!(
                    "the camera cannot be on the side of {0} that faces {0} itself: name another body",
                    target.name
                )));
            }
            // `DVec3::X` if the two bodies are at the same place.
            let outward = (states.state(faced_body)?.pos_km - centre).try_normalize().unwrap_or(DVec3::X);
            zenith = Some(outward);
            centre + outward * distance_km
        }
        Position::Centre(body) => {
            reference_body = body;
            let State { pos_km, vel_km_s } = states.state(body)?;
            velocity_km_s = vel_km_s;
            at_centre_of = Some(CarryingBody { id: body, centre_km: pos_km });
            pos_km
        }
        Position::Ground { body, latitude_deg, longitude_deg, height_km } => {
            reference_body = body;
            check_distance(height_km, || format!("height {height_km:?} km"))?;
            let (point, normal) = ground_point_km(states.body(body)?.radii_km, latitude_deg, longitude_deg, height_km);
            let icrf_from_body = states.icrf_from(Axes::BodyFixed, body)?;
            let State { pos_km, vel_km_s } = states.state(body)?;
            velocity_km_s = vel_km_s;
            stands_on = Some(CarryingBody { id: body, centre_km: pos_km });
            zenith = Some(icrf_from_body * normal);
            pos_km + icrf_from_body * point
        }
        Position::Offset { body, offset_km, axes } => {
            reference_body = body;
            let offset = states.icrf_from(axes, body)? * offset_km;
            check_distance(offset.length(), || "camera".into())?;
            zenith = offset.try_normalize();
            states.position_at_emission_km(body, offset.length())? + offset
        }
    };
    let forward = match request.look {
        // The direction in the image: aberration does not apply.
        Look::Along { direction, axes } => {
            let unit = normalisable_direction(direction.to_array()).map(DVec3::normalize);
            let unusable_direction = || SceneError::Request("the direction to look in must be finite and not zero".into());
            states.icrf_from(axes, reference_body)? * unit.ok_or_else(unusable_direction)?
        }
        Look::Target => {
            let target = required_target()?;
            let stands_on_target = stands_on.filter(|ground| ground.id == target);
            let apparent_km = match stands_on_target {
                Some(ground) => ground.centre_km,
                None => {
                    let (position_at_emission_km, _emission_time) = ephemeris.light_time_position(target, position_km, request.time)?;
                    position_at_emission_km
                }
            };
            let to_target = apparent_km - position_km;
            if to_target.length() < MIN_DISTANCE_KM || at_centre_of.is_some_and(|centre| centre.id == target) {
                return Err(SceneError::Request("the camera is at the centre of what it looks at: choose another place or target".into()));
            }
            if fov_deg.is_none() && matches!(position, Position::Centre(_)) {
                fov_deg = catalog.body(target).map(|b| {
                    let angular_radius_rad = (b.radii_km.max_element() / to_target.length()).min(1.0).asin();
                    fitted_fov_deg(angular_radius_rad).clamp(FITTED_FOV_RANGE_DEG.0, FITTED_FOV_RANGE_DEG.1)
                });
            }
            // No aberration for a camera that moves with the target ([`CarryingBody`]).
            if stands_on_target.is_some() { to_target.normalize() } else { aberrated(to_target.normalize(), velocity_km_s) }
        }
    };
    let up_hint = match request.up {
        // The north pole of the target if the camera looks at it, else of the body relative to which the camera is placed. A barycentre has none:
        // the celestial pole replaces it.
        Up::North => match request.target.filter(|_| request.look == Look::Target).or(Some(reference_body)) {
            Some(body) if catalog.body(body).is_some() => ephemeris.body_from_icrf(body, request.time)?.row(2),
            _ => DVec3::Z,
        },
        Up::Zenith => zenith.unwrap_or(DVec3::Z),
        Up::Celestial => DVec3::Z,
        Up::Ecliptic => ecliptic_pole(),
        Up::Along { direction, axes } => states.icrf_from(axes, reference_body)? * direction,
    };
    let fov_deg = fov_deg.unwrap_or(FOV_AT_GIVEN_POSITION_DEG);
    let camera = Camera::looking(position_km, forward, up_hint, fov_deg, request.width, request.height);
    let camera = if request.is_mirrored { camera.mirrored() } else { camera };
    let sky_aberration_velocity_km_s = states.state(reference_body)?.vel_km_s;
    Ok(Viewer { camera, velocity_km_s, sky_aberration_velocity_km_s, up_hint, at_centre_of, stands_on })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_without_a_unit_vector_is_refused() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let time = Instant::parse("2024-04-08T18:00:00Z").expect("a time");
        let looking = |direction: DVec3| {
            let look = Look::Along { direction, axes: Axes::Icrf };
            let request = ViewRequest { look, position: Position::Centre(NaifId::EARTH), ..ViewRequest::of(NaifId::MOON, time) };
            viewer(&catalog, &ephemeris, &request).map(|v| v.camera.forward)
        };
        for direction in [DVec3::ZERO, DVec3::X * f64::INFINITY, DVec3::splat(f64::NAN)] {
            let error = looking(direction).expect_err("refused").to_string();
            assert!(error.contains("direction"), "{direction}: {error}");
        }
        // The square of the first underflows, that of the last overflows.
        for length in [1e-200, 1e100, 1e200] {
            assert!(looking(DVec3::X * length).expect("a camera").distance(DVec3::X) < 1e-12, "{length}");
        }
    }
}
