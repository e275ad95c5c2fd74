//! Effects switched by hand on rendered scenes: each changes only what it may, and an effect that has nothing to do changes nothing.

use crate::support::session::SESSION;
use orrery::catalog::NaifId;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::Scene;
use orrery::scene::draw::{Air, Eclipse, Part};
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

fn over(target: i32, time: &str, radii: f64, towards: Option<i32>) -> ViewRequest {
    request(target, time, Position::Over { towards: towards.map(NaifId), distance_radii: Some(radii) })
}

fn pixels(scene: &Scene) -> Pixels {
    let plan = plan::plan(scene, &*SESSION, SAMPLING).expect("a plan");
    SESSION.renderer().render(&plan, SESSION.library(), true).expect("drawn").0.hdr
}

/// The same view under two sets of effects and one exposure.
fn both(request: &ViewRequest, with: &str, without: &str, stops: f64) -> (Scene, Pixels, Pixels) {
    let of = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("effects");
        SESSION.scene(&ViewRequest { effects, exposure: ExposureRequest::Stops(stops), ..request.clone() }).expect("a scene")
    };
    let (one, other) = (of(with), of(without));
    let pictures = (pixels(&one), pixels(&other));
    (one, pictures.0, pictures.1)
}

/// Cosine from the ground under a pixel's middle to a direction in the body's axes; `None` beside the disc.
fn cosine(scene: &Scene, body: i32, at: usize, direction: glam::DVec3) -> Option<f64> {
    let seen = scene.body(NaifId(body)).expect("in the catalog");
    let middle = glam::DVec2::new((at as u32 % SIDE) as f64 + 0.5, (at as u32 / SIDE) as f64 + 0.5);
    let hit = scene.camera.surface_under_pixel(&seen.placement, middle)?;
    Some((hit / seen.placement.radii_km).normalize().dot(direction))
}

fn sunward(scene: &Scene, body: i32) -> glam::DVec3 {
    let p = scene.body(NaifId(body)).expect("in the catalog").sub_solar.expect("lit");
    let (lat, lon) = (p.latitude_deg.to_radians(), p.longitude_deg.to_radians());
    glam::DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
}

/// Where two pictures differ by any bit.
fn changed(a: &Pixels, b: &Pixels) -> Vec<usize> {
    (0..a.len()).filter(|k| a[*k].map(f32::to_bits) != b[*k].map(f32::to_bits)).collect()
}

/// Asserts that an effect of the Earth changes something, and only pixels whose Sun stands between two cosines.
fn only_between(request: &ViewRequest, others: &str, effect: &str, stops: f64, sun: std::ops::RangeInclusive<f64>) {
    let (scene, with, without) = both(request, others, &format!("{others},-{effect}"), stops);
    let towards = sunward(&scene, 399);
    let places = changed(&with, &without);
    assert!(!places.is_empty(), "{effect} changes nothing");
    for k in places {
        // A pixel on the limb has its middle beside the disc or just inside: its Sun is not known.
        let Some(cosine) = cosine(&scene, 399, k, towards) else { continue };
        assert!(
            sun.contains(&cosine),
            "{effect} changes pixel {},{}, where the Sun's cosine is {cosine}",
            k as u32 % SIDE,
            k as u32 / SIDE
        );
    }
    // Two pixels beyond the limb nothing of the ground is left.
    let edge = |k: usize| {
        (0..9).any(|n| {
            cosine(&scene, 399, (k + n % 3 + (n / 3) * SIDE as usize).saturating_sub(1 + SIDE as usize).min(with.len() - 1), towards)
                .is_some()
        })
    };
    for k in changed(&with, &without) {
        assert!(edge(k), "{effect} changes pixel {k} beside the disc");
    }
}

#[test]
fn ground_effects_change_their_side_of_the_earth_alone() {
    // A quarter Earth: both sides are seen.
    let quarter = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    let bare = "-atmosphere,-clouds,-cloud-shadow,-eclipse,-planet-shine";
    only_between(&quarter, &format!("{bare},-normal"), "specular", 0.0, -0.02..=1.0);
    // Relief: 2.9 degrees to either side of the horizon.
    only_between(&quarter, &format!("{bare},-specular"), "normal", 0.0, -0.06..=1.0);
    only_between(&quarter, "-atmosphere,-clouds,-eclipse,-planet-shine,-normal,+cloud-shadow", "cloud-shadow", 0.0, -0.02..=1.0);
    only_between(&quarter, &format!("{bare},-normal,-specular"), "albedo", 0.0, -0.02..=1.0);
    // City lights, at the exposure of a night: they go on in twilight.
    only_between(&quarter, &format!("{bare},-normal,+night"), "night", 14.0, -1.0..=0.06);
}

#[test]
fn clouds_and_air_change_nothing_beyond_their_shells() {
    let earth = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    for (others, effect, shell) in [("-atmosphere", "clouds", 1.01), ("-clouds", "atmosphere", 1.04)] {
        let (scene, with, without) = both(&earth, others, &format!("{others},-{effect}"), 0.0);
        let body = scene.body(NaifId(399)).expect("the Earth");
        let wide = orrery::scene::camera::Placement { radii_km: body.placement.radii_km * shell, ..body.placement };
        let places = changed(&with, &without);
        assert!(places.len() > 100, "{effect}: {} pixels", places.len());
        for k in places {
            let (x, y) = ((k as u32 % SIDE) as f64 + 0.5, (k as u32 / SIDE) as f64 + 0.5);
            let reached = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (0.0, 0.0)]
                .iter()
                .any(|(dx, dy)| scene.camera.surface_under_pixel(&wide, glam::DVec2::new(x + dx, y + dy)).is_some());
            assert!(reached, "{effect} changes {x},{y}, outside of its shell");
        }
    }
}

/// The Earth stands in the Moon's sky on one side only; on the lit part of that side its light is lost beside the Sun's.
#[test]
fn earthshine_falls_where_the_earth_is_up() {
    let young = over(301, "2024-05-09T20:00:00Z", 8.0, None);
    let young = ViewRequest { position: Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(8.0) }, ..young };
    for view in [young.clone(), over(301, "2024-05-09T20:00:00Z", 8.0, Some(399))] {
        let (scene, with, without) = both(&view, "+planet-shine,-normal", "-planet-shine,-normal", 0.0);
        let moon = scene.body(NaifId::MOON).expect("the Moon");
        let earth = scene.body(NaifId::EARTH).expect("the Earth");
        let towards = (moon.placement.body_from_icrf * (earth.placement.centre_km - moon.placement.centre_km)).normalize();
        for k in changed(&with, &without) {
            let Some(up) = cosine(&scene, 301, k, towards) else { continue };
            // Two lights at the most: the other planets' are too weak to be told from none.
            assert!(up > -0.02 || (with[k][1] - without[k][1]).abs() < 1e-7, "the Earth's cosine is {up}");
            let cos_sun = cosine(&scene, 301, k, sunward(&scene, 301)).unwrap_or(0.0);
            assert!(cos_sun < 0.1 || with[k][1] < without[k][1] * 1.002, "{} by day", with[k][1] / without[k][1]);
        }
    }
    let (_, with, without) = both(&over(301, "2024-05-09T20:00:00Z", 8.0, Some(399)), "+planet-shine", "-planet-shine", 0.0);
    assert!(changed(&with, &without).len() > 500, "the dark side glows");
}

/// The Earth at full phase shines on the Moon with V = -3.99 + 5 log10(384400 km / 1 au) = -16.94 (Mallama and Hilton 2018, Astronomy and Computing
/// 25, 10), 9.82 magnitudes below the Sun's -26.76: 1.18e-4 of its light. On 9 May 2024 its phase angle is 23 degrees, which takes a quarter to a third
/// (Lambert's 0.87 to measured 0.65). Seen along the light, the ground turns it back as it does the Sun's at full Moon.
#[test]
fn earthshine_is_a_ten_thousandth_of_moonshine() {
    for radii in [221.0, 60.0] {
        let middle = |time: &str| {
            let from_earth =
                Position::Offset { body: NaifId::MOON, offset_km: glam::DVec3::new(radii * 1737.4, 0.0, 0.0), axes: Axes::BodyFixed };
            let effects = EffectOverrides::parse("+planet-shine,-normal").expect("effects");
            let base = request(301, time, from_earth);
            let exposure = ExposureRequest::Stops(0.0);
            let moon = ViewRequest { fov_deg: Some(100.0 / radii), effects, exposure, width: 65, height: 65, ..base };
            let scene = SESSION.scene(&moon).expect("a scene");
            f64::from(pixels(&scene)[32 * 65 + 32][1])
        };
        let ratio = middle("2024-05-09T20:00:00Z") / middle("2024-05-23T13:53:00Z");
        assert!((0.6e-4..1.15e-4).contains(&ratio), "{ratio:e} from {radii} radii");
    }
}

/// Occluders beside the Sun leave every bit of the light.
#[test]
fn an_eclipse_out_of_reach_is_none() {
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
        for place in &mut draw.uniforms.eclipse.places {
            place.x += 1000.0;
            moved += 1;
        }
        plain.features.eclipse = Eclipse::default();
    }
    assert!(moved > 0, "the Moon is there");
    let (near, far, none) = (pixels(&near), pixels(&far), pixels(&none));
    assert!(changed(&far, &none).is_empty(), "{} pixels", changed(&far, &none).len());
    assert!(changed(&near, &none).len() > 100, "the true eclipse shows");
}

/// Air without density is no air: within the last bits, since it takes its way through the exponential of nothing.
#[test]
fn air_of_no_density_is_no_air() {
    let earth = over(399, "2024-06-14T06:00:00Z", 3.0, Some(301));
    let effects = EffectOverrides::parse("-clouds,-cloud-shadow").expect("effects");
    let air = SESSION.scene(&ViewRequest { effects, exposure: ExposureRequest::Stops(0.0), ..earth }).expect("a scene");
    let (mut thin, mut none) = (air.clone(), air.clone());
    for draw in &mut thin.draws {
        let a = &mut draw.uniforms.air;
        for part in [
            &mut a.rayleigh_scattering,
            &mut a.rayleigh_extinction,
            &mut a.mie_scattering,
            &mut a.mie_extinction,
            &mut a.absorption_extinction,
        ] {
            *part = glam::Vec3::ZERO;
        }
        a.multi_scatter = Arc::new(a.multi_scatter.iter().map(|_| glam::Vec4::ZERO).collect());
    }
    none.draws.retain(|d| d.part != Part::Sky);
    none.draws.iter_mut().for_each(|d| d.features.air = Air::default());
    let (air, thin, none) = (pixels(&air), pixels(&thin), pixels(&none));
    let apart = |a: &Pixels, b: &Pixels| a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
    assert!(apart(&thin, &none) < 2e-6, "{}", apart(&thin, &none));
    assert!(apart(&air, &none) > 0.05, "air of true density shows");
}

/// From over the pole a long lens sees the globe within the rings alone.
#[test]
fn rings_outside_the_frame_change_nothing() {
    let time = "2017-05-17T00:00:00Z";
    let over_pole = Position::Offset { body: NaifId(699), offset_km: glam::DVec3::new(0.0, 0.0, 4.0 * 60_268.0), axes: Axes::BodyFixed };
    let view = |fov_deg: f64| ViewRequest { fov_deg: Some(fov_deg), look: Look::Target, ..request(699, time, over_pole) };
    let shadows = "-ring-shadow,-body-shadow,-planet-shine";
    let (_, with, without) = both(&view(18.0), shadows, &format!("{shadows},-rings"), 6.0);
    assert!(changed(&with, &without).is_empty(), "{} pixels", changed(&with, &without).len());
    let (_, with, without) = both(&view(60.0), shadows, &format!("{shadows},-rings"), 6.0);
    assert!(changed(&with, &without).len() > 500, "a wide lens sees them");
}
