//! The cloud shell of a body: when it is drawn, when its shadow is, and with what uniforms.
//!
//! The shell is the body's ellipsoid made larger by one factor. It is seen from outside only: a camera under the clouds sees none.

use crate::catalog::{Body, Clouds};
use crate::scene::camera::{self, Placement};
use crate::scene::draw::CloudUniforms;
use crate::scene::purpose::Bound;

/// The lowest Sun whose cloud shadows are told from the clouds above them, degrees from the zenith.
const LOW_SUN_DEG: f64 = 80.0;

/// The shell's radius over the body's.
pub(crate) fn shell_scale(body: &Body, clouds: &Clouds) -> f64 {
    1.0 + clouds.height_km / body.radii_km.max_element()
}

/// Where the shell appears.
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

/// Whether a shadow lies a pixel beside its cloud anywhere, with the numbers.
pub(crate) fn shadow_bound(body: &Body, clouds: &Clouds, diameter_px: f64, least: Bound) -> (bool, String) {
    let pixel_km = 2.0 * body.radii_km.max_element() / diameter_px.max(1e-9);
    let beside_km = clouds.height_km * LOW_SUN_DEG.to_radians().tan();
    (
        beside_km > pixel_km || least.is_linear(),
        format!("under a Sun {LOW_SUN_DEG} degrees from the zenith it falls {beside_km:.1} km aside; a pixel spans {pixel_km:.1} km"),
    )
}
