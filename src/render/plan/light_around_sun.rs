//! The draws of the light around the Sun: the corona and the Sun's glare.
//!
//! In: the scene. Out: one draw each, none where the scene has no such light. Not here: whether they are drawn, and how bright they are (scene).

use super::error::PlanError;
use super::passes::{Blend, PlanDraw, ShadingRate};
use super::provider::ResourceProvider;
use super::scissor::scissor;
use super::simple_draws::simple_draw;
use crate::scene::Scene;

/// The Sun's corona.
pub(super) fn corona(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let Some(corona) = &scene.corona else { return Ok(Vec::new()) };
    let draw = simple_draw("corona", scene, provider, |w| {
        w.vec3("middle", corona.middle)?;
        w.vec3("right", corona.right)?;
        w.vec3("up", corona.up)?;
        w.f32("radii_per_sine", corona.radii_per_sine)?;
        w.f32("half_pixel_radii", corona.half_pixel_radii)?;
        w.f32("inner_radius", corona.inner_radius)?;
        w.f32("inner_radiance", corona.inner_radiance)?;
        w.f32("flattening", corona.flattening)?;
        w.vec3("terms", corona.terms)?;
        w.vec3("colour", corona.colour)?;
        w.vec3("air_middle", corona.air_middle)?;
        w.vec3("air_right", corona.air_right)?;
        w.vec3("air_up", corona.air_up)?;
        w.f32("horizon_sine", corona.horizon_sine)?;
        w.vec4_array("tints", &corona.tints)?;
        w.f32("outer_cosine", corona.outer_cosine)?;
        w.f32("inverse_fade_width", corona.inverse_fade_width)?;
        w.f32("cutoff", corona.cutoff)
    })?;
    let scissor = scissor(corona.rect_in_clip, scene.camera.width, scene.camera.height);
    Ok(vec![PlanDraw { blend: Blend::Add, scissor, ..draw }])
}

/// The Sun's glare, drawn by the module `glow`.
pub(super) fn glare(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let Some(glare) = &scene.glare else { return Ok(Vec::new()) };
    let draw = simple_draw("glow", scene, provider, |w| {
        w.vec3("sun_direction", glare.sun_direction)?;
        w.f32("core_angle_sq", glare.core_angle_sq)?;
        w.vec3("strength", glare.strength)?;
        w.f32("cutoff", glare.cutoff)?;
        w.vec2("tan_half_fov", glare.tan_half_fov)?;
        w.vec2("law_fades_sq", glare.law_fades_sq)
    })?;
    let scissor = scissor(glare.rect_in_clip, scene.camera.width, scene.camera.height);
    let shading_rate = if glare.is_interpolated { ShadingRate::Interpolated } else { ShadingRate::PerPixel };
    Ok(vec![PlanDraw { blend: Blend::Add, shading_rate, scissor, ..draw }])
}
