//! The boundary between the tape (lowering, executor) and the rasteriser: what a lowered entry point reads and writes.
//!
//! A program runs over batches of `LANES` lanes in structure-of-arrays form. Fragment lanes are laid out in 2x2 quads: lanes 4q..4q+3
//! are the top-left, top-right, bottom-left, bottom-right pixel of quad q, so dpdx is lane^1 and dpdy is lane^2.

use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    Vertex,
    Fragment,
}

/// One scalar per lane that the caller writes before a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LaneInput {
    /// A component of `@location(index)`: an attribute (vertex) or a varying (fragment).
    Location {
        index: u32,
        component: u32,
        flat: bool,
    },
    /// Component 0..=3 of `@builtin(position)` in the fragment stage: x + 0.5, y + 0.5, depth, 1/w.
    FragCoord {
        component: u32,
    },
    FrontFacing,
    VertexIndex,
    InstanceIndex,
    SampleIndex,
}

/// One scalar per lane that the caller reads after a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LaneOutput {
    Location {
        index: u32,
        component: u32,
        flat: bool,
    },
    /// Component of the clip-space position (vertex stage).
    Position {
        component: u32,
    },
    FragDepth,
}

/// A texture-and-sampler pair or a texture alone that the program reads: binding numbers in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TextureUse {
    pub texture_binding: u32,
    /// None for textureLoad and textureDimensions.
    pub sampler_binding: Option<u32>,
}
