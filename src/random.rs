//! Pseudorandom numbers for random test cases, covering sets of shader keys, and synthetic minor planets and stars.
//!
//! In: a seed. Out: numbers and directions. Always: the same seed gives the same numbers on every machine; there is no
//! global state. Not here: unpredictable randomness.

/// The state of SplitMix64 (Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators, OOPSLA).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number of which all 64 bits are random.
    pub(crate) fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number, uniform in [0, 1).
    pub(crate) fn unit_interval(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number, uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit_interval()
    }

    /// An index below `count`, uniform but for the negligible bias of the modulo operation; 0 if `count` is 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.next_u64() % count.max(1) as u64) as usize
    }

    /// A uniformly chosen element of `all`, which must not be empty.
    pub(crate) fn choose<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }

    /// A unit vector whose direction is uniform over the sphere.
    pub(crate) fn direction(&mut self) -> glam::DVec3 {
        let (z, angle) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let radius = (1.0 - z * z).sqrt();
        glam::DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    }
}
