//! The catalog's well-known moments show the events that they describe, according to the ephemeris.

use glam::DVec3;
use orrery::catalog::moments::{KINDS, Moment};
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, angle_rad};
use orrery::time::Instant;
use orrery::units::SPEED_OF_LIGHT_KM_S;

struct World {
    catalog: Catalog,
    ephemeris: Ephemeris,
}

impl World {
    fn new() -> Self {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        Self { catalog, ephemeris }
    }
    /// Vector from one body's centre to another's, with light time, km.
    fn apparent_km(&self, from: NaifId, to: NaifId, t: Instant) -> DVec3 {
        let viewer = self.ephemeris.state(from, NaifId::SOLAR_SYSTEM_BARYCENTER, t, None).expect("a place").state.pos_km;
        self.ephemeris.light_time_position(to, viewer, t).expect("a place").0 - viewer
    }
    fn radius_km(&self, id: NaifId) -> f64 {
        self.catalog.body(id).expect("a body").radii_km.x
    }
    /// Distance of the receiver's centre from the axis of the occluder's shadow, in the receiver's radii.
    fn shadow_axis_distance_radii(&self, occluder: NaifId, receiver: NaifId, t: Instant) -> f64 {
        let to_sun = self.apparent_km(receiver, NaifId::SUN, t);
        let to_occluder = self.apparent_km(receiver, occluder, t);
        let axis = (to_sun - to_occluder).normalize();
        to_occluder.cross(axis).length() / self.radius_km(receiver)
    }
}

fn of_kind<'a>(world: &'a World, kind: &'a str) -> impl Iterator<Item = &'a Moment> {
    world.catalog.moments().iter().filter(move |m| m.kind == kind)
}

#[test]
fn every_kind_has_moments_in_order_of_time() {
    let world = World::new();
    for kind in KINDS {
        let times: Vec<f64> = of_kind(&world, kind).map(|m| m.time.tdb_seconds_past_j2000()).collect();
        assert!(!times.is_empty(), "{kind}");
        assert!(times.is_sorted(), "{kind}");
    }
}

/// The axis of the Moon's shadow meets the Earth; half a day later it is far off.
#[test]
fn solar_eclipses_are_central_and_at_their_greatest() {
    let world = World::new();
    for m in of_kind(&world, "solar eclipse") {
        let distance = world.shadow_axis_distance_radii(NaifId::MOON, NaifId::EARTH, m.time);
        assert!(distance < 1.0, "{}: {distance} radii", m.name);
        assert!(world.shadow_axis_distance_radii(NaifId::MOON, NaifId::EARTH, m.time.plus_seconds(43_200.0)) > 2.0);
        // Greatest eclipse: ten minutes earlier or later the axis is farther away.
        for offset_s in [-600.0, 600.0] {
            assert!(world.shadow_axis_distance_radii(NaifId::MOON, NaifId::EARTH, m.time.plus_seconds(offset_s)) > distance, "{}", m.name);
        }
    }
}

/// The entire Moon is inside the Earth's umbra.
#[test]
fn lunar_eclipses_are_total() {
    let world = World::new();
    for m in of_kind(&world, "lunar eclipse") {
        let (earth, moon, sun) = (world.radius_km(NaifId::EARTH), world.radius_km(NaifId::MOON), world.radius_km(NaifId::SUN));
        let to_sun = world.apparent_km(NaifId::EARTH, NaifId::SUN, m.time);
        let to_moon = world.apparent_km(NaifId::EARTH, NaifId::MOON, m.time);
        let behind_earth_km = -to_moon.dot(to_sun.normalize());
        let umbra_radius_km = earth - behind_earth_km * (sun - earth) / to_sun.length();
        let axis_distance_km = to_moon.cross(to_sun.normalize()).length();
        assert!(
            behind_earth_km > 0.0 && axis_distance_km + moon < umbra_radius_km,
            "{}: {axis_distance_km} km from the axis of an umbra of {umbra_radius_km} km",
            m.name
        );
    }
}

#[test]
fn transits_are_in_front_of_the_sun() {
    let world = World::new();
    for m in of_kind(&world, "transit") {
        let sun = world.apparent_km(NaifId::EARTH, NaifId::SUN, m.time);
        let sun_radius_rad = world.radius_km(NaifId::SUN) / sun.length();
        let separation_rad = |id: i32| angle_rad(world.apparent_km(NaifId::EARTH, NaifId(id), m.time), sun);
        let planet = if m.name.contains("Venus") { 299 } else { 199 };
        let other_planet = if planet == 299 { 199 } else { 299 };
        assert!(separation_rad(planet) < sun_radius_rad && separation_rad(other_planet) > sun_radius_rad, "{}", m.name);
    }
}

/// The axes of three shadows meet Jupiter at the time when the observed light left it.
#[test]
fn the_triple_shadow_has_three_shadows() {
    let world = World::new();
    let m = of_kind(&world, "shadows").next().expect("a moment");
    let light_time_s = world.apparent_km(NaifId::EARTH, NaifId(599), m.time).length() / SPEED_OF_LIGHT_KM_S;
    let light_left = m.time.plus_seconds(-light_time_s);
    let shadow_on_jupiter = [501, 502, 503, 504].map(|id| world.shadow_axis_distance_radii(NaifId(id), NaifId(599), light_left) < 1.0);
    assert_eq!(shadow_on_jupiter, [true, true, false, true]);
}

/// Elevation of a body, such as the Earth or the Sun, above Saturn's ring plane, in degrees.
fn ring_elevation_deg(world: &World, body: NaifId, t: Instant) -> f64 {
    let pole = world.ephemeris.body_from_icrf(NaifId(699), t).expect("an orientation").row(2);
    let from_saturn_km = -world.apparent_km(body, NaifId(699), t);
    90.0 - angle_rad(from_saturn_km, pole).to_degrees()
}

#[test]
fn ring_moments_have_the_described_elevation_of_sun_or_earth() {
    let world = World::new();
    let all: Vec<&Moment> = of_kind(&world, "rings").collect();
    let named = |part: &str| all.iter().find(|m| m.name.contains(part)).unwrap_or_else(|| panic!("{part}")).time;
    let equinox = ring_elevation_deg(&world, NaifId::SUN, named("equinox"));
    assert!(equinox.abs() < 0.02, "{equinox} degrees");
    let crossing = ring_elevation_deg(&world, NaifId::EARTH, named("edge-on"));
    assert!(crossing.abs() < 0.02, "{crossing} degrees");
    let open = ring_elevation_deg(&world, NaifId::EARTH, named("open"));
    assert!((open - 26.98).abs() < 0.1, "{open} degrees");
}

#[test]
fn the_great_conjunction_is_six_arcminutes_wide() {
    let world = World::new();
    let m = of_kind(&world, "conjunction").next().expect("a moment");
    let separation_rad =
        angle_rad(world.apparent_km(NaifId::EARTH, NaifId(599), m.time), world.apparent_km(NaifId::EARTH, NaifId(699), m.time));
    assert!((separation_rad.to_degrees() * 60.0 - 6.1).abs() < 0.1, "{} arcmin", separation_rad.to_degrees() * 60.0);
}

#[test]
fn an_invalid_moment_is_reported_with_its_line() {
    let text =
        "[[moment]]\nname = \"x\"\nkind = \"party\"\ntime = \"soon\"\ntarget = \"Erth\"\nabout = \"a\"\nsource = \"b\"\nfrom = \"Moon\"\n";
    let error = Catalog::with_files(&[("mine.toml".into(), text.into())]).expect_err("it is wrong").to_string();
    for part in ["mine.toml:3", "solar eclipse", "mine.toml:4", "ISO 8601", "vantage"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let unknown_target =
        text.replace("party", "rings").replace("soon", "2020-01-01").replace("from = \"Moon\"", "from = \"Moon\"\nfov_deg = 1.0");
    let error = Catalog::with_files(&[("mine.toml".into(), unknown_target)]).expect_err("it is wrong").to_string();
    assert!(
        error.contains("mine.toml:5") && error.contains("target \"Erth\" is not the name of a body; did you mean \"Earth\""),
        "{error}"
    );
}

/// An invalid value has one problem, its own: the viewpoint is only called incomplete or ambiguous if a field is missing or superfluous.
#[test]
fn an_invalid_value_of_a_viewpoint_is_one_problem() {
    let problems_of = |viewpoint: &str| -> Vec<String> {
        let text = format!(
            "[[moment]]\nname = \"x\"\nkind = \"rings\"\ntime = \"2020-01-01\"\ntarget = \"Saturn\"\nabout = \"a\"\nsource = \"b\"\n{viewpoint}"
        );
        let read = Catalog::with_files(&[("mine.toml".into(), text)]);
        read.map_or_else(|e| e.problems.into_iter().map(|problem| problem.message).collect(), |_| Vec::new())
    };
    let place = "over = \"Saturn\"\nlatitude_deg = 1.0\nlongitude_deg = 2.0\nheight_km = 3.0\nfov_deg = 4.0\n";
    assert!(problems_of(place).is_empty(), "{:?}", problems_of(place));
    for (viewpoint, field) in [
        ("side = \"Sun\"\nradii = 0.5\n".to_owned(), "x.radii"),
        ("away_from = \"Sun\"\nradii = \"3\"\n".to_owned(), "x.radii"),
        ("side = 3\nradii = 5.0\n".to_owned(), "x.side"),
        ("from = \"Earth\"\nfov_deg = 200.0\n".to_owned(), "x.fov_deg"),
        (place.replace("latitude_deg = 1.0", "latitude_deg = 91.0"), "x.latitude_deg"),
        (place.replace("height_km = 3.0", "height_km = 0.0"), "x.height_km"),
    ] {
        let problems = problems_of(&viewpoint);
        assert!(problems.len() == 1 && problems[0].starts_with(&format!("{field} = ")), "{viewpoint}: {problems:?}");
    }
    // Negative controls: a field is missing, or two viewpoints are given.
    for viewpoint in ["side = \"Sun\"\n", "from = \"Earth\"\nfov_deg = 1.0\nside = \"Sun\"\nradii = 5.0\n", "fov_deg = 1.0\n"] {
        let problems = problems_of(viewpoint);
        assert!(problems.len() == 1 && problems[0].starts_with("x.vantage = incomplete or ambiguous"), "{viewpoint}: {problems:?}");
    }
}
