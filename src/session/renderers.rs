//! Which renderers a user may ask for, and what becomes of a plan that one draws.

use crate::render::frame::Frame;
#[cfg(feature = "gpu")]
use crate::render::gpu::GpuError;
use crate::render::plan::GpuImage;
use crate::render::software::{RenderError, Timings};

/// What the user asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RendererPreference {
    /// A hardware GPU where there is one, else software.
    Auto,
    /// Any adapter, a driver on the processor too; none is an error.
    Gpu,
    /// The software renderer alone.
    #[default]
    Software,
}

impl RendererPreference {
    /// As the option has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Software => "software",
        }
    }
}

/// Why no renderer draws a plan.
#[derive(Debug, thiserror::Error)]
pub enum RendererError {
    /// The software renderer cannot.
    #[error(transparent)]
    Software(#[from] RenderError),
    /// The user demands a GPU, and none can be used.
    #[cfg(feature = "gpu")]
    #[error("{0}; leave --renderer out, or say --renderer software")]
    Gpu(GpuError),
    /// The user demands a GPU of a program without that renderer.
    #[cfg(not(feature = "gpu"))]
    #[error("this build has no GPU renderer: leave --renderer out, or say --renderer software")]
    NotBuilt,
}

/// Who drew a frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnBy {
    /// `gpu` or `software`.
    pub renderer: &'static str,
    /// The device and its driver, where a GPU drew.
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
