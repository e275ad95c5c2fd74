//! The shadow of rings on the ground near the camera, for the light meter.
//!
//! In: the rings' radial intervals of constant optical depth, the Sun, the camera. Out: the fraction of sunlight that the rings leave on the footprint of one
//! of the meter's rays, which is the part of the ground that the ray represents. The fraction changes gradually because it is a mean over the footprint and the
//! Sun's disc; this also holds at the equator, where the footprint reaches across the ring plane. If the camera is 3 radii or more from the body's centre, the
//! meter ignores the shadow: half of the globe is then in view, of which the shadow covers only a small part.

use super::MeteredFrame;
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// Distances of the camera from the body's centre, in body radii, between which the shadow fades out.
const FADE_RADII: (f64, f64) = (1.5, 3.0);

/// Ring-shine on ground in the rings' shadow, as a fraction of full sunlight. Measured in a drawn image, linear light, from 430 km above Saturn at 15 degrees
/// south, 1964-06-06: 1.1e-3.
const RING_SHINE_IN_SHADOW: f64 = 1e-3;

/// The shadow of rings on the ground of their body. Lengths in equatorial radii, body axes.
pub(super) struct RingShadowOnGround {
    /// Pairs, ascending: a radius in the ring plane, and the integral, up to this radius, of the fraction of sunlight that the rings block.
    blocked_up_to: Vec<[f64; 2]>,
    /// Unit vector towards the Sun.
    sun: DVec3,
    /// Tangent of the Sun's angular radius.
    sun_tangent: f64,
    /// The camera's position.
    camera: DVec3,
    /// Semi-axes of the body, in equatorial radii.
    semi_axes: DVec3,
    /// Weight of the shadow: less than 1 for a camera beyond the first of [`FADE_RADII`].
    weight: f64,
    /// Light on ground in complete shadow, as a fraction of full sunlight.
    light_in_shadow: f64,
}

impl RingShadowOnGround {
    /// Integral of the blocked fraction from the body's centre to a radius.
    fn blocked_within(&self, radius: f64) -> f64 {
        let edges = &self.blocked_up_to;
        match edges.partition_point(|[edge, _]| *edge <= radius) {
            0 => 0.0,
            k if k == edges.len() => edges[k - 1][1],
            k => {
                let ([from, below], [to, above]) = (edges[k - 1], edges[k]);
                below + (above - below) * (radius - from) / (to - from)
            }
        }
    }

    /// The fraction of sunlight that the rings leave at a point of the ground (unit-sphere frame), ring-shine included. `spacing`: angle between the meter's
    /// rays, radians.
    pub(super) fn transmittance(&self, point: DVec3, spacing: f64) -> f64 {
        let ground_point = point * self.semi_axes;
        let footprint_width = (spacing * (self.camera - ground_point).length()).max(1e-6);
        // Only ground beyond the ring plane, as seen from the Sun, is in shadow; near the equator this ground may be only a part of the footprint.
        let height_beyond_plane = -ground_point.z * self.sun.z.signum();
        let fraction_beyond = smoothstep(0.5 + height_beyond_plane / footprint_width);
        // Length of the path of sunlight from the ring plane to the ground.
        let from_ring_plane = height_beyond_plane.max(0.0) / self.sun.z.abs();
        if fraction_beyond <= 0.0 || !from_ring_plane.is_finite() {
            return 1.0;
        }
        let radius = (ground_point + self.sun * from_ring_plane).truncate().length();
        // A step on the ground moves the point in the ring plane by up to this many times the step's length.
        let stretch = 1.0 + self.sun.truncate().length() / self.sun.z.abs();
        let half_width = (0.5 * footprint_width * stretch + self.sun_tangent * from_ring_plane).max(1e-6);
        let blocked = (self.blocked_within(radius + half_width) - self.blocked_within(radius - half_width)) / (2.0 * half_width);
        1.0 - self.weight * fraction_beyond * blocked * (1.0 - self.light_in_shadow)
    }
}

impl MeteredFrame<'_, '_> {
    /// The shadow of a body's rings on its ground; `None` without rings, for a far camera, or if the user has switched the shadow off.
    pub(super) fn ring_shadow_on(&self, p: &PlacedBody<'_>) -> Option<RingShadowOnGround> {
        let unit_km = p.body.radii_km.x;
        let weight = 1.0 - smooth_rise(FADE_RADII, p.distance_km / unit_km);
        let user_choice = self.meter.context.request.effects.override_of_body(p.body, Effect::RingShadow);
        if weight <= 0.0 || p.body.rings.is_empty() || user_choice == Some(false) {
            return None;
        }
        let sun = (p.body_from_icrf * p.body_to_sun_km).normalize();
        let sun_tangent = crate::units::SUN_RADIUS_KM / p.body_to_sun_km.length();
        // The Sun's angular radius limits the slant, because its disc is never entirely in the ring plane.
        let slant = 1.0 / sun.z.abs().max(sun_tangent);
        let intervals = self.meter.context.caches.ring_tables.intervals(p.body.rings.iter(), unit_km);
        let (mut blocked_up_to, mut sum) = (Vec::with_capacity(2 * intervals.len()), 0.0);
        for interval in intervals.iter() {
            // `tau` is the optical depth along the normal.
            blocked_up_to.push([interval.inner, sum]);
            sum += (interval.outer - interval.inner) * (1.0 - (-interval.tau * slant).exp());
            blocked_up_to.push([interval.outer, sum]);
        }
        let camera = p.placement.body_from_icrf * -p.placement.centre_km / unit_km;
        let has_ring_shine = self.meter.context.request.effects.override_of_body(p.body, Effect::RingShine) != Some(false);
        let light_in_shadow = if has_ring_shine { RING_SHINE_IN_SHADOW } else { 0.0 };
        let semi_axes = p.body.radii_km / unit_km;
        Some(RingShadowOnGround { blocked_up_to, sun, sun_tangent, camera, semi_axes, weight, light_in_shadow })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0.5 rad south to 0.5 rad north, for a high and a low Sun on both sides of the ring plane: with steps an eighth as large, the largest change is less
    /// than a quarter, so there is no jump.
    #[test]
    fn the_shadow_changes_gradually_across_the_equator() {
        for (sin_sun_elevation, spacing) in [0.45, -0.2, 0.05].into_iter().flat_map(|s| [0.01, 0.1, 0.3].map(|spacing| (s, spacing))) {
            let rings = RingShadowOnGround {
                // Edges as those of Saturn's rings D, B, Cassini Division and A, with round integrals.
                blocked_up_to: vec![[1.1, 0.0], [1.52, 0.1], [1.95, 0.45], [2.03, 0.45], [2.27, 0.6]],
                sun: DVec3::new((1.0_f64 - sin_sun_elevation * sin_sun_elevation).sqrt(), 0.0, sin_sun_elevation),
                sun_tangent: 5e-4,
                camera: DVec3::new(1.3, 0.0, 0.02),
                semi_axes: DVec3::new(1.0, 1.0, 0.9),
                weight: 1.0,
                light_in_shadow: RING_SHINE_IN_SHADOW,
            };
            let largest_change = |steps: u32| {
                let angle = |k: u32| f64::from(k) / f64::from(steps) - 0.5;
                let all = (0..=steps).map(|k| rings.transmittance(DVec3::new(angle(k).cos(), 0.0, angle(k).sin()), spacing));
                let all: Vec<f64> = all.collect();
                assert!(all.iter().any(|t| *t < 0.8) && all.contains(&1.0), "{sin_sun_elevation} {spacing}: no shadow, or no light");
                all.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
            };
            let (of_coarse, of_fine) = (largest_change(800), largest_change(6400));
            assert!(of_fine < 0.25 * of_coarse, "{sin_sun_elevation} {spacing}: {of_coarse}, {of_fine} with smaller steps");
        }
    }
}
