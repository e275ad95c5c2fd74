//! The texels that a binding reads: the undecoded bytes of every mip level, borrowed from a texture or from the image of a pass.
//!
//! In: a texture or the image of a pass. Out: decoders of its format, which give linear f32 channels.
//!
//! sRGB is decoded with a table of 256 f32, exact to f32 rounding. `Texels::new` checks once that each level has as many bytes as its size
//! requires, so that reads check only the coordinates. The bytes of a map's level may still be on disk; `BoundLevel::read` fetches them
//! when lanes need that level.

#[cfg(target_arch = "x86_64")]
mod gather;

#[cfg(target_arch = "x86_64")]
use super::corners::Corners;
use crate::image::{Level, TexelFormat, Texture};
use crate::render::software::math::Real;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::__m256;
use std::sync::LazyLock;

/// Linear value of each sRGB byte, by IEC 61966-2-1.
static SRGB_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| crate::units::srgb_to_linear(i as f64 / 255.0) as f32));

/// Maximum number of texels of one level, because the gather instructions in `gather` take twice a texel's index as a signed 32-bit number.
const MAX_TEXELS: u64 = 1 << 30;
/// Maximum number of texels along a side, the limit of [`crate::render::software::math::Real::round_small`].
const MAX_SIDE: u32 = 1 << 22;

/// One mip level, its bytes in memory.
#[derive(Clone, Copy, Debug)]
pub struct LoadedLevel<'a> {
    pub width: u32,
    pub height: u32,
    bytes: &'a [u8],
}

/// What a level's bytes are read from.
#[derive(Clone, Copy, Debug)]
enum LevelBytes<'a> {
    /// The output of a pass, in memory.
    Memory(&'a [u8]),
    /// A level of a texture; it may still be on disk.
    Texture(&'a Level),
}

/// One mip level of a binding; its bytes may still be on disk.
#[derive(Clone, Copy, Debug)]
pub struct BoundLevel<'a> {
    pub width: u32,
    pub height: u32,
    bytes: LevelBytes<'a>,
}

impl<'a> BoundLevel<'a> {
    /// The level with its bytes in memory. The first call for a level of a map on disk reads them.
    #[inline]
    pub(crate) fn read(&self) -> LoadedLevel<'a> {
        let bytes = match self.bytes {
            LevelBytes::Memory(bytes) => bytes,
            LevelBytes::Texture(level) => level.bytes(),
        };
        LoadedLevel { width: self.width, height: self.height, bytes }
    }
}

/// The level with index `level` (0: the finest), and the next coarser one; `None` if the latter does not exist or has weight 0 in all lanes.
#[inline(always)]
pub(super) fn read_pair<'a, R: Real>(
    levels: &[BoundLevel<'a>],
    level: usize,
    coarser_weight: &[R],
) -> (LoadedLevel<'a>, Option<LoadedLevel<'a>>) {
    let coarser = levels.get(level + 1).filter(|_| coarser_weight.iter().fold(false, |any, w| any | (*w > R::ZERO)));
    (levels[level].read(), coarser.map(BoundLevel::read))
}

/// The texels of a texture or of a pass's output.
#[derive(Clone, Debug)]
pub struct Texels<'a> {
    pub format: TexelFormat,
    pub levels: Vec<BoundLevel<'a>>,
}

impl<'a> Texels<'a> {
    /// Texels in memory. `levels`: width, height and bytes of each mip level, the finest first.
    ///
    /// # Errors
    /// A level that is too large or whose number of bytes does not match its size, or no level at all.
    pub(crate) fn new(format: TexelFormat, levels: impl Iterator<Item = (u32, u32, &'a [u8])>) -> Result<Self, String> {
        Self::checked(
            format,
            levels.map(|(width, height, bytes)| (BoundLevel { width, height, bytes: LevelBytes::Memory(bytes) }, bytes.len())),
        )
    }

    /// Checks the levels, each given with its number of bytes.
    fn checked(format: TexelFormat, levels: impl Iterator<Item = (BoundLevel<'a>, usize)>) -> Result<Self, String> {
        let texel_bytes = u64::from(format.texel_bytes());
        let mut all = Vec::new();
        for (k, (level, byte_count)) in levels.enumerate() {
            let (width, height) = (level.width, level.height);
            let needed = u64::from(width) * u64::from(height) * texel_bytes;
            if width.max(height) > MAX_SIDE || needed / texel_bytes > MAX_TEXELS {
                return Err(format!("level {k} is {width}x{height}, larger than the renderer can read"));
            }
            if needed == 0 || byte_count as u64 != needed {
                return Err(format!("level {k} is {width}x{height} with {byte_count} bytes instead of {needed}"));
            }
            all.push(level);
        }
        if all.is_empty() { Err("it has no mip level".to_owned()) } else { Ok(Self { format, levels: all }) }
    }

    /// The texels of a texture, whose levels may still be on disk.
    ///
    /// # Errors
    /// As [`Texels::new`].
    pub fn of_texture(texture: &'a Texture) -> Result<Self, String> {
        let bound = |level: &'a Level| BoundLevel { width: level.width, height: level.height, bytes: LevelBytes::Texture(level) };
        Self::checked(texture.format, texture.levels.iter().map(|level| (bound(level), level.byte_count())))
    }
}

/// Decodes the bytes of a texel to four linear floats. Each format has its own type, so that the inner loops are compiled for each format.
pub(crate) trait Decode: Copy {
    /// A texel before decoding.
    type Texel: Copy + Default;
    /// The AVX2 decoder of the same format; on other architectures, this decoder.
    type Avx2: Decode;
    /// The decoder for machines with AVX2.
    /// # Safety
    /// The machine has AVX2.
    unsafe fn avx2(self) -> Self::Avx2;
    /// The texel at an index, counted row by row.
    /// # Safety
    /// `index` is less than the level's width times its height.
    unsafe fn texel(self, level: &LoadedLevel<'_>, index: u32) -> Self::Texel;
    /// Channel `K` of a texel.
    fn channel<const K: usize>(self, texel: Self::Texel) -> f32;
    #[inline(always)]
    fn channels(self, texel: Self::Texel) -> [f32; 4] {
        [self.channel::<0>(texel), self.channel::<1>(texel), self.channel::<2>(texel), self.channel::<3>(texel)]
    }

    /// Channel `K` of each of several texels.
    #[inline(always)]
    fn channel_of_each<const K: usize, const N: usize>(self, texels: &[Self::Texel; N]) -> [f32; N] {
        let mut out = [0.0; N];
        for (o, t) in out.iter_mut().zip(texels) {
            *o = self.channel::<K>(*t);
        }
        out
    }

    /// Whether this decoder has [`Decode::interpolate_eight`], with which [`super::filter_avx2`] filters. Such a decoder exists only on machines with AVX2.
    #[cfg(target_arch = "x86_64")]
    const FILTERS_WITH_AVX2: bool = false;

    /// The channels at eight points between texels, by bilinear interpolation; a channel that is not `needed` is unspecified. This default is never called:
    /// it is for decoders without `FILTERS_WITH_AVX2`.
    /// # Safety
    /// `FILTERS_WITH_AVX2`; the corners lie inside the level.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn interpolate_eight(self, level: &LoadedLevel<'_>, corners: &Corners, needed: [bool; 4]) -> [__m256; 4] {
        let _ = (level, corners, needed);
        // SAFETY: any bits are valid floats.
        unsafe { std::mem::zeroed() }
    }

    /// Texels of several lanes.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn fetch<const N: usize>(self, level: &LoadedLevel<'_>, index: &[u32; N]) -> [Self::Texel; N] {
        let mut out = [Self::Texel::default(); N];
        for (o, i) in out.iter_mut().zip(index) {
            // SAFETY: the caller guarantees it.
            *o = unsafe { self.texel(level, *i) };
        }
        out
    }

    /// Unfiltered reads of up to this many channels read each channel separately; reads of more channels read all four together.
    const MAX_SEPARATE_CHANNELS: usize = 1;

    /// Channel `K` of eight lanes' texels.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &LoadedLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        // SAFETY: the caller guarantees it.
        self.channel_of_each::<K, 8>(&unsafe { self.fetch(level, index) })
    }

    /// The four channels of eight lanes' texels. `MASKED`: zero where the mask is zero; a mask is all ones or zero.
    /// # Safety
    /// As [`Decode::texel`], for every lane.
    #[inline(always)]
    unsafe fn channels_of_eight<const MASKED: bool>(self, level: &LoadedLevel<'_>, index: &[u32; 8], mask: &[u32; 8]) -> [[f32; 8]; 4] {
        // SAFETY: the caller guarantees it.
        let t = unsafe { self.fetch(level, index) };
        let mut out = [
            self.channel_of_each::<0, 8>(&t),
            self.channel_of_each::<1, 8>(&t),
            self.channel_of_each::<2, 8>(&t),
            self.channel_of_each::<3, 8>(&t),
        ];
        if MASKED {
            for channel in &mut out {
                for (value, mask) in channel.iter_mut().zip(mask) {
                    *value = f32::from_bits(value.to_bits() & mask);
                }
            }
        }
        out
    }
}

/// Decodes bytes: sRGB colour by the table [`SRGB_LINEAR`], linear alpha.
#[derive(Clone, Copy)]
pub(crate) struct Srgb(&'static [f32; 256]);
/// Decodes bytes of linear values.
#[derive(Clone, Copy)]
pub(crate) struct Unorm;
/// Reads little-endian f32.
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

/// Four bytes at any alignment. Unlike `read_unaligned`, the read of a packed value is not checked in debug builds, and so is faster there.
#[derive(Clone, Copy)]
#[repr(C, packed)]
struct UnalignedWord(u32);

/// The bytes of a texel as one little-endian word.
/// # Safety
/// As [`Decode::texel`]; texels have four bytes.
#[inline(always)]
unsafe fn read_u32(level: &LoadedLevel<'_>, index: u32) -> u32 {
    // SAFETY: a level contains the bytes of all its texels ([`Texels::new`]).
    u32::from_le(unsafe { level.bytes.as_ptr().cast::<u32>().wrapping_add(index as usize).read_unaligned() })
}

/// Byte `K` of a texel as a value of 0 to 1. The byte becomes a signed integer, because AVX2 cannot convert unsigned ones.
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
            type Avx2 = gather::GatherDecoder<Self>;
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            unsafe fn avx2(self) -> gather::GatherDecoder<Self> {
                gather::GatherDecoder(self)
            }
            #[cfg(not(target_arch = "x86_64"))]
            type Avx2 = Self;
            #[cfg(not(target_arch = "x86_64"))]
            unsafe fn avx2(self) -> Self {
                self
            }
            #[inline(always)]
            unsafe fn texel(self, level: &LoadedLevel<'_>, index: u32) -> u32 {
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
    type Avx2 = gather::TransposeDecoder;
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn avx2(self) -> gather::TransposeDecoder {
        gather::TransposeDecoder(self)
    }
    #[cfg(not(target_arch = "x86_64"))]
    type Avx2 = Self;
    #[cfg(not(target_arch = "x86_64"))]
    unsafe fn avx2(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn texel(self, level: &LoadedLevel<'_>, index: u32) -> [f32; 4] {
        // SAFETY: as in `read_u32`; a texel has sixteen bytes.
        let bits = unsafe { level.bytes.as_ptr().cast::<[u32; 4]>().wrapping_add(index as usize).read_unaligned() };
        bits.map(|word| f32::from_bits(u32::from_le(word)))
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
        // `& 3` here and below: inside the texel whatever `K` is.
        texel[K & 3]
    }
    // Each channel of each lane takes one load and one store, whether channels are read separately or together, so reading complete texels has no advantage.
    const MAX_SEPARATE_CHANNELS: usize = 4;
    #[inline(always)]
    unsafe fn channel_of_eight<const K: usize>(self, level: &LoadedLevel<'_>, index: &[u32; 8]) -> [f32; 8] {
        let words = level.bytes.as_ptr().cast::<UnalignedWord>();
        // SAFETY: as in `texel`.
        index.map(|i| f32::from_bits(u32::from_le(unsafe { (*words.wrapping_add(i as usize * 4 + (K & 3))).0 })))
    }
}
