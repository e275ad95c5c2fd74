//! A texture of the CPU painter, and how its texels are interpolated.
//!
//! In: egui's images. Out: interpolated texels. Always: weights have steps of 1/256; at the centre of a texel the result is that texel. Opaque images
//! that are painted without a tint take a faster path, [`MagnifiedRows`], whose rounding differs: by one level of 255 at most.

use crate::image::{self, Level, SharedTexture, TexelFormat};
use egui::epaint::{ImageData, ImageDelta};
use egui::{Color32, TextureFilter, TextureWrapMode};
use std::sync::{Arc, OnceLock};

pub(crate) struct PainterTexture {
    pub width: usize,
    pub height: usize,
    pub texels: Vec<Color32>,
    is_opaque: bool,
    pub smooth: bool,
    pub repeats: bool,
    /// For a GPU renderer; created when first needed.
    shared: OnceLock<SharedTexture>,
}

/// Two neighbouring texels of a row or a column, and the weight of the second in 256ths.
#[derive(Clone, Copy)]
pub(crate) struct Tap {
    pub near: usize,
    pub far: usize,
    pub weight: u32,
}

/// An interpolated texel in fixed point (times 256). Each word has two channels in its halves, so that one multiplication serves both.
#[derive(Clone, Copy, Default)]
pub(crate) struct WideTexel {
    red_blue: u64,
    green_alpha: u64,
}

impl Tap {
    fn weights(self) -> (u64, u64) {
        (u64::from(256 - self.weight), u64::from(self.weight))
    }

    pub fn interpolate(self, near: Color32, far: Color32) -> WideTexel {
        let (near_weight, far_weight) = self.weights();
        let pair = |a: u8, b: u8| u64::from(a) | u64::from(b) << 32;
        let ([nr, ng, nb, na], [fr, fg, fb, fa]) = (near.to_array(), far.to_array());
        WideTexel {
            red_blue: pair(nr, nb) * near_weight + pair(fr, fb) * far_weight,
            green_alpha: pair(ng, na) * near_weight + pair(fg, fa) * far_weight,
        }
    }

    /// Interpolates two texels that were already interpolated in the other direction, and rounds to bytes.
    pub fn interpolate_mixed(self, near: WideTexel, far: WideTexel) -> Color32 {
        const HALF: u64 = 0x8000_0000_8000;
        let (near_weight, far_weight) = self.weights();
        let red_blue = near.red_blue * near_weight + far.red_blue * far_weight + HALF;
        let green_alpha = near.green_alpha * near_weight + far.green_alpha * far_weight + HALF;
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
        let smooth = delta.options.magnification == TextureFilter::Linear;
        let repeats = delta.options.wrap_mode != TextureWrapMode::ClampToEdge;
        let ImageData::Color(image) = delta.image;
        // An image that nobody else holds is not copied.
        let image = Arc::try_unwrap(image).unwrap_or_else(|shared| (*shared).clone());
        let [width, height] = image.size;
        let is_opaque = image.pixels.iter().all(|texel| texel.a() == 255);
        Self { width, height, texels: image.pixels, is_opaque, smooth, repeats, shared: OnceLock::new() }
    }

    /// Updates the part of the texture at the delta's position; a part that exceeds the texture is ignored.
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

    /// Whether every texel hides what is below it. May be false for an opaque texture that was updated.
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// The texels for a GPU renderer; every call returns the same allocation until the texels change.
    pub(crate) fn shared(&self) -> SharedTexture {
        let make = || {
            let bytes = bytemuck::cast_slice(&self.texels).to_vec();
            let level = Level::new(self.width as u32, self.height as u32, bytes);
            Arc::new(image::Texture { format: TexelFormat::Rgba8Unorm, levels: vec![level] })
        };
        self.shared.get_or_init(make).clone()
    }

    /// The tap at a coordinate from 0 to 1 in a row (or column) of `size` texels.
    pub fn tap(&self, coordinate: f32, size: usize) -> Tap {
        let inside = |v: i64| {
            let size = size as i64;
            (if self.repeats { v.rem_euclid(size) } else { v.clamp(0, size - 1) }) as usize
        };
        let texels = coordinate * size as f32;
        if !self.smooth {
            let near = inside(texels.floor() as i64);
            return Tap { near, far: near, weight: 0 };
        }
        // Weights in steps of 1/256 suffice for bytes. They are rounded, so that at a texel's centre the result is that texel, whatever the last bits of
        // the coordinate.
        let steps = ((texels - 0.5) * 256.0).round() as i64;
        let first = steps.div_euclid(256);
        Tap { near: inside(first), far: inside(first + 1), weight: steps.rem_euclid(256) as u32 }
    }

    fn bilinear(&self, x: Tap, y: Tap) -> Color32 {
        let (upper, lower) = (&self.texels[y.near * self.width..], &self.texels[y.far * self.width..]);
        if x.weight == 0 && y.weight == 0 {
            return upper[x.near];
        }
        let column = |k: usize| y.interpolate(upper[k], lower[k]);
        x.interpolate_mixed(column(x.near), column(x.far))
    }

    pub fn at(&self, u: f32, v: f32) -> Color32 {
        if self.texels.is_empty() {
            return Color32::WHITE;
        }
        self.bilinear(self.tap(u, self.width), self.tap(v, self.height))
    }
}

/// Rows of an opaque image, magnified: texel rows are first interpolated along the row, each once, and then two of them for each row of pixels.
#[derive(Default)]
pub(crate) struct MagnifiedRows {
    /// The texel row and the interpolated row, four channels of 15 bits per pixel, for the last two texel rows.
    rows: [(Option<usize>, Vec<u64>); 2],
    /// One texel row, four channels of 8 bits in lanes of 16.
    spread: Vec<u64>,
    /// Every pixel centre lies horizontally at a texel centre, so that no texel row needs interpolation along the row.
    is_aligned: bool,
}

/// The channels in the byte order of a pixel in memory: blue, green, red, and nothing.
fn spread(texel: Color32) -> u64 {
    let [r, g, b, _] = texel.to_array();
    u64::from(b) | u64::from(g) << 16 | u64::from(r) << 32
}

fn pixel(texel: Color32) -> u32 {
    let [r, g, b, _] = texel.to_array();
    u32::from_be_bytes([0, r, g, b])
}

impl MagnifiedRows {
    /// Forgets the rows of the last image.
    pub fn start(&mut self, texture: &PainterTexture, columns: &[Tap]) {
        self.rows.iter_mut().for_each(|(texel_row, _)| *texel_row = None);
        self.is_aligned = columns.iter().all(|tap| tap.weight == 0);
        debug_assert!(columns.iter().all(|tap| tap.near < texture.width && tap.far < texture.width));
    }

    /// Writes one row of pixels: `columns` has the tap of each pixel, `at` the two texel rows.
    pub fn row(&mut self, texture: &PainterTexture, columns: &[Tap], at: Tap, pixels: &mut [u32]) {
        if self.is_aligned && at.weight == 0 {
            let texels = &texture.texels[at.near * texture.width..(at.near + 1) * texture.width];
            for (p, column) in pixels.iter_mut().zip(columns) {
                *p = pixel(texels[column.near]);
            }
            return;
        }
        let near = self.interpolated(texture, columns, at.near, None);
        let far = self.interpolated(texture, columns, at.far, Some(near));
        let lanes = |k: usize| bytemuck::cast_slice::<u64, u16>(&self.rows[k].1);
        let bytes = bytemuck::cast_slice_mut::<u32, u8>(pixels);
        let rounded = |v: u16| ((v + 64) >> 7) as u8;
        if at.weight == 0 {
            for (byte, a) in bytes.iter_mut().zip(lanes(near)) {
                *byte = rounded(*a);
            }
        } else {
            // In 65536ths. The upper half of a product of 15 and 16 bits keeps 7 bits behind the point.
            let (far_weight, near_weight) = ((at.weight << 8) as u16, ((256 - at.weight) << 8) as u16);
            let weighted = |v: u16, weight: u16| ((u32::from(v) * u32::from(weight)) >> 16) as u16;
            for ((byte, a), b) in bytes.iter_mut().zip(lanes(near)).zip(lanes(far)) {
                *byte = rounded(weighted(*a, near_weight) + weighted(*b, far_weight));
            }
        }
    }

    /// The place in `rows` of a texel row, interpolated along the row. `kept` must not be overwritten.
    fn interpolated(&mut self, texture: &PainterTexture, columns: &[Tap], row: usize, kept: Option<usize>) -> usize {
        if let Some(known) = self.rows.iter().position(|(texel_row, _)| *texel_row == Some(row)) {
            return known;
        }
        // Rows come from top to bottom, so the upper of the two (with the smaller index) is no longer needed.
        let place = match kept {
            Some(kept) => 1 - kept,
            None => usize::from(self.rows[0].0 > self.rows[1].0),
        };
        self.spread.clear();
        self.spread.extend(texture.texels[row * texture.width..(row + 1) * texture.width].iter().map(|t| spread(*t)));
        let (texel_row, target) = &mut self.rows[place];
        *texel_row = Some(row);
        target.clear();
        target.extend(columns.iter().map(|tap| {
            let (near_weight, far_weight) = tap.weights();
            // At most 255 * 256 in each lane of 16 bits; halved, so that rounding later cannot overflow.
            ((self.spread[tap.near] * near_weight + self.spread[tap.far] * far_weight) >> 1) & 0x7fff_7fff_7fff_7fff
        }));
        place
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

    /// The largest difference of [`MagnifiedRows`] from bilinear interpolation in f64, levels of 255, for an image of this size.
    fn largest_error(texture: &PainterTexture, [width, height]: [usize; 2]) -> f64 {
        let tap = |pixel: usize, pixels: usize, texels: usize| texture.tap((pixel as f32 + 0.5) / pixels as f32, texels);
        let columns: Vec<Tap> = (0..width).map(|x| tap(x, width, WIDTH)).collect();
        let mut rows = MagnifiedRows::default();
        rows.start(texture, &columns);
        let mut pixels = vec![0; width];
        let mut largest: f64 = 0.0;
        for y in 0..height {
            let row = tap(y, height, HEIGHT);
            rows.row(texture, &columns, row, &mut pixels);
            for (pixel, column) in pixels.iter().zip(&columns) {
                let [zero, shown @ ..] = pixel.to_be_bytes();
                assert_eq!(zero, 0);
                for (channel, shown) in shown.into_iter().enumerate() {
                    let at = |x: usize, y: usize| f64::from(texture.texels[y * WIDTH + x].to_array()[channel]);
                    let mix = |a: f64, b: f64, weight: u32| a + (b - a) * f64::from(weight) / 256.0;
                    let of_row = |y: usize| mix(at(column.near, y), at(column.far, y), column.weight);
                    largest = largest.max((mix(of_row(row.near), of_row(row.far), row.weight) - f64::from(shown)).abs());
                }
            }
        }
        largest
    }

    #[test]
    fn magnified_rows_are_bilinear() {
        let texture = texture();
        assert!(texture.is_opaque());
        assert_eq!(largest_error(&texture, [WIDTH, HEIGHT]), 0.0, "an image in its own size is copied");
        for size in [[WIDTH, 2 * HEIGHT], [2 * WIDTH, HEIGHT], [3 * WIDTH, 3 * HEIGHT], [131, 87], [20, 11], [1, 1]] {
            let error = largest_error(&texture, size);
            assert!(error < 0.6, "{size:?}: {error} levels");
        }
        // The control: with rows in the wrong order, kept rows would be those of other texel rows.
        let columns: Vec<Tap> = (0..WIDTH).map(|x| texture.tap((x as f32 + 0.5) / WIDTH as f32, WIDTH)).collect();
        let mut rows = MagnifiedRows::default();
        rows.start(&texture, &columns);
        let [mut first, mut last] = [vec![0; WIDTH], vec![0; WIDTH]];
        rows.row(&texture, &columns, Tap { near: 3, far: 4, weight: 128 }, &mut first);
        rows.row(&texture, &columns, Tap { near: 9, far: 10, weight: 128 }, &mut last);
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
