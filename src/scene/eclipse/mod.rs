//! Eclipses: who stands before the Sun, by which model, with what uniforms, and the air of a caster that bends light.

pub(crate) mod air;
pub(crate) mod before_sun;
pub(crate) mod decision;
pub mod occluders;
pub mod refracted_limb;
pub mod shade;
pub mod uniforms;

pub use air::LAYERS as AIR_LAYERS;
pub use occluders::{Caster, Extent, Found, Receiver, Wanted, candidates, find, find_among, limb_law, model, possible};
pub use shade::Shade;
pub use uniforms::amounts_of;
