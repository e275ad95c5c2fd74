//! The request for a view: camera position and direction, field of view, exposure, layers and effects.
//!
//! In: values and texts from the command line or the window, or a camera file (a JSON file that describes a camera). Out: a [`ViewRequest`], which
//! names bodies by NAIF code. This module does not use the ephemeris; [`CameraFile::resolve`] looks up names in the catalog.

pub mod camera_file;
pub mod composition;
pub mod effects;
pub(crate) mod layers;
pub mod telescope;
pub mod view_request;
pub mod warp_mesh;

pub use super::purpose::Purpose;
pub use camera_file::{CAMERA_FILE_HELP, CameraFile, UP_NAMES, up_by_name};
pub use composition::{Composition, Projection, Stereo, StereoLayout};
pub use layers::Layers;
pub use telescope::Telescope;
pub use view_request::{
    Axes, EYE_HEIGHT_KM, ExposureRequest, FITTED_DISC_FRACTION, FOV_AT_FITTED_DISTANCE_DEG, FOV_AT_GIVEN_POSITION_DEG,
    INVISIBLE_EXPOSURE_CHANGE_STOPS, Look, Position, Quality, ToneMap, Up, ViewRequest,
};
pub use warp_mesh::WarpMesh;
