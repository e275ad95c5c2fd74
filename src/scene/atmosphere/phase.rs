//! Phase functions of the air, per steradian and linear sRGB channel: the mean over all directions is 1 / (4 pi).
//!
//! In: the catalog's phase function of a species, and the cosine of the scattering angle, 1 for forward scattering. Out: the phase function's value. Always:
//! the value is that of the shader's function (shaders/lib/air/phase.wesl) divided by pi; tests/shader/formulas.rs compares the two. docs/phase-function.md
//! says how to add a phase function.

use crate::catalog::{AerosolPhase, PhaseFunction};
use glam::DVec3;
use std::f64::consts::PI;

/// The value of a phase function in each channel.
pub fn per_steradian(phase: PhaseFunction, cos_scattering: f64) -> DVec3 {
    match phase {
        PhaseFunction::Rayleigh => DVec3::splat(rayleigh(cos_scattering)),
        PhaseFunction::Aerosol(AerosolPhase { asymmetry }) => {
            DVec3::from_array(asymmetry).map(|asymmetry| henyey_greenstein(cos_scattering, asymmetry))
        }
    }
}

/// Rayleigh's phase function, for gas.
fn rayleigh(cos_scattering: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos_scattering * cos_scattering)
}

/// Henyey and Greenstein's phase function, for aerosols (1941, Astrophysical Journal 93, 70).
fn henyey_greenstein(cos_scattering: f64, asymmetry: f64) -> f64 {
    // In the forward direction the denominator is (1 - g)^2, with g the asymmetry. As in the shader, it is kept above 0 for g near 1.
    let denominator = (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cos_scattering).max(1e-6);
    (1.0 - asymmetry * asymmetry) / (4.0 * PI * denominator.powf(1.5))
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
        for aerosol in AerosolPhase::SAMPLES {
            let phase = |cos: f64| per_steradian(PhaseFunction::Aerosol(aerosol), cos);
            assert!(is_one(4.0 * PI * mean(&phase)), "{aerosol:?}");
            let mean_cosine = 4.0 * PI * mean(&|cos| cos * phase(cos));
            let error = (mean_cosine - DVec3::from_array(aerosol.mean_cosine())).abs().max_element();
            assert!(error < 1e-4, "{mean_cosine} for {aerosol:?}");
        }
    }
}
