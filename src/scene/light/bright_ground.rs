//! Ground brighter than a body's mean, such as deserts and ice, for the light meter.
//!
//! In: an albedo map's linear texels and its gain. Out: [`BrightGround`]: how much brighter than the mean of the body each point of the ground is metered.
//! Always: the factor is continuous and at least 1. Darker ground is metered as the mean: a sea also mirrors sky and Sun, and looks right if it is dark.

use crate::catalog::Body;
use crate::scene::light::ground_grid::GroundGrid;
use glam::DVec3;

/// Power of the ground's reflectance, relative to the mean, by which it is metered. With 1, sand and snow would be as grey as rock; with 0 (the mean for all
/// ground) they were blank, the Sahara at 3.4 times white. Chosen: with 0.7 it is shown at about 0.8 of white.
const METERED_EXPONENT: f64 = 0.7;

/// The reflectance of bright ground on the grid of a body's albedo map.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightGround {
    /// Relative to the mean of the body, brightest channel; at least 1.
    relative_reflectance: GroundGrid,
}

impl BrightGround {
    /// `texels`: of the albedo map, rows from north to south, linear. `None` if their number is wrong, or without an albedo map.
    pub(crate) fn new(body: &Body, width: usize, height: usize, texels: impl Iterator<Item = [f64; 3]>) -> Option<Self> {
        let gain = body.maps.albedo.as_ref()?.gain;
        let brightest = |channels: [f64; 3]| channels.into_iter().fold(0.0, f64::max);
        let mean = brightest(body.mean_reflectance());
        if mean <= 0.0 {
            return None;
        }
        let relative = texels.map(|[red, green, blue]| brightest([red * gain[0], green * gain[1], blue * gain[2]]) / mean);
        let relative_reflectance = GroundGrid::new(body, width, height, relative.map(|value| value.max(1.0)))?;
        Some(Self { relative_reflectance })
    }

    /// The metered radiance of the ground at a point (unit-sphere frame), divided by that of ground with the body's mean reflectance.
    pub(crate) fn relative_radiance(&self, point: DVec3) -> f64 {
        self.relative_reflectance.at(point).powf(METERED_EXPONENT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// A map that is white in the east and black in the west: bright ground counts with a part of its brightness, dark ground as the mean. A wrong number of
    /// texels is rejected.
    #[test]
    fn only_ground_brighter_than_the_mean_counts() {
        let catalog = Catalog::embedded();
        let earth = catalog.body(NaifId::EARTH).expect("the Earth");
        let texels = || (0..8 * 4).map(|k| [f64::from(u8::from(k % 8 >= 4)); 3]);
        let ground = BrightGround::new(earth, 8, 4, texels()).expect("complete");
        let at = |lon_deg: f64| {
            let (sin, cos) = lon_deg.to_radians().sin_cos();
            ground.relative_radiance(DVec3::new(cos, sin, 0.1))
        };
        // White in the map: 0.55 in the brightest channel, 8.5 times the mean.
        let ratio = earth.maps.albedo.as_ref().expect("a map").gain[2] / earth.mean_reflectance()[2];
        assert!(ratio > 5.0 && (at(90.0) / ratio.powf(METERED_EXPONENT) - 1.0).abs() < 1e-6, "{ratio}: {}", at(90.0));
        assert_eq!(at(-90.0), 1.0);
        assert!(BrightGround::new(earth, 8, 5, texels()).is_none());
    }
}
