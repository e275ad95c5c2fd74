//! Keys, emitted modules, the library on disk, and queries that modules answer.

mod exports;
mod formulas;
mod hostile;
mod keys;
mod library;
mod probe;
mod wesl;
