//! A body that shrinks from a disc to a point keeps its light, through the scene, the emitted modules and the renderer.

use orrery::catalog::NaifId;
use orrery::render::plan::Fineness;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::scene::{Appearance, Scene};
use orrery::session::{Session, Sources};
use orrery::time::Instant;

/// Part of the point's light by which a small disc may be off. A disc of 1 to 2 pixels is sampled at four places a pixel, with the limb's
/// own coverage; the Sun's rays and the viewer's converge a little more on a near body than on a far one.
const SHARE: f64 = 0.04;

const FOV_DEG: f64 = 1.0;

/// Linear light of the whole picture times distance squared, the body's diameter in pixels, and how it was shown.
fn light(session: &Session, side: u32, diameter_px: f64) -> (f64, f64, Appearance) {
    let px_per_rad = f64::from(side) / (2.0 * (0.5 * FOV_DEG.to_radians()).tan());
    let distance_radii = 2.0 * px_per_rad / diameter_px;
    // Venus has no moon, and from the Sun's side nothing else stands before or behind it at this moment.
    let venus = NaifId(299);
    let request = ViewRequest {
        position: Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(distance_radii) },
        fov_deg: Some(FOV_DEG),
        exposure: ExposureRequest::Stops(0.0),
        width: side,
        height: side,
        ..ViewRequest::of(venus, Instant::parse("2024-04-08T18:17:16Z").expect("a time"))
    };
    let drawn = session.draw(&request, Fineness { samples: 4, anisotropy: 8 }, true).expect("drawn");
    let others = |s: &Scene| s.bodies.iter().filter(|b| b.appearance != Appearance::NotShown).count();
    assert_eq!(others(&drawn.scene), 1, "another body is in the picture");
    let sum: f64 = drawn.frame.hdr.iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum();
    let body = drawn.scene.body(venus).expect("Venus");
    (sum * body.distance_km.powi(2), body.diameter_px, body.appearance)
}

#[test]
fn a_body_keeps_its_light_while_it_shrinks_to_a_point() {
    let cache = tempfile::tempdir().expect("a folder");
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
    // With an even side the body sits on a pixel's corner, with an odd one in a pixel's middle.
    for side in [64, 65] {
        let (point, _, appearance) = light(&session, side, 0.5);
        assert_eq!(appearance, Appearance::Point);
        let mut seen = Vec::new();
        let mut last = f64::INFINITY;
        for step in 0..=14 {
            let (intrinsic, diameter_px, appearance) = light(&session, side, 2.3 - 0.1 * f64::from(step));
            println!("side {side}: {diameter_px:.2} px, {appearance:?}: {:.4} of the point's light", intrinsic / point);
            assert!((intrinsic / point - 1.0).abs() < SHARE, "{diameter_px} px: {} of the point's light", intrinsic / point);
            let received = intrinsic * diameter_px.powi(2);
            assert!(received < last, "farther away and yet brighter at {diameter_px} px");
            last = received;
            seen.push(appearance);
        }
        seen.dedup();
        assert_eq!(seen, [Appearance::Disc, Appearance::DiscAndPoint, Appearance::Point], "side {side}");
    }
}
