//! The times for which a view has an image: those for which the ephemeris has the camera's body, the target and the Sun.
//!
//! In: a view, a time, a session. Out: the error that the ephemeris gives, or the last such time of a span. Always: the light that arrives at a time must have
//! left at a time that the ephemeris has, too; of two ends of a span, one has an image. Not here: other bodies, without which a view is drawn.

use crate::catalog::NaifId;
use crate::ephemeris::{BEST_SOURCE, EphemerisError};
use crate::session::Session;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use crate::view::app::view_state::{CameraPose, ViewState};

/// The end of a span is found to this accuracy, seconds.
const END_ACCURACY_S: f64 = 1e-3;

/// Distance of the camera from the centre of the body relative to which it is placed. A camera on the ground, less than a second of light from the centre, and
/// a camera beside an unknown body count as being at the centre.
fn camera_distance_km(view: &ViewState, session: &Session) -> f64 {
    match view.camera_pose {
        CameraPose::Orbit { body, distance_radii, .. } => session.catalog().body(body).map_or(0.0, |body| distance_radii * body.radii_km.x),
        CameraPose::Free { offset_km, .. } => offset_km.length(),
        CameraPose::Ground { .. } | CameraPose::Centre { .. } => 0.0,
    }
}

/// The error if the view, at this time (TDB seconds past J2000), has no image because the ephemeris lacks a body.
pub(crate) fn check(view: &ViewState, tdb_s: f64, session: &Session) -> Result<(), EphemerisError> {
    let ephemeris = session.ephemeris();
    let camera_body = view.camera_pose.body();
    // The camera is at most this much light time farther from the target than the centre of its body. The second is for a camera on the ground.
    let margin_s = camera_distance_km(view, session) / SPEED_OF_LIGHT_KM_S + 1.0;
    for time in [tdb_s, tdb_s - margin_s].map(Instant::from_tdb_seconds_past_j2000) {
        if matches!(view.camera_pose, CameraPose::Orbit { .. } | CameraPose::Ground { .. }) {
            ephemeris.body_from_icrf(camera_body, time)?;
        }
        let camera_km = ephemeris.state(camera_body, NaifId::SOLAR_SYSTEM_BARYCENTER, time, BEST_SOURCE)?.state.pos_km;
        let (target_km, emitted_at) = ephemeris.light_time_position(view.target, camera_km, time)?;
        ephemeris.body_from_icrf(view.target, emitted_at)?;
        ephemeris.light_time_position(NaifId::SUN, target_km, emitted_at)?;
    }
    Ok(())
}

/// The last time before `without_tdb_s`, seen from `with_tdb_s`, at which the view has an image, and why it has none after that. At `with_tdb_s` it has one,
/// at `without_tdb_s` it has none, for the reason `why`. Either of the two may be the earlier one.
pub(crate) fn last_time_with_image(
    view: &ViewState,
    mut with_tdb_s: f64,
    mut without_tdb_s: f64,
    mut why: EphemerisError,
    session: &Session,
) -> (f64, EphemerisError) {
    while (without_tdb_s - with_tdb_s).abs() > END_ACCURACY_S {
        let middle_tdb_s = 0.5 * (with_tdb_s + without_tdb_s);
        // Far from J2000 neighbouring numbers are farther apart than the accuracy.
        if middle_tdb_s == with_tdb_s || middle_tdb_s == without_tdb_s {
            break;
        }
        match check(view, middle_tdb_s, session) {
            Ok(()) => with_tdb_s = middle_tdb_s,
            Err(e) => (without_tdb_s, why) = (middle_tdb_s, e),
        }
    }
    (with_tdb_s, why)
}
