//! Files dropped on the window: views, which are shown, tours, which are played, and data, which become layers over the sky or over the target's surface.
//!
//! In: the files dropped in this frame. Out: layers of the session with a request for a new image, actions that show a view, a started tour; a message
//! about each layer (how it was read) and each error. Always: files are read on the query worker (a background thread); an invalid file does not change the
//! image.

use super::{Interface, MAX_MESSAGE_LINES, tour};
use crate::catalog::NaifId;
use crate::files::read_text;
use crate::session::Session;
use crate::time::Instant;
use crate::view::app::tour::MAX_BYTES;
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::link::view_from_text;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use crate::wording::echo;
use serde_json::{Map, Value};
use std::path::Path;

/// What a dropped file contains.
enum Content {
    /// A layer, which the session has already; with the line that describes it.
    Layer(String),
    View(Box<ViewState>),
    /// A tour, as JSON.
    Tour(String),
}

/// Files that are being read.
#[derive(Default)]
pub(crate) struct DroppedFiles {
    pending: Vec<Pending<Result<Content, String>>>,
    /// Messages about the files of one batch, errors first. The window's reply (`Interface::show_reply`) shows all of them, because each reply replaces the
    /// last one. A batch ends when no file is being read any more.
    messages: Vec<String>,
}

/// The text of a view or tour, and whether it is a tour; `None` for any other file. Views and tours are recognised by fields that GeoJSON, the other
/// format whose names end in `.json`, does not have beside its `type`.
fn view_or_tour(path: &Path) -> Option<(String, bool)> {
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    if !is_json {
        return None;
    }
    let text = read_text(path, MAX_BYTES).ok()?;
    let fields: Map<String, Value> = serde_json::from_str(&text).ok()?;
    let is_tour = fields.contains_key("stops");
    let is_own = !fields.contains_key("type") && (is_tour || fields.contains_key("target"));
    is_own.then_some((text, is_tour))
}

/// Reads a file. `target`: the body that gets a layer with places on a body. `now`: the time of a view without one.
fn read(session: &Session, path: &Path, target: Option<NaifId>, now: Instant) -> Result<Content, String> {
    match view_or_tour(path) {
        Some((text, true)) => Ok(Content::Tour(text)),
        Some((text, false)) => {
            let view = view_from_text(&text, session, now);
            let named = |why: String| format!("{}: {why}", echo(&path.display().to_string()));
            view.map(|view| Content::View(Box::new(view))).map_err(|e| named(error_text(&e)))
        }
        None => session.add_data_file(path, target).map(Content::Layer).map_err(|e| error_text(&e)),
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
        let pending = ask(worker, move |session| read(session, &path, target, now));
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
            Ok(Content::View(view)) => actions.push(Action::Show(view)),
            Ok(Content::Tour(json)) => tour::start(interface, worker.session(), &json, actions),
            Ok(Content::Layer(description)) => {
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
