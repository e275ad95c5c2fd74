//! Sunlight by `probe` in transits that darken the ground less than an image can show: Mercury from the Earth, the Earth and the Moon from Mars.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::probe::Prober;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::time::Instant;
use serde_json::{Value, json};

/// Latitude and longitude of the place, degrees.
const PLACE_DEG: [f64; 2] = [-30.0, -70.0];

/// The answer of `probe` for a body's name and a time.
fn sunlight(receiver: &str, time: &str) -> Value {
    let renderer = SoftwareRenderer::new(Options { precision: Precision::F64, ..Options::default() }).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let [lat, lon] = PLACE_DEG;
    let query = json!({ "q": "sunlight", "body": receiver, "time": time, "lat": lat, "lon": lon });
    prober.answer(&query.to_string()).expect("answers")
}

/// The fraction that a small disc within the Sun's disc blocks: its share of the Sun's area, times the radiance there relative to the mean, with the query's
/// law of limb darkening. From the apparent directions at the place.
fn blocked_by_geometry(receiver: NaifId, transiting: NaifId, time: &str) -> f64 {
    let (catalog, ephemeris) = (SESSION.catalog(), SESSION.ephemeris());
    let time = Instant::parse(time).expect("a time");
    let radii_km = |id: NaifId| catalog.body(id).expect("in the catalog").radii_km;
    let centre_km = ephemeris.state(receiver, NaifId::SOLAR_SYSTEM_BARYCENTER, time, None).expect("a place").state.pos_km;
    let icrf_from_body = ephemeris.body_from_icrf(receiver, time).expect("an orientation").transpose();
    let [lat, lon] = PLACE_DEG;
    let place_km = centre_km + icrf_from_body * ground_point_km(radii_km(receiver), lat, lon, 0.0).0;
    let towards = |id: NaifId| ephemeris.light_time_position(id, place_km, time).expect("a place").0 - place_km;
    let (to_sun, to_transiting) = (towards(NaifId::SUN), towards(transiting));
    let angular_radius = |id: NaifId, distance_km: f64| (radii_km(id).x / distance_km).asin();
    let sun_rad = angular_radius(NaifId::SUN, to_sun.length());
    let radius = angular_radius(transiting, to_transiting.length()) / sun_rad;
    let distance = angle_rad(to_sun, to_transiting) / sun_rad;
    assert!(distance + radius < 1.0, "{transiting:?} is not within the Sun's disc: {distance}");
    let (u1, u2, mu) = (0.40, 0.26, (1.0 - distance * distance).sqrt());
    radius * radius * (1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2)) / (1.0 - u1 / 3.0 - u2 / 6.0)
}

#[test]
fn the_probe_counts_every_body_that_blocks_sunlight() {
    for (receiver, receiver_id, time, transiting) in [
        ("earth", NaifId::EARTH, "2019-11-11T15:19:37Z", &[("mercury", NaifId(199))][..]),
        ("mars", NaifId(499), "2084-11-10T08:00:00Z", &[("earth", NaifId::EARTH), ("moon", NaifId::MOON)][..]),
    ] {
        let answer = sunlight(receiver, time);
        for &(name, id) in transiting {
            let (blocked, reference) = (answer["by"][name].as_f64().unwrap_or(0.0), blocked_by_geometry(receiver_id, id, time));
            println!("{name} from {receiver}: {blocked:.3e}, by geometry {reference:.3e}");
            // Answers are f32 close to 1: steps of 6e-8, 0.2 % of what Mercury blocks.
            assert!((blocked / reference - 1.0).abs() < 0.01, "{name} from {receiver}: {blocked:e}, by geometry {reference:e}");
        }
        let sum: f64 = answer["by"].as_object().expect("bodies").values().filter_map(Value::as_f64).sum();
        let fraction = answer["fraction"].as_f64().expect("a fraction");
        assert!(fraction < 1.0 && (1.0 - sum - fraction).abs() < 1e-6, "{answer}");
    }
    // Before the transit, outside every penumbra: exactly 1.
    let before = sunlight("earth", "2019-11-11T10:00:00Z");
    assert_eq!((&before["by"], &before["fraction"]), (&json!({}), &json!(1.0)));
}
