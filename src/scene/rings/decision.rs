//! The decision whether a body's rings are drawn, cast a shadow on the globe and light it, and by which models.
//!
//! In: the inputs of one body and the decisions made so far. Out: the decisions, with the draws of the rings and the ring uniforms of the globe.

use crate::catalog::Ring;
use crate::message::reason;
use crate::scene::camera;
use crate::scene::draw::features::{PixelView, RingShadow};
use crate::scene::draw::uniforms::{DrawUniforms, Light, RingUniforms};
use crate::scene::draw::{BodyPart, Draw, MapFiles};
use crate::scene::eclipse;
use crate::scene::features::globe;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::lights;
use crate::scene::request::effects::Effect;
use crate::scene::rings::view::RingView;
use crate::scene::stated_errors;
use glam::DVec3;

/// Decides on the rings, on their shadow and light on the globe, and on the globe's shadow on them.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let Some(view) = &inputs.ring_view else { return decisions };
    let is_forced = inputs.effects().override_of(Effect::Rings) == Some(true);
    let seen = view.visible_rings(is_forced);
    let are_drawn = decisions.log.record_effect(Effect::Rings, seen.check.on, seen.check.reason);
    // Rings may cast a shadow on the globe even if they are not visible themselves.
    let include_all = true;
    let all_rings = view.visible_rings(include_all).rings;
    decisions.ring = decide_for_globe(inputs, view, &all_rings, &mut decisions);
    if !are_drawn || seen.rings.is_empty() {
        decisions.log.record(Effect::BodyShadow.name(), false, reason!("rings-not-drawn"));
        return decisions;
    }
    decisions.rings = draws_of_halves(inputs, view, &seen.rings, &mut decisions);
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
    let casts_no_shadow = decisions.chosen.ring_shadow == RingShadow::None;
    let mut ring_uniforms = if casts_no_shadow { RingUniforms::default() } else { view.shadow_uniforms(all_rings, inputs.sun(), model) };
    if decisions.log.record_effect(Effect::RingShine, check.on, check.reason)
        && let Some(shine) = shine
    {
        // The pixel view of sunlight shows the irradiance of the ground, which has no phase angle.
        let phase_brightness = if inputs.pixel_view() == PixelView::Sunlight { 1.0 } else { inputs.placed.phase_brightness() };
        ring_uniforms.shine_parameters = view.shine_parameters(&shine, phase_brightness);
        ring_uniforms.shine = Some(shine);
        decisions.chosen.ring_shine = true;
    }
    ring_uniforms
}

/// The draws of the rings: the half behind the globe's centre, then the half in front of it. Also decides on the globe's shadow and on eclipses of the rings.
fn draws_of_halves(inputs: &DecisionInputs<'_, '_>, view: &RingView<'_>, seen: &[&Ring], decisions: &mut Decisions<'_>) -> Vec<Draw> {
    let sun_radius_km = inputs.sun().map_or(0.0, |s| s.radii_km.x);
    let (check, model) = view.body_shadow(seen, sun_radius_km);
    if decisions.log.record_effect(Effect::BodyShadow, check.on, check.reason) {
        decisions.chosen.body_shadow = model;
        decisions.log.set_stated_error(Effect::BodyShadow.name(), stated_errors::of_body_shadow(model));
    }
    let outer_km = seen.iter().map(|r| r.outer_km).fold(0.0, f64::max);
    let eclipse = eclipse::decision::decide_for_rings(inputs, decisions, outer_km);
    let Some(features) = decisions.chosen.ring_features(view.body, inputs.pixel_view()) else { return Vec::new() };
    let sunlight = lights::sunlight(view.sun * view.sun_distance_km);
    // Rings have the albedo of their table. This factor fades them out together with the disc, and reddens them as the atmosphere around the camera does. It is
    // a factor on their light, not on the albedo that a pixel view shows.
    let light_factor = if inputs.pixel_view().shows_radiance() { globe::tint(inputs) * inputs.drawn_fraction() } else { DVec3::ONE };
    let shared = DrawUniforms {
        albedo: camera::narrow(light_factor),
        lights: vec![Light { direction_in_body: camera::narrow(view.sun), irradiance: camera::narrow(sunlight.irradiance) }],
        ring: view.uniforms(seen, inputs.sun(), inputs.pixel_view()),
        eclipse,
        ..DrawUniforms::default()
    };
    // `side`: -1 behind the globe's centre, 1 in front of it.
    let half = |part: BodyPart, side: f32| {
        let rays = view.rays(view.half_rect(outer_km, side.into())?);
        let DrawUniforms { albedo, lights, mut ring, eclipse, .. } = shared.clone();
        ring.side = side;
        let uniforms = DrawUniforms { albedo, lights, ring, eclipse, ..rays };
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
