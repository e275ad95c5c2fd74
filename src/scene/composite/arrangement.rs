//! The arrangement of frames in a composed image, as plain values.

use crate::scene::camera::sphere::SphereImage;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::request::StereoLayout;
use crate::scene::request::view_request::ViewRequest;

/// One perspective frame of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRequest {
    pub request: ViewRequest,
    pub viewer: Viewer,
}

/// The arrangement of the frames.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrangement {
    Eyes(Eyes),
    Faces(Faces),
    /// A single frame, for a warp mesh.
    Single,
}

/// The frames of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct CompositeFrames {
    /// The frame whose light is metered for the common exposure.
    pub meter: FrameRequest,
    pub frames: Vec<FrameRequest>,
    pub arrangement: Arrangement,
}

/// Both eyes in one image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    pub layout: StereoLayout,
    pub separation_km: f64,
    /// For the left and the right eye: the first column of the eye's frame that the image shows.
    pub columns: [u32; 2],
}

/// The faces of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    pub image: SphereImage,
    /// The frame of each face: front, right, back, left, up, down.
    pub frame_of: [Option<usize>; 6],
    /// Width of a face, which spans 90 degrees, in pixels; its frame has an additional border on each side.
    pub face_px: u32,
    /// The rectangle of each frame that the image shows: x0, y0, x1, y1 in pixels, the last two exclusive.
    pub visible_rects: Vec<[u32; 4]>,
}
