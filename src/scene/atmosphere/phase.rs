//! Phase functions of the air, per steradian and linear sRGB channel: the mean over all directions is 1 / (4 pi).
//!
//! In: the catalog's phase function of a species, and the cosine of the scattering angle, 1 for forward scattering. Out: the phase function's value, and the
//! mean cosine. Always: the value is that of the shader's function (shaders/lib/air/phase.wesl) divided by pi; tests/shader/formulas.rs compares the two.
//! docs/phase-function.md says how to change a phase function.

use crate::catalog::{AerosolFunction, AerosolPhase, PhaseFunction};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The value of a phase function in each channel.
pub fn per_steradian(phase: PhaseFunction, cos_scattering: f64) -> DVec3 {
    match phase {
        PhaseFunction::Rayleigh => DVec3::splat(rayleigh(cos_scattering)),
        // Destructured without `..`, so that a new parameter is a compile error here.
        PhaseFunction::Aerosol(AerosolPhase { function, asymmetry }) => DVec3::from_array(asymmetry).map(|asymmetry| match function {
            AerosolFunction::HenyeyGreenstein => henyey_greenstein(cos_scattering, asymmetry),
        }),
    }
}

/// The mean cosine of the scattering angle in each channel, to 1e-9 for peaks as narrow as that of Henyey-Greenstein's function with an asymmetry of 0.995.
pub(crate) fn mean_cosine(phase: PhaseFunction) -> DVec3 {
    const STEPS: u32 = 256;
    let (mut sum, mut sum_of_cosines) = (DVec3::ZERO, DVec3::ZERO);
    for k in 0..STEPS {
        // The scattering angle is (t - sin t) / 2, and 1 - cos t is proportional to its derivative: the angles are closely spaced at both ends, where the
        // functions have their peaks.
        let t = TAU * (f64::from(k) + 0.5) / f64::from(STEPS);
        let (sin, cos) = (0.5 * (t - t.sin())).sin_cos();
        let scattered = per_steradian(phase, cos) * (sin * (1.0 - t.cos()));
        sum += scattered;
        sum_of_cosines += scattered * cos;
    }
    sum_of_cosines / sum
}

/// Rayleigh's phase function, for gas.
fn rayleigh(cos_scattering: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos_scattering * cos_scattering)
}

/// Henyey and Greenstein's phase function, for aerosols (1941, Astrophysical Journal 93, 70).
fn henyey_greenstein(cos_scattering: f64, asymmetry: f64) -> f64 {
    // In the forward direction the base is (1 - g)^2, with g the asymmetry. As in the shader, it is kept above 0 for g near 1.
    let base = (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cos_scattering).max(1e-6);
    (1.0 - asymmetry * asymmetry) / (4.0 * PI * base.powf(1.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoint rule over the cosine; for the narrowest lobe its error is below 1e-4.
    #[test]
    fn the_functions_are_normalised_and_have_their_mean_cosine() {
        const STEPS: usize = 100_000;
        let cosines = || (0..STEPS).map(|k| (2.0 * k as f64 + 1.0) / STEPS as f64 - 1.0);
        let mean = |values: &dyn Fn(f64) -> DVec3| cosines().map(values).sum::<DVec3>() / STEPS as f64;
        let is_one = |values: DVec3| (values - 1.0).abs().max_element() < 1e-4;
        assert!(is_one(4.0 * PI * mean(&|cos| per_steradian(PhaseFunction::Rayleigh, cos))));
        for aerosol in AerosolPhase::samples() {
            let phase = PhaseFunction::Aerosol(aerosol);
            assert!(is_one(4.0 * PI * mean(&|cos| per_steradian(phase, cos))), "{aerosol:?}");
            let (found, expected) = (mean_cosine(phase), 4.0 * PI * mean(&|cos| cos * per_steradian(phase, cos)));
            assert!((found - expected).abs().max_element() < 1e-4, "{aerosol:?}: {found}, not {expected}");
        }
    }

    #[test]
    fn the_mean_cosine_of_henyey_greenstein_is_the_asymmetry() {
        for asymmetry in [[-0.3, 0.0, 0.5], [0.8, 0.95, 0.995]] {
            let aerosol = AerosolPhase { asymmetry, ..AerosolPhase::of(AerosolFunction::HenyeyGreenstein) };
            let found = mean_cosine(PhaseFunction::Aerosol(aerosol));
            assert!((found - DVec3::from_array(asymmetry)).abs().max_element() < 1e-9, "{found}, not {asymmetry:?}");
        }
    }
}
