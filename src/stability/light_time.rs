//! The sweep `light-time`: directions of bodies in the scene against an independent computation.
//!
//! In: a sweep's setup. Out: the greatest angle between the two directions, arcseconds.

use super::{SweepResult, SweepSetup, if_possible};
use crate::catalog::NaifId;
use crate::ephemeris::{BEST_SOURCE, angle_rad};
use crate::scene::request::{Position, ViewRequest};
use crate::session::{Session, SessionError};
use crate::time::Instant;
use crate::units::{RAD_PER_ARCSEC, SPEED_OF_LIGHT_KM_S};
use glam::DVec3;
use serde_json::json;

/// A vector of any length in the apparent direction of a body, ICRF, from the scene of a view from the Earth's centre; zero if the scene lacks the body.
fn direction_in_scene(session: &Session, body: NaifId, time: Instant) -> Result<DVec3, SessionError> {
    let request = ViewRequest { position: Position::Centre(NaifId::EARTH), width: 16, height: 16, ..ViewRequest::of(body, time) };
    Ok(session.scene(&request)?.body(body).map_or(DVec3::ZERO, |b| b.placement.centre_km))
}

/// The apparent direction of a body from the Earth's centre, ICRF: light time by bisection, then relativistic aberration.
fn direction_by_bisection(session: &Session, body: NaifId, time: Instant) -> Result<DVec3, SessionError> {
    let ephemeris = session.ephemeris();
    let state = |body, time| ephemeris.state(body, NaifId::SOLAR_SYSTEM_BARYCENTER, time, BEST_SOURCE).map(|s| s.state);
    let observer = state(NaifId::EARTH, time)?;
    // Light travels 80 au in 40 000 s. All bodies of the shipped catalogs are nearer.
    let (mut low_s, mut high_s) = (0.0, 40_000.0);
    // To a microsecond, during which a body moves by less than 0.1 m.
    while high_s - low_s > 1e-6 {
        let middle_s = 0.5 * (low_s + high_s);
        let light_time_s = (state(body, time.plus_seconds(-middle_s))?.pos_km - observer.pos_km).length() / SPEED_OF_LIGHT_KM_S;
        if light_time_s > middle_s { low_s = middle_s } else { high_s = middle_s }
    }
    let seen = (state(body, time.plus_seconds(-low_s))?.pos_km - observer.pos_km).normalize();
    // Lorentz transformation of the direction towards the body.
    let beta = observer.vel_km_s / SPEED_OF_LIGHT_KM_S;
    let gamma = 1.0 / (1.0 - beta.length_squared()).sqrt();
    Ok((seen / gamma + beta * (1.0 + gamma / (1.0 + gamma) * beta.dot(seen))) / (1.0 + beta.dot(seen)))
}

/// Directions of all bodies from the Earth's centre, from 1901 to 2088 (full) or in 1901 and 1999 (short). Instants that the ephemeris does not cover are
/// skipped.
pub(super) fn run(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let session = setup.session();
    // The tests of the sweep inject a wrong direction.
    let direction_of = setup.injected_faults.apparent_direction.unwrap_or(direction_in_scene);
    let instant_count = setup.short_or_full(2, 20);
    let bodies = session.catalog().bodies().iter().filter(|b| b.id != NaifId::EARTH);
    for body in bodies {
        for k in 0..instant_count {
            let time = Instant::from_jd_tdb(2_415_500.3 + 72_000.0 * f64::from(k) / f64::from(instant_count));
            let placed = if_possible(direction_of(session, body.id, time))?;
            let expected = if_possible(direction_by_bisection(session, body.id, time))?;
            let (Some(placed), Some(expected)) = (placed, expected) else { continue };
            // A zero vector, such as that of a body that the scene lacks, has no direction, and `angle_rad` would return 0.
            let separation = if placed == DVec3::ZERO { f64::INFINITY } else { angle_rad(placed, expected) / RAD_PER_ARCSEC };
            found.add(separation, || {
                (
                    json!({ "body": body.name, "time": time.to_utc_iso() }),
                    format!("placed {separation:.3} arcsec from its apparent direction"),
                )
            });
        }
    }
    Ok(found)
}
