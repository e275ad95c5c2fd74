//! Geometry of the light meter: intersection of rays with bodies, and the fraction of a disc that nearer bodies leave visible.
//!
//! Always: weights of positions, intersections and visible fractions change continuously with position and direction. `area_px` and
//! `weighted_in_frame_fraction` do so while an outline remains an ellipse, and jump where it opens or leaves the frame.

use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{Camera, Placement};
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Number of decades by which weights fall between half-way to the edge and the edge of the frame, so that a body that enters the frame gains weight
/// gradually.
const EDGE_DECADES: f64 = 5.0;

/// Weight of a position in the frame. `edge_fraction`: 0 in the middle of the frame, 1 on its edge.
pub(crate) fn frame_position_weight(edge_fraction: f64) -> f64 {
    10.0_f64.powf(-EDGE_DECADES * smoothstep(2.0 * edge_fraction - 1.0))
}

/// Result of intersecting a ray with a body, in the body's unit-sphere frame.
pub(crate) struct RayHit {
    /// Angle from the limb inwards to the ray, radians; negative if the ray misses the body.
    pub inside_rad: f64,
    /// The point where the ray meets the ground; if it misses, the point of the ground that is nearest to it.
    pub point: DVec3,
}

pub(crate) fn intersect(placement: &Placement, direction: DVec3) -> RayHit {
    let origin = placement.camera_in_unit_sphere();
    let ray = placement.direction_in_unit_sphere(direction).normalize();
    let (along, cross) = (-origin.dot(ray), origin.cross(ray).length());
    let limb_rad = 1.0_f64.atan2(((origin.length() - 1.0) * (origin.length() + 1.0)).max(0.0).sqrt());
    let point = (origin + ray * (along - (1.0 - cross * cross).max(0.0).sqrt())).normalize();
    RayHit { inside_rad: limb_rad - cross.atan2(along), point }
}

/// Area of a body's outline in pixels, not clipped to the frame. An open outline counts as the entire frame, a body beside or behind it as 0.
pub(crate) fn area_px(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    match placed.outline {
        Outline::Ellipse { area_px, .. } => area_px,
        Outline::Open => f64::from(camera.width) * f64::from(camera.height),
        Outline::Behind | Outline::Beside => 0.0,
    }
}

/// Approximate fraction of a body's outline that is in the frame, from its bounding box, times the weight of its position.
pub(crate) fn weighted_in_frame_fraction(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    let Outline::Ellipse { bounds, .. } = placed.outline else { return 0.0 };
    let size = DVec2::new(bounds.right - bounds.left, bounds.top - bounds.bottom);
    // A point's sprite is two pixels wide.
    let size = size.max(2.0 / camera.half_size());
    let box_centre = 0.5 * DVec2::new(bounds.right + bounds.left, bounds.top + bounds.bottom);
    let inside = (DVec2::ONE.min(box_centre + 0.5 * size) - DVec2::NEG_ONE.max(box_centre - 0.5 * size)).max(DVec2::ZERO);
    // The weight is that of the part of the outline nearest to the frame's middle.
    let edge_fraction = (box_centre.abs() - 0.5 * size).max_element().clamp(0.0, 1.0);
    (inside / size).element_product().min(1.0) * frame_position_weight(edge_fraction)
}

/// Visible fraction of a uniform disc behind a round body, from angles in radians. A smaller body covers the disc by a linear ramp; a larger body covers it by
/// a straight edge. The error is at most 0.03 if the body is larger than four times the disc or smaller than half of it, and at most 0.13 in between.
pub(crate) fn disc_fraction_behind_circle(separation_rad: f64, body_radius_rad: f64, disc_radius_rad: f64) -> f64 {
    if body_radius_rad < disc_radius_rad {
        let covered = ((body_radius_rad + disc_radius_rad - separation_rad) / (2.0 * body_radius_rad)).clamp(0.0, 1.0);
        return 1.0 - covered * (body_radius_rad / disc_radius_rad).powi(2);
    }
    let edge = ((separation_rad - body_radius_rad) / disc_radius_rad).clamp(-1.0, 1.0);
    1.0 - (edge.acos() - edge * (1.0 - edge * edge).sqrt()) / PI
}

/// Angle from the body's centre to its limb in the direction of a unit vector, and the cosine between the limb's normal at that point and the direction away
/// from the centre. Valid outside the body.
pub(crate) fn limb_towards(body: &Placement, towards: DVec3) -> (f64, f64) {
    let distance_km = body.centre_km.length();
    let to_centre = body.centre_km / distance_km;
    let perpendicular =
        (towards - to_centre * towards.dot(to_centre)).try_normalize().unwrap_or_else(|| to_centre.any_orthonormal_vector());
    // In the unit-sphere frame the ray a + u b, with u the tangent of the angle, touches the limb if its squared distance from the centre is 1.
    let (a, b) = (body.direction_in_unit_sphere(to_centre), body.direction_in_unit_sphere(perpendicular));
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let distance_radii = distance_km / body.radii_km.x;
    // Solves the equation quadratic * u^2 - 2 ab u - aa = 0.
    let quadratic = distance_radii * distance_radii * a.cross(b).length_squared() - bb;
    let angle = (ab + (ab * ab + quadratic * aa).max(0.0).sqrt()).atan2(quadratic);
    // The gradient of the squared distance is normal to the limb.
    let (sin, cos) = angle.sin_cos();
    let (c, d) = (body.camera_in_unit_sphere(), body.direction_in_unit_sphere(to_centre * cos + perpendicular * sin));
    let limb_normal =
        body.body_from_icrf.transpose() * ((d * (c.length_squared() - 1.0) - c * c.dot(d)) * (body.radii_km.x / body.radii_km));
    (angle, limb_normal.normalize_or_zero().dot(perpendicular * cos - to_centre * sin).clamp(0.0, 1.0))
}

/// Fraction of a disc that a body leaves visible. The disc has the angular radius `radius_rad` around the unit vector `towards`, and lies behind the body.
pub(crate) fn visible_disc_fraction(body: &Placement, towards: DVec3, radius_rad: f64) -> f64 {
    let separation_rad = crate::ephemeris::angle_rad(body.centre_km, towards);
    let (limb_rad, normal_cosine) = limb_towards(body, towards);
    disc_fraction_behind_circle(limb_rad + (separation_rad - limb_rad) * normal_cosine, limb_rad, radius_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Visible fraction of a disc of radius 1 behind another disc, from the closed form of the overlap of two circles.
    fn exact_visible_fraction(separation: f64, body: f64) -> f64 {
        if separation >= 1.0 + body {
            return 1.0;
        }
        if separation <= (1.0 - body).abs() {
            return if body >= 1.0 { 0.0 } else { 1.0 - body * body };
        }
        // Half the angles that the common chord of both circles spans at each centre.
        let of_sun = ((separation * separation + 1.0 - body * body) / (2.0 * separation)).acos();
        let of_body = ((separation * separation + body * body - 1.0) / (2.0 * separation * body)).acos();
        let segment = |angle: f64| angle - angle.sin() * angle.cos();
        1.0 - (segment(of_sun) + body * body * segment(of_body)) / PI
    }

    #[test]
    fn the_visible_fraction_is_within_the_stated_bounds() {
        let worst = |bodies: &[f64]| {
            let error = |body: f64| {
                (0..=400)
                    .map(move |k| (1.0 + body) * f64::from(k) / 380.0)
                    .map(move |s| (disc_fraction_behind_circle(s, body, 1.0) - exact_visible_fraction(s, body)).abs())
            };
            bodies.iter().flat_map(|b| error(*b)).fold(0.0, f64::max)
        };
        let (of_unequal_sizes, of_similar_sizes) =
            (worst(&[0.02, 0.1, 0.3, 0.5, 4.0, 10.0, 100.0]), worst(&[0.6, 0.9, 1.0, 1.1, 1.5, 2.0, 3.0]));
        assert!(of_unequal_sizes < 0.03, "{of_unequal_sizes}");
        assert!(of_similar_sizes < 0.13 && of_similar_sizes > 0.03, "{of_similar_sizes}");
    }
}
