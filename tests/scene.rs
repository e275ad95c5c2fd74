//! Scenes of the real sky: the face that a body shows, what is drawn and why, and requests that must be refused.

use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::scene::request::{CameraFile, Position, ViewRequest};
use orrery::scene::{Appearance, Scene};
use orrery::time::Instant;

fn sky() -> (Catalog, Ephemeris) {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    (catalog, ephemeris)
}

fn at(text: &str) -> Instant {
    Instant::parse(text).expect("a time")
}

fn apart_deg(a: f64, b: f64) -> f64 {
    (a - b + 540.0).rem_euclid(360.0) - 180.0
}

/// (time jd_tdb, body, sub-Earth east longitude and latitude, sub-solar east longitude and latitude): tests/data README, rotation.
const FACES: [(f64, i32, [f64; 4]); 3] = [
    (2_452_640.75, 499, [187.900_678_7, 13.624_199_0, 159.790_726_7, 22.379_783_4]),
    (2_452_640.75, 599, [166.328_275_6, 0.022_318_1, 160.007_862_6, 0.365_269_2]),
    (2_452_640.75, 699, [186.945_287_1, -26.659_708_6, 188.871_738_7, -26.704_465_9]),
];

#[test]
fn bodies_show_the_face_that_the_light_left() {
    let (catalog, ephemeris) = sky();
    for (jd_tdb, id, reference) in FACES {
        let mut request = ViewRequest::of(NaifId(id), Instant::from_jd_tdb(jd_tdb));
        request.position = Position::Centre(NaifId::EARTH);
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let body = scene.body(NaifId(id)).expect("in the catalog");
        let solar = body.sub_solar.expect("lit by the Sun");
        let ours = [body.sub_viewer.longitude_deg, body.sub_viewer.latitude_deg, solar.longitude_deg, solar.latitude_deg];
        for (ours, reference) in ours.iter().zip(reference) {
            assert!(apart_deg(*ours, reference).abs() < 0.01, "{id}: {ours} deg against {reference}");
        }
        // The pixel in the middle shows the sub-Earth point, aberration or not.
        let centre = glam::DVec2::new(512.0, 512.0);
        let hit = scene.camera.surface_under_pixel(&body.placement, centre).expect("the body fills the middle");
        let face = orrery::scene::SubPoint::of(hit * body.placement.radii_km);
        assert!(apart_deg(face.longitude_deg, reference[0]).abs() < 0.3, "{id}: the middle of the picture is at {face:?}");
    }
}

#[test]
fn a_viewer_on_the_ground_stands_on_it() {
    let (catalog, ephemeris) = sky();
    for height_km in [0.001, 0.0017, 1.0, 400.0] {
        let mut request = ViewRequest::of(NaifId::MOON, at("2024-04-12T20:00:00Z"));
        request.position = Position::Ground { body: NaifId::EARTH, latitude_deg: 51.5, longitude_deg: -0.1, height_km };
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let earth = scene.body(NaifId::EARTH).expect("the Earth");
        let place = &earth.placement;
        let c = place.camera_in_unit_sphere();
        // Height by the gradient of the ellipsoid's equation: exact to height over radius.
        let height = (c.length_squared() - 1.0) / (2.0 * (c / place.radii_km).length());
        assert!((height / height_km - 1.0).abs() < 0.05, "{height} km against {height_km}");
    }
}

#[test]
fn a_small_body_is_a_point_and_a_near_one_a_disc() {
    let (catalog, ephemeris) = sky();
    let jupiter = NaifId(599);
    for (fov_deg, appearance) in [(60.0, Appearance::Point), (0.02, Appearance::Disc)] {
        let mut request = ViewRequest::of(jupiter, at("2024-12-07T20:00:00Z"));
        request.position = Position::Centre(NaifId::EARTH);
        request.fov_deg = Some(fov_deg);
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let body = scene.body(jupiter).expect("Jupiter");
        assert_eq!(body.appearance, appearance);
        // The almanacs have Jupiter at V -2.8 at that opposition.
        assert!((body.magnitude.expect("it shines") + 2.8).abs() < 0.2, "{:?}", body.magnitude);
        assert!(scene.draws.windows(2).all(|w| {
            let distance = |k: usize| scene.body(w[k].body).map_or(0.0, |b| b.distance_km);
            distance(0) >= distance(1)
        }));
    }
}

#[test]
fn every_reason_is_given_and_lamps_wait_for_a_long_exposure() {
    let (catalog, ephemeris) = sky();
    let mut request = ViewRequest::of(NaifId::EARTH, at("2024-04-08T18:17:16Z"));
    let night = |request: &ViewRequest| {
        let scene = Scene::build(&catalog, &ephemeris, request).expect("a scene");
        let earth = scene.body(NaifId::EARTH).expect("the Earth").clone();
        assert!(earth.decisions.iter().all(|d| !d.reason.is_empty()));
        earth.decisions.into_iter().find(|d| d.feature == "night").expect("decided")
    };
    assert!(!night(&request).on);
    request.exposure = orrery::scene::request::ExposureRequest::Stops(10.0);
    assert!(night(&request).on);
    request.effects = orrery::scene::effects::EffectOverrides::parse("-night").expect("an effect");
    let asked = night(&request);
    assert_eq!((asked.on, asked.reason.as_str()), (false, "asked for"));
}

#[test]
fn what_no_camera_can_do_is_refused_by_name() {
    let (catalog, ephemeris) = sky();
    let refused = |change: &dyn Fn(&mut ViewRequest)| {
        let mut request = ViewRequest::of(NaifId::EARTH, at("2024-04-08T18:17:16Z"));
        change(&mut request);
        Scene::build(&catalog, &ephemeris, &request).expect_err("refused").to_string()
    };
    assert!(refused(&|r| r.width = 0).contains("size 0x1024"));
    assert!(refused(&|r| r.fov_deg = Some(180.0)).contains("field of view 180"));
    assert!(refused(&|r| r.fov_deg = Some(f64::NAN)).contains("field of view"));
    assert!(refused(&|r| r.position = Position::Over { towards: None, distance_radii: Some(0.5) }).contains("inside Earth"));
    assert!(refused(&|r| r.position = Position::Centre(NaifId::EARTH)).contains("centre"));
    let file = |text: &str| {
        let mut request = ViewRequest::of(NaifId::EARTH, at("2024-04-08T18:17:16Z"));
        CameraFile::parse("c.json", text).and_then(|c| c.resolve(&catalog, &mut request)).expect_err("refused").to_string()
    };
    assert!(file("{").contains("c.json") && file("{").contains("line 1"));
    assert!(file(r#"{"position":{"body":"vulcan","radii":[2,0,0]},"look":{"at":"sun"}}"#).contains("vulcan"));
    assert!(file(r#"{"position":{"body":"earth"},"look":{"at":"sun"}}"#).contains("radii, km, or latitude_deg"));
    assert!(file(r#"{"position":{"body":"earth","radii":[2,0,0]},"look":{"direction":[0,0,0]}}"#).contains("must not be zero"));
    assert!(file(r#"{"position":{"body":"earth","radii":[2,0,0],"tilt":3},"look":{"at":"sun"}}"#).contains("tilt"));
}
