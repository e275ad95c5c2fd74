//! One frame of the window: the textured triangles of the user interface. The rendered view is one of the textures.
//!
//! In: [`UiPrimitive`]s in the order in which they are painted, and the window's size. Out: a step of the frame graph, and the plan (list of passes) of that
//! step, which the GPU or the software renderer executes. Always: premultiplied sRGB-encoded values are blended without decoding. The window has a plan of its
//! own because it is redrawn more often than the view, whose image is a texture here. Not here: the layout of panels.

use super::error::PlanError;
use super::graph::{self, PassStep, TargetDescriptor, Write};
use super::passes::{
    AddressMode, Attribute, Blend, ColourFormat, Plan, PlanDraw, SamplerBinding, SamplerState, ShadingRate, TextureBinding, TextureSource,
    Vertices,
};
use super::provider::ResourceProvider;
use super::simple_draws::full_screen_draw;
use crate::image::{Level, TexelFormat, Texture};
use std::sync::Arc;

/// The module of all primitives: shaders/entry/interface.wesl.
pub const INTERFACE_MODULE: &str = "interface";
/// Name of the resource that the step creates.
const WINDOW_TARGET: &str = "window";
/// Bindings of the module's texture and sampler.
const TEXTURE_BINDING: u32 = 1;
const SAMPLER_BINDING: u32 = 2;

/// Triangles with one texture and one scissor rectangle.
#[derive(Clone, Debug)]
pub struct UiPrimitive {
    /// Two numbers per vertex: pixels from the window's top-left corner.
    pub positions_px: Vec<f32>,
    /// Two numbers per vertex: texture coordinates, 0 to 1 from the texture's top-left corner.
    pub uvs: Vec<f32>,
    /// Four numbers per vertex: sRGB-encoded, premultiplied, 0 to 1.
    pub colours: Vec<f32>,
    pub indices: Vec<u32>,
    pub texture: TextureSource,
    pub sampler: SamplerState,
    /// Pixels that may be drawn: x0, y0, x1, y1 (the last two exclusive).
    pub scissor: [u32; 4],
}

/// The step that draws a window's primitives.
///
/// # Errors
/// A uniform of the module that is not filled, or an unknown module.
pub fn interface_step(
    primitives: Vec<UiPrimitive>,
    [width, height]: [u32; 2],
    provider: &impl ResourceProvider,
) -> Result<PassStep, PlanError> {
    // The size of a pixel in clip space, which is 2 wide and 2 high.
    let pixel_size = glam::Vec2::new(2.0 / width as f32, 2.0 / height as f32);
    let template = full_screen_draw(INTERFACE_MODULE, [width, height], provider, |w| w.vec2("pixel_size", pixel_size))?;
    let draws = primitives.into_iter().map(|primitive| {
        let attribute = |components: u32, values: Vec<f32>| Attribute { components, values: Arc::new(values) };
        PlanDraw {
            textures: vec![TextureBinding { binding: TEXTURE_BINDING, source: primitive.texture }],
            samplers: vec![SamplerBinding { binding: SAMPLER_BINDING, state: primitive.sampler }],
            vertices: Vertices::Mesh {
                attributes: vec![attribute(2, primitive.positions_px), attribute(2, primitive.uvs), attribute(4, primitive.colours)],
                indices: Arc::new(primitive.indices),
            },
            blend: Blend::PremultipliedOver,
            shading_rate: ShadingRate::PerPixel,
            scissor: primitive.scissor,
            ..template.clone()
        }
    });
    let black = [0.0, 0.0, 0.0, 1.0];
    let window = TargetDescriptor {
        resource: WINDOW_TARGET,
        width,
        height,
        format: ColourFormat::Rgba8Unorm,
        samples: 1,
        clear: black,
        has_depth: false,
    };
    Ok(PassStep { name: "interface", reads: vec![], writes: Write::New(window), draws: draws.collect() })
}

/// The plan of a window.
///
/// # Errors
/// See [`interface_step`].
pub fn interface(primitives: Vec<UiPrimitive>, size: [u32; 2], provider: &impl ResourceProvider) -> Result<Plan, PlanError> {
    Ok(graph::compile(&[interface_step(primitives, size, provider)?], WINDOW_TARGET)?)
}

/// A plan that draws one white pixel. Rendering it once creates the pipelines and buffers that every window needs.
///
/// # Errors
/// See [`interface_step`].
pub fn warm_up_interface(provider: &impl ResourceProvider) -> Result<Plan, PlanError> {
    let white = Texture { format: TexelFormat::Rgba8Unorm, levels: vec![Level::new(1, 1, vec![255; 4])] };
    let primitive = UiPrimitive {
        positions_px: vec![0.0, 0.0, 2.0, 0.0, 0.0, 2.0],
        uvs: vec![0.5; 6],
        colours: vec![1.0; 12],
        indices: vec![0, 1, 2],
        texture: TextureSource::Image(Arc::new(white)),
        sampler: SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, is_trilinear: true },
        scissor: [0, 0, 1, 1],
    };
    interface(vec![primitive], [1, 1], provider)
}
