//! Data files dropped on the window, which become layers over the sky or over the target's surface.
//!
//! In: the files dropped in this frame. Out: layers of the session, a message about each file (how it was read, or its error), and a request
//! for a new image. Always: files are read on the query worker (a background thread); an invalid file does not change the image.

use super::{Interface, MAX_MESSAGE_LINES};
use crate::view::error_texts::error_text;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};

/// Files that are being read.
#[derive(Default)]
pub(crate) struct DroppedFiles {
    pending: Vec<Pending<Result<String, String>>>,
    /// Messages about all files of one batch, errors first. The window's reply (`Interface::show_reply`) shows all of them, because each reply replaces the
    /// last one. A batch ends when no file is being read any more.
    messages: Vec<String>,
}

/// Starts to read the files dropped in this frame; for files that have been read, reports the result and shows the layers.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker) {
    let paths: Vec<_> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
    // Files with places on a body become layers of the target.
    let target = Some(interface.viewer.view.target);
    if interface.dropped.pending.is_empty() {
        interface.dropped.messages.clear();
    }
    for path in paths {
        let pending = ask(worker, move |session| session.add_data_file(&path, target).map_err(|e| error_text(&e)));
        interface.dropped.pending.push(pending);
    }
    let mut answers = Vec::new();
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
            Ok(description) => {
                interface.viewer.view.layers.data = true;
                // The same view now gives another image, so the image is requested again.
                interface.viewport.requested = None;
                interface.dropped.messages.push(description);
            }
            Err(why) => interface.dropped.messages.insert(0, why),
        }
    }
    interface.show_reply(reply_of(&interface.dropped.messages));
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
