//! Chebyshev series, as in SPK kernels and in `chebyshev_cache`.
//!
//! In: coefficients and an argument in -1..=1, or a function on that interval. Out: value and derivative, or the coefficients of the polynomial that
//! interpolates the function at the Chebyshev nodes. The interpolant's error is within a small factor of that of the best polynomial of its degree.

use glam::DVec3;
use std::f64::consts::PI;

/// Value and derivative at `u` in -1..=1 of the sum of `c[k] T_k(u)`, by Clenshaw's recurrence and its derivative. `c` must
/// not be empty.
pub fn value_and_slope(c: &[f64], u: f64) -> (f64, f64) {
    // Clenshaw's last two partial results, and their derivatives with respect to `u`.
    let (mut b1, mut b2, mut d1, mut d2) = (0.0, 0.0, 0.0, 0.0);
    for &ck in c[1..].iter().rev() {
        let d0 = 2.0 * b1 + 2.0 * u * d1 - d2;
        let b0 = ck + 2.0 * u * b1 - b2;
        (b2, b1, d2, d1) = (b1, b0, d1, d0);
    }
    (c[0] + u * b1 - b2, b1 + u * d1 - d2)
}

/// The Chebyshev coefficients, by axis, of the polynomial of `terms` terms that interpolates `position` at the `terms` Chebyshev nodes of -1..=1.
pub fn fit_nodes(terms: usize, position: impl Fn(f64) -> DVec3) -> [Vec<f64>; 3] {
    // T_k at node j is the cosine of this angle.
    let angle = |k: usize, j: usize| PI * k as f64 * (j as f64 + 0.5) / terms as f64;
    let values: Vec<DVec3> = (0..terms).map(|j| position(angle(1, j).cos())).collect();
    std::array::from_fn(|axis| {
        (0..terms)
            .map(|k| {
                let sum: f64 = (0..terms).map(|j| values[j][axis] * angle(k, j).cos()).sum();
                sum * if k == 0 { 1.0 } else { 2.0 } / terms as f64
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_their_slopes_agree_with_cosines() {
        let c = [0.3, -1.2, 0.7, 0.05, -0.4];
        for i in 0..=20 {
            let theta = 0.01 + f64::from(i) / 20.0 * 3.1;
            let value: f64 = c.iter().enumerate().map(|(k, c)| c * (k as f64 * theta).cos()).sum();
            let slope: f64 = c.iter().enumerate().map(|(k, c)| c * k as f64 * (k as f64 * theta).sin() / theta.sin()).sum();
            let (found_value, found_slope) = value_and_slope(&c, theta.cos());
            assert!((found_value - value).abs() < 1e-14 && (found_slope - slope).abs() < 1e-11, "{theta}: {found_value} {found_slope}");
        }
    }

    #[test]
    fn polynomials_are_reproduced_and_curves_approximated() {
        let cubic = fit_nodes(5, |u| DVec3::new(1.0 - 2.0 * u * u * u, u, 3.0));
        let curve = fit_nodes(12, |u| DVec3::new((2.0 * u).sin(), (2.0 * u).cos(), 0.0));
        for i in -10..=10 {
            let u = f64::from(i) / 10.0;
            let (value, slope) = value_and_slope(&cubic[0], u);
            assert!((value - (1.0 - 2.0 * u * u * u)).abs() < 1e-14 && (slope + 6.0 * u * u).abs() < 1e-13, "{u}: {value} {slope}");
            // The remainder of 12 terms: 2^12 / (12! 2^11) = 4.2e-9.
            let (value, _) = value_and_slope(&curve[0], u);
            assert!((value - (2.0 * u).sin()).abs() < 4.2e-9, "{u}: {value}");
        }
    }
}
