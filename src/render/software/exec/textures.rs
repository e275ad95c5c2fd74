//! The texture interface of the executor, and an implementation for programs that read no texture.

use super::LaneMask;
use crate::render::software::math::Real;

/// Reads textures for a batch. `texture` indexes [`Program::textures`](crate::render::software::program::Program::textures). Slices contain one
/// value per lane; lanes outside `active` may contain any bits, NaN included, and their results are not used. `out`: red, green, blue, alpha, with
/// an empty slice for each channel that the program does not read.
pub trait TextureUnit<R: Real> {
    /// Filtered sample at the texture coordinates (u, v); `gradients`: their derivatives along x and y.
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], gradients: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]);
    /// Like `sample_gradients`, with up to `max_taps` taps along the footprint, summed as in shaders/lib/filtered_map.wesl. `max_taps` has one value per
    /// lane, or one for all lanes. The default implementation reads one tap.
    fn sample_filtered(
        &self,
        texture: usize,
        uv: [&[R]; 2],
        gradients: Gradients<'_, R>,
        max_taps: &[R],
        active: LaneMask,
        out: [&mut [R]; 4],
    ) {
        let _ = max_taps;
        self.sample_gradients(texture, uv[0], uv[1], gradients, active, out);
    }
    /// Filtered sample at (u, v) from a mip level (fractional: trilinear).
    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]);
    /// Bilinear interpolation between the texels of the finest level, as in shaders/lib/texels_between.wesl. `position`: x and y in texels; the middle of the
    /// first texel is at (0, 0).
    fn load_bilinear(&self, texture: usize, position: [&[R]; 2], active: LaneMask, out: [&mut [R]; 4]);
    /// The texel in column `x` and row `y` of a level; zeros outside the level. `x`, `y` and `level` are bit-cast integers ([`Real::lane_bits`]); `y` and
    /// `level` have one value per lane, or one for all lanes. Every lane of `out` is written.
    fn load(&self, texture: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]);
    /// Width and height of a level in texels. `level` is clamped to the existing levels.
    fn dimensions(&self, texture: usize, level: u32) -> [u32; 2];
    /// Number of mip levels.
    fn levels(&self, texture: usize) -> u32;
}

/// Derivatives of texture coordinates per pixel, with one value per lane.
#[derive(Clone, Copy)]
pub struct Gradients<'a, R> {
    pub du_dx: &'a [R],
    pub dv_dx: &'a [R],
    pub du_dy: &'a [R],
    pub dv_dy: &'a [R],
}

/// A texture unit for programs that should read no texture: a read returns zeros.
pub struct NoTextures;

impl<R: Real> TextureUnit<R> for NoTextures {
    fn sample_gradients(&self, _: usize, _: &[R], _: &[R], _: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn sample_level(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn load_bilinear(&self, _: usize, _: [&[R]; 2], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn load(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn dimensions(&self, _: usize, _: u32) -> [u32; 2] {
        [1, 1]
    }
    fn levels(&self, _: usize) -> u32 {
        1
    }
}
