//! Optical depth of the air above the ground along a straight line, as a polynomial.
//!
//! In: the atmosphere's uniforms. Out: the uniform `air_optical_depth_above_ground` of shaders/lib/air/optical_depth_above.wesl: per channel, the coefficients
//! of t, t², and so on, where t = 1 / (1 + slope cos z), z is the zenith angle, and the slope is that of `slope`. Always: the air is taken to extend upwards
//! without limit, because the air above an atmosphere's top is negligible. Relative error of the opacity 1 - exp(-depth) against quadrature: under 6e-5 for any
//! body of the catalog, above its ground and above its clouds, and under 2e-3 for the invented atmospheres of the tests below.

use crate::scene::atmosphere::{height_above_unit_sphere, radius_sq_minus_1};
use crate::scene::camera;
use crate::scene::constants::{ERFCX_FIT_SCALE, OPTICAL_DEPTH_TERMS as TERMS};
use crate::scene::draw::AtmosphereUniforms;
use crate::scene::numeric::gauss_legendre;
use glam::{DVec3, Vec3, Vec4};
use std::f64::consts::PI;

/// Number of zenith angles at which the polynomial is fitted.
const FIT_POINTS: usize = 24;
/// Number of quadrature nodes along a line.
const NODES: usize = 32;
/// Lines with less than this optical depth count as without air: the weights of the fit are about 1 / depth, and their squares must be far below the largest
/// f64.
const MIN_DEPTH: f64 = 1e-30;
/// Height, in scale heights, up to which a line is integrated: the density there is exp(-36) = 2e-16 of that at the ground.
const END_SCALE_HEIGHTS: f64 = 36.0;

/// Column density of an exponential atmosphere along a line that leaves the ground at `cos_zenith`, for a density of 1 at the ground. Column and scale height
/// are in radii of the ground. `nodes`: positions in 0 to 1 with weights.
fn exponential_column(scale_height: f64, cos_zenith: f64, nodes: &[(f64, f64)]) -> f64 {
    // The distance s at which the line has risen by END_SCALE_HEIGHTS: the positive root of s² + 2 s cos = height (2 + height), in a form without cancellation.
    let height = END_SCALE_HEIGHTS * scale_height;
    let rise = radius_sq_minus_1(height);
    let end = rise / (cos_zenith + (cos_zenith * cos_zenith + rise).sqrt());
    let density = |s: f64| {
        // |p|² - 1 at the distance s from the ground.
        let radius_sq_minus_1 = s * (s + 2.0 * cos_zenith);
        (-height_above_unit_sphere(radius_sq_minus_1) / scale_height).exp()
    };
    nodes.iter().map(|(x, weight)| weight * end * density(x * end)).sum()
}

/// Column density of the absorption layer along such a line, in radii, for a density of 1 in the layer's middle. `knots`: |p|² - 1 at the lower edge, the
/// middle and the upper edge. The density is linear in |p|² - 1 between the knots, and |p|² is quadratic along the line. So two quadrature nodes per piece are
/// exact.
fn layer_column(knots: DVec3, cos_zenith: f64, two_nodes: &[(f64, f64)]) -> f64 {
    // Distance along the line to the point with this |p|² - 1; 0 if that is below the ground. The maximum with 1e-30 avoids 0 / 0 for a horizontal line.
    let distance = |radius_sq_minus_1: f64| {
        let rise = radius_sq_minus_1.max(0.0);
        rise / (cos_zenith + (cos_zenith * cos_zenith + rise).sqrt()).max(1e-30)
    };
    // The column between two knots. `zero`, `full`: |p|² - 1 where the density is 0, and where it is 1.
    let piece = |from: f64, to: f64, zero: f64, full: f64| {
        let (a, b) = (distance(from), distance(to));
        if b <= a {
            return 0.0;
        }
        let density = |s: f64| (s * (s + 2.0 * cos_zenith) - zero) / (full - zero);
        two_nodes.iter().map(|(x, weight)| weight * (b - a) * density(a + x * (b - a))).sum::<f64>()
    };
    piece(knots.x, knots.y, knots.x, knots.y) + piece(knots.y, knots.z, knots.z, knots.y)
}

/// Computes the optical depth of the air along lines, by quadrature.
struct DepthIntegral<'a> {
    air: &'a AtmosphereUniforms,
    /// Gauss-Legendre nodes for the exponential profiles: positions in 0 to 1 with weights.
    nodes: Vec<(f64, f64)>,
    /// The same for each piece of the absorption layer.
    two_nodes: Vec<(f64, f64)>,
}

impl<'a> DepthIntegral<'a> {
    fn of(air: &'a AtmosphereUniforms, nodes: usize) -> Self {
        Self { air, nodes: gauss_legendre(nodes), two_nodes: gauss_legendre(2) }
    }

    /// The optical depth per channel along the line at this zenith angle.
    fn depth(&self, cos_zenith: f64) -> DVec3 {
        // `column` is computed only if the species exists.
        let depth_of_species = |extinction: Vec3, column: &dyn Fn() -> f64| match extinction == Vec3::ZERO {
            true => DVec3::ZERO,
            false => extinction.as_dvec3() * column(),
        };
        let air = self.air;
        let exponential = |scale_height: f32| move || exponential_column(f64::from(scale_height), cos_zenith, &self.nodes);
        depth_of_species(air.rayleigh_extinction, &exponential(air.rayleigh_scale_height))
            + depth_of_species(air.mie_extinction, &exponential(air.mie_scale_height))
            + depth_of_species(air.absorption_extinction, &|| layer_column(air.absorption_layer.as_dvec3(), cos_zenith, &self.two_nodes))
    }
}

/// The slope in t = 1 / (1 + slope cos z): for one species ERFCX_FIT_SCALE sqrt(x / 2), where x is 1 / scale height, so that t is the variable of the
/// polynomials in `chapman_function` (shaders/lib/air/column_density.wesl) at the ground; for two species the geometric mean of their slopes.
fn slope(air: &AtmosphereUniforms) -> f64 {
    let of_species = |scale_height: f32| ERFCX_FIT_SCALE * (0.5 / f64::from(scale_height)).sqrt();
    (of_species(air.rayleigh_scale_height) * of_species(air.mie_scale_height)).sqrt()
}

/// The rows of the uniform. xyz of row k, counted from 0: the coefficient of t^(k + 1) per channel. w of row 0: the slope; of the others: 0.
pub(crate) fn terms(air: &AtmosphereUniforms) -> [Vec4; TERMS] {
    let slope = slope(air);
    let integral = DepthIntegral::of(air, NODES);
    // Chebyshev nodes in t, which is 1 at the horizon and 1 / (1 + slope) in the zenith.
    let zenith_t = 1.0 / (1.0 + slope);
    let points: Vec<(f64, DVec3)> = (0..FIT_POINTS)
        .map(|k| {
            let t = 0.5 * (1.0 + zenith_t) + 0.5 * (1.0 - zenith_t) * (PI * (k as f64 + 0.5) / FIT_POINTS as f64).cos();
            (t, integral.depth((1.0 / t - 1.0) / slope))
        })
        .collect();
    let fits = [0, 1, 2].map(|channel| fit(points.iter().map(|(t, depth)| (*t, depth[channel]))));
    let mut rows = [Vec4::ZERO; TERMS];
    for (k, row) in rows.iter_mut().enumerate() {
        *row = camera::narrow(DVec3::from(fits.map(|c| c[k]))).extend(0.0);
    }
    rows[0].w = camera::narrow_scalar(slope);
    rows
}

/// Coefficients of t, t², … that fit the depth by least squares, weighted so that the relative error of the opacity is uniform. `points`: t and depth; the
/// coefficients are 0 if no point has air. Solved by orthogonalised columns (modified Gram-Schmidt), because the normal equations would lose half of the
/// digits.
fn fit(points: impl Iterator<Item = (f64, f64)>) -> [f64; TERMS] {
    let mut columns = [[0.0; FIT_POINTS]; TERMS];
    let mut right_hand = [0.0; FIT_POINTS];
    for (k, (t, depth)) in points.enumerate() {
        if depth < MIN_DEPTH {
            continue;
        }
        // An error of the depth counts as the relative error that it causes in the opacity 1 - exp(-depth), plus 1e-4 of its own relative error. Where the air
        // is opaque the former vanishes, so an error counts as at least 1e-3 of its own relative error.
        let opacity_error_per_depth_error = (-depth).exp() / -(-depth).exp_m1();
        let weight = (opacity_error_per_depth_error + 1e-4 / depth).max(1e-3 / depth);
        right_hand[k] = weight * depth;
        let mut power = weight;
        for column in &mut columns {
            power *= t;
            column[k] = power;
        }
    }
    let dot = |a: &[f64; FIT_POINTS], b: &[f64; FIT_POINTS]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut upper_triangle = [[0.0; TERMS]; TERMS];
    let mut coefficients = [0.0; TERMS];
    for i in 0..TERMS {
        let length = dot(&columns[i], &columns[i]).sqrt();
        if length == 0.0 {
            return [0.0; TERMS];
        }
        upper_triangle[i][i] = length;
        columns[i].iter_mut().for_each(|v| *v /= length);
        let unit = columns[i];
        for j in i + 1..TERMS {
            upper_triangle[i][j] = dot(&unit, &columns[j]);
            columns[j].iter_mut().zip(unit).for_each(|(v, u)| *v -= upper_triangle[i][j] * u);
        }
        coefficients[i] = dot(&unit, &right_hand);
        right_hand.iter_mut().zip(unit).for_each(|(v, u)| *v -= coefficients[i] * u);
    }
    for i in (0..TERMS).rev() {
        let known: f64 = (i + 1..TERMS).map(|j| upper_triangle[i][j] * coefficients[j]).sum();
        coefficients[i] = (coefficients[i] - known) / upper_triangle[i][i];
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZENITH_COSINE: f64 = 1.0;
    const HORIZON_COSINE: f64 = 0.0;

    /// The optical depth by the polynomial.
    fn fitted_depth(rows: &[Vec4; TERMS], cos_zenith: f64) -> DVec3 {
        let t = 1.0 / (1.0 + f64::from(rows[0].w) * cos_zenith);
        rows.iter().rev().fold(DVec3::ZERO, |sum, row| (sum + row.truncate().as_dvec3()) * t)
    }

    /// Largest relative error of the opacity over all zenith angles and channels.
    fn error(air: &AtmosphereUniforms) -> f64 {
        let (rows, exact) = (terms(air), DepthIntegral::of(air, 200));
        let steps = (0..=400).map(|k| f64::from(k) / 400.0);
        let relative_error = |cos: f64| {
            let (fitted, truth) = (fitted_depth(&rows, cos), exact.depth(cos));
            let opacity = |d: DVec3| 1.0 - (-d).exp();
            // The error of an opacity below 1e-12 is taken relative to 1e-12, because 1 - exp(-depth) is rounded to some 1e-16.
            ((opacity(fitted) - opacity(truth)).abs() / opacity(truth).max(DVec3::splat(1e-12))).max_element()
        };
        // The cubes are denser near the horizon.
        steps.flat_map(|x| [x, x * x * x]).map(relative_error).fold(0.0, f64::max)
    }

    #[test]
    fn the_polynomial_agrees_with_quadrature_for_all_bodies_over_ground_and_clouds() {
        let catalog = crate::catalog::Catalog::embedded();
        let mut bodies = 0;
        for body in catalog.bodies().iter().filter(|b| b.atmosphere.is_some()) {
            let clouds = body.clouds.as_ref().map(|c| crate::scene::atmosphere::clouds::shell_scale(body, c));
            let ground_scale = 1.0;
            for floor_scale in std::iter::once(ground_scale).chain(clouds) {
                let error = error(&crate::scene::atmosphere::air::uniforms(body, floor_scale));
                assert!(error < 6e-5, "{} at {floor_scale}: {error:e}", body.name);
            }
            bodies += 1;
        }
        assert!(bodies > 8, "only {bodies} bodies have air");
    }

    #[test]
    fn invented_atmospheres_keep_the_bound_and_no_air_has_no_depth() {
        // `layer`: |p|² - 1 at its lower edge, middle and top. `depths`: vertical optical depths of gas and haze, and about four times that of the layer: its
        // thickness is half the range of |p|² - 1, and its column half its thickness.
        let invented = |[gas_scale_height, haze_scale_height]: [f32; 2], depths: [f32; 3], layer: Vec3| AtmosphereUniforms {
            rayleigh_scale_height: gas_scale_height,
            rayleigh_extinction: Vec3::splat(depths[0] / gas_scale_height),
            mie_scale_height: haze_scale_height,
            mie_extinction: Vec3::splat(depths[1] / haze_scale_height),
            absorption_layer: layer,
            absorption_extinction: Vec3::splat(depths[2] / (layer.z - layer.x)),
            ..AtmosphereUniforms::default()
        };
        let high = Vec3::new(0.0031, 0.0078, 0.0126);
        for scale_heights in [[1.25e-3, 1.25e-3], [1.25e-3, 1.9e-4], [1.25e-3, 5e-5], [0.05, 0.01], [2e-4, 2e-4]] {
            for depths in [[0.01, 0.0, 0.0], [0.3, 0.1, 0.05], [0.0, 3.0, 0.0], [1e-4, 0.0, 1.0], [20.0, 1.0, 0.0]] {
                // The layer reaches the ground in the second case.
                for layer in [high, Vec3::new(0.0, 0.002, 0.004)] {
                    let error = error(&invented(scale_heights, depths, layer));
                    assert!(error < 2e-3, "{scale_heights:?} {depths:?} {layer}: {error:e}");
                }
            }
        }
        let none = terms(&invented([1.25e-3; 2], [0.0; 3], high));
        assert!(none.iter().all(|row| row.truncate() == Vec3::ZERO));
        // Air so thin that its transmittance rounds to 1: accurate if all lines exceed `MIN_DEPTH` (1e-19); otherwise finite and less than twice as thick.
        for thin in [1e-19, 1e-30, 1e-36] {
            let rows = terms(&invented([1.25e-3; 2], [thin, 0.0, 0.0], high));
            let depth = fitted_depth(&rows, ZENITH_COSINE).x;
            assert!(rows.iter().all(|row| row.is_finite()) && (0.0..2.0 * f64::from(thin)).contains(&depth.abs()), "{thin:e}: {depth:e}");
            assert!(thin < 1e-20 || (depth / f64::from(thin) - 1.0).abs() < 0.01, "{thin:e}: {depth:e}");
        }
    }

    /// The vertical column of an exponential atmosphere is its scale height, and that of a triangular layer half its thickness.
    #[test]
    fn the_columns_have_their_closed_forms() {
        let nodes = gauss_legendre(NODES);
        for scale_height in [2e-4, 1.25e-3, 0.02] {
            assert!((exponential_column(scale_height, ZENITH_COSINE, &nodes) / scale_height - 1.0).abs() < 1e-9);
            // Horizontal, for the scale height H = 1 / x in radii (Chapman 1931): H x exp(x) K1(x) = H sqrt(pi x / 2) (1 + 3 / (8 x) - 15 / (128 x²) + ...).
            let x = 1.0 / scale_height;
            let grazing = scale_height * (0.5 * PI * x).sqrt() * (1.0 + 0.375 / x);
            let error = exponential_column(scale_height, HORIZON_COSINE, &nodes) / grazing - 1.0;
            assert!(error.abs() < 0.2 / (x * x), "{scale_height}: {error:e}");
        }
        // Heights of 1e-4 to 3e-4.
        let knots = DVec3::new(2e-4, 4e-4, 6e-4);
        assert!((layer_column(knots, ZENITH_COSINE, &gauss_legendre(2)) / 1e-4 - 1.0).abs() < 1e-3);
        // Twice as long at 60 degrees, less the curvature.
        let cos_60_deg = 0.5;
        let slanted = layer_column(knots, cos_60_deg, &gauss_legendre(2)) / layer_column(knots, ZENITH_COSINE, &gauss_legendre(2));
        assert!((slanted - 2.0).abs() < 2e-3, "{slanted}");
    }
}
