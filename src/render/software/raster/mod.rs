//! The rasteriser: turns clip-space vertices into covered quads.
//!
//! [`clip`] clips a triangle to the part that can be projected. [`setup`] snaps it to fixed point, and derives the planes of depth and varyings: their linear
//! functions of the pixel's position. [`coverage`] walks a tile and determines the covered samples of its quads. Not here: shading, and storing colours or
//! depths.

pub mod clip;
pub mod coverage;
pub mod setup;
