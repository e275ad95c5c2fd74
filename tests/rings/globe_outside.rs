//! Rings in images and in faces of whole-sphere images that do not show the globe, also with the globe behind the camera: every pixel of the dense rings is
//! lit.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Purpose, Up, ViewRequest};
use orrery::session::DrawnFrame;
use orrery::time::Instant;
use std::f64::consts::{FRAC_PI_2, PI};

const SATURN: NaifId = NaifId(699);
const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };
/// Side of the perspective image, and height of the whole-sphere image.
const HEIGHT: u32 = 64;
/// Radii of the B and of the A ring without their edges.
const DENSE_RINGS_KM: [(f64, f64); 2] = [(94_000.0, 115_000.0), (123_500.0, 135_000.0)];
/// Half the green light of their faintest pixel in these views.
const MIN_LIGHT: f32 = 5e-5;
/// The camera, 1.5 radii from Saturn's centre over the sunlit side of the rings; body axes.
const CAMERA_RADII: DVec3 = DVec3::new(-1.103_428, 0.765_133, 0.668_594);

/// A view from [`CAMERA_RADII`] along the ring plane: 1 looks away from Saturn's axis, -1 towards it. No light but that of Saturn, its rings and its moons.
fn view(outwards: f64, effects: &str) -> ViewRequest {
    let radius_km = SESSION.catalog().body(SATURN).expect("Saturn").radii_km.x;
    ViewRequest {
        target: None,
        position: Position::Offset { body: SATURN, offset_km: CAMERA_RADII * radius_km, axes: Axes::BodyFixed },
        look: Look::Along { direction: CAMERA_RADII.truncate().extend(0.0) * outwards, axes: Axes::BodyFixed },
        up: Up::Along { direction: DVec3::Z, axes: Axes::BodyFixed },
        fov_deg: Some(110.0),
        exposure: ExposureRequest::Stops(6.0),
        purpose: Purpose::LINEAR,
        width: HEIGHT,
        height: HEIGHT,
        layers: Layers::NONE,
        effects: EffectOverrides::parse(&format!("-glow,-corona,-body-shadow{effects}")).expect("effects"),
        ..ViewRequest::of(SATURN, Instant::parse("2017-05-17T00:00:00Z").expect("a time"))
    }
}

/// The green light of the pixels in whose middle a dense ring is in front of the sky. `direction`: that of a pixel's middle in the camera's axes (right, up,
/// forward).
fn light_of_dense_rings(drawn: &DrawnFrame, direction: impl Fn(DVec2) -> Option<DVec3>) -> Vec<f32> {
    let (camera, width) = (&drawn.scene.camera, drawn.scene.camera.width as usize);
    let placement = &drawn.scene.body(SATURN).expect("Saturn").placement;
    let viewer_km = placement.body_from_icrf * -placement.centre_km;
    let in_dense_ring = |pixel: DVec2| {
        let Some(d) = direction(pixel) else { return false };
        let ray = placement.body_from_icrf * (camera.right * d.x + camera.up * d.y + camera.forward * d.z);
        let distance = -viewer_km.z / ray.z;
        let radius_km = (viewer_km + ray * distance).truncate().length();
        // The globe widened by a tenth, in axes in which it is a sphere.
        let (origin, towards) = (viewer_km / placement.radii_km, (ray / placement.radii_km).normalize());
        let is_near_globe = origin.dot(towards) < 0.0 && origin.cross(towards).length() < 1.1;
        distance > 0.0 && !is_near_globe && DENSE_RINGS_KM.iter().any(|(inner, outer)| (*inner..*outer).contains(&radius_km))
    };
    let middle = |k: usize| DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
    drawn.frame.hdr.iter().enumerate().filter(|(k, _)| in_dense_ring(middle(*k))).map(|(_, p)| p[1]).collect()
}

/// Asserts that all pixels of the dense rings are lit, and that the same pixels are dark without rings.
fn assert_lit(outwards: f64, composition: &Composition, width: u32, min_pixels: usize, direction: impl Fn(DVec2) -> Option<DVec3>) {
    let light = |effects: &str| {
        let request = ViewRequest { composition: composition.clone(), width, ..view(outwards, effects) };
        light_of_dense_rings(&SESSION.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn"), &direction)
    };
    let lit = |light: &[f32]| light.iter().filter(|l| **l > MIN_LIGHT).count();
    let (with_rings, without) = (light(""), light(",-rings"));
    println!("{} of {} pixels are lit, {} without rings", lit(&with_rings), with_rings.len(), lit(&without));
    assert!(with_rings.len() >= min_pixels && lit(&with_rings) == with_rings.len(), "{} of {}", lit(&with_rings), with_rings.len());
    // Negative control. The points of moons may light some pixels.
    assert!(lit(&without) * 50 < without.len(), "{} of {}", lit(&without), without.len());
}

/// A camera that looks away from Saturn, whose tangent cone is entirely behind it, sees the rings in front of it.
#[test]
fn rings_are_drawn_in_front_of_a_camera_that_looks_away_from_their_globe() {
    let tangent = 55_f64.to_radians().tan();
    let direction = |pixel: DVec2| {
        let clip = 2.0 * pixel / f64::from(HEIGHT) - 1.0;
        Some(DVec3::new(clip.x * tangent, -clip.y * tangent, 1.0))
    };
    assert_lit(1.0, &Composition::default(), HEIGHT, 400, direction);
}

/// The face opposite to Saturn has its part of the rings.
#[test]
fn every_face_of_a_whole_sphere_image_has_its_part_of_the_rings() {
    let composition = Composition { projection: Projection::Equirectangular, ..Composition::default() };
    let of_pixel = |pixel: DVec2| {
        let radians = pixel / f64::from(HEIGHT) * PI;
        let (longitude, latitude) = (radians.x - PI, FRAC_PI_2 - radians.y);
        DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos())
    };
    let in_last_face = |pixel: DVec2| Some(of_pixel(pixel)).filter(|d| -d.z > d.x.abs().max(d.y.abs()));
    assert_lit(-1.0, &composition, 2 * HEIGHT, 60, in_last_face);
    assert_lit(-1.0, &composition, 2 * HEIGHT, 600, |pixel| Some(of_pixel(pixel)));
}
