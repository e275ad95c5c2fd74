//! Decodes JPEG images, and refuses those that are cut short or damaged.
//!
//! In: an encoded JPEG. Out: its pixels, grey or RGB, the same as those that `image` decodes; or an error. The JPEG decoder of `image` is `zune-jpeg` in its
//! lenient mode, which fills with grey whatever it cannot decode. So this module calls `zune-jpeg` itself, in strict mode. Exception: the headers are read
//! leniently, because some programs write filler bytes between them, which change no pixel.
//!
//! Not noticed: a change within the compressed data that leaves it valid, because a JPEG has no checksum; and a cut that is followed by an end marker, because
//! the decoder takes what is missing for zeros.

use super::{ImageError, check_size};
use crate::unwinding::catch_panic;
use image::{DynamicImage, GrayImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Second bytes of markers (the first is 0xFF).
const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;

/// Decodes a JPEG; `name` is for the error. Nothing is allocated for an image above the limits, `max_side` in pixels.
pub(super) fn decode(name: &str, encoded: &[u8], max_megapixels: u32, max_side: u32) -> Result<DynamicImage, ImageError> {
    let unreadable = |reason: String| ImageError::Unreadable { name: name.to_owned(), reason };
    let damaged = || unreadable("it is damaged".into());
    // `check_size` applies the limits instead of the decoder.
    let options = DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(encoded), options);
    let headers = catch_panic(|| decoder.decode_headers()).ok_or_else(damaged)?;
    headers.map_err(|e| unreadable(error_text(&e)))?;
    let (width, height) = decoder.dimensions().ok_or_else(damaged)?;
    let size = (u32::try_from(width).unwrap_or(u32::MAX), u32::try_from(height).unwrap_or(u32::MAX));
    check_size(name, size, max_megapixels, max_side)?;
    if !has_end_marker(encoded) {
        return Err(unreadable("it is cut short or damaged: the mark at its end is missing".into()));
    }
    // Every other colour space is converted to RGB.
    let is_grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let target = if is_grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.set_strict_mode(true).jpeg_set_out_colorspace(target));
    let decoded = catch_panic(|| decoder.decode()).ok_or_else(damaged)?;
    let pixels = decoded.map_err(|e| unreadable(format!("it is damaged ({})", error_text(&e))))?;
    let image = match is_grey {
        true => GrayImage::from_raw(size.0, size.1, pixels).map(DynamicImage::ImageLuma8),
        false => RgbImage::from_raw(size.0, size.1, pixels).map(DynamicImage::ImageRgb8),
    };
    image.ok_or_else(damaged)
}

/// The decoder's text, without the quotation marks and line breaks that some of its texts have.
fn error_text(error: &DecodeErrors) -> String {
    match error {
        DecodeErrors::Format(text) => text.trim().to_owned(),
        DecodeErrors::FormatStatic(text) => (*text).to_owned(),
        other => other.to_string(),
    }
}

/// Whether the segments and the compressed data lead to the marker of the image's end. Bytes behind it do not count: some cameras append a second image.
fn has_end_marker(encoded: &[u8]) -> bool {
    let mut rest = encoded;
    while let Some(start) = rest.iter().position(|b| *b == 0xff) {
        let Some(code) = rest.get(start + 1) else { return false };
        // Bytes from here to the next place where a marker may begin.
        let length = match *code {
            END_OF_IMAGE => return true,
            // One of several filler bytes before a marker.
            0xff => 1,
            // A byte 0xff of the compressed data, and markers without a segment: restarts, TEM, the start of the image.
            0x00 | 0x01 | 0xd0..=0xd7 | START_OF_IMAGE => 2,
            // A segment: two bytes give its length, in which they are included.
            _ => match rest.get(start + 2..start + 4) {
                Some(bytes) => 2 + usize::from(u16::from_be_bytes([bytes[0], bytes[1]])),
                None => return false,
            },
        };
        let Some(next) = rest.get(start + length..) else { return false };
        rest = next;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::DEFAULT_MAX_MEGAPIXELS;
    use image::ImageFormat;
    use orrery_textures::MAPS;

    fn shipped(name: &str) -> Vec<u8> {
        MAPS.iter().find(|(n, _)| *n == name).expect("shipped").1.to_vec()
    }

    fn decoded(encoded: &[u8]) -> Result<DynamicImage, String> {
        decode("map.jpg", encoded, DEFAULT_MAX_MEGAPIXELS, u32::MAX).map_err(|e| e.to_string())
    }

    /// `image` decodes every one of the damaged files, with grey or bands in place of what is missing: this is what must not happen.
    #[test]
    fn cut_and_damaged_files_are_refused() {
        for name in ["titan.jpg", "earth_water.jpg"] {
            let whole = shipped(name);
            assert!(decoded(&whole).is_ok(), "{name}");
            let mut appended = whole.clone();
            appended.extend(&whole[..100]);
            assert!(decoded(&appended).is_ok(), "{name}: a second image follows");
            let half = whole.len() / 2;
            let mut zeros = whole.clone();
            zeros[half..].fill(0);
            // 256 bits of 1 (a zero byte follows each 0xff). The decoder must take some of them for a code, because codes and the numbers between them are at
            // most 16 bits long; but no Huffman code consists of ones alone.
            let mut ones = whole.clone();
            for (k, byte) in ones[half..half + 64].iter_mut().enumerate() {
                *byte = if k % 2 == 0 { 0xff } else { 0 };
            }
            for (damage, damaged) in [
                ("half", whole[..half].to_vec()),
                ("nine tenths", whole[..whole.len() * 9 / 10].to_vec()),
                ("without its last two bytes", whole[..whole.len() - 2].to_vec()),
                ("zeros", zeros),
                ("ones", ones),
            ] {
                assert!(image::load_from_memory_with_format(&damaged, ImageFormat::Jpeg).is_ok(), "{name}, {damage}: `image` accepts it");
                let error = decoded(&damaged).expect_err(damage);
                assert!(
                    error.starts_with("map.jpg: not an image that can be read: it is ") && error.contains("damaged"),
                    "{damage}: {error}"
                );
                assert!(!error.contains(['\n', '"', '\\']), "{damage}: {error}");
            }
        }
    }

    /// The strict mode changes no pixel of a sound file.
    #[test]
    fn whole_files_decode_as_in_lenient_mode() {
        for (name, bytes) in MAPS.iter().filter(|(name, _)| name.ends_with(".jpg")) {
            let lenient = image::load_from_memory_with_format(bytes, ImageFormat::Jpeg).expect("a JPEG");
            assert!(decoded(bytes) == Ok(lenient), "{name}");
        }
    }

    /// Filler bytes between the headers, as some programs write them, are no damage.
    #[test]
    fn filler_between_headers_is_accepted() {
        let whole = shipped("titan.jpg");
        let (start_of_image, rest) = whole.split_at(2);
        let mut filled = start_of_image.to_vec();
        filled.extend([0; 8]);
        filled.extend(rest);
        assert_eq!(decoded(&filled), decoded(&whole));
    }
}
