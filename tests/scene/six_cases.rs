//! The original engine's six cases, seen from outside: what is on the picture, and what stands in the HLSL that draws it and what does not.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::Part;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Position, ViewRequest};
use orrery::shader::ModuleId;
use orrery::shader::key::ShaderKey;
use orrery::shader::translate::{Language, translate};
use orrery::time::Instant;

const SIDE: u32 = 96;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 4 };

/// What is in the code of no body that needs no more than its map and sunlight.
const MORE: [&str; 7] = [
    "eclipse_light(",
    "ring_shadow_transmittance(",
    "planet_shadow_transmittance(",
    "air_before(",
    "sunlight_through_clouds(",
    "night_lights_on(",
    "ring_shine(",
];

/// A body as it is seen from a side, and the linear light of its picture.
struct Case {
    scene: Scene,
    light: Vec<[f32; 4]>,
}

fn case(target: i32, time: &str, from: Option<i32>, radii: f64, effects: &str) -> Case {
    let position = Position::Over { towards: from.map(NaifId), distance_radii: Some(radii) };
    let effects = EffectOverrides::parse(effects).expect("effects");
    let of = ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time"));
    let scene = SESSION.scene(&ViewRequest { position, effects, width: SIDE, height: SIDE, fov_deg: Some(45.0), ..of }).expect("a scene");
    let plan = plan::plan(&scene, &*SESSION, SAMPLING).expect("a plan");
    let light = SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn").0.hdr;
    Case { scene, light }
}

impl Case {
    /// The HLSL of a part of a body, if that is drawn.
    fn hlsl(&self, body: i32, part: Part) -> Option<String> {
        let draw = self.scene.draws.iter().find(|d| d.body == NaifId(body) && d.part == part)?;
        let module = SESSION.library().get(&ModuleId::Planet(ShaderKey::for_draw(&draw.features))).expect("a module");
        Some(translate(&module, Language::Hlsl).expect("HLSL"))
    }
    fn globe(&self, body: i32) -> String {
        self.hlsl(body, Part::Globe).expect("the globe is drawn")
    }
    /// Green light of a pixel, from the middle in parts of the picture's half.
    fn at(&self, x: f64, y: f64) -> f32 {
        let place = |v: f64| ((0.5 + 0.5 * v) * f64::from(SIDE)) as u32;
        self.light[(place(y) * SIDE + place(x)) as usize][1]
    }
    fn sum(&self) -> f64 {
        self.light.iter().map(|p| f64::from(p[1])).sum()
    }
}

fn has(code: &str, some: &[&str]) {
    for name in some {
        assert!(code.contains(name), "{name} is missing");
    }
}

fn lacks(code: &str, some: &[&str]) {
    for name in some {
        assert!(!code.contains(name), "{name} is there");
    }
}

#[test]
fn the_sun_shines_by_itself() {
    let sun = case(10, "2024-04-08T18:17:16Z", Some(399), 4.0, "");
    let code = sun.globe(10);
    has(&code, &["limb_darkening("]);
    lacks(&code, &["light_direction", "light_irradiance", "irradiance_on(", "reflected("]);
    lacks(&code, &MORE);
    // Darker towards the limb: the quadratic law leaves about half of the light at nine tenths of the radius and more in the middle.
    let radius = 1.0 / (4.0_f64.powi(2) - 1.0).sqrt() / 22.5_f64.to_radians().tan();
    assert!(sun.at(0.93 * radius, 0.0) < 0.8 * sun.at(0.0, 0.0) && sun.at(0.93 * radius, 0.0) > 0.2 * sun.at(0.0, 0.0));
}

#[test]
fn mercury_has_its_map_and_sunlight_and_nothing_more() {
    // At its greatest elongation: half of it is lit for the Earth.
    let time = "2024-03-24T22:00:00Z";
    let mercury = case(199, time, Some(399), 4.0, "-glow");
    let code = mercury.globe(199);
    has(&code, &["light_direction", "reflectance(", "albedo_map"]);
    lacks(&code, &MORE);
    assert_eq!(mercury.scene.draws.iter().filter(|d| d.body == NaifId(199)).count(), 1, "one draw");
    // Its night is black.
    let lit = |c: &Case| c.light.iter().filter(|p| p[1] > 0.0).count();
    let (part, whole) = (lit(&mercury), lit(&case(199, time, Some(10), 4.0, "-glow")));
    assert!(part > whole / 3 && part < whole * 2 / 3, "{part} of {whole} pixels are lit");
}

#[test]
fn the_earth_without_clouds_has_air() {
    let [with, without] = ["-clouds", "-clouds,-atmosphere"].map(|e| case(399, "2024-06-08T18:17:16Z", Some(10), 1.3, e));
    let code = with.globe(399);
    has(&code, &["air_before("]);
    // Seen from the Sun there is no night.
    lacks(&code, &["sunlight_through_clouds(", "eclipse_light(", "night_lights_on("]);
    lacks(&without.globe(399), &["air_before("]);
    assert!(with.hlsl(399, Part::Clouds).is_none() && with.hlsl(399, Part::Sky).is_some() && without.hlsl(399, Part::Sky).is_none());
    // From so near its rim is wider than half a pixel; the light of the air is blue.
    let blue = |c: &Case| c.light.iter().map(|p| f64::from(p[2]) - f64::from(p[0])).sum::<f64>();
    assert!(blue(&with) > blue(&without) + 10.0, "{} and {}", blue(&with), blue(&without));
}

#[test]
fn the_earth_with_clouds_is_brighter_and_they_throw_shadows() {
    let [with, without] = ["+cloud-shadow", "-clouds"].map(|e| case(399, "2024-06-08T18:17:16Z", Some(10), 4.0, e));
    has(&with.globe(399), &["sunlight_through_clouds("]);
    has(&with.hlsl(399, Part::Clouds).expect("a shell"), &["cloud_opacity("]);
    lacks(&without.globe(399), &["sunlight_through_clouds("]);
    assert!(with.sum() > 1.2 * without.sum(), "{} and {}", with.sum(), without.sum());
}

#[test]
fn the_moon_is_darkened_by_the_earth() {
    let half = "2022-11-08T09:45:00Z";
    let [with, without] = ["", "-eclipse"].map(|e| case(301, half, Some(399), 4.0, e));
    has(&with.globe(301), &["eclipse_light("]);
    lacks(&without.globe(301), &["eclipse_light("]);
    // Half of it in the umbra, the other half deep in the penumbra.
    assert!(with.sum() < 0.2 * without.sum() && with.sum() > 0.01 * without.sum(), "{} of {}", with.sum(), without.sum());
    // A week later nothing stands before the Sun.
    let later = case(301, "2022-11-15T09:45:00Z", Some(399), 4.0, "");
    lacks(&later.globe(301), &["eclipse_light("]);
}

#[test]
fn saturn_and_its_ring_shade_each_other() {
    // From the side of Uranus, aside of the Sun's, so that the shadow on the ring is seen beside the globe.
    let time = "2017-05-17T00:00:00Z";
    let [all, no_ring_shadow, no_body_shadow] =
        ["-ring-shine", "-ring-shine,-ring-shadow", "-ring-shine,-body-shadow"].map(|e| case(699, time, Some(799), 5.0, e));
    let ring = |c: &Case| c.hlsl(699, Part::Ring).expect("the ring is drawn");
    has(&all.globe(699), &["ring_shadow_transmittance("]);
    has(&ring(&all), &["planet_shadow_transmittance("]);
    lacks(&no_ring_shadow.globe(699), &["ring_shadow_transmittance("]);
    lacks(&ring(&no_body_shadow), &["planet_shadow_transmittance("]);
    assert!(no_ring_shadow.sum() > 1.005 * all.sum(), "{} and {}", no_ring_shadow.sum(), all.sum());
    assert!(no_body_shadow.sum() > 1.005 * all.sum(), "{} and {}", no_body_shadow.sum(), all.sum());
}
