//! The number of an eclipse in its Saros series.
//!
//! In: an eclipse, and a function that reports whether there is an eclipse at another phase of the same series. Out: its number, starting at 1. A series
//! begins with the first eclipse that the radii in force give: with a smaller shadow it may begin later.

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
    /// Number of the eclipse at `syzygy` in its series. The eclipses of a series follow each other without a gap, so bisection finds the first.
    ///
    /// # Errors
    /// The error of `exists`.
    pub(crate) fn member<E>(&mut self, syzygy: Syzygy, exists: impl Fn(Syzygy) -> Result<bool, E>) -> Result<i64, E> {
        let series = syzygy.saros();
        let first = match self.first_lunations.get(&series) {
            Some(first) => *first,
            None => {
                let (mut earlier_members, mut too_many) = (0, MAX_MEMBERS);
                while too_many - earlier_members > 1 {
                    let middle = (earlier_members + too_many) / 2;
                    if exists(Syzygy { lunation: syzygy.lunation - SAROS_LUNATIONS * middle, ..syzygy })? {
                        earlier_members = middle;
                    } else {
                        too_many = middle;
                    }
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
}
