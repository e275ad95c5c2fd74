//! Pictures in memory: textures with their mip chains, and finished frames as PNG and EXR.

use std::sync::Arc;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFormat {
    /// sRGB-encoded colour, linear alpha; decoded on read.
    Rgba8Srgb,
    /// Linear values 0..1.
    Rgba8Unorm,
    /// Linear 32-bit floats.
    Rgba32Float,
}

/// One mip level: tightly packed rows, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    pub width: u32,
    pub height: u32,
    pub bytes: Vec<u8>,
}

/// A texture with its full mip chain, level 0 first.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub format: TexelFormat,
    pub levels: Vec<Level>,
}

pub type SharedTexture = Arc<Texture>;
