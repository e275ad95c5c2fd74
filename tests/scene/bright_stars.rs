//! The layer of bright stars: at every exposure, in air, in linear light.

use super::stars::towards;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::time::Instant;

/// The layer of bright stars from -20 to 25 stops: the brightest star has the same light on the display until the exposure alone shows more. It is never
/// darker, and the stars are never fewer, than without the layer. In air and in linear light the layer changes neither.
#[test]
fn bright_stars_follow_the_exposure() {
    let time = Instant::parse("2024-03-01T00:00:00Z").expect("a time");
    // Orion, between the planets.
    let look = DVec3::new(0.1, 0.99, 0.0);
    let at = |stops: f64, bright_stars: bool| {
        let layers = Layers { stars: true, bright_stars, ..Layers::NONE };
        let request = ViewRequest { exposure: ExposureRequest::Stops(stops), layers, ..towards(look, 40.0, time) };
        SESSION.scene(&request).expect("a scene")
    };
    // The light of the brightest star and the number of stars; the light on the display.
    let shown = |scene: &Scene| {
        let brightest = scene.stars.iter().map(|s| f64::from(s.flux.y)).fold(0.0, f64::max);
        (scene.stars.len(), brightest * scene.exposure.factor())
    };
    let (count, light) = shown(&at(-20.0, true));
    assert!(count > 300 && light > 0.0, "{count} stars");
    let (mut brightened, mut unchanged) = (0, 0);
    for stops in -20..=25 {
        let (with, without) = (at(f64::from(stops), true), at(f64::from(stops), false));
        let (with, without) = (shown(&with), shown(&without));
        assert!(with.0 >= without.0 && with.1 >= without.1 * (1.0 - 1e-6), "{stops}: {with:?}, without the layer {without:?}");
        if without.1 >= light * (1.0 - 1e-6) {
            assert_eq!(with.0, without.0, "{stops}: the exposure alone shows stars as bright");
            assert!((with.1 / without.1 - 1.0).abs() < 1e-5, "{stops}");
            unchanged += 1;
        } else {
            assert!(with.0.abs_diff(count) <= 2 && (with.1 / light - 1.0).abs() < 1e-5, "{stops}: {with:?}, not {:?}", (count, light));
            brightened += 1;
        }
    }
    assert!(brightened > 15 && unchanged > 3, "{brightened} brightened, {unchanged} not");
    // The reason given says whether the stars are brightened.
    assert!(at(0.0, true).sky[0].reason.to_string().contains("to be seen at this exposure"), "{:?}", at(0.0, true).sky[0]);
    assert!(!at(24.0, true).sky[0].reason.to_string().contains("to be seen at this exposure"));
    // Under the Earth's air, by day and by night, and in linear light.
    for (utc, purpose) in [
        ("2024-03-20T12:00:00Z", Purpose::Display),
        ("2024-03-20T00:00:00Z", Purpose::Display),
        ("2024-03-20T00:00:00Z", Purpose::Linear { floor: 1e-3 }),
    ] {
        let with = |bright_stars: bool| {
            let request = ViewRequest {
                position: Position::Ground { body: NaifId::EARTH, latitude_deg: 45.0, longitude_deg: 0.0, height_km: 0.002 },
                look: Look::Along { direction: DVec3::new(0.3, 0.2, 0.93), axes: Axes::BodyFixed },
                up: Up::Zenith,
                purpose,
                layers: Layers { bright_stars, ..Layers::default() },
                ..towards(DVec3::Z, 60.0, Instant::parse(utc).expect("a time"))
            };
            shown(&SESSION.scene(&request).expect("a scene"))
        };
        assert_eq!(with(true), with(false), "{utc}, {purpose:?}");
    }
}
