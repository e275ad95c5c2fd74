//! Tables that draws read by texel: plain values, made by `rings`.

/// Integrals over a ring's radius: texels row by row, four numbers each. Their meaning is documented in shaders/lib/ring/profile.wesl for the ring itself,
/// and in shaders/lib/ring/shadow.wesl for its shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct RingTable {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<f32>,
    /// Innermost and outermost radius, equatorial radii.
    pub reach: [f64; 2],
    /// Formula of the bin index: the first number minus the second one divided by the radius; the third is the last bin.
    pub bins: [f64; 3],
    /// Indices of the first and the last slope of the rows of a ring's own table.
    pub slopes: [u32; 2],
}

impl RingTable {
    /// Number of rows after that of the bins.
    pub fn rows(&self) -> u32 {
        self.height - 1
    }
}

/// Irradiance of level ground over its height above the ring's plane, per unit of sunlight: texels row by row, red, green, blue and 0. The rows of the side
/// that the Sun's centre is on, then those of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct RingShine {
    pub texels: Vec<f32>,
    /// Height (unit-sphere frame) above which no ring is visible.
    pub reach: f64,
    /// The largest irradiance of any place, brightest channel.
    pub brightest: f64,
}

/// The lunar limb profile: texels row by row: height, its difference to the next, 0 and 0; in radii.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbTable {
    pub texels: Vec<f32>,
}
