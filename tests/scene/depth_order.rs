//! What hides what, at any distance: from near a body to 100 au, its ground, clouds, air and rings keep their order, whatever the
//! resolution of depth; and a moon in front of a ring or of clouds hides them, one behind is hidden.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;
use orrery::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use std::sync::LazyLock;

const SATURN: NaifId = NaifId(699);

static RENDERERS: LazyLock<[SoftwareRenderer; 2]> = LazyLock::new(|| {
    [Precision::F32, Precision::F64]
        .map(|precision| SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer"))
});

/// A body seen from a distance of `distance_km` in the direction `offset` (ICRF). Its disc is `disc_px` across, in an image 1.5 times that
/// size. `emitted`: when the light left the body.
fn view(body: NaifId, emitted: Instant, offset: DVec3, distance_km: f64, disc_px: f64, effects: &str) -> ViewRequest {
    let radius_km = SESSION.catalog().body(body).expect("a body").radii_km.x;
    let size = (1.5 * disc_px).round() as u32;
    let tangent = (radius_km / distance_km).asin().tan() * f64::from(size) / disc_px;
    ViewRequest {
        position: Position::Offset { body, offset_km: offset.normalize() * distance_km, axes: Axes::Icrf },
        width: size,
        height: size,
        fov_deg: Some(2.0 * tangent.atan().to_degrees()),
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(body, emitted.plus_seconds(distance_km / SPEED_OF_LIGHT_KM_S))
    }
}

fn drawn(request: &ViewRequest, samples: u8, precision: Precision) -> (Scene, Vec<[f32; 4]>) {
    let (scene, plan) = SESSION.plan(request, SamplingQuality { samples, anisotropy: 1 }).expect("a plan");
    let renderer = &RENDERERS[usize::from(precision == Precision::F64)];
    let hdr = renderer.render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
    (scene, hdr)
}

/// Greatest difference of two images relative to the brightest pixel of the first, without pixels near other bodies.
fn relative_difference(body: NaifId, (scene, a): &(Scene, Vec<[f32; 4]>), (other, b): &(Scene, Vec<[f32; 4]>)) -> f32 {
    let brightest = a.iter().flat_map(|p| p[..3].iter().copied()).fold(0.0, larger);
    assert!(brightest.is_finite(), "{body:?}");
    let is_near_other_body = |scene: &Scene, at: DVec2| {
        let near = |c: &orrery::scene::BodyReport| {
            let middle = scene.camera.clip(c.placement.centre_km).map(|clip| scene.camera.pixel_from_clip(clip));
            c.id != body && middle.is_some_and(|m| m.distance(at) < 3.0 + c.diameter_px)
        };
        scene.bodies.iter().any(near)
    };
    let width = scene.camera.width as usize;
    let mut worst = 0.0_f32;
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        let at = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        let change = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, larger);
        if (change.is_nan() || change > worst * brightest) && !is_near_other_body(scene, at) && !is_near_other_body(other, at) {
            worst = change / brightest;
        }
    }
    worst
}

/// From 3000 radii to 100 au, three steps per decade. Only the perspective may change. If the camera is d radii away, a point of a ring at
/// r radii moves by about r²/d radii, or 20 r²/d pixels, and neighbouring pixels may differ by up to white. So 500/d is allowed in addition
/// to 2e-3; it is less than that beyond 250 000 radii.
#[test]
fn layers_of_a_body_look_the_same_from_any_distance() {
    let earth = (NaifId::EARTH, "2024-06-08T06:00:00Z", "+clouds,+atmosphere,-planet-shine,-eclipse");
    let saturn = (SATURN, "2017-05-17T00:00:00Z", "+rings,+atmosphere,-planet-shine,-eclipse");
    for (body, emitted, effects) in [earth, saturn] {
        for (samples, precision) in [(1, Precision::F32), (4, Precision::F32), (1, Precision::F64)] {
            let emitted = Instant::parse(emitted).expect("a time");
            let radius_km = SESSION.catalog().body(body).expect("a body").radii_km.x;
            // From the Sun's direction, above the rings.
            let sun = SESSION.ephemeris().state(NaifId::SUN, body, emitted, None).expect("the Sun").state.pos_km.normalize();
            let towards = sun + DVec3::new(0.1, -0.2, 0.3);
            let mut previous = None;
            let mut distance_km = 3000.0 * radius_km;
            while distance_km < 100.0 * KM_PER_AU {
                let image = drawn(&view(body, emitted, towards, distance_km, 40.0, effects), samples, precision);
                assert!(image.0.draws.iter().filter(|d| d.body == body).count() > 1, "layers");
                if let Some((previous_km, previous_image)) = &previous {
                    let perspective_change = (500.0 * radius_km / previous_km) as f32;
                    let change = relative_difference(body, previous_image, &image);
                    let radii = distance_km / radius_km;
                    assert!(change < 2e-3 + perspective_change, "{body:?}, {samples} samples, {precision:?}: {change} at {radii:.0} radii");
                }
                previous = Some((distance_km, image));
                distance_km *= 2.154;
            }
        }
    }
}

/// The ring changes no pixel of a moon in front of it, and every lit pixel of a moon behind it, from nearby and from 90 au.
#[test]
fn a_moon_is_drawn_in_front_of_or_behind_the_ring() {
    let emitted = Instant::parse("2017-05-17T00:00:00Z").expect("a time");
    let to_icrf = SESSION.ephemeris().body_from_icrf(SATURN, emitted).expect("an orientation").transpose();
    let radius_km = SESSION.catalog().body(SATURN).expect("Saturn").radii_km.x;
    let mut compared = 0;
    for name in ["Tethys", "Dione", "Rhea"] {
        let moon = SESSION.catalog().find_body_or_barycenter(name).expect(name);
        let moon_km = SESSION.ephemeris().state(moon, SATURN, emitted, None).expect(name).state.pos_km;
        let moon_radius_km = SESSION.catalog().body(moon).expect(name).radii_km.max_element();
        for azimuth_step in 0..8 {
            // The camera is on the line through a point of the B ring and the moon, either beyond the moon or beyond the ring.
            let (sin, cos) = (f64::from(azimuth_step) * 0.785).sin_cos();
            let on_ring_km = to_icrf * (DVec3::new(cos, sin, 0.0) * (1.75 * radius_km));
            let line = (moon_km - on_ring_km).normalize();
            let sine_to_ring_plane = (to_icrf.transpose() * line).z.abs();
            let line_to_planet_km = (moon_km - line * moon_km.dot(line)).length();
            // Skip lines near the planet or nearly in the ring plane, and moons near that plane.
            if (to_icrf.transpose() * moon_km).z.abs() < 1.5 * moon_radius_km
                || sine_to_ring_plane < 1e-3
                || line_to_planet_km <= 1.1 * radius_km
            {
                continue;
            }
            for distance_km in [2e6, 3e8, 90.0 * KM_PER_AU] {
                for (in_front, towards) in [(true, line), (false, -line)] {
                    let request = |effects: &str| view(moon, emitted, towards, distance_km, 16.0, effects);
                    let effects = "-points,-eclipse,-planet-shine";
                    let (scene, with) = drawn(&request(&format!("+rings,{effects}")), 1, Precision::F32);
                    let (_, without) = drawn(&request(&format!("-rings,{effects}")), 1, Precision::F32);
                    // The image has 24 x 24 pixels, 1.5 times the disc's diameter. If its middle is dark, it shows the moon's night side.
                    if without[12 * 24 + 12][1] == 0.0 {
                        continue;
                    }
                    assert!(scene.draws.iter().any(|d| d.body == SATURN), "{name}: the rings are drawn");
                    let disc = scene.body(moon).expect(name).placement;
                    for (k, (a, b)) in with.iter().zip(&without).enumerate() {
                        let at = DVec2::new((k % 24) as f64 + 0.5, (k / 24) as f64 + 0.5);
                        let neighbours = [DVec2::ZERO, DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y];
                        if !neighbours.iter().all(|d| scene.camera.surface_under_pixel(&disc, at + *d).is_some()) {
                            continue;
                        }
                        if in_front {
                            assert_eq!(a, b, "{name} in front of the ring, {distance_km:e} km, pixel {at}");
                        } else if b[1] > 1e-4 {
                            assert_ne!(a, b, "{name} behind the ring, {distance_km:e} km, pixel {at}");
                        }
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 3000, "{compared} pixels");
}

/// In front of the Earth, the Moon hides the clouds and is drawn after the Earth; behind the Earth it is drawn before.
#[test]
fn a_moon_hides_the_clouds_or_is_hidden_by_them() {
    let emitted = Instant::parse("2024-06-08T06:00:00Z").expect("a time");
    let moon_km = SESSION.ephemeris().state(NaifId::MOON, NaifId::EARTH, emitted, None).expect("the Moon").state.pos_km;
    for distance_km in [2e6, 1e9, 90.0 * KM_PER_AU] {
        for in_front in [true, false] {
            let towards = if in_front { moon_km } else { -moon_km };
            let image = |effects: &str| {
                let request =
                    view(NaifId::EARTH, emitted, towards, distance_km, 40.0, &format!("{effects},-points,-planet-shine,-eclipse"));
                drawn(&ViewRequest { exposure: ExposureRequest::Stops(4.0), ..request }, 1, Precision::F32)
            };
            let (scene, with) = image("+clouds");
            let (_, without) = image("-clouds,-cloud-shadow");
            let moon = scene.body(NaifId::MOON).expect("the Moon");
            let middle = scene.camera.pixel_from_clip(scene.camera.clip(moon.placement.centre_km).expect("in front"));
            // The image is 60 pixels wide.
            let k = middle.y as usize * 60 + middle.x as usize;
            let order: Vec<_> = scene.draws.iter().map(|d| d.body).collect();
            let draw_index = |id: NaifId| order.iter().position(|b| *b == id).expect("drawn");
            assert_eq!(draw_index(NaifId::MOON) > draw_index(NaifId::EARTH), in_front, "{distance_km:e} km");
            if in_front {
                assert_eq!(with[k], without[k], "{distance_km:e} km: the cloud deck is visible through the Moon");
                assert!(with != without, "{distance_km:e} km: no clouds are visible beside the Moon");
            }
        }
    }
}
