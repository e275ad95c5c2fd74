//! What a kept picture says of itself, read back only where the whole file is as it was written.
//!
//! In: bytes of a file. Out: the text under one name, or why the file does not count. Always: one changed, missing or cut byte, and there is no text. A PNG carries a checksum
//! of each chunk; an EXR carries none, so [`seal_exr`] writes a SHA-256 of the file beside the text. Not done: what the text means.

use super::ImageError;
use sha2::{Digest, Sha256};
use std::io::Cursor;

/// Hexadecimal digits of a SHA-256.
const DIGEST_LEN: usize = 64;
/// The attribute of an EXR: the digest, a space, the text.
const ATTRIBUTE: &str = "orreryRequest";

fn damaged(why: impl std::fmt::Display) -> ImageError {
    ImageError::Damaged(why.to_string())
}

/// The text under `key` in a whole PNG of that size.
pub fn png_text(bytes: &[u8], (width, height): (u32, u32), key: &str) -> Result<Option<String>, ImageError> {
    let mut options = png::DecodeOptions::default();
    options.set_skip_ancillary_crc_failures(false);
    let mut reader = png::Decoder::new_with_options(Cursor::new(bytes), options).read_info().map_err(damaged)?;
    if reader.info().size() != (width, height) {
        let (w, h) = reader.info().size();
        return Err(damaged(format!("{w}x{h} pixels")));
    }
    let mut pixels = vec![0; reader.output_buffer_size().ok_or_else(|| damaged("too large"))?];
    reader.next_frame(&mut pixels).map_err(damaged)?;
    reader.finish().map_err(damaged)?;
    let chunk = reader.info().utf8_text.iter().find(|c| c.keyword == key);
    chunk.map(|c| c.get_text().map_err(damaged)).transpose()
}

/// The attribute's value before the digest is known.
pub(super) fn unsealed(text: &str) -> (&'static str, String) {
    (ATTRIBUTE, format!("{} {text}", "0".repeat(DIGEST_LEN)))
}

/// Where the digest stands, and the text after it.
fn seal_of(bytes: &[u8]) -> Option<(usize, &str)> {
    let head: Vec<u8> = [ATTRIBUTE.as_bytes(), b"\0string\0"].concat();
    // Attributes stand at the beginning, before the offsets of the lines.
    let at = bytes.windows(head.len()).take(1 << 16).position(|w| w == head)? + head.len();
    let length = u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize;
    let value = bytes.get(at + 4..at.checked_add(4 + length)?)?;
    let text = value.get(DIGEST_LEN..)?.strip_prefix(b" ")?;
    Some((at + 4, std::str::from_utf8(text).ok()?))
}

fn digest_without(bytes: &[u8], at: usize) -> String {
    let mut hash = Sha256::new();
    hash.update(&bytes[..at]);
    hash.update([b'0'; DIGEST_LEN]);
    hash.update(&bytes[at + DIGEST_LEN..]);
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// Puts the digest of an EXR into its place.
pub(super) fn seal_exr(bytes: &mut [u8]) {
    if let Some((at, _)) = seal_of(bytes) {
        let digest = digest_without(bytes, at);
        bytes[at..at + DIGEST_LEN].copy_from_slice(digest.as_bytes());
    }
}

/// The sealed text of a whole EXR.
pub fn exr_text(bytes: &[u8]) -> Result<Option<String>, ImageError> {
    let Some((at, text)) = seal_of(bytes) else { return Ok(None) };
    if digest_without(bytes, at).as_bytes() != &bytes[at..at + DIGEST_LEN] {
        return Err(damaged("its bytes are not those that were written"));
    }
    Ok(Some(text.to_owned()))
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

    /// Every byte turned and every length: the text comes back from the file as it was written and from no other.
    #[test]
    fn no_byte_may_change_or_be_missing() {
        type Read = fn(&[u8]) -> Result<Option<String>, ImageError>;
        let png_read: Read = |b| png_text(b, SIZE, "Request");
        for (kind, bytes, read) in [("png", png(), png_read), ("exr", exr(), exr_text as Read)] {
            assert_eq!(read(&bytes).expect("whole").as_deref(), Some("mine"), "{kind}");
            let counts = |b: &[u8]| read(b).is_ok_and(|t| t.as_deref() == Some("mine"));
            for at in 0..bytes.len() {
                assert!(!counts(&bytes[..at]), "{kind} cut to {at} of {} bytes", bytes.len());
                for bit in [1_u8, 0x80] {
                    let mut turned = bytes.clone();
                    turned[at] ^= bit;
                    assert!(!counts(&turned), "{kind}: byte {at} of {} turned", bytes.len());
                }
            }
        }
        assert!(png_text(&png(), (5, 4), "Request").is_err() && png_text(&png(), SIZE, "Other").expect("whole").is_none());
    }
}
