//! The folders of stored tables: what they hold, whether it is intact, and its removal.
//!
//! In: the cache folder. Out: numbers and sizes of tables, damaged ones, or the number of removed ones. Not here: which table has which name and content
//! (`air_tables`, `ring_shine_files`); so tables of other versions of the program and of other catalogs count like those in use.

use super::stored_tables::{self, EXTENSION, Magic};
use super::{air_tables, ring_shine_files};
use crate::files::{is_temporary, read_bytes, remove_if_present};
use std::path::{Path, PathBuf};

/// Largest table that is checked, bytes; real ones have less than a megabyte.
const MAX_TABLE_BYTES: u64 = 1 << 26;

/// Number and size of the stored tables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub(crate) struct StoredTablesStatus {
    pub entries: u64,
    pub bytes: u64,
}

/// The folders of stored tables of a cache folder.
pub(crate) struct StoredTables {
    /// Each with the first bytes of its files.
    folders: [(PathBuf, &'static Magic); 2],
}

/// The files of a folder; none if it cannot be read.
fn files_in(folder: &Path) -> impl Iterator<Item = PathBuf> {
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION)
}

impl StoredTables {
    /// `cache`: the folder that contains, or will contain, the folder `orrery/`.
    pub(crate) fn new(cache: &Path) -> Self {
        let folder = |name: &str| stored_tables::folder(cache, name);
        Self { folders: [(folder(air_tables::FOLDER), air_tables::MAGIC), (folder(ring_shine_files::FOLDER), ring_shine_files::MAGIC)] }
    }

    /// Counts the tables.
    pub(crate) fn status(&self) -> StoredTablesStatus {
        let tables = self.folders.iter().flat_map(|(folder, _)| files_in(folder)).filter(|path| is_table(path));
        tables.fold(StoredTablesStatus::default(), |sum, path| StoredTablesStatus {
            entries: sum.entries + 1,
            bytes: sum.bytes + path.metadata().map_or(0, |metadata| metadata.len()),
        })
    }

    /// Checks every table. Returns the number of intact ones, and the paths of the others with what is wrong.
    pub(crate) fn verify(&self) -> (u64, Vec<(PathBuf, String)>) {
        let (mut intact_count, mut damaged) = (0, Vec::new());
        for (folder, magic) in &self.folders {
            let mut tables: Vec<PathBuf> = files_in(folder).filter(|path| is_table(path)).collect();
            tables.sort();
            for path in tables {
                match read_bytes(&path, MAX_TABLE_BYTES) {
                    Ok(bytes) if stored_tables::decode(magic, &bytes).is_some() => intact_count += 1,
                    Ok(_) => damaged.push((path, "its checksum is wrong".into())),
                    Err(e) => damaged.push((path, e.to_string())),
                }
            }
        }
        (intact_count, damaged)
    }

    /// Removes all tables, and temporary files of crashed writers. Returns the number of files removed.
    pub(crate) fn clear(&self) -> std::io::Result<u64> {
        let mut removed_count = 0;
        for (folder, _) in &self.folders {
            for path in files_in(folder).filter(|path| is_table(path) || is_temporary(path)) {
                removed_count += u64::from(remove_if_present(&path)?);
            }
            // A folder that contains other files is kept.
            let _ = std::fs::remove_dir(folder);
        }
        Ok(removed_count)
    }
}
