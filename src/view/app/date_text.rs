//! Parser for typed dates: `8 April 2024`, `april 8 2024`, `2024-04-08 18:17`, `8.4.2024`, `28 May 585 BC`, `2027`, `now`; in German
//! `8. April 2024`, `28. Mai 585 v. Chr.`, `19. August 14 n. Chr.`, `jetzt`.
//!
//! In: text, the displayed time zone, the current time. Out: an instant, or `None` if the text is not a date. Always: a date is read in the displayed zone,
//! unless it names UTC; ISO 8601 text has its ISO 8601 meaning, that is the Gregorian calendar in all years, and so have other dates in digits alone. A date
//! before 15 October 1582 with the name of a month or an era is meant in the Julian calendar, as in history books, unless it says `(Gregorian)`; a later date
//! is in the Julian calendar if it says so. Not supported: other named zones and offsets; dates of ambiguous order, such as 4/8/2024.

use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::julian_calendar::CalendarDate;
use chrono::Datelike;

const MONTHS: [&str; 12] =
    ["january", "february", "march", "april", "may", "june", "july", "august", "september", "october", "november", "december"];

const GERMAN_MONTHS: [&str; 12] =
    ["januar", "februar", "märz", "april", "mai", "juni", "juli", "august", "september", "oktober", "november", "dezember"];

/// Words that say that a time is in UTC, in lower case.
const UTC_WORDS: [&str; 3] = ["utc", "ut", "z"];

/// Words that a date may contain in addition to the name of a month and that of a calendar.
const DATE_WORDS: [&str; 16] = ["utc", "ut", "z", "of", "at", "um", "uhr", "ad", "ce", "n.chr.", "bc", "bce", "v.chr.", "v.", "n.", "chr."];

/// Names of the calendars in lower case, in English and German, in full and abbreviated.
const JULIAN_WORDS: [&str; 3] = ["julian", "julianisch", "o.s."];
const GREGORIAN_WORDS: [&str; 5] = ["gregorian", "gregorianisch", "greg.", "greg", "n.s."];

/// Whether a valid date text means the same instant in every time zone, because it names UTC, is relative to now, or is a Julian date. `utc`, `ut`
/// and `z` count only as whole words, and `z` also after a digit: a month may end in `z`, as in `2024 März`.
fn is_same_in_every_zone(text: &str) -> bool {
    let text = text.trim().to_lowercase();
    let ends_in_digit = |text: &str| text.ends_with(|c: char| c.is_ascii_digit());
    let has_zero_offset =
        |word: &str| ["+00:00", "+0000", "+00"].into_iter().any(|offset| word.strip_suffix(offset).is_some_and(ends_in_digit));
    let names_utc = |word: &str| UTC_WORDS.contains(&word) || word.strip_suffix('z').is_some_and(ends_in_digit) || has_zero_offset(word);
    // Only words such as `today` and `tomorrow` are date texts without a digit.
    let is_relative_to_now = !text.contains(|c: char| c.is_ascii_digit());
    text.split([' ', ',']).any(names_utc) || is_relative_to_now || text.starts_with("jd_tdb:")
}

/// The instant of a date text; `None` if the text is no date. The date is read in `zone`, unless the text gives the same instant in every zone. In local time
/// the instant is rounded to whole seconds.
pub(crate) fn parse_date(text: &str, zone: ShownTimeZone, now: Instant) -> Option<Instant> {
    let utc = parse_utc(text, now)?;
    if zone == ShownTimeZone::Utc || is_same_in_every_zone(text) {
        return Some(utc);
    }
    zone.instant(ShownTimeZone::Utc.civil_time(utc)?)
}

/// The instant of a date text, read as UTC.
fn parse_utc(text: &str, now: Instant) -> Option<Instant> {
    let text = without_brackets(&text.trim().to_lowercase());
    // A comma usually separates parts of a date, so it is read as a decimal comma only if the text is no date otherwise.
    date_with_decimal_point(&text, now).or_else(|| date_with_decimal_point(&with_decimal_point(&text), now))
}

/// As [`parse_utc`], for a text in lower case whose seconds have no decimal comma.
fn date_with_decimal_point(text: &str, now: Instant) -> Option<Instant> {
    match text {
        "now" | "today" | "jetzt" | "heute" => return Some(now),
        "tomorrow" | "morgen" => return Some(now.plus_seconds(SECONDS_PER_DAY)),
        "yesterday" | "gestern" => return Some(now.plus_seconds(-SECONDS_PER_DAY)),
        _ => {}
    }
    if let Ok(time) = Instant::parse(text) {
        return Some(time);
    }
    let parts = Parts::of(text)?;
    let time_of_day = parts.time_of_day.unwrap_or("00:00");
    let written = parts.date()?;
    let date = if parts.is_julian(written) {
        let gregorian = written.gregorian_of_julian()?;
        CalendarDate { year: gregorian.year().into(), month: gregorian.month(), day: gregorian.day() }
    } else {
        written
    };
    let (sign, year) = if date.year < 0 { ("-", -date.year) } else { ("", date.year) };
    Instant::parse(&format!("{sign}{year:04}-{:02}-{:02}T{time_of_day}Z", date.month, date.day)).ok()
}

/// The date that a text states in the Julian calendar; `None` if the text is read in the Gregorian calendar, or is no date.
pub(crate) fn julian_date(text: &str) -> Option<CalendarDate> {
    let text = without_brackets(&text.trim().to_lowercase());
    if Instant::parse(&text).is_ok() {
        return None;
    }
    let with_point = with_decimal_point(&text);
    let parts = Parts::of(&text).or_else(|| Parts::of(&with_point))?;
    let written = parts.date()?;
    (parts.is_julian(written) && written.gregorian_of_julian().is_some()).then_some(written)
}

/// The text without brackets: the name of a calendar is often in brackets.
fn without_brackets(text: &str) -> String {
    text.replace(['(', ')'], " ").trim().to_owned()
}

/// The text with a decimal comma of the seconds replaced by a point, as in `18:17:16,5`. Elsewhere a comma separates parts of a date: `18:17:16,8 april 2024`.
fn with_decimal_point(text: &str) -> String {
    let is_decimal = |before_comma: &str, after_comma: &str| {
        let time_of_day = before_comma.rsplit([' ', ',', 't']).next().unwrap_or(before_comma);
        let rest = after_comma.trim_start_matches(|c: char| c.is_ascii_digit());
        let digit_count = after_comma.len() - rest.len();
        let ends_text = rest.trim().is_empty() || rest.trim() == "uhr" || UTC_WORDS.contains(&rest.trim());
        let has_seconds = time_of_day.matches(':').count() == 2 && time_of_day.ends_with(|c: char| c.is_ascii_digit());
        has_seconds && (1..=3).contains(&digit_count) && ends_text
    };
    match text.rsplit_once(',') {
        Some((before_comma, after_comma)) if is_decimal(before_comma, after_comma) => format!("{before_comma}.{after_comma}"),
        _ => text.to_owned(),
    }
}

/// Whether a text is meant as a date, valid or not: it contains a month's name and a number, or a date in digits such as `32.13.2024`, and every other word
/// is part of a date.
pub(crate) fn resembles_date(text: &str) -> bool {
    let text = without_brackets(&text.trim().to_lowercase());
    let words = || text.split([' ', ',']).filter(|w| !w.is_empty());
    let starts_with_digit = |word: &str| word.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    let is_in_digits = |word: &str| {
        let fields: Vec<&str> = word.split(['.', '/', '-']).collect();
        fields.len() == 3 && fields.iter().all(|f| !f.is_empty() && f.chars().all(|c| c.is_ascii_digit()))
    };
    // `t` separates date and time of day in ISO 8601.
    let is_date = |word: &str| is_in_digits(word.split('t').next().unwrap_or(word));
    words().all(|word| starts_with_digit(word) || month_number(word).is_some() || is_date_word(word))
        && (words().any(is_date) || words().any(|word| month_number(word).is_some()) && words().any(starts_with_digit))
}

/// Whether a word may be part of a date besides numbers and months.
fn is_date_word(word: &str) -> bool {
    DATE_WORDS.contains(&word) || JULIAN_WORDS.contains(&word) || GREGORIAN_WORDS.contains(&word)
}

/// The parts of a date that have been read so far.
#[derive(Default)]
struct Parts<'t> {
    /// Astronomical year: 1 BC is 0.
    year: Option<i64>,
    month: Option<u32>,
    day: Option<u32>,
    time_of_day: Option<&'t str>,
    /// Whether the month is written as a name, or the text has an era and a year alone.
    is_in_words: bool,
    /// Whether the text names the Julian calendar; `None` if it names none.
    names_julian: Option<bool>,
}

/// Sets a part of a date; `None` if it was set before.
fn set_once<T>(part: &mut Option<T>, value: T) -> Option<()> {
    part.is_none().then(|| *part = Some(value))
}

impl<'t> Parts<'t> {
    /// The parts of a text in lower case. `None` if a word is not part of a date, or a part occurs twice. Also `None` if an era such as `bc` has no year or
    /// a year that is not positive, if a word such as `at` stands in a text without a time of day, or if a day has no month.
    fn of(text: &'t str) -> Option<Self> {
        let mut parts = Self::default();
        // The era; `None`: none in the text so far.
        let mut is_before_christ = None;
        let mut expects_time_of_day = false;
        let mut words = text.split([' ', ',']).filter(|w| !w.is_empty());
        while let Some(word) = words.next() {
            match word {
                _ if UTC_WORDS.contains(&word) => {}
                "of" => {}
                "at" | "um" | "uhr" => expects_time_of_day = true,
                _ if JULIAN_WORDS.contains(&word) => set_once(&mut parts.names_julian, true)?,
                _ if GREGORIAN_WORDS.contains(&word) => set_once(&mut parts.names_julian, false)?,
                "ad" | "ce" | "n.chr." => set_once(&mut is_before_christ, false)?,
                "bc" | "bce" | "v.chr." => set_once(&mut is_before_christ, true)?,
                "v." | "n." => {
                    words.next().filter(|next| *next == "chr.")?;
                    set_once(&mut is_before_christ, word == "v.")?;
                }
                _ if word.contains(':') => set_once(&mut parts.time_of_day, word.strip_suffix('z').unwrap_or(word))?,
                _ if word.starts_with(|c: char| c.is_alphabetic()) => {
                    set_once(&mut parts.month, month_number(word)?)?;
                    parts.is_in_words = true;
                }
                _ if word.trim_end_matches('.').contains(['.', '/']) => parts.numeric_date(word)?,
                _ => parts.day_or_year(word)?,
            }
        }
        if is_before_christ.is_some() && parts.year.is_none() && parts.month.is_none() {
            // With an era, a number without a month is a year, although a number up to 31 was read as a day.
            parts.year = parts.day.take().map(i64::from);
        }
        parts.is_in_words |= is_before_christ.is_some() && parts.month.is_none();
        if let Some(is_before_christ) = is_before_christ {
            let year = parts.year.filter(|y| *y > 0)?;
            parts.year = Some(if is_before_christ { 1 - year } else { year });
        }
        if expects_time_of_day && parts.time_of_day.is_none() {
            return None;
        }
        // This also rejects a lone number of one or two digits, which was read as a day.
        (parts.day.is_none() || parts.month.is_some()).then_some(parts)
    }

    /// The date as it is written; `None` without a year.
    fn date(&self) -> Option<CalendarDate> {
        Some(CalendarDate { year: self.year?, month: self.month.unwrap_or(1), day: self.day.unwrap_or(1) })
    }

    /// Whether the date is meant in the Julian calendar. Dates in digits alone are not: the date field shows such dates, in the Gregorian calendar.
    fn is_julian(&self, written: CalendarDate) -> bool {
        self.names_julian.unwrap_or(self.is_in_words && written.is_before_reform())
    }

    /// Reads a day (`8`, `8th`, `8.`) or a year of up to four digits (`2024`, `-584`). One or two digits without a sign are a day, unless the day is already
    /// set or the number is not 1 to 31.
    fn day_or_year(&mut self, word: &str) -> Option<()> {
        let unsigned = word.strip_prefix('-').unwrap_or(word);
        let digits_end = unsigned.find(|c: char| !c.is_ascii_digit()).unwrap_or(unsigned.len());
        let (digits, ending) = unsigned.split_at(digits_end);
        let value: i64 = digits.parse().ok().filter(|_| digits.len() <= 4)?;
        let is_ordinal = ["st", "nd", "rd", "th", "."].contains(&ending);
        if !ending.is_empty() && !is_ordinal {
            return None;
        }
        if word.starts_with('-') {
            return if is_ordinal { None } else { set_once(&mut self.year, -value) };
        }
        if digits.len() <= 2 && self.day.is_none() && (1..=31).contains(&value) {
            return set_once(&mut self.day, value as u32);
        }
        if is_ordinal { None } else { set_once(&mut self.year, value) }
    }

    /// Reads `8.4.2024` as day, month, year, and `2024/4/8` as year, month, day. Both separators must be the same.
    fn numeric_date(&mut self, word: &str) -> Option<()> {
        if word.contains('.') && word.contains('/') {
            return None;
        }
        let number = |field: &str| field.parse::<i64>().ok().filter(|_| field.len() <= 4 && !field.starts_with('+'));
        let fields: Vec<i64> = word.split(['.', '/']).map(number).collect::<Option<_>>()?;
        let [first, middle, last] = fields[..] else { return None };
        // A number above 31 is no day, so it is the year.
        let (year, day) = if first > 31 {
            (first, last)
        } else if word.contains('.') {
            (last, first)
        } else {
            return None;
        };
        set_once(&mut self.year, year)?;
        set_once(&mut self.month, u32::try_from(middle).ok()?)?;
        set_once(&mut self.day, u32::try_from(day).ok()?)
    }
}

/// The number of a month from its name, or from at least the first three letters of its name.
fn month_number(word: &str) -> Option<u32> {
    let word = word.trim_end_matches('.');
    let is_match = |name: &&str| word.chars().count() >= 3 && name.starts_with(word);
    let index = MONTHS.iter().position(is_match).or_else(|| GERMAN_MONTHS.iter().position(is_match))?;
    Some(index as u32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn now() -> Instant {
        Instant::parse("2026-11-22T23:00:00Z").expect("a time")
    }

    #[test]
    fn only_calendar_dates_without_utc_depend_on_the_zone() {
        for text in [
            "8 April 2024 18:17 UTC",
            "8 April 2024 18:17 Z",
            "8 April 2024 18:17 UT",
            "18:17 UTC 8 April 2024",
            "18:17Z, 8 April 2024",
            "2024-04-08T18:17:00Z",
            "now",
            "morgen",
            "jd_tdb:2460409.26",
            "2024-04-08T18:17:16+00:00",
        ] {
            assert!(parse_utc(text, now()).is_some() && is_same_in_every_zone(text), "{text}");
        }
        for text in ["8 Dec 2024", "2024 Dec", "15 March 44 BC", "1 2024 März", "8 April 2024 18:17", "2024-04-08 18:17:00", "2027"] {
            assert!(parse_utc(text, now()).is_some() && !is_same_in_every_zone(text), "{text}");
        }
    }

    #[test]
    fn a_date_is_in_the_displayed_time_zone_unless_it_names_utc_or_now() {
        for zone in [ShownTimeZone::Utc, ShownTimeZone::Local] {
            let typed = |text: &str| parse_date(text, zone, now()).expect(text);
            for text in ["8 April 2024 18:17 UTC", "2024-04-08T18:17:00Z"] {
                assert_eq!(typed(text).to_utc_iso(), "2024-04-08T18:17:00Z", "{text}");
            }
            assert_eq!(typed("now"), now());
        }
        // In UTC a fraction of a second stays.
        let fraction = Instant::parse("2024-04-08T18:17:16.25Z").expect("a time");
        assert_eq!(parse_date("2024-04-08 18:17:16.25", ShownTimeZone::Utc, now()), Some(fraction));
        assert_eq!(parse_date("next Tuesday", ShownTimeZone::Local, now()), None);
    }

    /// Nine spellings of each day of five years give the instant of the ISO 8601 date, or no date for days such as 30 February.
    #[test]
    fn all_spellings_of_a_day_give_the_same_instant() {
        let ordinal_ending = |d: u32| match d {
            1 | 21 | 31 => "st",
            2 | 22 => "nd",
            3 | 23 => "rd",
            _ => "th",
        };
        for year in [1583, 1900, 2000, 2024, 9999] {
            for (m, name) in MONTHS.iter().enumerate() {
                let short = &name[..3];
                for d in 1..=31 {
                    let m = m + 1;
                    let iso = Instant::parse(&format!("{year:04}-{m:02}-{d:02}")).ok();
                    for text in [
                        format!("{d} {name} {year}"),
                        format!("{name} {d} {year}"),
                        format!("{short} {d}, {year}"),
                        format!("{d}{} {short}. {year}", ordinal_ending(d)),
                        format!("{year} {name} {d}"),
                        format!("  {d} {} {year} ", name.to_uppercase()),
                        format!("{d}.{m}.{year}"),
                        format!("{year}/{m}/{d}"),
                        format!("{year:04}-{m:02}-{d:02}"),
                    ] {
                        assert_eq!(parse_utc(&text, now()), iso, "{text}");
                    }
                }
            }
        }
    }

    #[test]
    fn times_of_day_years_and_words_are_read() {
        for (text, iso) in [
            ("8 April 2024 18:17", "2024-04-08T18:17:00Z"),
            ("April 8 2024, 18:17:16 UTC", "2024-04-08T18:17:16Z"),
            ("18:17 8 april 2024", "2024-04-08T18:17:00Z"),
            ("2024-04-08 18:17:16", "2024-04-08T18:17:16Z"),
            ("2024-04-08T18:17:16Z", "2024-04-08T18:17:16Z"),
            ("2027", "2027-01-01T00:00:00Z"),
            ("august 2027", "2027-08-01T00:00:00Z"),
            ("28 May 585 BC", "-0584-05-22T00:00:00Z"),
            ("1 jan 1 bc", "-0001-12-30T00:00:00Z"),
            ("7 BC", "-0007-12-30T00:00:00Z"),
            ("44 BC", "-0044-12-30T00:00:00Z"),
            ("14 n. Chr.", "0013-12-30T00:00:00Z"),
            ("AD 14 18:17", "0013-12-30T18:17:00Z"),
            ("-0584-05-28", "-0584-05-28T00:00:00Z"),
            ("now", "2026-11-22T23:00:00Z"),
            ("tomorrow", "2026-11-23T23:00:00Z"),
            ("8. April 2024", "2024-04-08T00:00:00Z"),
            ("8. Dezember 2024 um 18:17 Uhr", "2024-12-08T18:17:00Z"),
            ("1. März 2024", "2024-03-01T00:00:00Z"),
            ("8. Mai 2024, 18:17 UTC", "2024-05-08T18:17:00Z"),
            ("8.4.2024 18:17", "2024-04-08T18:17:00Z"),
            ("08.04.2024, 18:17:16,5", "2024-04-08T18:17:16.5Z"),
            ("8. April 2024, 18:17:16,25 UTC", "2024-04-08T18:17:16.25Z"),
            ("2024-04-08T18:17:16,125Z", "2024-04-08T18:17:16.125Z"),
            ("18:17:16,8 april 2024", "2024-04-08T18:17:16Z"),
            ("april 2024 18:17:16,8", "2024-04-08T18:17:16Z"),
            ("28. Mai 585 v. Chr.", "-0584-05-22T00:00:00Z"),
            ("28. Mai 585 v.Chr.", "-0584-05-22T00:00:00Z"),
            ("19. August 14 n. Chr.", "0014-08-17T00:00:00Z"),
            ("19. August 14 n.Chr.", "0014-08-17T00:00:00Z"),
            ("19 August 14 AD", "0014-08-17T00:00:00Z"),
            ("mär 2024", "2024-03-01T00:00:00Z"),
            ("28 May -584", "-0584-05-22T00:00:00Z"),
            ("8 April 2024 at 18:17z", "2024-04-08T18:17:00Z"),
            ("jetzt", "2026-11-22T23:00:00Z"),
        ] {
            let (found, expected) = (parse_utc(text, now()).expect(text), Instant::parse(iso).expect(iso));
            let difference_s = found.tdb_seconds_past_j2000() - expected.tdb_seconds_past_j2000();
            // A UTC day is not a whole number of TDB seconds.
            assert!(difference_s.abs() < 1e-3, "{text}: {difference_s} s");
        }
    }

    /// Impossible dates resemble dates; names and places do not.
    #[test]
    fn impossible_dates_resemble_dates() {
        for text in [
            "32 February 2024",
            "29 Feb 2023",
            "32.13.2024",
            "2024-13-01",
            "2024-02-30T10:00:00Z",
            "2027-08-02T10:07:00+02:00",
            "8 april 2024 25:00",
            "31. Juni 44 v. Chr.",
            "4/8/2024",
            "8 april 2024 2025",
        ] {
            assert!(parse_utc(text, now()).is_none() && resembles_date(text), "{text}");
        }
        for text in [
            "",
            " ",
            "mars",
            "maria",
            "io",
            "may",
            "hip 32349",
            "eclipse 2027",
            "98.3, 500",
            "1.2.3a",
            "12345",
            "900 km",
            "-ring-shadow",
            "sep. x 4",
            "-",
            ".",
        ] {
            assert!(!resembles_date(text), "{text}");
        }
    }

    #[test]
    fn other_texts_are_not_dates() {
        for text in [
            "",
            " ",
            "mars",
            "satu",
            "8",
            "8 april",
            "april",
            "31 february 2024",
            "30 feb 2024",
            "4/8/2024",
            "8 april 2024 2025",
            "8 april may 2024",
            "8 april 2024 25:00",
            "32 april 2024",
            "io",
            "12345",
            "eclipse 2027",
            "hip 32349",
            "8..2024",
            "1.2",
            "ma 2024",
            "0 bc",
            "99999999999999999999",
            "-",
            ":",
            "8th",
            "mä 2024",
            "8 april 2024 18:17zz",
            "28 mai 585 v.",
            "28 mai 585 chr.",
            "28 mai 585 n.",
            "28 mai 585 v. 18:17",
            "28 mai 585 bc ad",
            "0 ad",
            "8 april 2024 uhr",
            "8 april 2024 at",
            "8 april --584",
            "8 april --5",
            "8 april -5th",
            "8 april bc",
            "8 bc 9 bc",
            "april +5 2024",
            "+8.+4.2024",
            "4/8.2024",
            "8.4/2024",
            "2024/4.8",
        ] {
            assert_eq!(parse_utc(text, now()), None, "{text}");
        }
    }
}
