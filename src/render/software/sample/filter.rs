//! Filters the texels of a batch: nearest, bilinear, trilinear, several taps along a footprint.
//!
//! In: a batch's texture coordinates and footprints (the areas of the pixels on the map), in arrays of `BATCH` lanes. Out: up to four linear channels of each
//! active lane.
//!
//! With AVX2 and trilinear filtering, `filter_avx2` filters f32 lanes without sorting them. Otherwise a counting sort first orders the active lanes by mip
//! level and number of taps. Each level's lanes are then contiguous, those with the most taps first, so that a loop over them reads one level.
//! A lane's result does not depend on its neighbours or on the instruction set: multiply and add are never fused, and every lane sums its taps in the
//! same order. Texel indices are computed by wrapping operations, because overflow checks would keep loops from being vectorised in debug builds.
//! Coordinates that are not finite read an unspecified texel.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

#[cfg(target_arch = "x86_64")]
use super::filter_avx2;
use super::footprint::{FilterRequest, Footprints, ceil, floor, taps};
pub(crate) use super::lane_order::{BATCH, Channels, MAX_TAPS};
use super::lane_order::{CHUNK, LaneOrder, LazyArray, MAX_LEVELS, PADDED};
use super::texels::{BoundLevel, Decode, TexelLevel, read_pair};
use crate::render::plan::{AddressMode, SamplerState};
use crate::render::software::exec::LaneMask;
use crate::render::software::math::Real;

/// For red, green, blue and alpha: whether the caller needs the channel.
type ChannelMask = [bool; 4];

/// The `CHUNK` elements of an array from index `start` on, which are filtered together. `values`: from [`LaneOrder::gather`].
#[inline(always)]
fn chunk<T>(values: &[T], start: usize) -> &[T; CHUNK] {
    match values[start..].first_chunk() {
        Some(c) => c,
        None => unreachable!("arrays are padded, or all chunks start at multiples of the chunk length"),
    }
}

/// The two texels beside each coordinate along one axis, the second to the right of the first or below it, and the coordinate's fraction between them.
struct TexelPair<R> {
    first: [u32; CHUNK],
    second: [u32; CHUNK],
    fraction: [R; CHUNK],
}

/// The texels beside texture coordinates (0 to 1 over the level) along one axis. `size`: number of texels along the axis.
#[inline(always)]
fn texel_pair<R: Real>(coordinate: &[R; CHUNK], size: u32, mode: AddressMode) -> TexelPair<R> {
    let n = R::from_u32(size);
    let last = size as i32 - 1;
    let repeats = mode == AddressMode::Repeat;
    // The texels that are read in place of those before the first and after the last.
    let (before, after) = if repeats { (last, 0) } else { (0, last) };
    let mut out = TexelPair { first: [0; CHUNK], second: [0; CHUNK], fraction: [R::ZERO; CHUNK] };
    for i in 0..CHUNK {
        let c = coordinate[i];
        // Texels from the centre of the first texel.
        let x = if repeats { c - floor(c) } else { c } * n - R::from_f64(0.5);
        // Limited to the range of `round_small`; beyond -1 and `n` the texels no longer change. Written so that NaN becomes -1.
        let x = if x > -R::ONE { x } else { -R::ONE };
        let x = if x < n { x } else { n };
        let (rounded, index) = x.round_small();
        let is_rounded_up = rounded > x;
        out.fraction[i] = x - if is_rounded_up { rounded - R::ONE } else { rounded };
        let index = if is_rounded_up { index.wrapping_sub(1) } else { index };
        out.first[i] = (if index < 0 { before } else { index.min(last) }) as u32;
        out.second[i] = (if index >= last { after } else { index.wrapping_add(1) }) as u32;
    }
    out
}

/// The texels at the given columns and rows. A function and not a closure: a closure that is not inlined lacks the instruction set of the kernel that
/// calls it, and each gather instruction would become a call.
/// # Safety
/// Columns and rows lie inside the level.
#[inline(always)]
unsafe fn fetch<D: Decode>(decode: D, level: &TexelLevel<'_>, column: &[u32; CHUNK], row: &[u32; CHUNK]) -> [D::Texel; CHUNK] {
    let mut index = [0; CHUNK];
    for i in 0..CHUNK {
        index[i] = row[i].wrapping_mul(level.width).wrapping_add(column[i]);
    }
    // SAFETY: the caller guarantees it.
    unsafe { decode.fetch(level, &index) }
}

/// Red, green, blue and alpha at a chunk of texture coordinates, by bilinear interpolation in one level; 0 for channels that are not needed.
#[inline(always)]
fn bilinear<R: Real, D: Decode>(
    decode: D,
    level: &TexelLevel<'_>,
    u: &[R; CHUNK],
    v: &[R; CHUNK],
    state: &SamplerState,
    needed: ChannelMask,
) -> [[R; CHUNK]; 4] {
    let (x, y) = (texel_pair(u, level.width, state.address_u), texel_pair(v, level.height, state.address_v));
    // SAFETY: `texel_pair` clamps columns and rows to the level.
    unsafe { bilinear_between(decode, level, &x, &y, needed) }
}

/// As [`bilinear`], between two columns and two rows of a level.
/// # Safety
/// Columns and rows lie inside the level.
#[inline(always)]
unsafe fn bilinear_between<R: Real, D: Decode>(
    decode: D,
    level: &TexelLevel<'_>,
    x: &TexelPair<R>,
    y: &TexelPair<R>,
    needed: ChannelMask,
) -> [[R; CHUNK]; 4] {
    // SAFETY: the caller guarantees it.
    let texels = unsafe {
        [
            fetch(decode, level, &x.first, &y.first),
            fetch(decode, level, &x.second, &y.first),
            fetch(decode, level, &x.first, &y.second),
            fetch(decode, level, &x.second, &y.second),
        ]
    };
    let mut out = [[R::ZERO; CHUNK]; 4];
    let [r, g, b, a] = &mut out;
    if needed[0] {
        interpolate::<R, D, 0>(decode, &texels, &x.fraction, &y.fraction, r);
    }
    if needed[1] {
        interpolate::<R, D, 1>(decode, &texels, &x.fraction, &y.fraction, g);
    }
    if needed[2] {
        interpolate::<R, D, 2>(decode, &texels, &x.fraction, &y.fraction, b);
    }
    if needed[3] {
        interpolate::<R, D, 3>(decode, &texels, &x.fraction, &y.fraction, a);
    }
    out
}

/// Channel `K`, interpolated bilinearly between the four texels of each lane (top left, top right, bottom left, bottom right) by the fractions `x` and `y`.
#[inline(always)]
fn interpolate<R: Real, D: Decode, const K: usize>(
    decode: D,
    texels: &[[D::Texel; CHUNK]; 4],
    x: &[R; CHUNK],
    y: &[R; CHUNK],
    out: &mut [R; CHUNK],
) {
    let [top_left, top_right] = [decode.channel_of_each::<K, CHUNK>(&texels[0]), decode.channel_of_each::<K, CHUNK>(&texels[1])];
    let [bottom_left, bottom_right] = [decode.channel_of_each::<K, CHUNK>(&texels[2]), decode.channel_of_each::<K, CHUNK>(&texels[3])];
    let widened = |v: f32| R::from_f32_bits(v.to_bits());
    for i in 0..CHUNK {
        let top = widened(top_left[i]) + x[i] * (widened(top_right[i]) - widened(top_left[i]));
        let bottom = widened(bottom_left[i]) + x[i] * (widened(bottom_right[i]) - widened(bottom_left[i]));
        out[i] = top + y[i] * (bottom - top);
    }
}

/// The texel nearest to a texture coordinate along one axis of `size` texels.
#[inline(always)]
fn nearest_texel<R: Real>(coordinate: R, size: u32, mode: AddressMode) -> u32 {
    let n = R::from_u32(size);
    let x = if mode == AddressMode::Repeat { coordinate - floor(coordinate) } else { coordinate } * n;
    let x = if x > R::ZERO { x } else { R::ZERO };
    let x = if x < n { x } else { n };
    let (rounded, index) = x.round_small();
    (if rounded > x { index.wrapping_sub(1) } else { index }).min(size as i32 - 1) as u32
}

/// All four channels of the texels nearest to a chunk of texture coordinates, whichever the caller needs.
#[inline(always)]
fn nearest<R: Real, D: Decode>(decode: D, level: &TexelLevel<'_>, u: &[R; CHUNK], v: &[R; CHUNK], state: &SamplerState) -> [[R; CHUNK]; 4] {
    let mut index = [0; CHUNK];
    for i in 0..CHUNK {
        let row = nearest_texel(v[i], level.height, state.address_v);
        index[i] = row.wrapping_mul(level.width).wrapping_add(nearest_texel(u[i], level.width, state.address_u));
    }
    // SAFETY: `nearest_texel` clamps both coordinates to the level.
    let texels = unsafe { decode.fetch(level, &index) };
    let mut out = [[R::ZERO; CHUNK]; 4];
    let [r, g, b, a] = &mut out;
    channel::<R, D, 0>(decode, &texels, r);
    channel::<R, D, 1>(decode, &texels, g);
    channel::<R, D, 2>(decode, &texels, b);
    channel::<R, D, 3>(decode, &texels, a);
    out
}

/// Channel `K` of each lane's texel.
#[inline(always)]
fn channel<R: Real, D: Decode, const K: usize>(decode: D, texels: &[D::Texel; CHUNK], out: &mut [R; CHUNK]) {
    for (out, v) in out.iter_mut().zip(decode.channel_of_each::<K, CHUNK>(texels)) {
        *out = R::from_f32_bits(v.to_bits());
    }
}

/// Adds the first `count` lanes of `value` to the sums from position `start` of the lane order on. A chunk that begins in the batch ends in `sum`.
#[inline(always)]
fn add_chunk<R: Real>(sum: &mut [R; PADDED], start: usize, count: usize, value: &[R; CHUNK]) {
    let Some(sum) = sum[start..start + CHUNK].first_chunk_mut::<CHUNK>() else { return };
    for i in 0..CHUNK {
        sum[i] = if i < count { sum[i] + value[i] } else { sum[i] };
    }
}

/// As [`add_chunk`], for each channel that is needed.
#[inline(always)]
fn accumulate<R: Real>(sum: &mut [LazyArray<R>; 4], start: usize, count: usize, value: &[[R; CHUNK]; 4]) {
    for (sum, value) in sum.iter_mut().zip(value) {
        if let Some(sum) = &mut sum.0 {
            add_chunk(sum, start, count, value);
        }
    }
}

/// As [`accumulate`], but each lane's value is multiplied by its weight.
#[inline(always)]
fn accumulate_weighted<R: Real>(sum: &mut [LazyArray<R>; 4], start: usize, count: usize, value: &[[R; CHUNK]; 4], weight: &[R; CHUNK]) {
    let mut weighted = *value;
    for channel in &mut weighted {
        for i in 0..CHUNK {
            channel[i] = weight[i] * channel[i];
        }
    }
    accumulate(sum, start, count, &weighted);
}

#[inline(always)]
fn any_positive<R: Real>(values: &[R; CHUNK]) -> bool {
    let mut any = false;
    for v in values {
        any |= *v > R::ZERO;
    }
    any
}

/// Interpolates between a level and the coarser one. `fraction`: weight of the coarser level, which is `None` if no lane needs it.
#[inline(always)]
fn trilinear<R: Real, D: Decode>(
    decode: D,
    (level, coarser): (TexelLevel<'_>, Option<TexelLevel<'_>>),
    u: &[R; CHUNK],
    v: &[R; CHUNK],
    fraction: &[R; CHUNK],
    state: &SamplerState,
    needed: ChannelMask,
) -> [[R; CHUNK]; 4] {
    let mut value = bilinear(decode, &level, u, v, state, needed);
    if let Some(coarser) = coarser.filter(|_| any_positive(fraction)) {
        let coarser = bilinear(decode, &coarser, u, v, state, needed);
        for ((value, coarser), _) in value.iter_mut().zip(&coarser).zip(needed).filter(|(_, is_needed)| *is_needed) {
            for i in 0..CHUNK {
                // Not mixed at fraction 0, where the lane's result must not depend on a coarser texel that only its neighbours need: 0 times infinity is NaN.
                let mixed = value[i] + fraction[i] * (coarser[i] - value[i]);
                value[i] = if fraction[i] > R::ZERO { mixed } else { value[i] };
            }
        }
    }
    value
}

/// Filters the active lanes of a batch into `out`; the other lanes of `out` are left unchanged. `decode`: decodes the texture's format. `levels`: its mip
/// levels, the finest first, at least one.
#[inline(always)]
pub(crate) fn sample<R: Real, D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    request: &FilterRequest<'_, R>,
    state: &SamplerState,
    active: LaneMask,
    out: Channels<'_, R>,
) {
    let needed = out.each_ref().map(|o| o.is_some());
    let levels = &levels[..levels.len().min(MAX_LEVELS)];
    #[cfg(target_arch = "x86_64")]
    if D::FILTERS_WITH_AVX2
        && state.is_trilinear
        && let Some(request) = filter_avx2::F32Request::new(request)
    {
        let out = out.map(|lanes| R::as_f32_mut(lanes?)?.first_chunk_mut());
        // SAFETY: AVX2 decoders exist only on machines with AVX2.
        return unsafe { filter_avx2::filter(decode, levels, &request, state, active, out) };
    }
    let coarsest_level = R::from_u32(levels.len() as u32 - 1);
    // If not trilinear, the nearest level is read: `floor` after adding 0.5.
    let rounding = if state.is_trilinear { R::ZERO } else { R::from_f64(0.5) };
    // `key`: level * MAX_TAPS + (MAX_TAPS - taps), by which `LaneOrder` sorts.
    let (mut key, mut level_fraction) = ([0_u16; BATCH], [R::ZERO; BATCH]);
    for i in 0..BATCH {
        let level = request.level.as_ref().map_or(R::ZERO, |level| level[i]);
        let level = if level > R::ZERO { level } else { R::ZERO };
        let level = if level < coarsest_level { level } else { coarsest_level };
        // The finer of the two levels between which the lane interpolates; if not trilinear, the nearest level.
        let finer_level = floor(level + rounding);
        let finer_level = if finer_level < coarsest_level { finer_level } else { coarsest_level };
        level_fraction[i] = level - finer_level;
        let tap_count = request.footprints.as_ref().map_or(R::ONE, |footprints| ceil(footprints.length[i]));
        let missing_taps = R::from_u32(MAX_TAPS as u32) - tap_count;
        key[i] = (finer_level * R::from_u32(MAX_TAPS as u32) + missing_taps).round_small().1 as u16;
    }
    let order = LaneOrder::new(&key, active);
    // Lazy, so that arrays that are not needed are not zeroed: together they are as large as all other data of a batch.
    let (mut buffer_u, mut buffer_v, mut buffer_fraction, mut buffer_step_u, mut buffer_step_v, mut buffer_length) =
        (LazyArray::new(), LazyArray::new(), LazyArray::new(), LazyArray::new(), LazyArray::new(), LazyArray::new());
    let (u, v) = (order.gather(request.u, &mut buffer_u), order.gather(request.v, &mut buffer_v));
    if state.is_trilinear && !order.has_several_taps {
        let level_fraction = order.gather(&level_fraction, &mut buffer_fraction);
        let mut out = out;
        for level in order.levels.clone() {
            let (first, end) = order.positions(level);
            if first == end {
                continue;
            }
            let both_levels = read_pair(levels, level, &level_fraction[first..end]);
            for start in (first..end).step_by(CHUNK) {
                let fraction = chunk(level_fraction, start);
                let value = trilinear(decode, both_levels, chunk(u, start), chunk(v, start), fraction, state, needed);
                order.store(&value, start, end - start, &mut out);
            }
        }
        return;
    }
    // Sums in lane order for each needed channel; if not trilinear, each has a single term.
    let mut sum = [LazyArray::new(), LazyArray::new(), LazyArray::new(), LazyArray::new()];
    for (sum, _) in sum.iter_mut().zip(needed).filter(|(_, is_needed)| *is_needed) {
        sum.0 = Some([R::ZERO; PADDED]);
    }
    if !state.is_trilinear {
        for level in order.levels.clone() {
            let (first, end) = order.positions(level);
            if first == end {
                continue;
            }
            let texels = levels[level].read();
            for start in (first..end).step_by(CHUNK) {
                let value = nearest(decode, &texels, chunk(u, start), chunk(v, start), state);
                accumulate(&mut sum, start, end - start, &value);
            }
        }
    } else {
        let level_fraction = order.gather(&level_fraction, &mut buffer_fraction);
        // Without footprints every lane has one tap, which is handled above.
        let Some(Footprints { length, step_u, step_v }) = &request.footprints else { return };
        let (step_u, step_v) = (order.gather(step_u, &mut buffer_step_u), order.gather(step_v, &mut buffer_step_v));
        let length = order.gather(length, &mut buffer_length);
        let mut total_weight = [R::ZERO; PADDED];
        for level in order.levels.clone() {
            let (first, end) = order.positions(level);
            if first == end {
                continue;
            }
            let both_levels = read_pair(levels, level, &level_fraction[first..end]);
            for tap in 0..MAX_TAPS {
                // Lanes with more than `tap` taps come first. Those that have exactly `tap` taps, if any, begin where the key is this index.
                let tap_end = usize::from(order.starts[(level + 1) * MAX_TAPS - tap]);
                if tap_end == first {
                    break;
                }
                for start in (first..tap_end).step_by(CHUNK) {
                    let (mut tap_u, mut tap_v) = (*chunk(u, start), *chunk(v, start));
                    let (step_u, step_v) = (chunk(step_u, start), chunk(step_v, start));
                    // `along`: from the middle of the footprint, in steps.
                    let (along, weight) = taps(tap, chunk(length, start));
                    for i in 0..CHUNK {
                        tap_u[i] = tap_u[i] + along[i] * step_u[i];
                        tap_v[i] = tap_v[i] + along[i] * step_v[i];
                    }
                    let value = trilinear(decode, both_levels, &tap_u, &tap_v, chunk(level_fraction, start), state, needed);
                    accumulate_weighted(&mut sum, start, tap_end - start, &value, &weight);
                    add_chunk(&mut total_weight, start, tap_end - start, &weight);
                }
            }
        }
        for sum in sum.iter_mut().filter_map(|sum| sum.0.as_mut()) {
            // NaN at the positions after the last active lane, which `scatter` does not read.
            for (sum, total) in sum.iter_mut().zip(&total_weight) {
                *sum = *sum / *total;
            }
        }
    }
    for (out, sum) in out.into_iter().zip(&sum) {
        if let (Some(out), Some(sum)) = (out, &sum.0) {
            order.scatter(sum, out);
        }
    }
}
