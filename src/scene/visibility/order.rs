//! The order in which draws go over one another, far to near.
//!
//! In: where bodies are seen, and their draws. Out: the same draws in painter's order, so that no draw needs depth to know what it lies over: two layers of
//! one body may be closer than depth can tell. Two spheres that do not meet are parted by the plane where the tangents to both are equal, and who has the shorter
//! tangent from the camera stands before the other; a body that does not meet the plane of a ring stands before the whole ring or behind the
//! whole of it, as it is on the camera's side of that plane or not. Both hold at any distance, from close by too. Within a body the layers follow [`Part`].
//! Not here: bodies whose bounding spheres meet, and moons that the ring's plane cuts, as if embedded in it: of those depth decides.

use crate::catalog::NaifId;
use crate::scene::draw::{Draw, Part};
use crate::scene::placed::PlacedBody;
use glam::DVec3;

/// A body as the order sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    centre_km: DVec3,
    /// Of all its layers but the rings.
    radius_km: f64,
}

impl Ball {
    fn of(p: &PlacedBody<'_>) -> Self {
        let body = p.body;
        let air_km = body.atmosphere.as_ref().map_or(0.0, |a| a.top_km);
        let clouds_km = body.clouds.as_ref().map_or(0.0, |c| c.height_km);
        Self { centre_km: p.placement.centre_km, radius_km: body.radii_km.max_element() + air_km.max(clouds_km) }
    }

    /// Squared length of the tangent from the camera; below 0 inside.
    fn tangent_squared_km2(&self) -> f64 {
        self.centre_km.length_squared() - self.radius_km * self.radius_km
    }

    /// Whether the outlines overlap.
    fn overlaps(&self, other: &Self) -> bool {
        let reach = |b: &Self| (b.radius_km / b.centre_km.length()).min(1.0).asin();
        crate::ephemeris::angle_rad(self.centre_km, other.centre_km) < reach(self) + reach(other)
    }
}

/// Whether a body stands before another wherever both are seen.
pub(crate) fn stands_before(a: &PlacedBody<'_>, b: &PlacedBody<'_>) -> bool {
    Ball::of(a).tangent_squared_km2() < Ball::of(b).tangent_squared_km2()
}

/// Where a draw goes: after those of farther groups; in a group by step, then by the body's own distance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    group_squared_km2: f64,
    step: Step,
    own_squared_km2: f64,
}

/// The steps of a body with rings, and of the moons around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    MoonsBehindRings,
    FarHalf,
    MoonsBehindGlobe,
    Globe,
    MoonsBehindNearHalf,
    NearHalf,
}

/// Where a moon stands among the layers of its planet; `None`: before them all. `pole`: unit vector of the ring's plane.
fn among_rings(moon: &Ball, planet: &Ball, pole: DVec3) -> Option<Step> {
    let from_planet_km = moon.centre_km - planet.centre_km;
    let (height_km, camera_km) = (pole.dot(from_planet_km), -pole.dot(planet.centre_km));
    let cut = height_km.abs() <= moon.radius_km;
    let beyond = height_km * camera_km < 0.0;
    let before_globe = moon.tangent_squared_km2() < planet.tangent_squared_km2();
    // A camera inside the ring's reach may look outwards at a moon that is nearer than the planet and still behind the far half.
    let outwards = from_planet_km.dot(moon.centre_km) > 0.0 && !moon.overlaps(planet);
    match (cut, beyond, before_globe) {
        (true, _, true) | (false, false, true) => None,
        (true, _, false) | (false, true, false) => Some(Step::MoonsBehindRings),
        (false, true, true) if outwards => Some(Step::MoonsBehindRings),
        (false, true, true) => Some(Step::MoonsBehindNearHalf),
        (false, false, false) => Some(Step::MoonsBehindGlobe),
    }
}

/// Sorts the draws of placed bodies.
pub(crate) fn far_to_near(placed: &[PlacedBody<'_>], mut draws: Vec<Draw>) -> Vec<Draw> {
    let ringed: Vec<NaifId> = draws.iter().filter(|d| d.part == Part::Ring).map(|d| d.body).collect();
    let found = |id: NaifId| placed.iter().find(|p| p.body.id == id);
    let place = |id: NaifId, part: Part| {
        let Some(p) = found(id) else { return Place { group_squared_km2: 0.0, step: Step::Globe, own_squared_km2: 0.0 } };
        let own = Ball::of(p);
        let own_squared_km2 = own.tangent_squared_km2();
        let step = match part {
            Part::RingBehind => Step::FarHalf,
            Part::Ring => Step::NearHalf,
            Part::Sky | Part::Globe | Part::Clouds => Step::Globe,
        };
        let planet = p.body.parent.filter(|parent| ringed.contains(parent)).and_then(found);
        let among = planet.and_then(|planet| {
            let pole = planet.placement.body_from_icrf.transpose() * DVec3::Z;
            Some((Ball::of(planet).tangent_squared_km2(), among_rings(&own, &Ball::of(planet), pole)?))
        });
        let (group_squared_km2, step) = among.unwrap_or((own_squared_km2, step));
        Place { group_squared_km2, step, own_squared_km2 }
    };
    draws.sort_by_cached_key(|d| {
        let at = place(d.body, d.part);
        (Farther(at.group_squared_km2), at.step, Farther(at.own_squared_km2), d.part)
    });
    draws
}

/// How many of the sorted draws are a body's own or lie behind it: what light around that body lies over. Of a body without a draw those that are farther.
pub(crate) fn draws_behind(placed: &[PlacedBody<'_>], draws: &[Draw], body: NaifId) -> usize {
    let distance_km = |id: NaifId| placed.iter().find(|p| p.body.id == id).map_or(0.0, |p| p.distance_km);
    let own_km = distance_km(body);
    let last = draws.iter().rposition(|d| d.body == body).or_else(|| draws.iter().rposition(|d| distance_km(d.body) >= own_km));
    last.map_or(0, |last| last + 1)
}

/// The greater comes first.
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

    /// A sequence of numbers in 0..1 (Weyl's, of the golden ratio's powers).
    fn numbers(seed: u32) -> impl FnMut() -> f64 {
        let mut k = f64::from(seed);
        move || {
            k += 1.0;
            (k * 0.618_033_988_749_895 + (k * k * 0.324_717_957_244_746).fract()).fract()
        }
    }

    fn met(ball: &Ball, along: DVec3) -> Option<f64> {
        let b = ball.centre_km.dot(along);
        let square = ball.radius_km * ball.radius_km - (ball.centre_km - along * b).length_squared();
        (square > 0.0 && b > 0.0).then(|| b - square.sqrt())
    }

    /// Cameras near and far, moons anywhere around a planet with a ring: along each ray that meets two of them the later drawn is the nearer.
    #[test]
    fn along_every_ray_the_nearer_is_drawn_later() {
        let mut next = numbers(7);
        let mut direction = move || {
            let (z, turn) = (2.0 * next() - 1.0, std::f64::consts::TAU * next());
            (DVec3::new(turn.cos(), turn.sin(), 0.0) * (1.0_f64 - z * z).sqrt() + DVec3::Z * z, next(), next())
        };
        let (mut pairs, mut with_ring) = (0, 0);
        for _ in 0..40_000 {
            let (towards, far, size) = direction();
            let (outwards, away, tilt) = direction();
            let (aside, slant, _) = direction();
            // The planet has radius 1, the ring reaches from 1.2 to 2.3.
            let camera = towards * (1.02 + 10f64.powf(7.0 * far * far) - 1.0);
            let moon = Ball { centre_km: outwards * (1.3 + 4.0 * away) - camera, radius_km: 0.02 + 0.1 * size };
            let planet = Ball { centre_km: -camera, radius_km: 1.0 };
            let pole = DVec3::Z;
            // A ray that meets the moon.
            let _ = tilt;
            let along = (moon.centre_km + aside * (moon.radius_km * 0.9 * slant)).normalize();
            let Some(at_moon) = met(&moon, along) else { continue };
            if moon.tangent_squared_km2() < 0.0 {
                continue;
            }
            let before_globe = moon.tangent_squared_km2() < planet.tangent_squared_km2();
            let step = among_rings(&moon, &planet, pole);
            let drawn = step.map_or(if before_globe { 9 } else { -1 }, |s| s as i32);
            if let Some(at_globe) = met(&planet, along) {
                assert_eq!(at_moon < at_globe, drawn > Step::Globe as i32, "{moon:?} {step:?} from {camera}");
                pairs += 1;
            }
            let cut = (moon.centre_km + camera).z.abs() <= moon.radius_km;
            let at_ring = -camera.z / along.z;
            let on_ring = camera + along * at_ring;
            if cut || at_ring <= 0.0 || !(1.2..2.3).contains(&on_ring.length()) {
                continue;
            }
            let half = if on_ring.dot(along) > 0.0 { Step::FarHalf } else { Step::NearHalf };
            assert_eq!(at_moon < at_ring, drawn > half as i32, "{moon:?} {step:?}, {half:?} from {camera}");
            with_ring += 1;
            // The half itself: behind the globe or before it.
            if let Some(at_globe) = met(&planet, along) {
                assert_eq!(at_ring < at_globe, half > Step::Globe, "from {camera} along {along}");
            }
        }
        assert!(pairs > 500 && with_ring > 500, "{pairs} {with_ring}");
    }
}
