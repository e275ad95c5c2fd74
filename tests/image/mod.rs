//! The shipped maps, and decoded maps stored between runs.

mod poles;
mod shipped_maps;
mod stored_maps;
