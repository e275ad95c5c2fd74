//! The corona seen from high in the air, with the Sun behind the limb: it is reddened only along lines of sight that pass through the air.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec2;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::purpose::Purpose;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 80;

/// Bodies with the time of a view, the height of the top of their air in km, and how far the Sun is below the horizontal plane: some degrees behind the limb.
const VIEWS: [(NaifId, &str, f64, f64); 2] =
    [(NaifId::EARTH, "2024-03-20T03:00:00Z", 100.0, 14.0), (NaifId(299), "2017-05-17T00:00:00Z", 60.0, 12.0)];

/// A pixel's altitude above the visible horizon, and the corona's light in it.
struct CoronaPixel {
    above_horizon_deg: f64,
    light: [f64; 3],
}

/// The corona's light in a view towards the Sun from over the equator: the difference of the images with and without it. In units of the Sun's colour.
fn corona_light(body: NaifId, time: &str, height_km: f64, sun_below_deg: f64) -> Vec<CoronaPixel> {
    let time = Instant::parse(time).expect("a time");
    let view = |longitude_deg: f64, effects: &str| ViewRequest {
        position: Position::Ground { body, latitude_deg: 0.0, longitude_deg, height_km },
        width: SIDE,
        height: SIDE,
        fov_deg: Some(24.0),
        purpose: Purpose::LINEAR,
        exposure: ExposureRequest::Stops(0.0),
        layers: Layers::NONE,
        effects: EffectOverrides::parse(&format!("-glow,-points,-clouds,-night,-planet-shine,-eclipse,{effects}")).expect("effects"),
        ..ViewRequest::of(NaifId::SUN, time)
    };
    let anywhere = SESSION.scene(&view(0.0, "-corona")).expect("a scene");
    let noon_deg = anywhere.body(body).expect("there").sub_solar.expect("a sub-solar point").lon_east_deg;
    let longitude_deg = (noon_deg + 90.0 + sun_below_deg + 180.0).rem_euclid(360.0) - 180.0;
    let [with, without] = ["+corona", "-corona"].map(|effects| {
        let sampling = SamplingQuality { samples: 1, anisotropy: 1 };
        SESSION.draw(&view(longitude_deg, effects), sampling, FrameImages::DisplayAndHdr).expect("drawn")
    });
    let camera = &with.scene.camera;
    let placement = with.scene.body(body).expect("there").placement;
    let up = -placement.centre_km.normalize();
    let horizon_deg = -(placement.radii_km.x / placement.centre_km.length()).acos().to_degrees();
    let colour = SESSION.catalog().body(NaifId::SUN).expect("the Sun").colour.to_array();
    let pixels = with.frame.hdr.iter().zip(&without.frame.hdr).enumerate();
    pixels
        .map(|(k, (a, b))| {
            let centre = DVec2::new((k % SIDE as usize) as f64 + 0.5, (k / SIDE as usize) as f64 + 0.5);
            let ray = camera.ray(camera.clip_from_pixel(centre)).normalize();
            CoronaPixel {
                above_horizon_deg: up.dot(ray).asin().to_degrees() - horizon_deg,
                light: [0, 1, 2].map(|c| f64::from(a[c] - b[c]) / f64::from(colour[c])),
            }
        })
        .collect()
}

/// Four degrees above the horizon, where the air is transparent, the corona has the Sun's colour; close to the horizon it is red, in the same image.
#[test]
fn the_corona_is_red_only_behind_air() {
    for (body, time, top_km, sun_below_deg) in VIEWS {
        for height_km in [top_km - 5.0, top_km - 0.1] {
            let pixels = corona_light(body, time, height_km, sun_below_deg);
            let clear: Vec<_> = pixels.iter().filter(|p| p.above_horizon_deg > 4.0).collect();
            assert!(clear.len() > 500, "{body:?}: {} pixels", clear.len());
            for p in clear {
                let [red, green, blue] = p.light;
                let is_white = (red / green - 1.0).abs() < 0.02 && (blue / green - 1.0).abs() < 0.02;
                assert!(green > 0.0 && is_white, "{body:?}, {height_km} km: {:?} at {} degrees", p.light, p.above_horizon_deg);
            }
            let near_horizon = pixels.iter().filter(|p| (0.1..0.6).contains(&p.above_horizon_deg));
            let reddest = near_horizon.map(|p| p.light[0] / p.light[2].max(1e-3 * p.light[0])).fold(0.0, larger);
            assert!(reddest > 1.3, "{body:?}, {height_km} km: at most {reddest} times as red as the Sun near the horizon");
        }
    }
}

/// A tenth of a per cent below the top of the air and as much above it, the corona has the same light.
#[test]
fn the_corona_does_not_change_at_the_top_of_the_air() {
    for (body, time, top_km, sun_below_deg) in VIEWS {
        let [below, above] = [0.999, 1.001].map(|part| corona_light(body, time, part * top_km, sun_below_deg));
        let mut compared = 0;
        for (a, b) in below.iter().zip(&above).filter(|(a, _)| a.above_horizon_deg > 4.0) {
            let largest_change = (0..3).map(|c| (a.light[c] / b.light[c] - 1.0).abs()).fold(0.0, larger);
            assert!(largest_change < 0.02, "{body:?}, {} degrees: {:?} and {:?}", a.above_horizon_deg, a.light, b.light);
            compared += 1;
        }
        assert!(compared > 500, "{body:?}: {compared} pixels");
    }
}
