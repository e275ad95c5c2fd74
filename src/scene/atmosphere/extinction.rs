//! Scattering and extinction coefficients of an atmosphere by height, and optical depths along rays.
//!
//! In: the catalog's species. Out: coefficients per kilometre and optical depths, per channel (linear RGB). Heights and lengths are kilometres.
//! Not here: the geometry of rays. The caller gives the height along the ray.

use crate::catalog::{Atmosphere, Species};
use glam::DVec3;

/// Scattering coefficient of a species where its [`density`] is 1, per km.
pub(crate) fn scattering(s: &Species) -> DVec3 {
    DVec3::from_array(s.scattering_per_km)
}

/// Extinction coefficient of a species where its [`density`] is 1, per km.
pub(crate) fn extinction(s: &Species) -> DVec3 {
    scattering(s) + DVec3::from_array(s.absorption_per_km)
}

/// Density of a species at a height, relative to that at the ground; that of a triangular layer (a tent) relative to its peak. The density of such a layer
/// falls to 0 within `scale_height_km` above and below its centre.
pub(crate) fn density(s: &Species, height_km: f64) -> f64 {
    match s.tent_centre_km {
        Some(centre) => (1.0 - (height_km - centre).abs() / s.scale_height_km).max(0.0),
        None => (-height_km / s.scale_height_km).exp(),
    }
}

/// A coefficient summed over all species, per kilometre. `of_species`: [`scattering`] or [`extinction`].
pub(crate) fn coefficient(air: &Atmosphere, height_km: f64, of_species: fn(&Species) -> DVec3) -> DVec3 {
    air.species.iter().map(|s| of_species(s) * density(s, height_km)).sum()
}

/// Column of a species: the integral of its [`density`] from a height to infinity.
pub(crate) fn column_above_km(s: &Species, height_km: f64) -> f64 {
    match s.tent_centre_km {
        Some(centre) => {
            let half_widths_above_centre = ((height_km - centre) / s.scale_height_km).clamp(-1.0, 1.0);
            // Fraction of the triangle's area that is farther from the centre than this height, on the same side of the centre.
            let outer_fraction = 0.5 * (1.0 - half_widths_above_centre.abs()).powi(2);
            s.scale_height_km * if half_widths_above_centre < 0.0 { 1.0 - outer_fraction } else { outer_fraction }
        }
        None => s.scale_height_km * (-height_km / s.scale_height_km).exp(),
    }
}

/// Vertical optical depth of the air between a height and the top of the atmosphere.
pub(crate) fn depth_above(air: &Atmosphere, height_km: f64) -> DVec3 {
    air.species.iter().map(|s| extinction(s) * (column_above_km(s, height_km) - column_above_km(s, air.top_km))).sum()
}

/// Vertical opacity of the air above a height, the mean of the channels.
pub(crate) fn opacity_above(air: &Atmosphere, height_km: f64) -> f64 {
    -(-depth_above(air, height_km)).map(f64::exp_m1).element_sum() / 3.0
}

/// Quadrature along a ray: positions as fractions of its length, with their weights. The positions are midpoints of equal steps in the square root of the
/// length, so steps in length grow away from the start, where the air is densest.
pub(crate) fn quadrature(count: usize) -> impl DoubleEndedIterator<Item = (f64, f64)> {
    (0..count).map(move |k| {
        // A step du in the square root is a step 2 u du in the position u^2.
        let u = (k as f64 + 0.5) / count as f64;
        (u * u, 2.0 * u / count as f64)
    })
}

/// Optical depth of a straight ray that starts where its air is densest, by `count` samples. `height_km`: height at a distance in km from the start.
pub(crate) fn optical_depth(air: &Atmosphere, length_km: f64, count: usize, height_km: impl Fn(f64) -> f64) -> DVec3 {
    quadrature(count).map(|(fraction, weight)| coefficient(air, height_km(length_km * fraction), extinction) * (length_km * weight)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// On a vertical ray the height is the distance from the start, and the depth has a closed form.
    #[test]
    fn the_vertical_depth_is_that_of_the_columns() {
        let catalog = Catalog::embedded();
        let air = catalog.body(NaifId::EARTH).and_then(|b| b.atmosphere.as_ref()).expect("air");
        let column = |s: &Species| match s.tent_centre_km {
            // A triangular profile of half width w has the column of a layer of thickness w and density 1.
            Some(_) => s.scale_height_km,
            None => s.scale_height_km * -(-air.top_km / s.scale_height_km).exp_m1(),
        };
        let exact: DVec3 = air.species.iter().map(|s| extinction(s) * column(s)).sum();
        let relative_error =
            |count: usize| ((optical_depth(air, air.top_km, count, |distance_km| distance_km) - exact) / exact).abs().max_element();
        assert!(relative_error(1000) < 1e-5, "{}", relative_error(1000));
        // As many steps as `OPTICAL_DEPTH_STEPS` of `scene::eclipse::refraction`.
        assert!(relative_error(48) < 5e-3, "{}", relative_error(48));
        assert!(relative_error(4) > 5e-3, "four steps are too few");
        // Heights below and above the centre of the ozone, 25 km.
        for height_km in [0.0, 5.0, 20.0, 30.0, 80.0] {
            let by_steps = optical_depth(air, air.top_km - height_km, 4000, |distance_km| height_km + distance_km);
            let error = ((depth_above(air, height_km) - by_steps) / by_steps).abs().max_element();
            assert!(error < 1e-4, "{error} above {height_km} km");
        }
        assert!((quadrature(48).map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
