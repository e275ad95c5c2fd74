//! Meters the outer corona by rays of the frame, in two cases: the camera is near the Sun, so that the corona surrounds the camera; or a body in front of the
//! Sun hides the inner corona but not the outer one. Very near the Sun the rays meter the inner corona, too.
//!
//! In: the metered frame. Out: one subject, the corona beyond the annuli of the inner corona ([`MeteredFrame::corona`]). Always: continuous in the camera's
//! position.

use super::geometry::area_px;
use super::{ANNULI_TO_RAYS_SINES, AUTO_EXPOSED_MEAN, CORONA_RADII, FRAME_RAYS, LogMean, MeteredFrame, MeteredSubject, SUN_WEIGHT};
use crate::catalog::NaifId;
use crate::ephemeris::angle_rad;
use crate::message::reason;
use crate::scene::light::corona;
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::sky::zodiacal;
use crate::units::KM_PER_AU;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Weight of the inner corona in the sum over rays of the frame; in the annuli of [`MeteredFrame::corona`] its weight is 1 minus this. `sin_sun_radius`: sine
/// of the Sun's angular radius.
pub(super) fn ray_weight_of_inner_corona(sin_sun_radius: f64) -> f64 {
    smooth_rise(ANNULI_TO_RAYS_SINES, sin_sun_radius)
}

impl<'a> MeteredFrame<'_, 'a> {
    /// The bodies in the frame that may hide parts of the inner corona. Bodies of less than a pixel count, too, as in front of the Sun: the Moon hides the
    /// brightest part of the corona in images of any size.
    pub(super) fn bodies_before_inner_corona(&self, sun: &PlacedBody<'_>) -> Vec<&PlacedBody<'a>> {
        // The soft limbs of bodies (`MeteredFrame::ray_visibility`) reach less than another solar radius.
        let edge_rad = ((CORONA_RADII[1] + 1.0) * sun.body.radii_km.x / sun.distance_km).min(1.0).asin();
        let is_in_front = |o: &&PlacedBody<'_>| {
            o.body.id != NaifId::SUN
                && o.distance_km < sun.distance_km
                && area_px(self.meter.camera, o) > 0.0
                && angle_rad(o.placement.centre_km, sun.placement.centre_km) < o.angular_radius_rad() + edge_rad
        };
        self.meter.placed.iter().filter(is_in_front).collect()
    }

    /// The fraction of the inner corona's outer edge that nearer bodies hide, whether they are in the frame or not: 1 if a body hides all of the inner corona.
    /// A body much smaller than one of the sectors into which the edge is divided hides nothing.
    fn hidden_part_of_inner_corona(&self, sun: &PlacedBody<'_>) -> f64 {
        const SECTORS: u32 = 16;
        let to_sun = sun.placement.centre_km / sun.distance_km;
        let sin_edge_radius = CORONA_RADII[1] * sun.body.radii_km.x / sun.distance_km;
        if sin_edge_radius >= 1.0 {
            return 0.0;
        }
        let (x, y) = to_sun.any_orthonormal_pair();
        let sector_width = TAU * sin_edge_radius / f64::from(SECTORS);
        // Not `nearer_bodies`, which leaves out bodies beside the frame.
        let is_nearer =
            |o: &&PlacedBody<'_>| o.body.id != NaifId::SUN && o.distance_km < sun.distance_km && !o.placement.camera_is_inside();
        // Rises from 0 to 1 while the body's diameter grows from half a sector to a whole one.
        let opacity = |o: &PlacedBody<'_>| smoothstep(4.0 * o.body.radii_km.max_element() / (o.distance_km * sector_width) - 1.0);
        let nearer: Vec<(&PlacedBody<'_>, f64)> =
            self.meter.placed.iter().filter(is_nearer).map(|o| (o, opacity(o))).filter(|(_, opacity)| *opacity > 0.0).collect();
        let visibility = |k: u32| {
            let across = DVec2::from_angle(TAU * (f64::from(k) + 0.5) / f64::from(SECTORS)) * sin_edge_radius;
            let direction = to_sun * (1.0 - sin_edge_radius * sin_edge_radius).sqrt() + x * across.x + y * across.y;
            nearer.iter().map(|(o, opacity)| 1.0 - opacity * (1.0 - Self::ray_visibility(&[*o], direction, sector_width))).product::<f64>()
        };
        1.0 - (0..SECTORS).map(visibility).sum::<f64>() / f64::from(SECTORS)
    }

    /// Meters the corona beyond the annuli of [`Self::corona`]; near the Sun, all of it. `None` if the corona is narrow and its inner part is in view: for a
    /// camera at least [`zodiacal::NEAREST_AU`] from the Sun, unless a body hides that part.
    pub(super) fn outer_corona(&self) -> Option<MeteredSubject> {
        let (camera, request) = (self.meter.camera, self.meter.context.request);
        let sun = self.meter.placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > p.body.radii_km.x)?;
        // 0 from `NEAREST_AU` outwards, 1 within half of that distance.
        let nearness = smoothstep(2.0 * (1.0 - sun.distance_km / (zodiacal::NEAREST_AU * KM_PER_AU)));
        let corona_weight = corona::meter_weight(request, camera, self.meter.placed, sun, self.light.glare.as_ref());
        let outer_weight = if corona_weight > 0.0 { corona_weight * nearness.max(self.hidden_part_of_inner_corona(sun)) } else { 0.0 };
        if outer_weight <= 0.0 {
            return None;
        }
        let (to_sun, sin_sun_radius) = (sun.placement.centre_km / sun.distance_km, sun.body.radii_km.x / sun.distance_km);
        let inner_ray_weight = ray_weight_of_inner_corona(sin_sun_radius);
        let spacing = 2.0 * camera.tan_half_fov.length() / f64::from(FRAME_RAYS);
        let nearer = self.nearer_bodies(sun, spacing);
        let share = 1.0 / f64::from(FRAME_RAYS * FRAME_RAYS);
        let mut mean = LogMean::default();
        let fade_cosines = corona::fade_cosines(sun.distance_km);
        let drawn_part = |cosine: f64| fade_cosines.map_or(1.0, |[inner, outer]| smooth_rise((outer, inner), cosine));
        for ray in self.sample_frame(DVec3::normalize) {
            // As in shaders/entry/corona.wesl: distance in solar radii; in the hemisphere away from the Sun it keeps growing.
            let across = ray.cross(to_sun).length();
            let growing_across = if ray.dot(to_sun) > 0.0 { across } else { 2.0 - across };
            let rho = growing_across / sin_sun_radius;
            let ray_weight = if rho >= CORONA_RADII[1] { 1.0 } else { inner_ray_weight };
            if rho >= CORONA_RADII[0] && ray_weight > 0.0 {
                let visible_share = ray_weight * share * Self::ray_visibility(&nearer, ray, spacing);
                let radiance = corona::radiance(rho) * drawn_part(ray.dot(to_sun));
                mean.add(visible_share, radiance, self.foreground_radiance(ray, NaifId::SUN));
            }
        }
        let weight = outer_weight * if request.target == Some(NaifId::SUN) { SUN_WEIGHT } else { 1.0 };
        let no_body = None;
        let metered = mean.metered(reason!("subject-corona"), no_body, AUTO_EXPOSED_MEAN)?;
        Some(MeteredSubject { weight: metered.weight * weight, ..metered })
    }
}
