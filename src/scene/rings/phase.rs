//! Phase functions of a ring's particles, normalised to a mean of 1 over all directions.
//!
//! In: the phase angle `alpha` in radians (0 is backscattering) or its cosine. Out: the phase function of large particles or of dust, as in
//! shaders/lib/ring.

use std::sync::OnceLock;

/// Exponent of the power law (pi - phase angle)^n of large particles with mutual shadowing: Dones, Cuzzi and Showalter 1993 (Icarus 105, 184) for the A
/// ring.
pub(crate) const PHASE_EXPONENT: f64 = 3.09;
/// Amplitude and angular width (tangent of half the phase angle) of the opposition surge: the B ring brightens by 0.3 mag within half a degree in the phase
/// curves of Franklin and Cook 1965 (Astron. J. 70, 704).
pub(crate) const OPPOSITION_SURGE: [f64; 2] = [0.32, 0.0045];
/// Phase function of dust: asymmetry and weight of each Henyey-Greenstein lobe. Three lobes, as in the fit by Hedman and Stark 2015 (Astrophys. J. 811, 67) to
/// Saturn's G ring between 3 and 170 degrees of scattering angle; the numbers have not been checked against their table. All dust uses this phase
/// function, although the E ring's smaller grains scatter more widely. Within some 3 degrees of the Sun the E ring is therefore too bright, by an
/// estimated factor of up to 5.
pub(crate) const DUST_LOBES: [[f64; 2]; 3] = [[0.995, 0.643], [0.665, 0.176], [0.035, 0.181]];
pub use crate::scene::constants::MIN_COSINE;

/// The factor that normalises the power law to a mean of 1 over all directions.
pub(crate) fn power_law_factor() -> f64 {
    static FACTOR: OnceLock<f64> = OnceLock::new();
    *FACTOR.get_or_init(|| {
        const STEPS: u32 = 4096;
        let step = std::f64::consts::PI / f64::from(STEPS);
        // `theta`: pi minus the phase angle.
        let sum: f64 = (0..STEPS).map(|k| (f64::from(k) + 0.5) * step).map(|theta| theta.powf(PHASE_EXPONENT) * theta.sin()).sum();
        2.0 / (sum * step)
    })
}

/// Phase function of large particles without the opposition surge.
fn power_law_phase(alpha: f64) -> f64 {
    power_law_factor() * (std::f64::consts::PI - alpha).powf(PHASE_EXPONENT)
}

/// Phase function of dust, with a steep forward-scattering peak.
pub fn dust_phase(alpha: f64) -> f64 {
    phase_of_lobes(&DUST_LOBES, alpha)
}

/// Sum of Henyey-Greenstein phase functions, each given by its asymmetry and weight.
fn phase_of_lobes(lobes: &[[f64; 2]], alpha: f64) -> f64 {
    // 1 + g² + 2 g cos(alpha) = (1 - g)² + 4 g cos²(alpha / 2), a form without cancellation near forward scattering.
    let cos_half_sq = (0.5 * alpha).cos().powi(2);
    lobes.iter().map(|[g, weight]| weight * (1.0 - g * g) / ((1.0 - g).powi(2) + 4.0 * g * cos_half_sq).powf(1.5)).sum()
}

/// Phase function of large particles with the opposition surge, from the cosine of the phase angle.
pub fn large_particle_phase(cos_alpha: f64) -> f64 {
    let alpha = cos_alpha.clamp(-1.0, 1.0).acos();
    let [amplitude, width] = OPPOSITION_SURGE;
    power_law_phase(alpha) * (1.0 + amplitude / (1.0 + (0.5 * alpha).tan() / width))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Phase function of a mixture of large particles and dust, without the opposition surge.
    fn phase_function(alpha: f64, dust: f64) -> f64 {
        power_law_phase(alpha) * (1.0 - dust) + dust_phase(alpha) * dust
    }

    /// The mean over all directions. Steps are even in the logarithm of the angle from the Sun's direction, so that they resolve the narrowest lobe.
    fn mean(phase: impl Fn(f64) -> f64) -> f64 {
        let n = 200_000;
        let (first, last) = (1e-7_f64.ln(), std::f64::consts::PI.ln());
        let h = (last - first) / f64::from(n);
        (0..n).map(|k| (first + (f64::from(k) + 0.5) * h).exp()).map(|s| 0.5 * phase(std::f64::consts::PI - s) * s.sin() * s * h).sum()
    }

    #[test]
    fn the_phase_function_is_normalised() {
        for dust in [0.0, 0.3, 1.0] {
            let mean = mean(|alpha| phase_function(alpha, dust));
            assert!((mean - 1.0).abs() < 1e-5, "dust {dust}: {mean}");
        }
        // Negative control: with half the weight of the narrowest lobe, half of that lobe's light is missing from the mean.
        let mut lobes = DUST_LOBES;
        lobes[0][1] *= 0.5;
        let reduced = mean(|alpha| phase_of_lobes(&lobes, alpha));
        assert!((reduced - (1.0 - lobes[0][1])).abs() < 1e-5 && (reduced - 1.0).abs() > 0.1, "{reduced}");
        assert!((DUST_LOBES.iter().map(|l| l[1]).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// Large particles become fainter with the phase angle, down to zero. Dust is faintest at a middle phase angle and hundreds of times as bright near the
    /// Sun.
    #[test]
    fn large_particles_scatter_back_and_dust_forward() {
        let at = |deg: f64, dust: f64| phase_function(deg.to_radians(), dust);
        for k in 1..=179 {
            let (before, now) = (f64::from(k - 1), f64::from(k));
            assert!(at(now, 0.0) < at(before, 0.0), "large particles at {now}");
            assert!(now < 60.0 || at(now, 1.0) > at(before, 1.0), "dust at {now}");
            let ratio = at(now, 1.0) / at(before, 1.0);
            // The narrowest lobe varies as the inverse cube of the angle from the Sun: at half the angle it is 8 times as bright.
            assert!((0.9..8.0).contains(&ratio), "the dust's phase function jumps at {now}: {ratio}");
        }
        assert!(at(0.0, 0.0) > 4.0 && at(179.0, 0.0) < 1e-4);
        // In Voyager's images dust brightened by more than an order of magnitude from backward to forward scattering, unlike large particles.
        assert!(at(178.0, 1.0) / at(5.0, 1.0) > 100.0 && at(178.0, 0.01) > 1e3 * at(178.0, 0.0));
    }
}
