//! Delta T = TT - UT1: the lag of the Earth's rotation behind uniform time.
//!
//! In: an instant in TT. Out: Delta T and its standard error, seconds.
//!
//! | dates | model | error |
//! |---|---|---|
//! | 1973.2 to 2027.6 | IERS finals2000A (Bulletin A, from the package astropy-iers-data 0.2026.11.2) every 73 days, cubic interpolation | 0.013 s at the worst against the daily series, 0.004 s rms; after November 2026 IERS's own prediction, some 0.05 s |
//! | -720 to 1973.2 | spline of Stephenson, Morrison and Hohenkerk, Proc. R. Soc. A 472 (2016), table S15 as revised in 2020 | see [`delta_t_error_s`] |
//! | before -720, after 2027.6 | the long-term parabola of the same paper (the revision of 2020 has another), -320 + 32.5 ((year - 1825) / 100)² s before -1720 and after 2500, joined by cubics | see [`delta_t_error_s`] |

use super::delta_t_table::{IERS_FIRST_MJD, IERS_MS, IERS_STEP_DAYS, SPLINE};
use crate::units::{DAYS_PER_JULIAN_YEAR, JD_J2000, SECONDS_PER_DAY};

/// Julian date of the origin of the modified Julian date.
const MJD_ORIGIN_JD: f64 = 2_400_000.5;
const JULIAN_YEAR_S: f64 = DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
/// The long-term parabola applies up to this year.
const PARABOLA_UNTIL_YEAR: f64 = -1720.0;
/// The long-term parabola applies again from this year on.
const PARABOLA_FROM_YEAR: f64 = 2500.0;
/// From this year on, the IERS table holds predictions, not measurements.
const PREDICTED_FROM_YEAR: f64 = 2026.85;
/// The year of the IERS table's last entry, from which the error is that of an extrapolation. Values are interpolated only up to the entry before, 2027.6.
const TABLE_END_YEAR: f64 = 2027.8;
/// The year from which the spline is corrected linearly, so that it meets the IERS table.
const BLEND_FROM_YEAR: f64 = 1955.0;

/// Delta T in seconds at `tt_s`, TT seconds past J2000.
pub fn delta_t_s(tt_s: f64) -> f64 {
    let index = iers_index(tt_s);
    // Cubic interpolation needs an entry on either side of the interval, so the table is used from its second entry to the last but one.
    let last_used = IERS_MS.len() - 2;
    if index >= 1.0 && index < last_used as f64 {
        return iers_s(index);
    }
    let year = year_of(tt_s);
    if index < 1.0 {
        let [spline_start_year, ..] = SPLINE[0];
        if year >= spline_start_year {
            // The spline smooths the last years before the table, so that it is off by 0.2 s where the table takes over. A correction that grows linearly from
            // 0 in `BLEND_FROM_YEAR` to this gap makes it meet the table.
            let seam_year = year_of_entry(1);
            let gap_s = f64::from(IERS_MS[1]) * 1e-3 - spline_s(seam_year);
            let weight = ((year - BLEND_FROM_YEAR) / (seam_year - BLEND_FROM_YEAR)).clamp(0.0, 1.0);
            return spline_s(year) + weight * gap_s;
        }
        if year <= PARABOLA_UNTIL_YEAR {
            return parabola_s(year);
        }
        return cubic_between((PARABOLA_UNTIL_YEAR, parabola_s), (spline_start_year, spline_s), year);
    }
    if year >= PARABOLA_FROM_YEAR {
        return parabola_s(year);
    }
    // The slope of Delta T at the last used entry, seconds per year, is taken over two years, to exclude seasonal variation.
    let end_year = year_of_entry(last_used);
    let end_delta_t_s = f64::from(IERS_MS[last_used]) * 1e-3;
    let steps = (2.0 * DAYS_PER_JULIAN_YEAR / IERS_STEP_DAYS).round() as usize;
    let earlier_delta_t_s = f64::from(IERS_MS[last_used - steps]) * 1e-3;
    let slope = (end_delta_t_s - earlier_delta_t_s) / (steps as f64 * IERS_STEP_DAYS / DAYS_PER_JULIAN_YEAR);
    cubic_between((end_year, move |y| end_delta_t_s + slope * (y - end_year)), (PARABOLA_FROM_YEAR, parabola_s), year)
}

/// One standard error of [`delta_t_s`] before the IERS table: years and seconds, linear in between.
///
/// Up to 1600 as Morrison and Stephenson state it, J. Hist. Astron. 35 (2004), 333: [`early_error_s`] until 1200, and 20 s from 1300, because fluctuations over
/// decades are not known for those years. From 1700 the largest differences between the spline and the Astronomical Almanac (page K8), which is an earlier
/// reduction: 4.7 s about 1800, 0.8 s in 1900.
const ERRORS_BEFORE_TABLE_S: [(f64, f64); 8] =
    [(1200.0, 30.8), (1300.0, 20.0), (1600.0, 20.0), (1700.0, 5.0), (1820.0, 5.0), (1890.0, 2.1), (1900.0, 0.8), (1970.0, 0.7)];

/// The standard error before 1200: 0.8 s times the square of the centuries from 1820. Stated for the years from -1000 on; it gives 1167 s for -2000, for which
/// the spline's authors state 1080 s.
fn early_error_s(year: f64) -> f64 {
    0.8 * ((year - 1820.0) / 100.0).powi(2)
}

/// One standard error of [`delta_t_s`] in seconds. Before the IERS table it follows published errors and differences (462 s in 585 BC, 20 s in 1500, 0.8 s
/// in 1900), within the table measured differences. After the table's end it is that of an extrapolation: 38 s in 2100, 574 s in 2500
/// (`extrapolation_error_s`).
pub fn delta_t_error_s(tt_s: f64) -> f64 {
    let year = year_of(tt_s);
    match year {
        y if y >= TABLE_END_YEAR => extrapolation_error_s(y - TABLE_END_YEAR),
        // The error of IERS's prediction.
        y if y >= PREDICTED_FROM_YEAR => 0.05,
        // More than the 0.013 s by which the interpolated table differs from the daily series.
        y if y >= year_of_entry(1) => 0.02,
        y if y < ERRORS_BEFORE_TABLE_S[0].0 => early_error_s(y),
        y => {
            let next = ERRORS_BEFORE_TABLE_S.iter().position(|(listed_year, _)| y < *listed_year);
            let Some(next) = next else { return ERRORS_BEFORE_TABLE_S[ERRORS_BEFORE_TABLE_S.len() - 1].1 };
            let ((year0, error0_s), (year1, error1_s)) = (ERRORS_BEFORE_TABLE_S[next - 1], ERRORS_BEFORE_TABLE_S[next]);
            error0_s + (error1_s - error0_s) * (y - year0) / (year1 - year0)
        }
    }
}

/// The standard error this many years after the table's end, the sum of three: 0.05 s, the error of IERS's prediction; 0.2 s a year for thirty years, for
/// fluctuations over decades; and the Brownian motion with drift of Huber 2000, "Modeling the Length of Day and Extrapolating the Rotation of the Earth", which
/// NASA's page "Uncertainty in Delta T" uses, too. 38 s in 2100, 574 s in 2500, 30 min in 3000.
fn extrapolation_error_s(years: f64) -> f64 {
    /// Growth of the variance of the length of the day, ms² a year.
    const VARIANCE_MS2_YR: f64 = 0.058;
    /// Years of observations from which the drift is known.
    const OBSERVED_YEARS: f64 = 2500.0;
    // Error of the mean length of the day, ms.
    let day_length_error_ms = (years * VARIANCE_MS2_YR / 3.0 * (1.0 + years / OBSERVED_YEARS)).sqrt();
    0.05 + 0.2 * years.min(30.0) + 1e-3 * day_length_error_ms * years * DAYS_PER_JULIAN_YEAR
}

/// Julian years, 2000.0 at J2000.
fn year_of(tt_s: f64) -> f64 {
    2000.0 + tt_s / JULIAN_YEAR_S
}

/// The year of an entry of the IERS table.
fn year_of_entry(index: usize) -> f64 {
    year_of(((IERS_FIRST_MJD + index as f64 * IERS_STEP_DAYS) - (JD_J2000 - MJD_ORIGIN_JD)) * SECONDS_PER_DAY)
}

/// Position in the IERS table. The table's dates are in UTC, but TT may be used: in the minute between the two, Delta T changes by less than 3 µs.
fn iers_index(tt_s: f64) -> f64 {
    let mjd = tt_s / SECONDS_PER_DAY + (JD_J2000 - MJD_ORIGIN_JD);
    (mjd - IERS_FIRST_MJD) / IERS_STEP_DAYS
}

/// Delta T at a position in the IERS table: the cubic through the two entries before and the two after it.
fn iers_s(index: f64) -> f64 {
    let i = index as usize;
    let u = index - i as f64;
    let [a, b, c, d] = [i - 1, i, i + 1, i + 2].map(|k| f64::from(IERS_MS[k]) * 1e-3);
    -a * u * (u - 1.0) * (u - 2.0) / 6.0 + b * (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 - c * (u + 1.0) * u * (u - 2.0) / 2.0
        + d * (u + 1.0) * u * (u - 1.0) / 6.0
}

/// Delta T by the spline; before or after its years, by the continuation of its first or last piece.
fn spline_s(year: f64) -> f64 {
    let row = SPLINE.iter().find(|[_, last_year, ..]| year < *last_year).unwrap_or(&SPLINE[SPLINE.len() - 1]);
    let [first_year, last_year, a3, a2, a1, a0] = *row;
    let u = (year - first_year) / (last_year - first_year);
    a0 + u * (a1 + u * (a2 + u * a3))
}

/// Delta T by the long-term parabola.
fn parabola_s(year: f64) -> f64 {
    let u = (year - 1825.0) / 100.0;
    -320.0 + 32.5 * u * u
}

/// The cubic that meets both functions in value and slope at the two years.
fn cubic_between((y0, f0): (f64, impl Fn(f64) -> f64), (y1, f1): (f64, impl Fn(f64) -> f64), year: f64) -> f64 {
    let step_years = 0.01;
    let span = y1 - y0;
    let (value0, value1) = (f0(y0), f1(y1));
    // Derivatives with respect to `u`, that is seconds per span, by one-sided differences outside the span, where each function applies.
    let (slope0, slope1) = ((value0 - f0(y0 - step_years)) / step_years * span, (f1(y1 + step_years) - value1) / step_years * span);
    let u = (year - y0) / span;
    let v = 1.0 - u;
    value0 * v * v * (1.0 + 2.0 * u) + slope0 * u * v * v + value1 * u * u * (3.0 - 2.0 * u) - slope1 * u * u * v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_year(year: f64) -> f64 {
        delta_t_s((year - 2000.0) * JULIAN_YEAR_S)
    }

    #[test]
    fn agrees_with_published_values() {
        // Up to 2010: Astronomical Almanac, pages K8 and K9. 2020 and 2025: 32.184 s (TT - TAI) + 37 s (TAI - UTC) - (UT1 - UTC), with IERS's UT1 - UTC of
        // -0.177 s and 0.04 s.
        for (year, seconds, tolerance_s) in [
            // Before the table, where the spline smooths.
            (1973.0, 43.37, 0.3),
            (1974.0, 44.49, 0.02),
            (2000.0, 63.83, 0.02),
            (2010.0, 66.07, 0.02),
            (2020.0, 69.36, 0.02),
            (2025.0, 69.14, 0.02),
        ] {
            assert!((at_year(year) - seconds).abs() < tolerance_s, "{year}: {} s", at_year(year));
        }
        // Delta T of the year before is outside the tolerance.
        assert!((at_year(1999.0) - 63.83).abs() > 0.02);
    }

    /// Astronomical Almanac, pages K8 and K9: an earlier reduction of the same telescopic observations.
    const ALMANAC: [(f64, f64); 11] = [
        (1800.0, 13.7),
        (1820.0, 12.0),
        (1850.0, 7.1),
        (1880.0, -5.4),
        (1890.0, -5.9),
        (1900.0, -2.7),
        (1910.0, 10.5),
        (1920.0, 21.2),
        (1930.0, 24.0),
        (1940.0, 24.3),
        (1950.0, 29.15),
    ];

    #[test]
    fn the_stated_error_covers_the_differences_from_the_almanac() {
        for (year, seconds) in ALMANAC {
            let (difference_s, error_s) = ((at_year(year) - seconds).abs(), delta_t_error_s((year - 2000.0) * JULIAN_YEAR_S));
            assert!(difference_s <= error_s, "{year}: {difference_s} s, stated {error_s}");
        }
        // Negative control: an error of 0.1 s in 1900 (Stephenson and Houlden 1986) would not cover the difference.
        assert!((at_year(1900.0) + 2.7).abs() > 0.1);
    }

    #[test]
    fn the_stated_error_has_no_steps_before_the_iers_table() {
        let error = |year: f64| delta_t_error_s((year - 2000.0) * JULIAN_YEAR_S);
        for tenth in -30_000..19_730 {
            let year = f64::from(tenth) / 10.0;
            // The steepest part is that of 3001 BC: 0.08 s in a tenth of a year.
            assert!((error(year + 0.1) - error(year)).abs() < 0.1, "{year}: {} s, then {} s", error(year), error(year + 0.1));
        }
        // Nor at the end of the IERS table: the estimate grows by 0.3 s in the first year, by 0.02 s in its first tenth.
        assert!((error(TABLE_END_YEAR + 0.1) - error(TABLE_END_YEAR - 0.1)).abs() < 0.05);
        assert!((error(-584.4) - 462.4).abs() < 1.0 && (error(1500.0) - 20.0).abs() < 1e-9, "{}", error(-584.4));
    }

    /// Extrapolations from every third year since 1720, by the slope of the ten years before and the parabola's curvature, against what was measured later.
    #[test]
    fn the_stated_error_of_the_future_is_that_of_past_extrapolations() {
        let rms_s = |years: i32| {
            let errors = (1720..2026 - years).step_by(3).map(|start| {
                let (start, years) = (f64::from(start), f64::from(years));
                let slope = (at_year(start) - at_year(start - 10.0)) / 10.0;
                at_year(start + years) - at_year(start) - slope * years - 32.5 * (years / 100.0).powi(2)
            });
            let (count, sum) = errors.fold((0.0, 0.0), |(count, sum), error| (count + 1.0, sum + error * error));
            f64::sqrt(sum / count)
        };
        for years in [10, 20, 50, 100, 200] {
            let (rms_s, stated_s) = (rms_s(years), extrapolation_error_s(f64::from(years)));
            println!("{years} years: {rms_s:.1} s, stated {stated_s:.1} s");
            // Measured 0.75 to 1.15. The extrapolations overlap, so their mean square is itself uncertain by some tens of per cent.
            assert!((0.6..1.5).contains(&(rms_s / stated_s)), "{years}: {rms_s} s, stated {stated_s} s");
        }
        // Negative control: over a century the stated error would be too small if its third part were 0.8 s times the square of the centuries, the law of
        // `early_error_s`, even if its second part did not stop at 6 s after thirty years, but were 0.2 s a year for all hundred, 20 s.
        assert!(rms_s(100) > 1.5 * (0.05 + 0.8 + 20.0), "{}", rms_s(100));
    }

    /// Other published models: Espenak & Meeus 2006, and the parabola of the revision of 2020, -10 + 31.4 ((year - 1825) / 100)² s.
    #[test]
    fn published_models_of_the_future_differ_by_less_than_the_stated_error() {
        for year in [2500.0, 2750.0, 3000.0_f64] {
            let stated_s = delta_t_error_s((year - 2000.0) * JULIAN_YEAR_S);
            for model_s in [-20.0 + 32.0 * ((year - 1820.0) / 100.0).powi(2), -10.0 + 31.4 * ((year - 1825.0) / 100.0).powi(2)] {
                let difference_s = (at_year(year) - model_s).abs();
                assert!(difference_s < stated_s, "{year}: {difference_s} s, stated {stated_s} s");
                // Negative control: the same law, 20 s and 0.8 s times the square of the centuries since the table's end, would not cover the difference.
                assert!(difference_s > 20.0 + 0.8 * ((year - TABLE_END_YEAR) / 100.0).powi(2), "{year}: {difference_s} s");
            }
        }
    }

    /// Morrison & Stephenson, J. Hist. Astron. 35 (2004), table 1, with its standard errors: an earlier and independent reduction, which
    /// Espenak & Meeus's polynomials follow. It differs from the later spline by less than twice the combined standard error.
    const REDUCTION_OF_2004: [(f64, f64, f64); 5] =
        [(-500.0, 17_190.0, 430.0), (0.0, 10_580.0, 260.0), (500.0, 5_710.0, 140.0), (1000.0, 1_570.0, 55.0), (1600.0, 120.0, 20.0)];

    #[test]
    fn agrees_with_an_earlier_reduction_within_twice_the_combined_error() {
        for (year, seconds, sigma_s) in REDUCTION_OF_2004 {
            let ours_s = delta_t_error_s((year - 2000.0) * JULIAN_YEAR_S);
            let difference_s = (at_year(year) - seconds).abs();
            assert!(difference_s < 2.0 * ours_s.hypot(sigma_s), "{year}: {} s, published {seconds}", at_year(year));
        }
        // Delta T of 940 is outside the bounds for 1000.
        assert!((at_year(940.0) - 1_570.0).abs() > 2.0 * delta_t_error_s((1000.0 - 2000.0) * JULIAN_YEAR_S).hypot(55.0));
    }

    #[test]
    fn the_iers_table_takes_over_without_a_step() {
        // The table is used from its second entry on, 73 days into 1973; Delta T grew by 1.1 s a year.
        let seam_year = year_of_entry(1);
        let (before, after) = (at_year(seam_year - 1e-6), at_year(seam_year + 1e-6));
        assert!((1973.0..1973.4).contains(&seam_year) && (before - after).abs() < 1e-4, "{before} {after}");
        // Without the correction there would be a step.
        assert!((spline_s(seam_year) - after).abs() > 1e-3);
    }

    #[test]
    fn has_no_jumps() {
        let mut before = at_year(-4000.0);
        let mut year = -4000.0;
        while year < 4000.0 {
            year += 0.25;
            let now = at_year(year);
            // The parabola's slope at -4000 is 38 s a year, 9.5 s a step.
            assert!((now - before).abs() < 12.0, "{year}: {before} to {now}");
            if (1700.0..2600.0).contains(&year) {
                assert!((now - before).abs() < 1.5, "{year}: {before} to {now}");
            }
            before = now;
        }
    }
}
