//! An image of linear light includes effects that a display would not show. An image with the automatically selected effects is compared with one
//! with all effects: no pixel may differ by more than the threshold for linear light.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, Purpose, ViewRequest};
use orrery::time::Instant;

/// The threshold of [`Purpose::LINEAR`] for lit pixels, as a fraction of their light.
const RELATIVE_THRESHOLD: f32 = 1e-3;
const IO: NaifId = NaifId(501);
const JUPITER: NaifId = NaifId(599);
const TITAN: NaifId = NaifId(606);
const SATURN: NaifId = NaifId(699);
const URANUS: NaifId = NaifId(799);
const ALL_EFFECTS: &str =
    "+planet-shine,+night,+clouds,+cloud-shadow,+normal,+specular,+rings,+ring-shadow,+ring-shine,+body-shadow,+eclipse,+ellipsoid";

fn draw_pixels(request: &ViewRequest, purpose: Purpose, effects: &str, stops: f64) -> Vec<[f32; 4]> {
    let effects = EffectOverrides::parse(effects).expect("effects");
    let request = ViewRequest { purpose, effects, exposure: ExposureRequest::Stops(stops), ..request.clone() };
    SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
}

/// The greatest difference between channels of two images, relative to the larger of the two values.
fn greatest_relative_difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let relative = |(p, q): (&f32, &f32)| if p == q { 0.0 } else { (p - q).abs() / p.abs().max(q.abs()) };
    a.iter().zip(b).flat_map(|(p, q)| p[..3].iter().zip(&q[..3])).map(relative).fold(0.0, larger)
}

fn views() -> Vec<(&'static str, ViewRequest)> {
    let view = |target, time: &str, position, fov_deg| {
        let time = Instant::parse(time).expect("a time");
        ViewRequest { position, fov_deg, width: 48, height: 48, ..ViewRequest::of(target, time) }
    };
    let from_earth = Position::Centre(NaifId::EARTH);
    // Above the side that faces the body `towards`.
    let above_side = |towards, distance_radii| Position::AboveTarget { towards: Some(towards), distance_radii: Some(distance_radii) };
    vec![
        ("earthshine", view(NaifId::MOON, "2024-04-10T18:21:00Z", from_earth, None)),
        ("half Moon", view(NaifId::MOON, "2024-04-15T19:00:00Z", from_earth, None)),
        ("new Moon", view(NaifId::MOON, "2024-05-08T03:00:00Z", above_side(NaifId::EARTH, 8.0), Some(20.0))),
        ("the Earth's night", view(NaifId::EARTH, "2024-04-08T18:17:16Z", above_side(JUPITER, 3.0), None)),
        ("a small Earth", view(NaifId::EARTH, "2024-04-08T18:17:16Z", above_side(NaifId::MOON, 60.0), None)),
        ("Jupiter from a moon", view(JUPITER, "2024-12-07T20:00:00Z", above_side(IO, 6.0), None)),
        ("Io's night", view(IO, "2024-12-07T20:00:00Z", above_side(JUPITER, 4.0), None)),
        ("Saturn's night", view(SATURN, "2013-07-19T21:27:00Z", above_side(TITAN, 8.0), None)),
        ("Uranus and its rings", view(URANUS, "2024-04-08T18:17:16Z", above_side(NaifId::EARTH, 4.0), None)),
    ]
}

#[test]
fn linear_light_is_complete_at_any_exposure() {
    let mut displays_without_effects = 0;
    for (name, request) in views() {
        for stops in [-10.0, 5.0] {
            let all = draw_pixels(&request, Purpose::LINEAR, ALL_EFFECTS, stops);
            let automatic = draw_pixels(&request, Purpose::LINEAR, "", stops);
            let difference = greatest_relative_difference(&automatic, &all);
            assert!(difference <= RELATIVE_THRESHOLD, "{name} at {stops} stops: {difference:e}, {RELATIVE_THRESHOLD:e} allowed");
            // Negative control: many images for display leave out effects that they would not show.
            displays_without_effects +=
                usize::from(greatest_relative_difference(&draw_pixels(&request, Purpose::Display, "", stops), &all) > RELATIVE_THRESHOLD);
        }
    }
    assert!(displays_without_effects > 8, "only {displays_without_effects} images for display leave out effects");
}

/// In an EXR written by the program, the Moon's night side is lit by the Earth; without planet-shine it is black.
#[test]
fn earthshine_is_in_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    // How many pixels of the disc are exactly 0, and how many pixels it has.
    let dark_and_all = |effects: &[&str]| {
        let path = folder.path().join(format!("{}.exr", effects.len()));
        let view = ["render", "--target", "moon", "--from", "earth", "--time", "2024-04-10T18:21:00Z", "--size", "64x64"];
        let mut program = std::process::Command::new(crate::support::program::path());
        let output = program.args(view).args(effects).args(["--renderer", "software", "-o"]).arg(&path).output().expect("runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let image = image::open(&path).expect("an EXR").into_rgb32f();
        let on_disc = (0..64u32).flat_map(|y| (0..64u32).map(move |x| (x, y))).filter(|(x, y)| {
            let (dx, dy) = (f64::from(*x) - 31.5, f64::from(*y) - 31.5);
            dx.hypot(dy) < 22.0
        });
        let (mut dark, mut pixels) = (0, 0);
        for (x, y) in on_disc {
            dark += usize::from(image.get_pixel(x, y).0.iter().all(|v| *v == 0.0));
            pixels += 1;
        }
        (dark, pixels)
    };
    let (dark, pixels) = dark_and_all(&[]);
    assert!(pixels > 1000 && dark == 0, "{dark} of {pixels} pixels of the disc are exactly 0");
    let (dark, _) = dark_and_all(&["--effects=-planet-shine"]);
    assert!(dark > pixels / 2, "without planet-shine only {dark} of {pixels} pixels of the disc are exactly 0");
}

/// The GPU stores linear light as half floats, which end at 65,504. The brightest granules of the Sun's disc would exceed this in blue, so the shader limits
/// their light. With the glare added, every value must still fit.
#[test]
fn the_suns_disc_fits_into_half_floats() {
    let time = Instant::parse("2025-01-01T00:00:00Z").expect("a time");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(3.0) };
    let request = ViewRequest { position, fov_deg: Some(45.0), width: 256, height: 256, ..ViewRequest::of(NaifId::SUN, time) };
    let brightest = draw_pixels(&request, Purpose::LINEAR, "", 0.0).iter().flat_map(|p| &p[..3]).copied().fold(0.0, larger);
    assert!((62_000.0..=65_504.0).contains(&brightest), "{brightest}");
}
