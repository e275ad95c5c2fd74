//! Antialiased limbs in front of the Sun's disc: its light in an image is that of the part that nearer bodies leave visible. Tested for a
//! disc, for the point that replaces a small disc, and for sizes near the transition; a hidden Sun gives no light.

use crate::support::folds::larger;
use crate::support::session::{SESSION, session_over};
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::probe::Prober;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;
use serde_json::json;
use std::sync::LazyLock;

static RENDERER: LazyLock<SoftwareRenderer> = LazyLock::new(|| SoftwareRenderer::new(Options::default()).expect("a renderer"));

/// A session in which the occluders are shrunk to a radius of 1 m, so that nothing hides the Sun.
static UNOBSTRUCTED: LazyLock<Session> = LazyLock::new(|| {
    let folder = crate::support::scratch::folder("limbs");
    std::fs::create_dir_all(&folder).expect("a folder");
    let shrunk = |(id, name): &(i32, &str)| format!("[[body]]\nid = {id}\nname = \"{name}\"\nradii_km = [0.001, 0.001, 0.001]\n");
    std::fs::write(folder.join("small.toml"), OCCLUDERS.iter().map(shrunk).collect::<String>()).expect("written");
    session_over(&folder).0
});

const OCCLUDERS: [(i32, &str); 4] = [(301, "Moon"), (501, "Io"), (499, "Mars"), (299, "Venus")];

/// A camera behind a body whose disc appears approximately `k` times as large as the Sun's. Its centre is `d` solar radii from the Sun's,
/// at a position angle in radians. The Sun is in the middle of the image, with a radius of `radius_px`.
fn view_from_behind(body: i32, k: f64, d: f64, position_angle: f64, radius_px: f64, size: u32) -> ViewRequest {
    let time = Instant::parse("2024-04-16T18:00:00Z").expect("a time");
    let id = NaifId(body);
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, id, time, None).expect("the Sun").state.pos_km;
    let [radius_km, sun_radius_km] = [id, NaifId::SUN].map(|id| SESSION.catalog().body(id).expect("a body").radii_km.x);
    let sun_direction = to_sun.normalize();
    // From radius_km / distance_km = k * sun_radius_km / (distance_km + distance from the body to the Sun).
    let distance_km = radius_km * to_sun.length() / (k * sun_radius_km - radius_km);
    let sun_angle = sun_radius_km / (to_sun.length() + distance_km);
    let sideways = sun_direction.any_orthonormal_vector();
    let sideways = sideways * position_angle.cos() + sun_direction.cross(sideways) * position_angle.sin();
    let offset_km = -sun_direction * distance_km + sideways * (d * sun_angle * distance_km);
    let tangent = sun_angle.asin().tan() * f64::from(size) / (2.0 * radius_px);
    ViewRequest {
        target: Some(NaifId::SUN),
        position: Position::Offset { body: id, offset_km, axes: Axes::Icrf },
        look: Look::Target,
        width: size,
        height: size,
        fov_deg: Some(2.0 * tangent.atan().to_degrees()),
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse("-glow,-corona,-planet-shine,-atmosphere,-clouds").expect("effects"),
        ..ViewRequest::of(NaifId::SUN, time)
    }
}

/// The sum of an image's pixels per channel, and the image.
fn light(session: &Session, request: &ViewRequest, samples: u8) -> ([f64; 3], Vec<[f32; 4]>) {
    let (_, plan) = session.plan(request, SamplingQuality { samples, anisotropy: 1 }).expect("a plan");
    let hdr = RENDERER.render(&plan, session.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
    ([0, 1, 2].map(|c| hdr.iter().map(|p| f64::from(p[c])).sum()), hdr)
}

/// Apparent radius of the occluder and distance of the centres (k and d), in solar radii.
fn apparent_geometry(request: &ViewRequest, body: i32) -> (f64, f64) {
    let scene = SESSION.scene(request).expect("a scene");
    let [sun, occluder] = [NaifId::SUN, NaifId(body)].map(|id| scene.body(id).expect("a body"));
    let angular_radius = |b: &orrery::scene::BodyReport| (b.placement.radii_km.x / b.distance_km).asin();
    let separation = occluder.placement.centre_km.normalize().cross(sun.placement.centre_km.normalize()).length().asin();
    (angular_radius(occluder) / angular_radius(sun), separation / angular_radius(sun))
}

/// Fraction of the Sun's light, per channel, that an occluding disc leaves visible: the disc overlap that eclipses use.
fn visible_fraction(k: f64, d: f64) -> [f64; 3] {
    let prober = Prober { session: &SESSION, renderer: &RENDERER };
    let orrery::catalog::Photometry::Emissive { u1, u2 } = SESSION.catalog().body(NaifId::SUN).expect("the Sun").photometry else {
        panic!("the Sun must be emissive")
    };
    [0, 1, 2].map(|c| {
        let question = json!({"q": "disc-overlap", "k": k, "d": d, "u1": u1[c], "u2": u2[c], "model": "limb-darkened"});
        1.0 - prober.answer(&question.to_string()).expect("an answer")["blocked"].as_f64().expect("a number")
    })
}

/// A uniform disc has no limb darkening: the coefficients change nothing, even those that leave the limb dark (u1 + u2 = 1). They do change a limb-darkened
/// disc.
#[test]
fn the_uniform_disc_does_not_depend_on_limb_darkening() {
    let prober = Prober { session: &SESSION, renderer: &RENDERER };
    for (k, d) in [(0.3, 0.2), (0.9, 0.5), (1.0, 0.0), (1.1, 1.9), (4.0, 3.5)] {
        let blocked_of = |model: &str, u1: f64, u2: f64| {
            let question = json!({"q": "disc-overlap", "k": k, "d": d, "u1": u1, "u2": u2, "model": model});
            prober.answer(&question.to_string()).expect("an answer")["blocked"].as_f64().expect("a number")
        };
        let blocked = |u1: f64, u2: f64| blocked_of("uniform-disc", u1, u2);
        for step in 0..=8 {
            let u1 = f64::from(step) / 8.0;
            assert_eq!(blocked(u1, 1.0 - u1), blocked(0.0, 0.0), "k {k}, d {d}, u1 {u1}");
        }
        let [darkened, plain] = [1.0, 0.0].map(|u1| blocked_of("limb-darkened", u1, 0.0));
        assert_eq!(
            (darkened - plain).abs() > 1e-3,
            d + 1.0 > k,
            "k {k}, d {d}: {darkened} and {plain} of the light of the limb-darkened disc"
        );
    }
}

#[test]
fn the_suns_light_in_an_image_equals_its_visible_fraction() {
    let (mut dark, mut partial, mut worst_disc, mut worst_point) = (0, 0, 0.0_f64, 0.0_f64);
    // Discs larger than the Sun, smaller, nearly equal, and a planet's; from before first contact to totality or annularity.
    for (body, k) in [(301, 1.03), (301, 0.94), (301, 1.6), (301, 1.003), (299, 0.3), (301, 8.0)] {
        for (radius_px, size) in [(0.3, 24), (0.8, 24), (1.4, 24), (2.2, 24), (5.0, 24), (14.0, 48), (40.0, 100)] {
            // Distance of the centres: 0 at the inner contact, 1 at the outer one; 0 itself is moved inside the inner contact by 2 %.
            for (n, fraction) in [1.02, 0.98, 0.8, 0.5, 0.2, 0.04, 0.0].into_iter().enumerate() {
                let inner = f64::abs(k - 1.0);
                let d = inner + fraction * (1.0 + k - inner) - if fraction == 0.0 { 0.02 * inner } else { 0.0 };
                let request = view_from_behind(body, k, d, 0.7 + n as f64, radius_px, size);
                let (k, d) = apparent_geometry(&request, body);
                let expected = visible_fraction(k, d);
                let unobstructed = light(&UNOBSTRUCTED, &request, 1).0;
                for samples in [1, 4] {
                    let (sum, hdr) = light(&SESSION, &request, samples);
                    let found = [0, 1, 2].map(|c| sum[c] / unobstructed[c]);
                    let description =
                        format!("body {body}, k {k:.4}, d {d:.4}, {radius_px} px, {samples} samples: {found:?}, {expected:?}");
                    if d < k - 1.0 {
                        assert!(hdr.iter().all(|p| p[..3] == [0.0; 3]), "{description}");
                        dark += 1;
                        continue;
                    }
                    let error = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, larger);
                    // A point's light comes from the disc overlap. A disc is sampled pixel by pixel, with both limbs approximated by
                    // straight lines.
                    let is_point = radius_px <= 1.0;
                    let bound = if is_point { 5e-3 } else { 0.06 / radius_px + 0.003 };
                    assert!(error < bound, "{description}: off by {error:.5}");
                    let worst = if is_point { &mut worst_point } else { &mut worst_disc };
                    *worst = worst.max(error * if is_point { 1.0 } else { radius_px });
                    partial += usize::from(expected[1] < 0.99);
                }
            }
        }
    }
    println!("points off by {worst_point:e}, discs by {worst_disc:.4} / radius in pixels; {dark} dark, {partial} partial");
    assert!(dark > 20 && partial > 300, "{dark} dark, {partial} partial");
}

/// The eclipse of 8 April 2024 from Dallas, in fields of view from 0.7 to 120 degrees: no sunlight in totality, but some of it half an hour before.
#[test]
fn totality_is_dark_at_any_field_of_view() {
    for (time, is_total) in [("2024-04-08T18:42:38Z", true), ("2024-04-08T18:10:00Z", false)] {
        for fov_deg in [0.7, 2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 120.0] {
            for samples in [1, 4] {
                let request = ViewRequest {
                    position: Position::Ground { body: NaifId::EARTH, latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.1 },
                    fov_deg: Some(fov_deg),
                    width: 160,
                    height: 160,
                    exposure: ExposureRequest::Stops(0.0),
                    effects: EffectOverrides::parse("-glow,-corona,-planet-shine,-atmosphere").expect("effects"),
                    ..ViewRequest::of(NaifId::SUN, Instant::parse(time).expect("a time"))
                };
                let (_, hdr) = light(&SESSION, &request, samples);
                let in_middle_rows = |k: usize| (k / 160).abs_diff(80) < 30;
                let brightest = hdr.iter().enumerate().filter(|(k, _)| in_middle_rows(*k)).map(|(_, p)| p[1]).fold(0.0, larger);
                assert_eq!(
                    (brightest.is_finite(), brightest < 0.01),
                    (true, is_total),
                    "{time}, {fov_deg} degrees, {samples} samples: {brightest}"
                );
            }
        }
    }
}

/// From entirely below the horizon to entirely above it: no light at first, and then never less than before.
#[test]
fn the_sun_rises_smoothly_over_an_airless_horizon() {
    let time = Instant::parse("2024-04-16T18:00:00Z").expect("a time");
    let moon_radius_km = SESSION.catalog().body(NaifId::MOON).expect("the Moon").radii_km.x;
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, NaifId::MOON, time, None).expect("the Sun").state.pos_km;
    let (sun_direction, sideways) = (to_sun.normalize(), to_sun.normalize().any_orthonormal_vector());
    let sun_radius = SESSION.catalog().body(NaifId::SUN).expect("the Sun").radii_km.x / to_sun.length();
    for height_km in [0.05, 20.0, 2000.0] {
        let limb_angle = (moon_radius_km / (moon_radius_km + height_km)).asin();
        let mut before = f64::MAX;
        for step in -6..=6 {
            // Of the Sun's centre above the limb, in radians.
            let altitude = f64::from(step) * 0.25 * sun_radius;
            let angle = limb_angle + altitude;
            let offset_km: DVec3 = (-sun_direction * angle.cos() + sideways * angle.sin()) * (moon_radius_km + height_km);
            let request = ViewRequest {
                position: Position::Offset { body: NaifId::MOON, offset_km, axes: Axes::Icrf },
                // Without relief: mountains are lit while the Sun is still below the horizon.
                effects: EffectOverrides::parse("-glow,-corona,-planet-shine,-atmosphere,-clouds,-normal,-detail").expect("effects"),
                ..view_from_behind(301, 1.5, 0.0, 0.0, 12.0, 48)
            };
            let sum = light(&SESSION, &request, 1).0[1];
            if step <= -5 {
                assert_eq!(sum, 0.0, "{height_km} km, {step}");
            }
            assert!(step == -6 || sum >= before * 0.999, "{height_km} km, {step}: {sum} after {before}");
            assert!(step < 4 || sum > 0.0, "{height_km} km, {step}");
            before = sum;
        }
    }
}
