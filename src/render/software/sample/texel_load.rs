//! Reads single texels by integer coordinates, a batch at a time.
//!
//! In: a column for each lane; a row and a level, each either per lane or common to all lanes. Out: up to four channels per lane; zero if the lane is
//! not active or its texel lies outside the level. Always: every kernel class gives the same bits. If all lanes read the same level, their texels
//! are loaded without a branch, with gather instructions if the class has them; otherwise lane by lane.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::filter::{BATCH, Channels};
use super::full_batch;
use super::texels::{BoundLevel, Decode, TexelLevel};
use crate::render::software::exec::{LANE_BITS, LaneMask};
use crate::render::software::math::Real;

/// Columns, rows and levels (`x`, `y`, `level`) as bit-cast integers. Rows and levels have one value for each lane, or one for all lanes.
pub(super) type TexelCoordinates<'a, R> = [&'a [R]; 3];

/// Number of lanes that are read together.
const GROUP_LANES: usize = 8;

/// Loads the texels of a batch. `out`: red, green, blue, alpha, each either empty or as long as `x`.
#[inline(always)]
pub(super) fn load<R: Real, D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    [x, y, level]: TexelCoordinates<'_, R>,
    active: LaneMask,
    mut out: [&mut [R]; 4],
) {
    let count = x.len().min(BATCH);
    let (Some(first_row), Some(first_level)) = (y.first(), level.first().map(|l| l.lane_bits())) else { return };
    if level.iter().fold(0, |differing_bits, l| differing_bits | (l.lane_bits() ^ first_level)) != 0 {
        return load_lane_by_lane(decode, levels, [x, y, level], active, out);
    }
    let Some(level) = levels.get(first_level as usize) else { return out.iter_mut().for_each(|lanes| lanes.fill(R::ZERO)) };
    let active = if count == BATCH { active } else { active & ((1 << count) - 1) };
    let level = &level.read();
    // The buffers are separate variables, because an array of buffers would be zeroed at each call.
    let (mut column_buffer, mut row_buffer) = (None, None);
    let x = full_batch(x, &mut column_buffer);
    // `find_texels` fills these arrays in place: if it returned them, they would be copied.
    let (mut index, mut mask) = ([0; BATCH], [u32::MAX; BATCH]);
    if active != LaneMask::MAX {
        for (k, masks) in mask.as_chunks_mut::<{ LANE_BITS.len() }>().0.iter_mut().enumerate() {
            let active = (active >> (k * LANE_BITS.len())) as u32;
            for (mask, bit) in masks.iter_mut().zip(&LANE_BITS) {
                *mask = if active & bit != 0 { u32::MAX } else { 0 };
            }
        }
    }
    let all_lanes_have_texels = if y.len() == 1 {
        let row = first_row.lane_bits();
        find_texels(level, x, |_| row, &mut index, &mut mask)
    } else {
        let y = full_batch(y, &mut row_buffer);
        find_texels(level, x, |lane| y[lane].lane_bits(), &mut index, &mut mask)
    };
    if count == BATCH {
        let out = out.each_mut().map(|lanes| lanes.first_chunk_mut());
        return if all_lanes_have_texels {
            read_texels::<R, D, false>(decode, level, &index, &mask, out)
        } else {
            read_texels::<R, D, true>(decode, level, &index, &mask, out)
        };
    }
    let mut read = [[R::ZERO; BATCH]; 4];
    read_texels::<R, D, true>(decode, level, &index, &mask, read.each_mut().map(Some));
    for (out, read) in out.into_iter().zip(&read) {
        let count = count.min(out.len());
        out[..count].copy_from_slice(&read[..count]);
    }
}

/// Finds the index of each lane's texel in one level. A lane has a texel if its `mask` is set and its coordinates lie inside the level; otherwise its
/// mask is cleared and its index is 0. Returns whether all lanes have a texel.
#[inline(always)]
fn find_texels<R: Real>(
    level: &TexelLevel<'_>,
    x: &[R; BATCH],
    row: impl Fn(usize) -> u32,
    index: &mut [u32; BATCH],
    mask: &mut [u32; BATCH],
) -> bool {
    let (width, height) = (level.width, level.height);
    // The loop has a fixed length and no bounds checks, so that it is vectorised.
    let mut mask_of_all = u32::MAX;
    for lane in 0..BATCH {
        let (column, row) = (x[lane].lane_bits(), row(lane));
        // A negative coordinate is a large u32, hence outside.
        let inside = if (column < width) & (row < height) { u32::MAX } else { 0 };
        mask[lane] &= inside;
        index[lane] = row.wrapping_mul(width).wrapping_add(column) & mask[lane];
        mask_of_all &= mask[lane];
    }
    mask_of_all == u32::MAX
}

/// Reads the texels at `index`, each inside the level. `MASKED`: lanes whose mask is zero are set to zero.
#[inline(always)]
fn read_texels<R: Real, D: Decode, const MASKED: bool>(
    decode: D,
    level: &TexelLevel<'_>,
    index: &[u32; BATCH],
    mask: &[u32; BATCH],
    out: Channels<'_, R>,
) {
    let chunks = index.as_chunks::<GROUP_LANES>().0.iter().zip(mask.as_chunks::<GROUP_LANES>().0);
    match out {
        // The usual cases, without a test of each channel for each chunk.
        [Some(r), Some(g), Some(b), Some(a)] => {
            let [r, g, b, a] = [r, g, b, a].map(|lanes| lanes.as_chunks_mut::<GROUP_LANES>().0);
            for (((((index, mask), to_r), to_g), to_b), to_a) in chunks.zip(r).zip(g).zip(b).zip(a) {
                // SAFETY: `find_texels` keeps indices inside the level. (If `MASKED`, `channels_of_eight` masks the values, so that `write` need not.)
                let [r, g, b, a] = unsafe { decode.channels_of_eight::<MASKED>(level, index, mask) };
                write::<R, false>(to_r, &r, mask);
                write::<R, false>(to_g, &g, mask);
                write::<R, false>(to_b, &b, mask);
                write::<R, false>(to_a, &a, mask);
            }
        }
        [Some(r), Some(g), Some(b), None] => {
            let [r, g, b] = [r, g, b].map(|lanes| lanes.as_chunks_mut::<GROUP_LANES>().0);
            for ((((index, mask), to_r), to_g), to_b) in chunks.zip(r).zip(g).zip(b) {
                // SAFETY: as above.
                let [r, g, b, _] = unsafe { decode.channels_of_eight::<MASKED>(level, index, mask) };
                write::<R, false>(to_r, &r, mask);
                write::<R, false>(to_g, &g, mask);
                write::<R, false>(to_b, &b, mask);
            }
        }
        [r, g, b, a] => {
            if [&r, &g, &b, &a].into_iter().flatten().count() <= D::MAX_SEPARATE_CHANNELS {
                read_channel::<R, D, 0, MASKED>(decode, level, index, mask, r);
                read_channel::<R, D, 1, MASKED>(decode, level, index, mask, g);
                read_channel::<R, D, 2, MASKED>(decode, level, index, mask, b);
                read_channel::<R, D, 3, MASKED>(decode, level, index, mask, a);
                return;
            }
            let mut out = [r, g, b, a];
            for (k, (index, mask)) in chunks.enumerate() {
                // SAFETY: as above.
                let values = unsafe { decode.channels_of_eight::<MASKED>(level, index, mask) };
                for (out, values) in out.iter_mut().zip(&values) {
                    if let Some(to) = out.as_mut().and_then(|out| out.as_chunks_mut::<GROUP_LANES>().0.get_mut(k)) {
                        write::<R, false>(to, values, mask);
                    }
                }
            }
        }
    }
}

/// As [`read_texels`], for channel `K` alone.
#[inline(always)]
fn read_channel<R: Real, D: Decode, const K: usize, const MASKED: bool>(
    decode: D,
    level: &TexelLevel<'_>,
    index: &[u32; BATCH],
    mask: &[u32; BATCH],
    out: Option<&mut [R; BATCH]>,
) {
    let Some(out) = out else { return };
    let chunks = index.as_chunks::<GROUP_LANES>().0.iter().zip(mask.as_chunks::<GROUP_LANES>().0);
    for (to, (index, mask)) in out.as_chunks_mut::<GROUP_LANES>().0.iter_mut().zip(chunks) {
        // SAFETY: `find_texels` keeps indices inside the level.
        let values = unsafe { decode.channel_of_eight::<K>(level, index) };
        write::<R, MASKED>(to, &values, mask);
    }
}

/// Writes values of eight lanes; if `MASKED`, zero where the mask is zero.
#[inline(always)]
fn write<R: Real, const MASKED: bool>(to: &mut [R; GROUP_LANES], values: &[f32; GROUP_LANES], mask: &[u32; GROUP_LANES]) {
    for i in 0..GROUP_LANES {
        let bits = values[i].to_bits();
        to[i] = R::from_f32_bits(if MASKED { bits & mask[i] } else { bits });
    }
}

/// Loads texels whose level differs between lanes.
#[inline(always)]
fn load_lane_by_lane<R: Real, D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    [x, y, level]: TexelCoordinates<'_, R>,
    active: LaneMask,
    out: [&mut [R]; 4],
) {
    let [r, g, b, a] = out;
    for (lane, (x, level)) in x.iter().zip(level).enumerate().take(BATCH) {
        let (x, y) = (x.lane_bits(), y[if y.len() == 1 { 0 } else { lane }].lane_bits());
        let texel = match levels.get(level.lane_bits() as usize) {
            // SAFETY: both coordinates lie inside the level.
            Some(level) if active >> lane & 1 == 1 && x < level.width && y < level.height => unsafe {
                decode.texel(&level.read(), y * level.width + x)
            },
            _ => D::Texel::default(),
        };
        for (to, channel) in [&mut *r, &mut *g, &mut *b, &mut *a].into_iter().zip(decode.channels(texel)) {
            if let Some(to) = to.get_mut(lane) {
                *to = R::from_f32_bits(channel.to_bits());
            }
        }
    }
}
