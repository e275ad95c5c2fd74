//! The error of the lowering: why a module cannot be lowered, with the position in its source.

use crate::shader::LoweringFailure;
use naga::Span;

/// Why a module cannot run in the software renderer.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{what}")]
pub struct LowerError {
    /// What is not supported, as a message.
    pub what: String,
    /// Position in the WGSL text; undefined for a module that was read from the library, and for what no single construct causes.
    pub span: Span,
}

impl LowerError {
    pub(crate) fn new(what: String, span: Span) -> Self {
        Self { what, span }
    }
}

impl From<LowerError> for LoweringFailure {
    fn from(e: LowerError) -> Self {
        Self { what: e.what, span: e.span }
    }
}

pub(crate) type Result<T> = std::result::Result<T, LowerError>;
