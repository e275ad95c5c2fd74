//! The sample body drawn by a module: images in f32 and f64, and their statistics.
//!
//! In: a module built from a shader key. Out: a `SampleImage`. Always: one image is drawn on one thread, so that many can be drawn in parallel on
//! all cores; the renderer keeps nothing of the module.

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
    pub side: u32,
    /// Linear RGBA, premultiplied, in f32.
    pub single: Vec<[f32; 4]>,
    /// The result of the same tape in f64, rounded to f32 at the end.
    pub double: Vec<[f32; 4]>,
}

/// For each pixel, the greatest difference of any channel in display levels, where white is a white Lambert surface in full sunlight.
pub(crate) fn level_differences(first: &[[f32; 4]], second: &[[f32; 4]]) -> Vec<f64> {
    let exposed = |light| ExposedPixels { light, exposure_factor: 1.0 };
    levels::level_differences(exposed(first), exposed(second))
}

impl SampleImage {
    /// Mean luminance of the image in f64, relative to a white surface.
    pub(crate) fn mean_luminance(&self) -> f64 {
        let sum: f64 = self.double.iter().map(|p| luminance([p[0], p[1], p[2]].map(f64::from))).sum();
        sum / self.double.len().max(1) as f64
    }

    /// The greatest difference between f32 and f64, display levels.
    pub(crate) fn rounding_levels(&self) -> f64 {
        level_differences(&self.single, &self.double).into_iter().fold(0.0, f64::max)
    }

    /// Display bytes of the f32 image, on black. `fitted`: scaled so that the brightest channel is white, for images that show counts.
    pub(crate) fn display(&self, fitted: bool) -> Vec<[u8; 4]> {
        let brightest = self.single.iter().flat_map(|p| p[..3].iter().copied()).fold(0.0, f32::max);
        let factor = if fitted && brightest > 0.0 { 1.0 / brightest } else { 1.0 };
        let byte = |light: f32| levels::display_level(light, f64::from(factor)).round() as u8;
        self.single.iter().map(|[r, g, b, _]| [byte(*r), byte(*g), byte(*b), 255]).collect()
    }
}

/// Draws the sample body with modules.
pub(crate) struct SampleBodyRenderer {
    side: u32,
    single: SoftwareRenderer,
    double: SoftwareRenderer,
}

/// Runs `make` on all cores, once for each item, with a renderer for images of `side` x `side` pixels. If the renderer cannot be created,
/// `no_renderer` gives the item's error. `done` is called after each item. The results are in the order of the items.
pub(super) fn make_all<I: Sync, T: Send, E: Send>(
    side: u32,
    items: &[I],
    make: impl Fn(&SampleBodyRenderer, &I) -> Result<T, E> + Sync,
    no_renderer: impl Fn(&I, &SessionError) -> E + Sync,
    done: impl Fn() + Sync,
) -> Vec<Result<T, E>> {
    let make_one = |renderer: &mut Result<SampleBodyRenderer, SessionError>, item: &I| {
        let result = match renderer {
            Ok(renderer) => make(renderer, item),
            Err(e) => Err(no_renderer(item, e)),
        };
        done();
        result
    };
    items.par_iter().map_init(|| SampleBodyRenderer::new(side), make_one).collect()
}

/// A provider that returns its one module for every id.
struct SingleModule<'a>(&'a Arc<ShaderModule>);

impl ModuleProvider for SingleModule<'_> {
    fn module(&self, _: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        Ok(Arc::clone(self.0))
    }
}

impl SampleBodyRenderer {
    /// A renderer for images of `side` x `side` pixels. It uses the portable kernels, which give the same bits on every machine.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(crate) fn new(side: u32) -> Result<Self, SessionError> {
        let renderer =
            |precision| SoftwareRenderer::new(Options { threads: 1, precision, kernels: KernelClass::Portable, ..Options::default() });
        Ok(Self { side, single: renderer(Precision::F32)?, double: renderer(Precision::F64)? })
    }

    /// The plan of the sample body with a key.
    ///
    /// # Errors
    /// See [`sample_body_plan_of`].
    pub fn plan(&self, module: &ShaderModule, key: &ShaderKey) -> Result<Plan, SessionError> {
        sample_body_plan_of(module, key, self.side, SAMPLE_HALF_SIDE_WITH_LIMB)
    }

    /// Draws the sample body with a module.
    ///
    /// # Errors
    /// The module needs something that the sample body lacks, or cannot be run.
    pub(crate) fn draw(&self, module: &Arc<ShaderModule>, key: &ShaderKey) -> Result<SampleImage, SessionError> {
        let plan = self.plan(module, key)?;
        let light = |renderer: &SoftwareRenderer| -> Result<Vec<[f32; 4]>, SessionError> {
            let drawn = renderer.render(&plan, &SingleModule(module), FrameImages::DisplayAndHdr);
            // The next module may have the same name, and thousands of modules may follow.
            renderer.forget_modules();
            Ok(drawn?.0.hdr)
        };
        Ok(SampleImage { side: self.side, single: light(&self.single)?, double: light(&self.double)? })
    }
}
