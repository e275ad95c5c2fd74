//! Maps of bodies whose sources are coarse or grey, generated from noise and the craters of the gazetteer.

use super::{Colour, Feature, HEIGHT, WIDTH, smooth, to_byte};
use image::{Rgb, RgbImage};
use std::f64::consts::PI;

fn unit(lat: f64, lon: f64) -> [f64; 3] {
    let (lat, lon) = (lat.to_radians(), lon.to_radians());
    [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
}

/// Degrees between two unit vectors.
fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    (2.0 * (chord / 2.0).min(1.0).asin()).to_degrees()
}

fn hash(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B) ^ z.wrapping_mul(0xC2B2_AE35)) as u64;
    h = (h ^ (h >> 31)).wrapping_mul(0x7FB5_D329_728E_A185);
    h = (h ^ (h >> 27)).wrapping_mul(0x81DA_DEF4_BC2D_D44D);
    ((h ^ (h >> 33)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Smooth noise of one scale, -1..1, without a seam and without distortion at the poles.
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

/// A map from a function that gives the linear reflectance at each position; the texels are sRGB-encoded.
fn paint(reflectance: impl Fn([f64; 3], f64, f64) -> Colour) -> RgbImage {
    RgbImage::from_fn(WIDTH, HEIGHT, |x, y| {
        let lat = 90.0 - (f64::from(y) + 0.5) / f64::from(HEIGHT) * 180.0;
        let lon = (f64::from(x) + 0.5) / f64::from(WIDTH) * 360.0 - 180.0;
        Rgb(reflectance(unit(lat, lon), lat, lon).map(to_byte))
    })
}

/// Ground whose brightness varies equally on all scales: each octave has 0.7 of the amplitude of the one before, so that the spectrum falls
/// with a power near 3, like that of cratered ground (an estimate). Mean 0, about -1..1.
fn ground(p: [f64; 3], scale: f64, octaves: i32) -> f64 {
    (0..octaves).map(|o| 0.45 * 0.7_f64.powi(o) * value_noise(p.map(|v| v * scale * 1.9_f64.powi(o) + 31.0 * f64::from(o + 1)))).sum()
}

/// One crater: position, size, and freshness, which sets the contrast of floor, rim and ejecta with the ground. Few craters are fresh.
struct Mark {
    at: [f64; 3],
    radius_deg: f64,
    fresh: f64,
}

/// Random craters: positions uniform over the sphere, numbers that decrease with the square of the size, freshness mostly low.
fn random_craters(seed: i64, count: i64, least_deg: f64, most_deg: f64) -> Vec<Mark> {
    let mark = |k: i64| {
        let dice = |n: i64| hash(k, n, seed);
        let (z, turn) = (2.0 * dice(0) - 1.0, 2.0 * PI * dice(1));
        let r = (1.0 - z * z).sqrt();
        // Between the bounds, the number of craters above a size is proportional to its inverse square.
        let (a, b) = (least_deg.powi(-2), most_deg.powi(-2));
        Mark { at: [r * turn.cos(), r * turn.sin(), z], radius_deg: (a + (b - a) * dice(2)).powf(-0.5), fresh: dice(3).powi(4) }
    };
    (0..count).map(mark).collect()
}

/// The gazetteer's craters, each with a random freshness.
fn named(list: &[Feature], radius_km: f64) -> Vec<Mark> {
    let mark = |(k, f): (usize, &Feature)| Mark {
        at: unit(f.lat, f.lon),
        radius_deg: (f.diameter_km / 2.0 / radius_km).to_degrees().max(0.3),
        fresh: 0.15 + 0.5 * hash(k as i64, 7, 3).powi(2),
    };
    list.iter().enumerate().map(mark).collect()
}

/// Sum of the brightness that craters add at a position: floors, rims and ejecta blankets without a sharp edge, their circles distorted by
/// the ground.
fn cratered(p: [f64; 3], marks: &[Mark], floor: f64, rim: f64) -> f64 {
    let mut sum = 0.0;
    let mut bend = None;
    for m in marks {
        let cos = m.at[0] * p[0] + m.at[1] * p[1] + m.at[2] * p[2];
        let reach = (4.0 * m.radius_deg).to_radians();
        // 1 - x²/2 is below the cosine, so nothing within reach is skipped.
        if cos < 1.0 - 0.5 * reach * reach {
            continue;
        }
        let bend = *bend.get_or_insert_with(|| ground(p, 30.0, 4));
        let d = angle_deg(p, m.at) / m.radius_deg * (1.0 + 0.22 * bend);
        let bowl = 1.0 - smooth(0.55, 1.0, d);
        let ring = (-((d - 0.95) / 0.22).powi(2)).exp();
        let ejecta = (-(d - 1.0).max(0.0) * 1.4).exp() * (0.7 + 0.9 * bend).max(0.0) * smooth(0.8, 1.1, d);
        sum += floor * bowl * (0.3 + m.fresh) + rim * (ring * (0.08 + m.fresh) + 0.8 * ejecta * m.fresh);
    }
    sum
}

/// Dark old ground with many bright craters; Valhalla and Asgard are bright centres among faint broken rings.
pub(super) fn callisto(craters: &[Feature], basins: &[Feature]) -> RgbImage {
    let mut marks = named(craters, 2410.3);
    marks.extend(random_craters(11, 9000, 0.3, 2.5));
    paint(|p, _, _| {
        let mut v = 0.17 * (1.0 + 0.3 * ground(p, 3.0, 8));
        v += cratered(p, &marks, 0.07, 0.045);
        for b in basins {
            let (d, edge) = (angle_deg(p, unit(b.lat, b.lon)), (b.diameter_km / 2.0 / 2410.3).to_degrees());
            if d < edge {
                let bent = d / edge + 0.035 * ground(p, 6.0, 4);
                let core = 0.13 * (1.0 - smooth(0.08, 0.27, bent)) * (1.0 + 0.5 * ground(p, 20.0, 4));
                // Outer rings are closer together; all are interrupted in places.
                let broken = smooth(-0.25, 0.35, ground(p, 9.0, 3));
                let ring =
                    0.02 * (2.0 * PI * 13.0 * bent.powf(0.8)).sin() * broken * smooth(0.15, 0.3, bent) * (1.0 - smooth(0.6, 1.0, bent));
                v += core + ring;
            }
        }
        let v = v.max(0.05);
        [v * 1.04, v, v * 0.9]
    })
}

/// Cassini Regio, albedo 0.05, covers the leading side around 90 W; the trailing side and the poles are bright ice, 0.5. Between them the
/// ground is either dark or bright, in ever smaller patches: ice sublimates from warmer ground and is deposited on colder ground (Spencer &
/// Denk 2010).
pub(super) fn iapetus(craters: &[Feature]) -> RgbImage {
    let mut marks = named(craters, 734.5);
    marks.extend(random_craters(23, 4000, 0.5, 9.0));
    paint(|p, lat, lon| {
        let from_apex = angle_deg(unit(0.0, lon), unit(0.0, -90.0));
        let craters = cratered(p, &marks, -0.5, 0.6);
        // The dark oval: it reaches 62 degrees from the equator, and 100 degrees from the apex along it.
        let d = ((from_apex / 100.0).powi(2) + (lat / 62.0).powi(2)).sqrt();
        let patchy = d + 0.24 * ground(p, 5.0, 8) + 0.05 * craters;
        let dark = 1.0 - smooth(0.90, 1.10, patchy);
        let ice = 0.5 * (1.0 + 0.16 * ground(p, 6.0, 7) + 0.14 * craters);
        let cover = 0.05 * (1.0 + 0.22 * ground(p, 9.0, 6) + 0.12 * craters);
        let v = ice.max(0.1) * (1.0 - dark) + cover.max(0.02) * dark;
        let red = 1.02 + 0.18 * dark;
        [v * red, v, v * (0.97 - 0.2 * dark)]
    })
}

/// The southern cap is bright and pinkish down to about 15 S with a ragged edge, a whiter fringe and dark plume streaks; the north is
/// darker and greyer, in the west with cells some 40 km wide (cantaloupe terrain).
pub(super) fn triton() -> RgbImage {
    paint(|p, lat, lon| {
        let edge = lat + 15.0 + 16.0 * ground(p, 4.0, 7);
        let cap = 1.0 - smooth(-7.0, 7.0, edge);
        let fringe = (-((edge - 3.0) / 6.0).powi(2)).exp();
        // Ridges are where the noise changes sign.
        let cells = 1.0 - smooth(0.0, 0.35, value_noise(p.map(|v| v * 34.0 + 5.0 * ground(p, 12.0, 2))).abs());
        let cantaloupe = smooth(-20.0, 20.0, -((lon + 300.0).rem_euclid(360.0) - 120.0).abs() + 60.0) * smooth(-5.0, 10.0, lat);
        let north = 0.60 * (1.0 + 0.13 * ground(p, 5.0, 7)) + 0.035 * (cells - 0.4) * cantaloupe;
        // Streaks follow a wind that blows to the north-east.
        let along = [p[0] * 9.0 + p[2] * 4.0, p[1] * 9.0 - p[2] * 4.0, p[2] * 26.0];
        let streak = (value_noise(along) + 0.6 * ground(p, 18.0, 4) - 0.45).max(0.0) * smooth(-78.0, -52.0, lat) * cap;
        let south = 0.83 * (1.0 + 0.08 * ground(p, 6.0, 7)) - 0.28 * streak;
        let v = south * cap + north * (1.0 - cap) + 0.05 * fringe;
        let pink = cap * (1.0 - 0.5 * fringe);
        [v * (1.02 + 0.05 * pink), v * (1.0 - 0.01 * pink), v * (0.97 - 0.08 * pink)]
    })
}

/// Grey-brown ground, with Stickney bluish and brighter at 1 N 49 W, the named craters, and small random ones.
pub(super) fn phobos(craters: &[Feature]) -> RgbImage {
    let mut marks = named(craters, 11.1);
    marks.extend(random_craters(37, 1500, 1.0, 9.0));
    paint(|p, _, _| {
        let blue = 1.0 - smooth(15.0, 70.0, angle_deg(p, unit(1.0, -49.0)) + 18.0 * ground(p, 4.0, 6));
        let v = 0.07 * (1.0 + 0.22 * ground(p, 6.0, 7) + 0.25 * blue + cratered(p, &marks, -0.16, 0.13));
        let v = v.max(0.03);
        [v * (1.08 - 0.08 * blue), v, v * (0.9 + 0.08 * blue)]
    })
}
