//! Which pixels a draw discards because of marks in an image: those whose four nearest texels are all marked ([`MarkedImage`]). For example, the draw of
//! clouds discards the pixels whose clouds the ground's draw has already shaded.
//!
//! In: the image that an earlier pass drew, and where its texels lie on the screen. Out: whether a rectangle of pixels is discarded completely (the draw
//! "misses" it), kept completely (the draw "covers" it), or neither; these are the terms of [`Extent`](crate::render::plan::Extent). Always: the answers agree
//! with the draw's module. A rectangle with marked and unmarked texels gets neither answer, and the module decides for each of its pixels.

use super::sample::texels::{Decode, Float, Texels};
use crate::image::TexelFormat;
use crate::render::plan::MarkedImage;

/// The marks of an image.
#[derive(Clone, Debug)]
pub struct TexelMarks {
    /// The binding of the image, and where its texels lie on the screen.
    image: MarkedImage,
    /// Size of the image in texels.
    size: [u32; 2],
    /// Row by row, whether a texel is marked (its alpha is 1).
    is_marked: Vec<bool>,
}

impl TexelMarks {
    /// `None` if the image's format is not f32, or if memory is insufficient: then the module discards its pixels one by one.
    pub(super) fn new(image: MarkedImage, texels: &Texels<'_>) -> Option<Self> {
        let level = texels.levels.first().filter(|_| texels.format == TexelFormat::Rgba32Float)?.read();
        let count = level.width * level.height;
        let mut is_marked = super::try_vec(count as usize, false, "the marks of texels").ok()?;
        for (index, mark) in (0..count).zip(&mut is_marked) {
            // SAFETY: the level has `count` texels.
            *mark = Float.channel::<3>(unsafe { Float.texel(&level, index) }) == 1.0;
        }
        Some(Self { image, size: [level.width, level.height], is_marked })
    }

    /// Whether every pixel of a rectangle is discarded. `pixels`: left, top, right and bottom edge (the last two exclusive).
    pub(super) fn misses(&self, pixels: [u32; 4]) -> bool {
        self.rows(pixels).is_some_and(|mut rows| rows.all(|row| row.iter().all(|is_marked| *is_marked)))
    }

    /// Whether every pixel of a rectangle is kept.
    pub(super) fn covers(&self, pixels: [u32; 4]) -> bool {
        self.rows(pixels).is_some_and(|mut rows| rows.all(|row| row.iter().all(|is_marked| !is_marked)))
    }

    /// Marks of the texels that surround the pixels of a rectangle, row by row; `None` if some texels are beyond the image.
    fn rows(&self, pixels: [u32; 4]) -> Option<impl Iterator<Item = &[bool]>> {
        let [left, top, right, bottom] = self.image.texels_around(pixels);
        let [width, height] = self.size;
        (right <= width && bottom <= height)
            .then(|| (top..bottom).map(move |y| &self.is_marked[(y * width + left) as usize..(y * width + right) as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The marks of eight by eight texels, four pixels apart; the screen begins at texel (1, 2).
    fn marks(is_marked: impl Fn([u32; 2]) -> bool) -> TexelMarks {
        let texel = |k: u32| [0.5, 0.5, 0.5, if is_marked([k % 8, k / 8]) { 1.0_f32 } else { 0.0 }];
        let bytes: Vec<u8> = (0..64_u32).flat_map(texel).flat_map(f32::to_le_bytes).collect();
        let image = Texels::new(TexelFormat::Rgba32Float, std::iter::once((8, 8, &bytes[..]))).expect("an image");
        TexelMarks::new(MarkedImage { binding: 0, pixels_per_texel: 4, first_texel: [1, 2] }, &image).expect("marks")
    }

    #[test]
    fn a_rectangle_is_discarded_only_if_all_texels_around_its_pixels_are_marked() {
        // Texel (4, 5) lies at pixel (12, 12): for the pixels from 8 to 16 it is one of the four nearest texels.
        let (all_but_one, only_one) = (marks(|texel| texel != [4, 5]), marks(|texel| texel == [4, 5]));
        for (x, y) in (0..24).step_by(2).flat_map(|x| (0..20).step_by(2).map(move |y| (x, y))) {
            let is_near = [x, y].iter().all(|p| (8..16).contains(p));
            let quad = [x, y, x + 2, y + 2];
            assert_eq!((all_but_one.misses(quad), all_but_one.covers(quad)), (!is_near, false), "{x} {y}");
            assert_eq!((only_one.misses(quad), only_one.covers(quad)), (false, !is_near), "{x} {y}");
        }
        for rectangle in [[0, 0, 24, 20], [40, 0, 42, 2]] {
            assert!(!all_but_one.misses(rectangle) && !only_one.covers(rectangle), "{rectangle:?}: the module decides");
        }
    }
}
