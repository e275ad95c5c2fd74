//! Texels of four bytes are read with gather instructions, eight at a time. Texels of sixteen bytes are read with one load each and transposed
//! into channels in registers.
//!
//! In: indices of texels, each below the level's number of texels. Out: the same bits as from reading texel by texel. Requires AVX2.

use super::{Corners, Decode, Float, Srgb, TexelLevel, Unorm, unorm};
use crate::render::software::sample::corners::between;
use std::arch::x86_64::{
    __m128, __m256, __m256i, _mm256_add_epi32, _mm256_and_ps, _mm256_and_si256, _mm256_castps128_ps256, _mm256_cmpeq_epi32,
    _mm256_cvtepi32_ps, _mm256_i32gather_epi32, _mm256_i32gather_ps, _mm256_insertf128_ps, _mm256_movemask_epi8, _mm256_mul_ps,
    _mm256_permute_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_ps, _mm256_shuffle_epi32, _mm256_shuffle_ps, _mm256_srli_epi32,
    _mm256_unpackhi_ps, _mm256_unpacklo_ps,
};
use std::mem::transmute;

/// Four floats at any alignment. Debug builds check vector loads through pointers, which takes ten times as long as the load; they do not check
/// reads of a packed value.
#[derive(Clone, Copy)]
#[repr(C, packed)]
struct Unaligned(__m128);

/// A format of four bytes read with gather instructions; sRGB also gathers from its decoding table. Only [`Decode::gathering`] creates it.
#[derive(Clone, Copy)]
pub(crate) struct Gathering<D>(pub(super) D);

/// Formats of four bytes per texel, with the table that decodes red, green and blue (`None`: not by a table).
trait FourBytes: Decode<Texel = u32> {
    fn table(self) -> Option<&'static [f32; 256]>;
}

impl FourBytes for Srgb {
    #[inline(always)]
    fn table(self) -> Option<&'static [f32; 256]> {
        Some(self.0)
    }
}

impl FourBytes for Unorm {
    #[inline(always)]
    fn table(self) -> Option<&'static [f32; 256]> {
        None
    }
}

/// The words at the indices `index` from `base`, gathered eight at a time.
/// # Safety
/// Every index is below 2^31, `base` points to more than that many words, and the machine has AVX2.
#[inline(always)]
unsafe fn gather<const N: usize>(base: *const u8, index: &[u32; N]) -> [u32; N] {
    const { assert!(N.is_multiple_of(8)) };
    let mut out = [0; N];
    for (to, indices) in out.as_chunks_mut::<8>().0.iter_mut().zip(index.as_chunks::<8>().0) {
        // SAFETY: the caller guarantees the indices and AVX2; both arrays have eight words.
        unsafe {
            let indices = transmute::<[u32; 8], __m256i>(*indices);
            *to = transmute::<__m256i, [u32; 8]>(_mm256_i32gather_epi32::<4>(base.cast::<i32>(), indices));
        }
    }
    out
}

/// Channel `K` of four-byte texels. `table`: decodes red, green and blue.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn channel<const K: i32>(table: Option<&[f32; 256]>, texels: __m256i) -> __m256 {
    // SAFETY: the caller guarantees AVX2; a byte is below the table's length.
    unsafe {
        let byte = match K {
            0 => _mm256_and_si256(texels, _mm256_set1_epi32(0xff)),
            1 => _mm256_and_si256(_mm256_srli_epi32::<8>(texels), _mm256_set1_epi32(0xff)),
            2 => _mm256_and_si256(_mm256_srli_epi32::<16>(texels), _mm256_set1_epi32(0xff)),
            _ => _mm256_srli_epi32::<24>(texels),
        };
        match table.filter(|_| K < 3) {
            Some(table) => _mm256_i32gather_ps::<4>(table.as_ptr(), byte),
            None => _mm256_mul_ps(_mm256_cvtepi32_ps(byte), _mm256_set1_ps(1.0 / 255.0)),
        }
    }
}

/// Channel `K` between the texels at four corners.
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn channel_between<const K: i32>(table: Option<&[f32; 256]>, [a, b, c, d]: [__m256i; 4], fraction: [__m256; 2]) -> __m256 {
    // SAFETY: the caller guarantees it.
    unsafe { between([channel::<K>(table, a), channel::<K>(table, b), channel::<K>(table, c), channel::<K>(table, d)], fraction) }
}

impl<D: FourBytes> Decode for Gathering<D> {
    type Texel = u32;
    type Gathering = Self;
    const IN_REGISTERS: bool = true;
    #[inline(always)]
    unsafe fn interpolate_eight(self, level: &TexelLevel<'_>, corners: &Corners, needed: [bool; 4]) -> [__m256; 4] {
        // SAFETY: the corners lie inside the level, which has at most 2^30 texels; a `Gathering` exists only with AVX2.
        unsafe {
            let base = level.bytes.as_ptr().cast::<i32>();
            let [a, b, c, d] = corners.index;
            let texels = [
                _mm256_i32gather_epi32::<4>(base, a),
                _mm256_i32gather_epi32::<4>(base, b),
                _mm256_i32gather_epi32::<4>(base, c),
                _mm256_i32gather_epi32::<4>(base, d),
            ];
            let (table, fraction) = (self.0.table(), corners.fraction);
            let mut out = [_mm256_setzero_ps(); 4];
            if needed[0] {
                out[0] = channel_between::<0>(table, texels, fraction);
            }
            if needed[1] {
                out[1] = channel_between::<1>(table, texels, fraction);
            }
            if needed[2] {
                out[2] = channel_between::<2>(table, texels, fraction);
            }
            if needed[3] {
                out[3] = channel_between::<3>(table, texels, fraction);
            }
            out
        }
    }
    #[inline(always)]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> u32 {
        // SAFETY: the caller guarantees it.
        unsafe { self.0.texel(level, index) }
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: u32) -> f32 {
        self.0.channel::<K>(texel)
    }
    #[inline(always)]
    fn channel_of_each<const K: usize, const N: usize>(self, texels: &[u32; N]) -> [f32; N] {
        let mut out = [0.0; N];
        match self.0.table().filter(|_| K < 3) {
            Some(table) => {
                let mut byte = [0; N];
                for (byte, texel) in byte.iter_mut().zip(texels) {
                    *byte = texel >> (8 * K) & 0xff;
                }
                // SAFETY: a byte is below the table's length; a `Gathering` exists only on machines with AVX2.
                let words = unsafe { gather(table.as_ptr().cast::<u8>(), &byte) };
                for (out, word) in out.iter_mut().zip(words) {
                    *out = f32::from_bits(word);
                }
            }
            None => {
                for (out, texel) in out.iter_mut().zip(texels) {
                    *out = unorm::<K>(*texel);
                }
            }
        }
        out
    }
    #[inline(always)]
    unsafe fn fetch<const N: usize>(self, level: &TexelLevel<'_>, index: &[u32; N]) -> [u32; N] {
        // SAFETY: a level has at most 2^30 texels ([`Texels::new`]), and the caller's indices lie inside it; a `Gathering` exists only with AVX2.
        unsafe { gather(level.bytes.as_ptr(), index) }
    }
}

/// The format of four floats per texel, transposed in registers. Only [`Decode::gathering`] creates it.
#[derive(Clone, Copy)]
pub(crate) struct Transposing(pub(super) Float);

/// The texel at half of an index. Debug builds check each dereferenced pointer, but not this. A function and not a closure, which would lack the caller's
/// instruction set if it were not inlined.
/// # Safety
/// A texel at this index exists.
#[inline(always)]
unsafe fn texel_at(halves: *const u64, twice: u32) -> __m128 {
    let texel = halves.wrapping_add(twice as usize).cast::<Unaligned>();
    #[allow(clippy::transmute_ptr_to_ref, reason = "a dereferenced pointer is checked in debug builds")]
    // SAFETY: the caller guarantees it.
    unsafe {
        transmute::<*const Unaligned, &Unaligned>(texel).0
    }
}

/// The texels of lanes `low` and `low + 4`, whose indices are halves of these.
/// # Safety
/// As [`texel_at`]; the machine has AVX2.
#[inline(always)]
unsafe fn pair(halves: *const u64, twice: &[u32; 8], low: usize) -> __m256 {
    // SAFETY: the caller guarantees it.
    unsafe {
        let (first, second) = (texel_at(halves, twice[low]), texel_at(halves, twice[low + 4]));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
    }
}

impl Decode for Transposing {
    type Texel = [f32; 4];
    type Gathering = Self;
    const IN_REGISTERS: bool = true;
    #[inline(always)]
    unsafe fn interpolate_eight(self, level: &TexelLevel<'_>, corners: &Corners, _needed: [bool; 4]) -> [__m256; 4] {
        // SAFETY: the corners lie inside the level; a `Transposing` exists only with AVX2; vectors and arrays have eight words each.
        unsafe {
            let [a, b, c, d] = corners.index;
            let fraction = corners.fraction;
            // Where a texture is magnified, the lanes of a quad have the same corners: they do if the first corner and the last, diagonally opposite, are the same.
            let is_of_quad = |index| _mm256_cmpeq_epi32(index, _mm256_shuffle_epi32::<0>(index));
            let is_shared = _mm256_and_si256(is_of_quad(a), is_of_quad(d));
            if _mm256_movemask_epi8(is_shared) == -1 {
                return between_quads(
                    [self.of_quads(level, a), self.of_quads(level, b), self.of_quads(level, c), self.of_quads(level, d)],
                    fraction,
                );
            }
            let (a, b) = (self.transposed(level, a), self.transposed(level, b));
            let (c, d) = (self.transposed(level, c), self.transposed(level, d));
            [
                between([a[0], b[0], c[0], d[0]], fraction),
                between([a[1], b[1], c[1], d[1]], fraction),
                between([a[2], b[2], c[2], d[2]], fraction),
                between([a[3], b[3], c[3], d[3]], fraction),
            ]
        }
    }
    #[inline(always)]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> [f32; 4] {
        // SAFETY: the caller guarantees it.
        unsafe { self.0.texel(level, index) }
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
        self.0.channel::<K>(texel)
    }
    // Up to two gathers take fewer instructions than eight loads and a transposition; three are slower.
    const MAX_SEPARATE_CHANNELS: usize = 2;
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        // A gather scales its indices by at most eight bytes, half a texel. Twice an index fits, since a level has at most 2^30 texels.
        let twice = index.map(|i| i.wrapping_mul(2));
        // SAFETY: the caller's indices lie inside the level, whose texels have sixteen bytes; a `Transposing` exists only with AVX2.
        unsafe {
            let first = level.bytes.as_ptr().wrapping_add(4 * (K & 3)).cast::<i32>();
            transmute::<__m256i, [f32; 8]>(_mm256_i32gather_epi32::<8>(first, transmute::<[u32; 8], __m256i>(twice)))
        }
    }
    #[inline(always)]
    unsafe fn channels_of_eight<const MASKED: bool>(self, level: &TexelLevel<'_>, index: &[u32; 8], mask: &[u32; 8]) -> [[f32; 8]; 4] {
        // SAFETY: the caller guarantees it; vectors and arrays have eight words each.
        unsafe {
            let [r, g, b, a] = self.transposed(level, transmute::<[u32; 8], __m256i>(*index));
            // The compiler masks an array float by float.
            let mask = transmute::<[u32; 8], __m256>(if MASKED { *mask } else { [u32::MAX; 8] });
            let masked = [_mm256_and_ps(r, mask), _mm256_and_ps(g, mask), _mm256_and_ps(b, mask), _mm256_and_ps(a, mask)];
            transmute::<[__m256; 4], [[f32; 8]; 4]>(masked)
        }
    }
}

/// The channels between corners that the lanes of a quad share. `corners`: texels of the first quad, then of the second.
/// # Safety
/// AVX2.
#[inline(always)]
unsafe fn between_quads([a, b, c, d]: [__m256; 4], fraction: [__m256; 2]) -> [__m256; 4] {
    macro_rules! channel {
        ($lanes:literal) => {
            between(
                [
                    _mm256_permute_ps::<$lanes>(a),
                    _mm256_permute_ps::<$lanes>(b),
                    _mm256_permute_ps::<$lanes>(c),
                    _mm256_permute_ps::<$lanes>(d),
                ],
                fraction,
            )
        };
    }
    // SAFETY: the caller guarantees AVX2.
    unsafe { [channel!(0b00_00_00_00), channel!(0b01_01_01_01), channel!(0b10_10_10_10), channel!(0b11_11_11_11)] }
}

impl Transposing {
    /// The texels of two quads, whose lanes have the same index.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn of_quads(self, level: &TexelLevel<'_>, index: __m256i) -> __m256 {
        // SAFETY: as `transposed`.
        unsafe { pair(level.bytes.as_ptr().cast::<u64>(), &transmute::<__m256i, [u32; 8]>(_mm256_add_epi32(index, index)), 0) }
    }

    /// The four channels of eight texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn transposed(self, level: &TexelLevel<'_>, index: __m256i) -> [__m256; 4] {
        let halves = level.bytes.as_ptr().cast::<u64>();
        // SAFETY: the caller's indices lie inside the level, whose texels have sixteen bytes: an address has a factor of eight at most. Twice an index fits, since
        // a level has at most 2^30 texels. A `Transposing` exists only with AVX2.
        unsafe {
            let twice = transmute::<__m256i, [u32; 8]>(_mm256_add_epi32(index, index));
            let (t0, t1) = (pair(halves, &twice, 0), pair(halves, &twice, 1));
            let (t2, t3) = (pair(halves, &twice, 2), pair(halves, &twice, 3));
            let (low_01, low_23) = (_mm256_unpacklo_ps(t0, t1), _mm256_unpacklo_ps(t2, t3));
            let (high_01, high_23) = (_mm256_unpackhi_ps(t0, t1), _mm256_unpackhi_ps(t2, t3));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(low_01, low_23),
                _mm256_shuffle_ps::<0b11_10_11_10>(low_01, low_23),
                _mm256_shuffle_ps::<0b01_00_01_00>(high_01, high_23),
                _mm256_shuffle_ps::<0b11_10_11_10>(high_01, high_23),
            ]
        }
    }
}
