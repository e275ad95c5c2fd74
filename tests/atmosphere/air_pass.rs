//! The coarse image of the air against its evaluation in each pixel: the error that `explain` states, in levels of a display and in thresholds of its light.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{AirPass, PixelView};
use orrery::scene::effects::{EffectOverrides, VISIBLE_CHANGE, VISIBLE_LIGHT};
use orrery::scene::request::{Axes, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 512;
const MARS: NaifId = NaifId(499);

/// Bounds of the whole images: levels of 255, and the error in thresholds of a display. Measured: see docs/accuracy.md.
const MAX_LEVELS: u8 = 1;
const MAX_THRESHOLDS: f64 = 1.0;
/// The same in an eclipse, where clouds that the ground's draw shows share the sunlight of the ground below.
const MAX_THRESHOLDS_IN_ECLIPSE: f64 = 2.0;

/// A position above a place of the Earth (latitude and longitude in degrees), at a distance in radii.
pub(super) fn over(place: [f64; 2], radii: f64) -> Position {
    let [latitude, longitude] = place.map(f64::to_radians);
    let up = glam::DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
    Position::Offset { body: NaifId::EARTH, offset_km: up * radii * 6378.137, axes: Axes::BodyFixed }
}

/// A view of the Earth.
pub(super) fn view_of_earth(time: &str, position: Position, quality: Quality) -> ViewRequest {
    ViewRequest {
        position,
        quality,
        width: SIDE,
        height: SIDE,
        fov_deg: Some(45.0),
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
    }
}

/// Name, time, position and quality of views of the Earth: by day, in a total eclipse, from the Moon's side at half phase, over the evening, at night.
fn views() -> Vec<(&'static str, ViewRequest)> {
    let from = |distance_radii| Position::Over { towards: None, distance_radii: Some(distance_radii) };
    let view = |name, time: &str, position, quality| (name, view_of_earth(time, position, quality));
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

/// The display levels and the light of an image's pixels.
pub(super) type LevelsAndLight = (Vec<[u8; 4]>, Vec<[f32; 4]>);

pub(super) fn image(scene: &Scene) -> LevelsAndLight {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    let (frame, _) = SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn");
    (frame.display, frame.hdr)
}

pub(super) struct Difference {
    /// Greatest difference of a display level.
    pub levels: u8,
    /// Number of pixels that differ in their light.
    pub changed: usize,
    /// Number of pixels whose light differs by more than a threshold.
    pub beyond: usize,
    /// Greatest difference of light in thresholds: `VISIBLE_CHANGE` of the light, or `VISIBLE_LIGHT` of white where that is more.
    pub thresholds: f64,
}

pub(super) fn difference(a: &LevelsAndLight, b: &LevelsAndLight, white: f64) -> Difference {
    let levels = a.0.iter().zip(&b.0).flat_map(|(x, y)| (0..3).map(move |c| x[c].abs_diff(y[c]))).max().unwrap_or(0);
    let changed = a.1.iter().zip(&b.1).filter(|(x, y)| x != y).count();
    let off = |x: f32, y: f32| f64::from((x - y).abs()) / (VISIBLE_CHANGE * f64::from(x)).max(VISIBLE_LIGHT * white);
    let by_pixel = a.1.iter().zip(&b.1).map(|(x, y)| (0..3).map(|c| off(x[c], y[c])).fold(0.0, f64::max));
    let (beyond, thresholds) = by_pixel.fold((0, 0.0_f64), |(beyond, greatest), off| (beyond + usize::from(off > 1.0), greatest.max(off)));
    Difference { levels, changed, beyond, thresholds }
}

/// The image whose pixels all evaluate their own air.
fn image_by_pixel(request: &ViewRequest) -> LevelsAndLight {
    image(&SESSION.scene(&ViewRequest { coarse_air: false, ..request.clone() }).expect("a scene"))
}

/// The image with the bounds of the air and of the sunlight times these factors (0: only constant light is interpolated).
fn with_bounds(scene: &Scene, of_air: f32, of_sunlight: f32) -> LevelsAndLight {
    let mut scene = scene.clone();
    scene.draws.iter_mut().for_each(|d| {
        d.uniforms.air.coarse_bound *= of_air;
        d.uniforms.eclipse.coarse_bound *= of_sunlight;
    });
    image(&scene)
}

/// Whether the ground interpolates the sunlight of an eclipse.
fn interpolates_sunlight(scene: &Scene) -> bool {
    scene.draws.iter().any(|d| d.features.coarse_sunlight().is_some() && d.uniforms.eclipse.coarse_bound.min_element() > 0.0)
}

#[test]
fn interpolated_air_keeps_its_bound() {
    for (name, request) in views() {
        let scene = SESSION.scene(&request).expect("a scene");
        let readers = scene.draws.iter().filter(|d| d.features.air_pass.is_reader()).count();
        assert_eq!(readers, 2, "{name}: ground and clouds read the image");
        assert_eq!(interpolates_sunlight(&scene), name.starts_with("eclipse"), "{name}");
        let interpolated = difference(&image_by_pixel(&request), &image(&scene), scene.exposure.white());
        let report = format!(
            "{name}: {} levels, {:.2} thresholds, {} pixels changed",
            interpolated.levels, interpolated.thresholds, interpolated.changed
        );
        println!("{report}");
        let max_thresholds = if name.starts_with("eclipse") { MAX_THRESHOLDS_IN_ECLIPSE } else { MAX_THRESHOLDS };
        assert!(interpolated.levels <= MAX_LEVELS && interpolated.thresholds <= max_thresholds, "{report}");
        // By day nearly all of the disc, which fills half of the image, is interpolated.
        assert!(!name.starts_with("day") || interpolated.changed > (SIDE * SIDE / 3) as usize, "{report}");
    }
}

/// Negative control, on a disc that is hardly larger than the smallest with a coarse image: without the bound the error exceeds it.
#[test]
fn a_missing_bound_is_detected() {
    let mut worst = 0.0_f64;
    for (name, request) in views() {
        let request = ViewRequest { width: 160, height: 160, ..request };
        let scene = SESSION.scene(&request).expect("a scene");
        let (exact, white) = (image_by_pixel(&request), scene.exposure.white());
        let (bounded, loose) = (difference(&exact, &image(&scene), white), difference(&exact, &with_bounds(&scene, 1e6, 1e6), white));
        println!("{name}: {:.2} thresholds, without a bound {:.2}", bounded.thresholds, loose.thresholds);
        assert!(bounded.levels <= MAX_LEVELS && bounded.thresholds <= MAX_THRESHOLDS, "{name}: {:.2}", bounded.thresholds);
        worst = worst.max(loose.thresholds);
    }
    assert!(worst > 2.0 * MAX_THRESHOLDS, "{worst}");
}

/// Negative control of the sunlight alone: the air keeps its bound.
#[test]
fn a_missing_bound_of_the_sunlight_is_detected() {
    for (name, request) in views().into_iter().filter(|(name, _)| name.starts_with("eclipse")) {
        let request = ViewRequest { width: 160, height: 160, ..request };
        let scene = SESSION.scene(&request).expect("a scene");
        let loose = difference(&image_by_pixel(&request), &with_bounds(&scene, 1.0, 1e6), scene.exposure.white());
        println!("{name}: without a bound of the sunlight {:.2} thresholds", loose.thresholds);
        assert!(loose.thresholds > 2.0 * MAX_THRESHOLDS, "{name}: {:.2}", loose.thresholds);
    }
}

/// The shadow of Phobos is smaller than a texel: each pixel evaluates its sunlight. Negative control: interpolated within the bound of the air, it would be lost.
#[test]
fn a_shadow_smaller_than_a_texel_is_kept() {
    // Phobos crosses the Sun, as Curiosity saw it.
    let [latitude, longitude] = [-4.59_f64, 137.44].map(f64::to_radians);
    let up = glam::DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
    let request = ViewRequest {
        position: Position::Offset { body: MARS, offset_km: up * 3.0 * 3396.19, axes: Axes::BodyFixed },
        quality: Quality::Draft,
        width: 256,
        height: 256,
        ..ViewRequest::of(MARS, Instant::parse("2013-08-20T07:11:29Z").expect("a time"))
    };
    let mut worst = 0;
    // The shadow falls between the texels in some of these fields of view, and on one in others.
    for fov_deg in [40.0, 42.0, 44.0, 46.0, 48.0, 50.0] {
        let request = ViewRequest { fov_deg: Some(fov_deg), ..request.clone() };
        let mut scene = SESSION.scene(&request).expect("a scene");
        assert!(scene.draws.iter().any(|d| d.features.coarse_sunlight().is_some()), "the ground reads the image, under an eclipse");
        let exact = image_by_pixel(&request);
        let kept = difference(&exact, &image(&scene), scene.exposure.white());
        scene.draws.iter_mut().for_each(|d| d.uniforms.eclipse.coarse_bound = d.uniforms.air.coarse_bound);
        let lost = difference(&exact, &image(&scene), scene.exposure.white());
        println!("{fov_deg} degrees: {} levels, interpolated in spite of its size {}", kept.levels, lost.levels);
        assert!(kept.levels <= MAX_LEVELS && kept.thresholds <= MAX_THRESHOLDS, "{fov_deg} degrees: {} levels", kept.levels);
        worst = worst.max(lost.levels);
    }
    assert!(worst > 4 * MAX_LEVELS, "{worst} levels");
}

/// Without room for an error each pixel evaluates its air by the same code: only the compiler's order of additions may differ.
#[test]
fn without_room_for_an_error_each_pixel_evaluates_its_air() {
    let (name, request) = views().swap_remove(2);
    let scene = SESSION.scene(&request).expect("a scene");
    let rounding = difference(&image_by_pixel(&request), &with_bounds(&scene, 0.0, 0.0), scene.exposure.white());
    assert!(rounding.thresholds < 0.01, "{name}: {:.4}, {} pixels", rounding.thresholds, rounding.changed);
}

#[test]
fn other_views_evaluate_each_pixel_and_say_why() {
    let (_, day) = views().swap_remove(0);
    let cases = [
        ("linear light", ViewRequest { purpose: Purpose::LINEAR, ..day.clone() }),
        ("reference quality", ViewRequest { quality: Quality::Reference, ..day.clone() }),
        ("px wide", ViewRequest { width: 64, height: 64, ..day.clone() }),
        ("too few samples", ViewRequest { effects: EffectOverrides::parse("+atmosphere=vertex").expect("effects"), ..day.clone() }),
        ("by itself", ViewRequest { coarse_air: false, ..day.clone() }),
        ("shows no light of the air", ViewRequest { pixel_view: PixelView::Normal, ..day.clone() }),
    ];
    for (why, request) in cases {
        let scene = SESSION.scene(&request).expect("a scene");
        assert!(scene.draws.iter().all(|d| d.features.air_pass == AirPass::None), "{why}");
        let decisions = &scene.body(NaifId::EARTH).expect("the Earth").decisions;
        let decision = decisions.iter().find(|d| d.feature == "air-pass");
        // Without the light of the air the atmosphere itself may be left out.
        assert!(decision.is_none_or(|d| !d.on && d.reason.to_string().contains(why)), "{why}: {decision:?}");
        assert!(decision.is_some() || why == "shows no light of the air");
    }
}
