//! The light of a disc does not depend on the size of its image: crescents thinner than a pixel, rims of air far lower than a pixel, and the air around a night
//! side.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::BodyPart;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, Purpose, ViewRequest};
use orrery::time::Instant;

/// A body seen so that its disc fills three quarters of the image, whatever its size.
struct View {
    target: NaifId,
    from: Option<NaifId>,
    time: &'static str,
    effects: &'static str,
}

const MOON: View =
    View { target: NaifId::MOON, from: Some(NaifId::EARTH), time: "2024-04-08T06:00:00Z", effects: "-planet-shine,-normal,-detail" };
const VENUS: View = View { target: NaifId(299), from: Some(NaifId::EARTH), time: "2022-01-08T20:00:00Z", effects: "" };
const FULL_EARTH: View = View { target: NaifId::EARTH, from: None, time: "2024-04-08T18:17:16Z", effects: "-clouds" };
const CRESCENT_EARTH: View =
    View { target: NaifId::EARTH, from: Some(NaifId::MOON), time: "2024-03-23T00:00:00Z", effects: "-clouds,-specular" };
const MARS: View = View { target: NaifId(499), from: Some(NaifId(401)), time: "2020-01-01T04:00:00Z", effects: "" };

impl View {
    fn scene(&self, side: u32) -> Scene {
        let request = ViewRequest {
            position: self.from.map_or(Position::AboveTarget { towards: None, distance_radii: None }, Position::Centre),
            effects: EffectOverrides::parse(self.effects).expect("effects"),
            exposure: ExposureRequest::Stops(0.0),
            purpose: Purpose::LINEAR,
            width: side,
            height: side,
            ..ViewRequest::of(self.target, Instant::parse(self.time).expect("a time"))
        };
        let mut scene = SESSION.scene(&request).expect("a scene");
        scene.draws.retain(|d| d.body == self.target);
        assert!(!scene.draws.is_empty(), "{}", self.time);
        scene
    }

    /// The greatest relative change of a channel's light in a small image, against that of a larger one.
    fn worst_change(&self, sides: &[u32], large: u32) -> f64 {
        let reference = light(&self.scene(large));
        let change = |side: &u32| {
            let ratio = light(&self.scene(*side)) / reference;
            println!("{} {side}: {ratio}", self.time);
            (ratio - 1.0).abs().to_array().into_iter().fold(0.0, larger)
        };
        sides.iter().map(change).fold(0.0, larger)
    }
}

/// Mean linear light of the image.
fn light(scene: &Scene) -> DVec3 {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 4 }).expect("a plan");
    let pixels = SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
    let sum: DVec3 = pixels.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).sum();
    sum / pixels.len() as f64
}

/// The same scene with one evaluation for each pixel at the limb.
fn without_averages(scene: &Scene) -> Scene {
    assert!(scene.draws.iter().any(|d| d.features.thin_limb), "no draw averages its limb");
    let mut scene = scene.clone();
    for draw in &mut scene.draws {
        draw.features.thin_limb = false;
    }
    scene
}

#[test]
fn a_thin_crescent_has_the_same_light_at_every_size() {
    let change = MOON.worst_change(&[24, 32, 48, 64, 90, 128, 256], 512);
    assert!(change < 0.08, "{change}");
    // At 64 pixels the crescent is 0.2 pixels wide. One evaluation for each pixel finds a sixth of its light.
    let scene = MOON.scene(64);
    let found = light(&without_averages(&scene)) / light(&scene);
    assert!(found.max_element() < 0.3, "{found}");
}

#[test]
fn a_thin_rim_of_air_has_the_same_light_at_every_size() {
    let change = VENUS.worst_change(&[64, 90, 128, 256, 512], 1024);
    assert!(change < 0.08, "{change}");
    let scene = VENUS.scene(64);
    // One evaluation for each pixel shows a rim of 0.07 pixels as if it were a pixel high.
    let found = light(&without_averages(&scene)) / light(&scene);
    assert!(found.min_element() > 1.5, "{found}");
    // The rim has more than a quarter of the light in each channel, so a scene without it would not have the same light at every size.
    let mut bare = scene.clone();
    bare.draws.retain(|d| d.part != BodyPart::Sky);
    let found = light(&bare) / light(&scene);
    assert!(bare.draws.len() < scene.draws.len() && found.max_element() < 0.75, "{found}");
}

#[test]
fn discs_under_air_have_the_same_light_at_every_size() {
    for (view, bounds) in [
        (FULL_EARTH, [(32, 0.052), (64, 0.02), (128, 0.01)]),
        (CRESCENT_EARTH, [(32, 0.03), (64, 0.035), (128, 0.04)]),
        (MARS, [(48, 0.02), (64, 0.02), (128, 0.01)]),
    ] {
        for (side, bound) in bounds {
            let change = view.worst_change(&[side], 256);
            assert!(change < bound, "{} at {side} pixels: {change} against {bound}", view.time);
        }
        let scene = view.scene(64);
        let mut bare = scene.clone();
        bare.draws.retain(|d| d.part != BodyPart::Sky);
        let rim = 1.0 - light(&bare) / light(&scene);
        println!("{}: the rim has {rim} of the light", view.time);
        assert!(bare.draws.len() < scene.draws.len() && rim.max_element() > 1e-3, "{}: {rim}", view.time);
    }
    // The air over the ground of Mars is drawn whatever the height of the rim: it adds light to each channel, most
    // to blue, which the ground hardly has.
    let ground = View { effects: "-atmosphere", ..MARS };
    let with_air = light(&MARS.scene(48)) / light(&ground.scene(48));
    assert!(with_air.max_element() > 1.1, "{with_air}");
}

/// Mercury's crescent at a phase angle of 150 degrees, just narrower than the widest one that is averaged: no pixel changes by more than 2 levels where
/// averages begin, when a camera approaches or zooms out. Measured in steps of the part of a pixel that is averaged: 3 levels at a fiftieth, 0 at a
/// thousandth; here it is a five hundredth.
#[test]
fn averages_of_a_crescent_begin_gradually() {
    let mercury = NaifId(199);
    let time = Instant::parse("2030-04-03T00:00:00Z").expect("a time");
    let sun_km = SESSION.ephemeris().state(NaifId::SUN, mercury, time, None).expect("a position").state.pos_km;
    let towards_sun = sun_km.normalize();
    let across = towards_sun.cross(DVec3::Z).normalize();
    let phase = 150_f64.to_radians();
    // The disc is 118 pixels wide, so that the crescent is 7.9 pixels wide.
    let (side, fov_deg) = (160, 10_f64);
    let px_per_rad = f64::from(side) / (2.0 * (0.5 * fov_deg.to_radians()).tan());
    let distance_radii = 1.0 / (118.0 / 2.0 / px_per_rad).sin();
    let direction = across * phase.sin() + towards_sun * phase.cos();
    let radius_km = SESSION.catalog().body(mercury).expect("in the catalog").radii_km.x;
    let request = ViewRequest {
        position: Position::Offset { body: mercury, offset_km: direction * (distance_radii * radius_km), axes: Axes::Icrf },
        fov_deg: Some(fov_deg),
        exposure: ExposureRequest::Stops(2.0),
        width: side,
        height: side,
        ..ViewRequest::of(mercury, time)
    };
    let mut scene = SESSION.scene(&request).expect("a scene");
    scene.draws.retain(|d| d.body == mercury);
    let part = scene.draws[0].uniforms.averaged_part;
    assert!(part > 0.0 && part < 0.01, "{part}");
    let levels = |scene: &Scene| {
        let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 1, anisotropy: 4 }).expect("a plan");
        SESSION.renderer().render(&plan, SESSION.library(), FrameImages::Display).expect("drawn").0.display
    };
    let bare = levels(&without_averages(&scene));
    let change = |scene: &Scene| {
        let levels = levels(scene);
        levels.iter().zip(&bare).map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])).max()).max().flatten().expect("pixels")
    };
    let at_limit = change(&scene);
    // Negative control: averages over the entire pixel, without a fade.
    let mut abrupt = scene.clone();
    abrupt.draws.iter_mut().for_each(|d| d.uniforms.averaged_part = 1.0);
    let abrupt = change(&abrupt);
    println!("averages over {part} of a pixel change it by up to {at_limit} levels, over all of it by {abrupt}");
    assert!(at_limit <= 2 && abrupt > 20, "{at_limit} {abrupt}");
}

/// Jupiter's crescent at a phase angle of 150 degrees, a fraction of a pixel wide, for files of linear light. Small moons are in front of the Sun somewhere
/// over Jupiter at most times; their shadows, which change no pixel by more than the floor of linear light, do not keep the crescent from being averaged.
#[test]
fn a_crescent_in_a_file_of_linear_light_has_the_same_light_at_every_size() {
    let jupiter = NaifId(599);
    let scene = |side: u32, hour: u32, effects: &str| {
        let time = Instant::parse(&format!("2024-04-08T{hour:02}:00:00Z")).expect("a time");
        let sun_km = SESSION.ephemeris().state(NaifId::SUN, jupiter, time, None).expect("a position").state.pos_km;
        let towards_sun = sun_km.normalize();
        let across = towards_sun.cross(DVec3::Z).normalize();
        let phase = 150_f64.to_radians();
        let request = ViewRequest {
            position: Position::Offset {
                body: jupiter,
                offset_km: (across * phase.sin() + towards_sun * phase.cos()) * 4e7,
                axes: Axes::Icrf,
            },
            fov_deg: Some(0.3),
            effects: EffectOverrides::parse(effects).expect("effects"),
            exposure: ExposureRequest::Stops(0.0),
            purpose: Purpose::LINEAR,
            width: side,
            height: side,
            ..ViewRequest::of(jupiter, time)
        };
        let mut scene = SESSION.scene(&request).expect("a scene");
        scene.draws.retain(|d| d.body == jupiter);
        scene
    };
    // The light with every shadow that exists, of an image whose crescent is then evaluated at one point of each pixel.
    let with_shadows = |hour: &u32| light(&scene(12, *hour, "+eclipse")).x / light(&scene(12, *hour, "-eclipse")).x;
    let (hour, found) = (0..24).map(|hour| (hour, with_shadows(&hour))).min_by(|a, b| a.1.total_cmp(&b.1)).expect("hours");
    println!("{hour} h: {found} of the light");
    assert!(found < 0.85, "{found}");
    let reference = light(&scene(512, hour, ""));
    for side in [12, 16, 24, 32, 48, 64, 128] {
        let ratio = light(&scene(side, hour, "")) / reference;
        println!("{side} pixels: {ratio}");
        assert!((ratio - 1.0).abs().max_element() < 0.1, "{side} pixels: {ratio}");
    }
}

/// A body between the Sun and the viewer, without the Sun: at 179.3 degrees of phase the Sun is beside the image, at 180 degrees it is behind the disc. Returns
/// a factor, too, from the mean light of the image to a unit that does not depend on its size.
fn backlit(body: NaifId, phase_deg: f64, diameter_px: f64, effects: &str) -> (Scene, f64) {
    let time = Instant::parse("2024-10-10T00:00:00Z").expect("a time");
    let sun_km = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("a position").state.pos_km;
    let towards_sun = sun_km.normalize();
    let across = towards_sun.cross(DVec3::Z).normalize();
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let distance_radii = if phase_deg < 180.0 { 3000.0 } else { 100.0 };
    let radius_km = SESSION.catalog().body(body).expect("in the catalog").radii_km.x;
    let side = 8 * ((0.2 * diameter_px) as u32 + 2);
    let side_per_diameter = f64::from(side) / diameter_px;
    let offset_km = (towards_sun * cos + across * sin) * (distance_radii * radius_km);
    let request = ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some((2.0 * (side_per_diameter / distance_radii).atan()).to_degrees()),
        effects: EffectOverrides::parse(&format!("-planet-shine,-eclipse,-refracted-limb,sun:-glow,sun:-corona{effects}"))
            .expect("effects"),
        exposure: ExposureRequest::Stops(0.0),
        purpose: Purpose::LINEAR,
        width: side,
        height: side,
        ..ViewRequest::of(body, time)
    };
    let mut scene = SESSION.scene(&request).expect("a scene");
    scene.draws.retain(|d| d.body == body);
    (scene, side_per_diameter.powi(2))
}

/// The same of a night side with a rim of air.
fn night_side(body: NaifId, phase_deg: f64, diameter_px: f64) -> (Scene, f64) {
    let (scene, factor) = backlit(body, phase_deg, diameter_px, "");
    assert!(scene.draws.iter().any(|d| d.part == BodyPart::Sky), "{body:?} in {diameter_px} pixels has no rim");
    (scene, factor)
}

/// The crescent Earth with clouds, glint and air, each channel. As the product of two means over a pixel, of the ground's light and of the air's transmittance,
/// and with clouds that cover ground and sky independently, the Earth at 165 to 170 degrees in 8 to 14 pixels had up to 1.4 times its light in red, and in
/// blue at 175 degrees 0.86 times.
#[test]
fn a_crescent_earth_has_the_same_light_at_every_size() {
    for effects in ["", ",-specular", ",-specular,-clouds"] {
        for phase_deg in [150.0, 160.0, 165.0, 168.0, 170.0, 172.0, 175.0] {
            let light_in = |diameter_px: f64| {
                let (scene, factor) = backlit(NaifId::EARTH, phase_deg, diameter_px, effects);
                light(&scene) * factor
            };
            let reference = light_in(512.0);
            for diameter_px in [8.0, 14.0, 24.0, 40.0, 60.0, 128.0] {
                let ratio = light_in(diameter_px) / reference;
                println!("{phase_deg} degrees in {diameter_px} pixels{effects}: {ratio:.3}");
                let worst = (ratio - 1.0).abs().to_array().into_iter().fold(0.0, larger);
                assert!(worst < 0.08, "{phase_deg} degrees in {diameter_px} pixels{effects}: {ratio}");
            }
        }
    }
    // Negative control: one ray for each pixel of ground and clouds.
    let (mut scene, _factor) = backlit(NaifId::EARTH, 170.0, 14.0, "");
    let averaged = light(&scene);
    scene.draws.iter_mut().filter(|d| d.part != BodyPart::Sky).for_each(|d| d.features.thin_limb = false);
    let found = light(&scene) / averaged;
    assert!(found.min_element() > 1.5, "{found}");
}

/// Crescents a tenth of a pixel wide, whose limb is at another place between the pixels in each image. With the coverage of a pixel whose sides are along and
/// across the limb, Mercury had 0.86 to 1.29 times its light, Venus 0.91 to 1.19 times; now at most 1.12 and 1.05 times.
#[test]
fn a_thin_crescent_has_the_same_light_wherever_its_limb_crosses_the_pixels() {
    for body in [NaifId(199), NaifId(299)] {
        let light_in = |diameter_px: f64| {
            let (scene, factor) = backlit(body, 170.0, diameter_px, "");
            light(&scene).element_sum() * factor
        };
        let reference = light_in(512.0);
        for diameter_px in [7.0, 7.4, 7.9, 8.4, 9.0, 9.7, 10.5, 11.4, 12.4, 13.5, 14.7, 16.0] {
            let ratio = light_in(diameter_px) / reference;
            println!("{body:?} in {diameter_px} pixels: {ratio:.3}");
            assert!((0.95..1.14).contains(&ratio), "{body:?} in {diameter_px} pixels: {ratio}");
        }
    }
}

/// All light of these discs comes from air at the limb. With rays of equal weight, without the lengths of the limb in each pixel, Venus in 4.1 pixels would
/// have 1.6 times its light, and the Earth in 6 pixels 0.7 times.
#[test]
fn the_air_around_a_night_side_has_the_same_light_at_every_size() {
    for (body, phase_deg) in
        [(399, 179.3), (399, 180.0), (499, 179.3), (499, 180.0), (606, 179.3), (606, 180.0), (299, 179.3), (999, 179.3)]
    {
        let light_in = |diameter_px: f64| {
            let (scene, factor) = night_side(NaifId(body), phase_deg, diameter_px);
            light(&scene).element_sum() * factor
        };
        let reference = light_in(256.0);
        for diameter_px in [4.1, 5.0, 6.0, 8.0, 12.0, 24.0, 48.0, 96.0] {
            let ratio = light_in(diameter_px) / reference;
            println!("{body} at {phase_deg} degrees in {diameter_px} pixels: {ratio}");
            assert!((0.82..1.18).contains(&ratio), "{body} at {phase_deg} degrees in {diameter_px} pixels: {ratio}");
        }
    }
    // Negative control: with one ray for each pixel of ground and clouds, as if the averages ended at 179 degrees.
    let (mut scene, _factor) = night_side(NaifId::EARTH, 179.3, 5.0);
    let averaged = light(&scene).element_sum();
    let ground = scene.draws.iter_mut().filter(|d| d.part != BodyPart::Sky);
    ground.for_each(|d| d.features.thin_limb = false);
    let found = light(&scene).element_sum() / averaged;
    assert!(found > 4.0, "{found}");
}
