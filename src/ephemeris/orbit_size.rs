//! Size and period of a body's orbit about its parent.
//!
//! In: the catalog and the ephemeris; for the osculating period also an instant. Out: kilometres and seconds. Always: the semi-major axis and the sidereal
//! period do not depend on the displayed instant. Not here: the other elements of the orbit.

use super::conic::ConicState;
use super::{BEST_SOURCE, Ephemeris};
use crate::catalog::{Body, BodyKind, Catalog, Motion};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use std::f64::consts::TAU;

/// [`sidereal_period_s`] measures over 1, 2, 4, ... revolutions, doubled this many times.
const DOUBLINGS: u32 = 10;

/// The state of a body relative to its parent, km and km/s, and the sum of their GMs if the catalog has the parent's (0 stands for a missing one of the body).
/// `None` for a body without a parent in the catalog or one that the ephemeris cannot place.
fn orbit_at(catalog: &Catalog, ephemeris: &Ephemeris, body: &Body, time: Instant) -> Option<(ConicState, Option<f64>)> {
    let parent = catalog.body(body.parent?)?;
    let state = ephemeris.state(body.id, parent.id, time, BEST_SOURCE).ok()?.state;
    let gm_km3_s2 = parent.gm_km3_s2.map(|gm| gm + body.gm_km3_s2.unwrap_or(0.0));
    Some((ConicState { position: state.pos_km, velocity: state.vel_km_s }, gm_km3_s2))
}

/// Semi-major axis of the orbit about the parent: that of the catalog's elements; without elements, by the vis-viva equation from the state at J2000; without
/// the parent's GM or for an unbound orbit, the distance at J2000. `None` for a body without a parent in the catalog or one that the ephemeris cannot place.
pub fn semi_major_axis_km(catalog: &Catalog, ephemeris: &Ephemeris, body: &Body) -> Option<f64> {
    if let Motion::MeanElements(elements) = &body.motion {
        return Some(elements.semi_major_axis_km);
    }
    let (orbit, gm_km3_s2) = orbit_at(catalog, ephemeris, body, Instant::from_tdb_seconds_past_j2000(0.0))?;
    let axis_km = gm_km3_s2.map(|gm| gm / orbit.gm_over_semi_major_axis(gm)).filter(|a| a.is_finite() && *a > 0.0);
    Some(axis_km.unwrap_or(orbit.position.length()))
}

/// Period of the ellipse about the parent on which the body would stay without perturbations, from its state at `time`. For a moon it differs from the
/// mean period by up to 2 percent; see [`sidereal_period_s`]. `None` without the parent's GM, for an unbound orbit, and as for [`semi_major_axis_km`].
pub fn osculating_period_s(catalog: &Catalog, ephemeris: &Ephemeris, body: &Body, time: Instant) -> Option<f64> {
    let (orbit, gm_km3_s2) = orbit_at(catalog, ephemeris, body, time)?;
    orbit.period(gm_km3_s2?)
}

/// Mean time in which a moon revolves once relative to the stars: from the mean motion of the catalog's elements, else measured over 1024 revolutions from
/// J2000. Error: at most 5e-5 of the period for the moons of the test below; 3.3e-5 for the Moon, the largest. The function evaluates a dozen states: call it
/// once, not per frame. `None` for a body that is not a moon, and for a moon that the ephemeris cannot place over this span, such as one from a short kernel.
pub fn sidereal_period_s(catalog: &Catalog, ephemeris: &Ephemeris, moon: &Body) -> Option<f64> {
    if moon.kind != BodyKind::Moon {
        return None;
    }
    if let Motion::MeanElements(elements) = &moon.motion {
        return Some(360.0 / elements.mean_motion_deg_day * SECONDS_PER_DAY);
    }
    let state_at = |tdb_s: f64| Some(orbit_at(catalog, ephemeris, moon, Instant::from_tdb_seconds_past_j2000(tdb_s))?.0);
    let start = state_at(0.0)?;
    let pole = start.position.cross(start.velocity).try_normalize()?;
    let mut period_s = osculating_period_s(catalog, ephemeris, moon, Instant::from_tdb_seconds_past_j2000(0.0))?;
    for doubling in 0..=DOUBLINGS {
        let revolutions = f64::from(1_u32 << doubling);
        let end = state_at(revolutions * period_s)?.position;
        // Revolutions beyond whole ones, -0.5 to 0.5: unambiguous, because each doubling starts from a period good enough for the next. The largest excess of
        // a shipped moon is 0.1 (Hyperion).
        let excess = pole.dot(start.position.cross(end)).atan2(start.position.dot(end)) / TAU;
        period_s *= revolutions / (revolutions + excess);
    }
    Some(period_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::units::KM_PER_AU;

    /// The semi-major axis from one state differs from the mean axis by the size of the perturbations. Mean axes: Mars 1.523 71 au and Jupiter 5.202 89 au
    /// (Standish 1992), the Moon 384 400 km. 2 % is more than these perturbations.
    #[test]
    fn an_orbit_known_by_its_state_has_its_published_axis() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        for (id, published_km) in [(499, 1.523_71 * KM_PER_AU), (599, 5.202_89 * KM_PER_AU), (301, 384_400.0)] {
            let ours = semi_major_axis_km(&catalog, &ephemeris, catalog.body(NaifId(id)).expect("a body")).expect("an orbit");
            assert!((ours / published_km - 1.0).abs() < 0.02, "{id}: {ours} against {published_km}");
        }
        assert_eq!(semi_major_axis_km(&catalog, &ephemeris, catalog.body(NaifId::SUN).expect("the Sun")), None);
    }

    /// Sidereal periods in days of NASA's fact sheets, quoted from memory. Moons with theories come first, then those with elements; Triton is retrograde.
    /// Another reference: `tests/ephemeris/satellites.rs`. In order: the Moon, Io, Callisto, Mimas, Titan, Hyperion, Iapetus, Phobos, Triton, Charon.
    #[test]
    fn moons_have_their_published_sidereal_periods() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let j2000 = Instant::from_tdb_seconds_past_j2000(0.0);
        for (id, published_days) in [
            (301, 27.321_66),
            (501, 1.769_138),
            (504, 16.689_018),
            (601, 0.942_422),
            (606, 15.945_421),
            (607, 21.276_61),
            (608, 79.330_18),
            (401, 0.318_91),
            (801, 5.876_854),
            (901, 6.387_2),
        ] {
            let moon = catalog.body(NaifId(id)).expect("a moon");
            let error = |period_s: Option<f64>| (period_s.expect("a period") / (published_days * SECONDS_PER_DAY) - 1.0).abs();
            let ours = error(sidereal_period_s(&catalog, &ephemeris, moon));
            assert!(ours < 5e-5, "{id}: {ours}");
            // Negative control: the osculating period of a moon with a theory.
            let osculating = error(osculating_period_s(&catalog, &ephemeris, moon, j2000));
            assert!(osculating > 5e-5 || matches!(moon.motion, Motion::MeanElements(_)), "{id}: {osculating}");
        }
        for id in [NaifId::SUN, NaifId::EARTH] {
            assert_eq!(sidereal_period_s(&catalog, &ephemeris, catalog.body(id).expect("a body")), None);
        }
    }
}
