//! Shading a tile: quads of one draw are gathered into batches, run, depth-tested and blended.
//!
//! A batch is 32 quads in the order in which they were covered. Quads of several triangles of one draw share a batch, so small triangles
//! fill the lanes as well as large ones do; a large triangle's batches are whole 16x8 blocks. Without discard and written depth
//! the depth test comes first and hidden quads are never shaded. Results leave a batch in quad order, so the order of triangles holds.

use super::exec::{ExecutionCounts, LaneMask, TextureUnit};
use super::fragment_plan::{Feed, FragmentPlan};
use super::math::Real;
use super::raster::coverage::{BLOCK_QUADS, TilePixels, full_coverage, quad_place, sample_positions, walk_tile};
use super::raster::setup::{Geometry, Plane, SUBPIXEL, Surface};
use super::stage::{LANES, LaneProgram, LaneRun};
use super::tiles::TileTarget;
use crate::render::plan::{Blend, DepthState};

const QUADS: usize = LANES / 4;

#[derive(Clone, Copy, Debug)]
struct Quad {
    /// Index inside the tile.
    place: u16,
    coverage: u16,
    surface: u32,
}

/// A draw ready for its tiles.
pub struct DrawJob<'a, R: Real> {
    pub geometry: Geometry,
    pub fragment: &'a dyn LaneProgram<R>,
    pub fragment_plan: FragmentPlan,
    pub blend: Blend,
    /// The target takes what the pixel cost in place of what it shows: the instructions that a texture read is shown as.
    pub instructions_per_read: Option<f64>,
}

/// One tile under work on one thread.
pub struct TileShader<'a> {
    pub target: &'a mut TileTarget,
    pub pixels: &'a TilePixels,
    pub tile: [u32; 2],
    pub samples: u8,
}

/// The samples of the pixels of a quad, by which of its four lanes live.
const SAMPLES_OF: [u16; 16] = {
    let mut samples = [0; 16];
    let mut living = 0;
    while living < 16 {
        let mut corner = 0;
        while corner < 4 {
            samples[living] |= if living >> corner & 1 == 1 { 0xf << (4 * corner) } else { 0 };
            corner += 1;
        }
        living += 1;
    }
    samples
};

/// Components of a colour that a program does not write: red, green and blue, and alpha.
static ABSENT: [[f32; LANES]; 2] = [[0.0; LANES], [1.0; LANES]];

/// Quads waiting for a full batch.
#[derive(Clone, Debug)]
pub struct Batch {
    quads: [Quad; QUADS],
    count: usize,
    /// Colour of the last run narrowed to f32, where the lanes are wider.
    narrowed: [[f32; LANES]; 4],
}

impl Batch {
    pub fn new() -> Self {
        Self { quads: [Quad { place: 0, coverage: 0, surface: 0 }; QUADS], count: 0, narrowed: [[0.0; LANES]; 4] }
    }
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}

/// A run with other textures.
struct ReadingRun<'a, R: Real> {
    run: &'a mut dyn LaneRun<R>,
    texture: &'a dyn TextureUnit<R>,
}

impl<R: Real> LaneRun<R> for ReadingRun<'_, R> {
    fn input(&mut self, k: usize) -> &mut [R; LANES] {
        self.run.input(k)
    }
    fn run(&mut self, active: LaneMask) -> LaneMask {
        self.run.run_reading(active, self.texture)
    }
    fn output(&self, k: usize) -> &[R; LANES] {
        self.run.output(k)
    }
    fn work(&self) -> ExecutionCounts {
        self.run.work()
    }
}

/// A plane's values at pixels that lie so far from where it has the value `at`.
#[inline(always)]
fn evaluate<R: Real>(lanes: &mut [R], [x, y]: [&[R]; 2], at: R, plane: &Plane) {
    if plane.dx == 0.0 && plane.dy == 0.0 {
        lanes.fill(at);
        return;
    }
    let (dx, dy) = (R::from_f64(plane.dx), R::from_f64(plane.dy));
    for ((lane, x), y) in lanes.iter_mut().zip(x).zip(y) {
        *lane = at + dx * *x + dy * *y;
    }
}

impl TileShader<'_> {
    /// Draws the given triangles of one draw, in order.
    pub fn draw<R: Real>(&mut self, job: &DrawJob<'_, R>, triangles: &[u32], run: &mut dyn LaneRun<R>, batch: &mut Batch) {
        let plan = &job.fragment_plan;
        for &t in triangles {
            let triangle = &job.geometry.triangles[t as usize];
            let surface = &job.geometry.surfaces[triangle.surface as usize];
            let samples = self.samples;
            let early = (plan.early && plan.uses_depth()).then(|| self.depth_at_samples(surface));
            let [tile_x, tile_y] = self.tile;
            walk_tile(triangle, tile_x, tile_y, samples, |first, count, coverage| {
                if count == QUADS && batch.count == 0 && early.is_none() {
                    self.shade_block(job, first, triangle.surface, run, batch);
                    return;
                }
                for place in first..first + count {
                    let coverage = early.as_ref().map_or(coverage, |depth| self.test_quad(place, coverage, depth, plan.depth));
                    if coverage == 0 {
                        continue;
                    }
                    batch.quads[batch.count] = Quad { place: place as u16, coverage, surface: triangle.surface };
                    batch.count += 1;
                    if batch.count == QUADS {
                        self.flush(job, run, batch, None);
                    }
                }
            });
        }
        self.flush(job, run, batch, None);
    }

    /// The depth plane relative to the tile's corner: one constant per sample, and the steps in x and y. In f64 until the sum: near a
    /// horizon the depth is a small difference of large terms.
    fn depth_at_samples(&self, surface: &Surface) -> ([f64; 4], f64, f64) {
        let corner = self.corner(surface);
        let mut at = [0.0; 4];
        for (value, [sx, sy]) in at.iter_mut().zip(sample_positions(self.samples)) {
            // Pixel positions below are centres.
            let (dx, dy) = (*sx as f64 / SUBPIXEL as f64 - 0.5, *sy as f64 / SUBPIXEL as f64 - 0.5);
            *value = surface.depth.at(corner[0] + dx, corner[1] + dy);
        }
        (at, surface.depth.dx, surface.depth.dy)
    }

    fn corner(&self, surface: &Surface) -> [f64; 2] {
        [f64::from(self.tile[0]) - surface.origin[0], f64::from(self.tile[1]) - surface.origin[1]]
    }

    fn test_quad(&mut self, place: usize, coverage: u16, depth: &([f64; 4], f64, f64), state: DepthState) -> u16 {
        let (at, dx, dy) = depth;
        let mut passed = 0;
        for corner in 0..4 {
            let covered = coverage >> (4 * corner) & 0xf;
            if covered != 0 {
                let pixel = place * 4 + corner;
                let step = dx * f64::from(self.pixels.x[pixel]) + dy * f64::from(self.pixels.y[pixel]);
                passed |= self.target.test_depth(pixel, covered, at.map(|v| (v + step) as f32), state.test, state.write) << (4 * corner);
            }
        }
        passed
    }

    /// Draws a block by a job that covers all of the target. It reads `texture` in place of those that were bound.
    pub fn map_block<R: Real>(
        &mut self,
        job: &DrawJob<'_, R>,
        block: usize,
        texture: &dyn TextureUnit<R>,
        run: &mut dyn LaneRun<R>,
        batch: &mut Batch,
    ) {
        self.shade_block(job, block * BLOCK_QUADS as usize, 0, &mut ReadingRun { run, texture }, batch);
    }

    /// Shades a wholly covered block; the batch is empty before and after.
    fn shade_block<R: Real>(&mut self, job: &DrawJob<'_, R>, first: usize, surface: u32, run: &mut dyn LaneRun<R>, batch: &mut Batch) {
        let coverage = full_coverage(self.samples);
        for (k, quad) in batch.quads.iter_mut().enumerate() {
            *quad = Quad { place: (first + k) as u16, coverage, surface };
        }
        batch.count = QUADS;
        self.flush(job, run, batch, Some(first));
    }

    /// Runs the quads that wait. `block`: they are all quads of one block, from this one on.
    fn flush<R: Real>(&mut self, job: &DrawJob<'_, R>, run: &mut dyn LaneRun<R>, batch: &mut Batch, block: Option<usize>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the instructions are there.
            return unsafe { self.flush_by_avx2(job, run, batch, block) };
        }
        self.flush_all(job, run, batch, block);
    }

    /// The same code, wider: no instruction of it rounds differently.
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn flush_by_avx2<R: Real>(&mut self, job: &DrawJob<'_, R>, run: &mut dyn LaneRun<R>, batch: &mut Batch, block: Option<usize>) {
        self.flush_all(job, run, batch, block);
    }

    #[inline(always)]
    fn flush_all<R: Real>(&mut self, job: &DrawJob<'_, R>, run: &mut dyn LaneRun<R>, batch: &mut Batch, block: Option<usize>) {
        let count = std::mem::take(&mut batch.count);
        if count == 0 {
            return;
        }
        // Unused lanes repeat the last quad, inactive: their values stay tame.
        let last = batch.quads[count - 1];
        batch.quads[count..].fill(Quad { coverage: 0, ..last });
        let quads = &batch.quads;
        // Helper lanes run with their quad, for the derivatives.
        let active = LaneMask::MAX >> (LANES - 4 * count);
        self.feed(job, run, quads, block.is_some());
        let alive = run.run(active);
        let plan = &job.fragment_plan;
        let outputs = plan.colour.map(|output| output.map(|o| run.output(o)));
        for (narrowed, values) in batch.narrowed.iter_mut().zip(&outputs) {
            if let Some(wide) = values.filter(|v| R::as_f32(&v[..]).is_none()) {
                narrowed.iter_mut().zip(wide).for_each(|(to, from)| *to = from.f64() as f32);
            }
        }
        let mut whole = block.filter(|_| plan.early);
        if !plan.early {
            if alive == 0 {
                return;
            }
            let late = plan.depth_output.map(|o| run.output(o));
            whole = block.filter(|first| alive == LaneMask::MAX && self.block_passes(plan, late, *first));
            if whole.is_none() {
                self.late(job, late, alive, &mut batch.quads[..count]);
            }
        }
        let colour = [0, 1, 2, 3].map(|k| match outputs[k] {
            Some(values) => R::as_f32(&values[..]).unwrap_or(&batch.narrowed[k]),
            None => ABSENT[usize::from(k == 3)].as_slice(),
        });
        if let Some(per_read) = job.instructions_per_read {
            let work = run.work();
            let reads = f64::from(work.texture_reads) * per_read;
            let work = [work.instructions as f32, reads as f32, 0.0, 0.0].map(|v| [v; LANES]);
            self.store(job, &batch.quads[..count], work.each_ref().map(|v| v.as_slice()));
            return;
        }
        if let Some(first) = whole
            && self.target.store_lanes(first * 4, job.blend, colour)
        {
            return;
        }
        self.store(job, &batch.quads[..count], colour);
    }

    /// Fills the lane inputs. `is_block`: the quads are those of one block, of one surface.
    #[inline(always)]
    fn feed<R: Real>(&self, job: &DrawJob<'_, R>, run: &mut dyn LaneRun<R>, quads: &[Quad; QUADS], is_block: bool) {
        // Runs of quads with one surface.
        let mut runs = [(0_usize, 0_usize, 0_u32); QUADS];
        let mut run_count = 0;
        if is_block {
            (runs[0], run_count) = ((0, QUADS, quads[0].surface), 1);
        }
        for (q, quad) in quads.iter().enumerate().skip(if is_block { QUADS } else { 0 }) {
            if run_count > 0 && runs[run_count - 1].2 == quad.surface {
                runs[run_count - 1].1 = q + 1;
            } else {
                runs[run_count] = (q, q + 1, quad.surface);
                run_count += 1;
            }
        }
        let runs = &runs[..run_count];
        // Pixel centres relative to the first quad of their run: near the triangle, where its planes round least.
        let (mut x, mut y) = ([R::ZERO; LANES], [R::ZERO; LANES]);
        for (from, to, _) in runs {
            let [x0, y0] = quad_place(quads[*from].place.into()).map(|v| v as f32);
            let at = usize::from(quads[*from].place) * 4;
            if is_block || quads[*from..*to].windows(2).all(|w| w[1].place == w[0].place + 1) {
                let (lanes, pixels) = (from * 4..to * 4, at..at + (to - from) * 4);
                for (lane, p) in x[lanes.clone()].iter_mut().zip(&self.pixels.x[pixels.clone()]) {
                    *lane = R::from_f32_bits((p - x0).to_bits());
                }
                for (lane, p) in y[lanes].iter_mut().zip(&self.pixels.y[pixels]) {
                    *lane = R::from_f32_bits((p - y0).to_bits());
                }
                continue;
            }
            for (q, quad) in quads.iter().enumerate().take(*to).skip(*from) {
                let at = usize::from(quad.place) * 4;
                for corner in 0..4 {
                    x[q * 4 + corner] = R::from_f64((self.pixels.x[at + corner] - x0).into());
                    y[q * 4 + corner] = R::from_f64((self.pixels.y[at + corner] - y0).into());
                }
            }
        }
        let run_corner = |from: usize| {
            let [qx, qy] = quad_place(quads[from].place.into());
            [f64::from(self.tile[0] + qx), f64::from(self.tile[1] + qy)]
        };
        let surfaces = &job.geometry.surfaces;
        let evaluate = |lanes: &mut [R; LANES], from: usize, to: usize, plane: &Plane, surface: &Surface| {
            let [cx, cy] = run_corner(from);
            let at = R::from_f64(plane.at(cx - surface.origin[0], cy - surface.origin[1]));
            if is_block {
                return evaluate(lanes, [&x, &y], at, plane);
            }
            evaluate(&mut lanes[from * 4..to * 4], [&x[from * 4..to * 4], &y[from * 4..to * 4]], at, plane);
        };
        let feeds = &job.fragment_plan.feeds;
        let divides =
            feeds.iter().any(|f| matches!(f, Feed::Varying { flat: false, .. })) && !runs.iter().all(|r| surfaces[r.2 as usize].affine);
        let mut w = [R::ONE; LANES];
        if divides {
            for (from, to, s) in runs {
                let surface = &surfaces[*s as usize];
                if !surface.affine {
                    evaluate(&mut w, *from, *to, &surface.inverse_w, surface);
                    w[from * 4..to * 4].iter_mut().for_each(|v| *v = R::ONE / *v);
                }
            }
        }
        for (k, feed) in feeds.iter().enumerate() {
            let lanes = run.input(k);
            for (from, to, s) in runs {
                let surface = &surfaces[*s as usize];
                match feed {
                    Feed::PixelX | Feed::PixelY => {
                        let (axis, local) = if *feed == Feed::PixelX { (0, &x) } else { (1, &y) };
                        let origin = R::from_f64(run_corner(*from)[axis]);
                        for (lane, v) in lanes[from * 4..to * 4].iter_mut().zip(&local[from * 4..to * 4]) {
                            *lane = origin + *v;
                        }
                    }
                    Feed::Depth => evaluate(lanes, *from, *to, &surface.depth, surface),
                    Feed::InverseW => evaluate(lanes, *from, *to, &surface.inverse_w, surface),
                    Feed::Varying { index, flat } => {
                        evaluate(lanes, *from, *to, &job.geometry.planes[surface.first_plane + index], surface);
                        if !flat && !surface.affine {
                            for (lane, w) in lanes[from * 4..to * 4].iter_mut().zip(&w[from * 4..to * 4]) {
                                *lane = *lane * *w;
                            }
                        }
                    }
                    Feed::FrontFacing => lanes[from * 4..to * 4].fill(R::from_mask(surface.front)),
                    Feed::Zero => lanes[from * 4..to * 4].fill(R::ZERO),
                }
            }
        }
    }

    /// Whether every sample of a block passes the depth that its lanes wrote; it is kept then. Where one does not, or the depth is the surface's own, nothing is done.
    #[inline(always)]
    fn block_passes<R: Real>(&mut self, plan: &FragmentPlan, depth: Option<&[R; LANES]>, first: usize) -> bool {
        if !plan.uses_depth() {
            return true;
        }
        let Some(values) = depth else { return false };
        let mut new = [0.0; LANES];
        for (new, value) in new.iter_mut().zip(values) {
            *new = (value.f64() as f32).clamp(0.0, 1.0);
        }
        self.target.all_pass_depth(first * 4, &new, plan.depth.test, plan.depth.write)
    }

    /// Drops dead lanes from the coverage and tests what is left.
    fn late<R: Real>(&mut self, job: &DrawJob<'_, R>, depth: Option<&[R; LANES]>, alive: LaneMask, quads: &mut [Quad]) {
        let state = job.fragment_plan.depth;
        let uses_depth = job.fragment_plan.uses_depth();
        let full = full_coverage(self.samples);
        for (q, quad) in quads.iter_mut().enumerate() {
            quad.coverage &= SAMPLES_OF[(alive >> (q * 4)) as usize & 0xf];
            if !uses_depth || quad.coverage == 0 {
                continue;
            }
            match &depth {
                Some(values) => {
                    if quad.coverage == full {
                        let new: [f32; 4] = std::array::from_fn(|corner| (values[q * 4 + corner].f64() as f32).clamp(0.0, 1.0));
                        if self.target.all_pass_depth(usize::from(quad.place) * 4, &new, state.test, state.write) {
                            continue;
                        }
                    }
                    let mut passed = 0;
                    for corner in 0..4 {
                        let covered = quad.coverage >> (4 * corner) & 0xf;
                        if covered != 0 {
                            let pixel = usize::from(quad.place) * 4 + corner;
                            // clamp leaves NaN, which passes no test.
                            let new = [(values[q * 4 + corner].f64() as f32).clamp(0.0, 1.0); 4];
                            passed |= self.target.test_depth(pixel, covered, new, state.test, state.write) << (4 * corner);
                        }
                    }
                    quad.coverage = passed;
                }
                None => {
                    let surface = &job.geometry.surfaces[quad.surface as usize];
                    let at = self.depth_at_samples(surface);
                    quad.coverage = self.test_quad(quad.place.into(), quad.coverage, &at, state);
                }
            }
        }
    }

    #[inline(always)]
    fn store<R: Real>(&mut self, job: &DrawJob<'_, R>, quads: &[Quad], colour: [&[f32]; 4]) {
        let blend = job.blend;
        let full = full_coverage(self.samples);
        let mut q = 0;
        while q < quads.len() {
            // As many fully covered neighbours as there are go in one stroke.
            let run = quads[q..]
                .iter()
                .enumerate()
                .take_while(|(i, n)| n.coverage == full && usize::from(n.place) == usize::from(quads[q].place) + i)
                .count();
            if run > 0 {
                let lanes = q * 4..(q + run) * 4;
                let source = [0, 1, 2, 3].map(|k: usize| &colour[k][lanes.clone()]);
                if self.target.store_lanes(usize::from(quads[q].place) * 4, blend, source) {
                    q += run;
                    continue;
                }
            }
            for (i, quad) in quads.iter().enumerate().skip(q).take(run.max(1)) {
                for corner in 0..4 {
                    let covered = quad.coverage >> (4 * corner) & 0xf;
                    if covered != 0 {
                        let lane = i * 4 + corner;
                        self.target.store(
                            usize::from(quad.place) * 4 + corner,
                            covered,
                            blend,
                            [0, 1, 2, 3].map(|k: usize| colour[k][lane]),
                        );
                    }
                }
            }
            q += run.max(1);
        }
    }
}
