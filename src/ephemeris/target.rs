//! What an observer looks at: a body or barycentre of the catalog, a minor planet or comet on its orbit about the Sun, or a star's direction.
//!
//! In: a target and an instant. Out: its state, and its position when the light left it. The orbit of a small body is osculating: without perturbations, so
//! that its error is unknown and grows with the time from the epoch of its elements. Of a comet with elements for several apparitions, the nearest count.

use super::conic::heliocentric_state;
use super::{Ephemeris, EphemerisError, Source, SourcedState, State};
use crate::catalog::NaifId;
use crate::catalog::small_bodies::{NamedTarget, SmallBody};
use crate::time::Instant;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use glam::DVec3;

/// Something in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target<'a> {
    /// A body or barycentre.
    Body(NaifId),
    /// A minor planet or comet.
    SmallBody(&'a SmallBody),
    /// The direction of a star: a unit vector, ICRF. A star has an altitude, but no position.
    Direction(DVec3),
}

impl From<NaifId> for Target<'_> {
    fn from(id: NaifId) -> Self {
        Self::Body(id)
    }
}

impl<'a> From<&'a NamedTarget> for Target<'a> {
    fn from(named: &'a NamedTarget) -> Self {
        match named {
            NamedTarget::Body(id) => Self::Body(*id),
            NamedTarget::SmallBody(body) => Self::SmallBody(body),
        }
    }
}

/// Largest change of the time of emission, seconds, at which its iteration ends: a comet at its fastest moves by less than a metre in this time.
const EMISSION_TOLERANCE_S: f64 = 1e-6;
/// Largest number of iterations. Each multiplies the error by v/c, under 3e-3 for a comet that grazes the Sun.
const MAX_EMISSION_ROUNDS: u32 = 10;

impl Ephemeris {
    /// As [`Self::state`], also for small bodies: their source is [`Source::Mean`] whatever `source`, which then applies to the Sun and the centre; the bound
    /// of their error is infinite.
    ///
    /// # Errors
    /// As [`Self::state`]; also for a direction, which has no position.
    pub fn target_state(
        &self,
        target: Target<'_>,
        center: NaifId,
        t: Instant,
        source: Option<Source>,
    ) -> Result<SourcedState, EphemerisError> {
        let small_body = match target {
            Target::Body(body) => return self.state(body, center, t, source),
            Target::SmallBody(small_body) => small_body,
            Target::Direction(_) => return Err(EphemerisError::other("a star's direction is no position")),
        };
        let sun = self.state(NaifId::SUN, center, t, source)?;
        let days = t.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
        let heliocentric = heliocentric_state(small_body.orbit_at(days), days);
        let from_sun = State { pos_km: heliocentric.position * KM_PER_AU, vel_km_s: heliocentric.velocity * (KM_PER_AU / SECONDS_PER_DAY) };
        Ok(SourcedState { state: from_sun.plus(sun.state), source: Source::Mean, error_km: f64::INFINITY })
    }

    /// As [`Self::light_time_position`], also for small bodies.
    ///
    /// # Errors
    /// As [`Self::light_time_position`]; also for a direction, which has no position.
    pub fn target_light_time_position(
        &self,
        target: Target<'_>,
        observer_pos_km: DVec3,
        t: Instant,
    ) -> Result<(DVec3, Instant), EphemerisError> {
        if let Target::Body(body) = target {
            return self.light_time_position(body, observer_pos_km, t);
        }
        let mut emitted = t;
        for round in 0.. {
            let found = self.target_state(target, NaifId::SOLAR_SYSTEM_BARYCENTER, emitted, super::BEST_SOURCE);
            let found = if emitted == t { found } else { found.map_err(EphemerisError::when_light_left) };
            let pos_km = found?.state.pos_km;
            let next = t.plus_seconds(-(pos_km - observer_pos_km).length() / SPEED_OF_LIGHT_KM_S);
            let correction_s = next.tdb_seconds_past_j2000() - emitted.tdb_seconds_past_j2000();
            if correction_s.abs() < EMISSION_TOLERANCE_S || round == MAX_EMISSION_ROUNDS {
                return Ok((pos_km, emitted));
            }
            emitted = next;
        }
        unreachable!("the loop returns in its last round")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    /// The light of a comet near the Earth and of one far away left it as long ago as light takes for the distance; the place is the geometric one then.
    #[test]
    fn light_of_a_small_body_left_it_a_light_time_ago() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the built-in kernel");
        for (name, time) in
            [("C/1996 B2", "1996-03-25T00:00:00Z"), ("Hale-Bopp", "2020-01-01T00:00:00Z"), ("Pallas", "2027-01-01T00:00:00Z")]
        {
            let named = catalog.target_named(name).expect(name);
            let t = Instant::parse(time).expect("a time");
            let state = |target: Target<'_>, t: Instant| {
                ephemeris.target_state(target, NaifId::SOLAR_SYSTEM_BARYCENTER, t, super::super::BEST_SOURCE).expect("in range").state
            };
            let earth_km = state(NaifId::EARTH.into(), t).pos_km;
            let (found_km, emitted) = ephemeris.target_light_time_position((&named).into(), earth_km, t).expect("in range");
            let light_s = (found_km - earth_km).length() / SPEED_OF_LIGHT_KM_S;
            let elapsed_s = t.tdb_seconds_past_j2000() - emitted.tdb_seconds_past_j2000();
            // Seconds since J2000 are rounded to 0.1 microseconds.
            assert!((light_s - elapsed_s).abs() < 2e-6, "{name}: {light_s} {elapsed_s}");
            assert!(state((&named).into(), emitted).pos_km.distance(found_km) < 1e-3, "{name}");
            let late_km = state((&named).into(), t).pos_km.distance(found_km);
            assert!(late_km > 1e3, "{name}: without light time it would be only {late_km} km off");
        }
    }
}
