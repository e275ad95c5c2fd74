//! The draws of minor planets and comets as points and tails, and of the orbits of bodies as lines.
//!
//! In: the scene and the layouts of the simple shaders. Out: draws with their uniform bytes filled by field name, and their instance attributes.
//! Not here: the choice of what is drawn (scene).

use super::error::PlanError;
use super::passes::{Attribute, Blend, Instances, PlanDraw, Vertices};
use super::provider::ResourceProvider;
use super::simple_draws::{DEPTH_TESTED, STAR_ATTRIBUTES, instanced_rectangles, simple_draw, sprites};
use crate::scene::camera::NEAR_DEPTH_KM;
use crate::scene::orbit_arcs::{CHORDS_PER_ARC, OrbitArc};
use crate::scene::orbits;
use crate::scene::sky::comet_tails::LightPatch;
use crate::scene::sky::minor_planets::{LIGHT_TIME_PER_AU, NEAR_AU};
use crate::scene::{
    CORE_SIGMA_PX, GLARE_RADIUS_EXPONENT, GLARE_SCALE_RADIUS_PX, MAX_GLARE_FRACTION, MAX_RADIUS_PX, MIN_POINT_RADIUS_PX, Scene,
};
use std::sync::Arc;

/// All minor planets in one draw, or none without minor planets; the shader computes their positions from their orbital elements.
pub(super) fn minor_planets(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    // A user's file may list only bodies of the catalog, which are no minor planets here.
    let Some(minor_planets) = scene.minor_planets.as_ref().filter(|m| !m.times.is_empty()) else { return Ok(Vec::new()) };
    let attribute = |components: u32, values: &Arc<Vec<f32>>| Attribute { components, values: Arc::clone(values) };
    let (elements, count) = (&minor_planets.columns, u32::try_from(minor_planets.times.len()).unwrap_or(u32::MAX));
    let attributes = vec![
        attribute(4, &elements.perihelion),
        attribute(4, &elements.perihelion_velocity),
        attribute(1, &elements.slope),
        attribute(1, &minor_planets.times),
    ];
    let draw = simple_draw("minor_planets", scene, provider, |w| {
        w.vec3("right", minor_planets.axes[0])?;
        w.vec3("up", minor_planets.axes[1])?;
        w.vec3("forward", minor_planets.axes[2])?;
        w.vec3("camera_high", minor_planets.camera_parts[0])?;
        w.vec3("camera_low", minor_planets.camera_parts[1])?;
        w.vec3("velocity", minor_planets.velocity)?;
        w.vec3("colour", minor_planets.colour)?;
        w.vec2("pixel_size", scene.camera.clip_per_pixel())?;
        // How the size of a sprite and its glare follow from its brightest pixel: `law` of `point_shape` in shaders/lib/point_shape.wesl.
        w.vec4("point_law", [MIN_POINT_RADIUS_PX, GLARE_RADIUS_EXPONENT, MAX_RADIUS_PX, MAX_GLARE_FRACTION].map(|v| v as f32).into())?;
        w.f32("core_sigma_px", CORE_SIGMA_PX as f32)?;
        w.f32("glare_scale_radius_px", GLARE_SCALE_RADIUS_PX as f32)?;
        w.f32("flux_per_irradiance", minor_planets.flux_per_irradiance)?;
        w.f32("peak_over_white", minor_planets.peak_over_white)?;
        w.f32("marker_flux", minor_planets.marker_flux)?;
        w.f32("light_time", LIGHT_TIME_PER_AU as f32)?;
        w.f32("near_au", NEAR_AU as f32)?;
        w.vec3("air_x", minor_planets.air_axes[0])?;
        w.vec3("air_y", minor_planets.air_axes[1])?;
        w.vec3("air_z", minor_planets.air_axes[2])?;
        w.f32("horizon_sine", minor_planets.horizon_sine)?;
        w.vec4_array("transmittances", &minor_planets.transmittances)
    })?;
    // One triangle per body; its sprite is drawn in the inscribed circle.
    let (vertices, instances) = (Vertices::Count(3), Instances { count, attributes });
    Ok(vec![PlanDraw { label: "minor planets".into(), vertices, instances, blend: Blend::Add, depth: DEPTH_TESTED, ..draw }])
}

/// Arcs of orbits, each a polyline of [`CHORDS_PER_ARC`] chords, which the shader computes.
pub(super) fn orbits(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    if scene.orbits.is_empty() {
        return Ok(Vec::new());
    }
    let (_, instances) = instanced_rectangles::<OrbitArc>(
        &scene.orbits,
        &[
            (3, |a| a.point.to_array().to_vec()),
            (3, |a| a.first_derivative.to_array().to_vec()),
            (3, |a| a.second_derivative.to_array().to_vec()),
            // alpha, where alpha u^2 is the argument of Stumpff's functions, then the first and the last u on the arc.
            (3, |a| vec![a.alpha, a.range[0], a.range[1]]),
            (2, |a| a.opacity.to_vec()),
            (3, |a| a.colour.to_array().to_vec()),
        ],
    );
    let draw = simple_draw("orbit", scene, provider, |w| {
        w.vec2("pixel_size", scene.camera.clip_per_pixel())?;
        w.f32("half_width_px", orbits::HALF_WIDTH_PX)?;
        w.f32("radiance", orbits::RELATIVE_RADIANCE / scene.exposure.factor_f32())?;
        w.f32("segments", CHORDS_PER_ARC as f32)?;
        w.f32("near", NEAR_DEPTH_KM as f32)
    })?;
    let vertices = Vertices::Count(6 * CHORDS_PER_ARC);
    Ok(vec![PlanDraw { label: "orbits".into(), vertices, instances, blend: Blend::PremultipliedOver, depth: DEPTH_TESTED, ..draw }])
}

/// Heads, comas and tails of comets.
pub(super) fn comets(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let heads = sprites("comets", &scene.comets.heads, &STAR_ATTRIBUTES, GLARE_SCALE_RADIUS_PX, scene, provider)?;
    let mut draws: Vec<PlanDraw> = heads.into_iter().map(|draw| PlanDraw { depth: DEPTH_TESTED, ..draw }).collect();
    if !scene.comets.patches.is_empty() {
        let (vertices, instances) = instanced_rectangles::<LightPatch>(
            &scene.comets.patches,
            &[
                (3, |p| p.centre.to_array().to_vec()),
                (3, |p| p.axes[0].to_array().to_vec()),
                (3, |p| p.axes[1].to_array().to_vec()),
                (2, |p| p.radii.to_array().to_vec()),
                (2, |p| vec![p.radiance, p.core]),
                (1, |p| vec![p.depth]),
                (3, |p| p.colour.to_array().to_vec()),
            ],
        );
        let draw = simple_draw("comet_tail", scene, provider, |w| w.f32("pixel_tangent", scene.camera.pixel_tangent() as f32))?;
        draws.push(PlanDraw { label: "comas and tails".into(), vertices, instances, blend: Blend::Add, depth: DEPTH_TESTED, ..draw });
    }
    Ok(draws)
}
