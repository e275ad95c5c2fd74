//! MPCORB.DAT of the Minor Planet Center: fixed columns, packed dates.
//!
//! In: one line. Out: a [`SmallBody`], or the field that is wrong. Columns are those of the Center's "Export format for minor-planet orbits". Everything down
//! to the first line of dashes is the heading, unless one of the first two lines is a body: then there is no heading, and dashes further down are an error.

use super::SmallBody;
use super::rows::{
    self, ABSOLUTE_MAGNITUDE, ARGUMENT_OF_PERIHELION, ASCENDING_NODE, ECCENTRICITY, EPOCH, INCLINATION, MEAN_ANOMALY, SEMI_MAJOR_AXIS,
    SLOPE, Values,
};
use crate::time::Instant;
use crate::units::JD_J2000;
use crate::wording::echo_within;
use std::ops::Range;

/// The fields that are plain numbers: index in [`rows::FIELDS`] and byte range in the line.
const NUMBERS: [(usize, Range<usize>); 8] = [
    (ABSOLUTE_MAGNITUDE, 8..13),
    (SLOPE, 14..19),
    (MEAN_ANOMALY, 26..35),
    (ARGUMENT_OF_PERIHELION, 37..46),
    (ASCENDING_NODE, 48..57),
    (INCLINATION, 59..68),
    (ECCENTRICITY, 70..79),
    (SEMI_MAJOR_AXIS, 92..103),
];
/// Byte range of the packed designation.
const PACKED_DESIGNATION: Range<usize> = 0..7;
/// Byte range of the packed epoch.
const EPOCH_COLUMNS: Range<usize> = 20..25;
/// Byte range of the number in brackets and the name; a line may end within or before it.
const READABLE_DESIGNATION: Range<usize> = 166..194;

/// Whether one of the first two lines can be read as a body. If only the second can, the first has a mistake, which is then reported.
fn starts_with_body(text: &str) -> bool {
    text.lines().take(2).any(|line| !line.contains(',') && body(line).is_ok())
}

/// Whether a text is in this format: a line of dashes ends its heading (of at most 100 lines), or one of its first two lines can be read as a body.
pub(super) fn is_mpcorb(text: &str) -> bool {
    let is_dashes = |line: &str| line.len() > 100 && line.bytes().all(|b| b == b'-');
    text.lines().take(100).any(is_dashes) || starts_with_body(text)
}

/// The lines that describe bodies, with line numbers starting at 1.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let end_of_heading = || text.lines().position(|l| l.starts_with("----------"));
    let heading = if starts_with_body(text) { 0 } else { end_of_heading().map_or(0, |k| k + 1) };
    text.lines().enumerate().skip(heading).map(|(k, line)| (k + 1, line)).filter(|(_, line)| !line.trim().is_empty())
}

/// Julian date of a packed date: the century as a letter (I: 18, J: 19, K: 20), two digits of the year, and month and day as one digit or letter each (A: 10).
/// K239D is 13 September 2023.
fn packed_jd(text: &str) -> Option<f64> {
    let bytes = text.as_bytes();
    let digit = |b: u8| char::from(b).to_digit(36).filter(|_| !b.is_ascii_lowercase());
    let [century, y1, y2, month, day] = bytes else { return None };
    let century = digit(*century).filter(|c| (18..=20).contains(c))?;
    let year = 100 * century + 10 * digit(*y1).filter(|d| *d < 10)? + digit(*y2).filter(|d| *d < 10)?;
    let (month, day) = (digit(*month)?, digit(*day)?);
    // The packed date means midnight TT, but `Instant::parse` reads UTC: rounding to midnight removes the difference of about a minute.
    let utc = Instant::parse(&format!("{year:04}-{month:02}-{day:02}T00:00:00Z")).ok()?;
    let jd = utc.tdb_seconds_past_j2000() / crate::units::SECONDS_PER_DAY + JD_J2000;
    Some((jd - 0.5).round() + 0.5)
}

/// Reads the body that a line describes.
pub(super) fn body(line: &str) -> Result<SmallBody, String> {
    let cell = |columns: &Range<usize>| line.get(columns.clone());
    let too_short =
        || "too short for MPCORB.DAT, and no first line names columns such as e,a_au,i_deg,node_deg,argp_deg,M_deg,epoch_mjd,H".to_owned();
    let mut values: Values = Values::default();
    for (k, columns) in &NUMBERS {
        values[*k] = rows::number(*k, cell(columns).ok_or_else(too_short)?)?;
    }
    let epoch = cell(&EPOCH_COLUMNS).ok_or_else(too_short)?;
    let epoch_jd =
        packed_jd(epoch).ok_or_else(|| format!("epoch is `{}`; expected a packed date such as K239D", echo_within(epoch, 10)))?;
    values[EPOCH] = Some(epoch_jd);
    let packed = cell(&PACKED_DESIGNATION).unwrap_or_default().trim();
    let readable = line.get(READABLE_DESIGNATION.start..READABLE_DESIGNATION.end.min(line.len())).unwrap_or_default().trim();
    let (designation, name) = match readable.strip_prefix('(').and_then(|r| r.split_once(')')) {
        Some((number, name)) => (number.trim(), name.trim()),
        None if readable.is_empty() => (packed, ""),
        None => (readable, ""),
    };
    rows::body(designation, name, &values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_unpacked() {
        // The Minor Planet Center's own examples: J9611 is 1 January 1996, K01AM is 22 October 2001.
        assert_eq!(packed_jd("J9611"), Some(2_450_083.5));
        assert_eq!(packed_jd("K01AM"), Some(2_452_204.5));
        for wrong in ["", "K23", "K2Z11", "K23DD", "k239D", "Z2311"] {
            assert_eq!(packed_jd(wrong), None, "{wrong}");
        }
    }
}
