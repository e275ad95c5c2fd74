//! The value of an expression during lowering: scalars, a place (the target of a pointer), or a texture or sampler.

use super::ssa::SsaValue;
use naga::TypeInner;

/// An index that is not a constant, into an array, matrix or vector.
#[derive(Clone, Copy, Debug)]
pub struct DynamicIndex {
    pub value: SsaValue,
    /// Number of scalars from one element to the next.
    pub stride: usize,
    /// Number of elements.
    pub count: u32,
}

/// The target of a pointer, in a variable or in the uniform block. `inner`: the type of the value stored there.
#[derive(Clone, Debug)]
pub enum Place {
    /// Scalars of the environment (`Lowerer::env`: the current values of all variables in scope), as many as `inner` has. Position of
    /// the first in `env`: `base` plus the sum of each index times its stride. An index out of range counts as that of the last element.
    Variable { base: usize, indices: Vec<DynamicIndex>, inner: TypeInner },
    /// The uniform block from byte `byte_offset` plus `word_offset` words of 4 bytes. The word offset is computed from dynamic indices, each already
    /// clamped to the last element; `None` if there are none.
    Uniform { byte_offset: u32, word_offset: Option<SsaValue>, inner: TypeInner },
}

/// The value of an expression during lowering.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Scalars(Vec<SsaValue>),
    Place(Place),
    /// A texture or a sampler.
    Resource(naga::Handle<naga::GlobalVariable>),
}

impl Place {
    pub(crate) fn inner(&self) -> &TypeInner {
        match self {
            Self::Variable { inner, .. } | Self::Uniform { inner, .. } => inner,
        }
    }
}
