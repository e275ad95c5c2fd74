//! The part of a body and its air that an image can show: what is in the frame and in front of the horizon.
//!
//! In: the camera and the rays of the frame's corners in the body's axes, the body's shape, and the height of its air. Out: whether a shadow can touch that
//! part. Method: the part is contained in two convex bodies, a cap that the horizon cuts off, and the frame's pyramid. It is apart from a shadow if in some
//! direction across the shadow one of the two is beyond the shadow's edge. Always: a shadow that darkens a visible point touches the part. Not here: shadows on
//! rings and on shape models, of which more can be seen than of an ellipsoid.

use glam::DVec3;
use std::f64::consts::TAU;

/// Number of directions across the shadow that are tested. The nearest of them is at most 2.8 degrees from any direction.
const DIRECTIONS: u32 = 64;
/// Distance by which the part is enlarged, equatorial radii: 0.6 km on the Earth, where shaders in f32 are accurate to metres.
const MARGIN: f64 = 1e-4;

/// The visible part of a body. Lengths are in the body's equatorial radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisiblePart {
    /// Semi-axes of the ground.
    axis_ratios: DVec3,
    /// Position of the camera, and view rays through the frame's corners, with a view depth of 1; body axes.
    camera: DVec3,
    corner_rays: [DVec3; 4],
    /// Unit vector from the body's centre, in the frame where the ground is the unit sphere.
    towards_camera: DVec3,
    /// In that frame: the radius of the air's top, and the smallest component along `towards_camera` of a visible point.
    top: f64,
    lowest: f64,
    /// Greatest distance of a visible point from the camera.
    reach: f64,
    /// Distance outside a shadow up to which its light is changed, too.
    spread: f64,
}

/// The points with `point . normal >= bound`, and the points of that plane between one of them and one of the others. Their convex hull is the part of the
/// points' convex hull on that side.
fn clipped(points: &[DVec3], normal: DVec3, bound: f64) -> Vec<DVec3> {
    let height = |p: &DVec3| p.dot(normal) - bound;
    let (inside, outside): (Vec<DVec3>, Vec<DVec3>) = points.iter().copied().partition(|p| height(p) >= 0.0);
    let crossing = |p: &DVec3, q: &DVec3| *p + (*q - *p) * (height(p) / (height(p) - height(q)));
    let crossings: Vec<DVec3> = inside.iter().flat_map(|p| outside.iter().map(move |q| (p, q))).map(|(p, q)| crossing(p, q)).collect();
    inside.into_iter().chain(crossings).collect()
}

impl VisiblePart {
    /// `None` for a camera on the ground's ellipsoid or in it. `camera`, `corner_rays`: body axes; `max_radius`: of the air's top in the frame where the ground
    /// is the unit sphere, 1 without air; `spread`: see the field.
    pub(crate) fn of(camera: DVec3, corner_rays: [DVec3; 4], axis_ratios: DVec3, max_radius: f64, spread: f64) -> Option<Self> {
        let in_unit_sphere = camera / axis_ratios;
        let distance = in_unit_sphere.length();
        if distance.partial_cmp(&1.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let top = max_radius.max(1.0) + MARGIN;
        // The farthest visible point is on a ray that grazes the ground, where it leaves the air. Every other visible point has a greater component along
        // `towards_camera`. Lengths along that ray: from the camera to the horizon, and from there to the top of the air.
        let (to_horizon, from_horizon) = (((distance - 1.0) * (distance + 1.0)).sqrt(), (top * top - 1.0).sqrt());
        Some(Self {
            axis_ratios,
            camera,
            corner_rays,
            towards_camera: in_unit_sphere / distance,
            top,
            lowest: (1.0 - to_horizon * from_horizon) / distance - MARGIN,
            reach: (to_horizon + from_horizon) * axis_ratios.max_element(),
            spread,
        })
    }

    /// Points whose convex hull contains the part: the frame's pyramid, cut off at the greatest distance of a visible point, at the horizon, and at the top of
    /// the air above the point below the camera.
    fn corners(&self) -> Vec<DVec3> {
        let base = self.corner_rays.iter().map(|ray| self.camera + *ray * self.reach);
        let pyramid: Vec<DVec3> = std::iter::once(self.camera).chain(base).collect();
        // A component along `towards_camera` in the unit-sphere frame is the product with this vector in body axes.
        let normal = self.towards_camera / self.axis_ratios;
        clipped(&clipped(&pyramid, normal, self.lowest), -normal, -self.top)
    }

    /// The greatest component along `direction` (body axes) of a point below the top of the air and in front of the horizon.
    fn extent_of_cap(&self, direction: DVec3) -> f64 {
        let scaled = direction * self.axis_ratios;
        let (length, component) = (scaled.length(), scaled.dot(self.towards_camera));
        if self.top * component >= self.lowest * length {
            return self.top * length;
        }
        // On the edge of the cap.
        let (rim_radius_sq, across_sq) = (self.top * self.top - self.lowest * self.lowest, length * length - component * component);
        self.lowest * component + (rim_radius_sq.max(0.0) * across_sq.max(0.0)).sqrt()
    }

    /// Whether a shadow may touch the part. `sunward`: unit vector along the shadow's axis; `ends`: centre and radius of two cross sections between which the
    /// shadow is.
    pub(crate) fn may_touch(&self, sunward: DVec3, ends: &[(DVec3, f64); 2]) -> bool {
        let corners = self.corners();
        let [(centre, near_radius), (_, far_radius)] = *ends;
        let radius = near_radius.max(far_radius) + self.spread;
        let (x, y) = sunward.any_orthonormal_pair();
        let is_beyond = |direction: DVec3| {
            let in_frame = corners.iter().map(|corner| corner.dot(direction)).fold(f64::INFINITY, f64::min);
            in_frame.max(-self.extent_of_cap(-direction)) > centre.dot(direction) + radius
        };
        let directions = (0..DIRECTIONS).map(|k| (TAU * f64::from(k) / f64::from(DIRECTIONS)).sin_cos());
        !directions.map(|(sin, cos)| x * cos + y * sin).any(is_beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scene::camera::Camera;
    use glam::DVec2;

    /// A camera near a body, with the rays of the corners of its frame, which looks in any direction.
    struct View {
        position: DVec3,
        camera: Camera,
        axis_ratios: DVec3,
        top: f64,
    }

    impl View {
        fn random(random: &mut Random) -> Self {
            let axis_ratios = DVec3::new(1.0, random.between(0.9, 1.0), random.between(0.9, 1.0));
            let position = random.direction() * axis_ratios * (1.0 + 10.0_f64.powf(random.between(-4.0, 1.0)));
            // Half of the views show the horizon or the ground below it.
            let down = -position.normalize();
            let towards = down * random.between(0.0, 1.0) + random.direction();
            let camera = Camera::looking(DVec3::ZERO, towards, random.direction(), random.between(1.0, 110.0), 64, 48);
            Self { position, camera, axis_ratios, top: 1.0 + 10.0_f64.powf(random.between(-4.0, -1.0)) }
        }

        fn part(&self, top: f64) -> VisiblePart {
            let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|c| self.camera.ray(DVec2::from_array(c)));
            let spread = 0.0;
            VisiblePart::of(self.position, corners, self.axis_ratios, top, spread).expect("above the ground")
        }

        /// A point on a random ray of the frame, in the air or on the ground; `None` if the ray misses the air.
        fn visible_point(&self, random: &mut Random) -> Option<DVec3> {
            let clip = DVec2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let ray = (self.camera.ray(clip) / self.axis_ratios).normalize();
            let origin = self.position / self.axis_ratios;
            let to_nearest = -origin.dot(ray);
            let half_chord = |radius: f64| (radius * radius - origin.cross(ray).length_squared()).max(0.0).sqrt();
            let (from, mut to) = ((to_nearest - half_chord(self.top)).max(0.0), to_nearest + half_chord(self.top));
            if half_chord(1.0) > 0.0 && to_nearest > 0.0 {
                to = to_nearest - half_chord(1.0);
            }
            (half_chord(self.top) > 0.0 && to > from).then(|| (origin + ray * random.between(from, to)) * self.axis_ratios)
        }
    }

    /// Shadows over visible points always touch the visible part. If the air were a hundredth as high, some would not. Of shadows over random places of the
    /// body, most are apart.
    #[test]
    fn a_shadow_over_a_visible_point_touches_the_part() {
        let mut random = Random::new(23);
        let (mut seen, mut missed_if_low, mut apart, mut elsewhere) = (0, 0, 0, 0);
        for _ in 0..40_000 {
            let view = View::random(&mut random);
            let sunward = random.direction();
            let radius = 10.0_f64.powf(random.between(-3.0, -0.3));
            let ends_around = |point: DVec3, random: &mut Random| {
                let offset = random.direction().reject_from_normalized(sunward).normalize_or_zero() * (radius * random.between(0.0, 1.0));
                [-1.0, 1.0].map(|along| (point + offset + sunward * along, radius))
            };
            let part = view.part(view.top);
            if let Some(point) = view.visible_point(&mut random) {
                seen += 1;
                let ends = ends_around(point, &mut random);
                assert!(part.may_touch(sunward, &ends), "{point} from {}, shadow of {radius} along {sunward}", view.position);
                missed_if_low += u32::from(!view.part(1.0 + 0.01 * (view.top - 1.0)).may_touch(sunward, &ends));
            }
            elsewhere += 1;
            let place = random.direction();
            apart += u32::from(!part.may_touch(sunward, &ends_around(place, &mut random)));
        }
        println!("{seen} seen, {missed_if_low} missed if the air were low; {apart} of {elsewhere} elsewhere are apart");
        assert!(seen > 5000 && missed_if_low > 0 && 2 * apart > elsewhere, "{seen}, {missed_if_low}, {apart} of {elsewhere}");
    }

    /// From 15 km above the Earth, whose air is 100 km high, the ground is seen up to 437 km away and the air up to 1570 km. A vertical shadow is apart beyond
    /// the air that is seen, and behind the camera if it is farther away than its own radius.
    #[test]
    fn shadows_beyond_the_horizon_or_behind_the_camera_are_apart() {
        const EARTH_KM: f64 = 6378.0;
        let position = DVec3::Z * (1.0 + 15.0 / EARTH_KM);
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, 64, 48);
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|c| camera.ray(DVec2::from_array(c)));
        let (max_radius, spread) = (1.0 + 100.0 / EARTH_KM, 0.0);
        let part = VisiblePart::of(position, corners, DVec3::ONE, max_radius, spread).expect("above the ground");
        let touches = |x_km: f64| {
            let centre = DVec3::X * (x_km / EARTH_KM);
            part.may_touch(DVec3::Z, &[(centre + DVec3::Z * 2.0, 50.0 / EARTH_KM), (centre - DVec3::Z * 2.0, 50.0 / EARTH_KM)])
        };
        assert_eq!([-60.0, -40.0, 200.0, 1500.0, 1700.0].map(touches), [false, true, true, true, false]);
    }
}
