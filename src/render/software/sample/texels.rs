//! The texels that a binding reads: borrowed bytes of every mip level, which are decoded when read.
//!
//! sRGB is decoded with a table of 256 f32, exact to f32 rounding. `Texels::new` checks once that each level has as many bytes as its size
//! requires, so that reads check only the coordinates.

use crate::image::{TexelFormat, Texture};
use std::sync::LazyLock;

/// Linear value of each sRGB byte, by IEC 61966-2-1.
static SRGB_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| crate::units::srgb_to_linear(i as f64 / 255.0) as f32));

/// Maximum number of texels of one level, because indices are 32 bits wide.
const MAX_TEXELS: u64 = 1 << 30;
/// Maximum number of texels along a side, the limit of [`crate::render::software::math::Real::round_small`].
const MAX_SIDE: u32 = 1 << 22;

/// One mip level.
#[derive(Clone, Copy, Debug)]
pub struct TexelLevel<'a> {
    pub width: u32,
    pub height: u32,
    bytes: &'a [u8],
}

/// A texture or a pass's output.
#[derive(Clone, Debug)]
pub struct Texels<'a> {
    pub format: TexelFormat,
    pub levels: Vec<TexelLevel<'a>>,
}

impl<'a> Texels<'a> {
    /// # Errors
    /// A level that is too large or whose number of bytes does not match its size, or no level at all.
    pub(crate) fn new(format: TexelFormat, levels: impl Iterator<Item = (u32, u32, &'a [u8])>) -> Result<Self, String> {
        let texel_bytes = match format {
            TexelFormat::Rgba8Srgb | TexelFormat::Rgba8Unorm => 4,
            TexelFormat::Rgba32Float => 16,
        };
        let mut all = Vec::new();
        for (k, (width, height, bytes)) in levels.enumerate() {
            let needed = u64::from(width) * u64::from(height) * texel_bytes;
            if width.max(height) > MAX_SIDE || needed / texel_bytes > MAX_TEXELS {
                return Err(format!("level {k} is {width}x{height}, larger than the renderer can read"));
            }
            if needed == 0 || bytes.len() as u64 != needed {
                return Err(format!("level {k} is {width}x{height} with {} bytes instead of {needed}", bytes.len()));
            }
            all.push(TexelLevel { width, height, bytes });
        }
        if all.is_empty() { Err("it has no mip level".to_owned()) } else { Ok(Self { format, levels: all }) }
    }

    /// # Errors
    /// As [`Texels::new`].
    pub fn of_texture(texture: &'a Texture) -> Result<Self, String> {
        Self::new(texture.format, texture.levels.iter().map(|l| (l.width, l.height, l.bytes.as_slice())))
    }
}

/// Decodes the bytes of a texel to four linear floats. Each format has its own type, so that the inner loops are compiled for each format.
pub(crate) trait Decode: Copy {
    /// A texel before decoding.
    type Texel: Copy + Default;
    /// The decoder of the same format that reads with gather instructions, on machines that have them.
    type Gathering: Decode;
    /// # Safety
    /// The machine has AVX2.
    unsafe fn gathering(self) -> Self::Gathering;
    /// # Safety
    /// `index` is less than the level's width times its height.
    unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> Self::Texel;
    /// Channel `K` of a texel.
    fn channel<const K: usize>(self, texel: Self::Texel) -> f32;
    #[inline(always)]
    fn channels(self, texel: Self::Texel) -> [f32; 4] {
        [self.channel::<0>(texel), self.channel::<1>(texel), self.channel::<2>(texel), self.channel::<3>(texel)]
    }

    /// Channel `K` of several lanes' texels.
    #[inline(always)]
    fn channel_of_each<const K: usize, const N: usize>(self, texels: &[Self::Texel; N]) -> [f32; N] {
        let mut out = [0.0; N];
        for (o, t) in out.iter_mut().zip(texels) {
            *o = self.channel::<K>(*t);
        }
        out
    }

    /// Texels of several lanes.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn fetch<const N: usize>(self, level: &TexelLevel<'_>, index: &[u32; N]) -> [Self::Texel; N] {
        let mut out = [Self::Texel::default(); N];
        for (o, i) in out.iter_mut().zip(index) {
            // SAFETY: the caller guarantees it.
            *o = unsafe { self.texel(level, *i) };
        }
        out
    }

    /// Up to this many channels of single texels are read separately; if more are needed, all four are read together.
    const MAX_SEPARATE_CHANNELS: usize = 1;

    /// Channel `K` of eight lanes' texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        // SAFETY: the caller guarantees it.
        self.channel_of_each::<K, 8>(&unsafe { self.fetch(level, index) })
    }

    /// The four channels of eight lanes' texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channels_of_eight(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [[f32; 8]; 4] {
        // SAFETY: the caller guarantees it.
        let t = unsafe { self.fetch(level, index) };
        [
            self.channel_of_each::<0, 8>(&t),
            self.channel_of_each::<1, 8>(&t),
            self.channel_of_each::<2, 8>(&t),
            self.channel_of_each::<3, 8>(&t),
        ]
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Srgb(&'static [f32; 256]);
#[derive(Clone, Copy)]
pub(crate) struct Unorm;
#[derive(Clone, Copy)]
pub(crate) struct Float;

impl Srgb {
    pub(crate) fn new() -> Self {
        Self(&SRGB_LINEAR)
    }
}

impl Default for Srgb {
    fn default() -> Self {
        Self::new()
    }
}

/// Four bytes at any alignment. Debug builds check reads through pointers, but not reads of a packed value.
#[derive(Clone, Copy)]
#[repr(C, packed)]
struct UnalignedWord(u32);

/// # Safety
/// As [`Decode::texel`]; texels have four bytes.
#[inline(always)]
unsafe fn read_u32(level: &TexelLevel<'_>, index: u32) -> u32 {
    // SAFETY: a level contains the bytes of all its texels ([`Texels::new`]).
    u32::from_le(unsafe { level.bytes.as_ptr().cast::<u32>().wrapping_add(index as usize).read_unaligned() })
}

#[inline(always)]
fn unorm<const K: usize>(texel: u32) -> f32 {
    (texel >> (8 * K) & 0xff) as i32 as f32 * (1.0 / 255.0)
}

/// Implements [`Decode`] for a format of four bytes per texel, given the expression that decodes channel `K`.
macro_rules! decode_four_byte_texels {
    ($format:ty, |$decoder:ident, $texel:ident| $channel:expr) => {
        impl Decode for $format {
            type Texel = u32;
            #[cfg(target_arch = "x86_64")]
            type Gathering = gather::Gathering<Self>;
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            unsafe fn gathering(self) -> gather::Gathering<Self> {
                gather::Gathering(self)
            }
            #[cfg(not(target_arch = "x86_64"))]
            type Gathering = Self;
            #[cfg(not(target_arch = "x86_64"))]
            unsafe fn gathering(self) -> Self {
                self
            }
            #[inline(always)]
            unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> u32 {
                // SAFETY: the caller guarantees it.
                unsafe { read_u32(level, index) }
            }
            #[inline(always)]
            fn channel<const K: usize>(self, $texel: u32) -> f32 {
                let $decoder = self;
                $channel
            }
        }
    };
}

decode_four_byte_texels!(Srgb, |srgb, texel| if K == 3 { unorm::<3>(texel) } else { srgb.0[(texel >> (8 * K) & 0xff) as usize] });
decode_four_byte_texels!(Unorm, |_unorm, texel| unorm::<K>(texel));

impl Decode for Float {
    type Texel = [f32; 4];
    #[cfg(target_arch = "x86_64")]
    type Gathering = gather::Transposing;
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn gathering(self) -> gather::Transposing {
        gather::Transposing(self)
    }
    #[cfg(not(target_arch = "x86_64"))]
    type Gathering = Self;
    #[cfg(not(target_arch = "x86_64"))]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> [f32; 4] {
        // SAFETY: as in `read_u32`; a texel has sixteen bytes.
        let bits = unsafe { level.bytes.as_ptr().cast::<[u32; 4]>().wrapping_add(index as usize).read_unaligned() };
        bits.map(|word| f32::from_bits(u32::from_le(word)))
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
        texel[K & 3]
    }
    // A channel of a lane takes one load and one store either way, so reading complete texels has no advantage.
    const MAX_SEPARATE_CHANNELS: usize = 4;
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        let words = level.bytes.as_ptr().cast::<UnalignedWord>();
        // SAFETY: as in `texel`.
        index.map(|i| f32::from_bits(u32::from_le(unsafe { (*words.wrapping_add(i as usize * 4 + (K & 3))).0 })))
    }
}

#[cfg(target_arch = "x86_64")]
mod gather {
    //! Texels of four bytes are read with gather instructions, eight at a time. Texels of sixteen bytes are read with one load each and transposed
    //! into channels in registers.
    //!
    //! In: indices of texels, each below the level's number of texels. Out: the same bits as from reading texel by texel. Requires AVX2.

    use super::{Decode, Float, Srgb, TexelLevel, Unorm, unorm};
    use std::arch::x86_64::{
        __m128, __m256, __m256i, _mm256_castps128_ps256, _mm256_i32gather_epi32, _mm256_insertf128_ps, _mm256_shuffle_ps,
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

    impl<D: FourBytes> Decode for Gathering<D> {
        type Texel = u32;
        type Gathering = Self;
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

    /// The texels of lanes `low` and `low + 4`. A function and not a closure, which would lack the caller's instruction set if it were not inlined.
    /// # Safety
    /// Texels at these indices exist; the machine has AVX2.
    #[inline(always)]
    unsafe fn pair(texels: *const Unaligned, index: &[u32; 8], low: usize) -> __m256 {
        // SAFETY: the caller guarantees it.
        unsafe {
            let Unaligned(first) = *texels.wrapping_add(index[low] as usize);
            let Unaligned(second) = *texels.wrapping_add(index[low + 4] as usize);
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
        }
    }

    impl Decode for Transposing {
        type Texel = [f32; 4];
        type Gathering = Self;
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
        unsafe fn channels_of_eight(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [[f32; 8]; 4] {
            let texels = level.bytes.as_ptr().cast::<Unaligned>();
            // SAFETY: the caller's indices lie inside the level, whose texels have sixteen bytes.
            let [t0, t1, t2, t3] =
                unsafe { [pair(texels, index, 0), pair(texels, index, 1), pair(texels, index, 2), pair(texels, index, 3)] };
            // SAFETY: a `Transposing` exists only with AVX2; vectors and arrays have eight floats each.
            unsafe {
                let (low_01, low_23) = (_mm256_unpacklo_ps(t0, t1), _mm256_unpacklo_ps(t2, t3));
                let (high_01, high_23) = (_mm256_unpackhi_ps(t0, t1), _mm256_unpackhi_ps(t2, t3));
                transmute::<[__m256; 4], [[f32; 8]; 4]>([
                    _mm256_shuffle_ps::<0b01_00_01_00>(low_01, low_23),
                    _mm256_shuffle_ps::<0b11_10_11_10>(low_01, low_23),
                    _mm256_shuffle_ps::<0b01_00_01_00>(high_01, high_23),
                    _mm256_shuffle_ps::<0b11_10_11_10>(high_01, high_23),
                ])
            }
        }
    }
}
