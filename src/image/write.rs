//! Writes finished frames: PNG with text chunks, EXR with linear floats.
//!
//! In: the pixels of a frame, top row first, and texts to embed. Out: the bytes of a file. Always: the same input gives the same bytes, because no time or
//! version of the program is added; a caller may put them into its texts. A text is *sealed* in an EXR if it is stored with the SHA-256 of the file
//! (`super::integrity`).

use super::ImageError;
use super::integrity::{seal_exr, unsealed_attribute};
use std::io::{Cursor, Write};

fn write_error(e: impl std::fmt::Display) -> ImageError {
    ImageError::Write(e.to_string())
}

fn check_pixel_count<T>(width: u32, height: u32, pixels: &[T]) -> Result<(), ImageError> {
    if width == 0 || height == 0 || u64::from(width) * u64::from(height) != pixels.len() as u64 {
        return Err(ImageError::WrongLength { width, height, given_bytes: size_of_val(pixels) });
    }
    Ok(())
}

/// Writes sRGB display bytes as an RGBA PNG; the `texts`, each a keyword and a value, become iTXt chunks in the order given.
pub fn write_png(out: impl Write, width: u32, height: u32, display: &[[u8; 4]], texts: &[(&str, &str)]) -> Result<(), ImageError> {
    check_pixel_count(width, height, display)?;
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // `Fast` takes a twentieth of the default's time (measured), for files that are 4 to 24 % larger.
    encoder.set_compression(png::Compression::Fast);
    for (keyword, value) in texts {
        encoder.add_itxt_chunk((*keyword).to_owned(), (*value).to_owned()).map_err(write_error)?;
    }
    let mut writer = encoder.write_header().map_err(write_error)?;
    writer.write_image_data(bytemuck::cast_slice(display)).map_err(write_error)?;
    writer.finish().map_err(write_error)
}

/// The text with a question mark for each character that Latin-1, the encoding of an EXR's texts, lacks.
fn limited_to_latin_1(text: &str) -> String {
    text.chars().map(|c| if u8::try_from(u32::from(c)).is_ok() { c } else { '?' }).collect()
}

/// Writes linear RGBA floats (premultiplied, as rendered) as an EXR. `comments`, if not empty, becomes the attribute `comments`. `sealed_text`: a text in
/// ASCII, stored in one attribute with the SHA-256 of the file; [`super::exr_text_in_head`] reads it. `None`: the file has no SHA-256 either, so
/// [`super::verify_exr`] rejects it.
pub fn write_exr(
    mut out: impl Write,
    width: u32,
    height: u32,
    hdr: &[[f32; 4]],
    comments: &str,
    sealed_text: Option<&str>,
) -> Result<(), ImageError> {
    use exr::prelude::{AttributeValue, Image, SpecificChannels, Text, Vec2, WritableImage};
    check_pixel_count(width, height, hdr)?;
    let (w, h) = (width as usize, height as usize);
    let pixel = |position: Vec2<usize>| {
        let [r, g, b, a] = hdr[position.y() * w + position.x()];
        (r, g, b, a)
    };
    let mut image = Image::from_channels((w, h), SpecificChannels::rgba(pixel));
    image.layer_data.attributes.comments = Text::new_or_none(limited_to_latin_1(comments)).filter(|_| !comments.is_empty());
    if let Some(text) = sealed_text {
        let (name, value) = unsealed_attribute(text);
        // `Text` itself would accept any Latin-1.
        let (Some(name), Some(value)) = (Text::new_or_none(name), Text::new_or_none(value).filter(|_| text.is_ascii())) else {
            return Err(write_error("the text to seal is not ASCII"));
        };
        // At most one entry in the hash map `other`: the crate writes its entries in an unspecified order, but the same input must give the same bytes.
        image.layer_data.attributes.other.insert(name, AttributeValue::Text(value));
    }
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(write_error)?;
    let mut bytes = bytes.into_inner();
    // Fills in the SHA-256 beside the sealed text; without such a text it changes nothing.
    seal_exr(&mut bytes);
    out.write_all(&bytes).map_err(write_error)
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
        let no_sealed_text = None;
        let mut bytes = Cursor::new(Vec::new());
        write_exr(&mut bytes, 3, 2, &pixels, "metres", no_sealed_text).unwrap();
        assert!(bytes.get_ref().windows(6).any(|w| w == b"metres"));
        let mut again = Cursor::new(Vec::new());
        write_exr(&mut again, 3, 2, &pixels, "metres", no_sealed_text).unwrap();
        assert_eq!(bytes.get_ref(), again.get_ref());
        // The comments may contain a body's name with characters that an EXR cannot store.
        let mut greek = Cursor::new(Vec::new());
        write_exr(&mut greek, 3, 2, &pixels, "1 metre, \u{3b1} Cen", no_sealed_text).unwrap();
        let stored = b"1 metre, ? Cen";
        assert!(greek.get_ref().windows(stored.len()).any(|w| w == stored));
        assert!(write_exr(Vec::new(), 3, 2, &pixels, "", Some("\u{3b1}")).unwrap_err().to_string().contains("not ASCII"));
        let error = write_exr(Vec::new(), 3, 3, &pixels, "metres", no_sealed_text).unwrap_err().to_string();
        // Six pixels of four floats.
        assert_eq!(error, "96 bytes are not an image of 3x3 texels");
        let back = image::load_from_memory(bytes.get_ref()).unwrap().into_rgba32f();
        assert_eq!(back.as_raw().as_slice(), bytemuck::cast_slice::<_, f32>(&pixels));
    }
}
