//! Vectors of f32 for the hand-written shader: eight lanes with AVX2 and FMA, sixteen with AVX-512. x86-64 only.
//!
//! Both modules export the same names, so that the macro in `by_hand.rs` writes the shader for both. A mask has one truth value per lane.

macro_rules! two_operands {
    ($features:literal, $vector:ty, $($name:ident = $intrinsic:ident),*) => { $(
        #[target_feature(enable = $features)]
        pub fn $name(a: $vector, b: $vector) -> $vector { $intrinsic(a, b) }
    )* };
}

/// Eight lanes.
pub mod avx2 {
    use std::arch::x86_64::*;

    pub type Vector = __m256;
    pub type Mask = __m256;
    pub const LANES: usize = 8;

    two_operands!(
        "avx2,fma",
        Vector,
        add = _mm256_add_ps,
        sub = _mm256_sub_ps,
        mul = _mm256_mul_ps,
        div = _mm256_div_ps,
        min = _mm256_min_ps,
        max = _mm256_max_ps
    );

    /// The same value in all lanes.
    #[target_feature(enable = "avx2,fma")]
    pub fn splat(x: f32) -> Vector {
        _mm256_set1_ps(x)
    }
    /// `a` times `b` plus `c`.
    #[target_feature(enable = "avx2,fma")]
    pub fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm256_fmadd_ps(a, b, c)
    }
    /// `a` times `b` minus `c`.
    #[target_feature(enable = "avx2,fma")]
    pub fn fma_minus(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm256_fmsub_ps(a, b, c)
    }
    /// `c` minus `a` times `b`.
    #[target_feature(enable = "avx2,fma")]
    pub fn minus_product(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm256_fnmadd_ps(a, b, c)
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn sqrt(a: Vector) -> Vector {
        _mm256_sqrt_ps(a)
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn floor(a: Vector) -> Vector {
        _mm256_floor_ps(a)
    }
    /// The nearest whole number, ties to even.
    #[target_feature(enable = "avx2,fma")]
    pub fn round(a: Vector) -> Vector {
        _mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(a)
    }
    /// `a` times 2^n. `n` is whole, from -126 to 127.
    #[target_feature(enable = "avx2,fma")]
    pub fn scale_by_power(a: Vector, n: Vector) -> Vector {
        let power = _mm256_slli_epi32::<23>(_mm256_add_epi32(_mm256_cvtps_epi32(n), _mm256_set1_epi32(127)));
        _mm256_mul_ps(a, _mm256_castsi256_ps(power))
    }
    /// Where `a` is less than `b`.
    #[target_feature(enable = "avx2,fma")]
    pub fn less(a: Vector, b: Vector) -> Mask {
        _mm256_cmp_ps::<_CMP_LT_OQ>(a, b)
    }
    /// `yes` where the mask is set, otherwise `no`.
    #[target_feature(enable = "avx2,fma")]
    pub fn select(no: Vector, yes: Vector, mask: Mask) -> Vector {
        _mm256_blendv_ps(no, yes, mask)
    }
    /// Whether the mask is set in at least one lane.
    #[target_feature(enable = "avx2,fma")]
    pub fn any(mask: Mask) -> bool {
        _mm256_movemask_ps(mask) != 0
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn abs(a: Vector) -> Vector {
        _mm256_andnot_ps(splat(-0.0), a)
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn neg(a: Vector) -> Vector {
        _mm256_xor_ps(splat(-0.0), a)
    }
    /// `a` with the sign of `b`. The sign bit of `a` must be 0.
    #[target_feature(enable = "avx2,fma")]
    pub fn with_sign(a: Vector, b: Vector) -> Vector {
        _mm256_or_ps(a, _mm256_and_ps(b, splat(-0.0)))
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn load(values: &[f32; LANES]) -> Vector {
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm256_loadu_ps(values.as_ptr()) }
    }
    #[target_feature(enable = "avx2,fma")]
    pub fn store(a: Vector) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), a) };
        values
    }
    /// The lanes, rounded to whole numbers, ties to even.
    #[target_feature(enable = "avx2,fma")]
    pub fn store_i32(a: Vector) -> [i32; LANES] {
        let mut values = [0; LANES];
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm256_storeu_si256(values.as_mut_ptr().cast(), _mm256_cvtps_epi32(a)) };
        values
    }
}

/// Sixteen lanes.
pub mod avx512 {
    use std::arch::x86_64::*;

    pub type Vector = __m512;
    pub type Mask = __mmask16;
    pub const LANES: usize = 16;

    two_operands!(
        "avx512f,avx512dq",
        Vector,
        add = _mm512_add_ps,
        sub = _mm512_sub_ps,
        mul = _mm512_mul_ps,
        div = _mm512_div_ps,
        min = _mm512_min_ps,
        max = _mm512_max_ps
    );

    /// The same value in all lanes.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn splat(x: f32) -> Vector {
        _mm512_set1_ps(x)
    }
    /// `a` times `b` plus `c`.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn fma(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm512_fmadd_ps(a, b, c)
    }
    /// `a` times `b` minus `c`.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn fma_minus(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm512_fmsub_ps(a, b, c)
    }
    /// `c` minus `a` times `b`.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn minus_product(a: Vector, b: Vector, c: Vector) -> Vector {
        _mm512_fnmadd_ps(a, b, c)
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn sqrt(a: Vector) -> Vector {
        _mm512_sqrt_ps(a)
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn floor(a: Vector) -> Vector {
        _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(a)
    }
    /// The nearest whole number, ties to even.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn round(a: Vector) -> Vector {
        _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(a)
    }
    /// `a` times 2^n. `n` is whole.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn scale_by_power(a: Vector, n: Vector) -> Vector {
        _mm512_scalef_ps(a, n)
    }
    /// Where `a` is less than `b`.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn less(a: Vector, b: Vector) -> Mask {
        _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)
    }
    /// `yes` where the mask is set, otherwise `no`.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn select(no: Vector, yes: Vector, mask: Mask) -> Vector {
        _mm512_mask_blend_ps(mask, no, yes)
    }
    /// Whether the mask is set in at least one lane.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn any(mask: Mask) -> bool {
        mask != 0
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn abs(a: Vector) -> Vector {
        _mm512_abs_ps(a)
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn neg(a: Vector) -> Vector {
        _mm512_xor_ps(splat(-0.0), a)
    }
    /// `a` with the sign of `b`. The sign bit of `a` must be 0.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn with_sign(a: Vector, b: Vector) -> Vector {
        _mm512_or_ps(a, _mm512_and_ps(b, splat(-0.0)))
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn load(values: &[f32; LANES]) -> Vector {
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm512_loadu_ps(values.as_ptr()) }
    }
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn store(a: Vector) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm512_storeu_ps(values.as_mut_ptr(), a) };
        values
    }
    /// The lanes, rounded to whole numbers, ties to even.
    #[target_feature(enable = "avx512f,avx512dq")]
    pub fn store_i32(a: Vector) -> [i32; LANES] {
        let mut values = [0; LANES];
        // SAFETY: the array has as many numbers as the vector has lanes.
        unsafe { _mm512_storeu_si512(values.as_mut_ptr().cast(), _mm512_cvtps_epi32(a)) };
        values
    }
}
