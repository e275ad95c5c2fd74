//! Turns a view request into a plan, and draws the plan.
//!
//! In: a request. Out: its scene with a plan, or the finished frame. Always: a frame is drawn from one set of shader sources, also when they change meanwhile;
//! modules whose entries on disk were tampered with are rebuilt.

use super::renderers::{RenderOutput, RendererError, RequestedOutput};
use super::{DrawnFrame, Session, SessionError, Stage};
use crate::render::frame::Frame;
use crate::render::plan::{self, FrameImages, Plan, PlanError, SamplingQuality};
use crate::render::software::SoftwareRenderer;
use crate::scene::Scene;
use crate::scene::request::ViewRequest;
use crate::shader::ModuleId;
use crate::shader::fragments::Fragments;

impl Session {
    /// Scene and plan of a view. A map that cannot be read is reported once, and its body is drawn without the map.
    ///
    /// # Errors
    /// The scene cannot be built, or a module cannot be compiled.
    pub fn plan(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<(Scene, Plan), SessionError> {
        if !request.composition.is_plain() {
            return self.composite_plan(request, sampling);
        }
        loop {
            let scene = self.scene_with(request, |required| self.timed(Stage::Maps, || self.read_maps(required)))?;
            let modules = plan::modules(&scene);
            let report_no_progress = || {};
            self.timed(Stage::Shaders, || self.library.warm(&modules, report_no_progress));
            match self.timed(Stage::Plan, || plan::plan(&scene, self, sampling)) {
                Ok(plan) => return Ok((scene, plan)),
                // A map that was not among the `required` ones, and so was not read before, is unreadable: the scene is built again without it.
                Err(PlanError::Map { file, why }) if self.record_unreadable_map(&file, &why) => {}
                Err(_) if self.replace_tampered(&modules) => {}
                Err(e) => return Err(e.into()),
            }
        }
    }

    /// The passes and draws of a view in their order, as text; of a composed image only the passes.
    ///
    /// # Errors
    /// See [`Self::plan`].
    pub fn passes(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<String, SessionError> {
        let (scene, plan) = self.plan(request, sampling)?;
        let steps = if request.composition.is_plain() { plan::steps(&scene, self, sampling)? } else { Vec::new() };
        Ok(plan::graph::listing(&steps, &plan))
    }

    /// Draws a view with the chosen renderer, or with the software renderer (`self.renderer()`) if the GPU fails. Waits until the GPU's pipelines are compiled.
    /// `images`: which images the frame contains, the displayed one alone or also the linear one.
    pub fn draw(&self, request: &ViewRequest, sampling: SamplingQuality, images: FrameImages) -> Result<DrawnFrame, SessionError> {
        self.draw_by(self.renderer(), request, sampling, images)
    }

    /// As [`Self::draw`], but what is drawn in software is drawn on the threads of [`Self::background_renderer`].
    pub fn draw_in_background(
        &self,
        request: &ViewRequest,
        sampling: SamplingQuality,
        images: FrameImages,
    ) -> Result<DrawnFrame, SessionError> {
        self.draw_by(self.background_renderer(), request, sampling, images)
    }

    /// See [`Self::draw`]. `software`: draws the view unless a GPU does.
    fn draw_by(
        &self,
        software: &SoftwareRenderer,
        request: &ViewRequest,
        sampling: SamplingQuality,
        images: FrameImages,
    ) -> Result<DrawnFrame, SessionError> {
        self.draw_planned(request, sampling, |plan| {
            self.devices.draw_waiting(software, plan, &self.library, RequestedOutput::Frame(images))
        })
    }

    /// Plans a view and calls `draw` with the plan. Repeats both if a module was tampered with on disk, or if the shader sources change meanwhile.
    fn draw_planned(
        &self,
        request: &ViewRequest,
        sampling: SamplingQuality,
        draw: impl Fn(&Plan) -> Result<RenderOutput, RendererError>,
    ) -> Result<DrawnFrame, SessionError> {
        self.with_unchanged_shader_sources(|| {
            loop {
                let (scene, plan) = self.plan(request, sampling)?;
                match self.timed(Stage::Draw, || draw(&plan)) {
                    Ok(output) => return Ok(drawn_frame(scene, &plan, output)),
                    Err(_) if self.replace_tampered(&plan.modules()) => {}
                    Err(why) => return Err(why.into()),
                }
            }
        })
    }

    /// Draws a plan with the chosen renderer, as [`Self::draw`] does.
    pub(crate) fn draw_plan(&self, plan: &Plan, images: FrameImages) -> Result<Frame, SessionError> {
        Ok(self.devices.draw_waiting(self.renderer(), plan, &self.library, RequestedOutput::Frame(images))?.frame)
    }

    /// Replaces the modules whose entries on disk were tampered with. Returns whether there was any; if not, a retry is of no use.
    pub(super) fn replace_tampered(&self, modules: &[ModuleId]) -> bool {
        let replaced = self.library.replace_tampered(modules) > 0;
        if replaced {
            self.devices.forget_modules();
        }
        replaced
    }

    /// Compiles modules from these shader sources from now on. The user's custom surfaces (`surfaces`) stay among them.
    pub fn set_fragments(&self, fragments: Fragments) {
        self.devices.change_shader_sources(|| self.library.set_fragments(fragments.and_files(self.surfaces.iter().cloned())));
    }

    /// Draws a view for a window; in software if the GPU is not ready for this view.
    pub fn draw_without_waiting(
        &self,
        request: &ViewRequest,
        sampling: SamplingQuality,
        requested: RequestedOutput,
    ) -> Result<DrawnFrame, SessionError> {
        // By this plan a GPU prepares the pipelines of the window's interface. In software the interface is painted without shader modules.
        let interface_plan = || plan::warm_up_interface(self).ok();
        self.draw_planned(request, sampling, |plan| self.devices.draw_without_waiting(plan, interface_plan, &self.library, requested))
    }

    /// Repeats `draw` until the shader sources do not change during the call. A plan has the layouts and uniform bytes of its modules, but a renderer
    /// fetches each module only when it draws the module's pass: after a change, that module no longer fits the plan.
    fn with_unchanged_shader_sources<T>(&self, mut draw: impl FnMut() -> Result<T, SessionError>) -> Result<T, SessionError> {
        loop {
            let changes_before = self.devices.shader_source_changes();
            let drawn = draw();
            if self.devices.shader_source_changes() == changes_before {
                return drawn;
            }
        }
    }
}

fn drawn_frame(scene: Scene, plan: &Plan, RenderOutput { frame, gpu_image, drawn_by }: RenderOutput) -> DrawnFrame {
    DrawnFrame { scene, simple_draws: plan.simple_draws(), frame, gpu_image, drawn_by }
}

#[cfg(test)]
mod tests {
    use super::super::Sources;
    use super::*;
    use crate::shader::fragments::FRAGMENTS;

    #[test]
    fn a_frame_during_which_the_shader_sources_change_is_drawn_again() {
        let cache = tempfile::tempdir().expect("a folder");
        let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
        let session = Session::open(&sources, |line| panic!("{line}")).expect("a session");
        let (path, text) = FRAGMENTS[0];
        let mut drawn = 0;
        let last = session.with_unchanged_shader_sources(|| {
            drawn += 1;
            if drawn == 1 {
                session.set_fragments(Fragments::with_files([(path.to_owned(), format!("{text}\n// edited\n"))]));
                // Undone within the same frame: the shader sources are the same again, but the frame may be mixed.
                session.set_fragments(Fragments::default());
                // The mixture of old and new modules may be an error.
                return Err(SessionError::File { path: path.to_owned(), why: "does not fit".to_owned() });
            }
            Ok(drawn)
        });
        assert!(last.is_ok_and(|n| n == 2) && drawn == 2, "{drawn}");
    }
}
