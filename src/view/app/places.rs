//! Positions and orientations of bodies for moving the camera.
//!
//! In: bodies and instants. Out: vectors and rotations, ICRF; `None` where no source covers the time. A trait, so that tests can place bodies freely.

use crate::catalog::NaifId;
use crate::session::Session;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat3, DVec3};

/// Positions and orientations of bodies.
pub trait BodyPositions {
    /// From the centre of `from` to that of `to`, ICRF kilometres.
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3>;
    /// The offset from `body` of a free camera that sees `carrier` at `-offset_km`. A free camera sees each body where its light left it; on the ground it sees its
    /// own body at its true place. This keeps what is near in place when the camera leaves the ground: the body moves 0.3 to 0.6 km in the light
    /// time, and a camera kept at its absolute position would start below the ground.
    fn offset_from_km(&self, body: NaifId, carrier: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3>;
    /// The rotation from ICRF to body-fixed axes: its rows are the body's axes.
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3>;
}

/// Positions of a session's ephemeris.
pub struct SessionPositions<'a>(pub &'a Session);

impl BodyPositions for SessionPositions<'_> {
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3> {
        self.0.ephemeris().state(to, from, time, None).ok().map(|a| a.state.pos_km)
    }
    fn offset_from_km(&self, body: NaifId, carrier: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3> {
        if body == carrier {
            return Some(offset_km);
        }
        let ephemeris = self.0.ephemeris();
        let seen_at = time.plus_seconds(-offset_km.length() / SPEED_OF_LIGHT_KM_S);
        let carrier = ephemeris.state(carrier, NaifId::SOLAR_SYSTEM_BARYCENTER, seen_at, None).ok()?;
        let camera_km = carrier.state.pos_km + offset_km;
        Some(camera_km - ephemeris.light_time_position(body, camera_km, time).ok()?.0)
    }
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3> {
        self.0.ephemeris().body_from_icrf(body, time).ok()
    }
}
