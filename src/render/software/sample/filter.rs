//! Filtering: nearest, bilinear, trilinear, anisotropic.
//!
//! In: texture coordinates (0..1 across the texture) and their gradients per pixel. Out: four linear floats.
//!
//! A pixel's footprint is the ellipse that its unit circle becomes in texels. Its axes are the singular values of the gradient matrix; up to
//! `anisotropy` trilinear taps are spread evenly along the major axis, and the mip level is log2 of the minor one (or of the major over
//! `anisotropy`, whichever is greater), as Direct3D and Vulkan describe. Without anisotropy the level is log2 of the longer
//! gradient. Coordinates that are not finite read some texel and never trap.

use super::texels::{Decode, TexelLevel};
use crate::render::plan::{AddressMode, SamplerState};
use crate::render::software::math::Real;

/// The taps of one lane.
#[derive(Clone, Copy, Debug)]
pub struct Footprint<R> {
    /// Mip level, not yet clamped.
    pub level: R,
    pub taps: u32,
    /// Step from tap to tap in texture coordinates.
    pub step: [R; 2],
}

#[inline(always)]
fn floor<R: Real>(x: R) -> R {
    let r = x.round();
    if r > x { r - R::ONE } else { r }
}

#[inline(always)]
fn from_f32<R: Real>(x: f32) -> R {
    R::from_f32_bits(x.to_bits())
}

/// Gradients `[du, dv]` per pixel in x and in y to a footprint on a texture of `size` texels.
#[inline(always)]
pub fn footprint<R: Real>(size: [u32; 2], dx: [R; 2], dy: [R; 2], anisotropy: u8) -> Footprint<R> {
    let (w, h) = (R::from_u32(size[0]), R::from_u32(size[1]));
    let (ux, vx, uy, vy) = (dx[0] * w, dx[1] * h, dy[0] * w, dy[1] * h);
    let half = R::from_f64(0.5);
    let one_tap = |square: R| Footprint { level: half * square.log2::<false>(), taps: 1, step: [R::ZERO; 2] };
    if anisotropy <= 1 {
        let (x, y) = (ux * ux + vx * vx, uy * uy + vy * vy);
        return one_tap(if x > y { x } else { y });
    }
    // J Jᵀ = [a b; b c]; its eigenvalues are the squares of the axes.
    let (a, c, b) = (ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy);
    let (mean, difference) = (half * (a + c), half * (a - c));
    let major_sq = mean + (difference * difference + b * b).sqrt();
    // NaN counts as magnified.
    let minified = major_sq > R::ONE;
    if !minified {
        return one_tap(major_sq);
    }
    let det = ux * vy - uy * vx;
    let minor_sq = det * det / major_sq;
    let most = R::from_u32(anisotropy.into());
    let least_sq = major_sq / (most * most);
    let kept_sq = if minor_sq > least_sq { minor_sq } else { least_sq };
    // Below one texel there is nothing finer to read.
    let kept_sq = if kept_sq > R::ONE { kept_sq } else { R::ONE };
    // 1 % under the next whole number is still that number of taps.
    let taps = ((major_sq / kept_sq).sqrt() + R::from_f64(0.99)).to_u32().clamp(1, anisotropy.into());
    let mut f = one_tap(kept_sq);
    if taps > 1 {
        // The eigenvector of the major axis, by whichever row is better conditioned.
        let (x, y) = if difference > R::ZERO { (major_sq - c, b) } else { (b, major_sq - a) };
        let scale = (major_sq / (x * x + y * y)).sqrt() / R::from_u32(taps);
        f.taps = taps;
        f.step = [x * scale / w, y * scale / h];
    }
    f
}

/// Whole texel and fraction of a coordinate; the two neighbours by the address mode.
#[inline(always)]
fn neighbours<R: Real>(coordinate: R, size: u32, mode: AddressMode) -> (u32, u32, R) {
    let n = R::from_u32(size);
    let wrapped = match mode {
        AddressMode::Repeat => coordinate - floor(coordinate),
        AddressMode::ClampToEdge => coordinate,
    };
    let x = wrapped * n - R::from_f64(0.5);
    // Written so that NaN becomes the first texel.
    let x = if x > -R::ONE { x } else { -R::ONE };
    let x = if x < n { x } else { n };
    let whole = floor(x);
    let fraction = x - whole;
    let i = whole.to_i32();
    let last = size as i32 - 1;
    let (i0, i1) = match mode {
        AddressMode::Repeat => (if i < 0 { last } else { i.min(last) }, if i >= last { 0 } else { i + 1 }),
        AddressMode::ClampToEdge => (i.clamp(0, last), (i + 1).clamp(0, last)),
    };
    (i0 as u32, i1 as u32, fraction)
}

#[inline(always)]
fn bilinear<R: Real, D: Decode>(decode: D, level: &TexelLevel<'_>, uv: [R; 2], state: &SamplerState) -> [R; 4] {
    let (x0, x1, fx) = neighbours(uv[0], level.width, state.address_u);
    let (y0, y1, fy) = neighbours(uv[1], level.height, state.address_v);
    let texel = |x, y| decode.texel(level, x, y).map(from_f32::<R>);
    let (t00, t10, t01, t11) = (texel(x0, y0), texel(x1, y0), texel(x0, y1), texel(x1, y1));
    std::array::from_fn(|k| {
        let top = t00[k] + fx * (t10[k] - t00[k]);
        let bottom = t01[k] + fx * (t11[k] - t01[k]);
        top + fy * (bottom - top)
    })
}

#[inline(always)]
fn nearest_texel<R: Real>(coordinate: R, size: u32, mode: AddressMode) -> u32 {
    let n = R::from_u32(size);
    let wrapped = match mode {
        AddressMode::Repeat => coordinate - floor(coordinate),
        AddressMode::ClampToEdge => coordinate,
    };
    let x = wrapped * n;
    let x = if x > R::ZERO { x } else { R::ZERO };
    x.to_u32().min(size - 1)
}

/// One lane.
#[inline(always)]
pub fn sample<R: Real, D: Decode>(
    decode: D,
    levels: &[TexelLevel<'_>],
    uv: [R; 2],
    footprint: &Footprint<R>,
    state: &SamplerState,
) -> [R; 4] {
    let last = R::from_u32(levels.len() as u32 - 1);
    let level = if footprint.level > R::ZERO { footprint.level } else { R::ZERO };
    let level = if level < last { level } else { last };
    if !state.linear {
        let at = &levels[((level + R::from_f64(0.5)).to_u32() as usize).min(levels.len() - 1)];
        let (x, y) = (nearest_texel(uv[0], at.width, state.address_u), nearest_texel(uv[1], at.height, state.address_v));
        return decode.texel(at, x, y).map(from_f32::<R>);
    }
    let fine = (level.to_u32() as usize).min(levels.len() - 1);
    let between = level - R::from_u32(fine as u32);
    let mut sum = [R::ZERO; 4];
    let centre = R::from_f64(0.5) * (R::from_u32(footprint.taps) - R::ONE);
    for tap in 0..footprint.taps {
        let offset = R::from_u32(tap) - centre;
        let place = [uv[0] + offset * footprint.step[0], uv[1] + offset * footprint.step[1]];
        let mut value = bilinear(decode, &levels[fine], place, state);
        if between > R::ZERO && fine + 1 < levels.len() {
            let coarse = bilinear(decode, &levels[fine + 1], place, state);
            for k in 0..4 {
                value[k] = value[k] + between * (coarse[k] - value[k]);
            }
        }
        for k in 0..4 {
            sum[k] = sum[k] + value[k];
        }
    }
    if footprint.taps > 1 {
        let share = R::ONE / R::from_u32(footprint.taps);
        sum = sum.map(|v| v * share);
    }
    sum
}
