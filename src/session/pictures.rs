//! What the user asked to keep, to files: whole or not at all.
//!
//! In: a frame and what it says of itself, or any bytes. Out: a PNG or an EXR, by the name's ending, or the bytes. Always: a file that is there is complete; an interrupted
//! run leaves no half picture to be taken for done; what is written under a new name replaces nothing, whoever writes beside it.

use crate::image;
use crate::render::frame::Frame;
use crate::wording::echo;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The name of the PNG chunk that holds what the picture is of ([`super::Provenance`]).
pub const PROVENANCE_CHUNK: &str = "Request";

/// Linear pixels, by the name's ending.
pub fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// `text`: chunks of the PNG; an EXR keeps the `Legend` and the mark of its request. An EXR needs a frame that kept its linear pixels.
///
/// # Errors
/// The path and why, in one line.
pub fn write_picture(path: &Path, frame: &Frame, text: &[(&'static str, String)]) -> Result<(), String> {
    write_whole(path, FileAccess::All, |out| fill_picture(out, is_exr(path), frame, text))
}

/// The same as [`write_new`] writes: all names have one ending.
///
/// # Errors
/// The path and why, in one line.
pub fn write_new_picture(
    names: impl IntoIterator<Item = PathBuf>,
    is_exr: bool,
    frame: &Frame,
    text: &[(&'static str, String)],
) -> Result<PathBuf, String> {
    write_new(names, FileAccess::All, |out| fill_picture(out, is_exr, frame, text))
}

fn fill_picture(out: &mut BufWriter<&mut File>, is_exr: bool, frame: &Frame, text: &[(&'static str, String)]) -> Result<(), String> {
    if is_exr {
        let legend = text.iter().find(|(k, _)| *k == "Legend").map_or("", |(_, v)| v.as_str());
        let mark = text.iter().find(|(k, _)| *k == PROVENANCE_CHUNK).map(|(_, v)| v.as_str());
        image::write_exr(out, frame.width, frame.height, &frame.hdr, legend, mark).map_err(|e| e.to_string())
    } else {
        let text: Vec<(&str, &str)> = text.iter().map(|(k, v)| (*k, v.as_str())).collect();
        image::write_png(out, frame.width, frame.height, &frame.display, &text).map_err(|e| e.to_string())
    }
}

/// Who may read a kept file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileAccess {
    /// Every user of the machine.
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
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), String>,
) -> Result<(), String> {
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", echo(&path.display().to_string()));
    filled(path, readers, fill).and_then(|file| file.persist(path).map_err(|e| failed(&e.error)))?;
    Ok(())
}

/// Written beside its place and moved whole to the first of `names`, all of one folder, that no file has; answers which it is.
///
/// # Errors
/// The path and why, in one line: no name is free, for one.
pub fn write_new(
    names: impl IntoIterator<Item = PathBuf>,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), String>,
) -> Result<PathBuf, String> {
    let mut names = names.into_iter();
    let mut name = names.next().ok_or("no name to write to")?;
    let mut file = filled(&name, readers, fill)?;
    loop {
        // One step of the system: between looking and moving another program could take the name.
        match file.persist_noclobber(&name) {
            Ok(_) => return Ok(name),
            Err(e) if e.error.kind() == ErrorKind::AlreadyExists => {
                let taken = || format!("{}: a file of this name exists already", name.display());
                file = e.file;
                name = names.next().ok_or_else(taken)?;
            }
            Err(e) => return Err(format!("{}: {}", name.display(), e.error)),
        }
    }
}

/// The content of `path`, whole, under another name of its folder.
fn filled(
    path: &Path,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), String>,
) -> Result<NamedTempFile, String> {
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
    if readers == FileAccess::All {
        open_to_others(file.as_file());
    }
    Ok(file)
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
        ErrorKind::NotFound => format!("there is no folder {}; make it first", echo(&folder.display().to_string())),
        ErrorKind::NotADirectory => format!("{} is no folder", echo(&folder.display().to_string())),
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn numbered(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
        let folder = folder.to_owned();
        (1..).map(move |n| folder.join(format!("a-{n}.txt")))
    }

    /// Eight writers at once, each ten files, beside files of others: nothing is lost and nothing replaced.
    #[test]
    fn what_is_written_under_a_new_name_replaces_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let others = [2, 5, 41];
        for n in others {
            std::fs::write(folder.path().join(format!("a-{n}.txt")), "another's").expect("a file");
        }
        let write = |writer: usize, k: usize| {
            let text = format!("{writer} {k}");
            write_new(numbered(folder.path()), FileAccess::All, |out| out.write_all(text.as_bytes()).map_err(|e| e.to_string()))
        };
        let written: Vec<(String, PathBuf)> = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..8)
                .map(|w| scope.spawn(move || (0..10).map(|k| (format!("{w} {k}"), write(w, k).expect("a file"))).collect::<Vec<_>>()))
                .collect();
            writers.into_iter().flat_map(|w| w.join().expect("a writer")).collect()
        });
        let names: BTreeSet<&PathBuf> = written.iter().map(|(_, path)| path).collect();
        assert_eq!(names.len(), 80, "two writers have one name");
        for (text, path) in &written {
            assert_eq!(&std::fs::read_to_string(path).expect("a file"), text, "{}", path.display());
        }
        for n in others {
            assert_eq!(std::fs::read_to_string(folder.path().join(format!("a-{n}.txt"))).expect("a file"), "another's");
        }
        // No name is left out, and nothing else is left behind.
        let expected: BTreeSet<String> = (1..=83).map(|n| format!("a-{n}.txt")).collect();
        let found = std::fs::read_dir(folder.path()).expect("a folder");
        let found: BTreeSet<String> = found.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn names_that_are_all_taken_are_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let name = folder.path().join("a.txt");
        std::fs::write(&name, "first").expect("a file");
        let why = write_new([name.clone()], FileAccess::All, |_| Ok(())).expect_err("it is taken");
        assert!(why.contains("a.txt") && why.contains("exists already") && !why.contains('\n'), "{why}");
        assert_eq!(std::fs::read_to_string(&name).expect("a file"), "first");
        let nowhere = folder.path().join("none").join("b.txt");
        assert!(write_new([nowhere], FileAccess::All, |_| Ok(())).is_err_and(|why| why.contains("b.txt")));
    }
}
