//! Phase functions of the air, per steradian and linear sRGB channel: the mean over all directions is 1 / (4 pi).
//!
//! In: the catalog's phase function of a species, and the cosine of the scattering angle, 1 for forward scattering. Out: the phase function's value, and the
//! mean cosine. Always: the value is that of the shader's function (shaders/lib/air/phase.wesl) divided by pi; tests/shader/formulas.rs compares both with
//! each other and with functions of its own. docs/phase-function.md says how to change a phase function.

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
        // functions have their peaks. Constant factors cancel in the quotient of the sums.
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
    (1.0 - asymmetry * asymmetry) / (4.0 * PI * asymmetry_base(cos_scattering, asymmetry).powf(1.5))
}

/// 1 + g^2 - 2 g c, with g the asymmetry and c the cosine: the base of the powers in Henyey-Greenstein's and other functions. In the forward direction it is
/// (1 - g)^2, which is 0 for g = 1; as in the shader, it is at least 1e-6, so that nothing divides by 0.
fn asymmetry_base(cos_scattering: f64, asymmetry: f64) -> f64 {
    (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cos_scattering).max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, Species};

    /// Whether each channel differs by less than a tolerance; false if one is NaN. (`max_element` may lose a NaN.)
    fn are_near(found: DVec3, expected: DVec3, tolerance: f64) -> bool {
        (found - expected).abs().cmplt(DVec3::splat(tolerance)).all()
    }

    /// Tests every function, so that a new one needs no test of its own. The means are computed by the midpoint rule over the cosine; for the narrowest peak of
    /// the samples its error is below 1e-4. Some samples have an asymmetry of 0: a formula that divides by the asymmetry gives NaN there, and the test fails.
    #[test]
    fn the_functions_are_normalised_and_have_their_mean_cosine() {
        const STEPS: usize = 100_000;
        let cosines = || (0..STEPS).map(|k| (2.0 * k as f64 + 1.0) / STEPS as f64 - 1.0);
        let mean = |values: &dyn Fn(f64) -> DVec3| cosines().map(values).sum::<DVec3>() / STEPS as f64;
        let is_one = |values: DVec3| are_near(values, DVec3::ONE, 1e-4);
        assert!(!is_one(DVec3::new(1.0, f64::NAN, 1.0)) && !is_one(DVec3::splat(1.001)), "the checks below cannot fail");
        assert!(is_one(4.0 * PI * mean(&|cos| per_steradian(PhaseFunction::Rayleigh, cos))));
        for aerosol in AerosolPhase::samples() {
            let phase = PhaseFunction::Aerosol(aerosol);
            let all_light = 4.0 * PI * mean(&|cos| per_steradian(phase, cos));
            assert!(is_one(all_light), "{aerosol:?}: {all_light} of the light, not all; NaN: a formula that is 0 / 0 for some asymmetry");
            let (found, expected) = (mean_cosine(phase), 4.0 * PI * mean(&|cos| cos * per_steradian(phase, cos)));
            assert!(are_near(found, expected, 1e-4), "{aerosol:?}: {found}, not {expected}");
        }
    }

    #[test]
    fn the_mean_cosine_of_henyey_greenstein_is_the_asymmetry() {
        for asymmetry in [[-0.3, 0.0, 0.5], [0.8, 0.95, 0.995]] {
            let aerosol = AerosolPhase { asymmetry, ..AerosolPhase::of(AerosolFunction::HenyeyGreenstein) };
            let found = mean_cosine(PhaseFunction::Aerosol(aerosol));
            assert!(are_near(found, DVec3::from_array(asymmetry), 1e-9), "{found}, not {asymmetry:?}");
        }
    }

    /// Prints, for each function and each aerosol of the catalog: the function's value relative to Henyey-Greenstein's in four directions, and its mean
    /// cosine, with the aerosol's asymmetry; and the same with the asymmetry that has the mean cosine of Henyey-Greenstein's function, NaN if none has. For
    /// Henyey-Greenstein's function itself, this must be the aerosol's own asymmetry. Further numbers are the aerosol's if it has this function.
    #[test]
    fn each_function_compared_with_henyey_greenstein() {
        const COSINES: [(f64, &str); 4] = [(1.0, "forwards"), (0.707, "at 45 degrees"), (0.0, "sideways"), (-1.0, "backwards")];
        let catalog = Catalog::embedded();
        let airs = catalog.bodies().iter().filter_map(|body| Some((&body.name, body.atmosphere.as_ref()?)));
        let aerosols =
            airs.flat_map(|(name, air)| air.species.iter().filter_map(Species::aerosol_phase).map(move |aerosol| (name, aerosol)));
        let aerosols: Vec<(&String, AerosolPhase)> = aerosols.collect();
        assert!(aerosols.len() >= 4, "{aerosols:?}");
        for function in AerosolFunction::ALL {
            for (name, aerosol) in &aerosols {
                let asymmetry = &aerosol.asymmetry;
                let of = |function: AerosolFunction, asymmetry: [f64; 3]| {
                    let with_numbers = if aerosol.function == function { *aerosol } else { AerosolPhase::of(function) };
                    PhaseFunction::Aerosol(AerosolPhase { asymmetry, ..with_numbers })
                };
                let ratios_to_hg = |asymmetry_of_function: [f64; 3]| {
                    let phases = [of(function, asymmetry_of_function), of(AerosolFunction::HenyeyGreenstein, *asymmetry)];
                    let ratios = COSINES.map(|(cos, direction)| {
                        let [value, value_of_hg] = phases.map(|phase| per_steradian(phase, cos));
                        format!("{direction} {:.2}", value / value_of_hg)
                    });
                    ratios.join(", ")
                };
                let asymmetry_of_same_mean = DVec3::from_array(*asymmetry).map(|wanted| {
                    // By bisection; the mean cosine grows with the asymmetry.
                    let (mut below, mut above) = (-0.999, 0.999);
                    for _ in 0..50 {
                        let middle = 0.5 * (below + above);
                        let is_below = mean_cosine(of(function, [middle; 3])).x < wanted;
                        (below, above) = if is_below { (middle, above) } else { (below, middle) };
                    }
                    let found = mean_cosine(of(function, [below; 3])).x;
                    if (found - wanted).abs() < 1e-6 { below } else { f64::NAN }
                });
                let mean = mean_cosine(of(function, *asymmetry));
                println!("{function:?}, {name}, g {asymmetry:?} kept: {}; mean cosine {mean:.3}", ratios_to_hg(*asymmetry));
                let ratios_of_same_mean = ratios_to_hg(asymmetry_of_same_mean.to_array());
                println!("    mean cosine of Henyey-Greenstein's function kept: g {asymmetry_of_same_mean:.3}; {ratios_of_same_mean}");
                let is_unchanged = are_near(asymmetry_of_same_mean, DVec3::from_array(*asymmetry), 1e-6);
                assert!(is_unchanged || function != AerosolFunction::HenyeyGreenstein, "{name}: {asymmetry_of_same_mean}");
            }
        }
    }
}
