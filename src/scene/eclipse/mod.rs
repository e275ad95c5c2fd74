//! Eclipses: the bodies that hide the Sun from a receiver (occluders), the models and uniforms of their shadows, the shadows' cones and paths on the ground,
//! and refraction in an occluder's atmosphere.
//!
//! In: placed bodies, the ephemeris and the request's eclipse settings. Out: decisions, uniforms of shaders/lib/eclipse, lines on the ground, and fractions of
//! sunlight. Not here: the light of each pixel, which the shaders compute, and dates of eclipses (`events`).

pub mod approximate_shadow;
pub(crate) mod decision;
pub(crate) mod model;
pub mod occluders;
pub mod refracted_limb;
pub(crate) mod refraction;
pub(crate) mod shadow_cone;
pub(crate) mod shadow_path;
pub mod shadow_region;
pub(crate) mod sun_occluders;
pub mod uniforms;
pub(crate) mod visible_part;

pub use model::{EclipseModelChoice, choose_eclipse_model, max_occluders};
pub use occluders::{FoundOccluders, Occluder, Receiver, ReceiverExtent, candidates, limb_darkening, select_occluders};
pub use refraction::LAYERS as REFRACTING_LAYERS;
pub use shadow_region::ReceiverShape;
pub(crate) use uniforms::uniforms_of_occluders;
