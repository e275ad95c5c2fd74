//! Light: its sources, how bodies reflect it, how bright they appear, and the exposure of the image.

// Which exposure an image gets.
pub(crate) mod auto_exposure;
// Irradiance that a body with its rings causes at the viewer.
pub(crate) mod brightness;
// The Sun's corona.
pub mod corona;
// From radiance to display values.
pub mod exposure;
// The Sun's glare.
pub mod glare;
// The lights on a body: the Sun, and bodies that reflect sunlight.
pub(crate) mod lights;
// Visual magnitude of a body, eclipses included.
pub(crate) mod magnitude;
// The light meter of automatic exposure.
pub(crate) mod meter;
// City lights, for the light meter.
pub mod night_lights;
// Published phase laws of planets and the Moon.
pub(crate) mod phase_laws;
// Photometric models, integrated over the disc.
pub mod photometry;
// The decision on light that other bodies reflect onto a body.
pub(crate) mod planet_shine;
