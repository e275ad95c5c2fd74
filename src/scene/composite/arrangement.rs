//! The frames of a composed image and their arrangement, as plain values. [`CompositeFrames::of`] creates them. A scene is built for each frame;
//! `render::plan::composite` combines the images as the arrangement says.

use crate::scene::camera::sphere::SphereImage;
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::request::StereoLayout;
use crate::scene::request::view_request::ViewRequest;

/// One perspective frame of a composed image.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRequest {
    pub request: ViewRequest,
    pub viewer: Viewer,
}

/// How the frames are put together.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrangement {
    Eyes(Eyes),
    Faces(Faces),
    /// A single frame, for a warp mesh.
    Single,
}

/// The frames of a composed image.
#[derive(Clone, Debug, PartialEq)]
pub struct CompositeFrames {
    /// The frame whose light is metered for the common exposure.
    pub meter: FrameRequest,
    pub frames: Vec<FrameRequest>,
    pub arrangement: Arrangement,
}

/// A stereo pair: the frames of the left and of the right eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    pub layout: StereoLayout,
    /// Distance between the two cameras.
    pub separation_km: f64,
    /// For the left and the right eye: the first column of the eye's frame that the image shows.
    pub first_columns: [u32; 2],
}

/// The faces of a dome image or a whole-sphere image.
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    pub image: SphereImage,
    /// Index of each face's frame; `None` for a face that the image does not show. Order: front, right, back, left, up, down.
    pub frame_of_face: [Option<usize>; 6],
    /// Width of a face, which spans 90 degrees, in pixels; its frame has an additional border on each side.
    pub face_px: u32,
    /// For each frame, the rectangle that the image shows: x0, y0, x1, y1 in pixels of the frame, the last two exclusive.
    pub visible_rects: Vec<[u32; 4]>,
}
