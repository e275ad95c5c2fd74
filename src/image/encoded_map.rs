//! The file of a map, before it is decoded.
//!
//! In: the encoded bytes, and how they are decoded. Out: the texture. Not here: finding the file, and caching the texture.

use super::map_decoding::MapDecoding;
use super::mips::RowThreads;
use super::{ImageError, Texture};
use std::borrow::Cow;

/// A map's file.
#[derive(Clone, Debug)]
pub(super) struct EncodedMap {
    /// Name in error messages.
    pub name: String,
    /// The encoded image (PNG or JPEG).
    pub bytes: Cow<'static, [u8]>,
    /// How it is decoded.
    pub decoding: MapDecoding,
    /// Limit on its number of pixels.
    pub max_megapixels: u32,
}

impl EncodedMap {
    /// The decoded map with its mip levels. `threads`: which threads compute its mip levels; the result is the same.
    pub(super) fn decode(&self, threads: RowThreads) -> Result<Texture, ImageError> {
        Texture::decode_map(&self.name, &self.bytes, self.decoding, self.max_megapixels, threads)
    }
}
