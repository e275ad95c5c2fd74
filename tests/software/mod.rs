//! The software renderer: lowering, arithmetic, rasterisation, sampling, tone mapping.

mod between;
mod control_flow;
mod filtered;
mod frame;
mod lower;
mod math;
mod pass_fusion;
mod raster;
mod sampling;
mod speed;
mod tone_map;
