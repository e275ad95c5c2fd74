//! Local circumstances of an eclipse: contacts, magnitude, altitudes, rising and setting.
//!
//! In: a place, and the positions of the bodies during the eclipse. Out: circumstances, or none if the discs never overlap. Times as numbers are seconds from
//! the middle of the span of [`EarthSky`]. Contacts are those of the mean limbs (the Moon as a sphere); altitudes are without refraction; the Sun or the Moon
//! rises and sets with its upper limb, with the conventional refraction of 34 arcmin.

use super::numeric::{time_of_minimum, zero_crossing};
use super::sky::{BodyRadii, EarthSky};
use crate::ephemeris::angle_rad;
use crate::ephemeris::topocentric::{HORIZON_REFRACTION_DEG, ground_point_km, place_of_normal_deg};
use crate::time::Instant;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const HORIZON_REFRACTION_RAD: f64 = HORIZON_REFRACTION_DEG * PI / 180.0;
/// The maximum is searched up to this far from the given instant, and contacts up to this far from the maximum. At a place, a solar eclipse lasts at most 3.6
/// hours, a transit 8.
const SEARCH_S: f64 = 4.5 * 3600.0;
/// Step in the search for the maximum, and for rising and setting.
const SEARCH_STEP_S: f64 = 120.0;
/// At a place beside a path of totality or annularity, the least separation of the discs is searched up to this far from the instant at which the shadow's axis
/// is at the closest place on the path's centre line. In this span the separation has only one minimum: in an extreme case, 20 degrees from the path of
/// 1529-11-11, it is 52 minutes from that instant.
const NEAR_PATH_SEARCH_S: f64 = 5400.0;

/// A place on the Earth, in geodetic coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodeticPosition {
    /// Geodetic latitude.
    pub latitude_deg: f64,
    /// East longitude.
    pub longitude_deg: f64,
    /// Height above the ellipsoid.
    pub height_km: f64,
}

impl GeodeticPosition {
    /// The place at a point of the spheroid's surface, ITRS. `earth_radii_km`: the spheroid's semi-axes.
    pub(super) fn of_surface_point(point_km: DVec3, earth_radii_km: DVec3) -> Self {
        let [latitude_deg, longitude_deg] = place_of_normal_deg(earth_radii_km, point_km / (earth_radii_km * earth_radii_km));
        Self { latitude_deg, longitude_deg, height_km: 0.0 }
    }
}

/// A contact or the maximum of an eclipse, with the position in the sky of the eclipsed body: the Sun, or the Moon in a lunar eclipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalContact {
    /// As in [`LocalCircumstances::contacts`], or `maximum`.
    pub name: &'static str,
    /// When an observer at the place sees it, after the light time.
    pub time: Instant,
    /// Altitude of the eclipsed body's centre, without refraction.
    pub altitude_deg: f64,
    /// Azimuth from north through east.
    pub azimuth_deg: f64,
    /// Angular radius of the eclipsed body as seen from the place.
    pub semidiameter_deg: f64,
}

impl LocalContact {
    /// Whether the disc's upper limb is at or above the horizon, with refraction. The instant of rising or setting, which may be the maximum, counts as up.
    pub fn is_up(&self) -> bool {
        (self.altitude_deg + self.semidiameter_deg).to_radians() + HORIZON_REFRACTION_RAD > -HORIZON_TOLERANCE_RAD
    }
}

/// An altitude this far below the horizon still counts as at the horizon. Risings and settings are found to 1e-4 s, in which altitudes change by up to 1e-8
/// radians.
const HORIZON_TOLERANCE_RAD: f64 = 1e-7;

/// Local circumstances of an eclipse.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalCircumstances {
    /// Whether any part of the eclipse is above the horizon. If not, the fields `maximum` to `obscuration` are those without a horizon.
    pub is_visible: bool,
    /// In order of time, also those below the horizon: C1 to C4 of a solar eclipse, I to IV of a transit, or P1, U1 to U4 and P4 of a lunar eclipse.
    pub contacts: Vec<LocalContact>,
    /// The maximum above the horizon; if the eclipse is not visible, the geometric maximum.
    pub maximum: LocalContact,
    /// Part of the Sun's diameter that is covered at maximum; if one disc lies within the other, the Moon's diameter over the Sun's. In a lunar
    /// eclipse the part of the Moon's diameter inside the umbra, or inside the penumbra if the eclipse is penumbral; negative outside. The magnitude of a lunar
    /// eclipse differs between places only because the Moon may be above the horizon only before or after the greatest eclipse.
    pub magnitude: f64,
    /// Part of the Moon's diameter inside the penumbra at maximum; `None` for a solar eclipse.
    pub penumbral_magnitude: Option<f64>,
    /// Part of the Sun's disc that is covered at maximum; `None` for a lunar eclipse.
    pub obscuration: Option<f64>,
    /// First rising of the eclipsed body between first and last contact; `None` if it does not rise then.
    pub rise: Option<Instant>,
    /// First setting of the eclipsed body between first and last contact; `None` if it does not set then.
    pub set: Option<Instant>,
    /// Seconds from second to third contact: the duration of totality or annularity, or of the time in which the planet is entirely on the
    /// Sun's disc; `None` if neither disc lies within the other, and for a lunar eclipse.
    pub central_duration_s: Option<f64>,
}

/// Angular radii and separation of the discs of the Sun and the Moon (in a transit: the planet) as seen from a place, radians. Almanacs use two radii of the
/// Moon: a smaller one for totality and annularity (umbra), a larger one for the partial phase (penumbra).
#[derive(Clone, Copy, Debug)]
pub(super) struct Discs {
    /// The Sun's radius.
    pub sun_radius_rad: f64,
    /// The Moon's radius for the umbra.
    pub moon_radius_rad: f64,
    /// The Moon's radius for the penumbra.
    penumbral_moon_radius_rad: f64,
    /// Angle between the centres.
    separation_rad: f64,
}

impl Discs {
    /// Angle between the limbs, negative if the discs overlap: the separation of the centres less that at external tangency.
    fn limb_gap_rad(&self) -> f64 {
        self.separation_rad - self.sun_radius_rad - self.penumbral_moon_radius_rad
    }

    /// Separation of the centres less that at internal tangency; negative if one disc lies within the other.
    pub(crate) fn angle_from_internal_tangency_rad(&self) -> f64 {
        self.separation_rad - (self.sun_radius_rad - self.moon_radius_rad).abs()
    }

    /// The covered part of the Sun's diameter while neither disc lies within the other: (L1 - m) / (L1 + L2) in Besselian notation, here as angles. L1 is the
    /// Sun's radius plus the Moon's for the penumbra, L2 the Sun's less the Moon's for the umbra, m the separation. The result is 1 when the Moon just covers
    /// the Sun, and exceeds 1 when the Moon covers more.
    pub(crate) fn covered_diameter(&self) -> f64 {
        -self.limb_gap_rad() / (2.0 * self.sun_radius_rad + self.penumbral_moon_radius_rad - self.moon_radius_rad)
    }

    /// The Moon's angular radius over the Sun's.
    pub(crate) fn radius_ratio(&self) -> f64 {
        self.moon_radius_rad / self.sun_radius_rad
    }

    /// The part of the Sun's diameter that is covered. If one disc lies within the other, the ratio of their radii.
    fn magnitude(&self) -> f64 {
        if self.angle_from_internal_tangency_rad() < 0.0 { self.radius_ratio() } else { self.covered_diameter() }
    }

    /// The part of the area of the Sun's disc that is covered.
    fn obscuration(&self) -> f64 {
        // Separation and the Moon's radius in units of the Sun's radius.
        let (d, r) = (self.separation_rad / self.sun_radius_rad, self.moon_radius_rad / self.sun_radius_rad);
        if d >= 1.0 + r {
            return 0.0;
        }
        if d <= (1.0 - r).abs() {
            return (r * r).min(1.0);
        }
        // The covered area consists of two circular segments; their half angles at the centres of the discs:
        let at_sun = ((d * d + 1.0 - r * r) / (2.0 * d)).clamp(-1.0, 1.0).acos();
        let at_moon = ((d * d + r * r - 1.0) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
        (at_sun - at_sun.sin() * at_sun.cos() + r * r * (at_moon - at_moon.sin() * at_moon.cos())) / PI
    }
}

/// Instants at which the mean limbs touch, seconds as in [`EarthSky`].
#[derive(Clone, Copy, Debug)]
pub(super) struct MeanContacts {
    /// When the separation is least.
    pub maximum_s: f64,
    /// First and last contact.
    pub outer: (f64, f64),
    /// Second and third contact; `None` if neither disc comes to lie within the other.
    pub inner: Option<(f64, f64)>,
    /// Whether the Moon's disc is smaller than the Sun's at the maximum; of interest only with `inner` contacts.
    pub is_annular: bool,
}

/// The body whose eclipse is seen: the Sun, also in a transit, or the Moon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Eclipsed {
    Sun,
    Moon,
}

/// An observer's place on the Earth during an eclipse.
pub(super) struct Station<'a> {
    sky: &'a EarthSky,
    radii: BodyRadii,
    /// The place, ITRS.
    point_km: DVec3,
    /// Unit vector to the geodetic zenith, ITRS.
    normal: DVec3,
}

impl<'a> Station<'a> {
    pub(crate) fn new(sky: &'a EarthSky, radii: BodyRadii, place: GeodeticPosition) -> Self {
        let (point_km, normal) = ground_point_km(radii.earth_radii_km, place.latitude_deg, place.longitude_deg, place.height_km);
        Self { sky, radii, point_km, normal }
    }

    /// The discs as seen from the place.
    pub(crate) fn discs(&self, s: f64) -> Discs {
        let (sun, moon) = self.sun_and_moon_km(s);
        let radius = |radius_km: f64, offset: DVec3| (radius_km / offset.length()).min(1.0).asin();
        Discs {
            sun_radius_rad: radius(self.radii.sun_radius_km, sun),
            moon_radius_rad: radius(self.radii.moon_radius_km, moon),
            penumbral_moon_radius_rad: radius(self.radii.penumbral_moon_radius_km, moon),
            separation_rad: angle_rad(sun, moon),
        }
    }

    /// Vectors from the place to the Sun and the Moon, GCRS.
    pub(crate) fn sun_and_moon_km(&self, s: f64) -> (DVec3, DVec3) {
        let point_km = self.sky.itrs_from_gcrs(s).transpose() * self.point_km;
        (self.sky.sun_km(s) - point_km, self.sky.near_body_km(s) - point_km)
    }

    pub(crate) fn instant(&self, s: f64) -> Instant {
        self.sky.instant(s)
    }

    pub(crate) fn radii(&self) -> BodyRadii {
        self.radii
    }

    /// Altitude and azimuth, radians, of a body at `body_km` from the Earth's centre, GCRS.
    fn altitude_azimuth_rad(&self, body_km: DVec3, s: f64) -> (f64, f64) {
        let from_station_km = self.sky.itrs_from_gcrs(s) * body_km - self.point_km;
        // At a pole, east and north are those of the meridian 0.
        let east = DVec3::Z.cross(self.normal).try_normalize().unwrap_or(DVec3::Y);
        let north = self.normal.cross(east);
        let (east_km, north_km) = (from_station_km.dot(east), from_station_km.dot(north));
        let altitude_rad = from_station_km.dot(self.normal).atan2(east_km.hypot(north_km));
        let azimuth_rad = east_km.atan2(north_km).rem_euclid(TAU);
        (altitude_rad, azimuth_rad)
    }

    /// The contact at `s`, with altitude, azimuth and semidiameter of the eclipsed body.
    fn contact(&self, name: &'static str, s: f64, eclipsed: Eclipsed) -> LocalContact {
        let (altitude, azimuth) = self.altitude_azimuth_rad(self.eclipsed_body_km(eclipsed, s), s);
        LocalContact {
            name,
            time: self.sky.instant(s),
            altitude_deg: altitude.to_degrees(),
            azimuth_deg: azimuth.to_degrees(),
            semidiameter_deg: self.semidiameter_rad(eclipsed, s).to_degrees(),
        }
    }

    /// Position of the eclipsed body from the Earth's centre, GCRS.
    fn eclipsed_body_km(&self, eclipsed: Eclipsed, s: f64) -> DVec3 {
        match eclipsed {
            Eclipsed::Sun => self.sky.sun_km(s),
            Eclipsed::Moon => self.sky.near_body_km(s),
        }
    }

    /// Angular radius of the eclipsed body.
    fn semidiameter_rad(&self, eclipsed: Eclipsed, s: f64) -> f64 {
        let discs = self.discs(s);
        match eclipsed {
            Eclipsed::Sun => discs.sun_radius_rad,
            Eclipsed::Moon => discs.moon_radius_rad,
        }
    }

    /// Altitude of the Sun, degrees.
    pub(crate) fn sun_altitude_deg(&self, s: f64) -> f64 {
        let (altitude_rad, _azimuth_rad) = self.altitude_azimuth_rad(self.sky.sun_km(s), s);
        altitude_rad.to_degrees()
    }

    /// When the discs are nearest to each other, searched around `near_s`.
    fn instant_of_maximum(&self, near_s: f64) -> f64 {
        let steps = (2.0 * SEARCH_S / SEARCH_STEP_S) as i32;
        let sample_s = |i: i32| near_s - SEARCH_S + f64::from(i) * SEARCH_STEP_S;
        let separation = |s: f64| self.discs(s).separation_rad;
        let nearest = (0..=steps).min_by(|a, b| separation(sample_s(*a)).total_cmp(&separation(sample_s(*b)))).unwrap_or(0);
        time_of_minimum(sample_s(nearest) - SEARCH_STEP_S, sample_s(nearest) + SEARCH_STEP_S, separation)
    }

    /// Second and third contact around the least separation; `None` if neither disc comes to lie within the other.
    pub(crate) fn inner_contacts(&self, near_s: f64) -> Option<(f64, f64)> {
        let maximum_s = self.instant_of_maximum(near_s);
        let gap_rad = |s: f64| self.discs(s).angle_from_internal_tangency_rad();
        // Each contact is between the maximum, where the gap is negative, and the end of the search.
        (gap_rad(maximum_s) < 0.0)
            .then(|| (zero_crossing(maximum_s, maximum_s - SEARCH_S, gap_rad), zero_crossing(maximum_s, maximum_s + SEARCH_S, gap_rad)))
    }

    /// The instant of the least separation, searched within [`NEAR_PATH_SEARCH_S`] of `near_s`; `None` if neither disc lies within the other then.
    pub(crate) fn total_or_annular_instant_near(&self, near_s: f64) -> Option<f64> {
        let maximum_s = time_of_minimum(near_s - NEAR_PATH_SEARCH_S, near_s + NEAR_PATH_SEARCH_S, |s| self.discs(s).separation_rad);
        (self.discs(maximum_s).angle_from_internal_tangency_rad() < 0.0).then_some(maximum_s)
    }

    /// Contacts of the mean limbs around the least separation, which is searched around `near_s`; `None` if the discs never meet.
    pub(crate) fn mean_contacts(&self, near_s: f64) -> Option<MeanContacts> {
        let maximum_s = self.instant_of_maximum(near_s);
        let limb_gap_rad = |s: f64| self.discs(s).limb_gap_rad();
        (limb_gap_rad(maximum_s) < 0.0).then(|| {
            let discs = self.discs(maximum_s);
            let outer = (
                zero_crossing(maximum_s, maximum_s - SEARCH_S, limb_gap_rad),
                zero_crossing(maximum_s, maximum_s + SEARCH_S, limb_gap_rad),
            );
            MeanContacts { maximum_s, outer, inner: self.inner_contacts(near_s), is_annular: discs.moon_radius_rad < discs.sun_radius_rad }
        })
    }

    /// Circumstances at the place of an eclipse of the Sun, or of a transit, that is greatest near `near_s`; `None` if the discs never meet.
    /// `contact_names`: those of the first to the fourth contact.
    pub(crate) fn solar_circumstances(&self, near_s: f64, contact_names: [&'static str; 4]) -> Option<LocalCircumstances> {
        let MeanContacts { maximum_s, outer: (first, last), inner, .. } = self.mean_contacts(near_s)?;
        let sun = Eclipsed::Sun;
        let [first_name, second_name, third_name, fourth_name] = contact_names;
        let mut contacts = vec![self.contact(first_name, first, sun), self.contact(fourth_name, last, sun)];
        if let Some((second, third)) = inner {
            let between = 1..1;
            contacts.splice(between, [self.contact(second_name, second, sun), self.contact(third_name, third, sun)]);
        }
        let above_horizon = self.above_horizon(first, last, sun);
        let magnitude = |s: f64| self.discs(s).magnitude();
        // The separation decreases until the maximum and increases after it. So if the maximum is below the horizon, the largest visible magnitude is at a
        // rising or a setting.
        let visible_maximum_s = above_horizon.instant_of_largest_magnitude(maximum_s, magnitude);
        Some(LocalCircumstances {
            is_visible: visible_maximum_s.is_some(),
            contacts,
            maximum: self.contact("maximum", visible_maximum_s.unwrap_or(maximum_s), sun),
            magnitude: magnitude(visible_maximum_s.unwrap_or(maximum_s)),
            penumbral_magnitude: None,
            obscuration: Some(self.discs(visible_maximum_s.unwrap_or(maximum_s)).obscuration()),
            rise: above_horizon.rise_s.map(|s| self.sky.instant(s)),
            set: above_horizon.set_s.map(|s| self.sky.instant(s)),
            central_duration_s: inner.map(|(second, third)| third - second),
        })
    }

    /// Circumstances at the place of an eclipse of the Moon with these contacts (name, seconds), greatest at `greatest_s`.
    /// `magnitude` and `penumbral_magnitude`: those of [`LocalCircumstances`], as functions of time.
    pub(crate) fn lunar_circumstances(
        &self,
        contacts: &[(&'static str, f64)],
        greatest_s: f64,
        magnitude: impl Fn(f64) -> f64,
        penumbral_magnitude: impl Fn(f64) -> f64,
    ) -> LocalCircumstances {
        let moon = Eclipsed::Moon;
        let (first, last) = contacts.iter().fold((greatest_s, greatest_s), |(first, last), (_, s)| (first.min(*s), last.max(*s)));
        let above_horizon = self.above_horizon(first, last, moon);
        let visible_maximum_s = above_horizon.instant_of_largest_magnitude(greatest_s, &magnitude);
        LocalCircumstances {
            is_visible: visible_maximum_s.is_some(),
            contacts: contacts.iter().map(|(name, s)| self.contact(name, *s, moon)).collect(),
            maximum: self.contact("maximum", visible_maximum_s.unwrap_or(greatest_s), moon),
            magnitude: magnitude(visible_maximum_s.unwrap_or(greatest_s)),
            penumbral_magnitude: Some(penumbral_magnitude(visible_maximum_s.unwrap_or(greatest_s))),
            obscuration: None,
            rise: above_horizon.rise_s.map(|s| self.sky.instant(s)),
            set: above_horizon.set_s.map(|s| self.sky.instant(s)),
            central_duration_s: None,
        }
    }

    /// When the upper limb of the eclipsed body is above the horizon between `first` and `last`.
    fn above_horizon(&self, first: f64, last: f64, eclipsed: Eclipsed) -> AboveHorizon {
        let refracted_upper_limb_rad = |s: f64| {
            let (altitude, _) = self.altitude_azimuth_rad(self.eclipsed_body_km(eclipsed, s), s);
            altitude + HORIZON_REFRACTION_RAD + self.semidiameter_rad(eclipsed, s)
        };
        let mut above_horizon = AboveHorizon { spans: Vec::new(), rise_s: None, set_s: None };
        let mut up_since = (refracted_upper_limb_rad(first) > 0.0).then_some(first);
        let mut current = first;
        while current < last {
            let next = (current + SEARCH_STEP_S).min(last);
            match (refracted_upper_limb_rad(current) > 0.0, refracted_upper_limb_rad(next) > 0.0) {
                (false, true) => {
                    let s = zero_crossing(current, next, refracted_upper_limb_rad);
                    above_horizon.rise_s = above_horizon.rise_s.or(Some(s));
                    up_since = Some(s);
                }
                (true, false) => {
                    // `zero_crossing` expects a negative value at `current`.
                    let s = zero_crossing(current, next, |s| -refracted_upper_limb_rad(s));
                    above_horizon.set_s = above_horizon.set_s.or(Some(s));
                    above_horizon.spans.extend(up_since.take().map(|from| (from, s)));
                }
                _ => {}
            }
            current = next;
        }
        above_horizon.spans.extend(up_since.map(|from| (from, last)));
        above_horizon
    }
}

/// The spans in which a body is above the horizon, and its first rising and setting, if any, between two instants.
struct AboveHorizon {
    /// Each from rising (or the first instant) to setting (or the last), in seconds.
    spans: Vec<(f64, f64)>,
    rise_s: Option<f64>,
    set_s: Option<f64>,
}

impl AboveHorizon {
    /// The instant of the largest magnitude while the body is above the horizon; `None` if it never is. `maximum_s`: the instant of the largest magnitude
    /// regardless of the horizon.
    fn instant_of_largest_magnitude(&self, maximum_s: f64, magnitude: impl Fn(f64) -> f64) -> Option<f64> {
        let nearest = self.spans.iter().map(|(from, to)| maximum_s.clamp(*from, *to));
        nearest.max_by(|a, b| magnitude(*a).total_cmp(&magnitude(*b)))
    }
}
