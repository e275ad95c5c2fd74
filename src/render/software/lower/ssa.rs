//! Instructions in SSA form, before they get slots and registers. The builder emits them, the optimisations rewrite them, and `finish.rs` assembles the tapes
//! from them.

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

/// The values that an instruction reads or writes. Up to four are stored inline: with a `Vec`, most of the lowering time was spent in allocation.
pub(crate) type SsaValues = SmallVec<[SsaValue; 4]>;

/// One SSA instruction. It runs once per draw if `dst` is a [`SsaValue::Draw`], otherwise once per batch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SsaInstr {
    Op {
        dst: SsaValue,
        op: Op,
        args: SsaValues,
    },
    /// A chain of operations as one instruction, as [`Instr::FusedKernel`](crate::render::software::tape::Instr::FusedKernel); created by
    /// `chains.rs`, after the other optimisations.
    FusedKernel {
        dst: SsaValue,
        ops: Vec<FusedOp>,
        args: SsaValues,
    },
    /// Copies a value. Only variables are written more than once: those of loops and branches (`merge.rs`), and captured named values (`capture.rs`). All
    /// writes after the first are `Assign`; before slots are allocated, `merge.rs` replaces some: the operation that computes `from` then writes `dst` itself.
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
    /// `Texture` and the four variants below it: as the instructions of the same name in `tape.rs`, with a label in place of the index of a jump's target.
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
    /// Marks the start of a loop for the optimisations, as `LoopEnd` does its end; neither becomes an instruction of a tape.
    LoopStart,
    LoopEnd,
}

impl SsaInstr {
    /// Whether the instruction is at the border of straight-line code: what is known of values before it may not hold after it.
    pub(crate) fn is_control_flow(&self) -> bool {
        match self {
            Self::SkipIfNoLane { .. } | Self::JumpIf { .. } | Self::Jump { .. } | Self::Label(_) | Self::LoopStart | Self::LoopEnd => true,
            Self::Op { .. }
            | Self::FusedKernel { .. }
            | Self::Assign { .. }
            | Self::LoadUniform { .. }
            | Self::Texture { .. }
            | Self::TextureSize { .. } => false,
        }
    }
}

/// The values that an instruction reads.
pub(crate) fn reads(instr: &SsaInstr) -> SsaValues {
    match instr {
        SsaInstr::Op { args, .. } | SsaInstr::FusedKernel { args, .. } => args.clone(),
        SsaInstr::Assign { from, .. } => smallvec![*from],
        SsaInstr::LoadUniform { index, .. } => index.iter().copied().collect(),
        SsaInstr::Texture { args, mask, .. } => args.iter().copied().chain([*mask]).collect(),
        SsaInstr::TextureSize { level, .. } => smallvec![*level],
        SsaInstr::SkipIfNoLane { mask, .. } => smallvec![*mask],
        SsaInstr::JumpIf { cond, .. } => smallvec![*cond],
        SsaInstr::Jump { .. } | SsaInstr::Label(_) | SsaInstr::LoopStart | SsaInstr::LoopEnd => smallvec![],
    }
}

/// How often each value is read, by instructions and as an output.
pub(crate) fn use_counts(code: &[SsaInstr], outputs: &[SsaValue]) -> HashMap<SsaValue, u32> {
    let mut uses: HashMap<SsaValue, u32> = HashMap::default();
    for v in code.iter().flat_map(reads).chain(outputs.iter().copied()) {
        *uses.entry(v).or_default() += 1;
    }
    uses
}

/// Removes the instructions with these indices.
pub(crate) fn remove_instrs(code: &mut Vec<SsaInstr>, removed: &HashSet<usize>) {
    let mut index = 0;
    code.retain(|_| {
        index += 1;
        !removed.contains(&(index - 1))
    });
}

/// Replaces the values that an instruction reads by those that `replacement` gives for them, if any.
pub(crate) fn replace_reads(instr: &mut SsaInstr, replacement: impl Fn(SsaValue) -> Option<SsaValue>) {
    let replace = |v: &mut SsaValue| *v = replacement(*v).unwrap_or(*v);
    match instr {
        SsaInstr::Op { args, .. } | SsaInstr::FusedKernel { args, .. } => args.iter_mut().for_each(replace),
        SsaInstr::Assign { from, .. } => replace(from),
        SsaInstr::LoadUniform { index, .. } => index.iter_mut().for_each(replace),
        SsaInstr::Texture { args, mask, .. } => args.iter_mut().chain([mask]).for_each(replace),
        SsaInstr::TextureSize { level, .. } => replace(level),
        SsaInstr::SkipIfNoLane { mask, .. } => replace(mask),
        SsaInstr::JumpIf { cond, .. } => replace(cond),
        SsaInstr::Jump { .. } | SsaInstr::Label(_) | SsaInstr::LoopStart | SsaInstr::LoopEnd => {}
    }
}

/// The values that an instruction writes.
pub(crate) fn writes(instr: &SsaInstr) -> SsaValues {
    match instr {
        SsaInstr::Op { dst, .. }
        | SsaInstr::FusedKernel { dst, .. }
        | SsaInstr::Assign { dst, .. }
        | SsaInstr::LoadUniform { dst, .. }
        | SsaInstr::TextureSize { dst, .. } => smallvec![*dst],
        SsaInstr::Texture { dst, .. } => SsaValues::from_slice(dst),
        _ => smallvec![],
    }
}
