//! The scene: everything that one frame shows, and for each effect the decision whether it is drawn, and why.
//!
//! In: the catalog, the ephemeris, a [`request::ViewRequest`], and the loaded [`Resources`]: shape models, city lights, scattering tables. Out: a [`Scene`]:
//! the camera, every body with its decisions, the draws from far to near, and the bodies drawn as points. All values are f64 until [`camera`] narrows them. No
//! module here depends on shaders or has global state.
//!
//! `build` calls the submodules in this order: `request`, `camera` (position of the viewer), `placed` (apparent position of each body), `light::meter`
//! (exposure), `features` with the modules of each effect (`surface`, `eclipse`, `rings`, `atmosphere`), light around the Sun (`light::corona`,
//! `light::glare`), `visibility` (what is hidden), `sky`, `visibility::order` (order of draws), `annotation`. `draw` defines the data that these
//! modules create for the renderer; `composite` combines several frames into one image, `seen_from` reports all bodies without an image, and
//! `observed` gives the quantities of an ephemeris.
//!
//! Modules and names with `doc(hidden)` are public only for tests and benches.

#[doc(hidden)]
pub mod annotation;
#[doc(hidden)]
pub mod atmosphere;
mod body_report;
mod build;
#[doc(hidden)]
pub mod camera;
#[doc(hidden)]
pub mod composite;
#[doc(hidden)]
pub mod constants;
mod decision;
#[doc(hidden)]
pub mod draw;
#[doc(hidden)]
pub mod eclipse;
mod error;
#[doc(hidden)]
mod features;
mod finished;
#[doc(hidden)]
pub mod light;
mod numeric;
mod observed;
mod placed;
mod point;
pub mod purpose;
pub mod request;
#[doc(hidden)]
pub mod resources;
#[doc(hidden)]
pub mod rings;
mod seen_from;
#[doc(hidden)]
pub mod sky;
#[doc(hidden)]
pub mod stated_errors;
#[doc(hidden)]
pub mod surface;
mod thresholds;
mod visibility;

#[doc(hidden)]
pub use annotation::{grids, legend, line_texts, orbit_arcs, orbits, sky_lines, traces};
pub(crate) use atmosphere::optical_depth_above_ground;
#[doc(hidden)]
pub use atmosphere::uniform_rows::uniform_value;
#[doc(hidden)]
pub use atmosphere::{multi_scatter_in_shadow, multi_scatter_table, quadrature_nodes};
pub use body_report::{Appearance, BodyReport, InventedData, SubPoint};
#[doc(hidden)]
pub use build::SceneBuilder;
#[doc(hidden)]
pub use camera::{silhouette, viewpoint};
#[doc(hidden)]
pub use eclipse::refracted_limb;
pub use error::{OutOfRange, RequestValue, SceneError};
pub use finished::Scene;
pub use light::exposure::{AUTO_EXPOSED_MEAN, AUTO_EXPOSED_SUN, CD_M2_PER_RADIANCE, DARKEST_EV, Exposure, darkest_white};
#[doc(hidden)]
pub use light::meter::{RELIEF_SLOPE_RMS, corrected_twilight_rows, metered_twilight};
#[doc(hidden)]
pub use light::{bright_ground, corona, disc_light, glare, night_lights, photometry};
#[doc(hidden)]
pub use observed::{Elongation, Observed, SkyOfEarth, small_body_magnitude};
#[doc(hidden)]
pub use point::{
    CORE_SIGMA_PX, GLARE_RADIUS_EXPONENT, GLARE_SCALE_RADIUS_PX, MAX_GLARE_FRACTION, MAX_RADIUS_PX, MIN_POINT_RADIUS_PX, disc_fraction,
    disc_glare_spread, point_peak, point_spread,
};
#[doc(hidden)]
pub use resources::{Caches, Requirements, Resources};
#[doc(hidden)]
pub use rings::ring_shine;
pub use seen_from::bodies_seen_from;
#[doc(hidden)]
pub use surface::overlays;

/// Names and markers of bodies, and the body, star, comet or minor planet under a click.
#[doc(hidden)]
pub mod labels {
    pub use super::annotation::data::Dot;
    pub use super::annotation::labels::*;
    #[cfg(feature = "view")]
    pub(crate) use super::annotation::line_texts::place_texts;
    pub use super::annotation::margin::Margin;
    pub use super::annotation::picking::{
        CLICK_RADIUS_PX, SkyObject, body_at, sight_of, small_body_at, small_body_px, snapped_px, star_at, star_px,
    };
    #[cfg(feature = "view")]
    pub(crate) use super::annotation::small_body_names::small_body_names;
    pub use super::annotation::text::{Bar, Rect, TextLine};
    pub use super::sky::small_body_sight::{SeenSmallBody, SmallBodySight};
}

/// The effects that can be switched, and the decisions about them.
pub mod effects {
    pub use super::decision::Decision;
    #[doc(hidden)]
    pub use super::features::choice::{BodyCapabilities, FeatureSelection};
    #[doc(hidden)]
    pub use super::features::possible::possible_features;
    pub use super::request::effects::{Effect, EffectOverrides};
    pub use super::thresholds::{MAX_LIGHTS, VISIBLE_CHANGE, VISIBLE_LIGHT};
}
