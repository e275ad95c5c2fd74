//! Drawing: the plan says what, a renderer does it, the frame holds the result.
pub mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod plan;
pub mod software;
