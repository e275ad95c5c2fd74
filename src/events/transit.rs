//! Transits of Mercury and Venus across the Sun.
//!
//! In: catalog, ephemeris, a span of time. Out: least distance of the centres, magnitude and the contacts of the limbs, as seen from the Earth's centre and
//! from places on the ground. Positions are apparent: the planet where the light passed it, the Sun where the light left it. Not here: the black-drop effect.

use super::contacts::{Contact, seconds_between};
use super::local::{GeodeticPosition, LocalCircumstances, Station};
use super::numeric::{time_of_minimum, zero_crossing};
use super::sky::{BodyRadii, EarthSky, apparent_position_km};
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::{Ephemeris, EphemerisError, angle_rad};
use crate::time::Instant;
use crate::units::{RAD_PER_ARCSEC, SECONDS_PER_DAY};

/// Mercury and Venus.
const INFERIOR_PLANETS: [NaifId; 2] = [NaifId(199), NaifId(299)];
/// Time between samples of the elongation. It has only one minimum in the week around an inferior conjunction, so the samples show this minimum.
const STEP_S: f64 = 2.0 * SECONDS_PER_DAY;
/// Limit of the elongation at a sample within a day of a transit. The elongation changes by at most 1.9 degrees a day.
const MAX_ELONGATION_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Half of the span over which positions are fitted ([`EarthSky`]). The longest transits take 8 hours.
const HALF_SPAN_S: f64 = 6.0 * 3600.0;

/// A transit of an inferior planet.
#[derive(Clone, Debug)]
pub struct Transit {
    /// Mercury or Venus.
    pub planet: NaifId,
    /// When the centres are nearest. Like the contacts, it is the time at which the light reaches the Earth's centre.
    pub greatest: Instant,
    /// Least angle between the centres.
    pub separation_arcsec: f64,
    /// Least separation of the centres in units of the Sun's angular radius; positive if the planet passes (celestial) north of the Sun's centre.
    pub gamma: f64,
    /// The largest covered part of the Sun's diameter: the planet's apparent diameter over the Sun's, unless the planet is never entirely in front of the Sun.
    pub magnitude: f64,
    /// I to IV, with their instants; II and III are missing if the planet is never entirely in front of the Sun.
    pub contacts: Vec<Contact>,
    conjunction: PlanetConjunction,
    /// `greatest` in seconds from the middle of `conjunction.sky`.
    greatest_s: f64,
}

impl Transit {
    /// Seconds from first to fourth contact, which every transit has.
    pub(crate) fn duration_s(&self) -> Option<f64> {
        seconds_between(&self.contacts, "I", "IV")
    }

    /// Local circumstances at a place; `None` if the planet misses the Sun, as seen from there. The Sun may be below the horizon.
    pub fn seen_from(&self, place: GeodeticPosition) -> Option<LocalCircumstances> {
        let station = Station::new(&self.conjunction.sky, self.conjunction.radii, place);
        station.solar_circumstances(self.greatest_s, ["I", "II", "III", "IV"])
    }
}

/// Transits whose greatest phase is in `from..to`, planet by planet.
///
/// # Errors
/// The catalog lacks a body, or the ephemeris does not cover the samples, from two days before the span to six after it, or the four days before and after a
/// sample at an inferior conjunction.
pub fn transits(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<Transit>, EphemerisError> {
    let eclipse_radii = BodyRadii::of(catalog)?;
    let mut found = Vec::new();
    for planet in INFERIOR_PLANETS {
        let body =
            catalog.body(planet).ok_or_else(|| EphemerisError::other(format!("the catalog has no body {}: transits need it", planet.0)))?;
        let planet_radius_km = body.radii_km.x;
        // The planet takes the Moon's place in the computation of an eclipse.
        let radii = BodyRadii { moon_radius_km: planet_radius_km, penumbral_moon_radius_km: planet_radius_km, ..eclipse_radii };
        // Angle between the centres, radians; pi if the planet is behind the Sun.
        let elongation = |t: Instant| -> Result<f64, EphemerisError> {
            let (sun_km, planet_km) = (apparent_position_km(ephemeris, NaifId::SUN, t)?, apparent_position_km(ephemeris, planet, t)?);
            Ok(if planet_km.length() < sun_km.length() { angle_rad(sun_km, planet_km) } else { std::f64::consts::PI })
        };
        let steps = ((to.tdb_seconds_past_j2000() - from.tdb_seconds_past_j2000()) / STEP_S).ceil() as i64 + 1;
        let at = |i: i64| from.plus_seconds(i as f64 * STEP_S);
        let (mut previous, mut current) = (elongation(at(-1))?, elongation(at(0))?);
        for i in 0..=steps {
            let next = elongation(at(i + 1))?;
            if current <= previous && current < next && current < MAX_ELONGATION_RAD {
                let conjunction = PlanetConjunction::around(ephemeris, planet, at(i), radii)?;
                found.extend(conjunction.transit(planet).filter(|t| (from..to).contains(&t.greatest)));
            }
            (previous, current) = (current, next);
        }
    }
    Ok(found)
}

/// The apparent positions of the Sun and a planet around an inferior conjunction. A time `s` is in seconds from the middle of `sky`.
#[derive(Clone, Debug)]
struct PlanetConjunction {
    /// Apparent positions, seen from the Earth's centre; `near_body` is the planet.
    sky: EarthSky,
    /// With the planet's radius in place of the Moon's.
    radii: BodyRadii,
}

impl PlanetConjunction {
    /// `near`: an instant within two days of the conjunction.
    fn around(ephemeris: &Ephemeris, planet: NaifId, near: Instant, radii: BodyRadii) -> Result<Self, EphemerisError> {
        // Fitted over some days to find the middle, then over the hours of a transit.
        let over_days = Self { sky: EarthSky::around(ephemeris, planet, near, 2.0 * STEP_S)?, radii };
        let middle = over_days.sky.instant(time_of_minimum(-STEP_S, STEP_S, |s| over_days.separation_rad(s)));
        Ok(Self { sky: EarthSky::around(ephemeris, planet, middle, HALF_SPAN_S)?, radii })
    }

    /// Angle between the centres.
    fn separation_rad(&self, s: f64) -> f64 {
        angle_rad(self.sky.sun_km(s), self.sky.near_body_km(s))
    }

    /// Angular radii of the Sun and the planet, radians.
    fn angular_radii_rad(&self, s: f64) -> (f64, f64) {
        let radius = |radius_km: f64, distance_km: f64| (radius_km / distance_km).asin();
        (
            radius(self.radii.sun_radius_km, self.sky.sun_km(s).length()),
            radius(self.radii.moon_radius_km, self.sky.near_body_km(s).length()),
        )
    }

    /// The transit; `None` if the planet misses the Sun, as seen from the Earth's centre.
    fn transit(self, planet: NaifId) -> Option<Transit> {
        // Angles from external and from internal tangency of the discs: the first is negative if they overlap, the second if the planet is entirely on the Sun.
        let outer_gap_rad = |s: f64| {
            let (sun_rad, planet_rad) = self.angular_radii_rad(s);
            self.separation_rad(s) - sun_rad - planet_rad
        };
        let inner_gap_rad = |s: f64| {
            let (sun_rad, planet_rad) = self.angular_radii_rad(s);
            self.separation_rad(s) - sun_rad + planet_rad
        };
        let greatest_s = time_of_minimum(-HALF_SPAN_S, HALF_SPAN_S, |s| self.separation_rad(s));
        if outer_gap_rad(greatest_s) >= 0.0 {
            return None;
        }
        // The contact between the greatest phase and an instant before or after the transit.
        let contact = |outside_s: f64, gap_rad: &dyn Fn(f64) -> f64| self.sky.instant(zero_crossing(greatest_s, outside_s, gap_rad));
        let mut contacts = vec![("I", contact(-HALF_SPAN_S, &outer_gap_rad)), ("IV", contact(HALF_SPAN_S, &outer_gap_rad))];
        if inner_gap_rad(greatest_s) < 0.0 {
            // Between I and IV.
            contacts.splice(1..1, [("II", contact(-HALF_SPAN_S, &inner_gap_rad)), ("III", contact(HALF_SPAN_S, &inner_gap_rad))]);
        }
        let (sun_rad, planet_rad) = self.angular_radii_rad(greatest_s);
        // Positive if the planet is north of the Sun's centre.
        let northward = self.sky.near_body_km(greatest_s).normalize_or_zero().z - self.sky.sun_km(greatest_s).normalize_or_zero().z;
        Some(Transit {
            planet,
            greatest: self.sky.instant(greatest_s),
            separation_arcsec: self.separation_rad(greatest_s) / RAD_PER_ARCSEC,
            gamma: (self.separation_rad(greatest_s) / sun_rad).copysign(northward),
            // Half of the covered part of the diameter, which is at most the planet's radius, over the Sun's radius.
            magnitude: (-outer_gap_rad(greatest_s) / 2.0).min(planet_rad) / sun_rad,
            contacts,
            conjunction: self,
            greatest_s,
        })
    }
}
