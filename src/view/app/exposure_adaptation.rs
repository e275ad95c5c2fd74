//! Automatic exposure of the window: it approaches the metered value smoothly.
//!
//! In: metered exposures of drawn pictures, real time, the view. Out: the exposure of the next request. Always: the difference in stops decays by
//! exp(-t / `TIME_CONSTANT_S`) in real time, at any frame rate; it jumps without a predecessor: for the first picture, for
//! another target or standpoint that no flight leads to, and after manual exposure. It reads no clock, and does not apply to saved pictures: a link, a
//! file and a sequence of frames are exposed for their instant alone.

use crate::catalog::NaifId;
use crate::scene::Exposure;
use crate::scene::request::ExposureRequest;
use crate::view::app::view_state::{CameraPose, ViewState};
use std::mem::{Discriminant, discriminant};

/// A camera's automatic exposure takes half a second, as does the eye's neural adaptation; its photochemical adaptation takes minutes, too long to wait for.
/// Chosen by eye.
pub(crate) const TIME_CONSTANT_S: f64 = 0.4;

/// The properties that two views must share for the exposure to adapt smoothly.
type Standpoint = (NaifId, NaifId, Discriminant<CameraPose>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Adapted {
    stops: f64,
    metered_stops: f64,
    at_s: f64,
}

#[derive(Default)]
pub(crate) struct ExposureAdaptation {
    standpoint: Option<Standpoint>,
    /// `None` before the first picture.
    adapted: Option<Adapted>,
    /// When a picture was last requested, and whether it is still pending.
    asked_s: f64,
    awaited: bool,
}

impl ExposureAdaptation {
    /// Resets the adaptation after a cut to another view.
    fn reset_on_cut(&mut self, view: &ViewState) {
        let standpoint = (view.target, view.eye.body(), discriminant(&view.eye));
        let flies = |s: &Standpoint| {
            s.2 == discriminant(&CameraPose::Free {
                body: s.1,
                offset_km: Default::default(),
                forward: Default::default(),
                up: Default::default(),
            })
        };
        let cut = self.standpoint.replace(standpoint).is_some_and(|last| last != standpoint && !flies(&last) && !flies(&standpoint));
        if cut || view.exposure_stops.is_some() {
            self.adapted = None;
        }
    }

    /// The exposure to request for the next picture of a view.
    pub(crate) fn ask(&mut self, view: &ViewState, now_s: f64) -> ExposureRequest {
        self.reset_on_cut(view);
        (self.asked_s, self.awaited) = (now_s, true);
        match (view.exposure_stops, self.adapted) {
            (Some(stops), _) => ExposureRequest::Stops(stops),
            (None, None) => ExposureRequest::Auto,
            (None, Some(from)) => {
                let part = -(-(now_s - from.at_s).max(0.0) / TIME_CONSTANT_S).exp_m1();
                ExposureRequest::Gliding { from_stops: from.stops, part }
            }
        }
    }

    /// Takes note of a finished picture.
    pub(crate) fn note_drawn(&mut self, exposure: &Exposure, asked: ExposureRequest) {
        self.awaited = false;
        let adapted = Adapted { stops: exposure.stops, metered_stops: exposure.metered_stops, at_s: self.asked_s };
        self.adapted = (!matches!(asked, ExposureRequest::Stops(_))).then_some(adapted);
    }

    /// Whether another picture of the same view would be closer to the metered exposure.
    pub(crate) fn is_adapting(&self) -> bool {
        !self.awaited && self.adapted.is_some_and(|a| a.stops != a.metered_stops)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Instant;
    use glam::DVec3;

    fn view(target: NaifId) -> ViewState {
        ViewState::around(target, DVec3::X * 1e5, 6378.0, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.0))
    }

    /// The exposure that a scene with this metering gives a request.
    fn exposed(asked: ExposureRequest, metered_stops: f64) -> Exposure {
        Exposure { stops: asked.stops_of(metered_stops), metered_stops, reason: String::new() }
    }

    /// From 0 to 10 stops at several frame rates: after one time constant all have gone 1 - 1/e of the way, and all end at 10.
    #[test]
    fn stops_glide_with_the_time_constant_at_any_rate() {
        for rate_hz in [5.0, 20.0, 100.0] {
            let (mut eye, view) = (ExposureAdaptation::default(), view(NaifId::EARTH));
            let mut step = |now_s: f64, metered: f64| {
                let asked = eye.ask(&view, now_s);
                let exposure = exposed(asked, metered);
                eye.note_drawn(&exposure, asked);
                (exposure.stops, eye.is_adapting())
            };
            assert_eq!(step(0.0, 0.0), (0.0, false), "the first picture jumps");
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
            assert_eq!(last, 10.0, "at rest it is the metered one");
        }
    }

    /// A new target is a cut, a flight to it is none; manual stops apply at once.
    #[test]
    fn a_cut_jumps_and_a_flight_glides() {
        let free = ViewState {
            eye: CameraPose::Free { body: NaifId::MOON, offset_km: DVec3::X, forward: DVec3::X, up: DVec3::Z },
            ..view(NaifId::MOON)
        };
        let by_hand = ViewState { exposure_stops: Some(3.0), ..view(NaifId::EARTH) };
        let after = |next: &ViewState| {
            let (mut eye, first) = (ExposureAdaptation::default(), view(NaifId::EARTH));
            let asked = eye.ask(&first, 0.0);
            eye.note_drawn(&exposed(asked, 0.0), asked);
            eye.ask(next, 0.1)
        };
        assert_eq!(after(&view(NaifId::MOON)), ExposureRequest::Auto);
        assert!(matches!(after(&free), ExposureRequest::Gliding { from_stops: 0.0, .. }));
        assert!(matches!(after(&view(NaifId::EARTH)), ExposureRequest::Gliding { .. }));
        assert_eq!(after(&by_hand), ExposureRequest::Stops(3.0));
    }
}
