//! Parses and formats times: ISO 8601 UTC, and `jd_tdb:` with a Julian date.
//!
//! In: a text, or an [`Instant`]. Out: the instant, or an error of one line; or the text. The calendar arithmetic is written here, because years from -9999 to
//! 9999 are read, and leap seconds must survive a round trip. Years beyond these are written with more digits, which [`parse`] rejects.

use super::{Instant, TimeError};
use crate::units::SECONDS_PER_DAY;
use crate::wording::echo_within;

/// The end of every error: the allowed forms.
const ALLOWED: &str = "give ISO 8601 UTC such as 2024-04-08T18:17:16Z, or jd_tdb:2460409.262";

/// Endings of a time of day that mean UTC: Z, and the offset of zero that many programs write.
const UTC_SUFFIXES: [&str; 5] = ["Z", "z", "+00:00", "+0000", "+00"];

/// Reads the forms that [`Instant::parse`] documents.
pub(super) fn parse(text: &str) -> Result<Instant, TimeError> {
    let time_error = |what: &str| TimeError(format!("time `{}`: {what}; {ALLOWED}", echo_within(text, 120)));
    let trimmed = text.trim();
    if let Some(number) = trimmed.strip_prefix("jd_tdb:") {
        let jd: f64 = number.trim().parse().map_err(|_| time_error("no number after jd_tdb:"))?;
        // A little more than the years from -9999 to 9999, the only ones that a calendar date with four digits can have.
        if !(-2_000_000.0..=5_400_000.0).contains(&jd) {
            return Err(time_error("a Julian date outside -2000000 to 5400000"));
        }
        return Ok(Instant::from_jd_tdb(jd));
    }
    if is_other_day_number(trimmed) {
        return Err(time_error("a day number without its kind: write a Julian date (TDB) after jd_tdb:, that is an MJD plus 2400000.5"));
    }
    // No zone follows a date without a time of day.
    if trimmed
        .strip_suffix(['Z', 'z'])
        .is_some_and(|date| date.ends_with(|c: char| c.is_ascii_digit()) && !date.contains([':', 'T', 't', ' ']))
    {
        return Err(time_error("a Z without a time of day; a date alone is 00:00:00 UTC"));
    }
    let (date, clock) = match trimmed.split_once(['T', 't', ' ']) {
        Some((date, clock)) if date.ends_with(|c: char| c.is_ascii_digit()) => (date, clock),
        // A date without a time of day; or a word with a T, such as `tomorrow`, which the error is to quote in full.
        _ => (trimmed, "00:00:00"),
    };
    let (is_negative, date) = match date.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, date.strip_prefix('+').unwrap_or(date)),
    };
    let mut date_parts = date.split('-');
    let mut field = |name: &str, digits: usize| -> Result<i64, TimeError> {
        let part = date_parts.next().ok_or_else(|| time_error(&format!("the {name} is missing")))?;
        exact_digits(part, digits).ok_or_else(|| time_error(&format!("the {name} `{}` is not {digits} digits", echo_within(part, 40))))
    };
    let (year, month, day) = (field("year", 4)?, field("month", 2)?, field("day", 2)?);
    if date_parts.next().is_some() {
        return Err(time_error("more than year, month and day"));
    }
    let year = if is_negative { -year } else { year };
    if !(1..=12).contains(&month) {
        return Err(time_error("the month is not 01 to 12"));
    }
    if day < 1 || day > days_in_month(year, month) {
        return Err(time_error("no such day in that month"));
    }
    let clock = UTC_SUFFIXES.into_iter().find_map(|suffix| clock.strip_suffix(suffix)).unwrap_or(clock);
    if clock.contains(['+', '-']) {
        return Err(time_error("an offset from UTC; convert the time to UTC, and end it with Z or nothing"));
    }
    if let Some(at) = clock.find(|c: char| !(c.is_ascii_digit() || matches!(c, ':' | '.'))) {
        let other = echo_within(clock[at..].trim(), 40);
        return Err(time_error(&format!("`{other}` in the time of day, which is hours:minutes:seconds in UTC")));
    }
    let mut clock_parts = clock.split(':');
    let mut clock_field = |name: &str, limit: i64| -> Result<i64, TimeError> {
        let part = clock_parts.next().filter(|part| !part.is_empty()).ok_or_else(|| time_error(&format!("the {name} is missing")))?;
        let value = exact_digits(part, 2).filter(|value| *value < limit);
        value.ok_or_else(|| time_error(&format!("the {name} `{}` is not 00 to {}", echo_within(part, 40), limit - 1)))
    };
    let (hour, minute) = (clock_field("hour", 24)?, clock_field("minute", 60)?);
    let second = match clock_parts.next() {
        None => 0.0,
        Some(p) => {
            let value = seconds(p).filter(|s| *s < 61.0);
            value.ok_or_else(|| time_error(&format!("the second `{}` is not 00 to 60, with a fraction or without", echo_within(p, 40))))?
        }
    };
    if clock_parts.next().is_some() {
        return Err(time_error("more than hours, minutes and seconds"));
    }
    let start_of_minute_s = (days_past_j2000_noon(year, month, day) - 0.5) * SECONDS_PER_DAY + (hour * 3600 + minute * 60) as f64;
    if second >= 60.0 {
        // Second 60 exists only in a UTC minute of 61 s. The length of the minute is measured in TT.
        let minute_start = Instant::from_utc_seconds(start_of_minute_s);
        let length_s = Instant::from_utc_seconds(start_of_minute_s + 60.0).tt_seconds_past_j2000() - minute_start.tt_seconds_past_j2000();
        if start_of_minute_s < super::UTC_START_S || length_s < 60.5 {
            return Err(time_error("that minute has no leap second"));
        }
        return Ok(minute_start.plus_seconds(second));
    }
    Ok(Instant::from_utc_seconds(start_of_minute_s + second))
}

/// Whether a text is a count of days in another form than `jd_tdb:DAY`, such as `JD2460409.5`, `mjd 60408` or `2460409.5`.
fn is_other_day_number(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let with_unit = lower.strip_prefix("mjd").or_else(|| lower.strip_prefix("jd"));
    let number = with_unit.unwrap_or(&lower).trim_start_matches(|c: char| !c.is_ascii_digit());
    // More digits than a year has, and fewer than a date.
    let is_long = || number.split('.').next().is_some_and(|whole| (5..=7).contains(&whole.len())) || number.contains('.');
    number.parse::<f64>().is_ok() && (with_unit.is_some() || lower.starts_with(|c: char| c.is_ascii_digit()) && is_long())
}

/// Parses exactly `digits` ASCII digits; `None` for any other text.
fn exact_digits(part: &str, digits: usize) -> Option<i64> {
    (part.len() == digits && part.bytes().all(|b| b.is_ascii_digit())).then(|| part.parse().ok()).flatten()
}

/// Parses `SS` or `SS.fff`; `None` for any other text.
fn seconds(part: &str) -> Option<f64> {
    let (whole_part, fraction) = part.split_once('.').unwrap_or((part, "0"));
    exact_digits(whole_part, 2)?;
    (!fraction.is_empty() && fraction.bytes().all(|b| b.is_ascii_digit())).then(|| part.parse().ok()).flatten()
}

/// The text that [`Instant::to_utc_iso`] documents.
pub(super) fn format_utc(t: Instant) -> String {
    let (utc_s, leap_s) = t.utc_seconds_rounded_to_ms();
    if !utc_s.is_finite() {
        return "not a time".to_owned();
    }
    if utc_s.abs() > MAX_CALENDAR_S {
        return format!("jd_tdb:{:e}", t.jd_tdb());
    }
    format!("{}Z", calendar_text(utc_s, leap_s))
}

/// The text that [`Instant::to_tt_iso`] documents.
pub(super) fn format_tt(t: Instant) -> String {
    let tt_s = t.tt_seconds_past_j2000();
    // TT has no leap seconds.
    let leap_s = None;
    if tt_s.abs() <= MAX_CALENDAR_S { calendar_text(tt_s, leap_s) } else { format_utc(t) }
}

/// A million years in seconds, far below the overflow of the integers in [`calendar_date`].
const MAX_CALENDAR_S: f64 = 3.2e13;

/// Date and time of day of a count of seconds past 2000-01-01T12:00, to the millisecond. `leap_s`: for a time in a leap second, the seconds since its start;
/// `count_s` is then its end.
fn calendar_text(count_s: f64, leap_s: Option<f64>) -> String {
    // Rounded to milliseconds first, so that a carry reaches every field.
    // In a leap second the clock is read one second before its end, where hour and minute are still 23:59; the second is then written as 60.
    let (clock_ms, leap_ms) = match leap_s {
        Some(leap_s) if (leap_s * 1e3).round() < 1000.0 => ((count_s * 1e3).round() - 1000.0, Some((leap_s * 1e3).round())),
        _ => ((count_s * 1e3).round(), None),
    };
    let past_midnight_ms = clock_ms + 0.5 * SECONDS_PER_DAY * 1e3;
    let day_number = (past_midnight_ms / (SECONDS_PER_DAY * 1e3)).floor();
    let ms_of_day = (past_midnight_ms - day_number * SECONDS_PER_DAY * 1e3) as i64;
    let (year, month, day) = calendar_date(day_number as i64);
    let (hour, minute) = (ms_of_day / 3_600_000, ms_of_day / 60_000 % 60);
    let (second, ms) = match leap_ms {
        Some(ms) => (60, ms as i64),
        None => (ms_of_day / 1000 % 60, ms_of_day % 1000),
    };
    let sign = if year < 0 { "-" } else { "" };
    let fraction = if ms == 0 { String::new() } else { format!(".{ms:03}") };
    format!("{sign}{:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{fraction}", year.abs())
}

fn days_in_month(year: i64, month: i64) -> i64 {
    match month {
        4 | 6 | 9 | 11 => 30,
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        _ => 31,
    }
}

/// Days from 0000-03-01 to 2000-01-01.
const DAYS_FROM_MARCH_0000_TO_2000: i64 = 730_425;
/// Days of the Gregorian calendar's cycle of 400 years.
const DAYS_PER_CYCLE: i64 = 146_097;

/// Days from 2000-01-01 to the date, both at noon. Counts from 1 March, so that the leap day ends the year; (153 m + 2) / 5 is the number of days before month
/// m of that year (H. Hinnant, chrono-Compatible Low-Level Date Algorithms, `days_from_civil`).
fn days_past_j2000_noon(year: i64, month: i64, day: i64) -> f64 {
    let year_from_march = if month <= 2 { year - 1 } else { year };
    let month_from_march = (month + 9) % 12;
    let days_before_year =
        365 * year_from_march + year_from_march.div_euclid(4) - year_from_march.div_euclid(100) + year_from_march.div_euclid(400);
    (days_before_year + (153 * month_from_march + 2) / 5 + day - 1 - DAYS_FROM_MARCH_0000_TO_2000) as f64
}

/// Year, month and day of a number of days past 2000-01-01: the inverse of [`days_past_j2000_noon`], in cycles of 400 years (Hinnant's `civil_from_days`).
fn calendar_date(days_past_2000: i64) -> (i64, i64, i64) {
    let days_past_march_0000 = days_past_2000 + DAYS_FROM_MARCH_0000_TO_2000;
    let cycle = days_past_march_0000.div_euclid(DAYS_PER_CYCLE);
    let day_of_cycle = days_past_march_0000.rem_euclid(DAYS_PER_CYCLE);
    // 1460 days: four years without their leap day. 36,524 days: a century. 146,096: the last day of the cycle.
    let year_of_cycle = (day_of_cycle - day_of_cycle / 1460 + day_of_cycle / 36_524 - day_of_cycle / 146_096) / 365;
    let day_of_year = day_of_cycle - (365 * year_of_cycle + year_of_cycle / 4 - year_of_cycle / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (400 * cycle + year_of_cycle + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message names what is wrong, and not a field that is right. Negative control: the last lines are times.
    #[test]
    fn messages_name_what_is_wrong_with_a_time() {
        for (text, message_part) in [
            ("2024-04-08T18:17:16 UTC", "`UTC` in the time of day"),
            ("2024-04-08T18:17:16 EST", "`EST` in the time of day"),
            ("2024-04-08T18:17:16,5Z", "`,5` in the time of day"),
            ("2024-04-08T18:17:16.Z", "the second `16.` is not 00 to 60"),
            ("2024-04-08T18:17:61", "the second `61` is not 00 to 60"),
            ("2024-04-08T18", "the minute is missing"),
            ("2024-04-08T18Z", "the minute is missing"),
            ("2024-04-08T18:7", "the minute `7` is not 00 to 59"),
            ("2024-04-08T", "the hour is missing"),
            ("2024-04-08T24:00", "the hour `24` is not 00 to 23"),
            ("2024-04-08Z", "a Z without a time of day"),
            ("2024-04-08T18:17+02:00", "convert the time to UTC"),
            ("JD2460409.5", "after jd_tdb:"),
            ("mjd 60408", "after jd_tdb:"),
            ("2460409.5", "after jd_tdb:"),
            ("2024", "the month is missing"),
            ("jdx", "the year `jdx`"),
        ] {
            let message = parse(text).expect_err(text).to_string();
            assert!(message.contains(message_part) && message.ends_with(ALLOWED), "{text}: {message}");
        }
        for text in ["2024-04-08T18:17:16.5Z", "2024-04-08 18:17", "2024-04-08T18:17z", "jd_tdb:2460409.5"] {
            assert!(parse(text).is_ok(), "{text}");
        }
    }

    #[test]
    fn calendar_and_day_numbers_are_inverse() {
        for n in (-3_000_000..3_000_000).step_by(977) {
            let (y, m, d) = calendar_date(n);
            assert_eq!(days_past_j2000_noon(y, m, d) as i64, n, "{y}-{m}-{d}");
        }
        assert_eq!(calendar_date(0), (2000, 1, 1));
        // 0000-03-01 (Gregorian) starts at Julian day 1 721 119.5.
        assert_eq!(calendar_date(1_721_120 - 2_451_545), (0, 3, 1));
    }
}
