//! Apparent positions of the Sun, and of the Moon or an inferior planet, from the Earth's centre over some hours.
//!
//! In: the ephemeris and an instant. Out: apparent positions as Chebyshev polynomials, accurate to under a metre: the search for contacts evaluates these,
//! which is faster than the ephemeris. Light time and the aberration of the Earth's motion are included: the frame moves with the Earth, so light from the Sun
//! past the Moon to the ground follows a straight line. The eclipse shaders use the same frame. Neglected: the 20 metres that the Moon moves while light
//! travels the Earth's radius. Not included: bending of light, refraction.

use super::fitted::FittedPosition;
use crate::catalog::{Catalog, EclipseRadii, NaifId};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError};
use crate::time::Instant;
use glam::{DMat3, DVec3};

/// Angular velocity of the Earth relative to the ICRF, radians per second (IERS Conventions 2010, eq. 5.15).
const EARTH_ROTATION_RAD_PER_S: f64 = 7.292_115_146_7e-5;

/// The apparent position of a body from the Earth's centre at `t`: km, ICRF axes, which are those of the GCRS.
///
/// # Errors
/// The ephemeris does not cover `t`.
pub(super) fn apparent_position_km(ephemeris: &Ephemeris, body: NaifId, t: Instant) -> Result<DVec3, EphemerisError> {
    let earth = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state;
    let (position_at_emission_km, _emission_time) = ephemeris.light_time_position(body, earth.pos_km, t)?;
    let offset_km = position_at_emission_km - earth.pos_km;
    let distance_km = offset_km.length();
    Ok(aberrated(offset_km / distance_km, earth.vel_km_s) * distance_km)
}

/// Radii of the Sun, the Moon and the Earth, km, from the catalog. For the transit of a planet, `transit` replaces the Moon's radii by the planet's.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyRadii {
    pub sun_radius_km: f64,
    /// The Moon's radius for the umbra.
    pub moon_radius_km: f64,
    /// The Moon's radius for the penumbra, for which almanacs use a larger one.
    pub penumbral_moon_radius_km: f64,
    /// The Earth's semi-axes.
    pub earth_radii_km: DVec3,
    /// The convention (IAU or almanacs) that the Sun's and the Moon's radii follow; it also sets the enlargement of the Earth's shadow.
    pub convention: EclipseRadii,
}

impl BodyRadii {
    /// The radii of a catalog.
    ///
    /// # Errors
    /// The catalog lacks one of the three bodies.
    pub(crate) fn of(catalog: &Catalog) -> Result<Self, EphemerisError> {
        Self::by(catalog, catalog.eclipse_radii())
    }

    /// The radii of almanacs ([`EclipseRadii::Almanac`]), whatever convention the catalog follows.
    ///
    /// # Errors
    /// The catalog lacks one of the three bodies.
    pub(crate) fn of_almanacs(catalog: &Catalog) -> Result<Self, EphemerisError> {
        Self::by(catalog, EclipseRadii::Almanac)
    }

    /// `convention`: the catalog's own, or one that replaces its radii.
    fn by(catalog: &Catalog, convention: EclipseRadii) -> Result<Self, EphemerisError> {
        let radii_km = |id, name: &str| {
            let body = catalog.body(id).ok_or_else(|| EphemerisError::other(format!("the catalog has no {name}: eclipses need it")))?;
            Ok::<_, EphemerisError>(body.radii_km)
        };
        let of_catalog_km = (radii_km(NaifId::SUN, "Sun")?.x, radii_km(NaifId::MOON, "Moon")?.x);
        let (sun_radius_km, moon_radius_km) = convention.replacement_km().unwrap_or(of_catalog_km);
        Ok(Self {
            sun_radius_km,
            moon_radius_km,
            penumbral_moon_radius_km: moon_radius_km * convention.penumbral_moon_ratio(),
            earth_radii_km: radii_km(NaifId::EARTH, "Earth")?,
            convention,
        })
    }
}

/// Fitted apparent positions of the Sun and of a nearer body, from the Earth's centre. Times are seconds from the middle of the span.
#[derive(Clone, Debug)]
pub(super) struct EarthSky {
    middle: Instant,
    sun: FittedPosition,
    /// The Moon, or the planet in transit.
    near_body: FittedPosition,
    itrs_from_gcrs_at_middle: DMat3,
}

impl EarthSky {
    /// The sky from `half_span_s` before to `half_span_s` after `middle`. `near_body`: the Moon, whose motion the fit follows for a `half_span_s` of up to 19
    /// hours, or a planet that passes in front of the Sun.
    ///
    /// # Errors
    /// The ephemeris does not cover the span.
    pub(crate) fn around(ephemeris: &Ephemeris, near_body: NaifId, middle: Instant, half_span_s: f64) -> Result<Self, EphemerisError> {
        let fit = |body| FittedPosition::fit(half_span_s, |s| apparent_position_km(ephemeris, body, middle.plus_seconds(s)));
        Ok(Self {
            middle,
            sun: fit(NaifId::SUN)?,
            near_body: fit(near_body)?,
            itrs_from_gcrs_at_middle: ephemeris.body_from_icrf(NaifId::EARTH, middle)?,
        })
    }

    /// The instant `s` seconds after the middle.
    pub(crate) fn instant(&self, s: f64) -> Instant {
        self.middle.plus_seconds(s)
    }

    /// Apparent position of the Sun from the Earth's centre, GCRS.
    pub(crate) fn sun_km(&self, s: f64) -> DVec3 {
        self.sun.at(s)
    }

    /// Apparent position of the Moon or the planet from the Earth's centre, GCRS.
    pub(crate) fn near_body_km(&self, s: f64) -> DVec3 {
        self.near_body.at(s)
    }

    /// Rotation from GCRS to ITRS at `s`. Over the span, the Earth is taken to rotate uniformly about its pole at the middle.
    pub(crate) fn itrs_from_gcrs(&self, s: f64) -> DMat3 {
        // The axes of ITRS turn eastwards, so the components of a fixed direction turn westwards.
        DMat3::from_rotation_z(-EARTH_ROTATION_RAD_PER_S * s) * self.itrs_from_gcrs_at_middle
    }

    /// Unit vector to the Earth's north pole at the middle, GCRS.
    pub(crate) fn pole(&self) -> DVec3 {
        self.itrs_from_gcrs_at_middle.row(2)
    }
}
