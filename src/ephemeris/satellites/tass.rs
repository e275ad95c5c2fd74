//! TASS 1.7 of Mimas, Enceladus, Tethys, Dione, Rhea, Titan, Iapetus and Hyperion (Vienne & Duriez 1995, A&A 297, 588; Hyperion: Duriez &
//! Vienne 1997, A&A 324, 366).
//!
//! In: the index of a moon, and an instant. Out: the state relative to Saturn's centre, ICRF. [`error_km`] bounds the position's error.
//!
//! Time: TT days past JD 2444240.0. Frame: Saturn's equator as the theory defines it. The table's matrix converts it to the ecliptic of J2000, and the
//! obliquity of VSOP87 converts that to ICRF (the remaining offset of the frames is under 0.1 arcsec: 2 km at Iapetus).
//!
//! Each element is a sum of groups of periodic terms. The terms of a group have one angle in common, which is added to their arguments: an integer combination
//! of the moons' slow longitude variations. The variation of a moon is the first group of its own longitude series. So these first groups are summed before
//! the others, for all moons whose variations the others need.

use super::{Derivatives, Elements, Sums, SumsGrid, Term, tt_days_past};
use crate::ephemeris::State;
use crate::time::Instant;
use glam::{DMat3, DVec2};
use serde::Deserialize;

const EPOCH_JD_TT: f64 = 2_444_240.0;
/// Spacing of the nodes at which the series are summed, seconds. The error of the extrapolation between them is 0.02 m at most.
pub(super) const STEP_S: f64 = 720.0;
/// Angle between the equator and the ecliptic of J2000 in VSOP87 (Bretagnon & Francou 1988), degrees: 23°26'21.4091".
const OBLIQUITY_DEG: f64 = 23.0 + 26.0 / 60.0 + 21.4091 / 3600.0;
/// Number of driving moons: those whose slow longitude variation is part of the arguments of others. Hyperion, the eighth moon, is not one of them.
const DRIVING_MOON_COUNT: usize = 7;

/// The table; the names of all fields are those of its JSON file.
#[derive(Debug, Deserialize)]
struct Table {
    /// Matrix elements, row by row.
    to_vsop87_ecliptic_j2000: [f64; 9],
    bodies: [Moon; 8],
}

/// Integer multiples of the eight longitude variations, and the terms that they shift.
#[derive(Debug, Deserialize)]
struct Group([i32; 8], Vec<Term>);

/// The constants and series of one moon.
#[derive(Debug, Deserialize)]
struct Moon {
    /// GM of Saturn and the moon, au³ per day².
    mu: f64,
    /// Reference value of the mean motion, radians a day. `s0[0]` and the first series are relative corrections to it.
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
    /// For each moon, the driving moons on whose variations its arguments or its own longitude depend. Only these variations are summed for the moon.
    driven_by: [[bool; DRIVING_MOON_COUNT]; 8],
    /// Caches the sums at evenly spaced instants, from which [`Self::state`] extrapolates.
    grid: SumsGrid,
}

impl Tass17 {
    pub(super) fn parse(json: &str) -> Result<Self, serde_json::Error> {
        let table: Table = serde_json::from_str(json)?;
        let ecliptic_from_frame = DMat3::from_cols_array(&table.to_vsop87_ecliptic_j2000).transpose();
        let icrf_from_ecliptic = DMat3::from_rotation_x(OBLIQUITY_DEG.to_radians());
        let driven_by = std::array::from_fn(|i| {
            let groups = || table.bodies[i].series.iter().flatten();
            // A moon's own variation is part of its longitude, even if no group depends on it.
            std::array::from_fn(|j| i == j || groups().any(|Group(multiples, _)| multiples[j] != 0))
        });
        Ok(Self {
            moons: table.bodies,
            icrf_from_frame: icrf_from_ecliptic * ecliptic_from_frame,
            driven_by,
            grid: SumsGrid::with_step(STEP_S),
        })
    }

    /// State relative to Saturn's centre, ICRF; index 0 Mimas to 5 Titan, 6 Iapetus, 7 Hyperion; `None` for another.
    pub fn state(&self, index: usize, t: Instant) -> Option<State> {
        let moon = self.moons.get(index)?;
        let (sums, days_from_node) = self.grid.nearest(index, t, |node| self.sums(index, moon, tt_days_past(node, EPOCH_JD_TT)));
        Some(Self::elements(moon, t, &sums, days_from_node).state(&self.icrf_from_frame))
    }

    /// The sums of a moon's series, `days` (TT) past the theory's epoch.
    fn sums(&self, index: usize, moon: &Moon, days: f64) -> Sums {
        let variations = self.slow_variations(index, days);
        let sum = |groups: &[Group]| {
            let group_sum = |Group(multiples, terms): &Group| {
                let shift = Derivatives::sum(
                    multiples.iter().zip(variations).map(|(&multiple, variation)| variation.map(|v| f64::from(multiple) * v)),
                );
                Derivatives::sum(terms.iter().map(|term| term.at(days, shift.0)))
            };
            Derivatives::sum(groups.iter().map(group_sum))
        };
        let [mean_motion, longitude, eccentricity, inclination] = &moon.series;
        // The first group of a driving moon's longitude is its slow variation: already summed.
        let (own_variation, longitude) = if index < DRIVING_MOON_COUNT {
            (variations[index], longitude.get(1..).unwrap_or_default())
        } else {
            (Derivatives::default(), &longitude[..])
        };
        Sums {
            semi_major_axis_or_mean_motion: sum(mean_motion).map(|v| v.x),
            longitude: own_variation.plus(sum(longitude).map(|v| v.y)),
            eccentricity: sum(eccentricity),
            inclination: sum(inclination),
        }
    }

    /// The elements at `t`, from the sums at a node `days_from_node` earlier (negative: later).
    fn elements(moon: &Moon, t: Instant, sums: &Sums, days_from_node: f64) -> Elements {
        let s0 = moon.s0;
        let mean_motion_per_day = moon.aam * (1.0 + s0[0] + sums.semi_major_axis_or_mean_motion.extrapolated(days_from_node));
        Elements {
            semi_major_axis_au: (moon.mu / (mean_motion_per_day * mean_motion_per_day)).cbrt(),
            mean_motion_per_day,
            mean_longitude_rad: sums.longitude.extrapolated(days_from_node) + s0[1] + moon.aam * tt_days_past(t, EPOCH_JD_TT),
            eccentricity: DVec2::new(s0[2], s0[3]) + sums.eccentricity.extrapolated(days_from_node),
            inclination: DVec2::new(s0[4], s0[5]) + sums.inclination.extrapolated(days_from_node),
        }
    }

    /// Slow longitude variations, radians, of the driving moons on which this moon's arguments depend; 0 for the others.
    fn slow_variations(&self, index: usize, days: f64) -> [Derivatives<f64>; 8] {
        let mut variations = [Derivatives::default(); 8];
        for (j, is_needed) in self.driven_by[index].iter().enumerate() {
            if *is_needed && let Some(Group(_, terms)) = self.moons[j].series[1].first() {
                variations[j] = Derivatives::sum(terms.iter().map(|term| term.at(days, [0.0; 4]).map(|v| v.y)));
            }
        }
        variations
    }
}

/// Estimated bound of the position's error, km. It was not measured, because no newer solution of Saturn's moons was available. Tests verify that the sums are
/// correct to metres and that the moons face Saturn (tests/ephemeris/satellites.rs). More than a century from 2000 the bound grows, up to about the diameter of
/// the orbit.
pub fn error_km(index: usize, t: Instant) -> f64 {
    let near_2000_km = [400.0, 300.0, 300.0, 300.0, 300.0, 300.0, 800.0, 1500.0].get(index).copied().unwrap_or(1500.0);
    let orbit_radii_km = [186_000.0, 238_000.0, 295_000.0, 377_000.0, 527_000.0, 1_222_000.0, 3_561_000.0, 1_481_000.0];
    (near_2000_km * super::error_growth(t, 100.0)).min(2.2 * orbit_radii_km.get(index).copied().unwrap_or(3_561_000.0))
}

#[cfg(test)]
impl Tass17 {
    pub(super) fn set_step(&mut self, step_s: f64) {
        self.grid = SumsGrid::with_step(step_s);
    }

    /// The state without the grid.
    pub(super) fn state_without_grid(&self, index: usize, t: Instant) -> Option<State> {
        let moon = self.moons.get(index)?;
        let sums = self.sums(index, moon, tt_days_past(t, EPOCH_JD_TT));
        let days_from_node = 0.0;
        Some(Self::elements(moon, t, &sums, days_from_node).state(&self.icrf_from_frame))
    }
}
