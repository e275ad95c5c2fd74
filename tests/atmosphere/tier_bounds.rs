//! Error bounds of the air's tiers on random rays: new rays in each run, through every air of the catalog and of the reference table, against the adaptive
//! quadrature of tests/support/air_reference.rs. A failure message names the ray; ORRERY_SEED repeats the same rays.

use crate::support::air_reference::{Air, Phase, Profile, Ray, Seen, Species};
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::probe::Prober;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::scene::draw::AtmosphereModel;
use orrery::scene::tiers;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_4, TAU};
use std::hash::{BuildHasher, Hasher};
use std::sync::LazyLock;

const TABLE: &str = include_str!("../data/rayleigh_reference_public.json");

/// An air, also in the form of a probe question.
struct AirCase {
    name: String,
    question: Value,
    air: Air,
    radius_km: f64,
    /// Radiance of the zenith in its brightest channel, with the Sun 45 degrees up.
    zenith: f64,
}

fn vector(v: &Value) -> DVec3 {
    let at = |k: usize| v[k].as_f64().expect("a number");
    DVec3::new(at(0), at(1), at(2))
}

/// The air of a probe question, parsed for the reference.
fn air_of(question: &Value) -> (f64, Air) {
    let number = |v: &Value| v.as_f64().expect("a number");
    let radius_km = number(&question["planet_radius_km"]);
    let species = |s: &Value| {
        let profile = if s["profile"] == "tent" {
            let (centre, half) = (number(&s["centre_km"]), number(&s["half_width_km"]));
            Profile::Triangle { knots: [centre - half, centre, centre + half].map(|km| km / radius_km) }
        } else {
            Profile::Exponential { height: number(&s["scale_height_km"]) / radius_km }
        };
        let phase = if s["phase"] == "hg" { Phase::HenyeyGreenstein(number(&s["g"])) } else { Phase::Rayleigh };
        let per_radius = |field: &str| s.get(field).map_or(DVec3::ZERO, vector) * (radius_km * 1000.0);
        Species { profile, phase, scattering: per_radius("scattering_per_m"), extinction: per_radius("extinction_per_m") }
    };
    let species = question["species"].as_array().expect("a list").iter().map(species).collect();
    (radius_km, Air { top: number(&question["top_km"]) / radius_km, species })
}

fn air_case(name: String, question: Value) -> AirCase {
    let (radius_km, air) = air_of(&question);
    let up = DVec3::Z;
    let sun = DVec3::new(FRAC_PI_4.sin(), 0.0, FRAC_PI_4.cos());
    let zenith = air.seen(&Ray { camera: up * (1.0 + 1e-3 / radius_km), along: up, sun }).radiance.max_element();
    assert!(zenith > 0.0, "{name}");
    AirCase { name, question, air, radius_km, zenith }
}

/// Six airs of the table and all airs of the catalog.
fn all() -> Vec<AirCase> {
    let table: Value = serde_json::from_str(TABLE).expect("JSON");
    let listed = table["atmospheres"].as_object().expect("a map").iter().map(|(name, a)| air_case(name.clone(), a.clone()));
    let of_body = |body: &orrery::catalog::Body| {
        let air = body.atmosphere.as_ref()?;
        let species: Vec<Value> = air
            .species
            .iter()
            .map(|s| {
                let per_m = |v: [f64; 3]| v.map(|x| x / 1000.0);
                let extinction: [f64; 3] = std::array::from_fn(|k| s.scattering_per_km[k] + s.absorption_per_km[k]);
                match (s.tent_centre_km, s.asymmetry) {
                    (Some(centre), _) => json!({ "profile": "tent", "centre_km": centre, "half_width_km": s.scale_height_km,
                        "extinction_per_m": per_m(extinction) }),
                    (None, g) => json!({ "profile": "exponential", "scale_height_km": s.scale_height_km, "g": g.unwrap_or(0.0),
                        "scattering_per_m": per_m(s.scattering_per_km), "extinction_per_m": per_m(extinction),
                        "phase": if g.is_some() { "hg" } else { "rayleigh" } }),
                }
            })
            .collect();
        let question = json!({ "planet_radius_km": body.radii_km.x, "top_km": air.top_km, "species": species });
        Some(air_case(body.name.clone(), question))
    };
    listed.chain(SESSION.catalog().bodies().iter().filter_map(of_body)).collect()
}

struct Random(u64);

impl Random {
    /// Uniform in 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }
    fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }
}

/// Families of rays, each difficult in a different way.
const FAMILIES: [&str; 9] = [
    "the disc from space",
    "the limb from space",
    "inside, any way",
    "about the horizon",
    "straight up or down",
    "twilight",
    "along the knots",
    "night",
    "tangent",
];

/// Lowest elevation of the Sun, in degrees.
const NIGHT_DEG: f64 = -18.0;

fn ray(random: &mut Random, family: usize, air_case: &AirCase) -> Ray {
    let (up, side) = random.direction().any_orthonormal_pair();
    let (turn, top) = (random.between(0.0, TAU), air_case.air.top);
    let sun_side = side * turn.cos() + up.cross(side) * turn.sin();
    let at_elevation = |along: DVec3, deg: f64| up * deg.to_radians().sin() + along * deg.to_radians().cos();
    // Heights from a metre to the top of the air.
    let lowest = 1e-3 / air_case.radius_km;
    let height = lowest * (top / lowest).powf(random.uniform());
    let inside = up * (1.0 + height);
    let knots: Vec<f64> = air_case
        .air
        .species
        .iter()
        .filter_map(|s| if let Profile::Triangle { knots } = s.profile { Some(knots) } else { None })
        .flatten()
        .collect();
    match family {
        0 | 1 => {
            let impact_radius = if family == 0 { random.uniform().sqrt() } else { 1.0 + top * random.uniform() };
            let camera_distance = 1.0 + top + 10f64.powf(random.between(-3.0, 1.0));
            Ray {
                camera: up * impact_radius - side * (camera_distance * camera_distance - impact_radius * impact_radius).sqrt(),
                along: side,
                sun: random.direction(),
            }
        }
        2 => Ray { camera: inside, along: random.direction(), sun: random.direction() },
        3 => {
            let dip_deg = (1.0 / (1.0 + height)).acos().to_degrees();
            let offset_deg = 3.0 * random.between(-1.0, 1.0) * random.uniform();
            Ray {
                camera: inside,
                along: at_elevation(side, offset_deg - dip_deg),
                sun: at_elevation(sun_side, random.between(NIGHT_DEG, 90.0)),
            }
        }
        4 => {
            let along = if random.uniform() < 0.7 { up } else { -up };
            Ray { camera: inside, along, sun: at_elevation(sun_side, random.between(NIGHT_DEG, 90.0)) }
        }
        5 => {
            let deg = 100.0 * random.uniform() * random.uniform() - 10.0;
            Ray { camera: inside, along: at_elevation(side, deg), sun: at_elevation(sun_side, random.between(-12.0, 2.0)) }
        }
        6 => {
            let knot = if knots.is_empty() { top * random.uniform() } else { knots[(random.uniform() * knots.len() as f64) as usize] };
            let perigee_radius = 1.0 + knot + 0.02 * top * random.between(-1.0, 1.0) * random.uniform();
            Ray {
                camera: up * perigee_radius.max(1.0 + lowest) + side * random.between(-0.3, 0.3),
                along: side,
                sun: at_elevation(sun_side, random.between(-12.0, 18.0)),
            }
        }
        7 => Ray { camera: inside, along: random.direction(), sun: at_elevation(sun_side, random.between(NIGHT_DEG, -6.0)) },
        _ => {
            // Just above or below the ground, from nearby and from far away.
            let perigee_radius = 1.0 + 1e-3 * top * random.between(-1.0, 1.0) * random.uniform();
            let start_distance = (2.0 * top).sqrt() * 10f64.powf(random.between(-1.0, 1.0));
            Ray {
                camera: up * perigee_radius - side * start_distance,
                along: side,
                sun: at_elevation(sun_side, random.between(NIGHT_DEG, 90.0)),
            }
        }
    }
}

/// Number of rays per family and air.
const RAYS: usize = 5;

struct RayCase {
    air_case: usize,
    family: usize,
    ray: Ray,
    seen: Seen,
}

struct Sweep {
    seed: u64,
    airs: Vec<AirCase>,
    rays: Vec<RayCase>,
}

static SWEEP: LazyLock<Sweep> = LazyLock::new(|| {
    let seed = std::env::var("ORRERY_SEED")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or_else(|| std::hash::RandomState::new().build_hasher().finish() >> 32);
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let airs = all();
    assert!(airs.len() >= 16, "{}", airs.len());
    let mut rays = Vec::new();
    for (k, air_case) in airs.iter().enumerate() {
        for family in 0..FAMILIES.len() {
            for _ in 0..RAYS {
                let ray = ray(&mut random, family, air_case);
                // A camera below the ground sees no air.
                if ray.camera.length() > 1.0 {
                    let seen = air_case.air.seen(&ray);
                    rays.extend(seen.in_air.then_some(RayCase { air_case: k, family, ray, seen }));
                }
            }
        }
    }
    Sweep { seed, airs, rays }
});

/// Sorted radiance errors of all rays, the largest transmittance error, and a text that names the worst rays.
fn errors(tier: &str, precision: Precision) -> (Vec<f64>, f64, String) {
    let sweep = &*SWEEP;
    let renderer = SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let (mut all, mut worst_transmittance, mut worst) = (Vec::new(), 0.0f64, 0.0f64);
    let mut worst_rays = [String::new(), String::new()];
    for ray_case in &sweep.rays {
        let (air_case, ray, seen) = (&sweep.airs[ray_case.air_case], &ray_case.ray, &ray_case.seen);
        let question = json!({ "q": "scatter", "atmosphere": air_case.question, "cam": ray.camera.to_array(), "dir": ray.along.to_array(),
            "sun": ray.sun.to_array(), "tier": tier });
        let answer = prober.answer(&question.to_string()).expect("an answer");
        let (radiance, transmittance) = (vector(&answer["radiance"]), vector(&answer["transmittance"]));
        assert!(radiance.is_finite() && radiance.min_element() >= 0.0 && transmittance.is_finite(), "{ray:?}: {answer}");
        let error =
            ((radiance - seen.radiance).abs() / seen.radiance.max(DVec3::splat(tiers::MIN_OF_ZENITH * air_case.zenith))).max_element();
        let transmittance_error = (transmittance - seen.transmittance).abs().max_element();
        let describe = || format!("{}, {}, {ray:?}: {radiance} for {}", air_case.name, FAMILIES[ray_case.family], seen.radiance);
        if error > worst {
            (worst, worst_rays[0]) = (error, describe());
        }
        if transmittance_error > worst_transmittance {
            (worst_transmittance, worst_rays[1]) = (transmittance_error, describe());
        }
        all.push(error);
    }
    all.sort_by(f64::total_cmp);
    (all, worst_transmittance, format!("seed {}: {worst_rays:?}", sweep.seed))
}

/// Bound of the finest tier in f64. In f32 the edge of the planet's shadow on a steep ray of one kilometre is off by a per cent of the ray.
const FINEST_IN_F64: f64 = 0.01;

fn assert_within_bounds_on_new_rays(tier: AtmosphereModel) {
    let stated = tiers::of_atmosphere(tier).expect("a tier");
    for precision in [Precision::F32, Precision::F64] {
        let at_most = if tier == AtmosphereModel::Pixel32 && precision == Precision::F64 { FINEST_IN_F64 } else { stated.at_most };
        let (errors, through, told) = errors(stated.name, precision);
        let (most, worst) = (errors[errors.len() * 95 / 100], errors[errors.len() - 1]);
        println!("{} {precision:?}, {} rays: 95 % {most:.5}, worst {worst:.5}, transmittance {through:.1e}", stated.name, errors.len());
        assert!(errors.len() > 400, "{}", errors.len());
        assert!(most < stated.mostly.expect("told") && worst < at_most, "{stated}, {precision:?}: {most:.5} {worst:.5}; {told}");
        assert!(through < tiers::AIR_TRANSMITTANCE, "{stated}, {precision:?}: transmittance {through:.1e}; {told}");
    }
}

#[test]
fn vertex_keeps_its_bounds_on_new_rays() {
    assert_within_bounds_on_new_rays(AtmosphereModel::Vertex);
}

#[test]
fn pixel_8_keeps_its_bounds_on_new_rays() {
    assert_within_bounds_on_new_rays(AtmosphereModel::Pixel8);
}

#[test]
fn pixel_16_keeps_its_bounds_on_new_rays() {
    assert_within_bounds_on_new_rays(AtmosphereModel::Pixel16);
}

#[test]
fn pixel_32_keeps_its_bounds_on_new_rays() {
    assert_within_bounds_on_new_rays(AtmosphereModel::Pixel32);
}

#[test]
fn the_table_tier_keeps_its_single_scattering_bounds_on_new_rays() {
    assert_within_bounds_on_new_rays(AtmosphereModel::Table);
}

/// Checks the reference quadrature itself against the table that was computed outside this program to 1e-8; an error of a hundredth in the width of a
/// triangular layer must be detected.
#[test]
fn the_reference_agrees_with_the_table() {
    let table: Value = serde_json::from_str(TABLE).expect("JSON");
    let airs: Vec<AirCase> = table["atmospheres"].as_object().expect("a map").iter().map(|(n, a)| air_case(n.clone(), a.clone())).collect();
    let mut wider = table["atmospheres"]["earth_full"].clone();
    wider["species"][2]["half_width_km"] = json!(15.15);
    let wider = air_of(&wider).1;
    let (mut rays, mut apart) = (0, 0.0f64);
    for row in table["rays"].as_array().expect("rays") {
        let ray = Ray { camera: vector(&row["cam"]), along: vector(&row["dir"]), sun: vector(&row["sun"]) };
        let (name, expected) = (row["atm"].as_str().expect("a name"), vector(&row["radiance"]));
        let relative_error = |seen: &Seen| ((seen.radiance - expected).abs() / expected.max(DVec3::splat(1e-12))).max_element();
        let air_case = airs.iter().find(|k| k.name == name).expect("listed");
        let seen = air_case.air.seen(&ray);
        assert!(relative_error(&seen) < 1e-8, "{row}: {seen:?}");
        assert_eq!(seen.in_air, !row["segment"].is_null());
        assert_eq!(seen.hits_ground, row["hits_ground"] == true);
        if seen.in_air {
            let through = (seen.transmittance - vector(&row["transmittance"])).abs().max_element();
            assert!(through < 1e-8, "{row}: {through}");
            rays += 1;
        }
        if name == "earth_full" {
            apart = apart.max(relative_error(&wider.seen(&ray)));
        }
    }
    assert!(rays > 150 && apart > 1e-4, "{rays} {apart}");
}
