//! The larger and the smaller of two numbers for folds over results, where NaN must not get lost: `f64::max` and `f64::min` ignore it, so that a wrong result
//! would pass. These functions return it instead, and it fails each comparison that follows. `DVec3::max_element` may lose NaN, too.

use glam::DVec3;

/// Whether a number is NaN: only NaN is not equal to itself.
fn is_nan<T: PartialOrd>(number: &T) -> bool {
    number.partial_cmp(number).is_none()
}

/// The larger number, or NaN if one of them is NaN.
pub fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if is_nan(&a) || a >= b { a } else { b }
}

/// The smaller number, or NaN if one of them is NaN.
pub fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if is_nan(&a) || a <= b { a } else { b }
}

/// The largest component, or NaN if one of them is NaN.
pub fn largest_component(v: DVec3) -> f64 {
    v.to_array().into_iter().fold(f64::NEG_INFINITY, larger)
}

#[test]
fn nan_is_both_the_largest_and_the_smallest() {
    for position in 0..3 {
        // The sign of NaN, which decides its place in `total_cmp`, has no effect.
        for nan in [f64::NAN, -f64::NAN] {
            let mut numbers = [1.0, 3.0, 2.0];
            assert_eq!((numbers.into_iter().fold(0.0, larger), numbers.into_iter().fold(9.0, smaller)), (3.0, 1.0));
            numbers[position] = nan;
            assert!(numbers.into_iter().fold(0.0, larger).is_nan() && numbers.into_iter().fold(9.0, smaller).is_nan());
        }
    }
    assert_eq!(largest_component(DVec3::new(-3.0, -1.0, -2.0)), -1.0);
    assert!(DVec3::AXES.into_iter().all(|axis| largest_component(DVec3::select(axis.cmpgt(DVec3::ZERO), DVec3::NAN, axis)).is_nan()));
    assert_eq!((larger(f32::INFINITY, 1.0), smaller(f32::NEG_INFINITY, 1.0)), (f32::INFINITY, f32::NEG_INFINITY));
}
