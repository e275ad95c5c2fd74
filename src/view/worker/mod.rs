//! Work off the window's thread: images, answers to queries, and the resolution of moving images.

pub mod adaptive_resolution;
pub mod query_cache;
pub mod render_worker;
