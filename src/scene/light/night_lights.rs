//! City lights for the light meter: the radiance of the ground on the night side.
//!
//! In: a night map's linear texels and its gain. Out: [`NightLights`], the radiance at each point of the ground. Always: the radiance is continuous and not
//! negative. Only the light meter reads these values; shaders read the map itself.

use crate::catalog::Body;
use crate::scene::constants::CIVIL_TWILIGHT_SINE;
use crate::scene::light::ground_grid::GroundGrid;
use crate::scene::numeric::smoothstep;
use crate::scene::thresholds::NIGHT_MAP_WHITE_RADIANCE;
use glam::DVec3;

/// The radiance of a body's city lights on the grid of its night map.
#[derive(Clone, Debug, PartialEq)]
pub struct NightLights {
    radiance: GroundGrid,
}

/// Radiance of a white texel of the body's night map, in the channel with the largest gain; 0 without a night map.
pub(crate) fn white_radiance(body: &Body) -> f64 {
    body.maps.night.as_ref().map_or(0.0, |map| map.gain.iter().copied().fold(0.0, f64::max)) * NIGHT_MAP_WHITE_RADIANCE
}

/// Fraction of city lights that are switched on: 0 if the Sun is above the horizon, 1 if it is at least 6 degrees below. The same as in
/// shaders/lib/night_lights.wesl. `cos_incidence`: cosine of the Sun's zenith angle, negative at night.
pub(crate) fn lit_fraction(cos_incidence: f64) -> f64 {
    1.0 - smoothstep(cos_incidence / CIVIL_TWILIGHT_SINE + 1.0)
}

impl NightLights {
    /// Computes the radiance from the texels of an equirectangular map: rows from north to south, each texel's brightest channel, linear, 0 to 1. `None` if
    /// the number of texels is wrong.
    pub(crate) fn new(body: &Body, width: usize, height: usize, texels: impl Iterator<Item = f64>) -> Option<Self> {
        let white = white_radiance(body);
        let radiance = GroundGrid::new(body, width, height, texels.map(|texel| texel.max(0.0) * white))?;
        Some(Self { radiance })
    }

    /// Radiance at a point of the ground (unit-sphere frame).
    pub(crate) fn radiance_at(&self, point: DVec3) -> f64 {
        self.radiance.at(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    /// A map that is bright only in the east gives light there, none in the west, and half at the meridian in between. A wrong number of texels is
    /// rejected.
    #[test]
    fn city_lights_are_where_the_map_has_them() {
        let catalog = Catalog::embedded();
        let earth = catalog.body(NaifId::EARTH).expect("the Earth");
        let texels = || (0..8 * 4).map(|k| f64::from(u8::from(k % 8 >= 4)));
        let night_lights = NightLights::new(earth, 8, 4, texels()).expect("complete");
        let white = white_radiance(earth);
        let fraction_of_white = |lon_deg: f64| {
            let (sin, cos) = lon_deg.to_radians().sin_cos();
            night_lights.radiance_at(DVec3::new(cos, sin, 0.1)) / white
        };
        let [west, middle, east] = [-90.0, 0.0, 90.0].map(fraction_of_white);
        assert!(white > 0.0);
        assert!((east - 1.0).abs() < 1e-6 && west.abs() < 1e-9 && (middle - 0.5).abs() < 1e-6, "{west} {middle} {east}");
        assert!(NightLights::new(earth, 8, 5, texels()).is_none());
        assert_eq!((lit_fraction(0.0), lit_fraction(-0.2)), (0.0, 1.0));
    }
}
