//! Elementary functions for lanes, branch-free so that the compiler turns a loop over lanes into vector code.
//!
//! Every function is generic over `F`: true uses fused multiply-add, false rounds product and sum separately. For a given `F` the result
//! is the same bit pattern in every kernel class, because only IEEE basic operations occur. Errors are measured in tests/software/math.rs.
//!
//! f32 `sin` and `cos` reduce the argument in f64. f32 `pow` evaluates f64 polynomials whose length suffices for an f32 result. The less
//! frequent f32 functions (tan, hyperbolic and inverse hyperbolic) round the result of the f64 function.

pub mod double;
pub mod single;

use super::kernels::class::Kernels;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A lane element: f32, or f64 for measuring the rounding error of the same shader. Integers and masks are bit-cast and stored in the same slots:
/// integers as the low 32 bits, masks as all zeros or all ones.
pub trait Real:
    Copy
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Kernels
{
    const ZERO: Self;
    const ONE: Self;
    /// An integer's bits as an element.
    fn from_int(bits: u32) -> Self;
    /// The low 32 bits, as an integer's bits.
    fn int(self) -> u32;
    fn from_mask(set: bool) -> Self;
    fn mask(self) -> bool;
    fn from_f64(x: f64) -> Self;
    fn f64(self) -> f64;
    /// The same slice if the elements are f32.
    fn as_f32(values: &[Self]) -> Option<&[f32]>;
    /// Bitwise operations on all bits of the element, for masks and integers.
    fn bit_and(self, b: Self) -> Self;
    fn bit_or(self, b: Self) -> Self;
    fn bit_xor(self, b: Self) -> Self;
    fn bit_not(self) -> Self;
    /// The bits of the value rounded to f32, and the reverse (WGSL `bitcast`).
    fn f32_bits(self) -> u32;
    fn from_f32_bits(bits: u32) -> Self;
    /// Saturating conversions; NaN becomes 0.
    fn to_i32(self) -> i32;
    fn to_u32(self) -> u32;
    fn from_i32(i: i32) -> Self;
    fn from_u32(u: u32) -> Self;
    fn fma<const F: bool>(self, b: Self, c: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// Magnitude of self, sign of `s`.
    fn with_sign(self, s: Self) -> Self;
    /// Nearest integer, ties to even.
    fn round(self) -> Self;
    /// [`Real::round`], floor and truncation: one instruction on machines that have it, a library call on others.
    fn round_native(self) -> Self;
    fn floor_native(self) -> Self;
    fn trunc_native(self) -> Self;
    /// The nearest integer (ties to even), as an element and as an integer, for |self| <= 2^22; unspecified for larger values and NaN.
    fn round_small(self) -> (Self, i32);
    fn is_nan(self) -> bool;
    fn is_inf(self) -> bool;
    /// self times 2^n.
    fn ldexp(self, n: i32) -> Self;
    fn exp<const F: bool>(self) -> Self;
    fn exp2<const F: bool>(self) -> Self;
    fn log<const F: bool>(self) -> Self;
    fn log2<const F: bool>(self) -> Self;
    fn sin<const F: bool>(self) -> Self;
    fn cos<const F: bool>(self) -> Self;
    fn tan<const F: bool>(self) -> Self;
    fn asin<const F: bool>(self) -> Self;
    fn acos<const F: bool>(self) -> Self;
    fn atan2<const F: bool>(self, x: Self) -> Self;
    fn sinh<const F: bool>(self) -> Self;
    fn cosh<const F: bool>(self) -> Self;
    fn tanh<const F: bool>(self) -> Self;
    fn asinh<const F: bool>(self) -> Self;
    fn acosh<const F: bool>(self) -> Self;
    fn atanh<const F: bool>(self) -> Self;
    fn pow<const F: bool>(self, y: Self) -> Self;
}

macro_rules! common {
    ($t:ty, $bits:ty, $module:ident, $magic:expr) => {
        const ZERO: Self = 0.0;
        const ONE: Self = 1.0;
        #[inline(always)]
        fn from_int(bits: u32) -> Self {
            <$t>::from_bits(<$bits>::from(bits))
        }
        #[inline(always)]
        fn int(self) -> u32 {
            self.to_bits() as u32
        }
        #[inline(always)]
        fn from_mask(set: bool) -> Self {
            <$t>::from_bits((0 as $bits).wrapping_sub(<$bits>::from(set)))
        }
        #[inline(always)]
        fn mask(self) -> bool {
            self.to_bits() != 0
        }
        #[inline(always)]
        fn from_f64(x: f64) -> Self {
            x as $t
        }
        #[inline(always)]
        fn f64(self) -> f64 {
            f64::from(self)
        }
        #[inline(always)]
        fn bit_and(self, b: Self) -> Self {
            <$t>::from_bits(self.to_bits() & b.to_bits())
        }
        #[inline(always)]
        fn bit_or(self, b: Self) -> Self {
            <$t>::from_bits(self.to_bits() | b.to_bits())
        }
        #[inline(always)]
        fn bit_xor(self, b: Self) -> Self {
            <$t>::from_bits(self.to_bits() ^ b.to_bits())
        }
        #[inline(always)]
        fn bit_not(self) -> Self {
            <$t>::from_bits(!self.to_bits())
        }
        #[inline(always)]
        fn f32_bits(self) -> u32 {
            (self as f32).to_bits()
        }
        #[inline(always)]
        fn from_f32_bits(bits: u32) -> Self {
            <$t>::from(f32::from_bits(bits))
        }
        #[inline(always)]
        fn to_i32(self) -> i32 {
            // Equals `self as i32`, in steps that have vector instructions.
            const LIMIT: $t = 2_147_483_648.0;
            let over = self >= LIMIT;
            let under = self < -LIMIT;
            let inside = if over | under | (self != self) { 0.0 } else { self };
            // SAFETY: values outside i32 have been replaced by zero.
            let k = unsafe { inside.to_int_unchecked::<i32>() };
            let k = if over { i32::MAX } else { k };
            if under { i32::MIN } else { k }
        }
        #[inline(always)]
        fn to_u32(self) -> u32 {
            self as u32
        }
        #[inline(always)]
        fn from_i32(i: i32) -> Self {
            i as $t
        }
        #[inline(always)]
        fn from_u32(u: u32) -> Self {
            u as $t
        }
        #[inline(always)]
        fn fma<const F: bool>(self, b: Self, c: Self) -> Self {
            if F { self.mul_add(b, c) } else { self * b + c }
        }
        #[inline(always)]
        fn abs(self) -> Self {
            <$t>::abs(self)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            <$t>::sqrt(self)
        }
        #[inline(always)]
        fn with_sign(self, s: Self) -> Self {
            self.copysign(s)
        }
        #[inline(always)]
        fn round(self) -> Self {
            // Adding and subtracting 2^(mantissa bits) rounds to nearest even; larger values are integers already.
            let a = <$t>::abs(self);
            let r = (a + $magic) - $magic;
            (if a < $magic { r } else { a }).copysign(self)
        }
        #[inline(always)]
        fn round_native(self) -> Self {
            self.round_ties_even()
        }
        #[inline(always)]
        fn floor_native(self) -> Self {
            self.floor()
        }
        #[inline(always)]
        fn trunc_native(self) -> Self {
            self.trunc()
        }
        #[inline(always)]
        fn round_small(self) -> (Self, i32) {
            // After adding 1.5 * 2^(mantissa bits), the low bits are the integer. A saturating conversion has no vector instruction.
            const MAGIC: $t = 1.5 * $magic;
            let sum = self + MAGIC;
            (sum - MAGIC, (sum.to_bits() as i32).wrapping_sub(MAGIC.to_bits() as i32))
        }
        #[inline(always)]
        fn is_nan(self) -> bool {
            self != self
        }
        #[inline(always)]
        fn is_inf(self) -> bool {
            <$t>::abs(self) == <$t>::INFINITY
        }
        #[inline(always)]
        fn ldexp(self, n: i32) -> Self {
            $module::scale(self, n)
        }
        #[inline(always)]
        fn exp<const F: bool>(self) -> Self {
            $module::exp::<F>(self)
        }
        #[inline(always)]
        fn exp2<const F: bool>(self) -> Self {
            $module::exp2::<F>(self)
        }
        #[inline(always)]
        fn log<const F: bool>(self) -> Self {
            $module::log::<F>(self)
        }
        #[inline(always)]
        fn log2<const F: bool>(self) -> Self {
            $module::log2::<F>(self)
        }
        #[inline(always)]
        fn sin<const F: bool>(self) -> Self {
            $module::sin_cos::<F, false>(self)
        }
        #[inline(always)]
        fn cos<const F: bool>(self) -> Self {
            $module::sin_cos::<F, true>(self)
        }
        #[inline(always)]
        fn asin<const F: bool>(self) -> Self {
            $module::asin::<F>(self)
        }
        #[inline(always)]
        fn acos<const F: bool>(self) -> Self {
            $module::acos::<F>(self)
        }
        #[inline(always)]
        fn atan2<const F: bool>(self, x: Self) -> Self {
            $module::atan2::<F>(self, x)
        }
        #[inline(always)]
        fn tan<const F: bool>(self) -> Self {
            double::tan::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn sinh<const F: bool>(self) -> Self {
            double::sinh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn cosh<const F: bool>(self) -> Self {
            double::cosh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn tanh<const F: bool>(self) -> Self {
            double::tanh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn asinh<const F: bool>(self) -> Self {
            double::asinh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn acosh<const F: bool>(self) -> Self {
            double::acosh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn atanh<const F: bool>(self) -> Self {
            double::atanh::<F>(f64::from(self)) as $t
        }
        #[inline(always)]
        fn pow<const F: bool>(self, y: Self) -> Self {
            $module::pow::<F>(self, y)
        }
    };
}

impl Real for f32 {
    common!(f32, u32, single, 8_388_608.0);
    #[inline(always)]
    fn as_f32(values: &[Self]) -> Option<&[f32]> {
        Some(values)
    }
}

impl Real for f64 {
    common!(f64, u64, double, 4_503_599_627_370_496.0);
    #[inline(always)]
    fn as_f32(_: &[Self]) -> Option<&[f32]> {
        None
    }
}

/// Horner's rule, highest coefficient first.
#[inline(always)]
pub(crate) fn horner<R: Real, const F: bool, const K: usize>(x: R, c: [R; K]) -> R {
    let mut y = c[0];
    let mut k = 1;
    while k < K {
        y = y.fma::<F>(x, c[k]);
        k += 1;
    }
    y
}
