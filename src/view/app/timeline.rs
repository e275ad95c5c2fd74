//! The axis of a timeline: the mapping between time and position, and the dates along it.
//!
//! In: the time at the middle of the axis, its span, its width. Out: positions of times, times of positions, calendar ticks. Always: the mapping
//! is linear in TDB; ticks are at whole hours, days, months or years of the displayed time zone, far enough apart for their labels. Not here:
//! events (`known_events`), painting.

use super::civil_time::ShownTimeZone;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use crate::view::language::dates::{day_and_month, short_month_name};
use crate::view::language::{decimal, text};
use chrono::{Datelike, Days, Months, NaiveDate, NaiveDateTime, TimeDelta, Timelike};
use std::ops::RangeInclusive;

const HOUR_S: f64 = 3600.0;
const YEAR_S: f64 = DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
/// Range of the span of time that a timeline shows: a quarter of a day to four centuries.
pub(crate) const SPAN_RANGE_S: RangeInclusive<f64> = 6.0 * HOUR_S..=400.0 * YEAR_S;
/// For each unit of [`span_text`] the span with the longest text, seconds.
pub(crate) const SPANS_WITH_LONGEST_TEXTS_S: [f64; 4] = [60.0 * HOUR_S, 80.0 * SECONDS_PER_DAY, 20.0 / 12.0 * YEAR_S, 400.0 * YEAR_S];
/// Span of a timeline until the user changes it.
pub(crate) const DEFAULT_SPAN_S: f64 = 2.0 * YEAR_S;
/// Minimum distance between ticks, points, so that their labels do not touch.
const MIN_TICK_DISTANCE_POINTS: f64 = 72.0;
/// Maximum number of ticks: more than fit into a window 4000 points wide.
const MAX_TICKS: usize = 100;
/// Zoom factor of a wheel notch.
const ZOOM_PER_NOTCH: f64 = 1.3;

/// The times that a timeline shows, and its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeAxis {
    /// Time at the middle of the axis, TDB seconds past J2000.
    pub middle_tdb_s: f64,
    /// Time between the ends of the axis, seconds.
    pub span_s: f64,
    /// Width of the axis, points.
    pub width_points: f64,
}

/// A labelled date on the axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    /// TDB seconds past J2000.
    pub tdb_s: f64,
    pub label: String,
}

/// A calendar interval between ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TickInterval {
    Hours(u32),
    Days(u32),
    Months(u32),
    Years(i32),
}

/// The intervals to choose from, ascending: an axis uses the first that leaves room for the labels.
const TICK_INTERVALS: [TickInterval; 18] = [
    TickInterval::Hours(1),
    TickInterval::Hours(3),
    TickInterval::Hours(6),
    TickInterval::Hours(12),
    TickInterval::Days(1),
    TickInterval::Days(5),
    TickInterval::Days(10),
    TickInterval::Months(1),
    TickInterval::Months(3),
    TickInterval::Months(6),
    TickInterval::Years(1),
    TickInterval::Years(2),
    TickInterval::Years(5),
    TickInterval::Years(10),
    TickInterval::Years(20),
    TickInterval::Years(50),
    TickInterval::Years(100),
    TickInterval::Years(200),
];

/// A stored span clamped to [`SPAN_RANGE_S`]; the default span if the stored value is not finite.
pub(crate) fn usable_span_s(saved: f64) -> f64 {
    if saved.is_finite() { saved.clamp(*SPAN_RANGE_S.start(), *SPAN_RANGE_S.end()) } else { DEFAULT_SPAN_S }
}

/// The span after zooming by wheel notches; positive notches shorten it.
pub(crate) fn zoomed_span_s(span_s: f64, notches: f64) -> f64 {
    usable_span_s(span_s * ZOOM_PER_NOTCH.powf(-notches))
}

/// A span as text: `36 hours`, `20 days`, `8 months`, `120 years`.
pub(crate) fn span_text(span_s: f64) -> String {
    let days = span_s / SECONDS_PER_DAY;
    match days {
        d if d < 3.0 => text!("span-hours", count = decimal(d * 24.0, 0)),
        d if d < 90.0 => text!("span-days", d = decimal(d, 0)),
        d if d < 730.0 => text!("span-months", count = decimal(d / (DAYS_PER_JULIAN_YEAR / 12.0), 0)),
        d => text!("span-years", count = decimal(d / DAYS_PER_JULIAN_YEAR, 0)),
    }
}

impl TimeAxis {
    pub(crate) fn start_tdb_s(&self) -> f64 {
        self.middle_tdb_s - 0.5 * self.span_s
    }

    pub(crate) fn end_tdb_s(&self) -> f64 {
        self.middle_tdb_s + 0.5 * self.span_s
    }

    /// The position of a time, points from the left end; outside the axis it is negative or larger than the width.
    pub(crate) fn position_points(&self, tdb_s: f64) -> f64 {
        (tdb_s - self.start_tdb_s()) / self.span_s * self.width_points
    }

    /// The time at a distance from the left end in points, TDB seconds past J2000.
    pub(crate) fn tdb_s_at(&self, points: f64) -> f64 {
        self.start_tdb_s() + points / self.width_points * self.span_s
    }

    /// The duration that a distance in points stands for, seconds.
    pub(crate) fn duration_s(&self, points: f64) -> f64 {
        points / self.width_points * self.span_s
    }

    /// Ticks along the axis, at whole dates and hours of `zone`; empty if the axis starts outside the calendar.
    pub(crate) fn ticks(&self, zone: ShownTimeZone) -> Vec<Tick> {
        let is_wide_enough = |interval: &&TickInterval| interval.seconds() / self.span_s * self.width_points >= MIN_TICK_DISTANCE_POINTS;
        let interval = TICK_INTERVALS.iter().find(is_wide_enough).copied().unwrap_or(TickInterval::Years(200));
        let start = Instant::from_tdb_seconds_past_j2000(self.start_tdb_s());
        let Some(first) = zone.civil_time(start).and_then(|civil| interval.floor(civil)) else { return Vec::new() };
        std::iter::successors(Some(first), |civil| interval.next_tick(*civil))
            .take(MAX_TICKS)
            .filter_map(|civil| Some(Tick { tdb_s: zone.instant(civil)?.tdb_seconds_past_j2000(), label: interval.label(civil) }))
            .skip_while(|tick| tick.tdb_s < self.start_tdb_s())
            .take_while(|tick| tick.tdb_s <= self.end_tdb_s())
            .collect()
    }
}

impl TickInterval {
    /// Mean length, seconds.
    fn seconds(self) -> f64 {
        match self {
            Self::Hours(n) => f64::from(n) * HOUR_S,
            Self::Days(n) => f64::from(n) * SECONDS_PER_DAY,
            Self::Months(n) => f64::from(n) * YEAR_S / 12.0,
            Self::Years(n) => f64::from(n) * YEAR_S,
        }
    }

    /// The last tick at or before a civil time; `None` outside the calendar.
    fn floor(self, civil: NaiveDateTime) -> Option<NaiveDateTime> {
        let date = civil.date();
        match self {
            Self::Hours(n) => date.and_hms_opt(civil.hour() / n * n, 0, 0),
            Self::Days(1) => Some(midnight(date)),
            // There is no tick on the 31st, since it would be next to the tick on the 1st.
            Self::Days(n) => date.with_day(1 + date.day0().min(29) / n * n).map(midnight),
            Self::Months(n) => date.with_day(1)?.with_month(1 + date.month0() / n * n).map(midnight),
            Self::Years(n) => NaiveDate::from_ymd_opt(date.year().div_euclid(n) * n, 1, 1).map(midnight),
        }
    }

    /// The tick after a tick; `None` outside the calendar.
    fn next_tick(self, civil: NaiveDateTime) -> Option<NaiveDateTime> {
        let date = civil.date();
        match self {
            Self::Hours(n) => civil.checked_add_signed(TimeDelta::hours(n.into())),
            Self::Days(1) => civil.checked_add_days(Days::new(1)),
            // As in `floor`, there is no tick on the 31st.
            Self::Days(n) if date.day() + n > 30 => date.with_day(1)?.checked_add_months(Months::new(1)).map(midnight),
            Self::Days(n) => civil.checked_add_days(Days::new(n.into())),
            Self::Months(n) => civil.checked_add_months(Months::new(n)),
            Self::Years(n) => NaiveDate::from_ymd_opt(date.year().checked_add(n)?, 1, 1).map(midnight),
        }
    }

    /// The label of a tick: time of day, day, month or year, according to the interval. A tick of whole hours that is at midnight has the day; a tick at
    /// the beginning of a year has the year.
    fn label(self, civil: NaiveDateTime) -> String {
        let year = match civil.year() {
            year if year > 0 => year.to_string(),
            year => text!("date-year-bc", year = 1 - year),
        };
        match self {
            Self::Hours(_) if civil.hour() > 0 => civil.format("%H:%M").to_string(),
            Self::Hours(_) | Self::Days(_) if civil.ordinal0() > 0 => day_and_month(civil.date()),
            Self::Months(_) if civil.month0() > 0 => short_month_name(civil.date()).to_owned(),
            _ => year,
        }
    }
}

fn midnight(date: NaiveDate) -> NaiveDateTime {
    date.and_time(chrono::NaiveTime::MIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(middle: &str, span_s: f64, width_points: f64) -> TimeAxis {
        TimeAxis { middle_tdb_s: Instant::parse(middle).expect("a time").tdb_seconds_past_j2000(), span_s, width_points }
    }

    #[test]
    fn position_and_time_are_inverse() {
        let axis = axis("2024-04-08T18:17:00Z", 30.0 * SECONDS_PER_DAY, 900.0);
        assert!((axis.position_points(axis.middle_tdb_s) - 450.0).abs() < 1e-9);
        for points in [0.0, 17.0, 450.0, 900.0] {
            assert!((axis.position_points(axis.tdb_s_at(points)) - points).abs() < 1e-6);
        }
        assert!((axis.duration_s(30.0) - SECONDS_PER_DAY).abs() < 1e-6);
    }

    /// For spans from a day to four centuries, ticks are in order, inside the axis, neither too close nor too far apart, and at whole hours of UTC.
    #[test]
    fn ticks_are_at_whole_dates_and_far_enough_apart() {
        for middle in ["2024-02-29T18:17:00Z", "1582-10-10T00:00:00Z", "-0043-03-15T12:00:00Z", "2100-12-31T23:59:00Z"] {
            let mut span_s = SECONDS_PER_DAY;
            while span_s < *SPAN_RANGE_S.end() {
                for width in [300.0, 900.0, 2500.0] {
                    let axis = axis(middle, span_s, width);
                    let ticks = axis.ticks(ShownTimeZone::Utc);
                    let positions: Vec<f64> = ticks.iter().map(|t| axis.position_points(t.tdb_s)).collect();
                    let case = format!("{middle}, {}, {width}: {ticks:?}", span_text(span_s));
                    assert!(positions.iter().all(|p| (0.0..=width).contains(p)), "{case}");
                    // Ticks every five days can be three days apart, from 26 February to 1 March.
                    assert!(positions.windows(2).all(|p| p[1] - p[0] > 0.55 * MIN_TICK_DISTANCE_POINTS), "{case}");
                    // An interval of `TICK_INTERVALS` is at most five times the one before it, for which there is no room.
                    assert!(positions.windows(2).all(|p| p[1] - p[0] < 5.0 * MIN_TICK_DISTANCE_POINTS), "{case}");
                    let max_intervals = width / MIN_TICK_DISTANCE_POINTS;
                    // The factor 1.2: single intervals are shorter than the mean interval.
                    assert!(
                        ticks.len() as f64 <= max_intervals * 1.2 + 1.0 && ticks.len() as f64 >= (max_intervals / 5.0).floor(),
                        "{case}"
                    );
                    for tick in &ticks {
                        // A millisecond is added, so that rounding does not give the second before.
                        let iso = Instant::from_tdb_seconds_past_j2000(tick.tdb_s + 1e-3).to_utc_iso();
                        assert!(iso.contains(":00:00"), "{iso}: {case}");
                    }
                }
                span_s *= 1.37;
            }
        }
    }

    #[test]
    fn labels_suit_the_tick_interval() {
        let labels =
            |middle, span_s| axis(middle, span_s, 400.0).ticks(ShownTimeZone::Utc).into_iter().map(|t| t.label).collect::<Vec<_>>();
        assert_eq!(labels("2024-04-08T12:30:00Z", 1.2 * SECONDS_PER_DAY), ["8 Apr", "06:00", "12:00", "18:00", "9 Apr"]);
        assert_eq!(labels("2024-03-05T00:00:00Z", 20.0 * SECONDS_PER_DAY), ["26 Feb", "1 Mar", "6 Mar", "11 Mar"]);
        assert_eq!(labels("2024-01-05T00:00:00Z", 150.0 * SECONDS_PER_DAY), ["Nov", "Dec", "2024", "Feb", "Mar"]);
        assert_eq!(labels("0001-06-01T00:00:00Z", 40.0 * YEAR_S), ["11 BC", "1 BC", "10", "20"]);
    }

    #[test]
    fn spans_stay_within_the_limits() {
        assert_eq!(zoomed_span_s(*SPAN_RANGE_S.start(), 99.0), *SPAN_RANGE_S.start());
        assert_eq!(zoomed_span_s(*SPAN_RANGE_S.end(), -99.0), *SPAN_RANGE_S.end());
        assert!((zoomed_span_s(zoomed_span_s(YEAR_S, 3.0), -3.0) / YEAR_S - 1.0).abs() < 1e-12);
        assert!(SPAN_RANGE_S.contains(&usable_span_s(f64::NAN)) && SPAN_RANGE_S.contains(&usable_span_s(-1.0)));
        for (days, text) in [(0.25, "6 hours"), (20.0, "20 days"), (365.25, "12 months"), (36_525.0, "100 years")] {
            assert_eq!(span_text(days * SECONDS_PER_DAY), text);
        }
    }
}
