//! The depth of a tile's samples, and the depth test.
//!
//! In: the new depth of a pixel, a quad or a block. Out: the samples that pass. Always: depth is reversed, so that a greater value is nearer; a NaN is never
//! stored. Not here: colour (`tiles`).

use super::raster::coverage::{BLOCK_PIXELS, TILE_PIXELS};
use crate::render::plan::DepthState;

/// Whether bit `k` of a mask of samples or blocks is set.
#[inline(always)]
pub(super) fn has_bit(mask: impl Into<u32>, k: usize) -> bool {
    mask.into() >> k & 1 == 1
}

/// Reversed depth of a tile's samples. The index of a pixel, here and in the methods, is that in lane order ([`super::raster::coverage`]).
#[derive(Clone, Debug, Default)]
pub(crate) struct TileDepth {
    /// Four samples per pixel; empty until a tile uses depth. With one sample per pixel, only the first is meaningful. [`Self::test_all`] nevertheless tests
    /// and writes all four. If one of the other three fails, so does that test, and the caller tests the covered samples alone.
    samples: Vec<[f32; 4]>,
    /// Bit `k`: the stored depth of block `k` is valid. The stored depth of the other blocks is stale; their pixels count as infinitely far.
    valid_blocks: u32,
}

impl TileDepth {
    /// Starts a new tile, infinitely far everywhere. `uses_depth`: whether the tile tests or writes depth.
    pub(crate) fn clear(&mut self, uses_depth: bool) {
        self.valid_blocks = 0;
        if uses_depth && self.samples.is_empty() {
            self.samples.resize(TILE_PIXELS, [0.0; 4]);
        }
    }

    /// Clears the depth of a pixel's block on its first use in this tile.
    #[inline(always)]
    fn prepare(&mut self, pixel: usize) {
        let block = pixel / BLOCK_PIXELS;
        if !has_bit(self.valid_blocks, block) {
            self.valid_blocks |= 1 << block;
            if let Some(pixels) = self.samples.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) {
                pixels.fill([0.0; 4]);
            }
        }
    }

    /// Depth test of one pixel. `new`: the new depth of each sample. Returns the samples of `covered` (bit `s`: sample `s`, 0 to 3) whose new depth is greater
    /// (nearer), or all of `covered` if `test` is false, and stores their depth if `write`, except NaN.
    #[inline(always)]
    pub(crate) fn test(&mut self, pixel: usize, covered: u16, new: [f32; 4], DepthState { test, write }: DepthState) -> u16 {
        self.prepare(pixel);
        let stored = &mut self.samples[pixel];
        let mut passed = 0;
        for s in 0..4 {
            // Branch-free: along an edge the branches would be mispredicted.
            let passes = has_bit(covered, s) & (!test | (new[s] > stored[s]));
            passed |= u16::from(passes) << s;
            stored[s] = if passes & write & !new[s].is_nan() { new[s] } else { stored[s] };
        }
        passed
    }

    /// Depth test of the four pixels of a quad, of which `pixel` is the first. `new`: one depth per pixel, which all its samples have. Returns the samples of
    /// `covered` (bit `4 k + s`: sample `s` of pixel `k` of the quad) that pass, and stores their depth, as [`Self::test`] does; 0 for a tile without depth.
    /// All samples are computed in the same way, without branches, so that the loop is vectorised.
    #[inline(always)]
    pub(crate) fn test_quad(&mut self, pixel: usize, covered: u16, new: &[f32; 4], DepthState { test, write }: DepthState) -> u16 {
        self.prepare(pixel);
        let Some(stored) = self.samples.get_mut(pixel..pixel + 4).and_then(|pixels| pixels.as_flattened_mut().as_mut_array::<16>()) else {
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

    /// Depth test of consecutive, fully covered pixels of one block at once; `pixel` is the first. `new`: one depth per pixel. If all samples pass, returns
    /// true and stores their depth if `write`; otherwise, or for a tile without depth, returns false and changes no depth. A NaN never passes here, even if
    /// `test` is false: the caller then tests pixel by pixel, which does not store the NaN.
    #[inline(always)]
    pub(crate) fn test_all(&mut self, pixel: usize, new: &[f32], DepthState { test, write }: DepthState) -> bool {
        let block = pixel / BLOCK_PIXELS;
        if new.len() == BLOCK_PIXELS && !has_bit(self.valid_blocks, block) {
            // The pixels are those of the complete block, and nothing was drawn on it: it is infinitely far, at depth 0.
            let Some(pixels) = self.samples.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) else { return false };
            let all_pass = new.iter().fold(true, |all, new| all & ((!test & !new.is_nan()) | (*new > 0.0)));
            if all_pass && write {
                self.valid_blocks |= 1 << block;
                for (stored, new) in pixels.iter_mut().zip(new) {
                    *stored = [*new; 4];
                }
            }
            return all_pass;
        }
        self.prepare(pixel);
        let Some(stored) = self.samples.get_mut(pixel..pixel + new.len()) else { return false };
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
}

#[cfg(test)]
mod tests {
    use super::*;

    const USES_DEPTH: bool = true;
    const TEST_AND_WRITE: DepthState = DepthState { test: true, write: true };

    #[test]
    fn clearing_a_tile_resets_its_depth() {
        let mut t = TileDepth::default();
        t.clear(USES_DEPTH);
        let (pixel, first_of_next_quad, first_sample) = (200, 204, 1);
        t.test(pixel, first_sample, [0.9; 4], TEST_AND_WRITE);
        assert_eq!(t.test(pixel, first_sample, [0.5; 4], TEST_AND_WRITE), 0);
        t.clear(USES_DEPTH);
        assert_eq!(t.test(pixel, first_sample, [0.5; 4], TEST_AND_WRITE), first_sample);
        assert!(t.test_all(first_of_next_quad, &[0.1; 4], TEST_AND_WRITE));
    }

    #[test]
    fn greater_depth_is_nearer() {
        let mut t = TileDepth::default();
        t.clear(USES_DEPTH);
        assert_eq!(t.test(3, 0b1111, [0.5; 4], TEST_AND_WRITE), 0b1111);
        assert_eq!(t.test(3, 0b1111, [0.25, 0.75, 0.5, 0.6], TEST_AND_WRITE), 0b1010);
        assert_eq!(t.test(3, 0b0001, [0.1; 4], DepthState { test: false, write: false }), 0b0001);
    }

    #[test]
    fn pixels_pass_together_if_each_of_them_passes() {
        let values = [0.1, 0.4, 0.6, 0.9, f32::NAN];
        for case in 0..5_usize.pow(4) {
            let new: [f32; 4] = std::array::from_fn(|k| values[case / 5_usize.pow(k as u32) % 5]);
            for (test, write) in [(true, true), (true, false), (false, true)] {
                let state = DepthState { test, write };
                let mut start = TileDepth::default();
                start.clear(USES_DEPTH);
                start.test(8, 0b1111, [0.5, 0.0, 0.5, 0.0], TEST_AND_WRITE);
                start.test(10, 0b1111, [0.3; 4], TEST_AND_WRITE);
                let (mut together, mut one_by_one) = (start.clone(), start.clone());
                let at_once = together.test_all(8, &new, state);
                let passed: Vec<u16> = (0..4).map(|k| one_by_one.test(8 + k, 0b1111, [new[k]; 4], state)).collect();
                let has_no_nan = new.iter().all(|v| !v.is_nan());
                assert_eq!(at_once, has_no_nan && passed.iter().all(|p| *p == 0b1111), "{new:?}");
                let depths = |t: &TileDepth| t.samples[8..12].to_vec();
                assert_eq!(depths(&together), if at_once { depths(&one_by_one) } else { depths(&start) }, "{new:?}");
            }
        }
    }

    /// The test of a complete block gives what the tests of its pixels give, whether or not something was drawn on it.
    #[test]
    fn a_block_is_tested_as_its_pixels_are() {
        for value in [0.5, 0.0, f32::NAN] {
            for (test, write, is_drawn_on) in [(true, true, false), (true, false, false), (false, true, false), (true, true, true)] {
                let state = DepthState { test, write };
                let mut start = TileDepth::default();
                start.clear(USES_DEPTH);
                if is_drawn_on {
                    start.test(BLOCK_PIXELS + 5, 0b1111, [0.3; 4], TEST_AND_WRITE);
                }
                let mut new = [0.5; BLOCK_PIXELS];
                new[77] = value;
                let (mut block, mut pixels) = (start.clone(), start.clone());
                let at_once = block.test_all(BLOCK_PIXELS, &new, state);
                let passed = (0..BLOCK_PIXELS).map(|k| pixels.test(BLOCK_PIXELS + k, 0b1111, [new[k]; 4], state));
                let all_pass = passed.fold(true, |all, samples| all & (samples == 0b1111));
                assert_eq!(at_once, all_pass && !value.is_nan(), "{value} {test} {write}");
                let depths = |mut target: TileDepth| {
                    target.prepare(BLOCK_PIXELS);
                    target.samples[BLOCK_PIXELS..2 * BLOCK_PIXELS].to_vec()
                };
                assert_eq!(depths(block), depths(if at_once { pixels } else { start }), "{value} {test} {write}");
            }
        }
        let mut without_depth = TileDepth::default();
        without_depth.clear(!USES_DEPTH);
        assert!(!without_depth.test_all(0, &[0.5; BLOCK_PIXELS], TEST_AND_WRITE), "a tile without depth");
    }

    /// The test of a quad gives what the tests of its pixels give, for every combination of depths and for partial coverage.
    #[test]
    fn a_quad_is_tested_as_its_pixels_are() {
        let values = [0.1, 0.4, 0.9, f32::NAN];
        for case in 0..4_usize.pow(4) {
            let new: [f32; 4] = std::array::from_fn(|k| values[case / 4_usize.pow(k as u32) % 4]);
            for (covered, test, write) in [(0xffff, true, true), (0x5a3c, true, true), (0x0f71, true, false), (0x8421, false, true)] {
                let state = DepthState { test, write };
                let mut quad = TileDepth::default();
                quad.clear(USES_DEPTH);
                quad.test(8, 0b1111, [0.5, 0.0, 0.5, 0.4], TEST_AND_WRITE);
                quad.test(10, 0b0110, [0.3; 4], TEST_AND_WRITE);
                let mut pixels = quad.clone();
                let passed = quad.test_quad(8, covered, &new, state);
                let of_pixel = |k: usize| pixels.test(8 + k, covered >> (4 * k) & 0xf, [new[k]; 4], state) << (4 * k);
                assert_eq!(passed, (0..4).map(of_pixel).fold(0, |all, bits| all | bits), "{new:?} {covered:x}");
                assert_eq!(quad.samples[8..12], pixels.samples[8..12], "{new:?} {covered:x}");
            }
        }
    }
}
