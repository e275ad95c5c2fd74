//! The Sun's glare over the image (`glow`): the same law in every projection, and a Sun that leaves the image, drawn as a disc or as a point.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::glare::VEILING_GLARE_COEFFICIENT;
use orrery::scene::request::{Axes, Composition, ExposureRequest, Layers, Look, Position, Projection, Purpose, Up, ViewRequest};
use orrery::session::DrawnFrame;
use orrery::time::Instant;
use orrery::units::KM_PER_AU;
use orrery::{FrameImages, ephemeris};

/// Linear light of the Sun's disc and its glare alone, 1 au from the Sun, whose direction is ICRF x; `beside_deg`: angle of the line of sight from the Sun.
fn request(projection: Projection, beside_deg: f64, fov_deg: Option<f64>, [width, height]: [u32; 2]) -> ViewRequest {
    let (sin, cos) = beside_deg.to_radians().sin_cos();
    ViewRequest {
        position: Position::Offset { body: NaifId::SUN, offset_km: DVec3::NEG_X * KM_PER_AU, axes: Axes::Icrf },
        look: Look::Along { direction: DVec3::new(cos, sin, 0.0), axes: Axes::Icrf },
        composition: Composition { projection, ..Composition::default() },
        fov_deg,
        width,
        height,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse("-corona,sun:-points").expect("effects"),
        layers: Layers::NONE,
        purpose: Purpose::LINEAR,
        ..ViewRequest::of(NaifId::SUN, Instant::parse("2024-06-21T00:00:00Z").expect("a time"))
    }
}

fn drawn(request: &ViewRequest) -> DrawnFrame {
    SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn")
}

/// The law of Stiles and Holladay, which fades out between 30 and 90 degrees, at each pixel of a perspective image, a dome image and a whole-sphere image.
/// Negative control: the law that does not fade.
#[test]
fn the_glare_depends_on_the_direction_only() {
    for (projection, fov_deg, size, least_pixels) in [
        (Projection::Perspective, Some(90.0), [64, 64], 3000),
        (Projection::Fisheye, Some(200.0), [96, 96], 3000),
        (Projection::Equirectangular, None, [128, 64], 1500),
    ] {
        let image = drawn(&request(projection, 25.0, fov_deg, size));
        let scene = &image.scene;
        let sun_km = scene.body(NaifId::SUN).expect("the Sun").placement.centre_km;
        let (towards, irradiance) = (sun_km.normalize(), (KM_PER_AU / sun_km.length()).powi(2));
        let (mut worst, mut worst_of_control, mut pixels) = (0.0_f64, 0.0_f64, 0);
        for (k, light) in image.frame.hdr.iter().enumerate() {
            let (x, y) = (k % size[0] as usize, k / size[0] as usize);
            let centre_px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let Some(direction) = scene.geometry.direction(&scene.camera, centre_px) else { continue };
            let angle_deg = ephemeris::angle_rad(direction, towards).to_degrees();
            let green = f64::from(light[1]);
            // Nearer, a pixel is too wide for the law at its centre; farther, the rim of the fisheye has partly black pixels.
            if angle_deg > 95.0 {
                // Planets are points of at most 1e-6.
                assert!(green < 1e-5, "{projection:?}: {green} at {angle_deg} degrees from the Sun");
            } else if (20.0..70.0).contains(&angle_deg) {
                let chord_sq = |deg: f64| (2.0 * (0.5 * deg.to_radians()).sin()).powi(2);
                let risen = ((chord_sq(angle_deg) - chord_sq(30.0)) / (chord_sq(90.0) - chord_sq(30.0))).clamp(0.0, 1.0);
                let unfaded = VEILING_GLARE_COEFFICIENT * irradiance / chord_sq(angle_deg);
                let expected = unfaded * (1.0 - risen * risen * (3.0 - 2.0 * risen));
                worst = larger(worst, (green / expected - 1.0).abs());
                worst_of_control = larger(worst_of_control, (green / unfaded - 1.0).abs());
                pixels += 1;
            }
        }
        println!("{projection:?}: {worst:.4} in {pixels} pixels");
        assert!(worst < 0.02 && pixels > least_pixels, "{projection:?}: {worst} in {pixels} pixels");
        assert!(worst_of_control > 0.15, "{projection:?}: {worst_of_control}");
    }
}

/// The line of sight turns away from the Sun, in steps of 0.1 degrees: when the Sun leaves the frame, 30 degrees from its middle, the light in the middle
/// fades steadily, and is gone 9 degrees later. In a whole-sphere image nothing leaves.
#[test]
fn the_glare_fades_while_the_sun_leaves_the_frame() {
    let light_in_middle = |projection, beside_deg: f64| {
        let size = [32, 32];
        let image = drawn(&request(projection, beside_deg, Some(60.0).filter(|_| projection == Projection::Perspective), size));
        let middle = (size[0] * size[1] / 2 + size[0] / 2) as usize;
        f64::from(image.frame.hdr[middle][1])
    };
    let light: Vec<f64> = (290..=395).map(|k| light_in_middle(Projection::Perspective, 0.1 * f64::from(k))).collect();
    for (k, [before, after]) in light.array_windows().enumerate() {
        let beside_deg = 29.0 + 0.1 * k as f64;
        assert!(after <= before, "{beside_deg} degrees: {before} to {after}");
        assert!(*after >= before * 5.0 / 6.0 - 1e-4 * light[0], "{beside_deg} degrees: {before} to {after}");
    }
    // What is left are planets, as points.
    assert!(light[0] > 0.01 && light[105] < 1e-3 * light[0], "{} to {}", light[0], light[105]);
    let of_sphere = |beside_deg| light_in_middle(Projection::Equirectangular, beside_deg);
    assert!(of_sphere(39.5) > 0.4 * of_sphere(29.0));
}

/// As [`request`], but the Sun is a point where it is small, at a distance and an exposure that shows the same glare at any distance.
fn request_with_point(projection: Projection, beside_deg: f64, distance_au: f64, size: [u32; 2]) -> ViewRequest {
    let fov_deg = (projection == Projection::Perspective).then_some(60.0);
    ViewRequest {
        position: Position::Offset { body: NaifId::SUN, offset_km: DVec3::NEG_X * KM_PER_AU * distance_au, axes: Axes::Icrf },
        effects: EffectOverrides::parse("-corona").expect("effects"),
        exposure: ExposureRequest::Stops(2.0 * distance_au.log2()),
        up: Up::Along { direction: DVec3::Z, axes: Axes::Icrf },
        ..request(projection, beside_deg, fov_deg, size)
    }
}

/// Green light in the middle of a perspective image of 32 pixels, relative to the Sun's irradiance.
fn relative_light_in_middle(beside_deg: f64, distance_au: f64) -> f64 {
    let image = drawn(&request_with_point(Projection::Perspective, beside_deg, distance_au, [32, 32]));
    f64::from(image.frame.hdr[32 * 16 + 16][1]) * distance_au.powi(2)
}

/// The same for a Sun of a third of a pixel, whose sprite is as wide as the image and gives most of the light. Its light ended within a tenth of a degree.
#[test]
fn the_sprite_of_a_point_like_sun_fades_while_it_leaves_the_frame() {
    let light: Vec<f64> = (290..=395).map(|k| relative_light_in_middle(0.1 * f64::from(k), 1.0)).collect();
    for (k, [before, after]) in light.array_windows().enumerate() {
        let beside_deg = 29.0 + 0.1 * k as f64;
        assert!(after <= before && *after >= before * 5.0 / 6.0 - 1e-4 * light[0], "{beside_deg} degrees: {before} to {after}");
    }
    let of_veil = |beside_deg: f64| {
        let image = drawn(&request(Projection::Perspective, beside_deg, Some(60.0), [32, 32]));
        f64::from(image.frame.hdr[32 * 16 + 16][1])
    };
    assert!(light[0] > 2.0 * of_veil(29.0) && light[105] < 1e-3 * light[0], "{} to {}", light[0], light[105]);
    // Beside the frame, too, the sprite adds to the light of the veil.
    assert!(light[20] > 1.5 * of_veil(31.0), "{}, {}", light[20], of_veil(31.0));
}

/// From 0.01 au, where the Sun is a disc of 53 degrees, to 100 au, where it is a point, with its centre just inside the frame, just outside, and farther
/// out: the glare in the middle changes steadily, and the edge makes no difference. Near 0.1 au the disc becomes a point, whose sprite adds to the glare.
/// Negative control: from disc to point the glare grows by far more than in any step.
#[test]
fn the_glare_at_the_edge_is_steady_from_disc_to_point() {
    let distance_au = |k: i32| 0.01 * 1.1_f64.powi(k);
    for beside_deg in [29.97, 30.03, 32.0] {
        let light: Vec<f64> = (0..=97).map(|k| relative_light_in_middle(beside_deg, distance_au(k))).collect();
        for (k, [before, after]) in (0..).zip(light.array_windows()) {
            let step = (after / before).ln().abs();
            assert!(step < 0.45, "{beside_deg} degrees, {} au: {before} to {after}", distance_au(k));
        }
        assert!(light[97] > 2.0 * light[15], "{beside_deg} degrees: {} to {}", light[15], light[97]);
    }
    for k in [0, 10, 20, 25, 30, 50, 97] {
        let [inside, outside] = [29.97, 30.03].map(|deg| relative_light_in_middle(deg, distance_au(k)));
        assert!((inside / outside).ln().abs() < 0.06, "{} au: {inside} inside, {outside} outside", distance_au(k));
    }
}

/// In a whole-sphere image no direction is outside, whichever face of the cube shows it: with the Sun on the edge of two faces, 45 degrees from the middle, the
/// light around it is that of a Sun in the middle of a face.
#[test]
fn the_sprite_of_a_whole_sphere_image_ignores_the_edges_of_faces() {
    let flux = |beside_deg: f64| {
        let scene = drawn(&request_with_point(Projection::Equirectangular, beside_deg, 1.0, [64, 32])).scene;
        let sun: Vec<_> = scene.points.iter().filter(|p| p.body == NaifId::SUN).collect();
        assert_eq!(sun.len(), 1, "{beside_deg}");
        f64::from(sun[0].flux.y)
    };
    let in_middle = flux(0.0);
    for beside_deg in [44.9, 45.0, 45.1] {
        assert!((flux(beside_deg) / in_middle - 1.0).abs() < 1e-3, "{beside_deg}: {}, {in_middle}", flux(beside_deg));
    }
}

/// The decision about the glare says that the Sun is beside the image.
#[test]
fn the_reason_names_a_sun_beside_the_image() {
    let reason = |beside_deg: f64| {
        let scene = SESSION.scene(&request(Projection::Perspective, beside_deg, Some(60.0), [32, 32])).expect("a scene");
        let sun = scene.body(NaifId::SUN).expect("the Sun");
        sun.decisions.iter().find(|d| d.effect == "glow").map(|d| d.reason.to_string())
    };
    assert!(reason(20.0).is_some_and(|r| r.starts_with("glare at the limb")), "{:?}", reason(20.0));
    assert!(reason(35.0).is_some_and(|r| r.starts_with("the Sun is beside the image")), "{:?}", reason(35.0));
    assert_eq!(reason(60.0), None);
}
