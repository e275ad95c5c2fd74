//! The running clock stops at the ends of the ephemeris.
//!
//! In: the time before and after a frame's advance. Out: a pause at the last time for which the view has an image, and one reply that says why. Always: a clock
//! that is outside the ephemeris runs on only towards it; time that the user sets or steps is not limited, and the window says why such a view has no image.

use super::Interface;
use crate::view::app::placed_times::{check, last_time_with_image};
use crate::view::error_texts::error_text;
use crate::view::language::text;
use crate::view::worker::render_worker::RenderWorker;

/// Pauses time if it has run past the last time for which the view has an image. `before_tdb_s`: the displayed time before it advanced in this frame.
pub(super) fn stop(interface: &mut Interface, before_tdb_s: f64, worker: &dyn RenderWorker) {
    let viewer = &mut interface.viewer;
    let (session, after_tdb_s) = (worker.session(), viewer.view.tdb_s);
    if after_tdb_s == before_tdb_s {
        return;
    }
    let Err(why) = check(&viewer.view, after_tdb_s, session) else { return };
    if check(&viewer.view, before_tdb_s, session).is_ok() {
        let (end_tdb_s, why) = last_time_with_image(&viewer.view, before_tdb_s, after_tdb_s, why, session);
        viewer.view.tdb_s = end_tdb_s;
        viewer.time_rate.set_paused(true);
        interface.show_reply(text!("time-stopped", why = error_text(&why)));
    } else if after_tdb_s.abs() > before_tdb_s.abs() {
        // Every shipped source has J2000, when `tdb_s` is 0. The reason why there is no image is shown already.
        viewer.view.tdb_s = before_tdb_s;
        viewer.time_rate.set_paused(true);
    }
}
