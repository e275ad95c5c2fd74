//! The renderers that a user may request, and the result of drawing a plan.
//!
//! In: nothing; the module only defines types. Out: the user's choice, what `devices` returns for a plan, and whether its GPU is ready.

use crate::render::frame::Frame;
#[cfg(feature = "gpu")]
use crate::render::gpu::GpuError;
use crate::render::plan::{FrameImages, GpuImage};
use crate::render::software::{RenderError, Timings};

/// The user's choice of renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RendererPreference {
    /// A GPU, unless its driver is known to draw on the CPU; else the software renderer.
    Auto,
    /// Any adapter, including software drivers. If none is usable, a command fails; a window draws in software.
    Gpu,
    /// Only the software renderer.
    #[default]
    Software,
}

impl RendererPreference {
    /// The value of `--renderer`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Software => "software",
        }
    }
}

/// Why no renderer can draw a plan.
#[derive(Debug, thiserror::Error)]
pub enum RendererError {
    /// The software renderer failed.
    #[error(transparent)]
    Software(#[from] RenderError),
    /// The user requires a GPU, and none can be used.
    #[cfg(feature = "gpu")]
    #[error("{0}; leave --renderer out, or say --renderer software")]
    Gpu(GpuError),
    /// The user requires a GPU, and this build has no GPU renderer.
    #[cfg(not(feature = "gpu"))]
    #[error("this build has no GPU renderer: leave --renderer out, or say --renderer software")]
    NotBuilt,
}

/// Which renderer drew a frame, and how long its passes took.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnBy {
    /// `gpu` or `software`.
    pub renderer: &'static str,
    /// The device and its driver, if a GPU drew.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapter: Option<String>,
    /// Milliseconds on the device by pass, if the adapter has timestamps.
    #[serde(rename = "passes_ms", skip_serializing_if = "Vec::is_empty")]
    pub gpu_passes_ms: Vec<(String, f64)>,
    /// Timings of the software renderer, if it drew the frame.
    #[serde(skip)]
    pub software_timings: Option<Timings>,
}

/// The result of drawing a plan.
pub struct RenderOutput {
    pub frame: Frame,
    /// The image, if it stays on the GPU; `frame` has no pixels then.
    pub gpu_image: Option<GpuImage>,
    pub drawn_by: DrawnBy,
}

/// The form in which the caller needs a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestedOutput {
    /// Pixels in CPU memory.
    Frame(FrameImages),
    /// The image may stay on the GPU that draws it.
    OnGpu,
}

/// Whether the GPU can draw, now or soon, the image that the window last drew in software.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// No thread prepares the GPU, and none has finished since the last image.
    Settled,
    /// A thread opens the device, or compiles the pipelines that the last image needs.
    Preparing,
    /// The thread has finished: the window should draw its image again.
    JustReady,
}
