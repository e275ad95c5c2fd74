//! The only definition of what each operation computes on one lane. Constant folding, the per-draw tape and the vector kernels share it.

use crate::render::software::math::Real;
use crate::render::software::tape::Op;

/// One operation on one lane; unused operands are ignored. `F`: fused multiply-add.
pub(crate) trait Eval {
    /// Number of operands.
    const ARITY: usize;
    fn eval<R: Real, const F: bool>(a: R, b: R, c: R) -> R;
}

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

#[inline(always)]
fn signed<R: Real>(a: R) -> i32 {
    a.int() as i32
}
#[inline(always)]
fn from_signed<R: Real>(i: i32) -> R {
    R::from_int(i as u32)
}
// Classes with fused multiply-add have a rounding instruction; the others round by adding and subtracting a power of two. Both are exact, so the
// bits are the same.
#[inline(always)]
fn trunc<R: Real, const F: bool>(a: R) -> R {
    if F {
        return a.trunc_native();
    }
    let m = a.abs();
    let r = m.round();
    (if r > m { r - R::ONE } else { r }).with_sign(a)
}
#[inline(always)]
fn floor<R: Real, const F: bool>(a: R) -> R {
    if F {
        return a.floor_native();
    }
    let r = a.round();
    if r > a { r - R::ONE } else { r }
}
#[inline(always)]
fn round<R: Real, const F: bool>(a: R) -> R {
    if F { a.round_native() } else { a.round() }
}

/// IEEE half precision of a value, ties to even, as 16 bits.
#[inline(always)]
fn to_half(x: f32) -> u32 {
    let bits = x.to_bits();
    let sign = (bits >> 16) & 0x8000;
    let a = bits & 0x7fff_ffff;
    // Adding 0.5 aligns the ten kept bits of a subnormal half with the float's lowest bits, rounding on the way.
    let small = (f32::from_bits(a) + 0.5).to_bits().wrapping_sub(0x3f00_0000);
    let normal = a.wrapping_add(0xc800_0fff).wrapping_add((a >> 13) & 1) >> 13;
    let finite = if a < 0x3880_0000 { small } else { normal };
    let over = if a > 0x7f80_0000 { 0x7e00 } else { 0x7c00 };
    sign | if a >= 0x4780_0000 { over } else { finite }
}

#[inline(always)]
fn from_half(h: u32) -> f32 {
    let sign = (h & 0x8000) << 16;
    let m = h & 0x7fff;
    let scaled = f32::from_bits(m << 13) * 5.192_296_9e33; // 2^112
    let special = f32::from_bits((m << 13) | 0x7f80_0000);
    let y = if m >= 0x7c00 { special } else { scaled };
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
    Copy = |R, F, a, _, _| a;
    Neg = |R, F, a, _, _| -a;
    Abs = |R, F, a, _, _| a.abs();
    Sqrt = |R, F, a, _, _| a.sqrt();
    InverseSqrt = |R, F, a, _, _| R::ONE / a.sqrt();
    Floor = |R, F, a, _, _| floor::<R, F>(a);
    Ceil = |R, F, a, _, _| -floor::<R, F>(-a);
    Round = |R, F, a, _, _| round::<R, F>(a);
    Trunc = |R, F, a, _, _| trunc::<R, F>(a);
    Fract = |R, F, a, _, _| a - floor::<R, F>(a);
    Sign = |R, F, a, _, _| if a > R::ZERO { R::ONE } else if a < R::ZERO { -R::ONE } else { R::ZERO };
    Exp = |R, F, a, _, _| a.exp::<F>();
    Exp2 = |R, F, a, _, _| a.exp2::<F>();
    Log = |R, F, a, _, _| a.log::<F>();
    Log2 = |R, F, a, _, _| a.log2::<F>();
    Sin = |R, F, a, _, _| a.sin::<F>();
    Cos = |R, F, a, _, _| a.cos::<F>();
    Tan = |R, F, a, _, _| a.tan::<F>();
    Asin = |R, F, a, _, _| a.asin::<F>();
    Acos = |R, F, a, _, _| a.acos::<F>();
    Atan = |R, F, a, _, _| a.atan2::<F>(R::ONE);
    Sinh = |R, F, a, _, _| a.sinh::<F>();
    Cosh = |R, F, a, _, _| a.cosh::<F>();
    Tanh = |R, F, a, _, _| a.tanh::<F>();
    Asinh = |R, F, a, _, _| a.asinh::<F>();
    Acosh = |R, F, a, _, _| a.acosh::<F>();
    Atanh = |R, F, a, _, _| a.atanh::<F>();
    QuantizeF16 = |R, F, a, _, _| R::from_f64(f64::from(from_half(to_half(f32::from_bits(a.f32_bits())))));
    F16FromF = |R, F, a, _, _| R::from_int(to_half(f32::from_bits(a.f32_bits())));
    FFromF16 = |R, F, a, _, _| R::from_f64(f64::from(from_half(a.int())));
    IsNan = |R, F, a, _, _| R::from_mask(a.is_nan());
    IsInf = |R, F, a, _, _| R::from_mask(a.is_inf());
    INeg = |R, F, a, _, _| from_signed(signed(a).wrapping_neg());
    IAbs = |R, F, a, _, _| from_signed(signed(a).wrapping_abs());
    ISign = |R, F, a, _, _| from_signed(signed(a).signum());
    INot = |R, F, a, _, _| R::from_int(!a.int());
    BNot = |R, F, a, _, _| a.bit_not();
    CountOneBits = |R, F, a, _, _| R::from_int(count_ones(a.int()));
    LeadingZeros = |R, F, a, _, _| R::from_int(leading_zeros(a.int()));
    TrailingZeros = |R, F, a, _, _| R::from_int(trailing_zeros(a.int()));
    ReverseBits = |R, F, a, _, _| R::from_int(a.int().reverse_bits());
    FirstLeadingBitU = |R, F, a, _, _| R::from_int(31u32.wrapping_sub(leading_zeros(a.int())));
    FirstLeadingBitI = |R, F, a, _, _| R::from_int(31u32.wrapping_sub(leading_zeros(a.int() ^ ((signed(a) >> 31) as u32))));
    FirstTrailingBit = |R, F, a, _, _| R::from_int(if a.int() == 0 { u32::MAX } else { trailing_zeros(a.int()) });
    IFromF = |R, F, a, _, _| from_signed(a.to_i32());
    UFromF = |R, F, a, _, _| R::from_int(a.to_u32());
    FFromI = |R, F, a, _, _| R::from_i32(signed(a));
    FFromU = |R, F, a, _, _| R::from_u32(a.int());
    BitsFromF = |R, F, a, _, _| R::from_int(a.f32_bits());
    FFromBits = |R, F, a, _, _| R::from_f32_bits(a.int());
    Add = |R, F, a, b, _| a + b;
    Sub = |R, F, a, b, _| a - b;
    Mul = |R, F, a, b, _| a * b;
    Div = |R, F, a, b, _| a / b;
    Min = |R, F, a, b, _| if a < b { a } else { b };
    Max = |R, F, a, b, _| if a > b { a } else { b };
    FRem = |R, F, a, b, _| a - b * trunc::<R, F>(a / b);
    Pow = |R, F, a, b, _| a.pow::<F>(b);
    Atan2 = |R, F, a, b, _| a.atan2::<F>(b);
    Ldexp = |R, F, a, b, _| a.ldexp(signed(b));
    FLt = |R, F, a, b, _| R::from_mask(a < b);
    FLe = |R, F, a, b, _| R::from_mask(a <= b);
    FEq = |R, F, a, b, _| R::from_mask(a == b);
    FNe = |R, F, a, b, _| R::from_mask(a != b);
    ILt = |R, F, a, b, _| R::from_mask(signed(a) < signed(b));
    ILe = |R, F, a, b, _| R::from_mask(signed(a) <= signed(b));
    ULt = |R, F, a, b, _| R::from_mask(a.int() < b.int());
    ULe = |R, F, a, b, _| R::from_mask(a.int() <= b.int());
    IEq = |R, F, a, b, _| R::from_mask(a.int() == b.int());
    INe = |R, F, a, b, _| R::from_mask(a.int() != b.int());
    IAdd = |R, F, a, b, _| R::from_int(a.int().wrapping_add(b.int()));
    ISub = |R, F, a, b, _| R::from_int(a.int().wrapping_sub(b.int()));
    IMul = |R, F, a, b, _| R::from_int(a.int().wrapping_mul(b.int()));
    IDiv = |R, F, a, b, _| from_signed(if signed(b) == 0 { signed(a) } else { signed(a).wrapping_div(signed(b)) });
    UDiv = |R, F, a, b, _| R::from_int(if b.int() == 0 { a.int() } else { a.int() / b.int() });
    IRem = |R, F, a, b, _| from_signed(if signed(b) == 0 { 0 } else { signed(a).wrapping_rem(signed(b)) });
    URem = |R, F, a, b, _| R::from_int(if b.int() == 0 { 0 } else { a.int() % b.int() });
    Shl = |R, F, a, b, _| R::from_int(a.int().wrapping_shl(b.int()));
    ShrI = |R, F, a, b, _| from_signed(signed(a).wrapping_shr(b.int()));
    ShrU = |R, F, a, b, _| R::from_int(a.int().wrapping_shr(b.int()));
    And = |R, F, a, b, _| a.bit_and(b);
    Or = |R, F, a, b, _| a.bit_or(b);
    Xor = |R, F, a, b, _| a.bit_xor(b);
    IMin = |R, F, a, b, _| from_signed(signed(a).min(signed(b)));
    IMax = |R, F, a, b, _| from_signed(signed(a).max(signed(b)));
    UMin = |R, F, a, b, _| R::from_int(a.int().min(b.int()));
    UMax = |R, F, a, b, _| R::from_int(a.int().max(b.int()));
    Fma = |R, F, a, b, c| a.fma::<F>(b, c);
    Fms = |R, F, a, b, c| a.fma::<F>(b, -c);
    Fnma = |R, F, a, b, c| (-a).fma::<F>(b, c);
    Select = |R, F, a, b, c| if a.mask() { b } else { c };
    // For scalars only: the derivative of one value for all lanes is zero. Lanes have their own derivative kernels.
    Dpdx = |R, F, _, _, _| R::ZERO;
    Dpdy = |R, F, _, _, _| R::ZERO;
}
