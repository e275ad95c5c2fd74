//! Pairs of operations in one kernel: the second takes the first's result without a store and a load between.
//!
//! In: up to five operands, those of the first operation and then the rest of the second's. Out: what the two kernels would give one after
//! the other, bit for bit, because each operation still rounds by itself. Which pairs there are was chosen by what the atmosphere, eclipse and
//! map code of planets asks for; the lowering asks [`known`] and leaves every other pair apart.

use super::Input;
use super::ops::Eval;
use crate::render::software::math::Real;
use crate::render::software::tape::{Op, Pair};

/// Most operands of a pair.
pub const MOST_OPERANDS: usize = 5;

/// Operand kinds as bits, the first operand lowest: L = one value per lane, R = one value for all lanes.
pub const fn mask(kinds: &str) -> u8 {
    let (kinds, mut bits, mut k) = (kinds.as_bytes(), 0, 0);
    while k < kinds.len() {
        if kinds[k] == b'L' {
            bits |= 1 << k;
        }
        k += 1;
    }
    bits
}

/// First operation, second operation, which operand of the second the first's result is, and the kinds of operands served.
macro_rules! with_pairs {
    ($m:ident) => {
        $m! {
            Mul Exp 0 ["RL" "LL"],
            Neg Exp 0 ["L"],
            Mul Mul 1 ["RLL" "RLR" "LLL" "LLR"],
            Mul Fma 0 ["RLLL" "LLLL"],
            Mul Fma 1 ["RLLL" "LLLL"],
            Mul Fma 2 ["RLRL" "LLLL" "RLLL" "LLRL"],
            Fma Fma 0 ["LLLLL" "RLRLR"],
            Fma Fma 1 ["LLLLL" "RLRLR" "LLRLR"],
            Fma Fma 2 ["LLLLL" "RLLRL" "RLRRL"],
            Fma Sqrt 0 ["LLL"],
            Fma Div 0 ["RLLL" "LLLL"],
            Fma Div 1 ["RLRR" "RLRL"],
            Fma Max 0 ["LLLR" "RLLR"],
            Fma Mul 1 ["RLRL" "RLLL" "LLLL"],
            Fnma Div 1 ["RLRR"],
            Fnma Max 0 ["LLRR"],
            Fms Max 0 ["LLRR" "LLLR"],
            Add Sub 0 ["RLL" "LLL"],
            Sub Div 0 ["LLL" "LRR" "LRL"],
            Sub Max 0 ["LRR" "LLR"],
            Sub Mul 1 ["LRR" "LLL" "LRL"],
            Max Min 0 ["LRR"],
            Max Sqrt 0 ["LR"],
            Max Mul 1 ["LRR" "LRL"],
            Div Max 0 ["LLR" "RLR" "LRR"],
            Div Mul 1 ["RLL"],
            Mul Max 0 ["RLR" "LLR"],
            Select Fma 1 ["LLLRL"],
            FLe And 1 ["RLL" "LRL" "LLL"],
            FLt And 1 ["RLL" "LRL" "LLL"],
            BNot And 1 ["LL"],
        }
    };
}
pub(crate) use with_pairs;

macro_rules! known_table {
    ($($first:ident $second:ident $at:literal [$($kinds:literal)*],)*) => {
        const TABLE: &[(Pair, &str)] = &[$($((Pair { first: Op::$first, second: Op::$second, at: $at }, $kinds),)*)*];
    };
}
with_pairs!(known_table);

/// Every pair with the kinds of operands that it serves, as [`mask`] reads them.
pub fn all() -> &'static [(Pair, &'static str)] {
    TABLE
}

/// Whether there is a kernel for this pair and these kinds of operands.
pub fn known(pair: Pair, operands: usize, kinds: u8) -> bool {
    TABLE.iter().any(|(p, k)| *p == pair && k.len() == operands && mask(k) == kinds)
}

/// `TAKES`: operands of the first operation. `AT`: the place of its result among the second's. `KINDS`: as [`mask`]. `F`: fused.
/// # Safety
/// Every operand is valid for `N` reads, or one where its bit is not set or it is not used; none overlaps `dst`.
#[inline(always)]
pub unsafe fn lanes<A: Eval, B: Eval, R: Real, const N: usize, const TAKES: usize, const AT: usize, const KINDS: u8, const F: bool>(
    dst: &mut [R; N],
    operands: [*const R; MOST_OPERANDS],
) {
    let [a, b, c, d, e] = operands;
    // SAFETY: the caller vouches for one read of each operand, and for N of those whose bit is set.
    let new = |p: *const R, k: usize| unsafe { Input::<R, N>::new(p, KINDS >> k & 1 == 1) };
    let inputs = [new(a, 0), new(b, 1), new(c, 2), new(d, 3), new(e, 4)];
    for (i, to) in dst.iter_mut().enumerate() {
        let last = TAKES - 1;
        let v = A::eval::<R, F>(inputs[0].at(i), inputs[if last < 1 { last } else { 1 }].at(i), inputs[last].at(i));
        let (r, s) = (inputs[TAKES].at(i), inputs[TAKES + 1].at(i));
        *to = match AT {
            0 => B::eval::<R, F>(v, r, s),
            1 => B::eval::<R, F>(r, v, s),
            _ => B::eval::<R, F>(r, s, v),
        };
    }
}
