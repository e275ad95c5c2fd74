//! The decision on planet-shine: the reflected light of other bodies on a body's ground, in addition to sunlight.
//!
//! In: the lights that other bodies reflect onto the body (`lights`). Out: those that are drawn, strongest first, and the reason; for a body drawn as a point,
//! the irradiance that they cause at the viewer.

use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::decision::DecisionLog;
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::brightness;
use crate::scene::light::lights::{self, IncidentLight};
use crate::scene::request::effects::Effect;
use crate::units::KM_PER_AU;
use glam::DVec3;

/// Decides which bodies' reflected light is added to the sunlight on the ground.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    if BodyCapabilities::of(inputs.body()).is_emissive {
        return decisions;
    }
    // Sunlight is white, so its channels are equal.
    let irradiance = lights::sunlight(inputs.placed.body_to_sun_km).irradiance.x;
    decisions.log.record("sunlight", true, reason!("irradiance", irradiance = format_args!("{irradiance:.3e}")));
    decisions.secondary_lights = drawn_lights(inputs, &mut decisions.log);
    decisions.chosen.secondary_light_count = decisions.secondary_lights.len() as u8;
    decisions
}

/// The lights that are drawn, with the decision in the log.
fn drawn_lights(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) -> Vec<IncidentLight> {
    let (body, placed, threshold, reflectors) = (inputs.body(), inputs.placed, inputs.threshold(), inputs.frame.reflectors);
    let is_forced = inputs.effects().override_of(Effect::PlanetShine) == Some(true);
    let (secondary_lights, strongest) =
        lights::planet_shine(body, placed.position_km, reflectors, |radiance| is_forced || threshold.is_exceeded_by_radiance(radiance));
    let name_of = |id: NaifId| reflectors.iter().find(|r| r.body.id == id).map_or("?", |r| r.body.name.as_str());
    let reason = match strongest {
        Some((from, radiance)) => reason!("shine-strongest", body = name_of(from), light = threshold.radiance_description(radiance)),
        None => reason!("shine-none"),
    };
    if log.record_effect(Effect::PlanetShine, !secondary_lights.is_empty(), reason) { secondary_lights } else { Vec::new() }
}

/// The irradiance at the viewer by planet-shine on a body that is drawn as a point, linear RGB, in units of the Sun's at 1 au. The lights are those that would
/// be drawn on the body's disc ([`drawn_lights`]). The body reflects each as it reflects sunlight: with the same phase function and the same light curve.
pub(crate) fn irradiance_at_viewer(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) -> DVec3 {
    let (body, placed) = (inputs.body(), inputs.placed);
    if BodyCapabilities::of(body).is_emissive {
        return DVec3::ZERO;
    }
    let viewer_km = (placed.placement.camera_in_unit_sphere() * body.radii_km).normalize() * placed.distance_km;
    let effects = inputs.effects();
    // The irradiance includes the light of the body's air unless the air is switched off.
    let may_draw = |effect: Effect| effects.override_of(effect) != Some(false);
    let reflected = |light: &IncidentLight| {
        let phase_angle_rad = crate::ephemeris::angle_rad(light.direction, -placed.placement.centre_km);
        // The Sun, if it were 1 au away in the direction of the light, would cause an irradiance of 1.
        let sun_at_1_au_km = placed.body_from_icrf * light.direction * KM_PER_AU;
        let per_unit_irradiance = brightness::globe_irradiance(body, phase_angle_rad, sun_at_1_au_km, viewer_km);
        light.irradiance * per_unit_irradiance.with_shown_air(body, may_draw).rgb(body)
    };
    drawn_lights(inputs, log).iter().map(reflected).sum()
}
