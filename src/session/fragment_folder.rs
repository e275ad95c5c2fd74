//! Reads a folder of shader fragments that override the built-in fragments.
//!
//! In: a folder. Out: when each of its `*.wesl` files was changed, and their texts by their paths inside the folder. Hidden files are ignored. Always: every
//! `*.wesl` file replaces a built-in fragment or is imported by a fragment; any other is an error. Not here: checks of the files' contents.

use crate::files::read_text;
use crate::shader::fragments::{FRAGMENTS, Fragments};
use crate::wording::{did_you_mean, echo};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Time of the last change, and length in bytes, of each file.
pub type FragmentTimes = BTreeMap<PathBuf, (SystemTime, u64)>;

/// The search follows this many levels of subfolders. The limit also ends cycles of links.
const MAX_DEPTH: usize = 8;
/// Largest number of fragment files.
const MAX_FILES: usize = 2000;
/// Largest fragment file, bytes; the longest built-in fragment has 14 kB.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Why a folder's fragments cannot be used. Each variant names the file or folder.
#[derive(Debug, thiserror::Error)]
pub enum FragmentFolderError {
    /// The system cannot read a file or folder.
    #[error("{path}: {source}")]
    Unreadable {
        /// File or folder.
        path: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// There is no such folder.
    #[error("{0}: there is no such folder; `orrery shader export` writes the shader sources into a folder")]
    NoFolder(String),
    /// The folder has more fragment files than the limit.
    #[error("{0}: more than {MAX_FILES} *.wesl files")]
    TooMany(String),
    /// The folder has a `.wgsl` fragment of an earlier version.
    #[error("{0}: shader sources are *.wesl files now; `orrery shader export` writes those of this version")]
    Outdated(String),
    /// The folder has no fragments.
    #[error("{0}: no *.wesl file is here; `orrery shader export` writes the shader sources into a folder")]
    Empty(String),
    /// A file neither replaces a built-in fragment nor is imported by a fragment.
    #[error("{path}: no shader source has this path, and none uses it; {hint}")]
    Unused {
        /// The file.
        path: String,
        /// A suggestion which fragment may have been meant.
        hint: String,
    },
}

fn shown_path(path: &Path) -> String {
    echo(&path.display().to_string())
}

fn unreadable(path: &Path, source: std::io::Error) -> FragmentFolderError {
    FragmentFolderError::Unreadable { path: shown_path(path), source }
}

/// Whether a file or folder is hidden. Editors and file systems keep locks, drafts and attributes of a file in hidden files, some with its extension; Emacs'
/// lock is a link without a target.
pub(super) fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

/// Every `*.wesl` file below a folder, except hidden ones, with the time of its last change and its length.
///
/// # Errors
/// No such folder, a file or folder that cannot be read, an outdated fragment, too many files, or no fragment at all.
pub fn fragment_times(folder: &Path) -> Result<FragmentTimes, FragmentFolderError> {
    if !folder.exists() {
        return Err(FragmentFolderError::NoFolder(shown_path(folder)));
    }
    let mut outdated = None;
    let (mut found, mut folders) = (FragmentTimes::new(), vec![(folder.to_owned(), 0)]);
    while let Some((subfolder, depth)) = folders.pop() {
        for entry in std::fs::read_dir(&subfolder).map_err(|e| unreadable(&subfolder, e))? {
            let path = entry.map_err(|e| unreadable(&subfolder, e))?.path();
            if is_hidden(&path) {
                continue;
            }
            let metadata = path.metadata().map_err(|e| unreadable(&path, e))?;
            if metadata.is_dir() {
                folders.extend((depth < MAX_DEPTH).then_some((path, depth + 1)));
            } else if metadata.is_file() && is_outdated_fragment(folder, &path) {
                outdated.get_or_insert(path);
            } else if metadata.is_file() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("wesl")) {
                // On a file system without times, only the length shows a change.
                let change_time = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                found.insert(path, (change_time, metadata.len()));
            }
        }
        if found.len() > MAX_FILES {
            return Err(FragmentFolderError::TooMany(shown_path(folder)));
        }
    }
    if let Some(path) = outdated {
        return Err(FragmentFolderError::Outdated(shown_path(&path)));
    }
    if found.is_empty() {
        return Err(FragmentFolderError::Empty(shown_path(folder)));
    }
    Ok(found)
}

/// Whether a file is named like a built-in fragment but has the extension `.wgsl`, which fragments had before they were written in WESL.
fn is_outdated_fragment(folder: &Path, path: &Path) -> bool {
    let relative_path = path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/");
    relative_path.strip_suffix(".wgsl").is_some_and(|stem| FRAGMENTS.iter().any(|(p, _)| p.strip_suffix(".wesl") == Some(stem)))
}

/// Reads the given fragment files of a folder.
///
/// # Errors
/// A file that cannot be read, or that neither replaces a built-in fragment nor is imported by a fragment.
pub fn read_fragments(folder: &Path, files: &FragmentTimes) -> Result<Fragments, FragmentFolderError> {
    let read_file = |path: &PathBuf| {
        let text = read_text(path, MAX_FILE_BYTES).map_err(|e| unreadable(path, e))?;
        let relative_path = path.strip_prefix(folder).unwrap_or(path);
        let parts: Vec<_> = relative_path.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        Ok((parts.join("/"), text))
    };
    let fragments = Fragments::with_files(files.keys().map(read_file).collect::<Result<Vec<_>, FragmentFolderError>>()?);
    match fragments.unused().first() {
        None => Ok(fragments),
        Some(path) => Err(FragmentFolderError::Unused { path: shown_path(&folder.join(path)), hint: suggestion(path) }),
    }
}

/// A suggestion for a path that no fragment has: a fragment with the same file name in another folder, or else one with a similar path.
fn suggestion(path: &str) -> String {
    let file_name = |p: &str| p.rsplit('/').next().unwrap_or_default().to_owned();
    let same_name: Vec<&str> = FRAGMENTS.iter().map(|(p, _)| *p).filter(|p| file_name(p) == file_name(path)).collect();
    match same_name.first() {
        Some(p) => format!("did you mean `{p}`?"),
        None => did_you_mean(path, FRAGMENTS.iter().map(|(p, _)| *p))
            .unwrap_or_else(|| "`orrery shader export` writes all built-in sources".into()),
    }
}
