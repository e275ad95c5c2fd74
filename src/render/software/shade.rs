//! Shades a tile: gathers the quads of one draw into batches, runs the fragment program on them, depth-tests them and blends their colours.
//!
//! A batch is 32 quads (128 lanes) in the order in which triangles cover them; a block of 16x8 pixels has as many. Quads of several triangles of one draw
//! share a batch, so that small triangles use all lanes too; the batches of a large triangle are complete blocks. If a program neither discards nor writes
//! depth, depth is tested before shading, so that hidden quads are not shaded. Results are blended in quad order, which keeps the triangle order.
//!
//! In: the draw's triangles that may cover the tile, and its fragment program. Out: the tile's colour and depth. Not here: coverage (`raster::coverage`),
//! lane inputs (`lane_inputs`), and the stored samples (`tiles`, `tile_depth`).

use super::coarse_shading::{InterpolatedLight, Tile, shade_coarsely};
use super::exec::{ExecutionCounts, LaneMask, TextureUnit};
use super::fragment_setup::FragmentSetup;
use super::lane_inputs;
use super::math::Real;
use super::prepared_draw::{PreparedDraw, QUADS_PER_BATCH, Quad};
use super::raster::coverage::{
    BLOCK_HEIGHT, BLOCK_QUADS, BLOCK_WIDTH, PixelCentres, TILE_BLOCKS, block_position, full_coverage, quad_position, sample_positions,
    walk_tile,
};
use super::raster::setup::{STEPS_PER_PIXEL, SourceTriangle};
use super::stage::{LANES, LaneRun};
use super::tiles::TileTarget;
use crate::render::plan::DepthState;

/// Shades one tile on one thread.
pub(crate) struct TileShader<'a> {
    pub target: &'a mut TileTarget,
    pub pixel_centres: &'a PixelCentres,
    /// Top-left pixel of the tile.
    pub tile_corner: [u32; 2],
    /// Samples per pixel: 1 or 4.
    pub samples: u8,
}

/// For each set of a quad's lanes, given by four bits: the coverage of a quad in which all samples of these lanes' pixels are covered.
const COVERAGE_OF_LANES: [u16; 16] = {
    let mut coverage = [0; 16];
    let mut lanes = 0;
    while lanes < 16 {
        let mut corner = 0;
        while corner < 4 {
            coverage[lanes] |= if lanes >> corner & 1 == 1 { 0xf << (4 * corner) } else { 0 };
            corner += 1;
        }
        lanes += 1;
    }
    coverage
};

/// Values of colour components that a program does not write: 0 for red, green and blue; 1 for alpha.
static DEFAULT_COMPONENTS: [[f32; LANES]; 2] = [[0.0; LANES], [1.0; LANES]];

/// Quads that are collected until the batch is full.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    quads: [Quad; QUADS_PER_BATCH],
    count: usize,
    /// Colour of the last run, converted to f32; used only if the lanes are f64.
    f32_colour: [[f32; LANES]; 4],
    interpolated_light: Box<InterpolatedLight>,
}

impl Batch {
    pub(crate) fn new() -> Self {
        Self {
            quads: [Quad { index: 0, coverage: 0, source_triangle: 0 }; QUADS_PER_BATCH],
            count: 0,
            f32_colour: [[0.0; LANES]; 4],
            interpolated_light: Box::new(InterpolatedLight::new()),
        }
    }
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}

/// A `LaneRun` (the working state of the fragment program) that reads `texture` in place of the bound textures.
struct RunWithTexture<'a, R: Real> {
    run: &'a mut dyn LaneRun<R>,
    texture: &'a dyn TextureUnit<R>,
}

impl<R: Real> LaneRun<R> for RunWithTexture<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        self.run.input(k)
    }
    fn run(&mut self, active: LaneMask) -> LaneMask {
        self.run.run_with_textures(active, self.texture)
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        self.run.output(k)
    }
    fn counts(&self) -> ExecutionCounts {
        self.run.counts()
    }
}

/// Depths clamped to 0 to 1. NaN remains, and fails every depth test.
#[inline(always)]
fn clamped<R: Real>(values: &[R; LANES]) -> [f32; LANES] {
    let mut depths = [0.0; LANES];
    match R::as_f32(values) {
        Some(values) => depths.iter_mut().zip(values).for_each(|(depth, value)| *depth = value.clamp(0.0, 1.0)),
        None => depths.iter_mut().zip(values).for_each(|(depth, value)| *depth = (value.to_f64() as f32).clamp(0.0, 1.0)),
    }
    depths
}

/// Clears the coverage of quads whose pixels are zero in all components, because blending such a quad changes nothing.
#[inline(always)]
fn drop_zero_quads(quads: &mut [Quad], colour: [&[f32]; 4]) {
    let [r, g, b, a] = colour.map(|lanes| lanes.as_chunks::<4>().0);
    for ((((quad, r), g), b), a) in quads.iter_mut().zip(r).zip(g).zip(b).zip(a) {
        let mut bits = [0; 4];
        for i in 0..4 {
            bits[i] = r[i].to_bits() | g[i].to_bits() | b[i].to_bits() | a[i].to_bits();
        }
        if bits[0] | bits[1] | bits[2] | bits[3] == 0 {
            quad.coverage = 0;
        }
    }
}

/// A block that a triangle covers partly, compared with the draw's extent.
struct PartlyCoveredBlock {
    /// Index of its first quad in the tile.
    first_quad: usize,
    /// Whether the draw's extent includes no pixel of the block.
    extent_misses: bool,
    /// Whether the draw's extent includes every pixel of the block.
    extent_covers: bool,
}

/// Left, top, right and bottom edge, on the screen, of the block whose first quad has this index.
fn block_on_screen([tile_x, tile_y]: [u32; 2], first_quad: usize) -> [u32; 4] {
    let [x, y] = block_position(first_quad / QUADS_PER_BATCH);
    [tile_x + x, tile_y + y, tile_x + x + BLOCK_WIDTH, tile_y + y + BLOCK_HEIGHT]
}

/// Left, top, right and bottom edge, on the screen, of the quad with this index.
fn quad_on_screen([tile_x, tile_y]: [u32; 2], index: usize) -> [u32; 4] {
    let [x, y] = quad_position(index);
    [tile_x + x, tile_y + y, tile_x + x + 2, tile_y + y + 2]
}

impl TileShader<'_> {
    /// Draws the given triangles of one draw, in order.
    pub(crate) fn draw<R: Real>(&mut self, draw: &PreparedDraw<'_, R>, triangles: &[u32], run: &mut dyn LaneRun<R>, batch: &mut Batch) {
        let setup = &draw.fragment_setup;
        let coarsely_shaded_blocks = {
            let mut tile = Tile { target: self.target, pixel_centres: self.pixel_centres, corner: self.tile_corner };
            shade_coarsely(draw, triangles, &mut tile, run, &mut batch.interpolated_light)
        };
        for (k, &t) in triangles.iter().enumerate() {
            draw.geometry.prefetch(&triangles[k..]);
            let triangle = &draw.geometry.triangles[t as usize];
            let source_triangle = &draw.geometry.source_triangles[triangle.source_triangle as usize];
            let samples = self.samples;
            // The triangle's depth plane, if depth is tested before shading.
            let early_depth = (setup.allows_early_depth_test && setup.uses_depth()).then(|| self.depth_at_samples(source_triangle));
            let [tile_x, tile_y] = self.tile_corner;
            // Bit `b`: the triangle covers block `b`, and an edge of the draw's extent crosses it. These blocks come last, so that their quads fill batches of
            // their own.
            let mut extent_edge_blocks = 0_u64;
            let mut latest_partly_covered: Option<PartlyCoveredBlock> = None;
            walk_tile(triangle, tile_x, tile_y, samples, |first_quad, count, coverage| {
                if coarsely_shaded_blocks >> (first_quad / QUADS_PER_BATCH) & 1 == 1 {
                    return;
                }
                // All quads of a fully covered block are visited at once.
                if let Some(extent) = draw.extent.as_ref().filter(|_| count == QUADS_PER_BATCH) {
                    let block = block_on_screen([tile_x, tile_y], first_quad);
                    if extent.misses(block) {
                        return;
                    }
                    if !extent.covers(block) {
                        extent_edge_blocks |= 1 << (first_quad / QUADS_PER_BATCH);
                        return;
                    }
                }
                // A fully covered block fills a batch of its own, unless earlier quads wait in the batch or the depth test may drop quads of the block.
                if count == QUADS_PER_BATCH && batch.count == 0 && early_depth.is_none() {
                    self.shade_block(draw, first_quad, triangle.source_triangle, run, batch);
                    return;
                }
                // The quads of a partly covered block are visited one by one. The extent is tested for the block first, then for each quad.
                let mut extent = draw.extent.as_ref().filter(|_| count != QUADS_PER_BATCH);
                if let Some(draw_extent) = extent {
                    let first_of_block = first_quad / QUADS_PER_BATCH * QUADS_PER_BATCH;
                    let block = match latest_partly_covered.take().filter(|block| block.first_quad == first_of_block) {
                        Some(block) => block,
                        None => {
                            let rectangle = block_on_screen([tile_x, tile_y], first_of_block);
                            PartlyCoveredBlock {
                                first_quad: first_of_block,
                                extent_misses: draw_extent.misses(rectangle),
                                extent_covers: draw_extent.covers(rectangle),
                            }
                        }
                    };
                    let block = latest_partly_covered.insert(block);
                    if block.extent_misses {
                        return;
                    }
                    extent = extent.filter(|_| !block.extent_covers);
                }
                for index in first_quad..first_quad + count {
                    if extent.is_some_and(|extent| extent.misses(quad_on_screen([tile_x, tile_y], index))) {
                        continue;
                    }
                    let coverage = early_depth.as_ref().map_or(coverage, |depth| self.test_quad(index, coverage, depth, setup.depth));
                    if coverage == 0 {
                        continue;
                    }
                    self.gather(draw, Quad { index: index as u16, coverage, source_triangle: triangle.source_triangle }, run, batch);
                }
            });
            let Some(extent) = draw.extent.as_ref().filter(|_| extent_edge_blocks != 0) else { continue };
            for block in (0..TILE_BLOCKS).filter(|b| extent_edge_blocks >> b & 1 == 1) {
                for index in block * QUADS_PER_BATCH..(block + 1) * QUADS_PER_BATCH {
                    if extent.misses(quad_on_screen([tile_x, tile_y], index)) {
                        continue;
                    }
                    let full = full_coverage(samples);
                    let coverage = early_depth.as_ref().map_or(full, |depth| self.test_quad(index, full, depth, setup.depth));
                    if coverage != 0 {
                        self.gather(draw, Quad { index: index as u16, coverage, source_triangle: triangle.source_triangle }, run, batch);
                    }
                }
            }
        }
        let first_of_block = None;
        self.flush(draw, run, batch, first_of_block);
    }

    /// Adds a quad to the batch, which is shaded when it is full.
    #[inline(always)]
    fn gather<R: Real>(&mut self, draw: &PreparedDraw<'_, R>, quad: Quad, run: &mut dyn LaneRun<R>, batch: &mut Batch) {
        batch.quads[batch.count] = quad;
        batch.count += 1;
        if batch.count == QUADS_PER_BATCH {
            let first_of_block = None;
            self.flush(draw, run, batch, first_of_block);
        }
    }

    /// The triangle's depth: for each sample, its value if the pixel's centre were the tile's top-left corner; then its derivatives in x and y, per pixel. In
    /// f64, because near a horizon the depth is a small difference of large terms.
    fn depth_at_samples(&self, source_triangle: &SourceTriangle) -> ([f64; 4], f64, f64) {
        let corner = self.corner_from_origin(source_triangle);
        let mut at_samples = [0.0; 4];
        for (value, [sx, sy]) in at_samples.iter_mut().zip(sample_positions(self.samples)) {
            // Relative to the pixel's centre, because `PixelCentres` contains centres.
            let (dx, dy) = (*sx as f64 / STEPS_PER_PIXEL as f64 - 0.5, *sy as f64 / STEPS_PER_PIXEL as f64 - 0.5);
            *value = source_triangle.depth.at(corner[0] + dx, corner[1] + dy);
        }
        (at_samples, source_triangle.depth.dx, source_triangle.depth.dy)
    }

    /// Offset of the tile's top-left corner from the origin of the triangle's planes, in pixels.
    fn corner_from_origin(&self, source_triangle: &SourceTriangle) -> [f64; 2] {
        [f64::from(self.tile_corner[0]) - source_triangle.origin[0], f64::from(self.tile_corner[1]) - source_triangle.origin[1]]
    }

    /// Depth test of a quad; returns the coverage that passes. `depth`: as returned by [`TileShader::depth_at_samples`].
    fn test_quad(&mut self, index: usize, coverage: u16, depth: &([f64; 4], f64, f64), state: DepthState) -> u16 {
        let (at_samples, dx, dy) = depth;
        let mut passed = 0;
        for corner in 0..4 {
            let covered = coverage >> (4 * corner) & 0xf;
            if covered != 0 {
                let pixel = index * 4 + corner;
                let step = dx * f64::from(self.pixel_centres.x[pixel]) + dy * f64::from(self.pixel_centres.y[pixel]);
                passed |= self.target.depth.test(pixel, covered, at_samples.map(|v| (v + step) as f32), state) << (4 * corner);
            }
        }
        passed
    }

    /// Shades one block of a full-screen draw, whose only triangle has the index 0; the draw reads `texture` in place of the bound textures.
    pub(crate) fn shade_block_with_texture<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        block: usize,
        texture: &dyn TextureUnit<R>,
        run: &mut dyn LaneRun<R>,
        batch: &mut Batch,
    ) {
        self.shade_block(draw, block * BLOCK_QUADS as usize, 0, &mut RunWithTexture { run, texture }, batch);
    }

    /// Shades the fully covered block whose first quad has the index `first` in the tile; the batch is empty before and after.
    fn shade_block<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        first: usize,
        source_triangle: u32,
        run: &mut dyn LaneRun<R>,
        batch: &mut Batch,
    ) {
        let coverage = full_coverage(self.samples);
        for (k, quad) in batch.quads.iter_mut().enumerate() {
            *quad = Quad { index: (first + k) as u16, coverage, source_triangle };
        }
        batch.count = QUADS_PER_BATCH;
        self.flush(draw, run, batch, Some(first));
    }

    /// Shades, depth-tests and blends the collected quads. `first_of_block`: the first quad's index in the tile, if they make up a fully covered block.
    fn flush<R: Real>(&mut self, draw: &PreparedDraw<'_, R>, run: &mut dyn LaneRun<R>, batch: &mut Batch, first_of_block: Option<usize>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.flush_avx2(draw, run, batch, first_of_block) };
        }
        self.flush_generic(draw, run, batch, first_of_block);
    }

    /// [`TileShader::flush_generic`] compiled for AVX2: wider vectors, the same rounding.
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn flush_avx2<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        run: &mut dyn LaneRun<R>,
        batch: &mut Batch,
        first_of_block: Option<usize>,
    ) {
        self.flush_generic(draw, run, batch, first_of_block);
    }

    #[inline(always)]
    fn flush_generic<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        run: &mut dyn LaneRun<R>,
        batch: &mut Batch,
        first_of_block: Option<usize>,
    ) {
        let count = std::mem::take(&mut batch.count);
        if count == 0 {
            return;
        }
        // Unused lanes repeat the last quad, with no coverage, so that they compute ordinary values.
        let last = batch.quads[count - 1];
        batch.quads[count..].fill(Quad { coverage: 0, ..last });
        let quads = &batch.quads;
        // Uncovered pixels of a quad run as helper lanes for derivatives.
        let active = LaneMask::MAX >> (LANES - 4 * count);
        match first_of_block {
            // Relative to the block's corner, the pixel centres are the same for all blocks, and `pixel_centres` begins with those of the first block.
            Some(_) => lane_inputs::fill_block(draw, run, quads[0], [&self.pixel_centres.x, &self.pixel_centres.y], self.tile_corner),
            None => lane_inputs::fill_quads(draw, run, quads, self.pixel_centres, self.tile_corner),
        }
        let undiscarded = run.run(active);
        let setup = &draw.fragment_setup;
        // No closures in this loop, nor where `fully_drawn_block` is replaced: they would be compiled without this function's instruction set, and called.
        let mut outputs = [None; 4];
        for (lanes, output) in outputs.iter_mut().zip(setup.colour_outputs) {
            if let Some(output) = output {
                *lanes = Some(run.output(output));
            }
        }
        for (f32_values, values) in batch.f32_colour.iter_mut().zip(&outputs) {
            if let Some(f64_values) = values.filter(|v| R::as_f32(&v[..]).is_none()) {
                f32_values.iter_mut().zip(f64_values).for_each(|(to, from)| *to = from.to_f64() as f32);
            }
        }
        let mut colour = [&DEFAULT_COMPONENTS[0][..], &DEFAULT_COMPONENTS[0], &DEFAULT_COMPONENTS[0], &DEFAULT_COMPONENTS[1]];
        for (k, lanes) in colour.iter_mut().enumerate() {
            if let Some(values) = outputs[k] {
                *lanes = R::as_f32(&values[..]).unwrap_or(&batch.f32_colour[k]);
            }
        }
        // Quads that change nothing need no depth test either. They are common: most quads of a sprite have no light.
        if first_of_block.is_none() && draw.may_drop_zero_fragments() {
            drop_zero_quads(&mut batch.quads[..count], colour);
        }
        // The first quad of the block, if every sample of it is drawn.
        let mut fully_drawn_block = first_of_block.filter(|_| setup.allows_early_depth_test);
        if !setup.allows_early_depth_test {
            if undiscarded == 0 {
                return;
            }
            let written_depth = setup.depth_output.map(|o| run.output(o));
            fully_drawn_block = match first_of_block {
                Some(first) if undiscarded == LaneMask::MAX && self.test_block_depth(setup, written_depth, first) => Some(first),
                _ => None,
            };
            if fully_drawn_block.is_none() {
                self.late_depth_test(draw, written_depth, undiscarded, &mut batch.quads[..count]);
            }
        }
        // The pixel view of shading cost stores counts in place of the colour.
        if let Some(instructions_per_read) = draw.instructions_per_read {
            let counts = run.counts();
            let reads = f64::from(counts.texture_reads) * instructions_per_read;
            let cost = [counts.instructions as f32, reads as f32, 0.0, 0.0].map(|v| [v; LANES]);
            self.store(draw, &batch.quads[..count], cost.each_ref().map(|v| v.as_slice()));
            return;
        }
        match fully_drawn_block {
            Some(first) => self.target.store_lanes(first * 4, draw.blend, colour),
            None => self.store(draw, &batch.quads[..count], colour),
        }
    }

    /// Depth test of a complete block with the depth that the program wrote. If every sample passes, stores the depth (if the draw writes depth) and returns
    /// true. Otherwise, or if the program writes no depth, changes nothing and returns false. If the draw neither tests nor writes depth, returns true.
    #[inline(always)]
    fn test_block_depth<R: Real>(&mut self, setup: &FragmentSetup, depth: Option<&[R; LANES]>, first: usize) -> bool {
        if !setup.uses_depth() {
            return true;
        }
        let Some(values) = depth else { return false };
        self.target.depth.test_all(first * 4, &clamped(values), setup.depth)
    }

    /// Late depth test: removes discarded lanes from the coverage and depth-tests the others.
    #[inline(always)]
    fn late_depth_test<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        depth: Option<&[R; LANES]>,
        undiscarded: LaneMask,
        quads: &mut [Quad],
    ) {
        let state = draw.fragment_setup.depth;
        let uses_depth = draw.fragment_setup.uses_depth();
        let full = full_coverage(self.samples);
        let written_depth = depth.map(clamped);
        for (q, quad) in quads.iter_mut().enumerate() {
            quad.coverage &= COVERAGE_OF_LANES[(undiscarded >> (q * 4)) as usize & 0xf];
            if !uses_depth || quad.coverage == 0 {
                continue;
            }
            match &written_depth {
                Some(values) => {
                    let new = &values.as_chunks::<4>().0[q];
                    if quad.coverage == full && self.target.depth.test_all(usize::from(quad.index) * 4, new, state) {
                        continue;
                    }
                    quad.coverage = self.target.depth.test_quad(usize::from(quad.index) * 4, quad.coverage, new, state);
                }
                None => {
                    let source_triangle = &draw.geometry.source_triangles[quad.source_triangle as usize];
                    let depth_plane = self.depth_at_samples(source_triangle);
                    quad.coverage = self.test_quad(quad.index.into(), quad.coverage, &depth_plane, state);
                }
            }
        }
    }

    /// Blends the covered samples of the quads into the target.
    #[inline(always)]
    fn store<R: Real>(&mut self, draw: &PreparedDraw<'_, R>, quads: &[Quad], colour: [&[f32]; 4]) {
        let blend = draw.blend;
        let full = full_coverage(self.samples);
        let mut start = 0;
        while start < quads.len() {
            if quads[start].coverage == 0 {
                start += 1;
                continue;
            }
            // Consecutive fully covered quads are stored together.
            let run_length = quads[start..]
                .iter()
                .enumerate()
                .take_while(|(i, quad)| quad.coverage == full && usize::from(quad.index) == usize::from(quads[start].index) + i)
                .count();
            if run_length > 0 {
                let lanes = start * 4..(start + run_length) * 4;
                let [r, g, b, a] = colour;
                let source = [&r[lanes.clone()], &g[lanes.clone()], &b[lanes.clone()], &a[lanes]];
                self.target.store_lanes(usize::from(quads[start].index) * 4, blend, source);
                start += run_length;
                continue;
            }
            let quad = quads[start];
            for corner in 0..4 {
                let covered = quad.coverage >> (4 * corner) & 0xf;
                if covered != 0 {
                    let lane = start * 4 + corner;
                    self.target.store(
                        usize::from(quad.index) * 4 + corner,
                        covered,
                        blend,
                        [colour[0][lane], colour[1][lane], colour[2][lane], colour[3][lane]],
                    );
                }
            }
            start += 1;
        }
    }
}
