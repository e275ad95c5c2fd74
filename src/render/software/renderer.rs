//! Executes a plan on the CPU.
//!
//! In: a plan and its modules. Out: a frame and its timings. Always: passes run in order, and a pass may read the output of an earlier pass; the
//! image does not depend on the number of threads. The stored bytes of a module's tapes (compiled instructions) are decoded once, to a `Program` for each of
//! its two entry points, and cached. The renderer has its own thread pool.

use super::RenderError;
use super::exec::KernelBinding;
use super::kernels::KernelClass;
use super::lower::programs_from_bytes;
use super::math::Real;
use super::pass::{DrawStages, PassImage, execute, execute_fused};
use super::pass_fusion::can_fuse_with_next_pass;
use super::program::{Program, ShaderStage};
use super::raster::setup::VertexGrid;
use super::sample::texels::Texels;
use super::sample::{BoundTexture, Textures};
use super::tape_stage::TapeStage;
use super::texel_marks::TexelMarks;
use super::timings::{PassTimings, Timings};
use super::tone_map::ToneMapOffsets;
use crate::image::TexelFormat;
use crate::memo::LruMap;
use crate::render::frame::Frame;
use crate::render::plan::{FrameImages, ModuleProvider, Pass, Plan, PlanDraw, TextureSource};
use crate::shader::ModuleId;
use crate::shader::library::MODULES_KEPT;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

/// Floating-point type of the lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    #[default]
    F32,
    /// The reference for checks of accuracy: the same tape in f64, three to seven times slower.
    F64,
}

/// Settings of a renderer. They change the image only by the rounding of values and of vertex positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of threads; 0: one per logical CPU.
    pub threads: usize,
    pub kernel_class: KernelClass,
    pub precision: Precision,
    pub vertex_grid: VertexGrid,
}

impl Default for Options {
    fn default() -> Self {
        Self { threads: 0, kernel_class: KernelClass::in_use(), precision: Precision::F32, vertex_grid: VertexGrid::default() }
    }
}

/// One entry point of a module: its program, and the program's binding to kernels.
#[derive(Debug)]
pub(super) struct EntryPoint {
    pub program: Program,
    kernel_binding: KernelBinding,
}

impl From<Program> for EntryPoint {
    fn from(program: Program) -> Self {
        Self { program, kernel_binding: KernelBinding::default() }
    }
}

/// The entry points of one module.
#[derive(Debug)]
pub(super) struct EntryPoints {
    pub vertex: EntryPoint,
    pub fragment: EntryPoint,
    /// Where the uniforms of the shipped tone map lie; if set, a native function replaces the fragment stage's tape. `None` for any other module, and for an
    /// edited tone map.
    pub tone_map: Option<ToneMapOffsets>,
}

/// The cache of decoded programs.
#[derive(Debug)]
struct DecodedModules {
    by_id: LruMap<ModuleId, Arc<EntryPoints>>,
    /// Number of calls of [`SoftwareRenderer::forget_modules`]. A module that was fetched before the latest call may have the old source and is not cached.
    times_forgotten: u64,
}

/// Executes plans on the CPU.
#[derive(Debug)]
pub struct SoftwareRenderer {
    pool: rayon::ThreadPool,
    options: Options,
    decoded: Mutex<DecodedModules>,
}

/// The vertex and the fragment stage of a draw, bound to its uniforms and textures.
pub(super) struct BoundStages<'a, R: Real> {
    pub vertex: TapeStage<'a, R>,
    pub fragment: TapeStage<'a, R>,
}

impl SoftwareRenderer {
    /// # Errors
    /// Kernels that this machine lacks, or no threads.
    pub fn new(options: Options) -> Result<Self, RenderError> {
        if !KernelClass::available().contains(&options.kernel_class) {
            return Err(RenderError::Kernels(options.kernel_class.name().to_owned()));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .thread_name(|k| format!("draw-{k}"))
            .build()
            .map_err(|e| RenderError::Threads(e.to_string()))?;
        let decoded = DecodedModules { by_id: LruMap::with_capacity(MODULES_KEPT), times_forgotten: 0 };
        Ok(Self { pool, options, decoded: Mutex::new(decoded) })
    }

    /// Runs `work` inside the renderer's thread pool.
    pub(super) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Drops the cached programs, and those that other threads are decoding. The caller must do this after a module's source has changed under the same
    /// name.
    pub fn forget_modules(&self) {
        let mut decoded = self.decoded.lock();
        decoded.by_id.clear();
        decoded.times_forgotten += 1;
    }

    pub(crate) fn options(&self) -> &Options {
        &self.options
    }

    /// Number of threads that draw.
    pub(crate) fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Executes the plan.
    ///
    /// # Errors
    /// A binding, attribute or varying that is missing or does not fit, or a loop that does not end, with its draw or pass; insufficient memory.
    pub fn render(&self, plan: &Plan, modules: &impl ModuleProvider, requested: FrameImages) -> Result<(Frame, Timings), RenderError> {
        match self.options.precision {
            Precision::F32 => self.pool.install(|| self.render_as::<f32>(plan, modules, requested)),
            Precision::F64 => self.pool.install(|| self.render_as::<f64>(plan, modules, requested)),
        }
    }

    /// As [`SoftwareRenderer::render`], with lanes of type `R`.
    fn render_as<R: Real>(
        &self,
        plan: &Plan,
        modules: &impl ModuleProvider,
        requested: FrameImages,
    ) -> Result<(Frame, Timings), RenderError> {
        let start = Instant::now();
        let mut timings = Timings::default();
        // The image of each pass with its width and height.
        let mut images: Vec<(PassImage, u32, u32)> = Vec::new();
        let mut pass_index = 0;
        while let Some(pass) = plan.passes.get(pass_index) {
            if requested == FrameImages::Display
                && can_fuse_with_next_pass(plan, pass_index)
                && let Some((image, pass_timings, prepare_ms)) =
                    self.execute_fused_passes::<R>([pass, &plan.passes[pass_index + 1]], modules, &images)?
            {
                timings.prepare_ms += prepare_ms;
                timings.passes.extend(pass_timings);
                // A placeholder for the HDR image, which was never stored and which no other pass reads.
                images.push((PassImage::Float(Vec::new()), pass.width, pass.height));
                images.push((image, pass.width, pass.height));
                pass_index += 2;
                continue;
            }
            let (image, pass_timings, prepare_ms) = self.execute_pass::<R>(pass, modules, &images)?;
            timings.prepare_ms += prepare_ms;
            timings.passes.push(pass_timings);
            images.push((image, pass.width, pass.height));
            pass_index += 1;
        }
        let (last, width, height) = images.pop().ok_or(RenderError::NoPass)?;
        let mut frame = Frame { width, height, hdr: Vec::new(), display: Vec::new() };
        match last {
            PassImage::Unorm(bytes) => {
                frame.display = bytes;
                if requested == FrameImages::DisplayAndHdr {
                    // The HDR image is found by its index and not by its size, because other HDR images, such as the air samples, may have the same size. It is
                    // left out if its size differs from the display image's, as it may for a warped image or a stereo pair.
                    if let Some((PassImage::Float(hdr), w, h)) = plan.hdr_pass_index().and_then(|k| images.into_iter().nth(k))
                        && (w, h) == (width, height)
                    {
                        frame.hdr = hdr;
                    }
                }
            }
            PassImage::Float(hdr) => frame.hdr = hdr,
        }
        timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
        Ok((frame, timings))
    }

    /// Executes one pass; returns its image and timings, and the milliseconds that it took to bind its draws. `earlier`: the images of earlier passes
    /// with their widths and heights.
    fn execute_pass<R: Real>(
        &self,
        pass: &Pass,
        modules: &impl ModuleProvider,
        earlier: &[(PassImage, u32, u32)],
    ) -> Result<(PassImage, PassTimings, f64), RenderError> {
        let start = Instant::now();
        let entry_points = self.entry_points_of_pass(pass, modules)?;
        let bound = self.bind_all::<R>(pass, &entry_points, &outputs_of(earlier))?;
        let prepare_ms = 1e3 * start.elapsed().as_secs_f64();
        let (image, timings) = execute(pass, &self.stages_of(&bound))?;
        check_loop_limits(pass, &bound)?;
        Ok((image, timings, prepare_ms))
    }

    /// Executes two passes as one, with results as in `execute_pass`; `None` if [`execute_fused`] finds that they cannot be fused, which the plan alone does
    /// not show.
    fn execute_fused_passes<R: Real>(
        &self,
        [first, second]: [&Pass; 2],
        modules: &impl ModuleProvider,
        earlier: &[(PassImage, u32, u32)],
    ) -> Result<Option<(PassImage, [PassTimings; 2], f64)>, RenderError> {
        let start = Instant::now();
        let entry_points = [self.entry_points_of_pass(first, modules)?, self.entry_points_of_pass(second, modules)?];
        let mut pass_outputs = outputs_of(earlier);
        let first_bound = self.bind_all::<R>(first, &entry_points[0], &pass_outputs)?;
        pass_outputs.push(texels_of(&PLACEHOLDER, 1, 1));
        let second_bound = self.bind_all::<R>(second, &entry_points[1], &pass_outputs)?;
        let prepare_ms = 1e3 * start.elapsed().as_secs_f64();
        let fused = execute_fused(first, &self.stages_of(&first_bound), second, &self.stages_of(&second_bound))?;
        check_loop_limits(first, &first_bound)?;
        check_loop_limits(second, &second_bound)?;
        Ok(fused.map(|(image, timings)| (image, timings, prepare_ms)))
    }

    fn entry_points_of_pass(&self, pass: &Pass, modules: &impl ModuleProvider) -> Result<Vec<Arc<EntryPoints>>, RenderError> {
        pass.draws.iter().map(|d| self.entry_points(d, modules)).collect()
    }

    /// The stages of a pass's draws, bound to their uniforms and textures.
    fn bind_all<'a, R: Real>(
        &self,
        pass: &'a Pass,
        entry_points: &'a [Arc<EntryPoints>],
        pass_outputs: &[Result<Arc<Texels<'a>>, String>],
    ) -> Result<Vec<BoundStages<'a, R>>, RenderError> {
        pass.draws.iter().zip(entry_points).map(|(draw, entry_points)| self.bind::<R>(draw, entry_points, pass_outputs)).collect()
    }

    /// The entry points of the draw's module, from the cache if they are there.
    fn entry_points(&self, draw: &PlanDraw, modules: &impl ModuleProvider) -> Result<Arc<EntryPoints>, RenderError> {
        let times_forgotten = {
            let mut decoded = self.decoded.lock();
            if let Some(known) = decoded.by_id.get(&draw.module) {
                return Ok(known);
            }
            decoded.times_forgotten
        };
        let module_error = |what: String| RenderError::Module { draw: draw.label.clone(), what };
        let module = modules.module(&draw.module).map_err(|e| module_error(e.to_string()))?;
        let programs = programs_from_bytes(&module.tape).map_err(|e| module_error(format!("its stored programs cannot be read: {e}")))?;
        let (mut vertex, mut fragment) = (None, None);
        for program in programs {
            match program.stage {
                ShaderStage::Vertex => vertex = Some(program),
                ShaderStage::Fragment => fragment = Some(program),
            }
        }
        let (Some(vertex), Some(fragment)) = (vertex, fragment) else {
            return Err(module_error(format!("module {} lacks a vertex or a fragment stage", draw.module)));
        };
        let entry_points =
            Arc::new(EntryPoints { vertex: vertex.into(), fragment: fragment.into(), tone_map: ToneMapOffsets::of(&module) });
        let mut decoded = self.decoded.lock();
        if decoded.times_forgotten == times_forgotten {
            decoded.by_id.insert(draw.module.clone(), Arc::clone(&entry_points));
        }
        drop(decoded);
        Ok(entry_points)
    }

    fn stages_of<'a, R: Real>(&self, bound: &'a [BoundStages<'_, R>]) -> Vec<DrawStages<'a, R>> {
        let vertex_grid = self.options.vertex_grid;
        bound.iter().map(|b| DrawStages { vertex: &b.vertex as _, vertex_grid, fragment: &b.fragment as _ }).collect()
    }

    /// Both stages of a draw, bound to its uniforms and textures. `pass_outputs`: the images of earlier passes, as [`outputs_of`] returns them.
    pub(super) fn bind<'a, R: Real>(
        &self,
        draw: &'a PlanDraw,
        entry_points: &'a EntryPoints,
        pass_outputs: &[Result<Arc<Texels<'a>>, String>],
    ) -> Result<BoundStages<'a, R>, RenderError> {
        let mut images_by_binding = HashMap::new();
        let class = self.options.kernel_class;
        let mut stage = |EntryPoint { program, kernel_binding }: &'a EntryPoint| {
            let textures = textures_of(draw, program, pass_outputs, &mut images_by_binding, class)?;
            let bound_program =
                kernel_binding.get(program, class).map_err(|what| RenderError::Module { draw: draw.label.clone(), what })?;
            Ok(TapeStage::new(program, bound_program, &draw.uniform_bytes, Box::new(textures), class))
        };
        let tone_map = entry_points.tone_map.and_then(|offsets| offsets.bind(&draw.uniform_bytes));
        let fragment = stage(&entry_points.fragment)?.with_tone_map(tone_map).with_marks(marks_of(draw, pass_outputs));
        Ok(BoundStages { vertex: stage(&entry_points.vertex)?, fragment })
    }
}

/// Bound in place of the output of the first of two fused passes, which the second reads tile by tile ([`TileTexture`](super::pass_fusion::TileTexture)).
static PLACEHOLDER: LazyLock<PassImage> = LazyLock::new(|| PassImage::Unorm(vec![[0; 4]]));

/// The images of earlier passes as textures, or why one cannot be read.
fn outputs_of(earlier: &[(PassImage, u32, u32)]) -> Vec<Result<Arc<Texels<'_>>, String>> {
    earlier.iter().map(|(image, w, h)| texels_of(image, *w, *h)).collect()
}

/// Checks that no stage of a pass was stopped.
///
/// # Errors
/// A stage that was stopped at a loop limit: the image is incomplete.
pub(super) fn check_loop_limits<R: Real>(pass: &Pass, bound: &[BoundStages<'_, R>]) -> Result<(), RenderError> {
    for (draw, bound) in pass.draws.iter().zip(bound) {
        for (stage, was_stopped) in [("vertex", bound.vertex.hit_loop_limit()), ("fragment", bound.fragment.hit_loop_limit())] {
            if was_stopped {
                return Err(RenderError::LoopLimit { draw: draw.label.clone(), stage });
            }
        }
    }
    Ok(())
}

/// The image of a pass as a texture.
fn texels_of(image: &PassImage, width: u32, height: u32) -> Result<Arc<Texels<'_>>, String> {
    let (format, bytes): (_, &[u8]) = match image {
        PassImage::Float(pixels) => (TexelFormat::Rgba32Float, bytemuck::cast_slice(pixels)),
        PassImage::Unorm(pixels) => (TexelFormat::Rgba8Unorm, bytemuck::cast_slice(pixels)),
    };
    Texels::new(format, std::iter::once((width, height, bytes))).map(Arc::new)
}

/// The marks by which a draw discards pixels (see [`MarkedImage`](crate::render::plan::MarkedImage)); `None` if it has none, or if they cannot be read in
/// advance.
/// `pass_outputs`: images of earlier passes.
fn marks_of(draw: &PlanDraw, pass_outputs: &[Result<Arc<Texels<'_>>, String>]) -> Option<TexelMarks> {
    let marked = draw.extent?.marked?;
    match &draw.textures.iter().find(|t| t.binding == marked.binding)?.source {
        TextureSource::PassOutput(pass) => TexelMarks::new(marked, pass_outputs.get(*pass)?.as_ref().ok()?),
        _ => None,
    }
}

/// The textures that a program reads, each with its sampler. `images_by_binding`: the draw's images that have been prepared, which its two stages share.
fn textures_of<'a>(
    draw: &'a PlanDraw,
    program: &Program,
    pass_outputs: &[Result<Arc<Texels<'a>>, String>],
    images_by_binding: &mut HashMap<u32, Arc<Texels<'a>>>,
    class: KernelClass,
) -> Result<Textures<'a>, RenderError> {
    let missing = |binding| RenderError::Binding { draw: draw.label.clone(), binding };
    let mut bound = Vec::new();
    for texture_use in &program.textures {
        let binding = texture_use.texture_binding;
        let invalid = |what: &String| RenderError::Texture { draw: draw.label.clone(), binding, what: what.clone() };
        let source = &draw.textures.iter().find(|t| t.binding == binding).ok_or_else(|| missing(binding))?.source;
        let texels = match source {
            TextureSource::PassOutput(pass) => {
                let output =
                    pass_outputs.get(*pass).ok_or_else(|| RenderError::PassOrder { draw: draw.label.clone(), binding, pass: *pass })?;
                Arc::clone(output.as_ref().map_err(invalid)?)
            }
            TextureSource::OnGpu(_) => return Err(invalid(&"it is in GPU memory only".to_owned())),
            TextureSource::Image(texture) | TextureSource::Persistent(texture) => match images_by_binding.get(&binding) {
                Some(known) => Arc::clone(known),
                None => {
                    let texels = Arc::new(Texels::of_texture(texture).map_err(|what| invalid(&what))?);
                    images_by_binding.insert(binding, Arc::clone(&texels));
                    texels
                }
            },
        };
        let sampler = match texture_use.sampler_binding {
            Some(binding) => Some(draw.samplers.iter().find(|s| s.binding == binding).ok_or_else(|| missing(binding))?.state),
            None => None,
        };
        bound.push(BoundTexture { texels, sampler });
    }
    Ok(Textures::new(bound, class))
}
