//! Creates software renderers with a session's options.
//!
//! In: the number of threads, and the precision. Out: a renderer with its own thread pool, or the error of starting the threads.

use crate::render::software::{self, Options, Precision, RenderError, SoftwareRenderer, VertexGrid};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::shader::Lowering;

// The software renderer knows no requests and so has its own limit, but it draws every image that may be requested.
const _: () = assert!(software::MAX_SIDE_PX == MAX_IMAGE_PX);

/// How the shader library lowers modules for the software renderer.
pub fn lowering() -> Lowering {
    software::lowering()
}

/// A software renderer. `threads`: `None` for one per core.
pub fn renderer(threads: Option<usize>, uses_f64: bool) -> Result<SoftwareRenderer, RenderError> {
    let precision = if uses_f64 { Precision::F64 } else { Precision::F32 };
    SoftwareRenderer::new(Options { threads: threads.unwrap_or(0), precision, ..Options::default() })
}

/// As [`renderer`] in f64, but vertices snap to the subpixel grid of GPUs.
pub fn renderer_for_gpu_comparison(threads: Option<usize>) -> Result<SoftwareRenderer, RenderError> {
    let threads = threads.unwrap_or(0);
    SoftwareRenderer::new(Options { threads, precision: Precision::F64, vertex_grid: VertexGrid::Gpu, ..Options::default() })
}
