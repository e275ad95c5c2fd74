//! Keys, generated modules, and the library that keeps them.
pub mod key;
