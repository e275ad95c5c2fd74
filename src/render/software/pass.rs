//! Executes one pass: sets up the triangles of every draw, bins them into tiles, and shades the tiles on all cores.
//!
//! In: a pass and the bound stages of its draws. Out: the resolved image and timings. Always: the image has the same bits for any number of threads, because
//! each tile's bin lists its triangles in the order of the draws, and tiles write disjoint parts of the image.
//!
//! Two passes can be fused (`execute_fused`) if the second reads each pixel of the first only when it writes the same pixel (pass_fusion.rs). A tile
//! then goes through both passes before the next tile is started, and the first pass's image is never stored.

use super::RenderError;
use super::fragment_setup::FragmentSetup;
use super::math::Real;
use super::pass_fusion::TileTexture;
use super::prepared_draw::{DrawExtent, PreparedDraw};
use super::raster::coverage::{PixelCentres, TILE_BLOCKS, TILE_SIDE_PX, block_position, covers_all};
use super::raster::setup::VertexGrid;
use super::shade::{Batch, TileShader};
use super::stage::{LaneRun, LaneStage};
use super::tile_rows::{TileRows, unorm8};
use super::tiles::TileTarget;
use super::timings::PassTimings;
use super::tone_map::ToneMapUniforms;
use super::vertex::{AssembledDraw, assemble};
use crate::render::plan::{ColourFormat, Pass, PlanDraw};
use crate::shader::ModuleId;
use parking_lot::Mutex;
use rayon::prelude::*;
use std::mem::MaybeUninit;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Centres of a tile's pixels.
static PIXEL_CENTRES: LazyLock<PixelCentres> = LazyLock::new(PixelCentres::new);

/// The stages of one draw, bound to its uniforms and textures, and the subpixel grid to which vertex positions are rounded after the vertex stage.
pub struct DrawStages<'a, R: Real> {
    pub vertex: &'a dyn LaneStage<R>,
    pub vertex_grid: VertexGrid,
    pub fragment: &'a dyn LaneStage<R>,
}

/// The resolved colour of a pass, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum PassImage {
    Float(Vec<[f32; 4]>),
    Unorm(Vec<[u8; 4]>),
}

/// A pass whose triangles are set up and binned.
struct PreparedPass<'a, R: Real> {
    pass: &'a Pass,
    draws: Vec<PreparedDraw<'a, R>>,
    bins: TileBins,
}

/// A second pass that is executed tile by tile with the first. Its first draw covers the target and reads the first pass's image.
struct FusedPass<'a, R: Real> {
    /// Its first draw.
    full_screen: PreparedDraw<'a, R>,
    /// The other draws of the second pass, such as labels.
    overlay: PreparedPass<'a, R>,
    /// The colour to which the full-screen draw maps the first pass's clear colour; `None` if that colour may differ between pixels.
    mapped_clear_colour: Option<[f32; 4]>,
    /// The uniforms of the full-screen draw if it is the shipped (not edited) tone map. Native code then maps complete tiles directly to bytes, where
    /// [`Self::direct_tone_map`] permits it.
    tone_map: Option<ToneMapUniforms>,
    /// Set if the full-screen draw has read pixels other than its own, which makes the image invalid.
    read_other_pixels: AtomicBool,
}

impl<R: Real> FusedPass<'_, R> {
    /// The tone map that converts a tile to display bytes in native code. `None` if the full-screen draw is not the shipped tone map, or maps the clear colour
    /// differently at different pixels. Also `None` if another draw of the second pass covers part of the tile.
    fn direct_tone_map(&self, [tx, ty]: [usize; 2]) -> Option<&ToneMapUniforms> {
        self.tone_map.as_ref().filter(|_| self.mapped_clear_colour.is_some() && self.overlay.bins.tile(tx, ty).is_empty())
    }
}

/// The triangles of every tile, in draw order, one tile after the other.
struct TileBins {
    /// Number of tiles in a row.
    tiles_across: usize,
    /// Index of each tile's first entry, and at the end the number of entries.
    starts: Vec<usize>,
    /// Each entry: the index of a draw, and the index of a raster triangle in this draw's geometry.
    entries: Vec<(u32, u32)>,
}

impl TileBins {
    fn new<R: Real>(width: u32, height: u32, draws: &[PreparedDraw<'_, R>]) -> Result<Self, RenderError> {
        let (tiles_across, tiles_down) = (width.div_ceil(TILE_SIDE_PX) as usize, height.div_ceil(TILE_SIDE_PX) as usize);
        let for_each_entry = |visit: &mut dyn FnMut(usize, (u32, u32))| {
            for (draw_index, draw) in draws.iter().enumerate() {
                for (triangle_index, triangle) in draw.geometry.triangles.iter().enumerate() {
                    let [x0, y0, x1, y1] = triangle.bounds_px;
                    for ty in y0 / TILE_SIDE_PX..y1.div_ceil(TILE_SIDE_PX) {
                        for tx in x0 / TILE_SIDE_PX..x1.div_ceil(TILE_SIDE_PX) {
                            visit(ty as usize * tiles_across + tx as usize, (draw_index as u32, triangle_index as u32));
                        }
                    }
                }
            }
        };
        // The entries are counted first, so that memory is reserved once, and too little memory is an error.
        let mut starts = super::try_vec(tiles_across * tiles_down + 1, 0_usize, "the tiles")?;
        for_each_entry(&mut |tile, _| starts[tile + 1] += 1);
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut entries = super::try_vec(starts[tiles_across * tiles_down], (0, 0), "the tiles' triangles")?;
        let mut next = starts.clone();
        for_each_entry(&mut |tile, entry| {
            entries[next[tile]] = entry;
            next[tile] += 1;
        });
        Ok(Self { tiles_across, starts, entries })
    }

    fn tile(&self, x: usize, y: usize) -> &[(u32, u32)] {
        let k = y * self.tiles_across + x;
        &self.entries[self.starts[k]..self.starts[k + 1]]
    }
}

/// Executes a pass. `stages`: the bound stages of the pass's draws, in order. Runs on the thread pool from which it is called.
pub fn execute<R: Real>(pass: &Pass, stages: &[DrawStages<'_, R>]) -> Result<(PassImage, PassTimings), RenderError> {
    let start = Instant::now();
    let (prepared, mut timings) = prepare_pass(pass, stages)?;
    // There is no second pass.
    let fused = None;
    let unused_timings = &mut PassTimings::default();
    let all_timings = [&mut timings, unused_timings];
    let image = match pass.format {
        ColourFormat::Hdr | ColourFormat::HdrF32 => {
            let write = |worker: &Worker<'_, R>, rows: TileRows<'_, '_, [f32; 4]>, _| worker.first.target.write_linear(rows);
            PassImage::Float(draw_tiles(&prepared, fused, "an image of f32 colours", Some(pass.clear), write, all_timings)?)
        }
        ColourFormat::Rgba8Unorm => {
            let write = |worker: &Worker<'_, R>, rows: TileRows<'_, '_, [u8; 4]>, _| worker.first.target.write_converted(rows, unorm8);
            PassImage::Unorm(draw_tiles(&prepared, fused, "an image of display bytes", Some(unorm8(pass.clear)), write, all_timings)?)
        }
    };
    timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
    Ok((image, timings))
}

/// Executes two fused passes and returns the image of the second. `None` if they cannot be fused: the first draw of the second pass does not draw every
/// pixel of its target, or reads pixels other than its own. The wall time of both passes together is recorded for the first one.
pub(crate) fn execute_fused<R: Real>(
    first: &Pass,
    first_stages: &[DrawStages<'_, R>],
    second: &Pass,
    second_stages: &[DrawStages<'_, R>],
) -> Result<Option<(PassImage, [PassTimings; 2])>, RenderError> {
    let start = Instant::now();
    let (first_prepared, mut first_timings) = prepare_pass(first, first_stages)?;
    let (mut overlay, mut second_timings) = prepare_pass(second, second_stages)?;
    let is_full_screen = |draw: &PreparedDraw<'_, R>| match &draw.geometry.triangles[..] {
        [triangle] => covers_all(triangle, [second.width, second.height]) && draw.fragment_setup.draws_every_covered_pixel(),
        _ => false,
    };
    // What runs once per draw cannot read the size of the first pass's image, which does not exist yet.
    let can_be_fused = |draw: &PreparedDraw<'_, R>| is_full_screen(draw) && !draw.fragment.reads_texture_size_per_draw();
    if !overlay.draws.first().is_some_and(can_be_fused) {
        return Ok(None);
    }
    let full_screen = overlay.draws.remove(0);
    // The bins of the other draws alone: the full-screen draw needs no bins.
    overlay.bins = TileBins::new(second.width, second.height, &overlay.draws)?;
    let no_second_pass = None;
    let mapped_clear_colour = full_screen
        .fragment
        .is_position_independent()
        .then(|| Worker::new(&first_prepared, no_second_pass).map_clear_colour(&first_prepared, &full_screen));
    let tone_map = full_screen.fragment.tone_map();
    let fused = FusedPass { full_screen, overlay, mapped_clear_colour, tone_map, read_other_pixels: AtomicBool::new(false) };
    let clear_bytes = unorm8(mapped_clear_colour.unwrap_or_default());
    let write = |worker: &Worker<'_, R>, rows: TileRows<'_, '_, [u8; 4]>, tile| match fused.direct_tone_map(tile) {
        Some(tone_map) => worker.first.target.write_tone_mapped(rows, tone_map, clear_bytes),
        None => worker.final_target().write_converted(rows, unorm8),
    };
    let timings = [&mut first_timings, &mut second_timings];
    let image = draw_tiles(&first_prepared, Some(&fused), "an image of display bytes", mapped_clear_colour.map(unorm8), write, timings)?;
    first_timings.wall_ms = 1e3 * start.elapsed().as_secs_f64();
    Ok((!fused.read_other_pixels.into_inner()).then_some((PassImage::Unorm(image), [first_timings, second_timings])))
}

/// Runs the vertex stages of a pass, sets up its triangles and bins them.
fn prepare_pass<'a, R: Real>(pass: &'a Pass, stages: &[DrawStages<'a, R>]) -> Result<(PreparedPass<'a, R>, PassTimings), RenderError> {
    check_size_and_samples(pass)?;
    let mut timings = PassTimings { name: pass.name.to_owned(), ..PassTimings::default() };
    let mut draws = Vec::with_capacity(pass.draws.len());
    for (draw, stages) in pass.draws.iter().zip(stages) {
        draws.push(prepare_draw(pass, draw, stages, &mut timings)?);
    }
    let start = Instant::now();
    let bins = TileBins::new(pass.width, pass.height, &draws)?;
    timings.binning_ms = 1e3 * start.elapsed().as_secs_f64();
    Ok((PreparedPass { pass, draws, bins }, timings))
}

fn check_size_and_samples(pass: &Pass) -> Result<(), RenderError> {
    let is_valid = |side_px: u32| (1..=super::MAX_SIDE_PX).contains(&side_px);
    if !is_valid(pass.width) || !is_valid(pass.height) {
        return Err(RenderError::Size { pass: pass.name.to_owned(), width: pass.width, height: pass.height });
    }
    if pass.samples != 1 && pass.samples != 4 {
        return Err(RenderError::Samples { pass: pass.name.to_owned(), samples: pass.samples });
    }
    Ok(())
}

/// The number of instructions that one texture read counts as, in a module whose key selects the pixel view of shading cost; `None` for all others.
fn instructions_per_read(module: &ModuleId) -> Option<f64> {
    if let ModuleId::Keyed(key) = module { key.instructions_per_read() } else { None }
}

fn prepare_draw<'a, R: Real>(
    pass: &Pass,
    draw: &PlanDraw,
    stages: &DrawStages<'a, R>,
    timings: &mut PassTimings,
) -> Result<PreparedDraw<'a, R>, RenderError> {
    let fragment = stages.fragment;
    let AssembledDraw { geometry, submitted_triangles, vertex_seconds, setup_seconds } =
        assemble(draw, stages.vertex, fragment.inputs(), [pass.width, pass.height], stages.vertex_grid)?;
    timings.vertex_ms += 1e3 * vertex_seconds;
    timings.setup_ms += 1e3 * setup_seconds;
    timings.submitted_triangles += submitted_triangles;
    // Each submitted triangle that is not culled has one source triangle in the geometry, even if clipping splits it into several raster triangles.
    timings.culled_triangles += submitted_triangles - geometry.source_triangles.len();
    timings.clipped_triangles += geometry.clipped_count;
    timings.rasterised_triangles += geometry.triangles.len();
    let fragment_setup = FragmentSetup::new(fragment, draw.depth, pass.has_depth);
    Ok(PreparedDraw {
        geometry,
        fragment,
        fragment_setup,
        blend: draw.blend,
        shading_rate: draw.shading_rate,
        // The plan gives the outlines and names the image of marks. The marks were read from this image when the fragment stage was bound.
        extent: draw.extent.map(|outlines| DrawExtent { outlines, marks: fragment.marks().cloned() }),
        instructions_per_read: instructions_per_read(&draw.module),
    })
}

/// Draws the image of a pass, or of the second of two fused passes. The memory is not initialised first, to save one write of the image;
/// each pixel is written once. `allocation` names the image in the error if memory is insufficient. `empty_tile_colour`: colour of a tile without
/// triangles; `None` if it differs between pixels, in which case such tiles are shaded too. `write` writes a drawn tile, given by column and row.
/// `timings`: of the first pass, and of the fused second pass; without a second pass, its timings are left unchanged.
fn draw_tiles<R: Real, T: Copy + Send + Sync>(
    first: &PreparedPass<'_, R>,
    fused: Option<&FusedPass<'_, R>>,
    allocation: &'static str,
    empty_tile_colour: Option<T>,
    write: impl Fn(&Worker<'_, R>, TileRows<'_, '_, T>, [usize; 2]) + Sync,
    timings: [&mut PassTimings; 2],
) -> Result<Vec<T>, RenderError> {
    let pass = first.pass;
    let count = pass.width as usize * pass.height as usize;
    let mut image = Vec::new();
    super::try_grow(&mut image, count, allocation)?;
    let pixel_centres = &*PIXEL_CENTRES;
    // Boxed, because each tile moves a worker out of the list and back.
    let idle_workers: Mutex<Vec<Box<Worker<'_, R>>>> = Mutex::new(Vec::new());
    let tile_side = TILE_SIDE_PX as usize;
    image.spare_capacity_mut()[..count].par_chunks_mut(tile_side * pass.width as usize).enumerate().for_each(|(ty, tile_row)| {
        // `Some` for tiles that are filled instead of drawn.
        let fill_colour = |tx: usize| {
            let has_triangles = |bins: &TileBins| !bins.tile(tx, ty).is_empty();
            empty_tile_colour.filter(|_| !has_triangles(&first.bins) && !fused.is_some_and(|f| has_triangles(&f.overlay.bins)))
        };
        let mut rows_of_tiles: Vec<Vec<&mut [MaybeUninit<T>]>> =
            (0..first.bins.tiles_across).map(|tx| Vec::with_capacity(if fill_colour(tx).is_none() { tile_side } else { 0 })).collect();
        for row in tile_row.chunks_mut(pass.width as usize) {
            for (tx, part) in row.chunks_mut(tile_side).enumerate() {
                match fill_colour(tx) {
                    Some(colour) => part.fill(MaybeUninit::new(colour)),
                    None => rows_of_tiles[tx].push(part),
                }
            }
        }
        rows_of_tiles.par_iter_mut().enumerate().filter(|(tx, _)| fill_colour(*tx).is_none()).for_each(|(tx, rows)| {
            let idle_worker = idle_workers.lock().pop();
            let mut worker = idle_worker.unwrap_or_else(|| Box::new(Worker::new(first, fused)));
            worker.draw_tile(first, fused, [tx, ty], pixel_centres);
            let start = Instant::now();
            write(&worker, rows, [tx, ty]);
            worker.resolve_seconds += start.elapsed().as_secs_f64();
            idle_workers.lock().push(worker);
        });
    });
    // SAFETY: the rows of all tiles make up the image; each tile was either filled, or drawn and then written to every pixel of its rows.
    unsafe { image.set_len(count) };
    let [first_timings, second_timings] = timings;
    for worker in idle_workers.into_inner() {
        first_timings.shading_thread_ms += 1e3 * worker.first.shading_seconds;
        let last_pass_timings = if let Some((second, _)) = worker.second {
            second_timings.shading_thread_ms += 1e3 * second.shading_seconds;
            &mut *second_timings
        } else {
            &mut *first_timings
        };
        last_pass_timings.resolve_thread_ms += 1e3 * worker.resolve_seconds;
    }
    Ok(image)
}

/// The working state of one thread in one fragment program.
type BoxedRun<'a, R> = Box<dyn LaneRun<R> + Send + 'a>;

/// Buffers for drawing tiles of one pass.
struct PassWorker<'a, R: Real> {
    target: TileTarget,
    /// One run per draw, created on first use.
    runs: Vec<Option<BoxedRun<'a, R>>>,
    shading_seconds: f64,
}

impl<'a, R: Real> PassWorker<'a, R> {
    fn new(prepared: &PreparedPass<'a, R>) -> Self {
        Self { target: TileTarget::new(prepared.pass.samples), runs: prepared.draws.iter().map(|_| None).collect(), shading_seconds: 0.0 }
    }

    /// Draws a tile's triangles into the target.
    fn draw(&mut self, prepared: &PreparedPass<'a, R>, [tx, ty]: [usize; 2], pixel_centres: &PixelCentres, batch: &mut Batch) {
        let tile_corner = [tx as u32 * TILE_SIDE_PX, ty as u32 * TILE_SIDE_PX];
        let mut shader = TileShader { target: &mut self.target, pixel_centres, tile_corner, samples: prepared.pass.samples };
        for entries_of_draw in prepared.bins.tile(tx, ty).chunk_by(|(draw_a, _), (draw_b, _)| draw_a == draw_b) {
            let (draw_index, _) = entries_of_draw[0];
            let draw_index = draw_index as usize;
            let draw = &prepared.draws[draw_index];
            let run = self.runs[draw_index].get_or_insert_with(|| draw.fragment.new_run());
            let triangles: Vec<u32> = entries_of_draw.iter().map(|(_, t)| *t).collect();
            shader.draw(draw, &triangles, run.as_mut(), batch);
        }
    }
}

/// Buffers for drawing tiles, used by one thread at a time.
struct Worker<'a, R: Real> {
    first: PassWorker<'a, R>,
    /// Of a fused second pass: the buffers for its other draws, and the run of its full-screen draw.
    second: Option<(PassWorker<'a, R>, BoxedRun<'a, R>)>,
    batch: Batch,
    resolve_seconds: f64,
}

impl<'a, R: Real> Worker<'a, R> {
    fn new(first: &PreparedPass<'a, R>, fused: Option<&FusedPass<'a, R>>) -> Self {
        let second = fused.map(|f| (PassWorker::new(&f.overlay), f.full_screen.fragment.new_run()));
        Self { first: PassWorker::new(first), second, batch: Batch::new(), resolve_seconds: 0.0 }
    }

    /// The target that contains the final image of the tile.
    fn final_target(&self) -> &TileTarget {
        self.second.as_ref().map_or(&self.first.target, |(second, _)| &second.target)
    }

    /// Draws a tile of the first pass and, unless native code maps it to display bytes directly, of the fused second pass.
    fn draw_tile(
        &mut self,
        first: &PreparedPass<'a, R>,
        fused: Option<&FusedPass<'a, R>>,
        tile_index: [usize; 2],
        pixel_centres: &PixelCentres,
    ) {
        let start = Instant::now();
        let pass = first.pass;
        let entries = first.bins.tile(tile_index[0], tile_index[1]);
        let uses_depth = entries.iter().any(|(draw, _)| first.draws[*draw as usize].fragment_setup.uses_depth());
        self.first.target.clear(pass.clear, uses_depth);
        self.first.draw(first, tile_index, pixel_centres, &mut self.batch);
        self.first.shading_seconds += start.elapsed().as_secs_f64();
        let start = Instant::now();
        self.first.target.resolve();
        self.resolve_seconds += start.elapsed().as_secs_f64();
        if let (Some(fused), Some((second, full_screen_run))) =
            (fused.filter(|f| f.direct_tone_map(tile_index).is_none()), &mut self.second)
        {
            let start = Instant::now();
            if fused.mapped_clear_colour.is_none() {
                self.first.target.prepare_all_blocks();
            }
            // `can_fuse_with_next_pass` admits only a second pass without depth.
            let uses_depth = false;
            second.target.clear(fused.mapped_clear_colour.unwrap_or(fused.overlay.pass.clear), uses_depth);
            let tile_corner = tile_index.map(|k| k as u32 * TILE_SIDE_PX);
            let texture = TileTexture::new(&self.first.target, tile_corner, [pass.width, pass.height]);
            let mut shader = TileShader { target: &mut second.target, pixel_centres, tile_corner, samples: 1 };
            for block in 0..TILE_BLOCKS {
                let [x, y] = block_position(block);
                let is_inside = tile_corner[0] + x < pass.width && tile_corner[1] + y < pass.height;
                if is_inside && (fused.mapped_clear_colour.is_none() || self.first.target.is_written(block)) {
                    texture.shaded_block.set(block);
                    shader.shade_block_with_texture(&fused.full_screen, block, &texture, full_screen_run.as_mut(), &mut self.batch);
                }
            }
            fused.read_other_pixels.fetch_or(texture.read_other_pixels.get(), Ordering::Relaxed);
            second.draw(&fused.overlay, tile_index, pixel_centres, &mut self.batch);
            second.shading_seconds += start.elapsed().as_secs_f64();
        }
    }

    /// The colour to which a position-independent full-screen draw maps the first pass's clear colour.
    fn map_clear_colour(&mut self, first: &PreparedPass<'a, R>, full_screen: &PreparedDraw<'a, R>) -> [f32; 4] {
        let (pass, pixel_centres) = (first.pass, &*PIXEL_CENTRES);
        // The block that a new `TileTexture` presents.
        let block = 0;
        let (samples, uses_depth) = (1, false);
        self.first.target.clear(pass.clear, uses_depth);
        self.first.target.prepare_all_blocks();
        let mut mapped = TileTarget::new(samples);
        mapped.clear([0.0; 4], uses_depth);
        let texture = TileTexture::new(&self.first.target, [0, 0], [pass.width, pass.height]);
        let mut shader = TileShader { target: &mut mapped, pixel_centres, tile_corner: [0, 0], samples };
        shader.shade_block_with_texture(full_screen, block, &texture, full_screen.fragment.new_run().as_mut(), &mut self.batch);
        mapped.block(block).map_or([0.0; 4], |planes| planes.map(|plane| plane[0]))
    }
}
