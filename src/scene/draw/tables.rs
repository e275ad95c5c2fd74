//! Tables that draws read by texel: plain values, made by `rings`.

/// Integrals over a ring's radius: texels row by row, four numbers each. What each is stands in shaders/lib/ring/profile.wesl for the ring itself and in
/// shaders/lib/ring/shadow.wesl for its shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct RingTable {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<f32>,
    /// Innermost and outermost radius, equatorial radii.
    pub reach: [f64; 2],
    /// A radius lies in the bin of this number, less the second one over the radius; the last bin.
    pub bins: [f64; 3],
    /// Of a ring's own table the first and the last slope of its rows.
    pub slopes: [u32; 2],
}

impl RingTable {
    /// Rows after that of the bins.
    pub fn rows(&self) -> u32 {
        self.height - 1
    }
}

/// Irradiance of level ground over its height above the ring's plane, per unit of sunlight: texels row by row, red, green, blue and 0. The rows of the side
/// that the Sun's centre is on, then those of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct RingShine {
    pub texels: Vec<f32>,
    /// Height (unit-sphere frame) from which on no ring is seen.
    pub reach: f64,
    /// The greatest irradiance of any place, the brightest channel.
    pub brightest: f64,
}

/// The Moon's own limb: texels row by row, height and its change to the next, 0 and 0; radii.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbTable {
    pub texels: Vec<f32>,
}
