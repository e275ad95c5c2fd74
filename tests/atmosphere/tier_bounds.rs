//! The bounds of the air's tiers on rays that nobody chose: new ones in each run, through every air of the catalog and of the reference table, against the
//! adaptive quadrature of tests/support/air_reference.rs. A failure names the ray; ORRERY_SEED draws the same rays again.

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

/// An air as a question of the probe has it.
struct Known {
    name: String,
    question: Value,
    air: Air,
    radius_km: f64,
    /// Brightest channel of the zenith under a Sun at 45 degrees.
    zenith: f64,
}

fn vector(v: &Value) -> DVec3 {
    let at = |k: usize| v[k].as_f64().expect("a number");
    DVec3::new(at(0), at(1), at(2))
}

/// The reference's own reading of the question.
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

fn known(name: String, question: Value) -> Known {
    let (radius_km, air) = air_of(&question);
    let up = DVec3::Z;
    let sun = DVec3::new(FRAC_PI_4.sin(), 0.0, FRAC_PI_4.cos());
    let zenith = air.seen(&Ray { camera: up * (1.0 + 1e-3 / radius_km), along: up, sun }).radiance.max_element();
    assert!(zenith > 0.0, "{name}");
    Known { name, question, air, radius_km, zenith }
}

/// Six airs of the table, and every one of the catalog.
fn all() -> Vec<Known> {
    let table: Value = serde_json::from_str(TABLE).expect("JSON");
    let listed = table["atmospheres"].as_object().expect("a map").iter().map(|(name, a)| known(name.clone(), a.clone()));
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
        Some(known(body.name.clone(), question))
    };
    listed.chain(SESSION.catalog().bodies().iter().filter_map(of_body)).collect()
}

struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn part(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.part()
    }
    fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }
}

/// Kinds of rays that are hard each in its own way.
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

/// Degrees under the horizon of the deepest night.
const NIGHT_DEG: f64 = -18.0;

fn ray(random: &mut Random, family: usize, known: &Known) -> Ray {
    let (up, side) = random.direction().any_orthonormal_pair();
    let (turn, top) = (random.between(0.0, TAU), known.air.top);
    let sun_side = side * turn.cos() + up.cross(side) * turn.sin();
    let raised = |along: DVec3, deg: f64| up * deg.to_radians().sin() + along * deg.to_radians().cos();
    // From a metre to the top.
    let lowest = 1e-3 / known.radius_km;
    let height = lowest * (top / lowest).powf(random.part());
    let inside = up * (1.0 + height);
    let knots: Vec<f64> = known
        .air
        .species
        .iter()
        .filter_map(|s| if let Profile::Triangle { knots } = s.profile { Some(knots) } else { None })
        .flatten()
        .collect();
    match family {
        0 | 1 => {
            let aside = if family == 0 { random.part().sqrt() } else { 1.0 + top * random.part() };
            let away = 1.0 + top + 10f64.powf(random.between(-3.0, 1.0));
            Ray { camera: up * aside - side * (away * away - aside * aside).sqrt(), along: side, sun: random.direction() }
        }
        2 => Ray { camera: inside, along: random.direction(), sun: random.direction() },
        3 => {
            let dip_deg = (1.0 / (1.0 + height)).acos().to_degrees();
            let off_deg = 3.0 * random.between(-1.0, 1.0) * random.part();
            Ray { camera: inside, along: raised(side, off_deg - dip_deg), sun: raised(sun_side, random.between(NIGHT_DEG, 90.0)) }
        }
        4 => {
            let along = if random.part() < 0.7 { up } else { -up };
            Ray { camera: inside, along, sun: raised(sun_side, random.between(NIGHT_DEG, 90.0)) }
        }
        5 => {
            let deg = 100.0 * random.part() * random.part() - 10.0;
            Ray { camera: inside, along: raised(side, deg), sun: raised(sun_side, random.between(-12.0, 2.0)) }
        }
        6 => {
            let knot = if knots.is_empty() { top * random.part() } else { knots[(random.part() * knots.len() as f64) as usize] };
            let low = 1.0 + knot + 0.02 * top * random.between(-1.0, 1.0) * random.part();
            Ray {
                camera: up * low.max(1.0 + lowest) + side * random.between(-0.3, 0.3),
                along: side,
                sun: raised(sun_side, random.between(-12.0, 18.0)),
            }
        }
        7 => Ray { camera: inside, along: random.direction(), sun: raised(sun_side, random.between(NIGHT_DEG, -6.0)) },
        _ => {
            // Just over or under the ground, from near and far.
            let low = 1.0 + 1e-3 * top * random.between(-1.0, 1.0) * random.part();
            let back = (2.0 * top).sqrt() * 10f64.powf(random.between(-1.0, 1.0));
            Ray { camera: up * low - side * back, along: side, sun: raised(sun_side, random.between(NIGHT_DEG, 90.0)) }
        }
    }
}

/// Rays of each family through each air, with what they see.
const RAYS: usize = 5;

struct Asked {
    known: usize,
    family: usize,
    ray: Ray,
    seen: Seen,
}

struct Sweep {
    seed: u64,
    airs: Vec<Known>,
    rays: Vec<Asked>,
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
    for (k, known) in airs.iter().enumerate() {
        for family in 0..FAMILIES.len() {
            for _ in 0..RAYS {
                let ray = ray(&mut random, family, known);
                // A camera under the ground sees no air.
                if ray.camera.length() > 1.0 {
                    let seen = known.air.seen(&ray);
                    rays.extend(seen.in_air.then_some(Asked { known: k, family, ray, seen }));
                }
            }
        }
    }
    Sweep { seed, airs, rays }
});

/// Error of the radiance of each ray, sorted, and the largest of a transmittance, with the rays that have them.
fn errors(tier: &str, precision: Precision) -> (Vec<f64>, f64, String) {
    let sweep = &*SWEEP;
    let renderer = SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer");
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let (mut all, mut through, mut worst) = (Vec::new(), 0.0f64, 0.0f64);
    let mut told = [String::new(), String::new()];
    for asked in &sweep.rays {
        let (known, ray, seen) = (&sweep.airs[asked.known], &asked.ray, &asked.seen);
        let question = json!({ "q": "scatter", "atmosphere": known.question, "cam": ray.camera.to_array(), "dir": ray.along.to_array(),
            "sun": ray.sun.to_array(), "tier": tier });
        let answer = prober.answer(&question.to_string()).expect("an answer");
        let (radiance, transmittance) = (vector(&answer["radiance"]), vector(&answer["transmittance"]));
        assert!(radiance.is_finite() && radiance.min_element() >= 0.0 && transmittance.is_finite(), "{ray:?}: {answer}");
        let error = ((radiance - seen.radiance).abs() / seen.radiance.max(DVec3::splat(tiers::MIN_OF_ZENITH * known.zenith))).max_element();
        let off = (transmittance - seen.transmittance).abs().max_element();
        let tell = || format!("{}, {}, {ray:?}: {radiance} for {}", known.name, FAMILIES[asked.family], seen.radiance);
        if error > worst {
            (worst, told[0]) = (error, tell());
        }
        if off > through {
            (through, told[1]) = (off, tell());
        }
        all.push(error);
    }
    all.sort_by(f64::total_cmp);
    (all, through, format!("seed {}: {told:?}", sweep.seed))
}

/// Of the finest tier without rounding. In f32 the planet's shadow on a steep ray of a kilometre has an edge that is a per cent of the ray off.
const FINEST_IN_F64: f64 = 0.01;

fn holds(tier: AtmosphereModel) {
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
fn vertex_holds_its_bounds_on_new_rays() {
    holds(AtmosphereModel::Vertex);
}

#[test]
fn pixel_8_holds_its_bounds_on_new_rays() {
    holds(AtmosphereModel::Pixel8);
}

#[test]
fn pixel_16_holds_its_bounds_on_new_rays() {
    holds(AtmosphereModel::Pixel16);
}

#[test]
fn pixel_32_holds_its_bounds_on_new_rays() {
    holds(AtmosphereModel::Pixel32);
}

#[test]
fn the_table_scatters_once_within_its_bounds_on_new_rays() {
    holds(AtmosphereModel::Table);
}

/// The quadrature that all is held against, against the table that was computed elsewhere to 1e-8; a tent that is a hundredth wider is seen.
#[test]
fn the_reference_is_the_tables() {
    let table: Value = serde_json::from_str(TABLE).expect("JSON");
    let airs: Vec<Known> = table["atmospheres"].as_object().expect("a map").iter().map(|(n, a)| known(n.clone(), a.clone())).collect();
    let mut wider = table["atmospheres"]["earth_full"].clone();
    wider["species"][2]["half_width_km"] = json!(15.15);
    let wider = air_of(&wider).1;
    let (mut rays, mut apart) = (0, 0.0f64);
    for row in table["rays"].as_array().expect("rays") {
        let ray = Ray { camera: vector(&row["cam"]), along: vector(&row["dir"]), sun: vector(&row["sun"]) };
        let (name, expected) = (row["atm"].as_str().expect("a name"), vector(&row["radiance"]));
        let off = |seen: &Seen| ((seen.radiance - expected).abs() / expected.max(DVec3::splat(1e-12))).max_element();
        let known = airs.iter().find(|k| k.name == name).expect("listed");
        let seen = known.air.seen(&ray);
        assert!(off(&seen) < 1e-8, "{row}: {seen:?}");
        assert_eq!(seen.in_air, !row["segment"].is_null());
        assert_eq!(seen.hits_ground, row["hits_ground"] == true);
        if seen.in_air {
            let through = (seen.transmittance - vector(&row["transmittance"])).abs().max_element();
            assert!(through < 1e-8, "{row}: {through}");
            rays += 1;
        }
        if name == "earth_full" {
            apart = apart.max(off(&wider.seen(&ray)));
        }
    }
    assert!(rays > 150 && apart > 1e-4, "{rays} {apart}");
}
