//! The sky: stars, the Milky Way and zodiacal light behind all bodies; also minor planets and comets, which are too small to be bodies of the
//! catalog.

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
