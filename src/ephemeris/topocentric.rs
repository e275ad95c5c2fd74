//! Topocentric phenomena: altitude and azimuth, rising and setting, and transits and occultations of discs.
//!
//! In: a place on a body, a target, an instant. Out: horizontal coordinates in degrees, and the instants of events. Altitudes are without refraction; rising
//! and setting on the Earth include the conventional 34 arcmin of refraction and the semidiameter (Explanatory Supplement, 3rd ed., section 12.1.3). Light
//! time is included.
//! Stellar aberration is left out: it changes altitudes by up to 20 arcsec, hence risings by up to 1.4 s at the equator and by more elsewhere; two
//! neighbouring discs are shifted by nearly the same angle. The horizon is perpendicular to the ellipsoid's normal.

use super::target::Target;
use super::{BEST_SOURCE, Ephemeris, EphemerisError, State, angle_rad};
use crate::catalog::{Catalog, NaifId};
use crate::time::Instant;
use crate::units::INVERSE_GOLDEN_RATIO;
use glam::{DVec2, DVec3};

/// Refraction at the Earth's horizon by the convention of almanacs: 34 arcminutes.
pub(crate) const HORIZON_REFRACTION_DEG: f64 = 34.0 / 60.0;
/// Seconds between samples of altitude and hour angle; a body that is above the horizon for less time may be missed.
const RISE_STEP_S: f64 = 600.0;
/// Seconds between samples of two discs that may overlap.
const CONTACT_STEP_S: f64 = 60.0;
/// Longest time in seconds for which a passage is followed: from the searched span to the greatest obscuration if that is outside the span, and from the
/// greatest obscuration to each contact.
const LONGEST_PASSAGE_S: f64 = 2.0 * crate::units::SECONDS_PER_DAY;
/// Tolerance of roots, seconds.
const ROOT_TOLERANCE_S: f64 = 0.05;

/// A place on the ground of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// The body that the place is on.
    pub body: NaifId,
    /// Planetographic latitude: the angle between the equator and the ellipsoid's normal.
    pub lat_graphic_deg: f64,
    /// Planetocentric east longitude.
    pub lon_east_deg: f64,
    /// Height above the reference ellipsoid.
    pub height_km: f64,
}

/// The position of a target in the sky of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizontal {
    /// Azimuth from north through east, 0 to 360.
    pub azimuth_deg: f64,
    /// Altitude without refraction.
    pub altitude_deg: f64,
    /// Hour angle from the meridian westward, -180 to 180.
    pub hour_angle_deg: f64,
    /// Distance from the observer to the body's centre; infinite for a star.
    pub distance_km: f64,
    /// Angular radius of the disc, from the body's mean radius; 0 for a star, and for a minor planet or comet, whose radius is unknown.
    pub semidiameter_deg: f64,
    /// Direction from the place to the target, ICRF.
    pub direction: DVec3,
}

/// The risings, transits and settings of a target in a span, usually a day. A star, and so a planet, may have two of them in one day, because it returns after
/// 23 h 56 min.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RiseSetTimes {
    /// First rising; `None`: the target does not rise within the span.
    pub rise: Option<Instant>,
    /// First setting; `None`: the target does not set within the span.
    pub set: Option<Instant>,
    /// First upper transit and the target's altitude then, degrees; `None` if there is no transit within the span, as for the Moon on one day of a month.
    pub transit: Option<(Instant, f64)>,
    /// Second rising, if any.
    pub second_rise: Option<Instant>,
    /// Second setting, if any.
    pub second_set: Option<Instant>,
    /// Second upper transit, if any, and the target's altitude then.
    pub second_transit: Option<(Instant, f64)>,
    /// Whether the target is above the horizon at the start of the span.
    pub is_up_at_start: bool,
}

/// A transit or occultation of one disc by another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscPassage {
    /// First contact of the discs; `None` if they overlap already two days before the greatest obscuration.
    pub begins: Option<Instant>,
    /// Last contact of the discs; `None` if they still overlap two days after the greatest obscuration.
    pub ends: Option<Instant>,
    /// Second and third contact, between which the smaller disc is entirely in front of or behind the larger; `None` if it never is, or if either of the two
    /// is more than two days from the greatest obscuration.
    pub inner: Option<(Instant, Instant)>,
    /// The instant of greatest obscuration.
    pub greatest: Instant,
    /// Largest covered fraction of the target's diameter; if one disc lies within the other, the near disc's diameter over the target's.
    pub magnitude: f64,
    /// The target's altitude at the greatest obscuration.
    pub altitude_deg: f64,
}

/// The point at `height_km` above a place of the reference ellipsoid, and the ellipsoid's outward normal there, in body-fixed axes. Definition of
/// a place's latitude and longitude, also on an ellipsoid with three different axes: the planetographic latitude is the angle between the equator and the
/// normal; the longitude is planetocentric, that of the line from the centre to the place, as in the IAU's reports and in maps. On a spheroid the normal has
/// the same longitude.
pub fn ground_point_km(radii_km: DVec3, latitude_deg: f64, longitude_deg: f64, height_km: f64) -> (DVec3, DVec3) {
    let (lat, lon) = (latitude_deg.to_radians(), longitude_deg.to_radians());
    let squared = radii_km * radii_km;
    // Unit vector of the normal's equatorial part. The normal at the position p is parallel to p / squared. Here `squared` is divided by its first component,
    // so that on a spheroid the vector is exactly the direction of the longitude.
    let outward = (DVec2::from_angle(lon) * (squared.x / squared.truncate())).normalize();
    let normal = (outward * lat.cos()).extend(lat.sin());
    // p = k squared normal; k follows from the ellipsoid's equation, p . (p / squared) = 1.
    let surface = squared * normal / (squared * normal).dot(normal).sqrt();
    (surface + normal * height_km, normal)
}

/// Planetographic latitude and planetocentric east longitude, degrees, of the place where the ellipsoid has this outward normal (of any length): the inverse
/// of [`ground_point_km`].
pub fn place_of_normal_deg(radii_km: DVec3, normal: DVec3) -> [f64; 2] {
    // A multiple of the position.
    let position = radii_km * radii_km * normal;
    [normal.z.atan2(normal.truncate().length()), position.y.atan2(position.x)].map(f64::to_degrees)
}

/// The inputs that all computations here share: a place on the ground, and the bodies in its sky.
pub struct ObserverSky<'a> {
    /// The bodies with their radii.
    pub catalog: &'a Catalog,
    /// The positions of the bodies.
    pub ephemeris: &'a Ephemeris,
    /// The observer's place.
    pub place: Observer,
}

impl ObserverSky<'_> {
    /// The position of a target in the sky of the place.
    ///
    /// # Errors
    /// The target is the body that the place is on or a barycentre, one of the two is not in the catalog, or the ephemeris cannot place it at `t`.
    pub fn topocentric<'t>(&self, target: impl Into<Target<'t>>, t: Instant) -> Result<Horizontal, EphemerisError> {
        let target = target.into();
        let catalog_body = |id: NaifId| {
            let unknown = || EphemerisError::other(format!("{} has no disc and no ground: name a body", self.ephemeris.name_of(id)));
            self.catalog.body(id).ok_or_else(unknown)
        };
        let ground = catalog_body(self.place.body)?;
        let radius_km = match target {
            Target::Body(id) => catalog_body(id)?.radii_km.element_sum() / 3.0,
            Target::SmallBody(_) | Target::Direction(_) => 0.0,
        };
        if target == Target::Body(ground.id) {
            return Err(EphemerisError::other(format!("{} has no altitude and azimuth from a place on it", ground.name)));
        }
        let (point, normal) = ground_point_km(ground.radii_km, self.place.lat_graphic_deg, self.place.lon_east_deg, self.place.height_km);
        let icrf_from_body = self.ephemeris.body_from_icrf(ground.id, t)?.transpose();
        let (direction, distance_km) = match target {
            Target::Direction(direction) => (direction, f64::INFINITY),
            Target::Body(_) | Target::SmallBody(_) => {
                let centre_km = self.ephemeris.state(ground.id, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state.pos_km;
                let observer_km = centre_km + icrf_from_body * point;
                let (target_km, _) = self.ephemeris.target_light_time_position(target, observer_km, t)?;
                let to_target = target_km - observer_km;
                let distance_km = to_target.length();
                (to_target / distance_km, distance_km)
            }
        };
        // The direction in the axes of the body that the place is on, like `normal`.
        let in_body = icrf_from_body.transpose() * direction;
        // If the normal is exactly along the polar axis, the body's y axis is taken as east.
        let east = DVec3::Z.cross(normal).try_normalize().unwrap_or(DVec3::Y);
        let north = normal.cross(east);
        let azimuth_deg = in_body.dot(east).atan2(in_body.dot(north)).to_degrees().rem_euclid(360.0);
        // Length of the direction's horizontal part. The altitude is an atan2 with it, because an arc sine is imprecise near the zenith.
        let horizontal_length = in_body.dot(east).hypot(in_body.dot(north));
        Ok(Horizontal {
            azimuth_deg,
            altitude_deg: in_body.dot(normal).atan2(horizontal_length).to_degrees(),
            // The angle in the equatorial plane from the direction to the normal, positive if the target is west of the meridian.
            hour_angle_deg: (normal.y * in_body.x - normal.x * in_body.y).atan2(normal.x * in_body.x + normal.y * in_body.y).to_degrees(),
            distance_km,
            semidiameter_deg: (radius_km / distance_km).min(1.0).asin().to_degrees(),
            direction,
        })
    }

    /// The state of the place relative to the solar system's barycentre, ICRF: it moves with its body and turns with the ground.
    ///
    /// # Errors
    /// The body that the place is on is not in the catalog, or the ephemeris cannot place it at `t`.
    pub fn state(&self, t: Instant) -> Result<State, EphemerisError> {
        let unknown = || EphemerisError::other(format!("{} has no ground", self.ephemeris.name_of(self.place.body)));
        let ground = self.catalog.body(self.place.body).ok_or_else(unknown)?;
        let (point, _) = ground_point_km(ground.radii_km, self.place.lat_graphic_deg, self.place.lon_east_deg, self.place.height_km);
        let from_centre =
            |t: Instant| -> Result<DVec3, EphemerisError> { Ok(self.ephemeris.body_from_icrf(ground.id, t)?.transpose() * point) };
        // The chord over two seconds is shorter than the arc by a part of 1e-9, for the Earth.
        let (before, after) = (from_centre(t.plus_seconds(-1.0))?, from_centre(t.plus_seconds(1.0))?);
        let centre = self.ephemeris.state(ground.id, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state;
        Ok(centre.plus(State { pos_km: from_centre(t)?, vel_km_s: (after - before) / 2.0 }))
    }

    /// Altitude in degrees that is 0 when the target rises or sets: the altitude of a large disc's upper limb, or of a small disc's centre. On the Earth, the
    /// result includes the refraction at the horizon.
    fn rise_set_altitude_deg(&self, target: Target<'_>, t: Instant) -> Result<f64, EphemerisError> {
        let horizontal = self.topocentric(target, t)?;
        let refraction_deg = if self.place.body == NaifId::EARTH { HORIZON_REFRACTION_DEG } else { 0.0 };
        // Almanacs use the upper limb of the Sun and the Moon, and the centre of planets and stars. Here the upper limb counts for every disc of more than
        // 0.05 degrees in semidiameter: of the bodies in the Earth's sky, the Sun and the Moon.
        let limb_deg = if horizontal.semidiameter_deg > 0.05 { horizontal.semidiameter_deg } else { 0.0 };
        Ok(horizontal.altitude_deg + refraction_deg + limb_deg)
    }

    /// Rising, transit and setting in the `length_s` seconds after `start`.
    ///
    /// # Errors
    /// As [`Self::topocentric`].
    pub fn rise_set_times<'t>(&self, target: impl Into<Target<'t>>, start: Instant, length_s: f64) -> Result<RiseSetTimes, EphemerisError> {
        let target = target.into();
        let rise_set_altitude = |s: f64| self.rise_set_altitude_deg(target, start.plus_seconds(s));
        let crossings = all_crossings(length_s, rise_set_altitude)?;
        let horizontal = |s: f64| self.topocentric(target, start.plus_seconds(s));
        // Positive while the target is west of the meridian, which it may pass to either side. Only the upper passage, at an hour angle of 0, is its transit.
        let west_of_meridian = |s: f64| Ok(horizontal(s)?.hour_angle_deg.to_radians().sin());
        let mut transits = Vec::new();
        for crossing in all_crossings(length_s, west_of_meridian)? {
            let at_meridian = horizontal(crossing.s)?;
            if at_meridian.hour_angle_deg.abs() < 90.0 {
                transits.push((start.plus_seconds(crossing.s), at_meridian.altitude_deg));
            }
        }
        let nth = |is_upward: bool, n: usize| crossings.iter().filter(|c| c.is_upward == is_upward).nth(n).map(|c| start.plus_seconds(c.s));
        Ok(RiseSetTimes {
            rise: nth(true, 0),
            set: nth(false, 0),
            transit: transits.first().copied(),
            second_rise: nth(true, 1),
            second_set: nth(false, 1),
            second_transit: transits.get(1).copied(),
            is_up_at_start: rise_set_altitude(0.0)? > 0.0,
        })
    }

    /// When the target's centre, without refraction, first rises above an altitude and first sinks below it, in this order, in the `length_s` seconds after
    /// `start`, as for twilight by the Sun at -6, -12 and -18 degrees; `None` where it does not. A stay of less than ten minutes on one side may be missed.
    ///
    /// # Errors
    /// As [`Self::topocentric`].
    pub fn crossings(
        &self,
        target: NaifId,
        altitude_deg: f64,
        start: Instant,
        length_s: f64,
    ) -> Result<[Option<Instant>; 2], EphemerisError> {
        let altitude_above = |s: f64| Ok(self.topocentric(target, start.plus_seconds(s))?.altitude_deg - altitude_deg);
        let found = all_crossings(length_s, altitude_above)?;
        Ok([true, false].map(|is_upward| found.iter().find(|c| c.is_upward == is_upward).map(|c| start.plus_seconds(c.s))))
    }

    /// The first passage of `occulting` in front of `target` that is at least partly within the `length_s` seconds after `start`, above the horizon or not;
    /// `None` if there is none.
    ///
    /// # Errors
    /// As [`Self::topocentric`].
    pub fn passage(&self, target: NaifId, occulting: NaifId, start: Instant, length_s: f64) -> Result<Option<DiscPassage>, EphemerisError> {
        // Overlap of the discs in degrees; negative if they are apart. -180, less than any overlap, if `occulting` is not in front of `target`.
        let overlap = |s: f64| -> Result<f64, EphemerisError> {
            let t = start.plus_seconds(s);
            let (far, near) = (self.topocentric(target, t)?, self.topocentric(occulting, t)?);
            if near.distance_km >= far.distance_km {
                return Ok(-180.0);
            }
            Ok(far.semidiameter_deg + near.semidiameter_deg - angle_rad(far.direction, near.direction).to_degrees())
        };
        // The almanacs' radius of the Moon is larger for first and last contact than for totality; `outer_overlap` uses the larger one.
        let penumbral_ratio = if occulting == NaifId::MOON { self.catalog.eclipse_radii().penumbral_moon_ratio() } else { 1.0 };
        let outer_overlap = |s: f64| -> Result<f64, EphemerisError> {
            let near = self.topocentric(occulting, start.plus_seconds(s))?;
            Ok(overlap(s)? + near.semidiameter_deg * (penumbral_ratio - 1.0))
        };
        let steps = (length_s / CONTACT_STEP_S).ceil().max(1.0) as usize;
        // Time and overlap of the sample with the largest overlap.
        let mut best: Option<(f64, f64)> = None;
        for i in 0..=steps {
            let s = (i as f64 * CONTACT_STEP_S).min(length_s);
            let sampled = overlap(s)?;
            match best {
                Some((_, largest)) if sampled > largest => best = Some((s, sampled)),
                // The passage is over; later overlaps belong to another one.
                Some((_, largest)) if largest > 0.0 && sampled <= 0.0 => break,
                None => best = Some((s, sampled)),
                _ => {}
            }
        }
        let Some((mut sampled_s, mut largest)) = best else { return Ok(None) };
        // A passage that is in progress at the start or at the end of the span may have its largest overlap outside of it.
        for step in [-CONTACT_STEP_S, CONTACT_STEP_S] {
            while largest > 0.0 && (-LONGEST_PASSAGE_S..=length_s + LONGEST_PASSAGE_S).contains(&sampled_s) {
                let next = overlap(sampled_s + step)?;
                if next <= largest {
                    break;
                }
                (sampled_s, largest) = (sampled_s + step, next);
            }
        }
        // If no sample overlaps, a passage shorter than a step is searched only within the span.
        let limited_to_span = |s: f64| if largest > 0.0 { s } else { s.max(0.0).min(length_s) };
        let (earliest_s, latest_s) = (limited_to_span(sampled_s - CONTACT_STEP_S), limited_to_span(sampled_s + CONTACT_STEP_S));
        let greatest_s = time_of_maximum(earliest_s, latest_s, overlap)?;
        let largest = overlap(greatest_s)?;
        if largest <= 0.0 {
            return Ok(None);
        }
        let t = start.plus_seconds(greatest_s);
        let (far, near) = (self.topocentric(target, t)?, self.topocentric(occulting, t)?);
        // How far the smaller disc lies inside the larger, degrees: 0 at internal tangency, negative if it protrudes.
        let inner_overlap = |s: f64| -> Result<f64, EphemerisError> {
            let t = start.plus_seconds(s);
            Ok(overlap(s)? - 2.0 * self.topocentric(target, t)?.semidiameter_deg.min(self.topocentric(occulting, t)?.semidiameter_deg))
        };
        let instant = |s: f64| start.plus_seconds(s);
        let is_inside = inner_overlap(greatest_s)? > 0.0;
        let inner_s =
            if is_inside { contact_s(greatest_s, BEFORE, inner_overlap)?.zip(contact_s(greatest_s, AFTER, inner_overlap)?) } else { None };
        Ok(Some(DiscPassage {
            begins: contact_s(greatest_s, BEFORE, outer_overlap)?.map(instant),
            ends: contact_s(greatest_s, AFTER, outer_overlap)?.map(instant),
            inner: inner_s.map(|(second_s, third_s)| (instant(second_s), instant(third_s))),
            greatest: t,
            magnitude: if is_inside { near.semidiameter_deg / far.semidiameter_deg } else { largest / (2.0 * far.semidiameter_deg) },
            altitude_deg: far.altitude_deg,
        }))
    }
}

/// A change of sign.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Time from the start of the search, seconds.
    s: f64,
    /// Whether the function becomes positive; otherwise it stops being positive.
    is_upward: bool,
}

/// The times from 0 to `length_s` at which `f` becomes positive or stops being positive, ascending.
fn all_crossings(length_s: f64, f: impl Fn(f64) -> Result<f64, EphemerisError>) -> Result<Vec<Crossing>, EphemerisError> {
    let steps = (length_s / RISE_STEP_S).ceil().max(1.0) as usize;
    let mut found = Vec::new();
    let mut previous = f(0.0)?;
    for i in 1..=steps {
        let (start_s, end_s) = ((i - 1) as f64 * RISE_STEP_S, (i as f64 * RISE_STEP_S).min(length_s));
        let current = f(end_s)?;
        if previous <= 0.0 && current > 0.0 {
            found.push(Crossing { s: root(start_s, end_s, &f)?, is_upward: true });
        }
        if previous > 0.0 && current <= 0.0 {
            found.push(Crossing { s: root(start_s, end_s, |s| Ok(-f(s)?))?, is_upward: false });
        }
        previous = current;
    }
    Ok(found)
}

/// Sign of the search for a contact before the greatest obscuration.
const BEFORE: f64 = -1.0;
/// Sign of the search for a contact after the greatest obscuration.
const AFTER: f64 = 1.0;

/// Time of the contact [`BEFORE`] or [`AFTER`] the greatest obscuration, by `sign`: the root of `overlap`. `None` if the discs still overlap at the end of
/// [`LONGEST_PASSAGE_S`].
fn contact_s(greatest_s: f64, sign: f64, overlap: impl Fn(f64) -> Result<f64, EphemerisError>) -> Result<Option<f64>, EphemerisError> {
    let mut step = CONTACT_STEP_S;
    // The time farthest from the greatest obscuration at which `overlap` was found to be positive.
    let mut inside_s = greatest_s;
    while step <= LONGEST_PASSAGE_S {
        let s = greatest_s + sign * step;
        if overlap(s)? <= 0.0 {
            return root(s, inside_s, &overlap).map(Some);
        }
        inside_s = s;
        step += CONTACT_STEP_S;
    }
    Ok(None)
}

/// The root of `f` between `a`, where `f` is not positive, and `b`, where it is positive; `a` may be later than `b`.
fn root(mut a: f64, mut b: f64, f: impl Fn(f64) -> Result<f64, EphemerisError>) -> Result<f64, EphemerisError> {
    while (b - a).abs() > ROOT_TOLERANCE_S {
        let middle = 0.5 * (a + b);
        if f(middle)? > 0.0 {
            b = middle;
        } else {
            a = middle;
        }
    }
    Ok(0.5 * (a + b))
}

/// The time between `a` and `b` at which `f` is greatest, if it has one peak, by golden-section search.
fn time_of_maximum(mut a: f64, mut b: f64, f: impl Fn(f64) -> Result<f64, EphemerisError>) -> Result<f64, EphemerisError> {
    while b - a > ROOT_TOLERANCE_S {
        let (left, right) = (b - INVERSE_GOLDEN_RATIO * (b - a), a + INVERSE_GOLDEN_RATIO * (b - a));
        if f(left)? > f(right)? {
            b = right;
        } else {
            a = left;
        }
    }
    Ok(0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of the search is no contact. The overlap is positive for `half_duration_s` before and after a greatest obscuration at 500 s. 3600.5 s is not a
    /// multiple of the search's step.
    #[test]
    fn discs_that_overlap_for_more_than_two_days_have_no_contact() {
        for (half_duration_s, has_contact) in [(3600.5, true), (LONGEST_PASSAGE_S - 1.0, true), (LONGEST_PASSAGE_S + 1.0, false)] {
            for sign in [BEFORE, AFTER] {
                let found = contact_s(500.0, sign, |s| Ok(half_duration_s - (s - 500.0).abs())).expect("a time or none");
                assert_eq!(found.is_some(), has_contact, "{half_duration_s} {sign}: {found:?}");
                let error_s = found.map_or(0.0, |s| s - (500.0 + sign * half_duration_s));
                assert!(error_s.abs() <= ROOT_TOLERANCE_S, "{half_duration_s} {sign}: {error_s} s");
            }
        }
    }

    #[test]
    fn ground_points_of_the_earth_agree_with_wgs84() {
        // Paris (48.8584 N, 2.2945 E) by the closed form for WGS84's spheroid: a = 6378.137 km, 1/f = 298.257223563; n is the radius of curvature in the prime
        // vertical.
        let a: f64 = 6378.137;
        let b = a * (1.0 - 1.0 / 298.257_223_563);
        let (lat, lon) = (48.8584_f64.to_radians(), 2.2945_f64.to_radians());
        let n = a * a / ((a * lat.cos()).powi(2) + (b * lat.sin()).powi(2)).sqrt();
        let h = 0.33;
        let expected = DVec3::new((n + h) * lat.cos() * lon.cos(), (n + h) * lat.cos() * lon.sin(), (n * (b / a).powi(2) + h) * lat.sin());
        let (point, normal) = ground_point_km(DVec3::new(a, a, b), 48.8584, 2.2945, h);
        assert!((point - expected).length() < 1e-9);
        assert!((normal.z - lat.sin()).abs() < 1e-12);
    }

    /// On bodies with three different axes a place has the planetocentric longitude, and its normal the planetographic latitude. The longitude of the normal
    /// is another one, which must not pass: the last assertion checks that the two differ by more than 20
    /// degrees somewhere, on Amalthea's ellipsoid.
    #[test]
    fn places_on_triaxial_bodies_have_planetocentric_longitudes() {
        let mut greatest_difference_deg = 0.0_f64;
        // About the radii of Amalthea, of Phobos and of Saturn; the last is a spheroid.
        for radii_km in [DVec3::new(125.0, 73.0, 64.0), DVec3::new(13.0, 11.4, 9.1), DVec3::new(60_268.0, 60_268.0, 54_364.0)] {
            for latitude_deg in [-89.0, -40.0, 0.0, 20.0, 75.0] {
                for longitude_deg in [-179.0, -110.0, -20.0, 0.0, 45.0, 90.0, 133.0] {
                    let (ground_km, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, 0.0);
                    let place = format!("{radii_km}, {latitude_deg}, {longitude_deg}");
                    assert!(((ground_km / radii_km).length() - 1.0).abs() < 1e-12, "{place}: not on the ellipsoid");
                    // The gradient of the ellipsoid's equation.
                    assert!(normal.distance((ground_km / (radii_km * radii_km)).normalize()) < 1e-12, "{place}: not the normal");
                    assert!((normal.z - latitude_deg.to_radians().sin()).abs() < 1e-12, "{place}: not its latitude");
                    let found_deg = ground_km.y.atan2(ground_km.x).to_degrees();
                    assert!((found_deg - longitude_deg).abs() < 1e-10, "{place}: longitude {found_deg}");
                    let [inverse_lat_deg, inverse_lon_deg] = place_of_normal_deg(radii_km, normal * 3.0);
                    assert!((inverse_lat_deg - latitude_deg).abs() + (inverse_lon_deg - longitude_deg).abs() < 1e-10, "{place}");
                    let normal_deg = normal.y.atan2(normal.x).to_degrees();
                    greatest_difference_deg = greatest_difference_deg.max((normal_deg - longitude_deg).abs());
                    // Above the ground the vertical is the normal.
                    let (raised_km, _) = ground_point_km(radii_km, latitude_deg, longitude_deg, 5.0);
                    assert!((raised_km - ground_km).distance(normal * 5.0) < 1e-9, "{place}");
                }
            }
        }
        assert!((20.0..30.0).contains(&greatest_difference_deg), "{greatest_difference_deg}");
    }
}
