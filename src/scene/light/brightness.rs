//! The irradiance at the viewer from an entire body (globe and rings), at any phase angle.
//!
//! In: the body, and the positions of the viewer and of the Sun or another light. Out: [`Irradiance`]. Left out: eclipses. Errors: 0.2 magnitudes for globes,
//! 0.15 for Saturn with rings (tests/scene/magnitudes.rs).

use crate::catalog::Body;
use crate::scene::light::{disc_light, ellipsoid, photometry};
use crate::scene::rings::ring_light::RingLight;
use crate::scene::rings::ring_table::RingTables;
use crate::units::{KM_PER_AU, luminance};
use glam::DVec3;

/// Irradiance at the viewer, in units of the Sun's at 1 au.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Irradiance {
    /// Luminance of the light of the ground, which has the body's colour.
    of_ground: f64,
    /// Light of the air, linear RGB ([`disc_light::ground_and_air_irradiance`]).
    of_air: DVec3,
    /// Light of the rings, linear RGB.
    of_rings: DVec3,
}

impl Irradiance {
    /// The same without the light that the air adds.
    pub(crate) fn without_air(self) -> Self {
        Self { of_air: DVec3::ZERO, ..self }
    }

    /// Its luminance.
    pub(crate) fn luminance(self) -> f64 {
        self.of_ground + luminance((self.of_air + self.of_rings).to_array())
    }

    /// Its colour, linear RGB.
    pub(crate) fn rgb(self, body: &Body) -> DVec3 {
        body.colour.as_dvec3() * self.of_ground + self.of_air + self.of_rings
    }
}

/// Irradiance from the globe, without its rings and their shadow; that of an elongated body depends on the sides that face the Sun and the viewer
/// ([`ellipsoid`]). Parameters as for [`irradiance`].
pub(crate) fn globe_irradiance(body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> Irradiance {
    let radius_sq_km2 = photometry::projected_radius_sq_km2(body.radii_km, viewer_km.normalize());
    let (alpha, sun_distance_km, viewer_distance_km) = (phase_angle_rad, sun_distance_km(sun_km), viewer_km.length());
    let (mut of_uniform_ground, of_air) =
        disc_light::ground_and_air_irradiance(body, alpha, sun_distance_km, viewer_distance_km, radius_sq_km2);
    if let Some(phase_times_radius_sq) = ellipsoid::phase_times_radius_sq_km2(body, sun_km.normalize_or_zero(), viewer_km.normalize()) {
        of_uniform_ground = body.geometric_albedo * phase_times_radius_sq * (KM_PER_AU / (sun_distance_km * viewer_distance_km)).powi(2);
    }
    Irradiance {
        of_ground: of_uniform_ground * photometry::light_curve(body, sun_km.normalize_or_zero(), viewer_km.normalize()),
        of_air,
        of_rings: DVec3::ZERO,
    }
}

/// At least 1 km, because the body may be the Sun itself.
fn sun_distance_km(sun_km: DVec3) -> f64 {
    sun_km.length().max(1.0)
}

/// Irradiance from globe and rings. `phase_angle_rad`: Sun-body-viewer. `sun_km` and `viewer_km`: positions relative to the body's centre, body axes.
pub(crate) fn irradiance(ring_tables: &RingTables, body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> Irradiance {
    let of_globe = globe_irradiance(body, phase_angle_rad, sun_km, viewer_km);
    if body.rings.is_empty() || sun_km == DVec3::ZERO {
        return of_globe;
    }
    let (viewer_distance_km, viewer, sun_distance_km) = (viewer_km.length(), viewer_km.normalize(), sun_distance_km(sun_km));
    let rings = RingLight::of(ring_tables, body, sun_km.normalize(), viewer);
    // `ring_albedo` is relative to a disc of the equatorial radius.
    Irradiance {
        of_ground: of_globe.of_ground * rings.globe_light_fraction,
        of_air: of_globe.of_air * rings.globe_light_fraction,
        of_rings: rings.ring_albedo * (body.radii_km.x / viewer_distance_km * KM_PER_AU / sun_distance_km).powi(2),
    }
}
