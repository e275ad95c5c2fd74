//! Work off the window's thread: rendering of images and answers to queries. Also the choice of resolution for moving images.

pub mod adaptive_resolution;
pub mod freed_memory;
pub mod query_cache;
pub mod render_worker;
