//! Runs a [`Program`] over batches of lanes.
//!
//! In: the uniform bytes of a draw (once, [`Program::prepare`]), then per batch the lane inputs and the lanes that are active. Out: the lane
//! outputs and which lanes live. Inactive lanes may hold anything; no operation traps on it. A program is bound to kernels once, in
//! [`Executor::new`]; a batch allocates nothing.

use super::kernels::{self, KernelClass, KernelFn};
use super::math::Real;
use super::program::{Constant, LaneInput, LaneOutput, Program};
use super::tape::{Instr, Operand, TextureOp, WordKind};

/// Lanes of a batch unless asked otherwise; 32 and 64 suit small primitives.
pub const LANES: usize = 128;

/// Backward jumps after which a batch is given up: a loop that never ends must not hang a frame.
const MOST_LOOP_TURNS: u32 = 1 << 20;

/// Which lanes of a batch: bit i is lane i.
pub type LaneMask = u128;

/// Reads textures for a batch. `texture` indexes [`Program::textures`]; slices hold one value per lane; lanes outside `active` may hold
/// anything, NaN included, and their results are not used.
pub trait TextureUnit<R: Real> {
    /// Filtered sample at (u, v) with the gradients of u and v per pixel step in x and y.
    #[allow(clippy::too_many_arguments)]
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], gradients: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]);
    /// Filtered sample at (u, v) from a mip level (fractional: trilinear).
    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]);
    /// One texel; integers bit-cast ([`Real::int`]); outside the level: zeros.
    fn load(&self, texture: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]);
    /// Width and height in texels of a level (clamped to those there are).
    fn dimensions(&self, texture: usize, level: u32) -> [u32; 2];
    /// Number of mip levels.
    fn levels(&self, texture: usize) -> u32;
}

/// The 32 single bits: loops that spread or collect bits by this table become vector code, those that shift by the lane do not.
const BITS: [u32; 32] = {
    let mut bits = [0; 32];
    let mut k = 0;
    while k < 32 {
        bits[k] = 1 << k;
        k += 1;
    }
    bits
};

/// Derivatives of texture coordinates by pixel, one per lane.
#[derive(Clone, Copy)]
pub struct Gradients<'a, R> {
    pub du_dx: &'a [R],
    pub dv_dx: &'a [R],
    pub du_dy: &'a [R],
    pub dv_dy: &'a [R],
}

/// A unit for programs that read no texture: zeros.
pub struct NoTextures;

impl<R: Real> TextureUnit<R> for NoTextures {
    fn sample_gradients(&self, _: usize, _: &[R], _: &[R], _: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn sample_level(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn load(&self, _: usize, _: &[R], _: &[R], _: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        out.into_iter().for_each(|o| o.fill(R::ZERO));
    }
    fn dimensions(&self, _: usize, _: u32) -> [u32; 2] {
        [1, 1]
    }
    fn levels(&self, _: usize) -> u32 {
        1
    }
}

/// The per-draw values of a program: registers after the uniform tape, and the uniform block for indexed reads.
#[derive(Clone, Debug)]
pub struct Prepared<R> {
    registers: Vec<R>,
    words: Vec<u32>,
}

fn constant<R: Real>(c: Constant) -> R {
    match c {
        Constant::Float(x) => R::from_f64(x),
        Constant::Int(i) => R::from_int(i),
        Constant::Bool(b) => R::from_mask(b),
    }
}

fn uniform_word<R: Real>(words: &[u32], kind: WordKind, offset: u32, index: u32, stride: u32, count: u32) -> R {
    let at = offset.saturating_add(index.min(count.max(1) - 1).saturating_mul(stride)) as usize / 4;
    let bits = words.get(at).copied().unwrap_or(0);
    match kind {
        WordKind::Float => R::from_f32_bits(bits),
        WordKind::Int => R::from_int(bits),
    }
}

fn scalar<R: Real>(instr: &Instr, fused: bool, registers: &mut [R], words: &[u32]) {
    let read = |o: &Operand, registers: &[R]| match *o {
        Operand::Reg(r) => registers[usize::from(r)],
        Operand::Slot(_) => R::ZERO,
    };
    match instr {
        Instr::Scalar { op, dst, args } => {
            let arg = |k: usize| args.get(k).map_or(R::ZERO, |o| read(o, registers));
            registers[usize::from(*dst)] = kernels::eval(*op, fused, arg(0), arg(1), arg(2));
        }
        Instr::LoadUniform { dst, kind, offset, index, stride, count } => {
            let i = index.as_ref().map_or(0, |o| read(o, registers).int());
            registers[usize::from(*dst)] = uniform_word(words, *kind, *offset, i, *stride, *count);
        }
        _ => {}
    }
}

impl Program {
    /// Runs the per-draw tape on the bytes of the uniform block (little-endian words; missing bytes read as zero), in the class of this process.
    pub fn prepare<R: Real>(&self, uniform_bytes: &[u8]) -> Prepared<R> {
        self.prepare_for(uniform_bytes, KernelClass::detect())
    }

    /// The same for a given class: it decides whether products and sums fuse.
    pub fn prepare_for<R: Real>(&self, uniform_bytes: &[u8], class: KernelClass) -> Prepared<R> {
        let words: Vec<u32> = uniform_bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let mut registers = vec![R::ZERO; self.registers as usize];
        for (r, c) in registers.iter_mut().zip(&self.constants) {
            *r = constant(*c);
        }
        for instr in &self.uniform_tape {
            scalar(instr, class.fused(), &mut registers, &words);
        }
        Prepared { registers, words }
    }
}

#[repr(C, align(64))]
#[derive(Clone)]
struct Lane<R, const N: usize>([R; N]);

/// A value's place as an element offset into the slots or the registers.
#[derive(Clone, Copy)]
enum Place {
    Slot(u32),
    Reg(u32),
}

enum Step<R> {
    Kernel { run: KernelFn<R>, dst: u32, args: [Place; 3] },
    Splat { slot: u32, register: u32 },
    Scalar(Instr),
    Gather { dst: u32, kind: WordKind, offset: u32, index: u32, stride: u32, count: u32 },
    Texture { what: TextureOp, texture: usize, dst: [u32; 4], args: [u32; 6], mask: Place },
    TextureSize { dst: usize, texture: usize, axis: u8, level: usize },
    SkipIfNone { slot: u32, target: u32 },
    JumpIf { register: usize, when: bool, target: u32 },
    Jump { target: u32 },
}

/// Runs one program in one class with `N` lanes a batch.
pub struct Executor<R: Real, const N: usize = LANES> {
    slots: Vec<Lane<R, N>>,
    registers: Vec<R>,
    steps: Vec<Step<R>>,
    inputs: Vec<LaneInput>,
    outputs: Vec<LaneOutput>,
    output_slots: Vec<u32>,
    discarded: Option<u32>,
    fused: bool,
}

/// Lanes that keep their arguments: the slots after the program's own hold broadcast operands of kernels that take lanes only.
const SCRATCH: u32 = 8;

impl<R: Real, const N: usize> Executor<R, N> {
    /// Binds the program to the kernels of this process's class.
    ///
    /// # Errors
    /// A program with an index out of range (see [`Program::check`]).
    pub fn new(program: &Program) -> Result<Self, String> {
        Self::with_class(program, KernelClass::detect())
    }

    /// The same for a class that the machine must have.
    ///
    /// # Errors
    /// A program with an index out of range, or a class that this machine lacks.
    pub fn with_class(program: &Program, class: KernelClass) -> Result<Self, String> {
        const { assert!(N.is_multiple_of(kernels::CHUNK) && N <= 128, "lanes: 32, 64, 96 or 128") };
        program.check()?;
        if !KernelClass::available().contains(&class) {
            return Err(format!("this machine has no {} kernels", class.name()));
        }
        let mut steps = Vec::with_capacity(program.lane_tape.len());
        let mut starts = Vec::with_capacity(program.lane_tape.len() + 1);
        for instr in &program.lane_tape {
            starts.push(steps.len() as u32);
            bind::<R, N>(instr, class, program.slots, &mut steps);
        }
        starts.push(steps.len() as u32);
        for step in &mut steps {
            if let Step::SkipIfNone { target, .. } | Step::JumpIf { target, .. } | Step::Jump { target } = step {
                *target = starts[*target as usize];
            }
        }
        let slot = |o: &Operand| match *o {
            Operand::Slot(s) => Ok(u32::from(s)),
            Operand::Reg(_) => Err("an output must be a lane value".to_owned()),
        };
        Ok(Self {
            slots: vec![Lane([R::ZERO; N]); (program.slots + SCRATCH) as usize],
            registers: vec![R::ZERO; program.registers as usize],
            steps,
            inputs: program.inputs.clone(),
            outputs: program.outputs.clone(),
            output_slots: program.output_operands.iter().map(slot).collect::<Result<_, _>>()?,
            discarded: program.discarded.as_ref().map(slot).transpose()?,
            fused: class.fused(),
        })
    }

    /// What each input means, in order.
    pub fn inputs(&self) -> &[LaneInput] {
        &self.inputs
    }

    /// What each output means, in order.
    pub fn outputs(&self) -> &[LaneOutput] {
        &self.outputs
    }

    /// The lanes of input `k`, to be written before every run (a run reuses their place).
    pub fn input_mut(&mut self, k: usize) -> &mut [R; N] {
        assert!(k < self.inputs.len(), "input {k} of {}", self.inputs.len());
        &mut self.slots[k].0
    }

    /// Gives input `k` one value for all lanes.
    pub fn set_input_constant(&mut self, k: usize, value: R) {
        self.input_mut(k).fill(value);
    }

    /// The lanes of output `k` after a run.
    pub fn output(&self, k: usize) -> &[R; N] {
        &self.slots[self.output_slots[k] as usize].0
    }

    /// Runs one batch and returns the active lanes that did not discard. When the program uses derivatives, `active` must hold the four
    /// lanes of every quad of which one is covered: the others are its helper lanes.
    pub fn run(&mut self, prepared: &Prepared<R>, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        let active = if N < 128 { active & ((1 << (N % 128)) - 1) } else { active };
        if active == 0 || prepared.registers.len() != self.registers.len() {
            return 0;
        }
        for (k, lanes) in self.slots[self.inputs.len()].0.chunks_exact_mut(32).enumerate() {
            let part = (active >> (32 * k)) as u32;
            for (lane, bit) in lanes.iter_mut().zip(&BITS) {
                *lane = R::from_mask(part & bit != 0);
            }
        }
        self.registers.copy_from_slice(&prepared.registers);
        if !self.walk(prepared, textures) {
            return 0;
        }
        active & !self.discarded.map_or(0, |s| self.mask(s))
    }

    fn mask(&self, slot: u32) -> LaneMask {
        let mut bits = 0u128;
        for (k, four) in self.slots[slot as usize].0.chunks_exact(32).enumerate() {
            let mut part = 0u32;
            for (lane, bit) in four.iter().zip(&BITS) {
                part |= if lane.mask() { *bit } else { 0 };
            }
            bits |= u128::from(part) << (32 * k);
        }
        bits
    }

    fn any(&self, slot: u32) -> bool {
        // Whole-array OR: the compiler makes it vector code, and the test leaves no chain of branches.
        self.slots[slot as usize].0.iter().fold(R::ZERO, |a, &b| a.bit_or(b)).mask()
    }

    fn walk(&mut self, prepared: &Prepared<R>, textures: &dyn TextureUnit<R>) -> bool {
        let steps = std::mem::take(&mut self.steps);
        let finished = self.walk_steps(&steps, prepared, textures);
        self.steps = steps;
        finished
    }

    fn walk_steps(&mut self, steps: &[Step<R>], prepared: &Prepared<R>, textures: &dyn TextureUnit<R>) -> bool {
        let mut at = 0usize;
        let mut turns = 0u32;
        while let Some(step) = steps.get(at) {
            at += 1;
            let target = match step {
                Step::Kernel { run, dst, args } => {
                    let base = self.slots.as_mut_ptr().cast::<R>();
                    let registers = self.registers.as_ptr();
                    // SAFETY: Program::check has verified every index against the counts that the buffers were made from, dst is no
                    // operand's slot, scratch slots are only operands here, and the class of the kernel is available (with_class).
                    unsafe {
                        let place = |p: Place| match p {
                            Place::Slot(s) => base.add(s as usize * N).cast_const(),
                            Place::Reg(r) => registers.add(r as usize),
                        };
                        run(base.add(*dst as usize * N), place(args[0]), place(args[1]), place(args[2]), N);
                    }
                    continue;
                }
                Step::Splat { slot, register } => {
                    self.slots[*slot as usize].0 = [self.registers[*register as usize]; N];
                    continue;
                }
                Step::Scalar(instr) => {
                    scalar(instr, self.fused, &mut self.registers, &prepared.words);
                    continue;
                }
                Step::Gather { dst, kind, offset, index, stride, count } => {
                    for i in 0..N {
                        let k = self.slots[*index as usize].0[i].int();
                        self.slots[*dst as usize].0[i] = uniform_word(&prepared.words, *kind, *offset, k, *stride, *count);
                    }
                    continue;
                }
                Step::Texture { what, texture, dst, args, mask } => {
                    self.texture(*what, *texture, *dst, *args, *mask, textures);
                    continue;
                }
                Step::TextureSize { dst, texture, axis, level } => {
                    let level = self.registers[*level].int();
                    let size = if *axis > 1 { textures.levels(*texture) } else { textures.dimensions(*texture, level)[usize::from(*axis)] };
                    self.registers[*dst] = R::from_int(size);
                    continue;
                }
                Step::SkipIfNone { slot, target } if !self.any(*slot) => *target,
                Step::JumpIf { register, when, target } if self.registers[*register].mask() == *when => *target,
                Step::Jump { target } => *target,
                Step::SkipIfNone { .. } | Step::JumpIf { .. } => continue,
            } as usize;
            if target < at {
                turns += 1;
                if turns > MOST_LOOP_TURNS {
                    return false;
                }
            }
            at = target;
        }
        true
    }

    fn texture(&mut self, what: TextureOp, texture: usize, dst: [u32; 4], args: [u32; 6], mask: Place, textures: &dyn TextureUnit<R>) {
        let active = match mask {
            Place::Slot(s) => self.mask(s),
            Place::Reg(r) if self.registers[r as usize].mask() => LaneMask::MAX,
            Place::Reg(_) => 0,
        };
        let mut out = [[R::ZERO; N]; 4];
        {
            let arg = |k: usize| &self.slots[args[k] as usize].0[..];
            let mut parts = out.each_mut().map(|o| &mut o[..]);
            let [r, g, b, a] = &mut parts;
            let out = [&mut **r, &mut **g, &mut **b, &mut **a];
            match what {
                TextureOp::Gradients => {
                    let gradients = Gradients { du_dx: arg(2), dv_dx: arg(3), du_dy: arg(4), dv_dy: arg(5) };
                    textures.sample_gradients(texture, arg(0), arg(1), gradients, active, out);
                }
                TextureOp::Level => textures.sample_level(texture, arg(0), arg(1), arg(2), active, out),
                TextureOp::Load => textures.load(texture, arg(0), arg(1), arg(2), active, out),
            }
        }
        for (d, o) in dst.into_iter().zip(out) {
            self.slots[d as usize].0 = o;
        }
    }
}

/// One instruction as bound steps; operands that a kernel cannot take as broadcast go through scratch slots after the program's own.
fn bind<R: Real, const N: usize>(instr: &Instr, class: KernelClass, scratch: u32, steps: &mut Vec<Step<R>>) {
    let mut used = 0;
    let mut lanes = |o: &Operand, steps: &mut Vec<Step<R>>| match *o {
        Operand::Slot(s) => u32::from(s),
        Operand::Reg(r) => {
            let slot = scratch + used;
            used += 1;
            steps.push(Step::Splat { slot, register: u32::from(r) });
            slot
        }
    };
    let register = |o: &Operand| match *o {
        Operand::Reg(r) => usize::from(r),
        Operand::Slot(_) => 0,
    };
    match instr {
        Instr::Lane { op, dst, args } => {
            let place = |k: usize| match args.get(k).or(args.first()) {
                Some(Operand::Slot(s)) => Place::Slot(u32::from(*s)),
                Some(Operand::Reg(r)) => Place::Reg(u32::from(*r)),
                None => Place::Slot(0),
            };
            let places = [place(0), place(1), place(2)];
            let kinds = places.map(|p| matches!(p, Place::Slot(_)));
            let dst = u32::from(*dst);
            match kernels::special::<R, N>(class, *op, kinds) {
                Some(run) => steps.push(Step::Kernel { run, dst, args: places }),
                None => {
                    let mut slots = [0u32; 3];
                    for k in 0..3 {
                        slots[k] = match args.get(k) {
                            Some(o) => lanes(o, steps),
                            None => slots[0],
                        };
                    }
                    steps.push(Step::Kernel { run: kernels::general::<R>(class, *op), dst, args: slots.map(Place::Slot) });
                }
            }
        }
        Instr::Scalar { .. } | Instr::LoadUniform { .. } => steps.push(Step::Scalar(instr.clone())),
        Instr::GatherUniform { dst, kind, offset, index, stride, count } => {
            let index = lanes(index, steps);
            steps.push(Step::Gather { dst: u32::from(*dst), kind: *kind, offset: *offset, index, stride: *stride, count: *count });
        }
        Instr::Texture { what, texture, dst, args, mask } => {
            let mut slots = [0u32; 6];
            for (s, o) in slots.iter_mut().zip(args) {
                *s = lanes(o, steps);
            }
            let mask = match *mask {
                Operand::Slot(s) => Place::Slot(u32::from(s)),
                Operand::Reg(r) => Place::Reg(u32::from(r)),
            };
            steps.push(Step::Texture { what: *what, texture: usize::from(*texture), dst: dst.map(u32::from), args: slots, mask });
        }
        Instr::TextureSize { dst, texture, axis, level } => {
            steps.push(Step::TextureSize { dst: usize::from(*dst), texture: usize::from(*texture), axis: *axis, level: register(level) })
        }
        Instr::SkipIfNone { mask, target } => {
            let slot = lanes(mask, steps);
            steps.push(Step::SkipIfNone { slot, target: *target });
        }
        Instr::JumpIf { cond, when, target } => steps.push(Step::JumpIf { register: register(cond), when: *when, target: *target }),
        Instr::Jump { target } => steps.push(Step::Jump { target: *target }),
    }
}
