//! Keys, generated modules, and the library that keeps them.
//!
//! [`key`] says what to draw, [`mod@emit`] writes the WGSL, [`module`] parses, validates, reflects and lowers it, [`library`] keeps the result.

pub mod compare;
pub mod emit;
pub mod fragments;
pub mod generator;
pub mod key;
pub mod library;
pub mod module;
pub mod record;
pub mod reflect;
pub mod translate;

pub use emit::{Emitted, SourceMap, emit};
pub use library::Library;
pub use module::{Lowering, ModuleId, ShaderModule};
pub use reflect::{Layout, UniformWriter};

/// Why a module could not be made. None of these can happen with the fragments that ship; they are what a changed fragment meets.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    #[error("shaders/{path}:{line}: {what}")]
    Fragment { path: String, line: u32, what: String },
    #[error("there is no shader module `{0}`")]
    NoSuchModule(String),
    #[error("module {id}: {what}")]
    Parse { id: String, what: String },
    #[error("module {id} is not valid: {what}")]
    Invalid { id: String, what: String },
    #[error("module {id}: {source}")]
    Layout { id: String, source: reflect::LayoutError },
    #[error("module {id} cannot be lowered for the software renderer: {what}")]
    Lowering { id: String, what: String },
}
