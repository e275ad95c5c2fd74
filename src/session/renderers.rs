//! Which renderers a user may ask for, and what becomes of a plan that one draws.

use crate::render::frame::Frame;
use crate::render::plan::GpuImage;
use crate::render::software::Timings;

/// What the user asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RendererPreference {
    /// A hardware GPU where there is one, else software.
    Auto,
    /// Any adapter, a driver on the processor too; none is an error.
    Gpu,
    #[default]
    Software,
}

impl RendererPreference {
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Software => "software",
        }
    }
}

/// Who drew a frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnBy {
    pub renderer: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Milliseconds on the device by pass, where the adapter tells.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes_ms: Vec<(String, f64)>,
    /// What the software renderer did, where it drew.
    #[serde(skip)]
    pub software: Option<Timings>,
}

/// What became of a plan.
pub struct RenderOutput {
    pub frame: Frame,
    /// The picture, where it stays on the device: the frame has no pixels then.
    pub on_gpu: Option<GpuImage>,
    pub by: DrawnBy,
}

/// What a frame is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestedOutput {
    Pixels,
    /// The linear picture too.
    Linear,
    /// The picture may stay on the device that draws it.
    OnGpu,
}

/// Whether a picture that was drawn promptly in software could now come from the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// Nothing is under way.
    Settled,
    /// A thread makes what the last picture would need.
    Preparing,
    /// It has made it.
    JustReady,
}
