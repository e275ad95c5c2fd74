//! The member number of an eclipse: its number within its Saros series.
//!
//! In: the new or full moon of an eclipse, and a function that reports whether there is an eclipse at another new or full moon of the same series. Out: the
//! member number, starting at 1. It depends on the radii of the Sun and the Moon: with a smaller shadow the series may begin later.

use super::lunation::Syzygy;
use std::collections::HashMap;

/// Lunations from one eclipse of a series to the next.
const SAROS_LUNATIONS: i64 = 223;
/// More than the number of eclipses of any series, which is some 70 to 90.
const MEMBERS_BOUND: i64 = 100;

/// Cache of the lunation at which each series begins. Solar and lunar series have the same numbers, so each kind needs its own cache.
#[derive(Debug, Default)]
pub(super) struct SeriesStarts {
    /// By the number of the series: the lunation of its first eclipse.
    first_lunations: HashMap<i64, i64>,
}

impl SeriesStarts {
    /// Member number of the eclipse at `syzygy`, which must be one. `is_eclipse_at`: whether there is an eclipse at a new or full moon; it fails where the
    /// ephemeris does not reach back. The eclipses of a series have no gaps, so bisection finds the first. Where `is_eclipse_at` fails, the search assumes that
    /// the series has not begun.
    ///
    /// # Errors
    /// If `is_eclipse_at` fails 223 lunations before the earliest eclipse found, the series may have begun earlier: that error.
    pub(crate) fn member<E>(&mut self, syzygy: Syzygy, is_eclipse_at: impl Fn(Syzygy) -> Result<bool, E>) -> Result<i64, E> {
        let series = syzygy.saros_series();
        let first_lunation = match self.first_lunations.get(&series) {
            Some(first_lunation) => *first_lunation,
            None => {
                // The number of eclipses of the series before this one is at least `lower` and less than `upper`.
                let (mut lower, mut upper) = (0, MEMBERS_BOUND);
                let mut error_at_upper = None;
                while upper - lower > 1 {
                    let middle = (lower + upper) / 2;
                    match is_eclipse_at(Syzygy { lunation: syzygy.lunation - SAROS_LUNATIONS * middle, ..syzygy }) {
                        Ok(true) => lower = middle,
                        Ok(false) => (upper, error_at_upper) = (middle, None),
                        Err(e) => (upper, error_at_upper) = (middle, Some(e)),
                    }
                }
                if let Some(e) = error_at_upper {
                    return Err(e);
                }
                let first_lunation = syzygy.lunation - SAROS_LUNATIONS * lower;
                self.first_lunations.insert(series, first_lunation);
                first_lunation
            }
        };
        Ok((syzygy.lunation - first_lunation) / SAROS_LUNATIONS + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::lunation::Phase;
    use std::cell::Cell;

    #[test]
    fn members_are_counted_from_the_first() {
        let at = |lunation| Syzygy { phase: Phase::New, lunation };
        let calls = Cell::new(0);
        let is_eclipse_at = |s: Syzygy| {
            calls.set(calls.get() + 1);
            Ok::<_, ()>(s.lunation >= 300 - 29 * SAROS_LUNATIONS)
        };
        let mut starts = SeriesStarts::default();
        assert_eq!(starts.member(at(300), is_eclipse_at), Ok(30));
        let calls_of_one_search = calls.get();
        // Bisection among 100 members takes at most seven calls.
        assert!(calls_of_one_search < 9);
        assert_eq!(starts.member(at(300 + SAROS_LUNATIONS), is_eclipse_at), Ok(31));
        assert_eq!(calls.get(), calls_of_one_search, "the series is known");
        assert_eq!(SeriesStarts::default().member(at(300), |_| Err::<bool, _>("too early")), Err("too early"));
    }

    /// Member 20 of a series. Its number is known if the series can be computed back to the full moon before its first member, the 20th before member 20.
    /// `computable`: how many full moons of the series before member 20 can be computed.
    #[test]
    fn the_number_is_unknown_only_if_the_series_may_begin_before_the_span() {
        let at = |lunation| Syzygy { phase: Phase::Full, lunation };
        for (computable, expected) in [(19, Err("too early")), (20, Ok(20)), (24, Ok(20)), (60, Ok(20))] {
            let is_eclipse_at = |s: Syzygy| match (300 - s.lunation) / SAROS_LUNATIONS {
                earlier if earlier > computable => Err("too early"),
                earlier => Ok(earlier <= 19),
            };
            assert_eq!(SeriesStarts::default().member(at(300), is_eclipse_at), expected, "{computable} earlier full moons");
        }
    }
}
