//! The value of an expression during lowering: scalars, a place to which a pointer refers, or a texture or sampler.

use super::step::SsaValue;
use naga::TypeInner;

/// An index that is not a constant, into an array, matrix or vector.
#[derive(Clone, Copy, Debug)]
pub struct VariableIndex {
    pub value: SsaValue,
    /// Scalars from one element to the next.
    pub stride: usize,
    /// Number of elements.
    pub count: u32,
}

/// A place in a variable or in the uniform block; `inner` is the type of the place.
#[derive(Clone, Debug)]
pub enum Place {
    /// The scalars of the environment (`Lowerer::env`: the current values of all variables in scope) from `base` plus each index times its stride.
    /// A load with an index out of range reads the last element; a store with an index out of range has no effect.
    Local { base: usize, indices: Vec<VariableIndex>, inner: TypeInner },
    /// The uniform block from byte `offset` plus `dynamic` words of 4 bytes; the indices in `dynamic` are clamped to the last element already.
    Uniform { offset: u32, dynamic: Option<SsaValue>, inner: TypeInner },
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
            Self::Local { inner, .. } | Self::Uniform { inner, .. } => inner,
        }
    }
}
