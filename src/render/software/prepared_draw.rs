//! The input of tile shading: a draw whose triangles are set up (converted to edge functions and planes), the pixels that it may change, and the quads that
//! the triangles cover.

use super::fragment_setup::FragmentSetup;
use super::math::Real;
use super::raster::setup::RasterGeometry;
use super::stage::{LANES, LaneStage};
use super::texel_marks::TexelMarks;
use crate::render::plan::{Blend, Extent, ShadingRate};

/// Number of quads in a batch. The lanes of a batch are shaded at once.
pub(super) const QUADS_PER_BATCH: usize = LANES / 4;

/// Two by two pixels that a triangle covers partly or completely.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    /// Index of the quad in its tile.
    pub index: u16,
    /// Covered samples, four bits per pixel.
    pub coverage: u16,
    /// Index in [`RasterGeometry::source_triangles`].
    pub source_triangle: u32,
}

/// The pixels that a draw may change. Its methods take rectangles of pixels: left, top, right and bottom edge (the last two exclusive).
pub(crate) struct DrawExtent {
    /// Where the draw may change pixels: inside the body's outline and, if it draws the atmosphere beyond the limb, outside the ground's outline.
    pub outlines: Extent,
    /// Marks that narrow the extent: the draw discards each pixel whose four nearest texels in the image of marks are all marked.
    pub marks: Option<TexelMarks>,
}

impl DrawExtent {
    /// Whether the draw changes no pixel of a rectangle.
    pub(super) fn misses(&self, pixels: [u32; 4]) -> bool {
        self.outlines.misses(pixels) || self.marks.as_ref().is_some_and(|marks| marks.misses(pixels))
    }

    /// Whether the draw may change every pixel of a rectangle.
    pub(super) fn covers(&self, pixels: [u32; 4]) -> bool {
        self.outlines.covers(pixels) && self.marks.as_ref().is_none_or(|marks| marks.covers(pixels))
    }
}

/// A draw whose triangles are set up, ready to be shaded tile by tile.
pub(crate) struct PreparedDraw<'a, R: Real> {
    pub geometry: RasterGeometry,
    pub fragment: &'a dyn LaneStage<R>,
    pub fragment_setup: FragmentSetup,
    pub blend: Blend,
    pub shading_rate: ShadingRate,
    /// The pixels that the draw may change; `None` if they are not known.
    pub extent: Option<DrawExtent>,
    /// Number of instructions that one texture read counts as. `Some` only in the pixel view of shading cost, where instruction counts replace
    /// colour.
    pub instructions_per_read: Option<f64>,
}

impl<R: Real> PreparedDraw<'_, R> {
    /// Whether the draw adds light that may be interpolated between shaded points. Every covered pixel must get a value (no discard, no use of depth, no
    /// extent), and this value must be light and not a count of instructions.
    pub(super) fn is_interpolated(&self) -> bool {
        self.shading_rate == ShadingRate::Interpolated
            && self.blend == Blend::Add
            && self.fragment_setup.draws_every_covered_pixel()
            && self.extent.is_none()
            && self.instructions_per_read.is_none()
    }

    /// Whether a fragment whose colour is zero in all four components changes neither colour nor depth, so that it can be dropped.
    pub(super) fn may_drop_zero_fragments(&self) -> bool {
        let setup = &self.fragment_setup;
        let writes_late_depth = setup.depth.write && !setup.allows_early_depth_test;
        self.blend != Blend::Replace && self.instructions_per_read.is_none() && !writes_late_depth
    }
}
