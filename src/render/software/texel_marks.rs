//! Which pixels a draw discards because an image says so: those between four texels that are all marked (`MarkedTexels`).
//!
//! In: the image that an earlier pass drew, and where its texels lie on the screen. Out: whether a rectangle of pixels is discarded as a whole, or not at all.
//! Always: a pixel that the draw's module keeps is never called discarded; the module decides between texels that are not all marked.

use super::sample::texels::{Decode, Float, Texels};
use crate::image::TexelFormat;
use crate::render::plan::MarkedTexels;

/// The marks of an image.
#[derive(Clone, Debug)]
pub struct TexelMarks {
    place: MarkedTexels,
    /// Size of the image in texels.
    size: [u32; 2],
    /// By row: whether the texel is marked.
    is_marked: Vec<bool>,
}

impl TexelMarks {
    /// `None` if the image has no floats, or too many texels for memory: then the module discards its pixels one by one.
    pub(super) fn new(place: MarkedTexels, image: &Texels<'_>) -> Option<Self> {
        let level = image.levels.first().filter(|_| image.format == TexelFormat::Rgba32Float)?.read();
        let count = level.width * level.height;
        let mut is_marked = super::try_vec(count as usize, false, "the marks of texels").ok()?;
        for (index, is_marked) in (0..count).zip(&mut is_marked) {
            // SAFETY: the level has `count` texels.
            *is_marked = Float.channel::<3>(unsafe { Float.texel(&level, index) }) == 1.0;
        }
        Some(Self { place, size: [level.width, level.height], is_marked })
    }

    /// Whether every pixel of a rectangle is discarded. `pixels`: left, top, right and bottom edge (exclusive).
    pub(super) fn misses(&self, pixels: [u32; 4]) -> bool {
        self.rows(pixels).is_some_and(|mut rows| rows.all(|row| row.iter().all(|is_marked| *is_marked)))
    }

    /// Whether the module keeps every pixel of a rectangle.
    pub(super) fn covers(&self, pixels: [u32; 4]) -> bool {
        self.rows(pixels).is_some_and(|mut rows| rows.all(|row| row.iter().all(|is_marked| !is_marked)))
    }

    /// The texels beside which the pixels of a rectangle lie, by row; `None` if some are beyond the image.
    fn rows(&self, pixels: [u32; 4]) -> Option<impl Iterator<Item = &[bool]>> {
        let [left, top, right, bottom] = self.place.beside(pixels);
        let [width, height] = self.size;
        (right <= width && bottom <= height)
            .then(|| (top..bottom).map(move |y| &self.is_marked[(y * width + left) as usize..(y * width + right) as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_is_discarded_only_if_all_texels_around_its_pixels_are_marked() {
        // Eight by eight texels, four pixels apart, of which one is not marked; the screen begins at texel (1, 2).
        let unmarked = [4, 5];
        let bytes: Vec<u8> = (0..64_u32)
            .flat_map(|k| [0.5, 0.5, 0.5, if [k % 8, k / 8] == unmarked { 0.0_f32 } else { 1.0 }])
            .flat_map(f32::to_le_bytes)
            .collect();
        let image = Texels::new(TexelFormat::Rgba32Float, std::iter::once((8, 8, &bytes[..]))).expect("an image");
        let marks = TexelMarks::new(MarkedTexels { binding: 0, pixels_per_texel: 4, first_texel: [1, 2] }, &image).expect("marks");
        for (x, y) in (0..24).step_by(2).flat_map(|x| (0..20).step_by(2).map(move |y| (x, y))) {
            // Texel 4 lies at pixel 12, texel 5 of the rows at pixel 12 too.
            let is_beside = |p: u32| (8..16).contains(&p);
            assert_eq!(marks.misses([x, y, x + 2, y + 2]), !(is_beside(x) && is_beside(y)), "{x} {y}");
            assert!(!marks.covers([x, y, x + 2, y + 2]), "the other texels around it are marked");
        }
        assert!(!marks.misses([0, 0, 24, 20]) && !marks.misses([40, 0, 42, 2]), "beyond the image the module decides");
    }
}
