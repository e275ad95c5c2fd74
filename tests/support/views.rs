//! The views that are recorded as images, and compared between the renderers.

use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Up, ViewRequest};
use orrery::session::standard_scenes;
use orrery::time::Instant;

const SIDE: u32 = 192;
const ECLIPSE_DAY: &str = "2024-04-08T18:17:16Z";

struct View {
    name: &'static str,
    target: i32,
    at: At,
    time: &'static str,
}

/// Where the camera is.
enum At {
    /// Before the lit side, at the distance that fills most of the picture.
    Usual,
    /// The same, at this distance.
    Radii(f64),
    /// At the Earth's centre, with this field of view.
    EarthDeg(f64),
}

const fn view(name: &'static str, target: i32, at: At, time: &'static str) -> View {
    View { name, target, at, time }
}

const VIEWS: [View; 11] = [
    view("earth", 399, At::Usual, ECLIPSE_DAY),
    view("moon", 301, At::EarthDeg(0.7), "2024-04-16T01:00:00Z"),
    view("mars", 499, At::Radii(3.0), ECLIPSE_DAY),
    view("jupiter", 599, At::Usual, ECLIPSE_DAY),
    view("jupiter-moons", 599, At::Radii(60.0), "2024-12-07T20:00:00Z"),
    view("saturn", 699, At::Usual, "2017-05-17T00:00:00Z"),
    view("neptune", 899, At::Usual, ECLIPSE_DAY),
    view("io", 501, At::Usual, ECLIPSE_DAY),
    view("sun", 10, At::Usual, ECLIPSE_DAY),
    view("pluto", 999, At::Usual, ECLIPSE_DAY),
    // Jupiter is half a pixel wide: a point, and its moons' light beside it.
    view("jupiter-a-point", 599, At::EarthDeg(5.0), "2024-12-07T20:00:00Z"),
];

/// The views by name.
pub fn views() -> Vec<(&'static str, ViewRequest)> {
    let request = |v: View| {
        let (position, fov_deg) = match v.at {
            At::Usual => (Position::Over { towards: None, distance_radii: None }, None),
            At::Radii(radii) => (Position::Over { towards: None, distance_radii: Some(radii) }, None),
            At::EarthDeg(fov_deg) => (Position::Centre(NaifId::EARTH), Some(fov_deg)),
        };
        let base = ViewRequest::of(NaifId(v.target), Instant::parse(v.time).expect("a time"));
        (v.name, ViewRequest { position, fov_deg, width: SIDE, height: SIDE, ..base })
    };
    // The camera hangs close over ground: the other form of the intersection.
    // And the stars.
    let standard = standard_scenes(SIDE, SIDE).into_iter().filter(|s| ["moon-limb", "night-sky", "belt"].contains(&s.name));
    VIEWS.into_iter().map(request).chain(standard.map(|s| (s.name, s.request))).chain(small_bodies_and_orbits()).collect()
}

/// Halley with its tails on 16 March 1986 as the Earth saw it, and Saturn among the orbits of its moons.
fn small_bodies_and_orbits() -> [(&'static str, ViewRequest); 2] {
    let halley = ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: DVec3::new(0.473, -0.797, -0.375), axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(12.0),
        exposure: ExposureRequest::Stops(25.0),
        layers: Layers { comets: true, stars: false, ..Layers::default() },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("1986-03-16T00:00:00Z").expect("a time"))
    };
    let orbits = ViewRequest {
        position: Position::Over { towards: None, distance_radii: Some(30.0) },
        layers: Layers { orbits: true, traces: true, ..Layers::default() },
        ..ViewRequest::of(NaifId(699), Instant::parse("2017-05-17T00:00:00Z").expect("a time"))
    };
    [("halley", halley), ("saturn-orbits", orbits)].map(|(name, request)| (name, ViewRequest { width: SIDE, height: SIDE, ..request }))
}
