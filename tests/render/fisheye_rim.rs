//! Stars and points at the rim of a dome image: they end at its circle, and the ground hides stars there, too.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Up, ViewRequest};
use orrery::scene::{GLARE_RADIUS_EXPONENT, MIN_POINT_RADIUS_PX};
use orrery::session::DrawnFrame;
use orrery::time::Instant;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };
const SIDE: u32 = 200;
const JUPITER: NaifId = NaifId(599);
/// Half the diagonal of a pixel: a pixel whose middle is farther than this outside the circle is entirely outside.
const HALF_DIAGONAL_PX: f64 = 0.71;
/// How far below the horizon a pixel of a dome of 180 degrees may show the sky. The outermost samples of a texel are 0.375 texels from its middle, bilinear
/// interpolation reaches 1 texel, and the pixel's outermost points are 0.375 pixels from its middle. With texels of 0.57 degrees (a face of 200 pixels, at its
/// middle) and pixels of 0.9 degrees that makes 1.125 degrees along an axis, and 1.5 degrees across a horizon inclined by 25 degrees. Measured: 1.33 degrees.
const EDGE_DEG: f64 = 1.6;

/// A dome image of a night sky with much brightened stars.
fn dome(request: ViewRequest) -> DrawnFrame {
    let request = ViewRequest {
        composition: Composition { projection: Projection::Fisheye, ..Composition::default() },
        width: SIDE,
        height: SIDE,
        ..request
    };
    SESSION.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn")
}

fn night() -> ViewRequest {
    ViewRequest::of(JUPITER, Instant::parse("2024-01-20T22:00:00Z").expect("a time"))
}

/// Offset of a position from the middle of the image, y downwards.
fn from_middle(pixel: DVec2) -> DVec2 {
    pixel - 0.5 * f64::from(SIDE)
}

/// Offsets of a scene's sprites of stars from the middle, and their radii.
fn stars(drawn: &DrawnFrame) -> Vec<(DVec2, f64)> {
    let offset = |centre: glam::Vec3| centre.truncate().as_dvec2() * DVec2::new(1.0, -1.0) * 0.5 * f64::from(SIDE);
    drawn.scene.stars.iter().map(|s| (offset(s.centre), f64::from(s.radius_px))).collect()
}

/// From 48 degrees north, towards Jupiter, half of the circle shows the ground. The image differs from one without stars only within the circle, and above the
/// horizon to within [`EDGE_DEG`]. Many sprites lie across the circle, above and below the horizon.
#[test]
fn stars_light_neither_the_ground_at_the_rim_nor_what_is_outside_the_circle() {
    let view = |stars: bool| ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg: 48.0, longitude_deg: 11.0, height_km: 0.002 },
        up: Up::Zenith,
        fov_deg: Some(180.0),
        stars_boost_stops: 10.0,
        exposure: ExposureRequest::Stops(16.0),
        layers: Layers { stars, ..Layers::NONE },
        ..night()
    };
    let (with, without) = (dome(view(true)), dome(view(false)));
    let camera = &with.scene.camera;
    // The normal of the Earth's ellipsoid, which differs from the direction away from its centre by 0.2 degrees.
    let earth = with.scene.body(NaifId::EARTH).expect("the Earth").placement;
    let zenith = (earth.body_from_icrf.transpose() * (earth.camera_in_unit_sphere() / earth.radii_km)).normalize();
    let circle_px = 0.5 * f64::from(SIDE);
    // Altitude of the direction at an offset from the middle.
    let altitude_deg = |offset: DVec2| {
        let angle = offset.length() / circle_px * 90_f64.to_radians();
        let radial = offset.normalize_or_zero() * angle.sin();
        let direction: DVec3 = camera.right * radial.x - camera.up * radial.y + camera.forward * angle.cos();
        direction.dot(zenith).asin().to_degrees()
    };
    let (mut lit_in_sky, mut lit_elsewhere) = (0, 0);
    for (k, (a, b)) in with.frame.hdr.iter().zip(&without.frame.hdr).enumerate() {
        let offset = from_middle(DVec2::new(f64::from(k as u32 % SIDE) + 0.5, f64::from(k as u32 / SIDE) + 0.5));
        let is_outside = offset.length() > circle_px + HALF_DIAGONAL_PX;
        if a != b && (is_outside || altitude_deg(offset) < -EDGE_DEG) {
            lit_elsewhere += 1;
        }
        lit_in_sky += usize::from(a != b && !is_outside);
        assert!(!is_outside || a[..3] == [0.0; 3], "{offset}: {a:?}");
    }
    let across = |is_above: bool| {
        let crosses =
            |(offset, radius): &&(DVec2, f64)| offset.length() + radius > circle_px + 1.0 && (altitude_deg(*offset) > 0.0) == is_above;
        stars(&with).iter().filter(crosses).count()
    };
    println!("{lit_in_sky} pixels; sprites across the circle: {} above the horizon, {} below", across(true), across(false));
    assert!(lit_elsewhere == 0 && lit_in_sky > 1000, "{lit_elsewhere} {lit_in_sky}");
    // The case arises: without the black outside the circle, these sprites would light it.
    assert!(across(true) > 5 && across(false) > 5, "{} {}", across(true), across(false));
}

/// The glare of Jupiter, a point, ends at the circle; with Jupiter nearer to the circle than the radius of the smallest sprite, at this radius. Control: far
/// from the circle the glare is as wide as in the middle, for the smaller pixels.
#[test]
fn the_glare_of_a_point_ends_at_the_circle() {
    const FOV_DEG: f64 = 20.0;
    let view = |look: Look| ViewRequest {
        position: Position::Offset { body: NaifId::EARTH, offset_km: DVec3::Z * 20_000.0, axes: Axes::Icrf },
        look,
        fov_deg: Some(FOV_DEG),
        exposure: ExposureRequest::Stops(18.0),
        layers: Layers::NONE,
        ..night()
    };
    let middle = dome(view(Look::Target));
    let to_jupiter = middle.scene.body(JUPITER).expect("Jupiter").placement.centre_km.normalize();
    let sprite = |drawn: &DrawnFrame| drawn.scene.points.iter().find(|p| p.body == JUPITER).map(|p| (p.centre, f64::from(p.radius_px)));
    let (_, widest_px) = sprite(&middle).expect("Jupiter");
    assert!(widest_px > 6.0, "{widest_px}");
    let sideways = to_jupiter.any_orthonormal_vector();
    for from_circle_px in [1.0, 2.5, 4.0, 20.0] {
        let angle = (0.5 * FOV_DEG - from_circle_px * FOV_DEG / f64::from(SIDE)).to_radians();
        let drawn = dome(view(Look::Along { direction: to_jupiter * angle.cos() + sideways * angle.sin(), axes: Axes::Icrf }));
        let (centre, radius_px) = sprite(&drawn).expect("Jupiter");
        let distance_px = 0.5 * f64::from(SIDE) * (1.0 - f64::from(centre.truncate().length()));
        assert!((distance_px - from_circle_px).abs() < 0.1, "{distance_px} pixels, {from_circle_px} expected");
        // A fisheye's pixels cover less sky farther from the middle, so the same light fills them with more radiance.
        let unlimited_px = widest_px * (angle / angle.sin()).powf(GLARE_RADIUS_EXPONENT);
        let expected_px = unlimited_px.min(distance_px).max(MIN_POINT_RADIUS_PX);
        assert!((radius_px - expected_px).abs() < 0.001, "{radius_px} pixels, {distance_px} from the circle, {expected_px} expected");
    }
}
