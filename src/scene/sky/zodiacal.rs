//! Zodiacal light: the radiance of sunlit interplanetary dust, in any direction and at any distance of the observer from the Sun.
//!
//! In: elongation from the Sun and ecliptic latitude. Out: radiance. The source is Leinert et al. 1998 (A&AS 127, 1), table 17, at 500 nm, which is accurate
//! to 10 %. [`brightness`] is within 13 % of each entry of that table at an elongation of 15 degrees or more. At r au from the Sun the zodiacal light scales
//! with r^-2.3 (Helios 1 and 2 between 0.3 and 1 au, Leinert et al. 1981, A&A 103, 177); outside that range this is an extrapolation. At smaller elongations
//! the corona replaces the zodiacal light. Its outer part, the F corona, is light of the same dust, and at a fixed elongation it falls as r^-2.5. Where the two
//! are blended, the ratio of zodiacal light to corona is therefore between 0.5 and 2 for r from 0.3 to 5 au (0.54 at 0.3 au). Left out: the cloud's tilt of 1.5
//! degrees with its seasonal effects, observers far off the ecliptic, and the dust's reddening.

use crate::scene::light::photometry::irradiance_of_magnitude;
use glam::DVec4;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Square degrees in a steradian.
const SQUARE_DEGREES_PER_SR: f64 = (180.0 / PI) * (180.0 / PI);

/// Radiance of one star of tenth magnitude per square degree.
pub(crate) static S10: LazyLock<f64> = LazyLock::new(|| irradiance_of_magnitude(10.0) * SQUARE_DEGREES_PER_SR * PI);

/// One S10 unit (one star of tenth magnitude and of the Sun's colour per square degree) in the table's unit, 1e-8 W/m2/sr/um (Leinert et al. 1998, table 2).
const TABLE_PER_S10: f64 = 1.28;
/// Exponent of the observer's distance from the Sun.
const DISTANCE_EXPONENT: f64 = -2.3;
/// Distance of the observer from the Sun, au, within which no zodiacal light is drawn, only the corona.
pub(crate) const NEAREST_AU: f64 = 0.1;
/// Elongations, degrees, between which the corona blends into the zodiacal light.
pub(crate) const CORONA_BLEND_DEG: (f64, f64) = (15.0, 25.0);

/// Offset in [`brightness`] that keeps the logarithm's argument positive in the direction of the Sun.
pub(crate) const LOG_OFFSET: f64 = 1.02;
/// Coefficients of the binary logarithm of the table's values: rows are powers of log2(`LOG_OFFSET` - cosine of the elongation), columns are powers
/// of the sine of the latitude.
pub(crate) const LAW: [[f64; 4]; 5] = [
    [7.8937, 0.0533, -5.4046, 3.8745],
    [-0.8988, 2.1406, -4.6106, 2.7313],
    [0.4626, -1.6305, 3.2623, -1.2307],
    [0.2008, -1.2444, 3.586, -1.698],
    [0.0279, -0.1863, 0.4585, 0.1464],
];

/// Brightness at 1 au in the table's unit, without the blend into the corona. The table is valid for an observer in the ecliptic; for an observer far from
/// the ecliptic the result is an estimate.
pub fn brightness(cos_elongation: f64, sin_latitude: f64) -> f64 {
    let log_term = (LOG_OFFSET - cos_elongation).log2();
    // For an observer in the ecliptic the sine of the latitude never exceeds that of the elongation. For other observers it is limited to that.
    let sine = sin_latitude.abs().min((1.0 - cos_elongation * cos_elongation).max(0.0).sqrt());
    let latitude_polynomial = LAW.into_iter().rev().fold(DVec4::ZERO, |sum, row| sum * log_term + DVec4::from_array(row));
    latitude_polynomial.dot(DVec4::new(1.0, sine, sine * sine, sine * sine * sine)).exp2()
}

/// Radiance that a value of 1 of [`brightness`] stands for, for an observer at this distance from the Sun.
pub fn unit_radiance(sun_distance_au: f64) -> f64 {
    *S10 / TABLE_PER_S10 * sun_distance_au.powf(DISTANCE_EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leinert et al. 1998, table 17: rows by difference of longitude from the Sun, columns by latitude; 0 for entries that the table does not have.
    const LATITUDES: [f64; 11] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 45.0, 60.0, 75.0, 90.0];
    const TABLE: [(f64, [f64; 11]); 19] = [
        (0.0, [0.0, 0.0, 0.0, 3140.0, 1610.0, 985.0, 640.0, 275.0, 150.0, 100.0, 77.0]),
        (5.0, [0.0, 0.0, 0.0, 2940.0, 1540.0, 945.0, 625.0, 271.0, 150.0, 100.0, 77.0]),
        (10.0, [0.0, 0.0, 4740.0, 2470.0, 1370.0, 865.0, 590.0, 264.0, 148.0, 100.0, 77.0]),
        (15.0, [11500.0, 6780.0, 3440.0, 1860.0, 1110.0, 755.0, 525.0, 251.0, 146.0, 100.0, 77.0]),
        (20.0, [6400.0, 4480.0, 2410.0, 1410.0, 910.0, 635.0, 454.0, 237.0, 141.0, 99.0, 77.0]),
        (25.0, [3840.0, 2830.0, 1730.0, 1100.0, 749.0, 545.0, 410.0, 223.0, 136.0, 97.0, 77.0]),
        (30.0, [2480.0, 1870.0, 1220.0, 845.0, 615.0, 467.0, 365.0, 207.0, 131.0, 95.0, 77.0]),
        (35.0, [1650.0, 1270.0, 910.0, 680.0, 510.0, 397.0, 320.0, 193.0, 125.0, 93.0, 77.0]),
        (40.0, [1180.0, 940.0, 700.0, 530.0, 416.0, 338.0, 282.0, 179.0, 120.0, 92.0, 77.0]),
        (45.0, [910.0, 730.0, 555.0, 442.0, 356.0, 292.0, 250.0, 166.0, 116.0, 90.0, 77.0]),
        (60.0, [505.0, 442.0, 352.0, 292.0, 243.0, 209.0, 183.0, 134.0, 104.0, 86.0, 77.0]),
        (75.0, [338.0, 317.0, 269.0, 227.0, 196.0, 172.0, 151.0, 116.0, 93.0, 82.0, 77.0]),
        (90.0, [259.0, 251.0, 225.0, 193.0, 166.0, 147.0, 132.0, 104.0, 86.0, 79.0, 77.0]),
        (105.0, [212.0, 210.0, 197.0, 170.0, 150.0, 133.0, 119.0, 96.0, 82.0, 77.0, 77.0]),
        (120.0, [188.0, 186.0, 177.0, 154.0, 138.0, 125.0, 113.0, 90.0, 77.0, 74.0, 77.0]),
        (135.0, [179.0, 178.0, 166.0, 147.0, 134.0, 122.0, 110.0, 90.0, 77.0, 73.0, 77.0]),
        (150.0, [179.0, 178.0, 165.0, 148.0, 137.0, 127.0, 116.0, 96.0, 79.0, 72.0, 77.0]),
        (165.0, [196.0, 192.0, 179.0, 165.0, 151.0, 141.0, 131.0, 104.0, 82.0, 72.0, 77.0]),
        (180.0, [230.0, 212.0, 195.0, 178.0, 163.0, 148.0, 134.0, 105.0, 83.0, 72.0, 77.0]),
    ];

    #[test]
    fn the_law_fits_the_published_table() {
        let (mut worst, mut compared): (f64, u32) = (0.0, 0);
        for (longitude, row) in TABLE {
            for (latitude, published) in LATITUDES.into_iter().zip(row).filter(|(_, v)| *v > 0.0) {
                let (lon, lat) = (f64::to_radians(longitude), f64::to_radians(latitude));
                let cos_elongation = lat.cos() * lon.cos();
                // A tenth of a degree less than 15, so that rounding does not exclude the entries at 15 degrees.
                if cos_elongation > 14.9_f64.to_radians().cos() {
                    continue;
                }
                let error = brightness(cos_elongation, lat.sin()) / published - 1.0;
                worst = worst.max(error.abs());
                compared += 1;
                assert!(error.abs() < 0.13, "{longitude}, {latitude}: {error:.3}");
                assert_eq!(brightness(cos_elongation, lat.sin()), brightness(cos_elongation, -lat.sin()));
            }
        }
        println!("{compared} entries, worst {worst:.3}");
        assert!(compared > 190, "{compared}");
        // Negative control: a law without latitude would fail. At 60 degrees of elongation the ecliptic is more than twice as bright as the latitude of 60
        // degrees.
        let (cos_60_deg, sin_60_deg) = (0.5, 0.866);
        assert!(brightness(cos_60_deg, 0.0) / brightness(cos_60_deg, sin_60_deg) > 2.0);
    }

    /// From outside the ecliptic, any combination of elongation and latitude occurs: the law stays between 60 (the table's least value is 72) and its value
    /// in the ecliptic at the smallest elongation.
    #[test]
    fn the_law_stays_finite_for_every_direction() {
        let (brightest, faintest) = (brightness(CORONA_BLEND_DEG.0.to_radians().cos(), 0.0), 60.0);
        for elongation in 15..=180 {
            for latitude in 0..=90 {
                let value = brightness(f64::from(elongation).to_radians().cos(), f64::from(latitude).to_radians().sin());
                assert!((faintest..=1.01 * brightest).contains(&value), "{elongation}, {latitude}: {value}");
            }
        }
    }

    /// In the range of elongations where the corona blends into the zodiacal light, both laws, averaged around the Sun, agree within a factor of 2. Both are
    /// published, and neither is fitted to the other.
    #[test]
    fn corona_and_zodiacal_light_meet() {
        use crate::scene::light::corona;
        use crate::units::{KM_PER_AU, SUN_RADIUS_KM};
        for au in [0.3, 1.0, 5.2] {
            for degrees in [CORONA_BLEND_DEG.0, 20.0, CORONA_BLEND_DEG.1] {
                let (sin, cos) = f64::to_radians(degrees).sin_cos();
                let around = (0..360).map(|a| brightness(cos, sin * f64::from(a).to_radians().sin())).sum::<f64>() / 360.0;
                let ratio = around * unit_radiance(au) / corona::radiance(sin * au * KM_PER_AU / SUN_RADIUS_KM);
                println!("{au} au, {degrees} degrees: {ratio:.2}");
                assert!((0.5..2.0).contains(&ratio), "{au} au, {degrees} degrees: {ratio}");
            }
        }
    }
}
