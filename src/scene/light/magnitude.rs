//! Visual magnitude of a whole body, in the sunlight that eclipses leave.
//!
//! Always: a body wholly in an umbra that no air brightens has no magnitude. In a partial eclipse the error is 0.1, that of the straight ramp in
//! [`crate::scene::eclipse::shade`].

use crate::catalog::NaifId;
use crate::scene::eclipse::before_sun;
use crate::scene::light::photometry;
use crate::scene::placed::PlacedBody;
use crate::scene::resources::Context;

/// A disc this wide leaves no occluder out for its size, pixels.
const LARGE_DISC_PX: f64 = 1e4;
/// Bodies move by this between the instants at which they are placed: light crosses a system in seconds, at tens of kilometres a second.
const PLACED_WITHIN_KM: f64 = 2e3;

/// Visual magnitude in the sunlight that is left; `None` in the dark.
pub(crate) fn magnitude(context: Context<'_>, p: &PlacedBody<'_>, placed: &[PlacedBody<'_>]) -> Option<f64> {
    let lit = if may_be_eclipsed(p, placed) { before_sun::left_by_eclipses(context, p, LARGE_DISC_PX) } else { 1.0 };
    let irradiance = p.irradiance * lit;
    (irradiance > 0.0).then(|| photometry::magnitude(irradiance))
}

/// Whether another body may stand before the Sun: asked of places alone, before the ephemeris is asked for shadows.
fn may_be_eclipsed(p: &PlacedBody<'_>, placed: &[PlacedBody<'_>]) -> bool {
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
