//! Whether the air before a body's ground and clouds is drawn as a coarse image of its own, which their pixels interpolate.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, with the bound of the interpolation's error. Always: where the error may exceed the
//! bound, such as at the limb, a pixel evaluates its own air (shaders/lib/air/coarse.wesl), so the decision changes an image by no more than the bound.

use crate::message::{Reason, reason};
use crate::scene::camera;
use crate::scene::constants::COARSE_AIR_PX;
use crate::scene::draw::features::{AirPass, AtmosphereModel, PixelView, RingShadow};
use crate::scene::draw::uniforms::{DrawUniforms, EclipseUniforms};
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::request::view_request::Quality;
use crate::scene::thresholds::VISIBLE_LIGHT;
use glam::Vec2;

/// Name of the decision.
pub(crate) const AIR_PASS: &str = "air-pass";

/// Diameter of a disc in pixels from which on a coarse image is worth its two passes: below, most pixels are near the limb, where each evaluates its air.
const MIN_DIAMETER_PX: f64 = 128.0;

/// Radius of a penumbra in pixels from which on the sunlight is interpolated: eight texels, of which one or two remain where the ground is seen at a low angle.
const MIN_PENUMBRA_PX: f64 = 8.0 * COARSE_AIR_PX as f64;

/// Radius of the smallest occluder's penumbra beside the body's centre, in the body's equatorial radii.
fn smallest_penumbra(eclipse: &EclipseUniforms) -> f64 {
    let tan_sun_radius = 1.0 / f64::from(eclipse.across[0].w);
    let occluders = eclipse.occluder_positions.iter().zip(&eclipse.occluder_outlines);
    occluders.map(|(position, outline)| f64::from(outline.w) + f64::from(position.z) * tan_sun_radius).fold(f64::INFINITY, f64::min)
}

/// Decides on the coarse image.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let chosen = &mut decisions.chosen;
    if chosen.air == AtmosphereModel::None {
        return decisions;
    }
    let threshold = inputs.threshold();
    let request = inputs.frame.context.request;
    let off = |reason: Reason| (false, reason);
    let (on, reason) = match () {
        () if !request.coarse_air => off(reason!("air-pass-single-draws")),
        () if !matches!(inputs.pixel_view(), PixelView::Final | PixelView::Cost) => off(reason!("air-pass-view")),
        () if chosen.air == AtmosphereModel::Vertex => off(reason!("air-pass-vertex")),
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
    chosen.air_pass = if decisions.log.note(AIR_PASS, on, reason) { AirPass::Read } else { AirPass::None };
    decisions
}

/// Sets the bound of the interpolation's error. Called when the draw has its lights.
pub(crate) fn set_bound(uniforms: &mut DrawUniforms, inputs: &DecisionInputs<'_, '_>) {
    let irradiance = uniforms.lights.first().map_or(1.0, |l| l.irradiance.max_element());
    let threshold = inputs.threshold();
    let on_black = threshold.min_radiance() / f64::from(irradiance.max(f32::MIN_POSITIVE));
    uniforms.air.coarse_bound = Vec2::new(camera::narrow_scalar(threshold.min_change()), camera::narrow_scalar(on_black));
    // Between the texels of a smaller shadow no difference would show that it is there.
    let is_seen = smallest_penumbra(&uniforms.eclipse) * 0.5 * inputs.diameter_px >= MIN_PENUMBRA_PX;
    uniforms.eclipse.coarse_bound = if is_seen { uniforms.air.coarse_bound } else { Vec2::NEG_ONE };
}
