//! Text embedded in saved images, and the integrity of the complete file.
//!
//! In: bytes of a file. Out: its text (of a PNG or a GIF, the text under one key), and whether a PNG or an EXR is intact. Always: any changed or missing
//! byte of these is detected. A PNG has a checksum for each chunk; an EXR has none, so [`seal_exr`] stores the SHA-256 of the file in an attribute, in front of
//! the text: the EXR is then *sealed*. Not here: the meaning of the text.

use super::ImageError;
use sha2::{Digest, Sha256};
use std::io::Cursor;

/// Hexadecimal digits of a SHA-256.
const DIGEST_LEN: usize = 64;
/// The name of the attribute of a sealed EXR. The attribute's value is the digest, a space, and the text.
const ATTRIBUTE: &str = "orreryRequest";

fn damaged(why: impl std::fmt::Display) -> ImageError {
    ImageError::Damaged(why.to_string())
}

/// The texts of an image that [`super::write_png`] or [`super::write_exr`] wrote, and of an animation, lie within this many bytes from the start of the file.
pub const TEXT_SEARCH_BYTES: usize = 1 << 16;

/// The text under `key` in the chunks before a PNG's pixels; the rest of the file may be missing or damaged. `head`: the first bytes of the file.
pub fn png_text_in_head(head: &[u8], key: &str) -> Option<String> {
    let reader = png_decoder(head).read_info().ok()?;
    reader.info().utf8_text.iter().find(|c| c.keyword == key)?.get_text().ok()
}

/// The label of a GIF's comment.
const GIF_COMMENT: u8 = 0xfe;

/// The text under `key` in the comments before a GIF's first frame; the rest of the file may be missing or damaged. `head`: the first bytes of the file.
pub fn gif_text_in_head(head: &[u8], key: &str) -> Option<String> {
    // Signature, version, width and height have 10 bytes; then come a byte with the length of the colour table, two other bytes, and the table.
    let flags = *head.get(10).filter(|_| head.starts_with(b"GIF8"))?;
    let table_bytes = if flags & 0x80 == 0 { 0 } else { 3_usize << ((flags & 7) + 1) };
    let mut rest = head.get(13 + table_bytes..)?;
    // An extension is 0x21, its label, and blocks, each preceded by its length; the last block has the length 0.
    while let [0x21, label, blocks @ ..] = rest {
        let mut text = Vec::new();
        rest = blocks;
        loop {
            let (length, bytes) = rest.split_first()?;
            let block = bytes.get(..usize::from(*length))?;
            rest = &bytes[block.len()..];
            if block.is_empty() {
                break;
            }
            text.extend_from_slice(block);
        }
        let value = std::str::from_utf8(&text).ok().and_then(|text| text.strip_prefix(key)?.strip_prefix(": "));
        if let (GIF_COMMENT, Some(value)) = (*label, value) {
            return Some(value.to_owned());
        }
    }
    None
}

/// A decoder that also checks the checksums of text chunks.
fn png_decoder(bytes: &[u8]) -> png::Decoder<Cursor<&[u8]>> {
    let mut options = png::DecodeOptions::default();
    options.set_skip_ancillary_crc_failures(false);
    png::Decoder::new_with_options(Cursor::new(bytes), options)
}

/// Checks that these are the bytes of an intact PNG of this size, in pixels.
pub fn verify_png(bytes: &[u8], (width, height): (u32, u32)) -> Result<(), ImageError> {
    let mut reader = png_decoder(bytes).read_info().map_err(damaged)?;
    let (w, h) = reader.info().size();
    if (w, h) != (width, height) {
        return Err(damaged(format!("it has {w}x{h} pixels instead of {width}x{height}")));
    }
    let mut pixels = vec![0; reader.output_buffer_size().ok_or_else(|| damaged("too large"))?];
    reader.next_frame(&mut pixels).map_err(damaged)?;
    reader.finish().map_err(damaged)
}

/// Name and value of the attribute of an EXR that is to be sealed, with zero digits in place of the digest, which [`seal_exr`] fills in.
pub(super) fn unsealed_attribute(text: &str) -> (&'static str, String) {
    (ATTRIBUTE, format!("{} {text}", "0".repeat(DIGEST_LEN)))
}

/// Offset of the digest in a sealed EXR, and the text after it.
fn digest_offset_and_text(bytes: &[u8]) -> Option<(usize, &str)> {
    let name: Vec<u8> = [ATTRIBUTE.as_bytes(), b"\0string\0"].concat();
    // An attribute is its name, its type (each ends with a zero byte), the length of its value (u32, little-endian), and the value.
    let length_offset = bytes.windows(name.len()).take(TEXT_SEARCH_BYTES).position(|w| w == name)? + name.len();
    let length = u32::from_le_bytes(bytes.get(length_offset..length_offset + 4)?.try_into().ok()?) as usize;
    let value = bytes.get(length_offset + 4..length_offset.checked_add(4)?.checked_add(length)?)?;
    let text = value.get(DIGEST_LEN..)?.strip_prefix(b" ")?;
    Some((length_offset + 4, std::str::from_utf8(text).ok()?))
}

/// SHA-256 of the file in hexadecimal, computed with zero digits in place of the digest at `digest_offset`.
fn digest_with_zeros(bytes: &[u8], digest_offset: usize) -> String {
    let mut hash = Sha256::new();
    hash.update(&bytes[..digest_offset]);
    hash.update([b'0'; DIGEST_LEN]);
    hash.update(&bytes[digest_offset + DIGEST_LEN..]);
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// Fills in the digest of an EXR that has a sealed text; leaves any other EXR as it is.
pub(super) fn seal_exr(bytes: &mut [u8]) {
    if let Some((digest_offset, _)) = digest_offset_and_text(bytes) {
        let digest = digest_with_zeros(bytes, digest_offset);
        bytes[digest_offset..digest_offset + DIGEST_LEN].copy_from_slice(digest.as_bytes());
    }
}

/// The text of a sealed EXR; the rest of the file may be missing or damaged. `head`: the first bytes of the file.
pub fn exr_text_in_head(head: &[u8]) -> Option<String> {
    digest_offset_and_text(head).map(|(_, text)| text.to_owned())
}

/// Checks that these are the bytes of an intact sealed EXR.
pub fn verify_exr(bytes: &[u8]) -> Result<(), ImageError> {
    match digest_offset_and_text(bytes) {
        Some((offset, _)) if digest_with_zeros(bytes, offset).as_bytes() == &bytes[offset..offset + DIGEST_LEN] => Ok(()),
        _ => Err(damaged("its bytes are not those that were written")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{write_exr, write_png};
    use super::*;

    const SIZE: (u32, u32) = (5, 3);

    fn png() -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels: Vec<[u8; 4]> = (0..15_u8).map(|i| [i, 255 - i, 3 * i, 255]).collect();
        write_png(&mut bytes, 5, 3, &pixels, &[("Title", "Earth"), ("Request", "mine")]).expect("written");
        bytes
    }

    fn exr() -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let pixels: Vec<[f32; 4]> = (0..15).map(|i| [i as f32 * 1e4, 1e-6, 0.1, 1.0]).collect();
        write_exr(&mut bytes, 5, 3, &pixels, "legend", Some("mine")).expect("written");
        bytes.into_inner()
    }

    /// The text of a file with any byte changed, or cut at any length, is not accepted.
    #[test]
    fn no_byte_may_change_or_be_missing() {
        type Read = fn(&[u8]) -> Option<String>;
        let png_read: Read = |b| png_text_in_head(b, "Request").filter(|_| verify_png(b, SIZE).is_ok());
        let exr_read: Read = |b| exr_text_in_head(b).filter(|_| verify_exr(b).is_ok());
        for (kind, bytes, read) in [("png", png(), png_read), ("exr", exr(), exr_read)] {
            assert_eq!(read(&bytes).as_deref(), Some("mine"), "{kind}");
            let is_accepted = |b: &[u8]| read(b).as_deref() == Some("mine");
            for at in 0..bytes.len() {
                assert!(!is_accepted(&bytes[..at]), "{kind} cut to {at} of {} bytes", bytes.len());
                for bit in [1_u8, 0x80] {
                    let mut flipped = bytes.clone();
                    flipped[at] ^= bit;
                    assert!(!is_accepted(&flipped), "{kind}: byte {at} of {} flipped", bytes.len());
                }
            }
        }
        assert!(verify_png(&png(), (5, 4)).is_err() && png_text_in_head(&png(), "Other").is_none());
    }
}
