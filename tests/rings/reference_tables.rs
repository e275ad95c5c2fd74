//! Rings against tables made outside this program, against geometry, and in complete frames.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::probe::Prober;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::draw::{BodyPart, BodyShadow, RingShadow};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::scene::stated_errors;
use orrery::time::Instant;
use orrery::units::GOLDEN_ANGLE_RAD;
use serde_json::{Value, json};
use std::sync::LazyLock;

const SATURN: NaifId = NaifId(699);
const URANUS: NaifId = NaifId(799);
const TITAN: NaifId = NaifId(606);
const SINGLE_SAMPLE: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

/// The number of this name in the answer to a probe's question.
fn ask(precision: Precision, question: &Value, name: &str) -> f64 {
    static RENDERERS: LazyLock<[SoftwareRenderer; 2]> = LazyLock::new(|| {
        [Precision::F32, Precision::F64]
            .map(|precision| SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer"))
    });
    let renderer = &RENDERERS[usize::from(precision == Precision::F64)];
    let answer = Prober { session: &SESSION, renderer }.answer(&question.to_string()).unwrap_or_else(|e| panic!("{question}: {e}"));
    answer[name].as_f64().unwrap_or_else(|| panic!("{answer}"))
}

fn table() -> Value {
    serde_json::from_str(include_str!("../data/ring_shadow_public.json")).expect("JSON")
}

fn list<'a>(v: &'a Value, name: &str) -> &'a [Value] {
    v[name].as_array().unwrap_or_else(|| panic!("{name}"))
}

#[test]
fn light_through_the_ring_follows_the_closed_form() {
    // Measured: 3e-8.
    const MAX_ERROR: f64 = 1e-6;
    let table = table();
    let ring_step = |p: &Value| json!({"r_in": p["r_in"], "r_out": p["r_out"], "tau_normal": p["tau_normal"]});
    let profile: Vec<_> = list(&table, "ring_profile").iter().map(ring_step).collect();
    for precision in [Precision::F32, Precision::F64] {
        let mut in_shadow = 0;
        for row in list(&table, "surface_points") {
            let question = json!({"q": "ring-transmission", "profile": profile, "flattening": table["flattening"], "point": row["point"], "sun": row["sun"]});
            let expected = row["ring_transmission"].as_f64().expect("a number");
            let error = ask(precision, &question, "transmission") - expected;
            assert!(error.abs() < MAX_ERROR, "{precision:?} {question}: off by {error:e}");
            in_shadow += i32::from(expected < 0.99);
        }
        assert!(in_shadow > 10, "the table must contain shadows");
    }
}

/// Sunlight near the shadow of a single opaque ring edge, where errors are largest, against the sum over 20 000 points of a uniform Sun's
/// disc. Suns are low and high, edges across and along the light; the disc projects onto a small part of the ring. With the Sun at least 5
/// degrees high the error is below 0.7 %. It is largest for an edge along the light of a very low Sun, because there the edge curves by
/// more than the penumbra's width within the disc's projection.
#[test]
fn the_penumbra_agrees_with_a_sum_over_the_suns_disc() {
    const EDGE: f64 = 1.5;
    const POINTS: i32 = 20_000;
    let stated = stated_errors::of_ring_shadow(RingShadow::Penumbra).expect("a stated error").max_error;
    let profile = json!([{"r_in": EDGE, "r_out": 9.0, "tau_normal": 20.0}]);
    let (mut worst, mut worst_high, mut worst_of_point_sun) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (height_deg, sun_radius_deg) in
        [(0.2_f64, 0.03_f64), (0.7, 0.03), (2.0, 0.03), (5.0, 0.03), (26.7, 0.03), (26.7, 0.27), (60.0, 0.27)]
    {
        let (sine, cosine) = height_deg.to_radians().sin_cos();
        let tangent = sun_radius_deg.to_radians().tan();
        let sun = glam::DVec3::new(cosine, 0.0, sine);
        let up = glam::DVec3::new(-sine, 0.0, cosine);
        // Distance from the point to the plane along the light. It makes the projected disc's semi-axis along the light a fiftieth of the
        // planet's radius, or less.
        let distance_to_plane = (0.02 * sine / tangent).min(1.0);
        for azimuth_rad in [0.0_f64, 0.5, 0.8, 1.1, 1.4, 1.57] {
            let (across, along) = azimuth_rad.sin_cos();
            let half_penumbra = distance_to_plane * tangent * (along / sine).hypot(across);
            for offset in (-12..=12).map(|k| f64::from(k) / 10.0) {
                let plane_point = glam::DVec3::new(along, across, 0.0) * (EDGE + offset * half_penumbra);
                let point = plane_point - sun * distance_to_plane;
                let transmitted = |x: f64, y: f64| {
                    let towards = (sun + tangent * (x * glam::DVec3::Y + y * up)).normalize();
                    let radius = (point - towards * (point.z / towards.z)).truncate().length();
                    if radius >= EDGE { (-20.0 / towards.z).exp() } else { 1.0 }
                };
                // Uniform over the disc, in steps of the golden angle.
                let transmitted_at = |k: i32| {
                    let (y, x) = (f64::from(k) * GOLDEN_ANGLE_RAD).sin_cos();
                    let distance_on_disc = ((f64::from(k) + 0.5) / f64::from(POINTS)).sqrt();
                    transmitted(distance_on_disc * x, distance_on_disc * y)
                };
                let mean = (0..POINTS).map(transmitted_at).sum::<f64>() / f64::from(POINTS);
                let model_error = |model: &str| {
                    let question = json!({"q": "ring-transmission", "profile": profile, "point": point.to_array(), "sun": sun.to_array(),
                        "sun_angular_radius_deg": sun_radius_deg, "model": model});
                    (ask(Precision::F64, &question, "transmission") - mean).abs()
                };
                worst = larger(worst, model_error("penumbra"));
                worst_of_point_sun = larger(worst_of_point_sun, model_error("point-sun"));
                if height_deg >= 5.0 {
                    worst_high = larger(worst_high, model_error("penumbra"));
                }
            }
        }
    }
    println!("error at most {worst:.4} of the light, {worst_high:.4} under a high Sun, {worst_of_point_sun:.3} with a point Sun");
    assert!(worst < stated && worst_high < 0.007, "{worst} of the light, {worst_high} under a high Sun");
    assert!(worst_of_point_sun > 0.4, "a point Sun would pass: {worst_of_point_sun}");
}

/// Under a Sun exactly over a pole, the light through the ring and beside its edges is that of a Sun almost there.
#[test]
fn a_sun_over_a_pole_does_not_shine_through_the_ring() {
    for (radius, sun_deg, pole) in [(1.5, 0.5, 1.0), (1.5, 2.0, 1.0), (1.5, 2.0, -1.0), (2.0, 2.0, 1.0), (1.0, 5.0, -1.0)] {
        for precision in [Precision::F32, Precision::F64] {
            let light = [0.0, 1e-5].map(|x| {
                let profile = json!([{"r_in": 1.0, "r_out": 2.0, "tau_normal": 1.0}]);
                let question = json!({"q": "ring-transmission", "profile": profile, "point": [radius, 0.0, -0.1 * pole],
                    "sun": [x, 0.0, pole], "sun_angular_radius_deg": sun_deg, "model": "penumbra"});
                ask(precision, &question, "transmission")
            });
            assert!((light[0] - light[1]).abs() < 1e-3 && light[0] < 0.9, "{precision:?} {radius} {sun_deg} {pole}: {light:?}");
        }
    }
}

/// Locates the shadow edges of a sphere and of the oblate globe on the ring, for low and high Suns, in 40 directions from the antisolar one
/// to 90 degrees away. Their greatest distance is at most the stated error, and more than half of it.
#[test]
fn the_shadow_of_a_sphere_has_the_stated_error() {
    let (flattening, outer) = (0.098, 2.3);
    for height_deg in [0.5_f64, 4.0, 12.0, 26.7] {
        let (sine, cosine) = height_deg.to_radians().sin_cos();
        let is_hidden = |model: &str, radius: f64, angle: f64| {
            let point = [-radius * angle.cos(), radius * angle.sin(), 0.0];
            let question = json!({"q": "ring-shadow", "flattening": flattening, "point": point, "sun": [cosine, 0.0, sine],
                "sun_angular_radius_deg": 1e-3, "model": model});
            ask(Precision::F64, &question, "blocked") > 0.5
        };
        // Going outwards in each direction, there is one shadow edge.
        let edge = |model: &str, angle: f64| {
            let (mut from, mut to) = (1.01, outer);
            if !is_hidden(model, from, angle) || is_hidden(model, to, angle) {
                return if is_hidden(model, to, angle) { to } else { from };
            }
            while to - from > 1e-6 {
                let middle = 0.5 * (from + to);
                if is_hidden(model, middle, angle) { from = middle } else { to = middle }
            }
            from
        };
        // Distance perpendicular to the edge. The sphere's shadow is an ellipse with the semi-axes 1 and 1 / sine; (x, y) is normal to it.
        let edge_distance = |angle: f64| {
            let [x, y] = [angle.cos() * sine * sine, angle.sin()];
            let cos_to_normal = (x * angle.cos() + y * angle.sin()) / x.hypot(y);
            (edge("sphere", angle) - edge("uniform-disc", angle)).abs() * cos_to_normal
        };
        let worst = (0..40).map(|k| edge_distance(f64::from(k) * 0.0389)).fold(0.0, larger);
        let stated = stated_errors::sphere_shadow_offset(1.0 - flattening, sine, outer);
        println!("{height_deg} degrees: {worst:.4} of {stated:.4} radii");
        assert!(worst <= stated + 1e-5, "{height_deg} degrees: {worst} radii, {stated} stated");
        assert!(worst > 0.5 * stated, "{height_deg} degrees: {worst} radii is far less than the {stated} stated");
    }
}

#[test]
fn the_oblate_planet_hides_the_tabulated_fraction_of_the_sun() {
    let (table, stated) = (table(), stated_errors::of_body_shadow(BodyShadow::EllipsoidPenumbra).expect("a stated error").max_error);
    let mut sphere_error: f64 = 0.0;
    for row in list(&table, "ring_points") {
        let ask = |precision, model: &str| {
            let question = json!({"q": "ring-shadow", "flattening": table["flattening"], "point": row["point"], "sun": row["sun"],
                "sun_angular_radius_deg": row["sun_angular_radius_deg"], "model": model});
            ask(precision, &question, "blocked")
        };
        for (model, field) in [("uniform-disc", "blocked_uniform"), ("limb-darkened", "blocked_limb_darkened")] {
            let expected = row[field].as_f64().expect("a number");
            for precision in [Precision::F32, Precision::F64] {
                let error = ask(precision, model) - expected;
                assert!(error.abs() < stated, "{precision:?} {model} {row}: off by {error:e}");
            }
            sphere_error = sphere_error.max((ask(Precision::F32, "sphere") - expected).abs());
        }
    }
    assert!(sphere_error > 0.3, "a sphere under a point Sun would pass, too: {sphere_error}");
}

/// Behind a very flat planet a large Sun reaches past one side or both, although its centre is deep behind the planet: against the sum over 100 000 points of
/// a uniform Sun's disc.
#[test]
fn a_very_flat_planet_does_not_hide_all_of_a_sun_that_reaches_past_it() {
    const POINTS: i32 = 100_000;
    const SUN_RADIUS_DEG: f64 = 2.0;
    let stated = stated_errors::of_body_shadow(BodyShadow::EllipsoidPenumbra).expect("a stated error").max_error;
    let tangent = SUN_RADIUS_DEG.to_radians().tan();
    for (flattening, distance, sun) in [
        (0.7, 4.0, glam::DVec3::new(0.999, 0.0, 0.045)),
        (0.8, 3.0, glam::DVec3::new(0.9992, 0.0, 0.04)),
        (0.8, 4.0, glam::DVec3::new(0.98, 0.2, 0.001)),
    ] {
        let semi_axes = glam::DVec3::new(1.0, 1.0, 1.0 - flattening);
        let point = glam::DVec3::new(-distance, 0.0, 0.0);
        let towards = sun.normalize();
        let right = towards.cross(glam::DVec3::Z).normalize();
        let up = right.cross(towards);
        let hides = |k: i32| {
            let distance_on_disc = ((f64::from(k) + 0.5) / f64::from(POINTS)).sqrt();
            let (y, x) = (f64::from(k) * GOLDEN_ANGLE_RAD).sin_cos();
            // In the frame in which the planet is the unit sphere.
            let ray = (towards + tangent * distance_on_disc * (x * right + y * up)) / semi_axes;
            let from = point / semi_axes;
            from.dot(ray) < 0.0 && from.cross(ray).length_squared() < ray.length_squared()
        };
        let hidden = (0..POINTS).filter(|k| hides(*k)).count() as f64 / f64::from(POINTS);
        assert!(hidden < 0.99, "the Sun must reach past the planet: {hidden}");
        let question = json!({"q": "ring-shadow", "flattening": flattening, "point": point.to_array(), "sun": sun.to_array(),
            "sun_angular_radius_deg": SUN_RADIUS_DEG, "model": "uniform-disc"});
        for precision in [Precision::F32, Precision::F64] {
            let error = ask(precision, &question, "blocked") - hidden;
            assert!(error.abs() < stated, "{precision:?} {question}: off by {error:e} from {hidden}");
        }
    }
}

#[test]
fn a_narrow_ringlet_keeps_its_position_in_the_table() {
    let profile = json!([{"r_in": 1.5, "r_out": 1.6, "tau_normal": 0.5}, {"r_in": 1.55, "r_out": 1.55005, "tau_normal": 3.0}]);
    let transmission_at = |radius: f64| {
        let question = json!({"q": "ring-transmission", "profile": profile, "point": [radius - 0.5, 0.0, -0.5], "sun": [1.0, 0.0, 1.0]});
        ask(Precision::F64, &question, "transmission")
    };
    // Length of the light's path through the ring relative to its thickness, for a Sun 45 degrees high.
    let slant_factor = 2.0_f64.sqrt();
    for (radius, tau) in [(1.49999, 0.0), (1.5001, 0.5), (1.54999, 0.5), (1.550025, 3.0), (1.5501, 0.5), (1.5999, 0.5), (1.6001, 0.0)] {
        let (found, expected) = (transmission_at(radius), (-tau * slant_factor).exp());
        // Measured: 1.1e-8.
        assert!((found - expected).abs() < 1e-6, "{radius}: {found}, not {expected}");
    }
}

/// A pixel's footprint on the ring plane is divided into segments of about a sixteenth of a radius. When the number of segments changes,
/// the light must not jump.
#[test]
fn one_more_segment_of_a_pixels_footprint_changes_nothing_visible() {
    use orrery::session::sample_body_plan;
    const SIDE: u32 = 40;
    let key = "ring.sun1.bodyshadow-sphere.sphere".parse().expect("a key");
    let drawn = |half_side: f64| {
        let plan = sample_body_plan(SESSION.library(), &key, SIDE, half_side as f32).expect("a plan");
        SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr
    };
    let change = |a: f64, b: f64| {
        let (a, b) = (drawn(a), drawn(b));
        a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, larger)
    };
    for segments in [1.0, 2.0, 3.0, 5.0] {
        // Half the image's side, in radii, for which a pixel is so many segments long. The sample ring is seen from 25 degrees above its
        // plane.
        let half_side = segments / 16.0 * f64::from(SIDE) / 2.0 * 25f64.to_radians().sin();
        let jump = change(half_side * (1.0 - 1e-5), half_side * (1.0 + 1e-5));
        assert!(jump < 1e-3, "{segments} segments: {jump}");
        assert!(change(half_side, half_side * 1.02) > 5e-3, "the comparison must be able to fail");
    }
}

#[test]
fn invalid_queries_get_an_error_of_one_line() {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let prober_error =
        |question: Value| Prober { session: &SESSION, renderer: &renderer }.answer(&question.to_string()).expect_err("wrong").to_string();
    let with_geometry = |mut question: Value| {
        (question["point"], question["sun"]) = (json!([1.0, 0.0, 0.0]), json!([0.0, 0.0, 1.0]));
        question
    };
    let rings: Value = (0..5000).map(|k| json!({"r_in": 1e4 + f64::from(k), "r_out": 10_001 + k, "tau_normal": 1.0})).collect();
    for (question, message_part) in [
        (with_geometry(json!({"q": "ring-transmission"})), "profile"),
        (with_geometry(json!({"q": "ring-transmission", "body": "nowhere"})), "nowhere"),
        (with_geometry(json!({"q": "ring-transmission", "profile": [{"r_in": 2.0, "r_out": 1.0, "tau_normal": 1.0}]})), "r_out above it"),
        (with_geometry(json!({"q": "ring-transmission", "profile": rings})), "4096 or more intervals"),
        (with_geometry(json!({"q": "ring-shadow", "flattening": 1.5})), "flattening"),
        (json!({"q": "ring-shadow", "flattening": 0.1, "point": [1.5, 0, 0], "sun": [0, 0, 0]}), "sun"),
    ] {
        assert!(matches!(prober_error(question), error if error.contains(message_part) && !error.contains('\n')), "{message_part}");
    }
}

fn request(target: NaifId, time: &str, distance_radii: f64, size: u32, effects: &str) -> ViewRequest {
    ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
        width: size,
        height: size,
        exposure: ExposureRequest::Stops(5.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        fov_deg: Some(5.0),
        ..ViewRequest::of(target, Instant::parse(time).expect("a time"))
    }
}

/// The scene, and the linear pixels drawn from it.
fn pixels(request: &ViewRequest) -> (Scene, Vec<[f32; 4]>) {
    let drawn = SESSION.draw(request, SINGLE_SAMPLE, FrameImages::DisplayAndHdr).expect("drawn");
    let hdr = drawn.frame.hdr.clone();
    assert_eq!(hdr.len(), (request.width * request.height) as usize);
    (drawn.scene, hdr)
}

/// Green light that the rings add: the mean pixel of the image with rings minus that of the image without.
fn ring_light(target: NaifId, time: &str, distance_radii: f64, size: u32) -> f64 {
    let sum = |effects: &str| {
        let (_, hdr) = pixels(&request(target, time, distance_radii, size, effects));
        hdr.iter().map(|p| f64::from(p[1])).sum::<f64>() / f64::from(size * size)
    };
    sum("+rings,-ring-shadow,-points") - sum("-rings,-ring-shadow,-points")
}

#[test]
fn narrow_rings_keep_their_light_at_any_size() {
    // Most of Uranus' rings are a few kilometres wide. The outermost dense one is drawn 20 to 600 pixels across. Pixels outside the rings
    // are equal in both images and cancel.
    let reference = ring_light(URANUS, "2030-01-01T00:00:00Z", 60.0, 800);
    assert!(reference > 0.0);
    for size in [25, 50, 100, 250] {
        let light = ring_light(URANUS, "2030-01-01T00:00:00Z", 60.0, size);
        assert!((light / reference - 1.0).abs() < 0.04, "{size} px: {light:e} against {reference:e}");
    }
}

#[test]
fn edge_on_and_at_the_crossings_every_pixel_is_finite_and_no_brighter_than_sunlight() {
    // The Earth crosses the ring plane on 2025-03-23, the Sun on 2025-05-06.
    let times = ["2017-05-17T00:00:00Z", "2025-03-23T17:46:00Z", "2025-03-23T18:30:00Z", "2025-05-06T14:15:00Z", "2025-05-06T20:00:00Z"];
    for time in times {
        for (size, distance_radii) in [(300, 70.0), (64, 90.0)] {
            let (scene, hdr) = pixels(&request(SATURN, time, distance_radii, size, "+rings"));
            assert!(scene.draws.iter().any(|d| d.part == BodyPart::RingInFront), "{time}");
            // At 9 au and beyond, sunlight is at most 0.0125 of that at 1 au; Enceladus, the brightest body, reflects 1.4 times as much as
            // a white plane.
            let worst = hdr.iter().flat_map(|p| p[..3].iter().copied()).fold(0.0, f32::max);
            assert!(hdr.iter().all(|p| p.iter().all(|v| v.is_finite() && *v >= 0.0)), "{time} {size}");
            assert!(worst < 0.0125 * 1.5 && worst > 0.001, "{time} {size}: {worst}");
        }
    }
}

#[test]
fn the_side_away_from_the_sun_is_darker() {
    // Between the Earth's crossing and the Sun's, the Earth sees the unlit side.
    let light_at = |time: &str| ring_light(SATURN, time, 70.0, 200);
    let (unlit, lit) = (light_at("2025-04-20T00:00:00Z"), light_at("2017-05-17T00:00:00Z"));
    assert!(unlit < 0.05 * lit && lit > 0.0, "unlit {unlit:e}, lit {lit:e}");
}

#[test]
fn rings_switched_off_are_not_drawn_and_rings_below_the_horizon_change_no_bit() {
    let (scene_without, hdr) = pixels(&request(SATURN, "2017-05-17T00:00:00Z", 70.0, 120, "-rings,-ring-shadow,-atmosphere"));
    assert!(
        scene_without
            .draws
            .iter()
            .all(|d| d.part == BodyPart::Globe && d.features.ring_shadow == RingShadow::None && d.uniforms.ring.table.is_none())
    );
    let with_rings = request(SATURN, "2017-05-17T00:00:00Z", 70.0, 120, "-ring-shadow,-atmosphere");
    let (scene, hdr_with) = pixels(&with_rings);
    let parts: Vec<_> = scene.draws.iter().filter(|d| d.body == SATURN).map(|d| d.part).collect();
    assert_eq!(parts, [BodyPart::RingBehind, BodyPart::Globe, BodyPart::RingInFront]);
    assert_ne!(hdr, hdr_with);
    // From the ground near the pole the rings are below the horizon.
    let ground = |effects: &str| {
        let standing = ViewRequest {
            target: Some(TITAN),
            position: Position::Ground { body: SATURN, latitude_deg: 88.0, longitude_deg: 10.0, height_km: 1.0 },
            fov_deg: Some(90.0),
            ..request(SATURN, "2017-05-17T00:00:00Z", 70.0, 64, effects)
        };
        pixels(&standing).1
    };
    assert_eq!(ground("-rings,-ring-shadow,-atmosphere"), ground("+rings,-ring-shadow,-atmosphere"));
}

#[test]
fn ring_shadows_are_decided_by_the_light_they_block() {
    let features = |target, time: &str, size| {
        let scene = SESSION.scene(&request(target, time, 70.0, size, "")).expect("a scene");
        let features_of = |part| scene.draws.iter().find(|d| d.body == target && d.part == part).map(|d| d.features);
        (features_of(BodyPart::Globe).expect("a globe"), features_of(BodyPart::RingInFront))
    };
    let (globe, ring) = features(SATURN, "2017-05-17T00:00:00Z", 400);
    assert_eq!((globe.ring_shadow, ring.map(|f| f.body_shadow)), (RingShadow::PointSun, Some(BodyShadow::EllipsoidPenumbra)));
    // Near the Sun's crossing of the ring plane the penumbra is wide.
    assert_eq!(features(SATURN, "2025-05-01T00:00:00Z", 400).0.ring_shadow, RingShadow::Penumbra);
    // Under a high Sun the shadow of Uranus' rings misses the globe.
    assert_eq!(features(URANUS, "2030-01-01T00:00:00Z", 400).0.ring_shadow, RingShadow::None);
}

/// Green radiance of Saturn's rings at some radii, on the darker of the two ansae. The camera is at this phase angle on the arc from the
/// Sun's side over the north pole.
fn ansa_radiance(phase_angle_deg: f64, radii_km: &[f64]) -> Vec<f64> {
    const SIZE: u32 = 161;
    const FOV_DEG: f64 = 6.0;
    let time = "2013-07-19T21:27:00Z";
    let from_sun = ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(100.0) },
        ..request(SATURN, time, 100.0, 8, "-points")
    };
    let placement = SESSION.scene(&from_sun).expect("a scene").body(SATURN).expect("Saturn").placement;
    let (sun, pole) = (-placement.centre_km.normalize(), placement.body_from_icrf.transpose() * glam::DVec3::Z);
    let poleward = (pole - sun * pole.dot(sun)).normalize();
    let distance_km = placement.centre_km.length();
    let direction = sun * phase_angle_deg.to_radians().cos() + poleward * phase_angle_deg.to_radians().sin();
    let axes = orrery::scene::request::Axes::Icrf;
    let seen = ViewRequest {
        position: Position::Offset { body: SATURN, offset_km: direction * distance_km, axes },
        fov_deg: Some(FOV_DEG),
        exposure: ExposureRequest::Stops(0.0),
        ..request(SATURN, time, 100.0, SIZE, "-points,-glow,-planet-shine,-body-shadow,+rings")
    };
    let (_, hdr) = pixels(&seen);
    let pixel_tangent = 2.0 * (0.5 * FOV_DEG).to_radians().tan() / f64::from(SIZE);
    let middle = f64::from(SIZE / 2);
    let green_at = |x: f64| f64::from(hdr[(SIZE / 2 * SIZE + x.round() as u32) as usize][1]);
    radii_km.iter().map(|r| r / distance_km / pixel_tangent).map(|px| green_at(middle - px).min(green_at(middle + px))).collect()
}

/// As in Cassini's image of 2013-07-19, the E and G rings are bright against the Sun. From the Sun's side they are fainter: 86 and 67 times
/// (measured).
#[test]
fn dusty_rings_are_bright_only_in_forward_scattering() {
    // E, G, the gap between F and G, and B.
    let radii_km = [239_000.0, 168_500.0, 152_000.0, 110_000.0];
    let ([e_back, g_back, _, b_back], [e, g, between, b]) = (
        <[f64; 4]>::try_from(ansa_radiance(5.0, &radii_km)).expect("four"),
        <[f64; 4]>::try_from(ansa_radiance(175.0, &radii_km)).expect("four"),
    );
    println!("E {e_back:.2e} {e:.2e}, G {g_back:.2e} {g:.2e}, B {b_back:.2e} {b:.2e}");
    assert!(e > 60.0 * e_back, "E: {e_back} becomes {e}");
    assert!(g > 45.0 * g_back && g > 1e-7, "G: {g_back} becomes {g}");
    assert!(between < 0.02 * e, "nothing lies between F and G: {between}");
    // The B ring consists of large bodies: it is brighter from the Sun's side.
    assert!(b < 0.1 * b_back, "B: {b_back} becomes {b}");
}

/// From the Sun's side to just before the camera crosses the ring plane: no jump, and light is always positive.
#[test]
fn a_dusty_ring_changes_smoothly_with_the_phase_angle() {
    let all: Vec<f64> = (0..=38).map(|k| ansa_radiance(f64::from(4 * k) + 1.0, &[239_000.0])[0]).collect();
    for (k, pair) in all.windows(2).enumerate() {
        assert!(pair[0] > 0.0 && (0.5..2.6).contains(&(pair[1] / pair[0])), "at {} degrees: {pair:?}", 4 * k);
    }
    assert!(all[38] > 3.0 * all[20], "it brightens against the Sun: {} and {}", all[20], all[38]);
}

/// The profile against published edges (km) and mean normal optical depths. Edges of B and of the Maxwell gap: PDS Ring-Moon Systems Node
/// (https://pds-rings.seti.org/saturn/saturn_tables.html), which has the inner edge of C at 74,491 km; the catalog's profile of C begins at Voyager's 74,658
/// km. Edges of A: French et al. 1993 (Icarus 103, 163). Gaps in A and mean depths: Colwell et al. 2009, rounded from memory.
#[test]
fn saturns_profile_has_the_published_edges_gaps_and_depths() {
    let catalog = orrery::catalog::Catalog::embedded();
    let rings = &catalog.body(SATURN).expect("Saturn").rings;
    let tau = |r: f64| rings.iter().rfind(|x| x.inner_km <= r && r < x.outer_km).map_or(0.0, |x| x.tau_normal);
    let mean = |from: f64, to: f64| (0..4000).map(|k| tau(from + (to - from) * (f64::from(k) + 0.5) / 4000.0)).sum::<f64>() / 4000.0;
    for (name, from, to, lowest, highest) in [
        ("C", 74_658.0, 91_975.0, 0.08, 0.2),
        ("B1", 92_000.0, 99_000.0, 0.9, 1.5),
        ("B2", 99_000.0, 104_500.0, 1.5, 2.6),
        ("B3", 104_500.0, 110_000.0, 3.5, 5.0),
        ("B4", 110_000.0, 117_500.0, 1.7, 3.0),
        ("Cassini Division", 117_932.0, 122_050.0, 0.08, 0.2),
        ("A", 122_050.0, 136_775.0, 0.4, 0.7),
        ("E about Enceladus", 230_000.0, 245_000.0, 0.5e-5, 2e-5),
        ("G", 166_000.0, 175_000.0, 0.3e-6, 2e-6),
    ] {
        let depth = mean(from, to);
        assert!((lowest..highest).contains(&depth), "{name}: {depth}");
    }
    for (name, middle_km, width_km) in [("Encke", 133_589.0, 322.0), ("Keeler", 136_505.0, 34.0), ("Maxwell", 87_476.5, 267.0)] {
        let thin_places = (-20..=20).filter(|k| tau(middle_km + f64::from(*k) / 40.0 * width_km) < 0.06).count();
        assert!(thin_places > 25, "{name} gap: {thin_places} of 41 places");
        assert!(tau(middle_km - width_km) > 0.06 && tau(middle_km + width_km) > 0.06, "{name} gap is as wide as published");
    }
    for (name, edge, falls_outwards) in [("A's outer", 136_775.0, true), ("B's outer", 117_570.0, true), ("B's inner", 91_975.0, false)] {
        let (inside, outside) = (mean(edge - 150.0, edge - 50.0), mean(edge + 50.0, edge + 150.0));
        assert!((inside > 2.0 * outside) == falls_outwards && (inside / outside - 1.0).abs() > 0.5, "{name} edge: {inside}, {outside}");
    }
    // The catalog distinguishes dusty from dust-free rings.
    assert!(
        rings.iter().filter(|r| r.dust_fraction > 0.9).count() > 80
            && rings.iter().any(|r| r.name.starts_with('B') && r.dust_fraction == 0.0)
    );
}
