//! The ground of a body that the frame shows, for the light meter: samples on lines across the image.
//!
//! In: the camera, a body's placement, the direction of the Sun, and what lights or hides the ground. Out: the radiance of samples of the ground, added to a
//! mean with their shares of the frame. The lines run between the dark and the lit side of the body, and end exactly at limb and frame. Each line is divided
//! exactly at the terminator, and its lit and its dark part have samples of their own. Always: the samples change continuously with the camera and the Sun, and
//! even the thinnest crescent has its share. (Fixed rays would miss a crescent thinner than their spacing, or count it many times.)

use super::geometry::{frame_position_weight, least_weight_of_ground, ray_and_limb};
use super::ground::Ground;
use super::highlights::{Highlights, Part};
use super::{LogMean, MeteredFrame};
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{Camera, Placement};
use crate::scene::eclipse::approximate_shadow::ApproximateShadow;
use crate::scene::placed::PlacedBody;
use glam::{DVec2, DVec3};

/// Number of lines. Few lines are too coarse for the weight of a position ([`frame_position_weight`]), which falls by a factor of 1e5 towards the frame's edge.
/// Largest error of the exposure of a crescent beside a black night side, at phase angles of 150 to 179 degrees and any distance: with 48 lines 0.6 stops (root
/// mean square 0.05 stops), with 20 lines 3 stops.
const LINE_COUNT: u32 = 48;
/// Number of samples on the lit and on the dark part of a line.
const SAMPLES_PER_PART: u32 = 10;

/// A sample of the ground.
struct GroundSample {
    /// Direction from the camera, ICRF, of any length.
    direction: DVec3,
    /// Position in the frame, clip x and y.
    clip: DVec2,
    /// Unit-sphere frame.
    point: DVec3,
    /// Area that the sample represents, as a fraction of the frame's area.
    share: f64,
}

/// The part of a body's ground that is in the frame.
#[derive(Default)]
struct VisibleGround {
    samples: Vec<GroundSample>,
    /// About the largest angle between neighbouring samples, radians.
    spacing: f64,
}

/// The real roots of a t² + 2 b t + c, ascending; one is infinite if a = 0. `None` without two different real roots.
fn roots([a, b, c]: [f64; 3]) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, c / q);
    (discriminant > 0.0 && !first.is_nan() && !second.is_nan()).then(|| [first.min(second), first.max(second)])
}

/// View rays through a straight line of the image, `nearest + step * t`, in the unit-sphere frame.
struct ScanLine {
    /// Position of the camera.
    camera: DVec3,
    /// The ray, within the body's bounds, that passes nearest to the body's centre. `t` is 0 there, so that the equations below keep their digits for a distant
    /// body.
    nearest: DVec3,
    /// Change of the ray per unit of `t`.
    step: DVec3,
    /// Unit normal of the terminator's plane, towards the Sun.
    terminator_normal: DVec3,
}

impl ScanLine {
    /// The line of the view rays `origin + step * k`, and the `t` of the ray `origin`. `bounds`: the range of k over the body's bounds within the frame.
    fn of(camera: DVec3, origin: DVec3, step: DVec3, bounds: [f64; 2], terminator_normal: DVec3) -> (Self, f64) {
        let across = camera.cross(step);
        // The k that minimises |camera x ray|. If the camera looks along the horizon, `step` points to the body's centre, and k is infinite.
        let to_nearest = -camera.cross(origin).dot(across) / across.length_squared().max(f64::MIN_POSITIVE);
        let to_nearest = to_nearest.clamp(bounds[0], bounds[1]);
        (Self { camera, nearest: origin + step * to_nearest, step, terminator_normal }, -to_nearest)
    }

    fn ray(&self, t: f64) -> DVec3 {
        self.nearest + self.step * t
    }

    /// The coefficients `a, b, c` (see [`roots`]) of `form(ray(t), ray(t))`. `form`: symmetric and bilinear.
    fn coefficients(&self, form: impl Fn(DVec3, DVec3) -> f64) -> [f64; 3] {
        [form(self.step, self.step), form(self.nearest, self.step), form(self.nearest, self.nearest)]
    }

    /// The range of `t` inside the body's outline, which may be infinite; `None` if the line misses the body.
    fn part_on_disc(&self) -> Option<[f64; 2]> {
        // The straight line through the camera c along a ray d meets the unit sphere, in front of the camera or behind it, if |d|² >= |c x d|².
        let limb = self.coefficients(|x, y| x.dot(y) - self.camera.cross(x).dot(self.camera.cross(y)));
        let is_in_front = |t: f64| self.camera.dot(self.ray(t)) < 0.0;
        match roots(limb) {
            // The rays whose straight lines meet the sphere are between the roots: all in front of the camera, or all behind it.
            Some([from, to]) if limb[0] < 0.0 => is_in_front(0.5 * (from + to)).then_some([from, to]),
            // They are beyond the roots: beyond one root in front of the camera, beyond the other behind it. `step` shows which, as the ray of infinite t.
            Some([_, from]) if self.camera.dot(self.step) < 0.0 => Some([from, f64::INFINITY]),
            Some([to, _]) => Some([f64::NEG_INFINITY, to]),
            // Either all rays or none: all only if the camera is on the ground or in it.
            None => (limb[0] > 0.0 && is_in_front(0.0)).then_some([f64::NEG_INFINITY, f64::INFINITY]),
        }
    }

    /// Whether the ray at `t`, which must meet the ground, meets it on the lit side.
    fn is_lit(&self, t: f64) -> bool {
        let ray = self.ray(t).normalize();
        let half_chord_sq = 1.0 - self.camera.cross(ray).length_squared();
        let point = self.camera - ray * (self.camera.dot(ray) + half_chord_sq.max(0.0).sqrt());
        point.dot(self.terminator_normal) > 0.0
    }

    /// Divides, at the terminator, a range of `t` that is on the disc. The resulting ranges are alternately lit and dark.
    fn lit_and_dark_parts(&self, [start, end]: [f64; 2]) -> Vec<[f64; 2]> {
        // A ray d meets the terminator's plane, normal to s, in the point s x (c x d) / (s . d). This is a point of the terminator, visible or not, if it is on
        // the unit sphere: |s x (c x d)|² = |c x d|² - (s . (c x d))² = (s . d)².
        let terminator = self.coefficients(|x, y| {
            let (across_x, across_y) = (self.camera.cross(x), self.camera.cross(y));
            let s = self.terminator_normal;
            across_x.dot(across_y) - s.dot(across_x) * s.dot(across_y) - s.dot(x) * s.dot(y)
        });
        // If the camera is in the terminator's plane, the two roots coincide at -b / a. `roots` then gives none, as for a line that does not cross the
        // terminator, whose parts on either side of -b / a are both lit or both dark, and are joined below.
        let [a, b, _] = terminator;
        let crossings = roots(terminator).unwrap_or([if a == 0.0 { start } else { -b / a }; 2]);
        let [first, second] = crossings.map(|t| t.clamp(start, end));
        let mut parts: Vec<(bool, [f64; 2])> = Vec::with_capacity(3);
        for [from, to] in [[start, first], [first, second], [second, end]].into_iter().filter(|[from, to]| from < to) {
            let is_lit = self.is_lit(0.5 * (from + to));
            match parts.last_mut() {
                // The line crosses the terminator on the far side of the body, or not at all.
                Some((was_lit, part)) if *was_lit == is_lit => part[1] = to,
                _ => parts.push((is_lit, [from, to])),
            }
        }
        parts.into_iter().map(|(_, part)| part).collect()
    }
}

/// The part of a line of the image plane that is in the frame: its ends as distances from `origin`, not in this order if the line misses the frame. `origin`,
/// `along`: a point of the line and a unit vector, as tangents of angles from the middle of the frame. `tan_half_fov`: of the camera.
fn part_in_frame(origin: DVec2, along: DVec2, tan_half_fov: DVec2) -> [f64; 2] {
    // Along a line parallel to an edge the division gives infinities.
    let [one, other] = [-tan_half_fov, tan_half_fov].map(|edges| (edges - origin) / along);
    [one.min(other).max_element(), one.max(other).min_element()]
}

impl VisibleGround {
    /// `sun`: unit vector towards the Sun, body axes.
    fn of(camera: &Camera, placement: &Placement, sun: DVec3) -> Self {
        // The lines are parallel to the image of the plane through camera, body and Sun; if these are in one line, any direction will do.
        let normal = placement.centre_km.cross(placement.body_from_icrf.transpose() * sun);
        let along = DVec2::new(normal.dot(camera.up), -normal.dot(camera.right)).try_normalize().unwrap_or(DVec2::X);
        let across = along.perp();
        let icrf_axis = |v: DVec2| camera.right * v.x + camera.up * v.y;
        // The camera with its axes along and across the lines; its clip coordinates are tangents of angles.
        let turned = Camera { right: icrf_axis(along), up: icrf_axis(across), tan_half_fov: DVec2::ONE, ..camera.clone() };
        // Bounds of the body within the frame in the turned axes, tangents of angles.
        let frame = DVec2::new(along.abs().dot(camera.tan_half_fov), across.abs().dot(camera.tan_half_fov));
        let (mut low, mut high) = (-frame, frame);
        if let Outline::Ellipse { bounds, .. } = Outline::of(&turned, placement) {
            low = low.max(DVec2::new(bounds.left, bounds.bottom));
            high = high.min(DVec2::new(bounds.right, bounds.top));
        }
        let size = high - low;
        if !size.cmpgt(DVec2::ZERO).all() {
            return Self::default();
        }
        let terminator_normal = (sun / placement.radii_km).normalize();
        let camera_in_unit_sphere = placement.camera_in_unit_sphere();
        let line_height = size.y / f64::from(LINE_COUNT);
        let mut samples = Vec::with_capacity((2 * LINE_COUNT * SAMPLES_PER_PART) as usize);
        for line in 0..LINE_COUNT {
            let origin = across * (low.y + line_height * (f64::from(line) + 0.5));
            let view_ray = |position: DVec2| camera.ray(position / camera.tan_half_fov);
            let (scan_line, t_origin) = ScanLine::of(
                camera_in_unit_sphere,
                placement.direction_in_unit_sphere(view_ray(origin)),
                placement.direction_in_unit_sphere(turned.right),
                [low.x, high.x],
                terminator_normal,
            );
            let Some([disc_start, disc_end]) = scan_line.part_on_disc() else { continue };
            let [frame_start, frame_end] = part_in_frame(origin, along, camera.tan_half_fov).map(|t| t + t_origin);
            let (start, end) = (frame_start.max(disc_start), frame_end.min(disc_end));
            if !(start < end && start.is_finite() && end.is_finite()) {
                continue;
            }
            for [from, to] in scan_line.lit_and_dark_parts([start, end]) {
                let step = (to - from) / f64::from(SAMPLES_PER_PART);
                let frame_area = 4.0 * camera.tan_half_fov.element_product();
                let share = step * line_height / frame_area;
                samples.extend((0..SAMPLES_PER_PART).map(|k| {
                    let t = from + step * (f64::from(k) + 0.5);
                    let position = origin + along * (t - t_origin);
                    let direction = view_ray(position);
                    let point = ray_and_limb(placement, direction).point;
                    GroundSample { direction, clip: position / camera.tan_half_fov, point, share }
                }));
            }
        }
        Self { samples, spacing: DVec2::new(size.x / f64::from(SAMPLES_PER_PART), line_height).length() }
    }
}

impl MeteredFrame<'_, '_> {
    /// Adds the radiance of a body's ground, at samples of the part that the frame shows, to `mean`, each with the weight of its position; all of them with at
    /// least the weight that goes with their share of the frame ([`least_weight_of_ground`]). Returns the unhidden ground's share of the frame, times `weight`,
    /// which is a factor on all shares. `shadow`: of other bodies, if any. `transmittance`: of the air around the camera.
    pub(super) fn sum_ground(
        &self,
        p: &PlacedBody<'_>,
        ground: &Ground<'_>,
        shadow: Option<&ApproximateShadow<'_>>,
        weight: f64,
        transmittance: f64,
        mean: &mut LogMean,
    ) -> f64 {
        let visible = VisibleGround::of(self.meter.camera, &p.placement, ground.sun);
        let nearer = self.nearer_bodies(p, visible.spacing);
        let ring_shadow = self.ring_shadow_on(p);
        let twilight_air = self.twilight_air_of(p);
        let (mut covered_share, mut of_ground, mut highlights) = (0.0, LogMean::default(), Highlights::default());
        // Sums without the weights of positions, of the weights and of their squares.
        let (mut even_weight, mut even_weight_sq) = (0.0, 0.0);
        for sample in &visible.samples {
            let share = weight * sample.share * Self::ray_visibility(&nearer, sample.direction, visible.spacing);
            if share <= 0.0 {
                continue;
            }
            covered_share += share;
            let normal = (sample.point / p.placement.radii_km).normalize();
            let to_viewer = -(p.placement.body_from_icrf * sample.direction).normalize();
            let ring_transmittance = ring_shadow.as_ref().map_or(1.0, |rings| rings.transmittance(sample.point, visible.spacing));
            let of_air = twilight_air.as_ref().map_or(0.0, |air| air.radiance(normal.dot(ground.sun), normal.dot(to_viewer)));
            let foreground_radiance = self.foreground_radiance(sample.direction, p.body.id);
            let position_weight = frame_position_weight(sample.clip.abs().max_element().min(1.0));
            ground.for_each_slope([sample.point, normal, to_viewer], shadow, ring_transmittance, |part, of_surface| {
                let share = share * part;
                let radiance = of_surface.plus(ground.albedo.twilight(of_air * ground.sun_irradiance)).times(transmittance);
                of_ground.add_to_mean(share * position_weight, radiance, foreground_radiance);
                // Wherever it lies in the frame, bright ground is burnt out as soon.
                highlights.add(Part::of(share, radiance, foreground_radiance));
                let full_weight = LogMean::weight_of_full_frame(radiance.metered, foreground_radiance);
                even_weight += share * full_weight;
                even_weight_sq += share * full_weight * full_weight;
            });
        }
        mean.highlights.merge(&highlights);
        if of_ground.weight > 0.0 {
            // The share of the ground that has most of the weight: of a night side with a crescent that of the crescent, of evenly lit ground that of all.
            let bright_share = even_weight * even_weight / even_weight_sq;
            mean.merge(&of_ground.times((even_weight * least_weight_of_ground(bright_share) / of_ground.weight).max(1.0)));
        }
        covered_share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// A camera that looks `turned_deg` past the centre of a flattened body, the body, and the direction to the Sun in body axes. `distance_radii`: from the
    /// body's centre to the camera.
    fn view(distance_radii: f64, phase_deg: f64, fov_deg: f64, turned_deg: f64) -> (Camera, Placement, DVec3) {
        let body_from_icrf = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.7);
        let to_camera = DVec3::new(0.3, -0.5, 0.8).normalize();
        let (sin, cos) = phase_deg.to_radians().sin_cos();
        let sun = to_camera * cos + to_camera.any_orthonormal_vector() * sin;
        let forward = to_camera.cross(DVec3::Z).normalize() * turned_deg.to_radians().tan() - to_camera;
        let camera = Camera::looking(DVec3::ZERO, forward, DVec3::new(0.2, 0.1, 1.0), fov_deg, 160, 90);
        let placement =
            Placement { centre_km: to_camera * (-1000.0 * distance_radii), body_from_icrf, radii_km: DVec3::new(1000.0, 1000.0, 950.0) };
        (camera, placement, body_from_icrf * sun)
    }

    /// Shares of the frame of a body and of its lit part, from the samples.
    fn shares((camera, placement, sun): &(Camera, Placement, DVec3)) -> [f64; 2] {
        let visible = VisibleGround::of(camera, placement, *sun);
        let lit = visible.samples.iter().filter(|s| (s.point / placement.radii_km).dot(*sun) > 0.0);
        [visible.samples.iter().map(|s| s.share).sum(), lit.map(|s| s.share).sum()]
    }

    /// The same from `side` x `side` rays, each of which counts in full or not at all.
    fn shares_of_grid((camera, placement, sun): &(Camera, Placement, DVec3), side: u32) -> [f64; 2] {
        let mut counts = [0.0; 2];
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let clip = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * 2.0 / f64::from(side) - 1.0;
            let ray = ray_and_limb(placement, camera.ray(clip));
            if ray.inside_rad > 0.0 {
                counts[0] += 1.0;
                counts[1] += f64::from((ray.point / placement.radii_km).dot(*sun) > 0.0);
            }
        }
        counts.map(|count| count / f64::from(side * side))
    }

    /// Thin crescents near and far, in the frame and cut off by it: the share of the body is right to 0.5 %, that of its lit part to 5 %, of which up to 2 %
    /// are errors of the reference, a grid of rays.
    #[test]
    fn crescents_have_their_share_of_the_frame() {
        for (distance_radii, phase_deg, fov_deg, turned_deg) in [
            (1.9, 140.0, 60.0, 0.0),
            (2.6, 152.0, 50.0, 5.0),
            (221.0, 170.0, 0.6, 0.0),
            (221.0, 150.0, 0.45, 0.05),
            (1e6, 150.0, 1.3e-4, 1e-5),
            // Along the horizon, where every line leads to the nadir.
            (1.02, 60.0, 60.0, 90.0),
            (1.02, 60.0, 60.0, 90.0 - 1e-7),
        ] {
            let view = view(distance_radii, phase_deg, fov_deg, turned_deg);
            let (found, expected) = (shares(&view), shares_of_grid(&view, 700));
            let errors = [0, 1].map(|k| (found[k] / expected[k] - 1.0).abs());
            assert!(
                expected[1] > 0.0 && errors[0] < 0.005 && errors[1] < 0.05,
                "{distance_radii} radii, {phase_deg} degrees: {found:?}, not {expected:?}"
            );
        }
        // Negative control: a grid of 20 x 20 rays, whose spacing is wider than this crescent, gets its share wrong by more than 30 %.
        let view = view(2.6, 152.0, 50.0, 5.0);
        let [coarse, fine] = [20, 700].map(|side| shares_of_grid(&view, side)[1]);
        assert!((coarse / fine - 1.0).abs() > 0.3, "{coarse} {fine}");
    }

    /// A crescent grows out of nothing while the camera moves away, always in small steps.
    #[test]
    fn a_crescent_comes_into_view_gradually() {
        // The limb hides it up to about 1.9 radii: on a sphere up to 1 / cos(150 - 90 degrees) = 2. It is seen at distances from 1.8 to 2.3 radii.
        let lit: Vec<f64> = (0..500).map(|k| shares(&view(1.8 + 0.001 * f64::from(k), 150.0, 70.0, 0.0))[1]).collect();
        // At first hidden, at last in view; each of the 499 steps adds less than a hundredth of the final share.
        assert!(lit[0] == 0.0 && lit[499] > 2e-4, "{lit:?}");
        assert!(lit.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.01 * lit[499]), "{lit:?}");
    }

    #[test]
    fn a_body_outside_the_frame_has_no_samples() {
        assert_eq!(shares(&view(20.0, 60.0, 10.0, 60.0)), [0.0; 2]);
    }
}
