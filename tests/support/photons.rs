//! Skylight by a Monte Carlo simulation: photons are followed backwards from level ground through a body's spherical air. It shares only the catalog's numbers
//! with the program: density, phase functions and geometry are written here again.

use super::random::Random;
use glam::DVec3;
use orrery::catalog::{AerosolFunction, AerosolPhase, Body, PhaseFunction, Species};
use std::f64::consts::{PI, TAU};

/// Greatest number of scatterings, by air or ground, along a photon's path. Light of higher orders is dropped; in Titan's air it is below 1e-3 of the whole.
const MAX_ORDERS: u32 = 200;

/// The air and ground of a body, in one channel.
pub struct Air<'a> {
    body: &'a Body,
    species: &'a [Species],
    /// One per species.
    angles: Vec<ScatteringAngles>,
    channel: usize,
    top_km: f64,
    /// Albedo of the ground, a Lambert surface.
    albedo: f64,
    /// Upper limit of the extinction coefficient at any height, per km.
    max_extinction_per_km: f64,
}

/// Irradiance of level ground by the sky, relative to that of a plane that faces the Sun outside the air, with its standard error.
pub struct Skylight {
    /// Light scattered once.
    pub once: f64,
    /// Light of all orders.
    pub all: f64,
    /// Standard error of `all`.
    pub error: f64,
}

/// A direction at an angle of this cosine to `from`, at a random azimuth.
fn deflected(random: &mut Random, from: DVec3, cosine: f64) -> DVec3 {
    let (sin, cos) = (TAU * random.positive()).sin_cos();
    let (x, y) = from.any_orthonormal_pair();
    (from * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()).normalize()
}

/// One of the two points at which a line crosses a sphere.
#[derive(Clone, Copy, PartialEq)]
enum Crossing {
    Entry,
    Exit,
}

/// Distance along a ray to a sphere around the origin; `None` if the ray misses this crossing.
fn distance_to_sphere(p: DVec3, direction: DVec3, radius: f64, crossing: Crossing) -> Option<f64> {
    let b = p.dot(direction);
    let discriminant = b * b - p.length_squared() + radius * radius;
    let half_chord = discriminant.max(0.0).sqrt();
    let distance = if crossing == Crossing::Entry { -b - half_chord } else { -b + half_chord };
    (discriminant > 0.0 && distance > 0.0).then_some(distance)
}

/// Arguments in the order of `src/scene/atmosphere/phase.rs`.
fn henyey_greenstein(cosine: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

/// Phase function of a channel per steradian, also for `air_reference` and `reference_rays`. Random angles follow from it.
pub fn per_steradian(phase: PhaseFunction, channel: usize, cosine: f64) -> f64 {
    match phase {
        PhaseFunction::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cosine * cosine),
        // Destructured without `..`, so that a new parameter is a compile error.
        PhaseFunction::Aerosol(AerosolPhase { function, asymmetry }) => match function {
            AerosolFunction::HenyeyGreenstein => henyey_greenstein(cosine, asymmetry[channel]),
        },
    }
}

/// A random cosine, distributed by Henyey-Greenstein's function.
fn henyey_greenstein_cosine(random: &mut Random, g: f64) -> f64 {
    if g.abs() < 1e-6 {
        return 2.0 * random.uniform() - 1.0;
    }
    let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * random.uniform());
    (1.0 + g * g - ratio * ratio) / (2.0 * g)
}

/// Random scattering angles, distributed by the phase function of a channel.
pub struct ScatteringAngles {
    phase: PhaseFunction,
    channel: usize,
    /// Ascending cosines, each with the fraction of the light that is scattered at smaller ones.
    fractions: Vec<[f64; 2]>,
}

impl ScatteringAngles {
    pub fn new(phase: PhaseFunction, channel: usize) -> Self {
        const STEPS: u32 = 4000;
        // Closely spaced at both ends, where functions have their peaks.
        let cosine = |k: u32| {
            let t = TAU * f64::from(k) / f64::from(STEPS);
            -(0.5 * (t - t.sin())).cos()
        };
        let (mut sum, mut fractions) = (0.0, vec![[-1.0, 0.0]]);
        for (from, to) in (0..STEPS).map(|k| (cosine(k), cosine(k + 1))) {
            sum += 0.5 * (to - from) * (per_steradian(phase, channel, from) + per_steradian(phase, channel, to));
            fractions.push([to, sum]);
        }
        for [_, fraction] in &mut fractions {
            *fraction /= sum;
        }
        Self { phase, channel, fractions }
    }

    /// The cosine of a random angle.
    pub fn cosine(&self, random: &mut Random) -> f64 {
        if self.phase == PhaseFunction::Rayleigh {
            // By rejection: a gas nowhere scatters more than forwards.
            let value = |cosine: f64| per_steradian(self.phase, self.channel, cosine);
            loop {
                let cosine = 2.0 * random.uniform() - 1.0;
                if random.uniform() * value(1.0) < value(cosine) {
                    return cosine;
                }
            }
        }
        let fraction = random.uniform();
        let above = self.fractions.partition_point(|[_, below]| *below <= fraction).clamp(1, self.fractions.len() - 1);
        let ([from, at_from], [to, at_to]) = (self.fractions[above - 1], self.fractions[above]);
        from + (to - from) * (fraction - at_from) / (at_to - at_from)
    }
}

impl<'a> Air<'a> {
    /// The air of a body that has an atmosphere.
    pub fn of(body: &'a Body, channel: usize) -> Self {
        let atmosphere = body.atmosphere.as_ref().expect("air");
        let max_extinction_per_km = atmosphere.species.iter().map(|s| s.scattering_per_km[channel] + s.absorption_per_km[channel]).sum();
        let albedo = body.mean_reflectance()[channel];
        let angles = atmosphere.species.iter().map(|s| ScatteringAngles::new(s.phase, channel)).collect();
        Self { body, species: &atmosphere.species, angles, channel, top_km: atmosphere.top_km, albedo, max_extinction_per_km }
    }

    fn density(species: &Species, height_km: f64) -> f64 {
        match species.tent_centre_km {
            Some(centre) => (1.0 - (height_km - centre).abs() / species.scale_height_km).max(0.0),
            None => (-height_km / species.scale_height_km).exp(),
        }
    }

    fn extinction_per_km(&self, height_km: f64) -> f64 {
        let of = |s: &Species| (s.scattering_per_km[self.channel] + s.absorption_per_km[self.channel]) * Self::density(s, height_km);
        self.species.iter().map(of).sum()
    }

    fn scattering_per_km(&self, height_km: f64) -> impl Iterator<Item = (&Species, f64)> {
        self.species.iter().map(move |s| (s, s.scattering_per_km[self.channel] * Self::density(s, height_km)))
    }

    fn height_km(&self, p: DVec3) -> f64 {
        (p.length() - self.body.radii_km.x).max(0.0)
    }

    /// Transmittance towards the Sun; 0 if the body is in front of it.
    fn sun_transmittance(&self, p: DVec3, sun: DVec3) -> f64 {
        const STEPS: u32 = 96;
        let radius_km = self.body.radii_km.x;
        if distance_to_sphere(p, sun, radius_km, Crossing::Entry).is_some() {
            return 0.0;
        }
        // Steps grow away from the point, which is where the air is densest unless the Sun is below the horizon.
        let length_km = distance_to_sphere(p, sun, radius_km + self.top_km, Crossing::Exit).unwrap_or(0.0);
        let depth = |k: u32| {
            let u = (f64::from(k) + 0.5) / f64::from(STEPS);
            self.extinction_per_km(self.height_km(p + sun * (length_km * u * u))) * length_km * 2.0 * u / f64::from(STEPS)
        };
        (-(0..STEPS).map(depth).sum::<f64>()).exp()
    }

    /// A random direction in the sky, and one over the density of such directions per steradian; `None` for a direction below the horizon. A third of the
    /// directions is distributed with the cosine of the zenith angle, a third towards the horizon in the Sun's azimuth, from where most twilight comes, and a
    /// third around the Sun, where aerosols scatter most: by Henyey-Greenstein's function, whatever the phase functions of the air are.
    fn sky_direction(random: &mut Random, sun: DVec3) -> Option<(DVec3, f64)> {
        /// Asymmetry of the last third.
        const AROUND_SUN: f64 = 0.7;
        // The Sun's direction, or 3 degrees above the horizon in the Sun's azimuth if the Sun is lower: from there comes the light of twilight.
        let glow = DVec3::new(sun.x, sun.y, sun.z.max(0.05)).normalize();
        // Density of the second third's azimuths, per radian from the Sun's azimuth: 0.7 of them are within 0.8 rad, the others all around.
        let azimuth_density = |azimuth: f64| 0.3 / TAU + if azimuth.abs() < 0.8 { 0.7 / 1.6 } else { 0.0 };
        let direction = match (3.0 * random.uniform()) as u32 {
            0 => {
                let cosine = random.positive().sqrt();
                deflected(random, DVec3::Z, cosine)
            }
            1 => {
                let cosine = random.positive().powi(2);
                let azimuth = if random.positive() < 0.7 { 0.8 } else { PI } * (2.0 * random.positive() - 1.0);
                let horizontal = (1.0 - cosine * cosine).sqrt();
                DVec3::new(horizontal * azimuth.cos(), horizontal * azimuth.sin(), cosine)
            }
            _ => {
                let cosine = henyey_greenstein_cosine(random, AROUND_SUN);
                deflected(random, glow, cosine)
            }
        };
        if direction.z <= 0.0 {
            return None;
        }
        // In the second third, the cosine of the zenith angle is the square of a uniform number, so its density is 1 / (2 sqrt(cosine)).
        let horizon_density = azimuth_density(direction.y.atan2(direction.x)) / (2.0 * direction.z.sqrt());
        let density = (direction.z / PI + horizon_density + henyey_greenstein(direction.dot(glow), AROUND_SUN)) / 3.0;
        Some((direction, 1.0 / density))
    }

    /// Optical depth of the first `length_km` of a ray.
    fn depth(&self, from: DVec3, direction: DVec3, length_km: f64) -> f64 {
        const STEPS: u32 = 200;
        let step_km = length_km / f64::from(STEPS);
        let extinction = |k: u32| self.extinction_per_km(self.height_km(from + direction * (step_km * (f64::from(k) + 0.5))));
        (0..STEPS).map(extinction).sum::<f64>() * step_km
    }

    /// Distance along a ray at which a photon meets the air, by delta tracking; `None` if it reaches `end_km` before.
    fn free_path_km(&self, random: &mut Random, from: DVec3, direction: DVec3, end_km: f64) -> Option<f64> {
        let mut distance_km = 0.0;
        loop {
            distance_km -= random.positive().ln() / self.max_extinction_per_km;
            if distance_km >= end_km {
                return None;
            }
            let height_km = self.height_km(from + direction * distance_km);
            if random.positive() * self.max_extinction_per_km < self.extinction_per_km(height_km) {
                return Some(distance_km);
            }
        }
    }

    /// Skylight by `paths` photons followed backwards; each scattering adds the sunlight that is scattered there into the path. `sun_cosine`: of the Sun's
    /// zenith angle.
    pub fn skylight(&self, sun_cosine: f64, paths: u32) -> Skylight {
        let radius_km = self.body.radii_km.x;
        let sun = DVec3::new((1.0 - sun_cosine * sun_cosine).max(0.0).sqrt(), 0.0, sun_cosine);
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let (mut once, mut all, mut squares) = (0.0, 0.0, 0.0);
        for _ in 0..paths {
            let Some((mut direction, inverse_density)) = Self::sky_direction(&mut random, sun) else { continue };
            let mut weight = direction.z * inverse_density;
            let mut position = DVec3::Z * (radius_km + 0.002);
            let mut light = 0.0;
            for order in 0..MAX_ORDERS {
                let ground_km = distance_to_sphere(position, direction, radius_km, Crossing::Entry);
                let to_space = || distance_to_sphere(position, direction, radius_km + self.top_km, Crossing::Exit);
                let end_km = ground_km.or_else(to_space).unwrap_or(0.0);
                let mut free_path_km = self.free_path_km(&mut random, position, direction, end_km);
                if order == 0 {
                    // In thin air few photons would be scattered at all. So each photon is scattered, and its weight is multiplied by the probability of that.
                    weight *= -(-self.depth(position, direction, end_km)).exp_m1();
                    if weight <= 0.0 {
                        break;
                    }
                    while free_path_km.is_none() {
                        free_path_km = self.free_path_km(&mut random, position, direction, end_km);
                    }
                }
                if let Some(free_path_km) = free_path_km {
                    position += direction * free_path_km;
                    let height_km = self.height_km(position);
                    let extinction = self.extinction_per_km(height_km);
                    let sunlight = self.sun_transmittance(position, sun);
                    let towards_path =
                        |(s, scattering): (&Species, f64)| scattering * per_steradian(s.phase, self.channel, direction.dot(sun));
                    let scattered = weight * sunlight * self.scattering_per_km(height_km).map(towards_path).sum::<f64>() / extinction;
                    light += scattered;
                    once += if order == 0 { scattered } else { 0.0 };
                    let total: f64 = self.scattering_per_km(height_km).map(|(_, scattering)| scattering).sum();
                    weight *= total / extinction;
                    let mut chosen = random.uniform() * total;
                    let species = self.scattering_per_km(height_km).position(|(_, scattering)| {
                        chosen -= scattering;
                        chosen < 0.0
                    });
                    let Some(species) = species else { break };
                    let turn_cosine = self.angles[species].cosine(&mut random);
                    direction = deflected(&mut random, direction, turn_cosine);
                } else if let Some(ground_km) = ground_km {
                    let up = (position + direction * ground_km).normalize();
                    position = up * (radius_km + 0.001);
                    weight *= self.albedo;
                    light += weight * self.sun_transmittance(position, sun) * up.dot(sun).max(0.0) / PI;
                    let cosine = random.positive().sqrt();
                    direction = deflected(&mut random, up, cosine);
                } else {
                    break;
                }
                // Faint paths end by Russian roulette.
                if weight < 0.01 {
                    if random.positive() < 0.5 {
                        break;
                    }
                    weight *= 2.0;
                }
            }
            all += light;
            squares += light * light;
        }
        let (n, mean) = (f64::from(paths), all / f64::from(paths));
        Skylight { once: once / n, all: mean, error: ((squares / n - mean * mean).max(0.0) / n).sqrt() }
    }
}
