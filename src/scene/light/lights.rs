//! The lights that shine on a body: the Sun, and other bodies that reflect enough sunlight onto it.
//!
//! In: the placed bodies. Out: [`IncidentLight`]s, each with a direction and an irradiance. Not here: eclipses. A reflecting body is treated as a point at its
//! centre, with the phase function of its photometric model or published law. Its angular size as seen from the lit body is ignored: on Io, where Jupiter is 19
//! degrees across, this moves the edge of Jupiter-shine by up to 10 degrees. Its disc has the size of a sphere of equal volume: this gives 2 % more light from
//! Jupiter for a receiver in the plane of Jupiter's equator, and 7 % less light from Saturn for a receiver above Saturn's pole. A body other than the Sun that
//! emits light is treated in the same way, with its own light in place of reflected light. Lights are compared with each other and with thresholds by their
//! green channel.

use crate::catalog::{Body, NaifId};
use crate::scene::light::disc_light;
use crate::scene::thresholds::MAX_LIGHTS;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// A body that reflects sunlight: its barycentric position, and the Sun's position relative to it, ICRF.
pub(crate) struct Reflector<'a> {
    pub body: &'a Body,
    pub position_km: DVec3,
    pub body_to_sun_km: DVec3,
}

/// Light from one source that falls on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IncidentLight {
    pub from: NaifId,
    /// Unit vector towards the light, ICRF.
    pub direction: DVec3,
    /// Linear RGB, in units of the Sun's irradiance at 1 au.
    pub irradiance: DVec3,
}

/// Sunlight on a body other than the Sun.
pub(crate) fn sunlight(body_to_sun_km: DVec3) -> IncidentLight {
    let irradiance = (KM_PER_AU / body_to_sun_km.length()).powi(2);
    IncidentLight { from: NaifId::SUN, direction: body_to_sun_km.normalize(), irradiance: DVec3::splat(irradiance) }
}

/// Squared radius of a sphere with the body's volume.
fn radius_sq_km2(body: &Body) -> f64 {
    body.radii_km.element_product().cbrt().powi(2)
}

/// A bound of the green light that `source` reflects onto a body at `receiver_km` (barycentric).
fn max_reflected_light(source: &Reflector<'_>, receiver_km: DVec3) -> f64 {
    let distance_km = (source.position_km - receiver_km).length();
    let irradiance_per_mean_radiance =
        disc_light::irradiance_per_mean_radiance(source.body_to_sun_km.length(), distance_km, radius_sq_km2(source.body));
    disc_light::max_mean_radiance(source.body) * irradiance_per_mean_radiance
}

/// The light that `source` reflects onto a body at `receiver_km` (barycentric); `None` if the receiver is nearer to the source's centre than the source's
/// greatest semi-axis.
fn reflected_light(source: &Reflector<'_>, receiver_km: DVec3) -> Option<IncidentLight> {
    let to_source = source.position_km - receiver_km;
    let distance_km = to_source.length();
    if distance_km <= source.body.radii_km.max_element() {
        return None;
    }
    let phase_angle_rad = crate::ephemeris::angle_rad(-to_source, source.body_to_sun_km);
    let radius_sq_km2 = radius_sq_km2(source.body);
    let sun_distance_km = source.body_to_sun_km.length();
    let irradiance = disc_light::irradiance_of_measured_side(source.body, phase_angle_rad, sun_distance_km, distance_km, radius_sq_km2);
    Some(IncidentLight { from: source.body.id, direction: to_source / distance_km, irradiance })
}

/// The lights that other bodies reflect onto a receiver. Returns the significant lights, strongest first, at most [`MAX_LIGHTS`] - 1 because one light is the
/// Sun. Also returns the body that reflects the strongest light, significant or not, and the radiance which this light gives to a surface that faces it and
/// has the receiver's albedo. `is_significant`: whether a light that causes this radiance matters.
pub(crate) fn planet_shine(
    receiver: &Body,
    receiver_km: DVec3,
    sources: &[Reflector<'_>],
    is_significant: impl Fn(f64) -> bool,
) -> (Vec<IncidentLight>, Option<(NaifId, f64)>) {
    // At least 0.01, so that a catalog albedo of 0 does not switch the lights off.
    let radiance_caused_by = |light: &IncidentLight| light.irradiance.y * receiver.geometric_albedo.max(0.01);
    let others = sources.iter().filter(|s| s.body.id != receiver.id && s.body.id != NaifId::SUN);
    let mut by_bound: Vec<(f64, &Reflector<'_>)> = others.map(|s| (max_reflected_light(s, receiver_km), s)).collect();
    by_bound.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    // Strongest first. Of most sources the bound shows that they are too weak: weaker than the last of the `MAX_LIGHTS` - 1 lights that can be returned.
    let mut all: Vec<IncidentLight> = Vec::new();
    for (bound, source) in by_bound {
        if all.get(usize::from(MAX_LIGHTS) - 2).is_some_and(|weakest| weakest.irradiance.y > bound) {
            break;
        }
        let Some(light) = reflected_light(source, receiver_km).filter(|l| l.irradiance.y > 0.0) else { continue };
        let place = all.partition_point(|stronger| stronger.irradiance.y >= light.irradiance.y);
        all.insert(place, light);
    }
    let strongest = all.first().map(|l| (l.from, radiance_caused_by(l)));
    let significant = all.into_iter().filter(|l| is_significant(radiance_caused_by(l))).take(usize::from(MAX_LIGHTS) - 1).collect();
    (significant, strongest)
}
