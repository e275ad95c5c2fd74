//! The time between the frames of a sequence, or between the rows of a table.
//!
//! In: a start and a number of steps. Out: an instant. Always: the instant follows from the number of steps, so that rounding errors do not add up.

use super::Instant;
use crate::units::SECONDS_PER_DAY;

/// A step in time; it may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// Seconds of elapsed time: a leap second is one of them. Before 1972, where there are none, seconds of UT1.
    Seconds(f64),
    /// Days of the calendar: after a whole number of them it is the same time of day, also across a leap second.
    Days(f64),
}

impl TimeStep {
    /// The instant that is `count` steps after `start`.
    pub fn after(self, start: Instant, count: f64) -> Instant {
        match self {
            Self::Seconds(seconds) => start.plus_elapsed_seconds(count * seconds),
            Self::Days(days) => start.plus_utc_seconds(count * days * SECONDS_PER_DAY),
        }
    }

    /// Whether a step leads to a later time.
    pub fn is_forward(self) -> bool {
        let (Self::Seconds(length) | Self::Days(length)) = self;
        length > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(start: &str, step: TimeStep, counts: std::ops::Range<i32>) -> Vec<String> {
        let start = Instant::parse(start).expect("a time");
        counts.map(|count| step.after(start, f64::from(count)).to_utc_iso()).collect()
    }

    #[test]
    fn a_leap_second_is_a_second_of_its_own() {
        let last_of_2016 = ["2016-12-31T23:59:58Z", "2016-12-31T23:59:59Z", "2016-12-31T23:59:60Z", "2017-01-01T00:00:00Z"];
        assert_eq!(times(last_of_2016[0], TimeStep::Seconds(1.0), 0..4), last_of_2016);
        let last_of_june_1972 = ["1972-06-30T23:59:59Z", "1972-06-30T23:59:60Z", "1972-07-01T00:00:00Z"];
        assert_eq!(times(last_of_june_1972[0], TimeStep::Seconds(1.0), 0..3), last_of_june_1972);
        // From within, backwards, in fractions and in longer steps.
        assert_eq!(times("2016-12-31T23:59:60Z", TimeStep::Seconds(1.0), -1..2), last_of_2016[1..]);
        assert_eq!(times("2017-01-01T00:00:00Z", TimeStep::Seconds(-1.0), 0..3), [last_of_2016[3], last_of_2016[2], last_of_2016[1]]);
        assert_eq!(times("2016-12-31T23:59:60Z", TimeStep::Seconds(0.5), 1..3), ["2016-12-31T23:59:60.500Z", last_of_2016[3]]);
        assert_eq!(times("2016-12-31T23:00:00Z", TimeStep::Seconds(3600.0), 1..2), ["2016-12-31T23:59:60Z"]);
        assert_eq!(times("1972-01-01T00:00:00Z", TimeStep::Seconds(86_400.0), 181..183), ["1972-06-30T00:00:00Z", "1972-06-30T23:59:60Z"]);
    }

    /// Before 1972 times are UT1, whose days differ from 86 400 seconds of TDB.
    #[test]
    fn hours_keep_the_minute_where_there_is_no_leap_second() {
        for (start, hours, end) in [
            ("2016-12-31T06:00:00Z", 17, "2016-12-31T23:00:00Z"),
            ("2017-01-01T00:00:00Z", 70_000, "2024-12-26T16:00:00Z"),
            ("-0584-05-20T12:00:00Z", 22_000_000, "1926-02-18T04:00:00Z"),
        ] {
            assert_eq!(times(start, TimeStep::Seconds(3600.0), hours..hours + 1), [end]);
        }
    }

    /// There is a leap second at the end of 2016.
    #[test]
    fn days_keep_the_time_of_day() {
        for (start, end) in [("2016-12-30T06:00:00Z", "2017-01-02T06:00:00Z"), ("-0584-05-20T12:00:00Z", "-0584-05-23T12:00:00Z")] {
            assert_eq!(times(start, TimeStep::Days(1.0), 3..4), [end]);
        }
        assert_eq!(times("2017-01-01T12:00:00Z", TimeStep::Days(-0.5), 0..4)[3], "2016-12-31T00:00:00Z");
    }
}
