//! Automatic exposure of bodies in a shadow, alone and next to lit bodies; and the glare of a partly hidden Sun.

use crate::support::folds::{larger, smaller};
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::camera::Placement;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Look, Position, Projection, ViewRequest};
use orrery::scene::{Scene, glare};
use orrery::time::Instant;
use orrery::units::GOLDEN_ANGLE_RAD;

const IO: NaifId = NaifId(501);
const PHOBOS: NaifId = NaifId(401);

fn request(target: NaifId, time: &str, position: Position, fov_deg: Option<f64>) -> ViewRequest {
    ViewRequest { position, fov_deg, width: 128, height: 128, ..ViewRequest::of(target, Instant::parse(time).expect("a time")) }
}

fn without_eclipse(request: &ViewRequest) -> ViewRequest {
    ViewRequest { effects: EffectOverrides::parse("-eclipse").expect("an effect"), ..request.clone() }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

/// The white fraction of the image, and the mean red and blue levels (of 255) of the pixels that are not black.
fn white_and_mean_levels(request: &ViewRequest) -> (f64, [f64; 2]) {
    let frame = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::Display).expect("drawn").frame;
    let white = frame.display.iter().filter(|p| p[..3].iter().all(|v| *v > 250)).count();
    let lit: Vec<_> = frame.display.iter().filter(|p| p[0] > 8).collect();
    let mean = |c: usize| lit.iter().map(|p| f64::from(p[c])).sum::<f64>() / lit.len().max(1) as f64;
    (white as f64 / frame.display.len() as f64, [mean(0), mean(2)])
}

/// Io in Jupiter's shadow, seen from the Earth. Alone in the frame, Io is exposed for the shadow, where at most a ten thousandth of its
/// sunlight remains. When Jupiter fills a tenth of the frame, the exposure is that of a lit Io, and Jupiter is not burnt out.
#[test]
fn a_lit_planet_limits_the_exposure_of_its_eclipsed_moon() {
    let io_at_fov = |fov_deg| request(IO, "2025-03-01T13:00:00Z", Position::Centre(NaifId::EARTH), Some(fov_deg));
    let (alone, next_to_jupiter) = (io_at_fov(0.004), io_at_fov(0.03));
    let stops_gained = |request: &ViewRequest| scene(request).exposure.stops - scene(&without_eclipse(request)).exposure.stops;
    assert!(stops_gained(&alone) > 13.0, "{}", stops_gained(&alone));
    assert!((-0.1..1.5).contains(&stops_gained(&next_to_jupiter)), "{}", stops_gained(&next_to_jupiter));
    let reason = scene(&next_to_jupiter).exposure.reason.to_string();
    assert!(reason.starts_with("Jupiter"), "{reason}");
    let (white, _) = white_and_mean_levels(&next_to_jupiter);
    assert!(white < 0.01, "{white} of the frame is white");
    // With the exposure for Io alone, Jupiter would be burnt out: the check above can fail.
    let stops = scene(&without_eclipse(&next_to_jupiter)).exposure.stops + stops_gained(&alone);
    let (white, _) = white_and_mean_levels(&ViewRequest { exposure: ExposureRequest::Stops(stops), ..next_to_jupiter.clone() });
    assert!(white > 0.05, "{white} of the frame is white");
    // As Jupiter moves into the frame, the exposure decreases towards that of a lit Io and never falls below it.
    let mut previous = f64::MAX;
    for k in 0..20 {
        let request = io_at_fov(0.008 + 0.001 * f64::from(k));
        let stops_gained = stops_gained(&request);
        assert!(stops_gained > -0.1 && stops_gained < previous + 0.5, "{stops_gained} after {previous} at {:?}", request.fov_deg);
        previous = stops_gained;
    }
    assert!(previous < 2.0, "{previous}");
}

/// The numbers in a text that stand between two texts.
fn numbers_between(text: &str, before: &str, after: &str) -> Vec<f64> {
    text.split(before).skip(1).filter_map(|rest| rest.split_once(after)?.0.parse().ok()).collect()
}

/// What the reason of a metered exposure says: luminance of the main subject in cd/m2, the level at which it is shown, and its aim; and the stops by which
/// other subjects and a limit move it from its aim.
fn metered_levels(reason: &str) -> ([f64; 3], Vec<f64>) {
    let number = |before: &str, after: &str| numbers_between(reason, before, after).first().copied();
    let luminance_cd_m2 = number("metered at ", " cd/m2").expect(reason);
    let level = number("shown at ", " of white").expect(reason);
    let aim = number("(aim: ", ")").unwrap_or(level);
    ([luminance_cd_m2, level, aim], numbers_between(reason, "%: ", " stops").into_iter().chain(limit_stops(reason)).collect())
}

/// The stops by which a limit darkens an image.
fn limit_stops(reason: &str) -> Option<f64> {
    let (_, limit) = reason.split_once("; limited ")?;
    limit.split_once(": ")?.1.strip_suffix(" stops")?.parse().ok()
}

/// The reason gives the level at which the exposure shows the subject that was metered, and what moves it from its aim: another subject (the Moon as a point by
/// night), the Sun's glare, the limit of night photographs. Negative control: the aim is not that level. The Moon alone, as a large disc, is shown at its aim.
#[test]
fn the_reason_says_at_which_level_a_subject_is_shown() {
    let (moon, titan, from_earth) = (NaifId::MOON, NaifId(606), Position::Centre(NaifId::EARTH));
    let on_the_ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 25.0, longitude_deg: 10.0, height_km: 0.0017 };
    let of_size = |side: u32, request: ViewRequest| ViewRequest { width: side, height: side, ..request };
    let full_moon = "2024-01-25T22:00:00Z";
    let dark_sky = ViewRequest {
        look: Look::Along { direction: DVec3::new(0.1, -0.3, 1.0), axes: Axes::Icrf },
        target: None,
        ..request(NaifId::EARTH, "2024-03-01T00:00:00Z", from_earth, Some(5.0))
    };
    for (request, moved_by) in [
        (of_size(256, request(moon, full_moon, on_the_ground, Some(90.0))), "the sky of Earth at"),
        (of_size(1024, request(moon, full_moon, on_the_ground, Some(90.0))), "the sky of Earth at"),
        (request(PHOBOS, "2024-04-05T20:12:00Z", from_earth, Some(20.0)), "contributes"),
        (of_size(1024, request(moon, "2024-09-23T17:57:00Z", Position::Centre(titan), Some(5.0))), "limited by the Sun's glare: "),
        (dark_sky, "limited to a night-sky photograph, EV -6.5: -0.25 stops"),
        (request(moon, full_moon, from_earth, None), ""),
    ] {
        let exposure = scene(&request).exposure;
        let reason = exposure.reason.to_string();
        let ([luminance_cd_m2, level, aim], moved_stops) = metered_levels(&reason);
        // A white plane in sunlight, radiance 1, has 128 klx / pi.
        let drawn_level = luminance_cd_m2 * exposure.stops.exp2() / (128_000.0 / std::f64::consts::PI);
        // Levels are rounded to two digits, the first perhaps a 1.
        assert!((drawn_level / level).log2().abs() < 0.08, "{drawn_level}: {reason}");
        assert_eq!((drawn_level / aim).log2().abs() > 0.1, !moved_by.is_empty(), "{drawn_level}: {reason}");
        assert!(reason.contains(moved_by) && moved_stops.is_empty() == moved_by.is_empty(), "{reason}");
        // The text leaves out what moves the exposure by less than 0.1 stops: the dark sky, a faint body.
        assert!(((level / aim).log2() - moved_stops.iter().sum::<f64>()).abs() < 0.25, "{moved_stops:?}: {reason}");
    }
}

/// Low over Saturn, where the rings take the sunlight from all ground in the frame. Metered in full sunlight, the image would be black.
#[test]
fn ground_in_the_shadow_of_rings_is_exposed_for_the_shadow() {
    let at = |latitude_deg: f64, effects: &str| {
        let position = Position::Ground { body: NaifId(699), latitude_deg, longitude_deg: -138.2, height_km: 431.0 };
        let effects = EffectOverrides::parse(effects).expect("effects");
        ViewRequest { effects, ..request(NaifId(699), "1964-06-06T21:00:00Z", position, Some(3.53)) }
    };
    let stops = |latitude_deg: f64, effects: &str| scene(&at(latitude_deg, effects)).exposure.stops;
    let gained = stops(-15.18, "") - stops(-15.18, "-ring-shadow");
    assert!(gained > 1.5, "{gained} stops");
    let (_, [red, _]) = white_and_mean_levels(&at(-15.18, ""));
    assert!((40.0..230.0).contains(&red), "{red} of 255");
}

/// The eclipsed Moon of 8 November 2022 is exposed for the shadow and looks red, both alone in front of the stars and next to the Earth's
/// night side; next to the Earth's day side it is not exposed for the shadow.
#[test]
fn the_exposure_shows_the_red_moon_unless_the_earths_day_side_is_in_view() {
    let time = "2022-11-08T11:00:00Z";
    let eclipsed_moon = request(NaifId::MOON, time, Position::AboveTarget { towards: None, distance_radii: None }, None);
    let (white, [r, b]) = white_and_mean_levels(&eclipsed_moon);
    assert!(white < 0.01 && r > 100.0 && r > 2.0 * b, "{white} of the frame is white, {r} red and {b} blue");
    let stops_gained = |request: &ViewRequest| scene(request).exposure.stops - scene(&without_eclipse(request)).exposure.stops;
    assert!(stops_gained(&eclipsed_moon) > 8.0, "{}", stops_gained(&eclipsed_moon));
    let from_earth = |sunward_radii: f64| {
        let base = scene(&request(NaifId::MOON, time, Position::Centre(NaifId::EARTH), Some(1.0)));
        let away = base.body(NaifId::MOON).expect("the Moon").placement.centre_km.normalize();
        let offset_km = (away.cross(DVec3::Z).normalize() * 1.5 - away * sunward_radii) * 6378.0;
        let position = Position::Offset { body: NaifId::EARTH, offset_km, axes: Axes::Icrf };
        request(NaifId::MOON, time, position, Some(130.0))
    };
    let (night, day) = (stops_gained(&from_earth(0.0)), stops_gained(&from_earth(1.5)));
    assert!(night > 8.0, "next to the night side: {night}");
    assert!(day < 1.5, "next to the day side: {day}");
}

/// Visible fraction of the Sun's disc behind an ellipsoid, sampled by rays to 4000 points of the disc.
fn visible_fraction_by_rays(body: &Placement, sun: &Placement) -> f64 {
    const RAYS: usize = 4000;
    let towards_sun = sun.centre_km.normalize();
    let (x, y) = towards_sun.any_orthonormal_pair();
    let sun_angular_radius = (sun.radii_km.x / sun.centre_km.length()).asin();
    let origin = body.camera_in_unit_sphere();
    let is_unblocked = |k: &usize| {
        // Steps of the golden angle spread the points evenly.
        let (sin, cos) = (*k as f64 * GOLDEN_ANGLE_RAD).sin_cos();
        let offset = DVec2::new(cos, sin) * sun_angular_radius * ((*k as f64 + 0.5) / RAYS as f64).sqrt();
        let ray = body.direction_in_unit_sphere(towards_sun + x * offset.x + y * offset.y).normalize();
        origin.dot(ray) > 0.0 || origin.cross(ray).length() > 1.0
    };
    (0..RAYS).filter(is_unblocked).count() as f64 / RAYS as f64
}

/// The Sun emerges from behind Phobos, whose longest axis is about 1.5 times its shortest: the glare is proportional to the visible
/// fraction of the disc, which rays measure.
#[test]
fn a_partly_hidden_sun_has_glare_in_proportion_to_its_visible_part() {
    // Seen from Phobos, Mars comes near the Sun only an hour later.
    let time = "2024-04-24T06:00:00Z";
    let lit = scene(&request(PHOBOS, time, Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(6.0) }, None));
    let body = lit.body(PHOBOS).expect("Phobos").placement;
    let sun = (body.body_from_icrf * lit.body(NaifId::SUN).expect("the Sun").placement.centre_km).normalize();
    for sideways in [sun.cross(DVec3::Z).normalize(), sun.cross(DVec3::Z).cross(sun).normalize()] {
        let (mut hidden, mut partial, mut unhidden) = (0, 0, 0);
        for k in 0..70 {
            let offset_km = sideways * (8.0 + 0.1 * f64::from(k)) - sun * 60.0;
            let position = Position::Offset { body: PHOBOS, offset_km, axes: Axes::BodyFixed };
            let scene = scene(&ViewRequest { exposure: ExposureRequest::Stops(0.0), ..request(PHOBOS, time, position, Some(60.0)) });
            let sun = scene.body(NaifId::SUN).expect("the Sun").placement;
            let expected = visible_fraction_by_rays(&scene.body(PHOBOS).expect("Phobos").placement, &sun);
            let unhidden_glare = glare::VEILING_GLARE_COEFFICIENT * (orrery::units::KM_PER_AU / sun.centre_km.length()).powi(2);
            let glare_fraction = scene.glare.map_or(0.0, |g| f64::from(g.strength.x) / unhidden_glare);
            assert!((glare_fraction - expected).abs() < 0.03, "{k} along {sideways}: {glare_fraction}, {expected} by rays");
            match expected {
                0.0 => hidden += 1,
                1.0 => unhidden += 1,
                _ => partial += 1,
            }
        }
        assert!(hidden > 5 && partial > 1 && unhidden > 5, "{hidden} {partial} {unhidden}");
    }
}

/// Twelve seconds after totality the glare surrounds the crescent, not the middle of the Moon's disc. Before first contact it surrounds the Sun.
#[test]
fn the_glare_of_a_crescent_sun_surrounds_the_crescent() {
    let dallas = Position::Ground { body: NaifId::EARTH, latitude_deg: 32.78, longitude_deg: -96.8, height_km: 0.0017 };
    // The middle of the glare from the Sun's middle, in solar radii: away from the Moon, and across that direction. And the square of its core's radius.
    let found = |time: &str| {
        let scene = scene(&request(NaifId::SUN, time, dallas, Some(1.5)));
        let glare = scene.glare.expect("glare");
        let across = |id: NaifId| {
            let towards = scene.body(id).expect("there").placement.centre_km.normalize();
            DVec2::new(towards.dot(scene.camera.right), towards.dot(scene.camera.up))
        };
        let sun = scene.body(NaifId::SUN).expect("the Sun").placement;
        let radius = sun.radii_km.x / sun.centre_km.length();
        let offset = (glare.sun_direction.truncate().as_dvec2() - across(NaifId::SUN)) / radius;
        let away = (across(NaifId::SUN) - across(NaifId::MOON)).normalize();
        (offset.dot(away), offset.perp_dot(away), f64::from(glare.core_angle_sq) / (radius * radius))
    };
    let (away, sideways, core) = found("2024-04-08T18:44:45Z");
    assert!((0.8..1.0).contains(&away) && sideways.abs() < 0.05 && core < 0.1, "{away} {sideways} {core}");
    let (away, sideways, core) = found("2024-04-08T17:00:00Z");
    assert!(away.abs() < 1e-3 && sideways.abs() < 1e-3 && (core - 1.0).abs() < 1e-3, "{away} {sideways} {core}");
}

/// A view of the whole system shows only the dark sky, which is far fainter than the Sun's glare: the image is nearly black, not grey. The median level is
/// at most 16 of 255. At 2.7 stops more, as for a subject that the glare does not hide, it is grey.
#[test]
fn the_dark_sky_behind_the_glare_is_nearly_black() {
    let position = Position::AboveTarget { towards: None, distance_radii: Some(12_000.0) };
    let whole_system = request(NaifId::SUN, "2024-06-08T00:00:00Z", position, Some(60.0));
    let median = |request: &ViewRequest| {
        let frame = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::Display).expect("drawn").frame;
        let mut reds: Vec<u8> = frame.display.iter().map(|p| p[0]).collect();
        reds.sort_unstable();
        reds[reds.len() / 2]
    };
    assert!((4..=16).contains(&median(&whole_system)), "{} of 255", median(&whole_system));
    let stops = scene(&whole_system).exposure.stops + 2.7;
    let brighter = ViewRequest { exposure: ExposureRequest::Stops(stops), ..whole_system };
    assert!(median(&brighter) > 30, "{} of 255", median(&brighter));
}

/// A camera at a body's centre sees the Sun as from beside the body, which is not in front of it. From the Sun's centre there is no glare, and the exposure
/// of a planet is that of the planet.
#[test]
fn the_exposure_from_a_body_s_centre_is_that_from_beside_it() {
    let stops = |target, position, fov_deg| scene(&request(target, "2024-06-08T04:00:00Z", position, Some(fov_deg))).exposure.stops;
    let beside = |body| Position::Offset { body, offset_km: DVec3::Z * 2e6, axes: Axes::Icrf };
    for fov_deg in [0.55, 5.0, 20.0] {
        let (centre, beside) =
            (stops(NaifId::SUN, Position::Centre(NaifId::EARTH), fov_deg), stops(NaifId::SUN, beside(NaifId::EARTH), fov_deg));
        assert!((centre - beside).abs() < 0.1, "{fov_deg}: {centre} from the centre, {beside} beside the Earth");
    }
    let (centre, beside) = (stops(NaifId::EARTH, Position::Centre(NaifId::SUN), 0.01), stops(NaifId::EARTH, beside(NaifId::SUN), 0.01));
    assert!((centre - beside).abs() < 0.1, "{centre} from the centre, {beside} beside the Sun");
}

/// A camera at the centre of a body, a millimetre above its ground at the equator and at the pole, and a tenth of a radius over the pole: the exposure is a
/// number, between that of the Sun's disc from its surface and that of the night sky.
#[test]
fn a_camera_at_or_on_a_body_has_an_exposure() {
    let time = "2024-04-08T18:42:38Z";
    let mut metered = 0;
    for body in [10, 399, 301, 401, 599, 699, 999].map(NaifId) {
        let ground = |latitude_deg: f64| Position::Ground { body, latitude_deg, longitude_deg: 0.0, height_km: 1e-6 };
        let radius_km = SESSION.catalog().body(body).expect("a body").radii_km.z;
        let over_pole = Position::Offset { body, offset_km: DVec3::Z * (1.1 * radius_km), axes: Axes::BodyFixed };
        for (position, target) in [Position::Centre(body), ground(0.0), ground(90.0), over_pole]
            .into_iter()
            .flat_map(|position| [NaifId::SUN, NaifId::EARTH].map(|target| (position, target)))
        {
            if position == Position::Centre(target) {
                continue;
            }
            let view = ViewRequest { width: 16, height: 16, ..request(target, time, position, Some(60.0)) };
            let stops = scene(&view).exposure.stops;
            assert!((-17.0..22.0).contains(&stops), "{body:?}, {position:?} to {target:?}: {stops}");
            metered += 1;
        }
    }
    assert_eq!(metered, 7 * 8 - 2);
}

/// Near the terminator the Moon's ground is exposed for the light on its slopes, which are lit up to three degrees beyond it: at half of white for the mean
/// slope. The slopes of a dozen places differ so much that the mean over them is far from it (measured: 0.025 of white at -2 degrees, where two of the places
/// have nearly all the light; where single slopes are bright, these highlights are protected). On smooth ground the
/// meter would see night beyond the terminator: at that exposure the slopes are some 40 to 1400 times white.
#[test]
fn ground_at_the_terminator_is_exposed_for_its_slopes() {
    let at = |latitude_deg: f64, longitude_deg: f64| {
        let position = Position::Ground { body: NaifId::MOON, latitude_deg, longitude_deg, height_km: 0.3 };
        ViewRequest { width: 24, height: 24, ..request(NaifId::MOON, "1909-07-27T06:00:00Z", position, None) }
    };
    let sub_solar = scene(&at(0.0, 0.0)).body(NaifId::MOON).expect("the Moon").sub_solar.expect("lit");
    let (sin_sun, cos_sun) = sub_solar.lat_centric_deg.to_radians().sin_cos();
    for altitude_deg in [-2.0_f64, -1.0, 0.0, 1.0, 3.0, 8.0] {
        let (mut levels, mut levels_as_smooth) = (Vec::new(), Vec::new());
        for (k, latitude_deg) in (-55..=55).step_by(10).enumerate() {
            let (sin_lat, cos_lat) = f64::from(latitude_deg).to_radians().sin_cos();
            let hour_angle_deg = ((altitude_deg.to_radians().sin() - sin_lat * sin_sun) / (cos_lat * cos_sun)).acos().to_degrees();
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let longitude_deg = (sub_solar.lon_east_deg + side * hour_angle_deg + 180.0).rem_euclid(360.0) - 180.0;
            let view = at(f64::from(latitude_deg), longitude_deg);
            let drawn = SESSION.draw(&view, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
            let light = drawn.frame.hdr.iter().map(|p| f64::from(p[0].max(p[1]).max(p[2]))).sum::<f64>() / drawn.frame.hdr.len() as f64;
            levels.push(light / drawn.scene.exposure.white());
            let smooth = ViewRequest { effects: EffectOverrides::parse("-normal,-detail").expect("effects"), ..view };
            levels_as_smooth.push(light / scene(&smooth).exposure.white());
        }
        let mean = |levels: &[f64]| levels.iter().sum::<f64>() / levels.len() as f64;
        assert!((0.02..4.0).contains(&mean(&levels)), "{altitude_deg} degrees: {levels:?}");
        assert!(altitude_deg > 0.0 || mean(&levels_as_smooth) > 10.0, "{altitude_deg} degrees, metered as smooth: {levels_as_smooth:?}");
    }
}

/// The air dims a low Sun, and with it the Sun's glare: at sunset a view towards the Sun is exposed for its sky, not for a glare that is not there. In the
/// afternoon the air passes most of the glare, which lowers the exposure a little.
#[test]
fn the_glare_of_a_setting_sun_is_metered_through_the_air() {
    const MERCURY: NaifId = NaifId(199);
    let position = Position::Ground { body: NaifId::EARTH, latitude_deg: 0.0, longitude_deg: 0.0, height_km: 0.0017 };
    let stops_lost = |time: &str| {
        let with_glare = request(MERCURY, time, position, Some(50.0));
        let without_glare = ViewRequest { effects: EffectOverrides::parse("-glow").expect("an effect"), ..with_glare.clone() };
        let drawn = scene(&with_glare);
        assert!(drawn.glare.is_some(), "{time}: no glare");
        scene(&without_glare).exposure.stops - drawn.exposure.stops
    };
    for time in ["2024-06-16T17:50:00Z", "2024-06-16T17:56:00Z"] {
        assert!(stops_lost(time) < 1.0, "{time}: {} stops darker", stops_lost(time));
    }
    let in_the_afternoon = stops_lost("2024-06-16T16:00:00Z");
    assert!((0.03..0.5).contains(&in_the_afternoon), "{in_the_afternoon}");
}

/// In a small image the sprite of a Sun of less than two pixels has a glare as bright as that around the Sun. It lowers the exposure, so that it does not
/// whiten the image; a large image, of which the sprite covers little, does not change.
#[test]
fn the_sprite_of_a_point_like_sun_is_metered() {
    let position = Position::AboveTarget { towards: Some(NaifId(599)), distance_radii: Some(4.0) };
    let crescent_moon = request(NaifId::MOON, "2024-12-28T00:00:00Z", position, Some(60.0));
    let at = |side: u32| ViewRequest { width: side, height: side, ..crescent_moon.clone() };
    let stops_of_large_image = scene(&at(400)).exposure.stops;
    let stops_lost = stops_of_large_image - scene(&at(40)).exposure.stops;
    assert!((0.7..2.5).contains(&stops_lost), "{stops_lost}");
    let (white, _) = white_and_mean_levels(&at(40));
    let (white_before, _) = white_and_mean_levels(&ViewRequest { exposure: ExposureRequest::Stops(stops_of_large_image), ..at(40) });
    assert!(white < 0.13 && white_before > 1.4 * white, "{white}, {white_before} with the exposure of the large image");
}

/// The veil around the Sun and the glare of its sprite are switched by different effects: each that is drawn lowers the exposure of a small image, and none
/// that is not drawn does.
#[test]
fn only_the_glare_that_is_drawn_is_metered() {
    let position = Position::AboveTarget { towards: Some(NaifId(599)), distance_radii: Some(4.0) };
    let crescent_moon = request(NaifId::MOON, "2024-12-28T00:00:00Z", position, Some(60.0));
    let stops = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        scene(&ViewRequest { width: 40, height: 40, effects, ..crescent_moon.clone() }).exposure.stops
    };
    let (both, veil, sprite, none) = (stops(""), stops("-points"), stops("-glow"), stops("-glow,-points"));
    assert!(veil - both > 0.5 && none - veil > 0.5, "{both} with both, {veil} with the veil, {none} without glare");
    assert!(none - sprite > 0.5, "{sprite} with the sprite, {none} without glare");
    // In a whole-sphere image of this size a sprite is at most 16 pixels high.
    let of_sphere = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        let composition = Composition { projection: Projection::Equirectangular, ..Composition::default() };
        let view = ViewRequest { width: 80, height: 40, fov_deg: None, effects, composition, ..crescent_moon.clone() };
        SESSION.draw(&view, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::Display).expect("drawn").scene.exposure.stops
    };
    let (sprite, none) = (of_sphere("-glow"), of_sphere("-glow,-points"));
    assert!((none - sprite).abs() < 0.3, "whole sphere: {sprite} with the sprite, {none} without glare");
}

/// Near the Sun the corona covers the entire sky. It is metered there, too, also in a view away from the Sun, which would be white if it were exposed for a
/// dark sky.
#[test]
fn the_corona_around_a_camera_is_metered() {
    for height_km in [7e5, 2e6, 2.9e6, 3.1e6] {
        let position = Position::Ground { body: NaifId::SUN, latitude_deg: 60.0, longitude_deg: -60.0, height_km };
        let away = ViewRequest { width: 40, height: 40, ..request(NaifId(502), "2022-02-13T01:00:00Z", position, Some(30.0)) };
        let metered = scene(&away);
        assert!(metered.corona.is_some() && metered.glare.is_none(), "{height_km} km");
        let (white, _) = white_and_mean_levels(&away);
        assert!(white < 0.5, "{height_km} km: {white} of the frame is white at {} stops", metered.exposure.stops);
    }
}

/// The Sun behind the Earth, seen from the Moon's distance: only its refracted image at the limb is left. The exposure is the same on whichever side of the
/// Earth that image is, in wide and in tall images, although the limb is nearer to the frame's edge at the top of one and at the sides of the other.
#[test]
fn the_exposure_of_a_refracted_sun_does_not_depend_on_its_side() {
    let time = "2022-11-08T11:00:00Z";
    let instant = Instant::parse(time).expect("a time");
    let towards_sun = -SESSION.ephemeris().state(NaifId::EARTH, NaifId::SUN, instant, None).expect("a position").state.pos_km.normalize();
    let right = towards_sun.cross(DVec3::Z).normalize();
    let up = right.cross(towards_sun);
    let at = |side: DVec3, (width, height): (u32, u32), effects: &str| {
        // The Sun's centre is 0.6 degrees from the Earth's, whose radius is 0.95 degrees.
        let separation = 0.6_f64.to_radians();
        let towards_earth = towards_sun * separation.cos() + side * separation.sin();
        let position = Position::Offset { body: NaifId::EARTH, offset_km: towards_earth * -384_400.0, axes: Axes::Icrf };
        let effects = EffectOverrides::parse(effects).expect("effects");
        let fov_deg = 2.6 * f64::from(height) / f64::from(width.min(height));
        scene(&ViewRequest { width, height, effects, ..request(NaifId::EARTH, time, position, Some(fov_deg)) }).exposure.stops
    };
    for size in [(256, 144), (144, 256), (128, 128)] {
        let stops = [right, -right, up, -up].map(|side| at(side, size, ""));
        println!("{size:?}: {stops:?}");
        let (least, most) = (stops.into_iter().fold(f64::INFINITY, smaller), stops.into_iter().fold(f64::NEG_INFINITY, larger));
        assert!(most - least < 1.0, "{size:?}: {stops:?}");
        // Without the refracted image the exposure is that of the night side: a side on which the image is not metered would differ by as much.
        let without_limb = at(right, size, "-refracted-limb");
        assert!(without_limb > most + 8.0, "{size:?}: {without_limb}, {stops:?}");
    }
}
