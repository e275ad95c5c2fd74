//! Steps: instructions in SSA form, before they get slots and registers. The builder emits them, the optimisation passes rewrite them, and `finish.rs`
//! assembles the tapes from them.

use crate::render::software::tape::{FusedOp, Op, TextureOp, WordKind};
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};
use smallvec::{SmallVec, smallvec};

/// A scalar value during lowering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum SsaValue {
    /// Index into the constants.
    Const(u32),
    /// Computed on the draw tape, once per draw. The number here, as in `Shared` and `Lane`, only identifies the value.
    Draw(u32),
    /// One value for all lanes, computed on the lane tape.
    Shared(u32),
    /// One value per lane.
    Lane(u32),
}

pub(crate) type JumpLabel = u32;

/// The values that a step reads or writes. Up to four are stored inline: with a `Vec`, most of the lowering time was spent in allocation.
pub(crate) type SsaValues = SmallVec<[SsaValue; 4]>;

/// One step. The rate of `dst` (see `builder.rs`) determines how often it runs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SsaStep {
    Op {
        dst: SsaValue,
        op: Op,
        args: SsaValues,
    },
    /// A chain of operations as one instruction, as [`Instr::FusedKernel`](crate::render::software::tape::Instr::FusedKernel); created by the last pass,
    /// `chains.rs`.
    FusedKernel {
        dst: SsaValue,
        ops: Vec<FusedOp>,
        args: SsaValues,
    },
    /// Copies a value. Only variables are written more than once: those of loops and branches (`merge.rs`), and captured named values (`capture.rs`). Their
    /// later writes are `Assign`; the last pass before slots are allocated turns some of these into the result of an operation.
    Assign {
        dst: SsaValue,
        from: SsaValue,
    },
    /// As `Instr::LoadUniform`: `offset` and `stride` in bytes.
    LoadUniform {
        dst: SsaValue,
        kind: WordKind,
        offset: u32,
        index: Option<SsaValue>,
        stride: u32,
        count: u32,
    },
    /// This step and the four below: as the instructions of the same name in `tape.rs`, with a label in place of the index of a jump's target.
    Texture {
        op: TextureOp,
        texture: u16,
        dst: [SsaValue; 4],
        args: SsaValues,
        mask: SsaValue,
    },
    TextureSize {
        dst: SsaValue,
        texture: u16,
        axis: u8,
        level: SsaValue,
    },
    SkipIfNoLane {
        mask: SsaValue,
        label: JumpLabel,
    },
    JumpIf {
        cond: SsaValue,
        when: bool,
        label: JumpLabel,
    },
    Jump {
        label: JumpLabel,
    },
    Label(JumpLabel),
    /// Marks the start of a loop for the optimisation passes, as `LoopEnd` does its end; neither becomes an instruction.
    LoopStart,
    LoopEnd,
}

/// The values that a step reads.
pub(crate) fn reads(step: &SsaStep) -> SsaValues {
    match step {
        SsaStep::Op { args, .. } | SsaStep::FusedKernel { args, .. } => args.clone(),
        SsaStep::Assign { from, .. } => smallvec![*from],
        SsaStep::LoadUniform { index, .. } => index.iter().copied().collect(),
        SsaStep::Texture { args, mask, .. } => args.iter().copied().chain([*mask]).collect(),
        SsaStep::TextureSize { level, .. } => smallvec![*level],
        SsaStep::SkipIfNoLane { mask, .. } => smallvec![*mask],
        SsaStep::JumpIf { cond, .. } => smallvec![*cond],
        SsaStep::Jump { .. } | SsaStep::Label(_) | SsaStep::LoopStart | SsaStep::LoopEnd => smallvec![],
    }
}

/// How often each value is read, by steps and as an output.
pub(crate) fn use_counts(code: &[SsaStep], outputs: &[SsaValue]) -> HashMap<SsaValue, u32> {
    let mut uses: HashMap<SsaValue, u32> = HashMap::default();
    for v in code.iter().flat_map(reads).chain(outputs.iter().copied()) {
        *uses.entry(v).or_default() += 1;
    }
    uses
}

/// Removes the steps with these indices.
pub(crate) fn remove_steps(code: &mut Vec<SsaStep>, removed: &HashSet<usize>) {
    let mut index = 0;
    code.retain(|_| {
        index += 1;
        !removed.contains(&(index - 1))
    });
}

/// Replaces the values that a step reads by those that `replacement` gives for them, if any.
pub(crate) fn replace_reads(step: &mut SsaStep, replacement: impl Fn(SsaValue) -> Option<SsaValue>) {
    let replace = |v: &mut SsaValue| *v = replacement(*v).unwrap_or(*v);
    match step {
        SsaStep::Op { args, .. } | SsaStep::FusedKernel { args, .. } => args.iter_mut().for_each(replace),
        SsaStep::Assign { from, .. } => replace(from),
        SsaStep::LoadUniform { index, .. } => index.iter_mut().for_each(replace),
        SsaStep::Texture { args, mask, .. } => args.iter_mut().chain([mask]).for_each(replace),
        SsaStep::TextureSize { level, .. } => replace(level),
        SsaStep::SkipIfNoLane { mask, .. } => replace(mask),
        SsaStep::JumpIf { cond, .. } => replace(cond),
        SsaStep::Jump { .. } | SsaStep::Label(_) | SsaStep::LoopStart | SsaStep::LoopEnd => {}
    }
}

/// The values that a step writes.
pub(crate) fn writes(step: &SsaStep) -> SsaValues {
    match step {
        SsaStep::Op { dst, .. }
        | SsaStep::FusedKernel { dst, .. }
        | SsaStep::Assign { dst, .. }
        | SsaStep::LoadUniform { dst, .. }
        | SsaStep::TextureSize { dst, .. } => smallvec![*dst],
        SsaStep::Texture { dst, .. } => SsaValues::from_slice(dst),
        _ => smallvec![],
    }
}
