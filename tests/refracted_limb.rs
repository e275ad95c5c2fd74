//! The refracted Sun in the limb of a body: as much light as the eclipse says that arrives, at every place, size and field of view.

use crate::shared::SESSION;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::probe::Prober;
use orrery::probe::sunlight::Sky;
use orrery::render::plan::{Fineness, plan};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::draw::EclipseModel;
use orrery::scene::eclipse::{Receiver, Wanted};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::scene::viewpoint::ground_point_km;
use orrery::time::Instant;
use orrery::units::KM_PER_AU;
use std::f64::consts::PI;

const FINENESS: Fineness = Fineness { samples: 1, anisotropy: 1 };
const MARS: NaifId = NaifId(499);
const TITAN: NaifId = NaifId(606);

fn instant(text: &str) -> Instant {
    Instant::parse(text).expect(text)
}

fn at(body: NaifId, time: Instant, fov_deg: f64, side: u32, effects: &str) -> ViewRequest {
    ViewRequest {
        fov_deg: Some(fov_deg),
        width: side,
        height: side,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(body, time)
    }
}

fn light(scene: &Scene, renderer: &SoftwareRenderer) -> Vec<[f64; 3]> {
    let plan = plan(scene, &*SESSION, FINENESS).expect("a plan");
    let hdr = renderer.render(&plan, SESSION.library(), true).expect("drawn").0.hdr;
    hdr.iter().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

/// The irradiance that a picture brings to a plane facing each of its pixels, in that of the Sun at 1 au.
fn irradiance(scene: &Scene, light: &[[f64; 3]]) -> [f64; 3] {
    let camera = &scene.camera;
    let mut sum = [0.0; 3];
    for (k, pixel) in light.iter().enumerate() {
        let (x, y) = (k as u32 % camera.width, k as u32 / camera.width);
        let clip = camera.clip_from_pixel(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let off_axis = camera.ray(clip).length();
        let solid_angle = camera.pixel_tangent().powi(2) / off_axis.powi(3);
        for c in 0..3 {
            sum[c] += pixel[c] * solid_angle / PI;
        }
    }
    sum
}

/// What a picture of the refracted limb alone brings: with it, less without.
fn of_the_limb(request: &ViewRequest, renderer: &SoftwareRenderer) -> [f64; 3] {
    let without = EffectOverrides::parse(&format!("{},-refracted-limb", request.effects.to_text())).expect("effects");
    let [with, without] = [request.effects.clone(), without].map(|effects| {
        let scene = SESSION.scene(&ViewRequest { effects, ..request.clone() }).expect("a scene");
        irradiance(&scene, &light(&scene, renderer))
    });
    std::array::from_fn(|c| with[c] - without[c])
}

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

/// Light past the Earth at places of the Moon's ground, by the eclipse, over that of the Sun at 1 au.
fn on_the_moon(renderer: &SoftwareRenderer, time: Instant, places: &[(f64, f64)]) -> Vec<[f64; 3]> {
    let prober = Prober { session: &SESSION, renderer };
    let moon = SESSION.catalog().body(NaifId::MOON).expect("the Moon");
    let receiver = Receiver::at(SESSION.ephemeris(), moon, time).expect("placed");
    let sky = Sky::over(&prober, &receiver, Wanted::Asked(EclipseModel::Refracted)).expect("a sky");
    let point = |(latitude, longitude): &(f64, f64)| ground_point_km(moon.radii_km, *latitude, *longitude, 0.0).0 / moon.radii_km.x;
    let points: Vec<DVec3> = places.iter().map(point).collect();
    let left = sky.left(&sky.casters, &points, None).expect("answers");
    let full = |p: &DVec3| {
        let point_km = receiver.body_from_icrf.transpose() * (*p * moon.radii_km.x);
        (KM_PER_AU / (receiver.sun_from_body_km - point_km).length()).powi(2)
    };
    left.iter().zip(&points).map(|(left, p)| left.map(|part| part * full(p))).collect()
}

/// From the edge of the penumbra to the middle of the umbra and over the Moon's face, in small and large pictures: the Sun beside the Earth and the
/// ring together bring what the eclipse says.
#[test]
fn the_ring_brings_the_light_that_arrives() {
    let single = renderer(Precision::F32);
    let sizes = [(64, 2.4), (150, 4.4), (320, 3.0)];
    let mut worst: f64 = 0.0;
    for (k, minutes) in [-172.0, -140.0, -118.0, -109.0, -104.0, -95.0, -60.0, 0.0, 30.0, 70.0].into_iter().enumerate() {
        let time = instant("2022-11-08T10:59:00Z").plus_seconds(60.0 * minutes);
        let places = [(0.0, 0.0), (50.0, -40.0), (-35.0, 60.0)];
        let place = k % places.len();
        let expected = on_the_moon(&single, time, &places[place..=place])[0];
        let (latitude_deg, longitude_deg) = places[place];
        let (side, fov) = sizes[(k + k / 3) % sizes.len()];
        let fov = if minutes < -90.0 { 4.4 } else { fov };
        let request = ViewRequest {
            position: Position::Ground { body: NaifId::MOON, latitude_deg, longitude_deg, height_km: 0.0017 },
            ..at(NaifId::EARTH, time, fov, side, "sun:-albedo,-glow,-night,-planet-shine")
        };
        let scene = SESSION.scene(&request).expect("a scene");
        let seen = irradiance(&scene, &light(&scene, &single));
        for c in 0..3 {
            let error = seen[c] / expected[c] - 1.0;
            println!("{minutes} min, {side} px, channel {c}: {:e} for {:e}, off by {:.4}", seen[c], expected[c], error);
            worst = worst.max(error.abs());
        }
    }
    assert!(worst < 0.03, "{worst}");
}

/// The camera on the far side from the Sun, `aside` radii off the axis.
fn behind(body: NaifId, radii: f64, aside: f64, side: u32, fov_deg: f64, effects: &str) -> ViewRequest {
    let time = instant("2022-11-08T10:59:00Z");
    let of = SESSION.catalog().body(body).expect("a body");
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("placed").state.pos_km.normalize();
    let across = to_sun.any_orthonormal_vector();
    let offset_km = (across * aside - to_sun * radii) * of.radii_km.x;
    ViewRequest { position: Position::Offset { body, offset_km, axes: Axes::Icrf }, ..at(body, time, fov_deg, side, effects) }
}

/// Its light does not depend on how large a picture shows it.
#[test]
fn the_light_is_the_same_at_every_size() {
    let single = renderer(Precision::F32);
    for (body, radii) in [(NaifId::EARTH, 60.3_f64), (NaifId::EARTH, 157.0), (MARS, 40.0), (TITAN, 30.0), (NaifId::EARTH, 8.0)] {
        let fov = 2.6 * (1.0 / radii).asin().to_degrees();
        let sums: Vec<_> =
            [20, 33, 64, 129, 400].map(|side| of_the_limb(&behind(body, radii, 0.12, side, fov, "-clouds,-night"), &single)).to_vec();
        let last = sums[sums.len() - 1];
        assert!(last[0] > 1e-9 && last[0] > last[2], "{body:?}: {last:?}");
        for (k, sum) in sums.iter().enumerate() {
            for c in 0..3 {
                println!("{body:?} {radii} {k} {c}: {:.4}", sum[c] / last[c]);
                assert!(
                    (sum[c] / last[c] - 1.0).abs() < if k == 0 { 0.06 } else { 0.03 },
                    "{body:?}, size {k}, channel {c}: {sum:?} for {last:?}"
                );
            }
        }
    }
}

/// The Sun sets behind the Earth as seen from an orbit: its light goes over from all to the last of the ring, without a step.
#[test]
fn the_light_falls_without_a_step_as_the_sun_sets() {
    let single = renderer(Precision::F32);
    let radii: f64 = 42_164.0 / 6378.137;
    let limb = (1.0 / radii).asin();
    let mut before: Option<f64> = None;
    let mut reddest: f64 = 0.0;
    for step in 0..40 {
        // The Sun's centre from the limb, solar radii, outward.
        let height = 2.0 - 0.25 * f64::from(step);
        let angle = limb + height * 0.00466;
        let (sin, cos) = angle.sin_cos();
        let mut request = behind(NaifId::EARTH, radii * cos, radii * sin, 160, 2.2, "sun:-albedo,-glow,-night,-clouds");
        let to_sun = SESSION.ephemeris().state(NaifId::SUN, NaifId::EARTH, request.time, None).expect("placed").state.pos_km;
        let Position::Offset { offset_km, .. } = request.position else { panic!("an offset") };
        request.look = orrery::scene::request::Look::Along { direction: to_sun - offset_km, axes: Axes::Icrf };
        let scene = SESSION.scene(&request).expect("a scene");
        let sum = irradiance(&scene, &light(&scene, &single));
        println!("{height:.2}: {sum:?}");
        if let Some(before) = before {
            assert!(sum[0] <= before * 1.003, "{height}: {} after {before}", sum[0]);
            assert!(sum[0] > before * 0.3 - 1e-7, "{height}: {} after {before}", sum[0]);
        }
        if step == 0 {
            assert!((sum[0] - 1.0).abs() < 0.05, "{sum:?}");
        }
        reddest = reddest.max(if sum[0] > 1e-6 { sum[0] / sum[2].max(1e-12) } else { 0.0 });
        before = Some(sum[0]);
    }
    assert!(reddest > 5.0, "the last light is red: {reddest}");
}

/// Single precision draws what double precision does, near the Earth, from the Moon and from afar.
#[test]
fn single_precision_holds_at_every_distance() {
    let [single, double] = [Precision::F32, Precision::F64].map(renderer);
    for (radii, fov_part, side) in
        [(1.06, 0.9, 64), (60.3, 2.6, 96), (157.0, 2.6, 96), (60.3, 0.05, 64), (157.0, 0.02, 64), (1500.0, 2.6, 48)]
    {
        let limb = (1.0_f64 / radii).asin();
        let fov = (fov_part * limb).to_degrees();
        let mut request = behind(NaifId::EARTH, radii, 0.3_f64.min(0.1 * radii), side, fov, "-clouds,-night,-glow");
        if fov_part < 2.0 {
            // At the limb.
            let Position::Offset { offset_km, .. } = request.position else { panic!("an offset") };
            let back = -offset_km.normalize();
            let aside = (offset_km + back * offset_km.dot(-back)).normalize_or(back.any_orthonormal_vector());
            request.look = orrery::scene::request::Look::Along { direction: back * limb.cos() + aside * limb.sin(), axes: Axes::Icrf };
        }
        let scene = SESSION.scene(&request).expect("a scene");
        assert_eq!(scene.limbs.len(), 1, "{radii}");
        let [s, d] = [&single, &double].map(|renderer| light(&scene, renderer));
        let most = d.iter().map(|p| p[0]).fold(0.0, f64::max);
        assert!(most > 1e-3, "{radii}: {most}");
        let worst = s.iter().zip(&d).map(|(s, d)| (s[0] - d[0]).abs()).fold(0.0, f64::max) / most;
        println!("{radii} {fov_part}: {worst:e} of {most:e}");
        assert!(worst < 0.5 / 256.0, "{radii} radii, {fov_part}: off by {worst} of the brightest");
    }
}

/// It is noted with a reason, and goes with the air, the effect and the place.
#[test]
fn the_limb_is_explained() {
    let on = |request: &ViewRequest| {
        let scene = SESSION.scene(request).expect("a scene");
        let body = scene.body(request.target.expect("a target")).expect("there").clone();
        let found = body.decisions.iter().find(|d| d.feature == "refracted-limb").cloned();
        assert_eq!(found.as_ref().is_some_and(|d| d.on), !scene.limbs.is_empty());
        found.map(|d| (d.on, d.reason))
    };
    let says = |request: &ViewRequest, on_: bool, words: &str| {
        let (is_on, reason) = on(request).expect("a decision");
        assert!(is_on == on_ && reason.contains(words), "{is_on}: {reason}");
    };
    says(&behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, ""), true, "of white against");
    says(&behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, "-refracted-limb"), false, "asked for");
    says(&behind(NaifId::EARTH, 60.0, 0.1, 64, 3.0, "-atmosphere"), false, "switched off");
    says(&behind(NaifId::EARTH, -60.0, 0.1, 64, 3.0, ""), false, "before the Sun");
    says(&behind(NaifId::EARTH, 6.0, 6.0, 64, 25.0, ""), false, "no layer");
    assert_eq!(on(&behind(NaifId(599), 60.0, 0.1, 64, 3.0, "")), None, "nobody knows how Jupiter's air bends light");
}
