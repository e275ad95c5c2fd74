//! Helpers that several tests share.

pub mod air_reference;
pub mod emitted;
pub mod folds;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hand_shader;
pub mod photons;
pub mod program;
pub mod random;
pub mod reference_rays;
pub mod scratch;
pub mod session;
pub mod sweep;
pub mod switch;
pub mod views;
