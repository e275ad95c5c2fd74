//! The effect of rings on a body's total brightness: the light that they scatter to a viewer, the fraction of the globe's light that they transmit, and the
//! light that they scatter onto the globe (ring-shine).
//!
//! In: a ringed body, the directions to Sun and viewer in body axes. Out: [`RingLight`], [`seen_ring_shine`], and the [`transmittance`] along a ray. The light
//! is computed as in shaders/lib/ring/photometry.wesl for a point Sun and a distant viewer: single scattering by a flat layer that the globe and its shadow
//! partly hide. tests/scene/magnitudes.rs compares it with Mallama and Hilton 2018 (Astron. Comput. 25, 10, eq. 10, Saturn, tilts of 0 to 27 degrees, phase
//! angles up to 6.5 degrees). Not modelled: the globe's light on the rings, the Sun's size.

use crate::catalog::Body;
use crate::scene::draw::tables::RingShine;
use crate::scene::rings::phase::{MIN_COSINE, dust_phase, large_particle_phase};
use crate::scene::rings::ring_shine::scattered;
use crate::scene::rings::ring_table::{RingInterval, RingTables};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// Number of radii at which points of the rings are tested for being hidden or shadowed by the globe. With four times as many radii and azimuths the light of
/// the rings changes by less than 0.002 mag.
const RADIUS_COUNT: usize = 24;
/// Number of azimuths tested at each radius.
const AZIMUTH_COUNT: usize = 72;
/// Numbers of cells across and along the lit and visible part of the globe, a lune, for the globe's light that the rings transmit. There are more along the
/// lune, because the edges of shadows mostly run across it. The error of the fraction is at most 0.025 (test below); mostly it is below 0.005.
const LUNE_COLUMNS: usize = 12;
const LUNE_ROWS: usize = 48;
/// Rings that block less light than opaque rings of this width, in equatorial radii, count as transparent; it is compared with the sum for the way from the Sun
/// and the way to the viewer. Such rings take at most 0.006 of the globe's light (Uranus; Neptune 0.0002, Jupiter less) at phase angles up to 175 degrees (test
/// below).
const MIN_BLOCKED_WIDTH: f64 = 0.015;
/// Smallest extent in radius over which transmittance is averaged, equatorial radii: it keeps the division by the extent accurate.
const MIN_EXTENT: f64 = 1e-6;

/// Numbers of cells along and across the meridians of the globe, for its ring-shine. A grid eight times as fine changes the light by up to 4 %.
const SHINE_ROWS: usize = 24;
const SHINE_COLUMNS: usize = 48;
/// Phase angles between which ring-shine fades in, both in the light of a body drawn as a point and in the light meter: at the first a quarter of the disc is
/// dark, at the second more than half. At smaller phase angles ring-shine is at most a hundredth of Saturn's light.
pub(crate) const SHINE_FADE_IN_RAD: (f64, f64) = (1.0, 1.7);

/// Unit vectors in the rings' plane, at the middles of `AZIMUTH_COUNT` equal angles.
static DIRECTIONS: LazyLock<[DVec2; AZIMUTH_COUNT]> =
    LazyLock::new(|| std::array::from_fn(|k| DVec2::from_angle((k as f64 + 0.5) * TAU / AZIMUTH_COUNT as f64)));

/// The light of rings and their effect on the globe's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingLight {
    /// I/F (radiance relative to that of a white Lambert plane that faces the Sun), integrated over the visible sunlit area of the rings as projected towards
    /// the viewer, divided by pi and the squared equatorial radius, linear RGB. It corresponds to the globe's geometric albedo times its phase function.
    pub ring_albedo: DVec3,
    /// Fraction of the globe's light that is neither in the rings' shadow nor hidden by them.
    pub globe_light_fraction: f64,
}

impl RingLight {
    /// The value for a body without rings.
    pub(crate) const NONE: Self = Self { ring_albedo: DVec3::ZERO, globe_light_fraction: 1.0 };

    /// The light of a body's rings. `sun` and `viewer`: unit vectors from the body's centre, body axes.
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
        let (innermost, radius_step) = (first.inner, (last.outer - first.inner) / RADIUS_COUNT as f64);
        let lit_and_seen_fractions: Vec<f64> =
            (0..RADIUS_COUNT).map(|k| globe.lit_and_seen_fraction(innermost + (k as f64 + 0.5) * radius_step, sun, viewer)).collect();
        let lit_and_seen_at = |r: f64| lit_and_seen_fractions[(((r - innermost) / radius_step) as usize).min(RADIUS_COUNT - 1)];
        let cos_phase = sun.dot(viewer).clamp(-1.0, 1.0);
        let (large_particle_phase, dust_phase) = (large_particle_phase(cos_phase), dust_phase(cos_phase.acos()));
        let scattered_to_viewer = |interval: &RingInterval| {
            let scattered = scattered(interval.tau, 1.0 / mu, 1.0 / mu0, is_same_side);
            let area = PI * (interval.outer - interval.inner) * (interval.outer + interval.inner) * viewer.z.abs();
            let phase = large_particle_phase * (1.0 - interval.dust_fraction) + dust_phase * interval.dust_fraction;
            // `scattered` leaves out the albedo and a quarter of the phase function.
            let of_white = 0.25 * phase * scattered * area * lit_and_seen_at(0.5 * (interval.inner + interval.outer));
            DVec3::from_array(interval.albedo) * of_white
        };
        // A Sun exactly in the plane lights neither side.
        let ring_albedo = if sun.z == 0.0 { DVec3::ZERO } else { intervals.iter().map(scattered_to_viewer).sum::<DVec3>() / PI };
        Self { ring_albedo, globe_light_fraction: globe.transmitted_fraction(&intervals, sun, viewer) }
    }
}

/// Ring-shine on the globe as a distant viewer sees it past the rings: the irradiance of the ground per unit of sunlight, integrated over the visible part of
/// the globe as projected towards the viewer, divided by pi and the squared equatorial radius, linear RGB. `sun` and `viewer`: unit vectors from the body's
/// centre, body axes.
pub(crate) fn seen_ring_shine(tables: &RingTables, body: &Body, shine: &RingShine, sun: DVec3, viewer: DVec3) -> DVec3 {
    let globe = Globe { axes: body.radii_km / body.radii_km.x };
    let intervals = tables.intervals(body.rings.iter(), body.radii_km.x);
    globe.seen_ring_shine(shine, &RingPath::new(&intervals, viewer), sun)
}

/// The globe, lengths in its equatorial radii.
struct Globe {
    /// Semi-axes.
    axes: DVec3,
}

impl Globe {
    /// Fraction of a circle in the rings' plane, with this radius, from which neither the Sun nor the viewer is hidden by the globe.
    fn lit_and_seen_fraction(&self, radius: f64, sun: DVec3, viewer: DVec3) -> f64 {
        // The globe as a unit sphere: coordinates divided by its semi-axes.
        let circle_axes = DVec2::splat(radius) / self.axes.truncate();
        let [sun, viewer] = [sun, viewer].map(|towards| towards / self.axes);
        let [sun_sq, viewer_sq] = [sun, viewer].map(DVec3::length_squared);
        let is_lit_and_seen = |direction: &&DVec2| {
            let point = **direction * circle_axes;
            let radius_sq_minus_1 = point.length_squared() - 1.0;
            // Whether the ray from the point, which has z = 0, meets the unit sphere: the condition that the quadratic equation has a solution ahead.
            let is_blocked = |towards: DVec2, towards_sq: f64| {
                let along = point.dot(towards);
                along < 0.0 && along * along > towards_sq * radius_sq_minus_1
            };
            !is_blocked(sun.truncate(), sun_sq) && !is_blocked(viewer.truncate(), viewer_sq)
        };
        DIRECTIONS.iter().filter(is_lit_and_seen).count() as f64 / AZIMUTH_COUNT as f64
    }

    /// See [`seen_ring_shine`]. The cells are equal steps of the unit sphere's latitude and of the hour angle from the Sun. `path`: in the viewer's direction.
    fn seen_ring_shine(&self, shine: &RingShine, path: &RingPath<'_>, sun: DVec3) -> DVec3 {
        let noon = sun.truncate().try_normalize().unwrap_or(DVec2::X);
        let (cell_height_rad, cell_width_rad) = (PI / SHINE_ROWS as f64, TAU / SHINE_COLUMNS as f64);
        let mut sum = DVec3::ZERO;
        for row in 0..SHINE_ROWS {
            let (sin_latitude, cos_latitude) = ((row as f64 + 0.5) * cell_height_rad - 0.5 * PI).sin_cos();
            for column in 0..SHINE_COLUMNS {
                let meridian = DVec2::from_angle((column as f64 + 0.5) * cell_width_rad).rotate(noon);
                let unit_point = (meridian * cos_latitude).extend(sin_latitude);
                // Area of the globe as projected towards the viewer, per area of the unit sphere. The globe is the unit sphere stretched by `axes`, and
                // `unit_point / axes` is normal to the globe (Nanson's formula).
                let projected_area = self.axes.element_product() * (unit_point / self.axes).dot(path.towards);
                if projected_area <= 0.0 {
                    continue;
                }
                let east = (meridian.perp() * (cell_width_rad * cos_latitude)).extend(0.0);
                let north = (meridian * -sin_latitude).extend(cos_latitude) * cell_height_rad;
                let transmittance = path.mean_transmittance(unit_point * self.axes, [east, north].map(|edge| edge * self.axes));
                sum += shine.irradiance_rgb(unit_point, sun) * (projected_area * transmittance * cos_latitude);
            }
        }
        sum * (cell_width_rad * cell_height_rad / PI)
    }

    /// Fraction of a Lambert globe's light that the rings transmit, both on the way from the Sun and on the way to the viewer. The lit and visible part of the
    /// globe, a lune of the unit sphere, is cut into `LUNE_COLUMNS` times `LUNE_ROWS` cells; in each the transmittance is the mean over the cell's extent in
    /// radius of the rings.
    fn transmitted_fraction(&self, intervals: &[RingInterval], sun: DVec3, viewer: DVec3) -> f64 {
        // The globe as a unit sphere: coordinates divided by its semi-axes. Great circles bound its lit and its visible half.
        let [to_sun, to_viewer] = [sun, viewer].map(|towards| (towards / self.axes).normalize());
        let (sum, difference) = (to_sun + to_viewer, to_viewer - to_sun);
        let Some(middle) = sum.try_normalize() else { return 1.0 };
        let side = difference.try_normalize().unwrap_or_else(|| middle.any_orthonormal_vector());
        let pole = side.cross(middle);
        // (pi - phase angle) / 2, for the directions in the frame of the unit sphere.
        let half_width_rad = sum.length().atan2(difference.length());
        let paths = [sun, viewer].map(|towards| RingPath::new(intervals, towards));
        // The rings of Jupiter, Uranus and Neptune change almost nothing.
        if paths.iter().map(RingPath::blocked_width).sum::<f64>() < MIN_BLOCKED_WIDTH {
            return 1.0;
        }
        let (cell_width_rad, cell_height_rad) = (2.0 * half_width_rad / LUNE_COLUMNS as f64, PI / LUNE_ROWS as f64);
        // For each column: unit vectors outwards and to the east, on the lune's equator.
        let meridians: [[DVec3; 2]; LUNE_COLUMNS] = std::array::from_fn(|k| {
            let (sin, cos) = ((k as f64 + 0.5) * cell_width_rad - half_width_rad).sin_cos();
            [middle * cos + side * sin, side * cos - middle * sin]
        });
        let (mut reflected, mut transmitted) = (0.0, 0.0);
        for row in 0..LUNE_ROWS {
            let (sin_latitude, cos_latitude) = ((row as f64 + 0.5) * cell_height_rad - 0.5 * PI).sin_cos();
            for [outward, east] in meridians {
                let unit_point = outward * cos_latitude + pole * sin_latitude;
                let north = pole * cos_latitude - outward * sin_latitude;
                let normal = (unit_point / self.axes).normalize();
                // The cell's projected area is proportional to its cosine towards the viewer on the unit sphere, and to `cos_latitude`.
                let light = normal.dot(sun).max(0.0) * unit_point.dot(to_viewer).max(0.0) * cos_latitude;
                let cell = [east * (cell_width_rad * cos_latitude), north * cell_height_rad].map(|edge| edge * self.axes);
                if light == 0.0 {
                    continue;
                }
                reflected += light;
                transmitted += paths.iter().fold(light, |light, path| light * path.mean_transmittance(unit_point * self.axes, cell));
            }
        }
        if reflected > 0.0 { transmitted / reflected } else { 1.0 }
    }
}

/// Parallel paths through the rings.
struct RingPath<'a> {
    intervals: &'a [RingInterval],
    /// Unit vector along the paths, body axes.
    towards: DVec3,
    /// Transmittance of each interval.
    transmittances: Vec<f64>,
    /// Integral of the transmittance over the radius from the inner edge of the first interval to that of each interval; the last element is the integral over
    /// all intervals.
    integrals: Vec<f64>,
}

impl<'a> RingPath<'a> {
    fn new(intervals: &'a [RingInterval], towards: DVec3) -> Self {
        let transmittances: Vec<f64> = intervals.iter().map(|interval| transmittance_of(interval, towards)).collect();
        let mut integral = 0.0;
        let mut integrals = vec![integral];
        for (interval, transmittance) in intervals.iter().zip(&transmittances) {
            integral += (interval.outer - interval.inner) * transmittance;
            integrals.push(integral);
        }
        Self { intervals, towards, transmittances, integrals }
    }

    /// Width of opaque rings that would block as much light.
    fn blocked_width(&self) -> f64 {
        let width = self.intervals.first().zip(self.intervals.last()).map_or(0.0, |(first, last)| last.outer - first.inner);
        width - self.integrals.last().copied().unwrap_or(0.0)
    }

    /// Integral of the transmittance over the radius, from the inner edge of the first interval; negative inside this edge. Without intervals it is the radius,
    /// because the transmittance is 1.
    fn integral_to(&self, radius: f64) -> f64 {
        let index = self.intervals.partition_point(|interval| interval.outer <= radius);
        let (Some(first), Some(last)) = (self.intervals.first(), self.intervals.last()) else { return radius };
        match self.intervals.get(index) {
            _ if radius <= first.inner => radius - first.inner,
            Some(interval) => self.integrals[index] + (radius - interval.inner) * self.transmittances[index],
            None => self.integrals[index] + radius - last.outer,
        }
    }

    /// Mean transmittance on the paths from the points of a cell of the globe. `point`: the middle of the cell; `cell`: its sides. Lengths in equatorial radii.
    /// The radius at which the paths cross the rings counts as linear over the cell, and its distribution is replaced by a uniform one of the same variance.
    fn mean_transmittance(&self, point: DVec3, cell: [DVec3; 2]) -> f64 {
        if self.towards.z == 0.0 {
            return 1.0;
        }
        // Length of the path to the rings' plane; below 0 for a point beyond the plane.
        let length = -point.z / self.towards.z;
        if length < 0.0 && point.z.abs() >= 0.5 * (cell[0].z.abs() + cell[1].z.abs()) {
            // The entire cell is beyond the plane.
            return 1.0;
        }
        let point_outward = point.truncate().normalize_or_zero();
        let crossing = (point + self.towards * length).truncate();
        // A cell whose middle is beyond the plane may have points on the other side, from which the paths cross the plane just outside the globe's equator. For
        // such a cell the radius is that of the middle's path, continued backwards to the plane, to first order. Paths that run inwards cross the plane within
        // the globe.
        let outward = if length > 0.0 { crossing.normalize_or_zero() } else { point_outward };
        let outward_cosine = outward.dot(self.towards.truncate());
        let radius = if length > 0.0 {
            crossing.length()
        } else if outward_cosine > 0.0 {
            point.truncate().length() + length * outward_cosine
        } else {
            return 1.0;
        };
        // The dot product of this vector with a displacement of the point is the change of the radius at which the path crosses the plane.
        let gradient = outward.extend(-outward_cosine / self.towards.z);
        let half_width = 0.5 * DVec2::from_array(cell.map(|side| gradient.dot(side))).length().max(MIN_EXTENT);
        let (from, to) = (radius - half_width, radius + half_width);
        let (Some(first), Some(last)) = (self.intervals.first(), self.intervals.last()) else { return 1.0 };
        if to <= first.inner || from >= last.outer { 1.0 } else { (self.integral_to(to) - self.integral_to(from)) / (to - from) }
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
    intervals.get(index).filter(|interval| interval.inner <= radius).map_or(1.0, |interval| transmittance_of(interval, towards))
}

/// Transmittance of an interval along a path. `towards`: unit vector along the path.
fn transmittance_of(interval: &RingInterval, towards: DVec3) -> f64 {
    (-interval.tau / towards.z.abs().max(MIN_COSINE)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::units::luminance;

    fn direction(latitude_deg: f64, longitude_deg: f64) -> DVec3 {
        let (lat, lon) = (latitude_deg.to_radians(), longitude_deg.to_radians());
        DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
    }

    #[test]
    fn rings_seen_edge_on_add_almost_nothing_and_a_body_without_rings_is_unchanged() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("Saturn");
        let edge_on = RingLight::of(&RingTables::default(), saturn, direction(10.0, 0.0), direction(0.0, 3.0));
        assert!(edge_on.ring_albedo.max_element() < 1e-3 && edge_on.globe_light_fraction > 0.5, "{edge_on:?}");
        let moon = catalog.body(NaifId(301)).expect("the Moon");
        assert_eq!(RingLight::of(&RingTables::default(), moon, DVec3::X, DVec3::X), RingLight::NONE);
    }

    #[test]
    fn more_open_rings_add_more_light() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("Saturn");
        let ring_albedo: Vec<f64> = (0..=9)
            .map(|k| {
                let [sun, viewer] = [0.0, 2.0].map(|longitude_deg| direction(3.0 * f64::from(k), longitude_deg));
                luminance(RingLight::of(&RingTables::default(), saturn, sun, viewer).ring_albedo.to_array())
            })
            .collect();
        assert!(ring_albedo.windows(2).all(|w| w[1] > w[0]), "{ring_albedo:?}");
        assert!(ring_albedo[9] > 0.2, "{ring_albedo:?}");
    }

    /// Irradiance |z|, the distance from the equator's plane in the unit-sphere frame, against closed forms: its integral over the disc, divided by pi, is 2/3
    /// seen from the pole, whatever the flattening, and 4/(3 pi) seen from the equator of a sphere.
    #[test]
    fn seen_ring_shine_is_the_integral_over_the_visible_globe() {
        use crate::scene::rings::ring_shine::{COLUMNS, ROWS};
        // The table contains irradiance divided by |z|.
        let shine = RingShine { texels: vec![1.0; 2 * ROWS * COLUMNS * 4], max_height: 1.0, brightest: 1.0 };
        let sun = direction(20.0, 40.0);
        let seen = |polar_radius: f64, intervals: &[RingInterval], viewer: DVec3| {
            let globe = Globe { axes: DVec3::new(1.0, 1.0, polar_radius) };
            globe.seen_ring_shine(&shine, &RingPath::new(intervals, viewer), sun).x
        };
        let expected = [2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 4.0 / (3.0 * PI)];
        let found = [seen(1.0, &[], DVec3::Z), seen(0.5, &[], DVec3::Z), seen(0.5, &[], DVec3::NEG_Z), seen(1.0, &[], DVec3::X)];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
        }
        // Opaque rings hide a part of the half of the globe beyond their plane, but nothing from straight above.
        let opaque = [RingInterval { inner: 1.0, outer: 9.0, tau: 50.0, albedo: [0.0; 3], dust_fraction: 0.0 }];
        let oblique = direction(40.0, 10.0);
        let [open, hidden] = [&opaque[..0], &opaque[..]].map(|intervals| seen(0.9, intervals, oblique));
        assert!(hidden > 0.5 * open && hidden < 0.97 * open, "{hidden} of {open}");
        assert!((seen(1.0, &opaque, DVec3::Z) / expected[0] - 1.0).abs() < 0.02);
    }

    /// [`Globe::transmitted_fraction`] by many points of the square around the globe's disc, each with the transmittance at this point.
    fn transmitted_fraction_by_points(globe: &Globe, intervals: &[RingInterval], sun: DVec3, viewer: DVec3, points_per_side: u32) -> f64 {
        let (across, up) = viewer.any_orthonormal_pair();
        let (mut reflected, mut transmitted) = (0.0, 0.0);
        for k in 0..points_per_side * points_per_side {
            let [x, y] = [k % points_per_side, k / points_per_side].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(points_per_side) - 1.0);
            let plane_point = (across * x + up * y) / globe.axes;
            let towards = viewer / globe.axes;
            let (a, b, c) = (towards.length_squared(), plane_point.dot(towards), plane_point.length_squared() - 1.0);
            if b * b <= a * c {
                continue;
            }
            let hit = plane_point + towards * ((-b + (b * b - a * c).sqrt()) / a);
            let light = (hit / globe.axes).normalize().dot(sun).max(0.0);
            let point = hit * globe.axes;
            reflected += light;
            transmitted += light * transmittance(intervals, point, sun) * transmittance(intervals, point, viewer);
        }
        if reflected > 0.0 { transmitted / reflected } else { 1.0 }
    }

    /// Rings that count as transparent: the light that they take, by many points, from all sides at phase angles up to 175 degrees.
    #[test]
    fn narrow_rings_take_little_of_the_light_of_their_globe() {
        let catalog = Catalog::embedded();
        let mut random = crate::random::Random::new(7);
        for id in [599, 799, 899] {
            let planet = catalog.body(NaifId(id)).expect("in the catalog");
            let intervals = RingTables::default().intervals(planet.rings.iter(), planet.radii_km.x);
            let globe = Globe { axes: planet.radii_km / planet.radii_km.x };
            let (mut largest, mut non_transparent_count) = (0.0_f64, 0);
            for _ in 0..400 {
                let (sun, viewer) = (random.direction(), random.direction());
                if crate::ephemeris::angle_rad(sun, viewer) > 175_f64.to_radians() {
                    continue;
                }
                let fraction = globe.transmitted_fraction(&intervals, sun, viewer);
                let error = fraction - transmitted_fraction_by_points(&globe, &intervals, sun, viewer, 300);
                largest = largest.max(error.abs());
                non_transparent_count += i32::from(fraction < 1.0);
            }
            println!("{id}: {largest:.4}; not transparent {non_transparent_count} times");
            assert!(largest < 0.01, "{id}: {largest}");
        }
    }

    /// Saturn from many sides, in small steps of latitude: the error, and how much it differs from one step to the next.
    #[test]
    fn the_light_of_the_globe_behind_rings_is_accurate_and_does_not_flicker() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("Saturn");
        let intervals = RingTables::default().intervals(saturn.rings.iter(), saturn.radii_km.x);
        let globe = Globe { axes: saturn.radii_km / saturn.radii_km.x };
        let (mut flicker_of_few_points, mut light_lost_by_crescent) = (0.0_f64, 0.0_f64);
        // Latitude of the Sun, phase angle in longitude, the viewer's first latitude and its step: the rings open and nearly edge-on, the globe full and as a
        // crescent.
        for (sun_deg, phase_deg, from_deg, step_deg) in [
            (26.6, 100.0, -23.5, 0.1),
            (26.6, 3.0, -15.3, 0.1),
            (26.6, 3.0, 20.0, 0.35),
            (-2.0, 160.0, 0.5, 0.1),
            (5.0, 100.0, 1.0, 0.35),
            (10.0, 150.0, -8.0, 0.83),
            (20.0, 172.0, -19.0, 1.93),
        ] {
            let (mut errors, mut errors_of_few) = (Vec::new(), Vec::new());
            for k in 0..12 {
                let (sun, viewer) = (direction(sun_deg, 0.0), direction(from_deg + step_deg * f64::from(k), phase_deg));
                let expected = transmitted_fraction_by_points(&globe, &intervals, sun, viewer, 500);
                errors.push(globe.transmitted_fraction(&intervals, sun, viewer) - expected);
                errors_of_few.push(transmitted_fraction_by_points(&globe, &intervals, sun, viewer, 24) - expected);
                light_lost_by_crescent = light_lost_by_crescent.max(if phase_deg > 170.0 { 1.0 - expected } else { 0.0 });
            }
            let largest = errors.iter().fold(0.0_f64, |largest, error| largest.max(error.abs()));
            let flicker = |errors: &[f64]| errors.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            println!("Sun at {sun_deg}, phase {phase_deg}: {largest:.4}, from step to step {:.4}", flicker(&errors));
            assert!(largest < 0.025 && flicker(&errors) < 0.02, "Sun at {sun_deg}, phase {phase_deg}: {largest}, {}", flicker(&errors));
            flicker_of_few_points = flicker_of_few_points.max(flicker(&errors_of_few));
        }
        // Negative control: with as many points on a square the light jumps by more than 0.05 from step to step. The crescent behind the rings loses more than
        // 0.05 of its light, so that the test compares something.
        assert!(flicker_of_few_points > 0.05 && light_lost_by_crescent > 0.05, "{flicker_of_few_points}, {light_lost_by_crescent}");
    }
}
