//! The number of an eclipse in its Saros series.
//!
//! In: an eclipse, and a function that reports whether there is an eclipse at another phase of the same series. Out: its number, starting at 1. A series
//! begins with the first eclipse that the chosen radii of the Sun and the Moon give: with a smaller shadow it may begin later.

use super::lunation::Syzygy;
use std::collections::HashMap;

/// Lunations from one eclipse of a series to the next.
const SAROS_LUNATIONS: i64 = 223;
/// More than the number of eclipses of any series.
const MAX_MEMBERS: i64 = 100;

/// Cache of the first lunations of series.
#[derive(Debug, Default)]
pub(super) struct SeriesStarts {
    /// Lunation of the first eclipse by number of the series.
    first_lunations: HashMap<i64, i64>,
}

impl SeriesStarts {
    /// Number of the eclipse at `syzygy` in its series. The eclipses of a series follow each other without a gap, so bisection finds the first. A probe
    /// where `exists` fails counts as without an eclipse: it is usually far before the series, and before the theories' span.
    ///
    /// # Errors
    /// The error of `exists` at the phase before the earliest known eclipse, which may then not be the first.
    pub(crate) fn member<E>(&mut self, syzygy: Syzygy, exists: impl Fn(Syzygy) -> Result<bool, E>) -> Result<i64, E> {
        let series = syzygy.saros();
        let first = match self.first_lunations.get(&series) {
            Some(first) => *first,
            None => {
                let (mut earlier_members, mut too_many) = (0, MAX_MEMBERS);
                let mut error_at_too_many = None;
                while too_many - earlier_members > 1 {
                    let middle = (earlier_members + too_many) / 2;
                    match exists(Syzygy { lunation: syzygy.lunation - SAROS_LUNATIONS * middle, ..syzygy }) {
                        Ok(true) => earlier_members = middle,
                        Ok(false) => (too_many, error_at_too_many) = (middle, None),
                        Err(e) => (too_many, error_at_too_many) = (middle, Some(e)),
                    }
                }
                if let Some(e) = error_at_too_many {
                    return Err(e);
                }
                let first = syzygy.lunation - SAROS_LUNATIONS * earlier_members;
                self.first_lunations.insert(series, first);
                first
            }
        };
        Ok((syzygy.lunation - first) / SAROS_LUNATIONS + 1)
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
        let exists = |s: Syzygy| {
            calls.set(calls.get() + 1);
            Ok::<_, ()>(s.lunation >= 300 - 29 * SAROS_LUNATIONS)
        };
        let mut starts = SeriesStarts::default();
        assert_eq!(starts.member(at(300), exists), Ok(30));
        let calls_of_one_search = calls.get();
        assert!(calls_of_one_search < 9);
        assert_eq!(starts.member(at(300 + SAROS_LUNATIONS), exists), Ok(31));
        assert_eq!(calls.get(), calls_of_one_search, "the series is known");
        assert_eq!(SeriesStarts::default().member(at(300), |_| Err::<bool, _>("too early")), Err("too early"));
    }

    /// Member 20 of a series: the number is known if the phase before the first member can be computed, however many earlier ones cannot.
    #[test]
    fn only_a_start_at_the_end_of_the_span_is_unknown() {
        let at = |lunation| Syzygy { phase: Phase::Full, lunation };
        for (computable, expected) in [(19, Err("too early")), (20, Ok(20)), (24, Ok(20)), (60, Ok(20))] {
            let exists = |s: Syzygy| match (300 - s.lunation) / SAROS_LUNATIONS {
                earlier if earlier > computable => Err("too early"),
                earlier => Ok(earlier <= 19),
            };
            assert_eq!(SeriesStarts::default().member(at(300), exists), expected, "{computable} earlier phases");
        }
    }
}
