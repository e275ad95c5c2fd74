//! A lowered entry point: a tape of scalar operations over lanes, and what it reads and writes.
//!
//! A program runs over batches of [`LANES`] lanes in structure-of-arrays form. Fragment lanes are laid out in 2x2 quads: lanes 4q..4q+3
//! are the top-left, top-right, bottom-left and bottom-right pixel of quad q, so the neighbour right is lane^1 and the one below lane^2.
//! The uniform tape runs once per draw on single values; its results and the constants are the broadcast table, which lane operations read
//! without taking a slot.

use super::op::Op;
use serde::{Deserialize, Serialize};

/// Lanes of one batch: 32 quads. The measured sweet spot between dispatch cost and first-level cache.
pub const LANES: usize = 128;

/// One scalar per lane that the caller writes before a run. Integers and booleans travel as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    Vertex,
    Fragment,
}

/// Where an operation reads: a lane slot, or an entry of the broadcast table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Operand {
    Slot(u16),
    Splat(u16),
}

/// A value known when the module is lowered. Floats are kept in double precision and rounded once, to the run's precision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Constant {
    Float(f64),
    /// `i32` or `u32` bits.
    Bits(u32),
    Bool(bool),
}

/// One step of the lane tape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Step {
    /// `dst = op(args)`; `dst` is never the slot of an argument.
    Op {
        op: Op,
        dst: u16,
        args: [Operand; 3],
    },
    /// Goes on at step `to` when no active lane has the mask set.
    SkipUnlessAny {
        mask: Operand,
        to: u32,
    },
    /// Goes back to step `to` while any active lane has the mask set.
    LoopWhileAny {
        mask: Operand,
        to: u32,
    },
    /// Ends the batch when no active lane has the mask set (every lane is discarded).
    EndUnlessAny {
        mask: Operand,
    },
    /// Four channels at (u, v) with the gradients of both.
    SampleGrad {
        texture: u32,
        sampler: u32,
        dst: [u16; 4],
        uv: [Operand; 2],
        gradient: [Operand; 4],
    },
    SampleLevel {
        texture: u32,
        sampler: u32,
        dst: [u16; 4],
        uv: [Operand; 2],
        level: Operand,
    },
    /// One texel by integer coordinates and level.
    Load {
        texture: u32,
        dst: [u16; 4],
        at: [Operand; 2],
        level: Operand,
    },
    /// Width and height of a level, as integers.
    Dimensions {
        texture: u32,
        dst: [u16; 2],
        level: Operand,
    },
}

/// One step of the uniform tape: `table[dst] = op(table[args])`, or a load from the uniform bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum UniformStep {
    Op {
        op: Op,
        dst: u16,
        args: [u16; 3],
    },
    /// A 32-bit word of the block at `binding`, as a float or as bits.
    Word {
        binding: u32,
        byte: u32,
        dst: u16,
        float: bool,
    },
}

/// A lowered entry point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    pub stage: Stage,
    /// Input k is written to slot k.
    pub inputs: Vec<LaneInput>,
    pub outputs: Vec<(LaneOutput, Operand)>,
    /// The mask of lanes that were not discarded; none when the entry point never discards.
    pub alive: Option<Operand>,
    pub constants: Vec<Constant>,
    /// Entries of the broadcast table: the constants first.
    pub table_len: u16,
    pub uniform_steps: Vec<UniformStep>,
    pub steps: Vec<Step>,
    pub slots: u16,
    pub uses_derivatives: bool,
}

impl Program {
    /// How often each kind of step stands on the lane tape, by name.
    pub fn operation_counts(&self) -> std::collections::BTreeMap<String, usize> {
        let mut counts = std::collections::BTreeMap::new();
        for step in &self.steps {
            let name = match step {
                Step::Op { op, .. } => format!("{op:?}"),
                Step::SkipUnlessAny { .. } | Step::LoopWhileAny { .. } | Step::EndUnlessAny { .. } => "Jump".into(),
                Step::SampleGrad { .. } | Step::SampleLevel { .. } => "Sample".into(),
                Step::Load { .. } => "Load".into(),
                Step::Dimensions { .. } => "Dimensions".into(),
            };
            *counts.entry(name).or_insert(0) += 1;
        }
        counts
    }
}

/// The programs of a module's entry points, as the library keeps them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModulePrograms {
    pub vertex: Program,
    pub fragment: Program,
}
