//! Multiply scattered light of an atmosphere, as a table over height and the Sun's zenith angle.
//!
//! In: a body with its atmosphere. Out: a table of [`NODES`] RGB values, all of them square roots and for sunlight of irradiance 1. One row for each height:
//! the radiance that light scattered twice or more adds to a view ray, divided by the ray's optical depth of scattering. One more row: the irradiance of level
//! ground by the entire sky. Then one row for each azimuth from the Sun's: the radiance of the sky that the waves of water mirror to a low view
//! (shaders/lib/air/skylight.wesl). Method: `diffuse_light` sums the diffuse light, which has been scattered or reflected by the ground at least once, over all
//! orders. What scatters again at a height is the mean of the diffuse light there over all directions, so the table has no directions: S. Hillaire's form of
//! multiple scattering (EGSR 2020), without its geometric series. The ground is a Lambert surface of the body's albedo. Not modelled: the directionality of
//! light scattered more than once, and differences in illumination between neighbouring places. Errors: tests/atmosphere/skylight.rs,
//! tests/scene/mirrored_sky.rs.

use crate::catalog::Body;
use crate::scene::atmosphere::air_sphere::{AirSphere, GROUND_CLEARANCE_KM, direction, ground_albedo, scattering_in_draws};
use crate::scene::atmosphere::diffuse_light::{DiffuseLight, SampleCounts};
use crate::scene::atmosphere::extinction::density;
use crate::scene::camera;
use crate::scene::constants::{MULTI_SCATTER_BEND as BEND, MULTI_SCATTER_FIRST_X as FIRST_COORDINATE};
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rows for the sky that water mirrors.
pub use crate::scene::constants::MIRRORED_SKY_AZIMUTHS;
/// Numbers of rows and of columns. Rows: heights spaced quadratically from the ground to the top. Columns: cosines of the Sun's zenith angle, densest at the
/// horizon (see [`sun_cosine`]).
pub use crate::scene::constants::{MULTI_SCATTER_COLUMNS as COLUMNS, MULTI_SCATTER_HEIGHTS as HEIGHTS};
/// One row per height, then one for the irradiance of level ground, then one per azimuth of the mirrored sky.
pub const NODES: usize = (HEIGHTS + 1 + MIRRORED_SKY_AZIMUTHS) * COLUMNS;
/// The source files that determine the table: an edit of one of them invalidates tables cached on disk. Other code of the program that these files use
/// supplies only the body's numbers, which are part of the cache key too, and the narrowing to f32.
pub(crate) const SOURCES: [&str; 6] = [
    include_str!("multi_scatter_table.rs"),
    include_str!("diffuse_light.rs"),
    include_str!("air_sphere.rs"),
    include_str!("extinction.rs"),
    include_str!("phase.rs"),
    include_str!("../constants.rs"),
];

/// Sampling of light scattered once, with the Sun above the horizon.
const BY_DAY: SampleCounts = SampleCounts { azimuths: 6, steps: 24 };
/// The same with the Sun below the horizon, when it lights only a small part of the sky.
const AT_DUSK: SampleCounts = SampleCounts { azimuths: 12, steps: 32 };
/// Directions, on the entire sphere, for the irradiance of the ground by light scattered once.
const GROUND_DIRECTIONS: usize = 1024;
/// Integration steps along each of these directions.
const GROUND_STEPS: usize = 48;
/// Column coordinate of the last column, the Sun in the zenith. `FIRST_COORDINATE` is that of the first column, the lowest Sun.
const LAST_COORDINATE: f64 = 1.0 / (1.0 + BEND);

/// Zenith cosines of the sky that the waves of water mirror to a horizontal view, each with a third of the light: altitudes of 6, 13 and 21 degrees. They are
/// the middles of the thirds of the distribution for waves of 5 m/s of wind (slopes of Cox & Munk 1954, weighted by the visible area of each facet and by
/// Fresnel's formulas). In azimuth the mirrored light comes from within 2 to 4 degrees (root mean square), which counts as one direction.
const MIRRORED_ZENITH_COSINES: [f64; 3] = [0.1, 0.22, 0.36];

/// Cosine of the Sun's zenith angle in a column. Columns are evenly spaced in their coordinate x = mu / (|mu| + BEND), with mu this cosine; the smaller
/// `BEND` is, the denser they are near the horizon.
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
    // Of one of the directions on the entire sphere, of which only the upper half are summed.
    let solid_angle = 2.0 * TAU / GROUND_DIRECTIONS as f64;
    // Factors with which the phase functions integrate to 1 over these directions.
    let norms = sphere.phase_norms(sun, directions(GROUND_DIRECTIONS).map(|d| (d, solid_angle)));
    let sky = directions(GROUND_DIRECTIONS).filter(|d| d.z > 0.0);
    // `.0`: the radiance. Where the ray would meet the ground (`.1`) does not matter here.
    let sum: DVec3 = sky.map(|along| sphere.single_scattering(from, along, GROUND_STEPS, sun, &norms).0 * along.z).sum();
    sum * solid_angle
}

/// The column coordinate of a zenith cosine: mu / (|mu| + BEND).
pub(crate) fn column_coordinate(cosine: f64) -> f64 {
    cosine / (cosine.abs() + BEND)
}

/// The table between its nodes, still a square root. `height_fraction`: the height divided by that of the top of the air. Nodes that a table lacks count as 0.
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

/// Azimuth of a row of the mirrored sky, from the Sun's.
pub fn mirrored_azimuth_rad(row: usize) -> f64 {
    let position = row as f64 / (MIRRORED_SKY_AZIMUTHS - 1) as f64;
    2.0 * (position * position).asin()
}

/// Radiance of the sky along a ray from the ground, in the shader's unit, at unit irradiance by the Sun. As in the drawn sky, light scattered more than once is
/// that of the rows of heights, `table`.
fn sky_radiance(sphere: &AirSphere<'_>, table: &[Vec4], along: DVec3, sun: DVec3) -> DVec3 {
    let from = DVec3::Z * (sphere.radius_km + GROUND_CLEARANCE_KM);
    // One direction is not a sum over directions, for which phase functions would need other factors.
    let norms = vec![DVec3::ONE; sphere.air.species.len()];
    let (once, _ground) = sphere.single_scattering(from, along, GROUND_STEPS, sun, &norms);
    let mut further_orders = DVec3::ZERO;
    sphere.follow(from, along, GROUND_STEPS, |p, transmitted_km| {
        let height_km = sphere.height_km(p);
        let scattering_per_km: DVec3 = sphere.air.species.iter().map(|s| scattering_in_draws(s) * density(s, height_km)).sum();
        let root = root_between(table, height_km / sphere.air.top_km, column_coordinate(p.normalize().dot(sun)));
        further_orders += transmitted_km * scattering_per_km * root * root;
    });
    once * PI + further_orders
}

/// A column of the rows of the mirrored sky: the mean radiance over [`MIRRORED_ZENITH_COSINES`] at each azimuth.
fn mirrored_column(sphere: &AirSphere<'_>, table: &[Vec4], column: usize) -> [DVec3; MIRRORED_SKY_AZIMUTHS] {
    let sun = direction(sun_cosine(column), 0.0);
    std::array::from_fn(|row| {
        let along = |cosine: &f64| direction(*cosine, mirrored_azimuth_rad(row));
        let sum: DVec3 = MIRRORED_ZENITH_COSINES.iter().map(|cosine| sky_radiance(sphere, table, along(cosine), sun)).sum();
        sum / MIRRORED_ZENITH_COSINES.len() as f64
    })
}

/// The table of a body's atmosphere: rows of heights from the ground up, the row of the ground's irradiance, the rows of the mirrored sky. Each value (xyz; w
/// is 0) is the square root of a radiance or irradiance in the shader's unit: the Sun's irradiance is 1, and so is the radiance of a white plane that faces the
/// Sun. Uses all cores; `None` without an atmosphere.
pub fn table(body: &Body) -> Option<Vec<Vec4>> {
    let sphere = AirSphere { radius_km: body.radii_km.x, air: body.atmosphere.as_ref()?, ground_albedo: ground_albedo(body) };
    let diffuse = DiffuseLight::of(&sphere);
    let columns: Vec<(Vec<DVec3>, DVec3)> = (0..COLUMNS).into_par_iter().map(|column| table_column(&sphere, &diffuse, column)).collect();
    // The shader's radiance is pi times the radiance per steradian.
    let rows = (0..HEIGHTS).flat_map(|row| columns.iter().map(move |(means, _)| means[row] * PI));
    let ground = columns.iter().map(|(_, ground)| *ground);
    let element = |v: DVec3| camera::narrow(root(v)).extend(0.0);
    let mut table: Vec<Vec4> = rows.chain(ground).map(element).collect();
    let mirrored: Vec<_> = (0..COLUMNS).into_par_iter().map(|column| mirrored_column(&sphere, &table, column)).collect();
    table.extend((0..MIRRORED_SKY_AZIMUTHS).flat_map(|row| mirrored.iter().map(move |sky| element(sky[row]))));
    Some(table)
}
