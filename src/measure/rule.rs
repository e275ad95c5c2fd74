//! The rule that determines which options of a choice are dominated, and which are admissible for a quality level (`draft`, `standard` or
//! `reference`). A *choice* is a setting, such as the number of samples per pixel; its values are its *options*.
//!
//! In: time and error of the options of one choice. Out: the dominated options, and those admissible for a quality. Always: an option is
//! dominated only by an option that is clearly faster and not clearly less accurate, or clearly more accurate at no greater median time.
//! Clearly faster: the interquartile ranges of the times do not overlap, and the medians differ by more than 5 %. Clearly more accurate: the error is
//! smaller by more than 1 %. An option is admissible if it is within the quality's bound and no other option within the bound is clearly faster; `reference`
//! has no bound: of the most accurate options, those are admissible than which no other is clearly faster.

use super::timing::Quartiles;
use crate::scene::request::Quality;

/// The unit of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ErrorUnit {
    /// Angle on the sky.
    Arcseconds,
    /// Percent of a pixel's radiance or of the image's summed light, depending on the choice.
    PercentOfLight,
    /// The 99.9th percentile over pixels of the error on the display, in levels: 1/255 of the display's range.
    Levels,
}

impl ErrorUnit {
    /// The name in tables and plots.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Arcseconds => "arcsec",
            Self::PercentOfLight => "% of light",
            Self::Levels => "255ths",
        }
    }

    /// Upper limit of a quality's error. `None`: the most accurate option must be used.
    ///
    /// `draft` is for exploring:
    /// - A good eye resolves 60 arcsec, and 4 arcsec at a magnification of 15; the bound is a quarter of the latter.
    /// - 15.9 % of light is a quarter of a stop: 1 - 2^(-1/4).
    /// - 32 levels are an eighth of white; one pixel of a thousand may exceed them.
    ///
    /// `standard` is for the window and for saved images:
    /// - The Moon moves 0.1 arcsec in 0.2 s, so the time of a contact of an eclipse is off by at most 0.2 s.
    /// - Half a percent of light is a third of a level at mid grey.
    /// - Three levels are 1 % of the display's range.
    pub(crate) fn bound(self, quality: Quality) -> Option<f64> {
        let [draft, standard] = match self {
            Self::Arcseconds => [1.0, 0.1],
            Self::PercentOfLight => [15.9, 0.5],
            Self::Levels => [32.0, 3.0],
        };
        match quality {
            Quality::Draft => Some(draft),
            Quality::Standard => Some(standard),
            Quality::Reference => None,
        }
    }
}

/// Error and time of an option.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measurement {
    /// Error in the choice's unit, at least 0.
    pub error: f64,
    /// Quartiles of the ratio of the option's time to that of the choice's most accurate option.
    pub relative_time: Quartiles,
}

impl Measurement {
    /// Whether `self` takes less time: the interquartile ranges do not overlap, and the medians differ by more than 5 %, because less does not justify a
    /// change.
    fn is_clearly_faster(&self, other: &Self) -> bool {
        self.relative_time.high < other.relative_time.low && self.relative_time.median < 0.95 * other.relative_time.median
    }

    /// Whether the error is smaller by more than 1 %.
    fn is_clearly_more_accurate(&self, other: &Self) -> bool {
        self.error < 0.99 * other.error
    }

    /// Whether `self` is clearly faster than `other` and not clearly less accurate, or clearly more accurate at no greater median time.
    pub(crate) fn dominates(&self, other: &Self) -> bool {
        let (is_faster, is_more_accurate) = (self.is_clearly_faster(other), self.is_clearly_more_accurate(other));
        is_faster && !other.is_clearly_more_accurate(self) || is_more_accurate && self.relative_time.median <= other.relative_time.median
    }
}

/// For each option, whether another one dominates it.
pub(crate) fn dominated(options: &[Measurement]) -> Vec<bool> {
    options.iter().map(|a| options.iter().any(|b| b.dominates(a))).collect()
}

/// For each option, whether it is admissible for a quality: it is eligible, and no other eligible option is clearly faster. Eligible are the options that
/// meet the bound; for `reference`, or if none meets it, the options within 1 % of the smallest error.
pub(crate) fn admissible(quality: Quality, unit: ErrorUnit, options: &[Measurement]) -> Vec<bool> {
    let bound = unit.bound(quality).filter(|bound| options.iter().any(|o| o.error <= *bound));
    let is_eligible = |o: &Measurement| match bound {
        Some(bound) => o.error <= bound,
        None => !options.iter().any(|other| other.is_clearly_more_accurate(o)),
    };
    options.iter().map(|o| is_eligible(o) && !options.iter().any(|other| is_eligible(other) && other.is_clearly_faster(o))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An option with this median of the relative time, and quartiles 5 % below and above it.
    fn option(error: f64, median: f64) -> Measurement {
        Measurement { error, relative_time: Quartiles { low: 0.95 * median, median, high: 1.05 * median } }
    }

    #[test]
    fn slower_and_no_more_accurate_options_are_dominated() {
        let options = [option(8.0, 0.2), option(4.0, 0.5), option(5.0, 0.7), option(0.0, 1.0), option(0.0, 2.0)];
        assert_eq!(dominated(&options), [false, false, true, false, true]);
        // Times within the spread: equally accurate options both stay.
        assert_eq!(dominated(&[option(1.0, 1.0), option(1.0, 1.03)]), [false, false]);
        // A clearly more accurate option dominates if its median time is not greater, by however little it is faster; an error smaller by 0.1 % is not enough.
        assert_eq!(dominated(&[option(1.0, 1.03), option(0.5, 1.0)]), [true, false]);
        assert_eq!(dominated(&[option(1.0, 1.03), option(0.999, 1.0)]), [false, false]);
    }

    #[test]
    fn a_quality_takes_the_fastest_option_within_its_bound() {
        let unit = ErrorUnit::Levels;
        let [draft, standard] = [Quality::Draft, Quality::Standard].map(|q| unit.bound(q).expect("a bound"));
        let options = [option(2.0 * draft, 0.1), option(0.9 * draft, 0.2), option(0.9 * standard, 0.5), option(0.5, 1.0)];
        // The indices of the admissible options for draft, standard and reference.
        let by_quality = |options: &[Measurement]| {
            Quality::ALL.map(|q| admissible(q, unit, options).iter().enumerate().filter_map(|(k, ok)| ok.then_some(k)).collect::<Vec<_>>())
        };
        assert_eq!(by_quality(&options), [[1], [2], [3]]);
        let mut changed = options;
        changed[2].error = 1.1 * standard;
        assert_eq!(by_quality(&changed), [[1], [3], [3]], "option 2 exceeds the bound of standard");
        changed[3].relative_time = option(0.0, 0.15).relative_time;
        assert_eq!(by_quality(&changed), [[3], [3], [3]], "option 3 is the fastest within the bound of draft, too");
        // If the measurement cannot distinguish two options, both are admissible.
        assert_eq!(by_quality(&[option(0.5, 1.0), option(0.5, 1.02)]), [[0, 1], [0, 1], [0, 1]]);
        // An option that meets no bound is admissible if none is more accurate.
        assert_eq!(by_quality(&[option(1e9, 1.0)]), [[0], [0], [0]]);
    }
}
