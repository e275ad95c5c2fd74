//! The texels that a binding reads: borrowed bytes of every mip level, decoded on the way.
//!
//! sRGB is decoded by a table of 256 f32, exact to f32 rounding. Levels are whole (their bytes fit their size): that is checked here once,
//! so that reads need no other check than that of the coordinates.

use crate::image::{TexelFormat, Texture};
use std::sync::LazyLock;

/// IEC 61966-2-1, byte to linear.
static SRGB_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| crate::units::srgb_to_linear(i as f64 / 255.0) as f32));

/// Texels of one level at most: indices are 32 bits wide.
const MAX_TEXELS: u64 = 1 << 30;
/// Texels along a side at most: see [`crate::render::software::math::Real::nearest_small`].
const MAX_SIDE: u32 = 1 << 22;

/// One mip level.
#[derive(Clone, Copy, Debug)]
pub struct TexelLevel<'a> {
    pub width: u32,
    pub height: u32,
    pub(super) bytes: &'a [u8],
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
    pub fn new(format: TexelFormat, levels: impl Iterator<Item = (u32, u32, &'a [u8])>) -> Result<Self, String> {
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

/// How bytes become four linear floats; one type per format, so that the inner loops are made for each.
pub trait Decode: Copy {
    /// A texel as stored.
    type Texel: Copy + Default;
    /// The same by gathers, where the machine has them.
    type Gathering: Decode;
    /// # Safety
    /// The machine has AVX2.
    unsafe fn gathering(self) -> Self::Gathering;
    /// # Safety
    /// `index` is less than the level's width times its height.
    unsafe fn stored(self, level: &TexelLevel<'_>, index: u32) -> Self::Texel;
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
    /// As [`Decode::stored`], for every lane.
    #[inline(always)]
    unsafe fn fetch<const N: usize>(self, level: &TexelLevel<'_>, index: &[u32; N]) -> [Self::Texel; N] {
        let mut out = [Self::Texel::default(); N];
        for (o, i) in out.iter_mut().zip(index) {
            // SAFETY: passed on to the caller.
            *o = unsafe { self.stored(level, *i) };
        }
        out
    }
}

#[derive(Clone, Copy)]
pub struct Srgb(pub(super) &'static [f32; 256]);
#[derive(Clone, Copy)]
pub struct Unorm;
#[derive(Clone, Copy)]
pub struct Float;

impl Srgb {
    pub fn new() -> Self {
        Self(&SRGB_LINEAR)
    }
}

impl Default for Srgb {
    fn default() -> Self {
        Self::new()
    }
}

/// # Safety
/// As [`Decode::stored`]; texels have four bytes.
#[inline(always)]
unsafe fn four_bytes(level: &TexelLevel<'_>, index: u32) -> u32 {
    // SAFETY: a level holds the bytes of all its texels ([`Texels::new`]).
    u32::from_le(unsafe { level.bytes.as_ptr().cast::<u32>().wrapping_add(index as usize).read_unaligned() })
}

#[inline(always)]
pub(super) fn unorm<const K: usize>(texel: u32) -> f32 {
    (texel >> (8 * K) & 0xff) as i32 as f32 * (1.0 / 255.0)
}

impl Decode for Srgb {
    type Texel = u32;
    #[cfg(target_arch = "x86_64")]
    type Gathering = super::gather::Gathering<Self>;
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn gathering(self) -> super::gather::Gathering<Self> {
        super::gather::Gathering(self)
    }
    #[cfg(not(target_arch = "x86_64"))]
    type Gathering = Self;
    #[cfg(not(target_arch = "x86_64"))]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn stored(self, level: &TexelLevel<'_>, index: u32) -> u32 {
        // SAFETY: passed on to the caller.
        unsafe { four_bytes(level, index) }
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: u32) -> f32 {
        if K == 3 { unorm::<3>(texel) } else { self.0[(texel >> (8 * K) & 0xff) as usize] }
    }
}

impl Decode for Unorm {
    type Texel = u32;
    #[cfg(target_arch = "x86_64")]
    type Gathering = super::gather::Gathering<Self>;
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    unsafe fn gathering(self) -> super::gather::Gathering<Self> {
        super::gather::Gathering(self)
    }
    #[cfg(not(target_arch = "x86_64"))]
    type Gathering = Self;
    #[cfg(not(target_arch = "x86_64"))]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn stored(self, level: &TexelLevel<'_>, index: u32) -> u32 {
        // SAFETY: passed on to the caller.
        unsafe { four_bytes(level, index) }
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: u32) -> f32 {
        unorm::<K>(texel)
    }
}

impl Decode for Float {
    type Texel = [f32; 4];
    type Gathering = Self;
    #[inline(always)]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn stored(self, level: &TexelLevel<'_>, index: u32) -> [f32; 4] {
        // SAFETY: as in `four_bytes`; a texel has sixteen.
        let bits = unsafe { level.bytes.as_ptr().cast::<[u32; 4]>().wrapping_add(index as usize).read_unaligned() };
        let f = |k: usize| f32::from_bits(u32::from_le(bits[k]));
        [f(0), f(1), f(2), f(3)]
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: [f32; 4]) -> f32 {
        texel[K & 3]
    }
}
