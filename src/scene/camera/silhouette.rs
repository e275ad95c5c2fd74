//! The outline of an ellipsoid in the image: the conic section of its tangent cone with the image plane, in f64.
//!
//! In: a camera and a body's placement. Out: an [`Outline`]. The image plane is put through the body's centre; x (right) and y (up) are measured from this
//! centre in equatorial radii. In the unit-sphere frame, let c be the camera, and r and u the steps of x and y. The view ray through (x, y) has the direction
//! d = x r + y u - c. Its line meets the body if |d|² - |c × d|² >= 0. The left side is a quadratic form vᵀQv of v = (x, y, 1). [`Outline::of`] computes Q from
//! products of c, r and u. No large numbers cancel, so the outline of a kilometre-sized moon at 100 au is still accurate.

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
    /// The entire body is behind the camera.
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

/// The largest cosine of the angle between the unit vector `axis` and any vector that ends on the segment from `from` to `to`.
fn largest_cosine_on_segment(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let step = to - from;
    let (a, b) = (axis.dot(from), axis.dot(step));
    // The t at which the derivative of the cosine (a + b t) / |from + t step| is zero.
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
        // The negated upper-left 2x2 block of Q is B = [xx xy; xy yy]. The outline is an ellipse exactly if B is positive definite. A determinant up to 1e-12
        // times the square of the larger diagonal entry is rounding error and counts as 0.
        let xx = c_cross_r.dot(c_cross_r) - r.dot(r);
        let xy = c_cross_r.dot(c_cross_u) - r.dot(u);
        let yy = c_cross_u.dot(c_cross_u) - u.dot(u);
        let determinant = xx * yy - xy * xy;
        let scale = xx.abs().max(yy.abs());
        if xx <= 0.0 || yy <= 0.0 || determinant <= 1e-12 * scale * scale {
            return if meets_frame(camera, placement) { Self::Open } else { Self::Beside };
        }
        if depth_km <= 0.0 {
            return Self::Behind;
        }
        // With p = (x, y), the form is -pᵀ B p + 2 linear · p + |c|². It is largest at the ellipse's centre. Relative to this centre, the ellipse is
        // pᵀ B p <= form_at_centre; its half extents squared are form_at_centre times the diagonal of B's inverse, its area is pi form_at_centre / sqrt(det B).
        let inverse = DMat2::from_cols(DVec2::new(yy, -xy), DVec2::new(-xy, xx)) * (1.0 / determinant);
        let linear = -DVec2::new(r.dot(c), u.dot(c));
        let ellipse_centre = inverse * linear;
        let form_at_centre = c.dot(c) + linear.dot(ellipse_centre);
        // Converts equatorial radii at the centre's depth to clip units.
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

    /// The padded bounding box clipped to the frame; `None` if the body cannot be in the frame.
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
