//! Filters maps eight lanes (a group) at a time in AVX2 registers, without arrays in between.
//!
//! In: a batch of f32 lanes, in the order of the batch, not sorted as in `lane_order`. Eight neighbouring lanes nearly always read the same mip level;
//! where they do not, they are filtered once for each level, which costs less than sorting the batch. Out: as [`super::filter`], by the same steps for
//! each lane, so that the bits are the same. Not here: levels and footprints (`footprint`).

use super::corners::{Corners, TexelsBeside};
use super::footprint::{FilterRequest, tap_of_each_lane};
use super::lane_order::{BATCH, Channels, MAX_TAPS};
use super::texels::{BoundLevel, Decode, LoadedLevel};
use crate::render::plan::{AddressMode, SamplerState};
use crate::render::software::exec::LaneMask;
use crate::render::software::math::Real;
use std::arch::x86_64::{
    __m256, __m256i, _CMP_GT_OQ, _mm256_add_epi32, _mm256_add_ps, _mm256_and_ps, _mm256_and_si256, _mm256_andnot_si256, _mm256_blendv_ps,
    _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_ps, _mm256_cmpeq_epi32, _mm256_cmpgt_epi32, _mm256_cvttps_epi32, _mm256_div_ps,
    _mm256_floor_ps, _mm256_max_epi32, _mm256_max_ps, _mm256_min_epi32, _mm256_min_epu32, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setr_epi32, _mm256_setzero_ps, _mm256_setzero_si256, _mm256_sub_ps,
    _mm256_testz_si256, _mm256_xor_ps,
};
use std::mem::transmute;

/// Number of lanes in an AVX2 register, filtered together.
pub(super) const GROUP_LANES: usize = 8;
/// The bits of all lanes of a group.
pub(super) const ALL_OF_GROUP: u32 = (1 << GROUP_LANES) - 1;

/// A [`FilterRequest`] of f32.
pub(super) struct F32Request<'a> {
    u: &'a [f32; BATCH],
    v: &'a [f32; BATCH],
    /// The mip level of each lane; `None` if each lane reads level 0 with one tap.
    levels_of_lanes: Option<&'a [f32; BATCH]>,
    /// Of [`Footprints`](super::footprint::Footprints): the length in taps, and the width of a tap in u and in v, in texture coordinates. `None` if each
    /// lane has one tap.
    footprints: Option<[&'a [f32; BATCH]; 3]>,
}

impl<'a> F32Request<'a> {
    /// `None` for f64.
    #[inline(always)]
    pub(super) fn new<R: Real>(request: &'a FilterRequest<'_, R>) -> Option<Self> {
        let as_f32 = |values: &'a [R; BATCH]| R::as_f32(values)?.first_chunk();
        let footprints = match &request.footprints {
            Some(footprints) => Some([as_f32(&footprints.length)?, as_f32(&footprints.step_u)?, as_f32(&footprints.step_v)?]),
            None => None,
        };
        let levels_of_lanes = match &request.level {
            Some(level) => Some(as_f32(level)?),
            None => None,
        };
        Some(Self { u: as_f32(request.u)?, v: as_f32(request.v)?, levels_of_lanes, footprints })
    }
}

/// The values of group `group`: lanes `8 * group` to `8 * group + 7`.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn group_of(values: &[f32; BATCH], group: usize) -> __m256 {
    // SAFETY: an array and a register have eight floats each.
    unsafe { transmute::<[f32; GROUP_LANES], __m256>(values.as_chunks().0[group]) }
}

/// `n` in every lane.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn broadcast(n: u32) -> __m256i {
    // SAFETY: the caller guarantees AVX2.
    unsafe { _mm256_set1_epi32(n as i32) }
}

/// Size and addressing of a level along one axis: the number of texels, and the index of the last one, in every lane.
#[derive(Clone, Copy)]
pub(super) struct AxisSize {
    size: __m256,
    last: __m256i,
    /// Whether the image repeats along this axis; otherwise it continues with its outermost texels.
    repeats: bool,
}

impl AxisSize {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    unsafe fn new(size: u32, repeats: bool) -> Self {
        // SAFETY: the caller guarantees AVX2.
        unsafe { Self { size: _mm256_set1_ps(size as i32 as f32), last: broadcast(size - 1), repeats } }
    }
}

/// A level, and its width and height in registers.
#[derive(Clone, Copy)]
pub(super) struct SizedLevel<'a> {
    pub texels: LoadedLevel<'a>,
    pub axes: [AxisSize; 2],
    /// The number of texels in a row.
    pub width: __m256i,
}

impl<'a> SizedLevel<'a> {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn new(texels: LoadedLevel<'a>, address_modes: [AddressMode; 2]) -> Self {
        let repeats = address_modes.map(|mode| mode == AddressMode::Repeat);
        // SAFETY: the caller guarantees AVX2.
        unsafe {
            let axes = [AxisSize::new(texels.width, repeats[0]), AxisSize::new(texels.height, repeats[1])];
            Self { texels, axes, width: broadcast(texels.width) }
        }
    }
}

/// A mip level, and the next coarser one where lanes lie between both.
#[derive(Clone, Copy)]
struct LevelPair<'a> {
    finer_index: usize,
    finer: SizedLevel<'a>,
    coarser: Option<SizedLevel<'a>>,
}

/// The levels from which some lanes read, brought into memory. `previous`: those of the lanes before, which are usually the same.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn level_pair<'a>(
    levels: &[BoundLevel<'a>],
    address_modes: [AddressMode; 2],
    finer_index: usize,
    needs_coarser: bool,
    previous: Option<LevelPair<'a>>,
) -> LevelPair<'a> {
    if let Some(previous) = previous
        && previous.finer_index == finer_index
        && (previous.coarser.is_some() || !needs_coarser)
    {
        return previous;
    }
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let finer = SizedLevel::new(levels[finer_index].read(), address_modes);
        let coarser = match levels.get(finer_index + 1) {
            Some(coarser) if needs_coarser => Some(SizedLevel::new(coarser.read(), address_modes)),
            _ => None,
        };
        LevelPair { finer_index, finer, coarser }
    }
}

/// The texels before and after each position along one axis, and the position's fraction between them. `x`: positions; the centre of texel `k` is at `k`.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn texels_beside(x: __m256, axis: &AxisSize) -> TexelsBeside {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        // min and max return their second operand if one is NaN: NaN becomes -1.
        let x = _mm256_min_ps(_mm256_max_ps(x, _mm256_set1_ps(-1.0)), axis.size);
        let whole = _mm256_floor_ps(x);
        let fraction = _mm256_sub_ps(x, whole);
        let k = _mm256_cvttps_epi32(whole);
        let next = _mm256_add_epi32(k, _mm256_set1_epi32(1));
        let indices = if axis.repeats {
            // -1 is the largest unsigned number, so that it becomes the last texel.
            [_mm256_min_epu32(k, axis.last), _mm256_andnot_si256(_mm256_cmpgt_epi32(next, axis.last), next)]
        } else {
            [_mm256_max_epi32(_mm256_min_epi32(k, axis.last), _mm256_setzero_si256()), _mm256_min_epi32(next, axis.last)]
        };
        TexelsBeside { indices, fraction }
    }
}

/// As [`texels_beside`], for a texture coordinate (0 to 1 over the level).
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn texel_pair(c: __m256, axis: &AxisSize) -> TexelsBeside {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let c = if axis.repeats { _mm256_sub_ps(c, _mm256_floor_ps(c)) } else { c };
        texels_beside(_mm256_sub_ps(_mm256_mul_ps(c, axis.size), _mm256_set1_ps(0.5)), axis)
    }
}

/// Bilinear interpolation at eight texture coordinates, between the texels of one level. `needed`: for each channel, whether it is used.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn bilinear<D: Decode>(decode: D, level: &SizedLevel<'_>, [u, v]: [__m256; 2], needed: [bool; 4]) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2; `texel_pair` clamps columns and rows to the level.
    unsafe {
        let corners = Corners::new(level.width, texel_pair(u, &level.axes[0]), texel_pair(v, &level.axes[1]));
        decode.interpolate_eight(&level.texels, &corners, needed)
    }
}

/// Interpolates between a level and the coarser one, if there is one.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn trilinear<D: Decode>(
    decode: D,
    LevelPair { finer, coarser, .. }: &LevelPair<'_>,
    uv: [__m256; 2],
    fraction: __m256,
    needed: [bool; 4],
) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let mut value = bilinear(decode, finer, uv, needed);
        let is_between = _mm256_cmp_ps::<_CMP_GT_OQ>(fraction, _mm256_setzero_ps());
        if let Some(coarser) = coarser
            && _mm256_movemask_ps(is_between) != 0
        {
            let coarser = bilinear(decode, coarser, uv, needed);
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

/// What [`value_of`] reads of a group of eight lanes.
struct GroupInput<'a> {
    uv: [__m256; 2],
    /// Weight of the next coarser level.
    fraction: __m256,
    /// As [`F32Request::footprints`], of the whole batch.
    footprints: Option<[&'a [f32; BATCH]; 3]>,
    /// Index of the group in the batch.
    group: usize,
}

/// [`tap_of_each_lane`] for eight lanes. `length`: of the footprints, in taps.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn tap_of_eight_lanes(index: usize, length: __m256) -> (__m256, __m256) {
    // SAFETY: registers and arrays have eight floats each.
    unsafe {
        let (along, weight) = tap_of_each_lane(index, &transmute::<__m256, [f32; GROUP_LANES]>(length));
        (transmute::<[f32; GROUP_LANES], __m256>(along), transmute::<[f32; GROUP_LANES], __m256>(weight))
    }
}

/// The filtered values of eight lanes, one register per channel. `wanted_lanes`: all bits set in the lanes whose value is used.
/// `needed`: as for [`bilinear`].
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn value_of<D: Decode>(
    decode: D,
    levels: &LevelPair<'_>,
    input: &GroupInput<'_>,
    wanted_lanes: __m256,
    needed: [bool; 4],
) -> [__m256; 4] {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let ([u, v], fraction) = (input.uv, input.fraction);
        let Some([length, step_u, step_v]) = input.footprints else { return trilinear(decode, levels, [u, v], fraction, needed) };
        let length = group_of(length, input.group);
        if _mm256_movemask_ps(_mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(length, _mm256_set1_ps(1.0)), wanted_lanes)) == 0 {
            return trilinear(decode, levels, [u, v], fraction, needed);
        }
        let (step_u, step_v) = (group_of(step_u, input.group), group_of(step_v, input.group));
        let (mut sum, mut total_weight) = ([_mm256_setzero_ps(); 4], _mm256_setzero_ps());
        for index in 0..MAX_TAPS {
            // A lane has as many taps as its length, rounded up, so tap `index` exists if the length is greater than `index`.
            let has_tap = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(length, _mm256_set1_ps(index as f32)), wanted_lanes);
            if _mm256_movemask_ps(has_tap) == 0 {
                break;
            }
            // `along`: place of the tap on the footprint's major axis, from the middle, in taps.
            let (along, weight) = tap_of_eight_lanes(index, length);
            let uv = [_mm256_add_ps(u, _mm256_mul_ps(along, step_u)), _mm256_add_ps(v, _mm256_mul_ps(along, step_v))];
            let value = trilinear(decode, levels, uv, fraction, needed);
            total_weight = _mm256_add_ps(total_weight, _mm256_and_ps(weight, has_tap));
            for k in 0..4 {
                sum[k] = _mm256_blendv_ps(sum[k], _mm256_add_ps(sum[k], _mm256_mul_ps(weight, value[k])), has_tap);
            }
        }
        for sum in &mut sum {
            *sum = _mm256_div_ps(*sum, total_weight);
        }
        sum
    }
}

/// A register with all bits set in the lanes whose bit of `lane_bits` is set.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn mask_of(lane_bits: u32) -> __m256 {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(lane_bits as i32), bits), bits))
    }
}

/// The channels of a batch, in groups of eight lanes.
type LaneGroups<'a> = [Option<&'a mut [[f32; GROUP_LANES]]>; 4];

/// Divides each channel into groups of eight lanes.
#[inline(always)]
pub(super) fn in_groups(out: Channels<'_, f32>) -> LaneGroups<'_> {
    out.map(|channel| channel.map(|values| values.as_chunks_mut::<GROUP_LANES>().0))
}

/// Writes the active lanes of a group of eight. `active`: one bit per lane of the group.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn write_group(out: &mut LaneGroups<'_>, group: usize, value: [__m256; 4], active: u32) {
    for (out, value) in out.iter_mut().zip(value) {
        let Some(out) = out.as_mut().map(|out| &mut out[group]) else { continue };
        // SAFETY: the caller guarantees AVX2; registers and arrays have eight floats each.
        unsafe {
            let kept = transmute::<[f32; GROUP_LANES], __m256>(*out);
            let value = if active == ALL_OF_GROUP { value } else { _mm256_blendv_ps(kept, value, mask_of(active)) };
            *out = transmute::<__m256, [f32; GROUP_LANES]>(value);
        }
    }
}

/// The finer level that each of eight lanes reads, and its fraction towards the coarser one.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn level_and_fraction(levels_of_lanes: &[f32; BATCH], group: usize, level_count: usize) -> (__m256, __m256) {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        // max returns its second operand if one is NaN: NaN becomes 0.
        let coarsest = _mm256_set1_ps((level_count - 1) as f32);
        let level = _mm256_min_ps(_mm256_max_ps(group_of(levels_of_lanes, group), _mm256_setzero_ps()), coarsest);
        let finer = _mm256_floor_ps(level);
        (finer, _mm256_sub_ps(level, finer))
    }
}

/// The finer level, if it is the same in all lanes, and whether some lane needs the coarser one as well.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn shared_level(levels_of_lanes: &[f32; BATCH], level_count: usize) -> Option<(usize, bool)> {
    // SAFETY: the caller guarantees AVX2; a register and an array have eight numbers each.
    unsafe {
        let (first, mut largest_fraction) = level_and_fraction(levels_of_lanes, 0, level_count);
        let mut differs = _mm256_setzero_ps();
        for group in 1..BATCH / GROUP_LANES {
            let (finer, fraction) = level_and_fraction(levels_of_lanes, group, level_count);
            differs = _mm256_or_ps(differs, _mm256_xor_ps(finer, first));
            largest_fraction = _mm256_max_ps(largest_fraction, fraction);
        }
        let levels = transmute::<__m256, [f32; GROUP_LANES]>(first);
        let is_shared = _mm256_testz_si256(_mm256_castps_si256(differs), _mm256_castps_si256(differs)) == 1
            && levels.iter().all(|level| *level == levels[0]);
        let needs_coarser = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(largest_fraction, _mm256_setzero_ps())) != 0;
        is_shared.then_some((levels[0] as usize, needs_coarser))
    }
}

/// Filters the active lanes into `out`; the other lanes of `out` are left unchanged. `levels`: from the finest to the coarsest that may be read.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn filter<D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    request: &F32Request<'_>,
    state: &SamplerState,
    active: LaneMask,
    out: Channels<'_, f32>,
) {
    let needed = out.each_ref().map(|o| o.is_some());
    let mut out = in_groups(out);
    let address_modes = [state.address_u, state.address_v];
    let Some(levels_of_lanes) = request.levels_of_lanes else {
        // SAFETY: the caller guarantees AVX2.
        unsafe {
            let level = SizedLevel::new(levels[0].read(), address_modes);
            for group in 0..BATCH / GROUP_LANES {
                let active = (active >> (group * GROUP_LANES)) as u32 & ALL_OF_GROUP;
                if active != 0 {
                    let value = bilinear(decode, &level, [group_of(request.u, group), group_of(request.v, group)], needed);
                    write_group(&mut out, group, value, active);
                }
            }
        }
        return;
    };
    if active == LaneMask::MAX
        // SAFETY: the caller guarantees AVX2.
        && let Some((finer_index, needs_coarser)) = unsafe { shared_level(levels_of_lanes, levels.len()) }
    {
        // SAFETY: as above.
        unsafe {
            let previous = None;
            let pair = level_pair(levels, address_modes, finer_index, needs_coarser, previous);
            for group in 0..BATCH / GROUP_LANES {
                let (_, fraction) = level_and_fraction(levels_of_lanes, group, levels.len());
                let uv = [group_of(request.u, group), group_of(request.v, group)];
                let input = GroupInput { uv, fraction, footprints: request.footprints, group };
                let value = value_of(decode, &pair, &input, _mm256_castsi256_ps(_mm256_set1_epi32(-1)), needed);
                write_group(&mut out, group, value, ALL_OF_GROUP);
            }
        }
        return;
    }
    let mut previous = None;
    for group in 0..BATCH / GROUP_LANES {
        let active = (active >> (group * GROUP_LANES)) as u32 & ALL_OF_GROUP;
        if active == 0 {
            continue;
        }
        // SAFETY: the caller guarantees AVX2; registers and arrays have eight numbers each.
        unsafe {
            let zero = _mm256_setzero_ps();
            let (finer, fraction) = level_and_fraction(levels_of_lanes, group, levels.len());
            let finer = _mm256_cvttps_epi32(finer);
            let finer_of_lane = transmute::<__m256i, [i32; GROUP_LANES]>(finer);
            let is_between = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(fraction, zero)) as u32;
            let uv = [group_of(request.u, group), group_of(request.v, group)];
            let input = GroupInput { uv, fraction, footprints: request.footprints, group };
            let (mut value, mut remaining) = ([zero; 4], active);
            while remaining != 0 {
                let finer_index = finer_of_lane[remaining.trailing_zeros() as usize % GROUP_LANES];
                let same_level = _mm256_castsi256_ps(_mm256_cmpeq_epi32(finer, _mm256_set1_epi32(finer_index)));
                let lanes_at_level = _mm256_movemask_ps(same_level) as u32 & active;
                let pair = level_pair(levels, address_modes, finer_index as usize, lanes_at_level & is_between != 0, previous);
                let wanted_lanes = if lanes_at_level == ALL_OF_GROUP { same_level } else { mask_of(lanes_at_level) };
                let level_value = value_of(decode, &pair, &input, wanted_lanes, needed);
                previous = Some(pair);
                for k in 0..4 {
                    value[k] =
                        if lanes_at_level == active { level_value[k] } else { _mm256_blendv_ps(value[k], level_value[k], wanted_lanes) };
                }
                remaining &= !lanes_at_level;
            }
            write_group(&mut out, group, value, active);
        }
    }
}
