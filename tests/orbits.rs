//! Orbit lines in pictures: asked for, hidden by what is nearer, over what is farther. Where the lines run is tested beside src/scene/orbits.rs.

use crate::shared::SESSION;
use glam::DVec2;
use orrery::catalog::NaifId;
use orrery::render::plan::Fineness;
use orrery::scene::request::{Layers, Position, ViewRequest};
use orrery::time::Instant;

const JUPITER: NaifId = NaifId(599);

/// Jupiter among the orbits of its four moons.
fn jupiter(orbits: bool) -> ViewRequest {
    let time = Instant::parse("2024-12-07T20:00:00Z").expect("a time");
    let position = Position::Over { towards: None, distance_radii: Some(12.0) };
    ViewRequest { position, width: 256, height: 256, layers: Layers { orbits }, ..ViewRequest::of(JUPITER, time) }
}

#[test]
fn lines_run_before_and_behind_the_planet() {
    let fineness = Fineness { samples: 4, anisotropy: 1 };
    let draw = |orbits: bool| SESSION.draw(&jupiter(orbits), fineness, true).expect("drawn");
    let (plain, lined) = (draw(false), draw(true));
    assert!(plain.scene.lines.is_empty() && lined.scene.lines.len() > 100, "{} pieces", lined.scene.lines.len());
    assert!(plain.scene.bodies.iter().flat_map(|b| &b.decisions).all(|d| d.feature != "orbit"), "not asked for");
    let camera = &lined.scene.camera;
    let planet = lined.scene.body(JUPITER).expect("in the catalog");
    let centre = camera.pixel_from_clip(camera.clip(planet.placement.centre_km).expect("in front"));
    let depth = orrery::scene::camera::NEAR_DEPTH_KM / planet.placement.centre_km.dot(camera.forward);
    let changed = |at: DVec2| {
        let k = at.y as usize * camera.width as usize + at.x as usize;
        (0..3).any(|c| (plain.frame.hdr[k][c] - lined.frame.hdr[k][c]).abs() > 1e-3)
    };
    let (mut before, mut behind, mut beside) = ((0, 0), (0, 0), (0, 0));
    for piece in &lined.scene.lines {
        let [a, b] = piece.ends.map(|e| e.as_dvec3());
        let at = camera.pixel_from_clip(a.truncate().lerp(b.truncate(), 0.5));
        if at.min_element() < 0.0 || at.max_element() >= 256.0 {
            continue;
        }
        let from_centre = (at - centre).length() / (0.5 * planet.diameter_px);
        let count = match (from_centre, 0.5 * (a.z + b.z) > depth) {
            (..0.8, true) => &mut before,
            (..0.8, false) => &mut behind,
            (1.2.., _) => &mut beside,
            _ => continue,
        };
        *count = (count.0 + u32::from(changed(at)), count.1 + 1);
    }
    let all = |(changed, of): (u32, u32)| of > 3 && 10 * changed > 9 * of;
    assert!(all(before) && all(beside), "(seen, of): before {before:?}, beside {beside:?}");
    // Another moon's line may run before the hidden place.
    assert!(behind.1 > 3 && 4 * behind.0 < behind.1, "(seen, of): behind {behind:?}");
    let said =
        |name: &str| lined.scene.bodies.iter().find(|b| b.name == name).and_then(|b| b.decisions.iter().find(|d| d.feature == "orbit"));
    assert!(said("Io").is_some_and(|d| d.on && d.reason.contains("Jupiter")), "{:?}", said("Io"));
    assert!(said("Moon").is_some_and(|d| !d.on), "{:?}", said("Moon"));
    assert!(said("Sun").is_none(), "{:?}", said("Sun"));
}

#[test]
fn layers_are_read_or_refused_by_name() {
    assert_eq!(Layers::parse("+orbits,-labels").expect("the contract's example"), Layers { orbits: true });
    assert_eq!(Layers::parse("+orbits, -orbits").expect("the last sign"), Layers::default());
    for (text, why) in [("orbits", "write + or -"), ("+stars", "there are orbits"), ("+labels", "the window's")] {
        let error = Layers::parse(text).expect_err("refused").to_string();
        assert!(error.contains(why) && error.contains(text), "{error}");
    }
}
