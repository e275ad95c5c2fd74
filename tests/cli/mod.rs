//! The built program: verbs, messages, files.

mod bench;
mod composition;
mod frames;
mod hostile;
mod messages;
mod verbs;
