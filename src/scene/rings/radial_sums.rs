//! The light that rings scatter towards a viewer, integrated over the radius, so that the light meter need not visit each ringlet for each of its rays.
//!
//! In: the intervals of a body's rings and the Sun's light on them. Out: mean light between two radii, of large particles and of dust, without their phase
//! functions. Always: exact in radius. Between slopes of the path it is linear in log x, as in the ring's table (shaders/lib/ring/profile.wesl), whose
//! error it shares: at most 2.9e-4 of the sunlight. A slope's sums are computed when a ray first needs them.

use super::ring_table::{RingConditions, RingInterval, SLOPES};
use crate::scene::constants::RING_SLOPES_PER_OCTAVE;

/// Light of large particles and of dust, times the greatest albedo of the channels.
type ByParticle = [f64; 2];

/// The light along paths of one slope.
struct SlopeSums {
    /// Of each interval.
    light: Vec<ByParticle>,
    /// Its integral over the radius up to each interval's inner edge, and at the end up to the outermost edge.
    integral: Vec<ByParticle>,
}

impl SlopeSums {
    fn new(intervals: &[RingInterval], conditions: &RingConditions, slope: f64) -> Self {
        let light = intervals.iter().map(|interval| {
            let albedo = interval.albedo.iter().copied().fold(0.0, f64::max);
            let light = if interval.tau > 0.0 { albedo * conditions.light(interval, slope) } else { 0.0 };
            [light * (1.0 - interval.dust), light * interval.dust]
        });
        let light: Vec<ByParticle> = light.collect();
        let mut sum = [0.0; 2];
        let mut integral = vec![sum];
        for (interval, light) in intervals.iter().zip(&light) {
            sum = [0, 1].map(|k| sum[k] + (interval.to - interval.from) * light[k]);
            integral.push(sum);
        }
        Self { light, integral }
    }

    /// The integral up to a radius, which lies in interval number `k` or inside of it.
    fn up_to(&self, intervals: &[RingInterval], radius: f64, k: usize) -> ByParticle {
        let Some(interval) = intervals.get(k) else { return self.integral[intervals.len()] };
        let within = (radius - interval.from).max(0.0);
        [0, 1].map(|p| self.integral[k][p] + within * self.light[k][p])
    }
}

/// Integrals for any slope.
pub(crate) struct RadialSums<'a> {
    intervals: &'a [RingInterval],
    conditions: RingConditions,
    of_slope: Vec<Option<SlopeSums>>,
}

impl<'a> RadialSums<'a> {
    /// `sunlight`: fractions of the Sun's disc on the viewer's side of the plane and on the other, each with its mean sine.
    pub(crate) fn new(intervals: &'a [RingInterval], sunlight: [[f64; 2]; 2]) -> Self {
        let of_slope = (0..SLOPES).map(|_| None).collect();
        Self { intervals, conditions: RingConditions::new(Some(sunlight), 1.0, 1.0), of_slope }
    }

    /// Mean light between two radii along paths of slope `x` (1 / cosine to the normal).
    pub(crate) fn mean(&mut self, [from, to]: [f64; 2], x: f64) -> ByParticle {
        let place = (x.log2() * f64::from(RING_SLOPES_PER_OCTAVE)).clamp(0.0, f64::from(SLOPES - 1));
        let below = (place as usize).min(SLOPES as usize - 2);
        let upper = place - below as f64;
        let interval_at = |radius: f64| self.intervals.partition_point(|interval| interval.to <= radius);
        let ends = [(from, interval_at(from)), (to, interval_at(to))];
        let [lower_mean, upper_mean] = [below, below + 1].map(|k| {
            let slope = (k as f64 / f64::from(RING_SLOPES_PER_OCTAVE)).exp2();
            let sums = self.of_slope[k].get_or_insert_with(|| SlopeSums::new(self.intervals, &self.conditions, slope));
            let [inner, outer] = ends.map(|(radius, interval)| sums.up_to(self.intervals, radius, interval));
            [0, 1].map(|p| (outer[p] - inner[p]) / (to - from))
        });
        [0, 1].map(|p| lower_mean[p] + upper * (upper_mean[p] - lower_mean[p]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::scene::rings::ring_table::intervals;
    use crate::scene::rings::single_scatter::{scattered, sun_halves};

    /// The mean light from every interval, each by its own single scattering.
    fn one_by_one(intervals: &[RingInterval], sunlight: [[f64; 2]; 2], [from, to]: [f64; 2], x: f64) -> ByParticle {
        let mut mean = [0.0; 2];
        for interval in intervals.iter().filter(|interval| interval.tau > 0.0) {
            let overlap = (interval.to.min(to) - interval.from.max(from)).max(0.0) / (to - from);
            let light: f64 = (0..2)
                .filter(|half| sunlight[*half][0] > 0.0)
                .map(|half| sunlight[half][0] * scattered(interval.tau, x, 1.0 / sunlight[half][1], half == 0))
                .sum();
            let light = overlap * light * interval.albedo.iter().copied().fold(0.0, f64::max);
            mean[0] += light * (1.0 - interval.dust);
            mean[1] += light * interval.dust;
        }
        mean
    }

    /// Largest difference over radii, widths and slopes of a body's rings.
    fn difference(name: &str, wrong: f64) -> f64 {
        let catalog = Catalog::embedded();
        let body = catalog.body_named(name).expect("a body");
        let intervals = intervals(body.rings.iter(), body.radii_km.x);
        let (inner, outer) = (intervals[0].from, intervals[intervals.len() - 1].to);
        let mut largest: f64 = 0.0;
        for sine in [0.45, 0.02] {
            let [near, far] = sun_halves(sine, 4.8e-4);
            for sunlight in [[near, far], [far, near]] {
                let mut sums = RadialSums::new(&intervals, sunlight);
                for k in 0..400 {
                    let part = |step: f64| (f64::from(k) * step).fract();
                    let middle = inner - 0.1 + (outer - inner + 0.2) * part(0.618_034);
                    let half = 0.5 * (-13.0 * part(0.754_878)).exp2();
                    let x = (7.0 * part(0.819_173)).exp2();
                    let between = [middle - half, middle + half];
                    let (mean, exact) = (sums.mean(between, x * wrong), one_by_one(&intervals, sunlight, between, x));
                    largest = (0..2).fold(largest, |d, p| d.max((mean[p] - exact[p]).abs()));
                }
            }
        }
        largest
    }

    #[test]
    fn means_are_those_of_every_interval_one_by_one() {
        for name in ["jupiter", "saturn", "uranus", "neptune"] {
            let d = difference(name, 1.0);
            assert!(d < 3e-4, "{name}: {d}");
        }
        // The comparison must be able to fail: paths steeper by a tenth.
        assert!(difference("saturn", 0.9) > 3e-3);
    }
}
