//! The barycentres of the planets' systems by VSOP87A and the Sun by VSOP87E (crate vsop87, all terms), the Moon by ELP ([`super::elp`]), and Pluto's system
//! from an SPK kernel of Chebyshev polynomials that were fitted to DE440 for 1551-2646.
//!
//! In: a target (NAIF code: the barycentres 1 to 9, the Sun 10, the Moon 301, the Earth 399, Mercury 199, Venus 299) and an instant in TDB seconds past J2000.
//! Out: a state relative to the series' origin, ICRF, and the bound of its error against DE440 ([`error_km`]). The series of VSOP87 have thousands of terms, so
//! they are evaluated only at the nodes of Chebyshev polynomials (src/ephemeris/chebyshev_cache.rs). The polynomials agree with the series to 4e-3 km, limited
//! by the resolution of a Julian date in a double (4e-5 s), and to 2e-6 km/s (tests/ephemeris/positions.rs).

use super::chebyshev_cache::ChebyshevCache;
use super::mean_elements::CONSTANT_ERROR_YEARS;
use super::{EphemerisError, State, elp::LunarSeries, frames, spk::Spk};
use crate::units::{DAYS_PER_JULIAN_YEAR, JD_J2000, KM_PER_AU, SECONDS_PER_DAY};
use glam::DVec3;
use vsop87::{RectangularCoordinates, vsop87a, vsop87e};

/// Ratio of the Earth's mass to the Moon's (DE440, Park et al. 2021).
pub const EARTH_MOON_MASS_RATIO: f64 = 81.300_568_221_497_22;

/// Days that one polynomial of Mercury covers: fewer than for the other bodies, because Mercury's period is the shortest and its harmonics are the largest.
const MERCURY_INTERVAL_DAYS: f64 = 16.0;
/// Days that one polynomial of any other body covers.
const INTERVAL_DAYS: f64 = 32.0;
/// Terms of the Moon's series with at least this amplitude are summed: all terms of the table.
const ALL_TERMS_ARCSEC: f64 = 0.0;
/// As [`ALL_TERMS_ARCSEC`], for [`Series::moon_by_largest_terms`]: equation of the centre, evection, variation and the like.
const LARGEST_TERMS_ARCSEC: f64 = 500.0;

/// The Moon's series, Pluto's kernel, and the cached polynomials that approximate the series of the crate vsop87. Pluto's kernel counts as a series below.
#[derive(Debug)]
pub struct Series {
    moon: LunarSeries,
    pluto: Spk,
    polynomials: ChebyshevCache,
}

impl Series {
    /// The series from the embedded tables.
    pub fn embedded() -> Result<Self, EphemerisError> {
        Ok(Self {
            moon: LunarSeries::embedded()?,
            pluto: Spk::parse("pluto_1551_2646.bsp", orrery_catalogs::PLUTO_KERNEL)?,
            polynomials: ChebyshevCache::default(),
        })
    }

    /// NAIF code of the origin of the series of `target`; `None` without a series, and for Pluto outside the kernel's span.
    pub fn origin_of(&self, target: i32, tdb_s: f64) -> Option<i32> {
        match target {
            9 => self.pluto.segment(9, tdb_s).map(|segment| segment.center),
            _ => super::mean_elements::origin_of(target),
        }
    }

    /// The span in which the series of `target` is valid, TDB seconds past J2000; infinite except for Pluto. `None` without a series.
    pub fn coverage(&self, target: i32) -> Option<(f64, f64)> {
        match target {
            9 => self.pluto.coverage(9),
            _ => super::mean_elements::origin_of(target).map(|_| (f64::NEG_INFINITY, f64::INFINITY)),
        }
    }

    /// State of `target` relative to its origin ([`Self::origin_of`]), ICRF; `None` as there.
    pub fn state(&self, target: i32, tdb_s: f64) -> Option<State> {
        match target {
            9 => self.pluto.state_and_center(9, tdb_s).map(|(_, state)| state),
            301 => Some(self.moon.state(tdb_s, ALL_TERMS_ARCSEC)),
            399 => Some(earth_from_moon(self.moon.state(tdb_s, ALL_TERMS_ARCSEC))),
            // Mercury and Venus coincide with their barycentres, which are their origins.
            199 | 299 => Some(State::REST),
            _ => {
                let series = vsop_series_of(target)?;
                let days = if target == 1 { MERCURY_INTERVAL_DAYS } else { INTERVAL_DAYS };
                Some(self.polynomials.state(target, days, tdb_s, |tdb_s| vsop_position_km(series, tdb_s)))
            }
        }
    }

    /// The position that the polynomials approximate, directly from the series of VSOP87, km, ICRF; `None` for targets without one.
    pub fn position_by_series_km(target: i32, tdb_s: f64) -> Option<DVec3> {
        vsop_series_of(target).map(|series| vsop_position_km(series, tdb_s))
    }

    /// The Moon's geocentric state by the largest terms of its series, for [`Source::Mean`](super::Source::Mean).
    pub fn moon_by_largest_terms(&self, tdb_s: f64) -> State {
        self.moon.state(tdb_s, LARGEST_TERMS_ARCSEC)
    }
}

/// The Earth's state relative to the Earth-Moon barycentre, from the Moon's geocentric one.
pub fn earth_from_moon(moon: State) -> State {
    let fraction = -1.0 / (1.0 + EARTH_MOON_MASS_RATIO);
    State { pos_km: moon.pos_km * fraction, vel_km_s: moon.vel_km_s * fraction }
}

/// A series of the crate vsop87: position in astronomical units, ecliptic of J2000, as a function of the Julian date in TDB.
type VsopSeries = fn(f64) -> RectangularCoordinates;

/// The series of the barycentre of a planet's system (heliocentric) or of the Sun (from the barycentre of the solar system); `None` for other NAIF codes.
fn vsop_series_of(target: i32) -> Option<VsopSeries> {
    Some(match target {
        1 => vsop87a::mercury,
        2 => vsop87a::venus,
        3 => vsop87a::earth_moon,
        4 => vsop87a::mars,
        5 => vsop87a::jupiter,
        6 => vsop87a::saturn,
        7 => vsop87a::uranus,
        8 => vsop87a::neptune,
        10 => vsop87e::sun,
        _ => return None,
    })
}

/// ICRF, relative to the series' origin.
fn vsop_position_km(series: VsopSeries, tdb_s: f64) -> DVec3 {
    let position_au = series(tdb_s / SECONDS_PER_DAY + JD_J2000);
    frames::icrf_from_ecliptic() * (DVec3::new(position_au.x, position_au.y, position_au.z) * KM_PER_AU)
}

/// Upper limit of the error of the position relative to its origin, km: the largest difference from DE440 at 4000 dates over 1552-2646, as
/// `examples/measure_ephemeris.rs` prints it, rounded up. More than [`CONSTANT_ERROR_YEARS`] from J2000 the limit grows with the square of time. That growth is
/// an assumption and was not measured.
pub fn error_km(target: i32, tdb_s: f64) -> f64 {
    let worst_km = match target {
        1 => 125.0,
        2 => 70.0,
        3 => 150.0,
        4 => 2_700.0,
        5 => 2_900.0,
        6 => 10_000.0,
        7 => 145_000.0,
        8 => 185_000.0,
        9 => 400.0,
        10 => 1_600.0,
        301 => 7.0,
        399 => 0.1,
        // Mercury and Venus coincide with their barycentres: a nominal bound.
        _ => 0.001,
    };
    let growth = (tdb_s / (CONSTANT_ERROR_YEARS * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY)).abs().max(1.0);
    worst_km * growth * growth
}
