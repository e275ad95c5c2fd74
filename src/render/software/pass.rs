//! One pass: geometry of every draw, bins, tiles over all cores.
//!
//! Bins hold, per tile, the triangles in the order of the draws, so a tile's picture does not depend on which thread draws it or when:
//! the same bits come from one thread and from many. Tiles write disjoint parts of the target.
//!
//! Two passes can be drawn as one ([`execute_pair`]): where the second reads nothing of the first but each pixel's own (own_pixel.rs), a tile goes through
//! both before the next is begun, and the first makes no picture.

use super::RenderError;
use super::fragment_plan::FragmentPlan;
use super::math::Real;
use super::own_pixel::TileTexture;
use super::raster::coverage::{TILE, TILE_BLOCKS, TilePixels, block_place, covers_all};
use super::shade::{Batch, DrawJob, TileShader};
use super::stage::{LaneProgram, LaneRun};
use super::tiles::{TileTarget, unorm8};
use super::timings::PassTimings;
use super::vertex::{Assembled, assemble};
use crate::render::plan::{ColourFormat, Pass, PlanDraw};
use crate::shader::ModuleId;
use parking_lot::Mutex;
use rayon::prelude::*;
use std::cell::Cell;
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};
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

/// A pass whose draws are ready for its tiles.
struct PassJobs<'a, R: Real> {
    pass: &'a Pass,
    jobs: Vec<DrawJob<'a, R>>,
    bins: Bins,
}

/// A second pass: a draw that makes a picture of the first pass's pixels, and the draws over it.
struct Mapped<'a, R: Real> {
    map: DrawJob<'a, R>,
    over: PassJobs<'a, R>,
    /// What the map makes of a pixel that no draw of the first pass has touched, where that is the same everywhere.
    blank: Option<[f32; 4]>,
    /// The map has read other pixels than its own: what was drawn is no picture.
    read_elsewhere: AtomicBool,
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
    let (jobs, mut timings) = ready(pass, stages)?;
    let image = match pass.format {
        ColourFormat::Rgba32Float | ColourFormat::Rgba32FloatDim => {
            PassImage::Float(draw_tiles(&jobs, None, "a pass of f32 colour", |c| c, [&mut timings, &mut PassTimings::default()])?)
        }
        ColourFormat::Rgba8Unorm => {
            PassImage::Unorm(draw_tiles(&jobs, None, "a pass of display bytes", unorm8, [&mut timings, &mut PassTimings::default()])?)
        }
    };
    timings.wall_ms = 1e3 * whole.elapsed().as_secs_f64();
    Ok((image, timings))
}

/// Executes two passes as one; the picture is the second's. `None` where that cannot be: the second's first draw does not cover all of it, or reads other
/// pixels than its own. The first pass's wall time is that of both.
pub fn execute_pair<R: Real>(
    first: &Pass,
    first_stages: &[DrawStages<'_, R>],
    second: &Pass,
    second_stages: &[DrawStages<'_, R>],
) -> Result<Option<(PassImage, [PassTimings; 2])>, RenderError> {
    let whole = Instant::now();
    let (light, mut of_light) = ready(first, first_stages)?;
    let (mut over, mut of_second) = ready(second, second_stages)?;
    let covers = |job: &DrawJob<'_, R>| match &job.geometry.triangles[..] {
        [one] => covers_all(one, [second.width, second.height]) && job.fragment_plan.tests_nothing(),
        _ => false,
    };
    if !over.jobs.first().is_some_and(covers) {
        return Ok(None);
    }
    let map = over.jobs.remove(0);
    over.bins = Bins::new(second.width, second.height, &over.jobs)?;
    let blank = map.fragment.is_same_everywhere().then(|| Worker::new(&light, None).map_blank(&light, &map));
    let mapped = Mapped { map, over, blank, read_elsewhere: AtomicBool::new(false) };
    let image = draw_tiles(&light, Some(&mapped), "a pass of display bytes", unorm8, [&mut of_light, &mut of_second])?;
    of_light.wall_ms = 1e3 * whole.elapsed().as_secs_f64();
    Ok((!mapped.read_elsewhere.into_inner()).then_some((PassImage::Unorm(image), [of_light, of_second])))
}

/// Runs the vertex stages of a pass and sorts its triangles.
fn ready<'a, R: Real>(pass: &'a Pass, stages: &[DrawStages<'a, R>]) -> Result<(PassJobs<'a, R>, PassTimings), RenderError> {
    check(pass)?;
    let mut timings = PassTimings { name: pass.name.to_owned(), ..PassTimings::default() };
    let mut jobs = Vec::with_capacity(pass.draws.len());
    for (draw, stages) in pass.draws.iter().zip(stages) {
        jobs.push(prepare(pass, draw, stages, &mut timings)?);
    }
    let start = Instant::now();
    let bins = Bins::new(pass.width, pass.height, &jobs)?;
    timings.binning_ms = 1e3 * start.elapsed().as_secs_f64();
    Ok((PassJobs { pass, jobs, bins }, timings))
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

/// The picture of a pass, or of the second of two; each pixel is written once, by the thread that draws its tile: to touch 16 MB for the first time is a cost of its own.
fn draw_tiles<R: Real, T: Copy + Send + Sync>(
    light: &PassJobs<'_, R>,
    mapped: Option<&Mapped<'_, R>>,
    what: &'static str,
    convert: impl Fn([f32; 4]) -> T + Sync,
    timings: [&mut PassTimings; 2],
) -> Result<Vec<T>, RenderError> {
    let pass = light.pass;
    let count = pass.width as usize * pass.height as usize;
    let mut image = Vec::new();
    super::try_grow(&mut image, count, what)?;
    let pixels = TilePixels::new();
    // Tiles of this colour need no drawing; `None`: no two tiles need be alike.
    let blank = mapped.map_or(Some(pass.clear), |m| m.blank).map(&convert);
    let idle: Mutex<Vec<Worker<'_, R>>> = Mutex::new(Vec::new());
    let tile = TILE as usize;
    image.spare_capacity_mut()[..count].par_chunks_mut(tile * pass.width as usize).enumerate().for_each(|(ty, band)| {
        let blank = |tx: usize| {
            let drawn = |bins: &Bins| !bins.tile(tx, ty).is_empty();
            blank.filter(|_| !drawn(&light.bins) && !mapped.is_some_and(|m| drawn(&m.over.bins)))
        };
        let mut tiles: Vec<Vec<&mut [MaybeUninit<T>]>> =
            (0..light.bins.across).map(|tx| Vec::with_capacity(if blank(tx).is_none() { tile } else { 0 })).collect();
        for row in band.chunks_mut(pass.width as usize) {
            for (tx, part) in row.chunks_mut(tile).enumerate() {
                match blank(tx) {
                    Some(blank) => part.fill(MaybeUninit::new(blank)),
                    None => tiles[tx].push(part),
                }
            }
        }
        tiles.par_iter_mut().enumerate().filter(|(tx, _)| blank(*tx).is_none()).for_each(|(tx, rows)| {
            let free = idle.lock().pop();
            let mut worker = free.unwrap_or_else(|| Worker::new(light, mapped));
            worker.draw_tile(light, mapped, [tx, ty], &pixels);
            let start = Instant::now();
            worker.finished().write_to(rows, &convert);
            worker.resolve_seconds += start.elapsed().as_secs_f64();
            idle.lock().push(worker);
        });
    });
    // SAFETY: the rows of all tiles are all of the picture; a tile that is drawn has written each pixel of its rows, any other was filled.
    unsafe { image.set_len(count) };
    let [first, second] = timings;
    for worker in idle.into_inner() {
        first.shading_thread_ms += 1e3 * worker.light.shading_seconds;
        let last = if let Some((mapped, _)) = worker.mapped {
            second.shading_thread_ms += 1e3 * mapped.shading_seconds;
            &mut *second
        } else {
            &mut *first
        };
        last.resolve_thread_ms += 1e3 * worker.resolve_seconds;
    }
    Ok(image)
}

/// A thread's state in one program.
type Run<'a, R> = Box<dyn LaneRun<R> + Send + 'a>;

/// A thread's buffers for one pass.
struct PassWorker<'a, R: Real> {
    target: TileTarget,
    /// By draw; started when first needed.
    runs: Vec<Option<Run<'a, R>>>,
    shading_seconds: f64,
}

impl<'a, R: Real> PassWorker<'a, R> {
    fn new(of: &PassJobs<'a, R>) -> Self {
        Self { target: TileTarget::new(of.pass.samples), runs: of.jobs.iter().map(|_| None).collect(), shading_seconds: 0.0 }
    }

    /// Draws the triangles of a tile over what is there.
    fn draw(&mut self, of: &PassJobs<'a, R>, [tx, ty]: [usize; 2], pixels: &TilePixels, batch: &mut Batch) {
        let tile = [tx as u32 * TILE, ty as u32 * TILE];
        let mut shader = TileShader { target: &mut self.target, pixels, tile, samples: of.pass.samples };
        for of_draw in of.bins.tile(tx, ty).chunk_by(|a, b| a.0 == b.0) {
            let d = of_draw[0].0 as usize;
            let job = &of.jobs[d];
            let run = self.runs[d].get_or_insert_with(|| job.fragment.start());
            let triangles: Vec<u32> = of_draw.iter().map(|(_, t)| *t).collect();
            shader.draw(job, &triangles, run.as_mut(), batch);
        }
    }
}

/// A thread's buffers, handed from tile to tile.
struct Worker<'a, R: Real> {
    light: PassWorker<'a, R>,
    /// Of the second pass, and of its map.
    mapped: Option<(PassWorker<'a, R>, Run<'a, R>)>,
    batch: Batch,
    resolve_seconds: f64,
}

impl<'a, R: Real> Worker<'a, R> {
    fn new(light: &PassJobs<'a, R>, mapped: Option<&Mapped<'a, R>>) -> Self {
        let mapped = mapped.map(|m| (PassWorker::new(&m.over), m.map.fragment.start()));
        Self { light: PassWorker::new(light), mapped, batch: Batch::new(), resolve_seconds: 0.0 }
    }

    /// The target that holds the picture.
    fn finished(&self) -> &TileTarget {
        self.mapped.as_ref().map_or(&self.light.target, |(of_second, _)| &of_second.target)
    }

    fn draw_tile(&mut self, light: &PassJobs<'a, R>, mapped: Option<&Mapped<'a, R>>, at: [usize; 2], pixels: &TilePixels) {
        let start = Instant::now();
        let pass = light.pass;
        let depth = light.bins.tile(at[0], at[1]).iter().any(|(d, _)| light.jobs[*d as usize].fragment_plan.uses_depth());
        self.light.target.clear(pass.clear, depth);
        self.light.draw(light, at, pixels, &mut self.batch);
        self.light.shading_seconds += start.elapsed().as_secs_f64();
        let start = Instant::now();
        self.light.target.merge_samples();
        self.resolve_seconds += start.elapsed().as_secs_f64();
        if let (Some(mapped), Some((of_second, map_run))) = (mapped, &mut self.mapped) {
            let start = Instant::now();
            if mapped.blank.is_none() {
                self.light.target.touch_all();
            }
            of_second.target.clear(mapped.blank.unwrap_or(mapped.over.pass.clear), false);
            let tile = at.map(|k| k as u32 * TILE);
            let texture =
                TileTexture { resolved: &self.light.target, tile, size: [pass.width, pass.height], read_elsewhere: Cell::new(false) };
            let mut shader = TileShader { target: &mut of_second.target, pixels, tile, samples: 1 };
            for block in 0..TILE_BLOCKS {
                let [x, y] = block_place(block);
                let inside = tile[0] + x < pass.width && tile[1] + y < pass.height;
                if inside && (mapped.blank.is_none() || self.light.target.is_touched(block)) {
                    shader.map_block(&mapped.map, block, &texture, map_run.as_mut(), &mut self.batch);
                }
            }
            mapped.read_elsewhere.fetch_or(texture.read_elsewhere.get(), Ordering::Relaxed);
            of_second.draw(&mapped.over, at, pixels, &mut self.batch);
            of_second.shading_seconds += start.elapsed().as_secs_f64();
        }
    }

    /// What a map that is the same everywhere makes of the first pass's clear colour.
    fn map_blank(&mut self, light: &PassJobs<'a, R>, map: &DrawJob<'a, R>) -> [f32; 4] {
        let (pass, pixels) = (light.pass, TilePixels::new());
        self.light.target.clear(pass.clear, false);
        self.light.target.touch_all();
        let mut blank = TileTarget::new(1);
        blank.clear([0.0; 4], false);
        let texture =
            TileTexture { resolved: &self.light.target, tile: [0, 0], size: [pass.width, pass.height], read_elsewhere: Cell::new(false) };
        let mut shader = TileShader { target: &mut blank, pixels: &pixels, tile: [0, 0], samples: 1 };
        shader.map_block(map, 0, &texture, map.fragment.start().as_mut(), &mut self.batch);
        blank.block(0).map_or([0.0; 4], |planes| planes.map(|plane| plane[0]))
    }
}
