//! The difference of two images in display levels (0 to 255).
//!
//! In: two images of one size as 8-bit RGBA rows. Out: a [`Difference`] over every red, green and blue value (and alpha if either image is
//! not opaque), and an image of the differences. Differences are of encoded values, which are roughly perceptually uniform; nothing
//! is aligned, scaled or filtered.

use super::levels::MAX_LEVEL;
use super::{ImageError, decode_rgba8};

/// Statistics of absolute differences, in display levels (0 to 255).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Mean over all compared values.
    pub mean: f64,
    /// 99.9 % of the values differ by this or less.
    pub p999: u8,
    /// The largest difference.
    pub max: u8,
    /// Peak signal-to-noise ratio; `None` (infinite) for equal images.
    pub psnr_db: Option<f64>,
    /// Number of pixels of each image.
    pub pixels: u64,
}

/// 8-bit RGBA rows, top first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayImage {
    pub width: u32,
    pub height: u32,
    pub rgba: Vec<[u8; 4]>,
}

impl DisplayImage {
    /// Reads an encoded PNG or JPEG; `name` is for the error.
    pub fn decode(name: &str, encoded: &[u8], max_megapixels: u32) -> Result<Self, ImageError> {
        let max_side = u32::MAX;
        let rgba = decode_rgba8(name, encoded, max_megapixels, max_side)?;
        Ok(Self { width: rgba.width(), height: rgba.height(), rgba: rgba.pixels().map(|p| p.0).collect() })
    }

    fn has_alpha(&self) -> bool {
        self.rgba.iter().any(|p| p[3] != u8::MAX)
    }

    /// Checks that both images have the same size, and as many pixels as their size states, at least one.
    fn check_comparable(&self, other: &Self) -> Result<(), ImageError> {
        if (self.width, self.height) != (other.width, other.height) {
            let (a, b) = ((self.width, self.height), (other.width, other.height));
            return Err(ImageError::DifferentSizes { a, b });
        }
        let has_all_pixels =
            |image: &&Self| u64::from(image.width) * u64::from(image.height) == image.rgba.len() as u64 && !image.rgba.is_empty();
        match [self, other].into_iter().find(|image| !has_all_pixels(image)) {
            None => Ok(()),
            Some(Self { width, height, rgba }) => {
                Err(ImageError::WrongLength { width: *width, height: *height, given_bytes: rgba.len().saturating_mul(4) })
            }
        }
    }

    /// The difference of `other` from this image.
    ///
    /// # Errors
    /// Different sizes, or an image without all of its pixels.
    pub fn difference(&self, other: &Self) -> Result<Difference, ImageError> {
        self.check_comparable(other)?;
        let channels = if self.has_alpha() || other.has_alpha() { 4 } else { 3 };
        let mut level_counts = [0_u64; 256];
        for (p, q) in self.rgba.iter().zip(&other.rgba) {
            for c in 0..channels {
                level_counts[usize::from(p[c].abs_diff(q[c]))] += 1;
            }
        }
        let value_count: u64 = level_counts.iter().sum();
        // The mean of the differences raised to `power`.
        let moment =
            |power: i32| (0_u8..=255).zip(level_counts).map(|(d, n)| f64::from(d).powi(power) * n as f64).sum::<f64>() / value_count as f64;
        let mean_square = moment(2);
        Ok(Difference {
            mean: moment(1),
            p999: level_not_exceeded(&level_counts, value_count - value_count / 1000),
            max: level_not_exceeded(&level_counts, value_count),
            psnr_db: (mean_square > 0.0).then(|| 10.0 * (MAX_LEVEL * MAX_LEVEL / mean_square).log10()),
            pixels: self.rgba.len() as u64,
        })
    }

    /// The fraction of pixels whose red, green and blue differ by at most the values of the same pixel in `tolerances`.
    ///
    /// # Errors
    /// Different sizes, or an image without all of its pixels.
    pub(crate) fn fraction_within(&self, other: &Self, tolerances: &Self) -> Result<f64, ImageError> {
        self.check_comparable(other)?;
        self.check_comparable(tolerances)?;
        let is_within = |((p, q), max): &((&[u8; 4], &[u8; 4]), &[u8; 4])| (0..3).all(|c| p[c].abs_diff(q[c]) <= max[c]);
        let within = self.rgba.iter().zip(&other.rgba).zip(&tolerances.rgba).filter(is_within).count();
        Ok(within as f64 / self.rgba.len() as f64)
    }

    /// The absolute differences of red, green and blue, scaled so that the largest of them becomes 255; opaque, and black for equal images.
    ///
    /// # Errors
    /// Different sizes, or an image without all of its pixels.
    pub fn difference_image(&self, other: &Self) -> Result<Self, ImageError> {
        self.check_comparable(other)?;
        let differences = || self.rgba.iter().zip(&other.rgba).map(|(p, q)| [0, 1, 2].map(|c| p[c].abs_diff(q[c])));
        let largest = u32::from(differences().flatten().max().unwrap_or(0).max(1));
        let pixel = |difference: [u8; 3]| {
            let [r, g, b] = difference.map(|d| (u32::from(d) * 255 / largest) as u8);
            [r, g, b, u8::MAX]
        };
        Ok(Self { rgba: differences().map(pixel).collect(), ..*self })
    }
}

/// The smallest difference, in display levels, that at least `min_count` values do not exceed. `level_counts`: number of values by their difference.
fn level_not_exceeded(level_counts: &[u64; 256], min_count: u64) -> u8 {
    let mut counted = 0;
    for (level, n) in (0..=u8::MAX).zip(level_counts) {
        counted += n;
        if counted >= min_count {
            return level;
        }
    }
    u8::MAX
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, value: impl Fn(usize) -> u8) -> DisplayImage {
        let rgba = (0..(width * height) as usize).map(|i| [value(i), value(i), value(i), 255]).collect();
        DisplayImage { width, height, rgba }
    }

    #[test]
    fn statistics_agree_with_a_calculation_by_hand() {
        // One pixel of 1000 differs by 51, a fifth of the scale: mean 0.051, mean square 2.601, PSNR 10 log10(65025 / 2.601) = 43.979 dB.
        let a = image(40, 25, |_| 10);
        let d = a.difference(&image(40, 25, |i| if i == 7 { 61 } else { 10 })).expect("one size");
        assert!((d.mean - 0.051).abs() < 1e-12 && d.max == 51 && d.pixels == 1000, "{d:?}");
        assert_eq!(d.p999, 0, "999 of 1000 do not differ");
        assert!((d.psnr_db.expect("finite") - 43.979_4).abs() < 1e-3, "{d:?}");
        let two = a.difference(&image(40, 25, |i| if i < 2 { 61 } else { 10 })).expect("one size");
        assert_eq!(two.p999, 51, "two of 1000 are more than one in a thousand");
    }

    #[test]
    fn equal_images_have_no_psnr_and_differences_are_symmetric() {
        let (a, b) = (image(9, 7, |i| i as u8), image(9, 7, |i| 255 - i as u8));
        let same = a.difference(&a).expect("one size");
        assert!(same.mean == 0.0 && same.max == 0 && same.psnr_db.is_none());
        assert_eq!(a.difference(&b).expect("one size"), b.difference(&a).expect("one size"));
        assert_eq!(image(2, 2, |_| 0).difference(&image(2, 2, |_| 255)).expect("one size").psnr_db, Some(0.0));
    }

    #[test]
    fn a_pixel_is_within_its_tolerance_if_no_channel_exceeds_it() {
        let (a, b) = (image(10, 10, |_| 10), image(10, 10, |i| if i < 3 { 14 } else { 11 }));
        assert_eq!(a.fraction_within(&b, &image(10, 10, |_| 1)).expect("one size"), 0.97);
        assert_eq!(a.fraction_within(&b, &image(10, 10, |_| 4)).expect("one size"), 1.0);
        assert_eq!(a.fraction_within(&b, &image(10, 10, |_| 0)).expect("one size"), 0.0);
        assert!(a.fraction_within(&b, &image(5, 20, |_| 4)).is_err());
    }

    #[test]
    fn alpha_is_compared_if_either_image_is_not_opaque() {
        let opaque = image(2, 2, |_| 100);
        let mut clear = opaque.clone();
        clear.rgba[0][3] = 0;
        let d = opaque.difference(&clear).expect("one size");
        assert!(d.max == 255 && (d.mean - 255.0 / 16.0).abs() < 1e-12, "{d:?}");
        // The image of the differences shows no alpha, so alpha does not scale it.
        clear.rgba[1] = [102, 101, 100, 255];
        assert_eq!(opaque.difference_image(&clear).expect("one size").rgba[..2], [[0, 0, 0, 255], [255, 127, 0, 255]]);
    }

    #[test]
    fn the_image_of_differences_is_scaled_to_255_and_sizes_must_agree() {
        let shown = image(3, 1, |_| 9).difference_image(&image(3, 1, |i| 9 + 2 * i as u8)).expect("one size");
        assert_eq!(shown.rgba, [[0, 0, 0, 255], [127, 127, 127, 255], [255, 255, 255, 255]]);
        let error = image(3, 1, |_| 0).difference(&image(1, 3, |_| 0)).expect_err("sizes").to_string();
        assert!(error.contains("3x1") && error.contains("1x3"), "{error}");
        assert!(image(0, 0, |_| 0).difference(&image(0, 0, |_| 0)).is_err());
        // The error has the length of the image that lacks pixels, whichever it is.
        let (whole, mut truncated) = (image(3, 1, |_| 0), image(3, 1, |_| 0));
        truncated.rgba.pop();
        for (a, b) in [(&whole, &truncated), (&truncated, &whole)] {
            let error = a.difference_image(b).expect_err("length").to_string();
            assert_eq!(error, "8 bytes are not an image of 3x1 texels");
        }
    }
}
