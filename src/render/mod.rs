//! Rendering: a plan of passes and draws, two renderers that execute it, and the frame that results.
pub mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod plan;
pub mod software;
