//! Computes, from the gradients of a lane's texture coordinates, the mip level and the taps that the lane reads.
//!
//! In: gradients, the texture's size, the maximum number of taps. Out: a `FilterRequest` with a level and a footprint for each lane.
//!
//! A pixel's footprint is the ellipse, in texels, onto which the gradients map a circle of diameter 1 pixel. The lengths of its axes are the
//! singular values of the gradient matrix. As in shaders/lib/filtered_map.wesl, up to `max_taps` trilinear taps cover the major axis; the outermost two end
//! where the axis ends. The mip level is log2 of the minor axis, or of the major axis / `max_taps` if that is greater. Where the major axis is not a whole
//! number of taps long, the taps in the middle overlap, and the overlap is taken from their weight, so that the filtered value is continuous in the gradients.
//! The level of isotropic filtering is log2 of the longer gradient. No level is finer than level 0. Gradients are limited, so that no footprint exceeds the
//! range of f32. Loops over lanes are branch-free, so that they are vectorised. Gradients that are NaN give an unspecified valid level and length.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::lane_order::{BATCH, MAX_TAPS};
use crate::render::software::math::Real;

/// Longer gradients, in texels, count as this long along each axis of the map: `LONGEST_GRADIENT` of shaders/lib/filtered_map.wesl.
const LONGEST_GRADIENT: f64 = 1e9;

/// The taps of one lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint<R> {
    /// Mip level, at least 0; it may be coarser than the coarsest level.
    pub level: R,
    /// Length of the major axis in taps, at least 1. The number of taps is this length, rounded up.
    pub length: R,
    /// The vector along the major axis from one tap to the next, if they do not overlap, in texture coordinates.
    pub step: [R; 2],
}

/// The weight of a tap that overlaps no other one, relative to the other taps of the footprint: `tap_weight` of shaders/lib/filtered_map.wesl. `along`: the
/// tap's place on the major axis, from the middle; `length`: length of the axis, which ends at plus and minus half of it; both in taps. It is 1, as there, so
/// that the filtered value is the mean over the footprint (a box filter).
#[inline(always)]
fn tap_weight<R: Real>(_along: R, _length: R) -> R {
    R::ONE
}

/// Tap number `index` of each lane: its place on the major axis, from the middle, and its weight. Places and `length` are in taps. The value of a footprint is
/// the weighted sum of its taps, divided by the sum of their weights. Both kernels, `filter` and `filter_avx2`, call this
/// function, so that the bits are equal.
#[inline(always)]
pub(super) fn taps<R: Real, const N: usize>(index: usize, length: &[R; N]) -> ([R; N], [R; N]) {
    let half = R::from_f64(0.5);
    let (mut along, mut weight) = ([R::ZERO; N], [R::ZERO; N]);
    for i in 0..N {
        let count = ceil(length[i]);
        let excess = count - length[i];
        let offset = R::from_u32(index as u32) - half * (count - R::ONE);
        let distance = offset.abs();
        // Side by side, the taps would be longer than the axis by `excess`, so each moves towards the middle by half of it. The taps in the middle then overlap
        // by `excess` in all. This is taken from their weights: of two taps half of it from each, of a single one in the middle all of it.
        let to_middle = half * excess;
        let moved = if distance < to_middle { R::ZERO } else { distance - to_middle };
        let share_of_excess = if distance < R::ONE { R::ONE - distance } else { R::ZERO };
        along[i] = moved.with_sign(offset);
        weight[i] = (R::ONE - excess * share_of_excess) * tap_weight(along[i], length[i]);
    }
    (along, weight)
}

#[inline(always)]
pub(super) fn ceil<R: Real>(x: R) -> R {
    -floor(-x)
}

#[inline(always)]
pub(super) fn floor<R: Real>(x: R) -> R {
    let rounded = x.round();
    if rounded > x { rounded - R::ONE } else { rounded }
}

impl<R: Real> Footprint<R> {
    /// Anisotropic filtering: up to `max_taps` taps along the major axis, as in `filtered_map` of shaders/lib/filtered_map.wesl. The other arguments are
    /// those of [`texel_gradients`].
    #[inline(always)]
    pub(crate) fn anisotropic(size: [R; 2], dx: [R; 2], dy: [R; 2], max_taps: R) -> Self {
        let half = R::from_f64(0.5);
        let [ux, vx, uy, vy] = texel_gradients(size, dx, dy);
        // For the gradient matrix J, J Jᵀ has the diagonal elements a and c and the other element b; its eigenvalues are the squares of the axes.
        let (a, c, b) = (ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy);
        let (mean, half_difference) = (half * (a + c), half * (a - c));
        let major_sq =
            if max_taps > R::ONE { mean + (half_difference * half_difference + b * b).sqrt() } else { longest_sq([ux, vx, uy, vy]) };
        let det = ux * vy - uy * vx;
        let minor_sq = det * det / major_sq;
        let min_width_sq = major_sq / (max_taps * max_taps);
        // Width of one tap, squared.
        let width_sq = if minor_sq > min_width_sq { minor_sq } else { min_width_sq };
        let width_sq = at_least_one(width_sq);
        // Shorter by 0.01, so that a round footprint has one tap in spite of rounding.
        let length = (major_sq / width_sq).sqrt() - R::from_f64(0.01);
        let length = if length < max_taps { length } else { max_taps };
        let length = if length > R::ONE { length } else { R::ONE };
        // The eigenvector of the major axis, computed from the better conditioned row of the matrix.
        let is_longer_in_u = half_difference > R::ZERO;
        let x = if is_longer_in_u { major_sq - c } else { b };
        let y = if is_longer_in_u { b } else { major_sq - a };
        let axis_sq = x * x + y * y;
        // The width of a tap divided by the eigenvector's length, whose square counts as at least 1e-30: a round footprint has no direction; its eigenvector is
        // 0.
        let scale = width_sq.sqrt() / if axis_sq > R::from_f64(1e-30) { axis_sq } else { R::from_f64(1e-30) }.sqrt();
        Self { level: level_of(width_sq), length, step: [x * scale / size[0], y * scale / size[1]] }
    }
}

/// A gradient in texels, limited to [`LONGEST_GRADIENT`]. Written so that it is vectorised.
#[inline(always)]
fn limited<R: Real>(gradient: R) -> R {
    let longest = R::from_f64(LONGEST_GRADIENT);
    let raised = if gradient > -longest { gradient } else { -longest };
    if raised < longest { raised } else { longest }
}

/// The gradients in texels per pixel: du/dx, dv/dx, du/dy, dv/dy, limited. `dx`, `dy`: gradients `[du, dv]` per pixel in x and in y; `size`: of the texture,
/// in texels.
#[inline(always)]
fn texel_gradients<R: Real>(size: [R; 2], dx: [R; 2], dy: [R; 2]) -> [R; 4] {
    [limited(dx[0] * size[0]), limited(dx[1] * size[1]), limited(dy[0] * size[0]), limited(dy[1] * size[1])]
}

/// The square of the longer of the two gradients from [`texel_gradients`].
#[inline(always)]
fn longest_sq<R: Real>([ux, vx, uy, vy]: [R; 4]) -> R {
    let (dx_sq, dy_sq) = (ux * ux + vx * vx, uy * uy + vy * vy);
    if dx_sq > dy_sq { dx_sq } else { dy_sq }
}

/// The greater of x and 1; NaN becomes 1.
#[inline(always)]
fn at_least_one<R: Real>(x: R) -> R {
    if x > R::ONE { x } else { R::ONE }
}

/// The level whose texels have a given width, in texels of level 0. `width_sq`: the square of the width, at least 1.
#[inline(always)]
fn level_of<R: Real>(width_sq: R) -> R {
    // `false`: without fused multiply-add, so that the bits do not depend on the instruction set.
    R::from_f64(0.5) * width_sq.log2_of_at_least_one::<false>()
}

/// Whether every value is at most 1; false if a value is NaN.
#[inline(always)]
fn are_at_most_one<R: Real>(values: &[R; BATCH]) -> bool {
    values.iter().fold(true, |all, value| all & (*value <= R::ONE))
}

/// The coordinates, levels and footprints of the lanes of a batch.
pub(crate) struct FilterRequest<'a, R> {
    pub u: &'a [R; BATCH],
    pub v: &'a [R; BATCH],
    /// The mip level of each lane; `None` if each lane reads level 0 with one tap, as under magnification.
    pub level: Option<[R; BATCH]>,
    /// `None` if each lane has one tap.
    pub footprints: Option<Footprints<R>>,
}

/// The footprints of the lanes of a batch, as in [`Footprint`].
pub(crate) struct Footprints<R> {
    pub length: [R; BATCH],
    pub step_u: [R; BATCH],
    pub step_v: [R; BATCH],
}

impl<'a, R: Real> FilterRequest<'a, R> {
    pub(crate) fn new(u: &'a [R; BATCH], v: &'a [R; BATCH]) -> Self {
        Self { u, v, level: None, footprints: None }
    }

    /// Fills levels and footprints from the gradients `g`: du/dx, dv/dx, du/dy, dv/dy, per pixel. `size`: width and height of level 0 in texels. `max_taps`: at
    /// least 1; `None` for isotropic filtering.
    #[inline(always)]
    pub(crate) fn set_footprints(&mut self, size: [u32; 2], g: [&[R; BATCH]; 4], max_taps: Option<&[R; BATCH]>) {
        let size = [R::from_u32(size[0]), R::from_u32(size[1])];
        let Some(max_taps) = max_taps else {
            let mut widths_sq = [R::ZERO; BATCH];
            for i in 0..BATCH {
                widths_sq[i] = longest_sq(texel_gradients(size, [g[0][i], g[1][i]], [g[2][i], g[3][i]]));
            }
            if !are_at_most_one(&widths_sq) {
                self.level = Some(widths_sq.map(|square| level_of(at_least_one(square))));
            }
            return;
        };
        // The sum of the squares of both axes is at least the square of the major axis. Where the sum is at most 1, `anisotropic` gives level 0 and one tap,
        // in spite of rounding, because it shortens the footprint by 0.01.
        let mut sums_sq = [R::ZERO; BATCH];
        for i in 0..BATCH {
            let (ux, vx, uy, vy) = (g[0][i] * size[0], g[1][i] * size[1], g[2][i] * size[0], g[3][i] * size[1]);
            sums_sq[i] = (ux * ux + vx * vx) + (uy * uy + vy * vy);
        }
        if are_at_most_one(&sums_sq) {
            return;
        }
        let limit = R::from_u32(MAX_TAPS as u32);
        let zeros = [R::ZERO; BATCH];
        let level = self.level.insert(zeros);
        let footprints = self.footprints.insert(Footprints { length: zeros, step_u: zeros, step_v: zeros });
        for i in 0..BATCH {
            let max_taps = if max_taps[i] < limit { max_taps[i] } else { limit };
            let f = Footprint::anisotropic(size, [g[0][i], g[1][i]], [g[2][i], g[3][i]], max_taps);
            level[i] = f.level;
            (footprints.length[i], footprints.step_u[i], footprints.step_v[i]) = (f.length, f.step[0], f.step[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a batch has levels if its footprints are `width` texels wide, except one of `width_of_one_lane`. Up to 8 taps if `is_anisotropic`, else one.
    fn has_level(width: f32, width_of_one_lane: f32, is_anisotropic: bool) -> bool {
        let (zeros, max_taps) = ([0.0; BATCH], [8.0; BATCH]);
        let mut gradient = [width / 64.0; BATCH];
        gradient[77] = width_of_one_lane / 64.0;
        let mut request = FilterRequest::new(&zeros, &zeros);
        request.set_footprints([64, 64], [&gradient, &zeros, &zeros, &gradient], is_anisotropic.then_some(&max_taps));
        assert_eq!(request.footprints.is_some(), is_anisotropic && request.level.is_some());
        request.level.is_some()
    }

    /// tests/software/filtered_map.rs relies on this to test the code for magnified batches.
    #[test]
    fn a_batch_has_no_levels_only_if_all_lanes_are_magnified() {
        for is_anisotropic in [false, true] {
            assert!(!has_level(0.1, 0.7, is_anisotropic));
            assert!(has_level(0.1, 1.1, is_anisotropic));
            assert!(has_level(3.0, 3.0, is_anisotropic));
        }
    }
}
