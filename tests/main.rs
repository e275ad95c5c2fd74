//! The only test binary, so that tests link once. Each module is a folder named after the part of the program that it tests; tests/README.md
//! maps behaviour to file.

mod atmosphere;
mod catalog;
mod cli;
mod eclipse;
mod ephemeris;
mod events;
#[cfg(feature = "gpu")]
mod gpu;
mod image;
mod project;
mod render;
mod rings;
mod scene;
mod shader;
mod software;
mod stability;
mod support;
#[cfg(feature = "view")]
mod view;
