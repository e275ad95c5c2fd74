//! Effects switched by hand in rendered scenes: each changes only its own pixels, and an effect without anything to draw changes nothing.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{Air, BodyPart, Eclipse};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use orrery::time::Instant;
use std::sync::Arc;

const SIDE: u32 = 96;
const ECLIPSE_DAY: &str = "2024-04-08T18:17:16Z";
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 4 };

type Pixels = Vec<[f32; 4]>;

fn request(target: i32, time: &str, position: Position) -> ViewRequest {
    ViewRequest { position, width: SIDE, height: SIDE, ..ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time")) }
}

fn over(target: i32, time: &str, distance_radii: f64, towards: Option<i32>) -> ViewRequest {
    request(target, time, Position::AboveTarget { towards: towards.map(NaifId), distance_radii: Some(distance_radii) })
}

fn pixels(scene: &Scene) -> Pixels {
    let plan = plan::plan(scene, &*SESSION, SAMPLING).expect("a plan");
    SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr
}

/// The same view with two sets of effects at the same exposure: the scene of the first, and the pixels of both.
fn with_and_without(request: &ViewRequest, with: &str, without: &str, stops: f64) -> (Scene, Pixels, Pixels) {
    let scene_with = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        SESSION.scene(&ViewRequest { effects, exposure: ExposureRequest::Stops(stops), ..request.clone() }).expect("a scene")
    };
    let (scene_a, scene_b) = (scene_with(with), scene_with(without));
    let images = (pixels(&scene_a), pixels(&scene_b));
    (scene_a, images.0, images.1)
}

/// Cosine between the surface normal at a pixel's centre and a direction in the body's axes; `None` outside the disc.
fn cosine(scene: &Scene, body: i32, pixel: usize, direction: glam::DVec3) -> Option<f64> {
    let body = scene.body(NaifId(body)).expect("in the catalog");
    let middle = glam::DVec2::new((pixel as u32 % SIDE) as f64 + 0.5, (pixel as u32 / SIDE) as f64 + 0.5);
    let hit = scene.camera.surface_under_pixel(&body.placement, middle)?;
    Some((hit / body.placement.radii_km).normalize().dot(direction))
}

/// Direction from the body's centre to the Sun, body axes.
fn sunward(scene: &Scene, body: i32) -> glam::DVec3 {
    let p = scene.body(NaifId(body)).expect("in the catalog").sub_solar.expect("lit");
    let (lat, lon) = (p.lat_centric_deg.to_radians(), p.lon_east_deg.to_radians());
    glam::DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
}

/// Indices of pixels at which two images differ by any bit.
fn changed_pixels(a: &Pixels, b: &Pixels) -> Vec<usize> {
    (0..a.len()).filter(|k| a[*k].map(f32::to_bits) != b[*k].map(f32::to_bits)).collect()
}

/// Asserts that an effect of the Earth changes at least one pixel, and only pixels for which the cosine of the Sun's zenith angle is in the
/// range `sun_cosines`. `others`: settings of other effects.
fn assert_changes_only_between(request: &ViewRequest, others: &str, effect: &str, stops: f64, sun_cosines: std::ops::RangeInclusive<f64>) {
    let (scene, with, without) = with_and_without(request, others, &format!("{others},-{effect}"), stops);
    let towards = sunward(&scene, 399);
    let changed_places = changed_pixels(&with, &without);
    assert!(!changed_places.is_empty(), "{effect} changes nothing");
    for k in changed_places {
        // The centre of a pixel on the limb may lie outside the disc: then the Sun's angle is unknown.
        let Some(cosine) = cosine(&scene, 399, k, towards) else { continue };
        assert!(
            sun_cosines.contains(&cosine),
            "{effect} changes pixel {},{}, where the Sun's cosine is {cosine}",
            k as u32 % SIDE,
            k as u32 / SIDE
        );
    }
    // The disc includes the changed pixel or one of its eight neighbours.
    let is_near_disc = |k: usize| {
        (0..9).any(|n| {
            cosine(&scene, 399, (k + n % 3 + (n / 3) * SIDE as usize).saturating_sub(1 + SIDE as usize).min(with.len() - 1), towards)
                .is_some()
        })
    };
    for k in changed_pixels(&with, &without) {
        assert!(is_near_disc(k), "{effect} changes pixel {k} beside the disc");
    }
}

#[test]
fn ground_effects_change_only_their_side_of_the_earth() {
    // A quarter Earth shows day and night.
    let quarter = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    let other_effects_off = "-atmosphere,-clouds,-cloud-shadow,-eclipse,-planet-shine";
    assert_changes_only_between(&quarter, &format!("{other_effects_off},-normal"), "specular", 0.0, -0.02..=1.0);
    // The highest relief matters up to 2.9 degrees beyond the terminator.
    assert_changes_only_between(&quarter, &format!("{other_effects_off},-specular"), "normal", 0.0, -0.06..=1.0);
    assert_changes_only_between(
        &quarter,
        "-atmosphere,-clouds,-eclipse,-planet-shine,-normal,+cloud-shadow",
        "cloud-shadow",
        0.0,
        -0.02..=1.0,
    );
    assert_changes_only_between(&quarter, &format!("{other_effects_off},-normal,-specular"), "albedo", 0.0, -0.02..=1.0);
    // City lights at a night exposure: they switch on during twilight.
    assert_changes_only_between(&quarter, &format!("{other_effects_off},-normal,+night"), "night", 14.0, -1.0..=0.06);
}

#[test]
fn clouds_and_air_change_nothing_beyond_their_shells() {
    let earth = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    for (others, effect, shell_radii) in [("-atmosphere", "clouds", 1.01), ("-clouds", "atmosphere", 1.04)] {
        let (scene, with, without) = with_and_without(&earth, others, &format!("{others},-{effect}"), 0.0);
        let body = scene.body(NaifId::EARTH).expect("the Earth");
        let shell_outline = orrery::scene::camera::Placement { radii_km: body.placement.radii_km * shell_radii, ..body.placement };
        let places = changed_pixels(&with, &without);
        assert!(places.len() > 100, "{effect}: {} pixels", places.len());
        for k in places {
            let (x, y) = ((k as u32 % SIDE) as f64 + 0.5, (k as u32 / SIDE) as f64 + 0.5);
            let reached = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (0.0, 0.0)]
                .iter()
                .any(|(dx, dy)| scene.camera.surface_under_pixel(&shell_outline, glam::DVec2::new(x + dx, y + dy)).is_some());
            assert!(reached, "{effect} changes {x},{y}, outside of its shell");
        }
    }
}

/// The Earth is above the horizon on only one side of the Moon; on the sunlit part of that side earthshine is negligible against sunlight.
#[test]
fn earthshine_falls_where_the_earth_is_up() {
    for view in [over(301, "2024-05-09T20:00:00Z", 8.0, Some(10)), over(301, "2024-05-09T20:00:00Z", 8.0, Some(399))] {
        let (scene, with, without) = with_and_without(&view, "+planet-shine,-normal", "-planet-shine,-normal", 0.0);
        let moon = scene.body(NaifId::MOON).expect("the Moon");
        let earth = scene.body(NaifId::EARTH).expect("the Earth");
        let towards = (moon.placement.body_from_icrf * (earth.placement.centre_km - moon.placement.centre_km)).normalize();
        for k in changed_pixels(&with, &without) {
            let Some(earth_cosine) = cosine(&scene, 301, k, towards) else { continue };
            // Other planets may light the Moon too, by less than the tolerance.
            assert!(earth_cosine > -0.02 || (with[k][1] - without[k][1]).abs() < 1e-7, "the Earth's cosine is {earth_cosine}");
            let cos_sun = cosine(&scene, 301, k, sunward(&scene, 301)).unwrap_or(0.0);
            assert!(cos_sun < 0.1 || with[k][1] < without[k][1] * 1.002, "{} by day", with[k][1] / without[k][1]);
        }
    }
    let (_, with, without) = with_and_without(&over(301, "2024-05-09T20:00:00Z", 8.0, Some(399)), "+planet-shine", "-planet-shine", 0.0);
    assert!(changed_pixels(&with, &without).len() > 500, "the dark side glows");
}

/// The full Earth shines on the Moon with V = -3.99 + 5 log10(384400 km / 1 au) = -16.94 (Mallama and Hilton 2018, Astronomy and Computing
/// 25, 10), 9.82 magnitudes fainter than the Sun's -26.76: 1.18e-4 of its light. On 9 May 2024 the Earth's phase angle is 23 degrees, which
/// reduces this by 13 to 35 % (factors of 0.87 by Lambert's law to 0.65 measured). Seen along the direction of the light, the ground
/// reflects it as it reflects sunlight at full Moon.
#[test]
fn earthshine_is_a_ten_thousandth_of_sunlight_on_the_moon() {
    for distance_radii in [221.0, 60.0] {
        let middle_light = |time: &str| {
            let from_earth = Position::Offset {
                body: NaifId::MOON,
                offset_km: glam::DVec3::new(distance_radii * 1737.4, 0.0, 0.0),
                axes: Axes::BodyFixed,
            };
            let effects = EffectOverrides::parse("+planet-shine,-normal").expect("effects");
            let base = request(301, time, from_earth);
            let exposure = ExposureRequest::Stops(0.0);
            let moon = ViewRequest { fov_deg: Some(100.0 / distance_radii), effects, exposure, width: 65, height: 65, ..base };
            let scene = SESSION.scene(&moon).expect("a scene");
            f64::from(pixels(&scene)[32 * 65 + 32][1])
        };
        let ratio = middle_light("2024-05-09T20:00:00Z") / middle_light("2024-05-23T13:53:00Z");
        assert!((0.6e-4..1.15e-4).contains(&ratio), "{ratio:e} from {distance_radii} radii");
    }
}

/// Occluders that do not reach the Sun's disc leave the light unchanged to the last bit.
#[test]
fn occluders_out_of_reach_cause_no_eclipse() {
    let earth = over(399, ECLIPSE_DAY, 3.0, None);
    let scene = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        SESSION.scene(&ViewRequest { effects, exposure: ExposureRequest::Stops(0.0), ..earth.clone() }).expect("a scene")
    };
    let near = scene("-atmosphere");
    let mut far = near.clone();
    let mut none = near.clone();
    let mut moved = 0;
    for (draw, plain) in far.draws.iter_mut().zip(&mut none.draws) {
        for place in &mut draw.uniforms.eclipse.occluder_positions {
            place.x += 1000.0;
            moved += 1;
        }
        plain.features.eclipse = Eclipse::default();
    }
    assert!(moved > 0, "the Moon must be among the occluders");
    let (near, far, none) = (pixels(&near), pixels(&far), pixels(&none));
    assert!(changed_pixels(&far, &none).is_empty(), "{} pixels", changed_pixels(&far, &none).len());
    assert!(changed_pixels(&near, &none).len() > 100, "the true eclipse must be visible");
}

/// Air of zero density equals no air, but for the last bits: the shader still evaluates the exponential of an optical depth of 0.
#[test]
fn air_of_zero_density_equals_no_air() {
    let earth = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    let effects = EffectOverrides::parse("-clouds,-cloud-shadow").expect("effects");
    let air = SESSION.scene(&ViewRequest { effects, exposure: ExposureRequest::Stops(0.0), ..earth }).expect("a scene");
    let (mut thin, mut none) = (air.clone(), air.clone());
    for draw in &mut thin.draws {
        let a = &mut draw.uniforms.air;
        for coefficient in [
            &mut a.rayleigh_scattering,
            &mut a.rayleigh_extinction,
            &mut a.mie_scattering,
            &mut a.mie_extinction,
            &mut a.absorption_extinction,
        ] {
            *coefficient = glam::Vec3::ZERO;
        }
        a.optical_depth_above_ground = Default::default();
        a.multi_scatter = Arc::new(a.multi_scatter.iter().map(|_| glam::Vec4::ZERO).collect());
    }
    none.draws.retain(|d| d.part != BodyPart::Sky);
    none.draws.iter_mut().for_each(|d| d.features.air = Air::default());
    let (air, thin, none) = (pixels(&air), pixels(&thin), pixels(&none));
    let greatest_difference =
        |a: &Pixels, b: &Pixels| a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, larger);
    assert!(greatest_difference(&thin, &none) < 2e-6, "{}", greatest_difference(&thin, &none));
    assert!(greatest_difference(&air, &none) > 0.05, "air of true density must be visible");
}

/// From above the pole, a narrow field of view contains only the globe, inside the rings.
#[test]
fn rings_outside_the_frame_change_nothing() {
    let time = "2017-05-17T00:00:00Z";
    let over_pole = Position::Offset { body: NaifId(699), offset_km: glam::DVec3::new(0.0, 0.0, 4.0 * 60_268.0), axes: Axes::BodyFixed };
    let view = |fov_deg: f64| ViewRequest { fov_deg: Some(fov_deg), look: Look::Target, ..request(699, time, over_pole) };
    let shadows = "-ring-shadow,-body-shadow,-planet-shine";
    let (_, with, without) = with_and_without(&view(18.0), shadows, &format!("{shadows},-rings"), 6.0);
    assert!(changed_pixels(&with, &without).is_empty(), "{} pixels", changed_pixels(&with, &without).len());
    let (_, with, without) = with_and_without(&view(60.0), shadows, &format!("{shadows},-rings"), 6.0);
    assert!(changed_pixels(&with, &without).len() > 500, "a wide field of view must show the rings");
}

/// Glare and corona are switched as the Sun's own effects, too.
#[test]
fn light_around_the_sun_is_switched_for_the_sun_alone() {
    let request = request(10, "2024-04-08T18:42:00Z", Position::Centre(NaifId::EARTH));
    let lights = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        let scene = SESSION.scene(&ViewRequest { effects, ..request.clone() }).expect("a scene");
        (scene.glare.is_some(), scene.corona.is_some())
    };
    assert_eq!(lights("sun:-glow,sun:-corona"), (false, false));
    assert_eq!(lights("sun:+glow,sun:+corona"), (true, true));
    assert_eq!(lights("+glow,-corona,sun:-glow,sun:+corona"), (false, true));
    assert_eq!(lights("+glow,+corona,moon:-glow,moon:-corona"), (true, true));
}
