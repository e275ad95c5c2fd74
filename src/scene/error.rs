//! Why a view cannot be made.

use crate::catalog::UnknownName;
use crate::ephemeris::EphemerisError;

/// Why a request gives no scene: one line each.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{0}")]
    Request(String),
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    #[error("`{0}` is not a body of the catalog (a barycentre has no surface): name a body")]
    NotABody(String),
    #[error("the camera is inside {0}: move it out, or leave the body's name out of the position")]
    Inside(String),
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
}
