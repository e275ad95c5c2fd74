//! What eclipses leave of the light that air scatters many times: more than nothing in an umbra, for it comes from the lit air and ground around.
//!
//! In: a body with its air, and the occluders' outlines of an eclipse's uniforms. Out: for each occluder [`NODES`] factors on the table of [`crate::scene::atmosphere::air_table`] over the
//! distance from the occluder's limb, in solar radii, at [`HEIGHTS`] heights, and one row for the light of the whole sky on level ground. Method: light of the
//! second order comes from where a straight way through the air met sunlit air or ground; how far away that is, and how much comes from there, is summed over
//! directions as the table does, and each distance sees the mean over all sides of what the occluder leaves of the Sun's disc. Further orders spread
//! once more each. Always holds: 1 outside of the penumbra's blurred edge, in 0 to 1 everywhere. Left out: that sides differ (the umbra counts as a circle across the
//! light, drawn out along the ground by the Sun's height), the change of the Sun's height within the shadow, how much of the curved Earth lies under the way's far
//! end, and that what two occluders' shadows share is spread twice.
//! Error: against photons followed one by one through the same eclipse within 40 % where a thousandth of the light is left (tests/eclipse/totality.rs).

use crate::catalog::{Atmosphere, Body};
use crate::scene::atmosphere::extinction::{self, extinction, scattering};
use crate::scene::camera;
use crate::scene::draw::{EclipseUniforms, MAX_OCCLUDERS};
use glam::{DVec2, DVec3, Vec4};
use std::f64::consts::{PI, TAU};

/// Rows of [`crate::scene::atmosphere::air_table`] from the ground up: 0, 2, 8 and 18 km in the Earth's 100 km of air. Above the last one its values go on.
pub use crate::scene::constants::SPREAD_HEIGHTS as HEIGHTS;
/// The heights' rows, then one of the light on level ground.
pub const ROWS: usize = HEIGHTS + 1;
/// Distances from the occluder's limb, close together in the middle of the shadow.
pub use crate::scene::constants::SPREAD_COLUMNS as COLUMNS;
pub const NODES: usize = ROWS * COLUMNS;
/// Where the rows begin that say how far each occluder's columns reach, and of how many rows all is.
pub const REACHES: usize = NODES * MAX_OCCLUDERS as usize;
pub const TABLES: usize = REACHES + MAX_OCCLUDERS as usize;

/// What it is, for a reader.
pub(crate) const SAID: &str = "scattered from the lit air and ground around, within 40 % where a thousandth is left";

const SLOPES: usize = 32;
const STEPS: usize = 24;
/// Distances over the ground: the first holds all below, each next one reaches 1.41 times as far.
const BINS: usize = 18;
const FIRST_KM: f64 = 2.0;
/// Sides that a distance is averaged over.
const SIDES: usize = 12;
/// Rounds of further scattering; each adds less than half of the one before.
const ORDERS: usize = 4;
const MAX_AGAIN: f64 = 0.98;
/// Beyond so many kilometres nothing is spread into a shadow: eight free paths of red light.
const REACH_KM: f64 = 600.0;
/// The lowest Sun: below it the shadow leaves the planet.
const MIN_SUN: f64 = 0.05;
const EDGE_NODES: usize = 96;
const RINGS: usize = 40;

/// For one occluder: where the columns lie and the factors' roots.
struct Shadow {
    /// Radius of the occluder in solar radii.
    occluder: f64,
    /// Kilometres across the light to a solar radius.
    km: f64,
    sun_cosine: f64,
    from: f64,
    to: f64,
    /// What is left of the Sun over the distance from the occluder's limb, -1 to 1.
    left: Vec<DVec3>,
    sides: [(DVec2, DVec2); SIDES],
}

impl Shadow {
    fn of(body: &Body, eclipse: &EclipseUniforms, index: usize) -> Option<Self> {
        let (place, shape) = (eclipse.places.get(index)?.as_dvec4(), eclipse.shapes.get(index)?.as_dvec4());
        let across = place.truncate().truncate();
        // Where the axis meets the ground, or passes it.
        let along = (1.0 - across.length_squared()).max(0.0).sqrt();
        let depth = place.z - along;
        let per_radius = f64::from(eclipse.across[0].w) * (1.0 - along * f64::from(eclipse.axis.w)) / depth;
        if !(depth > 0.0 && per_radius > 0.0 && per_radius.is_finite()) {
            return None;
        }
        let occluder = (shape.z * shape.w).sqrt() * per_radius;
        let km = body.radii_km.x / per_radius;
        let margin = REACH_KM / km;
        let laws = eclipse.limb.map(|l| l.truncate().as_dvec3());
        let left = (0..EDGE_NODES).map(|k| left_of_sun(occluder, -1.0 + 2.0 * k as f64 / (EDGE_NODES - 1) as f64, &laws)).collect();
        let sun_cosine = along.max(MIN_SUN);
        Some(Self { occluder, km, sun_cosine, from: (-1.0 - margin).max(-occluder), to: 1.0 + margin, left, sides: sides(sun_cosine) })
    }

    /// What is left of the Sun at a distance from the occluder's centre.
    fn left(&self, distance: f64) -> DVec3 {
        let edge = distance - self.occluder;
        if edge >= 1.0 {
            return DVec3::ONE;
        }
        let at = (0.5 * (edge + 1.0)).max(0.0) * (EDGE_NODES - 1) as f64;
        let k = (at as usize).min(EDGE_NODES - 2);
        self.left[k].lerp(self.left[k + 1], at - k as f64)
    }

    /// Distance from the occluder's centre at a column.
    fn distance(&self, column: usize) -> f64 {
        self.occluder + self.from + (self.to - self.from) * (column as f64 / (COLUMNS - 1) as f64).powi(2)
    }

    /// A row of roots between its columns.
    fn between(&self, row: &[DVec3], distance: f64) -> DVec3 {
        let x = ((distance - self.occluder - self.from) / (self.to - self.from)).clamp(0.0, 1.0).sqrt() * (COLUMNS - 1) as f64;
        let k = (x as usize).min(COLUMNS - 2);
        let root = row[k].lerp(row[k + 1], x - k as f64);
        root * root
    }

    /// Mean of a quantity over all sides of a place, so many kilometres over the ground from it.
    fn around(&self, distance: f64, way_km: f64, what: impl Fn(f64) -> DVec3) -> DVec3 {
        let way = way_km / self.km;
        let side = |(from, to): &(DVec2, DVec2)| what((*from * distance + *to * way).length());
        self.sides.iter().map(side).sum::<DVec3>() / SIDES as f64
    }
}

/// Unit vectors to a place from the shadow's axis, and from the place over the ground, across the light.
fn sides(sun_cosine: f64) -> [(DVec2, DVec2); SIDES] {
    std::array::from_fn(|k| {
        // The place itself lies on any side of the axis: the golden section spreads both angles evenly.
        let (sin, cos) = (TAU * (k as f64 + 0.5) / SIDES as f64).sin_cos();
        (DVec2::from_angle(PI * (k as f64 * 0.618_033_988_749).fract()), DVec2::new(sun_cosine * cos, sin))
    })
}

/// Part of the Sun's light past a circle of radius `occluder` whose limb is `edge` beyond the Sun's centre (below 0: it covers the centre).
fn left_of_sun(occluder: f64, edge: f64, laws: &[DVec3; 3]) -> DVec3 {
    let apart = (occluder + edge).max(0.0);
    let ring = |k: usize| {
        let r = (k as f64 + 0.5) / RINGS as f64;
        let mu = (1.0 - r * r).sqrt();
        let law = laws[0] + laws[1] * mu + laws[2] * (mu * mu);
        let cosine = (r * r + apart * apart - occluder * occluder) / (2.0 * r * apart).max(1e-12);
        law * (TAU * r * (1.0 - cosine.clamp(-1.0, 1.0).acos() / PI) / RINGS as f64)
    };
    let whole: DVec3 = (0..RINGS)
        .map(|k| {
            let r = (k as f64 + 0.5) / RINGS as f64;
            let mu = (1.0 - r * r).sqrt();
            (laws[0] + laws[1] * mu + laws[2] * (mu * mu)) * (TAU * r / RINGS as f64)
        })
        .sum();
    ((0..RINGS).map(ring).sum::<DVec3>() / whole.max(DVec3::splat(1e-12))).clamp(DVec3::ZERO, DVec3::ONE)
}

fn each(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

/// How much comes from which distance over the ground.
#[derive(Clone)]
struct Sources {
    parts: [DVec3; BINS],
    /// Sums of distances by part, green.
    ways_km: [f64; BINS],
}

impl Sources {
    const NONE: Self = Self { parts: [DVec3::ZERO; BINS], ways_km: [0.0; BINS] };

    fn add(&mut self, way_km: f64, part: DVec3) {
        let bin = (2.0 * (way_km / FIRST_KM).max(1.0).log2()).ceil().min((BINS - 1) as f64) as usize;
        self.parts[bin] += part;
        self.ways_km[bin] += way_km * part.y;
    }

    fn whole(&self) -> DVec3 {
        self.parts.iter().copied().sum()
    }

    /// What arrives of it where each source has the strength `what` of its distance from the occluder's centre.
    fn seen(&self, shadow: &Shadow, distance: f64, what: impl Fn(f64) -> DVec3) -> DVec3 {
        let bins = self.parts.iter().zip(&self.ways_km).filter(|(part, _)| part.max_element() > 0.0);
        bins.map(|(part, variants)| *part * shadow.around(distance, variants / part.y.max(1e-300), &what)).sum()
    }
}

struct Air<'a> {
    radius_km: f64,
    air: &'a Atmosphere,
    ground: DVec3,
}

impl Air<'_> {
    fn height_km(&self, row: usize) -> f64 {
        self.air.top_km * (row as f64 / (crate::scene::atmosphere::air_table::HEIGHTS - 1) as f64).powi(2)
    }

    fn sum(&self, height_km: f64, what: fn(&crate::catalog::Species) -> DVec3) -> DVec3 {
        extinction::sum(self.air, height_km, what)
    }

    /// Transmittance towards a Sun that is not low.
    fn sunlight(&self, height_km: f64, sun_cosine: f64) -> DVec3 {
        let above = |s: &crate::catalog::Species| match s.tent_centre_km {
            None => s.scale_height_km * (-height_km / s.scale_height_km).exp(),
            Some(centre) => {
                let x = ((height_km - centre) / s.scale_height_km).clamp(-1.0, 1.0);
                s.scale_height_km * (0.5 - x + 0.5 * x * x.abs())
            }
        };
        let depth: DVec3 = self.air.species.iter().map(|s| extinction(s) * above(s)).sum();
        each(depth, |d| (-d / sun_cosine).exp())
    }

    /// Follows a way from a height; tells what scatters on it, at which distance over the ground and height. Answers how far away it meets the ground, and what
    /// comes through from there.
    fn way(&self, height_km: f64, slope: f64, mut scatters: impl FnMut(f64, f64, DVec3)) -> Option<(f64, DVec3)> {
        let r = self.radius_km + height_km.max(1e-4);
        let (b, low) = (r * slope, r * r * (1.0 - slope * slope));
        let to_ground = self.radius_km * self.radius_km - low;
        let hits = slope < 0.0 && to_ground > 0.0;
        let top = (self.radius_km + self.air.top_km).powi(2) - low;
        let way_km = if hits { -b - to_ground.sqrt() } else { -b + top.max(0.0).sqrt() }.max(0.0);
        let over = |s: f64| self.radius_km * (s * (1.0 - slope * slope).sqrt()).atan2(r + s * slope);
        let mut through = DVec3::ONE;
        for k in 0..STEPS {
            let u = (k as f64 + 0.5) / STEPS as f64;
            let (s, step) = (way_km * u * u, way_km * 2.0 * u / STEPS as f64);
            let h = ((low + (b + s).powi(2)).sqrt() - self.radius_km).max(0.0);
            let depth = self.sum(h, extinction) * step;
            let cell = each(depth, |d| if d > 1e-6 { -(-d).exp_m1() / d } else { 1.0 });
            scatters(over(s), h, through * self.sum(h, scattering) * cell * step);
            through *= each(depth, |d| (-d).exp());
        }
        hits.then(|| (over(way_km), through))
    }

    /// Of a height: sources of light of the second order, and of light that scatters again.
    fn sources(&self, row: usize, sun_cosine: f64) -> (Sources, Sources) {
        let (mut second, mut again) = (Sources::NONE, Sources::NONE);
        for (slope, weight) in slopes() {
            let ground = self.way(self.height_km(row), slope, |way, h, part| {
                second.add(way, part * self.sunlight(h, sun_cosine) * (weight / (4.0 * PI)));
                again.add(way, part * weight);
            });
            if let Some((way, through)) = ground {
                second.add(way, through * self.ground * self.sunlight(0.0, sun_cosine) * (weight * sun_cosine / PI));
            }
        }
        (second, again)
    }
}

/// Slopes from straight down to straight up, close together at the horizon; weights sum to 1.
fn slopes() -> impl Iterator<Item = (f64, f64)> {
    let half = SLOPES / 2;
    (0..half).flat_map(move |k| {
        let u = (k as f64 + 0.5) / half as f64;
        let weight = u / half as f64;
        [(u * u, weight), (-u * u, weight)]
    })
}

/// The tables of all occluders that a draw may count, each [`NODES`] roots, then for each occluder where its columns begin and one over how far they reach. Without
/// air, and for occluders that are not there, all is 1.
pub fn tables(body: &Body, eclipse: &EclipseUniforms) -> Vec<Vec4> {
    let mut all = vec![Vec4::ONE; TABLES];
    for index in 0..eclipse.places.len().min(usize::from(MAX_OCCLUDERS)) {
        let shadow = body.atmosphere.as_ref().and_then(|air| Some((air, Shadow::of(body, eclipse, index)?)));
        let Some((air, shadow)) = shadow else { continue };
        let air = Air { radius_km: body.radii_km.x, air, ground: DVec3::from_array(body.target_mean_colour()) };
        for (to, root) in all[index * NODES..].iter_mut().zip(roots(&air, &shadow)) {
            *to = camera::narrow(root).extend(0.0);
        }
        let reach = DVec3::new(shadow.from, 1.0 / (shadow.to - shadow.from), 0.0);
        all[REACHES + index] = camera::narrow(reach).extend(0.0);
    }
    all
}

fn roots(air: &Air<'_>, shadow: &Shadow) -> Vec<DVec3> {
    let root = |v: DVec3| each(v, |x| x.clamp(0.0, 1.0).sqrt());
    let heights: Vec<(Sources, Sources)> = (0..HEIGHTS).map(|row| air.sources(row, shadow.sun_cosine)).collect();
    let mut rows = Vec::new();
    for (second, again) in &heights {
        let most = each(again.whole(), |a| a.min(MAX_AGAIN));
        let once: Vec<DVec3> = (0..COLUMNS)
            .map(|c| second.seen(shadow, shadow.distance(c), |d| shadow.left(d)) / second.whole().max(DVec3::splat(1e-300)))
            .collect();
        let mut row: Vec<DVec3> = once.iter().map(|v| root(*v)).collect();
        for _ in 0..ORDERS {
            let next = |c: usize| {
                let spread = again.seen(shadow, shadow.distance(c), |d| shadow.between(&row, d)) / again.whole().max(DVec3::splat(1e-300));
                root(once[c] * (DVec3::ONE - most) + spread * most)
            };
            row = (0..COLUMNS).map(next).collect();
        }
        rows.extend(row);
    }
    let ground = on_ground(air, shadow, &heights, &rows);
    rows.extend(ground.into_iter().map(root));
    for last in (0..ROWS).map(|r| (r + 1) * COLUMNS - 1) {
        rows[last] = DVec3::ONE;
    }
    rows
}

/// Part of the whole sky's light on level ground that is left.
fn on_ground(air: &Air<'_>, shadow: &Shadow, heights: &[(Sources, Sources)], rows: &[DVec3]) -> Vec<DVec3> {
    // What shines at a height per unit of scattering: sunlight scattered once, and all further orders.
    let many: Vec<DVec3> =
        heights.iter().map(|(second, again)| second.whole() / (DVec3::ONE - each(again.whole(), |a| a.min(MAX_AGAIN)))).collect();
    let mut once = Sources::NONE;
    let mut further = vec![Sources::NONE; HEIGHTS];
    for (slope, weight) in slopes().filter(|(slope, _)| *slope > 0.0) {
        let weight = weight * slope;
        let scatters = |way: f64, h: f64, part: DVec3| {
            once.add(way, part * air.sunlight(h, shadow.sun_cosine) * (weight / (4.0 * PI)));
            let at = ((h / air.air.top_km).sqrt() * (crate::scene::atmosphere::air_table::HEIGHTS - 1) as f64).min((HEIGHTS - 1) as f64);
            let (below, up) = ((at as usize).min(HEIGHTS - 2), at - (at as usize).min(HEIGHTS - 2) as f64);
            further[below].add(way, part * many[below] * (weight * (1.0 - up)));
            further[below + 1].add(way, part * many[below + 1] * (weight * up));
        };
        air.way(0.0, slope, scatters);
    }
    let whole = once.whole() + further.iter().map(Sources::whole).sum::<DVec3>();
    let left = |c: usize| {
        let distance = shadow.distance(c);
        let row = |r: usize| &rows[r * COLUMNS..(r + 1) * COLUMNS];
        let of_further = |r: usize| further[r].seen(shadow, distance, |d| shadow.between(row(r), d));
        let light = once.seen(shadow, distance, |d| shadow.left(d)) + (0..HEIGHTS).map(of_further).sum::<DVec3>();
        light / whole.max(DVec3::splat(1e-300))
    };
    (0..COLUMNS).map(left).collect()
}
