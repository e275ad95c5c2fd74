//! A body's spherical atmosphere over its ground: rays through it, and the light that they collect.
//!
//! In: the catalog's atmosphere. Out: per channel (linear RGB) the light that is scattered once into a ray, the sunlight that the ground reflects, and the
//! transmittance along rays. Positions (`p`, `from`) are relative to the body's centre, in km. Directions are unit vectors: `along` of a ray, `sun` towards the
//! Sun. Not modelled: refraction, the flattening of the body.

use crate::catalog::{Atmosphere, Body, Species};
use crate::scene::atmosphere::extinction::{coefficient, density, extinction, optical_depth, quadrature, scattering};
use crate::scene::atmosphere::phase;
use crate::scene::constants::MULTI_SCATTER_HEIGHTS;
use glam::DVec3;
use std::f64::consts::PI;

/// Integration steps towards the Sun.
const SUNLIGHT_STEPS: usize = 24;
/// Height at which rays that leave the ground start, so that rounding puts none of them below the ground: 10 cm.
pub(crate) const GROUND_CLEARANCE_KM: f64 = 1e-4;

/// Height of a row of the table of multiple scattering. Rows are spaced quadratically from the ground (row 0) to the top; a fraction is between rows.
pub(crate) fn row_height_km(air: &Atmosphere, row: f64) -> f64 {
    air.top_km * (row / (MULTI_SCATTER_HEIGHTS - 1) as f64).powi(2)
}

/// Direction with this zenith cosine and azimuth; the zenith is z.
pub(super) fn direction(cosine: f64, azimuth_rad: f64) -> DVec3 {
    let (sin, cos) = azimuth_rad.sin_cos();
    let across = (1.0 - cosine * cosine).max(0.0).sqrt();
    DVec3::new(across * cos, across * sin, cosine)
}

/// Scattering coefficient of a species where its [`density`] is 1, per km; zero for a triangular layer, because draws treat the light that such a layer
/// scatters as absorbed.
pub(super) fn scattering_in_draws(s: &Species) -> DVec3 {
    if s.tent_centre_km.is_some() { DVec3::ZERO } else { scattering(s) }
}

/// Albedo of the ground, linear RGB, at most 1. A geometric albedo may exceed 1, but with a ground that reflects more light than it receives, each order of
/// scattering in thick air could be brighter than the previous one, and their sum would diverge.
pub(super) fn ground_albedo(body: &Body) -> DVec3 {
    DVec3::from_array(body.mean_reflectance()).min(DVec3::ONE)
}

/// A body's spherical atmosphere.
pub(super) struct AirSphere<'a> {
    pub(super) radius_km: f64,
    pub(super) air: &'a Atmosphere,
    /// Albedo of the ground, linear RGB.
    pub(super) ground_albedo: DVec3,
}

/// Where a ray meets the ground.
pub(super) struct GroundHit {
    pub(super) point_km: DVec3,
    /// Transmittance from the ground to the start of the ray.
    pub(super) transmittance: DVec3,
}

impl AirSphere<'_> {
    /// Distance in km from a point along a ray to where the ray leaves the air; and whether that is at the ground, otherwise at the top of the atmosphere.
    fn distance_to_boundary(&self, p: DVec3, along: DVec3) -> (f64, bool) {
        // Positions on the ray, in km, are counted from the point of its line that is nearest to the centre, at the squared distance `nearest_sq`. The line
        // enters a sphere half a chord before this point, and leaves it half a chord after it.
        let start = p.dot(along);
        let nearest_sq = p.length_squared() - start * start;
        let half_ground_chord_sq = self.radius_km * self.radius_km - nearest_sq;
        if start < 0.0 && half_ground_chord_sq > 0.0 {
            return ((-start - half_ground_chord_sq.sqrt()).max(0.0), true);
        }
        let half_top_chord_sq = (self.radius_km + self.air.top_km).powi(2) - nearest_sq;
        ((-start + half_top_chord_sq.max(0.0).sqrt()).max(0.0), false)
    }

    /// Height of a point above the ground.
    pub(super) fn height_km(&self, p: DVec3) -> f64 {
        (p.length() - self.radius_km).max(0.0)
    }

    /// Transmittance towards the Sun; 0 through the planet.
    fn sun_transmittance(&self, p: DVec3, sun: DVec3) -> DVec3 {
        let (length_km, hits_ground) = self.distance_to_boundary(p, sun);
        if hits_ground {
            return DVec3::ZERO;
        }
        let depth = optical_depth(self.air, length_km, SUNLIGHT_STEPS, |s_km| self.height_km(p + sun * s_km));
        depth.map(|d| (-d).exp())
    }

    /// Follows a ray in `count` steps, and returns where it meets the ground, if it does. Calls `add` for each step: with a point of the step, and with the
    /// step's length in km times the mean transmittance from the step to the start of the ray. For sunlight, this product times the scattering coefficient, the
    /// phase function and the Sun's irradiance at the point is the radiance that reaches the start.
    pub(super) fn follow(&self, from: DVec3, along: DVec3, count: usize, mut add: impl FnMut(DVec3, DVec3)) -> Option<GroundHit> {
        let (length_km, hits_ground) = self.distance_to_boundary(from, along);
        let mut transmittance = DVec3::ONE;
        let mut take_step = |fraction: f64, weight: f64| {
            let point = from + along * (length_km * fraction);
            let step_km = length_km * weight;
            let depth = coefficient(self.air, self.height_km(point), extinction) * step_km;
            // Mean transmittance from the start of the step to its points: (1 - exp(-d)) / d, which is 1 for d = 0.
            let mean_transmittance = depth.map(|d| if d > 1e-6 { -(-d).exp_m1() / d } else { 1.0 });
            add(point, transmittance * mean_transmittance * step_km);
            transmittance *= depth.map(|d| (-d).exp());
        };
        // Steps are shortest where the air is densest: at the ground if the ray meets it, otherwise at its start.
        if hits_ground {
            quadrature(count).rev().for_each(|(from_ground, weight)| take_step(1.0 - from_ground, weight));
        } else {
            quadrature(count).for_each(|(fraction, weight)| take_step(fraction, weight));
        }
        hits_ground.then(|| GroundHit { point_km: from + along * length_km, transmittance })
    }

    /// Radiance of the light scattered once that arrives along a ray, divided by the Sun's irradiance, per steradian (shaders multiply it by pi); and where the
    /// ray meets the ground, if it does. `count`: integration steps. `norms`: a factor for the phase function of each species (see [`Self::phase_norms`]).
    pub(super) fn single_scattering(
        &self,
        from: DVec3,
        along: DVec3,
        count: usize,
        sun: DVec3,
        norms: &[DVec3],
    ) -> (DVec3, Option<GroundHit>) {
        let species = self.air.species.iter();
        // The scattering angle is the same at all points of the ray.
        let into_ray: Vec<DVec3> = species
            .clone()
            .zip(norms)
            .map(|(s, norm)| scattering_in_draws(s) * *norm * phase::per_steradian(s.phase, along.dot(sun)))
            .collect();
        let mut light = DVec3::ZERO;
        let ground = self.follow(from, along, count, |p, transmitted_km| {
            let height_km = self.height_km(p);
            let scattered: DVec3 = species.clone().zip(&into_ray).map(|(s, into_ray)| *into_ray * density(s, height_km)).sum();
            light += transmitted_km * scattered * self.sun_transmittance(p, sun);
        });
        (light, ground)
    }

    /// For each species and channel, the factor that normalises its phase function over discrete directions: one over the sum of the function's values times
    /// the solid angles. Without this factor the sum would not be 1, because the narrow peak of a forward-scattering aerosol lies between the directions or on
    /// one of them. `directions`: each with its solid angle. The solid angles sum to 4 pi; a direction that also stands for its mirror image has twice its
    /// solid angle. A sum near 0 is raised, so that the factor stays finite.
    pub(super) fn phase_norms(&self, sun: DVec3, directions: impl Iterator<Item = (DVec3, f64)> + Clone) -> Vec<DVec3> {
        let sum =
            |s: &Species| directions.clone().map(|(d, solid_angle)| phase::per_steradian(s.phase, d.dot(sun)) * solid_angle).sum::<DVec3>();
        self.air.species.iter().map(|s| 1.0 / sum(s).max(DVec3::splat(1e-9))).collect()
    }

    /// Radiance of the ground in direct sunlight, divided by the irradiance of the Sun, per steradian.
    pub(super) fn reflected(&self, ground_point: DVec3, sun: DVec3) -> DVec3 {
        let up = ground_point.normalize();
        let above = up * (self.radius_km + GROUND_CLEARANCE_KM);
        self.ground_albedo * self.sun_transmittance(above, sun) * (up.dot(sun).max(0.0) / PI)
    }
}
