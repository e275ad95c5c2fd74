//! Transits of Mercury and Venus before the Sun, as the Earth's centre sees them.
//!
//! In: a span of time. Out: least distance of the centres and the four contacts of the mean limbs. The planet stands where the light passed it, the Sun
//! where it left. Not here: the parallax of a place (up to 7 minutes for Venus), the black drop.

use super::contacts::{Contact, seconds_between};
use super::fitted::FittedPlace;
use super::numeric::{end_of_negative, least_instant};
use super::sky::seen_from_earth_km;
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::{Ephemeris, EphemerisError, angle_rad};
use crate::time::Instant;
use crate::units::RAD_PER_ARCSEC;

/// The planets between the Earth and the Sun.
const INNER: [NaifId; 2] = [NaifId(199), NaifId(299)];
/// Between samples of the elongation: an inferior conjunction of either planet takes more than a week.
const STEP_S: f64 = 2.0 * 86_400.0;
/// A transit takes 8 hours at most.
const HALF_S: f64 = 6.0 * 3600.0;

/// A transit of an inner planet.
#[derive(Clone, Debug)]
pub struct Transit {
    pub planet: NaifId,
    /// When the centres are nearest, as the Earth's centre receives the light, like the contacts.
    pub greatest: Instant,
    pub separation_arcsec: f64,
    /// Distance of the centres over the Sun's radius, positive where the planet passes north of the Sun's centre (celestial north).
    pub gamma: f64,
    /// The planet's diameter over the Sun's; less where the planet is not wholly before the Sun.
    pub magnitude: f64,
    /// I to IV; II and III are missing where the planet is never wholly before the Sun.
    pub contacts: Vec<Contact>,
}

impl Transit {
    /// From first to fourth contact.
    pub fn duration_s(&self) -> Option<f64> {
        seconds_between(&self.contacts, "I", "IV")
    }
}

/// Transits that are greatest from `from` to before `to`, planet by planet.
///
/// # Errors
/// The catalog lacks a body, or the theories do not reach the span.
pub fn transits(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<Transit>, EphemerisError> {
    let radius_km = |id: NaifId| {
        let body = catalog.body(id).ok_or_else(|| EphemerisError(format!("the catalog has no body {}: transits need it", id.0)))?;
        Ok::<_, EphemerisError>(body.radii_km.x)
    };
    let sun_km = radius_km(NaifId::SUN)?;
    let mut found = Vec::new();
    for planet in INNER {
        let planet_km = radius_km(planet)?;
        // Distance of the centres by direction alone; behind the Sun counts as far.
        let elongation = |t: Instant| -> Result<f64, EphemerisError> {
            let (sun, near) = (seen_from_earth_km(ephemeris, NaifId::SUN, t)?, seen_from_earth_km(ephemeris, planet, t)?);
            Ok(if near.length() < sun.length() { angle_rad(sun, near) } else { std::f64::consts::PI })
        };
        let steps = ((to.tdb_seconds_past_j2000() - from.tdb_seconds_past_j2000()) / STEP_S).ceil() as i64 + 1;
        let at = |i: i64| from.plus_seconds(i as f64 * STEP_S);
        let (mut before, mut here) = (elongation(at(-1))?, elongation(at(0))?);
        for i in 0..=steps {
            let after = elongation(at(i + 1))?;
            if here <= before && here < after && here < NEAR {
                let passage = Passage::around(ephemeris, planet, at(i), [sun_km, planet_km])?;
                found.extend(passage.transit(planet).filter(|t| (from..to).contains(&t.greatest)));
            }
            (before, here) = (here, after);
        }
    }
    Ok(found)
}

/// Within a step of a transit the planet is nearer to the Sun than this, radians: 1.9 degrees a day are the most.
const NEAR: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The discs of the Sun and a planet for some hours.
struct Passage {
    middle: Instant,
    sun: FittedPlace,
    planet: FittedPlace,
    radii_km: [f64; 2],
}

impl Passage {
    fn around(ephemeris: &Ephemeris, planet: NaifId, near: Instant, radii_km: [f64; 2]) -> Result<Self, EphemerisError> {
        // Over four days first, to find the middle; then over the hours of a transit.
        let wide = Self::fit(ephemeris, planet, near, 2.0 * STEP_S, radii_km)?;
        let s = least_instant(-STEP_S, STEP_S, |s| wide.separation(s));
        Self::fit(ephemeris, planet, near.plus_seconds(s), HALF_S, radii_km)
    }

    fn fit(ephemeris: &Ephemeris, planet: NaifId, middle: Instant, half_s: f64, radii_km: [f64; 2]) -> Result<Self, EphemerisError> {
        let fit = |body| FittedPlace::over(half_s, |s| seen_from_earth_km(ephemeris, body, middle.plus_seconds(s)));
        Ok(Self { middle, sun: fit(NaifId::SUN)?, planet: fit(planet)?, radii_km })
    }

    fn separation(&self, s: f64) -> f64 {
        angle_rad(self.sun.at(s), self.planet.at(s))
    }

    /// Angular radii.
    fn discs(&self, s: f64) -> (f64, f64) {
        ((self.radii_km[0] / self.sun.at(s).length()).asin(), (self.radii_km[1] / self.planet.at(s).length()).asin())
    }

    fn transit(&self, planet: NaifId) -> Option<Transit> {
        let separation = |s: f64| self.separation(s);
        let outer = |s: f64| separation(s) - self.discs(s).0 - self.discs(s).1;
        let inner = |s: f64| separation(s) - self.discs(s).0 + self.discs(s).1;
        let greatest_s = least_instant(-HALF_S, HALF_S, separation);
        if outer(greatest_s) >= 0.0 {
            return None;
        }
        let end = |sign: f64, f: &dyn Fn(f64) -> f64| self.middle.plus_seconds(end_of_negative(greatest_s, sign * HALF_S, f));
        let mut contacts = vec![("I", end(-1.0, &outer)), ("IV", end(1.0, &outer))];
        if inner(greatest_s) < 0.0 {
            contacts.splice(1..1, [("II", end(-1.0, &inner)), ("III", end(1.0, &inner))]);
        }
        let (sun_radius, planet_radius) = self.discs(greatest_s);
        let (sun, seen) = (self.sun.at(greatest_s), self.planet.at(greatest_s));
        let north = seen.normalize_or_zero().z - sun.normalize_or_zero().z;
        Some(Transit {
            planet,
            greatest: self.middle.plus_seconds(greatest_s),
            separation_arcsec: separation(greatest_s) / RAD_PER_ARCSEC,
            gamma: (separation(greatest_s) / sun_radius).copysign(north),
            magnitude: (-outer(greatest_s) / 2.0).min(planet_radius) / sun_radius,
            contacts,
        })
    }
}
