//! A pass that is only read pixel by pixel need not be a picture: the tone map takes each tile's light while the tile is still there.
//!
//! In: a plan, and the tile that a pass has just resolved. Out: whether the next pass may be drawn tile by tile with it ([`next_reads_own_pixels`]), and the tile as a texture
//! ([`TileTexture`]). Always: a program that asks for anything but the pixels of its own block gets zeros and is found out; whoever draws then makes the picture and starts again.

use super::exec::{Gradients, LANES, LaneMask, TextureUnit};
use super::math::Real;
use super::program::{LaneInput, Program};
use super::raster::coverage::{BLOCK_PIXELS, block_at, quad_place};
use super::tape::{Instr, Operand, TextureOp};
use super::tiles::TileTarget;
use crate::render::plan::{Blend, ColourFormat, Plan, TextureSource};
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};

const _: () = assert!(LANES == BLOCK_PIXELS);

/// Pixels of a block in lane order, relative to its left top one: x and y.
static IN_BLOCK: std::sync::LazyLock<[[u32; LANES]; 2]> = std::sync::LazyLock::new(|| {
    let place = |axis: usize| std::array::from_fn(|lane| quad_place(lane / 4)[axis] + (((lane % 4) >> axis) & 1) as u32);
    [place(0), place(1)]
});

/// Whether pass `k` makes light of which the next pass draws its first picture, of the same size, and which nothing else reads.
pub fn next_reads_own_pixels(plan: &Plan, k: usize) -> bool {
    let (Some(light), Some(picture)) = (plan.passes.get(k), plan.passes.get(k + 1)) else { return false };
    let reads = |source: &TextureSource| matches!(source, TextureSource::PassOutput(read) if *read == k);
    let readers = plan.passes.iter().flat_map(|p| &p.draws).flat_map(|d| &d.textures).filter(|t| reads(&t.source)).count();
    let first = picture.draws.first();
    light.format != ColourFormat::Rgba8Unorm
        && picture.format == ColourFormat::Rgba8Unorm
        && (light.width, light.height, 1, false) == (picture.width, picture.height, picture.samples, picture.depth)
        && readers == 1
        && first.is_some_and(|d| d.blend == Blend::Replace && d.textures.len() == 1 && reads(&d.textures[0].source))
}

/// A resolved tile as a texture as large as its target.
pub struct TileTexture<'a> {
    pub resolved: &'a TileTarget,
    /// Left top pixel.
    pub tile: [u32; 2],
    /// Of the target.
    pub size: [u32; 2],
    /// Something else was asked for than the pixels of a block of this tile in their order.
    pub read_elsewhere: Cell<bool>,
}

impl TileTexture<'_> {
    fn elsewhere<R: Real>(&self, out: [&mut [R]; 4]) {
        self.read_elsewhere.set(true);
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }

    /// The block whose pixels these are, in their order.
    fn block<R: Real>(&self, x: &[R], y: &[R], level: &[R]) -> Option<usize> {
        let (x, y, level): (&[R; LANES], &[R; LANES], &[R; LANES]) = (x.try_into().ok()?, y.try_into().ok()?, level.try_into().ok()?);
        let [across, down] = &*IN_BLOCK;
        let [x0, y0] = [x[0].int(), y[0].int()];
        let mut same = true;
        for i in 0..LANES {
            same &= (x[i].int().wrapping_sub(x0) == across[i]) & (y[i].int().wrapping_sub(y0) == down[i]) & (level[i].int() == 0);
        }
        block_at([x0.wrapping_sub(self.tile[0]), y0.wrapping_sub(self.tile[1])]).filter(|_| same)
    }
}

impl<R: Real> TextureUnit<R> for TileTexture<'_> {
    fn sample_gradients(&self, _: usize, _: &[R], _: &[R], _: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        self.elsewhere(out);
    }
    fn sample_level(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        self.elsewhere(out);
    }
    fn load(&self, _: usize, x: &[R], y: &[R], level: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        let Some(planes) = self.block(x, y, level).and_then(|block| self.resolved.block(block)) else { return self.elsewhere(out) };
        for (to, plane) in out.into_iter().zip(planes) {
            for (to, value) in to.iter_mut().zip(plane) {
                *to = R::from_f32_bits(value.to_bits());
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
    /// Whether the lane's place goes into nothing but the places of texels that it loads: then equal texels give equal results. Programs
    /// that jump backwards are not looked into.
    pub fn is_same_everywhere(&self) -> bool {
        let mut of_place: BTreeSet<u16> =
            (0..).zip(&self.inputs).filter(|(_, input)| !matches!(input, LaneInput::FrontFacing)).map(|(k, _)| k).collect();
        // What depends on the place where a jump arrives.
        let mut arriving: HashMap<usize, BTreeSet<u16>> = HashMap::new();
        for (at, instr) in self.lane_tape.iter().enumerate() {
            of_place.extend(arriving.remove(&at).unwrap_or_default());
            let depends = |o: &Operand| matches!(o, Operand::Slot(s) if of_place.contains(s));
            let result = match instr {
                Instr::Texture { what: TextureOp::Load, args, mask, .. }
                    if !depends(mask) && args.last().is_none_or(|level| !depends(level)) =>
                {
                    false
                }
                _ => instr.operands().iter().any(depends),
            };
            match instr.target() {
                Some(_) if result => return false,
                Some(target) if target as usize <= at => return false,
                Some(target) => arriving.entry(target as usize).or_default().extend(&of_place),
                None => {}
            }
            for slot in instr.written_slots() {
                if result {
                    of_place.insert(slot);
                } else {
                    of_place.remove(&slot);
                }
            }
        }
        of_place.extend(arriving.into_values().flatten());
        let depends = |o: &Operand| matches!(o, Operand::Slot(s) if of_place.contains(s));
        !self.uses_derivatives && !self.output_operands.iter().chain(&self.discarded).any(depends)
    }
}
