//! The window's own frame: the interface's triangles, the picture of the sky among their textures.
//!
//! In: [`UiPrimitive`]s in the order in which they are painted, and the window's size. Out: one step and its plan, which either renderer walks. Always: blending is the
//! interface's (premultiplied, in display colours). It is a plan of its own because a window turns more often than its picture is drawn: what the
//! picture's plan made comes in as a texture. It knows nothing of panels.

use super::error::PlanError;
use super::graph::{self, Step, Target, Write};
use super::passes::{
    AddressMode, Attribute, Blend, ColourFormat, Plan, PlanDraw, SamplerBinding, SamplerState, TextureBinding, TextureSource, Vertices,
};
use super::provider::ResourceProvider;
use super::shared::over_all;
use crate::image::{Level, TexelFormat, Texture};
use std::sync::Arc;

/// The module of all pieces: shaders/entry/interface.wesl.
pub const INTERFACE_MODULE: &str = "interface";
/// What the step makes.
const WINDOW: &str = "window";
const TEXTURE_BINDING: u32 = 1;
const SAMPLER_BINDING: u32 = 2;

/// Triangles with one texture, within one rectangle.
#[derive(Clone, Debug)]
pub struct UiPrimitive {
    /// Two numbers a corner: pixels from the window's left top corner.
    pub corners_px: Vec<f32>,
    /// Two numbers a corner, 0 to 1 from the texture's left top corner.
    pub places: Vec<f32>,
    /// Four numbers a corner: sRGB-encoded, premultiplied, 0 to 1.
    pub colours: Vec<f32>,
    pub indices: Vec<u32>,
    pub texture: TextureSource,
    pub sampler: SamplerState,
    /// Pixels that may be touched: x0, y0, x1, y1 (exclusive).
    pub scissor: [u32; 4],
}

/// The step that makes a window of its pieces.
///
/// # Errors
/// What the module lacks.
pub fn interface_step(pieces: Vec<UiPrimitive>, [width, height]: [u32; 2], provider: &impl ResourceProvider) -> Result<Step, PlanError> {
    let pixel_size = glam::Vec2::new(2.0 / width as f32, 2.0 / height as f32);
    let plain = over_all(INTERFACE_MODULE, [width, height], provider, |w| w.vec2("pixel_size", pixel_size))?;
    let draws = pieces.into_iter().map(|piece| {
        let attribute = |components: u32, values: Vec<f32>| Attribute { components, values: Arc::new(values) };
        PlanDraw {
            textures: vec![TextureBinding { binding: TEXTURE_BINDING, source: piece.texture }],
            samplers: vec![SamplerBinding { binding: SAMPLER_BINDING, state: piece.sampler }],
            vertices: Vertices::Mesh {
                attributes: vec![attribute(2, piece.corners_px), attribute(2, piece.places), attribute(4, piece.colours)],
                indices: Arc::new(piece.indices),
            },
            blend: Blend::PremultipliedOver,
            scissor: piece.scissor,
            ..plain.clone()
        }
    });
    let black = [0.0, 0.0, 0.0, 1.0];
    let window = Target { resource: WINDOW, width, height, format: ColourFormat::Rgba8Unorm, samples: 1, clear: black, depth: false };
    Ok(Step { name: "interface", reads: vec![], writes: Write::New(window), draws: draws.collect() })
}

/// The plan of a window.
///
/// # Errors
/// See [`interface_step`].
pub fn interface(pieces: Vec<UiPrimitive>, size: [u32; 2], provider: &impl ResourceProvider) -> Result<Plan, PlanError> {
    Ok(graph::compile(&[interface_step(pieces, size, provider)?], WINDOW)?)
}

/// The plan of a window of one white pixel: drawn to no end, a device has made by it what any window needs.
///
/// # Errors
/// See [`interface_step`].
pub fn warm_up_interface(provider: &impl ResourceProvider) -> Result<Plan, PlanError> {
    let white = Texture { format: TexelFormat::Rgba8Unorm, levels: vec![Level { width: 1, height: 1, bytes: vec![255; 4] }] };
    let piece = UiPrimitive {
        corners_px: vec![0.0, 0.0, 2.0, 0.0, 0.0, 2.0],
        places: vec![0.5; 6],
        colours: vec![1.0; 12],
        indices: vec![0, 1, 2],
        texture: TextureSource::Image(Arc::new(white)),
        sampler: SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, linear: true },
        scissor: [0, 0, 1, 1],
    };
    interface(vec![piece], [1, 1], provider)
}
