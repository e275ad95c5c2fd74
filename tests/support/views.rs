//! The views that are recorded as golden images and compared between the renderers.

use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::request::{
    Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Stereo, StereoLayout, Up, ViewRequest, WarpMesh,
};
use orrery::session::standard_scenes;
use orrery::time::Instant;
use std::sync::Arc;

const SIDE: u32 = 192;
const ECLIPSE_DAY: &str = "2024-04-08T18:17:16Z";

struct View {
    name: &'static str,
    /// NAIF id.
    target: i32,
    camera: CameraPlace,
    time: &'static str,
}

/// Position of the camera.
enum CameraPlace {
    /// Over the default side of the body ([`Position::AboveTarget`]), at the distance at which the disc fills 3/4 of the image's height.
    Fitted,
    /// Over the same side, at this distance from the centre in equatorial radii.
    Radii(f64),
    /// At the Earth's centre, with this field of view in degrees.
    EarthDeg(f64),
}

const fn view(name: &'static str, target: i32, camera: CameraPlace, time: &'static str) -> View {
    View { name, target, camera, time }
}

const VIEWS: [View; 11] = [
    view("earth", 399, CameraPlace::Fitted, ECLIPSE_DAY),
    view("moon", 301, CameraPlace::EarthDeg(0.7), "2024-04-16T01:00:00Z"),
    view("mars", 499, CameraPlace::Radii(3.0), ECLIPSE_DAY),
    view("jupiter", 599, CameraPlace::Fitted, ECLIPSE_DAY),
    view("jupiter-moons", 599, CameraPlace::Radii(60.0), "2024-12-07T20:00:00Z"),
    view("saturn", 699, CameraPlace::Fitted, "2017-05-17T00:00:00Z"),
    view("neptune", 899, CameraPlace::Fitted, ECLIPSE_DAY),
    view("io", 501, CameraPlace::Fitted, ECLIPSE_DAY),
    view("sun", 10, CameraPlace::Fitted, ECLIPSE_DAY),
    view("pluto", 999, CameraPlace::Fitted, ECLIPSE_DAY),
    // Jupiter is half a pixel wide and drawn as a point; its moons are beside it.
    view("jupiter-a-point", 599, CameraPlace::EarthDeg(5.0), "2024-12-07T20:00:00Z"),
];

/// The views by name.
pub fn views() -> Vec<(&'static str, ViewRequest)> {
    let request = |v: View| {
        let (position, fov_deg) = match v.camera {
            CameraPlace::Fitted => (Position::AboveTarget { towards: None, distance_radii: None }, None),
            CameraPlace::Radii(radii) => (Position::AboveTarget { towards: None, distance_radii: Some(radii) }, None),
            CameraPlace::EarthDeg(fov_deg) => (Position::Centre(NaifId::EARTH), Some(fov_deg)),
        };
        let base = ViewRequest::of(NaifId(v.target), Instant::parse(v.time).expect("a time"));
        (v.name, ViewRequest { position, fov_deg, width: SIDE, height: SIDE, ..base })
    };
    // The Milky Way from Antares to Altair, with stars and diffuse light boosted by 3 stops, and no body as target.
    let milky_way = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: DVec3::new(0.0, -0.94, -0.34), axes: Axes::Icrf },
        up: Up::Celestial,
        target: None,
        fov_deg: Some(70.0),
        width: SIDE,
        height: SIDE,
        stars_boost_stops: 3.0,
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-06-07T00:00:00Z").expect("a time"))
    };
    // A view from so close to the ground that rays start at the camera (`anchor_is_camera`), the night sky, and the belt of minor planets.
    let standard = standard_scenes(SIDE, SIDE).into_iter().filter(|s| ["moon-limb", "night-sky", "belt"].contains(&s.name));
    let single_images = VIEWS.into_iter().map(request).chain([("milky-way", milky_way)]).chain(standard.map(|s| (s.name, s.request)));
    single_images.chain(composed_views()).chain(views_with_layers()).collect()
}

/// Composed images.
fn composed_views() -> Vec<(&'static str, ViewRequest)> {
    let view_of = |target: i32, time: &str, composition: Composition| ViewRequest {
        composition,
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time"))
    };
    let stereo = |layout| Composition { stereo: Some(Stereo { layout, eye_separation_km: None }), ..Composition::default() };
    let sphere = |projection| Composition { projection, ..Composition::default() };
    let saturn = |layout| view_of(699, "2017-05-17T00:00:00Z", stereo(layout));
    // A warp mesh of 4 x 3 nodes: a trapezoid with curved edges, darker on the left.
    let nodes: String = (0..12)
        .map(|k| {
            let (u, v) = (f64::from(k % 4) / 3.0, f64::from(k / 4) / 2.0);
            let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            format!("{} {} {u} {v} {}\n", x * (1.0 - 0.2 * y), y - 0.2 * x * x, 0.4 + 0.6 * u)
        })
        .collect();
    let mesh = WarpMesh::parse("screen", &format!("2\n4 3\n{nodes}")).expect("a mesh");
    let ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 32.8, longitude_deg: -96.8, height_km: 0.002 };
    let dome = Composition { is_zenith_centred: true, ..sphere(Projection::Fisheye) };
    let near_mars = Position::AboveTarget { towards: None, distance_radii: Some(1.6) };
    vec![
        ("saturn-anaglyph", saturn(StereoLayout::Anaglyph)),
        ("saturn-side-by-side", saturn(StereoLayout::SideBySide)),
        ("saturn-interlaced", saturn(StereoLayout::Interlaced)),
        ("dome-dusk", ViewRequest { position: ground, up: Up::Zenith, ..view_of(10, "2024-04-09T00:20:00Z", dome) }),
        (
            "mars-equirectangular",
            ViewRequest { position: near_mars, height: SIDE / 2, ..view_of(499, ECLIPSE_DAY, sphere(Projection::Equirectangular)) },
        ),
        ("earth-warped", view_of(399, ECLIPSE_DAY, Composition { warp: Some(Arc::new(mesh)), ..Composition::default() })),
    ]
}

/// Halley's comet with its tails on 16 March 1986 from the Earth, Saturn among the orbits of its moons, the path of the eclipse of 2024 on the globe, and the
/// Moon in the fields of view of instruments.
fn views_with_layers() -> [(&'static str, ViewRequest); 4] {
    let halley = ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: DVec3::new(0.473, -0.797, -0.375), axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(12.0),
        exposure: ExposureRequest::Stops(25.0),
        layers: Layers { comets: true, ..Layers::NONE },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("1986-03-16T00:00:00Z").expect("a time"))
    };
    let orbits = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(30.0) },
        layers: Layers { orbits: true, traces: true, ..Layers::default() },
        ..ViewRequest::of(NaifId(699), Instant::parse("2017-05-17T00:00:00Z").expect("a time"))
    };
    let eclipse_path = ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.2) },
        layers: Layers { eclipse_path: true, ..Layers::NONE },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(ECLIPSE_DAY).expect("a time"))
    };
    let instruments = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        fov_deg: Some(9.0),
        layers: Layers { instruments: true, ..Layers::NONE },
        ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-16T01:00:00Z").expect("a time"))
    };
    [("halley", halley), ("saturn-orbits", orbits), ("eclipse-path", eclipse_path), ("instruments", instruments)]
        .map(|(name, request)| (name, ViewRequest { width: SIDE, height: SIDE, ..request }))
}
