//! Where an occluder's shadow lies near its receiver, and whether it meets the image.
//!
//! In: an occluder, shape and size of its receiver, and the frustum of the camera in the receiver's axes. Out: a tapered capsule that contains every point of
//! the receiver in the penumbra, and whether any of it can be in the image: in the frustum and, of an ellipsoid, in front of its horizon (`visible_part`).
//! Always: the capsule may be too large, but never too small, so a shadow in the image is never judged to be outside.

use crate::scene::camera::{Camera, Placement};
use crate::scene::eclipse::visible_part::VisiblePart;
use glam::{DVec2, DVec3};

/// Pixels by which the frustum is widened on each side, because a pixel at the image's edge also shows what is less than a pixel outside.
const MARGIN_PX: f64 = 2.0;
/// Factor on the penumbra's radius: a margin of 0.1 %. The cone that touches Sun and occluder is wider than `radius + behind * widening` (see
/// [`ShadowRegion::of`]) by a fraction of about the square of the Sun's angular radius in radians, 2e-5 on the Earth.
const RADIUS_MARGIN: f64 = 1.001;

/// The image's frustum in a receiver's axes and equatorial radii.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    /// The camera's position relative to the receiver's centre.
    position: DVec3,
    /// Inward unit normals of its planes, all through the camera: the four sides, then the plane perpendicular to the view axis.
    inward_normals: [DVec3; 5],
    /// Tangent of the angle of the smallest pixel, which is at a corner.
    smallest_pixel_tangent: f64,
    /// View rays through the corners, of view depth 1.
    corner_rays: [DVec3; 4],
    /// What the image shows of the receiver, if its ground hides what is behind the horizon.
    visible_part: Option<VisiblePart>,
}

impl Frustum {
    /// The frustum of `camera` in the axes of a placed body.
    pub(crate) fn of(camera: &Camera, placement: &Placement) -> Self {
        let tan = camera.tan_half_fov * (1.0 + DVec2::splat(MARGIN_PX) / camera.half_size_px());
        let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|axis| placement.body_from_icrf * axis);
        let sides = [forward * tan.x - right, forward * tan.x + right, forward * tan.y - up, forward * tan.y + up];
        Self {
            position: placement.body_from_icrf * -placement.centre_km / placement.radii_km.x,
            inward_normals: [sides[0], sides[1], sides[2], sides[3], forward].map(DVec3::normalize),
            // A corner is at sqrt(1 + tan²) times the distance of the middle, and its pixels are seen obliquely.
            smallest_pixel_tangent: camera.pixel_tangent() / (1.0 + camera.tan_half_fov.length_squared()),
            corner_rays: [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]
                .map(|[x, y]| forward + right * (x * tan.x) + up * (y * tan.y)),
            visible_part: None,
        }
    }

    /// The frustum for a receiver whose ground, an ellipsoid with these semi-axes, hides what is behind the horizon. `max_radius`: of the top of its air;
    /// `spread`: distance outside a shadow up to which the light is changed, too; both in equatorial radii.
    pub(crate) fn above_ground(self, axis_ratios: DVec3, max_radius: f64, spread: f64) -> Self {
        let visible_part = VisiblePart::of(self.position, self.corner_rays, axis_ratios, max_radius, spread);
        Self { visible_part, ..self }
    }
}

/// The points of a receiver that an occluder may darken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiverShape {
    /// Every point within `max_radius`.
    Ball,
    /// Points of the equatorial plane within `max_radius`: rings.
    EquatorialPlane,
}

/// A tapered capsule (a capsule whose radius grows along it): the part of a penumbra that can touch a receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowRegion {
    /// Centre and radius of both ends, the one nearer to the Sun first.
    ends: [(DVec3, f64); 2],
    /// Unit vector along the axis.
    sunward: DVec3,
}

impl ShadowRegion {
    /// The part of a penumbra that may touch the receiver; `None` if the penumbra misses the receiver. `centre`, `radius`: of the occluder. `sunward`: unit
    /// vector to the Sun. `widening`: growth of the penumbra's radius per unit of distance behind the occluder. `max_radius`: distance of the receiver's
    /// farthest point from its centre. Lengths in the receiver's equatorial radii, positions relative to its centre.
    pub(crate) fn of(centre: DVec3, radius: f64, sunward: DVec3, widening: f64, max_radius: f64, shape: ReceiverShape) -> Option<Self> {
        let radius_at = |behind: f64| (radius + behind * widening) * RADIUS_MARGIN;
        // How far behind the occluder the axis is nearest to the receiver's centre; and the square of its distance from this centre.
        let behind_nearest = centre.dot(sunward);
        let axis_distance_sq = (centre - sunward * behind_nearest).length_squared();
        let far_radius = radius_at((behind_nearest + max_radius).max(0.0));
        // The cross section around a point of the axis touches the receiver only if the point is at most `max_radius + far_radius` from the receiver's centre.
        if axis_distance_sq > (max_radius + far_radius).powi(2) {
            return None;
        }
        let max_half_length = ((max_radius + far_radius).powi(2) - axis_distance_sq).max(0.0).sqrt();
        // A cross section is perpendicular to the axis: at more than `max_radius` along the axis from the receiver's centre it contains no point of the
        // receiver.
        let half_length = max_half_length.min(max_radius);
        // The range of distances behind the occluder at which a cross section can contain a point of the receiver.
        let (mut from, mut to) = ((behind_nearest - half_length).max(0.0), behind_nearest + half_length);
        if shape == ReceiverShape::EquatorialPlane {
            // A cross section extends along the plane's normal by its radius times the cosine of the Sun's elevation over the plane. One `RADIUS_MARGIN` is the
            // factor in `radius_at`, the other is an additional margin.
            let cosine = (1.0 - sunward.z * sunward.z).max(0.0).sqrt() * RADIUS_MARGIN * RADIUS_MARGIN;
            for side in [1.0, -1.0] {
                // The cross section must not be entirely on this side of the plane:
                // side * (centre.z - behind * sunward.z) <= (radius + behind * widening) * cosine
                let (rate, bound) = (side * sunward.z + widening * cosine, side * centre.z - radius * cosine);
                if rate > 0.0 {
                    from = from.max(bound / rate);
                } else if rate < 0.0 {
                    to = to.min(bound / rate);
                } else if bound > 0.0 {
                    return None;
                }
            }
        }
        let end = |behind: f64| (centre - sunward * behind, radius_at(behind));
        (from <= to).then(|| Self { ends: [end(from), end(to)], sunward })
    }

    /// Whether any part of the region can be in the image: no plane of the frustum has both ends, and so the entire region, outside, and it touches the visible
    /// part of the receiver.
    pub(crate) fn meets(&self, frustum: &Frustum) -> bool {
        let meets_planes = frustum
            .inward_normals
            .iter()
            .all(|normal| self.ends.iter().any(|(centre, radius)| (*centre - frustum.position).dot(*normal) > -radius));
        meets_planes && frustum.visible_part.is_none_or(|visible| visible.may_touch(self.sunward, &self.ends))
    }

    /// A lower limit of the width of the pixels that show the region, measured at the region, in equatorial radii.
    pub(crate) fn min_pixel(&self, frustum: &Frustum) -> f64 {
        let [(near, near_radius), (far, far_radius)] = self.ends;
        let (axis, to_camera) = (far - near, frustum.position - near);
        let fraction = (to_camera.dot(axis) / axis.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let distance = (to_camera - axis * fraction).length() - near_radius.max(far_radius);
        distance.max(0.0) * frustum.smallest_pixel_tangent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const MAX_RADIUS: f64 = 3.0;

    struct Shadow {
        centre: DVec3,
        radius: f64,
        sunward: DVec3,
        widening: f64,
    }

    impl Shadow {
        fn random(random: &mut Random) -> Self {
            // The Sun's elevation over the plane is often far below one degree.
            let flattened = random.direction() * DVec3::new(1.0, 1.0, 10.0_f64.powf(random.between(-5.0, 0.0)));
            Self {
                centre: random.direction() * random.between(0.5, 30.0) * DVec3::new(1.0, 1.0, 10.0_f64.powf(random.between(-3.0, 0.0))),
                radius: 10.0_f64.powf(random.between(-3.0, 0.5)),
                sunward: flattened.normalize(),
                widening: 10.0_f64.powf(random.between(-4.0, -1.5)),
            }
        }

        fn region(&self, shape: ReceiverShape) -> Option<ShadowRegion> {
            ShadowRegion::of(self.centre, self.radius, self.sunward, self.widening, MAX_RADIUS, shape)
        }

        /// Whether the shader darkens a point: one behind the occluder's centre, and within the penumbra's radius of the axis.
        fn darkens(&self, point: DVec3) -> bool {
            let behind = (self.centre - point).dot(self.sunward);
            let axis_distance = (point - self.centre).reject_from_normalized(self.sunward).length();
            behind > 0.0 && axis_distance < self.radius + behind * self.widening
        }
    }

    fn is_inside(frustum: &Frustum, point: DVec3) -> bool {
        frustum.inward_normals.iter().all(|normal| (point - frustum.position).dot(*normal) > 0.0)
    }

    fn random_frustum(random: &mut Random, position: DVec3) -> Frustum {
        let camera = Camera::looking(DVec3::ZERO, random.direction(), DVec3::Z, random.between(0.1, 120.0), 64, 48);
        let placement = Placement { centre_km: -position, body_from_icrf: glam::DMat3::IDENTITY, radii_km: DVec3::ONE };
        Frustum::of(&camera, &placement)
    }

    /// Random points of the receiver in the penumbra; on the plane for rings.
    fn darkened_points(random: &mut Random, shadow: &Shadow, shape: ReceiverShape) -> Vec<DVec3> {
        let behind_nearest = shadow.centre.dot(shadow.sunward);
        let point_near_shadow = |random: &mut Random| {
            let behind = random.between((behind_nearest - MAX_RADIUS).max(0.0), behind_nearest + MAX_RADIUS);
            let width = (shadow.radius + behind.max(0.0) * shadow.widening) * random.between(0.0, 1.0);
            let offset = random.direction().reject_from_normalized(shadow.sunward).normalize_or_zero() * width;
            let mut point = shadow.centre - shadow.sunward * behind + offset;
            if shape == ReceiverShape::EquatorialPlane {
                // Moved parallel to the axis into the plane.
                point -= shadow.sunward * (point.z / shadow.sunward.z);
                point.z = 0.0;
            }
            point
        };
        (0..40).map(|_| point_near_shadow(random)).filter(|p| p.length() <= MAX_RADIUS && shadow.darkens(*p)).collect()
    }

    /// Points in a shadow and in the image: the region must meet the image. With radii a tenth as wide, some would be missed.
    #[test]
    fn a_shadow_in_the_image_is_never_left_out() {
        let mut random = Random::new(11);
        for shape in [ReceiverShape::Ball, ReceiverShape::EquatorialPlane] {
            let (mut seen, mut left_out_if_narrow, mut outside) = (0, 0, 0);
            for _ in 0..20_000 {
                let shadow = Shadow::random(&mut random);
                let position = random.direction() * 10.0_f64.powf(random.between(0.01, 2.0));
                let frustum = random_frustum(&mut random, position);
                let region = shadow.region(shape);
                outside += usize::from(!region.is_some_and(|r| r.meets(&frustum)));
                for point in darkened_points(&mut random, &shadow, shape).into_iter().filter(|p| is_inside(&frustum, *p)) {
                    seen += 1;
                    let region = region.unwrap_or_else(|| panic!("{shape:?}: no region, yet {point} is darkened"));
                    assert!(region.meets(&frustum), "{shape:?}: {point} is darkened and in the image");
                    let pixel = (point - frustum.position).length() * frustum.smallest_pixel_tangent;
                    assert!(region.min_pixel(&frustum) <= pixel * 1.0001, "{shape:?}: a smaller pixel at {point}");
                    let narrow = ShadowRegion { ends: region.ends.map(|(centre, radius)| (centre, 0.1 * radius)), ..region };
                    left_out_if_narrow += usize::from(!narrow.meets(&frustum));
                }
            }
            println!("{shape:?}: {seen} points, {left_out_if_narrow} left out if narrow, {outside} regions outside");
            assert!(seen > 1000 && left_out_if_narrow > 0 && outside > 10_000, "{shape:?}: {seen}, {left_out_if_narrow}, {outside}");
        }
    }

    /// A moon has no region if the plane is between it and the Sun, or if its shadow meets the plane beyond the largest radius.
    #[test]
    fn a_shadow_that_misses_the_plane_has_no_region() {
        let sunward = DVec3::new(1.0, 0.0, 0.5).normalize();
        let region = |centre: DVec3| ShadowRegion::of(centre, 0.01, sunward, 1e-3, MAX_RADIUS, ReceiverShape::EquatorialPlane);
        assert!(region(DVec3::new(2.0, 0.0, 0.0)).is_some(), "a moon in the plane");
        assert!(region(DVec3::new(2.0, 0.0, 0.3)).is_some(), "its shadow falls on the plane 0.6 nearer to the planet");
        assert!(region(DVec3::new(2.0, 0.0, -0.1)).is_none(), "the plane is between the Sun and the moon");
        assert!(region(DVec3::new(8.0, 0.0, 0.01)).is_none(), "the shadow meets the plane beyond the largest radius");
    }
}
