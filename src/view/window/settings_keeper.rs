//! Writes changed settings on a separate thread while the window is open, so that a killed program loses at most the last half second of changes.
//!
//! In: the settings after each frame. Out: calls of `write`. Always: one write at a time, and only for settings that differ from the previous
//! ones. Changes still pending when the window is closed are left to the caller, who writes the final settings.

use crate::view::app::settings::Settings;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Time without a change before settings are written, so that dragging a slider counts as one change.
const QUIET: Duration = Duration::from_millis(500);

/// The sender of changed settings; the thread ends when it is dropped.
pub(crate) struct SettingsKeeper {
    changed: Sender<Settings>,
    last: Settings,
}

impl SettingsKeeper {
    /// `settings`: the current content of the settings file. The returned receiver is for [`write_changes`].
    pub(crate) fn new(settings: &Settings) -> (Self, Receiver<Settings>) {
        let (changed, changes) = channel();
        (Self { changed, last: settings.clone() }, changes)
    }

    /// Sends the settings to the writer if they differ from the last ones.
    pub(crate) fn note(&mut self, settings: &Settings) {
        if self.last != *settings {
            self.last.clone_from(settings);
            // Cannot fail: the receiving thread outlives this sender.
            let _ = self.changed.send(settings.clone());
        }
    }
}

/// Writes changes until the keeper is dropped.
pub(crate) fn write_changes(changes: &Receiver<Settings>, write: impl FnMut(&Settings)) {
    write_after(changes, QUIET, write);
}

fn write_after(changes: &Receiver<Settings>, quiet: Duration, mut write: impl FnMut(&Settings)) {
    while let Ok(mut latest) = changes.recv() {
        loop {
            match changes.recv_timeout(quiet) {
                Ok(newer) => latest = newer,
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
        write(&latest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_of_several_changes_is_written_once_and_none_after_the_end() {
        let zoomed = |zoom| Settings { zoom, ..Settings::default() };
        let (mut keeper, changes) = SettingsKeeper::new(&zoomed(1.0));
        let (written, seen) = channel();
        std::thread::scope(|scope| {
            scope.spawn(move || write_after(&changes, Duration::from_millis(50), |s| written.send(s.zoom).expect("a test that listens")));
            for zoom in [1.0, 1.1, 1.1, 1.2] {
                keeper.note(&zoomed(zoom));
            }
            assert_eq!(seen.recv(), Ok(1.2));
            keeper.note(&zoomed(1.2));
            keeper.note(&zoomed(1.3));
            assert_eq!(seen.recv(), Ok(1.3));
            // Still pending when the keeper is dropped, hence left to the caller.
            keeper.note(&zoomed(1.4));
            drop(keeper);
        });
        assert!(seen.try_recv().is_err());
    }
}
