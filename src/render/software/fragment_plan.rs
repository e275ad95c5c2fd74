//! What a fragment program takes and gives, worked out once for a draw of a pass.
//!
//! In: the program's lane inputs and outputs, the draw's depth state. Out: [`FragmentPlan`]. Not here: triangles, tiles.

use super::program::{LaneInput, LaneOutput};
use crate::render::plan::DepthState;

/// What a fragment program reads, by lane input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    PixelX,
    PixelY,
    Depth,
    InverseW,
    Varying { index: usize, flat: bool },
    FrontFacing,
    Zero,
}

/// The fragment stage of one draw, prepared once per pass.
#[derive(Clone, Debug)]
pub struct FragmentPlan {
    pub(super) feeds: Vec<Feed>,
    /// Where the program's outputs have red, green, blue and alpha.
    pub(super) colour: [Option<usize>; 4],
    pub(super) depth_output: Option<usize>,
    /// Depth is tested before shading.
    pub(super) early: bool,
    pub(super) depth: DepthState,
}

impl FragmentPlan {
    /// `has_depth`: the pass has a depth target.
    pub fn new(inputs: &[LaneInput], outputs: &[LaneOutput], uses_discard: bool, depth: DepthState, has_depth: bool) -> Self {
        let mut varyings = 0;
        let feeds = inputs
            .iter()
            .map(|input| match *input {
                LaneInput::FragCoord { component: 0 } => Feed::PixelX,
                LaneInput::FragCoord { component: 1 } => Feed::PixelY,
                LaneInput::FragCoord { component: 2 } => Feed::Depth,
                LaneInput::FragCoord { .. } => Feed::InverseW,
                LaneInput::Location { flat, .. } => {
                    varyings += 1;
                    Feed::Varying { index: varyings - 1, flat }
                }
                LaneInput::FrontFacing => Feed::FrontFacing,
                // One shading per pixel: the sample index is that of the first.
                LaneInput::SampleIndex | LaneInput::VertexIndex | LaneInput::InstanceIndex => Feed::Zero,
            })
            .collect();
        let colour = [0, 1, 2, 3]
            .map(|c| outputs.iter().position(|o| matches!(*o, LaneOutput::Location { index: 0, component, .. } if component == c)));
        let depth_output = outputs.iter().position(|o| matches!(o, LaneOutput::FragDepth));
        let depth = DepthState { test: depth.test && has_depth, write: depth.write && has_depth };
        Self { feeds, colour, depth_output, early: !uses_discard && depth_output.is_none(), depth }
    }

    /// Every covered pixel is drawn: no lane dies, and no depth is asked for.
    pub fn tests_nothing(&self) -> bool {
        self.early && !self.uses_depth()
    }

    pub fn uses_depth(&self) -> bool {
        self.depth.test || self.depth.write
    }
}
