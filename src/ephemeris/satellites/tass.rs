//! TASS 1.7 of Mimas, Enceladus, Tethys, Dione, Rhea, Titan, Iapetus and Hyperion (Vienne & Duriez 1995, A&A 297, 588; Hyperion: Duriez &
//! Vienne 1997, A&A 324, 366).
//!
//! Time: TT days past JD 2444240.0. Frame: Saturn's equator of the theory; the table's matrix
//! leads to the ecliptic of J2000, and the obliquity of VSOP87 to ICRF (the frames' remaining offset is under 0.1 arcsec: 2 km at Iapetus).
//! Each element is a sum of groups; a group's terms share an integer combination of the moons' slow longitude variations. Those variations
//! are the first group of each moon's longitude series, so they are summed first, for all moons that the groups name.
//!
//! A frame asks for each moon some thirty times within seconds, and a sum takes some 40 000 instructions. So the six elements, which change slowly, are
//! interpolated by polynomials over a quarter of the moon's period; a state then agrees with the sums to 2 mm (tested below). The stretches lie on a fixed
//! grid, so that a result does not depend on earlier calls.

use super::{Elements, Term, tt_days_past};
use crate::ephemeris::{State, chebyshev};
use crate::time::Instant;
use glam::{DMat3, DVec2, DVec3};
use parking_lot::Mutex;
use serde::Deserialize;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Number of terms of a polynomial, and the part of a period that it covers.
const TERMS: usize = 12;
const PERIODS: f64 = 0.25;
/// Maximum number of kept polynomials, half a kilobyte each; when it is exceeded, all are dropped.
const MAX_KEPT: usize = 4096;

const EPOCH_JD_TT: f64 = 2_444_240.0;
/// Angle between the equator and the ecliptic of J2000 in VSOP87 (Bretagnon & Francou 1988), degrees: 23°26'21.4091".
const OBLIQUITY_DEG: f64 = 23.0 + 26.0 / 60.0 + 21.4091 / 3600.0;
/// Moons whose slow longitude variation enters the others' arguments; Hyperion, the eighth, enters none.
const DRIVING_MOONS: usize = 7;

#[derive(Debug, Deserialize)]
struct Table {
    /// Matrix elements, row by row.
    to_vsop87_ecliptic_j2000: [f64; 9],
    bodies: [Moon; 8],
}

/// Integer multiples of the eight longitude variations, and the terms that they shift.
#[derive(Debug, Deserialize)]
struct Group([i32; 8], Vec<Term>);

#[derive(Debug, Deserialize)]
struct Moon {
    /// GM of Saturn and the moon, au³ per day².
    mu: f64,
    /// Mean value of the mean motion, radians a day.
    aam: f64,
    /// Constant parts of the mean motion (relative), longitude, e cos ϖ, e sin ϖ, sin(I/2) cos Ω, sin(I/2) sin Ω.
    s0: [f64; 6],
    /// Series of the mean motion (relative, cosines), longitude (sines), e·exp(iϖ), sin(I/2)·exp(iΩ).
    series: [Vec<Group>; 4],
}

/// The eight moons' series.
#[derive(Debug)]
pub struct Tass17 {
    moons: [Moon; 8],
    icrf_from_frame: DMat3,
    /// Which driving moons each moon's arguments name, so that the others' variations are not summed.
    driven_by: [[bool; DRIVING_MOONS]; 8],
    /// Polynomials of the elements, keyed by moon and number of the stretch.
    kept: Mutex<HashMap<(usize, i64), Arc<Polynomials>>>,
}

/// Chebyshev coefficients of mean motion, longitude less its mean motion, and eccentricity; then of inclination.
type Polynomials = [[Vec<f64>; 3]; 2];

impl Moon {
    /// Elements from the sums of [`Tass17::sums`].
    fn elements(&self, days: f64, [mean_motion_per_day, longitude, ex, ey, ix, iy]: [f64; 6]) -> Elements {
        Elements {
            semi_major_axis_au: (self.mu / (mean_motion_per_day * mean_motion_per_day)).cbrt(),
            mean_motion_per_day,
            mean_longitude_rad: longitude + self.aam * days,
            eccentricity: DVec2::new(ex, ey),
            inclination: DVec2::new(ix, iy),
        }
    }
}

impl Tass17 {
    pub(super) fn parse(json: &str) -> Result<Self, serde_json::Error> {
        let table: Table = serde_json::from_str(json)?;
        let ecliptic_from_frame = DMat3::from_cols_array(&table.to_vsop87_ecliptic_j2000).transpose();
        let icrf_from_ecliptic = DMat3::from_rotation_x(OBLIQUITY_DEG.to_radians());
        let driven_by = std::array::from_fn(|i| {
            let groups = || table.bodies[i].series.iter().flatten();
            // A moon's own variation is part of its longitude, whether a group names it or not.
            std::array::from_fn(|j| i == j || groups().any(|g| g.0[j] != 0))
        });
        Ok(Self { moons: table.bodies, icrf_from_frame: icrf_from_ecliptic * ecliptic_from_frame, driven_by, kept: Mutex::default() })
    }

    /// State relative to Saturn's centre; index 0 Mimas to 5 Titan, 6 Iapetus, 7 Hyperion; `None` for another.
    pub fn state(&self, index: usize, t: Instant) -> Option<State> {
        let moon = self.moons.get(index)?;
        let days = tt_days_past(t, EPOCH_JD_TT);
        let radius_days = 0.5 * PERIODS * TAU / moon.aam;
        let number = (days / (2.0 * radius_days)).floor();
        let middle_days = (2.0 * number + 1.0) * radius_days;
        let key = (index, number as i64);
        let known = self.kept.lock().get(&key).cloned();
        let polynomials = known.unwrap_or_else(|| {
            // Computed without the lock, so that other threads are not blocked. Two threads that compute the same stretch get the same numbers.
            let made = Arc::new(self.polynomials(index, moon, middle_days, radius_days));
            let mut kept = self.kept.lock();
            if kept.len() >= MAX_KEPT {
                kept.clear();
            }
            kept.insert(key, Arc::clone(&made));
            made
        });
        let u = (days - middle_days) / radius_days;
        let [first, second] = polynomials.each_ref().map(|axes| axes.each_ref().map(|c| chebyshev::value_and_slope(c, u).0));
        Some(moon.elements(days, [first[0], first[1], first[2], second[0], second[1], second[2]]).state(&self.icrf_from_frame))
    }

    fn polynomials(&self, index: usize, moon: &Moon, middle_days: f64, radius_days: f64) -> Polynomials {
        // The nodes are the same for both, so that the sums are evaluated once.
        let sums = chebyshev::nodes(TERMS).map(|u| self.sums(index, moon, middle_days + u * radius_days)).collect::<Vec<_>>();
        let fit = |from: usize| chebyshev::fit(&sums.iter().map(|s| DVec3::from_slice(&s[from..from + 3])).collect::<Vec<_>>());
        [fit(0), fit(3)]
    }

    /// Mean motion in radians a day, mean longitude less `aam` times the days, e (cos ϖ, sin ϖ), sin(I/2) (cos Ω, sin Ω).
    fn sums(&self, index: usize, moon: &Moon, days: f64) -> [f64; 6] {
        let slow = self.slow_variations(index, days);
        let sum = |groups: &[Group]| {
            let of_group = |group: &Group| {
                let shift: f64 = group.0.iter().zip(slow).map(|(&times, variation)| f64::from(times) * variation).sum();
                group.1.iter().map(|term| term.at(days, shift)).sum::<DVec2>()
            };
            groups.iter().map(of_group).sum::<DVec2>()
        };
        let [motion, longitude, eccentricity, inclination] = &moon.series;
        // The slow variation of a driving moon is its first group: already summed.
        let (own_slow, longitude) =
            if index < DRIVING_MOONS { (slow[index], longitude.get(1..).unwrap_or_default()) } else { (0.0, &longitude[..]) };
        let s0 = moon.s0;
        let (eccentricity, inclination) = (sum(eccentricity), sum(inclination));
        [
            moon.aam * (1.0 + s0[0] + sum(motion).x),
            s0[1] + own_slow + sum(longitude).y,
            s0[2] + eccentricity.x,
            s0[3] + eccentricity.y,
            s0[4] + inclination.x,
            s0[5] + inclination.y,
        ]
    }

    /// Slow longitude variations in radians, of the driving moons that this one's arguments name; 0 for the others.
    fn slow_variations(&self, index: usize, days: f64) -> [f64; 8] {
        let mut slow = [0.0; 8];
        for (j, named) in self.driven_by[index].iter().enumerate() {
            if *named && let Some(first) = self.moons[j].series[1].first() {
                slow[j] = first.1.iter().map(|term| term.at(days, 0.0).y).sum();
            }
        }
        slow
    }
}

/// Bound of the error, km. It was not measured, because no newer solution of Saturn's moons was at hand. Tests verify that the sums are correct to
/// metres and that the moons face Saturn (tests/ephemeris/satellites.rs). More than a century from 2000 the bound grows, but it never exceeds the
/// orbit's width.
pub fn error_km(index: usize, t: Instant) -> f64 {
    let within_km = [400.0, 300.0, 300.0, 300.0, 300.0, 300.0, 800.0, 1500.0].get(index).copied().unwrap_or(1500.0);
    let orbits_km = [186_000.0, 238_000.0, 295_000.0, 377_000.0, 527_000.0, 1_222_000.0, 3_561_000.0, 1_481_000.0];
    (within_km * super::growth(t, 100.0)).min(2.2 * orbits_km.get(index).copied().unwrap_or(3_561_000.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::satellites::MoonTheories;

    #[test]
    fn polynomials_agree_with_the_sums() {
        let theory = MoonTheories::embedded().expect("embedded").saturn;
        for (index, moon) in theory.moons.iter().enumerate() {
            let (mut largest, mut speed) = (0.0_f64, 0.0_f64);
            for k in 0..400 {
                // Steps of an irrational part of a stretch, from 1950 to 2050 and beyond.
                let t = Instant::from_tdb_seconds_past_j2000(f64::from(k - 200) * 8.0e6 + f64::from(k * k) * 1234.567);
                let days = tt_days_past(t, EPOCH_JD_TT);
                let exact = moon.elements(days, theory.sums(index, moon, days)).state(&theory.icrf_from_frame);
                let state = theory.state(index, t).expect("a moon");
                largest = largest.max((state.pos_km - exact.pos_km).length());
                speed = speed.max((state.vel_km_s - exact.vel_km_s).length());
            }
            assert!(largest < 2e-6 && speed < 1e-9, "{index}: {largest:e} km, {speed:e} km/s");
        }
        assert_eq!(theory.state(8, Instant::from_tdb_seconds_past_j2000(0.0)), None);
    }

    #[test]
    fn results_do_not_depend_on_earlier_calls() {
        let times = [0.0, 1e4, -3e8, 1e4, 2.5e9].map(Instant::from_tdb_seconds_past_j2000);
        let forth = MoonTheories::embedded().expect("embedded").saturn;
        let back = MoonTheories::embedded().expect("embedded").saturn;
        let mut of_back: Vec<_> = times.iter().rev().map(|t| back.state(0, *t)).collect();
        of_back.reverse();
        assert_eq!(times.iter().map(|t| forth.state(0, *t)).collect::<Vec<_>>(), of_back);
    }
}
