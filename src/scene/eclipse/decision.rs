//! Whether eclipses darken a body and its rings, and by which model; and the shadow of other bodies' rings.
//!
//! In: the inputs of one body, and its decisions so far. Out: the same decisions, with the eclipse model and its uniforms added, and the shadow of other
//! bodies' rings: where it varies over the disc, as a grid that the shader reads, otherwise as a factor on all sunlight.

use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::atmosphere::clouds;
use crate::scene::decision::DecisionLog;
use crate::scene::draw::features::{Eclipse, RingShadow};
use crate::scene::draw::uniforms::{EclipseUniforms, RingUniforms};
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::eclipse::sun_occluders::{self, ReceivingPart, sun_occluders};
use crate::scene::eclipse::{model, uniforms};
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::effects::Effect;
use crate::scene::rings::shadow_on_body::{LitGlobe, ShadowOnBody};
use crate::scene::stated_errors;
use glam::DVec3;

/// Lower limit of the factor on a body's sunlight: draws have the second light of the air relative to sunlight, so they divide by it.
const MIN_SUNLIGHT_FACTOR: f64 = 1e-6;
/// The name of the decision about the shadow of other bodies' rings.
const RINGS_OF_OTHERS: &str = "eclipse-by-rings";

/// Decides which occluders darken the globe, its air and its clouds, and by which model.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    if BodyCapabilities::of(inputs.body()).is_emissive {
        return decisions;
    }
    let ring_shadow = varying_ring_shadow(inputs);
    let past_rings = record_rings_of_others(inputs, &mut decisions.log, ring_shadow.as_ref());
    match ring_shadow {
        Some(ShadowOnBody { grid, axes, .. }) => {
            decisions.chosen.ring_shadow = RingShadow::OfPlanet;
            decisions.log.set_stated_error(RINGS_OF_OTHERS, stated_errors::of_ring_shadow(RingShadow::OfPlanet));
            decisions.ring = RingUniforms { shadow_grid: Some(grid), shadow_grid_axes: axes, ..RingUniforms::default() };
        }
        None => decisions.sunlight_factor *= past_rings.max(DVec3::splat(MIN_SUNLIGHT_FACTOR)),
    }
    let context = inputs.frame.context;
    let camera = Some(inputs.frame.camera);
    let Some(mut found) = sun_occluders(context, inputs.placed, inputs.diameter_px, ReceivingPart::Body, camera) else { return decisions };
    if !decisions.log.record_effect(Effect::Eclipse, !found.occluders.is_empty(), std::mem::take(&mut found.reason)) {
        found.occluders.clear();
    }
    decisions.chosen.eclipse = model::choose_eclipse_model(&mut found.occluders, model::eclipse_model_choice(context.request));
    if decisions.chosen.ring_shadow == RingShadow::OfPlanet {
        decisions.chosen.eclipse = decisions.chosen.eclipse.beside_ring_shadow();
    }
    decisions.log.set_stated_error(Effect::Eclipse.name(), stated_errors::of_eclipse(decisions.chosen.eclipse.model));
    decisions.eclipse = uniforms::uniforms_of_occluders(&found.occluders, decisions.chosen.eclipse.model, &found.receiver, found.sun);
    decisions
}

/// The shadow of another body's rings, if it is switched on and varies visibly over the disc. A body with rings of its own, or behind the rings of two bodies,
/// is dimmed evenly; no built-in body is such a body.
fn varying_ring_shadow(inputs: &DecisionInputs<'_, '_>) -> Option<ShadowOnBody> {
    let (context, placed, body) = (inputs.frame.context, inputs.placed, inputs.body());
    let [rings] = sun_occluders::rings_of_others(context, placed) else { return None };
    let is_off = inputs.effects().override_of(Effect::Eclipse) == Some(false);
    if is_off || !body.rings.is_empty() {
        return None;
    }
    let sun = placed.catalog.body(NaifId::SUN)?;
    let intervals = context.caches.ring_tables.intervals(rings.owner.rings.iter(), rings.owner.radii_km.x);
    let (disc_radius_km, unit_km) = (body.radii_km.max_element(), body.radii_km.x);
    let air_km = body.atmosphere.as_ref().map_or(0.0, |air| air.top_km);
    let cloud_radii = body.clouds.as_ref().map_or(1.0, |clouds| clouds::shell_scale(body, clouds));
    let mesh_radius_km = inputs.mesh.map_or(0.0, |mesh| mesh.max_radius * unit_km);
    let extent_km = (disc_radius_km + air_km).max(disc_radius_km * cloud_radii).max(mesh_radius_km);
    let lit = LitGlobe { body_from_icrf: placed.body_from_icrf, unit_km, disc_radius_km, extent_km };
    let shadow = context.caches.ring_shadows.shadow_on(&lit, rings, &intervals, limb_darkening(sun))?;
    shadow.varies_by_more_than(context.request.purpose.min_change()).then_some(shadow)
}

/// Records the shadow of other bodies' rings on a body that is drawn as a point, if there is one. Its light is dimmed by [`sun_occluders::visible_sunlight`].
pub(crate) fn decide_on_rings_of_others(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) {
    record_rings_of_others(inputs, log, None);
}

/// Records the shadow of other bodies' rings on a body, if there is one, and returns the fraction of sunlight that it leaves in the mean. `drawn`: the shadow
/// that the shader draws; without it all sunlight of the body is dimmed by the mean. The effect `eclipse` switches both together with the shadows of other
/// bodies.
fn record_rings_of_others(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>, drawn: Option<&ShadowOnBody>) -> DVec3 {
    let (context, placed) = (inputs.frame.context, inputs.placed);
    let rings = sun_occluders::rings_of_others(context, placed);
    if rings.is_empty() {
        return DVec3::ONE;
    }
    let fraction = sun_occluders::shown_sunlight_past_rings(context, placed);
    let is_on = !log.is_switched_off(Effect::Eclipse);
    let owners: Vec<String> = rings.iter().map(|r| r.owner.name.clone()).collect();
    let reason = match drawn {
        _ if !is_on => reason!("eclipse-switched-off"),
        Some(ShadowOnBody { range: [from, to], .. }) => reason!(
            "eclipse-by-rings-drawn",
            bodies = owners,
            part = format_args!("{:.4}", fraction.y),
            from = format_args!("{from:.3}"),
            to = format_args!("{to:.3}")
        ),
        None => reason!("eclipse-by-rings", bodies = owners, part = format_args!("{:.4}", fraction.y)),
    };
    log.record(RINGS_OF_OTHERS, is_on, reason);
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
