//! The exposure of an image: the factor from radiance to display values; and the constants of automatic exposure: target levels, photometric units, limits.
//!
//! In: stops, from the user or from the light meter. Out: the factor, and the radiance that it shows as white. Not here: the choice of the stops
//! (`auto_exposure`).

use crate::message::Reason;
use crate::scene::camera::narrow_scalar;

/// The exposure of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Base-2 logarithm of the factor that is applied to radiance before the tone map: a larger value makes the image brighter.
    pub stops: f64,
    /// The light meter's result in the same unit. `stops` differs from it during a transition (`ExposureRequest::Transition`). Equal to `stops` if nothing was
    /// metered.
    pub metered_stops: f64,
    /// Why the image has this exposure, for the user; while `stops` differs from `metered_stops`, why it approaches the latter.
    pub reason: Reason,
}

impl Exposure {
    /// An exposure by the factor 2^stops, with the reason for it.
    pub(crate) fn of(stops: f64, reason: Reason) -> Self {
        Self { stops, metered_stops: stops, reason }
    }
    /// The factor by which radiance is multiplied.
    pub fn factor(&self) -> f64 {
        self.stops.exp2()
    }
    /// [`Self::factor`] in the precision of the tone map.
    pub(crate) fn factor_f32(&self) -> f32 {
        narrow_scalar(self.factor())
    }
    /// The radiance that the image shows as white.
    pub fn white(&self) -> f64 {
        1.0 / self.factor()
    }
}

/// Exposure of the pixel view `cost`, in stops: 2^14 instructions are white.
pub(crate) const COST_STOPS: f64 = -14.0;
/// Fraction of white (linear) at which automatic exposure shows the mean radiance of a metered subject (brightest channel), such as a fully lit
/// disc. Details twice as bright as the mean then reach white without being clipped, and a coloured body keeps its colour.
pub const AUTO_EXPOSED_MEAN: f64 = 0.5;
/// The same for the Sun's disc: its centre reaches white, and the darkened limb stays below white.
pub const AUTO_EXPOSED_SUN: f64 = 0.85;
/// Luminance in cd/m2 of radiance 1, that is, of a white plane facing the Sun at 1 au: its illuminance divided by pi. With 2.54e-6 lux for V = 0 (Allen
/// 1976, Astrophysical Quantities), the Sun's V = -26.76 is 128 klx. Good to 5 %, a fourteenth of a stop: published solar illuminance constants lie between
/// 128 and 134 klx.
pub const CD_M2_PER_RADIANCE: f64 = 128_000.0 / std::f64::consts::PI;
/// Luminance that a camera's sensor shows as white at EV 0 and ISO 100, cd/m2; it is proportional to 2^EV (ISO 12232's saturation-based speed with a lens
/// of transmittance 0.65: 78 / (100 x 0.65)). At EV 15, usual for sunlit ground, a radiance of 1 is white to 0.05 stop.
const WHITE_AT_EV_0_CD_M2: f64 = 1.2;
/// Lower limit of the EV of automatic exposure: the EV of a photograph of the Milky Way at f/2.8, 22 s, ISO 3200. White is then 0.013 cd/m2, and the moonless
/// sky of the Earth is shown at a hundredth of it. The faintest star that the eye sees (6 mag) is then grey: in an image of 1024 pixels over a vertical field
/// of 45 degrees, its brightest pixel is at most 0.44 of white.
pub const DARKEST_EV: f64 = -6.5;

/// The smallest radiance that automatic exposure shows as white.
pub fn darkest_white() -> f64 {
    WHITE_AT_EV_0_CD_M2 * DARKEST_EV.exp2() / CD_M2_PER_RADIANCE
}
