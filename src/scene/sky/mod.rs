//! The sky: stars, the Milky Way, zodiacal light and the user's images behind all bodies; also minor planets and comets, which are drawn from orbital
//! elements, not as bodies of the catalog.
//!
//! In: the catalog, the camera with its motion, the threshold, and the radiance displayed as white. Out: sprites, patches of light and uniforms, each with a
//! decision and its reason.

pub mod background;
pub mod comet_tails;
pub mod comets;
pub mod frames;
pub mod images;
pub mod map;
pub mod minor_planet_columns;
pub mod minor_planets;
pub mod small_body_sight;
mod star_colour;
mod star_temperature;
pub mod stars;
pub mod zodiacal;

pub use star_temperature::temperature_k;
