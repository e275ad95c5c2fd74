//! The built program: verbs, messages, files.

mod bench;
#[cfg(unix)]
mod bounded;
mod frames;
mod hostile;
mod messages;
mod verbs;
