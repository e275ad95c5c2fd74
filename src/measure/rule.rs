//! Which options are worth having, and which of them a quality takes: by rule.
//!
//! In: time and error of the options of one choice. Out: those that are dominated, and the option of each quality. Always: an option is dominated only by one
//! that is clearly cheaper at no greater error, or clearly more accurate at no greater time; what differs by less than the spread of the measurement decides
//! nothing. A quality takes the cheapest option within its bound; `reference` has no bound and takes the most accurate one.

use super::timing::Spread;
use crate::scene::request::Quality;

/// The unit of an error, as a person feels it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Angle on the sky.
    Arcseconds,
    /// Percent of the light that is there.
    PercentOfLight,
    /// Mean distance between two outlines, pixels.
    PixelsOfLimb,
    /// 255ths of a displayed channel that 99.9 % of all pixels keep within.
    Levels,
}

impl Unit {
    /// As tables and plots have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Arcseconds => "arcsec",
            Self::PercentOfLight => "% of light",
            Self::PixelsOfLimb => "px of limb",
            Self::Levels => "255ths",
        }
    }

    /// The greatest error that a quality may have; `None`: the least there is.
    ///
    /// `draft` is for looking around: an arcsecond is a quarter of what a good eye resolves in a telescope of 30x; 10 % of light is the least step that
    /// the eye tells between two pictures; a pixel of the outline; 64 levels in one pixel of a thousand is a jagged edge. `standard` is what the program
    /// shows and writes: a tenth of an arcsecond is 0.2 s of a contact with the Moon, half a percent is a level at mid grey, a quarter of a pixel is the
    /// project's bound for silhouettes.
    pub fn bound(self, quality: Quality) -> Option<f64> {
        let [draft, standard] = match self {
            Self::Arcseconds => [1.0, 0.1],
            Self::PercentOfLight => [10.0, 0.5],
            Self::PixelsOfLimb => [1.0, 0.25],
            Self::Levels => [64.0, 24.0],
        };
        match quality {
            Quality::Draft => Some(draft),
            Quality::Standard => Some(standard),
            Quality::Reference => None,
        }
    }
}

/// What the rule weighs of an option.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// In the choice's unit, at least 0.
    pub error: f64,
    /// Over the time of the choice's most accurate option.
    pub time: Spread,
}

impl Weight {
    fn is_clearly_cheaper(&self, than: &Self) -> bool {
        self.time.high < than.time.low
    }

    /// By more than a thousandth of the error.
    fn is_more_accurate(&self, than: &Self) -> bool {
        self.error < than.error * (1.0 - 1e-3)
    }

    /// Whether nobody would take the other one.
    pub fn dominates(&self, other: &Self) -> bool {
        let (cheaper, more_accurate) = (self.is_clearly_cheaper(other), self.is_more_accurate(other));
        cheaper && !other.is_more_accurate(self) || more_accurate && self.time.median <= other.time.median
    }
}

/// For each option whether another dominates it.
pub fn dominated(options: &[Weight]) -> Vec<bool> {
    options.iter().map(|a| options.iter().any(|b| b.dominates(a))).collect()
}

/// The option of a quality: the cheapest within the bound, of those that are equally cheap the most accurate; where none is within, and for
/// `reference`, the most accurate one, of equally accurate ones the cheapest. `None` without options.
pub fn option_of(quality: Quality, unit: Unit, options: &[Weight]) -> Option<usize> {
    let most_accurate = || {
        (0..options.len()).reduce(|best, k| {
            let (a, b) = (&options[best], &options[k]);
            let better = b.is_more_accurate(a) || !a.is_more_accurate(b) && b.is_clearly_cheaper(a);
            if better { k } else { best }
        })
    };
    let Some(bound) = unit.bound(quality) else { return most_accurate() };
    let within = (0..options.len()).filter(|k| options[*k].error <= bound);
    let cheapest = within.reduce(|best, k| {
        let (a, b) = (&options[best], &options[k]);
        let better = b.is_clearly_cheaper(a) || !a.is_clearly_cheaper(b) && b.error < a.error;
        if better { k } else { best }
    });
    cheapest.or_else(most_accurate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn option(error: f64, time: f64) -> Weight {
        Weight { error, time: Spread { low: 0.95 * time, median: time, high: 1.05 * time } }
    }

    #[test]
    fn what_is_dearer_and_no_better_is_dominated() {
        let options = [option(8.0, 0.2), option(4.0, 0.5), option(5.0, 0.7), option(0.0, 1.0), option(0.0, 2.0)];
        assert_eq!(dominated(&options), [false, false, true, false, true]);
        // Within the spread nothing is decided: equally good ones stay, and the better one drops the other.
        assert_eq!(dominated(&[option(1.0, 1.0), option(1.0, 1.03)]), [false, false]);
        assert_eq!(dominated(&[option(1.0, 1.03), option(0.5, 1.0)]), [true, false]);
    }

    #[test]
    fn a_quality_takes_the_cheapest_option_within_its_bound() {
        let unit = Unit::Levels;
        let [draft, standard] = [Quality::Draft, Quality::Standard].map(|q| unit.bound(q).expect("a bound"));
        let options = [option(2.0 * draft, 0.1), option(0.9 * draft, 0.2), option(0.9 * standard, 0.5), option(0.5, 1.0)];
        let chosen = |options: &[Weight]| Quality::ALL.map(|q| option_of(q, unit, options));
        assert_eq!(chosen(&options), [Some(1), Some(2), Some(3)]);
        // The rule says when a default no longer holds: an option gets worse, or another gets cheaper.
        let mut changed = options;
        changed[2].error = 1.1 * standard;
        assert_eq!(chosen(&changed), [Some(1), Some(3), Some(3)]);
        changed[3].time = option(0.0, 0.15).time;
        assert_eq!(chosen(&changed), [Some(3), Some(3), Some(3)]);
        assert_eq!(chosen(&[option(1e9, 1.0)]), [Some(0); 3]);
        assert_eq!(chosen(&[]), [None; 3]);
    }
}
