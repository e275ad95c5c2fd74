//! The decision on planet-shine: the reflected light of other bodies on a body's ground, in addition to sunlight.
//!
//! In: the lights that other bodies reflect onto the body (`lights`). Out: those that are drawn, strongest first, and the reason.

use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::features::choice::Capabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::lights;
use crate::scene::request::effects::Effect;

/// Decides which bodies' reflected light is added to the sunlight on the ground.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (body, placed, threshold, reflectors) = (inputs.body(), inputs.placed, inputs.threshold(), inputs.frame.reflectors);
    if Capabilities::of(body).is_emissive {
        return decisions;
    }
    let log = &mut decisions.log;
    let irradiance = lights::sunlight(placed.sun_from_body_km).irradiance.x;
    log.record("sunlight", true, reason!("irradiance", irradiance = format_args!("{irradiance:.3e}")));
    let is_forced = inputs.effects().override_of(Effect::PlanetShine) == Some(true);
    let (secondary_lights, strongest) =
        lights::planet_shine(body, placed.position_km, reflectors, |radiance| is_forced || threshold.is_exceeded_by_radiance(radiance));
    let name_of = |id: NaifId| reflectors.iter().find(|r| r.body.id == id).map_or("?", |r| r.body.name.as_str());
    let reason = match strongest {
        Some((from, radiance)) => reason!("shine-strongest", body = name_of(from), light = threshold.radiance_description(radiance)),
        None => reason!("shine-none"),
    };
    if log.record_effect(Effect::PlanetShine, !secondary_lights.is_empty(), reason) {
        decisions.secondary_lights = secondary_lights;
    }
    decisions.chosen.secondary_light_count = decisions.secondary_lights.len() as u8;
    decisions
}
