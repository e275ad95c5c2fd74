//! Finds chains of operations, in which each operation is the only reader of the previous operation's result, and divides each chain into the fewest pieces
//! that have a kernel each.
//!
//! In: the SSA instructions after all other optimisations but the last, `merge.rs`. Out: the same instructions, in which a fused kernel of `kernels/chains.rs`
//! replaces each piece of several operations, at the place of the last of them. Always: the operations of a chain come from one basic block, and no variable
//! that one of them reads is assigned between it and the end of the chain.

use super::ssa::{SsaInstr, SsaValue, SsaValues, remove_instrs, use_counts};
use crate::render::software::kernels::chains::{MAX_CHAIN_OPS, MAX_OPERANDS, find};
use crate::render::software::tape::{FusedOp, Op};
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};
use smallvec::smallvec;

/// `chained_operand` (the index of the operand that is the previous operation's result) of the first operation of a chain, which has none. In a further
/// operation the same number means the first operand.
const NO_CHAINED_OPERAND: u8 = 0;

/// One operation of a chain.
#[derive(Clone)]
struct ChainOp {
    /// Index of its instruction.
    index: usize,
    /// The operation, and which of `args` is the previous operation's result.
    fused: FusedOp,
    /// All operands, including the previous operation's result.
    args: SsaValues,
}

/// Fuses lane operations into chains, and replaces each chain by as few kernels (`FusedKernel` instructions and single operations) as possible. `outputs`: the
/// program's outputs, which count as uses.
pub(crate) fn fuse_chains(code: &mut Vec<SsaInstr>, outputs: &[SsaValue]) {
    fold_negations(code, outputs);
    let uses = use_counts(code, outputs);
    // Chains of this basic block to which an operation may still be appended. Key: the chain's result so far, which has exactly one use.
    let mut open_chains: HashMap<SsaValue, Vec<ChainOp>> = HashMap::default();
    let mut closed_chains: Vec<Vec<ChainOp>> = Vec::new();
    for (index, instr) in code.iter().enumerate() {
        match instr {
            SsaInstr::Assign { dst, .. } => {
                // A chain that reads the variable's old value must end before this instruction.
                let ended: Vec<SsaValue> =
                    open_chains.iter().filter(|(_, c)| c.iter().any(|op| op.args.contains(dst))).map(|(v, _)| *v).collect();
                closed_chains.extend(ended.iter().filter_map(|v| open_chains.remove(v)));
            }
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op, args } => {
                // The chains that this operation may continue, each with the operation appended.
                let candidates = args.iter().enumerate().filter_map(|(position, v)| {
                    let mut chain = open_chains.get(v)?.clone();
                    let (fused, args) = commuted(FusedOp { op: *op, chained_operand: position as u8 }, args);
                    chain.push(ChainOp { index, fused, args });
                    // Prefer a chain that needs no more kernels with this operation than without it; then the longest.
                    let adds_no_kernel = kernel_count(&chain) == kernel_count(&chain[..chain.len() - 1]);
                    Some(((adds_no_kernel, chain.len()), *v, chain))
                });
                let chain = match candidates.max_by_key(|(benefit, ..)| *benefit) {
                    Some((_, v, chain)) => {
                        open_chains.remove(&v);
                        chain
                    }
                    None => vec![ChainOp { index, fused: FusedOp { op: *op, chained_operand: NO_CHAINED_OPERAND }, args: args.clone() }],
                };
                if uses.get(dst) == Some(&1) {
                    open_chains.insert(*dst, chain);
                } else {
                    closed_chains.push(chain);
                }
            }
            other if other.is_control_flow() => {
                closed_chains.extend(std::mem::take(&mut open_chains).into_values());
            }
            _ => {}
        }
    }
    closed_chains.extend(open_chains.into_values());
    let mut removed = HashSet::default();
    for chain in &closed_chains {
        for piece in split(chain).into_iter().filter(|p| p.len() > 1) {
            // `has_kernel` holds for a piece, so its operands are not too many.
            let (Some((operands, _kinds)), Some(last)) = (operands(piece), piece.last()) else { continue };
            let SsaInstr::Op { dst, .. } = code[last.index] else { continue };
            let ops = fused_ops(piece);
            code[last.index] = SsaInstr::FusedKernel { dst, ops, args: operands };
            removed.extend(piece[..piece.len() - 1].iter().map(|op| op.index));
        }
    }
    remove_instrs(code, &removed);
}

/// Folds the negation of a factor into the only reader, a fused multiply-add, which becomes `Fnma`: -a * b + c is exactly c - a * b.
fn fold_negations(code: &mut Vec<SsaInstr>, outputs: &[SsaValue]) {
    let uses = use_counts(code, outputs);
    // Index of each negation, and its operand, by its result.
    let mut negations: HashMap<SsaValue, (usize, SsaValue)> = HashMap::default();
    let mut removed = HashSet::default();
    for (index, instr) in code.iter_mut().enumerate() {
        match instr {
            // A negation of the old value of `dst` stays an operation of its own.
            SsaInstr::Assign { dst, .. } => negations.retain(|_, (_, a)| *a != *dst),
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op: Op::Neg, args } if uses.get(dst) == Some(&1) => {
                negations.insert(*dst, (index, args[0]));
            }
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op: Op::Fma, args } => {
                let found = (0..2).find_map(|position| Some((position, *negations.get(&args[position])?)));
                let Some((position, (negation, factor))) = found else { continue };
                // Sorted as in the table of chains: a factor that all lanes share comes before one with one element per lane.
                let mut factors = [factor, args[1 - position]];
                factors.sort();
                removed.insert(negation);
                *instr = SsaInstr::Op { dst: *dst, op: Op::Fnma, args: smallvec![factors[0], factors[1], args[2]] };
            }
            other if other.is_control_flow() => {
                negations.clear();
            }
            _ => {}
        }
    }
    remove_instrs(code, &removed);
}

/// Swaps the first two operands, if they are interchangeable, so that the previous result is second. The table of chains has only this order, which halves the
/// number of its kernels.
fn commuted(op: FusedOp, args: &[SsaValue]) -> (FusedOp, SsaValues) {
    let mut args = SsaValues::from_slice(args);
    if op.chained_operand == 0 && matches!(op.op, Op::Mul | Op::Add | Op::And | Op::Or | Op::Fma | Op::Fms | Op::Fnma) {
        args.swap(0, 1);
        return (FusedOp { chained_operand: 1, ..op }, args);
    }
    (op, args)
}

/// The operands of a piece of a chain, and their kinds: bit k is set if operand k has one value per lane (`kernels::chains::kind_bits`). The operands of the
/// first operation come first, then those of each further operation without the previous result. `None` if there are more than [`MAX_OPERANDS`].
fn operands(piece: &[ChainOp]) -> Option<(SsaValues, u8)> {
    let mut all = piece.first()?.args.clone();
    for op in &piece[1..] {
        all.extend(op.args.iter().enumerate().filter(|(k, _)| *k != usize::from(op.fused.chained_operand)).map(|(_, v)| *v));
    }
    if all.len() > MAX_OPERANDS {
        return None;
    }
    let kinds = all.iter().enumerate().map(|(k, v)| u8::from(matches!(v, SsaValue::Lane(_))) << k).sum();
    Some((all, kinds))
}

/// The operations of a piece of a chain. The first has no chained operand in this piece.
fn fused_ops(piece: &[ChainOp]) -> Vec<FusedOp> {
    piece
        .iter()
        .enumerate()
        .map(|(k, op)| FusedOp { chained_operand: if k == 0 { NO_CHAINED_OPERAND } else { op.fused.chained_operand }, ..op.fused })
        .collect()
}

/// Whether one kernel computes this piece.
fn has_kernel(piece: &[ChainOp]) -> bool {
    if piece.len() == 1 {
        return true;
    }
    operands(piece).is_some_and(|(_, kinds)| find(&fused_ops(piece), kinds).is_some())
}

/// Splits a chain into the fewest pieces that have a kernel each, by dynamic programming.
fn split(chain: &[ChainOp]) -> Vec<&[ChainOp]> {
    // Entry k: the fewest kernels for the first k operations, and the start of the last of their pieces.
    let mut best = vec![(0, 0)];
    for end in 1..=chain.len() {
        let starts = (end.saturating_sub(MAX_CHAIN_OPS)..end).filter(|start| has_kernel(&chain[*start..end]));
        let kernels_before = |start: usize| best[start].0;
        // A piece of one operation always has a kernel, so there is a start.
        let fewest = starts.map(|start| (kernels_before(start) + 1, start)).min().unwrap_or((end, end - 1));
        best.push(fewest);
    }
    let mut pieces = Vec::new();
    let mut end = chain.len();
    while end > 0 {
        let (_, start) = best[end];
        pieces.push(&chain[start..end]);
        end = start;
    }
    pieces
}

/// The fewest kernels that compute a chain.
fn kernel_count(chain: &[ChainOp]) -> usize {
    split(chain).len()
}
