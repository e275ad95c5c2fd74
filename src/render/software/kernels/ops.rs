//! The only definition of what each operation computes on one lane. Constant folding, operations on registers and the SIMD kernels share it. A lane is
//! stored as a float, f32 or f64: an integer in its low 32 bits (`Real::lane_bits`), a mask (boolean) in all its bits. `Real::f32_bits` instead are the
//! bits of a float lane's value rounded to f32 (WGSL `bitcast`).
//!
//! In: up to three operands. Out: the result. Always: no operation traps, whatever its operands; integer division by zero and shifts beyond 31 bits have the
//! results that WGSL specifies.

use crate::render::software::math::Real;
use crate::render::software::tape::Op;

/// One operation on one lane; unused operands are ignored. `FMA`: whether the kernel class has fused multiply-add.
pub(crate) trait Eval {
    /// Number of operands.
    const ARITY: usize;
    fn eval<R: Real, const FMA: bool>(a: R, b: R, c: R) -> R;
}

/// Defines a type for each operation, by the expression of its result. [`Op`] explains the prefixes of the names. `$r`: the element type; `$f`: whether the
/// kernel class has fused multiply-add; `$a`, `$b`, `$c`: the operands.
macro_rules! eval {
    ($($name:ident = |$r:ident, $f:ident, $a:pat_param, $b:pat_param, $c:pat_param| $body:expr;)*) => {$(
        pub struct $name;
        impl Eval for $name {
            const ARITY: usize = Op::$name.arity();
            #[inline(always)]
            fn eval<$r: Real, const $f: bool>($a: $r, $b: $r, $c: $r) -> $r { $body }
        }
    )*};
}

/// The integer that a lane stores, as a signed one.
#[inline(always)]
fn signed<R: Real>(a: R) -> i32 {
    a.lane_bits() as i32
}
#[inline(always)]
fn from_signed<R: Real>(i: i32) -> R {
    R::from_lane_bits(i as u32)
}
// `trunc`, `floor` and `round`: classes with fused multiply-add have a rounding instruction; the others round by adding and subtracting a power of two. Both
// ways are exact, so the bits are the same.
#[inline(always)]
fn trunc<R: Real, const FMA: bool>(a: R) -> R {
    if FMA {
        return a.trunc_native();
    }
    let magnitude = a.abs();
    let rounded = magnitude.round();
    (if rounded > magnitude { rounded - R::ONE } else { rounded }).with_sign(a)
}
#[inline(always)]
fn floor<R: Real, const FMA: bool>(a: R) -> R {
    if FMA {
        return a.floor_native();
    }
    let rounded = a.round();
    if rounded > a { rounded - R::ONE } else { rounded }
}
#[inline(always)]
fn round<R: Real, const FMA: bool>(a: R) -> R {
    if FMA { a.round_native() } else { a.round() }
}

/// IEEE half precision of a value, ties to even, as 16 bits.
#[inline(always)]
fn to_half(x: f32) -> u32 {
    let bits = x.to_bits();
    let sign = (bits >> 16) & 0x8000;
    // The bits of |x|.
    let a = bits & 0x7fff_ffff;
    // A subnormal half is a multiple of 2^-24, and so is every float from 0.5 to 1: adding 0.5 rounds |x| to such a multiple, whose number is in the low bits.
    let subnormal = (f32::from_bits(a) + 0.5).to_bits().wrapping_sub(0x3f00_0000);
    // Adding 0xc8000000 (-112 << 23) changes the exponent's bias from 127 to 15; 0xfff and the lowest kept bit round to nearest, ties to even.
    let normal = a.wrapping_add(0xc800_0fff).wrapping_add((a >> 13) & 1) >> 13;
    // 2^-14 is the smallest normal half; values from 2^16 on are beyond all halves.
    let finite = if a < 0x3880_0000 { subnormal } else { normal };
    let nan_or_infinity = if a > 0x7f80_0000 { 0x7e00 } else { 0x7c00 };
    sign | if a >= 0x4780_0000 { nan_or_infinity } else { finite }
}

/// The value of the 16 bits of a half-precision number.
#[inline(always)]
fn from_half(h: u32) -> f32 {
    let sign = (h & 0x8000) << 16;
    let magnitude = h & 0x7fff;
    let finite = f32::from_bits(magnitude << 13) * 5.192_296_9e33; // 2^112, the difference of the biases
    let nan_or_infinity = f32::from_bits((magnitude << 13) | 0x7f80_0000);
    let y = if magnitude >= 0x7c00 { nan_or_infinity } else { finite };
    f32::from_bits(y.to_bits() | sign)
}

#[inline(always)]
fn leading_zeros(mut x: u32) -> u32 {
    // Copies the highest set bit to all lower bits, then counts; this vectorises without a count-leading-zeros instruction.
    x |= x >> 1;
    x |= x >> 2;
    x |= x >> 4;
    x |= x >> 8;
    x |= x >> 16;
    count_ones(!x)
}
/// The sum of the bits by pairs, nibbles and bytes (Warren, Hacker's Delight, 5-1), which vectorises without a population-count instruction.
#[inline(always)]
fn count_ones(x: u32) -> u32 {
    let x = x - ((x >> 1) & 0x5555_5555);
    let x = (x & 0x3333_3333) + ((x >> 2) & 0x3333_3333);
    (((x + (x >> 4)) & 0x0f0f_0f0f).wrapping_mul(0x0101_0101)) >> 24
}
#[inline(always)]
fn trailing_zeros(x: u32) -> u32 {
    count_ones(!x & x.wrapping_sub(1))
}

eval! {
    Copy = |R, FMA, a, _, _| a;
    Neg = |R, FMA, a, _, _| -a;
    Abs = |R, FMA, a, _, _| a.abs();
    Sqrt = |R, FMA, a, _, _| a.sqrt();
    InverseSqrt = |R, FMA, a, _, _| R::ONE / a.sqrt();
    Floor = |R, FMA, a, _, _| floor::<R, FMA>(a);
    Ceil = |R, FMA, a, _, _| -floor::<R, FMA>(-a);
    Round = |R, FMA, a, _, _| round::<R, FMA>(a);
    Trunc = |R, FMA, a, _, _| trunc::<R, FMA>(a);
    Fract = |R, FMA, a, _, _| a - floor::<R, FMA>(a);
    Sign = |R, FMA, a, _, _| if a > R::ZERO { R::ONE } else if a < R::ZERO { -R::ONE } else { R::ZERO };
    Exp = |R, FMA, a, _, _| a.exp::<FMA>();
    Exp2 = |R, FMA, a, _, _| a.exp2::<FMA>();
    Log = |R, FMA, a, _, _| a.log::<FMA>();
    Log2 = |R, FMA, a, _, _| a.log2::<FMA>();
    Sin = |R, FMA, a, _, _| a.sin::<FMA>();
    Cos = |R, FMA, a, _, _| a.cos::<FMA>();
    Tan = |R, FMA, a, _, _| a.tan::<FMA>();
    Asin = |R, FMA, a, _, _| a.asin::<FMA>();
    Acos = |R, FMA, a, _, _| a.acos::<FMA>();
    Atan = |R, FMA, a, _, _| a.atan2::<FMA>(R::ONE);
    Sinh = |R, FMA, a, _, _| a.sinh::<FMA>();
    Cosh = |R, FMA, a, _, _| a.cosh::<FMA>();
    Tanh = |R, FMA, a, _, _| a.tanh::<FMA>();
    Asinh = |R, FMA, a, _, _| a.asinh::<FMA>();
    Acosh = |R, FMA, a, _, _| a.acosh::<FMA>();
    Atanh = |R, FMA, a, _, _| a.atanh::<FMA>();
    QuantizeF16 = |R, FMA, a, _, _| R::from_f64(f64::from(from_half(to_half(f32::from_bits(a.f32_bits())))));
    F16FromF = |R, FMA, a, _, _| R::from_lane_bits(to_half(f32::from_bits(a.f32_bits())));
    FFromF16 = |R, FMA, a, _, _| R::from_f64(f64::from(from_half(a.lane_bits())));
    IsNan = |R, FMA, a, _, _| R::from_mask(a.is_nan());
    IsInf = |R, FMA, a, _, _| R::from_mask(a.is_inf());
    INeg = |R, FMA, a, _, _| from_signed(signed(a).wrapping_neg());
    IAbs = |R, FMA, a, _, _| from_signed(signed(a).wrapping_abs());
    ISign = |R, FMA, a, _, _| from_signed(signed(a).signum());
    INot = |R, FMA, a, _, _| R::from_lane_bits(!a.lane_bits());
    BNot = |R, FMA, a, _, _| a.bit_not();
    CountOneBits = |R, FMA, a, _, _| R::from_lane_bits(count_ones(a.lane_bits()));
    LeadingZeros = |R, FMA, a, _, _| R::from_lane_bits(leading_zeros(a.lane_bits()));
    TrailingZeros = |R, FMA, a, _, _| R::from_lane_bits(trailing_zeros(a.lane_bits()));
    ReverseBits = |R, FMA, a, _, _| R::from_lane_bits(a.lane_bits().reverse_bits());
    // Of 0, 31 - 32 = -1: the result that WGSL specifies.
    FirstLeadingBitU = |R, FMA, a, _, _| R::from_lane_bits(31u32.wrapping_sub(leading_zeros(a.lane_bits())));
    FirstLeadingBitI = |R, FMA, a, _, _| R::from_lane_bits(31u32.wrapping_sub(leading_zeros(a.lane_bits() ^ ((signed(a) >> 31) as u32))));
    FirstTrailingBit = |R, FMA, a, _, _| R::from_lane_bits(if a.lane_bits() == 0 { u32::MAX } else { trailing_zeros(a.lane_bits()) });
    IFromF = |R, FMA, a, _, _| from_signed(a.to_i32());
    UFromF = |R, FMA, a, _, _| R::from_lane_bits(a.to_u32());
    FFromI = |R, FMA, a, _, _| R::from_i32(signed(a));
    FFromU = |R, FMA, a, _, _| R::from_u32(a.lane_bits());
    BitsFromF = |R, FMA, a, _, _| R::from_lane_bits(a.f32_bits());
    FFromBits = |R, FMA, a, _, _| R::from_f32_bits(a.lane_bits());
    Add = |R, FMA, a, b, _| a + b;
    Sub = |R, FMA, a, b, _| a - b;
    Mul = |R, FMA, a, b, _| a * b;
    Div = |R, FMA, a, b, _| a / b;
    // Min and Max give the second operand if one is NaN or both are equal.
    Min = |R, FMA, a, b, _| if a < b { a } else { b };
    Max = |R, FMA, a, b, _| if a > b { a } else { b };
    FRem = |R, FMA, a, b, _| a - b * trunc::<R, FMA>(a / b);
    Pow = |R, FMA, a, b, _| a.pow::<FMA>(b);
    Atan2 = |R, FMA, a, b, _| a.atan2::<FMA>(b);
    Ldexp = |R, FMA, a, b, _| a.ldexp(signed(b));
    FLt = |R, FMA, a, b, _| R::from_mask(a < b);
    FLe = |R, FMA, a, b, _| R::from_mask(a <= b);
    FEq = |R, FMA, a, b, _| R::from_mask(a == b);
    FNe = |R, FMA, a, b, _| R::from_mask(a != b);
    ILt = |R, FMA, a, b, _| R::from_mask(signed(a) < signed(b));
    ILe = |R, FMA, a, b, _| R::from_mask(signed(a) <= signed(b));
    ULt = |R, FMA, a, b, _| R::from_mask(a.lane_bits() < b.lane_bits());
    ULe = |R, FMA, a, b, _| R::from_mask(a.lane_bits() <= b.lane_bits());
    IEq = |R, FMA, a, b, _| R::from_mask(a.lane_bits() == b.lane_bits());
    INe = |R, FMA, a, b, _| R::from_mask(a.lane_bits() != b.lane_bits());
    IAdd = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().wrapping_add(b.lane_bits()));
    ISub = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().wrapping_sub(b.lane_bits()));
    IMul = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().wrapping_mul(b.lane_bits()));
    IDiv = |R, FMA, a, b, _| from_signed(if signed(b) == 0 { signed(a) } else { signed(a).wrapping_div(signed(b)) });
    UDiv = |R, FMA, a, b, _| R::from_lane_bits(if b.lane_bits() == 0 { a.lane_bits() } else { a.lane_bits() / b.lane_bits() });
    IRem = |R, FMA, a, b, _| from_signed(if signed(b) == 0 { 0 } else { signed(a).wrapping_rem(signed(b)) });
    URem = |R, FMA, a, b, _| R::from_lane_bits(if b.lane_bits() == 0 { 0 } else { a.lane_bits() % b.lane_bits() });
    Shl = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().wrapping_shl(b.lane_bits()));
    ShrI = |R, FMA, a, b, _| from_signed(signed(a).wrapping_shr(b.lane_bits()));
    ShrU = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().wrapping_shr(b.lane_bits()));
    And = |R, FMA, a, b, _| a.bit_and(b);
    Or = |R, FMA, a, b, _| a.bit_or(b);
    Xor = |R, FMA, a, b, _| a.bit_xor(b);
    IMin = |R, FMA, a, b, _| from_signed(signed(a).min(signed(b)));
    IMax = |R, FMA, a, b, _| from_signed(signed(a).max(signed(b)));
    UMin = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().min(b.lane_bits()));
    UMax = |R, FMA, a, b, _| R::from_lane_bits(a.lane_bits().max(b.lane_bits()));
    Fma = |R, FMA, a, b, c| a.fma::<FMA>(b, c);
    Fms = |R, FMA, a, b, c| a.fma::<FMA>(b, -c);
    Fnma = |R, FMA, a, b, c| (-a).fma::<FMA>(b, c);
    // `a` is the condition, `b` the value if it is true.
    Select = |R, FMA, a, b, c| if a.is_mask_set() { b } else { c };
    // For registers and constants only: the derivative of a value that all lanes share is zero. Slots have their own derivative kernels.
    Dpdx = |R, FMA, _, _, _| R::ZERO;
    Dpdy = |R, FMA, _, _, _| R::ZERO;
}
