//! Computes the mip level and the taps that a lane reads from the gradients of its texture coordinates.
//!
//! A pixel's footprint is the ellipse, in texels, onto which the gradients map a circle of diameter 1 pixel. The lengths of its axes are the
//! singular values of the gradient matrix. Up to `max_taps` trilinear taps are spread evenly along the major axis, from end to end, and the mip
//! level is log2 of the minor axis (or of the major axis / `max_taps`, if that is greater), as in shaders/lib/filtered_map.wesl. The level of a
//! plain sampler is log2 of the longer gradient. Everything is branch-free, so that loops over lanes are vectorised. Gradients that are not finite
//! give an unspecified valid level and number of taps.

use crate::render::software::math::Real;

/// The taps of one lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint<R> {
    /// Mip level, before clamping.
    pub level: R,
    /// Number of taps, at least 1.
    pub taps: R,
    /// Step from one tap to the next, in texture coordinates.
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
    pub(crate) fn at_level(level: R) -> Self {
        Self { level, taps: R::ONE, step: [R::ZERO; 2] }
    }

    /// Isotropic filtering, one tap. `dx`, `dy`: gradients `[du, dv]` per pixel in x and in y; `size`: of the texture, in texels.
    #[inline(always)]
    pub(crate) fn isotropic(size: [R; 2], dx: [R; 2], dy: [R; 2]) -> Self {
        let (ux, vx, uy, vy) = (dx[0] * size[0], dx[1] * size[1], dy[0] * size[0], dy[1] * size[1]);
        let (dx_sq, dy_sq) = (ux * ux + vx * vx, uy * uy + vy * vy);
        Self::at_level(half_log2(if dx_sq > dy_sq { dx_sq } else { dy_sq }))
    }

    /// Anisotropic filtering: up to `max_taps` taps along the major axis, as in `filtered_map` of shaders/lib/filtered_map.wesl.
    #[inline(always)]
    pub(crate) fn anisotropic(size: [R; 2], dx: [R; 2], dy: [R; 2], max_taps: R) -> Self {
        let half = R::from_f64(0.5);
        let (ux, vx, uy, vy) = (dx[0] * size[0], dx[1] * size[1], dy[0] * size[0], dy[1] * size[1]);
        // For the gradient matrix J, J Jᵀ = [a b; b c]; its eigenvalues are the squares of the axes.
        let (a, c, b) = (ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy);
        let (mean, difference) = (half * (a + c), half * (a - c));
        let (dx_sq, dy_sq) = (ux * ux + vx * vx, uy * uy + vy * vy);
        let longest_sq = if dx_sq > dy_sq { dx_sq } else { dy_sq };
        let major_sq = if max_taps > R::ONE { mean + (difference * difference + b * b).sqrt() } else { longest_sq };
        let det = ux * vy - uy * vx;
        let minor_sq = det * det / major_sq;
        let min_width_sq = major_sq / (max_taps * max_taps);
        // Width of one tap, squared.
        let width_sq = if minor_sq > min_width_sq { minor_sq } else { min_width_sq };
        // At least one texel, since no level is finer than level 0. NaN becomes one texel as well.
        let width_sq = if width_sq > R::ONE { width_sq } else { R::ONE };
        // Rounded up, unless the excess over an integer is below 0.01.
        let taps = floor((major_sq / width_sq).sqrt() + R::from_f64(0.99));
        let taps = if taps < max_taps { taps } else { max_taps };
        let taps = if taps > R::ONE { taps } else { R::ONE };
        // The eigenvector of the major axis, computed from the better conditioned row of the matrix.
        let is_wide = difference > R::ZERO;
        let x = if is_wide { major_sq - c } else { b };
        let y = if is_wide { b } else { major_sq - a };
        let has_several_taps = taps > R::ONE;
        // The outermost taps end at the ends of the major axis, so the distance between their centres is the axis length minus the width of a tap.
        let spread = major_sq.sqrt() - width_sq.sqrt();
        let scale = spread / ((x * x + y * y).sqrt() * if has_several_taps { taps - R::ONE } else { R::ONE });
        let step_u = if has_several_taps { x * scale / size[0] } else { R::ZERO };
        let step_v = if has_several_taps { y * scale / size[1] } else { R::ZERO };
        Self { level: half_log2(width_sq), taps, step: [step_u, step_v] }
    }
}

#[inline(always)]
fn half_log2<R: Real>(square: R) -> R {
    R::from_f64(0.5) * square.log2::<false>()
}
