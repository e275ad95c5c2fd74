//! Whether the air in front of a body's ground and clouds is drawn as a coarse image, which their pixels interpolate. In an eclipse, the image also holds the
//! sunlight that reaches the ground.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, and the bound of the interpolation's error as a uniform. Always: where the
//! error may exceed the bound, such as at the limb, a pixel evaluates its own air (shaders/lib/air/coarse.wesl). So the decision changes an image by no more
//! than the bound.

use crate::message::{Reason, reason};
use crate::scene::camera;
use crate::scene::constants::COARSE_AIR_PX;
use crate::scene::draw::features::{AirPass, AtmosphereModel, RingShadow};
use crate::scene::draw::uniforms::{DrawUniforms, EclipseUniforms};
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::view_request::Quality;
use crate::scene::thresholds::VISIBLE_LIGHT;
use glam::{Vec2, Vec4};

/// Name of this decision in the log.
pub(crate) const AIR_PASS: &str = "air-pass";

/// Smallest diameter of a disc in pixels for which a coarse image is worth its two passes: on a smaller one, most pixels are near the limb, where each
/// evaluates its own air.
const MIN_DIAMETER_PX: f64 = 128.0;

/// Smallest radius of a penumbra in pixels for which the sunlight is interpolated: eight texels. On a large disc the limit is higher ([`resolves_penumbrae`]).
const MIN_PENUMBRA_PX: f64 = 8.0 * COARSE_AIR_PX as f64;

/// Radius of the smallest penumbra at the ground nearest to the Sun, in the body's equatorial radii; infinite without occluders.
fn smallest_penumbra(eclipse: &EclipseUniforms) -> f64 {
    // w is the cotangent of the Sun's angular radius.
    let tan_sun_radius = 1.0 / f64::from(eclipse.perpendicular_axes[0].w);
    let occluders = eclipse.occluder_positions.iter().zip(&eclipse.occluder_outlines);
    // The occluder's shorter semi-axis, widened by the Sun's angular radius from the occluder (z: its distance towards the Sun) to the ground at z = 1.
    let radius = |position: Vec4, outline: Vec4| f64::from(outline.w) + (f64::from(position.z) - 1.0).max(0.0) * tan_sun_radius;
    occluders.map(|(position, outline)| radius(*position, *outline)).fold(f64::INFINITY, f64::min)
}

/// Whether every penumbra covers some texels; a smaller one could lie between texels and be missed. Only texels at least two texels (8 pixels) inside the limb
/// can be interpolated. On a disc with a radius of R pixels, the cosine of the emission angle is 4 / sqrt(R) there. A penumbra with a radius of sqrt(R)
/// pixels is foreshortened by this cosine from 2 sqrt(R) to 8 pixels: two texels. `radius_px`: R at the distance of the body's centre; the visible ground is
/// nearer.
fn resolves_penumbrae(eclipse: &EclipseUniforms, radius_px: f64) -> bool {
    smallest_penumbra(eclipse) * radius_px >= MIN_PENUMBRA_PX.max(radius_px.sqrt())
}

/// Decides on the coarse image.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let chosen = &mut decisions.chosen;
    if chosen.air_model == AtmosphereModel::None {
        return decisions;
    }
    let threshold = inputs.threshold();
    let request = inputs.frame.context.request;
    let off = |reason: Reason| (false, reason);
    let (on, reason) = match () {
        // A probe evaluates a single draw, which must not depend on a pass before it.
        () if !request.may_use_coarse_air => off(reason!("air-pass-single-draws")),
        () if !inputs.pixel_view().shows_radiance() => off(reason!("air-pass-view")),
        () if chosen.air_model == AtmosphereModel::Vertex => off(reason!("air-pass-vertex")),
        () if chosen.ring_shadow != RingShadow::None => off(reason!("air-pass-ring-shadow")),
        () if threshold.is_linear() => off(reason!("air-pass-linear")),
        () if request.quality == Quality::Reference => off(reason!("air-pass-reference")),
        () if inputs.diameter_px < MIN_DIAMETER_PX => {
            off(reason!("air-pass-small", size = format_args!("{:.0}", inputs.diameter_px), threshold = MIN_DIAMETER_PX))
        }
        () => (
            true,
            reason!(
                "air-pass",
                side = COARSE_AIR_PX,
                part = format_args!("{:.2e}", threshold.min_change()),
                dark = format_args!("{VISIBLE_LIGHT:.2e}")
            ),
        ),
    };
    chosen.air_pass = if decisions.log.record(AIR_PASS, on, reason) { AirPass::Read } else { AirPass::None };
    decisions
}

/// Sets the bounds of the interpolation's error, of the air and of the sunlight in an eclipse. The uniforms must already have their lights and their eclipse.
pub(crate) fn set_error_bounds(uniforms: &mut DrawUniforms, inputs: &DecisionInputs<'_, '_>) {
    let irradiance = uniforms.lights.first().map_or(1.0, |l| l.irradiance.max_element());
    let threshold = inputs.threshold();
    let min_relative_radiance = threshold.min_radiance() / f64::from(irradiance.max(f32::MIN_POSITIVE));
    uniforms.air.max_coarse_error = Vec2::new(camera::narrow_scalar(threshold.min_change()), camera::narrow_scalar(min_relative_radiance));
    let radius_px = inputs.body().radii_km.x / (inputs.placed.distance_km * inputs.frame.camera.pixel_tangent());
    // A negative bound: no pixel interpolates the sunlight.
    uniforms.eclipse.max_coarse_error =
        if resolves_penumbrae(&uniforms.eclipse, radius_px) { uniforms.air.max_coarse_error } else { Vec2::NEG_ONE };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniforms of one occluder at a distance and with a radius, both in the body's equatorial radii. The Sun's angular radius is 1 / 215 radian.
    fn eclipse(distance: f32, radius: f32) -> EclipseUniforms {
        EclipseUniforms {
            perpendicular_axes: [Vec4::new(1.0, 0.0, 0.0, 215.0), Vec4::Y],
            occluder_positions: vec![Vec4::new(0.0, 0.0, distance, 0.0)],
            occluder_outlines: vec![Vec4::new(1.0, 0.0, radius, radius)],
            ..EclipseUniforms::default()
        }
    }

    #[test]
    fn only_penumbrae_of_several_texels_are_interpolated() {
        let moon = eclipse(60.0, 0.27);
        // 0.27 + (60 - 1) / 215.
        assert!((smallest_penumbra(&moon) - 0.544).abs() < 1e-3, "{}", smallest_penumbra(&moon));
        // The penumbra has a radius of 35 pixels on a disc with a radius of 64, and of 27 on one of 50; MIN_PENUMBRA_PX is 32.
        assert!(resolves_penumbrae(&moon, 64.0) && resolves_penumbrae(&moon, 1e5) && !resolves_penumbrae(&moon, 50.0));
        // On a disc with a radius of 3200 pixels, a penumbra of a hundredth of that has a radius of MIN_PENUMBRA_PX = 32, but sqrt(3200) = 57 are required. On
        // one of 10,000 pixels both are 100.
        let small_moon = eclipse(1.0, 0.01);
        assert!(
            !resolves_penumbrae(&small_moon, 3199.0)
                && !resolves_penumbrae(&small_moon, 3201.0)
                && resolves_penumbrae(&small_moon, 10_001.0)
        );
        assert!(
            resolves_penumbrae(&EclipseUniforms { occluder_positions: vec![], ..moon }, 1.0),
            "without occluders there is no shadow to miss"
        );
    }
}
