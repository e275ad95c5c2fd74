//! What lies beyond all bodies: the stars.

mod star_colour;
pub mod stars;
