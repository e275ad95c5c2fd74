//! Scenes of the real sky: the visible hemisphere of bodies, what is drawn and why, and requests that must be refused.

use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::scene::request::{Axes, CameraFile, Look, Position, ViewRequest};
use orrery::scene::{Appearance, Caches, Resources, Scene, SceneBuilder, bodies_seen_from};
use orrery::session::standard_scenes;
use orrery::time::Instant;
use orrery::units::SPEED_OF_LIGHT_KM_S;
use std::collections::BTreeSet;

fn sky() -> (Catalog, Ephemeris) {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    (catalog, ephemeris)
}

fn parse_time(text: &str) -> Instant {
    Instant::parse(text).expect("a time")
}

fn longitude_difference_deg(a: f64, b: f64) -> f64 {
    (a - b + 540.0).rem_euclid(360.0) - 180.0
}

fn reference() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/rotation_public.json")).expect("the table is JSON")
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Largest allowed error of a sub-point, in degrees.
const SUB_POINT_TOLERANCE_DEG: f64 = 0.01;

/// Largest allowed error of the Sun's altitude, in degrees: more than the Sun's parallax, which the test neglects.
const SUN_ALTITUDE_TOLERANCE_DEG: f64 = 0.005;

/// Altitude of a point of the sky by spherical trigonometry: latitude of the place's vertical, declination and hour angle, degrees.
fn altitude_deg(latitude_deg: f64, declination_deg: f64, hour_angle_deg: f64) -> f64 {
    let ((sin_lat, cos_lat), (sin_dec, cos_dec)) = (latitude_deg.to_radians().sin_cos(), declination_deg.to_radians().sin_cos());
    (sin_lat * sin_dec + cos_lat * cos_dec * hour_angle_deg.to_radians().cos()).asin().to_degrees()
}

#[test]
fn bodies_show_the_hemisphere_seen_with_light_time() {
    let (catalog, ephemeris) = sky();
    let (mut count, mut wrong_verticals_detected, mut largest_altitude_error_deg) = (0, 0, 0.0_f64);
    for date in reference()["sub_points_dates"].as_array().expect("dates") {
        for (name, id) in [("mars", 499), ("jupiter", 599), ("saturn", 699), ("moon", 301)] {
            let expected = &date["bodies"][name]["light_time"];
            let field = |name: &str| number(&expected[name]);
            let viewer_point = [field("sub_earth_lon_east_deg"), field("sub_earth_lat_centric_deg")];
            let sun_point = [field("sub_solar_lon_east_deg"), field("sub_solar_lat_centric_deg")];
            let mut request = ViewRequest::of(NaifId(id), Instant::from_jd_tdb(number(&date["jd_tdb"])));
            request.position = Position::Centre(NaifId::EARTH);
            let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
            let body = scene.body(NaifId(id)).expect("in the catalog");
            let solar = body.sub_solar.expect("lit by the Sun");
            for (computed, reference) in [(body.sub_observer, viewer_point), (solar, sun_point)] {
                let error_deg = longitude_difference_deg(computed.lon_east_deg, reference[0])
                    .abs()
                    .max((computed.lat_centric_deg - reference[1]).abs());
                assert!(error_deg < SUB_POINT_TOLERANCE_DEG, "{name} {}: {computed:?} against {reference:?}", date["label"]);
                // The two points must differ, so that a mix-up would fail.
                let other = if reference == sun_point { viewer_point } else { sun_point };
                assert!(
                    longitude_difference_deg(computed.lon_east_deg, other[0]).abs() > SUB_POINT_TOLERANCE_DEG,
                    "{name} {}",
                    date["label"]
                );
            }
            // The vertical at the sub-Earth point is that of its planetographic latitude.
            let axes_squared = (body.placement.radii_km.x / body.placement.radii_km.z).powi(2);
            let lat_graphic_deg = (axes_squared * viewer_point[1].to_radians().tan()).atan().to_degrees();
            let sun_altitude_deg = body.sun_altitude_deg.expect("lit by the Sun");
            let error_deg =
                |latitude_deg| (sun_altitude_deg - altitude_deg(latitude_deg, sun_point[1], viewer_point[0] - sun_point[0])).abs();
            assert!(error_deg(lat_graphic_deg) < SUN_ALTITUDE_TOLERANCE_DEG, "{name} {}: {sun_altitude_deg}", date["label"]);
            largest_altitude_error_deg = largest_altitude_error_deg.max(error_deg(lat_graphic_deg));
            wrong_verticals_detected += usize::from(error_deg(viewer_point[1]) > SUN_ALTITUDE_TOLERANCE_DEG);
            // The pixel in the middle shows the sub-Earth point, whatever the aberration.
            let centre = glam::DVec2::new(512.0, 512.0);
            let hit = scene.camera.surface_under_pixel(&body.placement, centre).expect("the body fills the middle");
            let middle_point = orrery::scene::SubPoint::of(hit * body.placement.radii_km);
            assert!(
                longitude_difference_deg(middle_point.lon_east_deg, viewer_point[0]).abs() < 0.3,
                "{name}: the middle of the image is at {middle_point:?}"
            );
            count += 1;
        }
    }
    println!("largest error of the Sun's altitude: {largest_altitude_error_deg:.4} degrees");
    assert_eq!(count, 24);
    assert!(wrong_verticals_detected >= 6, "{wrong_verticals_detected} of the altitudes over the wrong horizon");
}

/// The Earth's sub-solar and sub-lunar points, from ERFA's matrices and this program's positions, which other tests compare with DE440.
#[test]
fn the_earths_sub_points_follow_its_true_rotation() {
    use glam::{DMat3, DVec3};
    /// Rotation of the Earth per second, in degrees.
    const EARTH_ROTATION_DEG_S: f64 = 360.985_647 / 86_400.0;
    let (catalog, ephemeris) = sky();
    let mut count = 0;
    for epoch in reference()["epochs"].as_array().expect("epochs") {
        let Some(earth) = epoch.get("earth_erfa") else { continue };
        let time = Instant::from_jd_tdb(number(&epoch["jd_tdb"]));
        let rows = earth["gcrs_to_itrs_no_polar_motion"].as_array().expect("rows");
        let row = |i: usize| DVec3::from_array([0, 1, 2].map(|k| number(&rows[i][k])));
        let itrs_from_gcrs = DMat3::from_cols(row(0), row(1), row(2)).transpose();
        // The table assumes its own Delta T: the Earth turns by the difference.
        let delta_t_difference_s = (time.jd_tt() - time.jd_ut1()) * 86_400.0 - number(&earth["assumed_delta_t_tt_minus_ut1_s"]);
        let bodies = bodies_seen_from(&catalog, &ephemeris, Position::Centre(NaifId::MOON), time).expect("placed");
        let body = bodies.iter().find(|body| body.id == NaifId::EARTH).expect("the Earth");
        let light_s = body.distance_km / SPEED_OF_LIGHT_KM_S;
        // The light that is seen left the Earth one light time ago; the sunlight that illuminated the Earth then had left the Sun
        // earlier.
        let position_at = |id: NaifId, seconds: f64| {
            ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, time.plus_seconds(seconds), None).expect("a state").state.pos_km
        };
        let from_earth = position_at(NaifId::EARTH, -light_s);
        let sun_light_s = (position_at(NaifId::SUN, -light_s) - from_earth).length() / SPEED_OF_LIGHT_KM_S;
        let to_sun = position_at(NaifId::SUN, -light_s - sun_light_s) - from_earth;
        let to_moon = position_at(NaifId::MOON, 0.0) - from_earth;
        for (name, computed, direction) in [("viewer", body.sub_observer, to_moon), ("Sun", body.sub_solar.expect("lit"), to_sun)] {
            let v = itrs_from_gcrs * direction;
            let longitude_deg = v.y.atan2(v.x).to_degrees() + (light_s + delta_t_difference_s) * EARTH_ROTATION_DEG_S;
            let latitude_deg = v.z.atan2(v.truncate().length()).to_degrees();
            let error_deg =
                longitude_difference_deg(computed.lon_east_deg, longitude_deg).abs().max((computed.lat_centric_deg - latitude_deg).abs());
            assert!(error_deg < SUB_POINT_TOLERANCE_DEG, "{} {name}: {computed:?} against {longitude_deg} {latitude_deg}", time.jd_tdb());
            // An error of four seconds of rotation would be detected.
            assert!(
                longitude_difference_deg(computed.lon_east_deg, longitude_deg + 4.0 * EARTH_ROTATION_DEG_S).abs() > SUB_POINT_TOLERANCE_DEG
            );
        }
        count += 1;
    }
    assert!(count >= 3, "{count}");
}

#[test]
fn a_viewer_on_the_ground_stands_on_it() {
    let (catalog, ephemeris) = sky();
    for height_km in [0.001, 0.0017, 1.0, 400.0] {
        let mut request = ViewRequest::of(NaifId::MOON, parse_time("2024-04-12T20:00:00Z"));
        request.position = Position::Ground { body: NaifId::EARTH, latitude_deg: 51.5, longitude_deg: -0.1, height_km };
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let earth = scene.body(NaifId::EARTH).expect("the Earth");
        let placement = &earth.placement;
        let camera = placement.camera_in_unit_sphere();
        // Height from the gradient of the ellipsoid's equation: exact to the ratio of height to radius.
        let height = (camera.length_squared() - 1.0) / (2.0 * (camera / placement.radii_km).length());
        assert!((height / height_km - 1.0).abs() < 0.05, "{height} km against {height_km}");
    }
}

/// On the Moon's ground, looking at the Earth 45 degrees up: the ground below the frame is neither drawn nor metered.
#[test]
fn ground_below_the_frame_is_neither_drawn_nor_metered() {
    let (catalog, ephemeris) = sky();
    let mut request = ViewRequest::of(NaifId::EARTH, parse_time("2024-04-12T20:00:00Z"));
    request.position = Position::Ground { body: NaifId::MOON, latitude_deg: 45.0, longitude_deg: 0.0, height_km: 0.002 };
    let mut scene_towards_earth = |fov_deg: f64, target: Option<NaifId>| {
        // Look in a direction instead of at a target: without a target, the meter uses whatever fills the frame.
        let towards_earth = Scene::build(&catalog, &ephemeris, &ViewRequest { target: Some(NaifId::EARTH), ..request.clone() });
        let direction = towards_earth.expect("a scene").body(NaifId::EARTH).expect("the Earth").placement.centre_km.normalize();
        request.fov_deg = Some(fov_deg);
        request.look = Look::Along { direction, axes: Axes::Icrf };
        Scene::build(&catalog, &ephemeris, &ViewRequest { target, ..request.clone() }).expect("a scene")
    };
    let narrow = scene_towards_earth(20.0, None);
    assert_eq!(narrow.body(NaifId::MOON).expect("the Moon").appearance, Appearance::NotShown);
    assert!(
        narrow.draws.iter().all(|d| d.body != NaifId::MOON) && narrow.exposure.reason.to_string().starts_with("Earth"),
        "{}",
        narrow.exposure.reason
    );
    let wide = scene_towards_earth(120.0, None);
    assert_eq!(wide.body(NaifId::MOON).expect("the Moon").appearance, Appearance::Disc);
    // The ground is in the lunar night, lit by the Earth alone; the Earth is metered.
    assert!(wide.exposure.reason.to_string().starts_with("Earth"), "{}", wide.exposure.reason);
}

#[test]
fn a_small_body_is_a_point_and_a_nearby_body_is_a_disc() {
    let (catalog, ephemeris) = sky();
    let jupiter = NaifId(599);
    for (fov_deg, appearance) in [(60.0, Appearance::Point), (0.02, Appearance::Disc)] {
        let mut request = ViewRequest::of(jupiter, parse_time("2024-12-07T20:00:00Z"));
        request.position = Position::Centre(NaifId::EARTH);
        request.fov_deg = Some(fov_deg);
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let body = scene.body(jupiter).expect("Jupiter");
        assert_eq!(body.appearance, appearance);
        // Almanacs give Jupiter V -2.8 at that opposition.
        assert!((body.magnitude.expect("it shines") + 2.8).abs() < 0.2, "{:?}", body.magnitude);
        // Far bodies are drawn first.
        assert!(scene.draws.windows(2).all(|w| {
            let distance = |k: usize| scene.body(w[k].body).map_or(0.0, |b| b.distance_km);
            distance(0) >= distance(1)
        }));
    }
}

#[test]
fn every_decision_has_a_reason_and_city_lights_need_a_long_exposure() {
    let (catalog, ephemeris) = sky();
    let mut request = ViewRequest::of(NaifId::EARTH, parse_time("2024-04-08T18:17:16Z"));
    let night_decision = |request: &ViewRequest| {
        let scene = Scene::build(&catalog, &ephemeris, request).expect("a scene");
        let earth = scene.body(NaifId::EARTH).expect("the Earth").clone();
        assert!(earth.decisions.iter().all(|d| !d.reason.to_string().is_empty()));
        earth.decisions.into_iter().find(|d| d.effect == "night").expect("decided")
    };
    assert!(!night_decision(&request).on);
    request.exposure = orrery::scene::request::ExposureRequest::Stops(10.0);
    assert!(night_decision(&request).on);
    request.effects = orrery::scene::effects::EffectOverrides::parse("-night").expect("an effect");
    let switched_off = night_decision(&request);
    assert_eq!((switched_off.on, &*switched_off.reason.to_string()), (false, "set by you"));
}

#[test]
fn impossible_camera_values_are_refused_by_name() {
    let (catalog, ephemeris) = sky();
    let refused = |change: &dyn Fn(&mut ViewRequest)| {
        let mut request = ViewRequest::of(NaifId::EARTH, parse_time("2024-04-08T18:17:16Z"));
        change(&mut request);
        Scene::build(&catalog, &ephemeris, &request).expect_err("refused").to_string()
    };
    assert!(refused(&|r| r.width = 0).contains("size 0x1024"));
    assert!(refused(&|r| r.fov_deg = Some(180.0)).contains("field of view 180"));
    assert!(refused(&|r| r.fov_deg = Some(f64::NAN)).contains("field of view"));
    assert!(refused(&|r| r.position = Position::AboveTarget { towards: None, distance_radii: Some(0.5) }).contains("inside Earth"));
    assert!(refused(&|r| r.position = Position::Centre(NaifId::EARTH)).contains("centre"));
    let file = |text: &str| {
        let mut request = ViewRequest::of(NaifId::EARTH, parse_time("2024-04-08T18:17:16Z"));
        CameraFile::parse("c.json", text).and_then(|c| c.resolve(&catalog, &mut request)).expect_err("refused").to_string()
    };
    assert!(file("{").contains("c.json:1:"));
    assert!(file(r#"{"position":{"body":"vulcan","radii":[2,0,0]},"look":{"at":"sun"}}"#).contains("vulcan"));
    assert!(file(r#"{"position":{"body":"earth"},"look":{"at":"sun"}}"#).contains("radii, km, or latitude_deg"));
    for offset in [r#""radii":[2,0,0]"#, r#""km":[9000,0,0]"#] {
        let with_height = format!(r#"{{"position":{{"body":"earth",{offset},"height_km":5}},"look":{{"at":"sun"}}}}"#);
        assert!(file(&with_height).contains("height_km only with"), "{offset}");
    }
    assert!(file(r#"{"position":{"body":"earth","radii":[2,0,0]},"look":{"direction":[0,0,0]}}"#).contains("must not be zero"));
    assert!(file(r#"{"position":{"body":"earth","radii":[2,0,0],"tilt":3},"look":{"at":"sun"}}"#).contains("tilt"));
}

/// The camera's distance and the bodies' light times must not appear in the message.
#[test]
fn a_refused_time_is_reported_as_it_was_given() {
    let (catalog, ephemeris) = sky();
    let refused = |request: &ViewRequest| Scene::build(&catalog, &ephemeris, request).expect_err("refused").to_string();
    let offset = |body| Position::Offset { body, offset_km: glam::DVec3::new(1e6, 2e6, 3e6), axes: Axes::Icrf };
    let positions = [
        Position::AboveTarget { towards: None, distance_radii: None },
        Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(1e5) },
        Position::Centre(NaifId::EARTH),
        Position::Ground { body: NaifId::MOON, latitude_deg: 10.0, longitude_deg: 20.0, height_km: 1.0 },
        offset(NaifId(499)),
    ];
    for time in ["-3001-01-01T00:00:00Z", "-3500-06-15T12:00:00.500Z", "3001-02-01T00:00:00Z", "9999-12-31T00:00:00Z"] {
        for (target, position) in [301, 599, 899].into_iter().flat_map(|id| positions.map(|position| (NaifId(id), position))) {
            let message = refused(&ViewRequest { position, ..ViewRequest::of(target, parse_time(time)) });
            assert!(message.contains(&format!("not at {time};")) && !message.contains("light"), "{position:?}: {message}");
        }
    }
    // Light from Neptune takes four hours. Light that arrives just after the start of Neptune's positions left before that start.
    let first = ephemeris.state(NaifId(899), NaifId::SUN, parse_time("-3001-11-24T00:00:00Z"), None);
    assert!(first.is_ok(), "{first:?}");
    let mut start = (parse_time("-3001-11-20T00:00:00Z"), parse_time("-3001-11-24T00:00:00Z"));
    for _ in 0..40 {
        let half_s = 0.5 * (start.1.tdb_seconds_past_j2000() - start.0.tdb_seconds_past_j2000());
        let middle = start.0.plus_seconds(half_s);
        let is_covered = ephemeris.state(NaifId(899), NaifId::SUN, middle, None).is_ok();
        start = if is_covered { (start.0, middle) } else { (middle, start.1) };
    }
    let request = ViewRequest { position: Position::Centre(NaifId::EARTH), ..ViewRequest::of(NaifId(899), start.1.plus_seconds(60.0)) };
    let message = refused(&request);
    assert!(message.contains("the light that arrives at the given time left then"), "{message}");
    let later = ViewRequest { time: start.1.plus_seconds(86_400.0), ..request };
    assert!(Scene::build(&catalog, &ephemeris, &later).is_ok());
}

#[test]
fn the_requirements_of_a_view_cover_everything_it_draws() {
    let (catalog, ephemeris) = sky();
    let caches = Caches::default();
    let total_eclipse = ViewRequest::of(NaifId::EARTH, parse_time("2024-04-08T18:17:16Z"));
    let beside_saturn = ViewRequest { fov_deg: Some(20.0), ..ViewRequest::of(NaifId(606), parse_time("2024-12-07T20:00:00Z")) };
    let requests = standard_scenes(640, 360).into_iter().map(|s| s.request).chain([total_eclipse, beside_saturn]);
    let (mut maps, mut tables) = (0, 0);
    for request in requests {
        let builder = SceneBuilder::new(&catalog, &ephemeris, &request, &caches).expect("a view");
        let required = builder.requirements(&Resources::default());
        let scene = builder.build(&Resources::default());
        let required_files: BTreeSet<&str> = required.maps.iter().flat_map(|(files, _)| files.by_role().map(|(_, file)| file)).collect();
        let drawn_files: BTreeSet<&str> = scene.draws.iter().flat_map(|d| d.map_files.by_role().map(|(_, file)| file)).collect();
        assert!(drawn_files.is_subset(&required_files), "{drawn_files:?} of {required_files:?}");
        // No table is loaded: each effect that lacks its table reports that.
        let lacks_table = |b: &&orrery::scene::BodyReport| b.decisions.iter().any(|d| d.reason.to_string().ends_with("is not available"));
        let lacking: Vec<NaifId> = scene.bodies.iter().filter(lacks_table).map(|b| b.id).collect();
        assert!(lacking.iter().all(|id| required.scattering_tables.contains(id)), "{lacking:?} of {:?}", required.scattering_tables);
        (maps, tables) = (maps + drawn_files.len(), tables + lacking.len());
    }
    assert!(maps > 5 && tables > 1, "{maps} maps and {tables} tables");
}
