//! Display levels (not mip levels) of linear light, and the differences of two linear images on a display.
//!
//! In: linear light and the exposure factor that converts it to display light, where 1 is white. Out: levels from 0 to 255, not rounded, so
//! that errors below a level can be distinguished. Always: light above white counts as white; a pixel that is finite in only one of two
//! images counts as a difference of 255. Alpha is not compared.

use crate::units::linear_to_srgb;

/// The level of white, the largest of an 8-bit display.
pub(super) const MAX_LEVEL: f64 = 255.0;

/// A linear image, and the factor from its light to display light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExposedPixels<'a> {
    /// Red, green and blue, and the coverage, which is not compared. A pixel is finite if all four are.
    pub light: &'a [[f32; 4]],
    /// Factor from light to display light, where 1 is white.
    pub exposure_factor: f64,
}

/// The display level of linear light.
pub(crate) fn display_level(light: f32, exposure_factor: f64) -> f64 {
    MAX_LEVEL * linear_to_srgb((f64::from(light) * exposure_factor).clamp(0.0, 1.0))
}

/// For each pixel, the greatest difference of red, green or blue, in display levels.
pub(crate) fn level_differences(a: ExposedPixels<'_>, b: ExposedPixels<'_>) -> Vec<f64> {
    let is_finite = |pixel: &[f32; 4]| pixel.iter().all(|v| v.is_finite());
    let difference = |(pixel_a, pixel_b): (&[f32; 4], &[f32; 4])| {
        if is_finite(pixel_a) != is_finite(pixel_b) {
            return MAX_LEVEL;
        }
        let channel = |c: usize| (display_level(pixel_a[c], a.exposure_factor) - display_level(pixel_b[c], b.exposure_factor)).abs();
        (0..3).map(channel).fold(0.0, f64::max)
    };
    a.light.iter().zip(b.light).map(difference).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If not handled separately, a NaN would count as no difference, because `f64::max` ignores it.
    #[test]
    fn a_value_that_is_finite_in_only_one_image_is_a_difference() {
        let grey = [[0.2, 0.2, 0.2, 1.0]];
        fn exposed(light: &[[f32; 4]]) -> ExposedPixels<'_> {
            ExposedPixels { light, exposure_factor: 1.0 }
        }
        assert_eq!(level_differences(exposed(&grey), exposed(&grey)), [0.0]);
        for broken in [f32::NAN, f32::INFINITY] {
            let broken = [[0.2, broken, 0.2, 1.0]];
            assert_eq!(level_differences(exposed(&grey), exposed(&broken)), [255.0]);
            assert_eq!(level_differences(exposed(&broken), exposed(&grey)), [255.0]);
        }
    }

    #[test]
    fn levels_follow_the_display_encoding_and_end_at_white() {
        let exposed = |light, exposure_factor| ExposedPixels { light, exposure_factor };
        let (black, bright) = ([[0.0, 0.0, 0.0, 1.0]; 2], [[0.0, 0.0, 0.0, 1.0], [0.0, 3.0, 0.0, 1.0]]);
        let differences = level_differences(exposed(&black, 1.0), exposed(&bright, 1.0));
        assert!(differences[0] == 0.0 && (differences[1] - 255.0).abs() < 1e-9, "{differences:?}");
        assert_eq!(level_differences(exposed(&black, 1.0), exposed(&bright, 0.0)), [0.0, 0.0]);
        // IEC 61966-2-1: a linear 0.5 is 187.5 of 255.
        assert!((display_level(0.5, 1.0) - 187.5).abs() < 0.05 && (display_level(0.25, 2.0) - 187.5).abs() < 0.05);
    }
}
