//! Published phase laws: brightness of the planets' globes and of the Moon as a function of phase angle.
//!
//! In: a body and a phase angle. Out: its brightness relative to zero phase; the brightness at zero phase follows from the catalog's geometric albedo.
//!
//! Source for the planets: Mallama and Hilton 2018, "Computing apparent planetary magnitudes for The Astronomical Almanac", Astronomy and Computing 25, 10-24,
//! the V-band laws without the terms of rotation and without Saturn's rings. Source for the Moon: Allen 1976, Astrophysical Quantities, 3rd ed., section
//! 66: 0.026 a + 4.0e-9 a^4 mag, a in degrees.

use crate::catalog::NaifId;
use glam::DVec3;

/// A curve of magnitude by phase angle. Coefficients begin with the constant term.
enum Curve {
    /// A polynomial of the angle in degrees.
    Magnitude(&'static [f64]),
    /// A magnitude, and the factor on its flux: a polynomial of the angle as a fraction of 180 degrees.
    Flux(f64, &'static [f64]),
}

impl Curve {
    fn magnitude(&self, alpha_deg: f64) -> f64 {
        let polynomial = |coefficients: &[f64], x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
        match self {
            Self::Magnitude(coefficients) => polynomial(coefficients, alpha_deg),
            Self::Flux(magnitude, coefficients) => magnitude - 2.5 * polynomial(coefficients, alpha_deg / 180.0).log10(),
        }
    }
}

/// Magnitude as a function of phase angle.
pub(crate) struct PhaseLaw {
    /// Each curve with the largest angle to which it applies, degrees; in ascending order.
    pieces: &'static [(f64, Curve)],
    /// Largest phase angle to which the law was fitted, degrees.
    pub limit_deg: f64,
    /// Direction from which the body was measured, body axes, if it always shows this side. The laws of the others are means over their rotation.
    pub measured_side: Option<DVec3>,
}

impl PhaseLaw {
    /// Brightness relative to zero phase. `alpha_deg`: phase angle, 0..=`limit_deg`.
    pub(crate) fn brightness(&self, alpha_deg: f64) -> f64 {
        10f64.powf(-0.4 * (self.magnitude(alpha_deg) - self.magnitude(0.0)))
    }

    fn magnitude(&self, alpha_deg: f64) -> f64 {
        let piece = self.pieces.iter().find(|(up_to, _)| alpha_deg <= *up_to).or(self.pieces.last());
        piece.map_or(0.0, |(_, curve)| curve.magnitude(alpha_deg))
    }
}

use Curve::{Flux, Magnitude};

const MERCURY: PhaseLaw = PhaseLaw {
    pieces: &[(170.0, Magnitude(&[-0.613, 6.3280e-2, -1.6336e-3, 3.3644e-5, -3.4265e-7, 1.6893e-9, -3.0334e-12]))],
    limit_deg: 170.0,
    measured_side: None,
};
const VENUS: PhaseLaw = PhaseLaw {
    pieces: &[
        (163.7, Magnitude(&[-4.384, -1.044e-3, 3.687e-4, -2.814e-6, 8.938e-9])),
        (179.0, Magnitude(&[236.05828, -2.81914, 8.39034e-3])),
    ],
    limit_deg: 179.0,
    measured_side: None,
};
const EARTH: PhaseLaw = PhaseLaw { pieces: &[(170.0, Magnitude(&[-3.99, -1.060e-3, 2.054e-4]))], limit_deg: 170.0, measured_side: None };
const MOON: PhaseLaw =
    PhaseLaw { pieces: &[(150.0, Magnitude(&[0.0, 0.026, 0.0, 0.0, 4.0e-9]))], limit_deg: 150.0, measured_side: Some(DVec3::X) };
const MARS: PhaseLaw = PhaseLaw {
    pieces: &[(50.0, Magnitude(&[-1.601, 2.267e-2, -1.302e-4])), (120.0, Magnitude(&[-0.367, -2.573e-2, 3.445e-4]))],
    limit_deg: 120.0,
    measured_side: None,
};
const JUPITER: PhaseLaw = PhaseLaw {
    pieces: &[(12.0, Magnitude(&[-9.395, -3.7e-4, 6.16e-4])), (130.0, Flux(-9.428, &[1.0, -1.507, -0.363, -0.062, 2.809, -1.876]))],
    limit_deg: 130.0,
    measured_side: None,
};
const SATURN: PhaseLaw = PhaseLaw {
    pieces: &[(6.5, Magnitude(&[-8.95, -3.7e-4, 6.16e-4])), (150.0, Magnitude(&[-8.94, 2.446e-4, 2.672e-4, -1.506e-6, 4.767e-9]))],
    limit_deg: 150.0,
    measured_side: None,
};
const URANUS: PhaseLaw = PhaseLaw { pieces: &[(154.0, Magnitude(&[-7.110, 6.587e-3, 1.045e-4]))], limit_deg: 154.0, measured_side: None };
const NEPTUNE: PhaseLaw = PhaseLaw { pieces: &[(133.0, Magnitude(&[-7.00, 7.944e-3, 9.617e-5]))], limit_deg: 133.0, measured_side: None };

/// The published law of a body; `None` if there is none.
pub(crate) fn law(body: NaifId) -> Option<&'static PhaseLaw> {
    match body.0 {
        199 => Some(&MERCURY),
        299 => Some(&VENUS),
        399 => Some(&EARTH),
        301 => Some(&MOON),
        499 => Some(&MARS),
        599 => Some(&JUPITER),
        699 => Some(&SATURN),
        799 => Some(&URANUS),
        899 => Some(&NEPTUNE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_join_within_a_tenth_of_a_magnitude() {
        for id in [299, 499, 599, 699] {
            let law = law(NaifId(id)).expect("has a law");
            for pair in law.pieces.windows(2) {
                let boundary_deg = pair[0].0;
                let step = law.magnitude(boundary_deg) - law.magnitude(boundary_deg + 1e-6);
                assert!(step.abs() < 0.1, "{id} jumps by {step} mag at {boundary_deg} degrees");
            }
        }
    }

    #[test]
    fn brightness_is_one_at_full_phase_and_less_at_quadrature() {
        for id in [199, 299, 399, 301, 499, 599, 699, 799, 899] {
            let law = law(NaifId(id)).expect("has a law");
            assert!((law.brightness(0.0) - 1.0).abs() < 1e-12);
            assert!((0.05..0.6).contains(&law.brightness(90.0)), "{id}: {}", law.brightness(90.0));
        }
    }

    #[test]
    fn a_half_moon_is_an_eleventh_of_a_full_one() {
        // Allen 1976: phase 90 degrees is 2.60 mag fainter than full, a factor of 10.96.
        let factor = 1.0 / law(NaifId::MOON).expect("has a law").brightness(90.0);
        assert!((10.9..11.1).contains(&factor), "{factor}");
    }
}
