//! How bright a picture is: the factor from radiance to brightness, and the levels that exposures are made for.

use crate::scene::camera::narrow_scalar;

/// How radiance becomes brightness.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// 2^stops is the factor on radiance.
    pub stops: f64,
    /// What the light meter says, where it was asked; else the same.
    pub metered_stops: f64,
    /// What set it.
    pub reason: String,
}

impl Exposure {
    /// Of stops over 1, and what set them.
    pub fn of(stops: f64, reason: impl Into<String>) -> Self {
        Self { stops, metered_stops: stops, reason: reason.into() }
    }
    /// 2^stops.
    pub fn factor(&self) -> f64 {
        self.stops.exp2()
    }
    /// The factor for the tone map.
    pub fn factor_f32(&self) -> f32 {
        narrow_scalar(self.factor())
    }
    /// The radiance that the picture shows as white.
    pub fn white(&self) -> f64 {
        1.0 / self.factor()
    }
}

/// Exposure of the picture of costs: 16384 instructions are white.
pub const COST_STOPS: f64 = -14.0;
/// Radiance of a fully lit disc in its brightest channel, as a part of white, at automatic exposure: bright features of twice the mean
/// still differ, and a coloured body keeps its colour.
pub const AUTO_EXPOSED_MEAN: f64 = 0.5;
/// The same for the Sun, whose disc is what white is: its centre meets white and the darkened limb stays below.
pub const AUTO_EXPOSED_SUN: f64 = 0.85;
/// Luminance of a white plane that faces the Sun at 1 au, cd/m2: radiance 1. The illuminance is that of V = -26.76 with 2.54e-6 lux for V = 0, 128
/// klx, over pi. An estimate to 5 %, a fourteenth of a stop: published solar illuminance constants lie between 128 and 134 klx.
pub const CANDELAS_PER_RADIANCE: f64 = 128_000.0 / std::f64::consts::PI;
/// Over 2^EV at ISO 100, cd/m2: what a camera's sensor shows as white (ISO 12232's saturation-based speed, a lens that lets 0.65 through:
/// 78 / (100 x 0.65)). Sunlit ground, EV 15, is then exposed by 0 stops.
const WHITE_AT_EV_0: f64 = 1.2;
/// The exposure opens no further: a photograph of the night sky at f/2.8, 8 s, ISO 1600 is one of EV -4. White is then 0.075 cd/m2; a star of 6 mag,
/// the faintest that the eye sees, is a fifteenth of it in a picture of 45 degrees and 1024 pixels.
pub const DARKEST_EV: f64 = -4.0;

/// The radiance that the longest exposure shows as white.
pub fn darkest_white() -> f64 {
    WHITE_AT_EV_0 * DARKEST_EV.exp2() / CANDELAS_PER_RADIANCE
}
