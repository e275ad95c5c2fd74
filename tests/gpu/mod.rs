//! The GPU renderer against the software renderer.

pub mod renderer;
