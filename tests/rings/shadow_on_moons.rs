//! The shadow of rings on moons: the eclipse of Iapetus that Barnard observed in 1889, the agreement of image, `explain` and `probe`, and rings of a user's
//! catalog.

use crate::support::session::{SESSION, sources};
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::probe::Prober;
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::draw::BodyPart;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::scene::{Scene, bodies_seen_from};
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use serde_json::json;

const IAPETUS: NaifId = NaifId(608);

fn time(text: &str) -> Instant {
    Instant::parse(text).expect("a time")
}

fn minutes_between(from: Instant, to: Instant) -> f64 {
    (to.tdb_seconds_past_j2000() - from.tdb_seconds_past_j2000()) / 60.0
}

/// A catalog and its ephemeris.
fn sky_of(catalog: Catalog) -> (Catalog, Ephemeris) {
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    (catalog, ephemeris)
}

/// The built-in catalog with a file added.
fn sky_with(file: &str) -> (Catalog, Ephemeris) {
    sky_of(Catalog::with_files(&[("mine.toml".to_owned(), file.to_owned())]).unwrap_or_else(|e| panic!("{e}")))
}

/// Magnitude of a body from the Earth's centre; 99 without light.
fn magnitude((catalog, ephemeris): &(Catalog, Ephemeris), id: NaifId, time: Instant) -> f64 {
    let bodies = bodies_seen_from(catalog, ephemeris, Position::Centre(NaifId::EARTH), time).expect("placed");
    bodies.iter().find(|b| b.id == id).expect("in the catalog").magnitude.unwrap_or(99.0)
}

/// When a condition that holds at `from` and not at `to` ceases to hold, to a few seconds.
fn end_of(holds: impl Fn(Instant) -> bool, from: Instant, to: Instant) -> Instant {
    assert!(holds(from) && !holds(to));
    let (mut before, mut after) = (from, to);
    for _ in 0..10 {
        let middle = before.plus_seconds(30.0 * minutes_between(before, after));
        if holds(middle) { before = middle } else { after = middle }
    }
    after
}

/// Barnard at Lick Observatory, on the morning of 2 November 1889 (Monthly Notices 50, 107): Iapetus came out of the shadow of the globe, first seen at 5h25m
/// sidereal time (10:44 UT at a longitude of 121.64 degrees west), faintly; then it went through the shadow of the C ring, and vanished in that of the B ring.
/// He estimated its brightness for 2.6 hours (Bryan 2007, J. Astron. Hist. Heritage 10, 31), until 13:20 UT. Iapetus counts as seen here while it is less than
/// 2 magnitudes fainter than usual. At both ends it changes by a magnitude in 4 to 10 minutes, so the choice matters little. The tolerances are those of his
/// eye (he judged the first light to be that of Enceladus, which it has 9 minutes later), and of the positions (970 km, 5 minutes).
#[test]
fn iapetus_fades_in_the_shadow_of_the_rings_when_barnard_saw_it() {
    let sky = sky_of(Catalog::embedded());
    let iapetus = |time: Instant| magnitude(&sky, IAPETUS, time);
    // Between the globe's shadow and the rings'.
    let undimmed = iapetus(time("1889-11-02T11:20:00Z"));
    let is_seen = |time: Instant| iapetus(time) < undimmed + 2.0;
    let reappeared = end_of(|time| !is_seen(time), time("1889-11-02T10:30:00Z"), time("1889-11-02T11:15:00Z"));
    let late_min = minutes_between(time("1889-11-02T10:44:00Z"), reappeared);
    let vanished = end_of(is_seen, time("1889-11-02T12:30:00Z"), time("1889-11-02T14:00:00Z"));
    let vanished_late_min = minutes_between(time("1889-11-02T13:20:00Z"), vanished);
    println!("reappears {late_min:.1} min after Barnard saw it, vanishes {vanished_late_min:.1} min after his last estimate");
    assert!(late_min.abs() < 8.0, "{late_min}");
    assert!(vanished_late_min.abs() < 10.0, "{vanished_late_min}");
    // The C ring is translucent.
    let [before_rings, behind_c_ring] = ["1889-11-02T11:30:00Z", "1889-11-02T12:20:00Z"].map(|text| iapetus(time(text)) - undimmed);
    assert!(before_rings.abs() < 0.03 && (0.25..0.7).contains(&behind_c_ring), "{before_rings}, {behind_c_ring}");
    // Negative control: without rings Iapetus keeps its light.
    let bare = sky_with("[[ring]]\nbody = \"Saturn\"\nname = \"none\"\ninner_km = 7e4\nouter_km = 8e4\ntau_normal = 0.0\n");
    let without_rings = ["1889-11-02T12:20:00Z", "1889-11-02T13:30:00Z"].map(|text| magnitude(&bare, IAPETUS, time(text)) - undimmed);
    assert!(without_rings.iter().all(|fading| fading.abs() < 0.03), "{without_rings:?}");
}

/// When light from Iapetus in the shadow of the C ring left it, as Barnard saw it at 12:30.
const BEHIND_C_RING: &str = "1889-11-02T11:10:00Z";

/// A view of Iapetus in the shadow of the C ring, as a disc or as a point.
fn scene(distance_radii: f64, stops: f64, effects: &str) -> Scene {
    let request = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
        fov_deg: Some(20.0),
        width: 64,
        height: 64,
        exposure: ExposureRequest::Stops(stops),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(IAPETUS, time(BEHIND_C_RING))
    };
    SESSION.scene(&request).expect("a scene")
}

/// The sunlight of the drawn disc, and the light of the point.
fn light(scene: &Scene) -> [Option<f64>; 2] {
    let globe = scene.draws.iter().find(|d| d.body == IAPETUS && d.part == BodyPart::Globe);
    let point = scene.points.iter().find(|p| p.body == IAPETUS);
    [globe.map(|d| f64::from(d.uniforms.lights[0].irradiance.y)), point.map(|p| f64::from(p.flux.y))]
}

fn by_rings(scene: &Scene) -> (bool, String) {
    let decisions = &scene.body(IAPETUS).expect("Iapetus").decisions;
    let found: Vec<_> = decisions.iter().filter(|d| d.effect == "eclipse-by-rings").collect();
    assert_eq!(found.len(), 1, "decided once");
    (found[0].on, found[0].reason.to_string())
}

/// Disc, point, magnitude, `explain` and `probe` have the same factor. Without the effect `eclipse`, images lack the shadow; the magnitude keeps it.
#[test]
fn disc_point_magnitude_explain_and_probe_agree() {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let query = json!({ "q": "sunlight", "body": "iapetus", "time": BEHIND_C_RING, "lat": 0.0, "lon": 0.0 });
    let answer = Prober { session: &SESSION, renderer: &renderer }.answer(&query.to_string()).expect("answers");
    let fraction = answer["fraction"].as_f64().expect("a number");
    assert!((0.5..0.8).contains(&fraction), "{answer}");
    assert!((answer["by"]["saturn rings"].as_f64().expect("by rings") - (1.0 - fraction)).abs() < 1e-6, "{answer}");
    // A disc of about 60 pixels, too dark to have glare, and a point of a fifth of a pixel, which is exposed longer to be visible.
    for (kind, distance_radii, stops) in [(0, 6.0, 0.0), (1, 2000.0, 8.0)] {
        let [with, without] = ["-planet-shine", "-planet-shine,-eclipse"].map(|effects| scene(distance_radii, stops, effects));
        let [dimmed, full] = [&with, &without].map(|scene| light(scene)[kind].expect("drawn"));
        assert!((dimmed / full - fraction).abs() < 2e-3, "{dimmed} of {full}, not {fraction}");
        let (is_on, reason) = by_rings(&with);
        assert!(is_on && reason.contains("Saturn"), "{reason}");
        let stated: f64 = reason.split(' ').find_map(|word| word.parse().ok()).expect("a number");
        assert!((stated - fraction).abs() < 2e-3, "{reason}");
        assert!(!by_rings(&without).0);
        let [of_dimmed, of_full] = [&with, &without].map(|scene| scene.body(IAPETUS).and_then(|b| b.magnitude).expect("lit"));
        assert!((of_dimmed - of_full).abs() < 1e-9, "{of_dimmed}, {of_full}");
    }
}

/// A ring around the Earth, out to three quarters of the Moon's distance: at the full Moon of June 2024 sunlight, 23.4 degrees above the equator, passes it on
/// the way to the Moon, and is dimmed by the optical depth over the sine of that angle. The new Moon is on the near side of the ring.
#[test]
fn rings_of_a_users_catalog_dim_the_moon() {
    const OPTICAL_DEPTH: f64 = 0.5;
    let ring = format!("[[ring]]\nbody = \"Earth\"\nname = \"x\"\ninner_km = 7e3\nouter_km = 3e5\ntau_normal = {OPTICAL_DEPTH}\n");
    let (ringed, bare) = (sky_with(&ring), sky_of(Catalog::embedded()));
    let fading = |text: &str| magnitude(&ringed, NaifId::MOON, time(text)) - magnitude(&bare, NaifId::MOON, time(text));
    let expected = 2.5 * std::f64::consts::LOG10_E * OPTICAL_DEPTH / 23.43_f64.to_radians().sin();
    let full = fading("2024-06-22T01:00:00Z");
    assert!((full - expected).abs() < 0.03, "{full}, not {expected}");
    assert!(fading("2024-06-06T18:00:00Z").abs() < 1e-9);
}

/// The Moon two days before the full Moon, in the shadow of a ring around the Earth that leaves 0.28 of the sunlight, in a catalog with more entries. Returns
/// the decisions about the Moon: effect, whether it is on, and the reason.
fn decisions_in_ring_shadow(entries: &str, position: Position, effects: &str) -> Vec<(&'static str, bool, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let ring = "[[ring]]\nbody = \"Earth\"\nname = \"x\"\ninner_km = 7e3\nouter_km = 3e5\ntau_normal = 0.5\n";
    std::fs::write(folder.path().join("mine.toml"), format!("{ring}{entries}")).expect("written");
    let sources = Sources { catalogs: Some(folder.path().to_owned()), ..sources() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
    let request = ViewRequest {
        position,
        fov_deg: Some(40.0),
        width: 64,
        height: 64,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId::MOON, time("2024-06-20T01:00:00Z"))
    };
    let scene = session.scene(&request).expect("a scene");
    let moon = scene.body(NaifId::MOON).expect("the Moon");
    moon.decisions.iter().map(|d| (d.effect, d.on, d.reason.to_string())).collect()
}

/// Of ring-shine and planet-shine, which no shader has together, the stronger is drawn. The Moon's own ring gives it 1.8 times as much light as the Earth, or
/// half as much, because its light is sunlight that the Earth's ring dims. Negative control: without the shadow ring-shine is drawn.
#[test]
fn the_stronger_light_is_that_of_dimmed_sunlight() {
    let own_ring = "[[ring]]\nbody = \"Moon\"\nname = \"y\"\ninner_km = 2e3\nouter_km = 5e3\ntau_normal = 1.8e-5\n";
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(6.0) };
    for (effects, left_out, other) in
        [("+planet-shine,+ring-shine", "ring-shine", "planet-shine"), ("+planet-shine,+ring-shine,-eclipse", "planet-shine", "ring-shine")]
    {
        let decisions = decisions_in_ring_shadow(own_ring, position, effects);
        let is_left_out = |effect: &str| decisions.iter().any(|(name, on, _)| *name == effect && !on);
        assert!(is_left_out(left_out) && !is_left_out(other), "{effects}: {decisions:?}");
    }
}

/// Light of the Earth in the air of the Moon, relative to sunlight: 3.5 times as much if the Earth's ring dims sunlight to 0.28.
#[test]
fn planet_shine_in_air_is_compared_with_dimmed_sunlight() {
    let air = "[[atmosphere]]\nbody = \"Moon\"\ntop_km = 50.0\nsource = \"a test\"\n[[atmosphere.species]]\nname = \"gas\"\n\
               scattering_per_km = [0.01, 0.01, 0.01]\nabsorption_per_km = [0.0, 0.0, 0.0]\nscale_height_km = 8.0\n";
    let position = Position::Ground { body: NaifId::MOON, latitude_deg: 0.0, longitude_deg: 0.0, height_km: 0.0017 };
    let part = |effects: &str| -> f64 {
        let decisions = decisions_in_ring_shadow(air, position, effects);
        let (.., reason) = decisions.iter().find(|(name, ..)| *name == "planet-shine-in-air").expect("decided");
        reason.split(' ').find_map(|word| word.parse().ok()).expect("a number")
    };
    let (dimmed, undimmed) = (part("+planet-shine"), part("+planet-shine,-eclipse"));
    // The numbers have two digits.
    assert!((dimmed / undimmed * 0.2846 - 1.0).abs() < 0.1, "{dimmed}, {undimmed} in undimmed sunlight");
}
