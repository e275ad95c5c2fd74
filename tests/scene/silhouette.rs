//! The silhouette is accurate to a quarter of a pixel at any distance: the shader's f32 arithmetic is compared with f64, and the bounding
//! rectangle with the outline.

use crate::support::folds::larger;
use glam::{DMat3, DVec2, DVec3, Vec3};
use orrery::scene::camera::{AnchorForm, Camera, ClipRect, Placement, ViewRays};
use orrery::scene::silhouette::{Outline, PADDING_PX};
use orrery::units::KM_PER_AU;

fn orientation() -> DMat3 {
    DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(-0.4) * DMat3::from_rotation_y(1.1)
}

/// A camera `distance_km` from the centre of a body with the given semi-axes. The viewing direction is `off_axis_rad` away from the centre.
fn set_up(radii_km: DVec3, distance_km: f64, off_axis_rad: f64, fov_deg: f64, width: u32, height: u32) -> (Camera, Placement) {
    let direction = DVec3::new(0.3, -0.8, 0.52).normalize();
    let across = direction.cross(DVec3::Z).normalize();
    let forward = DMat3::from_axis_angle(across, off_axis_rad) * direction;
    let camera = Camera::looking(DVec3::ZERO, forward, DVec3::new(0.1, 0.2, 1.0), fov_deg, width, height);
    (camera, Placement { centre_km: direction * distance_km, body_from_icrf: orientation(), radii_km })
}

/// Points of the silhouette inside the frame, in clip space. They come from the cone of tangent rays to the unit sphere, in f64.
fn silhouette_points(camera: &Camera, placement: &Placement) -> Vec<DVec2> {
    let camera_in_unit_sphere = placement.camera_in_unit_sphere();
    let d = camera_in_unit_sphere.length();
    let to_centre = -camera_in_unit_sphere / d;
    let (e1, e2) = to_centre.any_orthonormal_pair();
    // Half angle of the cone of tangents: sin = 1/d.
    let (sin, cos) = (1.0 / d, ((d - 1.0) * (d + 1.0)).sqrt() / d);
    let count = 20_000;
    (0..count)
        .filter_map(|k| {
            let phi = std::f64::consts::TAU * f64::from(k) / f64::from(count);
            let ray = to_centre * cos + (e1 * phi.cos() + e2 * phi.sin()) * sin;
            let icrf = placement.body_from_icrf.transpose() * (ray * placement.radii_km);
            camera.clip(icrf).filter(|p| p.x.abs() <= 1.0 && p.y.abs() <= 1.0)
        })
        .collect()
}

/// How 1 - q² is computed, where q is the ray's distance from the centre in the unit sphere: in the shader's factored form, or from the
/// camera as a difference of squares.
#[derive(Clone, Copy)]
enum Formula {
    Factored,
    DifferenceOfSquares,
}

/// The discriminant in f32, with the varyings interpolated over the two triangles.
fn f32_discriminant(rays: &ViewRays, clip: DVec2, formula: Formula) -> f32 {
    let r = rays.rect_in_clip;
    // Barycentric weights of the pixel in the upper left or lower right triangle, as a rasteriser computes them.
    let u = ((clip.x - f64::from(r.x)) / f64::from(r.z - r.x)) as f32;
    let v = ((clip.y - f64::from(r.y)) / f64::from(r.w - r.y)) as f32;
    let corner = |o: Vec3, du: Vec3, dv: Vec3, x: f32, y: f32| o + x * du + y * dv;
    let interpolate = |o, du, dv| {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| corner(o, du, dv, x, y));
        if u + v <= 1.0 { a * (1.0 - u - v) + b * u + c * v } else { d * (u + v - 1.0) + b * (1.0 - v) + c * (1.0 - u) }
    };
    let ray: Vec3 = interpolate(rays.ray_origin, rays.ray_du, rays.ray_dv);
    match formula {
        Formula::Factored => {
            let [linear, quadratic] = rays.silhouette_form;
            (linear.x + u * (linear.y + u * quadratic.x + v * quadratic.y) + v * (linear.z + v * quadratic.z)) / ray.dot(ray)
        }
        Formula::DifferenceOfSquares => {
            let anchor: Vec3 = interpolate(rays.anchor_origin, rays.anchor_du, rays.anchor_dv);
            anchor.dot(ray.normalize_or_zero()).powi(2) - rays.anchor_radius_sq_minus_1
        }
    }
}

/// The same discriminant in f64, from the camera. The cross product of the camera's position and the ray is accurate at any distance.
fn exact_discriminant(camera: &Camera, placement: &Placement, clip: DVec2) -> f64 {
    let ray = placement.direction_in_unit_sphere(camera.ray(clip)).normalize();
    1.0 - placement.camera_in_unit_sphere().cross(ray).length_squared()
}

/// Largest distance in pixels between the f32 silhouette and the exact one, over the exact silhouette's points inside the frame.
fn worst_px(camera: &Camera, placement: &Placement, formula: Formula) -> Option<f64> {
    let rect = Outline::of(camera, placement).rect(camera)?;
    let rays = camera.view_rays(
        placement,
        rect,
        if matches!(formula, Formula::DifferenceOfSquares) { AnchorForm::Camera } else { AnchorForm::Auto },
    );
    let step = 1.0 / camera.half_size_px();
    let points = silhouette_points(camera, placement);
    let stride = (points.len() / 400).max(1);
    points
        .iter()
        .step_by(stride)
        .map(|&p| {
            let slope =
                |axis: DVec2| (exact_discriminant(camera, placement, p + axis) - exact_discriminant(camera, placement, p - axis)) / 2.0;
            let gradient = DVec2::new(slope(DVec2::new(step.x, 0.0)), slope(DVec2::new(0.0, step.y))).length();
            f64::from(f32_discriminant(&rays, p, formula)).abs() / gradient
        })
        .reduce(larger)
}

const EARTH_RADII_KM: DVec3 = DVec3::new(6378.137, 6378.137, 6356.752);
/// (name, radii in km, distance in km, angle off axis in rad, field of view in deg).
fn cases() -> Vec<(String, DVec3, f64, f64, f64)> {
    let mut all = Vec::new();
    for height_km in [0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 400.0] {
        for fov_deg in [5.0, 60.0, 120.0] {
            // The horizon is at 90 degrees from the nadir minus its dip; aim the camera at it.
            all.push((format!("{} m over the Earth, fov {fov_deg}", height_km * 1e3), EARTH_RADII_KM, 6378.2 + height_km, 1.5, fov_deg));
        }
    }
    for distance_radii in [1.05, 1.2, 1.4, 1.7, 2.0, 3.0, 4.0, 6.0, 10.0, 60.0, 1e3, 1e5] {
        let fitted_fov_deg = 2.0 * (1.0_f64 / distance_radii).min(1.0).asin().to_degrees();
        for fov_deg in [fitted_fov_deg.min(120.0), (fitted_fov_deg / 8.0).min(120.0)] {
            let off_axis_rad =
                if fov_deg < fitted_fov_deg.min(120.0) { (1.0_f64 / distance_radii).asin() } else { 0.1 * fov_deg.to_radians() };
            all.push((
                format!("{distance_radii} radii, fov {fov_deg:.4}"),
                EARTH_RADII_KM,
                EARTH_RADII_KM.x * distance_radii,
                off_axis_rad,
                fov_deg,
            ));
        }
    }
    for (name, radii_km, distance_km) in [
        ("Neptune from 100 au", DVec3::new(24764.0, 24764.0, 24341.0), 100.0 * KM_PER_AU),
        ("Phobos from 100 au", DVec3::new(13.0, 11.4, 9.1), 100.0 * KM_PER_AU),
        ("the Sun from 100 au", DVec3::splat(695_700.0), 100.0 * KM_PER_AU),
    ] {
        let fov_deg = 2.6 * (radii_km.x / distance_km).to_degrees();
        all.push((name.into(), radii_km, distance_km, 0.1 * fov_deg.to_radians(), fov_deg));
    }
    all
}

#[test]
fn the_silhouette_is_accurate_to_a_quarter_pixel_from_a_metre_to_a_hundred_au() {
    let mut worst: (f64, String) = (0.0, String::new());
    let mut measured = 0;
    for (name, radii_km, distance_km, off_axis_rad, fov_deg) in cases() {
        let (camera, placement) = set_up(radii_km, distance_km, off_axis_rad, fov_deg, 1024, 1024);
        let Some(error_px) = worst_px(&camera, &placement, Formula::Factored) else { continue };
        measured += 1;
        println!("{name:44} {error_px:.5} px");
        assert!(error_px <= 0.25, "{name}: {error_px} px");
        if error_px > worst.0 {
            worst = (error_px, name);
        }
    }
    println!("worst: {} px, {}", worst.0, worst.1);
    assert!(measured > 30, "only {measured} cases had a silhouette in the frame");
}

#[test]
fn the_check_detects_the_cancellation_of_a_difference_of_squares() {
    // From far away, the difference of two large squares loses its digits to cancellation; `worst_px` must detect this.
    let (camera, placement) = set_up(EARTH_RADII_KM, EARTH_RADII_KM.x * 1e5, 0.0, 1.5e-3, 1024, 1024);
    assert!(worst_px(&camera, &placement, Formula::DifferenceOfSquares).expect("in the frame") > 1.0);
    assert!(worst_px(&camera, &placement, Formula::Factored).expect("in the frame") < 0.01);
}

#[test]
fn the_bounding_rectangle_touches_the_outline() {
    let mut ellipses = 0;
    for (name, radii_km, distance_km, off_axis_rad, fov_deg) in cases() {
        let (camera, placement) = set_up(radii_km, distance_km, off_axis_rad * 0.5, fov_deg, 800, 600);
        let Outline::Ellipse { bounds, area_px } = Outline::of(&camera, &placement) else { continue };
        ellipses += 1;
        // A much wider frame contains the entire outline; its points are scaled back by the ratio of the tangents.
        let mut wide = camera.clone();
        wide.tan_half_fov *= 1e3;
        let points: Vec<DVec2> = silhouette_points(&wide, &placement).into_iter().map(|p| p * 1e3).collect();
        let extreme =
            |pick: fn(f64, f64) -> f64, coordinate: fn(&DVec2) -> f64| points.iter().map(coordinate).reduce(pick).expect("an outline");
        let pixel: f64 = 2.0 / 600.0;
        let size = (bounds.right - bounds.left).abs().max((bounds.top - bounds.bottom).abs());
        let tolerance = (0.02 * pixel).max(2e-6 * size);
        for (side, exact, bound) in [
            ("left", extreme(f64::min, |p| p.x), bounds.left),
            ("right", extreme(f64::max, |p| p.x), bounds.right),
            ("bottom", extreme(f64::min, |p| p.y), bounds.bottom),
            ("top", extreme(f64::max, |p| p.y), bounds.top),
        ] {
            assert!((exact - bound).abs() < tolerance, "{name}, {side}: outline {exact}, box {bound}");
        }
        // Shoelace area of the outline in pixels.
        let px: Vec<DVec2> = points.iter().map(|&p| camera.pixel_from_clip(p)).collect();
        let shoelace: f64 = px.iter().zip(px.iter().cycle().skip(1)).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() / 2.0;
        assert!((shoelace / area_px - 1.0).abs() < 1e-4, "{name}: area {area_px}, outline {shoelace}");
    }
    assert!(ellipses > 10, "{ellipses} outlines");
}

#[test]
fn bodies_outside_the_frame_have_no_rectangle_and_the_ground_fills_the_frame() {
    let behind = set_up(EARTH_RADII_KM, 1e5, std::f64::consts::PI, 60.0, 64, 64);
    assert_eq!(Outline::of(&behind.0, &behind.1), Outline::Behind);
    let beside = set_up(EARTH_RADII_KM, 1e6, 1.0, 20.0, 64, 64);
    assert_eq!(Outline::of(&beside.0, &beside.1).rect(&beside.0), None);
    let ground = set_up(EARTH_RADII_KM, 6378.2, 1.5, 60.0, 64, 64);
    assert_eq!(Outline::of(&ground.0, &ground.1).rect(&ground.0), Some(ClipRect::VIEWPORT));
    // The rectangle of a body in the middle of the frame is padded.
    let (camera, placement) = set_up(DVec3::splat(1000.0), 1e5, 0.0, 10.0, 500, 500);
    let Outline::Ellipse { bounds, .. } = Outline::of(&camera, &placement) else { panic!("in front") };
    let rect = Outline::of(&camera, &placement).rect(&camera).expect("in the frame");
    assert!((bounds.left - rect.left - PADDING_PX / 250.0).abs() < 1e-12);
    assert!((rect.top - bounds.top - PADDING_PX / 250.0).abs() < 1e-12);
}

/// Near the ground, in any viewing direction: a body that is [`Outline::Beside`] covers no pixel, and a body that is [`Outline::Open`]
/// covers a pixel of the frame or of a border of 3 pixels around it.
#[test]
fn a_body_is_classified_as_outside_only_if_it_covers_no_pixel() {
    let (mut beside, mut open) = (0, 0);
    for distance_km in [6378.15, 6400.0, 6800.0, 9000.0] {
        for fov_deg in [10.0, 45.0, 100.0] {
            for k in 0..60 {
                let off_axis_rad = std::f64::consts::PI * (f64::from(k) + 0.5) / 60.0;
                let (camera, placement) = set_up(EARTH_RADII_KM, distance_km, off_axis_rad, fov_deg, 90, 60);
                let is_visible = |margin: i32| {
                    let positions = |size: i32| (-margin..=size + margin).map(f64::from);
                    positions(90).any(|x| positions(60).any(|y| camera.surface_under_pixel(&placement, DVec2::new(x, y)).is_some()))
                };
                match Outline::of(&camera, &placement) {
                    Outline::Beside => {
                        assert!(!is_visible(0), "{distance_km} km, {fov_deg} degrees, {off_axis_rad} rad off axis: a pixel shows the body");
                        beside += 1;
                    }
                    Outline::Open => {
                        assert!(
                            is_visible(3),
                            "{distance_km} km, {fov_deg} degrees, {off_axis_rad} rad off axis: no part of the body is in the frame"
                        );
                        open += 1;
                    }
                    _ => {}
                }
            }
        }
    }
    assert!(beside > 100 && open > 100, "{beside} {open}");
}

#[test]
fn a_point_on_the_ground_maps_to_a_pixel_and_back() {
    for (distance_km, fov_deg) in [(7000.0, 90.0), (20_000.0, 40.0), (384_400.0, 2.2), (KM_PER_AU, 0.006), (100.0 * KM_PER_AU, 6e-5)] {
        let (camera, placement) = set_up(EARTH_RADII_KM, distance_km, 0.0, fov_deg, 1000, 700);
        let mut checked = 0;
        for lat in (-80..=80).step_by(20) {
            for lon in (-180..180).step_by(20) {
                let (lat, lon) = (f64::from(lat).to_radians(), f64::from(lon).to_radians());
                let unit = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
                let Some(pixel) = camera.pixel_of_surface(&placement, unit) else { continue };
                let back = camera.surface_under_pixel(&placement, pixel).expect("the pixel shows the body");
                // Near the limb, rounding of the pixel position corresponds to a long distance on the ground: compare foreshortened
                // distances.
                let foreshortening = unit.dot(placement.camera_in_unit_sphere().normalize()).max(1e-3);
                assert!(((back - unit) * foreshortening).length() < 1e-6, "{distance_km} km: {unit} came back as {back}");
                checked += 1;
            }
        }
        assert!(checked >= 4, "{checked} places checked from {distance_km} km");
    }
}

/// The most, in pixels, by which a GPU shifts the rays of a rectangle if it rounds the corners to multiples of 1/256 pixel and interpolates
/// between those.
fn ray_shift_px([left, top, right, bottom]: [f64; 4], camera: &Camera) -> f64 {
    let corners = [DVec2::new(left, top), DVec2::new(right, bottom)].map(|clip| camera.pixel_from_clip(clip));
    let moved = corners.map(|corner| (corner * 256.0).round() / 256.0);
    let part_of = |px: DVec2, [from, to]: [DVec2; 2]| (px - from) / (to - from);
    corners
        .map(|px| ((part_of(px, corners) - part_of(px, moved)) * (corners[1] - corners[0])).abs().max_element())
        .into_iter()
        .fold(0.0, larger)
}

#[test]
fn a_gpu_that_rounds_corners_to_a_256th_of_a_pixel_shifts_no_ray() {
    let mut worst_of_outlines = 0.0_f64;
    for (width, height) in [(16, 16), (33, 97), (1280, 800), (3840, 2160), (16_384, 16_384)] {
        // Corners are f32 in clip space: 6e-8 of half the side.
        let bound = 1e-7 * f64::from(width.max(height)) + 1e-9;
        for distance_radii in [1.5, 4.0, 30.0, 700.0] {
            let radii_km = DVec3::new(6000.0, 6000.0, 5800.0);
            let (camera, placement) = set_up(radii_km, distance_radii * radii_km.x, 0.0, 40.0, width, height);
            let Some(rect) = Outline::of(&camera, &placement).rect(&camera) else { continue };
            let rays = camera.view_rays(&placement, rect, AnchorForm::Auto);
            let drawn = rays.rect_in_clip.as_dvec4().to_array();
            let shift = ray_shift_px(drawn, &camera);
            assert!(shift < bound, "{width}x{height}, {distance_radii} radii: {shift} px");
            let [left, top, right, bottom] = drawn;
            let contains = left <= rect.left + 1e-7 && right >= rect.right - 1e-7 && top >= rect.top - 1e-7 && bottom <= rect.bottom + 1e-7;
            assert!(contains, "{drawn:?} does not contain {rect:?}");
            worst_of_outlines = worst_of_outlines.max(ray_shift_px([rect.left, rect.top, rect.right, rect.bottom], &camera));
        }
    }
    assert!(worst_of_outlines > 1e-3, "the outlines' own rectangles would move rays by {worst_of_outlines} px only");
}
