//! The order of draws, from far to near.
//!
//! In: placed bodies and their draws. Out: the same draws in painter's order, so that visibility does not depend on the depth test, which cannot separate two
//! close layers of one body. Two disjoint spheres are separated by the plane of equal tangent lengths (their radical plane); the sphere with the shorter
//! tangent from the camera is in front. A body that does not cross the plane of a ring is entirely in front of the ring or entirely behind it, depending on
//! whether it is on the camera's side of that plane. Both rules are valid at any distance. Within a body the layers follow [`BodyPart`]. Not here: bodies whose
//! bounding spheres intersect, and moons that cross the ring's plane; the depth test decides between those.

use crate::catalog::NaifId;
use crate::scene::draw::{BodyPart, Draw};
use crate::scene::placed::PlacedBody;
use glam::DVec3;

/// The bounding sphere of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BoundingSphere {
    /// Relative to the camera, ICRF.
    centre_km: DVec3,
    /// Includes all layers except the rings.
    radius_km: f64,
}

impl BoundingSphere {
    fn of(p: &PlacedBody<'_>) -> Self {
        let body = p.body;
        let air_km = body.atmosphere.as_ref().map_or(0.0, |a| a.top_km);
        let clouds_km = body.clouds.as_ref().map_or(0.0, |c| c.height_km);
        Self { centre_km: p.placement.centre_km, radius_km: body.radii_km.max_element() + air_km.max(clouds_km) }
    }

    /// Squared length of the tangent from the camera to the sphere; negative for a camera inside.
    fn tangent_sq_km2(&self) -> f64 {
        self.centre_km.length_squared() - self.radius_km * self.radius_km
    }

    /// Whether the outlines overlap, as seen from the camera.
    fn overlaps(&self, other: &Self) -> bool {
        let angular_radius = |b: &Self| (b.radius_km / b.centre_km.length()).min(1.0).asin();
        crate::ephemeris::angle_rad(self.centre_km, other.centre_km) < angular_radius(self) + angular_radius(other)
    }
}

/// Whether body `a` is in front of body `b` wherever their outlines overlap.
pub(crate) fn is_in_front(a: &PlacedBody<'_>, b: &PlacedBody<'_>) -> bool {
    BoundingSphere::of(a).tangent_sq_km2() < BoundingSphere::of(b).tangent_sq_km2()
}

/// The sort key of a draw: farther groups first; within a group by step; within a step farther bodies first. A group is a planet with rings and its moons, or a
/// single body. Distances are the squared lengths of tangents to bounding spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DrawOrder {
    group_tangent_sq_km2: f64,
    step: DrawingStep,
    body_tangent_sq_km2: f64,
}

/// The steps in which a body with rings and the moons around it are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum DrawingStep {
    MoonsBehindRings,
    /// The half of the ring behind the globe's centre: each ray meets it beyond the ray's point nearest to that centre.
    FarHalf,
    MoonsBehindGlobe,
    Globe,
    MoonsBehindNearHalf,
    /// The half of the ring in front of the globe's centre.
    NearHalf,
}

/// The step in which a moon of a ringed planet is drawn; `None`: in front of all layers of the planet, as a group of its own. `pole`: normal of the ring's
/// plane, unit vector.
fn step_among_rings(moon: &BoundingSphere, planet: &BoundingSphere, pole: DVec3) -> Option<DrawingStep> {
    let from_planet_km = moon.centre_km - planet.centre_km;
    // Heights above the ring's plane.
    let (moon_height_km, camera_height_km) = (pole.dot(from_planet_km), -pole.dot(planet.centre_km));
    let crosses_plane = moon_height_km.abs() <= moon.radius_km;
    let is_on_far_side = moon_height_km * camera_height_km < 0.0;
    let is_in_front_of_globe = moon.tangent_sq_km2() < planet.tangent_sq_km2();
    // A camera within the ring's radius that looks away from the planet sees the far half, because each ray meets the ring beyond the ray's point nearest to
    // the globe's centre. A moon behind that half may be closer to the camera than the planet.
    let is_seen_outwards = from_planet_km.dot(moon.centre_km) > 0.0 && !moon.overlaps(planet);
    if crosses_plane {
        // The depth test decides between moon and ring; the order of draws, only between moon and globe.
        return if is_in_front_of_globe { None } else { Some(DrawingStep::MoonsBehindRings) };
    }
    match (is_on_far_side, is_in_front_of_globe) {
        (false, true) => None,
        (false, false) => Some(DrawingStep::MoonsBehindGlobe),
        (true, true) if !is_seen_outwards => Some(DrawingStep::MoonsBehindNearHalf),
        (true, _) => Some(DrawingStep::MoonsBehindRings),
    }
}

/// Sorts the draws of placed bodies.
pub(crate) fn far_to_near(placed: &[PlacedBody<'_>], mut draws: Vec<Draw>) -> Vec<Draw> {
    let ringed: Vec<NaifId> = draws.iter().filter(|d| d.part == BodyPart::RingInFront).map(|d| d.body).collect();
    let placed_body = |id: NaifId| placed.iter().find(|p| p.body.id == id);
    let order_of = |id: NaifId, part: BodyPart| {
        // Every draw is made from a placed body, so this value is never used.
        let Some(p) = placed_body(id) else {
            return DrawOrder { group_tangent_sq_km2: 0.0, step: DrawingStep::Globe, body_tangent_sq_km2: 0.0 };
        };
        let sphere = BoundingSphere::of(p);
        let body_tangent_sq_km2 = sphere.tangent_sq_km2();
        let step = match part {
            BodyPart::RingBehind => DrawingStep::FarHalf,
            BodyPart::RingInFront => DrawingStep::NearHalf,
            BodyPart::Sky | BodyPart::Globe | BodyPart::Clouds => DrawingStep::Globe,
        };
        let planet = p.body.parent.filter(|parent| ringed.contains(parent)).and_then(placed_body);
        let moon_order = planet.and_then(|planet| {
            let pole = planet.placement.body_from_icrf.transpose() * DVec3::Z;
            Some((BoundingSphere::of(planet).tangent_sq_km2(), step_among_rings(&sphere, &BoundingSphere::of(planet), pole)?))
        });
        let (group_tangent_sq_km2, step) = moon_order.unwrap_or((body_tangent_sq_km2, step));
        DrawOrder { group_tangent_sq_km2, step, body_tangent_sq_km2 }
    };
    draws.sort_by_cached_key(|d| {
        let order = order_of(d.body, d.part);
        (Farther(order.group_tangent_sq_km2), order.step, Farther(order.body_tangent_sq_km2), d.part)
    });
    draws
}

/// Number of sorted draws up to and including the last draw of `body`: the Sun's corona is drawn after the Sun's draws. For a body without a draw, the number
/// of draws up to the last one of a farther body.
pub(crate) fn draw_count_up_to(placed: &[PlacedBody<'_>], draws: &[Draw], body: NaifId) -> usize {
    let distance_km = |id: NaifId| placed.iter().find(|p| p.body.id == id).map_or(0.0, |p| p.distance_km);
    let body_km = distance_km(body);
    let last = draws.iter().rposition(|d| d.body == body).or_else(|| draws.iter().rposition(|d| distance_km(d.body) >= body_km));
    last.map_or(0, |last| last + 1)
}

/// A squared distance as a sort key: larger values sort first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Farther(f64);

impl Eq for Farther {}
impl PartialOrd for Farther {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Farther {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.0.total_cmp(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quasi-random sequence of numbers in 0..1: the fractional parts of a quadratic polynomial.
    fn numbers(seed: u32) -> impl FnMut() -> f64 {
        let mut k = f64::from(seed);
        move || {
            k += 1.0;
            (k * 0.618_033_988_749_895 + (k * k * 0.324_717_957_244_746).fract()).fract()
        }
    }

    /// Distance along a ray from the camera to a sphere; `None` if the ray misses it.
    fn distance_to(sphere: &BoundingSphere, along: DVec3) -> Option<f64> {
        let b = sphere.centre_km.dot(along);
        let square = sphere.radius_km * sphere.radius_km - (sphere.centre_km - along * b).length_squared();
        (square > 0.0 && b > 0.0).then(|| b - square.sqrt())
    }

    /// For cameras at many distances and moons anywhere around a planet with a ring: along each ray that meets two of moon, globe and ring, the one drawn
    /// later is nearer. Lengths are in radii of the planet.
    #[test]
    fn along_every_ray_the_nearer_is_drawn_later() {
        let mut next = numbers(7);
        // A direction, and two numbers in 0..1.
        let mut random_direction_and_numbers = move || {
            let (z, angle) = (2.0 * next() - 1.0, std::f64::consts::TAU * next());
            (DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0_f64 - z * z).sqrt() + DVec3::Z * z, next(), next())
        };
        let (mut pairs, mut with_ring) = (0, 0);
        for _ in 0..40_000 {
            let (to_camera, camera_number, size) = random_direction_and_numbers();
            let (to_moon, moon_number, _) = random_direction_and_numbers();
            let (perpendicular, offset, _) = random_direction_and_numbers();
            // Distances from the globe's centre: of the camera 1.02 to 10 million, of the moon 1.3 to 5.3, of the ring 1.2 to 2.3.
            let camera = to_camera * (0.02 + 10f64.powf(7.0 * camera_number * camera_number));
            let moon = BoundingSphere { centre_km: to_moon * (1.3 + 4.0 * moon_number) - camera, radius_km: 0.02 + 0.1 * size };
            let planet = BoundingSphere { centre_km: -camera, radius_km: 1.0 };
            let pole = DVec3::Z;
            // A ray that meets the moon.
            let along = (moon.centre_km + perpendicular * (moon.radius_km * 0.9 * offset)).normalize();
            let Some(at_moon) = distance_to(&moon, along) else { continue };
            if moon.tangent_sq_km2() < 0.0 {
                continue;
            }
            let is_in_front_of_globe = moon.tangent_sq_km2() < planet.tangent_sq_km2();
            let step = step_among_rings(&moon, &planet, pole);
            // Without a step the moon is sorted as a group of its own: after all steps of the planet if it is in front, otherwise before them.
            let rank = step.map_or(if is_in_front_of_globe { i32::MAX } else { -1 }, |s| s as i32);
            if let Some(at_globe) = distance_to(&planet, along) {
                assert_eq!(at_moon < at_globe, rank > DrawingStep::Globe as i32, "{moon:?} {step:?} from {camera}");
                pairs += 1;
            }
            let crosses_plane = (moon.centre_km + camera).z.abs() <= moon.radius_km;
            let at_ring = -camera.z / along.z;
            let on_ring = camera + along * at_ring;
            if crosses_plane || at_ring <= 0.0 || !(1.2..2.3).contains(&on_ring.length()) {
                continue;
            }
            let half = if on_ring.dot(along) > 0.0 { DrawingStep::FarHalf } else { DrawingStep::NearHalf };
            assert_eq!(at_moon < at_ring, rank > half as i32, "{moon:?} {step:?}, {half:?} from {camera}");
            with_ring += 1;
            // The half of the ring itself is behind the globe or in front of it.
            if let Some(at_globe) = distance_to(&planet, along) {
                assert_eq!(at_ring < at_globe, half > DrawingStep::Globe, "from {camera} along {along}");
            }
        }
        assert!(pairs > 500 && with_ring > 500, "{pairs} {with_ring}");
    }
}
