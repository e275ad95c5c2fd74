//! The shipped maps, and what is kept of them between runs.

mod poles;
mod shipped_maps;
mod stored_maps;
