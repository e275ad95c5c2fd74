//! A filter for rows near the poles of an equirectangular map: it makes their detail as coarse in longitude as in latitude.
//!
//! A texel row at latitude phi is cos phi times as long as the equator's but has as many texels. Fine structure in such rows (grain, JPEG
//! blocks, brush strokes, slopes along the rows) is narrow in longitude and long in latitude: on the sphere it forms a star of streaks around
//! the pole. A function that is smooth at the pole has no such structure: the closer a row is to the pole, the fewer waves the function has
//! along it.
//!
//! In: linear texels of one level. Out: each row beyond 45 degrees, averaged along its circle by a Gaussian of sigma = 0.6 sqrt(tan² phi - 1) texels.
//! The finest spot of a map is assumed to have, before the filter, a sigma of 0.6 texels in both directions. The filter makes it 0.6 tan phi texels along the
//! row (squares of sigmas add), which is 0.6 sin phi of the equator's texels. So the spot is 1 / sin phi times as long as it is wide: sqrt 2 at 45 degrees, 1
//! at the poles. Always: each row keeps its mean, and rows within 45 degrees of the equator keep their texels. The rows next to the poles keep half of the
//! first harmonic in longitude (sigma is 1.2 radians there: exp(-1.2² / 2) = 0.49) and little of the higher ones. Detail finer than the Gaussian of its row is
//! lost; streaks that the surface itself has remain if they are wider than the Gaussian.
//!
//! The directions east and north rotate with the meridian, so slopes (the east and north components of normals) are averaged as vectors in one
//! frame at the pole. In this frame, the slopes of a cone around the pole cancel out over the full circle. Every mip level is filtered again:
//! halving alone would leave a level finer in longitude than in latitude.

use std::f64::consts::{PI, TAU};

/// How the rows near the poles of an image are filtered, by the meaning of its texels; `PoleRowFilter` does it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PoleFilter {
    /// No poles: the image is not equirectangular over the whole sphere.
    #[default]
    None,
    /// Colours or scalars.
    Values,
    /// Normals: their components to the east (red), to the north (green) and outward (blue), -1 to 1 stored as 0 to 1.
    Normals,
}

/// Value of a slope channel for zero slope: byte value 127.5.
const NO_SLOPE: f32 = 0.5;
/// The finest detail of a map, as the sigma of a Gaussian in texels.
const DETAIL_TEXELS: f64 = 0.6;

/// Sigma of the filter in texels for a row at latitude `lat` (radians), as the module's head states it. It is smaller if `finer_is_filtered`: if the level was
/// computed from a filtered finer level.
fn sigma_texels(lat: f64, finer_is_filtered: bool) -> f64 {
    let excess = (lat.tan().powi(2) - 1.0).max(0.0);
    // The filter of the finer level already contributes a quarter of the variance, because its texels are half as long; variances of Gaussians add.
    DETAIL_TEXELS * (excess * if finer_is_filtered { 0.75 } else { 1.0 }).sqrt()
}

/// Latitude of a row's centre, radians.
fn latitude(row: usize, height: usize) -> f64 {
    (0.5 - (row as f64 + 0.5) / height as f64) * PI
}

/// The filter of the rows of one level.
pub(super) struct PoleRowFilter {
    poles: PoleFilter,
    height: usize,
    /// Whether the level was computed from a filtered finer level.
    finer_is_filtered: bool,
    /// Sine and cosine of each column's longitude from the map's left edge; empty unless normals are filtered, so that only their texels are rotated.
    longitude_sin_cos: Vec<[f32; 2]>,
}

impl PoleRowFilter {
    /// The filter of a level of this size.
    pub(crate) fn of(poles: PoleFilter, width: usize, height: usize, finer_is_filtered: bool) -> Self {
        let longitude = |x: usize| (x as f64 + 0.5) / width as f64 * TAU;
        let sin_cos = (0..width).map(|x| [longitude(x).sin() as f32, longitude(x).cos() as f32]);
        let longitude_sin_cos = if poles == PoleFilter::Normals { sin_cos.collect() } else { Vec::new() };
        Self { poles, height, finer_is_filtered, longitude_sin_cos }
    }

    /// Sigma of a row in texels; 0 if the filter keeps the row.
    fn sigma(&self, row: usize) -> f64 {
        if self.poles == PoleFilter::None { 0.0 } else { sigma_texels(latitude(row, self.height), self.finer_is_filtered) }
    }

    /// Whether the filter changes a row.
    pub(crate) fn changes(&self, row: usize) -> bool {
        self.sigma(row) > 0.0
    }

    /// Filters one row in place; texels are linear RGBA, starting at the left edge. `sums`: scratch memory, reused from row to row.
    pub(crate) fn smooth(&self, row: usize, texels: &mut [[f32; 4]], sums: &mut PrefixSums) {
        let sigma = self.sigma(row);
        if sigma <= 0.0 || texels.is_empty() {
            return;
        }
        // In the frame at the pole, x points away from the pole along the meridian of the map's left edge, and y to the east of this meridian. North points
        // towards the north pole, but away from the south pole.
        let away_per_north = if 2 * row < self.height { -1.0 } else { 1.0 };
        for (t, [sine, cosine]) in texels.iter_mut().zip(&self.longitude_sin_cos) {
            let (east, away) = (t[0] - NO_SLOPE, (t[1] - NO_SLOPE) * away_per_north);
            (t[0], t[1]) = (away * cosine - east * sine, east * cosine + away * sine);
        }
        gaussian(texels, sigma, sums);
        for (t, [sine, cosine]) in texels.iter_mut().zip(&self.longitude_sin_cos) {
            let (x, y) = (t[0], t[1]);
            (t[0], t[1]) = (NO_SLOPE + y * cosine - x * sine, NO_SLOPE + (x * cosine + y * sine) * away_per_north);
        }
    }
}

/// Scratch memory: prefix sums of a row's texels.
pub(super) type PrefixSums = Vec<[f64; 4]>;

/// A Gaussian filter along the circle of a row, whose last texel adjoins the first. It is approximated by three box filters of equal length, whose variances
/// add up to sigma². If a box is as long as the circle or longer, each texel becomes the mean of the circle.
fn gaussian(texels: &mut [[f32; 4]], sigma: f64, sums: &mut PrefixSums) {
    let count = texels.len();
    let filter = BoxFilter::with_variance(sigma * sigma / 3.0);
    if filter.length >= count as f64 {
        let mut sum = [0.0_f64; 4];
        for t in texels.iter() {
            for (sum, v) in sum.iter_mut().zip(t) {
                *sum += f64::from(*v);
            }
        }
        texels.fill(sum.map(|s| (s / count as f64) as f32));
        return;
    }
    sums.resize(sums.len().max(count + 2 * filter.whole + 3), [0.0; 4]);
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: AVX2 was detected.
        return unsafe { filter.average_avx2(texels, sums) };
    }
    filter.average(texels, sums);
}

/// A box filter of a length that need not be a whole number of texels.
struct BoxFilter {
    /// Number of texels with full weight on either side of the middle.
    whole: usize,
    /// Weight of the next texel on either side.
    end_weight: f64,
    /// Length of the box in texels, the sum of all weights.
    length: f64,
}

impl BoxFilter {
    /// The box with this variance, in squared texels. With `whole` texels on both sides of its middle and no others, a box has the variance
    /// whole (whole + 1) / 3; the largest such box not above the variance is taken. The end weight adds the rest; it solves
    /// (whole (whole + 1) (2 whole + 1) / 3 + 2 end_weight (whole + 1)²) / (2 whole + 1 + 2 end_weight) = variance.
    fn with_variance(variance: f64) -> Self {
        let whole = (((1.0 + 12.0 * variance).sqrt() - 1.0) / 2.0).floor();
        let end_weight = (variance * (2.0 * whole + 1.0) - whole * (whole + 1.0) * (2.0 * whole + 1.0) / 3.0)
            / (2.0 * ((whole + 1.0).powi(2) - variance));
        Self { whole: whole as usize, end_weight, length: 2.0 * (whole + end_weight) + 1.0 }
    }

    /// Applies the filter three times around the circle. `sums` holds at least count + 2 whole + 3 values.
    #[inline(always)]
    fn average(&self, texels: &mut [[f32; 4]], sums: &mut [[f64; 4]]) {
        let (count, whole, inverse_length) = (texels.len(), self.whole, 1.0 / self.length);
        for _ in 0..3 {
            // sums[i]: prefix sum of `i` texels, starting `whole + 1` before the first.
            let mut sum = [0.0_f64; 4];
            sums[0] = sum;
            let mut next = 1;
            for section in [&texels[count - whole - 1..], &*texels, &texels[..=whole]] {
                for (prefix_sum, t) in sums[next..].iter_mut().zip(section) {
                    for c in 0..4 {
                        sum[c] += f64::from(t[c]);
                    }
                    *prefix_sum = sum;
                }
                next += section.len();
            }
            // For texel `i`, the prefix sums at both ends of the texels with full weight (inner), numbers `i + 1` and `i + 2 whole + 2`, and one texel beyond
            // them (outer).
            let ends = sums.iter().zip(&sums[1..]).zip(sums[2 * whole + 2..].iter().zip(&sums[2 * whole + 3..]));
            for (t, ((outer_start, inner_start), (inner_end, outer_end))) in texels.iter_mut().zip(ends) {
                for c in 0..4 {
                    let inner = inner_end[c] - inner_start[c];
                    t[c] = ((inner + self.end_weight * (outer_end[c] - outer_start[c] - inner)) * inverse_length) as f32;
                }
            }
        }
    }

    /// The same code compiled for AVX2: wider vectors, the same rounding.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn average_avx2(&self, texels: &mut [[f32; 4]], sums: &mut [[f64; 4]]) {
        self.average(texels, sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 128;
    const HEIGHT: usize = 64;

    /// Texels as a function of column and row.
    fn level(texel: impl Fn(usize, usize) -> [f32; 4]) -> Vec<Vec<[f32; 4]>> {
        (0..HEIGHT).map(|y| (0..WIDTH).map(|x| texel(x, y)).collect()).collect()
    }

    fn smoothed(mut rows: Vec<Vec<[f32; 4]>>, poles: PoleFilter) -> Vec<Vec<[f32; 4]>> {
        let finer_is_filtered = false;
        let pole_filter = PoleRowFilter::of(poles, WIDTH, HEIGHT, finer_is_filtered);
        rows.iter_mut().enumerate().for_each(|(y, row)| pole_filter.smooth(y, row, &mut PrefixSums::new()));
        rows
    }

    fn grain(x: usize, y: usize) -> [f32; 4] {
        let n = (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B);
        let n = (n ^ (n >> 15)).wrapping_mul(0x2C1B_3C6D);
        [(n >> 16) as f32 / 65_536.0, (n & 0xFFFF) as f32 / 65_536.0, 1.0, 1.0]
    }

    /// The mean square of the gradient along the row, divided by the one across to the next row; gradients per angle on the sphere, in the red channel.
    fn along_over_across(rows: &[Vec<[f32; 4]>], y: usize) -> f64 {
        let cos = latitude(y, HEIGHT).cos();
        let along: f64 = (0..WIDTH).map(|x| f64::from(rows[y][x][0] - rows[y][(x + 1) % WIDTH][0]).powi(2)).sum::<f64>() / cos / cos;
        let across: f64 = (0..WIDTH).map(|x| f64::from(rows[y][x][0] - rows[y + 1][x][0]).powi(2)).sum();
        along / across
    }

    #[test]
    fn grain_has_no_direction_at_the_poles_and_rows_keep_their_means() {
        let before = level(grain);
        let after = smoothed(before.clone(), PoleFilter::Values);
        for y in 0..HEIGHT {
            let mean = |rows: &[Vec<[f32; 4]>]| rows[y].iter().map(|t| f64::from(t[0])).sum::<f64>() / WIDTH as f64;
            assert!((mean(&before) - mean(&after)).abs() < 1e-5, "row {y}");
            let lat = latitude(y, HEIGHT).to_degrees();
            assert_eq!(lat.abs() < 45.0, before[y] == after[y], "row {y}");
            if lat.abs() > 60.0 && y + 1 < HEIGHT {
                let [ratio_before, ratio_after] = [&before, &after].map(|rows| along_over_across(rows, y));
                // The ratio of white noise is 1/cos² of the latitude, 4 or more beyond 60 degrees. After the filter it is about 1, with scatter (0.3 to 1.6)
                // because a filtered row has few independent values.
                assert!(
                    ratio_before > 2.5 && ratio_after < 2.2 && ratio_after < 0.6 * ratio_before,
                    "row {y}: {ratio_before} became {ratio_after}"
                );
            }
        }
    }

    #[test]
    fn functions_that_are_smooth_on_the_sphere_stay() {
        // Functions of the position on the unit sphere with wavelengths of at least 2 pi / sqrt(8² + 7²) = 0.59, which is much longer than the filter.
        let colour = |x: usize, y: usize| {
            let (lat, lon) = (latitude(y, HEIGHT), (x as f64 + 0.5) / WIDTH as f64 * TAU);
            let (px, py) = (lat.cos() * lon.cos(), lat.cos() * lon.sin());
            [
                (0.5 + 0.3 * px + 0.1 * px * py - 0.2 * py * lat.sin()) as f32,
                (0.5 + 0.2 * (8.0 * px).sin() * (7.0 * py).cos()) as f32,
                0.0,
                1.0,
            ]
        };
        let (before, after) = (level(colour), smoothed(level(colour), PoleFilter::Values));
        let max_difference =
            |c: usize| before.iter().flatten().zip(after.iter().flatten()).map(|(a, b)| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        // The rows at the poles, 0.025 rad from them, lose half of the first harmonic, whose amplitude is 0.025 sqrt(0.3² + 0.2²) = 0.009.
        assert!(max_difference(0) < 0.006, "{}", max_difference(0));
        // Sigma is less than 0.6 texels of the equator = 0.03 rad: exp(-(8 * 0.03)² / 2) takes 3 % of the amplitude of 0.2; at the poles half of
        // 0.2 x 8 x 0.025 is lost.
        assert!(max_difference(1) < 0.03, "{}", max_difference(1));
    }

    #[test]
    fn slopes_are_averaged_as_vectors() {
        // The same direction of slope everywhere in space, along x: in the texture it rotates with the meridian.
        let uniform_slope = |north: f32| {
            move |x: usize, _: usize| {
                let lon = (x as f64 + 0.5) / WIDTH as f64 * TAU;
                [NO_SLOPE - 0.2 * lon.sin() as f32, NO_SLOPE + north * 0.2 * lon.cos() as f32, 1.0, 1.0]
            }
        };
        // A cone around the pole.
        let cone = level(|_, _| [NO_SLOPE, NO_SLOPE + 0.3, 0.8, 1.0]);
        let cone = smoothed(cone, PoleFilter::Normals);
        for (y, north) in [(0, -1.0), (HEIGHT - 1, 1.0)] {
            let slope = smoothed(level(uniform_slope(north)), PoleFilter::Normals);
            let difference = slope[y].iter().enumerate().map(|(x, t)| (t[1] - uniform_slope(north)(x, y)[1]).abs()).fold(0.0, f32::max);
            assert!(difference < 1e-5, "row {y}: {difference}");
            let remaining = cone[y].iter().map(|t| (t[1] - NO_SLOPE).abs()).fold(0.0, f32::max);
            // In the frame at the pole the cone's slope is a first harmonic in longitude, of which the filter keeps half: 0.15.
            assert!(remaining < 0.17, "row {y}: the cone's tip slopes by {remaining} of 0.3");
            let values = smoothed(level(|_, _| [NO_SLOPE, NO_SLOPE + 0.3, 0.8, 1.0]), PoleFilter::Values);
            assert!(values[y].iter().all(|t| (t[1] - NO_SLOPE) > 0.29), "as numbers the cone would stay");
        }
    }

    #[test]
    fn a_gaussian_has_its_sigma_and_small_levels_do_no_harm() {
        for sigma in [0.3, 0.9, 2.0, 7.5] {
            let mut row = vec![[0.0; 4]; 256];
            row[128] = [1.0; 4];
            gaussian(&mut row, sigma, &mut PrefixSums::new());
            let moment = |k: i32| row.iter().enumerate().map(|(i, t)| f64::from(t[0]) * (i as f64 - 128.0).powi(k)).sum::<f64>();
            assert!((moment(0) - 1.0).abs() < 1e-5 && moment(1).abs() < 1e-4);
            assert!((moment(2).sqrt() / sigma - 1.0).abs() < 1e-3, "{sigma}: {}", moment(2).sqrt());
        }
        for (w, h) in [(1, 1), (2, 1), (1, 2), (3, 2), (4, 3)] {
            let finer_is_filtered = true;
            let pole_filter = PoleRowFilter::of(PoleFilter::Normals, w, h, finer_is_filtered);
            for y in 0..h {
                let mut row = vec![[0.25; 4]; w];
                pole_filter.smooth(y, &mut row, &mut PrefixSums::new());
                assert!(row.iter().flatten().all(|v| v.is_finite()));
            }
        }
    }

    /// Vectors of any width give the same bits, and previous content of the scratch memory does not matter.
    #[test]
    fn boxes_give_the_same_bits_with_any_vector_width() {
        let row: Vec<[f32; 4]> = (0..WIDTH).map(|x| [0, 1, 2, 3].map(|c| ((x * 37 + c * 11) % 97) as f32 * 0.01 - 0.3)).collect();
        for sigma in [0.7, 2.3, 9.0] {
            let (mut one, mut other) = (row.clone(), row.clone());
            gaussian(&mut one, sigma, &mut vec![[f64::NAN; 4]; 3 * WIDTH]);
            BoxFilter::with_variance(sigma * sigma / 3.0).average(&mut other, &mut vec![[0.0; 4]; 3 * WIDTH]);
            assert!(one == other && one != row, "sigma {sigma}");
        }
    }
}
