//! Apparent places from the Earth, and the sub-observer and sub-solar points of a body.
//!
//! In: a body, barycentre or small body, and an instant (of reception); for the points also the body from whose centre they are observed. Out: degrees,
//! kilometres and seconds, for display. Apparent places include light time, light deflection by the Sun, and stellar aberration with its relativistic terms.
//! Omitted: deflection by the planets (under 0.02 arcsec, and only beside their discs), and the atmosphere.

use super::orientation::{self, PoleAndMeridian};
use super::target::Target;
use super::topocentric::place_of_normal_deg;
use super::{BEST_SOURCE, Ephemeris, EphemerisError, Source, State};
use crate::catalog::{Body, NaifId};
use crate::time::Instant;
use crate::units::{KM_PER_AU, RAD_PER_ARCSEC, SPEED_OF_LIGHT_KM_S};
use glam::{DMat3, DVec3};

/// SOFA's `dlim`: lower limit of 1 - cos(angle), a divisor of the deflection, which would be 0 behind the Sun's centre. The angle, at the Sun, is that between
/// the direction to the body and the direction away from the Earth; for a distant body it is the elongation. The limit is reached at 4.9 arcmin, behind the
/// Sun's disc (16 arcmin).
const DEFLECTION_LIMIT: f64 = 1e-6;

/// Tenths of a second of time in an hour, and of a second of arc in a degree.
const TENTHS_PER_HOUR_OR_DEGREE: u64 = 36_000;
/// Tenths of a second, of time or of arc, in a minute.
const TENTHS_PER_MINUTE: u64 = 600;

/// Right ascension and declination. The frame is stated where this type is used.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RaDec {
    /// Right ascension, 0 to 360.
    pub ra_deg: f64,
    /// Declination, -90 to 90.
    pub dec_deg: f64,
}

impl RaDec {
    /// Right ascension and declination of a direction of any length, in the direction's frame.
    pub fn of(direction: DVec3) -> Self {
        let (lon_deg, lat_deg) = lon_lat_deg(direction);
        Self { ra_deg: lon_deg, dec_deg: lat_deg }
    }

    /// Right ascension in hours, minutes and seconds of time: `5h 34m 31.9s`.
    pub fn ra_text(&self) -> String {
        let tenths = tenths_of_seconds(self.ra_deg.rem_euclid(360.0) / 15.0) % (24 * TENTHS_PER_HOUR_OR_DEGREE);
        let (hours, minutes, seconds) = sexagesimal(tenths);
        format!("{hours}h {minutes:02}m {seconds:04.1}s")
    }

    /// Declination in degrees, minutes and seconds of arc: `+8° 05′ 01.5″`.
    pub fn dec_text(&self) -> String {
        let tenths = tenths_of_seconds(self.dec_deg.abs());
        let sign = if self.dec_deg < 0.0 && tenths > 0 { '-' } else { '+' };
        let (degrees, minutes, seconds) = sexagesimal(tenths);
        format!("{sign}{degrees}° {minutes:02}′ {seconds:04.1}″")
    }
}

/// Hours or degrees as tenths of a second of time or of arc.
fn tenths_of_seconds(hours_or_degrees: f64) -> u64 {
    (hours_or_degrees * TENTHS_PER_HOUR_OR_DEGREE as f64).round() as u64
}

/// Splits tenths of a second, of time or of arc, into hours or degrees, minutes, and seconds.
fn sexagesimal(tenths: u64) -> (u64, u64, f64) {
    (tenths / TENTHS_PER_HOUR_OR_DEGREE, tenths / TENTHS_PER_MINUTE % 60, (tenths % TENTHS_PER_MINUTE) as f64 / 10.0)
}

/// A body's apparent place, as seen from the Earth's centre or from a place on the Earth.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ApparentPlace {
    /// Right ascension and declination in the GCRS.
    pub gcrs: RaDec,
    /// Right ascension and declination in the true equator and equinox of date (IAU 2006/2000A).
    pub true_of_date: RaDec,
    /// Distance from the body at the time of emission to the Earth at reception.
    pub distance_km: f64,
    /// Light time from the body to the observer.
    pub light_time_s: f64,
    /// The least accurate source of the body's position relative to the Earth.
    pub source: Source,
    /// Upper limit of the error of the body's position relative to the Earth, as an angle seen from the Earth.
    pub error_arcsec: f64,
}

/// Apparent place of a target, as seen from the Earth's centre at `t`.
///
/// # Errors
/// The ephemeris cannot place the target, or the target is the Earth.
pub fn apparent_place<'a>(ephemeris: &Ephemeris, target: impl Into<Target<'a>>, t: Instant) -> Result<ApparentPlace, EphemerisError> {
    let earth = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state;
    apparent_place_from(ephemeris, earth, target, t)
}

/// Apparent place of a target, as seen at `t` by an observer at the Earth's centre or on the Earth, with the barycentric state `observer`. The bound of the
/// error is that of the geocentric place.
///
/// # Errors
/// The ephemeris cannot place the target, or the target is where the observer is.
pub fn apparent_place_from<'a>(
    ephemeris: &Ephemeris,
    observer: State,
    target: impl Into<Target<'a>>,
    t: Instant,
) -> Result<ApparentPlace, EphemerisError> {
    let target = target.into();
    let sun_pos_km = ephemeris.state(NaifId::SUN, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state.pos_km;
    let (body_pos_km, _emission_time) = ephemeris.target_light_time_position(target, observer.pos_km, t)?;
    let to_body = body_pos_km - observer.pos_km;
    let distance_km = to_body.length();
    // The direction with light time, but without deflection and aberration.
    let astrometric = to_body.try_normalize().ok_or_else(|| EphemerisError::other("the Earth has no place as seen from its own centre"))?;

    let sun_to_observer_km = observer.pos_km - sun_pos_km;
    let sun_distance_au = sun_to_observer_km.length() / KM_PER_AU;
    // Arguments of `ld`: the Sun's mass in solar masses; the directions from the observer to the body, from the Sun to the body, from the Sun to the observer;
    // the observer's distance from the Sun; the limit. The Sun's position is that at `t`: it moves by a few kilometres while light travels from it to the
    // Earth. The Sun does not deflect its own light.
    let deflected = match (body_pos_km - sun_pos_km).try_normalize() {
        Some(sun_to_body) if target != Target::Body(NaifId::SUN) => DVec3::from_array(sofars::astro::ld(
            1.0,
            astrometric.to_array(),
            sun_to_body.to_array(),
            sun_to_observer_km.normalize().to_array(),
            sun_distance_au,
            DEFLECTION_LIMIT,
        )),
        _ => astrometric,
    };
    let beta = observer.vel_km_s / SPEED_OF_LIGHT_KM_S;
    let inverse_gamma = (1.0 - beta.length_squared()).sqrt();
    // Arguments of `ab`: the direction without aberration; the observer's velocity, units of c; its distance from the Sun, au; one over the Lorentz factor.
    let apparent = DVec3::from_array(sofars::astro::ab(&deflected.to_array(), &beta.to_array(), sun_distance_au, inverse_gamma));
    // Source and error of the body's position are taken from its geometric state at `t`.
    let geometric_state = ephemeris.target_state(target, NaifId::EARTH, t, BEST_SOURCE)?;
    Ok(ApparentPlace {
        gcrs: RaDec::of(apparent),
        true_of_date: RaDec::of(orientation::true_of_date_from_gcrs(t) * apparent),
        distance_km,
        light_time_s: distance_km / SPEED_OF_LIGHT_KM_S,
        source: geometric_state.source,
        error_arcsec: geometric_state.error_km / distance_km / RAD_PER_ARCSEC,
    })
}

/// A viewer at rest sees a light in the direction `u` (unit vector); the result is the direction (unit vector) in which a moving viewer sees it.
/// `velocity_km_s`: of the moving viewer, relative to the one at rest.
///
/// The relativistic formula (Urban and Seidelmann 2013, Explanatory Supplement, eq. 7.40), exact for uniform motion. SOFA's `ab`, used by [`apparent_place`],
/// adds the effect of the Sun's gravity, below a microarcsecond.
pub fn aberrated(u: DVec3, velocity_km_s: DVec3) -> DVec3 {
    let beta = velocity_km_s / SPEED_OF_LIGHT_KM_S;
    let inverse_gamma = (1.0 - beta.length_squared()).sqrt();
    let along = u.dot(beta);
    ((inverse_gamma * u + (1.0 + along / (1.0 + inverse_gamma)) * beta) / (1.0 + along)).normalize()
}

/// A point of a body's surface, degrees.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SurfacePoint {
    /// Planetocentric longitude: east positive, 0 to 360.
    pub lon_east_deg: f64,
    /// Planetocentric latitude: north positive.
    pub lat_centric_deg: f64,
    /// Planetographic longitude, 0 to 360: counted so that the sub-observer longitude of a distant observer grows with time (west for direct
    /// rotation, east for retrograde); by custom east for the Sun, the Earth and the Moon.
    pub lon_graphic_deg: f64,
    /// Planetographic latitude, the angle between the equator and the ellipsoid's normal: north positive.
    pub lat_graphic_deg: f64,
}

/// The orientation of a body towards an observer and the Sun, at the time of emission.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SubPoints {
    /// Where the line to the observer meets the surface.
    pub sub_observer: SurfacePoint,
    /// Where the line to the Sun meets the surface; `None` for the Sun itself.
    pub sub_solar: Option<SurfacePoint>,
    /// Angle at the body between the observer and the Sun; `None` for the Sun itself.
    pub phase_angle_deg: Option<f64>,
    /// Direction of the north pole, ICRF.
    pub pole: RaDec,
    /// Angle of the prime meridian, WGCCRE's W, 0 to 360.
    pub w_deg: f64,
    /// Distance from the observer to the body's centre.
    pub distance_km: f64,
    /// Light time from the body to the observer.
    pub light_time_s: f64,
}

/// The sub-observer and sub-solar points of `body` in the light that reaches `observer` at `t`. Aberration is left
/// out, as is usual for these points.
pub fn sub_points(ephemeris: &Ephemeris, body: &Body, observer: NaifId, t: Instant) -> Result<SubPoints, EphemerisError> {
    let observer_pos_km = ephemeris.state(observer, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state.pos_km;
    let (body_pos_km, emission_time) = ephemeris.light_time_position(body.id, observer_pos_km, t)?;
    let (sun_pos_km, _) = ephemeris.light_time_position(NaifId::SUN, body_pos_km, emission_time)?;
    let body_from_icrf = ephemeris.body_from_icrf(body.id, emission_time)?;
    let one_minute_later = ephemeris.body_from_icrf(body.id, emission_time.plus_seconds(60.0))?;
    let east_is_positive =
        matches!(body.id, NaifId::SUN | NaifId::EARTH | NaifId::MOON) || is_retrograde(&body_from_icrf, &one_minute_later);
    let point = |direction: DVec3| surface_point(body_from_icrf * direction, body.radii_km, east_is_positive);

    let to_observer = observer_pos_km - body_pos_km;
    // A millimetre, in km.
    if to_observer.length() < 1e-6 {
        return Err(EphemerisError::other(format!("{} cannot be seen from its own centre", body.name)));
    }
    let to_sun = (body.id != NaifId::SUN).then_some(sun_pos_km - body_pos_km);
    let pole_and_meridian = PoleAndMeridian::of(&body_from_icrf);
    Ok(SubPoints {
        sub_observer: point(to_observer),
        sub_solar: to_sun.map(point),
        phase_angle_deg: to_sun.map(|to_sun| super::angle_rad(to_sun, to_observer).to_degrees()),
        pole: RaDec { ra_deg: pole_and_meridian.pole_ra_deg, dec_deg: pole_and_meridian.pole_dec_deg },
        w_deg: pole_and_meridian.w_deg,
        distance_km: to_observer.length(),
        light_time_s: to_observer.length() / SPEED_OF_LIGHT_KM_S,
    })
}

/// Whether the rotation is retrograde, so that a direction fixed in ICRF moves east in the body's axes. `now`, `later`: `body_from_icrf` at two
/// instants less than half a rotation apart.
fn is_retrograde(now: &DMat3, later: &DMat3) -> bool {
    let x_axis_now_icrf = now.row(0);
    (*later * x_axis_now_icrf).y > 0.0
}

/// The point of the surface in a direction from the body's centre (body axes, any length). `east_is_positive`: whether planetographic longitude increases
/// eastward.
fn surface_point(direction_in_body: DVec3, radii_km: DVec3, east_is_positive: bool) -> SurfacePoint {
    let (lon_east_deg, lat_centric_deg) = lon_lat_deg(direction_in_body);
    // Normal to the ellipsoid at the surface point; that point is a multiple of the direction.
    let normal = direction_in_body / (radii_km * radii_km);
    // The longitude of the place with this normal is that above, here -180 to 180.
    let [lat_graphic_deg, _lon_east_deg] = place_of_normal_deg(radii_km, normal);
    SurfacePoint {
        lon_east_deg,
        lat_centric_deg,
        lon_graphic_deg: if east_is_positive { lon_east_deg } else { (-lon_east_deg).rem_euclid(360.0) },
        lat_graphic_deg,
    }
}

/// Longitude 0 to 360 and latitude of a direction, degrees.
fn lon_lat_deg(v: DVec3) -> (f64, f64) {
    (v.y.atan2(v.x).to_degrees().rem_euclid(360.0), v.z.atan2(v.truncate().length()).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sexagesimal_text_carries_and_keeps_the_sign() {
        let text = |ra_deg: f64, dec_deg: f64| (RaDec { ra_deg, dec_deg }.ra_text(), RaDec { ra_deg, dec_deg }.dec_text());
        assert_eq!(text(83.633, 8.083_75), ("5h 34m 31.9s".into(), "+8° 05′ 01.5″".into()));
        assert_eq!(text(359.999_999_9, -0.5), ("0h 00m 00.0s".into(), "-0° 30′ 00.0″".into()));
        assert_eq!(text(-15.0, 59.0 / 60.0 + 59.96 / 3600.0), ("23h 00m 00.0s".into(), "+1° 00′ 00.0″".into()));
        assert_eq!(text(0.0, -1e-9).1, "+0° 00′ 00.0″");
    }

    #[test]
    fn graphic_coordinates_of_saturn() {
        // At a planetocentric latitude of 45 degrees Saturn's normal leans 5.9 degrees poleward: the tangent of the
        // planetographic latitude is (60268/54364)^2.
        let radii_km = DVec3::new(60_268.0, 60_268.0, 54_364.0);
        let east_is_positive = false;
        let point = surface_point(DVec3::new(1.0, 0.0, 1.0), radii_km, east_is_positive);
        assert!((point.lat_centric_deg - 45.0).abs() < 1e-12);
        assert!((point.lat_graphic_deg.to_radians().tan() - (60_268.0_f64 / 54_364.0).powi(2)).abs() < 1e-12);
        let point = surface_point(DVec3::new(0.0, 1.0, 0.0), radii_km, east_is_positive);
        assert!((point.lon_east_deg - 90.0).abs() < 1e-12 && (point.lon_graphic_deg - 270.0).abs() < 1e-12);
        assert!(surface_point(DVec3::Z, radii_km, !east_is_positive).lat_graphic_deg > 89.999);
    }

    /// Planetocentric latitude -20.55 and longitude -12.93 degrees: the sub-Earth point of Phobos on 2024-06-01, by this program. A spheroid with the mean
    /// equatorial radius, used here before, gives a planetographic latitude of -34 degrees instead of -36.95, which the gradient below confirms.
    #[test]
    fn the_graphic_latitude_on_phobos_is_that_of_the_ellipsoids_normal() {
        let radii_km = DVec3::new(13.0, 11.4, 9.1);
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = ((-20.55_f64).to_radians().sin_cos(), (-12.93_f64).to_radians().sin_cos());
        let direction = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        let east_is_positive = false;
        let point = surface_point(direction, radii_km, east_is_positive);
        // The normal as the gradient of the ellipsoid's equation.
        let gradient = DVec3::new(direction.x / 13.0_f64.powi(2), direction.y / 11.4_f64.powi(2), direction.z / 9.1_f64.powi(2));
        assert!((point.lat_graphic_deg - gradient.normalize().z.asin().to_degrees()).abs() < 1e-9, "{point:?}");
        assert!((point.lat_graphic_deg + 36.95).abs() < 0.05 && (point.lon_east_deg - 347.07).abs() < 1e-9, "{point:?}");
    }

    #[test]
    fn the_earths_speed_shifts_a_star_abeam_by_the_constant_of_aberration() {
        // kappa = v / c = 20.49552 arcsec (IAU 1976); v is the Earth's mean speed, near 29.789 km/s.
        let seen = aberrated(DVec3::Y, DVec3::X * 29.7892);
        let shift_arcsec = seen.x.atan2(seen.y) / RAD_PER_ARCSEC;
        assert!((shift_arcsec - 20.4955).abs() < 0.01, "{shift_arcsec}");
        assert_eq!(aberrated(DVec3::Y, DVec3::ZERO), DVec3::Y);
    }

    #[test]
    fn retrograde_rotation_is_recognized() {
        // Venus's pole.
        let turned = |deg: f64| PoleAndMeridian { pole_ra_deg: 272.8, pole_dec_deg: 67.2, w_deg: deg }.body_from_icrf();
        assert!(is_retrograde(&turned(10.0), &turned(9.9)));
        assert!(!is_retrograde(&turned(10.0), &turned(10.1)));
    }
}
