//! The software renderer: executes the plan's modules on the CPU.
//!
//! module IR → [`lower`] → [`program`] (a tape of lane operations) → [`exec`] (vector kernels) under [`raster`] (triangles to lanes)

pub mod exec;
pub mod kernels;
pub mod math;
pub mod program;
pub mod tape;
