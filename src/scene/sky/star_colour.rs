//! The colour of a star from its colour index B-V.
//!
//! In: B-V. Out: linear sRGB of luminance 1, in which sunlight is white, as everywhere in the program. The star is drawn as the black body that has its
//! index, seen by the CIE 1931 observer. Left out: differences between a star's spectrum and that of a black body, such as the absorption bands of cool
//! stars. Indices outside `MIN_B_V..=MAX_B_V` are clamped. A star's own temperature differs from that of this black body: [`super::star_temperature`].

use crate::units::luminance;
use glam::{DMat3, DVec3};
use std::sync::LazyLock;

/// Colour indices of the table's ends, and the number of its steps, 0.05 each.
const MIN_B_V: f64 = -0.4;
const MAX_B_V: f64 = 2.4;
const STEPS: usize = 56;
/// Effective temperature of the Sun (IAU 2015 Resolution B3), kelvin.
const SUN_K: f64 = 5772.0;

/// Colours of stars, linear sRGB of luminance 1, at colour indices in even steps from [`MIN_B_V`] to [`MAX_B_V`].
static COLOURS: LazyLock<[DVec3; STEPS + 1]> = LazyLock::new(|| {
    let sun = linear_srgb(SUN_K);
    std::array::from_fn(|k| {
        let b_v = MIN_B_V + (MAX_B_V - MIN_B_V) * k as f64 / STEPS as f64;
        // Scaled so that the Sun is white.
        let colour = (linear_srgb(black_body_k(b_v)) / sun).max(DVec3::ZERO);
        colour / luminance(colour.to_array())
    })
});

/// Temperature in kelvin of the black body that has the colour index B-V (Ballesteros 2012, EPL 97, 34008, eq. 14).
pub(super) fn black_body_k(b_v: f64) -> f64 {
    4600.0 * (1.0 / (0.92 * b_v + 1.7) + 1.0 / (0.92 * b_v + 0.62))
}

/// Colour-matching functions of the CIE 1931 observer, approximated by the sums of Gaussians of Wyman, Sloan and Shirley 2013 (JCGT 2, 2, eq. 4).
fn colour_matching(nm: f64) -> DVec3 {
    let lobe = |height: f64, middle_nm: f64, width_below_nm: f64, width_above_nm: f64| {
        let x = (nm - middle_nm) / if nm < middle_nm { width_below_nm } else { width_above_nm };
        height * (-0.5 * x * x).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

/// CIE XYZ of a black body, in arbitrary units: Planck's law, summed in steps of 5 nm.
fn black_body_xyz(kelvin: f64) -> DVec3 {
    // Second radiation constant hc/k, nm K (CODATA 2018).
    const C2: f64 = 1.438_776_877e7;
    // The factor 600 only sets the arbitrary unit.
    (380..=780).step_by(5).map(f64::from).map(|nm| colour_matching(nm) * ((600.0 / nm).powi(5) / (C2 / (nm * kelvin)).exp_m1())).sum()
}

/// The colour of a black body in linear sRGB (IEC 61966-2-1), in the arbitrary units of [`black_body_xyz`].
fn linear_srgb(kelvin: f64) -> DVec3 {
    // Column by column.
    let rgb_from_xyz = DMat3::from_cols_array(&[3.2406, -0.9689, 0.0557, -1.5372, 1.8758, -0.2040, -0.4986, 0.0415, 1.0570]);
    rgb_from_xyz * black_body_xyz(kelvin)
}

/// Colour of a star: linear sRGB of luminance 1; white if its colour index is unknown.
pub(super) fn star_colour(b_v: Option<f32>) -> DVec3 {
    let Some(b_v) = b_v else { return DVec3::ONE };
    let position = (f64::from(b_v).clamp(MIN_B_V, MAX_B_V) - MIN_B_V) / (MAX_B_V - MIN_B_V) * STEPS as f64;
    let lower = (position as usize).min(STEPS - 1);
    COLOURS[lower].lerp(COLOURS[lower + 1], position - lower as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities of black bodies: CIE illuminant A (2856 K) and the Planckian locus at 6500 K and 10 000 K (CIE 15:2004).
    #[test]
    fn black_bodies_have_their_chromaticity() {
        for (kelvin, x, y) in [(2856.0, 0.447_57, 0.407_45), (6500.0, 0.313_5, 0.323_7), (10_000.0, 0.280_7, 0.288_4)] {
            let v = black_body_xyz(kelvin);
            let sum = v.element_sum();
            assert!((v.x / sum - x).abs() < 0.004 && (v.y / sum - y).abs() < 0.004, "{kelvin}: {} {}", v.x / sum, v.y / sum);
        }
    }

    /// A star with the Sun's index (0.653, Ramirez et al. 2012) is white, Rigel is bluer and Betelgeuse redder. A larger index is always redder, and the
    /// luminance is always 1, so that a star's brightness follows from its V magnitude alone.
    #[test]
    fn the_sun_is_white_and_colours_run_from_blue_to_red() {
        assert!((star_colour(Some(0.653)) - DVec3::ONE).abs().max_element() < 0.02, "{}", star_colour(Some(0.653)));
        // The colours are about (0.77, 1.01, 1.60) and (1.48, 0.92, 0.40).
        let (rigel, betelgeuse) = (star_colour(Some(-0.03)), star_colour(Some(1.85)));
        assert!(rigel.z > 1.2 && rigel.x < 0.9 && betelgeuse.x > 1.4 && betelgeuse.z < 0.45, "{rigel} {betelgeuse}");
        let ratio = |b_v: f32| star_colour(Some(b_v)).x / star_colour(Some(b_v)).z.max(1e-9);
        let mut last = 0.0;
        for k in 0..=28 {
            let b_v = -0.4 + 0.1 * k as f32;
            assert!(ratio(b_v) > last, "{b_v}");
            last = ratio(b_v);
            let colour = star_colour(Some(b_v));
            assert!((luminance(colour.to_array()) - 1.0).abs() < 1e-3 && colour.min_element() >= 0.0, "{b_v}: {colour}");
        }
        assert_eq!(star_colour(Some(99.0)), star_colour(Some(2.4)));
        assert_eq!(star_colour(None), DVec3::ONE);
    }
}
