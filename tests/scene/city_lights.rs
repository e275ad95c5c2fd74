//! City lights by the height of the camera: a landscape of light from above, dim ground around a camera among the lamps.

use super::metering::assert_changes_smoothly;
use crate::support::session::SESSION;
use glam::{DVec3, Vec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{SamplingQuality, plan};
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Up, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 32;
/// Latitude and longitude in degrees, and a time.
type Place = ([f64; 2], &'static str);
const MADRID_BY_NIGHT: Place = ([40.417, -3.704], "2026-08-12T22:00:00Z");
/// The Sun is 8 degrees below the horizon, so that all lights are on.
const LONDON_AT_DUSK: Place = ([51.507, -0.128], "2026-11-30T16:54:00Z");
const PARIS_BY_NIGHT: Place = ([48.85, 2.35], "2026-11-28T22:00:00Z");
/// The part of the map's light that a camera on the ground sees.
const FACTOR_ON_GROUND: f32 = 0.02;

/// A view in a direction `altitude_deg` above the horizon in the north.
fn view(([latitude_deg, longitude_deg], time): Place, height_km: f64, altitude_deg: f64) -> ViewRequest {
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
    let (sin, cos) = altitude_deg.to_radians().sin_cos();
    ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km },
        look: Look::Along { direction: north * cos + up * sin, axes: Axes::BodyFixed },
        up: Up::Zenith,
        layers: Layers::NONE,
        fov_deg: Some(60.0),
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
    }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

/// Mean display level of the upper third of the image, the sky, and of the lower third, the ground.
fn levels_of_sky_and_ground(scene: &Scene) -> [f64; 2] {
    let plan = plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    let (frame, _) = SESSION.renderer().render(&plan, SESSION.library(), FrameImages::Display).expect("drawn");
    let third = frame.display.len() / 3;
    let mean = |pixels: &[[u8; 4]]| pixels.iter().flat_map(|p| &p[..3]).map(|v| f64::from(*v)).sum::<f64>() / (3 * pixels.len()) as f64;
    [mean(&frame.display[..third]), mean(&frame.display[frame.display.len() - third..])]
}

/// The scene of a view from the ground, but with all the light of the night map, which is drawn even if the little that is left of it would not be seen.
fn with_the_whole_map(request: &ViewRequest) -> Scene {
    let mut scene = scene(&ViewRequest { effects: EffectOverrides::parse("+night").expect("effects"), ..request.clone() });
    scene.draws.iter_mut().for_each(|d| d.uniforms.night_radiance /= FACTOR_ON_GROUND);
    scene
}

/// Radiance of a white texel of the night map, by the uniforms of the Earth's ground. At the exposure of a night, so that city lights are drawn.
fn white_of_night_map(height_km: f64) -> Vec3 {
    let scene = scene(&ViewRequest { exposure: ExposureRequest::Stops(19.0), ..view(PARIS_BY_NIGHT, height_km, -85.0) });
    let ground = scene.draws.iter().find(|d| d.body == NaifId::EARTH && d.features.maps.night).expect("ground with city lights");
    ground.uniforms.night_radiance
}

/// From 10 m above a city the ground is not a plain of light: by night it is darker than half of white (level 188), at dusk darker than the sky. Negative
/// control: the whole light of the night map.
#[test]
fn the_ground_of_a_city_is_dim_around_the_camera() {
    for (place, may_exceed_sky) in [(MADRID_BY_NIGHT, true), (LONDON_AT_DUSK, false)] {
        let request = view(place, 0.01, 0.0);
        let [sky, ground] = levels_of_sky_and_ground(&scene(&request));
        let limit = if may_exceed_sky { 188.0 } else { sky };
        assert!(ground < limit, "{place:?}: sky {sky}, ground {ground}");
        let [_, lit_ground] = levels_of_sky_and_ground(&with_the_whole_map(&request));
        assert!(lit_ground > limit, "{place:?}: sky {sky}, with the whole map {lit_ground}");
    }
}

/// From 3 km on, city lights are those of the map bit by bit. Below, they never brighten on the way down, and change by less than 1.25 times per step of 4 %.
#[test]
fn city_lights_fade_only_below_three_kilometres() {
    let from_space = white_of_night_map(3_000.0);
    assert!(from_space.min_element() > 0.0);
    for height_km in [3.05, 10.0, 400.0] {
        assert_eq!(white_of_night_map(height_km), from_space, "from {height_km} km");
    }
    let on_ground = white_of_night_map(0.01) / from_space;
    assert!((on_ground / FACTOR_ON_GROUND - 1.0).abs().max_element() < 1e-3, "{on_ground}");
    let steps: Vec<f32> = (0..110).map(|k| white_of_night_map(0.06 * 1.04_f64.powi(k)).x).collect();
    assert!(steps.windows(2).all(|w| (1.0..1.25).contains(&(w[1] / w[0]))), "{steps:?}");
}

/// A camera over a city that looks down and descends by night: the exposure follows the lights as they fade, without a jump.
#[test]
fn the_exposure_follows_the_fading_lights() {
    assert_changes_smoothly("lowered", 1.0, 60, |k| view(PARIS_BY_NIGHT, 5.0 * 1.08_f64.powf(-k), -85.0));
}

/// `explain` says why there is less light near the ground; from above there is nothing to say.
#[test]
fn the_decision_names_the_height() {
    let reason = |height_km: f64| {
        let scene = scene(&ViewRequest { exposure: ExposureRequest::Stops(19.0), ..view(PARIS_BY_NIGHT, height_km, 0.0) });
        let earth = scene.body(NaifId::EARTH).expect("the Earth");
        earth.decisions.iter().find(|d| d.effect == "night").expect("decided").reason.to_string()
    };
    assert!(reason(0.01).contains("2 % of the map's light at a height of 0.01 km"), "{}", reason(0.01));
    assert!(!reason(10.0).contains("map's light"), "{}", reason(10.0));
}
