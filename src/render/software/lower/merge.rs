//! Merges the two sides of a branch whose condition is one value for all lanes.
//!
//! In: the SSA instructions of both sides, of which a batch runs one, and the environments after them. Out: for each lane value that differs, a variable that
//! each side writes at its end. A side that leaves the scalar as it was writes nothing: the variable starts as a copy of that value, before the branch. So the
//! side that runs pays for its own values only; a `select` would run after either side. Always: a variable is read only after its last write, or, within the
//! sides, in place of the value of which it is a copy. [`write_variables_directly`] then removes most copies at the ends, and `finish.rs` those at the start.
//! Not here: branches whose condition differs between lanes, which need a `select` for each scalar.

use super::lowerer::Lowerer;
use super::ssa::{SsaInstr, SsaValue, SsaValues, reads, remove_instrs, replace_reads, use_counts, writes};
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};

/// The instructions and environments of both sides of a branch: first of the side that runs if the condition holds.
pub(super) struct Sides {
    /// Index of the first instruction, the jump that skips the first side.
    pub start: usize,
    /// For each side, the index after its last instruction, which is the label of the jump that skips the side.
    pub ends: [usize; 2],
    /// The environments after each side.
    pub envs: [Vec<SsaValue>; 2],
}

impl Lowerer<'_> {
    /// Merges the scalars that differ between the sides into the environment, which is that from before the branch. `accepted_env`: that after the side that
    /// runs if the condition `cond` holds; `rejected_env`: that after the other side.
    pub(super) fn merge_sides(&mut self, cond: SsaValue, Sides { start, ends, envs: [accepted_env, rejected_env] }: Sides) {
        // Copies before the branch, and at the end of each side.
        let (mut at_start, mut at_ends) = (Vec::new(), [Vec::new(), Vec::new()]);
        // By value from before the branch: the variable that is a copy of it.
        let mut copy_of: HashMap<SsaValue, SsaValue> = HashMap::default();
        for (scalar, (accepted, rejected)) in accepted_env.into_iter().zip(rejected_env).enumerate() {
            let before = self.env[scalar];
            let is_lane = |v: SsaValue| matches!(v, SsaValue::Lane(_));
            // A flag that is known on one side is merged by a select, which the builder may simplify to a known value: the lowering of later statements depends
            // on whether a flag is known.
            let is_known = [accepted, rejected].iter().any(|v| self.builder.known_bool(*v).is_some());
            if accepted == rejected || is_known || !(is_lane(accepted) || is_lane(rejected)) {
                self.env[scalar] = self.builder.select(cond, accepted, rejected);
                continue;
            }
            let variable = self.builder.fresh_lane();
            if accepted == before || rejected == before {
                at_start.push(SsaInstr::Assign { dst: variable, from: before });
                if is_lane(before) {
                    copy_of.entry(before).or_insert(variable);
                }
            }
            for (side, value) in [accepted, rejected].into_iter().enumerate().filter(|(_, value)| *value != before) {
                at_ends[side].push(SsaInstr::Assign { dst: variable, from: value });
            }
            self.env[scalar] = variable;
        }
        // If the sides read the copy, nothing reads the original value after it, and both can have the same slot. Instructions after the sides, such as those
        // of the selects above, keep the original value, because the variable has its new one there.
        for instr in &mut self.builder.lane_instrs[start..ends[1]] {
            replace_reads(instr, |v| copy_of.get(&v).copied());
        }
        let [accepted_copies, rejected_copies] = at_ends;
        // From the last place to the first, so that the indices of the others stay right. A side's last instruction is its label.
        for (position, copies) in [(ends[1] - 1, rejected_copies), (ends[0] - 1, accepted_copies), (start, at_start)] {
            self.builder.lane_instrs.splice(position..position, copies);
        }
    }
}

/// Lets an operation write a variable directly, if nothing but the copy into that variable reads its result, and nothing reads or writes the variable between
/// the operation and the copy. `outputs`: the program's outputs, which count as reads.
pub(super) fn write_variables_directly(code: &mut Vec<SsaInstr>, outputs: &[SsaValue]) {
    let uses = use_counts(code, outputs);
    // In the instructions since the last jump or label: where each value was computed by an operation, and where each was last read or written.
    let mut computed_at: HashMap<SsaValue, usize> = HashMap::default();
    let mut accessed_at: HashMap<SsaValue, usize> = HashMap::default();
    let mut removed = HashSet::default();
    for index in 0..code.len() {
        match &code[index] {
            SsaInstr::Assign { dst: dst @ SsaValue::Lane(_), from } if uses.get(from) == Some(&1) => {
                if let Some(&op_index) = computed_at.get(from)
                    && accessed_at.get(dst).is_none_or(|access| *access < op_index)
                    && let (SsaInstr::Op { dst: result, .. } | SsaInstr::FusedKernel { dst: result, .. }, dst) = (&code[op_index], *dst)
                    && result == from
                {
                    if let SsaInstr::Op { dst: result, .. } | SsaInstr::FusedKernel { dst: result, .. } = &mut code[op_index] {
                        *result = dst;
                    }
                    accessed_at.insert(dst, index);
                    removed.insert(index);
                    continue;
                }
            }
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), .. } | SsaInstr::FusedKernel { dst, .. } => {
                computed_at.insert(*dst, index);
            }
            other if other.is_control_flow() => {
                computed_at.clear();
                accessed_at.clear();
            }
            _ => {}
        }
        let accessed: SsaValues = reads(&code[index]).into_iter().chain(writes(&code[index])).collect();
        accessed_at.extend(accessed.into_iter().map(|v| (v, index)));
    }
    remove_instrs(code, &removed);
}
