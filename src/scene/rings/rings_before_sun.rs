//! The shadow of rings on bodies other than their own: the fraction of sunlight that passes the rings of a planet on its way to a moon.
//!
//! In: a lit body, the catalog and the ephemeris. Out: for each body of the same system whose rings take sunlight from it, a factor per channel on the
//! lit body's sunlight: the mean transmittance over the limb-darkened disc of the Sun and over the lit side of the body, each point of which counts by the
//! cosine of incidence; and [`RingsBeforeSun::fraction_at`] for a single place. Rays that the globe of the rings' owner blocks do not count, because its
//! shadow is drawn by itself (`eclipse`): the product of both is the light that is left. Light time is included; aberration moves Sun and rings alike. Always:
//! 1 far from the shadow, continuous in time. Not here: the shadow of rings on their own globe (shaders/lib/ring); the shadow on a disc place by place
//! (`shadow_grid`), for which the factor is no substitute: a moon is mostly larger than the penumbra, and near the equinox the shadow is a narrow line.
//!
//! Errors (docs/accuracy.md): up to 0.007 of the light by the finite number of rays.

use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::Ephemeris;
use crate::scene::eclipse::occluders::{MIN_BLOCKED_FRACTION_IN_IMAGES, Receiver, limb_darkening};
use crate::scene::rings::phase::MIN_COSINE;
use crate::scene::rings::ring_light::transmittance;
use crate::scene::rings::ring_table::{RingInterval, RingTables};
use crate::time::Instant;
use crate::units::GOLDEN_ANGLE_RAD;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Number of rays from points of the lit side to points of the Sun's disc.
const RAYS: usize = 4096;
/// Steps between the points of the lit side, which fill a square evenly: the inverse of the plastic number, and its square (Roberts 2018, the sequence R2).
const LIT_SIDE_STEPS: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);

/// A body on which the Sun shines.
#[derive(Clone, Copy)]
pub(crate) struct LitBody<'a> {
    pub body: &'a Body,
    /// Barycentric position at `time`, ICRF.
    pub position_km: DVec3,
    /// The time at which the light reaches the body.
    pub time: Instant,
    /// Vector from the body to where the Sun was when the light left the Sun, ICRF.
    pub body_to_sun_km: DVec3,
}

impl<'a> From<&Receiver<'a>> for LitBody<'a> {
    fn from(receiver: &Receiver<'a>) -> Self {
        let Receiver { body, position_km, time, body_to_sun_km, .. } = *receiver;
        Self { body, position_km, time, body_to_sun_km }
    }
}

/// The rings of one body in front of the Sun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RingsBeforeSun<'a> {
    /// The body that has the rings.
    pub owner: &'a Body,
    /// Fraction of sunlight that they let through, per channel, of the light that passes the owner's globe.
    pub fraction: DVec3,
    /// The sunlight of the lit body.
    pub beam: Beam,
    /// The owner's axes when the light passed it.
    pub owner_from_icrf: DMat3,
}

impl RingsBeforeSun<'_> {
    /// The fraction at one place of the lit body, per channel. `place_km`: from the body's centre, ICRF. `sun`: the Sun in the catalog.
    pub fn fraction_at(&self, tables: &RingTables, place_km: DVec3, sun: &Body) -> DVec3 {
        let unit_km = self.owner.radii_km.x;
        let beam = Beam { body: self.beam.body + self.owner_from_icrf * place_km / unit_km, body_radius: 0.0, ..self.beam };
        let intervals = tables.intervals(self.owner.rings.iter(), unit_km);
        beam.fraction_through(&intervals, self.owner.radii_km / unit_km, limb_darkening(sun)).unwrap_or(DVec3::ONE)
    }
}

/// The other bodies of a body's system that have visible rings.
pub(crate) fn bodies_with_rings<'a>(catalog: &'a Catalog, body: &Body) -> impl Iterator<Item = &'a Body> + use<'a> {
    let (id, planet) = (body.id, body.system_planet());
    let may_shade =
        move |owner: &&Body| owner.id != id && owner.system_planet() == planet && owner.rings.iter().any(|r| r.tau_normal > 0.0);
    catalog.bodies().iter().filter(may_shade)
}

/// The rings that take sunlight from a body: those of the other bodies of its system. Empty if they take too little to be seen.
pub(crate) fn rings_before_sun<'a>(
    ephemeris: &Ephemeris,
    catalog: &'a Catalog,
    tables: &RingTables,
    lit: LitBody<'_>,
) -> Vec<RingsBeforeSun<'a>> {
    let Some(sun) = catalog.body(NaifId::SUN).filter(|s| s.id != lit.body.id) else { return Vec::new() };
    bodies_with_rings(catalog, lit.body)
        .filter_map(|owner| {
            // Where the owner was when the sunlight that now reaches the body passed it.
            let (owner_km, passed_at) = ephemeris.light_time_position(owner.id, lit.position_km, lit.time).ok()?;
            let owner_from_icrf = ephemeris.body_from_icrf(owner.id, passed_at).ok()?;
            let unit_km = owner.radii_km.x;
            let in_owner_axes = |offset_km: DVec3| owner_from_icrf * offset_km / unit_km;
            let body_km = lit.position_km - owner_km;
            let beam = Beam {
                body: in_owner_axes(body_km),
                // The radius of a sphere of the same volume.
                body_radius: lit.body.radii_km.element_product().cbrt() / unit_km,
                sun: in_owner_axes(body_km + lit.body_to_sun_km),
                sun_radius: sun.radii_km.max_element() / unit_km,
            };
            let intervals = tables.intervals(owner.rings.iter(), unit_km);
            let fraction = beam.fraction_through(&intervals, owner.radii_km / unit_km, limb_darkening(sun))?;
            Some(RingsBeforeSun { owner, fraction, beam, owner_from_icrf })
        })
        .collect()
}

/// A ray from the lit side of a body to the Sun's disc, for unit radii of both.
struct Ray {
    /// Place on the Sun's disc, and the cosine of the angle at which the light leaves the Sun.
    on_sun: DVec2,
    mu: f64,
    /// Point of the lit side: two components across the direction to the Sun, and the one along it.
    on_body: DVec3,
}

static ALL_RAYS: LazyLock<Vec<Ray>> = LazyLock::new(|| {
    let ray = |k: usize| {
        // Even on the Sun's disc.
        let (radius_sq, angle_rad) = ((k as f64 + 0.5) / RAYS as f64, k as f64 * GOLDEN_ANGLE_RAD);
        // As dense on the body's disc as the cosine of incidence.
        let step = (LIT_SIDE_STEPS * k as f64 + 0.5).fract();
        let cosine = (1.0 - step.x).cbrt();
        let across = DVec2::from_angle(step.y * TAU) * (1.0 - cosine * cosine).sqrt();
        Ray { on_sun: DVec2::from_angle(angle_rad) * radius_sq.sqrt(), mu: (1.0 - radius_sq).sqrt(), on_body: across.extend(cosine) }
    };
    (0..RAYS).map(ray).collect()
});

/// The sunlight of one body. Axes of the rings' owner, from its centre, in its equatorial radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beam {
    pub body: DVec3,
    pub body_radius: f64,
    pub sun: DVec3,
    pub sun_radius: f64,
}

/// The part of a range of lengths in which `slope * length <= limit`; `None` if it has none.
fn clipped([from, to]: [f64; 2], slope: f64, limit: f64) -> Option<[f64; 2]> {
    let [from, to] = if slope > 0.0 {
        [from, to.min(limit / slope)]
    } else if slope < 0.0 {
        [from.max(limit / slope), to]
    } else if limit < 0.0 {
        return None;
    } else {
        [from, to]
    };
    (from <= to).then_some([from, to])
}

impl Beam {
    /// Whether light may pass the ring plane within a radius. A quick test, which errs on the side of yes: no light does if the middle of the beam, where its
    /// width reaches the plane, is farther from the owner's axis than the radius and that width.
    fn may_pass_within(&self, radius: f64) -> bool {
        let to_sun = self.sun - self.body;
        let distance = to_sun.length();
        if distance <= 0.0 {
            return false;
        }
        let (sunward, widening) = (to_sun / distance, self.sun_radius / distance);
        let (across, per_length) = (self.body.truncate(), sunward.truncate());
        // Beyond this length the beam has left the rings for good. Without it a beam along the plane would widen to the size of the Sun.
        let leaving_speed = per_length.length() - widening;
        let end = if leaving_speed > 0.0 { (across.length() + radius + self.body_radius) / leaving_speed } else { distance };
        // The plane is within the beam's width of its middle: |height + slope length| <= body_radius + widening length.
        let in_plane = clipped([0.0, end.min(distance)], sunward.z - widening, self.body_radius - self.body.z)
            .and_then(|range| clipped(range, -sunward.z - widening, self.body_radius + self.body.z));
        let Some([from, to]) = in_plane else { return false };
        let nearest = (-across.dot(per_length) / per_length.length_squared().max(f64::MIN_POSITIVE)).clamp(from, to);
        (across + per_length * nearest).length() <= radius + self.body_radius + widening * to
    }

    /// The smallest cosine between a ray and the rings' normal.
    pub(super) fn smallest_cosine(&self) -> f64 {
        let to_sun = self.sun - self.body;
        ((to_sun.z.abs() - self.sun_radius - self.body_radius) / to_sun.length()).max(MIN_COSINE)
    }

    /// Outer radius of the rings that can take a visible part of the light; `None` if none can.
    pub(crate) fn outer_radius(&self, intervals: &[RingInterval]) -> Option<f64> {
        let cosine = self.smallest_cosine();
        intervals.iter().rfind(|i| -(-i.tau / cosine).exp_m1() > MIN_BLOCKED_FRACTION_IN_IMAGES).map(|i| i.outer)
    }

    /// Mean fraction per channel of the light that rings let through; `None` if it passes beside all that matter, and in the entire shadow of the globe.
    /// `globe`: semi-axes; `limb_darkening`: coefficients of 1 - mu and (1 - mu)² per channel.
    pub(crate) fn fraction_through(&self, intervals: &[RingInterval], globe: DVec3, limb_darkening: (DVec3, DVec3)) -> Option<DVec3> {
        let outer_radius = self.outer_radius(intervals)?;
        if !self.may_pass_within(outer_radius) {
            return None;
        }
        let sunward = (self.sun - self.body).normalize();
        let (x, y) = sunward.any_orthonormal_pair();
        let (mut light, mut transmitted) = (DVec3::ZERO, DVec3::ZERO);
        for ray in ALL_RAYS.iter() {
            let point = self.body + (x * ray.on_body.x + y * ray.on_body.y + sunward * ray.on_body.z) * self.body_radius;
            let towards = (self.sun + (x * ray.on_sun.x + y * ray.on_sun.y) * self.sun_radius - point).normalize();
            if is_blocked(globe, point, towards) {
                continue;
            }
            let one_minus_mu = 1.0 - ray.mu;
            let radiance = DVec3::ONE - limb_darkening.0 * one_minus_mu - limb_darkening.1 * (one_minus_mu * one_minus_mu);
            light += radiance;
            transmitted += radiance * transmittance(intervals, point, towards);
        }
        let fraction = transmitted / light;
        // Comparisons with NaN, the fraction of no light, are false.
        let is_visible = 1.0 - fraction.min_element() > MIN_BLOCKED_FRACTION_IN_IMAGES;
        is_visible.then_some(fraction)
    }
}

/// Whether an ellipsoid around the origin blocks a ray. `axes`: its semi-axes.
pub(crate) fn is_blocked(axes: DVec3, point: DVec3, towards: DVec3) -> bool {
    let (origin, direction) = (point / axes, towards / axes);
    let along = origin.dot(direction);
    along < 0.0 && along * along > direction.length_squared() * (origin.length_squared() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use std::f64::consts::PI;

    const NO_LIMB_DARKENING: (DVec3, DVec3) = (DVec3::ZERO, DVec3::ZERO);

    fn ring(inner: f64, outer: f64, tau: f64) -> RingInterval {
        RingInterval { inner, outer, tau, albedo: [0.0; 3], dust_fraction: 0.0 }
    }

    /// A beam whose middle crosses the ring plane at a place, from a body at a distance `length` beyond it. `sunward`: unit vector. `penumbra`: radius
    /// in the plane of the cone from the body's centre to the Sun, for a Sun straight above.
    fn beam(crossing: DVec3, sunward: DVec3, length: f64, penumbra: f64, body_radius: f64) -> Beam {
        const SUN_DISTANCE: f64 = 1e5;
        let body = crossing - sunward * length;
        Beam { body, body_radius, sun: body + sunward * SUN_DISTANCE, sun_radius: penumbra * SUN_DISTANCE / length }
    }

    fn elevated(degrees: f64) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(cos, 0.0, sin)
    }

    /// A point Sun through a wide ring of one optical depth: exp(-tau / sine of the elevation). Beside the ring, and on the sunlit side of it, all light
    /// arrives.
    #[test]
    fn a_point_sun_is_dimmed_by_the_slanted_optical_depth() {
        const TAU: f64 = 0.4;
        let rings = [ring(1.3, 2.2, TAU)];
        for elevation_deg in [2.0, 12.0, 26.0, 90.0] {
            let sunward = elevated(elevation_deg);
            let through = |radius: f64, length: f64| {
                beam(DVec3::Y * radius, sunward, length, 1e-9, 1e-9).fraction_through(&rings, DVec3::ONE, NO_LIMB_DARKENING)
            };
            let expected = (-TAU / sunward.z).exp();
            let found = through(1.7, 20.0).expect("dimmed");
            assert!((found - expected).abs().max_element() < 1e-6, "{elevation_deg}: {found}, not {expected}");
            assert_eq!([through(1.2, 20.0), through(2.3, 20.0), through(1.7, -20.0)], [None; 3], "{elevation_deg}");
        }
    }

    /// The penumbra of an opaque edge on a small body, the Sun straight above: the part of a uniform disc on one side of a straight line. On a body as large as
    /// the penumbra the change is spread, and half of the light is left where the middle of the beam is on the edge.
    #[test]
    fn the_penumbra_of_an_edge_is_that_of_a_disc_behind_a_line() {
        const PENUMBRA: f64 = 1e-3;
        let rings = [ring(1.5, 9.0, 90.0)];
        // `offset`: of the beam's middle from the edge, outwards, in radii of the penumbra.
        let left = |offset: f64, body_radius: f64| {
            let beam = beam(DVec3::Y * (1.5 + offset * PENUMBRA), DVec3::Z, 50.0, PENUMBRA, body_radius);
            beam.fraction_through(&rings, DVec3::ONE, NO_LIMB_DARKENING).map_or(1.0, |f| f.y)
        };
        let small = 1e-3 * PENUMBRA;
        let offsets = (-60..=60).map(|k| f64::from(k) / 50.0);
        let mut largest = 0.0_f64;
        for offset in offsets.clone() {
            let line = offset.clamp(-1.0, 1.0);
            let expected = (line.acos() - line * (1.0 - line * line).sqrt()) / PI;
            largest = largest.max((left(offset, small) - expected).abs());
        }
        println!("{largest:.4}");
        assert!(largest < 5e-3, "{largest}");
        assert!((left(0.0, PENUMBRA) - 0.5).abs() < 0.01 && left(1.1, PENUMBRA) > 0.02 && left(-1.1, PENUMBRA) < 0.98);
        // Continuous: a step of 0.02 takes at most 2 / pi of its length, and the error of the rays. Negative control: from a point all light goes in one step.
        let largest_step = |body_radius: f64| {
            let all: Vec<f64> = offsets.clone().map(|offset| left(offset, body_radius)).collect();
            all.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f64::max)
        };
        assert!(largest_step(small) < 0.02 * 2.0 / PI + 5e-3, "{}", largest_step(small));
        let of_point_sun = |offset: f64| {
            let beam = beam(DVec3::Y * (1.5 + offset * PENUMBRA), DVec3::Z, 50.0, 1e-12, 1e-12);
            beam.fraction_through(&rings, DVec3::ONE, NO_LIMB_DARKENING).map_or(1.0, |f| f.y)
        };
        assert!(of_point_sun(-0.01) - of_point_sun(0.01) > 0.99);
    }

    /// With half of the Sun behind the limb of the globe, the factor is that of the other half alone; with all of it, there is none.
    #[test]
    fn light_that_the_globe_blocks_does_not_count() {
        const TAU: f64 = 0.1;
        let rings = [ring(1.0, 3.0, TAU)];
        let sunward = elevated(10.0);
        let through = |radius: f64| {
            let beam = beam(DVec3::Y * radius, sunward, 50.0, 1e-3, 1e-6);
            beam.fraction_through(&rings, DVec3::ONE, NO_LIMB_DARKENING)
        };
        let expected = (-TAU / sunward.z).exp();
        for radius in [1.0, 1.5] {
            let found = through(radius).expect("dimmed");
            assert!((found.y - expected).abs() < 2e-3, "{radius}: {found}, not {expected}");
        }
        assert_eq!(through(0.5), None);
    }

    /// The quick test never misses a beam of which a ray passes the ring. Most beams are rejected.
    #[test]
    fn the_quick_test_keeps_all_beams_that_pass_the_ring() {
        let mut random = Random::new(11);
        let (mut passing, mut rejected) = (0, 0);
        const COUNT: u32 = 2000;
        for _ in 0..COUNT {
            let rings = [ring(1.2, random.between(1.5, 4.0), 1.0)];
            let tilt_deg = 10.0_f64.powf(random.between(-3.0, 1.9));
            let sunward = elevated(tilt_deg * if random.unit_interval() < 0.5 { 1.0 } else { -1.0 });
            // Half of the bodies are near the plane, as most moons are.
            let flattening = if random.unit_interval() < 0.5 { 1.0 } else { 0.01 };
            let body = random.direction() * DVec3::new(1.0, 1.0, flattening) * random.between(1.5, 40.0);
            let distance = 1e4;
            let (body_radius, sun_radius) = (random.between(1e-4, 0.3), distance * random.between(1e-4, 5e-3));
            let beam = Beam { body, body_radius, sun: body + sunward * distance, sun_radius };
            let is_kept = beam.may_pass_within(rings[0].outer);
            rejected += u32::from(!is_kept);
            let (x, y) = sunward.any_orthonormal_pair();
            let passes = ALL_RAYS.iter().any(|ray| {
                let point = body + (x * ray.on_body.x + y * ray.on_body.y + sunward * ray.on_body.z) * body_radius;
                let towards = (beam.sun + (x * ray.on_sun.x + y * ray.on_sun.y) * sun_radius - point).normalize();
                transmittance(&rings, point, towards) < 1.0
            });
            passing += u32::from(passes);
            assert!(is_kept || !passes, "{body} {sunward}");
        }
        println!("{passing} pass, {rejected} of {COUNT} are rejected");
        assert!(passing > 20 && 2 * rejected > COUNT, "{passing}, {rejected}");
    }
}
