//! The list of the temporary files that this process is writing, so that a process that ends early leaves none behind.
//!
//! In: temporary files when they are created. Out: the same files, renamed or removed. Always: a temporary file is in the list from its creation until it is
//! renamed or removed. After [`remove_unfinished`] no thread creates or renames one. Not here: files of killed processes (`remove_stale_once`).

use parking_lot::Mutex;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// An entry of the list, until it is dropped.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        UNFINISHED.lock().remove(&self.0);
    }
}

/// A temporary file. It is removed when this is dropped, unless it was renamed.
pub(super) struct TemporaryFile {
    // Dropped in this order: the file is removed before its entry.
    file: NamedTempFile,
    listed: Listed,
}

impl TemporaryFile {
    /// Creates a file by `create`.
    pub(super) fn new(create: impl FnOnce() -> Result<NamedTempFile>) -> Result<Self> {
        let mut unfinished = UNFINISHED.lock();
        let file = create()?;
        let listed = Listed(file.path().to_owned());
        unfinished.insert(listed.0.clone());
        Ok(Self { file, listed })
    }

    pub(super) fn as_file_mut(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Renames the file; it replaces an existing one.
    pub(super) fn persist(self, path: &Path) -> Result<()> {
        let Self { file, listed: _listed } = self;
        // While the lock is held, the process does not end: the rename cannot fail because the file was just removed.
        let _lock = UNFINISHED.lock();
        file.persist(path).map(drop).map_err(|e| e.error)
    }

    /// Renames the file unless `path` exists; then the file is returned beside the error.
    pub(super) fn persist_new(self, path: &Path) -> std::result::Result<(), (Error, Self)> {
        let Self { file, listed } = self;
        // Declared last, so that it is released before `listed`, which needs the lock to remove its entry.
        let _lock = UNFINISHED.lock();
        // A single system call checks and renames; between two separate calls another program could take the name.
        match file.persist_noclobber(path) {
            Ok(_) => Ok(()),
            Err(e) => Err((e.error, Self { file: e.file, listed })),
        }
    }
}

/// Removes all files that this process is writing. The process must end right after this call: a thread that creates, renames or drops a temporary file from
/// now on waits forever.
pub(crate) fn remove_unfinished() {
    let unfinished = UNFINISHED.lock();
    remove_all(unfinished.iter());
    std::mem::forget(unfinished);
}

/// A failure is ignored: the process ends in any case, and a later one removes the file when it is a day old.
fn remove_all<'a>(paths: impl Iterator<Item = &'a PathBuf>) {
    paths.for_each(|path| drop(std::fs::remove_file(path)));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of the process itself is tested with the program (`cli/interrupt`).
    #[test]
    fn a_temporary_file_is_listed_until_it_is_renamed_or_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let create = || TemporaryFile::new(|| NamedTempFile::new_in(folder.path())).expect("a file");
        // Other tests write files at the same time.
        let listed = || UNFINISHED.lock().iter().filter(|path| path.starts_with(folder.path())).cloned().collect::<Vec<_>>();
        let (renamed, refused, dropped, removed) = (create(), create(), create(), create());
        assert_eq!(listed().len(), 4);
        let taken = folder.path().join("a.txt");
        renamed.persist(&taken).expect("renamed");
        let (e, refused) = refused.persist_new(&taken).map_err(|(e, file)| (e.kind(), file)).expect_err("the name is taken");
        assert!(e == std::io::ErrorKind::AlreadyExists && listed().len() == 3, "{:?}", listed());
        drop(dropped);
        refused.persist_new(&folder.path().join("b.txt")).map_err(|(e, _)| e).expect("renamed");
        assert_eq!(listed(), [removed.file.path()]);
        remove_all(listed().iter());
        let mut left: Vec<_> = std::fs::read_dir(folder.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
        left.sort();
        assert_eq!(left, ["a.txt", "b.txt"]);
        drop(removed);
        assert!(listed().is_empty());
    }
}
