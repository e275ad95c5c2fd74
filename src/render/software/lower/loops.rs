//! Makes loops cheaper without changing a bit of what they compute.
//!
//! In: the steps after dead code has gone and products have been fused. Out: the same steps, those of a loop that compute the same in every
//! turn before it, and exits from loops by one jump in place of two. Only what every turn computes moves: a step behind a skip stays there, since
//! to run it always may cost more than to run it often.

use super::step::{Label, Step, Val, reads, writes};
use crate::render::software::tape::Op;
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};

/// Moves what does not change from turn to turn before its loop, from the innermost loops outward.
pub fn hoist(code: &mut [Step]) {
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

/// The loop that begins at `start` and ends at `end`; what leaves it stands right before it, so `end` stays where it is.
fn hoist_one(code: &mut [Step], start: usize, end: usize) {
    let mut changing: HashSet<Val> = code[start..end].iter().flat_map(writes).collect();
    let inside: HashSet<Label> =
        code[start..end].iter().filter_map(|step| if let Step::Label(l) = step { Some(*l) } else { None }).collect();
    // Labels of the skips that are open. A jump out of the loop opens none: what follows is run in every turn that comes so far.
    let mut skips: Vec<Label> = Vec::new();
    let mut inner = 0;
    let mut leaving = HashSet::default();
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
                leaving.insert(at);
            }
            _ => {}
        }
    }
    if leaving.is_empty() {
        return;
    }
    let (before, body): (Vec<_>, Vec<_>) = code[start..end].iter().cloned().enumerate().partition(|(k, _)| leaving.contains(&(start + k)));
    for (to, (_, step)) in code[start..end].iter_mut().zip(before.into_iter().chain(body)) {
        *to = step;
    }
}

/// A jump over a jump becomes one with the opposite condition, and a condition that was negated for it the one before.
pub fn straighten(code: &mut Vec<Step>) {
    let opposite: HashMap<Val, Val> = code
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
            && let Some(before) = opposite.get(cond).filter(|v| !assigned.contains(v))
        {
            (*cond, *when) = (*before, !*when);
        }
    }
    let over = |w: &[Step]| match w {
        [Step::JumpIf { label: over, .. }, Step::Jump { .. }, Step::Label(next)] => over == next,
        _ => false,
    };
    while let Some(at) = code.windows(3).position(over) {
        if let (Step::JumpIf { cond, when, .. }, Step::Jump { label }) = (&code[at], &code[at + 1]) {
            code[at] = Step::JumpIf { cond: *cond, when: !*when, label: *label };
            code.remove(at + 1);
        }
    }
}
