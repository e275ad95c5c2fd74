//! Catalog files: the shipped files are valid, and errors in a file name its line.

mod atmospheres;
mod entries;
mod moments;
mod user_files;
