//! Theory L1.2 of the motion of Io, Europa, Ganymede and Callisto (Lainey, Duriez & Vienne 2006, A&A 456, 783), in the shortened series of
//! Astronomy Engine 2.1.19.
//!
//! In: the index of a moon, and an instant. Out: the state relative to Jupiter's centre, ICRF. [`error_km`] bounds the position's error.
//!
//! Time: TT days past 1950-01-01 00:00 (JD 2433282.5). Frame: the table's own plane near Jupiter's equator, rotated to ICRF by its matrix.

use super::{Derivatives, Elements, Sums, SumsGrid, Term, tt_days_past};
use crate::ephemeris::State;
use crate::time::Instant;
use glam::{DMat3, DVec3};
use serde::Deserialize;

const EPOCH_JD_TT: f64 = 2_433_282.5;
/// Spacing of the nodes at which the series are summed, seconds. The error of the extrapolation between them is 0.02 m at most (Io, whose fastest terms turn by
/// seven radians a day).
pub(super) const STEP_S: f64 = 192.0;

/// The table; the names of all fields are those of its JSON file.
#[derive(Debug, Deserialize)]
struct Table {
    /// The axes of Jupiter's frame, one per row, as vectors in the equatorial frame of J2000.
    jup_to_eqj: [[f64; 3]; 3],
    moons: [Moon; 4],
}

/// The constants and series of one moon.
#[derive(Debug, Deserialize)]
struct Moon {
    /// GM of Jupiter and the moon, au³ per day².
    mu: f64,
    /// Mean longitude at the epoch, radians.
    al0: f64,
    /// Rate of the mean longitude, radians a day.
    al1: f64,
    /// Semi-major axis, au: a sum of cosines.
    a: Vec<Term>,
    /// Periodic part of the mean longitude, radians: a sum of sines.
    l: Vec<Term>,
    /// Eccentricity e·exp(iϖ): a sum of complex exponentials.
    z: Vec<Term>,
    /// Inclination sin(I/2)·exp(iΩ): a sum of complex exponentials.
    zeta: Vec<Term>,
}

/// The four moons' series.
#[derive(Debug)]
pub struct GalileanL12 {
    moons: [Moon; 4],
    icrf_from_frame: DMat3,
    /// Caches the sums at evenly spaced instants, from which [`Self::state`] extrapolates.
    grid: SumsGrid,
}

impl GalileanL12 {
    pub(super) fn parse(json: &str) -> Result<Self, serde_json::Error> {
        let table: Table = serde_json::from_str(json)?;
        let axes = table.jup_to_eqj.map(DVec3::from_array);
        Ok(Self { moons: table.moons, icrf_from_frame: DMat3::from_cols(axes[0], axes[1], axes[2]), grid: SumsGrid::with_step(STEP_S) })
    }

    /// State relative to Jupiter's centre, ICRF; index 0 Io, 1 Europa, 2 Ganymede, 3 Callisto; `None` for another.
    pub fn state(&self, index: usize, t: Instant) -> Option<State> {
        let moon = self.moons.get(index)?;
        let (sums, days_from_node) = self.grid.nearest(index, t, |node| Self::sums(moon, tt_days_past(node, EPOCH_JD_TT)));
        Some(Self::elements(moon, t, &sums, days_from_node).state(&self.icrf_from_frame))
    }

    /// The sums of a moon's series, `days` (TT) past the theory's epoch.
    fn sums(moon: &Moon, days: f64) -> Sums {
        let no_shift = [0.0; 4];
        let sum = |terms: &[Term]| Derivatives::sum(terms.iter().map(|term| term.at(days, no_shift)));
        Sums {
            semi_major_axis_or_mean_motion: sum(&moon.a).map(|v| v.x),
            periodic_longitude: sum(&moon.l).map(|v| v.y),
            eccentricity: sum(&moon.z),
            inclination: sum(&moon.zeta),
        }
    }

    /// The elements at `t`, from the sums at a node `days_from_node` earlier (negative: later).
    fn elements(moon: &Moon, t: Instant, sums: &Sums, days_from_node: f64) -> Elements {
        let semi_major_axis_au = sums.semi_major_axis_or_mean_motion.extrapolated(days_from_node);
        Elements {
            semi_major_axis_au,
            mean_motion_per_day: (moon.mu / semi_major_axis_au.powi(3)).sqrt(),
            mean_longitude_rad: sums.periodic_longitude.extrapolated(days_from_node) + moon.al0 + moon.al1 * tt_days_past(t, EPOCH_JD_TT),
            eccentricity: sums.eccentricity.extrapolated(days_from_node),
            inclination: sums.inclination.extrapolated(days_from_node),
        }
    }
}

/// Bound of the position's error, km. The shortened series differ from JPL's jup365 in 1931-1933 and 2068 (tests/ephemeris/satellites.rs) by at most 353
/// (Io), 193 (Europa), 288 (Ganymede) and 478 (Callisto); at least a third is added for the dates between. More than 70 years from 2000 the bound
/// grows, up to about the diameter of the orbit.
pub fn error_km(index: usize, t: Instant) -> f64 {
    let near_2000_km = [480.0, 300.0, 400.0, 650.0].get(index).copied().unwrap_or(650.0);
    let orbit_radius_km = [422_000.0, 671_000.0, 1_070_000.0, 1_883_000.0].get(index).copied().unwrap_or(1_883_000.0);
    (near_2000_km * super::error_growth(t, 70.0)).min(2.1 * orbit_radius_km)
}

#[cfg(test)]
impl GalileanL12 {
    pub(super) fn set_step(&mut self, step_s: f64) {
        self.grid = SumsGrid::with_step(step_s);
    }

    /// The state without the grid.
    pub(super) fn state_without_grid(&self, index: usize, t: Instant) -> Option<State> {
        let moon = self.moons.get(index)?;
        let sums = Self::sums(moon, tt_days_past(t, EPOCH_JD_TT));
        let days_from_node = 0.0;
        Some(Self::elements(moon, t, &sums, days_from_node).state(&self.icrf_from_frame))
    }
}
