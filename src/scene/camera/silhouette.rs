//! The outline of an ellipsoid in the image: the conic section of its tangent cone with the image plane, in f64.
//!
//! In: a camera and a body's placement. Out: an [`Outline`]. Let c be the camera and r and u the image axes, all in the unit-sphere frame. The view ray
//! through the image position (x, y), relative to the projected centre in units of the body's radius, has the direction d = x r + y u - c. It meets the body if
//! |d|² - |c x d|² >= 0. The left side is a quadratic form in v = (x, y, 1), vᵀQv; [`Outline::of`] has Q in closed form. No large numbers cancel, so the
//! outline of a kilometre-sized moon at 100 au is still accurate.

use crate::scene::camera::{Camera, ClipRect, Placement};
use glam::{DMat2, DVec2, DVec3};

/// The outline of a body in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// Entirely in front of the camera: the ellipse's bounding box in clip coordinates, and its area in pixels; neither is clipped to the frame.
    Ellipse { bounds: ClipRect, area_px: f64 },
    /// The tangent cone extends behind the camera and into the frame: the outline is open, and any pixel may show the body.
    Open,
    /// The tangent cone extends behind the camera, but no view ray of the frame is inside the cone.
    Beside,
    /// The body is behind the camera.
    Behind,
}

/// Pixels added on each side of a bounding box: half a pixel for the limb's antialiased edge, and one pixel because shaders run on quads of 2x2 pixels.
pub const PADDING_PX: f64 = 1.5;

/// Whether a view ray of the padded frame meets the body, whose centre may be behind the camera. In the unit-sphere frame the tangent cone is circular, so only
/// the frame's ray nearest to the cone's axis must be tested: the axis itself, or a ray on the frame's edge.
fn meets_frame(camera: &Camera, placement: &Placement) -> bool {
    // For a very flat ellipsoid, such as a ring's disc, rounding errors make the test meaningless: assume that the cone meets the frame.
    if placement.radii_km.min_element() < 1e-3 * placement.radii_km.max_element() {
        return true;
    }
    let c = placement.camera_in_unit_sphere();
    let distance = c.length();
    let axis = -c / distance;
    let padded_edge = DVec2::ONE + PADDING_PX / camera.half_size_px();
    if camera.clip(placement.centre_km).is_some_and(|p| p.abs().cmple(padded_edge).all()) {
        return true;
    }
    let ray = |x: f64, y: f64| placement.direction_in_unit_sphere(camera.ray(DVec2::new(x, y) * padded_edge));
    let corners = [ray(-1.0, -1.0), ray(1.0, -1.0), ray(1.0, 1.0), ray(-1.0, 1.0)];
    let largest_cosine = (0..4).map(|k| largest_cosine_on_segment(axis, corners[k], corners[(k + 1) % 4])).fold(-1.0, f64::max);
    // The right side is the cosine of the cone's half angle.
    largest_cosine >= ((distance - 1.0) * (distance + 1.0)).sqrt() / distance
}

/// The largest cosine of the angle between a unit vector and any vector on the segment from `from` to `to`.
fn largest_cosine_on_segment(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let step = to - from;
    let (a, b) = (axis.dot(from), axis.dot(step));
    // Where the derivative of the cosine along the segment is zero.
    let stationary = (b * from.length_squared() - a * from.dot(step)) / (a * step.length_squared() - b * from.dot(step));
    let cosine = |t: f64| axis.dot((from + step * t).normalize());
    let at_stationary = if (0.0..=1.0).contains(&stationary) { cosine(stationary) } else { -1.0 };
    at_stationary.max(cosine(0.0)).max(cosine(1.0))
}

impl Outline {
    /// The outline of a body. The camera must be outside the body.
    pub fn of(camera: &Camera, placement: &Placement) -> Self {
        let depth_km = placement.centre_km.dot(camera.forward);
        let c = placement.camera_in_unit_sphere();
        let (r, u) = (placement.direction_in_unit_sphere(camera.right), placement.direction_in_unit_sphere(camera.up));
        let (c_cross_r, c_cross_u) = (c.cross(r), c.cross(u));
        // Entries 11, 12 and 22 of the negated upper-left 2x2 block of Q; the block is positive definite exactly if the outline is an ellipse. A determinant up
        // to 1e-12 times the square of the larger diagonal entry is rounding error and counts as 0.
        let block = [c_cross_r.dot(c_cross_r) - r.dot(r), c_cross_r.dot(c_cross_u) - r.dot(u), c_cross_u.dot(c_cross_u) - u.dot(u)];
        let determinant = block[0] * block[2] - block[1] * block[1];
        let scale = block[0].abs().max(block[2].abs());
        if block[0] <= 0.0 || block[2] <= 0.0 || determinant <= 1e-12 * scale * scale {
            return if meets_frame(camera, placement) { Self::Open } else { Self::Beside };
        }
        if depth_km <= 0.0 {
            return Self::Behind;
        }
        // With p = (x, y), the form is -pᵀ block p + 2 linear · p + |c|². It is largest at the ellipse's centre.
        let inverse = DMat2::from_cols(DVec2::new(block[2], -block[1]), DVec2::new(-block[1], block[0])) * (1.0 / determinant);
        let linear = -DVec2::new(r.dot(c), u.dot(c));
        let ellipse_centre = inverse * linear;
        let form_at_centre = c.dot(c) + linear.dot(ellipse_centre);
        // Converts body radii at the centre's depth to clip units.
        let clip_per_radius = placement.radii_km.x / (depth_km * camera.tan_half_fov);
        let Some(body_centre_in_clip) = camera.clip(placement.centre_km) else { return Self::Behind };
        let middle = body_centre_in_clip + ellipse_centre * clip_per_radius;
        let half = DVec2::new((form_at_centre * inverse.x_axis.x).sqrt(), (form_at_centre * inverse.y_axis.y).sqrt()) * clip_per_radius;
        let px_per_radius = clip_per_radius * camera.half_size_px();
        Self::Ellipse {
            bounds: ClipRect { left: middle.x - half.x, top: middle.y + half.y, right: middle.x + half.x, bottom: middle.y - half.y },
            area_px: std::f64::consts::PI * form_at_centre * inverse.determinant().sqrt() * px_per_radius.x * px_per_radius.y,
        }
    }

    /// The padded bounding box clipped to the viewport; `None` if the body cannot be in the image.
    pub fn rect(&self, camera: &Camera) -> Option<ClipRect> {
        match *self {
            Self::Behind | Self::Beside => None,
            Self::Open => Some(ClipRect::VIEWPORT),
            Self::Ellipse { bounds, .. } => {
                let pad = DVec2::splat(PADDING_PX) / camera.half_size_px();
                let rect = ClipRect {
                    left: (bounds.left - pad.x).max(-1.0),
                    top: (bounds.top + pad.y).min(1.0),
                    right: (bounds.right + pad.x).min(1.0),
                    bottom: (bounds.bottom - pad.y).max(-1.0),
                };
                (rect.left < rect.right && rect.bottom < rect.top).then_some(rect)
            }
        }
    }
}
