//! A folder of shader fragments that override the built-in ones.
//!
//! In: a folder. Out: its `*.wesl` files by their paths inside it, and when each was changed. Always: every file replaces a built-in fragment or is imported by one; any other file is an error.
//! Not here: checking their contents.

use crate::files::read_text;
use crate::shader::fragments::{FRAGMENTS, Fragments};
use crate::wording::{did_you_mean, echo};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Time of the last change and length of each file.
pub type FragmentTimes = BTreeMap<PathBuf, (SystemTime, u64)>;

/// Maximum depth and number of files in the search; the depth limit also ends cycles of links.
const MAX_DEPTH: usize = 8;
const MAX_FILES: usize = 2000;
/// Largest fragment file, bytes; the longest built-in fragment has some 10 kB.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Why a folder's fragments cannot be used: the file or folder, and what is wrong with it.
#[derive(Debug, thiserror::Error)]
pub enum FragmentFolderError {
    /// The system cannot read it.
    #[error("{path}: {source}")]
    Unreadable {
        /// File or folder.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// More files than the limit.
    #[error("{0}: more than {MAX_FILES} *.wesl files")]
    TooMany(String),
    /// A `.wgsl` fragment of an earlier version.
    #[error("{0}: fragments are *.wesl files now; `orrery shader export` writes those of this version")]
    Outdated(String),
    /// The folder has no fragment.
    #[error("{0}: no *.wesl file is here; `orrery shader export` writes the fragments into a folder")]
    Empty(String),
    /// A file longer than a megabyte.
    #[error("{0}: longer than any fragment")]
    TooLong(String),
    /// A file that replaces no built-in fragment and that none imports.
    #[error("{path}: no fragment has this path, and none uses it; {hint}")]
    Unused {
        /// The file.
        path: String,
        /// Which one may have been meant.
        hint: String,
    },
}

fn shown(path: &Path) -> String {
    echo(&path.display().to_string())
}

fn unreadable(path: &Path, source: std::io::Error) -> FragmentFolderError {
    FragmentFolderError::Unreadable { path: shown(path), source }
}

/// Every `*.wesl` file below a folder.
///
/// # Errors
/// What cannot be read, or that there is no fragment.
pub fn fragment_times(folder: &Path) -> Result<FragmentTimes, FragmentFolderError> {
    let folder_of_all = folder.to_owned();
    let mut old = None;
    let (mut found, mut folders) = (FragmentTimes::new(), vec![(folder.to_owned(), 0)]);
    while let Some((folder, depth)) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(|e| unreadable(&folder, e))? {
            let path = entry.map_err(|e| unreadable(&folder, e))?.path();
            let about = path.metadata().map_err(|e| unreadable(&path, e))?;
            if about.is_dir() {
                folders.extend((depth < MAX_DEPTH).then_some((path, depth + 1)));
            } else if about.is_file() && is_old_fragment(&folder_of_all, &path) {
                old.get_or_insert(path);
            } else if about.is_file() && path.extension().is_some_and(|e| e == "wesl") {
                let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                found.insert(path, (changed, about.len()));
            }
        }
        if found.len() > MAX_FILES {
            return Err(FragmentFolderError::TooMany(shown(&folder)));
        }
    }
    if let Some(path) = old {
        return Err(FragmentFolderError::Outdated(shown(&path)));
    }
    if found.is_empty() {
        return Err(FragmentFolderError::Empty(shown(folder)));
    }
    Ok(found)
}

/// Whether a file has the path of a fragment from before the move to WESL.
fn is_old_fragment(folder: &Path, path: &Path) -> bool {
    let inside = path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/");
    inside.strip_suffix(".wgsl").is_some_and(|stem| FRAGMENTS.iter().any(|(p, _)| p.strip_suffix(".wesl") == Some(stem)))
}

/// The fragments of a folder whose files are these.
///
/// # Errors
/// A file that cannot be read, or that neither replaces a built-in fragment nor is imported by one.
pub fn read_fragments(folder: &Path, files: &FragmentTimes) -> Result<Fragments, FragmentFolderError> {
    let one = |path: &PathBuf| {
        let text = read_text(path, MAX_FILE_BYTES).map_err(|e| unreadable(path, e))?;
        let inside = path.strip_prefix(folder).unwrap_or(path);
        let parts: Vec<_> = inside.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        Ok((parts.join("/"), text))
    };
    let fragments = Fragments::with_files(files.keys().map(one).collect::<Result<Vec<_>, FragmentFolderError>>()?);
    match fragments.unused().first() {
        None => Ok(fragments),
        Some(path) => Err(FragmentFolderError::Unused { path: shown(&folder.join(path)), hint: suggestion(path) }),
    }
}

/// The fragment that a path may have meant: by the whole path, or by the same file name in another folder.
fn suggestion(path: &str) -> String {
    let last = |p: &str| p.rsplit('/').next().unwrap_or_default().to_owned();
    let same_name: Vec<&str> = FRAGMENTS.iter().map(|(p, _)| *p).filter(|p| last(p) == last(path)).collect();
    match same_name.first() {
        Some(p) => format!("did you mean `{p}`?"),
        None => {
            did_you_mean(path, FRAGMENTS.iter().map(|(p, _)| *p)).unwrap_or_else(|| "`orrery shader export` writes all there are".into())
        }
    }
}
