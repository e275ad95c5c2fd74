//! Mirrored images: they are the flipped images of the same views, but their texts are not mirrored.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::image::DisplayImage;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{
    Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Stereo, StereoLayout, Up, ViewRequest,
};
use orrery::session::DrawnFrame;
use orrery::time::Instant;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };
/// A multiple of twice the spacing of the coarse image of the air, whose points then are symmetric.
const SIDE: u32 = 128;
const SATURN: NaifId = NaifId(699);

fn draw(request: &ViewRequest) -> DrawnFrame {
    SESSION.draw(request, SAMPLING, FrameImages::Display).expect("drawn")
}

fn image(drawn: &DrawnFrame) -> DisplayImage {
    DisplayImage { width: drawn.frame.width, height: drawn.frame.height, rgba: drawn.frame.display.clone() }
}

fn flipped(image: &DisplayImage) -> DisplayImage {
    DisplayImage { rgba: image.rgba.chunks(image.width as usize).flat_map(|row| row.iter().rev().copied()).collect(), ..*image }
}

fn view_of(target: NaifId, time: &str) -> ViewRequest {
    ViewRequest { width: SIDE, height: SIDE, ..ViewRequest::of(target, Instant::parse(time).expect("a time")) }
}

/// Views of ellipsoids, rings, air, clouds and stars, and composed images, none of them symmetric.
fn views() -> Vec<(&'static str, ViewRequest)> {
    let up = Up::Along { direction: DVec3::new(0.7, -0.5, 0.5), axes: Axes::Icrf };
    let saturn = ViewRequest { up, ..view_of(SATURN, "2017-05-17T00:00:00Z") };
    let earth = view_of(NaifId::EARTH, "2024-04-08T18:17:16Z");
    let milky_way = ViewRequest {
        target: None,
        position: Position::Centre(NaifId::EARTH),
        look: Look::Along { direction: DVec3::new(0.0, -0.94, -0.34), axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(70.0),
        stars_boost_stops: 3.0,
        ..view_of(NaifId::EARTH, "2024-06-07T00:00:00Z")
    };
    let dusk = ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg: 50.0, longitude_deg: 10.0, height_km: 0.1 },
        up: Up::Zenith,
        fov_deg: Some(90.0),
        ..view_of(NaifId::MOON, "2024-04-12T19:00:00Z")
    };
    let composed = |composition: Composition, request: &ViewRequest| ViewRequest { composition, ..request.clone() };
    let sphere = |projection| Composition { projection, ..Composition::default() };
    let tilted_dome = Composition { is_zenith_centred: true, tilt_deg: 20.0, ..sphere(Projection::Fisheye) };
    let pair = Composition { stereo: Some(Stereo { layout: StereoLayout::SideBySide, eye_separation_km: None }), ..Composition::default() };
    vec![
        ("dome", ViewRequest { fov_deg: Some(180.0), ..composed(tilted_dome, &dusk) }),
        ("whole sphere", ViewRequest { fov_deg: None, height: SIDE / 2, ..composed(sphere(Projection::Equirectangular), &dusk) }),
        ("stereo pair", composed(pair, &saturn)),
        ("dusk", dusk),
        ("saturn", saturn),
        ("earth", earth),
        ("milky way", milky_way),
    ]
}

/// The differences are those of four samples per pixel, which are not symmetric. As a negative control, the image that is not flipped differs.
#[test]
fn a_mirrored_image_is_the_flipped_image() {
    for (name, request) in views() {
        let plain = draw(&request);
        let mirrored = ViewRequest { is_mirrored: true, ..request };
        // The samples of the light meter are not all symmetric.
        let (stops, mirrored_stops) = (plain.scene.exposure.stops, draw(&mirrored).scene.exposure.stops);
        assert!((mirrored_stops - stops).abs() < 0.1, "{name}: {mirrored_stops} stops, not {stops}");
        let (plain, mirrored) = (image(&plain), image(&draw(&ViewRequest { exposure: ExposureRequest::Stops(stops), ..mirrored })));
        let difference = mirrored.difference(&flipped(&plain)).expect("one size");
        let without_flip = mirrored.difference(&plain).expect("one size").mean;
        println!("{name}: mean {:.3}, 99.9 % {}; not flipped: {without_flip:.2}", difference.mean, difference.p999);
        assert!(difference.mean < 0.25, "{name}: mean {}", difference.mean);
        assert!(without_flip > 0.5 && without_flip > 4.0 * difference.mean, "{name}: {without_flip} if not flipped");
    }
}

/// The caption has the same pixels in both images, and bodies have their names where the flipped image shows them.
#[test]
fn texts_are_not_mirrored() {
    let view = view_of(SATURN, "2017-05-17T00:00:00Z");
    let position = Position::AboveTarget { towards: None, distance_radii: Some(40.0) };
    let layers = Layers { labels: true, caption: true, ..Layers::NONE };
    let [plain, mirrored] =
        [false, true].map(|is_mirrored| draw(&ViewRequest { is_mirrored, position, layers, width: 320, height: 320, ..view.clone() }));
    let labels_of = |drawn: &DrawnFrame| drawn.scene.labels.as_ref().expect("labels").labels.clone();
    let (labels, mirrored_labels) = (labels_of(&plain), labels_of(&mirrored));
    assert!(labels.len() >= 3, "{labels:?}");
    for label in &labels {
        let other = mirrored_labels.iter().find(|other| other.body == label.body).expect("in both images");
        let expected_px = DVec2::new(320.0 - label.centre_px.x, label.centre_px.y);
        assert!(other.centre_px.distance(expected_px) < 1e-6, "{}: {}, not {expected_px}", label.name, other.centre_px);
        let direction = |drawn: &DrawnFrame, at: DVec2| drawn.scene.geometry.direction(&drawn.scene.camera, at).expect("a direction");
        assert!(direction(&plain, label.centre_px).distance(direction(&mirrored, other.centre_px)) < 1e-9, "{}", label.name);
    }
    // The caption is in the last rows, with no body nearby.
    let (plain, mirrored) = (image(&plain), image(&mirrored));
    let caption_rows = |image: &DisplayImage| image.rgba[image.rgba.len() - 320 * 40..].to_vec();
    let caption = caption_rows(&plain);
    assert!(caption.iter().filter(|p| p[0] > 100).count() > 100, "no caption");
    assert!(caption == caption_rows(&mirrored) && caption != caption_rows(&flipped(&plain)));
}
