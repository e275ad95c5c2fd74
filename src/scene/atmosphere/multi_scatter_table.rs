//! Multiply scattered light of an atmosphere, as a table over height and the Sun's zenith angle.
//!
//! In: a body with its atmosphere. Out: [`NODES`] square roots. One row for each height holds roots of the radiance that light scattered twice or more adds to
//! a view ray, per scattering optical depth of the ray and per irradiance of the Sun. One more row holds roots of the irradiance of level ground by the entire
//! sky, per irradiance of the Sun. Method: `diffuse_light` sums all orders of scattering. The light that scatters again at a height is the mean of the diffuse
//! light there over all directions, so the table has no directions: S. Hillaire's form of multiple scattering (EGSR 2020), without its geometric series. The
//! ground is a Lambert surface of the body's albedo. Not modelled: the directionality of light scattered more than once, and differences in illumination
//! between neighbouring places. Errors: tests/atmosphere/skylight.rs.

use crate::catalog::Body;
use crate::scene::atmosphere::air_sphere::{AirSphere, GROUND_CLEARANCE_KM, direction, ground_albedo};
use crate::scene::atmosphere::diffuse_light::{DiffuseLight, SampleCounts};
use crate::scene::camera;
use crate::scene::constants::{MULTI_SCATTER_BEND as BEND, MULTI_SCATTER_FIRST_X as FIRST_COORDINATE};
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Numbers of rows and of columns. Rows: heights spaced quadratically from the ground to the top. Columns: cosines of the Sun's zenith angle, densest at the
/// horizon.
pub use crate::scene::constants::{MULTI_SCATTER_COLUMNS as COLUMNS, MULTI_SCATTER_HEIGHTS as HEIGHTS};
/// One row per height, then one for the irradiance of level ground.
pub const NODES: usize = (HEIGHTS + 1) * COLUMNS;
/// The source files that determine the table: an edit of one of them invalidates tables cached on disk. From the rest of the program they use only the
/// body's numbers, which are part of the cache key too, and the narrowing to f32.
pub(crate) const SOURCES: [&str; 6] = [
    include_str!("multi_scatter_table.rs"),
    include_str!("diffuse_light.rs"),
    include_str!("air_sphere.rs"),
    include_str!("extinction.rs"),
    include_str!("phase.rs"),
    include_str!("../constants.rs"),
];

/// Sampling with the Sun above the horizon.
const BY_DAY: SampleCounts = SampleCounts { azimuths: 6, steps: 24 };
/// Sampling with the Sun below the horizon, when it lights only a small part of the sky.
const AT_DUSK: SampleCounts = SampleCounts { azimuths: 12, steps: 32 };
/// Directions of the sphere, and integration steps along each, for the irradiance of the ground by light scattered once.
const GROUND_DIRECTIONS: usize = 1024;
const GROUND_STEPS: usize = 48;
/// Column coordinate of the last column, the Sun in the zenith. `FIRST_COORDINATE` is that of the first column, the lowest Sun.
const LAST_COORDINATE: f64 = 1.0 / (1.0 + BEND);

/// Cosine of the Sun's zenith angle in a column. Columns are evenly spaced in their coordinate x = mu / (|mu| + BEND), with mu this cosine.
pub fn sun_cosine(column: usize) -> f64 {
    let x = FIRST_COORDINATE + (LAST_COORDINATE - FIRST_COORDINATE) * column as f64 / (COLUMNS - 1) as f64;
    BEND * x / (1.0 - x.abs())
}

/// Directions of a Fibonacci lattice on the sphere.
fn directions(count: usize) -> impl Iterator<Item = DVec3> + Clone {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (PI * (1.0 + 5.0f64.sqrt()) * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    })
}

/// Irradiance of level ground by skylight that was scattered once, per irradiance of the Sun.
fn ground_irradiance_once(sphere: &AirSphere<'_>, sun: DVec3) -> DVec3 {
    let from = DVec3::Z * (sphere.radius_km + GROUND_CLEARANCE_KM);
    // The directions are distributed over the entire sphere.
    let solid_angle = 2.0 * TAU / GROUND_DIRECTIONS as f64;
    let norms = sphere.phase_norms(sun, directions(GROUND_DIRECTIONS).map(|d| (d, solid_angle)));
    let sky = directions(GROUND_DIRECTIONS).filter(|d| d.z > 0.0);
    let sum: DVec3 = sky.map(|along| sphere.single_scattering(from, along, GROUND_STEPS, sun, &norms).0 * along.z).sum();
    sum * solid_angle
}

/// The column coordinate of a zenith cosine: mu / (|mu| + BEND).
pub(crate) fn column_coordinate(cosine: f64) -> f64 {
    cosine / (cosine.abs() + BEND)
}

/// Interpolates the square roots of a table. `height_fraction`: the height divided by that of the top of the air. 0 for a truncated table.
pub(crate) fn root_between(table: &[Vec4], height_fraction: f64, column_coordinate: f64) -> DVec3 {
    between_nodes(height_fraction, column_coordinate, |k| table.get(k).map_or(DVec3::ZERO, |v| v.truncate().as_dvec3()))
}

/// Bilinear interpolation between the nodes of the table. `height_fraction`: as in [`root_between`]. `node`: the value of node row * COLUMNS + column.
fn between_nodes(height_fraction: f64, column_coordinate: f64, node: impl Fn(usize) -> DVec3) -> DVec3 {
    let row = height_fraction.clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f64;
    let last_column = (COLUMNS - 1) as f64;
    let column = ((column_coordinate - FIRST_COORDINATE) / (LAST_COORDINATE - FIRST_COORDINATE) * last_column).clamp(0.0, last_column);
    let (r, c) = ((row as usize).min(HEIGHTS - 2), (column as usize).min(COLUMNS - 2));
    let in_row = |r: usize| node(r * COLUMNS + c).lerp(node(r * COLUMNS + c + 1), column - c as f64);
    in_row(r).lerp(in_row(r + 1), row - r as f64)
}

/// The value that the table contains: square roots, because light at dusk falls by orders of magnitude between two columns.
fn root(v: DVec3) -> DVec3 {
    v.map(|x| x.max(0.0).sqrt())
}

/// A column of the table: the mean radiance of diffuse light at each height, and the irradiance of level ground by the sky.
fn table_column(sphere: &AirSphere<'_>, diffuse: &DiffuseLight<'_>, column: usize) -> (Vec<DVec3>, DVec3) {
    let azimuth_rad = 0.0;
    let sun = direction(sun_cosine(column), azimuth_rad);
    let field = diffuse.field(sun, if sun.z > 0.0 { BY_DAY } else { AT_DUSK });
    let means = (0..HEIGHTS).map(|row| diffuse.mean_radiance(&field, row)).collect();
    (means, ground_irradiance_once(sphere, sun) + diffuse.irradiance_by_further_orders(&field))
}

/// The table of a body's atmosphere: rows of heights from the ground up, then the row of the ground. Each value is a square root in the shader's unit, in
/// which 1 is the irradiance of a plane that faces the Sun, and the radiance of that plane if it is white. Uses all cores; `None` without an atmosphere.
pub fn table(body: &Body) -> Option<Vec<Vec4>> {
    let sphere = AirSphere { radius_km: body.radii_km.x, air: body.atmosphere.as_ref()?, ground_albedo: ground_albedo(body) };
    let diffuse = DiffuseLight::of(&sphere);
    let columns: Vec<(Vec<DVec3>, DVec3)> = (0..COLUMNS).into_par_iter().map(|column| table_column(&sphere, &diffuse, column)).collect();
    // In the shader's unit, a radiance is multiplied by pi.
    let rows = (0..HEIGHTS).flat_map(|row| columns.iter().map(move |(means, _)| means[row] * PI));
    let ground = columns.iter().map(|(_, ground)| *ground);
    Some(rows.chain(ground).map(|v| camera::narrow(root(v)).extend(0.0)).collect())
}
