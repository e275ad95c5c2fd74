//! Maps of bodies for which no map with a free licence was found, generated from noise and the gazetteer's craters and rings.
//!
//! In: craters and rings of the gazetteer. Out: a map per body, the same in each run. Reflectances, sizes and frequencies without a source are chosen by
//! eye. In the functions that paint a body, `p` is a unit vector in body axes, and `v` the reflectance before the hue is applied.

use super::{Colour, Feature, HEIGHT, WIDTH, smoothstep, to_byte};
use image::{Rgb, RgbImage};
use std::f64::consts::PI;

/// Unit vector in body axes; `lon_deg`: positive east.
fn unit_vector(lat_deg: f64, lon_deg: f64) -> [f64; 3] {
    let (lat, lon) = (lat_deg.to_radians(), lon_deg.to_radians());
    [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
}

/// Angle between two unit vectors, degrees.
fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    (2.0 * (chord / 2.0).min(1.0).asin()).to_degrees()
}

/// A uniform number from 0 to 1, fixed for each lattice point.
fn hash(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B) ^ z.wrapping_mul(0xC2B2_AE35)) as u64;
    h = (h ^ (h >> 31)).wrapping_mul(0x7FB5_D329_728E_A185);
    h = (h ^ (h >> 27)).wrapping_mul(0x81DA_DEF4_BC2D_D44D);
    ((h ^ (h >> 33)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Smooth noise of one scale, -1..1, at a point `q` of space: interpolates random values at the points with integer coordinates, so that a
/// map has no seam and no distortion at the poles.
fn value_noise(q: [f64; 3]) -> f64 {
    let base = q.map(f64::floor);
    let fade: Vec<f64> = (0..3).map(|i| q[i] - base[i]).map(|t| t * t * (3.0 - 2.0 * t)).collect();
    let mut sum = 0.0;
    for corner in 0..8_i64 {
        let bit = |i: i64| (corner >> i) & 1;
        let weight: f64 = (0..3).map(|i| if bit(i as i64) == 1 { fade[i] } else { 1.0 - fade[i] }).product();
        sum += weight * hash(base[0] as i64 + bit(0), base[1] as i64 + bit(1), base[2] as i64 + bit(2));
    }
    2.0 * sum - 1.0
}

/// A map from a function that gives the linear reflectance at a unit vector with its latitude and longitude in degrees.
fn paint(reflectance: impl Fn([f64; 3], f64, f64) -> Colour) -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let lat = 90.0 - (f64::from(y) + 0.5) / f64::from(HEIGHT) * 180.0;
        let lon = (f64::from(x) + 0.5) / f64::from(WIDTH) * 360.0 - 180.0;
        Rgb(reflectance(unit_vector(lat, lon), lat, lon).map(to_byte))
    })
}

/// Fractal noise: each octave has 1.9 times the frequency and 0.7 times the amplitude of the one before, so that the power spectrum of a map
/// falls about as frequency^-3, like that of cratered ground (an estimate). Mean 0, about -1..1. The offsets make the octaves independent.
/// `scale`: lattice cells of the first octave per unit of `p`.
fn fractal_noise(p: [f64; 3], scale: f64, octaves: i32) -> f64 {
    (0..octaves).map(|o| 0.45 * 0.7_f64.powi(o) * value_noise(p.map(|v| v * scale * 1.9_f64.powi(o) + 31.0 * f64::from(o + 1)))).sum()
}

/// One crater: direction of its centre, size, and freshness, which sets the contrast of floor, rim and ejecta with the ground. Few craters are fresh.
struct Crater {
    centre: [f64; 3],
    radius_deg: f64,
    freshness: f64,
}

/// Random craters: positions uniform over the sphere, radii by a power law, freshness mostly low.
fn random_craters(seed: i64, count: i64, min_radius_deg: f64, max_radius_deg: f64) -> Vec<Crater> {
    let crater = |k: i64| {
        let uniform = |n: i64| hash(k, n, seed);
        let (z, longitude) = (2.0 * uniform(0) - 1.0, 2.0 * PI * uniform(1));
        let r = (1.0 - z * z).sqrt();
        // Between the bounds, the density of radii is proportional to radius^-3.
        let (a, b) = (min_radius_deg.powi(-2), max_radius_deg.powi(-2));
        Crater {
            centre: [r * longitude.cos(), r * longitude.sin(), z],
            radius_deg: (a + (b - a) * uniform(2)).powf(-0.5),
            freshness: uniform(3).powi(4),
        }
    };
    (0..count).map(crater).collect()
}

/// The gazetteer's craters on a body of this radius, each with a random freshness.
fn named_craters(list: &[Feature], body_radius_km: f64) -> Vec<Crater> {
    let crater = |(k, f): (usize, &Feature)| Crater {
        centre: unit_vector(f.lat_deg, f.lon_deg),
        radius_deg: (f.diameter_km / 2.0 / body_radius_km).to_degrees().max(0.3),
        freshness: 0.15 + 0.5 * hash(k as i64, 7, 3).powi(2),
    };
    list.iter().enumerate().map(crater).collect()
}

/// Sum of the brightness that craters add at a position: floors, rims and ejecta blankets with soft edges, their circles distorted by noise.
/// `floor`, `rim`: brightness of the floor and of the rim and ejecta of a fresh crater.
fn crater_brightness(p: [f64; 3], craters: &[Crater], floor: f64, rim: f64) -> f64 {
    let mut sum = 0.0;
    let mut distortion = None;
    for crater in craters {
        let cos = crater.centre[0] * p[0] + crater.centre[1] * p[1] + crater.centre[2] * p[2];
        let reach = (4.0 * crater.radius_deg).to_radians();
        // 1 - x²/2 is below the cosine, so nothing within reach is skipped.
        if cos < 1.0 - 0.5 * reach * reach {
            continue;
        }
        let distortion = *distortion.get_or_insert_with(|| fractal_noise(p, 30.0, 4));
        let d = angle_deg(p, crater.centre) / crater.radius_deg * (1.0 + 0.22 * distortion);
        let bowl = 1.0 - smoothstep(0.55, 1.0, d);
        let ring = (-((d - 0.95) / 0.22).powi(2)).exp();
        let ejecta = (-(d - 1.0).max(0.0) * 1.4).exp() * (0.7 + 0.9 * distortion).max(0.0) * smoothstep(0.8, 1.1, d);
        sum += floor * bowl * (0.3 + crater.freshness) + rim * (ring * (0.08 + crater.freshness) + 0.8 * ejecta * crater.freshness);
    }
    sum
}

const CALLISTO_RADIUS_KM: f64 = 2410.3;

/// Dark old ground with many bright craters; Valhalla, Asgard and the other basins are bright centres within faint broken rings.
pub(super) fn callisto(craters: &[Feature], basins: &[Feature]) -> RgbImage {
    let mut all_craters = named_craters(craters, CALLISTO_RADIUS_KM);
    all_craters.extend(random_craters(11, 9000, 0.3, 2.5));
    paint(|p, _, _| {
        let mut v = 0.17 * (1.0 + 0.3 * fractal_noise(p, 3.0, 8));
        v += crater_brightness(p, &all_craters, 0.07, 0.045);
        for b in basins {
            let (d, edge) = (angle_deg(p, unit_vector(b.lat_deg, b.lon_deg)), (b.diameter_km / 2.0 / CALLISTO_RADIUS_KM).to_degrees());
            if d < edge {
                let distorted = d / edge + 0.035 * fractal_noise(p, 6.0, 4);
                let core = 0.13 * (1.0 - smoothstep(0.08, 0.27, distorted)) * (1.0 + 0.5 * fractal_noise(p, 20.0, 4));
                // Outer rings are farther apart; all are interrupted in places.
                let broken = smoothstep(-0.25, 0.35, fractal_noise(p, 9.0, 3));
                let ring = 0.02
                    * (2.0 * PI * 13.0 * distorted.powf(0.8)).sin()
                    * broken
                    * smoothstep(0.15, 0.3, distorted)
                    * (1.0 - smoothstep(0.6, 1.0, distorted));
                v += core + ring;
            }
        }
        let v = v.max(0.05);
        [v * 1.04, v, v * 0.9]
    })
}

/// Cassini Regio, albedo 0.05, covers the leading side around 90 W; the trailing side and the poles are bright ice, albedo 0.5. Along the
/// border the ground is either dark or bright, in patches of all sizes: ice sublimates from warmer ground and is deposited on colder ground
/// (Spencer & Denk 2010).
pub(super) fn iapetus(craters: &[Feature]) -> RgbImage {
    let radius_km = 734.5;
    let mut all_craters = named_craters(craters, radius_km);
    all_craters.extend(random_craters(23, 4000, 0.5, 9.0));
    paint(|p, lat, lon| {
        let apex_distance_deg = angle_deg(unit_vector(0.0, lon), unit_vector(0.0, -90.0));
        let crater_light = crater_brightness(p, &all_craters, -0.5, 0.6);
        // The dark oval extends 100 degrees from the apex along the equator, and to latitude 62.
        let d = ((apex_distance_deg / 100.0).powi(2) + (lat / 62.0).powi(2)).sqrt();
        let patchy = d + 0.24 * fractal_noise(p, 5.0, 8) + 0.05 * crater_light;
        let dark = 1.0 - smoothstep(0.90, 1.10, patchy);
        let ice = 0.5 * (1.0 + 0.16 * fractal_noise(p, 6.0, 7) + 0.14 * crater_light);
        let dark_ground = 0.05 * (1.0 + 0.22 * fractal_noise(p, 9.0, 6) + 0.12 * crater_light);
        let v = ice.max(0.1) * (1.0 - dark) + dark_ground.max(0.02) * dark;
        let red = 1.02 + 0.18 * dark;
        [v * red, v, v * (0.97 - 0.2 * dark)]
    })
}

/// The bright, pinkish southern cap extends to about 15 S and has a ragged edge, a whiter fringe and dark plume streaks. The north is darker and
/// greyer; in Bubembe Regio (18 N, 335 E in the gazetteer) and around it, up to the smooth plains that begin near 14 E, it has cells some 40 km wide
/// (cantaloupe terrain).
pub(super) fn triton() -> RgbImage {
    paint(|p, lat, _| {
        let edge = lat + 15.0 + 16.0 * fractal_noise(p, 4.0, 7);
        let cap = 1.0 - smoothstep(-7.0, 7.0, edge);
        let fringe = (-((edge - 3.0) / 6.0).powi(2)).exp();
        // The ridges between the cells are where the noise changes sign.
        let cells = 1.0 - smoothstep(0.0, 0.35, value_noise(p.map(|v| v * 34.0 + 5.0 * fractal_noise(p, 12.0, 2))).abs());
        let bubembe_distance_deg = angle_deg(p, unit_vector(18.0, 335.0));
        let cantaloupe = (1.0 - smoothstep(25.0, 50.0, bubembe_distance_deg)) * smoothstep(-5.0, 10.0, lat);
        let north = 0.60 * (1.0 + 0.13 * fractal_noise(p, 5.0, 7)) + 0.035 * (cells - 0.4) * cantaloupe;
        // Streaks are elongated east-west, tilted by at most 10 degrees: to the north-east at 45 E, to the north-west at 225 E.
        let stretched = [p[0] * 9.0 + p[2] * 4.0, p[1] * 9.0 - p[2] * 4.0, p[2] * 26.0];
        let streak = (value_noise(stretched) + 0.6 * fractal_noise(p, 18.0, 4) - 0.45).max(0.0) * smoothstep(-78.0, -52.0, lat) * cap;
        let south = 0.83 * (1.0 + 0.08 * fractal_noise(p, 6.0, 7)) - 0.28 * streak;
        let v = south * cap + north * (1.0 - cap) + 0.05 * fringe;
        let pink = cap * (1.0 - 0.5 * fringe);
        [v * (1.02 + 0.05 * pink), v * (1.0 - 0.01 * pink), v * (0.97 - 0.08 * pink)]
    })
}

/// Grey-brown ground, bluish and brighter around Stickney (1 N, 49 W), with the named craters and random ones.
pub(super) fn phobos(craters: &[Feature]) -> RgbImage {
    let radius_km = 11.1;
    let mut all_craters = named_craters(craters, radius_km);
    all_craters.extend(random_craters(37, 1500, 1.0, 9.0));
    paint(|p, _, _| {
        let blue = 1.0 - smoothstep(15.0, 70.0, angle_deg(p, unit_vector(1.0, -49.0)) + 18.0 * fractal_noise(p, 4.0, 6));
        let v = 0.07 * (1.0 + 0.22 * fractal_noise(p, 6.0, 7) + 0.25 * blue + crater_brightness(p, &all_craters, -0.16, 0.13));
        let v = v.max(0.03);
        [v * (1.08 - 0.08 * blue), v, v * (0.9 + 0.08 * blue)]
    })
}
