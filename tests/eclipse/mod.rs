//! Sunlight that bodies block: reference tables, exact contacts, overlapping discs, totality, faint transits, effects beside an eclipse.

mod air_of_planets;
mod beside_others;
mod draft;
mod faint_transits;
mod linear_penumbra;
mod overlapping_limbs;
mod reference_tables;
mod small_corona;
mod totality;
mod twilight;
mod umbra;
