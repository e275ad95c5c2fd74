//! Determines which samples of a tile a triangle covers.
//!
//! In: a triangle in fixed point, and a tile. Out: the covered quads, each with its covered samples, in lane order.
//!
//! A tile is 64x64 pixels, divided into blocks of 16x8 pixels, and these into quads of 2x2. Lane order goes through blocks, quads and the quad's pixels (its
//! `corner`: top left, top right, bottom left, bottom right). The index of a pixel in its tile is `block * 128 + quad * 4 + corner`; `PixelCentres` maps it to
//! x and y. The coverage of a quad is sixteen bits: four per pixel, one per sample. With one sample per pixel, only the lowest of the four is used.

use super::setup::{RasterTriangle, STEPS_PER_PIXEL};

/// Width and height of a tile in pixels.
pub(crate) const TILE_SIDE_PX: u32 = 64;
/// Number of pixels in a tile.
pub(crate) const TILE_PIXELS: usize = (TILE_SIDE_PX * TILE_SIDE_PX) as usize;
/// Number of quads in a tile.
pub(crate) const TILE_QUADS: usize = TILE_PIXELS / 4;
/// Width and height of a block in pixels.
pub(crate) const BLOCK_WIDTH: u32 = 16;
pub(crate) const BLOCK_HEIGHT: u32 = 8;
const BLOCKS_ACROSS: u32 = TILE_SIDE_PX / BLOCK_WIDTH;
const QUADS_ACROSS: u32 = BLOCK_WIDTH / 2;
/// Number of quads in a block.
pub(crate) const BLOCK_QUADS: u32 = BLOCK_WIDTH * BLOCK_HEIGHT / 4;
/// Number of pixels in a block, equal to the number of lanes in a batch.
pub(crate) const BLOCK_PIXELS: usize = (BLOCK_WIDTH * BLOCK_HEIGHT) as usize;
/// Number of blocks in a tile.
pub(crate) const TILE_BLOCKS: usize = TILE_PIXELS / BLOCK_PIXELS;

/// Sample positions inside a pixel: the standard 4x pattern of Vulkan, Direct3D and WebGPU, in fixed point ([`STEPS_PER_PIXEL`]).
const SAMPLES_4: [[i64; 2]; 4] = [[1536, 512], [3584, 1536], [512, 2560], [2560, 3584]];
/// The pixel's centre.
const SAMPLES_1: [[i64; 2]; 1] = [[2048, 2048]];

/// Sample positions relative to a pixel's top-left corner, in fixed point. `samples`: their number per pixel, 1 or 4.
pub(crate) fn sample_positions(samples: u8) -> &'static [[i64; 2]] {
    if samples == 4 { &SAMPLES_4 } else { &SAMPLES_1 }
}

/// The coverage of a quad whose samples are all covered. `samples`: their number per pixel, 1 or 4.
pub(crate) fn full_coverage(samples: u8) -> u16 {
    if samples == 4 { 0xffff } else { 0x1111 }
}

/// Top-left pixel of a quad inside its tile.
pub(crate) fn quad_position(quad: usize) -> [u32; 2] {
    let (block, index) = (quad as u32 / BLOCK_QUADS, quad as u32 % BLOCK_QUADS);
    [block % BLOCKS_ACROSS * BLOCK_WIDTH + index % QUADS_ACROSS * 2, block / BLOCKS_ACROSS * BLOCK_HEIGHT + index / QUADS_ACROSS * 2]
}

/// Top-left pixel of a block inside its tile.
pub(crate) fn block_position(block: usize) -> [u32; 2] {
    quad_position(block * BLOCK_QUADS as usize)
}

/// The block whose top-left pixel is at `x`, `y` inside its tile; `None` if there is none.
pub(crate) fn block_at([x, y]: [u32; 2]) -> Option<usize> {
    let is_block_corner = x.is_multiple_of(BLOCK_WIDTH) && y.is_multiple_of(BLOCK_HEIGHT) && x < TILE_SIDE_PX && y < TILE_SIDE_PX;
    is_block_corner.then(|| (y / BLOCK_HEIGHT * BLOCKS_ACROSS + x / BLOCK_WIDTH) as usize)
}

/// Whether the triangle covers every sample of a target. The target's right and bottom edges contain no sample and need not be covered.
pub(crate) fn covers_all(triangle: &RasterTriangle, [width, height]: [u32; 2]) -> bool {
    let last = |size: u32| i64::from(size) * STEPS_PER_PIXEL - 1;
    let corners = [[0, 0], [last(width), 0], [0, last(height)], [last(width), last(height)]];
    triangle.bounds_px == [0, 0, width, height] && triangle.edges.iter().all(|e| corners.iter().all(|[x, y]| e.a * x + e.b * y + e.c >= 0))
}

/// Whether the triangle covers every sample of a rectangle, given by left, top, right and bottom edge (the last two exclusive).
pub(crate) fn covers_rectangle(triangle: &RasterTriangle, [x0, y0, x1, y1]: [u32; 4]) -> bool {
    let [left, top, right, bottom] = triangle.bounds_px;
    let is_inside_bounds = left <= x0 && top <= y0 && x1 <= right && y1 <= bottom;
    if !is_inside_bounds {
        return false;
    }
    let (lower, _) = edge_function_bounds(triangle, x0, y0, x1 - x0, y1 - y0);
    lower >= 0
}

/// Pixel centres of a tile in lane order, relative to the tile's top-left corner.
#[derive(Clone, Debug)]
pub(crate) struct PixelCentres {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
}

impl PixelCentres {
    pub(crate) fn new() -> Self {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for quad in 0..TILE_QUADS {
            let [qx, qy] = quad_position(quad);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                x.push((qx + dx) as f32 + 0.5);
                y.push((qy + dy) as f32 + 0.5);
            }
        }
        Self { x, y }
    }
}

impl Default for PixelCentres {
    fn default() -> Self {
        Self::new()
    }
}

/// Calls `emit(first quad, number of quads, coverage)` for the quads with a covered sample in the tile at `tile_x`, `tile_y` (pixels), in lane order: once
/// for all quads of a fully covered block, otherwise once per quad. `samples`: their number per pixel, 1 or 4.
pub(crate) fn walk_tile(triangle: &RasterTriangle, tile_x: u32, tile_y: u32, samples: u8, mut emit: impl FnMut(usize, usize, u16)) {
    let [left, top, right, bottom] = triangle.bounds_px;
    // The part of the triangle's bounds in this tile, relative to the tile.
    let (x0, y0) = (left.max(tile_x) - tile_x, top.max(tile_y) - tile_y);
    let (x1, y1) = (right.min(tile_x + TILE_SIDE_PX), bottom.min(tile_y + TILE_SIDE_PX));
    if x1 <= tile_x || y1 <= tile_y || x0 >= TILE_SIDE_PX || y0 >= TILE_SIDE_PX {
        return;
    }
    let (x1, y1) = (x1 - tile_x, y1 - tile_y);
    let block_coverage = BlockCoverage::new(triangle, samples);
    for block_y in y0 / BLOCK_HEIGHT..y1.div_ceil(BLOCK_HEIGHT) {
        for block_x in x0 / BLOCK_WIDTH..x1.div_ceil(BLOCK_WIDTH) {
            let block = block_y * BLOCKS_ACROSS + block_x;
            let (bx, by) = (block_x * BLOCK_WIDTH, block_y * BLOCK_HEIGHT);
            let (lower, upper) = edge_function_bounds(triangle, tile_x + bx, tile_y + by, BLOCK_WIDTH, BLOCK_HEIGHT);
            if upper < 0 {
                continue;
            }
            let is_inside_bounds = bx >= x0 && by >= y0 && bx + BLOCK_WIDTH <= x1 && by + BLOCK_HEIGHT <= y1;
            let first = (block * BLOCK_QUADS) as usize;
            if lower >= 0 && is_inside_bounds {
                emit(first, BLOCK_QUADS as usize, full_coverage(samples));
                continue;
            }
            let clip = [x0.max(bx) - bx, y0.max(by) - by, x1.min(bx + BLOCK_WIDTH) - bx, y1.min(by + BLOCK_HEIGHT) - by];
            let found = block_coverage.quads(triangle, tile_x + bx, tile_y + by, clip);
            for (index, coverage) in found.index.iter().zip(&found.coverage).take(found.count) {
                emit(first + usize::from(*index), 1, *coverage);
            }
        }
    }
}

/// Bounds of the three edge functions over a rectangle of pixels: (smallest of the three minima, smallest of the three maxima).
/// If the second value is negative, nothing is covered; if the first value is not negative, everything is.
fn edge_function_bounds(triangle: &RasterTriangle, x: u32, y: u32, width: u32, height: u32) -> (i64, i64) {
    let (x, y) = (i64::from(x) * STEPS_PER_PIXEL, i64::from(y) * STEPS_PER_PIXEL);
    let (w, h) = (i64::from(width) * STEPS_PER_PIXEL, i64::from(height) * STEPS_PER_PIXEL);
    let (mut lower, mut upper) = (i64::MAX, i64::MAX);
    for e in &triangle.edges {
        let corner = e.a * x + e.b * y + e.c;
        let (across, down) = (e.a * w, e.b * h);
        lower = lower.min(corner + across.min(0) + down.min(0));
        upper = upper.min(corner + across.max(0) + down.max(0));
    }
    (lower, upper)
}

/// The quads of a block with a covered sample, in lane order.
struct CoveredQuads {
    /// Number of entries of the two arrays that are in use.
    count: usize,
    /// Index of each quad in the block.
    index: [u8; BLOCK_QUADS as usize],
    coverage: [u16; BLOCK_QUADS as usize],
}

/// A triangle's edge functions at the samples of a quad, relative to their values at the quad's top-left corner. `N`: number of samples in a quad.
struct QuadSamples<const N: usize> {
    /// Per edge, the values at the samples.
    edge_values: [[i64; N]; 3],
    /// Per edge, the greatest of these values.
    max_at_samples: [i64; 3],
    /// Per edge, the differences to the next quad in x and in y.
    step: [[i64; 2]; 3],
}

impl<const N: usize> QuadSamples<N> {
    /// For a small triangle this takes as long as the coverage tests that follow. Therefore it multiplies once per sample position in a pixel instead of
    /// once per sample of the quad, and is inlined, so that the result is not copied.
    #[inline(always)]
    fn new(triangle: &RasterTriangle) -> Self {
        let positions = sample_positions((N / 4) as u8);
        let mut samples = Self { edge_values: [[0; N]; 3], max_at_samples: [0; 3], step: [[0; 2]; 3] };
        for (k, e) in triangle.edges.iter().enumerate() {
            let (right, down) = (e.a * STEPS_PER_PIXEL, e.b * STEPS_PER_PIXEL);
            let mut max_in_pixel = i64::MIN;
            for (s, [sx, sy]) in positions.iter().enumerate() {
                let in_pixel = e.a * sx + e.b * sy;
                max_in_pixel = max_in_pixel.max(in_pixel);
                for (corner, at_corner) in [0, right, down, right + down].into_iter().enumerate() {
                    samples.edge_values[k][corner * (N / 4) + s] = at_corner + in_pixel;
                }
            }
            samples.max_at_samples[k] = max_in_pixel + right.max(0) + down.max(0);
            samples.step[k] = [2 * right, 2 * down];
        }
        samples
    }

    /// Coverage of a quad, given the values of the three edge functions at its top-left corner.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "loops by index over several arrays of one length are what the compiler vectorises")]
    fn coverage(&self, at_corner: [i64; 3]) -> u16 {
        let [a, b, c] = &self.edge_values;
        const { assert!(N == 4 || N == 16) };
        // The additions wrap, because overflow checks would keep the loop from being vectorised in debug builds.
        let mut coverage = 0;
        for k in 0..N {
            // The sign bit is set if the sample lies outside an edge.
            let signs = at_corner[0].wrapping_add(a[k]) | at_corner[1].wrapping_add(b[k]) | at_corner[2].wrapping_add(c[k]);
            coverage |= if signs >= 0 { SAMPLE_BITS[k * (16 / N)] } else { 0 };
        }
        coverage
    }

    /// The covered quads of a block at `x`, `y` (pixels) of the target. `clip`: the part of the block that may be covered, as
    /// [`RasterTriangle::bounds_px`], relative to the block.
    #[inline(always)]
    fn covered(&self, triangle: &RasterTriangle, x: u32, y: u32, [x0, y0, x1, y1]: [u32; 4]) -> CoveredQuads {
        let mut found = CoveredQuads { count: 0, index: [0; BLOCK_QUADS as usize], coverage: [0; BLOCK_QUADS as usize] };
        let (x, y) = (i64::from(x) * STEPS_PER_PIXEL, i64::from(y) * STEPS_PER_PIXEL);
        let edge_values_at_block = triangle.edges.each_ref().map(|e| e.a * x + e.b * y + e.c);
        for row in y0 / 2..y1.div_ceil(2) {
            let bits_in_rows = coverage_within(row * 2, y0, y1, LOWER_ROW);
            for column in x0 / 2..x1.div_ceil(2) {
                let (across, down) = (i64::from(column), i64::from(row));
                let edge_value = |k: usize| edge_values_at_block[k] + self.step[k][0] * across + self.step[k][1] * down;
                let at_corner = [edge_value(0), edge_value(1), edge_value(2)];
                // Skips the quad if all its samples lie outside one edge.
                let [a, b, c] = self.max_at_samples;
                if (at_corner[0] + a) | (at_corner[1] + b) | (at_corner[2] + c) < 0 {
                    continue;
                }
                let coverage = self.coverage(at_corner) & bits_in_rows & coverage_within(column * 2, x0, x1, RIGHT_COLUMN);
                // There is room for every quad of a block, so `get_mut` always returns a place.
                if let (true, Some(index), Some(quad_coverage)) =
                    (coverage != 0, found.index.get_mut(found.count), found.coverage.get_mut(found.count))
                {
                    (*index, *quad_coverage) = ((row * QUADS_ACROSS + column) as u8, coverage);
                    found.count += 1;
                }
            }
        }
        found
    }

    /// [`QuadSamples::covered`] compiled for AVX2.
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn covered_avx2(&self, triangle: &RasterTriangle, x: u32, y: u32, clip: [u32; 4]) -> CoveredQuads {
        self.covered(triangle, x, y, clip)
    }
}

/// Coverage bits of the lower two pixels of a quad, and of the right two.
const LOWER_ROW: u16 = 0xff00;
const RIGHT_COLUMN: u16 = 0xf0f0;

/// The coverage bits of a quad's pixels that lie in `start..end` along one axis. `first`: coordinate of the quad's first pixels along the axis;
/// `second_half`: the bits of its second pixels.
#[inline(always)]
fn coverage_within(first: u32, start: u32, end: u32, second_half: u16) -> u16 {
    (if first < start { second_half } else { u16::MAX }) & (if first + 1 >= end { !second_half } else { u16::MAX })
}

/// The single bits of a quad's coverage. Loops that select from a table are vectorised; loops that shift are not.
const SAMPLE_BITS: [u16; 16] = {
    let mut bits = [0; 16];
    let mut k = 0;
    while k < 16 {
        bits[k] = 1 << k;
        k += 1;
    }
    bits
};

/// Computes the coverage of the partly covered blocks of one triangle.
#[allow(clippy::large_enum_variant, reason = "on the stack, one per triangle and tile")]
enum BlockCoverage {
    SingleSample(QuadSamples<4>),
    FourSamples(QuadSamples<16>),
}

impl BlockCoverage {
    #[inline(always)]
    fn new(triangle: &RasterTriangle, samples: u8) -> Self {
        if samples == 4 { Self::FourSamples(QuadSamples::new(triangle)) } else { Self::SingleSample(QuadSamples::new(triangle)) }
    }

    /// As [`QuadSamples::covered`].
    fn quads(&self, triangle: &RasterTriangle, x: u32, y: u32, clip: [u32; 4]) -> CoveredQuads {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe {
                match self {
                    Self::SingleSample(samples) => samples.covered_avx2(triangle, x, y, clip),
                    Self::FourSamples(samples) => samples.covered_avx2(triangle, x, y, clip),
                }
            };
        }
        match self {
            Self::SingleSample(samples) => samples.covered(triangle, x, y, clip),
            Self::FourSamples(samples) => samples.covered(triangle, x, y, clip),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lane_order_visits_every_pixel_of_a_tile_once() {
        let pixels = PixelCentres::new();
        let mut seen = vec![false; (TILE_SIDE_PX * TILE_SIDE_PX) as usize];
        for (x, y) in pixels.x.iter().zip(&pixels.y) {
            let index = (*y as u32 * TILE_SIDE_PX + *x as u32) as usize;
            assert!(!seen[index]);
            seen[index] = true;
        }
        assert!(seen.iter().all(|s| *s));
        for block in 0..TILE_BLOCKS {
            let [x, y] = block_position(block);
            assert_eq!((pixels.x[block * BLOCK_PIXELS], pixels.y[block * BLOCK_PIXELS]), (x as f32 + 0.5, y as f32 + 0.5));
            assert_eq!((block_at([x, y]), block_at([x + 2, y]), block_at([x, y + TILE_SIDE_PX])), (Some(block), None, None));
        }
    }

    /// A pseudorandom number below `n` (Knuth's linear congruential generator).
    fn random(seed: &mut u64, n: u64) -> i64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((*seed >> 33) % n) as i64
    }

    /// Compares each sample of each pixel with the edge functions, for triangles of all sizes that span several tiles or are cut by a scissor.
    #[test]
    fn quads_are_covered_where_their_samples_lie_inside() {
        let (mut seed, mut partly_covered_count) = (1, 0);
        for round in 0..400_u32 {
            let size_px = [3_i64, 12, 60, 200][round as usize % 4];
            let corner = |seed: &mut u64| {
                let size = size_px * STEPS_PER_PIXEL;
                [100 * STEPS_PER_PIXEL, 90 * STEPS_PER_PIXEL].map(|middle| middle + random(seed, size as u64) - size / 2)
            };
            let p = [corner(&mut seed), corner(&mut seed), corner(&mut seed)];
            let edge = |a: [i64; 2], b: [i64; 2]| {
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                super::super::setup::EdgeFunction { a: -dy, b: dx, c: dy * a[0] - dx * a[1] }
            };
            let bounds_px = if round % 3 == 0 { [97, 89, 131, 90] } else { [0, 0, 191, 200] };
            let triangle = RasterTriangle { edges: [edge(p[0], p[1]), edge(p[1], p[2]), edge(p[2], p[0])], bounds_px, source_triangle: 0 };
            for samples in [1, 4] {
                for (tile_x, tile_y) in [(64, 64), (128, 64), (0, 64)] {
                    let mut found = vec![0_u16; TILE_QUADS];
                    walk_tile(&triangle, tile_x, tile_y, samples, |first, count, coverage| found[first..first + count].fill(coverage));
                    for (quad, found) in found.iter().enumerate() {
                        let [x, y] = quad_position(quad);
                        let mut expected = 0;
                        for (corner, (dx, dy)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                            let (x, y) = (tile_x + x + dx, tile_y + y + dy);
                            for (s, [sx, sy]) in sample_positions(samples).iter().enumerate() {
                                let at = |e: &super::super::setup::EdgeFunction| {
                                    e.a * (i64::from(x) * STEPS_PER_PIXEL + sx) + e.b * (i64::from(y) * STEPS_PER_PIXEL + sy) + e.c
                                };
                                let inside = (bounds_px[0]..bounds_px[2]).contains(&x) && (bounds_px[1]..bounds_px[3]).contains(&y);
                                if inside && triangle.edges.iter().all(|e| at(e) >= 0) {
                                    expected |= 1 << (4 * corner + s);
                                }
                            }
                        }
                        partly_covered_count += u32::from(expected != 0 && expected != full_coverage(samples));
                        assert_eq!(*found, expected, "round {round}, {samples} samples, tile {tile_x}, quad {quad}");
                    }
                }
            }
        }
        assert!(partly_covered_count > 1000, "only {partly_covered_count} quads were partly covered");
    }
}
