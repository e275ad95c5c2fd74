//! Where a viewer sees a minor planet or a comet: for names, clicks and facts, one body at a time.
//!
//! In: the ephemeris, the camera's position with its velocity, a time, a body. Out: [`SeenSmallBody`]. Always: light time and aberration are those of the drawn
//! heads (`comets`) and points (`minor_planets`). Not here: what is drawn.

use crate::catalog::small_bodies::SmallBody;
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::conic::heliocentric_state;
use crate::ephemeris::target::Target;
use crate::ephemeris::{Ephemeris, angle_rad};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use glam::DVec3;

/// A viewer of small bodies.
#[derive(Clone, Copy)]
pub struct SmallBodySight<'a> {
    /// The position of the Sun.
    pub ephemeris: &'a Ephemeris,
    /// Barycentric position of the camera, ICRF.
    pub position_km: DVec3,
    /// The viewer's velocity, for the aberration of bodies.
    pub velocity_km_s: DVec3,
    /// The time at the camera.
    pub time: Instant,
}

/// A minor planet or a comet as a viewer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenSmallBody {
    /// Vector from the camera to its apparent place, ICRF.
    pub apparent_km: DVec3,
    /// Its distance from the Sun when the light left it.
    pub sun_distance_au: f64,
    /// Angle at the body between the viewer and the Sun.
    pub phase_angle_rad: f64,
}

impl SmallBodySight<'_> {
    /// The body as it is seen; `None` if the ephemeris does not cover the time, or the camera is at the body.
    pub fn see(&self, body: &SmallBody) -> Option<SeenSmallBody> {
        let target = Target::SmallBody(body);
        let (position_km, emitted) = self.ephemeris.target_light_time_position(target, self.position_km, self.time).ok()?;
        let to_body = position_km - self.position_km;
        let distance_km = to_body.length();
        let days = emitted.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
        let from_sun_au = heliocentric_state(body.orbit_at(days), days).position;
        (distance_km > 0.0 && distance_km.is_finite()).then(|| SeenSmallBody {
            apparent_km: aberrated(to_body / distance_km, self.velocity_km_s) * distance_km,
            sun_distance_au: from_sun_au.length(),
            phase_angle_rad: angle_rad(-to_body, -from_sun_au),
        })
    }
}
