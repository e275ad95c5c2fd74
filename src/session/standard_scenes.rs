//! The scenes that benchmarks draw; the command line and criterion share this list.
//!
//! In: the size of the images. Out: named view requests at fixed times, some with synthetic minor planets or stars that the session must be given.

use crate::catalog::NaifId;
use crate::catalog::small_bodies::SmallBodies;
use crate::catalog::stars::StarCatalog;
use crate::scene::request::{Axes, Layers, Look, Position, Up, ViewRequest};
use crate::time::Instant;

/// A named view at a fixed time.
#[derive(Clone, Debug)]
pub struct StandardScene {
    /// The name that `bench` uses.
    pub name: &'static str,
    /// The view.
    pub request: ViewRequest,
}

impl StandardScene {
    /// Minor planets that replace the embedded ones while this scene is measured, if it has its own.
    pub fn minor_planets(&self) -> Option<SmallBodies> {
        /// Number of minor planets of the scene `belt`.
        const COUNT: usize = 100_000;
        (self.name == "belt").then(|| SmallBodies::synthetic_belt(COUNT))
    }

    /// Stars that replace the embedded ones while this scene is measured, if it has its own.
    pub fn stars(&self) -> Option<StarCatalog> {
        /// Number of stars of the scene `million-stars`.
        const COUNT: usize = 1_000_000;
        (self.name == "million-stars").then(|| StarCatalog::synthetic(COUNT))
    }
}

/// 2024-04-08T18:18:25 TDB, the greatest eclipse of the total solar eclipse over North America. The time of all scenes but `moon-limb`.
const ECLIPSE_JD_TDB: f64 = 2_460_409.262_789_4;

/// 2024-04-16 01:01 TDB, six hours after first quarter. The time of the scene `moon-limb`, because at the time of the eclipse the near side is dark.
const QUARTER_JD_TDB: f64 = 2_460_416.542_5;

const JUPITER: NaifId = NaifId(599);
const SATURN: NaifId = NaifId(699);

/// The view of a body from a distance, on the side that faces the Earth; of the Earth, on the side that faces the Sun.
fn view_of(target: NaifId, distance_radii: f64, time: Instant) -> ViewRequest {
    let position = Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) };
    ViewRequest { position, ..ViewRequest::of(target, time) }
}

/// The list of scenes: the Earth from 3 radii, Saturn, the Moon's limb from 400 km, Jupiter with its Galilean moons, the planets from 56 au in the Earth's
/// direction, the night sky around Orion with constellation figures, the main belt, and the night sky again, with a million stars and without figures.
pub fn standard_scenes(width: u32, height: u32) -> Vec<StandardScene> {
    let time = Instant::from_jd_tdb(ECLIPSE_JD_TDB);
    // Looking north and 38 degrees down. The Moon's horizon is 36 degrees down from this height, so it crosses the image above the middle.
    let limb = ViewRequest {
        position: Position::Ground { body: NaifId::MOON, latitude_deg: 10.0, longitude_deg: 40.0, height_km: 400.0 },
        look: Look::Along { direction: glam::DVec3::new(-0.569, -0.478, 0.671), axes: Axes::BodyFixed },
        target: None,
        fov_deg: Some(45.0),
        ..ViewRequest::of(NaifId::MOON, Instant::from_jd_tdb(QUARTER_JD_TDB))
    };
    let system = ViewRequest { fov_deg: Some(60.0), ..view_of(NaifId::SUN, 12_000.0, time) };
    // Centred on Orion's belt, as seen from the Earth.
    let night_sky = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: glam::DVec3::new(0.105, 0.994, -0.01), axes: Axes::Icrf },
        up: Up::Celestial,
        target: None,
        fov_deg: Some(45.0),
        layers: Layers { constellations: true, ..Layers::default() },
        ..ViewRequest::of(NaifId::EARTH, time)
    };
    // From 6.3 au north of the ecliptic; [`StandardScene::minor_planets`] generates the belt.
    let belt = ViewRequest {
        position: Position::Offset { body: NaifId::SUN, offset_km: glam::DVec3::new(0.0, -3.5e8, 8.8e8), axes: Axes::Icrf },
        layers: Layers { minor_planets: true, ..Layers::default() },
        fov_deg: Some(55.0),
        ..ViewRequest::of(NaifId::SUN, time)
    };
    let million_stars = ViewRequest { layers: Layers::default(), ..night_sky.clone() };
    let views = [
        ("earth-3-radii", view_of(NaifId::EARTH, 3.0, time)),
        ("saturn", view_of(SATURN, 5.0, time)),
        ("moon-limb", limb),
        ("jupiter-four-moons", ViewRequest { fov_deg: Some(45.0), ..view_of(JUPITER, 60.0, time) }),
        ("whole-system", system),
        ("night-sky", night_sky),
        ("belt", belt),
        ("million-stars", million_stars),
    ];
    views.into_iter().map(|(name, request)| StandardScene { name, request: ViewRequest { width, height, ..request } }).collect()
}
