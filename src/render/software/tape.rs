//! The tape: a shader compiled to a list of instructions, which the software renderer interprets for many pixels (lanes) at once. This module defines its
//! operations, operands and instructions as plain values; [`super::kernels`] defines what an operation computes.

use serde::{Deserialize, Serialize};

/// Where the value of an operand is: the number of a slot or of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Operand {
    /// One value per lane.
    Slot(u16),
    /// One value for all lanes.
    Reg(u16),
}

macro_rules! ops {
    ($($name:ident $arity:literal,)*) => {
        /// A scalar operation, applied lane by lane (Dpdx and Dpdy, the screen-space derivatives, also read neighbouring lanes). A prefix or suffix names the
        /// type of the operands: F floats, U unsigned integers, B masks (booleans), I signed integers; I also stands for both kinds of integers where their
        /// results have the same bits, as in IAdd. An arithmetic operation without such a letter is for floats, a bitwise one for integers and masks; Copy and
        /// Select are for all types. `XFromY` converts Y to X; F16 stands for the bits of a half float, in the lower half of an integer, and Bits for the bits
        /// of a float, unchanged. Fma, Fms and Fnma are a*b+c, a*b-c and c-a*b. Comparisons yield masks. The operands of Select are the mask, the result where
        /// it is set, and the result elsewhere (in WGSL the last two are in the opposite order, and the condition is last).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum Op { $($name,)* }
        impl Op {
            /// All operations, in declaration order.
            pub const ALL: &[Op] = &[$(Op::$name,)*];
            /// Number of operands, 1 to 3.
            pub const fn arity(self) -> usize { match self { $(Op::$name => $arity,)* } }
        }
    };
}
pub(crate) use ops_list::with_ops;
mod ops_list {
    /// Calls the macro `$m` with every operation and its number of operands.
    macro_rules! with_ops {
        ($m:ident) => {
            $m! {
                Copy 1, Neg 1, Abs 1, Sqrt 1, InverseSqrt 1, Floor 1, Ceil 1, Round 1, Trunc 1, Fract 1, Sign 1,
                Exp 1, Exp2 1, Log 1, Log2 1, Sin 1, Cos 1, Tan 1, Asin 1, Acos 1, Atan 1,
                Sinh 1, Cosh 1, Tanh 1, Asinh 1, Acosh 1, Atanh 1, QuantizeF16 1, F16FromF 1, FFromF16 1,
                IsNan 1, IsInf 1, INeg 1, IAbs 1, ISign 1, INot 1, BNot 1,
                CountOneBits 1, LeadingZeros 1, TrailingZeros 1, ReverseBits 1, FirstLeadingBitI 1, FirstLeadingBitU 1, FirstTrailingBit 1,
                IFromF 1, UFromF 1, FFromI 1, FFromU 1, BitsFromF 1, FFromBits 1,
                Dpdx 1, Dpdy 1,
                Add 2, Sub 2, Mul 2, Div 2, Min 2, Max 2, FRem 2, Pow 2, Atan2 2, Ldexp 2,
                FLt 2, FLe 2, FEq 2, FNe 2, ILt 2, ILe 2, ULt 2, ULe 2, IEq 2, INe 2,
                IAdd 2, ISub 2, IMul 2, IDiv 2, UDiv 2, IRem 2, URem 2, Shl 2, ShrI 2, ShrU 2,
                And 2, Or 2, Xor 2, IMin 2, IMax 2, UMin 2, UMax 2,
                Fma 3, Fms 3, Fnma 3, Select 3,
            }
        };
    }
    pub(crate) use with_ops;
}
with_ops!(ops);

/// One operation of a chain. A chain is several operations that one kernel computes; each takes the result of the previous one as an operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct FusedOp {
    pub op: Op,
    /// Index of the operand that is the result of the chain's previous operation; 0 for the first operation, which has no such operand.
    pub chained_operand: u8,
}

/// The type of a 32-bit word of the uniform block. `Int`: signed or unsigned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WordKind {
    Float,
    Int,
}

/// The kind of a texture instruction. Each variant lists its operands in order. u and v are texture coordinates, 0 to 1 across the texture; their derivatives
/// are per pixel of the image that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TextureOp {
    /// u, v, du/dx, dv/dx, du/dy, dv/dy.
    Gradients,
    /// Like `Gradients`, then the maximum number of taps along the footprint: `filtered_map` of shaders/lib/filtered_map.wesl as one operation.
    Filtered,
    /// u, v, level.
    Level,
    /// x, y, level (integers).
    Load,
    /// x, y in texels, (0, 0) at the middle of the first texel: bilinear interpolation of level 0, `texels_between` of shaders/lib/texels_between.wesl as one
    /// operation.
    Bilinear,
}

/// One instruction. `dst` is the number of a slot or register. The target of a jump is the index of an instruction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Instr {
    /// dst slot = op(args), lane by lane; at least one argument is a slot, or `op` is Copy.
    Lane {
        op: Op,
        dst: u16,
        args: Vec<Operand>,
    },
    /// dst slot = result of a chain of operations, lane by lane. `args`: the operands of the first operation, then the remaining operands of
    /// each further operation. Only for the chains for which [`super::kernels`] has a compiled function.
    FusedKernel {
        ops: Vec<FusedOp>,
        dst: u16,
        args: Vec<Operand>,
    },
    /// dst register = op(args), computed once for all lanes; arguments are registers.
    Scalar {
        op: Op,
        dst: u16,
        args: Vec<Operand>,
    },
    /// dst register = the word of the uniform block at byte `offset + index * stride`, with the index clamped to `count - 1`; `None`: index 0.
    LoadUniform {
        dst: u16,
        kind: WordKind,
        offset: u32,
        index: Option<Operand>,
        stride: u32,
        count: u32,
    },
    /// Like `LoadUniform` with one index and one word per lane: `index` and `dst` are slots.
    GatherUniform {
        dst: u16,
        kind: WordKind,
        offset: u32,
        index: Operand,
        stride: u32,
        count: u32,
    },
    /// dst slots (red, green, blue, alpha) = what is read from a texture, in the lanes that are set in `mask`. `texture`: index into the program's list of
    /// textures with their samplers.
    Texture {
        op: TextureOp,
        texture: u16,
        dst: [u16; 4],
        /// Of the four results, those that any instruction reads. The others are neither filtered nor written.
        channels_read: [bool; 4],
        args: Vec<Operand>,
        mask: Operand,
    },
    /// dst register (an integer) = width (axis 0) or height (axis 1) of a level in texels, or the number of levels (axis 2).
    TextureSize {
        dst: u16,
        texture: u16,
        axis: u8,
        level: Operand,
    },
    /// Jumps to `target` if no lane is set in the mask.
    SkipIfNoLane {
        mask: Operand,
        target: u32,
    },
    /// Jumps to `target` if `cond`, a register that contains a boolean, equals `when`.
    JumpIf {
        cond: Operand,
        when: bool,
        target: u32,
    },
    Jump {
        target: u32,
    },
}

impl Instr {
    /// Whether the instruction may be on the tape that runs once per draw: it computes a register from registers or from the uniform block.
    pub(crate) fn is_per_draw(&self) -> bool {
        matches!(self, Self::Scalar { .. } | Self::LoadUniform { .. } | Self::TextureSize { .. })
            && self.operands().iter().all(|o| matches!(o, Operand::Reg(_)))
    }

    /// Whether the number of operands is right, operands that must be registers are, and the result slots of a texture instruction differ. Not checked here:
    /// the operands of a chain, which [`super::exec`] checks before the first run.
    pub(crate) fn is_well_formed(&self) -> bool {
        let is_register = |o: &Operand| matches!(o, Operand::Reg(_));
        match self {
            Self::Lane { op, args, .. } => args.len() == op.arity(),
            Self::Scalar { op, args, .. } => args.len() == op.arity() && args.iter().all(is_register),
            Self::LoadUniform { index, .. } => index.iter().all(is_register),
            Self::Texture { op, args, dst, .. } => {
                let needed = match op {
                    TextureOp::Gradients => 6,
                    TextureOp::Filtered => 7,
                    TextureOp::Level | TextureOp::Load => 3,
                    TextureOp::Bilinear => 2,
                };
                args.len() == needed && dst.iter().enumerate().all(|(k, slot)| !dst[..k].contains(slot))
            }
            Self::TextureSize { axis, level, .. } => *axis <= 2 && is_register(level),
            Self::JumpIf { cond, .. } => is_register(cond),
            Self::FusedKernel { .. } | Self::GatherUniform { .. } | Self::SkipIfNoLane { .. } | Self::Jump { .. } => true,
        }
    }

    /// All operands that the instruction reads, a mask included.
    pub(crate) fn operands(&self) -> Vec<Operand> {
        match self {
            Self::Lane { args, .. } | Self::FusedKernel { args, .. } | Self::Scalar { args, .. } => args.clone(),
            Self::LoadUniform { index, .. } => index.iter().copied().collect(),
            Self::GatherUniform { index, .. } => vec![*index],
            Self::Texture { args, mask, .. } => args.iter().copied().chain([*mask]).collect(),
            Self::TextureSize { level, .. } => vec![*level],
            Self::SkipIfNoLane { mask, .. } => vec![*mask],
            Self::JumpIf { cond, .. } => vec![*cond],
            Self::Jump { .. } => vec![],
        }
    }

    pub(crate) fn written_slots(&self) -> Vec<u16> {
        match self {
            Self::Lane { dst, .. } | Self::FusedKernel { dst, .. } | Self::GatherUniform { dst, .. } => vec![*dst],
            Self::Texture { dst, .. } => dst.to_vec(),
            _ => vec![],
        }
    }

    pub(crate) fn written_register(&self) -> Option<u16> {
        match self {
            Self::Scalar { dst, .. } | Self::LoadUniform { dst, .. } | Self::TextureSize { dst, .. } => Some(*dst),
            _ => None,
        }
    }

    /// The texture that the instruction reads, as an index into the program's list.
    pub(crate) fn texture(&self) -> Option<u16> {
        match self {
            Self::Texture { texture, .. } | Self::TextureSize { texture, .. } => Some(*texture),
            _ => None,
        }
    }

    /// The target, if the instruction is a jump.
    pub(crate) fn target(&self) -> Option<u32> {
        match self {
            Self::SkipIfNoLane { target, .. } | Self::JumpIf { target, .. } | Self::Jump { target } => Some(*target),
            _ => None,
        }
    }
}
