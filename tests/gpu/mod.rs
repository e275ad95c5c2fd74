//! The GPU renderer against the software renderer.

mod air_pass;
mod renderer;
