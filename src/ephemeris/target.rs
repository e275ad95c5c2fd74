//! What an observer looks at: a body or barycentre of the catalog, a minor planet or comet on its orbit about the Sun, or a star's direction.
//!
//! In: a target and an instant. Out: its state, and its position when the light left it. The orbit of a small body is osculating: without perturbations, so
//! that its error is unknown and grows with the time from the epoch of its elements. Of a comet with elements for several apparitions, the nearest count.

use super::conic::heliocentric_state;
use super::{BEST_SOURCE, Ephemeris, EphemerisError, Source, SourcedState, State};
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

    /// The position of `body` whose light reaches `observer_pos_km` (barycentric ICRF) at `t`: the barycentric position at the time of emission, and that
    /// time.
    ///
    /// # Errors
    /// As [`Self::state`]. An error whose time is earlier than `t` says that the light left at that time.
    pub fn light_time_position(&self, body: NaifId, observer_pos_km: DVec3, t: Instant) -> Result<(DVec3, Instant), EphemerisError> {
        self.target_light_time_position(Target::Body(body), observer_pos_km, t)
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
        let mut emitted = match target {
            Target::Body(body) => self.emission_time_of_system(body, observer_pos_km, t).unwrap_or(t),
            Target::SmallBody(_) | Target::Direction(_) => t,
        };
        // Each round multiplies the error by v/c, which is under 1e-3 for bodies of the catalog and under 3e-3 for a comet that grazes the Sun, so that six
        // rounds always suffice. The last correction, of less than a second, is made along the velocity, which leaves 6 metres at most (Metis, whose path
        // curves most of those of the catalog; tests/ephemeris/positions.rs), 140 metres for a comet at the Sun's surface.
        for round in 0.. {
            let found = self.target_state(target, NaifId::SOLAR_SYSTEM_BARYCENTER, emitted, BEST_SOURCE);
            if found.is_err() && round == 0 && emitted != t {
                emitted = t;
                continue;
            }
            let found = if emitted == t { found } else { found.map_err(EphemerisError::when_light_left) };
            let state = found?.state;
            let light_s = (state.pos_km - observer_pos_km).length() / SPEED_OF_LIGHT_KM_S;
            let next = t.plus_seconds(-light_s);
            let correction_s = next.tdb_seconds_past_j2000() - emitted.tdb_seconds_past_j2000();
            emitted = next;
            if correction_s.abs() < 1.0 || round == 5 {
                return Ok((state.pos_km + state.vel_km_s * correction_s, emitted));
            }
        }
        unreachable!("the loop returns in its sixth round")
    }

    /// When light that reaches the observer at `t` left the barycentre of a planet's or moon's system, whose position takes less work than a moon's.
    fn emission_time_of_system(&self, body: NaifId, observer_pos_km: DVec3, t: Instant) -> Option<Instant> {
        // The NAIF code of a planet or moon is 100 times that of its system's barycentre, plus a number below 100.
        let system = (101..1000).contains(&body.0).then_some(NaifId(body.0 / 100))?;
        let State { pos_km, vel_km_s } = self.state(system, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE).ok()?.state;
        let light_s_from = |pos_km: DVec3| (pos_km - observer_pos_km).length() / SPEED_OF_LIGHT_KM_S;
        let light_s = light_s_from(pos_km - vel_km_s * light_s_from(pos_km));
        // At more than 300 s of light time the observer is certainly in another system.
        (light_s > 300.0).then(|| t.plus_seconds(-light_s))
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
                ephemeris.target_state(target, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE).expect("in range").state
            };
            let earth_km = state(NaifId::EARTH.into(), t).pos_km;
            let (found_km, emitted) = ephemeris.target_light_time_position((&named).into(), earth_km, t).expect("in range");
            let light_s = (found_km - earth_km).length() / SPEED_OF_LIGHT_KM_S;
            let elapsed_s = t.tdb_seconds_past_j2000() - emitted.tdb_seconds_past_j2000();
            // The last correction of the time of emission is under a second; it changes the light time by v/c of that.
            assert!((light_s - elapsed_s).abs() < 3e-4, "{name}: {light_s} {elapsed_s}");
            assert!(state((&named).into(), emitted).pos_km.distance(found_km) < 1e-3, "{name}");
            let late_km = state((&named).into(), t).pos_km.distance(found_km);
            assert!(late_km > 1e3, "{name}: without light time it would be only {late_km} km off");
        }
    }
}
