//! Photometry: reflectance and geometric albedo of each photometric model; phase functions of models and bodies; rotational light curves; magnitudes.
//!
//! In: a photometric model or a body of the catalog, angles and directions. Out: these quantities.
//!
//! Units: a white Lambert plane facing a unit irradiance has radiance 1 (no factor pi), and irradiance 1 is the Sun's at 1 au. A body of geometric albedo p
//! at full phase then has the mean radiance p times its irradiance. `alpha` is the phase angle in radians, 0..=pi.

use crate::catalog::{Body, Map, Photometry};
use crate::scene::light::phase_laws;
pub use crate::scene::light::phase_laws::slope_parameter_law;
use crate::units::{KM_PER_AU, SUN_RADIUS_KM};
use glam::DVec3;
use std::f64::consts::PI;

/// Visual magnitude of the Sun at 1 au, Vega system (Willmer 2018, ApJS 236, 47, table 3: Johnson V).
pub(crate) const SUN_V_MAGNITUDE_AT_1_AU: f64 = -26.76;

/// Geometric albedo of a photometric model per channel, for an albedo map of value 1; for an emissive body the mean of its limb darkening over the disc.
///
/// mu0 and mu are the cosines of incidence and emission. At zero phase mu0 = mu, and the disc average has the weight 2 mu dmu. The averages: Lambert 2/3;
/// Lommel-Seeliger (normalised as 2 mu0/(mu + mu0)) 1; McEwen's lunar-Lambert the weighted mean of these two; Oren-Nayar 2a/3 + b/2, with its coefficients a
/// and b.
pub fn model_geometric_albedo(model: &Photometry) -> [f64; 3] {
    match *model {
        Photometry::Emissive { u1, u2 } => [0, 1, 2].map(|k| 1.0 - u1[k] / 3.0 - u2[k] / 6.0),
        Photometry::Lambert => [2.0 / 3.0; 3],
        Photometry::LommelSeeliger => [1.0; 3],
        Photometry::LunarLambert { lunar_weight } => [lunar_weight + (1.0 - lunar_weight) * 2.0 / 3.0; 3],
        Photometry::OrenNayar { roughness_deg } => {
            let (a, b) = oren_nayar_a_b(roughness_deg);
            [2.0 * a / 3.0 + b / 2.0; 3]
        }
    }
}

/// The coefficients A and B of Oren and Nayar 1994 (SIGGRAPH, eq. 30), from the roughness in degrees.
fn oren_nayar_a_b(roughness_deg: f64) -> (f64, f64) {
    let sigma_sq = roughness_deg.to_radians().powi(2);
    (1.0 - 0.5 * sigma_sq / (sigma_sq + 0.33), 0.45 * sigma_sq / (sigma_sq + 0.09))
}

/// Radiance of a facet under unit irradiance, for an albedo map of value 1, as in the files of shaders/lib/photometry/. The radiance is 0 if the Sun or the
/// viewer is below the facet's horizon, and always 1 for an emissive body.
pub fn reflectance(model: &Photometry, cos_incidence: f64, cos_emission: f64, cos_phase: f64) -> f64 {
    let (mu0, mu) = (cos_incidence, cos_emission);
    if mu0 <= 0.0 || mu <= 0.0 {
        return if matches!(model, Photometry::Emissive { .. }) { 1.0 } else { 0.0 };
    }
    let lommel_seeliger = 2.0 * mu0 / (mu0 + mu);
    match *model {
        Photometry::Emissive { .. } => 1.0,
        Photometry::Lambert => mu0,
        Photometry::LommelSeeliger => lommel_seeliger,
        Photometry::LunarLambert { lunar_weight } => lunar_weight * lommel_seeliger + (1.0 - lunar_weight) * mu0,
        Photometry::OrenNayar { roughness_deg } => {
            let (a, b) = oren_nayar_a_b(roughness_deg);
            // sin(greater angle) tan(lesser angle) times the cosine of the azimuth difference, written with the phase angle.
            mu0 * (a + b * (cos_phase - mu0 * mu).max(0.0) / mu0.max(mu))
        }
    }
}

/// Phase function of a Lambert sphere, 1 at zero phase (Russell 1916).
pub(crate) fn lambert_phase(alpha: f64) -> f64 {
    (alpha.sin() + (PI - alpha) * alpha.cos()) / PI
}

/// Phase function of a Lommel-Seeliger sphere, 1 at zero phase (Lester, McCall and Tatum 1979).
fn lommel_seeliger_phase(alpha: f64) -> f64 {
    // At both ends the product below is 0 times infinity.
    if alpha < 1e-9 {
        return 1.0;
    }
    if alpha > PI - 1e-9 {
        return 0.0;
    }
    1.0 + (alpha / 2.0).sin() * (alpha / 2.0).tan() * (alpha / 4.0).tan().ln()
}

/// Phase function of an Oren-Nayar sphere, 1 at zero phase, integrated by the midpoint rule over photometric longitude (along the great circle through the
/// Sun's and the viewer's direction) and latitude: 96 x 48 points; four times as many change it by less than 1e-3.
fn oren_nayar_phase(roughness_deg: f64, alpha: f64) -> f64 {
    let (a, b) = oren_nayar_a_b(roughness_deg);
    let model = Photometry::OrenNayar { roughness_deg };
    let (nlon, nlat) = (96, 48);
    // The lit and visible part has photometric longitudes from alpha - 90 to 90 degrees. The viewer is at longitude 0, the Sun at alpha.
    let (from, to) = (alpha - PI / 2.0, PI / 2.0);
    // Those of the southern hemisphere: the northern one reflects the same.
    let cos_latitudes: Vec<f64> = (0..nlat / 2).map(|j| (PI * ((f64::from(j) + 0.5) / f64::from(nlat) - 0.5)).cos()).collect();
    let mut sum = 0.0;
    for i in 0..nlon {
        let lon = from + (to - from) * (f64::from(i) + 0.5) / f64::from(nlon);
        let (cos_sun, cos_viewer) = ((lon - alpha).cos(), lon.cos());
        for cos_latitude in &cos_latitudes {
            let (mu0, mu) = (cos_latitude * cos_sun, cos_latitude * cos_viewer);
            sum += 2.0 * reflectance(&model, mu0, mu, alpha.cos()) * mu * cos_latitude;
        }
    }
    let integral = sum * (to - from) / f64::from(nlon) * PI / f64::from(nlat);
    // Relative to zero phase: the mean over the disc divided by the geometric albedo.
    integral / PI / (2.0 * a / 3.0 + b / 2.0)
}

/// Phase function of the model: brightness at phase angle `alpha` relative to zero phase.
pub fn model_phase(model: &Photometry, alpha: f64) -> f64 {
    let value = match *model {
        Photometry::Emissive { .. } => 1.0,
        Photometry::Lambert => lambert_phase(alpha),
        Photometry::LommelSeeliger => lommel_seeliger_phase(alpha),
        Photometry::LunarLambert { lunar_weight } => {
            let lambert = (1.0 - lunar_weight) * 2.0 / 3.0;
            (lunar_weight * lommel_seeliger_phase(alpha) + lambert * lambert_phase(alpha)) / (lunar_weight + lambert)
        }
        Photometry::OrenNayar { roughness_deg } => oren_nayar_phase(roughness_deg, alpha),
    };
    // Rounding makes some of these slightly negative near 180 degrees.
    value.max(0.0)
}

/// Phase function of the body: the published law if there is one, else the model's phase function. Beyond the largest phase angle to which it was fitted,
/// the published law is continued in proportion to the model's phase function. The law is the light of ground and air together; `disc_light` divides it
/// between the two.
pub(crate) fn phase(body: &Body, alpha: f64) -> f64 {
    let Some(law) = phase_laws::law(body.id) else { return model_phase(&body.photometry, alpha) };
    let limit_rad = law.limit_deg.to_radians();
    if alpha <= limit_rad {
        law.brightness(alpha.to_degrees())
    } else {
        law.brightness(law.limit_deg) * model_phase(&body.photometry, alpha) / model_phase(&body.photometry, limit_rad).max(1e-12)
    }
}

/// Factor on the albedo map, or on the colour of a body without a map: the inverse of the model's geometric albedo. With it, a map whose mean is the catalog's
/// geometric albedo gives a disc of this geometric albedo.
pub(crate) fn albedo_normalisation(body: &Body) -> DVec3 {
    1.0 / DVec3::from_array(model_geometric_albedo(&body.photometry))
}

/// Albedo of the ground in a direction from the body's centre, body axes, relative to the published one, as far as the harmonics of its map give it.
pub(crate) fn relative_albedo(map: &Map, direction: DVec3) -> f64 {
    let [degree_1, degree_2] = map.harmonics.map_or([0.0; 2], |harmonics| harmonics.sums_by_degree(direction.normalize()));
    map.relative_mean * (1.0 + degree_1 + degree_2).max(0.0)
}

/// Numbers of photometric longitudes and latitudes of [`light_curve`].
const LIGHT_CURVE_GRID: [u32; 2] = [24, 12];

/// The rotational light curve: brightness of the disc relative to that of a disc that has the published albedo everywhere. 1 for an emissive body or without an
/// albedo map. `relative_mean` of a map is its mean albedo relative to the published one; it is the result for a map without harmonics. Otherwise the relative
/// albedo of a point is `relative_mean` times the sum of 1 and the map's harmonics (at least 0), and the result is the mean of that over the lit and visible
/// part of a sphere, weighted by the reflectance. `sun` and `viewer`: unit vectors from the body, body axes. Errors: those of the harmonics, which leave out
/// all finer detail of the map (tests/image/light_curves.rs).
pub fn light_curve(body: &Body, sun: DVec3, viewer: DVec3) -> f64 {
    let reflects = !matches!(body.photometry, Photometry::Emissive { .. });
    let Some(map) = body.maps.albedo.as_ref().filter(|_| reflects) else { return 1.0 };
    let Some(harmonics) = map.harmonics else { return map.relative_mean };
    let alpha = crate::ephemeris::angle_rad(sun, viewer);
    // Photometric longitude 0 is the viewer's, alpha the Sun's; the pole is perpendicular to both.
    let towards_sun = sun.reject_from(viewer).try_normalize().unwrap_or_else(|| viewer.any_orthonormal_vector());
    let pole = viewer.cross(towards_sun);
    let [columns, rows] = LIGHT_CURVE_GRID;
    // The lit and visible longitudes, from alpha - 90 to 90 degrees.
    let lit_longitudes_rad = PI - alpha;
    let (mut light, mut light_of_uniform_albedo) = (0.0, 0.0);
    for row in 0..rows {
        let (sin_latitude, cos_latitude) = (PI * ((f64::from(row) + 0.5) / f64::from(rows) - 0.5)).sin_cos();
        for column in 0..columns {
            let longitude = PI / 2.0 - lit_longitudes_rad * (f64::from(column) + 0.5) / f64::from(columns);
            let (mu0, mu) = (cos_latitude * (longitude - alpha).cos(), cos_latitude * longitude.cos());
            let weight = reflectance(&body.photometry, mu0, mu, alpha.cos()) * mu * cos_latitude;
            let normal = (viewer * longitude.cos() + towards_sun * longitude.sin()) * cos_latitude + pole * sin_latitude;
            let [degree_1, degree_2] = harmonics.sums_by_degree(normal);
            light += weight * (1.0 + degree_1 + degree_2).max(0.0);
            light_of_uniform_albedo += weight;
        }
    }
    // At a phase angle of 180 degrees nothing is lit.
    if light_of_uniform_albedo > 0.0 { map.relative_mean * light / light_of_uniform_albedo } else { 1.0 }
}

/// The part of a published phase law that is due to bright and dark areas, for a body that was measured from one side only (the Moon): the [`light_curve`] seen
/// from that side at phase angle `alpha`, relative to full phase; the mean of the waxing and the waning phase. 1 for other bodies. Beyond the law's largest
/// phase angle, the value there.
pub fn measured_side_curve(body: &Body, alpha: f64) -> f64 {
    let Some(law) = phase_laws::law(body.id) else { return 1.0 };
    let Some(side) = law.measured_side else { return 1.0 };
    // The Sun is near the plane of the equator, so the phases are those of a Sun in this plane, east and west of the measured side.
    let across = DVec3::Z.cross(side).normalize_or_zero();
    let (sin, cos) = alpha.min(law.limit_deg.to_radians()).sin_cos();
    let both_phases: f64 = [sin, -sin].map(|sin| light_curve(body, side * cos + across * sin, side)).iter().sum();
    0.5 * both_phases / light_curve(body, side, side).max(1e-12)
}

/// Mean radiance of the Sun's disc, which causes irradiance 1 at 1 au.
pub(crate) fn sun_disc_radiance() -> f64 {
    (KM_PER_AU / SUN_RADIUS_KM).powi(2)
}

/// Area of the ellipsoid's outline seen along `n` (unit vector, body axes), divided by pi: the squared radius of a circle of the same area.
pub(crate) fn projected_radius_sq_km2(radii_km: DVec3, n: DVec3) -> f64 {
    let (a, b, c) = (radii_km.x, radii_km.y, radii_km.z);
    ((b * c * n.x).powi(2) + (a * c * n.y).powi(2) + (a * b * n.z).powi(2)).sqrt()
}

/// Visual magnitude of an irradiance in units of the Sun's at 1 au.
pub fn magnitude(irradiance: f64) -> f64 {
    SUN_V_MAGNITUDE_AT_1_AU - 2.5 * irradiance.log10()
}

/// The irradiance of a visual magnitude.
pub fn irradiance_of_magnitude(magnitude: f64) -> f64 {
    10.0_f64.powf(0.4 * (SUN_V_MAGNITUDE_AT_1_AU - magnitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODELS: [Photometry; 6] = [
        Photometry::Lambert,
        Photometry::LommelSeeliger,
        Photometry::LunarLambert { lunar_weight: 0.6 },
        Photometry::LunarLambert { lunar_weight: 0.0 },
        Photometry::OrenNayar { roughness_deg: 20.0 },
        Photometry::OrenNayar { roughness_deg: 0.0 },
    ];

    /// Mean radiance of the disc under unit irradiance, by the midpoint rule over the image plane.
    fn disc_mean(model: &Photometry, alpha: f64) -> f64 {
        let to_sun = DVec3::new(alpha.sin(), 0.0, alpha.cos());
        let n = 700;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (x, y) = (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0, 2.0 * (f64::from(j) + 0.5) / f64::from(n) - 1.0);
                let z2 = 1.0 - x * x - y * y;
                if z2 <= 0.0 {
                    continue;
                }
                let normal = DVec3::new(x, y, z2.sqrt());
                let mu0 = normal.dot(to_sun);
                if mu0 > 0.0 {
                    sum += reflectance(model, mu0, normal.z, to_sun.z);
                }
            }
        }
        sum * 4.0 / f64::from(n * n) / PI
    }

    #[test]
    fn closed_forms_are_the_disc_integrals_of_the_models() {
        for model in &MODELS {
            let full = disc_mean(model, 0.0);
            let closed = model_geometric_albedo(model)[0];
            assert!((full - closed).abs() < 2e-3, "{model:?}: disc {full}, closed form {closed}");
            for alpha_deg in [10.0_f64, 60.0, 90.0, 140.0] {
                let alpha = alpha_deg.to_radians();
                let (disc, closed) = (disc_mean(model, alpha) / full, model_phase(model, alpha));
                assert!((disc - closed).abs() < 3e-3, "{model:?} at {alpha_deg}: disc {disc}, closed form {closed}");
            }
        }
    }

    #[test]
    fn phase_functions_fall_from_one_to_zero() {
        for model in &MODELS {
            assert!((model_phase(model, 0.0) - 1.0).abs() < 2e-3);
            assert!(model_phase(model, PI) < 1e-6);
            let values: Vec<_> = (0..=180).map(|d| model_phase(model, f64::from(d).to_radians())).collect();
            assert!(values.windows(2).all(|w| w[1] <= w[0] + 1e-9), "{model:?}");
        }
    }

    #[test]
    fn the_suns_irradiance_at_one_au_is_one() {
        let radius = DVec3::splat(SUN_RADIUS_KM);
        let solid_angle_over_pi = projected_radius_sq_km2(radius, DVec3::Y) / KM_PER_AU.powi(2);
        assert!((sun_disc_radiance() * solid_angle_over_pi - 1.0).abs() < 1e-12);
        assert!((magnitude(1.0) - SUN_V_MAGNITUDE_AT_1_AU).abs() < 1e-12);
    }

    #[test]
    fn the_projected_area_along_an_axis_is_the_product_of_the_other_two() {
        // Divided by pi, the ellipse seen along one semi-axis has the product of the other two as its area.
        let r = DVec3::new(3.0, 2.0, 1.0);
        assert!((projected_radius_sq_km2(r, DVec3::X) - 2.0).abs() < 1e-12);
        assert!((projected_radius_sq_km2(r, DVec3::Y) - 3.0).abs() < 1e-12);
        assert!((projected_radius_sq_km2(r, DVec3::Z) - 6.0).abs() < 1e-12);
    }
}
