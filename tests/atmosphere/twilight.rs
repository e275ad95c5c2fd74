//! Skylight on level ground in twilight: the multiple-scattering table against a Monte Carlo simulation that follows photons backwards
//! through the same spherical air.

use crate::support::random::Random;
use glam::DVec3;
use orrery::catalog::{Catalog, NaifId, Species};
use orrery::scene::multi_scatter_table;
use std::f64::consts::{PI, TAU};

/// A planet whose atmosphere is gas only, in one channel. Lengths in km.
struct Gas {
    radius: f64,
    /// Height of the top above the ground.
    top: f64,
    scale_height: f64,
    /// Scattering coefficient at the ground, per km.
    scattering: f64,
    /// Of the ground, a Lambert surface.
    albedo: f64,
}

/// A direction at an angle of this cosine to `from`, at a random azimuth.
fn deflected(random: &mut Random, from: DVec3, cosine: f64) -> DVec3 {
    let (sin, cos) = (TAU * random.positive()).sin_cos();
    let (x, y) = from.any_orthonormal_pair();
    (from * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()).normalize()
}

/// Skylight on level ground, relative to the Sun's irradiance.
struct Sky {
    /// From light scattered once.
    once: f64,
    /// From light of all orders.
    all: f64,
}

impl Gas {
    /// Relative to the ground.
    fn density(&self, p: DVec3) -> f64 {
        (-(p.length() - self.radius) / self.scale_height).exp()
    }

    /// Distance along a ray to a sphere: to the entry point if `inward`, otherwise to the exit point.
    fn distance_to_sphere(p: DVec3, along: DVec3, radius: f64, inward: bool) -> Option<f64> {
        let b = p.dot(along);
        let discriminant = b * b - p.length_squared() + radius * radius;
        let distance = if inward { -b - discriminant.max(0.0).sqrt() } else { -b + discriminant.max(0.0).sqrt() };
        (discriminant > 0.0 && distance > 0.0).then_some(distance)
    }

    /// Transmittance towards the Sun; 0 if the planet blocks the ray.
    fn sunlight(&self, p: DVec3, sun: DVec3) -> f64 {
        const STEPS: u32 = 96;
        if Self::distance_to_sphere(p, sun, self.radius, true).is_some() {
            return 0.0;
        }
        let step = Self::distance_to_sphere(p, sun, self.radius + self.top, false).unwrap_or(0.0) / f64::from(STEPS);
        let column: f64 = (0..STEPS).map(|k| self.density(p + sun * (step * (f64::from(k) + 0.5)))).sum();
        (-column * step * self.scattering).exp()
    }

    /// Skylight by delta tracking along paths backwards from the ground; each scattering adds the sunlight scattered there into the path.
    fn sky(&self, sun_cosine: f64, paths: u32) -> Sky {
        let sun = DVec3::new((1.0 - sun_cosine * sun_cosine).sqrt(), 0.0, sun_cosine);
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let mut sky = Sky { once: 0.0, all: 0.0 };
        for _ in 0..paths {
            // Importance sampling of the horizon and the Sun's azimuth, from where most light comes: the zenith cosine is the square of a
            // random number; seven of ten azimuths are drawn within 0.8 rad of the Sun's, the others from the whole circle.
            let cosine_root = random.positive();
            let cosine = cosine_root * cosine_root;
            let azimuth = if random.positive() < 0.7 { 0.8 } else { PI } * (2.0 * random.positive() - 1.0);
            let azimuth_density = 0.3 / TAU + if azimuth.abs() < 0.8 { 0.7 / 1.6 } else { 0.0 };
            let horizontal = (1.0 - cosine * cosine).sqrt();
            let mut along = DVec3::new(horizontal * azimuth.cos(), horizontal * azimuth.sin(), cosine);
            let mut weight = cosine * 2.0 * cosine_root / azimuth_density;
            let mut position = DVec3::Z * (self.radius + 0.002);
            for order in 0..60 {
                let ground = Self::distance_to_sphere(position, along, self.radius, true);
                let end = ground.or_else(|| Self::distance_to_sphere(position, along, self.radius + self.top, false)).unwrap_or(0.0);
                let mut distance = 0.0;
                let scatters = loop {
                    distance -= random.positive().ln() / self.scattering;
                    if distance >= end {
                        break false;
                    }
                    if random.positive() < self.density(position + along * distance) {
                        break true;
                    }
                };
                if scatters {
                    position += along * distance;
                    let cos = along.dot(sun);
                    let light = weight * self.sunlight(position, sun) * 3.0 / (16.0 * PI) * (1.0 + cos * cos);
                    sky.all += light;
                    sky.once += if order == 0 { light } else { 0.0 };
                    let turn_cosine = loop {
                        let mu = 2.0 * random.positive() - 1.0;
                        if random.positive() * 2.0 < 1.0 + mu * mu {
                            break mu;
                        }
                    };
                    along = deflected(&mut random, along, turn_cosine);
                } else if let Some(ground) = ground {
                    let up = (position + along * ground).normalize();
                    position = up * (self.radius + 0.001);
                    weight *= self.albedo;
                    sky.all += weight * self.sunlight(position, sun) * up.dot(sun).max(0.0) / PI;
                    let cosine = random.positive().sqrt();
                    along = deflected(&mut random, up, cosine);
                } else {
                    break;
                }
            }
        }
        Sky { once: sky.once / f64::from(paths), all: sky.all / f64::from(paths) }
    }
}

/// With the Sun from the horizon to 6 degrees below it. The table agrees although, for orders above the second, it assumes that the
/// surrounding air is lit uniformly. Single scattering alone would fail.
#[test]
fn twilight_from_the_table_agrees_with_photons() {
    let mut earth = Catalog::embedded().body(NaifId::EARTH).expect("the Earth").clone();
    let air = earth.atmosphere.as_mut().expect("air");
    air.species.retain(Species::is_gas);
    let (top, species) = (air.top_km, air.species[0].clone());
    let table = multi_scatter_table::table(&earth).expect("a table");
    for (column, paths) in [(6, 100_000), (5, 100_000), (4, 200_000), (3, 400_000)] {
        let sun_cosine = multi_scatter_table::sun_cosine(column);
        assert!((-0.105..0.01).contains(&sun_cosine), "{sun_cosine}");
        for channel in [1, 2] {
            let gas = Gas {
                radius: earth.radii_km.x,
                top,
                scale_height: species.scale_height_km,
                scattering: species.scattering_per_km[channel],
                albedo: earth.mean_reflectance()[channel],
            };
            let sky = gas.sky(sun_cosine, paths);
            let tabulated = f64::from(table[multi_scatter_table::HEIGHTS * multi_scatter_table::SUNS + column][channel]).powi(2);
            println!(
                "{:.2} degrees, channel {channel}: {:.3} of {:.3e}, once {:.3}",
                sun_cosine.asin().to_degrees(),
                tabulated / sky.all,
                sky.all,
                sky.once / sky.all
            );
            assert!((tabulated / sky.all - 1.0).abs() < 0.1, "{sun_cosine:.3}, channel {channel}: {tabulated:.3e} for {:.3e}", sky.all);
            assert!(sky.once / sky.all < 0.9, "{sun_cosine:.3}, channel {channel}: {:.3e} of {:.3e}", sky.once, sky.all);
        }
    }
}
