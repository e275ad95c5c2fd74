//! Shader keys, generated shader modules, and the shader library, a cache of these modules in memory and on disk.
//!
//! In: the features of a draw, or the name of a simple shader. Out: a [`ShaderModule`]: WGSL, naga IR, layout, and a program for the software renderer.
//! [`id`] names the module: a body's by its [`key`], a simple shader's by the name of its fragment. [`mod@emit`] writes its WGSL from the [`fragments`];
//! [`module`] parses, validates, reflects and lowers it; [`library`] caches the result, in a folder that [`generator`] names. [`source`] parses fragments;
//! [`constants`] writes the fragments with the numbers that Rust and shaders share. [`translate`] writes a module in other shading languages, [`compare`]
//! compares two modules, [`record`] records digests of all modules. In these files, a *module* is such a shader module, and a *fragment* is a WESL source file
//! of shaders/, never the fragment stage.

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
pub use library::ShaderLibrary;
pub use module::{Lowering, LoweringFailure, ShaderModule, TapeFault};
pub use reflect::{Layout, UniformWriter};
pub use source_map::SourceMap;

/// Why a module could not be built. With the shipped WESL files, only [`ShaderError::NoSuchModule`] can occur; the others come from a user's files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// A file is not valid WESL, or uses syntax that the generator does not support.
    #[error("shaders/{path}:{line}:{column}: {what}")]
    Fragment {
        /// Path below shaders/.
        path: String,
        /// Counted from 1; 0 if there is no such file.
        line: u32,
        /// Counted from 1; 0 if there is no such file.
        column: u32,
        /// What is wrong.
        what: String,
    },
    /// No simple shader or probe has this name.
    #[error("there is no shader module `{0}`")]
    NoSuchModule(String),
    /// The emitted text is not WGSL.
    #[error("module {id}: {what}")]
    Parse {
        /// Which module.
        id: String,
        /// Message of naga's parser.
        what: String,
    },
    /// The emitted text is WGSL, but not valid.
    #[error("module {id} is not valid: {what}")]
    Invalid {
        /// Which module.
        id: String,
        /// Message of naga's validator.
        what: String,
    },
    /// The module has a binding or a uniform that the plan does not fill.
    #[error("module {id}: {source}")]
    Layout {
        /// Which module.
        id: String,
        /// Which binding or field.
        source: reflect::LayoutError,
    },
    /// The module uses a construct for which the software renderer has no operation.
    #[error("module {id} cannot be lowered for the software renderer: {what}")]
    Lowering {
        /// Which module.
        id: String,
        /// The unsupported construct, after its place.
        what: String,
    },
}
