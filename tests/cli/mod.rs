//! The built program: verbs, messages, files.

mod bench;
mod frames;
mod hostile;
mod messages;
mod verbs;
