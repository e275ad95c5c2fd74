//! Relief near the limb: slopes that face away from the viewer leave no black dots. Sunlight on relief, on level ground and on the sea around sunset.

use crate::support::folds::{larger, smaller};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;

/// The smallest ratio of a pixel's light with relief to its light without, where the smooth Moon is lit.
fn min_light_ratio(session: &Session, from: NaifId, time: &str) -> f64 {
    let image = |effects: &str| {
        let request = ViewRequest {
            position: Position::AboveTarget { towards: Some(from), distance_radii: Some(60.0) },
            fov_deg: Some(2.1),
            exposure: ExposureRequest::Stops(2.0),
            effects: EffectOverrides::parse(effects).expect("effects"),
            width: 400,
            height: 400,
            ..ViewRequest::of(NaifId::MOON, Instant::parse(time).expect("a time"))
        };
        session.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
    };
    let (rough, smooth) = (image("+normal,-planet-shine"), image("-normal,-planet-shine"));
    let lit_pixels = rough.iter().zip(&smooth).filter(|(_, s)| s[1] > 0.01);
    lit_pixels.map(|(r, s)| f64::from(r[1] / s[1])).fold(f64::INFINITY, smaller)
}

#[test]
fn a_full_moon_has_no_black_dots_on_its_limb() {
    let session = &*crate::support::session::SESSION;
    // Seen from the Sun's direction every visible slope faces the Sun. At the limb the Sun is on the horizon of the smooth ground, where
    // `horizon_factor` (shaders/lib/reflected.wesl) leaves half of the light.
    for time in ["2024-04-23T23:00:00Z", "2024-06-22T01:00:00Z"] {
        let min = min_light_ratio(session, NaifId::SUN, time);
        println!("{time}: {min:.3}");
        assert!(min > 0.4, "{time}: {min} of the smooth Moon's light");
    }
    // At first quarter, slopes along the terminator are dark: the comparison must be able to fail.
    assert!(min_light_ratio(session, NaifId::EARTH, "2024-04-15T19:00:00Z") < 0.1);
}

/// Linear light of each pixel, in a small image at a fixed exposure.
fn ground_light(view: ViewRequest, effects: &str) -> Vec<[f64; 3]> {
    let view = ViewRequest {
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(effects).expect("effects"),
        width: 48,
        height: 48,
        ..view
    };
    let session = &*crate::support::session::SESSION;
    let drawn = session.draw(&view, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
    drawn.frame.hdr.iter().map(|p| [0, 1, 2].map(|channel| f64::from(p[channel]))).collect()
}

/// The sea at A Coruna, towards the Sun, which sets at 19:38 UTC (altitude -0.28 degrees, its semidiameter 0.26): it glitters before, and not after. With a
/// ramp of 0.05 rad for water, too, the glitter lasted until 19:52. Without air, whose light the sea mirrors after sunset, too.
#[test]
fn the_sea_does_not_glitter_after_sunset() {
    let glint = |time: &str| {
        let position = Position::Ground { body: NaifId::EARTH, latitude_deg: 43.37, longitude_deg: -8.4, height_km: 0.01 };
        let view = ViewRequest { position, fov_deg: Some(8.0), ..ViewRequest::of(NaifId::SUN, Instant::parse(time).expect("a time")) };
        let (with, without) =
            (ground_light(view.clone(), "-atmosphere,-clouds,+specular"), ground_light(view, "-atmosphere,-clouds,-specular"));
        with.iter().zip(&without).map(|(a, b)| a[0] - b[0]).fold(0.0, larger)
    };
    // Measured: 47, 23, and at most 1e-5, from rounding.
    for (time, is_lit) in [("19:30:00", true), ("19:36:00", true), ("19:38:30", false), ("19:42:00", false)] {
        let found = glint(&format!("2026-08-12T{time}Z"));
        println!("{time}: {found:.2e}");
        let expected = if is_lit { 0.5..100.0 } else { 0.0..1e-3 };
        assert!(expected.contains(&found), "{time}: {found}");
    }
}

/// Level ground of the Moon has no sunlight with the Sun 2.3 degrees below the horizon, steep slopes of the map still have some 1.5 degrees below.
#[test]
fn after_sunset_only_steep_slopes_of_the_moon_have_sunlight() {
    let mean_light = |time: &str, latitude_deg: f64, longitude_deg: f64| {
        let position = Position::Ground { body: NaifId::MOON, latitude_deg, longitude_deg, height_km: 0.3 };
        let view = ViewRequest { position, ..ViewRequest::of(NaifId::MOON, Instant::parse(time).expect("a time")) };
        let pixels = ground_light(view, "-planet-shine");
        pixels.iter().map(|p| p[1]).sum::<f64>() / pixels.len() as f64
    };
    let (day, night) = (mean_light("2026-11-29T21:00:00Z", 0.0, 14.0), mean_light("2026-11-30T21:00:00Z", 0.0, 14.0));
    println!("level: {day:.2e} by day, {night:.2e} after sunset");
    // The ramp of 0.05 rad left a fiftieth in linear light; single pixels had more.
    assert!(day > 0.01 && night < 1e-4 * day, "{day} {night}");
    let slope = mean_light("1909-07-27T06:00:00Z", -1.846, 156.182);
    println!("slope: {slope:.2e}");
    assert!(slope > 5e-3, "{slope}");
}
