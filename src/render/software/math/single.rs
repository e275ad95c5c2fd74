//! Elementary functions of f32 (single precision) for the lanes of the software renderer; tests/software/math.rs measures their errors. Outside a function's
//! domain the result is NaN.
//!
//! Coefficients, highest power first: S. Moshier, Cephes mathematical library (expf, logf, sinf, asinf, atanf); those of `pow` are our own.

use super::{Real, double, horner};

/// The bits of sqrt(1/2). If they are subtracted from the bits of x, the exponent field contains the n for which x / 2^n is in [sqrt(1/2), sqrt(2)).
const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
/// 1.5 * 2^23. Added to a number up to 2^22, it rounds the number to an integer, which is then in the low bits of the sum.
const ROUNDER: f32 = 12_582_912.0;

/// a b + c, rounded once if `FMA`, else twice.
#[inline(always)]
fn fma<const FMA: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

/// 2^n for -126 <= n <= 127.
#[inline(always)]
fn exp2_int(n: i32) -> f32 {
    f32::from_bits((n.wrapping_add(127) as u32) << 23)
}

/// x * 2^n in three steps, since 2^n itself may be out of range. Rounding occurs only if the result is below the normal range.
#[inline(always)]
pub(crate) fn ldexp(x: f32, n: i32) -> f32 {
    // Beyond these bounds every finite x except 0 overflows to infinity or underflows to 0.
    let n = n.clamp(-300, 300);
    let third = n / 3;
    x * exp2_int(third) * exp2_int(third) * exp2_int(n - 2 * third)
}

/// e^r 2^n, where |r| <= ln(2)/2 and -126 <= n <= 128; n is given as t = ROUNDER + n. Multiplies by 2^(n-1) and by 2, because 2^128 is not an f32. For
/// n = -126 the bits computed for 2^(n-1) are those of zero, so the result is zero.
#[inline(always)]
fn exp_of_reduced<const FMA: bool>(r: f32, t: f32) -> f32 {
    // e^r = 1 + r + r^2 p(r).
    let p = horner::<f32, FMA, 6>(r, [1.987_569_2e-4, 1.398_2e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5.000_000_1e-1]);
    // The bits of 2^(n-1): the low bits of t, moved to the exponent field, and the bias 127 less 1.
    let half_power = f32::from_bits((t.to_bits() << 23).wrapping_add(126 << 23));
    2.0 * fma::<FMA>(fma::<FMA>(p, r * r, r), half_power, half_power)
}

/// e^x. Results below 2^-125.5 (x < -86.99) are zero, although WGSL allows only subnormal results, those below 2^-126, to be flushed to zero: the full range
/// would need a second scale factor.
#[inline(always)]
pub(crate) fn exp<const FMA: bool>(x: f32) -> f32 {
    // Beyond these bounds the result overflows to infinity or underflows to 0. They keep n in -126..=128. NaN stays.
    let clamped = if x > 88.9 { 88.9 } else { x };
    let clamped = if clamped < -87.5 { -87.5 } else { clamped };
    let t = fma::<FMA>(clamped, std::f32::consts::LOG2_E, ROUNDER);
    let n = t - ROUNDER;
    // ln 2 = 0.693359375 - 2.12e-4; the product of 0.693359375 with n is exact.
    let r = fma::<FMA>(n, 2.121_944_4e-4, fma::<FMA>(n, -0.693_359_375, clamped));
    exp_of_reduced::<FMA>(r, t)
}

/// 2^x. Results below 2^-125.5 are zero, for the same reason as in [`exp`].
#[inline(always)]
pub(crate) fn exp2<const FMA: bool>(x: f32) -> f32 {
    // As in `exp`, where x is divided by ln 2.
    let clamped = if x > 128.25 { 128.25 } else { x };
    let clamped = if clamped < -126.25 { -126.25 } else { clamped };
    let t = clamped + ROUNDER;
    let r = (clamped - (t - ROUNDER)) * std::f32::consts::LN_2;
    exp_of_reduced::<FMA>(r, t)
}

/// Splits the argument of a logarithm into (1 + f) 2^exponent with f in [-0.293, 0.414]. Returns f, the exponent, and the rest of the series, log(1 + f) - f.
#[inline(always)]
fn log_parts<const FMA: bool>(x: f32) -> (f32, f32, f32) {
    // Scaling by 2^23 makes a subnormal x normal. Numbers x <= 0 are scaled too; the callers replace the result for them.
    let is_scaled = x < f32::MIN_POSITIVE;
    let scaled = if is_scaled { x * 8_388_608.0 } else { x };
    let (f, exponent, rest) = log_parts_of_normal::<FMA>(scaled);
    (f, exponent - if is_scaled { 23.0 } else { 0.0 }, rest)
}

/// As [`log_parts`], for a positive normal number.
#[inline(always)]
fn log_parts_of_normal<const FMA: bool>(x: f32) -> (f32, f32, f32) {
    let shifted_bits = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let exponent = ((shifted_bits as i32) >> 23) as f32;
    let f = f32::from_bits((shifted_bits & 0x007f_ffff).wrapping_add(SQRT_HALF_BITS)) - 1.0;
    // log(1 + f) = f - f^2/2 + f^3 p(f).
    let p = horner::<f32, FMA, 9>(
        f,
        [
            7.037_683_6e-2,
            -1.151_461e-1,
            1.167_699_9e-1,
            -1.242_014_1e-1,
            1.424_932_3e-1,
            -1.666_805_8e-1,
            2.000_071_5e-1,
            -2.499_999_4e-1,
            3.333_333e-1,
        ],
    );
    let z = f * f;
    (f, exponent, fma::<FMA>(-0.5, z, f * z * p))
}

/// Replaces the logarithm `y` for special arguments: 0 gives -inf, a negative number or NaN gives NaN, inf gives inf.
#[inline(always)]
fn log_special_cases(x: f32, y: f32) -> f32 {
    let y = if x == f32::INFINITY { x } else { y };
    let y = if x == 0.0 { f32::NEG_INFINITY } else { y };
    if x >= 0.0 { y } else { f32::NAN }
}

/// The natural logarithm, with ln 2 in two parts as in [`exp`].
#[inline(always)]
pub(crate) fn log<const FMA: bool>(x: f32) -> f32 {
    let (f, exponent, rest) = log_parts::<FMA>(x);
    let low = fma::<FMA>(exponent, -2.121_944_4e-4, rest);
    log_special_cases(x, fma::<FMA>(exponent, 0.693_359_375, low + f))
}

#[inline(always)]
pub(crate) fn log2<const FMA: bool>(x: f32) -> f32 {
    log_special_cases(x, log2_of_parts::<FMA>(log_parts::<FMA>(x)))
}

/// log2 of a finite number >= 1.
#[inline(always)]
pub(crate) fn log2_of_at_least_one<const FMA: bool>(x: f32) -> f32 {
    log2_of_parts::<FMA>(log_parts_of_normal::<FMA>(x))
}

/// log2 of the number with these [`log_parts`].
#[inline(always)]
fn log2_of_parts<const FMA: bool>((f, exponent, rest): (f32, f32, f32)) -> f32 {
    // log2(1 + f) = (f + rest) log2(e), where log2(e) = 1 + 0.4427. The products with 0.4427 are added to the exact products with 1.
    const LOG2_E_MINUS_1: f32 = 0.442_695_04;
    let small = fma::<FMA>(f, LOG2_E_MINUS_1, rest * LOG2_E_MINUS_1) + rest;
    (small + f) + exponent
}

/// sin, or cos(x) = sin(x + pi/2) if `COS`. Accurate for |x| <= 1.6e6, as is [`double::reduce_by_quarter_turns`]; for greater |x| the result only stays within
/// [-1, 1].
#[inline(always)]
pub(crate) fn sin_or_cos<const FMA: bool, const COS: bool>(x: f32) -> f32 {
    let (r, n) = double::reduce_by_quarter_turns(f64::from(x));
    let r = r as f32;
    let quadrant = if COS { n.wrapping_add(1) } else { n };
    let z = r * r;
    let s = fma::<FMA>(horner::<f32, FMA, 3>(z, [-1.951_529_6e-4, 8.332_161e-3, -1.666_665_5e-1]) * z, r, r).copysign(r);
    let c = fma::<FMA>(horner::<f32, FMA, 3>(z, [2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2]), z * z, fma::<FMA>(-0.5, z, 1.0));
    let y = if quadrant & 1 != 0 { c } else { s };
    // In quadrants 2 and 3 the sign bit changes.
    f32::from_bits(y.to_bits() ^ (((quadrant & 2) as u32) << 30))
}

/// The arcsine of s, where z = s^2 <= 1/4.
#[inline(always)]
fn asin_up_to_half<const FMA: bool>(z: f32, s: f32) -> f32 {
    let p = horner::<f32, FMA, 5>(z, [4.216_32e-2, 2.418_131_1e-2, 4.547_002_6e-2, 7.495_300_3e-2, 1.666_675_2e-1]);
    fma::<FMA>(p * z, s, s)
}

#[inline(always)]
pub(crate) fn asin<const FMA: bool>(x: f32) -> f32 {
    let a = x.abs();
    let is_large = a > 0.5;
    // If a > 0.5: asin(a) = pi/2 - 2 asin(sqrt((1 - a) / 2)).
    let half = 0.5 * (1.0 - a);
    // The polynomial's argument is the smaller of (1 - a) / 2 and a^2, which are equal at a = 0.5. If it were selected by `is_large`, the compiler would
    // evaluate the polynomial for both arguments.
    let z = if half < a * a { half } else { a * a };
    let root = half.sqrt();
    let y = asin_up_to_half::<FMA>(z, if is_large { root } else { a });
    let y = if is_large { std::f32::consts::FRAC_PI_2 - 2.0 * y } else { y };
    y.copysign(x)
}

#[inline(always)]
pub(crate) fn acos<const FMA: bool>(x: f32) -> f32 {
    let a = x.abs();
    let is_large = a > 0.5;
    // If a > 0.5: acos(a) = 2 asin(sqrt((1 - a) / 2)).
    let half = 0.5 * (1.0 - a);
    // The polynomial's argument is the smaller of (1 - a) / 2 and a^2, which are equal at a = 0.5. If it were selected by `is_large`, the compiler would
    // evaluate the polynomial for both arguments.
    let z = if half < a * a { half } else { a * a };
    let root = half.sqrt();
    let y = asin_up_to_half::<FMA>(z, if is_large { root } else { x });
    let for_large = if x < 0.0 { std::f32::consts::PI - 2.0 * y } else { 2.0 * y };
    // 4.4e-8 is the rounding error of the f32 constant FRAC_PI_2, which exceeds pi/2.
    if is_large { for_large } else { (std::f32::consts::FRAC_PI_2 - y) - 4.371_139e-8 }
}

/// The angle of the point (x, y) from the x axis, -pi to pi; signed zeros and infinities as IEEE 754 recommends.
#[inline(always)]
pub(crate) fn atan2<const FMA: bool>(y: f32, x: f32) -> f32 {
    let (ay, ax) = (y.abs(), x.abs());
    let is_swapped = ay > ax;
    let (small, large) = if is_swapped { (ax, ay) } else { (ay, ax) };
    let are_equal = small == large;
    // If small / large is greater than tan(pi/8), the angle is computed relative to the diagonal.
    let is_near_diagonal = small > 0.414_213_57 * large;
    let (num, den) = if is_near_diagonal { (small - large, small + large) } else { (small, large) };
    let q = num / den;
    // Also for 0 / 0 and infinity - infinity.
    let q = if are_equal { 0.0 } else { q };
    let z = q * q;
    let p = horner::<f32, FMA, 4>(z, [8.053_744_5e-2, -1.387_768_6e-1, 1.997_771_1e-1, -3.333_295e-1]);
    let t = fma::<FMA>(p * z, q, q);
    let t = if is_near_diagonal | (are_equal & (large > 0.0)) { std::f32::consts::FRAC_PI_4 + t } else { t };
    let t = if is_swapped { std::f32::consts::FRAC_PI_2 - t } else { t };
    let t = if x.is_sign_negative() { std::f32::consts::PI - t } else { t };
    let t = t.copysign(y);
    if x.is_nan() | y.is_nan() { f32::NAN } else { t }
}

/// x^y, with the special cases of [`double::pow`]. Evaluates f64 polynomials, because y log2(x) needs 32 significant bits: 8 before the point, and 24 after it
/// for an f32 result. The polynomials interpolate at Chebyshev nodes, and are just long enough for f32: the relative errors are 2^-38 (log2) and 2^-33 (exp2).
#[inline(always)]
pub(crate) fn pow<const FMA: bool>(x: f32, y: f32) -> f32 {
    /// As [`SQRT_HALF_BITS`], for f64.
    const F64_SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    /// Makes every exponent of an f32 positive.
    const EXPONENT_OFFSET: u64 = 1024;
    let shifted_bits = f64::from(x).to_bits().wrapping_sub(F64_SQRT_HALF_BITS);
    // Converts the exponent to a float: adds `EXPONENT_OFFSET`, ORs the sum into the bits of 2^52, and subtracts 2^52 and `EXPONENT_OFFSET`. Without AVX-512,
    // no vector instruction converts 64-bit integers to floats.
    let exponent_bits = shifted_bits.wrapping_add(EXPONENT_OFFSET << 52) >> 52;
    let x_exponent = f64::from_bits(exponent_bits | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + EXPONENT_OFFSET as f64);
    let f = f64::from_bits((shifted_bits & 0x000f_ffff_ffff_ffff).wrapping_add(F64_SQRT_HALF_BITS)) - 1.0;
    // log2(1 + f) / f.
    let q = horner::<f64, FMA, 14>(
        f,
        [
            -6.806_287_590_390_596e-2,
            1.311_374_375_368_668_4e-1,
            -1.347_892_873_836_604_3e-1,
            1.306_289_025_602_109_6e-1,
            -1.425_234_075_541_001_6e-1,
            1.601_822_613_029_602_6e-1,
            -1.804_326_852_102_011_7e-1,
            2.061_086_952_930_662_8e-1,
            -2.404_466_267_772_730_4e-1,
            2.885_387_623_299_674_6e-1,
            -3.606_737_897_710_07e-1,
            4.808_983_490_727_960_8e-1,
            -7.213_475_203_430_863e-1,
            1.442_695_040_886_203_3,
        ],
    );
    let log2_x = f.fma::<FMA>(q, x_exponent);
    // For |y| > 1e20 the result overflows or underflows for every x but 1. The bound keeps the product finite.
    let bounded_y = f64::from(y);
    let bounded_y = if bounded_y > 1e20 { 1e20 } else { bounded_y };
    let bounded_y = if bounded_y < -1e20 { -1e20 } else { bounded_y };
    let exponent = log2_x * bounded_y;
    // Beyond these bounds the result overflows to infinity or underflows to 0.
    let exponent = if exponent > 130.0 { 130.0 } else { exponent };
    let exponent = if exponent < -152.0 { -152.0 } else { exponent };
    // As a float and as an integer.
    let (nearest, n) = exponent.round_small();
    // 2^(exponent - nearest).
    let p = horner::<f64, FMA, 8>(
        exponent - nearest,
        [
            1.529_732_376_070_107_4e-5,
            1.546_144_469_856_913e-4,
            1.333_350_238_616_277e-3,
            9.618_056_678_524_638e-3,
            5.550_410_883_909_618_4e-2,
            2.402_265_092_227_135e-1,
            std::f64::consts::LN_2,
            1.0,
        ],
    );
    let r = (p * f64::from_bits((n.wrapping_add(1023) as u64) << 52)) as f32;
    // Zero to a positive power and infinity to a negative one are zero.
    let r = if (x == 0.0) | (x == f32::INFINITY) { if (x == 0.0) == (y > 0.0) { 0.0 } else { f32::INFINITY } } else { r };
    let r = if x < 0.0 { f32::NAN } else { r };
    let r = if (y == 0.0) | (x == 1.0) { 1.0 } else { r };
    if x.is_nan() | y.is_nan() { f32::NAN } else { r }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log2_of_at_least_one_gives_the_bits_of_log2() {
        // The step is a prime, so that the low bits vary.
        let mut numbers = (0..).map(|k| f32::from_bits(1.0_f32.to_bits() + k * 7919)).take_while(|x| x.is_finite());
        assert!(numbers.all(|x| {
            log2::<true>(x).to_bits() == log2_of_at_least_one::<true>(x).to_bits()
                && log2::<false>(x).to_bits() == log2_of_at_least_one::<false>(x).to_bits()
        }));
        assert_ne!(log2::<false>(0.0), log2_of_at_least_one::<false>(0.0), "zero is a special case");
    }
}
