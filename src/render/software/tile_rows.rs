//! Writes a resolved tile into the rows of an image, block by block, because a converted block stays in the L1 cache.
//!
//! In: a tile, and the part of each of its rows that lies inside the image. Out: these rows, with every pixel written. Always: a block that was not drawn
//! has one colour, which is converted once.

use super::raster::coverage::{self, BLOCK_PIXELS, TILE_BLOCKS, block_position};
use super::tiles::TileTarget;
use super::tone_map::{BlockRows, ToneMapUniforms};
use std::mem::MaybeUninit;

const BLOCK_WIDTH: usize = coverage::BLOCK_WIDTH as usize;
const BLOCK_HEIGHT: usize = coverage::BLOCK_HEIGHT as usize;

/// `rows[y]` is the part of the tile's row `y` that lies inside the image.
pub(super) type TileRows<'a, 'b, T> = &'a mut [&'b mut [MaybeUninit<T>]];

/// Converts values of 0 to 1 to bytes, rounding to nearest, ties to even; values out of range are clamped, and NaN becomes 0. Avoids `as u8`, whose
/// saturation would keep loops from being vectorised.
#[inline(always)]
pub(crate) fn unorm8(colour: [f32; 4]) -> [u8; 4] {
    let byte = |v: f32| {
        let v = if v > 0.0 { v } else { 0.0 };
        let v = if v < 1.0 { v } else { 1.0 };
        // Adding 1.5 * 2^23 leaves the rounded integer in the low bits.
        (v * 255.0 + 12_582_912.0).to_bits() & 0xff
    };
    (byte(colour[0]) | byte(colour[1]) << 8 | byte(colour[2]) << 16 | byte(colour[3]) << 24).to_le_bytes()
}

/// Writes a block's pixels, given in lane order ([`coverage`]). Here and below, `[x0, y0]` is the block's top-left pixel inside the tile.
#[inline(always)]
fn place_block<T: Copy>(rows: TileRows<'_, '_, T>, [x0, y0]: [usize; 2], pixels: &[T; BLOCK_PIXELS]) {
    // The pixels of a quad are two pairs, one in each of two rows.
    let (pairs, _) = pixels.as_chunks::<2>();
    for (y, row) in rows.iter_mut().skip(y0).take(BLOCK_HEIGHT).enumerate() {
        let Some(pairs_of_two_rows) = pairs[y / 2 * BLOCK_WIDTH..].first_chunk::<BLOCK_WIDTH>() else { continue };
        match row.get_mut(x0..).and_then(|row| row.first_chunk_mut::<BLOCK_WIDTH>()) {
            Some(target) => {
                for (target, pairs_of_quad) in target.as_chunks_mut::<2>().0.iter_mut().zip(pairs_of_two_rows.as_chunks::<2>().0) {
                    *target = pairs_of_quad[y % 2].map(MaybeUninit::new);
                }
            }
            // The last columns, if the width is not a multiple of a block's width.
            None => {
                let row_pixels = pairs_of_two_rows.iter().skip(y % 2).step_by(2).flatten();
                row.iter_mut().skip(x0).zip(row_pixels).for_each(|(target, pixel)| *target = MaybeUninit::new(*pixel));
            }
        }
    }
}

/// Writes a block's pixels, given row by row as little-endian words of four display bytes.
#[inline(always)]
fn place_block_rows(rows: TileRows<'_, '_, [u8; 4]>, [x0, y0]: [usize; 2], words: &BlockRows) {
    for (row, words) in rows.iter_mut().skip(y0).zip(words) {
        let pixels = words.map(|word| MaybeUninit::new(word.to_le_bytes()));
        match row.get_mut(x0..).and_then(|row| row.first_chunk_mut::<BLOCK_WIDTH>()) {
            Some(target) => *target = pixels,
            // The last columns, if the width is not a multiple of a block's width.
            None => row.iter_mut().skip(x0).zip(pixels).for_each(|(target, pixel)| *target = pixel),
        }
    }
}

/// Fills a block with one value.
#[inline(always)]
fn fill_block<T: Copy>(rows: TileRows<'_, '_, T>, [x0, y0]: [usize; 2], value: T) {
    for row in rows.iter_mut().skip(y0).take(BLOCK_HEIGHT) {
        match row.get_mut(x0..).and_then(|row| row.first_chunk_mut::<BLOCK_WIDTH>()) {
            Some(target) => *target = [MaybeUninit::new(value); BLOCK_WIDTH],
            None => row.iter_mut().skip(x0).for_each(|target| *target = MaybeUninit::new(value)),
        }
    }
}

/// Writes two rows of a block's pixels, given the channels of the eight quads that make up the two rows.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn interleave_avx2(channels: [&[f32; 2 * BLOCK_WIDTH]; 4], rows: [&mut [MaybeUninit<[f32; 4]>; BLOCK_WIDTH]; 2]) {
    use std::arch::x86_64::{
        __m256, _mm256_loadu_ps, _mm256_permute2f128_ps, _mm256_shuffle_ps, _mm256_storeu_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
    };
    let [upper, lower] = rows.map(|row| row.as_chunks_mut::<4>().0);
    // Two quads at a time.
    for (k, (upper, lower)) in upper.iter_mut().zip(lower).enumerate() {
        let [r, g, b, a] = channels.map(|channel| {
            let lanes: &[f32; 8] = &channel.as_chunks::<8>().0[k];
            // SAFETY: eight floats are read from a reference to eight floats.
            unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
        });
        // In each register, the lower half belongs to the first quad and the upper half to the second.
        let (rg_01, rg_23, ba_01, ba_23) =
            (_mm256_unpacklo_ps(r, g), _mm256_unpackhi_ps(r, g), _mm256_unpacklo_ps(b, a), _mm256_unpackhi_ps(b, a));
        let pixels_of_row = |rg: __m256, ba: __m256| {
            let (left, right) = (_mm256_shuffle_ps::<0b01_00_01_00>(rg, ba), _mm256_shuffle_ps::<0b11_10_11_10>(rg, ba));
            [_mm256_permute2f128_ps::<0x20>(left, right), _mm256_permute2f128_ps::<0x31>(left, right)]
        };
        for (to, pixels) in [(upper, pixels_of_row(rg_01, ba_01)), (lower, pixels_of_row(rg_23, ba_23))] {
            let (pairs, _) = to.as_chunks_mut::<2>();
            for (pair, pixels) in pairs.iter_mut().zip(pixels) {
                // SAFETY: a pair of pixels is eight floats.
                unsafe { _mm256_storeu_ps(pair.as_mut_ptr().cast(), pixels) };
            }
        }
    }
}

impl TileTarget {
    /// Writes every pixel of a resolved tile, converted by `convert`.
    pub(crate) fn write_converted<T: Copy>(&self, rows: TileRows<'_, '_, T>, convert: impl Fn([f32; 4]) -> T) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.write_converted_avx2(rows, convert) };
        }
        self.write_converted_generic(rows, convert);
    }

    /// [`TileTarget::write_converted_generic`] compiled for AVX2: wider vectors, the same rounding.
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn write_converted_avx2<T: Copy>(&self, rows: TileRows<'_, '_, T>, convert: impl Fn([f32; 4]) -> T) {
        self.write_converted_generic(rows, convert);
    }

    #[inline(always)]
    fn write_converted_generic<T: Copy>(&self, rows: TileRows<'_, '_, T>, convert: impl Fn([f32; 4]) -> T) {
        let clear_value = convert(self.clear_colour());
        let mut converted = [clear_value; BLOCK_PIXELS];
        for block in 0..TILE_BLOCKS {
            let [x0, y0] = block_position(block).map(|v| v as usize);
            let Some([r, g, b, a]) = self.block(block).filter(|_| y0 < rows.len()) else { continue };
            if !self.is_written(block) {
                fill_block(rows, [x0, y0], clear_value);
                continue;
            }
            for ((((to, r), g), b), a) in converted.iter_mut().zip(r).zip(g).zip(b).zip(a) {
                *to = convert([*r, *g, *b, *a]);
            }
            place_block(rows, [x0, y0], &converted);
        }
    }

    /// Writes every pixel of a resolved tile of linear light, as [`TileTarget::write_converted`] without a conversion.
    pub(crate) fn write_linear(&self, rows: TileRows<'_, '_, [f32; 4]>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.write_linear_avx2(rows) };
        }
        self.write_converted_generic(rows, |colour| colour);
    }

    /// [`TileTarget::write_linear`] with AVX2: transposes channels into pixels in registers. In `write_converted_generic`, the compiler copies each pixel to
    /// the stack and back.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn write_linear_avx2(&self, rows: TileRows<'_, '_, [f32; 4]>) {
        let clear_value = self.clear_colour();
        for block in 0..TILE_BLOCKS {
            let [x0, y0] = block_position(block).map(|v| v as usize);
            let Some(channels) = self.block(block).filter(|_| y0 < rows.len()) else { continue };
            if !self.is_written(block) {
                fill_block(rows, [x0, y0], clear_value);
                continue;
            }
            let is_inside = y0 + BLOCK_HEIGHT <= rows.len() && x0 + BLOCK_WIDTH <= rows[y0].len();
            if is_inside {
                for (quad_row, pair) in rows[y0..y0 + BLOCK_HEIGHT].as_chunks_mut::<2>().0.iter_mut().enumerate() {
                    let from = quad_row * 2 * BLOCK_WIDTH;
                    let lanes = channels.map(|channel| channel[from..].first_chunk::<{ 2 * BLOCK_WIDTH }>());
                    let [upper, lower] = pair.each_mut().map(|row| row[x0..].first_chunk_mut::<BLOCK_WIDTH>());
                    if let ([Some(r), Some(g), Some(b), Some(a)], Some(upper), Some(lower)) = (lanes, upper, lower) {
                        interleave_avx2([r, g, b, a], [upper, lower]);
                    }
                }
            } else {
                let [r, g, b, a] = channels;
                place_block(rows, [x0, y0], &std::array::from_fn(|k| [r[k], g[k], b[k], a[k]]));
            }
        }
    }

    /// Writes the display bytes of every pixel of a resolved tile of linear light. `clear_bytes`: the display bytes of the clear colour.
    pub(super) fn write_tone_mapped(&self, rows: TileRows<'_, '_, [u8; 4]>, tone_map: &ToneMapUniforms, clear_bytes: [u8; 4]) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.write_tone_mapped_avx2(rows, tone_map, clear_bytes) };
        }
        self.write_tone_mapped_generic(rows, tone_map, clear_bytes);
    }

    /// [`TileTarget::write_tone_mapped`] with AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn write_tone_mapped_avx2(&self, rows: TileRows<'_, '_, [u8; 4]>, tone_map: &ToneMapUniforms, clear_bytes: [u8; 4]) {
        let mut words = BlockRows::default();
        for block in 0..TILE_BLOCKS {
            if let Some(light) = self.light_or_fill(block, rows, clear_bytes) {
                tone_map.map_rows_avx2(light, &mut words);
                place_block_rows(rows, block_position(block).map(|v| v as usize), &words);
            }
        }
    }

    /// [`TileTarget::write_tone_mapped`] without special instructions.
    fn write_tone_mapped_generic(&self, rows: TileRows<'_, '_, [u8; 4]>, tone_map: &ToneMapUniforms, clear_bytes: [u8; 4]) {
        let mut words = BlockRows::default();
        for block in 0..TILE_BLOCKS {
            if let Some(light) = self.light_or_fill(block, rows, clear_bytes) {
                tone_map.map_rows_generic(light, &mut words);
                place_block_rows(rows, block_position(block).map(|v| v as usize), &words);
            }
        }
    }

    /// Red, green and blue of a block that was written. Any other block is filled with `clear_bytes`, if it is inside the image, and gives `None`.
    #[inline(always)]
    fn light_or_fill(&self, block: usize, rows: TileRows<'_, '_, [u8; 4]>, clear_bytes: [u8; 4]) -> Option<[&[f32; BLOCK_PIXELS]; 3]> {
        let corner = block_position(block).map(|v| v as usize);
        if corner[1] >= rows.len() {
            return None;
        }
        if !self.is_written(block) {
            fill_block(rows, corner, clear_bytes);
            return None;
        }
        let [r, g, b, _] = self.block(block)?;
        Some([r, g, b])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::plan::Blend;

    /// The image has the pixels that were drawn, and the clear colour in the one block on which nothing was drawn.
    #[test]
    fn every_pixel_is_written_where_it_belongs() {
        const UNDRAWN_BLOCK: usize = 9;
        let pixels = coverage::PixelCentres::new();
        let mut t = TileTarget::new(1);
        let clear = [-1.0, -2.0, -3.0, -4.0];
        let uses_depth = false;
        t.clear(clear, uses_depth);
        for (p, (x, y)) in pixels.x.iter().zip(&pixels.y).enumerate().filter(|(p, _)| p / BLOCK_PIXELS != UNDRAWN_BLOCK) {
            let covered = 1;
            t.store(p, covered, Blend::Replace, [*x, *y, p as f32, -*x]);
        }
        let [undrawn_x, undrawn_y] = block_position(UNDRAWN_BLOCK).map(|v| v as usize);
        for (width, height) in [(64, 64), (33, 64), (64, 9), (1, 1), (50, 47)] {
            let mut image = vec![MaybeUninit::uninit(); width * height];
            t.write_linear(&mut image.chunks_mut(width).collect::<Vec<_>>());
            for (k, pixel) in image.into_iter().enumerate() {
                // SAFETY: every pixel has been written.
                let colour = unsafe { pixel.assume_init() };
                let (column, row) = (k % width, k / width);
                let is_undrawn =
                    (undrawn_x..undrawn_x + BLOCK_WIDTH).contains(&column) && (undrawn_y..undrawn_y + BLOCK_HEIGHT).contains(&row);
                let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
                let lane = pixels.x.iter().zip(&pixels.y).position(|p| p == (&x, &y)).expect("a lane");
                let expected = if is_undrawn { clear } else { [x, y, lane as f32, -x] };
                assert_eq!(colour, expected, "{width}x{height}: {column}, {row}");
            }
        }
    }

    #[test]
    fn bytes_round_to_nearest() {
        assert_eq!(unorm8([0.0, 1.0, 0.5, 2.0]), [0, 255, 128, 255]);
        assert_eq!(unorm8([-1.0, f32::NAN, f32::INFINITY, -0.0]), [0, 0, 255, 0]);
        for byte in 0..=255_u8 {
            let [below, at, above] = [-0.49, 0.0, 0.49].map(|d| (f32::from(byte) + d) / 255.0);
            assert_eq!(unorm8([below, at, above, 0.0]), [byte, byte, byte, 0]);
        }
    }
}
