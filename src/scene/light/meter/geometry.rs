//! Geometry of the light meter: intersection of rays with bodies, and the fraction of a disc that nearer bodies leave visible.
//!
//! In: the camera and the placement of a body. Out: weights, angles and fractions. Always: these values change continuously with position and direction.
//! Exceptions: `area_px`, `weighted_in_frame_fraction` and `entire_disc_weight` jump where an ellipse becomes an open outline ([`Outline::Open`]) or leaves the
//! frame.

use crate::ephemeris::angle_rad;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{Camera, Placement};
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3, FloatExt};
use std::f64::consts::{FRAC_PI_2, PI};

/// Number of decades by which a weight falls between the middle of the frame and its edge, so that a body that enters the frame gains weight gradually. The
/// weight is constant over the inner half of that distance.
const EDGE_DECADES: f64 = 5.0;

/// Weight of a position in the frame. `edge_fraction`: 0 in the middle of the frame, 1 on its edge.
pub(crate) fn frame_position_weight(edge_fraction: f64) -> f64 {
    10.0_f64.powf(-EDGE_DECADES * smoothstep(2.0 * edge_fraction - 1.0))
}

/// Share of the frame from which ground has its full [`least_weight_of_ground`], and the decades by which this is below 1: a twentieth. Ground that reaches
/// inner parts of the frame has more weight by its position alone, so nothing changes there.
const LEAST_WEIGHT_SHARE: f64 = 0.06;
const LEAST_WEIGHT_DECADES: f64 = 1.3;

/// Least weight of ground, relative to that in the middle of the frame, wherever it lies in the frame. `share`: the part of the frame that it fills. A planet's
/// ground along an edge of the frame lies in no inner part, however much of the edge it fills. With the weight of its position alone, ground in full sunlight
/// on a twelfth of the frame would be white by a factor of a thousand, in an image exposed for the dark sky above it. With no share the least weight is that of
/// the frame's edge, so that ground enters the frame gradually.
pub(crate) fn least_weight_of_ground(share: f64) -> f64 {
    10.0_f64.powf(-EDGE_DECADES.lerp(LEAST_WEIGHT_DECADES, smoothstep(share / LEAST_WEIGHT_SHARE)))
}

/// Where a ray passes a body, relative to its limb and ground; in the body's unit-sphere frame.
pub(crate) struct RayAndLimb {
    /// Angle between ray and limb in the unit-sphere frame; positive if the ray meets the body, negative if it misses it.
    pub inside_rad: f64,
    /// The point where the ray meets the ground; if it misses, the point of the ground that is nearest to it.
    pub point: DVec3,
}

/// Where a ray from the camera passes a body. `direction`: ICRF, of any length.
pub(crate) fn ray_and_limb(placement: &Placement, direction: DVec3) -> RayAndLimb {
    let origin = placement.camera_in_unit_sphere();
    let ray = placement.direction_in_unit_sphere(direction).normalize();
    // The ray's point nearest to the body's centre: its distance from the camera along the ray, and from the centre.
    let (along, off_centre) = (-origin.dot(ray), origin.cross(ray).length());
    let limb_rad = 1.0_f64.atan2(((origin.length() - 1.0) * (origin.length() + 1.0)).max(0.0).sqrt());
    let point = (origin + ray * (along - (1.0 - off_centre * off_centre).max(0.0).sqrt())).normalize();
    RayAndLimb { inside_rad: limb_rad - off_centre.atan2(along), point }
}

/// Angle between a direction (ICRF, of any length) and the nearest direction in the frame, radians: 0 in the frame, and up to pi behind the camera.
pub(crate) fn angle_from_frame_rad(camera: &Camera, direction: DVec3) -> f64 {
    if camera.clip(direction).is_some_and(|clip| clip.abs().max_element() <= 1.0) {
        return 0.0;
    }
    // The edges of the frame are arcs of great circles. The nearest direction is a corner, or where the perpendicular arc meets an edge.
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| camera.ray(DVec2::new(x, y)));
    let from_edge_rad = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        let normal = from.cross(to);
        let on_circle = direction.reject_from(normal);
        let is_on_edge = normal.dot(from.cross(on_circle)) > 0.0 && normal.dot(on_circle.cross(to)) > 0.0;
        // The other corner is that of the next edge.
        let nearest = if is_on_edge { on_circle } else { from };
        angle_rad(direction, nearest)
    };
    (0..corners.len()).map(from_edge_rad).fold(PI, f64::min)
}

/// Whether every ray of the frame misses the body's limb by at least half of `spacing`, the angle between the meter's rays, in radians. The distance from the
/// limb is [`RayAndLimb::inside_rad`], in the unit-sphere frame. A quick test: it may return false although this holds.
pub(crate) fn is_beside_frame(camera: &Camera, placement: &Placement, spacing: f64) -> bool {
    let radii_km = placement.radii_km;
    let radius_rad = (radii_km.max_element() / placement.centre_km.length()).min(1.0).asin();
    // The unit-sphere frame shrinks angles by at most the ratio of the semi-axes; the factor of two is a margin for large angles.
    let margin_rad = spacing * radii_km.max_element() / radii_km.min_element();
    angle_rad(placement.centre_km, camera.forward) - radius_rad - camera.corner_rad() > 2.0 * margin_rad
}

/// Area within a body's outline in pixels, not clipped to the frame. An open outline counts as the entire frame, a body beside the frame or behind the camera
/// as 0.
pub(crate) fn area_px(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    match placed.outline {
        Outline::Ellipse { area_px, .. } => area_px,
        Outline::Open => f64::from(camera.width) * f64::from(camera.height),
        Outline::Behind | Outline::Beside => 0.0,
    }
}

/// Fraction of the bounding box of a body's outline that is in the frame; 0 for an open outline.
fn in_frame_fraction(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    let Some((box_centre, size)) = bounding_box(camera, placed) else { return 0.0 };
    let inside = (DVec2::ONE.min(box_centre + 0.5 * size) - DVec2::NEG_ONE.max(box_centre - 0.5 * size)).max(DVec2::ZERO);
    (inside / size).element_product().min(1.0)
}

/// [`in_frame_fraction`] times [`outline_position_weight`]. 0 for an open outline: the caller then samples the ground in the frame, but counts the Sun as
/// entirely in the frame.
pub(crate) fn weighted_in_frame_fraction(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    in_frame_fraction(camera, placed) * outline_position_weight(camera, placed)
}

/// Number of decades by which the weight of the sum over an entire disc falls while the disc leaves the frame, or the field of view becomes narrower. The
/// weight falls by decades because a crescent outside the frame may be a million times as bright as the night side inside.
const CLIPPED_DECADES: f64 = 9.0;
/// Diameters of a disc between which this fall of the weight sets in: the light of a smaller disc is spread over a sprite.
const CLIPPED_FROM_PX: (f64, f64) = (4.0, 8.0);

/// Weight of the sum over a body's entire disc: 1 if the disc is in the frame, nearly 0 if only the part of its ground that is in the frame may be metered, as
/// in a narrow field of view.
pub(crate) fn entire_disc_weight(camera: &Camera, placed: &PlacedBody<'_>, diameter_px: f64) -> f64 {
    let outside = 1.0 - smoothstep(in_frame_fraction(camera, placed));
    10.0_f64.powf(-CLIPPED_DECADES * outside * smooth_rise(CLIPPED_FROM_PX, diameter_px))
}

/// Weight of the position of a body's outline in the frame: the weight of the point of its bounding box that is nearest to the frame's middle. 0 for an open
/// outline.
pub(crate) fn outline_position_weight(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    let Some((box_centre, size)) = bounding_box(camera, placed) else { return 0.0 };
    frame_position_weight((box_centre.abs() - 0.5 * size).max_element().clamp(0.0, 1.0))
}

/// Centre and size of the bounding box of a body's outline, clip coordinates; `None` for an open outline. Outlines narrower than two pixels count as two pixels
/// wide, as their light is spread over a sprite.
fn bounding_box(camera: &Camera, placed: &PlacedBody<'_>) -> Option<(DVec2, DVec2)> {
    let Outline::Ellipse { bounds, .. } = placed.outline else { return None };
    let size = DVec2::new(bounds.right - bounds.left, bounds.top - bounds.bottom).max(2.0 / camera.half_size_px());
    Some((0.5 * DVec2::new(bounds.right + bounds.left, bounds.top + bounds.bottom), size))
}

/// Number of decades by which the weight of a crescent falls after the crescent has set behind the limb.
const SETTING_DECADES: f64 = 9.0;

/// Upper limit of the angle below the limb over which the weight falls. A compromise: while the lit part is hidden but still has weight, the exposure is too
/// short for the night side. With an angle of 0, the exposure of the Moon from 12 radii would jump by 10.7 stops when the Sun sets.
const MAX_SETTING_RANGE_RAD: f64 = 2.5 * PI / 180.0;

/// Weight of the lit part of a sphere: 1 while some of it is in sight. A near viewer sees less than half of the sphere; after the lit part has set behind the
/// limb, the weight falls to nearly 0. The weight falls gradually because the light itself ends abruptly: a body without air has no twilight.
/// `distance_radii`: from the viewer to the sphere's centre.
pub(crate) fn lit_part_weight(phase_angle_rad: f64, distance_radii: f64) -> f64 {
    // Angles at the sphere's centre: from the sub-observer point to the limb, and from the limb to the lit part behind it.
    let limb_rad = distance_radii.max(1.0).recip().acos();
    let below_limb_rad = phase_angle_rad - FRAC_PI_2 - limb_rad;
    // At a phase angle of 180 degrees the lit part lies a right angle minus `limb_rad` behind the limb. For a far viewer this is little, so the weight has
    // fallen after 0.6 of this angle.
    let setting_range_rad = MAX_SETTING_RANGE_RAD.min(0.6 * (FRAC_PI_2 - limb_rad)).max(f64::MIN_POSITIVE);
    10.0_f64.powf(-SETTING_DECADES * smoothstep(below_limb_rad / setting_range_rad))
}

/// Area between a circle of radius 1 and a chord that spans twice this angle at the centre. `half_angle`: radians.
fn segment_area(half_angle: f64) -> f64 {
    // For small angles the difference loses its digits; the series has a relative error below 3e-10 there.
    if half_angle < 0.01 {
        return half_angle.powi(3) * (2.0 / 3.0 - 2.0 / 15.0 * half_angle * half_angle);
    }
    half_angle - half_angle.sin() * half_angle.cos()
}

/// Visible fraction of a uniform disc behind a round body, from the overlap of two circles in a plane. Angles are taken as lengths in this plane: the error is
/// at most 0.007 for discs with a radius of up to 0.1 radians, and at most 0.02 up to 0.3 radians. `separation_rad`: between the two centres.
pub(crate) fn visible_fraction_behind_circle(separation_rad: f64, body_radius_rad: f64, disc_radius_rad: f64) -> f64 {
    // In units of the disc's radius.
    let separation = separation_rad / disc_radius_rad;
    let body_radius = body_radius_rad / disc_radius_rad;
    // From the body's edge to the disc's centre; negative if the centre is covered.
    let from_edge = (separation_rad - body_radius_rad) / disc_radius_rad;
    if from_edge >= 1.0 {
        return 1.0;
    }
    if from_edge <= -1.0 {
        return 0.0;
    }
    if separation + body_radius <= 1.0 {
        return 1.0 - body_radius * body_radius;
    }
    // Distances of the two centres from the chord through the points where the circles cross. This form stays accurate for a large body.
    let disc_to_chord = (from_edge * (separation + body_radius) + 1.0) / (2.0 * separation);
    let body_to_chord = separation - disc_to_chord;
    let half_chord = ((1.0 - disc_to_chord) * (1.0 + disc_to_chord)).max(0.0).sqrt();
    let of_disc = segment_area(half_chord.atan2(disc_to_chord));
    let of_body = body_radius * body_radius * segment_area(half_chord.atan2(body_to_chord));
    (1.0 - (of_disc + of_body) / PI).clamp(0.0, 1.0)
}

/// The point of a body's limb in one direction from its centre.
struct LimbPoint {
    /// Angle at the camera between the body's centre and the point.
    angle_rad: f64,
    /// Cosine of the angle between the limb's normal and the direction away from the centre.
    normal_cosine: f64,
}

/// The point of the limb in the direction from the body's centre to a unit vector. Valid for a camera outside the body.
fn limb_towards(placement: &Placement, towards: DVec3) -> LimbPoint {
    let distance_km = placement.centre_km.length();
    let to_centre = placement.centre_km / distance_km;
    let perpendicular =
        (towards - to_centre * towards.dot(to_centre)).try_normalize().unwrap_or_else(|| to_centre.any_orthonormal_vector());
    // In the unit-sphere frame, the ray along axis + u side, with u the tangent of the angle, touches the limb if its squared distance from the centre is 1.
    let (axis, side) = (placement.direction_in_unit_sphere(to_centre), placement.direction_in_unit_sphere(perpendicular));
    let (axis_sq, axis_side, side_sq) = (axis.dot(axis), axis.dot(side), side.dot(side));
    let distance_radii = distance_km / placement.radii_km.x;
    let cross_sq = axis.cross(side).length_squared();
    // Solves the equation square_coefficient * u^2 - 2 axis_side u - axis_sq = 0. Close to the ground `square_coefficient` is small, of either sign.
    let square_coefficient = distance_radii * distance_radii * cross_sq - side_sq;
    let camera_radii = distance_radii * axis_sq.sqrt();
    let root = (cross_sq * (camera_radii - 1.0).max(0.0) * (camera_radii + 1.0)).sqrt();
    // Two forms of the same root. Neither subtracts numbers of similar size, and the first argument is never negative: the angle is between 0 and pi. With the
    // first form alone both arguments would be negative where `axis_side` and `square_coefficient` are, and the angle would point away from the body.
    let angle_rad = if axis_side > 0.0 { (axis_side + root).atan2(square_coefficient) } else { axis_sq.atan2(root - axis_side) };
    // The gradient of the squared distance is normal to the limb.
    let (sin, cos) = angle_rad.sin_cos();
    let camera = placement.camera_in_unit_sphere();
    let ray = placement.direction_in_unit_sphere(to_centre * cos + perpendicular * sin);
    let gradient = ray * (camera.length_squared() - 1.0) - camera * camera.dot(ray);
    let normal = placement.body_from_icrf.transpose() * (gradient * (placement.radii_km.x / placement.radii_km));
    let outwards = perpendicular * cos - to_centre * sin;
    LimbPoint { angle_rad, normal_cosine: normal.normalize_or_zero().dot(outwards).clamp(0.0, 1.0) }
}

/// Fraction of a disc that a body leaves visible. The disc has the angular radius `radius_rad` around the unit vector `towards`, and lies behind the body.
pub(crate) fn visible_fraction_behind_body(placement: &Placement, towards: DVec3, radius_rad: f64) -> f64 {
    let separation_rad = angle_rad(placement.centre_km, towards);
    let limb = limb_towards(placement, towards);
    // A flattened body's limb is tilted against the direction from its centre: the disc's distance from it is shorter, by the cosine of the tilt.
    let from_limb_rad = (separation_rad - limb.angle_rad) * limb.normal_cosine;
    visible_fraction_behind_circle(limb.angle_rad + from_limb_rad, limb.angle_rad, radius_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::DMat3;

    /// From 0.1 m to 10 km and far above the ground of round and flattened bodies, at all latitudes and azimuths: the angle of the limb is that at which rays
    /// begin to miss the body, found by bisection. The bodies are turned against the sky.
    #[test]
    fn the_limb_is_where_rays_begin_to_miss_the_body() {
        // Whether a ray from the camera meets the ellipsoid; km, body axes.
        let meets = |camera: DVec3, ray: DVec3, radii: DVec3, height_term: f64| {
            let (p, d) = (camera / radii, ray / radii);
            let along = p.dot(d);
            along < 0.0 && along * along > d.dot(d) * height_term
        };
        let bodies = [
            DVec3::new(6378.1366, 6378.1366, 6356.7519),
            DVec3::splat(1737.4),
            DVec3::new(3396.19, 3396.19, 3376.2),
            DVec3::new(60268.0, 60268.0, 54364.0),
            DVec3::new(13.0, 11.4, 9.1),
        ];
        let body_from_icrf = DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), 1.1);
        for (radii_km, height_km) in
            bodies.iter().flat_map(|r| [1e-4, 5e-4, 1.7e-3, 4e-3, 5e-3, 0.01, 0.1, 1.0, 10.0, 1e5].map(|h| (*r, h)))
        {
            for latitude_deg in [-89.0_f64, -60.0, -43.37, -10.0, 0.0, 1.0, 30.0, 59.33, 80.0] {
                let (sin, cos) = latitude_deg.to_radians().sin_cos();
                let on_sphere = DVec3::new(cos * 0.6, cos * 0.8, sin);
                let ground = on_sphere * radii_km;
                let up = (on_sphere / radii_km).normalize();
                let camera = ground + up * height_km;
                // |camera|^2 - 1 in the unit-sphere frame, without the loss of digits.
                let step = up * height_km / radii_km;
                let height_term = step.dot(2.0 * on_sphere + step);
                let placement = Placement { centre_km: body_from_icrf.transpose() * -camera, body_from_icrf, radii_km };
                let to_centre = -camera.normalize();
                let side = to_centre.any_orthonormal_vector();
                for azimuth in (0..24).map(|k| f64::from(k) * PI / 12.0) {
                    let perpendicular = side * azimuth.cos() + to_centre.cross(side) * azimuth.sin();
                    let ray = |angle: f64| to_centre * angle.cos() + perpendicular * angle.sin();
                    let (mut inside, mut outside) = (0.0, PI);
                    for _ in 0..60 {
                        let middle = 0.5 * (inside + outside);
                        if meets(camera, ray(middle), radii_km, height_term) { inside = middle } else { outside = middle }
                    }
                    // The direction lies anywhere on that side: here a little below the limb.
                    let found = limb_towards(&placement, body_from_icrf.transpose() * ray(0.98 * inside)).angle_rad;
                    // Rounding of the camera's position, 1e-16, over the height, 1.7e-9 radii or more, times the dip.
                    assert!((found - inside).abs() < 1e-9, "{radii_km}, {height_km} km, {latitude_deg}, {azimuth}: {found}, not {inside}");
                }
            }
        }
    }

    /// The angle from the frame against the smallest angle to directions on a fine grid of the frame, all over the sky, also behind the camera. Negative control:
    /// the nearest place in the image is not the nearest direction.
    #[test]
    fn the_angle_from_the_frame_is_that_of_the_nearest_direction() {
        const STEPS: i32 = 100;
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 100.0, 160, 80);
        let clip = |k: i32| f64::from(2 * k - STEPS) / f64::from(STEPS);
        let rays: Vec<DVec3> =
            (0..(STEPS + 1).pow(2)).map(|k| camera.ray(DVec2::new(clip(k % (STEPS + 1)), clip(k / (STEPS + 1))))).collect();
        let (mut behind, mut largest_error_of_clamped) = (0, 0.0_f64);
        for k in 0..200 {
            let z = (f64::from(k) + 0.5) / 100.0 - 1.0;
            let (sin, cos) = (f64::from(k) * crate::units::GOLDEN_ANGLE_RAD).sin_cos();
            let direction = DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z);
            let expected = rays.iter().map(|ray| angle_rad(direction, *ray)).fold(PI, f64::min);
            let found = angle_from_frame_rad(&camera, 3.0 * direction);
            // The grid's steps are at most 0.048 radians.
            assert!(found <= expected + 1e-9 && expected - found < 0.03, "{direction}: {found}, not {expected}");
            match camera.clip(direction) {
                Some(clip) => {
                    let clamped = camera.ray(clip.clamp(DVec2::NEG_ONE, DVec2::ONE));
                    largest_error_of_clamped = largest_error_of_clamped.max(angle_rad(direction, clamped) - found);
                }
                None => {
                    behind += 1;
                    assert!(found > 0.3, "{direction}: {found}");
                }
            }
        }
        assert!(behind > 80 && largest_error_of_clamped > 0.1, "{behind}, {largest_error_of_clamped}");
    }

    /// The weight of ground along the edge of the frame grows from that of the edge, always in small steps.
    #[test]
    fn ground_along_the_edge_gains_weight_with_its_share() {
        let decades = |share: f64| least_weight_of_ground(share).log10();
        assert!((decades(0.0) - frame_position_weight(1.0).log10()).abs() < 1e-9 && (decades(0.06) + 1.3).abs() < 1e-9);
        // The steepest step: 1.5 times the mean slope, 3.7 decades over 0.06, gives 0.09 decades in 0.001.
        let steps = (0..100).map(|k| decades(0.001 * f64::from(k + 1)) - decades(0.001 * f64::from(k)));
        assert!(steps.clone().all(|step| (0.0..0.1).contains(&step)) && steps.sum::<f64>() > 3.6, "{}", decades(0.1));
    }

    /// A crescent in sight has all of its weight, one that has set behind the limb of a near viewer has almost none.
    #[test]
    fn a_crescent_behind_the_limb_has_no_weight() {
        let weight = |phase_deg: f64, distance_radii: f64| lit_part_weight(phase_deg.to_radians(), distance_radii);
        for (phase_deg, distance_radii) in [(0.0, 3.0), (90.0, 3.0), (160.5, 3.0), (176.0, 221.0), (179.7, 221.0), (179.9, 1e9)] {
            assert_eq!(weight(phase_deg, distance_radii), 1.0, "phase {phase_deg}, {distance_radii} radii");
        }
        // The limb is 70.5 degrees from the sub-observer point at 3 radii, 85.2 degrees at 12 radii and 89.74 degrees at 221 radii.
        for (phase_deg, distance_radii) in [(163.1, 3.0), (177.8, 12.0), (179.95, 221.0), (180.0, 1e9)] {
            assert!(weight(phase_deg, distance_radii) < 1.1e-9, "phase {phase_deg}, {distance_radii} radii");
        }
        // The steepest step: 1.5 times the mean slope of the smoothstep, 9 decades over 2.5 degrees, gives 0.108 decades in 0.02 degrees.
        let decades = (0..200).map(|k| weight(175.0 + 0.02 * f64::from(k), 12.0).log10()).collect::<Vec<f64>>();
        assert!(decades.windows(2).all(|w| w[1] <= w[0] && w[0] - w[1] < 0.15), "{decades:?}");
    }

    /// Bodies around frames of all sizes, round and elongated: one that counts as beside the frame blocks no ray. Most of those that block none are found.
    #[test]
    fn a_body_beside_the_frame_blocks_no_ray() {
        let mut random = Random::new(11);
        let (mut beside, mut missed) = (0, 0);
        for k in 0..4000 {
            let fov_deg = 10.0_f64.powf(random.between(-3.0, 2.0));
            let camera = Camera::looking(DVec3::ZERO, random.direction(), random.direction(), fov_deg, 300, 200);
            let spacing = (2.0 * camera.tan_half_fov).length() / 20.0;
            // Within some widths of the frame, or anywhere.
            let spread = if k % 2 == 0 { 6.0 * camera.tan_half_fov.y } else { 2.0 };
            let towards = (camera.forward + random.direction() * (spread * random.between(0.0, 1.0))).normalize();
            let radii_km = DVec3::new(1.0, random.between(0.6, 1.0), random.between(0.6, 1.0));
            let distance_km = 1.0 + 10.0_f64.powf(random.between(-2.0, 5.0));
            let body_from_icrf = DMat3::from_axis_angle(random.direction(), random.between(0.0, 3.0));
            let placement = Placement { centre_km: towards * distance_km, body_from_icrf, radii_km };
            let clip = |n: u32| DVec2::new(f64::from(n % 9), f64::from(n / 9)) / 4.0 - 1.0;
            // The condition under which `MeteredFrame::ray_visibility` is less than 1.
            let blocks = (0..81).any(|n| 0.5 + ray_and_limb(&placement, camera.ray(clip(n))).inside_rad / spacing > 0.0);
            let is_beside = is_beside_frame(&camera, &placement, spacing);
            assert!(!(is_beside && blocks), "{fov_deg} degrees, {placement:?}");
            beside += u32::from(is_beside);
            missed += u32::from(!is_beside && !blocks);
        }
        assert!(beside > 1000 && missed < beside, "{beside} beside the frame, {missed} others block nothing");
    }

    /// Visible fraction of a disc on the celestial sphere, by rings of equal area around its centre.
    fn fraction_on_sphere(separation: f64, body: f64, disc: f64) -> f64 {
        const RINGS: u32 = 2000;
        let covered_of_ring = |k: u32| {
            let radius = (1.0 - (f64::from(k) + 0.5) / f64::from(RINGS) * (1.0 - disc.cos())).acos();
            let cosine = (body.cos() - radius.cos() * separation.cos()) / (radius.sin() * separation.sin()).max(1e-300);
            cosine.clamp(-1.0, 1.0).acos() / PI
        };
        1.0 - (0..RINGS).map(covered_of_ring).sum::<f64>() / f64::from(RINGS)
    }

    /// Visible fraction of a disc of radius 1 in a plane, by chords parallel to the direction of the body.
    fn fraction_in_plane(separation: f64, body: f64) -> f64 {
        const CHORDS: u32 = 4000;
        let covered_of_chord = |k: u32| {
            // Chords at equal steps of the angle, so that their ends converge.
            let angle = PI * ((f64::from(k) + 0.5) / f64::from(CHORDS) - 0.5);
            let (height, half_length) = (angle.sin(), angle.cos());
            let half_body = (body * body - height * height).max(0.0).sqrt();
            // `separation - half_body`, in a form that stays accurate for a large body.
            let near_end = if half_body > 0.0 { separation - body + height * height / (body + half_body) } else { separation };
            let covered = half_length.min(separation + half_body) - near_end.max(-half_length);
            covered.max(0.0) * half_length
        };
        1.0 - (0..CHORDS).map(covered_of_chord).sum::<f64>() / f64::from(CHORDS)
    }

    /// Separations from concentric, or one disc's radius inside the edge of a larger body, to just beyond contact.
    fn separations(body: f64, disc: f64, count: u32) -> impl Iterator<Item = f64> {
        let first = (body - 1.02 * disc).max(0.0);
        (0..=count).map(move |k| first + (body + 1.02 * disc - first) * f64::from(k) / f64::from(count))
    }

    #[test]
    fn the_visible_fraction_is_the_overlap_of_two_circles() {
        for body in [0.0, 1e-3, 0.02, 0.1, 0.5, 0.9, 1.0, 1.1, 2.0, 10.0, 1e3, 1e6, 1e9] {
            for separation in separations(body, 1.0, 100) {
                let (found, expected) = (visible_fraction_behind_circle(separation, body, 1.0), fraction_in_plane(separation, body));
                assert!((found - expected).abs() < 2e-4, "{body} {separation}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn the_error_of_a_plane_sky_is_within_the_stated_bounds() {
        let worst = |discs: &[f64]| {
            let mut worst = 0.0_f64;
            for (disc, body) in discs.iter().flat_map(|disc| [0.01, 0.05, 0.1, 0.3, 0.6, 1.0, 1.5].map(|body| (*disc, body))) {
                for separation in separations(body, disc, 60) {
                    let error = visible_fraction_behind_circle(separation, body, disc) - fraction_on_sphere(separation, body, disc);
                    worst = worst.max(error.abs());
                }
            }
            worst
        };
        let (of_small, of_large) = (worst(&[0.0047, 0.02, 0.05, 0.1]), worst(&[0.3]));
        assert!(of_small < 0.007 && of_small > 0.004, "{of_small}");
        assert!(of_large < 0.02 && of_large > 0.01, "{of_large}");
    }

    /// Largest change of a function of separation and body radius, over steps of both, relative to the largest change that the overlap allows. The overlap
    /// changes by at most twice the change of the radius and 2 / pi times that of the separation.
    fn largest_jump(fraction: impl Fn(f64, f64) -> f64) -> f64 {
        const STEP: f64 = 1e-3;
        let mut largest = 0.0_f64;
        for centre in [0.05, 0.5, 1.0, 2.0, 4.0, 100.0] {
            for body in (-10..10).map(|k| centre + STEP * f64::from(k)) {
                for separation in separations(body, 1.0, 500) {
                    let here = fraction(separation, body);
                    let by_radius = (fraction(separation, body + STEP) - here).abs() / (2.0 * STEP);
                    let by_separation = (fraction(separation + STEP, body) - here).abs() / (2.0 / PI * STEP);
                    largest = largest.max(by_radius).max(by_separation);
                }
            }
        }
        largest
    }

    #[test]
    fn the_visible_fraction_changes_continuously() {
        let jump = largest_jump(|separation, body| visible_fraction_behind_circle(separation, body, 1.0));
        assert!(jump < 1.001, "{jump}");
        // Negative control: a linear ramp for smaller bodies beside a straight edge for larger ones jumps at equal radii, by more than ten times what the
        // overlap allows.
        let in_two_parts = |separation: f64, body: f64| {
            if body < 1.0 {
                return 1.0 - ((body + 1.0 - separation) / (2.0 * body)).clamp(0.0, 1.0) * body * body;
            }
            let edge = (separation - body).clamp(-1.0, 1.0);
            1.0 - (edge.acos() - edge * (1.0 - edge * edge).sqrt()) / PI
        };
        let jump = largest_jump(in_two_parts);
        assert!(jump > 10.0, "{jump}");
    }
}
