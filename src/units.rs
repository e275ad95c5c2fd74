//! Physical constants and unit conversions, each with its source.
//!
//! Everything inside Orrery is SI with kilometres for lengths and radians for angles; degrees exist at the user's edge only.

/// Kilometres in one astronomical unit (IAU 2012 Resolution B2, exact).
pub const KM_PER_AU: f64 = 149_597_870.7;
/// Speed of light in km/s (SI, exact).
pub const SPEED_OF_LIGHT_KM_S: f64 = 299_792.458;
/// Nominal solar radius in km (IAU 2015 Resolution B3, exact).
pub const SUN_RADIUS_KM: f64 = 695_700.0;
/// Solar irradiance at 1 au in W/m² (IAU 2015 Resolution B3 nominal total solar irradiance).
pub const SOLAR_IRRADIANCE_W_M2: f64 = 1361.0;
pub const SECONDS_PER_DAY: f64 = 86_400.0;
/// Julian date of J2000.0, 2000-01-01T12:00 in the scale at hand.
pub const JD_J2000: f64 = 2_451_545.0;
pub const DAYS_PER_JULIAN_CENTURY: f64 = 36_525.0;
pub const RAD_PER_ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);

/// Luminance of linear RGB with the primaries of sRGB (ITU-R BT.709-6, item 3.2).
pub fn luminance([red, green, blue]: [f64; 3]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}
