//! The Sun's glare over the frame, for the light meter: the veil (the veiling glare of `light::glare`), and the glare of the sprite that draws a small Sun as a
//! point.
//!
//! In: the placed Sun and the camera. Out: [`FrameGlare`], which computes the median radiance over the frame. A Sun just beside the image has glare, too: veil
//! and sprite fade by the same law. The sprite's glare reaches at most 64 pixels, but in an image of about that size it is as bright as the veil. The sprite's
//! radius depends on the exposure, so with a sprite the median is computed for a given white. Without one it is computed once.

use super::MeteredFrame;
use super::geometry::area_px;
use crate::catalog::NaifId;
use crate::scene::light::glare;
use crate::scene::point;
use std::f64::consts::PI;

/// The Sun's sprite, and the glare at a grid of rays over the frame.
struct Sprite {
    /// The radiance that the Sun would have if it filled one pixel, brightest channel, before the fraction below.
    flux: f64,
    /// Fraction of this light that is drawn: less than 1 for a Sun beside the image.
    drawn_fraction: f64,
    /// Radiance of the veil, and distance from the Sun's centre in pixels, at each ray.
    samples: Vec<[f64; 2]>,
}

/// The Sun's glare over the frame.
#[derive(Default)]
pub(crate) struct FrameGlare {
    /// Median radiance of the veil; 0 without a Sun in the image or just beside it.
    median_of_veil: f64,
    /// `None` if no sprite's glare counts, as for a Sun that is drawn as a disc.
    sprite: Option<Sprite>,
}

/// The median of an even number of values, which are reordered; 0 of none.
fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let (lower, upper_middle, _) = values.select_nth_unstable_by(values.len() / 2, f64::total_cmp);
    0.5 * (lower.iter().copied().fold(f64::NEG_INFINITY, f64::max) + *upper_middle)
}

impl FrameGlare {
    /// Median radiance over the frame; 0 if the Sun is far outside the image. `white`: the radiance that is shown as white.
    pub(crate) fn median(&self, white: f64) -> f64 {
        let Some(sprite) = &self.sprite else { return self.median_of_veil };
        let radius_px = point::sprite_radius_px(sprite.flux, white);
        let [_, amplitude] = point::point_spread(radius_px);
        let radiance = sprite.flux * sprite.drawn_fraction * amplitude;
        let total = |[veil, distance_px]: &[f64; 2]| veil + radiance * point::glare_profile(*distance_px, radius_px);
        median(&mut sprite.samples.iter().map(total).collect::<Vec<f64>>())
    }
}

impl MeteredFrame<'_, '_> {
    /// The Sun's glare over the frame, dimmed by the air around the camera. Veil and sprite belong to different effects, and each counts if it is drawn.
    /// Sprites that are limited to a small part of the image (`Camera::limits_sprite_size`) do not count, because they do not change the median.
    pub(super) fn frame_glare(&self) -> FrameGlare {
        let camera = self.meter.camera;
        let sun = self.meter.placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > 0.0);
        let Some(sun) = sun else { return FrameGlare::default() };
        // The sprite is drawn at the Sun's centre, even if a part of the Sun is hidden. In a whole-sphere image the Sun may be behind the meter's frame.
        let centre = camera.clip(sun.placement.centre_km);
        let drawn_fraction = glare::entered_fraction(camera, sun);
        let flux = if centre.is_some() && drawn_fraction > 0.0 && !camera.limits_sprite_size {
            let point_light_fraction = 1.0 - self.disc_fraction(sun, 2.0 * (area_px(camera, sun) / PI).sqrt());
            let visible_fraction = glare::visible_fraction(self.meter.placed, sun);
            point::flux(camera, sun).max_element() * point_light_fraction * visible_fraction * self.light.sun_transmittance
        } else {
            0.0
        };
        if self.light.glare.is_none() && flux <= 0.0 {
            return FrameGlare::default();
        }
        let samples = self.sample_frame(|ray| {
            let distance_px =
                camera.clip(ray).zip(centre).map_or(f64::INFINITY, |(clip, centre)| ((clip - centre) * camera.half_size_px()).length());
            let veil = self.light.glare.as_ref().map_or(0.0, |veil| veil.radiance(ray.normalize()));
            [self.light.sun_transmittance * veil, distance_px]
        });
        let median_of_veil = median(&mut samples.iter().map(|[veil, _]| *veil).collect::<Vec<f64>>());
        FrameGlare { median_of_veil, sprite: (flux > 0.0).then_some(Sprite { flux, drawn_fraction, samples }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_the_mean_of_the_middle_two() {
        assert_eq!(median(&mut []), 0.0);
        for mut values in [[4.0, 1.0, 2.0, 8.0], [8.0, 4.0, 2.0, 1.0], [2.0, 8.0, 1.0, 4.0]] {
            assert_eq!(median(&mut values), 3.0);
        }
    }

    /// A sprite of which a hundredth is drawn has a hundredth of the glare, at the same radius.
    #[test]
    fn the_glare_of_a_sprite_is_in_proportion_to_its_drawn_fraction() {
        let median_of = |drawn_fraction: f64| {
            let samples = (0..16).map(|k| [0.0, f64::from(k)]).collect();
            FrameGlare { median_of_veil: 0.0, sprite: Some(Sprite { flux: 1e3, drawn_fraction, samples }) }.median(1.0)
        };
        assert!(median_of(1.0) > 0.0 && (median_of(0.01) / median_of(1.0) - 0.01).abs() < 1e-12);
    }
}
