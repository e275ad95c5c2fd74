//! Roots and minima of smooth functions of time.
//!
//! In: a function, and an interval with one root or one minimum. Out: the argument of the root or minimum, within a tolerance. Times are seconds from an
//! instant near the event: beyond 5e11 s (16,000 years) neighbouring f64 numbers are farther apart than the tolerance, and the searches would not end.

use crate::units::INVERSE_GOLDEN_RATIO;

/// Tolerance of times, seconds.
const TOLERANCE_S: f64 = 1e-4;

/// The zero of `f` between `inside`, where `f` is negative, and `outside`, which may be earlier. If `f` is negative at `outside`, the result is `outside`.
/// Between the two, the sign of `f` changes at most once.
pub(super) fn zero_crossing(inside: f64, outside: f64, f: impl Fn(f64) -> f64) -> f64 {
    if f(outside) < 0.0 {
        return outside;
    }
    let (mut negative, mut not_negative) = (inside, outside);
    while (not_negative - negative).abs() > TOLERANCE_S {
        let middle = 0.5 * (negative + not_negative);
        if f(middle) < 0.0 {
            negative = middle;
        } else {
            not_negative = middle;
        }
    }
    0.5 * (negative + not_negative)
}

/// The argument at which `f`, which has one minimum between `a` and the larger `b`, is least, by golden-section search to `tolerance`. `f` is flat near its
/// minimum, so rounding errors of its values can displace the result by more than `tolerance`.
pub(super) fn minimum(mut a: f64, mut b: f64, tolerance: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut left, mut right) = (b - INVERSE_GOLDEN_RATIO * (b - a), a + INVERSE_GOLDEN_RATIO * (b - a));
    let (mut f_left, mut f_right) = (f(left), f(right));
    while b - a > tolerance {
        if f_left < f_right {
            (b, right, f_right) = (right, left, f_left);
            left = b - INVERSE_GOLDEN_RATIO * (b - a);
            f_left = f(left);
        } else {
            (a, left, f_left) = (left, right, f_right);
            right = a + INVERSE_GOLDEN_RATIO * (b - a);
            f_right = f(right);
        }
    }
    0.5 * (a + b)
}

/// As [`minimum`], for a function of time in seconds.
pub(super) fn time_of_minimum(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    minimum(a, b, TOLERANCE_S, f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_and_minima_are_found() {
        assert!((zero_crossing(0.0, 9000.0, |s| s * s - 1e6) - 1000.0).abs() < 1e-3);
        assert!((zero_crossing(0.0, -9000.0, |s| s * s - 1e6) + 1000.0).abs() < 1e-3);
        assert_eq!(zero_crossing(0.0, 500.0, |s| s * s - 1e6), 500.0);
        assert!((time_of_minimum(-9000.0, 9000.0, |s| (1e6 + (s - 321.0).powi(2)).sqrt()) - 321.0).abs() < 2e-3);
    }
}
