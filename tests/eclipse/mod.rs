//! Sunlight that bodies block: reference tables, exact contacts, overlapping discs, totality.

mod draft;
mod linear_penumbra;
mod overlapping_limbs;
mod reference_tables;
mod totality;
mod twilight;
mod umbra;
