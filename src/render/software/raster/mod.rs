//! From clip-space vertices to covered quads.
//!
//! [`clip`] cuts a triangle to what can be projected, [`setup`] snaps it to fixed point and derives the planes of depth and varyings,
//! [`coverage`] walks a tile and says which samples of which quads are inside. Nothing here shades or stores.

pub mod clip;
pub mod coverage;
pub mod setup;
