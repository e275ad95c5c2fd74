//! Images: textures with their mip chains, files of finished frames (PNG, EXR, animated PNG, GIF, y4m), and the difference of two images.
//!
//! In: encoded image files (maps and panoramas), or the rows of a frame. Out: [`Texture`]s with mip chains computed in linear light, or encoded files. The
//! texture of a map or panorama always has all levels down to 1x1; glyph atlases, tables of floats and the textures of the window have level 0 alone.

use crate::unwinding::catch_panic;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, RgbaImage};
use std::io::Cursor;
use std::sync::Arc;

mod animation;
mod compare;
mod encoded_map;
mod glyph_atlas;
mod integrity;
mod jpeg;
pub(crate) mod levels;
mod map_decoding;
mod map_entry;
mod maps;
mod mip_level;
mod mips;
mod panorama;
mod poles;
mod stored_maps;
mod write;
mod y4m;

pub use animation::{AnimationFormat, AnimationWriter, MAX_ANIMATION_PIXELS, SharedBytes, animation_format};
pub use compare::{Difference, DisplayImage};
pub use glyph_atlas::{Glyph, GlyphAtlas};
pub use integrity::{TEXT_SEARCH_BYTES, exr_text_in_head, gif_text_in_head, png_text_in_head, verify_exr, verify_png};
pub use map_decoding::{MapDecoding, OpacityTexels};
pub use maps::{MapOrigin, MapStore};
pub use mip_level::Level;
use mips::RowThreads;
pub use panorama::{Panorama, PanoramaExcess, read_panorama};
pub use poles::PoleFilter;
pub use stored_maps::{StoredMaps, StoredMapsStatus};
pub use write::{write_exr, write_png};
pub use y4m::{overwrite_with_y4m_frame, write_y4m_header};

/// Largest encoded image, bytes.
pub(crate) const MAX_FILE_BYTES: u64 = 1 << 30;
/// Default limit on the size of an image, needed because a small file can claim any size. A map of 8192 x 4096 has 34 megapixels.
pub const DEFAULT_MAX_MEGAPIXELS: u32 = 64;
/// Longest side of a map. A map of 64 megapixels in one row would need 2.5 GB for its mip levels.
const MAX_MAP_SIDE: u32 = 1 << 16;
/// Memory that a decoder may use apart from the pixels, bytes: for compressed colour profiles and texts. The limit is needed because a file of one
/// megabyte can expand to a gigabyte of them.
const DECODER_OVERHEAD_BYTES: u64 = 16 << 20;
/// Memory that a decoder may use per pixel, bytes: four channels of 16 bits, and as much again for its own buffers.
const DECODER_BYTES_PER_PIXEL: u64 = 16;

/// The format of a texture's texels; all have four channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFormat {
    /// sRGB-encoded colour, which a shader's read decodes; linear alpha.
    Rgba8Srgb,
    /// Linear values 0..1.
    Rgba8Unorm,
    /// Linear 32-bit floats.
    Rgba32Float,
}

impl TexelFormat {
    /// Bytes of one texel.
    pub(crate) fn texel_bytes(self) -> u32 {
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm => 4,
            Self::Rgba32Float => 16,
        }
    }
}

/// A texture: its mip levels, level 0 first.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub format: TexelFormat,
    pub levels: Vec<Level>,
}

pub type SharedTexture = Arc<Texture>;

/// Why an image could not be read, compared or written: one line.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// `searched`: a clause with the folder that was also searched, such as `, nor is it in maps`; empty if there was none.
    #[error("no map named {name}: it is not embedded{searched}; put it into a folder, and name the folder with --textures")]
    Missing { name: String, searched: String },
    #[error("{name}: {}", unreadable_text(reason))]
    Unreadable { name: String, reason: String },
    #[error("{name}: {}", too_large_text(*width, *height, *max_megapixels))]
    TooLarge { name: String, width: u32, height: u32, max_megapixels: u32 },
    /// A buffer does not have the length of an image of this size in its format, or the size is 0.
    #[error("{given_bytes} bytes are not an image of {width}x{height} texels")]
    WrongLength { width: u32, height: u32, given_bytes: usize },
    #[error("the images differ in size, {}x{} and {}x{} pixels", a.0, a.1, b.0, b.1)]
    /// `a`, `b`: width and height of the two images.
    DifferentSizes { a: (u32, u32), b: (u32, u32) },
    /// A saved image whose bytes have changed or are missing.
    #[error("not a whole image: {0}")]
    Damaged(String),
    #[error("the image could not be written: {0}")]
    Write(String),
}

impl ImageError {
    /// The file that the error is about, if it names one, and the reason without the file's name.
    pub(crate) fn file_and_reason(&self) -> (Option<&str>, String) {
        match self {
            Self::Unreadable { name, reason } => (Some(name.as_str()), unreadable_text(reason)),
            Self::TooLarge { name, width, height, max_megapixels } => {
                (Some(name.as_str()), too_large_text(*width, *height, *max_megapixels))
            }
            other => (None, other.to_string()),
        }
    }
}

fn unreadable_text(reason: &str) -> String {
    // Some reasons of decoders end with a line break.
    format!("not an image that can be read: {}", reason.trim_end())
}

fn too_large_text(width: u32, height: u32, max_megapixels: u32) -> String {
    let needed = megapixels(width, height);
    format!("{width} x {height} pixels are {needed} megapixels, more than {max_megapixels}; --max-megapixels {needed} allows them")
}

/// Megapixels, rounded up.
fn megapixels(width: u32, height: u32) -> u64 {
    (u64::from(width) * u64::from(height)).div_ceil(1_000_000)
}

/// Refuses an image that is too large to be decoded.
fn check_size(name: &str, (width, height): (u32, u32), max_megapixels: u32, max_side: u32) -> Result<(), ImageError> {
    if megapixels(width, height) > u64::from(max_megapixels) {
        return Err(ImageError::TooLarge { name: name.to_owned(), width, height, max_megapixels });
    }
    if width.max(height) > max_side {
        let reason = format!("{width} x {height} pixels; at most {max_side} on each side");
        return Err(ImageError::Unreadable { name: name.to_owned(), reason });
    }
    Ok(())
}

/// Decodes a PNG or a JPEG; `name` is for the error. No pixels are allocated for an image above `max_megapixels` or `max_side` (pixels).
fn decode_rgba8(name: &str, encoded: &[u8], max_megapixels: u32, max_side: u32) -> Result<RgbaImage, ImageError> {
    Ok(decode_any(name, encoded, &[ImageFormat::Png, ImageFormat::Jpeg], max_megapixels, max_side)?.into_rgba8())
}

/// Width and height that the header of a PNG states; `None` if the bytes end before them. They are read here because the decoder, which reads colour profiles
/// before it reports the size, needs its memory limit first.
fn stated_png_size(encoded: &[u8]) -> Option<(u32, u32)> {
    // After the signature (8 bytes) and the chunk's length and type (4 each), the IHDR chunk begins with width and height.
    let u32_at = |offset: usize| Some(u32::from_be_bytes(encoded.get(offset..offset + 4)?.try_into().ok()?));
    Some((u32_at(16)?, u32_at(20)?))
}

/// Decodes an image of any of these formats, with the file's own bit depth.
fn decode_any(name: &str, encoded: &[u8], formats: &[ImageFormat], max_megapixels: u32, max_side: u32) -> Result<DynamicImage, ImageError> {
    let unreadable = |reason: String| ImageError::Unreadable { name: name.to_owned(), reason };
    let format = image::guess_format(encoded).ok().filter(|f| formats.contains(f));
    let format = format.ok_or_else(|| {
        unreadable(format!("it is none of {}", formats.iter().map(|f| f.extensions_str()[0].to_uppercase()).collect::<Vec<_>>().join(", ")))
    })?;
    if format == ImageFormat::Jpeg {
        return jpeg::decode(name, encoded, max_megapixels, max_side);
    }
    let mut reader = ImageReader::with_format(Cursor::new(encoded), format);
    let mut limits = Limits::default();
    let max_pixels = u64::from(max_megapixels) * 1_000_000;
    // Only a PNG's header is read here; for other formats the size is checked after the decoder has reported it.
    let stated_pixels = match format {
        ImageFormat::Png => stated_png_size(encoded).map_or(0, |(width, height)| u64::from(width) * u64::from(height)),
        _ => max_pixels,
    };
    limits.max_alloc = Some(stated_pixels.min(max_pixels) * DECODER_BYTES_PER_PIXEL + DECODER_OVERHEAD_BYTES);
    reader.limits(limits);
    // A panic of a decoder counts as damage of the file.
    let decoder = catch_panic(|| reader.into_decoder()).ok_or_else(|| unreadable("it is damaged".into()))?;
    let decoder = decoder.map_err(|e| unreadable(e.to_string()))?;
    check_size(name, decoder.dimensions(), max_megapixels, max_side)?;
    let decoded = catch_panic(|| DynamicImage::from_decoder(decoder)).ok_or_else(|| unreadable("it is damaged".into()))?;
    decoded.map_err(|e| unreadable(e.to_string()))
}

impl Texture {
    /// A texture with its full mip chain from 8-bit RGBA rows, top first. `format` is one of the two 8-bit formats.
    pub fn from_rgba8(width: u32, height: u32, rgba: Vec<u8>, format: TexelFormat) -> Result<Self, ImageError> {
        Self::with_decoding(width, height, rgba, MapDecoding::plain(format), RowThreads::All)
    }

    /// As [`Self::from_rgba8`], with the format and the pole filter of `decoding`. Its `opacity` tells whether coarser levels average values or opacities.
    fn with_decoding(width: u32, height: u32, rgba: Vec<u8>, decoding: MapDecoding, threads: RowThreads) -> Result<Self, ImageError> {
        let format = decoding.format;
        let needed_bytes = u64::from(width) * u64::from(height) * 4;
        if width == 0 || height == 0 || needed_bytes != rgba.len() as u64 || format == TexelFormat::Rgba32Float {
            return Err(ImageError::WrongLength { width, height, given_bytes: rgba.len() });
        }
        Ok(Self { format, levels: mips::chain(width, height, rgba, decoding, threads) })
    }

    /// A texture from an encoded JPEG or PNG; `name` is for the error.
    pub fn decode(name: &str, encoded: &[u8], format: TexelFormat) -> Result<Self, ImageError> {
        Self::decode_map(name, encoded, MapDecoding::plain(format), DEFAULT_MAX_MEGAPIXELS, RowThreads::All)
    }

    /// As [`Self::decode`], with all settings of `decoding`, and another limit on the size.
    fn decode_map(name: &str, encoded: &[u8], decoding: MapDecoding, max_megapixels: u32, threads: RowThreads) -> Result<Self, ImageError> {
        let rgba = decode_rgba8(name, encoded, max_megapixels, MAX_MAP_SIDE)?;
        let (width, height) = rgba.dimensions();
        Self::with_decoding(width, height, rgba.into_raw(), decoding, threads)
    }

    /// The texture with premultiplied alpha in linear light and a new mip chain: transparent texels then have no colour that
    /// filtering could spread. For [`TexelFormat::Rgba32Float`], which is not supported, the result has no levels.
    #[must_use]
    pub(crate) fn premultiplied(self) -> Self {
        let Some(first) = self.levels.into_iter().next().filter(|_| self.format != TexelFormat::Rgba32Float) else {
            return Self { format: self.format, levels: Vec::new() };
        };
        let (width, height) = (first.width, first.height);
        let mut bytes = first.into_bytes();
        mips::premultiply(&mut bytes, self.format);
        Self { format: self.format, levels: mips::chain(width, height, bytes, MapDecoding::plain(self.format), RowThreads::All) }
    }

    /// Mean linear RGB over the sphere of an equirectangular map: rows weighted by the cosine of their latitude. Zero without levels, and for
    /// [`TexelFormat::Rgba32Float`], which is not supported.
    pub fn mean_over_sphere(&self) -> [f64; 3] {
        let Some(level) = self.levels.first().filter(|_| self.format != TexelFormat::Rgba32Float) else { return [0.0; 3] };
        let linear_of_byte = mips::decode_table(self.format);
        let (mut sum, mut weight_sum) = ([0.0; 3], 0.0);
        for (y, row) in level.bytes().chunks_exact(level.width as usize * 4).enumerate() {
            // The sine of the colatitude is the cosine of the latitude.
            let weight = ((y as f64 + 0.5) / f64::from(level.height) * std::f64::consts::PI).sin();
            let mut row_sum = [0.0_f64; 3];
            for texel in row.chunks_exact(4) {
                for c in 0..3 {
                    row_sum[c] += f64::from(linear_of_byte[usize::from(texel[c])]);
                }
            }
            for c in 0..3 {
                sum[c] += weight * row_sum[c];
            }
            weight_sum += weight * f64::from(level.width);
        }
        sum.map(|s| s / weight_sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages are printed with control characters escaped, so a line break at the end would appear as `\n`.
    #[test]
    fn reasons_of_decoders_end_without_a_line_break() {
        let error = |reason: &str| ImageError::Unreadable { name: "a.jpg".into(), reason: reason.into() };
        for reason in ["expected 162 but found 143", "expected 162 but found 143\n"] {
            assert_eq!(error(reason).to_string(), "a.jpg: not an image that can be read: expected 162 but found 143");
            assert_eq!(error(reason).file_and_reason().1, "not an image that can be read: expected 162 but found 143");
        }
    }
}
