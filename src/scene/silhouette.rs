//! The outline of an ellipsoid in the picture: the conic that its tangent cone cuts from the image plane, in f64.
//!
//! A view ray of homogeneous image place v meets the body where vᵀQv >= 0. With c the camera and r, u the image axes in the
//! unit-sphere frame, and the image place counted from the projected centre in units of the body's radius, Q has the closed form
//! of [`Outline::of`]; nothing large cancels, so a kilometre-sized moon at 100 au keeps its shape.

use super::camera::{Camera, ClipRect, Placement};
use glam::{DMat2, DVec2};

/// What of the picture a body's outline takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// Wholly before the camera: the ellipse's bounding box and its area in pixels, both untrimmed.
    Ellipse {
        bounds: ClipRect,
        area_px: f64,
    },
    /// The tangent cone reaches behind the camera: the outline is open, any pixel may show the body.
    Open,
    Behind,
}

/// Pixels added on each side of a bounding box: the limb's soft edge takes half a pixel, and a quad reaches one further.
pub const PADDING_PX: f64 = 1.5;

impl Outline {
    /// `camera` must be outside the body.
    pub fn of(camera: &Camera, place: &Placement) -> Self {
        let depth_km = place.centre_km.dot(camera.forward);
        let c = place.camera_in_unit_sphere();
        let (r, u) = (place.direction_in_unit_sphere(camera.right), place.direction_in_unit_sphere(camera.up));
        let (n1, n2) = (c.cross(r), c.cross(u));
        // Minus the upper block of Q: positive definite exactly when the outline is an ellipse.
        let block = [n1.dot(n1) - r.dot(r), n1.dot(n2) - r.dot(u), n2.dot(n2) - u.dot(u)];
        let determinant = block[0] * block[2] - block[1] * block[1];
        let scale = block[0].abs().max(block[2].abs());
        if block[0] <= 0.0 || block[2] <= 0.0 || determinant <= 1e-12 * scale * scale {
            return Self::Open;
        }
        if depth_km <= 0.0 {
            return Self::Behind;
        }
        let inverse = DMat2::from_cols(DVec2::new(block[2], -block[1]), DVec2::new(-block[1], block[0])) * (1.0 / determinant);
        let linear = -DVec2::new(r.dot(c), u.dot(c));
        let centre = inverse * linear;
        let level = c.dot(c) + linear.dot(centre);
        // From body radii at the centre's depth to clip units.
        let clip_per_radius = place.radii_km.x / (depth_km * camera.tan_half_fov);
        let Some(origin) = camera.clip(place.centre_km) else { return Self::Behind };
        let middle = origin + centre * clip_per_radius;
        let half = DVec2::new((level * inverse.x_axis.x).sqrt(), (level * inverse.y_axis.y).sqrt()) * clip_per_radius;
        let px = clip_per_radius * camera.half_size();
        Self::Ellipse {
            bounds: ClipRect { left: middle.x - half.x, top: middle.y + half.y, right: middle.x + half.x, bottom: middle.y - half.y },
            area_px: std::f64::consts::PI * level * inverse.determinant().sqrt() * px.x * px.y,
        }
    }

    /// The padded box trimmed to the viewport; `None` where nothing of the body can be in the picture.
    pub fn rect(&self, camera: &Camera) -> Option<ClipRect> {
        match *self {
            Self::Behind => None,
            Self::Open => Some(ClipRect::VIEWPORT),
            Self::Ellipse { bounds, .. } => {
                let pad = DVec2::splat(PADDING_PX) / camera.half_size();
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
