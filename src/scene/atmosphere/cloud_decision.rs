//! Whether the shell of clouds is drawn over a body's globe.

use crate::scene::atmosphere::{air, clouds};
use crate::scene::camera;
use crate::scene::camera::silhouette::Outline;
use crate::scene::draw::features::MapSet;
use crate::scene::draw::{Draw, MapFiles, Part};
use crate::scene::features::case::{Case, Decisions};
use crate::scene::features::globe;
use crate::scene::light::{lights, photometry};
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// Decides on the shell of clouds.
pub(crate) fn decide<'c>(case: &Case<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    so_far.clouds = shell(case, &mut so_far);
    so_far
}

fn shell(case: &Case<'_, '_>, so_far: &mut Decisions<'_>) -> Option<Draw> {
    let (body, p) = (case.body(), case.placed);
    let clouds = body.clouds.as_ref()?;
    let features = so_far.chosen.cloud_features(body, case.pixel_view())?;
    let scale = clouds::shell_scale(body, clouds);
    let shell = clouds::shell(&p.placement, scale);
    if shell.camera_is_inside() {
        let reason = format!("the camera is below the clouds, {} km above the surface", clouds.height_km);
        so_far.log.note(Effect::Clouds.name(), false, reason);
        return None;
    }
    let full_cover = clouds.albedo * lights::sunlight(p.sun_from_body_km).irradiance.x;
    let check = || (case.threshold().is_exceeded_by(full_cover), format!("a closed deck is {}", case.threshold().description(full_cover)));
    if !so_far.log.map(Effect::Clouds, Some(&clouds.map), check) {
        return None;
    }
    let rect = Outline::of(case.frame.camera, &shell).rect(case.frame.camera)?;
    let mut uniforms = globe::uniforms(case, &shell, rect, MapSet::default(), &so_far.shine);
    let brightness = photometry::phase_correction(body, p.alpha, p.distance_km / body.radii_km.x);
    uniforms.air = air::uniforms(body, scale);
    air::set_ends(&mut uniforms, false);
    uniforms.albedo = camera::narrow(DVec3::splat(clouds.albedo * brightness * case.share));
    let map_files = MapFiles { cloud: Some(clouds.map.file.clone()), ..MapFiles::default() };
    Some(Draw { body: body.id, part: Part::Clouds, name: format!("{} clouds", body.name), features, uniforms, map_files })
}
