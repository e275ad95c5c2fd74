//! The camera, and the only place in `scene` where f64 is narrowed to f32.
//!
//! In: the camera's position and axes (ICRF, kilometres, f64) and a body's centre relative to it. Out: screen positions, and the view rays of a draw as affine
//! functions of the position in its rectangle ([`ViewRays`]), whose f32 values are of order one at any distance because the camera is subtracted in f64.
//! Always: in clip coordinates, x points right and y up, each from -1 to 1 over the viewport; in pixels, x points right and y down, and centres are at
//! half-integers. Not here: where the camera is (`viewpoint`).

pub mod geometry;
pub mod silhouette;
pub mod sphere;
pub mod viewpoint;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, Vec4};

/// View depth in km that maps to reversed depth 1: surfaces nearer than this (10 cm) are clipped.
pub const NEAR_DEPTH_KM: f64 = 1e-4;

/// Largest number of Newton's steps for the camera's height. Far away each step increases `t` by half: 100 au from the smallest body takes some 60.
const MAX_HEIGHT_STEPS: u32 = 100;

/// The directions that a dome image or a whole-sphere image shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComposedCone {
    /// Unit vector, ICRF.
    pub axis: DVec3,
    /// Largest angle from the axis: pi in a whole-sphere image.
    pub half_angle_rad: f64,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Barycentric position, ICRF.
    pub position_km: DVec3,
    /// Unit axes in ICRF; `right` x `up` is -`forward`, in a mirrored image `forward`.
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// Tangent of half the field of view, horizontal and vertical.
    pub tan_half_fov: DVec2,
    /// Size of the viewport, pixels.
    pub width: u32,
    pub height: u32,
    /// Whether the frame is one face of a dome image or of a whole-sphere image.
    pub is_cube_face: bool,
    /// What a dome image or a whole-sphere image shows in all its frames: the Sun's glare is that of the entire image. `None`: the frame is the image.
    pub composed_cone: Option<ComposedCone>,
    /// Whether the frame belongs to a dome image or a whole-sphere image, in which sprites of points are limited to a small part of the image.
    pub limits_sprite_size: bool,
}

/// The apparent position, orientation and size of a body, f64. Its unit-sphere frame has the body's axes, each divided by its semi-axis, so that the ellipsoid
/// is the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Vector from the camera to the body's apparent centre, ICRF, kilometres.
    pub centre_km: DVec3,
    /// Rows are the body's axes. Aberration rotates them by the same rotation as the body's direction, so that the visible side does not change.
    pub body_from_icrf: DMat3,
    /// Semi-axes.
    pub radii_km: DVec3,
}

impl Placement {
    /// Position of the camera in the unit-sphere frame.
    pub fn camera_in_unit_sphere(&self) -> DVec3 {
        self.body_from_icrf * -self.centre_km / self.radii_km
    }

    /// An ICRF vector in the unit-sphere frame, times the equatorial radius `radii_km.x`, so that its length stays of the same order (for a sphere, the same).
    pub fn direction_in_unit_sphere(&self, v: DVec3) -> DVec3 {
        self.body_from_icrf * v * (self.radii_km.x / self.radii_km)
    }

    /// Whether the camera is inside the ellipsoid or on it.
    pub(crate) fn camera_is_inside(&self) -> bool {
        self.camera_in_unit_sphere().length_squared() <= 1.0
    }

    /// Unit-sphere point of the body in an ICRF direction from the camera, which must be outside the body; `None` if the ray misses the body.
    pub(crate) fn surface_along(&self, direction: DVec3) -> Option<DVec3> {
        self.surface_along_unit_sphere(self.direction_in_unit_sphere(direction))
    }

    /// Vector from the camera to the body's ground in an ICRF direction, ICRF, km; `None` if the ray misses the body, or if the camera is inside it.
    pub(crate) fn ground_along(&self, direction: DVec3) -> Option<DVec3> {
        let unit_point = self.surface_along(direction).filter(|_| !self.camera_is_inside())?;
        Some(self.centre_km + self.body_from_icrf.transpose() * (unit_point * self.radii_km))
    }

    /// Height of the camera above the ellipsoid: its distance from the nearest point of the ellipsoid; 0 inside.
    pub(crate) fn camera_height_km(&self) -> f64 {
        let (camera, radii_sq) = (self.camera_in_unit_sphere(), self.radii_km * self.radii_km);
        let excess = (camera.length() - 1.0) * (camera.length() + 1.0);
        // With the camera at x and semi-axes a, the nearest point is a² x / (a² + t), where t >= 0 solves |a x / (a² + t)|² = 1. The left side is convex and
        // falls, so Newton's steps from t = 0 approach the root from below, without passing it. The step for t = 0 is written without cancellation.
        if excess.is_nan() || excess <= 0.0 {
            return 0.0;
        }
        let camera_km = camera * self.radii_km;
        let mut t = 0.0;
        for step in 0..MAX_HEIGHT_STEPS {
            let q = camera_km * self.radii_km / (radii_sq + t);
            let value = if step == 0 { excess } else { q.length_squared() - 1.0 };
            let change = value / (2.0 * (q * q / (radii_sq + t)).element_sum());
            t += change;
            if change <= 1e-12 * t {
                break;
            }
        }
        (camera_km * t / (radii_sq + t)).length()
    }

    /// The camera's height above the ellipsoid, if it is more than 0 and less than the largest semi-axis: near a body, the height says more than the distance of
    /// the centre.
    pub(crate) fn height_near_ground_km(&self) -> Option<f64> {
        Some(self.camera_height_km()).filter(|height_km| *height_km > 0.0 && *height_km < self.radii_km.max_element())
    }

    /// Whether the body covers an entire disc of this angular radius around an ICRF direction: whether the direction meets a smaller ellipsoid, whose outline
    /// is inside the body's by the disc's radius. Exact for a sphere; otherwise that distance is off by up to the disc's radius times the flattening.
    pub(crate) fn covers_disc(&self, direction: DVec3, angular_radius_rad: f64) -> bool {
        // A sphere of radius r at distance D has the angular radius asin(r / D). To appear smaller by the angle a, it must have the radius r cos a - h sin a,
        // where h is the distance to the horizon, h² = D² - r².
        let (sin, cos) = angular_radius_rad.sin_cos();
        let distance = self.camera_in_unit_sphere().length();
        // Lengths along the line to the centre have the ratio `centre_km.length() / distance` between kilometres and the unit-sphere frame.
        let horizon_km = ((distance - 1.0) * (distance + 1.0)).max(0.0).sqrt() * self.centre_km.length() / distance;
        let radii_km = self.radii_km * cos - horizon_km * sin;
        radii_km.min_element() > 0.0 && Self { radii_km, ..*self }.surface_along(direction).is_some()
    }

    /// Like [`Self::surface_along`], for a direction of any length in the unit-sphere frame.
    pub(crate) fn surface_along_unit_sphere(&self, direction: DVec3) -> Option<DVec3> {
        let origin = self.camera_in_unit_sphere();
        let ray = direction.normalize();
        // Distance along the ray to its point nearest to the centre.
        let to_nearest = -origin.dot(ray);
        // |origin x ray| is the distance of the ray's line from the centre, computed without cancellation.
        let half_chord_sq = 1.0 - origin.cross(ray).length_squared();
        (half_chord_sq >= 0.0 && to_nearest > 0.0).then(|| origin + ray * (to_nearest - half_chord_sq.sqrt()))
    }
}

/// A bounding rectangle in clip space, where y points up: `top` is greater than `bottom`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipRect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl ClipRect {
    /// The entire image.
    pub const VIEWPORT: Self = Self { left: -1.0, top: 1.0, right: 1.0, bottom: -1.0 };

    /// The intersection of two rectangles; `None` if it is empty.
    pub(crate) fn intersection(&self, other: &Self) -> Option<Self> {
        let common = Self {
            left: self.left.max(other.left),
            top: self.top.min(other.top),
            right: self.right.min(other.right),
            bottom: self.bottom.max(other.bottom),
        };
        (common.left < common.right && common.bottom < common.top).then_some(common)
    }

    /// Left, top, right and bottom as f32.
    pub(crate) fn narrowed(&self) -> Vec4 {
        narrow4(glam::DVec4::new(self.left, self.top, self.right, self.bottom))
    }

    /// The smallest rectangle of whole pixels around this one. `half_size_px`: half the image's size, pixels.
    pub(crate) fn of_whole_pixels(&self, half_size_px: DVec2) -> Self {
        let column = |clip: f64, round: fn(f64) -> f64| round((1.0 + clip) * half_size_px.x) / half_size_px.x - 1.0;
        let row = |clip: f64, round: fn(f64) -> f64| 1.0 - round((1.0 - clip) * half_size_px.y) / half_size_px.y;
        Self {
            left: column(self.left, f64::floor),
            top: row(self.top, f64::floor),
            right: column(self.right, f64::ceil),
            bottom: row(self.bottom, f64::ceil),
        }
    }
}

/// One draw's view rays as functions of u and v, narrowed to f32 ([`Camera::view_rays`]). The fields fill those of the same names in
/// [`crate::scene::draw::DrawUniforms`], which documents all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRays {
    pub rect_in_clip: Vec4,
    pub anchor_origin: Vec3,
    pub anchor_du: Vec3,
    pub anchor_dv: Vec3,
    pub ray_origin: Vec3,
    pub ray_du: Vec3,
    pub ray_dv: Vec3,
    pub anchor_radius_sq_minus_1: f32,
    pub anchor_is_camera: bool,
    /// A polynomial that is 0 at the silhouette: coefficients of 1, u, v, then of u², uv, v².
    pub silhouette_form: [Vec4; 2],
    /// The reversed depth of a unit-sphere point p is 1 / (dot(xyz, p) + w).
    pub depth_row: Vec4,
    /// The point of the body that reaches farthest along the line from the body's centre to the camera, as a unit-sphere point.
    pub nearest_point: Vec3,
    pub camera_in_unit_sphere: Vec3,
}

/// Where the anchors of view rays are: at the camera, or on the plane through the body's centre parallel to the image. `Auto` chooses the form whose rounding
/// error moves the silhouette less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnchorForm {
    Auto,
    Camera,
    Plane,
}

/// Narrows f64 to f32, rounding to nearest. The other modules of `scene` narrow only by this function and its variants below.
pub(crate) fn narrow(v: DVec3) -> Vec3 {
    v.as_vec3()
}

/// Like [`narrow`], for two components.
pub(crate) fn narrow2(v: DVec2) -> Vec2 {
    v.as_vec2()
}

/// Like [`narrow`], for four components.
pub(crate) fn narrow4(v: glam::DVec4) -> Vec4 {
    v.as_vec4()
}

/// Like [`narrow`], for one number.
pub(crate) fn narrow_scalar(v: f64) -> f32 {
    v as f32
}

impl Camera {
    /// A camera whose up axis is as close to `up_hint` as the line of sight allows. `fov_deg`: vertical field of view.
    pub fn looking(position_km: DVec3, forward: DVec3, up_hint: DVec3, fov_deg: f64, width: u32, height: u32) -> Self {
        let forward = forward.normalize();
        // A hint along the line of sight (within 1e-9 radians) is unusable: fall back on the celestial pole, then on the equinox.
        let right = [up_hint, DVec3::Z, DVec3::X]
            .into_iter()
            .map(|up| forward.cross(up.normalize_or_zero()))
            .find(|right| right.length() > 1e-9)
            .unwrap_or(DVec3::Y)
            .normalize();
        let up = right.cross(forward);
        let tan_y = (fov_deg.to_radians() / 2.0).tan();
        let tan_half_fov = DVec2::new(tan_y * f64::from(width) / f64::from(height), tan_y);
        Self {
            position_km,
            right,
            up,
            forward,
            tan_half_fov,
            width,
            height,
            is_cube_face: false,
            composed_cone: None,
            limits_sprite_size: false,
        }
    }

    /// The camera of the image that is mirrored left to right. All that is placed by the axes follows, and texts, which are placed by pixels, stay readable.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { right: -self.right, ..self }
    }

    /// Whether the image is mirrored: whether front faces wind clockwise on the screen.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.right.cross(self.up).dot(self.forward) > 0.0
    }

    /// Half the width and height of the viewport, pixels.
    pub fn half_size_px(&self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height)) / 2.0
    }

    /// Whether a sphere may be in the frame: partly beyond the near plane, and not entirely outside any of the frustum's four side planes, each moved outwards
    /// by a margin. `centre_km`: in the camera's axes (right, up, forward).
    pub(crate) fn sphere_may_be_in_frame(&self, centre_km: DVec3, radius_km: f64, margin_px: f64) -> bool {
        let half = self.half_size_px();
        // `lateral_km` - tan z is the centre's distance beyond a side plane, times sqrt(1 + tan²).
        let is_outside = |lateral_km: f64, tan_half_fov: f64, half_px: f64| {
            let tan = tan_half_fov * (1.0 + margin_px / half_px);
            (lateral_km.abs() - tan * centre_km.z) > radius_km * (1.0 + tan * tan).sqrt()
        };
        let tan = self.tan_half_fov;
        centre_km.z + radius_km > NEAR_DEPTH_KM && !is_outside(centre_km.x, tan.x, half.x) && !is_outside(centre_km.y, tan.y, half.y)
    }

    /// An ICRF vector in the camera's axes: right, up, forward.
    pub(crate) fn in_axes(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.right), v.dot(self.up), v.dot(self.forward))
    }

    /// Clip units per pixel, for shaders.
    pub(crate) fn clip_per_pixel(&self) -> Vec2 {
        (1.0 / self.half_size_px()).as_vec2()
    }

    /// Tangent of the angle that one pixel spans at the image's centre.
    pub fn pixel_tangent(&self) -> f64 {
        self.tan_half_fov.y / self.half_size_px().y
    }

    /// Angle from the middle of the frame to its corner.
    pub fn corner_rad(&self) -> f64 {
        self.tan_half_fov.length().atan()
    }

    /// The view ray through a clip position as an ICRF vector of view depth 1.
    pub fn ray(&self, clip: DVec2) -> DVec3 {
        self.forward + self.right * (clip.x * self.tan_half_fov.x) + self.up * (clip.y * self.tan_half_fov.y)
    }

    /// Clip position of a direction; `None` behind the camera.
    pub fn clip(&self, direction: DVec3) -> Option<DVec2> {
        let depth = direction.dot(self.forward);
        (depth > 0.0).then(|| DVec2::new(direction.dot(self.right), direction.dot(self.up)) / (depth * self.tan_half_fov))
    }

    /// Pixel of a clip position.
    pub fn pixel_from_clip(&self, clip: DVec2) -> DVec2 {
        DVec2::new(1.0 + clip.x, 1.0 - clip.y) * self.half_size_px()
    }

    /// Clip position of a pixel.
    pub fn clip_from_pixel(&self, pixel: DVec2) -> DVec2 {
        let p = pixel / self.half_size_px();
        DVec2::new(p.x - 1.0, 1.0 - p.y)
    }

    /// The point of the body under a pixel, unit-sphere frame; `None` outside the body or behind the camera.
    pub fn surface_under_pixel(&self, placement: &Placement, pixel: DVec2) -> Option<DVec3> {
        placement.surface_along(self.ray(self.clip_from_pixel(pixel)))
    }

    /// Pixel of a unit-sphere point of the body; `None` behind the camera or on the far side.
    pub fn pixel_of_surface(&self, placement: &Placement, unit_point: DVec3) -> Option<DVec2> {
        // The near side is beyond the plane through the horizon, on which camera . p = 1.
        let is_near_side = placement.camera_in_unit_sphere().dot(unit_point) >= 1.0;
        let direction = placement.centre_km + placement.body_from_icrf.transpose() * (unit_point * placement.radii_km);
        if is_near_side { self.clip(direction).map(|c| self.pixel_from_clip(c)) } else { None }
    }

    /// Narrows the rays of one draw to f32.
    ///
    /// A ray is given by its direction and its anchor, a point on it. Both are affine over the rectangle: value = origin + u du + v dv, where u goes from 0 at
    /// the left edge to 1 at the right, and v from 0 at the top to 1 at the bottom. The anchor is the camera (camera form), or the ray's intersection with the
    /// plane through the body's centre parallel to the image (plane form). The rounding of f32, of relative error e, moves the silhouette, as the camera sees
    /// it, by about 2 e |c| radians in the camera form and by 3 e A / t in the plane form. Here c is the camera in the unit-sphere frame, and t the camera's
    /// distance to the horizon (t² = |c|² - 1). A is the greatest distance of an anchor in the rectangle from the body's centre. `Auto` takes the form with
    /// the smaller shift. Measured in tests/scene/silhouette.rs.
    ///
    /// The rectangle is enlarged to whole pixels, because a GPU moves vertices to multiples of 1/256 pixel, and some interpolate between the moved vertices (an
    /// NVIDIA H100 by its errors, docs/trade.md). Rays would be off by up to 1/512 pixel, which changes a faint edge on black by up to 6 of 255, and the Sun's
    /// edge by far more.
    pub fn view_rays(&self, placement: &Placement, rect: ClipRect, form: AnchorForm) -> ViewRays {
        let rect = rect.of_whole_pixels(self.half_size_px());
        // The edges are narrowed first, so that rays and clip positions agree exactly. x, y, z, w: left, top, right, bottom.
        let rect_in_clip = rect.narrowed();
        let r = rect_in_clip.as_dvec4();
        // Origin, du and dv.
        let rays_in_icrf = [
            self.ray(DVec2::new(r.x, r.y)),
            self.right * ((r.z - r.x) * self.tan_half_fov.x),
            self.up * ((r.w - r.y) * self.tan_half_fov.y),
        ];
        let [origin, du, dv] = rays_in_icrf.map(|ray| placement.direction_in_unit_sphere(ray));
        let camera = placement.camera_in_unit_sphere();
        let centre_depth_km = placement.centre_km.dot(self.forward);
        // In equatorial radii, by which `direction_in_unit_sphere` multiplies.
        let centre_depth = centre_depth_km / placement.radii_km.x;
        let radius_sq_minus_1 = (camera.length() - 1.0) * (camera.length() + 1.0);
        let plane = [origin * centre_depth + camera, du * centre_depth, dv * centre_depth];
        // At least 1: the anchors on the silhouette are outside the unit sphere or on it.
        let farthest_anchor = [plane[0], plane[0] + plane[1], plane[0] + plane[2], plane[0] + plane[1] + plane[2]]
            .iter()
            .map(|p| p.length())
            .fold(1.0, f64::max);
        let plane_is_better = centre_depth > 0.0 && 3.0 * farthest_anchor < 2.0 * camera.length() * radius_sq_minus_1.max(0.0).sqrt();
        let anchor_is_camera = match form {
            AnchorForm::Auto => !plane_is_better,
            AnchorForm::Camera => true,
            AnchorForm::Plane => false,
        };
        let anchor = if anchor_is_camera { [camera, DVec3::ZERO, DVec3::ZERO] } else { plane };
        // The moment of a ray is camera x ray; its length is |ray| q, where q is the distance of the ray's line from the centre. So |ray|² - |moment|² is
        // |ray|² (1 - q²), a quadratic form over the rectangle that is 0 at the silhouette. A ray's component along the line to the centre does not
        // contribute to its moment; it is removed first, because its rounding would.
        let centre = placement.centre_km.normalize_or_zero();
        let moments = rays_in_icrf.map(|ray| camera.cross(placement.direction_in_unit_sphere(ray - centre * ray.dot(centre))));
        let rays = [origin, du, dv];
        // Entry of the symmetric matrix of the quadratic form of (1, u, v).
        let entry = |i: usize, k: usize| rays[i].dot(rays[k]) - moments[i].dot(moments[k]);
        let silhouette_form =
            [DVec3::new(entry(0, 0), 2.0 * entry(0, 1), 2.0 * entry(0, 2)), DVec3::new(entry(1, 1), 2.0 * entry(1, 2), entry(2, 2))];
        // The view depth of a unit-sphere point p is the centre's plus the component along `forward` of p times the semi-axes.
        let depth_axis = placement.body_from_icrf * self.forward * placement.radii_km / NEAR_DEPTH_KM;
        // The outward normal at a unit-sphere point p is along p / radii: it is along the line to the camera where p is along -centre * radii.
        let nearest_point = (placement.body_from_icrf * -centre * placement.radii_km).normalize_or_zero();
        ViewRays {
            rect_in_clip,
            anchor_origin: narrow(anchor[0]),
            anchor_du: narrow(anchor[1]),
            anchor_dv: narrow(anchor[2]),
            ray_origin: narrow(origin),
            ray_du: narrow(du),
            ray_dv: narrow(dv),
            anchor_radius_sq_minus_1: narrow_scalar(radius_sq_minus_1),
            anchor_is_camera,
            silhouette_form: silhouette_form.map(|row| narrow(row).extend(0.0)),
            depth_row: narrow(depth_axis).extend(narrow_scalar(centre_depth_km / NEAR_DEPTH_KM)),
            nearest_point: narrow(nearest_point),
            camera_in_unit_sphere: narrow(camera),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use std::f64::consts::TAU;

    /// The angle in radians from the centre's direction up to which a condition on directions holds; 0 if it does not hold at the centre.
    fn angle_up_to(holds: impl Fn(DVec3) -> bool, centre: DVec3, perpendicular: DVec3) -> f64 {
        let at = |angle: f64| centre * angle.cos() + perpendicular * angle.sin();
        // Bisection to 1e-10 radians; no body's rim is farther than 1.7 radians from its centre here.
        let (mut from, mut to) = (0.0, 1.7);
        for _ in 0..34 {
            let middle = 0.5 * (from + to);
            if holds(at(middle)) { from = middle } else { to = middle }
        }
        from
    }

    /// A camera above a point of the ellipsoid, along the normal: its height is what it was placed at, on spheres, on Saturn, and on bodies with three different
    /// axes; below the ground it is 0.
    #[test]
    fn the_height_is_that_along_the_normal() {
        let mut random = Random::new(11);
        for radii_km in [DVec3::splat(6378.0), DVec3::new(60268.0, 60268.0, 54364.0), DVec3::new(13.0, 11.4, 9.1)] {
            for height_km in [1e-3, 1.0, 0.9 * radii_km.z, 1e3 * radii_km.x, 1.5e10] {
                let unit = random.direction();
                let normal = (unit / radii_km).normalize();
                let body_from_icrf = DMat3::from_axis_angle(random.direction(), random.between(0.0, TAU));
                let above = |height_km: f64| {
                    let camera_km = unit * radii_km + normal * height_km;
                    Placement { centre_km: body_from_icrf.transpose() * -camera_km, body_from_icrf, radii_km }
                };
                let found = above(height_km).camera_height_km();
                assert!((found / height_km - 1.0).abs() < 1e-6, "{radii_km} {height_km}: {found}");
                let is_near = height_km < radii_km.x;
                assert_eq!(above(height_km).height_near_ground_km().is_some(), is_near, "{radii_km} {height_km}");
                assert_eq!(above(-0.01 * radii_km.z).camera_height_km(), 0.0);
            }
        }
    }

    /// For cameras from the ground to a telescope's distance (`height`: above the ellipsoid, in radii): a body covers a disc exactly if all rays through the
    /// disc's rim meet the body.
    #[test]
    fn a_body_covers_a_disc_if_all_rays_of_its_rim_meet_the_body() {
        let mut random = Random::new(7);
        for (height, flattening) in [1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e4].into_iter().flat_map(|h| [0.0, 0.1].map(|f| (h, f))) {
            for _ in 0..6 {
                let radii_km = DVec3::new(1.0, 1.0, 1.0 - flattening);
                let body_from_icrf = DMat3::from_axis_angle(random.direction(), random.between(0.0, TAU));
                let camera = random.direction() * radii_km * (1.0 + height);
                let body = Placement { centre_km: body_from_icrf.transpose() * -camera, body_from_icrf, radii_km };
                // The angular radius of the disc: that of the Sun as seen from the Earth, or a fifth of the body's own if this is smaller.
                let disc_rad = (0.2 * (1.0 / (1.0 + height)).asin()).min(0.0047);
                let all_rays_meet = |direction: DVec3| {
                    let (x, y) = direction.any_orthonormal_pair();
                    (0..48).map(|k| TAU * f64::from(k) / 48.0).all(|angle| {
                        let across = x * angle.cos() + y * angle.sin();
                        body.surface_along(direction * disc_rad.cos() + across * disc_rad.sin()).is_some()
                    })
                };
                let centre = body.centre_km.normalize();
                let perpendicular = centre.cross(random.direction()).normalize();
                let expected = angle_up_to(all_rays_meet, centre, perpendicular);
                let found = angle_up_to(|direction| body.covers_disc(direction, disc_rad), centre, perpendicular);
                // Rays at 48 places of the rim miss up to 0.2 % of its radius; on a flattened body `covers_disc` is off by up to the flattening times the
                // radius. Both are allowed with some room.
                let allowed = (0.003 + 1.2 * flattening) * disc_rad;
                assert!((found - expected).abs() < allowed, "height {height}, {flattening}: {found}, not {expected}");
            }
        }
    }
}
