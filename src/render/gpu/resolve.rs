//! Samples to pixels by a shader of our own, where the driver's way is slow.
//!
//! In: a target of several samples. Out: a pass that writes their mean. A driver that computes on the processor resolves by a shader of its own that it
//! compiles anew at each start; ours comes out of its cache as all modules do. On hardware resolving is the driver's: there are circuits
//! for it, and samples need not leave the chip.

use std::collections::HashMap;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Color, ColorTargetState, ColorWrites, CommandEncoder, Device,
    FragmentState, LoadOp, MultisampleState, Operations, PipelineCompilationOptions, PrimitiveState, RenderPassColorAttachment,
    RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline, RenderPipelineDescriptor, ShaderModuleDescriptor, ShaderSource,
    StoreOp, TextureFormat, TextureView, VertexState,
};

const SHADER: &str = concat!(include_str!("../../../shaders/lib/screen.wesl"), include_str!("resolve.wgsl"));

/// Pipelines by what they write and of how many samples.
#[derive(Default)]
pub struct Resolves {
    made: HashMap<(TextureFormat, u32), RenderPipeline>,
}

/// One target's way from samples to pixels.
pub struct Resolve {
    pipeline: RenderPipeline,
    group: BindGroup,
}

impl Resolves {
    pub fn of(&mut self, device: &Device, samples: &TextureView, format: TextureFormat, count: u32) -> Resolve {
        let pipeline = self.made.entry((format, count)).or_insert_with(|| pipeline(device, format, count)).clone();
        let entries = [BindGroupEntry { binding: 0, resource: BindingResource::TextureView(samples) }];
        let layout = &pipeline.get_bind_group_layout(0);
        let group = device.create_bind_group(&BindGroupDescriptor { label: Some("resolve"), layout, entries: &entries });
        Resolve { pipeline, group }
    }
}

impl Resolve {
    pub fn encode(&self, encoder: &mut CommandEncoder, into: &TextureView, timestamp_writes: Option<RenderPassTimestampWrites<'_>>) {
        let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
        let colour = RenderPassColorAttachment { view: into, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("resolve"),
            color_attachments: &[Some(colour)],
            timestamp_writes,
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn pipeline(device: &Device, format: TextureFormat, count: u32) -> RenderPipeline {
    let source = ShaderSource::Wgsl(format!("const SAMPLES: i32 = {count};\n{SHADER}").into());
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
