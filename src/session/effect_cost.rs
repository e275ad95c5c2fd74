//! Measures the time that one effect costs in a view and how much the effect changes the image, by drawing the view with and without it.
//!
//! In: a view and an effect. Out: an [`EffectCost`]. Always: the time is measured in software on an image of limited size and scaled by the number of pixels;
//! both images have the view's exposure, so that their radiances can be compared. Not here: the cost on the GPU, which is known only per pass.

use super::{Session, SessionError};
use crate::render::plan::{FrameImages, Plan, SamplingQuality};
use crate::scene::effects::Effect;
use crate::scene::request::{Composition, ExposureRequest, ViewRequest};
use std::time::{Duration, Instant};

/// Largest number of pixels of a measured image.
const MAX_MEASURED_PIXELS: f64 = 16_000.0;
/// Number of times that the view is drawn with and without the effect, alternately; the fastest times count.
const ROUNDS: usize = 3;

/// The time that an effect costs in a view, and how much it changes the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectCost {
    /// Milliseconds that the effect adds to the drawing of an image of the view's size, at least 0. The noise is some per cent of the total time.
    pub ms: f64,
    /// How much the effect changes the image.
    pub light: LightChange,
}

/// Difference of two images of the same size, as fractions of the total luminance of the brighter image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightChange {
    /// Total luminance of the second image minus that of the first: -1..=1.
    pub net: f64,
    /// Sum of the absolute changes of the pixels' luminance: 0..=2.
    pub absolute: f64,
}

impl LightChange {
    /// The change from one image to another of the same size, in linear light.
    pub fn between(first: &[[f32; 4]], second: &[[f32; 4]]) -> Self {
        let sum = |pixels: &[[f32; 4]]| pixels.iter().map(luminance).sum::<f64>();
        let (first_total, second_total) = (sum(first), sum(second));
        let absolute = first.iter().zip(second).map(|(a, b)| (luminance(a) - luminance(b)).abs()).sum::<f64>();
        let brighter = first_total.max(second_total);
        let fraction = |change: f64| if brighter > 0.0 { change / brighter } else { 0.0 };
        Self { net: fraction(second_total - first_total), absolute: fraction(absolute) }
    }
}

fn luminance([r, g, b, _]: &[f32; 4]) -> f64 {
    crate::units::luminance([r, g, b].map(|c| f64::from(*c)))
}

impl Session {
    /// Draws `request` with and without `effect`, and compares. `stops`: the exposure of the view in stops, which both images get. `is_already_on`: the view
    /// already has the effect, by its request or automatically; otherwise the effect is switched on for the comparison. `body_name`: the effect is switched for
    /// this body alone; if `None`, for all bodies for which the request does not switch it.
    ///
    /// # Errors
    /// The reason why the view cannot be drawn.
    pub fn effect_cost(
        &self,
        request: &ViewRequest,
        stops: f64,
        (effect, is_already_on): (Effect, bool),
        body_name: Option<&str>,
    ) -> Result<EffectCost, SessionError> {
        let pixels = f64::from(request.width) * f64::from(request.height);
        let scale = (MAX_MEASURED_PIXELS / pixels).sqrt().min(1.0);
        let scaled_side = |px: u32| ((f64::from(px) * scale).round() as u32).max(1);
        let (width, height) = (scaled_side(request.width), scaled_side(request.height));
        let plan_view = |composition: &Composition, with_effect: bool| -> Result<Plan, SessionError> {
            let exposure = ExposureRequest::Stops(stops);
            let mut scaled_request = ViewRequest { width, height, exposure, composition: composition.clone(), ..request.clone() };
            match body_name {
                _ if with_effect && is_already_on => {}
                Some(name) => scaled_request.effects.own_overrides_mut(name).set(effect, with_effect),
                None => scaled_request.effects.set(effect, with_effect),
            }
            Ok(self.plan(&scaled_request, SamplingQuality::of(request.quality))?.1)
        };
        // First without the effect, then with it; the arrays below have the same order.
        let plans = [plan_view(&request.composition, false)?, plan_view(&request.composition, true)?];
        let mut fastest = [Duration::MAX; 2];
        let mut linear_images: [Vec<[f32; 4]>; 2] = [Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            for (k, plan) in plans.iter().enumerate() {
                let start = Instant::now();
                let (frame, _) = self.background_renderer().render(plan, self.library(), FrameImages::DisplayAndHdr)?;
                fastest[k] = fastest[k].min(start.elapsed());
                linear_images[k] = frame.hdr;
            }
        }
        // A stereo pair or a warped image has no linear light of its own, so the light of a single eye, or of the image before the warp, is compared.
        let without_stereo_and_warp = Composition { stereo: None, warp: None, ..request.composition.clone() };
        if without_stereo_and_warp != request.composition {
            for (linear_image, with_effect) in linear_images.iter_mut().zip([false, true]) {
                let plan = plan_view(&without_stereo_and_warp, with_effect)?;
                *linear_image = self.background_renderer().render(&plan, self.library(), FrameImages::DisplayAndHdr)?.0.hdr;
            }
        }
        let pixel_ratio = pixels / (f64::from(width) * f64::from(height));
        Ok(EffectCost {
            // An effect adds work, so a negative difference is noise.
            ms: (fastest[1].as_secs_f64() - fastest[0].as_secs_f64()).max(0.0) * 1e3 * pixel_ratio,
            light: LightChange::between(&linear_images[0], &linear_images[1]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_changes_are_fractions_of_the_brighter_image() {
        let (grey, black) = ([0.5, 0.5, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0]);
        let [to_black, to_grey, swapped, none] = [
            LightChange::between(&[grey, grey], &[grey, black]),
            LightChange::between(&[black], &[grey]),
            LightChange::between(&[grey, black], &[black, grey]),
            LightChange::between(&[black], &[black]),
        ];
        assert!((to_black.net + 0.5).abs() < 1e-6 && (to_black.absolute - 0.5).abs() < 1e-6);
        assert_eq!((to_grey.net, to_grey.absolute), (1.0, 1.0));
        assert_eq!((swapped.net, swapped.absolute), (0.0, 2.0), "the light of one pixel disappears and appears in another");
        assert_eq!((none.net, none.absolute), (0.0, 0.0));
    }
}
