//! Ring-shine: light that rings scatter onto their own planet, on its night side and in the rings' shadow.
//!
//! In: the rings, the planet's oblateness, the Sun's elevation over their plane, the particles' phase function. Out: [`RingShine`], a table of irradiance
//! divided by height, as a function of height (|z| of the unit-sphere frame) and hour angle from the Sun. Two variables are enough because planet and rings
//! are axially symmetric. Always: no value is negative; a place where the outermost ring is below the horizon gets no light; both sides of the plane are
//! equal if the Sun is in it. Not modelled: light reflected between globe and ring more than once, and the penumbra of the globe's shadow on the ring (a
//! thousandth of a radius).
//!
//! The light is single scattering as in shaders/lib/ring/photometry.wesl, integrated over the part of the ring above the ground's horizon and outside the
//! globe's shadow. The edges of this part are the limits of integration, so that the quadrature never crosses a discontinuity. On Saturn's night side the
//! result differs from a plain sum over the rings by less than 1 % of the sum's value at the brightest place (tests/rings/ring_shine.rs).

use crate::catalog::{Body, Ring};
use crate::memo::{Memo, NumbersKey};
use crate::scene::camera::narrow_scalar;
use crate::scene::constants::{RING_SLANTS, RING_SLANTS_PER_OCTAVE};
pub use crate::scene::draw::tables::RingShine;
use crate::scene::numeric::gauss_legendre;
use crate::scene::rings::phase::{MIN_COSINE, large_particle_phase};
use crate::scene::rings::ring_table::{self, RingInterval, intervals};
pub use crate::scene::rings::single_scatter::{scattered, sun_disc_parts};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Table size: number of hour angles, and number of heights on one side of the plane.
pub use crate::scene::constants::{RING_SHINE_COLUMNS as COLUMNS, RING_SHINE_ROWS as ROWS};
/// Approximate number of annuli of about equal weight into which the rings are grouped.
const ANNULUS_COUNT: usize = 32;
/// Number of Gauss-Legendre nodes on an arc.
const ARC_NODES: usize = 12;
/// Number of slants 2^(k/8) at which an annulus' light is tabulated, as in a [`RingTable`](crate::scene::draw::tables::RingTable).
const SLANTS: usize = RING_SLANTS as usize;
const SLANTS_PER_OCTAVE: f64 = RING_SLANTS_PER_OCTAVE as f64;
/// Height that is used at the equator instead of 0, because the table contains light divided by height.
const EQUATOR_HEIGHT: f64 = 1e-6;

impl RingShine {
    /// As [`Self::irradiance_rgb`], brightest channel.
    pub(crate) fn irradiance(&self, point: DVec3, sun: DVec3) -> f64 {
        self.irradiance_rgb(point, sun).max_element()
    }

    /// Irradiance of level ground per unit of sunlight, linear RGB, interpolated as in shaders/lib/ring/shine.wesl. `point`: unit-sphere frame; `sun`: unit
    /// vector, body axes.
    pub(crate) fn irradiance_rgb(&self, point: DVec3, sun: DVec3) -> DVec3 {
        let height = point.z.abs();
        let noon = sun.truncate().try_normalize().unwrap_or(DVec2::X);
        let hour_fraction = point.truncate().perp_dot(noon).abs().atan2(point.truncate().dot(noon)) / PI;
        let cell = |fraction: f64, count: usize| {
            let position = fraction.clamp(0.0, 1.0) * (count - 1) as f64;
            let low = (position as usize).min(count - 2);
            (low, position - low as f64)
        };
        let (column, column_fraction) = cell(hour_fraction, COLUMNS);
        let (row, row_fraction) = cell((height / self.max_height).min(1.0).sqrt(), ROWS);
        let first_row = if point.z * sun.z >= 0.0 { 0 } else { ROWS };
        let texel = |row: usize, column: usize| -> DVec3 {
            let index = 4 * ((first_row + row) * COLUMNS + column);
            self.texels.get(index..index + 3).map_or(DVec3::ZERO, |t| DVec3::from_array([0, 1, 2].map(|k| f64::from(t[k]))))
        };
        let mixed = |row: usize| texel(row, column).lerp(texel(row, column + 1), column_fraction);
        mixed(row).lerp(mixed(row + 1), row_fraction) * height
    }
}

/// The geometry that determines a table. Lengths are equatorial radii.
#[derive(Clone, Copy, Debug)]
pub struct RingShineGeometry<'a> {
    pub rings: &'a [&'a Ring],
    pub radius_km: f64,
    /// Ratio of the polar to the equatorial radius.
    pub polar_ratio: f64,
    /// Sine of the Sun's elevation over the plane; its sign does not matter.
    pub sin_elevation: f64,
    /// Tangent of the Sun's angular radius.
    pub sun_tangent: f64,
}

/// A group of intervals, approximated by a thin annulus at one radius.
struct Annulus {
    radius: f64,
    /// For each side of the plane (0: the side on which the Sun's centre is) and each slant: scattered light integrated over the intervals' radii, per channel.
    light: [Vec<DVec3>; 2],
}

impl Annulus {
    /// The scattered light along paths of a slant, interpolated. `side`: see `light`.
    fn light_along(&self, side: usize, slant: f64) -> DVec3 {
        let position = (slant.log2() * SLANTS_PER_OCTAVE).clamp(0.0, (SLANTS - 1) as f64 - 1e-9);
        let below = position as usize;
        self.light[side][below].lerp(self.light[side][below + 1], position.fract())
    }
}

/// Weight of an interval in the division into annuli: the light that it removes along a path of slant 4 (elevation 14.5 degrees), times its width and albedo.
fn weight(interval: &RingInterval) -> f64 {
    (interval.outer - interval.inner) * -(-4.0 * interval.tau).exp_m1() * interval.albedo.iter().sum::<f64>()
}

/// Divides intervals of constant optical depth into parts, and groups the parts into annuli of about equal weight.
fn annuli(geometry: &RingShineGeometry<'_>) -> Vec<Annulus> {
    let intervals = intervals(geometry.rings.iter().copied(), geometry.radius_km);
    let total: f64 = intervals.iter().map(weight).sum();
    if total.is_nan() || total <= 0.0 {
        return Vec::new();
    }
    let weight_per_annulus = total / ANNULUS_COUNT as f64;
    let mut groups: Vec<Vec<RingInterval>> = vec![Vec::new()];
    // Weight of the last group.
    let mut group_weight = 0.0;
    for interval in intervals.into_iter().filter(|s| s.tau > 0.0) {
        let parts = (weight(&interval) / weight_per_annulus).ceil().max(1.0);
        let width = (interval.outer - interval.inner) / parts;
        for k in 0..parts as usize {
            let inner = interval.inner + width * k as f64;
            let part = RingInterval { inner, outer: inner + width, ..interval };
            if group_weight >= weight_per_annulus {
                groups.push(Vec::new());
                group_weight -= weight_per_annulus;
            }
            group_weight += weight(&part);
            if let Some(group) = groups.last_mut() {
                group.push(part);
            }
        }
    }
    let sun_disc_parts = sun_disc_parts(geometry.sin_elevation.abs(), geometry.sun_tangent);
    let annulus = |group: &Vec<RingInterval>| {
        let total_weight: f64 = group.iter().map(weight).sum();
        let radius = group.iter().map(|s| weight(s) * 0.5 * (s.inner + s.outer)).sum::<f64>() / total_weight.max(1e-300);
        let light_at_slant = |side: usize, k: usize| {
            let slant = (k as f64 / SLANTS_PER_OCTAVE).exp2();
            let from_interval = |interval: &RingInterval| {
                let from_sun_part = |sun_part: usize| {
                    let [fraction, sine] = sun_disc_parts[sun_part];
                    if fraction > 0.0 {
                        fraction * scattered(interval.tau, slant, 1.0 / sine.max(MIN_COSINE), sun_part == side)
                    } else {
                        0.0
                    }
                };
                DVec3::from_array(interval.albedo) * ((interval.outer - interval.inner) * (from_sun_part(0) + from_sun_part(1)))
            };
            group.iter().map(from_interval).sum()
        };
        let light = [0, 1].map(|side| (0..SLANTS).map(|k| light_at_slant(side, k)).collect());
        Annulus { radius, light }
    };
    groups.iter().filter(|g| !g.is_empty()).map(annulus).collect()
}

/// Tables are interpolated between knots. There is a knot, with its own table, at each elevation of the Sun whose sine has at most this many binary digits
/// after the leading one.
const KNOT_DIGITS: u32 = 5;

/// Rounds an absolute value to `digits` binary digits after the leading one.
fn round_to_digits(v: f64, digits: u32) -> f64 {
    let dropped_bits = 52 - digits;
    f64::from_bits((v.abs().to_bits() + (1 << (dropped_bits - 1))) >> dropped_bits << dropped_bits)
}

/// Number of cached tables of each kind.
const CACHE_CAPACITY: usize = 16;

/// The source files that determine a table: an edit of one of them invalidates tables stored on disk. Beyond these files, a table depends only on the numbers
/// of its key and on the narrowing to f32.
pub(crate) const SOURCES: [&str; 6] = [
    include_str!("ring_shine.rs"),
    include_str!("phase.rs"),
    include_str!("ring_table.rs"),
    include_str!("single_scatter.rs"),
    include_str!("../constants.rs"),
    include_str!("../numeric.rs"),
];

/// A store that keeps tables between runs of the program, because computing a table takes longer than drawing a frame.
pub(crate) trait RingShineStore: std::fmt::Debug + Send + Sync {
    /// The table that was stored under a key, if it is complete and undamaged.
    fn read(&self, key: &[f64]) -> Option<RingShine>;
    /// Stores a table under a key.
    fn write(&self, key: &[f64], table: &RingShine);
}

/// Tables of ring-shine, cached from frame to frame.
#[derive(Debug)]
pub struct RingShineCache {
    /// Tables interpolated between knots.
    shines: Memo<NumbersKey, Option<Arc<RingShine>>>,
    /// Tables of the knots.
    knots: Memo<NumbersKey, Option<Arc<RingShine>>>,
    /// `None`: in memory only.
    store: Option<Box<dyn RingShineStore>>,
}

impl Default for RingShineCache {
    fn default() -> Self {
        Self { shines: Memo::with_capacity(CACHE_CAPACITY), knots: Memo::with_capacity(CACHE_CAPACITY), store: None }
    }
}

impl RingShineCache {
    /// A cache that also keeps its tables in `store`.
    pub(crate) fn stored(store: Option<Box<dyn RingShineStore>>) -> Self {
        Self { store, ..Self::default() }
    }

    /// The table of a knot: from memory, from disk, or computed.
    fn knot_table(&self, geometry: &RingShineGeometry<'_>) -> Option<Arc<RingShine>> {
        let key: Vec<f64> = geometry.cache_key().collect();
        self.knots.get(key.iter().copied().collect(), || {
            let stored = self.store.as_ref().and_then(|store| store.read(&key));
            let table = stored.or_else(|| {
                let computed = geometry.table();
                if let (Some(store), Some(computed)) = (&self.store, &computed) {
                    store.write(&key, computed);
                }
                computed
            });
            table.map(Arc::new)
        })
    }
}

impl<'a> RingShineGeometry<'a> {
    /// The geometry of a body whose rings are `rings`. `sun`: unit vector towards the Sun, body axes. All who need a table ask for it by this function, so that
    /// they get the same from the cache.
    pub(crate) fn of(body: &Body, rings: &'a [&'a Ring], sun: DVec3, sun_distance_km: f64, sun_radius_km: f64) -> Self {
        Self {
            rings,
            radius_km: body.radii_km.x,
            polar_ratio: body.radii_km.z / body.radii_km.x,
            sin_elevation: sun.z,
            sun_tangent: sun_radius_km / sun_distance_km,
        }
    }
}

impl RingShineGeometry<'_> {
    /// Irradiance divided by height, at a height and an hour angle in radians. `gauss`: nodes and weights of the quadrature. `side`: 0 on the side of the plane
    /// on which the Sun's centre is, 1 on the other.
    fn irradiance_per_height(&self, annuli: &[Annulus], gauss: &[(f64, f64)], side: usize, height: f64, hour_angle: f64) -> DVec3 {
        let axis_distance = (1.0 - height * height).max(0.0).sqrt();
        let normal = DVec3::new(axis_distance, 0.0, height / self.polar_ratio).normalize();
        let place = DVec3::new(axis_distance, 0.0, self.polar_ratio * height);
        let (sin_hour, cos_hour) = hour_angle.sin_cos();
        let sine = self.sin_elevation.abs();
        // For a Sun over the pole the sine of the upper knot is above 1.
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        // Direction to the Sun relative to the place's meridian.
        let sun = DVec3::new(cosine * cos_hour, -cosine * sin_hour, if side == 0 { sine } else { -sine });
        // Component of the Sun's direction in the rings' plane, unit-sphere frame.
        let sun_in_plane = cosine / cosine.hypot(sine / self.polar_ratio);
        // Of the rings' plane, only points beyond this radius can be above the horizon of the place.
        let horizon_radius = 1.0 / axis_distance.max(1e-9);
        let mut sum = DVec3::ZERO;
        for annulus in annuli.iter().filter(|a| a.radius > horizon_radius) {
            let r = annulus.radius;
            let half_arc = (horizon_radius / r).acos();
            // Half angle of the ring's arc in the globe's shadow, centred on the anti-solar point, whose hour angle is pi.
            let shadow_cosine = (r * r - 1.0).max(0.0).sqrt() / (r * sun_in_plane).max(1e-12);
            let shadow_half_arc = if shadow_cosine < 1.0 { shadow_cosine.acos() } else { 0.0 };
            let (from, to) = (hour_angle - half_arc, hour_angle + half_arc);
            // The parts of the visible arc on either side of the shadow.
            for [a, b] in [[from, to.min(PI - shadow_half_arc)], [from.max(PI + shadow_half_arc), to]] {
                if b <= a {
                    continue;
                }
                for (x, w) in gauss {
                    let angle = a + (b - a) * x - hour_angle;
                    let (sin, cos) = angle.sin_cos();
                    let to_ring = DVec3::new(r * cos, r * sin, 0.0) - place;
                    let distance_sq = to_ring.length_squared();
                    let distance = distance_sq.sqrt();
                    let cos_incidence = normal.dot(to_ring).max(0.0) / distance;
                    let cos_emission = (place.z / distance).max(MIN_COSINE);
                    let phase = large_particle_phase(-sun.dot(to_ring) / distance);
                    // The ring's projected area divided by height: polar_ratio / distance is the cosine of emission divided by height.
                    let projected_area = (b - a) * w * r * cos_incidence * self.polar_ratio / (distance * distance_sq);
                    // 1/4 is the factor of single scattering; radiance 1 causes the irradiance 1 / pi per steradian.
                    sum += annulus.light_along(side, 1.0 / cos_emission) * (0.25 / PI * phase * projected_area);
                }
            }
        }
        sum
    }

    /// Computes the table. `None` if no ring scatters light.
    fn table(&self) -> Option<RingShine> {
        let annuli = annuli(self);
        let outermost = annuli.iter().map(|a| a.radius).fold(0.0, f64::max);
        if outermost <= 1.0 {
            return None;
        }
        let max_height = (1.0 - 1.0 / (outermost * outermost)).sqrt();
        let gauss = gauss_legendre(ARC_NODES);
        let rows: Vec<Vec<(DVec3, f64)>> = (0..2 * ROWS)
            .into_par_iter()
            .map(|n| {
                let (side, row) = (n / ROWS, n % ROWS);
                let height = max_height * (row as f64 / (ROWS - 1) as f64).powi(2);
                let light_at_column = |column: usize| {
                    let hour_angle = PI * column as f64 / (COLUMNS - 1) as f64;
                    (self.irradiance_per_height(&annuli, &gauss, side, height.max(EQUATOR_HEIGHT), hour_angle), height)
                };
                (0..COLUMNS).map(light_at_column).collect()
            })
            .collect();
        let brightest = rows.iter().flatten().map(|(light, height)| light.max_element() * height).fold(0.0, f64::max);
        let texel = |(light, _): &(DVec3, f64)| [light.x, light.y, light.z, 0.0].map(narrow_scalar);
        Some(RingShine { texels: rows.iter().flatten().flat_map(texel).collect(), max_height, brightest })
    }

    /// The cached table; `None` if no ring scatters light. The sine of the Sun's elevation is rounded to eleven binary digits (5e-4 of the light), so that
    /// successive frames share a table.
    pub fn shine(&self, cache: &RingShineCache) -> Option<Arc<RingShine>> {
        let geometry =
            Self { sin_elevation: round_to_digits(self.sin_elevation, 11), sun_tangent: round_to_digits(self.sun_tangent, 11), ..*self };
        cache.shines.get(geometry.cache_key().collect(), || geometry.interpolate(cache).map(Arc::new))
    }

    /// Interpolates between the tables of the knots below and above the Sun's elevation. Frames that span a year need few knots. Interpolation saves time,
    /// because computing a table takes as long as drawing two frames.
    fn interpolate(&self, cache: &RingShineCache) -> Option<RingShine> {
        let table_at_knot = |sin_elevation: f64| {
            // A Sun whose disc does not touch the plane is treated as a point.
            let geometry =
                Self { sin_elevation, sun_tangent: if sin_elevation > self.sun_tangent { 0.0 } else { self.sun_tangent }, ..*self };
            cache.knot_table(&geometry)
        };
        let dropped_bits = 52 - KNOT_DIGITS;
        let below = f64::from_bits(self.sin_elevation.to_bits() >> dropped_bits << dropped_bits);
        let above = f64::from_bits(below.to_bits() + (1 << dropped_bits));
        let (low, high) = (table_at_knot(below)?, table_at_knot(above)?);
        let upper_weight = narrow_scalar((self.sin_elevation - below) / (above - below));
        let texels = low.texels.iter().zip(&high.texels).map(|(a, b)| a + (b - a) * upper_weight).collect();
        let brightest = low.brightest + (high.brightest - low.brightest) * f64::from(upper_weight);
        Some(RingShine { texels, max_height: low.max_height, brightest })
    }

    /// The values that a table depends on, as a cache key.
    fn cache_key(&self) -> impl Iterator<Item = f64> {
        let own = [self.sin_elevation, self.sun_tangent, self.radius_km, self.polar_ratio];
        own.into_iter().chain(self.rings.iter().flat_map(|r| ring_table::cache_key(r)))
    }

    /// Upper limit of the irradiance of any place, per unit of sunlight: as if each ring had its maximum brightness and none of it were below the horizon. The
    /// dependence on the radius is an estimate; a test compares the limit with tables.
    pub(crate) fn upper_limit(&self) -> f64 {
        let brightest = large_particle_phase(1.0);
        let limit_of_ring = |ring: &&Ring| {
            let r = (ring.outer_km + ring.inner_km) / (2.0 * self.radius_km);
            let albedo = ring.albedo.iter().copied().fold(0.0, f64::max);
            let width = (ring.outer_km - ring.inner_km) / self.radius_km;
            albedo * 0.25 * brightest * ring.tau_normal.min(1.0) * width * r.sqrt() / (r - 1.0).max(1e-3)
        };
        self.rings.iter().map(limit_of_ring).sum::<f64>().min(brightest * 0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::GOLDEN_ANGLE_RAD;

    fn ring(inner_km: f64, outer_km: f64, tau_normal: f64) -> Ring {
        Ring { name: "x".into(), inner_km, outer_km, tau_normal, albedo: [0.8, 0.6, 0.4], dust_fraction: 0.0 }
    }

    fn geometry<'a>(rings: &'a [&'a Ring], sin_elevation: f64) -> RingShineGeometry<'a> {
        RingShineGeometry { rings, radius_km: 1.0, polar_ratio: 0.9, sin_elevation, sun_tangent: 5e-4 }
    }

    /// The largest interpolated irradiance is at least 0.9 of the table's brightest value and at most a thousandth above it (the height is interpolated
    /// between two rows). The equator, which sees the ring's edge, gets no light.
    #[test]
    fn the_interpolated_irradiance_matches_the_table() {
        let ring = ring(1.3, 2.2, 1.0);
        let shine = geometry(&[&ring], 0.3).shine(&RingShineCache::default()).expect("light");
        let sun = DVec3::new(0.6, 0.7, 0.3).normalize();
        let irradiance_at_point = |k: u32| {
            let z = (f64::from(k) + 0.5) / 10_000.0 - 1.0;
            let (sin, cos) = (f64::from(k) * GOLDEN_ANGLE_RAD).sin_cos();
            shine.irradiance(DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z, sun)
        };
        let brightest = (0..20_000).map(irradiance_at_point).fold(0.0, f64::max);
        assert!(brightest <= shine.brightest * (1.0 + 1e-3) && brightest > 0.9 * shine.brightest, "{brightest} of {}", shine.brightest);
        assert_eq!(shine.irradiance(DVec3::X, sun), 0.0);
    }

    #[test]
    fn the_parts_of_the_suns_disc_share_its_light() {
        for sine in [0.0, 1e-4, 3e-4, 4.99e-4, 5e-4, 0.1] {
            let [[above, height_above], [below, depth_below]] = sun_disc_parts(sine, 5e-4);
            assert!((above + below - 1.0).abs() < 1e-12 && height_above >= 0.0 && depth_below >= 0.0);
            // The mean height of the entire disc is the height of its centre.
            let mean_height = above * height_above - below * depth_below;
            assert!((mean_height - sine).abs() < 1e-9, "{sine}: {above} {height_above} {below} {depth_below}");
        }
    }

    #[test]
    fn no_rings_give_no_light_and_thin_rings_give_light_in_proportion() {
        let nothing = ring(1.5, 2.0, 0.0);
        assert!(
            geometry(&[], 0.3).shine(&RingShineCache::default()).is_none()
                && geometry(&[&nothing], 0.3).shine(&RingShineCache::default()).is_none()
        );
        assert_eq!(geometry(&[&nothing], 0.3).upper_limit(), 0.0);
        let brightest_at_depth = |tau: f64| geometry(&[&ring(1.5, 2.0, tau)], 0.3).table().expect("a table").brightest;
        assert!((brightest_at_depth(2e-6) / brightest_at_depth(1e-6) - 2.0).abs() < 1e-4);
        assert!(brightest_at_depth(2.0) < 1.9 * brightest_at_depth(1.0), "thick rings shadow themselves");
    }

    #[test]
    fn interpolation_between_knots_agrees_with_an_exact_table() {
        let ring = ring(1.24, 2.27, 0.8);
        let rings = [&ring];
        for sine in [2e-4, 3e-3, 0.047, 0.13, 0.29, 0.447] {
            // Halfway between two knots.
            let below = round_to_digits(sine, KNOT_DIGITS);
            let geometry = RingShineGeometry {
                sin_elevation: f64::from_bits(below.to_bits() + (1 << (51 - KNOT_DIGITS))),
                sun_tangent: 5e-4,
                ..geometry(&rings, sine)
            };
            let (exact, interpolated) =
                (geometry.table().expect("a table"), geometry.interpolate(&RingShineCache::default()).expect("a table"));
            let max_error = |other: &RingShine| exact.texels.iter().zip(&other.texels).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let brightest = exact.texels.iter().copied().fold(0.0, f32::max);
            assert!(max_error(&interpolated) < 1e-3 * brightest, "sine {sine}: {} of {brightest}", max_error(&interpolated));
            let alone = RingShineGeometry { sin_elevation: below, ..geometry }.table().expect("a table");
            assert!(
                max_error(&alone) > 3.0 * max_error(&interpolated),
                "one knot alone, sine {sine}: {} of {brightest}",
                max_error(&alone)
            );
        }
    }

    /// The sine is rounded to 1, which is a knot; the knot above it is not the sine of any elevation.
    #[test]
    fn a_sun_over_the_pole_gives_light() {
        let rings = [&ring(1.2, 2.2, 0.7)];
        for sine in [0.9999, 1.0, -1.0] {
            let shine = geometry(&rings, sine).shine(&RingShineCache::default()).expect("light");
            assert!(shine.brightest > 0.0 && shine.texels.iter().all(|v| v.is_finite()), "{sine}");
        }
    }

    #[test]
    fn both_sides_are_equal_if_the_sun_is_in_the_plane() {
        let rings = [&ring(1.2, 2.2, 0.7)];
        let difference = |sine: f64| {
            let table = geometry(&rings, sine).table().expect("a table");
            let (one, other) = table.texels.split_at(ROWS * COLUMNS * 4);
            one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs()) / table.brightest).fold(0.0, f64::max)
        };
        assert!(difference(0.0) < 1e-6, "{}", difference(0.0));
        assert!(difference(0.3) > 0.1, "{}", difference(0.3));
    }

    #[test]
    fn the_upper_limit_is_never_exceeded() {
        for (inner, outer, tau, sine) in [(1.1, 1.2, 5.0, 0.4), (1.2, 2.3, 0.5, 0.1), (1.9, 1.91, 0.05, 0.9), (1.3, 1.4, 1e-5, 0.5)] {
            let rings = [&ring(inner, outer, tau)];
            let geometry = geometry(&rings, sine);
            let table = geometry.table().expect("a table");
            assert!(table.texels.iter().all(|v| v.is_finite() && *v >= 0.0));
            let found = table.brightest;
            assert!(found > 0.0 && found < geometry.upper_limit(), "{found} and {}", geometry.upper_limit());
        }
    }
}
