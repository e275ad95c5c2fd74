//! The decision whether a body's rings are drawn, cast a shadow on the globe and light it, and by which models.
//!
//! In: the inputs of one body and the decisions made so far. Out: these decisions and those about the rings, the draws of the rings, and the globe's uniforms
//! for ring shadow and ring-shine.

use crate::catalog::Ring;
use crate::message::reason;
use crate::scene::atmosphere;
use crate::scene::camera;
use crate::scene::draw::features::{PixelView, RingShadow};
use crate::scene::draw::uniforms::{DrawUniforms, Light, RingUniforms};
use crate::scene::draw::{BodyPart, Draw, MapFiles};
use crate::scene::eclipse;
use crate::scene::features::globe;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::effects::Effect;
use crate::scene::rings::view::RingView;
use crate::scene::stated_errors;
use glam::DVec3;

/// Decides on the rings, on their shadow and light on the globe, and on the globe's shadow on them.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    // Without a view, neither the rings nor a globe that they shade or light is in the image.
    let Some(view) = &inputs.ring_view else { return decisions };
    let include_all = inputs.effects().override_of(Effect::Rings) == Some(true);
    let visible = view.visible_rings(include_all);
    let are_drawn = decisions.log.record_effect(Effect::Rings, visible.check.on, visible.check.reason);
    // Rings may cast a shadow on the globe even if they are not visible themselves.
    let include_all = true;
    let all_rings = view.visible_rings(include_all).rings;
    // `ring`: uniforms of the globe; `rings`: draws of the rings.
    decisions.ring = decide_for_globe(inputs, view, &all_rings, &mut decisions);
    if !are_drawn || visible.rings.is_empty() {
        decisions.log.record(Effect::BodyShadow.name(), false, reason!("rings-not-drawn"));
        return decisions;
    }
    decisions.rings = decide_and_draw(inputs, view, &visible.rings, &mut decisions);
    decisions
}

/// The same for air in the image without the globe and the rings: decides on their shadow, and on the light that excludes the light of other bodies.
pub(crate) fn decide_for_air<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let Some(view) = inputs.ring_view_for_air().filter(|_| atmosphere::decision::may_be_in_frame(inputs)) else { return decisions };
    let include_all = true;
    decisions.ring = decide_for_globe(inputs, &view, &view.visible_rings(include_all).rings, &mut decisions);
    decisions
}

/// Decides on the rings' shadow and light on the globe.
fn decide_for_globe(
    inputs: &DecisionInputs<'_, '_>,
    view: &RingView<'_>,
    all_rings: &[&Ring],
    decisions: &mut Decisions<'_>,
) -> RingUniforms {
    let sun_radius_km = inputs.sun().map_or(0.0, |s| s.radii_km.x);
    let (check, model) = view.ring_shadow(all_rings, sun_radius_km);
    if decisions.log.record_effect(Effect::RingShadow, check.on, check.reason) {
        decisions.chosen.ring_shadow = model;
        decisions.log.set_stated_error(Effect::RingShadow.name(), stated_errors::of_ring_shadow(model));
    }
    let user_choice = inputs.effects().override_of(Effect::RingShine);
    let (check, shine) = view.ring_shine(all_rings, sun_radius_km, user_choice);
    let casts_shadow = decisions.chosen.ring_shadow != RingShadow::None;
    let mut ring_uniforms = if casts_shadow { view.shadow_uniforms(all_rings, inputs.sun(), model) } else { RingUniforms::default() };
    if decisions.log.record_effect(Effect::RingShine, check.on, check.reason)
        && let Some(shine) = shine
    {
        // The pixel view of sunlight shows irradiance, which does not depend on the phase angle.
        let phase_brightness = if inputs.pixel_view() == PixelView::Sunlight { 1.0 } else { inputs.placed.phase_brightness() };
        ring_uniforms.shine_parameters = view.shine_parameters(&shine, phase_brightness);
        ring_uniforms.shine = Some(shine);
        decisions.chosen.ring_shine = true;
    }
    ring_uniforms
}

/// Decides on the globe's shadow on the rings and on eclipses of the rings. Returns the draws of the half behind the globe's centre, then of the half in front
/// of it; a half outside the frame has none.
fn decide_and_draw(inputs: &DecisionInputs<'_, '_>, view: &RingView<'_>, visible: &[&Ring], decisions: &mut Decisions<'_>) -> Vec<Draw> {
    let sun_radius_km = inputs.sun().map_or(0.0, |s| s.radii_km.x);
    let (check, model) = view.body_shadow(visible, sun_radius_km);
    if decisions.log.record_effect(Effect::BodyShadow, check.on, check.reason) {
        decisions.chosen.body_shadow = model;
        decisions.log.set_stated_error(Effect::BodyShadow.name(), stated_errors::of_body_shadow(model));
    }
    let outer_km = visible.iter().map(|r| r.outer_km).fold(0.0, f64::max);
    let eclipse = eclipse::decision::decide_for_rings(inputs, decisions, outer_km);
    // An emissive body's rings are not drawn.
    let Some(features) = decisions.chosen.ring_features(view.body, inputs.pixel_view()) else { return Vec::new() };
    // Past the rings of other bodies; the shadows of other bodies on the rings are uniforms.
    let irradiance = decisions.sunlight(inputs.placed);
    // The rings' table has their albedo, so the uniform `albedo` holds a factor on their light. It fades them out together with the disc, and applies the
    // reddening by the atmosphere around the camera. A pixel view of the albedo itself does not have this factor.
    let light_factor = if inputs.pixel_view().shows_radiance() { globe::tint(inputs) * inputs.drawn_fraction() } else { DVec3::ONE };
    let shared = DrawUniforms {
        albedo: camera::narrow(light_factor),
        lights: vec![Light { direction_in_body: camera::narrow(view.sun), irradiance: camera::narrow(irradiance) }],
        ring: view.uniforms(visible, inputs.sun(), inputs.pixel_view()),
        eclipse,
        ..DrawUniforms::default()
    };
    // `side`: -1 behind the globe's centre, 1 in front of it.
    let half = |part: BodyPart, side: f32| {
        let ray_uniforms = view.rays(view.half_rect(outer_km, side.into())?);
        let DrawUniforms { albedo, lights, mut ring, eclipse, .. } = shared.clone();
        ring.side = side;
        let uniforms = DrawUniforms { albedo, lights, ring, eclipse, ..ray_uniforms };
        Some(Draw {
            body: view.body.id,
            part,
            name: format!("{} rings", view.body.name),
            features,
            uniforms,
            map_files: MapFiles::default(),
        })
    };
    [half(BodyPart::RingBehind, -1.0), half(BodyPart::RingInFront, 1.0)].into_iter().flatten().collect()
}
