//! The events of the timeline that have been found so far, and the two searches for more: back in time, and forward.
//!
//! In: the displayed span of time, found events. Out: the search whose next step is due; the known events ordered by time. Always: the searched span has no
//! gaps; its end that is closer to the middle of the displayed span is extended first. If the middle of the displayed span is farther from the searched
//! span than the length of one step (than `MIN_STEP_S` if the ephemeris covered no step from where the searches started), or if there are too many events,
//! all events are dropped and both searches start again at that middle. Not here: the thread that searches, and the painting.

use super::event_search::{EventKind, EventSearch, MIN_STEP_S, SkyEvent};
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

/// Number of events above which all events are dropped and the searches start again.
const MAX_EVENTS: usize = 5000;

/// The events of some kinds found so far.
#[derive(Debug)]
pub(crate) struct KnownEvents {
    kinds: &'static [EventKind],
    /// Length of a step of the searches, seconds.
    step_s: f64,
    /// The searches back and forward in time from the same instant, in this order; `None` before the first step. What both have searched is the searched
    /// span.
    searches: Option<[EventSearch; 2]>,
    events: Vec<KnownEvent>,
}

impl KnownEvents {
    /// No events yet. `step_days`: length of one step.
    pub(crate) fn new(kinds: &'static [EventKind], step_days: f64) -> Self {
        Self { kinds, step_s: step_days * SECONDS_PER_DAY, searches: None, events: Vec::new() }
    }

    /// Start and end of the searched span, TDB seconds past J2000; `None` before the searches start.
    fn searched_span(&self) -> Option<(f64, f64)> {
        let [first_tdb_s, last_tdb_s] = self.searches.as_ref()?.each_ref().map(|search| search.searched_until().tdb_seconds_past_j2000());
        Some((first_tdb_s, last_tdb_s))
    }

    /// How far from the searched span the middle of the displayed span may be, seconds, before the searches start again. This is the length of a step, or
    /// `MIN_STEP_S` if the ephemeris covered no step of either search: it may still cover a time that is less than a step away, which must then be searched.
    fn reach_s(&self) -> f64 {
        let found_nothing_covered =
            |[back, forward]: &[EventSearch; 2]| back.is_over() && forward.is_over() && back.searched_until() == forward.searched_until();
        if self.searches.as_ref().is_some_and(found_nothing_covered) { MIN_STEP_S } else { self.step_s }
    }

    /// The search whose next step extends the searched span towards the displayed span `from_tdb_s..to_tdb_s`, TDB seconds past J2000; `None` if the
    /// displayed span has been searched.
    pub(crate) fn next_search(&mut self, from_tdb_s: f64, to_tdb_s: f64) -> Option<EventSearch> {
        let middle_tdb_s = 0.5 * (from_tdb_s + to_tdb_s);
        let reach_s = self.reach_s();
        let is_far_from_middle =
            |(first_tdb_s, last_tdb_s): (f64, f64)| middle_tdb_s < first_tdb_s - reach_s || middle_tdb_s > last_tdb_s + reach_s;
        if self.searched_span().is_none_or(is_far_from_middle) || self.events.len() > MAX_EVENTS {
            let middle = Instant::from_tdb_seconds_past_j2000(middle_tdb_s);
            let endless_s = f64::INFINITY;
            let search = |is_backward| EventSearch::new(self.kinds.to_vec(), middle, endless_s, is_backward).in_steps_of(self.step_s);
            self.searches = Some([true, false].map(search));
            self.events.clear();
        }
        let (first_tdb_s, last_tdb_s) = self.searched_span()?;
        let [back, forward] = self.searches.as_ref()?;
        match [first_tdb_s > from_tdb_s && !back.is_over(), last_tdb_s < to_tdb_s && !forward.is_over()] {
            [false, false] => None,
            [true, true] if middle_tdb_s - first_tdb_s < last_tdb_s - middle_tdb_s => Some(back.clone()),
            [true, false] => Some(back.clone()),
            [_, true] => Some(forward.clone()),
        }
    }

    /// Stores the result of a step. `search`: from [`Self::next_search`]; `advanced`: the same search after the step, which found the events `found`. The
    /// result is dropped if the searches have started again meanwhile.
    pub(crate) fn add_result(&mut self, search: &EventSearch, advanced: EventSearch, found: Vec<KnownEvent>) {
        let Some(stored) = self.searches.iter_mut().flatten().find(|stored| **stored == *search) else { return };
        *stored = advanced;
        self.events.extend(found);
        self.events.sort_by(|a, b| a.tdb_s.total_cmp(&b.tdb_s));
    }

    /// The parts of the displayed span `from_tdb_s..to_tdb_s` that are still to be searched: start and end of the part before the searched span, and of the
    /// part after it.
    pub(crate) fn unsearched(&self, from_tdb_s: f64, to_tdb_s: f64) -> [Option<(f64, f64)>; 2] {
        let (Some((first_tdb_s, last_tdb_s)), Some([back, forward])) = (self.searched_span(), &self.searches) else {
            return [Some((from_tdb_s, to_tdb_s)), None];
        };
        let part_before = (first_tdb_s > from_tdb_s && !back.is_over()).then(|| (from_tdb_s, first_tdb_s.min(to_tdb_s)));
        let part_after = (last_tdb_s < to_tdb_s && !forward.is_over()).then(|| (last_tdb_s.max(from_tdb_s), to_tdb_s));
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
    use crate::ephemeris::EphemerisError;
    use crate::events::{MoonEvent, MoonEventType};
    use crate::units::DAYS_PER_JULIAN_YEAR;

    const DAY_S: f64 = SECONDS_PER_DAY;
    /// For the parameter `is_covered` of [`advanced`].
    const COVERED: bool = true;

    /// A search after a step. `is_covered`: whether the ephemeris covers the step.
    fn advanced(search: &EventSearch, is_covered: bool) -> EventSearch {
        let mut advanced = search.clone();
        advanced.finish_step((!is_covered).then(|| EphemerisError::other("not covered")));
        advanced
    }

    /// Number of steps until a span has been searched. `is_covered`: whether the ephemeris covers the next step of a search.
    fn steps_needed(known: &mut KnownEvents, from_tdb_s: f64, to_tdb_s: f64, is_covered: impl Fn(&EventSearch) -> bool) -> usize {
        let mut steps = 0;
        while let Some(next) = known.next_search(from_tdb_s, to_tdb_s) {
            known.add_result(&next, advanced(&next, is_covered(&next)), Vec::new());
            steps += 1;
            assert!(steps < 1000, "no end");
        }
        steps
    }

    #[test]
    fn a_span_is_searched_only_once_and_extended_when_the_displayed_span_moves() {
        let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
        let mut steps = |from_days: f64, to_days: f64| steps_needed(&mut known, from_days * DAY_S, to_days * DAY_S, |_| true);
        assert_eq!(steps(0.0, 100.0), 10);
        assert_eq!(steps(0.0, 100.0), 0);
        assert_eq!(steps(30.0, 120.0), 2, "only the new part after the searched span");
        assert_eq!(steps(-10.0, 50.0), 1, "only the new part before the searched span");
        assert_eq!(steps(9000.0, 9100.0), 10, "the searches start again elsewhere");
        assert_eq!(known.searched_span(), Some((9000.0 * DAY_S, 9100.0 * DAY_S)));
    }

    #[test]
    fn the_unsearched_parts_shrink_from_the_middle_to_the_ends() {
        let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
        let (from_tdb_s, to_tdb_s) = (0.0, 100.0 * DAY_S);
        assert_eq!(known.unsearched(from_tdb_s, to_tdb_s), [Some((from_tdb_s, to_tdb_s)), None]);
        for step in 1..=4 {
            let next = known.next_search(from_tdb_s, to_tdb_s).expect("a search");
            known.add_result(&next, advanced(&next, COVERED), Vec::new());
            let [before, after] = known.unsearched(from_tdb_s, to_tdb_s).map(|part| part.map_or(0.0, |(a, b)| b - a));
            assert_eq!(before + after, (100.0 - 10.0 * f64::from(step)) * DAY_S);
            assert!((before - after).abs() <= 10.0 * DAY_S, "{before} {after}");
        }
        steps_needed(&mut known, from_tdb_s, to_tdb_s, |_| true);
        assert_eq!(known.unsearched(from_tdb_s, to_tdb_s), [None; 2]);
        steps_needed(&mut known, 50.0 * DAY_S, 150.0 * DAY_S, |_| false);
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
        known.add_result(&next, advanced(&next, COVERED), vec![found]);
        steps_needed(&mut known, 0.0, 10.0 * DAY_S, |_| true);
        known.rewrite_titles(|event| format!("{:?}", event.kind()));
        assert_eq!(known.between(0.0, 10.0 * DAY_S).iter().map(|e| e.title.as_str()).collect::<Vec<_>>(), ["Moons"]);
        assert_eq!(steps_needed(&mut known, 0.0, 10.0 * DAY_S, |_| true), 0);
    }

    /// The dates are inside and outside the span of the built-in series, from the end of 3002 BC to AD 3000, because a kernel may reach further.
    #[test]
    fn both_sides_of_a_distant_date_are_searched() {
        for years_past_j2000 in [-12_000.0, -3500.0, 1500.0, 9000.0] {
            let mut known = KnownEvents::new(&[EventKind::Solar], 10.0);
            let middle_tdb_s = years_past_j2000 * DAYS_PER_JULIAN_YEAR * DAY_S;
            let (from_tdb_s, to_tdb_s) = (middle_tdb_s - 100.0 * DAY_S, middle_tdb_s + 100.0 * DAY_S);
            assert_eq!(steps_needed(&mut known, from_tdb_s, to_tdb_s, |_| true), 20, "{years_past_j2000}");
        }
    }

    /// The last step before the end of the ephemeris once failed as a whole, so that up to 500 days seemed to be without events.
    #[test]
    fn the_span_is_searched_up_to_the_end_of_the_ephemeris() {
        // A negative `end_days` is the beginning of the ephemeris, a positive one its end.
        for end_days in [-499.0, -3.0, 3.0, 499.0, 500.0, 501.0, 730.0, 1234.5] {
            let is_covered = |search: &EventSearch| {
                let step_end_days = search.end_of_step().tdb_seconds_past_j2000() / DAY_S;
                if end_days < 0.0 { step_end_days >= end_days } else { step_end_days <= end_days }
            };
            let mut known = KnownEvents::new(&[EventKind::Solar], 500.0);
            let steps = steps_needed(&mut known, -2000.0 * DAY_S, 2000.0 * DAY_S, is_covered);
            assert!(steps < 30, "{end_days}: {steps} steps");
            let (first_tdb_s, last_tdb_s) = known.searched_span().expect("a span");
            let unsearched_days = if end_days < 0.0 { first_tdb_s / DAY_S - end_days } else { end_days - last_tdb_s / DAY_S };
            assert!((0.0..2.0).contains(&unsearched_days), "{end_days}: {unsearched_days} days are left");
        }
    }

    /// When the searches started beyond the end of the ephemeris, the 500 days before their start once counted as searched, too.
    #[test]
    fn a_search_that_began_outside_the_ephemeris_starts_again_inside() {
        // The ephemeris ends at J2000.
        let is_covered = |search: &EventSearch| {
            [search.searched_until(), search.end_of_step()].into_iter().all(|end| end.tdb_seconds_past_j2000() <= 0.0)
        };
        let mut known = KnownEvents::new(&[EventKind::Solar], 500.0);
        let mut steps = |from_days: f64, to_days: f64| steps_needed(&mut known, from_days * DAY_S, to_days * DAY_S, is_covered);
        assert!(steps(50.0, 150.0) > 0);
        assert_eq!(steps(50.5, 150.5), 0, "no search starts again after a move of less than `MIN_STEP_S`");
        assert!(steps(-350.0, -250.0) > 0);
        let (first_tdb_s, last_tdb_s) = known.searched_span().expect("a span");
        assert!(first_tdb_s <= -350.0 * DAY_S && last_tdb_s >= -250.0 * DAY_S, "{} to {} days", first_tdb_s / DAY_S, last_tdb_s / DAY_S);
    }

    #[test]
    fn nothing_is_searched_beyond_the_ephemeris_and_late_results_are_dropped() {
        let mut known = KnownEvents::new(&[EventKind::Lunar], 10.0);
        let first = known.next_search(0.0, 20.0 * DAY_S).expect("a search");
        let mut lengths_days = Vec::new();
        while let Some(next) = known.next_search(0.0, 20.0 * DAY_S) {
            let [start_tdb_s, end_tdb_s] = [next.searched_until(), next.end_of_step()].map(Instant::tdb_seconds_past_j2000);
            lengths_days.push((end_tdb_s - start_tdb_s).abs() / DAY_S);
            known.add_result(&next, advanced(&next, !COVERED), Vec::new());
        }
        // Steps of 10, 5, 2.5 and 1.25 days on each side.
        lengths_days.sort_by(f64::total_cmp);
        assert_eq!(lengths_days, [1.25, 1.25, 2.5, 2.5, 5.0, 5.0, 10.0, 10.0]);
        let elsewhere = known.next_search(900.0 * DAY_S, 920.0 * DAY_S).expect("a search");
        known.add_result(&first, advanced(&first, COVERED), Vec::new());
        assert_eq!(known.searched_span(), Some((910.0 * DAY_S, 910.0 * DAY_S)));
        known.add_result(&elsewhere, advanced(&elsewhere, COVERED), Vec::new());
        assert_ne!(known.searched_span(), Some((910.0 * DAY_S, 910.0 * DAY_S)));
    }
}
