//! Errors of building a scene.

use crate::catalog::UnknownName;
use crate::ephemeris::EphemerisError;

/// The reason why no scene can be built for a request; each message is one line.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// An invalid value of the request; the message names it.
    #[error("{0}")]
    Request(String),
    /// A name that the catalog does not have.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// A barycentre where a body is needed; the text is its NAIF code.
    #[error("`{0}` is not a body of the catalog (a barycentre has no surface): name a body")]
    NotABody(String),
    /// The camera is inside the body of this name, and was not placed at its centre. A body is not drawn from its own centre, so a camera there is allowed.
    #[error("the camera is inside {0}: move it above the surface, or exactly to the centre, from where {0} is not drawn")]
    Inside(String),
    /// The ephemeris has no position at that time.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
}
