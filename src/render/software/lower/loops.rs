//! Loop optimisations that leave every result bit-identical: loop-invariant code motion, and merging of jumps.
//!
//! In: the SSA instructions after dead-code elimination and multiply-add fusion. Out: the same instructions, with loop-invariant instructions moved before
//! their loop, and with one jump instead of two at exits from loops. An instruction is moved only if every iteration that does not leave the loop runs it. One
//! that may be skipped stays: running it once before the loop may cost more than running it only where it is needed.

use super::ssa::{JumpLabel, SsaInstr, SsaValue, reads, remove_instrs, writes};
use crate::render::software::tape::Op;
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};

/// Moves loop-invariant instructions before their loop, from the innermost loops outward.
pub(crate) fn hoist(code: &mut [SsaInstr]) {
    let mut loop_starts = Vec::new();
    let mut index = 0;
    while index < code.len() {
        match &code[index] {
            SsaInstr::LoopStart => loop_starts.push(index),
            SsaInstr::LoopEnd => {
                if let Some(start) = loop_starts.pop() {
                    hoist_from_loop(code, start, index);
                }
            }
            _ => {}
        }
        index += 1;
    }
}

/// Hoists instructions out of the loop whose `LoopStart` is at `start` and whose `LoopEnd` is at `end`. They are placed directly before `LoopStart`, so
/// `LoopEnd` stays at `end`.
fn hoist_from_loop(code: &mut [SsaInstr], start: usize, end: usize) {
    // Values that are written in the loop, except those of hoisted instructions. Variables stay among them: here only `Assign`, which is not hoisted, writes
    // variables, because `write_variables_directly` runs later.
    let mut changing: HashSet<SsaValue> = code[start..end].iter().flat_map(writes).collect();
    let labels_inside: HashSet<JumpLabel> =
        code[start..end].iter().filter_map(|instr| if let SsaInstr::Label(l) = instr { Some(*l) } else { None }).collect();
    // Labels of the skips over the current instruction. A jump out of the loop is not a skip: only the last iteration takes it.
    let mut skips: Vec<JumpLabel> = Vec::new();
    let mut inner_depth = 0;
    let mut hoisted = HashSet::default();
    for (index, instr) in code.iter().enumerate().take(end).skip(start + 1) {
        match instr {
            SsaInstr::SkipIfNoLane { label, .. } | SsaInstr::JumpIf { label, .. } | SsaInstr::Jump { label } => {
                skips.extend(labels_inside.get(label));
            }
            SsaInstr::Label(label) => skips.retain(|l| l != label),
            SsaInstr::LoopStart => inner_depth += 1,
            SsaInstr::LoopEnd => inner_depth -= 1,
            // Those of inner loops that could be hoisted are before their loop already, at depth 0.
            SsaInstr::Op { dst, .. } | SsaInstr::LoadUniform { dst, .. }
                if inner_depth == 0 && skips.is_empty() && reads(instr).iter().all(|v| !changing.contains(v)) =>
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
    let (hoisted_instrs, body): (Vec<_>, Vec<_>) =
        code[start..end].iter().cloned().enumerate().partition(|(k, _)| hoisted.contains(&(start + k)));
    for (to, (_, instr)) in code[start..end].iter_mut().zip(hoisted_instrs.into_iter().chain(body)) {
        *to = instr;
    }
}

/// Replaces a conditional jump on `!x` by one on `x` with `when` inverted. Then replaces a conditional jump over a jump by one conditional jump to the latter's
/// target, also with `when` inverted.
pub(crate) fn merge_jumps(code: &mut Vec<SsaInstr>) {
    // Only shared values, because the condition of a jump is one.
    let operand_of_not: HashMap<SsaValue, SsaValue> = code
        .iter()
        .filter_map(|instr| match instr {
            SsaInstr::Op { dst: dst @ SsaValue::Shared(_), op: Op::BNot, args } => Some((*dst, args[0])),
            _ => None,
        })
        .collect();
    // An operand that an `Assign` writes may change between the negation and the jump. (The result of a negation is never a variable here.)
    let assigned: HashSet<SsaValue> =
        code.iter().filter_map(|instr| if let SsaInstr::Assign { dst, .. } = instr { Some(*dst) } else { None }).collect();
    for instr in code.iter_mut() {
        if let SsaInstr::JumpIf { cond, when, .. } = instr
            && let Some(operand) = operand_of_not.get(cond).filter(|v| !assigned.contains(v))
        {
            (*cond, *when) = (*operand, !*when);
        }
    }
    let is_jump_over_jump = |instrs: &[SsaInstr]| match instrs {
        [SsaInstr::JumpIf { label, .. }, SsaInstr::Jump { .. }, SsaInstr::Label(next)] => label == next,
        _ => false,
    };
    let jumps_over_jumps: Vec<usize> =
        code.windows(3).enumerate().filter(|(_, instrs)| is_jump_over_jump(instrs)).map(|(index, _)| index).collect();
    let mut removed = HashSet::default();
    for index in jumps_over_jumps {
        if let (SsaInstr::JumpIf { cond, when, .. }, SsaInstr::Jump { label }) = (&code[index], &code[index + 1]) {
            code[index] = SsaInstr::JumpIf { cond: *cond, when: !*when, label: *label };
            removed.insert(index + 1);
        }
    }
    remove_instrs(code, &removed);
}
