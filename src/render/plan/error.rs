//! Why a scene cannot be planned.

use super::graph::GraphError;
use crate::shader::reflect::LayoutError;

#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error("module {module}: {source}")]
    Layout { module: String, source: LayoutError },
    #[error("{0}")]
    Module(String),
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The file, and why it could not be read.
    #[error("map {file}: {why}")]
    Map { file: String, why: String },
}
