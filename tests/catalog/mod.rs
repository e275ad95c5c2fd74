//! Catalog files: what ships is sound, what is wrong in a file is said with its line.

mod entries;
mod moments;
