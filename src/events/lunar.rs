//! Eclipses of the Moon.
//!
//! In: a full moon, the ephemeris, the catalog's radii. Out: type, greatest eclipse, magnitudes and contacts with the Earth's shadow. Light time is
//! included: sunlight that reaches the Earth from the eclipsed Moon passed the Earth 2.6 s earlier, on its way to the Moon. So the axis of the shadow is
//! opposite to the Sun's apparent position 2.6 s earlier. Almanacs use the Sun's position at the instant itself. Their instants are 0.2 s later: the time in
//! which the Moon gains on the Sun what the Sun moves in 2.6 s.
//!
//! The shadow is that of a sphere with the Earth's equatorial radius. With the IAU's radii it is not enlarged; with those of almanacs it is enlarged by
//! Danjon's rule, a hundredth of the Earth's radius, for the air (Espenak and Meeus 2009, NASA/TP-2009-214172). The enlarged shadow is the one that observers
//! time: the eclipse of 2021-05-26, total for 15 minutes, is partial in the geometric shadow. `eclipse find` keeps the convention of `--radii`; the window
//! takes that of almanacs.

use super::contacts::{Contact, seconds_between};
use super::local::{GeodeticPosition, LocalCircumstances, Station};
use super::lunation::{Phase, Syzygy};
use super::numeric::{time_of_minimum, zero_crossing};
use super::sky::{BodyRadii, EarthSky};
use crate::catalog::{EclipseRadii, NaifId};
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::DVec3;

/// The true full moon is within 15 hours of the mean full moon.
const PHASE_SEARCH_S: f64 = 15.0 * 3600.0;
/// The Moon leaves the penumbra within 3.2 hours of the greatest eclipse.
const SHADOW_SEARCH_S: f64 = 4.0 * 3600.0;
/// Danjon's enlargement of the shadow, in Earth radii: 1/85 for the air, less 1/594, by which the Earth's radius at 45 degrees is smaller than the
/// equatorial one: 0.0101, rounded.
const DANJON_ENLARGEMENT: f64 = 0.01;

/// The type of a lunar eclipse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LunarType {
    Penumbral,
    Partial,
    Total,
}

impl LunarType {
    pub fn name(self) -> &'static str {
        match self {
            Self::Penumbral => "penumbral",
            Self::Partial => "partial",
            Self::Total => "total",
        }
    }
}

/// Name of the rule by which the convention of these radii enlarges the Earth's shadow, to allow for the atmosphere; "geometric": not at all.
pub fn shadow_enlargement(radii: EclipseRadii) -> &'static str {
    match radii {
        EclipseRadii::Iau => "geometric",
        EclipseRadii::Almanac => "danjon",
    }
}

/// An eclipse of the Moon.
#[derive(Clone, Debug)]
pub struct LunarEclipse {
    /// Penumbral, partial or total.
    pub class: LunarType,
    /// When the Moon's centre is nearest to the axis of the shadow. Like the contacts, it is the time at which the light reaches the Earth's centre.
    pub greatest: Instant,
    /// Least distance of the Moon's centre from the axis of the shadow, in the Earth's equatorial radii; positive if the Moon passes north of the axis.
    pub gamma: f64,
    /// Part of the Moon's diameter inside the umbra; negative outside, at least 1 if the Moon is entirely inside.
    pub umbral_magnitude: f64,
    /// The same for the penumbra; always positive.
    pub penumbral_magnitude: f64,
    /// The place where the Moon is in the zenith at greatest eclipse.
    pub place: GeodeticPosition,
    /// P1, U1, U2, U3, U4, P4 by time: the Moon enters the penumbra, enters the umbra, is entirely inside it, and the reverse. Those that do
    /// not occur are missing.
    pub contacts: Vec<Contact>,
    /// Number of the Saros series.
    pub saros: i64,
    /// Number of the eclipse within the series, starting at 1; `None` if the series may have begun before the span of the ephemeris, or
    /// if the search was not to find it.
    pub saros_member: Option<i64>,
    /// Used to compute the circumstances at a place.
    geometry: LunarEclipseGeometry,
}

/// Sky and radii of one eclipse; times are seconds from the mean full moon.
#[derive(Clone, Debug)]
struct LunarEclipseGeometry {
    sky: EarthSky,
    radii: BodyRadii,
    /// Instant of greatest eclipse.
    greatest_s: f64,
}

/// Position of the Moon relative to the shadow, and the shadow's radii at the Moon, km.
struct ShadowAtMoon {
    /// Vector from the axis to the Moon's centre, GCRS.
    offset_from_axis_km: DVec3,
    /// Radius of the umbra.
    umbra_radius_km: f64,
    /// Radius of the penumbra.
    penumbra_radius_km: f64,
}

impl LunarEclipseGeometry {
    /// The Moon's radius in lunar eclipses: the one that solar eclipses use for the penumbra.
    fn eclipsed_moon_radius_km(&self) -> f64 {
        self.radii.penumbral_moon_radius_km
    }

    /// The Moon and the shadow at `s`.
    fn shadow_at_moon(&self, s: f64) -> ShadowAtMoon {
        let moon_km = self.sky.near_body_km(s);
        // The Sun's apparent position 2.6 s earlier: see the module's comment.
        let sun_km = self.sky.sun_km(s - 2.0 * moon_km.length() / SPEED_OF_LIGHT_KM_S);
        let sun_distance_km = sun_km.length();
        // Unit vector along the axis of the shadow, away from the Sun.
        let antisolar = -sun_km / sun_distance_km;
        // The Moon's distance behind the Earth's centre along the axis.
        let distance_behind_km = moon_km.dot(antisolar);
        let (earth_radius_km, sun_radius_km) = (self.radii.earth_radii_km.x, self.radii.sun_radius_km);
        // `sign` of `radius_km`: whether the cone narrows or widens away from the Sun.
        let (narrowing, widening) = (-1.0, 1.0);
        // Radius, at the Moon's distance, of the cone with this half angle that touches the Earth's sphere.
        let radius_km = |sin_half: f64, sign: f64| {
            let cos_half = (1.0 - sin_half * sin_half).sqrt();
            (earth_radius_km + sign * distance_behind_km * sin_half) / cos_half
        };
        let enlargement_km = if self.radii.convention == EclipseRadii::Almanac { DANJON_ENLARGEMENT * earth_radius_km } else { 0.0 };
        ShadowAtMoon {
            offset_from_axis_km: moon_km - antisolar * distance_behind_km,
            umbra_radius_km: radius_km((sun_radius_km - earth_radius_km) / sun_distance_km, narrowing) + enlargement_km,
            penumbra_radius_km: radius_km((sun_radius_km + earth_radius_km) / sun_distance_km, widening) + enlargement_km,
        }
    }

    /// Umbral and penumbral magnitude.
    fn magnitudes(&self, s: f64) -> (f64, f64) {
        let shadow = self.shadow_at_moon(s);
        let fraction_inside = |shadow_radius_km: f64| {
            (shadow_radius_km + self.eclipsed_moon_radius_km() - shadow.offset_from_axis_km.length())
                / (2.0 * self.eclipsed_moon_radius_km())
        };
        (fraction_inside(shadow.umbra_radius_km), fraction_inside(shadow.penumbra_radius_km))
    }
}

/// The eclipse of the Moon at a full moon, if there is one.
pub(super) fn eclipse_at(ephemeris: &Ephemeris, radii: BodyRadii, full_moon: Syzygy) -> Result<Option<LunarEclipse>, EphemerisError> {
    debug_assert_eq!(full_moon.phase, Phase::Full);
    if !full_moon.eclipse_is_possible() {
        return Ok(None);
    }
    let sky = EarthSky::around(ephemeris, NaifId::MOON, full_moon.mean_instant(), PHASE_SEARCH_S + SHADOW_SEARCH_S)?;
    let mut geometry = LunarEclipseGeometry { sky, radii, greatest_s: 0.0 };
    let greatest_s = time_of_minimum(-PHASE_SEARCH_S, PHASE_SEARCH_S, |s| geometry.shadow_at_moon(s).offset_from_axis_km.length());
    geometry.greatest_s = greatest_s;
    let (umbral_magnitude, penumbral_magnitude) = geometry.magnitudes(greatest_s);
    if penumbral_magnitude <= 0.0 {
        return Ok(None);
    }
    let mut contacts = Vec::new();
    // Adds the first and the last instant at which `magnitude` equals `fraction`; none if it does not exceed `fraction` at greatest eclipse.
    let mut add_contacts = |first, last, magnitude: &dyn Fn(f64) -> f64, fraction: f64| {
        let missing_fraction = |s: f64| fraction - magnitude(s);
        if missing_fraction(greatest_s) < 0.0 {
            contacts.push((first, zero_crossing(greatest_s, greatest_s - SHADOW_SEARCH_S, missing_fraction)));
            contacts.push((last, zero_crossing(greatest_s, greatest_s + SHADOW_SEARCH_S, missing_fraction)));
        }
    };
    let umbral = |s: f64| geometry.magnitudes(s).0;
    let penumbral = |s: f64| geometry.magnitudes(s).1;
    add_contacts("P1", "P4", &penumbral, 0.0);
    add_contacts("U1", "U4", &umbral, 0.0);
    add_contacts("U2", "U3", &umbral, 1.0);
    contacts.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let offset = geometry.shadow_at_moon(greatest_s).offset_from_axis_km;
    let moon_itrs_km = geometry.sky.itrs_from_gcrs(greatest_s) * geometry.sky.near_body_km(greatest_s);
    Ok(Some(LunarEclipse {
        class: match umbral_magnitude {
            m if m >= 1.0 => LunarType::Total,
            m if m > 0.0 => LunarType::Partial,
            _ => LunarType::Penumbral,
        },
        greatest: geometry.sky.instant(greatest_s),
        gamma: offset.length().copysign(offset.dot(geometry.sky.pole())) / radii.earth_radii_km.x,
        umbral_magnitude,
        penumbral_magnitude,
        // At the place with the Moon in the zenith, the geodetic latitude is nearly the Moon's declination. The difference, below 0.004 degrees, arises because
        // the vertical does not pass exactly through the Earth's centre.
        place: GeodeticPosition {
            latitude_deg: moon_itrs_km.z.atan2(moon_itrs_km.truncate().length()).to_degrees(),
            longitude_deg: moon_itrs_km.y.atan2(moon_itrs_km.x).to_degrees(),
            height_km: 0.0,
        },
        contacts: contacts.into_iter().map(|(name, s)| (name, geometry.sky.instant(s))).collect(),
        saros: full_moon.saros_series(),
        // Set by the search for eclipses (`events::eclipses_at_phase`), which knows other eclipses of the series.
        saros_member: None,
        geometry,
    }))
}

impl LunarEclipse {
    /// Seconds from one contact to another, such as U1 to U4 for the partial and U2 to U3 for the total phase; `None` if either is missing.
    pub fn duration_s(&self, first: &str, last: &str) -> Option<f64> {
        seconds_between(&self.contacts, first, last)
    }

    /// Local circumstances at a place.
    pub fn seen_from(&self, place: GeodeticPosition) -> LocalCircumstances {
        let station = Station::new(&self.geometry.sky, self.geometry.radii, place);
        let seconds_of = |t: Instant| t.tdb_seconds_past_j2000() - self.geometry.sky.instant(0.0).tdb_seconds_past_j2000();
        let contacts: Vec<_> = self.contacts.iter().map(|(name, t)| (*name, seconds_of(*t))).collect();
        // The magnitude that has the name of the eclipse's type: a penumbral eclipse has no umbral phase.
        let magnitude = |s: f64| {
            let (umbral, penumbral) = self.geometry.magnitudes(s);
            if self.class == LunarType::Penumbral { penumbral } else { umbral }
        };
        let penumbral_magnitude = |s: f64| self.geometry.magnitudes(s).1;
        station.lunar_circumstances(&contacts, self.geometry.greatest_s, magnitude, penumbral_magnitude)
    }
}
