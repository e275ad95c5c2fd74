//! Linear light keeps effects that a display would not show: an image with the automatically selected effects is compared with one with
//! all effects, and no pixel may differ by more than the floor of the request's purpose.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, Purpose, ViewRequest};
use orrery::time::Instant;

/// The relative floor of [`Purpose::LINEAR`].
const FLOOR: f32 = 1e-3;
const ALL_EFFECTS: &str =
    "+planet-shine,+night,+clouds,+cloud-shadow,+normal,+specular,+rings,+ring-shadow,+ring-shine,+body-shadow,+eclipse,+ellipsoid";

fn pixels(request: &ViewRequest, purpose: Purpose, effects: &str, stops: f64) -> Vec<[f32; 4]> {
    let effects = EffectOverrides::parse(effects).expect("effects");
    let request = ViewRequest { purpose, effects, exposure: ExposureRequest::Stops(stops), ..request.clone() };
    SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
}

/// The greatest difference between channels of two images, relative to the larger of the two values.
fn relative_difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let relative = |(p, q): (&f32, &f32)| if p == q { 0.0 } else { (p - q).abs() / p.abs().max(q.abs()) };
    a.iter().zip(b).flat_map(|(p, q)| p[..3].iter().zip(&q[..3])).map(relative).fold(0.0, larger)
}

fn views() -> Vec<(&'static str, ViewRequest)> {
    let view = |target: i32, time: &str, position, fov_deg| {
        let time = Instant::parse(time).expect("a time");
        ViewRequest { position, fov_deg, width: 48, height: 48, ..ViewRequest::of(NaifId(target), time) }
    };
    let earth = Position::Centre(NaifId::EARTH);
    let over = |towards, radii| Position::AboveTarget { towards: Some(NaifId(towards)), distance_radii: Some(radii) };
    vec![
        ("earthshine", view(301, "2024-04-10T18:21:00Z", earth, None)),
        ("half Moon", view(301, "2024-04-15T19:00:00Z", earth, None)),
        ("new Moon", view(301, "2024-05-08T03:00:00Z", over(399, 8.0), Some(20.0))),
        ("the Earth's night", view(399, "2024-04-08T18:17:16Z", over(599, 3.0), None)),
        ("a small Earth", view(399, "2024-04-08T18:17:16Z", over(301, 60.0), None)),
        ("Jupiter from a moon", view(599, "2024-12-07T20:00:00Z", over(501, 6.0), None)),
        ("Io's night", view(501, "2024-12-07T20:00:00Z", over(599, 4.0), None)),
        ("Saturn's night", view(699, "2013-07-19T21:27:00Z", over(606, 8.0), None)),
        ("Uranus and its rings", view(799, "2024-04-08T18:17:16Z", over(399, 4.0), None)),
    ]
}

#[test]
fn linear_light_is_complete_at_any_exposure() {
    let mut displays_without_effects = 0;
    for (name, request) in views() {
        for stops in [-10.0, 5.0] {
            let all = pixels(&request, Purpose::LINEAR, ALL_EFFECTS, stops);
            let automatic = pixels(&request, Purpose::LINEAR, "", stops);
            let difference = relative_difference(&automatic, &all);
            assert!(difference <= FLOOR, "{name} at {stops} stops: {difference:e} against {FLOOR:e}");
            // An image for display at this exposure leaves out effects that it would not show; otherwise the comparison would prove
            // nothing.
            displays_without_effects += usize::from(relative_difference(&pixels(&request, Purpose::Display, "", stops), &all) > FLOOR);
        }
    }
    assert!(displays_without_effects > 8, "{displays_without_effects}");
}

/// In an EXR written by the program, the Moon's night side is lit by the Earth; without planet-shine it is black.
#[test]
fn earthshine_is_in_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    // The numbers of the disc's pixels that are exactly 0, and of all.
    let dark_and_all = |effects: &[&str]| {
        let path = folder.path().join(format!("{}.exr", effects.len()));
        let view = ["render", "--target", "moon", "--from", "earth", "--time", "2024-04-10T18:21:00Z", "--size", "64x64"];
        let mut program = std::process::Command::new(crate::support::program::path());
        let done = program.args(view).args(effects).args(["--renderer", "software", "-o"]).arg(&path).output().expect("runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
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

/// The GPU stores linear light as half floats, which end at 65,504. The brightest granules of the Sun's disc exceed it in blue; with the glare, every value
/// must fit.
#[test]
fn the_suns_disc_fits_into_half_floats() {
    let time = Instant::parse("2025-01-01T00:00:00Z").expect("a time");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(3.0) };
    let request = ViewRequest { position, fov_deg: Some(45.0), width: 256, height: 256, ..ViewRequest::of(NaifId::SUN, time) };
    let brightest = pixels(&request, Purpose::LINEAR, "", 0.0).iter().flat_map(|p| &p[..3]).copied().fold(0.0, larger);
    assert!((62_000.0..=65_504.0).contains(&brightest), "{brightest}");
}
