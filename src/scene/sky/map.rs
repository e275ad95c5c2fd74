//! A panorama of the sky: its frame, and what its texels mean.
//!
//! In: nothing but published figures, or what a file says. Out: [`SkyMap`]. Not here: texels.

use crate::scene::sky::frames::SkyFrame;
use crate::scene::sky::zodiacal::S10;

/// A panorama of the whole sky, equirectangular, longitude 0 in the middle and growing to the left, and what its texels mean.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// As whoever holds it knows it.
    pub file: String,
    pub frame: SkyFrame,
    /// Texels around the equator.
    pub width: u32,
    /// Radiance where a linear value is 1.
    pub unit_radiance: f64,
    /// Greatest linear value of a region of some texels.
    pub brightest: f64,
    /// How the feature is described.
    pub is_milky_way: bool,
}

/// File of the panorama that ships.
pub const MILKY_WAY_FILE: &str = "milky_way.jpg";

/// Surface brightness of the Large Sagittarius Star Cloud, the mean over 3 degrees at l 2, b -4: 20.5 V magnitudes in a square second, an estimate to 0.5 magnitudes
/// (published surface photometry of the brightest Milky Way lies between 20 and 21). In stars of tenth magnitude in a square degree.
const CLOUD_S10: f64 = 820.0;
/// What the panorama's linear luminance is there.
const CLOUD_VALUE: f64 = 0.3385;

impl SkyMap {
    /// The Milky Way that ships. Stars are filtered out of it: the catalogue's come apart. With the cloud above at its brightness its mean over the sky is 71 stars of tenth
    /// magnitude in a square degree, and the stars to V 7 add 26: together the 100 or so of integrated starlight (Roach & Megill 1961, ApJ 133, 228).
    pub fn milky_way() -> Self {
        let unit_radiance = CLOUD_S10 / CLOUD_VALUE * *S10;
        Self {
            file: MILKY_WAY_FILE.into(),
            frame: SkyFrame::Galactic,
            width: 2048,
            unit_radiance,
            brightest: CLOUD_VALUE,
            is_milky_way: true,
        }
    }
}
