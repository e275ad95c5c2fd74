//! How frames make a picture: plain values.

use crate::scene::camera::sphere::SpherePicture;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::request::StereoLayout;
use crate::scene::request::view_request::ViewRequest;

/// One perspective frame of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRequest {
    pub request: ViewRequest,
    pub viewer: Viewer,
}

/// How the frames make the picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrangement {
    Eyes(Eyes),
    Faces(Faces),
    /// A single frame, for a warp mesh.
    Single,
}

/// The frames of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// What the exposure is made for.
    pub meter: FrameRequest,
    pub frames: Vec<FrameRequest>,
    pub arrangement: Arrangement,
}

/// Both eyes in one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    pub layout: StereoLayout,
    pub separation_km: f64,
    /// Column of each eye's frame, left and right, at which its picture begins.
    pub columns: [u32; 2],
}

/// The faces of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    pub picture: SpherePicture,
    /// Which frame shows the face: front, right, back, left, up, down.
    pub frame_of: [Option<usize>; 6],
    /// Pixels of a right angle; a frame has a border more on each side.
    pub face_px: u32,
    /// Pixels of each frame that the picture shows: x0, y0, x1, y1 (exclusive).
    pub used: Vec<[u32; 4]>,
}
