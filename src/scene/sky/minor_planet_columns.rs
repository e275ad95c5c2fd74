//! Vertex data of shaders/entry/minor_planets.wesl: columns that do not change from frame to frame, and each body's time since its perihelion.
//!
//! In: the orbits of small bodies, and a time. Out: [`MinorPlanetColumns`]. Always: times are reduced in f64 to at most half a period before they are narrowed.

use crate::catalog::small_bodies::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, SmallBody};
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::light::photometry::irradiance_of_magnitude;
use std::f64::consts::PI;
use std::sync::Arc;

/// The columns that do not change from frame to frame, one row per body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MinorPlanetColumns {
    /// Vector from the Sun to the perihelion, au, ICRF, and 1 - e: four numbers per body.
    pub perihelion: Arc<Vec<f32>>,
    /// Velocity at the perihelion, au per unit of the shader's time (see `OrbitTiming`), ICRF, and the irradiance by the body at full phase, 1 au from Sun and
    /// viewer (1: that by the Sun at 1 au): four numbers per body.
    pub perihelion_velocity: Arc<Vec<f32>>,
    /// Slope parameter G of the H,G law.
    pub slope: Arc<Vec<f32>>,
    /// The timing of each orbit.
    timings: Arc<Vec<OrbitTiming>>,
}

/// Timing of an orbit with the perihelion distance q and the eccentricity e. The shader's unit of time, in which q and the Sun's GM are 1, is sqrt(q^3 / GM).
#[derive(Clone, Copy, Debug, PartialEq)]
struct OrbitTiming {
    /// A perihelion passage, days past J2000 (TDB).
    passage_days: f64,
    days_per_unit: f64,
    /// Half the period, in the shader's unit; infinite for an open orbit.
    half_period: f64,
}

impl OrbitTiming {
    fn of(orbit: &HeliocentricOrbit) -> Self {
        let (q, one_minus_e) = (orbit.perihelion_au, 1.0 - orbit.eccentricity);
        // Kepler's third law; the semi-major axis is 1 / (1 - e) perihelion distances.
        let half_period = if one_minus_e > 0.0 { PI * one_minus_e.powf(-1.5) } else { f64::INFINITY };
        Self { passage_days: orbit.passage_days, days_per_unit: q.powf(1.5) / GAUSS_CONSTANT, half_period }
    }

    /// Time since the nearest perihelion passage, negative before it, in the shader's unit. `days`: past J2000.
    fn since_passage(&self, days: f64) -> f64 {
        let t = (days - self.passage_days) / self.days_per_unit;
        if self.half_period.is_finite() { t - 2.0 * self.half_period * (0.5 * t / self.half_period).round() } else { t }
    }
}

impl MinorPlanetColumns {
    pub(crate) fn of(bodies: &[SmallBody]) -> Self {
        let (mut perihelion, mut perihelion_velocity) = (Vec::with_capacity(4 * bodies.len()), Vec::with_capacity(4 * bodies.len()));
        let mut slope = Vec::with_capacity(bodies.len());
        for body in bodies {
            let orbit = &body.orbit;
            let (irradiance, g) = match body.brightness {
                BrightnessLaw::Asteroid { h, g } => (irradiance_of_magnitude(h), g),
                // A minor planet without a magnitude counts as too faint to see. Comets are drawn by `scene::sky::comets`.
                BrightnessLaw::Comet { .. } | BrightnessLaw::Unknown => (0.0, 0.0),
            };
            perihelion.extend(narrow(orbit.to_perihelion * orbit.perihelion_au).to_array());
            perihelion.push(narrow_scalar(1.0 - orbit.eccentricity));
            // The speed at the perihelion is sqrt((1 + e) GM / q), in the shader's unit q sqrt(1 + e).
            let velocity = orbit.motion_at_perihelion * (orbit.perihelion_au * (1.0 + orbit.eccentricity).sqrt());
            perihelion_velocity.extend(narrow(velocity).to_array());
            perihelion_velocity.push(narrow_scalar(irradiance));
            slope.push(narrow_scalar(g));
        }
        let timings = bodies.iter().map(|b| OrbitTiming::of(&b.orbit)).collect();
        Self {
            perihelion: Arc::new(perihelion),
            perihelion_velocity: Arc::new(perihelion_velocity),
            slope: Arc::new(slope),
            timings: Arc::new(timings),
        }
    }

    /// Time of each body since its nearest perihelion passage, in the shader's unit. `days`: past J2000.
    pub(crate) fn times(&self, days: f64) -> Vec<f32> {
        self.timings.iter().map(|timing| narrow_scalar(timing.since_passage(days))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::TAU;

    /// For about two thousand years before and after J2000, reduced times stay within half a period and differ from the full time by whole periods.
    #[test]
    fn times_are_reduced_by_whole_turns() {
        const PASSAGE_DAYS: f64 = 8375.25;
        let orbit = |q: f64, e: f64| HeliocentricOrbit {
            perihelion_au: q,
            eccentricity: e,
            to_perihelion: DVec3::X,
            motion_at_perihelion: DVec3::Y,
            passage_days: PASSAGE_DAYS,
        };
        // Perihelion distance in au and eccentricity of closed orbits, from circular to nearly parabolic.
        for (q, e) in [(2.5, 0.08), (0.587, 0.967), (0.3, 0.9992), (1.0, 0.0)] {
            let timing = OrbitTiming::of(&orbit(q, e));
            let period_days = TAU / GAUSS_CONSTANT * (q / (1.0 - e)).powf(1.5);
            for days in [-700_000.0, -3.5, PASSAGE_DAYS, 9000.0, 812_345.6] {
                let t = timing.since_passage(days);
                assert!(t.abs() <= timing.half_period * (1.0 + 1e-12), "{q} {e} {days}: {t}");
                let turns = ((days - PASSAGE_DAYS) - t * timing.days_per_unit) / period_days;
                assert!((turns - turns.round()).abs() < 1e-9, "{turns}");
            }
        }
        // An open orbit has no period.
        let open = OrbitTiming::of(&orbit(1.0, 1.2));
        assert!((open.since_passage(PASSAGE_DAYS + 1e5) * open.days_per_unit - 1e5).abs() < 1e-6);
    }
}
