//! Fuses two passes: the tone map reads each tile of the HDR image while the tile is still in cache, and the HDR image is never stored.
//!
//! In: a plan and one of its passes; a tile that this pass has just resolved. Out: whether the pass and the next may be fused
//! ([`can_fuse_with_next_pass`]); the tile as a texture ([`TileTexture`]). Always: a tone map that reads anything but the pixels of the block
//! (16x8 pixels) that is being shaded gets zeros and sets a flag; the renderer then executes the two passes one after the other.

use super::exec::{Gradients, LANES, LaneMask, TextureUnit};
use super::math::Real;
use super::program::{LaneInput, Program};
use super::raster::coverage::{BLOCK_PIXELS, block_at, quad_position};
use super::tape::{Instr, Operand, TextureOp};
use super::tiles::TileTarget;
use crate::render::plan::{Blend, ColourFormat, Plan, TextureSource};
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};

// The pixels of a block are the lanes of one batch.
const _: () = assert!(LANES == BLOCK_PIXELS);

/// x and y of a block's pixels in lane order, relative to the block's top-left pixel. Four consecutive lanes are a quad of 2x2 pixels, row by row.
static BLOCK_OFFSETS: std::sync::LazyLock<[[u32; LANES]; 2]> = std::sync::LazyLock::new(|| {
    let offsets = |axis: usize| std::array::from_fn(|lane| quad_position(lane / 4)[axis] + (((lane % 4) >> axis) & 1) as u32);
    [offsets(0), offsets(1)]
});

/// Whether the pass with this index and the next pass may be fused: the pass draws an HDR image that only the first draw of the next pass reads, and the
/// next pass draws a display image of the same size. That draw reads nothing else and overwrites what is below it; the display image has one sample per pixel
/// and no depth.
pub(crate) fn can_fuse_with_next_pass(plan: &Plan, index: usize) -> bool {
    let (Some(hdr), Some(display)) = (plan.passes.get(index), plan.passes.get(index + 1)) else { return false };
    let reads_hdr = |source: &TextureSource| matches!(source, TextureSource::PassOutput(read) if *read == index);
    let reader_count = plan.passes.iter().flat_map(|p| &p.draws).flat_map(|d| &d.textures).filter(|t| reads_hdr(&t.source)).count();
    let first_draw = display.draws.first();
    hdr.format != ColourFormat::Rgba8Unorm
        && display.format == ColourFormat::Rgba8Unorm
        && (hdr.width, hdr.height) == (display.width, display.height)
        && (display.samples, display.has_depth) == (1, false)
        && reader_count == 1
        && first_draw.is_some_and(|d| d.blend == Blend::Replace && d.textures.len() == 1 && reads_hdr(&d.textures[0].source))
}

/// A resolved tile, presented as a texture of its target's size.
pub(crate) struct TileTexture<'a> {
    /// The tile's colours, one per pixel.
    pub resolved: &'a TileTarget,
    /// Top-left pixel of the tile.
    pub tile_corner: [u32; 2],
    /// Width and height of the tile's target, in pixels.
    pub size: [u32; 2],
    /// Index, in the tile, of the block that is being shaded. Other blocks may contain colours of an earlier tile.
    pub shaded_block: Cell<usize>,
    /// Set by any read that is not a load of all pixels of `shaded_block` in lane order.
    pub read_other_pixels: Cell<bool>,
}

impl<'a> TileTexture<'a> {
    /// `tile_corner`: top-left pixel of the tile; `size`: width and height of the tile's target in pixels. `shaded_block` is initially the first block.
    pub(crate) fn new(resolved: &'a TileTarget, tile_corner: [u32; 2], size: [u32; 2]) -> Self {
        Self { resolved, tile_corner, size, shaded_block: Cell::new(0), read_other_pixels: Cell::new(false) }
    }

    /// Records a read that this texture cannot serve, and returns zeros.
    fn reject<R: Real>(&self, out: [&mut [R]; 4]) {
        self.read_other_pixels.set(true);
        out.into_iter().for_each(|channel| channel.fill(R::ZERO));
    }

    /// The block that is being shaded, if `x`, `y` and `level` (as in [`TextureUnit::load`]) load all its pixels in lane order.
    fn loaded_block<R: Real>(&self, x: &[R], y: &[R], level: &[R]) -> Option<usize> {
        let (x, y): (&[R; LANES], &[R; LANES]) = (x.try_into().ok()?, y.try_into().ok()?);
        let [dx, dy] = &*BLOCK_OFFSETS;
        let [x0, y0] = [x[0].lane_bits(), y[0].lane_bits()];
        let mut is_block = level.iter().all(|l| l.lane_bits() == 0);
        for i in 0..LANES {
            is_block &= (x[i].lane_bits().wrapping_sub(x0) == dx[i]) & (y[i].lane_bits().wrapping_sub(y0) == dy[i]);
        }
        let block = block_at([x0.wrapping_sub(self.tile_corner[0]), y0.wrapping_sub(self.tile_corner[1])]);
        block.filter(|block| is_block && *block == self.shaded_block.get())
    }
}

impl<R: Real> TextureUnit<R> for TileTexture<'_> {
    fn sample_gradients(&self, _: usize, _: &[R], _: &[R], _: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        self.reject(out);
    }
    fn sample_level(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        self.reject(out);
    }
    fn load_bilinear(&self, _: usize, _: [&[R]; 2], _: LaneMask, out: [&mut [R]; 4]) {
        self.reject(out);
    }
    fn load(&self, _: usize, x: &[R], y: &[R], level: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        let Some(planes) = self.loaded_block(x, y, level).and_then(|block| self.resolved.block(block)) else { return self.reject(out) };
        for (channel, plane) in out.into_iter().zip(planes) {
            for (lane, value) in channel.iter_mut().zip(plane) {
                *lane = R::from_f32_bits(value.to_bits());
            }
        }
    }
    fn dimensions(&self, _: usize, _: u32) -> [u32; 2] {
        self.size
    }
    fn levels(&self, _: usize) -> u32 {
        1
    }
}

impl Program {
    /// Whether the result of a lane depends only on the texels that the lane loads and on values that all lanes share. The pixel's position then decides which
    /// texels are loaded, and nothing else. Pixels with equal texels have equal results, so that pixels on which nothing is drawn are tone-mapped only once.
    /// False for programs with backward jumps, which are not analysed.
    pub fn is_position_independent(&self) -> bool {
        // Slots (arrays of one value per lane) whose value depends on the lane's position. All lanes of a full-screen draw have the same `FrontFacing`.
        let mut dependent: BTreeSet<u16> =
            (0..).zip(&self.inputs).filter(|(_, input)| !matches!(input, LaneInput::FrontFacing)).map(|(k, _)| k).collect();
        // For each later instruction that is the target of jumps: the slots that are position-dependent at any of these jumps.
        let mut dependent_at_target: HashMap<usize, BTreeSet<u16>> = HashMap::new();
        for (index, instr) in self.lane_tape.iter().enumerate() {
            dependent.extend(dependent_at_target.remove(&index).unwrap_or_default());
            let depends = |o: &Operand| matches!(o, Operand::Slot(s) if dependent.contains(s));
            // The coordinates of a load may depend on the position; its mask and its level, the last argument, may not.
            let result_depends = match instr {
                Instr::Texture { op: TextureOp::Load, args, mask, .. }
                    if !depends(mask) && args.last().is_none_or(|level| !depends(level)) =>
                {
                    false
                }
                _ => instr.operands().iter().any(depends),
            };
            match instr.target() {
                Some(_) if result_depends => return false,
                Some(target) if target as usize <= index => return false,
                Some(target) => dependent_at_target.entry(target as usize).or_default().extend(&dependent),
                None => {}
            }
            for slot in instr.written_slots() {
                if result_depends {
                    dependent.insert(slot);
                } else {
                    dependent.remove(&slot);
                }
            }
        }
        // What remains are jumps to the end of the tape.
        dependent.extend(dependent_at_target.into_values().flatten());
        let depends = |o: &Operand| matches!(o, Operand::Slot(s) if dependent.contains(s));
        !self.uses_derivatives && !self.output_operands.iter().chain(&self.discarded).any(depends)
    }
}
