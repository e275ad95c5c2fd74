//! Light that a whole body sends to the viewer in full sunlight: its globe and its rings.
//!
//! Left out: light that other bodies reflect on it. Errors: globes 0.2 magnitudes, Saturn with rings 0.15 (tests/scene/magnitudes.rs).

use crate::catalog::Body;
use crate::scene::light::photometry;
use crate::scene::rings::ring_light::RingLight;
use crate::scene::rings::ring_table::RingTables;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// Of globe and rings, in full sunlight. `sun_km` and `viewer_km`: from the body's centre, body axes.
pub(crate) fn irradiance(tables: &RingTables, body: &Body, alpha: f64, sun_km: DVec3, viewer_km: DVec3) -> f64 {
    let (away_km, viewer) = (viewer_km.length(), viewer_km.normalize());
    let outline_squared_km2 = photometry::projected_radius_squared_km2(body.radii_km, viewer);
    let sun_away_km = sun_km.length().max(1.0);
    let globe = photometry::irradiance_at_viewer(body, alpha, sun_away_km, away_km, outline_squared_km2);
    if body.rings.is_empty() || sun_km == DVec3::ZERO {
        return globe;
    }
    let rings = RingLight::of(tables, body, sun_km.normalize(), viewer);
    globe * rings.globe_left + rings.added * (body.radii_km.x / away_km * KM_PER_AU / sun_away_km).powi(2)
}
