//! Whether the shell of clouds is drawn over a body's globe.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, with the draw of the clouds if there is one.

use crate::message::{Reason, reason};
use crate::scene::annotation::ground_lines;
use crate::scene::atmosphere::{air, clouds};
use crate::scene::camera;
use crate::scene::camera::silhouette::Outline;
use crate::scene::draw::features::{AirPass, Detail, MapSet};
use crate::scene::draw::{BodyPart, Draw, MapFiles};
use crate::scene::features::choice::FeatureSelection;
use crate::scene::features::globe;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::disc_light;
use crate::scene::request::effects::Effect;
use crate::scene::surface::detail;
use glam::DVec3;

/// Decides on the shell of clouds.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    decisions.clouds = draw(inputs, &mut decisions);
    decisions
}

/// Name of the decision whether the ground's draw shows the clouds.
const CLOUDS_WITH_GROUND: &str = "clouds-with-ground";
/// Largest height of the cloud shell above the ground, in pixels at the nearest ground, for clouds drawn with the ground. They share the ground's eclipse
/// shadow, so the shadow's edge on them is displaced by about their height, and by more under a low Sun.
const MAX_PARALLAX_PX: f64 = 4.0;

/// Whether the ground's draw also shows the clouds where it reads the coarse image of the air, with the reason. This saves a second evaluation of the
/// intersection, the map coordinates and the air. `height_km`: that of the clouds.
fn is_drawn_with_ground(inputs: &DecisionInputs<'_, '_>, chosen: FeatureSelection, height_km: f64) -> (bool, Reason) {
    let placed = inputs.placed;
    let pixel_km = (placed.distance_km - inputs.body().radii_km.max_element()).max(0.0) * inputs.frame.camera.pixel_tangent();
    let parallax_px = height_km / pixel_km.max(1e-9);
    let ground_lines =
        ground_lines::requested(inputs.frame.context.request.layers, Some(placed.body.id), &inputs.frame.catalog.data_layers());
    match () {
        () if ground_lines.iter().any(|(is_requested, _)| *is_requested) => (false, reason!("clouds-apart-lines")),
        () if inputs.rect.is_none() || !chosen.shows_clouds_on_ground(inputs.body()) => (false, reason!("clouds-apart-features")),
        () => (
            parallax_px <= MAX_PARALLAX_PX,
            reason!("clouds-parallax", size = format_args!("{parallax_px:.2}"), threshold = MAX_PARALLAX_PX),
        ),
    }
}

/// Decides on the clouds and creates their draw, if there is one.
fn draw(inputs: &DecisionInputs<'_, '_>, decisions: &mut Decisions<'_>) -> Option<Draw> {
    let (body, placed) = (inputs.body(), inputs.placed);
    let clouds = body.clouds.as_ref()?;
    let shell_scale = clouds::shell_scale(body, clouds);
    let shell = clouds::shell(&placed.placement, shell_scale);
    if shell.camera_is_inside() {
        let reason = reason!("clouds-camera-below", height = clouds.height_km);
        decisions.log.record(Effect::Clouds.name(), false, reason);
        return None;
    }
    let closed_deck_radiance = clouds.albedo * decisions.sunlight(placed).max_element();
    let threshold = inputs.threshold();
    let by_threshold = || {
        (
            threshold.is_exceeded_by_radiance(closed_deck_radiance),
            reason!("clouds-closed-deck", light = threshold.radiance_description(closed_deck_radiance)),
        )
    };
    if !decisions.log.record_effect_with_map(Effect::Clouds, Some(&clouds.map), by_threshold) {
        return None;
    }
    let (deg_per_px, max_deg_per_px) = detail::ground_deg_per_px(inputs.frame.camera, &shell, Some(&clouds.map));
    let has_billows = deg_per_px < max_deg_per_px && !decisions.log.is_switched_off(Effect::Detail);
    let sizes = reason!("detail-cloud-span", span = format_args!("{deg_per_px:.4}"), threshold = format_args!("{max_deg_per_px:.4}"));
    let reason = detail::description(Detail::Billows).and(sizes);
    decisions.log.record("cloud-detail", has_billows, reason);
    decisions.chosen.cloud_detail = has_billows;
    if decisions.chosen.air_pass != AirPass::None {
        let (on, reason) = is_drawn_with_ground(inputs, decisions.chosen, clouds.height_km);
        if decisions.log.record(CLOUDS_WITH_GROUND, on, reason) {
            decisions.chosen.air_pass = AirPass::ReadWithClouds;
        }
    }
    let features = decisions.chosen.cloud_features(body, inputs.pixel_view())?;
    let rect = Outline::of(inputs.frame.camera, &shell).rect(inputs.frame.camera)?;
    let mut uniforms = globe::uniforms(inputs, &shell, rect, MapSet::default(), &decisions.secondary_lights);
    let brightness = disc_light::phase_correction(body, placed.phase_angle_rad, placed.distance_km / body.radii_km.x);
    uniforms.air = air::uniforms(body, shell_scale);
    air::set_ends(&mut uniforms, air::FarEnd::Ground);
    uniforms.albedo = camera::narrow(DVec3::splat(clouds.albedo * brightness));
    let map_files =
        MapFiles { clouds: Some(clouds.map.file.clone()), cloud_texel_bits: Some(clouds::texel_bits(clouds)), ..MapFiles::default() };
    Some(Draw { body: body.id, part: BodyPart::Clouds, name: format!("{} clouds", body.name), features, uniforms, map_files })
}
