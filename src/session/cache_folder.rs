//! Chooses the cache folder, which keeps shader library, tables and decoded maps between runs.
//!
//! In: the folder that the user named, if any. Out: that folder or the system's cache folder, or the reason why neither is used. Always: no other user can
//! write to it. Not here: its creation and its files.

use super::{CacheFolderError, air_tables, ring_shine_files};
use crate::files::foreign_write_access;
use crate::wording::echo;
use std::path::{Path, PathBuf};

/// The program's folders below `orrery/`, one for each kind of cached file.
const SUBFOLDERS: [&str; 4] = ["shaders", air_tables::FOLDER, ring_shine_files::FOLDER, "maps"];

/// The given cache folder, or else the user's cache folder on this system.
///
/// # Errors
/// The system has no cache folder, or other users could write to the folder.
pub fn cache_folder(cache: Option<&Path>) -> Result<PathBuf, CacheFolderError> {
    let system_folder = || directories::BaseDirs::new().map(|dirs| dirs.cache_dir().to_owned());
    let Some(folder) = cache.map(Path::to_owned).or_else(system_folder) else {
        return Err(CacheFolderError::None);
    };
    let program_folder = folder.join("orrery");
    let subfolders = SUBFOLDERS.map(|name| (program_folder.join(name), false));
    // `is_parent`: the folder is not the program's own, so its group may write to it.
    for (path, is_parent) in [(folder.clone(), true), (program_folder, false)].into_iter().chain(subfolders) {
        if let Some(why) = foreign_write_access(&path, is_parent) {
            return Err(CacheFolderError::Shared { folder: echo(&path.display().to_string()), why });
        }
    }
    Ok(folder)
}
