//! Whether eclipses darken a body and its rings, and by which model.
//!
//! In: the case of one body and its decisions so far. Out: the decisions with the eclipse model and its uniforms.

use crate::message::reason;
use crate::scene::draw::features::Eclipse;
use crate::scene::draw::uniforms::EclipseUniforms;
use crate::scene::eclipse::sun_occluders::{ReceivingPart, requested_model, sun_occluders};
use crate::scene::eclipse::{occluders, uniforms};
use crate::scene::features::case::{BodyContext, Decisions};
use crate::scene::features::choice::Capabilities;
use crate::scene::request::effects::Effect;
use crate::scene::tiers;

/// Decides which occluders shade the globe, its air and its clouds.
pub(crate) fn decide<'c>(case: &BodyContext<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    if Capabilities::of(case.body()).emissive {
        return so_far;
    }
    let context = case.frame.context;
    let camera = Some(case.frame.camera);
    let Some(mut found) = sun_occluders(context, case.placed, case.diameter_px, ReceivingPart::Body, camera) else { return so_far };
    if !so_far.log.effect(Effect::Eclipse, !found.occluders.is_empty(), std::mem::take(&mut found.reason)) {
        found.occluders.clear();
    }
    so_far.chosen.eclipse = occluders::model(&mut found.occluders, requested_model(context.request));
    so_far.log.tier(Effect::Eclipse.name(), tiers::of_eclipse(so_far.chosen.eclipse.model));
    so_far.eclipse = uniforms::uniforms_of_casters(&found.occluders, so_far.chosen.eclipse.model, &found.receiver, found.sun);
    so_far
}

/// Decides which moons' shadows fall on the rings. The globe's `eclipse` effect switches these shadows too.
pub(crate) fn decide_for_rings(case: &BodyContext<'_, '_>, so_far: &mut Decisions<'_>, outer_km: f64) -> EclipseUniforms {
    let (p, context, camera) = (case.placed, case.frame.context, case.frame.camera);
    let diameter_px = 2.0 * p.body.radii_km.x / (p.distance_km * camera.pixel_tangent());
    let Some(mut found) = sun_occluders(context, p, diameter_px, ReceivingPart::Rings { outer_km }, Some(camera)) else {
        so_far.chosen.ring_eclipse = Eclipse::default();
        return EclipseUniforms::default();
    };
    if case.effects().override_of(Effect::Eclipse) == Some(false) {
        found.occluders.clear();
        found.reason = reason!("eclipse-switched-off");
    }
    so_far.log.note("eclipse-on-rings", !found.occluders.is_empty(), found.reason);
    let model = occluders::model(&mut found.occluders, requested_model(context.request));
    so_far.chosen.ring_eclipse = model;
    so_far.log.tier("eclipse-on-rings", tiers::of_eclipse(model.model));
    uniforms::uniforms_of_casters(&found.occluders, model.model, &found.receiver, found.sun)
}
