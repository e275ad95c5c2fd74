//! Why a question has no answer.

use crate::ephemeris::EphemerisError;
use crate::render::software::RenderError;
use crate::scene::SceneError;
use crate::session::SessionError;
use crate::shader::ShaderError;
use crate::shader::reflect::LayoutError;

/// One line: which field and what it may be, or what the program could not make.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The question cannot be read, or asks for what cannot be.
    #[error("{0}")]
    Question(String),
    /// No body's position at that time.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
    /// The view cannot be.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The view cannot be planned.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The module cannot be made.
    #[error(transparent)]
    Shader(#[from] ShaderError),
    /// The module asks for what the question does not give.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The module cannot be run.
    #[error(transparent)]
    Render(#[from] RenderError),
}

impl From<String> for ProbeError {
    fn from(why: String) -> Self {
        Self::Question(why)
    }
}

impl From<&str> for ProbeError {
    fn from(why: &str) -> Self {
        Self::Question(why.into())
    }
}
