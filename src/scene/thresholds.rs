//! Thresholds and limits that several effects share, and the radiance of city lights in a night map.

/// Relative change of a pixel above which an effect is drawn: 0.22 of an 8-bit level at white, less in darker pixels (sRGB curve).
pub const VISIBLE_CHANGE: f64 = 1.0 / 512.0;
/// Radiance above which an effect is drawn, as a fraction of white: half an 8-bit level on black, where the sRGB curve is steepest (slope 12.92). A smaller
/// radiance on black rounds to level 0.
pub const VISIBLE_LIGHT: f64 = 0.5 / 255.0 / 12.92;
/// Maximum number of light sources of a draw: the Sun and two other bodies.
pub const MAX_LIGHTS: u8 = 3;
/// Radiance of a white texel of a night map of gain 1, in units of the radiance of a sunlit white plane at 1 au. City cores reach 500 nW/cm2/sr in the
/// day-night band of VIIRS (Elvidge et al. 2017, Int. J. Remote Sensing 38, 5860). In that band the irradiance by the Sun is 600 W/m2, so the plane's radiance
/// is 600 W/m2/sr divided by pi.
pub(crate) const NIGHT_MAP_WHITE_RADIANCE: f64 = 2.6e-5;
