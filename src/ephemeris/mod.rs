//! Where everything is, and how it is turned: f64, kilometres, TDB, ICRF.

use crate::catalog::{Catalog, NaifId};
use crate::time::Instant;
use glam::{DMat3, DVec3};

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    Mean,
    Series,
    Kernel,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub pos_km: DVec3,
    pub vel_km_s: DVec3,
}

/// A geometric state with the source that gave it and that source's error bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    pub state: State,
    pub source: Source,
    pub error_km: f64,
}

#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct EphemerisError(pub String);

/// All theories behind one interface. Immutable after construction; shared by threads.
pub struct Ephemeris {}

impl Ephemeris {
    /// The shipped kernel, series and theories for the bodies of `catalog`.
    pub fn embedded(_catalog: &Catalog) -> Result<Self, EphemerisError> {
        unimplemented!()
    }
    /// Puts the user's SPK (bytes of the file) before the shipped kernel.
    pub fn with_kernel(self, _name: &str, _bytes: Vec<u8>) -> Result<Self, EphemerisError> {
        unimplemented!()
    }
    /// Geometric state of `body` relative to `center`, ICRF. `source: None` takes the best that covers `t`.
    pub fn state(&self, _body: NaifId, _center: NaifId, _t: Instant, _source: Option<Source>) -> Result<Answer, EphemerisError> {
        unimplemented!()
    }
    /// Rotation `body_from_icrf` (rows are the body's axes) at `t`.
    pub fn body_from_icrf(&self, _body: NaifId, _t: Instant) -> Result<DMat3, EphemerisError> {
        unimplemented!()
    }
    /// Where `body` is seen from `observer_pos_km` (barycentric ICRF) at `t`: barycentric position at the time the light left, and
    /// that time.
    pub fn light_time_position(&self, _body: NaifId, _observer_pos_km: DVec3, _t: Instant) -> Result<(DVec3, Instant), EphemerisError> {
        unimplemented!()
    }
}
