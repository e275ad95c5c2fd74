//! Whether eclipses darken a body and its rings, and by which model; and the shadow of other bodies' rings.
//!
//! In: the inputs of one body, and its decisions so far. Out: the same decisions, with the eclipse model and its uniforms added, and the factor by which other
//! bodies' rings dim the sunlight.

use crate::message::reason;
use crate::scene::decision::DecisionLog;
use crate::scene::draw::features::Eclipse;
use crate::scene::draw::uniforms::EclipseUniforms;
use crate::scene::eclipse::sun_occluders::{self, ReceivingPart, sun_occluders};
use crate::scene::eclipse::{model, uniforms};
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::effects::Effect;
use crate::scene::stated_errors;
use glam::DVec3;

/// Lower limit of the factor on a body's sunlight: draws have the second light of the air relative to sunlight, so they divide by it.
const MIN_SUNLIGHT_FACTOR: f64 = 1e-6;

/// Decides which occluders darken the globe, its air and its clouds, and by which model.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    if BodyCapabilities::of(inputs.body()).is_emissive {
        return decisions;
    }
    decisions.sunlight_factor *= decide_on_rings_of_others(inputs, &mut decisions.log).max(DVec3::splat(MIN_SUNLIGHT_FACTOR));
    let context = inputs.frame.context;
    let camera = Some(inputs.frame.camera);
    let Some(mut found) = sun_occluders(context, inputs.placed, inputs.diameter_px, ReceivingPart::Body, camera) else { return decisions };
    if !decisions.log.record_effect(Effect::Eclipse, !found.occluders.is_empty(), std::mem::take(&mut found.reason)) {
        found.occluders.clear();
    }
    decisions.chosen.eclipse = model::choose_eclipse_model(&mut found.occluders, model::eclipse_model_choice(context.request));
    decisions.log.set_stated_error(Effect::Eclipse.name(), stated_errors::of_eclipse(decisions.chosen.eclipse.model));
    decisions.eclipse = uniforms::uniforms_of_occluders(&found.occluders, decisions.chosen.eclipse.model, &found.receiver, found.sun);
    decisions
}

/// Records the shadow of other bodies' rings on a body, if there is one, and returns the fraction of sunlight that it leaves. No shader computes it: all
/// sunlight of the body is dimmed. The effect `eclipse` switches it together with the shadows of other bodies.
pub(crate) fn decide_on_rings_of_others(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) -> DVec3 {
    let (context, placed) = (inputs.frame.context, inputs.placed);
    let rings = sun_occluders::rings_of_others(context, placed);
    if rings.is_empty() {
        return DVec3::ONE;
    }
    let fraction = sun_occluders::shown_sunlight_past_rings(context, placed);
    let is_on = !log.is_switched_off(Effect::Eclipse);
    let owners: Vec<String> = rings.iter().map(|r| r.owner.name.clone()).collect();
    let reason = if is_on {
        reason!("eclipse-by-rings", bodies = owners, part = format_args!("{:.4}", fraction.y))
    } else {
        reason!("eclipse-switched-off")
    };
    log.record("eclipse-by-rings", is_on, reason);
    fraction
}

/// Decides which occluders darken the rings, out to the radius `outer_km`. The effect `eclipse` switches the shadows on the rings together with those on the
/// globe.
pub(crate) fn decide_for_rings(inputs: &DecisionInputs<'_, '_>, decisions: &mut Decisions<'_>, outer_km: f64) -> EclipseUniforms {
    let (placed, context, camera) = (inputs.placed, inputs.frame.context, inputs.frame.camera);
    let diameter_px = 2.0 * placed.body.radii_km.x / (placed.distance_km * camera.pixel_tangent());
    let Some(mut found) = sun_occluders(context, placed, diameter_px, ReceivingPart::Rings { outer_km }, Some(camera)) else {
        decisions.chosen.ring_eclipse = Eclipse::default();
        return EclipseUniforms::default();
    };
    if inputs.effects().override_of(Effect::Eclipse) == Some(false) {
        found.occluders.clear();
        found.reason = reason!("eclipse-switched-off");
    }
    decisions.log.record("eclipse-on-rings", !found.occluders.is_empty(), found.reason);
    let eclipse = model::choose_eclipse_model(&mut found.occluders, model::eclipse_model_choice(context.request));
    decisions.chosen.ring_eclipse = eclipse;
    decisions.log.set_stated_error("eclipse-on-rings", stated_errors::of_eclipse(eclipse.model));
    uniforms::uniforms_of_occluders(&found.occluders, eclipse.model, &found.receiver, found.sun)
}
