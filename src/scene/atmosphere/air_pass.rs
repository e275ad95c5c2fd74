//! Whether the air before a body's ground and clouds is drawn as a coarse picture of its own, which their pixels interpolate.
//!
//! In: the case of one body and its decisions so far. Out: the decisions, with the bound of the interpolation's error. Always: where the error may exceed the
//! bound, such as at the limb, a pixel evaluates its own air (shaders/lib/air/coarse.wesl), so the decision changes a picture by no more than the bound.

use crate::message::{Reason, reason};
use crate::scene::camera;
use crate::scene::constants::COARSE_AIR_PX;
use crate::scene::draw::features::{AtmosphereModel, PixelView, RingShadow};
use crate::scene::draw::uniforms::DrawUniforms;
use crate::scene::features::case::{BodyContext, Decisions};
use crate::scene::request::view_request::Quality;
use crate::scene::thresholds::VISIBLE_LIGHT;
use glam::Vec2;

/// Name of the decision.
pub(crate) const AIR_PASS: &str = "air-pass";

/// Diameter of a disc in pixels from which on a coarse picture is worth its two passes: below, most pixels are near the limb, where each evaluates its air.
const MIN_DIAMETER_PX: f64 = 128.0;

/// Decides on the coarse picture.
pub(crate) fn decide<'c>(case: &BodyContext<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    let chosen = &mut so_far.chosen;
    if chosen.air == AtmosphereModel::None {
        return so_far;
    }
    let threshold = case.threshold();
    let request = case.frame.context.request;
    let off = |reason: Reason| (false, reason);
    let (on, reason) = match () {
        () if !request.coarse_air => off(reason!("air-pass-single-draws")),
        () if !matches!(case.pixel_view(), PixelView::Final | PixelView::Cost) => off(reason!("air-pass-view")),
        () if chosen.air == AtmosphereModel::Vertex => off(reason!("air-pass-vertex")),
        () if chosen.ring_shadow != RingShadow::None => off(reason!("air-pass-ring-shadow")),
        () if threshold.is_linear() => off(reason!("air-pass-linear")),
        () if request.quality == Quality::Reference => off(reason!("air-pass-reference")),
        () if case.diameter_px < MIN_DIAMETER_PX => {
            off(reason!("air-pass-small", size = format_args!("{:.0}", case.diameter_px), least = MIN_DIAMETER_PX))
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
    chosen.air_pass = so_far.log.note(AIR_PASS, on, reason);
    so_far
}

/// Sets the bound of the interpolation's error. Called when the draw has its lights.
pub(crate) fn set_bound(uniforms: &mut DrawUniforms, case: &BodyContext<'_, '_>) {
    let irradiance = uniforms.lights.first().map_or(1.0, |l| l.irradiance.max_element());
    let threshold = case.threshold();
    let on_black = threshold.least_radiance() / f64::from(irradiance.max(f32::MIN_POSITIVE));
    uniforms.air.coarse_bound = Vec2::new(camera::narrow_scalar(threshold.min_change()), camera::narrow_scalar(on_black));
}
