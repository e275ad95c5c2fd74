//! Helpers that several tests share. No tests.

pub mod air_reference;
pub mod hand_shader;
pub mod session;
