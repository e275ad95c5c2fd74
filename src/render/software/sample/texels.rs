//! The texels that a binding reads: borrowed bytes of every mip level, decoded when read.
//!
//! sRGB is decoded with a table of 256 f32, exact to f32 rounding. `Texels::new` checks once that each level has as many bytes as its size
//! needs, so that reads check only the coordinates.

use crate::image::{TexelFormat, Texture};
use std::sync::LazyLock;

/// IEC 61966-2-1, byte to linear.
static SRGB_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| crate::units::srgb_to_linear(i as f64 / 255.0) as f32));

/// Texels of one level at most: indices are 32 bits wide.
const MAX_TEXELS: u64 = 1 << 30;
/// Texels along a side at most: see [`crate::render::software::math::Real::round_small`].
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
    /// A level whose bytes are not those of its size, or no level at all.
    pub(crate) fn new(format: TexelFormat, levels: impl Iterator<Item = (u32, u32, &'a [u8])>) -> Result<Self, String> {
        let texel = match format {
            TexelFormat::Rgba8Srgb | TexelFormat::Rgba8Unorm => 4,
            TexelFormat::Rgba32Float => 16,
        };
        let mut all = Vec::new();
        for (k, (width, height, bytes)) in levels.enumerate() {
            let needed = u64::from(width) * u64::from(height) * texel;
            if width.max(height) > MAX_SIDE || needed / texel > MAX_TEXELS {
                return Err(format!("level {k} is {width}x{height}, which is more than can be read"));
            }
            if needed == 0 || bytes.len() as u64 != needed {
                return Err(format!("level {k} is {width}x{height} with {} bytes, which should be {needed}", bytes.len()));
            }
            all.push(TexelLevel { width, height, bytes });
        }
        if all.is_empty() { Err("it has no level".to_owned()) } else { Ok(Self { format, levels: all }) }
    }

    /// # Errors
    /// As [`Texels::new`].
    pub fn of_texture(texture: &'a Texture) -> Result<Self, String> {
        Self::new(texture.format, texture.levels.iter().map(|l| (l.width, l.height, l.bytes.as_slice())))
    }
}

/// How bytes become four linear floats; one type per format, so that the inner loops are compiled for each.
pub(crate) trait Decode: Copy {
    /// A texel as stored.
    type Texel: Copy + Default;
    /// The same format read with gather instructions, on machines that have them.
    type Gathering: Decode;
    /// # Safety
    /// The machine has AVX2.
    unsafe fn gathering(self) -> Self::Gathering;
    /// # Safety
    /// `index` is less than the level's width times its height.
    unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> Self::Texel;
    /// One of its four channels.
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
            // SAFETY: passed on to the caller.
            *o = unsafe { self.texel(level, *i) };
        }
        out
    }

    /// Up to so many channels of single texels are read one by one, more of them together.
    const CHANNELS_READ_ALONE: usize = 1;

    /// Channel `K` of eight lanes' texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        // SAFETY: passed on to the caller.
        self.channel_of_each::<K, 8>(&unsafe { self.fetch(level, index) })
    }

    /// The four channels of eight lanes' texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channels_of_eight(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [[f32; 8]; 4] {
        // SAFETY: passed on to the caller.
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

/// Four bytes at any alignment. Debug builds check reads through pointers; reading a packed value is not checked.
#[derive(Clone, Copy)]
#[repr(C, packed)]
struct UnalignedWord(u32);

/// # Safety
/// As [`Decode::texel`]; texels have four bytes.
#[inline(always)]
unsafe fn read_u32(level: &TexelLevel<'_>, index: u32) -> u32 {
    // SAFETY: a level holds the bytes of all its texels ([`Texels::new`]).
    u32::from_le(unsafe { level.bytes.as_ptr().cast::<u32>().wrapping_add(index as usize).read_unaligned() })
}

#[inline(always)]
fn unorm<const K: usize>(texel: u32) -> f32 {
    (texel >> (8 * K) & 0xff) as i32 as f32 * (1.0 / 255.0)
}

/// A format of four bytes a texel: how channel `K` of a texel is decoded.
macro_rules! four_bytes_a_texel {
    ($format:ty, |$own:ident, $texel:ident| $channel:expr) => {
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
                // SAFETY: passed on to the caller.
                unsafe { read_u32(level, index) }
            }
            #[inline(always)]
            fn channel<const K: usize>(self, $texel: u32) -> f32 {
                let $own = self;
                $channel
            }
        }
    };
}

four_bytes_a_texel!(Srgb, |own, texel| if K == 3 { unorm::<3>(texel) } else { own.0[(texel >> (8 * K) & 0xff) as usize] });
four_bytes_a_texel!(Unorm, |_own, texel| unorm::<K>(texel));

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
        let f = |k: usize| f32::from_bits(u32::from_le(bits[k]));
        [f(0), f(1), f(2), f(3)]
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
        texel[K & 3]
    }
    // One load and one store for each channel of a lane: nothing is gained by reading whole texels.
    const CHANNELS_READ_ALONE: usize = 4;
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        let words = level.bytes.as_ptr().cast::<UnalignedWord>();
        // SAFETY: as in `texel`.
        index.map(|i| f32::from_bits(u32::from_le(unsafe { (*words.wrapping_add(i as usize * 4 + (K & 3))).0 })))
    }
}

#[cfg(target_arch = "x86_64")]
mod gather {
    //! Texels of four bytes are read with gather instructions, eight at a time; texels of sixteen bytes with one load each and transposed into
    //! channels in registers.
    //!
    //! In: indices of texels, each below the level's number of texels. Out: the same bits as reading one after the other. Needs AVX2.

    use super::{Decode, Float, Srgb, TexelLevel, Unorm, unorm};
    use std::arch::x86_64::{
        __m128, __m256, __m256i, _mm256_castps128_ps256, _mm256_i32gather_epi32, _mm256_insertf128_ps, _mm256_shuffle_ps,
        _mm256_unpackhi_ps, _mm256_unpacklo_ps,
    };
    use std::mem::transmute;

    /// Four floats at any alignment. Debug builds check vector loads through pointers, which takes ten times as long as the load; reading a
    /// packed value is not checked.
    #[derive(Clone, Copy)]
    #[repr(C, packed)]
    struct Unaligned(__m128);

    /// A format read with gather instructions; sRGB gathers from its decoding table as well. Only [`Decode::gathering`] makes it.
    #[derive(Clone, Copy)]
    pub(crate) struct Gathering<D>(pub(super) D);

    /// Formats of four bytes a texel, with the table that decodes red, green and blue.
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

    /// Words at `index` from `base`, eight at a time.
    /// # Safety
    /// Every index is below 2^31, `base` points to more than that many words, and the machine has AVX2.
    #[inline(always)]
    unsafe fn gather<const N: usize>(base: *const u8, index: &[u32; N]) -> [u32; N] {
        const { assert!(N.is_multiple_of(8)) };
        let mut out = [0; N];
        for (to, from) in out.as_chunks_mut::<8>().0.iter_mut().zip(index.as_chunks::<8>().0) {
            // SAFETY: passed on to the caller; both arrays hold eight words.
            unsafe {
                let at = transmute::<[u32; 8], __m256i>(*from);
                *to = transmute::<__m256i, [u32; 8]>(_mm256_i32gather_epi32::<4>(base.cast::<i32>(), at));
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
            // SAFETY: passed on to the caller.
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
            // SAFETY: a level has at most 2^30 texels ([`Texels::new`]), and the caller keeps to them; a `Gathering` exists only with AVX2.
            unsafe { gather(level.bytes.as_ptr(), index) }
        }
    }

    /// Four floats a texel. Only [`Decode::gathering`] makes it.
    #[derive(Clone, Copy)]
    pub(crate) struct Transposing(pub(super) Float);

    impl Decode for Transposing {
        type Texel = [f32; 4];
        type Gathering = Self;
        #[inline(always)]
        unsafe fn gathering(self) -> Self {
            self
        }
        #[inline(always)]
        unsafe fn texel(self, level: &TexelLevel<'_>, index: u32) -> [f32; 4] {
            // SAFETY: passed on to the caller.
            unsafe { self.0.texel(level, index) }
        }
        #[inline(always)]
        fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
            self.0.channel::<K>(texel)
        }
        // Two gathers are fewer instructions than eight loads that are transposed; three are slower.
        const CHANNELS_READ_ALONE: usize = 2;
        #[inline(always)]
        unsafe fn channel_of_eight<const K: usize>(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
            // A level has at most 2^30 texels: twice an index, in steps of eight bytes, fits.
            let twice = index.map(|i| i.wrapping_mul(2));
            // SAFETY: the caller keeps to the level's texels, of sixteen bytes each; a `Transposing` exists only with AVX2.
            unsafe {
                let first = level.bytes.as_ptr().wrapping_add(4 * (K & 3)).cast::<i32>();
                transmute::<__m256i, [f32; 8]>(_mm256_i32gather_epi32::<8>(first, transmute::<[u32; 8], __m256i>(twice)))
            }
        }
        #[inline(always)]
        unsafe fn channels_of_eight(self, level: &TexelLevel<'_>, index: &[u32; 8]) -> [[f32; 8]; 4] {
            let texels = level.bytes.as_ptr().cast::<Unaligned>();
            let pair = |low: usize| -> __m256 {
                // SAFETY: the caller keeps to the level's texels, of sixteen bytes each; a `Transposing` exists only with AVX2.
                unsafe {
                    let Unaligned(first) = *texels.wrapping_add(index[low] as usize);
                    let Unaligned(second) = *texels.wrapping_add(index[low + 4] as usize);
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
                }
            };
            let [t0, t1, t2, t3] = [pair(0), pair(1), pair(2), pair(3)];
            // SAFETY: a `Transposing` exists only with AVX2; vectors and arrays hold eight floats each.
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
