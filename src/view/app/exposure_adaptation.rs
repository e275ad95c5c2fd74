//! Automatic exposure of the window: it smoothly approaches the metered value, which the light meter of each image's scene computes.
//!
//! In: metered exposures of finished images, real time, the view. Out: the exposure of the next request. Always: while the metered value is
//! constant, the difference in stops decays as exp(-t / `TIME_CONSTANT_S`), where t is the real time at which an image is requested. This holds at any
//! frame rate and with any number of pending requests. The first image has the metered exposure, and so have the first after a cut and the first after
//! manual exposure. This module reads no clock. Saved images do not adapt: their automatic exposure is the metered value.
//!
//! A cut is a change of the pixel view, or of the target, the camera's body or the kind of camera pose. If the pose is free before or after the change,
//! only a change of the pixel view is a cut, because flights and tours use free poses.
//!
//! A changed metered value becomes known only when the first image with the new value is finished. The decay towards it is then counted from the request
//! of the last image with the old value. During continuous drawing, this start is too early by at most the interval between two requests. For the first image
//! with the new value the decay even starts one interval earlier: this image was requested before the last image with the old value was finished, so its
//! decay is counted from the request of the image before that one. If no image was requested for several time constants before the change, the first images
//! after the change have the metered exposure at once.

use crate::catalog::NaifId;
use crate::scene::Exposure;
use crate::scene::draw::PixelView;
use crate::scene::request::ExposureRequest;
use crate::view::app::view_state::{CameraPose, ViewState};
use std::mem::{Discriminant, discriminant};

/// Time constant of the adaptation, chosen by trial. A camera's automatic exposure and the eye's neural adaptation take about half a second; the
/// eye's photochemical adaptation takes minutes, which is too long to wait for.
pub(crate) const TIME_CONSTANT_S: f64 = 0.4;
/// Number of consecutive failed images after which no further image is requested for the adaptation alone. The cause of a failure usually lasts.
const MAX_FAILURES: u32 = 3;

/// The parts of a view whose change is a cut; the module comment states the exceptions.
#[derive(Clone, Copy, PartialEq)]
struct ViewIdentity {
    target: NaifId,
    camera_body: NaifId,
    pose_kind: Discriminant<CameraPose>,
    has_free_pose: bool,
    pixel_view: PixelView,
}

impl ViewIdentity {
    fn of(view: &ViewState) -> Self {
        Self {
            target: view.target,
            camera_body: view.camera_pose.body(),
            pose_kind: discriminant(&view.camera_pose),
            has_free_pose: matches!(view.camera_pose, CameraPose::Free { .. }),
            pixel_view: view.pixel_view,
        }
    }

    fn is_cut_from(&self, last: &Self) -> bool {
        self.pixel_view != last.pixel_view || (self != last && !self.has_free_pose && !last.has_free_pose)
    }
}

/// Identifies the request of an image. The job carries the ticket, and its result (the image, or the reason why there is none) returns the ticket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExposureTicket {
    /// Requests are numbered from 1. The default, 0, belongs to no request, and its image is ignored.
    number: u64,
    /// Real time of the request, seconds.
    requested_s: f64,
}

/// The adapted exposure at the request of the last finished image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LastExposure {
    /// The exposure of the image, or, if images overlapped, the exposure that continues the adaptation; see [`ExposureAdaptation::record`].
    stops: f64,
    /// Whether the image had the metered exposure.
    is_metered: bool,
    /// Real time of the request, seconds.
    requested_s: f64,
}

impl LastExposure {
    /// The exposure to request at the later time `now_s`, real seconds.
    fn request_at(&self, now_s: f64) -> ExposureRequest {
        // 1 - exp(-t / T), where t is the time since `requested_s` and T the time constant.
        let progress = -(-(now_s - self.requested_s).max(0.0) / TIME_CONSTANT_S).exp_m1();
        ExposureRequest::Transition { from_stops: self.stops, progress }
    }
}

/// The state of the adaptation.
#[derive(Default)]
pub(crate) struct ExposureAdaptation {
    /// Identity of the view of the newest request; `None` before the first.
    identity: Option<ViewIdentity>,
    /// `None`: the next request is for the metered exposure.
    last: Option<LastExposure>,
    /// Number of the newest request.
    newest_request: u64,
    /// Images of requests with at most this number are ignored: they show a view before the last cut, or were requested before or during manual exposure.
    last_ignored_request: u64,
    /// Number of the newest request whose image is finished or has failed. Some requests are never answered, because a newer one replaces
    /// them before they are started, but the newest one always is.
    newest_answered_request: u64,
    /// Failed images since the last finished one.
    failure_count: u32,
}

impl ExposureAdaptation {
    /// Resets the adaptation if the newest request is the first after a cut, or if the exposure is manual. Images that were requested before the cut or
    /// before manual exposure may still arrive: they are ignored, as are images with manual exposure.
    fn reset_if_cut_or_manual(&mut self, view: &ViewState) {
        let identity = ViewIdentity::of(view);
        let is_cut = self.identity.replace(identity).is_none_or(|last| identity.is_cut_from(&last));
        if view.exposure_stops.is_some() {
            (self.last, self.last_ignored_request) = (None, self.newest_request);
        } else if is_cut {
            (self.last, self.last_ignored_request) = (None, self.newest_request - 1);
        }
    }

    /// The exposure to request for the next image of a view, and the ticket to hand back with the image. `now_s`: real time, seconds.
    pub(crate) fn next_exposure(&mut self, view: &ViewState, now_s: f64) -> (ExposureRequest, ExposureTicket) {
        self.newest_request += 1;
        self.reset_if_cut_or_manual(view);
        let exposure = match (view.exposure_stops, self.last) {
            (Some(stops), _) => ExposureRequest::Stops(stops),
            (None, None) => ExposureRequest::Auto,
            (None, Some(last)) => last.request_at(now_s),
        };
        (exposure, ExposureTicket { number: self.newest_request, requested_s: now_s })
    }

    /// Records the exposure of a finished image.
    pub(crate) fn record(&mut self, exposure: &Exposure, ticket: ExposureTicket) {
        self.newest_answered_request = self.newest_answered_request.max(ticket.number);
        if ticket.number <= self.last_ignored_request {
            return;
        }
        self.failure_count = 0;
        let is_metered = exposure.stops == exposure.metered_stops;
        let stops = match self.last {
            // If the image before this one was unfinished when this one was requested, this image started from the exposure of an earlier one.
            // The adaptation continues from the last finished image all the same. Otherwise the images of two overlapping series would adapt
            // independently, and the brightness would alternate between the two.
            Some(last) if !is_metered => last.request_at(ticket.requested_s).stops_of(exposure.metered_stops),
            _ => exposure.stops,
        };
        self.last = Some(LastExposure { stops, is_metered, requested_s: ticket.requested_s });
    }

    /// Records that a requested image could not be drawn.
    pub(crate) fn record_failure(&mut self, ticket: ExposureTicket) {
        self.newest_answered_request = self.newest_answered_request.max(ticket.number);
        if ticket.number > self.last_ignored_request {
            self.failure_count = self.failure_count.saturating_add(1);
        }
    }

    /// Whether to request another image of an unchanged view, because the last one had not reached the metered exposure. False while a
    /// requested image is pending, and after repeated failures.
    pub(crate) fn needs_another_image(&self) -> bool {
        let is_pending = self.newest_answered_request < self.newest_request;
        !is_pending && self.failure_count < MAX_FAILURES && self.last.is_some_and(|last| !last.is_metered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Reason;
    use crate::time::Instant;
    use glam::DVec3;

    /// Frames of the interface per second.
    const FRAME_RATE_HZ: f64 = 60.0;
    /// The fraction of a step of the metered value that is covered after one time constant.
    const COVERED_FRACTION: f64 = 1.0 - 1.0 / std::f64::consts::E;

    fn view(target: NaifId) -> ViewState {
        ViewState::around(target, DVec3::X * 1e5, 6378.0, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.0))
    }

    fn in_free_pose(view: ViewState) -> ViewState {
        ViewState { camera_pose: CameraPose::Free { body: view.target, offset_km: DVec3::X, forward: DVec3::X, up: DVec3::Z }, ..view }
    }

    /// The exposure of a scene with the given metering, for a request.
    fn exposure_of(requested: ExposureRequest, metered_stops: f64) -> Exposure {
        Exposure { stops: requested.stops_of(metered_stops), metered_stops, reason: Reason::default() }
    }

    /// Requests an image and finishes it at once. Returns its stops.
    fn draw_at_once(adaptation: &mut ExposureAdaptation, view: &ViewState, now_s: f64, metered_stops: f64) -> f64 {
        let (requested, ticket) = adaptation.next_exposure(view, now_s);
        let exposure = exposure_of(requested, metered_stops);
        adaptation.record(&exposure, ticket);
        exposure.stops
    }

    /// An adaptation that has shown a view of the Earth at 0 stops, and has just begun to approach 10 stops.
    fn adapting() -> ExposureAdaptation {
        let mut adaptation = ExposureAdaptation::default();
        draw_at_once(&mut adaptation, &view(NaifId::EARTH), 0.0, 0.0);
        draw_at_once(&mut adaptation, &view(NaifId::EARTH), 0.01, 10.0);
        assert!(adaptation.needs_another_image());
        adaptation
    }

    /// From 0 to 10 stops: at each frame rate, one time constant covers 1 - 1/e of the difference, and the exposure ends at exactly 10.
    #[test]
    fn stops_approach_with_the_time_constant_at_any_frame_rate() {
        for rate_hz in [5.0, 20.0, 100.0] {
            let (mut adaptation, view) = (ExposureAdaptation::default(), view(NaifId::EARTH));
            let mut draw = |now_s: f64, metered_stops: f64| {
                let stops = draw_at_once(&mut adaptation, &view, now_s, metered_stops);
                (stops, adaptation.needs_another_image())
            };
            assert_eq!(draw(0.0, 0.0), (0.0, false), "the first image has the metered exposure");
            let (mut last_stops, mut stops_at_time_constant) = (0.0, f64::NAN);
            // Four seconds: ten time constants.
            for k in 1..=(4.0 * rate_hz) as u32 {
                let now_s = f64::from(k) / rate_hz;
                let (stops, needs_another_image) = draw(now_s, 10.0);
                assert!((stops > last_stops || last_stops == 10.0) && stops <= 10.0, "{stops} after {last_stops}");
                assert_eq!(needs_another_image, stops != 10.0);
                if (now_s - TIME_CONSTANT_S).abs() < 1e-9 {
                    stops_at_time_constant = stops;
                }
                last_stops = stops;
            }
            assert!((stops_at_time_constant - 10.0 * COVERED_FRACTION).abs() < 1e-6, "{stops_at_time_constant} at {rate_hz} Hz");
            assert_eq!(last_stops, 10.0, "the exposure ends at the metered value");
        }
    }

    /// An image of the simulation.
    #[derive(Debug)]
    struct SimulatedImage {
        /// Real time of the request, seconds.
        requested_s: f64,
        /// Exposure of the image.
        stops: f64,
    }

    /// Simulates six seconds in which the view moves, so that each frame of the interface requests an image. As in the window, the worker draws one image,
    /// which takes `image_s`, while the newest other request waits. The metered value is 0 stops before `step_s`, then 10. `has_own_time`: each image is
    /// recorded with the time of its own request; otherwise with the time of the newest request.
    fn images_of_a_step(image_s: f64, step_s: f64, has_own_time: bool) -> Vec<SimulatedImage> {
        type Job = (ExposureRequest, ExposureTicket);
        let (mut adaptation, view) = (ExposureAdaptation::default(), view(NaifId::EARTH));
        let (mut drawing, mut waiting): (Option<(Job, f64)>, Option<Job>) = (None, None);
        let mut newest_request_s = 0.0;
        let mut images = Vec::new();
        for frame in 0..360 {
            let now_s = f64::from(frame) / FRAME_RATE_HZ;
            if let Some(((requested, ticket), end_s)) = drawing.filter(|(_, end_s)| *end_s <= now_s) {
                drawing = waiting.take().map(|job| (job, end_s + image_s));
                let exposure = exposure_of(requested, if ticket.requested_s < step_s { 0.0 } else { 10.0 });
                images.push(SimulatedImage { requested_s: ticket.requested_s, stops: exposure.stops });
                let recorded = if has_own_time { ticket } else { ExposureTicket { requested_s: newest_request_s, ..ticket } };
                adaptation.record(&exposure, recorded);
            }
            newest_request_s = now_s;
            let job = adaptation.next_exposure(&view, now_s);
            if drawing.is_none() {
                drawing = Some((job, now_s + image_s));
            } else {
                waiting = Some(job);
            }
        }
        images
    }

    /// An image takes 50 or 100 ms, and two requests are pending. From the second image after a step on, the remaining difference is exp(-t / T)
    /// of the step, where t counts from the request of the last image before the step. Successive requests are apart by at most the times of one
    /// image and one frame. So the first image that covers 1 - 1/e of the step is requested T after the step, with at most this error.
    #[test]
    fn stops_approach_with_the_time_constant_while_images_overlap() {
        for image_s in [0.05, 0.1] {
            for step_s in [1.0, 1.03, 1.06, 1.09] {
                let has_own_time = true;
                let images = images_of_a_step(image_s, step_s, has_own_time);
                let interval_s = image_s + 1.0 / FRAME_RATE_HZ + 1e-9;
                assert!(images.windows(2).all(|pair| pair[1].requested_s - pair[0].requested_s <= interval_s));
                let first_after_step = images.iter().position(|image| image.requested_s >= step_s).expect("images after the step");
                let largest_error = |images: &[SimulatedImage]| {
                    let start_s = images[first_after_step - 1].requested_s;
                    let error = |image: &SimulatedImage| {
                        let expected = 10.0 * (1.0 - (-(image.requested_s - start_s) / TIME_CONSTANT_S).exp());
                        // A transition ends once the difference is invisible ([`ExposureRequest::stops_of`]).
                        if image.stops == 10.0 && expected > 9.97 { 0.0 } else { (image.stops - expected).abs() }
                    };
                    images[first_after_step + 1..].iter().map(error).fold(0.0, f64::max)
                };
                assert!(largest_error(&images) < 1e-9, "{} stops", largest_error(&images));
                let is_monotonic = images[first_after_step - 1..].windows(2).all(|pair| pair[1].stops >= pair[0].stops - 1e-9);
                assert!(is_monotonic, "the brightness alternates: {images:?}");
                let is_covered = |image: &&SimulatedImage| image.stops >= 10.0 * COVERED_FRACTION;
                let covered = images.iter().find(is_covered).expect("an image near the metered exposure");
                let time_s = covered.requested_s - step_s;
                assert!((time_s - TIME_CONSTANT_S).abs() <= interval_s, "{time_s} s with images of {image_s} s");
                // Negative control: each image is recorded with the time of the newest request, which is later than that of its own. The exposures then
                // differ from the decay by more than half a stop.
                let error = largest_error(&images_of_a_step(image_s, step_s, !has_own_time));
                assert!(error > 0.5, "{error} stops with the time of the newest request");
            }
        }
    }

    /// A new target without a flight is a cut, and so are other pixel values; a flight is not. Manual stops apply at once.
    #[test]
    fn exposure_jumps_after_a_cut_and_adapts_during_a_flight() {
        let after = |next: &ViewState| {
            let mut adaptation = ExposureAdaptation::default();
            draw_at_once(&mut adaptation, &view(NaifId::EARTH), 0.0, 0.0);
            adaptation.next_exposure(next, 0.1).0
        };
        assert_eq!(after(&view(NaifId::MOON)), ExposureRequest::Auto);
        assert!(matches!(after(&in_free_pose(view(NaifId::MOON))), ExposureRequest::Transition { from_stops: 0.0, .. }));
        assert!(matches!(after(&view(NaifId::EARTH)), ExposureRequest::Transition { .. }));
        assert_eq!(after(&ViewState { pixel_view: PixelView::Depth, ..in_free_pose(view(NaifId::EARTH)) }), ExposureRequest::Auto);
        assert_eq!(after(&ViewState { exposure_stops: Some(3.0), ..view(NaifId::EARTH) }), ExposureRequest::Stops(3.0));
    }

    /// An image of the old view that is finished after a cut does not become the start of an adaptation.
    #[test]
    fn a_late_image_of_an_old_view_is_ignored() {
        let (mut adaptation, moon) = (adapting(), view(NaifId::MOON));
        let (requested, late_ticket) = adaptation.next_exposure(&view(NaifId::EARTH), 0.1);
        let (_, moon_ticket) = adaptation.next_exposure(&moon, 0.15);
        adaptation.record(&exposure_of(requested, 10.0), late_ticket);
        assert!(!adaptation.needs_another_image());
        assert_eq!(adaptation.next_exposure(&moon, 0.2).0, ExposureRequest::Auto);
        adaptation.record(&exposure_of(ExposureRequest::Auto, 3.0), moon_ticket);
        assert!(matches!(adaptation.next_exposure(&moon, 0.25).0, ExposureRequest::Transition { from_stops: 3.0, .. }));
    }

    /// Images that were requested before or during manual exposure do not become the start of an adaptation, even if the user switches manual exposure
    /// off before they are finished.
    #[test]
    fn a_late_image_from_before_manual_exposure_is_ignored() {
        let (mut adaptation, auto) = (adapting(), view(NaifId::EARTH));
        let manual = ViewState { exposure_stops: Some(3.0), ..auto.clone() };
        let (requested, late_ticket) = adaptation.next_exposure(&auto, 0.1);
        let (manual_request, manual_ticket) = adaptation.next_exposure(&manual, 0.15);
        adaptation.record(&exposure_of(requested, 10.0), late_ticket);
        assert_eq!(adaptation.next_exposure(&auto, 0.2).0, ExposureRequest::Auto);
        adaptation.record(&exposure_of(manual_request, 10.0), manual_ticket);
        assert_eq!(adaptation.next_exposure(&auto, 0.25).0, ExposureRequest::Auto);
    }

    /// Of three requests, the third replaces the second while the second waits, so the second is never answered.
    #[test]
    fn another_image_is_needed_once_the_newest_request_is_answered() {
        let (mut adaptation, view) = (adapting(), view(NaifId::EARTH));
        let [first, _, third] = [0.02, 0.04, 0.06].map(|now_s| adaptation.next_exposure(&view, now_s));
        adaptation.record(&exposure_of(first.0, 10.0), first.1);
        assert!(!adaptation.needs_another_image(), "the third request is pending");
        adaptation.record(&exposure_of(third.0, 10.0), third.1);
        assert!(adaptation.needs_another_image());
    }

    /// The adaptation continues after a failed image, but an image that fails each time is not requested forever.
    #[test]
    fn a_failed_image_does_not_stop_the_adaptation() {
        let (mut adaptation, view) = (adapting(), view(NaifId::EARTH));
        let [older, newest] = [0.02, 0.04].map(|now_s| adaptation.next_exposure(&view, now_s).1);
        adaptation.record_failure(older);
        assert!(!adaptation.needs_another_image(), "the newest request is pending");
        adaptation.record_failure(newest);
        assert!(adaptation.needs_another_image());
        for _ in 2..MAX_FAILURES {
            let (_, ticket) = adaptation.next_exposure(&view, 0.06);
            adaptation.record_failure(ticket);
        }
        assert!(!adaptation.needs_another_image(), "the image fails each time");
        draw_at_once(&mut adaptation, &view, 0.08, 10.0);
        assert!(adaptation.needs_another_image());
    }
}
