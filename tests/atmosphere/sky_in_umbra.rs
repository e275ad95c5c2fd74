//! The sky around a camera in the umbra of a moon: it is metered as it is drawn. Its light comes from outside the umbra: on Jupiter from beyond a narrow
//! penumbra, on the Earth from the wide penumbra.

use super::dusk::metered_sky_cd_m2;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::CD_M2_PER_RADIANCE;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Up, ViewRequest};
use orrery::time::Instant;
use orrery::units::luminance;
use std::ops::Range;

/// Metered over drawn luminance. The meter takes the geometric mean over the directions of what is left of their light. With the arithmetic mean, which gives
/// 1.02 (Jupiter) to 1.3 times as much (the totality of 81 seconds), these places had 0.35 (Saturn) to 2.9 (10 km above Dallas).
const RATIOS: Range<f64> = 0.25..3.0;
/// Fraction of daylight that the meter took for every umbra: that which it found at Dallas in 2024.
const FIXED_FRACTION: f64 = 5.5e-4;

/// A place in an umbra, and the direction of a view of the sky there, with the Sun outside the frame. Angles in degrees, longitudes east; azimuth from north.
struct Place {
    body: (NaifId, &'static str),
    time: &'static str,
    latitude: f64,
    longitude: f64,
    height_km: f64,
    azimuth: f64,
}

fn places() -> [Place; 8] {
    let place = |body, time, latitude, longitude, height_km, azimuth| Place { body, time, latitude, longitude, height_km, azimuth };
    let (jupiter, earth) = ((NaifId(599), "Jupiter"), (NaifId(399), "Earth"));
    [
        // Io's umbra, near its edge and in the middle; Titan's; Charon's.
        place(jupiter, "2015-01-24T06:45:00Z", -5.0, 310.84, 5.0, 180.0),
        place(jupiter, "2015-01-24T06:45:00Z", -5.0, 310.84, 100.0, 180.0),
        place(jupiter, "2015-01-24T06:30:00Z", -4.58, 309.33, 50.0, 180.0),
        place((NaifId(699), "Saturn"), "2025-07-02T10:19:00Z", 25.43, 76.31, 50.0, 180.0),
        place((NaifId(999), "Pluto"), "1987-06-03T23:00:00Z", 23.39, 39.07, 0.01, 180.0),
        // Totalities of four minutes (Dallas) and of 81 seconds.
        place(earth, "2024-04-08T18:42:38Z", 32.78, -96.80, 0.002, 300.0),
        place(earth, "2024-04-08T18:42:38Z", 32.78, -96.80, 10.0, 300.0),
        place(earth, "2023-04-20T04:16:47Z", -9.58, 125.78, 0.002, 300.0),
    ]
}

/// A view of the sky from 1 to 61 degrees above the horizontal.
fn view(place: &Place, effects: &str) -> ViewRequest {
    let (sin_lat, cos_lat) = place.latitude.to_radians().sin_cos();
    let (sin_lon, cos_lon) = place.longitude.to_radians().sin_cos();
    let up = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let east = DVec3::new(-sin_lon, cos_lon, 0.0);
    let (sin, cos) = place.azimuth.to_radians().sin_cos();
    let (sin_altitude, cos_altitude) = 31_f64.to_radians().sin_cos();
    let direction = (up.cross(east) * cos + east * sin) * cos_altitude + up * sin_altitude;
    ViewRequest {
        target: None,
        position: Position::Ground {
            body: place.body.0,
            latitude_deg: place.latitude,
            longitude_deg: place.longitude,
            height_km: place.height_km,
        },
        look: Look::Along { direction, axes: Axes::BodyFixed },
        up: Up::Zenith,
        fov_deg: Some(60.0),
        width: 48,
        height: 36,
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(place.body.0, Instant::parse(place.time).expect("a time"))
    }
}

/// The luminance of the sky that the exposure of a view names, cd/m2.
fn metered(place: &Place, effects: &str) -> f64 {
    let scene = SESSION.scene(&view(place, effects)).expect("a scene");
    metered_sky_cd_m2(&scene, place.body.1).unwrap_or_else(|| panic!("{}: {}", place.body.1, scene.exposure.reason))
}

/// Median luminance of the drawn sky more than 6 degrees above the horizontal, cd/m2.
fn drawn(place: &Place) -> f64 {
    let view = ViewRequest {
        exposure: ExposureRequest::Stops(12.0),
        layers: Layers::parse("-stars,-milky-way,-zodiacal-light").expect("layers"),
        ..view(place, "-corona,-glow,-points,-planet-shine,-clouds,-rings")
    };
    let image = SESSION.draw(&view, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("draws");
    let camera = &image.scene.camera;
    let up = -image.scene.body(place.body.0).expect("the ground").placement.centre_km.normalize();
    let sine = |k: usize| {
        let pixel_centre = glam::DVec2::new(k as f64 % f64::from(camera.width) + 0.5, (k / camera.width as usize) as f64 + 0.5);
        camera.ray(camera.clip_from_pixel(pixel_centre)).normalize().dot(up)
    };
    let hdr = image.frame.hdr.iter().enumerate().filter(|(k, _)| sine(*k) > 6_f64.to_radians().sin());
    let mut all: Vec<f64> = hdr.map(|(_, p)| luminance([p[0], p[1], p[2]].map(f64::from)) * CD_M2_PER_RADIANCE).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

#[test]
fn the_sky_in_an_umbra_is_metered_as_it_is_drawn() {
    let mut failures = Vec::new();
    for place in places() {
        let (drawn, metered) = (drawn(&place), metered(&place, ""));
        let at = format!("{} at {}, {} km", place.body.1, place.time, place.height_km);
        println!("{at}: drawn {drawn:.3e} cd/m2, metered {metered:.3e}, {:.2} times that", metered / drawn);
        if !RATIOS.contains(&(metered / drawn)) {
            failures.push(format!("{at}: drawn {drawn:e} cd/m2, metered {metered:e}"));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    // Negative control: with one fraction of daylight for every umbra, the sky of Jupiter is metered 18 to 34 times too dark.
    for place in &places()[..2] {
        let ratio = metered(place, "-eclipse") * FIXED_FRACTION / drawn(place);
        assert!(ratio < 0.5 * RATIOS.start, "{} km: {ratio}", place.height_km);
    }
}
