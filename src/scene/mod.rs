//! What one frame needs, and why.
//!
//! In: the catalog, the ephemeris and a [`request::ViewRequest`]. Out: a [`Scene`]: the camera, every body with its decisions, the
//! draws far to near and the points. Everything is f64 until [`camera`] narrows it. Nothing here knows of shaders or keeps state.
//!
//! A frame passes the rooms in this order: `request`, `camera` (where the viewer stands), `placed` (where each body is seen), `light` (exposure), `features`
//! with the rooms of each effect (`surface`, `light`, `eclipse`, `rings`, `atmosphere`), `visibility` (order), `sky`, `annotation`.

pub mod annotation;
pub mod atmosphere;
mod build;
pub mod camera;
pub mod constants;
mod decision;
pub mod draw;
pub mod eclipse;
mod error;
mod features;
mod finished;
mod in_view;
pub mod light;
mod numeric;
mod placed;
mod point;
pub mod purpose;
pub mod request;
pub mod resources;
pub mod rings;
pub mod sky;
pub mod surface;
mod thresholds;
pub mod tiers;
mod visibility;

pub use annotation::{legend, orbits};
pub use atmosphere::{air_nodes, air_spread, air_table};
pub use build::SceneBuilder;
pub use camera::{silhouette, viewpoint};
pub use eclipse::refracted_limb;
pub use error::SceneError;
pub use finished::Scene;
pub use in_view::{Appearance, BodyInView, SubPoint};
pub use light::exposure::{AUTO_EXPOSED_MEAN, AUTO_EXPOSED_SUN, CANDELAS_PER_RADIANCE, DARKEST_EV, Exposure, darkest_white};
pub use light::{corona, glow, lamps, photometry};
pub use point::{CORE_SIGMA_PX, GLARE_WIDTH_PX, disc_share, point_spread};
pub use resources::{Caches, Requirements, Resources};
pub use rings::ring_shine;
pub use surface::overlays;

/// Names and markers of bodies, and which of them a click means.
pub mod marks {
    pub use super::annotation::labels::*;
    pub use super::annotation::picking::{REACH_PX, hit};
}

/// The features that can be switched, and what is decided about them.
pub mod effects {
    pub use super::decision::Decision;
    pub use super::features::choice::{Capabilities, FeatureSelection, flattening};
    pub use super::features::possible::possible_features;
    pub use super::request::effects::{Effect, EffectOverrides};
    pub use super::thresholds::{MAX_LIGHTS, VISIBLE_CHANGE};
}
