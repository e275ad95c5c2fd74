//! A glyph atlas: the glyphs of one text size in one texture, with their positions and advances.
//!
//! In: the characters to be drawn and their size in pixels. Out: [`GlyphAtlas`]: a texture of one mip level that holds coverage (the same in all four
//! channels), and for each character a [`Glyph`] and its *halo*: the glyph and all that is near it. More glyphs are a ring, its halo and a filled square.
//! Always: each glyph has a rectangle of its own in the texture (its cell), and at least one empty texel lies between two cells. A character missing in the
//! font becomes the font's replacement glyph. Not here: the position of text.
//!
//! A glyph is drawn with the pen at the top left corner of a pixel; the ring surrounds the middle of that pixel. So for a ring around a point, the pen position
//! is the point minus half a pixel, rounded. The font is Ubuntu Light, as in the window.

use super::{Level, SharedTexture, TexelFormat, Texture};
use ab_glyph::{Font, FontRef, ScaleFont};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// One glyph: its cell in the texture, and its metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glyph {
    /// Column and row of the cell's top left texel in the texture.
    pub top_left: [u32; 2],
    /// Width and height, texels; nothing is drawn if either is 0.
    pub size: [u32; 2],
    /// From the pen position on the baseline to the cell's top left corner, pixels; y points down.
    pub bearing: [i32; 2],
    /// Advance of the pen, pixels.
    pub advance: f32,
}

/// The glyphs of one text size.
#[derive(Clone, Debug)]
pub struct GlyphAtlas {
    /// The coverage of all glyphs.
    pub texture: SharedTexture,
    /// The glyph and the halo of each character.
    by_character: BTreeMap<char, WithHalo>,
    /// A ring. It is drawn around landing sites, around bodies that appear smaller than the ring, and as the compass.
    pub ring: Glyph,
    /// The halo of the ring.
    pub ring_halo: Glyph,
    /// A fully covered square, any part of which can be drawn as a filled rectangle.
    pub solid_square: Glyph,
    /// From the middle of a lower-case letter down to the baseline.
    pub baseline_offset_px: f32,
}

/// A glyph and its halo.
#[derive(Clone, Copy, Debug)]
struct WithHalo {
    glyph: Glyph,
    halo: Glyph,
}

/// What a cell of the atlas contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cell {
    Character(char),
    Halo(char),
    Ring,
    RingHalo,
    Square,
}

/// Radius of a halo, in units of the font size: two pixels for text of 13 pixels.
const HALO_EMS: f32 = 1.0 / 7.0;
/// Coverage from which a texel has a halo around it: strokes of small text cover some of their texels only a little.
const MIN_INK: f32 = 0.1;

/// Width of the texture, in units of the font size.
const TEXTURE_WIDTH_EMS: f32 = 20.0;
/// Stroke width of the ring, in units of the font size: one pixel for text of 13 pixels.
const RING_STROKE_EMS: f32 = 1.0 / 13.0;

/// The coverage of a glyph before it is placed in the atlas. `size`, `bearing` and `advance` as in [`Glyph`].
struct GlyphBitmap {
    size: [u32; 2],
    bearing: [i32; 2],
    advance: f32,
    /// Coverage of each texel, 0 to 1, top row first.
    coverage: Vec<f32>,
}

/// Coverage and metrics of a character's glyph; no texels if it has no outline, as a space. `size_px`: font size, the side of the em square.
///
/// The coverage c of a texel is raised to c (2 - c), as egui raises it for light text on dark ground (`TwoCoverageMinusCoverageSq` of epaint), so that names are
/// as heavy as in the window: the strokes of this light font are thinner than a texel of small text.
fn rasterise(font: &FontRef<'_>, character: char, size_px: f32) -> GlyphBitmap {
    // `unwrap_or`: for a font that does not state its units per em.
    let scaled = font.as_scaled(font.pt_to_px_scale(size_px * POINTS_PER_PX).unwrap_or(size_px.into()));
    let id = font.glyph_id(character);
    let advance = scaled.h_advance(id);
    let Some(outline) = scaled.outline_glyph(id.with_scale(scaled.scale())) else {
        return GlyphBitmap { size: [0, 0], bearing: [0, 0], advance, coverage: Vec::new() };
    };
    let bounds = outline.px_bounds();
    let size = [bounds.width() as u32, bounds.height() as u32];
    let mut coverage = vec![0.0; size[0] as usize * size[1] as usize];
    outline.draw(|x, y, texel_coverage| {
        if let Some(texel) = coverage.get_mut((y * size[0] + x) as usize) {
            let covered = texel_coverage.clamp(0.0, 1.0);
            *texel = covered * (2.0 - covered);
        }
    });
    GlyphBitmap { size, bearing: [bounds.min.x as i32, bounds.min.y as i32], advance, coverage }
}

/// Points per pixel: the font crate assumes 96 pixels per inch, and an inch has 72 points.
const POINTS_PER_PX: f32 = 0.75;

/// A ring, antialiased by the distance from its edges. Its centre is half a pixel right and down of the pen.
fn ring(radius_px: f32, stroke_px: f32) -> GlyphBitmap {
    let half_side = (radius_px + 0.5 * stroke_px + 1.0).ceil() as i32;
    let side = (2 * half_side + 1) as u32;
    let coverage_of_texel = |k: u32| {
        let (x, y) = ((k % side) as f32 - half_side as f32, (k / side) as f32 - half_side as f32);
        (0.5 * stroke_px + 0.5 - (x.hypot(y) - radius_px).abs()).clamp(0.0, 1.0)
    };
    GlyphBitmap {
        size: [side, side],
        bearing: [-half_side, -half_side],
        advance: 0.0,
        coverage: (0..side * side).map(coverage_of_texel).collect(),
    }
}

/// The halo of a glyph: all texels nearer to it than `radius_px`, antialiased by the distance.
fn halo(glyph: &GlyphBitmap, radius_px: f32) -> GlyphBitmap {
    let [width, height] = glyph.size.map(|side| side as i32);
    if width == 0 || height == 0 {
        return GlyphBitmap { size: [0, 0], bearing: glyph.bearing, advance: glyph.advance, coverage: Vec::new() };
    }
    // Beyond this number of texels the coverage is 0.
    let reach = (radius_px + 0.5).ceil() as i32;
    let columns = width + 2 * reach;
    let is_inked = |x: i32, y: i32| glyph.coverage[(y * width + x) as usize] >= MIN_INK;
    // Square of the distance of each column to the nearest inked texel of the row; infinite in a row without ink.
    let squares_in_row = |y: i32| -> Vec<f32> {
        let mut distances = vec![f32::INFINITY; columns as usize];
        (0..width).filter(|x| is_inked(*x, y)).for_each(|x| distances[(x + reach) as usize] = 0.0);
        for x in 1..distances.len() {
            distances[x] = distances[x].min(distances[x - 1] + 1.0);
        }
        for x in (1..distances.len()).rev() {
            distances[x - 1] = distances[x - 1].min(distances[x] + 1.0);
        }
        distances.into_iter().map(|distance| distance * distance).collect()
    };
    let rows: Vec<Vec<f32>> = (0..height).map(squares_in_row).collect();
    let coverage_at = |x: i32, y: i32| {
        let near_rows = (y - reach).max(0)..(y + reach + 1).min(height);
        let square_px = near_rows.map(|row| rows[row as usize][x as usize] + ((row - y) * (row - y)) as f32).fold(f32::INFINITY, f32::min);
        (radius_px + 0.5 - square_px.sqrt()).clamp(0.0, 1.0)
    };
    GlyphBitmap {
        size: [columns as u32, (height + 2 * reach) as u32],
        bearing: glyph.bearing.map(|offset| offset - reach),
        advance: glyph.advance,
        coverage: (-reach..height + reach).flat_map(|y| (0..columns).map(move |x| (x, y))).map(|(x, y)| coverage_at(x, y)).collect(),
    }
}

/// Side of the filled square, in units of the font size. Larger rectangles are tiled with it.
const SQUARE_SIDE_EMS: f32 = 2.0;

fn solid_square(side_px: u32) -> GlyphBitmap {
    GlyphBitmap { size: [side_px, side_px], bearing: [0, 0], advance: 0.0, coverage: vec![1.0; side_px as usize * side_px as usize] }
}

impl GlyphAtlas {
    /// Draws the given characters for text of `size_px`, which is clamped to the range from 4 to 512. `ring_radius_ems`: radius of the ring, in units of the
    /// font size. If the font cannot be read, the atlas has no characters.
    pub(crate) fn draw(characters: impl IntoIterator<Item = char>, size_px: f32, ring_radius_ems: f32) -> Self {
        let size_px = size_px.clamp(4.0, 512.0);
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok();
        let characters: BTreeSet<char> = characters.into_iter().collect();
        let halo_px = (HALO_EMS * size_px).round().max(1.0);
        let mut drawn: Vec<(Cell, GlyphBitmap)> = characters
            .into_iter()
            .filter_map(|c| Some((Cell::Character(c), rasterise(font.as_ref()?, c, size_px))))
            .chain([
                (Cell::Ring, ring(ring_radius_ems * size_px, (RING_STROKE_EMS * size_px).max(1.0))),
                (Cell::Square, solid_square((SQUARE_SIDE_EMS * size_px).ceil() as u32)),
            ])
            .collect();
        let halo_of = |(cell, bitmap): &(Cell, GlyphBitmap)| match cell {
            Cell::Character(c) => Some((Cell::Halo(*c), halo(bitmap, halo_px))),
            Cell::Ring => Some((Cell::RingHalo, halo(bitmap, halo_px))),
            Cell::Halo(_) | Cell::RingHalo | Cell::Square => None,
        };
        let halos: Vec<_> = drawn.iter().filter_map(halo_of).collect();
        drawn.extend(halos);
        let widest = drawn.iter().map(|(_, bitmap)| bitmap.size[0]).max().unwrap_or(0);
        let width = ((TEXTURE_WIDTH_EMS * size_px) as u32).max(widest + 2);
        // Rows of cells, each as high as its highest glyph, with a border of one empty texel. `corner`: top left corner of the next cell.
        let (mut corner, mut row_height) = ([1_u32, 1_u32], 0_u32);
        let mut positions = Vec::new();
        for (_, bitmap) in &drawn {
            if corner[0] + bitmap.size[0] + 1 > width {
                corner = [1, corner[1] + row_height + 1];
                row_height = 0;
            }
            positions.push(corner);
            corner[0] += bitmap.size[0] + 1;
            row_height = row_height.max(bitmap.size[1]);
        }
        let height = corner[1] + row_height + 1;
        let mut bytes = vec![0_u8; width as usize * height as usize * 4];
        for ((_, bitmap), position) in drawn.iter().zip(&positions) {
            for (y, row) in bitmap.coverage.chunks(bitmap.size[0].max(1) as usize).enumerate() {
                for (x, coverage) in row.iter().enumerate() {
                    let offset = 4 * ((position[1] as usize + y) * width as usize + position[0] as usize + x);
                    bytes[offset..offset + 4].fill((255.0 * coverage).round() as u8);
                }
            }
        }
        let glyph = |bitmap: &GlyphBitmap, top_left: [u32; 2]| Glyph {
            top_left,
            size: bitmap.size,
            bearing: bitmap.bearing,
            advance: bitmap.advance,
        };
        let all: BTreeMap<Cell, Glyph> =
            drawn.iter().zip(&positions).map(|((cell, bitmap), position)| (*cell, glyph(bitmap, *position))).collect();
        let empty = Glyph { top_left: [0, 0], size: [0, 0], bearing: [0, 0], advance: 0.0 };
        let of_cell = |cell: Cell| all.get(&cell).copied().unwrap_or(empty);
        let with_halo = |(cell, glyph): (&Cell, &Glyph)| match *cell {
            Cell::Character(c) => Some((c, WithHalo { glyph: *glyph, halo: of_cell(Cell::Halo(c)) })),
            Cell::Halo(_) | Cell::Ring | Cell::RingHalo | Cell::Square => None,
        };
        // Height of the letter x above the baseline, which typographers call x-height.
        let x_height = font.as_ref().map_or(0.0, |f| -(rasterise(f, 'x', size_px).bearing[1] as f32));
        Self {
            texture: Arc::new(Texture { format: TexelFormat::Rgba8Unorm, levels: vec![Level::new(width, height, bytes)] }),
            ring: of_cell(Cell::Ring),
            ring_halo: of_cell(Cell::RingHalo),
            solid_square: of_cell(Cell::Square),
            by_character: all.iter().filter_map(with_halo).collect(),
            baseline_offset_px: (0.5 * x_height).round(),
        }
    }

    /// The glyphs of a text, each with its pen position in pixels from the start of the text. Characters that the atlas lacks are skipped.
    pub(crate) fn layout<'a>(&'a self, text: &'a str) -> impl Iterator<Item = (f32, Glyph)> + 'a {
        self.layout_with_halos(text).map(|(start, WithHalo { glyph, .. })| (start, glyph))
    }

    /// The halos of a text's glyphs, each with its pen position as in [`Self::layout`].
    pub(crate) fn halos<'a>(&'a self, text: &'a str) -> impl Iterator<Item = (f32, Glyph)> + 'a {
        self.layout_with_halos(text).map(|(start, WithHalo { halo, .. })| (start, halo))
    }

    fn layout_with_halos<'a>(&'a self, text: &'a str) -> impl Iterator<Item = (f32, WithHalo)> + 'a {
        text.chars().filter_map(|c| self.by_character.get(&c)).scan(0.0, |pen, both| {
            let start = *pen;
            *pen += both.glyph.advance;
            Some((start, *both))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of the coverage of a glyph's texels.
    fn covered_texels(atlas: &GlyphAtlas, glyph: &Glyph) -> f64 {
        let level = &atlas.texture.levels[0];
        let texel = |x: u32, y: u32| f64::from(level.bytes()[4 * (y * level.width + x) as usize]) / 255.0;
        let ([left, top], [width, height]) = (glyph.top_left, glyph.size);
        (0..width * height).map(|k| texel(left + k % width, top + k / width)).sum()
    }

    #[test]
    fn cells_do_not_touch_and_contain_all_coverage() {
        let glyphs = GlyphAtlas::draw("Ganymede Io ö\u{10FFFF}".chars(), 20.0, 0.4);
        let mut all: Vec<Glyph> = glyphs.by_character.values().flat_map(|both| [both.glyph, both.halo]).collect();
        all.extend([glyphs.ring, glyphs.ring_halo, glyphs.solid_square]);
        let end = |glyph: &Glyph, axis: usize| glyph.top_left[axis] + glyph.size[axis];
        let apart = |a: &Glyph, b: &Glyph, axis: usize| end(a, axis) < b.top_left[axis] || end(b, axis) < a.top_left[axis];
        let inked: Vec<&Glyph> = all.iter().filter(|glyph| glyph.size[0] > 0).collect();
        for (k, a) in inked.iter().enumerate() {
            assert!(inked[k + 1..].iter().all(|b| apart(a, b, 0) || apart(a, b, 1)), "{a:?}");
        }
        let total: f64 = glyphs.texture.levels[0].bytes().chunks(4).map(|t| f64::from(t[0]) / 255.0).sum();
        let cells: f64 = all.iter().map(|glyph| covered_texels(&glyphs, glyph)).sum();
        assert!((total - cells).abs() < 1e-6 && total > 100.0, "{total} of texels, {cells} in cells");
        let space = glyphs.by_character[&' '];
        assert!(space.glyph.advance > 2.0 && space.glyph.size[0] == 0 && space.halo.size[0] == 0);
        assert!(covered_texels(&glyphs, &glyphs.by_character[&'\u{10FFFF}'].glyph) > 1.0, "the replacement glyph");
    }

    /// The halo of a vertical stroke, whose area is known: the stroke, widened by the radius on all sides, with round corners.
    #[test]
    fn a_halo_reaches_as_far_as_its_radius() {
        let (width, height) = (2, 20);
        let stroke = GlyphBitmap { size: [width, height], bearing: [3, -20], advance: 5.0, coverage: vec![1.0; (width * height) as usize] };
        let radius_px = 4.0;
        let halo = halo(&stroke, radius_px);
        assert_eq!((halo.bearing, halo.advance, halo.size), ([-2, -25], 5.0, [12, 30]));
        let area: f32 = halo.coverage.iter().sum();
        // Of a texel, the distance counts from its middle, so the halo ends a radius beyond the middles of the outermost texels, and half a texel after that.
        let (x, y, r) = (width as f32 - 1.0, height as f32 - 1.0, radius_px);
        let expected = x * y + 2.0 * r * (x + y) + std::f32::consts::PI * r * r;
        assert!((area / expected - 1.0).abs() < 0.03, "{area} texels instead of {expected}");
    }

    #[test]
    fn letters_grow_with_their_size_and_the_ring_has_its_area() {
        let [small, large] = [20.0, 40.0].map(|size| GlyphAtlas::draw("Saturn".chars(), size, 0.4));
        let ink = |atlas: &GlyphAtlas| atlas.layout("Saturn").map(|(_, glyph)| covered_texels(atlas, &glyph)).sum::<f64>();
        let ratio = ink(&large) / ink(&small);
        // Raising the coverage adds to the edges of strokes only, so that small letters gain more.
        assert!((3.2..4.0).contains(&ratio), "twice the size has {ratio} times the ink");
        // The area of the letters, from so large a size that edges do not matter. Without the raised coverage, small letters would have just this area of ink.
        let [area, small_ink] = [400.0, 13.0].map(|size: f32| ink(&GlyphAtlas::draw("Saturn".chars(), size, 0.4)) / f64::from(size * size));
        assert!((1.15..1.6).contains(&(small_ink / area)), "{small_ink} instead of {area} square ems of ink");
        let ring_px = covered_texels(&large, &large.ring);
        let stroke_px = f64::from(RING_STROKE_EMS) * 40.0;
        // The circumference of a ring with a radius of 0.4 font sizes of 40 pixels, times its stroke.
        let expected = std::f64::consts::TAU * 16.0 * stroke_px;
        assert!((ring_px / expected - 1.0).abs() < 0.02, "{ring_px} texels, {expected}");
        let end = |atlas: &GlyphAtlas| atlas.layout("Saturn").last().map_or(0.0, |(pen, glyph)| pen + glyph.advance);
        assert!((end(&large) / end(&small) - 2.0).abs() < 0.02);
    }
}
