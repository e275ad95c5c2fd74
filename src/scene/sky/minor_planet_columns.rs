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
    /// Velocity at the perihelion in au per unit of the shader's time (ICRF; its length is sqrt(1 + e) perihelion distances), and the irradiance at full phase,
    /// 1 au from Sun and viewer: four numbers per body.
    pub perihelion_velocity: Arc<Vec<f32>>,
    /// Slope parameter G of the H,G law.
    pub slope: Arc<Vec<f32>>,
    /// Timing of each orbit, in f64.
    timings: Arc<Vec<OrbitTiming>>,
}

/// Timing of an orbit: a perihelion passage in days past J2000, the length in days of the shader's unit of time, and half the period in that unit. The unit
/// is the time in which the mean anomaly of an orbit with the semi-major axis q, the perihelion distance, increases by one radian.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OrbitTiming {
    passage_days: f64,
    days_per_unit: f64,
    half_period: f64,
}

impl OrbitTiming {
    fn of(orbit: &HeliocentricOrbit) -> Self {
        let (q, one_minus_e) = (orbit.perihelion_au, 1.0 - orbit.eccentricity);
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
                BrightnessLaw::Comet { .. } | BrightnessLaw::Unknown => (0.0, 0.0),
            };
            perihelion.extend(narrow(orbit.to_perihelion * orbit.perihelion_au).to_array());
            perihelion.push(narrow_scalar(1.0 - orbit.eccentricity));
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

    /// For centuries, reduced times stay within half a period, and differ from the full time by a whole number of periods.
    #[test]
    fn times_are_reduced_by_whole_turns() {
        let orbit = |q: f64, e: f64| HeliocentricOrbit {
            perihelion_au: q,
            eccentricity: e,
            to_perihelion: DVec3::X,
            motion_at_perihelion: DVec3::Y,
            passage_days: 8375.25,
        };
        for (q, e) in [(2.5, 0.08), (0.587, 0.967), (0.3, 0.9992), (1.0, 0.0)] {
            let timing = OrbitTiming::of(&orbit(q, e));
            let period_days = TAU / GAUSS_CONSTANT * (q / (1.0 - e)).powf(1.5);
            for days in [-700_000.0, -3.5, 8375.25, 9000.0, 812_345.6] {
                let t = timing.since_passage(days);
                assert!(t.abs() <= timing.half_period * (1.0 + 1e-12), "{q} {e} {days}: {t}");
                let turns = ((days - 8375.25) - t * timing.days_per_unit) / period_days;
                assert!((turns - turns.round()).abs() < 1e-9, "{turns}");
            }
        }
        // An open orbit has no period.
        let open = OrbitTiming::of(&orbit(1.0, 1.2));
        assert!((open.since_passage(8375.25 + 1e5) * open.days_per_unit - 1e5).abs() < 1e-6);
    }
}
