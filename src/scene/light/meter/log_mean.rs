//! The mean radiance of a subject of the light meter.
//!
//! In: the parts of a subject, each with its share of the frame and its radiance. Out: a [`MeteredSubject`], and the parts for `highlights`. Always: the mean
//! is finite, whatever the parts are.

use super::MeteredSubject;
use super::ground::GroundRadiance;
use super::highlights::{Highlights, Part};
use super::weights::{contrast_weight, radiance_weight};
use crate::catalog::NaifId;
use crate::message::Argument;

/// Accumulates a weighted mean of the logarithm of radiance.
#[derive(Clone, Default)]
pub(super) struct LogMean {
    pub weight: f64,
    /// Sum of weight times the logarithm of radiance.
    pub log_sum: f64,
    /// Sum of weight times the logarithm of the part of the radiance that images show.
    drawn_part_log_sum: f64,
    /// The parts that may be highlights.
    pub highlights: Highlights,
}

impl LogMean {
    /// Adds a part of a subject. `share`: the part's share of the frame, times other weights. `foreground_radiance`: radiance of the light added in front of
    /// the part, which lowers its contrast.
    pub fn add(&mut self, share: f64, radiance: f64, foreground_radiance: f64) {
        self.add_ground(share, GroundRadiance::as_drawn(radiance), foreground_radiance);
    }

    /// The same for ground.
    pub fn add_ground(&mut self, share: f64, radiance: GroundRadiance, foreground_radiance: f64) {
        if self.add_to_mean(share, radiance, foreground_radiance) {
            self.highlights.add(Part::of(share, radiance, foreground_radiance));
        }
    }

    /// The same for a part that is no highlight, however bright: a body drawn as a point, or a rim of air, which is mostly lower than a pixel.
    pub fn add_outside_highlights(&mut self, share: f64, radiance: f64, foreground_radiance: f64) {
        self.add_ground_outside_highlights(share, GroundRadiance::as_drawn(radiance), foreground_radiance);
    }

    /// The same for the ground of a small disc.
    pub fn add_ground_outside_highlights(&mut self, share: f64, radiance: GroundRadiance, foreground_radiance: f64) {
        if self.add_to_mean(share, radiance, foreground_radiance) {
            self.highlights.add(Part::of(share, radiance, foreground_radiance).without_highlight());
        }
    }

    /// Adds a part to the mean alone. Returns whether it counts.
    pub fn add_to_mean(
        &mut self,
        share: f64,
        GroundRadiance { metered: radiance, drawn }: GroundRadiance,
        foreground_radiance: f64,
    ) -> bool {
        if !(share > 0.0 && radiance > 0.0) {
            return false;
        }
        let weight = share * radiance_weight(radiance) * contrast_weight(radiance, foreground_radiance);
        let log = weight * radiance.ln();
        // An infinite radiance or a foreground that is not a number would spoil the exposure of the entire frame.
        if !log.is_finite() {
            return false;
        }
        self.weight += weight;
        self.log_sum += log;
        self.drawn_part_log_sum += weight * (drawn / radiance).ln();
        true
    }

    /// Weight of a part of a subject that fills the frame; 0 if the part does not count. `foreground_radiance`: see [`Self::add`].
    pub fn weight_of_full_frame(radiance: f64, foreground_radiance: f64) -> f64 {
        let (mut mean, entire_frame) = (Self::default(), 1.0);
        mean.add_to_mean(entire_frame, GroundRadiance::as_drawn(radiance), foreground_radiance);
        mean.weight
    }

    /// The same mean with its weight multiplied.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            weight: self.weight * factor,
            log_sum: self.log_sum * factor,
            drawn_part_log_sum: self.drawn_part_log_sum * factor,
            highlights: self.highlights.times(factor),
        }
    }

    /// Adds the parts of another mean.
    pub fn merge(&mut self, other: &Self) {
        self.weight += other.weight;
        self.log_sum += other.log_sum;
        self.drawn_part_log_sum += other.drawn_part_log_sum;
        self.highlights.merge(&other.highlights);
    }

    /// The mean radiance; not a number if no part counts.
    pub fn radiance(&self) -> f64 {
        (self.log_sum / self.weight).exp()
    }

    /// The mean as a subject; `None` if no part counts. `target_level`: see [`MeteredSubject`].
    pub fn metered(&self, name: impl Into<Argument>, body: Option<NaifId>, target_level: f64) -> Option<MeteredSubject> {
        let radiance = self.radiance();
        (self.weight > 0.0 && radiance > 0.0).then(|| MeteredSubject {
            name: name.into(),
            body,
            radiance,
            target_level,
            weight: self.weight,
            drawn_part: (self.drawn_part_log_sum / self.weight).exp(),
            is_of_bodies: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_without_a_finite_radiance_does_not_count() {
        let mut mean = LogMean::default();
        let (share, no_foreground) = (0.1, 0.0);
        mean.add(share, 0.25, no_foreground);
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for number in numbers {
            mean.add(number, 1.0, no_foreground);
            mean.add(share, number, no_foreground);
            mean.add(share, 1.0, number);
            mean.add(share, number, number);
        }
        let (name, no_body, target_level) = ("", None, 0.5);
        let metered = mean.metered(name, no_body, target_level).expect("a subject");
        assert!((metered.radiance - 0.25).abs() < 1e-12 && metered.weight.is_finite(), "{metered:?}");
        // Parts with a finite radiance do count.
        mean.add(share, 1.0, no_foreground);
        assert!(mean.metered(name, no_body, target_level).expect("a subject").radiance > 0.26);
    }
}
