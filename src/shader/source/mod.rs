//! WESL fragments: what one file says, and under which conditions.
//!
//! In: the text of a fragment of shaders/. Out: [`Fragment`]: its lines cut at the spans of conditional items, its imports and the
//! names that it declares. [`condition`] reads and evaluates `@if` conditions; [`predicates`] names the ones that several
//! fragments ask for. Always: a fragment is parsed once, whatever the number of modules made of it. Not here: which
//! fragments there are (`shader::fragments`) and how lines become a module (`shader::emit`).

mod block;
pub mod condition;
mod fragment;
mod limits;
pub mod predicates;
mod scan;

pub use block::Block;
pub use fragment::{Fragment, Import, Line, Piece};
