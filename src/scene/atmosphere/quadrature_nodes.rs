//! Quadrature nodes: the heights at which the air's light is summed along rays that only rise or only fall, with the quantities that depend on height alone.
//!
//! In: the atmosphere's uniforms with the heights of a ray's ends. Out: rows of `AirAtHeight` (shaders/lib/air/column_density.wesl), polynomials of multiple
//! scattering at the nodes, and sample positions for all other rays. Method: Gauss-Legendre nodes in a variable w that is 0 at the lower end and grows upwards:
//! 1 - w² is the density of the species with the largest scale height, relative to its density at the lower end. The ends are inside the atmosphere or at its
//! top (`air::set_ends`).

use crate::scene::atmosphere::{multi_scatter_table, radius_sq_minus_1};
use crate::scene::camera;
use crate::scene::constants::{ERFCX_FIT_SCALE, MULTI_SCATTER_COEFFICIENTS};
use crate::scene::draw::AtmosphereUniforms;
use crate::scene::numeric::gauss_legendre;
use glam::{DVec3, Vec4};
use std::f64::consts::PI;

/// Number of rows (vec4s) of the uniform per node.
pub(crate) const ROWS: usize = 3;
/// Number of nodes that follow the quadrature nodes: one at the camera's end and one at the far end.
pub(crate) const ENDS: usize = 2;

/// Rows of the samples of shaders/lib/air/scatter_marched.wesl: position (x), 0 to 1; weight (y); midpoint between this position and the next (z).
pub(crate) fn samples(count: usize) -> Vec<Vec4> {
    let all = gauss_legendre(count);
    all.iter().enumerate().map(|(k, (x, w))| camera::narrow(DVec3::new(*x, *w, midpoint(&all, k))).extend(0.0)).collect()
}

/// The midpoint between the position of a node and that of the next, or the end at 1.
fn midpoint(nodes: &[(f64, f64)], k: usize) -> f64 {
    0.5 * (nodes[k].0 + nodes.get(k + 1).map_or(1.0, |next| next.0))
}

/// Scale heights and layer edges of an atmosphere's density profiles, in radii.
struct Profiles {
    /// Scale height of the gas.
    rayleigh_scale_height: f64,
    /// Scale height of the aerosol.
    mie_scale_height: f64,
    /// `radius_sq_minus_1` of the lower edge, middle and upper edge of the absorption layer.
    layer_edges: DVec3,
    /// The largest scale height.
    largest_scale_height: f64,
}

impl Profiles {
    /// The rows of a node. `weight`: quadrature weight in height; `midpoint_height`: the height half-way to the next node.
    fn rows(&self, height: f64, weight: f64, midpoint_height: f64) -> [Vec4; ROWS] {
        let radius = 1.0 + height;
        let (rayleigh_density, mie_density) = ((-height / self.rayleigh_scale_height).exp(), (-height / self.mie_scale_height).exp());
        // `erfcx_scale` and `grazing_column` are the values of `AirAtHeight::chapman`.
        let erfcx_scale = |scale_height: f64| ERFCX_FIT_SCALE * (0.5 * radius / scale_height).sqrt() / radius;
        // The column density outwards along a horizontal ray, as in shaders/lib/air/column_density.wesl, which has the root of pi as a factor of its own.
        let grazing_column = |density: f64, scale_height: f64| density * scale_height * (0.5 * PI * radius / scale_height).sqrt();
        let layer_edges = self.layer_edges - radius_sq_minus_1(height);
        let mie_per_rayleigh = ((1.0 / self.rayleigh_scale_height - 1.0 / self.mie_scale_height) * height).exp();
        let row = |x: f64, y: f64, z: f64, w: f64| camera::narrow(DVec3::new(x, y, z)).extend(camera::narrow_scalar(w));
        [
            row(radius_sq_minus_1(height), weight * radius * rayleigh_density, mie_per_rayleigh, 1.0 / radius),
            row(
                erfcx_scale(self.rayleigh_scale_height),
                grazing_column(rayleigh_density, self.rayleigh_scale_height),
                erfcx_scale(self.mie_scale_height),
                grazing_column(mie_density, self.mie_scale_height),
            ),
            row(layer_edges.x, layer_edges.y, layer_edges.z, radius_sq_minus_1(midpoint_height)),
        ]
    }
}

/// The ends of a ray and where the nodes between them lie, from the lower end up.
struct NodePlacement {
    profiles: Profiles,
    /// Heights of the camera's end, of the far end, and of the lower of the two, in radii.
    camera_height: f64,
    far_height: f64,
    low_height: f64,
    /// w at the upper end; see the module's documentation.
    w_max: f64,
    /// Quadrature nodes: positions from 0 to 1, with weights.
    nodes: Vec<(f64, f64)>,
}

impl NodePlacement {
    fn of(air: &AtmosphereUniforms, node_count: usize) -> Self {
        let (rayleigh_scale_height, mie_scale_height) = (f64::from(air.rayleigh_scale_height), f64::from(air.mie_scale_height));
        let has_mie = air.mie_extinction.max_element() > 0.0;
        let largest_scale_height = if has_mie { rayleigh_scale_height.max(mie_scale_height) } else { rayleigh_scale_height };
        let (camera_height, far_height) = (f64::from(air.end_heights.x), f64::from(air.end_heights.y));
        let low_height = camera_height.min(far_height);
        let w_max = (1.0 - (-(camera_height.max(far_height) - low_height) / largest_scale_height).exp()).max(0.0).sqrt();
        let layer_edges = air.absorption_layer.as_dvec3();
        let profiles = Profiles { rayleigh_scale_height, mie_scale_height, layer_edges, largest_scale_height };
        Self { profiles, camera_height, far_height, low_height, w_max, nodes: gauss_legendre(node_count) }
    }

    /// The height of a position `x`: 0 at the lower end, 1 at the upper.
    fn height(&self, x: f64) -> f64 {
        self.low_height - self.profiles.largest_scale_height * (1.0 - (self.w_max * x).powi(2)).ln()
    }

    /// The height above the ground of a position `x`, as a fraction of the height of the multiple-scattering table's top; may be outside 0 to 1.
    fn table_height_fraction(&self, x: f64, air: &AtmosphereUniforms) -> f64 {
        (self.height(x) + f64::from(air.multi_scatter_heights.x)) * f64::from(air.multi_scatter_heights.y)
    }
}

/// The rows of `count` quadrature nodes, then those of the two ends.
pub(crate) fn nodes(air: &AtmosphereUniforms, count: usize) -> Vec<Vec4> {
    let placement = NodePlacement::of(air, count);
    let profiles = &placement.profiles;
    let mut rows: Vec<Vec4> = Vec::with_capacity(ROWS * (count + ENDS));
    for (k, (x, weight)) in placement.nodes.iter().enumerate() {
        let w = placement.w_max * x;
        let height_per_w = 2.0 * w * profiles.largest_scale_height / (1.0 - w * w);
        let midpoint_height = placement.height(midpoint(&placement.nodes, k));
        rows.extend(profiles.rows(placement.height(*x), weight * placement.w_max * height_per_w, midpoint_height));
    }
    // The density continues above the top of the atmosphere, at both ends alike: the difference of their columns is the column between them.
    for end_height in [placement.camera_height, placement.far_height] {
        let weight = 0.0;
        rows.extend(profiles.rows(end_height, weight, end_height));
    }
    rows
}

/// Number of coefficients of the polynomial that approximates the multiple-scattering table at a height. Its variable is mu / (mu + MULTI_SCATTER_BEND), where
/// mu is the cosine of the Sun's zenith angle.
pub(crate) const COEFFICIENTS: usize = MULTI_SCATTER_COEFFICIENTS;
/// The cosine of the zenith angle of a Sun in the zenith.
const ZENITH_COSINE: f64 = 1.0;
/// Number of zenith cosines at which the polynomial is fitted.
const FIT_POINTS: usize = 48;

/// The polynomials at the heights of `count` nodes: least-squares fits of the table's square roots, for a Sun from the horizon to the zenith.
pub(crate) fn multi_scatter(air: &AtmosphereUniforms, count: usize) -> Vec<Vec4> {
    let column_coordinate = |k: usize| (k as f64 + 0.5) / FIT_POINTS as f64 * multi_scatter_table::column_coordinate(ZENITH_COSINE);
    let mut all = Vec::with_capacity(COEFFICIENTS * count);
    let placement = NodePlacement::of(air, count);
    for (x, _) in &placement.nodes {
        let height_fraction = placement.table_height_fraction(*x, air).clamp(0.0, 1.0);
        let mut normal_matrix = [[0.0; COEFFICIENTS]; COEFFICIENTS];
        let mut right_hand = [DVec3::ZERO; COEFFICIENTS];
        for k in 0..FIT_POINTS {
            let coordinate = column_coordinate(k);
            let root = multi_scatter_table::root_between(&air.multi_scatter, height_fraction, coordinate);
            for i in 0..COEFFICIENTS {
                right_hand[i] += root * coordinate.powi(i as i32);
                for (j, n) in normal_matrix[i].iter_mut().enumerate() {
                    *n += coordinate.powi((i + j) as i32);
                }
            }
        }
        all.extend(solve(normal_matrix, right_hand).map(|c| camera::narrow(c).extend(0.0)));
    }
    all
}

/// Solves the normal equations, matrix `m` times coefficients = right-hand side `b`, by Gaussian elimination; the matrix is positive definite.
fn solve(mut m: [[f64; COEFFICIENTS]; COEFFICIENTS], mut b: [DVec3; COEFFICIENTS]) -> [DVec3; COEFFICIENTS] {
    for i in 0..COEFFICIENTS {
        for r in i + 1..COEFFICIENTS {
            let factor = m[r][i] / m[i][i];
            let (pivot_row, pivot_side) = (m[i], b[i]);
            m[r].iter_mut().zip(pivot_row).skip(i).for_each(|(here, above)| *here -= factor * above);
            b[r] -= factor * pivot_side;
        }
    }
    for i in (0..COEFFICIENTS).rev() {
        let known: DVec3 = (i + 1..COEFFICIENTS).map(|c| b[c] * m[i][c]).sum();
        b[i] = (b[i] - known) / m[i][i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::atmosphere::height_above_unit_sphere;
    use glam::{Vec2, Vec3};

    /// The polynomials agree with the table at the heights of all nodes, for a Sun from the horizon to the zenith.
    #[test]
    fn the_polynomials_approximate_the_table() {
        let catalog = crate::catalog::Catalog::embedded();
        for name in ["Earth", "Mars", "Titan", "Venus"] {
            let body = catalog.bodies().iter().find(|b| b.name == name).expect(name);
            let table = multi_scatter_table::table(body).expect("air");
            let floor_scale = 1.0;
            let air = AtmosphereUniforms {
                multi_scatter: std::sync::Arc::new(table.clone()),
                ..crate::scene::atmosphere::air::uniforms(body, floor_scale)
            };
            let fits = multi_scatter(&air, 8);
            assert_eq!(fits.len(), 8 * COEFFICIENTS);
            let brightest = table.iter().map(|v| v.truncate().max_element()).fold(0.0, f32::max).powi(2);
            let placement = NodePlacement::of(&air, 8);
            for (k, (x, _)) in placement.nodes.iter().enumerate() {
                let height_fraction = placement.table_height_fraction(*x, &air).clamp(0.0, 1.0);
                for step in 0..=20 {
                    let coordinate = f64::from(step) / 20.0 * multi_scatter_table::column_coordinate(ZENITH_COSINE);
                    let root: DVec3 =
                        (0..COEFFICIENTS).map(|p| fits[COEFFICIENTS * k + p].truncate().as_dvec3() * coordinate.powi(p as i32)).sum();
                    let exact = multi_scatter_table::root_between(&table, height_fraction, coordinate);
                    let error = (root * root - exact * exact).abs().max_element();
                    assert!(error < 0.02 * f64::from(brightest), "{name}, node {k}, {coordinate}: {error} of {brightest}");
                }
            }
        }
    }

    /// Air similar to the Earth's, and the heights of the camera and of the far end; lengths in radii.
    fn air(camera: f32, far: f32) -> AtmosphereUniforms {
        AtmosphereUniforms {
            top_radius_sq_minus_1: 0.032,
            end_heights: Vec2::new(camera, far),
            rayleigh_scale_height: 0.00125,
            rayleigh_extinction: Vec3::ONE,
            mie_scale_height: 0.0002,
            mie_extinction: Vec3::ONE,
            absorption_layer: Vec3::new(0.003, 0.008, 0.0125),
            absorption_extinction: Vec3::ONE,
            ..AtmosphereUniforms::default()
        }
    }

    /// On a vertical ray the nodes' weights give the column of gas between the ends; the rows of an end give the layer's edges above it.
    #[test]
    fn the_weights_sum_to_the_column_of_gas() {
        // 0.0159 is just above the top of this air, 0 is the ground.
        for (camera, far) in [(0.0159, 0.0), (0.001, 0.0), (0.0005, 0.0159)] {
            let rows = nodes(&air(camera, far), 8);
            assert_eq!(rows.len(), ROWS * (8 + ENDS));
            let scale = 0.00125;
            let (low, high) = (f64::from(camera.min(far)), f64::from(camera.max(far)));
            let column = scale * ((-low / scale).exp() - (-high / scale).exp());
            // y is weight * radius * density of the gas, w is one over the radius.
            let sum: f64 = (0..8).map(|k| f64::from(rows[ROWS * k].y * rows[ROWS * k].w)).sum();
            assert!((sum / column - 1.0).abs() < 1e-4, "{camera} {far}: {sum} for {column}");
            let heights: Vec<f32> = (0..8).map(|k| rows[ROWS * k].x).collect();
            assert!(heights.is_sorted() && rows.iter().all(|r| r.is_finite()));
        }
        // The layer's edges relative to the far end, which is the ground (node 9), and to the camera's end in the middle of the layer (node 8).
        let ends = nodes(&air(height_above_unit_sphere(0.008) as f32, 0.0), 8);
        let layer_edges = |node: usize| ends[ROWS * node + 2].truncate().as_dvec3();
        assert!((layer_edges(9) - DVec3::new(0.003, 0.008, 0.0125)).abs().max_element() < 1e-8);
        assert!((layer_edges(8) - DVec3::new(-0.005, 0.0, 0.0045)).abs().max_element() < 1e-8);
    }
}
