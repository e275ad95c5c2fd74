//! Automatic exposure of the window: it approaches the metered value smoothly.
//!
//! In: metered exposures of drawn images, real time, the view. Out: the exposure of the next request. Always: the difference in stops decays as
//! exp(-t / `TIME_CONSTANT_S`) in real time, at any frame rate. The exposure takes the metered value at once for the first image, after a cut
//! (another target or camera position without a flight), and after manual exposure. This module reads no clock. Saved images do not adapt: their
//! automatic exposure is the metered value.

use crate::catalog::NaifId;
use crate::scene::Exposure;
use crate::scene::request::ExposureRequest;
use crate::view::app::view_state::{CameraPose, ViewState};
use std::mem::{Discriminant, discriminant};

/// Time constant of the adaptation, chosen by trial. A camera's automatic exposure and the eye's neural adaptation take about half a second; the
/// eye's photochemical adaptation takes minutes, which is too long to wait for.
pub(crate) const TIME_CONSTANT_S: f64 = 0.4;

/// Target, body of the camera, and kind of pose. A change is a cut, unless the pose before or after it is free, as in a flight.
type ViewIdentity = (NaifId, NaifId, Discriminant<CameraPose>);

/// The exposure of the last image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Adapted {
    stops: f64,
    metered_stops: f64,
    /// Real time of the request, seconds.
    at_s: f64,
}

#[derive(Default)]
pub(crate) struct ExposureAdaptation {
    identity: Option<ViewIdentity>,
    /// `None` before the first image.
    adapted: Option<Adapted>,
    /// Real time of the last request, seconds.
    requested_s: f64,
    /// The last requested image is still pending.
    is_pending: bool,
}

impl ExposureAdaptation {
    /// Resets the adaptation after a cut to another view, and while the exposure is manual.
    fn reset_on_cut(&mut self, view: &ViewState) {
        let identity = (view.target, view.eye.body(), discriminant(&view.eye));
        let is_free = |(_, camera_body, pose): &ViewIdentity| {
            *pose
                == discriminant(&CameraPose::Free {
                    body: *camera_body,
                    offset_km: Default::default(),
                    forward: Default::default(),
                    up: Default::default(),
                })
        };
        let cut = self.identity.replace(identity).is_some_and(|last| last != identity && !is_free(&last) && !is_free(&identity));
        if cut || view.exposure_stops.is_some() {
            self.adapted = None;
        }
    }

    /// The exposure to request for the next image of a view.
    pub(crate) fn next_exposure(&mut self, view: &ViewState, now_s: f64) -> ExposureRequest {
        self.reset_on_cut(view);
        (self.requested_s, self.is_pending) = (now_s, true);
        match (view.exposure_stops, self.adapted) {
            (Some(stops), _) => ExposureRequest::Stops(stops),
            (None, None) => ExposureRequest::Auto,
            (None, Some(from)) => {
                let progress = -(-(now_s - from.at_s).max(0.0) / TIME_CONSTANT_S).exp_m1();
                ExposureRequest::Transition { from_stops: from.stops, progress }
            }
        }
    }

    /// Records the exposure of a finished image. `requested`: the exposure that was requested for it.
    pub(crate) fn record(&mut self, exposure: &Exposure, requested: ExposureRequest) {
        self.is_pending = false;
        let adapted = Adapted { stops: exposure.stops, metered_stops: exposure.metered_stops, at_s: self.requested_s };
        self.adapted = (!matches!(requested, ExposureRequest::Stops(_))).then_some(adapted);
    }

    /// Whether another image of the same view would be closer to the metered exposure.
    pub(crate) fn is_adapting(&self) -> bool {
        !self.is_pending && self.adapted.is_some_and(|a| a.stops != a.metered_stops)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Reason;
    use crate::time::Instant;
    use glam::DVec3;

    fn view(target: NaifId) -> ViewState {
        ViewState::around(target, DVec3::X * 1e5, 6378.0, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.0))
    }

    /// The exposure of a scene with the given metering, for a request.
    fn exposure_of(requested: ExposureRequest, metered_stops: f64) -> Exposure {
        Exposure { stops: requested.stops_of(metered_stops), metered_stops, reason: Reason::default() }
    }

    /// From 0 to 10 stops: at each frame rate, one time constant covers 1 - 1/e of the difference, and the exposure ends at exactly 10.
    #[test]
    fn stops_approach_with_the_time_constant_at_any_frame_rate() {
        for rate_hz in [5.0, 20.0, 100.0] {
            let (mut adaptation, view) = (ExposureAdaptation::default(), view(NaifId::EARTH));
            let mut step = |now_s: f64, metered: f64| {
                let requested = adaptation.next_exposure(&view, now_s);
                let exposure = exposure_of(requested, metered);
                adaptation.record(&exposure, requested);
                (exposure.stops, adaptation.is_adapting())
            };
            assert_eq!(step(0.0, 0.0), (0.0, false), "the first image jumps");
            let (mut last, mut at_constant) = (0.0, f64::NAN);
            for k in 1..=(4.0 * rate_hz) as u32 {
                let now_s = f64::from(k) / rate_hz;
                let (stops, is_adapting) = step(now_s, 10.0);
                assert!((stops > last || last == 10.0) && stops <= 10.0, "{stops} after {last}");
                assert_eq!(is_adapting, stops != 10.0);
                if (now_s - TIME_CONSTANT_S).abs() < 1e-9 {
                    at_constant = stops;
                }
                last = stops;
            }
            assert!((at_constant - 10.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-6, "{at_constant} at {rate_hz} Hz");
            assert_eq!(last, 10.0, "the exposure ends at the metered value");
        }
    }

    /// A new target without a flight is a cut; a flight is not. Manual stops apply at once.
    #[test]
    fn exposure_jumps_after_a_cut_and_adapts_during_a_flight() {
        let free = ViewState {
            eye: CameraPose::Free { body: NaifId::MOON, offset_km: DVec3::X, forward: DVec3::X, up: DVec3::Z },
            ..view(NaifId::MOON)
        };
        let manual = ViewState { exposure_stops: Some(3.0), ..view(NaifId::EARTH) };
        let after = |next: &ViewState| {
            let (mut adaptation, first) = (ExposureAdaptation::default(), view(NaifId::EARTH));
            let requested = adaptation.next_exposure(&first, 0.0);
            adaptation.record(&exposure_of(requested, 0.0), requested);
            adaptation.next_exposure(next, 0.1)
        };
        assert_eq!(after(&view(NaifId::MOON)), ExposureRequest::Auto);
        assert!(matches!(after(&free), ExposureRequest::Transition { from_stops: 0.0, .. }));
        assert!(matches!(after(&view(NaifId::EARTH)), ExposureRequest::Transition { .. }));
        assert_eq!(after(&manual), ExposureRequest::Stops(3.0));
    }
}
