//! Bilinear interpolation in AVX2 registers, for eight points at a time.
//!
//! [`Corners::new`] turns the columns and rows of texels beside each point into the indices of its four corners in the level. The caller reads the texels at
//! the corners. [`bilinear`] interpolates between their values.

use std::arch::x86_64::{__m256, __m256i, _mm256_add_epi32, _mm256_add_ps, _mm256_mul_ps, _mm256_mullo_epi32, _mm256_sub_ps};

/// For each of eight points, the neighbouring columns or rows on both sides, and the point's position between them.
pub(super) struct TexelsBeside {
    /// Indices of the columns to the left and to the right, or of the rows above and below.
    pub indices: [__m256i; 2],
    /// From 0 at the first index to 1 at the second.
    pub fraction: __m256,
}

/// For each of eight points, the four texels around it, and its fractions between them.
pub(crate) struct Corners {
    /// Indices of the texels in the level, counted row by row: top left, top right, bottom left, bottom right.
    pub index: [__m256i; 4],
    /// The point's position between the left and the right texels, and between the upper and the lower ones, each from 0 to 1.
    pub fraction: [__m256; 2],
}

impl Corners {
    /// The corners between two columns and two rows of a level. `width`: the level's width in texels, the same in all eight elements.
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn new(width: __m256i, columns: TexelsBeside, rows: TexelsBeside) -> Self {
        // SAFETY: the caller guarantees AVX2.
        unsafe {
            let [left, right] = columns.indices;
            let [above, below] = [_mm256_mullo_epi32(rows.indices[0], width), _mm256_mullo_epi32(rows.indices[1], width)];
            let index = [
                _mm256_add_epi32(above, left),
                _mm256_add_epi32(above, right),
                _mm256_add_epi32(below, left),
                _mm256_add_epi32(below, right),
            ];
            Self { index, fraction: [columns.fraction, rows.fraction] }
        }
    }
}

/// Bilinear interpolation of one channel, given at the corners in the order of [`Corners::index`], by the fractions `x` and `y` ([`Corners::fraction`]).
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn bilinear([a, b, c, d]: [__m256; 4], [x, y]: [__m256; 2]) -> __m256 {
    // SAFETY: the caller guarantees AVX2.
    unsafe {
        let top = _mm256_add_ps(a, _mm256_mul_ps(x, _mm256_sub_ps(b, a)));
        let bottom = _mm256_add_ps(c, _mm256_mul_ps(x, _mm256_sub_ps(d, c)));
        _mm256_add_ps(top, _mm256_mul_ps(y, _mm256_sub_ps(bottom, top)))
    }
}
