//! Lowers the built-in functions of WGSL to tape operations.

use super::error::Result;
use super::lowerer::Lowerer;
use super::step::Val;
use crate::render::software::tape::Op;
use naga::{Expression, Handle, MathFunction, ScalarKind, TypeInner};

impl Lowerer<'_> {
    fn map2(&mut self, op: Op, a: &[Val], b: &[Val]) -> Vec<Val> {
        let of = |v: &[Val], i: usize| if v.len() == 1 { v[0] } else { v[i] };
        (0..a.len().max(b.len())).map(|i| self.builder.bin(op, of(a, i), of(b, i))).collect()
    }

    fn scale(&mut self, v: &[Val], s: Val) -> Vec<Val> {
        v.iter().map(|x| self.builder.bin(Op::Mul, *x, s)).collect()
    }

    fn clamp01(&mut self, x: Val) -> Val {
        let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
        let x = self.builder.bin(Op::Max, x, zero);
        self.builder.bin(Op::Min, x, one)
    }

    /// a*b+c, fused if the kernel class supports it.
    fn fma(&mut self, a: Val, b: Val, c: Val) -> Val {
        self.builder.op(Op::Fma, &[a, b, c])
    }

    pub(crate) fn math(&mut self, fun: MathFunction, arg: Handle<Expression>, more: [Option<Handle<Expression>>; 3]) -> Result<Vec<Val>> {
        use MathFunction as M;
        let kind = self.kind_of_any(arg)?;
        let float = kind == ScalarKind::Float;
        let signed = kind == ScalarKind::Sint;
        let a = self.scalars_of(arg)?;
        let mut rest: [Vec<Val>; 3] = Default::default();
        for (r, h) in rest.iter_mut().zip(more) {
            if let Some(h) = h {
                *r = self.scalars_of(h)?;
            }
        }
        let [b, c, d] = rest;
        let each = |this: &mut Self, op: Op| a.iter().map(|x| this.builder.un(op, *x)).collect::<Vec<_>>();
        let pick = |f: Op, s: Op, u: Op| {
            if float {
                f
            } else if signed {
                s
            } else {
                u
            }
        };
        Ok(match fun {
            M::Abs if !float && !signed => a,
            M::Abs => each(self, pick(Op::Abs, Op::IAbs, Op::Copy)),
            M::Min => self.map2(pick(Op::Min, Op::IMin, Op::UMin), &a, &b),
            M::Max => self.map2(pick(Op::Max, Op::IMax, Op::UMax), &a, &b),
            M::Clamp => {
                let low = self.map2(pick(Op::Max, Op::IMax, Op::UMax), &a, &b);
                self.map2(pick(Op::Min, Op::IMin, Op::UMin), &low, &c)
            }
            M::Saturate => a.iter().map(|x| self.clamp01(*x)).collect(),
            M::Cos => each(self, Op::Cos),
            M::Cosh => each(self, Op::Cosh),
            M::Sin => each(self, Op::Sin),
            M::Sinh => each(self, Op::Sinh),
            M::Tan => each(self, Op::Tan),
            M::Tanh => each(self, Op::Tanh),
            M::Acos => each(self, Op::Acos),
            M::Asin => each(self, Op::Asin),
            M::Atan => each(self, Op::Atan),
            M::Atan2 => self.map2(Op::Atan2, &a, &b),
            M::Asinh => each(self, Op::Asinh),
            M::Acosh => each(self, Op::Acosh),
            M::Atanh => each(self, Op::Atanh),
            M::Radians | M::Degrees => {
                let f = if fun == M::Radians { std::f64::consts::PI / 180.0 } else { 180.0 / std::f64::consts::PI };
                let f = self.builder.float(f);
                self.scale(&a, f)
            }
            M::Ceil => each(self, Op::Ceil),
            M::Floor => each(self, Op::Floor),
            M::Round => each(self, Op::Round),
            M::Fract => each(self, Op::Fract),
            M::Trunc => each(self, Op::Trunc),
            M::Modf => {
                // The members of the result are `fract` and `whole`.
                let whole = each(self, Op::Trunc);
                let mut all = self.map2(Op::Sub, &a, &whole);
                all.extend(whole);
                all
            }
            M::Ldexp => self.map2(Op::Ldexp, &a, &b),
            M::Exp => each(self, Op::Exp),
            M::Exp2 => each(self, Op::Exp2),
            M::Log => each(self, Op::Log),
            M::Log2 => each(self, Op::Log2),
            M::Pow => self.map2(Op::Pow, &a, &b),
            M::Dot => vec![self.dot(&a, &b, float)],
            M::Outer => b.iter().flat_map(|y| self.scale(&a, *y)).collect(),
            M::Cross => {
                let mut all = Vec::new();
                for (i, j) in [(1, 2), (2, 0), (0, 1)] {
                    let p = self.builder.bin(Op::Mul, a[i], b[j]);
                    let q = self.builder.bin(Op::Mul, a[j], b[i]);
                    all.push(self.builder.bin(Op::Sub, p, q));
                }
                all
            }
            M::Distance => {
                let difference = self.map2(Op::Sub, &a, &b);
                vec![self.length(&difference)]
            }
            M::Length => vec![self.length(&a)],
            M::Normalize => {
                let square = self.dot(&a, &a, true);
                let inverse = self.builder.un(Op::InverseSqrt, square);
                self.scale(&a, inverse)
            }
            M::FaceForward => {
                // a if dot(b, c) < 0, else -a.
                let side = self.dot(&b, &c, true);
                let zero = self.builder.float(0.0);
                let keep = self.builder.bin(Op::FLt, side, zero);
                let negated = each(self, Op::Neg);
                a.iter().zip(negated).map(|(x, n)| self.builder.select(keep, *x, n)).collect()
            }
            M::Reflect => {
                let along = self.dot(&b, &a, true);
                let minus_two = self.builder.float(-2.0);
                let f = self.builder.bin(Op::Mul, minus_two, along);
                (0..a.len()).map(|i| self.fma(f, b[i], a[i])).collect()
            }
            M::Refract => self.refract(&a, &b, c[0]),
            M::Sign => each(self, if float { Op::Sign } else { Op::ISign }),
            M::Fma => (0..a.len()).map(|i| self.fma(a[i], b[i], c[i])).collect(),
            M::Mix => {
                let t = |i: usize| if c.len() == 1 { c[0] } else { c[i] };
                let one = self.builder.float(1.0);
                let mut all = Vec::new();
                for i in 0..a.len() {
                    // a (1 - t) + b t: exact at both ends.
                    let s = self.builder.bin(Op::Sub, one, t(i));
                    let p = self.builder.bin(Op::Mul, a[i], s);
                    all.push(self.fma(b[i], t(i), p));
                }
                all
            }
            M::Step => {
                let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
                let reached = self.map2(Op::FLe, &a, &b);
                reached.into_iter().map(|r| self.builder.select(r, one, zero)).collect()
            }
            M::SmoothStep => {
                let (three, minus_two) = (self.builder.float(3.0), self.builder.float(-2.0));
                let above = self.map2(Op::Sub, &c, &a);
                let span = self.map2(Op::Sub, &b, &a);
                let t = self.map2(Op::Div, &above, &span);
                let mut all = Vec::new();
                for x in t {
                    let x = self.clamp01(x);
                    let square = self.builder.bin(Op::Mul, x, x);
                    let rest = self.fma(minus_two, x, three);
                    all.push(self.builder.bin(Op::Mul, square, rest));
                }
                all
            }
            M::Sqrt => each(self, Op::Sqrt),
            M::InverseSqrt => each(self, Op::InverseSqrt),
            M::Transpose => {
                let rows = self.rows(arg)?;
                (0..rows).flat_map(|r| a.iter().skip(r).step_by(rows).copied().collect::<Vec<_>>()).collect()
            }
            M::Determinant => {
                let rows = self.rows(arg)?;
                vec![self.determinant(&a, rows)]
            }
            M::QuantizeToF16 => each(self, Op::QuantizeF16),
            M::CountTrailingZeros => each(self, Op::TrailingZeros),
            M::CountLeadingZeros => each(self, Op::LeadingZeros),
            M::CountOneBits => each(self, Op::CountOneBits),
            M::ReverseBits => each(self, Op::ReverseBits),
            M::FirstTrailingBit => each(self, Op::FirstTrailingBit),
            M::FirstLeadingBit => each(self, if signed { Op::FirstLeadingBitI } else { Op::FirstLeadingBitU }),
            M::ExtractBits => a.iter().map(|x| self.extract_bits(*x, b[0], c[0], signed)).collect(),
            M::InsertBits => a.iter().zip(&b).map(|(x, y)| self.insert_bits(*x, *y, c[0], d[0])).collect(),
            M::Pack4x8snorm => vec![self.pack(&a, 8, 127.0, true)],
            M::Pack4x8unorm => vec![self.pack(&a, 8, 255.0, false)],
            M::Pack2x16snorm => vec![self.pack(&a, 16, 32767.0, true)],
            M::Pack2x16unorm => vec![self.pack(&a, 16, 65535.0, false)],
            M::Pack2x16float => {
                let halves = each(self, Op::F16FromF);
                let by = self.builder.int(16);
                let high = self.builder.bin(Op::Shl, halves[1], by);
                vec![self.builder.bin(Op::Or, halves[0], high)]
            }
            M::Unpack4x8snorm => self.unpack(a[0], 8, 127.0, true),
            M::Unpack4x8unorm => self.unpack(a[0], 8, 255.0, false),
            M::Unpack2x16snorm => self.unpack(a[0], 16, 32767.0, true),
            M::Unpack2x16unorm => self.unpack(a[0], 16, 65535.0, false),
            M::Unpack2x16float => {
                let (by, low) = (self.builder.int(16), self.builder.int(0xffff));
                let halves = [self.builder.bin(Op::And, a[0], low), self.builder.bin(Op::ShrU, a[0], by)];
                halves.into_iter().map(|h| self.builder.un(Op::FFromF16, h)).collect()
            }
            other => return Err(self.unsupported(format!("built-in function {other:?} is not supported"))),
        })
    }

    fn rows(&self, arg: Handle<Expression>) -> Result<usize> {
        match self.type_of(arg) {
            TypeInner::Matrix { rows, .. } => Ok(*rows as usize),
            _ => Err(self.unsupported("a matrix is needed here".into())),
        }
    }

    fn length(&mut self, v: &[Val]) -> Val {
        if let [x] = v {
            return self.builder.un(Op::Abs, *x);
        }
        let square = self.dot(v, v, true);
        self.builder.un(Op::Sqrt, square)
    }

    /// WGSL `refract`: zero for total internal reflection.
    fn refract(&mut self, incident: &[Val], normal: &[Val], eta: Val) -> Vec<Val> {
        let (zero, one) = (self.builder.float(0.0), self.builder.float(1.0));
        let cosine = self.dot(normal, incident, true);
        let cosine_squared = self.builder.bin(Op::Mul, cosine, cosine);
        let sine_squared = self.builder.bin(Op::Sub, one, cosine_squared);
        let eta_squared = self.builder.bin(Op::Mul, eta, eta);
        let refracted_sine_squared = self.builder.bin(Op::Mul, eta_squared, sine_squared);
        let k = self.builder.bin(Op::Sub, one, refracted_sine_squared);
        let total = self.builder.bin(Op::FLt, k, zero);
        let root = self.builder.un(Op::Sqrt, k);
        let f = self.fma(eta, cosine, root);
        (0..incident.len())
            .map(|i| {
                let along = self.builder.bin(Op::Mul, eta, incident[i]);
                let part = self.builder.bin(Op::Mul, f, normal[i]);
                let y = self.builder.bin(Op::Sub, along, part);
                self.builder.select(total, zero, y)
            })
            .collect()
    }

    /// Determinant of a column-major matrix, by cofactor expansion along the first column.
    fn determinant(&mut self, m: &[Val], n: usize) -> Val {
        if n == 1 {
            return m[0];
        }
        let mut sum = None;
        for r in 0..n {
            let minor: Vec<Val> = m.iter().enumerate().skip(n).filter(|(i, _)| i % n != r).map(|(_, v)| *v).collect();
            let minor = self.determinant(&minor, n - 1);
            let term = self.builder.bin(Op::Mul, m[r], minor);
            sum = Some(match sum {
                None => term,
                Some(s) if r % 2 == 1 => self.builder.bin(Op::Sub, s, term),
                Some(s) => self.builder.bin(Op::Add, s, term),
            });
        }
        sum.unwrap_or(m[0])
    }

    fn extract_bits(&mut self, x: Val, offset: Val, count: Val, signed: bool) -> Val {
        let (zero, full) = (self.builder.int(0), self.builder.int(32));
        let offset = self.builder.bin(Op::UMin, offset, full);
        let available = self.builder.bin(Op::ISub, full, offset);
        let count = self.builder.bin(Op::UMin, count, available);
        let none = self.builder.bin(Op::IEq, count, zero);
        let above = self.builder.bin(Op::ISub, available, count);
        let down = self.builder.bin(Op::ISub, full, count);
        // Shifts take their count modulo 32, which matters only for a count of 0: the select below handles it.
        let top = self.builder.bin(Op::Shl, x, above);
        let y = self.builder.bin(if signed { Op::ShrI } else { Op::ShrU }, top, down);
        self.builder.select(none, zero, y)
    }

    fn insert_bits(&mut self, x: Val, new: Val, offset: Val, count: Val) -> Val {
        let (zero, full, all) = (self.builder.int(0), self.builder.int(32), self.builder.int(u32::MAX));
        let offset = self.builder.bin(Op::UMin, offset, full);
        let available = self.builder.bin(Op::ISub, full, offset);
        let count = self.builder.bin(Op::UMin, count, available);
        let none = self.builder.bin(Op::IEq, count, zero);
        let down = self.builder.bin(Op::ISub, full, count);
        let ones = self.builder.bin(Op::ShrU, all, down);
        let mask = self.builder.bin(Op::Shl, ones, offset);
        let moved = self.builder.bin(Op::Shl, new, offset);
        let inside = self.builder.bin(Op::And, moved, mask);
        let not = self.builder.un(Op::INot, mask);
        let outside = self.builder.bin(Op::And, x, not);
        let y = self.builder.bin(Op::Or, inside, outside);
        self.builder.select(none, x, y)
    }

    fn pack(&mut self, v: &[Val], bits: u32, scale: f64, signed: bool) -> Val {
        let low = self.builder.float(if signed { -1.0 } else { 0.0 });
        let (one, half, scale) = (self.builder.float(1.0), self.builder.float(0.5), self.builder.float(scale));
        let mask = self.builder.int((1u32 << bits) - 1);
        let mut word = self.builder.int(0);
        for (i, x) in v.iter().enumerate() {
            let x = self.builder.bin(Op::Max, *x, low);
            let x = self.builder.bin(Op::Min, x, one);
            let x = self.fma(x, scale, half);
            let x = self.builder.un(Op::Floor, x);
            let x = self.builder.un(Op::IFromF, x);
            let x = self.builder.bin(Op::And, x, mask);
            let by = self.builder.int(bits * i as u32);
            let x = self.builder.bin(Op::Shl, x, by);
            word = self.builder.bin(Op::Or, word, x);
        }
        word
    }

    fn unpack(&mut self, x: Val, bits: u32, scale: f64, signed: bool) -> Vec<Val> {
        let (scale, minus_one) = (self.builder.float(scale), self.builder.float(-1.0));
        let width = self.builder.int(bits);
        (0..32 / bits)
            .map(|i| {
                let offset = self.builder.int(bits * i);
                let part = self.extract_bits(x, offset, width, signed);
                let y = self.builder.un(if signed { Op::FFromI } else { Op::FFromU }, part);
                let y = self.builder.bin(Op::Div, y, scale);
                if signed { self.builder.bin(Op::Max, y, minus_one) } else { y }
            })
            .collect()
    }
}
