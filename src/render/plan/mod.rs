//! The render plan: passes, order, uniform bytes. Plain values, shared by every renderer.

mod build;
mod error;
pub mod graph;
mod interface;
mod passes;
mod provider;
mod scissor;
mod shared;
pub use build::{
    Fineness, NIGHT_MAP_BINDING, OVERLAY_BINDINGS, RING_PROFILE_BINDING, RING_SHINE_BINDING, map_format, map_reading, modules, plan,
    ring_profile, ring_shine, steps, uniforms_of,
};
pub use error::PlanError;
pub use interface::{INTERFACE_MODULE, Piece, interface, interface_step, smallest_interface};
pub use passes::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, Instances, ModuleName, Modules, Pass, PictureOnDevice, Plan, PlanDraw,
    SamplerBinding, SamplerState, SharedDraw, TextureBinding, TextureSource, Vertices,
};
pub use provider::Supplies;

/// Instructions that a texture read is shown as in the picture of costs.
pub use crate::scene::legend::SHOWN_PER_READ;
