//! Dates of the Julian calendar, in which history books date everything before 15 October 1582.
//!
//! In: a date of the Julian calendar, with the astronomical year (1 BC is 0). Out: the same day in the Gregorian calendar, which all other code uses.

use crate::message::FIRST_GREGORIAN_DATE;
use chrono::{Duration, NaiveDate};

/// Year, month and day of either calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CalendarDate {
    /// Astronomical year: 1 BC is 0.
    pub(crate) year: i64,
    pub(crate) month: u32,
    pub(crate) day: u32,
}

impl CalendarDate {
    /// Whether history books give this date in the Julian calendar.
    pub(crate) fn is_before_reform(self) -> bool {
        // The day before it was 4 October 1582 of the Julian calendar.
        (self.year, i64::from(self.month), i64::from(self.day)) < FIRST_GREGORIAN_DATE
    }

    /// The day that has this date in the Julian calendar; `None` if there is no such date.
    pub(crate) fn gregorian_of_julian(self) -> Option<NaiveDate> {
        let Self { year, month, day } = self;
        let month_length = match month {
            2 if year.rem_euclid(4) == 0 => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return None,
        };
        if !(1..=month_length).contains(&day) {
            return None;
        }
        // Counted from 1 March, so that the leap day ends the year; (153 m + 2) / 5 is the number of days before month m of that year.
        let year_from_march = if month <= 2 { year - 1 } else { year };
        let month_from_march = i64::from((month + 9) % 12);
        let days_from_march_0000 =
            365 * year_from_march + year_from_march.div_euclid(4) + (153 * month_from_march + 2) / 5 + i64::from(day) - 1;
        // 1 March of the year 0 is two days earlier in the Julian calendar than in the Gregorian one.
        NaiveDate::from_ymd_opt(0, 3, 1)?.checked_add_signed(Duration::try_days(days_from_march_0000 - 2)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Instant;
    use crate::view::app::civil_time::ShownTimeZone;
    use crate::view::app::date_text::{julian_date, parse_date, resembles_date};

    /// Days with known dates in both calendars (Explanatory Supplement, 3rd ed., section 15.3; Meeus, Astronomical Algorithms, chapter 7).
    #[test]
    fn days_have_their_dates_in_both_calendars() {
        for ((year, month, day), gregorian) in [
            ((1582, 10, 5), "1582-10-15"),
            ((1582, 10, 4), "1582-10-14"),
            ((1066, 10, 14), "1066-10-20"),
            ((1917, 10, 25), "1917-11-07"),
            ((300, 2, 28), "0300-02-28"),
            ((300, 2, 29), "0300-03-01"),
            ((200, 3, 1), "0200-03-01"),
            ((1, 1, 1), "0000-12-30"),
            ((-43, 3, 15), "-0043-03-13"),
            ((-584, 5, 28), "-0584-05-22"),
            // The start of the Julian period: day 0 at noon.
            ((-4712, 1, 1), "-4713-11-24"),
        ] {
            let found = CalendarDate { year, month, day }.gregorian_of_julian().expect("a date");
            assert_eq!(found.format("%Y-%m-%d").to_string(), gregorian, "{year}-{month}-{day}");
        }
        for (year, month, day) in [(1500, 2, 30), (1501, 2, 29), (1500, 13, 1), (1500, 0, 1), (1500, 4, 31), (1500, 1, 0)] {
            assert_eq!(CalendarDate { year, month, day }.gregorian_of_julian(), None, "{year}-{month}-{day}");
        }
        // A leap year of the Julian calendar alone.
        assert!(CalendarDate { year: 1500, month: 2, day: 29 }.gregorian_of_julian().is_some());
        let reform = |day| CalendarDate { year: 1582, month: 10, day }.is_before_reform();
        assert!(reform(14) && !reform(15));
    }

    /// History books date in the Julian calendar what happened before 15 October 1582. Digits alone are Gregorian, as the date field shows them.
    #[test]
    fn dates_in_words_before_the_reform_are_julian() {
        let parsed = |text: &str| parse_date(text, ShownTimeZone::Utc, Instant::from_tdb_seconds_past_j2000(0.0));
        let day = |text: &str| parsed(text).unwrap_or_else(|| panic!("{text}")).plus_seconds(0.5).to_utc_iso();
        for (text, iso, is_julian) in [
            // The eclipse of Thales, the battle of Hastings, the last Julian day and the first Gregorian one.
            ("28 May 585 BC", "-0584-05-22", true),
            ("May 28, 585 BC (Julian)", "-0584-05-22", true),
            ("22 May 585 BC (Gregorian)", "-0584-05-22", false),
            ("22. Mai 585 v. Chr. (greg.)", "-0584-05-22", false),
            ("14 October 1066", "1066-10-20", true),
            ("29 February 1500", "1500-03-10", true),
            ("4 October 1582", "1582-10-14", true),
            ("15 October 1582", "1582-10-15", false),
            ("25 October 1917 Julian", "1917-11-07", true),
            ("7 November 1917", "1917-11-07", false),
            ("-0584-05-28", "-0584-05-28", false),
            ("28.05.585 v. Chr.", "-0584-05-28", false),
            ("1066-10-14", "1066-10-14", false),
            ("14.10.1066", "1066-10-14", false),
            ("1066", "1066-01-01", false),
        ] {
            assert!(day(text).starts_with(iso), "{text}: {}", day(text));
            assert_eq!(julian_date(text).is_some(), is_julian, "{text}");
        }
        for none in ["29 February 1501", "30 February 1500", "julian", "28 may 585 bc julian gregorian", "mars"] {
            assert!(parsed(none).is_none() && julian_date(none).is_none(), "{none}");
        }
        assert!(resembles_date("28 May 585 BC (Julian)"));
    }
}
