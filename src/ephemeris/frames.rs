//! The frame of the planetary theories. Out: the constant rotation from their ecliptic to ICRF.

use glam::{DMat3, DVec3};

/// Rotation from VSOP87's dynamical ecliptic and equinox of J2000 to FK5's equator, with the theory's own coefficients (Bretagnon and
/// Francou, Astron. Astrophys. 202 (1988), 309). The axes of FK5 and ICRF differ by 0.02 arcsec, less than the theories' errors.
pub fn icrf_from_ecliptic() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(1.0, -0.000_000_479_966, 0.0),
        DVec3::new(0.000_000_440_360, 0.917_482_137_087, 0.397_776_982_902),
        DVec3::new(-0.000_000_190_919, -0.397_776_982_902, 0.917_482_137_087),
    )
}
