//! What lies beyond all bodies: stars, the Milky Way, zodiacal light.

pub mod background;
pub mod frames;
pub mod map;
mod star_colour;
pub mod stars;
pub mod zodiacal;
