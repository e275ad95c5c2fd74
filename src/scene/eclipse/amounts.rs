//! The numbers that the eclipse fragments read: casters about the axis through receiver and Sun.

use super::super::camera;
use super::super::draw::EclipseModel;
use super::{Axis, Caster, Receiver, air};
use crate::catalog::{Body, Photometry};
use glam::{DVec2, DVec3, Vec4};

/// Uniforms of shaders/lib/eclipse, all f32, the receiver subtracted before; lengths in its equatorial radii.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EclipseAmounts {
    /// Unit vector to the Sun, body axes; 1 / distance.
    pub axis: Vec4,
    /// Two unit vectors across it; cotangent of the Sun's angular radius, and that over the distance.
    pub across: [Vec4; 2],
    /// Radiance of the Sun's disc per its light: factors of 1, mu, mu² per channel.
    pub limb: [Vec4; 3],
    /// Centre across the axis (xy) and along it (z).
    pub places: Vec<Vec4>,
    /// Unit vector of the outline's long axis (xy), semi-axes (zw).
    pub shapes: Vec<Vec4>,
    /// The first caster's air: radius and bending at the lower and the upper edge of each layer, and what it lets through.
    pub air_edges: Vec<Vec4>,
    pub air_passes: Vec<Vec4>,
    /// [`crate::scene::air_spread`]; brought in where the draw asks for it.
    pub spread: Vec<Vec4>,
}

/// Limb darkening of a body that glows, per channel; even where it does not glow.
pub fn limb_law(body: &Body) -> (DVec3, DVec3) {
    match body.photometry {
        Photometry::Emissive { u1, u2 } => (DVec3::from_array(u1), DVec3::from_array(u2)),
        _ => (DVec3::ZERO, DVec3::ZERO),
    }
}

/// 1 - u1 (1 - mu) - u2 (1 - mu)² over the disc's flux, as factors of 1, mu, mu². The flux of 1, mu, mu² is pi, 2/3 pi, pi/2.
fn limb_factors(u1: DVec3, u2: DVec3) -> [DVec3; 3] {
    let flux = (1.0 - u1 / 3.0 - u2 / 6.0) * std::f64::consts::PI;
    [(1.0 - u1 - u2) / flux, (u1 + 2.0 * u2) / flux, -u2 / flux]
}

pub(super) fn of(casters: &[Caster<'_>], model: EclipseModel, receiver: &Receiver<'_>, sun: &Body, axis: &Axis) -> EclipseAmounts {
    let narrow4 = |v: DVec3, w: f64| camera::narrow(v).extend(camera::narrow_scalar(w));
    let (u1, u2) = match model {
        EclipseModel::LimbDarkened | EclipseModel::Refracted => limb_law(sun),
        _ => (DVec3::ZERO, DVec3::ZERO),
    };
    let layers = match casters.first() {
        Some(first) if model == EclipseModel::Refracted => {
            let shown = air::shown(first.along, axis.sun_distance);
            air::layers(first.body, receiver.radius_km(), (first.semi.x * first.semi.y).sqrt(), shown)
        }
        _ => None,
    };
    // Where the air is counted by its layers, the opaque outline ends at their top.
    let raised = layers.as_ref().map_or(0.0, |l| l.top);
    let shape = |k: usize, c: &Caster<'_>| {
        let semi = c.semi + DVec2::splat(if k == 0 { raised } else { 0.0 });
        narrow4(c.long_axis.extend(semi.x), semi.y)
    };
    let edges = layers.as_ref().map_or(&[][..], |l| &l.edges);
    let passes = layers.as_ref().map_or(&[][..], |l| &l.passes);
    EclipseAmounts {
        axis: narrow4(axis.along, 1.0 / axis.sun_distance),
        across: [narrow4(axis.across[0], axis.cot), narrow4(axis.across[1], axis.cot / axis.sun_distance)],
        limb: limb_factors(u1, u2).map(|f| narrow4(f, 0.0)),
        places: casters.iter().map(|c| narrow4(c.across.extend(c.along), 0.0)).collect(),
        shapes: casters.iter().enumerate().map(|(k, c)| shape(k, c)).collect(),
        air_edges: edges.iter().map(|e| narrow4(e.truncate(), e.w)).collect(),
        air_passes: passes.iter().map(|p| narrow4(*p, 0.0)).collect(),
        spread: Vec::new(),
    }
}
