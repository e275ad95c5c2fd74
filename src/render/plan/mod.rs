//! The render plan: the passes of a frame in order, with their draws, bindings and uniform bytes.
//!
//! In: a finished scene, and a [`ResourceProvider`] of layouts, maps and glyphs. Out: a [`Plan`] of plain values, which every renderer can execute
//! without further decisions. Not here: the choice of what is drawn (scene).

mod build;
mod coarse_air;
mod composite;
mod error;
mod extent;
pub mod graph;
mod interface;
mod labels;
mod light_around_sun;
mod maps;
mod passes;
mod provider;
mod scissor;
mod simple_draws;
mod sky;
mod small_bodies;
mod uniform_bytes;
pub use build::{SamplingQuality, modules, plan, steps};
// The coarse image of the air has a subimage, a range of rows, for each quantity (air or sunlight) of each draw.
pub use coarse_air::{COARSE_AIR_TEXTURE, coarse_air_subimage_size};
pub use composite::{composite, composite_modules};
pub use error::PlanError;
// Which pixels a draw may change, and an image whose marks exclude some: where the ground's draw also shows the clouds, the clouds' draw discards its pixels.
pub use extent::{Extent, MarkedImage};
pub use interface::{INTERFACE_MODULE, UiPrimitive, interface, interface_step, warm_up_interface};
// The constants are the names of the texture variables to which the results of `limb_table`, `ring_profile`, `ring_shadow_grid` and `ring_shine` are bound.
// `role_of`: which map of a body a texture variable holds.
pub use maps::{
    LIMB_TABLE, RING_PROFILE, RING_SHADOW_GRID, RING_SHINE, limb_table, map_decoding, map_format, ring_profile, ring_shadow_grid,
    ring_shine, role_of,
};
pub use passes::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, FrameImages, FrontFace, GpuImage, Instances, ModuleProvider, Pass, Plan,
    PlanDraw, SamplerBinding, SamplerState, ShadingRate, SimpleDraw, TextureBinding, TextureSource, Vertices,
};
pub use provider::ResourceProvider;
pub(crate) use sky::SKY_DECODING;
pub use uniform_bytes::uniform_bytes;
