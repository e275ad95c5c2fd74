//! Eclipses are drawn together with the rings' shadow under air, and with relief and billows finer than the maps: light does not jump in time, nor between
//! cameras at one place.

use crate::support::folds::{larger, smaller};
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::draw::{BodyPart, Detail, Draw, PixelView, RingShadow};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::time::Instant;

const SATURN: NaifId = NaifId(699);
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 4 };

/// A view from above a place (latitude, east longitude, height in km), along a direction in body axes.
fn above(body: NaifId, [latitude_deg, longitude_deg, height_km]: [f64; 3], direction: DVec3, fov_deg: f64, time: &str) -> ViewRequest {
    ViewRequest {
        position: Position::Ground { body, latitude_deg, longitude_deg, height_km },
        look: Look::Along { direction, axes: Axes::BodyFixed },
        up: Up::Zenith,
        fov_deg: Some(fov_deg),
        exposure: ExposureRequest::Stops(0.0),
        layers: Layers::NONE,
        width: 48,
        height: 36,
        ..ViewRequest::of(body, Instant::parse(time).expect("a time"))
    }
}

/// From 100 m above the Moon, at 20 degrees north and 60 degrees east, towards the north-west and 15 degrees down.
fn low_over_the_moon(time: &str) -> ViewRequest {
    let direction = DVec3::new(-0.9286410655049862, 0.0645791000260818, 0.3653153586938076);
    above(NaifId::MOON, [20.0, 60.0, 0.1], direction, 60.0, time)
}

fn scene(request: &ViewRequest, effects: &str) -> Scene {
    SESSION.scene(&ViewRequest { effects: EffectOverrides::parse(effects).expect("effects"), ..request.clone() }).expect("a scene")
}

fn draw_of(scene: &Scene, body: NaifId, part: BodyPart) -> &Draw {
    scene.draws.iter().find(|d| d.body == body && d.part == part).expect("drawn")
}

/// Whether the eclipse of a body counts as drawn, by its last decision, and the reasons of all.
fn eclipse_decision(scene: &Scene, body: NaifId) -> (bool, String) {
    let decisions = &scene.body(body).expect("in the catalog").decisions;
    let of_eclipse: Vec<_> = decisions.iter().filter(|d| d.effect == "eclipse").collect();
    let reasons: Vec<String> = of_eclipse.iter().map(|d| d.reason.to_string()).collect();
    (of_eclipse.last().is_some_and(|d| d.on), reasons.join("; "))
}

/// On 2007-02-01 Mimas' penumbra is 37 degrees from the camera, which is 200 km above Saturn: its draws have no eclipse, as they would not show it.
#[test]
fn a_moons_shadow_elsewhere_is_not_drawn() {
    let along_the_ground = DVec3::new(-0.8382754701224185, 0.21276648187839925, 0.5020205776461033);
    let far_from_it = above(SATURN, [25.0, 300.7515, 200.0], along_the_ground, 90.0, "2007-02-01T12:00:00Z");
    let decided = scene(&far_from_it, "");
    for part in [BodyPart::Globe, BodyPart::Sky] {
        let features = draw_of(&decided, SATURN, part).features;
        assert!(features.eclipse.occluders == 0 && features.ring_shadow == RingShadow::Penumbra, "{part:?}: {features:?}");
    }
    let (is_on, reasons) = eclipse_decision(&decided, SATURN);
    assert!(!is_on && reasons.contains("Mimas") && reasons.contains("not on what the image shows"), "{reasons}");
}

/// From 200 km above Saturn, almost straight down, on 2024-10-01: the image shows the edge of the rings' shadow and, around 02:10, the shadow of Janus.
fn below_rings_and_janus(latitude_deg: f64, fov_deg: f64, time: Instant) -> ViewRequest {
    let direction = DVec3::new(-0.9686, 0.1621, 0.1883).normalize();
    ViewRequest { time, ..above(SATURN, [latitude_deg, 350.5, 200.0], direction, fov_deg, "2024-10-01T02:10:00Z") }
}

/// The linear light of an image.
fn light(request: &ViewRequest, effects: &str) -> Vec<[f32; 4]> {
    let view = ViewRequest { effects: EffectOverrides::parse(effects).expect("effects"), ..request.clone() };
    SESSION.draw(&view, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
}

/// From within Saturn's air the shadows of the rings and of Janus are drawn together: where only one of them falls, the image is that with this shadow alone;
/// nowhere is it brighter.
#[test]
fn the_shadows_of_rings_and_of_a_moon_are_drawn_together_from_within_the_air() {
    let time = Instant::parse("2024-10-01T02:10:00Z").expect("a time");
    let view = ViewRequest { purpose: Purpose::LINEAR, ..below_rings_and_janus(-5.7, 140.0, time) };
    let decided = scene(&view, "");
    for part in [BodyPart::Globe, BodyPart::Sky] {
        let features = draw_of(&decided, SATURN, part).features;
        assert!(features.eclipse.occluders > 0 && features.ring_shadow == RingShadow::Penumbra, "{part:?}: {features:?}");
    }
    let [both, rings, janus, neither] = ["", "-eclipse", "-ring-shadow", "-eclipse,-ring-shadow"].map(|effects| light(&view, effects));
    let differs = |a: f32, b: f32, bound: f32| (a - b).abs() > bound * a.max(b);
    let (mut in_rings, mut in_janus) = (0, 0);
    for k in 0..both.len() {
        let [both, rings, janus, neither] = [&both, &rings, &janus, &neither].map(|image| image[k][1]);
        let values = format!("pixel {k}: {both} with both, {rings} rings, {janus} Janus, {neither} neither");
        assert!(both <= 1.003 * rings.min(janus), "{values}");
        assert!(differs(rings, neither, 2e-3) || !differs(both, janus, 6e-3), "{values}");
        assert!(differs(janus, neither, 2e-3) || !differs(both, rings, 6e-3), "{values}");
        in_rings += u32::from(rings < 0.9 * neither);
        in_janus += u32::from(janus < 0.9 * neither);
    }
    println!("{in_rings} pixels in the rings' shadow, {in_janus} in that of Janus");
    assert!(in_rings > 80 && in_janus > 10, "{in_rings} {in_janus}");
}

/// While the shadow of Janus enters such an image, its light falls gradually: in 5 s by some thousandths. If one shadow took the place of the other, it would
/// fall by 0.8 % at once.
#[test]
fn the_light_of_saturn_changes_gradually_while_a_moons_shadow_enters_the_image() {
    let start = Instant::parse("2024-10-01T02:08:00Z").expect("a time");
    let mean_light = |step: i32| {
        let view = below_rings_and_janus(-6.0, 140.0, start.plus_seconds(5.0 * f64::from(step)));
        let pixels = light(&view, "");
        pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
    };
    let means: Vec<f64> = (0..16).map(mean_light).collect();
    let (least, most) = (means.iter().copied().fold(f64::INFINITY, smaller), means.iter().copied().fold(0.0, larger));
    let greatest_step = means.windows(2).map(|w| (w[1] / w[0] - 1.0).abs()).fold(0.0, larger);
    println!("mean light {least} to {most}, steps up to {greatest_step:.5}");
    assert!(greatest_step < 0.004 && least < 0.995 * most, "{greatest_step}: {means:?}");
}

/// The two images have the same pixels: the narrow one is the middle of the wide one. Returns the greatest relative difference of its pixels.
fn difference_of_middle(wide: &ViewRequest, narrow: &ViewRequest) -> f64 {
    let (in_wide, in_narrow) = (light(wide, ""), light(narrow, ""));
    let (left, top) = ((wide.width - narrow.width) / 2, (wide.height - narrow.height) / 2);
    let difference = |k: usize| {
        let (x, y) = (k as u32 % narrow.width, k as u32 / narrow.width);
        let (a, b) = (in_narrow[k], in_wide[((y + top) * wide.width + x + left) as usize]);
        (0..3).map(|c| f64::from((a[c] - b[c]).abs() / a[c].max(b[c]).max(f32::MIN_POSITIVE))).fold(0.0, larger)
    };
    (0..in_narrow.len()).map(difference).fold(0.0, larger)
}

/// The same view in half the width and height, with pixels of the same size.
fn middle_of(wide: &ViewRequest) -> ViewRequest {
    let half_fov = |degrees: f64| (0.5 * (0.5 * degrees).to_radians().tan()).atan().to_degrees();
    ViewRequest { width: wide.width / 2, height: wide.height / 2, fov_deg: wide.fov_deg.map(|fov| 2.0 * half_fov(fov)), ..wide.clone() }
}

/// Two cameras at one place, such as those of two faces of a dome image, show the same light where their images overlap, whichever shadows are in the rest of
/// each image.
#[test]
fn cameras_at_one_place_agree_on_shadows() {
    for minutes in [8.2, 10.0, 12.3] {
        let time = Instant::parse("2024-10-01T02:00:00Z").expect("a time").plus_seconds(60.0 * minutes);
        // With 48 x 40 pixels the middle begins at even pixels, so that derivatives are taken over the same pixels.
        let wide = ViewRequest { purpose: Purpose::LINEAR, height: 40, ..below_rings_and_janus(-5.7, 140.0, time) };
        let difference = difference_of_middle(&wide, &middle_of(&wide));
        println!("{minutes} min: {difference:.1e}");
        assert!(difference < 4e-3, "{minutes} min: {difference}");
    }
}

/// From within the rings' shadow the sky of Saturn is dark, also in an image that shows neither ground nor rings; without their shadow it is more than five
/// times as bright.
#[test]
fn the_sky_is_in_the_rings_shadow_with_and_without_ground_in_the_image() {
    let up = DVec3::new(0.24003756416221467, -0.40346687107580137, 0.882947592858927);
    let wide = above(SATURN, [22.0, 300.75, 100.0], up, 120.0, "2007-02-01T12:00:00Z");
    let wide = ViewRequest { purpose: Purpose::LINEAR, height: 40, ..wide };
    let narrow = middle_of(&wide);
    let parts = |request: &ViewRequest| -> Vec<BodyPart> {
        scene(request, "").draws.iter().filter(|d| d.body == SATURN && d.part != BodyPart::Sky).map(|d| d.part).collect()
    };
    assert!(parts(&wide).contains(&BodyPart::Globe) && parts(&narrow).is_empty(), "{:?} {:?}", parts(&wide), parts(&narrow));
    let difference = difference_of_middle(&wide, &narrow);
    assert!(difference < 4e-3, "{difference}");
    let mean_light = |effects: &str| light(&narrow, effects).iter().map(|p| f64::from(p[1])).sum::<f64>();
    let ratio = mean_light("-ring-shadow") / mean_light("");
    println!("difference {difference:.1e}; without the shadow {ratio:.2} times as bright");
    assert!(ratio > 5.0, "{ratio}");
}

/// From 15 km above the Earth, at 40 degrees north and 110 degrees west.
fn over_utah(time: &str) -> ViewRequest {
    let direction = DVec3::new(0.7477018538483815, -0.39151608974397645, -0.5363367311897258);
    above(NaifId::EARTH, [40.0, -110.0, 15.0], direction, 60.0, time)
}

/// On 2024-04-08 hills and billows are drawn before the Moon's penumbra comes and in it. At 16:40 it is in the image, but not in the middle of it.
#[test]
fn hills_and_billows_are_drawn_in_an_eclipse() {
    let features = |request: &ViewRequest| {
        let decided = scene(request, "");
        [BodyPart::Globe, BodyPart::Clouds].map(|part| draw_of(&decided, NaifId::EARTH, part).features)
    };
    for (time, occluders) in [("2024-04-08T16:30:00Z", 0), ("2024-04-08T16:40:00Z", 1), ("2024-04-08T18:00:00Z", 1)] {
        let drawn = features(&over_utah(time));
        assert_eq!(drawn.map(|f| f.detail), [Detail::Hills, Detail::Billows], "{time}");
        assert_eq!(drawn.map(|f| f.eclipse.occluders), [occluders; 2], "{time}");
    }
    let wide = ViewRequest { purpose: Purpose::LINEAR, height: 40, ..over_utah("2024-04-08T16:40:00Z") };
    let middle = middle_of(&wide);
    assert_eq!(features(&middle).map(|f| f.eclipse.occluders), [0; 2]);
    let difference = difference_of_middle(&wide, &middle);
    println!("difference {difference:.1e}");
    assert!(difference < 4e-3, "{difference}");
}

/// Low over the Moon, from before the penumbra of 2022-11-08 into the umbra, every image has craters, and every pixel of ground the light that it has without
/// the eclipse, times the fraction of sunlight that passes the Earth.
#[test]
fn craters_have_the_light_that_the_eclipse_leaves() {
    let start = Instant::parse("2022-11-08T08:40:00Z").expect("a time");
    let (mut full, mut partial, mut dark, mut worst) = (0, 0, 0, 0.0_f32);
    // Before the eclipse every pixel of ground is 1, and one that is partly sky less.
    let fractions = |request: &ViewRequest| light(&ViewRequest { pixel_view: PixelView::Eclipse, ..request.clone() }, "");
    let is_ground: Vec<bool> = fractions(&low_over_the_moon("2022-11-08T08:40:00Z")).iter().map(|p| p[1] > 0.999).collect();
    for minutes in (0..=108).step_by(6) {
        let request = ViewRequest { time: start.plus_seconds(60.0 * f64::from(minutes)), ..low_over_the_moon("2022-11-08T08:40:00Z") };
        let features = draw_of(&scene(&request, ""), NaifId::MOON, BodyPart::Globe).features;
        assert_eq!(features.detail, Detail::Craters, "{minutes} min: {features:?}");
        let [seen, without_eclipse] = ["-planet-shine", "-planet-shine,-eclipse"].map(|effects| light(&request, effects));
        let left = fractions(&request);
        for k in (0..seen.len()).filter(|k| is_ground[*k]) {
            for c in 0..3 {
                let expected = without_eclipse[k][c] * left[k][c];
                // f32 rounds the small fractions of the umbra; the second term is a ten-thousandth of the full light.
                let error = (seen[k][c] - expected).abs() / (expected + 1e-2 * without_eclipse[k][c]).max(f32::MIN_POSITIVE);
                worst = larger(worst, error);
            }
            full += u32::from(left[k][1] > 0.999);
            partial += u32::from((0.01..0.99).contains(&left[k][1]));
            dark += u32::from(left[k][1] < 0.001);
        }
    }
    println!("{full} pixels in full light, {partial} in the penumbra, {dark} in the umbra; largest error {worst:.1e}");
    assert!(worst < 0.01, "{worst}");
    assert!(full > 500 && partial > 500 && dark > 500, "{full} {partial} {dark}");
}
