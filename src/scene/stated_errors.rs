//! The error of each model of each effect, which `explain` prints and tests verify.
//!
//! In: a model, one of the features of a draw. Out: [`StatedError`]. Always: where the error is a fraction of light, a test reads it from here as its
//! tolerance. Where it is a fraction of a pixel, the model is chosen only if its shadow's edges are off by at most that fraction. For `point-sun` the
//! penumbra's width decides, for `sphere` also the flattening ([`sphere_shadow_offset`], which a test verifies). Not here: which model a draw gets (air,
//! eclipse, rings) and what it costs (`bench --effects`, docs/measurements.md).

use crate::message::{Reason, message, reason};
use crate::scene::draw::{AtmosphereModel, BodyShadow, EclipseModel, RingShadow};
use std::fmt;

/// A model, a way of computing an effect, with its error.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct StatedError {
    /// The model's name.
    pub name: &'static str,
    /// Error that 95 % of samples do not exceed; `None` if only the largest error is stated.
    #[serde(rename = "mostly", skip_serializing_if = "Option::is_none")]
    pub error_95_percent: Option<f64>,
    /// Largest error, as a fraction of the `quantity`.
    #[serde(rename = "at_most")]
    pub max_error: f64,
    /// The quantity that the error is relative to.
    #[serde(rename = "of")]
    pub quantity: Quantity,
}

impl StatedError {
    /// The model with its error.
    pub(crate) fn reason(&self) -> Reason {
        // Rounds to 1e-4 %, so that no binary digits show (100 * 0.07 = 7.000000000000001).
        let percent = |fraction: f64| (fraction * 1e6).round() / 1e4;
        let (model, max, quantity) = (self.name, percent(self.max_error), message!(self.quantity.0));
        match self.error_95_percent {
            Some(error) => reason!("model-error-mostly", model = model, max = max, mostly = percent(error), of = quantity),
            None => reason!("model-error", model = model, max = max, of = quantity),
        }
    }
}

impl fmt::Display for StatedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.reason().fmt(f)
    }
}

/// A quantity that an error is relative to: the id of the message that names it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity(pub(crate) &'static str);

impl serde::Serialize for Quantity {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        message!(self.0).serialize(to)
    }
}

const SUNLIGHT: Quantity = Quantity("quantity-sunlight");
/// A pixel, for errors in the position of a shadow's edges.
const EDGES: Quantity = Quantity("quantity-edges");

/// A ray's light scattered once, relative to which the errors of the atmosphere's models are stated. tests/atmosphere/model_bounds.rs measures the errors per
/// channel against adaptive quadrature, on new random rays in each run, for every atmosphere of the catalog. Each stated bound is at least a fifth above the
/// largest error found on 51,000 rays of 73 runs. The largest errors were 0.97 (`vertex`), 0.67 (`pixel-8`), 0.075 (`pixel-16`, `table`) and 0.0075
/// (`pixel-32`). With `pixel-8`, only one of the 73 runs had a ray with an error above 0.5, in the twilight of Uranus.
const SINGLE_SCATTERING: Quantity = Quantity("quantity-ray");
/// If the light of a ray is less than this fraction of the zenith's light (brightest channel, Sun at 45 degrees), its error is stated relative to this
/// fraction of the zenith's light.
pub const MIN_OF_ZENITH: f64 = 1e-3;
/// Largest error of the transmittance along any ray, in every model.
pub const AIR_TRANSMITTANCE: f64 = 3e-4;

/// The error of an atmosphere model; `None` without an atmosphere.
pub fn of_atmosphere(model: AtmosphereModel) -> Option<StatedError> {
    let stated = |name, error_95_percent, max_error, quantity| {
        Some(StatedError { name, error_95_percent: Some(error_95_percent), max_error, quantity })
    };
    match model {
        AtmosphereModel::None => None,
        AtmosphereModel::Vertex => stated("vertex", 0.1, 1.2, SINGLE_SCATTERING),
        AtmosphereModel::Pixel8 => stated("pixel-8", 0.025, 0.9, SINGLE_SCATTERING),
        AtmosphereModel::Pixel16 => stated("pixel-16", 0.004, 0.12, SINGLE_SCATTERING),
        AtmosphereModel::Pixel32 => stated("pixel-32", 0.002, 0.02, SINGLE_SCATTERING),
        // The error of multiple scattering is measured against a photon simulation.
        AtmosphereModel::Table => stated("table", 0.004, 0.12, Quantity("quantity-ray-and-sky")),
    }
}

/// The error of an eclipse model; `None` without an eclipse. `limb-darkened` is compared with integrals computed to forty digits, the simpler models with
/// `limb-darkened` (tests/eclipse/reference_tables.rs). The bounds hold for occluders whose outline has a ratio of axes of at least 0.7; behind flatter ones
/// the error of `limb-darkened` is up to ten times as large (tests/eclipse/umbra.rs).
pub fn of_eclipse(model: EclipseModel) -> Option<StatedError> {
    let stated = |name, max_error, quantity| Some(StatedError { name, error_95_percent: None, max_error, quantity });
    match model {
        EclipseModel::None => None,
        EclipseModel::Linear => stated("linear", 0.14, Quantity("quantity-behind-round-body")),
        EclipseModel::UniformDisc => stated("uniform-disc", 0.1, SUNLIGHT),
        EclipseModel::LimbDarkened => stated("limb-darkened", 5e-4, SUNLIGHT),
        EclipseModel::Refracted => stated("refracted", 5e-4, Quantity("quantity-sunlight-and-umbra")),
    }
}

/// The error of a ring's shadow on a globe; `None` without a shadow. The shadow of a body's own rings is compared with the closed form and with sums over the
/// Sun's disc (tests/rings/reference_tables.rs); the simpler model is chosen if its edges are off by at most `MAX_EDGE_ERROR_PX`. The shadow of another body's
/// rings is compared with sums over the Sun's disc (`rings::shadow_grid`).
pub fn of_ring_shadow(model: RingShadow) -> Option<StatedError> {
    let stated = |name, max_error, quantity| Some(StatedError { name, error_95_percent: None, max_error, quantity });
    match model {
        RingShadow::None => None,
        RingShadow::PointSun => stated("point-sun", MAX_EDGE_ERROR_PX, EDGES),
        RingShadow::Penumbra => stated("penumbra", 0.07, SUNLIGHT),
        RingShadow::OfPlanet => stated("grid", 0.03, SUNLIGHT),
    }
}

/// The error of the globe's shadow on a ring; `None` without a shadow. The shadow is compared as in [`of_ring_shadow`].
pub fn of_body_shadow(model: BodyShadow) -> Option<StatedError> {
    let stated = |name, max_error, quantity| Some(StatedError { name, error_95_percent: None, max_error, quantity });
    match model {
        BodyShadow::None => None,
        BodyShadow::Sphere => stated("sphere", MAX_EDGE_ERROR_PX, EDGES),
        BodyShadow::EllipsoidPenumbra => stated("ellipsoid-penumbra", 1e-3, SUNLIGHT),
    }
}

/// Upper limit of the distance between the edges of two shadows on the ring: a sphere's shadow and the globe's. Lengths are in equatorial radii.
/// `polar_radius`: of the globe; `sin_elevation`: sine of the Sun's elevation above the ring's plane; `outer_radius`: of the ring.
///
/// In the ring's plane both shadows are half-ellipses around the centre. Both are as wide as the equator. They reach out to 1 / `sin_elevation` (the sphere's)
/// and q / `sin_elevation` (the globe's). Here q is half the height of the globe's outline as seen from the Sun: below 1 for an oblate globe and above 1 for a
/// prolate one. In each direction the ratio of the two radii lies between q and 1. The edges are therefore apart by at most |1 - q| times the distance from the
/// centre to the farther edge. This distance is limited by the ring's outer radius and by the longer shadow's tip. If both shadows extend beyond the ring's
/// outer edge, the difference of their half widths at that edge is a second limit. Measured by tests/rings/reference_tables.rs for oblate globes.
pub fn sphere_shadow_offset(polar_radius: f64, sin_elevation: f64, outer_radius: f64) -> f64 {
    // Half the height of an ellipsoid's outline, seen from this elevation.
    let q = (polar_radius * polar_radius * (1.0 - sin_elevation * sin_elevation) + sin_elevation * sin_elevation).sqrt();
    let half_width = |tip: f64| (1.0 - outer_radius * outer_radius / (tip * tip)).sqrt();
    let (sphere_tip, globe_tip) = (1.0 / sin_elevation.abs().max(1e-9), q / sin_elevation.abs().max(1e-9));
    let radial_limit = (1.0 - q).abs() * outer_radius.min(sphere_tip.max(globe_tip));
    if outer_radius < sphere_tip.min(globe_tip) {
        radial_limit.min((half_width(sphere_tip) - half_width(globe_tip)).abs())
    } else {
        radial_limit
    }
}

/// Error or softness of a shadow's edges, in pixels, above which the more accurate model is chosen.
pub(crate) const MAX_EDGE_ERROR_PX: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::effects::Effect;

    /// A prolate globe's shadow is longer than that of a sphere, and wider at the same distance from the centre.
    #[test]
    fn a_prolate_globe_has_an_offset_too() {
        // Here q = sqrt(1.2^2 * 0.75 + 0.25) = 1.153. At radius 1.9 the half widths are 0.312 (sphere, tip at 2) and 0.567 (globe, tip at 2.307).
        let offset_at_edge = sphere_shadow_offset(1.2, 0.5, 1.9);
        assert!((offset_at_edge - 0.255).abs() < 1e-3, "{offset_at_edge}");
        // A wide ring contains both tips. They are 0.307 apart; the limit is (q - 1) * 2.307 = 0.354.
        let offset_at_tip = sphere_shadow_offset(1.2, 0.5, 10.0);
        assert!((0.3065..0.4).contains(&offset_at_tip), "{offset_at_tip}");
        assert_eq!(sphere_shadow_offset(1.0, 0.5, 10.0), 0.0);
    }

    #[test]
    fn a_costlier_model_is_more_accurate_and_every_model_is_listed() {
        let air: Vec<StatedError> = AtmosphereModel::ALL.into_iter().filter_map(of_atmosphere).collect();
        assert_eq!(air.len(), AtmosphereModel::ALL.len() - 1);
        // The first four: `table` has the errors of `pixel-16`.
        assert!(air[..4].windows(2).all(|w| w[1].max_error < w[0].max_error && w[1].error_95_percent < w[0].error_95_percent));
        let eclipse: Vec<StatedError> = EclipseModel::ALL.into_iter().filter_map(of_eclipse).collect();
        assert!(eclipse.len() == EclipseModel::ALL.len() - 1 && eclipse.windows(2).all(|w| w[1].max_error <= w[0].max_error));
        let names: Vec<_> = air.iter().chain(&eclipse).map(|e| e.name).collect();
        assert_eq!(names, [Effect::Atmosphere.models(), Effect::Eclipse.models()].concat());
        assert_eq!(air[2].to_string(), "pixel-16: error at most 12 %, mostly below 0.4 %, of each ray's light scattered once");
    }
}
