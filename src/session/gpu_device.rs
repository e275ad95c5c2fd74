//! Manages a session's GPU device: opens it on a separate thread, compiles the pipelines of plans, and closes it when it fails.
//!
//! In: plans and the user's preference. Out: frames, or `None` if the software renderer must draw. Always: a window never blocks on a
//! driver.

use super::renderers::{DrawnBy, Readiness, RenderOutput, RendererError, RendererPreference, RequestedOutput};
use crate::render::frame::Frame;
use crate::render::gpu::{FrameResourcesLock, GpuError, GpuRenderer};
use crate::render::plan::{FrameImages, ModuleProvider, Plan};
use crate::shader::ModuleId;
use crate::shader::{ShaderError, ShaderModule};
use parking_lot::Mutex;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;

type Notify = dyn Fn(&str) + Send + Sync;

/// A thread that opens the device and compiles the pipelines of the current plan.
struct Preparing {
    thread: JoinHandle<Result<Arc<GpuRenderer>, GpuError>>,
    /// `Gpu::module_changes` before the thread's modules were fetched.
    module_changes: u64,
    /// The preference when the thread was started.
    preference: RendererPreference,
}

/// The state of the device, as reported to a window.
pub enum DeviceState {
    /// The device draws.
    Open(Arc<GpuRenderer>),
    /// The device is not open yet, is being prepared, or its lifecycle is locked: the last reported state still applies.
    Unchanged,
    /// The software renderer draws.
    Software,
}

/// The device, from the first attempt to open it until the software renderer replaces it.
enum DeviceLifecycle {
    /// No attempt to open a device was made yet.
    Unopened,
    /// A thread opens the device, or compiles what a plan needs.
    Preparing(Preparing),
    Open(Arc<GpuRenderer>),
    /// The software renderer draws from now on.
    Closed,
}

/// The GPU of a session: its device, and the user's preference.
pub struct Gpu {
    preference: Mutex<RendererPreference>,
    lifecycle: Mutex<DeviceLifecycle>,
    /// Number of times that modules have changed. Each change makes the compiled pipelines outdated.
    module_changes: AtomicU64,
    /// Whether a preparing thread's result was taken over, and no image of the window was requested since.
    just_ready: AtomicBool,
    /// The last reported error, so that a sequence of frames reports the same error only once.
    last_error: Mutex<Option<GpuError>>,
}

/// The modules of a plan, or of several, as they were at one time.
pub struct ModuleSnapshot(HashMap<ModuleId, Arc<ShaderModule>>);

impl ModuleSnapshot {
    /// The modules of a plan, without those that cannot be compiled.
    pub fn of(plan: &Plan, provider: &impl ModuleProvider) -> Self {
        let ids: HashSet<&ModuleId> = plan.passes.iter().flat_map(|p| &p.draws).map(|d| &d.module).collect();
        Self(ids.into_iter().filter_map(|id| Some((id.clone(), provider.module(id).ok()?))).collect())
    }

    pub fn ids(&self) -> impl Iterator<Item = &ModuleId> {
        self.0.keys()
    }
}

impl ModuleProvider for ModuleSnapshot {
    fn module(&self, id: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        self.0.get(id).cloned().ok_or_else(|| ShaderError::NoSuchModule(id.to_string()))
    }
}

/// The lifecycle after a device could not be opened, if the user does not require one. Reports the fallback to software in one line.
fn fall_back(e: &GpuError, notify: &Notify) -> DeviceLifecycle {
    match e {
        GpuError::SoftwareDriver(_) => notify(&format!("{e}: drawing in software; --renderer gpu uses the driver nevertheless")),
        e => notify(&format!("{e}: drawing in software")),
    }
    DeviceLifecycle::Closed
}

impl Drop for Gpu {
    /// Waits until no driver is loading or compiling, because at process exit a driver frees memory that such a thread uses.
    fn drop(&mut self) {
        if let DeviceLifecycle::Preparing(preparing) = std::mem::replace(&mut *self.lifecycle.lock(), DeviceLifecycle::Closed) {
            let _ = preparing.thread.join();
        }
    }
}

impl Gpu {
    pub fn new(preference: RendererPreference) -> Self {
        let lifecycle = if preference == RendererPreference::Software { DeviceLifecycle::Closed } else { DeviceLifecycle::Unopened };
        Self {
            preference: Mutex::new(preference),
            lifecycle: Mutex::new(lifecycle),
            module_changes: AtomicU64::new(0),
            just_ready: AtomicBool::new(false),
            last_error: Mutex::default(),
        }
    }

    pub fn preference(&self) -> RendererPreference {
        *self.preference.lock()
    }

    /// Sets the preference. A change closes the open device, because another preference may select another device.
    pub fn set_preference(&self, preference: RendererPreference) {
        let before = std::mem::replace(&mut *self.preference.lock(), preference);
        if preference == before {
            return;
        }
        self.last_error.lock().take();
        let mut lifecycle = self.lifecycle.lock();
        if !matches!(*lifecycle, DeviceLifecycle::Preparing(_)) {
            *lifecycle = if preference == RendererPreference::Software { DeviceLifecycle::Closed } else { DeviceLifecycle::Unopened };
        }
    }

    /// Whether the GPU is being prepared for an image that was drawn in software. Never blocks.
    pub fn readiness(&self) -> Readiness {
        let Some(lifecycle) = self.lifecycle.try_lock() else { return Readiness::Settled };
        match &*lifecycle {
            _ if self.preference() == RendererPreference::Software => Readiness::Settled,
            DeviceLifecycle::Preparing(preparing) if preparing.thread.is_finished() => Readiness::JustReady,
            DeviceLifecycle::Preparing(_) => Readiness::Preparing,
            DeviceLifecycle::Open(_) if self.just_ready.load(Ordering::SeqCst) => Readiness::JustReady,
            DeviceLifecycle::Unopened | DeviceLifecycle::Open(_) | DeviceLifecycle::Closed => Readiness::Settled,
        }
    }

    /// Drops all pipelines, including those that a thread is compiling.
    pub fn forget_modules(&self) {
        self.module_changes.fetch_add(1, Ordering::SeqCst);
        let open = match &*self.lifecycle.lock() {
            DeviceLifecycle::Open(renderer) => Some(Arc::clone(renderer)),
            _ => None,
        };
        if let Some(renderer) = open {
            renderer.forget_modules();
        }
    }

    /// The state of the device for a window. Never blocks.
    pub fn device_state(&self, notify: &Notify) -> DeviceState {
        if self.preference() == RendererPreference::Software {
            return DeviceState::Software;
        }
        let Some(mut lifecycle) = self.lifecycle.try_lock() else { return DeviceState::Unchanged };
        self.take_over_finished(&mut lifecycle, notify);
        match &*lifecycle {
            DeviceLifecycle::Open(renderer) => DeviceState::Open(Arc::clone(renderer)),
            DeviceLifecycle::Unopened | DeviceLifecycle::Preparing(_) => DeviceState::Unchanged,
            DeviceLifecycle::Closed => DeviceState::Software,
        }
    }

    /// Starts a preparing thread. `module_changes`: read before the modules that the thread compiles.
    fn prepare(&self, module_changes: u64, work: impl FnOnce() -> Result<Arc<GpuRenderer>, GpuError> + Send + 'static) -> DeviceLifecycle {
        DeviceLifecycle::Preparing(Preparing { thread: std::thread::spawn(work), module_changes, preference: self.preference() })
    }

    /// Waits for a preparing thread, and returns the new lifecycle. Drops the thread's pipelines if modules changed meanwhile, and its device if the preference
    /// changed.
    fn wait_prepared(&self, preparing: Preparing) -> Result<DeviceLifecycle, GpuError> {
        let renderer = preparing.thread.join().unwrap_or_else(|_| Err(GpuError::NoAdapter("the driver's thread panicked".into())))?;
        if preparing.preference != self.preference() {
            return Ok(DeviceLifecycle::Unopened);
        }
        if preparing.module_changes != self.module_changes.load(Ordering::SeqCst) {
            renderer.forget_modules();
        }
        Ok(DeviceLifecycle::Open(renderer))
    }

    /// Takes over the result of a preparing thread that has finished.
    fn take_over_finished(&self, lifecycle: &mut DeviceLifecycle, notify: &Notify) {
        *lifecycle = match std::mem::replace(lifecycle, DeviceLifecycle::Unopened) {
            DeviceLifecycle::Preparing(preparing) if preparing.thread.is_finished() => {
                self.just_ready.store(true, Ordering::SeqCst);
                self.wait_prepared(preparing).unwrap_or_else(|e| fall_back(&e, notify))
            }
            other => other,
        };
    }

    /// Starts to open the device on a thread, in parallel with the other work before the first frame.
    pub fn start_opening(&self) {
        let mut lifecycle = self.lifecycle.lock();
        if matches!(*lifecycle, DeviceLifecycle::Unopened) {
            let accept_software = self.preference() == RendererPreference::Gpu;
            *lifecycle = self.prepare(self.module_changes.load(Ordering::SeqCst), move || GpuRenderer::open(accept_software).map(Arc::new));
        }
    }

    /// Destroys the open device, as a driver reset would.
    pub fn destroy(&self) {
        if let DeviceLifecycle::Open(renderer) = &*self.lifecycle.lock() {
            renderer.destroy();
        }
    }

    /// The open device; opens it if necessary, and waits for it. `None`: the software renderer must draw.
    fn open_or_wait(&self, notify: &Notify) -> Result<Option<Arc<GpuRenderer>>, RendererError> {
        let mut lifecycle = self.lifecycle.lock();
        let mut next = Ok(std::mem::replace(&mut *lifecycle, DeviceLifecycle::Unopened));
        if let Ok(DeviceLifecycle::Preparing(preparing)) = next {
            next = self.wait_prepared(preparing);
        }
        if let Ok(DeviceLifecycle::Unopened) = next {
            let accept_software = self.preference() == RendererPreference::Gpu;
            next = GpuRenderer::open(accept_software).map(|renderer| DeviceLifecycle::Open(Arc::new(renderer)));
        }
        *lifecycle = match next {
            Ok(next) => next,
            Err(e) if self.preference() == RendererPreference::Gpu => {
                return Err(RendererError::Gpu(e));
            }
            Err(e) => fall_back(&e, notify),
        };
        Ok(if let DeviceLifecycle::Open(renderer) = &*lifecycle { Some(Arc::clone(renderer)) } else { None })
    }

    /// Draws a plan, and waits for the device if necessary. `None`: the software renderer must draw.
    pub fn draw(
        &self,
        plan: &Plan,
        modules: &impl ModuleProvider,
        output: RequestedOutput,
        notify: &Notify,
    ) -> Result<Option<RenderOutput>, RendererError> {
        if self.preference() == RendererPreference::Software {
            return Ok(None);
        }
        // The lifecycle is not locked while drawing, so that `device_state` and `draw_if_ready` can read it meanwhile.
        Ok(self.open_or_wait(notify)?.and_then(|renderer| self.draw_on(&renderer, renderer.lock(), plan, modules, output, notify)))
    }

    /// Draws a plan with an open device. `None`: the GPU failed, and the software renderer must draw.
    fn draw_on(
        &self,
        renderer: &Arc<GpuRenderer>,
        frame_guard: FrameResourcesLock<'_>,
        plan: &Plan,
        modules: &impl ModuleProvider,
        output: RequestedOutput,
        notify: &Notify,
    ) -> Option<RenderOutput> {
        let drawn = match output {
            RequestedOutput::Frame(images) => {
                renderer.render_locked(frame_guard, plan, modules, images).map(|(frame, timings)| (frame, None, timings))
            }
            RequestedOutput::OnGpu => renderer.render_to_gpu_locked(frame_guard, plan, modules).map(|(image, timings)| {
                let frame = Frame { width: image.width, height: image.height, hdr: Vec::new(), display: Vec::new() };
                (frame, Some(image), timings)
            }),
        };
        match drawn {
            Ok((frame, gpu_image, timings)) => {
                let adapter = Some(renderer.facts().to_string());
                let drawn_by = DrawnBy { renderer: "gpu", adapter, gpu_passes_ms: timings.passes_ms, software_timings: None };
                Some(RenderOutput { frame, gpu_image, drawn_by })
            }
            Err(e) => {
                let last_error = self.last_error.lock().replace(e.clone());
                if last_error.as_ref() != Some(&e) {
                    notify(&format!("{e}: drawing in software"));
                }
                if e.is_final() {
                    let mut lifecycle = self.lifecycle.lock();
                    if matches!(&*lifecycle, DeviceLifecycle::Open(open) if Arc::ptr_eq(open, renderer)) {
                        *lifecycle = DeviceLifecycle::Closed;
                    }
                }
                None
            }
        }
    }

    /// Draws a plan if the device and its pipelines are ready; otherwise returns `None` and starts to prepare them, unless the device is
    /// closed. `interface_plan` returns the plan of the window's interface. Never blocks on a driver.
    pub fn draw_if_ready(
        &self,
        plan: &Plan,
        interface_plan: impl FnOnce() -> Option<Plan>,
        modules: &impl ModuleProvider,
        output: RequestedOutput,
        notify: &Arc<Notify>,
    ) -> Option<RenderOutput> {
        if self.preference() == RendererPreference::Software {
            return None;
        }
        // If the lock is taken, another thread opens the device or waits for it.
        let mut lifecycle = self.lifecycle.try_lock()?;
        self.take_over_finished(&mut lifecycle, &**notify);
        self.just_ready.store(false, Ordering::SeqCst);
        let renderer = match &*lifecycle {
            DeviceLifecycle::Open(renderer) => Some(Arc::clone(renderer)),
            DeviceLifecycle::Unopened => None,
            DeviceLifecycle::Preparing(_) | DeviceLifecycle::Closed => return None,
        };
        let interface_plan = interface_plan();
        if let Some(renderer) = &renderer {
            let is_ready_for_window = interface_plan.as_ref().and_then(|plan| renderer.is_ready_for_windows(plan)).unwrap_or(true);
            if let Some(frame_guard) = renderer.try_lock_for(plan).filter(|_| is_ready_for_window) {
                drop(lifecycle);
                return self.draw_on(renderer, frame_guard, plan, modules, output, &**notify);
            }
        }
        let passes = plan.passes.iter().chain(interface_plan.iter().flat_map(|plan| &plan.passes));
        let ids: Vec<&ModuleId> = passes.flat_map(|p| &p.draws).map(|d| &d.module).collect();
        // Read before the modules: if they change in between, pipelines are dropped unnecessarily, which is better than keeping outdated ones.
        let module_changes = self.module_changes.load(Ordering::SeqCst);
        let modules = ids.into_iter().map(|id| Some((id.clone(), modules.module(id).ok()?))).collect::<Option<_>>().map(ModuleSnapshot)?;
        let (plan, accept_software) = (plan.clone(), self.preference() == RendererPreference::Gpu);
        *lifecycle = self.prepare(module_changes, move || {
            let renderer = renderer.map_or_else(|| GpuRenderer::open(accept_software).map(Arc::new), Ok)?;
            // The plan is drawn once and the result dropped, because some drivers compile pipelines only at the first draw.
            let errors = [
                Some(renderer.render(&plan, &modules, FrameImages::Display).err()),
                interface_plan.map(|plan| renderer.warm_up_window_pipelines(&plan, &modules).err()),
            ];
            match errors.into_iter().flatten().flatten().find(GpuError::is_final) {
                Some(e) => Err(e),
                None => Ok(renderer),
            }
        });
        None
    }
}
