//! Unrolls innermost loops by two: doubles the loop's body, so that its variables need no copies.
//!
//! In: a checked program. Out: a checked program with the same results.
//!
//! At the end of a loop's body, each loop variable gets its next value by a copy from one slot to another, or from one register to another. In the second
//! body these two places are exchanged: the second body reads the variable from where the first one wrote the next value, and writes the next value to where
//! the first one reads the variable. So neither body needs the copy. Only a jump out of the second body is preceded by it, because the code after the loop
//! reads the variable from its own place. Only loops that end with copies and an unconditional jump back are doubled; a loop with a test after its copies (one
//! that lanes leave at different times, or a `do while`) keeps them. A variable also keeps its copy if its place, or that of its next value, takes part in
//! another copy, or if the next value may be read in another iteration or after the loop. This is done when a program is bound to its kernels; the tapes in the
//! shader library are not changed.

use crate::render::software::program::Program;
use crate::render::software::tape::{Instr, Op, Operand};
use std::borrow::Cow;

/// The slots, or registers, of a loop variable and of its next value. The second body exchanges them.
#[derive(Clone, Copy)]
struct ExchangedPair {
    variable: Operand,
    next: Operand,
}

/// An innermost loop: the indices of some of its instructions on the tape.
struct InnerLoop {
    /// The first instruction.
    head: usize,
    /// The first copy to a loop variable; only copies follow, up to `back_jump`. Equal to `back_jump` if there is no copy.
    first_copy: usize,
    /// The last instruction, which jumps to `head`.
    back_jump: usize,
}

/// The program with its innermost loops unrolled by two; unchanged if no loop can do without a copy.
pub(super) fn unroll_loops(program: &Program) -> Cow<'_, Program> {
    let tape = &program.lane_tape;
    let loops: Vec<(InnerLoop, Vec<ExchangedPair>)> = (0..tape.len())
        .filter_map(|index| {
            let inner = inner_loop(tape, index)?;
            let pairs = exchangeable_pairs(program, &inner);
            (!pairs.is_empty()).then_some((inner, pairs))
        })
        .collect();
    if loops.is_empty() {
        return Cow::Borrowed(program);
    }
    // For each instruction of the old tape, its index on the new one; for those of a doubled loop, that in the first body. The last entry is the new tape's
    // length.
    let mut new_index = Vec::with_capacity(tape.len() + 1);
    let mut new_tape = Vec::with_capacity(tape.len() * 2);
    let mut rest = loops.iter().peekable();
    let mut index = 0;
    while index < tape.len() {
        match rest.next_if(|(inner, _)| inner.head == index) {
            Some((inner, pairs)) => {
                append_doubled(tape, inner, pairs, &mut new_index, &mut new_tape);
                index = inner.back_jump + 1;
            }
            None => {
                new_index.push(new_tape.len());
                new_tape.push((tape[index].clone(), JumpTarget::OnOldTape));
                index += 1;
            }
        }
    }
    new_index.push(new_tape.len());
    let lane_tape = new_tape.into_iter().map(|(mut instr, jump_target)| {
        if let Instr::SkipIfNoLane { target, .. } | Instr::JumpIf { target, .. } | Instr::Jump { target } = &mut instr {
            *target = match jump_target {
                JumpTarget::OnOldTape => new_index[*target as usize] as u32,
                JumpTarget::OnNewTape(index) => index as u32,
            };
        }
        instr
    });
    Cow::Owned(Program { lane_tape: lane_tape.collect(), ..program.clone() })
}

/// Where an instruction of the new tape jumps to, while the tape is being made.
#[derive(Clone, Copy)]
enum JumpTarget {
    /// The target in the instruction, if it has one, is still an index on the old tape.
    OnOldTape,
    /// This index on the new tape, which will replace the target in the instruction.
    OnNewTape(usize),
}

/// Appends both bodies of a loop, and after them the copies for jumps out of the second body.
fn append_doubled(
    tape: &[Instr],
    inner: &InnerLoop,
    pairs: &[ExchangedPair],
    new_index: &mut Vec<usize>,
    new_tape: &mut Vec<(Instr, JumpTarget)>,
) {
    let InnerLoop { head, first_copy, back_jump } = *inner;
    let is_removed = |index: usize| {
        index >= first_copy && copy_operands(&tape[index]).is_some_and(|(variable, _)| pairs.iter().any(|p| p.variable == variable))
    };
    let kept: Vec<usize> = (head..back_jump).filter(|index| !is_removed(*index)).collect();
    // Where the two bodies begin on the new tape.
    let (first_body, second_body) = (new_tape.len(), new_tape.len() + kept.len());
    // Where an instruction of the loop is within either new body. A removed instruction has the position of the next instruction that is kept.
    let position = |index: usize| kept.partition_point(|k| *k < index);
    new_index.extend((head..back_jump).map(|index| first_body + position(index)));
    // The first body has no jump back: the second body follows it. No instruction has the old jump back as its target, but `new_index` needs an entry for it.
    new_index.push(second_body);
    new_tape.extend(kept.iter().map(|index| (tape[*index].clone(), JumpTarget::OnOldTape)));
    // After the second body and its jump back come its exits, one for each target that its jumps have outside the loop: the copies, then a jump to the target.
    let (first_exit, exit_length) = (second_body + kept.len() + 1, pairs.len() + 1);
    let mut exit_targets: Vec<usize> = Vec::new();
    for index in &kept {
        let instr = exchanged(&tape[*index], pairs);
        let target = match instr.target().map(|t| t as usize) {
            Some(to) if (head..=back_jump).contains(&to) => JumpTarget::OnNewTape(second_body + position(to)),
            Some(to) => {
                let exit = exit_targets.iter().position(|e| *e == to).unwrap_or_else(|| {
                    exit_targets.push(to);
                    exit_targets.len() - 1
                });
                JumpTarget::OnNewTape(first_exit + exit * exit_length)
            }
            None => JumpTarget::OnOldTape,
        };
        new_tape.push((instr, target));
    }
    // `JumpTarget::OnNewTape` replaces the 0.
    new_tape.push((Instr::Jump { target: 0 }, JumpTarget::OnNewTape(first_body)));
    for target in exit_targets {
        new_tape.extend(pairs.iter().map(|p| (copy_instr(p.variable, p.next), JumpTarget::OnOldTape)));
        new_tape.push((Instr::Jump { target: target as u32 }, JumpTarget::OnOldTape));
    }
}

/// The loop that the instruction at `back_jump` closes, if it contains no other loop and is entered only at its head.
fn inner_loop(tape: &[Instr], back_jump: usize) -> Option<InnerLoop> {
    let Instr::Jump { target } = tape[back_jump] else { return None };
    let head = target as usize;
    if head >= back_jump {
        return None;
    }
    let mut first_copy = back_jump;
    while first_copy > head && copy_operands(&tape[first_copy - 1]).is_some() {
        first_copy -= 1;
    }
    let is_simple = tape.iter().enumerate().filter(|(index, _)| *index != back_jump).all(|(index, instr)| {
        let Some(to) = instr.target().map(|t| t as usize) else { return true };
        let is_inside = (head..=back_jump).contains(&index);
        // From inside: no jump backwards, and none past the first copy, which would leave out copies. From outside: none into the loop, except to its head.
        if is_inside { to > index && !(first_copy + 1..=back_jump).contains(&to) } else { !(head + 1..=back_jump).contains(&to) }
    });
    is_simple.then_some(InnerLoop { head, first_copy, back_jump })
}

/// Destination and source of a copy between two slots or between two registers; `None` for any other instruction.
fn copy_operands(instr: &Instr) -> Option<(Operand, Operand)> {
    match instr {
        Instr::Lane { op: Op::Copy, dst, args } => match args[..] {
            [from @ Operand::Slot(_)] => Some((Operand::Slot(*dst), from)),
            _ => None,
        },
        Instr::Scalar { op: Op::Copy, dst, args } => match args[..] {
            [from @ Operand::Reg(_)] => Some((Operand::Reg(*dst), from)),
            _ => None,
        },
        _ => None,
    }
}

fn copy_instr(to: Operand, from: Operand) -> Instr {
    match to {
        Operand::Slot(dst) => Instr::Lane { op: Op::Copy, dst, args: vec![from] },
        Operand::Reg(dst) => Instr::Scalar { op: Op::Copy, dst, args: vec![from] },
    }
}

/// The variables of a loop whose copies can be left out: neither the variable's slot or register nor that of its next value takes part in a second copy,
/// and no other iteration and nothing after the loop reads that of the next value before it is written again.
fn exchangeable_pairs(program: &Program, inner: &InnerLoop) -> Vec<ExchangedPair> {
    let tape = &program.lane_tape;
    let all: Vec<(Operand, Operand)> = tape[inner.first_copy..inner.back_jump].iter().filter_map(copy_operands).collect();
    let uses = |operand: Operand| all.iter().flat_map(|(to, from)| [to, from]).filter(|o| **o == operand).count();
    let exits: Vec<usize> = tape[inner.head..inner.back_jump]
        .iter()
        .filter_map(|instr| instr.target().map(|t| t as usize))
        .filter(|to| !(inner.head..=inner.back_jump).contains(to))
        .collect();
    all.iter()
        .filter(|(to, from)| uses(*to) == 1 && uses(*from) == 1)
        .filter(|(_, from)| !exits.iter().chain([&inner.head]).any(|index| may_be_read(program, *index, *from)))
        .map(|(variable, next)| ExchangedPair { variable: *variable, next: *next })
        .collect()
}

/// Whether the value that `operand` has before the instruction with index `start` may be read, on any path through the tape from there.
fn may_be_read(program: &Program, start: usize, operand: Operand) -> bool {
    let tape = &program.lane_tape;
    let mut visited = vec![false; tape.len()];
    let mut path_starts = vec![start];
    while let Some(mut index) = path_starts.pop() {
        loop {
            // After the last instruction the outputs are read.
            let Some(instr) = tape.get(index) else {
                if program.output_operands.iter().chain(&program.discarded).any(|o| *o == operand) {
                    return true;
                }
                break;
            };
            if std::mem::replace(&mut visited[index], true) {
                break;
            }
            if reads(instr, operand) {
                return true;
            }
            if writes(instr, operand) {
                break;
            }
            match instr {
                Instr::Jump { target } => index = *target as usize,
                Instr::JumpIf { target, .. } | Instr::SkipIfNoLane { target, .. } => {
                    path_starts.push(*target as usize);
                    index += 1;
                }
                _ => index += 1,
            }
        }
    }
    false
}

fn reads(instr: &Instr, operand: Operand) -> bool {
    instr.operands().contains(&operand)
}

fn writes(instr: &Instr, operand: Operand) -> bool {
    match operand {
        Operand::Slot(s) => instr.written_slots().contains(&s),
        Operand::Reg(r) => instr.written_register() == Some(r),
    }
}

/// The instruction with the two operands of each pair exchanged.
fn exchanged(instr: &Instr, pairs: &[ExchangedPair]) -> Instr {
    let exchange = |operand: Operand| {
        let partner = |p: &ExchangedPair| {
            if p.variable == operand { Some(p.next) } else { (p.next == operand).then_some(p.variable) }
        };
        pairs.iter().find_map(partner).unwrap_or(operand)
    };
    let partner_index = |operand: Operand| match exchange(operand) {
        Operand::Slot(k) | Operand::Reg(k) => k,
    };
    let mut instr = instr.clone();
    match &mut instr {
        Instr::Lane { dst, args, .. } | Instr::FusedKernel { dst, args, .. } => {
            *dst = partner_index(Operand::Slot(*dst));
            args.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::Scalar { dst, args, .. } => {
            *dst = partner_index(Operand::Reg(*dst));
            args.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::LoadUniform { dst, index, .. } => {
            *dst = partner_index(Operand::Reg(*dst));
            index.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::GatherUniform { dst, index, .. } => {
            *dst = partner_index(Operand::Slot(*dst));
            *index = exchange(*index);
        }
        Instr::Texture { dst, args, mask, .. } => {
            dst.iter_mut().for_each(|d| *d = partner_index(Operand::Slot(*d)));
            args.iter_mut().for_each(|a| *a = exchange(*a));
            *mask = exchange(*mask);
        }
        Instr::TextureSize { dst, level, .. } => {
            *dst = partner_index(Operand::Reg(*dst));
            *level = exchange(*level);
        }
        Instr::SkipIfNoLane { mask: operand, .. } | Instr::JumpIf { cond: operand, .. } => *operand = exchange(*operand),
        Instr::Jump { .. } => {}
    }
    instr
}
