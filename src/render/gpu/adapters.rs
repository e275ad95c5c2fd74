//! Lists the adapters of this machine, and opens the best usable one.
//!
//! Hardware is preferred to drivers that draw on the CPU, and Vulkan, Metal and DX12 to GL. In: the environment variables that wgpu documents
//! (`WGPU_BACKEND` and others), and on Linux whether device nodes of graphics hardware exist. Out: descriptions of adapters, or an opened device.

use super::GpuError;
use std::path::Path;
use wgpu::{
    Adapter, Backend, Backends, Device, DeviceDescriptor, DeviceType, Features, Instance, InstanceDescriptor, InstanceFlags, Limits, Queue,
    TextureFormat, TextureFormatFeatureFlags,
};

/// What executes an adapter's commands, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdapterKind {
    Hardware,
    /// The driver does not report its kind.
    Unknown,
    /// A driver that draws on the CPU.
    Software,
}

/// What an adapter reports about itself. The user sees it as text and in JSON reports.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct AdapterFacts {
    pub name: String,
    /// As wgpu names it: vulkan, metal, dx12 or gl.
    pub backend: String,
    pub kind: AdapterKind,
    /// Name and version of the driver; empty if it reports neither.
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
            // GL does not report the type: wgpu guesses it from the renderer's name, but does not know every software driver.
            DeviceType::Other if is_name_of_software_driver(&info.name) => AdapterKind::Software,
            DeviceType::Other => AdapterKind::Unknown,
        };
        let driver = [info.driver.trim(), info.driver_info.trim()].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
        Self { name: info.name, backend: info.backend.to_string(), kind, driver }
    }
}

fn is_name_of_software_driver(name: &str) -> bool {
    let name = name.to_lowercase();
    ["llvmpipe", "softpipe", "swiftshader"].iter().any(|driver| name.contains(driver))
}

/// An adapter that may be opened, with the instance that creates its surfaces.
struct AdapterCandidate {
    facts: AdapterFacts,
    adapter: Adapter,
    instance: Instance,
}

/// The adapters of some backends, best first.
fn candidates(backends: Backends) -> Vec<AdapterCandidate> {
    let mut descriptor = InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends &= backends;
    // wgpu's validation of indirect draws, which this renderer does not use, would compile one more pipeline at each start.
    descriptor.flags.remove(InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = Instance::new(descriptor);
    let mut all = pollster::block_on(instance.enumerate_adapters(backends));
    all.sort_by_key(rank);
    all.into_iter().map(|adapter| AdapterCandidate { facts: AdapterFacts::of(&adapter), adapter, instance: instance.clone() }).collect()
}

/// Sort key that puts the best adapter first: by kind, then by type of device; of equal ones, GL is last.
fn rank(adapter: &Adapter) -> (AdapterKind, u8, bool) {
    let info = adapter.get_info();
    let device_rank = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (AdapterFacts::of(adapter).kind, device_rank, info.backend == Backend::Gl)
}

/// Whether there may be hardware that only GL supports. On Linux, hardware has one of these device nodes: those of DRM, of NVIDIA's driver, or of WSL.
fn gl_may_find_hardware() -> bool {
    !cfg!(target_os = "linux") || ["/dev/dri", "/dev/nvidiactl", "/dev/dxg"].iter().any(|node| Path::new(node).exists())
}

/// The adapters to try, best first. GL drivers are loaded only if no other backend finds hardware, because loading them is slow.
fn adapters_to_try() -> Vec<AdapterCandidate> {
    let mut all = candidates(Backends::all() - Backends::GL);
    let has_hardware = all.iter().any(|c| c.facts.kind == AdapterKind::Hardware);
    if all.is_empty() || (!has_hardware && gl_may_find_hardware()) {
        all.extend(candidates(Backends::GL));
        all.sort_by_key(|c| rank(&c.adapter));
    }
    all
}

/// The adapters of this machine, best first; empty if no driver is installed for any of the backends that wgpu's environment variables allow.
pub fn adapters() -> Vec<AdapterFacts> {
    candidates(Backends::all()).into_iter().map(|c| c.facts).collect()
}

/// An opened device, and which optional features it has.
pub(super) struct OpenedDevice {
    pub facts: AdapterFacts,
    pub instance: Instance,
    pub adapter: Adapter,
    pub device: Device,
    pub queue: Queue,
    /// Whether the device can blend into targets of 32-bit floats with 4 samples per pixel.
    pub blends_f32: bool,
    pub has_timestamps: bool,
}

/// Opens the best usable adapter. `accept_software`: whether drivers that draw on the CPU are accepted.
pub(super) fn open(accept_software: bool) -> Result<OpenedDevice, GpuError> {
    open_first(adapters_to_try(), accept_software, "Vulkan, Metal, DX12 or GL")
}

/// Opens a GL adapter; software drivers are accepted. [`open`] prefers any other backend.
pub(super) fn open_gl() -> Result<OpenedDevice, GpuError> {
    let accept_software = true;
    open_first(candidates(Backends::GL), accept_software, "GL")
}

/// Opens the first usable candidate; the error is that of the best one. `backends`: the backends that were searched, for the error if there is no candidate.
fn open_first(candidates: Vec<AdapterCandidate>, accept_software: bool, backends: &str) -> Result<OpenedDevice, GpuError> {
    let mut first_failure = None;
    for candidate in candidates {
        let is_accepted = accept_software || candidate.facts.kind != AdapterKind::Software;
        let opened = if is_accepted { open_device(candidate) } else { Err(GpuError::SoftwareDriver(candidate.facts.to_string())) };
        match opened {
            Ok(opened) => return Ok(opened),
            Err(e) => first_failure = first_failure.or(Some(e)),
        }
    }
    Err(first_failure.unwrap_or_else(|| GpuError::NoAdapter(format!("no {backends} driver was found"))))
}

fn open_device(AdapterCandidate { facts, adapter, instance }: AdapterCandidate) -> Result<OpenedDevice, GpuError> {
    let unusable = |why: String| GpuError::Adapter { adapter: facts.to_string(), why };
    let required_flags = TextureFormatFeatureFlags::MULTISAMPLE_X4 | TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE;
    let half_float_flags = adapter.get_texture_format_features(TextureFormat::Rgba16Float).flags;
    if !half_float_flags.contains(required_flags | TextureFormatFeatureFlags::BLENDABLE) {
        return Err(unusable("it cannot blend into targets of half floats with 4 samples".into()));
    }
    // WebGPU does not guarantee multisampled targets of 32-bit floats, so their support is a feature of the adapter.
    let f32_features = Features::FLOAT32_BLENDABLE | Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
    let blends_f32 = adapter.features().contains(f32_features)
        && adapter
            .get_texture_format_features(TextureFormat::Rgba32Float)
            .flags
            .contains(required_flags | TextureFormatFeatureFlags::BLENDABLE);
    let has_timestamps = adapter.features().contains(Features::TIMESTAMP_QUERY);
    let mut required_features = Features::empty();
    required_features.set(f32_features, blends_f32);
    required_features.set(Features::TIMESTAMP_QUERY, has_timestamps);
    // Apart from sizes, the limits of WebGL 2 suffice for every plan.
    let supported = adapter.limits();
    let required_limits =
        Limits { max_buffer_size: supported.max_buffer_size, ..Limits::downlevel_webgl2_defaults().using_resolution(supported) };
    let descriptor = DeviceDescriptor { label: Some("orrery"), required_features, required_limits, ..DeviceDescriptor::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| unusable(super::one_line(&e.to_string())))?;
    Ok(OpenedDevice { facts, instance, adapter, device, queue, blends_f32, has_timestamps })
}
