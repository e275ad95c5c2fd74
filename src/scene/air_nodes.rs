//! Heights at which light is summed along rays that only rise or only fall, and what depends on the height alone.
//!
//! In: the air's amounts with the heights of a ray's ends. Out: rows of lib/air/columns.wgsl's `AirNode`. Method: Gauss and Legendre's nodes in w
//! from the lower end up, where the density of the air that reaches highest is 1 - w²; the absorbing layer above a height is thought to lie half and
//! half at one standard deviation under and over its mean. Always holds: an end outside the air has nothing above it.

use super::camera;
use super::draw::{AirAmounts, AirTier};
use glam::{DVec3, Vec4};
use std::f64::consts::PI;

/// Rows of one node.
pub const ROWS: usize = 3;
/// After the samples: the camera's end and the far end.
pub const ENDS: usize = 2;
/// Samples of a sky's ray at a tier; those of lib/air/rising.wgsl.
pub const fn samples(tier: AirTier) -> usize {
    match tier {
        AirTier::None => 0,
        AirTier::Vertex => 4,
        AirTier::Pixel8 => 6,
        AirTier::Pixel16 | AirTier::Table => 8,
        AirTier::Pixel32 => 16,
    }
}

/// Steps through each half of the absorbing layer.
const STEPS: usize = 32;
/// Of the polynomial for erfcx in lib/air/columns.wgsl.
const ERFCX_SLOPE: f64 = 0.56;

/// Nodes in 0 to 1, ascending, and their weights, which sum to 1.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let one = |k: usize| {
        let mut x = -(PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut here) = (1.0, x);
            for j in 2..=count {
                let j = j as f64;
                (before, here) = (here, ((2.0 * j - 1.0) * x * here - (j - 1.0) * before) / j);
            }
            slope = n * (x * here - before) / (x * x - 1.0);
            x -= here / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(one).collect()
}

fn excess_of(height: f64) -> f64 {
    height * (2.0 + height)
}
fn height_of(excess: f64) -> f64 {
    excess / (1.0 + (1.0 + excess).sqrt())
}

struct Shells {
    gas: f64,
    haze: f64,
    /// Excesses of the layer's knots.
    layer: DVec3,
    /// Scale height of the air that reaches highest.
    highest: f64,
}

impl Shells {
    /// Column of the layer above a height, with the mean height there and its standard deviation.
    fn layer_above(&self, height: f64) -> (f64, f64, f64) {
        let knots = [self.layer.x, self.layer.y, self.layer.z].map(height_of);
        let (mut column, mut first, mut second) = (0.0, 0.0, 0.0);
        for (from, to) in [(knots[0], knots[1]), (knots[1], knots[2])] {
            let from = from.max(height);
            let step = (to - from) / STEPS as f64;
            for k in 0..if step > 0.0 { STEPS } else { 0 } {
                let at = from + (k as f64 + 0.5) * step;
                let e = excess_of(at);
                let density = ((e - self.layer.x) / (self.layer.y - self.layer.x)).min((self.layer.z - e) / (self.layer.z - self.layer.y));
                column += density * step;
                first += density * step * at;
                second += density * step * at * at;
            }
        }
        if column <= 0.0 {
            return (0.0, height, 0.0);
        }
        let mean = first / column;
        (column, mean, (second / column - mean * mean).max(0.0).sqrt())
    }

    /// `weight`: of the quadrature, in height.
    fn rows(&self, height: f64, weight: f64, between: f64) -> [Vec4; ROWS] {
        let radius = 1.0 + height;
        let (gas, haze) = ((-height / self.gas).exp(), (-height / self.haze).exp());
        let slope = |scale: f64| ERFCX_SLOPE * (0.5 * radius / scale).sqrt() / radius;
        let factor = |density: f64, scale: f64| density * scale * (0.5 * PI * radius / scale).sqrt();
        let (column, mean, deviation) = self.layer_above(height);
        let over = |at: f64| (at - height) * (2.0 + at + height);
        let per_gas = ((1.0 / self.gas - 1.0 / self.haze) * height).exp();
        let row = |x: f64, y: f64, z: f64, w: f64| camera::narrow(DVec3::new(x, y, z)).extend(camera::narrow_scalar(w));
        [
            row(excess_of(height), weight * radius * gas, per_gas, 1.0 / (radius * radius)),
            row(slope(self.gas), factor(gas, self.gas), slope(self.haze), factor(haze, self.haze)),
            row(0.5 * column, over(mean - deviation).max(1e-9), over(mean + deviation).max(1e-9), excess_of(between)),
        ]
    }
}

/// What an end outside the air has above it.
const NOTHING: [Vec4; ROWS] = [Vec4::new(0.0, 0.0, 0.0, 1.0), Vec4::ZERO, Vec4::new(0.0, 1.0, 1.0, 0.0)];

/// The rows of that many samples and of the two ends.
pub fn nodes(air: &AirAmounts, samples: usize) -> Vec<Vec4> {
    let (gas, haze) = (f64::from(air.gas_height), f64::from(air.haze_height));
    let hazy = air.haze_extinction.max_element() > 0.0;
    let shells = Shells { gas, haze, layer: air.layer.as_dvec3(), highest: if hazy { gas.max(haze) } else { gas } };
    let (camera, far) = (f64::from(air.ends.x), f64::from(air.ends.y));
    let (low, high) = (camera.min(far), camera.max(far));
    let whole = (1.0 - (-(high - low) / shells.highest).exp()).max(0.0).sqrt();
    let height = |w: f64| low - shells.highest * (1.0 - w * w).ln();
    let grid = gauss_legendre(samples);
    let mut rows: Vec<Vec4> = Vec::with_capacity(ROWS * (samples + ENDS));
    for (k, (x, weight)) in grid.iter().enumerate() {
        let w = whole * x;
        let next = grid.get(k + 1).map_or(1.0, |n| n.0);
        let slope = 2.0 * w * shells.highest / (1.0 - w * w);
        rows.extend(shells.rows(height(w), weight * whole * slope, height(0.5 * whole * (x + next))));
    }
    let top = height_of(f64::from(air.top));
    for end in [camera, far] {
        // Up to rounding of f32.
        rows.extend(if end < top * (1.0 - 1e-6) { shells.rows(end, 0.0, end) } else { NOTHING });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn the_quadrature_is_exact_for_its_degree_and_not_beyond() {
        for count in [1, 4, 6, 8, 16] {
            let grid = gauss_legendre(count);
            let power = |p: i32| grid.iter().map(|(x, w)| w * x.powi(p)).sum::<f64>();
            let degree = 2 * count as i32 - 1;
            for p in 0..=degree {
                assert!((power(p) - 1.0 / f64::from(p + 1)).abs() < 1e-12, "{count} nodes, power {p}");
            }
            assert!((power(degree + 1) - 1.0 / f64::from(degree + 2)).abs() > 1e-12 || count > 8);
            assert!(grid.windows(2).all(|w| w[0].0 < w[1].0));
        }
    }

    fn air(camera: f32, far: f32) -> AirAmounts {
        AirAmounts {
            top: 0.032,
            ends: Vec2::new(camera, far),
            gas_height: 0.00125,
            gas_extinction: Vec3::ONE,
            haze_height: 0.0002,
            haze_extinction: Vec3::ONE,
            layer: Vec3::new(0.003, 0.008, 0.0125),
            layer_extinction: Vec3::ONE,
            ..AirAmounts::default()
        }
    }

    /// Straight up, the samples' weights give the column of gas between the ends; the rows of a height give the layer above it.
    #[test]
    fn the_weights_sum_to_the_column_of_gas() {
        for (camera, far) in [(0.0159, 0.0), (0.001, 0.0), (0.0005, 0.0159)] {
            let rows = nodes(&air(camera, far), 8);
            assert_eq!(rows.len(), ROWS * (8 + ENDS));
            let scale = 0.00125;
            let (low, high) = (f64::from(camera.min(far)), f64::from(camera.max(far)));
            let column = scale * ((-low / scale).exp() - (-high / scale).exp());
            // gas * step * radius, over the distance from the centre, which is the radius.
            let sum: f64 = (0..8).map(|k| f64::from(rows[ROWS * k].y * rows[ROWS * k].w.sqrt())).sum();
            assert!((sum / column - 1.0).abs() < 1e-4, "{camera} {far}: {sum} for {column}");
            let heights: Vec<f32> = (0..8).map(|k| rows[ROWS * k].x).collect();
            assert!(heights.is_sorted() && rows.iter().all(|r| r.is_finite()));
        }
        // A tent's column is its half width.
        let ground = nodes(&air(0.0159, 0.0), 8);
        let tent = height_of(0.008) - height_of(0.003);
        assert!((f64::from(2.0 * ground[ROWS * 9 + 2].x) / tent - 1.0).abs() < 0.01);
        assert_eq!(ground[ROWS * 8 + 1], Vec4::ZERO, "the camera is outside");
    }
}
