//! Linear images and their differences.
//!
//! In: a session and requests for views. Out: [`LinearImage`]s, and the differences of two of them. Always: differences in levels are of the encoded value at
//! the view's exposure, not rounded to bytes, so that errors below a level can be distinguished; radiance above white counts as white.

use super::timing::quantile;
use crate::image::levels::{self, ExposedPixels};
use crate::render::plan::{self, FrameImages, Plan, SamplingQuality};
use crate::render::software::{Precision, SoftwareRenderer};
use crate::scene::Scene;
use crate::scene::request::{ExposureRequest, Quality, ViewRequest};
use crate::session::{Session, SessionError};

/// One sample per pixel, as in draft images, and at most eight taps (samples of a map along a pixel's footprint): the sampling of all images whose comparison
/// is not about sampling.
pub(crate) const SINGLE_SAMPLE: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };

/// The sampling of a view that is planned only to meter its exposure. Nothing is drawn with it.
const METERING_SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 16 };

/// An image of linear light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LinearImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Rows from the top; red, green and blue, premultiplied by the coverage, and the coverage.
    pub light: Vec<[f32; 4]>,
    /// Factor from radiance to display, where 1 is white.
    pub exposure_factor: f64,
}

impl LinearImage {
    /// Downsampled: each pixel is the average of `factor` x `factor` pixels. A rest of rows and columns is left out.
    #[must_use]
    pub(crate) fn downsampled(&self, factor: u32) -> Self {
        let (width, height) = (self.width / factor, self.height / factor);
        let mean = |x: u32, y: u32| {
            let mut sum = [0.0_f64; 4];
            for (dx, dy) in (0..factor).flat_map(|dy| (0..factor).map(move |dx| (dx, dy))) {
                let pixel = self.light[((y * factor + dy) * self.width + x * factor + dx) as usize];
                sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += f64::from(value));
            }
            sum.map(|sum| (sum / f64::from(factor * factor)) as f32)
        };
        let light = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
        Self { width, height, light, exposure_factor: self.exposure_factor }
    }

    /// Scaled to another size by bilinear interpolation of radiance between pixel centres, as a window shows a coarser image.
    #[must_use]
    pub(crate) fn upsampled(&self, width: u32, height: u32) -> Self {
        // Along one axis: the two pixels around pixel `k` of the upsampled image, and the weight of the second.
        let neighbours = |k: u32, side: u32, upsampled_side: u32| {
            let position = ((f64::from(k) + 0.5) * f64::from(side) / f64::from(upsampled_side) - 0.5).clamp(0.0, f64::from(side - 1));
            let first = position.floor() as u32;
            (first, (first + 1).min(side - 1), position.fract() as f32)
        };
        let pixel_at = |x: u32, y: u32| self.light[(y * self.width + x) as usize];
        let lerp = |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
        let mut light = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            let (y0, y1, ty) = neighbours(y, self.height, height);
            for x in 0..width {
                let (x0, x1, tx) = neighbours(x, self.width, width);
                light.push(lerp(lerp(pixel_at(x0, y0), pixel_at(x1, y0), tx), lerp(pixel_at(x0, y1), pixel_at(x1, y1), tx), ty));
            }
        }
        Self { width, height, light, exposure_factor: self.exposure_factor }
    }

    fn exposed_pixels(&self) -> ExposedPixels<'_> {
        ExposedPixels { light: &self.light, exposure_factor: self.exposure_factor }
    }
}

/// The larger value; NaN, which `f64::max` ignores, counts as the largest.
pub(crate) fn larger_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The precision in which the software renderer draws images of a quality, as `--quality` sets it.
pub(super) fn precision_of(quality: Quality) -> Precision {
    if quality == Quality::Reference { Precision::F64 } else { Precision::F32 }
}

/// For each pixel, the greatest difference of red, green or blue, in display levels (0 to 255). The images have the same size.
pub(crate) fn level_differences(a: &LinearImage, b: &LinearImage) -> Vec<f64> {
    levels::level_differences(a.exposed_pixels(), b.exposed_pixels())
}

/// The 99.9th percentile; 0 for no values.
pub(crate) fn p999(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.999).unwrap_or(0.0)
}

/// Draws views with the software renderer, in f32 or f64.
pub(crate) struct PrecisionRenderers<'a> {
    pub session: &'a Session,
    /// In f32.
    single: SoftwareRenderer,
    /// In f64.
    double: SoftwareRenderer,
}

impl<'a> PrecisionRenderers<'a> {
    pub(crate) fn new(session: &'a Session) -> Result<Self, SessionError> {
        let renderer_in = |precision: Precision| session.renderer_in(precision == Precision::F64);
        Ok(Self { session, single: renderer_in(Precision::F32)?, double: renderer_in(Precision::F64)? })
    }

    pub(crate) fn renderer(&self, precision: Precision) -> &SoftwareRenderer {
        match precision {
            Precision::F32 => &self.single,
            Precision::F64 => &self.double,
        }
    }

    /// Plans a view that is to be drawn repeatedly.
    pub(crate) fn plan_view(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<PlannedView, SessionError> {
        let (scene, plan) = self.session.plan(request, sampling)?;
        Ok(PlannedView { scene, plan })
    }

    /// Draws the view and returns its linear image.
    pub(crate) fn draw_linear(&self, view: &PlannedView, precision: Precision) -> Result<LinearImage, SessionError> {
        let (frame, _timings) = self.renderer(precision).render(&view.plan, self.session.library(), FrameImages::DisplayAndHdr)?;
        let exposure_factor = view.scene.exposure.factor();
        Ok(LinearImage { width: frame.width, height: frame.height, light: frame.hdr, exposure_factor })
    }

    /// Draws the view and discards the result, for timing.
    pub(crate) fn draw(&self, view: &PlannedView, precision: Precision) -> Result<(), SessionError> {
        self.renderer(precision).render(&view.plan, self.session.library(), FrameImages::Display)?;
        Ok(())
    }

    /// Plans a view with the draws of its target alone, because other, small bodies change from points to discs as the image grows. Without a target: with the
    /// draws of all bodies.
    pub(crate) fn plan_target_body(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<PlannedView, SessionError> {
        let mut scene = self.plan_view(request, sampling)?.scene;
        scene.draws.retain(|d| request.target.is_none_or(|target| d.body == target));
        let plan = plan::plan(&scene, self.session, sampling)?;
        Ok(PlannedView { scene, plan })
    }

    /// The same view with the exposure fixed at the value that the view as requested has, so that all images that are compared have the same exposure.
    pub(crate) fn with_metered_exposure(&self, request: ViewRequest) -> Result<ViewRequest, SessionError> {
        let stops = self.plan_view(&request, METERING_SAMPLING)?.scene.exposure.stops;
        Ok(ViewRequest { exposure: ExposureRequest::Stops(stops), ..request })
    }
}

/// A view that is ready to be drawn: its scene and its plan.
pub(crate) struct PlannedView {
    pub scene: Scene,
    pub plan: Plan,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn red_image(width: u32, height: u32, red: impl Fn(u32, u32) -> f32) -> LinearImage {
        let light = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| [red(x, y), 0.0, 0.0, 1.0]).collect();
        LinearImage { width, height, light, exposure_factor: 1.0 }
    }

    #[test]
    fn downsampling_and_upsampling_do_not_shift_light() {
        let ramp = red_image(8, 4, |x, _| x as f32);
        let half = ramp.downsampled(2);
        assert_eq!((half.width, half.height), (4, 2));
        assert_eq!(half.light.iter().map(|p| p[0]).collect::<Vec<_>>(), [0.5, 2.5, 4.5, 6.5, 0.5, 2.5, 4.5, 6.5]);
        // Between the centres of the outermost pixels of `half`, the ramp is reproduced.
        let back = half.upsampled(8, 4);
        assert!((1..7).all(|x| (back.light[x][0] - ramp.light[x][0]).abs() < 1e-6), "{:?}", &back.light[..8]);
        assert_eq!(ramp.upsampled(8, 4), ramp);
    }

    #[test]
    fn levels_follow_the_exposure() {
        let (black, white) = (red_image(2, 1, |_, _| 0.0), red_image(2, 1, |x, _| if x == 0 { 0.0 } else { 3.0 }));
        let difference = level_differences(&black, &white);
        assert!(difference[0] == 0.0 && (difference[1] - 255.0).abs() < 1e-9, "{difference:?}");
        let dark = LinearImage { exposure_factor: 0.0, ..white };
        assert_eq!(p999(level_differences(&black, &dark)), 0.0);
        assert_eq!(p999((0..=1000).map(f64::from).collect()), 999.0);
        assert_eq!(p999(Vec::new()), 0.0);
    }
}
