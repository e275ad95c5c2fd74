//! The effect of rings on a body's total brightness: the light that they scatter to a viewer, and the fraction of the globe's light that they transmit.
//!
//! In: a ringed body, the directions to Sun and viewer in body axes. Out: [`RingLight`]. The light is computed as in shaders/lib/ring/photometry.wesl for a
//! point Sun and a distant viewer: single scattering by a flat layer that the globe and its shadow partly hide. tests/scene/magnitudes.rs compares it with
//! Mallama and Hilton 2018 (Astron. Comput. 25, 10, eq. 10, Saturn, tilts of 0 to 27 degrees, phase angles up to 6.5 degrees). Not modelled: light reflected
//! between globe and rings, the Sun's size.

use crate::catalog::Body;
use crate::scene::rings::phase::{MIN_COSINE, dust_phase, large_particle_phase};
use crate::scene::rings::ring_shine::scattered;
use crate::scene::rings::ring_table::{RingInterval, RingTables};
use crate::units::luminance;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Number of radii at which points of the rings are tested for being hidden or shadowed by the globe. With four times as many radii and azimuths the light of
/// the rings changes by less than 0.002 mag.
const RADII: usize = 24;
/// Number of azimuths tested at each radius.
const AZIMUTHS: usize = 72;
/// Number of grid points along each side of the square around the globe's disc, for the globe's light that the rings transmit.
const DISC_GRID: usize = 24;

/// Unit vectors in the rings' plane, at the middles of `AZIMUTHS` equal angles.
static DIRECTIONS: LazyLock<[DVec2; AZIMUTHS]> =
    LazyLock::new(|| std::array::from_fn(|k| DVec2::from_angle((k as f64 + 0.5) * TAU / AZIMUTHS as f64)));

/// The light of rings and their effect on the globe's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingLight {
    /// I/F integrated over the visible sunlit area of the rings as projected towards the viewer, divided by pi and the squared equatorial radius. It
    /// corresponds to the globe's geometric albedo times its phase function.
    pub ring_albedo: f64,
    /// Fraction of the globe's light that is neither in the rings' shadow nor hidden by them.
    pub globe_light_fraction: f64,
}

impl RingLight {
    /// The value for a body without rings.
    pub(crate) const NONE: Self = Self { ring_albedo: 0.0, globe_light_fraction: 1.0 };

    /// `sun` and `viewer`: unit vectors from the body's centre, body axes.
    pub(crate) fn of(tables: &RingTables, body: &Body, sun: DVec3, viewer: DVec3) -> Self {
        let unit_km = body.radii_km.x;
        if body.rings.iter().all(|r| r.tau_normal <= 0.0) {
            return Self::NONE;
        }
        let intervals = tables.intervals(body.rings.iter(), unit_km);
        let (Some(first), Some(last)) = (intervals.first(), intervals.last()) else { return Self::NONE };
        // Cosines of emission and of incidence.
        let (mu, mu0) = (viewer.z.abs().max(MIN_COSINE), sun.z.abs().max(MIN_COSINE));
        let is_same_side = viewer.z * sun.z > 0.0;
        let globe = Globe { axes: body.radii_km / unit_km };
        let (innermost, width) = (first.inner, (last.outer - first.inner) / RADII as f64);
        let visible_fractions: Vec<f64> =
            (0..RADII).map(|k| globe.visible_fraction(innermost + (k as f64 + 0.5) * width, sun, viewer)).collect();
        let visible_at = |r: f64| visible_fractions[(((r - innermost) / width) as usize).min(RADII - 1)];
        let cos_phase = sun.dot(viewer).clamp(-1.0, 1.0);
        let (large_particle_phase, dust_phase) = (large_particle_phase(cos_phase), dust_phase(cos_phase.acos()));
        let reflected = |interval: &RingInterval| {
            let scattered = scattered(interval.tau, 1.0 / mu, 1.0 / mu0, is_same_side);
            let area = PI * (interval.outer - interval.inner) * (interval.outer + interval.inner) * viewer.z.abs();
            let phase = large_particle_phase * (1.0 - interval.dust_fraction) + dust_phase * interval.dust_fraction;
            0.25 * phase * luminance(interval.albedo) * scattered * area * visible_at(0.5 * (interval.inner + interval.outer))
        };
        let ring_albedo = if sun.z == 0.0 { 0.0 } else { intervals.iter().map(reflected).sum::<f64>() / PI };
        Self { ring_albedo, globe_light_fraction: globe.transmitted_fraction(&intervals, sun, viewer) }
    }
}

/// The globe, lengths in its equatorial radii.
struct Globe {
    /// Semi-axes.
    axes: DVec3,
}

impl Globe {
    /// Fraction of a circle in the rings' plane, with this radius, from which neither the Sun nor the viewer is hidden by the globe.
    fn visible_fraction(&self, radius: f64, sun: DVec3, viewer: DVec3) -> f64 {
        // The globe as a unit sphere: coordinates divided by its semi-axes.
        let circle_axes = DVec2::splat(radius) / self.axes.truncate();
        let [sun, viewer] = [sun, viewer].map(|towards| towards / self.axes);
        let [sun_sq, viewer_sq] = [sun, viewer].map(DVec3::length_squared);
        let is_visible = |direction: &&DVec2| {
            let point = **direction * circle_axes;
            let radius_sq_minus_1 = point.length_squared() - 1.0;
            let is_blocked = |towards: DVec2, towards_sq: f64| {
                let along = point.dot(towards);
                along < 0.0 && along * along > towards_sq * radius_sq_minus_1
            };
            !is_blocked(sun.truncate(), sun_sq) && !is_blocked(viewer.truncate(), viewer_sq)
        };
        DIRECTIONS.iter().filter(is_visible).count() as f64 / AZIMUTHS as f64
    }

    /// Fraction of a Lambert globe's light that the rings transmit, both on the way from the Sun and on the way to the viewer.
    fn transmitted_fraction(&self, intervals: &[RingInterval], sun: DVec3, viewer: DVec3) -> f64 {
        let (across, up) = viewer.any_orthonormal_pair();
        let (mut reflected, mut transmitted) = (0.0, 0.0);
        for k in 0..DISC_GRID * DISC_GRID {
            let [x, y] = [k % DISC_GRID, k / DISC_GRID].map(|i| 2.0 * (i as f64 + 0.5) / DISC_GRID as f64 - 1.0);
            // The globe is intersected as a unit sphere: coordinates divided by its semi-axes.
            let plane_point = (across * x + up * y) / self.axes;
            let towards = viewer / self.axes;
            let (a, b, c) = (towards.length_squared(), plane_point.dot(towards), plane_point.length_squared() - 1.0);
            if b * b <= a * c {
                continue;
            }
            let hit = plane_point + towards * ((-b + (b * b - a * c).sqrt()) / a);
            let normal = (hit / self.axes).normalize();
            let point = hit * self.axes;
            let light = normal.dot(sun);
            if light <= 0.0 {
                continue;
            }
            reflected += light;
            transmitted += light * transmittance(intervals, point, sun) * transmittance(intervals, point, viewer);
        }
        if reflected > 0.0 { transmitted / reflected } else { 1.0 }
    }
}

/// Transmittance of the rings along an endless ray from a point: 1 if the ray does not cross the rings. Body axes; lengths in equatorial radii; `towards` is a
/// unit vector.
pub(crate) fn transmittance(intervals: &[RingInterval], point: DVec3, towards: DVec3) -> f64 {
    if point.z * towards.z >= 0.0 {
        return 1.0;
    }
    let radius = (point - towards * (point.z / towards.z)).truncate().length();
    let index = intervals.partition_point(|interval| interval.outer <= radius);
    intervals
        .get(index)
        .filter(|interval| interval.inner <= radius)
        .map_or(1.0, |interval| (-interval.tau / towards.z.abs().max(MIN_COSINE)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};

    fn direction(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
        let (lat, lon) = (latitude_deg.to_radians(), longitude_deg.to_radians());
        DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
    }

    #[test]
    fn rings_seen_edge_on_add_almost_nothing_and_a_body_without_rings_is_unchanged() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("Saturn");
        let edge_on = RingLight::of(&RingTables::default(), saturn, direction(10.0, 0.0), direction(0.0, 3.0));
        assert!(edge_on.ring_albedo < 1e-3 && edge_on.globe_light_fraction > 0.5, "{edge_on:?}");
        let moon = catalog.body(NaifId(301)).expect("the Moon");
        assert_eq!(RingLight::of(&RingTables::default(), moon, DVec3::X, DVec3::X), RingLight::NONE);
    }

    #[test]
    fn more_open_rings_add_more_light() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("Saturn");
        let ring_albedo: Vec<f64> = (0..=9)
            .map(|k| {
                RingLight::of(&RingTables::default(), saturn, direction(3.0 * f64::from(k), 0.0), direction(3.0 * f64::from(k), 2.0))
                    .ring_albedo
            })
            .collect();
        assert!(ring_albedo.windows(2).all(|w| w[1] > w[0]), "{ring_albedo:?}");
        assert!(ring_albedo[9] > 0.2, "{ring_albedo:?}");
    }
}
