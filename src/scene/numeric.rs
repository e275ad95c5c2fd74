//! Numerical methods, and a format of numbers, that several modules of `scene` use.

use std::f64::consts::PI;

/// Nodes of Gauss-Legendre quadrature on 0 to 1, ascending, with their weights, which sum to 1. Exact for polynomials up to degree `2 count - 1`.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |k: usize| {
        let mut x = -(PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        // Derivative of the Legendre polynomial at x.
        let mut slope = 1.0;
        // Newton's method on the Legendre polynomial, from the usual asymptotic estimate of its roots. It converges in fewer than eight steps.
        for _ in 0..8 {
            // The Legendre polynomials of degree j - 1 and j at x.
            let (mut previous, mut current) = (1.0, x);
            for j in 2..=count {
                let j = j as f64;
                (previous, current) = (current, ((2.0 * j - 1.0) * x * current - (j - 1.0) * previous) / j);
            }
            slope = n * (x * current - previous) / (x * x - 1.0);
            x -= current / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Hermite interpolation from 0 at 0 to 1 at 1, with slope 0 at both ends and constant outside: WGSL's `smoothstep(0, 1, x)`.
pub(crate) fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// [`smoothstep`] between two limits: 0 up to the first, 1 from the second.
pub(crate) fn smooth_rise((start, end): (f64, f64), value: f64) -> f64 {
    smoothstep((value - start) / (end - start))
}

/// A number with this many significant digits, without trailing zeros after the decimal point; at most nine decimals, and no digit before the point is dropped.
pub(crate) fn with_significant_digits(number: f64, digits: i32) -> String {
    let decimals = (f64::from(digits) - 1.0 - number.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_is_exact_for_its_degree_and_not_beyond() {
        for count in [1, 4, 6, 8, 12, 16, 32] {
            let nodes = gauss_legendre(count);
            let power = |p: i32| nodes.iter().map(|(x, w)| w * x.powi(p)).sum::<f64>();
            let degree = 2 * count as i32 - 1;
            for p in 0..=degree {
                assert!((power(p) - 1.0 / f64::from(p + 1)).abs() < 1e-12, "{count} nodes, power {p}");
            }
            // With more than 8 nodes the error of the next degree is too small for this test.
            assert!((power(degree + 1) - 1.0 / f64::from(degree + 2)).abs() > 1e-12 || count > 8);
            assert!(nodes.windows(2).all(|w| w[0].0 < w[1].0));
        }
    }

    #[test]
    fn numbers_have_their_significant_digits() {
        for (number, digits, text) in [
            (1234.5, 3, "1234"),
            (12.345, 3, "12.3"),
            (0.5, 3, "0.5"),
            (0.001_26, 2, "0.0013"),
            (100.0, 2, "100"),
            (-2.0, 3, "-2"),
            (0.0, 3, "0"),
        ] {
            assert_eq!(with_significant_digits(number, digits), text);
        }
    }

    #[test]
    fn smoothstep_is_flat_at_its_ends() {
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0].map(smoothstep), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!(smoothstep(1e-4) < 1e-7 && 1.0 - smoothstep(1.0 - 1e-4) < 1e-7 && smoothstep(0.25) < 0.25);
    }
}
