//! What lies beyond all bodies: stars, the Milky Way, zodiacal light; and what is too small to be a body of the catalog: minor planets and comets.

pub mod background;
pub mod comets;
pub mod frames;
pub mod images;
pub mod map;
pub mod minor_planet_columns;
pub mod minor_planets;
mod star_colour;
pub mod stars;
pub mod zodiacal;

pub use star_colour::temperature_k;
