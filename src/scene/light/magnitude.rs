//! Visual magnitude of an entire body, lit by the sunlight that eclipses and the rings of other bodies leave; of the Sun, that of its part that no other body
//! hides.
//!
//! In: a placed body, and the bodies around it. Out: its magnitude. Left out: planet-shine, so that a body entirely in an umbra without refracted light has
//! no magnitude. In partial eclipses of Titan, Io, Callisto and Phobos, the error is at most 0.1 magnitudes if more than 0.4 of the light is left. If less is
//! left, the body is too bright: by up to 0.7 magnitudes if a twentieth is left, and by more below that. The cause is the linear ramp in
//! [`crate::scene::eclipse::approximate_shadow`], whose test compares these moons with sums over rays. The error is largest for a moon that is much smaller
//! than the penumbra is wide.

use crate::catalog::NaifId;
use crate::scene::eclipse::sun_occluders;
use crate::scene::light::photometry;
use crate::scene::placed::PlacedBody;
use crate::scene::resources::Context;
use crate::scene::visibility::hidden;
use crate::units::luminance;
use glam::DVec3;

/// Diameter of the disc that is passed to the choice of occluders: so large that no occluder is left out because its shadow is smaller than a pixel.
const LARGE_DISC_PX: f64 = 1e4;
/// Margin for the motion of bodies between the instants at which they are placed. Each body is placed where it was when its light left it. Within a system of
/// moons these instants differ by seconds, and bodies move at tens of kilometres per second.
const PLACEMENT_SHIFT_KM: f64 = 2e3;

/// Visual magnitude; `None` for a body that no sunlight reaches, and for the Sun in totality, whose corona is left out.
pub(crate) fn magnitude(context: Context<'_>, p: &PlacedBody<'_>, placed: &[PlacedBody<'_>]) -> Option<f64> {
    if p.body.id == NaifId::SUN {
        // A camera at the Sun's centre sees no disc.
        let visible = if p.distance_km > 0.0 { hidden::visible_fraction_past_other_bodies(placed, p) } else { DVec3::ZERO };
        let irradiance = luminance((p.irradiance.rgb(p.body) * visible).to_array());
        return (irradiance > 0.0).then(|| photometry::magnitude(irradiance));
    }
    // Only where it matters, because the search for occluders is costlier.
    let is_dimmed = may_be_eclipsed(p, placed) || !sun_occluders::rings_of_others(context, p).is_empty();
    let irradiance = if is_dimmed {
        luminance((p.irradiance.rgb(p.body) * sun_occluders::visible_sunlight_by_best_model(context, p, LARGE_DISC_PX)).to_array())
    } else {
        p.irradiance.luminance()
    };
    (irradiance > 0.0).then(|| photometry::magnitude(irradiance))
}

/// Whether another body may be in front of the Sun: a quick test of positions only, which avoids the costlier search for occluders.
fn may_be_eclipsed(p: &PlacedBody<'_>, placed: &[PlacedBody<'_>]) -> bool {
    let sun_distance_km = p.body_to_sun_km.length();
    if sun_distance_km == 0.0 {
        return false;
    }
    let to_sun = p.body_to_sun_km / sun_distance_km;
    let sun_radius_km = placed.iter().find(|other| other.body.id == NaifId::SUN).map_or(0.0, |s| s.body.radii_km.x);
    placed.iter().filter(|other| other.body.id != p.body.id && other.body.id != NaifId::SUN).any(|other| {
        let offset_km = other.position_km - p.position_km;
        let along_km = offset_km.dot(to_sun);
        let off_axis_km = (offset_km - to_sun * along_km).length();
        let max_off_axis_km =
            other.body.radii_km.max_element() + p.body.radii_km.max_element() + along_km * sun_radius_km / sun_distance_km;
        (0.0..sun_distance_km).contains(&along_km) && off_axis_km < max_off_axis_km + PLACEMENT_SHIFT_KM
    })
}
