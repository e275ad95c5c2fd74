//! A camera that rises through the top of an atmosphere, or through the clouds: neither light nor exposure jumps, although most maps already include the
//! light of the air. And the ground near the camera is exposed for itself, not for the planet with its clouds.

use super::air_pass::image;
use crate::support::folds::larger;
use crate::support::session::SESSION;
use crate::support::sweep;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 24;
const TIME: &str = "2024-06-16T11:00:00Z";
const MARS: NaifId = NaifId(499);
const VENUS: NaifId = NaifId(299);
/// Degrees of longitude from the place under the Sun: by day and in twilight.
const DEGREES_FROM_NOON: [f64; 2] = [40.0, 95.0];

/// Each body with an atmosphere, and the height of its top.
fn bodies_with_air() -> Vec<(NaifId, f64)> {
    let with_air: Vec<_> = SESSION.catalog().bodies().iter().filter_map(|b| Some((b.id, b.atmosphere.as_ref()?.top_km))).collect();
    assert!(with_air.len() >= 9, "{with_air:?}");
    with_air
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

/// Looks straight down at a place on the equator, where heights are those in the unit-sphere frame.
fn view(body: NaifId, time: &str, longitude_deg: f64, height_km: f64) -> ViewRequest {
    ViewRequest {
        position: Position::Ground { body, latitude_deg: 0.0, longitude_deg, height_km },
        layers: Layers::NONE,
        width: SIDE,
        height: SIDE,
        fov_deg: Some(45.0),
        ..ViewRequest::of(body, Instant::parse(time).expect("a time"))
    }
}

/// Longitude of the place under the Sun.
fn noon_deg(body: NaifId) -> f64 {
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
    let over_noon = scene(&ViewRequest { position, width: SIDE, height: SIDE, ..view(body, TIME, 0.0, 1.0) });
    let camera = over_noon.body(body).expect("there").placement.camera_in_unit_sphere();
    camera.y.atan2(camera.x).to_degrees()
}

/// Mean light of the image, per channel.
fn light(scene: &Scene) -> [f64; 3] {
    let (_, hdr) = image(scene);
    [0, 1, 2].map(|c| hdr.iter().map(|p| f64::from(p[c])).sum::<f64>() / hdr.len() as f64)
}

/// Largest relative difference of two lights. A difference of less than a thousandth of `white` counts as none: above the night side of Venus, the last of the
/// twilight, 0.0008 of white at the longest exposure, is not drawn.
fn relative_step(a: [f64; 3], b: [f64; 3], white: f64) -> f64 {
    let step = |a: f64, b: f64| if (a - b).abs() < 1e-3 * white { 0.0 } else { (a - b).abs() / a.max(b) };
    a.iter().zip(b).map(|(a, b)| step(*a, b)).fold(0.0, larger)
}

/// Four heights within a fiftieth of a percent of the top. Bounds: 3 % of the light (Jupiter in twilight: 2 %), a fiftieth of a stop by day and 0.3 in
/// twilight. If the map of Mars counted as bare ground below the top, as it does at the ground, the light would exceed its bound.
#[test]
fn light_and_exposure_do_not_jump_at_the_top_of_the_air() {
    for (body, top_km) in bodies_with_air() {
        let noon_deg = noon_deg(body);
        for degrees in DEGREES_FROM_NOON {
            let at = |height_km: f64| view(body, TIME, (noon_deg + degrees) % 360.0, height_km);
            let heights = [-2e-4, -1e-4, 1e-4, 2e-4].map(|part| top_km * (1.0 + part));
            let stops = heights.map(|h| scene(&at(h)).exposure.stops);
            let white = (-stops[0]).exp2();
            let fixed = |height_km: f64| scene(&ViewRequest { exposure: ExposureRequest::Stops(stops[0]), ..at(height_km) });
            let lights = heights.map(|h| light(&fixed(h)));
            for k in 1..heights.len() {
                let step = relative_step(lights[k - 1], lights[k], white);
                assert!(step < 0.03, "{body:?}, {degrees} degrees, {} km: {:?} to {:?}", heights[k], lights[k - 1], lights[k]);
                let step = (stops[k] - stops[k - 1]).abs();
                // In twilight the ground outside the sky's light may be black: on Venus the exposure is then that of the night sky.
                let bound = if degrees > 90.0 { 0.3 } else { 0.02 };
                assert!(step < bound, "{body:?}, {degrees} degrees, {} km: {stops:?} stops", heights[k]);
            }
            if body == MARS && degrees > 90.0 {
                // The map as bare ground, as near the ground.
                let mut bare = fixed(heights[1]);
                for draw in &mut bare.draws {
                    (draw.uniforms.air.blend_mode, draw.uniforms.air.map_weight) = (0.0, 0.0);
                }
                let step = relative_step(light(&bare), lights[2], white);
                assert!(step > 0.1, "only {step}: the check above cannot fail");
            }
        }
    }
}

/// By night, too, the light does not jump there, at the longest exposure that the meter chooses: by at most 3e-4 of white or 3 %. Negative control: ground that
/// the night sky lights in full up to the top of the air of Venus, above which no air is drawn over the disc.
#[test]
fn the_light_of_the_night_side_does_not_jump_at_the_top_of_the_air() {
    const STOPS: f64 = 19.0;
    const MIN_STEP: f64 = 3e-4;
    let in_units_of_min_step = |light: [f64; 3]| light.map(|channel| channel * 1e-3 / MIN_STEP);
    for (body, top_km) in bodies_with_air() {
        let longitude_deg = (noon_deg(body) + 165.0) % 360.0;
        let at = |part: f64| {
            let request = view(body, TIME, longitude_deg, part * top_km);
            scene(&ViewRequest { exposure: ExposureRequest::Stops(STOPS), ..request })
        };
        let step = |below: &Scene, above: &Scene| {
            let [below, above] = [below, above].map(|scene| in_units_of_min_step(light(scene)));
            relative_step(below, above, (-STOPS).exp2())
        };
        let (mut below, above) = (at(1.0 - 1e-5), at(1.0 + 1e-5));
        let found = step(&below, &above);
        assert!(found < 0.03, "{body:?}: {:?} to {:?}", light(&below), light(&above));
        if body == VENUS {
            for draw in &mut below.draws {
                draw.uniforms.air.night_radiance = 1.5e-9;
            }
            assert!(step(&below, &above) > 0.1, "the check above cannot fail");
        }
    }
}

/// From a hundredth of the air's height to above its top, in steps of half a hundredth, the exposure changes by less than a bound per step. The clouds of the
/// Earth, which come into view at once at 6 km, change it most: by 2.5 stops by day and by 3.2 in twilight.
#[test]
fn the_exposure_changes_gradually_from_the_ground_into_space() {
    const MAX_STOPS: f64 = 0.8;
    const MAX_STOPS_AT_CLOUDS: f64 = 3.5;
    let (mut longest_way, mut has_earth) = (0.0_f64, false);
    let clouds_km = clouds_of_the_earth_km();
    for (_, (body, top_km)) in bodies_with_air().into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let noon_deg = noon_deg(body);
        for degrees in DEGREES_FROM_NOON {
            let at = |k: i32| {
                let height_km = 0.005 * f64::from(k) * top_km;
                (height_km, scene(&view(body, TIME, (noon_deg + degrees) % 360.0, height_km)).exposure.stops)
            };
            let all: Vec<(f64, f64)> = (2..=220).map(at).collect();
            let is_at_clouds = |step: &&[(f64, f64)]| body == NaifId::EARTH && step[1].0 > 0.9 * clouds_km && step[0].0 < clouds_km;
            let (at_clouds, elsewhere): (Vec<_>, Vec<_>) = all.windows(2).partition(is_at_clouds);
            let greatest = |steps: Vec<&[(f64, f64)]>| steps.iter().map(|step| (step[1].1 - step[0].1).abs()).fold(0.0, larger);
            let (at_clouds, elsewhere) = (greatest(at_clouds), greatest(elsewhere));
            println!("{body:?}, {degrees} degrees from noon: at most {elsewhere:.3} stops a step, at clouds {at_clouds:.3}");
            let is_gradual = elsewhere < MAX_STOPS && at_clouds < MAX_STOPS_AT_CLOUDS;
            assert!(is_gradual, "{body:?}, {degrees} degrees from noon: {elsewhere} stops in a step, at clouds {at_clouds}: {all:?}");
            longest_way = longest_way.max((all[all.len() - 1].1 - all[0].1).abs());
            // In the dust of Mars and the haze of Titan ground and space are as bright.
            has_earth |= body == NaifId::EARTH;
        }
    }
    assert!(
        !has_earth || longest_way > 3.0 * MAX_STOPS,
        "no exposure changes by more than {longest_way} stops: the check above cannot fail"
    );
}

/// Looks straight up, or along the horizon towards the north, where no ground is in sight or only a part of the frame is ground.
fn view_of_sky(body: NaifId, longitude_deg: f64, height_km: f64, to_zenith: bool) -> ViewRequest {
    let (sin, cos) = longitude_deg.to_radians().sin_cos();
    let direction = if to_zenith { DVec3::new(cos, sin, 0.0) } else { DVec3::Z };
    ViewRequest { look: Look::Along { direction, axes: Axes::BodyFixed }, ..view(body, TIME, longitude_deg, height_km) }
}

/// Just below the top of the air the sky is as dark as above the air, by day, too. If the meter gave it 1/3000 of the daylight sky's weight there,
/// the exposure of the zenith above the Earth and Venus would jump by five stops.
#[test]
fn the_exposure_of_the_sky_does_not_jump_at_the_top_of_the_air() {
    let mut longest_way: f64 = 0.0;
    for (body, top_km) in bodies_with_air() {
        let longitude_deg = (noon_deg(body) + 80.0) % 360.0;
        for to_zenith in [true, false] {
            let stops = |part: f64| scene(&view_of_sky(body, longitude_deg, part * top_km, to_zenith)).exposure.stops;
            let (below, above) = (stops(1.0 - 1e-6), stops(1.0 + 1e-6));
            assert!((below - above).abs() < 0.3, "{body:?}, to the zenith: {to_zenith}: {below} to {above} stops");
            longest_way = longest_way.max((above - stops(0.01)).abs());
        }
    }
    assert!(longest_way > 5.0, "no exposure changes by more than {longest_way} stops: the check above cannot fail");
}

/// The exposure of the Earth at noon on the equator, and the brightest channel of the mean light.
fn noon_on_the_earth(longitude_deg: f64, height_km: f64, effects: &str) -> (f64, f64) {
    let hour = (12.0 - longitude_deg / 15.0).rem_euclid(24.0);
    let time = format!("2024-03-20T{hour:02.0}:00:00Z");
    let effects = EffectOverrides::parse(effects).expect("effects");
    let found = scene(&ViewRequest { effects, ..view(NaifId::EARTH, &time, longitude_deg, height_km) });
    (found.exposure.stops, light(&found).into_iter().fold(0.0, larger))
}

/// From eye level, sea and land around the equator at noon are shown between a quarter of white and white, in the mean; single places are darker (forests: a
/// tenth) or brighter (deserts). At the exposure of the planet with its clouds they are shown darker.
#[test]
fn the_ground_at_noon_is_neither_dark_nor_white() {
    let found: Vec<(f64, f64)> = (0..12).map(|k| noon_on_the_earth(30.0 * f64::from(k) - 180.0, 0.0017, "")).collect();
    let mean_shown = |shift: f64| found.iter().map(|(stops, light)| light * (stops + shift).exp2()).sum::<f64>() / found.len() as f64;
    assert!((0.25..1.0).contains(&mean_shown(0.0)), "{}: {found:?}", mean_shown(0.0));
    let planet = noon_on_the_earth(0.0, 100.0, "").0;
    let shift = planet - found[6].0;
    assert!(shift < -2.0 && mean_shown(shift) < 0.25, "{shift} stops: {}", mean_shown(shift));
}

/// Height of the Earth's clouds.
fn clouds_of_the_earth_km() -> f64 {
    SESSION.catalog().body(NaifId::EARTH).and_then(|b| b.clouds.as_ref()).expect("clouds").height_km
}

/// Up to nine tenths of the clouds' height the exposure is that of the ground; from the clouds on it is that of the planet; without clouds it is at all heights
/// that of the ground and the air in front of it.
#[test]
fn the_exposure_changes_below_the_clouds_and_not_above_them() {
    let clouds_km = clouds_of_the_earth_km();
    let stops = |height_km: f64, effects: &str| noon_on_the_earth(0.0, height_km, effects).0;
    let (below, above) = (stops(0.999 * clouds_km, ""), stops(1.001 * clouds_km, ""));
    assert!((below - above).abs() < 0.02, "{below} and {above} stops");
    assert!((above - stops(3.0 * clouds_km, "")).abs() < 0.2);
    let ground = stops(0.899 * clouds_km, "");
    assert!((stops(0.899 * clouds_km, "-clouds") - ground).abs() < 1e-9);
    let (clear, cloudy) = (stops(2.0 * clouds_km, "-clouds"), stops(2.0 * clouds_km, ""));
    assert!(clear > cloudy + 1.0 && clear < ground + 0.2, "{clear} without clouds, {cloudy} with them, {ground} below them");
}

/// Over the South Atlantic the clouds are closed. From just above them they were white up to 9 km, because the exposure was still that of the ground.
#[test]
fn a_closed_deck_is_not_white_from_just_above_it() {
    let clouds_km = clouds_of_the_earth_km();
    let at = |height_km: f64| {
        let position = Position::Ground { body: NaifId::EARTH, latitude_deg: -33.54, longitude_deg: -12.91, height_km };
        scene(&ViewRequest { position, ..view(NaifId::EARTH, "2026-11-29T15:00:00Z", 0.0, height_km) })
    };
    let ground_stops = at(0.8 * clouds_km).exposure.stops;
    for clouds_heights in [1.01, 1.1, 1.5, 2.0] {
        let found = at(clouds_heights * clouds_km);
        let light = light(&found).into_iter().fold(0.0, larger);
        let [shown, at_ground_exposure] = [found.exposure.stops, ground_stops].map(|stops| light * stops.exp2());
        assert!((0.2..0.8).contains(&shown), "from {clouds_heights} times their height the clouds are at {shown} of white");
        // Negative control.
        assert!(at_ground_exposure > 1.0, "{at_ground_exposure}: the check above cannot fail");
    }
}
