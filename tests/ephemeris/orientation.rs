//! Orientation and sub-points against CSPICE and ERFA (tests/data/rotation_public.json), including light time.

use glam::{DMat3, DVec3};
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, orientation};
use orrery::time::Instant;
use serde_json::Value;

/// Tolerance of IAU models, as the angle of rotation between two matrices: they are closed formulas, so only rounding may differ.
const IAU_TOLERANCE_DEG: f64 = 1e-7;
/// Tolerance of the Earth with the reference's Delta T; polar motion is left out on both sides.
const EARTH_TOLERANCE_DEG: f64 = 1e-6;
/// Tolerance of sub-points with light time. The reference uses barycentres as the positions of the planets: 320 km at 8 au for Saturn are
/// 1.5e-5 degrees.
const SUB_POINT_DEG: f64 = 5e-5;

fn reference() -> Value {
    serde_json::from_str(include_str!("../data/rotation_public.json")).expect("the table is JSON")
}

fn number(v: &Value) -> f64 {
    v.as_f64().expect("a number")
}

fn matrix(v: &Value) -> DMat3 {
    let rows: Vec<DVec3> = v.as_array().expect("rows").iter().map(|r| DVec3::new(number(&r[0]), number(&r[1]), number(&r[2]))).collect();
    DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()
}

/// Angle of the rotation from one matrix to the other, by the antisymmetric part, which keeps small angles accurate.
fn rotation_between_deg(a: &DMat3, b: &DMat3) -> f64 {
    let d = *a * b.transpose();
    let axis = DVec3::new(d.y_axis.z - d.z_axis.y, d.z_axis.x - d.x_axis.z, d.x_axis.y - d.y_axis.x);
    (axis.length() / 2.0).atan2((d.x_axis.x + d.y_axis.y + d.z_axis.z - 1.0) / 2.0).to_degrees()
}

fn id_of(name: &str) -> NaifId {
    Catalog::embedded().find_body_or_barycenter(name).unwrap_or_else(|| panic!("the catalog has {name}"))
}

#[test]
fn poles_and_prime_meridians_agree_with_wgccre() {
    let pck = orientation::Pck::parse(orientation::EMBEDDED_PCK).expect("the shipped PCK reads");
    let (mut count, mut failures) = (0, Vec::new());
    for epoch in reference()["epochs"].as_array().expect("epochs") {
        let t = Instant::from_jd_tdb(number(&epoch["jd_tdb"]));
        for (name, body) in epoch["bodies"].as_object().expect("bodies") {
            let model = pck.pole_and_meridian(id_of(name), t.tdb_seconds_past_j2000()).expect("the PCK has it");
            let deg = rotation_between_deg(&model.body_from_icrf(), &matrix(&body["icrf_to_body"]));
            count += 1;
            if deg > IAU_TOLERANCE_DEG {
                failures.push(format!("{name} at {}: {deg:.3e} degrees", t.jd_tdb()));
            }
        }
    }
    assert!(count >= 60, "{count}");
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn the_earths_rotation_agrees_with_erfa() {
    let mut count = 0;
    for epoch in reference()["epochs"].as_array().expect("epochs") {
        let Some(earth) = epoch.get("earth_erfa") else { continue };
        let t = Instant::from_jd_tdb(number(&epoch["jd_tdb"]));
        // Frame bias, precession and nutation.
        let bpn = orientation::true_of_date_from_gcrs(t);
        assert!(rotation_between_deg(&bpn, &matrix(&earth["bpn_gcrs_to_true_of_date"])) < EARTH_TOLERANCE_DEG, "{}", t.jd_tdb());
        // The program's Delta T differs from the reference's: a rotation about the pole by 15 arcsec per second of time.
        let itrs_from_gcrs = orientation::earth_itrs_from_gcrs(t);
        let delta_t_s = (t.jd_tt() - t.jd_ut1()) * 86_400.0;
        let delta_t_difference_s = delta_t_s - number(&earth["assumed_delta_t_tt_minus_ut1_s"]);
        let to_assumed_delta_t = DMat3::from_rotation_z(-(delta_t_difference_s * 360.985_647 / 86_400.0).to_radians());
        let deg = rotation_between_deg(&(to_assumed_delta_t * itrs_from_gcrs), &matrix(&earth["gcrs_to_itrs_no_polar_motion"]));
        // A Julian date in a single f64 has a resolution of 40 microseconds, 1.7e-7 degrees of rotation.
        assert!(deg < EARTH_TOLERANCE_DEG, "{}: {deg:.3e} degrees, Delta T {delta_t_s}", t.jd_tdb());
        count += 1;
    }
    assert!(count >= 3, "{count}");
}

/// Planetocentric east longitude and latitude of a direction, degrees.
fn lon_lat(v: DVec3) -> (f64, f64) {
    (v.y.atan2(v.x).to_degrees().rem_euclid(360.0), v.z.atan2(v.truncate().length()).to_degrees())
}

/// Arc between two points of a sphere, degrees.
fn arc_deg(a: (f64, f64), b: (f64, f64)) -> f64 {
    let unit = |(lon, lat): (f64, f64)| {
        let (lon, lat) = (lon.to_radians(), lat.to_radians());
        DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
    };
    let (a, b) = (unit(a), unit(b));
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[test]
fn sub_points_with_light_time_agree_with_cspice() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped data reads");
    let (mut count, mut failures) = (0, Vec::new());
    for date in reference()["sub_points_dates"].as_array().expect("dates") {
        let t = Instant::from_jd_tdb(number(&date["jd_tdb"]));
        let position_km = |id, t| ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, t, None).expect("a state").state.pos_km;
        let earth = position_km(NaifId::EARTH, t);
        for (name, body) in date["bodies"].as_object().expect("bodies") {
            let id = id_of(name);
            let expected = &body["light_time"];
            let (pos, emitted) = ephemeris.light_time_position(id, earth, t).expect("light time");
            let pck = orientation::Pck::parse(orientation::EMBEDDED_PCK).expect("reads");
            let body_from_icrf = pck.pole_and_meridian(id, emitted.tdb_seconds_past_j2000()).expect("the PCK has it").body_from_icrf();
            let (sun, _) = ephemeris.light_time_position(NaifId::SUN, pos, emitted).expect("light time");
            for (point, direction, lon, lat) in [
                ("sub-earth", earth - pos, "sub_earth_lon_east_deg", "sub_earth_lat_centric_deg"),
                ("sub-solar", sun - pos, "sub_solar_lon_east_deg", "sub_solar_lat_centric_deg"),
            ] {
                let deg = arc_deg(lon_lat(body_from_icrf * direction), (number(&expected[lon]), number(&expected[lat])));
                count += 1;
                if deg > SUB_POINT_DEG {
                    failures.push(format!("{name} {point} at {}: {deg:.2e} degrees", t.jd_tdb()));
                }
            }
        }
    }
    assert!(count >= 40, "{count}");
    assert!(failures.is_empty(), "{failures:#?}");
}

/// The IAU's rates of some small moons are not those of their orbits: by how much the longitude below Saturn drifts in ten years, as docs/accuracy.md says.
/// Telesto, which does not drift, is the control.
#[test]
fn small_moons_drift_against_saturn_as_documented() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped data reads");
    for (moon, deg_per_year) in [(612, -30.1), (614, 8.65), (618, -4.5), (615, 3.2), (616, -1.1), (617, -0.45), (613, 0.0)] {
        let longitude_deg = |years: f64| {
            let t = Instant::from_jd_tdb(2_451_545.0 + 365.25 * years);
            let to_saturn = ephemeris.state(NaifId(699), NaifId(moon), t, None).expect("a state").state.pos_km;
            lon_lat(ephemeris.body_from_icrf(NaifId(moon), t).expect("an orientation") * to_saturn).0
        };
        // Eccentric orbits sway by less than a degree.
        let error_deg = (longitude_deg(10.0) - longitude_deg(0.0) - 10.0 * deg_per_year + 180.0).rem_euclid(360.0) - 180.0;
        assert!(error_deg.abs() < 1.0, "{moon}: {error_deg} degrees from {deg_per_year} a year");
    }
}

#[test]
fn a_small_rotation_is_detected() {
    let small_rotation = DMat3::from_rotation_y(1e-6_f64.to_radians());
    assert!((rotation_between_deg(&small_rotation, &DMat3::IDENTITY) - 1e-6).abs() < 1e-12);
    assert!((arc_deg((359.9995, 0.0), (0.0005, 0.0)) - 0.001).abs() < 1e-9);
}
