//! The Sun's glare over the frame, for the light meter: the veil (the veiling glare of `light::glare`), and the glare of the sprite that draws a small Sun as a
//! point.
//!
//! In: the placed Sun and the camera. Out: [`FrameGlare`], which computes the median radiance over the frame. A Sun just beside the image has glare, too. The
//! sprite's glare reaches at most 64 pixels, but in an image of about that size it is as bright as the veil. The sprite's radius depends on the exposure, so
//! the median is computed for a given white.

use super::MeteredFrame;
use super::geometry::area_px;
use crate::catalog::NaifId;
use crate::scene::light::glare;
use crate::scene::point;
use std::f64::consts::PI;

/// The Sun's light as a point.
struct PointSun {
    /// The radiance that the Sun would have if it filled one pixel, brightest channel.
    flux: f64,
    /// Fraction of the light of the sprite's glare that is drawn: less than 1 for a Sun beside the image.
    drawn_part_of_glare: f64,
}

/// The Sun's glare at a grid of rays over the frame.
#[derive(Default)]
pub(crate) struct FrameGlare {
    /// Radiance of the veil, and distance from the Sun's centre in pixels. Empty without a Sun in the image or just beside it.
    samples: Vec<[f64; 2]>,
    /// `None` if no sprite's glare counts, as for a Sun that is drawn as a disc.
    point: Option<PointSun>,
}

impl FrameGlare {
    /// Median radiance over the frame; 0 if the Sun is far outside the image. `white`: the radiance that is shown as white.
    pub(crate) fn median(&self, white: f64) -> f64 {
        let half = self.samples.len() / 2;
        if half == 0 {
            return 0.0;
        }
        let sprite = self.point.as_ref().map(|p| {
            let radius_px = point::sprite_radius_px(p.flux, white, p.drawn_part_of_glare);
            let [_, amplitude] = point::point_spread(radius_px);
            (p.flux * amplitude, radius_px)
        });
        let of_sprite =
            |distance_px: f64| sprite.map_or(0.0, |(radiance, radius_px)| radiance * point::glare_profile(distance_px, radius_px));
        let mut all: Vec<f64> = self.samples.iter().map(|[veil, distance_px]| veil + of_sprite(*distance_px)).collect();
        all.sort_by(f64::total_cmp);
        0.5 * (all[half - 1] + all[half])
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
        let drawn_part_of_glare = glare::entered_fraction(camera, sun);
        let flux = if centre.is_some() && drawn_part_of_glare > 0.0 && !camera.limits_sprite_size {
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
        FrameGlare { samples, point: (flux > 0.0).then_some(PointSun { flux, drawn_part_of_glare }) }
    }
}
