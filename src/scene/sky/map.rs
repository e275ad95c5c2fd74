//! A panorama of the sky: its frame, and the radiance of its texels.
//!
//! In: published figures, or the metadata of the user's file. Out: [`SkyMap`]. Not here: the texels.

use crate::scene::sky::frames::SkyFrame;
use crate::scene::sky::zodiacal::S10;

/// An equirectangular panorama of the entire sky: longitude 0 in the middle, increasing to the left.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// The name under which the texture is looked up.
    pub file: String,
    pub frame: SkyFrame,
    /// Number of texels around the equator.
    pub width: u32,
    /// Radiance that the linear value 1 stands for.
    pub unit_radiance: f64,
    /// Mean linear value of the brightest region; 1, an upper limit, for a panorama of the user.
    pub brightest_value: f64,
    /// Light that is added to that of the texels: what exceeds the linear value 1. `None` if nothing does.
    pub bright: Option<BrightSkyMap>,
    /// Whether this is the built-in Milky Way, for the text of the decision.
    pub is_milky_way: bool,
}

/// A second panorama with the same axes and size.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightSkyMap {
    /// The name under which the texture is looked up.
    pub file: String,
    /// Radiance that the linear value 1 stands for.
    pub unit_radiance: f64,
}

/// File of the built-in panorama.
pub(crate) const MILKY_WAY_FILE: &str = "milky_way.jpg";

/// Surface brightness of the Large Sagittarius Star Cloud in stars of tenth magnitude per square degree: the mean over a field of 3 degrees at galactic
/// longitude 2 and latitude -4. It is 20.5 V magnitudes per square arcsecond, an estimate to 0.5 magnitudes (published surface photometry of the
/// brightest Milky Way lies between 20 and 21).
const CLOUD_S10: f64 = 820.0;
/// The linear luminance of the same cloud in the panorama.
const CLOUD_LINEAR_VALUE: f64 = 0.3385;

impl SkyMap {
    /// Radiance of the brightest region.
    pub(crate) fn brightest_radiance(&self) -> f64 {
        self.brightest_value * self.unit_radiance + self.bright.as_ref().map_or(0.0, |bright| bright.unit_radiance)
    }

    /// The built-in Milky Way. Stars are filtered out of it, because they are drawn from the star catalog. With the star cloud at `CLOUD_S10`,
    /// the mean over the sky is 71 stars of tenth magnitude per square degree, and the stars to V 7 add 26. The sum agrees with the roughly 100 of
    /// integrated starlight (Roach & Megill 1961, ApJ 133, 228).
    pub(crate) fn milky_way() -> Self {
        let unit_radiance = CLOUD_S10 / CLOUD_LINEAR_VALUE * *S10;
        Self {
            file: MILKY_WAY_FILE.into(),
            frame: SkyFrame::DeepStarMaps,
            width: 2048,
            unit_radiance,
            brightest_value: CLOUD_LINEAR_VALUE,
            bright: None,
            is_milky_way: true,
        }
    }
}
