//! The irradiance at the viewer from an entire body (globe and rings), at any phase angle.
//!
//! In: the body, and the positions of the viewer and of the Sun or another light. Out: [`Irradiance`]. Left out: eclipses. Errors: 0.2 magnitudes for globes,
//! 0.15 for Saturn with rings (tests/scene/magnitudes.rs). Ring-shine fades in between two phase angles (`SHINE_FADE_IN_RAD`), so views from the Earth
//! do not need its tables. At greater phase angles every magnitude needs them, even if the user has switched off the rings or their light, because a magnitude
//! is that of the real body.

use crate::catalog::{Body, Ring};
use crate::scene::light::{disc_light, ellipsoid, photometry};
use crate::scene::numeric::smooth_rise;
use crate::scene::request::effects::Effect;
use crate::scene::resources::Caches;
use crate::scene::rings::ring_light::{self, RingLight, SHINE_FADE_IN_RAD};
use crate::scene::rings::ring_shine::RingShineGeometry;
use crate::units::{KM_PER_AU, SUN_RADIUS_KM, luminance};
use glam::DVec3;

/// Ring-shine is left out if the upper limit of its irradiance on the globe, per unit of sunlight, is below this. The limit is 1.4 for Saturn, 0.0005 for
/// Uranus.
const MIN_RING_SHINE: f64 = 0.01;

/// Irradiance at the viewer, in units of the Sun's at 1 au.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Irradiance {
    /// Light of the ground, as a luminance; its colour is that of the body.
    of_ground: f64,
    /// Light of the air (for the Earth, of the air and of the glint on the sea), linear RGB ([`disc_light::ground_and_air_irradiance`]).
    of_air: DVec3,
    /// Light of the rings, linear RGB.
    of_rings: DVec3,
    /// Light that the rings scatter onto the globe, linear RGB.
    of_ring_shine: DVec3,
}

impl Irradiance {
    /// The irradiance as an image shows it: without the light of the air if the air is switched off. `shows` tells whether the image may draw an effect. For
    /// the Earth, `of_air` is one table for air and glint, mostly of the glint, and stays until both are off.
    pub(crate) fn with_shown_air(self, body: &Body, shows: impl Fn(Effect) -> bool) -> Self {
        let is_shown = shows(Effect::Atmosphere) || body.maps.specular.is_some() && shows(Effect::Specular);
        if is_shown { self } else { Self { of_air: DVec3::ZERO, ..self } }
    }

    /// This irradiance without ring-shine.
    pub(crate) fn without_ring_shine(self) -> Self {
        Self { of_ring_shine: DVec3::ZERO, ..self }
    }

    /// Its luminance.
    pub(crate) fn luminance(self) -> f64 {
        self.of_ground + luminance((self.of_air + self.of_rings + self.of_ring_shine).to_array())
    }

    /// The part of its luminance that comes from the globe, in the light of the Sun alone: without rings and ring-shine. 0 without any light.
    pub(crate) fn globe_fraction(self) -> f64 {
        let total = self.luminance();
        if total > 0.0 { (self.of_ground + luminance(self.of_air.to_array())) / total } else { 0.0 }
    }

    /// Its colour, linear RGB.
    pub(crate) fn rgb(self, body: &Body) -> DVec3 {
        body.colour.as_dvec3() * self.of_ground + self.of_air + self.of_rings + self.of_ring_shine
    }
}

/// Irradiance from the globe, without its rings and their shadow. For an elongated body it depends on the sides that face the Sun and the viewer
/// ([`ellipsoid`]). Parameters as for [`irradiance`].
pub(crate) fn globe_irradiance(body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> Irradiance {
    let outline_radius_sq_km2 = photometry::projected_radius_sq_km2(body.radii_km, viewer_km.normalize());
    let (sun_distance_km, viewer_distance_km) = (sun_distance_km(sun_km), viewer_km.length());
    // `of_uniform_ground`: as if the albedo were the same everywhere; `light_curve` is the factor of bright and dark sides.
    let (mut of_uniform_ground, of_air) =
        disc_light::ground_and_air_irradiance(body, phase_angle_rad, sun_distance_km, viewer_distance_km, outline_radius_sq_km2);
    // Only of elongated bodies that reflect and have no published phase law. The formula is that of `disc_light::irradiance_per_mean_radiance`.
    if let Some(phase_times_radius_sq) = ellipsoid::phase_times_radius_sq_km2(body, sun_km.normalize_or_zero(), viewer_km.normalize()) {
        of_uniform_ground = body.geometric_albedo * phase_times_radius_sq * (KM_PER_AU / (sun_distance_km * viewer_distance_km)).powi(2);
    }
    Irradiance {
        of_ground: of_uniform_ground * photometry::light_curve(body, sun_km.normalize_or_zero(), viewer_km.normalize()),
        of_air,
        of_rings: DVec3::ZERO,
        of_ring_shine: DVec3::ZERO,
    }
}

/// Distance of the Sun; at least 1 km, because the body may be the Sun itself.
fn sun_distance_km(sun_km: DVec3) -> f64 {
    sun_km.length().max(1.0)
}

/// Mean radiance, under a sunlight of irradiance 1, that ring-shine gives a disc of the equatorial radius, linear RGB. `sun_km`: as for
/// [`irradiance`]; `viewer`: unit vector, body axes.
fn ring_shine_radiance(caches: &Caches, body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer: DVec3) -> DVec3 {
    let weight = smooth_rise(SHINE_FADE_IN_RAD, phase_angle_rad);
    if weight <= 0.0 {
        return DVec3::ZERO;
    }
    let rings: Vec<&Ring> = body.rings.iter().filter(|r| r.tau_normal > 0.0).collect();
    let sun = sun_km.normalize();
    let geometry = RingShineGeometry::of(body, &rings, sun, sun_km.length(), SUN_RADIUS_KM);
    let shine = if geometry.upper_limit() < MIN_RING_SHINE { None } else { geometry.shine(&caches.ring_shines) };
    let Some(shine) = shine else { return DVec3::ZERO };
    // Under ring-shine the ground is drawn as a Lambert surface, without the factor that makes a sunlit disc as bright as its published phase law.
    let ground_radiance = photometry::albedo_normalisation(body) * body.geometric_albedo * body.colour.as_dvec3();
    ground_radiance * ring_light::seen_ring_shine(&caches.ring_tables, body, &shine, sun, viewer) * weight
}

/// Irradiance from globe and rings. `phase_angle_rad`: Sun-body-viewer. `sun_km` and `viewer_km`: positions relative to the body's centre, body axes.
pub(crate) fn irradiance(caches: &Caches, body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> Irradiance {
    let of_globe = globe_irradiance(body, phase_angle_rad, sun_km, viewer_km);
    // The Sun's position relative to itself is zero.
    if body.rings.is_empty() || sun_km == DVec3::ZERO {
        return of_globe;
    }
    let (viewer_distance_km, viewer, sun_distance_km) = (viewer_km.length(), viewer_km.normalize(), sun_distance_km(sun_km));
    let rings = RingLight::of(&caches.ring_tables, body, sun_km.normalize(), viewer);
    // As `disc_light::irradiance_per_mean_radiance`, for a disc of the equatorial radius, to which `ring_albedo` and ring-shine are relative: the factor from
    // its mean radiance under a sunlight of irradiance 1 to the irradiance at the viewer.
    let irradiance_per_mean_radiance = (body.radii_km.x / viewer_distance_km * KM_PER_AU / sun_distance_km).powi(2);
    Irradiance {
        of_ground: of_globe.of_ground * rings.globe_light_fraction,
        of_air: of_globe.of_air * rings.globe_light_fraction,
        of_rings: rings.ring_albedo * irradiance_per_mean_radiance,
        of_ring_shine: ring_shine_radiance(caches, body, phase_angle_rad, sun_km, viewer) * irradiance_per_mean_radiance,
    }
}
