//! The Moon by ELP2000-82B, truncated. In: an instant, and the amplitude of the smallest terms to sum. Out: the geocentric state, ICRF.
//!
//! The theory: Chapront-Touzé and Chapront, Astron. Astrophys. 190 (1988), 342; the terms are in catalogs/elp2000_truncated.csv. ELP's value of the tidal
//! acceleration is older than DE440's, so `FITTED_TO_DE440` was fitted to DE440's longitude over 1560 to 2640 (1500 dates). The greatest error against DE440
//! (`examples/measure_ephemeris.rs`) is 6.6 km or 3.8 arcsec (1.4 km rms) over 1552 to 2646, and 4.7 km or 2.7 arcsec over 1600 to 2500. Outside these years
//! the fitted quadratic term is an extrapolation: an error of 1 arcsec per century squared in the tidal acceleration moves the Moon by 50² / 2 arcsec, 21
//! arcmin, in 3000 BC.

use super::{EphemerisError, State, frames};
use crate::units::RAD_PER_ARCSEC;
use glam::DVec3;

const CENTURY_S: f64 = crate::units::DAYS_PER_JULIAN_CENTURY * crate::units::SECONDS_PER_DAY;

/// The Moon's mean longitude W1, counted along the mean ecliptic of date from the departure point. From the node where the mean ecliptics of date and of J2000
/// intersect, this point is as far as the equinox of J2000. Coefficients of powers of Julian centuries, radians.
const MEAN_LONGITUDE: [f64; 5] = [
    3.810_344_430_588_308,
    1_732_559_343.736_04 * RAD_PER_ARCSEC,
    -5.8883 * RAD_PER_ARCSEC,
    0.006_604 * RAD_PER_ARCSEC,
    -0.000_031_69 * RAD_PER_ARCSEC,
];
/// Correction of the mean longitude, fitted to DE440 (see the module's comment). Coefficients of powers of Julian centuries, radians.
const FITTED_TO_DE440: [f64; 3] = [-0.076_889 * RAD_PER_ARCSEC, -0.317_650 * RAD_PER_ARCSEC, -0.946_281 * RAD_PER_ARCSEC];

/// Arguments of the terms. Zeta is the mean longitude counted from the moving equinox: W1 plus the precession, both to first order in time. Coefficients of
/// powers of Julian centuries, radians.
const ARGUMENTS: [[f64; 5]; 13] = [
    // D, the elongation from the Sun.
    [5.198_466_741_027_443, 7_771.377_146_811_758, -2.844_935_162_1e-5, 3.197_346_2e-8, -1.543_65e-10],
    // l', the Sun's mean anomaly.
    [-0.043_125_180_208_125, 628.301_955_168_488, -2.680_534_843e-6, 7.126_76e-10, 7.27e-13],
    // l, the Moon's mean anomaly.
    [2.355_555_898_265_799, 8_328.691_426_955_555, 1.570_277_576_16e-4, 2.504_111_14e-7, -1.186_339e-9],
    // F, the argument of latitude.
    [1.627_905_233_371_468, 8_433.466_158_130_539, -5.939_210_000_4e-5, -4.949_948e-9, 2.021_7e-11],
    // Zeta.
    [3.810_344_430_588_308, 8_399.709_113_522_269, 0.0, 0.0, 0.0],
    // Mean longitudes of Mercury to Neptune.
    [4.402_608_842_402_962, 2_608.790_314_157_411, 0.0, 0.0, 0.0],
    [3.176_146_696_907_594, 1_021.328_554_621_109, 0.0, 0.0, 0.0],
    [1.753_470_343_150_658, 628.307_584_962_155, 0.0, 0.0, 0.0],
    [6.203_480_913_399_945, 334.061_243_149_23, 0.0, 0.0, 0.0],
    [0.599_546_497_388_674, 52.969_096_509_472, 0.0, 0.0, 0.0],
    [0.874_016_756_518_481, 21.329_909_543_8, 0.0, 0.0, 0.0],
    [5.481_293_871_604_991, 7.478_159_856_714, 0.0, 0.0, 0.0],
    [5.311_886_286_783_467, 3.813_303_563_758, 0.0, 0.0, 0.0],
];
/// Indices of D, l and F in [`ARGUMENTS`]: they are W1 minus the longitude of the Sun, of the perigee or of the node, and get the same correction as W1. Zeta
/// contains W1, too, but is not corrected: in 3000 BC the correction is 0.65 degrees, which would change zeta's terms, of 8 arcsec at most, by only 0.1 arcsec.
const WITH_LUNAR_LONGITUDE: [usize; 3] = [0, 2, 3];

/// Factor on the distances of the series, a0 / ath in the authors' program (ELP82B.F, "constants fitted to JPL's ephemerides DE200/LE200"; CDS VI/79). `ath` is
/// the Moon's Keplerian semi-major axis in km with which the series were computed; a0 is presumably the one fitted to DE200, because the note on ELP/MPP02
/// (Chapront and Francou 2002, section 5.1) has the same factor for DE405: a0(DE405) / a0(ELP), where a0(ELP) is `ath`. The factor moves the Moon by 3 cm.
const DISTANCE_RATIO: f64 = 384_747.980_644_895_4 / 384_747.980_674_316_5;

/// Length of an arcsecond at the Moon's mean distance, 384 748 km.
const KM_PER_ARCSEC: f64 = 1.865;

/// P = sin(π_A/2) sin Π_A (Laskar 1986, Astron. Astrophys. 157, 59), where the mean ecliptic of date is inclined by π_A to that of J2000 and Π_A is the
/// longitude of its node. Coefficients of T to T⁵, T in Julian centuries from J2000.
const ECLIPTIC_P: [f64; 5] = [0.101_803_91e-4, 0.470_204_39e-6, -0.541_736_7e-9, -0.250_794_8e-11, 0.463_486e-14];
/// Q = sin(π_A/2) cos Π_A, as [`ECLIPTIC_P`].
const ECLIPTIC_Q: [f64; 5] = [-0.113_469_002e-3, 0.123_726_74e-6, 0.126_541_7e-8, -0.137_180_8e-11, -0.320_334e-14];

/// The quantities of [`Term::quantity`].
const LONGITUDE: usize = 0;
const LATITUDE: usize = 1;
const DISTANCE: usize = 2;

/// A periodic term: amplitude times time^power times the sine of its angle.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// [`LONGITUDE`], [`LATITUDE`] or [`DISTANCE`].
    quantity: usize,
    /// Exponent of the time in Julian centuries past J2000, a factor of the term.
    power: i32,
    /// Arcseconds; kilometres for a term of the distance.
    amplitude: f64,
    /// Radians.
    phase: f64,
    /// Integer multiples of [`ARGUMENTS`], whose sum with the phase is the term's angle.
    multipliers: [i8; 13],
}

/// The terms of the Moon's longitude, latitude and distance.
#[derive(Debug)]
pub struct LunarSeries {
    terms: Vec<Term>,
}

impl LunarSeries {
    /// The terms of the embedded table.
    pub fn embedded() -> Result<Self, EphemerisError> {
        let lines = orrery_catalogs::LUNAR_SERIES.lines().enumerate().filter(|(_, l)| !l.starts_with('#') && !l.trim().is_empty());
        let read = |(number, line): (usize, &str)| {
            parse_term(line).ok_or_else(|| EphemerisError::other(format!("elp2000_truncated.csv:{}: not a term: {line}", number + 1)))
        };
        Ok(Self { terms: lines.map(read).collect::<Result<_, _>>()? })
    }

    /// Geocentric state, ICRF, at TDB seconds past J2000. Terms with an amplitude under `min_arcsec` are left out; an amplitude in km counts as the angle
    /// that it spans at the Moon's mean distance.
    pub fn state(&self, tdb_s: f64, min_arcsec: f64) -> State {
        let t = tdb_s / CENTURY_S;
        let (correction, correction_rate) = polynomial(&FITTED_TO_DE440, t);
        let mut arguments = ARGUMENTS.map(|a| polynomial(&a, t));
        for k in WITH_LUNAR_LONGITUDE {
            arguments[k].0 += correction;
            arguments[k].1 += correction_rate;
        }
        // Value and rate per century of the sum for each quantity.
        let mut sums = [(0.0, 0.0); 3];
        for term in &self.terms {
            let units_per_arcsec = if term.quantity == DISTANCE { KM_PER_ARCSEC } else { 1.0 };
            if term.amplitude.abs() < min_arcsec * units_per_arcsec {
                continue;
            }
            let (mut angle, mut rate) = (term.phase, 0.0);
            for (m, (a, a_rate)) in term.multipliers.iter().zip(&arguments) {
                let m = f64::from(*m);
                angle += m * a;
                rate += m * a_rate;
            }
            let (sin, cos) = angle.sin_cos();
            let amplitude = term.amplitude * t.powi(term.power);
            let amplitude_rate = if term.power == 0 { 0.0 } else { f64::from(term.power) * term.amplitude * t.powi(term.power - 1) };
            sums[term.quantity].0 += amplitude * sin;
            sums[term.quantity].1 += amplitude * rate * cos + amplitude_rate * sin;
        }
        // ELP's V, U and r: longitude, latitude and distance, referred to the mean ecliptic of date.
        let (mean_longitude, mean_longitude_rate) = polynomial(&MEAN_LONGITUDE, t);
        let v = mean_longitude + correction + sums[LONGITUDE].0 * RAD_PER_ARCSEC;
        let v_rate = mean_longitude_rate + correction_rate + sums[LONGITUDE].1 * RAD_PER_ARCSEC;
        let (u, u_rate) = (sums[LATITUDE].0 * RAD_PER_ARCSEC, sums[LATITUDE].1 * RAD_PER_ARCSEC);
        let (r, r_rate) = (sums[DISTANCE].0 * DISTANCE_RATIO, sums[DISTANCE].1 * DISTANCE_RATIO);
        let ((sin_v, cos_v), (sin_u, cos_u)) = (v.sin_cos(), u.sin_cos());
        let outward = DVec3::new(cos_u * cos_v, cos_u * sin_v, sin_u);
        let outward_rate =
            DVec3::new(-cos_u * sin_v, cos_u * cos_v, 0.0) * v_rate + DVec3::new(-sin_u * cos_v, -sin_u * sin_v, cos_u) * u_rate;
        // The ecliptic itself rotates by 47 arcsec per century: 0.03 mm/s at the Moon, left out of the velocity.
        let icrf_from_date = frames::icrf_from_ecliptic() * j2000_from_ecliptic_of_date(t);
        State { pos_km: icrf_from_date * (outward * r), vel_km_s: icrf_from_date * (outward * r_rate + outward_rate * r) / CENTURY_S }
    }
}

/// Rotation from the mean ecliptic of date to that of J2000, by Laskar's P and Q. `t`: Julian centuries from J2000.
fn j2000_from_ecliptic_of_date(t: f64) -> glam::DMat3 {
    let (p, q) = (polynomial(&ECLIPTIC_P, t).0 * t, polynomial(&ECLIPTIC_Q, t).0 * t);
    // 2 cos(π_A/2).
    let w = 2.0 * (1.0 - p * p - q * q).max(0.0).sqrt();
    glam::DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * p * p, 2.0 * p * q, -p * w),
        DVec3::new(2.0 * p * q, 1.0 - 2.0 * q * q, q * w),
        DVec3::new(p * w, -q * w, 1.0 - 2.0 * p * p - 2.0 * q * q),
    )
}

/// Value and derivative at `t` of the polynomial with coefficients `c`, the constant first.
fn polynomial(c: &[f64], t: f64) -> (f64, f64) {
    c.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * t + c, slope * t + value))
}

/// A line of the table: V, U or R for longitude, latitude or distance; then the fields of [`Term`], with the phase in degrees.
fn parse_term(line: &str) -> Option<Term> {
    let mut fields = line.split(',');
    let letter = fields.next()?;
    let quantity = ["V", "U", "R"].iter().position(|q| *q == letter)?;
    let power = fields.next()?.parse().ok()?;
    let amplitude = fields.next()?.parse().ok()?;
    let phase = fields.next()?.parse::<f64>().ok()?.to_radians();
    let mut multipliers = [0; 13];
    for m in &mut multipliers {
        *m = fields.next()?.parse().ok()?;
    }
    fields.next().is_none().then_some(Term { quantity, power, amplitude, phase, multipliers })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_of_the_ecliptic_of_date_is_a_rotation() {
        for t in [-50.0, -3.0, 0.0, 10.0] {
            let m = j2000_from_ecliptic_of_date(t);
            assert!((m * m.transpose() - glam::DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-14));
        }
    }

    #[test]
    fn velocity_is_the_slope_of_position() {
        let series = LunarSeries::embedded().expect("the table");
        let all_terms_arcsec = 0.0;
        let state = |tdb_s: f64| series.state(tdb_s, all_terms_arcsec);
        // The years 732, 2000 and 2412.
        for tdb_s in [-4e10, 0.0, 1.3e10] {
            let slope = (state(tdb_s + 60.0).pos_km - state(tdb_s - 60.0).pos_km) / 120.0;
            let velocity = state(tdb_s).vel_km_s;
            // 2 mm/s: the velocity leaves out 0.03 mm/s, and the angles of a date in 732 are rounded. The velocity changes by 10 m/s in an hour.
            assert!((slope - velocity).length() < 2e-6, "{slope} {velocity}");
            assert!((slope - state(tdb_s + 3600.0).vel_km_s).length() > 1e-4, "the velocity of an hour later must not pass");
        }
    }

    #[test]
    fn damaged_lines_are_rejected() {
        assert!(parse_term("V,0,1.0,2.0,1,0,0,0,0,0,0,0,0,0,0,0,0").is_some());
        for line in [
            "",
            "W,0,1,2,1,0,0,0,0,0,0,0,0,0,0,0,0",
            "V,0,1,2,1,0,0",
            "V,0,x,2,1,0,0,0,0,0,0,0,0,0,0,0,0",
            "V,0,1,2,1,0,0,0,0,0,0,0,0,0,0,0,0,9",
        ] {
            assert!(parse_term(line).is_none(), "{line}");
        }
    }
}
