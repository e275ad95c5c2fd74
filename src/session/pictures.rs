//! What the user asked to keep, to files: whole or not at all.
//!
//! In: a frame and what it says of itself, or any bytes. Out: a PNG or an EXR, by the name's ending, or the bytes. Always: a file that is there is complete; an interrupted
//! run leaves no half picture to be taken for done.

use super::MARK_CHUNK;
use crate::image;
use crate::render::frame::Frame;
use crate::wording::echo;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Linear pixels, by the name's ending.
pub fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// `text`: chunks of the PNG; an EXR keeps the `Legend` and the mark of its request. An EXR needs a frame that kept its linear pixels.
///
/// # Errors
/// The path and why, in one line.
pub fn write_picture(path: &Path, frame: &Frame, text: &[(&'static str, String)]) -> Result<(), String> {
    write_whole(path, Readers::All, |out| {
        if is_exr(path) {
            let legend = text.iter().find(|(k, _)| *k == "Legend").map_or("", |(_, v)| v.as_str());
            let mark = text.iter().find(|(k, _)| *k == MARK_CHUNK).map(|(_, v)| v.as_str());
            image::write_exr(out, frame.width, frame.height, &frame.hdr, legend, mark).map_err(|e| e.to_string())
        } else {
            let text: Vec<(&str, &str)> = text.iter().map(|(k, v)| (*k, v.as_str())).collect();
            image::write_png(out, frame.width, frame.height, &frame.display, &text).map_err(|e| e.to_string())
        }
    })
}

/// Who may read a kept file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readers {
    All,
    /// Settings tell where someone lives.
    Owner,
}

/// Written beside its place and moved there whole.
///
/// # Errors
/// The path and why, in one line.
pub fn write_whole(
    path: &Path,
    readers: Readers,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), String>,
) -> Result<(), String> {
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", echo(&path.display().to_string()));
    // Opened here: the crate's own opening puts the temporary name into its message.
    let open = |at: &Path| private().open(at);
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().make_in(folder, open).map_err(|e| failed(&missing(e, folder)))?;
    {
        let mut out = BufWriter::new(file.as_file_mut());
        fill(&mut out).map_err(|e| failed(&e))?;
        out.flush().map_err(|e| failed(&e))?;
    }
    if readers == Readers::All {
        open_to_others(file.as_file());
    }
    file.persist(path).map_err(|e| failed(&e.error))?;
    Ok(())
}

/// A new file that nobody else may read.
fn private() -> std::fs::OpenOptions {
    let mut options = std::fs::OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options
}

/// Which folder is missing says more than that something is.
fn missing(e: std::io::Error, folder: &Path) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => format!("there is no folder {}; make it first", echo(&folder.display().to_string())),
        std::io::ErrorKind::NotADirectory => format!("{} is no folder", echo(&folder.display().to_string())),
        _ => e.to_string(),
    }
}

/// Temporary files are private; a picture is not.
#[cfg(unix)]
fn open_to_others(file: &File) {
    use std::os::unix::fs::PermissionsExt;
    // Failing leaves the picture readable by its owner alone, which is no reason to lose it.
    let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
}

#[cfg(not(unix))]
fn open_to_others(_file: &File) {}
