//! One pass: geometry of every draw, bins, tiles over all cores.
//!
//! Bins hold, per tile, the triangles in the order of the draws, so a tile's picture does not depend on which thread draws it or when:
//! the same bits come from one thread and from many. Tiles write disjoint parts of the target.

use super::RenderError;
use super::math::Real;
use super::raster::coverage::{TILE, TilePixels};
use super::shade::{Batch, DrawJob, FragmentPlan, TileShader};
use super::stage::{LaneProgram, LaneRun};
use super::tiles::{TileTarget, unorm8};
use super::timings::PassTimings;
use super::vertex::{Assembled, assemble};
use crate::render::plan::{ColourFormat, Pass, PlanDraw};
use crate::shader::ModuleId;
use parking_lot::Mutex;
use rayon::prelude::*;
use std::mem::MaybeUninit;
use std::time::Instant;

/// The stages of one draw, bound to its uniforms and textures.
pub struct DrawStages<'a, R: Real> {
    pub vertex: &'a dyn LaneProgram<R>,
    pub fragment: &'a dyn LaneProgram<R>,
}

/// The resolved colour of a pass, rows top first.
#[derive(Clone, Debug, PartialEq)]
pub enum PassImage {
    Float(Vec<[f32; 4]>),
    Unorm(Vec<[u8; 4]>),
}

/// A thread's buffers, handed from tile to tile.
struct Worker<'a, R: Real> {
    target: TileTarget,
    batch: Batch,
    /// By draw; started when first needed.
    runs: Vec<Option<Box<dyn LaneRun<R> + Send + 'a>>>,
    shading_seconds: f64,
    resolve_seconds: f64,
}

/// The triangles of every tile, in draw order, one tile after the other.
struct Bins {
    across: usize,
    /// Where each tile's entries begin, and the end of the last.
    starts: Vec<usize>,
    /// (draw, triangle).
    entries: Vec<(u32, u32)>,
}

impl Bins {
    fn new<R: Real>(width: u32, height: u32, jobs: &[DrawJob<'_, R>]) -> Result<Self, RenderError> {
        let (across, down) = (width.div_ceil(TILE) as usize, height.div_ceil(TILE) as usize);
        let each = |visit: &mut dyn FnMut(usize, (u32, u32))| {
            for (d, job) in jobs.iter().enumerate() {
                for (t, triangle) in job.geometry.triangles.iter().enumerate() {
                    let [x0, y0, x1, y1] = triangle.pixels;
                    for ty in y0 / TILE..y1.div_ceil(TILE) {
                        for tx in x0 / TILE..x1.div_ceil(TILE) {
                            visit(ty as usize * across + tx as usize, (d as u32, t as u32));
                        }
                    }
                }
            }
        };
        // Counted first, so that memory is asked for once and a refusal is an error.
        let mut starts = super::try_vec(across * down + 1, 0_usize, "the tiles")?;
        each(&mut |tile, _| starts[tile + 1] += 1);
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut entries = super::try_vec(starts[across * down], (0, 0), "the tiles' triangles")?;
        let mut next = starts.clone();
        each(&mut |tile, entry| {
            entries[next[tile]] = entry;
            next[tile] += 1;
        });
        Ok(Self { across, starts, entries })
    }

    fn tile(&self, x: usize, y: usize) -> &[(u32, u32)] {
        let k = y * self.across + x;
        &self.entries[self.starts[k]..self.starts[k + 1]]
    }
}

/// Executes a pass whose draws' stages are given in order. Must be called inside the thread pool that shall do the work.
pub fn execute<R: Real>(pass: &Pass, stages: &[DrawStages<'_, R>]) -> Result<(PassImage, PassTimings), RenderError> {
    let whole = Instant::now();
    check(pass)?;
    let mut timings = PassTimings { name: pass.name.to_owned(), ..PassTimings::default() };
    let mut jobs = Vec::with_capacity(pass.draws.len());
    for (draw, stages) in pass.draws.iter().zip(stages) {
        jobs.push(prepare(pass, draw, stages, &mut timings)?);
    }
    let start = Instant::now();
    let bins = Bins::new(pass.width, pass.height, &jobs)?;
    timings.binning_ms = 1e3 * start.elapsed().as_secs_f64();

    let image = match pass.format {
        ColourFormat::Rgba32Float | ColourFormat::Rgba32FloatDim => {
            PassImage::Float(draw_tiles(pass, &jobs, &bins, "a pass of f32 colour", |c| c, &mut timings)?)
        }
        ColourFormat::Rgba8Unorm => PassImage::Unorm(draw_tiles(pass, &jobs, &bins, "a pass of display bytes", unorm8, &mut timings)?),
    };
    timings.wall_ms = 1e3 * whole.elapsed().as_secs_f64();
    Ok((image, timings))
}

fn check(pass: &Pass) -> Result<(), RenderError> {
    let most = super::MAX_SIZE;
    if pass.width == 0 || pass.height == 0 || pass.width > most || pass.height > most {
        return Err(RenderError::Size { pass: pass.name.to_owned(), width: pass.width, height: pass.height });
    }
    if pass.samples != 1 && pass.samples != 4 {
        return Err(RenderError::Samples { pass: pass.name.to_owned(), samples: pass.samples });
    }
    Ok(())
}

/// Where a module's picture is its own cost: the instructions that a texture read is shown as.
fn instructions_per_read(module: &ModuleId) -> Option<f64> {
    if let ModuleId::Planet(key) = module { key.instructions_per_read() } else { None }
}

fn prepare<'a, R: Real>(
    pass: &Pass,
    draw: &PlanDraw,
    stages: &DrawStages<'a, R>,
    timings: &mut PassTimings,
) -> Result<DrawJob<'a, R>, RenderError> {
    let fragment = stages.fragment;
    let Assembled { geometry, given, vertex_seconds, setup_seconds } =
        assemble(draw, stages.vertex, fragment.inputs(), pass.width, pass.height)?;
    timings.vertex_ms += 1e3 * vertex_seconds;
    timings.setup_ms += 1e3 * setup_seconds;
    timings.given += given;
    // Each one that is seen has its surface.
    timings.culled += given - geometry.surfaces.len();
    timings.clipped += geometry.clipped;
    timings.triangles += geometry.triangles.len();
    let fragment_plan = FragmentPlan::new(fragment.inputs(), fragment.outputs(), fragment.uses_discard(), draw.depth, pass.depth);
    Ok(DrawJob { geometry, fragment, fragment_plan, blend: draw.blend, instructions_per_read: instructions_per_read(&draw.module) })
}

/// The picture, each pixel written once, by the thread that draws its tile: to touch 16 MB for the first time is a cost of its own.
fn draw_tiles<R: Real, T: Copy + Send + Sync>(
    pass: &Pass,
    jobs: &[DrawJob<'_, R>],
    bins: &Bins,
    what: &'static str,
    convert: impl Fn([f32; 4]) -> T + Sync,
    timings: &mut PassTimings,
) -> Result<Vec<T>, RenderError> {
    let count = pass.width as usize * pass.height as usize;
    let mut image = Vec::new();
    super::try_grow(&mut image, count, what)?;
    let pixels = TilePixels::new();
    let blank = convert(pass.clear);
    let idle: Mutex<Vec<Worker<'_, R>>> = Mutex::new(Vec::new());
    let tile = TILE as usize;
    image.spare_capacity_mut()[..count].par_chunks_mut(tile * pass.width as usize).enumerate().for_each(|(ty, band)| {
        let wanted = |tx: usize| !bins.tile(tx, ty).is_empty();
        let mut tiles: Vec<Vec<&mut [MaybeUninit<T>]>> =
            (0..bins.across).map(|tx| Vec::with_capacity(if wanted(tx) { tile } else { 0 })).collect();
        for row in band.chunks_mut(pass.width as usize) {
            for (tx, part) in row.chunks_mut(tile).enumerate() {
                if wanted(tx) {
                    tiles[tx].push(part);
                } else {
                    part.fill(MaybeUninit::new(blank));
                }
            }
        }
        tiles.par_iter_mut().enumerate().filter(|(tx, _)| wanted(*tx)).for_each(|(tx, rows)| {
            let bin = bins.tile(tx, ty);
            let free = idle.lock().pop();
            let mut worker = free.unwrap_or_else(|| Worker::new(pass.samples, jobs.len()));
            worker.draw_tile(pass, jobs, bin, [tx as u32 * TILE, ty as u32 * TILE], &pixels);
            let start = Instant::now();
            worker.target.resolve_to(rows, &convert);
            worker.resolve_seconds += start.elapsed().as_secs_f64();
            idle.lock().push(worker);
        });
    });
    // SAFETY: the rows of all tiles are all of the picture; a tile with a bin has written each pixel of its rows, any other was filled.
    unsafe { image.set_len(count) };
    for worker in idle.into_inner() {
        timings.shading_thread_ms += 1e3 * worker.shading_seconds;
        timings.resolve_thread_ms += 1e3 * worker.resolve_seconds;
    }
    Ok(image)
}

impl<'a, R: Real> Worker<'a, R> {
    fn new(samples: u8, draws: usize) -> Self {
        Self {
            target: TileTarget::new(samples),
            batch: Batch::new(),
            runs: (0..draws).map(|_| None).collect(),
            shading_seconds: 0.0,
            resolve_seconds: 0.0,
        }
    }

    fn draw_tile(&mut self, pass: &Pass, jobs: &[DrawJob<'a, R>], bin: &[(u32, u32)], tile: [u32; 2], pixels: &TilePixels) {
        let start = Instant::now();
        let depth = bin.iter().any(|(d, _)| jobs[*d as usize].fragment_plan.uses_depth());
        self.target.clear(pass.clear, depth);
        let mut shader = TileShader { target: &mut self.target, pixels, tile, samples: pass.samples };
        for of_draw in bin.chunk_by(|a, b| a.0 == b.0) {
            let d = of_draw[0].0 as usize;
            let job = &jobs[d];
            let run = self.runs[d].get_or_insert_with(|| job.fragment.start());
            let triangles: Vec<u32> = of_draw.iter().map(|(_, t)| *t).collect();
            shader.draw(job, &triangles, run.as_mut(), &mut self.batch);
        }
        self.shading_seconds += start.elapsed().as_secs_f64();
    }
}
