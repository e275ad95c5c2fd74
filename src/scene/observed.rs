//! What an observer on the Earth sees of a body, minor planet or comet: the quantities of an ephemeris, without an image.
//!
//! In: the catalog, the ephemeris, a place on the Earth or its centre, a target and an instant. Out: [`Observed`]. Magnitudes and sizes of the catalog's bodies
//! are those of images and reports ([`super::seen_from`]): with phase laws, rings, light curves and eclipses. Minor planets follow the H, G system, comets M1
//! and K1. Left out: refraction and extinction by the Earth's air.

use crate::catalog::constellations::{Constellation, Constellations};
use crate::catalog::small_bodies::{BrightnessLaw, NamedTarget};
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::apparent::{ApparentPlace, apparent_place_from};
use crate::ephemeris::target::Target;
use crate::ephemeris::topocentric::{Horizontal, Observer, ObserverSky};
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError, State, angle_rad};
use crate::scene::body_report::BodyReport;
use crate::scene::error::SceneError;
use crate::scene::light::{phase_laws, photometry};
use crate::scene::request::view_request::Position;
use crate::scene::resources::Caches;
use crate::scene::seen_from::body_seen_from;
use crate::scene::sky::comets;
use crate::scene::sky::frames::unit_vector;
use crate::time::Instant;
use crate::units::{KM_PER_AU, RAD_PER_ARCSEC, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use std::f64::consts::PI;

/// Least height of the viewer whose magnitudes are computed, so that rounding does not put it inside the Earth: a metre.
const MIN_HEIGHT_KM: f64 = 1e-3;

/// The apparent angle between a target and the Sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elongation {
    /// 0 to 180.
    pub angle_deg: f64,
    /// Whether the target is east of the Sun, by right ascension: it then sets after the Sun, in the evening sky. It trails the Sun in its daily motion.
    pub is_east: bool,
}

/// A target as an observer on the Earth sees it. `None`: the quantity does not exist or is unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Observed {
    /// Its apparent place, distance and light time.
    pub place: ApparentPlace,
    /// Distance from the Sun when the light left that the observer sees; 0 for the Sun.
    pub sun_distance_km: f64,
    /// Rate of change of the distance, positive for a target that recedes; with light time.
    pub range_rate_km_s: f64,
    /// Angle at the target between the observer and the Sun. `None` for the Sun and for barycentres.
    pub phase_angle_deg: Option<f64>,
    /// The part of the disc that the Sun lights, for a sphere. `None` also for comets.
    pub illuminated_fraction: Option<f64>,
    /// `None` for the Sun.
    pub elongation: Option<Elongation>,
    /// Visual magnitude: of planets with their rings, of comets in total. `None` also without sunlight, as in the middle of an eclipse.
    pub magnitude: Option<f64>,
    /// Angle of the largest diameter. `None` for minor planets and comets outside the catalog, whose size is not known.
    pub angular_diameter_deg: Option<f64>,
    /// Mean visual magnitude of a square arcsecond of the globe's lit part, without rings.
    pub surface_brightness_mag_arcsec2: Option<f64>,
    /// The constellation that the target is in.
    pub constellation: Option<&'static Constellation>,
}

/// The sky of the Earth: of a place on it, or as seen from its centre.
pub struct SkyOfEarth<'a> {
    catalog: &'a Catalog,
    ephemeris: &'a Ephemeris,
    /// `None`: the Earth's centre.
    place: Option<Observer>,
    /// Tables that are kept from one instant to the next.
    caches: Caches,
}

/// Total magnitude of a minor planet or comet; `None` if the law is unknown or gives no light.
pub fn small_body_magnitude(law: BrightnessLaw, distance_au: f64, sun_distance_au: f64, phase_angle_rad: f64) -> Option<f64> {
    let magnitude = match law {
        BrightnessLaw::Asteroid { h, g } => {
            h + 5.0 * (distance_au * sun_distance_au).log10() + phase_laws::slope_parameter_magnitude(g, phase_angle_rad.to_degrees())
        }
        BrightnessLaw::Comet { .. } | BrightnessLaw::Unknown => {
            comets::total_magnitude(law, distance_au, sun_distance_au, phase_angle_rad)?
        }
    };
    magnitude.is_finite().then_some(magnitude)
}

/// Mean magnitude of a square arcsecond of the globe's lit part; `None` without light. `globe_fraction`: the part of the body's light that comes from its
/// globe.
fn surface_brightness(report: &BodyReport, globe_fraction: f64, illuminated_fraction: f64) -> Option<f64> {
    let to_viewer = (report.placement.body_from_icrf * -report.placement.centre_km).try_normalize()?;
    let disc_km2 = PI * photometry::projected_radius_sq_km2(report.placement.radii_km, to_viewer);
    let lit_arcsec2 = illuminated_fraction * disc_km2 / (report.distance_km * RAD_PER_ARCSEC).powi(2);
    let brightness = report.magnitude? + 2.5 * (lit_arcsec2 / globe_fraction).log10();
    brightness.is_finite().then_some(brightness)
}

impl<'a> SkyOfEarth<'a> {
    /// The sky of a place on the Earth; `None`: as seen from the Earth's centre.
    pub fn new(catalog: &'a Catalog, ephemeris: &'a Ephemeris, place: Option<Observer>) -> Self {
        Self { catalog, ephemeris, place, caches: Caches::default() }
    }

    /// `None` as seen from the Earth's centre.
    fn sky(&self) -> Option<ObserverSky<'a>> {
        self.place.map(|place| ObserverSky { catalog: self.catalog, ephemeris: self.ephemeris, place })
    }

    /// Barycentric state of the observer.
    fn observer(&self, t: Instant) -> Result<State, EphemerisError> {
        match self.sky() {
            Some(sky) => sky.state(t),
            None => Ok(self.ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state),
        }
    }

    /// The catalog's report on a body, and the part of its light that comes from its globe; `None` for a barycentre.
    fn report(&self, id: NaifId, t: Instant) -> Result<Option<(BodyReport, f64)>, SceneError> {
        let position = self.place.map_or(Position::Centre(NaifId::EARTH), |place| Position::Ground {
            body: place.body,
            latitude_deg: place.lat_graphic_deg,
            longitude_deg: place.lon_east_deg,
            height_km: place.height_km.max(MIN_HEIGHT_KM),
        });
        body_seen_from(self.catalog, self.ephemeris, &self.caches, position, t, id)
    }

    /// Azimuth and altitude of a target without refraction; `None` as seen from the Earth's centre.
    ///
    /// # Errors
    /// As [`ObserverSky::topocentric`].
    pub fn horizontal(&self, target: &NamedTarget, t: Instant) -> Result<Option<Horizontal>, EphemerisError> {
        self.sky().map(|sky| sky.topocentric(target, t)).transpose()
    }

    /// What the observer sees of a target.
    ///
    /// # Errors
    /// The target is the Earth, or the ephemeris cannot place it at `t`.
    pub fn observe(&self, target: &NamedTarget, t: Instant) -> Result<Observed, SceneError> {
        if *target == NamedTarget::Body(NaifId::EARTH) {
            return Err(EphemerisError::other("the Earth is not in its own sky").into());
        }
        let (ephemeris, observer) = (self.ephemeris, self.observer(t)?);
        let place = apparent_place_from(ephemeris, observer, target, t)?;
        let sun = apparent_place_from(ephemeris, observer, NaifId::SUN, t)?;

        let moving = Target::from(target);
        let emitted = t.plus_seconds(-place.light_time_s);
        let State { pos_km: body_km, vel_km_s: velocity_km_s } =
            ephemeris.target_state(moving, NaifId::SOLAR_SYSTEM_BARYCENTER, emitted, BEST_SOURCE)?.state;
        let to_body = body_km - observer.pos_km;
        let direction = to_body / place.distance_km;
        // The derivative of |p(t - d/c) - o(t)| = d, with the position p of the target and o of the observer.
        let range_rate_km_s = direction.dot(velocity_km_s - observer.vel_km_s) / (1.0 + direction.dot(velocity_km_s) / SPEED_OF_LIGHT_KM_S);

        let is_sun = *target == NamedTarget::Body(NaifId::SUN);
        let to_sun = ephemeris.light_time_position(NaifId::SUN, body_km, emitted)?.0 - body_km;
        let sun_distance_km = if is_sun { 0.0 } else { to_sun.length() };
        let phase_angle_rad = angle_rad(-to_body, to_sun);
        let lit_fraction = if is_sun { 1.0 } else { 0.5 * (1.0 + phase_angle_rad.cos()) };
        let (magnitude, angular_diameter_deg, surface_brightness_mag_arcsec2, has_phase, has_disc) = match target {
            NamedTarget::Body(id) => match self.report(*id, t)? {
                Some((report, globe_fraction)) => {
                    let brightness = surface_brightness(&report, globe_fraction, lit_fraction);
                    (report.magnitude, Some(report.angular_diameter_deg), brightness, !is_sun, !is_sun)
                }
                None => (None, None, None, false, false),
            },
            NamedTarget::SmallBody(body) => {
                let [distance_au, sun_distance_au] = [place.distance_km, sun_distance_km].map(|km| km / KM_PER_AU);
                let brightness = body.brightness_at(emitted.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
                let magnitude = small_body_magnitude(brightness, distance_au, sun_distance_au, phase_angle_rad);
                (magnitude, None, None, true, !body.is_comet())
            }
        };
        let [direction_gcrs, sun_direction_gcrs] = [place.gcrs, sun.gcrs].map(|place| unit_vector(place.ra_deg, place.dec_deg));
        Ok(Observed {
            sun_distance_km,
            range_rate_km_s,
            phase_angle_deg: has_phase.then(|| phase_angle_rad.to_degrees()),
            illuminated_fraction: has_disc.then_some(lit_fraction),
            elongation: (!is_sun).then(|| Elongation {
                angle_deg: angle_rad(direction_gcrs, sun_direction_gcrs).to_degrees(),
                is_east: (place.true_of_date.ra_deg - sun.true_of_date.ra_deg).to_radians().sin() > 0.0,
            }),
            magnitude,
            angular_diameter_deg,
            surface_brightness_mag_arcsec2,
            constellation: Constellations::embedded().containing(direction_gcrs),
            place,
        })
    }
}
