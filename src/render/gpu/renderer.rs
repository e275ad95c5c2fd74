//! Draws one frame on the GPU: targets, uniform bytes, passes, readback.
//!
//! In: a plan and its modules. Out: a [`Frame`] in CPU memory, an image in GPU memory, or a texture of a window. Always: the uniform bytes, attributes and
//! indices of a frame are each uploaded with one write. Error scopes around each frame catch its errors. After the device is lost, or an error outside a frame,
//! every later draw returns that error.

use super::adapters::{AdapterFacts, AdapterKind, OpenedDevice, open, open_gl};
use super::bytes::{Buffers, DrawOffsets, FrameBytes};
use super::gpu_images::GpuImages;
use super::pass_timer::{MAX_TIMED_PASSES, PassTimer, TIMESTAMP_PAIR_BYTES, timed_pass_count};
use super::pipelines::{Pipeline, PipelineKey, Pipelines, draws_pixels, pipeline_keys};
use super::readback::Readback;
use super::resolve::ResolvePipelines;
use super::targets::{PassTarget, texture_format};
use super::uploads::Uploads;
use super::{GpuError, with_error_scopes};
use crate::render::frame::Frame;
use crate::render::plan::{ColourFormat, FrameImages, GpuImage, ModuleProvider, Pass, Plan, PlanDraw, TextureSource, Vertices};
use crate::shader::ModuleId;
use parking_lot::{Mutex, MutexGuard};
use std::sync::Arc;
use std::time::Instant;
use wgpu::{
    Adapter, BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, BufferBinding, Color, CommandEncoder, Device, IndexFormat,
    Instance, LoadOp, Operations, PollType, Queue, RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPassTimestampWrites, StoreOp, TextureFormat,
};

/// Times of a GPU frame, and the bytes uploaded for it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct GpuTimings {
    /// Name and GPU milliseconds of the first passes, `MAX_TIMED_PASSES` at most; empty if the adapter has no timestamps.
    pub passes_ms: Vec<(String, f64)>,
    /// Bytes of textures uploaded for this frame.
    pub uploaded_bytes: u64,
    /// Milliseconds from the call (without its wait for the resources' lock) to the finished frame, including the wait for the GPU and any readback.
    pub wall_ms: f64,
}

/// GPU resources that are kept from frame to frame.
#[derive(Default)]
pub(super) struct FrameResources {
    pipelines: Pipelines,
    resolve_pipelines: ResolvePipelines,
    uploads: Uploads,
    pub(super) targets: Vec<PassTarget>,
    buffers: Buffers,
    readback: Readback,
    pass_timer: Option<PassTimer>,
}

impl FrameResources {
    fn pass_times(&self, device: &Device, queue: &Queue, plan: &Plan) -> Result<Vec<(String, f64)>, GpuError> {
        self.pass_timer.as_ref().map_or_else(|| Ok(Vec::new()), |pass_timer| pass_timer.read(device, queue, plan))
    }

    /// Whether all pipelines of a plan exist. `format`: the format of a pass's target, by the pass's index.
    pub(crate) fn is_ready(&self, plan: &Plan, format: impl Fn(usize) -> TextureFormat) -> bool {
        pipeline_keys(plan, format).iter().all(|key| self.pipelines.has(key))
    }
}

/// Target of a plan's last pass.
#[derive(Clone, Copy)]
pub(super) enum RenderTarget<'a> {
    /// A target that the renderer owns, in the format that is needed to return these images ([`texture_format`]).
    Owned(FrameImages),
    /// A texture of the caller, such as a window's.
    External(&'a wgpu::Texture),
}

/// Executes plans on one device.
pub struct GpuRenderer {
    facts: AdapterFacts,
    pub(super) instance: Instance,
    pub(super) adapter: Adapter,
    pub(super) device: Device,
    pub(super) queue: Queue,
    /// Whether the device can blend into targets of 32-bit floats with several samples per pixel.
    blends_f32: bool,
    has_timestamps: bool,
    /// Whether `resolve.wgsl`, not the driver, resolves multisampled targets; the module `resolve` states the reason.
    resolves_by_shader: bool,
    /// The error that every later draw returns: the device was lost, or an error occurred outside a frame.
    fatal_error: Arc<Mutex<Option<GpuError>>>,
    /// Resources for off-screen frames.
    resources: Mutex<FrameResources>,
    /// Resources for frames of windows, separate so that a window never waits for an off-screen frame that is being drawn.
    pub(super) window_resources: Mutex<FrameResources>,
    /// Images of off-screen frames that stay in GPU memory, where windows read them.
    finished_images: Mutex<GpuImages>,
}

/// Exclusive use of the resources for off-screen frames; a window's frames have their own.
pub struct FrameResourcesLock<'a>(MutexGuard<'a, FrameResources>);

/// A draw with its pipeline, bind group and offsets in the frame's buffers.
struct PreparedDraw<'a> {
    draw: &'a PlanDraw,
    pipeline: Arc<Pipeline>,
    bind_group: BindGroup,
    offsets: DrawOffsets,
}

impl GpuRenderer {
    /// Opens the best adapter. `accept_software`: whether a driver that draws on the CPU is accepted.
    ///
    /// # Errors
    /// No adapter, or no adapter with the features that every plan needs.
    pub fn open(accept_software: bool) -> Result<Self, GpuError> {
        Ok(Self::of(open(accept_software)?))
    }

    /// Opens a GL adapter; software drivers are accepted.
    ///
    /// # Errors
    /// As [`GpuRenderer::open`].
    pub fn open_gl() -> Result<Self, GpuError> {
        Ok(Self::of(open_gl()?))
    }

    fn of(OpenedDevice { facts, instance, adapter, device, queue, blends_f32, has_timestamps }: OpenedDevice) -> Self {
        let fatal_error: Arc<Mutex<Option<GpuError>>> = Arc::default();
        let (on_loss, on_error) = (Arc::clone(&fatal_error), Arc::clone(&fatal_error));
        device.set_device_lost_callback(move |_, why| {
            let why = if why.is_empty() { "the driver gave no reason".to_owned() } else { super::one_line(&why) };
            on_loss.lock().get_or_insert(GpuError::DeviceLost(why));
        });
        // Records errors outside a frame's scopes; by default wgpu would panic.
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            on_error.lock().get_or_insert(e.into());
        }));
        let resolves_by_shader = facts.kind == AdapterKind::Software && adapter.get_info().backend != wgpu::Backend::Gl;
        let (resources, window_resources, finished_images) = (Mutex::default(), Mutex::default(), Mutex::default());
        Self {
            facts,
            instance,
            adapter,
            device,
            queue,
            blends_f32,
            has_timestamps,
            resolves_by_shader,
            fatal_error,
            resources,
            window_resources,
            finished_images,
        }
    }

    pub fn facts(&self) -> &AdapterFacts {
        &self.facts
    }

    /// Destroys the device, so that every later frame fails as if the driver had lost it. Tests of the recovery from such a loss use this.
    pub(crate) fn destroy(&self) {
        self.device.destroy();
    }

    /// Waits for exclusive use of the resources for off-screen frames.
    pub(crate) fn lock(&self) -> FrameResourcesLock<'_> {
        FrameResourcesLock(self.resources.lock())
    }

    /// As [`GpuRenderer::lock`], but only if the plan's display image can be drawn without waiting for the shader compiler or for another frame.
    pub(crate) fn try_lock_for(&self, plan: &Plan) -> Option<FrameResourcesLock<'_>> {
        let resources = self.resources.try_lock()?;
        resources.is_ready(plan, |k| texture_format(plan.passes[k].format, FrameImages::Display)).then_some(FrameResourcesLock(resources))
    }

    /// Drops the pipelines of all modules. The caller must do this after a module's source has changed under the same name.
    pub fn forget_modules(&self) {
        for resources in [&self.resources, &self.window_resources] {
            resources.lock().pipelines = Pipelines::default();
        }
    }

    /// Bytes of uploaded textures in GPU memory, and the number of pipelines: the sums for off-screen frames and windows.
    pub fn resource_use(&self) -> (u64, usize) {
        [&self.resources, &self.window_resources].iter().fold((0, 0), |(bytes, pipelines), resources| {
            let resources = resources.lock();
            (bytes + resources.uploads.resident_bytes(), pipelines + resources.pipelines.len())
        })
    }

    /// Draws the plan and returns the `requested` images.
    ///
    /// # Errors
    /// See [`GpuError`]; after one for which [`GpuError::is_final`] holds, the next frame fails too.
    pub fn render(&self, plan: &Plan, modules: &impl ModuleProvider, requested: FrameImages) -> Result<(Frame, GpuTimings), GpuError> {
        self.render_locked(self.lock(), plan, modules, requested)
    }

    /// Like [`GpuRenderer::render`], with a lock that the caller has acquired.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub(crate) fn render_locked(
        &self,
        FrameResourcesLock(mut resources): FrameResourcesLock<'_>,
        plan: &Plan,
        modules: &impl ModuleProvider,
        requested: FrameImages,
    ) -> Result<(Frame, GpuTimings), GpuError> {
        if requested == FrameImages::DisplayAndHdr && !self.blends_f32 {
            return Err(GpuError::Unsupported("linear images on this adapter, which cannot blend 32-bit floats"));
        }
        let start = Instant::now();
        let (frame, mut timings) = self.run_checked(plan, || {
            let uploaded_bytes = self.submit(&mut resources, plan, modules, RenderTarget::Owned(requested))?;
            let frame = self.read_back(&mut resources, plan, requested)?;
            Ok((frame, GpuTimings { uploaded_bytes, passes_ms: resources.pass_times(&self.device, &self.queue, plan)?, wall_ms: 0.0 }))
        })?;
        timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
        Ok((frame, timings))
    }

    /// Draws the plan and leaves the image in GPU memory.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub fn render_to_gpu(&self, plan: &Plan, modules: &impl ModuleProvider) -> Result<(GpuImage, GpuTimings), GpuError> {
        self.render_to_gpu_locked(self.lock(), plan, modules)
    }

    /// Like [`GpuRenderer::render_to_gpu`], with a lock that the caller has acquired.
    ///
    /// # Errors
    /// As [`GpuRenderer::render`].
    pub(crate) fn render_to_gpu_locked(
        &self,
        FrameResourcesLock(mut resources): FrameResourcesLock<'_>,
        plan: &Plan,
        modules: &impl ModuleProvider,
    ) -> Result<(GpuImage, GpuTimings), GpuError> {
        let start = Instant::now();
        let (image, mut timings) = self.run_checked(plan, || {
            let uploaded_bytes = self.submit(&mut resources, plan, modules, RenderTarget::Owned(FrameImages::Display))?;
            // The image is handed over, so its target cannot be reused: the next frame creates another one.
            let last = resources.targets.pop().ok_or(GpuError::NoPass)?;
            // Wait until the image is drawn, so that frames do not queue up.
            self.device.poll(PollType::wait_indefinitely()).map_err(|e| GpuError::DeviceLost(e.to_string()))?;
            let passes_ms = resources.pass_times(&self.device, &self.queue, plan)?;
            let image = self.finished_images.lock().register(last.view, [last.width, last.height]);
            Ok((image, GpuTimings { uploaded_bytes, passes_ms, wall_ms: 0.0 }))
        })?;
        timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
        Ok((image, timings))
    }

    /// Whether the image is in the memory of this device.
    pub fn holds(&self, image: &GpuImage) -> bool {
        self.finished_images.lock().get(image).is_some()
    }

    /// Runs `work`, which draws a plan, and catches the device's errors. If this device cannot draw the plan, returns an error and does not run `work`.
    pub(super) fn run_checked<T>(&self, plan: &Plan, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        self.check_fatal_error()?;
        // Only the modules of the pixel view `cost` have a number of instructions per texture read.
        let is_cost_view = |d: &PlanDraw| matches!(&d.module, ModuleId::Keyed(k) if k.instructions_per_read().is_some());
        if plan.passes.iter().flat_map(|p| &p.draws).any(is_cost_view) {
            return Err(GpuError::Unsupported("the cost view, which counts the software renderer's operations"));
        }
        // `HdrF32` is the format of scenes whose white is too dim or too bright for half floats.
        if !self.blends_f32 && plan.passes.iter().any(|p| p.format == ColourFormat::HdrF32) {
            return Err(GpuError::Unsupported(
                "scenes exposed for a night sky, or shorter than for the Sun, on this adapter, which cannot blend 32-bit floats",
            ));
        }
        let result = with_error_scopes(&self.device, work);
        self.check_fatal_error()?;
        result?
    }

    pub(super) fn check_fatal_error(&self) -> Result<(), GpuError> {
        self.fatal_error.lock().clone().map_or(Ok(()), Err)
    }

    /// Uploads a plan's data and submits its passes. Returns the number of texture bytes that were uploaded. Afterwards `resources` contains the target
    /// of the last pass, too, even if it is the caller's texture ([`Self::submit_to_window`] removes that target).
    pub(super) fn submit(
        &self,
        resources: &mut FrameResources,
        plan: &Plan,
        modules: &impl ModuleProvider,
        target: RenderTarget<'_>,
    ) -> Result<u64, GpuError> {
        let uploaded_bytes_before = resources.uploads.total_uploaded_bytes;
        resources.uploads.begin_frame();
        self.update_targets(resources, plan, target)?;
        let mut bytes = FrameBytes::default();
        let mut prepared = Vec::new();
        // Collect the data of all draws first, because they determine the sizes of the buffers.
        let align = self.device.limits().min_uniform_buffer_offset_alignment as usize;
        let offsets_by_pass: Vec<Vec<_>> = plan.passes.iter().map(|p| p.draws.iter().map(|d| bytes.append(d, align)).collect()).collect();
        resources.buffers.upload(&self.device, &self.queue, &bytes);
        let formats: Vec<TextureFormat> = resources.targets.iter().map(|t| t.format).collect();
        let keys = pipeline_keys(plan, |k| formats[k]);
        resources.pipelines.create(&self.device, &keys, modules)?;
        // One key for each draw of the plan that is not skipped, in order: each pass takes its own from the front.
        let mut remaining_keys = keys.iter();
        for (pass_index, (pass, offsets_of_draws)) in plan.passes.iter().zip(offsets_by_pass).enumerate() {
            let draws = pass.draws.iter().zip(offsets_of_draws).filter(|(d, _)| draws_pixels(d)).zip(&mut remaining_keys);
            prepared.push(
                draws.map(|((d, offsets), key)| self.prepare(resources, key, pass_index, d, offsets)).collect::<Result<Vec<_>, _>>()?,
            );
        }
        // Frames of windows are not timed.
        if self.has_timestamps && resources.pass_timer.is_none() && matches!(target, RenderTarget::Owned(_)) {
            resources.pass_timer = Some(PassTimer::new(&self.device));
        }
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (k, (pass, draws)) in plan.passes.iter().zip(&prepared).enumerate() {
            self.encode(&mut encoder, resources, pass, draws, k);
        }
        if let Some(pass_timer) = &resources.pass_timer {
            let timed = timed_pass_count(plan);
            encoder.resolve_query_set(&pass_timer.queries, 0..2 * timed, &pass_timer.results, 0);
            encoder.copy_buffer_to_buffer(&pass_timer.results, 0, &pass_timer.readback, 0, u64::from(TIMESTAMP_PAIR_BYTES * timed));
        }
        self.queue.submit([encoder.finish()]);
        Ok(resources.uploads.total_uploaded_bytes - uploaded_bytes_before)
    }

    /// Reads back the output of the last pass, and the linear (HDR) image if it is `requested`.
    fn read_back(&self, resources: &mut FrameResources, plan: &Plan, requested: FrameImages) -> Result<Frame, GpuError> {
        let last = resources.targets.last().ok_or(GpuError::NoPass)?;
        let mut frame = Frame { width: last.width, height: last.height, hdr: Vec::new(), display: Vec::new() };
        let floats = |pixels: Vec<[u8; 16]>| -> Vec<[f32; 4]> { pixels.iter().map(|p| bytemuck::pod_read_unaligned(p)).collect() };
        if last.format == TextureFormat::Rgba8Unorm {
            frame.display = resources.readback.pixels(&self.device, &self.queue, &last.colour)?;
            // A warped image or a stereo pair is made from linear images that may have another size; it has no linear image of its own.
            let is_hdr = |t: &&PassTarget| t.format == TextureFormat::Rgba32Float && (t.width, t.height) == (last.width, last.height);
            let hdr_index = plan.hdr_pass_index().filter(|_| requested == FrameImages::DisplayAndHdr);
            if let Some(hdr_target) = hdr_index.and_then(|k| resources.targets.get(k)).filter(is_hdr) {
                frame.hdr = floats(resources.readback.pixels(&self.device, &self.queue, &hdr_target.colour)?);
            }
        } else if last.format == TextureFormat::Rgba32Float && requested == FrameImages::DisplayAndHdr {
            frame.hdr = floats(resources.readback.pixels(&self.device, &self.queue, &last.colour)?);
        } else {
            return Err(GpuError::Unsupported("a display image from a plan that ends with its linear image"));
        }
        Ok(frame)
    }

    /// Creates the targets of the plan's passes, reusing those of the previous frame that fit.
    fn update_targets(&self, resources: &mut FrameResources, plan: &Plan, target: RenderTarget<'_>) -> Result<(), GpuError> {
        let max_side = self.device.limits().max_texture_dimension_2d;
        let requested = if let RenderTarget::Owned(requested) = target { requested } else { FrameImages::Display };
        resources.targets.truncate(plan.passes.len());
        for (k, pass) in plan.passes.iter().enumerate() {
            let external = match target {
                RenderTarget::External(texture) if k + 1 == plan.passes.len() => Some(texture),
                _ => None,
            };
            let format = external.map_or_else(|| texture_format(pass.format, requested), wgpu::Texture::format);
            let samples = u32::from(pass.samples);
            if pass.width == 0 || pass.height == 0 || pass.width > max_side || pass.height > max_side {
                return Err(GpuError::TargetSize { adapter: self.facts.to_string(), width: pass.width, height: pass.height, max_side });
            }
            let fits = |t: &PassTarget| {
                (t.width, t.height, t.format, t.samples, t.depth.is_some()) == (pass.width, pass.height, format, samples, pass.has_depth)
            };
            if external.is_none() && resources.targets.get(k).is_some_and(fits) {
                continue;
            }
            // `None`: the driver resolves the samples.
            let resolve_pipelines = self.resolves_by_shader.then_some(&mut resources.resolve_pipelines);
            let new = PassTarget::new(&self.device, resolve_pipelines, pass, format, samples, external);
            if k < resources.targets.len() { resources.targets[k] = new } else { resources.targets.push(new) }
        }
        Ok(())
    }

    /// Finds a draw's pipeline, and binds its textures, samplers and uniforms.
    fn prepare<'a>(
        &self,
        resources: &mut FrameResources,
        key: &PipelineKey,
        pass_index: usize,
        draw: &'a PlanDraw,
        offsets: DrawOffsets,
    ) -> Result<PreparedDraw<'a>, GpuError> {
        let draw_error = |what: String| GpuError::Draw { draw: draw.label.clone(), what };
        let pipeline = resources.pipelines.get(key).ok_or_else(|| draw_error("has no pipeline".into()))?;
        if let Some(location) = offsets.attributes.iter().position(|range| range.is_empty()) {
            return Err(draw_error(format!("attribute {location} has no values")));
        }
        let missing = |binding: u32| draw_error(format!("binding {binding} is not supplied"));
        let mut views = Vec::new();
        for texture in &pipeline.layout.textures {
            let bound = draw.textures.iter().find(|t| t.binding == texture.binding).ok_or_else(|| missing(texture.binding))?;
            let view = match &bound.source {
                TextureSource::Image(image) | TextureSource::Persistent(image) => {
                    let is_persistent = matches!(bound.source, TextureSource::Persistent(_));
                    resources.uploads.view(&self.device, &self.queue, image, is_persistent).map_err(draw_error)?
                }
                TextureSource::OnGpu(image) => {
                    self.finished_images.lock().get(image).ok_or_else(|| draw_error("reads an image of another device".into()))?
                }
                TextureSource::PassOutput(k) if *k < pass_index => resources.targets[*k].view.clone(),
                TextureSource::PassOutput(k) => return Err(draw_error(format!("reads pass {k}, which is not drawn before it"))),
            };
            views.push((texture.binding, view));
        }
        let mut samplers = Vec::new();
        for sampler in &pipeline.layout.samplers {
            let bound = draw.samplers.iter().find(|s| s.binding == sampler.binding).ok_or_else(|| missing(sampler.binding))?;
            samplers.push((sampler.binding, resources.pipelines.sampler(&self.device, bound.state)));
        }
        let mut entries = Vec::new();
        if pipeline.layout.uniform_size > 0 {
            let needed = pipeline.layout.uniform_size;
            let has_needed_bytes = draw.uniform_bytes.len() == needed as usize;
            let (Some(buffer), true) = (&resources.buffers.uniforms, has_needed_bytes) else {
                return Err(draw_error(format!("has {} uniform bytes; its module needs {needed}", draw.uniform_bytes.len())));
            };
            let size = std::num::NonZeroU64::new(u64::from(needed));
            entries.push(BindGroupEntry { binding: 0, resource: BindingResource::Buffer(BufferBinding { buffer, offset: 0, size }) });
        }
        entries.extend(views.iter().map(|(binding, v)| BindGroupEntry { binding: *binding, resource: BindingResource::TextureView(v) }));
        entries.extend(samplers.iter().map(|(binding, s)| BindGroupEntry { binding: *binding, resource: BindingResource::Sampler(s) }));
        let descriptor = BindGroupDescriptor { label: Some(&draw.label), layout: &pipeline.bind_group_layout, entries: &entries };
        let bind_group = self.device.create_bind_group(&descriptor);
        Ok(PreparedDraw { draw, pipeline, bind_group, offsets })
    }

    /// Encodes a pass: its draws, and the resolve of its samples.
    fn encode(&self, encoder: &mut CommandEncoder, resources: &FrameResources, pass: &Pass, draws: &[PreparedDraw<'_>], pass_index: usize) {
        let target = &resources.targets[pass_index];
        let [r, g, b, a] = pass.clear.map(f64::from);
        let (view, resolve_target, store) = match (&target.multisampled, &target.resolve) {
            // The driver resolves the samples at the end of the pass.
            (Some(multisampled), None) => (multisampled, Some(&target.view), StoreOp::Discard),
            // A shader reads the samples after the pass.
            (Some(multisampled), Some(_)) => (multisampled, None, StoreOp::Store),
            (None, _) => (&target.view, None, StoreOp::Store),
        };
        let colour = RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: Operations { load: LoadOp::Clear(Color { r, g, b, a }), store },
        };
        let depth_stencil_attachment = target.depth.as_ref().map(|view| RenderPassDepthStencilAttachment {
            view,
            // Reversed depth: 0 is infinitely far.
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        });
        let pass_timer = resources.pass_timer.as_ref().filter(|_| (pass_index as u32) < MAX_TIMED_PASSES);
        let (begin_query, end_query) = (2 * pass_index as u32, 2 * pass_index as u32 + 1);
        let timestamp_writes = |begin: Option<u32>, end: Option<u32>| {
            pass_timer.map(|timer| RenderPassTimestampWrites {
                query_set: &timer.queries,
                beginning_of_pass_write_index: begin,
                end_of_pass_write_index: end,
            })
        };
        let mut render_pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some(pass.name),
            color_attachments: &[Some(colour)],
            depth_stencil_attachment,
            // If a shader resolves the samples, the time of the pass ends with that resolve.
            timestamp_writes: timestamp_writes(Some(begin_query), target.resolve.is_none().then_some(end_query)),
            occlusion_query_set: None,
            multiview_mask: None,
        });
        for prepared in draws {
            let [x0, y0, x1, y1] = prepared.draw.scissor;
            let (x1, y1) = (x1.min(pass.width), y1.min(pass.height));
            if x0 >= x1 || y0 >= y1 {
                continue;
            }
            render_pass.set_pipeline(&prepared.pipeline.pipeline);
            render_pass.set_bind_group(0, &prepared.bind_group, prepared.offsets.uniforms.as_slice());
            render_pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0);
            if let Some(buffer) = &resources.buffers.attributes {
                for (slot, range) in (0..).zip(&prepared.offsets.attributes) {
                    render_pass.set_vertex_buffer(slot, buffer.slice(range.clone()));
                }
            }
            match (&prepared.draw.vertices, prepared.offsets.indices, &resources.buffers.indices) {
                (Vertices::Count(n), ..) => render_pass.draw(0..*n, 0..prepared.draw.instances.count),
                (Vertices::Mesh { indices, .. }, Some(offset), Some(buffer)) => {
                    render_pass.set_index_buffer(buffer.slice(offset..offset + 4 * indices.len() as u64), IndexFormat::Uint32);
                    render_pass.draw_indexed(0..indices.len() as u32, 0, 0..prepared.draw.instances.count);
                }
                // Does not occur: a mesh without indices is skipped (`draws_pixels`), and the frame's buffers contain the indices of all others.
                _ => {}
            }
        }
        // On GL the scissor rectangle of the last draw would also clip the resolve at the end of the pass.
        render_pass.set_scissor_rect(0, 0, pass.width, pass.height);
        drop(render_pass);
        if let Some(resolve) = &target.resolve {
            resolve.encode(encoder, &target.view, timestamp_writes(None, Some(end_query)));
        }
    }
}
