//! The light of a body's disc by phase angle, divided between its ground and its air.
//!
//! In: a body, and a phase angle `alpha` in radians, 0..=pi. Out: the factor on the drawn ground, and the light of the point that stands for a distant body.
//! Always: ground and air together have the light of the published law, up to the law's limit (its greatest phase angle); a body is equally bright drawn as a
//! disc and as a point, with all effects on (tests/scene/points_like_discs.rs). Exceptions: the ground keeps `MIN_GROUND_PART` of the law where the drawn air
//! would leave it less; and the Earth. Its drawn ground and clouds have 0.36 of the published geometric albedo. So its disc has 0.37 of the light of its point
//! at small phase angles, and all of it only at large ones, where air and glint give the light (docs/accuracy.md).
//!
//! The air's light has two forms. Where gas without haze is opaque along the limb, the rim is drawn in the ground's colour, with light proportional to the
//! ground's: the rim *continues the ground* (Venus, the giant planets: `rim::continued_light`). Haze and dust have the light of the catalog's `forward_light`
//! (Mars, Titan, Pluto); the Earth's `forward_light` is that of its air and of the Sun's glint on the sea. Without a published law the photometric model gives
//! the ground's light alone, and the light of the air is added to it.

use crate::catalog::{Body, NaifId, Photometry};
use crate::scene::atmosphere::rim;
use crate::scene::light::phase_laws::{self, PhaseLaw};
use crate::scene::light::photometry::{measured_side_curve, model_geometric_albedo, model_phase, sun_disc_radiance};
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::units::{KM_PER_AU, luminance};
use glam::DVec3;

/// Smallest part of the published law that is left to the ground. Mars needs it near the law's limit, where its dust alone has most of the law's light; the
/// Earth needs it from 146 to 168 degrees. At these angles the drawn bodies are brighter than the law (docs/accuracy.md).
const MIN_GROUND_PART: f64 = 0.25;

/// Factor on the Sun's glint on the sea of a distant disc with clouds: an estimate. Clouds cover 0.72 of the seas (King et al. 2013, IEEE Transactions on
/// Geoscience and Remote Sensing 51, 3826). On a crescent the light of the glint passes the level of the clouds at two places far apart; the probability that
/// both are free of clouds is 0.28^2 = 0.08. The drawn clouds, which are fewer and opaque, let 0.65 of the light pass. The quotient is 0.12, and thin clouds
/// let some light through. Without the factor the Earth at 160 degrees had 2.4 times the light of the published law.
const GLINT_PAST_CLOUDS: f64 = 0.15;
/// Phase angles between which [`GLINT_PAST_CLOUDS`] sets in: at the first the two crossings of clouds 3 km high are 3 km apart, at the second 14 km. Chosen,
/// not measured.
const GLINT_FADE_RAD: (f64, f64) = (1.0, 2.35);

/// Light of haze or dust, or of the Earth's air and glint, at a phase angle: mean radiance of the disc under irradiance 1, linear RGB, from the catalog's
/// table.
fn forward_light(body: &Body, alpha: f64) -> DVec3 {
    let rows = body.atmosphere.as_ref().map_or(&[][..], |air| air.forward_light.as_slice());
    let alpha_deg = alpha.to_degrees();
    let next = rows.partition_point(|[phase_deg, ..]| *phase_deg <= alpha_deg);
    let rgb = |[_, rgb @ ..]: [f64; 4]| DVec3::from_array(rgb);
    match (next.checked_sub(1).and_then(|last| rows.get(last)), rows.get(next)) {
        (Some(from), Some(to)) => rgb(*from).lerp(rgb(*to), (alpha_deg - from[0]) / (to[0] - from[0])),
        (Some(row), None) | (None, Some(row)) => rgb(*row),
        (None, None) => DVec3::ZERO,
    }
}

/// Fraction of the published law's light that is left for the ground, and for a rim that continues it, after subtracting [`forward_light`]; at least
/// [`MIN_GROUND_PART`]. `alpha`: up to the law's limit.
fn fraction_left_by_forward_light(body: &Body, law: &PhaseLaw, alpha: f64) -> f64 {
    let forward = luminance(forward_light(body, alpha).to_array());
    (1.0 - forward / (body.geometric_albedo * law.brightness(alpha.to_degrees())).max(1e-12)).max(MIN_GROUND_PART)
}

/// Light of a rim that continues the ground, at a phase angle of 90 degrees, as a term that is added to [`model_phase`], which is the ground's light (1 at full
/// phase). At other phase angles the rim's light is proportional to their sine. The function sums over heights, so callers call it once.
fn rim_of_model(body: &Body) -> f64 {
    // All channels of the model's albedo are equal, since the body is not emissive.
    rim::continued_light(body) / model_geometric_albedo(&body.photometry)[0].max(1e-12)
}

/// Factor on the photometric model that gives ground and air together the published law; beyond the law's limit, the factor at the limit; 1 without a law.
/// As if every viewer saw the side that was measured. `rim`: from [`rim_of_model`].
fn model_factor(body: &Body, rim: f64, alpha: f64) -> f64 {
    let Some(law) = phase_laws::law(body.id) else { return 1.0 };
    let alpha = alpha.min(law.limit_deg.to_radians());
    let published = law.brightness(alpha.to_degrees()) * fraction_left_by_forward_light(body, law, alpha);
    published / (model_phase(&body.photometry, alpha) + rim * alpha.sin().max(0.0)).max(1e-12)
}

/// Phase function of the ground together with a rim that continues it, as if every viewer saw the side that was measured. `compute_rim`: computes
/// [`rim_of_model`].
fn phase_of_ground_and_rim(body: &Body, compute_rim: impl FnOnce() -> f64, alpha: f64) -> f64 {
    // Within the law's limit the model and the rim need not be computed.
    match phase_laws::law(body.id).filter(|law| alpha <= law.limit_deg.to_radians()) {
        Some(law) => law.brightness(alpha.to_degrees()) * fraction_left_by_forward_light(body, law, alpha),
        None => {
            let rim = compute_rim();
            model_factor(body, rim, alpha) * (model_phase(&body.photometry, alpha) + rim * alpha.sin().max(0.0))
        }
    }
}

/// The rim's part of the light of ground and rim together. `rim`: from [`rim_of_model`].
fn rim_part(body: &Body, rim: f64, alpha: f64) -> f64 {
    let rim = rim * alpha.sin().max(0.0);
    if rim > 0.0 { rim / (rim + model_phase(&body.photometry, alpha)) } else { 0.0 }
}

/// Distances of the viewer, in radii of the body, between which [`phase_correction`] sets in. Chosen, not derived: within the first a viewer sees a landscape
/// whose phase angle varies from point to point, beyond the second the entire disc at nearly one phase angle.
const PHASE_CORRECTION_RADII: [f64; 2] = [4.0, 20.0];

/// How much the phase correction applies at a distance: from 0 to 1.
fn correction_weight(distance_radii: f64) -> f64 {
    let [from, to] = PHASE_CORRECTION_RADII;
    smoothstep((distance_radii / from).ln() / (to / from).ln())
}

/// Factor by which the drawn radiance of the ground, and of the rim that continues it, is multiplied so that the disc's total brightness follows the published
/// phase law. It applies in full beyond the second of `PHASE_CORRECTION_RADII`, is 1 within the first, and changes smoothly with the logarithm of the distance
/// in between.
pub fn phase_correction(body: &Body, alpha: f64, distance_radii: f64) -> f64 {
    let weight = correction_weight(distance_radii);
    if weight <= 0.0 || matches!(body.photometry, Photometry::Emissive { .. }) {
        return 1.0;
    }
    // The law contains the light curve of the side that was measured; the map draws it again.
    (model_factor(body, rim_of_model(body), alpha) / measured_side_curve(body, alpha)).powf(weight)
}

/// Factor on the glint of the sea of a body whose clouds are drawn: [`GLINT_PAST_CLOUDS`] for a distant viewer of a crescent. It is 1 for a near viewer, who
/// sees the gaps between clouds, and at small phase angles, where the light passes the same gap twice. With the distance it changes like
/// [`phase_correction`].
pub(crate) fn glint_factor(body: &Body, alpha: f64, distance_radii: f64) -> f64 {
    let weight = if body.clouds.is_some() { correction_weight(distance_radii) * smooth_rise(GLINT_FADE_RAD, alpha) } else { 0.0 };
    GLINT_PAST_CLOUDS.powf(weight)
}

/// Factor, at least 1, by which the light meter brightens sunlit ground if the air is drawn: it stands for the light of haze and dust in front of the ground,
/// which the meter does not compute. Without that light [`phase_correction`] would be greater by this factor.
pub(crate) fn meter_gain_for_haze(body: &Body, alpha: f64, distance_radii: f64) -> f64 {
    let Some(law) = phase_laws::law(body.id) else { return 1.0 };
    fraction_left_by_forward_light(body, law, alpha.min(law.limit_deg.to_radians())).powf(-correction_weight(distance_radii))
}

/// A bound of the green mean radiance of a disc under irradiance 1 at every phase angle; infinite for a body that shines by itself.
pub(crate) fn max_mean_radiance(body: &Body) -> f64 {
    if is_emissive(body) {
        return f64::INFINITY;
    }
    let rows = body.atmosphere.as_ref().map_or(&[][..], |air| air.forward_light.as_slice());
    // No phase function exceeds 2 (test below).
    2.0 * f64::from(body.colour.y) * body.geometric_albedo + rows.iter().map(|[_, _, green, _]| *green).fold(0.0, f64::max)
}

/// Solid angle of the body's disc divided by pi, times the Sun's irradiance on the body: the factor from the disc's mean radiance under irradiance 1 to the
/// irradiance at the viewer.
pub(crate) fn irradiance_per_mean_radiance(sun_distance_km: f64, viewer_distance_km: f64, radius_sq_km2: f64) -> f64 {
    radius_sq_km2 * (KM_PER_AU / (viewer_distance_km * sun_distance_km)).powi(2)
}

fn is_emissive(body: &Body) -> bool {
    body.id == NaifId::SUN || matches!(body.photometry, Photometry::Emissive { .. })
}

/// Irradiance of a body that shines by itself; `None` for others.
fn emitted_irradiance(body: &Body, viewer_distance_km: f64, radius_sq_km2: f64) -> Option<f64> {
    is_emissive(body).then(|| sun_disc_radiance() * radius_sq_km2 / (viewer_distance_km * viewer_distance_km))
}

/// Irradiance that the body's ground causes at a viewer, in units of the Sun's at 1 au, without the body's colour and without the factor of bright and dark
/// sides (the caller multiplies by `photometry::light_curve`); and the irradiance by the light that its air adds, linear RGB.
///
/// `sun_distance_km`, `viewer_distance_km`: distances of the body from the Sun and from the viewer; `radius_sq_km2`: squared radius of a circle with the area
/// of the body's outline.
pub fn ground_and_air_irradiance(
    body: &Body,
    alpha: f64,
    sun_distance_km: f64,
    viewer_distance_km: f64,
    radius_sq_km2: f64,
) -> (f64, DVec3) {
    if let Some(emitted) = emitted_irradiance(body, viewer_distance_km, radius_sq_km2) {
        return (emitted, DVec3::ZERO);
    }
    let rim = rim_of_model(body);
    let (phase, rim_part) = (phase_of_ground_and_rim(body, || rim, alpha), rim_part(body, rim, alpha));
    let irradiance_per_mean_radiance = irradiance_per_mean_radiance(sun_distance_km, viewer_distance_km, radius_sq_km2);
    // The law contains the light curve of the side that was measured, and the caller multiplies by the light curve.
    let ground = body.geometric_albedo * phase * (1.0 - rim_part) / measured_side_curve(body, alpha);
    let air = body.colour.as_dvec3() * (body.geometric_albedo * phase * rim_part) + forward_light(body, alpha);
    (ground * irradiance_per_mean_radiance, air * irradiance_per_mean_radiance)
}

/// Irradiance by ground and air, linear RGB; for a body with bright and dark sides as if every viewer saw the side that was measured.
/// Parameters as for [`ground_and_air_irradiance`].
pub(crate) fn irradiance_of_measured_side(
    body: &Body,
    alpha: f64,
    sun_distance_km: f64,
    viewer_distance_km: f64,
    radius_sq_km2: f64,
) -> DVec3 {
    let colour = body.colour.as_dvec3();
    if let Some(emitted) = emitted_irradiance(body, viewer_distance_km, radius_sq_km2) {
        return colour * emitted;
    }
    let mean_radiance =
        colour * (body.geometric_albedo * phase_of_ground_and_rim(body, || rim_of_model(body), alpha)) + forward_light(body, alpha);
    mean_radiance * irradiance_per_mean_radiance(sun_distance_km, viewer_distance_km, radius_sq_km2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    #[test]
    fn no_disc_exceeds_the_bound_of_its_radiance() {
        let mut nearest_to_bound = 0.0_f64;
        for body in Catalog::embedded().bodies().iter().filter(|body| body.id != NaifId::SUN) {
            for k in 0..=720 {
                let alpha = f64::from(k) * std::f64::consts::PI / 720.0;
                // With this size and distance the irradiance is the mean radiance.
                let (viewer_distance_km, radius_sq_km2) = (1.0, 1.0);
                let mean_radiance = irradiance_of_measured_side(body, alpha, KM_PER_AU, viewer_distance_km, radius_sq_km2).y;
                let ratio = mean_radiance / max_mean_radiance(body);
                assert!(ratio <= 1.0, "{} at {} degrees: {ratio} of the bound", body.name, alpha.to_degrees());
                nearest_to_bound = nearest_to_bound.max(ratio);
            }
        }
        assert!(nearest_to_bound > 0.3, "a much too high bound: {nearest_to_bound}");
    }
}
