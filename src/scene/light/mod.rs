//! Light: its sources, its reflection by bodies, their apparent brightness, and the exposure of the image.

pub(crate) mod auto_exposure;
pub(crate) mod brightness;
pub mod corona;
pub mod exposure;
pub mod glare;
pub(crate) mod lights;
pub(crate) mod magnitude;
pub(crate) mod meter;
pub mod night_lights;
pub(crate) mod phase_laws;
pub mod photometry;
pub(crate) mod planet_shine;
