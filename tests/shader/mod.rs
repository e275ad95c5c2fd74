//! Keys, emitted modules, the library on disk, and questions that modules answer.

mod formulas;
mod keys;
mod library;
mod probe;
