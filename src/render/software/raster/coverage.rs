//! Which samples of a tile a triangle covers.
//!
//! A tile is 64x64 pixels, walked in blocks of 16x8, each in quads of 2x2: the lane order. Pixel `p` of a tile lies at `block * 128 +
//! quad * 4 + corner`; `TilePixels` maps that to x and y. Coverage of a quad is sixteen bits: four per pixel, one per sample (with one
//! sample only the lowest of the four is used).

use super::setup::{RasterTriangle, SUBPIXEL};

pub(crate) const TILE: u32 = 64;
/// Quads of a tile.
pub(crate) const TILE_QUADS: usize = (TILE * TILE / 4) as usize;
/// Pixels of a block.
pub(crate) const BLOCK_WIDTH: u32 = 16;
pub(crate) const BLOCK_HEIGHT: u32 = 8;
const BLOCKS_ACROSS: u32 = TILE / BLOCK_WIDTH;
const QUADS_ACROSS: u32 = BLOCK_WIDTH / 2;
/// Quads of a block.
pub(crate) const BLOCK_QUADS: u32 = BLOCK_WIDTH * BLOCK_HEIGHT / 4;
/// Pixels of a block: as many as a batch has lanes.
pub(crate) const BLOCK_PIXELS: usize = (BLOCK_WIDTH * BLOCK_HEIGHT) as usize;
/// Blocks of a tile.
pub(crate) const TILE_BLOCKS: usize = (TILE * TILE) as usize / BLOCK_PIXELS;

/// Sample positions inside a pixel: the standard 4x pattern of Vulkan, Direct3D and WebGPU, in fixed point.
const SAMPLES_4: [[i64; 2]; 4] = [[1536, 512], [3584, 1536], [512, 2560], [2560, 3584]];
const SAMPLES_1: [[i64; 2]; 1] = [[2048, 2048]];

/// Sample positions of a pixel, in fixed point.
pub(crate) fn sample_positions(samples: u8) -> &'static [[i64; 2]] {
    if samples == 4 { &SAMPLES_4 } else { &SAMPLES_1 }
}

/// The full coverage of a quad.
pub(crate) fn full_coverage(samples: u8) -> u16 {
    if samples == 4 { 0xffff } else { 0x1111 }
}

/// Top-left pixel of a quad inside its tile.
pub(crate) fn quad_position(quad: usize) -> [u32; 2] {
    let (block, inner) = (quad as u32 / BLOCK_QUADS, quad as u32 % BLOCK_QUADS);
    [block % BLOCKS_ACROSS * BLOCK_WIDTH + inner % QUADS_ACROSS * 2, block / BLOCKS_ACROSS * BLOCK_HEIGHT + inner / QUADS_ACROSS * 2]
}

/// Top-left pixel of a block inside its tile.
pub(crate) fn block_position(block: usize) -> [u32; 2] {
    quad_position(block * BLOCK_QUADS as usize)
}

/// The block of a tile whose top-left pixel is at `x`, `y`.
pub(crate) fn block_at([x, y]: [u32; 2]) -> Option<usize> {
    let is_corner = x.is_multiple_of(BLOCK_WIDTH) && y.is_multiple_of(BLOCK_HEIGHT) && x < TILE && y < TILE;
    is_corner.then(|| (y / BLOCK_HEIGHT * BLOCKS_ACROSS + x / BLOCK_WIDTH) as usize)
}

/// Whether the triangle covers every sample of a target. The right and bottom edges themselves hold no sample and need not be covered.
pub(crate) fn covers_all(triangle: &RasterTriangle, [width, height]: [u32; 2]) -> bool {
    let last = |size: u32| i64::from(size) * SUBPIXEL - 1;
    let corners = [[0, 0], [last(width), 0], [0, last(height)], [last(width), last(height)]];
    triangle.pixels == [0, 0, width, height] && triangle.edges.iter().all(|e| corners.iter().all(|[x, y]| e.a * x + e.b * y + e.c >= 0))
}

/// Pixel centres of a tile in lane order, relative to the tile's corner.
#[derive(Clone, Debug)]
pub(crate) struct TilePixels {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
}

impl TilePixels {
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

impl Default for TilePixels {
    fn default() -> Self {
        Self::new()
    }
}

/// Calls `emit(quad, count, coverage)` for the quads with a covered sample in the tile at `tile_x`, `tile_y` (pixels), in lane order: once for
/// all quads of a fully covered block, else one by one.
pub(crate) fn walk_tile(triangle: &RasterTriangle, tile_x: u32, tile_y: u32, samples: u8, mut emit: impl FnMut(usize, usize, u16)) {
    let [px0, py0, px1, py1] = triangle.pixels;
    let (x0, y0) = (px0.max(tile_x) - tile_x, py0.max(tile_y) - tile_y);
    let (x1, y1) = (px1.min(tile_x + TILE), py1.min(tile_y + TILE));
    if x1 <= tile_x || y1 <= tile_y || x0 >= TILE || y0 >= TILE {
        return;
    }
    let (x1, y1) = (x1 - tile_x, y1 - tile_y);
    for block_y in y0 / BLOCK_HEIGHT..y1.div_ceil(BLOCK_HEIGHT) {
        for block_x in x0 / BLOCK_WIDTH..x1.div_ceil(BLOCK_WIDTH) {
            let block = block_y * BLOCKS_ACROSS + block_x;
            let (bx, by) = (block_x * BLOCK_WIDTH, block_y * BLOCK_HEIGHT);
            let (least, most) = extremes(triangle, tile_x + bx, tile_y + by, BLOCK_WIDTH, BLOCK_HEIGHT);
            if most < 0 {
                continue;
            }
            let within = bx >= x0 && by >= y0 && bx + BLOCK_WIDTH <= x1 && by + BLOCK_HEIGHT <= y1;
            let first = (block * BLOCK_QUADS) as usize;
            if least >= 0 && within {
                emit(first, BLOCK_QUADS as usize, full_coverage(samples));
                continue;
            }
            for inner in 0..BLOCK_QUADS {
                let (qx, qy) = (bx + inner % QUADS_ACROSS * 2, by + inner / QUADS_ACROSS * 2);
                if qx + 2 <= x0 || qy + 2 <= y0 || qx >= x1 || qy >= y1 {
                    continue;
                }
                let mut coverage = quad_coverage(triangle, tile_x + qx, tile_y + qy, samples);
                for (corner, (dx, dy)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
                    let (x, y) = (qx + dx, qy + dy);
                    if x < x0 || y < y0 || x >= x1 || y >= y1 {
                        coverage &= !(0xf << (4 * corner));
                    }
                }
                if coverage != 0 {
                    emit(first + inner as usize, 1, coverage);
                }
            }
        }
    }
}

/// Bounds of the three edge functions over a rectangle of pixels: (smallest of the three minima, smallest of the three maxima).
/// A negative second value means that nothing is covered, a first value of zero or more that everything is.
fn extremes(triangle: &RasterTriangle, x: u32, y: u32, width: u32, height: u32) -> (i64, i64) {
    let (x, y) = (i64::from(x) * SUBPIXEL, i64::from(y) * SUBPIXEL);
    let (w, h) = (i64::from(width) * SUBPIXEL, i64::from(height) * SUBPIXEL);
    let (mut least, mut most) = (i64::MAX, i64::MAX);
    for e in &triangle.edges {
        let corner = e.a * x + e.b * y + e.c;
        let (across, down) = (e.a * w, e.b * h);
        least = least.min(corner + across.min(0) + down.min(0));
        most = most.min(corner + across.max(0) + down.max(0));
    }
    (least, most)
}

fn quad_coverage(triangle: &RasterTriangle, x: u32, y: u32, samples: u8) -> u16 {
    let (least, most) = extremes(triangle, x, y, 2, 2);
    if most < 0 {
        return 0;
    }
    if least >= 0 {
        return full_coverage(samples);
    }
    let mut coverage = 0;
    for corner in 0..4_u32 {
        let px = i64::from(x + (corner & 1)) * SUBPIXEL;
        let py = i64::from(y + (corner >> 1)) * SUBPIXEL;
        for (s, [sx, sy]) in sample_positions(samples).iter().enumerate() {
            if triangle.edges.iter().all(|e| e.a * (px + sx) + e.b * (py + sy) + e.c >= 0) {
                coverage |= 1 << (4 * corner as usize + s);
            }
        }
    }
    coverage
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_a_tile_has_one_place() {
        let pixels = TilePixels::new();
        let mut seen = vec![false; (TILE * TILE) as usize];
        for (x, y) in pixels.x.iter().zip(&pixels.y) {
            let at = (*y as u32 * TILE + *x as u32) as usize;
            assert!(!seen[at]);
            seen[at] = true;
        }
        assert!(seen.iter().all(|s| *s));
        for block in 0..TILE_BLOCKS {
            let [x, y] = block_position(block);
            assert_eq!((pixels.x[block * BLOCK_PIXELS], pixels.y[block * BLOCK_PIXELS]), (x as f32 + 0.5, y as f32 + 0.5));
            assert_eq!((block_at([x, y]), block_at([x + 2, y]), block_at([x, y + TILE])), (Some(block), None, None));
        }
    }
}
