//! Joins operations into chains: each takes the result of the one before, which nothing else reads, and one kernel computes them all.
//!
//! In: the steps after everything else has been done to them. Out: the same with chains, as few kernels as those of `kernels/chains.rs` allow. A
//! chain stands where its last operation stood, inside one straight piece of code, and no loop variable that it reads changes between.

use super::step::{Step, Val, Vals, reads};
use crate::render::software::kernels::chains::{MAX_LINKS, MAX_OPERANDS, find};
use crate::render::software::tape::{FusedOp, Op};
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};
use smallvec::smallvec;

/// One operation of a chain that may grow.
#[derive(Clone)]
struct Item {
    /// Where it stands in the code.
    place: usize,
    link: FusedOp,
    args: Vals,
}

pub fn join(code: &mut Vec<Step>, outputs: &[Val]) {
    negations(code, outputs);
    let uses = uses(code, outputs);
    // Chains of this straight piece whose last result has one reader, by that result.
    let mut open: HashMap<Val, Vec<Item>> = HashMap::default();
    let mut closed: Vec<Vec<Item>> = Vec::new();
    for (place, step) in code.iter().enumerate() {
        match step {
            Step::Assign { dst, .. } => {
                let stale: Vec<Val> = open.iter().filter(|(_, c)| c.iter().any(|i| i.args.contains(dst))).map(|(v, _)| *v).collect();
                closed.extend(stale.iter().filter_map(|v| open.remove(v)));
            }
            Step::Op { dst: dst @ Val::Lane(_), op, args } => {
                let grown = args.iter().enumerate().filter_map(|(at, v)| {
                    let mut chain = open.get(v)?.clone();
                    let (link, args) = turned(FusedOp { op: *op, at: at as u8 }, args);
                    chain.push(Item { place, link, args });
                    // What joins without a kernel of its own; of those the longest.
                    let free = kernels_of(&chain) == kernels_of(&chain[..chain.len() - 1]);
                    Some(((free, chain.len()), *v, chain))
                });
                let chain = match grown.max_by_key(|(worth, ..)| *worth) {
                    Some((_, v, chain)) => {
                        open.remove(&v);
                        chain
                    }
                    None => vec![Item { place, link: FusedOp { op: *op, at: 0 }, args: args.clone() }],
                };
                if uses.get(dst) == Some(&1) {
                    open.insert(*dst, chain);
                } else {
                    closed.push(chain);
                }
            }
            Step::SkipIfNone { .. } | Step::JumpIf { .. } | Step::Jump { .. } | Step::Label(_) | Step::LoopStart | Step::LoopEnd => {
                closed.extend(std::mem::take(&mut open).into_values());
            }
            _ => {}
        }
    }
    closed.extend(open.into_values());
    let mut gone = HashSet::default();
    for chain in &closed {
        for piece in cut(chain).into_iter().filter(|p| p.len() > 1) {
            let (Some((operands, _)), Some(last)) = (operands(piece), piece.last()) else { continue };
            let Step::Op { dst, .. } = code[last.place] else { continue };
            let links = piece.iter().enumerate().map(|(k, i)| FusedOp { at: if k == 0 { 0 } else { i.link.at }, ..i.link }).collect();
            code[last.place] = Step::FusedKernel { dst, links, args: operands };
            gone.extend(piece[..piece.len() - 1].iter().map(|i| i.place));
        }
    }
    let mut place = 0;
    code.retain(|_| {
        place += 1;
        !gone.contains(&(place - 1))
    });
}

fn uses(code: &[Step], outputs: &[Val]) -> HashMap<Val, u32> {
    let mut uses: HashMap<Val, u32> = HashMap::default();
    for v in code.iter().flat_map(reads).chain(outputs.iter().copied()) {
        *uses.entry(v).or_default() += 1;
    }
    uses
}

/// A negated factor of a sum of products: the sign changes no bit wherever it stands, so it goes into the operation.
fn negations(code: &mut Vec<Step>, outputs: &[Val]) {
    let uses = uses(code, outputs);
    let mut negated: HashMap<Val, (usize, Val)> = HashMap::default();
    let mut gone = HashSet::default();
    for (place, step) in code.iter_mut().enumerate() {
        match step {
            Step::Assign { dst, .. } => negated.retain(|_, (_, a)| *a != *dst),
            Step::Op { dst: dst @ Val::Lane(_), op: Op::Neg, args } if uses.get(dst) == Some(&1) => {
                negated.insert(*dst, (place, args[0]));
            }
            Step::Op { dst: dst @ Val::Lane(_), op: Op::Fma, args } => {
                let Some((at, (from, factor))) = (0..2).find_map(|at| Some((at, *negated.get(&args[at])?))) else { continue };
                // A value for all lanes stands first, as the chains have it.
                let mut factors = [factor, args[1 - at]];
                factors.sort();
                gone.insert(from);
                *step = Step::Op { dst: *dst, op: Op::Fnma, args: smallvec![factors[0], factors[1], args[2]] };
            }
            Step::SkipIfNone { .. } | Step::JumpIf { .. } | Step::Jump { .. } | Step::Label(_) | Step::LoopStart | Step::LoopEnd => {
                negated.clear();
            }
            _ => {}
        }
    }
    let mut place = 0;
    code.retain(|_| {
        place += 1;
        !gone.contains(&(place - 1))
    });
}

/// Where the operands of a product or sum may change places, the chain's result stands second: half as many kernels serve.
fn turned(link: FusedOp, args: &[Val]) -> (FusedOp, Vals) {
    let mut args = Vals::from_slice(args);
    if link.at == 0 && matches!(link.op, Op::Mul | Op::Add | Op::And | Op::Or | Op::Fma | Op::Fms | Op::Fnma) {
        args.swap(0, 1);
        return (FusedOp { at: 1, ..link }, args);
    }
    (link, args)
}

/// The operands of a piece of a chain and their kinds: the first's, then the rest of each further one's.
fn operands(piece: &[Item]) -> Option<(Vals, u8)> {
    let mut all = piece.first()?.args.clone();
    for item in &piece[1..] {
        all.extend(item.args.iter().enumerate().filter(|(k, _)| *k != usize::from(item.link.at)).map(|(_, v)| *v));
    }
    if all.len() > MAX_OPERANDS {
        return None;
    }
    let kinds = all.iter().enumerate().map(|(k, v)| u8::from(matches!(v, Val::Lane(_))) << k).sum();
    Some((all, kinds))
}

/// Whether one kernel computes this piece.
fn served(piece: &[Item]) -> bool {
    if piece.len() == 1 {
        return true;
    }
    let links: Vec<FusedOp> = piece.iter().enumerate().map(|(k, i)| FusedOp { at: if k == 0 { 0 } else { i.link.at }, ..i.link }).collect();
    operands(piece).is_some_and(|(_, kinds)| find(&links, kinds).is_some())
}

/// The pieces of the cheapest cut: fewest kernels.
fn cut(chain: &[Item]) -> Vec<&[Item]> {
    // For each length: the fewest kernels for so many operations, and where the last one begins.
    let mut best = vec![(0, 0)];
    for end in 1..=chain.len() {
        let starts = (end.saturating_sub(MAX_LINKS)..end).filter(|start| served(&chain[*start..end]));
        best.push(starts.map(|start| (best[start].0 + 1, start)).min().unwrap_or((end, end - 1)));
    }
    let mut pieces = Vec::new();
    let mut end = chain.len();
    while end > 0 {
        let start = best[end].1;
        pieces.push(&chain[start..end]);
        end = start;
    }
    pieces
}

fn kernels_of(chain: &[Item]) -> usize {
    cut(chain).len()
}
