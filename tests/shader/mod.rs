//! Keys, emitted modules, the library on disk, and questions that modules answer.

mod keys;
mod library;
mod probe;
