//! The sky by night: moonlight that the air scatters, in the sky and in front of the ground, and the light of the moonless sky. Images against the same air
//! with the Moon in the Sun's place, and against what the light meter finds.

use super::air_pass::image;
use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec3, Vec3};
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::draw::{AirPass, BodyPart, Light};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, ViewRequest};
use orrery::time::Instant;

/// The Moon is 66 degrees high at [`PLACE_DEG`].
const FULL_MOON: &str = "2024-01-25T22:00:00Z";
const NEW_MOON: &str = "2024-01-11T22:00:00Z";
/// The Sun is 65 degrees high there.
const NOON: &str = "2024-03-20T11:30:00Z";
/// Latitude and longitude.
const PLACE_DEG: [f64; 2] = [25.0, 10.0];
/// The zenith shows neither the Moon nor the Sun, which are 24 degrees from it.
const EFFECTS: &str = "-clouds,-points,-glow,-corona,-eclipse";

fn up() -> DVec3 {
    let [latitude, longitude] = PLACE_DEG.map(f64::to_radians);
    DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin())
}

/// A view from a height above the place, upwards or downwards.
fn view(time: &str, height_km: f64, direction: DVec3, more_effects: &str) -> ViewRequest {
    let [latitude_deg, longitude_deg] = PLACE_DEG;
    ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km },
        look: Look::Along { direction, axes: Axes::BodyFixed },
        layers: Layers::NONE,
        effects: EffectOverrides::parse(&format!("{EFFECTS}{more_effects}")).expect("effects"),
        width: 24,
        height: 24,
        fov_deg: Some(20.0),
        exposure: ExposureRequest::Stops(17.0),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
    }
}

/// The Earth alone. Without points other bodies are discs: at new Moon Vesta's one pixel in the zenith has 700 times the light of all pixels of the sky.
fn scene(request: &ViewRequest) -> Scene {
    let mut scene = SESSION.scene(request).expect("a scene");
    scene.draws.retain(|d| d.body == NaifId::EARTH);
    scene
}

/// The sky in the zenith of a camera on the ground.
fn zenith(time: &str, more_effects: &str) -> ViewRequest {
    view(time, 0.0017, up(), more_effects)
}

/// Mean light of the image, per channel.
fn light(scene: &Scene) -> [f64; 3] {
    let (_, hdr) = image(scene);
    [0, 1, 2].map(|c| hdr.iter().map(|p| f64::from(p[c])).sum::<f64>() / hdr.len() as f64)
}

/// The number of lights of the sky's draw.
fn lights_of_sky(scene: &Scene) -> u8 {
    scene.draws.iter().find(|d| d.part == BodyPart::Sky).expect("a sky").features.lights
}

/// Whether the light of another body in the Earth's air is drawn; `None` if no such light is drawn on its ground either.
fn is_shine_in_air(scene: &Scene) -> Option<bool> {
    let earth = scene.body(NaifId::EARTH).expect("the Earth");
    earth.decisions.iter().find(|d| d.effect == "planet-shine-in-air").map(|d| d.on)
}

/// 50 km above the ground the moonlit sky has a twentieth of its light, and is exposed for that, not as on the ground: by night nothing is in daylight below.
/// Negative control: at noon the sky is exposed as on the ground.
#[test]
fn the_moonlit_sky_high_in_the_air_is_exposed_for_its_light() {
    let stops = |time: &str, height_km: f64| {
        let request = ViewRequest { exposure: ExposureRequest::Auto, ..view(time, height_km, up(), "") };
        SESSION.scene(&request).expect("a scene").exposure.stops
    };
    let [by_night, by_day] = [FULL_MOON, NOON].map(|time| stops(time, 50.0) - stops(time, 0.0017));
    println!("50 km up: {by_night:.2} stops more by night, {by_day:.2} by day");
    assert!(by_night > 1.0, "{by_night} stops");
    assert!(by_day.abs() < 0.2, "{by_day} stops");
}

/// The light that the full Moon adds to the sky is that of a sky whose only light is the Moon, in the Sun's place. Bound: 2 %, for the half floats in which a
/// frame may be stored and for moonlight as the difference of two skies. It is 10 to 80 times the light of the moonless sky: by Krisciunas and Schaefer 1991
/// (Publications of the Astronomical Society of the Pacific 103, 1033) a dark sky is some 3.5 magnitudes brighter at full Moon.
#[test]
fn the_full_moon_lights_the_sky_as_a_faint_sun_would() {
    let moonlit = scene(&zenith(FULL_MOON, ""));
    assert_eq!((lights_of_sky(&moonlit), is_shine_in_air(&moonlit)), (2, Some(true)));
    let (with_moon, moonless) = (light(&moonlit), light(&scene(&zenith(FULL_MOON, ",-planet-shine"))));
    let mut moon_as_sun = moonlit;
    for draw in moon_as_sun.draws.iter_mut().filter(|d| d.part == BodyPart::Sky) {
        let (sun, moon) = (draw.uniforms.lights[0], draw.uniforms.lights[1]);
        let irradiance = sun.irradiance * draw.uniforms.air.second_light_irradiance;
        draw.uniforms.lights[0] = Light { irradiance, ..moon };
        (draw.uniforms.air.second_light_irradiance, draw.uniforms.air.night_radiance, draw.uniforms.air.light_from_beyond) =
            (Vec3::ZERO, 0.0, 0.0);
    }
    let expected = light(&moon_as_sun);
    for c in 0..3 {
        let added = with_moon[c] - moonless[c];
        println!("channel {c}: {:.3e} without the Moon, {added:.3e} by the Moon, {:.3e} expected", moonless[c], expected[c]);
        assert!((added / expected[c] - 1.0).abs() < 0.02, "channel {c}: {added:e}, {:e} expected", expected[c]);
    }
    let ratio = (with_moon[1] - moonless[1]) / moonless[1];
    assert!((10.0..80.0).contains(&ratio), "{ratio} times the light of the moonless sky");
    // Negative control: without the Moon nothing is added.
    let dark = scene(&zenith(NEW_MOON, ""));
    let added = light(&dark)[1] / light(&scene(&zenith(NEW_MOON, ",-planet-shine")))[1] - 1.0;
    assert!(added.abs() < 0.02, "{added} of the moonless sky at new Moon");
}

/// By day no sky has a second light: on a display its exposure is too short, and in linear light sunlight hides it.
#[test]
fn by_day_the_air_has_no_second_light() {
    let on_display = ViewRequest { exposure: ExposureRequest::Stops(0.0), ..zenith(NOON, "") };
    let linear = ViewRequest { purpose: Purpose::LINEAR, ..zenith(NOON, "") };
    for (request, expected) in [(on_display, None), (linear, Some(false))] {
        let found = scene(&request);
        assert_eq!((lights_of_sky(&found), is_shine_in_air(&found)), (1, expected));
        assert!(found.draws.iter().all(|d| d.uniforms.air.second_light_irradiance == Vec3::ZERO));
    }
    let by_night = scene(&ViewRequest { purpose: Purpose::LINEAR, ..zenith(FULL_MOON, "") });
    assert_eq!((lights_of_sky(&by_night), is_shine_in_air(&by_night)), (2, Some(true)));
}

/// From 400 km above the moonlit Earth, the air in front of the ground adds moonlight (mostly blue, 30 % or more). Interpolated from the coarse image it is the
/// same as evaluated in each pixel, within 1 % or a thousandth of white; air without moonlight is not.
#[test]
fn the_air_in_front_of_the_ground_is_moonlit() {
    let below = ViewRequest { width: 160, height: 160, fov_deg: Some(90.0), ..view(FULL_MOON, 400.0, -up(), ",-night") };
    let white = f64::exp2(-17.0);
    let interpolated = scene(&below);
    assert!(interpolated.draws.iter().any(|d| d.features.air_pass == AirPass::Read && d.features.lights > 1));
    let per_pixel = scene(&ViewRequest { may_use_coarse_air: false, ..below.clone() });
    let mut unlit_air = scene(&ViewRequest { may_use_coarse_air: false, ..below });
    for draw in &mut unlit_air.draws {
        draw.uniforms.air.second_light_irradiance = Vec3::ZERO;
    }
    let [(_, interpolated), (_, per_pixel), (_, unlit)] = [&interpolated, &per_pixel, &unlit_air].map(image);
    let blue = |hdr: &[[f32; 4]]| hdr.iter().map(|p| f64::from(p[2])).sum::<f64>();
    assert!(blue(&per_pixel) > 1.3 * blue(&unlit), "{} with moonlit air, {} without", blue(&per_pixel), blue(&unlit));
    let greatest = |hdr: &[[f32; 4]]| {
        let differences = hdr
            .iter()
            .zip(&per_pixel)
            .flat_map(|(a, b)| [0, 1, 2].map(|c| (f64::from(a[c]) - f64::from(b[c])).abs() / (0.01 * f64::from(b[c])).max(1e-3 * white)));
        differences.fold(0.0, larger)
    };
    assert!(greatest(&interpolated) < 1.0, "{} times the bound", greatest(&interpolated));
    assert!(greatest(&unlit) > 3.0, "only {} times the bound: the check above cannot fail", greatest(&unlit));
}

/// The luminance that the light meter finds, from the reason of the exposure.
fn metered_cd_m2(scene: &Scene) -> f64 {
    let text = scene.exposure.reason.to_string();
    let number = text.split_once("metered at ").and_then(|(_, rest)| rest.split_once(" cd/m2")).map(|(number, _)| number);
    number.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("no luminance in {text:?}"))
}

/// The meter counts the moonlight that is drawn: the luminance that it finds in the zenith, divided by the drawn light, is by full Moon what it is by day with
/// the Sun as high, within a factor of 1.5. Negative control: an image without moonlight, with the exposure for it.
#[test]
fn the_meter_finds_the_moonlight_that_is_drawn() {
    let metered_per_drawn = |time: &str, drawn_effects: &str| {
        let automatic = ViewRequest { exposure: ExposureRequest::Auto, ..zenith(time, "") };
        let metered = metered_cd_m2(&scene(&automatic));
        metered / light(&scene(&ViewRequest { purpose: Purpose::LINEAR, ..zenith(time, drawn_effects) }))[1]
    };
    let by_day = metered_per_drawn(NOON, "");
    let by_moon = metered_per_drawn(FULL_MOON, "") / by_day;
    assert!((1.0 / 1.5..1.5).contains(&by_moon), "{by_moon} times as much as by day");
    let unlit = metered_per_drawn(FULL_MOON, ",-planet-shine") / by_day;
    assert!(unlit > 5.0, "only {unlit}: the check above cannot fail");
}

/// The moonless sky has the airglow, and of the zodiacal light and starlight from behind the air only what the air scatters, because layers draw the rest: in
/// the zenith, where the clear air removes 5 to 40 % of the light, 0.05 to 0.4 of it.
#[test]
fn zodiacal_light_and_starlight_are_not_part_of_a_clear_sky() {
    let dark = scene(&zenith(NEW_MOON, ",-planet-shine"));
    let of = |part: BodyPart| dark.draws.iter().find(|d| d.part == part).map(|d| &d.uniforms.air).expect("a draw");
    let sky = of(BodyPart::Sky);
    let (airglow, starlight) = (f64::from(sky.night_radiance), f64::from(sky.light_from_beyond));
    let part_of_starlight = |light: f64| (light - airglow) / starlight;
    let found = part_of_starlight(light(&dark)[1]);
    assert!((0.05..0.4).contains(&found), "{found} of the starlight");
    assert!(!(0.05..0.4).contains(&part_of_starlight(airglow + starlight)), "the check above cannot fail");
    // All of it lights the ground.
    let looks_down = scene(&view(NEW_MOON, 0.0017, -up(), ",-planet-shine"));
    let ground = looks_down.draws.iter().find(|d| d.part == BodyPart::Globe).expect("the ground");
    let on_ground = f64::from(ground.uniforms.air.night_radiance);
    assert!((on_ground / (airglow + starlight) - 1.0).abs() < 1e-5, "{on_ground:e} on the ground");
}

/// The moonless sky is exposed as a photograph of the Milky Way: shown at 0.005 to 0.02 of white. With the limit of EV -4 it was at 0.002.
#[test]
fn the_moonless_sky_is_shown_dark_grey() {
    let automatic = scene(&ViewRequest { exposure: ExposureRequest::Auto, ..zenith(NEW_MOON, ",-planet-shine") });
    let drawn = light(&scene(&ViewRequest { purpose: Purpose::LINEAR, ..zenith(NEW_MOON, ",-planet-shine") }))[1];
    let level = drawn * automatic.exposure.factor();
    assert!((0.005..0.02).contains(&level), "{level} of white; {}", automatic.exposure.reason);
}

/// The darker a sky, the darker it is shown: levels of the table of exposures (`EXPOSURE_BY_ALTITUDE`), as `explain` gives them. A view across the direction of
/// the Sun, 30 degrees above the horizon, at the equator at an equinox: the Sun goes down by a degree in 4 minutes.
#[test]
fn the_sky_is_shown_the_darker_the_lower_the_sun_is() {
    let up = DVec3::new(25_f64.to_radians().cos(), -25_f64.to_radians().sin(), 0.0);
    let direction = up * 0.5 + DVec3::Z * 0.75_f64.sqrt();
    // Altitude of the Sun in degrees, and the level.
    for (time, altitude_deg, expected) in [
        ("2026-03-20T16:39:24Z", 47.0, 0.09),
        ("2026-03-20T19:47:24Z", 0.0, 0.09),
        ("2026-03-20T20:03:24Z", -4.0, 0.054),
        ("2026-03-20T20:11:24Z", -6.0, 0.022),
        ("2026-03-20T20:19:24Z", -8.0, 0.013),
        ("2026-03-20T20:35:24Z", -12.0, 0.0099),
    ] {
        let request = ViewRequest {
            position: Position::Ground { body: NaifId::EARTH, latitude_deg: 0.0, longitude_deg: -25.0, height_km: 0.0017 },
            look: Look::Along { direction, axes: Axes::BodyFixed },
            effects: EffectOverrides::parse("-clouds").expect("effects"),
            width: 64,
            height: 64,
            fov_deg: Some(40.0),
            exposure: ExposureRequest::Auto,
            ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
        };
        let text = SESSION.scene(&request).expect("a scene").exposure.reason.to_string();
        let level = text.split_once("shown at ").and_then(|(_, rest)| rest.split_once(" of white")).map(|(number, _)| number);
        let level: f64 = level.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("no level in {text:?}"));
        println!("the Sun at {altitude_deg} degrees: {level}");
        assert!((level / expected - 1.0).abs() < 0.25, "the Sun at {altitude_deg} degrees: {level}, not {expected}");
    }
}
