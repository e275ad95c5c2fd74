//! The tables that ring shaders read: the light that the rings remove from a path or scatter into it, and its integrals over the radius, for a range of slants.
//!
//! In: rings in catalog order (a later ring replaces earlier rings where they overlap); for the ring's own draws [`RingConditions`], for a shadow the slants of
//! sunlight. Out: [`RingTable`], plain f32 texels; their meaning and the interpolation error between rows are documented in shaders/lib/ring. Always: radii
//! increase, integrals never decrease.

use crate::catalog::Ring;
use crate::memo::{Memo, NumbersKey};
use crate::scene::camera::narrow_scalar;
use crate::scene::constants::{MIN_COSINE, RING_BIN_ROWS, RING_HEADER_ROWS, RING_ROWS_PER_SLANT, RING_SLANTS_PER_OCTAVE, SUN_STRIPS};
use crate::scene::draw::tables::RingTable;
use crate::scene::rings::single_scatter::scattered;
use std::sync::Arc;

/// Maximum number of slants in a ring's table; the slants are 2^(k/8), k = 0..=96.
pub(crate) use crate::scene::constants::RING_SLANTS as SLANTS;
/// Maximum number of nodes in a table, the edges of its intervals: half of the widest texture that every GPU supports.
pub(crate) const MAX_NODES: usize = 4096;

/// An interval of radius, from `inner` to `outer` equatorial radii, with constant optical depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingInterval {
    pub inner: f64,
    pub outer: f64,
    /// Optical depth along the normal.
    pub tau: f64,
    /// Effective single-scattering albedo (it includes multiple scattering), linear RGB.
    pub albedo: [f64; 3],
    /// Fraction of the scattered light that comes from dust.
    pub dust_fraction: f64,
}

impl RingInterval {
    /// Fraction of light removed along a path of a slant (1 / cosine of the angle between path and normal).
    fn removed_fraction(&self, slant: f64) -> f64 {
        -(-self.tau * slant).exp_m1()
    }

    /// Whether any light comes from dust.
    fn has_dust(&self) -> bool {
        self.tau > 0.0 && self.dust_fraction > 0.0
    }
}

/// Cuts overlapping rings into intervals, each with the properties of the last ring that contains it. `unit_km`: the body's equatorial radius.
pub(crate) fn intervals<'a>(rings: impl Iterator<Item = &'a Ring> + Clone, unit_km: f64) -> Vec<RingInterval> {
    let mut edges: Vec<f64> = rings.clone().flat_map(|r| [r.inner_km, r.outer_km]).collect();
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let interval_between = |pair: &[f64]| {
        let middle = (pair[0] + pair[1]) / 2.0;
        let top_ring = rings.clone().filter(|r| r.inner_km <= middle && middle < r.outer_km).last();
        let (tau, albedo, dust_fraction) = top_ring.map_or((0.0, [0.0; 3], 0.0), |r| (r.tau_normal, r.albedo, r.dust_fraction));
        RingInterval { inner: pair[0] / unit_km, outer: pair[1] / unit_km, tau, albedo, dust_fraction }
    };
    edges.windows(2).map(interval_between).collect()
}

/// The properties of a ring that a table depends on, as a cache key.
pub(crate) fn cache_key(ring: &Ring) -> [f64; 7] {
    let [red, green, blue] = ring.albedo;
    [ring.inner_km, ring.outer_km, ring.tau_normal, ring.dust_fraction, red, green, blue]
}

/// Number of cached tables of each kind: enough for the rings in a frame (the light meter reads the dense and the faint rings apart) and in the other variant of
/// the Compare panel. A table of Saturn's rings takes up to a megabyte.
const CACHE_CAPACITY: usize = 8;

/// Tables of rings, cached from frame to frame.
#[derive(Debug)]
pub(crate) struct RingTables {
    intervals: Memo<NumbersKey, Arc<Vec<RingInterval>>>,
    profiles: Memo<NumbersKey, Option<Arc<RingTable>>>,
    shadows: Memo<NumbersKey, Option<Arc<RingTable>>>,
}

impl Default for RingTables {
    fn default() -> Self {
        Self {
            intervals: Memo::with_capacity(CACHE_CAPACITY),
            profiles: Memo::with_capacity(CACHE_CAPACITY),
            shadows: Memo::with_capacity(CACHE_CAPACITY),
        }
    }
}

impl RingTables {
    /// [`intervals`] of all rings of a body, cached: computing those of Saturn takes a millisecond.
    pub fn intervals<'a>(&self, rings: impl Iterator<Item = &'a Ring> + Clone, unit_km: f64) -> Arc<Vec<RingInterval>> {
        let key = std::iter::once(unit_km).chain(rings.clone().flat_map(cache_key)).collect();
        self.intervals.get(key, || Arc::new(intervals(rings, unit_km)))
    }

    /// [`RingTable::of`] for some rings of a body, cached.
    pub(crate) fn profile(&self, rings: &[&Ring], unit_km: f64, conditions: &RingConditions) -> Option<Arc<RingTable>> {
        let sunlight = conditions.sunlight.iter().flatten().flatten().copied();
        let inputs = std::iter::once(unit_km).chain(conditions.slant_indices.map(f64::from)).chain(sunlight);
        let key = inputs.chain(rings.iter().flat_map(|r| cache_key(r))).collect();
        let intervals = || self.intervals(rings.iter().copied(), unit_km);
        self.profiles.get(key, || RingTable::of_intervals(&intervals(), conditions).map(Arc::new))
    }

    /// [`RingTable::of_shadow`] for some rings of a body, cached.
    pub(crate) fn shadow(&self, rings: &[&Ring], unit_km: f64, slants: &[f64]) -> Option<Arc<RingTable>> {
        let key = std::iter::once(unit_km).chain(slants.iter().copied()).chain(rings.iter().flat_map(|r| cache_key(r))).collect();
        let intervals = || self.intervals(rings.iter().copied(), unit_km);
        self.shadows.get(key, || RingTable::of_shadow_intervals(&intervals(), slants).map(Arc::new))
    }
}

/// Slants of sunlight (1 / sine of its angle to the ring's plane) for the rows of a shadow's table. `sine`: sine of the elevation of the Sun's centre
/// over the plane; `tangent`: tangent of the Sun's angular radius; `is_disc_resolved`: false if the Sun counts as a point, which has a single slant.
///
/// One slant is enough if the slant varies little across the disc. The criterion: for either half of the disc, the fraction of light that an interval removes
/// differs by at most 0.004 from the fraction for the slant of the centre. To first order the difference is at most 0.156 `tangent` / `sine`, where 0.156 is
/// the product of 4 / (3 pi), the distance of a half's centroid from the centre in radii of the disc, and 1 / e, the steepest change of the fraction with the
/// logarithm of the slant. In a test at `ONE_SLANT_MIN_ELEVATION_SUN_RADII` it is below 0.158 `tangent` / `sine`. For a lower Sun the slant of the centre is
/// followed by one slant for each strip of the disc, at the nodes of a Gauss-Chebyshev rule (shaders/lib/ring/shadow.wesl).
pub fn slants_of_sunlight(sine: f64, tangent: f64, is_disc_resolved: bool) -> Vec<f64> {
    let slant = |sine: f64| 1.0 / sine.abs().max(MIN_COSINE);
    if !is_disc_resolved || sine.abs() > ONE_SLANT_MIN_ELEVATION_SUN_RADII * tangent {
        return vec![slant(sine)];
    }
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let of_strip = |k: usize| {
        let offset = (k as f64 * std::f64::consts::PI / (SUN_STRIPS + 1) as f64).cos() * tangent;
        // Sine of the elevation of the point `offset` above the disc's centre (in distances of the Sun).
        slant((sine + cosine * offset) / offset.hypot(1.0))
    };
    std::iter::once(slant(sine)).chain((1..=SUN_STRIPS).map(of_strip)).collect()
}

/// Elevation of the Sun over the plane, in angular radii of the Sun, from which one slant is enough: 0.158 / 40 is less than 0.004.
const ONE_SLANT_MIN_ELEVATION_SUN_RADII: f64 = 40.0;
/// Fraction of its width by which a bin is extended inwards: more than the shader's f32 error in computing the bin.
const BIN_MARGIN: f64 = 0.01;

/// An index that maps a radius to its interval; shaders/lib/ring/intervals.wesl reads it.
struct RadiusBins {
    texels: Vec<f32>,
    /// The bin of a radius is `formula[0] - formula[1] / radius`, clamped to 0..=`formula[2]` and rounded down.
    formula: [f64; 3],
}

impl RadiusBins {
    /// The index of intervals sorted from the innermost outwards, for a table with one more column than there are intervals.
    fn of(intervals: &[RingInterval]) -> Self {
        let outer = intervals.last().map_or(1.0, |s| s.outer);
        // Not 0, so that a ring that reaches the centre has bins of a finite width in 1 / radius.
        let inner = intervals.first().map_or(1.0, |s| s.inner).max(1e-3 * outer);
        let columns = intervals.len() + 1;
        let count = RING_BIN_ROWS as usize * columns;
        // Bins are even steps of 1 / radius, counted outwards from the inner edge.
        let bins_per_inverse_radius = count as f64 / (1.0 / inner - 1.0 / outer);
        let at_inner = bins_per_inverse_radius / inner;
        let outer_radii: Vec<f32> = outer_radii(intervals).collect();
        let texel = |bin: usize| {
            let radius = bins_per_inverse_radius / (at_inner - (bin as f64 - BIN_MARGIN));
            let interval = if bin == 0 { 0 } else { intervals.partition_point(|s| s.outer <= radius).min(intervals.len() - 1) };
            // The texel holds the index of the interval in which the bin begins, and the outer radii of this interval and of the next two.
            let outer_radius = |k: usize| outer_radii.get(interval + k).copied().unwrap_or(f32::MAX);
            [narrow_scalar(interval as f64), outer_radius(0), outer_radius(1), outer_radius(2)]
        };
        // Consecutive bins lie in one column, in consecutive rows.
        let rows = RING_BIN_ROWS as usize;
        let texels = (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row)).flat_map(texel);
        Self { texels: texels.collect(), formula: [at_inner, bins_per_inverse_radius, count as f64 - 1.0] }
    }
}

/// Outer radii of the intervals; for the last interval `f32::MAX`, so that a search by radius ends there.
fn outer_radii(intervals: &[RingInterval]) -> impl Iterator<Item = f32> {
    let last = intervals.len().saturating_sub(1);
    intervals.iter().enumerate().map(move |(k, s)| if k == last { f32::MAX } else { narrow_scalar(s.outer) })
}

/// Innermost and outermost radius of the intervals; `None` if there are none or too many for a table.
fn radial_range(intervals: &[RingInterval]) -> Option<[f64; 2]> {
    let radius_range = [intervals.first()?.inner, intervals.last()?.outer];
    (intervals.len() < MAX_NODES).then_some(radius_range)
}

/// The sunlight on a ring and the range of slants of the view rays that cross the ring; all pixels share both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingConditions {
    /// Fractions of the Sun's disc on the viewer's side of the plane and on the other, each with its mean |sin(elevation)|; see
    /// [`sun_disc_parts`](super::ring_shine::sun_disc_parts). `None` for the pixel view of albedo.
    pub sunlight: Option<[[f64; 2]; 2]>,
    /// Indices (k of [`SLANTS`]) of the first and the last slant of the table's rows.
    slant_indices: [u32; 2],
}

impl RingConditions {
    /// `steepest` and `flattest`: smallest and largest slant of the view rays.
    pub fn new(sunlight: Option<[[f64; 2]; 2]>, steepest: f64, flattest: f64) -> Self {
        let slant_position = |slant: f64| slant.clamp(1.0, 1.0 / MIN_COSINE).log2() * f64::from(RING_SLANTS_PER_OCTAVE);
        // At least two slants, between which shaders interpolate.
        let first = (slant_position(steepest).floor() as u32).min(SLANTS - 2);
        Self { sunlight, slant_indices: [first, (slant_position(flattest).ceil() as u32).clamp(first + 1, SLANTS - 1)] }
    }

    /// Light that an interval scatters into a path of a slant, without the factors albedo and (phase function / 4); for the pixel view of albedo, the fraction
    /// of light that the interval removes.
    pub(super) fn light(&self, interval: &RingInterval, slant: f64) -> f64 {
        let Some(sunlight) = self.sunlight else { return interval.removed_fraction(slant) };
        // Part 0 is the one on the viewer's side.
        let light_of_part = |(part, [fraction, sine]): (usize, [f64; 2])| {
            if fraction > 0.0 { fraction * scattered(interval.tau, slant, 1.0 / sine.max(MIN_COSINE), part == 0) } else { 0.0 }
        };
        sunlight.into_iter().enumerate().map(light_of_part).sum()
    }
}

impl RingTable {
    /// The table for the draws of a ring. `None` without a ring, or with more than [`MAX_NODES`] nodes. `unit_km`: the body's equatorial radius.
    pub fn of<'a>(rings: impl Iterator<Item = &'a Ring> + Clone, unit_km: f64, conditions: &RingConditions) -> Option<Self> {
        Self::of_intervals(&intervals(rings, unit_km), conditions)
    }

    fn of_intervals(intervals: &[RingInterval], conditions: &RingConditions) -> Option<Self> {
        let radius_range = radial_range(intervals)?;
        let nodes = intervals.len() + 1;
        let [first, last] = conditions.slant_indices;
        let height = RING_HEADER_ROWS + RING_ROWS_PER_SLANT * (last - first + 1);
        let bins = RadiusBins::of(intervals);
        let mut texels = bins.texels;
        texels.reserve(nodes * height as usize * 4);
        let mut dusty_count = 0.0;
        for (interval, outer_radius) in intervals.iter().zip(outer_radii(intervals)) {
            // The number of dusty intervals farther in, plus one half if this one is dusty: tells shaders whether any interval of a range is dusty.
            let dust_code = dusty_count + if interval.has_dust() { 0.5 } else { 0.0 };
            dusty_count += if interval.has_dust() { 1.0 } else { 0.0 };
            texels.extend([narrow_scalar(interval.inner), outer_radius, dust_code, 0.0]);
        }
        texels.extend([narrow_scalar(radius_range[1]), f32::MAX, dusty_count, 0.0]);
        for k in first..=last {
            let slant = (f64::from(k) / f64::from(RING_SLANTS_PER_OCTAVE)).exp2();
            // Dust has rows of its own, because it has another phase function. Besides, its sums would lose precision if added to those of dense rings.
            // For each kind (0: large particles, 1: dust) the row of the intervals' values, then the row of the integrals from the innermost radius. The rows
            // of large particles contain the fraction removed by both kinds.
            let mut rows = [const { Vec::new() }; RING_ROWS_PER_SLANT as usize];
            let mut sums = [[0.0; 4]; 2];
            for interval in intervals {
                let light = conditions.light(interval, slant);
                let [red, green, blue] = interval.albedo.map(|albedo| light * albedo);
                let large = [red, green, blue].map(|v| v * (1.0 - interval.dust_fraction));
                let dust = [red, green, blue].map(|v| v * interval.dust_fraction);
                let values_of_kinds = [[large[0], large[1], large[2], interval.removed_fraction(slant)], [dust[0], dust[1], dust[2], 0.0]];
                for (kind, values) in values_of_kinds.into_iter().enumerate() {
                    rows[2 * kind].extend(values.map(narrow_scalar));
                    rows[2 * kind + 1].extend(sums[kind].map(narrow_scalar));
                    for (sum, value) in sums[kind].iter_mut().zip(values) {
                        *sum += (interval.outer - interval.inner) * value;
                    }
                }
            }
            for (kind, sum) in sums.into_iter().enumerate() {
                rows[2 * kind].extend([0.0; 4]);
                rows[2 * kind + 1].extend(sum.map(narrow_scalar));
            }
            rows.iter_mut().for_each(|row| texels.append(row));
        }
        Some(Self { width: nodes as u32, height, texels, radius_range, bins: bins.formula, slants: conditions.slant_indices })
    }

    /// The table for the draw of a globe in the rings' shadow, for the slants of sunlight of [`slants_of_sunlight`]. `None` as in
    /// [`RingTable::of`].
    pub fn of_shadow<'a>(rings: impl Iterator<Item = &'a Ring> + Clone, unit_km: f64, slants: &[f64]) -> Option<Self> {
        Self::of_shadow_intervals(&intervals(rings, unit_km), slants)
    }

    /// Texels after the bins: inner and outer radius, removed fraction, and its integral up to the inner radius; one row per slant.
    fn of_shadow_intervals(intervals: &[RingInterval], slants: &[f64]) -> Option<Self> {
        let radius_range = radial_range(intervals)?;
        let nodes = intervals.len() + 1;
        let bins = RadiusBins::of(intervals);
        let mut texels = bins.texels;
        for slant in slants {
            let mut sum = 0.0;
            for (interval, outer_radius) in intervals.iter().zip(outer_radii(intervals)) {
                let removed_fraction = interval.removed_fraction(*slant);
                texels.extend([narrow_scalar(interval.inner), outer_radius, narrow_scalar(removed_fraction), narrow_scalar(sum)]);
                sum += (interval.outer - interval.inner) * removed_fraction;
            }
            texels.extend([narrow_scalar(radius_range[1]), f32::MAX, 0.0, narrow_scalar(sum)]);
        }
        Some(Self {
            width: nodes as u32,
            height: slants.len() as u32 + RING_BIN_ROWS,
            texels,
            radius_range,
            bins: bins.formula,
            // Not used: only a ring's own table has rows for a range of slants.
            slants: [0, 1],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(inner_km: f64, outer_km: f64, tau_normal: f64) -> Ring {
        Ring { name: "x".into(), inner_km, outer_km, tau_normal, albedo: [0.5, 0.25, 0.125], dust_fraction: 0.0 }
    }

    /// The radii of the tests' rings are in equatorial radii.
    const UNIT_KM: f64 = 1.0;
    /// The conditions of the albedo view, with rows for every slant.
    const ALBEDO_VIEW: RingConditions = RingConditions { sunlight: None, slant_indices: [0, SLANTS - 1] };

    #[test]
    fn a_later_ring_lies_over_an_earlier_one() {
        let cut = intervals([ring(1.0, 4.0, 1.0), ring(2.0, 3.0, 0.0)].iter(), UNIT_KM);
        let taus: Vec<_> = cut.iter().map(|s| (s.inner, s.outer, s.tau)).collect();
        assert_eq!(taus, [(1.0, 2.0, 1.0), (2.0, 3.0, 0.0), (3.0, 4.0, 1.0)]);
    }

    #[test]
    fn rows_contain_the_removed_light_and_its_integral() {
        let table = RingTable::of([ring(1.0, 2.0, 0.7), ring(2.5, 3.0, 3.0)].iter(), UNIT_KM, &ALBEDO_VIEW).expect("a table");
        assert_eq!((table.width, table.height, table.radius_range), (4, RING_HEADER_ROWS + RING_ROWS_PER_SLANT * SLANTS, [1.0, 3.0]));
        // The table has four nodes, and a texel four channels.
        let at = |row: u32, node: usize, channel: usize| f64::from(table.texels[(row as usize * 4 + node) * 4 + channel]);
        for k in 0..SLANTS {
            let (value, integral) = (RING_HEADER_ROWS + RING_ROWS_PER_SLANT * k, RING_HEADER_ROWS + 1 + RING_ROWS_PER_SLANT * k);
            // Eight slants per octave.
            let slant = (f64::from(k) / 8.0).exp2();
            let [first, last] = [0.7, 3.0].map(|tau: f64| 1.0 - (-tau * slant).exp());
            assert!((at(value, 0, 3) - first).abs() < 1e-6 && (at(value, 0, 0) - 0.5 * first).abs() < 1e-6, "slant {k}");
            assert!((at(integral, 1, 3) - first).abs() < 1e-6 && (at(integral, 1, 0) - 0.5 * first).abs() < 1e-6, "slant {k}");
            assert_eq!((at(value, 1, 3), at(integral, 2, 3)), (0.0, at(integral, 1, 3)), "a gap adds nothing");
            assert!((at(integral, 3, 3) - first - 0.5 * last).abs() < 1e-6, "slant {k}");
        }
        assert!(RingTable::of([].iter(), UNIT_KM, &ALBEDO_VIEW).is_none());
    }

    /// At the lowest Sun for which one slant is used, the mean of the removed light over each half of the disc differs little from that for the centre's slant,
    /// for optical depths around the worst.
    #[test]
    fn both_halves_of_the_sun_lose_the_light_of_the_centres_slant() {
        const TANGENT: f64 = 5e-4;
        let is_disc_resolved = true;
        let slant_count = |sun_radii: f64| slants_of_sunlight(sun_radii * TANGENT, TANGENT, is_disc_resolved).len();
        assert_eq!(slant_count(1.01 * ONE_SLANT_MIN_ELEVATION_SUN_RADII), 1);
        assert_eq!(slant_count(0.99 * ONE_SLANT_MIN_ELEVATION_SUN_RADII), 1 + SUN_STRIPS);
        let largest_difference = |elevation_in_sun_radii: f64| {
            let sine = elevation_in_sun_radii * TANGENT;
            let difference = |depth_along_slant: f64, side: f64| {
                let removed = |sine_of_strip: f64| -(-depth_along_slant * sine / sine_of_strip).exp_m1();
                let strips =
                    (0..1000).map(|k| (f64::from(k) + 0.5) / 1000.0).map(|y| ((1.0 - y * y).sqrt(), removed(sine + side * y * TANGENT)));
                let (area, light) = strips.fold((0.0, 0.0), |(area, light), (width, removed)| (area + width, light + width * removed));
                (light / area - removed(sine)).abs()
            };
            let depths = (1..60).map(|k| 0.05 * f64::from(k));
            depths.flat_map(|depth| [difference(depth, 1.0), difference(depth, -1.0)]).fold(0.0, f64::max)
        };
        let lowest = largest_difference(ONE_SLANT_MIN_ELEVATION_SUN_RADII);
        assert!(
            lowest < 0.158 / ONE_SLANT_MIN_ELEVATION_SUN_RADII && lowest > 0.155 / ONE_SLANT_MIN_ELEVATION_SUN_RADII && lowest < 0.004,
            "{lowest}"
        );
        // Negative control: for a Sun half as high, one slant is wrong by more than the 0.004 that the criterion allows.
        assert!(largest_difference(0.5 * ONE_SLANT_MIN_ELEVATION_SUN_RADII) > 0.004);
    }

    /// Repeats the shader's search for the interval of a radius in f32: a bin never begins past that interval, and the search needs few reads.
    #[test]
    fn a_bin_begins_at_or_before_the_interval_of_its_radii() {
        let catalog = crate::catalog::Catalog::embedded();
        for body in catalog.bodies().iter().filter(|b| !b.rings.is_empty()) {
            let intervals = intervals(body.rings.iter(), body.radii_km.x);
            let bins = RadiusBins::of(&intervals);
            let [at_inner, bins_per_inverse_radius, last] = bins.formula.map(narrow_scalar);
            let (from, to) = (intervals[0].inner, intervals[intervals.len() - 1].outer);
            // Reads of further intervals, after that of the bin.
            let (mut extra_reads, mut max_extra_reads) = (0, 0);
            const SAMPLES: usize = 100_000;
            for k in 0..SAMPLES {
                // Most samples are near the inner edge.
                let radius = narrow_scalar(from + (to - from) * (k as f64 / SAMPLES as f64).powi(3));
                let bin = (at_inner - bins_per_inverse_radius / radius).clamp(0.0, last) as usize;
                let rows = RING_BIN_ROWS as usize;
                let texel = &bins.texels[((bin % rows) * (intervals.len() + 1) + bin / rows) * 4..][..4];
                let first = texel[0] as usize + texel[1..].iter().filter(|end| **end <= radius).count();
                let expected = intervals.partition_point(|s| narrow_scalar(s.outer) <= radius).min(intervals.len() - 1);
                assert!(first <= expected, "{}, {radius}: bin {bin} begins in interval {first}, past {expected}", body.name);
                extra_reads += expected - first;
                max_extra_reads = max_extra_reads.max(expected - first);
            }
            assert!(
                extra_reads < SAMPLES / 100 && max_extra_reads <= 5,
                "{}: {extra_reads} reads more for {SAMPLES} places, {max_extra_reads} at most",
                body.name
            );
        }
    }

    /// The light of a faint dusty ring outside a dense ring is precise to five digits.
    #[test]
    fn dust_is_summed_apart_from_large_particles() {
        let faint = Ring { dust_fraction: 0.8, ..ring(4.0, 5.0, 1e-6) };
        let table = RingTable::of([ring(1.0, 2.0, 3.0), faint].iter(), UNIT_KM, &ALBEDO_VIEW).expect("a table");
        // The table has four nodes, and a texel four channels.
        let at = |row: u32, node: usize, channel: usize| f64::from(table.texels[(row as usize * 4 + node) * 4 + channel]);
        let (large, dust) = (RING_HEADER_ROWS + 1, RING_HEADER_ROWS + 3);
        assert_eq!([0, 3].map(|c| at(dust, 2, c)), [0.0; 2], "no dust inside the faint ring");
        // Expected: red albedo, times the dust's or large particles' fraction, times the removed fraction 1e-6, over a width of 1.
        let light = at(dust, 3, 0) - at(dust, 2, 0);
        assert!((light / (0.5 * 0.8e-6) - 1.0).abs() < 1e-5, "{light}");
        let in_dense_sum = at(large, 3, 0) - at(large, 2, 0);
        assert!((in_dense_sum / (0.5 * 0.2e-6) - 1.0).abs() > 1e-3, "the sum with a dense ring loses precision: {in_dense_sum}");
    }
}
