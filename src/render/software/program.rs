//! A lowered entry point: its inputs, its outputs and its two tapes (lists of instructions, see `tape`). One tape runs once per draw, the other once per batch
//! of lanes. `lower` makes programs and `exec` runs them; the rasteriser sees only their inputs and outputs (`stage`).
//!
//! A program runs over batches of lanes in structure-of-arrays form. Fragment lanes are arranged in 2x2 quads: lanes 4q to 4q + 3
//! are the top-left, top-right, bottom-left, bottom-right pixel of quad q. So `dpdx` (right minus left) is computed from a lane and lane ^ 1, `dpdy` (lower
//! minus upper) from a lane and lane ^ 2.
//!
//! Always: every operand refers to a register or slot below the counts stored here ([`Program::check`] verifies this for bytes
//! from a file), and no lane operation writes a slot that it reads.

use super::tape::{Instr, Op, Operand};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShaderStage {
    Vertex,
    Fragment,
}

/// One scalar per lane that the caller writes before a run. Integers and booleans are bit-cast (see [`super::math::Real`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LaneInput {
    /// A component of `@location(index)`: an attribute (vertex) or a varying (fragment), `flat` if it is not interpolated.
    Location {
        index: u32,
        component: u32,
        flat: bool,
    },
    /// Component 0..=3 of `@builtin(position)` in the fragment stage: x and y of the pixel's centre in pixels from the top left of the target, reversed depth,
    /// and 1/w of the clip-space position.
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
    /// A component of `@location(index)`: a varying (vertex), `flat` if it is not interpolated, or a colour (fragment).
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

/// A texture that the program reads, with or without a sampler: their binding numbers in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TextureUse {
    pub texture_binding: u32,
    /// `None` for textureLoad and textureDimensions.
    pub sampler_binding: Option<u32>,
}

/// A constant operand, before conversion to the element type of the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Constant {
    Float(f64),
    /// The bits of an i32 or u32.
    Int(u32),
    Bool(bool),
}

/// Why the programs of a file cannot be run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProgramError {
    /// The bytes are not a serialized program.
    #[error(transparent)]
    Bytes(#[from] postcard::Error),
    /// An index outside the program's registers, slots, textures or tape, or an instruction with the wrong number or kind of operands.
    #[error("program '{0}' is malformed: an operand, count or jump target is invalid")]
    Malformed(String),
}

/// One lowered entry point. Registers contain one value for all lanes (constants first, then per-draw values, then values that the lane tape
/// computes); slots contain one value per lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// Name of the entry point.
    pub name: String,
    pub stage: ShaderStage,
    /// Lane inputs in order. When a run starts, input k is in slot k, and the mask of active lanes is in the slot after the last input.
    pub inputs: Vec<LaneInput>,
    /// For each input, whether any instruction reads it.
    pub inputs_read: Vec<bool>,
    pub outputs: Vec<LaneOutput>,
    /// For each output, the slot that contains it after the run. A register, which only a damaged file can have here or in `discarded`, is refused by
    /// `BoundProgram::new`.
    pub output_operands: Vec<Operand>,
    pub textures: Vec<TextureUse>,
    pub uses_discard: bool,
    /// The slot that contains the mask of the discarded lanes after the run, if `uses_discard`.
    pub discarded: Option<Operand>,
    pub uses_derivatives: bool,
    /// Size of the uniform block in bytes; 0 if there is none.
    pub uniform_size: u32,
    /// The values of the first registers.
    pub constants: Vec<Constant>,
    /// Tape without jumps that runs once per draw.
    pub draw_tape: Vec<Instr>,
    /// Tape that runs per batch of lanes.
    pub lane_tape: Vec<Instr>,
    pub register_count: u32,
    pub slot_count: u32,
}

/// Programs have fewer slots and fewer registers than this: operands are 16 bits wide. The limit is below 2^16, so that the numbers of scratch slots, which
/// `exec` adds after a program's slots, fit as well.
pub(crate) const SLOT_OR_REGISTER_LIMIT: u32 = 60_000;

impl Program {
    /// Each kind of lane operation with its number of occurrences on the tape, alone or in chains (a loop's body counts once): most frequent first, equally
    /// frequent ones in the order of [`Op`].
    pub fn op_statistics(&self) -> Vec<(Op, usize)> {
        let mut counts: Vec<(Op, usize)> = Vec::new();
        for instr in &self.lane_tape {
            let (single_op, chain) = match instr {
                Instr::Lane { op, .. } => (Some(*op), &[][..]),
                Instr::FusedKernel { ops, .. } => (None, &ops[..]),
                _ => (None, &[][..]),
            };
            for op in single_op.into_iter().chain(chain.iter().map(|fused| fused.op)) {
                match counts.iter_mut().find(|(counted, _)| *counted == op) {
                    Some((_, count)) => *count += 1,
                    None => counts.push((op, 1)),
                }
            }
        }
        counts.sort_by(|(op_a, count_a), (op_b, count_b)| count_b.cmp(count_a).then_with(|| (*op_a as u32).cmp(&(*op_b as u32))));
        counts
    }

    /// Verifies every index, so that a program read from a file cannot access anything outside its registers, slots or tape.
    pub fn check(&self) -> Result<(), ProgramError> {
        let is_in_range = |o: &Operand| match *o {
            Operand::Slot(s) => u32::from(s) < self.slot_count,
            Operand::Reg(r) => u32::from(r) < self.register_count,
        };
        // The slot after the inputs is that of the mask of active lanes. A jump may go to the end of the tape.
        let is_valid = self.inputs.len() < self.slot_count as usize
            && self.inputs_read.len() == self.inputs.len()
            && self.slot_count < SLOT_OR_REGISTER_LIMIT
            && self.register_count < SLOT_OR_REGISTER_LIMIT
            && self.constants.len() <= self.register_count as usize
            && self.outputs.len() == self.output_operands.len()
            && self.output_operands.iter().chain(&self.discarded).all(is_in_range)
            && self.draw_tape.iter().all(|i| i.is_per_draw())
            && self.draw_tape.iter().chain(&self.lane_tape).all(|i| {
                i.is_well_formed()
                    && i.operands().iter().all(is_in_range)
                    && i.written_slots().iter().all(|&s| u32::from(s) < self.slot_count && !i.operands().contains(&Operand::Slot(s)))
                    && i.written_register().is_none_or(|r| u32::from(r) < self.register_count)
                    && i.texture().is_none_or(|t| usize::from(t) < self.textures.len())
                    && i.target().is_none_or(|t| t as usize <= self.lane_tape.len())
            });
        if is_valid { Ok(()) } else { Err(ProgramError::Malformed(self.name.clone())) }
    }
}
