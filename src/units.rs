//! Physical and mathematical constants and unit conversions, each with its source.
//!
//! Computations use kilometres, seconds and radians; input and output also have other units, such as degrees. The name of each quantity ends in its unit.

/// Kilometres in one astronomical unit (IAU 2012 Resolution B2, exact).
pub const KM_PER_AU: f64 = 149_597_870.7;
/// Speed of light in km/s (SI, exact).
pub const SPEED_OF_LIGHT_KM_S: f64 = 299_792.458;
/// Nominal solar radius in km (IAU 2015 Resolution B3, exact).
pub const SUN_RADIUS_KM: f64 = 695_700.0;
/// Solar irradiance at 1 au in W/m² (IAU 2015 Resolution B3 nominal total solar irradiance).
pub const SOLAR_IRRADIANCE_W_M2: f64 = 1361.0;
/// Seconds of a Julian day, exact.
pub const SECONDS_PER_DAY: f64 = 86_400.0;
/// Julian date of J2000.0, 2000-01-01T12:00, in whichever time scale is used.
pub const JD_J2000: f64 = 2_451_545.0;
/// Days of 86 400 s in a Julian year, exact.
pub const DAYS_PER_JULIAN_YEAR: f64 = 365.25;
/// Days of 86 400 s in a Julian century, exact.
pub const DAYS_PER_JULIAN_CENTURY: f64 = 36_525.0;
/// Radians in one arcsecond: pi / 648 000, exact.
pub const RAD_PER_ARCSEC: f64 = std::f64::consts::PI / (180.0 * 3600.0);

/// Inverse of the golden ratio, (sqrt 5 - 1) / 2, to 15 digits: the factor by which each step of a golden-section search shrinks its interval.
pub const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// Golden angle in radians: pi (3 - sqrt 5), to the precision of f64. The first N multiples of this angle, taken as azimuths, cover a circle evenly for any N.
pub const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

/// Weights of red, green and blue in the luminance of linear RGB with sRGB primaries, and in the luma of encoded RGB (ITU-R BT.709-6, item 3.2).
pub const LUMINANCE_WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance of linear RGB with sRGB primaries.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    let [red, green, blue] = LUMINANCE_WEIGHTS;
    red * rgb[0] + green * rgb[1] + blue * rgb[2]
}

/// The sRGB transfer function of IEC 61966-2-1, from an encoded value in 0..1 to a linear one.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`srgb_to_linear`], from a linear value in 0..1 to an encoded one.
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
