//! Formulas that exist both in Rust (for bounds, decisions and tables) and in the shaders: over the range of its arguments, the emitted
//! function, evaluated in f64, agrees with the Rust function.
//!
//! Most tests state a tolerance, and show that an edited shader or exchanged arguments exceed it.

use crate::support::emitted::{Emitted, EvalInput};
use crate::support::folds::larger;
use crate::support::photons;
use crate::support::random::Random;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::catalog::{AerosolPhase, Catalog, NaifId, PhaseFunction, Photometry, Ring};
use orrery::image::{OpacityTexels, SharedTexture};
use orrery::render::plan::ring_profile;
use orrery::scene::atmosphere::phase;
use orrery::scene::draw::{CloudUniforms, DrawUniforms, Light, RingTable, Surface};
use orrery::scene::photometry::{model_geometric_albedo, model_phase, reflectance};
use orrery::scene::request::ViewRequest;
use orrery::scene::ring_shine::{scattered, sun_disc_parts};
use orrery::scene::rings::{MIN_COSINE, RingConditions, dust_phase, large_particle_phase};
use orrery::time::Instant;
use orrery::units::linear_to_srgb;
use std::f64::consts::PI;
use std::sync::Arc;

/// An input padded with zeros.
fn eval_input<const N: usize>(numbers: [f64; N]) -> EvalInput {
    std::array::from_fn(|k| numbers.get(k).copied().unwrap_or(0.0))
}

fn replace_once(text: String, shipped: &str, edit: &str) -> String {
    assert_eq!(text.matches(shipped).count(), 1, "{shipped}");
    text.replace(shipped, edit)
}

fn one_light() -> Vec<Light> {
    vec![Light { direction_in_body: glam::Vec3::X, irradiance: glam::Vec3::ONE }]
}

fn one_light_uniforms() -> DrawUniforms {
    DrawUniforms { lights: one_light(), ..DrawUniforms::default() }
}

/// Greatest difference of the first channel from the expected value, relative to the larger of 1 and that value.
fn greatest_error(results: &[[f64; 4]], expected: impl Iterator<Item = f64>) -> f64 {
    assert!(results.iter().all(|a| a[0].is_finite()));
    results.iter().zip(expected).map(|(a, e)| (a[0] - e).abs() / e.abs().max(1.0)).fold(0.0, larger)
}

const RING: &str = "ring.sun1.sphere";

/// The scene's uniforms of Saturn's ring, which contain the coefficients of its phase functions.
fn saturns_ring() -> DrawUniforms {
    let time = Instant::parse("2024-09-08T04:00:00Z").expect("a time");
    let scene = SESSION.scene(&ViewRequest::of(NaifId(699), time)).expect("a scene");
    let ring = scene.draws.iter().find(|d| d.features.surface == Surface::Ring).expect("Saturn has a ring").uniforms.clone();
    DrawUniforms { lights: one_light(), ..ring }
}

/// Cosines of the phase angle, closely spaced at both ends, where the opposition surge and forward scattering peak.
fn phase_cosines() -> Vec<f64> {
    (0..=1000).map(|k| f64::from(k) / 1000.0).map(|t| (PI * (t - (2.0 * PI * t).sin() / (2.0 * PI))).cos()).collect()
}

/// Tolerance 2e-5: the uniforms are f32, and 1 - g of the narrowest lobe is 0.005.
#[test]
fn the_phase_functions_of_rings_agree_with_the_shader() {
    const TOLERANCE: f64 = 2e-5;
    let uniforms = saturns_ring();
    let inputs: Vec<EvalInput> = phase_cosines().into_iter().map(|c| eval_input([c])).collect();
    for (function, reference) in
        [("ring_particle_phase", large_particle_phase as fn(f64) -> f64), ("ring_dust_phase", |c: f64| dust_phase(c.acos()))]
    {
        let value = format!("vec4f({function}(p.x))");
        let expected = || phase_cosines().into_iter().map(reference);
        let found = greatest_error(&Emitted::new(RING, &value).evaluate(&uniforms, None, &inputs), expected());
        assert!(found < TOLERANCE, "{function}: {found}");
        for (shipped, edit) in [
            ("2.0 * atan2(cos_half_phase, sin_half_phase)", "2.01 * atan2(cos_half_phase, sin_half_phase)"),
            ("g * (2.0 * max(1.0 + cos_phase", "g * (2.01 * max(1.0 + cos_phase"),
        ] {
            let edited = Emitted::edited(RING, &value, |text| replace_once(text, shipped, edit));
            let found = greatest_error(&edited.evaluate(&uniforms, None, &inputs), expected());
            let is_affected = shipped.contains("atan2") == (function == "ring_particle_phase");
            assert_eq!(found > 10.0 * TOLERANCE, is_affected, "{function}, {edit}: {found}");
        }
    }
}

/// Whether light is scattered equally in all directions, so that it does not depend on the cosine.
fn is_isotropic(function: PhaseFunction, channel: usize) -> bool {
    phase::per_steradian(function, 1.0)[channel] == phase::per_steradian(function, 0.0)[channel]
}

/// All phase functions of the air, for all samples. Tolerance 1e-12: both compute in f64. An input is the cosine of the scattering angle (p.x) and the four
/// parameters of the aerosol (p.y, p.z, p.w, q.x). A cosine 1e-6 smaller must be detected.
#[test]
fn the_phase_functions_of_air_agree_with_the_shader() {
    const AIR: &str = "lambert.albedo.sun1.air-pixel-8-mie.sphere";
    const TOLERANCE: f64 = 1e-12;
    let of_gas = (PhaseFunction::Rayleigh, [0.0; 4], "rayleigh_phase(COSINE)".to_owned(), 0);
    let of_aerosols = AerosolPhase::samples().into_iter().flat_map(|aerosol| {
        let value = |component: &str| format!("aerosol_phase(COSINE, vec4f(p.yzw, q.x)).{component}");
        [(0, "x"), (1, "y"), (2, "z")].map(|(channel, c)| (PhaseFunction::Aerosol(aerosol), aerosol.parameters(), value(c), channel))
    });
    for (function, [red, green, blue, w], value, channel) in [of_gas].into_iter().chain(of_aerosols) {
        let inputs: Vec<EvalInput> = phase_cosines().into_iter().map(|c| eval_input([c, red, green, blue, w])).collect();
        let error = |cosine: &str| {
            let emitted = Emitted::new(AIR, &format!("vec4f({})", value.replace("COSINE", cosine)));
            // The shader's functions are pi times those of Rust.
            let expected = phase_cosines().into_iter().map(|c| PI * phase::per_steradian(function, c)[channel]);
            greatest_error(&emitted.evaluate(&one_light_uniforms(), None, &inputs), expected)
        };
        let (found, of_other_cosine) = (error("p.x"), error("(p.x - 1.0e-6)"));
        assert!(found < TOLERANCE, "{function:?}, {channel}: {found}");
        let is_detected = of_other_cosine > 10.0 * TOLERANCE;
        assert!(is_detected || is_isotropic(function, channel), "{function:?}, {channel}: a wrong cosine is not detected");
    }
}

/// The phase functions of the air in Rust against the tests' own (tests/support/photons.rs), for all samples. Relative tolerance 1e-11: with the asymmetry
/// 0.95, 1 + g^2 - 2 g c is 0.0025 forwards, the difference of two numbers near 2, so that rounding changes a power of it by a few 1e-13. A cosine
/// 1e-6 smaller must be detected.
#[test]
fn the_phase_functions_of_air_agree_with_those_of_the_tests() {
    const TOLERANCE: f64 = 1e-11;
    let functions = [PhaseFunction::Rayleigh].into_iter().chain(AerosolPhase::samples().into_iter().map(PhaseFunction::Aerosol));
    for (function, channel) in functions.flat_map(|function| [0, 1, 2].map(|channel| (function, channel))) {
        let error = |cosine_offset: f64| {
            let error_at = |c: f64| {
                let tests_own = photons::per_steradian(function, channel, c + cosine_offset);
                (phase::per_steradian(function, c)[channel] / tests_own - 1.0).abs()
            };
            phase_cosines().into_iter().map(error_at).fold(0.0, larger)
        };
        let (found, of_other_cosine) = (error(0.0), error(-1e-6));
        assert!(found < TOLERANCE, "{function:?}, {channel}: src/scene/atmosphere/phase.rs and tests/support/photons.rs differ by {found}");
        let is_detected = of_other_cosine > 10.0 * TOLERANCE;
        assert!(is_detected || is_isotropic(function, channel), "{function:?}, {channel}: a wrong cosine is not detected");
    }
}

/// Uniforms for a ring table, and the texture from which the fragment reads it.
fn with_table(base: &DrawUniforms, table: RingTable) -> (DrawUniforms, SharedTexture) {
    let mut uniforms = base.clone();
    uniforms.ring.radius_range = glam::Vec2::new(table.radius_range[0] as f32, table.radius_range[1] as f32);
    let texture = ring_profile(&table);
    uniforms.ring.table = Some(Arc::new(table));
    (uniforms, texture)
}

/// A ring of uniform optical depth against the closed forms, on both sides of the plane and with the Sun's disc partly below it: within
/// 5e-4 plus 1 % of the light that passes through the ring. Between its rows the table is linear in the logarithm of the view ray's slant.
#[test]
fn light_scattered_by_a_ring_agrees_with_the_shader() {
    // Larger than the tangent of any Sun's angular radius in the catalog.
    const SUN_TANGENT: f64 = 0.02;
    let from_saturn = saturns_ring();
    let cosines: Vec<f64> = (0..200).map(|k| 0.02_f64.powf(f64::from(k) / 199.0)).collect();
    let inputs: Vec<EvalInput> = cosines.iter().map(|c| eval_input([*c])).collect();
    // Between 1.6 and 1.7 radii; the test above covers the phase function.
    let value = "vec4f(4.0 * ring_mean(radial_span(1.6, 0.1), 1.0 / p.x).large_particles.rgb, 0.0)";
    let emitted = Emitted::new(RING, value);
    let mut detected = 0;
    for tau in [0.01, 0.3, 1.0, 3.0] {
        for sine in [0.0, 0.004, 0.015, 0.03, 0.1, 0.2, 0.3001, 0.45] {
            let [sunward, beyond] = sun_disc_parts(sine, SUN_TANGENT);
            for sunlight in [[sunward, beyond], [beyond, sunward]] {
                let ring = Ring { name: "one".into(), inner_km: 1.2, outer_km: 2.2, tau_normal: tau, albedo: [1.0; 3], dust_fraction: 0.0 };
                let table = RingTable::of([ring].iter(), 1.0, &RingConditions::new(Some(sunlight), 1.0, 50.0)).expect("a table");
                let (uniforms, texture) = with_table(&from_saturn, table);
                let light = |half: usize, view_slant: f64, same_side: bool| {
                    let [fraction, sine] = sunlight[half];
                    if fraction > 0.0 { fraction * scattered(tau, view_slant, 1.0 / sine.max(MIN_COSINE), same_side) } else { 0.0 }
                };
                for (cosine, a) in cosines.iter().zip(emitted.evaluate(&uniforms, Some(texture), &inputs)) {
                    let view_slant = 1.0 / cosine;
                    let through = light(1, view_slant, false);
                    let expected = light(0, view_slant, true) + through;
                    let tolerance = 5e-4 + 0.01 * through;
                    assert!(
                        (a[0] / 4.0 - expected).abs() < tolerance,
                        "tau {tau}, sine {sine}, slant {view_slant}: {} for {expected}",
                        a[0] / 4.0
                    );
                    let swapped = light(0, view_slant, false) + light(1, view_slant, true);
                    detected += usize::from((a[0] / 4.0 - swapped).abs() > 10.0 * tolerance);
                }
            }
        }
    }
    assert!(detected > 500, "exchanged sides are detected only {detected} times");
}

/// The light that Saturn's rings block along a path, averaged over an interval of radius, against the sum over the catalog's ringlets in
/// f64: for 100 000 random intervals, 0.2 to 54 000 km wide, among the rings, inside and outside of them.
#[test]
fn any_interval_of_radius_has_the_mean_of_its_ringlets() {
    let catalog = Catalog::embedded();
    let saturn = catalog.body(NaifId(699)).expect("Saturn");
    let unit_km = saturn.radii_km.x;
    let slant: f64 = 2.0;
    let table = RingTable::of(saturn.rings.iter(), unit_km, &RingConditions::new(None, slant, slant)).expect("a table");
    let [inner, outer] = table.radius_range;
    // The fraction blocked between neighbouring edges, and its integral up to each edge.
    let mut edges: Vec<f64> = saturn.rings.iter().flat_map(|r| [r.inner_km / unit_km, r.outer_km / unit_km]).collect();
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    let blocked: Vec<f64> = edges
        .windows(2)
        .map(|e| {
            let middle_km = 0.5 * (e[0] + e[1]) * unit_km;
            let ringlet = saturn.rings.iter().rfind(|r| r.inner_km <= middle_km && middle_km < r.outer_km);
            ringlet.map_or(0.0, |r| -(-r.tau_normal * slant).exp_m1())
        })
        .collect();
    let mut blocked_up_to_edge = vec![0.0];
    for (e, t) in edges.windows(2).zip(&blocked) {
        blocked_up_to_edge.push(blocked_up_to_edge[blocked_up_to_edge.len() - 1] + (e[1] - e[0]) * t);
    }
    let blocked_integral = |r: f64| {
        let r = r.clamp(edges[0], edges[edges.len() - 1]);
        let k = edges.partition_point(|e| *e <= r).clamp(1, blocked.len()) - 1;
        blocked_up_to_edge[k] + (r - edges[k]) * blocked[k]
    };
    let mut random = Random(88_172_645_463_325_252);
    let inputs: Vec<EvalInput> = (0..100_000)
        .map(|_| {
            let width = 3.0e-6 * 3.0e5_f64.powf(random.uniform());
            let from =
                f64::from((inner - 0.2 + random.uniform() * (if random.uniform() < 0.8 { 1.5 } else { outer - inner + 0.4 })) as f32);
            eval_input([from, f64::from(width as f32)])
        })
        .collect();
    let (uniforms, texture) = with_table(&saturns_ring(), table);
    let greatest_error = |value: &str| {
        let results = Emitted::new(RING, value).evaluate(&uniforms, Some(texture.clone()), &inputs);
        // Errors are relative to the precision of the radii in f32: 2^-23 of an end, divided by the width.
        inputs
            .iter()
            .zip(results)
            .map(|(q, a)| {
                let (from, width) = (q[0], q[1]);
                let mean = (blocked_integral(from + width) - blocked_integral(from)) / width;
                (a[0] - mean).abs() / (1.2e-7 * (from + width).max(1.0) / width + 1e-6)
            })
            .reduce(larger)
            .expect("results")
    };
    let found = greatest_error("vec4f(ring_mean(radial_span(p.x, p.y), 2.0).large_particles.w)");
    assert!(found < 1.0, "{found} of the precision of f32");
    let widened = greatest_error("vec4f(ring_mean(radial_span(p.x, p.y + 1.0e-4), 2.0).large_particles.w)");
    assert!(widened > 10.0, "an interval 6 km wider would pass: {widened}");
}

/// A module, its photometric law, and the parameter that the shader gets.
const LAWS: [(&str, Photometry, f64); 4] = [
    ("lambert.sun1.sphere", Photometry::Lambert, 0.0),
    ("lommel-seeliger.sun1.sphere", Photometry::LommelSeeliger, 0.0),
    ("lunar-lambert.sun1.sphere", Photometry::LunarLambert { lunar_weight: 0.6 }, 0.6),
    ("oren-nayar.sun1.sphere", Photometry::OrenNayar { roughness_deg: 20.0 }, 20.0 * PI / 180.0 * 20.0 * PI / 180.0),
];

/// The WGSL call of a law's reflectance; the law's parameter, if any, is `p.w`.
fn reflectance_call(module: &str) -> String {
    let parameter = if module.starts_with("lunar") || module.starts_with("oren") { ", p.w" } else { "" };
    format!("vec4f(reflectance(p.x, p.y, p.z{parameter}))")
}

/// Light that a sphere with the shader's law sends to a viewer at a phase angle, relative to a disc of radiance 1.
fn disc_brightness(law: &Emitted, alpha: f64, parameter: f64) -> f64 {
    const LONGITUDES: u32 = 240;
    const LATITUDES: u32 = 120;
    let to_sun = DVec3::new(alpha.cos(), alpha.sin(), 0.0);
    // The visible and lit part: longitude from alpha - 90 to 90 degrees.
    let (from, width) = (alpha - PI / 2.0, PI - alpha);
    let mut inputs = Vec::new();
    let mut weights = Vec::new();
    for i in 0..LONGITUDES {
        let longitude = from + width * (f64::from(i) + 0.5) / f64::from(LONGITUDES);
        for j in 0..LATITUDES {
            let latitude = PI * ((f64::from(j) + 0.5) / f64::from(LATITUDES) - 0.5);
            let normal = DVec3::new(longitude.cos() * latitude.cos(), longitude.sin() * latitude.cos(), latitude.sin());
            inputs.push(eval_input([normal.dot(to_sun), normal.x, to_sun.x, parameter]));
            weights.push(normal.x * latitude.cos());
        }
    }
    let results = law.evaluate(&one_light_uniforms(), None, &inputs);
    let sum: f64 = results.iter().zip(weights).map(|(a, w)| a[0] * w).sum();
    sum * width / f64::from(LONGITUDES) / f64::from(LATITUDES)
}

/// The brightness of a point comes from the integrated light of the sphere, the brightness of a disc from the law at each point: both must
/// agree. Tolerance 1e-3 of full phase.
#[test]
fn spheres_of_each_law_are_as_bright_as_their_points() {
    const TOLERANCE: f64 = 1e-3;
    let relative_error = |law: &Emitted, model: &Photometry, parameter: f64| -> f64 {
        let full = model_geometric_albedo(model)[0];
        let error_at = |deg: f64| (disc_brightness(law, deg.to_radians(), parameter) / full - model_phase(model, deg.to_radians())).abs();
        [0.0, 10.0, 45.0, 90.0, 135.0, 170.0].map(error_at).into_iter().reduce(larger).expect("six angles")
    };
    for (module, model, parameter) in &LAWS {
        let found = relative_error(&Emitted::new(module, &reflectance_call(module)), model, *parameter);
        assert!(found < TOLERANCE, "{module}: {found}");
        let (shipped, edit) = match model {
            Photometry::Lambert => ("return cos_incidence;", "return 1.01 * cos_incidence;"),
            Photometry::LommelSeeliger | Photometry::LunarLambert { .. } => {
                ("2.0 * cos_incidence / max(cos_incidence +", "2.02 * cos_incidence / max(cos_incidence +")
            }
            _ => ("0.45 * sigma_sq", "0.48 * sigma_sq"),
        };
        let found = relative_error(
            &Emitted::edited(module, &reflectance_call(module), |text| replace_once(text, shipped, edit)),
            model,
            *parameter,
        );
        assert!(found > 2.0 * TOLERANCE, "{module}, {edit}: {found}");
    }
}

/// The law itself, which the light meter uses for ground. Tolerance 1e-6: the parameter is the only number passed in f32.
#[test]
fn reflectance_agrees_with_the_shader_at_every_angle() {
    let mut angles = Vec::new();
    for i in 1..40 {
        for j in 1..40 {
            for k in 0..8 {
                let (theta_i, theta_e) = (f64::from(i) / 40.0 * PI / 2.0, f64::from(j) / 40.0 * PI / 2.0);
                let azimuth = f64::from(k) / 7.0 * PI;
                let cos_phase = theta_i.cos() * theta_e.cos() + theta_i.sin() * theta_e.sin() * azimuth.cos();
                angles.push([theta_i.cos(), theta_e.cos(), cos_phase]);
            }
        }
    }
    for (module, model, parameter) in &LAWS {
        let inputs: Vec<EvalInput> = angles.iter().map(|[i, e, p]| eval_input([*i, *e, *p, *parameter])).collect();
        let results = Emitted::new(module, &reflectance_call(module)).evaluate(&one_light_uniforms(), None, &inputs);
        let found = greatest_error(&results, angles.iter().map(|[i, e, p]| reflectance(model, *i, *e, *p)));
        assert!(found < 1e-6, "{module}: {found}");
        let other = greatest_error(&results, angles.iter().map(|[i, e, p]| reflectance(model, *e, *i, *p)));
        assert!(other > 1e-2, "{module}: exchanged incidence and emission are not detected, {other}");
    }
}

/// A roughness given in degrees in the catalog reaches the shader as the square of radians, a lunar weight as it is.
#[test]
fn the_catalogs_parameters_reach_the_photometric_laws() {
    let catalog = Catalog::embedded();
    let time = Instant::parse("2024-09-08T04:00:00Z").expect("a time");
    let (mut weights, mut roughnesses) = (0, 0);
    for body in catalog.bodies() {
        let expected = match body.photometry {
            Photometry::LunarLambert { lunar_weight } => lunar_weight,
            Photometry::OrenNayar { roughness_deg } => roughness_deg.to_radians().powi(2),
            _ => continue,
        };
        let scene = SESSION.scene(&ViewRequest::of(body.id, time)).expect("a scene");
        let draws =
            scene.draws.iter().filter(|d| d.body == body.id && matches!(d.features.surface, Surface::LunarLambert | Surface::OrenNayar));
        for draw in draws {
            let count = if draw.features.surface == Surface::OrenNayar { &mut roughnesses } else { &mut weights };
            *count += 1;
            assert!((f64::from(draw.uniforms.photometric_parameter) - expected).abs() < 1e-6, "{}", body.name);
        }
    }
    assert!(weights > 0 && roughnesses > 0, "draws with a lunar weight: {weights}, with a roughness: {roughnesses}");
}

/// Mip levels of a cloud map have the mean of this opacity, so it must be the one that the shader computes from a texel.
#[test]
fn the_opacity_of_clouds_agrees_with_the_shader() {
    let texels: Vec<f32> = (0..=255_u8).map(|byte| f32::from(byte) / 255.0).collect();
    let inputs: Vec<EvalInput> = texels.iter().map(|texel| eval_input([f64::from(*texel)])).collect();
    let shader = Emitted::new("cloud.sun1.ellipsoid", "vec4f(cloud_opacity(p.x))");
    let errors = [(0.03, 0.75), (0.2, 0.9)].map(|(clear_texel, closed_texel)| {
        let clouds = CloudUniforms { clear_texel, closed_texel, ..CloudUniforms::default() };
        let results = shader.evaluate(&DrawUniforms { clouds, ..one_light_uniforms() }, None, &inputs);
        let opacity_with = |bounds: OpacityTexels| texels.iter().map(move |texel| f64::from(bounds.opacity(*texel)));
        let other = OpacityTexels::new(clear_texel, 0.5);
        [OpacityTexels::new(clear_texel, closed_texel), other].map(|bounds| greatest_error(&results, opacity_with(bounds)))
    });
    for [same_bounds, other_bounds] in errors {
        assert!(same_bounds < 1e-6, "{same_bounds}");
        assert!(other_bounds > 0.1, "the comparison must be able to fail: {other_bounds}");
    }
}

/// Tolerance 1e-6 of white, a four-thousandth of a level of 255.
#[test]
fn the_display_curve_agrees_with_the_shader() {
    let levels: Vec<f64> = (0..=4000).map(|k| f64::from(k) / 4000.0).collect();
    let inputs: Vec<EvalInput> = levels.iter().map(|v| eval_input([*v])).collect();
    let value = "vec4f(srgb_encoded(p.xxx), 1.0)";
    let error = |module: &Emitted| {
        greatest_error(&module.evaluate(&one_light_uniforms(), None, &inputs), levels.iter().map(|v| linear_to_srgb(*v)))
    };
    let found = error(&Emitted::new("tone_map", value));
    assert!(found < 1e-6, "{found}");
    let found = error(&Emitted::edited("tone_map", value, |text| replace_once(text, "(1.0 / 2.4)", "(1.0 / 2.2)")));
    assert!(found > 1e-3, "{found}");
}
