//! One revision of the shader library: the entries in a folder, or the modules of a folder of fragments.
//!
//! In: a folder. Out: modules by id. Always: an entry gives the text and the tape that its revision wrote. Exception: if this program's software
//! renderer cannot run the tape, the module is lowered again. Fragments are emitted by this program's generator. A folder with several revisions is
//! an error: the caller must name one of them.

use crate::files::read_bytes;
use crate::session::{FragmentFolderError, fragment_times, read_fragments};
use crate::shader::fragments::Fragments;
use crate::shader::library::{EXTENSION, EntryError, MAX_ENTRY_BYTES, decode_of_any_generator, module_name};
use crate::shader::{Lowering, ModuleId, ShaderError, ShaderModule};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Why a folder cannot be opened as a revision, or why a module of a revision cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RevisionError {
    /// The folder cannot be read.
    #[error("{}: {source}", folder.display())]
    Folder { folder: PathBuf, source: std::io::Error },
    /// The folder contains neither entries nor fragments.
    #[error("{}: no shader library and no shader sources in it; `orrery library warm --cache DIR` writes a library, `orrery shader export DIR` the sources", .0.display())]
    Nothing(PathBuf),
    /// The folder contains libraries that several generators wrote.
    #[error("{} holds {} revisions; name the folder of one: {}", folder.display(), found.len(), found.join(", "))]
    Several {
        folder: PathBuf,
        /// The paths of the generators' folders.
        found: Vec<String>,
    },
    /// The content of an entry is invalid.
    #[error("{}: {why}", file.display())]
    Entry { file: PathBuf, why: EntryError },
    /// A file cannot be read.
    #[error("{}: {source}", file.display())]
    File { file: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Fragments(#[from] FragmentFolderError),
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

/// Where the modules of a revision come from.
enum Modules {
    /// Entry files by module.
    Entries(BTreeMap<ModuleId, PathBuf>),
    /// Fragments, from which any module can be emitted.
    Fragments(Box<Fragments>),
}

/// Modules of one revision.
pub struct Revision {
    /// Name in a report: the folder, or a word such as `built-in`.
    pub name: String,
    modules: Modules,
    /// Names of modules that this program cannot parse, because the keys of another revision have other words.
    unknown_names: BTreeSet<String>,
}

/// Everything in a folder. An error names this folder, which may lie below the folder that the user gave.
fn paths_in(folder: &Path) -> Result<Vec<PathBuf>, RevisionError> {
    let failed = |source| RevisionError::Folder { folder: folder.to_owned(), source };
    std::fs::read_dir(folder).map_err(failed)?.map(|entry| entry.map(|e| e.path()).map_err(failed)).collect()
}

/// The paths of the entries in a folder, sorted.
fn entries_in(folder: &Path) -> Result<Vec<PathBuf>, RevisionError> {
    let mut entries = Vec::new();
    for path in paths_in(folder)? {
        if path.extension().is_some_and(|e| e == EXTENSION) {
            entries.push(path);
        }
    }
    entries.sort();
    Ok(entries)
}

/// Folders below a library's root that contain entries: one for each generator.
fn generator_folders(root: &Path) -> Result<Vec<PathBuf>, RevisionError> {
    let mut found = Vec::new();
    for path in paths_in(root)? {
        if path.is_dir() && !entries_in(&path)?.is_empty() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

impl Revision {
    /// This program's own modules.
    pub fn built_in() -> Self {
        Self::of_fragments("built-in", Fragments::default())
    }

    /// The modules of these fragments.
    pub fn of_fragments(name: &str, fragments: Fragments) -> Self {
        Self { name: name.to_owned(), modules: Modules::Fragments(Box::new(fragments)), unknown_names: BTreeSet::new() }
    }

    /// The revision in a folder: one generator's folder of a library, a library with one generator, a cache folder with such a library (that of `--cache`, or
    /// the folder `orrery` in it, which `doctor` names), or fragments written by `orrery shader export`.
    ///
    /// # Errors
    /// The folder cannot be read, contains none of these, or contains several revisions.
    pub fn open(folder: &Path) -> Result<Self, RevisionError> {
        let entries = entries_in(folder)?;
        if !entries.is_empty() {
            return Self::of_entries(folder, entries);
        }
        for root in [folder.to_owned(), folder.join("orrery").join("shaders"), folder.join("shaders")] {
            if !root.is_dir() {
                continue;
            }
            let found = generator_folders(&root)?;
            match &found[..] {
                [] => {}
                [one] => return Self::of_entries(one, entries_in(one)?),
                several => {
                    let found = several.iter().map(|p| p.display().to_string()).collect();
                    return Err(RevisionError::Several { folder: folder.to_owned(), found });
                }
            }
        }
        match fragment_times(folder) {
            Err(FragmentFolderError::Empty(_)) => Err(RevisionError::Nothing(folder.to_owned())),
            Err(e) => Err(e.into()),
            Ok(times) => Ok(Self::of_fragments(&folder.display().to_string(), read_fragments(folder, &times)?)),
        }
    }

    /// The revision of the entry files of one generator. `folder`: the folder that holds them.
    fn of_entries(folder: &Path, files: Vec<PathBuf>) -> Result<Self, RevisionError> {
        let (mut entries, mut unknown_names) = (BTreeMap::new(), BTreeSet::new());
        for file in files {
            let id_of_name = file.file_stem().and_then(|s| s.to_str()).and_then(|name| name.parse().ok());
            let id = match id_of_name {
                Some(id) => id,
                // The name of a long key is shortened, so the id is read from the entry itself.
                None => {
                    let name = module_name(&read_entry(&file)?).map_err(|why| RevisionError::Entry { file: file.clone(), why })?;
                    let Ok(id) = name.parse() else {
                        unknown_names.insert(name);
                        continue;
                    };
                    id
                }
            };
            entries.insert(id, file);
        }
        Ok(Self { name: folder.display().to_string(), modules: Modules::Entries(entries), unknown_names })
    }

    /// The modules of a library; `None` for fragments, which can emit any module.
    pub fn ids(&self) -> Option<Vec<ModuleId>> {
        match &self.modules {
            Modules::Entries(entries) => Some(entries.keys().cloned().collect()),
            Modules::Fragments(_) => None,
        }
    }

    /// Names of the revision's modules that this program cannot parse and therefore cannot compare.
    pub(crate) fn unknown_names(&self) -> &BTreeSet<String> {
        &self.unknown_names
    }

    /// A module; `None` if the library has no entry for it.
    ///
    /// # Errors
    /// The entry cannot be read, or the fragments give no valid module.
    pub(crate) fn module(&self, id: &ModuleId, lowering: &Lowering) -> Result<Option<ShaderModule>, RevisionError> {
        match &self.modules {
            Modules::Fragments(fragments) => Ok(Some(ShaderModule::build_with(fragments, id, lowering)?)),
            Modules::Entries(entries) => {
                let Some(file) = entries.get(id) else { return Ok(None) };
                let module = decode_of_any_generator(id, &read_entry(file)?, lowering);
                module.map(Some).map_err(|why| RevisionError::Entry { file: file.clone(), why })
            }
        }
    }
}

fn read_entry(file: &Path) -> Result<Vec<u8>, RevisionError> {
    read_bytes(file, MAX_ENTRY_BYTES).map_err(|source| RevisionError::File { file: file.to_owned(), source })
}
