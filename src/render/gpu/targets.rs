//! Render targets of passes.
//!
//! In: a pass of a plan, and which images are read back. Out: the textures into which the pass draws: colour, its samples if there are several per pixel,
//! and depth.

use super::pipelines::DEPTH_FORMAT;
use super::resolve::{ResolvePass, ResolvePipelines};
use crate::render::plan::{ColourFormat, FrameImages, Pass};
use wgpu::{Device, Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView};

/// The format of a target that the renderer owns. The linear image is stored in 32-bit floats if it is read back, otherwise in half floats if they suffice.
pub(super) fn texture_format(format: ColourFormat, requested: FrameImages) -> TextureFormat {
    match format {
        // The greatest half float is 65,504; shaders/lib/globe.wesl limits the radiance of emissive and of custom surfaces to 65,000. Rounding a radiance to
        // half floats changes its displayed value by at most 0.06 levels of 255, or by 0.25 if display white has radiance 4e-4; a scene whose white is dimmer,
        // or brighter than the greatest half float, is `HdrF32`.
        ColourFormat::Hdr if requested == FrameImages::Display => TextureFormat::Rgba16Float,
        ColourFormat::Hdr | ColourFormat::HdrF32 => TextureFormat::Rgba32Float,
        ColourFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
    }
}

/// The render target of one pass.
pub(super) struct PassTarget {
    pub width: u32,
    pub height: u32,
    pub format: TextureFormat,
    pub samples: u32,
    /// The resolved colour, which later passes read.
    pub colour: wgpu::Texture,
    /// The view of `colour`.
    pub view: TextureView,
    /// The multisampled colour, if the target has several samples per pixel.
    pub multisampled: Option<TextureView>,
    /// The pass that resolves the samples with a shader; `None` if the driver resolves them.
    pub resolve: Option<ResolvePass>,
    /// `None` if the pass has no depth buffer.
    pub depth: Option<TextureView>,
}

impl PassTarget {
    /// `external`: the caller's texture for the colour. `resolve_pipelines`: `Some` if a shader, not the driver, resolves the samples.
    pub(crate) fn new(
        device: &Device,
        resolve_pipelines: Option<&mut ResolvePipelines>,
        pass: &Pass,
        format: TextureFormat,
        samples: u32,
        external: Option<&wgpu::Texture>,
    ) -> Self {
        let texture = |format: TextureFormat, samples: u32, usage: TextureUsages| {
            device.create_texture(&TextureDescriptor {
                label: Some(pass.name),
                size: Extent3d { width: pass.width, height: pass.height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let attachment = TextureUsages::RENDER_ATTACHMENT;
        let new_colour = || texture(format, 1, attachment | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC);
        let colour = external.cloned().unwrap_or_else(new_colour);
        let usage = if resolve_pipelines.is_some() { attachment | TextureUsages::TEXTURE_BINDING } else { attachment };
        let multisampled = (samples > 1).then(|| view(&texture(format, samples, usage)));
        let resolve = resolve_pipelines.zip(multisampled.as_ref()).map(|(p, view)| p.resolve_pass(device, view, format, samples));
        Self {
            width: pass.width,
            height: pass.height,
            format,
            samples,
            view: view(&colour),
            colour,
            multisampled,
            resolve,
            depth: pass.has_depth.then(|| view(&texture(DEPTH_FORMAT, samples, attachment))),
        }
    }
}
