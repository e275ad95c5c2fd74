//! Pixel views: each shows what its legend says, checked against numbers known from the scene, and the written file explains its colours.

use crate::support::folds::{larger, smaller};
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::disc_light::phase_correction;
use orrery::scene::draw::PixelView;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, Composition, Look, Position, Projection, ViewRequest};
use orrery::scene::{Scene, SubPoint};
use orrery::time::Instant;
use std::f64::consts::{FRAC_PI_2, PI};

/// Odd, so that the middle pixel's centre is the centre of the image.
const SIDE: u32 = 97;
const MIDDLE: usize = 48 * 97 + 48;

struct Image {
    scene: Scene,
    hdr: Vec<[f32; 4]>,
}

impl Image {
    fn middle(&self) -> [f64; 3] {
        let p = self.hdr[MIDDLE];
        [p[0], p[1], p[2]].map(f64::from)
    }
}

fn drawn(target: i32, distance_radii: f64, time: &str, pixel_view: PixelView) -> Image {
    let time = Instant::parse(time).expect("a time");
    let request = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
        effects: EffectOverrides::parse("-normal").expect("an effect"),
        pixel_view,
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(NaifId(target), time)
    };
    let drawn = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn");
    Image { scene: drawn.scene, hdr: drawn.frame.hdr }
}

/// The Earth and other bodies shine on the Moon, but the view of the eclipse shows the Sun's light alone.
#[test]
fn the_eclipse_of_a_body_with_planet_shine_is_drawn() {
    for (time, range) in [("2022-11-08T09:45:00Z", 0.1..0.7), ("2022-11-08T08:50:00Z", 0.9..1.001)] {
        let request = ViewRequest {
            position: Position::Centre(NaifId::EARTH),
            effects: EffectOverrides::parse("+planet-shine").expect("an effect"),
            pixel_view: PixelView::Eclipse,
            width: SIDE,
            height: SIDE,
            ..ViewRequest::of(NaifId::MOON, Instant::parse(time).expect("a time"))
        };
        let drawn = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn");
        let brightest = drawn.frame.hdr.iter().map(|p| p[1]).fold(0.0, larger);
        assert!(range.contains(&brightest), "{time}: {brightest}");
    }
}

/// Earthshine in the middle of the Moon's night side, two days after new moon, as irradiance relative to the Sun's at 1 au. A full Earth straight above gives
/// its geometric albedo (0.434: Mallama, Krobusek and Pavlov 2017) times (radius / distance)², at 6371 and 363 436 km; at a phase angle of 23 degrees it is a
/// little fainter. It does not depend on the viewer's distance, with which the Moon's drawn albedo takes on its phase law. Negative control: with the inverse
/// of this law, as the radiance needs it, the irradiance would be too large.
#[test]
fn the_sunlight_view_shows_the_irradiance_by_other_bodies() {
    const TIME: &str = "2024-04-10T00:00:00Z";
    const FAR_RADII: f64 = 60.0;
    let full_earth = 0.434 * (6371.0_f64 / 363_436.0).powi(2);
    let middle = |distance_radii: f64, effects: &str| {
        let request = ViewRequest {
            position: Position::AboveTarget { towards: None, distance_radii: Some(distance_radii) },
            effects: EffectOverrides::parse(&format!("-normal,-detail,{effects}planet-shine")).expect("effects"),
            pixel_view: PixelView::Sunlight,
            width: SIDE,
            height: SIDE,
            ..ViewRequest::of(NaifId::MOON, Instant::parse(TIME).expect("a time"))
        };
        let drawn = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn");
        let phase_angle_rad = drawn.scene.body(NaifId::MOON).expect("the Moon").phase_angle_deg.to_radians();
        (f64::from(drawn.frame.hdr[MIDDLE][1]), phase_angle_rad)
    };
    let ((near, _), (far, phase_angle_rad)) = (middle(3.0, "+"), middle(FAR_RADII, "+"));
    let possible = 0.75 * full_earth..1.02 * full_earth;
    assert!(possible.contains(&near) && possible.contains(&far), "{near} and {far}, full Earth {full_earth}");
    assert!((near / far - 1.0).abs() < 0.02, "{near} from 3 radii, {far} from {FAR_RADII}");
    assert_eq!(middle(3.0, "-").0, 0.0);
    let moon = SESSION.catalog().body(NaifId::MOON).expect("the Moon");
    let with_phase_law = far / phase_correction(moon, phase_angle_rad, FAR_RADII);
    assert!(!possible.contains(&with_phase_law), "{with_phase_law} would pass");
}

const DAY: &str = "2024-04-08T18:17:16Z";

#[test]
fn every_view_differs_from_the_final_image() {
    for (target, distance_radii) in [(399, 3.0), (699, 5.0)] {
        let final_image = drawn(target, distance_radii, DAY, PixelView::Final);
        for view in PixelView::ALL.into_iter().filter(|v| *v != PixelView::Final) {
            let other = drawn(target, distance_radii, DAY, view);
            // Sunlight at Saturn is a hundredth of that at 1 au.
            let brightest = |p: &Image| p.hdr.iter().flat_map(|p| &p[..3]).fold(0.0, |a: f32, b| a.max(*b));
            let bound = 0.02 * brightest(&final_image).min(brightest(&other)).max(1e-6);
            let differ = |(a, b): &(&[f32; 4], &[f32; 4])| a[..3].iter().zip(&b[..3]).any(|(x, y)| (x - y).abs() > bound);
            let differing_pixels = final_image.hdr.iter().zip(&other.hdr).filter(differ).count();
            assert!(
                differing_pixels > final_image.hdr.len() / 100,
                "{view:?} of {target}: {differing_pixels} pixels differ from the final image"
            );
            assert!(other.hdr.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{view:?} of {target}");
        }
    }
}

/// The direction of a point from the body's centre.
fn unit(p: SubPoint) -> [f64; 3] {
    let (lat, lon) = (p.lat_centric_deg.to_radians(), p.lon_east_deg.to_radians());
    [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
}

fn assert_near(got: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance), "{what}: {got:?}, {expected:?} expected");
}

/// The Moon deviates from a sphere by about a thousandth, so the middle of the image is the sub-observer point.
#[test]
fn the_middle_of_the_moon_has_known_values_in_the_views() {
    let draw_view = |view| drawn(301, 6.0, "2024-04-16T01:00:00Z", view);
    let depth = draw_view(PixelView::Depth);
    let moon = depth.scene.body(NaifId::MOON).expect("the Moon").clone();
    assert_near(&depth.middle(), &[1.0; 3], 1e-3, "nearest");
    let sub_observer = unit(moon.sub_observer);
    assert_near(&draw_view(PixelView::Normal).middle(), &sub_observer.map(|v| 0.5 + 0.5 * v), 2e-3, "normal");
    let (u, v) = (0.5 + moon.sub_observer.lon_east_deg / 360.0, 0.5 - moon.sub_observer.lat_centric_deg / 180.0);
    assert_near(&draw_view(PixelView::Uv).middle(), &[u, v, 0.0], 2e-3, "map coordinates");
    let sun = moon.sub_solar.expect("the Sun shines on it");
    let cosine: f64 = unit(sun).iter().zip(sub_observer).map(|(a, b)| a * b).sum();
    // The Moon's distance from the Sun is within 0.3 % of the Earth's, which is 1.003 au on that day; its square is 1.006.
    assert_near(&draw_view(PixelView::Sunlight).middle(), &[cosine.max(0.0) / 1.006; 3], 0.02, "sunlight");
    assert_near(&draw_view(PixelView::Eclipse).middle(), &[1.0; 3], 0.0, "no eclipse");
    assert_near(&draw_view(PixelView::OpticalDepth).middle(), &[0.0; 3], 0.0, "no air");
}

/// A whole-sphere image in which Mars, 112 degrees wide, lies across the edge of two faces of the cube: where a pixel's ray meets the ellipsoid, the depth is
/// that of this point along the line from the camera to the centre. Tolerance: twice the change from pixel to pixel, 0.01, of the pixels farthest from the
/// centre. Negative control: the depth along the axis of the pixel's face.
#[test]
fn the_depth_does_not_depend_on_the_faces_of_a_whole_sphere_image() {
    const HEIGHT: u32 = 128;
    let mars = NaifId(499);
    let radius_km = SESSION.catalog().body(mars).expect("Mars").radii_km.x;
    let request = ViewRequest {
        position: Position::Offset { body: mars, offset_km: DVec3::NEG_X * (1.2 * radius_km), axes: Axes::Icrf },
        look: Look::Along { direction: DVec3::new(1.0, 1.0, 0.0), axes: Axes::Icrf },
        composition: Composition { projection: Projection::Equirectangular, ..Composition::default() },
        pixel_view: PixelView::Depth,
        width: 2 * HEIGHT,
        height: HEIGHT,
        ..ViewRequest::of(mars, Instant::parse(DAY).expect("a time"))
    };
    let drawn = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn");
    let (camera, placement) = (&drawn.scene.camera, &drawn.scene.body(mars).expect("Mars").placement);
    let origin = placement.camera_in_unit_sphere();
    let depth_along = |axis: DVec3, point: DVec3| {
        let farthest = (placement.body_from_icrf * axis * placement.radii_km).normalize();
        0.5 - 0.5 * farthest.dot(point)
    };
    let (mut compared, mut worst, mut differ_from_faces) = (0, 0.0_f64, 0);
    for (k, pixel) in drawn.frame.hdr.iter().enumerate() {
        let (x, y) = (k as u32 % (2 * HEIGHT), k as u32 / (2 * HEIGHT));
        let (longitude, latitude) =
            ((f64::from(x) + 0.5) / f64::from(HEIGHT) * PI - PI, FRAC_PI_2 - (f64::from(y) + 0.5) / f64::from(HEIGHT) * PI);
        let in_axes = DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos());
        let icrf = |v: DVec3| camera.right * v.x + camera.up * v.y + camera.forward * v.z;
        let ray = placement.direction_in_unit_sphere(icrf(in_axes)).normalize();
        let passes_centre_at = origin.cross(ray).length();
        if origin.dot(ray) >= 0.0 || passes_centre_at > 0.95 {
            continue;
        }
        let point = origin - ray * (origin.dot(ray) + (1.0 - passes_centre_at * passes_centre_at).sqrt());
        // The axis of the face is that of the greatest component.
        let face_axis = DVec3::select(in_axes.abs().cmpeq(DVec3::splat(in_axes.abs().max_element())), in_axes.signum(), DVec3::ZERO);
        let expected = depth_along(placement.centre_km.normalize(), point);
        compared += 1;
        worst = worst.max((f64::from(pixel[1]) - expected).abs());
        differ_from_faces += usize::from((depth_along(icrf(face_axis), point) - expected).abs() > 0.1);
    }
    println!("{compared} pixels, worst {worst:.4}; {differ_from_faces} differ from the depth along the axis of their face");
    assert!(compared > 2000 && worst < 0.02, "{compared} {worst}");
    assert!(differ_from_faces > compared / 2, "the depth along the axes of the faces would pass: {differ_from_faces} of {compared}");
}

/// Maps and names of bodies with three different semi-axes have planetocentric longitudes.
#[test]
fn map_coordinates_of_triaxial_bodies_are_planetocentric() {
    let mut greatest_parametric_error: f64 = 0.0;
    for (target, time) in
        [(401, DAY), (401, "2024-04-08T20:10:00Z"), (607, DAY), (607, "2024-04-13T00:00:00Z"), (610, DAY), (2_000_004, DAY)]
    {
        let image = drawn(target, 6.0, time, PixelView::Uv);
        let middle = image.scene.body(NaifId(target)).expect("the body").sub_observer;
        let (u, v) = (0.5 + middle.lon_east_deg / 360.0, 0.5 - middle.lat_centric_deg / 180.0);
        let [drawn_u, drawn_v, _] = image.middle();
        let turns = (drawn_u - u + 0.5).rem_euclid(1.0) - 0.5;
        assert!(turns.abs() < 5e-4 && (drawn_v - v).abs() < 5e-4, "{target} at {time}: {drawn_u} {drawn_v}, {u} {v} expected");
        // The angle in the unit-sphere frame is another one.
        let radii_km = SESSION.catalog().body(NaifId(target)).expect("in the catalog").radii_km;
        let (sin, cos) = middle.lon_east_deg.to_radians().sin_cos();
        let parametric = (sin / radii_km.y).atan2(cos / radii_km.x).to_degrees() - middle.lon_east_deg;
        greatest_parametric_error = greatest_parametric_error.max(((parametric / 360.0 + 0.5).rem_euclid(1.0) - 0.5).abs());
    }
    assert!(greatest_parametric_error > 4e-3, "{greatest_parametric_error} turns");
}

#[test]
fn views_of_eclipse_ring_and_air_show_transmittance_and_optical_depth() {
    let eclipse = drawn(399, 3.0, DAY, PixelView::Eclipse);
    let on_ground = |p: &&[f32; 4]| p[3] > 0.999 && p[..3].iter().any(|v| *v > 0.0);
    let smallest = eclipse.hdr.iter().filter(on_ground).map(|p| p[1]).fold(1.0, smaller);
    let greatest = eclipse.hdr.iter().map(|p| p[1]).fold(0.0, larger);
    assert!(smallest < 0.1 && (greatest - 1.0).abs() < 1e-3, "the Moon's shadow leaves {smallest}, elsewhere {greatest}");

    // Straight down, Rayleigh scattering over the sea has an optical depth of about 0.22 at 450 nm and 0.05 at 650 nm (Bucholtz 1995); haze
    // adds to both.
    let air = drawn(399, 3.0, DAY, PixelView::OpticalDepth);
    let [r, g, b] = air.middle();
    assert!(0.05 < r && r < g && g < b && (0.2..0.6).contains(&b), "{r} {g} {b}");
    let limb_depth = air.hdr.iter().map(|p| p[2]).fold(0.0, larger);
    assert!(f64::from(limb_depth) > 4.0 * b, "{limb_depth} along the limb");

    // Where nothing eclipses the rings, they are as white as the globe, except for their transparency. They were black.
    let unshadowed = drawn(699, 5.0, "2017-05-17T00:00:00Z", PixelView::Eclipse);
    let is_eclipsed = unshadowed.scene.bodies.iter().flat_map(|b| &b.features).any(|f| f.eclipse.occluders > 0);
    assert!(!is_eclipsed, "the view does not test rings without an eclipse");
    let globe_radius_px = 0.5 * unshadowed.scene.body(NaifId(699)).expect("Saturn").diameter_px;
    let is_outside_globe = |k: usize| {
        let (x, y) = ((k % SIDE as usize) as f64 - 48.0, (k / SIDE as usize) as f64 - 48.0);
        x.hypot(y) > 1.15 * globe_radius_px
    };
    let on_rings = unshadowed.hdr.iter().enumerate().filter(|(k, _)| is_outside_globe(*k)).map(|(_, p)| p[1]);
    let brightest = on_rings.fold(0.0, larger);
    assert!((0.7..1.001).contains(&brightest), "{brightest}");

    // The B ring is nearly opaque (normal depth 1 to 2.5 and more) and the Cassini Division is not; the image contains both.
    let rings = drawn(699, 5.0, "2017-05-17T00:00:00Z", PixelView::OpticalDepth);
    let greatest_depth = rings.hdr.iter().map(|p| p[1]).fold(0.0, larger);
    assert!(greatest_depth > 1.0, "optical depth {greatest_depth}");
    let shadow = drawn(699, 5.0, "2017-05-17T00:00:00Z", PixelView::Ring);
    let across_globe = 48 * SIDE as usize + 38..48 * SIDE as usize + 59;
    assert!(shadow.hdr[across_globe].iter().any(|p| p[1] > 0.0));
}

#[test]
fn cost_counts_what_ran() {
    let draw_with = |effects: &str, view| {
        let request = ViewRequest {
            position: Position::AboveTarget { towards: None, distance_radii: Some(3.0) },
            effects: EffectOverrides::parse(effects).expect("effects"),
            pixel_view: view,
            width: SIDE,
            height: SIDE,
            ..ViewRequest::of(NaifId::EARTH, Instant::parse(DAY).expect("a time"))
        };
        SESSION.draw(&request, SamplingQuality { samples: 1, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
    };
    let albedo_only = draw_with("-normal,-atmosphere,-clouds,-cloud-shadow,-eclipse,-night,-specular", PixelView::Cost);
    let all_effects = draw_with("", PixelView::Cost);
    let (one, all) = (albedo_only[MIDDLE], all_effects[MIDDLE]);
    assert!(one[0] > 50.0 && one[0].fract() == 0.0, "{one:?}");
    assert_eq!(one[1], 1024.0, "one read: the albedo map");
    assert!(all[0] > 2.0 * one[0] && all[1] > one[1], "{all:?} with everything, {one:?} without");
    assert_eq!(all_effects[0], [0.0, 0.0, 0.0, 1.0], "nothing is drawn in the corner");
}

#[test]
fn the_legend_is_in_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, marker) in [("a.png", "Legend"), ("a.exr", "comments")] {
        let path = folder.path().join(name);
        let write = || {
            let args = ["render", "--target", "mars", "--time", DAY, "--size", "32x32", "--pixels", "optical-depth", "-o"];
            orrery(&args, &path);
            std::fs::read(&path).expect("written")
        };
        let bytes = write();
        let contains = |word: &str| bytes.windows(word.len()).any(|w| w == word.as_bytes());
        assert!(contains(marker) && contains("optical-depth: of the air") && contains("white 1.000000"), "{name}");
        assert_eq!(bytes, write(), "{name}: a second write gives the same bytes");
    }
}

/// Runs the built program.
fn orrery(args: &[&str], path: &std::path::Path) {
    let done = std::process::Command::new(crate::support::program::path()).args(args).arg(path).output().expect("runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
