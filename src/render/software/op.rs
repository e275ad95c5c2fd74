//! The operations of the tape: one scalar result from up to three scalar arguments, the same on every kernel class.
//!
//! Booleans are masks: all bits set or none. Integers are 32 bits, wrapping. Floats follow IEEE 754; where WGSL leaves a choice
//! (NaN in min and max, overflow in conversions) the choice is written beside the operation in `math`.

use serde::{Deserialize, Serialize};

/// What one operation computes; see [`Op::arity`] for how many arguments count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Op {
    Copy,
    // Floats.
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    /// a * b + c, rounded once where the machine has it.
    MulAdd,
    /// c - a * b, likewise.
    NegMulAdd,
    Neg,
    Abs,
    Min,
    Max,
    Floor,
    Ceil,
    Trunc,
    Round,
    Fract,
    Sign,
    Sqrt,
    InverseSqrt,
    Exp,
    Exp2,
    Log,
    Log2,
    Pow,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Less,
    LessEqual,
    Equal,
    NotEqual,
    // Masks, and bits of integers.
    And,
    Or,
    Xor,
    Not,
    /// a where the mask c is set, else b.
    Select,
    // Integers.
    IntAdd,
    IntSub,
    IntMul,
    IntNeg,
    IntDiv,
    UintDiv,
    IntRem,
    UintRem,
    IntMin,
    IntMax,
    UintMin,
    UintMax,
    IntLess,
    UintLess,
    IntLessEqual,
    UintLessEqual,
    IntEqual,
    IntNotEqual,
    ShiftLeft,
    IntShiftRight,
    UintShiftRight,
    // Conversions.
    IntToFloat,
    UintToFloat,
    FloatToInt,
    FloatToUint,
    MaskToInt,
    IntToMask,
    /// The 32-bit pattern of a float as an integer and back (through f32 in double precision).
    FloatBits,
    BitsFloat,
    // Quads.
    DerivativeX,
    DerivativeY,
}

impl Op {
    /// Arguments that count: 1 to 3.
    pub fn arity(self) -> usize {
        use Op::*;
        match self {
            Copy | Neg | Abs | Floor | Ceil | Trunc | Round | Fract | Sign | Sqrt | InverseSqrt | Exp | Exp2 | Log | Log2 | Sin | Cos
            | Tan | Asin | Acos | Atan | Not | IntNeg | IntToFloat | UintToFloat | FloatToInt | FloatToUint | MaskToInt | IntToMask
            | FloatBits | BitsFloat | DerivativeX | DerivativeY => 1,
            MulAdd | NegMulAdd | Select => 3,
            _ => 2,
        }
    }

    /// The two first arguments may change places.
    pub fn commutes(self) -> bool {
        use Op::*;
        matches!(
            self,
            Add | Mul | Equal | NotEqual | And | Or | Xor | IntAdd | IntMul | IntMin | IntMax | UintMin | UintMax | IntEqual | IntNotEqual
        )
    }
}
