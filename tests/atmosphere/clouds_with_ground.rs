//! Clouds that the ground's draw shades look like clouds that their own draw shades, from 1.5 to 9 radii. Where the ground's draw does not
//! shade them, the decision states the reason.

use super::air_pass::{self, image, over, view_of_earth};
use crate::support::session::SESSION;
use crate::support::sweep;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::draw::{AirPass, BodyPart};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Quality, ViewRequest};

/// The largest difference that is allowed in an image, in levels of 255.
const MAX_LEVELS: u8 = 1;
/// The fraction of pixels whose light may differ by more than the threshold of a display.
const MAX_CHANGED_FRACTION: f64 = 1e-4;
/// The same in an eclipse, where clouds that the ground's draw shades get the sunlight of the ground below them.
const MAX_CHANGED_FRACTION_IN_ECLIPSE: f64 = 5e-3;

/// `place`: latitude and longitude below the camera, degrees. `distance_radii`: from the Earth's centre.
fn view(time: &str, place: [f64; 2], distance_radii: f64, quality: Quality) -> ViewRequest {
    view_of_earth(time, over(place, distance_radii), quality)
}

/// Whether the ground's draw shades the clouds.
fn ground_shades_clouds(scene: &Scene) -> bool {
    let draw_reads_air_with_clouds = |part| scene.draws.iter().any(|d| d.part == part && d.features.air_pass == AirPass::ReadWithClouds);
    let [globe, clouds] = [BodyPart::Globe, BodyPart::Clouds].map(draw_reads_air_with_clouds);
    assert_eq!(globe, clouds, "the globe's and the clouds' draw must agree");
    globe
}

/// The same scene, with the clouds shaded by their own draw alone.
fn with_separate_clouds(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for draw in scene.draws.iter_mut().filter(|d| d.features.air_pass == AirPass::ReadWithClouds) {
        draw.features.air_pass = AirPass::Read;
    }
    scene
}

/// Greatest difference in levels, and the fraction of pixels whose light differs by more than the threshold.
fn difference(scene: &Scene, other: &Scene) -> (u8, f64) {
    let (drawn, other_drawn) = (image(scene), image(other));
    let found = air_pass::difference(&drawn, &other_drawn, scene.exposure.white());
    (found.levels, found.beyond_threshold as f64 / drawn.1.len() as f64)
}

#[test]
fn clouds_drawn_with_the_ground_look_like_clouds_drawn_by_themselves() {
    let day = "2024-06-08T18:17:16Z";
    let views = [
        ("day", view(day, [20.0, -90.0], 3.0, Quality::Draft)),
        ("day, all orders of scattering", view(day, [20.0, -90.0], 3.0, Quality::Standard)),
        ("north pole", view(day, [90.0, 0.0], 3.0, Quality::Draft)),
        ("near", view(day, [35.0, -90.0], 1.5, Quality::Standard)),
        ("far", view(day, [20.0, -90.0], 9.0, Quality::Draft)),
        ("eclipse", view("2024-04-08T18:17:16Z", [25.0, -105.0], 3.0, Quality::Standard)),
        ("evening", view(day, [0.0, 0.0], 2.0, Quality::Standard)),
        ("crescent", view(day, [0.0, 60.0], 3.0, Quality::Draft)),
        ("moonlit night", view("2024-06-22T06:00:00Z", [0.0, -90.0], 3.0, Quality::Draft)),
    ];
    for (name, request) in views.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)).map(|(_, view)| view) {
        let scene = SESSION.scene(&request).expect("a scene");
        assert!(ground_shades_clouds(&scene), "{name}");
        let (levels, changed_fraction) = difference(&with_separate_clouds(&scene), &scene);
        println!("{name}: {levels} levels, {changed_fraction:.2e} of the pixels beyond the threshold");
        let max_changed_fraction = if name == "eclipse" { MAX_CHANGED_FRACTION_IN_ECLIPSE } else { MAX_CHANGED_FRACTION };
        assert!(levels <= MAX_LEVELS && changed_fraction < max_changed_fraction, "{name}: {levels} levels, {changed_fraction:.2e}");
    }
}

/// Negative control: without their height above the ground, clouds lack their parallax, and the comparison detects it.
#[test]
fn clouds_at_height_zero_are_detected() {
    let scene = SESSION.scene(&view("2024-06-08T18:17:16Z", [35.0, -90.0], 1.5, Quality::Draft)).expect("a scene");
    assert!(ground_shades_clouds(&scene));
    let mut flat = scene.clone();
    flat.draws.iter_mut().filter(|d| d.part == BodyPart::Globe).for_each(|d| d.uniforms.clouds.radius = 1.0);
    let (levels, changed_fraction) = difference(&scene, &flat);
    assert!(changed_fraction > 10.0 * MAX_CHANGED_FRACTION_IN_ECLIPSE, "{levels} levels, {changed_fraction:.2e}");
}

#[test]
fn clouds_shaded_by_their_own_draw_state_the_reason() {
    let day = view("2024-06-08T18:17:16Z", [20.0, -90.0], 3.0, Quality::Draft);
    // A part of the reason, and a view.
    let cases = [
        ("lines on the ground", ViewRequest { layers: Layers { grid_body: true, ..day.layers }, ..day.clone() }),
        ("features", ViewRequest { effects: EffectOverrides::parse("-normal").expect("effects"), ..day.clone() }),
        (
            "px above the ground",
            ViewRequest { fov_deg: Some(1.0), effects: EffectOverrides::parse("-detail").expect("effects"), ..day.clone() },
        ),
    ];
    for (reason_part, request) in cases {
        let scene = SESSION.scene(&request).expect("a scene");
        assert!(!ground_shades_clouds(&scene), "{reason_part}");
        let decisions = &scene.body(NaifId::EARTH).expect("the Earth").decisions;
        let decision = decisions.iter().find(|d| d.effect == "clouds-with-ground");
        assert!(decision.is_some_and(|d| !d.on && d.reason.to_string().contains(reason_part)), "{reason_part}: {decision:?}");
    }
}
