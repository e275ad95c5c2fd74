//! Which of several effects a body's draws have, where no shader has all of them.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, without effects that exclude each other. Always: the choice does not depend on
//! what the frame shows, so that the frames of a dome image or a stereo pair choose alike.

use crate::message::reason;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::effects::Effect;

/// Chooses between ring-shine and planet-shine, which no shader has together: the light that causes the smaller irradiance of the ground is left out.
pub(crate) fn choose_secondary_lights<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    if !decisions.chosen.ring_shine || decisions.secondary_lights.is_empty() {
        return decisions;
    }
    // `brightest` is relative to sunlight.
    let sunlight = decisions.sunlight(inputs.placed).max_element();
    let rings_irradiance = decisions.ring.shine.as_ref().map_or(0.0, |s| s.brightest) * sunlight;
    let bodies_irradiance = decisions.secondary_lights.iter().map(|l| l.irradiance.max_element()).fold(0.0, f64::max);
    if bodies_irradiance > rings_irradiance {
        decisions.log.record(Effect::RingShine.name(), false, reason!("rings-beside-shine"));
        decisions.chosen.ring_shine = false;
        decisions.ring.shine = None;
    } else {
        decisions.log.record(Effect::PlanetShine.name(), false, reason!("shine-beside-rings"));
        decisions.secondary_lights.clear();
    }
    decisions
}
