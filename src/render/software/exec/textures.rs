//! The texture interface of the executor, and an implementation for programs that read no texture.

use super::{LANES, LaneMask};
use crate::render::software::math::Real;

/// The lanes whose bits are not all zero.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
pub(super) fn mask_avx2(lanes: &[f32; LANES]) -> LaneMask {
    use std::arch::x86_64::{
        __m256i, _mm256_and_si256, _mm256_castsi256_ps, _mm256_cmpeq_epi32, _mm256_movemask_ps, _mm256_set1_epi32, _mm256_setzero_si256,
        _mm256_testc_si256,
    };
    // Usually every bit is set, because all lanes are active.
    let mut all = _mm256_set1_epi32(-1);
    for lanes in lanes.as_chunks::<8>().0 {
        // SAFETY: an array and a register have eight words each.
        all = _mm256_and_si256(all, unsafe { std::mem::transmute::<[f32; 8], __m256i>(*lanes) });
    }
    if _mm256_testc_si256(all, _mm256_set1_epi32(-1)) == 1 {
        return LaneMask::MAX;
    }
    let mut zeros = [0u8; LANES / 8];
    for (zeros, lanes) in zeros.iter_mut().zip(lanes.as_chunks::<8>().0) {
        // SAFETY: an array and a register have eight words each.
        let lanes = unsafe { std::mem::transmute::<[f32; 8], __m256i>(*lanes) };
        *zeros = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(lanes, _mm256_setzero_si256()))) as u8;
    }
    !LaneMask::from_le_bytes(zeros)
}

/// Whether a bit is set in any lane. Usually one of the first 32 lanes has one, and the others are not read.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
pub(super) fn is_any_set_avx2(lanes: &[f32; LANES]) -> bool {
    use std::arch::x86_64::{__m256i, _mm256_or_si256, _mm256_testz_si256};
    for lanes in lanes.as_chunks::<32>().0 {
        // SAFETY: a chunk and four registers have 32 words each.
        let [a, b, c, d] = unsafe { std::mem::transmute::<[f32; 32], [__m256i; 4]>(*lanes) };
        let any = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
        if _mm256_testz_si256(any, any) == 0 {
            return true;
        }
    }
    false
}

/// Reads textures for a batch. `texture` indexes [`Program::textures`](crate::render::software::program::Program::textures). Slices contain one
/// value per lane; lanes outside `active` may contain any bits, NaN included, and their results are not used. `out`: red, green, blue, alpha, with
/// an empty slice for each channel that the program does not read.
pub trait TextureUnit<R: Real> {
    /// Filtered sample at (u, v) with the gradients of u and v per pixel step in x and y.
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], gradients: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]);
    /// Like `sample_gradients`, with up to `max_taps` taps along the footprint, summed as in shaders/lib/filtered_map.wesl. `max_taps` has one value per
    /// lane, or one for all lanes. The default is one tap.
    fn sample_filtered(&self, texture: usize, uv: [&[R]; 2], g: Gradients<'_, R>, max_taps: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let _ = max_taps;
        self.sample_gradients(texture, uv[0], uv[1], g, active, out);
    }
    /// Filtered sample at (u, v) from a mip level (fractional: trilinear).
    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]);
    /// Bilinear interpolation between the texels of the finest level at (x, y), given in texels, as in shaders/lib/texels_between.wesl.
    fn between(&self, texture: usize, at: [&[R]; 2], active: LaneMask, out: [&mut [R]; 4]);
    /// One texel; zeros outside the level. x, y and level are bit-cast integers ([`Real::lane_bits`]); y and level have one value per lane, or one for all
    /// lanes. Every lane of `out` is written.
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

/// A texture unit for programs that read no texture: every read returns zeros.
pub struct NoTextures;

impl<R: Real> TextureUnit<R> for NoTextures {
    fn sample_gradients(&self, _: usize, _: &[R], _: &[R], _: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn sample_level(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn between(&self, _: usize, _: [&[R]; 2], _: LaneMask, out: [&mut [R]; 4]) {
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

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    #[test]
    fn each_lane_with_any_bit_set_is_in_the_mask() {
        if !is_x86_feature_detected!("avx2") {
            return;
        }
        let all = f32::from_bits(u32::MAX);
        // SAFETY: AVX2 was detected.
        let mask = |lanes: &[f32; LANES]| unsafe { mask_avx2(lanes) };
        assert_eq!(mask(&[all; LANES]), LaneMask::MAX);
        assert_eq!(mask(&[0.0; LANES]), 0);
        for lane in [0, 7, 64, LANES - 1] {
            for (bits, is_set) in [(0, false), (1, true), (u32::MAX, true)] {
                let mut lanes = [all; LANES];
                lanes[lane] = f32::from_bits(bits);
                let others = LaneMask::MAX ^ 1 << lane;
                assert_eq!(mask(&lanes), if is_set { LaneMask::MAX } else { others }, "lane {lane}, bits {bits:x}");
            }
        }
    }
}
