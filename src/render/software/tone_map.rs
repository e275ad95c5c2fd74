//! The shipped tone map (shaders/entry/tone_map.wesl) as one native function over the pixels of a block, which replaces its tape (list of instructions).
//!
//! In: linear light. Out: display bytes. Always: a byte is the level (0 to 255) nearest to the exact value of the sRGB curve, by a table of the curve's
//! 255 thresholds. The tape has an error of up to a thousandth of a level. So the byte may differ by one level from the tape's where a value lies within
//! that distance of a threshold. All kernel classes give the same bytes. Not here: a tone map that was edited, or f64, which the tape executes.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::exec::LANES;
use super::raster::coverage;
use crate::shader::{ModuleId, ShaderModule, generator};
use crate::units::srgb_to_linear;
use sha2::{Digest, Sha256};
use std::sync::LazyLock;

const BLOCK_WIDTH: usize = coverage::BLOCK_WIDTH as usize;
const BLOCK_HEIGHT: usize = coverage::BLOCK_HEIGHT as usize;
/// Name of the tone map's module.
const MODULE: &str = "tone_map";
/// SHA-256 of the emitted WGSL whose formula [`ToneMapUniforms::compress`] computes. If the WGSL has another digest, its tape is executed instead.
/// After a change of its fragments (WESL source files), adapt `compress` and record the new digest here.
const COMPRESS_WGSL_SHA256: &str = "9e377d8af9b8acb07e4c74c39894d549cdaa3e20f670e69b56fec3e3d9875308";

/// Offsets of the shipped tone map's uniforms, in bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToneMapOffsets {
    exposure: usize,
    linear_limit: usize,
}

impl ToneMapOffsets {
    /// `None` if the module is not the tone map whose formula [`ToneMapUniforms::compress`] computes.
    pub(super) fn of(module: &ShaderModule) -> Option<Self> {
        if module.id != ModuleId::Simple(MODULE) || sha256(&module.wgsl) != COMPRESS_WGSL_SHA256 {
            return None;
        }
        let offset = |name| module.layout.field(name).map(|field| field.offset as usize);
        Some(Self { exposure: offset("exposure")?, linear_limit: offset("linear_limit")? })
    }

    /// Reads the uniforms from the uniform bytes of a draw; `None` if there are too few bytes.
    pub(super) fn bind(self, uniform_bytes: &[u8]) -> Option<ToneMapUniforms> {
        let read = |offset: usize| uniform_bytes.get(offset..)?.first_chunk().map(|bytes| f32::from_le_bytes(*bytes));
        Some(ToneMapUniforms { exposure: read(self.exposure)?, linear_limit: read(self.linear_limit)? })
    }
}

fn sha256(text: &str) -> String {
    generator::hex(&Sha256::digest(text.as_bytes()))
}

/// The tone map with its uniforms.
#[derive(Clone, Copy, Debug)]
pub struct ToneMapUniforms {
    /// Factor on radiance.
    exposure: f32,
    /// Exposed light (1 is the white of the display) up to which the tone curve is the identity.
    linear_limit: f32,
}

/// The table ([`LEVELS`]) is for linear values from 2^-13, which is shown as level 0, to the largest f32 below 1. These are the bits of the two.
const FIRST_BITS: u32 = (127 - 13) << 23;
const LAST_BITS: u32 = 0x3f7f_ffff;
/// A cell is a range of values with equal high bits. A factor of two is divided into 128 cells, so that the width of a cell is at most 1/128 of its values. The
/// curve's slope is at most 255 * 1.055 / 2.4 = 112.1 levels per unit of the natural logarithm, so that it rises by less than a level in a cell: a cell
/// has at most one threshold.
const CELL_BITS: u32 = 16;
const CELLS: usize = ((LAST_BITS - FIRST_BITS) >> CELL_BITS) as usize + 1;

/// One entry per cell. The sum of the entry and the low bits of a value has the value's level in its high bits.
static LEVELS: LazyLock<Box<[u32; CELLS]>> = LazyLock::new(|| {
    let mut levels = Box::new([0; CELLS]);
    let mut threshold_bits = [LAST_BITS + 1; 256];
    for (level, bits) in threshold_bits.iter_mut().enumerate().skip(1) {
        // The middle between this level and the one below.
        let linear = srgb_to_linear((level as f64 - 0.5) / 255.0);
        // The smallest f32 that is not below `linear`.
        let nearest = linear as f32;
        *bits = nearest.to_bits() + u32::from(f64::from(nearest) < linear);
    }
    let mut level = 0;
    for (cell, entry) in levels.iter_mut().enumerate() {
        let start = FIRST_BITS + ((cell as u32) << CELL_BITS);
        let reaches_next = |level: usize, bits: u32| threshold_bits.get(level + 1).is_some_and(|threshold| *threshold <= bits);
        level += usize::from(reaches_next(level, start));
        *entry = (level as u32) << CELL_BITS;
        if reaches_next(level, start + ((1 << CELL_BITS) - 1)) {
            // From the threshold on, the low bits of a value carry into the level.
            *entry += start + (1 << CELL_BITS) - threshold_bits[level + 1];
            level += 1;
        }
    }
    levels
});

/// The cell and the low bits of a value that is neither negative nor NaN. A value outside the table's range is replaced by the nearest value inside.
#[inline(always)]
fn cell_of(linear: f32) -> (u32, u32) {
    // Values that are neither negative nor NaN are ordered like their bits.
    let bits = linear.to_bits().clamp(FIRST_BITS, LAST_BITS);
    ((bits - FIRST_BITS) >> CELL_BITS, bits & ((1 << CELL_BITS) - 1))
}

/// Opaque RGBA from each channel's sum of table entry and low bits.
#[inline(always)]
fn packed([r, g, b]: [u32; 3]) -> u32 {
    r >> CELL_BITS | (g >> CELL_BITS) << 8 | (b >> CELL_BITS) << 16 | 0xff00_0000
}

/// Encodes linear values, none of which is negative or NaN, as opaque RGBA, without instructions of a particular processor.
#[inline(always)]
fn encode_generic(linear: [&[f32; LANES]; 3], out: &mut [u32; LANES]) {
    let levels = &**LEVELS;
    let level = |value: f32| {
        let (cell, low) = cell_of(value);
        levels[cell as usize] + low
    };
    for (i, out) in out.iter_mut().enumerate() {
        *out = packed(linear.map(|plane| level(plane[i])));
    }
}

/// Encoding with gather instructions, which gives the same bytes.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{BLOCK_WIDTH, BlockRows, CELL_BITS, CELLS, FIRST_BITS, LANES, LAST_BITS, LEVELS};
    use std::arch::x86_64::{
        __m256, __m256i, _mm256_add_epi32, _mm256_and_si256, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_i32gather_epi32,
        _mm256_max_ps, _mm256_min_ps, _mm256_mul_ps, _mm256_mullo_epi32, _mm256_or_si256, _mm256_permute4x64_epi64, _mm256_set1_epi32,
        _mm256_set1_ps, _mm256_slli_epi32, _mm256_srli_epi32, _mm256_unpackhi_epi64, _mm256_unpacklo_epi64,
    };
    use std::mem::transmute;

    /// The levels of eight values times `factor`, each in the high bits of its word. NaN gives level 0.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn levels(table: &[u32; CELLS], factor: f32, values: &[f32; 8]) -> __m256i {
        let splat = |bits: u32| _mm256_set1_epi32(bits.cast_signed());
        // SAFETY: eight words in either form.
        let values = _mm256_mul_ps(unsafe { transmute::<[f32; 8], __m256>(*values) }, _mm256_set1_ps(factor));
        // If one operand is NaN, the maximum is the second operand.
        let at_least_first = _mm256_max_ps(values, _mm256_castsi256_ps(splat(FIRST_BITS)));
        let bits = _mm256_castps_si256(_mm256_min_ps(at_least_first, _mm256_castsi256_ps(splat(LAST_BITS))));
        // The low bits of FIRST_BITS are zero, so that FIRST_BITS can be subtracted after the shift. Here it is subtracted from the table's address.
        const { assert!(FIRST_BITS.trailing_zeros() >= CELL_BITS) };
        let origin = table.as_ptr().cast::<i32>().wrapping_sub((FIRST_BITS >> CELL_BITS) as usize);
        // SAFETY: bits are within FIRST_BITS..=LAST_BITS, so that the addresses are those of the table's entries 0..CELLS.
        let entries = unsafe { _mm256_i32gather_epi32::<4>(origin, _mm256_srli_epi32::<{ CELL_BITS as i32 }>(bits)) };
        _mm256_add_epi32(entries, _mm256_and_si256(bits, splat((1 << CELL_BITS) - 1)))
    }

    /// Opaque RGBA of the values `8 * k..8 * (k + 1)` of each channel times `factor`. `GREY`: the channels are equal, so that one is enough.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn encode_eight<const GREY: bool>(table: &[u32; CELLS], factor: f32, planes: [&[[f32; 8]]; 3], k: usize) -> __m256i {
        if GREY {
            let grey = _mm256_srli_epi32::<{ CELL_BITS as i32 }>(levels(table, factor, &planes[0][k]));
            // The product has the level in red, green and blue.
            return _mm256_or_si256(_mm256_mullo_epi32(grey, _mm256_set1_epi32(0x01_0101)), _mm256_set1_epi32(0xff << 24));
        }
        let [r, g, b] = [levels(table, factor, &planes[0][k]), levels(table, factor, &planes[1][k]), levels(table, factor, &planes[2][k])];
        let red = _mm256_srli_epi32::<{ CELL_BITS as i32 }>(r);
        let green = _mm256_slli_epi32::<8>(_mm256_srli_epi32::<{ CELL_BITS as i32 }>(g));
        let blue = _mm256_and_si256(b, _mm256_set1_epi32(0xff << CELL_BITS));
        let alpha = _mm256_set1_epi32(0xff << 24);
        _mm256_or_si256(_mm256_or_si256(red, green), _mm256_or_si256(blue, alpha))
    }

    /// Encodes linear values times `factor`, in lane order.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn encode(linear: [&[f32; LANES]; 3], factor: f32, out: &mut [u32; LANES]) {
        let (table, planes) = (&**LEVELS, linear.map(|plane| plane.as_chunks::<8>().0));
        for (k, out) in out.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            // SAFETY: eight words in either form.
            *out = unsafe { transmute::<__m256i, [u32; 8]>(encode_eight::<false>(table, factor, planes, k)) };
        }
    }

    /// As [`encode`] for the pixels of a block, with the result row by row. `GREY`: as in [`encode_eight`].
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn encode_rows<const GREY: bool>(linear: [&[f32; LANES]; 3], factor: f32, rows: &mut BlockRows) {
        let (table, planes) = (&**LEVELS, linear.map(|plane| plane.as_chunks::<8>().0));
        // Two rows of the block are eight quads, in four vectors of two quads. Each quad has a pair of pixels in each row.
        for (k, rows) in rows.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let quads = |pair: usize| encode_eight::<GREY>(table, factor, planes, 4 * k + pair);
            let mut row_halves = [[_mm256_set1_epi32(0); 2]; 2];
            for half in 0..2 {
                let (left, right) = (quads(2 * half), quads(2 * half + 1));
                // Interleaving leaves the pairs of the four quads in the order 0, 2, 1, 3.
                row_halves[0][half] = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_unpacklo_epi64(left, right));
                row_halves[1][half] = _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_unpackhi_epi64(left, right));
            }
            for (row, halves) in rows.iter_mut().zip(row_halves) {
                // SAFETY: sixteen words in either form.
                *row = unsafe { transmute::<[__m256i; 2], [u32; BLOCK_WIDTH]>(halves) };
            }
        }
    }
}

/// Whether red, green and blue have the same bits in all lanes. The loop has no early exit, so that the compiler vectorises it.
#[inline(always)]
fn is_grey([r, g, b]: [&[f32; LANES]; 3]) -> bool {
    if std::ptr::eq(r, g) && std::ptr::eq(r, b) {
        return true;
    }
    let mut differing = 0;
    for i in 0..LANES {
        differing |= (r[i].to_bits() ^ g[i].to_bits()) | (r[i].to_bits() ^ b[i].to_bits());
    }
    differing == 0
}

/// Display bytes of a block's pixels as little-endian words, by rows.
pub(super) type BlockRows = [[u32; BLOCK_WIDTH]; BLOCK_HEIGHT];

impl ToneMapUniforms {
    /// Display bytes of a block's pixels, in lane order: opaque RGBA, red in the lowest byte. `light`: linear red, green and blue.
    #[inline(always)]
    pub(super) fn map_generic(&self, light: [&[f32; LANES]; 3], out: &mut [u32; LANES]) {
        let mut exposed = [[0.0; LANES]; 3];
        self.expose(light, &mut exposed);
        if !self.is_linear(&light) {
            self.compress(&mut exposed);
        }
        encode_generic(exposed.each_ref(), out);
    }

    /// [`ToneMapUniforms::map_generic`] by rows.
    #[inline(always)]
    pub(super) fn map_rows_generic(&self, light: [&[f32; LANES]; 3], rows: &mut BlockRows) {
        let mut words = [0; LANES];
        self.map_generic(light, &mut words);
        for (row_of_quads, quads) in rows.as_chunks_mut::<2>().0.iter_mut().zip(words.as_chunks::<{ 2 * BLOCK_WIDTH }>().0) {
            for (k, word) in quads.iter().enumerate() {
                row_of_quads[k % 4 / 2][k / 4 * 2 + k % 2] = *word;
            }
        }
    }

    /// [`ToneMapUniforms::map_generic`] with AVX2: the same bytes.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx2")]
    fn map_avx2(&self, light: [&[f32; LANES]; 3], out: &mut [u32; LANES]) {
        if self.is_linear(&light) {
            return avx2::encode(light, self.exposure, out);
        }
        let mut exposed = [[0.0; LANES]; 3];
        self.expose(light, &mut exposed);
        self.compress(&mut exposed);
        let no_factor = 1.0;
        avx2::encode(exposed.each_ref(), no_factor, out);
    }

    /// [`ToneMapUniforms::map_rows_generic`] with AVX2: the same bytes.
    #[cfg(target_arch = "x86_64")]
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn map_rows_avx2(&self, light: [&[f32; LANES]; 3], rows: &mut BlockRows) {
        if is_grey(light) && self.is_linear(&light[..1]) {
            return avx2::encode_rows::<true>(light, self.exposure, rows);
        }
        if self.is_linear(&light) {
            return avx2::encode_rows::<false>(light, self.exposure, rows);
        }
        let mut exposed = [[0.0; LANES]; 3];
        self.expose(light, &mut exposed);
        self.compress(&mut exposed);
        let no_factor = 1.0;
        avx2::encode_rows::<false>(exposed.each_ref(), no_factor, rows);
    }

    /// Whether the tone curve is the identity for this light. False if a value is NaN with a positive sign, because such a NaN has greater bits than infinity.
    #[inline(always)]
    fn is_linear(&self, light: &[&[f32; LANES]]) -> bool {
        // Floats that are not negative are ordered like their bits as integers; the bits of a negative float are a negative integer.
        let mut greatest = 0;
        for plane in light {
            for value in *plane {
                greatest = greatest.max(value.to_bits().cast_signed());
            }
        }
        f32::from_bits(greatest.cast_unsigned()) * self.exposure <= self.linear_limit
    }

    /// Multiplies the light by the exposure; products that are negative or NaN become 0.
    #[inline(always)]
    fn expose(&self, light: [&[f32; LANES]; 3], exposed: &mut [[f32; LANES]; 3]) {
        for (exposed, light) in exposed.iter_mut().zip(light) {
            for i in 0..LANES {
                let value = light[i] * self.exposure;
                exposed[i] = if value > 0.0 { value } else { 0.0 };
            }
        }
    }

    /// The tone curve `filmic` of shaders/lib/display.wesl. It changes no value of a pixel whose greatest value is at most `linear_limit`. The shoulder has the
    /// value 0.8 and the slope 1 at 0.8, and approaches 1. Far above white the colour fades to white (`whiteness`).
    #[inline(always)]
    fn compress(&self, [r, g, b]: &mut [[f32; LANES]; 3]) {
        for i in 0..LANES {
            // The bounds 1e6 and 1e-12 keep the quotients finite for infinite light and for black.
            let colour = [r[i], g[i], b[i]].map(|c| if c < 1.0e6 { c } else { 1.0e6 });
            let greater = |a: f32, b: f32| if a > b { a } else { b };
            let peak = greater(greater(colour[0], colour[1]), greater(colour[2], 1.0e-12));
            let shoulder = 1.0 - 0.04 / (greater(peak, 0.8) - 0.6);
            let mapped = if peak <= self.linear_limit { peak } else { shoulder };
            let ratio = mapped / peak;
            let whiteness = 1.0 - 1.0 / (0.15 * (peak - mapped) + 1.0);
            [r[i], g[i], b[i]] = colour.map(|c| c * ratio * (1.0 - whiteness) + mapped * whiteness);
        }
    }

    /// As [`ToneMapUniforms::map_generic`], with AVX2 if this machine has it.
    pub(super) fn map_to_bytes(&self, light: [&[f32; LANES]; 3], out: &mut [u32; LANES]) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.map_avx2(light, out) };
        }
        self.map_generic(light, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The display level of a linear value by the formula of the sRGB curve, not rounded.
    fn exact_level(linear: f64) -> f64 {
        255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    }

    fn level(linear: f32) -> u32 {
        let (cell, low) = cell_of(linear);
        (LEVELS[cell as usize] + low) >> CELL_BITS
    }

    #[test]
    fn levels_are_nearest_to_the_curve() {
        // The step is a prime, so that the low bits vary.
        for bits in (0..1.1_f32.to_bits()).step_by(997) {
            let linear = f32::from_bits(bits);
            let error_levels = (f64::from(level(linear)) - exact_level(f64::from(linear)).min(255.0)).abs();
            assert!(error_levels <= 0.5 + 1e-9, "{linear}: {error_levels}");
        }
        // Each threshold lies between two neighbouring values.
        for k in 1..=255 {
            let threshold = threshold(k);
            let [below, above] = [threshold - 1, threshold].map(|bits| exact_level(f64::from(f32::from_bits(bits))));
            let half = f64::from(k) - 0.5;
            assert!(below < half + 1e-9 && above > half - 1e-9, "{k}: {below} {above}");
        }
        assert_eq!([0.0, 1.0, 7.0, f32::INFINITY].map(level), [0, 255, 255, 255]);
    }

    /// The bits of the smallest value that is shown at this level or a higher one.
    fn threshold(wanted: u32) -> u32 {
        let (mut below, mut at) = (0, LAST_BITS + 1);
        while at - below > 1 {
            let middle = below + (at - below) / 2;
            if level(f32::from_bits(middle)) < wanted { below = middle } else { at = middle }
        }
        at
    }

    fn light() -> [[f32; LANES]; 3] {
        [3, 17, 29].map(|step: usize| std::array::from_fn(|i| 10.0_f32.powf((i * step % LANES) as f32 / 16.0 - 5.0)))
    }

    #[test]
    fn every_instruction_set_gives_the_same_bytes() {
        let mut special_values = light();
        (special_values[0][3], special_values[1][4], special_values[2][5]) = (f32::NAN, f32::INFINITY, -1.0);
        for linear_limit in [0.8, f32::MAX] {
            let tone_map = ToneMapUniforms { exposure: 0.75, linear_limit };
            for light in [light(), special_values] {
                let (mut best, mut generic) = ([0; LANES], [1; LANES]);
                tone_map.map_to_bytes(light.each_ref(), &mut best);
                tone_map.map_generic(light.each_ref(), &mut generic);
                assert_eq!(best, generic);
                assert!(best.iter().all(|word| word >> 24 == 255));
                let mut rows = BlockRows::default();
                tone_map.map_rows_generic(light.each_ref(), &mut rows);
                let pixels = coverage::PixelCentres::new();
                for (lane, word) in generic.iter().enumerate() {
                    assert_eq!(rows[pixels.y[lane] as usize][pixels.x[lane] as usize], *word, "lane {lane}");
                }
                #[cfg(target_arch = "x86_64")]
                if is_x86_feature_detected!("avx2") {
                    let mut rows_avx2 = BlockRows::default();
                    // SAFETY: AVX2 was detected.
                    unsafe { tone_map.map_rows_avx2(light.each_ref(), &mut rows_avx2) };
                    assert_eq!(rows_avx2, rows);
                }
            }
        }
    }

    #[test]
    fn an_edited_tone_map_is_not_replaced() {
        let build = |fragments: &crate::shader::fragments::Fragments| {
            ShaderModule::build_with(fragments, &ModuleId::Simple(MODULE), &crate::shader::Lowering::without_tape()).expect("builds")
        };
        let shipped = build(&crate::shader::fragments::Fragments::default());
        let digest = sha256(&shipped.wgsl);
        assert_eq!(digest, COMPRESS_WGSL_SHA256, "the tone map's WGSL was edited: adapt ToneMapUniforms::compress, then record the digest");
        let bound = ToneMapOffsets::of(&shipped).and_then(|offsets| offsets.bind(&[2.0_f32, 0.8].map(f32::to_le_bytes).concat()));
        assert!(bound.is_some_and(|t| (t.exposure, t.linear_limit) == (2.0, 0.8)));
        let text = include_str!("../../../shaders/lib/display.wesl").replace("0.04", "0.05");
        let edited = crate::shader::fragments::Fragments::with_files([("lib/display.wesl".to_owned(), text)]);
        assert!(ToneMapOffsets::of(&build(&edited)).is_none());
    }
}
