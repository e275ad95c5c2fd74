//! Maps of heights on a sphere: filters, and a map with finer texels.
//!
//! Always: the filters continue each meridian beyond a pole as the opposite one, so that no edge shows.

/// Number of texels of a finer map for each of the source, along each axis.
const FINENESS: usize = 4;

/// Heights in metres, equirectangular: row 0 is the northernmost, column 0 is at longitude -180 degrees.
pub(super) struct Heights {
    pub width: usize,
    pub height: usize,
    pub metres: Vec<f64>,
}

impl Heights {
    /// Beyond a pole, the meridian continues as the opposite one.
    pub(super) fn at(&self, x: i64, y: i64) -> f64 {
        let (width, height) = (self.width as i64, self.height as i64);
        let is_beyond_pole = y < 0 || y >= height;
        let x = if is_beyond_pole { x + width / 2 } else { x };
        let y = if y < 0 { -1 - y } else { y.min(2 * height - 1 - y) };
        self.metres[(y * width + x.rem_euclid(width)) as usize]
    }

    pub(super) fn from_fn(width: usize, height: usize, mut value: impl FnMut(i64, i64) -> f64) -> Self {
        let metres = (0..width * height).map(|i| value((i % width) as i64, (i / width) as i64)).collect();
        Self { width, height, metres }
    }

    pub(super) fn combined(&self, other: &Self, value: impl Fn(f64, f64) -> f64) -> Self {
        let metres = self.metres.iter().zip(&other.metres).map(|(a, b)| value(*a, *b)).collect();
        Self { width: self.width, height: self.height, metres }
    }

    /// Smoothed by a Gaussian of this standard deviation in texels.
    fn blurred(&self, sigma: f64) -> Self {
        let reach = (4.0 * sigma).ceil() as i64;
        let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let sum = |value: &dyn Fn(i64) -> f64| (-reach..=reach).zip(&weights).map(|(k, weight)| weight * value(k)).sum::<f64>() / total;
        let along_rows = Self::from_fn(self.width, self.height, |x, y| sum(&|k| self.at(x + k, y)));
        Self::from_fn(self.width, self.height, |x, y| sum(&|k| along_rows.at(x, y + k)))
    }

    /// Without the part of the finest detail that is as weak as the noise (Wiener's filter; the variance is that of the surroundings).
    pub(super) fn denoised(&self, noise_m: f64) -> Self {
        let smooth = self.blurred(1.0);
        let detail = self.combined(&smooth, |a, b| a - b);
        let variance = detail.combined(&detail, |a, b| a * b).blurred(2.0);
        let kept = detail.combined(&variance, |d, v| d * (1.0 - noise_m * noise_m / v.max(1e-9)).max(0.0));
        smooth.combined(&kept, |a, b| a + b)
    }

    /// [`FINENESS`] times finer, by cubic splines along the rows and along the meridians, each of which continues as the opposite one.
    pub(super) fn finer(&self) -> Self {
        let (width, height) = (FINENESS * self.width, FINENESS * self.height);
        let rows: Vec<f64> = self.metres.chunks_exact(self.width).flat_map(finer_circle).collect();
        let rows = Self { width, height: self.height, metres: rows };
        let mut metres = vec![0.0; width * height];
        for x in 0..width / 2 {
            let circle: Vec<f64> = (0..2 * self.height).map(|y| rows.at(x as i64, y as i64)).collect();
            for (y, value) in finer_circle(&circle).into_iter().enumerate() {
                let (x, y) = if y < height { (x, y) } else { (x + width / 2, 2 * height - 1 - y) };
                metres[y * width + x] = value;
            }
        }
        Self { width, height, metres }
    }

    /// The means of squares of [`FINENESS`] texels to a side.
    pub(super) fn coarser(&self) -> Self {
        let (n, squared) = (FINENESS as i64, (FINENESS * FINENESS) as f64);
        Self::from_fn(self.width / FINENESS, self.height / FINENESS, |x, y| {
            (0..n * n).map(|k| self.at(n * x + k % n, n * y + k / n)).sum::<f64>() / squared
        })
    }
}

/// A cubic spline through values around a circle, at the middles of [`FINENESS`] parts of each.
fn finer_circle(values: &[f64]) -> Vec<f64> {
    let n = values.len() as i64;
    let at = |list: &[f64], i: i64| list[i.rem_euclid(n) as usize];
    // The recursive filter that turns values into coefficients of B-splines (Unser 1999, IEEE Signal Process. Mag. 16(6), 22); after 32 steps its start
    // no longer matters.
    let pole = 3.0_f64.sqrt() - 2.0;
    let (mut forward, mut state) = (vec![0.0; n as usize], 0.0);
    for i in -32..n {
        state = at(values, i) + pole * state;
        forward[i.rem_euclid(n) as usize] = state;
    }
    let (mut coefficients, mut state) = (vec![0.0; n as usize], 0.0);
    for i in (0..n + 32).rev() {
        state = pole * (state - at(&forward, i));
        coefficients[i.rem_euclid(n) as usize] = 6.0 * state;
    }
    let sample = |k: i64| {
        let position = (k as f64 + 0.5) / FINENESS as f64 - 0.5;
        let (i, t) = (position.floor() as i64, position - position.floor());
        let weights = [(1.0 - t).powi(3), 3.0 * t.powi(3) - 6.0 * t * t + 4.0, 3.0 * (t + t * t - t.powi(3)) + 1.0, t.powi(3)];
        (-1..3).zip(weights).map(|(offset, weight)| weight / 6.0 * at(&coefficients, i + offset)).sum()
    };
    (0..n * FINENESS as i64).map(sample).collect()
}
