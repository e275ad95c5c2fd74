//! Binds a program to SIMD kernels: instructions become sequences of kernel calls, with control-flow and texture steps between them.
//!
//! In: a program and a kernel class (instruction set). Out: [`BoundProgram`]. Always: every offset lies inside the arena, the memory that the executor
//! allocates for the program's slots and registers. Not here: running the program.

use super::LANES;
use super::uniform_words::UniformElements;
use super::unroll_loops::unroll_loops;
use crate::render::software::kernels::{self, KernelClass, KernelFn, ScalarFn};
use crate::render::software::math::Real;
use crate::render::software::program::Program;
use crate::render::software::tape::{FusedOp, Instr, Op, Operand, TextureOp};
use smallvec::SmallVec;
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// A call of a kernel. Offsets are in elements (values of type `R`) from the start of the arena.
pub(crate) struct KernelCall<R> {
    pub function: KernelFn<R>,
    /// Offset of the lanes that the kernel writes.
    pub dst: u32,
    /// Index in [`BoundProgram::operand_offsets`] of the kernel's first operand.
    pub first_operand: u32,
}

/// Four calls fit into a cache line.
const _: () = assert!(size_of::<KernelCall<f32>>() <= 16);

/// A call of an operation on registers. Registers are given by number.
pub(crate) struct ScalarCall<R> {
    pub function: ScalarFn<R>,
    pub dst: u32,
    /// An operation with fewer operands ignores the last ones.
    pub args: [u32; 3],
}

/// A load of a word of the uniform block into a register. `elements`: where the word is in each element of an array.
pub(crate) struct UniformLoad {
    pub dst: u32,
    pub elements: UniformElements,
    /// The register with the array element's index; `None`: the first element.
    pub index: Option<u32>,
}

/// The number of the slot or register that contains the mask of the lanes for which a texture is read.
#[derive(Clone, Copy)]
pub(crate) enum MaskLocation {
    Slot(u32),
    Register(usize),
}

/// An operand of a texture read: the part of the arena that contains its values.
#[derive(Clone, Copy)]
pub(crate) struct TextureArg {
    /// In elements from the start of the arena.
    pub offset: u32,
    /// Number of elements: `LANES`, or 1 if the operand is one value for all lanes.
    pub len: u32,
}

/// A read of a texture.
pub(crate) struct TextureRead {
    pub op: TextureOp,
    /// Index in the program's list of textures.
    pub texture: usize,
    /// Offset of each channel's lanes, in elements from the start of the arena.
    pub dst: [u32; 4],
    /// Whether the program reads each channel later. A channel that it does not read is not written.
    pub channels_read: [bool; 4],
    /// The operands, at most seven, in the order that [`TextureOp`] states; unused entries follow.
    pub args: [TextureArg; 7],
    pub mask: MaskLocation,
}

/// One step of a bound program. `target`: the index of the step to which a jump goes; until [`bind`] has bound all instructions, that of the instruction.
pub(crate) enum BoundStep {
    /// Runs the kernels `start..end` in order. `instructions`: the number of these kernels, where all kernels of a chain count as one.
    Kernels {
        start: u32,
        end: u32,
        instructions: u32,
    },
    /// Runs the operations on registers `start..end` in order.
    Scalars {
        start: u32,
        end: u32,
    },
    /// Loads words of the uniform block into registers: the loads `start..end`, in order.
    LoadUniforms {
        start: u32,
        end: u32,
    },
    /// For each lane, loads a word of an array element in the uniform block into slot `dst`. The element's index is in slot `index`.
    Gather {
        dst: u32,
        index: u32,
        elements: UniformElements,
    },
    /// Index in [`BoundProgram::texture_reads`].
    Texture(u32),
    /// As [`Instr::TextureSize`]; `dst` and `level` are registers.
    TextureSize {
        dst: usize,
        texture: usize,
        axis: u8,
        level: usize,
    },
    /// Jumps if no lane of the mask in `slot` is set.
    SkipIfNoLane {
        slot: u32,
        target: u32,
    },
    /// Jumps if the boolean in `register` equals `when`.
    JumpIf {
        register: usize,
        when: bool,
        target: u32,
    },
    Jump {
        target: u32,
    },
}

/// A program bound to the kernels of a class: sequences of kernel calls, with control-flow and texture steps between them. Executors of several threads share
/// it.
pub struct BoundProgram<R> {
    pub(super) steps: Vec<BoundStep>,
    pub(super) kernels: Vec<KernelCall<R>>,
    pub(super) scalars: Vec<ScalarCall<R>>,
    pub(super) uniform_loads: Vec<UniformLoad>,
    pub(super) texture_reads: Vec<TextureRead>,
    /// Arena offsets of the operands of every kernel, in the order of `kernels`: three for an operation, for a chain as many as it has operands.
    pub(super) operand_offsets: Vec<u32>,
    /// For each input, whether the program reads it.
    pub(super) inputs_read: Vec<bool>,
    /// Index of the arena's row at which the registers start, after the program's slots and the scratch slots; a row has `LANES` elements.
    pub(super) first_register_row: usize,
    pub(super) register_count: usize,
    /// For each output of the program, its slot.
    pub(super) output_slots: Vec<u32>,
    /// Slot of the mask of discarded lanes; `None` if the program discards none.
    pub(super) discarded: Option<u32>,
}

/// Number of scratch slots after the program's own slots. The first ones hold registers that are broadcast for steps that accept only lanes (at most the
/// coordinates and derivatives of a texture read, six); the last two hold the intermediate results of a chain.
pub(crate) const SCRATCH_SLOTS: u32 = 8;

impl<R: Real> BoundProgram<R> {
    /// Binds a program to the kernels of a class, which must be available on this machine.
    ///
    /// # Errors
    /// A program with an index out of range, a class that this machine lacks, a chain that has no kernel, or an operation without operands.
    pub(crate) fn new(program: &Program, class: KernelClass) -> Result<Self, String> {
        program.check().map_err(|e| e.to_string())?;
        if !KernelClass::available().contains(&class) {
            return Err(format!("this machine lacks the instruction set of the {} kernels", class.name()));
        }
        let slot = |o: &Operand| match *o {
            Operand::Slot(s) => Ok(u32::from(s)),
            Operand::Reg(_) => Err("an output must be a lane value".to_owned()),
        };
        let without_steps = Self {
            steps: Vec::new(),
            kernels: Vec::with_capacity(program.lane_tape.len()),
            scalars: Vec::new(),
            uniform_loads: Vec::new(),
            texture_reads: Vec::new(),
            operand_offsets: Vec::new(),
            inputs_read: program.inputs_read.clone(),
            first_register_row: (program.slot_count + SCRATCH_SLOTS) as usize,
            register_count: program.register_count as usize,
            output_slots: program.output_operands.iter().map(slot).collect::<Result<_, _>>()?,
            discarded: program.discarded.as_ref().map(slot).transpose()?,
        };
        let with_unrolled_loops = unroll_loops(program);
        debug_assert!(with_unrolled_loops.check().is_ok());
        bind(&with_unrolled_loops, class, without_steps)
    }

    /// Whether the program reads input `k`.
    pub(crate) fn reads_input(&self, k: usize) -> bool {
        self.inputs_read.get(k).is_some_and(|is_read| *is_read)
    }
}

/// A program's binding to kernels, kept from frame to frame: binding all programs takes 1 % of the processor's instructions for a frame (measured on the Earth
/// with clouds). Stores the kernel class and the [`BoundProgram`], as `dyn Any` because its type depends on the element type.
#[derive(Debug, Default)]
pub(crate) struct KernelBinding(OnceLock<(KernelClass, Arc<dyn Any + Send + Sync>)>);

impl KernelBinding {
    /// The program bound to a class; binds it at the first call. `program` must be the same at every call.
    ///
    /// # Errors
    /// As [`BoundProgram::new`].
    pub(crate) fn get<R: Real>(&self, program: &Program, class: KernelClass) -> Result<Arc<BoundProgram<R>>, String> {
        if let Some((_, bound)) = self.0.get().filter(|(bound_class, _)| *bound_class == class)
            && let Ok(bound) = Arc::clone(bound).downcast()
        {
            return Ok(bound);
        }
        let bound = Arc::new(BoundProgram::new(program, class)?);
        // Only the first binding is kept: a renderer has one class and one precision.
        let _ = self.0.set((class, Arc::clone(&bound) as _));
        Ok(bound)
    }
}

/// Binds the instructions of a program. `without_steps`: the bound program, without its steps, kernels and other lists that they index.
fn bind<R: Real>(program: &Program, class: KernelClass, without_steps: BoundProgram<R>) -> Result<BoundProgram<R>, String> {
    let register_offset = without_steps.first_register_row * LANES;
    let mut binder =
        Binder { bound: without_steps, class, first_scratch_slot: program.slot_count, register_offset, can_extend_sequence: false };
    let mut is_target = vec![false; program.lane_tape.len() + 1];
    for target in program.lane_tape.iter().filter_map(Instr::target) {
        is_target[target as usize] = true;
    }
    let mut step_of_instr = Vec::with_capacity(program.lane_tape.len() + 1);
    for (instr, is_target) in program.lane_tape.iter().zip(&is_target) {
        // A jump target starts a new step. For an instruction that extends the previous step, the index recorded here is one too great, but no jump refers to
        // it.
        binder.can_extend_sequence &= !is_target;
        step_of_instr.push(binder.bound.steps.len() as u32);
        binder.bind(instr)?;
    }
    let mut bound = binder.bound;
    step_of_instr.push(bound.steps.len() as u32);
    for step in &mut bound.steps {
        if let BoundStep::SkipIfNoLane { target, .. } | BoundStep::JumpIf { target, .. } | BoundStep::Jump { target } = step {
            *target = step_of_instr[*target as usize];
        }
    }
    Ok(bound)
}

fn is_per_lane(o: &Operand) -> bool {
    matches!(o, Operand::Slot(_))
}

/// Turns instructions into steps.
struct Binder<R> {
    bound: BoundProgram<R>,
    class: KernelClass,
    first_scratch_slot: u32,
    /// Offset of register 0, in elements from the start of the arena.
    register_offset: usize,
    /// Whether the last step is a sequence of kernels, of operations on registers or of loads, to which further ones may be appended.
    can_extend_sequence: bool,
}

impl<R: Real> Binder<R> {
    /// Offset of an operand, in elements from the start of the arena.
    fn offset(&self, o: &Operand) -> u32 {
        let offset = match *o {
            Operand::Slot(s) => usize::from(s) * LANES,
            Operand::Reg(r) => self.register_offset + usize::from(r),
        };
        offset as u32
    }

    /// Offset of a slot's first lane, in elements from the start of the arena.
    fn slot_offset(slot: u32) -> u32 {
        slot * LANES as u32
    }

    /// Appends a kernel to the last sequence of kernels, or begins a new sequence; the two methods below do the same for their kinds of steps. `dst` and
    /// `args`: offsets in the arena.
    fn push_kernel(&mut self, function: KernelFn<R>, dst: u32, args: &[u32]) {
        let end = self.bound.kernels.len() as u32 + 1;
        self.bound.kernels.push(KernelCall { function, dst, first_operand: self.bound.operand_offsets.len() as u32 });
        self.bound.operand_offsets.extend(args);
        match self.bound.steps.last_mut() {
            Some(BoundStep::Kernels { end: sequence_end, instructions, .. }) if self.can_extend_sequence => {
                *sequence_end = end;
                *instructions += 1;
            }
            _ => self.bound.steps.push(BoundStep::Kernels { start: end - 1, end, instructions: 1 }),
        }
        self.can_extend_sequence = true;
    }

    fn push_scalar(&mut self, call: ScalarCall<R>) {
        let end = self.bound.scalars.len() as u32 + 1;
        self.bound.scalars.push(call);
        match self.bound.steps.last_mut() {
            Some(BoundStep::Scalars { end: sequence_end, .. }) if self.can_extend_sequence => *sequence_end = end,
            _ => self.bound.steps.push(BoundStep::Scalars { start: end - 1, end }),
        }
        self.can_extend_sequence = true;
    }

    fn push_uniform_load(&mut self, load: UniformLoad) {
        let end = self.bound.uniform_loads.len() as u32 + 1;
        self.bound.uniform_loads.push(load);
        match self.bound.steps.last_mut() {
            Some(BoundStep::LoadUniforms { end: sequence_end, .. }) if self.can_extend_sequence => *sequence_end = end,
            _ => self.bound.steps.push(BoundStep::LoadUniforms { start: end - 1, end }),
        }
        self.can_extend_sequence = true;
    }

    /// Appends a step that is not a sequence.
    fn push_step(&mut self, step: BoundStep) {
        self.bound.steps.push(step);
        self.can_extend_sequence = false;
    }

    /// The slot of an operand that must have one value per lane. A register is first broadcast to the next scratch slot. `scratch_used`: number of scratch
    /// slots in use by this instruction.
    fn slot_of(&mut self, o: &Operand, scratch_used: &mut u32) -> Result<u32, String> {
        if let Operand::Slot(s) = *o {
            return Ok(u32::from(s));
        }
        let slot = self.first_scratch_slot + *scratch_used;
        *scratch_used += 1;
        if *scratch_used > SCRATCH_SLOTS {
            return Err(format!("more than {SCRATCH_SLOTS} operands"));
        }
        let from = self.offset(o);
        let are_operands_per_lane = [false; 3];
        match R::specialised(self.class, Op::Copy, are_operands_per_lane) {
            Some(broadcast) => self.push_kernel(broadcast, Self::slot_offset(slot), &[from; 3]),
            None => unreachable!("a copy of one value to all lanes has a specialised kernel"),
        }
        Ok(slot)
    }

    /// Binds one operation. If no specialised kernel accepts these operand kinds, registers are first broadcast to scratch slots, because the generic kernel
    /// accepts only slots. `dst_offset`: of the result in the arena.
    fn bind_operation(&mut self, op: Op, dst_offset: u32, args: &[Operand]) -> Result<(), String> {
        let first = args.first().ok_or("an operation without operands")?;
        // A kernel of one operation takes three operands. The first operand stands in for those that the operation lacks.
        let operand = |k: usize| args.get(k).unwrap_or(first);
        match R::specialised(self.class, op, [0, 1, 2].map(|k| is_per_lane(operand(k)))) {
            Some(function) => self.push_kernel(function, dst_offset, &[0, 1, 2].map(|k| self.offset(operand(k)))),
            None => {
                let mut scratch_used = 0;
                let mut offsets = [Self::slot_offset(self.slot_of(first, &mut scratch_used)?); 3];
                for (offset, o) in offsets.iter_mut().zip(args).skip(1) {
                    *offset = Self::slot_offset(self.slot_of(o, &mut scratch_used)?);
                }
                self.push_kernel(R::generic(self.class, op), dst_offset, &offsets);
            }
        }
        Ok(())
    }

    /// Binds a chain: one kernel if the class has chain kernels, else its operations one by one, with intermediate results in two scratch slots.
    fn bind_chain(&mut self, ops: &[FusedOp], dst_offset: u32, args: &[Operand]) -> Result<(), String> {
        // Bit k: whether operand k has one value per lane.
        let kinds = args.iter().take(kernels::chains::MAX_OPERANDS).enumerate().map(|(k, o)| u8::from(is_per_lane(o)) << k).sum();
        let is_complete = args.len() == kernels::chains::operand_count(ops);
        let index = if is_complete { kernels::chains::find(ops, kinds) } else { None };
        let index = index.ok_or_else(|| format!("no kernel for the chain {ops:?} with these operands"))?;
        if let Some(function) = R::chain_kernels(self.class).get(index) {
            let offsets: Vec<u32> = args.iter().map(|o| self.offset(o)).collect();
            self.push_kernel(*function, dst_offset, &offsets);
            return Ok(());
        }
        let kernels_before = self.bound.kernels.len();
        let mut rest = args;
        let mut result = None;
        for (k, fused_op) in ops.iter().enumerate() {
            let (own_operands, later_operands) = rest.split_at(fused_op.op.arity() - usize::from(result.is_some()));
            let mut operands: SmallVec<[Operand; 3]> = own_operands.into();
            if let Some(result) = result {
                operands.insert(usize::from(fused_op.chained_operand), result);
            }
            rest = later_operands;
            // The scratch slots alternate, so that no operation writes the slot that it reads.
            let intermediate = self.first_scratch_slot + SCRATCH_SLOTS - 1 - k as u32 % 2;
            let result_offset = if k + 1 == ops.len() { dst_offset } else { Self::slot_offset(intermediate) };
            self.bind_operation(fused_op.op, result_offset, &operands)?;
            result = Some(Operand::Slot(intermediate as u16));
        }
        // A chain counts as one instruction in every class, so that counts are the same on every machine. All its kernels are in the last sequence, because
        // nothing between them ends it.
        if let Some(BoundStep::Kernels { instructions, .. }) = self.bound.steps.last_mut() {
            *instructions -= (self.bound.kernels.len() - kernels_before - 1) as u32;
        }
        Ok(())
    }

    /// Binds one instruction.
    fn bind(&mut self, instr: &Instr) -> Result<(), String> {
        let mut scratch_used = 0;
        // `Program::check` has verified that the operands to which this is applied are registers.
        let register = |o: &Operand| match *o {
            Operand::Reg(r) => usize::from(r),
            Operand::Slot(_) => 0,
        };
        match instr {
            Instr::Lane { op, dst, args } => self.bind_operation(*op, Self::slot_offset(u32::from(*dst)), args)?,
            Instr::FusedKernel { ops, dst, args } => self.bind_chain(ops, Self::slot_offset(u32::from(*dst)), args)?,
            Instr::Scalar { op, dst, args } => {
                let args = [0, 1, 2].map(|k| args.get(k).or(args.first()).map_or(0, register) as u32);
                self.push_scalar(ScalarCall { function: R::scalar(*op, self.class.has_fma()), dst: u32::from(*dst), args });
            }
            Instr::LoadUniform { dst, kind, offset, index, stride, count } => {
                let elements = UniformElements { kind: *kind, offset: *offset, stride: *stride, count: *count };
                self.push_uniform_load(UniformLoad { dst: u32::from(*dst), elements, index: index.as_ref().map(|o| register(o) as u32) });
            }
            Instr::GatherUniform { dst, kind, offset, index, stride, count } => {
                let index = self.slot_of(index, &mut scratch_used)?;
                let elements = UniformElements { kind: *kind, offset: *offset, stride: *stride, count: *count };
                self.push_step(BoundStep::Gather { dst: u32::from(*dst), index, elements });
            }
            Instr::Texture { op, texture, dst, channels_read, args, mask } => {
                let mut texture_args = [TextureArg { offset: 0, len: LANES as u32 }; 7];
                for (k, (to, o)) in texture_args.iter_mut().zip(args).enumerate() {
                    *to = match o {
                        // The operands for which a read accepts one value for all lanes: y and level of a texel load, and the maximum number of taps of a
                        // filtered read.
                        Operand::Reg(_) if (*op == TextureOp::Load && k > 0) || (*op == TextureOp::Filtered && k == 6) => {
                            TextureArg { offset: self.offset(o), len: 1 }
                        }
                        _ => TextureArg { offset: Self::slot_offset(self.slot_of(o, &mut scratch_used)?), len: LANES as u32 },
                    };
                }
                let mask = match mask {
                    Operand::Slot(s) => MaskLocation::Slot(u32::from(*s)),
                    Operand::Reg(r) => MaskLocation::Register(usize::from(*r)),
                };
                let dst = dst.map(|slot| Self::slot_offset(u32::from(slot)));
                let channels_read = *channels_read;
                let read = TextureRead { op: *op, texture: usize::from(*texture), dst, channels_read, args: texture_args, mask };
                self.bound.texture_reads.push(read);
                self.push_step(BoundStep::Texture(self.bound.texture_reads.len() as u32 - 1));
            }
            Instr::TextureSize { dst, texture, axis, level } => {
                self.push_step(BoundStep::TextureSize {
                    dst: usize::from(*dst),
                    texture: usize::from(*texture),
                    axis: *axis,
                    level: register(level),
                });
            }
            Instr::SkipIfNoLane { mask, target } => {
                let slot = self.slot_of(mask, &mut scratch_used)?;
                self.push_step(BoundStep::SkipIfNoLane { slot, target: *target });
            }
            Instr::JumpIf { cond, when, target } => {
                self.push_step(BoundStep::JumpIf { register: register(cond), when: *when, target: *target });
            }
            Instr::Jump { target } => self.push_step(BoundStep::Jump { target: *target }),
        }
        Ok(())
    }
}
