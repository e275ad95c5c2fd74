//! Whether the shell of clouds is drawn over a body's globe.
//!
//! In: the case of one body and its decisions so far. Out: the decisions, with the draw of the clouds if there is one.

use crate::message::reason;
use crate::scene::atmosphere::{air, clouds};
use crate::scene::camera;
use crate::scene::camera::silhouette::Outline;
use crate::scene::draw::features::{Detail, MapSet};
use crate::scene::draw::{Draw, MapFiles, Part};
use crate::scene::features::case::{BodyContext, Decisions};
use crate::scene::features::globe;
use crate::scene::light::{lights, photometry};
use crate::scene::request::effects::Effect;
use crate::scene::surface::detail;
use glam::DVec3;

/// Decides on the shell of clouds.
pub(crate) fn decide<'c>(case: &BodyContext<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    so_far.clouds = shell(case, &mut so_far);
    so_far
}

fn shell(case: &BodyContext<'_, '_>, so_far: &mut Decisions<'_>) -> Option<Draw> {
    let (body, p) = (case.body(), case.placed);
    let clouds = body.clouds.as_ref()?;
    let scale = clouds::shell_scale(body, clouds);
    let shell = clouds::shell(&p.placement, scale);
    if shell.camera_is_inside() {
        let reason = reason!("clouds-camera-below", height = clouds.height_km);
        so_far.log.note(Effect::Clouds.name(), false, reason);
        return None;
    }
    let full_cover = clouds.albedo * lights::sunlight(p.sun_from_body_km).irradiance.x;
    let threshold = case.threshold();
    let check = || (threshold.is_exceeded_by(full_cover), reason!("clouds-closed-deck", light = threshold.description(full_cover)));
    if !so_far.log.map(Effect::Clouds, Some(&clouds.map), check) {
        return None;
    }
    let (span, max_span) = detail::ground_deg_per_px(case.frame.camera, &shell, Some(&clouds.map));
    let has_billows = span < max_span && !so_far.log.is_switched_off(Effect::Detail) && so_far.chosen.eclipse.occluders == 0;
    let sizes = reason!("detail-cloud-span", span = format_args!("{span:.4}"), most = format_args!("{max_span:.4}"));
    let reason = detail::law(Detail::Billows).and(sizes);
    so_far.log.note("cloud-detail", has_billows, reason);
    so_far.chosen.cloud_detail = has_billows;
    let features = so_far.chosen.cloud_features(body, case.pixel_view())?;
    let rect = Outline::of(case.frame.camera, &shell).rect(case.frame.camera)?;
    let mut uniforms = globe::uniforms(case, &shell, rect, MapSet::default(), &so_far.secondary_lights);
    let brightness = photometry::phase_correction(body, p.phase_angle, p.distance_km / body.radii_km.x);
    uniforms.air = air::uniforms(body, scale);
    air::set_ends(&mut uniforms, false);
    uniforms.albedo = camera::narrow(DVec3::splat(clouds.albedo * brightness * case.disc_fraction));
    let map_files = MapFiles { cloud: Some(clouds.map.file.clone()), ..MapFiles::default() };
    Some(Draw { body: body.id, part: Part::Clouds, name: format!("{} clouds", body.name), features, uniforms, map_files })
}
