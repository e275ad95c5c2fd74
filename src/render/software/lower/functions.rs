//! Lowers the built-in functions of WGSL to tape operations.
//!
//! In: a function and its arguments. Out: the scalars of the result; an error for a function without a lowering, such as `frexp`.

use super::error::Result;
use super::lowerer::Lowerer;
use super::ssa::SsaValue;
use crate::render::software::tape::Op;
use naga::{Expression, Handle, MathFunction, ScalarKind, TypeInner};

/// `is_signed` of [`Lowerer::pack`] and [`Lowerer::unpack`]: components from -1 to 1 ...
const SNORM: bool = true;
/// ... or from 0 to 1.
const UNORM: bool = false;

impl Lowerer<'_> {
    /// Applies `op` to each pair of components; a scalar is paired with every component.
    fn map_pairs(&mut self, op: Op, a: &[SsaValue], b: &[SsaValue]) -> Vec<SsaValue> {
        let component = |v: &[SsaValue], i: usize| if v.len() == 1 { v[0] } else { v[i] };
        (0..a.len().max(b.len())).map(|i| self.builder.binary(op, component(a, i), component(b, i))).collect()
    }

    fn scale(&mut self, v: &[SsaValue], s: SsaValue) -> Vec<SsaValue> {
        v.iter().map(|x| self.builder.binary(Op::Mul, *x, s)).collect()
    }

    fn saturate(&mut self, x: SsaValue) -> SsaValue {
        let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
        let x = self.builder.binary(Op::Max, x, zero);
        self.builder.binary(Op::Min, x, one)
    }

    /// a*b+c, fused if the kernel class supports it.
    fn fma(&mut self, a: SsaValue, b: SsaValue, c: SsaValue) -> SsaValue {
        self.builder.op(Op::Fma, &[a, b, c])
    }

    /// The scalars of a built-in function's result: of a vector by component, of a matrix by column. `a`, `b`, `c` and `d` below are the arguments in WGSL's
    /// order.
    pub(crate) fn math(
        &mut self,
        fun: MathFunction,
        arg: Handle<Expression>,
        more_args: [Option<Handle<Expression>>; 3],
    ) -> Result<Vec<SsaValue>> {
        use MathFunction as M;
        let kind = self.component_kind(arg)?;
        let is_float = kind == ScalarKind::Float;
        let is_signed = kind == ScalarKind::Sint;
        let a = self.scalars_of(arg)?;
        let mut more_scalars: [Vec<SsaValue>; 3] = Default::default();
        for (scalars, handle) in more_scalars.iter_mut().zip(more_args) {
            if let Some(handle) = handle {
                *scalars = self.scalars_of(handle)?;
            }
        }
        let [b, c, d] = more_scalars;
        let map_each = |this: &mut Self, op: Op| a.iter().map(|x| this.builder.unary(op, *x)).collect::<Vec<_>>();
        let by_kind = |float: Op, signed: Op, unsigned: Op| {
            if is_float {
                float
            } else if is_signed {
                signed
            } else {
                unsigned
            }
        };
        Ok(match fun {
            M::Abs if is_float => map_each(self, Op::Abs),
            M::Abs if is_signed => map_each(self, Op::IAbs),
            M::Abs => a,
            M::Min => self.map_pairs(by_kind(Op::Min, Op::IMin, Op::UMin), &a, &b),
            M::Max => self.map_pairs(by_kind(Op::Max, Op::IMax, Op::UMax), &a, &b),
            M::Clamp => {
                let raised = self.map_pairs(by_kind(Op::Max, Op::IMax, Op::UMax), &a, &b);
                self.map_pairs(by_kind(Op::Min, Op::IMin, Op::UMin), &raised, &c)
            }
            M::Saturate => a.iter().map(|x| self.saturate(*x)).collect(),
            M::Cos => map_each(self, Op::Cos),
            M::Cosh => map_each(self, Op::Cosh),
            M::Sin => map_each(self, Op::Sin),
            M::Sinh => map_each(self, Op::Sinh),
            M::Tan => map_each(self, Op::Tan),
            M::Tanh => map_each(self, Op::Tanh),
            M::Acos => map_each(self, Op::Acos),
            M::Asin => map_each(self, Op::Asin),
            M::Atan => map_each(self, Op::Atan),
            M::Atan2 => self.map_pairs(Op::Atan2, &a, &b),
            M::Asinh => map_each(self, Op::Asinh),
            M::Acosh => map_each(self, Op::Acosh),
            M::Atanh => map_each(self, Op::Atanh),
            M::Radians | M::Degrees => {
                let factor = if fun == M::Radians { std::f64::consts::PI / 180.0 } else { 180.0 / std::f64::consts::PI };
                let factor = self.builder.float(factor);
                self.scale(&a, factor)
            }
            M::Ceil => map_each(self, Op::Ceil),
            M::Floor => map_each(self, Op::Floor),
            M::Round => map_each(self, Op::Round),
            M::Fract => map_each(self, Op::Fract),
            M::Trunc => map_each(self, Op::Trunc),
            M::Modf => {
                // The members of the result, in this order: `fract`, `whole`.
                let whole = map_each(self, Op::Trunc);
                let mut all = self.map_pairs(Op::Sub, &a, &whole);
                all.extend(whole);
                all
            }
            M::Ldexp => self.map_pairs(Op::Ldexp, &a, &b),
            M::Exp => map_each(self, Op::Exp),
            M::Exp2 => map_each(self, Op::Exp2),
            M::Log => map_each(self, Op::Log),
            M::Log2 => map_each(self, Op::Log2),
            M::Pow => self.map_pairs(Op::Pow, &a, &b),
            M::Dot => vec![if is_float { self.dot(&a, &b) } else { self.integer_dot(&a, &b) }],
            M::Outer => b.iter().flat_map(|y| self.scale(&a, *y)).collect(),
            M::Cross => {
                let mut all = Vec::new();
                for (i, j) in [(1, 2), (2, 0), (0, 1)] {
                    let p = self.builder.binary(Op::Mul, a[i], b[j]);
                    let q = self.builder.binary(Op::Mul, a[j], b[i]);
                    all.push(self.builder.binary(Op::Sub, p, q));
                }
                all
            }
            M::Distance => {
                let difference = self.map_pairs(Op::Sub, &a, &b);
                vec![self.length(&difference)]
            }
            M::Length => vec![self.length(&a)],
            M::Normalize => {
                let square = self.dot(&a, &a);
                let inverse = self.builder.unary(Op::InverseSqrt, square);
                self.scale(&a, inverse)
            }
            M::FaceForward => {
                // a if dot(b, c) < 0, else -a.
                let side = self.dot(&b, &c);
                let zero = self.builder.float(0.0);
                let keep = self.builder.binary(Op::FLt, side, zero);
                let negated = map_each(self, Op::Neg);
                a.iter().zip(negated).map(|(x, n)| self.builder.select(keep, *x, n)).collect()
            }
            M::Reflect => {
                let normal_component = self.dot(&b, &a);
                let minus_two = self.builder.float(-2.0);
                let normal_factor = self.builder.binary(Op::Mul, minus_two, normal_component);
                (0..a.len()).map(|i| self.fma(normal_factor, b[i], a[i])).collect()
            }
            M::Refract => self.refract(&a, &b, c[0]),
            M::Sign => map_each(self, if is_float { Op::Sign } else { Op::ISign }),
            M::Fma => (0..a.len()).map(|i| self.fma(a[i], b[i], c[i])).collect(),
            M::Mix => {
                let weight = |i: usize| if c.len() == 1 { c[0] } else { c[i] };
                let one = self.builder.float(1.0);
                let mut all = Vec::new();
                for i in 0..a.len() {
                    // a (1 - weight) + b weight: exact at both ends.
                    let weight_of_a = self.builder.binary(Op::Sub, one, weight(i));
                    let weighted_a = self.builder.binary(Op::Mul, a[i], weight_of_a);
                    all.push(self.fma(b[i], weight(i), weighted_a));
                }
                all
            }
            M::Step => {
                // a: the edge.
                let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
                let reached = self.map_pairs(Op::FLe, &a, &b);
                reached.into_iter().map(|r| self.builder.select(r, one, zero)).collect()
            }
            M::SmoothStep => {
                let (three, minus_two) = (self.builder.float(3.0), self.builder.float(-2.0));
                // a: low, b: high, c: x. t = (x - low) / (high - low), then 3 t^2 - 2 t^3.
                let from_low = self.map_pairs(Op::Sub, &c, &a);
                let range = self.map_pairs(Op::Sub, &b, &a);
                let t = self.map_pairs(Op::Div, &from_low, &range);
                let mut all = Vec::new();
                for t in t {
                    let t = self.saturate(t);
                    let square = self.builder.binary(Op::Mul, t, t);
                    let rest = self.fma(minus_two, t, three);
                    all.push(self.builder.binary(Op::Mul, square, rest));
                }
                all
            }
            M::Sqrt => map_each(self, Op::Sqrt),
            M::InverseSqrt => map_each(self, Op::InverseSqrt),
            M::Transpose => {
                let rows = self.rows(arg)?;
                (0..rows).flat_map(|r| a.iter().skip(r).step_by(rows).copied().collect::<Vec<_>>()).collect()
            }
            M::Determinant => {
                let rows = self.rows(arg)?;
                vec![self.determinant(&a, rows)]
            }
            M::QuantizeToF16 => map_each(self, Op::QuantizeF16),
            M::CountTrailingZeros => map_each(self, Op::TrailingZeros),
            M::CountLeadingZeros => map_each(self, Op::LeadingZeros),
            M::CountOneBits => map_each(self, Op::CountOneBits),
            M::ReverseBits => map_each(self, Op::ReverseBits),
            M::FirstTrailingBit => map_each(self, Op::FirstTrailingBit),
            M::FirstLeadingBit => map_each(self, if is_signed { Op::FirstLeadingBitI } else { Op::FirstLeadingBitU }),
            M::ExtractBits => a.iter().map(|x| self.extract_bits(*x, b[0], c[0], is_signed)).collect(),
            M::InsertBits => a.iter().zip(&b).map(|(x, y)| self.insert_bits(*x, *y, c[0], d[0])).collect(),
            M::Pack4x8snorm => vec![self.pack(&a, 8, 127.0, SNORM)],
            M::Pack4x8unorm => vec![self.pack(&a, 8, 255.0, UNORM)],
            M::Pack2x16snorm => vec![self.pack(&a, 16, 32767.0, SNORM)],
            M::Pack2x16unorm => vec![self.pack(&a, 16, 65535.0, UNORM)],
            M::Pack2x16float => {
                let halves = map_each(self, Op::F16FromF);
                let shift = self.builder.int(16);
                let high = self.builder.binary(Op::Shl, halves[1], shift);
                vec![self.builder.binary(Op::Or, halves[0], high)]
            }
            M::Unpack4x8snorm => self.unpack(a[0], 8, 127.0, SNORM),
            M::Unpack4x8unorm => self.unpack(a[0], 8, 255.0, UNORM),
            M::Unpack2x16snorm => self.unpack(a[0], 16, 32767.0, SNORM),
            M::Unpack2x16unorm => self.unpack(a[0], 16, 65535.0, UNORM),
            M::Unpack2x16float => {
                let (shift, low) = (self.builder.int(16), self.builder.int(0xffff));
                let halves = [self.builder.binary(Op::And, a[0], low), self.builder.binary(Op::ShrU, a[0], shift)];
                halves.into_iter().map(|h| self.builder.unary(Op::FFromF16, h)).collect()
            }
            other => return Err(self.unsupported(format!("built-in function {other:?} is not supported"))),
        })
    }

    /// Number of rows of a matrix.
    fn rows(&self, arg: Handle<Expression>) -> Result<usize> {
        match self.type_of(arg) {
            TypeInner::Matrix { rows, .. } => Ok(*rows as usize),
            _ => Err(self.unsupported("a matrix is needed here".into())),
        }
    }

    fn length(&mut self, v: &[SsaValue]) -> SsaValue {
        if let [x] = v {
            return self.builder.unary(Op::Abs, *x);
        }
        let square = self.dot(v, v);
        self.builder.unary(Op::Sqrt, square)
    }

    /// WGSL `refract`: zero for total internal reflection.
    fn refract(&mut self, incident: &[SsaValue], normal: &[SsaValue], eta: SsaValue) -> Vec<SsaValue> {
        let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
        let cosine = self.dot(normal, incident);
        let cosine_squared = self.builder.binary(Op::Mul, cosine, cosine);
        let sine_squared = self.builder.binary(Op::Sub, one, cosine_squared);
        let eta_squared = self.builder.binary(Op::Mul, eta, eta);
        let refracted_sine_squared = self.builder.binary(Op::Mul, eta_squared, sine_squared);
        let refracted_cosine_squared = self.builder.binary(Op::Sub, one, refracted_sine_squared);
        let is_total_reflection = self.builder.binary(Op::FLt, refracted_cosine_squared, zero);
        let refracted_cosine = self.builder.unary(Op::Sqrt, refracted_cosine_squared);
        let normal_factor = self.fma(eta, cosine, refracted_cosine);
        (0..incident.len())
            .map(|i| {
                let from_incident = self.builder.binary(Op::Mul, eta, incident[i]);
                let from_normal = self.builder.binary(Op::Mul, normal_factor, normal[i]);
                let refracted = self.builder.binary(Op::Sub, from_incident, from_normal);
                self.builder.select(is_total_reflection, zero, refracted)
            })
            .collect()
    }

    /// Determinant of a column-major matrix of `n` columns and `n` rows, by cofactor expansion along the first column.
    fn determinant(&mut self, m: &[SsaValue], n: usize) -> SsaValue {
        if n == 1 {
            return m[0];
        }
        let mut sum = None;
        for r in 0..n {
            let minor: Vec<SsaValue> = m.iter().enumerate().skip(n).filter(|(i, _)| i % n != r).map(|(_, v)| *v).collect();
            let minor = self.determinant(&minor, n - 1);
            let term = self.builder.binary(Op::Mul, m[r], minor);
            sum = Some(match sum {
                None => term,
                Some(s) if r % 2 == 1 => self.builder.binary(Op::Sub, s, term),
                Some(s) => self.builder.binary(Op::Add, s, term),
            });
        }
        sum.unwrap_or(m[0])
    }

    /// WGSL `extractBits`.
    fn extract_bits(&mut self, x: SsaValue, offset: SsaValue, count: SsaValue, is_signed: bool) -> SsaValue {
        let (zero, word_bits) = (self.builder.int(0), self.builder.int(32));
        let offset = self.builder.binary(Op::UMin, offset, word_bits);
        let available = self.builder.binary(Op::ISub, word_bits, offset);
        let count = self.builder.binary(Op::UMin, count, available);
        let is_empty = self.builder.binary(Op::IEq, count, zero);
        let bits_above = self.builder.binary(Op::ISub, available, count);
        let bits_outside = self.builder.binary(Op::ISub, word_bits, count);
        // A shift takes its number of bits modulo 32, which matters only for a count of 0: the select below handles it.
        let left_aligned = self.builder.binary(Op::Shl, x, bits_above);
        let y = self.builder.binary(if is_signed { Op::ShrI } else { Op::ShrU }, left_aligned, bits_outside);
        self.builder.select(is_empty, zero, y)
    }

    /// WGSL `insertBits`.
    fn insert_bits(&mut self, x: SsaValue, new: SsaValue, offset: SsaValue, count: SsaValue) -> SsaValue {
        let (zero, word_bits, all_ones) = (self.builder.int(0), self.builder.int(32), self.builder.int(u32::MAX));
        let offset = self.builder.binary(Op::UMin, offset, word_bits);
        let available = self.builder.binary(Op::ISub, word_bits, offset);
        let count = self.builder.binary(Op::UMin, count, available);
        let is_empty = self.builder.binary(Op::IEq, count, zero);
        let bits_outside = self.builder.binary(Op::ISub, word_bits, count);
        // Here, too, shifts by 32 occur only for a count of 0.
        let ones = self.builder.binary(Op::ShrU, all_ones, bits_outside);
        let mask = self.builder.binary(Op::Shl, ones, offset);
        let shifted = self.builder.binary(Op::Shl, new, offset);
        let inside = self.builder.binary(Op::And, shifted, mask);
        let inverse_mask = self.builder.unary(Op::INot, mask);
        let outside = self.builder.binary(Op::And, x, inverse_mask);
        let y = self.builder.binary(Op::Or, inside, outside);
        self.builder.select(is_empty, x, y)
    }

    /// Packs components into one word of fields of `bits` bits each, the first in the lowest bits. A component of 1 becomes the integer `scale`.
    fn pack(&mut self, v: &[SsaValue], bits: u32, scale: f64, is_signed: bool) -> SsaValue {
        let minimum = self.builder.float(if is_signed { -1.0 } else { 0.0 });
        let (one, half, scale) = (self.builder.float(1.0), self.builder.float(0.5), self.builder.float(scale));
        let mask = self.builder.int((1u32 << bits) - 1);
        let mut word = self.builder.int(0);
        for (i, x) in v.iter().enumerate() {
            let x = self.builder.binary(Op::Max, *x, minimum);
            let x = self.builder.binary(Op::Min, x, one);
            let x = self.fma(x, scale, half);
            let x = self.builder.unary(Op::Floor, x);
            let x = self.builder.unary(Op::IFromF, x);
            let x = self.builder.binary(Op::And, x, mask);
            let shift = self.builder.int(bits * i as u32);
            let x = self.builder.binary(Op::Shl, x, shift);
            word = self.builder.binary(Op::Or, word, x);
        }
        word
    }

    /// The components of a word, as [`Lowerer::pack`] packs them.
    fn unpack(&mut self, x: SsaValue, bits: u32, scale: f64, is_signed: bool) -> Vec<SsaValue> {
        let (scale, minus_one) = (self.builder.float(scale), self.builder.float(-1.0));
        let width = self.builder.int(bits);
        (0..32 / bits)
            .map(|i| {
                let offset = self.builder.int(bits * i);
                let part = self.extract_bits(x, offset, width, is_signed);
                let y = self.builder.unary(if is_signed { Op::FFromI } else { Op::FFromU }, part);
                let y = self.builder.binary(Op::Div, y, scale);
                if is_signed { self.builder.binary(Op::Max, y, minus_one) } else { y }
            })
            .collect()
    }
}
