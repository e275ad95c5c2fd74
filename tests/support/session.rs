//! One session for every test that looks at pictures: maps are decoded, modules lowered and tables of air summed once for all of them.
//!
//! It draws in software, keeps its files in a folder of its own that goes with the process, and warns of nothing. A test that changes catalogs, or asks
//! what a session says, opens its own.

use orrery::session::{Session, Sources};
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex};

pub static SESSION: LazyLock<Session> = LazyLock::new(|| Session::open(&sources(), |line| panic!("{line}")).expect("opens"));

/// Of that session: what is built in, and files in a folder of the process.
pub fn sources() -> Sources {
    let cache = std::env::temp_dir().join(format!("orrery-tests-{}", std::process::id()));
    Sources { cache: Some(cache), ..Sources::default() }
}

/// A session over the catalogs and images of a folder, and what it says.
pub fn session_over(folder: &Path) -> (Session, Arc<Mutex<Vec<String>>>) {
    let said: Arc<Mutex<Vec<String>>> = Arc::default();
    let heard = said.clone();
    let sources = Sources {
        catalogs: Some(folder.to_owned()),
        textures: Some(folder.to_owned()),
        cache: Some(folder.join("cache")),
        ..Sources::default()
    };
    let session = Session::open(&sources, move |line| heard.lock().expect("a list").push(line.to_owned())).expect("opens");
    (session, said)
}
