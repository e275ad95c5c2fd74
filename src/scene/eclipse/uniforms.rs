//! Uniforms of shaders/lib/eclipse: the occluders relative to the axis from receiver to Sun.
//!
//! In: the occluders, the eclipse model, the receiver and the Sun. Out: [`EclipseUniforms`] in the receiver's axes and equatorial radii,
//! f32.

use crate::catalog::Body;
use crate::scene::camera;
use crate::scene::draw::features::EclipseModel;
use crate::scene::draw::uniforms::EclipseUniforms;
use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver, limb_darkening};
use crate::scene::eclipse::refraction;
use glam::{DVec2, DVec3, Vec2};

/// Uniforms of the occluders for a model; the defaults if the receiver is inside the Sun.
pub(crate) fn uniforms_of_occluders(
    occluders: &[Occluder<'_>],
    model: EclipseModel,
    receiver: &Receiver<'_>,
    sun: &Body,
) -> EclipseUniforms {
    match Axis::of(receiver, sun) {
        Some(axis) => uniforms_for_axis(&axis, occluders, model, receiver, sun),
        None => EclipseUniforms::default(),
    }
}

/// Limb darkening, 1 - u1 (1 - mu) - u2 (1 - mu)², divided by its integral over the unit disc: the coefficients of 1, mu, mu². The integrals of 1, mu, mu²
/// are pi, 2/3 pi, pi/2.
fn normalised_limb_darkening(u1: DVec3, u2: DVec3) -> [DVec3; 3] {
    let flux = (1.0 - u1 / 3.0 - u2 / 6.0) * std::f64::consts::PI;
    [(1.0 - u1 - u2) / flux, (u1 + 2.0 * u2) / flux, -u2 / flux]
}

/// The uniforms for an axis. [`EclipseUniforms`] documents the components of each `Vec4`. Three fields are set later, if the draw needs them:
/// `coarse_first_row` by `render::plan`, `max_coarse_error` by `scene::atmosphere::air_pass`, `multi_scatter` by `scene::features`.
fn uniforms_for_axis(axis: &Axis, occluders: &[Occluder<'_>], model: EclipseModel, receiver: &Receiver<'_>, sun: &Body) -> EclipseUniforms {
    let narrow4 = |v: DVec3, w: f64| camera::narrow(v).extend(camera::narrow_scalar(w));
    let (u1, u2) = match model {
        EclipseModel::LimbDarkened | EclipseModel::Refracted => limb_darkening(sun),
        _ => (DVec3::ZERO, DVec3::ZERO),
    };
    // In the model `Refracted`, the first occluder is the one whose air refracts light (`model::choose_eclipse_model`). Only its air is modelled.
    let layers = match occluders.first() {
        Some(first) if model == EclipseModel::Refracted => {
            let shift_per_bending = refraction::shift_per_bending(first.distance_along, axis.sun_distance);
            let mean_outline_radius = (first.semi_axes.x * first.semi_axes.y).sqrt();
            refraction::layers(first.body, receiver.radius_km(), mean_outline_radius, shift_per_bending)
        }
        _ => None,
    };
    // The shader adds the light through that air layer by layer, so the first occluder's opaque outline extends to the top of the layers.
    let air_thickness = layers.as_ref().map_or(0.0, |l| l.top);
    let outline = |index: usize, occluder: &Occluder<'_>| {
        let semi_axes = occluder.semi_axes + DVec2::splat(if index == 0 { air_thickness } else { 0.0 });
        narrow4(occluder.long_axis.extend(semi_axes.x), semi_axes.y)
    };
    let edges = layers.as_ref().map_or(&[][..], |l| &l.edges);
    let transmittances = layers.as_ref().map_or(&[][..], |l| &l.transmittances);
    EclipseUniforms {
        axis: narrow4(axis.sunward, 1.0 / axis.sun_distance),
        perpendicular_axes: [
            narrow4(axis.perpendicular_axes[0], axis.cot_sun_angular_radius),
            narrow4(axis.perpendicular_axes[1], axis.cot_sun_angular_radius / axis.sun_distance),
        ],
        max_coarse_error: Vec2::ZERO,
        coarse_first_row: 0.0,
        limb_darkening: normalised_limb_darkening(u1, u2).map(|c| narrow4(c, 0.0)),
        occluder_positions: occluders.iter().map(|o| narrow4(o.offset_across.extend(o.distance_along), 0.0)).collect(),
        occluder_outlines: occluders.iter().enumerate().map(|(index, occluder)| outline(index, occluder)).collect(),
        air_edges: edges.iter().map(|e| narrow4(e.truncate(), e.w)).collect(),
        air_transmittance: transmittances.iter().map(|t| narrow4(*t, 0.0)).collect(),
        multi_scatter: Vec::new(),
    }
}
