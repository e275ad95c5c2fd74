//! Relief near the limb: slopes that face away from the viewer leave no black dots.

use crate::support::folds::smaller;
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
