//! The irradiance at the viewer from an entire body (globe and rings), at any phase angle.
//!
//! In: the body, and the positions of the viewer and of the Sun or another light. Out: [`Irradiance`]. Left out: eclipses. Errors: 0.2 magnitudes for globes,
//! 0.15 for Saturn with rings (tests/scene/magnitudes.rs).

use crate::catalog::Body;
use crate::scene::light::{ellipsoid, photometry};
use crate::scene::rings::ring_light::RingLight;
use crate::scene::rings::ring_table::RingTables;
use crate::units::{KM_PER_AU, luminance};
use glam::DVec3;

/// Irradiance at the viewer, in units of the Sun's at 1 au.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Irradiance {
    /// Luminance of the light that follows the body's phase function. It has the body's colour.
    of_phase_function: f64,
    /// Light that thick air adds at large phase angles, linear RGB ([`photometry::forward_light`]).
    of_air: DVec3,
}

impl Irradiance {
    /// The same without the light that the air adds.
    pub(crate) fn without_air(self) -> Self {
        Self { of_air: DVec3::ZERO, ..self }
    }

    /// Its luminance.
    pub(crate) fn luminance(self) -> f64 {
        self.of_phase_function + luminance(self.of_air.to_array())
    }

    /// Its colour, linear RGB.
    pub(crate) fn rgb(self, body: &Body) -> DVec3 {
        body.colour.as_dvec3() * self.of_phase_function + self.of_air
    }
}

/// Irradiance from the globe, without its rings and their shadow; that of an elongated body depends on the sides that face the Sun and the viewer
/// ([`ellipsoid`]). Parameters as for [`irradiance`].
pub(crate) fn globe_irradiance(body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> Irradiance {
    let projected_radius_sq_km2 = photometry::projected_radius_sq_km2(body.radii_km, viewer_km.normalize());
    let (sun_distance_km, viewer_distance_km) = (sun_distance_km(sun_km), viewer_km.length());
    let mean_irradiance = match ellipsoid::phase_times_radius_sq_km2(body, sun_km.normalize_or_zero(), viewer_km.normalize()) {
        Some(km2) => body.geometric_albedo * km2 * (KM_PER_AU / (sun_distance_km * viewer_distance_km)).powi(2),
        None => photometry::irradiance_at_viewer(body, phase_angle_rad, sun_distance_km, viewer_distance_km, projected_radius_sq_km2),
    };
    Irradiance {
        of_phase_function: mean_irradiance * photometry::light_curve(body, sun_km.normalize_or_zero(), viewer_km.normalize()),
        of_air: photometry::forward_irradiance_at_viewer(
            body,
            phase_angle_rad,
            sun_distance_km,
            viewer_distance_km,
            projected_radius_sq_km2,
        ),
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
    let rings_irradiance = rings.ring_albedo * (body.radii_km.x / viewer_distance_km * KM_PER_AU / sun_distance_km).powi(2);
    Irradiance {
        of_phase_function: of_globe.of_phase_function * rings.globe_light_fraction + rings_irradiance,
        of_air: of_globe.of_air * rings.globe_light_fraction,
    }
}
