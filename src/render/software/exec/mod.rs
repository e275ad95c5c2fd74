//! Runs a [`Program`] over batches of lanes.
//!
//! In: the uniform bytes of a draw (once, [`Program::prepare`]), then per batch the lane inputs and the lanes that are active. Out: the lane
//! outputs and which lanes live. Inactive lanes may hold anything; no operation traps on it. A program is bound to kernels once, in
//! [`Executor::new`]; a batch allocates nothing.

pub use super::kernels::LANES;
use super::kernels::{self, KernelClass, KernelFn, ScalarFn};
use super::math::Real;
use super::program::{Constant, LaneInput, LaneOutput, Program};
use super::tape::{Instr, Link, Op, Operand, TextureOp, WordKind};
use smallvec::SmallVec;

/// Backward jumps after which a batch is given up: a loop that never ends must not hang a frame.
const MOST_LOOP_TURNS: u32 = 1 << 20;

/// Which lanes of a batch: bit i is lane i.
pub type LaneMask = u128;
const _: () = assert!(LANES == LaneMask::BITS as usize && LANES.is_multiple_of(kernels::CHUNK));

/// Reads textures for a batch. `texture` indexes [`Program::textures`]; slices hold one value per lane; lanes outside `active` may hold
/// anything, NaN included, and their results are not used.
pub trait TextureUnit<R: Real> {
    /// Filtered sample at (u, v) with the gradients of u and v per pixel step in x and y.
    #[allow(clippy::too_many_arguments)]
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], gradients: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]);
    /// The same with up to `most` taps along the footprint, as shaders/lib/filtered.wesl sums them; a unit that does not know better takes one.
    /// `place`: u and v.
    #[allow(clippy::too_many_arguments)]
    fn sample_filtered(&self, texture: usize, place: [&[R]; 2], g: Gradients<'_, R>, most: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let _ = most;
        self.sample_gradients(texture, place[0], place[1], g, active, out);
    }
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

/// The register that a once-only instruction writes and what; `read` gives a register's value.
fn scalar<R: Real>(instr: &Instr, fused: bool, words: &[u32], read: impl Fn(usize) -> R) -> Option<(usize, R)> {
    let read = |o: &Operand| match *o {
        Operand::Reg(r) => read(usize::from(r)),
        Operand::Slot(_) => R::ZERO,
    };
    match instr {
        Instr::Scalar { op, dst, args } => {
            let arg = |k: usize| args.get(k).map_or(R::ZERO, read);
            Some((usize::from(*dst), kernels::eval(*op, fused, arg(0), arg(1), arg(2))))
        }
        Instr::LoadUniform { dst, kind, offset, index, stride, count } => {
            let i = index.as_ref().map_or(0, |o| read(o).int());
            Some((usize::from(*dst), uniform_word(words, *kind, *offset, i, *stride, *count)))
        }
        _ => None,
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
            if let Some((r, value)) = scalar(instr, class.fused(), &words, |r| registers[r]) {
                registers[r] = value;
            }
        }
        Prepared { registers, words }
    }
}

#[repr(C, align(64))]
#[derive(Clone)]
struct Lane<R>([R; LANES]);

/// A kernel ready to be called. Places are element offsets from the start of the arena.
struct KernelStep<R> {
    run: KernelFn<R>,
    /// The place that it writes.
    dst: u32,
    /// Where the places of its operands begin in [`Bound::places`].
    operands: u32,
}

/// Four steps in a cache line.
const _: () = assert!(size_of::<KernelStep<f32>>() <= 16);

/// The mask that a texture is read under.
#[derive(Clone, Copy)]
enum Mask {
    Slot(u32),
    Register(usize),
}

enum Step<R> {
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
struct Bound<R> {
    steps: Vec<Step<R>>,
    kernels: Vec<KernelStep<R>>,
    /// The operands of every kernel, in their order.
    places: Vec<u32>,
}

/// Runs one program in one class.
pub struct Executor<R: Real> {
    /// The program's slots, then [`SCRATCH`] slots, then the registers, packed: one allocation, so that a kernel's operands are offsets.
    arena: Vec<Lane<R>>,
    /// Row of the arena where the registers start.
    first_register: usize,
    register_count: usize,
    bound: Bound<R>,
    inputs: Vec<LaneInput>,
    outputs: Vec<LaneOutput>,
    output_slots: Vec<u32>,
    discarded: Option<u32>,
    fused: bool,
    work: Work,
}

/// What the last run executed, each instruction over all lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    pub instructions: u32,
    pub texture_reads: u32,
}

/// Slots after the program's own: the first hold broadcast operands of kernels that take lanes only, the last two results inside a chain.
const SCRATCH: u32 = 8;

impl<R: Real> Executor<R> {
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
        program.check()?;
        if !KernelClass::available().contains(&class) {
            return Err(format!("this machine has no {} kernels", class.name()));
        }
        let first_register = (program.slots + SCRATCH) as usize;
        let mut binder = Binder {
            bound: Bound { steps: Vec::new(), kernels: Vec::with_capacity(program.lane_tape.len()), places: Vec::new() },
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
        for (instr, entered) in program.lane_tape.iter().zip(&targets) {
            // Who jumps here must not run what stands before.
            binder.open &= !entered;
            let step = binder.bound.steps.len() as u32;
            starts.push(if binder.open { step - 1 } else { step });
            binder.bind(instr)?;
        }
        let mut bound = binder.bound;
        starts.push(bound.steps.len() as u32);
        for step in &mut bound.steps {
            if let Step::SkipIfNone { target, .. } | Step::JumpIf { target, .. } | Step::Jump { target } = step {
                *target = starts[*target as usize];
            }
        }
        let slot = |o: &Operand| match *o {
            Operand::Slot(s) => Ok(u32::from(s)),
            Operand::Reg(_) => Err("an output must be a lane value".to_owned()),
        };
        Ok(Self {
            arena: vec![Lane([R::ZERO; LANES]); first_register + (program.registers as usize).div_ceil(LANES)],
            first_register,
            register_count: program.registers as usize,
            bound,
            work: Work::default(),
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
    pub fn input_mut(&mut self, k: usize) -> &mut [R; LANES] {
        assert!(k < self.inputs.len(), "input {k} of {}", self.inputs.len());
        &mut self.arena[k].0
    }

    /// Gives input `k` one value for all lanes.
    pub fn set_input_constant(&mut self, k: usize, value: R) {
        self.input_mut(k).fill(value);
    }

    /// The lanes of output `k` after a run.
    pub fn output(&self, k: usize) -> &[R; LANES] {
        &self.arena[self.output_slots[k] as usize].0
    }

    /// Runs one batch and returns the active lanes that did not discard. When the program uses derivatives, `active` must hold the four
    /// lanes of every quad of which one is covered: the others are its helper lanes.
    pub fn run(&mut self, prepared: &Prepared<R>, active: LaneMask, textures: &dyn TextureUnit<R>) -> LaneMask {
        self.work = Work::default();
        if active == 0 || prepared.registers.len() != self.register_count {
            return 0;
        }
        for (k, lanes) in self.arena[self.inputs.len()].0.chunks_exact_mut(32).enumerate() {
            let part = (active >> (32 * k)) as u32;
            for (lane, bit) in lanes.iter_mut().zip(&BITS) {
                *lane = R::from_mask(part & bit != 0);
            }
        }
        for (row, values) in self.arena[self.first_register..].iter_mut().zip(prepared.registers.chunks(LANES)) {
            row.0[..values.len()].copy_from_slice(values);
        }
        if !self.walk(prepared, textures) {
            return 0;
        }
        active & !self.discarded.map_or(0, |s| self.mask(s))
    }

    /// What the last run executed.
    pub fn work(&self) -> Work {
        self.work
    }

    fn mask(&self, slot: u32) -> LaneMask {
        let mut bits = 0u128;
        for (k, four) in self.arena[slot as usize].0.chunks_exact(32).enumerate() {
            let mut part = 0u32;
            for (lane, bit) in four.iter().zip(&BITS) {
                part |= if lane.mask() { *bit } else { 0 };
            }
            bits |= u128::from(part) << (32 * k);
        }
        bits
    }

    fn any(&self, slot: u32) -> bool {
        // An OR of a piece becomes vector code; mostly some lane of the first piece is set, and the rest need not be read.
        let (pieces, _) = self.arena[slot as usize].0.as_chunks::<{ kernels::CHUNK }>();
        pieces.iter().any(|piece| piece.iter().fold(R::ZERO, |a, &b| a.bit_or(b)).mask())
    }

    fn register(&self, r: usize) -> R {
        self.arena[self.first_register + r / LANES].0[r % LANES]
    }

    fn set_register(&mut self, r: usize, value: R) {
        self.arena[self.first_register + r / LANES].0[r % LANES] = value;
    }

    fn walk(&mut self, prepared: &Prepared<R>, textures: &dyn TextureUnit<R>) -> bool {
        let bound = std::mem::replace(&mut self.bound, Bound { steps: Vec::new(), kernels: Vec::new(), places: Vec::new() });
        let finished = self.walk_steps(&bound, prepared, textures);
        self.bound = bound;
        finished
    }

    fn run_kernels(&mut self, kernels: &[KernelStep<R>], places: &[u32]) {
        let base = self.arena.as_mut_ptr().cast::<R>();
        for k in kernels {
            // SAFETY: Program::check has verified every index against the counts that the arena was made from, so each place is that of a
            // whole slot or of a register inside it; `dst` is a slot and no operand's slot, and scratch slots are written by broadcasts
            // only, whose operand is a register, so nothing overlaps `dst`; `places` holds what the kernel takes (bind);
            // the class of the kernel is available (with_class).
            unsafe {
                let dst = &mut *base.add(k.dst as usize).cast::<[R; LANES]>();
                (k.run)(dst, base, places.as_ptr().add(k.operands as usize));
            }
        }
    }

    fn walk_steps(&mut self, bound: &Bound<R>, prepared: &Prepared<R>, textures: &dyn TextureUnit<R>) -> bool {
        let mut at = 0usize;
        let mut turns = 0u32;
        while let Some(step) = bound.steps.get(at) {
            at += 1;
            let target = match step {
                Step::Kernels { from, to, instructions } => {
                    self.work.instructions += instructions;
                    self.run_kernels(&bound.kernels[*from as usize..*to as usize], &bound.places);
                    continue;
                }
                Step::Scalar { run, dst, args } => {
                    let [a, b, c] = args.map(|r| self.register(r));
                    self.set_register(*dst, run(a, b, c));
                    continue;
                }
                Step::Load(instr) => {
                    if let Some((r, value)) = scalar(instr, self.fused, &prepared.words, |r| self.register(r)) {
                        self.set_register(r, value);
                    }
                    continue;
                }
                Step::Gather { dst, kind, offset, index, stride, count } => {
                    for i in 0..LANES {
                        let k = self.arena[*index as usize].0[i].int();
                        self.arena[*dst as usize].0[i] = uniform_word(&prepared.words, *kind, *offset, k, *stride, *count);
                    }
                    continue;
                }
                Step::Texture { what, texture, dst, args, mask } => {
                    self.work.texture_reads += 1;
                    self.texture(*what, *texture, *dst, *args, *mask, textures);
                    continue;
                }
                Step::TextureSize { dst, texture, axis, level } => {
                    let level = self.register(*level).int();
                    let size = if *axis > 1 { textures.levels(*texture) } else { textures.dimensions(*texture, level)[usize::from(*axis)] };
                    self.set_register(*dst, R::from_int(size));
                    continue;
                }
                Step::SkipIfNone { slot, target } if !self.any(*slot) => *target,
                Step::JumpIf { register, when, target } if self.register(*register).mask() == *when => *target,
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

    fn texture(&mut self, what: TextureOp, texture: usize, dst: [u32; 4], args: [u32; 7], mask: Mask, textures: &dyn TextureUnit<R>) {
        let active = match mask {
            Mask::Slot(s) => self.mask(s),
            Mask::Register(r) if self.register(r).mask() => LaneMask::MAX,
            Mask::Register(_) => 0,
        };
        let mut out = [[R::ZERO; LANES]; 4];
        {
            let arg = |k: usize| &self.arena[args[k] as usize].0[..];
            let mut parts = out.each_mut().map(|o| &mut o[..]);
            let [r, g, b, a] = &mut parts;
            let out = [&mut **r, &mut **g, &mut **b, &mut **a];
            match what {
                TextureOp::Gradients => {
                    let gradients = Gradients { du_dx: arg(2), dv_dx: arg(3), du_dy: arg(4), dv_dy: arg(5) };
                    textures.sample_gradients(texture, arg(0), arg(1), gradients, active, out);
                }
                TextureOp::Filtered => {
                    let gradients = Gradients { du_dx: arg(2), dv_dx: arg(3), du_dy: arg(4), dv_dy: arg(5) };
                    textures.sample_filtered(texture, [arg(0), arg(1)], gradients, arg(6), active, out);
                }
                TextureOp::Level => textures.sample_level(texture, arg(0), arg(1), arg(2), active, out),
                TextureOp::Load => textures.load(texture, arg(0), arg(1), arg(2), active, out),
            }
        }
        for (d, o) in dst.into_iter().zip(out) {
            self.arena[d as usize].0 = o;
        }
    }
}

fn is_lanes(o: &Operand) -> bool {
    matches!(o, Operand::Slot(_))
}

/// Turns instructions into steps.
struct Binder<R> {
    bound: Bound<R>,
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
            Some(Step::Kernels { to: end, instructions, .. }) if self.open => {
                *end = to;
                *instructions += 1;
            }
            _ => self.bound.steps.push(Step::Kernels { from: to - 1, to, instructions: 1 }),
        }
        self.open = true;
    }

    fn step(&mut self, step: Step<R>) {
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
    fn chain(&mut self, links: &[Link], dst: u32, args: &[Operand]) -> Result<(), String> {
        let kinds = args.iter().take(kernels::chains::MOST_OPERANDS).enumerate().map(|(k, o)| u8::from(is_lanes(o)) << k).sum();
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
        if let Some(Step::Kernels { instructions, .. }) = self.bound.steps.last_mut() {
            *instructions -= (self.bound.kernels.len() - kernels_before - 1) as u32;
        }
        Ok(())
    }

    fn bind(&mut self, instr: &Instr) -> Result<(), String> {
        let mut used = 0;
        let register = |o: &Operand| match *o {
            Operand::Reg(r) => usize::from(r),
            Operand::Slot(_) => 0,
        };
        match instr {
            Instr::Lane { op, dst, args } => self.operation(*op, Self::slot_place(u32::from(*dst)), args)?,
            Instr::Chain { links, dst, args } => self.chain(links, Self::slot_place(u32::from(*dst)), args)?,
            Instr::Scalar { op, dst, args } => {
                let args = [0, 1, 2].map(|k| args.get(k).or(args.first()).map_or(0, register));
                self.step(Step::Scalar { run: R::scalar(*op, self.class.fused()), dst: usize::from(*dst), args });
            }
            Instr::LoadUniform { .. } => self.step(Step::Load(instr.clone())),
            Instr::GatherUniform { dst, kind, offset, index, stride, count } => {
                let index = self.lanes(index, &mut used)?;
                self.step(Step::Gather { dst: u32::from(*dst), kind: *kind, offset: *offset, index, stride: *stride, count: *count });
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
                self.step(Step::Texture { what: *what, texture: usize::from(*texture), dst: dst.map(u32::from), args: slots, mask });
            }
            Instr::TextureSize { dst, texture, axis, level } => {
                self.step(Step::TextureSize {
                    dst: usize::from(*dst),
                    texture: usize::from(*texture),
                    axis: *axis,
                    level: register(level),
                });
            }
            Instr::SkipIfNone { mask, target } => {
                let slot = self.lanes(mask, &mut used)?;
                self.step(Step::SkipIfNone { slot, target: *target });
            }
            Instr::JumpIf { cond, when, target } => {
                self.step(Step::JumpIf { register: register(cond), when: *when, target: *target });
            }
            Instr::Jump { target } => self.step(Step::Jump { target: *target }),
        }
        Ok(())
    }
}
