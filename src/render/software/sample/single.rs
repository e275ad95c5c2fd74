//! Reads single texels by integer coordinates, a batch at a time.
//!
//! In: a column for each lane; a row and a level, each either per lane or common to all lanes. Out: up to four channels per lane; zero if the lane is
//! not active or its texel lies outside the level. Always: every kernel class gives the same bits. If all lanes read the same level, they are read
//! without a branch, with gather instructions if the class has them; otherwise lane by lane.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::filter::{BATCH, Channels};
use super::full_batch;
use super::texels::{Decode, TexelLevel};
use crate::render::software::exec::{LANE_BITS, LaneMask};
use crate::render::software::math::Real;

/// Columns, rows and levels as bit-cast integers. Rows and levels have one value for each lane, or one for all lanes.
pub(super) type TexelCoordinates<'a, R> = [&'a [R]; 3];

/// Lanes that are read together.
const CHUNK: usize = 8;

/// Reads the texels of a batch. `out`: red, green, blue, alpha, each either empty or as long as `x`.
#[inline(always)]
pub(super) fn load<R: Real, D: Decode>(
    decode: D,
    levels: &[TexelLevel<'_>],
    [x, y, level]: TexelCoordinates<'_, R>,
    active: LaneMask,
    mut out: [&mut [R]; 4],
) {
    let count = x.len().min(BATCH);
    let (Some(row), Some(first_level)) = (y.first(), level.first().map(|l| l.lane_bits())) else { return };
    if level.iter().fold(0, |differing_bits, l| differing_bits | (l.lane_bits() ^ first_level)) != 0 {
        return load_lane_by_lane(decode, levels, [x, y, level], active, out);
    }
    let Some(level) = levels.get(first_level as usize) else { return out.iter_mut().for_each(|lanes| lanes.fill(R::ZERO)) };
    let active = if count == BATCH { active } else { active & ((1 << count) - 1) };
    let [mut column_buffer, mut row_buffer] = [const { None }; 2];
    let x = full_batch(x, &mut column_buffer);
    let indices = if y.len() == 1 {
        let row = row.lane_bits();
        TexelIndices::new(level, x, |_| row, active)
    } else {
        let y = full_batch(y, &mut row_buffer);
        TexelIndices::new(level, x, |lane| y[lane].lane_bits(), active)
    };
    if count == BATCH {
        return indices.read(decode, level, out.map(|lanes| lanes.first_chunk_mut()));
    }
    let mut read = [[R::ZERO; BATCH]; 4];
    indices.read(decode, level, read.each_mut().map(Some));
    for (out, read) in out.into_iter().zip(&read) {
        let count = count.min(out.len());
        out[..count].copy_from_slice(&read[..count]);
    }
}

/// The positions of a batch's texels in one level. A lane has a texel if it is active and its coordinates lie inside the level.
struct TexelIndices {
    /// Index of a lane's texel; 0 if the lane has none.
    index: [u32; BATCH],
    /// All bits set if the lane has a texel, else zero.
    mask: [u32; BATCH],
    /// Whether every lane has a texel.
    is_complete: bool,
}

impl TexelIndices {
    #[inline(always)]
    fn new<R: Real>(level: &TexelLevel<'_>, x: &[R; BATCH], row: impl Fn(usize) -> u32, active: LaneMask) -> Self {
        let (width, height) = (level.width, level.height);
        let mut indices = Self { index: [0; BATCH], mask: [u32::MAX; BATCH], is_complete: false };
        if active != LaneMask::MAX {
            for (k, masks) in indices.mask.as_chunks_mut::<{ LANE_BITS.len() }>().0.iter_mut().enumerate() {
                let active = (active >> (k * LANE_BITS.len())) as u32;
                for (mask, bit) in masks.iter_mut().zip(&LANE_BITS) {
                    *mask = if active & bit != 0 { u32::MAX } else { 0 };
                }
            }
        }
        // The loop has a fixed length and no bounds checks, so that it is vectorised.
        let mut mask_of_all = u32::MAX;
        for lane in 0..BATCH {
            let (column, row) = (x[lane].lane_bits(), row(lane));
            // A negative coordinate is a large u32, hence outside.
            let inside = if (column < width) & (row < height) { u32::MAX } else { 0 };
            let mask = indices.mask[lane] & inside;
            indices.index[lane] = row.wrapping_mul(width).wrapping_add(column) & mask;
            indices.mask[lane] = mask;
            mask_of_all &= mask;
        }
        indices.is_complete = mask_of_all == u32::MAX;
        indices
    }

    #[inline(always)]
    fn read<R: Real, D: Decode>(&self, decode: D, level: &TexelLevel<'_>, out: Channels<'_, R>) {
        if self.is_complete {
            self.read_masked::<R, D, false>(decode, level, out);
        } else {
            self.read_masked::<R, D, true>(decode, level, out);
        }
    }

    /// `MASKED`: some lanes have no texel and are set to zero.
    #[inline(always)]
    fn read_masked<R: Real, D: Decode, const MASKED: bool>(&self, decode: D, level: &TexelLevel<'_>, out: Channels<'_, R>) {
        let [r, g, b, a] = out;
        if [&r, &g, &b, &a].into_iter().flatten().count() <= D::MAX_SEPARATE_CHANNELS {
            self.read_channel::<R, D, 0, MASKED>(decode, level, r);
            self.read_channel::<R, D, 1, MASKED>(decode, level, g);
            self.read_channel::<R, D, 2, MASKED>(decode, level, b);
            self.read_channel::<R, D, 3, MASKED>(decode, level, a);
            return;
        }
        let mut out = [r, g, b, a];
        for (k, index) in self.index.as_chunks::<CHUNK>().0.iter().enumerate() {
            // SAFETY: `new` keeps indices inside the level.
            let [r, g, b, a] = unsafe { decode.channels_of_eight(level, index) };
            let [to_r, to_g, to_b, to_a] = &mut out;
            self.write::<R, MASKED>(to_r, k, &r);
            self.write::<R, MASKED>(to_g, k, &g);
            self.write::<R, MASKED>(to_b, k, &b);
            self.write::<R, MASKED>(to_a, k, &a);
        }
    }

    #[inline(always)]
    fn read_channel<R: Real, D: Decode, const K: usize, const MASKED: bool>(
        &self,
        decode: D,
        level: &TexelLevel<'_>,
        out: Option<&mut [R; BATCH]>,
    ) {
        let mut out = out;
        if out.is_none() {
            return;
        }
        for (k, index) in self.index.as_chunks::<CHUNK>().0.iter().enumerate() {
            // SAFETY: `new` keeps indices inside the level.
            let values = unsafe { decode.channel_of_eight::<K>(level, index) };
            self.write::<R, MASKED>(&mut out, k, &values);
        }
    }

    /// Writes one channel of chunk `k`, if it is needed.
    #[inline(always)]
    fn write<R: Real, const MASKED: bool>(&self, out: &mut Option<&mut [R; BATCH]>, k: usize, values: &[f32; CHUNK]) {
        let Some(to) = out.as_mut().and_then(|out| out.as_chunks_mut::<CHUNK>().0.get_mut(k)) else { return };
        let Some(mask) = self.mask.as_chunks::<CHUNK>().0.get(k) else { return };
        for i in 0..CHUNK {
            let bits = values[i].to_bits();
            to[i] = R::from_f32_bits(if MASKED { bits & mask[i] } else { bits });
        }
    }
}

/// Reads texels of several levels.
#[inline(always)]
fn load_lane_by_lane<R: Real, D: Decode>(
    decode: D,
    levels: &[TexelLevel<'_>],
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
                decode.texel(level, y * level.width + x)
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
