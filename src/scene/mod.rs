//! What one frame needs, and why.
pub mod draw;
