//! The events of the timeline that have been found so far, and the next search for more.
//!
//! In: the displayed span of time, found events. Out: the next short search; the known events ordered by time. Always: the searched span has no
//! gaps; its end that is closer to the middle of the displayed span is extended first. If the middle of the displayed span is farther from the searched
//! span than the length of one search, all events are dropped and the search starts again at that middle. If a search reaches beyond the ephemeris,
//! shorter ones approach the end of the ephemeris. Not here: the thread that searches, and the painting.

use super::event_search::{EventKind, EventSearch, SkyEvent};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use std::sync::Arc;

/// An event with its title.
#[derive(Clone, Debug)]
pub(crate) struct KnownEvent {
    /// Time of the greatest phase, TDB seconds past J2000.
    pub tdb_s: f64,
    pub title: String,
    pub event: Arc<SkyEvent>,
}

/// Shortest search, seconds. At the end of the ephemeris, a part shorter than two days therefore remains unsearched, besides the margin that the search
/// itself needs.
const MIN_SEARCH_S: f64 = SECONDS_PER_DAY;
/// Number of events above which all events are dropped and the search starts again.
const MAX_EVENTS: usize = 5000;

/// Index of the side before the searched span in the arrays of [`KnownEvents`].
const BEFORE: usize = 0;
/// Index of the side after the searched span.
const AFTER: usize = 1;

/// The events of some kinds found so far.
#[derive(Debug)]
pub(crate) struct KnownEvents {
    kinds: &'static [EventKind],
    /// Length of a search, except near an end of the ephemeris; see `lengths_s`.
    step_s: f64,
    /// For each side ([`BEFORE`], [`AFTER`]): length of its next search. Once a search on a side has reached beyond the ephemeris, the length for this side
    /// is halved after each search.
    lengths_s: [f64; 2],
    /// Start and end of the searched span, TDB seconds past J2000; `None` before the first search.
    searched_span: Option<(f64, f64)>,
    /// For each side ([`BEFORE`], [`AFTER`]): whether nothing is left to search on this side, because the ephemeris ends.
    is_exhausted: [bool; 2],
    events: Vec<KnownEvent>,
}

/// A short search, and the side on which it extends the searched span.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NextSearch {
    pub search: EventSearch,
    /// Whether the search extends the searched span at its start, back in time.
    is_backward: bool,
    /// The end of the searched span at which the search starts, TDB seconds past J2000.
    start_tdb_s: f64,
    length_s: f64,
}

impl KnownEvents {
    /// No events yet. `step_days`: length of one search.
    pub(crate) fn new(kinds: &'static [EventKind], step_days: f64) -> Self {
        let step_s = step_days * SECONDS_PER_DAY;
        Self { kinds, step_s, lengths_s: [step_s; 2], searched_span: None, is_exhausted: [false; 2], events: Vec::new() }
    }

    /// The next search for the displayed span `from_tdb_s..to_tdb_s`, TDB seconds past J2000; `None` if the span has been searched.
    pub(crate) fn next_search(&mut self, from_tdb_s: f64, to_tdb_s: f64) -> Option<NextSearch> {
        let middle_tdb_s = 0.5 * (from_tdb_s + to_tdb_s);
        let is_far_from_middle =
            |(first_tdb_s, last_tdb_s): (f64, f64)| middle_tdb_s < first_tdb_s - self.step_s || middle_tdb_s > last_tdb_s + self.step_s;
        if self.searched_span.is_none_or(is_far_from_middle) || self.events.len() > MAX_EVENTS {
            (self.searched_span, self.is_exhausted) = (Some((middle_tdb_s, middle_tdb_s)), [false; 2]);
            self.lengths_s = [self.step_s; 2];
            self.events.clear();
        }
        let (first_tdb_s, last_tdb_s) = self.searched_span?;
        let is_incomplete = [first_tdb_s > from_tdb_s && !self.is_exhausted[BEFORE], last_tdb_s < to_tdb_s && !self.is_exhausted[AFTER]];
        let is_backward = match is_incomplete {
            [false, false] => return None,
            [true, true] => middle_tdb_s - first_tdb_s < last_tdb_s - middle_tdb_s,
            [is_incomplete_before, _] => is_incomplete_before,
        };
        let start_tdb_s = if is_backward { first_tdb_s } else { last_tdb_s };
        let start = Instant::from_tdb_seconds_past_j2000(start_tdb_s);
        let length_s = self.lengths_s[if is_backward { BEFORE } else { AFTER }];
        Some(NextSearch { search: EventSearch::new(self.kinds.to_vec(), start, length_s, is_backward), is_backward, start_tdb_s, length_s })
    }

    /// Stores the result of a search. `found`: its events; `None` if a part of the search is outside the ephemeris. The result is dropped if the search does
    /// not start at an end of the searched span.
    pub(crate) fn add_result(&mut self, search: &NextSearch, found: Option<Vec<KnownEvent>>) {
        let Some((first_tdb_s, last_tdb_s)) = &mut self.searched_span else { return };
        let end_tdb_s = if search.is_backward { first_tdb_s } else { last_tdb_s };
        if *end_tdb_s != search.start_tdb_s {
            return;
        }
        let side = if search.is_backward { BEFORE } else { AFTER };
        // Bisection: the ephemeris ends within the length of a search that failed. After each further search, whether it failed or not, the end of the
        // ephemeris is no farther from the searched span than the length of that search.
        if found.is_none() || search.length_s < self.step_s {
            self.lengths_s[side] = 0.5 * search.length_s;
            self.is_exhausted[side] = self.lengths_s[side] < MIN_SEARCH_S;
        }
        let Some(found) = found else { return };
        *end_tdb_s += if search.is_backward { -search.length_s } else { search.length_s };
        self.events.extend(found);
        self.events.sort_by(|a, b| a.tdb_s.total_cmp(&b.tdb_s));
    }

    /// The parts of the displayed span `from_tdb_s..to_tdb_s` that are still to be searched: start and end of the part before the searched span, and of the
    /// part after it.
    pub(crate) fn unsearched(&self, from_tdb_s: f64, to_tdb_s: f64) -> [Option<(f64, f64)>; 2] {
        let Some((first_tdb_s, last_tdb_s)) = self.searched_span else { return [Some((from_tdb_s, to_tdb_s)), None] };
        let part_before = (first_tdb_s > from_tdb_s && !self.is_exhausted[BEFORE]).then(|| (from_tdb_s, first_tdb_s.min(to_tdb_s)));
        let part_after = (last_tdb_s < to_tdb_s && !self.is_exhausted[AFTER]).then(|| (last_tdb_s.max(from_tdb_s), to_tdb_s));
        [part_before, part_after]
    }

    /// Formats the titles again, in the current language.
    pub(crate) fn rewrite_titles(&mut self, title: impl Fn(&SkyEvent) -> String) {
        for known in &mut self.events {
            known.title = title(&known.event);
        }
    }

    /// The known events in the span `from_tdb_s..to_tdb_s`, TDB seconds past J2000, ordered by time.
    pub(crate) fn between(&self, from_tdb_s: f64, to_tdb_s: f64) -> &[KnownEvent] {
        let first_index_at = |tdb_s: f64| self.events.partition_point(|e| e.tdb_s < tdb_s);
        self.events.get(first_index_at(from_tdb_s)..first_index_at(to_tdb_s)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::events::{MoonEvent, MoonEventType};
    use crate::units::DAYS_PER_JULIAN_YEAR;

    const DAY_S: f64 = SECONDS_PER_DAY;

    /// Number of searches until a span has been searched.
    fn searches_needed(known: &mut KnownEvents, from_s: f64, to_s: f64) -> usize {
        let mut searches = 0;
        while let Some(next) = known.next_search(from_s, to_s) {
            known.add_result(&next, Some(Vec::new()));
            searches += 1;
            assert!(searches < 1000, "no end");
        }
        searches
    }

    #[test]
    fn a_span_is_searched_only_once_and_extended_when_the_displayed_span_moves() {
        let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
        assert_eq!(searches_needed(&mut known, 0.0, 100.0 * DAY_S), 10);
        assert_eq!(searches_needed(&mut known, 0.0, 100.0 * DAY_S), 0);
        assert_eq!(searches_needed(&mut known, 30.0 * DAY_S, 120.0 * DAY_S), 2, "only the new part after the searched span");
        assert_eq!(searches_needed(&mut known, -10.0 * DAY_S, 50.0 * DAY_S), 1, "only the new part before the searched span");
        assert_eq!(searches_needed(&mut known, 9000.0 * DAY_S, 9100.0 * DAY_S), 10, "the search starts again elsewhere");
        assert_eq!(known.searched_span, Some((9000.0 * DAY_S, 9100.0 * DAY_S)));
    }

    #[test]
    fn the_unsearched_parts_shrink_from_the_middle_to_the_ends() {
        let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
        let (from_s, to_s) = (0.0, 100.0 * DAY_S);
        assert_eq!(known.unsearched(from_s, to_s), [Some((from_s, to_s)), None]);
        for step in 1..=4 {
            let next = known.next_search(from_s, to_s).expect("a search");
            known.add_result(&next, Some(Vec::new()));
            let [before, after] = known.unsearched(from_s, to_s).map(|part| part.map_or(0.0, |(a, b)| b - a));
            assert_eq!(before + after, (100.0 - 10.0 * f64::from(step)) * DAY_S);
            assert!((before - after).abs() <= 10.0 * DAY_S, "{before} {after}");
        }
        searches_needed(&mut known, from_s, to_s);
        assert_eq!(known.unsearched(from_s, to_s), [None; 2]);
        while let Some(later) = known.next_search(50.0 * DAY_S, 150.0 * DAY_S) {
            known.add_result(&later, None);
        }
        assert_eq!(known.unsearched(50.0 * DAY_S, 150.0 * DAY_S), [None; 2], "nothing is searched beyond the ephemeris");
    }

    /// A change of the language changes the titles, and searches nothing again.
    #[test]
    fn titles_are_rewritten_without_a_search() {
        let mut known = KnownEvents::new(&[EventKind::Moons], 10.0);
        let next = known.next_search(0.0, 10.0 * DAY_S).expect("a search");
        let greatest = Instant::from_tdb_seconds_past_j2000(5.0 * DAY_S);
        let (moon, planet) = (NaifId(501), NaifId(599));
        let event = MoonEvent { class: MoonEventType::Transit, moon, planet, nearer_moon: None, greatest, contacts: Vec::new() };
        let found = KnownEvent { tdb_s: 5.0 * DAY_S, title: "before".into(), event: Arc::new(SkyEvent::Moons(event)) };
        known.add_result(&next, Some(vec![found]));
        searches_needed(&mut known, 0.0, 10.0 * DAY_S);
        known.rewrite_titles(|event| format!("{:?}", event.kind()));
        assert_eq!(known.between(0.0, 10.0 * DAY_S).iter().map(|e| e.title.as_str()).collect::<Vec<_>>(), ["Moons"]);
        assert_eq!(searches_needed(&mut known, 0.0, 10.0 * DAY_S), 0);
    }

    /// The built-in series reach from 3001 BC to AD 3000; a kernel may reach further.
    #[test]
    fn both_sides_of_a_distant_date_are_searched() {
        for years in [-12_000.0, -3500.0, 1500.0, 9000.0] {
            let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
            let middle_s = years * DAYS_PER_JULIAN_YEAR * DAY_S;
            assert_eq!(searches_needed(&mut known, middle_s - 100.0 * DAY_S, middle_s + 100.0 * DAY_S), 20, "{years}");
        }
    }

    /// The last search before the end of the ephemeris once failed as a whole, so that up to 500 days seemed to be without events.
    #[test]
    fn the_span_is_searched_up_to_the_end_of_the_ephemeris() {
        for end_days in [-499.0, -3.0, 3.0, 499.0, 500.0, 501.0, 730.0, 1234.5] {
            // Whether the ephemeris covers a search. A negative `end_days` is the beginning of the ephemeris, a positive one its end.
            let is_covered = |search: &NextSearch| {
                let start_s = search.start_tdb_s;
                let end_s = start_s + search.length_s * if search.is_backward { -1.0 } else { 1.0 };
                if end_days < 0.0 { start_s.min(end_s) >= end_days * DAY_S } else { start_s.max(end_s) <= end_days * DAY_S }
            };
            let mut known = KnownEvents::new(&[EventKind::Solar], 500.0);
            let mut searches = 0;
            while let Some(next) = known.next_search(-2000.0 * DAY_S, 2000.0 * DAY_S) {
                known.add_result(&next, is_covered(&next).then(Vec::new));
                searches += 1;
                assert!(searches < 30, "{end_days}: no end");
            }
            let (first_s, last_s) = known.searched_span.expect("a span");
            let unsearched_days = if end_days < 0.0 { first_s / DAY_S - end_days } else { end_days - last_s / DAY_S };
            assert!((0.0..2.0).contains(&unsearched_days), "{end_days}: {unsearched_days} days are left");
        }
    }

    #[test]
    fn nothing_is_searched_beyond_the_ephemeris_and_late_results_are_dropped() {
        let mut known = KnownEvents::new(&[EventKind::Lunar], 10.0);
        let first = known.next_search(0.0, 20.0 * DAY_S).expect("a search");
        known.add_result(&first, None);
        let mut lengths_s = vec![first.length_s];
        while let Some(next) = known.next_search(0.0, 20.0 * DAY_S) {
            known.add_result(&next, None);
            lengths_s.push(next.length_s);
        }
        // Searches of 10, 5, 2.5 and 1.25 days on each side.
        lengths_s.sort_by(f64::total_cmp);
        assert_eq!(lengths_s, [1.25, 1.25, 2.5, 2.5, 5.0, 5.0, 10.0, 10.0].map(|days| days * DAY_S));
        let elsewhere = known.next_search(900.0 * DAY_S, 920.0 * DAY_S).expect("a search");
        known.add_result(&first, Some(Vec::new()));
        assert_eq!(known.searched_span, Some((910.0 * DAY_S, 910.0 * DAY_S)));
        known.add_result(&elsewhere, Some(Vec::new()));
        assert_ne!(known.searched_span, Some((910.0 * DAY_S, 910.0 * DAY_S)));
    }
}
