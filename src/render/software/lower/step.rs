//! Steps in SSA form: what the builder makes, the passes over it rewrite, and the tape is assembled from.

use crate::render::software::tape::{FusedOp, Op, TextureOp, WordKind};
use smallvec::{SmallVec, smallvec};

/// A scalar value during lowering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Val {
    /// Index into the constants.
    Const(u32),
    /// Computed once per draw.
    Draw(u32),
    /// One value for all lanes, computed in line.
    Uniform(u32),
    Lane(u32),
}

pub type Label = u32;

/// Values of one step, most often no more than an operation takes: thousands of keys are lowered, and most of the time went to allocation.
pub type Vals = SmallVec<[Val; 4]>;

/// One step before slots and registers are assigned. `dst` of Lane-rate steps are lane ids, of others ids of draw or uniform values.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    Op {
        dst: Val,
        op: Op,
        args: Vals,
    },
    /// Several operations as one instruction; made last, by `chains.rs`.
    FusedKernel {
        dst: Val,
        links: Vec<FusedOp>,
        args: Vals,
    },
    /// A loop variable takes its next value: the one step that writes a value twice.
    Assign {
        dst: Val,
        from: Val,
    },
    LoadUniform {
        dst: Val,
        kind: WordKind,
        offset: u32,
        index: Option<Val>,
        stride: u32,
        count: u32,
    },
    Texture {
        what: TextureOp,
        texture: u16,
        dst: [Val; 4],
        args: Vals,
        mask: Val,
    },
    TextureSize {
        dst: Val,
        texture: u16,
        axis: u8,
        level: Val,
    },
    SkipIfNone {
        mask: Val,
        label: Label,
    },
    JumpIf {
        cond: Val,
        when: bool,
        label: Label,
    },
    Jump {
        label: Label,
    },
    Label(Label),
    LoopStart,
    LoopEnd,
}

/// The values that a step reads.
pub fn reads(step: &Step) -> Vals {
    match step {
        Step::Op { args, .. } | Step::FusedKernel { args, .. } => args.clone(),
        Step::Assign { from, .. } => smallvec![*from],
        Step::LoadUniform { index, .. } => index.iter().copied().collect(),
        Step::Texture { args, mask, .. } => args.iter().copied().chain([*mask]).collect(),
        Step::TextureSize { level, .. } => smallvec![*level],
        Step::SkipIfNone { mask, .. } => smallvec![*mask],
        Step::JumpIf { cond, .. } => smallvec![*cond],
        Step::Jump { .. } | Step::Label(_) | Step::LoopStart | Step::LoopEnd => smallvec![],
    }
}

/// The values that a step writes.
pub fn writes(step: &Step) -> Vals {
    match step {
        Step::Op { dst, .. }
        | Step::FusedKernel { dst, .. }
        | Step::Assign { dst, .. }
        | Step::LoadUniform { dst, .. }
        | Step::TextureSize { dst, .. } => smallvec![*dst],
        Step::Texture { dst, .. } => Vals::from_slice(dst),
        _ => smallvec![],
    }
}
