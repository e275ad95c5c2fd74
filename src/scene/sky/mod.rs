//! What lies beyond all bodies, the stars, and what is too small to be a body of the catalog: minor planets and comets.

pub mod comets;
pub mod minor_planet_columns;
pub mod minor_planets;
mod star_colour;
pub mod stars;
