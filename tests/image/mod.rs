//! The shipped maps.

mod poles;
mod shipped_maps;
