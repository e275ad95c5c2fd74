//! A small body in front of a planet, its rings or the Sun hides as much of them as its disc covers, drawn as a point or as a disc.

use crate::support::session::SESSION;
use glam::{DMat3, DVec2, DVec3, Vec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::render::plan::{self, SamplingQuality};
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::scene::{Appearance, Scene};
use orrery::time::Instant;
use std::f64::consts::PI;

/// A square view of a moon. The camera is in this direction (ICRF) from the moon, which has this diameter in the image.
fn view(
    moon: NaifId,
    direction: DVec3,
    distance_km: f64,
    diameter_px: f64,
    time: Instant,
    side_px: u32,
    exposure: ExposureRequest,
) -> Scene {
    let radius_km = SESSION.catalog().body(moon).expect("a moon").radii_km.x;
    let half_side_tangent = radius_km / distance_km * f64::from(side_px) / diameter_px;
    let request = ViewRequest {
        position: Position::Offset { body: moon, offset_km: direction.normalize() * distance_km, axes: Axes::Icrf },
        fov_deg: Some(2.0 * half_side_tangent.atan().to_degrees()),
        exposure,
        width: side_px,
        height: side_px,
        ..ViewRequest::of(moon, time)
    };
    SESSION.scene(&request).expect("a scene")
}

/// The image's radiance in green.
fn green(scene: &Scene) -> Vec<f64> {
    let plan = plan::plan(scene, &*SESSION, SamplingQuality { samples: 4, anisotropy: 4 }).expect("a plan");
    let hdr = SESSION.renderer().render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
    hdr.iter().map(|p| f64::from(p[1])).collect()
}

/// Area that the moon hides, in pixels: the hidden fraction of each pixel's radiance, summed over the image.
fn hidden_area_px(scene: &Scene, moon: NaifId) -> f64 {
    let mut dark = scene.clone();
    dark.points.retain(|p| p.body == moon);
    dark.points.iter_mut().for_each(|p| p.flux = Vec3::ZERO);
    for draw in dark.draws.iter_mut().filter(|d| d.body == moon) {
        draw.uniforms.lights.iter_mut().for_each(|light| light.irradiance = Vec3::ZERO);
    }
    let mut background = dark.clone();
    background.draws.retain(|d| d.body != moon);
    background.points.clear();
    let (background, with_moon) = (green(&background), green(&dark));
    let middle = scene.camera.height / 2 * scene.camera.width + scene.camera.width / 2;
    assert!(background[middle as usize] > 0.0, "nothing is behind the moon");
    background.iter().zip(&with_moon).map(|(b, m)| if b == m { 0.0 } else { 1.0 - m / b }).sum()
}

/// Vector from one body's centre to another's, ICRF.
fn from_to_km(from: NaifId, to: NaifId, time: Instant) -> DVec3 {
    SESSION.ephemeris().state(to, from, time, None).expect("a state").state.pos_km
}

/// Axes of Saturn: rows, ICRF.
fn saturn_axes(time: Instant) -> DMat3 {
    SESSION.ephemeris().body_from_icrf(NaifId(699), time).expect("axes")
}

/// Vector from Saturn's centre to a moon, in Saturn's axes: z is the height above the rings' plane.
fn from_saturn_km(moon: NaifId, time: Instant) -> DVec3 {
    saturn_axes(time) * from_to_km(NaifId(699), moon, time)
}

/// The first whole hour after the beginning of 2017-05-17 for which `suits` holds.
fn hour_in_2017(suits: impl Fn(Instant) -> bool) -> Instant {
    let start = Instant::parse("2017-05-17T00:00:00Z").expect("a time");
    (0..400).map(|k| start.plus_seconds(3600.0 * f64::from(k))).find(|t| suits(*t)).expect("a time")
}

/// A time at which the side of a planet that its moon sees is lit. Seen from the outer side of the moon, this side is behind the moon.
fn time_of_lit_planet(moon: NaifId, planet: NaifId) -> Instant {
    let start = Instant::parse("2024-03-01T00:00:00Z").expect("a time");
    let is_lit = |time: &Instant| angle_rad(from_to_km(planet, moon, *time), from_to_km(planet, NaifId::SUN, *time)) < 0.7;
    (0..1000).map(|k| start.plus_seconds(3600.0 * f64::from(k))).find(is_lit).expect("a time")
}

#[test]
fn a_small_moon_hides_the_planet_behind_it() {
    // Io, Phobos and Hyperion.
    for (moon, planet) in [(NaifId(501), NaifId(599)), (NaifId(401), NaifId(499)), (NaifId(607), NaifId(699))] {
        let time = time_of_lit_planet(moon, planet);
        let direction = from_to_km(planet, moon, time);
        let radius_km = SESSION.catalog().body(moon).expect("a moon").radii_km.x;
        // Up to 2 pixels the moon is a point, from 4 on a disc, and both in between. With an even size it is centred on a pixel's corner.
        for (step, side) in (0..=38).flat_map(|step| [(step, 30), (step, 31)]) {
            let scene = view(moon, direction, 1e3 * radius_km, 0.3 + 0.1 * f64::from(step), time, side, ExposureRequest::Auto);
            let body = scene.body(moon).expect("a body");
            let area_px = 0.25 * PI * body.diameter_px.powi(2);
            let hidden_px = hidden_area_px(&scene, moon);
            println!("{moon:?}, image of {side} px: a moon of {:.3} px hides {hidden_px:.4} px, area {area_px:.4} px", body.diameter_px);
            // A point of almost 2 pixels would hide more than all of the pixel in its middle.
            let tolerance = if body.diameter_px < 1.8 { 0.01 } else { 0.12 };
            assert!((hidden_px / area_px - 1.0).abs() < tolerance, "{moon:?} {}: {hidden_px}, not {area_px}", body.diameter_px);
        }
    }
}

/// Titan's haze reaches far beyond its limb. Whether Titan is a point or a disc, its haze hides Saturn, too.
#[test]
fn a_small_moon_with_haze_hides_as_much_as_a_point_and_as_a_disc() {
    let (titan, saturn) = (NaifId(606), NaifId(699));
    let time = time_of_lit_planet(titan, saturn);
    let hidden_in_areas = |diameter_px: f64| {
        let scene = view(titan, from_to_km(saturn, titan, time), 2.6e6, diameter_px, time, 31, ExposureRequest::Auto);
        hidden_area_px(&scene, titan) / (0.25 * PI * scene.body(titan).expect("a body").diameter_px.powi(2))
    };
    let (point, disc) = (hidden_in_areas(1.5), hidden_in_areas(4.5));
    assert!(disc > 1.1, "{disc}");
    assert!((point / disc - 1.0).abs() < 0.08, "point {point}, disc {disc}");
}

/// A planet in transit hides the same area of the Sun wherever the planet's centre lies within a pixel.
#[test]
fn a_small_planet_hides_the_sun_behind_it() {
    let time = Instant::parse("2024-03-01T00:00:00Z").expect("a time");
    let mercury = NaifId(199);
    let direction = from_to_km(NaifId::SUN, mercury, time);
    for (diameter_px, side) in [0.3, 0.5, 0.8, 1.2, 1.7].into_iter().flat_map(|px| [(px, 30), (px, 31)]) {
        let mut scene = view(mercury, direction, 2.4e7, diameter_px, time, side, ExposureRequest::Auto);
        scene.glare = None;
        let area_px = 0.25 * PI * scene.body(mercury).expect("a body").diameter_px.powi(2);
        let hidden_px = hidden_area_px(&scene, mercury);
        assert!((hidden_px / area_px - 1.0).abs() < 0.01, "{diameter_px} px, image of {side} px: {hidden_px}, not {area_px}");
    }
}

/// By day, on the ground, a small body hides nothing behind the bright sky, except the Sun. The example is Mercury's transit of 2019.
#[test]
fn by_day_a_small_planet_hides_the_sun_behind_it() {
    let mercury = NaifId(199);
    let position = Position::Ground { body: NaifId::EARTH, latitude_deg: 5.0, longitude_deg: -45.0, height_km: 0.002 };
    let time = Instant::parse("2019-11-11T15:20:00Z").expect("a time");
    let request = ViewRequest { position, fov_deg: Some(1.0), width: 200, height: 200, ..ViewRequest::of(mercury, time) };
    let scene = SESSION.scene(&request).expect("a scene");
    let area_px = 0.25 * PI * scene.body(mercury).expect("a body").diameter_px.powi(2);
    let covered_px = scene.points.iter().find(|p| p.body == mercury).map_or(0.0, |p| f64::from(p.covered_px));
    assert!((covered_px / area_px - 1.0).abs() < 1e-3, "{covered_px}, not {area_px}");
}

/// A moon whose light is too faint to see has no point, and yet it hides what is behind it.
#[test]
fn a_moon_without_visible_light_hides_the_planet_behind_it() {
    let (hyperion, saturn) = (NaifId(607), NaifId(699));
    let time = time_of_lit_planet(hyperion, saturn);
    let scene = view(hyperion, from_to_km(saturn, hyperion, time), 1e5, 1.0, time, 31, ExposureRequest::Stops(-4.0));
    let body = scene.body(hyperion).expect("a body");
    assert_eq!(body.appearance, Appearance::NotShown);
    let area_px = 0.25 * PI * body.diameter_px.powi(2);
    let hidden_px = hidden_area_px(&scene, hyperion);
    assert!((hidden_px / area_px - 1.0).abs() < 0.01, "{hidden_px}, not {area_px}");
}

/// Seen from almost in the plane of the rings, Mimas is in front of them, although its orbit is larger.
#[test]
fn a_small_moon_hides_the_rings_behind_it() {
    let mimas = NaifId(601);
    let time = hour_in_2017(|t| from_saturn_km(mimas, t).z > 4000.0);
    let moon_km = from_saturn_km(mimas, time);
    // The line of sight meets the plane of the rings at this radius; it passes beside the globe.
    let angle_beside_globe_rad = 0.7;
    let view_before = |radius_km: f64| {
        let in_plane = DVec2::from_angle(angle_beside_globe_rad).rotate(moon_km.truncate().normalize()) * radius_km;
        view(mimas, saturn_axes(time).transpose() * (moon_km - in_plane.extend(0.0)), 1e5, 1.5, time, 31, ExposureRequest::Auto)
    };
    // Ring B.
    let hidden_px = hidden_area_px(&view_before(105_000.0), mimas);
    assert!((hidden_px / (0.25 * PI * 1.5 * 1.5) - 1.0).abs() < 0.2, "{hidden_px}");
    // Between the rings F and G there is nothing to hide, and no draw that would hide it.
    let points = view_before(155_000.0).points;
    assert!(points.iter().any(|p| p.body == mimas) && points.iter().all(|p| p.covered_px == 0.0), "{points:?}");
}

/// The light of a moon behind ring B passes through the ring; the moon hides nothing of the ring in front of it.
#[test]
fn a_small_moon_behind_the_rings_is_dimmed_by_them() {
    let mimas = NaifId(601);
    let time = hour_in_2017(|_| true);
    let moon_km = from_saturn_km(mimas, time);
    // The line of sight meets the plane of the rings at this radius, on the way from the moon to the camera.
    let angle_beside_globe_rad = 0.7;
    let view_through = |radius_km: f64| {
        let in_plane = DVec2::from_angle(angle_beside_globe_rad).rotate(moon_km.truncate().normalize()) * radius_km;
        let direction = in_plane.extend(0.0) - moon_km;
        view(mimas, saturn_axes(time).transpose() * direction, 3.0 * direction.length(), 1.5, time, 31, ExposureRequest::Auto)
    };
    let (behind_ring_b, beside) = (view_through(105_000.0), view_through(155_000.0));
    let flux = |scene: &Scene| scene.points.iter().find(|p| p.body == mimas).map_or(0.0, |p| f64::from(p.flux.y));
    assert!(flux(&beside) > 0.0 && flux(&behind_ring_b) < 1e-3 * flux(&beside), "{} {}", flux(&behind_ring_b), flux(&beside));
    assert!(hidden_area_px(&behind_ring_b, mimas).abs() < 0.01);
}

/// Rings that are seen almost edge-on hide a strip of a moon behind them, not its entire light.
#[test]
fn a_moon_behind_rings_seen_edge_on_keeps_most_of_its_light() {
    let (titan, saturn) = (NaifId(606), NaifId(699));
    let is_lit = |t: Instant| angle_rad(from_to_km(titan, saturn, t), from_to_km(titan, NaifId::SUN, t)) < 1.3;
    let time = hour_in_2017(|t| (3500.0..4500.0).contains(&from_saturn_km(titan, t).z.abs()) && is_lit(t));
    let titan_km = from_saturn_km(titan, time);
    // The line of sight passes beside the globe, and meets the plane of the rings here at a right angle to the direction of the planet's centre.
    let to_crossing_km = |radius_km: f64| {
        let in_plane = titan_km.truncate().normalize().perp() * radius_km;
        in_plane.extend(0.0) - titan_km
    };
    let view_through = |radius_km: f64| {
        let direction = to_crossing_km(radius_km);
        view(titan, saturn_axes(time).transpose() * direction, 100.0 * direction.length(), 1.5, time, 31, ExposureRequest::Auto)
    };
    let flux = |scene: &Scene| scene.points.iter().find(|p| p.body == titan).map_or(0.0, |p| f64::from(p.flux.y));
    let transmitted = flux(&view_through(105_000.0)) / flux(&view_through(155_000.0));
    // Along the line of sight the opaque rings A and B end where their radius is 136 775 km, in front of a strip of this half height.
    let direction = to_crossing_km(105_000.0);
    let half_height_km = (136_775_f64.powi(2) - 105_000_f64.powi(2)).sqrt() * direction.z.abs() / direction.truncate().length();
    let hidden = 4.0 * half_height_km / (PI * SESSION.catalog().body(titan).expect("Titan").radii_km.x);
    assert!((0.05..0.3).contains(&hidden), "{hidden}");
    assert!((transmitted - (1.0 - hidden)).abs() < 0.06, "{transmitted}, hidden {hidden}");
}
