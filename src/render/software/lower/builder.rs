//! Builds the SSA instructions. Folds constants, simplifies, finds equal computations (value numbering), and determines the rate of each value.
//!
//! In: operations and their operands. Out: their results, and the instructions that compute them. Always: a result is reused only where it has been computed.
//! Not here: control flow (`control_flow.rs`), and the optimisations of all instructions (`finish.rs`).
//!
//! A value's rate states how often it is computed: constant; per draw (once, on the draw tape); shared (one value for all lanes, on the lane tape
//! because it may change in a loop); per lane. The result of an operation has the highest rate among its operands.

use super::ssa::{JumpLabel, SsaInstr, SsaValue, SsaValues};
use crate::render::software::kernels;
use crate::render::software::program::Constant;
use crate::render::software::tape::{Op, TextureOp, WordKind};
use rustc_hash::FxHashMap as HashMap;

/// What a value is computed from; equal computations share one value.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Computation {
    Op(Op, SsaValues),
    UniformLoad { offset: u32, count: u32, is_integer: bool, index: Option<SsaValue> },
    TextureSize { texture: u16, axis: u8, level: SsaValue },
}

/// The instructions, constants and values of one entry point so far.
#[derive(Default)]
pub(crate) struct SsaBuilder {
    pub constants: Vec<Constant>,
    /// Index of each constant, by its type and its bits.
    constant_index: HashMap<(u8, u64), u32>,
    /// Instructions of the draw tape.
    pub draw_instrs: Vec<SsaInstr>,
    /// Instructions of the lane tape.
    pub lane_instrs: Vec<SsaInstr>,
    /// The numbers of the newest value and of the newest label.
    last_value: u32,
    last_label: JumpLabel,
    /// Values computed on the draw tape. They are available everywhere.
    draw_available: HashMap<Computation, SsaValue>,
    /// The operands of each `select` between lanes, by its result.
    selects: HashMap<SsaValue, [SsaValue; 3]>,
    /// The operand of each `BNot`, by its result.
    operand_of_not: HashMap<SsaValue, SsaValue>,
    /// Values computed on the lane tape: those outside all reuse scopes, then those of each open scope, innermost last. A reuse scope is a part of the tape
    /// that may be skipped, so its values must not be used after it.
    lane_available: Vec<HashMap<Computation, SsaValue>>,
}

impl SsaBuilder {
    pub(crate) fn new() -> Self {
        Self { lane_available: vec![HashMap::default()], ..Self::default() }
    }

    pub(crate) fn constant(&mut self, c: Constant) -> SsaValue {
        let key = match c {
            Constant::Float(x) => (0, x.to_bits()),
            Constant::Int(i) => (1, u64::from(i)),
            Constant::Bool(b) => (2, u64::from(b)),
        };
        let index = *self.constant_index.entry(key).or_insert_with(|| {
            self.constants.push(c);
            self.constants.len() as u32 - 1
        });
        SsaValue::Const(index)
    }

    pub(crate) fn float(&mut self, x: f64) -> SsaValue {
        self.constant(Constant::Float(x))
    }
    pub(crate) fn int(&mut self, i: u32) -> SsaValue {
        self.constant(Constant::Int(i))
    }
    pub(crate) fn bool(&mut self, b: bool) -> SsaValue {
        self.constant(Constant::Bool(b))
    }

    /// The constant, if the value is one; `None` if it is computed when the program runs. `known_bool` and `known_int`: only constants of that type.
    pub(crate) fn known_constant(&self, v: SsaValue) -> Option<Constant> {
        match v {
            SsaValue::Const(i) => Some(self.constants[i as usize]),
            _ => None,
        }
    }
    pub(crate) fn known_bool(&self, v: SsaValue) -> Option<bool> {
        match self.known_constant(v) {
            Some(Constant::Bool(b)) => Some(b),
            _ => None,
        }
    }
    pub(crate) fn known_int(&self, v: SsaValue) -> Option<u32> {
        match self.known_constant(v) {
            Some(Constant::Int(i)) => Some(i),
            _ => None,
        }
    }

    /// A new value with the rate *per lane*.
    pub(crate) fn fresh_lane(&mut self) -> SsaValue {
        self.last_value += 1;
        SsaValue::Lane(self.last_value)
    }
    /// A new value with the rate *shared*.
    pub(crate) fn fresh_shared(&mut self) -> SsaValue {
        self.last_value += 1;
        SsaValue::Shared(self.last_value)
    }
    pub(crate) fn fresh_label(&mut self) -> JumpLabel {
        self.last_label += 1;
        self.last_label
    }

    /// Starts a reuse scope, a part of the tape that may be skipped: values computed in it are not reused after it.
    pub(crate) fn open_reuse_scope(&mut self) {
        self.lane_available.push(HashMap::default());
    }
    pub(crate) fn close_reuse_scope(&mut self) {
        self.lane_available.pop();
    }
    /// Ends a reuse scope whose instructions are never skipped after all: its values may be reused after it.
    pub(crate) fn merge_reuse_scope(&mut self) {
        if let Some(scope) = self.lane_available.pop()
            && let Some(outer) = self.lane_available.last_mut()
        {
            outer.extend(scope);
        }
    }

    /// The earlier value of an equal computation, if it is available here.
    fn find_computed(&self, key: &Computation) -> Option<SsaValue> {
        self.draw_available.get(key).or_else(|| self.lane_available.iter().rev().find_map(|scope| scope.get(key))).copied()
    }

    /// A new value, with the highest rate among the operands from which it is computed.
    fn fresh_result(&mut self, args: &[SsaValue]) -> SsaValue {
        self.last_value += 1;
        if args.iter().any(|a| matches!(a, SsaValue::Lane(_))) {
            SsaValue::Lane(self.last_value)
        } else if args.iter().any(|a| matches!(a, SsaValue::Shared(_))) {
            SsaValue::Shared(self.last_value)
        } else {
            SsaValue::Draw(self.last_value)
        }
    }

    /// Appends an instruction to the tape on which `dst` is computed. With a `key`, an equal computation reuses `dst` from now on.
    fn emit(&mut self, dst: SsaValue, key: Option<Computation>, instr: SsaInstr) -> SsaValue {
        if matches!(dst, SsaValue::Draw(_)) {
            self.draw_instrs.push(instr);
            if let Some(k) = key {
                self.draw_available.insert(k, dst);
            }
        } else {
            self.lane_instrs.push(instr);
            if let (Some(k), Some(available)) = (key, self.lane_available.last_mut()) {
                available.insert(k, dst);
            }
        }
        dst
    }

    /// The result of an operation: folded, simplified, found among earlier results, or computed by a new instruction.
    pub(crate) fn op(&mut self, op: Op, args: &[SsaValue]) -> SsaValue {
        if let Some(folded) = self.fold(op, args) {
            return folded;
        }
        if let Some(simple) = self.simplify(op, args) {
            return simple;
        }
        let mut args = SsaValues::from_slice(args);
        // The operands of a commutative operation are sorted, so that equal computations have equal keys.
        if matches!(op, Op::Add | Op::Mul | Op::FEq | Op::FNe | Op::IAdd | Op::IMul | Op::IEq | Op::INe | Op::And | Op::Or | Op::Xor) {
            args.sort();
        }
        let key = Computation::Op(op, args.clone());
        if let Some(v) = self.find_computed(&key) {
            return v;
        }
        let dst = self.fresh_result(&args);
        match (op, &args[..]) {
            (Op::Select, &[cond, yes, no]) if matches!(dst, SsaValue::Lane(_)) => {
                self.selects.insert(dst, [cond, yes, no]);
            }
            (Op::BNot, &[a]) => {
                self.operand_of_not.insert(dst, a);
            }
            _ => {}
        }
        self.emit(dst, Some(key), SsaInstr::Op { dst, op, args })
    }

    pub(crate) fn unary(&mut self, op: Op, a: SsaValue) -> SsaValue {
        self.op(op, &[a])
    }
    pub(crate) fn binary(&mut self, op: Op, a: SsaValue, b: SsaValue) -> SsaValue {
        self.op(op, &[a, b])
    }
    pub(crate) fn select(&mut self, cond: SsaValue, yes: SsaValue, no: SsaValue) -> SsaValue {
        self.op(Op::Select, &[cond, yes, no])
    }
    pub(crate) fn not(&mut self, a: SsaValue) -> SsaValue {
        self.op(Op::BNot, &[a])
    }

    /// The result as a constant, if all operands are constants.
    fn fold(&mut self, op: Op, args: &[SsaValue]) -> Option<SsaValue> {
        if matches!(op, Op::Copy) {
            return None;
        }
        // The operands as lanes of f64 store them: integers and booleans as bits.
        let mut stored = [0.0f64; 3];
        for (operand, a) in stored.iter_mut().zip(args) {
            *operand = match self.known_constant(*a)? {
                Constant::Float(x) => x,
                Constant::Int(i) => f64::from_bits(u64::from(i)),
                Constant::Bool(b) => f64::from_bits(if b { u64::MAX } else { 0 }),
            };
        }
        if op == Op::Select {
            return Some(if self.known_bool(args[0])? { args[1] } else { args[2] });
        }
        let has_fma = false;
        let y = kernels::eval::<f64>(op, has_fma, stored[0], stored[1], stored[2]);
        let kind = match result_kind(op) {
            ResultKind::Same => match self.known_constant(args[0])? {
                Constant::Float(_) => ResultKind::Float,
                Constant::Int(_) => ResultKind::Int,
                Constant::Bool(_) => ResultKind::Bool,
            },
            k => k,
        };
        Some(match kind {
            ResultKind::Int => self.int(y.to_bits() as u32),
            ResultKind::Bool => self.bool(y.to_bits() != 0),
            _ => self.float(y),
        })
    }

    /// A value that equals the result and needs fewer or cheaper operations, if one is known.
    fn simplify(&mut self, op: Op, args: &[SsaValue]) -> Option<SsaValue> {
        let is_constant = |this: &Self, v: SsaValue, c: Constant| this.known_constant(v) == Some(c);
        let (one, zero) = (Constant::Float(1.0), Constant::Float(0.0));
        match (op, args) {
            (Op::Mul, &[a, b]) if is_constant(self, b, one) => Some(a),
            (Op::Mul, &[a, b]) if is_constant(self, a, one) => Some(b),
            (Op::Div, &[a, b]) if is_constant(self, b, one) => Some(a),
            (Op::Div, &[a, b]) => {
                // A power of two within the range of f32 has an exact reciprocal, and the product rounds like the quotient.
                let Some(Constant::Float(x)) = self.known_constant(b) else { return None };
                let is_power_of_two = x.to_bits() << 12 == 0 && (2f64.powi(-120)..=2f64.powi(120)).contains(&x.abs());
                is_power_of_two.then(|| {
                    let reciprocal = self.float(1.0 / x);
                    self.binary(Op::Mul, a, reciprocal)
                })
            }
            (Op::Add, &[a, b]) if is_constant(self, b, zero) => Some(a),
            (Op::Add, &[a, b]) if is_constant(self, a, zero) => Some(b),
            (Op::Sub, &[a, b]) if is_constant(self, b, zero) => Some(a),
            (Op::IAdd, &[a, b]) if is_constant(self, b, Constant::Int(0)) => Some(a),
            (Op::IAdd, &[a, b]) if is_constant(self, a, Constant::Int(0)) => Some(b),
            (Op::IMul, &[a, b]) if is_constant(self, b, Constant::Int(1)) => Some(a),
            (Op::IMul, &[a, b]) if is_constant(self, a, Constant::Int(1)) => Some(b),
            (Op::And | Op::Or, &[a, b]) if a == b => Some(a),
            (Op::And | Op::Or, &[a, b]) => {
                let (known, other) = if let Some(k) = self.known_bool(a) { (k, b) } else { (self.known_bool(b)?, a) };
                Some(match (op, known) {
                    (Op::And, true) | (Op::Or, false) => other,
                    (Op::And, _) => self.bool(false),
                    _ => self.bool(true),
                })
            }
            (Op::Select, &[c, a, b]) => {
                if let Some(k) = self.known_bool(c) {
                    return Some(if k { a } else { b });
                }
                if a == b {
                    return Some(a);
                }
                if let Some(&opposite) = self.operand_of_not.get(&c) {
                    return Some(self.select(opposite, b, a));
                }
                // An inner select with the same condition takes the same side as the outer one. Such selects arise where one side of a branch returns early.
                // Operands of a select: 0 the condition, 1 the result where it holds, 2 the result elsewhere.
                let inner_operand = |v, k: usize| self.selects.get(&v).filter(|inner| inner[0] == c).map(|inner| inner[k]);
                let (yes, no) = (inner_operand(a, 1).unwrap_or(a), inner_operand(b, 2).unwrap_or(b));
                if (yes, no) != (a, b) {
                    return Some(self.select(c, yes, no));
                }
                // select(c, select(inner, new, old), old) is select(c & inner, new, old), whatever bits `inner` has where `c` does not hold. Dead-code
                // elimination removes the inner select if nothing else reads its result.
                if let Some(&[inner, new, old]) = self.selects.get(&a)
                    && old == b
                {
                    let both = self.binary(Op::And, c, inner);
                    return Some(self.select(both, new, b));
                }
                // Masks are all ones or all zeros, so a select between a constant mask and any other is a logical operation.
                match (self.known_bool(a), self.known_bool(b)) {
                    (Some(true), Some(false)) => Some(c),
                    (Some(false), Some(true)) => Some(self.not(c)),
                    (Some(true), None) => Some(self.binary(Op::Or, c, b)),
                    (None, Some(false)) => Some(self.binary(Op::And, c, a)),
                    (Some(false), None) => {
                        let n = self.not(c);
                        Some(self.binary(Op::And, n, b))
                    }
                    (None, Some(true)) => {
                        let n = self.not(c);
                        Some(self.binary(Op::Or, n, a))
                    }
                    _ => None,
                }
            }
            (Op::BNot, &[a]) => self.operand_of_not.get(&a).copied(),
            _ => None,
        }
    }

    /// Loads the word at byte `offset` of the uniform block. With `index` = (i, n), loads the word i words further on, where i is clamped to n - 1.
    pub(crate) fn load_uniform(&mut self, kind: WordKind, offset: u32, index: Option<(SsaValue, u32)>) -> SsaValue {
        let (index, count) = match index {
            Some((i, n)) => match self.known_int(i) {
                Some(k) => return self.load_uniform(kind, offset + 4 * k.min(n.max(1) - 1), None),
                None => (Some(i), n),
            },
            None => (None, 1),
        };
        let key = Computation::UniformLoad { offset, count, is_integer: kind == WordKind::Int, index };
        if let Some(v) = self.find_computed(&key) {
            return v;
        }
        let dst = self.fresh_result(index.as_slice());
        self.emit(dst, Some(key), SsaInstr::LoadUniform { dst, kind, offset, index, stride: 4, count })
    }

    /// Reads a texture in the lanes set in `mask`; returns red, green, blue and alpha.
    pub(crate) fn texture(&mut self, op: TextureOp, texture: u16, args: &[SsaValue], mask: SsaValue) -> [SsaValue; 4] {
        let dst = [(); 4].map(|()| self.fresh_lane());
        self.lane_instrs.push(SsaInstr::Texture { op, texture, dst, args: SsaValues::from_slice(args), mask });
        dst
    }

    /// The size of a texture's level, or the number of levels; `axis` as in [`Instr::TextureSize`](crate::render::software::tape::Instr::TextureSize). `None`
    /// if the level differs between lanes.
    pub(crate) fn texture_size(&mut self, texture: u16, axis: u8, level: SsaValue) -> Option<SsaValue> {
        if matches!(level, SsaValue::Lane(_)) {
            return None;
        }
        let key = Computation::TextureSize { texture, axis, level };
        if let Some(v) = self.find_computed(&key) {
            return Some(v);
        }
        // Textures are bound per draw, so that the size has the rate of `level`, at least per draw.
        let dst = self.fresh_result(&[level]);
        Some(self.emit(dst, Some(key), SsaInstr::TextureSize { dst, texture, axis, level }))
    }
}

/// The type of an operation's result.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ResultKind {
    Float,
    Int,
    Bool,
    /// The type of the first operand.
    Same,
}

fn result_kind(op: Op) -> ResultKind {
    use Op::*;
    match op {
        FLt | FLe | FEq | FNe | ILt | ILe | ULt | ULe | IEq | INe | IsNan | IsInf | BNot => ResultKind::Bool,
        F16FromF | INeg | IAbs | ISign | INot | CountOneBits | LeadingZeros | TrailingZeros | ReverseBits | FirstLeadingBitI
        | FirstLeadingBitU | FirstTrailingBit | IFromF | UFromF | BitsFromF | IAdd | ISub | IMul | IDiv | UDiv | IRem | URem | Shl
        | ShrI | ShrU | IMin | IMax | UMin | UMax => ResultKind::Int,
        And | Or | Xor | Copy | Select => ResultKind::Same,
        _ => ResultKind::Float,
    }
}
