//! Cache of render pipelines, shader modules and samplers.
//!
//! In: the draws of a plan, and the modules that they name. Out: the pipeline of each draw, created at its first use. The key of a pipeline is everything on
//! which it depends: module, target format, samples, blending, depth, culling, attributes and the textures declared unfilterable.
//!
//! A module is passed to wgpu as the shader library's naga IR, so no text is parsed again; wgpu adds its bounds checks. Bind group 0 follows the module's
//! reflected layout: the uniform block (at a dynamic offset into one buffer per frame), textures, samplers.

use super::{GpuError, with_error_scopes};
use crate::image::TexelFormat;
use crate::render::plan::{
    AddressMode, Blend, Cull, DepthState, FrontFace, ModuleProvider, Pass, Plan, PlanDraw, SamplerState, TextureSource, Vertices,
};
use crate::shader::Layout;
use crate::shader::ModuleId;
use parking_lot::Mutex;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::num::NonZeroU64;
use std::sync::Arc;
use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BlendComponent, BlendFactor, BlendOperation, BlendState,
    BufferBindingType, ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, Device, Face, FilterMode, FragmentState,
    MipmapFilterMode, MultisampleState, PipelineCompilationOptions, PipelineLayoutDescriptor, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, Sampler, SamplerBindingType, SamplerDescriptor, ShaderModuleDescriptor, ShaderSource, ShaderStages,
    TextureFormat, TextureSampleType, TextureViewDimension, VertexAttribute, VertexBufferLayout, VertexFormat, VertexState, VertexStepMode,
};

pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Everything that distinguishes one pipeline from another.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    pub module: ModuleId,
    pub target_format: TextureFormat,
    pub samples: u32,
    blend: Blend,
    cull: Cull,
    front_face: FrontFace,
    /// `None`: the pass has no depth target.
    depth: Option<DepthState>,
    /// Number of f32 components of each attribute, per-vertex attributes first.
    attributes: Vec<u32>,
    /// Number of attributes that are per vertex; the others are per instance.
    vertex_attribute_count: usize,
    /// Bindings whose textures are declared unfilterable ([`unfilterable`]).
    unfilterable: Vec<u32>,
}

impl PipelineKey {
    pub(crate) fn of(draw: &PlanDraw, target_format: TextureFormat, samples: u32, has_depth: bool) -> Self {
        let vertex_attributes = match &draw.vertices {
            Vertices::Count(_) => &[][..],
            Vertices::Mesh { attributes, .. } => attributes,
        };
        Self {
            module: draw.module.clone(),
            target_format,
            samples,
            blend: draw.blend,
            cull: draw.cull,
            front_face: draw.front_face,
            depth: has_depth.then_some(draw.depth),
            attributes: vertex_attributes.iter().chain(&draw.instances.attributes).map(|a| a.components).collect(),
            vertex_attribute_count: vertex_attributes.len(),
            unfilterable: unfilterable(draw),
        }
    }
}

/// Bindings of the textures that are declared unfilterable, because a GPU need not support filtering of 32-bit float textures: images in such a format, and
/// outputs of passes, which may have such a format. Shaders read them with `textureLoad`.
fn unfilterable(draw: &PlanDraw) -> Vec<u32> {
    let may_be_float32 = |source: &TextureSource| match source {
        TextureSource::Image(texture) | TextureSource::Persistent(texture) => texture.format == TexelFormat::Rgba32Float,
        TextureSource::PassOutput(_) => true,
        // A display image: 8 bits per channel.
        TextureSource::OnGpu(_) => false,
    };
    draw.textures.iter().filter(|t| may_be_float32(&t.source)).map(|t| t.binding).collect()
}

/// Whether the draw has triangles, instances, and a pixel in its scissor rectangle. Other draws are skipped: wgpu panics at the empty buffers of a draw without
/// triangles or instances.
pub(super) fn draws_pixels(draw: &PlanDraw) -> bool {
    let has_triangles = match &draw.vertices {
        Vertices::Count(count) => *count > 0,
        Vertices::Mesh { indices, .. } => !indices.is_empty(),
    };
    let [x0, y0, x1, y1] = draw.scissor;
    has_triangles && draw.instances.count > 0 && x0 < x1 && y0 < y1
}

/// The pipeline keys of a plan's draws that are not skipped ([`draws_pixels`]), in order. `format`: target format by pass index.
pub(super) fn pipeline_keys(plan: &Plan, format: impl Fn(usize) -> TextureFormat) -> Vec<PipelineKey> {
    let key = |k: usize, pass: &Pass, d: &PlanDraw| PipelineKey::of(d, format(k), u32::from(pass.samples), pass.has_depth);
    let passes = plan.passes.iter().enumerate();
    passes
        .flat_map(|(k, pass)| pass.draws.iter().filter(|d| draws_pixels(d)).map(move |d| (k, pass, d)))
        .map(|(k, pass, d)| key(k, pass, d))
        .collect()
}

/// A pipeline with its bind group layout and its module's reflected layout.
pub(crate) struct Pipeline {
    pub pipeline: RenderPipeline,
    pub bind_group_layout: BindGroupLayout,
    pub layout: Layout,
}

#[derive(Default)]
pub(crate) struct Pipelines {
    /// With their reflected layouts.
    modules: HashMap<ModuleId, (wgpu::ShaderModule, Layout)>,
    by_key: HashMap<PipelineKey, Arc<Pipeline>>,
    samplers: HashMap<SamplerState, Sampler>,
}

impl Pipelines {
    pub(crate) fn has(&self, key: &PipelineKey) -> bool {
        self.by_key.contains_key(key)
    }

    /// Number of pipelines in the cache.
    pub(crate) fn len(&self) -> usize {
        self.by_key.len()
    }

    /// The pipeline of this key, if [`Pipelines::create`] has created it.
    pub(crate) fn get(&self, key: &PipelineKey) -> Option<Arc<Pipeline>> {
        self.by_key.get(key).cloned()
    }

    /// Creates the pipelines of `keys` that the cache lacks on several threads, because most drivers compile shaders when a pipeline is created, which is slow.
    pub(crate) fn create(&mut self, device: &Device, keys: &[PipelineKey], provider: &impl ModuleProvider) -> Result<(), GpuError> {
        let missing: Vec<&PipelineKey> =
            keys.iter().filter(|k| !self.by_key.contains_key(*k)).collect::<HashSet<_>>().into_iter().collect();
        let module_error = |id: &ModuleId, what: String| GpuError::Draw { draw: id.to_string(), what };
        let threads = compiler_threads(device.adapter_info().backend);
        let ids: HashSet<&ModuleId> = missing.iter().map(|k| &k.module).filter(|id| !self.modules.contains_key(*id)).collect();
        let created = parallel_map(threads, ids.into_iter().collect(), |id| {
            let module = provider.module(id).map_err(|e| module_error(id, e.to_string()))?;
            let label = module.id.to_string();
            let source = ShaderSource::Naga(Cow::Owned(module.module.clone()));
            let descriptor = ShaderModuleDescriptor { label: Some(&label), source };
            Ok((id.clone(), (with_error_scopes(device, || device.create_shader_module(descriptor))?, module.layout.clone())))
        });
        self.modules.extend(created.into_iter().collect::<Result<Vec<_>, GpuError>>()?);
        let created = parallel_map(threads, missing, |key| {
            let (module, layout) = &self.modules[&key.module];
            let pipeline = with_error_scopes(device, || create_pipeline(device, key, module, layout))?
                .map_err(|what| module_error(&key.module, what))?;
            Ok((key.clone(), Arc::new(pipeline)))
        });
        let created = created.into_iter().collect::<Result<Vec<_>, GpuError>>()?;
        self.by_key.extend(created);
        Ok(())
    }

    /// The sampler of this state, created at its first use.
    pub(crate) fn sampler(&mut self, device: &Device, state: SamplerState) -> Sampler {
        let sampler = self.samplers.entry(state).or_insert_with(|| {
            let address = |mode: AddressMode| match mode {
                AddressMode::Repeat => wgpu::AddressMode::Repeat,
                AddressMode::ClampToEdge => wgpu::AddressMode::ClampToEdge,
            };
            let (filter, mipmap_filter) = if state.is_trilinear {
                (FilterMode::Linear, MipmapFilterMode::Linear)
            } else {
                (FilterMode::Nearest, MipmapFilterMode::Nearest)
            };
            device.create_sampler(&SamplerDescriptor {
                address_mode_u: address(state.address_u),
                address_mode_v: address(state.address_v),
                mag_filter: filter,
                min_filter: filter,
                mipmap_filter,
                ..SamplerDescriptor::default()
            })
        });
        sampler.clone()
    }
}

/// Number of threads that compile for a backend: as many as there are cores, but only one for GL. GL has one context, which only one thread uses at a time;
/// wgpu panics when a call has waited for the context for six seconds. With NVIDIA's GL driver, compiling one view's modules on sixteen threads took longer
/// than that.
fn compiler_threads(backend: wgpu::Backend) -> usize {
    if backend == wgpu::Backend::Gl { 1 } else { std::thread::available_parallelism().map_or(1, usize::from) }
}

/// Maps all items on up to `threads` threads; the order of the results is arbitrary. The function starts its own threads, because in a shared pool the drawing
/// of the window would wait for the driver's compiler.
fn parallel_map<T: Send, R: Send>(threads: usize, items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = threads.min(items.len());
    let items = Mutex::new(items.into_iter());
    let run = || {
        let next = || items.lock().next();
        std::iter::from_fn(next).map(&work).collect::<Vec<R>>()
    };
    std::thread::scope(|scope| {
        let handles: Vec<_> = (1..threads).map(|_| scope.spawn(run)).collect();
        let mut results = run();
        for handle in handles {
            results.extend(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        results
    })
}

fn bind_group_entries(layout: &Layout, unfilterable: &[u32]) -> Vec<BindGroupLayoutEntry> {
    let entry =
        |binding: u32, ty: BindingType| BindGroupLayoutEntry { binding, visibility: ShaderStages::VERTEX_FRAGMENT, ty, count: None };
    let uniforms = NonZeroU64::new(u64::from(layout.uniform_size)).map(|size| {
        entry(0, BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: true, min_binding_size: Some(size) })
    });
    let textures = layout.textures.iter().map(|t| {
        let sample_type = TextureSampleType::Float { filterable: !unfilterable.contains(&t.binding) };
        entry(t.binding, BindingType::Texture { sample_type, view_dimension: TextureViewDimension::D2, multisampled: false })
    });
    let samplers = layout.samplers.iter().map(|s| entry(s.binding, BindingType::Sampler(SamplerBindingType::Filtering)));
    uniforms.into_iter().chain(textures).chain(samplers).collect()
}

fn blend_state(blend: Blend) -> Option<BlendState> {
    let component = |dst_factor: BlendFactor| BlendComponent { src_factor: BlendFactor::One, dst_factor, operation: BlendOperation::Add };
    let both = |dst: BlendFactor| Some(BlendState { color: component(dst), alpha: component(dst) });
    match blend {
        Blend::Replace => None,
        Blend::PremultipliedOver => both(BlendFactor::OneMinusSrcAlpha),
        Blend::Add => both(BlendFactor::One),
    }
}

fn create_pipeline(device: &Device, key: &PipelineKey, module: &wgpu::ShaderModule, layout: &Layout) -> Result<Pipeline, String> {
    let label = key.module.to_string();
    let entries = bind_group_entries(layout, &key.unfilterable);
    let bind_group_layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
    let pipeline_layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some(&label),
        bind_group_layouts: &[Some(&bind_group_layout)],
        immediate_size: 0,
    });
    // Each attribute has a buffer of its own.
    let mut attributes = Vec::new();
    for (location, components) in (0..).zip(&key.attributes) {
        let format = match components {
            1 => VertexFormat::Float32,
            2 => VertexFormat::Float32x2,
            3 => VertexFormat::Float32x3,
            4 => VertexFormat::Float32x4,
            n => return Err(format!("an attribute has {n} components; 1 to 4 are possible")),
        };
        attributes.push([VertexAttribute { format, offset: 0, shader_location: location }]);
    }
    let buffers: Vec<_> = attributes
        .iter()
        .enumerate()
        .map(|(k, attribute)| {
            let step_mode = if k < key.vertex_attribute_count { VertexStepMode::Vertex } else { VertexStepMode::Instance };
            Some(VertexBufferLayout { array_stride: 4 * u64::from(key.attributes[k]), step_mode, attributes: attribute })
        })
        .collect();
    let depth_stencil = key.depth.map(|depth| DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(depth.write),
        // Reversed: greater is nearer.
        depth_compare: Some(if depth.test { CompareFunction::Greater } else { CompareFunction::Always }),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    });
    let target = ColorTargetState { format: key.target_format, blend: blend_state(key.blend), write_mask: ColorWrites::ALL };
    let pipeline = device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some(&label),
        layout: Some(&pipeline_layout),
        vertex: VertexState { module, entry_point: None, compilation_options: PipelineCompilationOptions::default(), buffers: &buffers },
        primitive: PrimitiveState {
            cull_mode: (key.cull == Cull::Back).then_some(Face::Back),
            front_face: match key.front_face {
                FrontFace::CounterClockwise => wgpu::FrontFace::Ccw,
                FrontFace::Clockwise => wgpu::FrontFace::Cw,
            },
            ..PrimitiveState::default()
        },
        depth_stencil,
        multisample: MultisampleState { count: key.samples, ..MultisampleState::default() },
        fragment: Some(FragmentState {
            module,
            entry_point: None,
            compilation_options: PipelineCompilationOptions::default(),
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        // A pipeline cache is only useful for drivers without a disk cache of their own. Mesa's drivers have a disk cache (docs/measurements.md).
        cache: None,
    });
    Ok(Pipeline { pipeline, bind_group_layout, layout: layout.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_map_maps_each_item_once() {
        for (threads, count) in [(1, 5), (4, 0), (4, 1), (2, 2), (3, 100)] {
            let mut results = parallel_map(threads, (0..count).collect(), |k| 3 * k);
            results.sort_unstable();
            assert_eq!(results, (0..count).map(|k| 3 * k).collect::<Vec<_>>());
        }
    }

    #[test]
    fn gl_compiles_on_one_thread() {
        assert_eq!(compiler_threads(wgpu::Backend::Gl), 1);
        assert_eq!(compiler_threads(wgpu::Backend::Vulkan), std::thread::available_parallelism().map_or(1, usize::from));
    }
}
