//! Parses fragments, the WESL files of shaders/: their lines, conditions and imports.
//!
//! In: the text of a fragment. Out: [`Fragment`]: its lines, divided where conditional items begin and end, its imports and the names
//! that it declares. [`condition`] parses and evaluates `@if` conditions; [`predicates`] names conditions that several fragments
//! share; [`with_prefixed_names`] keeps the names of a custom surface apart from those of other fragments. Always: a fragment is
//! parsed once, however many modules contain it. Not here: the list of fragments (`shader::fragments`) and the emission of modules
//! (`shader::emit`).

mod block;
pub mod condition;
mod fragment;
mod limits;
mod own_names;
pub mod predicates;
mod scan;

pub use block::Block;
pub use fragment::{Fragment, FragmentLine, Import, Piece};
pub use own_names::with_prefixed_names;
