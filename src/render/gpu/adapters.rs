//! Which adapters this machine has, and opening one.
//!
//! Hardware comes before drivers that compute on the processor, and Vulkan, Metal and DX12 before GL. Reads the environment variables that wgpu
//! documents (`WGPU_BACKEND` and others), asks on Linux whether there are nodes of graphics hardware, and takes nothing else from outside.

use super::GpuError;
use std::path::Path;
use wgpu::{
    Adapter, Backend, Backends, Device, DeviceDescriptor, DeviceType, Features, Instance, InstanceDescriptor, InstanceFlags, Limits, Queue,
};
use wgpu::{TextureFormat, TextureFormatFeatureFlags};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdapterKind {
    Hardware,
    /// The driver does not say.
    Unknown,
    /// A driver that computes on the processor.
    Software,
}

/// What an adapter says of itself.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct AdapterFacts {
    pub name: String,
    /// Vulkan, Metal, Dx12 or Gl.
    pub backend: String,
    pub kind: AdapterKind,
    pub driver: String,
}

impl std::fmt::Display for AdapterFacts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}{}{})", self.name, self.backend, if self.driver.is_empty() { "" } else { ", " }, self.driver)
    }
}

impl AdapterFacts {
    fn of(adapter: &Adapter) -> Self {
        let info = adapter.get_info();
        let kind = match info.device_type {
            DeviceType::DiscreteGpu | DeviceType::IntegratedGpu | DeviceType::VirtualGpu => AdapterKind::Hardware,
            DeviceType::Cpu => AdapterKind::Software,
            // GL does not tell; the names of Mesa's processor drivers do.
            DeviceType::Other if ["llvmpipe", "softpipe", "swiftshader"].iter().any(|n| info.name.to_lowercase().contains(n)) => {
                AdapterKind::Software
            }
            DeviceType::Other => AdapterKind::Unknown,
        };
        let driver = [info.driver.trim(), info.driver_info.trim()].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
        Self { name: info.name, backend: info.backend.to_string(), kind, driver }
    }
}

/// An adapter of an instance, which makes surfaces for it.
struct Found {
    facts: AdapterFacts,
    adapter: Adapter,
    instance: Instance,
}

/// The adapters of some backends, best first.
fn found(backends: Backends) -> Vec<Found> {
    let mut descriptor = InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends &= backends;
    // No draw takes its numbers from the device: what would check them is a pipeline more at each start.
    descriptor.flags.remove(InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = Instance::new(descriptor);
    let mut all = pollster::block_on(instance.enumerate_adapters(backends));
    all.sort_by_key(rank);
    all.into_iter().map(|adapter| Found { facts: AdapterFacts::of(&adapter), adapter, instance: instance.clone() }).collect()
}

/// Smaller is better.
fn rank(adapter: &Adapter) -> (AdapterKind, u8, bool) {
    let info = adapter.get_info();
    let speed = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (AdapterFacts::of(adapter).kind, speed, info.backend == Backend::Gl)
}

/// Whether there may be hardware that GL drives and Vulkan does not. GL drivers take long to load, and on Linux find hardware by these nodes.
fn gl_may_have_more() -> bool {
    !cfg!(target_os = "linux") || ["/dev/dri", "/dev/nvidiactl", "/dev/dxg"].iter().any(|node| Path::new(node).exists())
}

/// The adapters that one may be opened of, best first.
fn to_open() -> Vec<Found> {
    let mut all = found(Backends::all() - Backends::GL);
    let hardware = all.iter().any(|f| f.facts.kind == AdapterKind::Hardware);
    if all.is_empty() || (!hardware && gl_may_have_more()) {
        all.extend(found(Backends::GL));
        all.sort_by_key(|f| rank(&f.adapter));
    }
    all
}

/// What adapters there are, best first; empty where no driver is installed.
pub fn adapters() -> Vec<AdapterFacts> {
    found(Backends::all()).into_iter().map(|f| f.facts).collect()
}

/// An opened device and what it can do beyond the least.
pub(super) struct Opened {
    pub facts: AdapterFacts,
    pub instance: Instance,
    pub adapter: Adapter,
    pub device: Device,
    pub queue: Queue,
    /// A linear picture of 32-bit floats can be blended into, with 4 samples.
    pub wide_colour: bool,
    pub timestamps: bool,
}

/// Opens the best adapter that will do. `software`: a driver on the processor will do.
pub(super) fn open(software: bool) -> Result<Opened, GpuError> {
    first_of(to_open(), software)
}

/// The same among GL's alone, even one on the processor: where another driver is there it is never the best.
pub(super) fn open_gl() -> Result<Opened, GpuError> {
    first_of(found(Backends::GL), true)
}

fn first_of(all: Vec<Found>, software: bool) -> Result<Opened, GpuError> {
    let Some(best) = all.first().map(|f| &f.facts) else {
        return Err(GpuError::NoAdapter("no Vulkan, Metal, DX12 or GL driver answered".into()));
    };
    if !software && best.kind == AdapterKind::Software {
        return Err(GpuError::SoftwareDriver(best.to_string()));
    }
    let mut first_failure = None;
    for one in all.into_iter().filter(|f| software || f.facts.kind != AdapterKind::Software) {
        match device_of(one) {
            Ok(opened) => return Ok(opened),
            Err(e) => first_failure = first_failure.or(Some(e)),
        }
    }
    Err(first_failure.unwrap_or_else(|| GpuError::NoAdapter("none is left".into())))
}

fn device_of(Found { facts, adapter, instance }: Found) -> Result<Opened, GpuError> {
    let failed = |why: String| GpuError::Adapter { adapter: facts.to_string(), why };
    let flags = TextureFormatFeatureFlags::MULTISAMPLE_X4 | TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE;
    let half = adapter.get_texture_format_features(TextureFormat::Rgba16Float).flags;
    if !half.contains(flags | TextureFormatFeatureFlags::BLENDABLE) {
        return Err(failed("it cannot blend into 4 samples of half floats".into()));
    }
    let wide = Features::FLOAT32_BLENDABLE | Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    let wide_colour = adapter.features().contains(wide)
        && adapter.get_texture_format_features(TextureFormat::Rgba32Float).flags.contains(flags | TextureFormatFeatureFlags::BLENDABLE);
    let timestamps = adapter.features().contains(Features::TIMESTAMP_QUERY);
    let mut required_features = Features::empty();
    required_features.set(wide, wide_colour);
    required_features.set(Features::TIMESTAMP_QUERY, timestamps);
    let own = adapter.limits();
    let required_limits = Limits { max_buffer_size: own.max_buffer_size, ..Limits::downlevel_webgl2_defaults().using_resolution(own) };
    let descriptor = DeviceDescriptor { label: Some("orrery"), required_features, required_limits, ..DeviceDescriptor::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| failed(super::one_line(&e.to_string())))?;
    Ok(Opened { facts, instance, adapter, device, queue, wide_colour, timestamps })
}
