//! Work off the window's thread: rendering of images and answers to queries. Also the resolution of moving images, and the return of freed
//! memory.

pub mod adaptive_resolution;
pub(crate) mod drawn_with;
pub mod freed_memory;
pub mod query_cache;
pub mod render_worker;
