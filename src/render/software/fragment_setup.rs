//! The inputs and outputs of a fragment program, resolved once for each draw of a pass.
//!
//! In: the program, and the draw's depth state. Out: `FragmentSetup`, which tells where each input comes from and which outputs are colour and depth. Not
//! here: triangles and tiles.

use super::math::Real;
use super::program::{LaneInput, LaneOutput};
use super::stage::LaneStage;
use crate::render::plan::DepthState;

/// The source of a lane input's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FragmentInputSource {
    /// x of the pixel's centre, in pixels of the target.
    PixelX,
    /// y of the pixel's centre, downwards.
    PixelY,
    Depth,
    /// 1/w of the clip-space position.
    InverseW,
    /// The interpolated varying with this index; each component counts as one.
    Interpolated(usize),
    /// The flat varying with this index; each component counts as one.
    Flat(usize),
    FrontFacing,
    /// The input is always 0 in a fragment stage.
    Zero,
    /// The program does not read this input, so it is not written.
    Unread,
}

/// Where the inputs of a draw's fragment program come from, which of its outputs are used, and how depth is tested.
#[derive(Clone, Debug)]
pub(crate) struct FragmentSetup {
    pub(super) input_sources: Vec<FragmentInputSource>,
    /// Indices of the program's outputs for red, green, blue and alpha.
    pub(super) colour_outputs: [Option<usize>; 4],
    pub(super) depth_output: Option<usize>,
    /// Whether depth may be tested before shading, because the program neither discards nor writes depth.
    pub(super) allows_early_depth_test: bool,
    pub(super) depth: DepthState,
}

impl FragmentSetup {
    /// `depth`: of the draw. `has_depth`: whether the pass has a depth target.
    pub(crate) fn new<R: Real>(fragment: &dyn LaneStage<R>, depth: DepthState, has_depth: bool) -> Self {
        let outputs = fragment.outputs();
        let (mut interpolated, mut flat) = (0, 0);
        let mut source_of = |input: &LaneInput| match *input {
            LaneInput::FragCoord { component: 0 } => FragmentInputSource::PixelX,
            LaneInput::FragCoord { component: 1 } => FragmentInputSource::PixelY,
            LaneInput::FragCoord { component: 2 } => FragmentInputSource::Depth,
            LaneInput::FragCoord { .. } => FragmentInputSource::InverseW,
            LaneInput::Location { flat: true, .. } => {
                flat += 1;
                FragmentInputSource::Flat(flat - 1)
            }
            LaneInput::Location { .. } => {
                interpolated += 1;
                FragmentInputSource::Interpolated(interpolated - 1)
            }
            LaneInput::FrontFacing => FragmentInputSource::FrontFacing,
            // Each pixel is shaded once, as sample 0. The indices of vertices and instances do not occur in a fragment stage.
            LaneInput::SampleIndex | LaneInput::VertexIndex | LaneInput::InstanceIndex => FragmentInputSource::Zero,
        };
        let source_if_read = |(k, input)| {
            // Also called for inputs that are not read, because it counts the varyings.
            let source = source_of(input);
            if fragment.reads_input(k) { source } else { FragmentInputSource::Unread }
        };
        let input_sources = fragment.inputs().iter().enumerate().map(source_if_read).collect();
        let colour_outputs = [0, 1, 2, 3]
            .map(|c| outputs.iter().position(|o| matches!(*o, LaneOutput::Location { index: 0, component, .. } if component == c)));
        let depth_output = outputs.iter().position(|o| matches!(o, LaneOutput::FragDepth));
        let depth = DepthState { test: depth.test && has_depth, write: depth.write && has_depth };
        let allows_early_depth_test = !fragment.uses_discard() && depth_output.is_none();
        Self { input_sources, colour_outputs, depth_output, allows_early_depth_test, depth }
    }

    /// Whether every covered pixel is drawn, because the draw neither discards, nor tests or writes depth.
    pub(crate) fn draws_every_covered_pixel(&self) -> bool {
        self.allows_early_depth_test && !self.uses_depth()
    }

    pub(crate) fn uses_depth(&self) -> bool {
        self.depth.test || self.depth.write
    }
}
