//! Theories of the large moons. In: an instant. Out: a state relative to the planet's centre, ICRF, km and km/s.
//!
//! Both theories (L1.2 of Jupiter's moons, TASS 1.7 of Saturn's) give six elements that are sums of periodic terms: semi-major axis or mean motion, mean
//! longitude λ, eccentricity z = e·exp(iϖ) and inclination ζ = sin(I/2)·exp(iΩ). The elements are osculating, so the velocity is computed as that of two-body
//! motion on them. It differs from the slope of the computed positions by up to 4e-4 of the speed (Callisto), for Hyperion by 1.5e-3.
//! `error_km` of each theory states the error by the periodic terms that its tables lack. No planet's position is needed here.

pub mod drift;
pub mod galilean;
pub mod tass;

use super::time_grid::TimeGrid;
use super::{EphemerisError, State, two_body};
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, KM_PER_AU, SECONDS_PER_DAY};
use glam::{DMat3, DVec2};
use serde::Deserialize;

/// Both theories with their tables.
#[derive(Debug)]
pub struct MoonTheories {
    pub galilean: galilean::GalileanL12,
    pub saturn: tass::Tass17,
}

impl MoonTheories {
    /// The theories from the embedded tables.
    pub fn embedded() -> Result<Self, EphemerisError> {
        let table_error = |file: &str, e: serde_json::Error| EphemerisError::other(format!("{file}: {e}"));
        Ok(Self {
            galilean: galilean::GalileanL12::parse(orrery_catalogs::GALILEAN_THEORY).map_err(|e| table_error("galilean_l12.json", e))?,
            saturn: tass::Tass17::parse(orrery_catalogs::SATURN_THEORY).map_err(|e| table_error("saturn_tass17.json", e))?,
        })
    }
}

/// One periodic term: amplitude, phase (radians) and frequency (radians a day).
#[derive(Clone, Copy, Debug, Deserialize)]
struct Term(f64, f64, f64);

impl Term {
    /// Amplitude times (cos, sin) of the term's angle plus a shift, with its first three derivatives with respect to time in days.
    /// `shift`: the added angle and its three derivatives.
    fn at(&self, days: f64, shift: [f64; 4]) -> Derivatives<DVec2> {
        let Self(amplitude, phase, frequency) = *self;
        let (sin, cos) = (phase + frequency * days + shift[0]).sin_cos();
        let value = DVec2::new(cos, sin) * amplitude;
        let rate = frequency + shift[1];
        let third = value.perp() * (shift[3] - rate * rate * rate) - value * (3.0 * rate * shift[2]);
        Derivatives([value, value.perp() * rate, value.perp() * shift[2] - value * (rate * rate), third])
    }
}

/// A value and its first three derivatives with respect to time in days.
#[derive(Clone, Copy, Debug, Default)]
struct Derivatives<T>([T; 4]);

impl<T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>> Derivatives<T> {
    fn map<U>(self, f: impl Fn(T) -> U) -> Derivatives<U> {
        Derivatives(self.0.map(f))
    }

    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    fn sum(terms: impl Iterator<Item = Self>) -> Self {
        terms.fold(Self::default(), Self::plus)
    }

    /// The value some days later, by the Taylor polynomial.
    fn extrapolated(&self, days: f64) -> T {
        let [value, first, second, third] = self.0;
        value + first * days + second * (0.5 * days * days) + third * (days * days * days / 6.0)
    }
}

/// The sums of a moon's series at an instant.
#[derive(Clone, Copy, Debug)]
struct Sums {
    /// Semi-major axis in au (L1.2), or the relative variation of the mean motion (TASS 1.7).
    semi_major_axis_or_mean_motion: Derivatives<f64>,
    /// Radians, without the secular part of the mean longitude.
    longitude: Derivatives<f64>,
    /// e (cos ϖ, sin ϖ).
    eccentricity: Derivatives<DVec2>,
    /// sin(I/2) (cos Ω, sin Ω).
    inclination: Derivatives<DVec2>,
}

/// Osculating elements of one instant, in au, radians and days.
#[derive(Clone, Copy, Debug)]
struct Elements {
    semi_major_axis_au: f64,
    mean_motion_per_day: f64,
    mean_longitude_rad: f64,
    /// e (cos ϖ, sin ϖ).
    eccentricity: DVec2,
    /// sin(I/2) (cos Ω, sin Ω).
    inclination: DVec2,
}

/// The sums of the moons of one theory at the nodes of a grid. The sums at other instants are extrapolated from the nearest node with three derivatives. Only
/// one node is needed per instant, which suits the search for events: it asks for instants far apart.
#[derive(Debug)]
struct SumsGrid(TimeGrid<usize, Sums>);

impl SumsGrid {
    /// `step_s`: the spacing of the nodes.
    fn with_step(step_s: f64) -> Self {
        Self(TimeGrid::new(step_s))
    }

    /// The sums of moon `index` at the node nearest to `t`, and the days from the node to `t`. `sum` sums the series at an instant.
    fn nearest(&self, index: usize, t: Instant, sum: impl Fn(Instant) -> Sums) -> (Sums, f64) {
        let (sums, seconds) = self.0.nearest(index, t.tdb_seconds_past_j2000(), |tdb_s| sum(Instant::from_tdb_seconds_past_j2000(tdb_s)));
        (sums, seconds / SECONDS_PER_DAY)
    }
}

impl Elements {
    /// The state relative to the planet's centre, ICRF. `icrf_from_frame`: rotation from the frame of the elements.
    fn state(&self, icrf_from_frame: &DMat3) -> State {
        let angle = |v: DVec2| v.y.atan2(v.x);
        let (periapsis, node) = (angle(self.eccentricity), angle(self.inclination));
        let in_frame = two_body::state_in_frame(
            self.semi_major_axis_au * KM_PER_AU,
            self.eccentricity.length(),
            2.0 * self.inclination.length().min(1.0).asin(),
            node,
            periapsis - node,
            self.mean_longitude_rad - periapsis,
            self.mean_motion_per_day / SECONDS_PER_DAY,
        );
        State { pos_km: *icrf_from_frame * in_frame.pos_km, vel_km_s: *icrf_from_frame * in_frame.vel_km_s }
    }
}

/// Factor by which an error bound grows with the date: 1 within `valid_years` of 2000, then growing with the square of the time, which is an assumption.
fn error_growth(t: Instant, valid_years: f64) -> f64 {
    let ratio = (t.tdb_seconds_past_j2000() / (valid_years * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY)).abs().max(1.0);
    ratio * ratio
}

/// TT days past a Julian date, without the rounding of a Julian date in one f64 (40 microseconds: under a metre for Io).
fn tt_days_past(t: Instant, epoch_jd_tt: f64) -> f64 {
    t.tt_seconds_past_j2000() / SECONDS_PER_DAY + (crate::units::JD_J2000 - epoch_jd_tt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_nodes_of_the_grid_moons_are_where_the_series_put_them() {
        let mut theories = MoonTheories::embedded().expect("the shipped tables");
        let mut largest_km = |is_saturn: bool, step_s: f64| {
            theories.galilean.set_step(step_s);
            theories.saturn.set_step(step_s);
            let mut found_km: f64 = 0.0;
            for k in -60..60 {
                let t = Instant::from_tdb_seconds_past_j2000(f64::from(k) * 5.1e7 + 0.5 * step_s);
                for i in 0..if is_saturn { 8 } else { 4 } {
                    let (cached, exact) = match is_saturn {
                        true => (theories.saturn.state(i, t), theories.saturn.state_without_grid(i, t)),
                        false => (theories.galilean.state(i, t), theories.galilean.state_without_grid(i, t)),
                    };
                    found_km = found_km.max(cached.expect("a moon").pos_km.distance(exact.expect("a moon").pos_km));
                }
            }
            found_km
        };
        for (is_saturn, step_s) in [(false, galilean::STEP_S), (true, tass::STEP_S)] {
            let (error_km, coarse_error_km) = (largest_km(is_saturn, step_s), largest_km(is_saturn, 16.0 * step_s));
            assert!(error_km < 2e-5, "{error_km} km");
            assert!(coarse_error_km > 2e-5, "a grid 16 times as coarse exceeds the bound: {coarse_error_km} km");
        }
    }
}
