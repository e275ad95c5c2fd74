//! The shipped maps, the light curves that follow from them, and decoded maps stored between runs.

mod light_curves;
mod pole_filter;
mod shipped_maps;
mod stored_maps;
