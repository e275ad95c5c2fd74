//! Positions and orientations of bodies, used to place and move the camera.
//!
//! In: bodies and instants. Out: ICRF vectors, and rotations from ICRF; `None` if the ephemeris does not cover the time. Tests implement
//! [`BodyPositions`] with invented bodies.

use crate::catalog::NaifId;
use crate::ephemeris::BEST_SOURCE;
use crate::session::Session;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat3, DVec3};

/// Positions and orientations of bodies.
pub trait BodyPositions {
    /// The vector from the centre of `from` to the centre of `to` at one instant, without light time and aberration; ICRF kilometres.
    fn geometric_vector_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3>;
    /// Converts `offset_km`, the camera's offset from `camera_body`, to its offset from `body`; both in ICRF kilometres. The camera is free: it is placed by
    /// an offset from a body's centre, not on its ground. Each offset is measured from the body's light-time position (without aberration): its centre when
    /// it emitted the light that reaches the camera at `time`.
    ///
    /// The offset of a camera on the ground is measured from the body's geometric position, its centre at `time`. When such a camera becomes free, this offset
    /// may be passed as `offset_km`, too. The camera then keeps its offset, not its barycentric position: while light travels from the Earth's centre to its
    /// ground, the Earth moves 0.6 km, so a camera that kept its position could be below the ground.
    fn free_camera_offset_km(&self, body: NaifId, camera_body: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3>;
    /// The rotation from ICRF to body-fixed axes. Its rows are the body's axes in ICRF.
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3>;
}

/// Positions from a session's ephemeris.
pub struct SessionPositions<'a>(pub &'a Session);

impl BodyPositions for SessionPositions<'_> {
    fn geometric_vector_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3> {
        self.0.ephemeris().state(to, from, time, BEST_SOURCE).ok().map(|relative| relative.state.pos_km)
    }
    fn free_camera_offset_km(&self, body: NaifId, camera_body: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3> {
        if body == camera_body {
            return Some(offset_km);
        }
        let ephemeris = self.0.ephemeris();
        let emission_time = time.plus_seconds(-offset_km.length() / SPEED_OF_LIGHT_KM_S);
        let camera_body_state = ephemeris.state(camera_body, NaifId::SOLAR_SYSTEM_BARYCENTER, emission_time, BEST_SOURCE).ok()?;
        // Relative to the solar system's barycentre, as is `body_km`.
        let camera_km = camera_body_state.state.pos_km + offset_km;
        let (body_km, _) = ephemeris.light_time_position(body, camera_km, time).ok()?;
        Some(camera_km - body_km)
    }
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3> {
        self.0.ephemeris().body_from_icrf(body, time).ok()
    }
}
