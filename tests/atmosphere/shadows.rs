//! Air in the shadow of rings and of other bodies: shadowed air is dark, and sunlit air is the same as without the shadow. Also the limb in
//! thick haze.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::{NaifId, Ring};
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{AtmosphereModel, BodyPart, Draw, DrawFeatures, Eclipse, Light, MAX_AIR_LIGHTS, RingShadow, RingTable};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;
use std::sync::Arc;

const SATURN: NaifId = NaifId(699);
const SIDE: u32 = 640;
const SATURN_RADIUS_KM: f64 = 60_268.0;

fn request(target: NaifId, time: &str, position: Position, effects: &str) -> ViewRequest {
    ViewRequest {
        position,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(target, Instant::parse(time).expect("a time"))
    }
}

fn pixels(scene: &Scene) -> Vec<[f32; 4]> {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr
}

/// The rim of Saturn's air seen from the equatorial plane, at right angles to the Sun. An opaque ring from below the ground out to 50 radii
/// leaves the air dark on the side of its plane away from the Sun, and changes no bit on the other side; a ring of zero optical depth
/// blocks nothing.
#[test]
fn rings_darken_only_the_air_behind_their_plane() {
    let time = "2017-05-17T00:00:00Z";
    let scene_for_sun =
        SESSION.scene(&request(SATURN, time, Position::AboveTarget { towards: None, distance_radii: Some(3.0) }, "")).expect("a scene");
    let sun =
        scene_for_sun.draws.iter().find(|d| d.part == BodyPart::Globe).expect("a globe").uniforms.lights[0].direction_in_body.as_dvec3();
    let offset_km = DVec3::new(-sun.y, sun.x, 0.0).normalize() * 2.0 * SATURN_RADIUS_KM;
    let position = Position::Offset { body: SATURN, offset_km, axes: Axes::BodyFixed };
    for (model_name, model) in [("pixel-8", AtmosphereModel::Pixel8), ("pixel-16", AtmosphereModel::Pixel16)] {
        let effects = format!("+atmosphere,+atmosphere={model_name},+ring-shadow,-rings,-ring-shine,-eclipse,-planet-shine");
        let rim_request = ViewRequest { width: SIDE, height: SIDE, fov_deg: Some(70.0), ..request(SATURN, time, position, &effects) };
        let mut scene = SESSION.scene(&rim_request).expect("a scene");
        scene.draws.retain(|d| d.body == SATURN && d.part == BodyPart::Sky);
        assert_eq!(scene.draws.len(), 1);
        assert_eq!(scene.draws[0].features.air.model, model);
        // 0: the shadow is evaluated at points along the ray; 1: once per ray, as for a rim thinner than a pixel.
        for rim_is_thin in [0.0, 1.0] {
            let pixels_under_rings = |tau_normal: Option<f64>| {
                let mut scene = scene.clone();
                let draw = &mut scene.draws[0];
                draw.uniforms.air.rim_is_thin = rim_is_thin;
                draw.features.ring_shadow = if tau_normal.is_some() { RingShadow::PointSun } else { RingShadow::None };
                let ring =
                    |tau_normal| Ring { name: "x".into(), inner_km: 0.9, outer_km: 50.0, tau_normal, albedo: [0.5; 3], dust_fraction: 0.0 };
                draw.uniforms.ring.table =
                    tau_normal.and_then(|t| RingTable::of_shadow([ring(t)].iter(), 1.0, &[1.0 / sun.z.abs()])).map(Arc::new);
                draw.uniforms.ring.radius_range = glam::Vec2::new(0.9, 50.0);
                pixels(&scene)
            };
            let (bare, clear, opaque) = (pixels_under_rings(None), pixels_under_rings(Some(0.0)), pixels_under_rings(Some(50.0)));
            let brightest = bare.iter().map(|p| p[1]).fold(0.0, larger);
            let placement = scene.body(SATURN).expect("Saturn").placement;
            let (mut dark, mut lit) = (0, 0);
            for k in 0..bare.len() {
                let (unshaded, behind_clear, behind_opaque) = (bare[k], clear[k], opaque[k]);
                assert!(
                    (0..4).all(|c| (unshaded[c] - behind_clear[c]).abs() <= 1e-6 * brightest.max(unshaded[c])),
                    "{model_name} {k}: {unshaded:?} {behind_clear:?}"
                );
                if unshaded[1] < 1e-3 * brightest {
                    continue;
                }
                // The ray's point nearest to the centre: its distance from the ring plane, in equatorial radii.
                let pixel = DVec2::new(f64::from(k as u32 % SIDE) + 0.5, f64::from(k as u32 / SIDE) + 0.5);
                let along = (placement.body_from_icrf * scene.camera.ray(scene.camera.clip_from_pixel(pixel))).normalize();
                let camera = -(placement.body_from_icrf * placement.centre_km);
                let z = (camera - along * camera.dot(along)).z / SATURN_RADIUS_KM;
                if z * sun.z.signum() < -0.2 {
                    assert!(
                        behind_opaque[1] < 1e-4 * unshaded[1],
                        "{model_name}: behind the plane at {z}: {behind_opaque:?} of {unshaded:?}"
                    );
                    dark += 1;
                } else if z * sun.z.signum() > 0.2 {
                    assert_eq!(behind_opaque.map(f32::to_bits), unshaded.map(f32::to_bits), "{model_name}: on the Sun's side at {z}");
                    lit += 1;
                }
            }
            assert!(dark > 100 && lit > 100, "{model_name}: {dark} dark and {lit} lit pixels");
        }
    }
}

/// The rim of Saturn's air, less than a pixel high, in the rings' shadow: the shadow evaluated once per ray against the penumbra evaluated
/// at points along the ray. The difference is in levels of 255 of an image whose brightest pixel is white.
#[test]
fn one_evaluation_per_ray_suffices_for_the_ring_shadow_on_a_thin_rim() {
    let (mut worst, mut worst_unshaded) = (0.0_f64, 0.0_f64);
    for time in ["2017-05-17T00:00:00Z", "2021-08-01T00:00:00Z", "2024-06-08T12:00:00Z"] {
        for (model_name, radii) in [("pixel-8", 3.3), ("pixel-16", 2.6)] {
            let effects = format!("+atmosphere,+atmosphere={model_name},+ring-shadow,-eclipse,-planet-shine");
            let position = Position::AboveTarget { towards: None, distance_radii: Some(radii) };
            let view_request = ViewRequest { width: SIDE, height: SIDE, fov_deg: Some(45.0), ..request(SATURN, time, position, &effects) };
            let once = SESSION.scene(&view_request).expect("a scene");
            let sky = once.draws.iter().find(|d| d.part == BodyPart::Sky).expect("a rim");
            assert!(sky.uniforms.air.rim_is_thin > 0.5 && sky.features.ring_shadow == RingShadow::PointSun, "{time} {model_name}");
            let pixels_with_changed_sky = |change: &dyn Fn(&mut Draw)| {
                let mut scene = once.clone();
                scene.draws.iter_mut().filter(|d| d.part == BodyPart::Sky).for_each(change);
                pixels(&scene)
            };
            let along_ray = pixels_with_changed_sky(&|d| {
                d.features.ring_shadow = RingShadow::Penumbra;
                d.uniforms.air.rim_is_thin = 0.0;
            });
            let unshaded = pixels_with_changed_sky(&|d| d.features.ring_shadow = RingShadow::None);
            let white = along_ray.iter().map(|p| p[1]).fold(0.0, larger);
            let level = |v: f32| 255.0 * orrery::units::linear_to_srgb(f64::from(v / white).clamp(0.0, 1.0));
            let greatest_difference = |a: &[[f32; 4]]| {
                let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (level(a[c]) - level(b[c])).abs()).fold(0.0, larger);
                a.iter().zip(&along_ray).map(difference).fold(0.0, larger)
            };
            let (error, error_unshaded) = (greatest_difference(&pixels(&once)), greatest_difference(&unshaded));
            println!("{time} {model_name}: {error:.2} of 255, {error_unshaded:.1} without the shadow");
            (worst, worst_unshaded) = (larger(worst, error), larger(worst_unshaded, error_unshaded));
        }
    }
    assert!(worst < 9.0 && worst_unshaded > 4.0 * worst, "{worst} of 255, {worst_unshaded} without a shadow");
}

/// The rim of Saturn's air, less than a pixel high, under its rings and in an eclipse by Mimas: it is lit beyond the shadow of Mimas, and black if Mimas were as
/// large as to hide the Sun from all of the air.
#[test]
fn a_thin_rim_under_rings_is_in_the_shadow_of_a_moon_too() {
    let effects = "+atmosphere,+atmosphere=pixel-16,+ring-shadow,-planet-shine";
    let position = Position::AboveTarget { towards: None, distance_radii: Some(3.3) };
    let base = request(SATURN, "2024-10-01T00:00:00Z", position, effects);
    let mut scene = SESSION.scene(&ViewRequest { width: SIDE, height: SIDE, fov_deg: Some(45.0), ..base }).expect("a scene");
    scene.draws.retain(|d| d.body == SATURN && d.part == BodyPart::Sky);
    let sky = scene.draws.first().expect("a rim");
    assert!(sky.uniforms.air.rim_is_thin > 0.5, "{:?}", sky.features);
    assert!(sky.features.eclipse.occluders > 0 && sky.features.ring_shadow == RingShadow::Penumbra, "{:?}", sky.features);
    let brightest = |scene: &Scene| pixels(scene).iter().map(|p| p[1]).fold(0.0, larger);
    let lit = brightest(&scene);
    for outline in &mut scene.draws[0].uniforms.eclipse.occluder_outlines {
        // The semi-axes of the outline, in radii of Saturn.
        (outline.z, outline.w) = (4.0, 4.0);
    }
    let dark = brightest(&scene);
    println!("brightest pixel {lit:e}, {dark:e} without the Sun");
    assert!(lit > 0.0 && dark < 1e-3 * lit, "{lit} {dark}");
}

/// The Earth in the Moon's shadow, with eight samples per ray. With the Moon moved out of reach, the image equals the one without an
/// eclipse. At the point of greatest eclipse, 25.3 N 104.1 W, ground, clouds and air are dark. And the image is close to that with 32
/// samples.
#[test]
fn eight_samples_suffice_for_an_eclipse() {
    const EARTH_SIDE: u32 = 300;
    let scene_of_model = |model_name: &str| {
        let effects = format!("+atmosphere,+atmosphere={model_name},-planet-shine");
        let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
        let view_request =
            ViewRequest { width: EARTH_SIDE, height: EARTH_SIDE, ..request(NaifId::EARTH, "2024-04-08T18:17:16Z", position, &effects) };
        SESSION.scene(&view_request).expect("a scene")
    };
    let eclipsed = scene_of_model("pixel-8");
    let of_model = eclipsed.draws.iter().filter(|d| d.features.air.model == AtmosphereModel::Pixel8 && d.features.eclipse.occluders > 0);
    assert_eq!(of_model.count(), 3, "ground, clouds and sky");
    let (mut moon_out_of_reach, mut uneclipsed) = (eclipsed.clone(), eclipsed.clone());
    moon_out_of_reach.draws.iter_mut().flat_map(|d| &mut d.uniforms.eclipse.occluder_positions).for_each(|p| p.x += 1000.0);
    uneclipsed.draws.iter_mut().for_each(|d| d.features.eclipse = Eclipse::default());
    let [shadow_px, far_px, uneclipsed_px, finer_px] =
        [&eclipsed, &moon_out_of_reach, &uneclipsed, &scene_of_model("pixel-32")].map(pixels);
    let greatest_difference = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, larger);
        a.iter().zip(b).map(difference).fold(0.0, larger)
    };
    let brightest = uneclipsed_px.iter().map(|p| p[1]).fold(0.0, larger);
    assert!(greatest_difference(&far_px, &uneclipsed_px) < 1e-6 * brightest, "{}", greatest_difference(&far_px, &uneclipsed_px));
    let earth = eclipsed.body(NaifId::EARTH).expect("the Earth").placement;
    let (lat, lon) = (25.3f64.to_radians(), (-104.1f64).to_radians());
    let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    let greatest_eclipse = (up * earth.radii_km).normalize();
    let pixel = eclipsed.camera.pixel_of_surface(&earth, greatest_eclipse).expect("it is seen");
    let k = pixel.y as usize * EARTH_SIDE as usize + pixel.x as usize;
    assert!(shadow_px[k][1] < 0.05 * uneclipsed_px[k][1], "{:?} of {:?}", shadow_px[k], uneclipsed_px[k]);
    // The largest differences are at the limb, where eight samples cover a long ray through twilight.
    assert!(greatest_difference(&shadow_px, &finer_px) < 0.06 * brightest, "{} of {brightest}", greatest_difference(&shadow_px, &finer_px));
    assert!(greatest_difference(&shadow_px, &uneclipsed_px) > 0.2 * brightest, "the shadow must be visible");
}

/// Titan's haze hides the edge of the ground: along a row of pixels, the second difference of the radiance at the limb is small. Without
/// air the radiance has a step.
#[test]
fn no_line_appears_at_the_limb_of_a_hazy_moon() {
    const TITAN: NaifId = NaifId(606);
    const LIMB_SIDE: u32 = 301;
    let greatest_second_difference = |towards: NaifId, effects: &str| {
        let position = Position::AboveTarget { towards: Some(towards), distance_radii: Some(3.0) };
        let view_request = ViewRequest {
            width: LIMB_SIDE,
            height: LIMB_SIDE,
            ..request(TITAN, "2017-05-17T00:00:00Z", position, &format!("-points,{effects}"))
        };
        let scene = SESSION.scene(&view_request).expect("a scene");
        let hdr = pixels(&scene);
        let placement = scene.body(TITAN).expect("Titan").placement;
        let row = LIMB_SIDE / 2;
        let on_disc = |x: u32| scene.camera.surface_under_pixel(&placement, DVec2::new(f64::from(x) + 0.5, f64::from(row) + 0.5)).is_some();
        let light = |x: u32| f64::from(hdr[(row * LIMB_SIDE + x) as usize][1]);
        let limbs: Vec<u32> = (1..LIMB_SIDE).filter(|x| on_disc(*x) != on_disc(x - 1)).collect();
        assert_eq!(limbs.len(), 2, "{limbs:?}");
        let at_limb = |limb: u32| {
            let level = light(limb).max(light(limb - 1));
            let second_difference = |x: u32| (light(x + 1) - 2.0 * light(x) + light(x - 1)).abs() / level;
            if level > 1e-6 { (limb - 1..limb + 2).map(second_difference).fold(0.0, larger) } else { 0.0 }
        };
        limbs.into_iter().map(at_limb).fold(0.0, larger)
    };
    // At full phase, and from Saturn's direction, from which the Sun lights Titan from the side.
    for towards in [NaifId::SUN, SATURN] {
        let (hazy, bare) = (greatest_second_difference(towards, ""), greatest_second_difference(towards, "-atmosphere"));
        // The haze itself accounts for 0.05. Too few samples behind the limb, or a map that does not fade, would give 0.14.
        assert!(hazy < 0.08, "{hazy} from {towards:?}");
        assert!(bare > 0.2, "{bare} from {towards:?}");
    }
}

/// Asserts that the draws of two scenes differ only in the eclipse (an eclipsed draw with several lights is padded to three, one of the sky to the two that air
/// scatters, the added ones dark).
fn assert_differ_only_in_the_eclipse(eclipsed: &Scene, plain: &Scene) {
    assert_eq!(eclipsed.draws.len(), plain.draws.len());
    assert!(
        eclipsed.draws.iter().any(|d| d.features.eclipse.occluders > 0 && d.features.air.model != AtmosphereModel::None),
        "air in an eclipse"
    );
    for (a, b) in eclipsed.draws.iter().zip(&plain.draws) {
        let padded = if b.part == BodyPart::Sky { MAX_AIR_LIGHTS } else { 3 };
        let lights = if b.features.lights > 1 { padded } else { 1 };
        assert_eq!(
            DrawFeatures { eclipse: a.features.eclipse, ring_shadow: a.features.ring_shadow, lights, ..b.features },
            a.features,
            "{}",
            a.name
        );
        let (lights_eclipsed, lights_plain) = (&a.uniforms.lights, &b.uniforms.lights);
        assert_eq!(lights_eclipsed[..lights_plain.len()], lights_plain[..], "{}", a.name);
        assert!(
            lights_eclipsed.len() == usize::from(lights)
                && lights_eclipsed[lights_plain.len()..].iter().all(|l| l.irradiance == glam::Vec3::ZERO),
            "{}",
            a.name
        );
    }
}

/// The Earth in an eclipse, seen from over its dusk. The second light of each draw is replaced by one of 5e-4 of sunlight from the
/// direction opposite the Sun. The night is as bright as without the eclipse, which blocks only the Sun's light, and with the occluders
/// moved out of reach nothing is blocked.
#[test]
fn an_eclipse_blocks_only_the_suns_light() {
    let time = "2024-04-08T18:17:16Z";
    let sunward = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
    let day_side = SESSION.scene(&request(NaifId::EARTH, time, sunward, "")).expect("a scene");
    let sun = day_side.draws.iter().find(|d| d.part == BodyPart::Globe).expect("a globe").uniforms.lights[0].direction_in_body;
    let across_sun = DVec3::new(-f64::from(sun.y), f64::from(sun.x), 0.0).normalize();
    let offset_km = (sun.as_dvec3() + 2.0 * across_sun).normalize() * 3.0 * 6378.0;
    let position = Position::Offset { body: NaifId::EARTH, offset_km, axes: Axes::BodyFixed };
    for model_name in ["pixel-8", "table"] {
        let scene_with = |switched: &str| {
            let effects = format!("+atmosphere,+atmosphere={model_name},-night,{switched}");
            let view_request = ViewRequest { width: 160, height: 160, ..request(NaifId::EARTH, time, position, &effects) };
            let mut scene = SESSION.scene(&view_request).expect("a scene");
            for light in scene.draws.iter_mut().flat_map(|d| d.uniforms.lights.iter_mut().skip(1).take(1)) {
                *light = Light { direction_in_body: -sun, irradiance: glam::Vec3::splat(5e-4) };
            }
            scene
        };
        let (eclipsed, plain) = (scene_with("+planet-shine,+eclipse"), scene_with("+planet-shine,-eclipse"));
        assert_differ_only_in_the_eclipse(&eclipsed, &plain);
        let mut far = eclipsed.clone();
        far.draws.iter_mut().flat_map(|d| &mut d.uniforms.eclipse.occluder_positions).for_each(|p| p.x += 1000.0);
        let (shown, far, plain, unlit) = (pixels(&eclipsed), pixels(&far), pixels(&plain), pixels(&scene_with("-planet-shine,+eclipse")));
        let placement = eclipsed.body(NaifId::EARTH).expect("the Earth").placement;
        let (mut night_pixels, mut shadow_pixels) = (0, 0);
        for k in 0..shown.len() {
            assert!(
                (0..4).all(|c| (far[k][c] - plain[k][c]).abs() <= 1e-6 * plain[k][c].max(1e-3)),
                "{model_name} {k}: {:?} {:?}",
                far[k],
                plain[k]
            );
            let middle = DVec2::new(f64::from(k as u32 % 160) + 0.5, f64::from(k as u32 / 160) + 0.5);
            let Some(hit) = eclipsed.camera.surface_under_pixel(&placement, middle) else { continue };
            let sun_cosine = (hit / placement.radii_km).normalize().dot(sun.as_dvec3());
            if sun_cosine < -0.3 {
                assert!(
                    (0..3).all(|c| (shown[k][c] - plain[k][c]).abs() <= 1e-5 * plain[k][c]),
                    "{model_name} {k}: {:?} {:?}",
                    shown[k],
                    plain[k]
                );
                // The second light, 5e-4 of sunlight, falls obliquely on sea of albedo 0.03 or more.
                let brighter = (0..3).any(|c| shown[k][c] > unlit[k][c] + 1e-8);
                assert!(brighter, "{model_name} {k}: the night is {:?} with and {:?} without", shown[k], unlit[k]);
                night_pixels += 1;
            } else if shown[k][1] < 0.9 * plain[k][1] {
                shadow_pixels += 1;
            }
        }
        assert!(night_pixels > 500 && shadow_pixels > 100, "{model_name}: {night_pixels} by night, {shadow_pixels} in the shadow");
    }
}
