//! One session for every test that looks at pictures: maps are decoded, modules lowered and tables of air summed once for all of them.
//!
//! It draws in software, keeps its files in a folder of its own that goes with the process, and warns of nothing. A test that changes catalogs, or asks
//! what a session says, opens its own.

use orrery::session::{Session, Sources};
use std::sync::LazyLock;

pub static SESSION: LazyLock<Session> = LazyLock::new(|| {
    let cache = std::env::temp_dir().join(format!("orrery-tests-{}", std::process::id()));
    Session::open(&Sources { cache: Some(cache), ..Sources::default() }, |line| panic!("{line}")).expect("opens")
});
