//! Work on other threads than the window's.
//!
//! In: render jobs and queries. Out: images and answers, some frames later. Always: the window's thread waits for neither.
//!
//! - `render_worker`: both workers: the render worker, a thread for images, and the query worker, a thread for queries.
//! - `query_cache`: answers, each kept by its key.
//! - `latest_answer`: the answer to a query whose inputs change; shown until the answer for newer inputs arrives.
//! - `session_inputs`: what an image or answer depends on besides its request.
//! - `adaptive_resolution`: the resolution of images while the view moves.
//! - `freed_memory`: returns freed memory to the system.

pub mod adaptive_resolution;
pub mod freed_memory;
pub(crate) mod latest_answer;
pub mod query_cache;
pub mod render_worker;
pub(crate) mod session_inputs;
