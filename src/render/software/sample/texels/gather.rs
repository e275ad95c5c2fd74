//! The AVX2 decoders of texels. Texels of four bytes are read with gather instructions, eight at a time. Of texels of sixteen bytes, one or two channels are
//! gathered; if more are needed, each texel is read with one load, and eight of them are transposed into channels in registers. Bilinear interpolation
//! of eight points stays in registers.
//!
//! In: a level and indices of its texels, or the corners of eight points in it. Out: linear channels of the texels, or interpolated at the points; the same
//! bits as from reading texel by texel.

use super::{Corners, Decode, Float, Srgb, TexelLevel, Unorm, unorm};
use crate::render::software::sample::corners::bilinear;
use std::arch::x86_64::{
    __m128, __m256, __m256i, _mm256_add_epi32, _mm256_and_ps, _mm256_and_si256, _mm256_castps128_ps256, _mm256_cmpeq_epi32,
    _mm256_cvtepi32_ps, _mm256_i32gather_epi32, _mm256_i32gather_ps, _mm256_insertf128_ps, _mm256_movemask_epi8, _mm256_mul_ps,
    _mm256_permute_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setzero_ps, _mm256_shuffle_epi32, _mm256_shuffle_ps, _mm256_srli_epi32,
    _mm256_unpackhi_ps, _mm256_unpacklo_ps,
};
use std::mem::transmute;

/// Four floats at any alignment. Debug builds check the alignment of a pointer at each vector load, which takes ten times as long as the load;
/// reading a packed field through a reference avoids the check.
#[derive(Clone, Copy)]
#[repr(C, packed)]
struct Unaligned(__m128);

/// Decodes a format of four bytes per texel with gather instructions; sRGB also gathers from its decoding table. Only [`Decode::avx2`] creates this decoder,
/// so it exists only on machines with AVX2.
#[derive(Clone, Copy)]
pub(crate) struct GatherDecoder<D>(pub(super) D);

/// Formats of four bytes per texel.
trait FourBytes: Decode<Texel = u32> {
    /// The linear value of each byte of red, green and blue; `None`: the byte over 255. Alpha is always the latter.
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

/// The 32-bit words at `base` with these indices, gathered eight at a time.
/// # Safety
/// For every index the word can be read, every index is below 2^31 (a gather's indices are signed), and the machine has AVX2.
#[inline(always)]
unsafe fn gather<const N: usize>(base: *const u8, indices: &[u32; N]) -> [u32; N] {
    const { assert!(N.is_multiple_of(8)) };
    let mut out = [0; N];
    for (to, eight) in out.as_chunks_mut::<8>().0.iter_mut().zip(indices.as_chunks::<8>().0) {
        // SAFETY: the caller guarantees the indices and AVX2; both arrays have eight words.
        unsafe {
            let eight = transmute::<[u32; 8], __m256i>(*eight);
            *to = transmute::<__m256i, [u32; 8]>(_mm256_i32gather_epi32::<4>(base.cast::<i32>(), eight));
        }
    }
    out
}

/// Channel `K` (0 to 3: red, green, blue, alpha) of eight texels of four bytes. `table`: [`FourBytes::table`].
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn channel_of_eight_texels<const K: i32>(table: Option<&[f32; 256]>, texels: __m256i) -> __m256 {
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

/// Bilinear interpolation of channel `K` between the texels at four corners, in the order of [`Corners::index`], by [`Corners::fraction`].
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn bilinear_channel<const K: i32>(table: Option<&[f32; 256]>, [a, b, c, d]: [__m256i; 4], fraction: [__m256; 2]) -> __m256 {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let corners = [
            channel_of_eight_texels::<K>(table, a),
            channel_of_eight_texels::<K>(table, b),
            channel_of_eight_texels::<K>(table, c),
            channel_of_eight_texels::<K>(table, d),
        ];
        bilinear(corners, fraction)
    }
}

impl<D: FourBytes> Decode for GatherDecoder<D> {
    type Texel = u32;
    type Avx2 = Self;
    const FILTERS_WITH_AVX2: bool = true;
    #[inline(always)]
    unsafe fn interpolate_eight(self, level: &TexelLevel<'_>, corners: &Corners, needed: [bool; 4]) -> [__m256; 4] {
        // SAFETY: the corners lie inside the level, which has at most 2^30 texels; a `GatherDecoder` exists only with AVX2.
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
                out[0] = bilinear_channel::<0>(table, texels, fraction);
            }
            if needed[1] {
                out[1] = bilinear_channel::<1>(table, texels, fraction);
            }
            if needed[2] {
                out[2] = bilinear_channel::<2>(table, texels, fraction);
            }
            if needed[3] {
                out[3] = bilinear_channel::<3>(table, texels, fraction);
            }
            out
        }
    }
    #[inline(always)]
    unsafe fn avx2(self) -> Self {
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
                // SAFETY: a byte is below the table's length; a `GatherDecoder` exists only on machines with AVX2.
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
        // SAFETY: a level has at most 2^30 texels ([`Texels::new`]), and the caller's indices lie inside it; a `GatherDecoder` exists only with AVX2.
        unsafe { gather(level.bytes.as_ptr(), index) }
    }
}

/// Decodes texels of four floats, which it transposes into channels in registers. Only [`Decode::avx2`] creates this decoder, so it exists only on machines
/// with AVX2.
#[derive(Clone, Copy)]
pub(crate) struct TransposeDecoder(pub(super) Float);

/// The texel of sixteen bytes that starts at `base[half_texel_index]`. The index is twice the texel's, because x86 addresses scale an index by at most
/// eight bytes, half a texel. Not checked in debug builds, see [`Unaligned`]. A function, because a closure cannot be `inline(always)`, and would lack the
/// caller's instruction set if it were not inlined.
/// # Safety
/// The texel exists.
#[inline(always)]
unsafe fn texel_at(base: *const u64, half_texel_index: u32) -> __m128 {
    let texel = base.wrapping_add(half_texel_index as usize).cast::<Unaligned>();
    #[allow(clippy::transmute_ptr_to_ref, reason = "a dereferenced pointer is checked in debug builds")]
    // SAFETY: the caller guarantees it.
    unsafe {
        transmute::<*const Unaligned, &Unaligned>(texel).0
    }
}

/// The texels of lanes `low` (in the lower half of the result) and `low + 4`; `half_texel_indices` as in [`texel_at`].
/// # Safety
/// As [`texel_at`]; the machine has AVX2.
#[inline(always)]
unsafe fn pair(base: *const u64, half_texel_indices: &[u32; 8], low: usize) -> __m256 {
    // SAFETY: the caller guarantees it.
    unsafe {
        let (first, second) = (texel_at(base, half_texel_indices[low]), texel_at(base, half_texel_indices[low + 4]));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
    }
}

impl Decode for TransposeDecoder {
    type Texel = [f32; 4];
    type Avx2 = Self;
    const FILTERS_WITH_AVX2: bool = true;
    #[inline(always)]
    unsafe fn interpolate_eight(self, level: &TexelLevel<'_>, corners: &Corners, _needed: [bool; 4]) -> [__m256; 4] {
        // SAFETY: the corners lie inside the level; a `TransposeDecoder` exists only with AVX2; vectors and arrays have eight words each.
        unsafe {
            let [a, b, c, d] = corners.index;
            let fraction = corners.fraction;
            // Four consecutive points are a quad of 2x2 pixels. Under magnification they often lie between the same four texels. Where two points have the same
            // top left corner and the same bottom right one, they have the same rows and columns, so all their corners agree.
            let equals_first_of_quad = |index| _mm256_cmpeq_epi32(index, _mm256_shuffle_epi32::<0>(index));
            let agree = _mm256_and_si256(equals_first_of_quad(a), equals_first_of_quad(d));
            let quads_share_corners = _mm256_movemask_epi8(agree) == -1;
            if quads_share_corners {
                let of_quads = [
                    self.texel_per_quad(level, a),
                    self.texel_per_quad(level, b),
                    self.texel_per_quad(level, c),
                    self.texel_per_quad(level, d),
                ];
                return bilinear_of_quads(of_quads, fraction);
            }
            let (a, b) = (self.transposed(level, a), self.transposed(level, b));
            let (c, d) = (self.transposed(level, c), self.transposed(level, d));
            [
                bilinear([a[0], b[0], c[0], d[0]], fraction),
                bilinear([a[1], b[1], c[1], d[1]], fraction),
                bilinear([a[2], b[2], c[2], d[2]], fraction),
                bilinear([a[3], b[3], c[3], d[3]], fraction),
            ]
        }
    }
    #[inline(always)]
    unsafe fn avx2(self) -> Self {
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
        // A gather scales its indices by at most eight bytes, half a texel. Twice an index is below 2^31, since a level has at most 2^30 texels.
        let half_texel_indices = index.map(|i| i.wrapping_mul(2));
        // SAFETY: the caller's indices lie inside the level, whose texels have sixteen bytes; a `TransposeDecoder` exists only with AVX2.
        unsafe {
            // `& 3` keeps the read inside the texel whatever `K` is.
            let channel_base = level.bytes.as_ptr().wrapping_add(4 * (K & 3)).cast::<i32>();
            transmute::<__m256i, [f32; 8]>(_mm256_i32gather_epi32::<8>(channel_base, transmute::<[u32; 8], __m256i>(half_texel_indices)))
        }
    }
    #[inline(always)]
    unsafe fn channels_of_eight<const MASKED: bool>(self, level: &TexelLevel<'_>, index: &[u32; 8], mask: &[u32; 8]) -> [[f32; 8]; 4] {
        // SAFETY: the caller guarantees it; vectors and arrays have eight words each.
        unsafe {
            let [r, g, b, a] = self.transposed(level, transmute::<[u32; 8], __m256i>(*index));
            // Lanes with mask 0 become 0. Masked as vectors, because the compiler would mask the floats of arrays one by one.
            let mask = transmute::<[u32; 8], __m256>(if MASKED { *mask } else { [u32::MAX; 8] });
            let masked = [_mm256_and_ps(r, mask), _mm256_and_ps(g, mask), _mm256_and_ps(b, mask), _mm256_and_ps(a, mask)];
            transmute::<[__m256; 4], [[f32; 8]; 4]>(masked)
        }
    }
}

/// Bilinear interpolation of the four channels between corners that the lanes of a quad share. `a` to `d`: the texels at one corner each, the first quad's
/// texel in the lower half and the second quad's in the upper half.
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn bilinear_of_quads([a, b, c, d]: [__m256; 4], fraction: [__m256; 2]) -> [__m256; 4] {
    // `$broadcast` copies one channel of a quad's texel to the four lanes of the quad.
    macro_rules! channel {
        ($broadcast:literal) => {
            bilinear(
                [
                    _mm256_permute_ps::<$broadcast>(a),
                    _mm256_permute_ps::<$broadcast>(b),
                    _mm256_permute_ps::<$broadcast>(c),
                    _mm256_permute_ps::<$broadcast>(d),
                ],
                fraction,
            )
        };
    }
    // SAFETY: the caller guarantees AVX2.
    unsafe { [channel!(0b00_00_00_00), channel!(0b01_01_01_01), channel!(0b10_10_10_10), channel!(0b11_11_11_11)] }
}

impl TransposeDecoder {
    /// One texel for each of two quads: the texels of lanes 0 and 4. Within a quad all lanes must have the same index.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn texel_per_quad(self, level: &TexelLevel<'_>, index: __m256i) -> __m256 {
        let base = level.bytes.as_ptr().cast::<u64>();
        // SAFETY: the caller's indices lie inside the level, whose texels have sixteen bytes. Twice an index is below 2^31, since a level has at most 2^30
        // texels. A `TransposeDecoder` exists only with AVX2.
        unsafe { pair(base, &transmute::<__m256i, [u32; 8]>(_mm256_add_epi32(index, index)), 0) }
    }

    /// The four channels of eight texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn transposed(self, level: &TexelLevel<'_>, index: __m256i) -> [__m256; 4] {
        let base = level.bytes.as_ptr().cast::<u64>();
        // SAFETY: as in `texel_per_quad`.
        unsafe {
            let half_texel_indices = transmute::<__m256i, [u32; 8]>(_mm256_add_epi32(index, index));
            let (t0, t1) = (pair(base, &half_texel_indices, 0), pair(base, &half_texel_indices, 1));
            let (t2, t3) = (pair(base, &half_texel_indices, 2), pair(base, &half_texel_indices, 3));
            // In each half, of two texels: red, red, green, green, and blue, blue, alpha, alpha.
            let (rg_01, rg_23) = (_mm256_unpacklo_ps(t0, t1), _mm256_unpacklo_ps(t2, t3));
            let (ba_01, ba_23) = (_mm256_unpackhi_ps(t0, t1), _mm256_unpackhi_ps(t2, t3));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(rg_01, rg_23),
                _mm256_shuffle_ps::<0b11_10_11_10>(rg_01, rg_23),
                _mm256_shuffle_ps::<0b01_00_01_00>(ba_01, ba_23),
                _mm256_shuffle_ps::<0b11_10_11_10>(ba_01, ba_23),
            ]
        }
    }
}
