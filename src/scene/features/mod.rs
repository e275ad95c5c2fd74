//! Decides which features the draws of one body have. Each decision compares a value with a threshold.
//!
//! In: a frame and a placed body. Out: the body's draws, its point, and every decision with its reason. The module of each effect decides on its
//! features. [`decide`] runs [`ALL_DECISIONS`] in order. Always: a decision reads only the results of decisions before it.

pub mod choice;
pub(crate) mod combinations;
pub(crate) mod globe;
pub(crate) mod inputs;
pub mod possible;

use crate::catalog::{Map, NaifId};
use crate::message::{Reason, reason};
use crate::scene::atmosphere::multi_scatter_in_shadow;
use crate::scene::body_report::Appearance;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{self, ClipRect};
use crate::scene::decision::{Decision, DecisionLog};
use crate::scene::draw::features::{AirPass, AtmosphereModel, DrawFeatures, PixelView, RingShadow, Shape};
use crate::scene::draw::uniforms::{DrawUniforms, Light};
use crate::scene::draw::{BodyPart, Draw, MapFiles, Point};
use crate::scene::light::lights;
use crate::scene::placed::PlacedBody;
use crate::scene::point::{self, DISC_ONLY_FROM_PX, POINT_ONLY_BELOW_PX};
use crate::scene::request::effects::Effect;
use crate::scene::surface::{crescent, ground, mesh_decision, meshes, overlays};
use crate::scene::{atmosphere, eclipse, light, rings};
use glam::{DVec3, Vec3};
use inputs::{DecideEffect, DecisionInputs, Decisions, FrameContext, decide_in_order};
use std::f64::consts::PI;
use std::sync::Arc;

/// Everything decided about one body.
pub(crate) struct DecidedBody {
    pub appearance: Appearance,
    /// See [`DecisionInputs::diameter_px`].
    pub diameter_px: f64,
    pub decisions: Vec<Decision>,
    /// The draws of the body, the globe first.
    pub draws: Vec<Draw>,
    /// `None` if no point is drawn ([`point_of`]).
    pub point: Option<Point>,
    /// The glare of the disc; `None` without glare ([`light::disc_glare::of`]).
    pub disc_glare: Option<Point>,
}

/// The decisions about a body that is drawn as a disc, in their order.
const ALL_DECISIONS: [DecideEffect; 11] = [
    ground::decide,
    light::planet_shine::decide,
    eclipse::decision::decide,
    overlays::decide,
    rings::decision::decide,
    combinations::choose_secondary_lights,
    atmosphere::decision::decide,
    crescent::decide,
    atmosphere::air_pass::decide,
    mesh_decision::decide,
    atmosphere::cloud_decision::decide,
];

/// The decisions about a body of which at most the atmosphere is in the image.
const AIR_ONLY_DECISIONS: [DecideEffect; 5] = [
    light::planet_shine::decide,
    eclipse::decision::decide,
    rings::decision::decide_for_air,
    combinations::choose_secondary_lights,
    atmosphere::decision::decide,
];

/// The decisions about effects that read maps, for [`required_maps`].
const MAP_DECISIONS: [DecideEffect; 3] = [ground::decide, overlays::decide, atmosphere::cloud_decision::decide];

/// Decides on all effects of one body. A body with the camera at its centre is not drawn.
pub(crate) fn decide(frame: &FrameContext<'_>, placed: &PlacedBody<'_>, camera_is_at_centre: bool) -> DecidedBody {
    let inputs = DecisionInputs::of(frame, placed);
    let mut log = inputs.log();
    if camera_is_at_centre {
        return not_shown(&inputs, Decisions::new(log), reason!("camera-at-centre"));
    }
    let glare = light::disc_glare::of(&inputs);
    let inputs = DecisionInputs { glare_fraction: glare.as_ref().map_or(0.0, |g| g.fraction), ..inputs };
    let disc_glare = glare.map(|g| g.sprite);
    if inputs.rect.is_none() && inputs.ring_view.is_none() {
        let point = point_beside_frame(&inputs);
        return DecidedBody { point, disc_glare, ..decide_air_only(&inputs, Decisions::new(log)) };
    }
    let reason = if inputs.rect.is_some() { reason!("outline-meets") } else { reason!("rings-meet") };
    log.record("visible", true, reason);
    let point = point_of(&inputs, &mut log);
    let diameter_px = inputs.diameter_px;
    if disc_glare.is_some() {
        let reason = reason!(
            "disc-glare",
            size = format_args!("{diameter_px:.2}"),
            percent = format_args!("{:.1}", 100.0 * inputs.glare_fraction),
            to = point::NO_GLARE_FROM_PX
        );
        log.record("disc-glare", true, reason);
    }
    if inputs.disc_fraction <= 0.0 {
        eclipse::decision::decide_on_rings_of_others(&inputs, &mut log);
        let is_visible = point.as_ref().is_some_and(|p| p.flux != Vec3::ZERO);
        let appearance = if is_visible { Appearance::Point } else { Appearance::NotShown };
        return DecidedBody { appearance, diameter_px, decisions: log.decisions, draws: Vec::new(), point, disc_glare };
    }
    let decided = decide_in_order(&ALL_DECISIONS, &inputs, Decisions::new(log));
    let appearance = if point.is_some() { Appearance::DiscAndPoint } else { Appearance::Disc };
    let globe = inputs.rect.map(|rect| globe_draw(&inputs, &decided, rect));
    let (draws, decisions) = assemble(&inputs, globe, decided);
    DecidedBody { appearance, diameter_px, decisions, draws, point, disc_glare }
}

/// The map files that the body's draws read, except those known to be unreadable, and the shape of the globe's draw; `None` if the body has no draws.
pub(crate) fn required_maps(frame: &FrameContext<'_>, placed: &PlacedBody<'_>) -> Option<(MapFiles, Shape)> {
    let inputs = DecisionInputs::of(frame, placed);
    let has_mesh = meshes::is_required(frame.context, frame.camera, placed);
    if inputs.disc_fraction <= 0.0 || inputs.rect.is_none() && inputs.ring_view.is_none() && !has_mesh {
        return None;
    }
    let decided = decide_in_order(&MAP_DECISIONS, &inputs, Decisions::new(inputs.log()));
    let features = decided.chosen.globe_features(inputs.body(), inputs.pixel_view());
    let mut files = map_files(&inputs, &features, &decided);
    let cloud_draw_map = decided.clouds.and_then(|c| c.map_files.clouds);
    files.clouds = files.clouds.or(cloud_draw_map);
    Some((files, if has_mesh { Shape::Mesh } else { features.shape }))
}

/// The result for a body that is not drawn.
fn not_shown(inputs: &DecisionInputs<'_, '_>, mut decided: Decisions<'_>, reason: Reason) -> DecidedBody {
    decided.log.record("visible", false, reason);
    let (appearance, decisions) = (Appearance::NotShown, decided.log.decisions);
    DecidedBody { appearance, diameter_px: inputs.diameter_px, decisions, draws: Vec::new(), point: None, disc_glare: None }
}

/// Decides on a body whose ground is outside the frame, but whose atmosphere may be in it.
fn decide_air_only<'c>(inputs: &DecisionInputs<'c, '_>, decisions: Decisions<'c>) -> DecidedBody {
    let steps: &[DecideEffect] = if inputs.body().atmosphere.is_some() { &AIR_ONLY_DECISIONS } else { &[] };
    let decided = decide_in_order(steps, inputs, decisions);
    if decided.sky.is_none() {
        let reason = if inputs.placed.outline == Outline::Behind { reason!("behind-camera") } else { reason!("outside-frame") };
        return not_shown(inputs, decided, reason);
    }
    let no_globe = None;
    let (draws, decisions) = assemble(inputs, no_globe, decided);
    DecidedBody { appearance: Appearance::Disc, diameter_px: inputs.diameter_px, decisions, draws, point: None, disc_glare: None }
}

/// Decides on the point that replaces a small disc. From [`POINT_ONLY_BELOW_PX`] to [`DISC_ONLY_FROM_PX`], disc and point share the light. `None` without a
/// point, or if the point is behind the camera or has no light and hides nothing.
fn point_of(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) -> Option<Point> {
    let (frame, placed, disc_fraction) = (inputs.frame, inputs.placed, inputs.disc_fraction);
    // Points are drawn after the air, so its transmittance is applied here.
    let light_factor = inputs.transmittance() * (1.0 - disc_fraction);
    let flux = point::flux(frame.camera, placed) * light_factor;
    // Eclipses are evaluated only for a point that would be visible without them, if all its flux fell into one pixel.
    let may_be_visible = disc_fraction < 1.0 && frame.threshold.is_exceeded_by_radiance(flux.max_element());
    let flux =
        if may_be_visible { flux * eclipse::sun_occluders::visible_sunlight(frame.context, placed, inputs.diameter_px) } else { flux };
    let reason =
        reason!("point-size", size = format_args!("{:.3}", inputs.diameter_px), from = POINT_ONLY_BELOW_PX, to = DISC_ONLY_FROM_PX);
    if !log.record_effect(Effect::Points, disc_fraction < 1.0, reason) || disc_fraction >= 1.0 {
        return None;
    }
    let flux = flux + planet_shine_on_point(inputs, log) * light_factor;
    let flux = if inputs.pixel_view() == PixelView::Final { flux } else { DVec3::ZERO };
    let brightest = flux.max_element();
    let is_visible = frame.threshold.is_exceeded_by_radiance(brightest);
    if !is_visible {
        log.record("point-visible", false, frame.threshold.radiance_description(brightest));
    }
    let covered_px = covered_px(inputs);
    // A point without light is dropped later if it hides nothing (`visibility::points`).
    let flux = if is_visible { flux } else { DVec3::ZERO };
    let clip = frame.camera.clip(placed.placement.centre_km).filter(|_| is_visible || covered_px > 0.0)?;
    Some(point::sprite(placed.body.id, clip, flux, covered_px))
}

/// The flux of a body's point by planet-shine; 0 for a point that would be invisible even if the Sun lit all of its disc, because no other body sheds more
/// light.
fn planet_shine_on_point(inputs: &DecisionInputs<'_, '_>, log: &mut DecisionLog<'_>) -> DVec3 {
    let (frame, placed) = (inputs.frame, inputs.placed);
    if placed.body.id == NaifId::SUN {
        return DVec3::ZERO;
    }
    let disc_px = 0.25 * PI * inputs.diameter_px.powi(2);
    let sunlight = lights::sunlight(placed.body_to_sun_km).irradiance.max_element();
    if !frame.threshold.is_exceeded_by_radiance(placed.body.geometric_albedo.max(0.01) * sunlight * disc_px) {
        return DVec3::ZERO;
    }
    // For a body that is drawn as a disc, too, this log is dropped, because the decisions about the disc include this one.
    let irradiance = if inputs.disc_fraction > 0.0 {
        light::planet_shine::irradiance_at_viewer(inputs, &mut inputs.log())
    } else {
        light::planet_shine::irradiance_at_viewer(inputs, log)
    };
    point::flux_of_irradiance(frame.camera, placed, irradiance)
}

/// Area in pixels that a body drawn as a point, together with its air, may hide of what is behind it. 0 if its disc is drawn, too, which hides as much; for the
/// Sun; and in pixel views other than the final image.
fn covered_px(inputs: &DecisionInputs<'_, '_>) -> f64 {
    let body = inputs.body();
    if inputs.disc_fraction > 0.0 || body.id == NaifId::SUN || inputs.pixel_view() != PixelView::Final {
        return 0.0;
    }
    let air = body.atmosphere.as_ref().filter(|_| inputs.effects().override_of(Effect::Atmosphere) != Some(false));
    let beyond_limb = air.map_or(0.0, |air| atmosphere::rim::hidden_area_ratio(body, air));
    0.25 * PI * inputs.diameter_px.powi(2) * (1.0 + beyond_limb)
}

/// The point of a body beside the frame: its glare may reach into the frame, as that of a star may. That of the Sun is dimmed later (`build::bodies`).
fn point_beside_frame(inputs: &DecisionInputs<'_, '_>) -> Option<Point> {
    let (camera, placed) = (inputs.frame.camera, inputs.placed);
    let clip = camera.clip(placed.placement.centre_km)?;
    if !point::reaches_frame(camera, clip, point::MAX_RADIUS_PX) {
        return None;
    }
    // The decisions about the point go to a separate log that is discarded: `explain` says only that the body is outside the frame.
    point_of(inputs, &mut inputs.log())
}

/// The files of the maps that a set of features reads.
fn map_files(inputs: &DecisionInputs<'_, '_>, features: &DrawFeatures, decided: &Decisions<'_>) -> MapFiles {
    let body = inputs.body();
    let file = |on: bool, map: &Option<Map>| map.as_ref().filter(|_| on).map(|m| m.file.clone());
    MapFiles {
        albedo: file(features.maps.albedo, &body.maps.albedo),
        normal: file(features.maps.normal, &body.maps.normal),
        specular: file(features.maps.specular, &body.maps.specular),
        night: file(features.maps.night, &body.maps.night),
        clouds: body.clouds.as_ref().filter(|_| features.maps.cloud_shadow).map(|c| c.map.file.clone()),
        cloud_texel_bits: body.clouds.as_ref().map(atmosphere::clouds::texel_bits),
        overlays: decided.overlays.iter().map(|o| o.file.clone()).collect(),
    }
}

/// The draw of the globe, or of the mesh that replaces it.
fn globe_draw(inputs: &DecisionInputs<'_, '_>, decided: &Decisions<'_>, rect: ClipRect) -> Draw {
    let (placed, body) = (inputs.placed, inputs.body());
    let features = decided.chosen.globe_features(body, inputs.pixel_view());
    let uniforms = globe::uniforms(inputs, &placed.placement, rect, decided.chosen.maps, &decided.secondary_lights);
    let radiance_factor = || placed.radiance_scale() * globe::colour_factor(body, globe::tint(inputs) * inputs.drawn_fraction());
    let overlays = decided.overlays.iter().map(|o| overlays::uniforms(body, o, radiance_factor())).collect();
    let mut uniforms = DrawUniforms { ring: decided.ring.clone(), overlays, ..uniforms };
    if let Some(mesh) = inputs.mesh.filter(|_| features.shape == Shape::Mesh) {
        mesh_decision::set_uniforms(&mut uniforms, inputs, mesh, decided.self_shadow);
    }
    Draw {
        body: body.id,
        part: BodyPart::Globe,
        name: body.name.clone(),
        features,
        uniforms,
        map_files: map_files(inputs, &features, decided),
    }
}

/// Completes the draws of a body and returns them, the globe first, with the decisions about it.
fn assemble(inputs: &DecisionInputs<'_, '_>, mut globe: Option<Draw>, mut decided: Decisions<'_>) -> (Vec<Draw>, Vec<Decision>) {
    for draw in [&mut globe, &mut decided.clouds].into_iter().flatten().filter(|d| d.features.air.model != AtmosphereModel::None) {
        draw.uniforms.air.optical_depth_above_ground = atmosphere::optical_depth_above_ground::terms(&draw.uniforms.air);
    }
    if let Some((globe, clouds)) = globe.as_mut().zip(decided.clouds.as_ref())
        && globe.features.air_pass == AirPass::ReadWithClouds
    {
        atmosphere::clouds::set_cloud_uniforms_of_ground(&mut globe.uniforms, &clouds.uniforms);
    }
    let mut draws: Vec<Draw> = globe.into_iter().chain(decided.sky).chain(decided.clouds).collect();
    if draws.iter().any(|d| d.features.air.model == AtmosphereModel::Table) && !decided.eclipse.occluder_positions.is_empty() {
        decided.eclipse.multi_scatter = multi_scatter_in_shadow::tables(inputs.body(), &decided.eclipse);
    }
    let sunlight_factor = camera::narrow(decided.sunlight_factor);
    for draw in &mut draws {
        // The features may round the number of lights up (`choice`), so that there are fewer shader keys; the additional lights are black.
        let black_light =
            Light { direction_in_body: draw.uniforms.lights.first().map_or(Vec3::Z, |l| l.direction_in_body), irradiance: Vec3::ZERO };
        while draw.uniforms.lights.len() < usize::from(draw.features.lights) {
            draw.uniforms.lights.push(black_light);
        }
        // The first light is the Sun.
        if let Some(sun) = draw.uniforms.lights.first_mut() {
            sun.irradiance *= sunlight_factor;
        }
        draw.uniforms.eclipse.clone_from(&decided.eclipse);
        if matches!(draw.part, BodyPart::Sky | BodyPart::Clouds) && draw.features.ring_shadow != RingShadow::None {
            draw.uniforms.ring.clone_from(&decided.ring);
        }
        draw.uniforms.air.blend_mode = decided.blend_mode;
        draw.uniforms.air.map_weight = decided.map_weight;
        draw.uniforms.air.second_light_irradiance = decided.second_light_irradiance;
        if draw.part != BodyPart::Sky {
            draw.uniforms.air.night_radiance *= decided.night_fraction_on_ground;
        }
        if draw.features.air_pass != AirPass::None {
            atmosphere::air_pass::set_error_bounds(&mut draw.uniforms, inputs);
        }
        if let Some(table) =
            inputs.frame.context.resources.scattering_tables.get(&draw.body).filter(|_| draw.features.air.model == AtmosphereModel::Table)
        {
            draw.uniforms.air.multi_scatter = Arc::clone(table);
        }
    }
    draws.extend(decided.rings);
    (draws, decided.log.decisions)
}
