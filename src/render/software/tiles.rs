//! The samples of one tile while it is drawn: colour, depth, blending, resolve.
//!
//! A tile is drawn completely before the next one is started, so multisampled data exists for one tile per thread only. A pixel whose samples
//! are all equal is stored once; the first edge through the pixel splits it into four samples. Colour is f32, as in the target, even if lanes are
//! f64.

use super::blend::{blend_lanes, blend_over_colour, blend_pixel};
use super::raster::coverage::{BLOCK_PIXELS, TILE, TILE_BLOCKS};
use crate::render::plan::Blend;

/// Whether bit `k` of a mask of samples or blocks is set.
#[inline(always)]
fn has_bit(mask: impl Into<u32>, k: usize) -> bool {
    mask.into() >> k & 1 == 1
}

/// Whether all bits of these lanes are 0, so that blending them changes nothing. No early exit, so that the compiler vectorises the loop.
#[inline(always)]
fn are_zero(lanes: &[f32]) -> bool {
    lanes.iter().fold(0, |all, v| all | v.to_bits()) == 0
}

const PIXELS: usize = (TILE * TILE) as usize;
/// Entry of [`TileTarget::split_index`] for a pixel whose samples are all equal.
const UNSPLIT: u16 = u16::MAX;

/// The samples of a tile, with pixels in lane order (see [`super::raster::coverage`]).
#[derive(Clone, Debug)]
pub(crate) struct TileTarget {
    samples: u8,
    /// Colour of unsplit pixels, one array per component.
    colour: [Vec<f32>; 4],
    /// Per pixel, its index in `split_colour`, or [`UNSPLIT`].
    split_index: Vec<u16>,
    /// Colours of the four samples of each split pixel.
    split_colour: Vec<[[f32; 4]; 4]>,
    /// The pixels of `split_colour`.
    split_pixels: Vec<u16>,
    /// Clear colour.
    clear_colour: [f32; 4],
    /// Bit `k`: block `k` was written since the last clear. The stored colours of the other blocks are stale; their pixels have `clear_colour`.
    written_blocks: u32,
    /// Reversed depth of the four samples. With one sample per pixel the first one decides. Only [`Self::test_depth_of_all`] writes and tests the others
    /// as well; at most they make that test fail, and the caller then tests the covered samples alone.
    depth: Vec<[f32; 4]>,
    /// Bit `k`: the stored depth of block `k` is valid. The stored depth of the other blocks is stale; their pixels are infinitely far.
    blocks_with_depth: u32,
}

impl TileTarget {
    pub(crate) fn new(samples: u8) -> Self {
        let plane = || vec![0.0; PIXELS];
        Self {
            samples,
            colour: [plane(), plane(), plane(), plane()],
            split_index: vec![UNSPLIT; PIXELS],
            split_colour: Vec::new(),
            split_pixels: Vec::new(),
            clear_colour: [0.0; 4],
            written_blocks: 0,
            depth: Vec::new(),
            blocks_with_depth: 0,
        }
    }

    /// Starts a new tile. `depth`: whether the tile tests or writes depth; if so, depth is cleared to infinitely far.
    pub(crate) fn clear(&mut self, colour: [f32; 4], depth: bool) {
        self.resolve();
        self.clear_colour = colour;
        (self.written_blocks, self.blocks_with_depth) = (0, 0);
        if depth && self.depth.is_empty() {
            self.depth.resize(PIXELS, [0.0; 4]);
        }
    }

    /// Marks a block as written; on the first write, fills it with the clear colour.
    #[inline(always)]
    fn prepare_block(&mut self, block: usize) {
        if !has_bit(self.written_blocks, block) {
            self.written_blocks |= 1 << block;
            for (plane, value) in self.colour.iter_mut().zip(self.clear_colour) {
                if let Some(pixels) = plane.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) {
                    pixels.fill(value);
                }
            }
        }
    }

    /// Fills all blocks that have not been written with the clear colour. Called before the complete tile is read.
    pub(crate) fn fill_unwritten(&mut self) {
        for block in 0..TILE_BLOCKS {
            self.prepare_block(block);
        }
    }

    /// Clears the depth of a pixel's block on its first use in this tile.
    #[inline(always)]
    fn prepare_depth(&mut self, pixel: usize) {
        let block = pixel / BLOCK_PIXELS;
        if !has_bit(self.blocks_with_depth, block) {
            self.blocks_with_depth |= 1 << block;
            if let Some(pixels) = self.depth.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) {
                pixels.fill([0.0; 4]);
            }
        }
    }

    /// Depth test of one pixel. Returns the samples of `covered` (four bits) whose new depth is greater (nearer), or all of `covered` if `test` is false, and
    /// stores their depth if `write`.
    #[inline(always)]
    pub(crate) fn test_depth(&mut self, pixel: usize, covered: u16, new: [f32; 4], test: bool, write: bool) -> u16 {
        self.prepare_depth(pixel);
        let stored = &mut self.depth[pixel];
        let mut passed = 0;
        for s in 0..4 {
            // Branch-free: along an edge the branches would be mispredicted.
            let passes = has_bit(covered, s) & (!test | (new[s] > stored[s]));
            passed |= u16::from(passes) << s;
            stored[s] = if passes & write & !new[s].is_nan() { new[s] } else { stored[s] };
        }
        passed
    }

    /// Depth test of the four pixels of a quad, each with one depth for all its samples. Returns the samples of `covered` (sixteen bits) that pass, as
    /// in [`Self::test_depth`], and stores their depth if `write`. All samples are computed in the same way, without branches, so that the loop is vectorised.
    #[inline(always)]
    pub(crate) fn test_depth_of_quad(&mut self, pixel: usize, covered: u16, new: &[f32; 4], test: bool, write: bool) -> u16 {
        self.prepare_depth(pixel);
        let Some(stored) = self.depth.get_mut(pixel..pixel + 4).and_then(|pixels| pixels.as_flattened_mut().as_mut_array::<16>()) else {
            return 0;
        };
        let new: [f32; 16] = std::array::from_fn(|sample| new[sample / 4]);
        let passes = new.iter().zip(&*stored).enumerate().map(|(sample, (new, stored))| u32::from(!test | (new > stored)) << sample);
        let passed = covered & passes.fold(0, |all, bit| all | bit) as u16;
        if write {
            for (sample, (stored, new)) in stored.iter_mut().zip(new).enumerate() {
                *stored = if (passed >> sample & 1 == 1) & !new.is_nan() { new } else { *stored };
            }
        }
        passed
    }

    /// Depth test of consecutive, fully covered pixels of one block. If all samples pass, returns true and stores their depth if `write`;
    /// otherwise changes nothing. A NaN never passes here, even if `test` is false: the caller then tests pixel by pixel, which does not store it.
    #[inline(always)]
    pub(crate) fn test_depth_of_all(&mut self, pixel: usize, new: &[f32], test: bool, write: bool) -> bool {
        let block = pixel / BLOCK_PIXELS;
        if new.len() == BLOCK_PIXELS && !has_bit(self.blocks_with_depth, block) {
            let Some(pixels) = self.depth.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) else { return false };
            // Nothing was drawn on the block: it is infinitely far, at depth 0.
            let all_pass = new.iter().fold(true, |all, new| all & ((!test & !new.is_nan()) | (*new > 0.0)));
            if all_pass && write {
                self.blocks_with_depth |= 1 << block;
                for (stored, new) in pixels.iter_mut().zip(new) {
                    *stored = [*new; 4];
                }
            }
            return all_pass;
        }
        self.prepare_depth(pixel);
        let Some(stored) = self.depth.get_mut(pixel..pixel + new.len()) else { return false };
        let mut all_pass = true;
        for (stored, new) in stored.iter().zip(new) {
            for s in stored {
                all_pass &= (!test & !new.is_nan()) | (*new > *s);
            }
        }
        if all_pass & write {
            for (stored, new) in stored.iter_mut().zip(new) {
                *stored = [*new; 4];
            }
        }
        all_pass
    }

    /// Blends `source` into the samples of `covered`.
    #[inline(always)]
    pub(crate) fn store(&mut self, pixel: usize, covered: u16, blend: Blend, source: [f32; 4]) {
        // Blending zeros changes nothing, and must not split a pixel. This is common at the edge of a sprite.
        if blend != Blend::Replace && are_zero(&source) {
            return;
        }
        let fully_covered = if self.samples == 4 { 0xf } else { 1 };
        self.prepare_block(pixel / BLOCK_PIXELS);
        if self.split_index[pixel] == UNSPLIT {
            let target: [f32; 4] = std::array::from_fn(|k| self.colour[k][pixel]);
            let new = blend_pixel(blend, source, target);
            if covered == fully_covered {
                for (plane, value) in self.colour.iter_mut().zip(new) {
                    plane[pixel] = value;
                }
            } else if covered != 0 {
                self.split_index[pixel] = self.split_colour.len() as u16;
                self.split_pixels.push(pixel as u16);
                self.split_colour.push(std::array::from_fn(|s| if has_bit(covered, s) { new } else { target }));
            }
            return;
        }
        let samples = &mut self.split_colour[usize::from(self.split_index[pixel])];
        for (s, target) in samples.iter_mut().enumerate() {
            if has_bit(covered, s) {
                *target = blend_pixel(blend, source, *target);
            }
        }
    }

    /// Blends fully covered pixels from `pixel` on. Returns false and changes nothing if one of them is split.
    #[inline(always)]
    pub(crate) fn store_lanes(&mut self, pixel: usize, blend: Blend, source: [&[f32]; 4]) -> bool {
        let range = pixel..pixel + source[0].len();
        // No early exit, so that the compiler vectorises the loop.
        if !self.split_pixels.is_empty() && self.split_index[range.clone()].iter().fold(false, |any, s| any | (*s != UNSPLIT)) {
            return false;
        }
        // Blending zeros changes nothing, so the block stays unwritten. This is common far from the centre of a glare.
        if blend != Blend::Replace && source.iter().all(|lanes| are_zero(lanes)) {
            return true;
        }
        let first = range.start / BLOCK_PIXELS;
        let is_complete_block = range.start == first * BLOCK_PIXELS && range.len() == BLOCK_PIXELS;
        if is_complete_block && !has_bit(self.written_blocks, first) {
            // The block has the clear colour, which is blended from here instead of being stored first.
            self.written_blocks |= 1 << first;
            let planes = self.colour.each_mut().map(|plane| &mut plane[range.clone()]);
            blend_over_colour(blend, source, self.clear_colour, planes);
            return true;
        }
        for block in first..range.end.div_ceil(BLOCK_PIXELS) {
            self.prepare_block(block);
        }
        let [r, g, b, a] = &mut self.colour;
        blend_lanes(blend, source, [&mut r[range.clone()], &mut g[range.clone()], &mut b[range.clone()], &mut a[range]]);
        true
    }

    /// Resolves the tile: sets every split pixel to the mean of its samples.
    pub(crate) fn resolve(&mut self) {
        for (pixel, samples) in self.split_pixels.drain(..).map(usize::from).zip(self.split_colour.drain(..)) {
            self.split_index[pixel] = UNSPLIT;
            for (k, plane) in self.colour.iter_mut().enumerate() {
                plane[pixel] = 0.25 * ((samples[0][k] + samples[1][k]) + (samples[2][k] + samples[3][k]));
            }
        }
    }

    /// The colour of the pixels of a block that was not written.
    pub(crate) fn clear_colour(&self) -> [f32; 4] {
        self.clear_colour
    }

    /// The colours of a block's pixels, one array per component. Valid once the tile is resolved, for a block that was written.
    pub(crate) fn block(&self, block: usize) -> Option<[&[f32; BLOCK_PIXELS]; 4]> {
        let [r, g, b, a] = &self.colour.each_ref().map(|plane| plane.as_chunks::<BLOCK_PIXELS>().0.get(block));
        Some([(*r)?, (*g)?, (*b)?, (*a)?])
    }

    /// Whether a block was written since the tile was started.
    pub(crate) fn is_written(&self, block: usize) -> bool {
        has_bit(self.written_blocks, block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(t: &TileTarget, pixel: usize) -> [f32; 4] {
        if t.is_written(pixel / BLOCK_PIXELS) { t.colour.each_ref().map(|plane| plane[pixel]) } else { t.clear_colour }
    }

    #[test]
    fn a_pixel_splits_at_an_edge_and_resolves_to_the_mean() {
        let mut t = TileTarget::new(4);
        t.clear([0.0, 0.0, 0.0, 1.0], false);
        t.store(7, 0b0101, Blend::Replace, [1.0, 2.0, 4.0, 1.0]);
        assert!(!t.store_lanes(4, Blend::Replace, [&[0.0; 4]; 4]));
        let mut resolved = t.clone();
        resolved.resolve();
        assert_eq!(pixel(&resolved, 7), [0.5, 1.0, 2.0, 1.0]);
        t.store(7, 0b1111, Blend::Add, [1.0, 0.0, 0.0, 0.0]);
        t.store(8, 0b0001, Blend::Add, [0.0; 4]);
        t.store(9, 0b0001, Blend::PremultipliedOver, [0.0; 4]);
        assert!((t.split_index[8], t.split_index[9]) == (UNSPLIT, UNSPLIT), "nothing was blended");
        t.resolve();
        assert_eq!(pixel(&t, 7), [1.5, 1.0, 2.0, 1.0]);
        assert!(t.store_lanes(8, Blend::Replace, [&[3.0; 4]; 4]));
        assert_eq!(pixel(&t, 11), [3.0; 4]);
        assert!(t.store_lanes(4, Blend::Replace, [&[2.0; 4]; 4]), "no pixel is split any more");
        t.store(7, 0b0001, Blend::Replace, [9.0; 4]);
        t.clear([0.25; 4], false);
        assert_eq!(pixel(&t, 7), [0.25; 4]);
    }

    #[test]
    fn written_blocks_are_tracked() {
        let mut t = TileTarget::new(1);
        t.clear([0.0; 4], false);
        let written = |t: &TileTarget| (0..PIXELS / BLOCK_PIXELS).filter(|b| t.is_written(*b)).collect::<Vec<_>>();
        assert!(written(&t).is_empty());
        t.store(BLOCK_PIXELS, 1, Blend::Add, [1.0; 4]);
        t.store_lanes(5 * BLOCK_PIXELS - 4, Blend::Replace, [&[1.0; 8]; 4]);
        assert_eq!(written(&t), [1, 4, 5]);
        t.clear([0.0; 4], false);
        t.store_lanes(0, Blend::Add, [&[0.0; 8]; 4]);
        t.store_lanes(0, Blend::PremultipliedOver, [&[0.0; 8]; 4]);
        assert!(written(&t).is_empty(), "nothing was added");
        t.store_lanes(0, Blend::Add, [&[0.0; 8], &[0.0, 0.0, 1e-30, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 8], &[0.0; 8]]);
        assert_eq!(written(&t), [0]);
        t.store(5 * BLOCK_PIXELS + 100, 1, Blend::Add, [2.0; 4]);
        assert_eq!(pixel(&t, 5 * BLOCK_PIXELS + 1), [0.0; 4], "the first write to a block clears its other pixels");
        assert_eq!(pixel(&t, 5 * BLOCK_PIXELS + 100), [2.0; 4]);
        t.fill_unwritten();
        assert_eq!(written(&t).len(), TILE_BLOCKS);
        assert_eq!(pixel(&t, 5 * BLOCK_PIXELS - 1), [0.0; 4]);
    }

    #[test]
    fn clearing_a_tile_resets_its_depth() {
        let mut t = TileTarget::new(1);
        t.clear([0.0; 4], true);
        t.test_depth(200, 1, [0.9; 4], true, true);
        assert_eq!(t.test_depth(200, 1, [0.5; 4], true, true), 0);
        t.clear([0.0; 4], true);
        assert_eq!(t.test_depth(200, 1, [0.5; 4], true, true), 1);
        assert!(t.test_depth_of_all(204, &[0.1; 4], true, true));
    }

    #[test]
    fn greater_depth_is_nearer() {
        let mut t = TileTarget::new(4);
        t.clear([0.0; 4], true);
        assert_eq!(t.test_depth(3, 0b1111, [0.5; 4], true, true), 0b1111);
        assert_eq!(t.test_depth(3, 0b1111, [0.25, 0.75, 0.5, 0.6], true, true), 0b1010);
        assert_eq!(t.test_depth(3, 0b0001, [0.1; 4], false, false), 0b0001);
    }

    #[test]
    fn pixels_pass_together_if_each_of_them_passes() {
        let values = [0.1, 0.4, 0.6, 0.9, f32::NAN];
        for case in 0..5_usize.pow(4) {
            let new: [f32; 4] = std::array::from_fn(|k| values[case / 5_usize.pow(k as u32) % 5]);
            for (test, write) in [(true, true), (true, false), (false, true)] {
                let mut start = TileTarget::new(4);
                start.clear([0.0; 4], true);
                start.test_depth(8, 0b1111, [0.5, 0.0, 0.5, 0.0], true, true);
                start.test_depth(10, 0b1111, [0.3; 4], true, true);
                let (mut one, mut four) = (start.clone(), start.clone());
                let at_once = one.test_depth_of_all(8, &new, test, write);
                let passed: Vec<u16> = (0..4).map(|k| four.test_depth(8 + k, 0b1111, [new[k]; 4], test, write)).collect();
                let has_no_nan = new.iter().all(|v| !v.is_nan());
                assert_eq!(at_once, has_no_nan && passed.iter().all(|p| *p == 0b1111), "{new:?}");
                let depths = |t: &TileTarget| t.depth[8..12].to_vec();
                assert_eq!(depths(&one), if at_once { depths(&four) } else { depths(&start) }, "{new:?}");
            }
        }
    }

    /// The test of a complete block gives what the tests of its pixels give, whether or not something was drawn on it.
    #[test]
    fn a_block_is_tested_as_its_pixels_are() {
        for value in [0.5, 0.0, f32::NAN] {
            for (test, write, is_drawn_on) in [(true, true, false), (true, false, false), (false, true, false), (true, true, true)] {
                let mut start = TileTarget::new(4);
                start.clear([0.0; 4], true);
                if is_drawn_on {
                    start.test_depth(BLOCK_PIXELS + 5, 0b1111, [0.3; 4], true, true);
                }
                let mut new = [0.5; BLOCK_PIXELS];
                new[77] = value;
                let (mut block, mut pixels) = (start.clone(), start.clone());
                let at_once = block.test_depth_of_all(BLOCK_PIXELS, &new, test, write);
                let passed = (0..BLOCK_PIXELS).map(|k| pixels.test_depth(BLOCK_PIXELS + k, 0b1111, [new[k]; 4], test, write));
                let all_pass = passed.fold(true, |all, samples| all & (samples == 0b1111));
                assert_eq!(at_once, all_pass && !value.is_nan(), "{value} {test} {write}");
                let depths = |mut target: TileTarget| {
                    target.prepare_depth(BLOCK_PIXELS);
                    target.depth[BLOCK_PIXELS..2 * BLOCK_PIXELS].to_vec()
                };
                assert_eq!(depths(block), depths(if at_once { pixels } else { start }), "{value} {test} {write}");
            }
        }
        let mut without_depth = TileTarget::new(1);
        without_depth.clear([0.0; 4], false);
        assert!(!without_depth.test_depth_of_all(0, &[0.5; BLOCK_PIXELS], true, true));
    }

    /// The test of a quad gives what the tests of its pixels give, for every combination of depths and for partial coverage.
    #[test]
    fn a_quad_is_tested_as_its_pixels_are() {
        let values = [0.1, 0.4, 0.9, f32::NAN];
        for case in 0..4_usize.pow(4) {
            let new: [f32; 4] = std::array::from_fn(|k| values[case / 4_usize.pow(k as u32) % 4]);
            for (covered, test, write) in [(0xffff, true, true), (0x5a3c, true, true), (0x0f71, true, false), (0x8421, false, true)] {
                let mut quad = TileTarget::new(4);
                quad.clear([0.0; 4], true);
                quad.test_depth(8, 0b1111, [0.5, 0.0, 0.5, 0.4], true, true);
                quad.test_depth(10, 0b0110, [0.3; 4], true, true);
                let mut pixels = quad.clone();
                let passed = quad.test_depth_of_quad(8, covered, &new, test, write);
                let of_pixel = |k: usize| pixels.test_depth(8 + k, covered >> (4 * k) & 0xf, [new[k]; 4], test, write) << (4 * k);
                assert_eq!(passed, (0..4).map(of_pixel).fold(0, |all, bits| all | bits), "{new:?} {covered:x}");
                assert_eq!(quad.depth[8..12], pixels.depth[8..12], "{new:?} {covered:x}");
            }
        }
    }
}
