//! The light of an ellipsoid that has no published phase law, as phase function times the squared radius of a circle as large as the outline.
//!
//! In: the body, and unit vectors to Sun and viewer. Out: this product, km². Product times geometric albedo = integral over the outline's area of the
//! radiance under irradiance 1 (0 where the ground is not lit), divided by pi. Not here: bright and dark sides of maps ([`photometry::light_curve`]), and
//! bodies with a published law. Greatest error of the integral, for semi-axes that differ by up to a factor of 2.4 and phase angles up to 150 degrees: 2e-4 for
//! Lommel-Seeliger, 5e-3 for lunar-Lambert with a lunar weight of at least 0.35, 1.2e-2 for Lambert, 1.6e-2 for Oren-Nayar with a roughness of up to 20
//! degrees. In 99 of 100 directions all errors are below 4e-3.

use crate::catalog::{Body, Photometry};
use crate::ephemeris::angle_rad;
use crate::scene::light::{phase_laws, photometry};
use crate::scene::numeric::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

/// A body counts as a sphere if its least semi-axis is more than this fraction of its greatest. This changes its light by at most 2 % at phase angles up to 150
/// degrees.
const SPHERE_FROM_AXIS_RATIO: f64 = 0.99;

/// Number of nodes of the integral in each of longitude and latitude.
const NODE_COUNT: usize = 8;

/// Nodes of the integral in longitude, as fractions of the range of longitudes, and their weights.
static LONGITUDES: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(NODE_COUNT));

/// Sine and cosine of each node's latitude, and the node's weight: the part of the unit sphere's area per radian of longitude that it represents.
static LATITUDES: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let of_node = |(node, weight): (f64, f64)| {
        // Nodes and weights are those of an integral from 0 to 1.
        let (sin, cos) = (PI * (node - 0.5)).sin_cos();
        [sin, cos, PI * weight * cos]
    };
    gauss_legendre(NODE_COUNT).into_iter().map(of_node).collect()
});

/// The phase function, multiplied by the squared radius, km², of a circle with the area of the outline. `None` for spheres, bodies with a published phase law
/// and emissive bodies, whose light `light::disc_light` gives. `sun`, `viewer`: unit vectors from the body, body axes.
pub(crate) fn phase_times_radius_sq_km2(body: &Body, sun: DVec3, viewer: DVec3) -> Option<f64> {
    let radii_km = body.radii_km;
    let is_sphere = radii_km.min_element() > SPHERE_FROM_AXIS_RATIO * radii_km.max_element();
    let is_emissive = matches!(body.photometry, Photometry::Emissive { .. });
    if is_sphere || is_emissive || phase_laws::law(body.id).is_some() {
        return None;
    }
    // All channels of the model's albedo are equal, since the body is not emissive.
    Some(reflected_km2(&body.photometry, radii_km, sun, viewer) / photometry::model_geometric_albedo(&body.photometry)[0])
}

/// The radiance under irradiance 1, integrated over the area of the outline and divided by pi, km². The albedo map counts as 1.
fn reflected_km2(model: &Photometry, radii_km: DVec3, sun: DVec3, viewer: DVec3) -> f64 {
    // In the frame in which the ground is the unit sphere, the cosine of incidence at a point is dot(point, to_sun) / length, and that of emission is
    // dot(point, to_viewer) / length, where length is that of (point / semi-axes).
    let (to_sun, to_viewer) = (sun / radii_km, viewer / radii_km);
    let (sun_length, viewer_length) = (to_sun.length(), to_viewer.length());
    // Not the phase angle, but the corresponding angle in this frame.
    let alpha = angle_rad(to_sun, to_viewer);
    // Longitude 0 is that of `to_viewer`, alpha that of `to_sun`; the pole is perpendicular to both.
    let x = to_viewer / viewer_length;
    // At smaller angles (radians) rounding would determine the direction.
    let y = if alpha > 1e-9 { to_sun.reject_from(x).normalize_or_zero() } else { x.any_orthonormal_vector() };
    // `pole` and, below, `equatorial` are unit vectors of this frame, divided by the semi-axes: parts of (point / semi-axes).
    let pole = x.cross(y) / radii_km;
    let pole_sq = pole.length_squared();
    // The lit and visible longitudes: from pi / 2 down to alpha - pi / 2.
    let (lit_visible_width, cos_phase) = (PI - alpha, sun.dot(viewer));
    let mut sum = 0.0;
    for (node, longitude_weight) in LONGITUDES.iter() {
        let longitude = FRAC_PI_2 - lit_visible_width * node;
        let (sin, cos) = longitude.sin_cos();
        let equatorial = (x * cos + y * sin) / radii_km;
        let (equatorial_sq, equatorial_dot_pole) = (equatorial.length_squared(), equatorial.dot(pole));
        // At latitude 0: dot(point, to_sun) and dot(point, to_viewer).
        let (towards_sun, towards_viewer) = ((longitude - alpha).cos() * sun_length, cos * viewer_length);
        for [sin_lat, cos_lat, latitude_weight] in LATITUDES.iter() {
            // The length of (point / semi-axes), squared.
            let length_sq = cos_lat * cos_lat * equatorial_sq + 2.0 * sin_lat * cos_lat * equatorial_dot_pole + sin_lat * sin_lat * pole_sq;
            let cos_lat_per_length = cos_lat / length_sq.sqrt();
            let radiance = photometry::reflectance(model, towards_sun * cos_lat_per_length, towards_viewer * cos_lat_per_length, cos_phase);
            // Projected towards the viewer, the ground's area is that of the unit sphere times dot(point, to_viewer) and the semi-axes' product.
            sum += longitude_weight * latitude_weight * radiance * cos_lat * towards_viewer;
        }
    }
    sum * lit_visible_width * radii_km.element_product() / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Semi-axes of Amalthea, Prometheus and Proteus.
    const SHAPES: [[f64; 3]; 3] = [[125.0, 73.0, 64.0], [68.2, 41.6, 28.2], [218.0, 208.0, 201.0]];
    const PHASES_DEG: [f64; 6] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0];

    /// Directions to Sun and viewer at a phase angle.
    fn random_directions(random: &mut Random, phase_deg: f64) -> [DVec3; 2] {
        let viewer = random.direction();
        let across = random.direction().reject_from(viewer).normalize();
        let (sin, cos) = phase_deg.to_radians().sin_cos();
        [viewer * cos + across * sin, viewer]
    }

    /// The closed form for a Lommel-Seeliger ellipsoid (Muinonen and Lumme 2015, A&A 584, A23), in the unit of [`reflected_km2`].
    fn muinonen_lumme_km2(radii_km: DVec3, sun: DVec3, viewer: DVec3) -> f64 {
        let (to_sun, to_viewer) = (sun / radii_km, viewer / radii_km);
        let (s, v, alpha) = (to_sun.length(), to_viewer.length(), angle_rad(to_sun, to_viewer));
        let lambda = (s * alpha.sin()).atan2(v + s * alpha.cos());
        let rest = alpha - lambda;
        // At alpha = 0 the logarithm has the factor sin(lambda) = 0.
        let logarithm = if alpha > 1e-9 { ((lambda / 2.0).tan() * (rest / 2.0).tan()).ln() } else { 0.0 };
        let shape = lambda.cos() + rest.cos() + lambda.sin() * rest.sin() * logarithm;
        radii_km.element_product() * s * v / (to_sun + to_viewer).length() * shape
    }

    /// The integral of [`reflected_km2`] as a sum over points of the entire ellipsoid; the reflectance of dark and of hidden points is 0.
    fn summed_km2(model: &Photometry, radii_km: DVec3, sun: DVec3, viewer: DVec3) -> f64 {
        let steps = 400;
        let mut sum = 0.0;
        for row in 0..steps {
            // Equal areas of the unit sphere.
            let z = (2.0 * f64::from(row) + 1.0) / f64::from(steps) - 1.0;
            for column in 0..steps {
                let (sin, cos) = (2.0 * PI * (f64::from(column) + 0.5) / f64::from(steps)).sin_cos();
                let point = DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z);
                let normal = point / radii_km;
                let [mu0, mu] = [sun, viewer].map(|direction| normal.dot(direction) / normal.length());
                sum += photometry::reflectance(model, mu0, mu, sun.dot(viewer)) * mu.max(0.0) * normal.length();
            }
        }
        // Each point stands for 4 pi / steps² of the unit sphere; the factor pi cancels.
        sum * 4.0 / f64::from(steps * steps) * radii_km.element_product()
    }

    #[test]
    fn a_lommel_seeliger_ellipsoid_has_the_light_of_the_closed_form() {
        let mut random = Random::new(3);
        let (mut worst, mut worst_of_sphere) = (0.0_f64, 0.0_f64);
        for radii_km in SHAPES.map(DVec3::from_array) {
            for phase_deg in PHASES_DEG {
                for _ in 0..40 {
                    let [sun, viewer] = random_directions(&mut random, phase_deg);
                    let reference = muinonen_lumme_km2(radii_km, sun, viewer);
                    let error = reflected_km2(&Photometry::LommelSeeliger, radii_km, sun, viewer) / reference - 1.0;
                    assert!(error.abs() < 2e-4, "{radii_km} at {phase_deg}: {error:e}");
                    worst = worst.max(error.abs());
                    // Negative control: with the phase function of a sphere and the outline's area, the light is wrong by more than half in some direction.
                    let phase = photometry::model_phase(&Photometry::LommelSeeliger, phase_deg.to_radians());
                    let of_sphere = phase * photometry::projected_radius_sq_km2(radii_km, viewer);
                    worst_of_sphere = worst_of_sphere.max((of_sphere / reference - 1.0).abs());
                }
            }
        }
        println!("{worst:e}; with a sphere's phase function {worst_of_sphere:.2}");
        assert!(worst_of_sphere > 0.5, "{worst_of_sphere}");
    }

    #[test]
    fn ellipsoids_of_each_model_have_the_light_of_a_fine_sum() {
        let mut random = Random::new(4);
        // Tolerances: 1e-3, the error of `summed_km2`, plus the error that the module's first comment states: 2e-4 (the greatest) for Lommel-Seeliger, 4e-3 (in
        // 99 of 100 directions) for the others, since none of the few directions here is among the worst.
        for (model, tolerance) in [
            (Photometry::LommelSeeliger, 1.2e-3),
            (Photometry::LunarLambert { lunar_weight: 0.35 }, 5e-3),
            (Photometry::Lambert, 5e-3),
            (Photometry::OrenNayar { roughness_deg: 20.0 }, 5e-3),
        ] {
            for radii_km in SHAPES.map(DVec3::from_array) {
                for phase_deg in PHASES_DEG {
                    let [sun, viewer] = random_directions(&mut random, phase_deg);
                    let (light, reference) = (reflected_km2(&model, radii_km, sun, viewer), summed_km2(&model, radii_km, sun, viewer));
                    assert!((light / reference - 1.0).abs() < tolerance, "{model:?}, {radii_km} at {phase_deg}: {light}, {reference}");
                }
            }
        }
    }

    /// Directions to Sun and viewer with nearly the greatest errors that a search found for the shape of Prometheus. The errors are within those that the file
    /// states, and more than 2/3 of them, so that smaller stated errors would fail. The error of
    /// `summed_km2` itself is below 1e-4 in these directions.
    #[test]
    fn in_the_worst_directions_the_errors_are_those_stated() {
        for (model, sun, viewer, stated) in [
            (Photometry::LunarLambert { lunar_weight: 0.35 }, [0.678, -0.734, -0.019], [0.699, 0.715, 0.019], 5e-3),
            (Photometry::Lambert, [-0.418, -0.905, 0.072], [-0.092, 0.993, -0.077], 1.2e-2),
            (Photometry::OrenNayar { roughness_deg: 20.0 }, [-0.832, -0.545, 0.099], [-0.878, 0.472, -0.076], 1.6e-2),
        ] {
            let [_, prometheus, _] = SHAPES;
            let radii_km = DVec3::from_array(prometheus);
            let [sun, viewer] = [sun, viewer].map(|direction| DVec3::from_array(direction).normalize());
            let error = (reflected_km2(&model, radii_km, sun, viewer) / summed_km2(&model, radii_km, sun, viewer) - 1.0).abs();
            assert!((2.0 / 3.0 * stated..stated).contains(&error), "{model:?}: {error:e}");
        }
    }

    #[test]
    fn spheres_have_their_phase_function() {
        for model in [
            Photometry::Lambert,
            Photometry::LommelSeeliger,
            Photometry::LunarLambert { lunar_weight: 0.6 },
            Photometry::OrenNayar { roughness_deg: 20.0 },
        ] {
            let geometric_albedo = photometry::model_geometric_albedo(&model)[0];
            for phase_deg in PHASES_DEG {
                let alpha = phase_deg.to_radians();
                let sun = DVec3::new(alpha.cos(), alpha.sin(), 0.0);
                // Of a sphere with a radius of 2 km.
                let phase = reflected_km2(&model, DVec3::splat(2.0), sun, DVec3::X) / 4.0 / geometric_albedo;
                let error = phase - photometry::model_phase(&model, alpha);
                assert!(error.abs() < 2e-3, "{model:?} at {phase_deg}: {error:e}");
            }
            // From behind, no light; nothing divides by 0.
            assert!(reflected_km2(&model, DVec3::new(3.0, 2.0, 1.0), DVec3::NEG_X, DVec3::X).abs() < 1e-12);
        }
    }

    #[test]
    fn only_elongated_bodies_without_a_published_law_are_integrated() {
        let catalog = crate::catalog::Catalog::embedded();
        // Amalthea and Hyperion are elongated. Io and Titan are spheres, Saturn and Vesta have a published law, the Sun is emissive.
        for (id, is_integrated) in [(505, true), (607, true), (2_000_004, false), (501, false), (606, false), (699, false), (10, false)] {
            let body = catalog.body(crate::catalog::NaifId(id)).expect("in the catalog");
            assert_eq!(phase_times_radius_sq_km2(body, DVec3::X, DVec3::Y).is_some(), is_integrated, "{}", body.name);
        }
    }
}
