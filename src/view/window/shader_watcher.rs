//! Reloads a folder of shader fragments (source files) when a file in it changes.
//!
//! In: a folder. Out: the session's fragments, replaced by the folder's `*.wesl` files. Always: after the first time, a separate thread reads the files,
//! and the query worker passes them to the session. While the folder cannot be read, for example because an editor is saving a file, the session keeps
//! the last fragments. An error in listing the files is reported once, when two checks in succession find it; an error in reading them is reported
//! by the first check that finds it.

use crate::session::{FragmentFolderError, FragmentTimes, Session, fragment_times, read_fragments};
use crate::view::worker::render_worker::RenderWorker;
use parking_lot::Mutex;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Interval between checks of the folder.
const CHECK_INTERVAL: Duration = Duration::from_secs(1);
/// Interval between checks whether the window was closed, so that closing it does not wait for a check of the folder.
const CLOSE_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// A watched folder.
pub struct ShaderWatcher {
    folder: PathBuf,
    last_check: Mutex<LastCheck>,
}

/// What the checks up to now have found.
struct LastCheck {
    /// The modification times and lengths of the folder's files when it was last read.
    times_at_last_read: FragmentTimes,
    /// Why the files could not be listed in the last check; `None` if they could.
    error: Option<String>,
    /// Whether this error was reported.
    is_reported: bool,
}

impl ShaderWatcher {
    /// Reads the folder for the first time.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be read, or the folder contains no fragments.
    pub fn open(folder: &Path, session: &Session) -> Result<Self, FragmentFolderError> {
        let times = fragment_times(folder)?;
        session.set_fragments(read_fragments(folder, &times)?);
        let last_check = LastCheck { times_at_last_read: times, error: None, is_reported: false };
        Ok(Self { folder: folder.to_owned(), last_check: Mutex::new(last_check) })
    }

    /// Reads the folder again if a file has changed, and lets the query worker ([`RenderWorker::run`]) pass the fragments to the session.
    pub fn check_files(&self, worker: &dyn RenderWorker) {
        let mut last = self.last_check.lock();
        let times = match fragment_times(&self.folder) {
            Ok(times) => times,
            Err(why) => return last.record_error(why.to_string(), worker),
        };
        (last.error, last.is_reported) = (None, false);
        if last.times_at_last_read == times {
            return;
        }
        match read_fragments(&self.folder, &times) {
            Ok(fragments) => worker.run(Box::new(move |session| session.set_fragments(fragments))),
            // Reported only once for each state of the folder: `times_at_last_read` is updated below even after an error.
            Err(why) => worker.run(Box::new(move |session| session.notify(&why.to_string()))),
        }
        last.times_at_last_read = times;
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

impl LastCheck {
    /// Records an error, and reports it once when two checks in succession find it: while an editor saves a file, the folder has an error for an instant.
    fn record_error(&mut self, why: String, worker: &dyn RenderWorker) {
        if self.error.as_ref() != Some(&why) {
            (self.error, self.is_reported) = (Some(why), false);
        } else if !std::mem::replace(&mut self.is_reported, true) {
            worker.run(Box::new(move |session| session.notify(&why)));
        }
    }
}
