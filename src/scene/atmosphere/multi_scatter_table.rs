//! Multiply scattered light of an atmosphere, as a table over height and the Sun's zenith angle.
//!
//! In: a body with its atmosphere. Out: [`NODES`] square roots. The row of each height holds square roots of the radiance of light scattered twice or more, per
//! irradiance of the Sun; one more row holds square roots of the irradiance of level ground by the entire sky. Method (S. Hillaire, EGSR 2020): light of the
//! second order is summed over directions with an isotropic phase function, and each further order is the previous order times the fraction that scatters again
//! nearby: a geometric series. The ground is a Lambert surface of the body's albedo. Not modelled: the directionality of the higher orders, and differences in
//! illumination between neighbouring places.

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::extinction::{self, density, extinction, optical_depth, quadrature, scattering};
use crate::scene::atmosphere::phase;
use crate::scene::camera;
use crate::scene::constants::{MULTI_SCATTER_BEND as BEND, MULTI_SCATTER_FIRST as FIRST_COORDINATE};
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Numbers of rows and of columns. Rows: heights spaced quadratically from the ground to the top. Columns: cosines of the Sun's zenith angle, densest at the
/// horizon.
pub use crate::scene::constants::{MULTI_SCATTER_HEIGHTS as HEIGHTS, MULTI_SCATTER_SUNS as SUNS};
/// One row per height, then one for the irradiance of level ground.
pub const NODES: usize = (HEIGHTS + 1) * SUNS;
/// The source files that determine the table: an edit of one of them invalidates tables cached on disk. From the rest of the program these files use only the
/// body's numbers, which are part of the cache key too, and the narrowing to f32.
pub(crate) const SOURCES: [&str; 4] =
    [include_str!("multi_scatter_table.rs"), include_str!("extinction.rs"), include_str!("phase.rs"), include_str!("../constants.rs")];

/// Sampling with the Sun above the horizon.
const BY_DAY: SampleCounts = SampleCounts { directions: 64, steps: 24 };
/// Sampling with the Sun below the horizon, when sunlight reaches only a small part of the sky: sampled as [`BY_DAY`], the ground's irradiance at a solar
/// depression of 12 degrees would be a thirtieth of its true value.
const AT_DUSK: SampleCounts = SampleCounts { directions: 192, steps: 32 };
/// Sampling for the row of the ground's irradiance.
const ON_GROUND: SampleCounts = SampleCounts { directions: 1024, steps: 48 };
/// Integration steps towards the Sun.
const SUNLIGHT_STEPS: usize = 24;
/// Upper limit of the fraction of light that scatters again, so that the series converges.
pub(crate) const MAX_RESCATTERED: f64 = 0.98;
/// Column coordinate of the last column, the Sun in the zenith.
const LAST_COORDINATE: f64 = 1.0 / (1.0 + BEND);
/// Height at which rays that leave the ground start, so that rounding puts none of them below the ground: 10 cm.
pub(crate) const GROUND_CLEARANCE_KM: f64 = 1e-4;

/// Number of directions over the sphere, and of integration steps along each.
#[derive(Clone, Copy)]
struct SampleCounts {
    directions: usize,
    steps: usize,
}

/// A body's spherical atmosphere.
struct AirSphere<'a> {
    radius_km: f64,
    air: &'a Atmosphere,
    /// Albedo of the ground, linear RGB.
    ground_albedo: DVec3,
}

/// Cosine of the Sun's zenith angle in a column. Columns are evenly spaced in their coordinate x = mu / (|mu| + BEND), with mu this cosine.
pub fn sun_cosine(column: usize) -> f64 {
    let x = FIRST_COORDINATE + (LAST_COORDINATE - FIRST_COORDINATE) * column as f64 / (SUNS - 1) as f64;
    BEND * x / (1.0 - x.abs())
}

/// Height of a row.
pub(crate) fn row_height_km(air: &Atmosphere, row: usize) -> f64 {
    air.top_km * (row as f64 / (HEIGHTS - 1) as f64).powi(2)
}

/// Directions of a Fibonacci lattice on the sphere.
fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (PI * (1.0 + 5.0f64.sqrt()) * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    })
}

/// Direction to a Sun of this zenith cosine; the zenith is z.
fn towards_sun(cosine: f64) -> DVec3 {
    DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine)
}

/// The result of integrating along one ray.
struct RayIntegral {
    /// In-scattered light, for the `source` of [`AirSphere::integrate`].
    light: DVec3,
    /// In-scattered light from a source of 1 everywhere.
    rescattered: DVec3,
    transmittance: DVec3,
    /// Where the ray meets the ground, if it does.
    ground_point: Option<DVec3>,
}

impl AirSphere<'_> {
    /// Distance in km from a point along a ray to where the ray leaves the air, and whether it does so at the ground; otherwise it does so at the top of the
    /// atmosphere.
    fn distance_to_boundary(&self, p: DVec3, direction: DVec3) -> (f64, bool) {
        // Positions on the ray are counted from its point nearest to the centre. The ray meets a sphere at plus and minus half its chord in that sphere.
        let start = p.dot(direction);
        let nearest_sq = p.length_squared() - start * start;
        let half_ground_chord_sq = self.radius_km * self.radius_km - nearest_sq;
        if start < 0.0 && half_ground_chord_sq > 0.0 {
            return ((-start - half_ground_chord_sq.sqrt()).max(0.0), true);
        }
        let half_top_chord_sq = (self.radius_km + self.air.top_km).powi(2) - nearest_sq;
        ((-start + half_top_chord_sq.max(0.0).sqrt()).max(0.0), false)
    }

    /// Height of a point above the ground.
    fn height_km(&self, p: DVec3) -> f64 {
        (p.length() - self.radius_km).max(0.0)
    }

    /// A coefficient summed over all species, per km. `of_species`: [`scattering`] or [`extinction`].
    fn coefficient(&self, height_km: f64, of_species: fn(&crate::catalog::Species) -> DVec3) -> DVec3 {
        extinction::coefficient(self.air, height_km, of_species)
    }

    /// Transmittance from a point towards the Sun; 0 through the planet. `sun`: unit vector.
    fn sunlight(&self, p: DVec3, sun: DVec3) -> DVec3 {
        let (length_km, hits_ground) = self.distance_to_boundary(p, sun);
        if hits_ground {
            return DVec3::ZERO;
        }
        let depth = optical_depth(self.air, length_km, SUNLIGHT_STEPS, |s_km| self.height_km(p + sun * s_km));
        depth.map(|d| (-d).exp())
    }

    /// Integrates in-scattering along a ray in `count` steps. `source`: radiance that a unit of scattering at a point sends into the ray.
    fn integrate(&self, origin: DVec3, direction: DVec3, count: usize, source: impl Fn(DVec3) -> DVec3) -> RayIntegral {
        let (length_km, hits_ground) = self.distance_to_boundary(origin, direction);
        let mut ray = RayIntegral {
            light: DVec3::ZERO,
            rescattered: DVec3::ZERO,
            transmittance: DVec3::ONE,
            ground_point: hits_ground.then(|| origin + direction * length_km),
        };
        for (fraction, weight) in quadrature(count) {
            let p = origin + direction * (length_km * fraction);
            let (height_km, step_km) = (self.height_km(p), length_km * weight);
            let depth = self.coefficient(height_km, extinction) * step_km;
            // Mean transmittance from the start of the step to its points.
            let mean_transmittance = depth.map(|d| if d > 1e-6 { -(-d).exp_m1() / d } else { 1.0 });
            let scattered = ray.transmittance * self.coefficient(height_km, scattering) * mean_transmittance * step_km;
            ray.light += scattered * source(p);
            ray.rescattered += scattered;
            ray.transmittance *= depth.map(|d| (-d).exp());
        }
        ray
    }

    /// The node of a row and a column: radiance of the second and all further orders of scattering, averaged over all directions, per irradiance of the Sun.
    fn node(&self, row: usize, column: usize) -> DVec3 {
        let origin = DVec3::Z * (self.radius_km + row_height_km(self.air, row).max(GROUND_CLEARANCE_KM));
        let sun = towards_sun(sun_cosine(column));
        let sampling = if sun.z > 0.0 { BY_DAY } else { AT_DUSK };
        let (mut second, mut rescattered) = (DVec3::ZERO, DVec3::ZERO);
        for direction in directions(sampling.directions) {
            let ray = self.integrate(origin, direction, sampling.steps, |p| self.sunlight(p, sun) / (4.0 * PI));
            second += ray.light + ray.ground_point.map_or(DVec3::ZERO, |g| ray.transmittance * self.reflected(g, sun));
            rescattered += ray.rescattered;
        }
        let rescattered = rescattered / sampling.directions as f64;
        second / sampling.directions as f64 / rescattered.map(|a| 1.0 - a.min(MAX_RESCATTERED))
    }

    /// Radiance of the ground in direct sunlight, per irradiance of the Sun.
    fn reflected(&self, ground_point: DVec3, sun: DVec3) -> DVec3 {
        let up = ground_point.normalize();
        let above = up * (self.radius_km + GROUND_CLEARANCE_KM);
        self.ground_albedo * self.sunlight(above, sun) * (up.dot(sun).max(0.0) / PI)
    }

    /// Irradiance of level ground by the entire sky, per irradiance of the Sun. `rows`: the nodes of all heights.
    fn ground_irradiance(&self, rows: &[DVec3], column: usize) -> DVec3 {
        let origin = DVec3::Z * (self.radius_km + GROUND_CLEARANCE_KM);
        let sun = towards_sun(sun_cosine(column));
        let mut sum = DVec3::ZERO;
        for direction in directions(ON_GROUND.directions).filter(|d| d.z > 0.0) {
            let multiple_source = |p: DVec3| self.interpolate(rows, self.height_km(p), p.normalize().dot(sun));
            let multiple = self.integrate(origin, direction, ON_GROUND.steps, multiple_source).light;
            sum += (multiple + self.single_scattering(origin, direction, sun)) * direction.z;
        }
        // The directions are distributed over the entire sphere, so each has the solid angle 2 TAU / count.
        sum * (2.0 * TAU / ON_GROUND.directions as f64)
    }

    /// Single scattering along a ray, with the phase function of each species.
    fn single_scattering(&self, origin: DVec3, direction: DVec3, sun: DVec3) -> DVec3 {
        let cos_scattering = direction.dot(sun);
        let source = |p: DVec3| {
            let height_km = self.height_km(p);
            let all = self.coefficient(height_km, scattering).max(DVec3::splat(1e-30));
            let phase_times_density = |s: &crate::catalog::Species| density(s, height_km) * phase::per_steradian(s.phase, cos_scattering);
            let phase_weighted: DVec3 = self.air.species.iter().map(|s| scattering(s) * phase_times_density(s)).sum();
            self.sunlight(p, sun) * phase_weighted / all
        };
        self.integrate(origin, direction, ON_GROUND.steps, source).light
    }

    /// Interpolates the table as the shader does.
    fn interpolate(&self, rows: &[DVec3], height_km: f64, cosine: f64) -> DVec3 {
        let node = |k: usize| root(rows[k]);
        let root = between_nodes(height_km / self.air.top_km, column_coordinate(cosine), node);
        root * root
    }
}

/// The column coordinate of a zenith cosine: mu / (|mu| + BEND).
pub(crate) fn column_coordinate(cosine: f64) -> f64 {
    cosine / (cosine.abs() + BEND)
}

/// Interpolates the square roots of a table at a height, given as a fraction of the top's height, and a column coordinate. Entries that the table lacks are 0.
pub(crate) fn root_between(table: &[Vec4], height_fraction: f64, column_coordinate: f64) -> DVec3 {
    between_nodes(height_fraction, column_coordinate, |k| table.get(k).map_or(DVec3::ZERO, |v| v.truncate().as_dvec3()))
}

/// Bilinear interpolation between the nodes of the table at a height, given as a fraction of the top's height, and a column coordinate. `node`: the value of
/// node row * SUNS + column.
fn between_nodes(height_fraction: f64, column_coordinate: f64, node: impl Fn(usize) -> DVec3) -> DVec3 {
    let row = height_fraction.clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f64;
    let column =
        ((column_coordinate - FIRST_COORDINATE) / (LAST_COORDINATE - FIRST_COORDINATE) * (SUNS - 1) as f64).clamp(0.0, (SUNS - 1) as f64);
    let (r, c) = ((row as usize).min(HEIGHTS - 2), (column as usize).min(SUNS - 2));
    let in_row = |r: usize| node(r * SUNS + c).lerp(node(r * SUNS + c + 1), column - c as f64);
    in_row(r).lerp(in_row(r + 1), row - r as f64)
}

/// The value that the table contains: square roots, because light at dusk falls by orders of magnitude between two columns.
fn root(v: DVec3) -> DVec3 {
    v.map(|x| x.max(0.0).sqrt())
}

/// The table of a body's atmosphere: rows of heights from the ground up, then the row of the ground. Each value is a square root in the shader's unit, in
/// which 1 is the irradiance of a plane that faces the Sun, and the radiance of that plane if it is white. Uses all cores; `None` without an atmosphere.
pub fn table(body: &Body) -> Option<Vec<Vec4>> {
    let sphere =
        AirSphere { radius_km: body.radii_km.x, air: body.atmosphere.as_ref()?, ground_albedo: DVec3::from_array(body.mean_reflectance()) };
    let rows: Vec<DVec3> = (0..HEIGHTS * SUNS).into_par_iter().map(|k| sphere.node(k / SUNS, k % SUNS)).collect();
    let ground: Vec<DVec3> = (0..SUNS).into_par_iter().map(|c| sphere.ground_irradiance(&rows, c)).collect();
    let rows = rows.iter().map(|v| *v * PI);
    Some(rows.chain(ground).map(|v| camera::narrow(root(v)).extend(0.0)).collect())
}
