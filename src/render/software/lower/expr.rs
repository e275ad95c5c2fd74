//! Lowers expressions.
//!
//! In: an expression of naga's IR. Out: a [`Value`]: a list of scalars in SSA form, a place (the target of a pointer), or a texture or sampler; an error for an
//! expression that the software renderer does not support. Not here: built-in functions (`functions.rs`), loads and stores (`place.rs`).

use super::error::Result;
use super::lowerer::Lowerer;
use super::place::{scalar_kind_of, supported_kind};
use super::ssa::SsaValue;
use super::value::{Place, Value};
use crate::render::software::program::{Constant, TextureUse};
use crate::render::software::tape::{Op, TextureOp};
use naga::{
    BinaryOperator, DerivativeAxis, Expression, Handle, ImageClass, ImageDimension, ImageQuery, Literal, RelationalFunction, SampleLevel,
    ScalarKind, TypeInner, UnaryOperator,
};

impl<'m> Lowerer<'m> {
    /// The type of an expression of the function that is being lowered; `handle` means such an expression here and below.
    pub(crate) fn type_of(&self, handle: Handle<Expression>) -> &'m TypeInner {
        let module: &'m naga::Module = self.module;
        self.frame().info[handle].ty.inner_with(&module.types)
    }

    /// The value of an expression: the stored one after a call or an `Emit` statement. Any other expression (a constant, an argument, a variable) is evaluated
    /// at each use, and its value is not stored.
    pub(crate) fn value_of(&mut self, handle: Handle<Expression>) -> Result<Value> {
        match self.frame().values.get(&handle) {
            Some(v) => Ok(v.clone()),
            None => self.evaluate(handle),
        }
    }

    /// The scalars of a value, in the order of components, columns, elements or members; an error for a pointer, texture or sampler.
    pub(crate) fn scalars_of(&mut self, handle: Handle<Expression>) -> Result<Vec<SsaValue>> {
        match self.value_of(handle)? {
            Value::Scalars(scalars) => Ok(scalars),
            _ => Err(self.unsupported("a value is needed here".into())),
        }
    }

    /// The value of a scalar expression.
    pub(crate) fn scalar_of(&mut self, handle: Handle<Expression>) -> Result<SsaValue> {
        let scalars = self.scalars_of(handle)?;
        scalars.first().copied().ok_or_else(|| self.unsupported("a scalar is needed here".into()))
    }

    /// The target of a pointer.
    pub(crate) fn place_of(&mut self, handle: Handle<Expression>) -> Result<Place> {
        match self.value_of(handle)? {
            Value::Place(p) => Ok(p),
            _ => Err(self.unsupported("a pointer is needed here".into())),
        }
    }

    fn literal(&mut self, literal: Literal) -> Result<SsaValue> {
        Ok(match literal {
            Literal::F32(x) => self.builder.float(f64::from(x)),
            Literal::AbstractFloat(x) => self.builder.float(x),
            Literal::U32(u) => self.builder.int(u),
            Literal::I32(i) => self.builder.int(i as u32),
            Literal::AbstractInt(i) => self.builder.int(i as u32),
            Literal::Bool(b) => self.builder.constant(Constant::Bool(b)),
            other => return Err(self.unsupported(format!("literal {other:?} is not supported"))),
        })
    }

    /// Evaluates a constant expression of the module; `handle` is one of naga's `global_expressions`.
    pub(crate) fn global_expression(&mut self, handle: Handle<Expression>) -> Result<Vec<SsaValue>> {
        let module: &'m naga::Module = self.module;
        match &module.global_expressions[handle] {
            Expression::Literal(l) => Ok(vec![self.literal(*l)?]),
            Expression::Constant(c) => self.global_expression(module.constants[*c].init),
            Expression::ZeroValue(ty) => self.zeros(&module.types[*ty].inner),
            Expression::Compose { components, .. } => {
                let mut all = Vec::new();
                for c in components {
                    all.extend(self.global_expression(*c)?);
                }
                Ok(all)
            }
            Expression::Splat { size, value } => {
                let v = self.global_expression(*value)?;
                Ok(vec![v[0]; *size as usize])
            }
            other => Err(self.unsupported(format!("constant expression {other:?} is not supported"))),
        }
    }

    /// As [`Self::value_of`], without the stored values.
    pub(crate) fn evaluate(&mut self, handle: Handle<Expression>) -> Result<Value> {
        let function = self.frame().function;
        let span = function.expressions.get_span(handle);
        if span.is_defined() {
            self.span = span;
        }
        let module: &'m naga::Module = self.module;
        let scalars = match &function.expressions[handle] {
            Expression::Literal(l) => vec![self.literal(*l)?],
            Expression::Constant(c) => self.global_expression(module.constants[*c].init)?,
            Expression::ZeroValue(ty) => self.zeros(&module.types[*ty].inner)?,
            Expression::Compose { components, .. } => {
                let mut all = Vec::new();
                for c in components {
                    all.extend(self.scalars_of(*c)?);
                }
                all
            }
            Expression::Splat { size, value } => vec![self.scalar_of(*value)?; *size as usize],
            Expression::Swizzle { size, vector, pattern } => {
                let v = self.scalars_of(*vector)?;
                pattern[..*size as usize].iter().map(|c| v[*c as usize]).collect()
            }
            Expression::FunctionArgument(i) => return Ok(self.frame().arguments[*i as usize].clone()),
            Expression::GlobalVariable(g) => return Ok(self.globals[g].clone()),
            Expression::LocalVariable(l) => {
                let inner = module.types[function.local_variables[*l].ty].inner.clone();
                return Ok(Value::Place(Place::Variable { base: self.frame().locals[l], indices: Vec::new(), inner }));
            }
            Expression::Load { pointer } => {
                let place = self.place_of(*pointer)?;
                self.load(&place)?
            }
            Expression::AccessIndex { base, index } => match self.value_of(*base)? {
                Value::Place(p) => return Ok(Value::Place(self.place_at_constant_index(&p, *index)?)),
                Value::Scalars(scalars) => {
                    let (child_type, first, _byte_offset) = self.child_type_and_offsets(self.type_of(*base), *index)?;
                    let n = self.scalar_count(&child_type)?;
                    scalars[first..first + n].to_vec()
                }
                Value::Resource(_) => return Err(self.unsupported("arrays of textures are not supported".into())),
            },
            Expression::Access { base, index } => {
                let k = self.scalar_of(*index)?;
                match self.value_of(*base)? {
                    Value::Place(p) => return Ok(Value::Place(self.place_at_index(&p, k)?)),
                    Value::Scalars(scalars) => self.select_element(self.type_of(*base), &scalars, k)?,
                    Value::Resource(_) => return Err(self.unsupported("arrays of textures are not supported".into())),
                }
            }
            Expression::Unary { op, expr } => {
                let is_float = self.component_kind(*expr)? == ScalarKind::Float;
                let op = match op {
                    UnaryOperator::Negate if is_float => Op::Neg,
                    UnaryOperator::Negate => Op::INeg,
                    UnaryOperator::LogicalNot => Op::BNot,
                    UnaryOperator::BitwiseNot => Op::INot,
                };
                self.map_scalars(*expr, op)?
            }
            Expression::Binary { op, left, right } => self.binary(*op, *left, *right)?,
            Expression::Select { condition, accept, reject } => {
                // One condition for all components, or one for each.
                let (c, a, r) = (self.scalars_of(*condition)?, self.scalars_of(*accept)?, self.scalars_of(*reject)?);
                (0..a.len()).map(|i| self.builder.select(if c.len() == 1 { c[0] } else { c[i] }, a[i], r[i])).collect()
            }
            Expression::Derivative { axis, expr, .. } => {
                let v = self.scalars_of(*expr)?;
                v.into_iter().map(|x| self.derivative(*axis, x)).collect()
            }
            Expression::Relational { fun, argument } => match fun {
                RelationalFunction::IsNan => self.map_scalars(*argument, Op::IsNan)?,
                RelationalFunction::IsInf => self.map_scalars(*argument, Op::IsInf)?,
                RelationalFunction::All => vec![self.fold_scalars(*argument, Op::And)?],
                RelationalFunction::Any => vec![self.fold_scalars(*argument, Op::Or)?],
            },
            Expression::Math { fun, arg, arg1, arg2, arg3 } => self.math(*fun, *arg, [*arg1, *arg2, *arg3])?,
            Expression::As { expr, kind, convert } => self.convert(*expr, *kind, *convert)?,
            Expression::ImageSample { image, sampler, gather, coordinate, array_index, offset, level, depth_ref, clamp_to_edge } => {
                for (used, what) in [
                    (gather.is_some(), "textureGather"),
                    (array_index.is_some(), "a texture array"),
                    (offset.is_some(), "a texel offset"),
                    (depth_ref.is_some(), "a depth comparison"),
                    (*clamp_to_edge, "textureSampleBaseClampToEdge"),
                ] {
                    if used {
                        return Err(self.unsupported(format!("{what} is not supported")));
                    }
                }
                self.sample(*image, *sampler, *coordinate, *level)?
            }
            Expression::ImageLoad { image, coordinate, array_index: None, sample: None, level } => {
                let no_sampler = None;
                let texture = self.texture_index(*image, no_sampler)?;
                let c = self.scalars_of(*coordinate)?;
                let level = match level {
                    Some(l) => self.scalar_of(*l)?,
                    None => self.builder.int(0),
                };
                self.builder.texture(TextureOp::Load, texture, &[c[0], c[1], level], self.active_mask).to_vec()
            }
            Expression::ImageQuery { image, query } => {
                let no_sampler = None;
                let texture = self.texture_index(*image, no_sampler)?;
                // Axes as in `Instr::TextureSize`: 0 is the width, 1 the height, 2 the number of levels.
                let (axes, level): (&[u8], _) = match query {
                    ImageQuery::Size { level } => (&[0, 1], *level),
                    ImageQuery::NumLevels => (&[2], None),
                    _ => return Err(self.unsupported("this texture query is not supported".into())),
                };
                let level = match level {
                    Some(l) => self.scalar_of(l)?,
                    None => self.builder.int(0),
                };
                let mut all = Vec::new();
                for axis in axes {
                    let size = self.builder.texture_size(texture, *axis, level);
                    all.push(
                        size.ok_or_else(|| self.unsupported("textureDimensions needs a level that is the same for all pixels".into()))?,
                    );
                }
                all
            }
            other => {
                // The name of the variant, without its fields.
                let name = format!("{other:?}");
                let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_owned();
                return Err(self.unsupported(format!("expression {name} is not supported")));
            }
        };
        Ok(Value::Scalars(scalars))
    }

    /// Applies one operation to every scalar of a value.
    pub(crate) fn map_scalars(&mut self, expr: Handle<Expression>, op: Op) -> Result<Vec<SsaValue>> {
        let v = self.scalars_of(expr)?;
        Ok(v.into_iter().map(|x| self.builder.unary(op, x)).collect())
    }

    /// Combines all scalars of a value by one operation.
    fn fold_scalars(&mut self, expr: Handle<Expression>, op: Op) -> Result<SsaValue> {
        let v = self.scalars_of(expr)?;
        v.into_iter().reduce(|a, b| self.builder.binary(op, a, b)).ok_or_else(|| self.unsupported("a vector is needed here".into()))
    }

    /// WGSL `dpdx`, `dpdy` or `fwidth`; zero for a value that all lanes share.
    pub(crate) fn derivative(&mut self, axis: DerivativeAxis, x: SsaValue) -> SsaValue {
        if !matches!(x, SsaValue::Lane(_)) {
            return self.builder.float(0.0);
        }
        match axis {
            DerivativeAxis::X => self.builder.unary(Op::Dpdx, x),
            DerivativeAxis::Y => self.builder.unary(Op::Dpdy, x),
            DerivativeAxis::Width => {
                let (dx, dy) = (self.builder.unary(Op::Dpdx, x), self.builder.unary(Op::Dpdy, x));
                let (dx, dy) = (self.builder.unary(Op::Abs, dx), self.builder.unary(Op::Abs, dy));
                self.builder.binary(Op::Add, dx, dy)
            }
        }
    }

    /// The kind of the components of a scalar, vector or matrix.
    pub(crate) fn component_kind(&self, handle: Handle<Expression>) -> Result<ScalarKind> {
        match self.type_of(handle) {
            TypeInner::Matrix { scalar, .. } => supported_kind(*scalar, self.span),
            other => scalar_kind_of(other, self.span),
        }
    }

    /// The element of a vector, matrix or array at an index that may be variable; the last element if the index is out of range, also below 0.
    fn select_element(&mut self, inner: &TypeInner, scalars: &[SsaValue], index: SsaValue) -> Result<Vec<SsaValue>> {
        let count = self.child_count(inner)? as usize;
        let element_length = scalars.len() / count;
        if let Some(k) = self.builder.known_int(index) {
            let k = (k as usize).min(count - 1);
            return Ok(scalars[k * element_length..(k + 1) * element_length].to_vec());
        }
        let mut selected = scalars[(count - 1) * element_length..].to_vec();
        for k in (0..count - 1).rev() {
            let position = self.builder.int(k as u32);
            let is_selected = self.builder.binary(Op::IEq, index, position);
            for (scalar, candidate) in selected.iter_mut().zip(&scalars[k * element_length..]) {
                *scalar = self.builder.select(is_selected, *candidate, *scalar);
            }
        }
        Ok(selected)
    }

    /// Dot product of vectors of floats.
    pub(crate) fn dot(&mut self, a: &[SsaValue], b: &[SsaValue]) -> SsaValue {
        self.sum_of_products(a, b, Op::Mul, Op::Add)
    }

    /// Dot product of vectors of integers.
    pub(crate) fn integer_dot(&mut self, a: &[SsaValue], b: &[SsaValue]) -> SsaValue {
        self.sum_of_products(a, b, Op::IMul, Op::IAdd)
    }

    fn sum_of_products(&mut self, a: &[SsaValue], b: &[SsaValue], mul: Op, add: Op) -> SsaValue {
        let mut sum = self.builder.binary(mul, a[0], b[0]);
        for (x, y) in a.iter().zip(b).skip(1) {
            let product = self.builder.binary(mul, *x, *y);
            sum = self.builder.binary(add, product, sum);
        }
        sum
    }

    /// A binary operator on scalars, vectors or matrices.
    fn binary(&mut self, op: BinaryOperator, left: Handle<Expression>, right: Handle<Expression>) -> Result<Vec<SsaValue>> {
        let (left_type, right_type) = (self.type_of(left), self.type_of(right));
        let kind = self.component_kind(left)?;
        let (a, b) = (self.scalars_of(left)?, self.scalars_of(right)?);
        if op == BinaryOperator::Multiply {
            match (left_type, right_type) {
                (TypeInner::Matrix { rows, .. }, TypeInner::Vector { .. }) => return Ok(self.matrix_times_vector(&a, &b, *rows as usize)),
                // Each component of the product is the dot product with a column.
                (TypeInner::Vector { .. }, TypeInner::Matrix { rows, .. }) => {
                    return Ok(b.chunks(*rows as usize).map(|column| self.dot(&a, column)).collect());
                }
                (TypeInner::Matrix { rows, .. }, TypeInner::Matrix { rows: rows_of_b, .. }) => {
                    return Ok(b
                        .chunks(*rows_of_b as usize)
                        .flat_map(|column| self.matrix_times_vector(&a, column, *rows as usize))
                        .collect());
                }
                _ => {}
            }
        }
        let n = a.len().max(b.len());
        let component = |v: &[SsaValue], i: usize| if v.len() == 1 { v[0] } else { v[i] };
        Ok((0..n).map(|i| self.binary_scalar(op, kind, component(&a, i), component(&b, i))).collect())
    }

    /// The product of a column-major matrix with `rows` rows and a vector.
    fn matrix_times_vector(&mut self, m: &[SsaValue], v: &[SsaValue], rows: usize) -> Vec<SsaValue> {
        (0..rows)
            .map(|r| {
                let row: Vec<SsaValue> = m.chunks(rows).map(|column| column[r]).collect();
                self.dot(&row, v)
            })
            .collect()
    }

    /// A binary operator on two scalars of one kind; a > b is computed as b < a.
    fn binary_scalar(&mut self, op: BinaryOperator, kind: ScalarKind, a: SsaValue, b: SsaValue) -> SsaValue {
        use BinaryOperator as B;
        // Not for operators on `Bool`. There is no shift of floats.
        let by_kind = |float: Op, signed: Op, unsigned: Op| match kind {
            ScalarKind::Float => float,
            ScalarKind::Sint => signed,
            _ => unsigned,
        };
        let has_bool_operands = kind == ScalarKind::Bool;
        let (op, is_swapped) = match op {
            B::Add => (by_kind(Op::Add, Op::IAdd, Op::IAdd), false),
            B::Subtract => (by_kind(Op::Sub, Op::ISub, Op::ISub), false),
            B::Multiply => (by_kind(Op::Mul, Op::IMul, Op::IMul), false),
            B::Divide => (by_kind(Op::Div, Op::IDiv, Op::UDiv), false),
            B::Modulo => (by_kind(Op::FRem, Op::IRem, Op::URem), false),
            B::Equal if has_bool_operands => {
                let x = self.builder.binary(Op::Xor, a, b);
                return self.builder.not(x);
            }
            B::NotEqual if has_bool_operands => (Op::Xor, false),
            B::Equal => (by_kind(Op::FEq, Op::IEq, Op::IEq), false),
            B::NotEqual => (by_kind(Op::FNe, Op::INe, Op::INe), false),
            B::Less => (by_kind(Op::FLt, Op::ILt, Op::ULt), false),
            B::LessEqual => (by_kind(Op::FLe, Op::ILe, Op::ULe), false),
            B::Greater => (by_kind(Op::FLt, Op::ILt, Op::ULt), true),
            B::GreaterEqual => (by_kind(Op::FLe, Op::ILe, Op::ULe), true),
            B::And | B::LogicalAnd => (Op::And, false),
            B::InclusiveOr | B::LogicalOr => (Op::Or, false),
            B::ExclusiveOr => (Op::Xor, false),
            B::ShiftLeft => (Op::Shl, false),
            B::ShiftRight => (by_kind(Op::ShrU, Op::ShrI, Op::ShrU), false),
        };
        if is_swapped { self.builder.binary(op, b, a) } else { self.builder.binary(op, a, b) }
    }

    /// Converts the scalars of a value to another kind of scalar, `width` bytes wide; without a `width`, reinterprets their bits (`bitcast`).
    fn convert(&mut self, expr: Handle<Expression>, kind: ScalarKind, width: Option<u8>) -> Result<Vec<SsaValue>> {
        use ScalarKind as K;
        let from = self.component_kind(expr)?;
        let v = self.scalars_of(expr)?;
        if let Some(w) = width {
            supported_kind(naga::Scalar { kind, width: w }, self.span)?;
        }
        let (zero_f, one_f) = (self.builder.float(0.0), self.builder.float(1.0));
        let (zero_i, one_i) = (self.builder.int(0), self.builder.int(1));
        let mut out = Vec::with_capacity(v.len());
        for x in v {
            let b = &mut self.builder;
            out.push(match (from, kind, width.is_some()) {
                // Signed and unsigned integers are stored as the same bits.
                (K::Float, K::Float, _) | (K::Sint | K::Uint, K::Sint | K::Uint, _) | (K::Bool, K::Bool, _) => x,
                (K::Float, _, false) => b.unary(Op::BitsFromF, x),
                (_, K::Float, false) => b.unary(Op::FFromBits, x),
                (K::Float, K::Sint, true) => b.unary(Op::IFromF, x),
                (K::Float, K::Uint, true) => b.unary(Op::UFromF, x),
                (K::Sint, K::Float, true) => b.unary(Op::FFromI, x),
                (K::Uint, K::Float, true) => b.unary(Op::FFromU, x),
                (K::Bool, K::Float, true) => b.select(x, one_f, zero_f),
                (K::Bool, K::Sint | K::Uint, true) => b.select(x, one_i, zero_i),
                (K::Float, K::Bool, true) => b.binary(Op::FNe, x, zero_f),
                (K::Sint | K::Uint, K::Bool, true) => b.binary(Op::INe, x, zero_i),
                _ => return Err(self.unsupported(format!("conversion from {from:?} to {kind:?} is not supported"))),
            });
        }
        Ok(out)
    }

    /// Index in the program's list of textures with their samplers; adds the texture if the list lacks it. `sampler`: `None` for reads without a sampler.
    pub(crate) fn texture_index(&mut self, image: Handle<Expression>, sampler: Option<Handle<Expression>>) -> Result<u16> {
        let inner = self.type_of(image);
        let is_supported = matches!(
            inner,
            TypeInner::Image {
                dim: ImageDimension::D2,
                arrayed: false,
                class: ImageClass::Sampled { kind: ScalarKind::Float, multi: false },
            }
        );
        if !is_supported {
            return Err(self.unsupported(format!("only texture_2d<f32> is supported, not {inner:?}")));
        }
        let texture_binding = self.binding(image)?;
        let sampler_binding = sampler.map(|s| self.binding(s)).transpose()?;
        let texture_use = TextureUse { texture_binding, sampler_binding };
        let index = self.textures.iter().position(|t| *t == texture_use).unwrap_or_else(|| {
            self.textures.push(texture_use);
            self.textures.len() - 1
        });
        Ok(index as u16)
    }

    /// The binding number of a texture or sampler variable.
    fn binding(&mut self, handle: Handle<Expression>) -> Result<u32> {
        let Value::Resource(global) = self.value_of(handle)? else {
            return Err(self.unsupported("a texture or sampler variable is needed here".into()));
        };
        match &self.module.global_variables[global].binding {
            Some(b) if b.group == 0 => Ok(b.binding),
            _ => Err(self.unsupported("textures and samplers must be in @group(0)".into())),
        }
    }

    /// WGSL `textureSample` and its variants: red, green, blue and alpha.
    fn sample(
        &mut self,
        image: Handle<Expression>,
        sampler: Handle<Expression>,
        coordinate: Handle<Expression>,
        level: SampleLevel,
    ) -> Result<Vec<SsaValue>> {
        let texture = self.texture_index(image, Some(sampler))?;
        let uv = self.scalars_of(coordinate)?;
        let (u, v) = (uv[0], uv[1]);
        // du/dx, dv/dx, du/dy, dv/dy.
        let gradients = match level {
            SampleLevel::Zero => {
                let zero = self.builder.float(0.0);
                return Ok(self.builder.texture(TextureOp::Level, texture, &[u, v, zero], self.active_mask).to_vec());
            }
            SampleLevel::Exact(l) => {
                let l = self.scalar_of(l)?;
                return Ok(self.builder.texture(TextureOp::Level, texture, &[u, v, l], self.active_mask).to_vec());
            }
            SampleLevel::Gradient { x, y } => {
                let (x, y) = (self.scalars_of(x)?, self.scalars_of(y)?);
                [x[0], x[1], y[0], y[1]]
            }
            SampleLevel::Auto | SampleLevel::Bias(_) => {
                let mut g = [
                    self.derivative(DerivativeAxis::X, u),
                    self.derivative(DerivativeAxis::X, v),
                    self.derivative(DerivativeAxis::Y, u),
                    self.derivative(DerivativeAxis::Y, v),
                ];
                if let SampleLevel::Bias(b) = level {
                    // A bias of b levels corresponds to a footprint 2^b times as large.
                    let b = self.scalar_of(b)?;
                    let factor = self.builder.unary(Op::Exp2, b);
                    g = g.map(|d| self.builder.binary(Op::Mul, d, factor));
                }
                g
            }
        };
        let args: Vec<SsaValue> = [u, v].into_iter().chain(gradients).collect();
        Ok(self.builder.texture(TextureOp::Gradients, texture, &args, self.active_mask).to_vec())
    }
}
