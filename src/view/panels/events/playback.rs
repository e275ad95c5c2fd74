//! The running playback of an event: it sets the rate of time, slower around a short central phase, and ends at the end of the event.
//!
//! In: an `EventPlayback`, the displayed time. Out: the displayed time and its rate. Always: a rate that the user chooses during the playback stays; a slow
//! frame does not skip the central phase. Not here: the span and the rates (`event_view`).

use super::{EventPlayback, Interface};
use crate::view::app::time_rate::MAX_REAL_STEP_S;

/// How far a slow frame may overshoot the end of a played event, real seconds. If the displayed time is farther outside the event, the user has set
/// another time.
const TOLERANCE_S: f64 = 10.0;

/// A running playback.
pub(super) struct RunningPlayback {
    pub playback: EventPlayback,
    /// The rate that the playback has set last, scene seconds per real second. While time has another one, the user has chosen it.
    set_rate: f64,
    /// The displayed time of the frame before, TDB seconds past J2000.
    last_tdb_s: f64,
}

impl RunningPlayback {
    /// A playback from its start, for which time already runs at the rate of the start.
    pub(super) fn from_start(playback: EventPlayback) -> Self {
        let start_tdb_s = playback.start_tdb_s;
        Self { playback, set_rate: playback.rate_at(start_tdb_s), last_tdb_s: start_tdb_s }
    }
}

/// Sets the rate of time for the running playback. Pauses time at the end of the event, unless the user has set another time meanwhile.
pub(super) fn update(interface: &mut Interface) {
    let Some(running) = &mut interface.events.playback else { return };
    let playback = running.playback;
    let (view, time_rate) = (&mut interface.viewer.view, &mut interface.viewer.time_rate);
    let last_tdb_s = std::mem::replace(&mut running.last_tdb_s, view.tdb_s);
    let rate = time_rate.rate();
    let after_end_s = view.tdb_s - playback.end_tdb_s;
    if after_end_s >= 0.0 && after_end_s <= TOLERANCE_S * playback.rate && rate > 0.0 {
        view.tdb_s = playback.end_tdb_s;
        time_rate.set_paused(true);
        interface.events.playback = None;
        return;
    }
    if after_end_s > 0.0 || view.tdb_s < playback.start_tdb_s - TOLERANCE_S * playback.rate {
        interface.events.playback = None;
        return;
    }
    if time_rate.resumed_rate() != running.set_rate {
        return;
    }
    // At the fast rate a single frame may pass over the whole slow part.
    if let Some(slow) = playback.slow_part
        && last_tdb_s < slow.start_tdb_s
        && view.tdb_s > slow.start_tdb_s
        && view.tdb_s - last_tdb_s <= MAX_REAL_STEP_S * rate
    {
        view.tdb_s = slow.start_tdb_s;
        running.last_tdb_s = view.tdb_s;
    }
    time_rate.set_speed(playback.rate_at(view.tdb_s));
    running.set_rate = time_rate.resumed_rate();
}
