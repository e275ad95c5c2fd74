//! Totality in small images: the corona of a Sun of a pixel keeps its light, as a point, and neither it nor the exposure jumps with size or time.

use super::totality::{DALLAS, TOTALITY, drawn, on_ground, parse_time, request};
use crate::support::session::SESSION;
use glam::DVec2;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::purpose::Purpose;
use orrery::scene::request::{Composition, ExposureRequest, Layers, Projection, ViewRequest};
use orrery::units::luminance;
use std::f64::consts::PI;

/// The Sun in totality without air and earthshine, as linear light.
fn without_air(fov_deg: f64, size: u32, effects: &str) -> ViewRequest {
    ViewRequest {
        position: on_ground(NaifId::EARTH, DALLAS),
        purpose: Purpose::LINEAR,
        layers: Layers::NONE,
        ..request(NaifId::SUN, parse_time(TOTALITY), fov_deg, size, 0.0, &format!("-atmosphere,-planet-shine,-clouds{effects}"))
    }
}

/// The same at Dallas with air, in a wide view.
fn wide(time: orrery::time::Instant, size: u32, stops: f64) -> ViewRequest {
    ViewRequest { position: on_ground(NaifId::EARTH, DALLAS), ..request(NaifId::SUN, time, 100.0, size, stops, "") }
}

/// Luminance times solid angle, summed over the image.
fn light(view: &ViewRequest) -> f64 {
    let image = drawn(view);
    let camera = &image.scene.camera;
    let middle_pixel_sr = camera.pixel_tangent().powi(2);
    let of_pixel = |(k, p): (usize, &[f32; 4])| {
        let centre = DVec2::new((k % camera.width as usize) as f64 + 0.5, (k / camera.width as usize) as f64 + 0.5);
        let cos = camera.ray(camera.clip_from_pixel(centre)).length().recip();
        luminance([p[0], p[1], p[2]].map(f64::from)) * middle_pixel_sr * cos.powi(3)
    };
    image.frame.hdr.iter().enumerate().map(of_pixel).sum()
}

fn corona_is_on(scene: &Scene) -> bool {
    let sun = scene.body(NaifId::SUN).expect("the Sun");
    sun.decisions.iter().find(|d| d.effect == "corona").is_some_and(|d| d.on)
}

/// Light of the Sun's point, green.
fn point_light(scene: &Scene) -> f64 {
    scene.points.iter().filter(|p| p.body == NaifId::SUN).map(|p| f64::from(p.flux.y)).sum()
}

/// The Sun from 0.6 to 11 pixels across: the light is that of an image in which it has 21 pixels. A simulation of the law (outside this program) gives 0.91 to
/// 1.07 of it.
#[test]
fn the_corona_keeps_its_light_at_every_size() {
    let expected = light(&without_air(10.0, 400, ""));
    for size in [12, 16, 20, 26, 32, 38, 44, 52, 60, 68, 76, 96, 120, 200] {
        let ratio = light(&without_air(10.0, size, "")) / expected;
        println!("{size} pixels: {ratio:.3}");
        assert!((ratio - 1.0).abs() < 0.15, "{size} pixels: {ratio} of the light");
    }
    // Negative control: the light is the corona's.
    let ratio = light(&without_air(10.0, 16, ",-corona")) / expected;
    assert!(ratio < 0.02, "{ratio} of the light without a corona");
}

/// An image of the entire sphere, in which the Sun is 0.3 pixels across, has the same light.
#[test]
fn an_image_of_the_sphere_shows_the_corona() {
    let size = [200_u32, 100];
    let light_of_sphere = |effects: &str| {
        let composition = Composition { projection: Projection::Equirectangular, ..Composition::default() };
        let view = ViewRequest { width: size[0], height: size[1], composition, ..without_air(10.0, 100, effects) };
        let of_pixel = |(k, p): (usize, &[f32; 4])| {
            let from_pole_rad = PI * ((k / size[0] as usize) as f64 + 0.5) / f64::from(size[1]);
            luminance([p[0], p[1], p[2]].map(f64::from)) * from_pole_rad.sin() * (PI / f64::from(size[1])).powi(2)
        };
        drawn(&view).frame.hdr.iter().enumerate().map(of_pixel).sum::<f64>()
    };
    let corona = light_of_sphere("") - light_of_sphere(",-corona");
    // The frame of this image ends 5 degrees from the Sun. The corona beyond has 4 % of the light.
    let expected = light(&without_air(10.0, 400, ""));
    assert!((0.8..1.3).contains(&(corona / expected)), "{} of the light", corona / expected);
}

/// In a view 100 degrees wide the Sun grows from 0.9 to 1.6 pixels: it has its corona at every size, and the exposure hardly changes.
#[test]
fn the_exposure_of_totality_does_not_depend_on_the_size() {
    let mut last_stops = None;
    for size in (240..=400).step_by(16) {
        let scene =
            SESSION.scene(&ViewRequest { exposure: ExposureRequest::Auto, ..wide(parse_time(TOTALITY), size, 0.0) }).expect("a scene");
        assert!(corona_is_on(&scene) && point_light(&scene) > 0.0, "{size} pixels: no corona");
        let change = (scene.exposure.stops - last_stops.unwrap_or(scene.exposure.stops)).abs();
        assert!(change < 0.05, "{size} pixels: the exposure changes by {change} stops");
        last_stops = Some(scene.exposure.stops);
    }
    // Negative control: without an eclipse the disc outshines the corona of a Sun of a pixel, whether or not there is glare.
    for effects in ["", "-glow"] {
        let effects = EffectOverrides::parse(effects).expect("effects");
        let scene = SESSION.scene(&ViewRequest { effects, ..wide(parse_time("2024-06-08T18:42:38Z"), 240, 0.0) }).expect("a scene");
        assert!(!corona_is_on(&scene));
    }
}

/// The corona of a Sun of 0.9 pixels appears before the last of the disc disappears, when it has less than a fiftieth of the light; in totality it has all.
#[test]
fn the_corona_of_a_small_sun_appears_gradually() {
    let at = |seconds: f64| {
        let time = parse_time("2024-04-08T18:40:00Z").plus_seconds(seconds);
        SESSION.scene(&wide(time, 240, 8.0)).expect("a scene")
    };
    let (mut off, mut on) = (0.0, 120.0);
    assert!(!corona_is_on(&at(off)) && corona_is_on(&at(on)));
    for _ in 0..20 {
        let middle = 0.5 * (off + on);
        if corona_is_on(&at(middle)) { on = middle } else { off = middle }
    }
    let share = |scene: &Scene| f64::from(scene.corona.expect("a corona").point_flux.y) / point_light(scene);
    let (first, total) = (share(&at(on)), share(&at(120.0)));
    assert!(first > 0.0 && first < 0.02, "{first} of the light {on} s after 18:40:00");
    assert!((total - 1.0).abs() < 1e-6, "{total} of the light in totality");
}
