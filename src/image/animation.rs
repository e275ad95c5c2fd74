//! Encodes frames as an animation: an animated PNG, which is lossless, or a GIF of 256 colours per frame.
//!
//! In: frames of one size (display bytes, top row first), their number and their rate, and texts to embed. Out: the bytes of a file. Always: the animation
//! loops forever at the given rate. GIF delays are whole hundredths of a second, so at rates that do not divide 100 the delays of a GIF's frames differ by one
//! hundredth, which keeps the mean rate. Alpha is ignored. The same input gives the same bytes.

use super::ImageError;
use parking_lot::Mutex;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Largest side of a GIF: the format stores it in 16 bits.
const MAX_GIF_SIDE_PX: u32 = u16::MAX as u32;
/// Largest rate of a GIF: its delays are hundredths of a second, and browsers show a delay of a single hundredth as ten.
const MAX_GIF_FRAMES_PER_S: u32 = 50;
/// Largest rate of an animated PNG: the format stores it in 16 bits, as the denominator of a frame's delay in seconds.
const MAX_APNG_FRAMES_PER_S: u32 = u16::MAX as u32;
/// Speed setting of the search for a frame's 256 colours: 1 is best, 30 is fastest.
const PALETTE_SEARCH_SPEED: i32 = 10;

/// The format of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationFormat {
    Apng,
    Gif,
}

enum Encoder<W: Write> {
    Apng(Box<png::Writer<W>>),
    Gif(Box<gif::Encoder<W>>),
}

/// Largest number of pixels of an animation that is encoded in memory, all frames together: a limit for callers to check. Uncompressed they have 6 GB.
pub const MAX_ANIMATION_PIXELS: f64 = 2e9;

/// The format for a file's extension; `None` for any other, also for `.png`.
pub fn animation_format(path: &Path) -> Option<AnimationFormat> {
    let extension = path.extension()?.to_ascii_lowercase();
    match extension.to_str()? {
        "gif" => Some(AnimationFormat::Gif),
        "apng" => Some(AnimationFormat::Apng),
        _ => None,
    }
}

/// A buffer that an encoder writes and its caller reads: each owns a clone of this handle.
#[derive(Clone, Default)]
pub struct SharedBytes(pub Arc<Mutex<Vec<u8>>>);

impl Write for SharedBytes {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Encodes frames one after the other.
pub struct AnimationWriter<W: Write> {
    encoder: Encoder<W>,
    width: u32,
    height: u32,
    frames_per_s: u32,
    frames_written: u32,
}

fn write_error(e: impl std::fmt::Display) -> ImageError {
    ImageError::Write(e.to_string())
}

impl<W: Write> AnimationWriter<W> {
    /// Starts a file of `frame_count` frames.
    ///
    /// # Errors
    /// A size or rate that the format does not support, or an error of the writer.
    pub(crate) fn new(
        out: W,
        format: AnimationFormat,
        (width, height): (u32, u32),
        frame_count: u32,
        frames_per_s: u32,
    ) -> Result<Self, ImageError> {
        let encoder = match format {
            AnimationFormat::Apng => {
                let mut encoder = png::Encoder::new(out, width, height);
                encoder.set_color(png::ColorType::Rgb);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
                encoder.set_compression(png::Compression::Fast);
                // The number of plays; 0 is without end.
                encoder.set_animated(frame_count, 0).map_err(write_error)?;
                // A delay of 1 / 0 s would mean 1/100 s.
                let in_range = u16::try_from(frames_per_s).ok().filter(|rate| *rate > 0);
                let frames_per_s = in_range.ok_or_else(|| {
                    ImageError::Write(format!("{frames_per_s} frames a second: an animated PNG has 1 to {MAX_APNG_FRAMES_PER_S}"))
                })?;
                encoder.set_frame_delay(1, frames_per_s).map_err(write_error)?;
                Encoder::Apng(Box::new(encoder.write_header().map_err(write_error)?))
            }
            AnimationFormat::Gif => {
                let side_u16 = |px: u32| {
                    u16::try_from(px).map_err(|_| ImageError::Write(format!("a GIF has at most {MAX_GIF_SIDE_PX} pixels a side")))
                };
                if !(1..=MAX_GIF_FRAMES_PER_S).contains(&frames_per_s) {
                    return Err(ImageError::Write(format!("{frames_per_s} frames a second: a GIF has 1 to {MAX_GIF_FRAMES_PER_S}")));
                }
                let mut encoder = gif::Encoder::new(out, side_u16(width)?, side_u16(height)?, &[]).map_err(write_error)?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(write_error)?;
                Encoder::Gif(Box::new(encoder))
            }
        };
        Ok(Self { encoder, width, height, frames_per_s, frames_written: 0 })
    }

    /// Stores texts with their keywords: in an animated PNG as iTXt chunks, in a GIF as comments `keyword: text`. Called before the first frame.
    ///
    /// # Errors
    /// A keyword that the format does not support, or an error of the writer.
    pub(crate) fn add_texts(&mut self, texts: &[(&str, String)]) -> Result<(), ImageError> {
        for (keyword, text) in texts {
            match &mut self.encoder {
                Encoder::Apng(writer) => {
                    writer.write_text_chunk(&png::text_metadata::ITXtChunk::new(*keyword, text.as_str())).map_err(write_error)?;
                }
                Encoder::Gif(writer) => {
                    let comment = format!("{keyword}: {text}");
                    writer.write_raw_extension(gif::Extension::Comment.into(), &[comment.as_bytes()]).map_err(write_error)?;
                }
            }
        }
        Ok(())
    }

    /// Adds a frame of sRGB display bytes.
    ///
    /// # Errors
    /// The frame has another size, or the writer failed.
    pub(crate) fn add(&mut self, display: &[[u8; 4]]) -> Result<(), ImageError> {
        let (width, height) = (self.width, self.height);
        if u64::from(width) * u64::from(height) != display.len() as u64 {
            return Err(ImageError::WrongLength { width, height, given_bytes: display.len().saturating_mul(4) });
        }
        let rgb: Vec<u8> = display.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        // For a GIF. The starting times are rounded, not the delay, so that rounding errors do not add up.
        let start_hundredths = |frame: u32| (f64::from(frame) * 100.0 / f64::from(self.frames_per_s)).round();
        let delay_hundredths = start_hundredths(self.frames_written + 1) - start_hundredths(self.frames_written);
        match &mut self.encoder {
            Encoder::Apng(writer) => writer.write_image_data(&rgb).map_err(write_error)?,
            Encoder::Gif(writer) => {
                // Width and height were checked against 65535 at the start.
                let mut frame = gif::Frame::from_rgb_speed(width as u16, height as u16, &rgb, PALETTE_SEARCH_SPEED);
                frame.delay = delay_hundredths as u16;
                writer.write_frame(&frame).map_err(write_error)?;
            }
        }
        self.frames_written += 1;
        Ok(())
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// Fewer frames of an animated PNG than announced at the start (a GIF does not store their number), or an error of the writer.
    pub(crate) fn finish(self) -> Result<(), ImageError> {
        match self.encoder {
            Encoder::Apng(writer) => writer.finish().map_err(write_error),
            Encoder::Gif(writer) => writer.into_inner().map(drop).map_err(write_error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{gif_text_in_head, png_text_in_head};
    use super::*;
    use image::AnimationDecoder;
    use std::io::Cursor;

    fn frames() -> Vec<Vec<[u8; 4]>> {
        (0..5_u8).map(|k| (0..12_u8).map(|i| [40 * k, 20 * i, 255 - 20 * i, 255]).collect()).collect()
    }

    fn written(format: AnimationFormat, frames_per_s: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = AnimationWriter::new(&mut bytes, format, (4, 3), 5, frames_per_s).expect("a writer");
        frames().iter().for_each(|frame| writer.add(frame).expect("a frame"));
        writer.finish().expect("an end");
        bytes
    }

    #[test]
    fn an_animated_png_keeps_every_frame_bit_for_bit() {
        let bytes = written(AnimationFormat::Apng, 25);
        let decoder = image::codecs::png::PngDecoder::new(Cursor::new(&bytes)).expect("a PNG").apng().expect("animated");
        let read: Vec<image::Frame> = decoder.into_frames().collect_frames().expect("frames");
        assert_eq!(read.len(), 5);
        for (frame, expected) in read.iter().zip(frames()) {
            assert_eq!(frame.delay().numer_denom_ms(), (40, 1));
            assert_eq!(frame.buffer().as_raw().chunks(4).map(|p| [p[0], p[1], p[2], p[3]]).collect::<Vec<_>>(), expected);
        }
        assert_eq!(bytes, written(AnimationFormat::Apng, 25));
    }

    #[test]
    fn a_gif_keeps_time_and_colours_that_fit_its_palette() {
        for frames_per_s in [1, 24, 30, 50] {
            let bytes = written(AnimationFormat::Gif, frames_per_s);
            let mut options = gif::DecodeOptions::new();
            options.set_color_output(gif::ColorOutput::RGBA);
            let mut decoder = options.read_info(Cursor::new(&bytes)).expect("a GIF");
            let (mut hundredths, mut count) = (0, 0);
            while let Some(frame) = decoder.read_next_frame().expect("a frame") {
                hundredths += u32::from(frame.delay);
                for (p, expected) in frame.buffer.chunks(4).zip(&frames()[count]) {
                    let difference = (0..3).map(|c| p[c].abs_diff(expected[c])).max();
                    assert!(difference <= Some(8), "{p:?} {expected:?}");
                }
                count += 1;
            }
            assert!(count == 5 && (f64::from(hundredths) - 500.0 / f64::from(frames_per_s)).abs() <= 0.5, "{frames_per_s}: {hundredths}");
        }
    }

    /// The long text fills several blocks of a GIF's comment.
    #[test]
    fn texts_read_back_and_leave_the_frames_as_they_are() {
        let texts = [("Title", "Earth, \u{3b1} Cen".to_owned()), ("Request", "0123456789".repeat(60))];
        for format in [AnimationFormat::Apng, AnimationFormat::Gif] {
            let mut bytes = Vec::new();
            let mut writer = AnimationWriter::new(&mut bytes, format, (4, 3), 5, 25).expect("a writer");
            writer.add_texts(&texts).expect("texts");
            frames().iter().for_each(|frame| writer.add(frame).expect("a frame"));
            writer.finish().expect("an end");
            let read: fn(&[u8], &str) -> Option<String> = match format {
                AnimationFormat::Apng => png_text_in_head,
                AnimationFormat::Gif => gif_text_in_head,
            };
            for (keyword, text) in &texts {
                assert_eq!(read(&bytes, keyword).as_ref(), Some(text), "{format:?}");
            }
            assert_eq!((read(&bytes, "Legend"), read(&written(format, 25), "Title")), (None, None));
            // A file that is cut within a text has none.
            let end_of_title = bytes.windows(5).position(|w| w == b"Earth").expect("a title") + 5;
            assert_eq!(read(&bytes[..end_of_title], "Title"), None, "{format:?}");
            let count = match format {
                AnimationFormat::Apng => {
                    image::codecs::png::PngDecoder::new(Cursor::new(&bytes)).expect("a PNG").apng().expect("animated").into_frames().count()
                }
                AnimationFormat::Gif => {
                    let mut decoder = gif::DecodeOptions::new().read_info(Cursor::new(&bytes)).expect("a GIF");
                    std::iter::from_fn(|| decoder.read_next_frame().expect("a frame").map(drop)).count()
                }
            };
            assert_eq!(count, 5, "{format:?}");
        }
    }

    #[test]
    fn unsupported_sizes_and_rates_are_refused() {
        let new = |format, size, frames_per_s| {
            AnimationWriter::new(Vec::new(), format, size, 1, frames_per_s).map(drop).map_err(|e| e.to_string())
        };
        assert!(new(AnimationFormat::Gif, (70_000, 1), 25).is_err_and(|e| e.contains("65535")));
        assert!(new(AnimationFormat::Gif, (7, 1), 51).is_err_and(|e| e.contains("1 to 50")));
        assert!(new(AnimationFormat::Apng, (7, 1), 70_000).is_err_and(|e| e.contains("65535")));
        assert!([AnimationFormat::Gif, AnimationFormat::Apng].iter().all(|format| new(*format, (7, 1), 0).is_err()));
        let mut writer = AnimationWriter::new(Vec::new(), AnimationFormat::Gif, (4, 3), 1, 25).expect("a writer");
        assert!(matches!(writer.add(&[[0; 4]; 5]), Err(ImageError::WrongLength { .. })));
    }
}
