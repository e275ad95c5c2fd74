//! The place of a star at a date: linear space motion, and parallax from the viewer's position.
//!
//! In: a star of a catalog, the years since its epoch, the viewer's barycentric position. Out: the vector to the star in units of its distance at the
//! epoch, so that stars without a measured distance need no special case. Its direction is without aberration, and one over its squared length is the
//! brightness relative to the catalog. Omitted: the change of light time along the star's path (as in catalogs), orbits of double stars, and light
//! deflection by the Sun (0.004 arcsec at 90 degrees, 1.75 at the limb).

use crate::catalog::stars::Star;
use glam::DVec3;

/// Vector from the viewer to the star, ICRF, in units of the star's distance at the epoch. `years`: since the epoch of the catalog. `viewer_au`: barycentric,
/// ICRF.
pub fn star_from_viewer(star: &Star, years: f64, viewer_au: DVec3) -> DVec3 {
    star.direction + star.motion_per_year * years - viewer_au * star.parallax_rad
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::stars::StarCatalog;
    use crate::ephemeris::angle_rad;
    use crate::units::RAD_PER_ARCSEC;

    /// Between opposite points of the Earth's orbit the nearest bright star (alpha Centauri A, HIP 71683) shifts by twice its parallax of 754.81 mas. Halfway
    /// to the star, its distance is half that at the epoch.
    #[test]
    fn parallax_is_the_angle_of_an_au() {
        let catalog = StarCatalog::embedded();
        let star = catalog.star_of_hip(71_683).expect("alpha Centauri A");
        let abeam = star.direction.any_orthonormal_vector();
        let [first, second] = [abeam, -abeam].map(|viewer_au| star_from_viewer(star, 0.0, viewer_au));
        let shift_arcsec = angle_rad(first, second) / RAD_PER_ARCSEC;
        assert!((shift_arcsec - 2.0 * star.parallax_rad / RAD_PER_ARCSEC).abs() < 1e-6, "{shift_arcsec}");
        assert!((1.4..1.6).contains(&shift_arcsec));
        let half_way = star_from_viewer(star, 0.0, star.direction * (0.5 / star.parallax_rad));
        assert!((half_way.length() - 0.5).abs() < 1e-12 && angle_rad(half_way, star.direction) < 1e-12);
    }

    /// In 3000 BC Arcturus (2.28 arcsec a year) was 3.16 degrees from its present place. The shipped catalog has no radial
    /// velocities, so its straight path is perpendicular to the present direction, and its direction turns by less than 90 degrees however long it moves.
    #[test]
    fn proper_motion_is_straight() {
        let catalog = StarCatalog::embedded();
        let star = catalog.star_of_hip(69_673).expect("Arcturus");
        let moved_deg = |years: f64| angle_rad(star.direction, star_from_viewer(star, years, DVec3::ZERO)).to_degrees();
        // From the catalog's epoch of 1991.25 to 3000 BC, the year -2999.
        assert!((moved_deg(-4990.0) - 3.16).abs() < 0.02, "{}", moved_deg(-4990.0));
        assert!(moved_deg(1e7) < 90.0 && moved_deg(1e7) > 89.0);
        assert_eq!(moved_deg(0.0), 0.0);
    }
}
