//! Air in the shadow of rings and of other bodies: what stands in the shadow does not shine, what stands in the Sun keeps every bit. And the limb in thick haze.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::catalog::{NaifId, Ring};
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{AtmosphereModel, Draw, DrawFeatures, Eclipse, Light, Part, RingShadow, RingTable};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;
use std::sync::Arc;

const SATURN: NaifId = NaifId(699);
const SIDE: u32 = 640;

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
    SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn").0.hdr
}

/// Saturn's rim from over its equator, abeam of the Sun. A disc of rings from the ground out to 50 radii that stops everything leaves the air beyond
/// its plane dark; one of no depth takes nothing.
#[test]
fn air_beyond_the_rings_is_dark_and_the_suns_side_keeps_every_bit() {
    let time = "2017-05-17T00:00:00Z";
    let sun = SESSION.scene(&request(SATURN, time, Position::Over { towards: None, distance_radii: Some(3.0) }, "")).expect("a scene");
    let sun = sun.draws.iter().find(|d| d.part == Part::Globe).expect("a globe").uniforms.lights[0].direction_in_body.as_dvec3();
    let abeam = DVec3::new(-sun.y, sun.x, 0.0).normalize() * 2.0 * 60_268.0;
    let position = Position::Offset { body: SATURN, offset_km: abeam, axes: Axes::BodyFixed };
    for (way, tier) in [("pixel-8", AtmosphereModel::Pixel8), ("pixel-16", AtmosphereModel::Pixel16)] {
        let effects = format!("+atmosphere,+atmosphere={way},+ring-shadow,-rings,-ring-shine,-eclipse,-planet-shine");
        let asked = ViewRequest { width: SIDE, height: SIDE, fov_deg: Some(70.0), ..request(SATURN, time, position, &effects) };
        let mut scene = SESSION.scene(&asked).expect("a scene");
        scene.draws.retain(|d| d.body == SATURN && d.part == Part::Sky);
        assert_eq!(scene.draws.len(), 1);
        assert_eq!(scene.draws[0].features.air.tier, tier);
        // Shaded at each sample and, as a rim under a pixel is, once a ray.
        for thin in [0.0, 1.0] {
            let under = |tau_normal: Option<f64>| {
                let mut scene = scene.clone();
                let draw = &mut scene.draws[0];
                draw.uniforms.air.thin_rim = thin;
                draw.features.ring_shadow = if tau_normal.is_some() { RingShadow::PointSun } else { RingShadow::None };
                let ring = |tau_normal| Ring { name: "x".into(), inner_km: 0.9, outer_km: 50.0, tau_normal, albedo: [0.5; 3], dust: 0.0 };
                draw.uniforms.ring.table =
                    tau_normal.and_then(|t| RingTable::of_shadow([ring(t)].iter(), 1.0, &[1.0 / sun.z.abs()])).map(Arc::new);
                draw.uniforms.ring.reach = glam::Vec2::new(0.9, 50.0);
                pixels(&scene)
            };
            let (bare, clear, opaque) = (under(None), under(Some(0.0)), under(Some(50.0)));
            let brightest = bare.iter().map(|p| p[1]).fold(0.0, f32::max);
            let placement = scene.body(SATURN).expect("Saturn").placement;
            let (mut dark, mut lit) = (0, 0);
            for k in 0..bare.len() {
                let (shown, through, hidden) = (bare[k], clear[k], opaque[k]);
                assert!(
                    (0..4).all(|c| (shown[c] - through[c]).abs() <= 1e-6 * brightest.max(shown[c])),
                    "{way} {k}: {shown:?} {through:?}"
                );
                if shown[1] < 1e-3 * brightest {
                    continue;
                }
                // Where the ray passes nearest to the centre, over the equatorial radius.
                let pixel = DVec2::new(f64::from(k as u32 % SIDE) + 0.5, f64::from(k as u32 / SIDE) + 0.5);
                let along = (placement.body_from_icrf * scene.camera.ray(scene.camera.clip_from_pixel(pixel))).normalize();
                let camera = -(placement.body_from_icrf * placement.centre_km);
                let z = (camera - along * camera.dot(along)).z / 60_268.0;
                if z * sun.z.signum() < -0.2 {
                    assert!(hidden[1] < 1e-4 * shown[1], "{way}: beyond the plane at {z}: {hidden:?} of {shown:?}");
                    dark += 1;
                } else if z * sun.z.signum() > 0.2 {
                    assert_eq!(hidden.map(f32::to_bits), shown.map(f32::to_bits), "{way}: on the Sun's side at {z}");
                    lit += 1;
                }
            }
            assert!(dark > 100 && lit > 100, "{way}: {dark} dark and {lit} lit pixels");
        }
    }
}

/// The rim of Saturn's air, 0.5 to 1 pixels high, in the rings' shadow taken once a ray against the penumbra at its samples: 255ths of the picture whose brightest pixel is white.
#[test]
fn a_rim_under_a_pixel_is_shaded_once_a_ray() {
    let (mut worst, mut without) = (0.0_f64, 0.0_f64);
    for time in ["2017-05-17T00:00:00Z", "2021-08-01T00:00:00Z", "2024-06-08T12:00:00Z"] {
        for (way, radii) in [("pixel-8", 3.3), ("pixel-16", 2.6)] {
            let effects = format!("+atmosphere,+atmosphere={way},+ring-shadow,-eclipse,-planet-shine");
            let position = Position::Over { towards: None, distance_radii: Some(radii) };
            let asked = ViewRequest { width: SIDE, height: SIDE, fov_deg: Some(45.0), ..request(SATURN, time, position, &effects) };
            let once = SESSION.scene(&asked).expect("a scene");
            let sky = once.draws.iter().find(|d| d.part == Part::Sky).expect("a rim");
            assert!(sky.uniforms.air.thin_rim > 0.5 && sky.features.ring_shadow == RingShadow::PointSun, "{time} {way}");
            let changed = |change: &dyn Fn(&mut Draw)| {
                let mut scene = once.clone();
                scene.draws.iter_mut().filter(|d| d.part == Part::Sky).for_each(change);
                pixels(&scene)
            };
            let by_samples = changed(&|d| {
                d.features.ring_shadow = RingShadow::Penumbra;
                d.uniforms.air.thin_rim = 0.0;
            });
            let unshaded = changed(&|d| d.features.ring_shadow = RingShadow::None);
            let white = by_samples.iter().map(|p| p[1]).fold(0.0, f32::max);
            let level = |v: f32| 255.0 * orrery::units::linear_to_srgb(f64::from(v / white).clamp(0.0, 1.0));
            let apart = |a: &[[f32; 4]]| {
                let of = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (level(a[c]) - level(b[c])).abs()).fold(0.0, f64::max);
                a.iter().zip(&by_samples).map(of).fold(0.0, f64::max)
            };
            let (found, bare) = (apart(&pixels(&once)), apart(&unshaded));
            println!("{time} {way}: {found:.2} of 255, {bare:.1} without the shadow");
            (worst, without) = (worst.max(found), without.max(bare));
        }
    }
    assert!(worst < 9.0 && without > 4.0 * worst, "{worst} of 255, {without} without a shadow");
}

/// The Earth under the Moon's shadow with eight samples: with occluders out of reach it is the Earth without; where the eclipse is deepest, at 25.3 N 104.1 W,
/// ground, cloud and air are dark; and it stays near the picture of 32 samples.
#[test]
fn eight_samples_do_for_an_eclipse() {
    const EARTH_SIDE: u32 = 300;
    let of = |way: &str| {
        let effects = format!("+atmosphere,+atmosphere={way},-planet-shine");
        let position = Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
        let asked =
            ViewRequest { width: EARTH_SIDE, height: EARTH_SIDE, ..request(NaifId::EARTH, "2024-04-08T18:17:16Z", position, &effects) };
        SESSION.scene(&asked).expect("a scene")
    };
    let near = of("pixel-8");
    let of_tier = near.draws.iter().filter(|d| d.features.air.tier == AtmosphereModel::Pixel8 && d.features.eclipse.occluders > 0);
    assert_eq!(of_tier.count(), 3, "ground, clouds and sky");
    let (mut far, mut none) = (near.clone(), near.clone());
    far.draws.iter_mut().flat_map(|d| &mut d.uniforms.eclipse.places).for_each(|p| p.x += 1000.0);
    none.draws.iter_mut().for_each(|d| d.features.eclipse = Eclipse::default());
    let (eclipsed, far, none, finer) = (pixels(&near), pixels(&far), pixels(&none), pixels(&of("pixel-32")));
    let apart = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let of = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        a.iter().zip(b).map(of).fold(0.0, f32::max)
    };
    let brightest = none.iter().map(|p| p[1]).fold(0.0, f32::max);
    assert!(apart(&far, &none) < 1e-6 * brightest, "{}", apart(&far, &none));
    let earth = near.body(NaifId::EARTH).expect("the Earth").placement;
    let (lat, lon) = (25.3f64.to_radians(), (-104.1f64).to_radians());
    let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    let middle = (up * earth.radii_km).normalize();
    let pixel = near.camera.pixel_of_surface(&earth, middle).expect("it is seen");
    let k = pixel.y as usize * EARTH_SIDE as usize + pixel.x as usize;
    assert!(eclipsed[k][1] < 0.05 * none[k][1], "{:?} of {:?}", eclipsed[k], none[k]);
    // At the limb, where a whole ray of twilight is eight samples; tests/atmosphere/single_scattering.rs allows them 21 %.
    assert!(apart(&eclipsed, &finer) < 0.06 * brightest, "{} of {brightest}", apart(&eclipsed, &finer));
    assert!(apart(&eclipsed, &none) > 0.2 * brightest, "the shadow shows");
}

/// Through Titan's haze the ground's edge does not show: along a row across the limb light bends gently. Without air it is a step.
#[test]
fn no_line_stands_at_the_limb_of_a_hazy_moon() {
    const TITAN: NaifId = NaifId(606);
    const LIMB_SIDE: u32 = 301;
    let bend = |towards: NaifId, effects: &str| {
        let position = Position::Over { towards: Some(towards), distance_radii: Some(3.0) };
        let asked = ViewRequest {
            width: LIMB_SIDE,
            height: LIMB_SIDE,
            ..request(TITAN, "2017-05-17T00:00:00Z", position, &format!("-points,{effects}"))
        };
        let scene = SESSION.scene(&asked).expect("a scene");
        let hdr = pixels(&scene);
        let placement = scene.body(TITAN).expect("Titan").placement;
        let row = LIMB_SIDE / 2;
        let on_disc = |x: u32| scene.camera.surface_under_pixel(&placement, DVec2::new(f64::from(x) + 0.5, f64::from(row) + 0.5)).is_some();
        let light = |x: u32| f64::from(hdr[(row * LIMB_SIDE + x) as usize][1]);
        let limbs: Vec<u32> = (1..LIMB_SIDE).filter(|x| on_disc(*x) != on_disc(x - 1)).collect();
        assert_eq!(limbs.len(), 2, "{limbs:?}");
        let at = |limb: u32| {
            let level = light(limb).max(light(limb - 1));
            let second = |x: u32| (light(x + 1) - 2.0 * light(x) + light(x - 1)).abs() / level;
            if level > 1e-6 { (limb - 1..limb + 2).map(second).fold(0.0, f64::max) } else { 0.0 }
        };
        limbs.into_iter().map(at).fold(0.0, f64::max)
    };
    // Full, and from Saturn's side, which the Sun lights from aside.
    for towards in [NaifId::SUN, SATURN] {
        let (hazy, bare) = (bend(towards, ""), bend(towards, "-atmosphere"));
        // The haze itself bends by 0.05 a pixel; too few samples behind the limb, or a map that does not fade, make 0.14 of it.
        assert!(hazy < 0.08, "{hazy} from {towards:?}");
        assert!(bare > 0.2, "{bare} from {towards:?}");
    }
}

/// Two scenes whose draws may differ in the eclipse alone.
fn differ_in_the_eclipse_alone(eclipsed: &Scene, plain: &Scene) {
    assert_eq!(eclipsed.draws.len(), plain.draws.len());
    assert!(
        eclipsed.draws.iter().any(|d| d.features.eclipse.occluders > 0 && d.features.air.tier != AtmosphereModel::None),
        "air in an eclipse"
    );
    for (a, b) in eclipsed.draws.iter().zip(&plain.draws) {
        let shadow = (a.features.eclipse, a.features.ring_shadow);
        let lights = if b.features.lights > 1 { 3 } else { 1 };
        assert_eq!(DrawFeatures { eclipse: shadow.0, ring_shadow: shadow.1, lights, ..b.features }, a.features, "{}", a.name);
        let (ours, theirs) = (&a.uniforms.lights, &b.uniforms.lights);
        assert_eq!(ours[..theirs.len()], theirs[..], "{}", a.name);
        assert!(ours.len() == usize::from(lights) && ours[theirs.len()..].iter().all(|l| l.irradiance == glam::Vec3::ZERO), "{}", a.name);
    }
}

/// Evening and night of the Earth on the day of an eclipse, and a thousandth of sunlight from the Sun's antipode: the night is as bright as without the eclipse, which
/// takes the Sun's light alone; and occluders out of reach take nothing.
#[test]
fn other_lights_stay_in_an_eclipse() {
    let time = "2024-04-08T18:17:16Z";
    let sunward = Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(3.0) };
    let sun = SESSION.scene(&request(NaifId::EARTH, time, sunward, "")).expect("a scene");
    let sun = sun.draws.iter().find(|d| d.part == Part::Globe).expect("a globe").uniforms.lights[0].direction_in_body;
    let abeam = DVec3::new(-f64::from(sun.y), f64::from(sun.x), 0.0).normalize();
    let offset_km = (sun.as_dvec3() + 2.0 * abeam).normalize() * 3.0 * 6378.0;
    let position = Position::Offset { body: NaifId::EARTH, offset_km, axes: Axes::BodyFixed };
    for way in ["pixel-8", "table"] {
        let of = |switched: &str| {
            let effects = format!("+atmosphere,+atmosphere={way},-night,{switched}");
            let asked = ViewRequest { width: 160, height: 160, ..request(NaifId::EARTH, time, position, &effects) };
            let mut scene = SESSION.scene(&asked).expect("a scene");
            for light in scene.draws.iter_mut().flat_map(|d| d.uniforms.lights.iter_mut().skip(1).take(1)) {
                *light = Light { direction_in_body: -sun, irradiance: glam::Vec3::splat(5e-4) };
            }
            scene
        };
        let (eclipsed, plain) = (of("+planet-shine,+eclipse"), of("+planet-shine,-eclipse"));
        differ_in_the_eclipse_alone(&eclipsed, &plain);
        let mut far = eclipsed.clone();
        far.draws.iter_mut().flat_map(|d| &mut d.uniforms.eclipse.places).for_each(|p| p.x += 1000.0);
        let (shown, far, plain, unlit) = (pixels(&eclipsed), pixels(&far), pixels(&plain), pixels(&of("-planet-shine,+eclipse")));
        let placement = eclipsed.body(NaifId::EARTH).expect("the Earth").placement;
        let (mut night, mut day) = (0, 0);
        for k in 0..shown.len() {
            assert!(
                (0..4).all(|c| (far[k][c] - plain[k][c]).abs() <= 1e-6 * plain[k][c].max(1e-3)),
                "{way} {k}: {:?} {:?}",
                far[k],
                plain[k]
            );
            let middle = DVec2::new(f64::from(k as u32 % 160) + 0.5, f64::from(k as u32 / 160) + 0.5);
            let Some(hit) = eclipsed.camera.surface_under_pixel(&placement, middle) else { continue };
            let height = (hit / placement.radii_km).normalize().dot(sun.as_dvec3());
            if height < -0.3 {
                // A thousandth of sunlight on sea of albedo 0.03 or more, aslant.
                assert!(
                    (0..3).all(|c| (shown[k][c] - plain[k][c]).abs() <= 1e-5 * plain[k][c]),
                    "{way} {k}: {:?} {:?}",
                    shown[k],
                    plain[k]
                );
                let brighter = (0..3).any(|c| shown[k][c] > unlit[k][c] + 1e-8);
                assert!(brighter, "{way} {k}: the night is {:?} with and {:?} without", shown[k], unlit[k]);
                night += 1;
            } else if shown[k][1] < 0.9 * plain[k][1] {
                day += 1;
            }
        }
        assert!(night > 500 && day > 100, "{way}: {night} by night, {day} in the shadow");
    }
}
