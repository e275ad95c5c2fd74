//! Loop optimisations that leave every result bit-identical: loop-invariant code motion, and merging of jumps.
//!
//! In: the steps after dead-code elimination and fused multiply-add. Out: the same steps, with loop-invariant steps moved before their loop, and
//! with one jump instead of two at exits from loops. Only steps that every iteration runs are moved. A step that may be skipped is not moved, since
//! running it once for every loop may cost more than running it only when it is needed.

use super::step::{Label, Step, Val, reads, writes};
use crate::render::software::tape::Op;
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};

/// Moves loop-invariant steps before their loop, from the innermost loops outward.
pub(crate) fn hoist(code: &mut [Step]) {
    let mut open = Vec::new();
    let mut at = 0;
    while at < code.len() {
        match &code[at] {
            Step::LoopStart => open.push(at),
            Step::LoopEnd => {
                if let Some(start) = open.pop() {
                    hoist_one(code, start, at);
                }
            }
            _ => {}
        }
        at += 1;
    }
}

/// Hoists steps out of the loop that begins at `start` and ends at `end`. They are placed directly before the loop, so `end` does not change.
fn hoist_one(code: &mut [Step], start: usize, end: usize) {
    let mut changing: HashSet<Val> = code[start..end].iter().flat_map(writes).collect();
    let inside: HashSet<Label> =
        code[start..end].iter().filter_map(|step| if let Step::Label(l) = step { Some(*l) } else { None }).collect();
    // Labels of the skips that are open at a step. A jump out of the loop is not a skip: every iteration that continues runs the steps after it.
    let mut skips: Vec<Label> = Vec::new();
    let mut inner = 0;
    let mut hoisted = HashSet::default();
    for (at, step) in code.iter().enumerate().take(end).skip(start + 1) {
        match step {
            Step::SkipIfNone { label, .. } | Step::JumpIf { label, .. } | Step::Jump { label } => {
                skips.extend(inside.get(label));
            }
            Step::Label(label) => skips.retain(|l| l != label),
            Step::LoopStart => inner += 1,
            Step::LoopEnd => inner -= 1,
            Step::Op { dst, .. } | Step::LoadUniform { dst, .. }
                if inner == 0 && skips.is_empty() && reads(step).iter().all(|v| !changing.contains(v)) =>
            {
                changing.remove(dst);
                hoisted.insert(at);
            }
            _ => {}
        }
    }
    if hoisted.is_empty() {
        return;
    }
    let (before, body): (Vec<_>, Vec<_>) = code[start..end].iter().cloned().enumerate().partition(|(k, _)| hoisted.contains(&(start + k)));
    for (to, (_, step)) in code[start..end].iter_mut().zip(before.into_iter().chain(body)) {
        *to = step;
    }
}

/// Replaces a conditional jump over a jump by one jump with the opposite condition, and a jump on `!x` by the opposite jump on `x`.
pub(crate) fn merge_jumps(code: &mut Vec<Step>) {
    let negation_of: HashMap<Val, Val> = code
        .iter()
        .filter_map(|step| match step {
            Step::Op { dst: dst @ Val::Uniform(_), op: Op::BNot, args } => Some((*dst, args[0])),
            _ => None,
        })
        .collect();
    let assigned: HashSet<Val> =
        code.iter().filter_map(|step| if let Step::Assign { dst, .. } = step { Some(*dst) } else { None }).collect();
    for step in code.iter_mut() {
        if let Step::JumpIf { cond, when, .. } = step
            && let Some(negated) = negation_of.get(cond).filter(|v| !assigned.contains(v))
        {
            (*cond, *when) = (*negated, !*when);
        }
    }
    let jumps_over_jump = |w: &[Step]| match w {
        [Step::JumpIf { label, .. }, Step::Jump { .. }, Step::Label(next)] => label == next,
        _ => false,
    };
    while let Some(at) = code.windows(3).position(jumps_over_jump) {
        if let (Step::JumpIf { cond, when, .. }, Step::Jump { label }) = (&code[at], &code[at + 1]) {
            code[at] = Step::JumpIf { cond: *cond, when: !*when, label: *label };
            code.remove(at + 1);
        }
    }
}
