//! Apparent places against skyfield on DE440, sub-points against CSPICE.

use glam::DVec3;
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::ephemeris::apparent::{RaDec, apparent_place, sub_points};
use orrery::scene::sky::frames::unit_vector;
use orrery::time::Instant;
use orrery::units::RAD_PER_ARCSEC;
use serde_json::Value;

/// Tolerance of apparent places, which includes the error of the shipped kernel.
const APPARENT_ARCSEC: f64 = 0.02;
/// Tolerance of sub-points and phase angles. Measured: 1.5e-5 degrees for Jupiter and Saturn, because the reference uses barycentres as the positions
/// of planets (Saturn: 320 km at 8 au); 1e-7 degrees for Mars and the Moon.
const SUB_POINT_DEG: f64 = 5e-5;

fn ephemeris() -> Ephemeris {
    Ephemeris::embedded(&Catalog::embedded()).expect("the shipped ephemeris")
}

fn direction(place: RaDec) -> DVec3 {
    unit_vector(place.ra_deg, place.dec_deg)
}

/// Angle between two directions.
fn separation_arcsec(a: RaDec, b: RaDec) -> f64 {
    2.0 * (0.5 * (direction(a) - direction(b)).length()).asin() / RAD_PER_ARCSEC
}

fn number(v: &Value, field: &str) -> f64 {
    v[field].as_f64().unwrap_or_else(|| panic!("{field} is not a number"))
}

#[test]
fn apparent_places_agree_with_skyfield() {
    let ephemeris = ephemeris();
    let table: Value = serde_json::from_str(include_str!("../data/ephemeris_public.json")).expect("the reference is JSON");
    let (mut compared, mut worst_gcrs, mut worst_of_date, mut worst_km) = (0, 0.0_f64, 0.0_f64, 0.0_f64);
    for epoch in table["apparent_places"].as_array().expect("epochs") {
        let jd_tt = number(epoch, "jd_tt");
        let t = Instant::from_jd_tt(jd_tt);
        for (name, reference) in epoch["bodies"].as_object().expect("bodies") {
            // From Mars outwards the reference has the barycentres of the planets' systems, NAIF ids 4 to 9.
            let id = match name.as_str() {
                "moon" => 301,
                "sun" => 10,
                "mercury" => 199,
                "venus" => 299,
                "mars" => 4,
                "jupiter" => 5,
                "saturn" => 6,
                "uranus" => 7,
                "neptune" => 8,
                "pluto" => 9,
                other => panic!("{other} is not a known name"),
            };
            let place = apparent_place(&ephemeris, NaifId(id), t).expect("a place");
            let apparent = |kind: &str| RaDec {
                ra_deg: number(reference, &format!("apparent_{kind}_ra_deg")),
                dec_deg: number(reference, &format!("apparent_{kind}_dec_deg")),
            };
            let gcrs_arcsec = separation_arcsec(place.gcrs, apparent("gcrs"));
            let of_date_arcsec = separation_arcsec(place.true_of_date, apparent("date"));
            let error_km = (place.distance_km - number(reference, "lighttime_distance_km")).abs();
            (worst_gcrs, worst_of_date, worst_km, compared) =
                (worst_gcrs.max(gcrs_arcsec), worst_of_date.max(of_date_arcsec), worst_km.max(error_km), compared + 1);
            assert!(
                gcrs_arcsec < APPARENT_ARCSEC && of_date_arcsec < APPARENT_ARCSEC,
                "{jd_tt} {name}: {gcrs_arcsec} and {of_date_arcsec} arcsec"
            );
            assert!(error_km < 10.0, "{jd_tt} {name}: {error_km} km");
            assert!((place.light_time_s - number(reference, "light_time_s")).abs() < 1e-4);
            // Negative controls: the place in the axes of date (precession), and the geometric place.
            assert!(separation_arcsec(place.gcrs, apparent("date")) > APPARENT_ARCSEC);
            let geometric = ephemeris.state(NaifId(id), NaifId::EARTH, t, None).expect("a place").state.pos_km;
            assert!(separation_arcsec(RaDec::of(geometric), apparent("gcrs")) > APPARENT_ARCSEC, "{name}");
        }
    }
    println!("{compared} places: {worst_gcrs} arcsec GCRS, {worst_of_date} arcsec of date, {worst_km} km");
    // Five dates, all in the span of the shipped kernel, and ten bodies.
    assert_eq!(compared, 50);
}

#[test]
fn sub_points_agree_with_cspice() {
    let (catalog, ephemeris) = (Catalog::embedded(), ephemeris());
    let table: Value = serde_json::from_str(include_str!("../data/rotation_public.json")).expect("the reference is JSON");
    let (mut compared, mut worst) = (0, 0.0_f64);
    for date in table["sub_points_dates"].as_array().expect("dates") {
        let t = Instant::from_jd_tdb(number(date, "jd_tdb"));
        for (name, reference) in date["bodies"].as_object().expect("bodies") {
            let body = catalog.find_body_or_barycenter(name).and_then(|id| catalog.body(id)).expect("a body");
            let points = sub_points(&ephemeris, body, NaifId::EARTH, t).expect("points");
            let expected = &reference["light_time"];
            let sun = points.sub_solar.expect("a planet has one");
            for (p, lon, lat) in [
                (points.sub_observer, "sub_earth_lon_east_deg", "sub_earth_lat_centric_deg"),
                (sun, "sub_solar_lon_east_deg", "sub_solar_lat_centric_deg"),
            ] {
                // The angle between two points of the sphere; `RaDec` holds longitude and latitude here.
                let error_deg = separation_arcsec(
                    RaDec { ra_deg: p.lon_east_deg, dec_deg: p.lat_centric_deg },
                    RaDec { ra_deg: number(expected, lon), dec_deg: number(expected, lat) },
                ) / 3600.0;
                (worst, compared) = (worst.max(error_deg), compared + 1);
                assert!(error_deg < SUB_POINT_DEG, "{name} {lon}: {error_deg} degrees");
            }
            let phase_deg = points.phase_angle_deg.expect("a planet has one");
            assert!((phase_deg - number(expected, "phase_angle_deg")).abs() < SUB_POINT_DEG, "{name}: phase {phase_deg}");
            assert!((points.light_time_s - number(expected, "light_time_s")).abs() < 0.01);
            // Negative control: without light time the planet would have rotated further. For the Moon, 1.3 s away, the difference is too
            // small.
            if points.light_time_s > 60.0 {
                assert!(
                    (points.sub_observer.lon_east_deg - number(&reference["geometric"], "sub_earth_lon_east_deg")).abs() > SUB_POINT_DEG
                );
            }
        }
    }
    println!("{compared} sub-points: {worst} degrees");
    assert!(compared >= 20);
}

#[test]
fn a_body_has_no_direction_from_its_own_centre() {
    let (catalog, ephemeris) = (Catalog::embedded(), ephemeris());
    let t = Instant::from_jd_tdb(2_451_545.0);
    assert!(apparent_place(&ephemeris, NaifId::EARTH, t).is_err());
    assert!(sub_points(&ephemeris, catalog.body(NaifId::EARTH).expect("the Earth"), NaifId::EARTH, t).is_err());
}
