//! A session that the tests share, so that maps are decoded, modules lowered and scattering tables computed only once.
//!
//! It draws in software, keeps its cache in the folder of the run, and panics on any message. A test that changes catalogs, or checks
//! messages, opens its own; tests of the window share the session of `view::interface`.

use orrery::session::{Session, Sources};
use orrery::shader::fragments::Fragments;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex};

pub static SESSION: LazyLock<Session> = LazyLock::new(|| Session::open(&sources(), |line| panic!("{line}")).expect("opens"));

/// Sources of [`SESSION`]: the built-in ones, and a cache in the folder of the run.
pub fn sources() -> Sources {
    let cache = super::scratch::folder("session");
    Sources { cache: Some(cache), ..Sources::default() }
}

/// A session with edited fragments: file, old text, new text.
pub fn session_with_edits(changes: &[(&str, &str, &str)]) -> Session {
    let cache = super::scratch::folder("edited-fragments");
    let session = Session::open(&Sources { cache: Some(cache), ..Sources::default() }, |_| {}).expect("opens");
    let mut files: BTreeMap<String, String> = BTreeMap::new();
    for (path, from, to) in changes {
        let built_in = || Fragments::default().text(path).expect("a fragment").to_owned();
        let text = files.entry((*path).to_owned()).or_insert_with(built_in);
        assert!(text.contains(from), "{path} no longer contains `{from}`");
        *text = text.replace(from, to);
    }
    session.set_fragments(Fragments::with_files(files));
    session
}

/// A session whose catalogs, maps and cache are in a folder, and the list of its messages.
pub fn session_over(folder: &Path) -> (Session, Arc<Mutex<Vec<String>>>) {
    let messages: Arc<Mutex<Vec<String>>> = Arc::default();
    let sink = messages.clone();
    let sources = Sources {
        catalogs: Some(folder.to_owned()),
        textures: Some(folder.to_owned()),
        cache: Some(folder.join("cache")),
        ..Sources::default()
    };
    let session = Session::open(&sources, move |line| sink.lock().expect("a list").push(line.to_owned())).expect("opens");
    (session, messages)
}
