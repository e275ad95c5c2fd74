//! Files dropped on the window, or named by `orrery view`: views are shown, tours are played, and data become layers.
//!
//! In: the files dropped in this frame, and one that was read before the window opened. Out: actions that show a view, a started tour, a request for an image
//! with a new layer; a message about each layer (how it was read) and each error. Always: dropped files are read on the query worker (a background thread);
//! an invalid file does not change the image. Not here: what a file contains ([`crate::view::opened_file`]).

use super::{Interface, MAX_MESSAGE_LINES, tour};
use crate::view::app::viewer::Action;
use crate::view::opened_file::{OpenedFile, read};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};

/// Files that are being read.
#[derive(Default)]
pub(crate) struct DroppedFiles {
    /// The file of [`Interface::open_file`], until the next frame.
    first: Option<OpenedFile>,
    pending: Vec<Pending<Result<OpenedFile, String>>>,
    /// Messages about the files of one batch, errors first. The window's reply (`Interface::show_reply`) shows all of them, because each reply replaces the
    /// last one. A batch ends when no file is being read any more.
    messages: Vec<String>,
}

impl Interface {
    /// Opens a file in the next frame, as if it were dropped on the window.
    pub fn open_file(&mut self, file: OpenedFile) {
        self.dropped.first = Some(file);
    }
}

/// Starts to read the files dropped in this frame. For files that have been read, shows layers and views, plays tours, and reports layers and errors.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let paths: Vec<_> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
    // Files with places on a body become layers of the target.
    let target = Some(interface.viewer.view.target);
    if interface.dropped.pending.is_empty() {
        interface.dropped.messages.clear();
    }
    let now = interface.viewer.now();
    for path in paths {
        let pending = ask(worker, move |session| read(session, &path, target, now).map_err(|unread| unread.in_window));
        interface.dropped.pending.push(pending);
    }
    let mut answers: Vec<_> = interface.dropped.first.take().map(Ok).into_iter().collect();
    interface.dropped.pending.retain(|pending| match pending.take() {
        Some(answer) => {
            answers.push(answer);
            false
        }
        None => true,
    });
    if answers.is_empty() {
        return;
    }
    for answer in answers {
        match answer {
            Ok(OpenedFile::View(view)) => actions.push(Action::Show(view)),
            Ok(OpenedFile::Tour(tour)) => tour::play(interface, *tour, actions),
            Ok(OpenedFile::Layer(description)) => {
                interface.viewer.view.layers.data = true;
                // The same view now gives another image, so the image is requested again.
                interface.viewport.requested = None;
                interface.dropped.messages.push(description);
            }
            Err(why) => interface.dropped.messages.insert(0, why),
        }
    }
    if !interface.dropped.messages.is_empty() {
        interface.show_reply(reply_of(&interface.dropped.messages));
    }
}

/// The messages, one a line; those beyond [`MAX_MESSAGE_LINES`] are left out.
fn reply_of(messages: &[String]) -> String {
    let shown = messages.get(..MAX_MESSAGE_LINES).map_or_else(|| messages.join("\n"), |first| first.join("\n"));
    if messages.len() > MAX_MESSAGE_LINES { shown + "\n…" } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_has_a_line_until_there_are_too_many() {
        let messages: Vec<String> = (1..=MAX_MESSAGE_LINES + 1).map(|k| format!("file {k}")).collect();
        assert_eq!(reply_of(&messages[..1]), "file 1");
        assert_eq!(reply_of(&messages[..2]), "file 1\nfile 2");
        let reply = reply_of(&messages[..MAX_MESSAGE_LINES]);
        assert!(reply.lines().count() == MAX_MESSAGE_LINES && !reply.contains('…'), "{reply}");
        assert_eq!(reply_of(&messages), reply + "\n…");
    }
}
