//! The GPU renderer against the software renderer.

mod renderer;
