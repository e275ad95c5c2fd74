//! Conversion of an image's values to colours: two percentiles select the values that become 0 (black) and 1 (white), a curve (stretch) bends the values
//! between them, and a colour map gives the colours.
//!
//! In: values, some of which may be NaN or infinite. Out: sRGB with alpha (255 where the value is finite, 0 elsewhere), or `None` if no value is finite. Not
//! here: [`ImageStyle::opacity`], which is applied when the image is drawn.

/// How the values of an image are converted to colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageStyle {
    /// The curve that bends the values between black and white.
    pub stretch: Stretch,
    /// The percentiles of the finite values that become black (first) and white (second), or the first and the last colour of the map; 0 to 100.
    pub percentiles: [f64; 2],
    /// The colours of the stretched values.
    pub colour_map: ColourMap,
    /// Opacity, 0 to 1.
    pub opacity: f64,
}

impl Default for ImageStyle {
    fn default() -> Self {
        Self { stretch: Stretch::Linear, percentiles: [0.5, 99.5], colour_map: ColourMap::Grey, opacity: 1.0 }
    }
}

/// An increasing curve that maps [0, 1] to [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stretch {
    /// Linear.
    Linear,
    /// Square root.
    Sqrt,
    /// Inverse hyperbolic sine, asinh(10 x) / asinh(10): nearly linear far below a tenth, logarithmic far above (Lupton et al. 2004).
    Asinh,
    /// ln(1 + 999 x) / ln 1000: 1 + 999 x runs over three decades, from 1 to 1000.
    Log,
}

/// Colours of the values from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// Black to white.
    Grey,
    /// Dark violet to yellow, perceptually uniform (van der Walt & Smith 2015).
    Viridis,
    /// Black, red, yellow, white.
    Heat,
}

impl Stretch {
    /// The curve's value at `x`, which is clamped to [0, 1].
    pub fn apply(self, x: f64) -> f64 {
        let x = x.clamp(0.0, 1.0);
        match self {
            Self::Linear => x,
            Self::Sqrt => x.sqrt(),
            Self::Asinh => (10.0 * x).asinh() / 10_f64.asinh(),
            Self::Log => (1.0 + 999.0 * x).ln() / 1000_f64.ln(),
        }
    }
}

/// Viridis as a polynomial: one row per power of the value from 0 to 6, with red, green and blue. Matt Zucker's fit (Shadertoy
/// WlfXRN, CC0) to the table of van der Walt & Smith, within 0.02.
const VIRIDIS: [[f64; 3]; 7] = [
    [0.277_727, 0.005_407, 0.334_100],
    [0.105_093, 1.404_614, 1.384_590],
    [-0.330_862, 0.214_848, 0.095_095],
    [-4.634_230, -5.799_101, -19.332_441],
    [6.228_270, 14.179_933, 56.690_553],
    [4.776_385, -13.745_145, -65.353_033],
    [-5.435_456, 4.645_853, 26.312_435],
];

impl ColourMap {
    /// sRGB of a value from 0 to 1.
    pub fn colour_at(self, x: f64) -> [u8; 3] {
        let byte = |v: f64| (255.0 * v.clamp(0.0, 1.0)).round() as u8;
        match self {
            Self::Grey => [byte(x); 3],
            Self::Viridis => [0, 1, 2].map(|channel| byte(VIRIDIS.iter().rev().fold(0.0, |sum, row| sum * x + row[channel]))),
            // Red rises in the first third of the range, green in the second, blue in the last.
            Self::Heat => [0.0, 1.0, 2.0].map(|start| byte(3.0 * x - start)),
        }
    }
}

/// The values at the percentiles of the finite values, which become black and white. `None` if none is finite.
fn black_and_white(values: &[f32], percentiles: [f64; 2]) -> Option<[f64; 2]> {
    let mut finite: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let last = finite.len().checked_sub(1)?;
    let [black, white] = percentiles.map(|percentile| {
        let index = ((percentile / 100.0 * last as f64).round() as usize).min(last);
        let (_, value, _) = finite.select_nth_unstable_by(index, f32::total_cmp);
        f64::from(*value)
    });
    Some([black, white])
}

/// Largest index of the table of colours, which saves a colour map's arithmetic per value. About four steps are one 8-bit level.
const TABLE_STEPS: u32 = 1023;

/// The colours of an image, four bytes (red, green, blue, alpha) per value; `None` if no value is finite.
pub(super) fn colours(values: &[f32], style: &ImageStyle) -> Option<Vec<u8>> {
    let [black, white] = black_and_white(values, style.percentiles)?;
    // If all values are equal, all are black.
    let scale = if white > black { 1.0 / (white - black) } else { 0.0 };
    let table: Vec<[u8; 3]> = (0..=TABLE_STEPS).map(|k| style.colour_map.colour_at(f64::from(k) / f64::from(TABLE_STEPS))).collect();
    let colour = |v: &f32| {
        if !v.is_finite() {
            return [0; 4];
        }
        let [r, g, b] = table[(f64::from(TABLE_STEPS) * style.stretch.apply((f64::from(*v) - black) * scale)).round() as usize];
        [r, g, b, 255]
    };
    Some(values.iter().flat_map(colour).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretch_curves_rise_from_0_to_1() {
        for stretch in [Stretch::Linear, Stretch::Sqrt, Stretch::Asinh, Stretch::Log] {
            assert!(stretch.apply(0.0).abs() < 1e-12 && (stretch.apply(1.0) - 1.0).abs() < 1e-12, "{stretch:?}");
            assert!((0..1000).all(|k| stretch.apply(f64::from(k) / 1000.0) < stretch.apply(f64::from(k + 1) / 1000.0)), "{stretch:?}");
            assert_eq!(stretch.apply(f64::INFINITY), stretch.apply(1.0));
        }
        // Computed by hand: the square root of 1/4 is 1/2; 99/999 is two of the logarithm's three decades; asinh makes 0.01 more than three times as bright.
        assert_eq!(Stretch::Sqrt.apply(0.25), 0.5);
        assert!((Stretch::Log.apply(99.0 / 999.0) - 2.0 / 3.0).abs() < 1e-12);
        assert!(Stretch::Asinh.apply(0.01) > 3.0 * 0.01);
    }

    #[test]
    fn colour_maps_grow_lighter() {
        for map in [ColourMap::Grey, ColourMap::Viridis, ColourMap::Heat] {
            let luma = |k: u32| {
                let c = map.colour_at(f64::from(k) / 100.0).map(f64::from);
                crate::units::luminance(c.map(|v| crate::units::srgb_to_linear(v / 255.0)))
            };
            assert!((0..100).all(|k| luma(k + 1) >= luma(k)), "{map:?}");
            // Viridis rises from 0.02 to 0.78, the others from 0 to 1.
            assert!(luma(100) > 0.7 && luma(0) < 0.03, "{map:?}");
        }
        // The polynomial is within 0.02 of the table, 5 of 255 levels. Start, middle and end of the table as published:
        // (0.267, 0.005, 0.329), (0.128, 0.567, 0.551), (0.993, 0.906, 0.144).
        for (x, expected) in [(0.0, [68, 1, 84]), (0.5, [33, 145, 140]), (1.0, [253, 231, 37])] {
            let found = ColourMap::Viridis.colour_at(x);
            assert!((0..3).all(|c| found[c].abs_diff(expected[c]) < 8), "{x}: {found:?}");
        }
    }

    #[test]
    fn black_and_white_are_percentiles_of_finite_values() {
        let mut values: Vec<f32> = (0..=1000).map(|k| k as f32).collect();
        values.extend([f32::NAN, f32::INFINITY]);
        assert_eq!(black_and_white(&values, [1.0, 99.0]), Some([10.0, 990.0]));
        assert_eq!(black_and_white(&[f32::NAN], [0.0, 100.0]), None);
        let style = ImageStyle { percentiles: [0.0, 100.0], ..ImageStyle::default() };
        assert_eq!(
            colours(&[0.0, 5.0, 10.0, f32::NAN], &style),
            Some(vec![0, 0, 0, 255, 128, 128, 128, 255, 255, 255, 255, 255, 0, 0, 0, 0])
        );
        assert_eq!(colours(&[3.0; 2], &style), Some(vec![0, 0, 0, 255, 0, 0, 0, 255]));
    }
}
