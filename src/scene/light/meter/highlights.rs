//! The highlights of the bodies in the frame: the brightest tenth of their ground and rings.
//!
//! In: the parts of all metered bodies, each with its area and radiance. Out: the radiance of the highlights, by which automatic exposure is limited. Always:
//! continuous in areas and radiances: the mean over a band of quantiles, not one quantile, which would jump where a bright part outgrows it. Not among the
//! parts: the Sun, its corona and the sky. Rims of air and bodies drawn as points are parts, but no highlights.

use super::ground::GroundRadiance;
use super::weights::{RADIANCE_WEIGHT_EXPONENT, contrast_weight};

/// A part of a body in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its share of the frame, times the weights of its position and of its contrast.
    pub area: f64,
    /// Its radiance as it counts for the mean.
    pub metered: f64,
    /// As images show it.
    pub drawn: f64,
    /// Whether it may be a highlight. Other parts, such as points and rims of air, take their share of the area, so that the highlights of a disc that becomes
    /// a point fade.
    pub may_be_highlight: bool,
}

impl Part {
    /// `share`: of the frame, times other weights. `foreground_radiance`: of the light in front of the part.
    pub(super) fn of(share: f64, radiance: GroundRadiance, foreground_radiance: f64) -> Self {
        let area = share * contrast_weight(radiance.metered, foreground_radiance);
        Self { area, metered: radiance.metered, drawn: radiance.drawn, may_be_highlight: true }
    }

    /// The same part as one that is no highlight, however bright.
    pub(super) fn without_highlight(self) -> Self {
        Self { may_be_highlight: false, ..self }
    }
}

/// The band of areas, counted from the brightest, whose mean radiance is that of the highlights. The hundredth before is left to glints and the like.
const HIGHLIGHT_BAND: [f64; 2] = [0.01, 0.1];

/// The parts among which the highlights are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Highlights(Vec<Part>);

impl Highlights {
    pub(super) fn add(&mut self, part: Part) {
        if part.area > 0.0 && part.drawn > 0.0 && part.drawn.is_finite() {
            self.0.push(part);
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.0.extend_from_slice(&other.0);
    }

    /// The same parts with their areas multiplied.
    pub(super) fn times(&self, factor: f64) -> Self {
        Self(self.0.iter().filter(|_| factor > 0.0).map(|part| Part { area: part.area * factor, ..*part }).collect())
    }

    /// The radiance of the highlights: the geometric mean over the band. `None` without parts. `exposed_radiance`: the mean for which the image is exposed;
    /// darker parts count less, as for that mean, so that the night side does not belong to the area of which the highlights are a tenth.
    pub(crate) fn radiance(&self, exposed_radiance: f64) -> Option<f64> {
        let weight = |part: &Part| part.area * (part.metered / exposed_radiance).min(1.0).powf(RADIANCE_WEIGHT_EXPONENT);
        let counted = |part: &Part| if part.may_be_highlight { part.drawn } else { part.drawn.min(exposed_radiance) };
        let mut by_brightness: Vec<(f64, f64)> = self.0.iter().map(|part| (counted(part), weight(part))).collect();
        by_brightness.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let total: f64 = by_brightness.iter().map(|(_, weight)| weight).sum();
        let [from, to] = HIGHLIGHT_BAND.map(|part| part * total);
        let (mut brighter, mut log_sum) = (0.0, 0.0);
        for (radiance, weight) in by_brightness {
            log_sum += ((brighter + weight).min(to) - to.min(from.max(brighter))).max(0.0) * radiance.ln();
            brighter += weight;
        }
        (total > 0.0).then(|| (log_sum / (to - from)).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn highlights(parts: &[(f64, f64)]) -> Highlights {
        let mut all = Highlights::default();
        parts
            .iter()
            .for_each(|(area, radiance)| all.add(Part { area: *area, metered: *radiance, drawn: *radiance, may_be_highlight: true }));
        all
    }

    /// Of even ground the highlights have its radiance. Bright ground counts fully from a tenth of the area on, and with half of its logarithm where it is half
    /// of the band. A glint of a hundredth does not count, nor does any amount of ground that is much darker than the mean.
    #[test]
    fn the_highlights_are_the_brightest_tenth() {
        let of = |parts: &[(f64, f64)]| highlights(parts).radiance(1.0).expect("parts");
        for (parts, expected) in [
            (&[(0.2, 0.7), (0.3, 0.7)][..], 0.7),
            (&[(0.9, 1.0), (0.1, 4.0)][..], 4.0),
            (&[(0.945, 1.0), (0.055, 4.0)][..], 2.0),
            (&[(0.99, 1.0), (0.01, 1e5)][..], 1.0),
            (&[(0.9, 1.0), (0.1, 4.0), (1e3, 1e-12)][..], 4.0),
        ] {
            assert!((of(parts) / expected - 1.0).abs() < 1e-3, "{parts:?}: {}, not {expected}", of(parts));
        }
        assert!(highlights(&[]).radiance(1.0).is_none());
    }

    /// A lit part that grows from nothing, on ground 10,000 times as dark, raises the highlights in small steps.
    #[test]
    fn a_growing_bright_part_raises_the_highlights_gradually() {
        let stops: Vec<f64> = (0..=400)
            .map(|k| f64::from(k) * 5e-4)
            .map(|area| highlights(&[(1.0 - area, 1e-4), (area, 1.0)]).radiance(1e-4).expect("parts").log2())
            .collect();
        assert!(stops[0] < -13.0 && stops[400] > -0.01, "{stops:?}");
        // 13.3 stops over an area of 0.09.
        assert!(stops.windows(2).all(|w| w[1] >= w[0] - 1e-9 && w[1] - w[0] < 0.1), "{stops:?}");
    }
}
