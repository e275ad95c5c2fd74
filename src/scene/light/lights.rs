//! What lights a body: the Sun, and other bodies that reflect enough of it.
//!
//! A reflecting body is taken as a point at its centre (its disc seen from the lit body is not resolved: for Io under Jupiter, 19
//! degrees across, that moves the edge of Jupiter-shine by up to 10 degrees), with the phase function of its photometric model or
//! published law.

use crate::catalog::{Body, NaifId};
use crate::scene::light::photometry;
use crate::scene::thresholds::MAX_LIGHTS;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// A body as a source of light: where it is and where the Sun is from it, ICRF, kilometres.
pub struct Reflector<'a> {
    pub body: &'a Body,
    pub position_km: DVec3,
    pub sun_from_body_km: DVec3,
}

/// One light on a body, f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightOn {
    pub from: NaifId,
    /// Unit vector towards it, ICRF.
    pub direction: DVec3,
    /// Linear RGB, in units of the Sun's irradiance at 1 au.
    pub irradiance: DVec3,
}

/// The Sun's light on a body.
pub fn sunlight(sun_from_body_km: DVec3) -> LightOn {
    let irradiance = (KM_PER_AU / sun_from_body_km.length()).powi(2);
    LightOn { from: NaifId::SUN, direction: sun_from_body_km.normalize(), irradiance: DVec3::splat(irradiance) }
}

/// Light that `source` reflects onto a body at `receiver_km`.
fn shine(source: &Reflector<'_>, receiver_km: DVec3) -> Option<LightOn> {
    let to_source = source.position_km - receiver_km;
    let distance_km = to_source.length();
    if distance_km <= source.body.radii_km.max_element() {
        return None;
    }
    let alpha = crate::ephemeris::angle_rad(-to_source, source.sun_from_body_km);
    let radius_squared_km2 = source.body.radii_km.element_product().cbrt().powi(2);
    let sun_km = source.sun_from_body_km.length();
    let white = photometry::irradiance_at_viewer(source.body, alpha, sun_km, distance_km, radius_squared_km2);
    Some(LightOn { from: source.body.id, direction: to_source / distance_km, irradiance: source.body.colour.as_dvec3() * white })
}

/// The reflected lights that count on a receiver, strongest first, at most two; and the strongest of all with the radiance it gives.
///
/// `counts`: whether a radiance does, of a surface of the receiver's albedo that faces the light.
pub fn planet_shine(
    receiver: &Body,
    receiver_km: DVec3,
    sources: &[Reflector<'_>],
    counts: impl Fn(f64) -> bool,
) -> (Vec<LightOn>, Option<(NaifId, f64)>) {
    let strength = |light: &LightOn| light.irradiance.y * receiver.geometric_albedo.max(0.01);
    let mut all: Vec<LightOn> = sources
        .iter()
        .filter(|s| s.body.id != receiver.id && s.body.id != NaifId::SUN)
        .filter_map(|s| shine(s, receiver_km))
        .filter(|l| l.irradiance.y > 0.0)
        .collect();
    all.sort_by(|a, b| b.irradiance.y.total_cmp(&a.irradiance.y));
    let strongest = all.first().map(|l| (l.from, strength(l)));
    let counted = all.into_iter().filter(|l| counts(strength(l))).take(usize::from(MAX_LIGHTS) - 1).collect();
    (counted, strongest)
}
