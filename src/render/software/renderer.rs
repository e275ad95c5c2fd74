//! The renderer itself: a plan and its modules in, a frame and its timings out.
//!
//! Passes run in order; a later one may read what an earlier one wrote. Programs are read from a module's tape once and kept. The renderer
//! has its own thread pool, and its pictures do not depend on the number of threads.

use super::RenderError;
use super::kernels::KernelClass;
use super::lower::programs_from_bytes;
use super::math::Real;
use super::own_pixel::next_reads_own_pixels;
use super::pass::{DrawStages, PassImage, execute, execute_pair};
use super::program::{Program, Stage};
use super::sample::texels::Texels;
use super::sample::{BoundTexture, Textures};
use super::stage::TapeStage;
use super::timings::{PassTimings, Timings};
use crate::image::TexelFormat;
use crate::render::frame::Frame;
use crate::render::plan::{ModuleProvider, Pass, Plan, PlanDraw, TextureSource};
use crate::shader::ModuleId;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

/// What the lanes compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    #[default]
    F32,
    /// The reference: the same tape in f64, some three to seven times slower.
    F64,
}

/// How a renderer works; none of it changes what is drawn beyond rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// 0: as many as the machine has.
    pub threads: usize,
    pub kernels: KernelClass,
    pub precision: Precision,
}

impl Default for Options {
    fn default() -> Self {
        Self { threads: 0, kernels: KernelClass::detect(), precision: Precision::F32 }
    }
}

/// The entry points of one module.
#[derive(Debug)]
pub(super) struct Entries {
    pub vertex: Program,
    pub fragment: Program,
}

/// Executes plans on the CPU.
#[derive(Debug)]
pub struct SoftwareRenderer {
    pool: rayon::ThreadPool,
    options: Options,
    entries: Mutex<HashMap<ModuleId, Arc<Entries>>>,
}

/// Both stages of a draw.
pub(super) struct Bindings<'a, R: Real> {
    pub vertex: TapeStage<'a, R>,
    pub fragment: TapeStage<'a, R>,
}

impl SoftwareRenderer {
    /// # Errors
    /// Kernels that this machine lacks, or no threads.
    pub fn new(options: Options) -> Result<Self, RenderError> {
        if !KernelClass::available().contains(&options.kernels) {
            return Err(RenderError::Kernels(options.kernels.name().to_owned()));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .thread_name(|k| format!("draw-{k}"))
            .build()
            .map_err(|e| RenderError::Threads(e.to_string()))?;
        Ok(Self { pool, options, entries: Mutex::default() })
    }

    /// Runs work inside the renderer's threads.
    pub(super) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Forgets the programs it keeps: modules of the same names are no longer the same.
    pub fn forget_modules(&self) {
        self.entries.lock().clear();
    }

    pub fn options(&self) -> &Options {
        &self.options
    }

    /// How many threads draw.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Executes the plan. `keep_hdr`: the frame keeps the linear picture too.
    ///
    /// # Errors
    /// What is missing or does not fit, by draw or pass; memory that is not there.
    pub fn render(&self, plan: &Plan, modules: &impl ModuleProvider, keep_hdr: bool) -> Result<(Frame, Timings), RenderError> {
        match self.options.precision {
            Precision::F32 => self.pool.install(|| self.frame::<f32>(plan, modules, keep_hdr)),
            Precision::F64 => self.pool.install(|| self.frame::<f64>(plan, modules, keep_hdr)),
        }
    }

    fn frame<R: Real>(&self, plan: &Plan, modules: &impl ModuleProvider, keep_hdr: bool) -> Result<(Frame, Timings), RenderError> {
        let start = Instant::now();
        let mut timings = Timings::default();
        let mut images: Vec<(PassImage, u32, u32)> = Vec::new();
        let mut k = 0;
        while let Some(pass) = plan.passes.get(k) {
            if !keep_hdr
                && next_reads_own_pixels(plan, k)
                && let Some((image, of_passes, prepare_ms)) = self.pair::<R>([pass, &plan.passes[k + 1]], modules, &images)?
            {
                timings.prepare_ms += prepare_ms;
                timings.passes.extend(of_passes);
                // The light is no picture, and nothing else asks for it.
                images.push((PassImage::Float(Vec::new()), pass.width, pass.height));
                images.push((image, pass.width, pass.height));
                k += 2;
                continue;
            }
            let (image, of_pass, prepare_ms) = self.pass::<R>(pass, modules, &images)?;
            timings.prepare_ms += prepare_ms;
            timings.passes.push(of_pass);
            images.push((image, pass.width, pass.height));
            k += 1;
        }
        let (last, width, height) = images.pop().ok_or(RenderError::NoPass)?;
        let mut frame = Frame { width, height, hdr: Vec::new(), display: Vec::new() };
        match last {
            PassImage::Unorm(bytes) => {
                frame.display = bytes;
                if keep_hdr {
                    // The scene's light comes first; what is made of it may be as large.
                    let scene = images.into_iter().find_map(|(image, w, h)| match image {
                        PassImage::Float(hdr) if (w, h) == (width, height) => Some(hdr),
                        _ => None,
                    });
                    frame.hdr = scene.unwrap_or_default();
                }
            }
            PassImage::Float(hdr) => frame.hdr = hdr,
        }
        timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
        Ok((frame, timings))
    }

    fn pass<R: Real>(
        &self,
        pass: &Pass,
        modules: &impl ModuleProvider,
        earlier: &[(PassImage, u32, u32)],
    ) -> Result<(PassImage, PassTimings, f64), RenderError> {
        let start = Instant::now();
        let entries = self.entries_of(pass, modules)?;
        let bound = self.bind_all::<R>(pass, &entries, &outputs_of(earlier))?;
        let prepare_ms = 1e3 * start.elapsed().as_secs_f64();
        let (image, timings) = execute(pass, &stages_of(&bound))?;
        check_ended(pass, &bound)?;
        Ok((image, timings, prepare_ms))
    }

    /// Two passes as one, where the second can be drawn so.
    fn pair<R: Real>(
        &self,
        [light, picture]: [&Pass; 2],
        modules: &impl ModuleProvider,
        earlier: &[(PassImage, u32, u32)],
    ) -> Result<Option<(PassImage, [PassTimings; 2], f64)>, RenderError> {
        let start = Instant::now();
        let entries = [self.entries_of(light, modules)?, self.entries_of(picture, modules)?];
        let mut outputs = outputs_of(earlier);
        let light_bound = self.bind_all::<R>(light, &entries[0], &outputs)?;
        // Bound in the light's place, and never read.
        outputs.push(texels_of(&UNREAD, 1, 1));
        let picture_bound = self.bind_all::<R>(picture, &entries[1], &outputs)?;
        let prepare_ms = 1e3 * start.elapsed().as_secs_f64();
        let done = execute_pair(light, &stages_of(&light_bound), picture, &stages_of(&picture_bound))?;
        check_ended(light, &light_bound)?;
        check_ended(picture, &picture_bound)?;
        Ok(done.map(|(image, timings)| (image, timings, prepare_ms)))
    }

    fn entries_of(&self, pass: &Pass, modules: &impl ModuleProvider) -> Result<Vec<Arc<Entries>>, RenderError> {
        pass.draws.iter().map(|d| self.entries(d, modules)).collect()
    }

    /// The stages of a pass's draws, each with its uniforms and textures.
    fn bind_all<'a, R: Real>(
        &self,
        pass: &'a Pass,
        entries: &'a [Arc<Entries>],
        outputs: &[Result<Arc<Texels<'a>>, String>],
    ) -> Result<Vec<Bindings<'a, R>>, RenderError> {
        pass.draws.iter().zip(entries).map(|(draw, entries)| self.bind::<R>(draw, entries, outputs)).collect()
    }

    /// The programs of the draw's module.
    fn entries(&self, draw: &PlanDraw, modules: &impl ModuleProvider) -> Result<Arc<Entries>, RenderError> {
        if let Some(known) = self.entries.lock().get(&draw.module) {
            return Ok(Arc::clone(known));
        }
        let fault = |what: String| RenderError::Module { draw: draw.label.clone(), what };
        let module = modules.module(&draw.module).map_err(|e| fault(e.to_string()))?;
        let programs = programs_from_bytes(&module.tape).map_err(|e| fault(format!("its tape cannot be read: {e}")))?;
        let (mut vertex, mut fragment) = (None, None);
        for program in programs {
            match program.stage {
                Stage::Vertex => vertex = Some(program),
                Stage::Fragment => fragment = Some(program),
            }
        }
        let (Some(vertex), Some(fragment)) = (vertex, fragment) else {
            return Err(fault(format!("module {} lacks a vertex or a fragment stage", draw.module)));
        };
        let entries = Arc::new(Entries { vertex, fragment });
        self.entries.lock().insert(draw.module.clone(), Arc::clone(&entries));
        Ok(entries)
    }

    pub(super) fn bind<'a, R: Real>(
        &self,
        draw: &'a PlanDraw,
        entries: &'a Entries,
        outputs: &[Result<Arc<Texels<'a>>, String>],
    ) -> Result<Bindings<'a, R>, RenderError> {
        let mut images = HashMap::new();
        let mut stage = |program: &'a Program| {
            let textures = textures_of(draw, program, outputs, &mut images, self.options.kernels)?;
            TapeStage::new(program, &draw.uniform_bytes, Box::new(textures), self.options.kernels)
                .map_err(|what| RenderError::Module { draw: draw.label.clone(), what })
        };
        Ok(Bindings { vertex: stage(&entries.vertex)?, fragment: stage(&entries.fragment)? })
    }
}

/// Stands in a binding for light that is read in its tile.
static UNREAD: LazyLock<PassImage> = LazyLock::new(|| PassImage::Unorm(vec![[0; 4]]));

fn outputs_of(earlier: &[(PassImage, u32, u32)]) -> Vec<Result<Arc<Texels<'_>>, String>> {
    earlier.iter().map(|(image, w, h)| texels_of(image, *w, *h)).collect()
}

fn stages_of<'a, R: Real>(bound: &'a [Bindings<'_, R>]) -> Vec<DrawStages<'a, R>> {
    bound.iter().map(|b| DrawStages { vertex: &b.vertex as _, fragment: &b.fragment as _ }).collect()
}

/// # Errors
/// A stage that was stopped in a loop: what was drawn is no picture.
fn check_ended<R: Real>(pass: &Pass, bound: &[Bindings<'_, R>]) -> Result<(), RenderError> {
    for (draw, bound) in pass.draws.iter().zip(bound) {
        for (stage, gave_up) in [("vertex", bound.vertex.gave_up()), ("fragment", bound.fragment.gave_up())] {
            if gave_up {
                return Err(RenderError::Endless { draw: draw.label.clone(), stage });
            }
        }
    }
    Ok(())
}

fn texels_of(image: &PassImage, width: u32, height: u32) -> Result<Arc<Texels<'_>>, String> {
    let (format, bytes): (_, &[u8]) = match image {
        PassImage::Float(pixels) => (TexelFormat::Rgba32Float, bytemuck::cast_slice(pixels)),
        PassImage::Unorm(pixels) => (TexelFormat::Rgba8Unorm, bytemuck::cast_slice(pixels)),
    };
    Texels::new(format, std::iter::once((width, height, bytes))).map(Arc::new)
}

/// The program's texture uses, each bound to what the draw brings.
fn textures_of<'a>(
    draw: &'a PlanDraw,
    program: &Program,
    outputs: &[Result<Arc<Texels<'a>>, String>],
    images: &mut HashMap<u32, Arc<Texels<'a>>>,
    class: KernelClass,
) -> Result<Textures<'a>, RenderError> {
    let missing = |binding| RenderError::Binding { draw: draw.label.clone(), binding };
    let mut bound = Vec::new();
    for of_program in &program.textures {
        let binding = of_program.texture_binding;
        let broken = |what: &String| RenderError::Texture { draw: draw.label.clone(), binding, what: what.clone() };
        let source = &draw.textures.iter().find(|t| t.binding == binding).ok_or_else(|| missing(binding))?.source;
        let texels = match source {
            TextureSource::PassOutput(pass) => {
                let output = outputs.get(*pass).ok_or_else(|| RenderError::PassOrder { draw: draw.label.clone(), binding, pass: *pass })?;
                Arc::clone(output.as_ref().map_err(broken)?)
            }
            TextureSource::OnGpu(_) => return Err(broken(&"it is on a device".to_owned())),
            TextureSource::Image(texture) | TextureSource::Persistent(texture) => match images.get(&binding) {
                Some(known) => Arc::clone(known),
                None => {
                    let texels = Arc::new(Texels::of_texture(texture).map_err(|what| broken(&what))?);
                    images.insert(binding, Arc::clone(&texels));
                    texels
                }
            },
        };
        let sampler = match of_program.sampler_binding {
            Some(at) => Some(draw.samplers.iter().find(|s| s.binding == at).ok_or_else(|| missing(at))?.state),
            None => None,
        };
        bound.push(BoundTexture { texels, sampler });
    }
    Ok(Textures::new(bound, class))
}
