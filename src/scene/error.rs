//! Errors of building a scene.

use crate::catalog::UnknownName;
use crate::ephemeris::EphemerisError;

/// A value of a request that has a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestValue {
    /// Width and height of the image.
    Size,
    /// The field of view.
    FieldOfView,
    /// The distance from the target.
    Distance,
    /// The latitude of a camera on the ground.
    Latitude,
    /// The longitude of a camera on the ground.
    Longitude,
    /// The height of a camera on the ground.
    Height,
    /// The offset of the camera from a body's centre.
    CameraOffset,
    /// The exposure.
    Exposure,
    /// The stops by which stars are brightened.
    StarsBoost,
    /// The tilt of a dome.
    DomeTilt,
    /// The distance between the eyes.
    EyeSeparation,
    /// A length of the telescope, its eyepiece or its sensor.
    TelescopeLength,
    /// The apparent field of a telescope's eyepiece.
    ApparentField,
    /// The time.
    Time,
}

impl std::fmt::Display for RequestValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Size => "size",
            Self::FieldOfView => "field of view",
            Self::Distance => "distance",
            Self::Latitude => "latitude",
            Self::Longitude => "longitude",
            Self::Height => "height",
            Self::CameraOffset => "camera offset",
            Self::Exposure => "exposure",
            Self::StarsBoost => "stars boost",
            Self::DomeTilt => "dome tilt",
            Self::EyeSeparation => "eye separation",
            Self::TelescopeLength => "telescope length",
            Self::ApparentField => "apparent field of the eyepiece",
            Self::Time => "time",
        })
    }
}

/// A value outside its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} {given}: must be {allowed}")]
pub struct OutOfRange {
    /// What the value describes.
    pub what: RequestValue,
    /// The value, with its unit if `what` does not imply it.
    pub given: String,
    /// The range, with its unit, as in `1 to 360 degrees`.
    pub allowed: String,
}

/// The reason why no scene can be built for a request; each message is one line.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A value of the request that is outside its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// An effect for a body that the catalog does not have.
    #[error("effects: {0}")]
    EffectBody(UnknownName),
    /// A value of a camera file that cannot be used.
    #[error("camera file, {field}: {why}")]
    CameraField {
        /// The field, as in `position.body`.
        field: &'static str,
        /// What is wrong with its value.
        why: String,
    },
    /// Any other invalid value of the request; the message names it.
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
