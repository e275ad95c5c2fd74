//! The maps of Orrery, as encoded image files. README.md states source, licence, projection, prime meridian and colour space of each file.
//!
//! Nothing is decoded here. The crate exists because a package in a registry holds 10 MB at most.

/// File name and bytes of every map, in order of name.
pub static MAPS: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/maps.rs"));
