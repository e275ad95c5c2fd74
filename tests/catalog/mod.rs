//! Catalog files: the shipped files are valid, and errors in a file name its line.

mod entries;
mod moments;
