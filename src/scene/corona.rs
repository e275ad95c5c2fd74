//! The Sun's corona: how bright it is at a distance from the Sun's centre.
//!
//! In: a distance in solar radii. Out: the radiance of K and F corona together, mean over position angles. Left out: streamers and their change from one
//! eclipse to the next, which reaches a factor of two.

use super::photometry::sun_disc_radiance;

/// Mean radiance of the disc over that of its centre in the visual band: 1 - u1/3 - u2/6 for the catalog's law of limb darkening is 0.8 to 0.9;
/// Baumbach's figures count in units of the disc's centre.
const CENTRE_OVER_MEAN: f64 = 1.2;

/// Radiance at `rho` solar radii from the Sun's centre, in units of a white plane's that faces the Sun at 1 au; 0 on the disc.
///
/// Baumbach 1937, Astron. Nachr. 263, 121: 1e-6 (0.0532 rho^-2.5 + 1.425 rho^-7 + 2.565 rho^-17) of the radiance of the disc's centre.
pub fn radiance(rho: f64) -> f64 {
    if rho < 1.0 {
        return 0.0;
    }
    let of_centre = 1e-6 * (0.0532 * rho.powf(-2.5) + 1.425 * rho.powi(-7) + 2.565 * rho.powi(-17));
    of_centre * CENTRE_OVER_MEAN * sun_disc_radiance()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// The whole corona beyond 1.03 radii is about half a full Moon: 0.5e-6 to 1.5e-6 of the Sun's light (Allen's Astrophysical Quantities, 4th ed., 14.8).
    #[test]
    fn all_of_it_is_about_a_millionth_of_the_sun() {
        let rings = 20_000;
        let step = 9.0 / f64::from(rings);
        let total: f64 = (0..rings).map(|k| 1.03 + (f64::from(k) + 0.5) * step).map(|rho| radiance(rho) * TAU * rho * step).sum();
        let part = total / (PI * sun_disc_radiance());
        assert!((0.5e-6..2e-6).contains(&part), "{part:e}");
    }

    #[test]
    fn it_fades_outward_and_is_nothing_on_the_disc() {
        assert_eq!(radiance(0.99), 0.0);
        let falls = (0..100).map(|k| 1.0 + f64::from(k) * 0.1).collect::<Vec<_>>();
        assert!(falls.windows(2).all(|w| radiance(w[0]) > radiance(w[1])));
    }
}
