//! The GPU renderer: executes the plan's modules through wgpu (Vulkan, Metal, DX12 or GL).
//!
//! In: a [`Plan`](super::plan::Plan) and the modules that it names, as naga IR. Out: the same [`Frame`](super::frame::Frame) that the software
//! renderer makes, up to rounding and texture filtering, or a picture that stays on the device, or a window's next picture ([`GpuSurface`]). It decides nothing about the picture: passes, order, blending, depth and uniform bytes are the
//! plan's. Every failure is a [`GpuError`] and never a panic, so that the caller can draw the same plan in software. What lives here between frames:
//! the device, pipelines, uploaded textures within a budget, targets of the last size.

mod adapters;
mod bytes;
mod clock;
mod pictures;
mod pipelines;
mod readback;
mod renderer;
mod resolve;
mod screen;
mod targets;
mod uploads;

pub use adapters::{AdapterFacts, AdapterKind, adapters};
pub use renderer::{FrameGuard, GpuRenderer, GpuTimings};
pub use screen::{GpuSurface, WindowHandle};

/// Why the GPU does not draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("no graphics adapter was found ({0})")]
    NoAdapter(String),
    /// Only a driver that computes on the processor is there, and it was not asked for.
    #[error("{0} computes on the processor")]
    SoftwareDriver(String),
    #[error("{adapter} cannot be used: {why}")]
    Adapter { adapter: String, why: String },
    #[error("the graphics device was lost ({0})")]
    Lost(String),
    #[error("the graphics device is out of memory")]
    Memory,
    #[error("{draw}: {what}")]
    Draw { draw: String, what: String },
    #[error("{adapter} draws no {width}x{height} pixels, {most} at most a side")]
    Size { adapter: String, width: u32, height: u32, most: u32 },
    /// The driver or wgpu refused a call.
    #[error("the graphics driver refused: {0}")]
    Refused(String),
    /// The software renderer alone can draw it.
    #[error("the GPU does not draw {0}")]
    NotDrawn(&'static str),
}

impl GpuError {
    /// Whether the next frame would fail too: the device is gone or its memory full, not this one plan at fault.
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::NotDrawn(_) | Self::Size { .. } | Self::Draw { .. })
    }
}

impl From<wgpu::Error> for GpuError {
    fn from(e: wgpu::Error) -> Self {
        match e {
            wgpu::Error::OutOfMemory { .. } => Self::Memory,
            wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
                Self::Refused(one_line(&description))
            }
        }
    }
}

/// Runs calls of the device; the first error that it has of them is the answer. Errors are known to the thread alone that made the call.
fn caught<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, GpuError> {
    use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
    let scopes = [Validation, OutOfMemory, Internal].map(|f| device.push_error_scope(f));
    let done = work();
    let caught: Vec<GpuError> = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).map(GpuError::from).collect();
    caught.into_iter().next().map_or(Ok(done), Err)
}

/// wgpu explains itself over many indented lines.
fn one_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join("; ")
}
