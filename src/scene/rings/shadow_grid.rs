//! The shadow of another body's rings on a body, place by place: the dark line of Saturn's rings on Rhea, the edges of Cassini's Division on Iapetus.
//!
//! In: the sunlight of a lit body, and the rings before the Sun. Out: a square grid of the fraction of sunlight that passes the rings, per channel, and the
//! axes of its places. A ray to the Sun meets the rings in the same place, whatever point of the ray is lit, and a body is small compared with the way to the
//! rings: so the fraction depends on the place across the direction to the Sun alone. It is the mean over the limb-darkened disc of the Sun. As in `rings_before_sun`, the light that the owner's globe blocks does not count. f64 throughout. Always:
//! exactly 1 where no ray of the Sun's disc passes a ring. Not here: the grid in a draw, and the cache of grids (`shadow_on_body`).
//!
//! The Sun's disc is divided into strips parallel to the rings' plane, because a low Sun's rays of one strip have one slant, and into cells. The rays of a cell
//! meet the plane in a range of radii, over which the mean of what the rings block is the difference of two integrals.
//!
//! Errors (docs/accuracy.md): 0.03 of the light, rms 0.002, mostly by the spacing of places. Not modelled: the thickness of the rings; the body's own depth,
//! which changes the width of the penumbra by the body's radius divided by the distance to the rings: 0.4 % for Mimas, less for the larger moons.

use crate::scene::rings::phase::MIN_COSINE;
use crate::scene::rings::ring_table::RingInterval;
use crate::scene::rings::rings_before_sun::{Beam, is_blocked};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Limits of the number of places along a side of the grid.
const SIDES: (f64, f64) = (16.0, 96.0);
/// Places per radius of the penumbra of an opaque ring, within these limits.
const PLACES_PER_PENUMBRA: f64 = 5.0;
/// Strips of the Sun's disc and cells of a strip, for a Sun nearer to the rings' plane than [`LOW_SUN_RADII`] of its radii, and for a higher one.
const CELLS_OF_LOW_SUN: (usize, usize) = (48, 4);
const CELLS_OF_HIGH_SUN: (usize, usize) = (16, 6);
const LOW_SUN_RADII: f64 = 40.0;
/// Bins of radius, at whose ends the integral of the blocked fraction is stored.
const BINS: usize = 4096;

/// A cell of the Sun's disc.
struct Cell {
    /// Its middle, parallel to the rings' plane; radii of the disc.
    u: f64,
    /// Its light, per channel.
    light: DVec3,
}

/// A strip of the Sun's disc, parallel to the rings' plane. Lengths are in radii of the disc.
struct Strip {
    /// Heights above the disc's centre: of the middle and of the upper edge. The lower edge is the upper one of the strip below.
    middle: f64,
    upper: f64,
    /// Half the strip's length, and half the width of its cells.
    reach: f64,
    half_width: f64,
    cells: Vec<Cell>,
    light: DVec3,
    /// Integral of the blocked fraction over radius, from the innermost radius to the ends of the bins.
    blocked_within: Vec<f64>,
}

/// Where rays from one point to a line of the Sun's disc parallel to the rings' plane meet this plane.
#[derive(Clone, Copy)]
struct Crossing {
    /// For the middle of the disc's line.
    middle: DVec2,
    /// Change per radius of the disc along its line.
    step: DVec2,
}

impl Crossing {
    fn at(self, u: f64) -> DVec2 {
        self.middle + self.step * u
    }
}

/// The rings between one body and the Sun. Axes and lengths as in [`Beam`].
pub(super) struct ShadedSun {
    beam: Beam,
    /// Half the grid's side.
    half_side: f64,
    /// Unit vectors across the direction to the Sun: parallel to the rings' plane, and perpendicular to that.
    pub x: DVec3,
    pub y: DVec3,
    strips: Vec<Strip>,
    /// Innermost and outermost radius; the number of bins per length between them, and half the width of a bin.
    radii: [f64; 2],
    bins_per_length: f64,
    half_bin: f64,
    /// Semi-axes of the owner's globe; `None` if it is far from the light.
    globe: Option<DVec3>,
}

/// Integral of the blocked fraction over radius from the first radius to the ends of [`BINS`] equal bins, for one slant of light.
fn blocked_within(intervals: &[RingInterval], cosine: f64, [inner, outer]: [f64; 2]) -> Vec<f64> {
    let blocked: Vec<f64> = intervals.iter().map(|i| -(-i.tau / cosine).exp_m1()).collect();
    let mut interval = intervals.partition_point(|i| i.outer <= inner);
    let (mut integral, mut reached) = (0.0, inner);
    let mut integrals = Vec::with_capacity(BINS + 1);
    integrals.push(0.0);
    for bin in 1..=BINS {
        let end = inner + (outer - inner) * (bin as f64 / BINS as f64);
        while interval < intervals.len() && intervals[interval].outer <= end {
            integral += blocked[interval] * (intervals[interval].outer - reached);
            reached = intervals[interval].outer;
            interval += 1;
        }
        if interval < intervals.len() {
            integral += blocked[interval] * (end - reached);
            reached = end;
        }
        integrals.push(integral);
    }
    integrals
}

/// Number of places along a side of the grid, by the radius of the penumbra of each ring's outer edge. For the same error the penumbra of a ring that blocks
/// little light needs fewer places: the error of linear interpolation increases with the step in light, and with the square of the spacing.
pub(super) fn places_along_side(beam: &Beam, intervals: &[RingInterval], half_side: f64) -> usize {
    let (distance, to_sun) = (beam.body.length(), beam.sun - beam.body);
    let cosine = beam.smallest_cosine();
    let places = |interval: &RingInterval| {
        let penumbra = beam.sun_radius / to_sun.length() * (distance - interval.outer).max(0.1 * distance);
        2.0 * half_side / penumbra * PLACES_PER_PENUMBRA * (-(-interval.tau / cosine).exp_m1()).sqrt()
    };
    let (fewest, most) = SIDES;
    intervals.iter().map(places).fold(fewest, f64::max).ceil().min(most) as usize
}

impl ShadedSun {
    /// `globe`: semi-axes of the rings' owner. `None` if no ring takes a visible part of the light.
    pub fn of(beam: Beam, intervals: &[RingInterval], globe: DVec3, (u1, u2): (DVec3, DVec3), half_side: f64) -> Option<Self> {
        let radii = [intervals.iter().find(|i| i.tau > 0.0)?.inner, beam.outer_radius(intervals)?];
        let to_sun = beam.sun - beam.body;
        let sunward = to_sun.try_normalize()?;
        let x = DVec3::Z.cross(sunward).try_normalize().unwrap_or(DVec3::X);
        let y = sunward.cross(x);
        let is_low = to_sun.z.abs() < LOW_SUN_RADII * beam.sun_radius;
        let (strip_count, cell_count) = if is_low { CELLS_OF_LOW_SUN } else { CELLS_OF_HIGH_SUN };
        let thickness = 2.0 / strip_count as f64;
        let strip = |k: usize| {
            let lower = k as f64 * thickness - 1.0;
            let middle = lower + 0.5 * thickness;
            let reach = (1.0 - middle * middle).sqrt();
            let half_width = reach / cell_count as f64;
            let cell = |j: usize| {
                let u = (2 * j + 1) as f64 * half_width - reach;
                let one_minus_mu = 1.0 - (1.0 - u * u - middle * middle).max(0.0).sqrt();
                let radiance = DVec3::ONE - u1 * one_minus_mu - u2 * (one_minus_mu * one_minus_mu);
                // All strips are equally thick, so the area is proportional to the width.
                Cell { u, light: radiance * half_width }
            };
            let cells: Vec<Cell> = (0..cell_count).map(cell).collect();
            let light = cells.iter().map(|c| c.light).sum();
            let slanted = to_sun + y * (middle * beam.sun_radius);
            let cosine = (slanted.z.abs() / slanted.length()).max(MIN_COSINE);
            let blocked_within = blocked_within(intervals, cosine, radii);
            Strip { middle, upper: lower + thickness, reach, half_width, cells, light, blocked_within }
        };
        let strips = (0..strip_count).into_par_iter().map(strip).collect();
        let along = beam.body.dot(sunward);
        let beside_globe = (beam.body - sunward * along).length() - half_side - beam.sun_radius * along.abs() / to_sun.length();
        let globe = (along < 0.0 && beside_globe < globe.max_element()).then_some(globe);
        let bins_per_length = BINS as f64 / (radii[1] - radii[0]);
        Some(Self { beam, half_side, x, y, strips, radii, bins_per_length, half_bin: 0.5 / bins_per_length, globe })
    }

    /// Number of places along a side of the grid.
    pub fn side(&self, intervals: &[RingInterval]) -> usize {
        places_along_side(&self.beam, intervals, self.half_side)
    }

    /// A place of the grid, from its centre, along `x` and `y`.
    pub fn place(&self, index: usize, side: usize) -> DVec2 {
        let [column, row] = [index % side, index / side].map(|k| k as f64 / (side - 1) as f64);
        DVec2::new(column, row) * (2.0 * self.half_side) - self.half_side
    }

    /// The fraction at every place of the grid, row by row. Places in the corners, which no lit point of the body is next to, have 1.
    pub fn fractions(&self, side: usize) -> Vec<DVec3> {
        // Shaders read the four corners of a square with the spacing as its side.
        let farthest = self.half_side + 1.5 * (2.0 * self.half_side / (side - 1) as f64);
        let fraction = |k: usize| {
            let place = self.place(k, side);
            if place.length() > farthest { DVec3::ONE } else { self.fraction(place) }
        };
        (0..side * side).into_par_iter().map(fraction).collect()
    }

    /// The fraction of sunlight that passes the rings to a place, per channel: of the light that passes the globe or, where the globe blocks all of it, of all.
    fn fraction(&self, place: DVec2) -> DVec3 {
        let point = self.beam.body + self.x * place.x + self.y * place.y;
        let to_sun = self.beam.sun - point;
        let (mut light, mut blocked) = (DVec3::ZERO, DVec3::ZERO);
        let (mut light_past_globe, mut blocked_past_globe) = (DVec3::ZERO, DVec3::ZERO);
        let edge = |height: f64| self.crossing(point, to_sun + self.y * (height * self.beam.sun_radius));
        let mut lower = edge(-1.0);
        for strip in &self.strips {
            let upper = edge(strip.upper);
            let crossings = [lower, upper];
            lower = upper;
            let meets_rings = self.meets_rings(strip, crossings);
            if self.globe.is_none() && !meets_rings {
                light += strip.light;
                continue;
            }
            for cell in &strip.cells {
                let blocked_by_cell = if meets_rings { cell.light * self.blocked(strip, crossings, cell.u) } else { DVec3::ZERO };
                light += cell.light;
                blocked += blocked_by_cell;
                let ray = to_sun + (self.x * cell.u + self.y * strip.middle) * self.beam.sun_radius;
                if self.globe.is_some_and(|axes| !is_blocked(axes, point, ray)) {
                    light_past_globe += cell.light;
                    blocked_past_globe += blocked_by_cell;
                }
            }
        }
        if light_past_globe.min_element() > 0.0 {
            (light, blocked) = (light_past_globe, blocked_past_globe);
        }
        (DVec3::ONE - blocked / light).max(DVec3::ZERO)
    }

    /// Where rays from a point to a line of the Sun's disc meet the rings' plane; `None` if they do not. `to_disc`: vector from the point to the line's middle.
    fn crossing(&self, point: DVec3, to_disc: DVec3) -> Option<Crossing> {
        // Part of the way to the disc. `x` is parallel to the plane, so it is the same for the whole line.
        let part = -point.z / to_disc.z;
        let is_between = part > 0.0 && part < 1.0;
        is_between.then(|| Crossing {
            middle: point.truncate() + to_disc.truncate() * part,
            step: self.x.truncate() * (self.beam.sun_radius * part),
        })
    }

    /// Whether rays to a strip may meet a ring. A quick test, which errs on the side of yes.
    fn meets_rings(&self, strip: &Strip, crossings: [Option<Crossing>; 2]) -> bool {
        let [inner, outer] = self.radii;
        match crossings {
            [None, None] => false,
            [Some(a), Some(b)] => {
                // The places of all rays are between those of the edges; they may pass the axis of the rings, so the distance from it has no lower limit but 0.
                let reach = strip.reach * a.step.length().max(b.step.length());
                let from_middle = 0.5 * (a.middle + b.middle).length();
                let spread = 0.5 * (a.middle - b.middle).length() + reach;
                from_middle - spread <= outer && from_middle + spread >= inner
            }
            [Some(_), None] | [None, Some(_)] => true,
        }
    }

    /// Mean fraction of the light that rings block, over the rays of a strip around `u`.
    fn blocked(&self, strip: &Strip, crossings: [Option<Crossing>; 2], u: f64) -> f64 {
        // Not `crossings.map`, which the compiler does not inline here: it took a third of the time.
        let (a, b) = (crossings[0].map(|c| c.at(u)), crossings[1].map(|c| c.at(u)));
        let (Some(a), Some(b)) = (a, b) else {
            // Rays parallel to the plane meet it nowhere, those close to them far outside the rings.
            let far = 100.0 * self.radii[1];
            return a.or(b).map_or(0.0, |place| self.mean_blocked(strip, place.length(), far, 0.0));
        };
        // Half the change of radius over the width of a cell.
        let step = crossings[0].map_or(DVec2::ZERO, |c| c.step);
        let (from, to) = (a.length(), b.length());
        let change_across = a.dot(step) * strip.half_width / from.max(1e-9);
        let mean = |from: f64, to: f64| self.mean_blocked(strip, from, to, change_across);
        // Where the places are nearest to the axis of the rings, as a part of the way from `a` to `b`. There the radius ends to decrease.
        let way = b - a;
        let part = -a.dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
        if part > 0.0 && part < 1.0 {
            let nearest = (a + way * part).length();
            return part * mean(from, nearest) + (1.0 - part) * mean(nearest, to);
        }
        mean(from, to)
    }

    /// Mean of the blocked fraction between two radii. `change_across`: half the length of another range, over which the mean is taken, too.
    fn mean_blocked(&self, strip: &Strip, from: f64, to: f64, change_across: f64) -> f64 {
        let half_range = DVec2::new(0.5 * (to - from), change_across).length().max(self.half_bin);
        let middle = 0.5 * (from + to);
        (self.within(strip, middle + half_range) - self.within(strip, middle - half_range)) / (2.0 * half_range)
    }

    /// Integral of the blocked fraction over radius up to `radius`.
    fn within(&self, strip: &Strip, radius: f64) -> f64 {
        let bin = ((radius - self.radii[0]) * self.bins_per_length).clamp(0.0, BINS as f64);
        let index = (bin as usize).min(BINS - 1);
        let [from, to] = [strip.blocked_within[index], strip.blocked_within[index + 1]];
        from + (to - from) * (bin - index as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::random::Random;
    use crate::scene::rings::ring_light::transmittance;
    use crate::scene::rings::ring_table::RingTables;
    use crate::units::GOLDEN_ANGLE_RAD;

    const LIMB_DARKENING: (DVec3, DVec3) = (DVec3::new(0.37, 0.47, 0.61), DVec3::new(0.24, 0.23, 0.21));

    /// The fraction at a place, by rays from it to many points of the Sun's disc, and the part of these rays that passes the globe.
    fn fraction_by_rays(shadow: &ShadedSun, intervals: &[RingInterval], place: DVec2) -> (DVec3, f64) {
        const RAYS: u32 = 8000;
        let beam = &shadow.beam;
        let point = beam.body + shadow.x * place.x + shadow.y * place.y;
        let (mut light, mut transmitted, mut past_globe) = (DVec3::ZERO, DVec3::ZERO, 0);
        for k in 0..RAYS {
            let radius_sq = (f64::from(k) + 0.5) / f64::from(RAYS);
            let on_sun = DVec2::from_angle(f64::from(k) * GOLDEN_ANGLE_RAD) * radius_sq.sqrt();
            let towards = beam.sun + (shadow.x * on_sun.x + shadow.y * on_sun.y) * beam.sun_radius - point;
            if shadow.globe.is_some_and(|axes| is_blocked(axes, point, towards)) {
                continue;
            }
            let one_minus_mu = 1.0 - (1.0 - radius_sq).sqrt();
            let radiance = DVec3::ONE - LIMB_DARKENING.0 * one_minus_mu - LIMB_DARKENING.1 * (one_minus_mu * one_minus_mu);
            past_globe += 1;
            light += radiance;
            transmitted += radiance * transmittance(intervals, point, towards.normalize());
        }
        (transmitted / light.max(DVec3::splat(f64::MIN_POSITIVE)), f64::from(past_globe) / f64::from(RAYS))
    }

    /// What a shader reads from the grid.
    fn fraction_in_grid(grid: &[DVec3], side: usize, half_side: f64, place: DVec2) -> DVec3 {
        let position = (place + half_side) * ((side - 1) as f64 / (2.0 * half_side));
        let low = position.floor().min(DVec2::splat((side - 2) as f64));
        let weight = position - low;
        let at = |column: usize, row: usize| grid[(low.y as usize + row) * side + low.x as usize + column];
        at(0, 0).lerp(at(1, 0), weight.x).lerp(at(0, 1).lerp(at(1, 1), weight.x), weight.y)
    }

    /// Planet, name, distance and radius in km, distance of the Sun in au, inner and outer radius of its dense rings in km.
    type MoonBehindRings = (i32, &'static str, f64, f64, f64, [f64; 2]);

    /// Moons of all sizes, near and far from their planet.
    const MOONS: [MoonBehindRings; 6] = [
        (699, "Mimas", 185_539.0, 198.0, 9.5, [74_500.0, 140_300.0]),
        (699, "Rhea", 527_068.0, 764.0, 9.5, [74_500.0, 140_300.0]),
        (699, "Titan", 1_221_865.0, 3275.0, 9.5, [74_500.0, 140_300.0]),
        (699, "Iapetus", 3_560_854.0, 735.0, 9.5, [74_500.0, 140_300.0]),
        (799, "Ariel", 190_900.0, 579.0, 19.2, [41_800.0, 51_200.0]),
        (799, "Oberon", 583_500.0, 761.0, 19.2, [41_800.0, 51_200.0]),
    ];

    /// A beam whose middle crosses the rings' plane at a place, from a moon of the given distance and radius. `elevation_deg`: the Sun's.
    fn beam(crossing: DVec3, elevation_deg: f64, (distance, radius): (f64, f64), (sun_distance, sun_radius): (f64, f64)) -> Beam {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let sunward = DVec3::new(cos, 0.0, sin);
        let along = crossing.dot(sunward);
        let length = along + (along * along - crossing.length_squared() + distance * distance).sqrt();
        let body = crossing - sunward * length;
        Beam { body, body_radius: radius, sun: body + sunward * sun_distance, sun_radius }
    }

    /// Random places on moons of Saturn and Uranus behind their rings, under a Sun from 0.0001 to 25 degrees above the rings' plane: the grid against rays to
    /// 8,000 points of the Sun's disc, per channel, and the mean over each moon's disc against [`Beam::fraction_through`]. Largest error of 15,000 places:
    /// 0.026. Negative control: the factor of the whole moon in place of the grid.
    #[test]
    fn the_grid_is_the_sum_over_the_suns_disc() {
        let catalog = Catalog::embedded();
        let mut random = Random::new(3);
        let (mut largest, mut sum_sq, mut places, mut error_of_factor, mut error_of_mean) = (0.0_f64, 0.0, 0, 0.0_f64, 0.0_f64);
        for (planet, moon, distance_km, radius_km, sun_au, [inner_km, outer_km]) in MOONS {
            let owner = catalog.body(NaifId(planet)).expect("in the catalog");
            let unit_km = owner.radii_km.x;
            let intervals = RingTables::default().intervals(owner.rings.iter(), unit_km);
            let (radius, globe) = (radius_km / unit_km, owner.radii_km / unit_km);
            for _ in 0..8 {
                let elevation_deg = 10.0_f64.powf(random.between(-4.0, 1.4));
                let angle_rad = random.between(0.0, std::f64::consts::TAU);
                let crossing = (DVec2::from_angle(angle_rad) * (random.between(inner_km, outer_km) / unit_km)).extend(0.0);
                let sun = (sun_au * 149_597_870.7 / unit_km, 695_700.0 / unit_km);
                let beam = beam(crossing, elevation_deg, (distance_km / unit_km, radius), sun);
                let Some(factor) = beam.fraction_through(&intervals, globe, LIMB_DARKENING) else { continue };
                let shadow = ShadedSun::of(beam, &intervals, globe, LIMB_DARKENING, radius).expect("rings in front of the Sun");
                let side = shadow.side(&intervals);
                let grid = shadow.fractions(side);
                for _ in 0..12 {
                    let place = DVec2::from_angle(random.between(0.0, std::f64::consts::TAU)) * (radius * random.unit_interval().sqrt());
                    let (expected, past_globe) = fraction_by_rays(&shadow, &intervals, place);
                    // The globe's shadow dims what the grid lets through.
                    let error = past_globe * (fraction_in_grid(&grid, side, radius, place) - expected).abs().max_element();
                    assert!(error < 0.03, "{moon}, the Sun {elevation_deg} degrees high, {place}: {error}");
                    largest = largest.max(error);
                    sum_sq += error * error;
                    places += 1;
                    error_of_factor = error_of_factor.max(past_globe * (factor - expected).abs().max_element());
                }
                // As `fraction_through` counts places: by the cosine of incidence. Not if a part of the disc is in the globe's shadow.
                if shadow.globe.is_none() {
                    let weight = |k: usize| (1.0 - shadow.place(k, side).length_squared() / (radius * radius)).max(0.0).sqrt();
                    let light: f64 = (0..grid.len()).map(weight).sum();
                    let mean = grid.iter().enumerate().map(|(k, fraction)| *fraction * weight(k)).sum::<DVec3>() / light;
                    error_of_mean = error_of_mean.max((mean - factor).abs().max_element());
                }
            }
        }
        let rms = (sum_sq / f64::from(places)).sqrt();
        println!("{places} places, {largest:.4}, rms {rms:.4}; mean {error_of_mean:.4}; control {error_of_factor:.2}");
        assert!(rms < 0.005 && error_of_mean < 0.012, "{rms}, {error_of_mean}");
        assert!(places > 200 && error_of_factor > 0.4, "{places}, {error_of_factor}");
    }

    /// An opaque ring's edge under a Sun in the zenith of the plane: exactly 1 beside the penumbra, 0 within the shadow but for rounding, and half between.
    #[test]
    fn an_edge_has_its_penumbra_and_nothing_beside_it() {
        let rings = [RingInterval { inner: 1.5, outer: 9.0, tau: 1e4, albedo: [0.0; 3], dust_fraction: 0.0 }];
        let (distance, sun_distance, sun_radius) = (50.0, 1e4, 4.0);
        let body = DVec3::new(0.0, 1.5, -distance);
        let beam = Beam { body, body_radius: 0.1, sun: body + DVec3::Z * sun_distance, sun_radius };
        let shadow = ShadedSun::of(beam, &rings, DVec3::ONE, LIMB_DARKENING, 0.1).expect("a shadow");
        // The radius of the penumbra is 0.02.
        let fraction = |offset: f64| {
            let outwards = DVec2::new(DVec3::Y.dot(shadow.x), DVec3::Y.dot(shadow.y));
            shadow.fraction(outwards * offset)
        };
        assert_eq!(fraction(-0.03), DVec3::ONE);
        assert!(fraction(0.03).max_element() < 1e-12, "{}", fraction(0.03));
        assert!((fraction(0.0) - 0.5).abs().max_element() < 0.01, "{}", fraction(0.0));
    }
}
