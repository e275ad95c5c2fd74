//! Reloads a folder of shader fragments (source files) when a file in it changes.
//!
//! In: a folder. Out: the session's fragments, replaced by the folder's `*.wesl` files. Always: after the first time, a separate thread reads the files,
//! and the query worker passes them to the session. While the folder cannot be read, for example because an editor is saving a file, the session keeps
//! the last fragments.

use crate::session::{FragmentFolderError, FragmentTimes, Session, fragment_times, read_fragments};
use crate::view::worker::render_worker::RenderWorker;
use parking_lot::Mutex;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Interval between checks of the folder.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Interval between checks whether the window was closed.
const CLOSE_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// A watched folder, and the modification times and lengths of its files when it was last read.
pub struct ShaderWatcher {
    folder: PathBuf,
    times_read: Mutex<FragmentTimes>,
}

impl ShaderWatcher {
    /// Reads the folder for the first time.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be read, or the folder contains no fragments.
    pub fn open(folder: &Path, session: &Session) -> Result<Self, FragmentFolderError> {
        let times = fragment_times(folder)?;
        session.set_fragments(read_fragments(folder, &times)?);
        Ok(Self { folder: folder.to_owned(), times_read: Mutex::new(times) })
    }

    /// Reads the folder again if a file has changed, and lets the query worker pass the fragments to the session.
    pub fn check_files(&self, worker: &dyn RenderWorker) {
        let Ok(times) = fragment_times(&self.folder) else { return };
        let mut times_read = self.times_read.lock();
        if *times_read == times {
            return;
        }
        match read_fragments(&self.folder, &times) {
            Ok(fragments) => worker.run(Box::new(move |session| session.set_fragments(fragments))),
            // Reported only once for each state of the folder: `times_read` is updated below even after an error.
            Err(why) => worker.run(Box::new(move |session| session.notify(&why.to_string()))),
        }
        *times_read = times;
    }

    /// Checks the files once a second until `is_closed` returns true. Blocks, so it needs its own thread.
    pub(crate) fn watch_until(&self, worker: &dyn RenderWorker, is_closed: impl Fn() -> bool) {
        let mut waited = Duration::ZERO;
        while !is_closed() {
            std::thread::sleep(CLOSE_CHECK_INTERVAL);
            waited += CLOSE_CHECK_INTERVAL;
            if waited >= CHECK_INTERVAL {
                waited = Duration::ZERO;
                self.check_files(worker);
            }
        }
    }
}
