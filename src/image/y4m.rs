//! Writes finished frames as YUV4MPEG2, for a video encoder.
//!
//! In: rows of display bytes, top first. Out: BT.709 luma and chroma in limited range (Y 16..235, C 16..240), one plane after the other, 4:4:4; alpha is
//! ignored. Always: a level is the exact value rounded to nearest, unless the exact value lies within 2e-5 of half-way between two levels; grey has no chroma.

use super::ImageError;
use crate::units::LUMINANCE_WEIGHTS;
use std::io::Write;

/// Starts a YUV4MPEG2 stream with 4:4:4 chroma, with so many `frames` in so many `seconds`. It has no texts, because x264 and older versions of ffmpeg refuse a
/// stream whose first line is longer than 80 bytes.
pub fn write_y4m_header(out: &mut impl Write, width: u32, height: u32, [frames, seconds]: [u32; 2]) -> Result<(), ImageError> {
    writeln!(out, "YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C444 XCOLORRANGE=LIMITED")
        .map_err(|e| ImageError::Write(e.to_string()))
}

const FRAME_HEADER: &[u8] = b"FRAME\n";
/// Pixels that are converted together.
const BLOCK_PIXELS: usize = 128;
/// Number of fraction bits of the fixed-point numbers. Every sum is at least 0 and less than 256, so it fits in 31 bits.
const FRACTION_BITS: u32 = 23;

/// A value in fixed point, rounded.
const fn to_fixed_point(value: f64) -> i32 {
    let scaled = value * (1 << FRACTION_BITS) as f64;
    (scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// Luma: three factors, on red, green and blue from 0 to 255; then the offset: the level 16 of black, and half a level for rounding.
const LUMA: [i32; 4] = {
    let [r, g, b] = LUMINANCE_WEIGHTS;
    let scale = 219.0 / 255.0;
    [to_fixed_point(scale * r), to_fixed_point(scale * g), to_fixed_point(scale * b), to_fixed_point(16.5)]
};

/// Factors and offset of a chroma component: channel `own` (0: red, 2: blue) minus luma, divided by `divisor`. The factors add up to exactly zero, so
/// that grey has no chroma. The offset is the level 128 of no chroma, and half a level for rounding.
const fn chroma(own: usize, divisor: f64) -> [i32; 4] {
    let scale = 224.0 / 255.0 / divisor;
    // Of red and blue, the one that is not `own`.
    let other = 2 - own;
    let mut factors = [0; 4];
    factors[own] = to_fixed_point(scale * (1.0 - LUMINANCE_WEIGHTS[own]));
    factors[other] = to_fixed_point(-scale * LUMINANCE_WEIGHTS[other]);
    factors[1] = -factors[0] - factors[2];
    factors[3] = to_fixed_point(128.5);
    factors
}

/// Factors and offsets of Y, Cb and Cr. BT.709 divides B - Y by 1.8556 and R - Y by 1.5748.
const PLANE_FACTORS: [[i32; 4]; 3] = [LUMA, chroma(2, 1.8556), chroma(0, 1.5748)];

/// One component (Y, Cb or Cr) of a pixel. `word`: the pixel's bytes red, green, blue and alpha, red in the lowest.
#[inline(always)]
fn level([red, green, blue, offset]: [i32; 4], word: u32) -> u8 {
    let [r, g, b] = [word, word >> 8, word >> 16].map(|v| (v & 0xff) as i32);
    let sum = red.wrapping_mul(r).wrapping_add(green.wrapping_mul(g)).wrapping_add(blue.wrapping_mul(b)).wrapping_add(offset);
    (sum >> FRACTION_BITS) as u8
}

/// What the pixels of a block have in common.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    OneColour,
    Grey,
    Any,
}

impl Content {
    #[inline(always)]
    fn of(pixels: &[[u8; 4]; BLOCK_PIXELS]) -> Self {
        const RGB: u32 = 0xff_ffff;
        let [first, last] = [pixels[0], pixels[BLOCK_PIXELS - 1]].map(u32::from_le_bytes);
        // For most blocks, the first and the last pixel already differ.
        if (first ^ last) & RGB == 0 && pixels.iter().fold(0, |bits, p| bits | (u32::from_le_bytes(*p) ^ first)) & RGB == 0 {
            return Self::OneColour;
        }
        // Red differs from green in the low byte, green from blue in the next.
        let channel_differences = pixels.iter().map(|p| u32::from_le_bytes(*p)).fold(0, |bits, word| bits | (word ^ (word >> 8)));
        if channel_differences & 0xffff == 0 { Self::Grey } else { Self::Any }
    }
}

/// Converts a block without instructions of a particular processor.
fn convert_generic(pixels: &[[u8; 4]; BLOCK_PIXELS], planes: [&mut [u8; BLOCK_PIXELS]; 3]) {
    let is_one_colour = Content::of(pixels) == Content::OneColour;
    for (plane, factors) in planes.into_iter().zip(PLANE_FACTORS) {
        if is_one_colour {
            plane.fill(level(factors, u32::from_le_bytes(pixels[0])));
            continue;
        }
        for (byte, pixel) in plane.iter_mut().zip(pixels) {
            *byte = level(factors, u32::from_le_bytes(*pixel));
        }
    }
}

/// The same integer arithmetic as `convert_generic`, for 32 pixels at a time.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{BLOCK_PIXELS, Content, FRACTION_BITS, LUMA, PLANE_FACTORS, level};
    use std::arch::x86_64::{
        __m256i, _mm256_add_epi32, _mm256_and_si256, _mm256_mullo_epi32, _mm256_packus_epi16, _mm256_packus_epi32,
        _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_setr_epi32, _mm256_srli_epi32,
    };
    use std::mem::transmute;

    /// One component of eight pixels.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn levels([red, green, blue, offset]: [i32; 4], [r, g, b]: [__m256i; 3]) -> __m256i {
        let product = |factor: i32, channel| _mm256_mullo_epi32(channel, _mm256_set1_epi32(factor));
        let red_green = _mm256_add_epi32(product(red, r), product(green, g));
        let sum = _mm256_add_epi32(_mm256_add_epi32(red_green, product(blue, b)), _mm256_set1_epi32(offset));
        // No sum is negative.
        _mm256_srli_epi32::<{ FRACTION_BITS as i32 }>(sum)
    }

    /// Stores the levels of 32 pixels as bytes.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn store(levels: [__m256i; 4], to: &mut [u8; 32]) {
        // The packing instructions work on each half of a vector; this permutation restores the order of the pixels.
        let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
        let (low, high) = (_mm256_packus_epi32(levels[0], levels[1]), _mm256_packus_epi32(levels[2], levels[3]));
        let packed = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(low, high), order);
        // SAFETY: a vector is 32 bytes.
        *to = unsafe { transmute::<__m256i, [u8; 32]>(packed) };
    }

    /// Luma of grey pixels: one product with the sum of the three factors.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn convert_grey(pixels: &[[u8; 4]; BLOCK_PIXELS], y: &mut [u8; BLOCK_PIXELS]) {
        let [red, green, blue, offset] = LUMA;
        let (factor, offset) = (_mm256_set1_epi32(red + green + blue), _mm256_set1_epi32(offset));
        for (to, pixels) in y.as_chunks_mut::<32>().0.iter_mut().zip(pixels.as_chunks::<32>().0) {
            // SAFETY: 32 pixels are four vectors.
            let words = unsafe { transmute::<[[u8; 4]; 32], [__m256i; 4]>(*pixels) };
            let mut levels = words;
            for vector in &mut levels {
                let grey = _mm256_and_si256(*vector, _mm256_set1_epi32(0xff));
                *vector = _mm256_srli_epi32::<{ FRACTION_BITS as i32 }>(_mm256_add_epi32(_mm256_mullo_epi32(grey, factor), offset));
            }
            store(levels, to);
        }
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn convert(pixels: &[[u8; 4]; BLOCK_PIXELS], [y, cb, cr]: [&mut [u8; BLOCK_PIXELS]; 3]) {
        match Content::of(pixels) {
            Content::OneColour => {
                let [y_level, cb_level, cr_level] = PLANE_FACTORS.map(|factors| level(factors, u32::from_le_bytes(pixels[0])));
                (*y, *cb, *cr) = ([y_level; BLOCK_PIXELS], [cb_level; BLOCK_PIXELS], [cr_level; BLOCK_PIXELS]);
                return;
            }
            Content::Grey => {
                convert_grey(pixels, y);
                // Grey has no chroma, so its levels are those of black.
                let black = 0;
                let [cb_level, cr_level] = [1, 2].map(|plane: usize| level(PLANE_FACTORS[plane], black));
                (*cb, *cr) = ([cb_level; BLOCK_PIXELS], [cr_level; BLOCK_PIXELS]);
                return;
            }
            Content::Any => {}
        }
        let byte_mask = _mm256_set1_epi32(0xff);
        for (k, pixels) in pixels.as_chunks::<32>().0.iter().enumerate() {
            // SAFETY: 32 pixels are four vectors.
            let words = unsafe { transmute::<[[u8; 4]; 32], [__m256i; 4]>(*pixels) };
            let channels = |word| {
                [
                    _mm256_and_si256(word, byte_mask),
                    _mm256_and_si256(_mm256_srli_epi32::<8>(word), byte_mask),
                    _mm256_and_si256(_mm256_srli_epi32::<16>(word), byte_mask),
                ]
            };
            let channels = [channels(words[0]), channels(words[1]), channels(words[2]), channels(words[3])];
            for (plane, factors) in [&mut *y, &mut *cb, &mut *cr].into_iter().zip(PLANE_FACTORS) {
                let levels = [
                    levels(factors, channels[0]),
                    levels(factors, channels[1]),
                    levels(factors, channels[2]),
                    levels(factors, channels[3]),
                ];
                store(levels, &mut plane.as_chunks_mut::<32>().0[k]);
            }
        }
    }
}

fn convert(pixels: &[[u8; 4]; BLOCK_PIXELS], planes: [&mut [u8; BLOCK_PIXELS]; 3]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the CPU feature was just detected.
        return unsafe { avx2::convert(pixels, planes) };
    }
    convert_generic(pixels, planes);
}

/// Replaces the content of `bytes` by one frame. A buffer of the right length, from the frame before, is overwritten without being cleared.
pub fn overwrite_with_y4m_frame(bytes: &mut Vec<u8>, display: &[[u8; 4]]) {
    bytes.resize(FRAME_HEADER.len() + 3 * display.len(), 0);
    let (header, planes) = bytes.split_at_mut(FRAME_HEADER.len());
    header.copy_from_slice(FRAME_HEADER);
    let (y, chroma) = planes.split_at_mut(display.len());
    let (cb, cr) = chroma.split_at_mut(display.len());
    let (blocks, rest) = display.as_chunks::<BLOCK_PIXELS>();
    // Each plane is divided into whole blocks and the rest, as the pixels are.
    let [(y_blocks, y_rest), (cb_blocks, cb_rest), (cr_blocks, cr_rest)] = [y, cb, cr].map(|plane| plane.as_chunks_mut::<BLOCK_PIXELS>());
    for (((pixels, y), cb), cr) in blocks.iter().zip(y_blocks).zip(cb_blocks).zip(cr_blocks) {
        convert(pixels, [y, cb, cr]);
    }
    for (plane, factors) in [y_rest, cb_rest, cr_rest].into_iter().zip(PLANE_FACTORS) {
        for (byte, pixel) in plane.iter_mut().zip(rest) {
            *byte = level(factors, u32::from_le_bytes(*pixel));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(display: &[[u8; 4]]) -> Vec<u8> {
        // A used buffer, to show that nothing of an earlier frame is left.
        let mut bytes = vec![7; 100_000];
        overwrite_with_y4m_frame(&mut bytes, display);
        assert!(bytes.starts_with(FRAME_HEADER));
        bytes.split_off(FRAME_HEADER.len())
    }

    #[test]
    fn grey_has_no_chroma() {
        assert_eq!(planes(&[[0, 0, 0, 255], [255, 255, 255, 0]]), [16, 235, 128, 128, 128, 128]);
        for grey in 0..=255 {
            assert_eq!(planes(&[[grey, grey, grey, 255]])[1..], [128, 128]);
        }
    }

    /// Luma and chroma as the standard defines them.
    fn exact([r, g, b]: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = [r, g, b].map(|v| f64::from(v) / 255.0);
        let luma = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        [16.0 + 219.0 * luma, 128.0 + 224.0 * (b - luma) / 1.8556, 128.0 + 224.0 * (r - luma) / 1.5748]
    }

    #[test]
    fn levels_are_the_exact_values_rounded() {
        let mut largest = 0.0_f64;
        for r in (0..=255).step_by(5) {
            let display: Vec<[u8; 4]> = (0..=255).flat_map(|g| (0..=255).map(move |b| [r, g, b, 255])).collect();
            let written = planes(&display);
            for (k, [r, g, b, _]) in display.iter().enumerate() {
                for (plane, exact) in written.chunks(display.len()).zip(exact([*r, *g, *b])) {
                    largest = largest.max((f64::from(plane[k]) - exact).abs());
                }
            }
        }
        assert!((0.499..=0.500_02).contains(&largest), "{largest}");
    }

    #[test]
    fn generic_code_gives_the_same_bytes() {
        let pixels: [[u8; 4]; BLOCK_PIXELS] = std::array::from_fn(|k| [k as u8, (3 * k) as u8, (255 - k) as u8, 255]);
        let grey = std::array::from_fn(|k| [2 * k as u8, 2 * k as u8, 2 * k as u8, k as u8]);
        for pixels in [pixels, grey, [[1, 2, 3, 4]; BLOCK_PIXELS]] {
            let mut results = [[[0; BLOCK_PIXELS]; 3]; 2];
            let [best, generic] = &mut results;
            convert(&pixels, best.each_mut());
            convert_generic(&pixels, generic.each_mut());
            assert_eq!(best, generic);
        }
    }

    #[test]
    fn blocks_of_one_colour_and_the_end_of_an_image_are_like_any_other_pixels() {
        let colour = |k: usize| if (130..400).contains(&k) { [9, 200, 31, 255] } else { [k as u8, (k * 7) as u8, (k * k) as u8, 255] };
        for length in [1, 127, 128, 129, 500, 1024] {
            let display: Vec<[u8; 4]> = (0..length).map(colour).collect();
            let together = planes(&display);
            for (k, pixel) in display.iter().enumerate() {
                let alone = planes(&[*pixel]);
                assert_eq!([0, 1, 2].map(|plane| together[plane * length + k]), alone[..], "{k} of {length}");
            }
        }
    }
}
