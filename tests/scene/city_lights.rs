//! City lights by the height of the camera: a landscape of light from above, none around a camera among the lamps; metered as they are drawn.

use super::metering::assert_changes_smoothly;
use crate::support::session::SESSION;
use glam::{DVec3, Vec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{SamplingQuality, plan};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Up, ViewRequest};
use orrery::scene::{CD_M2_PER_RADIANCE, Scene};
use orrery::time::Instant;

const SIDE: u32 = 32;
/// Latitude and longitude in degrees, and a time.
type Place = ([f64; 2], &'static str);
const MADRID_BY_NIGHT: Place = ([40.417, -3.704], "2026-08-12T22:00:00Z");
/// The Sun is 8 degrees below the horizon, so that all lights are on.
const LONDON_AT_DUSK: Place = ([51.507, -0.128], "2026-11-30T16:54:00Z");
const PARIS_BY_NIGHT: Place = ([48.85, 2.35], "2026-11-28T22:00:00Z");

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

/// Radiance of a white texel of the night map, by the uniforms of the Earth's ground. At the exposure of a night, so that city lights are drawn.
fn white_of_night_map(height_km: f64) -> Vec3 {
    let effects = EffectOverrides::parse("+night").expect("effects");
    let scene = scene(&ViewRequest { exposure: ExposureRequest::Stops(19.0), effects, ..view(PARIS_BY_NIGHT, height_km, -85.0) });
    let ground = scene.draws.iter().find(|d| d.body == NaifId::EARTH && d.features.maps.night).expect("ground with city lights");
    ground.uniforms.night_radiance
}

/// From 10 and 50 m above a city the ground is not a pale plain below a starry sky: by night and at dusk it is darker than the sky. Negative control: with the
/// whole light of the night map, as seen from 5 km, it would not be, even dimmed to the 2 % that were once left of it.
#[test]
fn the_ground_of_a_city_is_dark_around_the_camera() {
    for place in [MADRID_BY_NIGHT, LONDON_AT_DUSK] {
        for height_km in [0.01, 0.05] {
            let scene = scene(&view(place, height_km, 0.0));
            let [sky, ground] = levels_of_sky_and_ground(&scene);
            assert!(ground < sky, "{place:?} from {height_km} km: sky {sky}, ground {ground}");
            assert!(scene.draws.iter().all(|d| !d.features.maps.night), "{place:?} from {height_km} km");
            let once_left = 0.02 * f64::from(white_of_night_map(5.0).max_element()) * scene.exposure.factor();
            assert!(place == LONDON_AT_DUSK || once_left > 0.1, "{place:?}: {once_left} of white");
        }
    }
}

/// Straight down on a city from 0.3 to 5 km: the luminance that the reason gives for the ground is that of the drawn ground within a factor of 2.5;
/// and the ground is shown below half of white.
#[test]
fn city_lights_are_metered_as_they_are_drawn() {
    for height_km in [0.3, 0.5, 1.0, 2.0, 5.0] {
        let request = view(PARIS_BY_NIGHT, height_km, -89.0);
        let drawn = SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
        let reason = drawn.scene.exposure.reason.to_string();
        let hdr = &drawn.frame.hdr;
        let mean = hdr.iter().map(|p| f64::from(p[0].max(p[1]).max(p[2]))).sum::<f64>() / hdr.len() as f64;
        let metered = reason.strip_prefix("Earth metered at ").and_then(|rest| rest.split_once(" cd/m2"));
        let metered: f64 = metered.and_then(|(number, _)| number.parse().ok()).unwrap_or_else(|| panic!("{reason}"));
        let (ratio, level) = (mean * CD_M2_PER_RADIANCE / metered, mean * drawn.scene.exposure.factor());
        println!("{height_km} km: drawn / metered {ratio:.2}, {level:.3} of white; {reason}");
        assert!((0.4..2.5).contains(&ratio) && level < 0.5, "{height_km} km: {ratio}, {level} of white; {reason}");
    }
}

/// From 3 km on, city lights are those of the map bit by bit. Below, they never brighten on the way down, and lose less than a fortieth per step of 4 %.
#[test]
fn city_lights_fade_only_below_three_kilometres() {
    let from_space = white_of_night_map(3_000.0);
    assert!(from_space.min_element() > 0.0);
    for height_km in [3.05, 10.0, 400.0] {
        assert_eq!(white_of_night_map(height_km), from_space, "from {height_km} km");
    }
    assert_eq!(white_of_night_map(0.099), Vec3::ZERO);
    let steps: Vec<f32> = (0..110).map(|k| white_of_night_map(0.06 * 1.04_f64.powi(k)).x / from_space.x).collect();
    assert!(steps.windows(2).all(|w| (0.0..0.025).contains(&(w[1] - w[0]))), "{steps:?}");
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
    assert!(reason(0.01).contains("0 % of the map's light at a height of 0.01 km"), "{}", reason(0.01));
    assert!(!reason(10.0).contains("map's light"), "{}", reason(10.0));
}
