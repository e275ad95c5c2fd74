//! Times and triangle counts of a frame: plain data, which `--time-report` prints and the benches read.

/// Times and triangle counts of one pass.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct PassTimings {
    pub name: String,
    /// Triangles that the draws submitted, before clipping and culling; `given` in time reports.
    #[serde(rename = "given")]
    pub submitted_triangles: usize,
    /// Submitted triangles that are back-facing, without area, or entirely clipped or outside the draw's scissor rectangle.
    #[serde(rename = "culled")]
    pub culled_triangles: usize,
    /// Submitted triangles that a clip plane cut, such as the near plane or an edge of the guard band, and that are still visible.
    #[serde(rename = "clipped")]
    pub clipped_triangles: usize,
    /// Triangles to be rasterised, after clipping (which may split one into several) and culling.
    #[serde(rename = "triangles")]
    pub rasterised_triangles: usize,
    /// Wall time of the vertex programs.
    pub vertex_ms: f64,
    /// Wall time of clipping and of triangle set-up (edge functions and planes).
    pub setup_ms: f64,
    /// Wall time of sorting triangles into tiles.
    pub binning_ms: f64,
    /// Time of coverage, fragment programs, depth and blending, summed over threads. Each of two fused passes has its own.
    pub shading_thread_ms: f64,
    /// Time to resolve the samples and to convert them to the target's format, summed over threads. For two fused passes, the second has the time of both.
    pub resolve_thread_ms: f64,
    /// Wall time from the pass's start to its end. For two fused passes, the first has the time of both.
    pub wall_ms: f64,
}

/// Times of one frame.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Timings {
    /// Wall time of decoding the modules' tapes, and of binding uniforms and textures.
    pub prepare_ms: f64,
    pub passes: Vec<PassTimings>,
    /// Wall time from the call to the finished frame.
    pub wall_ms: f64,
}
