//! Civil dates and times of an instant, in UTC or in the computer's time zone.
//!
//! In: an instant and a zone, or a civil time and a zone. Out: the civil time, or the instant. Always: instants are rounded to whole seconds;
//! a civil time that the zone skips is moved forward by an hour; of a civil time that occurs twice, the first occurrence is meant; a leap second is
//! shown as the second before it.
//! Not here: parsing of typed dates (`date_text`).

use crate::time::Instant;
use chrono::{Duration, Local, LocalResult, NaiveDateTime, Offset, TimeZone, Utc};
use serde::{Deserialize, Serialize};

/// The time zone of displayed times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShownTimeZone {
    #[default]
    Utc,
    /// The computer's time zone.
    Local,
}

impl ShownTimeZone {
    /// The civil time of an instant; `None` outside the calendar's range of years.
    pub(crate) fn civil_time(self, t: Instant) -> Option<NaiveDateTime> {
        match self {
            Self::Utc => civil_time(t, &Utc),
            Self::Local => civil_time(t, &Local),
        }
    }

    /// The instant of a civil time; `None` outside the calendar's range of years.
    pub(crate) fn instant(self, civil: NaiveDateTime) -> Option<Instant> {
        match self {
            Self::Utc => instant(civil, &Utc),
            Self::Local => instant(civil, &Local),
        }
    }

    /// The zone's label for an instant: `UTC`, or the offset of the computer's zone at that instant, such as `UTC+05:30`.
    pub(crate) fn label(self, t: Instant) -> String {
        match (self, Self::Utc.civil_time(t)) {
            (Self::Local, Some(utc)) => offset_text(Local.offset_from_utc_datetime(&utc).fix().local_minus_utc()),
            _ => "UTC".into(),
        }
    }
}

/// The label of a zone by its offset from UTC in seconds, such as `UTC+05:30`.
fn offset_text(offset_s: i32) -> String {
    let minutes = offset_s.abs() / 60;
    format!("UTC{}{:02}:{:02}", if offset_s < 0 { '-' } else { '+' }, minutes / 60, minutes % 60)
}

fn civil_time<Z: TimeZone>(t: Instant, zone: &Z) -> Option<NaiveDateTime> {
    // The fraction of a second is cut off below. Half a second is added before, so that the result is rounded to whole seconds.
    let iso = t.plus_seconds(0.5).to_utc_iso();
    let (whole_seconds, _) = iso.trim_end_matches('Z').split_once('.').unwrap_or((iso.trim_end_matches('Z'), ""));
    // A leap second (`:60`) is shown as `:59`.
    let whole_seconds = whole_seconds.strip_suffix(":60").map_or(whole_seconds.to_owned(), |minute| format!("{minute}:59"));
    let utc = NaiveDateTime::parse_from_str(&whole_seconds, "%Y-%m-%dT%H:%M:%S").ok()?;
    utc.checked_add_signed(Duration::seconds(zone.offset_from_utc_datetime(&utc).fix().local_minus_utc().into()))
}

fn instant<Z: TimeZone>(civil: NaiveDateTime, zone: &Z) -> Option<Instant> {
    let utc = match zone.from_local_datetime(&civil) {
        LocalResult::Single(t) | LocalResult::Ambiguous(t, _) => t.naive_utc(),
        LocalResult::None => zone.from_local_datetime(&civil.checked_add_signed(Duration::hours(1))?).earliest()?.naive_utc(),
    };
    Instant::parse(&utc.format("%Y-%m-%dT%H:%M:%SZ").to_string()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chrono::FixedOffset;

    #[test]
    fn civil_times_of_fixed_offsets_round_trip() {
        for hours in [-12.0, -3.5, 0.0, 5.5, 5.75, 14.0] {
            let zone = FixedOffset::east_opt((hours * 3600.0) as i32).expect("a zone");
            for text in
                ["2024-04-08T18:17:16Z", "1999-12-31T23:59:59Z", "-0584-05-28T14:00:00Z", "0000-03-01T00:00:00Z", "1066-10-14T09:00:00Z"]
            {
                let t = Instant::parse(text).expect(text);
                let civil = civil_time(t, &zone).expect(text);
                assert_eq!(instant(civil, &zone).map(Instant::to_utc_iso), Some(text.to_owned()), "{text} {hours}");
                let utc = civil_time(t, &Utc).expect(text);
                assert_eq!((civil - utc).num_minutes() as f64, hours * 60.0, "{text}");
            }
        }
        assert_eq!((offset_text(19_800).as_str(), offset_text(-12_600).as_str()), ("UTC+05:30", "UTC-03:30"));
        assert!(civil_time(Instant::from_tdb_seconds_past_j2000(1e15), &Utc).is_none());
        // In this zone UTC is an hour later than the civil time, and the calendar ends at that civil time.
        assert!(instant(NaiveDateTime::MAX, &FixedOffset::west_opt(3600).expect("a zone")).is_none());
    }
}
