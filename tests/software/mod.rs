//! The software renderer: lowering, arithmetic, rasterisation, sampling, tone mapping.

mod coarse_shading;
mod control_flow;
mod edited_module;
mod filtered_map;
mod frame;
mod lower;
mod map_taps;
mod math;
mod pass_fusion;
mod raster;
mod read_map;
mod sampling;
mod speed;
mod texels_between;
mod tone_map;
