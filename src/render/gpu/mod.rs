//! The GPU renderer: executes plans through wgpu (Vulkan, Metal, DX12 or GL).
//!
//! In: a [`Plan`](super::plan::Plan) and the shader modules that it names, as naga IR. Out: the same [`Frame`](super::frame::Frame) as the software
//! renderer's, up to rounding and texture filtering, or an image that stays in GPU memory, or a window's next frame (`GpuSurface`). Always: the plan
//! determines passes, order, blending, depth and uniform bytes; every failure is a [`GpuError`] and never a panic, so that the caller can draw the
//! same plan in software. The device, pipelines, uploaded textures within a budget, and targets of the last size are kept between frames.

mod adapters;
mod bytes;
mod gpu_images;
mod pass_timer;
mod pipelines;
mod readback;
mod renderer;
mod resolve;
mod surface;
mod targets;
mod uploads;
mod x11;

pub use adapters::{AdapterFacts, AdapterKind, adapters};
pub use renderer::{FrameResourcesLock, GpuRenderer, GpuTimings};
pub(crate) use surface::{GpuSurface, WindowHandle};

/// Why the GPU did not draw a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    #[error("no graphics adapter was found ({0})")]
    NoAdapter(String),
    /// All drivers found draw on the CPU, and the caller did not accept such a driver.
    #[error("{0} is a software driver, which draws on the CPU")]
    SoftwareDriver(String),
    #[error("{adapter} cannot be used: {why}")]
    Adapter { adapter: String, why: String },
    #[error("the graphics device was lost ({0})")]
    DeviceLost(String),
    #[error("the graphics device is out of memory")]
    OutOfMemory,
    /// A draw whose module cannot be built, or whose data do not fit its module. `draw`: its label, or the name of the module.
    #[error("{draw}: {what}")]
    Draw { draw: String, what: String },
    #[error("{adapter} cannot draw {width}x{height} pixels; each side must be 1 to {max_side}")]
    TargetSize { adapter: String, width: u32, height: u32, max_side: u32 },
    /// The driver or wgpu refused a call.
    #[error("the graphics driver reported an error: {0}")]
    DriverError(String),
    /// Only the software renderer can draw this plan.
    #[error("the GPU cannot draw {0}")]
    Unsupported(&'static str),
    #[error("the plan has no pass")]
    NoPass,
}

impl GpuError {
    /// Whether the next frame would fail too, because the cause is the device (lost or out of memory, for example) and not this plan.
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::Unsupported(_) | Self::NoPass | Self::TargetSize { .. } | Self::Draw { .. })
    }
}

impl From<wgpu::Error> for GpuError {
    fn from(e: wgpu::Error) -> Self {
        match e {
            wgpu::Error::OutOfMemory { .. } => Self::OutOfMemory,
            wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
                Self::DriverError(one_line(&description))
            }
        }
    }
}

/// Runs device calls inside error scopes, and returns an error if a scope caught one. A scope catches only errors of calls on the thread that opened it.
fn with_error_scopes<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, GpuError> {
    use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
    let scopes = [Validation, OutOfMemory, Internal].map(|f| device.push_error_scope(f));
    let result = work();
    let errors: Vec<GpuError> = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop())).map(GpuError::from).collect();
    errors.into_iter().next().map_or(Ok(result), Err)
}

/// Joins the lines of a message; wgpu's messages have many indented lines.
fn one_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join("; ")
}
