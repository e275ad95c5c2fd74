//! Civil dates and times of an instant, in UTC or in the computer's time zone.
//!
//! In: an instant and a zone, or a civil time and a zone. Out: the civil time and the civil day, or the instant. Always: instants are rounded to whole
//! seconds; a civil time that the zone skips is moved forward by an hour; of a civil time that occurs twice, the first occurrence is meant, or the one nearer
//! to a given instant; a leap second is shown as the second before it. Not here: parsing of typed dates (`date_text`).

use crate::time::Instant;
use chrono::{Duration, Local, NaiveDateTime, NaiveTime, Offset, TimeZone, Utc};
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
        self.instants(civil).into_iter().next()
    }

    /// As [`Self::instant`]; for a civil time that occurs twice, the occurrence nearer to `near`.
    pub(crate) fn instant_near(self, civil: NaiveDateTime, near: Instant) -> Option<Instant> {
        nearest(self.instants(civil), near)
    }

    fn instants(self, civil: NaiveDateTime) -> Vec<Instant> {
        match self {
            Self::Utc => instants(civil, &Utc),
            Self::Local => instants(civil, &Local),
        }
    }

    /// Start and end of the civil day of an instant; `None` outside the calendar's range of years.
    pub(crate) fn day(self, t: Instant) -> Option<(Instant, Instant)> {
        let date = self.civil_time(t)?.date();
        Some((self.instant(date.and_time(NaiveTime::MIN))?, self.instant(date.succ_opt()?.and_time(NaiveTime::MIN))?))
    }

    /// The zone's label for an instant: `UTC`, or the offset of the computer's zone at that instant, such as `UTC+05:30`.
    pub(crate) fn label(self, t: Instant) -> String {
        match (self, Self::Utc.civil_time(t)) {
            (Self::Local, Some(utc)) => offset_text(Local.offset_from_utc_datetime(&utc).fix().local_minus_utc()),
            _ => "UTC".into(),
        }
    }
}

/// The label of a zone by its offset from UTC in seconds, such as `UTC+05:30`; local mean time has seconds, as in `UTC+00:53:28`.
fn offset_text(offset_s: i32) -> String {
    let (minutes, seconds) = (offset_s.abs() / 60, offset_s.abs() % 60);
    let seconds_text = if seconds == 0 { String::new() } else { format!(":{seconds:02}") };
    format!("UTC{}{:02}:{:02}{seconds_text}", if offset_s < 0 { '-' } else { '+' }, minutes / 60, minutes % 60)
}

/// The civil time of an instant in a zone, rounded to whole seconds; `None` outside the calendar's range of years.
fn civil_time<Z: TimeZone>(t: Instant, zone: &Z) -> Option<NaiveDateTime> {
    // The fraction of a second is cut off below. Half a second is added before, so that the result is rounded to whole seconds.
    let iso = t.plus_seconds(0.5).to_utc_iso();
    let (whole_seconds, _) = iso.trim_end_matches('Z').split_once('.').unwrap_or((iso.trim_end_matches('Z'), ""));
    // A leap second (`:60`) is shown as `:59`.
    let whole_seconds = whole_seconds.strip_suffix(":60").map_or(whole_seconds.to_owned(), |minute| format!("{minute}:59"));
    let utc = NaiveDateTime::parse_from_str(&whole_seconds, "%Y-%m-%dT%H:%M:%S").ok()?;
    utc.checked_add_signed(Duration::seconds(zone.offset_from_utc_datetime(&utc).fix().local_minus_utc().into()))
}

/// The instants of a civil time in a zone, ordered by time: none outside the calendar's range of years, two of a civil time that occurs twice.
fn instants<Z: TimeZone>(civil: NaiveDateTime, zone: &Z) -> Vec<Instant> {
    let mut found = utc_times(civil, zone);
    if found.is_empty() {
        // The zone skips this civil time.
        found = civil.checked_add_signed(Duration::hours(1)).map_or(Vec::new(), |later| utc_times(later, zone));
    }
    found.into_iter().filter_map(|utc| Instant::parse(&utc.format("%Y-%m-%dT%H:%M:%SZ").to_string()).ok()).collect()
}

/// The instant that is nearest to `near`; `None` if there is none to choose from.
fn nearest(instants: Vec<Instant>, near: Instant) -> Option<Instant> {
    let distance_s = |t: &Instant| (t.tdb_seconds_past_j2000() - near.tdb_seconds_past_j2000()).abs();
    instants.into_iter().min_by(|a, b| distance_s(a).total_cmp(&distance_s(b)))
}

/// The UTC times at which the zone has a civil time, ascending; none if the zone skips it.
fn utc_times<Z: TimeZone>(civil: NaiveDateTime, zone: &Z) -> Vec<NaiveDateTime> {
    let results = zone.from_local_datetime(&civil).map(|t| t.naive_utc());
    // chrono gives two results in the order of their offsets, not of their times, and one too many at the end of the hour that occurs twice.
    let has_civil_time = |utc: &NaiveDateTime| utc.checked_add_offset(zone.offset_from_utc_datetime(utc).fix()) == Some(civil);
    let mut found: Vec<NaiveDateTime> = [results.earliest(), results.latest()].into_iter().flatten().filter(has_civil_time).collect();
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use chrono::{FixedOffset, LocalResult, NaiveDate};

    fn hours_east(hours: f64) -> FixedOffset {
        FixedOffset::east_opt((hours * 3600.0) as i32).expect("an offset")
    }

    /// The computer's zone of central Europe in 2026, as chrono's `Local` answers for it.
    #[derive(Clone)]
    struct CentralEurope;

    impl TimeZone for CentralEurope {
        type Offset = FixedOffset;

        fn from_offset(_: &FixedOffset) -> Self {
            Self
        }

        fn offset_from_local_date(&self, local: &NaiveDate) -> LocalResult<FixedOffset> {
            self.offset_from_local_datetime(&local.and_time(NaiveTime::MIN))
        }

        fn offset_from_local_datetime(&self, local: &NaiveDateTime) -> LocalResult<FixedOffset> {
            let [winter, summer] = [1.0, 2.0].map(hours_east);
            match local.format("%m-%dT%H:%M:%S").to_string().as_str() {
                text if text <= "03-29T02:00:00" => LocalResult::Single(winter),
                text if text < "03-29T03:00:00" => LocalResult::None,
                text if text < "10-25T02:00:00" => LocalResult::Single(summer),
                text if text <= "10-25T03:00:00" => LocalResult::Ambiguous(winter, summer),
                _ => LocalResult::Single(winter),
            }
        }

        fn offset_from_utc_date(&self, utc: &NaiveDate) -> FixedOffset {
            self.offset_from_utc_datetime(&utc.and_time(NaiveTime::MIN))
        }

        fn offset_from_utc_datetime(&self, utc: &NaiveDateTime) -> FixedOffset {
            let text = utc.format("%m-%dT%H:%M:%S").to_string();
            hours_east(if ("03-29T01:00:00".."10-25T01:00:00").contains(&text.as_str()) { 2.0 } else { 1.0 })
        }
    }

    /// The second occurrence was once taken for the first.
    #[test]
    fn civil_times_that_occur_twice_or_never() {
        for (civil, expected) in [
            ("2026-10-25T01:59:59", &["2026-10-24T23:59:59Z"][..]),
            ("2026-10-25T02:00:00", &["2026-10-25T00:00:00Z", "2026-10-25T01:00:00Z"]),
            ("2026-10-25T02:30:00", &["2026-10-25T00:30:00Z", "2026-10-25T01:30:00Z"]),
            ("2026-10-25T03:00:00", &["2026-10-25T02:00:00Z"]),
            ("2026-03-29T02:00:00", &["2026-03-29T01:00:00Z"]),
            ("2026-03-29T02:30:00", &["2026-03-29T01:30:00Z"]),
            ("2026-03-29T03:00:00", &["2026-03-29T01:00:00Z"]),
            ("2026-07-01T12:00:00", &["2026-07-01T10:00:00Z"]),
        ] {
            let time = NaiveDateTime::parse_from_str(civil, "%Y-%m-%dT%H:%M:%S").expect(civil);
            let found: Vec<String> = instants(time, &CentralEurope).into_iter().map(Instant::to_utc_iso).collect();
            assert_eq!(found, expected, "{civil}");
        }
        // Negative control: chrono's first result is the later time.
        let twice = NaiveDate::from_ymd_opt(2026, 10, 25).and_then(|date| date.and_hms_opt(2, 30, 0)).expect("a time");
        let first = CentralEurope.from_local_datetime(&twice).earliest().expect("a time");
        assert_eq!(first.naive_utc().to_string(), "2026-10-25 01:30:00");
        // The time 02:30 is typed while 02:29 is displayed, once of the second of the two hours from 02:00 to 03:00, once of the first: 02:30 of the same hour
        // is meant.
        for (displayed, expected) in [("2026-10-25T01:29:00Z", "2026-10-25T01:30:00Z"), ("2026-10-25T00:29:00Z", "2026-10-25T00:30:00Z")] {
            let found = nearest(instants(twice, &CentralEurope), Instant::parse(displayed).expect(displayed));
            assert_eq!(found.map(Instant::to_utc_iso).as_deref(), Some(expected));
        }
    }

    /// The day of UTC, not of TDB, which begins 69 s earlier in 2026 and five hours earlier in 585 BC.
    #[test]
    fn a_day_lasts_from_midnight_to_midnight() {
        for (text, day) in [
            ("2026-11-29T00:00:00Z", ["2026-11-29T00:00:00Z", "2026-11-30T00:00:00Z"]),
            ("2026-11-29T23:59:30Z", ["2026-11-29T00:00:00Z", "2026-11-30T00:00:00Z"]),
            ("-0584-05-22T19:30:00Z", ["-0584-05-22T00:00:00Z", "-0584-05-23T00:00:00Z"]),
            // The day with the leap second.
            ("2016-12-31T23:59:59Z", ["2016-12-31T00:00:00Z", "2017-01-01T00:00:00Z"]),
        ] {
            let (start, end) = ShownTimeZone::Utc.day(Instant::parse(text).expect(text)).expect(text);
            assert_eq!([start, end].map(Instant::to_utc_iso), day, "{text}");
        }
    }

    #[test]
    fn civil_times_of_fixed_offsets_round_trip() {
        for hours in [-12.0, -3.5, 0.0, 5.5, 5.75, 14.0] {
            let zone = hours_east(hours);
            for text in
                ["2024-04-08T18:17:16Z", "1999-12-31T23:59:59Z", "-0584-05-28T14:00:00Z", "0000-03-01T00:00:00Z", "1066-10-14T09:00:00Z"]
            {
                let t = Instant::parse(text).expect(text);
                let civil = civil_time(t, &zone).expect(text);
                let found: Vec<String> = instants(civil, &zone).into_iter().map(Instant::to_utc_iso).collect();
                assert_eq!(found, [text], "{text} {hours}");
                let utc = civil_time(t, &Utc).expect(text);
                assert_eq!((civil - utc).num_minutes() as f64, hours * 60.0, "{text}");
            }
        }
        assert_eq!((offset_text(19_800).as_str(), offset_text(-12_600).as_str()), ("UTC+05:30", "UTC-03:30"));
        // The local mean times of Berlin and New York, before their standard times.
        assert_eq!((offset_text(3208).as_str(), offset_text(-17_762).as_str()), ("UTC+00:53:28", "UTC-04:56:02"));
        assert!(civil_time(Instant::from_tdb_seconds_past_j2000(1e15), &Utc).is_none());
        // In this zone UTC is an hour later than the civil time, and the calendar ends at that civil time.
        assert!(instants(NaiveDateTime::MAX, &hours_east(-1.0)).is_empty());
    }
}
