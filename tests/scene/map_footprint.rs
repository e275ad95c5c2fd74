//! A pixel's footprint on a map, as the shader computes it from view rays, is compared with differences of intersections in f64: over the disc,
//! at its limb and at the poles.

use crate::support::emitted::{Emitted, EvalInput};
use crate::support::folds::{larger, smaller};
use glam::{DMat3, DVec2, DVec3, Vec3};
use orrery::scene::camera::{AnchorForm, Camera, Placement, ViewRays};
use orrery::scene::draw::DrawUniforms;
use orrery::scene::silhouette::Outline;
use std::f64::consts::{PI, TAU};

const MODULE: &str = "lambert.sun0.ellipsoid.uv";
/// WGSL: the hit of the view ray at the place `p.xy` of the rectangle around the body. The tests insert it for `HIT` in the expressions that they
/// evaluate.
const HIT: &str = "surface_hit(Varyings(vec4f(0.0), draw.anchor_origin + p.x * draw.anchor_du + p.y * draw.anchor_dv, \
                   draw.ray_origin + p.x * draw.ray_du + p.y * draw.ray_dv, p.xy))";
const IMAGE_PX: u32 = 256;

/// The rays of a view of an oblate body. `distance_radii`: in its equatorial radii. `off_axis_rad`: the angle from the direction in which the
/// camera looks to the body's centre.
fn rays(distance_radii: f64, off_axis_rad: f64, fov_deg: f64) -> ViewRays {
    let direction = DVec3::new(0.3, -0.8, 0.52).normalize();
    let forward = DMat3::from_axis_angle(direction.cross(DVec3::Z).normalize(), off_axis_rad) * direction;
    let camera = Camera::looking(DVec3::ZERO, forward, DVec3::new(0.1, 0.2, 1.0), fov_deg, IMAGE_PX, IMAGE_PX);
    let radii_km = DVec3::new(60_268.0, 60_268.0, 54_364.0);
    let placement =
        Placement { centre_km: direction * (distance_radii * radii_km.x), body_from_icrf: DMat3::from_rotation_x(-0.4), radii_km };
    let rect = Outline::of(&camera, &placement).rect(&camera).expect("in the image");
    camera.view_rays(&placement, rect, AnchorForm::Auto)
}

fn uniforms(rays: &ViewRays) -> DrawUniforms {
    DrawUniforms { axis_ratios: Vec3::new(1.0, 1.0, 0.902), ..DrawUniforms::of_rays(rays) }
}

/// The anchor and the direction of the ray at a place of the rectangle.
fn ray_at(rays: &ViewRays, place: DVec2) -> (DVec3, DVec3) {
    let at_place = |origin: Vec3, du: Vec3, dv: Vec3| origin.as_dvec3() + place.x * du.as_dvec3() + place.y * dv.as_dvec3();
    (at_place(rays.anchor_origin, rays.anchor_du, rays.anchor_dv), at_place(rays.ray_origin, rays.ray_du, rays.ray_dv).normalize())
}

/// The point of the ray nearest to the body's centre, unit-sphere frame.
fn closest_point(rays: &ViewRays, place: DVec2) -> DVec3 {
    let (anchor, along) = ray_at(rays, place);
    anchor - along * anchor.dot(along)
}

/// Where the ray enters the unit sphere.
fn entry(rays: &ViewRays, place: DVec2) -> Option<DVec3> {
    let (_, along) = ray_at(rays, place);
    let closest = closest_point(rays, place);
    let half_chord = (1.0 - closest.length_squared()).sqrt();
    half_chord.is_finite().then(|| closest - along * half_chord)
}

/// Width and height of a pixel in the rectangle's coordinates.
fn pixel_size(rays: &ViewRays) -> DVec2 {
    let rect = rays.rect_in_clip.as_dvec4();
    DVec2::new(1.0 / (rect.z - rect.x), 1.0 / (rect.y - rect.w)) * (2.0 / f64::from(IMAGE_PX))
}

/// Inputs for the four pixels of a quad. The upper left one is at `place`.
fn quad(rays: &ViewRays, place: DVec2) -> [EvalInput; 4] {
    let size = pixel_size(rays);
    [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|pixels| {
        let at = place + pixels * size;
        [at.x, at.y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    })
}

/// The value of a WGSL expression of `HIT` at each place. A quad is evaluated at each, because derivatives need the other three pixels.
fn value_in_quads(value: &str, rays: &ViewRays, places: &[DVec2]) -> Vec<DVec3> {
    let inputs: Vec<EvalInput> = places.iter().flat_map(|place| quad(rays, *place)).collect();
    let results = Emitted::new(MODULE, &value.replace("HIT", HIT)).evaluate(&uniforms(rays), None, &inputs);
    results.iter().step_by(4).map(|r| DVec3::new(r[0], r[1], r[2])).collect()
}

/// Views from 0.02 radii above the ground to 10,000 radii from the centre: `rays` of distance, angle off axis, and field of view.
fn views() -> Vec<ViewRays> {
    [(1.02, 1.2, 60.0), (1.3, 0.7, 60.0), (3.0, 0.0, 45.0), (60.0, 0.0, 2.5), (1e4, 0.0, 0.015), (60.0, 0.0158, 0.2)]
        .map(|(distance_radii, off_axis_rad, fov_deg)| rays(distance_radii, off_axis_rad, fov_deg))
        .to_vec()
}

/// `count` times `count` places of the rectangle.
fn grid(count: i32) -> impl Iterator<Item = DVec2> {
    (0..count).flat_map(move |y| (0..count).map(move |x| DVec2::new(f64::from(x) + 0.3, f64::from(y) + 0.6) / f64::from(count)))
}

#[test]
fn steps_over_the_ground_are_the_differences_of_intersections() {
    for rays in views() {
        let pixel = pixel_size(&rays);
        // Away from the limb, where the ground is nearly flat within a pixel.
        let is_inside = |place: &DVec2| {
            let (length, next) = (closest_point(&rays, *place).length(), closest_point(&rays, *place + pixel).length());
            1.0 - length > 12.0 * (next - length).abs().max(1e-9)
        };
        let places: Vec<DVec2> = grid(24).filter(is_inside).collect();
        assert!(places.len() > 30, "{}", places.len());
        for (value, axis) in [("vec4f(HIT.step_x, 0.0)", DVec2::X), ("vec4f(HIT.step_y, 0.0)", DVec2::Y)] {
            for (place, found) in places.iter().zip(value_in_quads(value, &rays, &places)) {
                let offset = pixel * axis * 0.01;
                let (Some(before), Some(after)) = (entry(&rays, *place - offset), entry(&rays, *place + offset)) else { continue };
                // The two intersections are 0.02 pixels apart.
                let expected = (after - before) * 50.0;
                assert!((found - expected).length() < 0.01 * expected.length(), "{place}: {found}, not {expected}");
            }
        }
    }
}

/// In a pixel that the limb crosses, the footprint is not much shorter than a pixel, although some rays of the quad miss the body, and not much
/// longer than the ground that the pixel shows. Negative control: differences of hit points (`dpdx`) are shorter.
#[test]
fn pixels_across_the_limb_keep_their_width() {
    let mut shortest_difference = f64::INFINITY;
    for rays in views() {
        let pixel = pixel_size(&rays);
        let width = |place: DVec2| (closest_point(&rays, place + pixel * DVec2::X) - closest_point(&rays, place)).length();
        let is_across_limb = |place: &DVec2| {
            let corners =
                [DVec2::ZERO, pixel * DVec2::X, pixel * DVec2::Y, pixel].map(|corner| closest_point(&rays, *place + corner).length());
            corners.iter().any(|distance| *distance < 1.0) && corners.iter().any(|distance| *distance > 1.0)
        };
        let places: Vec<DVec2> = grid(400).filter(is_across_limb).collect();
        assert!(places.len() > 20, "{}", places.len());
        // The chord: a pixel of width w at the limb shows ground over a length of about sqrt(w).
        // The lengths of the steps, in pixels and in chords.
        let pixels_and_chords = |value: &str| -> Vec<(f64, f64)> {
            let steps = value_in_quads(value, &rays, &places);
            places.iter().zip(steps).map(|(place, step)| (step.length() / width(*place), step.length() / width(*place).sqrt())).collect()
        };
        let of_steps = pixels_and_chords("vec4f(HIT.step_x, 0.0)");
        let least_pixels = of_steps.iter().map(|(pixels, _)| *pixels).fold(f64::INFINITY, smaller);
        let most_chords = of_steps.iter().map(|(_, chords)| *chords).fold(0.0, larger);
        assert!(least_pixels > 0.9, "{least_pixels} pixels");
        assert!(most_chords < 2.0, "{most_chords} chords");
        // `f64::min` leaves out rays that miss the body, where a difference may be NaN.
        let of_differences = pixels_and_chords("vec4f(dpdx(HIT.position), 0.0)");
        shortest_difference = of_differences.iter().map(|(pixels, _)| *pixels).fold(shortest_difference, f64::min);
    }
    assert!(shortest_difference < 0.7, "the shortest difference is {shortest_difference} pixels");
}

/// Compares derivatives of map coordinates with differences, from the equator to a thousandth of a radian from the poles, for maps of
/// planetocentric and of planetographic latitude.
#[test]
fn map_coordinates_change_by_their_derivatives() {
    // `p.xyz` is the position, `q.xyz` the step to the next pixel right. The step down has the same components in another order.
    let emitted = Emitted::new(
        MODULE,
        "vec4f(map_coordinates(p.xyz, q.xyz, vec3f(q.z, q.x, q.y), vec2f(q.w, p.w)).dx, \
         map_coordinates(p.xyz, q.xyz, vec3f(q.z, q.x, q.y), vec2f(q.w, p.w)).dy)",
    );
    let turns_and_half_turns = |position: DVec3, stretch: DVec2| {
        let (x, y, z) = (position.x, stretch.x * position.y, stretch.y * position.z);
        DVec2::new(y.atan2(x) / TAU, -z.atan2(x.hypot(y)) / PI)
    };
    let mut inputs: Vec<EvalInput> = Vec::new();
    for latitude in [-PI / 2.0 + 1e-3, -1.5, -0.9, 0.0, 0.3, 1.2, PI / 2.0 - 1e-3] {
        for longitude in [0.2, 1.7, 3.1, -2.5] {
            // Three bodies with round equators, and the semi-axes of Hyperion.
            for stretch in [DVec2::ONE, DVec2::new(1.0, 0.83), DVec2::new(1.0, 1.2), DVec2::new(0.74, 0.57)] {
                let p = DVec3::new(latitude.cos() * f64::cos(longitude), latitude.cos() * f64::sin(longitude), f64::sin(latitude));
                for step in [DVec3::new(3e-3, -1e-3, 2e-3), DVec3::new(0.0, 0.0, 1e-3), DVec3::new(-4e-4, 1e-3, 0.0)] {
                    inputs.push([p.x, p.y, p.z, stretch.y, step.x, step.y, step.z, stretch.x]);
                }
            }
        }
    }
    let results = emitted.evaluate(&DrawUniforms::default(), None, &inputs);
    for (input, found) in inputs.iter().zip(results) {
        let (p, stretch) = (DVec3::new(input[0], input[1], input[2]), DVec2::new(input[7], input[3]));
        for (step, found) in [
            (DVec3::new(input[4], input[5], input[6]), DVec2::new(found[0], found[1])),
            (DVec3::new(input[6], input[4], input[5]), DVec2::new(found[2], found[3])),
        ] {
            let scale = 1e-5 * p.x.hypot(p.y);
            let difference = turns_and_half_turns(p + step * scale, stretch) - turns_and_half_turns(p - step * scale, stretch);
            // Without whole turns, which appear across the antimeridian.
            let turns = difference.x - difference.x.round();
            // Near a pole the shader narrows footprints in longitude: by 5 times the radius of the parallel, where that is less than 1.
            let parallel_radius = p.x.hypot(stretch.x * p.y) / DVec3::new(p.x, stretch.x * p.y, stretch.y * p.z).length();
            let expected = DVec2::new(turns * (5.0 * parallel_radius).min(1.0), difference.y) / (2.0 * scale);
            assert!((found - expected).length() < 1e-4 * expected.length() + 1e-8, "{input:?}: {found}, not {expected}");
        }
    }
}
