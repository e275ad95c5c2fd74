//! Resolves multisampled targets with a shader, on drivers that draw on the CPU (except GL drivers).
//!
//! In: a multisampled target. Out: a pass that writes the mean of each pixel's samples. Such drivers compile their built-in resolve shader at each start, but
//! keep this one in their disk cache (docs/measurements.md). Not used on hardware, where the driver can resolve with fixed-function units.

use std::collections::HashMap;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Color, ColorTargetState, ColorWrites, CommandEncoder, Device,
    FragmentState, LoadOp, MultisampleState, Operations, PipelineCompilationOptions, PrimitiveState, RenderPassColorAttachment,
    RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline, RenderPipelineDescriptor, ShaderModuleDescriptor, ShaderSource,
    StoreOp, TextureFormat, TextureView, VertexState,
};

/// WGSL without the constant SAMPLES, which [`create_pipeline`] prepends. `screen.wesl` is plain WGSL: it has neither conditions nor imports.
const SHADER: &str = concat!(include_str!("../../../shaders/lib/screen.wesl"), include_str!("resolve.wgsl"));

/// Resolve pipelines by target format and number of samples.
#[derive(Default)]
pub(crate) struct ResolvePipelines {
    by_format: HashMap<(TextureFormat, u32), RenderPipeline>,
}

/// The resolve pass of one target.
pub(crate) struct ResolvePass {
    pipeline: RenderPipeline,
    bind_group: BindGroup,
}

impl ResolvePipelines {
    pub(crate) fn resolve_pass(&mut self, device: &Device, multisampled: &TextureView, format: TextureFormat, samples: u32) -> ResolvePass {
        let pipeline = self.by_format.entry((format, samples)).or_insert_with(|| create_pipeline(device, format, samples)).clone();
        let entries = [BindGroupEntry { binding: 0, resource: BindingResource::TextureView(multisampled) }];
        let layout = &pipeline.get_bind_group_layout(0);
        let bind_group = device.create_bind_group(&BindGroupDescriptor { label: Some("resolve"), layout, entries: &entries });
        ResolvePass { pipeline, bind_group }
    }
}

impl ResolvePass {
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        timestamp_writes: Option<RenderPassTimestampWrites<'_>>,
    ) {
        let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
        let colour = RenderPassColorAttachment { view: target, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("resolve"),
            color_attachments: &[Some(colour)],
            timestamp_writes,
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn create_pipeline(device: &Device, format: TextureFormat, samples: u32) -> RenderPipeline {
    let source = ShaderSource::Wgsl(format!("const SAMPLES: i32 = {samples};\n{SHADER}").into());
    let module = &device.create_shader_module(ShaderModuleDescriptor { label: Some("resolve"), source });
    let compilation_options = PipelineCompilationOptions::default();
    let target = ColorTargetState { format, blend: None, write_mask: ColorWrites::ALL };
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("resolve"),
        layout: None,
        vertex: VertexState { module, entry_point: None, compilation_options: compilation_options.clone(), buffers: &[] },
        primitive: PrimitiveState::default(),
        depth_stencil: None,
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState { module, entry_point: None, compilation_options, targets: &[Some(target)] }),
        multiview_mask: None,
        cache: None,
    })
}
