//! The software renderer as a session uses it: how modules are lowered, and a plan drawn.

use crate::render::frame::Frame;
use crate::render::plan::Plan;
use crate::shader::Lowering;
use crate::shader::library::Library;

/// How the library turns modules into what the renderer runs.
pub fn lowering() -> Lowering {
    Lowering::none()
}

/// Draws a plan. `keep_hdr`: the frame keeps its linear radiance too.
pub fn draw(_plan: &Plan, _library: &Library, _keep_hdr: bool) -> Result<Frame, String> {
    Err("it is not part of this build".into())
}
