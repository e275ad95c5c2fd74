//! Turns SSA instructions into the stored program: dead-code elimination, fused multiply-add, merging of jumps, loop-invariant code motion, fusion into chains
//! (`FusedKernel`), removal of copies, then allocation of slots (one value per lane) by live range. Each value that all lanes share gets a register of its own.
//!
//! In: the instructions of both tapes in SSA form, and the program's inputs and outputs. Out: the tapes. Not here: the optimisations in `loops.rs`, `chains.rs`
//! and `merge.rs`.
//!
//! A lane value is live from its first write to its last use. If a loop uses a value from before the loop, the value is live to the loop's end. The slot freed
//! last is reused first. Always: a result never shares the slot of an operand, so that kernels may assume that results and operands do not overlap. The only
//! exception is a copy, which then emits no instruction.

use super::builder::SsaBuilder;
use super::error::LowerError;
use super::ssa::{JumpLabel, SsaInstr, SsaValue, reads, remove_instrs, use_counts, writes};
use crate::render::software::program::SLOT_OR_REGISTER_LIMIT;
use crate::render::software::tape::{Instr, Op, Operand};
use rustc_hash::{FxHashMap as HashMap, FxHashSet as HashSet};
use smallvec::smallvec;

/// The assembled tapes, as fields of a [`Program`](crate::render::software::program::Program).
pub(crate) struct FinishedTapes {
    pub draw_tape: Vec<Instr>,
    pub lane_tape: Vec<Instr>,
    /// For each input, whether any instruction reads it. The last input is the mask of active lanes.
    pub inputs_read: Vec<bool>,
    pub outputs: Vec<Operand>,
    pub register_count: u32,
    pub slot_count: u32,
}

/// Dead-code elimination. Iterates to a fixed point, because an instruction may read a loop variable that a later instruction of the loop assigns. Instructions
/// without a result control the flow and stay, except jumps to the next instruction.
fn eliminate_dead_code(builder: &mut SsaBuilder, outputs: &[SsaValue]) {
    let mut live: HashSet<SsaValue> = outputs.iter().copied().collect();
    loop {
        let before = live.len();
        for instr in builder.lane_instrs.iter().rev().chain(builder.draw_instrs.iter().rev()) {
            let written = writes(instr);
            if written.is_empty() || written.iter().any(|v| live.contains(v)) {
                live.extend(reads(instr));
            }
        }
        if live.len() == before {
            break;
        }
    }
    let keep = |s: &SsaInstr| {
        let written = writes(s);
        written.is_empty() || written.iter().any(|v| live.contains(v))
    };
    builder.lane_instrs.retain(keep);
    builder.draw_instrs.retain(keep);
    remove_jumps_to_next(&mut builder.lane_instrs);
}

/// Removes each jump to the next instruction. Instructions are visited from the last to the first, because a removed jump may leave an earlier one directly
/// before its label.
fn remove_jumps_to_next(code: &mut Vec<SsaInstr>) {
    let mut kept: Vec<SsaInstr> = Vec::with_capacity(code.len());
    for instr in code.drain(..).rev() {
        let label = match &instr {
            SsaInstr::SkipIfNoLane { label, .. } | SsaInstr::JumpIf { label, .. } | SsaInstr::Jump { label } => Some(*label),
            _ => None,
        };
        let is_jump_to_next = label.is_some_and(|label| kept.last() == Some(&SsaInstr::Label(label)));
        if !is_jump_to_next {
            kept.push(instr);
        }
    }
    kept.reverse();
    *code = kept;
}

/// A multiplication that may be fused with the addition or subtraction that reads it.
#[derive(Clone, Copy)]
struct Product {
    /// Index of its instruction.
    index: usize,
    /// The id of the stretch of instructions that contains it (`straight_line_id` in [`fuse_multiply_add`]).
    straight_line_id: u32,
    factors: [SsaValue; 2],
}

/// Fuses a*b+c, a*b-c and c-a*b if the product has no other use and its factors are unchanged at the addition.
fn fuse_multiply_add(builder: &mut SsaBuilder, outputs: &[SsaValue]) {
    let uses = use_counts(&builder.lane_instrs, outputs);
    let mut products: HashMap<SsaValue, Product> = HashMap::default();
    let mut removed = HashSet::default();
    // A product is fused only with an addition of the same id. Between instructions of the same id no loop variable among the product's factors is assigned, so
    // the addition may read the factors instead. A jump starts a new id, because what follows may be skipped; its label restores the id from before the jump.
    // Jumps out of a loop thus restore an id of the loop's body after the loop. This is harmless: no instruction after the loop reads a product of the body.
    let mut straight_line_id = 0u32;
    // For each jump whose label has not been reached: the id before the jump, and the label.
    let mut open_jumps: Vec<(u32, JumpLabel)> = Vec::new();
    let mut last_id = 0u32;
    for i in 0..builder.lane_instrs.len() {
        match &builder.lane_instrs[i] {
            SsaInstr::SkipIfNoLane { label, .. } | SsaInstr::JumpIf { label, .. } => {
                open_jumps.push((straight_line_id, *label));
                last_id += 1;
                straight_line_id = last_id;
            }
            SsaInstr::Label(l) => {
                // If several jumps lead here, the id from before the first of them counts.
                while let Some(k) = open_jumps.iter().rposition(|(_, label)| label == l) {
                    straight_line_id = open_jumps[k].0;
                    open_jumps.truncate(k);
                }
            }
            SsaInstr::LoopStart | SsaInstr::LoopEnd | SsaInstr::Jump { .. } => {
                last_id += 1;
                straight_line_id = last_id;
            }
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op: Op::Mul, args } if uses.get(dst) == Some(&1) => {
                products.insert(*dst, Product { index: i, straight_line_id, factors: [args[0], args[1]] });
            }
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op: op @ (Op::Add | Op::Sub), args } => {
                let product_of = |v: SsaValue| products.get(&v).filter(|p| p.straight_line_id == straight_line_id).copied();
                let (product, op, addend) = match (op, product_of(args[0]), product_of(args[1])) {
                    (Op::Add, Some(p), _) => (p, Op::Fma, args[1]),
                    (Op::Add, None, Some(p)) => (p, Op::Fma, args[0]),
                    (Op::Sub, Some(p), _) => (p, Op::Fms, args[1]),
                    (Op::Sub, None, Some(p)) => (p, Op::Fnma, args[0]),
                    _ => continue,
                };
                let dst = *dst;
                removed.insert(product.index);
                builder.lane_instrs[i] = SsaInstr::Op { dst, op, args: smallvec![product.factors[0], product.factors[1], addend] };
            }
            _ => {}
        }
    }
    remove_instrs(&mut builder.lane_instrs, &removed);
}

/// Live range of every value: the indices of the first and the last instruction that write or read it. If a loop uses a value from before the loop, the last
/// index is at least that of the loop's end. The last index of an output is `code.len()`.
fn live_ranges(code: &[SsaInstr], inputs: &[SsaValue], outputs: &[SsaValue]) -> HashMap<SsaValue, (usize, usize)> {
    // Inputs are live from the start of the program.
    let mut ranges: HashMap<SsaValue, (usize, usize)> = inputs.iter().map(|v| (*v, (0, 0))).collect();
    let mut loops: Vec<(usize, usize)> = Vec::new();
    let mut open_loops: Vec<usize> = Vec::new();
    for (i, instr) in code.iter().enumerate() {
        match instr {
            SsaInstr::LoopStart => open_loops.push(i),
            SsaInstr::LoopEnd => loops.extend(open_loops.pop().map(|start| (start, i))),
            _ => {}
        }
        for v in reads(instr).into_iter().chain(writes(instr)) {
            ranges.entry(v).or_insert((i, i)).1 = i;
        }
    }
    // An output that no instruction writes becomes an error in `operand_of`.
    for v in outputs {
        ranges.entry(*v).or_insert((0, 0)).1 = code.len();
    }
    // `loops` is in the order of the ends: after an inner loop has extended a range to its end, the outer loop may extend it further.
    for (start, end) in loops {
        for (first, last) in ranges.values_mut() {
            if *first <= start && *last > start && *last < end {
                *last = end;
            }
        }
    }
    ranges
}

/// Gives numbers to slots, or to registers. Only slots are ever freed.
struct NumberAllocator {
    free: Vec<u16>,
    /// The numbers 0 to `count - 1` exist, in use or free.
    count: u32,
}

impl NumberAllocator {
    fn allocate(&mut self) -> Result<u16, LowerError> {
        if let Some(s) = self.free.pop() {
            return Ok(s);
        }
        self.count += 1;
        if self.count >= SLOT_OR_REGISTER_LIMIT {
            return Err(LowerError::new(
                format!("the program needs {SLOT_OR_REGISTER_LIMIT} or more slots or registers"),
                naga::Span::UNDEFINED,
            ));
        }
        Ok((self.count - 1) as u16)
    }
}

/// Optimises the instructions and assembles the tapes. `inputs`: lane values; input k is in slot k at the start. `outputs`: lane values, all different and none
/// of them an input. `fuse_chains`: whether to compute chains of operations by fused kernels.
pub(crate) fn finish(
    mut builder: SsaBuilder,
    inputs: &[SsaValue],
    outputs: &[SsaValue],
    fuse_chains: bool,
) -> Result<FinishedTapes, LowerError> {
    eliminate_dead_code(&mut builder, outputs);
    fuse_multiply_add(&mut builder, outputs);
    super::loops::merge_jumps(&mut builder.lane_instrs);
    super::loops::hoist(&mut builder.lane_instrs);
    eliminate_dead_code(&mut builder, outputs);
    if fuse_chains {
        super::chains::fuse_chains(&mut builder.lane_instrs, outputs);
    }
    super::merge::write_variables_directly(&mut builder.lane_instrs, outputs);
    let live_ranges = live_ranges(&builder.lane_instrs, inputs, outputs);
    let mut values_read: HashSet<SsaValue> = outputs.iter().copied().collect();
    builder.lane_instrs.iter().for_each(|instr| values_read.extend(reads(instr)));
    let mut allocation: HashMap<SsaValue, Operand> = HashMap::default();
    let mut registers = NumberAllocator { free: Vec::new(), count: builder.constants.len() as u32 };
    let mut slots = NumberAllocator { free: Vec::new(), count: inputs.len() as u32 };
    for i in 0..builder.constants.len() {
        allocation.insert(SsaValue::Const(i as u32), Operand::Reg(i as u16));
    }
    // Per instruction, the slots that become free after the instruction, because it is the last to use their values. The entry after the last instruction is
    // for the outputs, whose slots never become free.
    let mut freed_after: Vec<Vec<u16>> = vec![Vec::new(); builder.lane_instrs.len() + 1];
    for (k, v) in inputs.iter().enumerate() {
        allocation.insert(*v, Operand::Slot(k as u16));
        let last = live_ranges.get(v).map_or(0, |(_, last)| *last);
        freed_after[last].push(k as u16);
    }
    for instr in &builder.draw_instrs {
        for v in writes(instr) {
            allocation.insert(v, Operand::Reg(registers.allocate()?));
        }
    }
    let mut draw_tape = Vec::new();
    for instr in &builder.draw_instrs {
        draw_tape.push(scalar_instr(instr, &|v| operand_of(&allocation, v))?);
    }
    let mut lane_tape: Vec<Instr> = Vec::new();
    let mut target_of: HashMap<JumpLabel, u32> = HashMap::default();
    for (i, instr) in builder.lane_instrs.iter().enumerate() {
        for v in writes(instr) {
            if allocation.contains_key(&v) {
                continue;
            }
            // If nothing uses a lane value after it is copied, the copy takes over the value's slot, and needs no instruction.
            if let SsaInstr::Assign { from: from @ SsaValue::Lane(_), .. } = instr
                && matches!(v, SsaValue::Lane(_))
                && let Some(Operand::Slot(s)) = allocation.get(from).copied()
                && let Some(position) = freed_after[i].iter().position(|freed| *freed == s)
            {
                freed_after[i].swap_remove(position);
                allocation.insert(v, Operand::Slot(s));
                freed_after[live_ranges.get(&v).map_or(i, |(_, last)| *last)].push(s);
                continue;
            }
            match v {
                SsaValue::Lane(_) => {
                    let s = slots.allocate()?;
                    allocation.insert(v, Operand::Slot(s));
                    freed_after[live_ranges.get(&v).map_or(i, |(_, last)| *last)].push(s);
                }
                _ => {
                    allocation.insert(v, Operand::Reg(registers.allocate()?));
                }
            }
        }
        let operand = |v: SsaValue| operand_of(&allocation, v);
        let number = |v: SsaValue| operand(v).map(number_of);
        let operands = |vs: &[SsaValue]| vs.iter().map(|v| operand(*v)).collect::<Result<Vec<_>, LowerError>>();
        match instr {
            SsaInstr::Op { dst: dst @ SsaValue::Lane(_), op, args } => {
                lane_tape.push(Instr::Lane { op: *op, dst: number(*dst)?, args: operands(args)? })
            }
            SsaInstr::Assign { dst: dst @ SsaValue::Lane(_), from } => {
                let from = operand(*from)?;
                // Equal if the copy has taken over the slot.
                if operand(*dst)? != from {
                    lane_tape.push(Instr::Lane { op: Op::Copy, dst: number(*dst)?, args: vec![from] });
                }
            }
            SsaInstr::LoadUniform { dst: dst @ SsaValue::Lane(_), kind, offset, index: Some(k), stride, count } => {
                lane_tape.push(Instr::GatherUniform {
                    dst: number(*dst)?,
                    kind: *kind,
                    offset: *offset,
                    index: operand(*k)?,
                    stride: *stride,
                    count: *count,
                })
            }
            SsaInstr::FusedKernel { dst, ops, args } => {
                lane_tape.push(Instr::FusedKernel { ops: ops.clone(), dst: number(*dst)?, args: operands(args)? })
            }
            SsaInstr::Op { .. } | SsaInstr::Assign { .. } | SsaInstr::LoadUniform { .. } | SsaInstr::TextureSize { .. } => {
                lane_tape.push(scalar_instr(instr, &operand)?);
            }
            SsaInstr::Texture { op, texture, dst: [r, g, b, a], args, mask } => lane_tape.push(Instr::Texture {
                op: *op,
                texture: *texture,
                dst: [number(*r)?, number(*g)?, number(*b)?, number(*a)?],
                channels_read: [r, g, b, a].map(|v| values_read.contains(v)),
                args: operands(args)?,
                mask: operand(*mask)?,
            }),
            SsaInstr::SkipIfNoLane { mask, label } => lane_tape.push(Instr::SkipIfNoLane { mask: operand(*mask)?, target: *label }),
            SsaInstr::JumpIf { cond, when, label } => lane_tape.push(Instr::JumpIf { cond: operand(*cond)?, when: *when, target: *label }),
            SsaInstr::Jump { label } => lane_tape.push(Instr::Jump { target: *label }),
            SsaInstr::Label(l) => {
                target_of.insert(*l, lane_tape.len() as u32);
            }
            SsaInstr::LoopStart | SsaInstr::LoopEnd => {}
        }
        slots.free.extend(std::mem::take(&mut freed_after[i]));
    }
    for instr in &mut lane_tape {
        if let Instr::SkipIfNoLane { target, .. } | Instr::JumpIf { target, .. } | Instr::Jump { target } = instr {
            // Without its label a jump gets a target that `Program::check` refuses.
            *target = target_of.get(target).copied().unwrap_or(u32::MAX);
        }
    }
    Ok(FinishedTapes {
        draw_tape,
        lane_tape,
        inputs_read: inputs.iter().map(|v| values_read.contains(v)).collect(),
        outputs: outputs.iter().map(|v| operand_of(&allocation, *v)).collect::<Result<_, _>>()?,
        register_count: registers.count.max(1),
        slot_count: slots.count.max(1),
    })
}

/// The slot or register of a value.
fn operand_of(allocation: &HashMap<SsaValue, Operand>, v: SsaValue) -> Result<Operand, LowerError> {
    let unwritten = || LowerError::new(format!("{v:?} is read, but no earlier step writes it"), naga::Span::UNDEFINED);
    allocation.get(&v).copied().ok_or_else(unwritten)
}

/// The number of a slot or register.
fn number_of(o: Operand) -> u16 {
    match o {
        Operand::Slot(k) | Operand::Reg(k) => k,
    }
}

/// The tape instruction for an SSA instruction whose result is a register, of either tape.
fn scalar_instr(instr: &SsaInstr, operand: &dyn Fn(SsaValue) -> Result<Operand, LowerError>) -> Result<Instr, LowerError> {
    let number = |v: SsaValue| operand(v).map(number_of);
    Ok(match instr {
        SsaInstr::Op { dst, op, args } => {
            Instr::Scalar { op: *op, dst: number(*dst)?, args: args.iter().map(|v| operand(*v)).collect::<Result<_, _>>()? }
        }
        SsaInstr::Assign { dst, from } => Instr::Scalar { op: Op::Copy, dst: number(*dst)?, args: vec![operand(*from)?] },
        SsaInstr::LoadUniform { dst, kind, offset, index: k, stride, count } => Instr::LoadUniform {
            dst: number(*dst)?,
            kind: *kind,
            offset: *offset,
            index: k.map(operand).transpose()?,
            stride: *stride,
            count: *count,
        },
        SsaInstr::TextureSize { dst, texture, axis, level } => {
            Instr::TextureSize { dst: number(*dst)?, texture: *texture, axis: *axis, level: operand(*level)? }
        }
        // No other instruction has a register as its result, so this is never reached; `Program::check` would refuse the target.
        _ => Instr::Jump { target: u32::MAX },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    /// Jumps that become jumps to the next instruction are removed together with those before them, in a time proportional to the number of instructions:
    /// 100,000 removals from a vector one by one would take minutes.
    #[test]
    fn jumps_to_the_next_instruction_are_removed_in_linear_time() {
        let mut builder = SsaBuilder::new();
        let mask = builder.fresh_lane();
        let skip = |label| SsaInstr::SkipIfNoLane { mask, label };
        let nested = |label| [skip(label), SsaInstr::Jump { label }, SsaInstr::Label(label)];
        let mut code: Vec<SsaInstr> = (0..100_000).flat_map(nested).collect();
        let start = Instant::now();
        remove_jumps_to_next(&mut code);
        assert!(code.len() == 100_000 && code.iter().all(|instr| matches!(instr, SsaInstr::Label(_))), "{} are left", code.len());
        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
        // A jump past another instruction stays, even if that is only a label.
        let mut code = vec![skip(1), SsaInstr::LoopStart, SsaInstr::Label(1), skip(2), SsaInstr::Label(1), SsaInstr::Label(2)];
        let before = code.clone();
        remove_jumps_to_next(&mut code);
        assert_eq!(code, before);
    }

    #[test]
    fn a_value_that_no_instruction_writes_is_an_error() {
        // The sum of two values; `inputs`: how many of them are inputs of the program.
        let sum = |inputs: usize| {
            let mut builder = SsaBuilder::new();
            let terms = [builder.fresh_lane(), builder.fresh_lane()];
            let dst = builder.fresh_lane();
            builder.lane_instrs.push(SsaInstr::Op { dst, op: Op::Add, args: smallvec![terms[0], terms[1]] });
            let fuse_chains = false;
            finish(builder, &terms[..inputs], &[dst], fuse_chains)
        };
        assert!(sum(2).is_ok());
        let error = sum(1).err().expect("the second term has no value");
        assert!(error.to_string().contains("no earlier step writes"), "{error}");
    }
}
