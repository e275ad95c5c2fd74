//! Filters maps eight lanes at a time in AVX2 registers, without arrays in between.
//!
//! In: the sorted lanes of a batch, of f32. Out: as [`super::filter`], by the same steps in the same order, so that the bits are the same. Integers wrap and
//! indices are clamped as there.

use super::corners::Corners;
use super::lane_order::{Channels, LaneOrder, MAX_TAPS};
use super::texels::{BoundLevel, Decode, TexelLevel, read_pair};
use crate::render::plan::{AddressMode, SamplerState};
use std::arch::x86_64::{
    __m256, __m256i, _CMP_GT_OQ, _mm256_add_epi32, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps, _mm256_andnot_si256, _mm256_blendv_ps,
    _mm256_ceil_ps, _mm256_cmp_ps, _mm256_cmpgt_epi32, _mm256_cvttps_epi32, _mm256_div_ps, _mm256_floor_ps, _mm256_max_epi32,
    _mm256_max_ps, _mm256_min_epi32, _mm256_min_epu32, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_mullo_epi32, _mm256_or_ps,
    _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_ps, _mm256_setzero_si256, _mm256_sub_ps,
};
use std::mem::transmute;

/// Lanes of a register.
const EIGHT: usize = 8;

/// What the filter reads of each lane, in sorted order. Eight lanes can be read from any position of an active lane on.
pub(super) struct SortedLanes<'a> {
    pub u: &'a [f32],
    pub v: &'a [f32],
    /// Part of the next coarser level.
    pub fraction: &'a [f32],
    /// The width of a tap in u and v, and the length in taps; `None` if each lane has one tap.
    pub footprints: Option<[&'a [f32]; 3]>,
}

/// Eight values from position `start` on; zeros where there are not as many.
/// # Safety
/// The machine has AVX2, as for all functions of this module.
#[inline(always)]
unsafe fn eight(values: &[f32], start: usize) -> __m256 {
    let array = values.get(start..).and_then(<[f32]>::first_chunk::<EIGHT>).unwrap_or(&[0.0; EIGHT]);
    // SAFETY: an array and a register have eight floats each.
    unsafe { transmute::<[f32; EIGHT], __m256>(*array) }
}

/// The texels before and after a coordinate along one axis, and its place between them.
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn texel_pair(c: __m256, size: u32, mode: AddressMode) -> (__m256i, __m256i, __m256) {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let n = _mm256_set1_ps(size as i32 as f32);
        let last = _mm256_set1_epi32(size as i32 - 1);
        let repeats = mode == AddressMode::Repeat;
        let c = if repeats { _mm256_sub_ps(c, _mm256_floor_ps(c)) } else { c };
        let x = _mm256_sub_ps(_mm256_mul_ps(c, n), _mm256_set1_ps(0.5));
        // A minimum or maximum with NaN is the second operand.
        let x = _mm256_min_ps(_mm256_max_ps(x, _mm256_set1_ps(-1.0)), n);
        let whole = _mm256_floor_ps(x);
        let fraction = _mm256_sub_ps(x, whole);
        let k = _mm256_cvttps_epi32(whole);
        let next = _mm256_add_epi32(k, _mm256_set1_epi32(1));
        if repeats {
            // -1 is the largest unsigned number, so that it becomes the last texel.
            (_mm256_min_epu32(k, last), _mm256_andnot_si256(_mm256_cmpgt_epi32(next, last), next), fraction)
        } else {
            (_mm256_max_epi32(_mm256_min_epi32(k, last), _mm256_setzero_si256()), _mm256_min_epi32(next, last), fraction)
        }
    }
}

/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn bilinear<D: Decode>(
    decode: D,
    level: &TexelLevel<'_>,
    [u, v]: [__m256; 2],
    state: &SamplerState,
    needed: [bool; 4],
) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2; `texel_pair` clamps columns and rows to the level.
    unsafe {
        let (left, right, x) = texel_pair(u, level.width, state.address_u);
        let (above, below, y) = texel_pair(v, level.height, state.address_v);
        let width = _mm256_set1_epi32(level.width as i32);
        let (above, below) = (_mm256_mullo_epi32(above, width), _mm256_mullo_epi32(below, width));
        let index =
            [_mm256_add_epi32(above, left), _mm256_add_epi32(above, right), _mm256_add_epi32(below, left), _mm256_add_epi32(below, right)];
        decode.interpolate_eight(level, &Corners { index, fraction: [x, y] }, needed)
    }
}

/// Interpolates between a level and the coarser one, if there is one.
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn trilinear<D: Decode>(
    decode: D,
    (level, coarser): (TexelLevel<'_>, Option<TexelLevel<'_>>),
    uv: [__m256; 2],
    fraction: __m256,
    state: &SamplerState,
    needed: [bool; 4],
) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let mut value = bilinear(decode, &level, uv, state, needed);
        let is_between = _mm256_cmp_ps::<_CMP_GT_OQ>(fraction, _mm256_setzero_ps());
        if let Some(coarser) = coarser
            && _mm256_movemask_ps(is_between) != 0
        {
            let coarser = bilinear(decode, &coarser, uv, state, needed);
            for k in 0..4 {
                if needed[k] {
                    let mixed = _mm256_add_ps(value[k], _mm256_mul_ps(fraction, _mm256_sub_ps(coarser[k], value[k])));
                    value[k] = _mm256_blendv_ps(value[k], mixed, is_between);
                }
            }
        }
        value
    }
}

/// The value of the eight lanes from position `start` on.
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn value_at<D: Decode>(
    decode: D,
    both_levels: (TexelLevel<'_>, Option<TexelLevel<'_>>),
    lanes: &SortedLanes<'_>,
    start: usize,
    state: &SamplerState,
    needed: [bool; 4],
) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let (u, v, fraction) = (eight(lanes.u, start), eight(lanes.v, start), eight(lanes.fraction, start));
        // The first lane has the most taps.
        let most_taps = lanes.footprints.map_or(1, |[.., length]| (length[start].ceil() as usize).min(MAX_TAPS));
        let Some([step_u, step_v, length]) = lanes.footprints.filter(|_| most_taps > 1) else {
            return trilinear(decode, both_levels, [u, v], fraction, state, needed);
        };
        let (step_u, step_v, length) = (eight(step_u, start), eight(step_v, start), eight(length, start));
        let (zero, half, one) = (_mm256_setzero_ps(), _mm256_set1_ps(0.5), _mm256_set1_ps(1.0));
        let sign = _mm256_set1_ps(-0.0);
        let taps = _mm256_ceil_ps(length);
        let excess = _mm256_sub_ps(taps, length);
        let (middle, to_middle) = (_mm256_mul_ps(half, _mm256_sub_ps(taps, one)), _mm256_mul_ps(half, excess));
        let mut sum = [zero; 4];
        for index in 0..most_taps {
            // As `footprint::tap`.
            let index = _mm256_set1_ps(index as f32);
            let offset = _mm256_sub_ps(index, middle);
            let distance = _mm256_andnot_ps(sign, offset);
            let moved = _mm256_max_ps(_mm256_sub_ps(distance, to_middle), zero);
            let weight = _mm256_sub_ps(one, _mm256_mul_ps(excess, _mm256_max_ps(_mm256_sub_ps(one, distance), zero)));
            let offset = _mm256_or_ps(moved, _mm256_and_ps(sign, offset));
            let uv = [_mm256_add_ps(u, _mm256_mul_ps(offset, step_u)), _mm256_add_ps(v, _mm256_mul_ps(offset, step_v))];
            let value = trilinear(decode, both_levels, uv, fraction, state, needed);
            let has_tap = _mm256_cmp_ps::<_CMP_GT_OQ>(taps, index);
            for k in 0..4 {
                sum[k] = _mm256_blendv_ps(sum[k], _mm256_add_ps(sum[k], _mm256_mul_ps(weight, value[k])), has_tap);
            }
        }
        [_mm256_div_ps(sum[0], length), _mm256_div_ps(sum[1], length), _mm256_div_ps(sum[2], length), _mm256_div_ps(sum[3], length)]
    }
}

/// Filters the sorted lanes into `out`. `levels`: not more than the coarsest that is read.
/// # Safety
/// AVX2.
#[inline(always)]
pub(super) unsafe fn filter<D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    order: &LaneOrder,
    lanes: &SortedLanes<'_>,
    state: &SamplerState,
    mut out: Channels<'_, f32>,
) {
    let needed = out.each_ref().map(|o| o.is_some());
    for level in order.levels.clone() {
        let (from, to) = order.positions(level);
        if from == to {
            continue;
        }
        let both_levels = read_pair(levels, level, &lanes.fraction[from..to]);
        let mut start = from;
        while start < to {
            // SAFETY: the caller guarantees AVX2; registers and arrays have eight floats each.
            let value = unsafe { transmute::<[__m256; 4], [[f32; EIGHT]; 4]>(value_at(decode, both_levels, lanes, start, state, needed)) };
            order.store(&value, start, to - start, &mut out);
            start += EIGHT;
        }
    }
}
