//! The shader library: a cache of modules, in memory and on disk.
//!
//! In: a module's name. Out: a shared [`ShaderModule`], from memory, from disk, or newly emitted. Always: the module is the one that the generator (the emitter
//! with its fragments) would emit now, even if entries on disk are damaged, unless an entry was tampered with (see [`ShaderLibrary::replace_tampered`]);
//! readers in any process see either a complete entry or none; disk errors are never fatal, and only the first in reading and the first in writing are
//! reported. Not here: the lowering of modules for the software renderer, and where messages go; the caller supplies both.

mod entry;

pub(crate) use entry::file_stem;
pub use entry::{EXTENSION, EntryError, decode, decode_of_any_generator, file_name, module_name};

use super::fragments::Fragments;
use super::generator;
use super::{Lowering, ModuleId, ShaderError, ShaderModule};
use crate::files::{is_temporary, read_bytes, remove_if_present, write_cached};
use crate::memo::LruMap;
use parking_lot::{Mutex, RwLock};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Maximum size of an entry in bytes; the largest entries have about 300 kB.
pub const MAX_ENTRY_BYTES: u64 = 1 << 24;

/// A module with its origin, or the error, once it has been loaded or built.
type ModuleCell = Arc<OnceLock<Result<(Arc<ShaderModule>, Origin), ShaderError>>>;

/// Where a module came from, and how long that took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    pub outcome: CacheOutcome,
    /// Time to read or build the module.
    pub took_ms: f64,
}

/// How the library got a module that was not in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CacheOutcome {
    /// Read from a valid entry on disk.
    Read,
    /// Emitted because there was no entry.
    Emitted,
    /// Emitted because the entry was damaged, of another format or tampered with; the new module replaces it.
    Repaired,
}

/// Counts since the library was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Statistics {
    /// Modules that came from memory.
    pub from_memory: u64,
    /// Modules that came from disk.
    pub from_disk: u64,
    /// Time spent reading these modules.
    pub reading_s: f64,
    /// Modules emitted, parsed, validated and lowered.
    pub emitted: u64,
    /// Time spent on emitting, parsing, validating and lowering.
    pub emitting_s: f64,
    /// Entries written.
    pub written: u64,
    /// Time spent writing these entries.
    pub writing_s: f64,
    /// Entries on disk that were damaged, of another format or tampered with, and were replaced ([`CacheOutcome::Repaired`]). The serialised name is `healed`.
    #[serde(rename = "healed")]
    pub repaired: u64,
}

#[derive(Default)]
struct Counters {
    from_memory: AtomicU64,
    from_disk: AtomicU64,
    reading_ns: AtomicU64,
    emitted: AtomicU64,
    emitting_ns: AtomicU64,
    written: AtomicU64,
    writing_ns: AtomicU64,
    repaired: AtomicU64,
}

/// Counts an event that began at `since`: adds 1 to `counter`, and the elapsed time to `nanoseconds`.
fn count(counter: &AtomicU64, nanoseconds: &AtomicU64, since: Instant) {
    counter.fetch_add(1, Ordering::Relaxed);
    nanoseconds.fetch_add(u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
}

/// The error for an entry on disk that cannot be used (damaged, or of another format); its module is built anew.
struct Unusable;

/// The content of the disk cache.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DiskStatus {
    /// Folder with the modules of this generator (these fragments and this code); `None` if the library is only in memory or has edited fragments.
    pub folder: Option<PathBuf>,
    /// Number of entries of this generator.
    pub entries: u64,
    /// Bytes of those entries.
    pub bytes: u64,
    /// Number of entries of other generators (older or newer programs).
    pub other_entries: u64,
    /// Bytes of the entries of other generators.
    pub other_bytes: u64,
    /// The first folder that could not be read, and why; the counts do not include it.
    pub unreadable: Option<String>,
}

/// The result of [`ShaderLibrary::verify`].
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DiskCheck {
    /// Number of valid entries: those equal to what the generator emits now. The serialised name is `whole`.
    #[serde(rename = "whole")]
    pub valid: u64,
    /// Damaged entries: the file, and what is wrong with it.
    pub damaged: Vec<(PathBuf, String)>,
    /// The first folder that could not be read, and why.
    pub unreadable: Option<String>,
}

/// The part of the generator that [`ShaderLibrary::set_fragments`] can change: the fragments, and the generator digest (`shader::generator`), which covers
/// fragments and code.
#[derive(Clone)]
struct Generator {
    fragments: Arc<Fragments>,
    digest: Arc<str>,
}

impl Generator {
    fn of(fragments: Fragments, lowering: &Lowering) -> Self {
        let digest = generator::digest_with(&fragments, &lowering.digest).into();
        Self { fragments: Arc::new(fragments), digest }
    }
}

/// Maximum number of modules in memory, each of about a quarter of a megabyte. A view of the whole system with all effects needs about
/// forty. An evicted module is read again from disk within a millisecond. The software renderer keeps as many decoded tapes.
pub(crate) const MODULES_KEPT: usize = 96;

/// A cache of modules by name, in memory and on disk; shared between threads.
pub struct ShaderLibrary {
    /// `<cache>/orrery/shaders`; `None` for a library that is only in memory.
    root: Option<PathBuf>,
    generator: RwLock<Generator>,
    lowering: Lowering,
    modules: Mutex<LruMap<ModuleId, ModuleCell>>,
    counters: Counters,
    /// Receives one line for each problem.
    report: Box<dyn Fn(&str) + Send + Sync>,
    write_error_reported: AtomicBool,
    read_error_reported: AtomicBool,
}

impl ShaderLibrary {
    /// A library in a cache directory, which need not exist. `report` receives one line for each problem.
    pub fn open(cache: &Path, lowering: Lowering, report: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self::new(Some(cache.join("orrery").join("shaders")), lowering, Box::new(report))
    }

    /// A library that is only in memory.
    pub fn in_memory(lowering: Lowering) -> Self {
        Self::new(None, lowering, Box::new(|_| {}))
    }

    fn new(root: Option<PathBuf>, lowering: Lowering, report: Box<dyn Fn(&str) + Send + Sync>) -> Self {
        Self {
            root,
            generator: RwLock::new(Generator::of(Fragments::default(), &lowering)),
            lowering,
            modules: Mutex::new(LruMap::with_capacity(MODULES_KEPT)),
            counters: Counters::default(),
            report,
            write_error_reported: AtomicBool::new(false),
            read_error_reported: AtomicBool::new(false),
        }
    }

    /// The generator digest, which names the folder of modules on disk.
    pub fn generator_digest(&self) -> Arc<str> {
        self.current_generator().digest
    }

    /// The fragments that modules are built from.
    pub fn fragments(&self) -> Arc<Fragments> {
        self.current_generator().fragments
    }

    fn current_generator(&self) -> Generator {
        self.generator.read().clone()
    }

    /// Builds modules from these fragments from now on, and drops the modules in memory. Unless the fragments are the built-in ones, no module is read from or
    /// written to disk.
    pub fn set_fragments(&self, fragments: Fragments) {
        let generator = Generator::of(fragments, &self.lowering);
        *self.generator.write() = generator;
        self.modules.lock().clear();
    }

    /// The folder of this generator on disk, if it has one.
    fn folder(&self) -> Option<PathBuf> {
        Some(self.root.as_ref()?.join(&*self.generator_if_built_in()?.digest))
    }

    /// The generator; `None` if its fragments are edited. Modules of edited fragments are not kept on disk, because every edit would leave a folder behind.
    fn generator_if_built_in(&self) -> Option<Generator> {
        Some(self.current_generator()).filter(|g| g.fragments.are_built_in())
    }

    /// Where a module came from, and how long that took; `None` for a module that is not in memory or could not be
    /// built.
    pub fn origin(&self, id: &ModuleId) -> Option<Origin> {
        let modules = self.modules.lock();
        Some(modules.peek(id)?.get()?.as_ref().ok()?.1)
    }

    /// Path of a module's entry, whether or not the file exists; `None` if the library has no folder ([`DiskStatus::folder`]).
    pub fn entry_path(&self, id: &ModuleId) -> Option<PathBuf> {
        Some(self.folder()?.join(file_name(id)))
    }

    /// Returns the module. Concurrent requests for one module wait for the first of them.
    pub fn get(&self, id: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        let cell = {
            let mut modules = self.modules.lock();
            modules.get(id).unwrap_or_else(|| {
                let cell = ModuleCell::default();
                modules.insert(id.clone(), Arc::clone(&cell));
                cell
            })
        };
        if cell.get().is_some() {
            self.counters.from_memory.fetch_add(1, Ordering::Relaxed);
        }
        cell.get_or_init(|| self.load_or_build(id)).as_ref().map(|(module, _)| Arc::clone(module)).map_err(Clone::clone)
    }

    fn is_in_memory(&self, id: &ModuleId) -> bool {
        self.modules.lock().peek(id).is_some_and(|cell| cell.get().is_some())
    }

    fn load_or_build(&self, id: &ModuleId) -> Result<(Arc<ShaderModule>, Origin), ShaderError> {
        let generator = self.current_generator();
        // Not `entry_path`: another thread may change the fragments, and module and path must be of the same generator.
        let root = self.root.as_ref().filter(|_| generator.fragments.are_built_in());
        let path = root.map(|root| root.join(&*generator.digest).join(file_name(id)));
        let start_of_request = Instant::now();
        let origin = |outcome: CacheOutcome| Origin { outcome, took_ms: start_of_request.elapsed().as_secs_f64() * 1e3 };
        let mut outcome = CacheOutcome::Emitted;
        if let Some(path) = path.as_deref() {
            match self.read(&generator.digest, id, path) {
                Some(Ok(module)) => return Ok((Arc::new(module), origin(CacheOutcome::Read))),
                Some(Err(Unusable)) => outcome = CacheOutcome::Repaired,
                None => {}
            }
        }
        let start = Instant::now();
        let module = ShaderModule::build_with(&generator.fragments, id, &self.lowering)?;
        count(&self.counters.emitted, &self.counters.emitting_ns, start);
        let origin = origin(outcome);
        if let Some(path) = &path {
            self.write(&generator.digest, &module, path);
        }
        Ok((Arc::new(module), origin))
    }

    /// Reads an entry from disk; `None` if there is no readable file.
    fn read(&self, generator_digest: &str, id: &ModuleId, path: &Path) -> Option<Result<ShaderModule, Unusable>> {
        let start = Instant::now();
        let bytes = match read_bytes(path, MAX_ENTRY_BYTES) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return None,
            // An entry that cannot be read is reported here; if the folder's path is not a folder (`NotADirectory`), the failing write reports it.
            Err(e) => {
                if e.kind() != std::io::ErrorKind::NotADirectory && !self.read_error_reported.swap(true, Ordering::Relaxed) {
                    (self.report)(&format!("shader library: {} cannot be read ({e}); its module is rebuilt", path.display()));
                }
                return None;
            }
        };
        match decode(generator_digest, id, &bytes, &self.lowering) {
            Ok(module) => {
                count(&self.counters.from_disk, &self.counters.reading_ns, start);
                Some(Ok(module))
            }
            Err(e) => {
                self.counters.repaired.fetch_add(1, Ordering::Relaxed);
                (self.report)(&format!("shader library: {} is replaced: {e}", path.display()));
                Some(Err(Unusable))
            }
        }
    }

    fn write(&self, generator_digest: &str, module: &ShaderModule, path: &Path) {
        // After one failure nothing more is written: on a full or read-only disk further attempts would only cost time.
        if self.cannot_be_written() {
            return;
        }
        // A folder or a pipe in the place of this entry is never replaced. `read` has reported it, and other entries can still be written.
        if path.metadata().is_ok_and(|existing| !existing.is_file()) {
            return;
        }
        let start = Instant::now();
        let Some(bytes) = entry::encode(generator_digest, module) else { return };
        match write_cached(path, &bytes) {
            Ok(()) => count(&self.counters.written, &self.counters.writing_ns, start),
            Err(e) => {
                if !self.write_error_reported.swap(true, Ordering::Relaxed) {
                    let folder = path.parent().unwrap_or(path).display();
                    (self.report)(&format!(
                        "shader library: {folder} cannot be written ({e}); modules are kept in memory only unless --cache DIR names another folder"
                    ));
                }
            }
        }
    }

    /// Loads or builds these modules on all cores; `done` is called after each. Returns the failures.
    pub fn warm(&self, ids: &[ModuleId], done: impl Fn() + Sync) -> Vec<ShaderError> {
        self.warm_while(ids, || true, done)
    }

    /// As [`Self::warm`], but once a module could not be written to disk, the remaining modules are left out ([`Self::cannot_be_written`]).
    pub fn warm_on_disk(&self, ids: &[ModuleId], done: impl Fn() + Sync) -> Vec<ShaderError> {
        self.warm_while(ids, || !self.cannot_be_written(), done)
    }

    /// Whether a module could not be written to disk. `report` has said why, and nothing more is written.
    pub fn cannot_be_written(&self) -> bool {
        self.write_error_reported.load(Ordering::Relaxed)
    }

    fn warm_while(&self, ids: &[ModuleId], continues: impl Fn() -> bool + Sync, done: impl Fn() + Sync) -> Vec<ShaderError> {
        let load = |id: &ModuleId| {
            if !continues() {
                return None;
            }
            let failure = self.get(id).err();
            done();
            failure
        };
        // Modules in memory are looked up on this thread, because the thread pool may be busy drawing.
        let (in_memory, missing): (Vec<&ModuleId>, Vec<&ModuleId>) = ids.iter().partition(|id| self.is_in_memory(id));
        let mut failures: Vec<ShaderError> = in_memory.into_iter().filter_map(load).collect();
        failures.par_extend(missing.into_par_iter().filter_map(load));
        failures
    }

    pub fn statistics(&self) -> Statistics {
        let counters = &self.counters;
        let number = |n: &AtomicU64| n.load(Ordering::Relaxed);
        let seconds = |n: &AtomicU64| Duration::from_nanos(n.load(Ordering::Relaxed)).as_secs_f64();
        Statistics {
            from_memory: number(&counters.from_memory),
            from_disk: number(&counters.from_disk),
            reading_s: seconds(&counters.reading_ns),
            emitted: number(&counters.emitted),
            emitting_s: seconds(&counters.emitting_ns),
            written: number(&counters.written),
            writing_s: seconds(&counters.writing_ns),
            repaired: number(&counters.repaired),
        }
    }

    /// Counts the entries on disk.
    pub fn status(&self) -> DiskStatus {
        let digest = self.generator_digest();
        let mut status = DiskStatus { folder: self.folder(), unreadable: self.unreadable_folder_message(), ..DiskStatus::default() };
        for folder in self.folders() {
            let is_own = folder.file_name().is_some_and(|n| n == &*digest);
            for file in entries_in(&folder) {
                let bytes = file.metadata().map_or(0, |m| m.len());
                let (entries, total) =
                    if is_own { (&mut status.entries, &mut status.bytes) } else { (&mut status.other_entries, &mut status.other_bytes) };
                *entries += 1;
                *total += bytes;
            }
        }
        status
    }

    /// Reads every entry of this generator, builds its module anew and compares the two, on all cores.
    pub fn verify(&self) -> DiskCheck {
        let mut check = DiskCheck { unreadable: self.unreadable_folder_message(), ..DiskCheck::default() };
        let mut files: Vec<_> = self.folder().iter().flat_map(|f| entries_in(f)).collect();
        files.sort();
        let results: Vec<_> = files.into_par_iter().map(|file| (self.verify_file(&file), file)).collect();
        for (result, file) in results {
            match result {
                Ok(()) => check.valid += 1,
                Err(what) => check.damaged.push((file, what)),
            }
        }
        check
    }

    fn verify_file(&self, file: &Path) -> Result<(), String> {
        let bytes = read_bytes(file, MAX_ENTRY_BYTES).map_err(|e| e.to_string())?;
        let digest = self.generator_digest();
        let name = entry::module_name_if_written_by(&digest, &bytes).map_err(|e| e.to_string())?;
        let id: ModuleId = name.parse().map_err(|e: super::key::KeyTextError| e.to_string())?;
        // The file may have been renamed.
        if file.file_name().is_none_or(|n| n != file_name(&id).as_str()) {
            return Err(EntryError::OtherGeneratorOrModule.to_string());
        }
        decode(&digest, &id, &bytes, &self.lowering).map_err(|e| e.to_string())?;
        let built = ShaderModule::build_with(&self.current_generator().fragments, &id, &self.lowering).map_err(|e| e.to_string())?;
        if entry::encode(&digest, &built).as_deref() == Some(&bytes) {
            Ok(())
        } else {
            Err("it differs from what the generator emits".into())
        }
    }

    /// To be called after a plan or a frame with these modules failed. Builds anew those modules that came from disk, and replaces each that differs from its
    /// new build, in memory and on disk. The entry of such a module was tampered with: it decodes, but was not written by the generator. Returns the number of
    /// replaced modules.
    pub fn replace_tampered(&self, ids: &[ModuleId]) -> usize {
        let generator = self.current_generator();
        let rebuilt_if_tampered = |id: &ModuleId| {
            let cell = self.modules.lock().peek(id).cloned()?;
            let Some(Ok((loaded, Origin { outcome: CacheOutcome::Read, .. }))) = cell.get() else { return None };
            let start = Instant::now();
            let built = ShaderModule::build_with(&generator.fragments, id, &self.lowering).ok()?;
            let origin = Origin { outcome: CacheOutcome::Repaired, took_ms: start.elapsed().as_secs_f64() * 1e3 };
            let is_tampered = entry::encode(&generator.digest, &built) != entry::encode(&generator.digest, loaded);
            is_tampered.then_some((built, origin))
        };
        let mut replaced = 0;
        for id in ids {
            let (Some((built, origin)), Some(path)) = (rebuilt_if_tampered(id), self.entry_path(id)) else { continue };
            (self.report)(&format!("shader library: {} is not used: it differs from what the generator emits", path.display()));
            self.counters.repaired.fetch_add(1, Ordering::Relaxed);
            self.write(&generator.digest, &built, &path);
            // In memory too: if the entry cannot be written, reading it again would make the caller fail again, without end.
            self.modules.lock().insert(id.clone(), Arc::new(OnceLock::from(Ok((Arc::new(built), origin)))));
            replaced += 1;
        }
        replaced
    }

    /// Removes every entry of every generator, and temporary files of crashed writers. Returns the number of files removed.
    ///
    /// # Errors
    /// A file cannot be removed, or a folder cannot be read, so that entries may be left in it.
    pub fn clear(&self) -> std::io::Result<u64> {
        let mut removed = 0;
        for folder in self.folders() {
            for file in files_in(&folder).filter(|f| is_temporary(f)).chain(entries_in(&folder)) {
                removed += u64::from(remove_if_present(&file)?);
            }
            // A folder that contains other files is kept.
            let _ = std::fs::remove_dir(&folder);
        }
        self.modules.lock().clear();
        self.unreadable_folder_message().map_or(Ok(removed), |why| Err(std::io::Error::other(why)))
    }

    /// The first folder that exists and cannot be read, and why, as text.
    fn unreadable_folder_message(&self) -> Option<String> {
        let why = |folder: &Path| match std::fs::read_dir(folder) {
            Ok(mut entries) => entries.find_map(|entry| entry.err()),
            Err(e) => Some(e).filter(|e| e.kind() != std::io::ErrorKind::NotFound),
        };
        let folders = self.root.iter().cloned().chain(self.folders());
        folders.into_iter().find_map(|folder| why(&folder).map(|e| format!("{} cannot be read: {e}", folder.display())))
    }

    /// Folders of all generators.
    fn folders(&self) -> Vec<PathBuf> {
        let read = self.root.as_ref().and_then(|r| std::fs::read_dir(r).ok());
        read.into_iter().flatten().flatten().map(|e| e.path()).filter(|p| p.is_dir()).collect()
    }
}

fn files_in(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    std::fs::read_dir(folder).ok().into_iter().flatten().flatten().map(|e| e.path()).filter(|p| p.is_file())
}

/// Everything named like an entry, except folders. Pipes and links are included, so that they are counted, verified and cleared.
fn entries_in(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let all = std::fs::read_dir(folder).ok().into_iter().flatten().flatten().map(|e| e.path());
    all.filter(|p| p.extension().is_some_and(|e| e == EXTENSION) && !p.is_dir())
}
