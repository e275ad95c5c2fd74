//! Stars and points in equirectangular images: the same place, light and angular size at every latitude, also over a pole. Markers on the seam.

use crate::support::session::SESSION;
use glam::{DMat3, DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::apparent::aberrated;
use orrery::render::plan::SamplingQuality;
use orrery::scene::composite::{Arrangement, CompositeFrames};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::photometry::irradiance_of_magnitude;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Purpose, Up, ViewRequest};
use orrery::scene::viewpoint::viewer;
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use std::f64::consts::PI;

const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };
/// An image of 1 degree per pixel.
const HEIGHT_PX: u32 = 180;
const RAD_PER_PX: f64 = PI / 180.0;
/// Visual magnitude of the star in all tests.
const STAR_MAGNITUDE: f64 = 1.36;

/// What an image shows around a star, by the directions and solid angles of its pixels.
#[derive(Debug)]
struct Measured {
    /// Angle from the star to the centroid of the light, pixels.
    offset_px: f64,
    /// Light in the image divided by the star's irradiance; 1 is expected.
    light: f64,
    /// Root mean square distances of the light from the star along its parallel and along its meridian, pixels.
    spread_px: DVec2,
}

/// An equirectangular image of the stars, with these directions (ICRF) towards its middle and its upper edge.
fn sky_image(position: Position, towards: DVec3, up: DVec3) -> ViewRequest {
    ViewRequest {
        target: None,
        position,
        look: Look::Along { direction: towards, axes: Axes::Icrf },
        up: Up::Along { direction: up, axes: Axes::Icrf },
        exposure: ExposureRequest::Stops(0.0),
        purpose: Purpose::LINEAR,
        width: 2 * HEIGHT_PX,
        height: HEIGHT_PX,
        layers: Layers { stars: true, ..Layers::NONE },
        composition: Composition { projection: Projection::Equirectangular, ..Composition::default() },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-03-01T00:00:00Z").expect("a time"))
    }
}

/// The only star of the session in an image in which it is at this latitude.
fn measure(session: &Session, latitude_deg: f64, exposure_stops: f64) -> Measured {
    let star = *session.catalog().stars().stars().first().expect("a star");
    let sideways = star.direction.any_orthonormal_vector();
    let (sin, cos) = latitude_deg.to_radians().sin_cos();
    let pole = star.direction * sin + sideways * cos;
    let request = ViewRequest {
        exposure: ExposureRequest::Stops(exposure_stops),
        ..sky_image(Position::Centre(NaifId::EARTH), star.direction.cross(sideways) + 0.3 * sideways, pole)
    };
    let frames = CompositeFrames::of(session.catalog(), session.ephemeris(), &request).expect("frames");
    let Arrangement::Faces(faces) = frames.arrangement else { panic!("faces") };
    let perspective = ViewRequest { composition: Composition::default(), ..request.clone() };
    let velocity = viewer(session.catalog(), session.ephemeris(), &perspective).expect("a viewer").sky_aberration_velocity_km_s;
    let seen = faces.image.in_axes(aberrated(star.direction, velocity));
    let parallel = DVec3::Y.cross(seen).normalize();
    let meridian = seen.cross(parallel);
    let drawn = session.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn");
    let (mut sum, mut moment, mut squares) = (0.0, DVec3::ZERO, DVec2::ZERO);
    for (k, pixel) in drawn.frame.hdr.iter().enumerate() {
        let (x, y) = (k as u32 % (2 * HEIGHT_PX), k as u32 / (2 * HEIGHT_PX));
        let longitude = (f64::from(x) + 0.5) * RAD_PER_PX - PI;
        let latitude = 0.5 * PI - (f64::from(y) + 0.5) * RAD_PER_PX;
        let direction = DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos());
        // Only near the star: elsewhere the image has planets, which are drawn as points.
        if angle_rad(direction, seen) < 9.0 * RAD_PER_PX {
            let light = f64::from(pixel[1]) * RAD_PER_PX * 2.0 * (0.5 * RAD_PER_PX).sin() * latitude.cos();
            sum += light;
            moment += direction * light;
            squares += light * DVec2::new(direction.dot(parallel), direction.dot(meridian)).powf(2.0);
        }
    }
    Measured {
        offset_px: angle_rad(moment, seen) / RAD_PER_PX,
        light: sum / PI / irradiance_of_magnitude(STAR_MAGNITUDE),
        spread_px: (squares / sum).powf(0.5) / RAD_PER_PX,
    }
}

/// At exposure 0 a star has no glare; at 32 stops its glare has the largest radius. Near a pole the face's pixels blur the star.
#[test]
fn a_star_has_the_same_size_at_every_latitude() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stars.csv");
    std::fs::write(&file, format!("ra_deg,dec_deg,v_mag\n152.093,11.967,{STAR_MAGNITUDE}\n")).expect("written");
    let sources = Sources { stars: Some(file), cache: Some(folder.path().join("cache")), ..Sources::default() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
    for exposure_stops in [0.0, 32.0] {
        let equator = measure(&session, 0.0, exposure_stops);
        assert!((equator.spread_px.x / equator.spread_px.y - 1.0).abs() < 0.05, "{equator:?}");
        for latitude_deg in [20.0, 44.0, 46.0, 59.5, 60.5, 75.0, 84.0, 88.3, 89.7, 90.0, -63.0, -89.1] {
            let there = measure(&session, latitude_deg, exposure_stops);
            println!("{exposure_stops} stops, latitude {latitude_deg}: {there:?}");
            assert!(there.offset_px < 0.15, "latitude {latitude_deg}: {there:?}");
            assert!((there.light - 1.0).abs() < 0.12, "latitude {latitude_deg}: {there:?}");
            let ratios = there.spread_px / equator.spread_px;
            assert!(ratios.min_element() > 0.75 && ratios.max_element() < 1.45, "latitude {latitude_deg}: {there:?} for {equator:?}");
        }
    }
}

/// A body drawn as a point in the middle column at latitude 45 degrees, on the edge of two faces of the cube, has as much light as at 30 degrees.
#[test]
fn a_point_on_the_edge_of_two_faces_is_drawn_once() {
    let (mercury, time) = (NaifId(199), Instant::parse("2024-03-01T00:00:00Z").expect("a time"));
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, mercury, time, None).expect("the Sun").state.pos_km.normalize();
    let radius_km = SESSION.catalog().body(mercury).expect("Mercury").radii_km.x;
    let sideways = to_sun.any_orthonormal_vector();
    let light = |latitude_deg: f64, distance_radii: f64| {
        let (sin, cos) = latitude_deg.to_radians().sin_cos();
        let request = ViewRequest {
            target: None,
            position: Position::Offset { body: mercury, offset_km: to_sun * (distance_radii * radius_km), axes: Axes::Icrf },
            look: Look::Along { direction: -to_sun * cos - sideways * sin, axes: Axes::Icrf },
            up: Up::Along { direction: sideways * cos - to_sun * sin, axes: Axes::Icrf },
            exposure: ExposureRequest::Stops(0.0),
            purpose: Purpose::LINEAR,
            width: 2 * HEIGHT_PX,
            height: HEIGHT_PX,
            layers: Layers::NONE,
            effects: EffectOverrides::parse("-glow,-corona").expect("effects"),
            composition: Composition { projection: Projection::Equirectangular, ..Composition::default() },
            ..ViewRequest::of(mercury, time)
        };
        let hdr = SESSION.draw(&request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr;
        let pixels = (0..HEIGHT_PX).flat_map(|y| (HEIGHT_PX - 6..HEIGHT_PX + 6).map(move |x| (x, y)));
        pixels
            .map(|(x, y)| (90.0 - latitude_deg - f64::from(y), (y * 2 * HEIGHT_PX + x) as usize, (f64::from(y) + 0.5) * RAD_PER_PX))
            .filter(|(rows, ..)| rows.abs() < 5.0)
            .map(|(_, index, from_pole)| f64::from(hdr[index][1]) * from_pole.sin())
            .sum::<f64>()
            * distance_radii.powi(2)
    };
    for step in 0..16 {
        let distance_radii = 130.0 + 3.7 * f64::from(step);
        let (on_edge, inside) = (light(45.0, distance_radii), light(30.0, distance_radii));
        assert!((on_edge / inside - 1.0).abs() < 0.12, "{distance_radii} radii: {on_edge}, inside the face {inside}");
    }
}

/// A star in the middle column at latitude 45 degrees, on the edge of two faces of the cube, is drawn once.
#[test]
fn a_star_on_the_edge_of_two_faces_is_drawn_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stars.csv");
    for step in 0..16 {
        std::fs::write(&file, format!("ra_deg,dec_deg,v_mag\n{},11.967,{STAR_MAGNITUDE}\n", 140.0 + 1.7 * f64::from(step)))
            .expect("written");
        let sources = Sources { stars: Some(file.clone()), cache: Some(folder.path().join("cache")), ..Sources::default() };
        let session = Session::open(&sources, |line| panic!("{line}")).expect("opens");
        let star = session.catalog().stars().stars().first().expect("a star").direction;
        let sideways = star.any_orthonormal_vector();
        let images_of_star = |latitude_deg: f64| {
            let (sin, cos) = latitude_deg.to_radians().sin_cos();
            // At rest relative to the solar system's barycentre there is no aberration.
            let position = Position::Offset { body: NaifId(0), offset_km: sideways * 1e9, axes: Axes::Icrf };
            let request = sky_image(position, star * cos - sideways * sin, star * sin + sideways * cos);
            session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn").scene.stars.len()
        };
        assert_eq!((images_of_star(45.0), images_of_star(30.0)), (1, 1), "star {step}");
    }
}

/// The Earth seen from the Moon's ground below it: the first row of pixels is lit from end to end.
#[test]
fn a_body_over_the_pole_is_in_all_columns() {
    let request = |height_px: u32, latitude_deg: f64| ViewRequest {
        position: Position::Ground { body: NaifId::MOON, latitude_deg, longitude_deg: 1.973, height_km: 0.002 },
        look: Look::Target,
        up: Up::Zenith,
        exposure: ExposureRequest::Stops(8.0),
        width: 2 * height_px,
        height: height_px,
        composition: Composition { projection: Projection::Equirectangular, ..Composition::default() },
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-04-08T18:17:16Z").expect("a time"))
    };
    // The Earth is less than four pixels wide in the first two images, and a disc in the last.
    for height_px in [64, 128, 512] {
        let first_row = |latitude_deg: f64| {
            let drawn = SESSION.draw(&request(height_px, latitude_deg), SAMPLING, FrameImages::Display).expect("drawn");
            drawn.frame.display[..2 * height_px as usize].iter().map(|p| p[1]).collect::<Vec<_>>()
        };
        let overhead = first_row(-0.459);
        assert!(overhead.iter().all(|level| *level > 200), "{height_px}: {overhead:?}");
        // Where the Earth is far from the zenith, the first row is dark.
        assert!(first_row(40.0).iter().all(|level| *level < 100), "{height_px}");
    }
}

/// The marker of Jupiter on the seam of the image, half of it at each edge, is that in the middle column, moved by half the width. Control: without the half at
/// one of the edges they differ.
#[test]
fn a_marker_on_the_seam_is_complete() {
    const WIDTH: i32 = 2 * HEIGHT_PX as i32;
    // Radius of a marker for glyphs of 13 pixels, and a pixel for its stroke; names begin farther away.
    const REACH_PX: i32 = 6;
    // At opposition, with no other marker or name within 10 degrees.
    let (jupiter, time) = (NaifId(599), Instant::parse("2024-12-07T00:00:00Z").expect("a time"));
    let position = Position::Offset { body: NaifId::EARTH, offset_km: DVec3::Z * 20_000.0, axes: Axes::Icrf };
    let drawn = |towards: DVec3, labels: bool| {
        let request = ViewRequest { time, layers: Layers { labels, ..Layers::NONE }, ..sky_image(position, towards, DVec3::Z) };
        SESSION.draw(&request, SAMPLING, FrameImages::Display).expect("drawn")
    };
    let to_jupiter = drawn(DVec3::X, false).scene.body(jupiter).expect("Jupiter").placement.centre_km;
    // Beside the middle of the column by 0.3 pixels, so that rounding is the same in both images.
    let towards = DMat3::from_rotation_z(0.3 * RAD_PER_PX) * to_jupiter;
    let row = ((0.5 * PI - to_jupiter.normalize().z.asin()) / RAD_PER_PX) as i32;
    // The pixels around a column that the labels change, relative to this column; columns continue at the opposite edge.
    let changed_around = |towards: DVec3, column: i32| {
        let (with, without) = (drawn(towards, true).frame.display, drawn(towards, false).frame.display);
        let reach = || -REACH_PX..=REACH_PX;
        let index = |x: i32, y: i32| ((row + y) * WIDTH + (column + x).rem_euclid(WIDTH)) as usize;
        let is_changed = |(x, y): &(i32, i32)| with[index(*x, *y)] != without[index(*x, *y)];
        reach().flat_map(|y| reach().map(move |x| (x, y))).filter(is_changed).collect::<Vec<_>>()
    };
    let (in_middle, on_seam) = (changed_around(towards, WIDTH / 2), changed_around(-towards * DVec3::new(1.0, 1.0, -1.0), 0));
    assert!(in_middle.len() > 20 && in_middle == on_seam, "{in_middle:?}, on the seam {on_seam:?}");
    let at_right_edge = on_seam.iter().filter(|(x, _)| *x < 0).count();
    assert!(at_right_edge > 5 && at_right_edge < on_seam.len() - 5, "{at_right_edge} of {}", on_seam.len());
}
