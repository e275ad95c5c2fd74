//! The fraction of sunlight that rings block at single points of their body.
//!
//! In: the rings' geometry. Out: the fraction, for the Sun as a point. Not here: the shadow that pixels show (shaders/lib/ring) and that of the light meter
//! (`light::meter`), which are means over the Sun's disc.

use crate::scene::rings::ring_table::RingInterval;
use crate::scene::rings::view::RingView;
use glam::DVec3;
use std::sync::Arc;

/// The shadow of all rings of a body.
pub(crate) struct ShadowAtPoints {
    intervals: Arc<Vec<RingInterval>>,
    /// Unit vector to the Sun, body axes.
    sun: DVec3,
}

impl ShadowAtPoints {
    pub(crate) fn of(view: &RingView<'_>) -> Self {
        Self { intervals: view.caches.ring_tables.intervals(view.body.rings.iter(), view.body.radii_km.x), sun: view.sun }
    }

    /// The fraction of sunlight that the rings block at a point. `point`: body axes, equatorial radii.
    pub(crate) fn blocked(&self, point: DVec3) -> f64 {
        // Sunlight passes the ring plane only on its way to points beyond that plane.
        let to_plane = -point.z / self.sun.z;
        if to_plane.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) || !to_plane.is_finite() {
            return 0.0;
        }
        let radius = (point + self.sun * to_plane).truncate().length();
        let interval = self.intervals.iter().find(|i| i.inner <= radius && radius < i.outer);
        interval.map_or(0.0, |i| -(-i.tau / self.sun.z.abs()).exp_m1())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the Sun 30 degrees above the ring plane, light goes through twice the optical depth. Points on the sunlit side of the plane, and points whose light
    /// passes inside or outside the ring, are not in shadow.
    #[test]
    fn only_points_whose_light_passes_the_ring_are_in_shadow() {
        let ring = RingInterval { inner: 1.5, outer: 2.0, tau: 0.4, albedo: [0.0; 3], dust_fraction: 0.0 };
        let sun = DVec3::new(0.75_f64.sqrt(), 0.0, 0.5);
        let shadow = ShadowAtPoints { intervals: Arc::new(vec![ring]), sun };
        // A point from which sunlight passes the plane at this radius, 0.3 below the plane.
        let below = |radius: f64| DVec3::X * radius - sun * 0.6;
        assert!((shadow.blocked(below(1.7)) - (1.0 - (-0.8_f64).exp())).abs() < 1e-12);
        assert_eq!([below(1.4), below(2.1), DVec3::X * 1.7 + sun * 0.6, DVec3::X * 1.7].map(|p| shadow.blocked(p)), [0.0; 4]);
    }
}
