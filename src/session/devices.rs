//! Which renderer draws, and the way back to software when the GPU cannot.
//!
//! In: what the user asked for, and plans. Out: frames. The software renderer is always there. A GPU is opened with the first frame; when it
//! is missing or fails, that is said in one line, and the same plan is drawn in software, this frame and every later one.

#[cfg(feature = "gpu")]
use super::gpu_device as gpu;
use super::renderers::{DrawnBy, Readiness, RenderOutput, RendererError, RendererPreference, RequestedOutput};
use crate::render::plan::Plan;
#[cfg(feature = "gpu")]
use crate::render::software::RenderError;
use crate::render::software::{Precision, SoftwareRenderer};
#[cfg(feature = "gpu")]
use crate::shader::ModuleId;
use crate::shader::ShaderLibrary;
#[cfg(feature = "gpu")]
use parking_lot::Mutex;
#[cfg(feature = "gpu")]
use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

pub struct Devices {
    pub software: SoftwareRenderer,
    /// Another one like it, with threads of its own; `None` inside where no threads were to be had.
    background_renderer: OnceLock<Option<SoftwareRenderer>>,
    say: Arc<dyn Fn(&str) + Send + Sync>,
    #[cfg(feature = "gpu")]
    gpu: gpu::Gpu,
    /// Modules of a user's fragments that software has drawn to the end.
    #[cfg(feature = "gpu")]
    tried: Mutex<HashSet<ModuleId>>,
    #[cfg(not(feature = "gpu"))]
    preference: RendererPreference,
}

impl Devices {
    /// `double_precision`: frames are computed in f64, which the software renderer alone does.
    pub fn new(
        software: SoftwareRenderer,
        preference: RendererPreference,
        double_precision: bool,
        say: Arc<dyn Fn(&str) + Send + Sync>,
    ) -> Self {
        let preference = if double_precision && preference != RendererPreference::Software {
            if preference == RendererPreference::Gpu {
                say("the GPU does not compute in f64, which --quality reference asks for; drawing in software");
            }
            RendererPreference::Software
        } else {
            preference
        };
        #[cfg(feature = "gpu")]
        return Self { software, background_renderer: OnceLock::new(), say, gpu: gpu::Gpu::new(preference), tried: Mutex::default() };
        #[cfg(not(feature = "gpu"))]
        Self { software, background_renderer: OnceLock::new(), say, preference }
    }

    /// The software renderer for what is drawn while a window's picture is: in one pool the picture would wait for the other to end.
    pub fn background_renderer(&self) -> &SoftwareRenderer {
        let made = self.background_renderer.get_or_init(|| SoftwareRenderer::new(*self.software.options()).ok());
        made.as_ref().unwrap_or(&self.software)
    }

    fn in_software(
        by: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        let (frame, timings) = by.render(plan, library, requested == RequestedOutput::Linear)?;
        let by = DrawnBy { renderer: "software", adapter: None, passes_ms: Vec::new(), software: Some(timings) };
        Ok(RenderOutput { frame, on_gpu: None, by })
    }

    /// Draws a plan with new modules of a user's fragments in software before a device gets it: software stops a loop without end, a device hangs on it.
    #[cfg(feature = "gpu")]
    fn try_in_software(&self, by: &SoftwareRenderer, plan: &Plan, library: &ShaderLibrary) -> Result<(), RendererError> {
        if library.fragments().are_built_in() || self.preference() == RendererPreference::Software {
            return Ok(());
        }
        let all = plan.passes.iter().flat_map(|pass| &pass.draws).map(|draw| &draw.module);
        let new: Vec<ModuleId> = all.filter(|module| !self.tried.lock().contains(*module)).cloned().collect();
        if new.is_empty() {
            return Ok(());
        }
        // Whatever else software cannot draw is for the device to say.
        if let Err(stopped @ RenderError::LoopLimit { .. }) = by.render(plan, library, false) {
            return Err(stopped.into());
        }
        self.tried.lock().extend(new);
        Ok(())
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw(
        &self,
        by: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        if self.preference == RendererPreference::Gpu {
            return Err(RendererError::NotBuilt);
        }
        let _ = &self.say;
        Self::in_software(by, plan, library, requested)
    }

    /// Draws the plan with the GPU where there is one that does, else with the given software renderer.
    ///
    /// # Errors
    /// Why neither draws; that no adapter is there when one was demanded.
    #[cfg(feature = "gpu")]
    pub fn draw(
        &self,
        by: &SoftwareRenderer,
        plan: &Plan,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        self.try_in_software(by, plan, library)?;
        match self.gpu.draw(plan, library, requested, &*self.say)? {
            Some(drawn) => Ok(drawn),
            None => Self::in_software(by, plan, library, requested),
        }
    }

    /// The same for a window: what the GPU has no pipeline for yet is drawn in software, while a thread makes it, and what `window`, the plan of
    /// a window's own frame, needs.
    #[cfg(feature = "gpu")]
    pub fn draw_or_fall_back(
        &self,
        plan: &Plan,
        window: impl FnOnce() -> Option<Plan>,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        self.try_in_software(&self.software, plan, library)?;
        match self.gpu.draw_if_ready(plan, window, library, requested, &self.say) {
            Some(drawn) => Ok(drawn),
            None => Self::in_software(&self.software, plan, library, requested),
        }
    }

    #[cfg(not(feature = "gpu"))]
    pub fn draw_or_fall_back(
        &self,
        plan: &Plan,
        _: impl FnOnce() -> Option<Plan>,
        library: &ShaderLibrary,
        requested: RequestedOutput,
    ) -> Result<RenderOutput, RendererError> {
        self.draw(&self.software, plan, library, requested)
    }

    /// What can be wished for here: software alone where frames are in f64, or the build has no GPU renderer.
    pub fn choices(&self) -> &'static [RendererPreference] {
        if self.software.options().precision == Precision::F64 || !cfg!(feature = "gpu") {
            return &[RendererPreference::Software];
        }
        &[RendererPreference::Auto, RendererPreference::Gpu, RendererPreference::Software]
    }

    /// What is wished for now.
    pub fn preference(&self) -> RendererPreference {
        #[cfg(feature = "gpu")]
        return self.gpu.preference();
        #[cfg(not(feature = "gpu"))]
        self.preference
    }

    /// Never waits.
    pub fn readiness(&self) -> Readiness {
        #[cfg(feature = "gpu")]
        return self.gpu.readiness();
        #[cfg(not(feature = "gpu"))]
        Readiness::Settled
    }

    /// Wishes for another renderer from the next frame on; what is not among the [`Self::choices`] changes nothing.
    pub fn choose(&self, preference: RendererPreference) {
        let _ = preference;
        #[cfg(feature = "gpu")]
        if self.choices().contains(&preference) {
            self.gpu.choose(preference);
        }
    }

    /// Begins to open the GPU that was wished for, so that the first frame waits less.
    pub fn begin(&self) {
        #[cfg(feature = "gpu")]
        self.gpu.begin();
    }

    /// Forgets what is kept of modules: those of the same names are no longer the same.
    pub fn forget_modules(&self) {
        self.software.forget_modules();
        if let Some(Some(background_renderer)) = self.background_renderer.get() {
            background_renderer.forget_modules();
        }
        #[cfg(feature = "gpu")]
        self.tried.lock().clear();
        #[cfg(feature = "gpu")]
        self.gpu.forget_modules();
    }

    /// The device that draws, if one does. Never waits: while it draws, or is made ready for more, the answer is [`gpu::DeviceState::Unchanged`].
    #[cfg(feature = "gpu")]
    pub fn standing(&self) -> gpu::DeviceState {
        self.gpu.standing(&*self.say)
    }

    /// Gives the device back, as a driver that resets does: for tests of the way back.
    #[cfg(feature = "gpu")]
    pub fn destroy_gpu(&self) {
        self.gpu.destroy();
    }
}
