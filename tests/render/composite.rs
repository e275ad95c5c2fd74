//! Images composed of several frames: positions of directions in domes and full spheres, seams, stereo disparity, and warps.
//!
//! External references: tests/data/stars_public.json (skyfield 1.55 on JPL DE440) for directions; the projections' formulas, written out
//! here; the spectra of Sanders & McAllister 2003 for the anaglyph. Tolerances: 0.01 pixels for the place of a
//! sprite, 0.1 pixels for the centroid of an image, as in tests/scene/stars.rs.

use crate::support::session::SESSION;
use glam::{DMat3, DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::composite::{Arrangement, CompositeFrames};
use orrery::scene::photometry::irradiance_of_magnitude;
use orrery::scene::request::{
    Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Purpose, Stereo, StereoLayout, Up, ViewRequest, WarpMesh,
};
use orrery::scene::viewpoint::viewer;
use orrery::session::{DrawnFrame, Session, Sources};
use orrery::time::Instant;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;
use std::sync::Arc;

const DIRECTION_TOLERANCE_PX: f64 = 0.01;
const TOLERANCE_PX: f64 = 0.1;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };

fn time(text: &str) -> Instant {
    Instant::parse(text).expect("a time")
}

/// The drawn frame, with its display pixels only.
fn draw(session: &Session, request: &ViewRequest) -> DrawnFrame {
    session.draw(request, SAMPLING, FrameImages::Display).expect("drawn")
}

/// The drawn frame, with its linear pixels.
fn draw_linear(session: &Session, request: &ViewRequest) -> DrawnFrame {
    session.draw(request, SAMPLING, FrameImages::DisplayAndHdr).expect("drawn")
}

fn composed(projection: Projection, request: ViewRequest) -> ViewRequest {
    ViewRequest { composition: Composition { projection, ..Composition::default() }, ..request }
}

/// A view along a direction from a point near the Earth, celestial north up, in linear light.
fn view_along(direction: DVec3, at: Instant) -> ViewRequest {
    ViewRequest {
        target: None,
        position: Position::Offset { body: NaifId::EARTH, offset_km: DVec3::X * 20_000.0, axes: Axes::Icrf },
        look: Look::Along { direction, axes: Axes::Icrf },
        up: Up::Celestial,
        exposure: ExposureRequest::Stops(0.0),
        purpose: Purpose::LINEAR,
        ..ViewRequest::of(NaifId::EARTH, at)
    }
}

#[derive(Deserialize)]
struct ReferenceStar {
    direction: [f64; 3],
    fov_deg: f64,
    size: [u32; 2],
    time: String,
    star: String,
    x: f64,
    y: f64,
}

#[derive(Deserialize)]
struct ReferenceTable {
    cases: Vec<ReferenceStar>,
}

/// Every star of the reference has a sprite where the projection's formula puts its direction. Fewer than a fifth of the displaced
/// positions have one.
#[test]
fn directions_in_domes_and_spheres_agree_with_the_reference() {
    let cases = serde_json::from_str::<ReferenceTable>(include_str!("../data/stars_public.json")).expect("the table").cases;
    let (mut worst, mut near_displaced, mut compared) = (0.0_f64, 0, 0);
    for view_cases in cases.chunk_by(|a, b| (a.direction, &a.time) == (b.direction, &b.time)) {
        let look = DVec3::from_array(view_cases[0].direction);
        let at = time(&view_cases[0].time);
        let fisheye = composed(Projection::Fisheye, ViewRequest { width: 400, height: 400, fov_deg: Some(200.0), ..view_along(look, at) });
        let sphere = composed(Projection::Equirectangular, ViewRequest { width: 800, height: 400, ..view_along(look, at) });
        let scene_of = |request: &ViewRequest| SESSION.plan(request, SAMPLING).expect("a plan").0;
        let (dome_scene, sphere_scene) = (scene_of(&fisheye), scene_of(&sphere));
        let right = look.cross(DVec3::Z).normalize();
        let up = right.cross(look).normalize();
        for case in view_cases {
            let tan_y = (case.fov_deg.to_radians() / 2.0).tan();
            let [w, h] = case.size.map(f64::from);
            let plane = DVec2::new((2.0 * case.x / w - 1.0) * tan_y * w / h, (1.0 - 2.0 * case.y / h) * tan_y);
            // The name is "HIP " and the number.
            let hip = case.star[4..].parse().expect("a number");
            let star = SESSION.catalog().stars().star_of_hip(hip).copied().expect("in the catalog");
            // For a star behind the camera the reference gives the opposite direction: skip it.
            if star.direction.dot(look) <= 0.0 {
                continue;
            }
            let direction = right * plane.x + up * plane.y + look.normalize();
            let in_dome =
                DVec2::splat(200.0) + plane / plane.length() * DVec2::new(1.0, -1.0) * plane.length().atan() * 200.0 / 100_f64.to_radians();
            let ra = direction.y.atan2(direction.x) - look.y.atan2(look.x);
            let dec = direction.z.atan2(direction.truncate().length());
            let in_sphere = DVec2::new((400.0 - ra / TAU * 800.0).rem_euclid(800.0), 200.0 - dec / PI * 400.0);
            for (scene, expected) in [(&dome_scene, in_dome), (&sphere_scene, in_sphere)] {
                let half = DVec2::new(f64::from(scene.camera.width), f64::from(scene.camera.height)) / 2.0;
                let sprites = || scene.stars.iter().map(|s| (DVec2::ONE + s.centre.truncate().as_dvec2() * DVec2::new(1.0, -1.0)) * half);
                let nearest = |at: DVec2| sprites().map(|p| p.distance(at)).fold(f64::MAX, f64::min);
                // Near a pole of the equirectangular image a star is a row of sprites. The dome is the square image.
                if dec.abs() < 0.8 || half.x == half.y {
                    worst = worst.max(nearest(expected));
                    compared += 1;
                    near_displaced += usize::from(nearest(expected + DVec2::new(0.1, 0.05)) < DIRECTION_TOLERANCE_PX);
                }
            }
        }
    }
    println!("{compared} positions, worst {worst:.4} pixels; {near_displaced} at displaced positions");
    assert!(compared >= 50 && worst < DIRECTION_TOLERANCE_PX, "{compared} {worst}");
    assert!(near_displaced < compared / 5, "any position would pass: {near_displaced} of {compared}");
}

/// A session with Regulus as the only star, and the folder of its files.
fn session_of_regulus() -> (Session, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stars.csv");
    std::fs::write(&file, "ra_deg,dec_deg,v_mag\n152.093,11.967,1.36\n").expect("written");
    let sources = Sources { stars: Some(file), cache: Some(folder.path().join("cache")), ..Sources::default() };
    (Session::open(&sources, |line| panic!("{line}")).expect("opens"), folder)
}

/// Wherever a star is in a dome or a sphere, the centroid of its image is where its direction is projected, and the light of its pixels
/// times their solid angle is the star's irradiance, to within 10 %.
#[test]
fn a_star_keeps_its_place_and_light_in_every_projection() {
    let (session, _folder) = session_of_regulus();
    let star = *session.catalog().stars().stars().first().expect("a star");
    let irradiance = irradiance_of_magnitude(1.36);
    for (k, angle_deg) in [0.0_f64, 20.0, 44.9, 45.0, 54.8, 70.0, 89.0, 120.0].into_iter().enumerate() {
        let sideways = star.direction.any_orthonormal_vector();
        let sideways = DMat3::from_axis_angle(star.direction, 0.8 * k as f64) * sideways;
        let look = star.direction * angle_deg.to_radians().cos() + sideways * angle_deg.to_radians().sin();
        for projection in [Projection::Fisheye, Projection::Equirectangular] {
            let at = time("2024-03-01T00:00:00Z");
            let size = if projection == Projection::Fisheye { (300, 300) } else { (600, 300) };
            let request = ViewRequest {
                position: Position::Centre(NaifId::EARTH),
                fov_deg: Some(260.0),
                width: size.0,
                height: size.1,
                layers: Layers { stars: true, ..Layers::NONE },
                ..view_along(look, at)
            };
            let request = composed(projection, request);
            let Arrangement::Faces(faces) =
                CompositeFrames::of(session.catalog(), session.ephemeris(), &request).expect("frames").arrangement
            else {
                panic!("faces")
            };
            let perspective = ViewRequest { composition: Composition::default(), fov_deg: Some(10.0), ..request.clone() };
            let velocity = viewer(session.catalog(), session.ephemeris(), &perspective).expect("a viewer").sky_aberration_velocity_km_s;
            let direction = orrery::ephemeris::apparent::aberrated(star.direction, velocity);
            let (in_axes, image) = (faces.image.in_axes(direction), &faces.image);
            let expected = image.pixel(in_axes).expect("in the image");
            // Sum only the light near the star: planets are points too.
            let drawn = draw_linear(&session, &request);
            let (mut sum, mut moment) = (0.0, DVec2::ZERO);
            let reach_px = 8.0 + if projection == Projection::Fisheye { 0.0 } else { image.pixel_sr_and_stretch(in_axes).1 };
            for (y, x) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (y, x))) {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let mut offset = at - expected;
                if projection == Projection::Equirectangular {
                    offset.x -= 600.0 * (offset.x / 600.0).round();
                }
                if offset.x.abs() < reach_px && offset.y.abs() < 8.0 {
                    let light = f64::from(drawn.frame.hdr[(y * size.0 + x) as usize][1]);
                    sum += light;
                    moment += offset * light;
                }
            }
            let flux = sum * image.pixel_sr_and_stretch(in_axes).0 / PI;
            let centroid_offset = moment / sum;
            assert!(centroid_offset.length() < TOLERANCE_PX, "{projection:?} {angle_deg} deg: {centroid_offset}");
            assert!((flux / irradiance - 1.0).abs() < 0.1, "{projection:?} {angle_deg} deg: {}", flux / irradiance);
        }
    }
}

/// The Sun's disc is drawn in the faces and resampled. Its centroid is where its direction is projected: on seams, on corners and
/// elsewhere.
#[test]
fn a_disc_on_a_seam_is_at_its_position() {
    let at = time("2024-04-08T18:17:16Z");
    let radius_km = SESSION.catalog().body(NaifId::SUN).expect("the Sun").radii_km.x;
    let mut worst = 0.0_f64;
    for (angle_deg, azimuth_rad) in
        [(0.0, 0.0), (30.0, 0.3), (45.0, 0.0), (45.0, FRAC_PI_2), (54.7, 0.785), (45.0, 2.0), (80.0, 0.1), (100.0, 1.0)]
    {
        // The Sun's direction in the image's axes. The camera stays on ICRF -x; the image's axes are rotated instead.
        let (sin, cos) = f64::to_radians(angle_deg).sin_cos();
        let sun_direction = DVec3::new(sin * f64::cos(azimuth_rad), sin * f64::sin(azimuth_rad), cos);
        // Any rotation that maps ICRF x to `sun_direction`.
        let from_icrf = DMat3::from_quat(glam::DQuat::from_rotation_arc(DVec3::X, sun_direction));
        let request = ViewRequest {
            position: Position::Offset { body: NaifId::SUN, offset_km: DVec3::NEG_X * 60.0 * radius_km, axes: Axes::Icrf },
            look: Look::Along { direction: from_icrf.row(2), axes: Axes::Icrf },
            up: Up::Along { direction: from_icrf.row(1), axes: Axes::Icrf },
            fov_deg: Some(240.0),
            width: 400,
            height: 400,
            effects: orrery::scene::effects::EffectOverrides::parse("-corona,-glow").expect("effects"),
            layers: Layers { stars: false, ..Layers::default() },
            exposure: ExposureRequest::Stops(-20.0),
            ..view_along(DVec3::X, at)
        };
        // The rows of a rotation are right-handed. The image's axes (right, up, forward) are left-handed, so x is mirrored.
        let mirrored = DVec3::new(-sun_direction.x, sun_direction.y, sun_direction.z);
        let drawn = draw_linear(&SESSION, &composed(Projection::Fisheye, request));
        let (mut sum, mut moment) = (0.0, DVec2::ZERO);
        for (k, p) in drawn.frame.hdr.iter().enumerate() {
            let (x, y) = ((k % 400) as f64 + 0.5, (k / 400) as f64 + 0.5);
            sum += f64::from(p[1]);
            moment += DVec2::new(x, y) * f64::from(p[1]);
        }
        let across = mirrored.truncate().length();
        let radius_px = across.atan2(mirrored.z) * 200.0 / 120_f64.to_radians();
        let radial = if across > 0.0 { mirrored.truncate() / across } else { DVec2::ZERO };
        let expected = DVec2::splat(200.0) + radial * DVec2::new(1.0, -1.0) * radius_px;
        let error_px = (moment / sum).distance(expected);
        worst = worst.max(error_px);
        assert!(error_px < TOLERANCE_PX, "{angle_deg} deg, azimuth {azimuth_rad}: {} for {expected}", moment / sum);
    }
    println!("worst {worst:.4} pixels");
}

/// The same sphere drawn from a cube that is rotated by 45 degrees: seams of one are in the middle of a face of the other, and the images
/// agree.
#[test]
fn seams_are_invisible() {
    let at = time("2024-04-08T12:00:00Z");
    let view = |turn_deg: f64| {
        let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
        let request = ViewRequest {
            position: Position::Offset { body: NaifId::EARTH, offset_km: DVec3::new(9000.0, 3000.0, 1000.0), axes: Axes::Icrf },
            exposure: ExposureRequest::Stops(0.5),
            purpose: Purpose::Display,
            width: 512,
            height: 256,
            layers: Layers { bloom: true, ..Layers::default() },
            ..view_along(DVec3::new(cos, sin, 0.0), at)
        };
        draw(&SESSION, &composed(Projection::Equirectangular, request)).frame.display
    };
    let (first, rotated) = (view(0.0), view(45.0));
    let lit = first.iter().filter(|p| p[1] > 40).count();
    assert!(lit > 10_000, "{lit}");
    // Near the equator the faces meet in vertical seams, 90 degrees apart. The first image has one 45 degrees from its middle; the rotated
    // image has one in the same direction as the middle of the first. Together that is a seam every 64 columns. A few horizontal seams
    // count as `elsewhere`.
    let (mut on_seams, mut elsewhere) = (Vec::new(), Vec::new());
    for (y, x) in (72..184_usize).flat_map(|y| (0..512_usize).map(move |x| (y, x))) {
        // 45 degrees are 64 columns; right ascension increases to the left.
        let (a, b) = (first[y * 512 + x], rotated[y * 512 + (x + 64) % 512]);
        if a[1] > 10 {
            let difference = (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).fold(0.0, f64::max);
            let from_seam = (x + 1) % 64;
            if from_seam <= 1 { on_seams.push(difference) } else { elsewhere.push(difference) }
        }
    }
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let (seams, faces) = (mean(&on_seams), mean(&elsewhere));
    println!("{} pixels on seams differ by {seams:.3} levels, {} others by {faces:.3}", on_seams.len(), elsewhere.len());
    // Measured: 3.5 levels on seams and 2.1 elsewhere.
    assert!(on_seams.len() > 200 && seams < 1.75 * faces + 0.3 && faces < 3.0, "{seams} {faces}");
    // The comparison must be able to fail: without the shift of 45 degrees the images differ.
    let unshifted_sum: u64 = (0..first.len()).map(|k| u64::from(first[k][1].abs_diff(rotated[k][1]))).sum();
    assert!(unshifted_sum as f64 / first.len() as f64 > 2.0);
}

/// The disparity of a point between the two images of a pair follows from its distance: for points near Jupiter as the cameras project
/// them, and for moons also in the pixels.
#[test]
fn disparity_follows_from_the_geometry() {
    let at = time("2024-12-07T20:00:00Z");
    let stereo = Stereo { layout: StereoLayout::SideBySide, eye_separation_km: None };
    let request = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(60.0) },
        composition: Composition { stereo: Some(stereo), ..Composition::default() },
        width: 1600,
        height: 800,
        fov_deg: Some(60.0),
        ..ViewRequest::of(NaifId(599), at)
    };
    let frames = CompositeFrames::of(SESSION.catalog(), SESSION.ephemeris(), &request).expect("frames");
    let Arrangement::Eyes(eyes) = frames.arrangement else { panic!("eyes") };
    let camera = &frames.meter.viewer.camera;
    assert_eq!(eyes.first_columns, [27, 0], "a thirtieth of 800 pixels");
    let [left, right] = [0, 1].map(|k| &frames.frames[k].viewer.camera);
    assert!(((right.position_km - left.position_km).length() / eyes.separation_km - 1.0).abs() < 1e-6);
    let target = SESSION.ephemeris().light_time_position(NaifId(599), camera.position_km, at).expect("Jupiter").0;
    let distance_km = (target - camera.position_km).length();
    let in_image = |k: usize, point_km: DVec3| {
        let eye = &frames.frames[k].viewer.camera;
        let clip = eye.clip(point_km - eye.position_km).expect("in front");
        eye.pixel_from_clip(clip) - DVec2::new(f64::from(eyes.first_columns[k]), 0.0)
    };
    let (mut near, mut far) = (0, 0);
    for k in -40..=40 {
        let point_km = target + DVec3::new(0.3, 1.0, 0.2).normalize() * (0.02 * f64::from(k) * distance_km);
        let depth = (point_km - camera.position_km).dot(camera.forward);
        let expected = eyes.separation_km / camera.pixel_tangent() * (1.0 / distance_km - 1.0 / depth);
        let [l, r] = [0, 1].map(|k| in_image(k, point_km));
        assert!((r.x - l.x - expected).abs() < 1e-3 && (r.y - l.y).abs() < 1e-3, "{k}: {} for {expected}", r.x - l.x);
        near += usize::from(expected < -1.0);
        far += usize::from(expected > 1.0);
    }
    assert!(near > 5 && far > 5);
    // In the image: centroids of the moons' points, left and right.
    let drawn = draw(&SESSION, &request);
    let mut measured = 0;
    for id in [501, 502, 503, 504] {
        let body = drawn.scene.body(NaifId(id)).expect("a moon").placement.centre_km;
        let moon_km = left.position_km + body;
        let centroid = |k: usize| {
            let middle = in_image(k, moon_km) + DVec2::new(800.0 * k as f64, 0.0);
            let (mut sum, mut moment) = (0.0, DVec2::ZERO);
            for (y, x) in (-7..=7).flat_map(|y| (-7..=7).map(move |x| (y, x))) {
                let (x, y) = (middle.x as i64 + x, middle.y as i64 + y);
                let level = drawn.frame.display[(y * 1600 + x) as usize][1];
                // Linear light, without the faint rim of the sprite.
                let light = if level > 20 { (f64::from(level) / 255.0).powf(2.2) } else { 0.0 };
                sum += light;
                moment += DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * light;
            }
            (sum, moment / sum - DVec2::new(800.0 * k as f64, 0.0))
        };
        let [l, r] = [in_image(0, moon_km), in_image(1, moon_km)];
        let inside = |p: DVec2| p.cmpgt(DVec2::splat(20.0)).all() && p.cmplt(DVec2::splat(780.0)).all();
        // Skip moons next to Jupiter, whose light would be included.
        if !inside(l) || !inside(r) || l.distance(DVec2::splat(400.0)) < 40.0 {
            continue;
        }
        let ((light, at_left), (_, at_right)) = (centroid(0), centroid(1));
        assert!(light > 0.01, "{id} is not in the image");
        let (measured_px, expected_px) = ((at_right - at_left).x, r.x - l.x);
        println!("{id}: disparity {measured_px:.3} for {expected_px:.3}, light {light:.2}, at {l}");
        assert!((measured_px - expected_px).abs() < 0.3, "{id}: {measured_px} for {expected_px}");
        measured += 1;
    }
    assert!(measured >= 2, "{measured}");
}

/// Eyes too far apart, eyes without a distance, and a stereo pair of domes: each error says what would work.
#[test]
fn impossible_stereo_pairs_are_refused() {
    let stereo = |km: f64| Composition {
        stereo: Some(Stereo { layout: StereoLayout::Anaglyph, eye_separation_km: Some(km) }),
        ..Composition::default()
    };
    let frames_with_separation = |km: f64| {
        let request = ViewRequest { composition: stereo(km), ..ViewRequest::of(NaifId(699), time("2024-01-01T00:00:00Z")) };
        CompositeFrames::of(SESSION.catalog(), SESSION.ephemeris(), &request).map(|_| ()).map_err(|e| e.to_string())
    };
    assert!(frames_with_separation(1000.0).is_ok());
    assert!(frames_with_separation(1e7).expect_err("too far").contains("at most"));
    assert!(frames_with_separation(0.0).expect_err("none").contains("more than 0"));
    // The largest separation that a message names is accepted, even if each eye's image is a pixel wide.
    for width in [2, 200] {
        let frames = |km: f64| {
            let stereo = Some(Stereo { layout: StereoLayout::SideBySide, eye_separation_km: Some(km) });
            let composition = Composition { stereo, ..Composition::default() };
            let request = ViewRequest { composition, width, ..ViewRequest::of(NaifId(699), time("2024-01-01T00:00:00Z")) };
            CompositeFrames::of(SESSION.catalog(), SESSION.ephemeris(), &request).map(|_| ()).map_err(|e| e.to_string())
        };
        let message = frames(1e12).expect_err("too far");
        let largest_km =
            message.rsplit_once("at most ").and_then(|(_, km)| km.strip_suffix(" km")?.parse::<f64>().ok()).expect("a separation");
        assert!(frames(largest_km).is_ok() && frames(1.1 * largest_km).is_err(), "{width}: {message}");
    }
    // Images a pixel wide have no column to spare for the usual parallax; the message does not name a separation that nobody gave.
    for (layout, width, is_possible) in [
        (StereoLayout::Anaglyph, 1, false),
        (StereoLayout::Anaglyph, 2, true),
        (StereoLayout::SideBySide, 3, false),
        (StereoLayout::SideBySide, 4, true),
    ] {
        let composition = Composition { stereo: Some(Stereo { layout, eye_separation_km: None }), ..Composition::default() };
        let request = ViewRequest { composition, width, ..ViewRequest::of(NaifId(699), time("2024-01-01T00:00:00Z")) };
        let found = CompositeFrames::of(SESSION.catalog(), SESSION.ephemeris(), &request).map(|_| ()).map_err(|e| e.to_string());
        assert_eq!(found.is_ok(), is_possible, "{layout:?} {width}: {found:?}");
        assert!(is_possible || found.is_err_and(|e| e.contains("2 pixels wide")), "{layout:?} {width}");
    }
    let both = Composition { projection: Projection::Fisheye, ..stereo(1000.0) };
    let request = ViewRequest { composition: both, ..ViewRequest::of(NaifId(699), time("2024-01-01T00:00:00Z")) };
    assert!(SESSION.plan(&request, SAMPLING).expect_err("both").to_string().contains("stereo requires the perspective projection"));
}

/// The poles of an equirectangular image are the zenith and the nadir already.
#[test]
fn only_a_fisheye_can_have_the_zenith_in_its_middle() {
    for projection in Projection::ALL {
        let composition = Composition { projection, is_zenith_centred: true, ..Composition::default() };
        let request = ViewRequest { composition, ..ViewRequest::of(NaifId(699), time("2024-01-01T00:00:00Z")) };
        let refusal = SESSION.plan(&request, SAMPLING).err().map(|e| e.to_string());
        assert_eq!(refusal.is_none(), projection == Projection::Fisheye, "{projection:?}: {refusal:?}");
        assert!(refusal.is_none_or(|text| text.contains("requires --projection fisheye")), "{projection:?}");
    }
}

/// The matrix of the anaglyph is the least-squares solution for the published spectra: tristimulus values of a CRT's phosphors, unfiltered
/// and behind each filter.
#[test]
fn the_anaglyph_matrix_is_the_least_squares_solution() {
    let left =
        DMat3::from_cols_array_2d(&[[5.42327, 2.70972, 5.50941e-5], [0.807004, 0.50201, 4.11221e-4], [0.047325, 0.0250529, 2.40686e-3]]);
    let right = DMat3::from_cols_array_2d(&[[0.180431, 0.448214, 0.289201], [1.6395, 6.31551, 2.3925], [2.00309, 1.35757, 11.062]]);
    let unfiltered = DMat3::from_cols_array_2d(&[[11.6638, 7.10807, 0.527874], [8.3959, 16.6845, 3.79124], [4.65843, 2.45008, 24.0604]]);
    let normal = (left.transpose() * left + right.transpose() * right).inverse();
    let (left_matrix, right_matrix) = (normal * left.transpose() * unfiltered, normal * right.transpose() * unfiltered);
    let shader = include_str!("../../shaders/entry/anaglyph.wesl");
    for (k, channel) in ["RED", "GREEN", "BLUE"].into_iter().enumerate() {
        let row = |side: &str| -> DVec3 {
            let start = shader.find(&format!("const {side}_{channel}: vec3f = vec3f(")).expect("a row");
            let text = shader[start..].split_once("vec3f(").and_then(|(_, t)| t.split_once(')')).expect("numbers").0;
            DVec3::from_slice(&text.split(',').map(|n| n.trim().parse().expect("a number")).collect::<Vec<f64>>())
        };
        let (l, r) = (left_matrix.row(k), right_matrix.row(k));
        let white = l.element_sum() + r.element_sum();
        assert!((row("LEFT") - l / white).length() < 2e-4 && (row("RIGHT") - r / white).length() < 2e-4, "{channel}");
        assert!((row("LEFT").element_sum() + row("RIGHT").element_sum() - 1.0).abs() < 1e-4, "{channel}");
    }
}

/// A warp mesh. `place` maps image coordinates, both from -1 to 1, to the mesh file's x (plus or minus the aspect ratio) and y.
fn mesh(columns: usize, rows: usize, brightness: f64, place: impl Fn(f64, f64) -> (f64, f64)) -> Arc<WarpMesh> {
    let mut text = format!("2\n{columns} {rows}\n");
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (u, v) = (c as f64 / (columns - 1) as f64, r as f64 / (rows - 1) as f64);
        let (x, y) = place(2.0 * u - 1.0, 2.0 * v - 1.0);
        let _ = writeln!(text, "{x} {y} {u} {v} {brightness}");
    }
    Arc::new(WarpMesh::parse("mesh", &text).expect("a mesh"))
}

/// An identity mesh reproduces the image, except for filtering; a mirroring mesh gives the mirrored image; brightness 1/2 gives half the
/// light.
#[test]
fn a_warp_moves_the_image_according_to_its_mesh() {
    let unwarped = ViewRequest { width: 240, height: 160, ..ViewRequest::of(NaifId(699), time("2017-05-17T00:00:00Z")) };
    let warped = |mesh: Arc<WarpMesh>| {
        let composition = Composition { warp: Some(mesh), ..Composition::default() };
        draw(&SESSION, &ViewRequest { composition, ..unwarped.clone() }).frame.display
    };
    let image = draw(&SESSION, &unwarped).frame.display;
    let mean_difference = |a: &[[u8; 4]], b: &dyn Fn(usize) -> [u8; 4]| {
        let sum: u64 = (0..a.len()).flat_map(|k| (0..3).map(move |c| (k, c))).map(|(k, c)| u64::from(a[k][c].abs_diff(b(k)[c]))).sum();
        sum as f64 / (3 * a.len()) as f64
    };
    let identical = warped(mesh(13, 9, 1.0, |x, y| (1.5 * x, y)));
    let mirrored = warped(mesh(13, 9, 1.0, |x, y| (-1.5 * x, y)));
    let mirrored_back = |k: usize| mirrored[k / 240 * 240 + 239 - k % 240];
    let identity_difference = mean_difference(&image, &|k| identical[k]);
    let mirrored_back_difference = mean_difference(&identical, &mirrored_back);
    let mirrored_difference = mean_difference(&identical, &|k| mirrored[k]);
    println!("identical {identity_difference:.3}, mirrored back {mirrored_back_difference:.3}, mirrored {mirrored_difference:.3} levels");
    assert!(identity_difference < 1.5 && mirrored_back_difference < 0.1 && mirrored_difference > 3.0);
    let half = warped(mesh(13, 9, 0.5, |x, y| (1.5 * x, y)));
    let linear = |v: u8| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let light = |p: &[[u8; 4]]| p.iter().map(|p| linear(p[1])).sum::<f64>();
    assert!((light(&half) / light(&identical) - 0.5).abs() < 0.01, "{}", light(&half) / light(&identical));
}

/// In a dome the sky's diffuse light is behind the stars: with the Milky Way a star is at least as bright as without. Only the faces draw
/// lines and background; the scene of the entire image has none.
#[test]
fn the_milky_way_hides_no_star_of_a_dome() {
    let (session, _folder) = session_of_regulus();
    let direction = session.catalog().stars().stars()[0].direction;
    let dome = |layers: Layers| {
        let base = view_along(direction, time("2024-03-01T00:00:00Z"));
        composed(Projection::Fisheye, ViewRequest { width: 300, height: 300, fov_deg: Some(120.0), layers, ..base })
    };
    let stars = Layers { stars: true, ..Layers::NONE };
    let brightest = |layers: Layers| {
        let drawn = draw_linear(&session, &dome(layers));
        drawn.frame.hdr.iter().map(|p| f64::from(p[1])).fold(0.0, f64::max)
    };
    let (alone, with_milky_way) = (brightest(stars), brightest(Layers { milky_way: true, ..stars }));
    assert!(alone > 0.0 && with_milky_way >= alone * (1.0 - 1e-6), "{alone} {with_milky_way}");
    let scene = draw_linear(&session, &dome(Layers { constellations: true, ..stars })).scene;
    assert!(scene.sky_lines.is_empty() && scene.orbits.is_empty() && scene.background.is_none());
}
