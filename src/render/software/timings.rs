//! Where a frame's time went: plain data for `--time-report` and the benches.

/// One pass.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct PassTimings {
    pub name: String,
    /// Triangles that the draws submitted.
    pub given: usize,
    /// Of those: back-facing, without area, or outside the target.
    pub culled: usize,
    /// Of those: clipped by the near plane or the guard band, and still visible.
    pub clipped: usize,
    /// Raster triangles after clipping and culling.
    pub triangles: usize,
    /// Wall time of the vertex programs.
    pub vertex_ms: f64,
    /// Wall time of clipping and set-up.
    pub setup_ms: f64,
    /// Wall time of sorting triangles into tiles.
    pub binning_ms: f64,
    /// Coverage, fragment programs, depth and blending: summed over threads.
    pub shading_thread_ms: f64,
    /// Resolve of the samples and conversion to the target's format: summed over threads.
    pub resolve_thread_ms: f64,
    /// From the pass's start to its end; the first of two fused passes has the time of both.
    pub wall_ms: f64,
}

/// One frame.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Timings {
    /// Reading the modules' tapes, binding uniforms and textures.
    pub prepare_ms: f64,
    pub passes: Vec<PassTimings>,
    /// From the call to the frame.
    pub wall_ms: f64,
}
