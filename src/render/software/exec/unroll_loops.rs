//! Unrolls innermost loops by two: doubles the loop's body, so that its variables need no copies.
//!
//! In: a checked program. Out: a checked program with the same results.
//!
//! At the end of a loop's body, each loop variable gets its next value by a copy from one slot to another, or from one register to another. In the second
//! body these two places are exchanged: the second body reads the variable from where the first one wrote the next value, and writes the next value to where
//! the first one reads the variable. So neither body needs the copy; only a jump out of the second body does. Only loops that end with copies and an
//! unconditional jump back are doubled; a loop that ends with a test (lanes that leave separately, `do while`) keeps its copies. Always: a variable keeps its
//! copy if its slot, or the slot of its next value, takes part in another copy, or if the next value may be read in another iteration or after the loop. The
//! stored program is not changed: its loops have one body.

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
    /// The first copy of a loop variable; only copies follow, up to `back_jump`.
    first_copy: usize,
    /// The last instruction, which jumps to `head`.
    back_jump: usize,
}

/// The program with its innermost loops unrolled by two; unchanged if no loop can do without a copy.
pub(super) fn unroll_loops(program: &Program) -> Cow<'_, Program> {
    let tape = &program.lane_tape;
    let loops: Vec<(InnerLoop, Vec<ExchangedPair>)> = (0..tape.len())
        .filter_map(|index| {
            let found = inner_loop(tape, index)?;
            let pairs = exchangeable_pairs(program, &found);
            (!pairs.is_empty()).then_some((found, pairs))
        })
        .collect();
    if loops.is_empty() {
        return Cow::Borrowed(program);
    }
    // For each instruction of the old tape, its index on the new one (of a doubled loop: its index in the first body). The last entry is the new tape's length.
    let mut new_index = Vec::with_capacity(tape.len() + 1);
    let mut new_tape = Vec::with_capacity(tape.len() * 2);
    let mut rest = loops.iter().peekable();
    let mut index = 0;
    while index < tape.len() {
        match rest.next_if(|(found, _)| found.head == index) {
            Some((found, pairs)) => {
                append_doubled(tape, found, pairs, &mut new_index, &mut new_tape);
                index = found.back_jump + 1;
            }
            None => {
                new_index.push(new_tape.len());
                new_tape.push((tape[index].clone(), Target::Original));
                index += 1;
            }
        }
    }
    new_index.push(new_tape.len());
    let lane_tape = new_tape.into_iter().map(|(mut instr, target)| {
        if let Instr::SkipIfNoLane { target: to, .. } | Instr::JumpIf { target: to, .. } | Instr::Jump { target: to } = &mut instr {
            *to = match target {
                Target::Original => new_index[*to as usize] as u32,
                Target::New(index) => index as u32,
            };
        }
        instr
    });
    Cow::Owned(Program { lane_tape: lane_tape.collect(), ..program.clone() })
}

/// What the target of a jump on the new tape refers to.
#[derive(Clone, Copy)]
enum Target {
    /// An index on the original tape.
    Original,
    /// An index on the new tape.
    New(usize),
}

/// Appends both bodies of a loop, and after them the copies for jumps out of the second body.
fn append_doubled(
    tape: &[Instr],
    found: &InnerLoop,
    pairs: &[ExchangedPair],
    new_index: &mut Vec<usize>,
    new_tape: &mut Vec<(Instr, Target)>,
) {
    let InnerLoop { head, first_copy, back_jump } = *found;
    let is_removed = |index: usize| {
        index >= first_copy && copy_operands(&tape[index]).is_some_and(|(variable, _)| pairs.iter().any(|p| p.variable == variable))
    };
    let kept: Vec<usize> = (head..back_jump).filter(|index| !is_removed(*index)).collect();
    // Where the two bodies begin on the new tape.
    let (first_body, second_body) = (new_tape.len(), new_tape.len() + kept.len());
    // Where an instruction of the loop is within either new body. A removed instruction has the position of the next instruction that is kept.
    let position = |index: usize| kept.partition_point(|k| *k < index);
    new_index.extend((head..back_jump).map(|index| first_body + position(index)));
    // The entry of the jump back. Nothing jumps to it, but `new_index` has one entry for each instruction.
    new_index.push(second_body);
    new_tape.extend(kept.iter().map(|index| (tape[*index].clone(), Target::Original)));
    // After the second body and its jump back come its exits, one for each instruction outside the loop to which it jumps: the copies, and a jump there.
    let first_exit = second_body + kept.len() + 1;
    let mut exit_targets: Vec<usize> = Vec::new();
    for index in &kept {
        let instr = exchanged(&tape[*index], pairs);
        let target = match instr.target().map(|t| t as usize) {
            Some(to) if (head..=back_jump).contains(&to) => Target::New(second_body + position(to)),
            Some(to) => {
                let exit = exit_targets.iter().position(|e| *e == to).unwrap_or_else(|| {
                    exit_targets.push(to);
                    exit_targets.len() - 1
                });
                Target::New(first_exit + exit * (pairs.len() + 1))
            }
            None => Target::Original,
        };
        new_tape.push((instr, target));
    }
    // `Target::New` replaces the 0.
    new_tape.push((Instr::Jump { target: 0 }, Target::New(first_body)));
    for target in exit_targets {
        new_tape.extend(pairs.iter().map(|p| (copy_instr(p.variable, p.next), Target::Original)));
        new_tape.push((Instr::Jump { target: target as u32 }, Target::Original));
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
        // Inside: no jump backwards, and none between the copies. From outside: none into the loop, except to its head.
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

/// The variables of a loop whose copies can be left out: no slot or register belongs to two pairs, and no other iteration and nothing after the loop reads the
/// slot or register of the next value before it is written again.
fn exchangeable_pairs(program: &Program, found: &InnerLoop) -> Vec<ExchangedPair> {
    let tape = &program.lane_tape;
    let all: Vec<(Operand, Operand)> = tape[found.first_copy..found.back_jump].iter().filter_map(copy_operands).collect();
    let uses = |operand: Operand| all.iter().flat_map(|(to, from)| [to, from]).filter(|o| **o == operand).count();
    let exits: Vec<usize> = tape[found.head..found.back_jump]
        .iter()
        .filter_map(|instr| instr.target().map(|t| t as usize))
        .filter(|to| !(found.head..=found.back_jump).contains(to))
        .collect();
    all.iter()
        .filter(|(to, from)| uses(*to) == 1 && uses(*from) == 1)
        .filter(|(_, from)| !exits.iter().chain([&found.head]).any(|index| may_be_read(program, *index, *from)))
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
    let number = |operand: Operand| match exchange(operand) {
        Operand::Slot(k) | Operand::Reg(k) => k,
    };
    let mut instr = instr.clone();
    match &mut instr {
        Instr::Lane { dst, args, .. } | Instr::FusedKernel { dst, args, .. } => {
            *dst = number(Operand::Slot(*dst));
            args.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::Scalar { dst, args, .. } => {
            *dst = number(Operand::Reg(*dst));
            args.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::LoadUniform { dst, index, .. } => {
            *dst = number(Operand::Reg(*dst));
            index.iter_mut().for_each(|a| *a = exchange(*a));
        }
        Instr::GatherUniform { dst, index, .. } => {
            *dst = number(Operand::Slot(*dst));
            *index = exchange(*index);
        }
        Instr::Texture { dst, args, mask, .. } => {
            dst.iter_mut().for_each(|d| *d = number(Operand::Slot(*d)));
            args.iter_mut().for_each(|a| *a = exchange(*a));
            *mask = exchange(*mask);
        }
        Instr::TextureSize { dst, level, .. } => {
            *dst = number(Operand::Reg(*dst));
            *level = exchange(*level);
        }
        Instr::SkipIfNoLane { mask: operand, .. } | Instr::JumpIf { cond: operand, .. } => *operand = exchange(*operand),
        Instr::Jump { .. } => {}
    }
    instr
}
