//! Air interpolated from the coarse image against air evaluated in each pixel: the difference must not exceed the bound that `explain`
//! states. It is measured in display levels, and in multiples of the smallest visible change of light (thresholds).

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{AirPass, AtmosphereModel, PixelView};
use orrery::scene::effects::{EffectOverrides, VISIBLE_CHANGE, VISIBLE_LIGHT};
use orrery::scene::request::{Axes, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 512;
const MARS: NaifId = NaifId(499);

/// Largest differences in an image: in levels of 255, and in thresholds ([`Difference::thresholds`]). docs/accuracy.md lists measured
/// values.
const MAX_LEVELS: u8 = 1;
const MAX_THRESHOLDS: f64 = 1.0;
/// The same in an eclipse, where clouds that the ground's draw shades get the sunlight of the ground below them.
const MAX_THRESHOLDS_IN_ECLIPSE: f64 = 2.0;

/// The position above a place on the Earth (latitude and longitude in degrees), at a distance from the centre in radii.
pub(super) fn over(place: [f64; 2], radii: f64) -> Position {
    let [latitude, longitude] = place.map(f64::to_radians);
    let up = glam::DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
    Position::Offset { body: NaifId::EARTH, offset_km: up * radii * 6378.137, axes: Axes::BodyFixed }
}

/// A square view of the Earth, 45 degrees wide.
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

/// Named views of the Earth: at full phase, in a total eclipse, at half phase, as a crescent, and from low above the evening terminator.
fn views() -> Vec<(&'static str, ViewRequest)> {
    let from_sunward = |distance_radii| Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) };
    let view = |name, time: &str, position, quality| (name, view_of_earth(time, position, quality));
    vec![
        view("day", "2024-06-08T18:17:16Z", from_sunward(3.0), Quality::Draft),
        view("day, all orders", "2024-06-08T18:17:16Z", from_sunward(3.0), Quality::Standard),
        view("eclipse", "2024-04-08T18:17:16Z", from_sunward(3.0), Quality::Standard),
        view("eclipse, draft", "2024-04-08T18:17:16Z", from_sunward(3.0), Quality::Draft),
        view("half phase", "2024-06-14T12:00:00Z", over([0.0, 90.0], 3.0), Quality::Standard),
        view("crescent", "2024-06-14T12:00:00Z", over([0.0, 150.0], 3.0), Quality::Draft),
        view("evening, low", "2024-06-14T00:00:00Z", over([20.0, -90.0], 1.2), Quality::Standard),
    ]
}

/// The display levels and the light of an image's pixels.
pub(super) type LevelsAndLight = (Vec<[u8; 4]>, Vec<[f32; 4]>);

pub(super) fn image(scene: &Scene) -> LevelsAndLight {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    let (frame, _) = SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn");
    (frame.display, frame.hdr)
}

pub(super) struct Difference {
    /// Greatest difference in display levels.
    pub levels: u8,
    /// Number of pixels whose light differs at all.
    pub changed: usize,
    /// Number of pixels whose light differs by more than one threshold.
    pub beyond_threshold: usize,
    /// Greatest difference of light in thresholds. A threshold is `VISIBLE_CHANGE` times the light or `VISIBLE_LIGHT` times white,
    /// whichever is more.
    pub thresholds: f64,
}

pub(super) fn difference(a: &LevelsAndLight, b: &LevelsAndLight, white: f64) -> Difference {
    let levels = a.0.iter().zip(&b.0).flat_map(|(x, y)| (0..3).map(move |c| x[c].abs_diff(y[c]))).max().unwrap_or(0);
    let changed = a.1.iter().zip(&b.1).filter(|(x, y)| x != y).count();
    let in_thresholds = |x: f32, y: f32| f64::from((x - y).abs()) / (VISIBLE_CHANGE * f64::from(x)).max(VISIBLE_LIGHT * white);
    let by_pixel = a.1.iter().zip(&b.1).map(|(x, y)| (0..3).map(|c| in_thresholds(x[c], y[c])).fold(0.0, larger));
    let (beyond_threshold, thresholds) =
        by_pixel.fold((0, 0.0_f64), |(count, greatest), difference| (count + usize::from(difference > 1.0), larger(greatest, difference)));
    Difference { levels, changed, beyond_threshold, thresholds }
}

/// The image drawn without a coarse image: every pixel evaluates its own air.
fn image_by_pixel(request: &ViewRequest) -> LevelsAndLight {
    image(&SESSION.scene(&ViewRequest { may_use_coarse_air: false, ..request.clone() }).expect("a scene"))
}

/// The image drawn with the bounds of the interpolation multiplied by these factors. With a bound of 0, only constant light is
/// interpolated.
fn image_with_scaled_bounds(scene: &Scene, air_factor: f32, sunlight_factor: f32) -> LevelsAndLight {
    let mut scene = scene.clone();
    scene.draws.iter_mut().for_each(|d| {
        d.uniforms.air.max_coarse_error *= air_factor;
        d.uniforms.eclipse.max_coarse_error *= sunlight_factor;
    });
    image(&scene)
}

/// Whether the ground interpolates the sunlight of an eclipse.
fn interpolates_sunlight(scene: &Scene) -> bool {
    scene.draws.iter().any(|d| d.features.coarse_sunlight().is_some() && d.uniforms.eclipse.max_coarse_error.min_element() > 0.0)
}

#[test]
fn interpolated_air_keeps_its_bound() {
    for (name, request) in views() {
        let scene = SESSION.scene(&request).expect("a scene");
        let readers = scene.draws.iter().filter(|d| d.features.air_pass.is_reader()).count();
        assert_eq!(readers, 2, "{name}: ground and clouds must read the coarse image");
        assert_eq!(interpolates_sunlight(&scene), name.starts_with("eclipse"), "{name}");
        let interpolated = difference(&image_by_pixel(&request), &image(&scene), scene.exposure.white());
        let report = format!(
            "{name}: {} levels, {:.2} thresholds, {} pixels changed",
            interpolated.levels, interpolated.thresholds, interpolated.changed
        );
        println!("{report}");
        let max_thresholds = if name.starts_with("eclipse") { MAX_THRESHOLDS_IN_ECLIPSE } else { MAX_THRESHOLDS };
        assert!(interpolated.levels <= MAX_LEVELS && interpolated.thresholds <= max_thresholds, "{report}");
        // At full phase nearly all of the disc, which covers 57 % of the image, is interpolated.
        assert!(!name.starts_with("day") || interpolated.changed > (SIDE * SIDE / 3) as usize, "{report}");
    }
}

/// Negative control: without a bound the interpolation's error is too large. At 160 pixels, from 3 radii, the disc is hardly larger than
/// the 128 pixels that a coarse image requires.
#[test]
fn a_missing_bound_is_detected() {
    let mut worst_unbounded = 0.0_f64;
    for (name, request) in views() {
        let request = ViewRequest { width: 160, height: 160, ..request };
        let scene = SESSION.scene(&request).expect("a scene");
        let (exact, white) = (image_by_pixel(&request), scene.exposure.white());
        let bounded = difference(&exact, &image(&scene), white);
        let unbounded = difference(&exact, &image_with_scaled_bounds(&scene, 1e6, 1e6), white);
        println!("{name}: {:.2} thresholds, without a bound {:.2}", bounded.thresholds, unbounded.thresholds);
        assert!(bounded.levels <= MAX_LEVELS && bounded.thresholds <= MAX_THRESHOLDS, "{name}: {:.2}", bounded.thresholds);
        worst_unbounded = worst_unbounded.max(unbounded.thresholds);
    }
    assert!(worst_unbounded > 2.0 * MAX_THRESHOLDS, "{worst_unbounded}");
}

/// Negative control for the sunlight in an eclipse: only its bound is removed.
#[test]
fn a_missing_bound_of_the_sunlight_is_detected() {
    for (name, request) in views().into_iter().filter(|(name, _)| name.starts_with("eclipse")) {
        let request = ViewRequest { width: 160, height: 160, ..request };
        let scene = SESSION.scene(&request).expect("a scene");
        let unbounded = difference(&image_by_pixel(&request), &image_with_scaled_bounds(&scene, 1.0, 1e6), scene.exposure.white());
        println!("{name}: without a bound of the sunlight {:.2} thresholds", unbounded.thresholds);
        assert!(unbounded.thresholds > 2.0 * MAX_THRESHOLDS, "{name}: {:.2}", unbounded.thresholds);
    }
}

/// The shadow of Phobos is smaller than a texel, so each pixel evaluates its own sunlight. Negative control: interpolated with the bound of
/// the air, the shadow is lost.
#[test]
fn a_shadow_smaller_than_a_texel_is_kept() {
    // The place and time at which Curiosity saw Phobos cross the Sun.
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
    // In some of these fields of view the shadow falls between the texels, in others on a texel.
    for fov_deg in [40.0, 42.0, 44.0, 46.0, 48.0, 50.0] {
        let request = ViewRequest { fov_deg: Some(fov_deg), ..request.clone() };
        let mut scene = SESSION.scene(&request).expect("a scene");
        assert!(scene.draws.iter().any(|d| d.features.coarse_sunlight().is_some()), "the ground must have a coarse image of its sunlight");
        let exact = image_by_pixel(&request);
        let kept = difference(&exact, &image(&scene), scene.exposure.white());
        scene.draws.iter_mut().for_each(|d| d.uniforms.eclipse.max_coarse_error = d.uniforms.air.max_coarse_error);
        let lost = difference(&exact, &image(&scene), scene.exposure.white());
        println!("{fov_deg} degrees: {} levels, wrongly interpolated {}", kept.levels, lost.levels);
        assert!(kept.levels <= MAX_LEVELS && kept.thresholds <= MAX_THRESHOLDS, "{fov_deg} degrees: {} levels", kept.levels);
        worst = worst.max(lost.levels);
    }
    assert!(worst > 4 * MAX_LEVELS, "{worst} levels");
}

/// With bounds of 0 each pixel evaluates its own air, with the same code as without a coarse image: only rounding may differ.
#[test]
fn with_bounds_of_zero_each_pixel_evaluates_its_own_air() {
    let (name, request) = views().swap_remove(2);
    assert_eq!(name, "eclipse");
    let scene = SESSION.scene(&request).expect("a scene");
    let rounding = difference(&image_by_pixel(&request), &image_with_scaled_bounds(&scene, 0.0, 0.0), scene.exposure.white());
    assert!(rounding.thresholds < 0.01, "{name}: {:.4}, {} pixels", rounding.thresholds, rounding.changed);
}

#[test]
fn views_without_a_coarse_image_state_the_reason() {
    let (_, day) = views().swap_remove(0);
    // Part of the reason, and the view.
    let cases = [
        ("linear light", ViewRequest { purpose: Purpose::LINEAR, ..day.clone() }),
        ("reference quality", ViewRequest { quality: Quality::Reference, ..day.clone() }),
        ("px wide", ViewRequest { width: 64, height: 64, ..day.clone() }),
        ("too few samples", ViewRequest { effects: EffectOverrides::parse("+atmosphere=vertex").expect("effects"), ..day.clone() }),
        ("by itself", ViewRequest { may_use_coarse_air: false, ..day.clone() }),
        ("shows no light of the air", ViewRequest { pixel_view: PixelView::Normal, ..day.clone() }),
    ];
    for (why, request) in cases {
        let scene = SESSION.scene(&request).expect("a scene");
        assert!(scene.draws.iter().all(|d| d.features.air_pass == AirPass::None), "{why}");
        let decisions = &scene.body(NaifId::EARTH).expect("the Earth").decisions;
        let decision = decisions.iter().find(|d| d.effect == "air-pass");
        // A pixel view that shows no light of the air may omit the atmosphere, and then also this decision.
        assert!(decision.is_none_or(|d| !d.on && d.reason.to_string().contains(why)), "{why}: {decision:?}");
        assert!(decision.is_some() || why == "shows no light of the air");
    }
}

/// Draft quality leaves out multiple scattering from far away only: near the air it is a fifth to a half of the light (`orrery measure`).
#[test]
fn draft_quality_includes_multiple_scattering_near_the_air() {
    let day = "2024-06-08T18:17:16Z";
    let on_ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 5.0, longitude_deg: -15.0, height_km: 0.1 };
    for (position, expected) in [
        (over([20.0, -90.0], 3.0), AtmosphereModel::Pixel8),
        (over([20.0, -90.0], 1.26), AtmosphereModel::Pixel8),
        (over([20.0, -90.0], 1.24), AtmosphereModel::Table),
        (on_ground, AtmosphereModel::Table),
    ] {
        let scene = SESSION.scene(&view_of_earth(day, position, Quality::Draft)).expect("a scene");
        let models: Vec<_> = scene.draws.iter().map(|d| d.features.air.model).filter(|m| *m != AtmosphereModel::None).collect();
        assert!(!models.is_empty() && models.iter().all(|m| *m == expected), "{position:?}: {models:?}");
    }
}

/// From inside the air, from its top and from above: the column between the camera and the ground is that of each pixel's own evaluation.
#[test]
fn the_air_is_interpolated_at_any_height() {
    let mut readers = 0;
    // The sign of y puts the place on the day side.
    for (body, radius_km, y) in [(NaifId::EARTH, 6378.137, -0.97), (MARS, 3396.19, 0.97), (NaifId(606), 2575.0, 0.97)] {
        for height_km in [0.1, 1.0, 5.0, 20.0, 60.0, 150.0, 500.0] {
            let up = glam::DVec3::new(0.1, y, 0.2).normalize();
            let request = ViewRequest {
                position: Position::Offset { body, offset_km: up * (radius_km + height_km), axes: Axes::BodyFixed },
                effects: EffectOverrides::parse("-detail").expect("effects"),
                quality: Quality::Standard,
                width: 160,
                height: 160,
                fov_deg: Some(60.0),
                ..ViewRequest::of(body, Instant::parse("2024-06-08T18:17:16Z").expect("a time"))
            };
            let scene = SESSION.scene(&request).expect("a scene");
            readers += scene.draws.iter().filter(|d| d.features.air_pass.is_reader()).count();
            let found = difference(&image_by_pixel(&request), &image(&scene), scene.exposure.white());
            let report = format!("{} from {height_km} km: {} levels, {:.2} thresholds", body.0, found.levels, found.thresholds);
            println!("{report}");
            assert!(found.levels <= MAX_LEVELS && found.thresholds <= MAX_THRESHOLDS, "{report}");
        }
    }
    assert!(readers > 10, "{readers} draws read a coarse image");
}
