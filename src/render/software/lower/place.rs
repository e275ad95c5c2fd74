//! Resolves pointers to places, and loads and stores the values at these places. A place is either scalars of the environment (`Lowerer::env`, the current
//! values of all shader variables) or bytes of the uniform block. An index is constant, or dynamic: known only when the shader runs.
//!
//! Always: an index out of range counts as that of the last element, also a negative one, for loads and for stores. So does naga's bounds check `Restrict`,
//! with which wgpu compiles for Vulkan, Metal and Direct3D. naga refuses modules with a constant index out of range; an index that only the lowering knows (the
//! counter of an unrolled loop) is treated as a dynamic one.

use super::error::{LowerError, Result};
use super::lowerer::Lowerer;
use super::ssa::SsaValue;
use super::value::{DynamicIndex, Place};
use crate::render::software::tape::{Op, WordKind};
use naga::{ArraySize, ScalarKind, Span, TypeInner};

/// The kind of a scalar, or of the components of a vector.
pub(crate) fn scalar_kind_of(inner: &TypeInner, span: Span) -> Result<ScalarKind> {
    let scalar = inner.scalar().ok_or_else(|| LowerError::new("a scalar or vector is needed here".into(), span))?;
    supported_kind(scalar, span)
}

/// The kind of a scalar of 32 bits or a boolean; an error for other widths.
pub(crate) fn supported_kind(scalar: naga::Scalar, span: Span) -> Result<ScalarKind> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint, 4) | (ScalarKind::Bool, _) => Ok(scalar.kind),
        (kind, width) => Err(LowerError::new(format!("{kind:?} of {} bits is not supported", 8 * u32::from(width)), span)),
    }
}

/// Maximum number of scalars of an array. The number is limited because each scalar is an SSA value, and an access with a dynamic index selects among all
/// scalars.
const MAX_ARRAY_SCALARS: usize = 1 << 14;

impl Lowerer<'_> {
    /// Number of scalars in a value of this type.
    pub(crate) fn scalar_count(&self, inner: &TypeInner) -> Result<usize> {
        Ok(match inner {
            TypeInner::Scalar(_) => 1,
            TypeInner::Vector { size, .. } => *size as usize,
            TypeInner::Matrix { columns, rows, .. } => *columns as usize * *rows as usize,
            TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
                let count = self.scalar_count(&self.module.types[*base].inner)?.checked_mul(n.get() as usize);
                let too_large = || self.unsupported(format!("an array of more than {MAX_ARRAY_SCALARS} numbers is not supported"));
                count.filter(|count| *count <= MAX_ARRAY_SCALARS).ok_or_else(too_large)?
            }
            TypeInner::Struct { members, .. } => {
                let mut n = 0;
                for m in members {
                    n += self.scalar_count(&self.module.types[m.ty].inner)?;
                }
                n
            }
            other => return Err(self.unsupported(format!("values of this type are not supported: {other:?}"))),
        })
    }

    /// Child `index` of a composite type (a component, column, element or member): its type, and its offset from the
    /// start of the composite, in scalars and in bytes of a uniform block. `index` is in range.
    pub(crate) fn child_type_and_offsets(&self, inner: &TypeInner, index: u32) -> Result<(TypeInner, usize, u32)> {
        let k = index as usize;
        Ok(match inner {
            TypeInner::Vector { scalar, .. } => (TypeInner::Scalar(*scalar), k, 4 * index),
            TypeInner::Matrix { rows, scalar, .. } => {
                (TypeInner::Vector { size: *rows, scalar: *scalar }, k * *rows as usize, index * column_stride(*rows))
            }
            TypeInner::Array { base, stride, .. } => {
                let child = self.module.types[*base].inner.clone();
                let child_scalars = self.scalar_count(&child)?;
                (child, k * child_scalars, index * stride)
            }
            TypeInner::Struct { members, .. } => {
                let mut scalars_before = 0;
                for m in &members[..k] {
                    scalars_before += self.scalar_count(&self.module.types[m.ty].inner)?;
                }
                (self.module.types[members[k].ty].inner.clone(), scalars_before, members[k].offset)
            }
            other => return Err(self.unsupported(format!("cannot index {other:?}"))),
        })
    }

    /// Number of children of a composite type.
    pub(crate) fn child_count(&self, inner: &TypeInner) -> Result<u32> {
        Ok(match inner {
            TypeInner::Vector { size, .. } => *size as u32,
            TypeInner::Matrix { columns, .. } => *columns as u32,
            TypeInner::Array { size: ArraySize::Constant(n), .. } => n.get(),
            TypeInner::Struct { members, .. } => members.len() as u32,
            other => return Err(self.unsupported(format!("cannot index {other:?}"))),
        })
    }

    /// The place of child `index`, which exists, of the value at a place.
    pub(crate) fn place_at_constant_index(&mut self, place: &Place, index: u32) -> Result<Place> {
        let (child, offset_in_scalars, offset_in_bytes) = self.child_type_and_offsets(place.inner(), index)?;
        Ok(match place.clone() {
            Place::Variable { base, indices, .. } => Place::Variable { base: base + offset_in_scalars, indices, inner: child },
            Place::Uniform { byte_offset, word_offset, .. } => {
                Place::Uniform { byte_offset: byte_offset + offset_in_bytes, word_offset, inner: child }
            }
        })
    }

    /// The place of the child at an index that may be dynamic. An index known here is clamped to the last child.
    pub(crate) fn place_at_index(&mut self, place: &Place, index: SsaValue) -> Result<Place> {
        let count = self.child_count(place.inner())?;
        if let Some(k) = self.builder.known_int(index) {
            return self.place_at_constant_index(place, k.min(count - 1));
        }
        // All children have the same type, so the offset of child 1 is the stride.
        let (child, stride_in_scalars, stride_in_bytes) = self.child_type_and_offsets(place.inner(), 1)?;
        Ok(match place.clone() {
            Place::Variable { base, mut indices, .. } => {
                indices.push(DynamicIndex { value: index, stride: stride_in_scalars, count });
                Place::Variable { base, indices, inner: child }
            }
            Place::Uniform { byte_offset, word_offset, .. } => {
                let last = self.builder.int(count - 1);
                let stride_in_words = self.builder.int(stride_in_bytes / 4);
                let clamped = self.builder.binary(Op::UMin, index, last);
                let words = self.builder.binary(Op::IMul, clamped, stride_in_words);
                let word_offset = Some(match word_offset {
                    Some(outer) => self.builder.binary(Op::IAdd, outer, words),
                    None => words,
                });
                Place::Uniform { byte_offset, word_offset, inner: child }
            }
        })
    }

    /// The scalars of the value at a place.
    pub(crate) fn load(&mut self, place: &Place) -> Result<Vec<SsaValue>> {
        match place {
            Place::Variable { base, indices, inner } => {
                let n = self.scalar_count(inner)?;
                self.load_local(*base, indices, n)
            }
            Place::Uniform { byte_offset, word_offset, inner } => {
                let (start, mut offsets_and_kinds) = (0, Vec::new());
                self.uniform_scalars(inner, start, &mut offsets_and_kinds)?;
                // The sum of the dynamic indices' offsets is clamped so that the load never leaves the uniform block.
                let words_to_end = self.uniform_size.saturating_sub(*byte_offset) / 4;
                let mut all = Vec::new();
                for (offset_in_bytes, kind) in offsets_and_kinds {
                    let index_and_limit = word_offset.map(|words| (words, words_to_end.saturating_sub(offset_in_bytes / 4)));
                    let word_kind = if kind == ScalarKind::Float { WordKind::Float } else { WordKind::Int };
                    all.push(self.builder.load_uniform(word_kind, byte_offset + offset_in_bytes, index_and_limit));
                }
                Ok(all)
            }
        }
    }

    /// Loads `n` scalars of the environment; `base`: index in `env` of the first one if all `indices` are 0. For each dynamic index, the element is selected
    /// among all elements; an index out of range selects the last one.
    fn load_local(&mut self, base: usize, indices: &[DynamicIndex], n: usize) -> Result<Vec<SsaValue>> {
        let Some((index, rest)) = indices.split_first() else {
            return Ok(self.env[base..base + n].to_vec());
        };
        let last = index.count - 1;
        let mut selected = self.load_local(base + last as usize * index.stride, rest, n)?;
        for k in (0..last).rev() {
            let element = self.load_local(base + k as usize * index.stride, rest, n)?;
            let position = self.builder.int(k);
            let is_selected = self.builder.binary(Op::IEq, index.value, position);
            for (scalar, candidate) in selected.iter_mut().zip(element) {
                *scalar = self.builder.select(is_selected, candidate, *scalar);
            }
        }
        Ok(selected)
    }

    /// Stores the scalars of a value at a place.
    pub(crate) fn store(&mut self, place: &Place, values: &[SsaValue]) -> Result<()> {
        match place {
            Place::Variable { base, indices, .. } => {
                let always = self.builder.bool(true);
                self.store_local(*base, &indices.clone(), values, always);
                Ok(())
            }
            Place::Uniform { .. } => Err(self.unsupported("the uniform block cannot be written".into())),
        }
    }

    /// Stores scalars in the lanes (shader invocations) where `cond` holds; `base` and `indices` as in [`Lowerer::load_local`]. An index out of range stores to
    /// the last element.
    fn store_local(&mut self, base: usize, indices: &[DynamicIndex], values: &[SsaValue], cond: SsaValue) {
        let Some((index, rest)) = indices.split_first() else {
            for (k, v) in values.iter().enumerate() {
                self.env[base + k] = self.builder.select(cond, *v, self.env[base + k]);
            }
            return;
        };
        for k in 0..index.count {
            let position = self.builder.int(k);
            let is_selected = if k + 1 == index.count {
                self.builder.binary(Op::ULe, position, index.value)
            } else {
                self.builder.binary(Op::IEq, index.value, position)
            };
            let is_stored = self.builder.binary(Op::And, cond, is_selected);
            self.store_local(base + k as usize * index.stride, rest, values, is_stored);
        }
    }

    /// Appends the byte offset and the kind of every scalar of a uniform of this type. `start`: byte offset of the uniform; all offsets have the same origin.
    fn uniform_scalars(&self, inner: &TypeInner, start: u32, out: &mut Vec<(u32, ScalarKind)>) -> Result<()> {
        if let TypeInner::Scalar(s) = inner {
            out.push((start, supported_kind(*s, self.span)?));
            return Ok(());
        }
        for k in 0..self.child_count(inner)? {
            let (child, _, offset_in_bytes) = self.child_type_and_offsets(inner, k)?;
            self.uniform_scalars(&child, start + offset_in_bytes, out)?;
        }
        Ok(())
    }

    /// The scalars of the zero value of a type.
    pub(crate) fn zeros(&mut self, inner: &TypeInner) -> Result<Vec<SsaValue>> {
        let n = self.scalar_count(inner)?;
        let mut zeros = Vec::with_capacity(n);
        self.append_zeros(inner, &mut zeros)?;
        Ok(zeros)
    }

    fn append_zeros(&mut self, inner: &TypeInner, out: &mut Vec<SsaValue>) -> Result<()> {
        if let TypeInner::Scalar(s) = inner {
            out.push(match supported_kind(*s, self.span)? {
                ScalarKind::Float => self.builder.float(0.0),
                ScalarKind::Bool => self.builder.bool(false),
                _ => self.builder.int(0),
            });
            return Ok(());
        }
        for k in 0..self.child_count(inner)? {
            let (child, _, _) = self.child_type_and_offsets(inner, k)?;
            self.append_zeros(&child, out)?;
        }
        Ok(())
    }
}

/// Bytes from one matrix column to the next in a uniform block (WGSL specification, *Alignment and Size*).
fn column_stride(rows: naga::VectorSize) -> u32 {
    if rows == naga::VectorSize::Bi { 8 } else { 16 }
}
