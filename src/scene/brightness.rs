//! How bright a whole body is to the viewer: globe, rings and what eclipses leave of its sunlight.
//!
//! In: a body where it is seen and the others around it. Out: irradiance at the viewer in units of the Sun's at 1 au, and visual magnitude. Always: a body
//! wholly in an umbra that no air brightens has no magnitude. Left out: light that other bodies reflect on it. Errors: globes 0.2 magnitudes, Saturn with
//! rings 0.15 (tests/scene/magnitudes.rs); in a partial eclipse 0.1, that of the straight ramp in [`super::eclipse::estimate`].

use super::request::ViewRequest;
use super::ring_light::RingLight;
use super::{Placed, features, photometry};
use crate::catalog::{Body, NaifId};
use crate::ephemeris::Ephemeris;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// A disc this wide leaves no caster out for its size, pixels.
const LARGE_DISC_PX: f64 = 1e4;
/// Bodies move by this between the instants at which they are placed: light crosses a system in seconds, at tens of kilometres a second.
const PLACED_WITHIN_KM: f64 = 2e3;

/// Of globe and rings, in full sunlight. `sun_km` and `viewer_km`: from the body's centre, body axes.
pub(super) fn irradiance(body: &Body, alpha: f64, sun_km: DVec3, viewer_km: DVec3) -> f64 {
    let (away_km, viewer) = (viewer_km.length(), viewer_km.normalize());
    let outline_squared_km2 = photometry::projected_radius_squared_km2(body.radii_km, viewer);
    let sun_away_km = sun_km.length().max(1.0);
    let globe = photometry::irradiance_at_viewer(body, alpha, sun_away_km, away_km, outline_squared_km2);
    if body.rings.is_empty() || sun_km == DVec3::ZERO {
        return globe;
    }
    let rings = RingLight::of(body, sun_km.normalize(), viewer);
    globe * rings.globe_left + rings.added * (body.radii_km.x / away_km * KM_PER_AU / sun_away_km).powi(2)
}

/// Visual magnitude in the sunlight that is left; `None` in the dark.
pub(super) fn magnitude(request: &ViewRequest, ephemeris: &Ephemeris, p: &Placed<'_>, placed: &[Placed<'_>]) -> Option<f64> {
    let lit = if may_be_eclipsed(p, placed) { features::left_by_eclipses(request, ephemeris, p, LARGE_DISC_PX) } else { 1.0 };
    let irradiance = p.irradiance * lit;
    (irradiance > 0.0).then(|| photometry::magnitude(irradiance))
}

/// Whether another body may stand before the Sun: asked of places alone, before the ephemeris is asked for shadows.
fn may_be_eclipsed(p: &Placed<'_>, placed: &[Placed<'_>]) -> bool {
    let sun_away_km = p.sun_from_body_km.length();
    if p.body.id == NaifId::SUN || sun_away_km == 0.0 {
        return false;
    }
    let to_sun = p.sun_from_body_km / sun_away_km;
    let sun_radius_km = placed.iter().find(|q| q.body.id == NaifId::SUN).map_or(0.0, |s| s.body.radii_km.x);
    placed.iter().filter(|q| q.body.id != p.body.id && q.body.id != NaifId::SUN).any(|q| {
        let from_p_km = q.position_km - p.position_km;
        let along_km = from_p_km.dot(to_sun);
        let aside_km = (from_p_km - to_sun * along_km).length();
        let reach_km = q.body.radii_km.max_element() + p.body.radii_km.max_element() + along_km * sun_radius_km / sun_away_km;
        (0.0..sun_away_km).contains(&along_km) && aside_km < reach_km + PLACED_WITHIN_KM
    })
}
