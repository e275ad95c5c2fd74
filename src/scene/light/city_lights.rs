//! The part of a night map's light that the ground below the camera shows.
//!
//! In: a body with a night map, and the camera. Out: a factor on the radiance of its city lights, for the draws of the globe and for the light meter. A night
//! map has the mean light of texels of kilometres, as seen from above. For a camera in a city this mean is wrong: most of the light comes from lamps and lit
//! streets, which cover little of the ground, and the ground between them is dim. Lamps are not drawn, and the sky has no glow of the city, so the mean fades to
//! nothing as the camera descends: a pale plain below a starry sky would be wrong. From a height of 3 km upwards the map's full light is drawn. The light meter
//! counts the lights that are drawn.

use crate::message::{Argument, Reason, reason};
use crate::scene::atmosphere::air;
use crate::scene::light::night_lights;
use crate::scene::numeric::{smoothstep, with_significant_digits};
use crate::scene::placed::PlacedBody;

/// Heights of the camera between which the factor rises from 0 to 1. Chosen: seen from 0.1 km single streets fill the frame, from 3 km whole towns.
const FADE_HEIGHTS_KM: [f64; 2] = [0.1, 3.0];

fn factor_at(height_km: f64) -> f64 {
    let [from, to] = FADE_HEIGHTS_KM;
    // Squared: a part in ten is left at 0.35 km.
    smoothstep((height_km.max(1e-9) / from).ln() / (to / from).ln()).powi(2)
}

/// Factor on the radiance of a body's city lights at the camera's height: 0 up to a height of 0.1 km, 1 from a height of 3 km on.
pub(crate) fn factor(p: &PlacedBody<'_>) -> f64 {
    factor_at(air::camera_height_km(p.body, &p.placement))
}

/// Radiance of a white texel of the body's night map as it is drawn, in the channel with the largest gain (the catalog's factor for each
/// channel of the map); 0 without a night map.
pub(crate) fn drawn_white_radiance(p: &PlacedBody<'_>) -> f64 {
    night_lights::white_radiance(p.body) * factor(p)
}

/// The reason why a camera near the ground sees less than the map's light; `reason` alone where it sees all of it.
pub(crate) fn with_height_note(reason: Reason, p: &PlacedBody<'_>) -> Reason {
    let factor = factor(p);
    if factor >= 1.0 {
        return reason;
    }
    let height_km = air::camera_height_km(p.body, &p.placement);
    let [height, percent] = [height_km, 100.0 * factor].map(|value| Argument::Number(with_significant_digits(value, 2)));
    reason.and(reason!("city-lights-near-ground", height = height, percent = percent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn city_lights_fade_out_towards_the_ground() {
        for height_km in [0.0, 0.002, 0.1] {
            assert_eq!(factor_at(height_km), 0.0, "{height_km} km");
        }
        // Exactly 1, so that views from these heights have the map's own light.
        for height_km in [3.0, 10.0, 400.0, 1e6] {
            assert_eq!(factor_at(height_km), 1.0, "{height_km} km");
        }
        // Per step of 2 % of the height; the light never falls with height.
        let steps = (0..250).map(|k| 0.05 * 1.02_f64.powi(k)).map(|height| factor_at(1.02 * height) - factor_at(height));
        let (least, greatest) = steps.fold((f64::INFINITY, 0.0_f64), |(least, greatest), step| (least.min(step), greatest.max(step)));
        assert!(least >= 0.0 && greatest > 0.0 && greatest < 0.012, "{least} to {greatest}");
    }
}
