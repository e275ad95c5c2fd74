//! Light: its sources, how bodies reflect it, how bright they appear, and the exposure of the image.

// The choice of an image's exposure.
pub(crate) mod auto_exposure;
// Irradiance at the viewer from a body and its rings.
pub(crate) mod brightness;
// Ground brighter than the mean, for the light meter.
pub mod bright_ground;
// The part of a night map's light that a camera near the ground sees.
pub(crate) mod city_lights;
// The Sun's corona.
pub mod corona;
// The glare of small discs.
pub(crate) mod disc_glare;
// The light of a disc by phase angle, divided between ground and air.
pub mod disc_light;
// Light that globes of unequal axes reflect.
pub(crate) mod ellipsoid;
// The factor from radiance to display values.
pub mod exposure;
// The Sun's glare.
pub mod glare;
// Values on the grid of a map, for the light meter.
pub(crate) mod ground_grid;
// The lights that shine on a body: the Sun, and bodies that reflect sunlight.
pub(crate) mod lights;
// Visual magnitude of a body, eclipses included.
pub(crate) mod magnitude;
// The light meter of automatic exposure.
pub(crate) mod meter;
// The light of city lights at each point of the ground, for the light meter.
pub mod night_lights;
// Published phase laws of planets and the Moon.
pub(crate) mod phase_laws;
// Reflectance, geometric albedo and phase functions; bright and dark sides, magnitudes.
pub mod photometry;
// The decision on planet-shine.
pub(crate) mod planet_shine;
