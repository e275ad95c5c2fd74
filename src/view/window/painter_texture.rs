//! A texture of the CPU painter, and how its texels are interpolated.
//!
//! In: egui's images. Out: interpolated texels. Always: weights are multiples of 1/256; at the centre of a texel the result is that texel.
//! Opaque images that are painted without a tint take a faster path, [`OpaqueRows`], whose results differ by at most one of 255 levels.

use crate::image::{self, Level, SharedTexture, TexelFormat};
use egui::epaint::{ImageData, ImageDelta};
use egui::{Color32, TextureFilter, TextureWrapMode};
use std::sync::{Arc, OnceLock};

/// A texture of `width * height` premultiplied texels, row by row.
pub(crate) struct PainterTexture {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Color32>,
    is_opaque: bool,
    /// Whether texels are interpolated linearly; otherwise the nearest one is taken.
    pub is_linear: bool,
    /// Whether the texture repeats at coordinates outside 0 to 1; otherwise they are clamped to its edge.
    pub repeats: bool,
    /// A copy of the texels for a GPU renderer, made when first needed.
    shared: OnceLock<SharedTexture>,
}

/// Two neighbouring texels of a row or a column between which a position lies, by their indices.
#[derive(Clone, Copy)]
pub(crate) struct TexelPair {
    pub first: usize,
    pub second: usize,
    /// The weight of the second texel, 256ths. The first has the remaining weight.
    pub weight: u32,
}

/// An interpolated texel; a channel is its level times 256. Each word has one channel in each half, so that one multiplication serves both.
#[derive(Clone, Copy, Default)]
pub(crate) struct WideTexel {
    red_blue: u64,
    green_alpha: u64,
}

impl TexelPair {
    /// The weights of the first and of the second texel, 256ths.
    fn weights(self) -> (u64, u64) {
        (u64::from(256 - self.weight), u64::from(self.weight))
    }

    /// Interpolates two texels: the first step of bilinear filtering.
    pub fn interpolate(self, first: Color32, second: Color32) -> WideTexel {
        let (first_weight, second_weight) = self.weights();
        let in_halves = |low: u8, high: u8| u64::from(low) | u64::from(high) << 32;
        let (first, second) = (first.to_array(), second.to_array());
        WideTexel {
            red_blue: in_halves(first[0], first[2]) * first_weight + in_halves(second[0], second[2]) * second_weight,
            green_alpha: in_halves(first[1], first[3]) * first_weight + in_halves(second[1], second[3]) * second_weight,
        }
    }

    /// Interpolates two results of [`Self::interpolate`] in the other direction, and rounds to bytes: the second step.
    pub fn interpolate_wide(self, first: WideTexel, second: WideTexel) -> Color32 {
        /// Half a level (0x8000) in both channels, for rounding; the sums are levels times 65536.
        const HALF: u64 = 0x8000_0000_8000;
        let (first_weight, second_weight) = self.weights();
        let red_blue = first.red_blue * first_weight + second.red_blue * second_weight + HALF;
        let green_alpha = first.green_alpha * first_weight + second.green_alpha * second_weight + HALF;
        Color32::from_rgba_premultiplied(
            (red_blue >> 16) as u8,
            (green_alpha >> 16) as u8,
            (red_blue >> 48) as u8,
            (green_alpha >> 48) as u8,
        )
    }
}

impl PainterTexture {
    pub fn new(delta: ImageDelta) -> Self {
        let is_linear = delta.options.magnification == TextureFilter::Linear;
        let repeats = delta.options.wrap_mode != TextureWrapMode::ClampToEdge;
        let ImageData::Color(image) = delta.image;
        // The pixels are copied only if egui still holds the image, too.
        let image = Arc::try_unwrap(image).unwrap_or_else(|shared| (*shared).clone());
        let [width, height] = image.size;
        let is_opaque = image.pixels.iter().all(|texel| texel.a() == 255);
        Self { width, height, texels: image.pixels, is_opaque, is_linear, repeats, shared: OnceLock::new() }
    }

    /// Updates a part of the texture. A part that exceeds the texture is ignored.
    pub fn update(&mut self, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let ([width, height], Some([x, y])) = (image.size, delta.pos) else { return };
        if x + width > self.width || y + height > self.height {
            return;
        }
        for (row, source) in image.pixels.chunks_exact(width.max(1)).enumerate() {
            let start = (y + row) * self.width + x;
            self.texels[start..start + width].copy_from_slice(source);
        }
        self.is_opaque &= image.pixels.iter().all(|texel| texel.a() == 255);
        self.shared.take();
    }

    /// Whether every texel is known to be opaque; false once a texel has been transparent, even if it was replaced since.
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// A copy of the texels for a GPU renderer, the same one until the texels change.
    pub(crate) fn shared(&self) -> SharedTexture {
        let copied = || {
            let bytes = bytemuck::cast_slice(&self.texels).to_vec();
            let level = Level::new(self.width as u32, self.height as u32, bytes);
            Arc::new(image::Texture { format: TexelFormat::Rgba8Unorm, levels: vec![level] })
        };
        self.shared.get_or_init(copied).clone()
    }

    /// The two texels between which a coordinate from 0 to 1 lies in a row or column of `size` texels.
    pub fn texel_pair(&self, coordinate: f32, size: usize) -> TexelPair {
        let wrapped = |texel: i64| {
            let size = size as i64;
            (if self.repeats { texel.rem_euclid(size) } else { texel.clamp(0, size - 1) }) as usize
        };
        let position = coordinate * size as f32;
        if !self.is_linear {
            let first = wrapped(position.floor() as i64);
            return TexelPair { first, second: first, weight: 0 };
        }
        // Multiples of 1/256 are fine enough for bytes. Rounding makes a coordinate at a texel's centre give that texel, despite the coordinate's own
        // rounding error.
        let position_256ths = ((position - 0.5) * 256.0).round() as i64;
        let first = position_256ths.div_euclid(256);
        TexelPair { first: wrapped(first), second: wrapped(first + 1), weight: position_256ths.rem_euclid(256) as u32 }
    }

    /// The texel interpolated between two columns and two rows.
    fn bilinear(&self, x: TexelPair, y: TexelPair) -> Color32 {
        let (upper, lower) = (&self.texels[y.first * self.width..], &self.texels[y.second * self.width..]);
        if x.weight == 0 && y.weight == 0 {
            return upper[x.first];
        }
        let column = |x: usize| y.interpolate(upper[x], lower[x]);
        x.interpolate_wide(column(x.first), column(x.second))
    }

    /// The filtered texel at texture coordinates; white if the texture is empty.
    pub fn sample(&self, u: f32, v: f32) -> Color32 {
        if self.texels.is_empty() {
            return Color32::WHITE;
        }
        self.bilinear(self.texel_pair(u, self.width), self.texel_pair(v, self.height))
    }
}

/// Bilinear interpolation of an opaque image that fills a rectangle: each texel row is interpolated horizontally once, and each row of pixels is
/// interpolated between two such rows.
#[derive(Default)]
pub(crate) struct OpaqueRows {
    /// The last two horizontally interpolated rows.
    rows: [InterpolatedRow; 2],
    /// The texel row that is being interpolated, see [`to_lanes`].
    texel_lanes: Vec<u64>,
    /// Whether every column of pixels lies at the centre of a column of texels, so that no horizontal interpolation is needed.
    is_aligned: bool,
}

/// A texel row interpolated horizontally, once for each column of pixels.
#[derive(Default)]
struct InterpolatedRow {
    /// Index of the texel row in the current image; `None` if `lanes` holds no row of this image.
    texel_row: Option<usize>,
    /// One value for each column of pixels, with four lanes of 16 bits; a lane is the level of a channel times 128.
    lanes: Vec<u64>,
}

/// The channels of a texel in four lanes of 16 bits, in the order of a pixel's bytes on a little-endian machine: blue, green, red, 0.
fn to_lanes(texel: Color32) -> u64 {
    let [r, g, b, _] = texel.to_array();
    u64::from(b) | u64::from(g) << 16 | u64::from(r) << 32
}

/// A texel as a pixel, 0x00RRGGBB.
fn to_pixel(texel: Color32) -> u32 {
    let [r, g, b, _] = texel.to_array();
    u32::from_be_bytes([0, r, g, b])
}

impl OpaqueRows {
    /// Starts an image, and drops the rows of the last one. `columns`: for each column of pixels, the texel columns between which it lies.
    pub fn start(&mut self, texture: &PainterTexture, columns: &[TexelPair]) {
        self.rows.iter_mut().for_each(|row| row.texel_row = None);
        self.is_aligned = columns.iter().all(|pair| pair.weight == 0);
        debug_assert!(columns.iter().all(|pair| pair.first < texture.width && pair.second < texture.width));
    }

    /// Writes one row of pixels. `columns`: as in [`Self::start`]; `row_pair`: the texel rows between which the row of pixels lies.
    pub fn write_row(&mut self, texture: &PainterTexture, columns: &[TexelPair], row_pair: TexelPair, pixels: &mut [u32]) {
        if self.is_aligned && row_pair.weight == 0 {
            let texels = &texture.texels[row_pair.first * texture.width..(row_pair.first + 1) * texture.width];
            for (pixel, column) in pixels.iter_mut().zip(columns) {
                *pixel = to_pixel(texels[column.first]);
            }
            return;
        }
        let none_kept = None;
        let first_index = self.interpolated_row_index(texture, columns, row_pair.first, none_kept);
        let second_index = self.interpolated_row_index(texture, columns, row_pair.second, Some(first_index));
        let lanes = |index: usize| bytemuck::cast_slice::<u64, u16>(&self.rows[index].lanes);
        let bytes = bytemuck::cast_slice_mut::<u32, u8>(pixels);
        // A lane is a level times 128, so 64 is half a level.
        let rounded = |lane: u16| ((lane + 64) >> 7) as u8;
        if row_pair.weight == 0 {
            for (byte, first) in bytes.iter_mut().zip(lanes(first_index)) {
                *byte = rounded(*first);
            }
        } else {
            // The weights are in 65536ths, so the upper 16 bits of a product are again a level times 128.
            let (second_weight, first_weight) = ((row_pair.weight << 8) as u16, ((256 - row_pair.weight) << 8) as u16);
            let weighted = |lane: u16, weight: u16| ((u32::from(lane) * u32::from(weight)) >> 16) as u16;
            for ((byte, first), second) in bytes.iter_mut().zip(lanes(first_index)).zip(lanes(second_index)) {
                *byte = rounded(weighted(*first, first_weight) + weighted(*second, second_weight));
            }
        }
    }

    /// The index in `rows` of a texel row. If this row is not in `rows` yet, interpolates it horizontally in place of one of the two. `texel_row`: the row's
    /// index in the texture. `kept_index`: index in `rows` of the one that must not be replaced; `None` if either may be.
    fn interpolated_row_index(
        &mut self,
        texture: &PainterTexture,
        columns: &[TexelPair],
        texel_row: usize,
        kept_index: Option<usize>,
    ) -> usize {
        if let Some(known_index) = self.rows.iter().position(|known| known.texel_row == Some(texel_row)) {
            return known_index;
        }
        // Rows are needed from top to bottom, so the upper one of the two is replaced. One without a texel row (`None`) counts as uppermost.
        let index = match kept_index {
            Some(kept_index) => 1 - kept_index,
            None => usize::from(self.rows[0].texel_row > self.rows[1].texel_row),
        };
        self.texel_lanes.clear();
        let texels = &texture.texels[texel_row * texture.width..(texel_row + 1) * texture.width];
        self.texel_lanes.extend(texels.iter().map(|texel| to_lanes(*texel)));
        let target = &mut self.rows[index];
        target.texel_row = Some(texel_row);
        target.lanes.clear();
        target.lanes.extend(columns.iter().map(|pair| {
            let (first_weight, second_weight) = pair.weights();
            // A lane is at most 255 * 256. It is halved, so that rounding cannot overflow later. The mask removes the bit that the shift brings in from
            // the next lane.
            ((self.texel_lanes[pair.first] * first_weight + self.texel_lanes[pair.second] * second_weight) >> 1) & 0x7fff_7fff_7fff_7fff
        }));
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{ColorImage, TextureOptions};

    const WIDTH: usize = 37;
    const HEIGHT: usize = 23;

    fn texture() -> PainterTexture {
        let texel = |i: usize| Color32::from_rgb((i * 97 % 256) as u8, (i * 41 % 253) as u8, if i.is_multiple_of(2) { 255 } else { 0 });
        let image = ColorImage::new([WIDTH, HEIGHT], (0..WIDTH * HEIGHT).map(texel).collect());
        PainterTexture::new(ImageDelta::full(image, TextureOptions::LINEAR))
    }

    /// The largest difference, in levels, between [`OpaqueRows`] and bilinear interpolation in f64 for an image drawn with this size.
    fn largest_error(texture: &PainterTexture, [width, height]: [usize; 2]) -> f64 {
        let pair = |pixel: usize, pixels: usize, texels: usize| texture.texel_pair((pixel as f32 + 0.5) / pixels as f32, texels);
        let columns: Vec<TexelPair> = (0..width).map(|x| pair(x, width, WIDTH)).collect();
        let mut rows = OpaqueRows::default();
        rows.start(texture, &columns);
        let mut pixels = vec![0; width];
        let mut largest: f64 = 0.0;
        for y in 0..height {
            let row_pair = pair(y, height, HEIGHT);
            rows.write_row(texture, &columns, row_pair, &mut pixels);
            for (pixel, column) in pixels.iter().zip(&columns) {
                let [zero, shown @ ..] = pixel.to_be_bytes();
                assert_eq!(zero, 0);
                for (channel, shown) in shown.into_iter().enumerate() {
                    let at = |x: usize, y: usize| f64::from(texture.texels[y * WIDTH + x].to_array()[channel]);
                    let mix = |a: f64, b: f64, weight: u32| a + (b - a) * f64::from(weight) / 256.0;
                    let of_row = |y: usize| mix(at(column.first, y), at(column.second, y), column.weight);
                    largest = largest.max((mix(of_row(row_pair.first), of_row(row_pair.second), row_pair.weight) - f64::from(shown)).abs());
                }
            }
        }
        largest
    }

    #[test]
    fn opaque_rows_match_bilinear_interpolation() {
        let texture = texture();
        assert!(texture.is_opaque());
        assert_eq!(largest_error(&texture, [WIDTH, HEIGHT]), 0.0, "an image drawn with its own size is copied");
        for size in [[WIDTH, 2 * HEIGHT], [2 * WIDTH, HEIGHT], [3 * WIDTH, 3 * HEIGHT], [131, 87], [20, 11], [1, 1]] {
            let error_levels = largest_error(&texture, size);
            // Rounding to whole levels alone gives errors of up to 0.5.
            assert!(error_levels < 0.6, "{size:?}: {error_levels} levels");
        }
        // Different texel rows give different pixels; otherwise the comparison above could not notice a row that is wrongly reused.
        let columns: Vec<TexelPair> = (0..WIDTH).map(|x| texture.texel_pair((x as f32 + 0.5) / WIDTH as f32, WIDTH)).collect();
        let mut rows = OpaqueRows::default();
        rows.start(&texture, &columns);
        let [mut first, mut last] = [vec![0; WIDTH], vec![0; WIDTH]];
        rows.write_row(&texture, &columns, TexelPair { first: 3, second: 4, weight: 128 }, &mut first);
        rows.write_row(&texture, &columns, TexelPair { first: 9, second: 10, weight: 128 }, &mut last);
        assert_ne!(first, last);
    }

    #[test]
    fn a_transparent_texel_makes_a_texture_transparent() {
        let mut texture = texture();
        let part = |colour| ImageDelta::partial([1, 1], ColorImage::filled([2, 2], colour), TextureOptions::LINEAR);
        texture.update(&part(Color32::RED));
        assert!(texture.is_opaque() && texture.texels[WIDTH + 1] == Color32::RED);
        texture.update(&part(Color32::from_black_alpha(254)));
        assert!(!texture.is_opaque());
    }
}
