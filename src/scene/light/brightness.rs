//! The irradiance at the viewer from an entire body (globe and rings), at any phase angle.
//!
//! In: the body, and the positions of Sun and viewer. Out: the irradiance. Left out: eclipses, and planet-shine on the body. Errors: 0.2 magnitudes for globes,
//! 0.15 for Saturn with rings (tests/scene/magnitudes.rs).

use crate::catalog::Body;
use crate::scene::light::photometry;
use crate::scene::rings::ring_light::RingLight;
use crate::scene::rings::ring_table::RingTables;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// Irradiance from the globe, without its rings and their shadow, in units of the Sun's at 1 au. Parameters as for [`irradiance`].
pub(crate) fn globe_irradiance(body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> f64 {
    let projected_radius_sq_km2 = photometry::projected_radius_sq_km2(body.radii_km, viewer_km.normalize());
    let mean_irradiance =
        photometry::irradiance_at_viewer(body, phase_angle_rad, sun_distance_km(sun_km), viewer_km.length(), projected_radius_sq_km2);
    mean_irradiance * photometry::light_curve(body, sun_km.normalize_or_zero(), viewer_km.normalize())
}

/// At least 1 km, because the body may be the Sun itself.
fn sun_distance_km(sun_km: DVec3) -> f64 {
    sun_km.length().max(1.0)
}

/// Irradiance from globe and rings, in units of the Sun's at 1 au. `phase_angle_rad`: Sun-body-viewer. `sun_km` and `viewer_km`: positions relative to the
/// body's centre, body axes.
pub(crate) fn irradiance(ring_tables: &RingTables, body: &Body, phase_angle_rad: f64, sun_km: DVec3, viewer_km: DVec3) -> f64 {
    let globe_irradiance = globe_irradiance(body, phase_angle_rad, sun_km, viewer_km);
    if body.rings.is_empty() || sun_km == DVec3::ZERO {
        return globe_irradiance;
    }
    let (viewer_distance_km, viewer, sun_distance_km) = (viewer_km.length(), viewer_km.normalize(), sun_distance_km(sun_km));
    let rings = RingLight::of(ring_tables, body, sun_km.normalize(), viewer);
    // `ring_albedo` is relative to a disc of the equatorial radius.
    let rings_irradiance = rings.ring_albedo * (body.radii_km.x / viewer_distance_km * KM_PER_AU / sun_distance_km).powi(2);
    globe_irradiance * rings.globe_light_fraction + rings_irradiance
}
