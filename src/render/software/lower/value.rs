//! The value of an expression during lowering: scalars, a place to which a pointer refers, or a texture or sampler.

use super::step::Val;
use naga::TypeInner;

/// A place in a variable or in the uniform block; `inner` is the type of the place.
#[derive(Clone, Debug)]
pub enum Place {
    /// Scalar `base` of the environment, plus the sum of each index (clamped to its count) times its stride in scalars. `indices`: value, count,
    /// stride.
    Local { base: usize, indices: Vec<(Val, usize, u32)>, inner: TypeInner },
    /// Byte `offset` of the uniform block plus `dynamic` scalars.
    Uniform { offset: u32, dynamic: Option<Val>, inner: TypeInner },
}

/// The value of an expression during lowering.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Scalars(Vec<Val>),
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
