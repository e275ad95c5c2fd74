//! Names of stars and constellations in dome images and whole-sphere images: beside their stars, in every face and across the edges of faces, and none of what
//! the ground hides.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::catalog::constellations::Constellations;
use orrery::catalog::stars::star_name;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::camera::sphere::SphereImage;
use orrery::scene::composite::{Arrangement, CompositeFrames};
use orrery::scene::labels::LabelMetrics;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Up, ViewRequest};
use orrery::time::Instant;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 1 };
/// A degree spans about three pixels in both projections.
const HEIGHT: u32 = 560;
/// Largest distance from a star to its name, pixels: the marker's radius and the gap beside it, at glyphs of 13 pixels.
const MAX_GAP_PX: f64 = 14.0;

fn view(position: Position, projection: Projection, layers: Layers) -> ViewRequest {
    ViewRequest {
        target: None,
        position,
        look: Look::Along { direction: DVec3::new(-0.8, 0.5, 0.1), axes: Axes::Icrf },
        up: Up::Celestial,
        fov_deg: Some(180.0),
        width: if projection == Projection::Fisheye { HEIGHT } else { 2 * HEIGHT },
        height: HEIGHT,
        exposure: ExposureRequest::Stops(16.0),
        layers,
        composition: Composition { projection, ..Composition::default() },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-03-01T22:00:00Z").expect("a time"))
    }
}

fn with_names() -> Layers {
    Layers { stars: true, star_names: true, constellations: true, ..Layers::NONE }
}

/// The scene of the entire image, and the image's projection.
fn scene_and_image(request: &ViewRequest) -> (Scene, SphereImage) {
    let frames = CompositeFrames::of(SESSION.catalog(), SESSION.ephemeris(), request).expect("frames");
    let Arrangement::Faces(faces) = frames.arrangement else { panic!("faces") };
    (SESSION.plan(request, SAMPLING).expect("a plan").0, faces.image)
}

/// The named stars of the catalog, without proper motion and aberration: together less than a tenth of a pixel here.
fn named_stars() -> Vec<(&'static str, DVec3)> {
    let stars = SESSION.catalog().stars();
    stars.stars().iter().filter_map(|s| Some((star_name(s.hip)?, s.direction))).collect()
}

/// A point near the Earth from which it hides a small part of the sky.
fn in_space() -> Position {
    Position::Offset { body: NaifId::EARTH, offset_km: DVec3::new(0.3, -0.2, -0.9) * 60_000.0, axes: Axes::Icrf }
}

/// Most names of stars are at the right of their stars, the others have no room; names of constellations are centred on their places. Control: half a degree
/// away from its star no name would be found.
#[test]
fn names_are_beside_their_stars_and_on_their_constellations() {
    for projection in [Projection::Fisheye, Projection::Equirectangular] {
        let (scene, image) = scene_and_image(&view(in_space(), projection, with_names()));
        let layer = scene.line_texts.expect("names");
        let metrics = LabelMetrics::of_size(layer.glyph_px);
        let mut numbers = [0; 3];
        let [beside, displaced, constellations] = &mut numbers;
        for (name, direction) in named_stars() {
            let Some(star_px) = image.pixel(image.in_axes(direction)) else { continue };
            let is_beside = |star_px: DVec2| {
                // A name may be right of the left edge of the image, and its star left of the right edge.
                let right_px = |left_end_px: DVec2| (left_end_px.x - star_px.x).rem_euclid(f64::from(image.width));
                let is_right_of_it = |left_end_px: DVec2| (left_end_px.y - star_px.y).abs() < 0.5 && right_px(left_end_px) < MAX_GAP_PX;
                layer.texts.iter().any(|t| t.text == name && is_right_of_it(t.left_end_px))
            };
            *beside += usize::from(is_beside(star_px));
            *displaced += usize::from(is_beside(star_px + DVec2::new(0.0, 1.5)));
        }
        for constellation in &Constellations::embedded().all {
            let Some(place_px) = image.pixel(image.in_axes(constellation.label_direction)) else { continue };
            let left_end_px = place_px - DVec2::new(0.5 * metrics.width_px(&constellation.name), 0.0);
            let is_there = layer.texts.iter().any(|t| t.text == constellation.name && t.left_end_px.distance(left_end_px) < 0.5);
            *constellations += usize::from(is_there);
        }
        println!("{projection:?}: {numbers:?} of {} texts", layer.texts.len());
        let [beside, displaced, constellations] = numbers;
        assert!(beside > 25 && constellations > 15 && displaced == 0, "{projection:?}: {numbers:?}");
        // Every text is one of these.
        assert_eq!(beside + constellations, layer.texts.len(), "{projection:?}");
    }
    let (scene, _) = scene_and_image(&view(in_space(), Projection::Fisheye, Layers { stars: true, ..Layers::NONE }));
    assert_eq!(scene.line_texts, None);
}

/// On the ground, under a sky that is dark, no star below the horizon has a name. Control: the same directions have names where no ground hides them.
#[test]
fn what_the_ground_hides_has_no_name() {
    let on_ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 20.0, longitude_deg: 40.0, height_km: 0.002 };
    let ([names_on_ground, names_in_space], zenith) = {
        let (scene, _) = scene_and_image(&view(on_ground, Projection::Equirectangular, with_names()));
        let zenith = -scene.body(NaifId::EARTH).expect("the Earth").placement.centre_km.normalize();
        let (other, _) = scene_and_image(&view(in_space(), Projection::Equirectangular, with_names()));
        ([scene, other].map(|s| s.line_texts.expect("names").texts), zenith)
    };
    let below: Vec<&str> = named_stars().into_iter().filter(|(_, d)| d.dot(zenith) < -0.05).map(|(name, _)| name).collect();
    let count = |texts: &[orrery::scene::line_texts::PlacedText]| texts.iter().filter(|t| below.contains(&t.text.as_str())).count();
    println!("{} names on the ground, {} of stars below its horizon in space", names_on_ground.len(), count(&names_in_space));
    assert!(count(&names_on_ground) == 0 && names_on_ground.len() > 15, "{}", count(&names_on_ground));
    assert!(count(&names_in_space) > 10, "{}", count(&names_in_space));
}

/// The names are drawn: they change the image.
#[test]
fn names_are_in_the_image() {
    let display = |layers: Layers| {
        SESSION.draw(&view(in_space(), Projection::Fisheye, layers), SAMPLING, FrameImages::Display).expect("drawn").frame.display
    };
    let (with, without) = (display(with_names()), display(Layers { star_names: false, ..with_names() }));
    let changed = with.iter().zip(&without).filter(|(a, b)| a != b).count();
    assert!(changed > 1000, "{changed} pixels");
}
