//! Pseudo-random numbers for tests: a xorshift generator, which gives the same sequence for the same seed; and the seed of tests whose cases differ in each
//! run.

use glam::DVec3;
use std::f64::consts::TAU;
use std::hash::{BuildHasher, Hasher};

/// `ORRERY_SEED`, which repeats the random cases of a failure; without it, another number in each run.
pub fn seed() -> u64 {
    match std::env::var("ORRERY_SEED") {
        Ok(text) => text.parse().expect("ORRERY_SEED is a whole number"),
        // Short enough to type.
        Err(_) => std::hash::RandomState::new().build_hasher().finish() >> 32,
    }
}

/// The generator's state. It must not be 0, because the state after 0 is 0 again.
pub struct Random(pub u64);

impl Random {
    /// A whole number below 2^53.
    fn integer(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64
    }

    /// Uniform, at least 0, less than 1.
    pub fn uniform(&mut self) -> f64 {
        self.integer() / (1u64 << 53) as f64
    }

    /// Uniform, greater than 0, at most 1: its logarithm is finite.
    pub fn positive(&mut self) -> f64 {
        (self.integer() + 0.5) / (1u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    /// Uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, azimuth) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let horizontal = (1.0 - z * z).sqrt();
        DVec3::new(horizontal * azimuth.cos(), horizontal * azimuth.sin(), z)
    }
}
