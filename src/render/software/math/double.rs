//! Elementary functions of f64. Coefficients: S. Moshier, Cephes (exp, atan, sinh, tanh); Sun Microsystems, fdlibm (log, sin, cos, asin, and the
//! split of log2(e) and of log2 x into a high and a low part).
//!
//! In: any f64; angles in radians. Out: infinities and NaN as in C, without error flags, except where a function says otherwise. Always: without branches, so
//! that loops over lanes can be vectorised; special arguments are replaced at the end. `FMA`: whether to use fused multiply-add. Not here: the measured errors
//! (`math/mod.rs`).

use super::horner;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, LOG2_E, PI};

/// 1.5 * 2^52. Added to a number, it rounds a number below 2^51 to an integer, which is then in the low bits of the sum.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// 2^54. A subnormal number times it is normal.
const TWO_POW_54: f64 = 18_014_398_509_481_984.0;
/// Above this x, asinh and acosh are computed as log(2 x): x^2 could overflow, and 1 is negligible beside it.
const ASYMPTOTIC_FROM: f64 = 1e150;

/// x limited to `low..=high`; NaN stays NaN, because it fails both comparisons.
#[inline(always)]
fn bounded(x: f64, low: f64, high: f64) -> f64 {
    let x = if x > high { high } else { x };
    if x < low { low } else { x }
}

#[inline(always)]
fn fma<const FMA: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// 2^n for -1022 <= n <= 1023; for any other n some number, without a panic.
#[inline(always)]
fn exp2_int(n: i64) -> f64 {
    f64::from_bits((n.wrapping_add(1023) as u64) << 52)
}

/// x * 2^n in three steps, since 2^n itself may be out of range. Rounding occurs only if the result is below the normal range.
#[inline(always)]
pub(crate) fn ldexp(x: f64, n: i32) -> f64 {
    // Beyond these bounds every finite x except 0 overflows to infinity or underflows to 0.
    let n = i64::from(n).clamp(-2200, 2200);
    let third = n / 3;
    x * exp2_int(third) * exp2_int(third) * exp2_int(n - 2 * third)
}

/// y * 2^n in two steps, since 2^n itself may be out of range. For -1078 <= n <= 1026, to which the callers limit n.
#[inline(always)]
fn scale_in_two_steps(y: f64, n: i64) -> f64 {
    let half = n >> 1;
    y * exp2_int(half) * exp2_int(n.wrapping_sub(half))
}

/// e^r for |r| <= 0.4 (a little more than ln 2 / 2), as 1 + 2 p / (q - p), where p is an odd polynomial in r and q an even one.
#[inline(always)]
fn exp_of_reduced<const FMA: bool>(r: f64) -> f64 {
    let z = r * r;
    let p = r * horner::<f64, FMA, 3>(z, [1.261_771_930_748_105_9e-4, 3.029_944_077_074_419_6e-2, 1.0]);
    let q = horner::<f64, FMA, 4>(z, [3.001_985_051_386_644_6e-6, 2.524_483_403_496_841e-3, 2.272_655_482_081_550_3e-1, 2.0]);
    1.0 + 2.0 * (p / (q - p))
}

/// The integer nearest to t, as a float and as an integer.
#[inline(always)]
fn round_to_int(t: f64) -> (f64, i64) {
    let sum = t + ROUNDER;
    (sum - ROUNDER, (sum.to_bits() as i64).wrapping_sub(ROUNDER.to_bits() as i64))
}

#[inline(always)]
pub(crate) fn exp<const FMA: bool>(x: f64) -> f64 {
    // Beyond these bounds the result overflows to infinity or underflows to 0.
    let clamped = bounded(x, -747.0, 711.0);
    let (k, n) = round_to_int(clamped * LOG2_E);
    // k ln 2 is subtracted, with ln 2 in two parts. The greater part has so few bits that its product with k is exact.
    let r = fma::<FMA>(k, -1.428_606_820_309_417_2e-6, fma::<FMA>(k, -6.931_457_519_531_25e-1, clamped));
    scale_in_two_steps(exp_of_reduced::<FMA>(r), n)
}

#[inline(always)]
pub(crate) fn exp2<const FMA: bool>(x: f64) -> f64 {
    // As in `exp`.
    let clamped = bounded(x, -1077.0, 1026.0);
    let (k, n) = round_to_int(clamped);
    scale_in_two_steps(exp_of_reduced::<FMA>((clamped - k) * LN_2), n)
}

/// Splits the argument of a logarithm into (1 + f) 2^exponent with f in [-0.293, 0.414]. Returns f, the exponent, f^2/2, and tail = s (f^2/2 + R), where
/// s = f/(2+f) and R is a polynomial in s^2, so that log(1 + f) = f - (f^2/2 - tail).
#[inline(always)]
fn log_parts<const FMA: bool>(x: f64) -> (f64, f64, f64, f64) {
    // Scaling makes a subnormal x normal. It also affects x <= 0, for which the callers replace the result.
    let is_scaled = x < f64::MIN_POSITIVE;
    let scaled = if is_scaled { x * TWO_POW_54 } else { x };
    /// The bits of sqrt(1/2). Subtracted from the bits of a number, they make the exponent field change at sqrt(2) instead of 2.
    const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    let bits = scaled.to_bits().wrapping_sub(SQRT_HALF_BITS);
    // Converts the exponent, a signed number of 12 bits, to a float: adds a bias of 2048 by inverting the highest bit, ORs the sum into the bits of 2^52, and
    // subtracts 2^52 and the bias. Below AVX-512, no vector instruction converts 64-bit integers to floats. For x < 0 and NaN the exponent is meaningless; the
    // callers replace the result.
    let exponent_bits = (bits >> 52) ^ 0x800;
    let exponent = f64::from_bits(exponent_bits | 0x4330_0000_0000_0000) - 4_503_599_627_370_496.0 - 2048.0;
    let exponent = if is_scaled { exponent - 54.0 } else { exponent };
    let f = f64::from_bits((bits & 0x000f_ffff_ffff_ffff).wrapping_add(SQRT_HALF_BITS)) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let r = z * horner::<f64, FMA, 7>(
        z,
        [
            1.479_819_860_511_658_6e-1,
            1.531_383_769_920_937_3e-1,
            1.818_357_216_161_805e-1,
            2.222_219_843_214_978_4e-1,
            2.857_142_874_366_239e-1,
            3.999_999_999_940_942e-1,
            6.666_666_666_666_735e-1,
        ],
    );
    let half_square = 0.5 * f * f;
    (f, exponent, half_square, s * (half_square + r))
}

/// Replaces the logarithm `y` for special arguments: 0 gives -inf, a negative number or NaN gives NaN, inf gives inf.
#[inline(always)]
fn log_special_cases(x: f64, y: f64) -> f64 {
    let y = if x == f64::INFINITY { x } else { y };
    let y = if x == 0.0 { f64::NEG_INFINITY } else { y };
    if x >= 0.0 { y } else { f64::NAN }
}

#[inline(always)]
pub(crate) fn log<const FMA: bool>(x: f64) -> f64 {
    let (f, exponent, half_square, tail) = log_parts::<FMA>(x);
    // ln 2 in two parts; the product of the greater part and the exponent is exact.
    let low = fma::<FMA>(exponent, 1.908_214_929_270_587_7e-10, tail);
    log_special_cases(x, fma::<FMA>(exponent, 6.931_471_803_691_238e-1, f - (half_square - low)))
}

/// log2 of a positive finite x as a double-double: the unevaluated sum of two numbers, the greater one first. tests/software/math.rs bounds the error of
/// `pow`, which uses it, by 6 ulp.
#[inline(always)]
fn log2_double_double<const FMA: bool>(x: f64) -> (f64, f64) {
    let (f, exponent, half_square, tail) = log_parts::<FMA>(x);
    // log(1 + f) = high + low.
    let high = high_bits(f - half_square);
    let low = ((f - high) - half_square) + tail;
    // Multiplies by log2(e), which is given in two parts.
    let product_high = high * 1.442_695_040_721_446_3;
    let product_low = fma::<FMA>(low + high, 1.675_171_316_488_651_2e-10, low * 1.442_695_040_721_446_3);
    let sum = exponent + product_high;
    (sum, product_low + ((exponent - sum) + product_high))
}

/// x without its low 27 bits. The remaining mantissa has 26 bits, so that the product of two such numbers is exact.
#[inline(always)]
fn high_bits(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0xffff_ffff_f800_0000)
}

#[inline(always)]
pub(crate) fn log2<const FMA: bool>(x: f64) -> f64 {
    let (high, low) = log2_double_double::<FMA>(x);
    log_special_cases(x, high + low)
}

/// Subtracts quarter turns (pi/2) from an angle in radians. Returns the remainder in [-pi/4, pi/4] and the number of quarter turns; only the low bits of this
/// number are valid. The remainder's relative error is below 3e-16 for |x| <= 1.6e6 (pi/2 is subtracted in three parts; the first two have 33 bits each,
/// so their products with up to 2^20 quarter turns are exact). For greater |x| the remainder is wrong, but clamped to [-0.786, 0.786], just beyond pi/4, for
/// which the polynomials of sine and cosine are made. inf and NaN give NaN.
#[inline(always)]
pub(crate) fn reduce_by_quarter_turns(x: f64) -> (f64, i64) {
    let (k, n) = round_to_int(x * std::f64::consts::FRAC_2_PI);
    let r = ((x - k * 1.570_796_326_734_125_6) - k * 6.077_100_506_303_966e-11) - k * 2.022_266_248_795_950_6e-21;
    let r = bounded(r, -0.786, 0.786);
    (if x.abs() == f64::INFINITY { f64::NAN } else { r }, n)
}

/// Sine and cosine of |r| <= 0.786.
#[inline(always)]
fn sin_and_cos<const FMA: bool>(r: f64) -> (f64, f64) {
    let z = r * r;
    let sin_polynomial = horner::<f64, FMA, 6>(
        z,
        [
            1.589_690_995_211_550_1e-10,
            -2.505_076_025_340_686_3e-8,
            2.755_731_370_707_006_8e-6,
            -1.984_126_982_985_795e-4,
            8.333_333_333_322_49e-3,
            -1.666_666_666_666_663_2e-1,
        ],
    );
    let cos_polynomial = horner::<f64, FMA, 6>(
        z,
        [
            -1.135_964_755_778_819_5e-11,
            2.087_572_321_298_174_8e-9,
            -2.755_731_435_139_066_3e-7,
            2.480_158_728_947_673e-5,
            -1.388_888_888_887_411e-3,
            4.166_666_666_666_66e-2,
        ],
    );
    // The sine is r + r z sin_polynomial, the cosine 1 - z/2 + z^2 cos_polynomial. The rounding error of w = 1 - z/2 is added back.
    let w = 1.0 - 0.5 * z;
    (fma::<FMA>(sin_polynomial * z, r, r).copysign(r), w + (((1.0 - w) - 0.5 * z) + z * z * cos_polynomial))
}

/// sin, or cos if `COS`.
#[inline(always)]
pub(crate) fn sin_or_cos<const FMA: bool, const COS: bool>(x: f64) -> f64 {
    let (r, n) = reduce_by_quarter_turns(x);
    let quadrant = if COS { n.wrapping_add(1) } else { n };
    let (s, c) = sin_and_cos::<FMA>(r);
    let y = if quadrant & 1 != 0 { c } else { s };
    // Negated in the quadrants 2 and 3: bit 63 is the sign.
    f64::from_bits(y.to_bits() ^ (((quadrant & 2) as u64) << 62))
}

#[inline(always)]
pub(crate) fn tan<const FMA: bool>(x: f64) -> f64 {
    let (r, n) = reduce_by_quarter_turns(x);
    let (s, c) = sin_and_cos::<FMA>(r);
    if n & 1 != 0 { -c / s } else { s / c }
}

/// The arcsine of s, where z = s^2 <= 1/4.
#[inline(always)]
fn asin_up_to_half<const FMA: bool>(z: f64, s: f64) -> f64 {
    let p = z * horner::<f64, FMA, 6>(
        z,
        [
            3.479_331_075_960_212e-5,
            7.915_349_942_898_145e-4,
            -4.005_553_450_067_941e-2,
            2.012_125_321_348_629_3e-1,
            -3.255_658_186_224_009e-1,
            1.666_666_666_666_666_6e-1,
        ],
    );
    let q = horner::<f64, FMA, 5>(
        z,
        [7.703_815_055_590_194e-2, -6.882_839_716_054_533e-1, 2.020_945_760_233_505_7, -2.403_394_911_734_414, 1.0],
    );
    fma::<FMA>(p / q, s, s)
}

/// Returns whether a > 0.5, where a = |x|, and an arcsine: if a > 0.5 that of sqrt((1 - a) / 2), which is half the arccosine of a, otherwise that of `small`,
/// for which the callers give a or x.
#[inline(always)]
fn asin_reduced<const FMA: bool>(a: f64, small: f64) -> (bool, f64) {
    let is_large = a > 0.5;
    let half = 0.5 * (1.0 - a);
    let root = half.sqrt();
    (is_large, asin_up_to_half::<FMA>(if is_large { half } else { a * a }, if is_large { root } else { small }))
}

#[inline(always)]
pub(crate) fn asin<const FMA: bool>(x: f64) -> f64 {
    let a = x.abs();
    let (is_large, y) = asin_reduced::<FMA>(a, a);
    (if is_large { FRAC_PI_2 - 2.0 * y } else { y }).copysign(x)
}

#[inline(always)]
pub(crate) fn acos<const FMA: bool>(x: f64) -> f64 {
    let (is_large, y) = asin_reduced::<FMA>(x.abs(), x);
    let for_large = if x < 0.0 { PI - 2.0 * y } else { 2.0 * y };
    // 6.1e-17 is pi / 2 - FRAC_PI_2, the rounding error of that constant.
    if is_large { for_large } else { FRAC_PI_2 - (y - 6.123_233_995_736_766e-17) }
}

/// The angle of the point (x, y), in all four quadrants; signed zeros and infinities as IEEE 754 recommends.
#[inline(always)]
pub(crate) fn atan2<const FMA: bool>(y: f64, x: f64) -> f64 {
    let (ay, ax) = (y.abs(), x.abs());
    let is_swapped = ay > ax;
    let (small, large) = if is_swapped { (ax, ay) } else { (ay, ax) };
    let are_equal = small == large;
    // If small / large is greater than tan(pi/8), the angle is computed relative to the diagonal.
    let is_near_diagonal = small > 0.414_213_562_373_095 * large;
    let (num, den) = if is_near_diagonal { (small - large, small + large) } else { (small, large) };
    let quotient = num / den;
    // 0 for equal numbers, which include two zeros and two infinities: their quotient is NaN.
    let quotient = if are_equal { 0.0 } else { quotient };
    let z = quotient * quotient;
    let p = horner::<f64, FMA, 5>(
        z,
        [
            -8.750_608_600_031_904e-1,
            -1.615_753_718_733_365e1,
            -7.500_855_792_314_705e1,
            -1.228_866_684_490_136_2e2,
            -6.485_021_904_942_025e1,
        ],
    );
    let d = horner::<f64, FMA, 6>(
        z,
        [
            1.0,
            2.485_846_490_142_306_3e1,
            1.650_270_098_316_988_5e2,
            4.328_810_604_912_902_7e2,
            4.853_903_996_359_137e2,
            1.945_506_571_482_614e2,
        ],
    );
    let t = fma::<FMA>(z * p / d, quotient, quotient);
    let t = if is_near_diagonal | (are_equal & (large > 0.0)) { FRAC_PI_4 + t } else { t };
    let t = if is_swapped { FRAC_PI_2 - t } else { t };
    let t = if x.is_sign_negative() { PI - t } else { t };
    let t = t.copysign(y);
    if x.is_nan() | y.is_nan() { f64::NAN } else { t }
}

#[inline(always)]
pub(crate) fn sinh<const FMA: bool>(x: f64) -> f64 {
    let a = x.abs();
    let z = a * a;
    let p = horner::<f64, FMA, 4>(
        z,
        [-7.894_744_439_635_37e-1, -1.637_258_575_259_838_3e2, -1.156_144_357_650_052_2e4, -3.517_549_648_081_514e5],
    );
    let q = horner::<f64, FMA, 4>(z, [1.0, -2.777_110_814_206_028e2, 3.615_782_798_344_32e4, -2.110_529_788_848_908_4e6]);
    let small = fma::<FMA>(a * z, p / q, a);
    // e^(a/2), because e^a may overflow where sinh does not.
    let e = exp::<FMA>(0.5 * a);
    let large = (0.5 * e) * e - 0.5 / e / e;
    (if a < 1.0 { small } else { large }).copysign(x)
}

#[inline(always)]
pub(crate) fn cosh<const FMA: bool>(x: f64) -> f64 {
    let e = exp::<FMA>(0.5 * x.abs());
    (0.5 * e) * e + 0.5 / e / e
}

#[inline(always)]
pub(crate) fn tanh<const FMA: bool>(x: f64) -> f64 {
    let a = x.abs();
    let z = a * a;
    let p = horner::<f64, FMA, 3>(z, [-9.643_991_794_250_522e-1, -9.928_772_310_019_186e1, -1.614_687_684_417_084_5e3]);
    let q = horner::<f64, FMA, 4>(z, [1.0, 1.128_116_784_916_329_3e2, 2.235_488_390_601_004_5e3, 4.844_063_053_251_255e3]);
    let small = fma::<FMA>(a * z, p / q, a);
    let large = 1.0 - 2.0 / (exp::<FMA>(2.0 * a) + 1.0);
    (if a < 0.625 { small } else { large }).copysign(x)
}

/// The natural logarithm of 1 + u for u > -1. Corrects the rounding error of 1 + u to first order.
#[inline(always)]
fn log1p<const FMA: bool>(u: f64) -> f64 {
    let w = 1.0 + u;
    let y = log::<FMA>(w) + (u - (w - 1.0)) / w;
    if w == f64::INFINITY { w } else { y }
}

#[inline(always)]
pub(crate) fn asinh<const FMA: bool>(x: f64) -> f64 {
    let a = x.abs();
    let is_huge = a > ASYMPTOTIC_FROM;
    // fdlibm's formula, here and in acosh and atanh, but for a wider range of arguments than there.
    let moderate = log1p::<FMA>(a + a * a / (1.0 + (1.0 + a * a).sqrt()));
    let asymptotic = log::<FMA>(a) + LN_2;
    (if is_huge { asymptotic } else { moderate }).copysign(x)
}

#[inline(always)]
pub(crate) fn acosh<const FMA: bool>(x: f64) -> f64 {
    let t = x - 1.0;
    let moderate = log1p::<FMA>(t + (2.0 * t + t * t).sqrt());
    let asymptotic = log::<FMA>(x) + LN_2;
    let y = if x > ASYMPTOTIC_FROM { asymptotic } else { moderate };
    if x < 1.0 { f64::NAN } else { y }
}

#[inline(always)]
pub(crate) fn atanh<const FMA: bool>(x: f64) -> f64 {
    let a = x.abs();
    let y = 0.5 * log1p::<FMA>(2.0 * a / (1.0 - a));
    let y = if a == 1.0 { f64::INFINITY } else { y };
    (if a > 1.0 { f64::NAN } else { y }).copysign(x)
}

/// x^y. NaN if x or y is NaN; otherwise x^0 = 1 for any x, and 1^y = 1. WGSL does not specify negative x; here the result is NaN unless y = 0.
#[inline(always)]
pub(crate) fn pow<const FMA: bool>(x: f64, y: f64) -> f64 {
    let (log2_x, log2_x_low) = log2_double_double::<FMA>(x);
    // For |y| > 1e20 the result overflows or underflows for every x but 1. The bound keeps the products finite.
    let bounded_y = bounded(y, -1e20, 1e20);
    let (log2_x_high, bounded_y_high) = (high_bits(log2_x), high_bits(bounded_y));
    let product_high = log2_x_high * bounded_y_high;
    let product_low = (bounded_y - bounded_y_high) * log2_x_high + bounded_y * ((log2_x - log2_x_high) + log2_x_low);
    let sum = product_high + product_low;
    let (k, n) = round_to_int(bounded(sum, -1077.0, 1026.0));
    // |rest| exceeds 0.4 only where `sum` was clamped, so that the result overflows or underflows anyway, and for arguments whose result is replaced below.
    let rest = ((product_high - k) + product_low) * LN_2;
    let power = scale_in_two_steps(exp_of_reduced::<FMA>(bounded(rest, -0.4, 0.4)), n);
    // For y > 0, 0^y is 0 and infinity^y infinite; for y < 0 it is the reverse.
    let power = if (x == 0.0) | (x == f64::INFINITY) { if (x == 0.0) == (y > 0.0) { 0.0 } else { f64::INFINITY } } else { power };
    let power = if x < 0.0 { f64::NAN } else { power };
    let power = if (y == 0.0) | (x == 1.0) { 1.0 } else { power };
    if x.is_nan() | y.is_nan() { f64::NAN } else { power }
}
