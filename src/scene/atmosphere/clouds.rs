//! The cloud shell of a body: its placement and uniforms.
//!
//! In: a body and its clouds. Out: the shell, which is the body's ellipsoid scaled up, and uniforms. The shell is drawn only for a camera outside it: from
//! below, no clouds are shown.

use crate::catalog::{Body, Clouds};
use crate::scene::camera::{self, Placement};
use crate::scene::draw::{CloudUniforms, DrawUniforms};

/// Ratio of the shell's radius to the body's radius.
pub(crate) fn shell_scale(body: &Body, clouds: &Clouds) -> f64 {
    1.0 + clouds.height_km / body.radii_km.max_element()
}

/// The placement of the shell.
pub(crate) fn shell(placement: &Placement, scale: f64) -> Placement {
    Placement { radii_km: placement.radii_km * scale, ..*placement }
}

/// Sets the cloud uniforms that only the ground's draw needs, which also shows the clouds where it interpolates the air. `clouds`: the uniforms of the clouds'
/// own draw.
pub(crate) fn set_cloud_uniforms_of_ground(ground: &mut DrawUniforms, clouds: &DrawUniforms) {
    ground.clouds.reflectance = clouds.albedo.x;
    ground.clouds.optical_depth_above = clouds.air.optical_depth_above_ground;
}

/// The texel values of the cloud map for a clear sky and for a closed deck, as bits of f32, which can be hashed.
pub(crate) fn texel_bits(clouds: &Clouds) -> [u32; 2] {
    [clouds.clear_texel, clouds.closed_texel].map(|texel| camera::narrow_scalar(texel).to_bits())
}

/// The cloud uniforms of all draws of a body; the remaining ones are set by [`set_cloud_uniforms_of_ground`] and `render::plan`.
pub(crate) fn uniforms(body: &Body) -> CloudUniforms {
    body.clouds.as_ref().map_or_else(CloudUniforms::default, |clouds| CloudUniforms {
        clear_texel: camera::narrow_scalar(clouds.clear_texel),
        closed_texel: camera::narrow_scalar(clouds.closed_texel),
        radius: camera::narrow_scalar(shell_scale(body, clouds)),
        albedo: camera::narrow_scalar(clouds.albedo),
        ..CloudUniforms::default()
    })
}
