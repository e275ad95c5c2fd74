//! Reloads a folder of shader fragments when a file in it changes.
//!
//! In: a folder. Out: the session compiles its modules from the folder's `*.wesl` files. Always: files are read on a thread of their own, and
//! modules change between two images. A folder that cannot be read for a moment, as while an editor saves, changes nothing.

use crate::session::{FragmentFolderError, FragmentTimes, Session, fragment_times, read_fragments};
use crate::view::worker::render_worker::RenderWorker;
use parking_lot::Mutex;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Interval of checks.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Interval at which the end of the window is noticed.
const CLOSE_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// The folder, and its state when it was last read.
pub struct ShaderWatcher {
    folder: PathBuf,
    read: Mutex<FragmentTimes>,
}

impl ShaderWatcher {
    /// Reads the folder for the first time.
    ///
    /// # Errors
    /// What cannot be read, or that there is no fragment.
    pub fn open(folder: &Path, session: &Session) -> Result<Self, FragmentFolderError> {
        let stamps = fragment_times(folder)?;
        session.set_fragments(read_fragments(folder, &stamps)?);
        Ok(Self { folder: folder.to_owned(), read: Mutex::new(stamps) })
    }

    /// Reads the folder again if a file has changed.
    pub fn check_files(&self, worker: &dyn RenderWorker) {
        let Ok(now) = fragment_times(&self.folder) else { return };
        let mut before = self.read.lock();
        if *before == now {
            return;
        }
        match read_fragments(&self.folder, &now) {
            Ok(fragments) => worker.run(Box::new(move |session| session.set_fragments(fragments))),
            // Reported once for each state of the folder.
            Err(why) => worker.run(Box::new(move |session| session.notify(&why.to_string()))),
        }
        *before = now;
    }

    /// Checks once a second until `closed`: for a thread of its own.
    pub(crate) fn watch_until(&self, worker: &dyn RenderWorker, closed: impl Fn() -> bool) {
        let mut waited = Duration::ZERO;
        while !closed() {
            std::thread::sleep(CLOSE_CHECK_INTERVAL);
            waited += CLOSE_CHECK_INTERVAL;
            if waited >= CHECK_INTERVAL {
                waited = Duration::ZERO;
                self.check_files(worker);
            }
        }
    }
}
