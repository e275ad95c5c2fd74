//! Errors of queries.

use crate::ephemeris::EphemerisError;
use crate::render::software::RenderError;
use crate::scene::SceneError;
use crate::session::SessionError;
use crate::shader::ShaderError;
use crate::shader::reflect::LayoutError;

/// Why a query has no answer. The message is one line: an invalid field with its allowed values, or the step that failed.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The query is invalid, or its computation gave no answer; the text says which.
    #[error("{0}")]
    Query(String),
    /// The position of a body is not known at that time.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
    /// The view is impossible.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The view cannot be planned.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The module cannot be compiled.
    #[error(transparent)]
    Shader(#[from] ShaderError),
    /// The module needs something that the query does not provide.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The module cannot be run.
    #[error(transparent)]
    Render(#[from] RenderError),
}

impl From<String> for ProbeError {
    fn from(why: String) -> Self {
        Self::Query(why)
    }
}

impl From<&str> for ProbeError {
    fn from(why: &str) -> Self {
        Self::Query(why.into())
    }
}
