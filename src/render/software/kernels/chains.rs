//! Chains of operations, each in one SIMD kernel: an operation uses the result of the previous one without a store and a load in between.
//!
//! In: up to [`MAX_OPERANDS`] operands: the operands of the first operation, then those of each further operation except the previous result. Out: the same
//! bits as from the kernels of the single operations run in order, because each operation still rounds separately. The lowering calls
//! [`find`], and splits a chain that the table lacks into chains of the table and single operations. Not here: the table (`chain_table`).

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

pub(crate) use super::chain_table::with_chains;

// The entries of `with_chains`, in the notation that `chain_table` explains, as a constant.
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

/// Runs a chain over `N` lanes. `KINDS`: as [`kind_bits`]. `FMA`: whether multiply-adds round once.
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
