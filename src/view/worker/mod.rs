//! Work off the window's thread: images, answers to questions, and how large an image may be while things move.

pub mod adaptive_resolution;
pub mod query_cache;
pub mod render_worker;
