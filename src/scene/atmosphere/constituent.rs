//! One constituent of a spherical atmosphere: what its columns take from the light of a distant source.
//!
//! In: a species of the catalog's air, a point above the ground, and the zenith angle of the source there. Out: coefficients of the species, its column from
//! the point to the source, and whether the body itself hides the source.

use crate::catalog::{PhaseFunction, Species};
use crate::scene::atmosphere::air_sphere::scattering_in_draws;
use crate::scene::atmosphere::extinction::{column_above_km, density, extinction};
use crate::scene::atmosphere::phase;
use glam::DVec3;
use std::f64::consts::PI;

/// The edge of the body's shadow in the air is softened over this fraction of the air's height, so that it does not move from step to step in jumps.
const SHADOW_EDGE: f64 = 0.03;

/// Visible part of a source behind the ground: 1 above the horizon, 0 in the body's shadow. `from_centre_km`: the point's distance from the body's centre;
/// `cosine`: of the source's zenith angle at the point.
pub(super) fn visible_source_fraction(ground_radius_km: f64, top_km: f64, from_centre_km: f64, cosine: f64) -> f64 {
    if cosine >= 0.0 {
        return 1.0;
    }
    // Height at which the source's light passes closest to the body's centre.
    let closest_height_km = from_centre_km * (1.0 - cosine * cosine).max(0.0).sqrt() - ground_radius_km;
    (0.5 + closest_height_km / (SHADOW_EDGE * top_km)).clamp(0.0, 1.0)
}

/// The angle at the body's centre, from the direction of a distant source, from which on [`visible_source_fraction`] is 0 at every height of the air.
pub(super) fn dark_from_rad(ground_radius_km: f64, top_km: f64) -> f64 {
    let highest_dark_sine = (ground_radius_km - 0.5 * SHADOW_EDGE * top_km) / (ground_radius_km + top_km);
    PI - highest_dark_sine.clamp(0.0, 1.0).asin()
}

/// A species with what does not depend on the ray.
pub(super) struct Constituent<'a> {
    pub(super) species: &'a Species,
    pub(super) scattering: DVec3,
    pub(super) extinction: DVec3,
    /// 1 - m, where m is the mean cosine of the scattering angle (for some functions not the catalog's asymmetry). By the similarity relation, this scattering
    /// acts like isotropic scattering whose coefficient is smaller by this factor: the *reduced* scattering.
    pub(super) reduced_scattering_factor: DVec3,
}

impl<'a> Constituent<'a> {
    pub(super) fn of(species: &'a Species) -> Self {
        let mean_cosine = species.aerosol_phase().map_or(DVec3::ZERO, |aerosol| phase::mean_cosine(PhaseFunction::Aerosol(aerosol)));
        Self {
            species,
            scattering: scattering_in_draws(species),
            extinction: extinction(species),
            reduced_scattering_factor: DVec3::ONE - mean_cosine,
        }
    }

    /// Column of the species from a point outwards to a light source that is not behind the body. `from_centre_km`: the point's distance from the body's
    /// centre; `cosine`: of the source's zenith angle at the point.
    pub(super) fn column_to_light_km(&self, ground_radius_km: f64, from_centre_km: f64, cosine: f64) -> f64 {
        let (s, height_km) = (self.species, from_centre_km - ground_radius_km);
        // Distance of the line's lowest point from the body's centre. The ray to a source below the horizon passes this point.
        let closest_km = from_centre_km * (1.0 - cosine * cosine).max(0.0).sqrt();
        let closest_height_km = (closest_km - ground_radius_km).max(0.0);
        if let Some(centre_km) = s.tent_centre_km {
            // The vertical column, divided by the cosine of the ray's zenith angle where it crosses the middle of the layer; a ray that only grazes the layer
            // gets the smallest cosine. `scale_height_km` of a triangular layer is half its width.
            let layer_km = ground_radius_km + centre_km;
            let cosine_in_layer = (1.0 - (closest_km / layer_km).powi(2)).max(s.scale_height_km / layer_km).sqrt();
            let above_km = column_above_km(s, height_km);
            let vertical_km = if cosine >= 0.0 { above_km } else { 2.0 * column_above_km(s, closest_height_km) - above_km };
            return vertical_km / cosine_in_layer;
        }
        // Chapman's function, with the upper bound of the error function by Abramowitz & Stegun 1964, 7.1.13. It is exact for a horizontal ray.
        let erfc_argument_sq = cosine * cosine * from_centre_km / (2.0 * s.scale_height_km);
        let column_scale_km = density(s, height_km) * (2.0 * from_centre_km * s.scale_height_km).sqrt();
        let outwards_km = column_scale_km / (erfc_argument_sq.sqrt() + (erfc_argument_sq + 4.0 / PI).sqrt());
        if cosine >= 0.0 {
            return outwards_km;
        }
        // The column along the whole line, less the column from the point in the direction away from the source.
        let whole_line_km = density(s, closest_height_km) * (2.0 * PI * closest_km * s.scale_height_km).sqrt();
        (whole_line_km - outwards_km).max(0.0)
    }
}
