//! The settings writer: writes changed settings on a separate thread while the window is open.
//!
//! In: the settings after each frame. Out: calls of the function `write` with settings that changed. Always: changes are written once half a second has passed
//! without a further change. If the program is killed, only the changes since the last such pause are lost. When the window is closed, changes may still be
//! pending: the caller writes the final settings.

use crate::view::app::settings::Settings;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Time without a change after which settings are written, so that a drag of a slider counts as one change.
const QUIET_TIME: Duration = Duration::from_millis(500);

/// Sends changed settings to the settings writer, which ends when the sender is dropped.
pub(crate) struct SettingsSender {
    changes: Sender<Settings>,
    /// The settings that were sent last, or the initial ones.
    last_sent: Settings,
}

impl SettingsSender {
    /// A sender for settings that differ from `settings`, the initial ones: those of the file, or the default ones if there is no usable file. The receiver
    /// is for [`write_changes`].
    pub(crate) fn new(settings: &Settings) -> (Self, Receiver<Settings>) {
        let (sender, receiver) = channel();
        (Self { changes: sender, last_sent: settings.clone() }, receiver)
    }

    /// Sends the settings to the settings writer if they differ from those that were sent last.
    pub(crate) fn send_if_changed(&mut self, settings: &Settings) {
        if self.last_sent != *settings {
            self.last_sent.clone_from(settings);
            // Fails only if the settings writer has panicked. The final settings are saved nevertheless when the window is closed.
            let _ = self.changes.send(settings.clone());
        }
    }
}

/// Writes changes until the sender is dropped. Blocks, so it needs its own thread.
pub(crate) fn write_changes(changes: &Receiver<Settings>, write: impl FnMut(&Settings)) {
    write_after(changes, QUIET_TIME, write);
}

/// Like [`write_changes`], with a quiet time that tests can shorten.
fn write_after(changes: &Receiver<Settings>, quiet_time: Duration, mut write: impl FnMut(&Settings)) {
    while let Ok(mut latest) = changes.recv() {
        loop {
            match changes.recv_timeout(quiet_time) {
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

    fn scaled(ui_scale: f32) -> Settings {
        Settings { ui_scale, ..Settings::default() }
    }

    /// The changes are sent before the writer starts, so that the result does not depend on the threads' timing.
    #[test]
    fn the_last_of_several_changes_is_written_once() {
        let (mut sender, changes) = SettingsSender::new(&scaled(1.0));
        let (report, written) = channel();
        for ui_scale in [1.0, 1.1, 1.1, 1.2] {
            sender.send_if_changed(&scaled(ui_scale));
        }
        std::thread::scope(|scope| {
            scope.spawn(move || write_after(&changes, Duration::from_millis(20), |s| report.send(s.ui_scale).expect("a receiver")));
            assert_eq!(written.recv(), Ok(1.2));
            sender.send_if_changed(&scaled(1.2));
            sender.send_if_changed(&scaled(1.3));
            assert_eq!(written.recv(), Ok(1.3));
            drop(sender);
        });
        assert!(written.try_recv().is_err());
    }

    #[test]
    fn changes_that_are_pending_when_the_sender_is_dropped_are_left_to_the_caller() {
        let (mut sender, changes) = SettingsSender::new(&scaled(1.0));
        sender.send_if_changed(&scaled(1.1));
        drop(sender);
        write_changes(&changes, |settings| panic!("written: {}", settings.ui_scale));
    }
}
