//! From texture coordinates and their gradients to what each lane of a batch reads: a mip level and a row of taps.
//!
//! A pixel's footprint is the ellipse that its unit circle becomes in texels. Its axes are the singular values of the gradient matrix; up to
//! `most` trilinear taps are spread evenly along the major axis, from end to end, and the mip level is log2 of the minor one (or of the major over
//! `most`, whichever is greater): the formula of shaders/lib/filtered_map.wesl. A plain sampler's level is log2 of the longer
//! gradient. Everything is branch-free, so that a loop over lanes becomes vector code. Gradients that are not finite give some level and
//! some taps.

use crate::render::software::math::Real;

/// The taps of one lane.
#[derive(Clone, Copy, Debug)]
pub struct Footprint<R> {
    /// Mip level, not yet clamped.
    pub level: R,
    /// A whole number from 1 on.
    pub taps: R,
    /// Step from tap to tap in texture coordinates.
    pub step: [R; 2],
}

#[inline(always)]
pub(super) fn floor<R: Real>(x: R) -> R {
    let r = x.round();
    if r > x { r - R::ONE } else { r }
}

impl<R: Real> Footprint<R> {
    /// One tap at a given level.
    #[inline(always)]
    pub fn at_level(level: R) -> Self {
        Self { level, taps: R::ONE, step: [R::ZERO; 2] }
    }

    /// Of gradients `[du, dv]` per pixel in x and in y, on a texture of `size` texels: one tap.
    #[inline(always)]
    pub fn isotropic(size: [R; 2], dx: [R; 2], dy: [R; 2]) -> Self {
        let (ux, vx, uy, vy) = (dx[0] * size[0], dx[1] * size[1], dy[0] * size[0], dy[1] * size[1]);
        let (x, y) = (ux * ux + vx * vx, uy * uy + vy * vy);
        Self::at_level(half_log2(if x > y { x } else { y }))
    }

    /// The same with up to `most` taps along the major axis, as `filtered_map` of shaders/lib/filtered_map.wesl has them.
    #[inline(always)]
    pub fn elongated(size: [R; 2], dx: [R; 2], dy: [R; 2], most: R) -> Self {
        let half = R::from_f64(0.5);
        let (ux, vx, uy, vy) = (dx[0] * size[0], dx[1] * size[1], dy[0] * size[0], dy[1] * size[1]);
        // J Jᵀ = [a b; b c]; its eigenvalues are the squares of the axes.
        let (a, c, b) = (ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy);
        let (mean, difference) = (half * (a + c), half * (a - c));
        let (x, y) = (ux * ux + vx * vx, uy * uy + vy * vy);
        let longest_sq = if x > y { x } else { y };
        let major_sq = if most > R::ONE { mean + (difference * difference + b * b).sqrt() } else { longest_sq };
        let det = ux * vy - uy * vx;
        let minor_sq = det * det / major_sq;
        let least_sq = major_sq / (most * most);
        let kept_sq = if minor_sq > least_sq { minor_sq } else { least_sq };
        // Below one texel there is nothing finer to read; so is NaN.
        let kept_sq = if kept_sq > R::ONE { kept_sq } else { R::ONE };
        // 1 % under the next whole number is still that number of taps.
        let taps = floor((major_sq / kept_sq).sqrt() + R::from_f64(0.99));
        let taps = if taps < most { taps } else { most };
        let taps = if taps > R::ONE { taps } else { R::ONE };
        // The eigenvector of the major axis, by whichever row is better conditioned.
        let wide = difference > R::ZERO;
        let x = if wide { major_sq - c } else { b };
        let y = if wide { b } else { major_sq - a };
        let many = taps > R::ONE;
        // The outermost taps, as wide as the minor axis, end with the major one: a second tap begins where the first is.
        let spread = major_sq.sqrt() - kept_sq.sqrt();
        let scale = spread / ((x * x + y * y).sqrt() * if many { taps - R::ONE } else { R::ONE });
        let step_u = if many { x * scale / size[0] } else { R::ZERO };
        let step_v = if many { y * scale / size[1] } else { R::ZERO };
        Self { level: half_log2(kept_sq), taps, step: [step_u, step_v] }
    }
}

#[inline(always)]
fn half_log2<R: Real>(square: R) -> R {
    R::from_f64(0.5) * square.log2::<false>()
}
