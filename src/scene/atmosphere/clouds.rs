//! The cloud shell of a body: its placement and uniforms.
//!
//! The shell is the body's ellipsoid scaled up. It is drawn only if the camera is outside: from below, no clouds are visible.

use crate::catalog::{Body, Clouds};
use crate::scene::camera::{self, Placement};
use crate::scene::draw::CloudUniforms;

/// Ratio of the shell's radius to the body's radius.
pub(crate) fn shell_scale(body: &Body, clouds: &Clouds) -> f64 {
    1.0 + clouds.height_km / body.radii_km.max_element()
}

/// The placement of the shell.
pub(crate) fn shell(placement: &Placement, scale: f64) -> Placement {
    Placement { radii_km: placement.radii_km * scale, ..*placement }
}

pub(crate) fn uniforms(body: &Body) -> CloudUniforms {
    body.clouds.as_ref().map_or_else(CloudUniforms::default, |clouds| CloudUniforms {
        clear: camera::narrow_scalar(clouds.clear_texel),
        full: camera::narrow_scalar(clouds.closed_texel),
        radius: camera::narrow_scalar(shell_scale(body, clouds)),
        albedo: camera::narrow_scalar(clouds.albedo),
    })
}
