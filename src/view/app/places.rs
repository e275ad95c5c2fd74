//! Positions and orientations of bodies, as far as moving the camera needs them.
//!
//! In: bodies and instants. Out: vectors and rotations, ICRF; nothing where no source covers the time. Tests put bodies elsewhere.

use crate::catalog::NaifId;
use crate::session::Session;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat3, DVec3};

/// Where bodies are and how they are oriented.
pub trait BodyPositions {
    /// From the centre of `from` to that of `to`, ICRF kilometres.
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3>;
    /// The offset from `body` of a camera that is `offset_km` from `carrier`. A camera is placed from where a body's light comes from (`follows_light`), or, on its
    /// ground or at its centre, from where the body is.
    fn offset_from_km(&self, body: NaifId, carrier: NaifId, offset_km: DVec3, follows_light: bool, time: Instant) -> Option<DVec3>;
    /// The rotation from ICRF to body-fixed axes: its rows are the body's axes.
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3>;
}

/// The places of a session's ephemeris.
pub struct SessionPlaces<'a>(pub &'a Session);

impl BodyPositions for SessionPlaces<'_> {
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3> {
        self.0.ephemeris().state(to, from, time, None).ok().map(|a| a.state.pos_km)
    }
    fn offset_from_km(&self, body: NaifId, carrier: NaifId, offset_km: DVec3, follows_light: bool, time: Instant) -> Option<DVec3> {
        if body == carrier && follows_light {
            return Some(offset_km);
        }
        let ephemeris = self.0.ephemeris();
        let light_s = if follows_light { offset_km.length() / SPEED_OF_LIGHT_KM_S } else { 0.0 };
        let carrier = ephemeris.state(carrier, NaifId::SOLAR_SYSTEM_BARYCENTER, time.plus_seconds(-light_s), None).ok()?;
        let camera_km = carrier.state.pos_km + offset_km;
        Some(camera_km - ephemeris.light_time_position(body, camera_km, time).ok()?.0)
    }
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3> {
        self.0.ephemeris().body_from_icrf(body, time).ok()
    }
}
