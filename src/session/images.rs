//! Writes frames to files.
//!
//! In: a frame and its metadata. Out: a PNG or an EXR, depending on the name's extension. Always: an interrupted run leaves no partial image behind;
//! [`write_new_image`] never replaces a file, even if several programs write at the same time.

use crate::files::{FileAccess, WriteError, write_atomic, write_new};
use crate::image;
use crate::render::frame::Frame;
use std::fs::File;
use std::io::{BufWriter, Error};
use std::path::{Path, PathBuf};

/// The PNG chunk with the provenance ([`super::Provenance`]).
pub const PROVENANCE_CHUNK: &str = "Request";

/// Whether a file name is that of an EXR, which contains linear pixels.
pub fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Writes a frame. `text`: keyword and text of each text chunk of a PNG; an EXR contains only the `Legend` and the provenance. An EXR needs a frame with
/// linear pixels.
///
/// # Errors
/// The path and the reason.
pub fn write_image(path: &Path, frame: &Frame, text: &[(&'static str, String)]) -> Result<(), WriteError> {
    write_atomic(path, FileAccess::All, |out| encode_image(out, is_exr(path), frame, text))
}

/// As [`write_image`], but to the first of `paths` at which no file exists yet; returns this path. `is_exr`: the format, the same for all paths.
///
/// # Errors
/// The path and the reason.
pub fn write_new_image(
    paths: impl IntoIterator<Item = PathBuf>,
    is_exr: bool,
    frame: &Frame,
    text: &[(&'static str, String)],
) -> Result<PathBuf, WriteError> {
    write_new(paths, FileAccess::All, |out| encode_image(out, is_exr, frame, text))
}

fn encode_image(out: &mut BufWriter<&mut File>, is_exr: bool, frame: &Frame, text: &[(&'static str, String)]) -> std::io::Result<()> {
    if is_exr {
        let legend = text.iter().find(|(k, _)| *k == "Legend").map_or("", |(_, v)| v.as_str());
        let provenance = text.iter().find(|(k, _)| *k == PROVENANCE_CHUNK).map(|(_, v)| v.as_str());
        image::write_exr(out, frame.width, frame.height, &frame.hdr, legend, provenance).map_err(Error::other)
    } else {
        let text: Vec<(&str, &str)> = text.iter().map(|(k, v)| (*k, v.as_str())).collect();
        image::write_png(out, frame.width, frame.height, &frame.display, &text).map_err(Error::other)
    }
}
