//! Coverage of the theories (kernels, series, mean elements, orbits of a catalog), for messages: why a state is not available at an instant, and which fields
//! of a catalog no theory supports.
//!
//! In: targets, instants, a catalog. Out: messages for the user. Always: the span in a message goes from the first to the last time that the theories cover; if
//! the instant is in a gap of this span, the message names the gap. No positions are computed here.

use super::{
    Ephemeris, EphemerisError, MAX_CHAIN_LINKS, MEAN_ELEMENTS_YEARS, ORBIT_YEARS, SERIES_YEARS, Source, is_centre_from_moons, mean_elements,
};
use crate::catalog::{Catalog, Motion, NaifId, Rotation};
use crate::message::{Argument, message};
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};

/// A field of a body that no theory supports at any time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnsupportedField {
    /// The body that has the field.
    pub body: NaifId,
    /// Key in the body's table of the catalog: `motion`, `parent` or `rotation`.
    pub field: &'static str,
    /// The reason, and what to write instead, in English.
    pub why: String,
}

/// Converts a span of Julian years to TDB seconds past J2000.
fn span_s((first, last): (f64, f64)) -> (f64, f64) {
    let seconds = |year: f64| (year - 2000.0) * DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
    (seconds(first), seconds(last))
}

/// Spans in their order; those that overlap or meet are one.
fn joined(mut spans: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut all: Vec<(f64, f64)> = Vec::with_capacity(spans.len());
    for (start, end) in spans {
        match all.last_mut() {
            Some((_, last_end)) if start <= *last_end => *last_end = last_end.max(end),
            _ => all.push((start, end)),
        }
    }
    all
}

/// An end of a span that does not contain `t`: its date, and the time of day only if `t` is on the same day.
fn end_text(end_s: f64, t: Instant) -> String {
    let text = Instant::from_tdb_seconds_past_j2000(end_s).to_utc_iso();
    match text.split_once('T') {
        Some((date, _)) if !t.to_utc_iso().starts_with(date) => date.to_owned(),
        _ => text,
    }
}

/// Number of links by which kernels or series lead from a body to the solar system's barycentre. The links of the series are counted; a kernel may need fewer.
fn links_to_barycentre(id: NaifId) -> usize {
    let origin_of = |id: &i32| if is_centre_from_moons(NaifId(*id)) { Some(id / 100) } else { mean_elements::origin_of(*id) };
    match std::iter::successors(Some(id.0), origin_of).count() - 1 {
        // Only a kernel has the body, usually relative to the Sun, which is relative to the barycentre.
        0 => 2,
        links => links,
    }
}

impl Ephemeris {
    pub(super) fn name_of(&self, target: NaifId) -> String {
        let named = |id: i32| self.names.get(&NaifId(id));
        match (target.0, named(target.0)) {
            (_, Some(name)) => name.clone(),
            (0, _) => "the solar system's barycentre".into(),
            (3, _) => "the Earth-Moon barycentre".into(),
            (system @ 1..=9, _) => match named(system * 100 + 99) {
                Some(planet) => format!("{planet}'s barycentre"),
                None => format!("barycentre {system}"),
            },
            (code, _) => format!("body {code}"),
        }
    }

    /// The spans for which `source` (`None`: any source) has the target, TDB seconds past J2000, in their order and with gaps between them. A catalog's orbit
    /// about a parent counts as covered by every source, because it is used whichever source is requested.
    fn coverage(&self, target: NaifId, source: Option<Source>) -> Vec<(f64, f64)> {
        let mut spans = Vec::new();
        if source.is_none_or(|s| s == Source::Kernel) {
            spans.extend(self.kernels.iter().flat_map(|k| k.spans(target.0)));
        }
        if source.is_none_or(|s| s == Source::Series) {
            let (first_s, last_s) = span_s(SERIES_YEARS);
            spans.extend(self.series.coverage(target.0).map(|(start_s, end_s)| (start_s.max(first_s), end_s.min(last_s))));
        }
        if source.is_none_or(|s| s == Source::Mean) && mean_elements::origin_of(target.0).is_some() {
            spans.push(span_s(MEAN_ELEMENTS_YEARS));
        }
        if self.orbits.get(&target).is_some_and(|o| o.motion != Motion::Planetary) {
            spans.push(span_s(ORBIT_YEARS));
        }
        joined(spans)
    }

    /// The error that `source` (`None`: any source) has no state of the target at `t`.
    pub(super) fn error_without_theory(&self, target: NaifId, t: Instant, source: Option<Source>) -> EphemerisError {
        let body = self.name_of(target);
        let sources = match source {
            None => message!("error-of-sources"),
            Some(Source::Kernel) => message!("error-of-kernel"),
            Some(Source::Series) => message!("error-of-series"),
            Some(Source::Mean) => message!("error-of-mean-elements"),
        };
        let spans = self.coverage(target, source);
        let Some(((first, _), (_, last))) = spans.first().copied().zip(spans.last().copied()) else {
            return EphemerisError(message!("error-no-place", sources = sources, body = &body));
        };
        let advice = match source {
            Some(Source::Kernel) => message!("error-longer-than-kernel"),
            _ => message!("error-longer-kernel"),
        };
        let [first, last, time] = [end_text(first, t), end_text(last, t), t.to_utc_iso()].map(Argument::Time);
        let tdb_s = t.tdb_seconds_past_j2000();
        let mut gaps = spans.windows(2).map(|pair| (pair[0].1, pair[1].0));
        EphemerisError(match gaps.find(|(start, end)| (*start..*end).contains(&tdb_s)) {
            None => {
                message!("error-time-outside", sources = sources, body = &body, first = first, last = last, time = time, other = advice)
            }
            Some((start, end)) => {
                let [until, again] = [end_text(start, t), end_text(end, t)].map(Argument::Time);
                message!(
                    "error-time-in-gap",
                    sources = sources,
                    body = &body,
                    first = first,
                    last = last,
                    until = until,
                    again = again,
                    time = time,
                    other = advice
                )
            }
        })
    }

    /// The fields of a catalog's bodies that no theory supports at any time.
    pub fn unsupported_fields(&self, catalog: &Catalog) -> Vec<UnsupportedField> {
        let mut fields = Vec::new();
        // The PCK has the rotation of a body at every time or at none.
        let any_time_s = 0.0;
        for body in catalog.bodies() {
            let mut add = |field, why: String| fields.push(UnsupportedField { body: body.id, field, why });
            if let Some((field, why)) = self.unsupported_motion(body.id, &body.motion, body.parent) {
                add(field, why);
            }
            match body.rotation {
                Rotation::Pck if self.pck.pole_and_meridian(body.id, any_time_s).is_none() => add(
                    "rotation",
                    format!(
                        "model = \"pck\", and the PCK has no rotation of body {}: write model = \"fixed\" with pole_ra_deg, pole_dec_deg, w0_deg and \
                         w_deg_day, or model = \"synchronous\" for a moon that keeps one face to its parent",
                        body.id.0
                    ),
                ),
                Rotation::Synchronous if body.parent.is_none() => add(
                    "rotation",
                    "model = \"synchronous\", and the body has no parent to turn its face to: write model = \"fixed\" with pole_ra_deg, \
                     pole_dec_deg, w0_deg and w_deg_day"
                        .into(),
                ),
                _ => {}
            }
        }
        fields
    }

    /// The catalog field and the reason, if no theory supports the motion.
    fn unsupported_motion(&self, id: NaifId, motion: &Motion, parent: Option<NaifId>) -> Option<(&'static str, String)> {
        // Whether kernels or series lead from a body to the solar system's barycentre, without the catalog's orbits.
        let has_own_source = |id: NaifId| is_centre_from_moons(id) || self.in_kernels_or_series(id);
        if *motion == Motion::Planetary {
            return (!has_own_source(id)).then(|| {
                let why = "theory = \"planetary\", and neither a kernel nor a series has body";
                (
                    "motion",
                    format!("{why} {}: name an SPK that has it by --kernel, or write theory = \"mean-elements\" with its orbit", id.0),
                )
            });
        }
        if parent.is_none() && !has_own_source(id) {
            return Some(("parent", "is missing: the motion is relative to it".into()));
        }
        let mut current = id;
        for links_so_far in 0..MAX_CHAIN_LINKS {
            if has_own_source(current) {
                if links_so_far + links_to_barycentre(current) <= MAX_CHAIN_LINKS {
                    return None;
                }
                break;
            }
            match self.orbits.get(&current) {
                // A parent without a theory is reported separately.
                None => return None,
                Some(orbit) if orbit.motion == Motion::Planetary => return None,
                Some(orbit) => current = orbit.parent,
            }
        }
        // The chain is too long. It cannot be a cycle, because the catalog's reader refuses cycles.
        Some((
            "parent",
            format!(
                "is too far down a chain of parents: write one from which at most {} steps lead to the solar system's barycentre",
                MAX_CHAIN_LINKS - 1
            ),
        ))
    }

    /// Whether a kernel or a series has the body. The series have the same targets as the mean elements.
    fn in_kernels_or_series(&self, id: NaifId) -> bool {
        mean_elements::origin_of(id.0).is_some() || self.kernels.iter().any(|k| k.coverage(id.0).is_some())
    }
}
