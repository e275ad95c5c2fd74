//! Dates as the window's language writes them.
//!
//! In: ISO 8601 text of the time module, months. Out: text. Always: English keeps the ISO order; German has day, month and year with points, and years before Christ as such.

use super::{Language, current, named, text};
use crate::time::Instant;
use chrono::{Datelike, NaiveDate};

/// An instant in UTC, to the millisecond if it has any.
pub(crate) fn instant_text(t: Instant) -> String {
    let iso = t.to_utc_iso();
    match (current(), iso.trim_end_matches('Z').split_once('T')) {
        (Language::German, Some((date, clock))) => format!("{} {} UTC", date_text(date), clock.replace('.', ",")),
        _ => iso,
    }
}

/// The day of an instant, UTC.
pub(crate) fn day_text(t: Instant) -> String {
    let iso = t.to_utc_iso();
    date_text(iso.split_once('T').map_or("", |(date, _)| date))
}

/// An ISO 8601 date, `2024-04-08`.
pub(crate) fn date_text(date: &str) -> String {
    let mut fields = date.rsplitn(3, '-');
    match (current(), fields.next(), fields.next(), fields.next()) {
        (Language::German, Some(day), Some(month), Some(year)) => format!("{day}.{month}.{}", year_text(year)),
        _ => date.to_owned(),
    }
}

/// Month and day of an ISO 8601 date.
pub(crate) fn month_day_text(month: &str, day: &str) -> String {
    match current() {
        Language::English => format!("{month}-{day}"),
        Language::German => format!("{day}.{month}."),
    }
}

/// An ISO 8601 year; those up to 0 are before Christ.
fn year_text(year: &str) -> String {
    match year.trim_start_matches('+').parse::<i64>() {
        Ok(number) if number <= 0 => text!("date-year-bc", year = 1 - number),
        _ => year.to_owned(),
    }
}

/// The full name of a date's month.
pub(crate) fn month_name(date: NaiveDate) -> &'static str {
    let number = NUMBERS[date.month0() as usize % NUMBERS.len()];
    named("month", number)
}

/// A few letters of it.
pub(crate) fn month_short(date: NaiveDate) -> &'static str {
    let number = NUMBERS[date.month0() as usize % NUMBERS.len()];
    named("month-short", number)
}

const NUMBERS: [&str; 12] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"];

/// Day, month and year: `8 April 2024`.
pub(crate) fn long_date(date: NaiveDate) -> String {
    // Years before 1 as chrono counts them, as everywhere in the calendar.
    text!("date-long", day = date.day(), month = month_name(date), year = date.format("%Y").to_string())
}

/// Day and month: `8 Apr`.
pub(crate) fn day_and_month(date: NaiveDate) -> String {
    text!("date-short", day = date.day(), month = month_short(date))
}
