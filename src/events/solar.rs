//! Eclipses of the Sun on the Earth.
//!
//! In: a new moon, the ephemeris, the catalog's radii. Out: type, greatest eclipse, contacts of the shadow cones with the Earth's spheroid. Greatest
//! eclipse is when the axis of the shadow is nearest to the Earth's centre (Explanatory Supplement, 3rd ed., section 11.3). Not here: the Moon's
//! mountains, refraction.

use super::cone::{Cone, Spheroid, moon_to_sun};
use super::contacts::Contact;
use super::local::{GeodeticPosition, LocalCircumstances, Station};
use super::lunation::{Phase, Syzygy};
use super::numeric::{time_of_minimum, zero_crossing};
use super::sky::{BodyRadii, EarthSky};
use crate::catalog::NaifId;
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;

/// The true new moon, and with it the greatest eclipse, is within 15 hours of the mean new moon.
const PHASE_SEARCH_S: f64 = 15.0 * 3600.0;
/// The penumbra leaves the Earth within 4 hours of the greatest eclipse.
const SHADOW_SEARCH_S: f64 = 4.0 * 3600.0;
/// The centre line is divided into this many steps, equal in time; at each end of a step, the eclipse is classified as total or annular.
const LINE_STEPS: i32 = 24;

/// The type of a solar eclipse: along the centre line if there is one, else at the place of greatest eclipse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolarType {
    Partial,
    Annular,
    Total,
    /// Annular on one part of the centre line, total on another.
    Hybrid,
}

impl SolarType {
    pub fn name(self) -> &'static str {
        match self {
            Self::Partial => "partial",
            Self::Annular => "annular",
            Self::Total => "total",
            Self::Hybrid => "hybrid",
        }
    }
}

/// An eclipse of the Sun.
#[derive(Clone, Debug)]
pub struct SolarEclipse {
    /// The type; `type` is a keyword of Rust.
    pub class: SolarType,
    /// Whether the axis of the shadow meets the ground.
    pub is_central: bool,
    /// Instant of greatest eclipse, when the light of Sun and Moon reaches the Earth's centre; contacts are given in the same way.
    pub greatest: Instant,
    /// Least distance of the shadow's axis from the Earth's centre, in the Earth's equatorial radii; positive if the axis passes north of the centre.
    pub gamma: f64,
    /// Magnitude at the place of greatest eclipse, as in eclipse canons. If the axis meets the ground then: the Moon's apparent diameter over the Sun's.
    /// Otherwise the covered part of the Sun's diameter by the Besselian formula (L1 - m) / (L1 + L2), which exceeds 1 where the Sun is covered entirely.
    pub magnitude: f64,
    /// Where the axis meets the ground at greatest eclipse, or the place nearest to the axis if the axis misses the ground.
    pub place: GeodeticPosition,
    /// Altitude of the Sun at `place` at greatest eclipse.
    pub sun_altitude_deg: f64,
    /// Duration of totality or annularity at `place`; `None` if the eclipse is partial there.
    pub duration_s: Option<f64>,
    /// In order of time, P1 and P4: the penumbra meets and leaves the Earth; between them, if they occur, U1 and U4: the umbra or antumbra does.
    pub contacts: Vec<Contact>,
    /// Number of the Saros series.
    pub saros: i64,
    /// Number of the eclipse within the series, starting at 1; `None` if the series may have begun before the span of the ephemeris, or
    /// if the search omits it (`solar_eclipses_without_saros`).
    pub saros_member: Option<i64>,
    pub(super) geometry: SolarEclipseGeometry,
}

/// Sky and radii of one eclipse. Times `s` are seconds from the mean new moon. The near body of the sky is the Moon. Vectors are GCRS, from the Earth's centre.
#[derive(Clone, Debug)]
pub(super) struct SolarEclipseGeometry {
    pub sky: EarthSky,
    pub radii: BodyRadii,
    /// Instant of greatest eclipse.
    pub greatest_s: f64,
}

impl SolarEclipseGeometry {
    fn earth(&self) -> Spheroid {
        let radii_km = self.radii.earth_radii_km;
        Spheroid { equatorial_km: radii_km.x, polar_km: radii_km.z, pole: self.sky.pole() }
    }

    /// Gap between the penumbra and the Earth; negative if they overlap. Almanacs use a larger radius of the Moon for the penumbra than for the umbra.
    fn penumbra_gap_km(&self, s: f64) -> f64 {
        let cone =
            Cone::penumbra(self.sky.sun_km(s), self.sky.near_body_km(s), self.radii.sun_radius_km, self.radii.penumbral_moon_radius_km);
        let (gap_km, _normal) = cone.gap_km(&self.earth());
        gap_km
    }

    /// Gap between the umbra or antumbra and the Earth; negative if they overlap.
    fn umbra_gap_km(&self, s: f64) -> f64 {
        let cone =
            Cone::umbra_or_antumbra(self.sky.sun_km(s), self.sky.near_body_km(s), self.radii.sun_radius_km, self.radii.moon_radius_km);
        let (gap_km, _normal) = cone.gap_km(&self.earth());
        gap_km
    }

    /// The place where the axis of the shadow meets the ground; `None` if it misses the ground.
    pub(crate) fn centre(&self, s: f64) -> Option<GeodeticPosition> {
        let (moon_km, (to_sun, _distance_km)) = (self.sky.near_body_km(s), moon_to_sun(self.sky.sun_km(s), self.sky.near_body_km(s)));
        let point_km = self.earth().sunlit_intersection_km(moon_km, to_sun)?;
        Some(GeodeticPosition::of_surface_point(self.sky.itrs_from_gcrs(s) * point_km, self.radii.earth_radii_km))
    }

    /// The place nearest to the axis, which must miss or touch the ground.
    fn nearest_place(&self, s: f64) -> GeodeticPosition {
        let (_gap_km, towards_earth) = Cone::axis(self.sky.sun_km(s), self.sky.near_body_km(s)).gap_km(&self.earth());
        GeodeticPosition::of_surface_point(
            self.sky.itrs_from_gcrs(s) * self.earth().support_point_km(-towards_earth),
            self.radii.earth_radii_km,
        )
    }

    /// An observer at a place during this eclipse.
    pub(crate) fn station(&self, place: GeodeticPosition) -> Station<'_> {
        Station::new(&self.sky, self.radii, place)
    }

    /// When the axis first meets and last leaves the ground, seconds; `None` if the axis misses the ground.
    pub(crate) fn central_span(&self) -> Option<(f64, f64)> {
        let earth = self.earth();
        // Negative while the axis meets the ground, as `zero_crossing` needs it.
        let minus_half_chord_sq =
            |s: f64| -earth.half_chord_sq(self.sky.near_body_km(s), moon_to_sun(self.sky.sun_km(s), self.sky.near_body_km(s)).0);
        // The flattening shifts the longest chord by less than ten minutes from the greatest eclipse.
        let middle = time_of_minimum(self.greatest_s - 600.0, self.greatest_s + 600.0, minus_half_chord_sq);
        (minus_half_chord_sq(middle) < 0.0).then(|| {
            (
                zero_crossing(middle, middle - SHADOW_SEARCH_S, minus_half_chord_sq),
                zero_crossing(middle, middle + SHADOW_SEARCH_S, minus_half_chord_sq),
            )
        })
    }

    /// Whether a central eclipse is total and not annular at a place of its path: whether the Moon's disc is larger than the Sun's.
    fn is_total(&self, s: f64, place: GeodeticPosition) -> bool {
        let discs = self.station(place).discs(s);
        discs.moon_radius_rad > discs.sun_radius_rad
    }

    /// The type of a central eclipse whose axis meets the ground between these two instants, in seconds, from samples of the centre line.
    fn type_along_line(&self, (start_s, end_s): (f64, f64)) -> SolarType {
        // The ends of the line are its places farthest from the Moon, which a sample between them would miss: a second after the start the axis has moved 1 km
        // inwards, where the ground is sqrt(2 * 6378 km * 1 km) = 113 km nearer to the Moon, whose disc is larger by 3e-4 of its diameter. At an end the axis
        // touches the ground, at the place nearest to the axis.
        let ends = [start_s, end_s].map(|s| (s, self.nearest_place(s)));
        let between = (1..LINE_STEPS).filter_map(|i| {
            let s = start_s + (end_s - start_s) * f64::from(i) / f64::from(LINE_STEPS);
            Some((s, self.centre(s)?))
        });
        let totality: Vec<bool> = ends.into_iter().chain(between).map(|(s, place)| self.is_total(s, place)).collect();
        match (totality.contains(&true), totality.contains(&false)) {
            (true, true) => SolarType::Hybrid,
            (true, false) => SolarType::Total,
            _ => SolarType::Annular,
        }
    }
}

/// The eclipse of the Sun at a new moon, if there is one.
pub(super) fn eclipse_at(ephemeris: &Ephemeris, radii: BodyRadii, new_moon: Syzygy) -> Result<Option<SolarEclipse>, EphemerisError> {
    debug_assert_eq!(new_moon.phase, Phase::New);
    if !new_moon.eclipse_is_possible() {
        return Ok(None);
    }
    let sky = EarthSky::around(ephemeris, NaifId::MOON, new_moon.mean_instant(), PHASE_SEARCH_S + SHADOW_SEARCH_S)?;
    // Vector from the Earth's centre to the nearest point of the axis.
    let nearest_on_axis_km = |s: f64| {
        let (moon_km, (to_sun, _distance_km)) = (sky.near_body_km(s), moon_to_sun(sky.sun_km(s), sky.near_body_km(s)));
        moon_km - to_sun * moon_km.dot(to_sun)
    };
    let greatest_s = time_of_minimum(-PHASE_SEARCH_S, PHASE_SEARCH_S, |s| nearest_on_axis_km(s).length());
    let nearest_km = nearest_on_axis_km(greatest_s);
    let gamma = nearest_km.length().copysign(nearest_km.dot(sky.pole())) / radii.earth_radii_km.x;
    let geometry = SolarEclipseGeometry { sky, radii, greatest_s };
    if geometry.penumbra_gap_km(greatest_s) >= 0.0 {
        return Ok(None);
    }
    // First and last contact of the Earth with a cone. `gap`: distance between the cone and the spheroid by time.
    let contacts_of = |gap: &dyn Fn(f64) -> f64| {
        let contact_s = |search_s: f64| zero_crossing(greatest_s, greatest_s + search_s, gap);
        (contact_s(-SHADOW_SEARCH_S), contact_s(SHADOW_SEARCH_S))
    };
    let penumbra_contacts_s = contacts_of(&|s| geometry.penumbra_gap_km(s));
    let umbra_contacts_s = (geometry.umbra_gap_km(greatest_s) < 0.0).then(|| contacts_of(&|s| geometry.umbra_gap_km(s)));
    let central_span = geometry.central_span();
    let centre = geometry.centre(greatest_s);
    let place = centre.unwrap_or_else(|| geometry.nearest_place(greatest_s));
    let class = match (central_span, umbra_contacts_s) {
        (Some(span), _) => geometry.type_along_line(span),
        (None, Some(_)) if geometry.is_total(greatest_s, place) => SolarType::Total,
        (None, Some(_)) => SolarType::Annular,
        (None, None) => SolarType::Partial,
    };
    let instant = |s: f64| geometry.sky.instant(s);
    let mut contacts = vec![("P1", instant(penumbra_contacts_s.0)), ("P4", instant(penumbra_contacts_s.1))];
    if let Some((first, last)) = umbra_contacts_s {
        contacts.splice(1..1, [("U1", instant(first)), ("U4", instant(last))]);
    }
    let station = geometry.station(place);
    let discs = station.discs(greatest_s);
    Ok(Some(SolarEclipse {
        class,
        is_central: central_span.is_some(),
        greatest: instant(greatest_s),
        gamma,
        // The axis may miss the ground at greatest eclipse, and graze it some minutes earlier or later: then the eclipse is central without a `centre`.
        magnitude: if centre.is_some() { discs.radius_ratio() } else { discs.covered_diameter() },
        place,
        sun_altitude_deg: station.sun_altitude_deg(greatest_s),
        duration_s: station.inner_contacts(greatest_s).map(|(second, third)| third - second),
        contacts,
        saros: new_moon.saros_series(),
        saros_member: None,
        geometry,
    }))
}

impl SolarEclipse {
    /// Local circumstances at a place; `None` if the Moon misses the Sun. At C1 and C4 the discs touch from outside, at C2 and C3 from inside.
    pub fn seen_from(&self, place: GeodeticPosition) -> Option<LocalCircumstances> {
        self.geometry.station(place).solar_circumstances(self.geometry.greatest_s, ["C1", "C2", "C3", "C4"])
    }
}
