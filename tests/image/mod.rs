//! The maps that ship.

mod poles;
mod shipped_maps;
