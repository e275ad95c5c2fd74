//! Bright ground below a camera near it, deserts and ice: it is exposed for itself, keeps a part of its brightness, and enters the exposure gradually.

use super::metering::assert_changes_smoothly;
use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Position, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 16;
/// Latitude and longitude in degrees, and a time about noon.
type Place = ([f64; 2], &'static str);
const SAHARA: Place = ([23.0, 10.0], "2026-06-21T11:30:00Z");
const GREENLAND: Place = ([72.0, -40.0], "2026-06-21T14:40:00Z");
const ATLANTIC: Place = ([10.0, -40.0], "2026-06-21T17:40:00Z");

/// Looks straight down.
fn view(([latitude_deg, longitude_deg], time): Place, height_km: f64, effects: &str) -> ViewRequest {
    ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km },
        layers: Layers::NONE,
        effects: EffectOverrides::parse(effects).expect("effects"),
        fov_deg: Some(45.0),
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
    }
}

fn stops(request: &ViewRequest) -> f64 {
    SESSION.scene(request).expect("a scene").exposure.stops
}

/// The level at which the ground is shown, as a fraction of white in the brightest channel, and the same at the exposure for ground of the mean albedo: that of
/// the view in which the map is switched off.
fn shown_and_as_mean(place: Place) -> [f64; 2] {
    let request = view(place, 0.001, "");
    let drawn = SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
    let hdr = &drawn.frame.hdr;
    let mean = |channel: usize| hdr.iter().map(|p| f64::from(p[channel])).sum::<f64>() / hdr.len() as f64;
    let light = [0, 1, 2].map(mean).into_iter().fold(0.0, larger);
    [drawn.scene.exposure.stops, stops(&view(place, 0.001, "-albedo"))].map(|stops| light * stops.exp2())
}

/// Sand and ice are shown below white and brighter than the sea. Negative control: exposed for the mean of all ground they are beyond white.
#[test]
fn deserts_and_ice_are_not_blank_from_near_the_ground() {
    let [sea, sea_as_mean] = shown_and_as_mean(ATLANTIC);
    for place in [SAHARA, GREENLAND] {
        let [shown, as_mean] = shown_and_as_mean(place);
        println!("{place:?}: {shown:.3} of white, exposed for the mean {as_mean:.3}; sea {sea:.3}");
        assert!((0.25..0.95).contains(&shown) && shown > sea, "{place:?}: {shown} of white, the sea {sea}");
        assert!(as_mean > 1.2, "{place:?}: {as_mean}: the check above cannot fail");
    }
    // Ground darker than the mean is exposed as the mean.
    assert!((sea - sea_as_mean).abs() < 1e-9 * sea, "{sea} and {sea_as_mean}");
}

/// A camera that rises from the Sahara into space, without clouds, which would hide it from 6 km on; and one that flies in from the sea.
#[test]
fn bright_ground_enters_the_exposure_gradually() {
    assert_changes_smoothly("raised", 0.4, 110, |k| view(SAHARA, 0.05 * 1.1_f64.powf(k), "-clouds"));
    assert_changes_smoothly("raised through the clouds' height", 0.5, 40, |k| view(SAHARA, 3.0 + 0.1 * k, ""));
    let from_the_sea = |k: f64| view(([23.0, -20.0 + 0.1 * k], "2026-06-21T12:45:00Z"), 1.0, "");
    assert_changes_smoothly("from the sea", 0.5, 100, from_the_sea);
    let [sea, desert] = [0.0, 100.0].map(|k| stops(&from_the_sea(k)));
    assert!(sea - desert > 1.0, "{sea} and {desert} stops: the check above cannot fail");
    // From a tenth of the radius on the ground is metered as the mean.
    let [with_map, without_map] = ["-clouds", "-clouds,-albedo"].map(|effects| stops(&view(SAHARA, 640.0, effects)));
    assert!((with_map - without_map).abs() < 1e-9, "{with_map} and {without_map} stops");
}
