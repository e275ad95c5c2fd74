//! What passes draw into: colour, samples, depth.

use super::pipelines::DEPTH_FORMAT;
use super::resolve::{Resolve, Resolves};
use crate::render::plan::Pass;
use wgpu::{Device, Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView};

/// What the passes of the last frame drew into.
pub(super) struct Target {
    pub width: u32,
    pub height: u32,
    pub format: TextureFormat,
    pub samples: u32,
    /// The colour that a later pass reads: resolved.
    pub colour: wgpu::Texture,
    pub view: TextureView,
    /// With several samples.
    pub sampled: Option<TextureView>,
    /// `None`: the driver resolves.
    pub resolve: Option<Resolve>,
    pub depth: Option<TextureView>,
}

impl Target {
    /// `given`: a texture that is there and takes the colour. `resolves`: where samples become pixels by a shader of ours.
    pub fn new(
        device: &Device,
        resolves: Option<&mut Resolves>,
        pass: &Pass,
        format: TextureFormat,
        samples: u32,
        given: Option<&wgpu::Texture>,
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
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let own = || texture(format, 1, drawn | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC);
        let colour = given.cloned().unwrap_or_else(own);
        let usage = if resolves.is_some() { drawn | TextureUsages::TEXTURE_BINDING } else { drawn };
        let sampled = (samples > 1).then(|| view(&texture(format, samples, usage)));
        let resolve = resolves.zip(sampled.as_ref()).map(|(resolves, s)| resolves.of(device, s, format, samples));
        Self {
            width: pass.width,
            height: pass.height,
            format,
            samples,
            view: view(&colour),
            colour,
            sampled,
            resolve,
            depth: pass.depth.then(|| view(&texture(DEPTH_FORMAT, samples, drawn))),
        }
    }
}
