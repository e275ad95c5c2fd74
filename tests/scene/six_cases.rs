//! The original engine's six cases, seen from outside: the contents of the image, and which functions its HLSL contains and lacks.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::BodyPart;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Position, ViewRequest};
use orrery::shader::ModuleId;
use orrery::shader::key::ShaderKey;
use orrery::shader::translate::{Language, translate};
use orrery::time::Instant;

const SIDE: u32 = 96;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 4 };

/// Functions that are absent from the code of a body that needs only its map and sunlight.
const EXTRA_FUNCTIONS: [&str; 7] = [
    "eclipse_light(",
    "ring_shadow_transmittance(",
    "planet_shadow_transmittance(",
    "air_before(",
    "sunlight_through_clouds(",
    "night_lights_on(",
    "ring_shine(",
];

/// A body seen from a given side, and the linear light of its image.
struct Case {
    scene: Scene,
    light: Vec<[f32; 4]>,
}

fn case(target: i32, time: &str, from: Option<i32>, radii: f64, effects: &str) -> Case {
    let position = Position::Over { towards: from.map(NaifId), distance_radii: Some(radii) };
    let effects = EffectOverrides::parse(effects).expect("effects");
    let base = ViewRequest::of(NaifId(target), Instant::parse(time).expect("a time"));
    let scene = SESSION.scene(&ViewRequest { position, effects, width: SIDE, height: SIDE, fov_deg: Some(45.0), ..base }).expect("a scene");
    let plan = plan::plan(&scene, &*SESSION, SAMPLING).expect("a plan");
    let light = SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn").0.hdr;
    Case { scene, light }
}

impl Case {
    /// The HLSL of one part of a body, if that part is drawn.
    fn hlsl(&self, body: i32, part: BodyPart) -> Option<String> {
        let draw = self.scene.draws.iter().find(|d| d.body == NaifId(body) && d.part == part)?;
        let module = SESSION.library().get(&ModuleId::Planet(ShaderKey::for_draw(&draw.features))).expect("a module");
        Some(translate(&module, Language::Hlsl).expect("HLSL"))
    }
    fn globe(&self, body: i32) -> String {
        self.hlsl(body, BodyPart::Globe).expect("the globe is drawn")
    }
    /// Green light of a pixel; coordinates from the middle, in half sizes of the image.
    fn light_at(&self, x: f64, y: f64) -> f32 {
        let pixel = |v: f64| ((0.5 + 0.5 * v) * f64::from(SIDE)) as u32;
        self.light[(pixel(y) * SIDE + pixel(x)) as usize][1]
    }
    fn sum(&self) -> f64 {
        self.light.iter().map(|p| f64::from(p[1])).sum()
    }
}

fn assert_contains(code: &str, names: &[&str]) {
    for name in names {
        assert!(code.contains(name), "{name} is missing from the code");
    }
}

fn assert_lacks(code: &str, names: &[&str]) {
    for name in names {
        assert!(!code.contains(name), "{name} must not be in the code");
    }
}

#[test]
fn the_sun_emits_light() {
    let sun = case(10, "2024-04-08T18:17:16Z", Some(399), 4.0, "");
    let code = sun.globe(10);
    assert_contains(&code, &["limb_darkening("]);
    assert_lacks(&code, &["light_direction", "light_irradiance", "irradiance_on(", "reflected("]);
    assert_lacks(&code, &EXTRA_FUNCTIONS);
    // Limb darkening: the quadratic law leaves about half of the central light at nine tenths of the radius.
    let radius = 1.0 / (4.0_f64.powi(2) - 1.0).sqrt() / 22.5_f64.to_radians().tan();
    assert!(
        sun.light_at(0.93 * radius, 0.0) < 0.8 * sun.light_at(0.0, 0.0) && sun.light_at(0.93 * radius, 0.0) > 0.2 * sun.light_at(0.0, 0.0)
    );
}

#[test]
fn mercury_has_only_its_map_and_sunlight() {
    // At Mercury's greatest elongation half of the disc is lit as seen from the Earth.
    let time = "2024-03-24T22:00:00Z";
    let mercury = case(199, time, Some(399), 4.0, "-glow");
    let code = mercury.globe(199);
    assert_contains(&code, &["light_direction", "reflectance(", "albedo_map"]);
    assert_lacks(&code, &EXTRA_FUNCTIONS);
    assert_eq!(mercury.scene.draws.iter().filter(|d| d.body == NaifId(199)).count(), 1, "one draw");
    // The night side is black.
    let lit_pixels = |c: &Case| c.light.iter().filter(|p| p[1] > 0.0).count();
    let (half_phase, full_phase) = (lit_pixels(&mercury), lit_pixels(&case(199, time, Some(10), 4.0, "-glow")));
    assert!(half_phase > full_phase / 3 && half_phase < full_phase * 2 / 3, "{half_phase} of {full_phase} pixels are lit");
}

#[test]
fn the_earth_without_clouds_has_air() {
    let [with, without] = ["-clouds", "-clouds,-atmosphere"].map(|e| case(399, "2024-06-08T18:17:16Z", Some(10), 1.3, e));
    let code = with.globe(399);
    assert_contains(&code, &["air_before("]);
    // Seen from the Sun there is no night side.
    assert_lacks(&code, &["sunlight_through_clouds(", "eclipse_light(", "night_lights_on("]);
    assert_lacks(&without.globe(399), &["air_before("]);
    assert!(
        with.hlsl(399, BodyPart::Clouds).is_none() && with.hlsl(399, BodyPart::Sky).is_some() && without.hlsl(399, BodyPart::Sky).is_none()
    );
    // From so close, the rim of air is wider than half a pixel, and the air's light is blue.
    let blue_excess = |c: &Case| c.light.iter().map(|p| f64::from(p[2]) - f64::from(p[0])).sum::<f64>();
    assert!(blue_excess(&with) > blue_excess(&without) + 10.0, "{} and {}", blue_excess(&with), blue_excess(&without));
}

#[test]
fn clouds_brighten_the_earth_and_cast_shadows() {
    let [with, without] = ["+cloud-shadow", "-clouds"].map(|e| case(399, "2024-06-08T18:17:16Z", Some(10), 4.0, e));
    assert_contains(&with.globe(399), &["sunlight_through_clouds("]);
    assert_contains(&with.hlsl(399, BodyPart::Clouds).expect("a shell"), &["cloud_opacity("]);
    assert_lacks(&without.globe(399), &["sunlight_through_clouds("]);
    assert!(with.sum() > 1.2 * without.sum(), "{} and {}", with.sum(), without.sum());
}

#[test]
fn the_moon_is_darkened_by_the_earth() {
    let partial_phase = "2022-11-08T09:45:00Z";
    let [with, without] = ["", "-eclipse"].map(|e| case(301, partial_phase, Some(399), 4.0, e));
    assert_contains(&with.globe(301), &["eclipse_light("]);
    assert_lacks(&without.globe(301), &["eclipse_light("]);
    // Half of the Moon is in the umbra, the other half deep in the penumbra.
    assert!(with.sum() < 0.2 * without.sum() && with.sum() > 0.01 * without.sum(), "{} of {}", with.sum(), without.sum());
    // A week later no body is in front of the Sun.
    let later = case(301, "2022-11-15T09:45:00Z", Some(399), 4.0, "");
    assert_lacks(&later.globe(301), &["eclipse_light("]);
}

#[test]
fn saturn_and_its_ring_cast_shadows_on_each_other() {
    // From the direction of Uranus, away from the Sun's, so that the shadow on the ring is visible next to the globe.
    let time = "2017-05-17T00:00:00Z";
    let [all, no_ring_shadow, no_body_shadow] =
        ["-ring-shine", "-ring-shine,-ring-shadow", "-ring-shine,-body-shadow"].map(|e| case(699, time, Some(799), 5.0, e));
    let ring = |c: &Case| c.hlsl(699, BodyPart::Ring).expect("the ring is drawn");
    assert_contains(&all.globe(699), &["ring_shadow_transmittance("]);
    assert_contains(&ring(&all), &["planet_shadow_transmittance("]);
    assert_lacks(&no_ring_shadow.globe(699), &["ring_shadow_transmittance("]);
    assert_lacks(&ring(&no_body_shadow), &["planet_shadow_transmittance("]);
    assert!(no_ring_shadow.sum() > 1.005 * all.sum(), "{} and {}", no_ring_shadow.sum(), all.sum());
    assert!(no_body_shadow.sum() > 1.005 * all.sum(), "{} and {}", no_body_shadow.sum(), all.sum());
}
