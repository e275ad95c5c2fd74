//! Chooses the renderer, and falls back to software when the GPU cannot draw.
//!
//! In: the user's preference, and plans. Out: frames. The software renderer is always available. A GPU is opened for the first frame, or earlier by
//! [`Devices::start_opening_gpu`]. If it is missing or fails, this is reported in one line and the plan is drawn in software; so are all later plans if the
//! device has become unusable. Outside a window, a missing GPU that the user requires is an error.

#[cfg(feature = "gpu")]
use super::gpu_device as gpu;
use super::renderers::{DrawnBy, Readiness, RenderOutput, RendererError, RendererPreference, RequestedOutput};
#[cfg(feature = "gpu")]
use crate::render::plan::ModuleProvider;
use crate::render::plan::{FrameImages, Plan};
#[cfg(feature = "gpu")]
use crate::render::software::RenderError;
use crate::render::software::{Precision, SoftwareRenderer};
use crate::shader::ShaderLibrary;
#[cfg(feature = "gpu")]
use crate::shader::{ModuleId, ShaderError, ShaderModule};
use parking_lot::Mutex;
#[cfg(feature = "gpu")]
use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

/// The renderers of a session.
pub struct Devices {
    pub software: SoftwareRenderer,
    /// A second software renderer with its own threads, created when first needed; `None` inside if no threads could be started.
    background_renderer: OnceLock<Option<SoftwareRenderer>>,
    /// Receives the messages for the user.
    notify: Arc<dyn Fn(&str) + Send + Sync>,
    #[cfg(feature = "gpu")]
    gpu: gpu::Gpu,
    /// Modules of the user's shader sources that the software renderer has executed without finding an endless loop.
    #[cfg(feature = "gpu")]
    dry_run_modules: Mutex<HashSet<ModuleId>>,
    #[cfg(not(feature = "gpu"))]
    preference: RendererPreference,
    /// Number of times that the shader sources have changed. Locked during a change.
    shader_source_changes: Mutex<u64>,
}

/// The modules with which the GPU draws a plan.
#[cfg(feature = "gpu")]
struct PlanModules<'a> {
    library: &'a ShaderLibrary,
    /// Only if the user's shader sources are in use: the plan's modules, and the value of `shader_source_changes` before these modules were fetched.
    snapshot: Option<(gpu::ModuleSnapshot, u64)>,
}

#[cfg(feature = "gpu")]
impl ModuleProvider for PlanModules<'_> {
    /// A module of another plan, such as that of the window's interface, comes from the library.
    fn module(&self, id: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        let from_snapshot = self.snapshot.as_ref().and_then(|(modules, _)| modules.module(id).ok());
        from_snapshot.map_or_else(|| self.library.module(id), Ok)
    }
}

impl Devices {
    /// `uses_f64`: frames are computed in f64, which only the software renderer can do.
    pub fn new(
        software: SoftwareRenderer,
        preference: RendererPreference,
        uses_f64: bool,
        notify: Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Self {
        let preference = if uses_f64 && preference != RendererPreference::Software {
            if preference == RendererPreference::Gpu {
                notify("the GPU does not compute in f64, which --quality reference asks for; drawing in software");
            }
            RendererPreference::Software
        } else {
            preference
        };
        #[cfg(feature = "gpu")]
        return Self {
            software,
            background_renderer: OnceLock::new(),
            notify,
            gpu: gpu::Gpu::new(preference),
            dry_run_modules: Mutex::default(),
            shader_source_changes: Mutex::default(),
        };
        #[cfg(not(feature = "gpu"))]
        Self { software, background_renderer: OnceLock::new(), notify, preference, shader_source_changes: Mutex::default() }
    }

    /// The software renderer for background work. It has its own thread pool, so that background work and the window's image do not wait for each other.
    pub fn background_renderer(&self) -> &SoftwareRenderer {
        let with_own_threads = self.background_renderer.get_or_init(|| SoftwareRenderer::new(*self.software.options()).ok());
        with_own_threads.as_ref().unwrap_or(&self.software)
    }

    fn draw_in_software(
        software: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        let images = if let RequestedOutput::Frame(images) = requested { images } else { FrameImages::Display };
        let (frame, timings) = software.render(plan, library, images)?;
        let drawn_by = DrawnBy { renderer: "software", adapter: None, gpu_passes_ms: Vec::new(), software_timings: Some(timings) };
        Ok(RenderOutput { frame, gpu_image: None, drawn_by })
    }

    /// The modules with which the GPU draws a plan. With the user's shader sources, new modules are executed in software first, because the software
    /// renderer detects an endless loop, which would hang a GPU. The GPU then gets exactly these modules, even if the shader sources change meanwhile. If the
    /// software renderer fails for another reason, the GPU gets the modules although not all were executed. [`Self::forget_if_outdated`] must follow the
    /// drawing.
    #[cfg(feature = "gpu")]
    fn modules_for_gpu<'a>(
        &self,
        software: &SoftwareRenderer,
        plan: &Plan,
        library: &'a ShaderLibrary,
    ) -> Result<PlanModules<'a>, RendererError> {
        if library.fragments().are_built_in() || self.preference() == RendererPreference::Software {
            return Ok(PlanModules { library, snapshot: None });
        }
        let (modules, ids_to_dry_run, changes) = loop {
            let changes = self.shader_source_changes();
            let modules = gpu::ModuleSnapshot::of(plan, library);
            let ids_to_dry_run: Vec<ModuleId> = modules.ids().filter(|id| !self.dry_run_modules.lock().contains(*id)).cloned().collect();
            // If nothing has changed until here, `ids_to_dry_run` refers to these modules, not to later ones with the same ids.
            if self.shader_source_changes() == changes {
                break (modules, ids_to_dry_run, changes);
            }
        };
        let modules = PlanModules { library, snapshot: Some((modules, changes)) };
        if ids_to_dry_run.is_empty() {
            return Ok(modules);
        }
        match software.render(plan, &modules, FrameImages::Display) {
            Ok(_) => {
                // Locked in the same order as in `change_shader_sources`, so that the two cannot deadlock.
                let changes_now = self.shader_source_changes.lock();
                if *changes_now == changes {
                    self.dry_run_modules.lock().extend(ids_to_dry_run);
                }
            }
            Err(endless @ RenderError::LoopLimit { .. }) => {
                self.forget_if_outdated(&modules);
                return Err(endless.into());
            }
            // Drawing on the GPU reports any other error. Not all modules were executed, so they are executed again before the next image.
            Err(_) => {}
        }
        Ok(modules)
    }

    /// Drops everything compiled from `modules` if the shader sources have changed since.
    #[cfg(feature = "gpu")]
    fn forget_if_outdated(&self, modules: &PlanModules<'_>) {
        if modules.snapshot.as_ref().is_some_and(|(_, changes)| *changes != self.shader_source_changes()) {
            self.forget_modules();
        }
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw_waiting(
        &self,
        software: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        if self.preference == RendererPreference::Gpu {
            return Err(RendererError::NotBuilt);
        }
        // Only a GPU's errors are reported.
        let _ = &self.notify;
        Self::draw_in_software(software, plan, library, requested)
    }

    /// Draws the plan with the GPU if one is available, else with the given software renderer. Waits until the GPU's pipelines are compiled.
    ///
    /// # Errors
    /// The software renderer failed, an endless loop in the user's shader sources, or the user requires a GPU and none can be opened.
    #[cfg(feature = "gpu")]
    pub fn draw_waiting(
        &self,
        software: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        let modules = self.modules_for_gpu(software, plan, library)?;
        let drawn = self.gpu.draw(plan, &modules, requested, &*self.notify);
        self.forget_if_outdated(&modules);
        match drawn? {
            Some(drawn) => Ok(drawn),
            None => Self::draw_in_software(software, plan, library, requested),
        }
    }

    /// As [`Self::draw_waiting`], for a window: a plan whose pipelines are not compiled yet is drawn in software, while a thread compiles these
    /// pipelines and those of `interface_plan`, the plan of the window's interface.
    #[cfg(feature = "gpu")]
    pub fn draw_without_waiting(
        &self,
        plan: &Plan,
        interface_plan: impl FnOnce() -> Option<Plan>,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        let modules = self.modules_for_gpu(&self.software, plan, library)?;
        let drawn = self.gpu.draw_if_ready(plan, interface_plan, &modules, requested, &self.notify);
        self.forget_if_outdated(&modules);
        match drawn {
            Some(drawn) => Ok(drawn),
            None => Self::draw_in_software(&self.software, plan, library, requested),
        }
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw_without_waiting(
        &self,
        plan: &Plan,
        _: impl FnOnce() -> Option<Plan>,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        self.draw_waiting(&self.software, plan, library, requested)
    }

    /// The renderers that the user can choose; only software if frames are computed in f64 or the build has no GPU renderer.
    pub fn choices(&self) -> &'static [RendererPreference] {
        if self.software.options().precision == Precision::F64 || !cfg!(feature = "gpu") {
            return &[RendererPreference::Software];
        }
        &[RendererPreference::Auto, RendererPreference::Gpu, RendererPreference::Software]
    }

    /// The current preference.
    pub fn preference(&self) -> RendererPreference {
        #[cfg(feature = "gpu")]
        return self.gpu.preference();
        #[cfg(not(feature = "gpu"))]
        self.preference
    }

    /// Whether the GPU is being prepared for an image that was drawn in software. Never blocks.
    pub fn readiness(&self) -> Readiness {
        #[cfg(feature = "gpu")]
        return self.gpu.readiness();
        #[cfg(not(feature = "gpu"))]
        Readiness::Settled
    }

    /// Sets the renderer from the next frame on. A preference that is not among the [`Self::choices`] is ignored.
    pub fn set_preference(&self, preference: RendererPreference) {
        // Without a GPU renderer there is no choice.
        let _ = preference;
        #[cfg(feature = "gpu")]
        if self.choices().contains(&preference) {
            self.gpu.set_preference(preference);
        }
    }

    /// Starts to open the preferred GPU on a thread, so that the first frame waits less.
    pub fn start_opening_gpu(&self) {
        #[cfg(feature = "gpu")]
        self.gpu.start_opening();
    }

    /// Changes the shader sources by `change`, and drops everything compiled from the old ones.
    pub fn change_shader_sources(&self, change: impl FnOnce()) {
        let mut changes = self.shader_source_changes.lock();
        change();
        self.forget_modules();
        *changes += 1;
    }

    /// Number of times that the shader sources have changed. Waits for the end of a change.
    pub fn shader_source_changes(&self) -> u64 {
        *self.shader_source_changes.lock()
    }

    /// Drops everything compiled from modules. Called when modules have changed under the same ids.
    pub fn forget_modules(&self) {
        self.software.forget_modules();
        if let Some(Some(background_renderer)) = self.background_renderer.get() {
            background_renderer.forget_modules();
        }
        #[cfg(feature = "gpu")]
        self.dry_run_modules.lock().clear();
        #[cfg(feature = "gpu")]
        self.gpu.forget_modules();
    }

    /// The GPU that draws, if any. Never blocks: while the device is opened or pipelines are compiled, the result is [`gpu::DeviceState::Unchanged`].
    #[cfg(feature = "gpu")]
    pub fn device_state(&self) -> gpu::DeviceState {
        self.gpu.device_state(&*self.notify)
    }

    /// Destroys the device, as a driver reset would, to test the fallback.
    #[cfg(feature = "gpu")]
    pub fn destroy_gpu(&self) {
        self.gpu.destroy();
    }
}
