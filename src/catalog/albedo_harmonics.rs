//! Spherical harmonics of an albedo map, degrees 1 and 2: by how much each side of a body is brighter than the mean of all sides.
//!
//! In: the coefficients of the catalog. Out: the sums of the terms of degree 1 and of degree 2 in a direction. Always: the mean of each sum over the
//! sphere is 0. Not here: the brightness of the disc, which also depends on the photometric model (`scene::photometry::light_curve`).

use glam::DVec3;

/// Coefficients of the spherical harmonics of an albedo map. They describe the map's green channel, linear and divided by its mean over the sphere: this ratio
/// is 1 + the terms of degree 1 + the terms of degree 2 + the terms of higher degrees, which are left out. A test computes the coefficients from the map
/// (tests/image/light_curves.rs).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlbedoHarmonics {
    /// Coefficients of [`AlbedoHarmonics::basis_of_degree_1`].
    pub degree_1: [f64; 3],
    /// Coefficients of [`AlbedoHarmonics::basis_of_degree_2`].
    pub degree_2: [f64; 5],
}

impl AlbedoHarmonics {
    /// The three harmonics of degree 1: x, y and z of a unit vector, body axes (x through the prime meridian, y at 90 degrees east, z the pole).
    pub fn basis_of_degree_1(n: DVec3) -> [f64; 3] {
        n.to_array()
    }

    /// The five harmonics of degree 2 of a unit vector, body axes, without the usual normalisation: xy, yz, (3 z² - 1)/2, xz, (x² - y²)/2.
    pub fn basis_of_degree_2(n: DVec3) -> [f64; 5] {
        [n.x * n.y, n.y * n.z, (3.0 * n.z * n.z - 1.0) / 2.0, n.x * n.z, (n.x * n.x - n.y * n.y) / 2.0]
    }

    /// The sum of the terms of degree 1, and the sum of the terms of degree 2, in a direction (unit vector, body axes).
    pub fn sums_by_degree(&self, n: DVec3) -> [f64; 2] {
        let sum = |coefficients: &[f64], basis: &[f64]| coefficients.iter().zip(basis).map(|(c, f)| c * f).sum();
        [sum(&self.degree_1, &Self::basis_of_degree_1(n)), sum(&self.degree_2, &Self::basis_of_degree_2(n))]
    }
}
