//! Elementary functions in f32, branch-free, for the auto-vectoriser.
//!
//! Cephes's single-precision polynomials (S. L. Moshier, netlib) where marked. Largest errors, measured by the tests below against
//! f64, in units in the last place: exp 1.1, exp2 1.1, log 1.1, log2 2.1, sin and cos 1.6 (|x| ≤ 2^20; |value| ≥ 2^-10), asin 2.4,
//! acos 1.8, atan 2.7, atan2 3.0, pow 0.6. NaN propagates; overflow is infinite, underflow 0.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Adding and subtracting this rounds |x| < 2^22 to the nearest integer.
const ROUNDER: f32 = 12_582_912.0;

#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) << 23) as u32)
}

/// y * 2^n for n within ±280, in two steps so that neither factor leaves the normal range.
#[inline(always)]
fn scaled(y: f32, n: i32) -> f32 {
    let half = n >> 1;
    y * power_of_two(half) * power_of_two(n - half)
}

/// e^r for |r| ≤ ln 2 / 2 (Cephes expf).
#[inline(always)]
fn exp_reduced(r: f32) -> f32 {
    let p = ((((1.987_569_2e-4 * r + 1.398_199_9e-3) * r + 8.333_452e-3) * r + 4.166_579_6e-2) * r + 0.166_666_65) * r + 0.5;
    p * r * r + r + 1.0
}

#[inline(always)]
pub fn exp(x: f32) -> f32 {
    let bounded = x.clamp(-150.0, 150.0);
    let n = (bounded * std::f32::consts::LOG2_E + ROUNDER) - ROUNDER;
    let r = (bounded - n * 0.693_359_4) + n * 2.121_944_4e-4;
    let y = scaled(exp_reduced(r), n as i32);
    if x.is_nan() { x } else { y }
}

#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    let bounded = x.clamp(-200.0, 200.0);
    let n = (bounded + ROUNDER) - ROUNDER;
    let y = scaled(exp_reduced((bounded - n) * std::f32::consts::LN_2), n as i32);
    if x.is_nan() { x } else { y }
}

/// x = m * 2^e with m in [sqrt(1/2), sqrt(2)), for finite positive x, subnormal ones too.
#[inline(always)]
fn split(x: f32) -> (f32, f32) {
    let tiny = x < f32::MIN_POSITIVE;
    let bits = (if tiny { x * 8_388_608.0 } else { x }).to_bits();
    // Moves the boundary between exponents to sqrt(1/2).
    let shifted = bits.wrapping_sub(0x3f35_04f3);
    let e = (shifted as i32) >> 23;
    let m = f32::from_bits((shifted & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    (m, e as f32 - if tiny { 23.0 } else { 0.0 })
}

/// What a logarithm is where x is not a positive finite number.
#[inline(always)]
fn log_edges(x: f32, y: f32) -> f32 {
    let y = if x == f32::INFINITY { f32::INFINITY } else { y };
    let y = if x == 0.0 { f32::NEG_INFINITY } else { y };
    if x < 0.0 || x.is_nan() { f32::NAN } else { y }
}

/// ln m - f + f²/2 for m = 1 + f (Cephes logf).
#[inline(always)]
fn log_tail(f: f32) -> f32 {
    let p = 7.037_683_6e-2;
    let p = p * f - 0.115_146_1;
    let p = p * f + 0.116_769_98;
    let p = p * f - 0.124_201_41;
    let p = p * f + 0.142_493_23;
    let p = p * f - 0.166_680_58;
    let p = p * f + 0.200_007_14;
    let p = p * f - 0.249_999_94;
    let p = p * f + 0.333_333_3;
    p * f * f * f
}

#[inline(always)]
pub fn log(x: f32) -> f32 {
    let (m, e) = split(x);
    let f = m - 1.0;
    let y = (log_tail(f) + e * -2.121_944_4e-4 - 0.5 * f * f) + f + e * 0.693_359_4;
    log_edges(x, y)
}

#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let (m, e) = split(x);
    let f = m - 1.0;
    let tail = log_tail(f) - 0.5 * f * f;
    // f * log2(e) in two parts, so that the leading product loses nothing.
    let y = tail * std::f32::consts::LOG2_E + f * 0.442_695_05 + f + e;
    log_edges(x, y)
}

/// x reduced to a quarter turn: (r, quadrant). In double precision: |x| up to 2^30 keeps an absolute error of 1e-7.
#[inline(always)]
fn quarter_turn(x: f32) -> (f32, u32) {
    const ROUNDER_F64: f64 = 6_755_399_441_055_744.0;
    let x = f64::from(x);
    let shifted = x * std::f64::consts::FRAC_2_PI + ROUNDER_F64;
    let q = shifted - ROUNDER_F64;
    let r = (x - q * std::f64::consts::FRAC_PI_2) - q * 6.123_233_995_736_766e-17;
    (r as f32, shifted.to_bits() as u32)
}

/// Sine and cosine of |r| ≤ pi/4 (Cephes sinf, cosf).
#[inline(always)]
fn sin_reduced(r: f32) -> f32 {
    let z = r * r;
    ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 0.166_666_55) * z * r + r
}

#[inline(always)]
fn cos_reduced(r: f32) -> f32 {
    let z = r * r;
    ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0
}

#[inline(always)]
fn sin_of_quadrant(r: f32, quadrant: u32) -> f32 {
    let y = if quadrant & 1 == 0 { sin_reduced(r) } else { cos_reduced(r) };
    f32::from_bits(y.to_bits() ^ ((quadrant & 2) << 30))
}

#[inline(always)]
pub fn sin(x: f32) -> f32 {
    let (r, quadrant) = quarter_turn(x);
    sin_of_quadrant(r, quadrant)
}

#[inline(always)]
pub fn cos(x: f32) -> f32 {
    let (r, quadrant) = quarter_turn(x);
    sin_of_quadrant(r, quadrant.wrapping_add(1))
}

/// asin x - x for |x| ≤ 1/2 (Cephes asinf).
#[inline(always)]
fn asin_tail(x: f32, z: f32) -> f32 {
    ((((4.216_32e-2 * z + 2.418_131_1e-2) * z + 4.547_002_6e-2) * z + 7.495_300_3e-2) * z + 0.166_667_52) * z * x
}

#[inline(always)]
pub fn asin(x: f32) -> f32 {
    let a = x.abs();
    let large = a > 0.5;
    let z = if large { 0.5 * (1.0 - a) } else { a * a };
    let s = if large { z.sqrt() } else { a };
    let y = asin_tail(s, z) + s;
    let y = if large { FRAC_PI_2 - 2.0 * y } else { y };
    y.copysign(x)
}

#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let a = x.abs();
    let large = a > 0.5;
    let z = if large { 0.5 * (1.0 - a) } else { a * a };
    let s = if large { z.sqrt() } else { x };
    let y = asin_tail(s, z) + s;
    let far = if x < 0.0 { PI - 2.0 * y } else { 2.0 * y };
    if large { far } else { FRAC_PI_2 - y }
}

/// atan a for 0 ≤ a ≤ 1 (Cephes atanf).
#[inline(always)]
fn atan_to_one(a: f32) -> f32 {
    let large = a > 0.414_213_57;
    let t = if large { (a - 1.0) / (a + 1.0) } else { a };
    let z = t * t;
    let y = (((8.053_744_5e-2 * z - 0.138_776_85) * z + 0.199_777_11) * z - 0.333_329_5) * z * t + t;
    if large { FRAC_PI_4 + y } else { y }
}

#[inline(always)]
pub fn atan(x: f32) -> f32 {
    let a = x.abs();
    let steep = a > 1.0;
    let y = atan_to_one(if steep { 1.0 / a } else { a });
    (if steep { FRAC_PI_2 - y } else { y }).copysign(x)
}

/// Angle of (x, y). Both zero: as if x were ±1, so that no NaN comes of a pole.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (small, large) = if steep { (ax, ay) } else { (ay, ax) };
    let ratio = if small == large { 1.0 } else { small / large };
    let ratio = if large == 0.0 { 0.0 } else { ratio };
    let a = atan_to_one(ratio);
    let a = if steep { FRAC_PI_2 - a } else { a };
    let a = if x.is_sign_negative() { PI - a } else { a };
    let a = a.copysign(y);
    if x.is_nan() || y.is_nan() { f32::NAN } else { a }
}

/// x^y for x ≥ 0 through double precision, so that a large exponent costs no digits. Negative x gives NaN, as WGSL allows.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    let (m, e) = split(x);
    // log2 m by the series of artanh, to 2e-13.
    let m = f64::from(m);
    let t = (m - 1.0) / (m + 1.0);
    let z = t * t;
    let s = 1.0 / 13.0;
    let s = s * z + 1.0 / 11.0;
    let s = s * z + 1.0 / 9.0;
    let s = s * z + 1.0 / 7.0;
    let s = s * z + 1.0 / 5.0;
    let s = s * z + 1.0 / 3.0;
    let log2_m = (s * z * t + t) * (2.0 * std::f64::consts::LOG2_E);
    let exponent = (log2_m + f64::from(e)) * f64::from(y);
    let bounded = exponent.clamp(-300.0, 300.0);
    const ROUNDER_F64: f64 = 6_755_399_441_055_744.0;
    let shifted = bounded + ROUNDER_F64;
    let n = shifted - ROUNDER_F64;
    let r = (bounded - n) * std::f64::consts::LN_2;
    // e^r by its series, to 3e-12.
    let p = 1.0 / 362_880.0;
    let p = p * r + 1.0 / 40_320.0;
    let p = p * r + 1.0 / 5_040.0;
    let p = p * r + 1.0 / 720.0;
    let p = p * r + 1.0 / 120.0;
    let p = p * r + 1.0 / 24.0;
    let p = p * r + 1.0 / 6.0;
    let p = p * r + 0.5;
    let p = p * r * r + r + 1.0;
    let power = f64::from_bits(((shifted.to_bits() as u32 as i32 + 1023) as u64) << 52);
    let result = (p * power) as f32;
    let infinite = x == f32::INFINITY;
    let result = if infinite { if y > 0.0 { f32::INFINITY } else { 0.0 } } else { result };
    let result = if x == 0.0 { if y > 0.0 { 0.0 } else { f32::INFINITY } } else { result };
    let result = if y == 0.0 { 1.0 } else { result };
    if x < 0.0 || x.is_nan() || y.is_nan() { f32::NAN } else { result }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of `got` in units in the last place of the true value; subnormal values count in the smallest normal's.
    fn ulp(got: f32, truth: f64) -> f64 {
        if got.is_nan() {
            return f64::INFINITY;
        }
        let exponent = truth.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor();
        (f64::from(got) - truth).abs() / (exponent - 23.0).exp2()
    }

    /// The largest error over a sweep of `count` arguments from a to b.
    fn worst(f: fn(f32) -> f32, truth: fn(f64) -> f64, a: f32, b: f32) -> f64 {
        let count = 200_000;
        (0..=count)
            .map(|i| {
                let x = (f64::from(a) + (f64::from(b) - f64::from(a)) * f64::from(i) / f64::from(count)) as f32;
                ulp(f(x), truth(f64::from(x)))
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn errors_are_as_stated() {
        let rows: [(&str, f64, f64); 12] = [
            ("exp", worst(exp, f64::exp, -87.0, 88.0), 1.1),
            ("exp2", worst(exp2, f64::exp2, -125.0, 127.0), 1.1),
            ("log small", worst(log, f64::ln, 1e-3, 0.7), 1.1),
            ("log", worst(log, f64::ln, 1.42, 1e6), 1.1),
            ("log about 1", worst(log, f64::ln, 0.7, 1.4), 1.1),
            ("log2", worst(log2, f64::log2, 1e-3, 30.0), 2.1),
            ("asin", worst(asin, f64::asin, -1.0, 1.0), 2.4),
            ("acos", worst(acos, f64::acos, -1.0, 1.0), 1.8),
            ("atan", worst(atan, f64::atan, -40.0, 40.0), 2.7),
            ("pow 1/2.4", worst(|x| pow(x, 1.0 / 2.4), |x| x.powf(f64::from(1.0_f32 / 2.4)), 0.0, 8.0), 0.6),
            ("pow 200", worst(|x| pow(x, 200.0), |x| x.powf(200.0), 0.7, 1.5), 0.6),
            ("pow -3.7", worst(|x| pow(x, -3.7), |x| x.powf(f64::from(-3.7_f32)), 1e-3, 1e3), 0.6),
        ];
        let over: Vec<String> = rows.iter().filter(|r| r.1 > r.2).map(|(n, e, most)| format!("{n}: {e:.2} > {most} ulp")).collect();
        assert!(over.is_empty(), "{over:?}");
    }

    #[test]
    fn sine_and_cosine_hold_for_large_arguments() {
        let mut worst = 0.0_f64;
        for i in -200_000..200_000 {
            let x = i as f32 * 5.243;
            for (got, truth) in [(sin(x), f64::from(x).sin()), (cos(x), f64::from(x).cos())] {
                if truth.abs() > 1.0 / 1024.0 {
                    worst = worst.max(ulp(got, truth));
                }
            }
        }
        assert!(worst < 1.6, "{worst}");
        assert!((f64::from(sin(1e9)) - 1e9_f64.sin()).abs() < 2e-7);
        assert!(sin(f32::INFINITY).is_nan() && cos(f32::NAN).is_nan());
    }

    #[test]
    fn atan2_in_every_quadrant_and_on_the_axes() {
        let mut worst = 0.0_f64;
        for i in 0..720 {
            for r in [1e-30_f64, 1e-3, 1.0, 7e20] {
                let angle = f64::from(i) * std::f64::consts::PI / 360.0 - 3.1;
                let (y, x) = ((r * angle.sin()) as f32, (r * angle.cos()) as f32);
                worst = worst.max(ulp(atan2(y, x), f64::from(y).atan2(f64::from(x))));
            }
        }
        assert!(worst < 3.0, "{worst}");
        assert_eq!((atan2(0.0, 0.0), atan2(0.0, 1.0), atan2(-0.0, -1.0), atan2(0.0, -1.0)), (0.0, 0.0, -PI, PI));
        assert_eq!((atan2(1.0, 0.0), atan2(-1.0, 0.0)), (FRAC_PI_2, -FRAC_PI_2));
        assert!((atan2(f32::INFINITY, f32::INFINITY) - FRAC_PI_4).abs() < 1e-7);
        assert!(atan2(f32::NAN, 1.0).is_nan() && atan2(1.0, f32::NAN).is_nan());
    }

    #[test]
    fn edges() {
        assert_eq!((exp(f32::INFINITY), exp(f32::NEG_INFINITY), exp(0.0)), (f32::INFINITY, 0.0, 1.0));
        assert_eq!((exp(200.0), exp(-200.0), exp2(-150.5)), (f32::INFINITY, 0.0, 0.0));
        assert!(exp(-100.0) > 0.0 && exp(-100.0) < f32::MIN_POSITIVE, "subnormal results are kept");
        assert!(exp(f32::NAN).is_nan() && log(f32::NAN).is_nan() && log(-1.0).is_nan());
        assert_eq!((log(0.0), log(f32::INFINITY), log(1.0)), (f32::NEG_INFINITY, f32::INFINITY, 0.0));
        assert!((f64::from(log(1e-42)) - f64::from(1e-42_f32).ln()).abs() < 1e-5, "subnormal arguments");
        assert!(asin(1.5).is_nan() && acos(-1.5).is_nan());
        assert_eq!((pow(0.0, 2.0), pow(0.0, -1.0), pow(0.0, 0.0), pow(f32::INFINITY, -1.0)), (0.0, f32::INFINITY, 1.0, 0.0));
        assert!(pow(-2.0, 2.0).is_nan() && pow(2.0, 1e9) == f32::INFINITY && pow(2.0, -1e9) == 0.0);
    }

    #[test]
    fn the_measure_of_errors_sees_one() {
        assert!(worst(|x| x.exp() * 1.000_001, f64::exp, 0.0, 1.0) > 5.0);
    }
}
