//! The coarse picture of the air against its evaluation in each pixel: the error that `explain` states, in levels of a display and in parts of the light.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{AirPass, PixelView};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 512;

/// Bounds of the whole pictures: levels of 255, and parts of the light of pixels brighter than a thousandth of white. Measured: see docs/accuracy.md.
const MOST_LEVELS: u8 = 1;
const MOST_OF_LIGHT: f32 = 2.0e-3;

/// Name, time, position and quality of views of the Earth: by day, in a total eclipse, from the Moon's side at half phase, over the evening, at night.
fn views() -> Vec<(&'static str, ViewRequest)> {
    let from = |distance_radii| Position::Over { towards: None, distance_radii: Some(distance_radii) };
    let over = |degrees: [f64; 2], radii: f64| {
        let [latitude, longitude] = degrees.map(f64::to_radians);
        let up = glam::DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
        Position::Offset { body: NaifId::EARTH, offset_km: up * radii * 6378.137, axes: Axes::BodyFixed }
    };
    let view = |name, time: &str, position, quality| {
        let request = ViewRequest {
            position,
            quality,
            width: SIDE,
            height: SIDE,
            fov_deg: Some(45.0),
            ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
        };
        (name, request)
    };
    vec![
        view("day", "2024-06-08T18:17:16Z", from(3.0), Quality::Draft),
        view("day, all orders", "2024-06-08T18:17:16Z", from(3.0), Quality::Standard),
        view("eclipse", "2024-04-08T18:17:16Z", from(3.0), Quality::Standard),
        view("eclipse, draft", "2024-04-08T18:17:16Z", from(3.0), Quality::Draft),
        view("half phase", "2024-06-14T12:00:00Z", over([0.0, 90.0], 3.0), Quality::Standard),
        view("crescent", "2024-06-14T12:00:00Z", over([0.0, 150.0], 3.0), Quality::Draft),
        view("evening, low", "2024-06-14T00:00:00Z", over([20.0, -90.0], 1.2), Quality::Standard),
    ]
}

/// The display levels and the light of a scene.
fn picture(scene: &Scene) -> (Vec<[u8; 4]>, Vec<[f32; 4]>) {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    let (frame, _) = SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn");
    (frame.display, frame.hdr)
}

struct Difference {
    /// Greatest difference of a level, and the number of pixels that differ in their light.
    levels: u8,
    changed: usize,
    /// Greatest relative difference of light that is brighter than a thousandth of white.
    part: f32,
}

fn difference(a: &(Vec<[u8; 4]>, Vec<[f32; 4]>), b: &(Vec<[u8; 4]>, Vec<[f32; 4]>), white: f32) -> Difference {
    let levels = a.0.iter().zip(&b.0).flat_map(|(x, y)| (0..3).map(move |c| x[c].abs_diff(y[c]))).max().unwrap_or(0);
    let changed = a.1.iter().zip(&b.1).filter(|(x, y)| x != y).count();
    let parts = a.1.iter().zip(&b.1).flat_map(|(x, y)| (0..3).map(move |c| (x[c], y[c]))).filter(|(x, _)| *x > 1e-3 * white);
    Difference { levels, changed, part: parts.map(|(x, y)| (x - y).abs() / x).fold(0.0, f32::max) }
}

/// The picture as it is, with the bound times `factor` (0: nothing is interpolated).
fn with_bound(scene: &Scene, factor: f32) -> (Vec<[u8; 4]>, Vec<[f32; 4]>) {
    let mut scene = scene.clone();
    scene.draws.iter_mut().for_each(|d| d.uniforms.air.coarse_bound *= factor);
    picture(&scene)
}

#[test]
fn interpolated_air_keeps_its_bound_and_a_loose_bound_shows() {
    // The worst of all views if any texel may be interpolated whose neighbours meet the ground.
    let (mut levels, mut part) = (0, 0.0_f32);
    for (name, request) in views() {
        let scene = SESSION.scene(&request).expect("a scene");
        let readers = scene.draws.iter().filter(|d| d.features.air_pass == AirPass::Read).count();
        assert_eq!(readers, 2, "{name}: ground and clouds read the picture");
        let white = scene.exposure.white() as f32;
        let mut exact = scene.clone();
        assert!(exact.evaluate_air_in_each_pixel());
        let evaluated = picture(&exact);
        let interpolated = difference(&evaluated, &picture(&scene), white);
        let loose = difference(&evaluated, &with_bound(&scene, 1e6), white);
        let report = format!(
            "{name}: {} levels, {:.2e} of the light, {} pixels changed; without a bound {} levels, {:.2e}",
            interpolated.levels, interpolated.part, interpolated.changed, loose.levels, loose.part
        );
        println!("{report}");
        assert!(interpolated.levels <= MOST_LEVELS && interpolated.part <= MOST_OF_LIGHT, "{report}");
        // By day nearly all of the disc, which fills half of the picture, is interpolated.
        assert!(!name.starts_with("day") || interpolated.changed > (SIDE * SIDE / 3) as usize, "{report}");
        (levels, part) = (levels.max(loose.levels), part.max(loose.part));
    }
    assert!(levels > MOST_LEVELS && part > 2.0 * MOST_OF_LIGHT, "a bound that is no bound is noticed: {levels} levels, {part:.2e}");
}

/// Without room for an error each pixel evaluates its air by the same code: only the compiler's order of additions may differ.
#[test]
fn without_room_for_an_error_each_pixel_evaluates_its_air() {
    let (name, request) = views().swap_remove(2);
    let scene = SESSION.scene(&request).expect("a scene");
    let mut exact = scene.clone();
    exact.evaluate_air_in_each_pixel();
    let apart = difference(&picture(&exact), &with_bound(&scene, 0.0), scene.exposure.white() as f32);
    assert!(apart.part < 1e-5, "{name}: {:.2e}, {} pixels", apart.part, apart.changed);
}

#[test]
fn other_views_evaluate_each_pixel_and_say_why() {
    let (_, day) = views().swap_remove(0);
    let cases = [
        ("linear light", ViewRequest { purpose: Purpose::LINEAR, ..day.clone() }),
        ("reference quality", ViewRequest { quality: Quality::Reference, ..day.clone() }),
        ("px wide", ViewRequest { width: 64, height: 64, ..day.clone() }),
        ("as few as they can be", ViewRequest { effects: EffectOverrides::parse("+atmosphere=vertex").expect("effects"), ..day.clone() }),
        ("shows no light of the air", ViewRequest { pixel_view: PixelView::Normal, ..day.clone() }),
    ];
    for (why, request) in cases {
        let scene = SESSION.scene(&request).expect("a scene");
        assert!(scene.draws.iter().all(|d| d.features.air_pass == AirPass::None), "{why}");
        let decisions = &scene.body(NaifId::EARTH).expect("the Earth").decisions;
        let decision = decisions.iter().find(|d| d.feature == "air-pass");
        // Without the light of the air the atmosphere itself may be left out.
        assert!(decision.is_none_or(|d| !d.on && d.reason.contains(why)), "{why}: {decision:?}");
        assert!(decision.is_some() || why == "shows no light of the air");
    }
}
