//! The effective temperature of a star from its colour index B-V.
//!
//! In: B-V. Out: kelvin, never rising with B-V. Three sources, because none holds for all stars:
//! - bluer than -0.05, mean values of main-sequence stars ([`HOT_DWARFS`]), interpolated;
//! - from there to [`MAX_B_V_OF_FIT`], the fit of Flower to main-sequence stars, subgiants and giants ([`FLOWER`]), which differs from the mean values of
//!   Mamajek's table by 3 % at most between B-V = -0.05 and 1.15;
//! - redder than that, the black body with this index, because the fit falls too steeply: to 2900 K at 1.8 and to 1200 K at 2.0.
//!
//! Indices outside -0.33..=2.4 are clamped: bluer ones are errors of measurement, and stars redder than 2.4 owe their colour to dust or to bands of carbon.
//! Errors: all stars from O3 to B0 (46 000 K to 31 000 K) lie within 0.03 magnitudes, so that an error of 0.01 changes the temperature by up to 22 %.
//! Interstellar dust reddens most hot stars in the catalog, which then seem too cool (Zeta Orionis: -0.20, 18 700 K here, about 29 500 K by its spectrum).
//! Red giants and red dwarfs of one index differ by up to 15 %; the fit is right for giants, and the built-in catalog has only one red dwarf, of type M0. Red
//! supergiants such as Betelgeuse seem 8 % too cool.
//!
//! The colours that are drawn follow from the black body with the star's index (`star_colour`), not from this temperature: a black body as hot as an O star
//! would be bluer than the star.

use super::star_colour::black_body_k;

/// B-V and effective temperature, kelvin, of main-sequence stars from O3 to B9.5: E. Mamajek, "A Modern Mean Dwarf Stellar Color and Effective Temperature
/// Sequence", version 2024.05.15 (github.com/emamajek/SpectralType), the continuation of Pecaut & Mamajek 2013, ApJS 208, 9, table 5. The rows O3, O4, O5, O7,
/// O9, B0, B0.5, B1, B1.5, B2, B2.5, B3, B5, B6, B7, B8, B9, B9.5.
// The index of O7 V resembles 1/pi.
#[expect(clippy::approx_constant)]
const HOT_DWARFS: [(f64, f64); 18] = [
    (-0.330, 45_900.0),
    (-0.326, 42_900.0),
    (-0.323, 41_400.0),
    (-0.318, 37_900.0),
    (-0.312, 33_300.0),
    (-0.301, 31_400.0),
    (-0.289, 29_000.0),
    (-0.278, 26_000.0),
    (-0.252, 24_500.0),
    (-0.215, 20_600.0),
    (-0.198, 18_500.0),
    (-0.178, 17_000.0),
    (-0.156, 15_700.0),
    (-0.140, 14_500.0),
    (-0.128, 14_000.0),
    (-0.109, 12_300.0),
    (-0.070, 10_700.0),
    (-0.050, 10_400.0),
];

/// Coefficients of powers of B-V in the decimal logarithm of the temperature: Flower 1996, ApJ 469, 355, as corrected by Torres 2010, AJ 140, 1158, table 2.
/// For main-sequence stars, subgiants and giants.
const FLOWER: [f64; 8] = [
    3.979_145_106_714_099,
    -0.654_992_268_598_245,
    1.740_690_042_385_095,
    -4.608_815_154_057_166,
    6.792_599_779_944_473,
    -5.396_909_891_322_525,
    2.192_970_376_522_49,
    -0.359_495_739_295_671,
];
/// Largest index for the fit. Here it meets the black body: both give 3547 K to within 1 K.
const MAX_B_V_OF_FIT: f64 = 1.676;
/// Largest index for which a temperature is computed; the same limit as for the colours.
const MAX_B_V: f64 = 2.4;

/// Effective temperature in kelvin that stars of this colour index have on average. The module's comment states its errors.
pub fn temperature_k(b_v: f64) -> f64 {
    let b_v = b_v.clamp(HOT_DWARFS[0].0, MAX_B_V);
    if let Some([(bluer, bluer_k), (redder, redder_k)]) = HOT_DWARFS.array_windows::<2>().find(|[_, (redder, _)]| b_v < *redder) {
        return bluer_k + (redder_k - bluer_k) * (b_v - bluer) / (redder - bluer);
    }
    if b_v < MAX_B_V_OF_FIT { 10_f64.powf(FLOWER.iter().rev().fold(0.0, |sum, c| sum * b_v + c)) } else { black_body_k(b_v) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::stars::StarCatalog;

    /// Published temperatures: the Sun (IAU 2015 Resolution B3; B-V of Ramirez et al. 2012), Vega (Kinman & Castelli 2002), Arcturus (Ramirez & Allende Prieto
    /// 2011), Aldebaran (Heiter et al. 2015), Betelgeuse (Levesque & Massey 2020); spectral types: the table that [`HOT_DWARFS`] is from. The tolerances are
    /// above 200 K only for red dwarfs and Betelgeuse, whose errors the module's comment states.
    #[test]
    fn well_known_stars_have_their_temperature() {
        for (name, b_v, published_k, tolerance_k) in [
            ("Sun", 0.653, 5_772.0, 150.0),
            ("Vega", -0.001, 9_602.0, 200.0),
            ("B0 V", -0.301, 31_400.0, 100.0),
            ("O5 V", -0.323, 41_400.0, 100.0),
            ("B3 V", -0.178, 17_000.0, 100.0),
            ("F0 V", 0.295, 7_220.0, 100.0),
            ("K0 V", 0.816, 5_290.0, 100.0),
            ("Arcturus", 1.239, 4_286.0, 150.0),
            ("Aldebaran", 1.538, 3_927.0, 100.0),
            ("M0 V", 1.42, 3_850.0, 300.0),
            ("M4 V", 1.65, 3_210.0, 450.0),
            ("M5 V", 1.83, 3_060.0, 350.0),
            ("Betelgeuse", 1.85, 3_600.0, 300.0),
        ] {
            let kelvin = temperature_k(b_v);
            assert!((kelvin - published_k).abs() <= tolerance_k, "{name}: {kelvin:.0} K, published {published_k} K");
        }
    }

    /// Indices bluer than the table's are clamped to its first, that of an O3 star.
    #[test]
    fn the_bluest_stars_are_limited_to_the_hottest_of_the_table() {
        for b_v in [-0.33, -0.4, -5.0, f64::NEG_INFINITY] {
            assert!((41_000.0..=46_000.0).contains(&temperature_k(b_v)), "{b_v}: {}", temperature_k(b_v));
        }
    }

    /// For the indices of the built-in catalog, and for any that a user's catalog may have: in steps of 0.01, and of 0.001 where two sources meet.
    #[test]
    fn a_redder_star_is_never_hotter() {
        let stars = StarCatalog::embedded();
        let mut indices: Vec<f64> = stars.stars().iter().filter_map(|s| s.b_v).map(f64::from).collect();
        indices.extend((-500..=1500).map(|k| 0.01 * f64::from(k)));
        indices.extend((-60..=300).map(|k| 0.001 * f64::from(k)).chain((1650..=1700).map(|k| 0.001 * f64::from(k))));
        indices.sort_by(f64::total_cmp);
        for pair in indices.windows(2) {
            let (bluer, redder) = (temperature_k(pair[0]), temperature_k(pair[1]));
            // The ranges overlap: the same index, computed in two ways, may differ in its last digits, and with it the temperature.
            assert!(redder <= bluer + 1e-6 && redder > 2_500.0, "{pair:?}: {bluer} K, {redder} K");
            // No jump where one source meets the next: over a step of 0.001, from -0.05 on, the temperature falls by less than 30 K.
            assert!(pair[1] - pair[0] > 0.0011 || pair[0] < -0.05 || bluer - redder < 30.0, "{pair:?}: {bluer} K, {redder} K");
        }
    }
}
