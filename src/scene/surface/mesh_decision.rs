//! Decides whether a body is drawn as a mesh, and whether the mesh casts shadows on itself.
//!
//! In: the inputs of one body, with its shape model if it has been loaded, and the decisions made before. Out: the decisions, and the uniforms of a mesh: the
//! transformation of its vertices, and the altitude of the Sun at each vertex.

use crate::catalog::NaifId;
use crate::mesh::Mesh;
use crate::message::reason;
use crate::scene::decision::with_invented_note;
use crate::scene::draw::uniforms::{DrawUniforms, MeshInstance};
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions, FrameContext};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use crate::scene::surface::meshes;
use glam::DVec3;
use std::sync::Arc;

/// Altitude of the Sun over a vertex's horizon, in solar radii, that stands for an unobstructed Sun: any large value.
const UNOBSTRUCTED_SUN_ALTITUDE: f32 = 1e3;

/// Direction of the Sun in body axes and its angular radius (radians), for a mesh's self-shadowing; `None` without sunlight.
pub(crate) fn sun_direction_and_radius(frame: &FrameContext<'_>, placed: &PlacedBody<'_>) -> Option<(DVec3, f64)> {
    let sun = frame.reflectors.iter().find(|r| r.body.id == NaifId::SUN && r.body.id != placed.body.id)?;
    let radius_rad = (sun.body.radii_km.x / placed.body_to_sun_km.length()).clamp(0.0, 1.0).asin();
    Some(((placed.body_from_icrf * placed.body_to_sun_km).normalize(), radius_rad))
}

/// Decides on the mesh and on its self-shadowing. A mesh that is present is always drawn: [`meshes::mesh_of`] returns none if the user switched it off.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (name, body, log) = (Effect::Mesh.name(), inputs.body(), &mut decisions.log);
    let resources = inputs.frame.context.resources;
    let Some(shape_model) = &body.mesh else {
        log.record(name, false, reason!("not-available"));
        return decisions;
    };
    if resources.is_unreadable(&shape_model.file) {
        log.record(name, false, reason!("unreadable-mesh", file = &shape_model.file));
        return decisions;
    }
    let Some(mesh) = inputs.mesh else {
        let is_switched_off = log.is_switched_off(Effect::Mesh);
        log.record(name, false, if is_switched_off { reason!("set-by-you") } else { reason!("unread-mesh", file = &shape_model.file) });
        return decisions;
    };
    let reason =
        reason!("mesh-triangles", count = mesh.triangle_count(), file = &shape_model.file, radii = format_args!("{:.3}", mesh.max_radius));
    let reason = with_invented_note(reason, shape_model.invented.as_deref(), |how| reason!("shape-invented", how = how));
    log.record_effect(Effect::Mesh, true, reason);
    decisions.chosen.mesh = Some(meshes::flags(body, mesh));
    let Some((to_sun, sun_radius_rad)) = sun_direction_and_radius(inputs.frame, inputs.placed) else { return decisions };
    let reason =
        reason!("mesh-shadow", degrees = format_args!("{:.3}", 2.0 * sun_radius_rad.to_degrees())).and(reason!("mesh-shadow-sharp"));
    let is_lit = !BodyCapabilities::of(body).is_emissive;
    if log.record_effect(Effect::SelfShadow, is_lit, reason) {
        decisions.self_shadow = Some((to_sun, sun_radius_rad));
    }
    decisions
}

/// Sets the vertex transformation, and the altitude of the Sun at each vertex: above the mesh's own horizon if it casts shadows on itself.
pub(crate) fn set_uniforms(
    uniforms: &mut DrawUniforms,
    inputs: &DecisionInputs<'_, '_>,
    mesh: &Arc<Mesh>,
    self_shadow: Option<(DVec3, f64)>,
) {
    let (anchor, matrix) = meshes::clip_from_unit_sphere(inputs.frame.camera, &inputs.placed.placement);
    uniforms.mesh_anchor = anchor;
    uniforms.clip_from_unit_sphere = matrix;
    let loaded = || inputs.frame.context.resources.sun_altitudes.get(&inputs.body().id).cloned();
    let sun_altitudes = match self_shadow {
        Some((to_sun, sun_radius_rad)) => loaded().unwrap_or_else(|| Arc::new(mesh.sun_altitudes(to_sun, sun_radius_rad))),
        None => Arc::new(vec![UNOBSTRUCTED_SUN_ALTITUDE; mesh.vertex_count()]),
    };
    uniforms.mesh = Some(MeshInstance { model: Arc::clone(mesh), sun_altitudes });
}
