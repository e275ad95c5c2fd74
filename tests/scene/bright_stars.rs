//! The layer of bright stars: at every exposure, in air, in linear light.

use super::stars::towards;
use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::time::Instant;

/// What a display shows of the stars.
#[derive(Debug, PartialEq)]
struct ShownStars {
    count: usize,
    /// Flux of the brightest star times the factor of the exposure.
    brightest: f64,
}

fn shown(scene: &Scene) -> ShownStars {
    let brightest = scene.stars.iter().map(|s| f64::from(s.flux.y)).fold(0.0, larger);
    ShownStars { count: scene.stars.len(), brightest: brightest * scene.exposure.factor() }
}

/// With the layer, the brightest star has the same light on the display at all exposures from -20 stops up to where the exposure alone
/// shows more. It is never darker, and the stars are never fewer, than without the layer. In air and in linear light the layer changes
/// nothing.
#[test]
fn bright_stars_follow_the_exposure() {
    let time = Instant::parse("2024-03-01T00:00:00Z").expect("a time");
    // Orion.
    let look = DVec3::new(0.1, 0.99, 0.0);
    let scene_at = |stops: f64, bright_stars: bool| {
        let layers = Layers { stars: true, bright_stars, ..Layers::NONE };
        let request = ViewRequest { exposure: ExposureRequest::Stops(stops), layers, ..towards(look, 40.0, time) };
        SESSION.scene(&request).expect("a scene")
    };
    let with_layer = |stops: f64| scene_at(stops, true);
    let without_layer = |stops: f64| scene_at(stops, false);
    let at_lowest = shown(&with_layer(-20.0));
    assert!(at_lowest.count > 300 && at_lowest.brightest > 0.0, "{at_lowest:?}");
    let (mut brightened, mut unchanged) = (0, 0);
    for stops in -20..=25 {
        let (with, without) = (shown(&with_layer(f64::from(stops))), shown(&without_layer(f64::from(stops))));
        assert!(
            with.count >= without.count && with.brightest >= without.brightest * (1.0 - 1e-6),
            "{stops}: {with:?}, without the layer {without:?}"
        );
        if without.brightest >= at_lowest.brightest * (1.0 - 1e-6) {
            assert_eq!(with.count, without.count, "{stops}: the exposure alone shows stars as bright");
            assert!((with.brightest / without.brightest - 1.0).abs() < 1e-5, "{stops}");
            unchanged += 1;
        } else {
            assert!(
                with.count.abs_diff(at_lowest.count) <= 2 && (with.brightest / at_lowest.brightest - 1.0).abs() < 1e-5,
                "{stops}: {with:?}, not {at_lowest:?}"
            );
            brightened += 1;
        }
    }
    assert!(brightened > 15 && unchanged > 3, "{brightened} brightened, {unchanged} not");
    // The reason says whether the stars are brightened.
    let reason = |stops: f64| with_layer(stops).sky_decisions[0].reason.to_string();
    assert!(reason(0.0).contains("to be seen at this exposure"), "{}", reason(0.0));
    assert!(!reason(24.0).contains("to be seen at this exposure"));
    // It also says where the star catalog ends, if the exposure would show fainter stars.
    let unlifted_reason = |stops: f64| without_layer(stops).sky_decisions[0].reason.to_string();
    for (stops, reaches_end) in [(24.0, true), (0.0, false)] {
        let reason = unlifted_reason(stops);
        assert_eq!(reason.contains("the faintest star of the catalog has magnitude 7.0"), reaches_end, "{reason}");
    }
    // Under the Earth's air, by day and by night, and in linear light.
    for (utc, purpose) in [
        ("2024-03-20T12:00:00Z", Purpose::Display),
        ("2024-03-20T00:00:00Z", Purpose::Display),
        ("2024-03-20T00:00:00Z", Purpose::Linear { floor: 1e-3 }),
    ] {
        let [with, without] = [true, false].map(|bright_stars| {
            let request = ViewRequest {
                position: Position::Ground { body: NaifId::EARTH, latitude_deg: 45.0, longitude_deg: 0.0, height_km: 0.002 },
                look: Look::Along { direction: DVec3::new(0.3, 0.2, 0.93), axes: Axes::BodyFixed },
                up: Up::Zenith,
                purpose,
                layers: Layers { bright_stars, ..Layers::default() },
                ..towards(DVec3::Z, 60.0, Instant::parse(utc).expect("a time"))
            };
            shown(&SESSION.scene(&request).expect("a scene"))
        });
        assert_eq!(with, without, "{utc}, {purpose:?}");
    }
}
