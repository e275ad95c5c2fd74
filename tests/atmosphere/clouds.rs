//! Clouds in drawn images: they are as bright as CERES measured, their shadow only removes light, and below them none are drawn.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::session::DrawnFrame;
use orrery::time::Instant;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };

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

fn draw(effects: &str) -> DrawnFrame {
    SESSION.draw(&earth(effects), SAMPLING, FrameImages::DisplayAndHdr).expect("draws")
}

fn sum_of_green(drawn: &DrawnFrame) -> f64 {
    drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum()
}

#[test]
fn clouds_brighten_the_earth_and_their_shadow_darkens_it() {
    let (bare, shadowed, clouded) = (draw("-clouds,-cloud-shadow"), draw("-clouds,+cloud-shadow"), draw("+clouds,-cloud-shadow"));
    let (bare_sum, shadowed_sum, clouded_sum) = (sum_of_green(&bare), sum_of_green(&shadowed), sum_of_green(&clouded));
    assert!(clouded_sum > 1.5 * bare_sum, "clouds reflect more than the ground: {clouded_sum} against {bare_sum}");
    assert!(shadowed_sum < 0.95 * bare_sum, "the shadow of clouds removes light: {shadowed_sum} against {bare_sum}");
    // A shadow only removes light. The two modules round map coordinates differently: 2e-6 of the light.
    for (s, b) in shadowed.frame.hdr.iter().zip(&bare.frame.hdr) {
        assert!((0..3).all(|k| s[k] <= b[k] * 1.000_005 + 1e-7), "{s:?} over {b:?}");
    }
    // Drawing is deterministic.
    let redrawn = draw("-clouds,-cloud-shadow");
    assert_eq!(redrawn.frame.hdr, bare.frame.hdr);
}

/// A coarser level of the cloud map has the mean opacity of the finer one, so that clouds smaller than a pixel keep their light. With the mean of the
/// texels' values instead, an image of 32 pixels would have 7 % less light than one of 512.
#[test]
fn the_light_of_a_cloudy_earth_does_not_depend_on_the_size_of_the_image() {
    let light_at = |side_px: u32| {
        let request = ViewRequest { width: side_px, height: side_px, ..earth("+clouds") };
        let sampling = SamplingQuality { samples: 4, anisotropy: 8 };
        let drawn = SESSION.draw(&request, sampling, FrameImages::DisplayAndHdr).expect("draws");
        sum_of_green(&drawn) / f64::from(side_px * side_px)
    };
    let full = light_at(512);
    for side_px in [32, 64, 128, 256] {
        let ratio = light_at(side_px) / full;
        assert!((ratio - 1.0).abs() < 0.015, "{side_px} pixels: {ratio}");
    }
}

/// The unit of radiance is that of a white plane that faces the Sun at 1 au.
#[test]
fn the_brightest_cloud_has_0_3_to_1_of_the_radiance_of_a_white_plane() {
    let clouded = draw("+clouds,-planet-shine");
    let brightest = clouded.frame.hdr.iter().map(|p| p[1]).fold(0.0, larger);
    assert!(brightest > 0.3 && brightest < 1.0, "{brightest}");
}

/// Green radiance of the fully lit disc, seen from so far away that nearly half of the sphere is visible: the mean, and the brightest
/// pixel.
fn full_disc(effects: &str) -> (f64, f64) {
    let request = ViewRequest {
        width: 100,
        height: 100,
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(200.0) },
        fov_deg: Some(0.6),
        ..earth(effects)
    };
    let drawn = SESSION.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("draws");
    let body = drawn.scene.body(NaifId::EARTH).expect("the Earth");
    let disc_area_px = std::f64::consts::FRAC_PI_4 * body.diameter_px.powi(2);
    let brightest = drawn.frame.hdr.iter().map(|p| f64::from(p[1])).fold(0.0, larger);
    (sum_of_green(&drawn) / disc_area_px, brightest)
}

/// Clouds are as bright as measured: they account for the difference between the Earth's albedo with and without them, and the thickest are
/// nearly white.
///
/// CERES measured a Bond albedo of 0.29 for all sky and 0.15 for clear sky (sources: the catalog). The Bond albedo of a Lambert sphere is
/// 3/2 of its mean radiance at full phase.
#[test]
fn clouds_make_the_difference_between_clear_and_all_sky_albedo() {
    let ((clear, _), (clouded, brightest)) = (full_disc("-clouds,-cloud-shadow"), full_disc("+clouds,+cloud-shadow"));
    let cloud_albedo = 1.5 * (clouded - clear);
    println!("clouds add {cloud_albedo:.3} to the albedo; brightest {brightest:.3}");
    assert!((cloud_albedo - 0.14).abs() < 0.03, "clouds add {cloud_albedo} to the albedo");
    // Thick clouds reflect 0.7 to 0.85 of the light at normal incidence; a pixel of 130 km also contains thinner ones.
    assert!((0.62..0.9).contains(&brightest), "{brightest}");
}

#[test]
fn below_the_clouds_none_are_drawn() {
    let at_height = |height_km: f64| ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg: 20.0, longitude_deg: 60.0, height_km },
        ..earth("+clouds")
    };
    let shows_clouds = |scene: &Scene| scene.draws.iter().any(|d| d.name.contains("clouds"));
    // From the ground in a direction above the horizon.
    let mut request = at_height(0.002);
    request.target = None;
    request.look = orrery::scene::request::Look::Along { direction: DVec3::X, axes: orrery::scene::request::Axes::BodyFixed };
    let scene = SESSION.scene(&request).expect("a scene");
    let decisions = &scene.body(NaifId::EARTH).expect("the Earth").decisions;
    let clouds = decisions.iter().rfind(|d| d.effect == "clouds");
    assert!(clouds.is_none_or(|d| !d.on), "{clouds:?}");
    assert!(!shows_clouds(&scene));
    // Straight down from above the clouds.
    assert!(shows_clouds(&SESSION.scene(&at_height(20.0)).expect("a scene")));
}
