//! Speed against accuracy. A choice is a setting, such as the number of samples per pixel; its values are its options. This module measures time and error of
//! each option.
//!
//! In: a session, and the time that the measurement may take. Out: `ChoiceMeasure`s: for each option its error (in arcseconds, percent of light or
//! display levels) and the ratio of its time to that of the choice's most accurate option. Always: times are ratios of alternating runs ([`timing`]). Errors
//! are relative to a reference, which for images is the most accurate option drawn in f64 (in f32 for `resolution`). [`rule`] determines the options that a
//! quality may use. The options that a quality does use are not listed here, but read from the scenes and settings that the program makes for it. Not measured:
//! tessellation, because ellipsoids are intersected and not tessellated.

mod complete_images;
mod drawings;
mod error_bound;
mod images;
pub mod plot;
mod positions;
pub mod rule;
pub mod timing;
mod view;

pub(crate) use complete_images::renderer;
pub(crate) use error_bound::{check_has_bounds, error_bounds};
pub(crate) use images::{LinearImage, PlannedView, PrecisionRenderers, SINGLE_SAMPLE, larger_or_nan, level_differences};
pub(crate) use timing::quantile;
pub(crate) use view::{SUFFICIENT_LEVELS, measure_view};

use crate::scene::request::Quality;
use crate::session::{Session, SessionError};
use rule::{ErrorUnit, Measurement};
use timing::{Quartiles, interleaved, seconds_of};

/// How long a measurement may take, which sets the size of the images and the number of rounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Within half a minute on two cores; all sweeps (series of views) of the command `stability` within two minutes.
    Short,
    /// Larger images and more rounds: several minutes.
    Full,
}

impl Effort {
    /// Width and height of the images, pixels.
    pub(crate) fn side_px(self) -> u32 {
        match self {
            Self::Short => 128,
            Self::Full => 384,
        }
    }

    /// Number of rounds. In each round every option is timed once.
    pub(crate) fn rounds(self) -> usize {
        match self {
            Self::Short => 15,
            Self::Full => 25,
        }
    }
}

/// The measurements of one option.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OptionMeasure {
    /// Name on the command line or in the documents.
    pub name: String,
    /// Error and time.
    pub measurement: Measurement,
    /// Whether another option dominates this one ([`rule::dominated`]).
    pub is_dominated: bool,
    /// The qualities that use this option in the program.
    pub default_of: Vec<Quality>,
    /// The qualities that may use this option by [`rule::admissible`].
    pub admissible_for: Vec<Quality>,
}

/// A choice and its options.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChoiceMeasure {
    /// Name of the choice.
    pub name: &'static str,
    /// A text: the quantity whose error is measured, and the view.
    pub about: &'static str,
    /// Unit of the errors.
    pub unit: ErrorUnit,
    /// Whether the rule does not apply; the reasons are given at `EXEMPT_FROM_RULE`.
    pub is_exempt_from_rule: bool,
    /// Measurements of the options.
    pub options: Vec<OptionMeasure>,
}

impl ChoiceMeasure {
    /// Qualities whose default option is inadmissible by the rule, each with an admissible option; qualities that have none are left out. Empty if the rule
    /// does not apply.
    pub(crate) fn defaults_to_change(&self) -> Vec<(Quality, &str)> {
        let has_inadmissible_default = |q: &Quality| self.options.iter().any(|o| o.default_of.contains(q) && !o.admissible_for.contains(q));
        let with_admissible_option = |q: Quality| self.options.iter().find(|o| o.admissible_for.contains(&q)).map(|o| (q, o.name.as_str()));
        Quality::ALL
            .into_iter()
            .filter(|q| !self.is_exempt_from_rule && has_inadmissible_default(q))
            .filter_map(with_admissible_option)
            .collect()
    }
}

/// An option before it is timed.
pub(crate) struct Candidate<'a> {
    name: String,
    /// Error of the option in the choice's unit.
    error: f64,
    /// The qualities that use this option in the program.
    default_of: Vec<Quality>,
    /// Draws or computes with the option once; this is what is timed.
    workload: Box<dyn Fn() -> Result<(), SessionError> + 'a>,
}

/// Times the candidates alternately and applies the rule. Times are ratios to that of the baseline: the last of the most accurate candidates. The baseline runs
/// twice in each round, and the ratio of these two times is its own: a measure of the noise. An error that is not a number counts as infinite.
pub(crate) fn measure_choice(
    name: &'static str,
    about: &'static str,
    unit: ErrorUnit,
    rounds: usize,
    mut candidates: Vec<Candidate<'_>>,
) -> Result<ChoiceMeasure, SessionError> {
    // Comparisons with NaN are false, so `rule::admissible` would find no option more accurate than one with this error, and could admit it for the quality
    // `reference`.
    for candidate in candidates.iter_mut().filter(|c| c.error.is_nan()) {
        candidate.error = f64::INFINITY;
    }
    let least_error = candidates.iter().map(|c| c.error).fold(f64::INFINITY, f64::min);
    let baseline = candidates.iter().rposition(|c| c.error <= least_error).unwrap_or(0);
    let mut times = {
        let timed = candidates.iter().map(|c| move || seconds_of(|| (c.workload)()));
        let workloads: Vec<Box<timing::Workload<'_, f64, SessionError>>> = timed.map(|w| Box::new(w) as Box<_>).collect();
        let workloads: Vec<&timing::Workload<'_, f64, SessionError>> =
            workloads.iter().chain(workloads.get(baseline)).map(|w| &**w).collect();
        // A first round, not timed, loads modules, maps and tables.
        interleaved(1, &workloads)?;
        interleaved(rounds, &workloads)?
    };
    let repeated_baseline = times.split_off(candidates.len());
    // For a baseline without any time above 0, to which no ratio exists.
    let equal_time = Quartiles { low: 1.0, median: 1.0, high: 1.0 };
    let measurements: Vec<Measurement> = candidates
        .iter()
        .enumerate()
        .map(|(k, c)| {
            let own_times = repeated_baseline.first().filter(|_| k == baseline).unwrap_or(&times[k]);
            Measurement { error: c.error, relative_time: Quartiles::of_ratios(own_times, &times[baseline]).unwrap_or(equal_time) }
        })
        .collect();
    let dominated = rule::dominated(&measurements);
    let admissible = Quality::ALL.map(|q| (q, rule::admissible(q, unit, &measurements)));
    let options = candidates
        .into_iter()
        .enumerate()
        .map(|(k, c)| OptionMeasure {
            name: c.name,
            measurement: measurements[k],
            is_dominated: dominated[k],
            default_of: c.default_of,
            admissible_for: admissible.iter().filter(|(_, is_admissible)| is_admissible[k]).map(|(q, _)| *q).collect(),
        })
        .collect();
    Ok(ChoiceMeasure { name, about, unit, is_exempt_from_rule: EXEMPT_FROM_RULE.contains(&name), options })
}

/// Choices to which the rule does not apply. For `ring-shadow`, `body-shadow` and `shape` the scene chooses the option from the view. `samples` is measured on
/// a shape model, the hard case. But nearly all views show none and need only one sample, so draft quality uses one in all views. The options of `quality` are
/// the qualities themselves.
const EXEMPT_FROM_RULE: [&str; 5] = ["ring-shadow", "body-shadow", "shape", "samples", "quality"];

/// A function that measures one choice.
pub(crate) type MeasureFn = fn(&Session, Effort) -> Result<ChoiceMeasure, SessionError>;

/// Every choice by name, except [`renderer`], which only a session with a GPU has. In the order in which a frame is made: positions, light, shapes, sampling,
/// the complete image.
pub(crate) const CHOICES: [(&str, MeasureFn); 14] = [
    ("ephemeris", positions::ephemeris_source),
    ("light-time", positions::direction_corrections),
    ("eclipse", drawings::eclipse_model),
    ("ring-shadow", drawings::ring_shadow),
    ("body-shadow", drawings::body_shadow),
    ("air", drawings::air_model),
    ("air-near", drawings::near_air_model),
    ("shape", drawings::shape),
    ("map-taps", drawings::map_taps),
    ("samples", drawings::samples),
    ("resolution", drawings::resolution),
    ("precision", drawings::precision),
    ("stars", complete_images::stars),
    ("quality", complete_images::quality),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// If a pixel of an image is not finite, the error of the image is not a number.
    #[test]
    fn an_error_that_is_not_a_number_is_infinite_and_no_quality_may_use_the_option() {
        let candidate =
            |name: &str, error: f64| Candidate { name: name.to_owned(), error, default_of: vec![], workload: Box::new(|| Ok(())) };
        let candidates = vec![candidate("broken", f64::NAN), candidate("intact", 1.0)];
        let measured = measure_choice("choice", "a test", ErrorUnit::Levels, 3, candidates).expect("measured");
        assert_eq!(measured.options[0].measurement.error, f64::INFINITY);
        let admissible_for: Vec<_> = measured.options.into_iter().map(|o| o.admissible_for).collect();
        assert_eq!(admissible_for, [vec![], Quality::ALL.to_vec()]);
    }
}
