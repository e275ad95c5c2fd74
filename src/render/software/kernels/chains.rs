//! Chains of operations, each in one SIMD kernel: an operation uses the result of the previous one without a store and a load in between.
//!
//! In: up to [`MAX_OPERANDS`] operands: the operands of the first operation, then those of each further operation except the previous result. Out: the same
//! bits as from the kernels of the single operations run in order, because each operation still rounds separately. The table contains the
//! chains that occur most often in the atmosphere, eclipse, ring, map and tone-map code (docs/measurements.md: chosen by how often their operations
//! follow each other). The lowering calls [`find`], and splits a chain that the table lacks into chains of the table and single operations.

use super::class::UNROLLED_LANES;
use super::operand::{KernelOperand, unchecked_ref};
use super::ops::Eval;
use crate::render::software::math::Real;
use crate::render::software::tape::{FusedOp, Op};
use std::collections::HashMap;
use std::sync::LazyLock;

/// Maximum number of operands of a chain.
pub const MAX_OPERANDS: usize = 8;
/// Maximum number of operations of a chain.
pub const MAX_CHAIN_OPS: usize = 8;

/// Operand kinds as bits, the first operand in the lowest bit: L (1) = one value per lane, a slot; R (0) = one value for all lanes, a register.
pub const fn kind_bits(kinds: &str) -> u8 {
    let (kinds, mut bits, mut k) = (kinds.as_bytes(), 0, 0);
    while k < kinds.len() {
        if kinds[k] == b'L' {
            bits |= 1 << k;
        }
        k += 1;
    }
    bits
}

/// Each entry: the kinds of the operands, the first operation, then each further operation with the position of the previous result among its
/// operands. In `Mul`, `Add`, `Fma`, `Fms`, `Fnma`, `And` and `Or` this position is never 0: the lowering swaps the first two operands if necessary.
macro_rules! with_chains {
    ($m:ident) => {
        $m! {
            "LLL" = Add > Mul 1,
            "LL" = Add > IFromF 0,
            "LRL" = Div > Div 0,
            "LLLR" = Div > Select 1,
            "LLL" = FEq > And 1,
            "LRLL" = FLt > Select 0,
            "RLRR" = FLt > Select 0,
            "LL" = Floor > FLt 0,
            "RLRLL" = Fma > Fms 1,
            "RLLR" = Fms > Div 0,
            "LR" = IFromF > And 1,
            "LRL" = Max > Div 1,
            "LRR" = Max > Div 1,
            "LLL" = Max > Min 0,
            "LLL" = Min > Add 1,
            "RLL" = Mul > Div 0,
            "RLR" = Mul > Div 0,
            "LLLL" = Mul > Fms 2,
            "LLRL" = Mul > Fms 2,
            "RLLL" = Mul > Fms 2,
            "RLRL" = Mul > Fms 2,
            "RL" = Mul > IFromF 0,
            "LLRL" = Select > Add 1,
            "LL" = Sub > Abs 0,
            "RLR" = Sub > Div 0,
            "LLLL" = Sub > Fma 1,
            "LLLR" = Sub > Select 2,
            "LLRL" = Add > Max 0 > Div 1,
            "LRRR" = Div > Max 0 > Min 0,
            "LLLR" = Fms > Max 0 > Sqrt 0,
            "LRR" = IFromF > IMul 1 > IAdd 1,
            "RLRLR" = Mul > Fma 2 > Add 1,
            "RLRLRL" = Mul > Fma 2 > Fnma 2,
            "LLLL" = Mul > Fma 2 > Sqrt 0,
            "LLLLL" = Sub > Fma 1 > Mul 1,
            "RLRR" = Sub > Max 0 > Min 0,
            "LLLLLLLL" = Mul > Fma 2 > Fma 2 > Fma 1,
            "LLLLLLL" = Mul > Fma 2 > Fma 2 > Mul 1,
            "LLLLLLL" = Mul > Fma 2 > Fma 2 > Sub 0,
            "LLLLLLL" = Mul > Fma 2 > Fma 2 > Sub 1,
            "LLLRL" = Sub > Sub 0 > Max 0 > Mul 1,
            "LRRRRR" = Max > Div 1 > Sub 1 > Max 0 > Min 0,
            "RLRRRR" = Div > Log2 0 > Fms 1 > Max 0 > Min 0,
            "LLRRLLL" = FLe > Select 0 > Add 1 > Add 1 > Add 1 > IFromF 0,
            "LLL" = Add > Sub 0,
            "RLL" = Add > Sub 0,
            "LL" = BNot > And 1,
            "LLR" = Div > Max 0,
            "LRR" = Div > Max 0,
            "RLR" = Div > Max 0,
            "RLL" = Div > Mul 1,
            "LLL" = FLe > And 1,
            "LRL" = FLe > And 1,
            "RLL" = FLe > And 1,
            "LLRR" = FLe > Select 0,
            "LLL" = FLt > And 1,
            "LRL" = FLt > And 1,
            "RLL" = FLt > And 1,
            "LRR" = FLt > Or 1,
            "LLLL" = Fma > Div 0,
            "RLLL" = Fma > Div 0,
            "RLRL" = Fma > Div 1,
            "RLRR" = Fma > Div 1,
            "LLLLL" = Fma > Fma 2,
            "LLLLL" = Fma > Fma 1,
            "LLRLR" = Fma > Fma 1,
            "RLLRL" = Fma > Fma 2,
            "RLRLR" = Fma > Fma 1,
            "RLRRL" = Fma > Fma 2,
            "LLL" = Fma > InverseSqrt 0,
            "LLLR" = Fma > Max 0,
            "RLLR" = Fma > Max 0,
            "LLLL" = Fma > Mul 1,
            "RLLL" = Fma > Mul 1,
            "RLRL" = Fma > Mul 1,
            "LLLLL" = Fma > Select 1,
            "LLL" = Fma > Sqrt 0,
            "LLLR" = Fms > Max 0,
            "LLRR" = Fms > Max 0,
            "RLRR" = Fms > Max 0,
            "RLRR" = Fnma > Div 1,
            "LLRR" = Fnma > Max 0,
            "LR" = Max > InverseSqrt 0,
            "LLL" = Max > Max 0,
            "LRR" = Max > Min 0,
            "LRL" = Max > Mul 1,
            "LRR" = Max > Mul 1,
            "LR" = Max > Sqrt 0,
            "LL" = Mul > Exp 0,
            "RL" = Mul > Exp 0,
            "RL" = Mul > Floor 0,
            "LLLL" = Mul > Fma 1,
            "LLLL" = Mul > Fma 2,
            "LLRL" = Mul > Fma 2,
            "RLLL" = Mul > Fma 1,
            "RLLL" = Mul > Fma 2,
            "RLRL" = Mul > Fma 2,
            "LLR" = Mul > Max 0,
            "RLR" = Mul > Max 0,
            "LLL" = Mul > Mul 1,
            "LLR" = Mul > Mul 1,
            "RLL" = Mul > Mul 1,
            "RLR" = Mul > Mul 1,
            "LLLR" = Mul > Select 2,
            "RLLR" = Mul > Select 2,
            "L" = Neg > Exp 0,
            "LR" = Neg > Mul 1,
            "LL" = Neg > Sub 0,
            "LLLRL" = Select > Fma 1,
            "LLL" = Sub > Div 0,
            "LRL" = Sub > Div 0,
            "LRR" = Sub > Div 0,
            "LLR" = Sub > Max 0,
            "LRR" = Sub > Max 0,
            "LLL" = Sub > Mul 1,
            "LLR" = Sub > Mul 1,
            "LRL" = Sub > Mul 1,
            "LRR" = Sub > Mul 1,
            "RLL" = Sub > Mul 1,
            "RL" = Sub > Sqrt 0,
            "RLRRL" = Fma > Div 1 > Mul 1,
            "RLRL" = Mul > Floor 0 > Fnma 1,
            "LLLLLL" = Mul > Fma 2 > Fma 2,
            "RLRLRL" = Mul > Fma 2 > Fma 2,
            "RLRR" = Mul > Max 0 > Min 0,
            "LLLLL" = Mul > Mul 1 > Fma 2,
            "LLRRL" = Mul > Mul 1 > Fma 2,
            "LLLL" = Mul > Mul 1 > Mul 1,
            "LLR" = Neg > Mul 1 > Mul 1,
            "LRRR" = Sub > Max 0 > Mul 1,
            "RLRR" = Div > Max 0 > Min 0 > Asin 0,
            "LRRR" = Max > Min 0 > Acos 0 > Mul 1,
            "RLLLL" = Mul > Exp 0 > Mul 1 > Fma 1,
            "RLRLL" = Mul > Exp 0 > Mul 1 > Fma 1,
            "RLRL" = Mul > Floor 0 > Fma 1 > Fract 0,
            "RLRLRLL" = Mul > Fma 2 > Fma 2 > Div 0,
            "RLRLRLRR" = Mul > Fma 2 > Fma 2 > Fma 1,
            "LLLLLL" = Mul > Fma 2 > Fma 2 > InverseSqrt 0,
            "LLLLLLR" = Mul > Fma 2 > Fma 2 > Max 0,
            "LLLLLL" = Mul > Fma 2 > Fma 2 > Sqrt 0,
            "LLLLLLR" = Mul > Fma 2 > Fma 2 > Sub 1,
            "LLLLR" = Mul > Fma 2 > Sqrt 0 > Max 0,
            "LLLLLR" = Mul > Fms 2 > Div 0 > Mul 1,
            "LLLLLLL" = Mul > Fms 2 > Mul 1 > Fma 2,
            "RLLRL" = Mul > Mul 1 > Fma 2 > Fract 0,
            "RLLLL" = Mul > Mul 1 > Mul 1 > Mul 1,
            "RLRLL" = Mul > Mul 1 > Mul 1 > Mul 1,
            "LLRRL" = FLe > Select 0 > Add 1,
            "LLRRLL" = FLe > Select 0 > Add 1 > Add 1,
            "RLRRL" = Fnma > Div 1 > Mul 1,
            "LRRRR" = Sub > Div 0 > Max 0 > Min 0,
            "LLRRRR" = Sub > Fma 1 > Div 1 > Sub 1,
            "LLRRRL" = Sub > Max 0 > Div 1 > Select 1,
            "RLRLL" = Sub > Max 0 > Sqrt 0 > Select 1,
            "RLLRLRRR" = Fma > Fma 2 > Sub 0 > Mul 1 > Div 0,
            "LRRRRLL" = Max > Sub 0 > Div 1 > Sub 1 > Select 2,
            "RLRLRLRR" = Mul > Fma 2 > Fma 2 > Max 0 > Min 0,
            "RLRLRLRL" = Mul > Fma 2 > Fma 2 > Max 0 > Mul 1,
            "RLRLRLRR" = Mul > Fma 2 > Fma 2 > Sub 1 > Max 0,
            "RLLLLLLL" = Mul > Mul 1 > Fma 1 > Fma 1 > Mul 1,
            "RLLRRRRR" = Fma > Add 1 > Max 0 > Div 1 > Max 0 > Min 0,
            "LLRRLLLL" = Select > Mul 1 > Mul 1 > Mul 1 > Mul 1 > Mul 1,
            "LLRRLRR" = Fnma > Max 0 > Sqrt 0 > Fms 1 > Max 0 > Neg 0 > Exp 0,
            "LRRRRLLL" = Max > Log2 0 > Mul 1 > Exp2 0 > Fms 1 > Select 2 > Add 1,
            "LRLRRRLR" = Sqrt > Max 0 > Div 1 > Add 1 > Max 0 > Min 0 > Select 1,
            "LLRRLLRR" = Div > Max 0 > Min 0 > Acos 0 > Sub 0 > Div 0 > Max 0 > Min 0,
            "LR" = Abs > Sub 1,
            "RLL" = Add > Div 1,
            "LLLR" = Add > Fma 1,
            "RLL" = Add > Mul 1,
            "LLLL" = Add > Select 2,
            "RL" = Add > Sqrt 0,
            "LL" = And > BNot 0,
            "LL" = BNot > Or 1,
            "LLR" = Div > Min 0,
            "RLRL" = FEq > Select 0,
            "LR" = FLe > BNot 0,
            "RLRL" = Fma > Add 1,
            "LLRR" = Fma > Div 1,
            "LLRRR" = Fma > Fma 1,
            "LLRLR" = Fma > Fms 1,
            "RLLL" = Fma > Min 0,
            "LLLLL" = Fma > Select 2,
            "RLL" = Fms > Abs 0,
            "RLRLR" = Fms > Fma 1,
            "LLRLR" = Fms > Fma 1,
            "LLR" = Max > Div 1,
            "LLL" = Max > Mul 1,
            "LRL" = Min > Mul 1,
            "LLL" = Mul > Div 0,
            "LLL" = Mul > Div 1,
            "RLRR" = Mul > Fma 1,
            "RLL" = Mul > Max 1,
            "RLR" = Mul > Min 0,
            "LLLR" = Mul > Select 1,
            "RL" = Mul > Sqrt 0,
            "LLLL" = Select > Mul 1,
            "LLRL" = Select > Mul 1,
            "LLLR" = Select > Mul 1,
            "LLLLL" = Select > Select 1,
            "LL" = Sqrt > Max 1,
            "RLL" = Sub > Div 0,
            "LLLL" = Sub > Select 1,
            "RLRR" = Add > Max 0 > Min 0,
            "LLRRL" = Add > Mul 1 > Fma 2,
            "LLRLL" = Add > Mul 1 > Fms 2,
            "LLRL" = Add > Mul 1 > Mul 1,
            "RLRR" = Div > Sub 0 > Max 0,
            "LRLRL" = FLt > And 1 > Select 0,
            "RLRLRLR" = Fma > Fma 1 > Fma 1,
            "LLRLRL" = Fma > Fma 1 > Mul 1,
            "RLRLLL" = Fma > Fma 1 > Mul 1,
            "LLRLLL" = Fma > Fma 2 > Mul 1,
            "RLRLL" = Fma > Mul 1 > Div 0,
            "RLRLR" = Fma > Mul 1 > Mul 1,
            "LLRLRLR" = Fms > Fma 1 > Fma 1,
            "LRRLR" = Max > Min 0 > Select 2,
            "RLLL" = Mul > Div 0 > Add 1,
            "LLLLLL" = Mul > Fms 2 > Select 1,
            "LLLRL" = Mul > Mul 1 > Fms 1,
            "LLRL" = Mul > Mul 1 > Mul 1,
            "LLLR" = Mul > Mul 1 > Mul 1,
            "LL" = Neg > Exp 0 > Mul 1,
            "LR" = Neg > Mul 1 > Exp 0,
            "LLL" = Neg > Mul 1 > Mul 1,
            "LLLL" = Select > Sub 0 > Abs 0,
            "RLRL" = Sub > Mul 1 > Mul 1,
            "RLLLR" = Sub > Mul 1 > Select 1,
            "RLL" = Sub > Mul 1 > Sqrt 0,
            "LLRLRLL" = Fma > Fma 1 > Mul 1 > Mul 1,
            "RLRRLRLL" = Fma > Fma 2 > Mul 1 > Fms 2,
            "RLLLRL" = Mul > Fma 1 > Mul 1 > Div 0,
            "RLRLRLL" = Mul > Fma 2 > Fma 2 > Mul 1,
            "RLRLRL" = Mul > Fma 2 > Fma 2 > Neg 0,
            "RLRLRLL" = Mul > Fma 2 > Mul 1 > Fma 1,
            "LLLLLLL" = Mul > Fma 2 > Mul 1 > Fma 2,
            "LRL" = Neg > Exp 0 > Sub 1 > Mul 1,
            "LLRLRLLL" = Fma > Fma 1 > Mul 1 > Mul 1 > Mul 1,
            "RLRLRL" = Mul > Fma 2 > Fma 2 > Neg 0 > Exp 0,
            "RLLLLLR" = Mul > Mul 1 > Mul 1 > Mul 1 > Select 1,
            "RLRLRLR" = Fms > Fma 1 > Fms 1,
            "LLRLRLR" = Fma > Fma 1 > Mul 1 > Mul 1 > Exp 0,
            "LL" = Abs > Mul 1,
            "LLL" = Fms > Abs 0,
            "RLLL" = Fms > Abs 0 > Mul 1,
            "LLLL" = Fms > Abs 0 > Mul 1,
            "LLL" = Min > Min 1,
            "RLR" = Sub > Max 1,
            "RLR" = Sub > Max 1 > Sqrt 0,
            "LLRRLRLL" = Add > Mul 1 > Fma 2 > Mul 1 > Fma 1,
            "RLRLRLLR" = Mul > Fma 2 > Mul 1 > Fma 1 > Mul 1,
            "RLLL" = Fms > Mul 1,
            "LLR" = Mul > Max 1 > Sqrt 0,
            "RLRLRLL" = Mul > Fma 2 > Fma 2 > Neg 0 > Exp 0 > Mul 1,
            "RLRLRLLL" = Mul > Fma 2 > Fma 2 > Neg 0 > Exp 0 > Mul 1 > Mul 1,
            "LR" = Neg > Exp 0 > Sub 1,
            "LLLLL" = Sub > Select 1 > Sub 0 > Abs 0,
            "LLLLLLL" = Mul > Fma 1 > Mul 1 > Fma 2,
            "LLL" = Neg > Exp 0 > Fma 1,
            "LLRLRLL" = Fma > Fma 1 > Fms 1,
            "LLLRL" = Fnma > Div 0 > Sub 0,
            "RLRLL" = Sub > Fma 1 > Mul 1,
            "LL" = Mul > Neg 0 > Exp 0,
            "RLLRLL" = Sub > Mul 1 > Mul 1 > Fma 2,
            "LR" = Max > Sqrt 0 > Neg 0,
            "LRL" = Max > Sqrt 0 > Mul 1,
            "LLLR" = And > Select 0,
            "LLLRLL" = Select > Mul 1 > Fma 2,
            "RLLLLR" = Mul > Fma 2 > Select 2,
            "LLLL" = Mul > Div 1 > Sub 0 > Abs 0,
            "LLRLRLLR" = Fma > Fma 1 > Mul 1 > Mul 1 > Mul 1,
            "RLRL" = Mul > Fma 1,
            "LLLR" = Fma > Mul 1,
            "LLR" = Min > FLt 0,
            "RLLRRRR" = Fma > Max 0 > Fma 1 > Div 1,
            "LR" = Div > Sqrt 0,
            "RLLLLL" = Mul > Div 0 > Add 1 > Select 2,
            "RLRLRLR" = Mul > Fma 2 > Fma 2 > Div 0,
            "LRL" = Max > InverseSqrt 0 > Mul 1,
            "LLLLR" = Mul > Fma 2 > Mul 1,
            "RLRLLR" = Sub > Mul 1 > Mul 1 > Fma 1,
            "LLLLLL" = Add > Mul 1 > Mul 1 > Fma 2,
            "RLLLRR" = Fma > Mul 1 > Fma 1,
            "LLRR" = Select > Mul 1,
            "LL" = Add > Sqrt 0,
            "RLRLLRR" = FEq > Select 0 > Atan2 1 > Fma 1,
            "LLRR" = Atan2 > Fnma 1,
            "LLRLLR" = Select > Select 1 > Mul 1,
            "LLL" = Sub > Add 1,
            "LLRLRLLL" = Fma > Fma 1 > Fms 1 > Abs 0 > Mul 1,
            "LLLR" = Fnma > Div 0,
            "RLRLLL" = Select > Fms 2 > Abs 0 > Mul 1 > Exp 0,
            "RLR" = Sub > Max 0,
            "RLRL" = Sub > Max 0 > Sqrt 0 > Mul 1,
            "RLRR" = IAdd > UMin 0 > IMul 1,
            "RLRL" = Mul > Min 0 > Mul 1,
            "RLRLLRR" = Sub > Fma 1 > Mul 1 > Fma 1,
            "LLLL" = Add > Mul 1 > Mul 1,
            "LLLLLLLR" = Add > Fma 1 > Mul 1 > Fma 1 > Mul 1,
            "LLL" = Add > Sub 0 > Abs 0,
            "RLLLR" = Fms > Mul 1 > Max 0 > Sqrt 0,
            "RLRRR" = Fma > Max 0 > Min 0,
            "LLL" = Neg > Select 1,
            "LLRL" = Max > Select 1,
            "RLLR" = Fnma > Div 1,
            "L" = Log > Neg 0,
            "LRLLL" = FLt > Select 0 > Mul 1,
            "LLLL" = Add > Fma 1 > Sqrt 0,
            "LRL" = FLt > Or 1,
            "LLRRLR" = Fnma > Select 1 > Min 0,
            "RLR" = Sub > Max 0 > Sqrt 0 > Neg 0,
            "LR" = Neg > Max 0 > Sqrt 0 > Neg 0,
            "RLLLRLL" = Mul > Fma 1 > Mul 1 > Div 0 > Sub 0 > Abs 0,
            "RLRRLRLL" = Mul > Fma 1 > Add 1 > Mul 1 > Fms 2,
            "LLL" = And > BNot 0 > Or 1,
            "LLLRLLL" = Select > Mul 1 > Mul 1 > Fma 2,
            "LLLL" = And > Select 0,
            "RLLR" = Mul > Sqrt 0 > Max 1 > Div 1,
            "LRL" = Sqrt > Add 1 > Div 1,
            "LR" = Neg > Div 0 > Exp 0,
            "LRR" = Neg > Max 0 > Div 0,
            "LRR" = Div > Min 0,
            "LLRRRL" = Fnma > Mul 1 > Max 0 > InverseSqrt 0 > Mul 1,
            "RLR" = Sub > Max 0 > Sqrt 0,
            "RLLLRLR" = Mul > Fma 1 > Mul 1 > Div 0 > Mul 1,
            "RLRRL" = Fnma > Mul 1 > Div 0,
            "RLLRL" = Add > Mul 1 > Mul 1 > Mul 1,
            "LRLL" = Max > Mul 1 > Div 1,
            "RLLL" = Mul > Mul 1 > Mul 1,
            "RLRLLLR" = Sub > Fma 1 > Mul 1 > Fma 1,
            "LLLR" = Mul > Div 1 > Min 0,
            "RLLR" = Fms > Max 0,
            "LLLRRLLR" = Fma > Sub 0 > Mul 1 > Fms 2 > Max 0 > Sqrt 0,
            "LLR" = Sub > Div 0,
            "RLLR" = Fma > Mul 1,
            "LLLRR" = Mul > Atan2 0 > Fnma 1,
            "RLRLRR" = Fma > Mul 1 > Fnma 1,
            "LLRRR" = Select > Min 0 > Sub 1,
            "LRRR" = Abs > Fma 1 > Div 1,
            "LRL" = FLe > Or 1,
            "RLRRRR" = Fma > Max 0 > Min 0 > Sqrt 0 > Sub 1,
            "RLLLR" = Mul > Mul 1 > Fma 1,
            "LLLLLLRL" = Mul > Fma 2 > Fma 2 > Max 0 > InverseSqrt 0 > Mul 1,
            "RLRR" = Div > Sub 1 > Div 0,
            "LLL" = Fma > Abs 0,
            "RLLLRLLL" = Mul > Fma 1 > Mul 1 > Div 0 > Sub 0 > Abs 0 > Mul 1,
            "LLLLR" = Add > Sub 0 > Abs 0 > Add 1 > Mul 1,
            "RLLL" = Mul > Mul 1 > Max 0,
            "LLLLRL" = Mul > Fma 2 > Sqrt 0 > Max 0 > Div 1,
            "RLRLRLL" = Mul > Fma 2 > Fma 2 > Mul 1 > Exp 0,
            "LLLLLRRL" = Atan2 > Mul 1 > Fma 2 > Mul 1 > Fma 1,
            "LRLLRL" = Div > Sub 1 > Mul 1 > Fma 1,
            "LRLRRR" = Abs > Add 1 > Div 1 > Add 1 > Mul 1 > Min 0,
            "LRR" = Max > UFromF 0 > UMin 0,
            "LRL" = Floor > Min 0 > Sub 1,
            "LLRLR" = Mul > Mul 1 > Fma 1,
            "LLLRLLLR" = Select > Mul 1 > Mul 1 > Max 1 > Fma 1,
            "LLLLRL" = Mul > Fma 2 > Fma 1,
            "LLR" = Sqrt > Mul 1 > Div 1,
            "LLL" = Mul > FLt 1,
        }
    };
}
pub(crate) use with_chains;

macro_rules! table {
    ($($kinds:literal = $first:ident $(> $op:ident $chained:literal)+,)*) => {
        const TABLE: &[(&[FusedOp], &str)] = &[$((
            &[FusedOp { op: Op::$first, chained_operand: 0 } $(, FusedOp { op: Op::$op, chained_operand: $chained })+],
            $kinds,
        ),)*];
    };
}
with_chains!(table);

/// Every chain that has a kernel, with the kinds of its operands in the notation of [`kind_bits`].
pub fn all() -> &'static [(&'static [FusedOp], &'static str)] {
    TABLE
}

/// Number of operands of a chain. Each operation after the first takes the previous result for one of its operands, which is not counted.
pub fn operand_count(ops: &[FusedOp]) -> usize {
    ops.iter().map(|fused| fused.op.arity()).sum::<usize>() + 1 - ops.len().max(1)
}

/// Index in [`all`] of the chain of these operations for operands of these kinds ([`kind_bits`]); `None` if no kernel computes it.
pub fn find(ops: &[FusedOp], kinds: u8) -> Option<usize> {
    static INDEX: LazyLock<HashMap<(&'static [FusedOp], u8), usize>> =
        LazyLock::new(|| TABLE.iter().enumerate().map(|(k, (ops, kinds))| ((*ops, kind_bits(kinds)), k)).collect());
    // A separate function shortens the lifetime of the keys to that of `ops`.
    fn lookup<'a>(index: &HashMap<(&'a [FusedOp], u8), usize>, ops: &'a [FusedOp], kinds: u8) -> Option<usize> {
        index.get(&(ops, kinds)).copied()
    }
    lookup(&INDEX, ops, kinds)
}

/// A chain as a type, built of [`First`] and [`Then`], with the function that evaluates it on one lane.
pub(crate) trait FusedKernel {
    /// Number of operands.
    const OPERANDS: usize;
    fn eval<R: Real, const N: usize, const FMA: bool>(operands: &[KernelOperand<'_, R, N>; MAX_OPERANDS], lane: usize) -> R;
}

/// The first operation.
pub(crate) struct First<A>(A);
/// The chain `P` and one further operation `B`, whose operand number `CHAINED` is the chain's result.
pub(crate) struct Then<P, B, const CHAINED: usize>(P, B);

impl<A: Eval> FusedKernel for First<A> {
    const OPERANDS: usize = A::ARITY;
    #[inline(always)]
    fn eval<R: Real, const N: usize, const FMA: bool>(operands: &[KernelOperand<'_, R, N>; MAX_OPERANDS], lane: usize) -> R {
        // Arguments beyond the arity are ignored; any operand can stand in for them.
        let last = A::ARITY - 1;
        A::eval::<R, FMA>(operands[0].at(lane), operands[if last < 1 { last } else { 1 }].at(lane), operands[last].at(lane))
    }
}

impl<P: FusedKernel, B: Eval, const CHAINED: usize> FusedKernel for Then<P, B, CHAINED> {
    const OPERANDS: usize = P::OPERANDS + B::ARITY - 1;
    #[inline(always)]
    fn eval<R: Real, const N: usize, const FMA: bool>(operands: &[KernelOperand<'_, R, N>; MAX_OPERANDS], lane: usize) -> R {
        let chained = P::eval::<R, N, FMA>(operands, lane);
        let next = if B::ARITY > 1 { operands[P::OPERANDS].at(lane) } else { chained };
        let last = if B::ARITY > 2 { operands[P::OPERANDS + 1].at(lane) } else { chained };
        match CHAINED {
            0 => B::eval::<R, FMA>(chained, next, last),
            1 => B::eval::<R, FMA>(next, chained, last),
            _ => B::eval::<R, FMA>(next, last, chained),
        }
    }
}

/// Runs a chain over `N` lanes. `KINDS`: as [`kind_bits`].
/// # Safety
/// `offsets` has the offset of every operand from `base`, in elements. Each operand is valid for `N` reads, or for one if its bit in `KINDS`
/// is not set. No operand overlaps `dst`.
#[inline(always)]
pub(crate) unsafe fn run_lanes<C: FusedKernel, R: Real, const N: usize, const KINDS: u8, const FMA: bool>(
    dst: &mut [R; N],
    base: *const R,
    offsets: *const u32,
) {
    macro_rules! operand {
        ($k:literal) => {{
            // Unused operands repeat the first operand.
            let k = if $k < C::OPERANDS { $k } else { 0 };
            // SAFETY: the caller guarantees that the offset and the operand are valid.
            unsafe { KernelOperand::<R, N>::new(base.add(*unchecked_ref(offsets.add(k)) as usize), KINDS >> k & 1 == 1) }
        }};
    }
    let operands = [operand!(0), operand!(1), operand!(2), operand!(3), operand!(4), operand!(5), operand!(6), operand!(7)];
    const { assert!(N.is_multiple_of(UNROLLED_LANES)) };
    for (k, part) in dst.chunks_exact_mut(UNROLLED_LANES).enumerate() {
        for (lane, result) in part.iter_mut().enumerate() {
            *result = C::eval::<R, N, FMA>(&operands, k * UNROLLED_LANES + lane);
        }
    }
}
