//! Times and places as short text for people.
//!
//! In: instants, places. Out: short texts without milliseconds. Not here: ISO 8601 for machines (`time`).

use crate::events::Place;
use crate::time::Instant;
use crate::view::language::dates::{date_text, month_day_text};
use crate::view::language::{decimal, named};

/// `2024-04-08 18:17 UTC`, rounded to the minute.
pub(crate) fn utc_minute(t: Instant) -> String {
    dated(&t.plus_seconds(30.0).to_utc_iso(), "hh:mm".len())
}

/// Month, day and time of day, `04-08 18:17:16`, UTC, rounded to the second: for lists of one event's instants.
pub(crate) fn utc_day_second(t: Instant) -> String {
    let whole = truncated(&t.plus_seconds(0.5).to_utc_iso(), "hh:mm:ss".len());
    let Some((date, clock)) = whole.trim_end_matches(" UTC").split_once(' ') else { return whole };
    let mut fields = date.rsplit('-');
    match (fields.next(), fields.next()) {
        (Some(day), Some(month)) => format!("{} {clock}", month_day_text(month, day)),
        _ => whole,
    }
}

/// The date and the first `clock_chars` characters of the time. Outside the calendar, a Julian date.
fn truncated(iso: &str, clock_chars: usize) -> String {
    match iso.split_once('T').and_then(|(date, clock)| Some((date, clock.get(..clock_chars)?))) {
        Some((date, clock)) => format!("{date} {clock} UTC"),
        None => iso.to_owned(),
    }
}

/// As [`truncated`], with the date as the language writes it.
fn dated(iso: &str, clock_chars: usize) -> String {
    let whole = truncated(iso, clock_chars);
    whole.split_once(' ').map_or(whole.clone(), |(date, clock)| format!("{} {clock}", date_text(date)))
}

/// `25.5° N, 33.2° E`.
pub(crate) fn place_text(place: Place) -> String {
    place_degrees(place.latitude_deg, place.longitude_deg, 1)
}

/// Latitude and longitude with their directions in place of signs.
pub(crate) fn place_degrees(latitude_deg: f64, longitude_deg: f64, digits: usize) -> String {
    let side = |deg: f64, positive, negative| {
        let direction = named("direction", if deg < 0.0 { negative } else { positive });
        format!("{}° {direction}", decimal(deg.abs(), digits))
    };
    format!("{}, {}", side(latitude_deg, "north", "south"), side(longitude_deg, "east", "west"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_and_carry_over() {
        let at = |text: &str| Instant::parse(text).expect(text);
        assert_eq!(utc_minute(at("2024-04-08T18:17:16Z")), "2024-04-08 18:17 UTC");
        assert_eq!(utc_minute(at("1999-12-31T23:59:40Z")), "2000-01-01 00:00 UTC");
        assert_eq!(utc_day_second(at("1999-12-31T23:59:40.6Z")), "12-31 23:59:41");
        assert_eq!(utc_day_second(at("-0584-05-28T14:00:00Z")), "05-28 14:00:00");
        assert_eq!(utc_minute(at("-0584-05-28T14:00:00Z")), "-0584-05-28 14:00 UTC");
        let far = Instant::from_tdb_seconds_past_j2000(1e15);
        assert_eq!(utc_minute(far), far.plus_seconds(30.0).to_utc_iso());
    }

    #[test]
    fn places_have_sides() {
        let place = |latitude_deg, longitude_deg| place_text(Place { latitude_deg, longitude_deg, height_km: 0.0 });
        assert_eq!(place(25.49, -104.13), "25.5° N, 104.1° W");
        assert_eq!(place(-33.0, 18.0), "33.0° S, 18.0° E");
    }
}
