//! Formats dates as is usual in the window's language.
//!
//! In: instants, the displayed time zone, ISO 8601 text, calendar dates. Out: text. Always: a day and a time of day are in the given zone, or name UTC; the
//! messages `date-*` determine order and punctuation, `month-*` the names of months. A date in words before the Gregorian calendar says that it is in it. An
//! instant that ISO 8601 cannot express is written as a Julian date, in every language alike. Not here: parsing of typed dates (`view::app::date_text`).

use super::numbers::localised;
use super::{text, translated_name};
use crate::message::{FIRST_GREGORIAN_DATE, time_scale};
use crate::time::Instant;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::julian_calendar::CalendarDate;
use chrono::{Datelike, NaiveDate};

/// An instant in UTC, with milliseconds if they are not zero.
pub(crate) fn instant_text(t: Instant) -> String {
    let iso = t.to_utc_iso();
    match iso.trim_end_matches('Z').split_once('T') {
        Some((date, clock)) => {
            let scale = time_scale(date_fields(date).and_then(|fields| fields.numbers()).map_or(i64::MAX, |(year, ..)| year));
            text!("date-instant", date = iso_date_text(date), clock = localised(clock.to_owned()), scale = scale)
        }
        None => iso,
    }
}

/// An instant in a zone, rounded to the minute, with the zone's label.
pub(crate) fn minute_text(t: Instant, zone: ShownTimeZone) -> String {
    let t = t.plus_seconds(30.0);
    labelled(t, zone, "hh:mm".len())
}

/// As [`minute_text`], with the date in digits: for lines that have little room.
pub(crate) fn short_minute_text(t: Instant, zone: ShownTimeZone) -> String {
    let t = t.plus_seconds(30.0);
    match date_and_clock(t, zone, "hh:mm".len()) {
        Some((date, clock)) => text!("date-minute", date = date_in_digits(&date), clock = clock, zone = zone.label(t)),
        None => t.to_utc_iso(),
    }
}

/// As [`minute_text`], without the label: for lists beside which the zone is named.
pub(crate) fn minute_text_without_zone(t: Instant, zone: ShownTimeZone) -> String {
    let t = t.plus_seconds(30.0);
    match date_and_clock(t, zone, "hh:mm".len()) {
        Some((date, clock)) => text!("date-field", date = iso_date_text(&date), clock = clock),
        None => t.to_utc_iso(),
    }
}

/// An instant in a zone, rounded to the second, with the zone's label.
pub(crate) fn second_text(t: Instant, zone: ShownTimeZone) -> String {
    labelled(t.plus_seconds(0.5), zone, "hh:mm:ss".len())
}

/// Day, the first `clock_length` characters of the time of day, and the label of the zone, without rounding.
fn labelled(t: Instant, zone: ShownTimeZone, clock_length: usize) -> String {
    match date_and_clock(t, zone, clock_length) {
        Some((date, clock)) => text!("date-minute", date = iso_date_text(&date), clock = clock, zone = zone.label(t)),
        None => t.to_utc_iso(),
    }
}

/// The ISO 8601 date of an instant in a zone, and the first `clock_length` characters of its time of day, without rounding. `None` outside the range of years
/// of ISO 8601, and in local time outside the calendar's.
fn date_and_clock(t: Instant, zone: ShownTimeZone, clock_length: usize) -> Option<(String, String)> {
    let iso = match zone {
        ShownTimeZone::Utc => t.to_utc_iso(),
        // The civil time is rounded to whole seconds.
        ShownTimeZone::Local => zone.civil_time(t.plus_seconds(-0.5))?.format("%Y-%m-%dT%H:%M:%S").to_string(),
    };
    let (date, clock) = iso.split_once('T')?;
    Some((date.to_owned(), clock.get(..clock_length)?.to_owned()))
}

/// Date in digits, hour and minute of an instant in UTC, without rounding: for the names of stored views, which stay when another zone is displayed.
pub(crate) fn minute_in_digits(t: Instant) -> String {
    match date_and_clock(t, ShownTimeZone::Utc, "hh:mm".len()) {
        Some((date, clock)) => format!("{} {clock} UTC", date_in_digits(&date)),
        None => t.to_utc_iso(),
    }
}

/// Month, day and time of day in a zone, rounded to the second, for the contacts of an event.
pub(crate) fn month_day_second_text(t: Instant, zone: ShownTimeZone) -> String {
    let t = t.plus_seconds(0.5);
    let parts = date_and_clock(t, zone, "hh:mm:ss".len());
    match parts.as_ref().and_then(|(date, clock)| Some((date_fields(date)?, clock))) {
        Some((DateFields { month, day, .. }, clock)) => {
            text!("date-month-day-second", month = month, day = day, clock = clock)
        }
        None => t.to_utc_iso(),
    }
}

/// The day of an instant in a zone, which is the day that the date field shows for it: for lists, whose zone is named beside them or in a tooltip.
pub(crate) fn day_text(t: Instant, zone: ShownTimeZone) -> String {
    let t = t.plus_seconds(0.5);
    match date_and_clock(t, zone, 0) {
        Some((date, _)) => iso_date_text(&date),
        None => t.to_utc_iso(),
    }
}

/// An ISO 8601 date in the language's usual form.
pub(super) fn iso_date_text(date: &str) -> String {
    let Some(fields) = date_fields(date) else { return date.to_owned() };
    let DateFields { year, month, day } = fields;
    let month_name = translated_name("month", month.trim_start_matches('0'));
    let mut year_text = year_text(year);
    if fields.numbers().is_some_and(|numbers| numbers < FIRST_GREGORIAN_DATE) {
        year_text = text!("date-year-gregorian", year = year_text);
    }
    text!("date-day", year = year_text, month = month, month_name = month_name, day = day, day_number = without_leading_zeros(day))
}

/// An ISO 8601 date in digits, for fields that can be edited.
pub(crate) fn date_in_digits(date: &str) -> String {
    let Some(DateFields { year, month, day }) = date_fields(date) else { return date.to_owned() };
    text!("date-digits", year = year_text(year), month = month, day = day)
}

/// Year, month and day of an ISO 8601 date, in its own characters.
#[derive(Clone, Copy)]
struct DateFields<'d> {
    year: &'d str,
    month: &'d str,
    day: &'d str,
}

impl DateFields<'_> {
    /// Year, month and day as numbers.
    fn numbers(self) -> Option<(i64, i64, i64)> {
        Some((self.year.trim_start_matches('+').parse().ok()?, self.month.parse().ok()?, self.day.parse().ok()?))
    }
}

/// The fields of an ISO 8601 date; `None` if it does not have three.
fn date_fields(date: &str) -> Option<DateFields<'_>> {
    // Split from the end, because a negative year begins with a hyphen.
    let mut from_end = date.rsplitn(3, '-');
    let (day, month, year) = (from_end.next()?, from_end.next()?, from_end.next()?);
    Some(DateFields { year, month, day })
}

/// The number in a text, such as 8 for `08`; 0 if the text is not a number.
fn without_leading_zeros(digits: &str) -> u32 {
    digits.parse().unwrap_or_default()
}

/// The text of an ISO 8601 year. Year 0 is 1 BC, and year -1 is 2 BC; a message determines how the language writes years BC.
fn year_text(iso: &str) -> String {
    match iso.trim_start_matches('+').parse::<i64>() {
        Ok(year) if year <= 0 => text!("date-iso-year-bc", iso = iso, year = 1 - year),
        _ => iso.to_owned(),
    }
}

/// The full name of a date's month.
pub(crate) fn month_name(date: NaiveDate) -> &'static str {
    translated_name("month", month_number(date))
}

/// The short name of a date's month.
pub(crate) fn short_month_name(date: NaiveDate) -> &'static str {
    translated_name("month-short", month_number(date))
}

/// The number of a date's month, `1` to `12`, as in the ids of the messages `month-…`.
fn month_number(date: NaiveDate) -> &'static str {
    const NUMBERS: [&str; 12] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"];
    // `month0` is at most 11. The remainder makes an index out of range impossible.
    NUMBERS[date.month0() as usize % NUMBERS.len()]
}

/// Day, month and year, for screen readers: `8 April 2024`.
pub(crate) fn long_date(date: NaiveDate) -> String {
    // Years before 1 keep their astronomical number, as in the year field of the calendar.
    text!("date-long", day = date.day(), month = month_name(date), year = date.format("%Y").to_string())
}

/// A date in words with its era: `28 May 585 BC`.
pub(crate) fn written_date(CalendarDate { year, month, day }: CalendarDate) -> String {
    let year = if year > 0 { year.to_string() } else { text!("date-year-bc", year = 1 - year) };
    text!("date-long", day = day, month = translated_name("month", &month.to_string()), year = year)
}

/// Day and month: `8 Apr`.
pub(crate) fn day_and_month(date: NaiveDate) -> String {
    text!("date-short", day = date.day(), month = short_month_name(date))
}
