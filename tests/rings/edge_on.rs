//! Rings seen almost edge-on, down to a hundredth of a pixel high: their light depends neither on where their plane lies among the pixels nor on the size
//! of the pixels, and is proportional to their height.

use crate::support::folds::{larger, smaller};
use crate::support::session::{SESSION, session_with_edits};
use crate::support::sweep;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;
use std::ops::Range;

const SATURN: NaifId = NaifId(699);
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };
/// Outer edge of the A ring, equatorial radii.
const OUTER_RADII: f64 = 2.27;
/// 30 degrees east of the subsolar point in all views, degrees.
const LONGITUDE_DEG: f64 = 172.0;
/// Size in pixels of the images with the entire globe, and half the height that they show at its distance, equatorial radii.
const WIDTH: u32 = 96;
const HEIGHT: u32 = 32;
const HALF_HEIGHT_RADII: f64 = 1.6;
/// Columns of these images beside the globe, with the rings from 1.3 to 2.4 radii from its middle.
const COLUMNS: Range<usize> = 24..35;
/// The plane is moved by a pixel in as many steps.
const SHIFTS: u32 = 6;

/// A camera above a longitude of Saturn, at a height above the ring plane, that looks in a direction; body axes, equatorial radii. 2017-05-17: the Sun is 27
/// degrees north of the plane.
fn view(distance: f64, plane_height: f64, direction: impl Fn(DVec3) -> DVec3, fov_deg: f64, size: [u32; 2]) -> ViewRequest {
    let radius_km = SESSION.catalog().body(SATURN).expect("Saturn").radii_km.x;
    let (sin, cos) = LONGITUDE_DEG.to_radians().sin_cos();
    let position = (DVec3::new(cos, sin, 0.0) * (distance * distance - plane_height * plane_height).sqrt()).with_z(plane_height);
    ViewRequest {
        target: None,
        position: Position::Offset { body: SATURN, offset_km: position * radius_km, axes: Axes::BodyFixed },
        look: Look::Along { direction: direction(position), axes: Axes::BodyFixed },
        up: Up::Along { direction: DVec3::Z, axes: Axes::BodyFixed },
        fov_deg: Some(fov_deg),
        exposure: ExposureRequest::Stops(0.0),
        purpose: Purpose::LINEAR,
        width: size[0],
        height: size[1],
        layers: Layers::NONE,
        ..ViewRequest::of(SATURN, Instant::parse("2017-05-17T00:00:00Z").expect("a time"))
    }
}

/// Green light of the rings in some columns: that of the image, less that of the image without rings.
fn ring_light(session: &Session, request: &ViewRequest, columns: &Range<usize>) -> f64 {
    let light = |effects: &str| {
        let request = ViewRequest { effects: EffectOverrides::parse(effects).expect("effects"), ..request.clone() };
        let pixels = session.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr;
        let in_columns = pixels.iter().enumerate().filter(|(k, _)| columns.contains(&(k % request.width as usize)));
        in_columns.map(|(_, p)| f64::from(p[1])).sum::<f64>()
    };
    light("") - light("-rings")
}

/// Light beside the globe of rings that would be `height_px` pixels high if they were as far away as the globe's centre, with their plane in several places
/// within a pixel.
fn light_by_shift(session: &Session, distance: f64, height_px: f64) -> Vec<f64> {
    let pixel_tangent = 2.0 * HALF_HEIGHT_RADII / distance / f64::from(HEIGHT);
    let plane_height = distance * height_px * pixel_tangent * distance / (2.0 * OUTER_RADII);
    let fov_deg = 2.0 * (HALF_HEIGHT_RADII / distance).atan().to_degrees();
    let light = |shift: u32| {
        let direction = |position: DVec3| DVec3::Z * (pixel_tangent * f64::from(shift) / f64::from(SHIFTS)) - position.normalize();
        ring_light(session, &view(distance, plane_height, direction, fov_deg, [WIDTH, HEIGHT]), &COLUMNS)
    };
    (0..SHIFTS).map(light).collect()
}

/// Mean, and difference of the extremes divided by the mean.
fn mean_and_spread(light: &[f64]) -> (f64, f64) {
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let (least, greatest) = light.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), l| (smaller(a, *l), larger(b, *l)));
    (mean, (greatest - least) / mean)
}

/// Symmetric ends of a footprint, at half its length at the middle's depth from there, as before perspective was exact.
const SYMMETRIC_ENDS: [(&str, &str, &str); 5] = [
    ("lib/ring/footprint.wesl", "let near_ray = in.ray - half_ray;", "let near_ray = in.ray;"),
    ("lib/ring/footprint.wesl", "let near_anchor = in.anchor - anchor_depth * half_ray;", "let near_anchor = in.anchor;"),
    ("lib/ring/footprint.wesl", "let far_descent = (in.ray.z + half_ray.z) * descent_sign;", "let far_descent = near_descent;"),
    (
        "lib/ring/footprint.wesl",
        "let near_t = dot(",
        "let near_t = -0.5 * camera_height * recession_length * per_near_descent * per_near_descent + dot(",
    ),
    ("lib/ring/footprint.wesl", "-2.0 * half_ray.z", "0.0 * half_ray.z"),
];

/// Both halves of the rings blended as if each covered the entire pixel.
const BLENDED_HALVES: [(&str, &str, &str); 1] = [("lib/ring/surface.wesl", "max(1.0 - opacity_in_front, max(coverage, 1.0e-6))", "1.0")];

/// From 3 to 200 radii. Measured spread: 0.053 from 3 radii, at most 0.014 from farther away.
#[test]
fn light_does_not_depend_on_where_the_plane_lies_within_a_pixel() {
    let mut case = 0;
    for (distance, max_spread) in [(3.0, 0.08), (6.0, 0.025), (25.0, 0.01), (60.0, 0.01), (200.0, 0.01)] {
        for height_px in [3.0, 1.0, 0.3, 0.1, 0.03, 0.01] {
            case += 1;
            if !sweep::runs(case, 3) {
                continue;
            }
            let (mean, spread) = mean_and_spread(&light_by_shift(&SESSION, distance, height_px));
            println!("{distance} radii, {height_px} pixels: light {mean:.3e}, spread {spread:.4}");
            assert!(mean > 0.0 && spread < max_spread, "{distance} radii, {height_px} pixels: light {mean}, spread {spread}");
        }
    }
}

/// Negative controls of the test above. Measured spreads: 5.0 and 1.4 with symmetric ends, 0.17 with blended halves.
#[test]
fn symmetric_ends_and_blended_halves_make_light_depend_on_the_place_of_the_plane() {
    let symmetric = session_with_edits(&SYMMETRIC_ENDS);
    for (distance, height_px) in [(6.0, 0.1), (60.0, 0.1)] {
        let (_, spread) = mean_and_spread(&light_by_shift(&symmetric, distance, height_px));
        assert!(spread > 1.0, "symmetric ends, {distance} radii, {height_px} pixels: {spread}");
    }
    let blended = session_with_edits(&BLENDED_HALVES);
    for distance in [6.0, 200.0] {
        let (_, spread) = mean_and_spread(&light_by_shift(&blended, distance, 1.0));
        assert!(spread > 0.12, "blended halves, {distance} radii: {spread}");
    }
}

/// A hundredth of a pixel high, rings have a hundredth of the light of rings one pixel high, within 10 % (measured: 6 % at 6 radii, 2 % farther away); with
/// the camera in their plane they have none. Negative control: symmetric ends, with the plane between two rows.
#[test]
fn light_is_proportional_to_the_height() {
    let per_pixel = |session: &Session, distance: f64, height_px: f64| light_by_shift(session, distance, height_px)[0] / height_px;
    for distance in [6.0, 25.0, 200.0] {
        let ratio = per_pixel(&SESSION, distance, 0.01) / per_pixel(&SESSION, distance, 1.0);
        println!("{distance} radii: {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.1, "{distance} radii: {ratio}");
        // From 6 radii the camera is in the E ring, whose light remains.
        let edge_on = larger(mean_and_spread(&light_by_shift(&SESSION, distance, 0.0)).0, 0.0);
        assert!(edge_on < 0.2 * 0.01 * per_pixel(&SESSION, distance, 1.0), "{distance} radii: {edge_on} edge-on");
    }
    let symmetric = session_with_edits(&SYMMETRIC_ENDS);
    let ratio = per_pixel(&symmetric, 6.0, 0.01) / per_pixel(&symmetric, 6.0, 1.0);
    assert!(ratio < 0.5, "symmetric ends: {ratio}");
}

/// In a telescope 6 radii away, 1 km above the plane, a pixel covers several radii of the plane, although view rays are flatter than the tables' flattest
/// slant. Pixels of a quarter of the size have the same light. Negative control: one segment per footprint.
#[test]
fn light_does_not_depend_on_the_size_of_pixels_in_a_telescope() {
    const SIZE: [u32; 2] = [60, 40];
    const PIXEL_TANGENT: f64 = 1e-4;
    // At the outer part of the rings, beside the globe.
    let direction = |position: DVec3| {
        let towards = DVec3::Z.cross(position).normalize() * 1.8 - position;
        towards.normalize() + DVec3::Z * (0.3 * PIXEL_TANGENT)
    };
    let fov_deg = 2.0 * (PIXEL_TANGENT * f64::from(SIZE[1]) / 2.0).atan().to_degrees();
    // Mean light per pixel.
    let light = |session: &Session, scale: u32| {
        let request = view(6.0, 2e-5, direction, fov_deg, SIZE.map(|s| s * scale));
        ring_light(session, &request, &(0..request.width as usize)) / f64::from(scale * scale)
    };
    let difference = |session: &Session| (light(session, 1) / light(&SESSION, 4) - 1.0).abs();
    let one_segment = session_with_edits(&[("lib/ring/surface.wesl", "draw.ring_segments", "1.0")]);
    let (found, control) = (difference(&SESSION), difference(&one_segment));
    println!("relative difference {found:.4}, with one segment {control:.4}");
    assert!(found < 0.05 && control > 0.3, "{found}, with one segment {control}");
}
