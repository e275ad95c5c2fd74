//! The light that rings scatter towards a viewer, integrated over the radius, so that the light meter need not visit every interval of the rings for each of
//! its rays.
//!
//! In: the intervals of a body's rings and the Sun's light on them. Out: mean light between two radii, of large particles and of dust, without the
//! factor (phase function / 4). A path's slant is 1 / cosine of its angle to the rings' normal: 1 along the normal, larger for flatter paths. Always: exact in
//! radius. Between the tabulated slants the light is linear in the slant's logarithm, as in the ring's table (shaders/lib/ring/profile.wesl); the error is
//! under 3e-4 of the sunlight (test below). A slant's sums are computed when a ray first needs them, outwards as far as rays need them. They do not depend on
//! the camera: [`RadialSumsCache`] keeps them while time stands still.

use super::ring_table::{RingConditions, RingInterval, SLANTS};
use crate::memo::Memo;
use crate::scene::constants::RING_SLANTS_PER_OCTAVE;
use parking_lot::Mutex;
use std::sync::Arc;

/// Light scattered by large particles (index 0) and by dust (index 1), in the channel with the greatest albedo, without the factor (phase function / 4).
type ByParticle = [f64; 2];

/// The light along paths of one slant, of the innermost intervals.
#[derive(Debug)]
struct SlantSums {
    slant: f64,
    /// Light of each interval.
    light: Vec<ByParticle>,
    /// Integral of the light over the radius up to each interval's inner edge; the last element is the integral over all these intervals.
    integral: Vec<ByParticle>,
}

impl SlantSums {
    fn new(slant: f64) -> Self {
        Self { slant, light: Vec::new(), integral: vec![[0.0; 2]] }
    }

    /// Extends the sums up to and including the interval of an index.
    fn extend_to(&mut self, intervals: &[RingInterval], conditions: &RingConditions, index: usize) {
        for interval in intervals.iter().take(index + 1).skip(self.light.len()) {
            let albedo = interval.albedo.iter().copied().fold(0.0, f64::max);
            let light = if interval.tau > 0.0 { albedo * conditions.light(interval, self.slant) } else { 0.0 };
            let light = [light * (1.0 - interval.dust_fraction), light * interval.dust_fraction];
            let sum = self.integral[self.light.len()];
            self.integral.push([0, 1].map(|particle| sum[particle] + (interval.outer - interval.inner) * light[particle]));
            self.light.push(light);
        }
    }

    /// The integral of the light up to a radius. `index`: index of the interval that contains the radius; 0 for a radius below all intervals, and the number of
    /// intervals for a radius above all of them. The sums must extend to that index.
    fn integral_to(&self, intervals: &[RingInterval], radius: f64, index: usize) -> ByParticle {
        let Some(interval) = intervals.get(index) else { return self.integral[intervals.len()] };
        let within = (radius - interval.inner).max(0.0);
        [0, 1].map(|particle| self.integral[index][particle] + within * self.light[index][particle])
    }
}

/// Integrals over the radius, interpolated between the slants of the table.
#[derive(Debug)]
pub(crate) struct RadialSums {
    intervals: Arc<Vec<RingInterval>>,
    conditions: RingConditions,
    /// The sums for each slant of the table; `None` until a ray needs them.
    by_slant: Vec<Option<SlantSums>>,
}

impl RadialSums {
    /// `sunlight`: for the parts of the Sun's disc on the viewer's side of the ring plane and on the other, the fraction of the disc and the mean
    /// of |sin(elevation)|.
    fn new(intervals: Arc<Vec<RingInterval>>, sunlight: [[f64; 2]; 2]) -> Self {
        let by_slant = (0..SLANTS).map(|_| None).collect();
        // Only a table's rows depend on the range of slants; `RingConditions::light` ignores it.
        Self { intervals, conditions: RingConditions::new(Some(sunlight), 1.0, 1.0), by_slant }
    }

    /// Mean light between two radii along paths of one slant.
    pub(crate) fn mean(&mut self, [from, to]: [f64; 2], slant: f64) -> ByParticle {
        let slant_position = (slant.log2() * f64::from(RING_SLANTS_PER_OCTAVE)).clamp(0.0, f64::from(SLANTS - 1));
        let lower_index = (slant_position as usize).min(SLANTS as usize - 2);
        let upper_weight = slant_position - lower_index as f64;
        let interval_at = |radius: f64| self.intervals.partition_point(|interval| interval.outer <= radius);
        let ends = [(from, interval_at(from)), (to, interval_at(to))];
        let [lower_mean, upper_mean] = [lower_index, lower_index + 1].map(|slant_index| {
            let slant = (slant_index as f64 / f64::from(RING_SLANTS_PER_OCTAVE)).exp2();
            let sums = self.by_slant[slant_index].get_or_insert_with(|| SlantSums::new(slant));
            sums.extend_to(&self.intervals, &self.conditions, ends[1].1);
            let [inner_integral, outer_integral] = ends.map(|(radius, interval)| sums.integral_to(&self.intervals, radius, interval));
            [0, 1].map(|particle| (outer_integral[particle] - inner_integral[particle]) / (to - from))
        });
        [0, 1].map(|particle| lower_mean[particle] + upper_weight * (upper_mean[particle] - lower_mean[particle]))
    }
}

/// Number of cached sums: those of the dense and of the faint rings of one planet on either side of them, for both variants of the Compare panel. Those of
/// Saturn take up to 3 MB.
const CACHE_CAPACITY: usize = 8;

/// What [`RadialSums`] depend on: the intervals, as [`super::ring_table::RingTables`] has them, and the sunlight.
type Inputs = (Arc<Vec<RingInterval>>, [[f64; 2]; 2]);

/// Sums, cached from frame to frame.
#[derive(Debug)]
pub(crate) struct RadialSumsCache(Memo<Inputs, Arc<Mutex<RadialSums>>>);

impl Default for RadialSumsCache {
    fn default() -> Self {
        Self(Memo::with_capacity(CACHE_CAPACITY))
    }
}

impl RadialSumsCache {
    /// The sums of these intervals under this sunlight: see [`RadialSums::new`].
    pub(crate) fn of(&self, intervals: &Arc<Vec<RingInterval>>, sunlight: [[f64; 2]; 2]) -> Arc<Mutex<RadialSums>> {
        let is_same = |cached: &Inputs, requested: &Inputs| Arc::ptr_eq(&cached.0, &requested.0) && cached.1 == requested.1;
        let compute = || Arc::new(Mutex::new(RadialSums::new(Arc::clone(intervals), sunlight)));
        self.0.get_compatible(is_same, (Arc::clone(intervals), sunlight), compute)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::scene::rings::ring_table::intervals;
    use crate::scene::rings::single_scatter::{scattered, sun_disc_parts};

    /// Tangent of the Sun's angular radius as seen from Saturn.
    const SUN_TANGENT: f64 = 4.8e-4;

    /// Reference for the mean light: single scattering, evaluated for every overlapping interval at the exact slant.
    fn one_by_one(intervals: &[RingInterval], sunlight: [[f64; 2]; 2], [from, to]: [f64; 2], slant: f64) -> ByParticle {
        let mut mean = [0.0; 2];
        for interval in intervals.iter().filter(|interval| interval.tau > 0.0) {
            let overlap = (interval.outer.min(to) - interval.inner.max(from)).max(0.0) / (to - from);
            let light: f64 = (0..2)
                .filter(|side| sunlight[*side][0] > 0.0)
                .map(|side| sunlight[side][0] * scattered(interval.tau, slant, 1.0 / sunlight[side][1], side == 0))
                .sum();
            let light = overlap * light * interval.albedo.iter().copied().fold(0.0, f64::max);
            mean[0] += light * (1.0 - interval.dust_fraction);
            mean[1] += light * interval.dust_fraction;
        }
        mean
    }

    /// Greatest difference from the reference over radii, widths and slants of a body's rings. `slant_factor`: the slant of the sums divided by that of the
    /// reference.
    fn greatest_difference(name: &str, slant_factor: f64) -> f64 {
        let catalog = Catalog::embedded();
        let body = catalog.body_named(name).expect("a body");
        let intervals = Arc::new(intervals(body.rings.iter(), body.radii_km.x));
        let (inner, outer) = (intervals[0].inner, intervals[intervals.len() - 1].outer);
        let mut greatest: f64 = 0.0;
        for sin_elevation in [0.45, 0.02] {
            let [centre_side, other_side] = sun_disc_parts(sin_elevation, SUN_TANGENT);
            for sunlight in [[centre_side, other_side], [other_side, centre_side]] {
                let mut sums = RadialSums::new(Arc::clone(&intervals), sunlight);
                for k in 0..400 {
                    // Additive low-discrepancy sequences.
                    let quasi_random = |increment: f64| (f64::from(k) * increment).fract();
                    let middle = inner - 0.1 + (outer - inner + 0.2) * quasi_random(0.618_034);
                    let half_width = 0.5 * (-13.0 * quasi_random(0.754_878)).exp2();
                    let slant = (7.0 * quasi_random(0.819_173)).exp2();
                    let between = [middle - half_width, middle + half_width];
                    let (mean, exact) = (sums.mean(between, slant * slant_factor), one_by_one(&intervals, sunlight, between, slant));
                    greatest = (0..2).fold(greatest, |max, particle| max.max((mean[particle] - exact[particle]).abs()));
                }
            }
        }
        greatest
    }

    #[test]
    fn means_are_those_of_every_interval_one_by_one() {
        let same_slant = 1.0;
        for name in ["jupiter", "saturn", "uranus", "neptune"] {
            let greatest = greatest_difference(name, same_slant);
            assert!(greatest < 3e-4, "{name}: {greatest}");
        }
        // Sums that were extended step by step are those that were computed at once.
        let catalog = Catalog::embedded();
        let saturn = catalog.body_named("saturn").expect("a body");
        let intervals = Arc::new(intervals(saturn.rings.iter(), saturn.radii_km.x));
        let sunlight = sun_disc_parts(0.45, SUN_TANGENT);
        let ranges = [[1.0, 1.3], [1.2, 1.25], [1.5, 1.9], [0.5, 1.0], [1.9, 2.2], [2.0, 9.0]];
        let mut step_by_step = RadialSums::new(Arc::clone(&intervals), sunlight);
        let at_once = ranges.map(|range| {
            let mut sums = RadialSums::new(Arc::clone(&intervals), sunlight);
            sums.mean([1.0, 9.0], 3.0);
            sums.mean(range, 3.0)
        });
        assert_eq!(ranges.map(|range| step_by_step.mean(range, 3.0)), at_once);
        assert!(at_once[2][0] > 0.0 && at_once[3] == [0.0; 2], "{at_once:?}");
        // The cache has them for the same Sun, and others for another.
        let cache = RadialSumsCache::default();
        let first = cache.of(&intervals, sunlight);
        let of_first = ranges.map(|range| first.lock().mean(range, 3.0));
        assert!(of_first == at_once && Arc::ptr_eq(&first, &cache.of(&intervals, sunlight)));
        let of_other = cache.of(&intervals, sun_disc_parts(0.4, SUN_TANGENT)).lock().mean(ranges[2], 3.0);
        assert!(of_other != at_once[2], "{of_other:?}");
        // Negative control: with slants smaller by a tenth, the light differs by more than ten times the tolerance.
        assert!(greatest_difference("saturn", 0.9) > 3e-3);
    }
}
