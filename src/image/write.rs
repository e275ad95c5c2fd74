//! Writes finished frames: PNG with text chunks, EXR with linear floats, y4m for a video encoder.
//!
//! In: rows of pixels, top first. The same input gives the same bytes: no clock, and no program version unless the caller adds it to the text.

use super::ImageError;
use super::sealed::{seal_exr, unsealed_attribute};
use std::io::{Cursor, Write};

fn failed(e: impl std::fmt::Display) -> ImageError {
    ImageError::Write(e.to_string())
}

fn check(width: u32, height: u32, given: usize) -> Result<(), ImageError> {
    if width == 0 || height == 0 || u64::from(width) * u64::from(height) != given as u64 {
        return Err(ImageError::Size { width, height, given: given.saturating_mul(4) });
    }
    Ok(())
}

/// Writes sRGB display bytes as an RGBA PNG; `text` becomes iTXt chunks in the order given.
pub fn write_png(out: impl Write, width: u32, height: u32, display: &[[u8; 4]], text: &[(&str, &str)]) -> Result<(), ImageError> {
    check(width, height, display.len())?;
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // A twentieth of the default's time for files 4 to 24 % larger (docs/measurements.md).
    encoder.set_compression(png::Compression::Fast);
    for (key, value) in text {
        encoder.add_itxt_chunk((*key).to_owned(), (*value).to_owned()).map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(bytemuck::cast_slice(display)).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// Writes linear RGBA floats (premultiplied, as rendered) as an EXR; `comments` becomes the attribute of that name, `sealed` one that
/// [`super::exr_head_text`] reads back.
pub fn write_exr(
    mut out: impl Write,
    width: u32,
    height: u32,
    hdr: &[[f32; 4]],
    comments: &str,
    sealed: Option<&str>,
) -> Result<(), ImageError> {
    use exr::prelude::{AttributeValue, Image, SpecificChannels, Text, Vec2, WritableImage};
    check(width, height, hdr.len())?;
    let (w, h) = (width as usize, height as usize);
    let pixel = |at: Vec2<usize>| {
        let [r, g, b, a] = hdr[at.y() * w + at.x()];
        (r, g, b, a)
    };
    let mut image = Image::from_channels((w, h), SpecificChannels::rgba(pixel));
    image.layer_data.attributes.comments = Text::new_or_none(comments).filter(|_| !comments.is_empty());
    if let Some((name, value)) = sealed.map(unsealed_attribute)
        && let (Some(name), Some(value)) = (Text::new_or_none(name), Text::new_or_none(value))
    {
        // Only one attribute, because the crate does not keep attributes in order.
        image.layer_data.attributes.other.insert(name, AttributeValue::Text(value));
    }
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(failed)?;
    let mut bytes = bytes.into_inner();
    seal_exr(&mut bytes);
    out.write_all(&bytes).map_err(failed)
}

/// Starts a YUV4MPEG2 stream: 4:4:4 chroma, `rate` frames per second.
pub fn write_y4m_header(out: &mut impl Write, width: u32, height: u32, rate: u32) -> Result<(), ImageError> {
    writeln!(out, "YUV4MPEG2 W{width} H{height} F{rate}:1 Ip A1:1 C444 XCOLORRANGE=LIMITED").map_err(failed)
}

/// Pixels that are converted together.
const BLOCK_PIXELS: usize = 128;

/// BT.709 luma and chroma of display bytes.
fn luma_and_chroma(pixels: &[[u8; 4]; BLOCK_PIXELS]) -> [[u8; BLOCK_PIXELS]; 3] {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the CPU feature was just detected.
        return unsafe { convert_avx2(pixels) };
    }
    convert_scalar(pixels)
}

/// The same code compiled for AVX2; no instruction rounds differently.
/// # Safety
/// The CPU has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn convert_avx2(pixels: &[[u8; 4]; BLOCK_PIXELS]) -> [[u8; BLOCK_PIXELS]; 3] {
    convert_scalar(pixels)
}

#[inline(always)]
fn convert_scalar(pixels: &[[u8; 4]; BLOCK_PIXELS]) -> [[u8; BLOCK_PIXELS]; 3] {
    let [red, green, blue] = crate::units::LUMINANCE_WEIGHTS.map(|w| w as f32);
    let mut values = [[0.0_f32; BLOCK_PIXELS]; 3];
    for i in 0..BLOCK_PIXELS {
        let word = u32::from_le_bytes(pixels[i]);
        let [r, g, b] = [word, word >> 8, word >> 16].map(|v| (v & 0xff) as i32 as f32 / 255.0);
        let luma = red * r + green * g + blue * b;
        values[0][i] = 16.0 + 219.0 * luma;
        values[1][i] = 128.0 + 224.0 * (b - luma) / 1.8556;
        values[2][i] = 128.0 + 224.0 * (r - luma) / 1.5748;
    }
    let mut bytes = [[0; BLOCK_PIXELS]; 3];
    for (bytes, values) in bytes.iter_mut().zip(&values) {
        for i in 0..BLOCK_PIXELS {
            bytes[i] = nearest_byte(values[i]);
        }
    }
    bytes
}

/// Rounds a value of 0 to 255 to the nearest integer, halves upwards. A saturating conversion would not be vectorised.
#[inline(always)]
fn nearest_byte(value: f32) -> u8 {
    // Adding 1.5 * 2^23 leaves the nearest integer to the sum in the low bits; if that is greater than the sum, one less is the floor.
    let sum = value + 0.5;
    let nearest = sum + 12_582_912.0;
    let over = nearest - 12_582_912.0 > sum;
    (nearest.to_bits() & 0xff).wrapping_sub(u32::from(over)) as u8
}

/// Adds one frame of display bytes: BT.709 luma and chroma, limited range (Y 16..235, C 16..240). Alpha is ignored.
pub fn write_y4m_frame(out: &mut impl Write, display: &[[u8; 4]]) -> Result<(), ImageError> {
    let mut planes = vec![0_u8; display.len() * 3];
    let (y, chroma) = planes.split_at_mut(display.len());
    let (cb, cr) = chroma.split_at_mut(display.len());
    // Blocks of fixed length with one loop per step allow the compiler to vectorise.
    let blocks =
        display.chunks(BLOCK_PIXELS).zip(y.chunks_mut(BLOCK_PIXELS)).zip(cb.chunks_mut(BLOCK_PIXELS)).zip(cr.chunks_mut(BLOCK_PIXELS));
    for (((pixels, y), cb), cr) in blocks {
        let mut block = [[0; 4]; BLOCK_PIXELS];
        block[..pixels.len()].copy_from_slice(pixels);
        let converted = luma_and_chroma(&block);
        for (to, from) in [y, cb, cr].into_iter().zip(&converted) {
            to.copy_from_slice(&from[..to.len()]);
        }
    }
    out.write_all(b"FRAME\n").and_then(|()| out.write_all(&planes)).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_reads_back_and_is_the_same_twice() {
        let pixels: Vec<[u8; 4]> = (0..15_u8).map(|i| [i, 255 - i, 3 * i, 255]).collect();
        let write = || {
            let mut bytes = Vec::new();
            write_png(&mut bytes, 5, 3, &pixels, &[("Title", "Earth"), ("Time", "2024-04-08T18:17:16Z")]).unwrap();
            bytes
        };
        let bytes = write();
        assert_eq!(bytes, write());
        let back = image::load_from_memory(&bytes).unwrap().into_rgba8();
        assert_eq!(back.as_raw().as_slice(), bytemuck::cast_slice::<_, u8>(&pixels));
        let reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().utf8_text[0].keyword, "Title");
        assert!(write_png(Vec::new(), 5, 4, &pixels, &[]).is_err());
    }

    #[test]
    fn an_exr_reads_back_bit_for_bit() {
        let pixels: Vec<[f32; 4]> = (0..6).map(|i| [i as f32 * 1e4, 1e-6, 0.1, 1.0]).collect();
        let mut bytes = Cursor::new(Vec::new());
        write_exr(&mut bytes, 3, 2, &pixels, "metres", None).unwrap();
        assert!(bytes.get_ref().windows(6).any(|w| w == b"metres"));
        let mut again = Cursor::new(Vec::new());
        write_exr(&mut again, 3, 2, &pixels, "metres", None).unwrap();
        assert_eq!(bytes.get_ref(), again.get_ref());
        let back = image::load_from_memory(bytes.get_ref()).unwrap().into_rgba32f();
        assert_eq!(back.as_raw().as_slice(), bytemuck::cast_slice::<_, f32>(&pixels));
    }

    #[test]
    fn halves_round_upwards() {
        for k in 0..=255 * 64 {
            let value = k as f32 / 64.0;
            let expected = (value + 0.5).floor().min(255.0) as u8;
            assert!(value > 255.49 || nearest_byte(value) == expected, "{value}");
        }
        assert_eq!([16.0, 16.49, 16.5, 17.5, 240.5].map(nearest_byte), [16, 16, 17, 18, 241]);
    }

    #[test]
    fn y4m_grey_has_no_chroma() {
        let mut bytes = Vec::new();
        write_y4m_header(&mut bytes, 2, 1, 25).unwrap();
        let start = bytes.len() + b"FRAME\n".len();
        write_y4m_frame(&mut bytes, &[[0, 0, 0, 255], [255, 255, 255, 255]]).unwrap();
        assert_eq!(&bytes[start..], [16, 235, 128, 128, 128, 128]);
    }
}
