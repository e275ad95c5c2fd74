//! Light that air has scattered more than once, as a table over height and the Sun's height.
//!
//! In: a body with its atmosphere. Out: [`NODES`] values of sky light per unit of sunlight. Method (S. Hillaire, EGSR 2020): light of the second
//! order is summed over directions with an even phase function, and each further order is the one before times the part that scatters
//! again nearby, a geometric series. The ground reflects as an even white plane of the body's albedo. Left out: the directions of the higher
//! orders, and that light spreads sideways further than the air around a point looks the same.

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::extinction::{self, density, extinction, optical_depth, scattering, steps};
use crate::scene::camera;
use glam::{DVec3, Vec4};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Heights, growing as squares from the ground to the top; cosines of the Sun's distance from the zenith, close together at the horizon.
pub use crate::scene::constants::{MULTIPLE_HEIGHTS as HEIGHTS, MULTIPLE_SUNS as SUNS};
/// The heights' rows, then one of the light that falls on level ground.
pub const NODES: usize = (HEIGHTS + 1) * SUNS;
/// The sources that decide which table an atmosphere gets: an edit of one of them makes tables that are kept on disk stale. What they take from the
/// rest of the program are the body's numbers, which name a kept table too, and the narrowing to f32.
pub const SOURCES: [&str; 3] = [include_str!("air_table.rs"), include_str!("extinction.rs"), include_str!("../constants.rs")];

/// Directions over the sphere and steps along each, by day.
const BY_DAY: SamplingQuality = SamplingQuality { directions: 64, steps: 24 };
/// Under the horizon the Sun lights little of the sky: with the day's resolution the light of the ground at 12 degrees was a thirtieth of what the sky sends.
const BY_DUSK: SamplingQuality = SamplingQuality { directions: 192, steps: 32 };
/// For the one row of the ground.
const ON_GROUND: SamplingQuality = SamplingQuality { directions: 1024, steps: 48 };
/// On the way to the Sun.
const STEPS: usize = 24;
/// The part that scatters again stays under this, so that the series ends.
const MAX_AGAIN: f64 = 0.98;
/// Columns lie evenly in x = mu / (|mu| + BEND), from FIRST to 1 / (1 + BEND).
use crate::scene::constants::{MULTIPLE_BEND as BEND, MULTIPLE_FIRST as FIRST};

#[derive(Clone, Copy)]
struct SamplingQuality {
    directions: usize,
    steps: usize,
}

/// The body's air in shells.
struct Shells<'a> {
    radius_km: f64,
    air: &'a Atmosphere,
    /// Linear RGB.
    ground: DVec3,
}

/// Cosine of the Sun's distance from the zenith in a column.
pub fn sun_cosine(column: usize) -> f64 {
    let x = FIRST + (1.0 / (1.0 + BEND) - FIRST) * column as f64 / (SUNS - 1) as f64;
    BEND * x / (1.0 - x.abs())
}

fn height_km(air: &Atmosphere, row: usize) -> f64 {
    air.top_km * (row as f64 / (HEIGHTS - 1) as f64).powi(2)
}

/// Even directions over the sphere.
fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (PI * (1.0 + 5.0f64.sqrt()) * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    })
}

/// Towards a Sun of this cosine from the zenith, which is z.
fn towards_sun(cosine: f64) -> DVec3 {
    DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine)
}

fn each(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

/// What comes along one ray.
struct Ray {
    /// Light scattered towards the eye by `source`, times the transmittance to it.
    light: DVec3,
    /// What would come if the whole air shone with 1.
    again: DVec3,
    through: DVec3,
    /// Where it meets the ground.
    ground: Option<DVec3>,
}

impl Shells<'_> {
    /// Way from a point to the ground (true) or out of the air.
    fn reach(&self, p: DVec3, along: DVec3) -> (f64, bool) {
        let b = p.dot(along);
        let low = p.length_squared() - b * b;
        let ground = self.radius_km * self.radius_km - low;
        if b < 0.0 && ground > 0.0 {
            return ((-b - ground.sqrt()).max(0.0), true);
        }
        let top = (self.radius_km + self.air.top_km).powi(2) - low;
        ((-b + top.max(0.0).sqrt()).max(0.0), false)
    }

    fn height(&self, p: DVec3) -> f64 {
        (p.length() - self.radius_km).max(0.0)
    }

    fn sum(&self, height_km: f64, what: fn(&crate::catalog::Species) -> DVec3) -> DVec3 {
        extinction::sum(self.air, height_km, what)
    }

    /// Transmittance towards the Sun; none through the planet.
    fn sunlight(&self, p: DVec3, sun: DVec3) -> DVec3 {
        let (way, hits) = self.reach(p, sun);
        if hits {
            return DVec3::ZERO;
        }
        let depth = optical_depth(self.air, way, STEPS, |s_km| self.height(p + sun * s_km));
        each(depth, |d| (-d).exp())
    }

    /// `source`: radiance per unit of scattering at a place.
    fn ray(&self, from: DVec3, along: DVec3, count: usize, source: impl Fn(DVec3) -> DVec3) -> Ray {
        let (way, hits) = self.reach(from, along);
        let mut ray = Ray { light: DVec3::ZERO, again: DVec3::ZERO, through: DVec3::ONE, ground: hits.then(|| from + along * way) };
        for (at, part) in steps(count) {
            let p = from + along * (way * at);
            let height = self.height(p);
            let depth = self.sum(height, extinction) * (way * part);
            let cell = each(depth, |d| if d > 1e-6 { -(-d).exp_m1() / d } else { 1.0 });
            let scattered = ray.through * self.sum(height, scattering) * cell * (way * part);
            ray.light += scattered * source(p);
            ray.again += scattered;
            ray.through *= each(depth, |d| (-d).exp());
        }
        ray
    }

    /// Mean radiance from all sides of all orders after the first.
    fn node(&self, row: usize, column: usize) -> DVec3 {
        // A finger's breadth above the ground, so that no ray begins under it.
        let from = DVec3::Z * (self.radius_km + height_km(self.air, row).max(1e-4));
        let sun = towards_sun(sun_cosine(column));
        let fine = if sun.z > 0.0 { BY_DAY } else { BY_DUSK };
        let (mut second, mut again) = (DVec3::ZERO, DVec3::ZERO);
        for along in directions(fine.directions) {
            let ray = self.ray(from, along, fine.steps, |p| self.sunlight(p, sun) / (4.0 * PI));
            second += ray.light + ray.ground.map_or(DVec3::ZERO, |g| ray.through * self.reflected(g, sun));
            again += ray.again;
        }
        let again = again / fine.directions as f64;
        second / fine.directions as f64 / each(again, |a| 1.0 - a.min(MAX_AGAIN))
    }

    /// Radiance of the ground in direct sunlight.
    fn reflected(&self, at: DVec3, sun: DVec3) -> DVec3 {
        let up = at.normalize();
        let above = up * (self.radius_km + 1e-4);
        self.ground * self.sunlight(above, sun) * (up.dot(sun).max(0.0) / PI)
    }

    /// Irradiance of level ground by the sky.
    fn on_ground(&self, rows: &[DVec3], column: usize) -> DVec3 {
        let from = DVec3::Z * (self.radius_km + 1e-4);
        let sun = towards_sun(sun_cosine(column));
        let mut sum = DVec3::ZERO;
        for along in directions(ON_GROUND.directions).filter(|d| d.z > 0.0) {
            let cos = along.dot(sun);
            let many = self.ray(from, along, ON_GROUND.steps, |p| self.at(rows, self.height(p), p.normalize().dot(sun))).light;
            let once: DVec3 = self.once(from, along, sun, cos);
            sum += (many + once) * along.z;
        }
        sum * (2.0 * TAU / ON_GROUND.directions as f64)
    }

    /// Light scattered once, each species by its own phase function.
    fn once(&self, from: DVec3, along: DVec3, sun: DVec3, cos: f64) -> DVec3 {
        let phases = |s: &crate::catalog::Species| match s.asymmetry {
            None => 3.0 / (16.0 * PI) * (1.0 + cos * cos),
            Some(g) => (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).max(1e-6).powf(1.5)),
        };
        let source = |p: DVec3| {
            let height = self.height(p);
            let all = self.sum(height, scattering).max(DVec3::splat(1e-30));
            let turned: DVec3 = self.air.species.iter().map(|s| scattering(s) * (density(s, height) * phases(s))).sum();
            self.sunlight(p, sun) * turned / all
        };
        self.ray(from, along, ON_GROUND.steps, source).light
    }

    /// The table between its nodes, as the shader reads it.
    fn at(&self, rows: &[DVec3], height_km: f64, cosine: f64) -> DVec3 {
        let row = (height_km / self.air.top_km).clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f64;
        let x = cosine / (cosine.abs() + BEND);
        let column = ((x - FIRST) / (1.0 / (1.0 + BEND) - FIRST) * (SUNS - 1) as f64).clamp(0.0, (SUNS - 1) as f64);
        let (r, c) = ((row as usize).min(HEIGHTS - 2), (column as usize).min(SUNS - 2));
        let along = |r: usize| root(rows[r * SUNS + c]).lerp(root(rows[r * SUNS + c + 1]), column - c as f64);
        let mean = along(r).lerp(along(r + 1), row - r as f64);
        mean * mean
    }
}

/// Where a cosine lies among the columns: in mu / (|mu| + BEND).
pub fn place(cosine: f64) -> f64 {
    cosine / (cosine.abs() + BEND)
}

/// The square root that a table holds at a part of the height to the top and a place among the columns; nothing from a table cut short.
pub fn root_between(table: &[Vec4], part: f64, place: f64) -> DVec3 {
    let row = part.clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f64;
    let column = ((place - FIRST) / (1.0 / (1.0 + BEND) - FIRST) * (SUNS - 1) as f64).clamp(0.0, (SUNS - 1) as f64);
    let (r, c) = ((row as usize).min(HEIGHTS - 2), (column as usize).min(SUNS - 2));
    let node = |r: usize, c: usize| table.get(r * SUNS + c).map_or(DVec3::ZERO, |v| v.truncate().as_dvec3());
    let along = |r: usize| node(r, c).lerp(node(r, c + 1), column - c as f64);
    along(r).lerp(along(r + 1), row - r as f64)
}

/// Interpolated are the square roots: the light of a dusk falls by orders between two columns.
fn root(v: DVec3) -> DVec3 {
    each(v, |x| x.max(0.0).sqrt())
}

/// The table of a body's air, rows of heights from the ground up, then the row of the ground. Of each value the square root, in the shader's
/// unit: 1 is the radiance of a white plane that faces the Sun. All cores work on it; `None` without air.
pub fn table(body: &Body) -> Option<Vec<Vec4>> {
    let shells =
        Shells { radius_km: body.radii_km.x, air: body.atmosphere.as_ref()?, ground: DVec3::from_array(body.target_mean_colour()) };
    let rows: Vec<DVec3> = (0..HEIGHTS * SUNS).into_par_iter().map(|k| shells.node(k / SUNS, k % SUNS)).collect();
    let ground: Vec<DVec3> = (0..SUNS).into_par_iter().map(|c| shells.on_ground(&rows, c)).collect();
    let rows = rows.iter().map(|v| *v * PI);
    Some(rows.chain(ground).map(|v| camera::narrow(root(v)).extend(0.0)).collect())
}
