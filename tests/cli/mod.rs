//! The built program: verbs, messages, files.

mod bench;
mod frames;
mod messages;
mod verbs;
