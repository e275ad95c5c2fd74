//! Keys, generated modules, and the library that keeps them.
//!
//! [`key`] says what to draw, [`mod@emit`] writes the WGSL, [`module`] parses, validates, reflects and lowers it, [`library`] keeps the result.

#[doc(hidden)]
pub mod compare;
#[doc(hidden)]
pub mod constants;
pub mod emit;
pub mod fragments;
#[doc(hidden)]
pub mod generator;
pub mod id;
pub mod key;
#[doc(hidden)]
pub mod library;
pub mod module;
#[doc(hidden)]
pub mod record;
pub mod reflect;
#[doc(hidden)]
pub mod source;
pub mod source_map;
pub mod translate;

pub use emit::{Emitted, emit};
pub use id::ModuleId;
pub use library::Library;
pub use module::{Lowering, LoweringFailure, ShaderModule};
pub use reflect::{Layout, UniformWriter};
pub use source_map::SourceMap;

/// Why a module could not be made. None of these can happen with the fragments that ship; they are what a changed fragment meets.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// A fragment is no WESL, or not of the kind that the generator reads.
    #[error("shaders/{path}:{line}:{column}: {what}")]
    Fragment {
        /// Below shaders/.
        path: String,
        /// The first is 1.
        line: u32,
        /// The first is 1.
        column: u32,
        /// What is wrong.
        what: String,
    },
    /// No such name among the simple modules and probes.
    #[error("there is no shader module `{0}`")]
    NoSuchModule(String),
    /// The emitted text is no WGSL.
    #[error("module {id}: {what}")]
    Parse {
        /// Which module.
        id: String,
        /// What naga's parser says.
        what: String,
    },
    /// The emitted text is WGSL, but not valid.
    #[error("module {id} is not valid: {what}")]
    Invalid {
        /// Which module.
        id: String,
        /// What naga's validator says.
        what: String,
    },
    /// A binding that the plan does not fill.
    #[error("module {id}: {source}")]
    Layout {
        /// Which module.
        id: String,
        /// Which binding or field.
        source: reflect::LayoutError,
    },
    /// The software renderer has no operation for it.
    #[error("module {id} cannot be lowered for the software renderer: {what}")]
    Lowering {
        /// Which module.
        id: String,
        /// What is missing.
        what: String,
    },
}
