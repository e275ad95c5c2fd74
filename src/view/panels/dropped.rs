//! Data files dropped on the window, which become layers over the sky or over the target's surface.
//!
//! In: the files dropped in this frame. Out: layers of the session, a message about each file (how it was read, or its error), and a request
//! for a new image. Always: files are read on the query worker; an invalid file does not change the image.

use super::Interface;
use crate::view::error_texts::error_text;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};

/// Files that are being read.
#[derive(Default)]
pub(crate) struct DroppedFiles {
    reading: Vec<Pending<Result<String, String>>>,
}

/// Starts to read the files dropped in this frame; for files that have been read, reports the result and shows the layers.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker) {
    let paths: Vec<_> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
    let body = Some(interface.viewer.view.target);
    for path in paths {
        let read = ask(worker, move |session| session.add_data_file(&path, body).map_err(|e| error_text(&e)));
        interface.dropped.reading.push(read);
    }
    let mut answers = Vec::new();
    interface.dropped.reading.retain(|pending| match pending.take() {
        Some(answer) => {
            answers.push(answer);
            false
        }
        None => true,
    });
    for answer in answers {
        let reply = match answer {
            Ok(description) => {
                interface.viewer.view.layers.data = true;
                // The same view now gives another image, so the image is requested again.
                interface.viewport.requested = None;
                description
            }
            Err(why) => why,
        };
        interface.reply(reply);
    }
}
