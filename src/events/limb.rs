//! Contacts of a solar eclipse at the Moon's true limb, with its mountains and valleys.
//!
//! In: an eclipse, a place, the ephemeris for the Moon's libration and a map of its heights. Out: the contacts of the Sun's disc and the Moon's true
//! silhouette, from the first (C1) to the fourth (C4). Each has an instant, a position on the limb, and a delay after the contact of the mean limb (the Moon as
//! a sphere). In a total eclipse, the last of Baily's beads goes out at C2 and the first one shines at C3. In an annular eclipse, the last mountain
//! leaves the Sun's limb at C2 and the first one reaches it at C3. Always: the silhouette is a [`LimbProfile`], computed for the instant of each contact. If
//! the Sun shines through a valley even at maximum, there is no C2 and no C3. Not included: refraction and the Sun's irregular limb. Magnitude and obscuration
//! remain those of the mean limb.

use super::local::{GeodeticPosition, Station};
use super::numeric::zero_crossing;
use super::solar::SolarEclipse;
use crate::catalog::NaifId;
use crate::catalog::lunar_heights::HeightMap;
use crate::ephemeris::limb_profile::{LIMB_POINTS, LimbProfile};
use crate::ephemeris::{Ephemeris, EphemerisError, angle_rad};
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// Contacts are searched this far from those of the mean limb: the Moon moves by a third of an arcsecond a second, and its heights are under seven
/// arcseconds.
const SEARCH_S: f64 = 90.0;
/// Step of the search; every visible bead lasts longer.
const STEP_S: f64 = 0.25;

/// A contact of the Moon's silhouette with the Sun's limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbContact {
    /// C1 to C4.
    pub name: &'static str,
    /// When it is seen from the place.
    pub time: Instant,
    /// Seconds after the contact of the mean limb; negative if earlier.
    pub delay_s: f64,
    /// Position angle of the contact on the limb, from celestial north (ICRF) through east.
    pub position_angle_deg: f64,
    /// Height of the silhouette at the contact, above the reference sphere of the map of heights.
    pub height_km: f64,
}

/// A condition on the silhouette that becomes true or false at a contact.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ContactCondition {
    /// Some point of the silhouette lies on the Sun: outer contacts, and the inner contacts of a total eclipse.
    AnyPointOnSun,
    /// The entire silhouette lies on the Sun: the inner contacts of an annular eclipse.
    AllPointsOnSun,
}

/// The Moon's silhouette as seen from a place. The profile of one instant is used for some minutes around it.
struct Silhouette<'a> {
    station: &'a Station<'a>,
    profile: LimbProfile,
    icrf_from_moon: DMat3,
}

impl<'a> Silhouette<'a> {
    /// The silhouette at `s`, seconds from the middle of the span of the station's `EarthSky`.
    fn at(station: &'a Station<'a>, ephemeris: &Ephemeris, map: &HeightMap, s: f64) -> Result<Self, EphemerisError> {
        let (_, moon_km) = station.sun_and_moon_km(s);
        let emitted = station.instant(s).plus_seconds(-moon_km.length() / SPEED_OF_LIGHT_KM_S);
        let moon_from_icrf = ephemeris.body_from_icrf(NaifId::MOON, emitted)?;
        let profile = LimbProfile::seen_from(map, moon_from_icrf * -moon_km);
        Ok(Self { station, profile, icrf_from_moon: moon_from_icrf.transpose() })
    }

    /// Unit vector from the place to point `k` of the silhouette. `moon_km`: vector from the place to the Moon. The point keeps its position angle and its
    /// height while the Moon moves.
    fn direction(&self, k: usize, moon_km: DVec3) -> DVec3 {
        let (distance_km, to_moon) = (moon_km.length(), moon_km.normalize());
        let position_angle_axes =
            self.profile.position_angle_axes().map(|a| self.icrf_from_moon * a).map(|a| (a - to_moon * a.dot(to_moon)).normalize());
        let (sin, cos) = (TAU * k as f64 / LIMB_POINTS as f64).sin_cos();
        let sin_angle = (self.profile.sphere_km() + self.profile.heights_km()[k]) / distance_km;
        (position_angle_axes[0] * cos + position_angle_axes[1] * sin) * sin_angle + to_moon * (1.0 - sin_angle * sin_angle).sqrt()
    }

    /// Angle by which the silhouette's nearest (or, for [`ContactCondition::AllPointsOnSun`], farthest) point lies outside the Sun's disc, and the index of
    /// that point.
    fn angle_outside_sun_rad(&self, condition: ContactCondition, s: f64) -> (f64, usize) {
        let (sun_km, moon_km) = self.station.sun_and_moon_km(s);
        let sun_radius_rad = (self.station.radii().sun_radius_km / sun_km.length()).min(1.0).asin();
        let angles_outside = (0..LIMB_POINTS).map(|k| (angle_rad(self.direction(k, moon_km), sun_km) - sun_radius_rad, k));
        let by_angle = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0);
        let nearest_or_farthest =
            if condition == ContactCondition::AnyPointOnSun { angles_outside.min_by(by_angle) } else { angles_outside.max_by(by_angle) };
        nearest_or_farthest.unwrap_or((f64::INFINITY, 0))
    }

    /// The contact at `s`. `mean_limb_s`: the time of the same contact of the mean limb.
    fn contact(&self, name: &'static str, s: f64, condition: ContactCondition, mean_limb_s: f64) -> LimbContact {
        let (_, k) = self.angle_outside_sun_rad(condition, s);
        let (_, moon_km) = self.station.sun_and_moon_km(s);
        let (to_moon, to_contact) = (moon_km.normalize(), self.direction(k, moon_km));
        let east = DVec3::Z.cross(to_moon).normalize();
        let north = to_moon.cross(east);
        LimbContact {
            name,
            time: self.station.instant(s),
            delay_s: s - mean_limb_s,
            position_angle_deg: to_contact.dot(east).atan2(to_contact.dot(north)).to_degrees().rem_euclid(360.0),
            height_km: self.profile.heights_km()[k],
        }
    }
}

impl SolarEclipse {
    /// Contacts of the Moon's true silhouette, by time; none if the mean limb has none.
    ///
    /// # Errors
    /// The Moon's orientation at that time is unknown.
    pub fn limb_contacts(
        &self,
        place: GeodeticPosition,
        ephemeris: &Ephemeris,
        map: &HeightMap,
    ) -> Result<Vec<LimbContact>, EphemerisError> {
        let station = self.geometry.station(place);
        let Some(mean_limb) = station.mean_contacts(self.geometry.greatest_s) else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        // The first instant, searched from `from_s` to `to_s`, at which `sign` times the angle outside the Sun is no longer negative. The first round uses the
        // silhouette at the contact of the mean limb, the second round the silhouette at the instant that the first one found.
        let find_contact =
            |name, condition, mean_limb_s: f64, [from_s, to_s]: [f64; 2], sign: f64| -> Result<Option<LimbContact>, EphemerisError> {
                let mut silhouette = Silhouette::at(&station, ephemeris, map, mean_limb_s)?;
                let mut contact_s = None;
                for _ in 0..2 {
                    let signed_angle_rad = |s: f64| sign * silhouette.angle_outside_sun_rad(condition, s).0;
                    let step_s = if to_s > from_s { STEP_S } else { -STEP_S };
                    let steps = ((to_s - from_s) / step_s).ceil() as i32;
                    if signed_angle_rad(from_s) >= 0.0 {
                        return Ok(None);
                    }
                    let Some(k) = (1..=steps).find(|k| signed_angle_rad(from_s + step_s * f64::from(*k)) >= 0.0) else { return Ok(None) };
                    let s = zero_crossing(from_s + step_s * f64::from(k - 1), from_s + step_s * f64::from(k), signed_angle_rad);
                    silhouette = Silhouette::at(&station, ephemeris, map, s)?;
                    contact_s = Some(s);
                }
                Ok(contact_s.map(|s| silhouette.contact(name, s, condition, mean_limb_s)))
            };
        let (c1_s, c4_s) = mean_limb.outer;
        // The angle outside the Sun is positive before C1 and after C4.
        found.extend(find_contact("C1", ContactCondition::AnyPointOnSun, c1_s, [c1_s - SEARCH_S, c1_s + SEARCH_S], -1.0)?);
        if let Some((c2_s, c3_s)) = mean_limb.inner {
            // Searched from the middle outwards: totality ends when a point of the silhouette lies on the Sun, annularity when one lies off the Sun.
            let (condition, sign) =
                if mean_limb.is_annular { (ContactCondition::AllPointsOnSun, 1.0) } else { (ContactCondition::AnyPointOnSun, -1.0) };
            let middle_s = 0.5 * (c2_s + c3_s);
            // Where the searches for C2 and C3 start: inside totality or annularity, but not beyond its middle.
            let (c2_start_s, c3_start_s) = ((c2_s + SEARCH_S).min(middle_s), (c3_s - SEARCH_S).max(middle_s));
            let inner = [
                find_contact("C2", condition, c2_s, [c2_start_s, c2_s - SEARCH_S], sign)?,
                find_contact("C3", condition, c3_s, [c3_start_s, c3_s + SEARCH_S], sign)?,
            ];
            found.extend(inner.into_iter().flatten());
        }
        found.extend(find_contact("C4", ContactCondition::AnyPointOnSun, c4_s, [c4_s + SEARCH_S, c4_s - SEARCH_S], -1.0)?);
        Ok(found)
    }
}
