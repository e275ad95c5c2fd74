//! Shades smooth light at the middle of every 4x4 pixels and interpolates between these points.
//!
//! In: a draw that permits it ([`ShadingRate::Interpolated`](crate::render::plan::ShadingRate)), and its only triangle in the tile. Out: its light, added
//! to each half of the tile (64x32 pixels, which one batch of 128 points spans) that the triangle covers. Always: the error is at most about a 500th of
//! the draw's own light (a quarter of an 8-bit display level at white, less in the dark), because the second differences between points are bounded. Where
//! they exceed the bound, as near the Sun and where the light ends, nothing is drawn here, and the caller shades every pixel. Not here: which draws permit it
//! (scene); the coarse image of the air (`air-pass`), which passes of its own compute.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::exec::LaneMask;
use super::lane_inputs;
use super::math::Real;
use super::prepared_draw::{PreparedDraw, QUADS_PER_BATCH, Quad};
use super::raster::coverage::{BLOCK_PIXELS, PixelCentres, TILE_BLOCKS, TILE_SIDE_PX, block_position, covers_rectangle};
use super::stage::{LANES, LaneRun};
use super::tiles::TileTarget;

/// Distance between neighbouring points, in pixels.
const SPACING: usize = 4;
/// Columns and rows of the points of one batch. The points have the layout of a block's pixels (16x8), enlarged by `SPACING`: a pixel's centre (0.5) becomes
/// the middle of 4 pixels (2.0).
const COLUMNS: usize = 16;
const ROWS: usize = 8;
const _: () = assert!(COLUMNS * ROWS == LANES && LANES == BLOCK_PIXELS && COLUMNS * SPACING == TILE_SIDE_PX as usize);
/// Quads across half a tile (64x32 pixels), and lanes in one row of quads.
const QUADS_ACROSS: usize = COLUMNS * SPACING / 2;
const ROW_LANES: usize = 4 * QUADS_ACROSS;
/// Rows of quads in half a tile and in a block, and lanes in one row of a block's quads.
const QUAD_ROWS: usize = ROWS * SPACING / 2;
const QUAD_ROWS_OF_BLOCK: usize = 4;
const BLOCK_ROW_LANES: usize = BLOCK_PIXELS / QUAD_ROWS_OF_BLOCK;
/// Blocks in one row of half a tile, and in half a tile.
const BLOCKS_ACROSS: usize = ROW_LANES / BLOCK_ROW_LANES;
const HALF_TILE_BLOCKS: usize = BLOCKS_ACROSS * QUAD_ROWS / QUAD_ROWS_OF_BLOCK;

/// Second difference of the light at three neighbouring points, relative to the light at the middle one, above which every pixel is shaded. A linear function
/// through two points departs from a parabola by t (t - 1) / 2 of the second difference, where t is 0 at the first point and 1 at the second: by at most 0.258
/// of this difference, at the outermost pixels, where t is 1.375. The sum over both axes is 0.516 / 256, about a 500th.
const SMOOTH_DIFFERENCE: f32 = 1.0 / 256.0;

/// One colour component at the points, row by row.
type Grid = [[f32; COLUMNS]; ROWS];
/// One component, interpolated along the rows of points: for each row of points, the values at the 64 columns of pixels, in the lane order of a row of quads.
/// So each value is stored twice, for the upper and the lower pixel of a quad.
type InterpolatedRows = [[f32; ROW_LANES]; ROWS];

/// The cell (the interval between two neighbouring points) in which a quad lies along an axis with `point_count` points, as the index of the cell's first
/// point. Quads beyond the outer points use the outermost cells.
const fn cell_of_quad(quad: usize, point_count: usize) -> usize {
    let cell = quad.saturating_sub(1) / (SPACING / 2);
    if cell < point_count - 2 { cell } else { point_count - 2 }
}

/// Position of a pixel's centre in its cell: 0 at the cell's first point, 1 at its second.
const fn position_in_cell(pixel: usize, point_count: usize) -> f32 {
    // Both positions are in half pixels: the centre of a pixel is at 2 * pixel + 1.
    let first_point = (2 * cell_of_quad(pixel / 2, point_count) + 1) * SPACING;
    ((2 * pixel + 1) as f32 - first_point as f32) / (2 * SPACING) as f32
}

/// For the pixels of a row of quads, in lane order from column `first` on: the horizontal position of each in its cell.
const fn horizontal_positions<const N: usize>(first: usize) -> [f32; N] {
    let mut positions = [0.0; N];
    let mut lane = 0;
    while lane < N {
        positions[lane] = position_in_cell(first + lane / 4 * 2 + lane % 2, COLUMNS);
        lane += 1;
    }
    positions
}
/// The horizontal position of each pixel in its cell: for a row's first quad, for the two quads between any two neighbouring points, and for the last quad.
static FIRST_QUAD_POSITIONS: [f32; 4] = horizontal_positions(0);
static QUAD_PAIR_POSITIONS: [f32; 8] = horizontal_positions(2);
static LAST_QUAD_POSITIONS: [f32; 4] = horizontal_positions(COLUMNS * SPACING - 2);

/// For each row of quads, and in it for each lane of a block, the pixel's vertical position in its cell.
static VERTICAL_POSITIONS: [[f32; BLOCK_ROW_LANES]; QUAD_ROWS] = {
    let mut positions = [[0.0; BLOCK_ROW_LANES]; QUAD_ROWS];
    let mut k = 0;
    while k < QUAD_ROWS * BLOCK_ROW_LANES {
        let (row, lane) = (k / BLOCK_ROW_LANES, k % BLOCK_ROW_LANES);
        positions[row][lane] = position_in_cell(2 * row + lane % 4 / 2, ROWS);
        k += 1;
    }
    positions
};

/// Reorders the points from lane order to rows.
#[inline(always)]
fn grid(lanes: &[f32; LANES]) -> Grid {
    let mut grid = [[0.0; COLUMNS]; ROWS];
    for (rows, quads) in grid.as_chunks_mut::<2>().0.iter_mut().zip(lanes.as_chunks::<{ 2 * COLUMNS }>().0) {
        for (k, quad) in quads.as_chunks::<4>().0.iter().enumerate() {
            for corner in 0..4 {
                rows[corner / 2][2 * k + corner % 2] = quad[corner];
            }
        }
    }
    grid
}

/// Whether the light may be interpolated; false if a value is NaN. The loops have no early exit, so that the compiler vectorises them.
#[inline(always)]
fn is_smooth(grid: &Grid) -> bool {
    let is_straight = |previous: f32, middle: f32, next: f32| (previous - 2.0 * middle + next).abs() <= SMOOTH_DIFFERENCE * middle;
    let mut all = true;
    for row in grid {
        for c in 1..COLUMNS - 1 {
            all &= is_straight(row[c - 1], row[c], row[c + 1]);
        }
    }
    for r in 1..ROWS - 1 {
        for c in 0..COLUMNS {
            all &= is_straight(grid[r - 1][c], grid[r][c], grid[r + 1][c]);
        }
    }
    all
}

/// Linear interpolation in `N` lanes, between the values at a cell's first and second point, at each lane's position in the cell. The values are returned
/// and not stored one by one, so that the compiler uses vectors.
#[inline(always)]
fn lerp<const N: usize>(from: [f32; N], to: [f32; N], position: &[f32; N]) -> [f32; N] {
    let mut values = [0.0; N];
    for i in 0..N {
        values[i] = from[i] + (to[i] - from[i]) * position[i];
    }
    values
}

/// Interpolates along the rows of points, to the columns of pixels.
#[inline(always)]
fn interpolate_rows(grid: &Grid, rows: &mut InterpolatedRows) {
    for (points, lanes) in grid.iter().zip(rows) {
        // The first quad and the last are outside the outer points. Between two points there are two quads.
        let (first_quad, other_quads) = lanes.split_at_mut(4);
        let (pairs, last_quad) = other_quads.as_chunks_mut::<8>();
        let cell_values = |cell: usize| [points[cell], points[cell + 1]];
        for (cell, pair) in pairs.iter_mut().enumerate() {
            let [from, to] = cell_values(cell);
            *pair = lerp([from; 8], [to; 8], &QUAD_PAIR_POSITIONS);
        }
        for (quad, cell, position) in [(first_quad, 0, FIRST_QUAD_POSITIONS), (last_quad, COLUMNS - 2, LAST_QUAD_POSITIONS)] {
            let [from, to] = cell_values(cell);
            quad.copy_from_slice(&lerp([from; 4], [to; 4], &position));
        }
    }
}

/// Interpolates between rows of points: fills the lanes of the block whose first row of quads is `first_quad_row`. `block_column`: number of blocks to its
/// left.
#[inline(always)]
fn fill_block_lanes(rows: &InterpolatedRows, block_column: usize, first_quad_row: usize, lanes: &mut [f32; BLOCK_PIXELS]) {
    for (row, lanes) in lanes.as_chunks_mut::<BLOCK_ROW_LANES>().0.iter_mut().enumerate() {
        let quad_row = first_quad_row + row;
        let cell = cell_of_quad(quad_row, ROWS);
        let at_points = |point_row: usize| &rows[point_row].as_chunks::<BLOCK_ROW_LANES>().0[block_column];
        *lanes = lerp(*at_points(cell), *at_points(cell + 1), &VERTICAL_POSITIONS[quad_row]);
    }
}

/// Components of the light of half a tile, interpolated along the rows of points. A thread reuses its memory.
#[derive(Clone, Debug)]
pub(super) struct InterpolatedLight {
    rows: [InterpolatedRows; 3],
    /// Index in `rows` and `block_buffers` of the values of red, of green and of blue. A component equal to red has the index of red, and is not interpolated
    /// again.
    source: [usize; 3],
    /// Buffers for one block of each component.
    block_buffers: [[f32; BLOCK_PIXELS]; 3],
}

impl InterpolatedLight {
    pub(super) fn new() -> Self {
        Self { rows: [[[0.0; ROW_LANES]; ROWS]; 3], source: [0, 1, 2], block_buffers: [[0.0; BLOCK_PIXELS]; 3] }
    }

    /// Interpolates the light at the points along their rows. Returns false if the light is not smooth.
    #[inline(always)]
    fn interpolate(&mut self, light: [&[f32; LANES]; 3]) -> bool {
        let has_equal_bits = |a: usize, b: usize| (0..LANES).fold(0, |bits, i| bits | (light[a][i].to_bits() ^ light[b][i].to_bits())) == 0;
        self.source = [0, if has_equal_bits(0, 1) { 0 } else { 1 }, if has_equal_bits(0, 2) { 0 } else { 2 }];
        for k in 0..3 {
            if self.source[k] == k {
                let grid = grid(light[k]);
                if !is_smooth(&grid) {
                    return false;
                }
                interpolate_rows(&grid, &mut self.rows[k]);
            }
        }
        true
    }

    /// Red, green and blue of a block of the half tile, in lane order.
    #[inline(always)]
    fn block(&mut self, block: usize) -> [&[f32; BLOCK_PIXELS]; 3] {
        for k in 0..3 {
            if self.source[k] == k {
                let first_quad_row = block / BLOCKS_ACROSS * QUAD_ROWS_OF_BLOCK;
                fill_block_lanes(&self.rows[k], block % BLOCKS_ACROSS, first_quad_row, &mut self.block_buffers[k]);
            }
        }
        let [r, g, b] = self.source;
        [&self.block_buffers[r], &self.block_buffers[g], &self.block_buffers[b]]
    }

    /// Shades the points of half a tile and adds the light to its blocks. `first_quad`: that of the half. Returns false, and draws nothing, if the light is
    /// not smooth.
    fn draw<R: Real>(&mut self, draw: &PreparedDraw<'_, R>, run: &mut dyn LaneRun<R>, first_quad: Quad, tile: &mut Tile<'_>) -> bool {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 was detected.
            return unsafe { self.draw_avx2(draw, run, first_quad, tile) };
        }
        self.draw_generic(draw, run, first_quad, tile)
    }

    /// [`Self::draw_generic`] compiled for AVX2: wider vectors, the same rounding.
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn draw_avx2<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        run: &mut dyn LaneRun<R>,
        first_quad: Quad,
        tile: &mut Tile<'_>,
    ) -> bool {
        self.draw_generic(draw, run, first_quad, tile)
    }

    #[inline(always)]
    fn draw_generic<R: Real>(
        &mut self,
        draw: &PreparedDraw<'_, R>,
        run: &mut dyn LaneRun<R>,
        first_quad: Quad,
        tile: &mut Tile<'_>,
    ) -> bool {
        let mut point_positions = [[0.0; LANES]; 2];
        for (positions, centres) in point_positions.iter_mut().zip([&tile.pixel_centres.x, &tile.pixel_centres.y]) {
            for (position, centre) in positions.iter_mut().zip(centres) {
                *position = centre * SPACING as f32;
            }
        }
        let [x, y] = &point_positions;
        lane_inputs::fill_block(draw, run, first_quad, [x, y], tile.corner);
        // A discarded point ends the light, which therefore is not smooth.
        if run.run(LaneMask::MAX) != LaneMask::MAX {
            return false;
        }
        let run = &*run;
        let lanes = draw.fragment_setup.colour_outputs.map(|o| o.and_then(|o| R::as_f32(run.output(o))?.first_chunk::<LANES>()));
        let [Some(r), Some(g), Some(b), Some(a)] = lanes else { return false };
        // Only red, green and blue are interpolated. A draw that also changes alpha is shaded at every pixel.
        if a.iter().fold(0, |bits, a| bits | a.to_bits()) != 0 || !self.interpolate([r, g, b]) {
            return false;
        }
        let first_block = usize::from(first_quad.index) / QUADS_PER_BATCH;
        for block in 0..HALF_TILE_BLOCKS {
            tile.target.add_light(first_block + block, self.block(block));
        }
        true
    }
}

/// The tile that is being drawn.
pub(super) struct Tile<'a> {
    pub target: &'a mut TileTarget,
    pub pixel_centres: &'a PixelCentres,
    /// The tile's top-left pixel.
    pub corner: [u32; 2],
}

/// Draws the halves of a tile that the draw's only triangle covers and in which its light is smooth. Returns the blocks that it has drawn, one bit each.
pub(super) fn shade_coarsely<R: Real>(
    draw: &PreparedDraw<'_, R>,
    triangles: &[u32],
    tile: &mut Tile<'_>,
    run: &mut dyn LaneRun<R>,
    light: &mut InterpolatedLight,
) -> u32 {
    let [triangle] = triangles else { return 0 };
    if !draw.is_interpolated() {
        return 0;
    }
    let triangle = &draw.geometry.triangles[*triangle as usize];
    let mut drawn = 0;
    for first_block in (0..TILE_BLOCKS).step_by(HALF_TILE_BLOCKS) {
        let [x, y] = block_position(first_block);
        let [x, y] = [tile.corner[0] + x, tile.corner[1] + y];
        let half_tile = [x, y, x + (COLUMNS * SPACING) as u32, y + (ROWS * SPACING) as u32];
        if !covers_rectangle(triangle, half_tile) {
            continue;
        }
        // The coverage is not read: the triangle covers all of the half tile.
        let first_quad = Quad { index: (first_block * QUADS_PER_BATCH) as u16, coverage: 0, source_triangle: triangle.source_triangle };
        if light.draw(draw, run, first_quad, tile) {
            drawn |= ((1 << HALF_TILE_BLOCKS) - 1) << first_block;
        }
    }
    drawn
}
