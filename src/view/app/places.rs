//! Positions and orientations of bodies, as far as moving the camera needs them.
//!
//! In: bodies and instants. Out: vectors and rotations, ICRF; nothing where no source covers the time. Tests put bodies elsewhere.

use crate::catalog::NaifId;
use crate::session::Session;
use crate::time::Instant;
use glam::{DMat3, DVec3};

/// Where bodies are and how they are oriented.
pub trait BodyPositions {
    /// From the centre of `from` to that of `to`, ICRF kilometres.
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3>;
    /// The rotation from ICRF to body-fixed axes: its rows are the body's axes.
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3>;
}

/// The places of a session's ephemeris.
pub struct SessionPlaces<'a>(pub &'a Session);

impl BodyPositions for SessionPlaces<'_> {
    fn between_km(&self, from: NaifId, to: NaifId, time: Instant) -> Option<DVec3> {
        self.0.ephemeris().state(to, from, time, None).ok().map(|a| a.state.pos_km)
    }
    fn body_from_icrf(&self, body: NaifId, time: Instant) -> Option<DMat3> {
        self.0.ephemeris().body_from_icrf(body, time).ok()
    }
}
