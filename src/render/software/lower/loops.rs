//! Loop optimisations that leave every result bit-identical: loop-invariant code motion, and merging of jumps.
//!
//! In: the steps after dead-code elimination and multiply-add fusion. Out: the same steps, with loop-invariant steps moved before their loop, and
//! with one jump instead of two at exits from loops. Only steps that every complete iteration runs are moved. A step that may be skipped is not moved:
//! running it once before the loop may cost more than running it only where it is needed.

use super::step::{JumpLabel, SsaStep, SsaValue, reads, remove_steps, writes};
use crate::render::software::tape::Op;
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};

/// Moves loop-invariant steps before their loop, from the innermost loops outward.
pub(crate) fn hoist(code: &mut [SsaStep]) {
    let mut loop_starts = Vec::new();
    let mut index = 0;
    while index < code.len() {
        match &code[index] {
            SsaStep::LoopStart => loop_starts.push(index),
            SsaStep::LoopEnd => {
                if let Some(start) = loop_starts.pop() {
                    hoist_from_loop(code, start, index);
                }
            }
            _ => {}
        }
        index += 1;
    }
}

/// Hoists steps out of the loop whose `LoopStart` is at `start` and whose `LoopEnd` is at `end`. They are placed directly before `LoopStart`, so `end`
/// does not change.
fn hoist_from_loop(code: &mut [SsaStep], start: usize, end: usize) {
    // Values that are written in the loop, except those of hoisted steps.
    let mut changing: HashSet<SsaValue> = code[start..end].iter().flat_map(writes).collect();
    let labels_inside: HashSet<JumpLabel> =
        code[start..end].iter().filter_map(|step| if let SsaStep::Label(l) = step { Some(*l) } else { None }).collect();
    // Labels of the skips over the current step. A jump out of the loop is not a skip: every iteration that continues runs the steps after it.
    let mut skips: Vec<JumpLabel> = Vec::new();
    let mut inner_depth = 0;
    let mut hoisted = HashSet::default();
    for (index, step) in code.iter().enumerate().take(end).skip(start + 1) {
        match step {
            SsaStep::SkipIfNoLane { label, .. } | SsaStep::JumpIf { label, .. } | SsaStep::Jump { label } => {
                skips.extend(labels_inside.get(label));
            }
            SsaStep::Label(label) => skips.retain(|l| l != label),
            SsaStep::LoopStart => inner_depth += 1,
            SsaStep::LoopEnd => inner_depth -= 1,
            SsaStep::Op { dst, .. } | SsaStep::LoadUniform { dst, .. }
                if inner_depth == 0 && skips.is_empty() && reads(step).iter().all(|v| !changing.contains(v)) =>
            {
                changing.remove(dst);
                hoisted.insert(index);
            }
            _ => {}
        }
    }
    if hoisted.is_empty() {
        return;
    }
    let (hoisted_steps, body): (Vec<_>, Vec<_>) =
        code[start..end].iter().cloned().enumerate().partition(|(k, _)| hoisted.contains(&(start + k)));
    for (to, (_, step)) in code[start..end].iter_mut().zip(hoisted_steps.into_iter().chain(body)) {
        *to = step;
    }
}

/// Replaces a conditional jump over a jump by one jump with the opposite condition, and a jump on `!x` by the opposite jump on `x`.
pub(crate) fn merge_jumps(code: &mut Vec<SsaStep>) {
    let operand_of_not: HashMap<SsaValue, SsaValue> = code
        .iter()
        .filter_map(|step| match step {
            SsaStep::Op { dst: dst @ SsaValue::Shared(_), op: Op::BNot, args } => Some((*dst, args[0])),
            _ => None,
        })
        .collect();
    // A value that an `Assign` writes may change between the negation and the jump.
    let assigned: HashSet<SsaValue> =
        code.iter().filter_map(|step| if let SsaStep::Assign { dst, .. } = step { Some(*dst) } else { None }).collect();
    for step in code.iter_mut() {
        if let SsaStep::JumpIf { cond, when, .. } = step
            && let Some(operand) = operand_of_not.get(cond).filter(|v| !assigned.contains(v))
        {
            (*cond, *when) = (*operand, !*when);
        }
    }
    let is_jump_over_jump = |steps: &[SsaStep]| match steps {
        [SsaStep::JumpIf { label, .. }, SsaStep::Jump { .. }, SsaStep::Label(next)] => label == next,
        _ => false,
    };
    let conditional_jumps: Vec<usize> =
        code.windows(3).enumerate().filter(|(_, steps)| is_jump_over_jump(steps)).map(|(index, _)| index).collect();
    let mut removed = HashSet::default();
    for index in conditional_jumps {
        if let (SsaStep::JumpIf { cond, when, .. }, SsaStep::Jump { label }) = (&code[index], &code[index + 1]) {
            code[index] = SsaStep::JumpIf { cond: *cond, when: !*when, label: *label };
            removed.insert(index + 1);
        }
    }
    remove_steps(code, &removed);
}
