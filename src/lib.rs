//! Orrery: a solar-system viewer whose planets are drawn by generated shaders.
//!
//! The modules are the stages of one pipeline, in order; ARCHITECTURE.md draws it and `tests/layering.rs` holds the
//! table of who may use whom:
//!
//! [`catalog`] + [`time`] → [`ephemeris`] → [`scene`] → [`shader`] → [`render`] → [`image`] → [`view`] or [`cli`].

pub mod catalog;
pub mod cli;
pub mod ephemeris;
pub mod image;
mod memo;
pub mod mesh;
pub mod probe;
pub mod render;
pub mod scene;
pub mod session;
pub mod shader;
pub mod time;
pub mod units;
#[cfg(feature = "view")]
pub mod view;
pub mod wording;
