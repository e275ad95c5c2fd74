//! Why a view cannot be made.

use crate::catalog::UnknownName;
use crate::ephemeris::EphemerisError;

/// Why a request gives no scene: one line each.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A value that no view can have, named.
    #[error("{0}")]
    Request(String),
    /// A name that the catalog does not have.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// A barycentre where a body is needed.
    #[error("`{0}` is not a body of the catalog (a barycentre has no surface): name a body")]
    NotABody(String),
    /// The camera would see a body from within.
    #[error("the camera is inside {0}: move it out, or leave the body's name out of the position")]
    Inside(String),
    /// No position at that time.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
}
