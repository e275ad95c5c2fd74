//! Drawing: the plan says what, a renderer does it, the frame holds the result.
pub mod frame;
pub mod plan;
pub mod software;
