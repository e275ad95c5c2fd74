//! The shadow of rings on the ground near the camera, for the light meter.
//!
//! In: the rings' intervals, the Sun, the camera. Out: the fraction of sunlight that the rings leave on the part of the ground that one ray of the meter stands for.
//! It changes gradually, because it is a mean over the ray's footprint and the Sun's disc; at the equator it may step, where footprints reach across the ring
//! plane. From 3 radii on there is no shadow: the entire disc is in view, of which the
//! shadow covers a small part.

use super::MeteredFrame;
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// Distances of the camera in body radii between which the shadow fades out.
const FADE_RADII: [f64; 2] = [1.5, 3.0];

/// Light of the rings themselves on ground in their shadow, as a fraction of full sunlight. An image from 430 km above Saturn at 15 degrees south, 1964-06-06,
/// has 1.1e-3 in linear light.
const RING_SHINE_IN_SHADOW: f64 = 1e-3;

/// Rings between the Sun and the ground of their body. Lengths in equatorial radii, body axes.
pub(super) struct RingShadowOnGround {
    /// Radii in the ring plane, ascending, and the integral of the blocked fraction of sunlight over the radius up to each.
    blocked_up_to: Vec<[f64; 2]>,
    /// Towards the Sun.
    sun: DVec3,
    /// Tangent of the Sun's angular radius.
    sun_tangent: f64,
    camera: DVec3,
    /// Body radii per equatorial radius.
    semi_axes: DVec3,
    weight: f64,
    /// Fraction of full sunlight that reaches ground in complete shadow.
    darkest: f64,
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

    /// The fraction of sunlight that the rings leave at a point, their own light included, of the ground (unit-sphere frame). `spacing`: angle between the meter's rays.
    pub(super) fn transmittance(&self, point: DVec3, spacing: f64) -> f64 {
        let ground = point * self.semi_axes;
        let to_ring_plane = -ground.z / self.sun.z;
        if !(to_ring_plane > 0.0 && to_ring_plane.is_finite()) {
            return 1.0;
        }
        let radius = (ground + self.sun * to_ring_plane).truncate().length();
        // A step on the ground moves the point in the ring plane by up to this factor.
        let stretch = 1.0 + self.sun.truncate().length() / self.sun.z.abs();
        let footprint = spacing * (self.camera - ground).length();
        let half_width = (0.5 * footprint * stretch + self.sun_tangent * to_ring_plane).max(1e-6);
        let blocked = (self.blocked_within(radius + half_width) - self.blocked_within(radius - half_width)) / (2.0 * half_width);
        1.0 - self.weight * blocked * (1.0 - self.darkest)
    }
}

impl MeteredFrame<'_, '_> {
    /// The shadow of a body's rings on its ground, unless the camera is far or the user has switched the shadow off.
    pub(super) fn ring_shadow_on(&self, p: &PlacedBody<'_>) -> Option<RingShadowOnGround> {
        let unit_km = p.body.radii_km.x;
        let [near, far] = FADE_RADII;
        let weight = 1.0 - smoothstep((p.distance_km / unit_km - near) / (far - near));
        let user_choice = self.meter.context.request.effects.override_of_body(p.body, Effect::RingShadow);
        if weight <= 0.0 || p.body.rings.is_empty() || user_choice == Some(false) {
            return None;
        }
        let sun = (p.body_from_icrf * p.sun_from_body_km).normalize();
        let sun_tangent = crate::units::SUN_RADIUS_KM / p.sun_from_body_km.length();
        let slant = 1.0 / sun.z.abs().max(sun_tangent);
        let intervals = self.meter.context.caches.ring_tables.intervals(p.body.rings.iter(), unit_km);
        let (mut blocked_up_to, mut sum) = (Vec::with_capacity(2 * intervals.len()), 0.0);
        for interval in intervals.iter() {
            blocked_up_to.push([interval.from, sum]);
            sum += (interval.to - interval.from) * (1.0 - (-interval.tau * slant).exp());
            blocked_up_to.push([interval.to, sum]);
        }
        let camera = p.placement.body_from_icrf * -p.placement.centre_km / unit_km;
        let has_ring_shine = self.meter.context.request.effects.override_of_body(p.body, Effect::RingShine) != Some(false);
        let darkest = if has_ring_shine { RING_SHINE_IN_SHADOW } else { 0.0 };
        let semi_axes = p.body.radii_km / unit_km;
        Some(RingShadowOnGround { blocked_up_to, sun, sun_tangent, camera, semi_axes, weight, darkest })
    }
}
