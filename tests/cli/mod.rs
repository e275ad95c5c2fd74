//! The built program: verbs, messages, files.

mod bench;
#[cfg(unix)]
mod bounded;
mod composition;
mod ephemeris;
mod error_bound;
mod frames;
mod hostile;
mod lunar_heights;
mod measure;
mod messages;
mod position_sources;
mod verbs;
