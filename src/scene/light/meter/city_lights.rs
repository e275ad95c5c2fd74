//! The weight of city lights on the ground around the camera.
//!
//! In: a body with a night map, and the camera. Out: a factor on the radiance of its city lights. A night map has texels of kilometres, so all ground around a
//! camera in a city shines. A view from there that shows much of the sky is exposed for the sky; otherwise no image from a city would have stars. From an
//! aircraft, and for a camera that looks down, the lights are the subject.

use super::MeteredFrame;
use crate::scene::atmosphere::air;
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;

/// Heights of the camera between which the lights around the camera gradually become lights of a landscape below.
const LANDSCAPE_HEIGHTS_KM: [f64; 2] = [0.1, 3.0];
/// A view from the ground counts entirely as a view of the sky if at least this fraction of the frame is above the horizon.
const SKY_VIEW_FRACTION: f64 = 0.4;
/// Factor on the lights in a view of the sky: with it they are darker than the ground in starlight. It is above 0 so that the logarithm of the lights, and with
/// it the exposure, changes gradually.
const SKY_VIEW_WEIGHT: f64 = 1e-4;

/// Factor on the city lights of the ground below a camera. `sky_fraction`: the part of the frame above the horizon.
fn weight(height_km: f64, sky_fraction: f64) -> f64 {
    let [from, to] = LANDSCAPE_HEIGHTS_KM;
    let nearness_to_ground = 1.0 - smoothstep((height_km.max(1e-9) / from).ln() / (to / from).ln());
    SKY_VIEW_WEIGHT.powf(nearness_to_ground * smoothstep(sky_fraction / SKY_VIEW_FRACTION))
}

impl MeteredFrame<'_, '_> {
    /// Weight of a body's city lights relative to its other ground.
    pub(super) fn city_light_weight(&self, p: &PlacedBody<'_>) -> f64 {
        let weight_from_afar = self.meter.city_light_weight;
        let surrounds_camera = self.meter.air.is_some_and(|a| a.body.id == p.body.id);
        if weight_from_afar <= 0.0 || !surrounds_camera {
            return weight_from_afar;
        }
        weight_from_afar * weight(air::camera_height_km(p.body, &p.placement), self.sky_fraction())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn city_lights_count_from_above_and_for_a_camera_that_looks_down() {
        for (height_km, sky_fraction, expected) in
            [(0.002, 0.0, 1.0), (3.0, 0.5, 1.0), (400.0, 1.0, 1.0), (0.002, 0.4, SKY_VIEW_WEIGHT), (0.1, 1.0, SKY_VIEW_WEIGHT)]
        {
            assert!((weight(height_km, sky_fraction) / expected - 1.0).abs() < 1e-12, "{height_km} km, sky {sky_fraction}");
        }
        // In stops, per step of 1 % of the frame and of 2 % of the height.
        let step = |a: f64, b: f64| (a / b).log2().abs();
        let turned = (0..100).map(|k| 0.01 * f64::from(k)).map(|sky| step(weight(0.002, sky), weight(0.002, sky + 0.01)));
        let raised = (0..250).map(|k| 0.05 * 1.02_f64.powi(k)).map(|height| step(weight(height, 0.5), weight(1.02 * height, 0.5)));
        assert!(turned.chain(raised).fold(0.0, f64::max) < 0.55);
    }
}
