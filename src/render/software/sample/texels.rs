//! The texels that a binding reads: borrowed bytes of every mip level, decoded on the way.
//!
//! sRGB is decoded by a table of 256 f32, exact to f32 rounding. Levels are whole (their bytes fit their size): that is checked here once,
//! so that reads need no other check than that of the coordinates.

use crate::image::{TexelFormat, Texture};
use std::sync::LazyLock;

/// IEC 61966-2-1, byte to linear.
static SRGB_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let encoded = i as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

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
    pub fn new(format: TexelFormat, levels: impl Iterator<Item = (u32, u32, &'a [u8])>) -> Result<Self, String> {
        let texel = match format {
            TexelFormat::Rgba8Srgb | TexelFormat::Rgba8Unorm => 4,
            TexelFormat::Rgba32Float => 16,
        };
        let mut all = Vec::new();
        for (k, (width, height, bytes)) in levels.enumerate() {
            let needed = u64::from(width) * u64::from(height) * texel;
            if needed == 0 || bytes.len() as u64 != needed || width > i32::MAX as u32 / 2 || height > i32::MAX as u32 / 2 {
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
    fn texel(self, level: &TexelLevel<'_>, x: u32, y: u32) -> [f32; 4];
}

#[derive(Clone, Copy)]
pub struct Srgb(&'static [f32; 256]);
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

#[inline(always)]
fn at(level: &TexelLevel<'_>, x: u32, y: u32) -> usize {
    y as usize * level.width as usize + x as usize
}

impl Decode for Srgb {
    #[inline(always)]
    fn texel(self, level: &TexelLevel<'_>, x: u32, y: u32) -> [f32; 4] {
        let i = at(level, x, y) * 4;
        let [r, g, b, a] = [level.bytes[i], level.bytes[i + 1], level.bytes[i + 2], level.bytes[i + 3]];
        [self.0[usize::from(r)], self.0[usize::from(g)], self.0[usize::from(b)], f32::from(a) * (1.0 / 255.0)]
    }
}

impl Decode for Unorm {
    #[inline(always)]
    fn texel(self, level: &TexelLevel<'_>, x: u32, y: u32) -> [f32; 4] {
        let i = at(level, x, y) * 4;
        [level.bytes[i], level.bytes[i + 1], level.bytes[i + 2], level.bytes[i + 3]].map(|v| f32::from(v) * (1.0 / 255.0))
    }
}

impl Decode for Float {
    #[inline(always)]
    fn texel(self, level: &TexelLevel<'_>, x: u32, y: u32) -> [f32; 4] {
        let texel = &level.bytes[at(level, x, y) * 16..][..16];
        std::array::from_fn(|k| f32::from_le_bytes([texel[4 * k], texel[4 * k + 1], texel[4 * k + 2], texel[4 * k + 3]]))
    }
}
