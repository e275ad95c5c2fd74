//! Eclipses: who stands before the Sun, by which model, with what uniforms, and the air of an occluder that bends light.

pub(crate) mod air;
pub(crate) mod before_sun;
pub(crate) mod decision;
pub mod occluders;
pub mod refracted_limb;
pub mod shade;
pub(crate) mod shadow_cone;
pub(crate) mod shadow_path;
pub mod uniforms;

pub use air::LAYERS as REFRACTING_LAYERS;
pub use occluders::{
    EclipseModelChoice, Occluder, OccluderSearch, Receiver, ReceiverExtent, candidates, find, limb_law, model, possible, select_occluders,
};
pub use shade::Shade;
pub use uniforms::uniforms_of_casters;
