//! The ground of the Earth by night: from orbit it is hardly lit, not as by day, and it darkens steadily through dusk.

use super::metering::assert_changes_smoothly;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::CD_M2_PER_RADIANCE;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Position, ViewRequest};
use orrery::time::Instant;

/// Local noon at 10 degrees east on the day of a full Moon.
const NOON: &str = "2025-01-13T11:30:00Z";

/// Straight down on the Sahara, some hours after noon.
fn sahara(height_km: f64, hours: f64, effects: &str) -> ViewRequest {
    let time = Instant::parse(NOON).expect("a time").plus_seconds(3600.0 * hours);
    let position = Position::Ground { body: NaifId::EARTH, latitude_deg: 20.0, longitude_deg: 10.0, height_km };
    let effects = EffectOverrides::parse(effects).expect("effects");
    ViewRequest { position, effects, fov_deg: Some(45.0), width: 48, height: 48, ..ViewRequest::of(NaifId::EARTH, time) }
}

/// The level of the ground as a fraction of white: the mean of the brightest channel. The drawn ground is at most 2.5 times as
/// bright as the luminance that the reason gives for the Earth (measured: 1.5 to 2.1): the Sahara is brighter than the mean ground.
fn level(request: &ViewRequest) -> f64 {
    let drawn = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
    let hdr = &drawn.frame.hdr;
    let mean = hdr.iter().map(|p| f64::from(p[0].max(p[1]).max(p[2]))).sum::<f64>() / hdr.len() as f64;
    let level = mean * drawn.scene.exposure.factor();
    let reason = drawn.scene.exposure.reason.to_string();
    let metered = reason.strip_prefix("Earth metered at ").and_then(|rest| rest.split_once(" cd/m2"));
    let ratio = metered.map(|(cd_m2, _)| mean * CD_M2_PER_RADIANCE / cd_m2.parse::<f64>().expect("a luminance"));
    println!("{level:.4} of white; drawn / metered {ratio:.2?}; {reason}");
    assert!(ratio.is_none_or(|ratio| (1.0..2.5).contains(&ratio)), "{ratio:?}: {reason}");
    level
}

/// In the light of the full Moon the ground is shown at 0.01 to 0.15 of white, by day at 0.1 to 0.8. It was 0.2 by night as by day.
#[test]
fn moonlit_ground_from_orbit_is_hardly_lit() {
    for height_km in [420.0, 3000.0] {
        let [day, night] = [0.0, 12.0].map(|hours| level(&sahara(height_km, hours, "-night")));
        assert!((0.1..0.8).contains(&day) && (0.01..0.15).contains(&night), "{height_km} km: {day} by day, {night} by night");
        assert!(day > 3.0 * night, "{height_km} km: {day} by day, {night} by night");
    }
}

/// From the afternoon until midnight, in steps of a degree of the Sun's altitude: the exposure has no jump, and the level of the ground does not rise.
#[test]
fn the_ground_darkens_steadily_through_dusk() {
    assert_changes_smoothly("dusk from orbit", 1.0, 120, |k| sahara(420.0, 4.0 + k / 15.0, "-night"));
    let levels: Vec<f64> = (0..=16).map(|k| level(&sahara(420.0, 4.0 + 0.5 * f64::from(k), "-night"))).collect();
    assert!(levels.windows(2).all(|w| w[1] < 1.3 * w[0]), "{levels:?}");
    assert!(levels[0] > 3.0 * levels[16], "{levels:?}");
}

/// As the Moon wanes, the moonlit ground becomes darker, without a jump of the exposure; at new Moon the limit of night photographs takes over.
#[test]
fn the_ground_darkens_with_the_waning_moon() {
    assert_changes_smoothly("from full to new Moon", 1.5, 15, |k| sahara(420.0, 12.0 + 24.0 * k, "-night"));
    let [full, new] = [12.0, 12.0 + 24.0 * 16.0].map(|hours| level(&sahara(420.0, hours, "-night")));
    assert!(new < full, "{full} at full Moon, {new} at new Moon");
}
