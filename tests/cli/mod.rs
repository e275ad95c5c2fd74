//! The built program: verbs, messages, files.

mod animations;
mod bench;
#[cfg(unix)]
mod bounded;
mod camera_files;
mod composition;
mod ephemeris;
mod error_bound;
mod frames;
mod horizon;
mod hostile;
#[cfg(unix)]
mod interrupt;
mod library_and_doctor;
mod lunar_heights;
mod measure;
mod messages;
mod opened_files;
mod output_names;
mod position_sources;
mod readme;
mod verbs;

use std::path::PathBuf;
use std::sync::LazyLock;

/// Runs the program with the software renderer and a cache folder that all tests share.
fn orrery(args: &[&str]) -> std::process::Output {
    static CACHE: LazyLock<PathBuf> = LazyLock::new(crate::support::scratch::program_cache);
    let mut command = std::process::Command::new(crate::support::program::path());
    command.args(["--renderer", "software", "--cache", path_text(&CACHE)]).args(args).output().expect("the program starts")
}

/// What the program wrote to standard error.
fn stderr_text(out: &std::process::Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

/// A path as an argument.
fn path_text(path: &std::path::Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}
