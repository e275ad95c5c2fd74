//! The sample body (a fixed body, see `session::sample_body`) drawn by a module: images in f32 and f64, and their statistics.
//!
//! In: a module built from a shader key. Out: a `SampleImage`. Always: an image is drawn on one thread, so that as many images as there are cores can be
//! drawn in parallel; the renderer keeps nothing of a module after its image.

use crate::image::levels::{self, ExposedPixels};
use crate::render::plan::{FrameImages, ModuleProvider, Plan};
use crate::render::software::kernels::KernelClass;
use crate::render::software::{Options, Precision, SoftwareRenderer};
use crate::session::{SAMPLE_HALF_SIDE_WITH_LIMB, SessionError, sample_body_plan_of};
use crate::shader::key::ShaderKey;
use crate::shader::{ModuleId, ShaderError, ShaderModule};
use crate::units::luminance;
use rayon::prelude::*;
use std::sync::Arc;

/// The sample body drawn by a module, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SampleImage {
    /// Width and height in pixels.
    pub side_px: u32,
    /// Linear RGBA, premultiplied, in f32.
    pub f32_pixels: Vec<[f32; 4]>,
    /// The result of the same tape in f64, rounded to f32 at the end.
    pub f64_pixels: Vec<[f32; 4]>,
}

/// For each pixel, the greatest difference of a channel, in display levels of 255. A white Lambert surface in full sunlight has level 255.
pub(crate) fn level_differences(first: &[[f32; 4]], second: &[[f32; 4]]) -> Vec<f64> {
    let exposed = |light| ExposedPixels { light, exposure_factor: 1.0 };
    levels::level_differences(exposed(first), exposed(second))
}

impl SampleImage {
    /// Mean luminance of the f64 image, relative to a white Lambert surface in full sunlight.
    pub(crate) fn mean_luminance(&self) -> f64 {
        let sum: f64 = self.f64_pixels.iter().map(|p| luminance([p[0], p[1], p[2]].map(f64::from))).sum();
        sum / self.f64_pixels.len().max(1) as f64
    }

    /// The greatest difference between the f32 and the f64 image, display levels.
    pub(crate) fn rounding_levels(&self) -> f64 {
        level_differences(&self.f32_pixels, &self.f64_pixels).into_iter().fold(0.0, f64::max)
    }

    /// Display bytes of the f32 image, on black. `fit_to_white`: scales the image so that its brightest channel is white, for images that show counts.
    pub(crate) fn display(&self, fit_to_white: bool) -> Vec<[u8; 4]> {
        let brightest = self.f32_pixels.iter().flat_map(|p| p[..3].iter().copied()).fold(0.0, f32::max);
        let factor = if fit_to_white && brightest > 0.0 { 1.0 / brightest } else { 1.0 };
        let byte = |light: f32| levels::display_level(light, f64::from(factor)).round() as u8;
        self.f32_pixels.iter().map(|[r, g, b, _]| [byte(*r), byte(*g), byte(*b), 255]).collect()
    }
}

/// Draws the sample body with modules, in f32 and in f64.
pub(crate) struct SampleBodyRenderer {
    /// Width and height of the images, pixels.
    side_px: u32,
    f32_renderer: SoftwareRenderer,
    f64_renderer: SoftwareRenderer,
}

/// Maps items in parallel on all cores: `make` gets each item with a renderer for images of `side_px` x `side_px` pixels. If that renderer cannot be created,
/// `renderer_error` gives the item's error. `on_item_done` is called after each item, from any thread. The results are in the order of the items.
pub(super) fn map_with_renderers<I: Sync, T: Send, E: Send>(
    side_px: u32,
    items: &[I],
    make: impl Fn(&SampleBodyRenderer, &I) -> Result<T, E> + Sync,
    renderer_error: impl Fn(&I, &SessionError) -> E + Sync,
    on_item_done: impl Fn() + Sync,
) -> Vec<Result<T, E>> {
    let make_one = |renderer: &mut Result<SampleBodyRenderer, SessionError>, item: &I| {
        let result = match renderer {
            Ok(renderer) => make(renderer, item),
            Err(e) => Err(renderer_error(item, e)),
        };
        on_item_done();
        result
    };
    items.par_iter().map_init(|| SampleBodyRenderer::new(side_px), make_one).collect()
}

/// A provider that returns the same module for every id.
struct FixedModule<'a>(&'a Arc<ShaderModule>);

impl ModuleProvider for FixedModule<'_> {
    fn module(&self, _: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        Ok(Arc::clone(self.0))
    }
}

impl SampleBodyRenderer {
    /// A renderer for images of `side_px` x `side_px` pixels. It uses the portable kernels, which give the same bits on every machine.
    ///
    /// # Errors
    /// The renderer's thread cannot be started.
    pub(crate) fn new(side_px: u32) -> Result<Self, SessionError> {
        let renderer =
            |precision| SoftwareRenderer::new(Options { threads: 1, precision, kernel_class: KernelClass::Portable, ..Options::default() });
        Ok(Self { side_px, f32_renderer: renderer(Precision::F32)?, f64_renderer: renderer(Precision::F64)? })
    }

    /// The plan that draws the sample body with the module of a key.
    ///
    /// # Errors
    /// See [`sample_body_plan_of`].
    pub(crate) fn plan(&self, module: &ShaderModule, key: &ShaderKey) -> Result<Plan, SessionError> {
        sample_body_plan_of(module, key, self.side_px, SAMPLE_HALF_SIDE_WITH_LIMB)
    }

    /// Draws the sample body with the module of a key.
    ///
    /// # Errors
    /// The module needs something that the sample body lacks, or cannot be run.
    pub(crate) fn draw(&self, module: &Arc<ShaderModule>, key: &ShaderKey) -> Result<SampleImage, SessionError> {
        let plan = self.plan(module, key)?;
        let hdr_pixels = |renderer: &SoftwareRenderer| -> Result<Vec<[f32; 4]>, SessionError> {
            let drawn = renderer.render(&plan, &FixedModule(module), FrameImages::DisplayAndHdr);
            // The next module may have the same id, and thousands of modules may follow.
            renderer.forget_modules();
            let (frame, _) = drawn?;
            Ok(frame.hdr)
        };
        let (f32_pixels, f64_pixels) = (hdr_pixels(&self.f32_renderer)?, hdr_pixels(&self.f64_renderer)?);
        Ok(SampleImage { side_px: self.side_px, f32_pixels, f64_pixels })
    }
}
