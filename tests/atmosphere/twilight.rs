//! The light of the twilight sky on level ground: the table of multiple scattering against photons that are followed backwards through the same spherical
//! air, one by one.

use glam::DVec3;
use orrery::catalog::{Catalog, NaifId};
use orrery::scene::air_table;
use std::f64::consts::{PI, TAU};

/// An air of gas alone over a ground that reflects a part, for one channel. Lengths in km.
struct Gas {
    radius: f64,
    top: f64,
    scale_height: f64,
    scattering: f64,
    albedo: f64,
}

struct Random(u64);

impl Random {
    /// Over 0, up to 1.
    fn part(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn turned(&mut self, from: DVec3, cosine: f64) -> DVec3 {
        let (sin, cos) = (TAU * self.part()).sin_cos();
        let (x, y) = from.any_orthonormal_pair();
        (from * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()).normalize()
    }
}

/// Irradiance per that of the Sun: of light scattered once, and of all orders.
struct Sky {
    once: f64,
    all: f64,
}

impl Gas {
    fn density(&self, p: DVec3) -> f64 {
        (-(p.length() - self.radius) / self.scale_height).exp()
    }

    /// Distance to a sphere, the nearer way in and the farther way out.
    fn reach(p: DVec3, along: DVec3, radius: f64, inward: bool) -> Option<f64> {
        let b = p.dot(along);
        let under = b * b - p.length_squared() + radius * radius;
        let way = if inward { -b - under.max(0.0).sqrt() } else { -b + under.max(0.0).sqrt() };
        (under > 0.0 && way > 0.0).then_some(way)
    }

    /// Transmittance towards the Sun; none through the planet.
    fn sunlight(&self, p: DVec3, sun: DVec3) -> f64 {
        const STEPS: u32 = 96;
        if Self::reach(p, sun, self.radius, true).is_some() {
            return 0.0;
        }
        let step = Self::reach(p, sun, self.radius + self.top, false).unwrap_or(0.0) / f64::from(STEPS);
        let column: f64 = (0..STEPS).map(|k| self.density(p + sun * (step * (f64::from(k) + 0.5)))).sum();
        (-column * step * self.scattering).exp()
    }

    /// Delta tracking, with the scattered light of the Sun added at each scattering.
    fn sky(&self, sun_cosine: f64, paths: u32) -> Sky {
        let sun = DVec3::new((1.0 - sun_cosine * sun_cosine).sqrt(), 0.0, sun_cosine);
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let mut sky = Sky { once: 0.0, all: 0.0 };
        for _ in 0..paths {
            // More of them near the horizon and towards the Sun, from where the light comes: the cosine is a square, and seven of ten azimuths are
            // within 0.8 rad of the Sun's.
            let root = random.part();
            let cosine = root * root;
            let azimuth = if random.part() < 0.7 { 0.8 } else { PI } * (2.0 * random.part() - 1.0);
            let of_azimuth = 0.3 / TAU + if azimuth.abs() < 0.8 { 0.7 / 1.6 } else { 0.0 };
            let across = (1.0 - cosine * cosine).sqrt();
            let mut along = DVec3::new(across * azimuth.cos(), across * azimuth.sin(), cosine);
            let mut weight = cosine * 2.0 * root / of_azimuth;
            let mut at = DVec3::Z * (self.radius + 0.002);
            for order in 0..60 {
                let ground = Self::reach(at, along, self.radius, true);
                let end = ground.or_else(|| Self::reach(at, along, self.radius + self.top, false)).unwrap_or(0.0);
                let mut way = 0.0;
                let scatters = loop {
                    way -= random.part().ln() / self.scattering;
                    if way >= end {
                        break false;
                    }
                    if random.part() < self.density(at + along * way) {
                        break true;
                    }
                };
                if scatters {
                    at += along * way;
                    let cos = along.dot(sun);
                    let light = weight * self.sunlight(at, sun) * 3.0 / (16.0 * PI) * (1.0 + cos * cos);
                    sky.all += light;
                    sky.once += if order == 0 { light } else { 0.0 };
                    let turn = loop {
                        let mu = 2.0 * random.part() - 1.0;
                        if random.part() * 2.0 < 1.0 + mu * mu {
                            break mu;
                        }
                    };
                    along = random.turned(along, turn);
                } else if let Some(ground) = ground {
                    let up = (at + along * ground).normalize();
                    at = up * (self.radius + 0.001);
                    weight *= self.albedo;
                    sky.all += weight * self.sunlight(at, sun) * up.dot(sun).max(0.0) / PI;
                    let cosine = random.part().sqrt();
                    along = random.turned(up, cosine);
                } else {
                    break;
                }
            }
        }
        Sky { once: sky.once / f64::from(paths), all: sky.all / f64::from(paths) }
    }
}

/// With the Sun from the horizon to 6 degrees below it, although the table's further orders take the air around for even. Light scattered once alone
/// would not do.
#[test]
fn the_tables_twilight_is_that_of_photons() {
    let mut earth = Catalog::embedded().body(NaifId::EARTH).expect("the Earth").clone();
    let air = earth.atmosphere.as_mut().expect("air");
    air.species.retain(|s| s.asymmetry.is_none() && s.tent_centre_km.is_none());
    let (top, species) = (air.top_km, air.species[0].clone());
    let table = air_table::table(&earth).expect("a table");
    for (column, paths) in [(6, 100_000), (5, 100_000), (4, 200_000), (3, 400_000)] {
        let cosine = air_table::sun_cosine(column);
        assert!((-0.105..0.01).contains(&cosine), "{cosine}");
        for channel in [1, 2] {
            let gas = Gas {
                radius: earth.radii_km.x,
                top,
                scale_height: species.scale_height_km,
                scattering: species.scattering_per_km[channel],
                albedo: earth.target_mean_colour()[channel],
            };
            let sky = gas.sky(cosine, paths);
            let got = f64::from(table[air_table::HEIGHTS * air_table::SUNS + column][channel]).powi(2);
            println!(
                "{:.2} degrees, channel {channel}: {:.3} of {:.3e}, once {:.3}",
                cosine.asin().to_degrees(),
                got / sky.all,
                sky.all,
                sky.once / sky.all
            );
            assert!((got / sky.all - 1.0).abs() < 0.1, "{cosine:.3}, channel {channel}: {got:.3e} for {:.3e}", sky.all);
            assert!(sky.once / sky.all < 0.9, "{cosine:.3}, channel {channel}: {:.3e} of {:.3e}", sky.once, sky.all);
        }
    }
}
