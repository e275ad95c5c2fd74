//! Work on other threads than the window's: images are rendered, queries answered. Also the resolution of images while the view moves, and the return
//! of freed memory to the system.

pub mod adaptive_resolution;
pub(crate) mod drawn_with;
pub mod freed_memory;
pub(crate) mod latest_answer;
pub mod query_cache;
pub mod render_worker;
