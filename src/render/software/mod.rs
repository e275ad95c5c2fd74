//! The software renderer: executes the plan's modules on the CPU.
//!
//! naga IR → [`lower`] → [`program`], a tape of lane operations → [`exec`], vector kernels chosen at run time.

pub mod math;
pub mod op;
pub mod program;
