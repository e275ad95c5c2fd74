//! Files dropped on the window: layers of data over the sky or the target's surface.
//!
//! In: the files of a frame. Out: layers of the session, a message about how they were read or what is wrong, and a new picture. Always: files are read off the drawing thread; an invalid
//! one changes nothing.

use super::Interface;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};

/// Files that are being read.
#[derive(Default)]
pub(crate) struct DroppedFiles {
    reading: Vec<Pending<Result<String, String>>>,
}

/// Takes the files dropped in this frame, and shows those that have been read.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker) {
    let paths: Vec<_> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
    let body = Some(interface.viewer.view.target);
    for path in paths {
        let read = ask(worker, move |session| session.add_data_file(&path, body).map_err(|e| e.to_string()));
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
        interface.message = match answer {
            Ok(what) => {
                interface.viewer.view.layers.data = true;
                // The same view now gives another picture.
                interface.viewport.requested = None;
                what
            }
            Err(why) => why,
        };
    }
}
