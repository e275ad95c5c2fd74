//! Runs a [`Program`] over batches of lanes.
//!
//! In: the uniform bytes of a draw (once, [`Program::run_draw_tape`]), then per batch the lane inputs, the mask of active lanes and the textures. Out: the
//! lane outputs and the mask of lanes that were not discarded. Always: inactive lanes may contain any bits, and no operation traps; a program is bound to
//! kernels once ([`BoundProgram`]), and a batch allocates nothing.

mod bind;
#[cfg(target_arch = "x86_64")]
mod lane_masks;
mod textures;
mod uniform_words;
mod unroll_loops;

pub use super::kernels::LANES;
use super::kernels::{self, KernelClass};
use super::math::Real;
use super::program::{Constant, Program};
use super::tape::{Instr, Operand, TextureOp};
pub use bind::BoundProgram;
pub(crate) use bind::KernelBinding;
use bind::{BoundStep, KernelCall, MaskLocation, ScalarCall, TextureRead, UniformLoad};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
pub use textures::{Gradients, NoTextures, TextureUnit};
use uniform_words::UniformElements;

/// Backward jumps after which a batch is stopped, so that an endless loop does not hang a frame. An unrolled loop (`unroll_loops`) jumps back once in two
/// iterations, so it may make twice as many.
const MAX_BACKWARD_JUMPS: u32 = 1 << 20;
/// Instructions of a batch, counted as in [`ExecutionCounts`], after which it is stopped at its next backward jump: a loop with long iterations would run for
/// too long before it reaches [`MAX_BACKWARD_JUMPS`]. A batch of the most expensive shipped module runs some 10^4 instructions; 2^25 take about a second.
const MAX_BATCH_INSTRUCTIONS: u32 = 1 << 25;
/// A texture read counts as this many instructions towards [`MAX_BATCH_INSTRUCTIONS`].
const INSTRUCTIONS_PER_TEXTURE_READ: u32 = 64;

/// A set of a batch's lanes: bit i is lane i.
pub type LaneMask = u128;
// Kernels process whole chunks.
const _: () = assert!(LANES == LaneMask::BITS as usize && LANES.is_multiple_of(kernels::CHUNK));

/// Entry k has only bit k set: the bit of lane k in a 32-bit part of a [`LaneMask`]. Loops that expand or collect masks with this table are vectorised; loops
/// that shift by the lane number are not.
pub(crate) const LANE_BITS: [u32; 32] = {
    let mut bits = [0; 32];
    let mut k = 0;
    while k < 32 {
        bits[k] = 1 << k;
        k += 1;
    }
    bits
};

/// The values of a program for one draw: the registers after the draw tape (the instructions that run once per draw) has run, and the uniform block, which the
/// lane tape (the instructions that run per batch) may read.
#[derive(Clone, Debug)]
pub struct DrawTapeValues<R> {
    /// A different number for each run of a draw tape, by which an executor knows whether these are the values in its registers.
    id: u64,
    registers: Vec<R>,
    uniform_words: Vec<u32>,
}

fn constant_value<R: Real>(c: Constant) -> R {
    match c {
        Constant::Float(x) => R::from_f64(x),
        Constant::Int(i) => R::from_lane_bits(i),
        Constant::Bool(b) => R::from_mask(b),
    }
}

/// Width (axis 0) or height (axis 1) of a level of a texture in texels, or the texture's number of levels (axis 2).
fn texture_size<R: Real>(textures: &dyn TextureUnit<R>, texture: usize, axis: u8, level: u32) -> u32 {
    if axis > 1 { textures.levels(texture) } else { textures.dimensions(texture, level)[usize::from(axis)] }
}

/// The register that an instruction of the draw tape writes, and its new value. `has_fma`: whether multiply-adds round once; `words`: the uniform block;
/// `textures`: those of the draw; `register`: the value of a register. `None` for an instruction that cannot be on the draw tape.
fn evaluate_scalar<R: Real>(
    instr: &Instr,
    has_fma: bool,
    words: &[u32],
    textures: &dyn TextureUnit<R>,
    register: impl Fn(usize) -> R,
) -> Option<(usize, R)> {
    // No operand of the draw tape is a slot (`Instr::is_per_draw`).
    let read = |o: &Operand| match *o {
        Operand::Reg(r) => register(usize::from(r)),
        Operand::Slot(_) => R::ZERO,
    };
    match instr {
        Instr::Scalar { op, dst, args } => {
            let arg = |k: usize| args.get(k).map_or(R::ZERO, read);
            Some((usize::from(*dst), kernels::eval(*op, has_fma, arg(0), arg(1), arg(2))))
        }
        Instr::LoadUniform { dst, kind, offset, index, stride, count } => {
            let element_index = index.as_ref().map_or(0, |o| read(o).lane_bits());
            let elements = UniformElements { kind: *kind, offset: *offset, stride: *stride, count: *count };
            Some((usize::from(*dst), elements.read(words, element_index)))
        }
        Instr::TextureSize { dst, texture, axis, level } => {
            let size = texture_size(textures, usize::from(*texture), *axis, read(level).lane_bits());
            Some((usize::from(*dst), R::from_lane_bits(size)))
        }
        _ => None,
    }
}

impl Program {
    /// Runs the draw tape on the bytes of the uniform block (little-endian words; words beyond the last one read as zero). `class` determines whether a
    /// multiply-add rounds once or twice. `textures`: those of the draw, of which only the sizes are read.
    pub fn run_draw_tape<R: Real>(&self, uniform_bytes: &[u8], class: KernelClass, textures: &dyn TextureUnit<R>) -> DrawTapeValues<R> {
        let words: Vec<u32> = uniform_bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let mut registers = vec![R::ZERO; self.register_count as usize];
        for (r, c) in registers.iter_mut().zip(&self.constants) {
            *r = constant_value(*c);
        }
        for instr in &self.draw_tape {
            if let Some((r, value)) = evaluate_scalar(instr, class.has_fma(), &words, textures, |r| registers[r]) {
                registers[r] = value;
            }
        }
        static LAST_ID: AtomicU64 = AtomicU64::new(0);
        let id = LAST_ID.fetch_add(1, Ordering::Relaxed) + 1;
        DrawTapeValues { id, registers, uniform_words: words }
    }
}

/// One value per lane.
#[repr(C, align(64))]
#[derive(Clone)]
struct LaneRow<R>([R; LANES]);
const _: () = assert!(size_of::<LaneRow<f32>>() == 4 * LANES && size_of::<LaneRow<f64>>() == 8 * LANES);

/// Runs one program with the kernels of one class.
pub struct Executor<R: Real> {
    /// One row for each slot of the program, then the scratch slots (for operands and intermediate results of kernels), then the registers, `LANES` to a row.
    /// One allocation, so that every operand is an offset from one base.
    arena: Vec<LaneRow<R>>,
    /// [`DrawTapeValues::id`] of the values in the registers; 0 at first.
    draw_values_id: u64,
    program: Arc<BoundProgram<R>>,
    counts: ExecutionCounts,
    hit_loop_limit: bool,
}

/// Number of instructions and texture reads of a run. An instruction is a kernel call, which computes all lanes; a chain is one instruction even if it takes
/// several calls. Operations on registers and loads from the uniform block are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExecutionCounts {
    pub instructions: u32,
    pub texture_reads: u32,
}

impl<R: Real> Executor<R> {
    /// Binds the program to the kernels of this process's class ([`KernelClass::in_use`]).
    ///
    /// # Errors
    /// As [`Executor::with_class`].
    pub fn new(program: &Program) -> Result<Self, String> {
        Self::with_class(program, KernelClass::in_use())
    }

    /// Binds the program to the kernels of a class, which must be available on this machine.
    ///
    /// # Errors
    /// A program with an index out of range (see [`Program::check`]), a chain that has no kernel, an operation without operands, or a class that this
    /// machine lacks.
    pub fn with_class(program: &Program, class: KernelClass) -> Result<Self, String> {
        Ok(Self::of(Arc::new(BoundProgram::new(program, class)?)))
    }

    /// An executor of a bound program.
    pub(crate) fn of(program: Arc<BoundProgram<R>>) -> Self {
        let rows = program.first_register_row + program.register_count.div_ceil(LANES);
        let arena = vec![LaneRow([R::ZERO; LANES]); rows];
        Self { arena, draw_values_id: 0, program, counts: ExecutionCounts::default(), hit_loop_limit: false }
    }

    /// The lanes of input `k`. If the program reads the input, the caller must write it before every run, because a run may overwrite it.
    pub fn input_mut(&mut self, k: usize) -> &mut [R; LANES] {
        assert!(k < self.program.inputs_read.len(), "input {k} of {}", self.program.inputs_read.len());
        &mut self.arena[k].0
    }

    /// Whether the program reads input `k`. The caller need not write an input that the program does not read.
    pub fn reads_input(&self, k: usize) -> bool {
        self.program.reads_input(k)
    }

    /// Sets all lanes of input `k` to one value.
    pub fn set_input_constant(&mut self, k: usize, value: R) {
        self.input_mut(k).fill(value);
    }

    /// The lanes of output `k` after a run.
    pub fn output(&self, k: usize) -> &[R; LANES] {
        &self.arena[self.program.output_slots[k] as usize].0
    }

    /// Runs one batch and returns the active lanes that did not discard; none if the run was stopped at a loop limit. If the program uses derivatives,
    /// `active` must contain all four lanes of every quad that has a covered lane; the uncovered lanes are helper lanes. `draw_values`: the result of
    /// [`Program::run_draw_tape`] for the same program.
    pub fn run(&mut self, draw_values: &DrawTapeValues<R>, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        self.counts = ExecutionCounts::default();
        self.hit_loop_limit = false;
        // A different number of registers: the values are those of another program.
        if active == 0 || draw_values.registers.len() != self.program.register_count {
            return 0;
        }
        // The mask of active lanes is in the slot after the inputs.
        let mask = &mut self.arena[self.program.inputs_read.len()].0;
        if active == LaneMask::MAX {
            mask.fill(R::from_mask(true));
        } else {
            for (k, lanes) in mask.chunks_exact_mut(LANE_BITS.len()).enumerate() {
                let part = (active >> (LANE_BITS.len() * k)) as u32;
                for (lane, bit) in lanes.iter_mut().zip(&LANE_BITS) {
                    *lane = R::from_mask(part & bit != 0);
                }
            }
        }
        // Not copied again for the same draw: the registers that a batch changes are written before they are read, also in the next batch.
        if self.draw_values_id != draw_values.id {
            self.draw_values_id = draw_values.id;
            for (row, values) in self.arena[self.program.first_register_row..].iter_mut().zip(draw_values.registers.chunks(LANES)) {
                row.0[..values.len()].copy_from_slice(values);
            }
        }
        // Another handle to the program, because `run_steps` changes `self` while it reads the program.
        let program = Arc::clone(&self.program);
        self.hit_loop_limit = !self.run_steps(&program, draw_values, textures);
        if self.hit_loop_limit {
            return 0;
        }
        active & !self.program.discarded.map_or(0, |s| self.lanes_set_in(s))
    }

    /// Whether the last run was stopped at [`MAX_BACKWARD_JUMPS`] or [`MAX_BATCH_INSTRUCTIONS`].
    pub(crate) fn hit_loop_limit(&self) -> bool {
        self.hit_loop_limit
    }

    /// Instructions and texture reads of the last run.
    pub fn counts(&self) -> ExecutionCounts {
        self.counts
    }

    /// The set lanes of the mask in a slot.
    fn lanes_set_in(&self, slot: u32) -> LaneMask {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = R::as_f32(&self.arena[slot as usize].0).and_then(|lanes| lanes.first_chunk::<LANES>())
            && is_x86_feature_detected!("avx2")
        {
            // SAFETY: AVX2 was detected.
            return unsafe { lane_masks::mask_avx2(lanes) };
        }
        let mut bits = 0u128;
        for (k, lanes) in self.arena[slot as usize].0.chunks_exact(LANE_BITS.len()).enumerate() {
            let mut part = 0u32;
            for (lane, bit) in lanes.iter().zip(&LANE_BITS) {
                part |= if lane.is_mask_set() { *bit } else { 0 };
            }
            bits |= u128::from(part) << (LANE_BITS.len() * k);
        }
        bits
    }

    /// Whether any lane of the mask in a slot is set.
    fn is_any_lane_set(&self, slot: u32) -> bool {
        let lanes = &self.arena[slot as usize].0;
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = R::as_f32(lanes).and_then(|lanes| lanes.first_chunk::<LANES>())
            && is_x86_feature_detected!("avx2")
        {
            // SAFETY: AVX2 was detected.
            return unsafe { lane_masks::is_any_set_avx2(lanes) };
        }
        // The OR of a chunk is vectorised. Usually a lane of the first chunk is set; then the other chunks are not read.
        let (chunks, _) = lanes.as_chunks::<{ kernels::CHUNK }>();
        chunks.iter().any(|chunk| chunk.iter().fold(R::ZERO, |a, &b| a.bit_or(b)).is_mask_set())
    }

    /// All registers, followed by the padding of the last row.
    fn registers(&self) -> &[R] {
        let rows = &self.arena[self.program.first_register_row..];
        // SAFETY: a row is an array of `LANES` values without padding (see the assertion below `LaneRow`).
        unsafe { std::slice::from_raw_parts(rows.as_ptr().cast(), rows.len() * LANES) }
    }

    fn registers_mut(&mut self) -> &mut [R] {
        let rows = &mut self.arena[self.program.first_register_row..];
        // SAFETY: as in `registers`.
        unsafe { std::slice::from_raw_parts_mut(rows.as_mut_ptr().cast(), rows.len() * LANES) }
    }

    fn register(&self, r: usize) -> R {
        self.registers()[r]
    }

    fn set_register(&mut self, r: usize, value: R) {
        self.registers_mut()[r] = value;
    }

    /// Runs operations on registers. Not inlined, for the reason given at `run_kernels`.
    #[inline(never)]
    fn run_scalars(&mut self, calls: &[ScalarCall<R>]) {
        let registers = self.registers_mut().as_mut_ptr();
        for call in calls {
            let [a, b, c] = call.args.map(|r| r as usize);
            // SAFETY: Program::check has verified every register against the count from which the arena was allocated; `unroll_loops` adds none.
            unsafe {
                registers.add(call.dst as usize).write((call.function)(
                    registers.add(a).read(),
                    registers.add(b).read(),
                    registers.add(c).read(),
                ))
            };
        }
    }

    /// Loads words of the uniform block into registers. Not inlined, for the reason given at `run_kernels`.
    #[inline(never)]
    fn load_uniforms(&mut self, loads: &[UniformLoad], words: &[u32]) {
        let registers = self.registers_mut();
        for load in loads {
            let index = load.index.map_or(0, |r| registers[r as usize].lane_bits());
            registers[load.dst as usize] = load.elements.read(words, index);
        }
    }

    /// Runs kernels in order. Not inlined: in the loop over all steps its pointers would not stay in processor registers.
    #[inline(never)]
    fn run_kernels(&mut self, kernels: &[KernelCall<R>], operand_offsets: &[u32]) {
        let base = self.arena.as_mut_ptr().cast::<R>();
        let operand_offsets = operand_offsets.as_ptr();
        let run = |kernel: &KernelCall<R>| {
            // SAFETY: Program::check has verified every index against the counts from which the arena was allocated, and `unroll_loops` adds no slots and
            // no registers. So each offset refers to a complete slot or to a register inside the arena. Nothing overlaps `dst`. If it is a slot of the
            // program, it is not an operand of the same kernel. If it is a scratch slot, the kernel is a broadcast, whose operand is a register, or part
            // of a chain, whose operations alternate between two scratch slots. `operand_offsets` has as many entries as the kernel takes (`Binder`). The
            // class of the kernel is available (`BoundProgram::new`).
            unsafe {
                #[allow(
                    clippy::transmute_ptr_to_ref,
                    reason = "`&mut *pointer` is checked at run time in debug builds, which takes as long as the kernel"
                )]
                let dst = std::mem::transmute::<*mut R, &mut [R; LANES]>(base.add(kernel.dst as usize));
                (kernel.function)(dst, base, operand_offsets.add(kernel.first_operand as usize));
            }
        };
        // Four kernels per iteration: with one per iteration, the loop itself takes a twentieth of a frame's instructions.
        let (quartets, rest) = kernels.as_chunks::<4>();
        for [a, b, c, d] in quartets {
            run(a);
            run(b);
            run(c);
            run(d);
        }
        rest.iter().for_each(run);
    }

    /// Runs all steps of the program; returns false if the batch was stopped at a loop limit.
    fn run_steps(&mut self, bound: &BoundProgram<R>, draw_values: &DrawTapeValues<R>, textures: &dyn TextureUnit<R>) -> bool {
        let mut next_step = 0usize;
        let mut backward_jumps = 0u32;
        while let Some(step) = bound.steps.get(next_step) {
            next_step += 1;
            let target = match step {
                // `instructions` may be less than the number of kernels, because a chain counts once.
                BoundStep::Kernels { start, end, instructions } => {
                    self.counts.instructions += instructions;
                    self.run_kernels(&bound.kernels[*start as usize..*end as usize], &bound.operand_offsets);
                    continue;
                }
                BoundStep::Scalars { start, end } => {
                    self.run_scalars(&bound.scalars[*start as usize..*end as usize]);
                    continue;
                }
                BoundStep::LoadUniforms { start, end } => {
                    self.load_uniforms(&bound.uniform_loads[*start as usize..*end as usize], &draw_values.uniform_words);
                    continue;
                }
                BoundStep::Gather { dst, index: index_slot, elements } => {
                    let indices = self.arena[*index_slot as usize].0;
                    elements.gather(&draw_values.uniform_words, &indices, &mut self.arena[*dst as usize].0);
                    continue;
                }
                BoundStep::Texture(k) => {
                    self.counts.texture_reads += 1;
                    self.read_texture(&bound.texture_reads[*k as usize], textures);
                    continue;
                }
                BoundStep::TextureSize { dst, texture, axis, level } => {
                    let level = self.register(*level).lane_bits();
                    self.set_register(*dst, R::from_lane_bits(texture_size(textures, *texture, *axis, level)));
                    continue;
                }
                BoundStep::SkipIfNoLane { slot, target } if !self.is_any_lane_set(*slot) => *target,
                BoundStep::JumpIf { register, when, target } if self.register(*register).is_mask_set() == *when => *target,
                BoundStep::Jump { target } => *target,
                BoundStep::SkipIfNoLane { .. } | BoundStep::JumpIf { .. } => continue,
            } as usize;
            if target < next_step {
                backward_jumps += 1;
                let cost = self.counts.texture_reads.saturating_mul(INSTRUCTIONS_PER_TEXTURE_READ).saturating_add(self.counts.instructions);
                if backward_jumps > MAX_BACKWARD_JUMPS || cost > MAX_BATCH_INSTRUCTIONS {
                    return false;
                }
            }
            next_step = target;
        }
        true
    }

    /// Reads a texture for the lanes set in the read's mask.
    fn read_texture(&mut self, read: &TextureRead, textures: &dyn TextureUnit<R>) {
        let active = match read.mask {
            MaskLocation::Slot(s) => self.lanes_set_in(s),
            MaskLocation::Register(r) if self.register(r).is_mask_set() => LaneMask::MAX,
            MaskLocation::Register(_) => 0,
        };
        let base = self.arena.as_mut_ptr().cast::<R>();
        // The lanes of a channel; empty if the program does not read it, which a texture unit skips.
        let output = |k: usize| -> &mut [R] {
            if !read.channels_read[k] {
                return &mut [];
            }
            // SAFETY: Program::check has verified that slots lie inside the arena, that the four slots of `dst` differ, and that none of them is an
            // operand; scratch slots come after the program's slots.
            unsafe { std::slice::from_raw_parts_mut(base.add(read.dst[k] as usize), LANES) }
        };
        let mut out = [output(0), output(1), output(2), output(3)];
        // Operand `k`, in the order that `TextureOp` states. SAFETY: as above; registers come after the slots, packed, and this instruction does not write its
        // operands.
        let arg = |k: usize| unsafe { std::slice::from_raw_parts(base.add(read.args[k].offset as usize), read.args[k].len as usize) };
        if active != LaneMask::MAX && read.op != TextureOp::Load {
            // Lanes that are not sampled are set to zero, so that the result does not depend on earlier batches of this thread. A load writes every lane.
            out.iter_mut().for_each(|o| o.fill(R::ZERO));
        }
        // Texture coordinates; x and y in texels for `Bilinear` and `Load`.
        let (u, v) = (arg(0), arg(1));
        let gradients = || Gradients { du_dx: arg(2), dv_dx: arg(3), du_dy: arg(4), dv_dy: arg(5) };
        match read.op {
            TextureOp::Gradients => textures.sample_gradients(read.texture, u, v, gradients(), active, out),
            TextureOp::Filtered => {
                let max_taps = arg(6);
                textures.sample_filtered(read.texture, [u, v], gradients(), max_taps, active, out);
            }
            TextureOp::Level => {
                let level = arg(2);
                textures.sample_level(read.texture, u, v, level, active, out);
            }
            TextureOp::Bilinear => textures.load_bilinear(read.texture, [u, v], active, out),
            TextureOp::Load => {
                let level = arg(2);
                textures.load(read.texture, u, v, level, active, out);
            }
        }
    }
}
