//! Instants and time scales: conversions between civil times, Julian dates and seconds of TDB.
//!
//! In: text, Julian dates or seconds, in one of the time scales. Out: an [`Instant`], which gives them in every scale. Always: an [`Instant`] is a number of
//! TDB seconds past J2000; nothing here reads a clock.
//!
//! * TT is TAI + 32.184 s. TDB - TT is the seven-term series of USNO Circular 179 (Kaplan 2005), eq. 2.6, good to 10 µs from 1600 to 2200.
//! * UTC from 1972 on is TAI less the leap seconds that the crate hifitime knows. After the last of them TAI - UTC stays at 37 s, because no
//!   other has been announced: far in the future UTC runs with atomic time, and UT1 - UTC may exceed 0.9 s.
//! * "UTC" before 1972-01-01 means UT1: the civil time of those years followed the Earth's rotation. On that date the two differ by
//!   0.045 s.
//! * UT1 is TT less Delta T; the model and its error are in [`delta_t`].
//! * Calendar dates are Gregorian for all years, with astronomical year numbers (year 0 is 1 BC), as ISO 8601 has it.

pub mod delta_t;
mod delta_t_table;
mod step;
mod text;

use crate::units::{DAYS_PER_JULIAN_CENTURY, JD_J2000, SECONDS_PER_DAY};
use hifitime::leap_seconds::{LatestLeapSeconds, LeapSecond};
pub use step::TimeStep;

/// Smallest standard error of Delta T that is printed beside a time: half of the second to which times are printed.
pub(crate) const MIN_SHOWN_DELTA_T_ERROR_S: f64 = 0.5;

/// TT - TAI in seconds, exact (IAU 1991).
const TT_MINUS_TAI_S: f64 = 32.184;
/// Seconds from hifitime's origin, 1900-01-01T00:00, to 2000-01-01T12:00, at 86 400 s to every day: 36524.5 days.
const J2000_PAST_1900_S: f64 = 36_524.5 * SECONDS_PER_DAY;
/// 1972-01-01T00:00 UTC, where UTC with leap seconds starts, in seconds past 2000-01-01T12:00 UTC at 86 400 s to every day.
const UTC_START_S: f64 = -10_227.5 * SECONDS_PER_DAY;

/// An instant: seconds of TDB past J2000 (2000-01-01T12:00 TDB).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Instant {
    tdb_s: f64,
}

/// A time that cannot be read. One line: what was given, what is wrong, what is allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct TimeError(pub String);

impl Instant {
    /// TDB seconds past 2000-01-01T12:00 TDB.
    pub fn from_tdb_seconds_past_j2000(tdb_s: f64) -> Self {
        Self { tdb_s }
    }

    /// Julian date in TDB.
    pub fn from_jd_tdb(jd_tdb: f64) -> Self {
        Self { tdb_s: (jd_tdb - JD_J2000) * SECONDS_PER_DAY }
    }

    /// Julian date in TT.
    pub fn from_jd_tt(jd_tt: f64) -> Self {
        Self::from_tt_seconds((jd_tt - JD_J2000) * SECONDS_PER_DAY)
    }

    /// Julian date of UTC, as [`Instant::parse`] understands UTC (UT1 before 1972). A double holds a Julian date to 40 µs only.
    pub fn from_jd_utc(jd_utc: f64) -> Self {
        Self::from_utc_seconds((jd_utc - JD_J2000) * SECONDS_PER_DAY)
    }

    /// ISO 8601 UTC (`2024-04-08T18:17:16Z`, years before 1 as astronomical `-2999-…`) or `jd_tdb:2460409.262`.
    ///
    /// The time of day may be left out (midnight), its seconds may be left out or carry a fraction, and the `Z` may be left out or
    /// written as `+00:00`. A second 60 is accepted where UTC has a leap second.
    pub fn parse(text: &str) -> Result<Self, TimeError> {
        text::parse(text)
    }

    /// TDB seconds past 2000-01-01T12:00 TDB.
    pub fn tdb_seconds_past_j2000(self) -> f64 {
        self.tdb_s
    }

    /// Julian date in TDB.
    pub fn jd_tdb(self) -> f64 {
        self.tdb_s / SECONDS_PER_DAY + JD_J2000
    }

    /// Julian date in TT.
    pub fn jd_tt(self) -> f64 {
        self.tt_seconds_past_j2000() / SECONDS_PER_DAY + JD_J2000
    }

    /// TT in seconds past 2000-01-01T12:00 TT.
    pub fn tt_seconds_past_j2000(self) -> f64 {
        // TDB - TT changes by less than 4e-10 s per second, so its argument may be either scale.
        self.tdb_s - tdb_minus_tt_s(self.tdb_s)
    }

    /// Julian date in UT1; error as stated in [`delta_t`].
    pub fn jd_ut1(self) -> f64 {
        self.ut1_seconds_past_j2000() / SECONDS_PER_DAY + JD_J2000
    }

    /// Delta T = TT - UT1 in seconds, and its standard error (see [`delta_t`]). An error of one second turns the Earth by 15 arcseconds.
    pub fn delta_t_and_error_s(self) -> (f64, f64) {
        let tt_s = self.tt_seconds_past_j2000();
        (delta_t::delta_t_s(tt_s), delta_t::delta_t_error_s(tt_s))
    }

    /// UT1 in seconds past 2000-01-01T12:00 UT1; error as stated in [`delta_t`].
    pub fn ut1_seconds_past_j2000(self) -> f64 {
        let tt_s = self.tt_seconds_past_j2000();
        tt_s - delta_t::delta_t_s(tt_s)
    }

    /// `2024-04-08T18:17:16Z`, with milliseconds when they are not zero; more than a million years before or after 2000, `jd_tdb:` with the Julian
    /// date; `not a time` if it is not finite. [`Self::parse`] reads years of four digits only.
    pub fn to_utc_iso(self) -> String {
        text::format_utc(self)
    }

    /// The same in TT: `2024-04-08T18:18:25.184`, without a Z.
    pub fn to_tt_iso(self) -> String {
        text::format_tt(self)
    }

    /// The instant `s` TDB seconds later.
    pub fn plus_seconds(self, s: f64) -> Self {
        Self { tdb_s: self.tdb_s + s }
    }

    /// The instant `s` seconds of UTC later, in which leap seconds count: the time that elapses, except before 1972, when these are seconds of UT1.
    pub fn plus_elapsed_seconds(self, s: f64) -> Self {
        if s == 0.0 {
            return self;
        }
        // A count of seconds in which no second is left out: UT1, and from 1972 on TAI, moved so that both agree at that time, to 0.045 s.
        let tai_count_s = self.tt_seconds_past_j2000() - TT_MINUS_TAI_S - FIRST_TAI_MINUS_UTC_S;
        let end_s = s + if tai_count_s < UTC_START_S { self.ut1_seconds_past_j2000() } else { tai_count_s };
        if end_s < UTC_START_S {
            Self::from_ut1_seconds(end_s)
        } else {
            Self::from_tt_seconds(end_s + FIRST_TAI_MINUS_UTC_S + TT_MINUS_TAI_S)
        }
    }

    /// The instant `s` UTC seconds later, at 86 400 s to every day: a day later is the same time of day, because leap seconds in the span are not counted.
    /// Only if the span begins within a leap second, its part of that leap second is counted: a second after 23:59:60 is midnight.
    pub fn plus_utc_seconds(self, s: f64) -> Self {
        if s == 0.0 {
            return self;
        }
        match self.utc_seconds_rounded_to_ms() {
            (_, Some(into_leap_s)) if (0.0..1.0).contains(&(into_leap_s + s)) => self.plus_seconds(s),
            (midnight_s, Some(into_leap_s)) => {
                // The count of UTC seconds is `midnight_s` both at the start of the leap second and at its end. Forward, the span ends `into_leap_s + s - 1`
                // after that end; backward, it ends `-(into_leap_s + s)` before that start.
                let uncounted_s = if s > 0.0 { 1.0 } else { 0.0 };
                Self::from_utc_seconds(midnight_s + into_leap_s + s - uncounted_s)
            }
            _ => {
                let (utc_s, _) = self.utc_seconds();
                Self::from_utc_seconds(utc_s + s)
            }
        }
    }

    /// `tt_s`: TT seconds past 2000-01-01T12:00 TT.
    fn from_tt_seconds(tt_s: f64) -> Self {
        Self { tdb_s: tt_s + tdb_minus_tt_s(tt_s) }
    }

    /// `utc_s`: UTC seconds past 2000-01-01T12:00, at 86 400 s to every day, so that a leap second has no number of its own.
    fn from_utc_seconds(utc_s: f64) -> Self {
        if utc_s < UTC_START_S {
            return Self::from_ut1_seconds(utc_s);
        }
        // `timestamp_tai_s` counts UTC, not TAI: see `leap_seconds`. The sum, about 3e9, is rounded to 0.5 µs. So a time that earlier rounding has put slightly
        // before midnight counts as midnight, after the leap second.
        let last_leap = leap_seconds().rev().find(|l| utc_s + J2000_PAST_1900_S >= l.timestamp_tai_s);
        let tai_minus_utc_s = last_leap.map_or(FIRST_TAI_MINUS_UTC_S, |l| l.delta_at);
        Self::from_tt_seconds(utc_s + tai_minus_utc_s + TT_MINUS_TAI_S)
    }

    /// `ut1_s`: UT1 seconds past 2000-01-01T12:00 UT1.
    fn from_ut1_seconds(ut1_s: f64) -> Self {
        // Delta T changes by less than 1e-5 s per second, so each iteration reduces the error by that factor: two would be exact to rounding, four are safe.
        let mut tt_s = ut1_s;
        for _ in 0..4 {
            tt_s = ut1_s + delta_t::delta_t_s(tt_s);
        }
        Self::from_tt_seconds(tt_s)
    }

    /// UTC seconds (86 400 to a day) past 2000-01-01T12:00. Within a leap second, the first value is the count at the following midnight, and the second
    /// value is the seconds since the leap second began; otherwise the second value is `None`.
    fn utc_seconds(self) -> (f64, Option<f64>) {
        self.utc_seconds_of_tai(self.tt_seconds_past_j2000() - TT_MINUS_TAI_S)
    }

    /// [`Self::utc_seconds`] of the nearest millisecond. A leap second's start, as a number of TDB seconds, may be rounded to 10 ns before it; the result is
    /// then still the leap second's start.
    fn utc_seconds_rounded_to_ms(self) -> (f64, Option<f64>) {
        let tai_s = self.tt_seconds_past_j2000() - TT_MINUS_TAI_S;
        self.utc_seconds_of_tai((tai_s * 1e3).round() / 1e3)
    }

    /// [`Self::utc_seconds`], with `tai_s` for the TAI of this instant, which the caller may have rounded.
    fn utc_seconds_of_tai(self, tai_s: f64) -> (f64, Option<f64>) {
        if tai_s - FIRST_TAI_MINUS_UTC_S < UTC_START_S {
            return (self.ut1_seconds_past_j2000(), None);
        }
        let mut tai_minus_utc_s = FIRST_TAI_MINUS_UTC_S;
        for leap in leap_seconds() {
            // The count of UTC seconds when the leap second ends.
            let new_day_utc_s = leap.timestamp_tai_s - J2000_PAST_1900_S;
            if tai_s >= new_day_utc_s + leap.delta_at {
                tai_minus_utc_s = leap.delta_at;
            } else if tai_s >= new_day_utc_s + tai_minus_utc_s {
                return (new_day_utc_s, Some(tai_s - new_day_utc_s - tai_minus_utc_s));
            } else {
                break;
            }
        }
        (tai_s - tai_minus_utc_s, None)
    }
}

/// TAI - UTC on 1972-01-01.
const FIRST_TAI_MINUS_UTC_S: f64 = 10.0;

/// The leap seconds by time. Despite its name, hifitime's `timestamp_tai_s` is not TAI but the count of UTC seconds (86 400 s a day since 1900) at the start of
/// the day after the leap second; the test `leap_seconds_count_as_published` verifies this.
fn leap_seconds() -> impl DoubleEndedIterator<Item = LeapSecond> {
    LatestLeapSeconds::default().filter(|l| l.announced_by_iers)
}

/// TDB - TT in seconds; the argument is seconds past J2000 in either scale. USNO Circular 179, eq. 2.6.
fn tdb_minus_tt_s(s: f64) -> f64 {
    // Julian centuries.
    let t = s / (DAYS_PER_JULIAN_CENTURY * SECONDS_PER_DAY);
    0.001657 * (628.3076 * t + 6.2401).sin()
        + 0.000022 * (575.3385 * t + 4.2970).sin()
        + 0.000014 * (1256.6152 * t + 6.1969).sin()
        + 0.000005 * (606.9777 * t + 4.0212).sin()
        + 0.000005 * (52.9691 * t + 0.4444).sin()
        + 0.000002 * (21.3299 * t + 5.5431).sin()
        + 0.000010 * t * (628.3076 * t + 4.2490).sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tt_of(text: &str) -> f64 {
        Instant::parse(text).expect(text).tt_seconds_past_j2000()
    }

    #[test]
    fn leap_seconds_count_as_published() {
        // IERS Bulletin C: TAI-UTC was 10 s from 1972-01-01, 32 s in 2000, 36 s in 2016, 37 s from 2017-01-01.
        for (text, utc_s, tai_minus_utc_s) in [
            ("1972-01-01T00:00:00Z", UTC_START_S, 10.0),
            ("2000-01-01T12:00:00Z", 0.0, 32.0),
            ("2016-12-31T12:00:00Z", 6209.0 * 86_400.0, 36.0),
            ("2017-01-01T00:00:00Z", 6209.5 * 86_400.0, 37.0),
            ("2100-01-01T12:00:00Z", 36_525.0 * 86_400.0, 37.0),
        ] {
            assert!((tt_of(text) - utc_s - tai_minus_utc_s - 32.184).abs() < 1e-5, "{text}: {}", tt_of(text) - utc_s);
        }
        assert!((tt_of("2017-01-01T00:00:00Z") - tt_of("2016-12-31T23:59:59Z") - 2.0).abs() < 1e-5);
        assert!((tt_of("2017-01-01T00:00:00Z") - tt_of("2016-12-31T23:59:60Z") - 1.0).abs() < 1e-5);
    }

    #[test]
    fn utc_text_round_trips() {
        for text in [
            "2024-04-08T18:17:16Z",
            "2016-12-31T23:59:60Z",
            "2016-12-31T23:59:59Z",
            "2017-01-01T00:00:00Z",
            "1972-06-30T23:59:60.500Z",
            "1972-01-01T00:00:00Z",
            // As numbers of TDB seconds, these leap seconds are rounded to some nanoseconds before they begin.
            "1987-12-31T23:59:60Z",
            "1995-12-31T23:59:60Z",
            "1998-12-31T23:59:60Z",
            "2005-12-31T23:59:60Z",
            "1969-07-20T20:17:40Z",
            "1600-02-29T00:00:00Z",
            "-2999-01-01T12:00:00Z",
            "0000-03-01T00:00:00Z",
            "3000-12-31T23:59:59.125Z",
        ] {
            assert_eq!(Instant::parse(text).expect(text).to_utc_iso(), text);
        }
    }

    #[test]
    fn an_offset_of_zero_is_utc() {
        let instant = Instant::parse("2024-04-08T18:17:16.500Z");
        for text in ["2024-04-08T18:17:16.5+00:00", "2024-04-08 18:17:16.500+00", "2024-04-08T18:17:16.5+0000"] {
            assert_eq!(Instant::parse(text), instant, "{text}");
        }
        assert!(instant.is_ok() && Instant::parse("2024-04-08T18:17+01:00").is_err());
    }

    #[test]
    fn a_span_from_within_a_leap_second_counts_its_part_of_it() {
        for (begin, s, text) in [
            ("2016-12-31T23:59:60Z", 0.0, "2016-12-31T23:59:60Z"),
            ("2016-12-31T23:59:60Z", 0.5, "2016-12-31T23:59:60.500Z"),
            ("2016-12-31T23:59:60Z", 1.0, "2017-01-01T00:00:00Z"),
            ("2016-12-31T23:59:60Z", 2.0, "2017-01-01T00:00:01Z"),
            ("2016-12-31T23:59:60Z", 86_400.0, "2017-01-01T23:59:59Z"),
            ("2016-12-31T23:59:60Z", -1.0, "2016-12-31T23:59:59Z"),
            ("2016-12-31T23:59:60.750Z", 0.5, "2017-01-01T00:00:00.250Z"),
            ("2016-12-31T23:59:60.750Z", -0.5, "2016-12-31T23:59:60.250Z"),
            // As a number of TDB seconds, this leap second is rounded to some nanoseconds before it begins.
            ("1987-12-31T23:59:60Z", 1.0, "1988-01-01T00:00:00Z"),
        ] {
            assert_eq!(Instant::parse(begin).expect("a leap second").plus_utc_seconds(s).to_utc_iso(), text, "{begin} and {s} s");
        }
    }

    #[test]
    fn tt_text_is_ahead_of_utc_by_69_184_seconds() {
        let t = Instant::parse("2024-04-08T18:17:20Z").expect("a time");
        assert_eq!(t.to_tt_iso(), "2024-04-08T18:18:29.184");
    }

    #[test]
    fn julian_dates_round_trip_and_tdb_stays_near_tt() {
        for jd in [625_673.5, 2_327_796.140625, 2_451_545.0, 2_460_409.262, 2_816_787.5] {
            let t = Instant::from_jd_tdb(jd);
            assert!((t.jd_tdb() - jd).abs() < 1e-9);
            assert!(((t.jd_tdb() - t.jd_tt()) * 86_400.0).abs() < 2e-3);
            assert!((Instant::from_jd_tt(t.jd_tt()).tdb_seconds_past_j2000() - t.tdb_seconds_past_j2000()).abs() < 1e-4);
        }
        // tests/data/ephemeris_public.json pairs jd_tt 2440423.25 with jd_tdb 2440423.2499999944 (4e-10 days is a double's step there).
        assert!((Instant::from_jd_tt(2_440_423.25).jd_tdb() - 2_440_423.249_999_994_4).abs() < 1e-9);
    }

    #[test]
    fn bad_times_are_refused_in_one_line() {
        for text in [
            "",
            "yesterday",
            "2024-13-01",
            "2023-02-29",
            "2024-04-08T25:00:00Z",
            "2024-04-08T18:17:60Z",
            "jd_tdb:",
            "jd_tdb:inf",
            "2024-04-08T18:17:16+02:00",
            "\u{661}\u{662}",
        ] {
            let error = Instant::parse(text).expect_err(text).to_string();
            assert!(!error.contains('\n') && error.len() > 10, "{error}");
        }
        // A `t` ends the date only after a digit, which is not so in this word.
        let error = Instant::parse("yesterday").expect_err("no date").to_string();
        assert!(error.contains("the year `yesterday` is not 4 digits"), "{error}");
    }
}
