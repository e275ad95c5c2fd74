//! The loop from the view state to the image on screen: receives finished images from the worker and requests the next one.
//!
//! In: the view, the viewport's size, finished images. Out: render jobs, textures. Always: images are coarse while the view moves, and an
//! image at full resolution follows soon after the motion ends; after a failure the last valid image stays visible. Not here: the layout of
//! panels.

use super::Interface;
use crate::catalog::NaifId;
use crate::render::plan::{FrameImages, GpuImage, SamplingQuality};
use crate::scene::labels::{Label, LabelMetrics, Rect, SkyObject, body_labels};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::scene::request::{ExposureRequest, Look, Position, Quality, Up, ViewRequest};
use crate::session::{Readiness, RequestedOutput, Session};
use crate::view::app::exposure_adaptation::ExposureTicket;
use crate::view::app::view_state::ViewStateError;
use crate::view::app::viewer::REAL_TIME_INTERVAL_S;
use crate::view::error_texts::error_text;
use crate::view::language::{self, body_name};
use crate::view::worker::adaptive_resolution::AdaptiveResolution;
use crate::view::worker::render_worker::{RenderJob, RenderWorker, RenderedView};
use crate::view::worker::session_inputs::SessionInputs;
use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use glam::DVec3;

/// Time after the last motion of the view until an image at full resolution is requested, seconds.
const STILL_AFTER_S: f64 = 0.18;
/// Additional delay of the frame that requests the image at full resolution, seconds: for a frame that came a moment too early, the view would still count
/// as moving.
const STILL_MARGIN_S: f64 = 0.005;
/// Interval between checks whether the GPU is ready to replace the software renderer, seconds.
const READY_CHECK_S: f64 = 0.1;
/// Largest fraction of real time that is spent on drawing while the view is at rest and the displayed time runs no faster than real time.
const MAX_REAL_TIME_LOAD: f64 = 0.1;

/// Change of the displayed time, seconds, above which a new image is drawn at once: the user must have set the time, because images at real
/// time are rarely so far apart.
const TIME_JUMP_S: f64 = 120.0;
/// Upper bound of the motion of any body's pole within [`TIME_JUMP_S`], radians. A camera in orbit is placed relative to the pole and moves with it:
/// positions and directions that differ by less (relative to their length) count as unchanged, but only in a view at rest, so that a drag is always
/// drawn at once. The fastest pole of catalogs/pck00011.tpc is that of Neptune's moon Naiad: at most 7.3e-6 by the rates and amplitudes of its
/// series; all others stay below 1.3e-6. Bodies without such a series, which turn with their orbits, were not examined.
const MAX_POLE_MOTION_RAD: f64 = 1e-5;

/// What an image shows at a place.
#[derive(Clone, Copy)]
pub(super) struct SeenPlace {
    /// The body there, if any.
    pub(super) body: Option<NaifId>,
    /// The star, comet or minor planet there, if there is no body.
    pub(super) sky_object: Option<SkyObject>,
    /// The direction of the place, or of the body or star near it, as an ICRF unit vector; `None` outside the circle of a fisheye image.
    pub(super) direction: Option<DVec3>,
    /// The pixel of the viewport.
    pub(super) viewport_px: [u32; 2],
}

/// The image on screen, the last requested image, and their state. Times are in egui's time (`InputState::time`).
pub(super) struct Viewport {
    /// The pixels of the image; `None` if it is on the GPU, and before the first image.
    pub(super) texture: Option<TextureHandle>,
    /// The last valid image; `None` before the first.
    pub(super) shown: Option<RenderedView>,
    /// The last job sent to the worker; `None` if the next frame must request an image.
    pub(super) requested: Option<RenderJob>,
    /// Time of the last request.
    pub(super) requested_s: f64,
    /// Time of the last action that moved the view.
    pub(super) last_motion_s: f64,
    /// Start of the current frame of the interface; NaN before the first.
    pub(super) frame_start_s: f64,
    /// The resolution of coarse images.
    pub(super) resolution: AdaptiveResolution,
    /// Size of the viewport, pixels.
    pub(super) size_px: [u32; 2],
    /// The pixel that the probe inspects, in an image of `size_px`: the last one clicked or typed.
    pub(super) picked_px: Option<[u32; 2]>,
    /// Number of images shown so far.
    pub(super) images_shown: u64,
    /// What images depend on besides their requests, as of the last frame of the interface; a change requires a new image.
    pub(super) session_inputs: Option<SessionInputs>,
    /// The labels and markers of the bodies in the displayed image.
    pub(super) labels: Vec<Label>,
    /// Rectangles of the message, the hints, a tour's text and *What to see now* over the viewport, as shown last, points.
    pub(super) overlays: Vec<egui::Rect>,
    /// Height of the caption at the viewport's lower edge, points.
    pub(super) caption_height: f32,
    /// What was under the pointer at the press, while its button is down.
    pub(super) pressed_place: Option<SeenPlace>,
    /// The body at the last right click, if there was one.
    pub(super) menu_body: Option<NaifId>,
    /// The direction of the last right click, or of the body or star near it, as an ICRF unit vector. A pixel would not do, because images with
    /// other resolutions may follow while the menu is open.
    pub(super) menu_direction: Option<DVec3>,
    /// The last star, comet or minor planet that was clicked or found.
    pub(super) sky_object: Option<SkyObject>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            texture: None,
            shown: None,
            requested: None,
            requested_s: f64::NEG_INFINITY,
            last_motion_s: f64::NEG_INFINITY,
            frame_start_s: f64::NAN,
            resolution: AdaptiveResolution::default(),
            size_px: [1, 1],
            picked_px: None,
            images_shown: 0,
            session_inputs: None,
            labels: Vec::new(),
            overlays: Vec::new(),
            caption_height: 0.0,
            pressed_place: None,
            menu_body: None,
            menu_direction: None,
            sky_object: None,
        }
    }
}

impl Interface {
    /// The last valid image.
    pub fn shown(&self) -> Option<&RenderedView> {
        self.viewport.shown.as_ref()
    }

    /// Rectangles of the message, the hints, a tour's text and *What to see now* over the viewport, as shown last, points.
    pub fn overlays(&self) -> &[egui::Rect] {
        &self.viewport.overlays
    }

    /// Number of images shown so far.
    pub(crate) fn images_shown(&self) -> u64 {
        self.viewport.images_shown
    }

    /// The last image, if it stayed on the GPU.
    pub(crate) fn gpu_image(&self) -> Option<&GpuImage> {
        self.viewport.shown.as_ref().and_then(|rendered| rendered.gpu_image.as_ref())
    }

    /// Drops an image on a GPU that does not present the window, and lets the next frame request a new image.
    pub(crate) fn drop_gpu_image(&mut self) {
        if let Some(rendered) = &mut self.viewport.shown {
            rendered.gpu_image = None;
        }
        self.viewport.requested = None;
    }

    /// Takes a finished image from the worker.
    pub(super) fn receive(&mut self, ctx: &egui::Context, worker: &dyn RenderWorker) {
        match worker.take() {
            None => {}
            Some(Err(failed)) => {
                self.adaptation.record_failure(failed.exposure_ticket);
                self.record_failure(&failed.why, worker);
            }
            Some(Ok(mut rendered)) => {
                self.failure_reason = None;
                let pixel_count = u64::from(rendered.width) * u64::from(rendered.height);
                if rendered.job.sampling == SamplingQuality::of(Quality::Draft) {
                    self.viewport.resolution.record(pixel_count, rendered.render_ms, rendered.idle_ms);
                }
                let pixels = std::mem::take(&mut rendered.rgba);
                if rendered.gpu_image.is_some() {
                    self.viewport.texture = None;
                } else {
                    let image = colour_image(rendered.width, rendered.height, pixels);
                    match &mut self.viewport.texture {
                        Some(texture) => texture.set(image, TextureOptions::LINEAR),
                        empty => *empty = Some(ctx.load_texture("sky", image, TextureOptions::LINEAR)),
                    }
                }
                self.performance.record(&rendered, self.viewport.frame_start_s);
                self.adaptation.record(&rendered.scene.exposure, rendered.job.exposure_ticket);
                // An exposure in transition is replaced by automatic exposure, so that requests derived from this image do not inherit it.
                if let ExposureRequest::Transition { .. } = rendered.job.request.exposure {
                    rendered.job.request.exposure = ExposureRequest::Auto;
                }
                self.viewport.shown = Some(rendered);
                self.viewport.images_shown += 1;
            }
        }
    }

    /// Stores the reason why there is no image of this view. Before the first image, the reason is also passed to [`Session::notify`], in English.
    fn record_failure(&mut self, why: &(dyn std::error::Error + 'static), worker: &dyn RenderWorker) {
        let text = error_text(why);
        if self.viewport.shown.is_none() && self.failure_reason.as_ref() != Some(&text) {
            worker.session().notify(&why.to_string());
        }
        self.failure_reason = Some(text);
    }

    /// Computes the labels and markers of the bodies in the displayed image. Names avoid the texts in the image and the `overlays`:
    /// rectangles that the interface shows over the image, in its pixels.
    pub(super) fn refresh_labels(&mut self, metrics: &LabelMetrics, overlays: impl IntoIterator<Item = Rect>) {
        let Some(rendered) = &self.viewport.shown else { return };
        let scene = &rendered.scene;
        let parent_of = |id: NaifId| self.viewer.selectable_body(id).and_then(|s| s.parent);
        let translated_name = |name: &str| body_name(name).to_owned();
        let occupied: Vec<Rect> = overlays.into_iter().chain(scene.text_and_bar_rects()).collect();
        self.viewport.labels = body_labels(
            &*scene.geometry.projection(&scene.camera),
            &scene.bodies,
            self.viewer.selected,
            parent_of,
            metrics,
            translated_name,
            &occupied,
        );
    }

    /// The job for an image of the current view, at the view's quality unless another one is given.
    fn image_job(&self, session: &Session, [width, height]: [u32; 2], quality: Option<Quality>) -> Result<RenderJob, ViewStateError> {
        let mut request = self.viewer.view.request(session.catalog(), session.ephemeris(), width, height)?;
        request.composition.warp.clone_from(&self.warp);
        if let Some(quality) = quality {
            request.quality = quality;
        }
        // The selected body is not outlined if it is the target.
        let selected = self.viewer.selected;
        request.layers.outline = self.settings.outlines_selected && selected != self.viewer.view.target;
        request.selected = request.layers.outline.then_some(selected);
        let output = if self.presents_on_gpu { RequestedOutput::OnGpu } else { RequestedOutput::Frame(FrameImages::Display) };
        Ok(RenderJob { sampling: SamplingQuality::of(request.quality), request, output, exposure_ticket: ExposureTicket::default() })
    }

    /// Sends a job for the current view to the worker, at the exposure that the adaptation has reached.
    fn submit(&mut self, job: RenderJob, worker: &dyn RenderWorker, now_s: f64) {
        self.viewport.requested = Some(job.clone());
        let (exposure, exposure_ticket) = self.adaptation.next_exposure(&self.viewer.view, now_s);
        worker.submit(RenderJob { request: ViewRequest { exposure, ..job.request }, exposure_ticket, ..job });
    }

    /// Requests the first image before there is a window, so that it is drawn while the window opens. Its size is computed from the
    /// viewport of the last run; if the viewport now has another aspect ratio, the image is cropped or has margins until the next image.
    pub fn request_first_image(&mut self, worker: &dyn RenderWorker) {
        language::set(self.language);
        // No image has been measured yet, so the divisor does not depend on the number of pixels.
        let divisor = self.viewport.resolution.divisor(1);
        let [width, height] = self.settings.panels.viewport_px.map(|side| (f64::from(side.clamp(1, MAX_IMAGE_PX)) / divisor).ceil() as u32);
        // An error is shown when the window requests the same image.
        if let Ok(job) = self.image_job(worker.session(), [width, height], Some(Quality::Draft)) {
            // egui's time starts at about 0.
            self.submit(job, worker, 0.0);
        }
    }

    /// Whether the first image is still being drawn and will show the job's view, although perhaps at another size or time.
    fn is_first_image_pending(&self, job: &RenderJob) -> bool {
        let is_same_view = |last: &RenderJob| {
            let size = (last.request.width, last.request.height);
            let mut request = job.request.clone();
            (request.width, request.height) = size;
            let ignores_time = true;
            last.sampling == job.sampling && !differs(&last.request, &request, ignores_time)
        };
        self.viewport.shown.is_none() && self.viewport.requested.as_ref().is_some_and(is_same_view)
    }

    /// Requests the image of the current view if it is needed, at a coarse resolution while the view moves.
    pub(super) fn request_image(&mut self, ctx: &egui::Context, worker: &dyn RenderWorker, now_s: f64) {
        // The first image is coarse, too, so that it appears soon after the window.
        let is_moving = self.viewer.is_animating() || now_s - self.viewport.last_motion_s < STILL_AFTER_S || self.viewport.shown.is_none();
        let [width, height] = self.viewport.size_px;
        // Pixels of the viewport per pixel of the image, along each side.
        let divisor = if is_moving { self.viewport.resolution.divisor(u64::from(width) * u64::from(height)) } else { 1.0 };
        let [image_width, image_height] = [width, height].map(|side| (f64::from(side) / divisor).ceil() as u32);
        let session = worker.session();
        let session_inputs = SessionInputs::of(session);
        let readiness = session.readiness();
        if self.viewport.session_inputs.replace(session_inputs.clone()).is_some_and(|last| last != session_inputs)
            || readiness == Readiness::JustReady
        {
            // The same view now gives another image, so the image is requested again.
            self.viewport.requested = None;
        }
        match self.image_job(session, [image_width, image_height], is_moving.then_some(Quality::Draft)) {
            Ok(job) => self.submit_if_needed(job, is_moving, worker, now_s),
            Err(why) => self.record_failure(&why, worker),
        }
        // The fields of these settings are in the Information panel.
        (self.settings.unit, self.settings.home) = (self.information.unit, self.information.observer_place);
        let until_still_s = STILL_AFTER_S - (now_s - self.viewport.last_motion_s);
        let is_animating = self.viewer.is_animating();
        let awaits_first_image = self.viewport.shown.is_none() && self.failure_reason.is_none();
        // Times until the interface needs its next frame, also if there is no image of the view: time runs on, and messages disappear.
        let delays_s = [
            self.viewer.frame_interval_s(),
            (until_still_s > 0.0 && !is_animating).then_some(until_still_s + STILL_MARGIN_S),
            // The worker of the tests has drawn the first image already; the next frame takes it.
            (awaits_first_image && !is_animating).then_some(0.0),
            (readiness == Readiness::Preparing).then_some(READY_CHECK_S),
            self.notice.remaining_s(now_s),
            // A new reply has its time from the next frame on.
            (!self.reply.is_empty()).then(|| self.reply_until_s.map_or(0.0, |until_s| until_s - now_s)),
        ];
        if let Some(delay_s) = delays_s.into_iter().flatten().reduce(f64::min) {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(delay_s.max(0.0)));
        }
    }

    /// Submits the job if the last requested image does not show its view, or the adaptation of the exposure needs another image.
    fn submit_if_needed(&mut self, job: RenderJob, is_moving: bool, worker: &dyn RenderWorker, now_s: f64) {
        // While time runs no faster than real time, little changes between images, so they are drawn rarely enough to keep the load low.
        let drawing_s = 1e-3 * self.viewport.shown.as_ref().map_or(0.0, |rendered| rendered.render_ms);
        let interval_s = REAL_TIME_INTERVAL_S.max(drawing_s / MAX_REAL_TIME_LOAD);
        let ignores_time = !is_moving && now_s - self.viewport.requested_s < interval_s;
        let is_stale = self
            .viewport
            .requested
            .as_ref()
            .is_none_or(|last| last.sampling != job.sampling || differs(&last.request, &job.request, ignores_time))
            && !self.is_first_image_pending(&job);
        if is_stale || self.adaptation.needs_another_image() {
            self.viewport.requested_s = now_s;
            self.submit(job, worker, now_s);
        }
    }
}

/// Whether the new request needs another image than the last one. `ignores_time`: time that passes without a jump does not need another image.
pub(super) fn differs(last: &ViewRequest, new: &ViewRequest, ignores_time: bool) -> bool {
    if !ignores_time {
        return last != new;
    }
    let jump_s = new.time.tdb_seconds_past_j2000() - last.time.tdb_seconds_past_j2000();
    *last != with_last_time_and_pose(last, new) || jump_s.abs() > TIME_JUMP_S
}

/// The new request with the time of the last request, and with its position and directions where these differ by no more than
/// [`MAX_POLE_MOTION_RAD`].
fn with_last_time_and_pose(last: &ViewRequest, new: &ViewRequest) -> ViewRequest {
    let is_close = |a: DVec3, b: DVec3| a.distance(b) <= MAX_POLE_MOTION_RAD * a.length();
    let position = match (last.position, new.position) {
        (Position::Offset { body, offset_km, axes }, Position::Offset { body: new_body, offset_km: new_offset_km, axes: new_axes })
            if (body, axes) == (new_body, new_axes) && is_close(offset_km, new_offset_km) =>
        {
            last.position
        }
        _ => new.position,
    };
    let look = match (last.look, new.look) {
        (Look::Along { direction, axes }, Look::Along { direction: new_direction, axes: new_axes })
            if axes == new_axes && is_close(direction, new_direction) =>
        {
            last.look
        }
        _ => new.look,
    };
    let up = match (last.up, new.up) {
        (Up::Along { direction, axes }, Up::Along { direction: new_direction, axes: new_axes })
            if axes == new_axes && is_close(direction, new_direction) =>
        {
            last.up
        }
        _ => new.up,
    };
    ViewRequest { time: last.time, position, look, up, ..new.clone() }
}

/// Opaque display bytes as an egui image.
pub(in crate::view) fn colour_image(width: u32, height: u32, rgba: Vec<[u8; 4]>) -> ColorImage {
    let pixels = rgba.into_iter().map(|[r, g, b, _]| Color32::from_rgb(r, g, b)).collect();
    ColorImage::new([width as usize, height as usize], pixels)
}
