//! Speed against accuracy: what each choice costs, and how far off it is.
//!
//! In: a session, and how long it may take. Out: [`ChoiceMeasure`]s: for each option of each choice its error in a unit that a person feels and its time as a
//! ratio to that of the choice's most accurate option. Always: times are ratios of runs in turns ([`timing`]), errors are taken against the best that the program
//! can do (f64, 64 samples a pixel, 16 taps on a footprint, the dearest model); which option each quality takes is read from the program, which one it should
//! take is computed by [`rule`]. Not done: tessellation, for ellipsoids are intersected and not tessellated.

mod drawings;
mod pictures;
pub mod plot;
mod positions;
pub mod rule;
pub mod timing;
mod view;
mod whole;

pub use pictures::{LightPicture, levels_apart, p999};
pub use view::{ENOUGH_LEVELS, ViewMeasure, measure_view};
pub use whole::renderer;

use crate::scene::request::Quality;
use crate::session::{Session, SessionError};
use rule::{Unit, Weight};
use timing::{Spread, in_turns, seconds_of};

/// How long a measurement may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// About a minute on two cores.
    Short,
    /// Larger pictures and more rounds: some minutes.
    Full,
}

impl Effort {
    /// Sides of the pictures, pixels.
    pub fn side_px(self) -> u32 {
        match self {
            Self::Short => 128,
            Self::Full => 384,
        }
    }

    /// Rounds in which all options take turns.
    pub fn rounds(self) -> usize {
        match self {
            Self::Short => 9,
            Self::Full => 21,
        }
    }
}

/// One option of a choice, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionMeasure {
    /// As the command line or the documents name it.
    pub name: String,
    /// Error and time.
    pub weight: Weight,
    /// Whether another option is better in both.
    pub is_dominated: bool,
    /// The qualities that take it, by the program as it is.
    pub default_of: Vec<Quality>,
    /// The qualities that should take it, by [`rule::option_of`].
    pub default_by_rule: Vec<Quality>,
}

/// A choice and its options, in the order of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceMeasure {
    /// What is chosen.
    pub name: &'static str,
    /// What the error is of, and in which view.
    pub about: &'static str,
    /// Of the errors.
    pub unit: Unit,
    /// What was measured of each.
    pub options: Vec<OptionMeasure>,
}

impl ChoiceMeasure {
    /// Qualities whose default is not what the rule says, with the option that it names.
    pub fn broken_defaults(&self) -> Vec<(Quality, &str)> {
        let by_rule = |o: &OptionMeasure, q: Quality| o.default_by_rule.contains(&q) && !o.default_of.contains(&q);
        let of = |q: Quality| self.options.iter().find(|o| by_rule(o, q)).map(|o| (q, o.name.as_str()));
        Quality::ALL.into_iter().filter(|q| self.options.iter().any(|o| o.default_of.contains(q))).filter_map(of).collect()
    }
}

/// An option before it is timed.
pub(crate) struct Candidate<'a> {
    name: String,
    error: f64,
    default_of: Vec<Quality>,
    work: Box<dyn Fn() -> Result<(), SessionError> + 'a>,
}

/// Times the candidates in turns and applies the rule; ratios are to the last candidate whose error is the least.
pub(crate) fn weighed(
    name: &'static str,
    about: &'static str,
    unit: Unit,
    rounds: usize,
    candidates: Vec<Candidate<'_>>,
) -> Result<ChoiceMeasure, SessionError> {
    let times = {
        let timed = candidates.iter().map(|c| move || seconds_of(|| (c.work)()));
        let works: Vec<Box<timing::Work<'_, f64, SessionError>>> = timed.map(|w| Box::new(w) as Box<_>).collect();
        let works: Vec<&timing::Work<'_, f64, SessionError>> = works.iter().map(|w| &**w).collect();
        // Modules, maps and tables are there before anything counts.
        in_turns(1, &works)?;
        in_turns(rounds, &works)?
    };
    let least = candidates.iter().map(|c| c.error).fold(f64::INFINITY, f64::min);
    let reference = candidates.iter().rposition(|c| c.error <= least).unwrap_or(0);
    let one = Spread { low: 1.0, median: 1.0, high: 1.0 };
    let weights: Vec<Weight> = candidates
        .iter()
        .enumerate()
        .map(|(k, c)| Weight { error: c.error, time: Spread::of_ratios(&times[k], &times[reference]).unwrap_or(one) })
        .collect();
    let dominated = rule::dominated(&weights);
    let by_rule = Quality::ALL.map(|q| (q, rule::option_of(q, unit, &weights)));
    let options = candidates
        .into_iter()
        .enumerate()
        .map(|(k, c)| OptionMeasure {
            name: c.name,
            weight: weights[k],
            is_dominated: dominated[k],
            default_of: c.default_of,
            default_by_rule: by_rule.iter().filter(|(_, option)| *option == Some(k)).map(|(q, _)| *q).collect(),
        })
        .collect();
    Ok(ChoiceMeasure { name, about, unit, options })
}

/// Measures one choice.
pub type MeasureChoice = fn(&Session, Effort) -> Result<ChoiceMeasure, SessionError>;

/// Every choice that trades, by name, in the order of a frame: positions, light, shapes, sampling, the whole.
pub const CHOICES: [(&str, MeasureChoice); 13] = [
    ("ephemeris", positions::ephemeris_source),
    ("light-time", positions::light_time),
    ("eclipse", drawings::eclipse_model),
    ("ring-shadow", drawings::ring_shadow),
    ("body-shadow", drawings::body_shadow),
    ("air", drawings::air_tier),
    ("shape", drawings::shape),
    ("map-taps", drawings::map_taps),
    ("samples", drawings::samples),
    ("resolution", drawings::resolution),
    ("precision", drawings::precision),
    ("stars", whole::stars),
    ("quality", whole::quality),
];
