//! Binds a program to kernels: instructions become straight runs of kernel calls, and between them the steps that decide where to go.
//!
//! In: a program and a kernel class. Out: [`BoundProgram`]. Always: every place lies inside the arena that the executor makes for the program.
//! Not here: running it.

use super::LANES;
use crate::render::software::kernels::{self, KernelClass, KernelFn, ScalarFn};
use crate::render::software::math::Real;
use crate::render::software::program::Program;
use crate::render::software::tape::{FusedOp, Instr, Op, Operand, TextureOp, WordKind};
use smallvec::SmallVec;

/// A kernel ready to be called. Places are element offsets from the start of the arena.
pub struct KernelStep<R> {
    pub run: KernelFn<R>,
    /// The place that it writes.
    pub dst: u32,
    /// Where the places of its operands begin in [`BoundProgram::places`].
    pub operands: u32,
}

/// Four steps in a cache line.
const _: () = assert!(size_of::<KernelStep<f32>>() <= 16);

/// The mask that a texture is read under.
#[derive(Clone, Copy)]
pub enum Mask {
    Slot(u32),
    Register(usize),
}

/// One step of a bound program.
pub enum BoundStep<R> {
    /// The kernels `from..to`, one after the other, for so many instructions.
    Kernels {
        from: u32,
        to: u32,
        instructions: u32,
    },
    /// An operation on registers, which are counted from the first of the arena's.
    Scalar {
        run: ScalarFn<R>,
        dst: usize,
        args: [usize; 3],
    },
    /// A load from the uniform block into a register.
    Load(Instr),
    Gather {
        dst: u32,
        kind: WordKind,
        offset: u32,
        index: u32,
        stride: u32,
        count: u32,
    },
    Texture {
        what: TextureOp,
        texture: usize,
        dst: [u32; 4],
        /// Which of the four are ever read.
        wanted: [bool; 4],
        args: [u32; 7],
        mask: Mask,
    },
    TextureSize {
        dst: usize,
        texture: usize,
        axis: u8,
        level: usize,
    },
    SkipIfNone {
        slot: u32,
        target: u32,
    },
    JumpIf {
        register: usize,
        when: bool,
        target: u32,
    },
    Jump {
        target: u32,
    },
}

/// A bound program: straight runs of kernels, and between them what decides where to go.
pub struct BoundProgram<R> {
    pub steps: Vec<BoundStep<R>>,
    pub kernels: Vec<KernelStep<R>>,
    /// The operands of every kernel, in their order.
    pub places: Vec<u32>,
}

/// Slots after the program's own: the first hold broadcast operands of kernels that take lanes only, the last two results inside a chain.
pub const SCRATCH: u32 = 8;

/// Binds a program to the kernels of a class. `first_register`: row of the arena where the registers start.
///
/// # Errors
/// A chain that has no kernel, or an operation without operands.
pub(super) fn bind<R: Real>(program: &Program, class: KernelClass, first_register: usize) -> Result<BoundProgram<R>, String> {
    let mut binder = Binder {
        bound: BoundProgram { steps: Vec::new(), kernels: Vec::with_capacity(program.lane_tape.len()), places: Vec::new() },
        class,
        scratch: program.slots,
        registers_at: first_register * LANES,
        open: false,
    };
    let mut targets = vec![false; program.lane_tape.len() + 1];
    for target in program.lane_tape.iter().filter_map(Instr::target) {
        targets[target as usize] = true;
    }
    let mut starts = Vec::with_capacity(program.lane_tape.len() + 1);
    for (at, (instr, entered)) in program.lane_tape.iter().zip(&targets).enumerate() {
        // Who jumps here must not run what stands before.
        binder.open &= !entered;
        let step = binder.bound.steps.len() as u32;
        starts.push(if binder.open { step - 1 } else { step });
        binder.bind(instr, |slot| is_read_after(program, at, slot))?;
    }
    let mut bound = binder.bound;
    starts.push(bound.steps.len() as u32);
    for step in &mut bound.steps {
        if let BoundStep::SkipIfNone { target, .. } | BoundStep::JumpIf { target, .. } | BoundStep::Jump { target } = step {
            *target = starts[*target as usize];
        }
    }
    Ok(bound)
}

/// Whether what an instruction writes into a slot is read: before the next write in the order of the tape. A value that goes round a loop is copied before
/// the loop's end; where a jump passes over the next write, what is read behind it is of no lane's concern, whichever value that is.
fn is_read_after(program: &Program, at: usize, slot: u16) -> bool {
    let reads = |o: &Operand| *o == Operand::Slot(slot);
    for instr in &program.lane_tape[at + 1..] {
        if instr.operands().iter().any(reads) {
            return true;
        }
        if instr.written_slots().contains(&slot) {
            return false;
        }
    }
    program.output_operands.iter().chain(&program.discarded).any(reads)
}

fn is_lanes(o: &Operand) -> bool {
    matches!(o, Operand::Slot(_))
}

/// Turns instructions into steps.
struct Binder<R> {
    bound: BoundProgram<R>,
    class: KernelClass,
    /// First scratch slot.
    scratch: u32,
    /// Element offset of register 0.
    registers_at: usize,
    /// The last step is a run of kernels that may grow.
    open: bool,
}

impl<R: Real> Binder<R> {
    fn place(&self, o: &Operand) -> u32 {
        let at = match *o {
            Operand::Slot(s) => usize::from(s) * LANES,
            Operand::Reg(r) => self.registers_at + usize::from(r),
        };
        at as u32
    }

    fn slot_place(slot: u32) -> u32 {
        slot * LANES as u32
    }

    fn kernel(&mut self, run: KernelFn<R>, dst: u32, args: &[u32]) {
        let to = self.bound.kernels.len() as u32 + 1;
        self.bound.kernels.push(KernelStep { run, dst, operands: self.bound.places.len() as u32 });
        self.bound.places.extend(args);
        match self.bound.steps.last_mut() {
            Some(BoundStep::Kernels { to: end, instructions, .. }) if self.open => {
                *end = to;
                *instructions += 1;
            }
            _ => self.bound.steps.push(BoundStep::Kernels { from: to - 1, to, instructions: 1 }),
        }
        self.open = true;
    }

    fn step(&mut self, step: BoundStep<R>) {
        self.bound.steps.push(step);
        self.open = false;
    }

    /// The slot of an operand that must be lanes; one value for all lanes is spread over scratch slot `used`.
    fn lanes(&mut self, o: &Operand, used: &mut u32) -> Result<u32, String> {
        if let Operand::Slot(s) = *o {
            return Ok(u32::from(s));
        }
        let slot = self.scratch + *used;
        *used += 1;
        if *used > SCRATCH {
            return Err(format!("more than {SCRATCH} operands"));
        }
        let from = self.place(o);
        match R::special(self.class, Op::Copy, [false; 3]) {
            Some(spread) => self.kernel(spread, Self::slot_place(slot), &[from; 3]),
            None => unreachable!("one value is spread by its own kernel"),
        }
        Ok(slot)
    }

    /// One operation. Operands that its kernel cannot take as broadcast go through scratch slots after the program's own.
    fn operation(&mut self, op: Op, dst: u32, args: &[Operand]) -> Result<(), String> {
        let first = args.first().ok_or("an operation without operands")?;
        let operand = |k: usize| args.get(k).unwrap_or(first);
        match R::special(self.class, op, [0, 1, 2].map(|k| is_lanes(operand(k)))) {
            Some(run) => self.kernel(run, dst, &[0, 1, 2].map(|k| self.place(operand(k)))),
            None => {
                let mut used = 0;
                let mut places = [Self::slot_place(self.lanes(first, &mut used)?); 3];
                for (place, o) in places.iter_mut().zip(args).skip(1) {
                    *place = Self::slot_place(self.lanes(o, &mut used)?);
                }
                self.kernel(R::general(self.class, op), dst, &places);
            }
        }
        Ok(())
    }

    /// A chain, by one kernel where the class has it; else as its operations, which hand their results on in two scratch slots.
    fn chain(&mut self, links: &[FusedOp], dst: u32, args: &[Operand]) -> Result<(), String> {
        let kinds = args.iter().take(kernels::chains::MAX_OPERANDS).enumerate().map(|(k, o)| u8::from(is_lanes(o)) << k).sum();
        let whole = args.len() == kernels::chains::takes(links);
        let found = if whole { kernels::chains::find(links, kinds) } else { None };
        let found = found.ok_or_else(|| format!("no kernel for the chain {links:?} with these operands"))?;
        if let Some(run) = R::chained(self.class).get(found) {
            let places: Vec<u32> = args.iter().map(|o| self.place(o)).collect();
            self.kernel(*run, dst, &places);
            return Ok(());
        }
        let kernels_before = self.bound.kernels.len();
        let mut rest = args;
        let mut result = None;
        for (k, link) in links.iter().enumerate() {
            let (own, further) = rest.split_at(link.op.arity() - usize::from(result.is_some()));
            let mut operands: SmallVec<[Operand; 3]> = own.into();
            if let Some(result) = result {
                operands.insert(usize::from(link.at), result);
            }
            rest = further;
            let handed_on = self.scratch + SCRATCH - 1 - k as u32 % 2;
            let to = if k + 1 == links.len() { dst } else { Self::slot_place(handed_on) };
            self.operation(link.op, to, &operands)?;
            result = Some(Operand::Slot(handed_on as u16));
        }
        // What a chain costs does not depend on the machine.
        if let Some(BoundStep::Kernels { instructions, .. }) = self.bound.steps.last_mut() {
            *instructions -= (self.bound.kernels.len() - kernels_before - 1) as u32;
        }
        Ok(())
    }

    /// `is_read`: whether what the instruction writes into a slot is read.
    fn bind(&mut self, instr: &Instr, is_read: impl Fn(u16) -> bool) -> Result<(), String> {
        let mut used = 0;
        let register = |o: &Operand| match *o {
            Operand::Reg(r) => usize::from(r),
            Operand::Slot(_) => 0,
        };
        match instr {
            Instr::Lane { op, dst, args } => self.operation(*op, Self::slot_place(u32::from(*dst)), args)?,
            Instr::FusedKernel { links, dst, args } => self.chain(links, Self::slot_place(u32::from(*dst)), args)?,
            Instr::Scalar { op, dst, args } => {
                let args = [0, 1, 2].map(|k| args.get(k).or(args.first()).map_or(0, register));
                self.step(BoundStep::Scalar { run: R::scalar(*op, self.class.fused()), dst: usize::from(*dst), args });
            }
            Instr::LoadUniform { .. } => self.step(BoundStep::Load(instr.clone())),
            Instr::GatherUniform { dst, kind, offset, index, stride, count } => {
                let index = self.lanes(index, &mut used)?;
                self.step(BoundStep::Gather { dst: u32::from(*dst), kind: *kind, offset: *offset, index, stride: *stride, count: *count });
            }
            Instr::Texture { what, texture, dst, args, mask } => {
                let mut slots = [0u32; 7];
                for (s, o) in slots.iter_mut().zip(args) {
                    *s = self.lanes(o, &mut used)?;
                }
                let mask = match mask {
                    Operand::Slot(s) => Mask::Slot(u32::from(*s)),
                    Operand::Reg(r) => Mask::Register(usize::from(*r)),
                };
                let (wanted, dst) = (dst.map(is_read), dst.map(u32::from));
                self.step(BoundStep::Texture { what: *what, texture: usize::from(*texture), dst, wanted, args: slots, mask });
            }
            Instr::TextureSize { dst, texture, axis, level } => {
                self.step(BoundStep::TextureSize {
                    dst: usize::from(*dst),
                    texture: usize::from(*texture),
                    axis: *axis,
                    level: register(level),
                });
            }
            Instr::SkipIfNone { mask, target } => {
                let slot = self.lanes(mask, &mut used)?;
                self.step(BoundStep::SkipIfNone { slot, target: *target });
            }
            Instr::JumpIf { cond, when, target } => {
                self.step(BoundStep::JumpIf { register: register(cond), when: *when, target: *target });
            }
            Instr::Jump { target } => self.step(BoundStep::Jump { target: *target }),
        }
        Ok(())
    }
}
