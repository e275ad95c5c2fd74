//! A folder of shader fragments laid over those built in, read again when a file changes.
//!
//! In: a folder. Out: the session's modules are made of its `*.wgsl` files. Always: files are read on a thread of their own, and modules change
//! between two pictures; a folder that cannot be read for a moment (an editor is saving) changes nothing.

use super::studio::Studio;
use crate::session::Session;
use crate::shader::fragments::Fragments;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime};

/// Files are looked at this often.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// The end of the window is noticed this soon.
const NOTICE: Duration = Duration::from_millis(50);

/// Time of the last change and length of each file.
type Stamps = BTreeMap<PathBuf, (SystemTime, u64)>;

/// The folder, and what it was like when it was read.
pub struct Watch {
    folder: PathBuf,
    read: Mutex<Stamps>,
}

impl Watch {
    /// Reads the folder for the first time.
    ///
    /// # Errors
    /// What cannot be read, or that there is no fragment.
    pub fn open(folder: &Path, session: &Session) -> Result<Self, String> {
        let stamps = stamps(folder)?;
        if stamps.is_empty() {
            return Err(format!("{}: no *.wgsl file is here", folder.display()));
        }
        session.make_shaders_of(read(folder, &stamps)?);
        Ok(Self { folder: folder.to_owned(), read: Mutex::new(stamps) })
    }

    /// Reads the folder again if a file changed since.
    pub fn look(&self, studio: &dyn Studio) {
        let Ok(now) = stamps(&self.folder) else { return };
        let mut before = self.read.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if *before == now {
            return;
        }
        let Ok(fragments) = read(&self.folder, &now) else { return };
        *before = now;
        studio.run(Box::new(move |session| session.make_shaders_of(fragments)));
    }

    /// Looks once a second until `closed`: for a thread of its own.
    pub fn work(&self, studio: &dyn Studio, closed: impl Fn() -> bool) {
        let mut waited = Duration::ZERO;
        while !closed() {
            std::thread::sleep(NOTICE);
            waited += NOTICE;
            if waited >= LOOK_EVERY {
                waited = Duration::ZERO;
                self.look(studio);
            }
        }
    }
}

fn stamps(folder: &Path) -> Result<Stamps, String> {
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let (mut found, mut folders) = (Stamps::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(|e| failed(&folder, e))? {
            let path = entry.map_err(|e| failed(&folder, e))?.path();
            let about = path.metadata().map_err(|e| failed(&path, e))?;
            if about.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                let changed = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                found.insert(path, (changed, about.len()));
            }
        }
    }
    Ok(found)
}

fn read(folder: &Path, files: &Stamps) -> Result<Fragments, String> {
    let one = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let inside = path.strip_prefix(folder).unwrap_or(path);
        let parts: Vec<_> = inside.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        Ok((parts.join("/"), text))
    };
    Ok(Fragments::with_files(files.keys().map(one).collect::<Result<Vec<_>, String>>()?))
}
