//! Why a scene cannot be planned.

use super::graph::GraphError;
use crate::shader::reflect::LayoutError;

/// Why a scene cannot be planned; the message is one line.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error("module {module}: {source}")]
    Layout { module: String, source: LayoutError },
    /// A module that does not exist, or data that it needs and the scene lacks.
    #[error("{0}")]
    Module(String),
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// A file of a map that could not be read.
    #[error("map {file}: {why}")]
    Map { file: String, why: String },
}
