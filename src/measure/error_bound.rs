//! Error bounds of an image relative to the reference quality, computed without drawing the complete reference image.
//!
//! In: a view. Out: an image of bounds, in linear light and in display levels (255ths). Always: the bound of a pixel is a sum of five terms:
//! - models: the difference from the same image with the reference's models and taps, times 1.25;
//! - the stated errors of the reference's models ([`stated_errors`](crate::scene::stated_errors));
//! - rounding: twice the difference of f32 and f64, plus 1e-6 of the light;
//! - sampling: a fraction of the difference from the neighbouring pixels;
//! - effects left out because they are below the threshold of visibility (only on a display): the threshold once, for all of them together.
//!
//! The bounds hold for this program's models; docs/accuracy.md lists effects that none of them includes. Bounds in display levels leave out bloom and the tone
//! map (see `level_bound`).

use super::images::{PlannedView, PrecisionRenderers, larger_or_nan, precision_of};
use crate::render::frame::Frame;
use crate::render::plan::SamplingQuality;
use crate::render::software::Precision;
use crate::scene::SceneError;
use crate::scene::draw::{EclipseModel, PixelView};
use crate::scene::effects::{Effect, VISIBLE_CHANGE, VISIBLE_LIGHT};
use crate::scene::request::{ExposureRequest, Purpose, Quality, ViewRequest};
use crate::scene::stated_errors;
use crate::session::{Session, SessionError};
use crate::units::linear_to_srgb;

/// Bound of the error of a shading edge inside a pixel. `difference`: the greatest difference of light between the pixel and its eight neighbours. Limbs and
/// rings need no such bound, because they are antialiased analytically. The fractions are empirical: tests/cli/error_bound.rs checks that bounds with them
/// hold. Images of standard quality have as many samples per pixel as the reference, so for them
/// the fraction is a mere margin.
fn sampling_error(quality: Quality, difference: f64) -> f64 {
    match quality {
        Quality::Draft => 0.5 * difference,
        Quality::Standard => 0.25 * difference,
        // Not 0 times the difference, which is NaN beside a pixel of infinite light.
        Quality::Reference => 0.0,
    }
}

/// A margin on the difference from the image with the reference's models, because that image is drawn in f32 and with the view's own number of samples.
const MODEL_DIFFERENCE_FACTOR: f64 = 1.25;

/// What the bound of the atmosphere models' error is computed from.
struct AirInputs {
    /// The image without atmospheres.
    airless: Vec<[f32; 4]>,
    /// Optical depth along each pixel's ray, per colour channel.
    optical_depth: Vec<[f32; 4]>,
    /// Largest error of the atmosphere models, as a fraction of the scattered light.
    max_error: f64,
}

/// The images from which the bounds of a view are computed.
struct BoundInputs {
    /// The image in the quality's precision.
    shown: Vec<[f32; 4]>,
    /// The image in the other precision, f32 or f64.
    shown_in_other_precision: Vec<[f32; 4]>,
    /// The image with the reference's models and taps, in f32.
    reference_models: Vec<[f32; 4]>,
    /// The image without eclipses, and the largest error of the eclipse models as a fraction of the light in this image. `None` if the view has no eclipse.
    without_eclipses: Option<(Vec<[f32; 4]>, f64)>,
    /// `None` if the view has no atmosphere.
    air: Option<AirInputs>,
}

/// Checks that bounds exist for the image of a request: they are computed from its linear light, and stereo pairs and warped images have only display values.
///
/// # Errors
/// The reason why it has none.
pub(crate) fn check_has_bounds(request: &ViewRequest) -> Result<(), SceneError> {
    let why = "stereo pairs and warped images have only display values, for which there is no bound of the error";
    let has_linear_light = request.composition.stereo.is_none() && request.composition.warp.is_none();
    if has_linear_light { Ok(()) } else { Err(SceneError::Request(why.into())) }
}

/// The bounds of a view's image at the request's quality: linear light in the frame's `hdr`, 255ths in its `display`.
///
/// # Errors
/// The reason why the view cannot be drawn, or why its image has no bounds.
pub(crate) fn error_bounds(session: &Session, request: &ViewRequest) -> Result<Frame, SessionError> {
    check_has_bounds(request)?;
    let renderers = PrecisionRenderers::new(session)?;
    let sampling = SamplingQuality::of(request.quality);
    let view = renderers.plan_view(request, sampling)?;
    let inputs = bound_inputs(&renderers, request, &view)?;
    let exposure_factor = view.scene.exposure.factor();
    let is_display = view.scene.purpose == Purpose::Display;
    let (width, height) = (request.width, request.height);
    let (mut hdr, mut display) = (Vec::new(), Vec::new());
    for (k, pixel) in inputs.shown.iter().enumerate() {
        let from_neighbours = neighbour_difference(&inputs.shown, width, k);
        let bound: [f64; 3] = std::array::from_fn(|c| {
            let light = f64::from(pixel[c]);
            let rounding = 2.0 * f64::from((pixel[c] - inputs.shown_in_other_precision[k][c]).abs()) + 1e-6 * light.abs();
            let eclipse = inputs
                .without_eclipses
                .as_ref()
                .map_or(0.0, |(unshadowed, max_error)| eclipse_error(light, f64::from(unshadowed[k][c]), *max_error));
            let air = inputs
                .air
                .as_ref()
                .map_or(0.0, |air| air_error(light, f64::from(air.airless[k][c]), f64::from(air.optical_depth[k][c]), air.max_error));
            let models = MODEL_DIFFERENCE_FACTOR * f64::from((pixel[c] - inputs.reference_models[k][c]).abs());
            // `VISIBLE_LIGHT` is a fraction of white; the exposure factor converts it to light.
            let left_out_effects = if is_display { VISIBLE_LIGHT / exposure_factor + VISIBLE_CHANGE * light.abs() } else { 0.0 };
            known_or_infinite(rounding + models + eclipse + air + sampling_error(request.quality, from_neighbours[c]) + left_out_effects)
        });
        hdr.push([bound[0] as f32, bound[1] as f32, bound[2] as f32, 1.0]);
        // With a tone map that preserves hue each channel depends on the others, so the largest bound applies to all.
        let worst = bound.into_iter().fold(0.0, f64::max);
        let levels = [0, 1, 2].map(|c| level_bound(f64::from(pixel[c]) * exposure_factor, worst * exposure_factor));
        display.push([levels[0], levels[1], levels[2], u8::MAX]);
    }
    Ok(Frame { width, height, hdr, display })
}

/// Bound of the error of the eclipse model, from the light with and without eclipses; 0 where eclipses change at most 1e-6 of the light, which
/// may be rounding. NaN if `unshadowed` is NaN; if `light` is, the bound of rounding is NaN.
fn eclipse_error(light: f64, unshadowed: f64, max_error: f64) -> f64 {
    if (unshadowed - light).abs() <= 1e-6 * unshadowed { 0.0 } else { max_error * unshadowed }
}

/// Bound of the error of the atmosphere model, from the light with and without atmospheres. `max_error` applies to the scattered light: what remains without
/// the transmitted light. The error of the transmittance is added. NaN if an input is NaN.
fn air_error(light: f64, airless: f64, optical_depth: f64, max_error: f64) -> f64 {
    let transmitted = airless * (-optical_depth).exp();
    let scattered = if light <= transmitted { 0.0 } else { light - transmitted };
    max_error * scattered + stated_errors::AIR_TRANSMITTANCE * airless
}

/// The bound of a channel; infinite if it is not a number, because then nothing is known of the channel (`f64::max` would ignore it).
fn known_or_infinite(bound: f64) -> f64 {
    if bound.is_nan() { f64::INFINITY } else { bound }
}

/// Bound of the error of the display level (255ths), from a bound of the error of the exposed radiance `light`; includes one level for rounding to bytes. The
/// tone map is left out: the slope of its curve is at most 1. Bloom is left out, too: it spreads about a seventh of the light above white, and so of its
/// error, to other pixels (`BLOOM_NARROW` and `BLOOM_WIDE`).
fn level_bound(light: f64, bound: f64) -> u8 {
    if !(light + bound).is_finite() {
        return u8::MAX;
    }
    let level = |light: f64| 255.0 * linear_to_srgb(light.max(0.0));
    let difference = (level(light + bound) - level(light)).max(level(light) - level(light - bound));
    (difference.ceil() + 1.0).min(255.0) as u8
}

/// Greatest absolute difference of light between pixel `k` and its eight neighbours, per channel; NaN if one of them is not a number.
fn neighbour_difference(light: &[[f32; 4]], width: u32, k: usize) -> [f64; 3] {
    let (w, h) = (width as i64, (light.len() / width as usize) as i64);
    let (x, y) = (k as i64 % w, k as i64 / w);
    let mut greatest = [0.0_f64; 3];
    for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
        let (nx, ny) = ((x + dx).clamp(0, w - 1), (y + dy).clamp(0, h - 1));
        let neighbour = light[(ny * w + nx) as usize];
        for (c, greatest) in greatest.iter_mut().enumerate() {
            *greatest = larger_or_nan(*greatest, f64::from((neighbour[c] - light[k][c]).abs()));
        }
    }
    greatest
}

/// Draws the images from which the bounds of a view are computed, all at the view's exposure.
fn bound_inputs(renderers: &PrecisionRenderers<'_>, request: &ViewRequest, view: &PlannedView) -> Result<BoundInputs, SessionError> {
    let sampling = SamplingQuality::of(request.quality);
    let precision = precision_of(request.quality);
    let other_precision = if precision == Precision::F64 { Precision::F32 } else { Precision::F64 };
    let request_at_exposure = ViewRequest { exposure: ExposureRequest::Stops(view.scene.exposure.stops), ..request.clone() };
    let draw = |request: &ViewRequest| {
        Ok::<_, SessionError>(renderers.draw_linear(&renderers.plan_view(request, sampling)?, Precision::F32)?.light)
    };
    let without = |effect: Effect| {
        let mut request = request_at_exposure.clone();
        request.effects.set(effect, false);
        request
    };
    // How far the view's models differ from the reference's is measured with this image; how far those are wrong is known only from their stated errors. The
    // image has the reference's taps (anisotropy), but the view's number of samples.
    let reference_request = ViewRequest { quality: Quality::Reference, ..request_at_exposure.clone() };
    let reference_models_view = renderers
        .plan_view(&reference_request, SamplingQuality { anisotropy: SamplingQuality::of(Quality::Reference).anisotropy, ..sampling })?;
    // The scene of an entire sphere has no draws of bodies: those are in the frames of its faces, and so in the plan.
    let features_in_frames = reference_models_view.plan.features_of_bodies();
    let features = || reference_models_view.scene.draws.iter().map(|d| d.features).chain(features_in_frames.iter().copied());
    let max_eclipse_error =
        features().filter_map(|f| stated_errors::of_eclipse(f.eclipse.model)).map(|stated| stated.max_error).fold(0.0, f64::max);
    let without_eclipses = if features().any(|f| f.eclipse.model != EclipseModel::None) {
        Some((draw(&without(Effect::Eclipse))?, max_eclipse_error))
    } else {
        None
    };
    let air = if let Some(max_error) =
        features().filter_map(|f| stated_errors::of_atmosphere(f.air.model)).map(|stated| stated.max_error).reduce(f64::max)
    {
        let depth_request = ViewRequest { pixel_view: PixelView::OpticalDepth, ..request_at_exposure.clone() };
        Some(AirInputs { airless: draw(&without(Effect::Atmosphere))?, optical_depth: draw(&depth_request)?, max_error })
    } else {
        None
    };
    let shown = renderers.draw_linear(view, precision)?.light;
    let shown_in_other_precision = renderers.draw_linear(view, other_precision)?.light;
    let reference_models = renderers.draw_linear(&reference_models_view, Precision::F32)?.light;
    Ok(BoundInputs { shown, shown_in_other_precision, reference_models, without_eclipses, air })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_in_levels_covers_every_light_within_its_bound() {
        assert_eq!(level_bound(0.5, 0.0), 1);
        let level = |light: f64| 255.0 * linear_to_srgb(light);
        for light in [0.0, 1e-4, 0.02, 0.3, 0.9] {
            for bound in [1e-5, 1e-3, 0.05] {
                let greatest = f64::from(level_bound(light, bound));
                for deviation in [-bound, -0.5 * bound, bound] {
                    let change = (level((light + deviation).max(0.0)).round() - level(light).round()).abs();
                    assert!(change <= greatest, "light {light}, deviation {deviation}: {change} levels, {greatest} stated");
                }
            }
        }
        assert_eq!(level_bound(0.0, 1e9), 255);
    }

    /// Light of a pixel that overflows in one of the precisions.
    #[test]
    fn a_bound_that_is_not_a_number_is_the_greatest() {
        assert_eq!([0.5, f64::NAN, f64::INFINITY].map(known_or_infinite), [0.5, f64::INFINITY, f64::INFINITY]);
        for (light, bound) in [(0.5, f64::INFINITY), (f64::NAN, 0.1), (f64::INFINITY, 0.1), (0.5, f64::NAN)] {
            assert_eq!(level_bound(light, bound), 255, "light {light}, bound {bound}");
        }
    }

    /// `f64::max` and comparisons with NaN would give an error of 0.
    #[test]
    fn an_input_that_is_not_a_number_is_not_taken_for_no_error() {
        assert_eq!([eclipse_error(0.5, 0.5, 0.1), eclipse_error(0.5, 1.0, 0.1)], [0.0, 0.1]);
        assert!(eclipse_error(0.5, f64::NAN, 0.1).is_nan() && eclipse_error(f64::NAN, 0.5, 0.1) == 0.05);
        assert_eq!(air_error(0.5, 0.0, 0.0, 0.1), 0.05);
        assert_eq!(air_error(0.25, 0.5, 0.0, 0.1), stated_errors::AIR_TRANSMITTANCE * 0.5);
        assert!(air_error(0.5, 0.5, f64::NAN, 0.1).is_nan());
        let mut light = vec![[0.5, 0.5, 0.5, 1.0]; 25];
        light[12] = [f32::NAN, f32::INFINITY, 0.5, 1.0];
        // The image has 5x5 pixels: pixel 6 touches pixel 12, the centre; pixel 4, a corner, does not.
        let near = neighbour_difference(&light, 5, 6);
        assert!(near[0].is_nan() && near[1] == f64::INFINITY && near[2] == 0.0, "{near:?}");
        assert_eq!(neighbour_difference(&light, 5, 4), [0.0; 3]);
        assert!(sampling_error(Quality::Standard, near[0]).is_nan());
        assert_eq!([Quality::Standard, Quality::Reference].map(|quality| sampling_error(quality, near[1])), [f64::INFINITY, 0.0]);
    }

    #[test]
    fn the_neighbour_difference_is_the_greatest() {
        let mut light = vec![[0.5, 0.5, 0.5, 1.0]; 25];
        light[12] = [0.9, 0.5, 0.1, 1.0];
        let near = neighbour_difference(&light, 5, 6);
        assert!((near[0] - 0.4).abs() < 1e-6 && near[1] == 0.0 && (near[2] - 0.4).abs() < 1e-6);
        assert_eq!(neighbour_difference(&light, 5, 4), [0.0; 3]);
    }
}
