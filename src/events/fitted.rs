//! A position as a Chebyshev polynomial over a span of hours or days, which is faster to evaluate than the ephemeris.
//!
//! In: the position as a function of time, and the span. Out: the polynomial, or the first error of the function. Beyond the span, the polynomial diverges.

use crate::ephemeris::{EphemerisError, chebyshev};
use glam::DVec3;
use std::cell::RefCell;

/// Number of Chebyshev terms per axis. The error is under a metre over 38 hours of the Moon's motion, or over half an orbit of Io.
const TERMS: usize = 14;

/// A fitted position, km. Times are seconds from the middle of the span.
#[derive(Clone, Debug)]
pub(super) struct FittedPosition {
    /// Half of the span.
    half_span_s: f64,
    /// Chebyshev coefficients of x, y and z.
    coefficients: [Vec<f64>; 3],
}

impl FittedPosition {
    /// Fits `position` from -`half_span_s` to `half_span_s`.
    ///
    /// # Errors
    /// The first error of `position`.
    pub(crate) fn fit(half_span_s: f64, position: impl Fn(f64) -> Result<DVec3, EphemerisError>) -> Result<Self, EphemerisError> {
        let first_error = RefCell::new(None);
        let coefficients = chebyshev::fit_nodes(TERMS, |u| {
            position(u * half_span_s).unwrap_or_else(|e| {
                first_error.borrow_mut().get_or_insert(e);
                DVec3::ZERO
            })
        });
        first_error.into_inner().map_or(Ok(Self { half_span_s, coefficients }), Err)
    }

    /// The position `s` seconds after the middle of the span, km.
    pub(crate) fn at(&self, s: f64) -> DVec3 {
        DVec3::from_array(self.coefficients.each_ref().map(|c| chebyshev::value_and_slope(c, s / self.half_span_s).0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orbit_is_fitted_and_an_error_is_returned() {
        let circle = |s: f64| DVec3::new((s / 2e4).cos(), (s / 2e4).sin(), 0.0) * 4e5;
        let fitted = FittedPosition::fit(3e4, |s| Ok(circle(s))).expect("a fit");
        for i in -30..=30 {
            let s = f64::from(i) * 1e3;
            assert!((fitted.at(s) - circle(s)).length() < 1e-3, "{s}");
        }
        assert!(FittedPosition::fit(1.0, |_| Err(EphemerisError::other("none"))).is_err());
    }
}
