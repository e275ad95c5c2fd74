//! The colours of one tile's samples while it is drawn: blending and resolve.
//!
//! In: the colours and coverage of the fragments. Out: the resolved colour of each pixel. Not here: depth (`tile_depth`), and the image (`tile_rows`).
//!
//! A tile is drawn completely before the next one is started, so multisampled data exists for one tile per thread only. A pixel whose samples
//! are all equal is stored once; the first edge through the pixel splits it into four samples. Colour is f32, as in the target, even if lanes are
//! f64.

use super::blend::{blend_lanes, blend_onto_colour, blend_pixel};
use super::raster::coverage::{BLOCK_PIXELS, TILE_BLOCKS, TILE_PIXELS};
use super::tile_depth::{TileDepth, has_bit};
use crate::render::plan::Blend;
use std::ops::Range;

/// Whether all bits of these lanes are 0, so that blending them changes nothing. No early exit, so that the compiler vectorises the loop.
#[inline(always)]
fn are_zero(lanes: &[f32]) -> bool {
    lanes.iter().fold(0, |bits, v| bits | v.to_bits()) == 0
}

/// Entry of [`TileTarget::split_index`] for a pixel whose samples are all equal.
const UNSPLIT: u16 = u16::MAX;

/// The colours (red, green, blue, alpha) of a tile's samples. Pixels are indexed in lane order (see [`super::raster::coverage`]).
#[derive(Clone, Debug)]
pub(crate) struct TileTarget {
    /// 1 or 4.
    samples_per_pixel: u8,
    /// Colour of unsplit pixels, one array per component.
    colour: [Vec<f32>; 4],
    /// Per pixel, its index in `split_colour`, or [`UNSPLIT`].
    split_index: Vec<u16>,
    /// Colours of the four samples of each split pixel.
    split_colour: Vec<[[f32; 4]; 4]>,
    /// The pixel of each entry of `split_colour`.
    split_pixels: Vec<u16>,
    /// Colour of the pixels on which nothing was drawn.
    clear_colour: [f32; 4],
    /// Bit `k`: block `k` was written since the last clear. The stored colours of the other blocks are stale; their pixels count as `clear_colour`.
    written_blocks: u32,
    /// Bit `k`: block `k` is grey, with equal red, green and blue. Only its red is valid, and stands for all three; its stored green and blue are stale.
    grey_blocks: u32,
    pub(crate) depth: TileDepth,
}

impl TileTarget {
    pub(crate) fn new(samples_per_pixel: u8) -> Self {
        let plane = || vec![0.0; TILE_PIXELS];
        Self {
            samples_per_pixel,
            colour: [plane(), plane(), plane(), plane()],
            split_index: vec![UNSPLIT; TILE_PIXELS],
            split_colour: Vec::new(),
            split_pixels: Vec::new(),
            clear_colour: [0.0; 4],
            written_blocks: 0,
            grey_blocks: 0,
            depth: TileDepth::default(),
        }
    }

    /// Starts a new tile. `uses_depth`: whether the tile tests or writes depth; if so, depth is cleared to infinitely far.
    pub(crate) fn clear(&mut self, colour: [f32; 4], uses_depth: bool) {
        // No pixel of the new tile is split.
        self.resolve();
        self.clear_colour = colour;
        (self.written_blocks, self.grey_blocks) = (0, 0);
        self.depth.clear(uses_depth);
    }

    /// Makes all that is stored for a block valid: fills it with the clear colour on the first write, or copies a grey block's red to green and blue. A grey
    /// block was written.
    #[inline(always)]
    fn prepare_block(&mut self, block: usize) {
        if has_bit(self.grey_blocks, block) {
            self.grey_blocks &= !(1 << block);
            let pixels = block * BLOCK_PIXELS..(block + 1) * BLOCK_PIXELS;
            let [red, green, blue, _] = &mut self.colour;
            green[pixels.clone()].copy_from_slice(&red[pixels.clone()]);
            blue[pixels.clone()].copy_from_slice(&red[pixels]);
            return;
        }
        if !has_bit(self.written_blocks, block) {
            self.written_blocks |= 1 << block;
            for (plane, value) in self.colour.iter_mut().zip(self.clear_colour) {
                if let Some(pixels) = plane.as_chunks_mut::<BLOCK_PIXELS>().0.get_mut(block) {
                    pixels.fill(value);
                }
            }
        }
    }

    /// Makes all blocks valid, as [`Self::prepare_block`] does. Called before the complete tile is read.
    pub(crate) fn prepare_all_blocks(&mut self) {
        for block in 0..TILE_BLOCKS {
            self.prepare_block(block);
        }
    }

    /// Blends `source` into those samples of a pixel whose bits are set in `covered`.
    #[inline(always)]
    pub(crate) fn store(&mut self, pixel: usize, covered: u16, blend: Blend, source: [f32; 4]) {
        // Blending zeros changes nothing, and must not split a pixel. This is common at the edge of a sprite.
        if blend != Blend::Replace && are_zero(&source) {
            return;
        }
        let all_samples = if self.samples_per_pixel == 4 { 0xf } else { 1 };
        self.prepare_block(pixel / BLOCK_PIXELS);
        if self.split_index[pixel] == UNSPLIT {
            let target: [f32; 4] = std::array::from_fn(|k| self.colour[k][pixel]);
            let new = blend_pixel(blend, source, target);
            if covered == all_samples {
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

    /// Blends into all samples of the split pixels in `range`. The caller then blends all pixels of `range` as if none were split: the value that it stores
    /// for a split pixel is overwritten by the resolve. `source`: the colour for the pixel at an index from the start of `range`.
    #[inline(always)]
    fn blend_split_pixels(&mut self, range: Range<usize>, blend: Blend, source: impl Fn(usize) -> [f32; 4]) {
        if self.split_pixels.is_empty() {
            return;
        }
        let split_index = &self.split_index[range];
        // No early exit, so that the compiler vectorises the loop.
        if split_index.iter().fold(false, |any, index| any | (*index != UNSPLIT)) {
            for (k, index) in split_index.iter().enumerate().filter(|(_, index)| **index != UNSPLIT) {
                let source = source(k);
                for sample in &mut self.split_colour[usize::from(*index)] {
                    *sample = blend_pixel(blend, source, *sample);
                }
            }
        }
    }

    /// Blends consecutive, fully covered pixels, of which `pixel` is the first. `source`: one array per component, with one value per pixel.
    #[inline(always)]
    pub(crate) fn store_lanes(&mut self, pixel: usize, blend: Blend, source: [&[f32]; 4]) {
        let range = pixel..pixel + source[0].len();
        // Blending zeros changes nothing, so the block stays unwritten. This is common far from the centre of a glare.
        if blend != Blend::Replace && source.iter().all(|lanes| are_zero(lanes)) {
            return;
        }
        self.blend_split_pixels(range.clone(), blend, |lane| source.map(|lanes| lanes[lane]));
        let first_block = range.start / BLOCK_PIXELS;
        let is_complete_block = range.start == first_block * BLOCK_PIXELS && range.len() == BLOCK_PIXELS;
        if is_complete_block && !has_bit(self.written_blocks, first_block) {
            // The block has the clear colour, which is blended from here instead of being stored first.
            self.written_blocks |= 1 << first_block;
            let [r, g, b, a] = &mut self.colour;
            let planes = [&mut r[range.clone()], &mut g[range.clone()], &mut b[range.clone()], &mut a[range]];
            blend_onto_colour(blend, source, self.clear_colour, planes);
            return;
        }
        for block in first_block..range.end.div_ceil(BLOCK_PIXELS) {
            self.prepare_block(block);
        }
        let [r, g, b, a] = &mut self.colour;
        blend_lanes(blend, source, [&mut r[range.clone()], &mut g[range.clone()], &mut b[range.clone()], &mut a[range]]);
    }

    /// Adds light (red, green, blue) to all pixels of a block. Grey light is given as one array three times, and recognised by the equal addresses.
    #[inline(always)]
    pub(crate) fn add_light(&mut self, block: usize, light: [&[f32; BLOCK_PIXELS]; 3]) {
        let pixels = block * BLOCK_PIXELS..(block + 1) * BLOCK_PIXELS;
        let ([colour @ .., alpha], [clear_rgb @ .., clear_alpha]) = (&mut self.colour, self.clear_colour);
        if !has_bit(self.written_blocks, block) {
            self.written_blocks |= 1 << block;
            let is_grey = std::ptr::eq(light[0], light[1]) && std::ptr::eq(light[0], light[2]) && clear_rgb == [clear_rgb[0]; 3];
            self.grey_blocks |= u32::from(is_grey) << block;
            let stored_components = if is_grey { 1 } else { 3 };
            for ((plane, light), clear) in colour.iter_mut().zip(light).zip(clear_rgb).take(stored_components) {
                for (pixel, light) in plane[pixels.clone()].iter_mut().zip(light) {
                    *pixel = clear + light;
                }
            }
            alpha[pixels].fill(clear_alpha);
            return;
        }
        self.prepare_block(block);
        self.blend_split_pixels(pixels.clone(), Blend::Add, |k| [light[0][k], light[1][k], light[2][k], 0.0]);
        for (plane, light) in self.colour.iter_mut().zip(light) {
            for (pixel, light) in plane[pixels.clone()].iter_mut().zip(light) {
                *pixel += light;
            }
        }
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

    /// The colours of a block's pixels, one array per component; the same array for red, green and blue of a grey block. Valid once the tile is resolved, for
    /// a block that was written. `None` if the tile has no such block.
    pub(crate) fn block(&self, block: usize) -> Option<[&[f32; BLOCK_PIXELS]; 4]> {
        let [r, g, b, a] = &self.colour.each_ref().map(|plane| plane.as_chunks::<BLOCK_PIXELS>().0.get(block));
        let [r, g, b, a] = [(*r)?, (*g)?, (*b)?, (*a)?];
        Some(if has_bit(self.grey_blocks, block) { [r, r, r, a] } else { [r, g, b, a] })
    }

    /// Whether a block was written since the tile was started.
    pub(crate) fn is_written(&self, block: usize) -> bool {
        has_bit(self.written_blocks, block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WITHOUT_DEPTH: bool = false;

    fn colour_of(t: &TileTarget, pixel: usize) -> [f32; 4] {
        match t.block(pixel / BLOCK_PIXELS).filter(|_| t.is_written(pixel / BLOCK_PIXELS)) {
            Some(planes) => planes.map(|plane| plane[pixel % BLOCK_PIXELS]),
            None => t.clear_colour,
        }
    }

    #[test]
    fn a_pixel_splits_at_an_edge_and_resolves_to_the_mean() {
        let mut t = TileTarget::new(4);
        t.clear([0.0, 0.0, 0.0, 1.0], WITHOUT_DEPTH);
        t.store(7, 0b0101, Blend::Replace, [1.0, 2.0, 4.0, 1.0]);
        // Two of the four samples have the new colour.
        let mut resolved = t.clone();
        resolved.resolve();
        assert_eq!(colour_of(&resolved, 7), [0.5, 1.0, 2.0, 1.0]);
        t.store(7, 0b1111, Blend::Add, [1.0, 0.0, 0.0, 0.0]);
        t.store(8, 0b0001, Blend::Add, [0.0; 4]);
        t.store(9, 0b0001, Blend::PremultipliedOver, [0.0; 4]);
        assert!((t.split_index[8], t.split_index[9]) == (UNSPLIT, UNSPLIT), "nothing was blended");
        t.resolve();
        assert_eq!(colour_of(&t, 7), [1.5, 1.0, 2.0, 1.0]);
        t.store_lanes(8, Blend::Replace, [&[3.0; 4]; 4]);
        assert_eq!(colour_of(&t, 11), [3.0; 4]);
        t.store_lanes(4, Blend::Replace, [&[2.0; 4]; 4]);
        assert_eq!(colour_of(&t, 7), [2.0; 4], "the pixel is not split any more");
        // A split pixel does not outlast its tile.
        t.store(7, 0b0001, Blend::Replace, [9.0; 4]);
        t.clear([0.25; 4], WITHOUT_DEPTH);
        assert_eq!(colour_of(&t, 7), [0.25; 4]);
    }

    #[test]
    fn written_blocks_are_tracked() {
        let mut t = TileTarget::new(1);
        t.clear([0.0; 4], WITHOUT_DEPTH);
        let written = |t: &TileTarget| (0..TILE_BLOCKS).filter(|b| t.is_written(*b)).collect::<Vec<_>>();
        assert!(written(&t).is_empty());
        t.store(BLOCK_PIXELS, 1, Blend::Add, [1.0; 4]);
        t.store_lanes(5 * BLOCK_PIXELS - 4, Blend::Replace, [&[1.0; 8]; 4]);
        assert_eq!(written(&t), [1, 4, 5]);
        t.clear([0.0; 4], WITHOUT_DEPTH);
        t.store_lanes(0, Blend::Add, [&[0.0; 8]; 4]);
        t.store_lanes(0, Blend::PremultipliedOver, [&[0.0; 8]; 4]);
        assert!(written(&t).is_empty(), "nothing was added");
        t.store_lanes(0, Blend::Add, [&[0.0; 8], &[0.0, 0.0, 1e-30, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 8], &[0.0; 8]]);
        assert_eq!(written(&t), [0]);
        t.store(5 * BLOCK_PIXELS + 100, 1, Blend::Add, [2.0; 4]);
        assert_eq!(colour_of(&t, 5 * BLOCK_PIXELS + 1), [0.0; 4], "the first write to a block clears its other pixels");
        assert_eq!(colour_of(&t, 5 * BLOCK_PIXELS + 100), [2.0; 4]);
        t.prepare_all_blocks();
        assert_eq!(written(&t).len(), TILE_BLOCKS);
        assert_eq!(colour_of(&t, 5 * BLOCK_PIXELS - 1), [0.0; 4]);
    }

    /// Light that is added to a block gives the same pixels as if it were blended: grey or coloured, over a grey clear colour or not, before or after other
    /// draws, over split pixels too.
    #[test]
    fn added_light_is_blended_light() {
        // Integers, whose sums are exact.
        let planes: [[f32; BLOCK_PIXELS]; 3] = std::array::from_fn(|k| std::array::from_fn(|i| (k * 1000 + i) as f32));
        let [r, g, b] = &planes;
        let draw = |t: &mut TileTarget| t.store(3 * BLOCK_PIXELS + 9, 0b0110, Blend::Add, [1.0, 2.0, 3.0, 0.5]);
        for clear in [[0.0, 0.0, 0.0, 1.0], [0.5, 0.25, 0.0, 1.0]] {
            for lights in [&[[r, r, r]][..], &[[r, g, b]], &[[r, r, r], [g, g, g]], &[[r, r, r], [r, g, b]], &[[r, g, b], [b, b, b]]] {
                for lights_before_draw in 0..=lights.len() {
                    let (mut added, mut blended) = (TileTarget::new(4), TileTarget::new(4));
                    for t in [&mut added, &mut blended] {
                        t.clear(clear, WITHOUT_DEPTH);
                    }
                    for (k, light) in lights.iter().enumerate() {
                        if k == lights_before_draw {
                            draw(&mut added);
                            draw(&mut blended);
                        }
                        added.add_light(3, *light);
                        let [r, g, b] = light.map(|lanes| lanes.as_slice());
                        blended.store_lanes(3 * BLOCK_PIXELS, Blend::Add, [r, g, b, &[0.0; BLOCK_PIXELS]]);
                    }
                    if lights_before_draw == lights.len() {
                        draw(&mut added);
                        draw(&mut blended);
                    }
                    for t in [&mut added, &mut blended] {
                        t.resolve();
                    }
                    for p in 2 * BLOCK_PIXELS..5 * BLOCK_PIXELS {
                        assert_eq!(colour_of(&added, p), colour_of(&blended, p), "{p}");
                    }
                    assert_ne!(colour_of(&added, 3 * BLOCK_PIXELS + 10), clear, "light was added");
                }
            }
        }
    }
}
