//! Eclipses as the emitted modules compute them, against tables made outside this program (tests/data/README.md), geometry and observations.

use crate::support::{folds::larger, session::SESSION, sweep};
use glam::{DVec3, Vec4};
use orrery::FrameImages;
use orrery::catalog::{NaifId, Photometry};
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::image::{MapDecoding, SharedTexture};
use orrery::probe::Prober;
use orrery::probe::sunlight::{OccludedSun, sunlight_from_uniforms};
use orrery::render::plan::{PlanError, ResourceProvider, SamplingQuality, plan};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::draw::{DrawFeatures, Eclipse, EclipseModel, EclipseUniforms};
use orrery::scene::eclipse::{EclipseModelChoice, Receiver};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, Quality, ViewRequest};
use orrery::scene::stated_errors;
use orrery::session::{Session, Sources};
use orrery::shader::Layout;
use orrery::shader::ModuleId;
use orrery::time::Instant;
use orrery::units::{GOLDEN_ANGLE_RAD, SPEED_OF_LIGHT_KM_S, luminance};
use serde_json::{Value, json};
use std::sync::LazyLock;

fn session_with(catalogs: std::path::PathBuf) -> Session {
    let cache = crate::support::scratch::folder("eclipse-round");
    Session::open(&Sources { cache: Some(cache), catalogs: Some(catalogs), ..Sources::default() }, |_| {}).expect("opens")
}

static F32_RENDERER: LazyLock<SoftwareRenderer> = LazyLock::new(|| renderer(Precision::F32));
static F64_RENDERER: LazyLock<SoftwareRenderer> = LazyLock::new(|| renderer(Precision::F64));

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

fn f32_prober() -> Prober<'static> {
    Prober { session: &SESSION, renderer: &F32_RENDERER }
}
fn f64_prober() -> Prober<'static> {
    Prober { session: &SESSION, renderer: &F64_RENDERER }
}

fn table(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}
fn number(v: &Value, name: &str) -> f64 {
    v[name].as_f64().unwrap_or_else(|| panic!("{name} in {v}"))
}
fn list<'a>(v: &'a Value, name: &str) -> &'a [Value] {
    v[name].as_array().unwrap_or_else(|| panic!("{name}"))
}

/// A number from the answer to a probe question.
fn ask(prober: &Prober<'_>, question: &Value, field: &str) -> f64 {
    number(&prober.answer(&question.to_string()).unwrap_or_else(|e| panic!("{question}: {e}")), field)
}

fn instant(text: &str) -> Instant {
    Instant::parse(text).expect(text)
}

#[test]
fn light_blocked_by_circles_and_ellipses_agrees_with_forty_digit_integrals() {
    let table = table(include_str!("../data/limb_darkened_overlap_public.json"));
    // Errors measured in f32 and f64: at most 5e-7 for circles, 2.1e-4 for ellipses.
    let stated = stated_errors::of_eclipse(EclipseModel::LimbDarkened).expect("a stated error").max_error;
    for (prober, max_circle_error, max_ellipse_error) in [(f32_prober(), 2e-6, stated), (f64_prober(), 1e-6, stated)] {
        for model in ["limb-darkened", "uniform-disc"] {
            let expected_field = if model == "uniform-disc" { "blocked_uniform" } else { "blocked_ld" };
            for row in list(&table, "circles") {
                let question = json!({"q": "disc-overlap", "k": row["k"], "d": row["d"], "u1": 0.4, "u2": 0.26, "model": model});
                let error = ask(&prober, &question, "blocked") - number(row, expected_field);
                assert!(error.abs() < max_circle_error, "{question}: off by {error:e}");
            }
            for row in list(&table, "ellipses") {
                let mut question = json!({"q": "disc-overlap", "u1": 0.4, "u2": 0.26, "model": model});
                for field in ["semi_major", "semi_minor", "centre_distance", "offset_angle_from_major_axis_deg"] {
                    question[field] = row[field].clone();
                }
                let error = ask(&prober, &question, "blocked") - number(row, expected_field);
                assert!(error.abs() < max_ellipse_error, "{question}: off by {error:e}");
            }
        }
    }
}

#[test]
fn the_linear_model_interpolates_between_the_contacts() {
    let prober = f32_prober();
    // `k`: radius of the occluder, `d`: distance of its centre, both in radii of the Sun.
    let blocked = |k: f64, d: f64, model: &str| ask(&prober, &json!({"q": "disc-overlap", "k": k, "d": d, "model": model}), "blocked");
    for k in [0.3_f64, 1.0, 4.0] {
        let (outer_contact, inner_contact) = (1.0 + k, (1.0 - k).abs());
        assert_eq!(blocked(k, outer_contact, "linear"), 0.0);
        let greatest = f64::min(k * k, 1.0);
        assert!((blocked(k, inner_contact, "linear") - greatest).abs() < 1e-6);
        assert!((blocked(k, 0.5 * (outer_contact + inner_contact), "linear") - 0.5 * greatest).abs() < 1e-6);
    }
    let error = blocked(1.0, 0.5, "linear") - blocked(1.0, 0.5, "uniform-disc");
    assert!((0.02..0.12).contains(&error), "between the contacts `linear` differs from the area by {error}");
}

/// The simpler models against the limb-darkened disc, in blue, where darkening is strongest: the error is at most the one that `explain` states,
/// and somewhere nearly as large.
#[test]
fn simpler_disc_models_have_their_stated_errors() {
    let prober = f32_prober();
    let blocked = |k: f64, d: f64, model: &str| {
        ask(&prober, &json!({"q": "disc-overlap", "k": k, "d": d, "u1": 0.625, "u2": 0.18, "model": model}), "blocked")
    };
    for model in [EclipseModel::Linear, EclipseModel::UniformDisc] {
        let stated = stated_errors::of_eclipse(model).expect("a stated error");
        let mut worst = 0.0f64;
        for k in [0.1, 0.5, 0.7, 0.76, 0.8, 0.9, 1.0, 1.02, 1.05, 1.1, 1.5, 4.0, 20.0] {
            // From the outer contact inwards: to concentric discs if the occluder is the smaller one, otherwise to the inner contact.
            for step in 0..40 {
                let d = (1.0 + k) * (1.0 - f64::from(step) / 40.0 * f64::min(2.0 / (1.0 + k), 1.0));
                worst = larger(worst, (blocked(k, d, stated.name) - blocked(k, d, "limb-darkened")).abs());
            }
        }
        println!("{}: {worst:.4}", stated.name);
        assert!(worst < stated.max_error && worst > 0.8 * stated.max_error, "{}: error {worst}, stated {}", stated.name, stated.max_error);
    }
}

#[test]
fn solar_eclipses_on_the_ground_agree_with_de440() {
    let table = table(include_str!("../data/eclipses_public.json"));
    let mut partial_samples = 0;
    for eclipse in list(&table, "eclipses").iter().filter(|e| e["kind"] == "solar") {
        for point in list(eclipse, "sample_points") {
            for (sample, expected) in list(eclipse, "sample_times").iter().zip(list(point, "at")) {
                let time = format!("{}Z", sample["utc"].as_str().expect("a time"));
                for (model, hidden_field) in [("limb-darkened", "obscured_flux_limb_darkened"), ("uniform-disc", "obscured_fraction")] {
                    let question = json!({"q": "sunlight", "body": "earth", "time": time, "lat": point["lat_deg"],
                        "lon": point["lon_east_deg"], "model": model});
                    let hidden = number(expected, hidden_field);
                    let error = ask(&f32_prober(), &question, "fraction") - (1.0 - hidden);
                    // Measured 2.1e-5. A shadow one second late would give an error of 3e-4; so would neglecting the Earth's aberration.
                    assert!(error.abs() < 5e-5, "{question}: off by {error:e}");
                    partial_samples += usize::from((0.01..0.99).contains(&hidden));
                }
            }
        }
    }
    assert!(partial_samples > 100, "{partial_samples} samples in the penumbra");
}

/// Sunlight at a body's centre in green, as if the body itself were not there.
fn light_at_the_centre(prober: &Prober<'_>, body: NaifId, time: Instant, sun_photometry: &Photometry) -> f64 {
    let body = prober.catalog().body(body).expect("a body");
    let receiver = Receiver::at(prober.ephemeris(), body, time).expect("placed");
    let occluded_sun = OccludedSun::seen_from(prober, &receiver, EclipseModelChoice::Requested(EclipseModel::LimbDarkened)).expect("Sun");
    occluded_sun.sunlight(&occluded_sun.occluders, &[DVec3::ZERO], Some(sun_photometry)).expect("answers")[0][1]
}

const UNIFORM_DISC: Photometry = Photometry::Emissive { u1: [0.0; 3], u2: [0.0; 3] };

#[test]
fn the_minimum_of_light_is_within_a_second_of_greatest_eclipse() {
    let table = table(include_str!("../data/eclipses_public.json"));
    let mut checked = 0;
    for eclipse in list(&table, "eclipses").iter().filter(|e| e["kind"] == "solar") {
        let greatest = &eclipse["greatest_eclipse"];
        // The light at the centre is least when the axis is nearest. With a greater gamma the penumbra, half as wide as the Earth, misses the centre.
        if number(greatest, "gamma").abs() > 0.52 {
            continue;
        }
        let greatest_time = Instant::from_tdb_seconds_past_j2000(number(greatest, "tdb_s_past_j2000"));
        let step_s = 120.0;
        let [before, middle, after] =
            [-step_s, 0.0, step_s].map(|s| light_at_the_centre(&f64_prober(), NaifId::EARTH, greatest_time.plus_seconds(s), &UNIFORM_DISC));
        assert!(before > middle && after > middle && middle < 0.99, "{before} {middle} {after}");
        // Where the parabola through the three values is least.
        let minimum_s = 0.5 * step_s * (before - after) / (before - 2.0 * middle + after);
        assert!(minimum_s.abs() < 1.0, "{}: {minimum_s} s", eclipse["id"]);
        checked += 1;
    }
    assert_eq!(checked, 3, "1999, 2020 and 2024");
}

#[test]
fn the_moon_crosses_the_earths_shadow_as_in_de440() {
    // The table is for a spherical Earth.
    let folder = crate::support::scratch::folder("eclipse-catalog");
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("round.toml"), "[[body]]\nid = 399\nname = \"Earth\"\nradii_km = [6378.137, 6378.137, 6378.137]\n")
        .expect("written");
    let session = session_with(folder);
    let prober = Prober { session: &session, renderer: &F32_RENDERER };
    let table = table(include_str!("../data/eclipses_public.json"));
    for eclipse in list(&table, "eclipses").iter().filter(|e| e["kind"] == "lunar") {
        for track in list(eclipse, "track") {
            // The table gives the times when the light reaches the Earth.
            let seen = Instant::from_tdb_seconds_past_j2000(number(track, "tdb_s_past_j2000"));
            let state = prober.ephemeris().state(NaifId::MOON, NaifId::EARTH, seen, None).expect("the Moon").state;
            let time = seen.plus_seconds(-state.pos_km.length() / SPEED_OF_LIGHT_KM_S);
            let error = light_at_the_centre(&prober, NaifId::MOON, time, &UNIFORM_DISC)
                - (1.0 - number(track, "sun_blocked_fraction_at_moon_centre"));
            // An error of one second would be 2.5e-4.
            assert!(error.abs() < 2.5e-4, "{} {}: off by {error:e}", eclipse["id"], track["dt_s_from_greatest"]);
        }
    }
}

/// Points of the ground in a square around a place: distances north and east of it in km, and position in equatorial radii.
fn ground_square(body_radii_km: DVec3, latitude_deg: f64, longitude_deg: f64, half_width_km: f64, steps: i32) -> Vec<(f64, f64, DVec3)> {
    let km_per_deg = body_radii_km.x.to_radians();
    let mut points = Vec::new();
    for i in -steps..=steps {
        for j in -steps..=steps {
            let [north, east] = [i, j].map(|k| f64::from(k) * half_width_km / f64::from(steps));
            let lat = latitude_deg + north / km_per_deg;
            let lon = longitude_deg + east / km_per_deg / lat.to_radians().cos();
            points.push((north, east, ground_point_km(body_radii_km, lat, lon, 0.0).0 / body_radii_km.x));
        }
    }
    points
}

#[test]
fn the_umbra_of_2013_november_3_is_as_wide_as_published() {
    // F. Espenak, eclipse bulletin: greatest eclipse 12:46:28.6 UT at 3 deg 29.4 min N, 11 deg 40.2 min W; path 57.5 km wide.
    let prober = f32_prober();
    let earth = SESSION.catalog().body(NaifId::EARTH).expect("the Earth");
    let receiver = Receiver::at(SESSION.ephemeris(), earth, instant("2013-11-03T12:46:28Z")).expect("placed");
    let occluded_sun = OccludedSun::seen_from(&prober, &receiver, EclipseModelChoice::Requested(EclipseModel::LimbDarkened)).expect("Sun");
    let ground = ground_square(earth.radii_km, 3.49, -11.67, 60.0, 30);
    let points: Vec<_> = ground.iter().map(|(_, _, position)| *position).collect();
    let light = occluded_sun.sunlight(&occluded_sun.occluders, &points, None).expect("answers");
    let dark: Vec<_> = ground.iter().zip(&light).filter(|(_, rgb)| rgb[1] < 1e-6).map(|((north, east, _), _)| (*north, *east)).collect();
    // The least extent of the dark points over all directions.
    let width_km = (0..36)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 5.0).to_radians().sin_cos();
            let across = || dark.iter().map(|(north, east)| north * cos + east * sin);
            across().fold(f64::MIN, f64::max) - across().fold(f64::MAX, f64::min)
        })
        .fold(f64::MAX, f64::min);
    assert!((width_km - 57.5).abs() < 6.0, "{width_km} km, from points 2 km apart");
}

#[test]
fn shadows_move_continuously_from_second_to_second() {
    // (body, time, greatest change per second): the Moon's shadow moves at up to 10 km/s near the edge of the Earth and has a penumbra of 3400 km;
    // the Moon moves through the Earth's shadow at 1 km/s.
    for (body, time, max_change) in [(NaifId::EARTH, "2006-03-29T12:17:51Z", 3e-3), (NaifId::MOON, "2022-05-16T06:22:36Z", 6e-4)] {
        let prober = f32_prober();
        let body = SESSION.catalog().body(body).expect("a body");
        let points: Vec<_> = (0..40)
            .flat_map(|i| (0..80).map(move |j| (f64::from(i) * 4.5 - 88.0, f64::from(j) * 4.5)))
            .map(|(lat, lon)| ground_point_km(body.radii_km, lat, lon, 0.0).0 / body.radii_km.x)
            .collect();
        let light = |second: f64| {
            let receiver = Receiver::at(SESSION.ephemeris(), body, instant(time).plus_seconds(second)).expect("placed");
            let occluded_sun = OccludedSun::seen_from(&prober, &receiver, EclipseModelChoice::Best).expect("Sun");
            occluded_sun.sunlight(&occluded_sun.occluders, &points, None).expect("answers")
        };
        let by_second: Vec<_> = (-2..3).map(|s| light(f64::from(s))).collect();
        for (before, after) in by_second.iter().zip(&by_second[1..]) {
            let worst = before.iter().zip(after).flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs())).fold(0.0, larger);
            assert!(worst < max_change, "{}: {worst:e}", body.name);
            assert!(worst > 0.0, "{}: nothing moves", body.name);
        }
    }
}

/// Mean light over the Moon's near side, per channel, relative to that outside the shadow.
fn light_on_near_side(prober: &Prober<'_>, time: &str) -> [f64; 3] {
    let moon = SESSION.catalog().body(NaifId::MOON).expect("the Moon");
    let receiver = Receiver::at(SESSION.ephemeris(), moon, instant(time)).expect("placed");
    let occluded_sun = OccludedSun::seen_from(prober, &receiver, EclipseModelChoice::Best).expect("Sun");
    // Uniform over the disc, as the full Moon is nearly as bright at the limb as in the middle. The Moon's +x axis faces the Earth.
    let points: Vec<_> = (0..400)
        .map(|k| {
            let (r, (sin, cos)) = (((f64::from(k) + 0.5) / 400.0).sqrt(), (f64::from(k) * GOLDEN_ANGLE_RAD).sin_cos());
            DVec3::new((1.0 - r * r).sqrt(), r * cos, r * sin)
        })
        .collect();
    let light = occluded_sun.sunlight(&occluded_sun.occluders, &points, None).expect("answers");
    [0, 1, 2].map(|c| light.iter().map(|rgb| rgb[c]).sum::<f64>() / light.len() as f64)
}

#[test]
fn the_eclipsed_moon_is_as_bright_as_observed_and_red() {
    // Greatest eclipse and umbral magnitude U. H. de Carvalho Vital's fit to eclipses without volcanic ash (r2 = 0.998): the Moon's magnitude
    // is -(U (2.08 U - 10.34) + 11.7); that of the full Moon is -12.7. The clouds of a day change it by half a magnitude. Greatest difference measured: 0.32.
    for (time, umbral_magnitude) in [("2022-11-08T10:59:09Z", 1.359), ("2021-11-19T09:02:53Z", 0.974), ("2019-01-21T05:12:14Z", 1.195)] {
        let rgb = light_on_near_side(&f32_prober(), time);
        let magnitude = -12.7 - 2.5 * luminance(rgb).log10();
        let observed = -(umbral_magnitude * (2.08 * umbral_magnitude - 10.34) + 11.7);
        println!("{time}: magnitude {magnitude:.2}, observed {observed:.2}, colour {:.1} {:.1}", rgb[0] / rgb[1], rgb[1] / rgb[2]);
        assert!((magnitude - observed).abs() < 0.5, "{time}: magnitude {magnitude}, observers give {observed}");
        assert!(umbral_magnitude < 1.0 || rgb[0] > 2.0 * rgb[1] && rgb[1] > rgb[2], "{time}: {rgb:?}");
    }
    // Without the Earth's air no light reaches the middle of the near side, in the umbra.
    let moon = SESSION.catalog().body(NaifId::MOON).expect("the Moon");
    let receiver = Receiver::at(SESSION.ephemeris(), moon, instant("2022-11-08T10:59:09Z")).expect("placed");
    let prober = f32_prober();
    let occluded_sun = OccludedSun::seen_from(&prober, &receiver, EclipseModelChoice::Requested(EclipseModel::LimbDarkened)).expect("Sun");
    assert!(occluded_sun.sunlight(&occluded_sun.occluders, &[DVec3::X], None).expect("answers")[0][0] < 1e-6);
}

/// Uniforms of a Sun on +z and of round occluders (x, y, z, radius), lengths in the receiver's radii. `tan_sun`: tangent of the Sun's angular radius.
fn uniforms(sun_distance: f64, tan_sun: f64, occluders: &[[f64; 4]], model: EclipseModel) -> (Eclipse, EclipseUniforms) {
    let vec4 = |x: f64, y: f64, z: f64, w: f64| Vec4::new(x as f32, y as f32, z as f32, w as f32);
    let (u1, u2) = if model == EclipseModel::UniformDisc { (0.0, 0.0) } else { (0.4, 0.26) };
    let flux = std::f64::consts::PI * (1.0 - u1 / 3.0 - u2 / 6.0);
    let limb_darkening = [1.0 - u1 - u2, u1 + 2.0 * u2, -u2].map(|f| vec4(f / flux, f / flux, f / flux, 0.0));
    let uniforms = EclipseUniforms {
        axis: vec4(0.0, 0.0, 1.0, 1.0 / sun_distance),
        perpendicular_axes: [vec4(1.0, 0.0, 0.0, 1.0 / tan_sun), vec4(0.0, 1.0, 0.0, 1.0 / (tan_sun * sun_distance))],
        limb_darkening,
        occluder_positions: occluders.iter().map(|c| vec4(c[0], c[1], c[2], 0.0)).collect(),
        occluder_outlines: occluders.iter().map(|c| vec4(1.0, 0.0, c[3], c[3])).collect(),
        ..EclipseUniforms::default()
    };
    (Eclipse { occluders: occluders.len() as u8, model }, uniforms)
}

/// Fraction of the Sun's light that discs (x, y, radius in solar radii) leave visible, from a fine grid over the Sun's disc.
fn visible_fraction_by_grid(discs: &[[f64; 3]], u1: f64, u2: f64) -> f64 {
    let side = 1200;
    let (mut total, mut visible) = (0.0, 0.0);
    for i in 0..side {
        for j in 0..side {
            let [x, y] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(side) * 2.0 - 1.0);
            let r2 = x * x + y * y;
            if r2 < 1.0 {
                let mu = (1.0 - r2).sqrt();
                let light = 1.0 - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2);
                total += light;
                visible += if discs.iter().any(|d| (x - d[0]).hypot(y - d[1]) < d[2]) { 0.0 } else { light };
            }
        }
    }
    visible / total
}

#[test]
fn overlapping_occluders_block_the_union_of_their_discs() {
    // The Sun's angular radius has the tangent 0.01, so at the occluders' distance of 100 its disc has a radius of 1, and lengths across are in solar radii.
    let occluders = |discs: &[[f64; 3]]| -> Vec<[f64; 4]> { discs.iter().map(|d| [d[0], d[1], 100.0, d[2]]).collect() };
    let cases: [&[[f64; 3]]; 6] = [
        &[[0.3, 0.0, 0.5], [0.3, 0.0, 0.5]],
        &[[0.3, 0.1, 0.5], [-0.2, 0.2, 0.4]],
        &[[1.2, 0.3, 0.9], [0.8, -0.7, 0.6]],
        &[[0.3, 0.1, 0.5], [-0.2, 0.2, 0.4], [0.0, -0.6, 0.3]],
        &[[0.3, 0.1, 0.5], [-0.2, 0.2, 0.4], [0.0, -0.6, 0.3], [0.2, -0.2, 0.45]],
        &[[30.4, 0.0, 30.0], [0.5, 0.4, 0.3]],
    ];
    for discs in cases {
        let product: f64 = discs.iter().map(|disc| visible_fraction_by_grid(std::slice::from_ref(disc), 0.4, 0.26)).product();
        let exact = visible_fraction_by_grid(discs, 0.4, 0.26);
        let (eclipse, eclipse_uniforms) = uniforms(1e7, 0.01, &occluders(discs), EclipseModel::LimbDarkened);
        let found = sunlight_from_uniforms(&f32_prober(), eclipse, eclipse_uniforms, &[DVec3::ZERO]).expect("answers")[0][1];
        assert!((found - exact).abs() < 1e-3, "{discs:?}: {found}, the grid says {exact}");
        assert!((product - exact).abs() > 0.01, "{discs:?}: the product {product} would pass as well");
        // `linear` is a rough model, but does not multiply the fractions either: two equal discs hide no more than one.
        let (eclipse, eclipse_uniforms) = uniforms(1e7, 0.01, &occluders(discs), EclipseModel::Linear);
        let linear = sunlight_from_uniforms(&f32_prober(), eclipse, eclipse_uniforms, &[DVec3::ZERO]).expect("answers")[0][1];
        assert!((linear - exact).abs() < 0.15, "{discs:?}: linear {linear}, the grid says {exact}");
    }
}

#[test]
fn bodies_behind_the_lit_point_do_not_darken_it() {
    for model in [EclipseModel::Linear, EclipseModel::UniformDisc, EclipseModel::LimbDarkened] {
        let (eclipse, eclipse_uniforms) = uniforms(2e4, 0.005, &[[0.0, 0.0, -60.0, 0.3]], model);
        let ground = [DVec3::Z, DVec3::X, DVec3::ZERO, -DVec3::Z];
        for rgb in sunlight_from_uniforms(&f32_prober(), eclipse, eclipse_uniforms, &ground).expect("answers") {
            assert_eq!(rgb, [1.0; 3], "{model:?}");
        }
        // The same occluder in front of the point blocks all its light.
        let (eclipse, eclipse_uniforms) = uniforms(2e4, 0.005, &[[0.0, 0.0, 30.0, 0.3]], model);
        assert!(sunlight_from_uniforms(&f32_prober(), eclipse, eclipse_uniforms, &[DVec3::Z]).expect("answers")[0][1] < 1e-6);
    }
}

#[test]
fn f32_suffices_out_to_neptune() {
    // Distance and radius of the Sun, then of the occluder, in the receiver's radii: the shadow of the Moon on the Earth, Io on Jupiter,
    // Jupiter on Io, Titan on Saturn, Saturn on Titan, Neptune on Triton, Neptune on Proteus.
    let cases = [
        (23_455.0, 109.1, 60.3, 0.2725),
        (10_890.0, 9.73, 5.9, 0.0255),
        (427_400.0, 381.9, 231.5, 39.25),
        (23_720.0, 11.54, 20.3, 0.0427),
        (555_300.0, 270.2, 474.5, 23.4),
        (3_323_000.0, 514.0, 262.2, 18.3),
        (21_400_000.0, 3313.0, 560.0, 117.9),
    ];
    let (mut worst_error, mut worst_distance) = (0.0, 0.0);
    for (sun_distance, sun_radius, distance, radius) in cases {
        let tan_sun = sun_radius / sun_distance;
        for k in (0..400).filter(|k| sweep::runs(*k as usize, 4)) {
            // From the axis to beyond the edge of the penumbra.
            let axis_distance = f64::from(k) / 400.0 * (radius + 1.2 * tan_sun * distance);
            let (eclipse, eclipse_uniforms) =
                uniforms(sun_distance, tan_sun, &[[axis_distance, 0.1 * axis_distance, distance, radius]], EclipseModel::LimbDarkened);
            let points = [DVec3::new(0.6, -0.3, 0.7), DVec3::new(-0.2, 0.1, 0.97)];
            let [in_f32, in_f64] = [f32_prober(), f64_prober()]
                .map(|p| sunlight_from_uniforms(&p, eclipse, eclipse_uniforms.clone(), &points).expect("answers"));
            for (a, b) in in_f32.iter().zip(&in_f64) {
                let error = (a[1] - b[1]).abs();
                assert!(error.is_finite(), "{sun_distance} radii from the Sun: {a:?}, {b:?}");
                if error > worst_error {
                    (worst_error, worst_distance) = (error, sun_distance);
                }
            }
        }
    }
    println!("greatest error {worst_error:e}, {worst_distance} radii from the Sun");
    assert!(worst_error < 5e-4 && worst_error > 0.0, "{worst_error:e}, {worst_distance} radii from the Sun");
}

fn view(target: NaifId, time: &str, effects: &str, quality: Quality) -> ViewRequest {
    ViewRequest {
        effects: EffectOverrides::parse(effects).expect("effects"),
        quality,
        width: 160,
        height: 160,
        exposure: ExposureRequest::Stops(2.0),
        ..ViewRequest::of(target, instant(time))
    }
}

fn features_of(request: &ViewRequest) -> DrawFeatures {
    let scene = Scene::build(SESSION.catalog(), SESSION.ephemeris(), request).expect("a scene");
    let target = request.target.expect("a target");
    scene.draws.iter().find(|d| d.body == target).expect("drawn").features
}

#[test]
fn the_scene_has_an_eclipse_feature_where_an_eclipse_occurs() {
    let eclipse = |target, time, effects: &str, quality| features_of(&view(target, time, effects, quality)).eclipse;
    let eclipse_by = |occluders, model| Eclipse { occluders, model };
    let (earth, moon, jupiter) = (NaifId::EARTH, NaifId::MOON, NaifId(599));
    let standard = Quality::Standard;
    assert_eq!(eclipse(earth, "2024-04-08T18:17:00Z", "", standard), eclipse_by(1, EclipseModel::LimbDarkened));
    assert_eq!(eclipse(earth, "2024-04-08T18:17:00Z", "", Quality::Draft), eclipse_by(1, EclipseModel::UniformDisc));
    assert_eq!(eclipse(earth, "2024-04-08T18:17:00Z", "+eclipse=linear", standard), eclipse_by(1, EclipseModel::Linear));
    assert_eq!(
        eclipse(earth, "2024-04-08T18:17:00Z", "+eclipse=refracted", standard),
        eclipse_by(1, EclipseModel::LimbDarkened),
        "the Moon has no air"
    );
    assert_eq!(eclipse(earth, "2024-04-08T18:17:00Z", "-eclipse", standard), Eclipse::default());
    assert_eq!(eclipse(earth, "2024-04-22T18:17:00Z", "", standard), Eclipse::default());
    assert_eq!(eclipse(moon, "2022-11-08T10:59:00Z", "", standard), eclipse_by(1, EclipseModel::Refracted));
    assert_eq!(eclipse(moon, "2022-11-01T10:59:00Z", "", standard), Eclipse::default());
    // From 06:27 to 06:52 UT, as seen from the Earth, three moons cast shadows on Jupiter.
    let request = ViewRequest { position: Position::Centre(earth), ..view(jupiter, "2015-01-24T06:40:00Z", "", standard) };
    let scene = Scene::build(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a scene");
    let decisions = &scene.body(jupiter).expect("Jupiter").decisions;
    let reason = decisions.iter().find(|d| d.effect == "eclipse").expect("decided").reason.to_string();
    assert!(["Io", "Europa", "Callisto"].iter().all(|moon| reason.contains(moon)), "{reason}");
    assert!(!reason.contains("Ganymede"), "{reason}");
}

/// Resources of the session without maps.
struct WithoutMaps;
impl ResourceProvider for WithoutMaps {
    fn layout(&self, module: &ModuleId) -> Result<Layout, PlanError> {
        SESSION.library().get(module).map(|m| m.layout.clone()).map_err(|e| PlanError::Module(e.to_string()))
    }
    fn map(&self, file: &str, _: MapDecoding) -> Result<SharedTexture, PlanError> {
        self.overlay(file)
    }
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError> {
        Err(PlanError::Map { file: file.into(), why: "this test draws without maps".into() })
    }
    fn ring_profile(&self, table: &std::sync::Arc<orrery::scene::draw::RingTable>) -> SharedTexture {
        SESSION.ring_profile(table)
    }
    fn glyphs(&self, size_px: f64) -> std::sync::Arc<orrery::image::GlyphAtlas> {
        SESSION.glyphs(size_px)
    }
}

#[test]
fn an_occluder_that_hides_nothing_changes_no_bit_of_the_image() {
    let draw = |effects: &str| {
        let request = view(NaifId::EARTH, "2024-04-08T18:17:00Z", effects, Quality::Draft);
        let mut scene = Scene::build(SESSION.catalog(), SESSION.ephemeris(), &request).expect("a scene");
        // Move the Moon to the side.
        for draw in &mut scene.draws {
            draw.uniforms.eclipse.occluder_positions.iter_mut().for_each(|p| p.x += 50.0);
        }
        let plan = plan(&scene, &WithoutMaps, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
        F32_RENDERER.render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("an image").0
    };
    const WITHOUT_SURFACE_EFFECTS: &str = ",-albedo,-normal,-specular,-night,-clouds,-cloud-shadow,-atmosphere";
    let [with, without] = ["+eclipse=limb-darkened", "-eclipse"].map(|e| draw(&format!("{e}{WITHOUT_SURFACE_EFFECTS}")));
    assert!(with.hdr.iter().any(|p| p[0] > 0.0));
    assert_eq!(with.hdr, without.hdr);
}
