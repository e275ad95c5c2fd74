//! Tables that shaders read as textures: plain values. `scene::rings` fills those of rings, `scene::visibility` fills that of the lunar limb profile;
//! `render::plan` makes textures from them.

use crate::scene::constants::RING_BIN_ROWS;

/// A ring's profile, integrated over radius, for the ring's own draw or for the ring's shadow: texels row by row, four numbers per texel.
/// shaders/lib/ring/profile.wesl documents the layout for the ring's own draw, shaders/lib/ring/shadow.wesl that for the shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct RingTable {
    pub width: u32,
    pub height: u32,
    pub texels: Vec<f32>,
    /// Innermost and outermost radius, equatorial radii.
    pub radius_range: [f64; 2],
    /// Coefficients of the bin index, `bins[0] - bins[1] / radius`; `bins[2]` is the index of the last bin.
    pub bins: [f64; 3],
    /// Indices of the first and the last slant for which the table of a ring's own draw has rows.
    pub slants: [u32; 2],
}

impl RingTable {
    /// Number of rows after the first rows, which hold the bins.
    pub fn rows_after_bins(&self) -> u32 {
        self.height - RING_BIN_ROWS
    }
}

/// Irradiance of level ground by ring-shine, divided by the ground's height above the ring's plane and by the Sun's irradiance: a function of this height
/// (rows) and of the hour angle from the Sun (columns). Texels row by row, red, green, blue and 0. First the rows of the side of the plane that the Sun's
/// centre is on, then those of the other side.
#[derive(Clone, Debug, PartialEq)]
pub struct RingShine {
    pub texels: Vec<f32>,
    /// Height above the ring's plane (|z| in the unit-sphere frame) above which no ring is visible.
    pub max_height: f64,
    /// The largest irradiance (not divided by height), brightest channel, relative to the Sun's.
    pub brightest: f64,
}

/// The shadow of the rings of another body: a square grid of places across the direction to the Sun, around the body's centre.
#[derive(Clone, Debug, PartialEq)]
pub struct RingShadowGrid {
    /// Number of places along a side, at least 2.
    pub side: u32,
    /// Fraction of sunlight that passes the rings to each place. Texels row by row: red, green, blue and 0.
    pub texels: Vec<f32>,
}

/// The lunar limb profile: one texel per position angle, in increasing order. Each texel contains the height above the sphere of the Moon's radius, the
/// difference between the next height and this one, 0 and 0. Heights are in the Moon's radii.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbTable {
    pub texels: Vec<f32>,
}
