//! The software renderer as a session uses it.

use crate::render::software::{self, Options, Precision, RenderError, SoftwareRenderer};
use crate::shader::Lowering;

/// How the library turns modules into what the renderer runs.
pub fn lowering() -> Lowering {
    software::lowering()
}

/// A renderer for the session's frames; `threads`: `None` for one per core.
pub fn renderer(threads: Option<usize>, double_precision: bool) -> Result<SoftwareRenderer, RenderError> {
    let precision = if double_precision { Precision::F64 } else { Precision::F32 };
    SoftwareRenderer::new(Options { threads: threads.unwrap_or(0), precision, ..Options::default() })
}
