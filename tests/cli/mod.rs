//! The built program: verbs, messages, files.

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
mod library_and_doctor;
mod lunar_heights;
mod measure;
mod messages;
mod output_names;
mod position_sources;
mod readme;
mod verbs;

/// What the program wrote to standard error.
fn stderr_text(out: &std::process::Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

/// A path as an argument.
fn path_text(path: &std::path::Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}
