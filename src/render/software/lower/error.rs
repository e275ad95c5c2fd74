//! The error of the lowering: why a module cannot be lowered, with the position in its source.

use naga::Span;

/// Why a module cannot run in the software renderer.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}{what}", .line.map(|l| format!("line {l}: ")).unwrap_or_default())]
pub struct LowerError {
    /// What is not supported, as a message.
    pub what: String,
    /// Position in the WGSL text; undefined for a module that was read from the library.
    pub span: Span,
    /// 1-based line of `span`, set by [`LowerError::with_source`].
    pub line: Option<u32>,
}

impl LowerError {
    pub(crate) fn new(what: String, span: Span) -> Self {
        Self { what, span, line: None }
    }

    /// Finds the line of the span in the module's text.
    pub fn with_source(mut self, wgsl: &str) -> Self {
        self.line = self.span.is_defined().then(|| self.span.location(wgsl).line_number);
        self
    }
}

pub(crate) type Result<T> = std::result::Result<T, LowerError>;
