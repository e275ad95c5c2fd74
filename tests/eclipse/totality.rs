//! Totality: the corona follows its law, the Moon is dark in front of it, and the planets appear next to it.

use crate::support::folds::{larger, smaller};
use crate::support::session::SESSION;
use glam::{DVec3, Vec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::effects::VISIBLE_LIGHT;
use orrery::scene::purpose::Purpose;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, ViewRequest};
use orrery::scene::{Appearance, Scene, corona};
use orrery::session::{DrawnFrame, Session, Sources};
use orrery::time::Instant;
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// Luminance of one unit of radiance, cd/m2: a white plane that faces the Sun at 1 au.
pub(super) const UNIT_CD_M2: f64 = 133_000.0 / PI;

/// Dallas, near the middle of totality on 2024-04-08.
pub(super) const DALLAS: (f64, f64) = (32.78, -96.80);

pub(super) const TOTALITY: &str = "2024-04-08T18:42:38Z";

pub(super) fn parse_time(time: &str) -> Instant {
    Instant::parse(time).expect("a time")
}

pub(super) fn request(target: NaifId, time: Instant, fov_deg: f64, size: u32, stops: f64, effects: &str) -> ViewRequest {
    ViewRequest {
        width: size,
        height: size,
        fov_deg: Some(fov_deg),
        exposure: ExposureRequest::Stops(stops),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(target, time)
    }
}

pub(super) fn on_ground(body: NaifId, (latitude_deg, longitude_deg): (f64, f64)) -> Position {
    Position::Ground { body, latitude_deg, longitude_deg, height_km: 0.002 }
}

pub(super) fn drawn(request: &ViewRequest) -> DrawnFrame {
    SESSION.draw(request, SAMPLING, FrameImages::DisplayAndHdr).expect("draws")
}

fn luminance(p: &[f32; 4]) -> f64 {
    orrery::units::luminance([p[0], p[1], p[2]].map(f64::from))
}

fn decision(scene: &Scene, body: NaifId, effect: &str) -> (bool, String) {
    let body = scene.body(body).expect("a body");
    let d = body.decisions.iter().find(|d| d.effect == effect).unwrap_or_else(|| panic!("{effect} of {}", body.name));
    (d.on, d.reason.to_string())
}

/// A pixel at `radius` solar radii from the Sun's centre, at `angle` (radians) from its equator.
struct SunPixel {
    radius: f64,
    angle: f64,
    luminance: f64,
}

/// Sine of the Sun's angular radius.
fn sun_radius_sine(scene: &Scene) -> f64 {
    let sun = scene.body(NaifId::SUN).expect("the Sun");
    sun.placement.radii_km.x / sun.distance_km
}

fn around_sun(drawn: &DrawnFrame) -> Vec<SunPixel> {
    let sun = drawn.scene.body(NaifId::SUN).expect("the Sun");
    let camera = &drawn.scene.camera;
    let towards = sun.placement.centre_km.normalize();
    let pole = sun.placement.body_from_icrf.row(2);
    let north = (pole - towards * pole.dot(towards)).normalize();
    let sun_radius_sine = sun_radius_sine(&drawn.scene);
    let pixel = |(k, p): (usize, &[f32; 4])| {
        let pixel_centre = glam::DVec2::new(k as f64 % f64::from(camera.width) + 0.5, (k / camera.width as usize) as f64 + 0.5);
        let ray = camera.ray(camera.clip_from_pixel(pixel_centre)).normalize();
        let across = ray - towards * ray.dot(towards);
        SunPixel {
            radius: across.length() / sun_radius_sine,
            angle: across.dot(north).atan2(across.dot(towards.cross(north))),
            luminance: luminance(p),
        }
    };
    drawn.frame.hdr.iter().enumerate().map(pixel).collect()
}

/// The unobstructed Sun from the Earth's centre, through optics without glare.
fn bare_sun(time: &str, fov_deg: f64, size: u32) -> DrawnFrame {
    let space = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        ..request(NaifId::SUN, parse_time(time), fov_deg, size, 12.0, "+corona,-glow,-points,-albedo")
    };
    drawn(&space)
}

/// The corona and the glare are drawn in rectangles, at whose edges no line may show: in faint light, neighbouring pixels differ by less than a third of the
/// faintest visible light.
#[test]
fn faint_light_around_the_sun_has_no_sharp_edge() {
    for (fov_deg, stops, effects) in
        [(20.0, 7.0, "+corona,-glow"), (40.0, 8.0, "+corona,-glow"), (20.0, -14.0, "-corona,+glow"), (60.0, -11.0, "-corona,+glow")]
    {
        let request_in_space = ViewRequest {
            position: Position::Centre(NaifId::EARTH),
            layers: Layers::parse("-stars").expect("a layer"),
            ..request(NaifId::SUN, parse_time("2022-03-01T00:00:00Z"), fov_deg, 400, stops, &format!("{effects},-points"))
        };
        let image = drawn(&request_in_space);
        let faintest = VISIBLE_LIGHT * image.scene.exposure.white();
        let light: Vec<f64> = image.frame.hdr.iter().map(|p| f64::from(p[0].max(p[1]).max(p[2]))).collect();
        assert!(
            light.iter().any(|l| *l > 10.0 * faintest) && light.contains(&0.0),
            "{fov_deg} degrees: the light must begin and end inside the image"
        );
        let rows = light.windows(2).enumerate().filter(|(k, _)| k % 400 != 399).map(|(_, w)| (w[0], w[1]));
        let columns = (0..light.len() - 400).map(|k| (light[k], light[k + 400]));
        let worst =
            rows.chain(columns).filter(|(a, b)| a.max(*b) < 3.0 * faintest).map(|(a, b)| (a - b).abs() / faintest).fold(0.0, larger);
        println!("{fov_deg} degrees, {effects}: {worst:.3}");
        assert!(worst < 0.33, "{fov_deg} degrees, {effects}: a step of {worst} of the faintest light that shows");
    }
}

/// The mean light of rings around the Sun against the mean of the law over their pixels, with pixels of 0.035 to 0.47 solar radii.
#[test]
fn the_corona_follows_its_law_at_every_scale() {
    for (fov_deg, size) in [(1.2, 128), (3.0, 160), (8.0, 200), (12.0, 96)] {
        let image = bare_sun("2022-03-01T00:00:00Z", fov_deg, size);
        let all = around_sun(&image);
        let pixel = 2.0 * (fov_deg.to_radians() / 2.0).tan() / f64::from(size);
        let pixel_radii = pixel / sun_radius_sine(&image.scene);
        // A pixel belongs to the ring that contains its centre. The first ring begins beyond the disc's soft edge.
        let edges: Vec<f64> =
            (0..6).map(|k| (1.0 + 1.5 * pixel_radii) * (1.25_f64).powi(k)).filter(|r| *r < 0.45 * f64::from(size) * pixel_radii).collect();
        let mut rings = 0;
        for ring in edges.windows(2) {
            let ring_pixels: Vec<&SunPixel> = all.iter().filter(|p| (ring[0]..ring[1]).contains(&p.radius)).collect();
            if ring_pixels.len() < 60 {
                continue;
            }
            let measured = ring_pixels.iter().map(|p| p.luminance).sum::<f64>() / ring_pixels.len() as f64;
            // The law averaged over 5 x 5 points in each pixel. The pixel's sides are taken along and across the radius, because the law is round.
            let subpixel = |k: i32| (f64::from(k) - 2.0) / 5.0 * pixel_radii;
            let law_in_pixel = |p: &&SunPixel| {
                (0..25).map(|k| corona::radiance((p.radius + subpixel(k % 5)).hypot(subpixel(k / 5)).max(1.0))).sum::<f64>() / 25.0
            };
            let expected = ring_pixels.iter().map(law_in_pixel).sum::<f64>() / ring_pixels.len() as f64;
            // Measured error: 0.6 %.
            assert!((measured / expected - 1.0).abs() < 0.01, "{fov_deg} degrees, {size} px, {ring:?}: {measured:e} for {expected:e}");
            rings += 1;
        }
        assert!(rings >= 2, "{fov_deg} degrees, {size} px: {rings} rings of 60 pixels or more");
        // The middle of the disc shows the Sun itself: a million times brighter than the corona.
        let middle = all.iter().filter(|p| p.radius < 0.8).map(|p| p.luminance).fold(f64::MAX, smaller);
        assert!(middle > 2e4, "{middle}");
    }
}

/// From an image: the corona's total light is a millionth of the Sun's (Allen's Astrophysical Quantities, 4th ed., 14.8: 0.6e-6 at minimum to 1.3e-6 at maximum
/// beyond 1.03 radii).
#[test]
fn the_corona_gives_a_millionth_of_the_suns_light() {
    let all = around_sun(&bare_sun("2022-03-01T00:00:00Z", 6.0, 300));
    let disc: f64 = all.iter().filter(|p| p.radius < 0.99).map(|p| p.luminance).sum();
    let corona: f64 = all.iter().filter(|p| p.radius > 1.03).map(|p| p.luminance).sum();
    let light_ratio = corona / disc;
    assert!((0.5e-6..2e-6).contains(&light_ratio), "{light_ratio:e}");
}

/// Isophotes of an image measured by Ludendorff's method: the mean of the diameters along the equator and 22.5 degrees to either side, divided by the mean
/// about the poles, minus 1.
#[test]
fn the_flattening_of_the_corona_follows_the_solar_cycle() {
    let measured_flattening = |time: &str| {
        let all = around_sun(&bare_sun(time, 4.0, 240));
        let level = corona::radiance(2.0);
        let radius = |angle_deg: f64| {
            let near = |p: &&SunPixel| {
                let difference_deg = (p.angle.to_degrees() - angle_deg).rem_euclid(180.0);
                difference_deg.min(180.0 - difference_deg) < 4.0
            };
            // The radius at which the brightness crosses the level, on the straight line fitted to the logarithms of radius and brightness.
            let sector: Vec<_> = all.iter().filter(near).filter(|p| (1.5..2.6).contains(&p.radius)).collect();
            let (n, sum_x, sum_y, sum_xx, sum_xy) =
                sector.iter().fold((0.0, 0.0, 0.0, 0.0, 0.0), |(n, sum_x, sum_y, sum_xx, sum_xy), p| {
                    let (x, y) = (p.luminance.ln(), p.radius.ln());
                    (n + 1.0, sum_x + x, sum_y + y, sum_xx + x * x, sum_xy + x * y)
                });
            let slope = (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
            ((sum_y - slope * sum_x) / n + slope * level.ln()).exp()
        };
        let mean = |a: f64| (radius(a) + radius(a - 22.5) + radius(a + 22.5)) / 3.0;
        mean(0.0) / mean(90.0) - 1.0
    };
    for (time, is_round) in
        [("1976-03-01T00:00:00Z", false), ("2019-12-01T00:00:00Z", false), ("2024-04-08T00:00:00Z", true), ("2001-01-01T00:00:00Z", true)]
    {
        let (measured, expected) = (measured_flattening(time), corona::flattening(parse_time(time)));
        // Measured error: 0.02, from the curvature of the isophote within the sectors.
        assert!((measured - expected).abs() < 0.05, "{time}: {measured:.3} for {expected:.3}");
        assert_eq!(measured < 0.12, is_round, "{time}: {measured:.3}");
    }
}

/// The corona is part of the scene when it is visible: not if the exposure is too short, not in the glare of more than a thin ring of the Sun, and not beside
/// the disc of a Sun smaller than a pixel.
#[test]
fn the_corona_is_drawn_when_it_can_be_seen() {
    let from_ground = |time: &str, place, stops| {
        let view = ViewRequest { position: on_ground(NaifId::EARTH, place), ..request(NaifId::SUN, parse_time(time), 3.0, 32, stops, "") };
        SESSION.scene(&view).expect("a scene")
    };
    for stops in [-12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 16.0, 24.0] {
        let (is_on, reason) = decision(&from_ground(TOTALITY, DALLAS, stops), NaifId::SUN, "corona");
        // At -10.5 stops the corona next to the limb is as bright as the faintest light that a display shows.
        let is_bright_enough = stops > -10.5;
        assert_eq!(is_on, is_bright_enough, "totality at {stops} stops: {reason}");
        // The annular eclipse of 2023 in Albuquerque, whose glare at the limb is 120 times as bright as the corona; a partial phase; no eclipse. In the last
        // two the glare is 2000 times as bright, so the corona changes it by less than the 1/512 that a display shows.
        for (time, place, is_annular) in [
            ("2023-10-14T16:37:00Z", (35.08, -106.65), true),
            ("2024-04-08T17:30:00Z", DALLAS, false),
            ("2024-06-08T17:30:00Z", DALLAS, false),
        ] {
            let (is_on, reason) = decision(&from_ground(time, place, stops), NaifId::SUN, "corona");
            assert_eq!(is_on, is_annular && is_bright_enough, "{time} at {stops} stops: {reason}");
            assert!(reason.contains("glare"), "{time} at {stops} stops: {reason}");
        }
    }
    let (mercury, jupiter, pluto) = (NaifId(199), NaifId(599), NaifId(999));
    for (from, is_drawn) in [(mercury, true), (NaifId::EARTH, true), (jupiter, true), (pluto, false)] {
        let view = ViewRequest { position: Position::Centre(from), ..request(NaifId::SUN, parse_time(TOTALITY), 4.0, 100, 6.0, "-glow") };
        let (is_on, reason) = decision(&SESSION.scene(&view).expect("a scene"), NaifId::SUN, "corona");
        assert_eq!(is_on, is_drawn, "{from:?}: {reason}");
    }
}

/// At the limb the glare of the entire Sun is 2000 times as bright as the corona. At 18:00 UTC, 37 minutes after first contact and 41 before totality, the Moon
/// hides 0.38 of the light, and the rest surrounds a point 0.3 radii from the Sun's middle. So the corona changes the glare at the limb behind the Moon by
/// 1/700: more than the 1/1000 that linear light keeps, less than the 1/512 that a display shows.
#[test]
fn linear_light_keeps_a_corona_that_a_display_loses_in_the_glare() {
    let view = request(NaifId::SUN, parse_time("2024-04-08T18:00:00Z"), 3.0, 32, 0.0, "");
    let view = ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..view };
    for (purpose, expected) in [(Purpose::Display, false), (Purpose::LINEAR, true)] {
        let scene = SESSION.scene(&ViewRequest { purpose, ..view.clone() }).expect("a scene");
        let (is_on, reason) = decision(&scene, NaifId::SUN, "corona");
        assert_eq!(is_on, expected, "{purpose}: {reason}");
    }
}

/// From first contact to totality: the decision about the corona states how much brighter the glare is at the limb than the corona. It is the drawn glare, at
/// the limb's farthest point from the glare's middle.
#[test]
fn the_corona_is_compared_with_the_glare_that_is_drawn() {
    let mut darkest = f64::INFINITY;
    for minute in 0..8 {
        let time = parse_time("2024-04-08T17:20:00Z").plus_seconds(600.0 * f64::from(minute));
        let view = request(NaifId::SUN, time, 3.0, 64, 0.0, "-atmosphere,-clouds,+glow");
        let scene = SESSION.scene(&ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..view }).expect("a scene");
        let (_, reason) = decision(&scene, NaifId::SUN, "corona");
        let stated =
            reason.split("the glare there is ").nth(1).and_then(|text| text.split(' ').next()).and_then(|text| text.parse::<f64>().ok());
        let stated = stated.unwrap_or_else(|| panic!("{reason}"));
        let glare = scene.glare.expect("glare");
        let sun = scene.body(NaifId::SUN).expect("the Sun").placement;
        let towards = sun.centre_km.normalize();
        let camera = &scene.camera;
        let towards = DVec3::new(towards.dot(camera.right), towards.dot(camera.up), towards.dot(camera.forward));
        let farthest = (glare.sun_direction.as_dvec3() - towards).length() + sun.radii_km.x / sun.centre_km.length();
        let expected = f64::from(glare.strength.y) / (farthest * farthest) / corona::radiance(1.0);
        // The reason has two digits.
        assert!((stated / expected - 1.0).abs() < 0.06, "{minute}: {stated}, drawn {expected}");
        darkest = darkest.min(stated);
    }
    assert!(darkest < 500.0, "{darkest}");
}

/// In totality the Moon's disc, lit by the Earth, is dark in front of the corona; from space, the Earth's disc hides the corona.
#[test]
fn the_moon_is_dark_in_front_of_the_corona() {
    let view = ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..request(NaifId::SUN, parse_time(TOTALITY), 1.2, 96, 12.0, "") };
    let with = drawn(&view);
    let all = around_sun(&with);
    // Here the Moon is 6 % larger than the Sun and 0.03 solar radii off centre.
    let on_moon: Vec<f64> = all.iter().filter(|p| p.radius < 0.95).map(|p| p.luminance).collect();
    let beside_moon: f64 = all.iter().filter(|p| (1.1..1.2).contains(&p.radius)).map(|p| p.luminance).fold(f64::MAX, smaller);
    let brightest = on_moon.iter().copied().fold(0.0, larger);
    assert!(beside_moon > 1e-2 && brightest < 0.02 * beside_moon, "the Moon is {brightest:e} in front of {beside_moon:e}");
    // The full Earth above the Moon gives 10 to 16 lux (a magnitude of -16.5 to -17.0), on an albedo of 0.05 to 0.2.
    let without = drawn(&ViewRequest { effects: EffectOverrides::parse("-planet-shine").expect("effects"), ..view });
    let dark = around_sun(&without).iter().filter(|p| p.radius < 0.8).map(|p| p.luminance).sum::<f64>();
    let light = all.iter().filter(|p| p.radius < 0.8).map(|p| p.luminance).sum::<f64>();
    let count = all.iter().filter(|p| p.radius < 0.8).count() as f64;
    let earthshine = (light - dark) / count * UNIT_CD_M2;
    assert!((0.1..1.5).contains(&earthshine), "{earthshine} cd/m2");
    // From behind the Earth's disc, on the side opposite the Sun, the corona is visible only as a ring outside the disc.
    let behind = Position::Offset { body: NaifId::EARTH, offset_km: behind_the_earth(), axes: Axes::Icrf };
    let space = drawn(&ViewRequest { position: behind, ..request(NaifId::SUN, parse_time(TOTALITY), 4.0, 96, 5.0, "-points,-atmosphere") });
    let (is_on, reason) = decision(&space.scene, NaifId::SUN, "corona");
    let seen = around_sun(&space);
    let hidden = seen.iter().filter(|p| p.radius < 1.1).map(|p| p.luminance).fold(0.0, larger);
    let ring = seen.iter().filter(|p| (2.0..2.2).contains(&p.radius)).map(|p| p.luminance).fold(f64::MAX, smaller);
    assert!(is_on && hidden < 1e-5 && ring > 3e-4, "{reason}: {hidden:e} behind the Earth, {ring:e} beside it");
}

/// An offset from the Earth's centre, away from the Sun, at which the Earth's disc is a third larger than the Sun's.
fn behind_the_earth() -> DVec3 {
    let scene = SESSION
        .scene(&ViewRequest { position: Position::Centre(NaifId::EARTH), ..request(NaifId::SUN, parse_time(TOTALITY), 4.0, 32, 0.0, "") })
        .expect("a scene");
    scene.body(NaifId::SUN).expect("the Sun").placement.centre_km.normalize() * -1.05e6
}

/// Venus and Jupiter near the eclipsed Sun are visible as points against the dark sky; against the day sky their contrast is less than 2 % of that.
#[test]
fn planets_are_visible_next_to_the_eclipsed_sun() {
    let (venus, jupiter) = (NaifId(299), NaifId(599));
    for planet in [venus, jupiter] {
        let draw_at = |time: &str, effects: &str| {
            let view =
                ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..request(planet, parse_time(time), 4.0, 48, 8.0, effects) };
            drawn(&view)
        };
        let contrast = |time: &str| {
            let (with, without) = (draw_at(time, "-corona"), draw_at(time, "-corona,-points"));
            assert_eq!(with.scene.body(planet).expect("the planet").appearance, Appearance::Point);
            let contrasts =
                with.frame.hdr.iter().zip(&without.frame.hdr).map(|(a, b)| (luminance(a) - luminance(b)) / luminance(b).max(1e-12));
            contrasts.fold(0.0, larger)
        };
        let (dark, day) = (contrast(TOTALITY), contrast("2024-04-08T17:00:00Z"));
        assert!(dark > 1.0 && day < 0.02 * dark && day > 0.0, "{planet:?}: {dark} in totality, {day} by day");
    }
}

/// Venus sets. At each altitude down to 10 degrees, the air dims it as one vertical optical depth times the air mass does; from 10 to 5 degrees, by more than
/// half.
#[test]
fn a_planet_near_the_horizon_is_dimmed_by_the_air() {
    let flux = |time: Instant, effects: &str| {
        let view = ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..request(NaifId(299), time, 4.0, 32, 8.0, effects) };
        let scene = SESSION.scene(&view).expect("a scene");
        let up = -scene.body(NaifId::EARTH).expect("ground").placement.centre_km.normalize();
        let sine = up.dot(scene.body(NaifId(299)).expect("Venus").placement.centre_km.normalize());
        (sine, scene.points.iter().find(|p| p.body == NaifId(299)).map_or(Vec3::ZERO, |p| p.flux))
    };
    let mut extinctions = Vec::new();
    for minutes in 0..14 {
        let time = parse_time("2024-04-08T18:42:38Z").plus_seconds(f64::from(minutes) * 1500.0);
        let (sine, with_air) = flux(time, "-eclipse");
        if sine < 5.0_f64.to_radians().sin() {
            continue;
        }
        let without_air = flux_without_air(time);
        // The air mass is 1 / sine within a few percent down to 10 degrees.
        let extinction = -(f64::from(with_air.y) / without_air).ln() * sine;
        if sine > 0.17 {
            extinctions.push(extinction);
        } else {
            assert!(f64::from(with_air.y) < 0.5 * without_air, "low: {} of {without_air}", with_air.y);
        }
    }
    assert!(extinctions.len() > 5, "{extinctions:?}");
    let (min, max) = extinctions.iter().fold((f64::MAX, 0.0_f64), |(a, b), k| (smaller(a, *k), larger(b, *k)));
    // Green: gas 0.09; with aerosol and ozone 0.1 to 0.25 in total.
    assert!(min > 0.1 && max < 0.25 && max / min < 1.1, "{extinctions:?}");
}

/// The point's flux at the camera without air, from the magnitude.
fn flux_without_air(time: Instant) -> f64 {
    let view = ViewRequest { position: Position::Centre(NaifId::EARTH), ..request(NaifId(299), time, 4.0, 32, 8.0, "") };
    let scene = SESSION.scene(&view).expect("a scene");
    let point = scene.points.iter().find(|p| p.body == NaifId(299)).expect("a point");
    f64::from(point.flux.y)
}

/// f32 and f64 give the same image of corona, sky and ground, within half an 8-bit level for 98 % of the pixels.
#[test]
fn single_precision_is_enough_for_totality() {
    let double = Session::open(&Sources { uses_f64: true, ..Sources::default() }, |_| {}).expect("opens");
    for (fov_deg, stops, target) in [(3.0, 5.0, NaifId::SUN), (90.0, 11.0, NaifId::SUN), (100.0, 11.0, NaifId::EARTH)] {
        let view = ViewRequest {
            position: on_ground(NaifId::EARTH, DALLAS),
            ..request(target, parse_time(TOTALITY), fov_deg, 40, stops, "-albedo,-normal,-clouds")
        };
        let (single, exact) = (drawn(&view), double.draw(&view, SAMPLING, FrameImages::DisplayAndHdr).expect("draws"));
        let level = |v: f32| {
            let x = (f64::from(v) * stops.exp2()).clamp(0.0, 1.0);
            255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
        };
        let mut differences: Vec<f64> = single
            .frame
            .hdr
            .iter()
            .zip(&exact.frame.hdr)
            .map(|(a, b)| (0..3).map(|c| (level(a[c]) - level(b[c])).abs()).fold(0.0, larger))
            .collect();
        differences.sort_by(f64::total_cmp);
        // The other 2 % are pixels of the limb and the horizon.
        let percentile_98 = differences[differences.len() * 98 / 100];
        assert!(percentile_98 < 0.5, "{fov_deg} degrees: {percentile_98} levels");
        assert!(single.frame.hdr.iter().any(|p| p[1] > 0.0));
        assert!(single.frame.hdr != exact.frame.hdr, "{fov_deg} degrees: both images have the same bits, so both were computed in f32");
    }
}
