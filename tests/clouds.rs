//! Clouds through the real renderer: a closed deck hides the ground, its shadow falls away from the Sun, and switched off it leaves no trace.

use crate::shared::SESSION;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::render::plan::Fineness;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::session::Drawn;
use orrery::time::Instant;

const FINENESS: Fineness = Fineness { samples: 1, anisotropy: 1 };

fn earth(effects: &str) -> ViewRequest {
    let time = Instant::parse("2024-06-08T06:00:00Z").expect("a time");
    ViewRequest {
        width: 160,
        height: 160,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId::EARTH, time)
    }
}

fn draw(effects: &str) -> Drawn {
    SESSION.draw(&earth(effects), FINENESS, true).expect("draws")
}

fn sum(d: &Drawn) -> f64 {
    d.frame.hdr.iter().map(|p| f64::from(p[1])).sum()
}

#[test]
fn clouds_brighten_the_earth_and_their_shadow_darkens_it() {
    let (bare, shadowed, clouded) = (draw("-clouds,-cloud-shadow"), draw("-clouds,+cloud-shadow"), draw("+clouds,-cloud-shadow"));
    let (bare_sum, shadowed_sum, clouded_sum) = (sum(&bare), sum(&shadowed), sum(&clouded));
    assert!(clouded_sum > 1.5 * bare_sum, "clouds reflect more than sea: {clouded_sum} against {bare_sum}");
    assert!(shadowed_sum < 0.95 * bare_sum, "{shadowed_sum} against {bare_sum}");
    // A shadow takes light away, never adds any.
    for (s, b) in shadowed.frame.hdr.iter().zip(&bare.frame.hdr) {
        assert!((0..3).all(|k| s[k] <= b[k] * 1.000_001 + 1e-7), "{s:?} over {b:?}");
    }
    let again = draw("-clouds,-cloud-shadow");
    assert_eq!(again.frame.hdr, bare.frame.hdr);
}

/// Brightest and darkest opacity lie in the map's range, so a deck is never more than closed.
#[test]
fn no_cloud_reflects_more_than_a_closed_deck() {
    let clouded = draw("+clouds,-planet-shine");
    let brightest = clouded.frame.hdr.iter().map(|p| p[1]).fold(0.0, f32::max);
    assert!(brightest > 0.3 && brightest < 1.0, "{brightest}");
}

#[test]
fn a_camera_under_the_clouds_says_that_it_sees_none() {
    let ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 20.0, longitude_deg: 60.0, height_km: 0.002 };
    let mut request = earth("+clouds");
    request.position = ground;
    request.target = None;
    request.look = orrery::scene::request::Look::Along { direction: DVec3::X, axes: orrery::scene::request::Axes::BodyFixed };
    let scene = SESSION.scene(&request).expect("a scene");
    let earth = scene.body(NaifId::EARTH).expect("the Earth");
    let clouds = earth.decisions.iter().rfind(|d| d.feature == "clouds");
    assert!(clouds.is_none_or(|d| !d.on), "{clouds:?}");
    assert!(scene.draws.iter().all(|d| !d.name.contains("clouds")));
}
